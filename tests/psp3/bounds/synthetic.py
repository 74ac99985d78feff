"""Runs of unit masses under a servo and a disturbance that is known: kinematics only."""

from __future__ import annotations

import numpy as np

from psp3.checks import Array
from psp3.simulation.result import Result
from psp3.trajectories.motion import Motion

KP, KV, PERIOD = 100.0, 20.0, 0.01


def disturbed(
    disturbances: Array,
    start: tuple[float, float] = (0.0, 0.0),
    kp: float = KP,
    kv: float = KV,
    period: float = PERIOD,
) -> Result:
    """Return a run that is to stay at zero, under disturbances (periods, parts, k)."""
    periods, parts, k = disturbances.shape
    part = period / parts
    states = np.empty((periods + 1, 2, k))
    states[0] = -np.array(start)[:, np.newaxis]
    for j, row in enumerate(disturbances):
        position, speed = states[j]
        servo = -kp * position - kv * speed
        for disturbance in row:
            acceleration = servo + disturbance
            position = position + part * speed + 0.5 * part**2 * acceleration
            speed = speed + part * acceleration
        states[j + 1] = position, speed
    still = np.zeros((periods + 1, k))
    nowhere = np.full((periods + 1, 3), np.nan)
    return Result(
        period * np.arange(periods + 1),
        states[:, 0].copy(),
        states[:, 1].copy(),
        Motion(still, still, still, nowhere),
        still,
        nowhere,
    )


def constant(sizes: Array, periods: int = 60) -> Result:
    """Return a run under constant disturbances (k,)."""
    return disturbed(np.broadcast_to(np.asarray(sizes, dtype=float), (periods, 1, len(sizes))))
