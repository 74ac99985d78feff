"""The compiled loop of controller and plant."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from fuzzy2.support.compiled import compiled, scalar
from psp3.checks import Array, Indices
from psp3.control.controller import steer
from psp3.dynamics.compiled_robot import advance

WHOLE, NO_FORCE, LEFT_POSES, BEYOND_LIMITS = range(4)
"""How a loop ended: it did not; the controller's forces were not finite; the robot left its
reachable poses; an actuated joint left its limits.
"""


class Wires(NamedTuple):
    """The parts between a controller and a robot of m motors, p positions and n speeds.

    ``resolution`` (k,) of the encoders of the first coordinates, 0 for a perfect one, and their
    ``last`` positions (k,); ``noise`` (N, p + n) of the measurement of positions and speeds, or (0,
    p + n); ``limit`` (m,) largest forces, infinite for none; ``low`` and ``high`` (p,) ends of the
    joints; ``seen`` (p + n,) the last values that the controller saw.
    """

    resolution: Array
    last: Array
    noise: Array
    limit: Array
    low: Array
    high: Array
    seen: Array


class Track(NamedTuple):
    """The record of a loop, one row per sample.

    ``t`` (N,) and ``desired`` (N, 3k) are given; ``states`` (N, p + n), forces ``asked`` for and
    ``applied`` (N, m) and what the controller ``wrote`` (N, w) are written.
    """

    t: Array
    desired: Array
    states: Array
    asked: Array
    applied: Array
    wrote: Array


@scalar
def read_encoders(
    resolutions: Array,
    last: Array,
    is_first: bool,
    period: float,
    positions: Array,
    speeds: Array,
) -> None:
    """Turn the true state into encoder readings: counts, and speeds from their differences.

    There is one resolution for each of the first coordinates; ``last`` are the previous readings of
    positions.
    """
    for i in range(resolutions.size):
        resolution = resolutions[i]
        if resolution > 0.0:
            positions[i] = resolution * math.floor(positions[i] / resolution + 0.5)
            speeds[i] = 0.0 if is_first else (positions[i] - last[i]) / period
            last[i] = positions[i]


@scalar
def limited(force: float, limit: float) -> float:
    """Return a force that is no larger than a limit."""
    return min(max(force, -limit), limit)


@compiled
def run(
    controller: Any,
    robot: Any,
    drives: Array,
    state: Array,
    wires: Wires,
    track: Track,
    period: float,
    steps: int,
    delay: int,
    first: int,
    end: int,
    ending: Indices,
) -> int:
    """Run a controller and a robot from sample ``first`` up to ``end``.

    ``state`` (p + n,) is the robot's state, changed in place. A period has ``steps`` integration
    steps, and forces are delayed by ``delay`` periods. Return the number of samples whose force is
    known, and write to ``ending`` (1,) how the loop ended.
    """
    # Read from the tables once, because in the loop this would cost as much as a step of PD.
    resolutions, last, noise, limit, low, high, seen = wires
    times, wanted, states, asked, applied, wrote = track
    p, count, is_noisy = low.size, times.size, noise.shape[0] > 0
    positions, speeds = seen[:p], seen[p:]
    for k in range(first, end):
        for i in range(state.size):
            states[k, i] = seen[i] = state[i]
            if is_noisy:
                seen[i] += noise[k, i]
        read_encoders(resolutions, last, k == 0, period, positions, speeds)
        if not steer(controller, k, times[k], positions, speeds, wanted[k], wrote[k]):
            ending[0] = NO_FORCE
            return k
        for i in range(limit.size):
            asked[k, i] = limited(wrote[k, i], limit[i])
            applied[k, i] = asked[max(k - delay, 0), i]
        if k + 1 < count:
            if not advance(robot, state, applied[k], period / steps, steps, drives):
                ending[0] = LEFT_POSES
                return k + 1
            for i in range(p):
                if not low[i] <= state[i] <= high[i]:
                    ending[0] = BEYOND_LIMITS
                    return k + 1
    return end
