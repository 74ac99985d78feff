"""Detection.

The path by differences, runs against the simulation, signals by their formulas, and what came out.
"""

from __future__ import annotations

import dataclasses
import math
from functools import cache
from typing import Any

import numpy as np
import pytest

import psp3
from psp3.errors import InvalidValue, UnknownName
from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
from psp3.fuzzy_control.monitor import Monitor, torque_width
from psp3.simulation import simulate
from psp3.study import detection
from psp3.study.detection import (
    EVENT,
    SIGNALS,
    Detection,
    Watched,
    detect,
    markdown,
    watch,
    watched_controller,
    watched_run,
)
from psp3.study.paths import DepartingHelix
from psp3.study.statistics import Estimate
from psp3.trajectories import Motion


@cache
def controller() -> FuzzyComputedTorque:
    return watched_controller(watched_run())


@cache
def found() -> dict[str, Detection]:
    return {one.signal: one for one in detect(4, payloads=(2.0,))}


class Recorder:
    """A controller with the desired motion given from outside, that keeps its intervals."""

    def __init__(self, wanted: FuzzyComputedTorque) -> None:
        self.wanted = wanted

    def reset(self) -> None:
        """Forget nothing."""

    def torque(
        self, t: float, heights: np.ndarray, speeds: np.ndarray, desired: Motion
    ) -> np.ndarray:
        """Do as the controller does."""
        return self.wanted.torque(t, heights, speeds, desired)

    @property
    def torque_interval(self) -> np.ndarray:
        """Of the last call."""
        return self.wanted.torque_interval


def test_a_watched_run_is_the_simulation_before_and_after_the_event() -> None:
    """Without noise of measurement.

    The payload rides on the star from the event on: 1e-9 m and N for sums in another order.
    """
    quiet = dataclasses.replace(watched_run(2.0, seed=3), position_noise=0.0, speed_noise=0.0)
    run = watch(quiet)
    rng, robot = np.random.default_rng([3, 3]), psp3.load("psp3")
    radius, period, phase = (
        rng.uniform(0.007, 0.012),
        rng.uniform(2.0, 3.0),
        rng.uniform(0.0, 2.0 * np.pi),
    )
    path = DepartingHelix(radius, period, phase, radius, 1.0, robot)
    np.testing.assert_array_equal(run.desired, path(run.t).heights)
    before = simulate(
        robot,
        Recorder(controller()),
        path,
        1.0,
        initial_positions=run.heights[0],
        initial_speeds=run.speeds[0],
    )
    np.testing.assert_allclose(run.heights[:501], before.heights, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(run.torque[:501], before.torque, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(run.interval[:501], before.torque_interval, rtol=0.0, atol=1e-9)

    class Later:
        def __call__(self, t: np.ndarray) -> Motion:
            return path(np.asarray(t) + EVENT)

    loaded = psp3.load(
        "psp3",
        parameters=dataclasses.replace(
            robot.parameters, star_mass=robot.parameters.star_mass + 2.0
        ),
    )
    k = round(EVENT / 0.002)
    after = simulate(
        loaded,
        controller(),
        Later(),
        1.0,
        initial_positions=run.heights[k],
        initial_speeds=run.speeds[k],
    )  # type: ignore[arg-type]
    np.testing.assert_allclose(run.heights[k : k + 501], after.heights, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(run.torque[k : k + 501], after.torque, rtol=0.0, atol=1e-9)


def test_signals_are_what_they_are_said_to_be() -> None:
    """One sample at a time, from the controller itself.

    Of the residual the size: a third of the weight on each screw, 11.3 N in all.

    Within 1 N: the rules explain the robot without payload to 0.5 N.
    """
    run = watch(dataclasses.replace(watched_run("wider", 6), payload=2.0))
    signals = {name: signal(controller(), run) for name, signal in SIGNALS.items()}
    low, high = controller().ranges_
    for k in range(0, len(run.t), 250):
        a, v = run.heights[k], run.speeds[k]
        x = np.array([a[0] - a[1], a[0] - a[2], v[0] - v[1], v[0] - v[2]])
        controller().torque(0.0, a, v, Motion(a, v, np.zeros(3), a))
        assert (signals["range"][k] == 0.0) == controller().covered
        assert signals["range"][k] == pytest.approx(
            max(0.0, *((low - x) / (high - low)), *((x - high) / (high - low)))
        )
        assert signals["firing"][k] == pytest.approx(
            1.0 - max(upper for _, upper in controller().system_.firing(x))
        )
        assert signals["error"][k] == pytest.approx(math.dist(run.desired[k], a))
        assert signals["interval"][k] == pytest.approx(
            float((run.interval[k, :, 1] - run.interval[k, :, 0]).sum())
        )
    late = run.t > EVENT + 1.0
    assert signals["residual"][late].mean() == pytest.approx(
        math.sqrt(3.0) * 2.0 * 9.81 / 3.0, abs=1.0
    )
    assert signals["residual"][~late & (run.t < EVENT)].max() < 1.0


@pytest.mark.slow
def test_the_interval_does_not_tell_that_the_robot_left_what_was_learned() -> None:
    """What was found, with four seeds.

    Farther out the interval is no wider, while the range tells every time.
    """
    interval, reach = found()["interval"], found()["range"]
    assert interval.excess["wider"] < 1.05
    assert interval.detected["wider"].value <= 0.5
    assert reach.detected["wider"].value == 1.0
    assert reach.delay["wider"].value < 0.6
    # With a payload the robot stays inside: the range is silent, and the residual tells within a
    # hundredth of a second or so.
    assert reach.detected["2 kg"].value == 0.0
    assert found()["residual"].detected["2 kg"].value == 1.0
    assert found()["residual"].delay["2 kg"].value < 0.05
    assert list(found()) == list(SIGNALS)
    for one in found().values():
        assert one.false_alarms.count == 4
        assert set(one.detected) == set(one.delay) == set(one.excess) == {"faster", "wider", "2 kg"}


def test_why_the_interval_does_not_grow_outside() -> None:
    """It is at most as wide as the consequents differ, and nearly that in the middle of the region.

    Beyond its edge it is narrower.

    Gravity, which makes up most of it, unclamped, in all directions from the middle; means over 500
    directions.
    """
    system, (low, high) = controller().system_, controller().ranges_
    hull = np.ptp(np.asarray(system.consequents)[:, 15:], axis=0).sum()
    directions = np.random.default_rng(0).normal(size=(500, 4))
    directions /= np.abs(directions).max(axis=1, keepdims=True)
    shares = {}
    for distance in (0.5, 1.0, 1.5, 2.0, 3.0):
        x = 0.5 * (low + high) + 0.5 * distance * (high - low) * directions
        widths = np.ptp(system.type_reduced(x), axis=-1)[:, 15:].sum(axis=1) / hull
        assert widths.max() <= 1.0 + 1e-12
        shares[distance] = widths.mean()
    assert shares[0.5] > 0.9
    assert max(shares[distance] for distance in (1.0, 1.5, 2.0, 3.0)) < shares[0.5] - 0.05


@pytest.mark.slow
def test_the_result_does_not_depend_on_threads_and_the_monitor_is_the_given_one() -> None:
    one, other = (detect(2, payloads=(), workers=workers) for workers in (1, 3))
    assert [(x.signal, x.threshold, x.excess) for x in one] == [
        (x.signal, x.threshold, x.excess) for x in other
    ]
    greatest = detect(2, payloads=(), monitor=Monitor(1.0))
    for x, y in zip(one, greatest, strict=True):
        assert x.threshold <= y.threshold
    assert greatest[0].threshold > one[0].threshold


def test_a_table_says_what_was_found() -> None:
    share, never = Estimate(0.25, 0.125, 0.5, 8), Estimate(math.nan, math.nan, math.nan, 0)
    one = Detection(
        "range",
        0.0123456,
        share,
        {"wider": Estimate(1.0, 0.7, 1.0, 8), "2 kg": Estimate(0.0, 0.0, 0.3, 8)},
        {"wider": Estimate(0.4, 0.3, 0.5, 8), "2 kg": never},
        {"wider": 3.0, "2 kg": 0.0},
    )
    assert markdown([one]).splitlines() == [
        "| signal | threshold | false alarms | wider | 2 kg |",
        "|---|---|---|---|---|",
        "| range | 0.0123 | 25 % (12 to 50) | 100 % after 0.40 s | 0 % |",
    ]


def test_a_false_alarm_that_goes_on_is_no_detection() -> None:
    t = np.array([0.0, EVENT, EVENT + 1.0, EVENT + 2.0, EVENT + 3.0])
    assert detection._delay(t, np.array([False, True, True, True, True])) == math.inf
    assert detection._delay(t, np.array([True, True, False, True, False])) == 2.0
    assert detection._delay(t, np.zeros(5, dtype=bool)) == math.inf
    run = Watched(t, *(np.zeros((5, 3)) for _ in range(3)), np.zeros((5, 3, 2)), np.zeros((5, 3)))
    np.testing.assert_array_equal(torque_width(run.interval), np.zeros(5))


@pytest.mark.parametrize(
    ("options", "error"),
    [
        ({"seeds": 1}, InvalidValue),
        ({"payloads": (0.0,)}, InvalidValue),
        ({"kind": "t3"}, UnknownName),
        ({"learner": "none"}, UnknownName),
        ({"snr_db": math.nan}, ValueError),
        ({"workers": 0}, InvalidValue),
    ],
)
def test_what_cannot_be_measured_is_refused(
    options: dict[str, Any], error: type[Exception]
) -> None:
    with pytest.raises(error):
        detect(**({"seeds": 2} | options))
