"""Compiled dynamics of driven joints.

They determine which joints stick and how the others accelerate, for Runge–Kutta steps from event to
event.

The laws are in :mod:`psp3.drives`. A joint's ``slip`` is 1 or −1 for the direction in which it
slips, and 0 while it sticks. An event is a joint that comes to rest, or one at rest that starts to
move. Between events slip is constant and the motion is smooth, so steps keep their order of
accuracy if they are divided at events. Two opposite events within one step are missed.

``drives`` has a row for every joint: reflected inertia, viscous and dry friction. ``net`` is the
part of the forces that remains for dry friction and acceleration, (M + J) a = net − friction.
"""

from __future__ import annotations

import math

import numpy as np

from fuzzy2.support.compiled import compiled
from psp3.checks import Array

INERTIA, VISCOUS, DRY = range(3)

ROUNDING = 1e-12
"""A joint starts to move when the force on it exceeds its friction by more than this share of the
acting forces, a margin for rounding.
"""

MOST_SWEEPS = 200
"""Most sweeps of coordinate descent in the search for sticking joints. A few suffice, unless two
solutions differ only by rounding.
"""

MOST_EVENTS = 50
"""Most events in one step. After these the rest of the step is taken at once, and joints that
reversed in it are stopped at its end.
"""

RESOLUTION = 2.0**-44
"""Accuracy of the time of an event, as a share of a step: 1e-16 s for a step of 2 ms."""


@compiled
def accelerations(mass: Array, net: Array, drives: Array, slip: Array, out: Array) -> None:
    """Write the accelerations of joints with given slip; those that stick have none."""
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
    """Return how much more friction the sticking joint i could provide.

    If it is negative, the joint starts to move.
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
    """Return whether sticking joints can be held, and slipping ones move in their direction.

    Only joints at rest are checked.
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
    """Write the slip of moving joints; those at rest stick for now.

    Return whether any joint is at rest, for which slip must be chosen.
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
    """Improve the slip from ``slip_of`` to the one of Gauss's principle.

    The method is coordinate descent; joints that can stick do so.
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
    """Stop joints that move against their slip, and let them stick."""
    for i in range(speeds.size):
        if drives[i, DRY] > 0.0 and slip[i] * speeds[i] < 0.0:
            speeds[i] = slip[i] = 0.0
