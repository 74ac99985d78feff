r"""Areas and moments of a membership function on the continuous domain, whole and up to any point.

The domain is cut at the kinks of the membership function. Each piece is halved until a
Gauss-Legendre rule with sixteen points agrees with the same rule on both halves. The error is
relative to the integral of the piece, not to that of the whole domain, because the centroid of an
interval type-2 set can lie far out on a tail, where all memberships are tiny.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import NotApplicable
from fuzzy2.support.checks import Array

NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)
TOLERANCE = 1e-13  # relative to a piece's own integral; sixteen points reach it before rounding
NEGLIGIBLE = 1e-280  # below this, denormal numbers lose relative accuracy
MOST_PIECES = 20_000
# number of halvings after which a piece at a jump is as narrow as the distance between two floats
DEEPEST = 60


class Moments:
    r"""Area and first moment of a membership function.

    They are :math:`\int \mu\,dx` and :math:`\int (x - x_0)\,\mu\,dx`.

    Parameters
    ----------
    membership : callable
        Maps points (...,) to grades (...,).
    points : (P,) array
        Ascending points from one end of the domain to the other, including every known kink.
    origin : float
        Point :math:`x_0` about which the moment is taken. A point near the middle of the set keeps
        cancellation small.

    Raises
    ------
    NotApplicable
        If the function is too rough for the quadrature to converge.
    """

    def __init__(self, membership: Callable[[Array], Array], points: Array, origin: float) -> None:
        self._membership, self._origin = membership, origin
        left, right = points[:-1], points[1:]
        edges, values = [points], []
        lefts = []
        for depth in range(DEEPEST + 1):
            whole = self._rule(left, right)
            middle = 0.5 * (left + right)
            halves = self._rule(
                np.concatenate([left, middle]), np.concatenate([middle, right])
            ).reshape(2, -1, 2)
            both = halves.sum(axis=0)
            reach = np.maximum(abs(left - origin), abs(right - origin))
            # Points are themselves rounded, which looks like noise if a membership function varies
            # within the piece.
            rounding = (
                8.0
                * np.finfo(float).eps
                * np.maximum(abs(left), abs(right))
                / np.maximum(right - left, NEGLIGIBLE)
            )
            allowed = ((TOLERANCE + rounding) * both[:, 0])[:, None] * np.stack(
                [np.ones_like(reach), reach], axis=-1
            ) + NEGLIGIBLE
            rough = (abs(whole - both) > allowed).any(axis=-1) & (left < middle) & (middle < right)
            if depth == DEEPEST:
                rough[:] = False
            lefts.append(left[~rough])
            values.append(both[~rough])
            if not rough.any():
                break
            if np.count_nonzero(rough) > MOST_PIECES:
                raise NotApplicable(
                    "quadrature",
                    f"the membership function is too rough near {float(left[rough][0]):.6g}",
                )
            edges.append(middle[rough])
            left, right = (
                np.concatenate([left[rough], middle[rough]]),
                np.concatenate([middle[rough], right[rough]]),
            )
        order = np.argsort(np.concatenate(lefts), kind="stable")
        pieces = np.concatenate(values)[order]
        self._edges = np.sort(np.concatenate(edges))
        # Sums run from both ends, because the small remainder on a tail must not be the difference
        # of two large sums.
        self._sums = np.concatenate([np.zeros((1, 2)), np.cumsum(pieces, axis=0)])
        self._rests = np.concatenate([np.cumsum(pieces[::-1], axis=0)[::-1], np.zeros((1, 2))])

    def _rule(self, left: Array, right: Array) -> Array:
        """Return (P, 2) areas and moments over the pieces [left, right], each of shape (P,)."""
        half = 0.5 * (right - left)
        x = (0.5 * (left + right))[:, None] + half[:, None] * NODES
        weighted = half[:, None] * WEIGHTS * self._membership(x)
        return np.stack(
            [weighted.sum(axis=-1), (weighted * (x - self._origin)).sum(axis=-1)], axis=-1
        )

    @property
    def total(self) -> tuple[float, float]:
        """Area and moment of the whole domain."""
        return float(self._sums[-1, 0]), float(self._sums[-1, 1])

    @property
    def ends(self) -> tuple[float, float]:
        """Ends of the domain."""
        return float(self._edges[0]), float(self._edges[-1])

    def up_to(self, x: float) -> tuple[float, float]:
        """Return area and moment from the left end of the domain to ``x``."""
        piece, x = self._piece(x)
        area, moment = (
            self._sums[piece] + self._rule(self._edges[piece : piece + 1], np.array([x]))[0]
        )
        return float(area), float(moment)

    def beyond(self, x: float) -> tuple[float, float]:
        """Return area and moment from ``x`` to the right end of the domain."""
        piece, x = self._piece(x)
        area, moment = (
            self._rests[piece + 1]
            + self._rule(np.array([x]), self._edges[piece + 1 : piece + 2])[0]
        )
        return float(area), float(moment)

    def _piece(self, x: float) -> tuple[int, float]:
        """Return the piece that contains ``x``, which is first limited to the domain."""
        x = min(max(x, float(self._edges[0])), float(self._edges[-1]))
        return min(int(np.searchsorted(self._edges, x, side="right")) - 1, len(self._edges) - 2), x

    def point_of_area(self, area: float) -> float:
        """Return the point where the area from the left end equals ``area``.

        It is found by bisection within one piece, down to neighboring floats.
        """
        piece = min(
            max(int(np.searchsorted(self._sums[:, 0], area, side="left")) - 1, 0),
            len(self._edges) - 2,
        )
        left, right = float(self._edges[piece]), float(self._edges[piece + 1])
        while True:
            middle = 0.5 * (left + right)
            if not left < middle < right:
                return middle
            if self.up_to(middle)[0] < area:
                left = middle
            else:
                right = middle


def merged(*points: ArrayLike) -> Array:
    """Return all points in ascending order, without duplicates."""
    return np.unique(np.concatenate([np.asarray(some, dtype=float).ravel() for some in points]))
