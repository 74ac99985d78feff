"""How long steps take, on a clock that is ours.

What is counted, what is not, and which percentile is which.
"""

from __future__ import annotations

import numpy as np
import pytest

from psp3.checks import Array
from psp3.control.classical import PD, ComputedTorque
from psp3.errors import InvalidValue
from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
from psp3.fuzzy_control.records import Record, record
from psp3.loading import load
from psp3.study.latency import (
    WARM_UP,
    Latency,
    controllers_of_table_6_2,
    measure_latencies,
    step_times,
    summarize,
)
from psp3.trajectories import Helix, Motion


class Stopwatch:
    """A clock that stands still but for what is told to take time [ns]."""

    def __init__(self) -> None:
        self.now = 12345

    def __call__(self) -> int:
        """Return the time."""
        return self.now


class Slow:
    """A controller whose k-th counted call takes k microseconds.

    Those before the count take a second.
    """

    def __init__(self, clock: Stopwatch, counted: int) -> None:
        self.clock, self.counted = clock, counted
        self.calls: list[tuple[float, Array, Array, Motion]] = []
        self.resets = 0

    def reset(self) -> None:
        """Count."""
        self.resets += 1

    def torque(self, t: float, heights: Array, speeds: Array, desired: Motion) -> Array:
        """Remember the call, and let it take its time."""
        self.calls.append((t, heights, speeds, desired))
        number = len(self.calls) - min(WARM_UP, self.counted)
        self.clock.now += 1000 * number if number > 0 else 10**9
        return np.zeros(3)


def motion(count: int) -> tuple[Array, Array, Array, Motion]:
    t = 0.1 * np.arange(count)
    values = np.arange(3.0 * count).reshape(count, 3)
    return t, values, -values, Motion(values + 0.1, values + 0.2, values + 0.3, values + 0.4)


@pytest.mark.parametrize("count", [1, 30, 1000])
def test_counted_are_the_calls_after_the_warm_up_each_with_its_state(count: int) -> None:
    clock = Stopwatch()
    controller = Slow(clock, count)
    states = motion(count)
    times = step_times(controller, *states, clock)
    np.testing.assert_allclose(times, 1e-6 * np.arange(1, count + 1), rtol=1e-12)
    assert controller.resets == 1
    for k, (t, heights, speeds, desired) in enumerate(controller.calls[-count:]):
        assert t == states[0][k]
        np.testing.assert_array_equal(heights, states[1][k])
        np.testing.assert_array_equal(speeds, states[2][k])
        for name in Motion._fields:
            np.testing.assert_array_equal(getattr(desired, name), getattr(states[3], name)[k])


def test_percentiles_are_times_that_were_measured() -> None:
    """By nearest rank, counted by hand.

    Of 1 to 1000 the 500th, 990th, 999th and 1000th, in whatever order they come.
    """
    times = np.random.default_rng(0).permutation(np.arange(1.0, 1001.0))
    assert summarize(times) == Latency(1000, 500.0, 990.0, 999.0, 1000.0)
    assert summarize(np.array([7.0])) == Latency(1, 7.0, 7.0, 7.0, 7.0)
    # Ranks between two times are those of the later one: 1.5 of 3, and 148.5 and 149.85 of 150.
    assert summarize(np.array([3.0, 1.0, 2.0])) == Latency(3, 2.0, 3.0, 3.0, 3.0)
    assert summarize(np.arange(1.0, 151.0)) == Latency(150, 75.0, 149.0, 150.0, 150.0)


def test_no_state_is_refused() -> None:
    with pytest.raises(InvalidValue, match="at least one time"):
        step_times(Slow(Stopwatch(), 0), *motion(0))


@pytest.fixture(scope="module")
def recorded() -> Record:
    robot = load("psp3")
    return record(robot, Helix(robot=robot), period=0.01)


def test_controllers_are_those_of_the_table(recorded: Record) -> None:
    robot = load("psp3")
    controllers = controllers_of_table_6_2(robot, recorded)
    assert list(controllers) == [
        "PD",
        "CTC, noc",
        "CTC, pinocchio",
        "CTC, closed_form",
        "t1",
        "it2",
        "gt2",
    ]
    assert isinstance(controllers["PD"], PD)
    models = set()
    for name in ("noc", "pinocchio", "closed_form"):
        controller = controllers[f"CTC, {name}"]
        assert isinstance(controller, ComputedTorque)
        models.add(type(controller.model).__name__)
    assert len(models) == 3
    for kind in ("t1", "it2", "gt2"):
        controller = controllers[kind]
        assert isinstance(controller, FuzzyComputedTorque)
        assert controller.kind == kind


def test_states_are_spread_over_the_whole_run(recorded: Record) -> None:
    clock = Stopwatch()
    controller = Slow(clock, 5)
    desired = Helix(robot=load("psp3"))(recorded.t)
    found = measure_latencies({"slow": controller}, recorded, desired, 5, clock)
    assert found["slow"].steps == 5
    assert found["slow"].worst == pytest.approx(5e-6)
    middle = (len(recorded.t) - 1) // 2
    counted = controller.calls[-5:]
    assert (counted[0][0], counted[2][0], counted[4][0]) == (
        0.0,
        recorded.t[middle],
        recorded.t[-1],
    )
    np.testing.assert_array_equal(counted[4][1], recorded.heights[-1])
    np.testing.assert_array_equal(counted[4][3].tip, desired.tip[-1])
