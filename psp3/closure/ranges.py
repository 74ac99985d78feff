"""Joint ranges: poses inside them, and ranges that no closed pose fits."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from psp3.checks import Array

ROUNDING = 1e-6
"""A joint that is beyond a limit by no more than this is at it [m, rad]."""


class Beyond(NamedTuple):
    """A joint that is outside its range in the reference pose, so that this limit cannot hold."""

    joint: str
    position: float
    """Where it is [m or rad]."""
    limit: float
    """The limit that it is beyond [m or rad]."""

    def __str__(self) -> str:
        side = "below" if self.position < self.limit else "above"
        return f"{self.joint} at {self.position:.6g}, {side} {self.limit:.6g}"


def within_limits(model: pin.Model, q: Array) -> Array:
    """Return a configuration with every joint of one coordinate brought inside its limits."""
    inside = np.array(q, dtype=float)
    for _, at, low, high in _ranges(model):
        if not low <= inside[at] <= high:
            # Not on the limit, where a leg may be stretched.
            margin = 0.05 * min(high - low, 1.0)
            inside[at] = low + margin if inside[at] < low else high - margin
    return inside


def how_far_beyond(model: pin.Model, q: Array) -> float:
    """Return by how much joints of one coordinate are beyond their limits, all together [m, rad].

    Zero where all are inside, to rounding.
    """
    outside = (max(low - q[at], q[at] - high) for _, at, low, high in _ranges(model))
    return float(sum(one for one in outside if not one <= ROUNDING))


def freed(model: pin.Model, q: Array) -> tuple[pin.Model, tuple[Beyond, ...]]:
    """Return a model whose ranges hold a configuration, and what had to be done for it.

    A limit that a joint is at, to rounding, is moved to where the joint is; one that a joint is
    beyond is taken away.
    """
    made, beyond = model, []
    for name, at, low, high in _ranges(model):
        if low <= q[at] <= high:
            continue
        if made is model:
            made = model.copy()
        limits = made.lowerPositionLimit if q[at] < low else made.upperPositionLimit
        limit = low if q[at] < low else high
        if abs(q[at] - limit) <= ROUNDING:
            limits[at] = q[at]
        else:
            limits[at] = -np.inf if q[at] < low else np.inf
            beyond.append(Beyond(name, float(q[at]), limit))
    return made, tuple(beyond)


def _ranges(model: pin.Model) -> Iterator[tuple[str, int, float, float]]:
    """Yield name, place and limits of each joint of one coordinate that has any."""
    for name, joint in zip(list(model.names)[1:], list(model.joints)[1:], strict=True):
        if joint.nq == 1:
            at = joint.idx_q
            low, high = float(model.lowerPositionLimit[at]), float(model.upperPositionLimit[at])
            # A limit that is at infinity, or below the other, is none.
            if low <= high:
                yield str(name), at, low, high
