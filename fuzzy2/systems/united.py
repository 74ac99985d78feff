r"""Centroid of the union of all consequents of one output, without a grid.

Each rule clips or scales its output set by its firing strength, and the sets are united or added
up. The centroid of the result is integrated between nodes, which are the kinks of all sets and the
points where the implication clips them. Between two nodes, Lobatto's rule must agree with the same
rule on both halves; otherwise the piece is halved. So no set is too narrow to be found, and linear
pieces are exact at once.

The centroid of an interval type-2 union is the interval :math:`[c_l, c_r]` of eq. 1.70, where
:math:`c_l` is the only zero of

.. math:: F(c) = \int_{-\infty}^{c} (c - x)\,\overline\mu(x)\,dx
          - \int_{c}^{\infty} (x - c)\,\underline\mu(x)\,dx,

which increases and is convex, so Newton's iteration from the right always finds it. :math:`c_r` is
found in the same way from the mirrored union.

Sets that are single points have no area. The centroid of a union of points is their average,
weighted with their grades after the implication. A union of points and sets with an area is
refused.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.operations.t_norms import TConorm, TNorm
from fuzzy2.reduction.defuzzification import defuzzify_samples
from fuzzy2.reduction.interval import generalized_centroid
from fuzzy2.sets.type1 import Type1Set
from fuzzy2.support.checks import Array
from fuzzy2.support.pieces import pieces
from fuzzy2.support.quadrature import merged
from fuzzy2.systems.averages import averaged
from fuzzy2.systems.maxima import maximum
from fuzzy2.systems.terms import domain_of

# Lobatto's rule with seven points, exact to degree 11. It evaluates the ends of a piece, so it
# detects a kink near an end that Gauss's points would miss. The ends are evaluated just inside,
# because sets may jump there.
_ROOTS = np.polynomial.legendre.Legendre.basis(6).deriv().roots()
_ALL = np.concatenate([[-1.0], _ROOTS.real, [1.0]])
NODES = (1.0 - 1e-11) * _ALL
WEIGHTS = 2.0 / (42.0 * np.polynomial.legendre.Legendre.basis(6)(_ALL) ** 2)
GAUSS = np.concatenate([NODES, WEIGHTS])
TOLERANCE = 1e-11
"""Two rules agree if they differ by this share of the area: of the whole for type-1 sets, of the
piece for interval type-2 ones, whose centroid may end on a tail."""
NEGLIGIBLE = 1e-280
"""Area below which grades are too small for a relative error."""
MOST_ROUGH = 1000
"""Greatest number of pieces of an input that are halved at a time."""
DEEPEST = 48
"""Greatest number of halvings, after which a piece is as narrow as the distance between two
floats."""
ITERATIONS = 100
"""Greatest number of Newton steps; about five are usual."""
_BETWEEN = 16  # points between two nodes at which maxima are searched
_HALVINGS = 60
BLOCK = 256
"""Number of inputs that are integrated at a time."""

_Membership = Callable[[NDArray[np.intp], Array], Array]


class _Pieces(NamedTuple):
    """Pieces of a block of unions, in the order of rows and points.

    ``areas`` and ``moments`` (P, 2) belong to the lower and the upper membership function. Moments
    are taken about the union's origin.
    """

    rows: NDArray[np.intp]
    left: Array
    right: Array
    areas: Array
    moments: Array


class United:
    """The output sets of all rules, prepared for unions with any firing strengths.

    Parameters
    ----------
    sets : sequence of R sets of type 1 or interval type-2 sets
        Consequent of each rule.
    implication : TNorm
        T-norm that combines a rule's firing strength with its output set.
    aggregation : TConorm, or None
        T-conorm that unites the rules' sets; None adds them up.
    ends : (float, float), optional
        Range of the output, outside which sets are ignored. By default it is the range that the
        sets cover (``terms.domain_of``): their supports, or for unbounded sets the part above
        exp(-12.5).

    Raises
    ------
    NotApplicable
        If some of the sets are single points, and others are not.
    InvalidValue
        If a set lies outside the range.
    """

    def __init__(
        self,
        sets: Sequence[Any],
        implication: TNorm,
        aggregation: TConorm | None,
        ends: tuple[float, float] | None,
    ) -> None:
        self._implication, self._aggregation = implication, aggregation
        self.crisp = all(isinstance(item, Type1Set) for item in sets)
        distinct: list[Any] = []
        for item in sets:
            if item not in distinct:
                distinct.append(item)
        self._number = np.array([distinct.index(item) for item in sets])
        self._first = np.array([sets.index(item) for item in distinct])
        # Under the maximum, only the largest firing of equal sets matters.
        self._by_set = aggregation is not None and aggregation.name == "max"
        self._sets = distinct if self._by_set else list(sets)
        upper = [item.upper for item in self._sets]
        self._check_range(ends)
        points = [one.support[0] == one.support[1] for one in upper]
        self.of_points = all(points)
        if any(points) and not self.of_points:
            raise NotApplicable(
                "the exact centroid of the rules' united sets",
                f"{upper[points.index(True)]!r} is a single point, which has no area beside "
                f"{upper[points.index(False)]!r}; take type_reduction='center_of_sets' or "
                "integration='sum', or points only",
            )
        if self.of_points:
            points_of = np.array([one.support[0] for one in upper])
            self._places, self._group = np.unique(points_of, return_inverse=True)
            at = zip(self._sets, points_of, strict=True)
            self._heights = np.array(
                [[float(item.lower(x)), float(item.upper(x))] for item, x in at]
            )
            return
        self._rows = self._kernel_rows()
        self._nodes = self._kinks(ends)
        self._ends = float(self._nodes[0]), float(self._nodes[-1])
        self._origin = 0.5 * self._ends[0] + 0.5 * self._ends[1]

    @property
    def compiled_sets(self) -> tuple[Array, NDArray[np.int64], Array] | None:
        """Rows of the sets, the set of each rule, and kinks; None if a set has no row."""
        if self.of_points or self._rows is None:
            return None
        numbers = self._number if self._by_set else np.arange(len(self._sets))
        return self._rows, numbers, self._nodes

    @property
    def sampled(self) -> tuple[Array, Array, NDArray[np.int64]] | None:
        """Single points (P,), grades of sets there (K, 2, P), set of each rule; None for areas."""
        if not self.of_points:
            return None
        at_own = self._group[:, np.newaxis] == np.arange(len(self._places))
        grades = np.where(at_own[:, np.newaxis], self._heights[..., np.newaxis], 0.0)
        numbers = self._number if self._by_set else np.arange(len(self._sets))
        return self._places, grades, numbers

    def _check_range(self, ends: tuple[float, float] | None) -> None:
        for item in self._sets:
            left, right = item.upper.support
            if ends is not None and (left > ends[1] or right < ends[0]):
                raise InvalidValue(
                    "output_ranges", ends, f"ranges that meet the support of {item!r:.80}"
                )

    def _kernel_rows(self) -> Array | None:
        """Return the sets as rows for the compiled loop, or None if a set has no row."""
        summed = self._aggregation is None
        if self._implication.name not in ("min", "product") or not (summed or self._by_set):
            return None
        rows = []
        for item in self._sets:
            own = item.kernel_row()
            both = (own, own) if own else (item.lower.kernel_row(), item.upper.kernel_row())
            if None in both or max(row[0] for row in both) > 1.0:
                return None
            rows += [(0.0, *row) for row in both]
        return np.array(rows, dtype=float).ravel()

    def _kinks(self, ends: tuple[float, float] | None) -> Array:
        """Return the ascending points, including both ends, between which all sets are smooth."""
        kinks = merged(*(self._own_kinks(item) for item in self._sets))
        left, right = domain_of(self._sets) if ends is None else ends
        return merged(kinks[(kinks > left) & (kinks < right)], (left, right))

    @staticmethod
    def _own_kinks(item: Any) -> Array:
        """Return the kinks of a set and points that locate it; few for Gaussians, for speed."""
        row = item.kernel_row()
        if row is None or row[0] != 0:
            return np.asarray(item.landmarks)
        means, sigma = np.array(row[1:3]), max(row[3:5])
        return merged(means, means.mean(), *(means + s * sigma for s in (-8, -2.5, 2.5, 8)))

    def _by_set_strengths(self, strengths: Array) -> Array:
        """Return the firing (n, K, 2) of the different sets, from the firing of the rules."""
        if not self._by_set:
            return strengths
        highest = np.zeros((len(strengths), len(self._sets), 2))
        for k in range(len(self._sets)):
            highest[:, k] = strengths[:, self._number == k].max(axis=1)
        return highest

    def average(self, strengths: Array, method: str, shares: tuple[float, float]) -> Array:
        """Return the outputs (n, 2), with both ends equal, by a direct method.

        Parameters
        ----------
        strengths : (n, R, 2) array
            Firing intervals.
        method : {"nie_tan", "begian_melek_mendel"}
            The centroid of the mean of both membership functions, or the weighted mean of the
            centroids of both.
        shares : (float, float)
            Weights of the centroid of the lower and of the upper membership function.
        """
        fired = self._by_set_strengths(strengths)
        if self.of_points:
            weights = self._weights_of_points(fired)
            return averaged(self._places, weights, method, shares)
        membership = self._membership(fired, False)
        pieces = self._integrated(membership, fired, False)
        areas, moments = (_by_row(values, pieces.rows, len(fired)) for values in pieces[3:])
        with np.errstate(invalid="ignore", divide="ignore"):
            if method == "nie_tan":
                middle = self._origin + moments.sum(axis=-1) / areas.sum(axis=-1)
            else:
                low, high = (self._origin + moments / areas).T
                middle = shares[0] * np.where(np.isnan(low), high, low) + shares[1] * high
        return np.stack([middle, middle], axis=-1)

    def bisectors(self, strengths: Array) -> Array:
        """Return the points (n,) that halve the areas of type-1 unions."""
        fired = self._by_set_strengths(strengths)
        if self.of_points:
            return self._bisectors_of_points(fired)
        membership = self._membership(fired, True)
        pieces = self._integrated(membership, fired, True)
        areas = pieces.areas[:, 0]
        starts = np.searchsorted(pieces.rows, np.arange(len(fired)))
        half = 0.5 * np.bincount(pieces.rows, areas, len(fired))
        before = _before(pieces.areas, starts)[:, 0]
        out = np.full(len(fired), np.nan)
        passed = np.flatnonzero((before + areas >= half[pieces.rows]) & (areas > 0.0))
        found = np.full(len(fired), -1)
        found[pieces.rows[passed][::-1]] = passed[::-1]
        rows = np.flatnonzero((found >= 0) & (half > 0.0))
        at = found[rows]
        start, low, high = pieces.left[at], pieces.left[at].copy(), pieces.right[at].copy()
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            own = self._rule(membership, rows, start, middle)[0, :, 0]
            short = before[at] + own < half[rows]
            low, high = np.where(short, middle, low), np.where(short, high, middle)
        out[rows] = 0.5 * (low + high)
        return out

    def _bisectors_of_points(self, fired: Array) -> Array:
        return defuzzify_samples(self._places, self._weights_of_points(fired)[..., 1], "bisector")

    def maxima(self, strengths: Array, kind: str) -> Array:
        """Return points (n,) of the greatest grades of type-1 unions; see ``operators.MAXIMA``."""
        fired = self._by_set_strengths(strengths)
        if self.of_points:
            return maximum(self._places, self._weights_of_points(fired)[..., 1], kind)
        membership = self._membership(fired, True)
        nodes = self._row_nodes(fired)
        steps = np.arange(_BETWEEN) / _BETWEEN
        # Points start just inside each piece, because sets may jump at its ends.
        width = np.diff(nodes, axis=1)
        inside = nodes[:, :-1, np.newaxis] + width[..., np.newaxis] * steps
        points = np.concatenate([inside.reshape(len(nodes), -1), nodes[:, -1:]], axis=1)
        rows = np.arange(len(fired))
        grades = membership(rows, points)[0]
        return maximum(points, grades, kind, lambda x: membership(rows, x)[0])

    def centroids(self, strengths: Array) -> Array:
        """Return the centroids (n, 2) of the unions under firing intervals (n, R, 2).

        A centroid is NaN where no rule fires.
        """
        strengths = self._by_set_strengths(strengths)
        if self.of_points:
            return self._of_points(strengths)
        out = np.empty((len(strengths), 2))
        start = 0
        if self._rows is not None:
            start = self._compiled(self._rows, strengths, out)
        while start < len(strengths):
            block = slice(start, start + BLOCK)
            out[block] = self._of_areas(strengths[block])
            start += BLOCK
        return out

    def _compiled(self, rows: Array, strengths: Array, out: Array) -> int:
        """Write the centroids with the compiled loop; return the first row that it refused."""
        from fuzzy2.systems.united_kernels import centroids_of_unions

        by_end = np.ascontiguousarray(np.moveaxis(strengths, 2, 1))
        crisp = self.crisp and np.array_equal(strengths[..., 0], strengths[..., 1])
        for part in pieces(len(strengths)):
            refused = centroids_of_unions(
                rows,
                by_end[part],
                self._implication.name == "product",
                self._aggregation is None,
                crisp,
                self._nodes,
                GAUSS,
                TOLERANCE,
                out[part],
            )
            if refused >= 0:
                return int(part.start + refused)
        return len(strengths)

    def _of_points(self, strengths: Array) -> Array:
        return generalized_centroid(self._places, self._weights_of_points(strengths))

    def _weights_of_points(self, strengths: Array) -> Array:
        """Return the grades (n, P, 2) of the union at its different points, in ascending order."""
        weights = self._implication(strengths, self._heights)
        return np.stack(
            [
                weights[:, self._group == k].sum(axis=1)
                if self._aggregation is None
                else self._aggregation.reduce(weights[:, self._group == k], axis=1)
                for k in range(len(self._places))
            ],
            axis=1,
        )

    def _of_areas(self, strengths: Array) -> Array:
        crisp = self.crisp and np.array_equal(strengths[..., 0], strengths[..., 1])
        membership = self._membership(strengths, crisp)
        pieces = self._integrated(membership, strengths, crisp)
        count = len(strengths)
        areas, moments = (_by_row(values, pieces.rows, count) for values in pieces[3:])
        with np.errstate(invalid="ignore", divide="ignore"):
            if crisp:
                centroid = self._origin + moments[:, 0] / areas[:, 0]
                return np.stack([centroid, centroid], axis=-1)
            left = self._left_end(pieces, membership, areas, moments)
            mirrored = _Pieces(
                (count - 1 - pieces.rows)[::-1],
                -pieces.right[::-1],
                -pieces.left[::-1],
                pieces.areas[::-1],
                -pieces.moments[::-1],
            )
            right = -self._left_end(
                mirrored,
                lambda rows, x: membership(count - 1 - rows, -x),
                areas[::-1],
                -moments[::-1],
                -self._origin,
            )[::-1]
        return np.stack([np.minimum(left, right), np.maximum(left, right)], axis=-1)

    def _membership(self, strengths: Array, crisp: bool) -> _Membership:
        """Return a function from rows (P,) and points (P, q) to grades of the union (2, P, q).

        For type-1 unions the result is (1, P, q).
        """
        ends = (1,) if crisp else (0, 1)

        def membership(rows: NDArray[np.intp], x: Array) -> Array:
            return np.stack([self._united(end, strengths[rows, :, end], x) for end in ends])

        return membership

    def _united(self, end: int, strengths: Array, x: Array) -> Array:
        """Return the grades of the lower or upper union at points (P, q), fired by (P, K)."""
        united: Array | None = None
        for k, item in enumerate(self._sets):
            grades = (item.upper if end else item.lower)(x)
            clipped = self._implication(strengths[:, k, np.newaxis], grades)
            if united is None:
                united = clipped
            else:
                united = (
                    united + clipped
                    if self._aggregation is None
                    else self._aggregation(united, clipped)
                )
        assert united is not None
        return united

    def _row_nodes(self, strengths: Array) -> Array:
        """Return the ascending nodes (n, N) of each row: kinks and points of clipping."""
        nodes = [np.broadcast_to(self._nodes, (len(strengths), len(self._nodes)))]
        name = self._implication.name
        if name in ("min", "nilpotent", "lukasiewicz"):
            for k, item in enumerate(self._sets):
                for end, part in ((0, item.lower), (1, item.upper)):
                    if (end == 0 and part is item.upper and self.crisp) or not part.is_convex():
                        continue
                    level = strengths[:, k, end] if name == "min" else 1.0 - strengths[:, k, end]
                    # Levels stay slightly below the height, because of rounding and because some
                    # sets never reach it.
                    cuts = part.alpha_cut(np.clip(level, 1e-300, part.height * (1.0 - 1e-12)))
                    nodes.append(np.stack(cuts, axis=-1))
        return np.sort(np.clip(np.concatenate(nodes, axis=1), *self._ends), axis=1)

    def _integrated(self, membership: _Membership, strengths: Array, crisp: bool) -> _Pieces:
        nodes = self._row_nodes(strengths)
        rows = np.repeat(np.arange(len(strengths)), nodes.shape[1] - 1)
        left, right = nodes[:, :-1].ravel(), nodes[:, 1:].ravel()
        keep = right > left
        rows, left, right = rows[keep], left[keep], right[keep]
        done: list[_Pieces] = []
        scale: Array = np.zeros(len(strengths))
        for depth in range(DEEPEST + 1):
            middle = 0.5 * (left + right)
            whole = self._rule(membership, rows, left, right)
            first = self._rule(membership, rows, left, middle)
            second = self._rule(membership, rows, middle, right)
            both = first + second
            if depth == 0:
                scale = np.bincount(rows, both[0, :, -1], len(strengths)).astype(float)
            reach = self._ends[1] - self._ends[0]
            sizes = scale[rows][:, np.newaxis] if crisp else both[0]
            # Points are themselves rounded, which looks like noise if a set varies within a piece.
            noise = 1e-15 * np.maximum(np.abs(left), np.abs(right)) / (right - left)
            allowed = (TOLERANCE + noise)[:, np.newaxis] * sizes + NEGLIGIBLE
            gap = np.abs(whole - both)
            rough = ((gap[0] > allowed) | (gap[1] > allowed * reach)).any(axis=-1)
            rough &= (left < middle) & (middle < right) & (depth < DEEPEST)
            if np.count_nonzero(rough) > MOST_ROUGH * len(strengths):
                # Halving does not make noise smoother.
                rough[:] = False
            fine = ~rough
            done.append(_Pieces(rows[fine], left[fine], right[fine], *both[:, fine]))
            if not rough.any():
                break
            left, middle, right = left[rough], middle[rough], right[rough]
            rows = np.concatenate([rows[rough], rows[rough]])
            left, right = np.concatenate([left, middle]), np.concatenate([middle, right])
        joined: list[Any] = [np.concatenate(column) for column in zip(*done, strict=True)]
        order = np.lexsort((joined[1], joined[0]))
        return _Pieces(*(column[order] for column in joined))

    def _rule(
        self, membership: _Membership, rows: NDArray[np.intp], left: Array, right: Array
    ) -> Array:
        """Return areas and moments (2, P, ends) over pieces."""
        half = 0.5 * (right - left)
        x = (0.5 * (left + right))[:, np.newaxis] + half[:, np.newaxis] * NODES
        weighted = membership(rows, x) * (half[:, np.newaxis] * WEIGHTS)
        return np.stack([weighted.sum(axis=-1).T, (weighted * (x - self._origin)).sum(axis=-1).T])

    def _left_end(
        self,
        pieces: _Pieces,
        membership: _Membership,
        areas: Array,
        moments: Array,
        origin: float | None = None,
    ) -> Array:
        """Return the left ends (n,) of the centroids.

        ``areas`` and ``moments`` (n, 2) are those of the whole unions.
        """
        center = self._origin if origin is None else origin
        count = len(areas)
        starts = np.searchsorted(pieces.rows, np.arange(count))
        before = [_before(values, starts) for values in (pieces.areas, pieces.moments)]
        after = [
            total[pieces.rows, 0] - (part[:, 0] + own[:, 0])
            for total, part, own in zip(
                (areas, moments), before, (pieces.areas, pieces.moments), strict=True
            )
        ]
        edge = pieces.right - center
        upper = [part[:, 1] + own[:, 1] for part, own in zip(before, pieces[3:], strict=True)]
        value = edge * upper[0] - upper[1] + edge * after[0] - after[1]
        # The first piece with a positive F at its right end contains the zero. If there is no lower
        # area, it is the first piece with an upper area, and the zero is its left end.
        found = np.full(count, -1)
        good = np.flatnonzero((value >= 0.0) & (upper[0] > 0.0))
        found[pieces.rows[good][::-1]] = good[::-1]
        rows = np.flatnonzero(found >= 0)
        ends = np.full(count, np.nan)
        if not rows.size:
            return ends
        at = found[rows]
        c, left, right = pieces.right[at].copy(), pieces.left[at], pieces.right[at]
        own_rows = pieces.rows[at]
        least = 1e-15 * (self._ends[1] - self._ends[0])
        for _ in range(ITERATIONS):
            low = self._partial(membership, own_rows, c, right, center)[:, :, 0]
            high = self._partial(membership, own_rows, left, c, center)[:, :, -1]
            mass_before, moment_before = (before[i][at, 1] + high[i] for i in (0, 1))
            mass_after, moment_after = (after[i][at] + low[i] for i in (0, 1))
            x = c - center
            slope = mass_before + mass_after
            error = x * mass_before - moment_before + x * mass_after - moment_after
            step = np.where(slope > 0.0, error / slope, 0.0)
            new = np.clip(c - step, left, right)
            moved = np.abs(new - c).max()
            c = new
            if moved <= least:
                break
        ends[rows] = c
        # Rounding may leave a small lower area where there is none.
        none = rows[areas[rows, 0] <= 0.0]
        ends[none] = pieces.left[found[none]]
        return ends

    def _partial(
        self,
        membership: _Membership,
        rows: NDArray[np.intp],
        left: Array,
        right: Array,
        center: float,
    ) -> Array:
        half = 0.5 * (right - left)
        x = (0.5 * (left + right))[:, np.newaxis] + half[:, np.newaxis] * NODES
        weighted = membership(rows, x) * (half[:, np.newaxis] * WEIGHTS)
        return np.stack([weighted.sum(axis=-1).T, (weighted * (x - center)).sum(axis=-1).T])


def _by_row(values: Array, rows: NDArray[np.intp], count: int) -> Array:
    """Return the sums (n, ends) of the values (P, ends) of each row's pieces."""
    return np.stack([np.bincount(rows, column, count) for column in values.T], axis=-1)


def _before(values: Array, starts: NDArray[np.intp]) -> Array:
    """Return the sums (P, ends) of the values of all pieces of a row before each piece.

    Each row has its own sum, because one over all rows would lose what is small in a row after
    another one that is not.
    """
    total = np.zeros_like(values)
    for start, end in itertools.pairwise([*starts.tolist(), len(values)]):
        np.cumsum(values[start : max(start, end - 1)], axis=0, out=total[start + 1 : end])
    return total
