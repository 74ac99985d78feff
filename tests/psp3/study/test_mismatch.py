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
from psp3.study import study
from psp3.study.execution import execute, mismatched, simulate_run
from psp3.study.mismatch import CONTROLLERS, case, compare
from psp3.study.paths import TRAJECTORIES
from psp3.study.run import Run
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
def simulated(case: Run, name: str, seed: int, duration: float) -> Result:
    believed = psp3.load("psp3")
    parameters = mismatched(
        believed.parameters, 0.05, case.payload, np.random.default_rng([seed, 1])
    )
    plant = RungeKutta(psp3.load("psp3", parameters=parameters), drive=case.drive)
    return simulate(
        believed,
        controller(name, case.snr_db, seed),
        TRAJECTORIES[case.trajectory or "helix"](believed),
        duration,
        plant=plant,
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", CONTROLLERS)
@pytest.mark.parametrize(
    "setting",
    [
        case(2.0, "waypoints", 20.0),
        case(1.0, drive=Drive(coulomb_friction=3.0, viscous_friction=5.0)),
    ],
    ids=["noisy", "driven"],
)
def test_runs_are_those_of_the_simulation(name: str, setting: Run) -> None:
    """Without noise of measurement, which the simulation does not have.

    1e-9 m: sums of the torque have another order, which feedback does not amplify; dry friction,
    which jumps, is the reason for 1e-7.
    """
    quiet = replace(setting, position_noise=0.0, speed_noise=0.0)
    run = replace(quiet, controller=name, seed=3, duration=0.5)
    samples, found = simulate_run(run).result, execute(run)
    result = simulated(quiet, name, 3, 0.5)
    tolerance = 1e-9 if setting.drive == Drive() else 1e-7
    np.testing.assert_allclose(samples.heights, result.heights, rtol=0.0, atol=tolerance)
    np.testing.assert_allclose(samples.torque, result.torque, rtol=0.0, atol=1e3 * tolerance)
    assert found["sum_of_squared_errors"] == pytest.approx(sum_of_squared_errors(result), rel=1e-4)
    error = result.desired.heights - result.heights
    assert found["settled_error"] == pytest.approx(
        math.sqrt((error[125:] ** 2).sum(axis=1).mean()), rel=1e-4
    )


def test_runs_of_one_seed_see_the_same_noise_and_others_do_not() -> None:
    """White noise on speeds goes through kv M = 9.3 N s/m.

    Torques of two runs of one seed are the same, those of two seeds are not.
    """
    setting = case(1.0, duration=0.1)
    first, again, other, without = (
        simulate_run(replace(setting, controller=name, seed=seed)).result.torque
        for name, seed in (("ctc", 0), ("ctc", 0), ("ctc", 1), ("lqr", 0))
    )
    np.testing.assert_array_equal(first, again)
    assert np.abs(first - other).max() > 1e-3
    assert np.abs(without - first).max() > 1e-3


def test_a_comparison_does_not_depend_on_threads_and_does_what_does_not_differ_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    done: list[str] = []

    def counted(run: Run) -> dict[str, float]:
        done.append(run.controller)
        return execute(run)

    options: dict[str, Any] = {
        "payloads": (2.0,),
        "trajectories": ("helix",),
        "snrs_db": (math.inf, 20.0),
        "seeds": 2,
        "duration": 0.2,
    }
    names = ("ctc", "t1")
    one = compare(**options, controllers=names, workers=1)
    monkeypatch.setattr(study, "execute", counted)
    other = compare(**options, controllers=names, workers=3)
    np.testing.assert_array_equal(one.table.metrics, other.table.metrics)
    # Computed torque sees no records: two seeds of it, and four of the fuzzy controller.
    assert sorted(done) == ["ctc"] * 2 + ["t1"] * 4
    exact, noisy = one.cases
    np.testing.assert_array_equal(one.values(exact, "ctc"), one.values(noisy, "ctc"))
    assert (one.values(exact, "t1") != one.values(noisy, "t1")).all()


def test_adaptive_type_1_wins_under_a_payload_and_its_interval_says_so() -> None:
    """Three seeds of five seconds.

    The settled error is less than half of every other one's, and type-2 comes second.
    """
    found = compare((2.0,), ("helix",), (math.inf,), 3, duration=5.0)
    (setting,) = found.cases
    assert found.best(setting, "settled_error") == ("adaptive-t1",)
    for name in CONTROLLERS:
        if name != "adaptive-t1":
            assert found.ratio(setting, "adaptive-t1", name, "settled_error").high < 0.7
    order = sorted(
        CONTROLLERS, key=lambda name: found.values(setting, name, "settled_error").mean()
    )
    assert order[:3] == ["adaptive-t1", "adaptive-it2", "lqr-stiff"]
    rows = {row.controller: row for row in found.rows("settled_error")}
    assert rows["ctc"].mean.count == 3
    assert rows["ctc"].mean.value == pytest.approx(
        found.values(setting, "ctc", "settled_error").mean()
    )
    assert rows["ctc"].diverged.value == 0.0
    # As stiff as computed torque, it is off by about as much.
    assert 0.7 < rows["lqr"].mean.value / rows["ctc"].mean.value < 1.0


def test_a_run_that_diverges_says_so() -> None:
    """With 20 kg more than it believes, the integral's loop is unstable.

    The robot leaves its poses after some seconds.
    """
    lost = execute(replace(case(20.0), controller="ctc-integral"))
    assert lost["diverged"] == 1.0
    assert math.isnan(lost["sum_of_squared_errors"])
    assert lost["end_time"] < 10.4


def test_other_robots_are_compared_by_the_same_call() -> None:
    """Exact computed torque with an integral leaves the least under a mismatch of masses."""
    names = ("pd-gravity", "ctc", "ctc-integral")
    found = compare((0.0,), ("sway",), (math.inf,), 2, names, 1.0, robot="five_bar")
    (setting,) = found.cases
    assert found.best(setting, "settled_error")[0] == "ctc-integral"
    assert found.in_words(setting) == "0 kg, sway, exact records"


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"payloads": (-1.0,)}, InvalidValue, "payload"),
        ({"payloads": (math.nan,)}, InvalidValue, "payload"),
        ({"trajectories": ("spiral",)}, UnknownName, "helix"),
        ({"snrs_db": (-200.0,)}, InvalidValue, "snr_db"),
        ({"seeds": 1}, InvalidValue, "seeds"),
        ({"seeds": 2.0}, InvalidValue, "seeds"),
        ({"controllers": ("pid",)}, UnknownName, "adaptive-it2"),
        ({"duration": 0.0}, InvalidValue, "duration"),
        ({"duration": 0.001}, InvalidValue, "at least one .*periods"),
        ({"drive": None}, InvalidValue, "Drive"),
        ({"workers": 0}, InvalidValue, "workers"),
    ],
)
def test_what_cannot_be_compared_is_refused_before_any_run(
    options: dict[str, Any], error: type[Exception], words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(study, "execute", lambda *_: pytest.fail("a run was started"))
    with pytest.raises(error, match=words):
        compare(**options)
