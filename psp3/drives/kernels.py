"""Compiled dynamics of driven joints.

Which of them stick, how the others accelerate, and Runge–Kutta steps from event to event.

The laws are in :mod:`psp3.drives`. A joint's ``slip`` is 1 or −1 for the way it slips, 0 while it
sticks. Between two events, a joint that comes to rest or one that lets go, slip is constant and the
motion is smooth, so that steps keep their order: a step in which something happens is cut there.
What happens and is undone within one step is not seen.

``drives`` has a row for every joint: reflected inertia, viscous and dry friction. ``net`` is what
is left of the forces for dry friction and acceleration, (M + J) a = net − friction.
"""

from __future__ import annotations

import math

import numpy as np

from fuzzy2.support.compiled import compiled
from psp3.checks import Array

INERTIA, VISCOUS, DRY = range(3)

ROUNDING = 1e-12
"""A joint lets go when the force on it exceeds its friction by more than this share of the forces
at work, where rounding ends.
"""

MOST_SWEEPS = 200
"""Sweeps of coordinate descent in the search for what sticks; a few do, unless two answers differ
by rounding alone.
"""

MOST_EVENTS = 50
"""Events in one step; after so many the rest of it is taken at once, and joints that turned back in
it are stopped at its end.
"""

RESOLUTION = 2.0**-44
"""Share of a step to which the time of an event is found: 1e-16 s of 2 ms."""


@compiled
def accelerations(mass: Array, net: Array, drives: Array, slip: Array, out: Array) -> None:
    """Write the accelerations of joints whose slip is given: those that stick have none."""
    n = net.size
    # Cholesky's method on the rows and columns of the joints that slip.
    factor = np.zeros((n, n))
    for i in range(n):
        out[i] = 0.0
        if slip[i] == 0.0:
            continue
        for j in range(i + 1):
            if slip[j] == 0.0:
                continue
            total = mass[i, j]
            for k in range(j):
                total -= factor[i, k] * factor[j, k]
            factor[i, j] = math.sqrt(total) if i == j else total / factor[j, j]
        total = net[i] - drives[i, DRY] * slip[i]
        for k in range(i):
            total -= factor[i, k] * out[k]
        out[i] = total / factor[i, i]
    for i in range(n - 1, -1, -1):
        if slip[i] == 0.0:
            continue
        total = out[i]
        for k in range(i + 1, n):
            total -= factor[k, i] * out[k]
        out[i] = total / factor[i, i]


@compiled
def spare_friction(mass: Array, net: Array, drives: Array, acceleration: Array, i: int) -> float:
    """Return how much more friction joint i, which sticks, could give.

    Where it is negative the joint lets go.
    """
    reaction = net[i]
    for j in range(net.size):
        reaction -= mass[i, j] * acceleration[j]
    spare: float = drives[i, DRY] + ROUNDING * (drives[i, DRY] + abs(net[i])) - abs(reaction)
    return spare


@compiled
def _is_solution(
    mass: Array, net: Array, drives: Array, speeds: Array, slip: Array, acceleration: Array
) -> bool:
    """Whether joints that stick can be held, and those that slip go the way of their slip.

    Of the joints at rest.
    """
    for i in range(net.size):
        if speeds[i] != 0.0 or drives[i, DRY] == 0.0:
            continue
        if slip[i] == 0.0:
            if spare_friction(mass, net, drives, acceleration, i) < 0.0:
                return False
        elif slip[i] * acceleration[i] < 0.0:
            return False
    return True


@compiled
def slip_of(drives: Array, speeds: Array, slip: Array) -> bool:
    """Write the slip of what moves, and that the rest sticks.

    Return whether there is a rest, whose slip is to be chosen.
    """
    some_rest = False
    for i in range(speeds.size):
        if drives[i, DRY] == 0.0 or speeds[i] > 0.0:
            slip[i] = 1.0
        elif speeds[i] < 0.0:
            slip[i] = -1.0
        else:
            slip[i], some_rest = 0.0, True
    return some_rest


@compiled
def choose_slip(mass: Array, net: Array, drives: Array, speeds: Array, slip: Array) -> None:
    """Improve what ``slip_of`` wrote to the slip that Gauss's principle gives.

    By coordinate descent; what can stick does.
    """
    n = net.size
    trial, acceleration = np.zeros(n), np.empty(n)
    for _ in range(MOST_SWEEPS):
        accelerations(mass, net, drives, slip, acceleration)
        if _is_solution(mass, net, drives, speeds, slip, acceleration):
            return
        for i in range(n):
            total = net[i]
            for j in range(n):
                if j != i:
                    total -= mass[i, j] * trial[j]
            if speeds[i] == 0.0 and drives[i, DRY] > 0.0:
                slip[i] = (
                    1.0 if total > drives[i, DRY] else (-1.0 if total < -drives[i, DRY] else 0.0)
                )
            trial[i] = 0.0 if slip[i] == 0.0 else (total - drives[i, DRY] * slip[i]) / mass[i, i]


@compiled
def stop_what_turned_back(drives: Array, speeds: Array, slip: Array) -> None:
    """Set the speed of joints to zero that go against their slip, and let them stick."""
    for i in range(speeds.size):
        if drives[i, DRY] > 0.0 and slip[i] * speeds[i] < 0.0:
            speeds[i] = slip[i] = 0.0
