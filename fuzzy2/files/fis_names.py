"""What the names in ``.fis`` files mean: methods and membership functions."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from fuzzy2.errors import InvalidValue, NotExpressible
from fuzzy2.files.description import SUM
from fuzzy2.sets.interval_type2 import GaussianUncertainSigma, IntervalType2Set
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.sigmoids import Sigmoid, SigmoidDifference, SigmoidProduct
from fuzzy2.sets.smooth_shapes import Bell, PiShaped, TwoSidedGaussian
from fuzzy2.sets.type1 import Singleton, Type1Set
from fuzzy2.sets.uncertain_mean import NearestMeanGaussian

SAMPLE_POINTS = 101
"""Points of an output's range that MATLAB takes for the centroid, unless it is told otherwise."""

OPEN_TOOLBOX_SUFFIX = ".t2fis"

T_NORMS = {"min": "min", "prod": "product"}
AGGREGATIONS = {"max": "max", "probor": "probabilistic", "sum": SUM}
REDUCERS = {"karnikmendel": "km", "ekm": "ekm", "iasc": "iasc", "eiasc": "eiasc"}

OPEN_TOOLBOX_REDUCERS = {
    "KM": "km",
    "Karnik-Mendel": "km",
    "EKM": "ekm",
    "IASC": "iasc",
    "EIASC": "eiasc",
}


def _gaussian_combination(
    sigma1: float, mean1: float, sigma2: float, mean2: float, height: float
) -> Type1Set:
    if abs(sigma1) == abs(sigma2) and mean1 <= mean2:
        return _unscaled(NearestMeanGaussian((mean1, mean2), abs(sigma1)), height)
    return _unscaled(TwoSidedGaussian((mean1, mean2), (abs(sigma1), abs(sigma2))), height)


def _pi(a: float, b: float, c: float, d: float, height: float) -> Type1Set:
    # Where the foot is not left of the shoulder, there is a step midway between them.
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
    if height != 1.0:
        raise NotExpressible(f"a height of {height:g}", "fuzzy2", f"{type(made).__name__} has none")
    return made


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
    "sigmf": (2, lambda slope, center, height: _unscaled(Sigmoid(center, slope), height)),
    "dsigmf": (
        4,
        lambda s1, c1, s2, c2, height: _unscaled(SigmoidDifference((c1, c2), (s1, s2)), height),
    ),
    "psigmf": (
        4,
        lambda s1, c1, s2, c2, height: _unscaled(SigmoidProduct((c1, c2), (s1, s2)), height),
    ),
}
"""Shapes with the number of their parameters; what makes them takes the height last."""


def toolbox_shape(
    kind: str, parameters: list[float], lower: tuple[list[float], list[float]] | None
) -> Any:
    """Return a set of the Fuzzy Logic Toolbox.

    ``lower`` is the scale and the lags of a type-2 set.
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
    if left == right == 0.0:
        return pair_of_sets(_named_shape(kind, parameters, height), upper)
    if not isinstance(upper, Triangular | Trapezoidal):
        raise NotExpressible(
            f"a lag of {kind!r}", "fuzzy2", "what it means where sides are curved is not documented"
        )
    return pair_of_sets(_lagged(upper, left, right, height), upper)


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
    """Return a set of the open toolbox, whose height may follow its parameters."""
    count = _SHAPES[kind][0] if kind in _SHAPES else 0
    return (
        _named_shape(kind, parameters[:count], parameters[count])
        if len(parameters) == count + 1
        else _named_shape(kind, parameters, 1.0)
    )


def _named_shape(kind: str, parameters: list[float], height: float) -> Type1Set:
    if kind not in _SHAPES:
        raise NotExpressible(
            f"the membership function {kind!r}", "fuzzy2", f"known are {', '.join(_SHAPES)}"
        )
    count, make = _SHAPES[kind]
    if len(parameters) != count:
        raise InvalidValue("the parameters", parameters, f"{count} numbers")
    return make(*parameters, height)


def pair_of_sets(lower: Type1Set, upper: Type1Set) -> IntervalType2Set:
    """Return the interval type-2 set of two membership functions, a Gaussian one if it can be."""
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
    """Return the corners of a set with straight sides as a trapezoid."""
    if isinstance(one, Trapezoidal):
        return one.a, one.b, one.c, one.d
    if isinstance(one, Triangular):
        return one.left, one.peak, one.peak, one.right
    if isinstance(one, Interval):
        return one.left, one.left, one.right, one.right
    return (one.point,) * 4 if isinstance(one, Singleton) else None
