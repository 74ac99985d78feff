"""Robots as their files are: free motions, floating bases, any count of motors, couplings, springs.

Each against MuJoCo's own mass matrix, bias, passive forces and Jacobians, projected on the null
space of its equalities with NumPy: the projection shares nothing with ours.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import psp3
from psp3.errors import (
    DependentCoordinates,
    InvalidValue,
    MobilityMismatch,
    UnknownName,
    UnreachableForces,
)
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


def random_states(
    robot: psp3.ClosedLoopRobot, rng: np.random.Generator, count: int
) -> tuple[Array, Array]:
    """Return states near the reference, a floating base anywhere: (count, p) and (count, n)."""
    n = len(robot.coordinates_v)
    positions = np.tile(robot.reference, (count, 1))
    scalars = n - 6 * ("root" in robot.coordinates)
    positions[:, :scalars] += rng.uniform(-0.1, 0.1, (count, scalars))
    if "root" in robot.coordinates:
        positions[:, scalars : scalars + 3] = rng.uniform(-1.0, 1.0, (count, 3))
        turns = rng.normal(size=(count, 4))
        positions[:, scalars + 3 :] = turns / np.linalg.norm(turns, axis=1, keepdims=True)
    return positions, rng.uniform(-1.0, 1.0, (count, n))


@pytest.mark.parametrize("name", list(ROBOTS))
def test_accelerations_are_those_of_mujoco_projected(name: str, tmp_path: Path) -> None:
    """Of 500 states to 1e-8: both sides solve with numbers of condition up to 1e5."""
    text, free, coordinates = ROBOTS[name]
    robot = loaded(tmp_path, text, free)
    assert robot.coordinates == coordinates
    engine, rng = NullSpace(text, robot.model), np.random.default_rng(0)
    positions, speeds = random_states(robot, rng, 500)
    forces = rng.uniform(-1.0, 1.0, (500, len(robot.actuated)))
    along = np.einsum("knm,km->kn", robot.actuation_matrix(positions), forces)
    found = robot.forward_dynamics(positions, speeds, along)
    configurations, velocities = robot.configuration(positions), robot.velocity(positions, speeds)
    for q, v, force, ours in zip(configurations, velocities, forces, found, strict=True):
        held, rates = held_rows(robot, q), np.zeros(0)
        if len(held):
            rates = derivative(
                lambda t, q=q, v=v: held_rows(robot, pin.integrate(robot.model, q, t * v)) @ v, 1e-2
            )
        expected, gap, opening = engine.accelerations(q, v, robot.motors @ force, held, rates)
        assert gap < 1e-11
        assert opening < 1e-11
        size = np.abs(expected).max()
        assert np.abs(ours - expected[robot.coordinates_v]).max() < 1e-8 * size


@pytest.mark.parametrize("name", list(ROBOTS))
def test_forces_and_accelerations_belong_together(name: str, tmp_path: Path) -> None:
    """Of 500 states to 1e-10 of the largest number of each: what one makes the other gives back."""
    robot = loaded(tmp_path, *ROBOTS[name][:2])
    rng = np.random.default_rng(0)
    positions, speeds = random_states(robot, rng, 500)
    forces = rng.uniform(-1.0, 1.0, (500, len(robot.actuated)))
    actuation = robot.actuation_matrix(positions)
    along = np.einsum("knm,km->kn", actuation, forces)
    found = robot.forward_dynamics(positions, speeds, along)
    size = 1.0 + np.abs(along).max(axis=1, keepdims=True)
    M, C, G = robot.equation_of_motion(positions, speeds)
    size += np.abs(G).max(axis=1, keepdims=True)
    assembled = np.einsum("kij,kj->ki", M, found) + np.einsum("kij,kj->ki", C, speeds) + G
    assert (np.abs(assembled - along) < 1e-10 * size).all()
    assert (np.abs(robot.inverse_dynamics(positions, speeds, found) - along) < 1e-10 * size).all()
    # The motors' forces of a motion that they can bring about: none shorter makes the same.
    again = robot.actuator_forces(positions, speeds, found)
    assert (np.abs(np.einsum("knm,km->kn", actuation, again) - along) < 1e-10 * size).all()
    assert (np.linalg.norm(again, axis=1) <= np.linalg.norm(forces, axis=1) + 1e-9).all()
    for k in range(0, 500, 25):
        preload = robot.preload(positions[k])
        assert preload.shape[1] == len(robot.actuated) - np.linalg.matrix_rank(actuation[k])
        assert np.abs(actuation[k] @ preload).max(initial=0.0) < 1e-12
        assert np.abs(preload.T @ again[k]).max(initial=0.0) < 1e-10 * size[k, 0]


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


KNOWN_TO_NOC = (
    "doubled hinge, locked",
    "doubled hinge, kept",
    "five-bar, three motors",
    "five-bar, four motors",
)


@pytest.mark.parametrize(
    ("name", "route", "count"),
    [(name, "pinocchio", 500) for name in ROBOTS] + [(name, "noc", 100) for name in KNOWN_TO_NOC],
)
def test_the_other_routes_take_the_same_coordinates(
    name: str, route: str, count: int, tmp_path: Path
) -> None:
    """To 1e-10, as of the shipped robots: M, C v and G, and the motors' forces of a motion."""
    robot = loaded(tmp_path, *ROBOTS[name][:2])
    other, rng = robot.dynamics(route), np.random.default_rng(1)
    positions, speeds = random_states(robot, rng, count)
    (M, C, G), (M2, C2, G2) = (one.equation_of_motion(positions, speeds) for one in (robot, other))
    largest = np.abs(M).max(axis=(1, 2)) + np.abs(G).max(axis=1)
    assert (np.abs(M - M2).max(axis=(1, 2)) < 1e-10 * largest).all()
    rates = np.einsum("kij,kj->ki", C - C2, speeds)
    assert (np.abs(rates).max(axis=1) < 1e-10 * largest).all()
    assert (np.abs(G - G2).max(axis=1) < 1e-10 * largest).all()


@pytest.mark.parametrize("name", list(ROBOTS))
def test_the_motors_forces_are_those_of_the_other_route(name: str, tmp_path: Path) -> None:
    """50 states to 1e-9, because the condition of the actuation comes on top: of all coordinates.

    And of the commanded ones alone.
    """
    robot = loaded(tmp_path, *ROBOTS[name][:2])
    other, rng = robot.dynamics("pinocchio"), np.random.default_rng(1)
    positions, speeds = random_states(robot, rng, 50)
    forces = rng.uniform(-1.0, 1.0, (50, len(robot.actuated)))
    along = np.einsum("knm,km->kn", robot.actuation_matrix(positions), forces)
    made = other.forward_dynamics(positions, speeds, along)
    ours = robot.forward_dynamics(positions, speeds, along)
    assert (np.abs(made - ours).max(axis=1) < 1e-9 * np.abs(ours).max(axis=1)).all()
    for wanted in (made, made[:, : robot.commanded]):
        found = other.actuator_forces(positions, speeds, wanted)
        expected = robot.actuator_forces(positions, speeds, wanted)
        assert np.abs(found - expected).max() < 1e-8 * (1.0 + np.abs(expected).max())


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("rod, its spin locked", "a ball whose spin is held"),
        ("gripper: tendon, coupling, springs", "springs"),
        ("five-bar, a mimic joint drives", "couplings"),
        ("biped on a floating base", "a floating base"),
    ],
)
def test_what_the_thesis_has_no_word_for_is_said(name: str, part: str, tmp_path: Path) -> None:
    robot = loaded(tmp_path, *ROBOTS[name][:2])
    with pytest.raises(InvalidValue, match=part):
        robot.dynamics("noc")


@pytest.mark.parametrize("free", ["lock", "keep"])
def test_hinges_in_the_other_route(free: str, tmp_path: Path) -> None:
    """A biped with a foot on a hinge, whose base follows: 100 states to 1e-10."""
    file = tmp_path / "robot.xml"
    file.write_text(biped("l_hip", "l_motor", "r_hip", "r_motor"), encoding="utf-8")
    robot = psp3.ClosedLoopRobot.from_mjcf(
        file, free=free, closures=[("l_shank", "world", "hinge")]
    )
    other, rng = robot.dynamics("pinocchio"), np.random.default_rng(1)
    n = len(robot.coordinates_v)
    positions = robot.reference + rng.uniform(-0.1, 0.1, (100, n))
    speeds = rng.uniform(-1.0, 1.0, (100, n))
    forces = robot.inverse_dynamics(positions, speeds, speeds)
    found = other.inverse_dynamics(positions, speeds, speeds)
    size = np.abs(forces).max(axis=1)
    assert (np.abs(found - forces).max(axis=1) < 1e-10 * size).all()


def test_too_few_motors_cannot_bring_about_every_motion(tmp_path: Path) -> None:
    """A five-bar with a motor and a spring: what is left over is what the spring's joint lacks."""
    robot = loaded(tmp_path, five_bar("m1", spring=SPRING), "keep")
    positions, speeds = robot.reference, np.array([0.2, -0.1])
    needed = robot.inverse_dynamics(positions, speeds, [1.0, 2.0])
    with pytest.raises(UnreachableForces, match="p1") as caught:
        robot.actuator_forces(positions, speeds, [1.0, 2.0])
    # The motor is the first coordinate itself.
    assert caught.value.residual == pytest.approx(abs(needed[1]), rel=1e-9)


def test_free_motions_are_refused_where_that_is_asked_for(tmp_path: Path) -> None:
    for name in ("doubled hinge, locked", "rod, its spin locked"):
        with pytest.raises(MobilityMismatch, match="can still move"):
            loaded(tmp_path, ROBOTS[name][0], "refuse")
    with pytest.raises(UnknownName, match="keep"):
        loaded(tmp_path, rod(), "drop")


def test_one_warning_names_what_is_held(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    robot = loaded(tmp_path, doubled(), "lock")
    (record,) = [one for one in caplog.records if "held where they are" in one.getMessage()]
    (held,) = robot.locked
    # Of the two hinges on one line the first in the file.
    assert held.joint == "pin1"
    assert held.moving == ("pin1", "pin2")
    assert "pin1 (would move pin2)" in record.getMessage()


def test_springs_come_before_the_order_of_the_file(tmp_path: Path) -> None:
    """Of a five-bar with one motor any joint could be held; it is the one with a spring."""
    for joint in ("p1", "p2"):
        text = five_bar("m1").replace(f'name="{joint}"', f'name="{joint}" stiffness="3"')
        (held,) = loaded(tmp_path, text, "lock").locked
        assert held.joint == joint
    (held,) = loaded(tmp_path, five_bar("m1"), "lock").locked
    assert held.joint == "p1"


def test_coordinates_can_be_chosen(tmp_path: Path) -> None:
    """A five-bar in the coordinates of its elbows: the same motion, and forces of one power."""
    file = tmp_path / "robot.xml"
    file.write_text(five_bar("m1", "m2"), encoding="utf-8")
    usual = psp3.ClosedLoopRobot.from_mjcf(file)
    robot = psp3.ClosedLoopRobot.from_mjcf(file, coordinates=["p2", "p1"])
    assert (robot.coordinates, robot.actuated) == (("p2", "p1"), ("m1", "m2"))
    rng = np.random.default_rng(2)
    for _ in range(5):
        positions = usual.reference + rng.uniform(-0.1, 0.1, 2)
        speeds, accelerations = rng.uniform(-1.0, 1.0, (2, 2))
        q, v = usual.configuration(positions), usual.velocity(positions, speeds)
        forces = usual.inverse_dynamics(positions, speeds, accelerations)
        at, moving = q[robot.coordinates_q], v[robot.coordinates_v]
        assert np.allclose(robot.configuration(at), q, atol=1e-12)
        along = robot.actuation_matrix(at) @ forces
        assert along @ moving == pytest.approx(forces @ speeds, rel=1e-10)
        turned = robot.forward_dynamics(at, moving, along)
        assert np.allclose(robot.actuator_forces(at, moving, turned), forces, atol=1e-10)
    with pytest.raises(DependentCoordinates, match="m2"):
        psp3.ClosedLoopRobot.from_mjcf(file, coordinates=["m1", "p1", "m2"])


def test_damping_of_a_motor_counts(tmp_path: Path) -> None:
    """A motor that turns at 0.3 rad/s against 2 N m s gives 0.6 N m more."""
    speeds = np.array([0.3, 0.3])
    answers = []
    for more in ("", 'damping="2"'):
        text = five_bar("m1", "m2").replace('name="m1"', f'name="m1" {more}')
        robot = loaded(tmp_path, text, "lock")
        answers.append(robot.inverse_dynamics(robot.reference, speeds, [0.0, 0.0]))
        _, C, G = robot.equation_of_motion(robot.reference, speeds)
        assert np.allclose(C @ speeds + G, answers[-1], atol=1e-12)
    assert np.allclose(answers[1] - answers[0], [0.6, 0.0], atol=1e-12)


def test_dry_friction_brakes_every_joint_that_moves(tmp_path: Path) -> None:
    """At elbow and motor: friction times the sign of the speed, brought to the motors by power."""
    plain = loaded(tmp_path, five_bar("m1", "m2"), "lock")
    text = five_bar("m1", "m2", spring='frictionloss=".4"')
    robot = loaded(tmp_path, text.replace('name="m2"', 'name="m2" frictionloss=".7"'), "lock")
    rng = np.random.default_rng(3)
    for _ in range(5):
        positions = robot.reference + rng.uniform(-0.1, 0.1, 2)
        speeds = rng.uniform(-1.0, 1.0, 2)
        L = plain.closure(positions).complement
        friction = np.zeros(robot.model.nv)
        for name, most in (("p1", 0.4), ("m2", 0.7)):
            at = robot.model.joints[robot.model.getJointId(name)].idx_v
            friction[at] = most * np.sign((L @ speeds)[at])
        more = robot.inverse_dynamics(positions, speeds, speeds) - plain.inverse_dynamics(
            positions, speeds, speeds
        )
        assert np.allclose(more, L.T @ friction, atol=1e-10)
        M, C, G = robot.equation_of_motion(positions, speeds)
        forces = robot.inverse_dynamics(positions, speeds, speeds)
        assert np.allclose(M @ speeds + C @ speeds + G, forces, atol=1e-10)
    assert np.allclose(
        robot.inverse_dynamics(positions, [0.0, 0.0], [0.0, 0.0]),
        plain.inverse_dynamics(positions, [0.0, 0.0], [0.0, 0.0]),
    )
