"""Meaning of the membership functions in ``.fis`` files."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any, NamedTuple

from fuzzy2.errors import InvalidValue, NotExpressible
from fuzzy2.sets.derived import Truncated
from fuzzy2.sets.interval_type2 import GaussianUncertainSigma, IntervalType2Set
from fuzzy2.sets.lagged import Lagged
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.sigmoids import Sigmoid, SigmoidDifference, SigmoidProduct
from fuzzy2.sets.smooth_shapes import Bell, PiShaped, TwoSidedGaussian
from fuzzy2.sets.type1 import SampledSet, Singleton, Type1Set
from fuzzy2.sets.uncertain_mean import NearestMeanGaussian

_WITH_HEIGHT = (Triangular, Trapezoidal, Gaussian, PiShaped)
"""Classes with a height."""


def _gaussian_combination(
    sigma1: float, mean1: float, sigma2: float, mean2: float, height: float
) -> Type1Set:
    if abs(sigma1) == abs(sigma2) and mean1 <= mean2:
        return _unscaled(NearestMeanGaussian((mean1, mean2), abs(sigma1)), height)
    return _unscaled(TwoSidedGaussian((mean1, mean2), (abs(sigma1), abs(sigma2))), height)


def _pi(a: float, b: float, c: float, d: float, height: float) -> Type1Set:
    # If the foot is not to the left of the shoulder, there is a step midway between them.
    if math.isfinite(a) and a >= b:
        a = b = 0.5 * a + 0.5 * b
    if math.isfinite(d) and c >= d:
        c = d = 0.5 * c + 0.5 * d
    if b > c:
        raise NotExpressible(
            "pimf with shoulders that cross",
            "fuzzy2",
            "the second shoulder must not be left of the first one",
        )
    return PiShaped(a, b, c, d, height)


def _unscaled(made: Type1Set, height: float) -> Type1Set:
    """Return a set without a height, given its class, scaled to a height."""
    return made if height == 1.0 else Lagged(made, (0.0, 0.0), height)


def _ramp(start: float, end: float, height: float) -> Type1Set:
    if start <= end:
        return Trapezoidal(start, end, math.inf, math.inf, height)
    return Trapezoidal(-math.inf, -math.inf, end, start, height)


def _sigmoid(slope: float, center: float) -> Type1Set:
    if slope == 0.0:
        raise NotExpressible("sigmf with the slope 0", "fuzzy2", "it is 1/2 everywhere")
    return Sigmoid(center, slope)


_SHAPES: dict[str, tuple[int, Callable[..., Type1Set]]] = {
    "trimf": (3, Triangular),
    "trapmf": (4, Trapezoidal),
    "linsmf": (2, lambda a, b, height: Trapezoidal(a, b, math.inf, math.inf, height)),
    "linzmf": (2, lambda a, b, height: Trapezoidal(-math.inf, -math.inf, a, b, height)),
    "smf": (2, lambda a, b, height: _pi(a, b, math.inf, math.inf, height)),
    "zmf": (2, lambda a, b, height: _pi(-math.inf, -math.inf, a, b, height)),
    "pimf": (4, _pi),
    "gaussmf": (2, lambda sigma, mean, height: Gaussian(mean, abs(sigma), height)),
    "gauss2mf": (4, _gaussian_combination),
    "gbellmf": (
        3,
        lambda width, slope, center, height: _unscaled(Bell(center, abs(width), slope), height),
    ),
    "sigmf": (2, lambda slope, center, height: _unscaled(_sigmoid(slope, center), height)),
    "dsigmf": (
        4,
        lambda s1, c1, s2, c2, height: _unscaled(SigmoidDifference((c1, c2), (s1, s2)), height),
    ),
    "psigmf": (
        4,
        lambda s1, c1, s2, c2, height: _unscaled(SigmoidProduct((c1, c2), (s1, s2)), height),
    ),
    # Shapes of fuzzylite.
    "rectmf": (2, lambda left, right, height: _unscaled(Interval(left, right), height)),
    "rampmf": (2, _ramp),
}
"""Shapes with the number of their parameters; their constructors take the height last."""


def toolbox_shape(
    kind: str, parameters: list[float], lower: tuple[list[float], list[float]] | None
) -> Any:
    """Return a set for a shape of the Fuzzy Logic Toolbox.

    ``lower`` holds the scale and the lags of a type-2 set.
    """
    upper = _named_shape(kind, parameters, 1.0)
    if lower is None:
        return upper
    scale, lag = lower
    if (
        len(scale) != 1
        or len(lag) not in (1, 2)
        or not all(0.0 <= value <= 1.0 for value in (*scale, *lag))
    ):
        raise InvalidValue("[scale],[lags]", (scale, lag), "one number and one or two, in [0, 1]")
    height, (left, right) = scale[0], (lag[0], lag[-1])
    if height == 1.0 and left == right == 0.0:
        return upper
    if height == 0.0:
        raise NotExpressible(
            "a scale of 0", "fuzzy2", "the lower membership function must be above 0"
        )
    if left == right == 0.0 and isinstance(upper, _WITH_HEIGHT):
        return pair_of_sets(dataclasses.replace(upper, height=height), upper)
    if isinstance(upper, Triangular | Trapezoidal):
        return pair_of_sets(_lagged(upper, left, right, height), upper)
    return pair_of_sets(Lagged(upper, (left, right), height), upper)


def _lagged(upper: Triangular | Trapezoidal, left: float, right: float, height: float) -> Type1Set:
    if isinstance(upper, Triangular):
        foot, other_foot = (
            upper.left + left * (upper.peak - upper.left),
            upper.right - right * (upper.right - upper.peak),
        )
        return Triangular(min(foot, upper.peak), upper.peak, max(other_foot, upper.peak), height)
    a = upper.a if math.isinf(upper.a) else min(upper.a + left * (upper.b - upper.a), upper.b)
    d = upper.d if math.isinf(upper.d) else max(upper.d - right * (upper.d - upper.c), upper.c)
    return Trapezoidal(a, upper.b, upper.c, d, height)


def open_toolbox_shape(kind: str, parameters: list[float]) -> Type1Set:
    """Return a set for a shape of the open toolbox, whose height may follow its parameters."""
    count = _SHAPES[kind][0] if kind in _SHAPES else 0
    return (
        _named_shape(kind, parameters[:count], parameters[count])
        if len(parameters) == count + 1
        else _named_shape(kind, parameters, 1.0)
    )


def _named_shape(kind: str, parameters: list[float], height: float) -> Type1Set:
    if kind == "discretemf":
        return _discrete(parameters)
    if kind not in _SHAPES:
        raise NotExpressible(
            f"the membership function {kind!r}", "fuzzy2", f"known are {', '.join(_SHAPES)}"
        )
    count, make = _SHAPES[kind]
    # Files of version 1 pad parameters to four numbers with zeros.
    if len(parameters) > count and not any(parameters[count:]):
        parameters = parameters[:count]
    if len(parameters) != count:
        raise InvalidValue("the parameters", parameters, f"{count} numbers")
    return make(*parameters, height)


def _discrete(parameters: list[float]) -> Type1Set:
    if len(parameters) < 4 or len(parameters) % 2:
        raise InvalidValue("the parameters", parameters, "pairs of points and grades, at least two")
    return SampledSet(parameters[::2], parameters[1::2])


class Crossing(NamedTuple):
    """Two membership functions of the open toolbox that cross within the range.

    They do not bound a footprint, but the toolbox multiplies and averages both anyway.
    """

    lower: Type1Set
    upper: Type1Set


def inside_range(lower: Type1Set, upper: Type1Set, ends: tuple[float, float]) -> Type1Set:
    """Return a lower membership function, cut off at the ends of a range if necessary.

    That is necessary if it is above the upper function beyond the range.
    """
    if isinstance(lower, Gaussian) and isinstance(upper, Gaussian):
        below, above = lower, upper
        if below.mean == above.mean and below.sigma <= above.sigma:
            return lower
    try:
        IntervalType2Set(lower=lower, upper=upper)
    except InvalidValue:
        return Truncated(lower, *ends)
    return lower


def pair_of_sets(lower: Type1Set, upper: Type1Set) -> IntervalType2Set:
    """Return the interval type-2 set of two membership functions, a Gaussian one if possible."""
    if (
        isinstance(lower, Gaussian)
        and isinstance(upper, Gaussian)
        and lower.mean == upper.mean
        and lower.height == upper.height == 1.0
    ):
        return (
            GaussianUncertainSigma(lower.mean, (lower.sigma, upper.sigma))
            if lower.sigma <= upper.sigma
            else IntervalType2Set(lower, upper)
        )
    return IntervalType2Set(lower=lower, upper=upper)


def corners_of(one: Type1Set) -> tuple[float, float, float, float] | None:
    """Return the corners of a set with straight sides, as those of a trapezoid."""
    if isinstance(one, Trapezoidal):
        return one.a, one.b, one.c, one.d
    if isinstance(one, Triangular):
        return one.left, one.peak, one.peak, one.right
    if isinstance(one, Interval):
        return one.left, one.left, one.right, one.right
    return (one.point,) * 4 if isinstance(one, Singleton) else None


def named_shape(one: Type1Set) -> tuple[str, tuple[float, ...], float] | None:
    """Return kind, parameters and height of a set; None if the toolbox does not have its shape."""
    if isinstance(one, Trapezoidal) and math.isinf(one.a) and math.isfinite(one.d):
        return "linzmf", (one.c, one.d), one.height
    if isinstance(one, Trapezoidal) and math.isinf(one.d) and math.isfinite(one.a):
        return "linsmf", (one.a, one.b), one.height
    corners = corners_of(one)
    if corners is not None and all(map(math.isfinite, corners)):
        return (
            ("trimf", (corners[0], *corners[2:]), one.height)
            if isinstance(one, Triangular)
            else ("trapmf", corners, one.height)
        )
    if isinstance(one, PiShaped) and (math.isfinite(one.a) or math.isfinite(one.d)):
        corners = one.a, one.b, one.c, one.d
        kind = "zmf" if math.isinf(one.a) else "smf" if math.isinf(one.d) else "pimf"
        return kind, tuple(filter(math.isfinite, corners)), one.height
    return _named_curve(one)


def _named_curve(one: Type1Set) -> tuple[str, tuple[float, ...], float] | None:
    match one:
        case Gaussian():
            return "gaussmf", (one.sigma, one.mean), one.height
        case NearestMeanGaussian():
            return "gauss2mf", (one.sigma, one.mean[0], one.sigma, one.mean[1]), 1.0
        case TwoSidedGaussian():
            return "gauss2mf", (one.sigma[0], one.mean[0], one.sigma[1], one.mean[1]), 1.0
        case SigmoidDifference() | SigmoidProduct():
            (c1, c2), (s1, s2) = one.center, one.slope
            kind = "dsigmf" if isinstance(one, SigmoidDifference) else "psigmf"
            return kind, (s1, c1, s2, c2), 1.0
        case Bell():
            return "gbellmf", (one.width, one.slope, one.center), 1.0
        case Sigmoid():
            return "sigmf", (one.slope, one.center), 1.0
    return None
