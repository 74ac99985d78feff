"""Joint ranges: poses inside them, and ranges that contain no closed pose."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from psp3.checks import Array

ROUNDING = 1e-6
"""A joint that is beyond a limit by at most this counts as at the limit [m, rad]."""


class Beyond(NamedTuple):
    """A joint outside its range in the reference pose. Its limit is removed."""

    joint: str
    position: float
    """Position of the joint [m or rad]."""
    limit: float
    """The exceeded limit [m or rad]."""

    def __str__(self) -> str:
        side = "below" if self.position < self.limit else "above"
        return f"{self.joint} at {self.position:.6g}, {side} {self.limit:.6g}"


def within_limits(model: pin.Model, q: Array) -> Array:
    """Return a configuration with every joint of one coordinate moved inside its limits."""
    inside = np.array(q, dtype=float)
    for _, at, low, high in _ranges(model):
        if not low <= inside[at] <= high:
            # Not onto the limit, because a leg may be stretched there.
            margin = 0.05 * min(high - low, 1.0)
            inside[at] = low + margin if inside[at] < low else high - margin
    return inside


def how_far_beyond(model: pin.Model, q: Array) -> float:
    """Return the sum over joints of one coordinate of the distance beyond their limits [m, rad].

    It is zero if all are inside, to rounding.
    """
    outside = (max(low - q[at], q[at] - high) for _, at, low, high in _ranges(model))
    return float(sum(one for one in outside if not one <= ROUNDING))


def freed(model: pin.Model, q: Array) -> tuple[pin.Model, tuple[Beyond, ...]]:
    """Return a model whose ranges contain a configuration, and the limits that were removed.

    If a joint is at a limit, to rounding, the limit is moved to the joint; if it is beyond, the
    limit is removed.
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
    """Yield name, place and limits of each joint of one coordinate that has limits."""
    for name, joint in zip(list(model.names)[1:], list(model.joints)[1:], strict=True):
        if joint.nq == 1:
            at = joint.idx_q
            low, high = float(model.lowerPositionLimit[at]), float(model.upperPositionLimit[at])
            # An infinite limit does not count, nor an upper limit below the lower one.
            if low <= high:
                yield str(name), at, low, high
