"""Motions of robots to differentiate."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

import psp3
from tests.helpers import Array


def swing(
    robot: psp3.ClosedLoopRobot, seed: int = 0
) -> Callable[[float], tuple[Array, Array, Array]]:
    """Return a smooth motion of the actuated joints near the reference pose.

    Positions, speeds, accelerations at a time.
    """
    rng = np.random.default_rng(seed)
    size, rate, phase = (
        rng.uniform(low, high, len(robot.actuated))
        for low, high in ((0.02, 0.06), (2.0, 4.0), (0.0, 6.0))
    )

    def motion(t: float) -> tuple[Array, Array, Array]:
        angle = rate * t + phase
        return (
            robot.reference + size * np.sin(angle),
            size * rate * np.cos(angle),
            -size * rate**2 * np.sin(angle),
        )

    return motion
