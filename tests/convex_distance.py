"""Distances of convex solids, independent of coal.

Projections onto each in turn, with a certificate of how near the answer is.

The distance of two points, one in each solid, is an upper bound. A lower bound is the gap between
the solids in any direction, from their support functions. Here both are computed, so a result needs
no trust in the iteration.
"""

from __future__ import annotations

from typing import NamedTuple

import coal
import numpy as np
import pinocchio as pin

from tests.helpers import Array


class Solid(NamedTuple):
    """A cylinder on its z axis, a box or a ball.

    ``size`` (3,) is radius, radius and half length, the half edges, or thrice the radius.
    """

    kind: str
    size: Array
    rotation: Array
    translation: Array


def solid(shape: pin.GeometryObject, placement: pin.SE3) -> Solid:
    """Return one of Pinocchio's shapes where it is."""
    form = shape.geometry
    if isinstance(form, coal.Box):
        kind, size = "box", np.array(form.halfSide)
    elif isinstance(form, coal.Cylinder):
        kind, size = "cylinder", np.array([form.radius, form.radius, form.halfLength])
    else:
        kind, size = "ball", np.full(3, form.radius)
    return Solid(kind, size, placement.rotation.copy(), placement.translation.copy())


def projection(body: Solid, point: Array) -> Array:
    """Return the point of a solid that is nearest to a given one."""
    p = body.rotation.T @ (point - body.translation)
    if body.kind == "box":
        p = np.clip(p, -body.size, body.size)
    elif body.kind == "cylinder":
        across = np.hypot(p[0], p[1])
        scale = min(1.0, body.size[0] / across) if across > 0.0 else 1.0
        p = np.array([scale * p[0], scale * p[1], np.clip(p[2], -body.size[2], body.size[2])])
    else:
        p = p * min(1.0, body.size[0] / max(np.linalg.norm(p), 1e-300))
    return body.rotation @ p + body.translation


def support(body: Solid, direction: Array) -> float:
    """Return how far a solid reaches in a direction."""
    d = body.rotation.T @ direction
    if body.kind == "box":
        reach = np.abs(d) @ body.size
    elif body.kind == "cylinder":
        reach = body.size[0] * np.hypot(d[0], d[1]) + body.size[2] * abs(d[2])
    else:
        reach = body.size[0] * np.linalg.norm(d)
    return float(reach + direction @ body.translation)


def bounds(
    first: Solid, second: Solid, rounds: int = 20_000, gap: float = 1e-8
) -> tuple[float, float]:
    """Return a lower and an upper bound of the distance of two solids that do not overlap.

    Projected gradient steps on the squared distance with Nesterov's acceleration, from the middles.
    """
    one, other = first.translation.copy(), second.translation.copy()
    ahead_one, ahead_other, momentum = one, other, 1.0
    lower, upper = -np.inf, np.inf
    for k in range(rounds):
        middle = 0.5 * (ahead_one + ahead_other)
        new_one, new_other = projection(first, middle), projection(second, middle)
        following = 0.5 * (1.0 + np.sqrt(1.0 + 4.0 * momentum**2))
        share = (momentum - 1.0) / following
        # Back to plain steps where the momentum leads uphill.
        if (new_one - ahead_one) @ (new_one - one) + (new_other - ahead_other) @ (
            new_other - other
        ) < 0.0 and k:
            share, following = 0.0, 1.0
        ahead_one, ahead_other = (
            new_one + share * (new_one - one),
            new_other + share * (new_other - other),
        )
        one, other, momentum = new_one, new_other, following
        if k % 10 == 0:
            way = other - one
            length = float(np.linalg.norm(way))
            upper = min(upper, length)
            lower = max(lower, -support(second, -way / length) - support(first, way / length))
            if upper - lower < gap:
                break
    return lower, upper
