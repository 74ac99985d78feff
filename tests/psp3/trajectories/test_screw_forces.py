"""Screw forces of a motion.

Against other implementations of the dynamics, finite differences, and the conservation of energy.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

import psp3
from psp3.errors import InvalidArray, InvalidValue, StrokeExceeded, UnreachableTip
from psp3.trajectories import Circle, FromCSV, Helix, Hold, Line, PointToPoint, Trajectory
from psp3.trajectories.screw_forces import screw_forces
from psp3.trajectories.sway import Sway

ROBOT = psp3.load("psp3")

MOTIONS = {
    "helix": Helix(robot=ROBOT),
    "circle": Circle(0.015, 1.0, robot=ROBOT),
    "point-to-point": PointToPoint([0.0, 0.0, 0.07], [-0.01, 0.015, 0.12], 0.5, robot=ROBOT),
}


@pytest.fixture(params=list(MOTIONS))
def motion(request: pytest.FixtureRequest) -> Trajectory:
    return MOTIONS[request.param]


@pytest.mark.parametrize("model", ["pinocchio", "noc"])
def test_forces_are_those_of_the_independent_implementations(
    motion: Trajectory, model: str
) -> None:
    """The term sums of RNEA and of the thesis's own route.

    The bar of the models is 1e-9 of the largest entry.
    """
    t = np.linspace(0.0, 0.5, 7)
    ours, other = screw_forces(motion, t), screw_forces(motion, t, ROBOT.dynamics(model))
    assert other.forces is not ours.forces
    for name in ("inertial", "coriolis", "gravity", "forces"):
        expected = getattr(other, name)
        np.testing.assert_allclose(
            getattr(ours, name), expected, rtol=0.0, atol=1e-9 * max(np.abs(expected).max(), 1e-3)
        )


def test_forces_are_those_of_recursive_newton_euler_on_the_tree(motion: Trajectory) -> None:
    """Inverse dynamics of the tree projected on the screws takes no M, C or G at all.

    1e-9 of the weight.
    """
    t = np.linspace(0.0, 0.5, 11)
    forces = screw_forces(motion, t)
    tree = ROBOT.dynamics("pinocchio")
    expected = tree.inverse_dynamics(
        forces.motion.heights, forces.motion.speeds, forces.motion.accelerations
    )  # type: ignore[attr-defined]
    np.testing.assert_allclose(forces.forces, expected, atol=1e-7)


def test_work_of_the_screws_is_the_gain_in_energy(motion: Trajectory) -> None:
    """Trapezoidal rule at 0.1 ms.

    Its error is about 1e-8 of the power's second derivative, below 1e-6 J.
    """
    t = np.linspace(0.0, 0.5, 5001)
    forces = screw_forces(motion, t)
    heights, speeds = forces.motion.heights, forces.motion.speeds
    energy = ROBOT.kinetic_energy(heights, speeds) + ROBOT.potential_energy(heights)
    work = np.trapezoid((forces.forces * speeds).sum(axis=-1), t)
    np.testing.assert_allclose(work, energy[-1] - energy[0], atol=1e-6)
    assert np.ptp(energy) > 1e-3


def test_rates_are_the_derivatives_of_the_heights(motion: Trajectory) -> None:
    """Central differences over 0.1 ms: 1e-8 of the third derivative, about 100 m/s³."""
    step = 1e-4
    t = np.linspace(0.05, 0.45, 9)
    before, now, after = (screw_forces(motion, t + shift).motion for shift in (-step, 0.0, step))
    np.testing.assert_allclose(
        now.speeds, (after.heights - before.heights) / (2.0 * step), atol=1e-6
    )
    np.testing.assert_allclose(
        now.accelerations, (after.speeds - before.speeds) / (2.0 * step), atol=1e-4
    )


def test_tip_at_rest_takes_the_weight_and_nothing_else() -> None:
    """The three screws carry 26.496 kg in sum, at any pose."""
    held = screw_forces(Hold([0.012, -0.004, 0.1], robot=ROBOT), [0.0, 1.0])
    np.testing.assert_array_equal(held.inertial, 0.0)
    np.testing.assert_array_equal(held.coriolis, 0.0)
    np.testing.assert_allclose(held.forces.sum(axis=-1), 26.496 * 9.81, rtol=1e-12)


def test_columns_are_a_file_that_can_be_followed_again(motion: Trajectory, tmp_path: Path) -> None:
    """A spline through samples 1 ms apart misses a smooth path by less than 1e-9 m.

    It misses its curvature by less than 1e-2 m/s².
    """
    t = np.linspace(0.0, 0.5, 501)
    forces = screw_forces(motion, t)
    columns = forces.columns()
    assert list(columns) == ["t", "x", "y", "z"] + [
        f"{name}{k}" for name in ("a", "speed", "acceleration", "force") for k in (1, 2, 3)
    ]
    assert {values.shape for values in columns.values()} == {(501,)}
    np.testing.assert_array_equal(columns["force2"], forces.forces[:, 1])
    path = tmp_path / "motion.csv"
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(zip(*(values.tolist() for values in columns.values()), strict=True))
    between = t[50:-50] + 4e-4
    again, exact = screw_forces(FromCSV(path, robot=ROBOT), between), screw_forces(motion, between)
    np.testing.assert_allclose(again.motion.heights, exact.motion.heights, atol=1e-9)
    np.testing.assert_allclose(again.forces, exact.forces, atol=0.1)


@pytest.mark.parametrize(
    ("call", "error"),
    [
        (lambda: screw_forces(Helix(0.03, robot=ROBOT), [0.0, 1.0]), UnreachableTip),
        (
            lambda: screw_forces(
                Line([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], 1.0, robot=ROBOT), np.linspace(0.0, 1.0, 9)
            ),
            StrokeExceeded,
        ),
        (lambda: screw_forces(MOTIONS["helix"], 0.0), InvalidArray),
        (lambda: screw_forces(MOTIONS["helix"], [[0.0]]), InvalidArray),
        (lambda: screw_forces(MOTIONS["helix"], [0.0, np.nan]), InvalidArray),
    ],
)
def test_motions_that_cannot_be_made_are_refused(call: object, error: type[Exception]) -> None:
    with pytest.raises(error):
        call()  # type: ignore[operator]


def test_forces_of_more_motors_than_coordinates() -> None:
    """Each term is of least norm, so that their sum is what the motors do; 1e-10 is rounding."""
    robot = psp3.load("planar_4rrr")
    forces = screw_forces(Sway(robot=robot), np.linspace(0.0, 1.0, 11))
    expected = robot.dynamics("pinocchio").actuator_forces(*forces.motion[:3])
    assert forces.forces.shape == (11, 4)
    np.testing.assert_allclose(
        forces.forces, expected, rtol=0.0, atol=1e-10 * np.abs(expected).max()
    )


@pytest.mark.parametrize(("name", "follower"), [("gripper", "right_spring"), ("biped", "root")])
def test_motions_that_motors_do_not_determine_have_no_forces(name: str, follower: str) -> None:
    robot = psp3.load(name)
    with pytest.raises(InvalidValue, match=rf"{follower}.* simulate finds both"):
        screw_forces(Sway(robot=robot), [0.0, 0.1])
