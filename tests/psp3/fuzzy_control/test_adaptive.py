"""The adaptive controller.

Against batch least squares over a whole run, the trained controller, and robots that it does not
know.
"""

from __future__ import annotations

import dataclasses
import math
from functools import cache
from typing import Any

import numpy as np
import pytest

import psp3
from fuzzy2.learning.adaptation_kernels import settle, solve
from psp3.control.controller import Widths
from psp3.drives import NO_DRIVE
from psp3.errors import InvalidArray, InvalidValue, NotTrained
from psp3.fuzzy_control import adaptive_kernels as kernels
from psp3.fuzzy_control.adaptive import (
    LEAST_SHARE_OF_MASS,
    UPDATE_PERIOD,
    AdaptiveFuzzyComputedTorque,
    trained_rules,
)
from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
from psp3.fuzzy_control.records import Record, differences, pack, record, unpack
from psp3.simulation import Result, simulate
from psp3.simulation.loop import compiled_loop, new_track, unbounded
from psp3.simulation.metrics import sum_of_squared_errors
from psp3.simulation.runge_kutta import RungeKutta
from psp3.three_psp.robot import PSP3
from psp3.three_psp.stepping import ClosedFormSteps
from psp3.trajectories import Helix, Motion

PERIOD = 0.002


@cache
def robot() -> PSP3:
    return psp3.load("psp3")


@cache
def loaded(payload: float) -> PSP3:
    parameters = robot().parameters
    return psp3.load(
        "psp3", parameters=dataclasses.replace(parameters, star_mass=parameters.star_mass + payload)
    )


def adaptive_run(
    controller: AdaptiveFuzzyComputedTorque,
    plant: np.ndarray,
    desired: np.ndarray,
    state: np.ndarray,
    start: float,
    measured: np.ndarray,
    samples: np.ndarray,
) -> int:
    """Write states and what the controller says (N, 17) of a compiled run, and its last state."""
    motion = Motion(*(desired[:, i : i + 3] for i in (0, 3, 6, 0)))
    track = new_track(start + PERIOD * np.arange(len(desired)), motion, controller.numbers_said)
    noise = measured if len(measured) else None
    ended = compiled_loop(
        controller.table(None, Widths.of_motors(3)),
        ClosedFormSteps(plant, 1, NO_DRIVE),
        unbounded(PERIOD, np.zeros(3), noise=noise),
        track,
        state,
    )
    state[:] = ended.state
    samples[:] = np.concatenate([track.states, track.wrote], axis=1)
    return ended.samples


@cache
def recorded() -> Record:
    return record(robot(), Helix(robot=robot()))


@cache
def trained(kind: str = "t1", **options: Any) -> FuzzyComputedTorque:
    variation = 0.1 if kind == "it2" else None
    return FuzzyComputedTorque(kind, robot(), mean_variation=variation, **options).learn(
        recorded(), rng=np.random.default_rng(0)
    )


@cache
def run(kind: str, payload: float, adaptive: bool, duration: float = 4.0) -> Result:
    controller = AdaptiveFuzzyComputedTorque(trained(kind)) if adaptive else trained(kind)
    return simulate(loaded(payload), controller, Helix(robot=robot()), duration)


def memory_after(controller: AdaptiveFuzzyComputedTorque, result: Result) -> kernels.Memory:
    """Show the controller a run that is over, and return what it remembers of it."""
    controller.reset()
    for k, now in enumerate(map(Motion._make, zip(*result.desired, strict=True))):
        torque = controller.torque(result.t[k], result.heights[k], result.speeds[k], now)
        np.testing.assert_array_equal(torque, result.torque[k])
    return controller._memory


# What is learned


@pytest.mark.parametrize("memory", [0.3, 2.0])
def test_what_is_learned_is_batch_least_squares_over_the_run(memory: float) -> None:
    """By singular values of the filtered rows of all periods, and the prior's.

    Rows are weighted with their age.

    The basis functions come from the system's firing, the filter is a sum over all earlier rows,
    and everything is taken at the middle of its period. 1e-7 kg and N: numbers of 100, a prior of
    1e-4, and squares of both in the one that is solved recursively.
    """
    base = trained("t1")
    controller = AdaptiveFuzzyComputedTorque(base, memory=memory)
    result = simulate(loaded(2.0), controller, Helix(robot=robot()), 0.6)
    count = len(result.t) - 1
    a, v = (0.5 * (x[1:] + x[:-1]) for x in (result.heights, result.speeds))
    rise = np.diff(result.speeds, axis=0) / PERIOD
    firing = base.system_.firing(np.clip(differences(a, v), *base.ranges_))[..., 0]
    phi = firing / firing.sum(axis=1, keepdims=True)
    consequents = np.asarray(base.system_.consequents)
    M, C, G = unpack(phi @ consequents)
    missed = (
        result.torque[:-1] - np.einsum("nij,nj->ni", M, rise) - np.einsum("nij,nj->ni", C, v) - G
    )
    # Outputs that adapt: M's upper triangle, then G; entry (i, j) of M is number a (5 - a) / 2 + b.
    factors = np.zeros((count, 3, 9))
    for i in range(3):
        for j in range(3):
            factors[:, i, min(i, j) * (5 - min(i, j)) // 2 + max(i, j)] = rise[:, j]
        factors[:, i, 6 + i] = 1.0
    rows = (factors[..., np.newaxis] * phi[:, np.newaxis, np.newaxis, :]).reshape(count, 3, -1)
    blend = 1.0 - math.exp(-PERIOD / controller.lag)
    age = np.arange(count)[:, np.newaxis] - np.arange(count)
    lowpass = np.where(age >= 0, blend * (1.0 - blend) ** np.maximum(age, 0), 0.0)
    rows, missed = np.einsum("nm,mik->nik", lowpass, rows), lowpass @ missed
    # The last solution is that of the last multiple of ten periods.
    last = 10 * (count // round(UPDATE_PERIOD / PERIOD))
    weights = np.sqrt(PERIOD * np.exp(-PERIOD / memory) ** np.arange(last - 1, -1, -1))
    matrix = np.concatenate(
        [
            (weights[:, np.newaxis, np.newaxis] * rows[:last]).reshape(3 * last, -1),
            np.diag(np.sqrt(controller.rules.prior)),
        ]
    )
    right = np.concatenate([(weights[:, np.newaxis] * missed[:last]).ravel(), np.zeros(9 * 16)])
    expected = np.linalg.lstsq(matrix, right, rcond=None)[0].reshape(9, 16)
    assert (np.abs(expected).max(axis=1) > 1e-3).all()
    moved = (controller.consequents - consequents).T
    np.testing.assert_allclose(moved[[0, 1, 2, 3, 4, 5, 15, 16, 17]], expected, rtol=0.0, atol=1e-7)
    np.testing.assert_array_equal(moved[6:15], 0.0)


def test_no_acceleration_is_needed_to_know_the_mean_of_a_period() -> None:
    """With the exact M, C and G at the middle of a period the torque comes out to the second order.

    A period half as long, a quarter.
    """
    errors = []
    for period in (PERIOD, 0.5 * PERIOD):
        result = simulate(
            robot(), psp3.ComputedTorque(robot()), Helix(period=0.5, robot=robot()), 0.5, period
        )
        a, v = (0.5 * (x[1:] + x[:-1]) for x in (result.heights, result.speeds))
        torque = robot().inverse_dynamics(a, v, np.diff(result.speeds, axis=0) / period)
        errors.append(np.abs(torque - result.torque[:-1]).max())
    assert errors[0] < 1e-2
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)


@pytest.mark.parametrize("kind", ["t1", "it2"])
def test_a_payload_is_learned(kind: str) -> None:
    """It leaves less than a fifth of the squared error in four seconds.

    G rises by the weight, a third of it on each screw.

    Within 1 N of 6.5 N: what the rules cannot say of the pose is in there, too.
    """
    alone, adapted = run(kind, 2.0, False), run(kind, 2.0, True)
    assert sum_of_squared_errors(adapted) < 0.05 * sum_of_squared_errors(alone)
    controller = AdaptiveFuzzyComputedTorque(trained(kind))
    memory_after(controller, adapted)
    late = slice(-500, None)
    inputs = np.clip(
        differences(adapted.heights[late], adapted.speeds[late]), *trained(kind).ranges_
    )
    system = type(trained(kind).system_)(
        trained(kind).system_.inputs, trained(kind).system_.rules, controller.consequents
    )
    rise = (system(inputs) - trained(kind).system_(inputs))[:, 15:].mean(axis=0)
    np.testing.assert_allclose(rise, 2.0 * 9.81 / 3.0, atol=1.0)


def test_without_mismatch_it_does_no_harm() -> None:
    assert sum_of_squared_errors(run("t1", 0.0, True)) < 1.05 * sum_of_squared_errors(
        run("t1", 0.0, False)
    )


@pytest.mark.parametrize("kind", ["t1", "it2"])
def test_with_boundless_trust_it_is_the_trained_controller(kind: str) -> None:
    """1e-9 N: torques are sums of the same numbers in another order.

    The trust is a million times the squares of a run.
    """
    controller, base = AdaptiveFuzzyComputedTorque(trained(kind), trust=1e12), trained(kind)
    result = run(kind, 2.0, False)
    for k in range(0, len(result.t), 37):
        now = Motion(*(array[k] for array in result.desired))
        torque = controller.torque(result.t[k], result.heights[k], result.speeds[k], now)
        np.testing.assert_allclose(
            torque, base.torque(0.0, result.heights[k], result.speeds[k], now), rtol=0.0, atol=1e-9
        )
        np.testing.assert_allclose(
            controller.torque_interval, base.torque_interval, rtol=0.0, atol=1e-9
        )
        assert controller.covered == base.covered
        assert not controller.fell_back


def test_the_torque_is_the_middle_of_its_interval() -> None:
    """Type-2 keeps its width while it adapts; that of type-1 is none, but for rounding."""
    for kind in ("t1", "it2"):
        result = run(kind, 2.0, True)
        low, high = np.moveaxis(result.torque_interval, -1, 0)
        np.testing.assert_allclose(0.5 * (low + high), result.torque, rtol=0.0, atol=1e-9)
        assert (high - low >= 0.0).all()
        assert ((high - low).min() > 0.1) == (kind == "it2")
    assert np.ptp(run("t1", 2.0, True).torque_interval, axis=-1).max() < 1e-9


# Robustness


def test_consequents_stay_in_reach_whatever_comes_in() -> None:
    """Heights and speeds that jump at random, which no forces explain.

    M stays above its share of the trained one without falling back.
    """
    controller = AdaptiveFuzzyComputedTorque(trained("t1"), reach=0.3)
    rng = np.random.default_rng(0)
    desired = Motion(np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3))
    bounds = controller.rules.reach.reshape(9, 16)
    consequents = np.asarray(trained("t1").system_.consequents)
    was_at_reach = False
    for k in range(600):
        torque = controller.torque(
            PERIOD * k, rng.normal(0.0, 0.05, 3), rng.normal(0.0, 0.3, 3), desired
        )
        assert np.isfinite(torque).all()
        moved = (controller.consequents - consequents).T[[0, 1, 2, 3, 4, 5, 15, 16, 17]]
        assert (np.abs(moved) <= bounds + 1e-12).all()
        assert not controller.fell_back
        was_at_reach |= controller.at_reach
    assert was_at_reach
    mean_weight = np.abs(consequents[:, 15:]).mean()
    np.testing.assert_allclose(bounds[6:], 0.3 * mean_weight, rtol=1e-12)
    # The bound on M is what a rank-one change of equal entries can take of the smallest eigenvalue.
    smallest = np.linalg.eigvalsh(unpack(consequents.mean(axis=0))[0])[0]
    np.testing.assert_allclose(3.0 * bounds[:6], (1.0 - LEAST_SHARE_OF_MASS) * smallest, rtol=1e-12)


def test_a_mass_matrix_that_is_too_small_gives_way_to_the_trained_rules() -> None:
    """Consequents are put there by hand; the box does not let it come to this."""
    controller = AdaptiveFuzzyComputedTorque(trained("it2"))
    controller._memory.consequents[:12] *= 0.2
    a, v = recorded().heights[100], recorded().speeds[100]
    desired = Motion(a, v, np.ones(3), a)
    torque = controller.torque(0.0, a, v, desired)
    assert controller.fell_back
    np.testing.assert_allclose(
        torque, trained("it2").torque(0.0, a, v, desired), rtol=0.0, atol=1e-9
    )
    controller.reset()
    controller._memory.consequents[:12] *= 0.3
    controller.torque(0.0, a, v, desired)
    assert not controller.fell_back


def test_at_rest_nothing_winds_up() -> None:
    """Eight seconds in one pose under a wrong weight.

    Its forces are learned, and all of M stays near what was trained.

    And nothing goes on to grow: eight seconds later, four times the memory, all is where it was,
    but for 2 % of what the way there taught.
    """
    controller = AdaptiveFuzzyComputedTorque(trained("t1", kp=100.0, kv=20.0))
    desired = Motion(
        *(np.asarray(x, dtype=float) for x in ([0.0, 0.05, -0.05], [0.0] * 3, [0.0] * 3, [0.0] * 3))
    )
    plant = loaded(2.0).parameters.as_array()
    state, wanted = (
        np.concatenate([desired.heights, np.zeros(3)]),
        np.tile(np.concatenate(desired[:3]), (4001, 1)),
    )
    samples = np.empty((4001, 6 + 11))
    seen = []
    for part in range(2):
        adaptive_run(
            controller,
            plant,
            wanted,
            state,
            8.0 * part,
            np.empty((0, 6)),
            samples,
        )
        seen.append(controller.consequents)
    np.testing.assert_allclose(state[:3], desired.heights, atol=1e-5)
    np.testing.assert_allclose(seen[1], seen[0], atol=0.02 * 0.2)
    assert not controller.at_reach
    assert np.abs(seen[0] - np.asarray(trained("t1").system_.consequents))[:, :6].max() < 0.2


def test_noise_of_measurement_disturbs_little() -> None:
    """10 µm and 1 mm/s, white: in a period that is an acceleration of 0.7 m/s², 6 N on a screw.

    The torque it makes is a tenth of that.
    """
    controller = AdaptiveFuzzyComputedTorque(trained("t1"))
    t = PERIOD * np.arange(3001)
    motion = Helix(robot=robot())(t)
    desired = np.concatenate([motion.heights, motion.speeds, motion.accelerations], axis=1)
    noise = np.random.default_rng(0).standard_normal((len(t), 6)) * np.repeat([1e-5, 1e-3], 3)
    runs = []
    for measured in (np.empty((0, 6)), noise):
        controller.reset()
        samples, state = np.empty((len(t), 17)), np.concatenate([motion.heights[0], np.zeros(3)])
        done = adaptive_run(
            controller,
            loaded(2.0).parameters.as_array(),
            desired,
            state,
            0.0,
            measured,
            samples,
        )
        assert done == len(t)
        runs.append(samples[1000:, 6:9])
    assert np.sqrt(np.mean((runs[1] - runs[0]) ** 2)) < 0.6


def test_the_least_squares_within_the_box_are_the_ones_that_are_found() -> None:
    """By SciPy's bounded solver.

    Coordinate descent stops where no sweep moves anything, 1e-9 for the condition of the problem.
    """
    optimize = pytest.importorskip("scipy.optimize")
    rng = np.random.default_rng(0)
    for _ in range(10):
        rows, targets, prior = (
            rng.normal(size=(20, 8)),
            3.0 * rng.normal(size=20),
            rng.uniform(0.1, 1.0, 8),
        )
        bound = rng.uniform(0.1, 1.0, 8)
        matrix = np.concatenate([rows, np.diag(np.sqrt(prior))])
        expected = optimize.lsq_linear(
            matrix,
            np.concatenate([targets, np.zeros(8)]),
            (-bound, bound),
            method="bvls",
            tol=1e-14,
        ).x
        out, whole = np.zeros(8), np.empty((8, 8))
        information, right = np.triu(rows.T @ rows), rows.T @ targets
        settle(information, right, prior, -bound, bound, 10_000, whole, np.empty(8), out)
        np.testing.assert_allclose(out, expected, atol=1e-9)
        assert (np.abs(out) == bound).any()
        assert solve(information, right, prior, whole, out)
        np.testing.assert_allclose(
            out, np.linalg.solve(rows.T @ rows + np.diag(prior), right), atol=1e-12
        )


# The protocol of controllers


@pytest.mark.parametrize("kind", ["t1", "it2"])
def test_the_compiled_run_is_the_simulation(kind: str) -> None:
    """To the last bit: the same kernels in the same order, called from Python here and there."""

    class InPython(RungeKutta):
        """A plant that the compiled loop does not know."""

    result = simulate(
        robot(),
        AdaptiveFuzzyComputedTorque(trained(kind)),
        Helix(robot=robot()),
        1.0,
        plant=InPython(loaded(2.0)),
    )
    controller = AdaptiveFuzzyComputedTorque(trained(kind))
    desired = np.concatenate(
        [result.desired.heights, result.desired.speeds, result.desired.accelerations], axis=1
    )
    samples, state = np.empty((len(result.t), 17)), np.concatenate([result.heights[0], np.zeros(3)])
    done = adaptive_run(
        controller,
        loaded(2.0).parameters.as_array(),
        desired,
        state,
        0.0,
        np.empty((0, 6)),
        samples,
    )
    assert done == len(result.t)
    np.testing.assert_array_equal(samples[:, 0:3], result.heights)
    np.testing.assert_array_equal(samples[:, 6:9], result.torque)
    np.testing.assert_array_equal(
        samples[:, 9:15].reshape(-1, 2, 3).swapaxes(1, 2), result.torque_interval
    )
    np.testing.assert_array_equal(samples[:, 15] > 0.0, result.covered)


def test_reset_forgets_everything() -> None:
    controller = AdaptiveFuzzyComputedTorque(trained("t1"))
    first, second = (simulate(loaded(2.0), controller, Helix(robot=robot()), 0.5) for _ in range(2))
    np.testing.assert_array_equal(first.torque, second.torque)
    controller.reset()
    np.testing.assert_array_equal(controller.consequents, trained("t1").system_.consequents)
    assert np.isnan(controller.torque_interval).all()
    np.testing.assert_array_equal(
        trained_rules(trained("t1"), 1.0, 0.5).trained[::2].T, trained("t1").system_.consequents
    )


def test_a_call_at_the_same_time_learns_nothing() -> None:
    controller = AdaptiveFuzzyComputedTorque(trained("t1"))
    a = np.array([0.0, 0.01, 0.02])
    desired = Motion(a, np.zeros(3), np.zeros(3), a)
    one, other = (controller.torque(1.0, a, np.zeros(3), desired) for _ in range(2))
    np.testing.assert_array_equal(one, other)
    assert controller._memory.clock[kernels.SINCE_UPDATE] == 0.0
    controller.torque(1.0 + PERIOD, a, np.zeros(3), desired)
    assert controller._memory.clock[kernels.SINCE_UPDATE] == pytest.approx(PERIOD)


@pytest.mark.parametrize(
    ("t", "heights", "speeds"),
    [
        (math.nan, [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
        (math.inf, [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
        (1.0, [math.nan, 0.0, 0.0], [0.0, 0.0, 0.0]),
        (1.0, [0.0, 0.0, 0.0], [0.0, math.inf, 0.0]),
        (1.0, [0.0, 0.0], [0.0, 0.0, 0.0]),
        (1.0, "abc", [0.0, 0.0, 0.0]),
    ],
)
def test_what_is_no_state_is_refused_and_nothing_learned_from(
    t: float, heights: Any, speeds: Any
) -> None:
    controller = AdaptiveFuzzyComputedTorque(trained("t1"))
    good = Motion(*(np.zeros(3) for _ in range(4)))
    controller.torque(0.0, np.zeros(3), np.zeros(3), good)
    before = [np.array(array) for array in controller._memory]
    with pytest.raises((InvalidValue, InvalidArray)):
        controller.torque(t, heights, speeds, good)
    with pytest.raises(InvalidArray):
        controller.torque(
            1.0, np.zeros(3), np.zeros(3), good._replace(accelerations=np.full(3, math.nan))
        )
    for array, old in zip(controller._memory, before, strict=True):
        np.testing.assert_array_equal(array, old)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"memory": 0.0}, "memory"),
        ({"memory": math.nan}, "memory"),
        ({"trust": 0.0}, "trust"),
        ({"reach": 0.0}, "reach"),
        ({"reach": 1.0}, "above 0 and below 1"),
        ({"lag": -1.0}, "lag"),
    ],
)
def test_parameters_that_cannot_be_meant_are_refused(options: dict[str, float], words: str) -> None:
    with pytest.raises(InvalidValue, match=words):
        AdaptiveFuzzyComputedTorque(trained("t1"), **options)


def test_controllers_that_cannot_adapt_are_refused() -> None:
    with pytest.raises(NotTrained):
        AdaptiveFuzzyComputedTorque(FuzzyComputedTorque("t1", robot()))
    for other in (
        FuzzyComputedTorque("gt2", robot()),
        FuzzyComputedTorque("t1", robot(), outside="crisp"),
        psp3.ComputedTorque(robot()),
    ):
        with pytest.raises(InvalidValue, match='"t1" or "it2" with outside="clamp"'):
            AdaptiveFuzzyComputedTorque(other)  # type: ignore[arg-type]
    assert pack(*unpack(trained("t1").fallback_)).shape == (18,)
    assert repr(AdaptiveFuzzyComputedTorque(trained("t1"))).endswith(
        "16 rules), memory=2, trust=0.0001, reach=0.5, lag=0.05)"
    )
