"""Compiled dynamics of driven joints: which of them stick, how the others accelerate, and Runge–Kutta steps from event to event.

The laws are in :mod:`psp3.drives`. A joint's ``slip`` is 1 or −1 for the way it slips, 0 while it sticks. Between two events, a joint
that comes to rest or one that lets go, slip is constant and the motion is smooth, so that steps keep their order: a step in which
something happens is cut there. What happens and is undone within one step is not seen.

``drives`` has a row for every joint: reflected inertia, viscous and dry friction. ``net`` is what is left of the forces for dry friction
and acceleration, (M + J) a = net − friction.
"""

from __future__ import annotations

import math

import numpy as np

from fuzzy2.compiled import compiled
from psp3.arrays import Array
from psp3.closed_form import equation_of_motion, forward_kinematics

INERTIA, VISCOUS, DRY = range(3)

ROUNDING = 1e-12
"""A joint lets go when the force on it exceeds its friction by more than this share of the forces at work, where rounding ends."""

MOST_SWEEPS = 200
"""Sweeps of coordinate descent in the search for what sticks; a few do, unless two answers differ by rounding alone."""

MOST_EVENTS = 50
"""Events in one step; after so many the rest of it is taken at once, and joints that turned back in it are stopped at its end."""

MOST_TRIALS = 60
"""Trials in the search for the time of an event; some eight do."""

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
    """Return how much more friction joint i, which sticks, could give; where it is negative the joint lets go."""
    reaction = net[i]
    for j in range(net.size):
        reaction -= mass[i, j] * acceleration[j]
    spare: float = drives[i, DRY] + ROUNDING * (drives[i, DRY] + abs(net[i])) - abs(reaction)
    return spare


@compiled
def _is_solution(mass: Array, net: Array, drives: Array, speeds: Array, slip: Array, acceleration: Array) -> bool:
    """Whether the joints at rest that stick can be held, and those that slip go the way of their slip."""
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
    """Write the slip of what moves, and that the rest sticks; return whether there is a rest, whose slip is to be chosen."""
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
    """Improve what ``slip_of`` wrote to the slip that Gauss's principle gives, by coordinate descent; what can stick does."""
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
                slip[i] = 1.0 if total > drives[i, DRY] else (-1.0 if total < -drives[i, DRY] else 0.0)
            trial[i] = 0.0 if slip[i] == 0.0 else (total - drives[i, DRY] * slip[i]) / mass[i, i]


@compiled
def stop_what_turned_back(drives: Array, speeds: Array, slip: Array) -> None:
    """Set the speed of joints to zero that go against their slip, and let them stick."""
    for i in range(speeds.size):
        if drives[i, DRY] > 0.0 and slip[i] * speeds[i] < 0.0:
            speeds[i] = slip[i] = 0.0


# The 3-PSP


@compiled
def _balance(state: Array, forces: Array, p: Array, drives: Array, mass: Array, net: Array) -> None:
    """Write M + J and what is left of the forces; NaN where the pose is none of the machine's."""
    full = np.empty(21)
    if equation_of_motion(state[:3], state[3:], p, full) >= 0:
        full[:] = math.nan
    for i in range(3):
        net[i] = forces[i] - full[18 + i] - drives[i, VISCOUS] * state[3 + i]
        for j in range(3):
            mass[i, j] = full[3 * i + j]
            net[i] -= full[9 + 3 * i + j] * state[3 + j]
        mass[i, i] += drives[i, INERTIA]


@compiled
def _step(
    state: Array, forces: Array, duration: float, p: Array, drives: Array, slip: Array, mass: Array, net: Array, rates: Array, new: Array
) -> None:
    """Write the state after one step of the classical Runge–Kutta method with constant slip; ``rates`` is scratch space (4, 6)."""
    acceleration = np.empty(3)
    for i in range(6):
        new[i] = state[i]
    for stage in range(4):
        _balance(new, forces, p, drives, mass, net)
        accelerations(mass, net, drives, slip, acceleration)
        for i in range(3):
            rates[stage, i], rates[stage, 3 + i] = new[3 + i], acceleration[i]
        share = duration if stage == 2 else 0.5 * duration
        for i in range(6):
            new[i] = state[i] + share * rates[stage, i]
    for i in range(6):
        new[i] = state[i] + duration / 6.0 * (rates[0, i] + 2.0 * (rates[1, i] + rates[2, i]) + rates[3, i])


@compiled
def _margin(state: Array, forces: Array, p: Array, drives: Array, slip: Array, mass: Array, net: Array) -> float:
    """Return what is left until a joint comes to rest or lets go, in m/s or N; negative once it has happened."""
    margin, sticks = math.inf, False
    for i in range(3):
        if slip[i] == 0.0:
            sticks = True
        elif drives[i, DRY] > 0.0:
            margin = min(margin, slip[i] * state[3 + i])
    if sticks:
        acceleration = np.empty(3)
        _balance(state, forces, p, drives, mass, net)
        accelerations(mass, net, drives, slip, acceleration)
        for i in range(3):
            if slip[i] == 0.0:
                margin = min(margin, spare_friction(mass, net, drives, acceleration, i))
    return margin


@compiled
def _first_event(
    state: Array, forces: Array, step: float, p: Array, drives: Array, slip: Array, mass: Array, net: Array, rates: Array, new: Array
) -> float:
    """Write the state just after the first event in a step that has one, and return its time: false position (Illinois)."""
    high, above = step, _margin(new, forces, p, drives, slip, mass, net)
    # A joint that has just let go has no margin at first, so that a time must be found when it has.
    low, below = high, above
    while below < 0.0 and low > RESOLUTION * step:
        high, above, low = low, below, 0.5 * low
        _step(state, forces, low, p, drives, slip, mass, net, rates, new)
        below = _margin(new, forces, p, drives, slip, mass, net)
    if below < 0.0:
        return low
    for _ in range(MOST_TRIALS):
        if high - low <= RESOLUTION * step:
            break
        time = (low * above - high * below) / (above - below)
        if not low < time < high:
            time = 0.5 * (low + high)
        _step(state, forces, time, p, drives, slip, mass, net, rates, new)
        margin = _margin(new, forces, p, drives, slip, mass, net)
        # An end that stays counts for half, so that it does not stay for ever.
        if margin < 0.0:
            high, above, below = time, margin, 0.5 * below
        else:
            low, below, above = time, margin, 0.5 * above
    _step(state, forces, high, p, drives, slip, mass, net, rates, new)
    return high


@compiled
def advance_driven(state: Array, forces: Array, step: float, steps: int, p: Array, drives: Array) -> bool:
    """Do as ``closed_form.advance`` for a robot with drives, an array (3, 3)."""
    mass, net, rates, new, slip = np.empty((3, 3)), np.empty(3), np.empty((4, 6)), np.empty(6), np.zeros(3)
    for _ in range(steps):
        left = step
        for event in range(MOST_EVENTS + 1):
            if slip_of(drives, state[3:], slip):
                _balance(state, forces, p, drives, mass, net)
                choose_slip(mass, net, drives, state[3:], slip)
            part = left
            _step(state, forces, part, p, drives, slip, mass, net, rates, new)
            if event < MOST_EVENTS and _margin(new, forces, p, drives, slip, mass, net) < 0.0:
                part = _first_event(state, forces, part, p, drives, slip, mass, net, rates, new)
            stop_what_turned_back(drives, new[3:], slip)
            state[:] = new
            left -= part
            if left <= 0.0:
                break
    total = state[3] + state[4] + state[5]
    valid: bool = math.isfinite(total) and forward_kinematics(state[:3], p, np.empty(18)) < 0
    return valid
