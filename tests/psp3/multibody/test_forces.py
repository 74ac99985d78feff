"""Velocities, accelerations and forces of closed poses, against Pinocchio and NumPy."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.testing import assert_allclose

from psp3.dynamics.projected import ProjectedDynamics
from psp3.multibody import flatten
from psp3.multibody.bodies import weigh
from psp3.multibody.forces import (
    add_change,
    carried,
    change_of_joint_speeds,
    independent_speeds,
    joint_forces,
    joint_speeds,
    projected,
    twists,
)
from psp3.multibody.tree import (
    AT_ACCELERATIONS,
    AT_FIELDS,
    AT_JOINT_ACCELERATIONS,
    AT_JOINT_FORCES,
    AT_JOINT_SPEEDS,
    AT_JOINTS,
    AT_RESTS,
    AT_ROOM,
    AT_VELOCITIES,
    ELEMENTS,
    JOINT_NUMBERS,
)
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.helpers import Array, derivative
from tests.psp3.multibody.flat import Flat, dense_complement, independent_of, pinocchios_jacobian


def moving(flat: Flat, speeds: Array) -> Array:
    """Give the pose independent speeds; return those of all joints."""
    room = flat.at(AT_ROOM)
    flat.part(AT_ROOM, flat.n)[:] = speeds
    joint_speeds(flat.tree, flat.memory, room, flat.at(AT_JOINT_SPEEDS))
    z, X = flat.at(AT_JOINT_SPEEDS), flat.at(AT_VELOCITIES)
    carried(flat.tree, flat.memory, z, X, flat.at(AT_ACCELERATIONS))
    return flat.part(AT_JOINT_SPEEDS, flat.nv).copy()


def accelerating(flat: Flat, accelerations: Array) -> Array:
    """Give the moving pose independent accelerations; return those of all joints."""
    change, rate = flat.at(AT_JOINT_ACCELERATIONS), flat.at(AT_ACCELERATIONS)
    flat.part(AT_ROOM, flat.n)[:] = accelerations
    independent_speeds(flat.tree, flat.memory, flat.at(AT_ROOM), change)
    change_of_joint_speeds(
        *flat.all, flat.at(AT_JOINT_SPEEDS), flat.at(AT_VELOCITIES), rate, change
    )
    add_change(flat.tree, flat.memory, change, rate)
    return flat.part(AT_JOINT_ACCELERATIONS, flat.nv).copy()


def test_independent_speeds_are_put_where_they_belong(parts: SimpleNamespace, flat: Flat) -> None:
    speeds = flat.part(AT_ROOM, flat.n)
    speeds[:] = 1.0 + np.arange(flat.n)
    independent_speeds(flat.tree, flat.memory, flat.at(AT_ROOM), flat.at(AT_JOINT_SPEEDS))
    expected = np.zeros(flat.nv)
    expected[independent_of(parts)] = speeds
    assert (flat.part(AT_JOINT_SPEEDS, flat.nv) == expected).all()


def test_joint_speeds_are_those_of_the_dense_complement(
    parts: SimpleNamespace, flat: Flat, pose: Array
) -> None:
    """By NumPy's pseudo-inverse of Pinocchio's Jacobian, which they keep closed; 1e-12."""
    flat.close(pose)
    speeds = np.random.default_rng(61).normal(size=flat.n)
    v = moving(flat, speeds)
    assert_allclose(v, dense_complement(parts, pose) @ speeds, rtol=0.0, atol=1e-12)
    assert np.abs(pinocchios_jacobian(parts, pose) @ v).max() < 1e-12


def test_twists_are_pinocchios_in_the_base(
    parts: SimpleNamespace, flat: Flat, anywhere: Array
) -> None:
    """Of any joint velocities, with and without how they change; 1e-13."""
    flat.place(anywhere)
    v = np.random.default_rng(62).normal(size=flat.nv)
    flat.part(AT_JOINT_SPEEDS, flat.nv)[:] = v
    z, X = flat.at(AT_JOINT_SPEEDS), flat.at(AT_VELOCITIES)
    data, count = parts.model.createData(), flat.count(ELEMENTS)
    pin.forwardKinematics(parts.model, data, anywhere, v)
    _, of_joint = flatten._elements(parts.model)
    twists(flat.tree, flat.memory, z, X)
    found = flat.part(AT_VELOCITIES, count + 1, 6).copy()
    assert (found[count] == 0.0).all()
    for joint in range(1, parts.model.njoints):
        world = pin.getVelocity(parts.model, data, joint, pin.ReferenceFrame.WORLD)
        expected = flat.seen_from.actInv(world).vector
        assert_allclose(found[of_joint[joint]], expected, rtol=0.0, atol=1e-13)
    flat.part(AT_VELOCITIES, count + 1, 6)[:] = np.nan
    carried(flat.tree, flat.memory, z, X, flat.at(AT_ACCELERATIONS))
    assert_allclose(flat.part(AT_VELOCITIES, count + 1, 6), found, rtol=0.0, atol=1e-14)


def test_how_twists_change_is_pinocchios_acceleration_without_joint_accelerations(
    parts: SimpleNamespace, flat: Flat, anywhere: Array
) -> None:
    """In the base; of chains of several elements Pinocchio knows the last. 1e-12."""
    flat.place(anywhere)
    v = np.random.default_rng(63).normal(size=flat.nv)
    flat.part(AT_JOINT_SPEEDS, flat.nv)[:] = v
    z, X = flat.at(AT_JOINT_SPEEDS), flat.at(AT_VELOCITIES)
    carried(flat.tree, flat.memory, z, X, flat.at(AT_ACCELERATIONS))
    data = parts.model.createData()
    pin.forwardKinematics(parts.model, data, anywhere, v, np.zeros(flat.nv))
    _, of_joint = flatten._elements(parts.model)
    rates = flat.part(AT_ACCELERATIONS, flat.count(ELEMENTS) + 1, 6)
    for joint in range(1, parts.model.njoints):
        world = pin.getAcceleration(parts.model, data, joint, pin.ReferenceFrame.WORLD)
        expected = flat.seen_from.actInv(world).vector
        assert_allclose(rates[of_joint[joint]], expected, rtol=0.0, atol=1e-12)


def test_how_twists_of_other_speeds_change_while_the_elements_move(
    parts: SimpleNamespace, flat: Flat, anywhere: Array
) -> None:
    """By differences of twists along the motion, seen from one point; 1e-9."""
    rng = np.random.default_rng(64)
    v, other = rng.normal(size=(2, flat.nv))
    wide = flat.count(ELEMENTS) + 1
    z, X, rate = flat.at(AT_JOINT_SPEEDS), flat.at(AT_FIELDS), flat.at(AT_ACCELERATIONS)

    flat.place(anywhere)
    start = flat.seen_from

    def twists_at(q: Array) -> Array:
        flat.place(q)
        flat.part(AT_JOINT_SPEEDS, flat.nv)[:] = other
        twists(flat.tree, flat.memory, z, X)
        moved = start.actInv(flat.seen_from)
        return np.array([moved.act(pin.Motion(row)) for row in flat.part(AT_FIELDS, wide, 6)])

    expected = derivative(lambda t: twists_at(pin.integrate(parts.model, anywhere, t * v)), 1e-2)
    flat.place(anywhere)
    flat.part(AT_JOINT_SPEEDS, flat.nv)[:] = v
    twists(flat.tree, flat.memory, z, flat.at(AT_VELOCITIES))
    flat.part(AT_JOINT_SPEEDS, flat.nv)[:] = other
    carried(flat.tree, flat.memory, z, X, rate)
    assert_allclose(flat.part(AT_ACCELERATIONS, wide, 6), expected, rtol=0.0, atol=1e-9)


def test_joint_accelerations_keep_the_loops_closed(
    parts: SimpleNamespace, robot: ClosedLoopRobot, flat: Flat, pose: Array
) -> None:
    """Those of Pinocchio's ``constraintDynamics``, from their independent ones; 1e-8."""
    flat.close(pose)
    rng = np.random.default_rng(65)
    v = moving(flat, rng.normal(size=flat.n))
    theirs = ProjectedDynamics(robot).constrained_accelerations(pose, v, rng.normal(size=flat.n))
    found = accelerating(flat, theirs[independent_of(parts)])
    assert_allclose(found, theirs, rtol=0.0, atol=1e-8)


def test_joint_forces_are_pinocchios_with_springs_and_damping(
    parts: SimpleNamespace, flat: Flat, pose: Array
) -> None:
    """RNEA, in which the motors' inertia is; springs and damping by hand. 1e-12."""
    flat.close(pose)
    rng = np.random.default_rng(66)
    joints = flat.numbers[flat.at(AT_JOINTS) :][: JOINT_NUMBERS * flat.nv].reshape(
        -1, JOINT_NUMBERS
    )
    joints[:, 1] = rng.uniform(size=flat.nv)
    rests = flat.numbers[flat.at(AT_RESTS) :][: parts.model.nq]
    springs = np.zeros(flat.nv)
    for joint in list(parts.model.joints)[1:]:
        # Springs are of joints with a coordinate for each freedom.
        if joint.nq == joint.nv:
            for k in range(joint.nv):
                joints[joint.idx_v + k, 2] = stiffness = rng.uniform(1.0, 2.0)
                rests[joint.idx_q + k] = rest = rng.normal()
                springs[joint.idx_v + k] = stiffness * (pose[joint.idx_q + k] - rest)
    weigh(*flat.all)
    v = moving(flat, rng.normal(size=flat.n))
    a = accelerating(flat, rng.normal(size=flat.n))
    joint_forces(*flat.all)
    found = flat.part(AT_JOINT_FORCES, flat.nv).copy()
    expected = pin.rnea(parts.model, parts.model.createData(), pose, v, a)
    expected += joints[:, 1] * v + springs
    assert_allclose(found, expected, rtol=0.0, atol=1e-12 * max(1.0, np.abs(expected).max()))


def test_projection_is_the_product_with_the_complement(
    parts: SimpleNamespace, flat: Flat, pose: Array
) -> None:
    """Lᵀ f, by NumPy; 1e-12."""
    flat.close(pose)
    forces = flat.part(AT_JOINT_FORCES, flat.nv)
    forces[:] = np.random.default_rng(67).normal(size=flat.nv)
    projected(flat.tree, flat.memory, flat.at(AT_JOINT_FORCES), flat.at(AT_ROOM))
    expected = dense_complement(parts, pose).T @ forces
    assert_allclose(flat.part(AT_ROOM, flat.n), expected, rtol=0.0, atol=1e-12)


def test_power_of_joint_forces_is_that_of_projected_ones(flat: Flat, pose: Array) -> None:
    """For any forces: f · L s = Lᵀ f · s, to rounding."""
    flat.close(pose)
    rng = np.random.default_rng(68)
    speeds: Any = rng.normal(size=flat.n)
    v = moving(flat, speeds)
    forces = flat.part(AT_JOINT_FORCES, flat.nv)
    forces[:] = rng.normal(size=flat.nv)
    projected(flat.tree, flat.memory, flat.at(AT_JOINT_FORCES), flat.at(AT_ROOM))
    assert_allclose(flat.part(AT_ROOM, flat.n) @ speeds, forces @ v, rtol=0.0, atol=1e-13)
