"""Learned torques on symbols, against the controller's own steps and differences of them."""

from __future__ import annotations

import warnings
from typing import Any

import casadi
import numpy as np
import pytest

import psp3
from fuzzy2.errors import ApproximationWarning
from psp3.errors import NotTrained
from psp3.symbolic import SymbolicRobot, fuzzy_torque
from tests.helpers import Array

ROBOT = psp3.load("psp3")
HELIX = psp3.trajectories.Helix(radius=0.020, period=2.0, rise=0.010)
KINDS: dict[str, dict[str, Any]] = {
    "t1": {"kind": "t1", "snr_db": 0.0},
    "it2": {"kind": "it2", "snr_db": 20.0},
    "it2 strongest": {"kind": "it2", "snr_db": 10.0},
    "gt2 first": {"kind": "gt2", "snr_db": 10.0, "levels": 3},
    "gt2 last": {"kind": "gt2", "snr_db": 10.0, "levels": 3, "defuzzify": "last"},
    "gt2 corollary": {
        "kind": "gt2",
        "mean_variation": 0.05,
        "reduction": "gaussian",
        "term_width": 0.5,
    },
}


@pytest.fixture(scope="module", params=[*KINDS])
def controller(request: pytest.FixtureRequest) -> psp3.FuzzyComputedTorque:
    made = psp3.FuzzyComputedTorque(robot=ROBOT, **KINDS[request.param])
    with warnings.catch_warnings():
        # How well the corollary approximates is not what is looked at.
        warnings.simplefilter("ignore", ApproximationWarning)
        return made.fit(HELIX, rng=np.random.default_rng(1))


def states(count: int, away: float) -> list[tuple[Array, Array, Any]]:
    rng, found = np.random.default_rng(5), []
    for _ in range(count):
        wanted = HELIX(rng.uniform(0.0, 5.0))
        heights = wanted.positions + rng.normal(0.0, away, 3)
        found.append((heights, wanted.speeds + rng.normal(0.0, 10.0 * away, 3), wanted))
    return found


def test_torque_is_that_of_a_step(controller: psp3.FuzzyComputedTorque) -> None:
    """Within the trained range and outside of it; to 1e-12 of the largest force."""
    function, covered = fuzzy_torque(controller), []
    for away in (1e-4, 0.01):
        for heights, speeds, wanted in states(100, away):
            expected = controller.torque(0.0, heights, speeds, wanted)
            found = function(heights, speeds, *wanted[:3]).full().ravel()
            assert np.abs(found - expected).max() <= 1e-12 * np.abs(expected).max()
            covered.append(controller.covered)
    assert any(covered)
    assert not all(covered)


def test_derivatives_are_those_of_differences(controller: psp3.FuzzyComputedTorque) -> None:
    """Of a step of 1e-7, whose rounding and truncation stay below 1e-6 of the largest slope."""
    function = fuzzy_torque(controller)
    x, wanted_motion = casadi.SX.sym("x", 6), [casadi.SX.sym(f"w{k}", 3) for k in range(3)]
    torque = function(x[:3], x[3:], *wanted_motion)
    slope = casadi.Function("slope", [x, *wanted_motion], [casadi.jacobian(torque, x)])
    h = 1e-7
    for heights, speeds, wanted in states(10, 1e-3):
        state = np.concatenate([heights, speeds])

        def step(at: Array, wanted: Any = wanted) -> Array:
            return controller.torque(0.0, at[:3], at[3:], wanted)

        columns = [(step(state + e) - step(state - e)) / (2.0 * h) for e in h * np.eye(6)]
        expected = np.stack(columns, axis=-1)
        found = slope(state, *wanted[:3]).full()
        assert np.abs(found - expected).max() <= 1e-6 * np.abs(expected).max()


def test_where_an_estimate_cannot_be_used_it_falls_back() -> None:
    """Type-1 rules from samples with ten times as much noise as signal."""
    made = psp3.FuzzyComputedTorque("t1", ROBOT, snr_db=-10.0)
    made.fit(HELIX, rng=np.random.default_rng(2))
    function, fell_back = fuzzy_torque(made), []
    for heights, speeds, wanted in states(100, 0.005):
        expected = made.torque(0.0, heights, speeds, wanted)
        found = function(heights, speeds, *wanted[:3]).full().ravel()
        assert np.abs(found - expected).max() <= 1e-12 * np.abs(expected).max()
        fell_back.append(made.fell_back)
    assert any(fell_back)
    assert not all(fell_back)


@pytest.mark.slow
def test_another_robot_with_a_coriolis_matrix_from_its_mass_matrix() -> None:
    robot = psp3.load("five_bar")
    sway = psp3.trajectories.Sway(robot=robot)
    made = psp3.FuzzyComputedTorque("t1", robot, coriolis="mass", rules=12)
    made.fit(sway, duration=2.0, samples=200)
    function, rng = fuzzy_torque(made), np.random.default_rng(0)
    for _ in range(50):
        wanted = sway(rng.uniform(0.0, 2.0))
        positions = wanted.positions + rng.normal(0.0, 0.02, 2)
        expected = made.torque(0.0, positions, wanted.speeds, wanted)
        found = function(positions, wanted.speeds, *wanted[:3]).full().ravel()
        assert np.abs(found - expected).max() <= 1e-12 * np.abs(expected).max()


def trained_crisp(name: str, kind: str) -> tuple[psp3.FuzzyComputedTorque, Any]:
    """Return a controller with exact dynamics outside of its trained range, and its motion."""
    robot = psp3.load(name)
    path: Any = HELIX if name == "psp3" else psp3.trajectories.Sway(robot=robot)
    noise = {} if kind == "t1" else {"snr_db": 20.0}
    made = psp3.FuzzyComputedTorque(kind, robot, rules=8, outside="crisp", **noise)
    return made.fit(path, duration=2.0, samples=150, rng=np.random.default_rng(1)), path


@pytest.mark.parametrize(("name", "kind"), [("psp3", "it2"), ("five_bar", "gt2"), ("delta", "t1")])
def test_exact_dynamics_take_over_outside_of_the_trained_range(name: str, kind: str) -> None:
    """Torque to rounding, 1e-13 of the largest, and slopes as of differences of a step of 1e-7.

    Of robots without a closed form the function takes the configuration, which goes along.
    """
    made, path = trained_crisp(name, kind)
    n, function, closed = made.joints, fuzzy_torque(made), name == "psp3"
    x, wanted_motion = casadi.SX.sym("x", 2 * n), [casadi.SX.sym(f"w{k}", n) for k in range(3)]
    given = [x, *wanted_motion]
    if closed:
        slopes = casadi.jacobian(function(x[:n], x[n:], *wanted_motion), x)
    else:
        symbolic = SymbolicRobot(made.robot)
        q = symbolic.configuration
        torque = function(x[:n], x[n:], *wanted_motion, q)
        slopes = casadi.jacobian(torque, x)
        along = casadi.jacobian(symbolic.configuration_rates(q, x[n:]), x[n:])
        slopes[:, :n] += casadi.jacobian(torque, q) @ along
        given.append(q)
    slope, rng, covered = casadi.Function("slope", given, [slopes]), np.random.default_rng(3), []

    def step(at: Array, wanted: Any) -> Array:
        return made.torque(0.0, at[:n], at[n:], wanted)

    for k in range(20):
        wanted = path(rng.uniform(0.0, 2.0))
        # Far enough from the ends of the range that no difference steps over them.
        positions = wanted.positions + rng.normal(0.0, 1e-4 if k % 2 else 0.005, n)
        speeds = wanted.speeds + rng.normal(0.0, 1e-3, n)
        state = np.concatenate([positions, speeds])
        expected = step(state, wanted)
        covered.append(made.covered)
        extra = () if closed else (made.robot.configuration(positions),)
        found = function(positions, speeds, *wanted[:3], *extra).full().ravel()
        assert np.abs(found - expected).max() <= 1e-13 * np.abs(expected).max()
        columns = [
            (step(state + e, wanted) - step(state - e, wanted)) / 2e-7 for e in 1e-7 * np.eye(2 * n)
        ]
        differences = np.stack(columns, axis=-1)
        found = slope(state, *wanted[:3], *extra).full()
        assert np.abs(found - differences).max() <= 1e-6 * np.abs(differences).max()
    assert any(covered)
    assert not all(covered)


def test_what_was_not_trained_is_refused() -> None:
    with pytest.raises(NotTrained):
        fuzzy_torque(psp3.FuzzyComputedTorque("t1", ROBOT))
