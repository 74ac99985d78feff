"""General type-2 sets with a principal membership and Gaussian secondary memberships."""

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
    """Bound of an α-plane: the principal membership shifted up or down and limited to [0, 1].

    Compiled kernels read it as a row of numbers, which :mod:`fuzzy2.systems.shape_kernels` defines.
    """

    row: KernelRow | None = None

    def _kernel_row(self) -> KernelRow | None:
        return self.row


@dataclass(frozen=True)
class GaussianType2Set(GeneralType2Set):
    r"""General type-2 set with Gaussian vertical slices, truncated to [0, 1].

    The slices are centered on a principal membership function.

    .. math:: \mu(x, u) = \exp\left(-\frac{(u - m(x))^2}{2\,\sigma(x)^2}\right), \quad u \in [0, 1]

    A Gaussian is positive everywhere, so the footprint of uncertainty is all of [0, 1] where sigma
    is positive. Figures show ``alpha_plane(0.01)`` instead.

    Parameters
    ----------
    principal : Type1Set
        Principal membership function m. The attribute keeps the given set, including its part
        outside the domain.
    sigma : float or callable
        Standard deviation of the slices: a number, or a function from points (...,) to numbers
        (...,). It must not be negative; 0 means a crisp slice.
    domain : (float, float)
        Domain of the set; unbounded by default. An α-plane has a centroid only if the domain is
        bounded.

    Raises
    ------
    InvalidValue
        If sigma is negative or not finite (a function is checked where it is evaluated), or if the
        domain does not meet the principal set.
    """

    # without it the property of the base class would be taken for a default
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
        """The domain; for a crisp set, its intersection with the support of the principal set."""
        left, right = self.principal.support
        return (
            (max(left, self.domain[0]), min(right, self.domain[1]))
            if self.sigma == 0.0
            else self.domain
        )

    @property
    def landmarks(self) -> Array:
        """The landmarks of the principal set within the domain, and the ends of the domain."""
        ends = [end for end in self.support if math.isfinite(end)]
        points = self.principal.landmarks
        return merged(points[(points >= self.support[0]) & (points <= self.support[1])], ends)

    def secondary(self, x: float) -> Type1Set:
        """Return the vertical slice at a point.

        It is a Gaussian truncated to [0, 1], or a singleton where sigma is 0 (eq. 1.3).
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
        # At alpha = 0 a Gaussian extends over all of [0, 1], but one of width 0 is a single point.
        reach = np.where(
            spreads > 0.0,
            gaussian_reach(np.array(alpha), np.maximum(spreads, np.finfo(float).tiny)),
            0.0,
        )
        return np.maximum(memberships - reach, 0.0), np.minimum(memberships + reach, 1.0)

    def _bound_set(self, alpha: float, end: int) -> FunctionalSet:
        found = super()._bound_set(alpha, end)
        row = self.principal.kernel_row()
        # Kernels know these planes only for Gaussian and trapezoidal principal sets, constant
        # spreads and unbounded domains.
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
        # If the width varies with the points, the slope of the plane needs the slope of the width.
        return None if callable(self.sigma) else partial(self._bound_slopes, alpha=alpha, end=end)

    def _kinks_of_bound(self, alpha: float, end: int) -> Array:
        if callable(self.sigma) or self.sigma == 0.0 or not self.principal.is_convex():
            return np.empty(0)
        # Points where the membership is cut off at 0 or 1. A search for a supremum that does not
        # know them misses narrow overlaps.
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
        # only constant spreads come here
        reach = gaussian_reach(np.array(alpha), float(self.sigma))  # type: ignore[arg-type]
        # Where the bound is cut off at 0 or 1, its slope is 0 unless the principal membership leads
        # back into [0, 1].
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
