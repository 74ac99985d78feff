"""How long one step of a controller takes (Table 6.2).

It is called from Python as a control loop would call it.

A control loop must meet its deadline in every step, so what counts is the tail: the median says
what the computation costs, the percentiles what the machine adds to it. Garbage collection is left
as it is, because a loop in Python lives with it.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from psp3.checks import Array
from psp3.control.classical import PD, ComputedTorque
from psp3.control.controller import Controller
from psp3.errors import InvalidValue
from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
from psp3.fuzzy_control.records import Record
from psp3.published import TABLE_6_1
from psp3.three_psp.robot import PSP3
from psp3.trajectories.motion import Motion

WARM_UP = 50
"""Steps that are made and not counted: the first ones load code and fill caches."""

Clock = Callable[[], int]


class Latency(NamedTuple):
    """Times of single steps [s].

    How many ``steps`` were measured, and the times that half of them (``median``), 99 %
    (``percentile_99``), 99.9 % (``percentile_99_9``) and all of them (``worst``) do not exceed.
    """

    steps: int
    median: float
    percentile_99: float
    percentile_99_9: float
    worst: float


def step_times(
    controller: Controller,
    t: Array,
    heights: Array,
    speeds: Array,
    desired: Motion,
    clock: Clock = time.perf_counter_ns,
) -> Array:
    """Return how long each call of a controller takes.

    Parameters
    ----------
    controller : Controller
        What is measured; it is called on the first states of the run before anything is counted.
    t : (N,) ndarray
        Times [s].
    heights, speeds : (N, 3) ndarray
        States of the robot, [m] and [m/s].
    desired : Motion
        Desired motion at these times, arrays of shape (N, 3).
    clock : callable
        Returns nanoseconds.

    Returns
    -------
    (N,) ndarray
        Times [s], each with the time it takes to read the clock, some 50 ns.

    Raises
    ------
    InvalidValue
        If there is no state.
    """
    if len(t) == 0:
        raise InvalidValue("t", t, "at least one time")
    # Taken apart before, so that only the controller's own work is timed.
    calls = list(
        zip(
            t.tolist(),
            np.array(heights),
            np.array(speeds),
            map(Motion._make, zip(*desired, strict=True)),
            strict=True,
        )
    )
    controller.reset()
    torque = controller.torque
    for call in calls[:WARM_UP]:
        torque(*call)
    nanoseconds = np.empty(len(calls))
    for k, (now, a, v, wanted) in enumerate(calls):
        start = clock()
        torque(now, a, v, wanted)
        nanoseconds[k] = clock() - start
    return 1e-9 * nanoseconds


def summarize(times: Array) -> Latency:
    """Return the percentiles of step times, each one that was measured (nearest rank).

    Parameters
    ----------
    times : (N,) ndarray
        Times [s].

    Returns
    -------
    Latency
    """
    ascending = np.sort(times).tolist()
    # Ranks in whole numbers: 99.9 % of 1000 is 999, and in floating point a little more.
    median, high, higher, worst = (
        ascending[-(-permille * len(ascending) // 1000) - 1] for permille in (500, 990, 999, 1000)
    )
    return Latency(len(times), median, high, higher, worst)


def controllers_of_table_6_2(robot: PSP3, recorded: Record) -> dict[str, Controller]:
    """Return the controllers whose steps are compared, by name.

    The thesis's four, computed torque by three models, general type-2.

    Parameters
    ----------
    robot : PSP3
        The robot.
    recorded : Record
        What the fuzzy ones learn from, with the mean variation of 20 dB but no noise.

    Returns
    -------
    dict
        ``"PD"``; ``"CTC, "`` with the name of a model, which closes the loops in every step, if it
        needs to; ``"t1"``, ``"it2"``, ``"gt2"``.
    """
    controllers: dict[str, Controller] = {"PD": PD(*TABLE_6_1["PD"])}
    for name in ("noc", "pinocchio", "closed_form"):
        model = robot if name == "closed_form" else robot.dynamics(name)
        controllers[f"CTC, {name}"] = ComputedTorque(model, *TABLE_6_1["CTC"])
    for kind in ("t1", "it2", "gt2"):
        controllers[kind] = FuzzyComputedTorque(kind, robot, mean_variation=0.3).learn(recorded)
    return controllers


def measure_latencies(
    controllers: dict[str, Controller],
    recorded: Record,
    desired: Motion,
    steps: int,
    clock: Clock = time.perf_counter_ns,
) -> dict[str, Latency]:
    """Return the latencies of controllers on states of a recorded run, spread evenly over it.

    Parameters
    ----------
    controllers : dict of Controller
        By name.
    recorded : Record
        The run, N samples.
    desired : Motion
        What was desired of it, arrays of shape (N, 3).
    steps : int
        Steps of each controller, at most N.
    clock : callable
        Returns nanoseconds.

    Returns
    -------
    dict of Latency
        By name.
    """
    chosen = np.linspace(0, len(recorded.t) - 1, steps).round().astype(int)
    states = (
        recorded.t[chosen],
        recorded.heights[chosen],
        recorded.speeds[chosen],
        Motion(*(array[chosen] for array in desired)),
    )
    return {
        name: summarize(step_times(controller, *states, clock))
        for name, controller in controllers.items()
    }
