"""Robots of example-parallel-robots, where a clone of it is at hand.

They load, or the error says what keeps them from it.

The environment variable EXAMPLE_PARALLEL_ROBOTS names the clone; nothing of it is kept here. Two
habits of its files leave joints that move by themselves, which no motor holds and which our loader
refuses:

* a hinge that closes a loop is written twice, once at each end, so that what is between the two can
  spin (five-bar, Delta);
* a rod with a ball joint at either end can spin about itself (the legs, but for
  ``digit_like_2legs``, which has universal joints).

Both are put right in the loop file alone, in its own words: ``FIXED`` for one hinge of two, or for
one revolute of three.
"""

from __future__ import annotations

import os
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import NamedTuple

import numpy as np
import pytest
import yaml
from numpy.testing import assert_allclose

from psp3.description.urdf import read_robot
from psp3.dynamics.natural_orthogonal_complement import NaturalOrthogonalComplement
from psp3.errors import MobilityMismatch
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.helpers import Array, derivative, relative_error

CLONE = os.environ.get("EXAMPLE_PARALLEL_ROBOTS", "")

pytestmark = pytest.mark.skipif(
    not CLONE, reason="EXAMPLE_PARALLEL_ROBOTS names no clone of example-parallel-robots"
)


class Example(NamedTuple):
    """A robot of the collection."""

    motors: int
    spins: tuple[str, ...] = ()
    """Joints to lock, one for each motion that no motor commands."""
    range: float = 0.05
    """How far from the reference the motors are moved [m or rad]; some references are close to a
    singularity.
    """


ROBOTS = {
    "5bar_linkage": Example(2, ("closedloop1_B",)),
    "5bar_linkage_iso3d": Example(2),
    "5bar_linkage_iso6d": Example(2),
    "robot_delta": Example(2, ("closedloop1_B", "closedloop2_B", "closedloop3_B")),
    "talos_like": Example(6, ("moteur_rod_1_rev2",)),
    "cassie_like": Example(
        5, ("servo_gauche_half_planta_rode_rev2", "tigh_half_hachil_rode_2_rev2")
    ),
    "digit_like": Example(
        6, ("hip_x_toe_a_2/2_rev2", "crank_toe_b_2/2_rev2", "crank_2_toe_b_2/2_2_rev2")
    ),
    "digit_like_2legs": Example(12),
    "disney_like": Example(
        6,
        (
            "motor_link_2_tigh_mirror2_2_rev1",
            "motor_link_tigh_mirror2_rev1",
            "ankle_universal_2_rev1",
        ),
    ),
    "wl16_like": Example(
        6,
        tuple(f"hip_part_motor_part{leg}_rev2" for leg in ("", "_2", "_3", "_4", "_5", "_6")),
        0.001,
    ),
}
SPINNING = [name for name, example in ROBOTS.items() if example.spins]


def files(name: str) -> tuple[Path, Path]:
    directory = Path(CLONE) / "robots" / name
    if not directory.is_dir():
        pytest.skip(f"this clone has no {directory}")
    return directory / "robot.urdf", directory / "robot.yaml"


@cache
def loaded(name: str) -> ClosedLoopRobot:
    """Return a robot with the joints locked that spin."""
    urdf, loops = files(name)
    content, spins = yaml.safe_load(loops.read_text()), list(ROBOTS[name].spins)
    content["joint_name"] = content.get("joint_name", []) + spins
    content["joint_type"] = content.get("joint_type", []) + ["FIXED"] * len(spins)
    repaired = Path(mkdtemp()) / "robot.yaml"
    repaired.write_text(yaml.safe_dump(content))
    return ClosedLoopRobot(*read_robot(urdf, repaired))


def states(name: str, count: int) -> tuple[ClosedLoopRobot, Array, Array]:
    robot, rng = loaded(name), np.random.default_rng(0)
    n = len(robot.actuated)
    positions = robot.reference + ROBOTS[name].range * rng.uniform(-1.0, 1.0, (count, n))
    return robot, positions, rng.normal(size=(count, n))


@pytest.mark.parametrize("name", SPINNING)
def test_joints_that_spin_are_named(name: str) -> None:
    """As published, a robot of these has a degree of freedom for each spin besides its motors."""
    example, (urdf, loops) = ROBOTS[name], files(name)
    with pytest.raises(MobilityMismatch) as caught:
        ClosedLoopRobot(*read_robot(urdf, loops), free="refuse")
    report = caught.value.mobility
    assert report.degrees_of_freedom == example.motors + len(example.spins)
    assert (report.actuators, report.commanded, report.over_actuation) == (
        example.motors,
        example.motors,
        0,
    )
    assert set(example.spins) <= set(report.free_joints)
    for joint in example.spins:
        assert joint in str(caught.value)


@pytest.mark.parametrize("name", ROBOTS)
def test_robots_have_as_many_degrees_of_freedom_as_motors_once_nothing_spins(name: str) -> None:
    robot = loaded(name)
    assert len(robot.actuated) == ROBOTS[name].motors
    assert (
        robot.mobility.degrees_of_freedom,
        robot.mobility.under_actuation,
        robot.mobility.over_actuation,
    ) == (ROBOTS[name].motors, 0, 0)


@pytest.mark.parametrize("name", ROBOTS)
def test_every_shape_is_drawn(name: str, caplog: pytest.LogCaptureFixture) -> None:
    """Meshes are named ``package:///part.stl`` and lie beside the URDF."""
    urdf, loops = files(name)
    parts = read_robot(urdf, loops)
    assert parts.visual_model.ngeoms == urdf.read_text().count("<visual>")
    assert "cannot be read" not in caplog.text


@pytest.mark.parametrize("name", ROBOTS)
def test_loops_close_and_dynamics_agree_with_the_natural_orthogonal_complement(name: str) -> None:
    """Ten poses around the reference: loops closed to 1e-10.

    M, C v and G by the thesis's equations, to 1e-8 relative.
    """
    robot, positions, speeds = states(name, 10)
    q, v = robot.configuration(positions), robot.velocity(positions, speeds)
    noc = NaturalOrthogonalComplement(robot)
    assert np.abs(noc.constraint(q)).max() < 1e-10
    mass, coriolis, gravity = robot.equation_of_motion(positions, speeds)
    assert relative_error(mass, noc.mass_matrix(q)) < 1e-8
    forces = np.einsum("nij,nj->ni", noc.coriolis_matrix(q, v), speeds)
    assert relative_error(np.einsum("nij,nj->ni", coriolis, speeds), forces) < 1e-8
    assert relative_error(gravity, noc.gravity(q)) < 1e-8


@pytest.mark.parametrize("name", ROBOTS)
def test_forward_dynamics_undo_inverse_dynamics(name: str) -> None:
    """To 1e-8 of the largest acceleration there is, with or without these forces.

    Near a singularity what they hold back is large.
    """
    robot, positions, speeds = states(name, 10)
    accelerations = np.random.default_rng(1).normal(size=positions.shape)
    forces = robot.inverse_dynamics(positions, speeds, accelerations)
    free = robot.forward_dynamics(positions, speeds, np.zeros_like(forces))
    largest = max(np.abs(accelerations).max(), np.abs(free).max())
    assert_allclose(
        robot.forward_dynamics(positions, speeds, forces),
        accelerations,
        rtol=0,
        atol=1e-8 * largest,
    )


@pytest.mark.parametrize("name", ROBOTS)
def test_rate_of_the_mass_matrix_minus_twice_c_is_skew(name: str) -> None:
    """With dM/dt of eighth order along the motion.

    1e-7 relative, as rounding in M is divided by the step.
    """
    robot, (position,), (speed,) = states(name, 1)
    step = 0.01 * ROBOTS[name].range / np.abs(speed).max()
    rate = derivative(lambda time: robot.mass_matrix(position + time * speed), step)
    difference = rate - 2.0 * robot.coriolis_matrix(position, speed)
    assert np.abs(difference + difference.T).max() < 1e-7 * np.abs(rate).max()


@pytest.mark.parametrize("name", ROBOTS)
def test_mass_matrix_and_weight_agree_with_mujoco(name: str, tmp_path: Path) -> None:
    """MuJoCo's mass matrix and weight of the tree on the null space of its own constraints.

    1e-8 relative. It finds the loops closed.
    """
    mujoco = pytest.importorskip("mujoco", reason="MuJoCo is in the extras mujoco and test")
    from psp3.robots.mjcf_export import mujoco_state, to_mjcf

    robot, positions, _ = states(name, 3)
    engine = mujoco.MjModel.from_xml_string(to_mjcf(robot))
    data = mujoco.MjData(engine)
    for position in positions:
        q = robot.configuration(position)
        data.qpos[:], _ = mujoco_state(robot, q)
        mujoco.mj_forward(engine, data)
        assert np.abs(data.efc_pos[: data.ne]).max() < 1e-9
        change = np.array([mujoco_state(robot, q, unit)[1] for unit in np.eye(robot.model.nv)]).T
        _, values, right = np.linalg.svd(data.efc_J.reshape(-1, engine.nv)[: data.ne] @ change)
        null = right[np.count_nonzero(values > 1e-7 * values[0]) :].T
        complement = null @ np.linalg.inv(null[robot.actuated_v])
        tree = np.empty((engine.nv, engine.nv))
        for row, unit in zip(tree, np.eye(engine.nv), strict=True):
            mujoco.mj_mulM(engine, data, row, unit)
        mass = complement.T @ change.T @ tree @ change @ complement
        weight = complement.T @ change.T @ data.qfrc_bias
        assert_allclose(robot.mass_matrix(position), mass, rtol=0, atol=1e-8 * np.abs(mass).max())
        assert_allclose(robot.gravity(position), weight, rtol=0, atol=1e-8 * np.abs(weight).max())
