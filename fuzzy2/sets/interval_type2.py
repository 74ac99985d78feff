r"""Interval type-2 fuzzy sets.

All secondary grades are 1, so the footprint of uncertainty (eq. 1.4) determines the set.

The footprint lies between two type-1 sets, the lower and the upper membership function. The
centroid of the set is the interval of the centroids of all type-1 sets embedded in the footprint
(eq. 1.70).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.sets.curves import refined
from fuzzy2.sets.pictures import ShownSet
from fuzzy2.sets.shapes import Gaussian, Interval
from fuzzy2.sets.type1 import ROUNDING, KernelRow, SampledSet, Type1Set, keep_nan, set_fields
from fuzzy2.sets.uncertain_mean import FarthestMeanGaussian, NearestMeanGaussian
from fuzzy2.support.checks import Array, ascending_pair, positive, real, reals, share, true_or_false
from fuzzy2.support.quadrature import Moments, merged

MOST_ITERATIONS = 1000  # about ten iterations are usual
FURTHEST_TAIL = np.array([12.0, 18.0, 26.0, 39.0])


@dataclass(frozen=True)
class IntervalType2Set(ShownSet):
    """Interval type-2 set between any two type-1 sets.

    ``fuzzy_set.lower`` and ``fuzzy_set.upper`` are type-1 sets, which are called with points, as in
    ``fuzzy_set.lower(x)``.

    Parameters
    ----------
    lower, upper : Type1Set
        Lower and upper membership function.

    Raises
    ------
    InvalidValue
        If the lower membership is above the upper one somewhere. Both are compared at every kink,
        on both sides of it, and at 64 points between each two kinks. That is exact for triangles,
        trapezoids, intervals and sampled sets.
    """

    lower: Type1Set
    upper: Type1Set

    def __post_init__(self) -> None:
        for name in ("lower", "upper"):
            if not isinstance(getattr(self, name), Type1Set):
                raise InvalidValue(name, getattr(self, name), "a type-1 set")
        check_below("lower", self.lower, "upper", self.upper)

    def footprint(self, x: ArrayLike) -> Array:
        r"""Return the primary membership :math:`J_x` at points (eq. 1.4).

        It is the interval that the footprint of uncertainty covers there.

        Parameters
        ----------
        x : (...,) array_like
            Points.

        Returns
        -------
        (..., 2) array
            Lower and upper grades.
        """
        points = reals("x", x)
        return np.stack([self.lower(points), self.upper(points)], axis=-1)

    @property
    def principal(self) -> EmbeddedSet:
        """Principal membership function.

        It is midway between the lower and the upper one, because all secondary grades are equal.
        """
        return EmbeddedSet(self, (), (0.5,))

    def secondary(self, x: float) -> Interval:
        """Return the vertical slice at a point, the interval between both memberships (eq. 1.3)."""
        low, high = self.footprint(real("x", x))
        return Interval(min(low, high), high)

    def alpha_plane(self, alpha: float) -> IntervalType2Set:
        """Return the set itself, because its secondary grades are all 1."""
        share("alpha", alpha)
        return self

    @property
    def support(self) -> tuple[float, float]:
        """Support of the upper membership function."""
        return self.upper.support

    @property
    def landmarks(self) -> Array:
        """Landmarks of both membership functions.

        They are ascending finite points between which both functions are smooth.
        """
        return merged(self.lower.landmarks, self.upper.landmarks)

    def centroid(self) -> tuple[float, float]:
        r"""Return the centroid on the continuous domain, eq. 1.70 with 1.68.

        It is found by quadrature and a root search.

        The left end is the smallest centroid of all embedded type-1 sets. The set with that
        centroid follows the upper membership function up to a switch point and the lower one after
        it, and the switch point equals the centroid:

        .. math::

            c_l = \frac{\int_{-\infty}^{c_l} x\,\overline\mu(x)\,dx
                + \int_{c_l}^{\infty} x\,\underline\mu(x)\,dx}
                       {\int_{-\infty}^{c_l} \overline\mu(x)\,dx
                           + \int_{c_l}^{\infty} \underline\mu(x)\,dx}

        For the right end the two functions are exchanged.

        Returns
        -------
        left, right : float
            Ends of the interval. If the lower membership has no area, they are the ends of the
            support.

        Raises
        ------
        NotApplicable
            If the set is unbounded and has no finite centroid.
        """
        points = self.upper.quadrature_points()
        first, last = float(points[0]), float(points[-1])
        if first == last:
            return first, first
        origin = 0.5 * first + 0.5 * last
        # The domain is cut at the kinks of both functions, because one may be zero where the other
        # is not.
        between = self.lower.landmarks
        points = merged(points, between[(between > first) & (between < last)])
        lower, upper = Moments(self.lower, points, origin), Moments(self.upper, points, origin)
        if upper.total[0] == 0.0:
            raise NotApplicable("centroid", f"the membership of {self!r} is zero almost everywhere")
        if lower.total[0] == 0.0:
            if not all(math.isfinite(end) for end in self.support):
                raise NotApplicable(
                    "centroid",
                    f"the lower membership of {self!r} has no area, and its support is unbounded",
                )
            return self.support
        return switch_point(upper, lower, origin), switch_point(lower, upper, origin)

    def embedded(
        self, choice: float | np.random.Generator, upper_first: bool = True
    ) -> EmbeddedSet:
        """Return a type-1 set embedded in the footprint of uncertainty (eq. 1.7).

        Parameters
        ----------
        choice : float or numpy.random.Generator
            A number is the switch point, where the set changes from one membership function to the
            other. A random generator draws, uniformly and for each interval between two landmarks,
            a constant share of the way from the lower to the upper membership function.
        upper_first : bool
            Whether the upper membership function comes before the switch point, as for the left end
            of the centroid. A random set ignores it.

        Returns
        -------
        EmbeddedSet
            The embedded set.
        """
        if isinstance(choice, np.random.Generator):
            edges = self.landmarks
            return EmbeddedSet(
                self, tuple(edges.tolist()), tuple(choice.uniform(size=edges.size + 1).tolist())
            )
        shares = (1.0, 0.0) if true_or_false("upper_first", upper_first) else (0.0, 1.0)
        return EmbeddedSet(
            self, (real("choice", choice, "a finite number, or a random generator"),), shares
        )

    def sample(self, x: ArrayLike) -> IntervalType2Set:
        """Return the set sampled at points (N,), with two :class:`SampledSet` as bounds."""
        return IntervalType2Set(lower=self.lower.sample(x), upper=self.upper.sample(x))

    def kernel_row(self) -> KernelRow | None:
        """Return the set as a row of numbers for the compiled kernels.

        It is None if only Python can evaluate the set.

        See :meth:`fuzzy2.sets.type1.Type1Set.kernel_row`. A pair of Gaussians with the same mean
        has a row.
        """
        low, high = self.lower, self.upper
        if isinstance(low, Gaussian) and isinstance(high, Gaussian) and low.mean == high.mean:
            return (
                0.0,
                low.mean,
                high.mean,
                low.sigma,
                high.sigma,
                low.height,
                high.height,
                0.0,
                0.0,
            )
        # A set without uncertainty is a type-1 set, and its lower function has the same row.
        return low.kernel_row() if low == high else None


@dataclass(frozen=True)
class GaussianUncertainMean(IntervalType2Set):
    r"""Gaussian whose mean is only known to lie between two values.

    .. math::

        \overline\mu(x) = e^{-(x - m)^2/(2 \sigma^2)},\ m = \min(\max(x, m_1), m_2), \qquad
        \underline\mu(x) = \min_{m \in \{m_1, m_2\}} e^{-(x - m)^2/(2 \sigma^2)}

    Parameters
    ----------
    mean : (float, float)
        Smallest and largest mean. Equal means make a type-1 set.
    sigma : float
        Standard deviation, above 0.

    Raises
    ------
    InvalidValue
        If the means are not two finite numbers in ascending order, or sigma is not above 0.
    """

    lower: FarthestMeanGaussian = field(init=False, repr=False, compare=False)
    upper: NearestMeanGaussian = field(init=False, repr=False, compare=False)
    mean: tuple[float, float]
    sigma: float

    def __post_init__(self) -> None:
        mean, sigma = ascending_pair("mean", self.mean), positive("sigma", self.sigma)
        set_fields(
            self,
            mean=mean,
            sigma=sigma,
            lower=FarthestMeanGaussian(mean, sigma),
            upper=NearestMeanGaussian(mean, sigma),
        )

    def kernel_row(self) -> KernelRow:
        """Return the set as a row of numbers for the compiled kernels.

        See :meth:`fuzzy2.sets.type1.Type1Set.kernel_row`.
        """
        return 0.0, *self.mean, self.sigma, self.sigma, 1.0, 1.0, 0.0, 0.0


@dataclass(frozen=True)
class GaussianUncertainSigma(IntervalType2Set):
    r"""Gaussian whose standard deviation is only known to lie between two values.

    .. math:: \overline\mu(x) = e^{-(x - m)^2/(2 \sigma_2^2)}, \qquad
              \underline\mu(x) = e^{-(x - m)^2/(2 \sigma_1^2)}

    Parameters
    ----------
    mean : float
        Mean.
    sigma : (float, float)
        Smallest and largest standard deviation, above 0. Equal ones make a type-1 set.

    Raises
    ------
    InvalidValue
        If the mean is not finite, or the standard deviations are not two finite numbers above 0 in
        ascending order.
    """

    lower: Gaussian = field(init=False, repr=False, compare=False)
    upper: Gaussian = field(init=False, repr=False, compare=False)
    mean: float
    sigma: tuple[float, float]

    def __post_init__(self) -> None:
        mean, sigma = real("mean", self.mean), ascending_pair("sigma", self.sigma)
        if sigma[0] <= 0.0:
            raise InvalidValue("sigma", self.sigma, "two finite numbers above 0 in ascending order")
        set_fields(
            self,
            mean=mean,
            sigma=sigma,
            lower=Gaussian(mean, sigma[0]),
            upper=Gaussian(mean, sigma[1]),
        )


@dataclass(frozen=True)
class EmbeddedSet(Type1Set):
    r"""Type-1 set embedded in the footprint of uncertainty of an interval type-2 set (eq. 1.7).

    .. math:: \mu(x) = \underline\mu(x) + \beta(x) \left(\overline\mu(x) - \underline\mu(x)\right)

    Parameters
    ----------
    footprint : IntervalType2Set
        The interval type-2 set that contains it.
    edges : sequence of E floats
        Ascending points at which the share :math:`\beta` jumps.
    shares : sequence of E + 1 floats
        Shares in [0, 1] before, between and after the edges. The next share holds from the edge
        itself.

    Raises
    ------
    InvalidValue
        If the edges are not ascending, if the shares are not in [0, 1], or if there is not one more
        share than edges.
    """

    footprint: IntervalType2Set
    edges: tuple[float, ...]
    shares: tuple[float, ...]

    def __post_init__(self) -> None:
        edges, shares = (
            tuple(real(name, value) for value in getattr(self, name))
            for name in ("edges", "shares")
        )
        if any(np.diff(edges) < 0.0):
            raise InvalidValue("edges", self.edges, "in ascending order")
        if len(shares) != len(edges) + 1 or not all(0.0 <= share <= 1.0 for share in shares):
            raise InvalidValue("shares", self.shares, f"{len(edges) + 1} numbers in [0, 1]")
        set_fields(self, edges=edges, shares=shares)

    @property
    def height(self) -> float:
        """Supremum of the sampled membership."""
        return self._sampled.height

    @cached_property
    def _sampled(self) -> SampledSet:
        return self.sample(refined(self._landmarks()))

    def _grades(self, x: Array) -> Array:
        share = np.asarray(self.shares)[np.searchsorted(self.edges, x, side="right")]
        low, high = self.footprint.lower(x), self.footprint.upper(x)
        return keep_nan(x, low + share * (high - low))

    def _slopes(self, x: Array) -> Array:
        share = np.asarray(self.shares)[np.searchsorted(self.edges, x, side="right")]
        low, high = self.footprint.lower.derivative(x), self.footprint.upper.derivative(x)
        return np.asarray(low + share * (high - low))

    def _support(self) -> tuple[float, float]:
        return self.footprint.support

    def _maxima(self) -> tuple[float, float]:
        return self._sampled._maxima()

    def _landmarks(self) -> Array:
        return merged(self.footprint.landmarks, self.edges)

    def _quadrature_points(self, power: int) -> Array:
        points = merged(self.footprint.upper.quadrature_points(power), self._landmarks())
        first, last = self._support()
        return points[(points >= first) & (points <= last)]

    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        return self._sampled.alpha_cut(alpha)

    def is_convex(self) -> bool:
        """Return whether the sampled membership rises to its maximum and then falls."""
        return self._sampled.is_convex()


def check_below(lower_name: str, lower: Type1Set, upper_name: str, upper: Type1Set) -> None:
    """Raise :class:`InvalidValue` where the membership ``lower`` is above ``upper``."""
    points = refined(merged(lower.landmarks, upper.landmarks))
    points = np.concatenate(
        [
            points,
            FURTHEST_TAIL * (points[-1] - points[0]) + points[-1],
            points[0] - FURTHEST_TAIL * np.ptp(points),
        ]
    )
    excess = lower(points) - upper(points)
    worst = int(np.argmax(excess))
    if excess[worst] > ROUNDING:
        grades = float(lower(points[worst])), float(upper(points[worst]))
        where = (
            f"at most {upper_name} everywhere, but at x = {points[worst]:.12g} they are "
            f"{grades[0]:.6g} and {grades[1]:.6g}"
        )
        raise InvalidValue(lower_name, lower, where)


def switch_point(before: Moments, after: Moments, origin: float) -> float:
    r"""Return the switch point, which equals the centroid of the set that switches there.

    That set has one membership before the switch point and the other after it.

    Newton's method solves :math:`\int (x - c)\,\mu_c(x)\,dx = 0`, which is the continuous
    Karnik-Mendel iteration, and is kept between bounds on both sides of the root. Where it
    converges slowly, because the lower membership is nearly zero, the interval is halved instead.
    """
    (low, high), point, last_step = before.ends, origin, math.inf
    best, smallest_step = point, math.inf
    for _ in range(MOST_ITERATIONS):
        area_before, moment_before = before.up_to(point)
        area_after, moment_after = after.beyond(point)
        step = origin + (moment_before + moment_after) / (area_before + area_after) - point
        if abs(step) < smallest_step:
            best, smallest_step = point, abs(step)
        low, high = (point, high) if step > 0.0 else (low, point)
        follower = point + step
        if abs(step) > 0.5 * abs(last_step) or not low <= follower <= high:
            follower = 0.5 * low + 0.5 * high
        if abs(step) <= 2.0 * np.finfo(float).eps * abs(point) or not low < follower < high:
            break
        point, last_step = follower, step
    return best
