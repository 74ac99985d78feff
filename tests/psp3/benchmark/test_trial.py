"""Trials: what is measured, what ends early, what is raised."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pytest

import psp3
from psp3.benchmark.baselines import BASELINES, REFERENCE
from psp3.benchmark.entries import MODEL, Entry
from psp3.benchmark.tasks import PATHS, ROBOTS, task
from psp3.benchmark.trial import Noisy, Trial, execute
from psp3.checks import Array
from psp3.errors import InvalidValue, UnknownName
from tests.psp3.benchmark.made import Exact, entry_of

SHORT = 0.4


@pytest.mark.parametrize("robot", ROBOTS)
def test_an_entry_that_is_exact_scores_like_exact_computed_torque(robot: str) -> None:
    """But for rounding of forces: errors are some tenths of a millimeter, equal to 1e-6 of that."""
    trial = Trial(robot, "outputs", 20.0, duration=SHORT)
    exact = execute(trial, entry_of("exact", Exact))
    reference = execute(trial, BASELINES[REFERENCE])
    assert exact["error"] is None
    for path in PATHS:
        mine, other = exact["runs"][path], reference["runs"][path]
        assert mine.keys() == other.keys()
        for name in mine:
            assert mine[name] == pytest.approx(other[name], rel=1e-6), name


def test_numbers_are_those_of_a_simulation_by_hand() -> None:
    of_robot, trial = task("delta"), Trial("delta", duration=SHORT)
    run = execute(trial, BASELINES["pd-gravity"])["runs"]["untrained"]
    mass = of_robot.robot.mass_matrix(of_robot.robot.reference)
    path = of_robot.paths["untrained"]
    result = psp3.simulate(
        of_robot.robot,
        psp3.GravityCompensatedPD(of_robot.robot, of_robot.kp * mass, of_robot.kv * mass),
        path,
        SHORT,
        0.004,
        initial_speeds=path(0.0).speeds,
    )
    off = np.sqrt(((path(result.t).tip - result.tip) ** 2).sum(axis=1))
    squares = (result.torque**2).sum(axis=1)
    assert run == {
        "diverged": False,
        "end_time": pytest.approx(SHORT),
        "rms_tip_error": pytest.approx(np.sqrt(np.mean(off**2))),
        "largest_tip_error": pytest.approx(off.max()),
        "rms_error": pytest.approx(
            np.sqrt(((path(result.t).positions - result.positions) ** 2).sum(axis=1).mean())
        ),
        "effort": pytest.approx(0.004 * (squares.sum() - 0.5 * (squares[0] + squares[-1]))),
        "fallbacks": 0.0,
    }


class Forces:
    """A controller that returns the same forces always."""

    def __init__(self, forces: Any) -> None:
        self.forces = forces

    def reset(self) -> None:
        """Forget nothing."""

    def torque(self, *given: object) -> Any:
        """Return the forces."""
        return self.forces


@pytest.mark.parametrize("force", [1e5, math.nan])
def test_losing_the_robot_is_a_result(force: float) -> None:
    entry = Entry("pushes", MODEL, lambda course: Forces(np.full(3, force)))
    outcome = execute(Trial("delta", duration=SHORT), entry)
    assert outcome["error"] is None
    for run in outcome["runs"].values():
        assert run.keys() == {"diverged", "end_time"}
        assert run["diverged"]
        assert run["end_time"] < SHORT


def raises(course: object) -> Any:
    raise RuntimeError("two\n lines")


def exits(course: object) -> Any:
    raise SystemExit(3)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (raises, "RuntimeError: two lines"),
        (exits, "SystemExit: 3"),
        (lambda course: Forces(np.zeros(2)), "InvalidTorque: .* something else than 3"),
        (lambda course: object(), "AttributeError: .*reset"),
    ],
)
def test_what_an_entry_raises_is_its_outcome(make: Any, message: str) -> None:
    outcome = execute(Trial("delta", duration=SHORT), Entry("bad", MODEL, make))
    assert outcome.keys() == {"error"}
    assert re.match(message, outcome["error"])


def test_measured_noise_is_seen_by_any_controller_the_same_in_every_run() -> None:
    seen: list[Array] = []

    class Looks(Forces):
        def torque(self, t: float, positions: Array, speeds: Array, desired: object) -> Any:
            seen.append(np.concatenate([positions, speeds]))
            return np.zeros(2)

    noise = np.random.default_rng(0).standard_normal((3, 4))
    noisy, at = Noisy(Looks(None), noise), np.arange(4.0)
    for _ in range(2):
        noisy.reset()
        for _ in range(3):
            noisy.torque(0.0, at[:2], at[2:], None)  # type: ignore[arg-type]
    np.testing.assert_array_equal(seen, np.tile(at + noise, (2, 1)))


def test_noise_of_measurement_makes_exact_computed_torque_worse() -> None:
    calm, noisy = (
        execute(Trial("delta", *reading, duration=SHORT), BASELINES[REFERENCE])["runs"]["trained"]
        for reading in (("none", math.inf), ("measurement", 10.0))
    )
    assert noisy["rms_tip_error"] > 1.5 * calm["rms_tip_error"]


@pytest.mark.parametrize(
    ("wrong", "error"),
    [
        (Trial("hexapod"), UnknownName),
        (Trial("psp3", "loud", 20.0), UnknownName),
        (Trial("psp3", "outputs", math.inf), InvalidValue),
        (Trial("psp3", "none", 20.0), InvalidValue),
        (Trial("psp3", seed=-1), InvalidValue),
        (Trial("psp3", duration=0.001), InvalidValue),
    ],
)
def test_wrong_trials_are_refused(wrong: Trial, error: type[Exception]) -> None:
    with pytest.raises(error):
        wrong.check()
