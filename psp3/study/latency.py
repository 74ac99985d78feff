"""The time of one step of a controller (Table 6.2).

The controller is called from Python, as a control loop would call it.

A control loop must meet its deadline in every step, so the slowest steps count. The median is the
cost of the computation; the high percentiles show what the machine adds to it. Garbage collection
stays on, because a control loop in Python runs with it, too.
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
"""Number of first steps that are not counted, because they load code and fill caches."""

Clock = Callable[[], int]


class Latency(NamedTuple):
    """Times of single steps [s].

    The number of measured ``steps``, and the times that half of them (``median``), 99 %
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
    """Return the time of each call of a controller.

    Parameters
    ----------
    controller : Controller
        Controller to measure; its calls on the first states of the run are not counted.
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
        Times [s]; each includes the time to read the clock, about 50 ns.

    Raises
    ------
    InvalidValue
        If there is no state.
    """
    if len(t) == 0:
        raise InvalidValue("t", t, "at least one time")
    # Unpacked before the loop, so only the controller's own work is timed.
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
    """Return percentiles of step times; each is a measured time (nearest rank).

    Parameters
    ----------
    times : (N,) ndarray
        Times [s].

    Returns
    -------
    Latency
    """
    ascending = np.sort(times).tolist()
    # Ranks in integer arithmetic: 99.9 % of 1000 is 999, but slightly more in floating point.
    median, high, higher, worst = (
        ascending[-(-permille * len(ascending) // 1000) - 1] for permille in (500, 990, 999, 1000)
    )
    return Latency(len(times), median, high, higher, worst)


def controllers_of_table_6_2(robot: PSP3, recorded: Record) -> dict[str, Controller]:
    """Return the controllers of Table 6.2 and further ones by name.

    They are the thesis's four, computed torque with three models, and general type-2.

    Parameters
    ----------
    robot : PSP3
        The robot.
    recorded : Record
        Record that the fuzzy controllers learn from, with the mean variation for 20 dB but no
        noise.

    Returns
    -------
    dict
        Controllers by name: ``"PD"``; ``"CTC, "`` and the name of a model, which closes the loops
        in every step if needed; ``"t1"``, ``"it2"``, ``"gt2"``.
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
        The desired motion of the run, arrays of shape (N, 3).
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
