"""Compiled Runge–Kutta steps of any robot with drives, from one friction event to the next.

An event is a joint that stops or starts slipping. A robot is a table of
:mod:`psp3.dynamics.compiled_robot`. States are positions and speeds (p + n,). With a floating base
there are more positions than speeds, and the rates of the positions are not the speeds.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from fuzzy2.support.compiled import compiled
from psp3.checks import Array
from psp3.drives.kernels import (
    DRY,
    MOST_EVENTS,
    RESOLUTION,
    accelerations,
    choose_slip,
    slip_of,
    spare_friction,
    stop_what_turned_back,
)
from psp3.dynamics.compiled_robot import balance, is_state, write_rates

MOST_TRIALS = 60
"""The largest number of trials in the search for the time of an event; about eight are enough."""


@compiled
def _speed_margin(drives: Array, slip: Array, state: Array) -> float:
    """Return the smallest speed of the slipping joints, which are at rest when it is zero."""
    p, margin = state.size - slip.size, math.inf
    for i in range(slip.size):
        if slip[i] != 0.0 and drives[i, DRY] > 0.0:
            margin = min(margin, slip[i] * state[p + i])
    return margin


@compiled
def _force_margin(mass: Array, net: Array, drives: Array, slip: Array, rate: Array) -> float:
    """Return the smallest force that a sticking joint can still hold, at accelerations ``rate``."""
    margin = math.inf
    for i in range(slip.size):
        if slip[i] == 0.0:
            margin = min(margin, spare_friction(mass, net, drives, rate, i))
    return margin


@compiled
def _some_stick(slip: Array) -> bool:
    for i in range(slip.size):  # noqa: SIM110 (compiled: a loop, not a generator)
        if slip[i] == 0.0:
            return True
    return False


@compiled
def _trial(
    robot: Any,
    state: Array,
    forces: Array,
    duration: float,
    drives: Array,
    slip: Array,
    mass: Array,
    net: Array,
    rates: Array,
    new: Array,
) -> float:
    """Write the state after one step with constant slip, and return its margin.

    The method is the classical Runge–Kutta; ``rates`` is scratch space (4, p + n). The margin is
    the speed or force [N] that remains until a joint comes to rest or starts to slip; it is
    negative after the event. ``balance`` is called at one place only, because each call may take
    long to compile.
    """
    n, size = net.size, state.size
    p, acceleration, margin = size - n, np.empty(n), math.inf
    for i in range(size):
        new[i] = state[i]
    for stage in range(5):
        if stage == 4:
            for i in range(size):
                new[i] = state[i] + duration / 6.0 * (
                    rates[0, i] + 2.0 * (rates[1, i] + rates[2, i]) + rates[3, i]
                )
            margin = _speed_margin(drives, slip, new)
        # After the last stage this only normalizes the quaternions.
        write_rates(robot, new, rates[stage % 4])
        if stage == 4 and not _some_stick(slip):
            return margin
        balance(robot, new, forces, drives, mass, net)
        accelerations(mass, net, drives, slip, acceleration)
        if stage < 4:
            share = duration if stage == 2 else 0.5 * duration
            for i in range(n):
                rates[stage, p + i] = acceleration[i]
            for i in range(size):
                new[i] = state[i] + share * rates[stage, i]
    return min(margin, _force_margin(mass, net, drives, slip, acceleration))


@compiled
def _first_event(
    robot: Any,
    state: Array,
    forces: Array,
    step: float,
    last: float,
    drives: Array,
    slip: Array,
    mass: Array,
    net: Array,
    rates: Array,
    new: Array,
) -> float:
    """Write the state just after the first event in a step, and return its time.

    ``last`` is the margin at the end of the step, which is negative. The method is false position
    (Illinois variant).
    """
    # A joint that has just started to slip has a margin of zero, so a time with a positive margin
    # is needed first.
    high, above, low, below = step, last, step, last
    while below < 0.0 and low > RESOLUTION * step:
        high, above, low = low, below, 0.5 * low
        below = _trial(robot, state, forces, low, drives, slip, mass, net, rates, new)
    if below < 0.0:
        return low
    for trial in range(MOST_TRIALS + 1):
        is_found = high - low <= RESOLUTION * step or trial == MOST_TRIALS
        time = (low * above - high * below) / (above - below)
        if not low < time < high:
            time = 0.5 * (low + high)
        if is_found:
            time = high
        margin = _trial(robot, state, forces, time, drives, slip, mass, net, rates, new)
        if is_found:
            break
        # The value at an end that stays is halved, so that it does not stay forever.
        if margin < 0.0:
            high, above, below = time, margin, 0.5 * below
        else:
            low, below, above = time, margin, 0.5 * above
    return high


@compiled
def advance_driven(
    robot: Any, state: Array, forces: Array, step: float, steps: int, drives: Array
) -> bool:
    """Take steps under constant forces, in place; each step is divided at its events.

    ``drives`` has a row for each of the n speeds, see :mod:`psp3.drives.kernels`. Return whether
    the robot can be in the final state.
    """
    n, size = drives.shape[0], state.size
    p = size - n
    mass, net, slip = np.empty((n, n)), np.empty(n), np.zeros(n)
    rates, new = np.empty((4, size)), np.empty(size)
    for _ in range(steps):
        left = step
        for event in range(MOST_EVENTS + 1):
            if slip_of(drives, state[p:], slip):
                balance(robot, state, forces, drives, mass, net)
                choose_slip(mass, net, drives, state[p:], slip)
            part = left
            margin = _trial(robot, state, forces, part, drives, slip, mass, net, rates, new)
            if event < MOST_EVENTS and margin < 0.0:
                part = _first_event(
                    robot, state, forces, part, margin, drives, slip, mass, net, rates, new
                )
            stop_what_turned_back(drives, new[p:], slip)
            for i in range(size):
                state[i] = new[i]
            left -= part
            if left <= 0.0:
                break
    valid: bool = is_state(robot, state)
    return valid
