"""Computed torque with what a regressor predicts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from psp3 import ComputedTorque
from psp3.benchmark.learned import LearnedComputedTorque
from psp3.benchmark.readings import NONE, lesson
from psp3.benchmark.tasks import ROBOTS, task
from psp3.checks import Array
from psp3.errors import InvalidEntry
from psp3.fuzzy_control.numbers import unpack
from tests.psp3.benchmark.made import Exact

RNG = np.random.default_rng


def controller_of(name: str, regressor: Any) -> LearnedComputedTorque:
    of_robot = task(name)
    samples = lesson(of_robot, NONE, np.inf, RNG(0), 20)
    return LearnedComputedTorque(
        regressor, samples, of_robot.inputs_of, of_robot.kp, of_robot.kv, "one"
    )


@pytest.mark.parametrize("name", ROBOTS)
def test_exact_estimates_make_exact_computed_torque(name: str) -> None:
    """Along the recorded way, but for rounding: M, C and G are on one side only."""
    of_robot = task(name)
    learned = controller_of(name, Exact(of_robot.robot))
    exact = ComputedTorque(of_robot.robot, of_robot.kp, of_robot.kv)
    recorded, motion = of_robot.recorded, of_robot.paths["untrained"](0.3)
    for k in recorded.sample(5):
        state = recorded.positions[k], recorded.speeds[k]
        expected = exact.torque(0.3, *state, motion)
        got = learned.torque(0.3, *state, motion)
        np.testing.assert_allclose(got, expected, rtol=1e-7, atol=1e-7 * np.abs(expected).max())
        assert not learned.fell_back


class Says:
    """A regressor that says the same numbers everywhere."""

    def __init__(self, said: Array) -> None:
        self.said = said

    def fit(self, X: Array, Y: Array) -> None:
        """Spoil the samples, which are this regressor's own."""
        X[:], Y[:] = np.nan, np.nan

    def predict(self, X: Array) -> Array:
        """Return the numbers."""
        return self.said


@pytest.mark.parametrize("flaw", ["not finite", "not definite"])
def test_unusable_estimates_are_replaced_by_the_average_of_the_samples(flaw: str) -> None:
    of_robot = task("psp3")
    samples = lesson(of_robot, NONE, np.inf, RNG(0), 20)
    said = np.zeros((1, 18)) if flaw == "not definite" else np.full((1, 18), np.nan)
    controller = controller_of("psp3", Says(said))
    estimate = controller.estimate(np.zeros(3), np.zeros(3))
    for one, other in zip(estimate, unpack(samples.outputs.mean(axis=0)), strict=True):
        np.testing.assert_array_equal(one, other)
    assert controller.fell_back


def test_predictions_of_another_shape_are_refused_with_the_shape_that_is_wanted() -> None:
    controller = controller_of("psp3", Says(np.zeros(18)))
    with pytest.raises(InvalidEntry, match=r"one: predict returned shape \(18,\).*\(1, 18\)"):
        controller.estimate(np.zeros(3), np.zeros(3))
