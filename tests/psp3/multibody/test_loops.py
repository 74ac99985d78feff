"""Closure equations of every kind: residual, Jacobian and what velocities accelerate.

Against Pinocchio's placements, NumPy's polynomials and differences.
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.polynomial import Polynomial
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from psp3.multibody.equations import Coupling, Spin
from psp3.multibody.flatten import NO_MOTORS, flattened
from psp3.multibody.forces import carried
from psp3.multibody.loops import accelerated, jacobian, residual_of
from psp3.multibody.tree import (
    AT_ACCELERATIONS,
    AT_DEPENDENT_V,
    AT_DRIVEN,
    AT_FACTORS,
    AT_GROUPS,
    AT_INDEPENDENT_V,
    AT_JOINT_SPEEDS,
    AT_RESIDUAL,
    AT_RIGHT,
    AT_VELOCITIES,
    DEPENDENT,
    FRAME,
    GROUP_COLUMNS,
    GROUP_DRIVERS,
    GROUP_ROWS,
    HINGE,
    POINT,
    ROWS,
)
from tests.helpers import Array, derivative, four_bar_closed_with_6d
from tests.psp3.multibody.flat import Flat, flat_of, flat_with, pinocchios_jacobian

KINDS = {"point": POINT, "hinge": HINGE, "frame": FRAME}
QUARTIC = [0.1, -0.3, 0.25, 0.4, -0.2]


def two_arms(kind: int) -> tuple[pin.Model, Flat, Array]:
    """Return two arms of many freedoms whose ends a closure joins, and a closed configuration."""
    rng, model = np.random.default_rng(41), pin.Model()

    def placement() -> pin.SE3:
        return pin.SE3(pin.exp3(rng.normal(size=3)), 0.4 * rng.normal(size=3))

    ends = []
    for arm in (
        [pin.JointModelRX(), pin.JointModelSpherical(), pin.JointModelPY()],
        [pin.JointModelRUBZ(), pin.JointModelFreeFlyer()],
    ):
        joint = 0
        for model_of in arm:
            joint = model.addJoint(joint, model_of, placement(), f"j{model.njoints}")
        ends.append(joint)
    q: Array = pin.integrate(model, pin.neutral(model), rng.uniform(-0.5, 0.5, model.nv))
    data, first = model.createData(), placement()
    pin.forwardKinematics(model, data, q)
    # A hinge's other frame may be turned about their common axis.
    turned = pin.SE3(pin.utils.rotate("z", 0.7 if kind == HINGE else 0.0), np.zeros(3))
    second = data.oMi[ends[1]].actInv(data.oMi[ends[0]] * first * turned)
    loop = pin.RigidConstraintModel(
        pin.ContactType.CONTACT_6D,
        model,
        ends[0],
        first,
        ends[1],
        second,
        pin.ReferenceFrame.LOCAL,
    )
    return model, flat_with(model, [(loop, kind)], [0]), q


def residual(flat: Flat, q: Array) -> Array:
    flat.place(q)
    residual_of(*flat.all, 0)
    return flat.part(AT_RESIDUAL, flat.count(ROWS)).copy()


def whole_jacobian(flat: Flat, q: Array) -> Array:
    """Return the derivative of the first group's residual by all velocities, (m, nv)."""
    residual(flat, q)
    jacobian(*flat.all, 0)
    g = flat.at(AT_GROUPS)
    rows, columns = flat.tree[g + GROUP_ROWS], flat.tree[g + GROUP_COLUMNS]
    found = np.zeros((rows, flat.nv))
    dependent = flat.tree[flat.at(AT_DEPENDENT_V) :][: flat.count(DEPENDENT)]
    found[:, dependent] = flat.part(AT_FACTORS, columns, rows).T
    drivers = flat.tree[g + GROUP_DRIVERS]
    if drivers:
        independent = flat.tree[flat.at(AT_INDEPENDENT_V) :][: flat.n]
        found[:, independent] = flat.part(AT_DRIVEN, drivers, rows).T
    return found


def by_differences(model: pin.Model, flat: Flat, q: Array) -> Array:
    return np.column_stack(
        [
            derivative(lambda t, u=unit: residual(flat, pin.integrate(model, q, t * u)), 1e-2)
            for unit in np.eye(model.nv)
        ]
    )


# Residual


def test_residual_is_position_and_rotation_vector_of_the_second_frame_in_the_first(
    parts: SimpleNamespace, anywhere: Array
) -> None:
    """From Pinocchio's placements and SciPy's rotation vectors, where loops are open; 1e-14."""
    flat = Flat(flattened(parts.model, parts.constraint_models, NO_MOTORS))
    data, rng = parts.model.createData(), np.random.default_rng(0)
    for _ in range(10):
        q = pin.integrate(parts.model, anywhere, rng.uniform(-0.3, 0.3, parts.model.nv))
        pin.forwardKinematics(parts.model, data, q)
        expected = []
        for loop in parts.constraint_models:
            relative = (data.oMi[loop.joint1_id] * loop.joint1_placement).actInv(
                data.oMi[loop.joint2_id] * loop.joint2_placement
            )
            expected.append(relative.translation)
            if loop.type == pin.ContactType.CONTACT_6D:
                expected.append(Rotation.from_matrix(relative.rotation).as_rotvec())
        found = residual(flat, q)
        assert_allclose(found, np.concatenate(expected), rtol=0.0, atol=1e-14)
        assert residual_of(*flat.all, 0) == np.abs(found).max()


def test_residual_of_a_hinge_is_what_two_axes_miss() -> None:
    """Position and the first two entries of the second z axis, in the first frame; 1e-14."""
    model, flat, q0 = two_arms(HINGE)
    data, rng = model.createData(), np.random.default_rng(1)
    assert_allclose(residual(flat, q0), np.zeros(5), rtol=0.0, atol=1e-14)
    _, frame, _ = two_arms(FRAME)
    for _ in range(10):
        q = pin.integrate(model, q0, rng.uniform(-0.5, 0.5, model.nv))
        pin.forwardKinematics(model, data, q)
        found = residual(flat, q)
        assert_allclose(found[:3], residual(frame, q)[:3], rtol=0.0, atol=1e-14)
        # The frame's second end is the hinge's without its turn about z, which moves no z axis.
        turn = Rotation.from_rotvec(residual(frame, q)[3:]).as_matrix()
        assert_allclose(found[3:], turn[:2, 2], rtol=0.0, atol=1e-14)


def test_residual_of_a_coupling_is_what_the_polynomial_misses() -> None:
    model = pin.Model()
    for name in ("x", "y"):
        model.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), name)
    flat = flat_with(model, [Coupling("", 2, 1, tuple(QUARTIC))], [0])
    for x, y in np.random.default_rng(2).uniform(-2.0, 2.0, (10, 2)):
        expected = y - Polynomial(QUARTIC)(x)
        assert_allclose(residual(flat, np.array([x, y])), [expected], rtol=0.0, atol=1e-14)
        slopes = [-Polynomial(QUARTIC).deriv()(x), 1.0]
        assert_allclose(whole_jacobian(flat, np.array([x, y]))[0], slopes, rtol=0.0, atol=1e-14)


@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 1e-12, 1e-9, 1e-7, 1e-5, 1e-3]))
def test_rotation_residual_near_half_a_turn(seed: int, off: float) -> None:
    """Where the sine vanishes the axis must still be found.

    5e-7: within 1e-7 of half a turn either direction of the axis is taken, and the angle is known
    to the root of rounding only.
    """
    model = pin.Model()
    model.addJoint(0, pin.JointModelSpherical(), pin.SE3.Identity(), "ball")
    loop = pin.RigidConstraintModel(
        pin.ContactType.CONTACT_6D,
        model,
        0,
        pin.SE3.Identity(),
        1,
        pin.SE3.Identity(),
        pin.ReferenceFrame.LOCAL,
    )
    flat = Flat(flattened(model, [loop], NO_MOTORS))
    axis = np.random.default_rng(seed).normal(size=3)
    turn = Rotation.from_rotvec((np.pi - off) * axis / np.linalg.norm(axis))
    found = residual(flat, turn.as_quat())[3:]
    assert (Rotation.from_rotvec(found) * turn.inv()).magnitude() < 5e-7


def test_a_residual_that_is_not_finite_counts_as_large(parts: SimpleNamespace) -> None:
    flat = flat_of(parts)
    flat.place(np.full(parts.model.nq, np.nan))
    assert not residual_of(*flat.all, 0) < np.inf


def held_ball() -> tuple[pin.Model, Flat, Spin]:
    """Return a ball on an arm that does not turn about an oblique axis of what it carries."""
    model, rng = pin.Model(), np.random.default_rng(6)
    model.addJoint(0, pin.JointModelRX(), pin.SE3.Identity(), "arm")
    model.addJoint(1, pin.JointModelSpherical(), pin.SE3.Random(), "ball")
    held = pin.Quaternion(pin.exp3(rng.normal(size=3))).coeffs()
    spin = Spin("", 2, np.array([0.6, 0.0, 0.8]), held)
    return model, Flat(flattened(model, [spin], NO_MOTORS)), spin


def test_a_spin_is_the_part_along_its_axis_of_the_turn_since() -> None:
    """Zero where it is held, and sin(angle / 2) after a turn about the axis itself; 1e-14."""
    _, flat, spin = held_ball()
    held = pin.Quaternion(spin.quaternion)
    for angle in (0.0, 0.3, -2.0):
        turned = held * pin.Quaternion(pin.exp3(angle * spin.axis))
        q = np.concatenate([[0.4], turned.coeffs()])
        assert_allclose(residual(flat, q), [np.sin(0.5 * angle)], rtol=0.0, atol=1e-14)


def test_slope_and_drift_of_a_spin_are_its_derivatives() -> None:
    """By differences of the residual, and of the slope along a motion; 1e-9."""
    model, flat, _ = held_ball()
    rng = np.random.default_rng(7)
    for _ in range(5):
        q = pin.randomConfiguration(model, np.full(5, -1.0), np.full(5, 1.0))
        assert_allclose(
            whole_jacobian(flat, q), by_differences(model, flat, q), rtol=0.0, atol=1e-9
        )
        v = rng.normal(size=4)
        expected = derivative(
            lambda t, q=q, v=v: whole_jacobian(flat, pin.integrate(model, q, t * v)) @ v, 1e-2
        )
        assert_allclose(rate_of_jacobian(flat, q, v), expected, rtol=0.0, atol=1e-9)


def test_a_joint_that_is_coupled_to_itself_is_held() -> None:
    model = pin.Model()
    for name in ("x", "y"):
        model.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), name)
    flat = flat_with(model, [Coupling("", 2, 2, (0.3,))], [0])
    q = np.array([0.1, 0.7])
    assert_allclose(residual(flat, q), [0.4], rtol=0.0, atol=1e-15)
    assert_allclose(whole_jacobian(flat, q), [[0.0, 1.0]], rtol=0.0, atol=0.0)


# Jacobian


def test_jacobian_is_the_derivative_of_the_residual_away_from_closure(
    parts: SimpleNamespace, anywhere: Array
) -> None:
    """1e-9: eighth-order differences with steps of 1e-2 are that good.

    Pinocchio's own Jacobian is not this derivative here.
    """
    flat = flat_of(parts)
    expected = by_differences(parts.model, flat, anywhere)
    assert_allclose(whole_jacobian(flat, anywhere), expected, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_jacobian_of_every_kind_between_every_kind_of_joint(kind: str) -> None:
    """1e-9, by differences as above."""
    model, flat, q0 = two_arms(KINDS[kind])
    step = np.random.default_rng(3).uniform(-0.4, 0.4, model.nv)
    for q in (q0, pin.integrate(model, q0, step)):
        expected = by_differences(model, flat, q)
        assert_allclose(whole_jacobian(flat, q), expected, rtol=0.0, atol=1e-9)


def test_jacobian_is_pinocchios_where_the_loops_are_closed(
    parts: SimpleNamespace, pose: Array
) -> None:
    """Minus Pinocchio's, whose rows are in other axes and places: they span the same. 1e-10."""
    ours, theirs = whole_jacobian(flat_of(parts), pose), pinocchios_jacobian(parts, pose)
    spanned = theirs.T @ np.linalg.lstsq(theirs.T, ours.T, rcond=1e-10)[0]
    assert_allclose(spanned, ours.T, rtol=0.0, atol=1e-10)
    assert np.linalg.matrix_rank(ours, 1e-10) == np.linalg.matrix_rank(theirs, 1e-10)


# What velocities accelerate


def rate_of_jacobian(flat: Flat, q: Array, v: Array) -> Array:
    """Return the rate of J v along the motion, by the kernel, (m,)."""
    residual(flat, q)
    flat.part(AT_JOINT_SPEEDS, flat.nv)[:] = v
    z, X = flat.at(AT_JOINT_SPEEDS), flat.at(AT_VELOCITIES)
    carried(flat.tree, flat.memory, z, X, flat.at(AT_ACCELERATIONS))
    accelerated(*flat.all, 0, z, X, flat.at(AT_ACCELERATIONS))
    return flat.part(AT_RIGHT, flat.count(ROWS)).copy()


def motion_in_the_loops(flat: Flat, q: Array, rng: np.random.Generator) -> Array:
    """Return random velocities that keep the loops closed."""
    _, values, right = np.linalg.svd(whole_jacobian(flat, q))
    free = right[np.count_nonzero(values > 1e-9 * values[0]) :]
    assert len(free)
    return np.asarray(rng.normal(size=len(free)) @ free)


@pytest.mark.parametrize("kind", KINDS)
def test_what_velocities_accelerate_is_the_second_derivative_of_the_residual(kind: str) -> None:
    """Of the motion with constant joint velocities, where the loops are closed; 1e-8.

    By differences of the Jacobian, itself compared above.
    """
    model, flat, q = two_arms(KINDS[kind])
    rng = np.random.default_rng(4)
    for _ in range(5):
        v = motion_in_the_loops(flat, q, rng)
        found = rate_of_jacobian(flat, q, v)
        expected = derivative(
            lambda t, v=v: whole_jacobian(flat, pin.integrate(model, q, t * v)) @ v, 1e-2
        )
        assert_allclose(found, expected, rtol=0.0, atol=1e-8)


def test_what_velocities_accelerate_in_robots(parts: SimpleNamespace, pose: Array) -> None:
    """As above, through every kind of joint and with redundant equations; 1e-8."""
    flat, rng = flat_of(parts), np.random.default_rng(5)
    v = motion_in_the_loops(flat, pose, rng)
    found = rate_of_jacobian(flat, pose, v)
    expected = derivative(
        lambda t: whole_jacobian(flat, pin.integrate(parts.model, pose, t * v)) @ v, 1e-2
    )
    assert_allclose(found, expected, rtol=0.0, atol=1e-8)


def test_what_a_velocity_accelerates_of_a_coupling() -> None:
    """−p''(x) ẋ², by NumPy's polynomials; 1e-13."""
    model = pin.Model()
    for name in ("x", "y"):
        model.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), name)
    flat = flat_with(model, [Coupling("", 2, 1, tuple(QUARTIC))], [0])
    x, speed = 0.7, -1.3
    slope = Polynomial(QUARTIC).deriv()(x)
    found = rate_of_jacobian(flat, np.array([x, 0.4]), np.array([speed, slope * speed]))
    expected = -Polynomial(QUARTIC).deriv(2)(x) * speed**2
    assert_allclose(found, [expected], rtol=0.0, atol=1e-13)


def test_a_hinge_leaves_the_linkage_the_freedom_of_a_frame_and_a_joint() -> None:
    """A planar linkage closed by a hinge, or by a frame behind a joint, moves alike; 1e-12."""
    whole = four_bar_closed_with_6d()
    loop = whole.constraint_models[0]
    data = whole.model.createData()
    pin.forwardKinematics(whole.model, data, whole.q0)
    # Without the last joint, whose axis the hinge is.
    model, axis = pin.Model(), data.oMi[4]
    for joint in range(1, 4):
        parent = int(whole.model.parents[joint])
        placement = whole.model.jointPlacements[joint]
        model.addJoint(parent, pin.JointModelRZ(), placement, f"j{joint}")
    hinge = pin.RigidConstraintModel(
        pin.ContactType.CONTACT_6D,
        model,
        2,
        data.oMi[2].actInv(axis),
        3,
        data.oMi[3].actInv(axis),
        pin.ReferenceFrame.LOCAL,
    )
    assert (loop.joint1_id, loop.joint2_id) == (2, 4)
    flat = flat_with(model, [(hinge, HINGE)], [0])
    q = whole.q0[:3]
    _, values, right = np.linalg.svd(whole_jacobian(flat, q))
    assert np.count_nonzero(values > 1e-9) == 2
    _, theirs, motions = np.linalg.svd(whole_jacobian(flat_of(whole), whole.q0))
    assert np.count_nonzero(theirs > 1e-9) == 3
    ours, expected = right[2] / right[2, 0], motions[3, :3] / motions[3, 0]
    assert_allclose(ours, expected, rtol=0.0, atol=1e-12)
