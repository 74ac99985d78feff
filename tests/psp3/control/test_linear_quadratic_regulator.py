"""Regulators.

The Riccati equations, the poles and costs they promise on the robot itself, and that nothing costs
less.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose, assert_array_equal
from scipy.linalg import solve_continuous_lyapunov, solve_discrete_lyapunov

import psp3
from psp3.control.linear_quadratic_regulator import (
    LinearQuadraticRegulator,
    Regulator,
    TimeVaryingLinearQuadraticRegulator,
    lqr,
    time_varying_lqr,
)
from psp3.dynamics.linearization import LinearSystem, discretize, linearize
from psp3.errors import InvalidArray, InvalidValue, NoStabilizingSolution
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from psp3.simulation.runge_kutta import RungeKutta
from psp3.trajectories import Helix, Motion, PointToPoint, Trajectory
from tests.helpers import ROBOTS_WITH_LOOPS, Array, derivative

PERIOD = 0.01


def linkage() -> ClosedLoopRobot:
    parts = ROBOTS_WITH_LOOPS[2]()
    return ClosedLoopRobot(parts.model, parts.constraint_models, parts.actuated, parts.q0)


ROBOTS: dict[str, Callable[[], ClosedLoopRobot]] = {
    "psp3": lambda: psp3.load("psp3"),
    "five_bar": lambda: psp3.load("five_bar"),
    "spatial linkage": linkage,
}


@pytest.fixture(scope="module", params=ROBOTS)
def robot(request: pytest.FixtureRequest) -> ClosedLoopRobot:
    return ROBOTS[request.param]()


@pytest.fixture(scope="module")
def star() -> psp3.PSP3:
    return psp3.load("psp3")


def weights(robot: ClosedLoopRobot) -> tuple[Array, Array]:
    """Return Q and R.

    Errors of 0.01 (m or rad) and 0.1 per second, and what accelerates a joint by 2 per second², are
    equally bad.
    """
    n, masses = len(robot.actuated), np.diag(robot.mass_matrix(robot.reference))
    return np.diag(1.0 / np.repeat([0.01, 0.1], n) ** 2), np.diag(1.0 / (2.0 * masses) ** 2)


def at_rest(positions: Array) -> Motion:
    return Motion(positions, np.zeros_like(positions), np.zeros_like(positions), np.zeros(3))


def run(
    robot: ClosedLoopRobot,
    controller: Any,
    desired: Motion,
    deviation: Array,
    steps: int,
    plant: RungeKutta,
) -> tuple[Array, Array]:
    """Return deviations from a desired rest, (steps + 1, 2n), and forces, (steps, n).

    Forces are held, and beside those of the rest.
    """
    n = len(robot.actuated)
    state = np.concatenate([desired.heights, desired.speeds]) + deviation
    rest = np.concatenate([desired.heights, desired.speeds])
    weight = robot.gravity(desired.heights)
    plant.start(state[:n], state[n:])
    states, forces = [state - rest], []
    for k in range(steps):
        force = controller.torque(k * PERIOD, state[:n], state[n:], desired)
        state = np.concatenate(plant.advance(force, PERIOD))
        states.append(state - rest)
        forces.append(force - weight)
    return np.array(states), np.array(forces)


# The algebraic equations


def residual(system: LinearSystem, regulator: Regulator, Q: Array, R: Array) -> Array:
    """Return what is left of the Riccati equation, written without the gain."""
    A, B, P = system.A, system.B, regulator.P
    if system.period is None:
        return A.T @ P + P @ A - P @ B @ np.linalg.inv(R) @ B.T @ P + Q
    return A.T @ P @ A - P - A.T @ P @ B @ np.linalg.inv(R + B.T @ P @ B) @ B.T @ P @ A + Q


@pytest.mark.parametrize("period", [None, 0.002, 0.05])
def test_riccati_equation_holds_and_the_loop_is_stable(
    robot: ClosedLoopRobot, period: float | None
) -> None:
    """1e-9 of the cost matrix: SciPy's solvers lose digits to the condition of their pencils."""
    Q, R = weights(robot)
    system = linearize(robot, robot.reference)
    system = system if period is None else discretize(system, period)
    found = lqr(system, Q, R)
    assert np.abs(residual(system, found, Q, R)).max() < 1e-9 * np.abs(found.P).max()
    assert_allclose(found.P, found.P.T, rtol=0, atol=1e-12 * np.abs(found.P).max())
    assert np.linalg.eigvalsh(found.P).min() > 0.0
    poles = np.linalg.eigvals(system.A - system.B @ found.K)
    assert_allclose(np.sort_complex(found.poles), np.sort_complex(poles), rtol=1e-12)
    assert (found.poles.real < 0.0).all() if period is None else (np.abs(found.poles) < 1.0).all()


def test_double_integrator_has_the_gains_of_the_textbook() -> None:
    r"""Of a unit mass with weights q on x and 1 on u.

    K = (√q, √2 q^¼), so the damping ratio is 1/√2 whatever q; 1e-12.
    """
    system = LinearSystem(np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0], [1.0]]))
    for q in (0.01, 1.0, 1e4):
        found = lqr(system, np.diag([q, 0.0]), np.eye(1))
        assert_allclose(found.K, [[np.sqrt(q), np.sqrt(2.0) * q**0.25]], rtol=1e-10)
        assert_allclose(-found.poles.real / np.abs(found.poles), np.sqrt(0.5), rtol=1e-10)


def test_short_periods_approach_the_continuous_regulator(star: psp3.PSP3) -> None:
    """The sampled gain differs by a term of first order in the period.

    Extrapolated from 1 and 0.5 ms, 1e-4 of the gain is left.
    """
    Q, R = weights(star)
    system = linearize(star, [0.02, -0.03, 0.05])
    coarse, fine = (lqr(discretize(system, period), Q, R).K for period in (1e-3, 5e-4))
    exact = lqr(system, Q, R).K
    assert np.abs(fine - exact).max() < 0.6 * np.abs(coarse - exact).max()
    assert np.abs(2.0 * fine - coarse - exact).max() < 1e-4 * np.abs(exact).max()


EIGHTHS = st.integers(-8, 8).map(lambda k: k / 8.0)


@settings(max_examples=40)
@given(
    A=arrays(float, (3, 3), elements=EIGHTHS),
    B=arrays(float, (3, 3), elements=EIGHTHS),
    off=arrays(float, (3, 3), elements=EIGHTHS),
    period=st.sampled_from([None, 0.1]),
)
def test_every_other_gain_costs_more(A: Array, B: Array, off: Array, period: float | None) -> None:
    """Of any system that the input reaches.

    Cost of other stable gains from Lyapunov's equation, which knows nothing of Riccati's.
    """
    system = LinearSystem(A, 4.0 * np.eye(3) + B)
    system = system if period is None else discretize(system, period)
    best = lqr(system, np.eye(3), np.eye(3))
    K = best.K + 0.2 * off
    closed = system.A - system.B @ K
    poles = np.linalg.eigvals(closed)
    assume(poles.real.max() < -1e-3 if period is None else np.abs(poles).max() < 0.999)
    weight = np.eye(3) + K.T @ K
    cost = (
        solve_continuous_lyapunov(closed.T, -weight)
        if period is None
        else solve_discrete_lyapunov(closed.T, weight)
    )
    assert np.linalg.eigvalsh(cost - best.P).min() > -1e-9 * np.abs(cost).max()


# On the robots


def test_poles_are_those_of_the_simulated_loop(robot: ClosedLoopRobot) -> None:
    """Slope of one period of the nonlinear robot under the controller, by differences.

    What was promised to 1e-8.
    """
    Q, R = weights(robot)
    controller = LinearQuadraticRegulator(robot, Q, R, PERIOD)
    desired = at_rest(robot.reference)
    m = 2 * len(robot.actuated)

    def after(deviation: Array) -> Array:
        return run(robot, controller, desired, deviation, 1, RungeKutta(robot, steps=4))[0][-1]

    closed = np.stack(
        [derivative(lambda t, u=unit: after(t * u), 2e-3) for unit in np.eye(m)], axis=-1
    )
    system, regulator = controller.system, controller.regulator
    assert_allclose(
        closed,
        system.A - system.B @ regulator.K,
        rtol=0,
        atol=1e-8 * max(1.0, np.abs(closed).max()),
    )
    assert_allclose(
        np.sort(np.abs(np.linalg.eigvals(closed))),
        np.sort(np.abs(regulator.poles)),
        rtol=0,
        atol=1e-7,
    )


def test_simulated_cost_is_the_promised_one_and_other_gains_cost_more(
    robot: ClosedLoopRobot,
) -> None:
    """From 1e-5 (m, rad, and per second), until all has died out to 1e-8 of the cost.

    1e-4: the robot is linear up to its deviation.

    Gains that are off by up to a tenth cost more, and what Lyapunov's equation says of them.
    """
    Q, R = weights(robot)
    controller = LinearQuadraticRegulator(robot, Q, R, PERIOD)
    rng = np.random.default_rng(41)
    deviation = 1e-5 * rng.normal(size=len(Q))
    steps = int(np.log(1e-4) / np.log(np.abs(controller.regulator.poles).max())) + 1

    def cost() -> float:
        states, forces = run(
            robot, controller, at_rest(robot.reference), deviation, steps, RungeKutta(robot)
        )
        return float(
            np.einsum("ki,ij,kj->", states, Q, states) + np.einsum("ki,ij,kj->", forces, R, forces)
        )

    best, promised = cost(), deviation @ controller.regulator.P @ deviation
    assert_allclose(best, promised, rtol=1e-4)
    A, B = controller.system.A, controller.system.B
    gains = controller.regulator.K * rng.uniform(0.9, 1.1, controller.regulator.K.shape)
    controller.regulator = controller.regulator._replace(K=gains)
    by_lyapunov = (
        deviation @ solve_discrete_lyapunov((A - B @ gains).T, Q + gains.T @ R @ gains) @ deviation
    )
    found = cost()
    assert found > best
    assert_allclose(found, by_lyapunov, rtol=1e-4)


def test_the_forces_are_those_of_the_motion_and_of_the_gain(star: psp3.PSP3) -> None:
    """On the trajectory the feed-forward alone, off it −K times the deviation more.

    Pinocchio's forces, 1e-9.
    """
    Q, R = weights(star)
    desired, tree = Helix(robot=star)(0.3), star.dynamics("pinocchio")
    controller = LinearQuadraticRegulator(star, Q, R)
    controller.reset()
    forces = tree.inverse_dynamics(  # type: ignore[attr-defined]
        desired.heights, desired.speeds, desired.accelerations
    )
    assert_allclose(
        controller.torque(0.3, desired.heights, desired.speeds, desired), forces, rtol=1e-9
    )
    off = 1e-3 * np.arange(1.0, 7.0)
    found = controller.torque(0.3, desired.heights + off[:3], desired.speeds + off[3:], desired)
    assert_allclose(found - forces, -controller.regulator.K @ off, rtol=1e-9)
    elsewhere = LinearQuadraticRegulator(star, Q, R, positions=[0.05, -0.05, 0.0])
    assert (
        np.abs(elsewhere.regulator.K - controller.regulator.K).max()
        > 1e-3 * np.abs(controller.regulator.K).max()
    )


# Along a trajectory


def test_recursion_finds_the_least_cost_of_all_forces_at_once() -> None:
    """Five periods of a random changing system.

    The cost as one quadratic form in all inputs, minimized by solving; 1e-10.
    """
    rng = np.random.default_rng(42)
    N, m, n = 5, 4, 2
    A, B = rng.normal(size=(N, m, m)), rng.normal(size=(N, m, n))
    Q, R, terminal = (
        np.diag([1.0, 2.0, 0.0, 1.0]),
        np.array([[2.0, 0.3], [0.3, 1.0]]),
        np.diag([3.0, 1.0, 1.0, 0.0]),
    )
    found = time_varying_lqr(LinearSystem(A, B, 0.1), Q, R, terminal)
    assert found.K.shape == (N, n, m)
    assert found.P.shape == (N + 1, m, m)
    # States 0 to N as a linear function of the first state and all inputs.
    free, driven = [np.eye(m)], [np.zeros((m, N * n))]
    for k in range(N):
        push = A[k] @ driven[-1]
        push[:, k * n : (k + 1) * n] += B[k]
        free.append(A[k] @ free[-1])
        driven.append(push)
    weight = [Q] * N + [terminal]
    H = sum(G.T @ W @ G for G, W in zip(driven, weight, strict=True)) + np.kron(np.eye(N), R)
    cross = sum(G.T @ W @ F for G, F, W in zip(driven, free, weight, strict=True))
    inputs = -np.linalg.solve(H, cross)
    least = sum(F.T @ W @ F for F, W in zip(free, weight, strict=True)) + cross.T @ inputs
    assert_allclose(found.P[0], least, rtol=0, atol=1e-10 * np.abs(least).max())
    assert_allclose(-found.K[0], inputs[:n], rtol=0, atol=1e-10 * np.abs(inputs).max())


def test_far_from_the_end_of_a_constant_system_the_gains_are_those_of_going_on_forever(
    star: psp3.PSP3,
) -> None:
    """From a terminal weight of zero 1500 periods before the end.

    And at every period from the default one; 1e-9.
    """
    Q, R = weights(star)
    system = discretize(linearize(star, star.reference), PERIOD)
    steady = lqr(system, Q, R)
    constant = LinearSystem(
        np.repeat(system.A[np.newaxis], 1500, axis=0),
        np.repeat(system.B[np.newaxis], 1500, axis=0),
        PERIOD,
    )
    assert_allclose(
        time_varying_lqr(constant, Q, R, np.zeros((6, 6))).K[0],
        steady.K,
        rtol=0,
        atol=1e-9 * np.abs(steady.K).max(),
    )
    whole = time_varying_lqr(constant, Q, R)
    assert_allclose(
        whole.K,
        np.broadcast_to(steady.K, whole.K.shape),
        rtol=0,
        atol=1e-9 * np.abs(steady.K).max(),
    )
    assert_allclose(whole.P[0], steady.P, rtol=0, atol=1e-9 * np.abs(steady.P).max())


def test_time_varying_regulator_brings_the_robot_onto_the_helix(star: psp3.PSP3) -> None:
    """Released 5 mm off a helix and at rest.

    Of the speed it lacks, 63 mm/s, and the 5 mm less than 0.2 mm is left after 1.5 s.

    That is by how much a force that is held for 4 ms lags behind; it is double with double the
    period.
    """
    Q, R = weights(star)
    helix = Helix(robot=star)
    start = helix(0.0).heights + np.array([0.005, -0.005, 0.005])
    errors = []
    for period in (0.008, 0.004):
        controller = TimeVaryingLinearQuadraticRegulator(star, helix, 2.0, Q, R, period)
        result = psp3.simulate(star, controller, helix, 2.0, period, initial_positions=start)
        error = np.abs(result.heights - result.desired.heights)
        assert error[0].max() == pytest.approx(0.005)
        errors.append(error[result.t > 1.5].max())
    assert errors[1] < 2e-4
    assert 1.9 < errors[0] / errors[1] < 2.1


def test_gains_along_a_trajectory_are_those_of_its_samples(star: psp3.PSP3) -> None:
    """Of every period from its start on, and after the end the last ones.

    Against a system that is put together here.

    In floating-point numbers 0.6/0.1 is less than 6, and 0.3/0.1 less than 3.
    """
    Q, R = weights(star)
    helix = Helix(robot=star)
    controller = TimeVaryingLinearQuadraticRegulator(star, helix, 0.6, Q, R, 0.1)
    assert_allclose(controller.t, np.linspace(0.0, 0.6, 7), atol=1e-15)
    motion = helix(controller.t)
    system = discretize(linearize(star, motion.heights, motion.speeds, motion.accelerations), 0.1)
    K = time_varying_lqr(system, Q, R).K
    off = 1e-3 * np.arange(1.0, 7.0)
    for t, sample in ((0.0, 0), (0.0999, 0), (0.1, 1), (0.3, 3), (0.35, 3), (0.6, 6), (7.0, 6)):
        now = helix(t)
        forces = star.inverse_dynamics(now.heights, now.speeds, now.accelerations)
        found = controller.torque(t, now.heights + off[:3], now.speeds + off[3:], now)
        assert_allclose(found, forces - K[sample] @ off, rtol=1e-12)


@pytest.mark.parametrize("name", ["psp3", "five_bar"])
def test_deviation_from_a_trajectory_costs_less_than_with_the_gains_of_one_pose(name: str) -> None:
    """Cost of a small deviation, to 0.5 %.

    From runs to both sides of a wide, fast helix and of a fast swing of the cranks.

    A is constant for a period in the regulator's model, and forces that are held lag behind those
    of the trajectory.
    """
    robot = psp3.load(name)
    Q, R = weights(robot)
    n, period, duration = len(robot.actuated), 0.008, 0.8
    trajectory: Trajectory
    if name == "psp3":
        trajectory = Helix(radius=0.022, period=0.7, robot=robot)
    else:
        trajectory = PointToPoint(
            robot.reference, robot.reference + np.array([0.5, 0.3]), duration, robot=robot
        )
    varying = TimeVaryingLinearQuadraticRegulator(robot, trajectory, duration, Q, R, period)
    fixed = LinearQuadraticRegulator(robot, Q, R, period)
    deviation = 1e-5 * np.concatenate([np.linspace(-2.0, 2.0, n), np.linspace(30.0, -10.0, n)])
    start = trajectory(0.0)

    def cost(controller: Any) -> float:
        runs = [
            psp3.simulate(
                robot,
                controller,
                trajectory,
                duration,
                period,
                initial_positions=start.heights + sign * deviation[:n],
                initial_speeds=start.speeds + sign * deviation[n:],
            )
            for sign in (1.0, -1.0)
        ]
        states = 0.5 * np.hstack(
            [runs[0].heights - runs[1].heights, runs[0].speeds - runs[1].speeds]
        )
        forces = 0.5 * (runs[0].torque - runs[1].torque)
        return float(
            np.einsum("ki,ij,kj->", states, Q, states) + np.einsum("ki,ij,kj->", forces, R, forces)
        )

    best = cost(varying)
    assert_allclose(best, deviation @ varying.regulator.P[0] @ deviation, rtol=0.005)
    assert best < cost(fixed)


# Shapes and what is refused


def test_leading_dimensions_are_kept(star: psp3.PSP3) -> None:
    Q, R = weights(star)
    heights = np.random.default_rng(43).uniform(-0.05, 0.05, size=(2, 3, 3))
    for period in (None, 0.01):
        system = linearize(star, heights)
        system = system if period is None else discretize(system, period)
        whole = lqr(system, Q, R)
        assert (whole.K.shape, whole.P.shape, whole.poles.shape) == (
            (2, 3, 3, 6),
            (2, 3, 6, 6),
            (2, 3, 6),
        )
        assert_array_equal(
            whole.K[1, 2], lqr(LinearSystem(system.A[1, 2], system.B[1, 2], period), Q, R).K
        )


INTEGRATOR = LinearSystem(np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0], [1.0]]))
SAMPLED = discretize(INTEGRATOR, 0.1)


@pytest.mark.parametrize("period", [None, 0.1])
def test_weights_that_are_symmetric_but_for_rounding_are_made_symmetric(
    period: float | None,
) -> None:
    """By 1e-13 of their size, as a product of matrices may be: the gains are those without."""
    system = INTEGRATOR if period is None else discretize(INTEGRATOR, period)
    Q = np.array([[2.0, 0.5], [0.5, 1.0]])
    uneven = Q + np.array([[0.0, 2e-13], [0.0, 0.0]])
    assert_allclose(lqr(system, uneven, [[1.0]]).K, lqr(system, Q, [[1.0]]).K, rtol=1e-11)
    assert_array_equal(
        time_varying_lqr(
            LinearSystem(np.eye(2)[np.newaxis], np.zeros((1, 2, 1)), 0.1), Q, [[1.0]], uneven
        ).P[-1],
        0.5 * (uneven + uneven.T),
    )


BAD_WEIGHTS = [
    (np.eye(3), np.eye(1), InvalidArray, "Q"),
    (np.eye(2), np.eye(2), InvalidArray, "R"),
    (1.0, np.eye(1), InvalidArray, "Q"),
    (np.eye(2), 1.0, InvalidArray, "R"),
    (np.full((2, 2), np.nan), np.eye(1), InvalidArray, "Q"),
    ("Q", np.eye(1), InvalidArray, "Q"),
    (np.array([[1.0, 0.5], [0.0, 1.0]]), np.eye(1), InvalidValue, "Q must be symmetric"),
    (np.diag([1.0, -1.0]), np.eye(1), InvalidValue, "positive semidefinite"),
    (np.eye(2), np.zeros((1, 1)), InvalidValue, "R must be positive definite"),
]


@pytest.mark.parametrize("system", [INTEGRATOR, SAMPLED], ids=["continuous", "sampled"])
@pytest.mark.parametrize(("Q", "R", "error", "message"), BAD_WEIGHTS)
def test_weights_that_are_none_are_refused(
    system: LinearSystem, Q: Any, R: Any, error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        lqr(system, Q, R)


@pytest.mark.parametrize(
    ("A", "B", "Q"),
    [
        # the input does not reach what grows
        (np.diag([1.0, -1.0]), np.array([[0.0], [1.0]]), np.eye(2)),
        # Q does not see where it drifts
        (np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0], [1.0]]), np.diag([0.0, 1.0])),
    ],
)
@pytest.mark.parametrize("period", [None, 0.1])
def test_what_cannot_be_made_stable_is_refused(
    A: Array, B: Array, Q: Array, period: float | None
) -> None:
    system = LinearSystem(A, B) if period is None else discretize(LinearSystem(A, B), period)
    with pytest.raises(NoStabilizingSolution, match="no regulator") as caught:
        lqr(system, Q, np.eye(1))
    assert caught.value.period == period


def test_recursion_refuses_what_is_not_a_sampled_system_of_some_periods() -> None:
    one = LinearSystem(SAMPLED.A[np.newaxis], SAMPLED.B[np.newaxis], 0.1)
    with pytest.raises(InvalidValue, match="sampled"):
        time_varying_lqr(one._replace(period=None), np.eye(2), np.eye(1))
    with pytest.raises(InvalidArray):
        time_varying_lqr(SAMPLED, np.eye(2), np.eye(1))
    with pytest.raises(InvalidArray):
        time_varying_lqr(
            LinearSystem(np.zeros((0, 2, 2)), np.zeros((0, 2, 1)), 0.1), np.eye(2), np.eye(1)
        )
    with pytest.raises(InvalidValue, match="terminal"):
        time_varying_lqr(one, np.eye(2), np.eye(1), -np.eye(2))


def test_controllers_refuse_what_is_malformed(star: psp3.PSP3) -> None:
    Q, R = weights(star)
    for arguments in (
        (np.eye(3), R),
        (Q, np.eye(2)),
        (Q, R, 0.0),
        (Q, R, 0.002, [0.0, np.nan, 0.0]),
        (Q, R, 0.002, np.zeros(2)),
    ):
        with pytest.raises((InvalidArray, InvalidValue)):
            LinearQuadraticRegulator(star, *arguments)
    for duration, period in ((0.0, 0.002), (np.nan, 0.002), (1.0, -1.0)):
        with pytest.raises(InvalidValue):
            TimeVaryingLinearQuadraticRegulator(star, Helix(robot=star), duration, Q, R, period)


def test_a_regulator_of_ones_own_runs_in_python(star: psp3.PSP3) -> None:
    """The compiled loop would pass over what a derived class changes.

    To the rounding by which both loops differ.
    """

    class Halved(LinearQuadraticRegulator):
        def torque(self, t: float, positions: Array, speeds: Array, desired: Motion) -> Array:
            return 0.5 * super().torque(t, positions, speeds, desired)

    class HalvedOnTheWay(TimeVaryingLinearQuadraticRegulator):
        def torque(self, t: float, positions: Array, speeds: Array, desired: Motion) -> Array:
            return 0.5 * super().torque(t, positions, speeds, desired)

    helix = Helix(robot=star)
    for whole, half in (
        (
            LinearQuadraticRegulator(star, *weights(star), PERIOD),
            Halved(star, *weights(star), PERIOD),
        ),
        (
            TimeVaryingLinearQuadraticRegulator(star, helix, 0.1, *weights(star), PERIOD),
            HalvedOnTheWay(star, helix, 0.1, *weights(star), PERIOD),
        ),
    ):
        first = [psp3.simulate(star, one, helix, 0.05, PERIOD).torque[0] for one in (whole, half)]
        assert_allclose(first[1], 0.5 * first[0], rtol=1e-12)
