"""Pinocchio's trees as flat arrays: elements, groups, limits and rows, and what is refused."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import psp3
from psp3.errors import UnsupportedJoint
from psp3.multibody import flatten
from psp3.multibody.flatten import NO_MOTORS, flattened
from psp3.multibody.tree import (
    AT_COLUMN_OF,
    AT_ELEMENTS,
    AT_GROUPS,
    AT_JOINTS,
    AT_LIMITS,
    AT_MASSIVE,
    BALL,
    BODIES,
    DEPENDENT,
    DRIVEN,
    ELEMENT_INTEGERS,
    ELEMENTS,
    FACTORS,
    FREE,
    GROUP_DRIVERS,
    GROUP_INTEGERS,
    GROUPS,
    INDEPENDENT,
    JOINT_NUMBERS,
    KIND,
    PARENT,
    ROWS,
    SCREW,
    UNBOUNDED,
)
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.helpers import spatial_loop_of_every_joint
from tests.psp3.multibody.flat import Flat, flat_of
from tests.psp3.multibody.linkages import rockers


def test_every_kind_of_joint_becomes_its_elements() -> None:
    """Screw; ball; angle as cosine and sine; a universal joint as two screws."""
    flat = flat_of(spatial_loop_of_every_joint())
    rows = flat.tree[flat.at(AT_ELEMENTS) :][: ELEMENT_INTEGERS * flat.count(ELEMENTS)]
    rows = rows.reshape(-1, ELEMENT_INTEGERS)
    assert_array_equal(rows[:, KIND], [SCREW, BALL, UNBOUNDED, SCREW, SCREW])
    assert_array_equal(rows[:, PARENT], [-1, 0, -1, 2, 3])
    # The first screw of the universal joint moves no body.
    massive = flat.tree[flat.at(AT_MASSIVE) :][: flat.count(BODIES)]
    assert_array_equal(massive, [0, 1, 2, 4])


def test_a_free_flyer_is_one_element() -> None:
    model = pin.Model()
    model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "free")
    flat = Flat(flattened(model, [], NO_MOTORS))
    assert (flat.count(ELEMENTS), flat.count(BODIES)) == (1, 0)
    assert flat.tree[flat.at(AT_ELEMENTS) + KIND] == FREE


def test_counts_are_those_of_the_robot(parts: SimpleNamespace, flat: Flat) -> None:
    rows = sum(loop.residualSize() for loop in parts.constraint_models)
    n = len(parts.actuated)
    assert (flat.count(ROWS), flat.count(INDEPENDENT)) == (rows, n)
    # Every joint of these robots is in its one loop.
    assert flat.count(DEPENDENT) == parts.model.nv - n
    assert flat.count(FACTORS) == rows * (parts.model.nv - n)
    assert flat.count(DRIVEN) == rows * n
    columns = flat.tree[flat.at(AT_COLUMN_OF) :][: parts.model.nv]
    assert sorted(columns) == list(range(-n, parts.model.nv - n))


def test_inertia_of_motors_and_limits_are_the_models(parts: SimpleNamespace) -> None:
    """Limits of joints that a motor drives are the business of others."""
    flat, model = flat_of(parts), parts.model
    joints = flat.numbers[flat.at(AT_JOINTS) :][: JOINT_NUMBERS * model.nv].reshape(
        -1, JOINT_NUMBERS
    )
    assert_array_equal(joints[:, 0], model.armature)
    assert_array_equal(joints[:, 1:], np.zeros((model.nv, JOINT_NUMBERS - 1)))
    limits = flat.numbers[flat.at(AT_LIMITS) :][: 2 * model.nq].reshape(-1, 2)
    for name, joint in zip(list(model.names)[1:], list(model.joints)[1:], strict=True):
        own = limits[joint.idx_q : joint.idx_q + joint.nq]
        if joint.nq == 1 and name not in parts.actuated:
            assert own[0, 0] == model.lowerPositionLimit[joint.idx_q]
            assert own[0, 1] == model.upperPositionLimit[joint.idx_q]
        else:
            assert_array_equal(own, np.tile([-np.inf, np.inf], (joint.nq, 1)))


# Groups


def test_loops_that_share_no_dependent_joint_are_groups_of_their_own() -> None:
    """Two rockers on one crank: two groups if it is a motor, and both are driven by it."""
    model, loops, _ = rockers(2)
    flat = Flat(flattened(model, loops, np.zeros(1, dtype=np.int64)))
    assert flat.count(GROUPS) == 2
    groups = flat.tree[flat.at(AT_GROUPS) :][: 2 * GROUP_INTEGERS].reshape(2, -1)
    assert_array_equal(groups[:, GROUP_DRIVERS], [1, 1])
    assert Flat(flattened(model, loops, NO_MOTORS)).count(GROUPS) == 1
    assert flat.flat.closure_rows == [3, 3]


def test_two_rockers_move_as_each_alone_even_on_one_motor() -> None:
    """The same configurations, 1e-12."""
    alone, both = (
        ClosedLoopRobot(*rockers(count)[:2], ("crank",), rockers(count)[2]) for count in (1, 2)
    )
    angles = np.linspace(0.0, 5.0, 30)[:, np.newaxis] + alone.reference
    for rocker in (0, 1):
        assert_allclose(
            both.configuration(angles)[:, [0, 1 + rocker, 3 + rocker]],
            alone.configuration(angles),
            rtol=0.0,
            atol=1e-12,
        )


def test_a_loop_that_joins_two_groups_makes_one_of_them() -> None:
    model, loops, _ = rockers(3)
    end = pin.SE3(np.eye(3), np.array([0.2, 0.0, 0.0]))
    # From the first coupler to the third.
    loops.append(
        pin.RigidConstraintModel(
            pin.ContactType.CONTACT_3D, model, 2, end, 4, end, pin.ReferenceFrame.LOCAL
        )
    )
    flat = Flat(flattened(model, loops, np.zeros(1, dtype=np.int64)))
    assert flat.count(GROUPS) == 2
    assert sorted(flat.flat.closure_rows) == [3, 3, 3, 3]


def test_the_order_of_loops_and_joints_changes_nothing() -> None:
    """Loops named in another order, and the delta's legs: M, C and G to 1e-11, relative."""
    robot = psp3.load("delta")
    turned = ClosedLoopRobot(
        robot.model, list(robot.constraint_models)[::-1], robot.actuated, robot.q0
    )
    rng = np.random.default_rng(91)
    x, v = robot.reference + rng.uniform(-0.1, 0.1, (5, 3)), rng.normal(size=(5, 3))
    for one, other in zip(
        robot.equation_of_motion(x, v), turned.equation_of_motion(x, v), strict=True
    ):
        assert_allclose(one, other, rtol=0.0, atol=1e-11 * np.abs(one).max())


def test_reflections_fill_no_row_below_the_ends() -> None:
    """Of random patterns of zeros: what NumPy's own reflections touch lies above them."""
    rng = np.random.default_rng(92)
    for _ in range(50):
        rows, columns = 8, 5
        pattern = rng.uniform(size=(rows, columns)) < 0.4
        ends = flatten._ends(rows, columns, {(int(i), int(k)) for i, k in np.argwhere(pattern)})
        matrix = np.where(pattern, rng.normal(size=pattern.shape), 0.0)
        for k in range(columns):
            assert not matrix[ends[k] :, k].any()
            column = matrix[k:, k].copy()
            column[0] += np.copysign(np.linalg.norm(column), column[0])
            if column.any():
                column /= np.linalg.norm(column)
                matrix[k:, k:] -= 2.0 * np.outer(column, column @ matrix[k:, k:])
                matrix[k + 1 :, k] = 0.0
                # Rounding is no entry.
                matrix[np.abs(matrix) < 1e-14] = 0.0


# What is refused


def ball_with_a_hinge() -> pin.JointModelComposite:
    composite = pin.JointModelComposite()
    composite.addJoint(pin.JointModelSpherical())
    composite.addJoint(pin.JointModelRX())
    return composite


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        (ball_with_a_hinge, "JointModelComposite"),
    ],
)
def test_joints_that_are_not_understood_are_named(kind: type, name: str) -> None:
    model = pin.Model()
    model.addJoint(0, kind(), pin.SE3.Identity(), "glide")
    with pytest.raises(UnsupportedJoint, match="glide") as caught:
        flattened(model, [], NO_MOTORS)
    assert caught.value.kind == name
