"""Linearizations against the motion of the robot itself.

And sampled systems against their algebra.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose, assert_array_equal
from scipy.integrate import solve_ivp

import psp3
from psp3.dynamics.linearization import LinearSystem, discretize, linearize
from psp3.errors import InvalidArray, InvalidValue
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from psp3.simulation.dormand_prince import DormandPrince
from psp3.trajectories import Helix
from tests.helpers import ROBOTS_WITH_LOOPS, Array, derivative


@pytest.fixture(scope="module")
def star() -> psp3.PSP3:
    return psp3.load("psp3")


def linkage() -> ClosedLoopRobot:
    parts = ROBOTS_WITH_LOOPS[2]()
    return ClosedLoopRobot(parts.model, parts.constraint_models, parts.actuated, parts.q0)


def slopes(function: Any, x: Array, step: float) -> Array:
    """Return the derivative of a function of x by eighth-order differences, as columns."""
    return np.stack(
        [derivative(lambda t, u=unit: function(x + t * u), step) for unit in np.eye(x.size)],
        axis=-1,
    )


@pytest.mark.parametrize("name", ["psp3", "spatial linkage"])
def test_linear_system_is_the_slope_of_the_equation_of_state(star: psp3.PSP3, name: str) -> None:
    """Of x' = (speeds, forward dynamics) at a moving state, by differences.

    1e-8 of the largest entry.
    """
    robot = star if name == "psp3" else linkage()
    n = len(robot.actuated)
    rng = np.random.default_rng(31)
    a = robot.reference + rng.uniform(-0.05, 0.05, n)
    v, w = rng.normal(size=(2, n))
    u, x = robot.inverse_dynamics(a, v, w), np.concatenate([a, v])
    found = linearize(robot, a, v, w)
    by_state = slopes(
        lambda x: np.concatenate([x[n:], robot.forward_dynamics(x[:n], x[n:], u)]), x, 2e-3
    )
    by_input = slopes(lambda u: np.concatenate([v, robot.forward_dynamics(a, v, u)]), u, 0.1)
    assert_allclose(found.A, by_state, rtol=0, atol=1e-8 * np.abs(by_state).max())
    assert_allclose(found.B, by_input, rtol=0, atol=1e-8 * np.abs(by_input).max())
    assert found.period is None


def test_sampled_system_is_the_slope_of_the_motion_over_a_period(star: psp3.PSP3) -> None:
    """About a pose at rest nothing is approximated, however long the period.

    State after 0.1 s by DOP853, by differences; 1e-8.
    """
    a, plant = np.array([0.02, -0.03, 0.05]), DormandPrince(star, 1e-13)
    weight = star.gravity(a)

    def after(state: Array, forces: Array) -> Array:
        plant.start(state[:3], state[3:])
        return np.concatenate(plant.advance(forces, 0.1))

    system = discretize(linearize(star, a), 0.1)
    rest = np.concatenate([a, np.zeros(3)])
    assert_allclose(after(rest, weight), rest, rtol=0, atol=1e-12)
    assert_allclose(system.A, slopes(lambda x: after(x, weight), rest, 5e-3), rtol=0, atol=1e-8)
    assert_allclose(system.B, slopes(lambda u: after(rest, u), weight, 1.0), rtol=0, atol=1e-8)


def test_a_small_deviation_from_a_trajectory_obeys_the_sampled_systems(star: psp3.PSP3) -> None:
    """One second along the helix, with forces and linearizations from the middle of every period.

    A and B are constant for a period, so the error falls as the period squared: 3.5 to 4.5 times as
    it is halved. What is left when that is extrapolated is of fourth order, 6e-6 of the deviation;
    the bar is 1e-5.
    """
    trajectory, small = Helix(robot=star), 1e-5 * np.array([1.0, -2.0, 0.5, 3.0, 1.0, -2.0])
    errors = []
    for period in (0.04, 0.02):
        motion = trajectory(period * (np.arange(round(1.0 / period)) + 0.5))
        systems = discretize(
            linearize(star, motion.heights, motion.speeds, motion.accelerations), period
        )
        plants = DormandPrince(star, 1e-13), DormandPrince(star, 1e-13)
        start = trajectory(0.0)
        for plant, sign in zip(plants, (1.0, -1.0), strict=True):
            plant.start(start.heights + sign * small[:3], start.speeds + sign * small[3:])
        predicted = small
        for A, held in zip(
            systems.A,
            star.inverse_dynamics(motion.heights, motion.speeds, motion.accelerations),
            strict=True,
        ):
            ahead, behind = (np.concatenate(plant.advance(held, period)) for plant in plants)
            predicted = A @ predicted
        errors.append((0.5 * (ahead - behind) - predicted) / np.linalg.norm(predicted))
    assert 3.5 < np.linalg.norm(errors[0]) / np.linalg.norm(errors[1]) < 4.5
    assert np.linalg.norm(4.0 * errors[1] - errors[0]) / 3.0 < 1e-5


def test_lifting_the_3_psp_is_a_double_integrator(star: psp3.PSP3) -> None:
    """A common speed of all nuts stays as it is.

    A force of the total mass on each accelerates all alike; 1e-12.
    """
    system = linearize(star, [0.02, -0.03, 0.05], [0.1, 0.3, -0.2], [1.0, -1.0, 2.0])
    ones, mass = np.ones(3), star.mass_matrix([0.02, -0.03, 0.05])
    assert_allclose(system.A @ np.concatenate([ones, 0 * ones]), 0.0, atol=1e-12)
    assert_allclose(
        system.A @ np.concatenate([0 * ones, ones]), np.concatenate([ones, 0 * ones]), atol=1e-12
    )
    assert_allclose(system.B @ mass @ ones, np.concatenate([0 * ones, ones]), atol=1e-12)


# Sampling


SQUARE = arrays(float, (3, 3), elements=st.floats(-3.0, 3.0))
TALL = arrays(float, (3, 2), elements=st.floats(-3.0, 3.0))


@given(A=SQUARE, B=TALL, period=st.floats(0.01, 0.5))
def test_two_periods_are_one_after_the_other(A: Array, B: Array, period: float) -> None:
    """A(2T) = A(T)², B(2T) = A(T) B(T) + B(T); 1e-11 of the square of the entries.

    SciPy's matrix exponential is off by up to 1e-12 of its largest entry for matrices of norm 4,
    compared with a Taylor series in extended precision.
    """
    once, twice = (discretize(LinearSystem(A, B), times * period) for times in (1, 2))
    size = max(1.0, np.abs(once.A).max()) * max(1.0, np.abs(once.A).max(), np.abs(once.B).max())
    assert_allclose(twice.A, once.A @ once.A, rtol=0, atol=1e-11 * size)
    assert_allclose(twice.B, once.A @ once.B + once.B, rtol=0, atol=1e-11 * size)


def test_sampling_is_integration() -> None:
    """Columns against DOP853, 1e-10; a double integrator against what everybody knows."""
    rng = np.random.default_rng(32)
    A, B = rng.normal(size=(4, 4)), rng.normal(size=(4, 2))
    found = discretize(LinearSystem(A, B), 0.3)
    for column, start, u in (
        *((found.A[:, k], unit, np.zeros(2)) for k, unit in enumerate(np.eye(4))),
        *((found.B[:, k], np.zeros(4), unit) for k, unit in enumerate(np.eye(2))),
    ):
        solution = solve_ivp(
            lambda _, x, u=u: A @ x + B @ u,
            (0.0, 0.3),
            start,
            method="DOP853",
            rtol=1e-12,
            atol=1e-12,
        )
        assert_allclose(column, solution.y[:, -1], rtol=0, atol=1e-10)
    mass = discretize(
        LinearSystem(np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0], [0.5]])), 0.1
    )
    assert_allclose(mass.A, [[1.0, 0.1], [0.0, 1.0]], rtol=1e-15)
    assert_allclose(mass.B, [[0.0025], [0.05]], rtol=1e-14)
    assert mass.period == 0.1


def test_leading_dimensions_are_kept(star: psp3.PSP3) -> None:
    rng = np.random.default_rng(33)
    heights = rng.uniform(-0.05, 0.05, size=(2, 4, 3))
    whole = linearize(star, heights, rng.normal(size=3))
    sampled = discretize(whole, 0.01)
    assert whole.A.shape == sampled.A.shape == (2, 4, 6, 6)
    assert whole.B.shape == sampled.B.shape == (2, 4, 6, 3)
    one = discretize(LinearSystem(whole.A[1, 2], whole.B[1, 2]), 0.01)
    assert_allclose(sampled.A[1, 2], one.A, rtol=0, atol=1e-15)
    assert_allclose(sampled.B[1, 2], one.B, rtol=0, atol=1e-15)
    assert linearize(star, np.zeros((0, 3))).A.shape == (0, 6, 6)


def test_at_rest_is_the_default(star: psp3.PSP3) -> None:
    for one, other in zip(
        linearize(star, np.zeros(3)),
        linearize(star, np.zeros(3), np.zeros(3), np.zeros(3)),
        strict=True,
    ):
        assert_array_equal(one, other)


BAD_SYSTEMS = [
    (np.zeros((2, 3)), np.zeros((2, 1))),
    (np.zeros(3), np.zeros((2, 1))),
    (1.0, 1.0),
    (np.eye(2), np.zeros((3, 1))),
    (np.eye(2), np.zeros(2)),
    (np.full((2, 2), np.nan), np.zeros((2, 1))),
    (np.eye(2), np.full((2, 1), np.inf)),
    (np.zeros((4, 2, 2)), np.zeros((2, 1))),
    ("A", "B"),
    (1j * np.eye(2), np.zeros((2, 1))),
]


@pytest.mark.parametrize(("A", "B"), BAD_SYSTEMS)
def test_what_is_no_linear_system_is_refused(A: Any, B: Any) -> None:
    with pytest.raises(InvalidArray):
        discretize(LinearSystem(A, B), 0.1)


@pytest.mark.parametrize("period", [0.0, -1.0, np.nan, np.inf, "1"])
def test_a_period_that_is_none_is_refused(period: Any) -> None:
    with pytest.raises(InvalidValue, match="period"):
        discretize(LinearSystem(np.eye(2), np.ones((2, 1))), period)


def test_a_sampled_system_is_not_sampled_again() -> None:
    system = discretize(LinearSystem(np.eye(2), np.ones((2, 1))), 0.1)
    with pytest.raises(InvalidValue, match="continuous"):
        discretize(system, 0.1)


@pytest.mark.parametrize("bad", [np.zeros(2), [np.nan, 0.0, 0.0], "home"])
def test_states_that_are_none_are_refused(star: psp3.PSP3, bad: Any) -> None:
    for arguments in ((bad,), (np.zeros(3), bad), (np.zeros(3), np.zeros(3), bad)):
        with pytest.raises(InvalidArray):
            linearize(star, *arguments)
