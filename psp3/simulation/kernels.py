"""The compiled loop of controller and plant."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from fuzzy2.support.compiled import compiled
from psp3.checks import Array, Indices
from psp3.control.controller import steer
from psp3.dynamics.compiled_robot import advance

WHOLE, NO_FORCE, LEFT_POSES, BEYOND_LIMITS = range(4)
"""How a loop ended: it did not; the controller's forces were not finite; the robot left the poses
it can take; an actuated joint left its limits.
"""


class Wires(NamedTuple):
    """What lies between controller and robot of n joints.

    ``resolution`` (n,) of the encoders, 0 for a perfect one, and their ``last`` positions (n,);
    ``noise`` (N, 2n) what measurement adds to positions and speeds, or (0, 2n); ``limit`` (n,)
    largest forces, infinite for none; ``low`` and ``high`` (n,) ends of the joints; ``seen`` (2n,)
    what the controller saw last.
    """

    resolution: Array
    last: Array
    noise: Array
    limit: Array
    low: Array
    high: Array
    seen: Array


class Track(NamedTuple):
    """What happens, a row a sample.

    ``t`` (N,) and ``desired`` (N, 3n) are given; ``states`` (N, 2n), forces ``asked`` for and
    ``applied`` (N, n) and what the controller ``wrote`` (N, w) are written.
    """

    t: Array
    desired: Array
    states: Array
    asked: Array
    applied: Array
    wrote: Array


@compiled
def _measure(state: Array, k: int, period: float, wires: Wires) -> None:
    """Write what the controller sees of a state: with noise, and counted by encoders."""
    n, seen, last = wires.resolution.size, wires.seen, wires.last
    for i in range(2 * n):
        seen[i] = state[i] + (wires.noise[k, i] if wires.noise.shape[0] > 0 else 0.0)
    for i in range(n):
        resolution = wires.resolution[i]
        if resolution > 0.0:
            seen[i] = resolution * math.floor(seen[i] / resolution + 0.5)
            seen[n + i] = (seen[i] - last[i]) / period if k > 0 else 0.0
            last[i] = seen[i]


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
    """Let a controller steer a robot from sample ``first`` up to ``end``.

    ``state`` (2n,) is where the robot is, changed in place; ``steps`` of integration in a period;
    forces come late by ``delay`` periods. Return the number of samples whose force is known, and
    write to ``ending`` (1,) why there are no more.
    """
    n, count = wires.resolution.size, track.t.size
    for k in range(first, end):
        for i in range(2 * n):
            track.states[k, i] = state[i]
        _measure(state, k, period, wires)
        seen, wrote = wires.seen, track.wrote[k]
        if not steer(controller, k, track.t[k], seen[:n], seen[n:], track.desired[k], wrote):
            ending[0] = NO_FORCE
            return k
        for i in range(n):
            track.asked[k, i] = min(max(wrote[i], -wires.limit[i]), wires.limit[i])
            track.applied[k, i] = track.asked[max(k - delay, 0), i]
        if k + 1 < count:
            if not advance(robot, state, track.applied[k], period / steps, steps, drives):
                ending[0] = LEFT_POSES
                return k + 1
            for i in range(n):
                if not wires.low[i] <= state[i] <= wires.high[i]:
                    ending[0] = BEYOND_LIMITS
                    return k + 1
    return end
