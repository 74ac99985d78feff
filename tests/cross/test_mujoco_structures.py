"""Robots as their files are: free motions, floating bases, more or fewer motors, couplings, springs.

Each against MuJoCo's own mass matrix, bias, passive forces and Jacobians, projected on the null
space of its equalities with NumPy: the projection shares nothing with ours.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import psp3
from psp3.errors import MobilityMismatch, UnreachableForces
from tests.helpers import Array, derivative
from tests.mujoco_null_space import NullSpace, biped, doubled, five_bar, gripper, rod

SPRING = 'stiffness="30" springref=".2" damping=".3"'
HALF = '<joint joint1="m2" joint2="m1" polycoef="0 -1 .5 0 .2"/>'
MIMIC = '<joint joint1="m2" joint2="m1" polycoef="0 -1 0 0 0"/>'

ROBOTS: dict[str, tuple[str, str, tuple[str, ...]]] = {
    # file, free motions, coordinates that it must have
    "rod, its spin locked": (rod(), "lock", ("crank",)),
    "doubled hinge, locked": (doubled(), "lock", ("crank",)),
    "doubled hinge, kept": (doubled(), "keep", ("crank", "pin1")),
    "biped on a floating base": (
        biped("l_hip", "l_motor", "r_hip", "r_motor"),
        "lock",
        ("l_hip", "l_motor", "r_hip", "r_motor", "root"),
    ),
    "biped with six motors": (
        biped("l_hip", "l_motor", "r_hip", "r_motor", "l_knee", "r_knee"),
        "lock",
        ("l_hip", "l_motor", "r_hip", "r_motor", "root"),
    ),
    "five-bar, three motors": (five_bar("m1", "m2", "p1"), "lock", ("m1", "m2")),
    "five-bar, four motors": (five_bar("m1", "m2", "p1", "p2"), "lock", ("m1", "m2")),
    "five-bar, a spring and a motor": (five_bar("m1", spring=SPRING), "keep", ("m1", "p1")),
    "five-bar, a quartic coupling": (five_bar("m1", more=HALF), "lock", ("m1",)),
    "five-bar, a mimic joint drives": (five_bar("m2", more=MIMIC), "lock", ("m2",)),
    "five-bar, coupled, two motors": (five_bar("m1", "p2", more=HALF), "lock", ("m1",)),
    "gripper: tendon, coupling, springs": (gripper(), "lock", ("l_driver",)),
}


def loaded(path: Path, text: str, free: str) -> psp3.ClosedLoopRobot:
    file = path / "robot.xml"
    file.write_text(text, encoding="utf-8")
    return psp3.ClosedLoopRobot.from_mjcf(file, free=free)


def random_positions(robot: psp3.ClosedLoopRobot, rng: np.random.Generator) -> Array:
    """Return positions near the reference; a floating base anywhere."""
    positions = robot.reference.copy()
    scalars = len(robot.coordinates_v) - 6 * ("root" in robot.coordinates)
    positions[:scalars] += rng.uniform(-0.1, 0.1, scalars)
    if "root" in robot.coordinates:
        positions[scalars:] = pin.SE3ToXYZQUAT(pin.SE3.Random())
    return positions


@pytest.mark.parametrize("name", list(ROBOTS))
def test_accelerations_are_those_of_mujoco_projected(name: str, tmp_path: Path) -> None:
    """Of 20 states. The bar is 1e-9: both sides solve with numbers of condition up to 1e5."""
    text, free, coordinates = ROBOTS[name]
    robot = loaded(tmp_path, text, free)
    assert robot.coordinates == coordinates
    engine, rng = NullSpace(text, robot.model), np.random.default_rng(0)
    n, m = len(robot.coordinates_v), len(robot.actuated)
    for _ in range(20):
        positions, speeds = random_positions(robot, rng), rng.uniform(-1.0, 1.0, n)
        q, v = robot.configuration(positions), robot.velocity(positions, speeds)
        forces = rng.uniform(-1.0, 1.0, m)
        held = held_rows(robot, q)
        rates = derivative(
            lambda t, q=q, v=v: held_rows(robot, pin.integrate(robot.model, q, t * v)) @ v, 1e-2
        )
        expected, gap, opening = engine.accelerations(q, v, robot.motors @ forces, held, rates)
        assert gap < 1e-11
        assert opening < 1e-11
        along = robot.actuation_matrix(positions) @ forces
        found = robot.forward_dynamics(positions, speeds, along)
        size = np.abs(expected).max()
        assert np.abs(found - expected[robot.coordinates_v]).max() < 1e-9 * size
        # The motors' forces of a motion that they can bring about.
        again = robot.actuator_forces(positions, speeds, found)
        assert np.allclose(robot.actuation_matrix(positions) @ again, along, atol=1e-9)
        assert np.linalg.norm(again) <= np.linalg.norm(forces) * (1.0 + 1e-9)
        for preload in robot.preload(positions).T:
            both = robot.motors @ (forces + preload)
            moved, _, _ = engine.accelerations(q, v, both, held, rates)
            assert np.abs(moved - expected).max() < 1e-8 * size
        M, C, G = robot.equation_of_motion(positions, speeds)
        assert np.allclose(M @ found + C @ speeds + G, along, atol=1e-9 * (1.0 + size))
        assert np.allclose(robot.inverse_dynamics(positions, speeds, found), along, atol=1e-9 * size)


def held_rows(robot: psp3.ClosedLoopRobot, q: Array) -> Array:
    """Return the rows of velocities that locks keep at zero: a joint, or the spin of a ball.

    Of a spin it is the derivative of the part along its axis of the vector of the quaternion, seen
    from where it is held: half of w n + n × u.
    """
    rows = np.zeros((len(robot.locked), robot.model.nv))
    for row, one in zip(rows, robot.locked, strict=True):
        joint = robot.model.joints[robot.model.getJointId(one.joint)]
        if one.spin is None:
            row[joint.idx_v] = 1.0
            continue
        ball = pin.Quaternion(q[joint.idx_q : joint.idx_q + 4])
        x, y, z, w = (pin.Quaternion(one.spin.quaternion).inverse() * ball).coeffs()
        axis = one.spin.axis
        row[joint.idx_v : joint.idx_v + 3] = 0.5 * (w * axis + np.cross(axis, [x, y, z]))
    return rows
