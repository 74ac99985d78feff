"""General type-2 sets whose principal and secondary memberships are Gaussian."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import InvalidValue
from fuzzy2.sets.curves import gaussian, gaussian_reach
from fuzzy2.sets.derived import FunctionalSet, Truncated
from fuzzy2.sets.general_type2 import GeneralType2Set
from fuzzy2.sets.shapes import Gaussian
from fuzzy2.sets.type1 import KernelRow, Singleton, Type1Set, pair_of_numbers, set_fields
from fuzzy2.support.checks import Array, ascending, real, reals
from fuzzy2.support.quadrature import merged


@dataclass(frozen=True)
class MovedMembership(FunctionalSet):
    """Bound of an α-plane: the principal membership, moved up or down and kept in [0, 1].

    Compiled kernels know it by a row, the one of :mod:`fuzzy2.systems.shape_kernels`.
    """

    row: KernelRow | None = None

    def _kernel_row(self) -> KernelRow | None:
        return self.row


@dataclass(frozen=True)
class GaussianType2Set(GeneralType2Set):
    r"""General type-2 set with Gaussian vertical slices, truncated to [0, 1].

    They lie about a principal membership.

    .. math:: \mu(x, u) = \exp\left(-\frac{(u - m(x))^2}{2\,\sigma(x)^2}\right), \quad u \in [0, 1]

    A Gaussian is positive everywhere, so that the footprint of uncertainty is all of [0, 1] where
    sigma is positive. What a picture shows of it is ``alpha_plane(0.01)``.

    Parameters
    ----------
    principal : Type1Set
        Principal membership function m. The attribute is the set as given, also outside of the
        domain.
    sigma : float or callable
        Standard deviation of the slices: a number, or a function from points (...,) to numbers
        (...,). Not negative; 0 is crisp.
    domain : (float, float)
        Domain of the set; unbounded by default. An α-plane needs a bounded one to have a centroid.

    Raises
    ------
    InvalidValue
        If sigma is negative or not finite (a function: where it is evaluated), or the domain does
        not meet the principal set.
    """

    # without it the property of the base would be taken for a default
    principal: Type1Set = field()
    sigma: float | Callable[[Array], ArrayLike]
    domain: tuple[float, float] = (-math.inf, math.inf)

    def __post_init__(self) -> None:
        if not isinstance(self.principal, Type1Set):
            raise InvalidValue("principal", self.principal, "a type-1 set")
        if not callable(self.sigma):
            set_fields(
                self,
                sigma=real("sigma", self.sigma, "a finite number of at least 0, or a function"),
            )
            self.spread(0.0)
        left, right = pair_of_numbers("domain", self.domain, "two numbers in ascending order")
        ascending("domain", (left, right))
        set_fields(self, domain=(left, right))
        if self.principal.support[0] > right or self.principal.support[1] < left:
            raise InvalidValue(
                "domain",
                self.domain,
                f"an interval that meets the support {self.principal.support}",
            )

    def spread(self, x: ArrayLike) -> Array:
        """Return the standard deviations of the vertical slices at points.

        Parameters
        ----------
        x : (...,) array_like
            Points.

        Returns
        -------
        (...,) array
            Standard deviations.

        Raises
        ------
        InvalidValue
            If the function ``sigma`` returns a negative number, or one that is not finite.
        """
        points = reals("x", x)
        spreads = np.broadcast_to(
            np.asarray(self.sigma(points) if callable(self.sigma) else self.sigma, dtype=float),
            points.shape,
        )
        if not ((spreads >= 0.0) & np.isfinite(spreads)).all():
            raise InvalidValue("sigma", spreads, "finite numbers of at least 0")
        return spreads

    @property
    def support(self) -> tuple[float, float]:
        """Domain; of a crisp set, what of the support of the principal set lies in it."""
        left, right = self.principal.support
        return (
            (max(left, self.domain[0]), min(right, self.domain[1]))
            if self.sigma == 0.0
            else self.domain
        )

    @property
    def landmarks(self) -> Array:
        """Those of the principal set within the domain, and the ends of the domain."""
        ends = [end for end in self.support if math.isfinite(end)]
        points = self.principal.landmarks
        return merged(points[(points >= self.support[0]) & (points <= self.support[1])], ends)

    def secondary(self, x: float) -> Type1Set:
        """Return the vertical slice at a point.

        A Gaussian truncated to [0, 1], or a singleton where sigma is 0 (eq. 1.3).
        """
        point = np.array(real("x", x))
        membership, sigma = float(self._principal(point)), float(self.spread(point))
        inside = self.domain[0] <= x <= self.domain[1]
        return (
            Truncated(Gaussian(membership, sigma), 0.0, 1.0)
            if sigma > 0.0 and inside
            else Singleton(membership)
        )

    def _principal(self, x: Array) -> Array:
        return np.where((x >= self.domain[0]) & (x <= self.domain[1]), self.principal(x), 0.0)

    def _inside_spread(self, x: Array) -> Array:
        return np.where((x >= self.domain[0]) & (x <= self.domain[1]), self.spread(x), 0.0)

    def _cut(self, x: Array, alpha: float) -> tuple[Array, Array]:
        memberships, spreads = self._principal(x), self._inside_spread(x)
        # At alpha = 0 a Gaussian reaches everywhere, but one of no width nowhere.
        reach = np.where(
            spreads > 0.0,
            gaussian_reach(np.array(alpha), np.maximum(spreads, np.finfo(float).tiny)),
            0.0,
        )
        return np.maximum(memberships - reach, 0.0), np.minimum(memberships + reach, 1.0)

    def _bound_set(self, alpha: float, end: int) -> FunctionalSet:
        found = super()._bound_set(alpha, end)
        row = self.principal.kernel_row()
        # Of other principal sets, spreads that change and bounded domains no kernel knows planes.
        if row is None or row[0] > 1.0 or callable(self.sigma) or np.isfinite(self.domain).any():
            return found
        reach = float(gaussian_reach(np.array(alpha), self.sigma)) if self.sigma > 0.0 else 0.0
        kind, *numbers = row[:8]
        # Kinds 11 and 12 of the kernels.
        moved: Any = (kind + 11.0, *numbers, reach if end else -reach)
        return MovedMembership(
            found.function, found.left, found.right, found.knots, found.slope, row=moved
        )

    def _slope_of_bound(self, alpha: float, end: int) -> Callable[[Array], Array] | None:
        # Slices of a width that is a function of the points have a plane whose slope needs that of
        # the function.
        return None if callable(self.sigma) else partial(self._bound_slopes, alpha=alpha, end=end)

    def _kinks_of_bound(self, alpha: float, end: int) -> Array:
        if callable(self.sigma) or self.sigma == 0.0 or not self.principal.is_convex():
            return np.empty(0)
        # Where a membership is cut off at 0 or 1. A search for a supremum that does not know of it
        # misses narrow overlaps.
        reach = float(gaussian_reach(np.array(alpha), self.sigma))
        membership = reach if end == 0 else 1.0 - reach
        if not 0.0 < membership < self.principal.height:
            return np.empty(0)
        ends = np.array(self.principal.alpha_cut(membership))
        return ends[np.isfinite(ends)]

    def _bound_slopes(self, x: Array, alpha: float, end: int) -> Array:
        slopes = self.principal.derivative(x)
        if self.sigma == 0.0:
            return slopes
        # no function comes here
        reach = gaussian_reach(np.array(alpha), float(self.sigma))  # type: ignore[arg-type]
        # Where a membership is cut off at 0 or 1, its slope is that of the principal one only if
        # that leads back.
        if end == 0:
            room = self.principal(x) - reach
            return np.where(room > 0.0, slopes, np.where(room == 0.0, np.maximum(slopes, 0.0), 0.0))
        room = 1.0 - reach - self.principal(x)
        return np.where(room > 0.0, slopes, np.where(room == 0.0, np.minimum(slopes, 0.0), 0.0))

    def _secondary_grades(self, x: Array, u: Array) -> Array:
        memberships, spreads = self._principal(x), self._inside_spread(x)
        grades = np.where(
            spreads > 0.0,
            gaussian(u, memberships, np.where(spreads > 0.0, spreads, 1.0)),
            u == memberships,
        )
        return np.where((u >= 0.0) & (u <= 1.0), grades, 0.0)
