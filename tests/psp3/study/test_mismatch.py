"""The comparison on robots that are not what controllers believe.

Its loops against the simulation, its pairs, and who wins.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

import psp3
from psp3.checks import Array
from psp3.control.controller import Controller
from psp3.control.linear_quadratic_regulator import LinearQuadraticRegulator
from psp3.drives import Drive
from psp3.errors import InvalidValue, UnknownName
from psp3.fuzzy_control.adaptive import AdaptiveFuzzyComputedTorque
from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
from psp3.simulation import Result, simulate
from psp3.simulation.metrics import sum_of_squared_errors
from psp3.simulation.runge_kutta import RungeKutta
from psp3.study import mismatch
from psp3.study.mismatch import CONTROLLERS, Case, Comparison, Outcome, compare, run, simulate_run
from psp3.study.run import TRAJECTORIES, mismatched
from psp3.trajectories import Motion


class WithIntegral:
    """Computed torque with an integral, written out."""

    def __init__(self, model: psp3.PSP3, kp: float, kv: float, ki: float) -> None:
        self.model, self.kp, self.kv, self.ki = model, kp, kv, ki
        self.reset()

    def reset(self) -> None:
        """Forget all errors."""
        self.times: list[float] = []
        self.errors: list[Array] = []

    def torque(self, t: float, heights: Array, speeds: Array, desired: Motion) -> Array:
        """Integrate all errors so far by the trapezoidal rule, and return the forces."""
        self.times.append(t)
        self.errors.append(desired.heights - heights)
        integral = np.trapezoid(self.errors, self.times, axis=0)
        servo = (
            desired.accelerations
            + self.kv * (desired.speeds - speeds)
            + self.kp * self.errors[-1]
            + self.ki * integral
        )
        return np.asarray(self.model.inverse_dynamics(heights, speeds, servo))


def controller(name: str, snr_db: float, seed: int) -> Controller:
    """Return a controller of the comparison, made from what the package offers."""
    robot = psp3.load("psp3")
    if name == "ctc":
        return psp3.ComputedTorque(robot, 10.0, 1.0)
    if name == "ctc-integral":
        return WithIntegral(robot, 10.0, 1.0, 3.0)
    if name.startswith("lqr"):
        force = 10.0 if name == "lqr-stiff" else 1.0
        return LinearQuadraticRegulator(robot, np.diag([1e4] * 3 + [1e2] * 3), np.eye(3) / force**2)
    base = FuzzyComputedTorque(
        name.removeprefix("adaptive-"),
        robot,
        snr_db=snr_db,
        mean_variation=float(psp3_variation(snr_db)),
    )
    base.fit(TRAJECTORIES["helix"](robot), rng=np.random.default_rng([seed, 0]))
    return AdaptiveFuzzyComputedTorque(base) if name.startswith("adaptive") else base


def psp3_variation(snr_db: float) -> float:
    """0.4 / (1 + 10**((S - 30) / 20)), of 20 dB where there is no noise."""
    return 0.4 / (1.0 + 10.0 ** ((min(snr_db, 20.0) - 30.0) / 20.0))


@cache
def simulated(case: Case, name: str, seed: int, duration: float) -> Result:
    believed = psp3.load("psp3")
    parameters = mismatched(
        believed.parameters, 0.05, case.payload, np.random.default_rng([seed, 1])
    )
    plant = RungeKutta(psp3.load("psp3", parameters=parameters), drive=case.drive)
    return simulate(
        believed,
        controller(name, case.snr_db, seed),
        TRAJECTORIES[case.trajectory](believed),
        duration,
        plant=plant,
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", CONTROLLERS)
@pytest.mark.parametrize(
    "case",
    [
        Case(2.0, "waypoints", 20.0),
        Case(1.0, drive=Drive(coulomb_friction=3.0, viscous_friction=5.0)),
    ],
    ids=["noisy", "driven"],
)
def test_runs_are_those_of_the_simulation(
    name: str, case: Case, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without noise of measurement, which the simulation does not have.

    1e-9 m: sums of the torque have another order, which feedback does not amplify; dry friction,
    which jumps, is the reason for 1e-7.
    """
    monkeypatch.setattr(mismatch, "MEASUREMENT_NOISE", (0.0, 0.0))
    samples = simulate_run(case, name, 3, 0.5)
    result = simulated(case, name, 3, 0.5)
    tolerance = 1e-9 if case.drive == Drive() else 1e-7
    np.testing.assert_allclose(samples[:, :3], result.heights, rtol=0.0, atol=tolerance)
    np.testing.assert_allclose(samples[:, 6:], result.torque, rtol=0.0, atol=1e3 * tolerance)
    outcome = run(case, name, 3, 0.5)
    assert outcome.error == pytest.approx(sum_of_squared_errors(result), rel=1e-4)
    error = result.desired.heights - result.heights
    assert outcome.settled == pytest.approx(
        math.sqrt((error[125:] ** 2).sum(axis=1).mean()), rel=1e-4
    )
    assert outcome.effort == pytest.approx((result.torque**2).sum(axis=1).mean(), rel=1e-4)


def test_runs_of_one_seed_see_the_same_noise_and_others_do_not() -> None:
    """White noise on speeds goes through kv M = 9.3 N s/m.

    Torques of two runs of one seed are the same, those of two seeds are not.
    """
    case = Case(1.0)
    first, again, other = (simulate_run(case, "ctc", seed, 0.1) for seed in (0, 0, 1))
    np.testing.assert_array_equal(first, again)
    assert np.abs(first[:, 6:] - other[:, 6:]).max() > 1e-3
    without = simulate_run(case, "lqr", 0, 0.1)
    assert np.abs(without[:, 6:] - first[:, 6:]).max() > 1e-3


def test_a_comparison_does_not_depend_on_threads_and_does_what_does_not_differ_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    done: list[tuple[Case, str, int]] = []

    def counted(case: Case, name: str, seed: int, duration: float) -> Outcome:
        done.append((case, name, seed))
        return run(case, name, seed, duration)

    options: dict[str, Any] = {
        "payloads": (2.0,),
        "trajectories": ("helix",),
        "snrs_db": (math.inf, 20.0),
        "seeds": 2,
        "duration": 0.2,
    }
    names = ("ctc", "t1")
    one = compare(**options, controllers=names, workers=1)
    monkeypatch.setattr(mismatch, "run", counted)
    other = compare(**options, controllers=names, workers=3)
    assert one.outcomes == other.outcomes
    # Computed torque sees no records: two seeds of it, and four of the fuzzy controller.
    assert sorted(name for _, name, _ in done) == ["ctc"] * 2 + ["t1"] * 4
    exact, noisy = one.cases
    np.testing.assert_array_equal(one.values(exact, "ctc"), one.values(noisy, "ctc"))
    assert (one.values(exact, "t1") != one.values(noisy, "t1")).all()


def test_adaptive_type_1_wins_under_a_payload_and_its_interval_says_so() -> None:
    """Three seeds of five seconds.

    The settled error is less than half of every other one's, and type-2 comes second.
    """
    found = compare((2.0,), ("helix",), (math.inf,), 3, duration=5.0)
    (case,) = found.cases
    assert found.best(case, "settled") == ("adaptive-t1",)
    for name in CONTROLLERS:
        if name != "adaptive-t1":
            assert found.ratio(case, "adaptive-t1", name, "settled").high < 0.7
    order = sorted(CONTROLLERS, key=lambda name: found.values(case, name, "settled").mean())
    assert order[:3] == ["adaptive-t1", "adaptive-it2", "lqr-stiff"]
    rows = {row.controller: row for row in found.rows()}
    assert rows["ctc"].error.count == 3
    assert rows["ctc"].error.value == pytest.approx(found.values(case, "ctc").mean())
    assert rows["ctc"].diverged.value == 0.0
    # As stiff as computed torque, it is off by about as much.
    assert 0.7 < rows["lqr"].settled.value / rows["ctc"].settled.value < 1.0


def outcome(settled: float, diverged: bool = False) -> Outcome:
    return Outcome(settled**2, settled, 1.0, diverged)


def test_best_are_the_least_and_those_not_shown_to_be_worse() -> None:
    """Made-up runs: in pairs what is always 10 % worse is worse.

    However much the seeds differ.
    """
    case = Case(1.0)
    seeds = [1.0, 5.0, 2.0, 8.0]
    worse, alike = [1.1 * x for x in seeds], [1.3, 4.8, 1.9, 8.3]
    table = {
        (case, "ctc"): tuple(map(outcome, seeds)),
        (case, "lqr"): tuple(map(outcome, worse)),
        (case, "t1"): tuple(map(outcome, alike)),
        (case, "it2"): (outcome(0.1), outcome(math.nan, True), outcome(0.1), outcome(0.1)),
    }
    found = Comparison((case,), ("ctc", "lqr", "t1", "it2"), table)
    assert found.best(case, "settled") == ("ctc", "t1")
    assert found.ratio(case, "lqr", "ctc", "settled").value == pytest.approx(1.1)
    assert found.rows()[3].diverged.value == 0.25
    assert found.rows()[3].settled.count == 3
    header, rule, line = found.markdown(scale=1.0).splitlines()
    assert header == "| kg | path | records | ctc | lqr | t1 | it2 |"
    assert rule == "|---" * 7 + "|"
    assert (
        line == f"| 1 | helix | exact | **4** | 4.4 | **{np.mean(alike):.3g}** | 0.1, 1 diverged |"
    )
    header, _, line = found.ratios([("lqr", "ctc"), ("t1", "ctc")]).splitlines()
    assert header == "| kg | path | records | lqr / ctc | t1 / ctc |"
    ratio = found.ratio(case, "t1", "ctc", "settled")
    # A ratio that is the same in every pair has an interval without width.
    assert line == (
        f"| 1 | helix | exact | 1.1 (1.1 to 1.1) | {ratio.value:.3g} ({ratio.low:.3g} to "
        f"{ratio.high:.3g}) |"
    )
    assert ratio.low < 1.0 < ratio.high
    lost = Comparison((case,), ("it2",), {(case, "it2"): table[case, "it2"]})
    assert lost.best(case) == ()


def test_a_run_that_diverges_says_so() -> None:
    """With 20 kg more than it believes, the integral's loop is unstable.

    The robot leaves its poses after some seconds.
    """
    lost = run(Case(20.0), "ctc-integral", 0)
    assert lost.diverged
    assert math.isnan(lost.error)
    assert len(simulate_run(Case(20.0), "ctc-integral", 0)) < 5201


def test_cases_say_what_they_are() -> None:
    assert str(Case(2.0, "waypoints", 20.0)) == "2 kg, waypoints, records of 20 dB"
    assert str(Case(drive=Drive(coulomb_friction=1.0))) == "0 kg, helix, exact records, driven"


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"payloads": (-1.0,)}, InvalidValue, "payload"),
        ({"payloads": (math.nan,)}, InvalidValue, "payload"),
        ({"trajectories": ("spiral",)}, UnknownName, "helix"),
        ({"snrs_db": (-200.0,)}, InvalidValue, "snr_db"),
        ({"seeds": 1}, InvalidValue, "seeds"),
        ({"seeds": 2.0}, InvalidValue, "seeds"),
        ({"controllers": ("pd",)}, UnknownName, "adaptive-it2"),
        ({"duration": 0.0}, InvalidValue, "duration"),
        ({"duration": 0.002}, InvalidValue, "at least two periods"),
        ({"drive": None}, InvalidValue, "Drive"),
        ({"workers": 0}, InvalidValue, "workers"),
    ],
)
def test_what_cannot_be_compared_is_refused_before_any_run(
    options: dict[str, Any], error: type[Exception], words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mismatch, "run", lambda *_: pytest.fail("a run was started"))
    with pytest.raises(error, match=words):
        compare(**options)


def test_what_was_not_compared_is_refused() -> None:
    case = Case(1.0)
    found = Comparison((case,), ("ctc",), {(case, "ctc"): (outcome(1.0), outcome(2.0))})
    with pytest.raises(UnknownName, match="settled"):
        found.values(case, "ctc", "speed")
    with pytest.raises(InvalidValue, match="one that was compared"):
        found.values(replace(case, payload=3.0), "ctc")
    with pytest.raises(UnknownName, match="controller"):
        run(case, "pd")
    with pytest.raises(InvalidValue, match="seed"):
        run(case, "ctc", -1)
