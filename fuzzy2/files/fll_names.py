"""Names of fuzzylite (7 and 8) for terms, norms, hedges and defuzzifiers."""

from __future__ import annotations

import math
from collections.abc import Callable
from types import MappingProxyType
from typing import Any

from fuzzy2.errors import InvalidValue, NotExpressible
from fuzzy2.files.description import SUM, Constant, LinearFunction
from fuzzy2.files.functions import FormulaFunction
from fuzzy2.sets.formula_set import FormulaSet
from fuzzy2.sets.named_shape import NamedShape
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.sigmoids import Sigmoid, SigmoidDifference, SigmoidProduct
from fuzzy2.sets.smooth_shapes import Bell, PiShaped, TwoSidedGaussian
from fuzzy2.sets.type1 import SampledSet, Type1Set
from fuzzy2.systems.hedges import HEDGES, Hedge, intensify, relax

T_NORMS = {
    "AlgebraicProduct": "product",
    "BoundedDifference": "lukasiewicz",
    "DrasticProduct": "drastic",
    "EinsteinProduct": "einstein",
    "HamacherProduct": "hamacher",
    "Minimum": "min",
    "NilpotentMinimum": "nilpotent",
}

S_NORMS = {
    "AlgebraicSum": "probabilistic",
    "BoundedSum": "lukasiewicz",
    "DrasticSum": "drastic",
    "EinsteinSum": "einstein",
    "HamacherSum": "hamacher",
    "Maximum": "max",
    "NilpotentMaximum": "nilpotent",
    # (a + b)/max(1, a + b) equals min(1, a + b).
    "NormalizedSum": "lukasiewicz",
    "UnboundedSum": SUM,
}

INTEGRALS = {
    "Bisector": "bisector",
    "Centroid": "centroid",
    "LargestOfMaximum": "largest_of_maxima",
    "MeanOfMaximum": "mean_of_maxima",
    "SmallestOfMaximum": "smallest_of_maxima",
}

RESOLUTION = 1000
"""Number of points of fuzzylite's sums if a file does not give one (100 in version 6)."""

FLL_HEDGES = MappingProxyType(
    {
        hedge.name: hedge
        for hedge in (
            Hedge("extremely", function=intensify),
            Hedge("seldom", function=relax),
            HEDGES["somewhat"],
            HEDGES["very"],
        )
    }
)
"""fuzzylite's hedges; its "extremely" is Zadeh's intensification."""

_MONOTONIC = ("Arc", "Concave", "Ramp", "Sigmoid", "SShape", "ZShape")
"""Terms of Tsukamoto's systems."""


def _trapezoid(a: float, b: float, c: float, d: float, height: float) -> Type1Set:
    # A foot at infinity means that the membership is 1 up to the shoulder.
    left, right = (-math.inf, -math.inf) if a == -math.inf else (a, b), (c, d)
    return Trapezoidal(*left, *((math.inf, math.inf) if d == math.inf else right), height)


def _triangle(a: float, b: float, c: float, height: float) -> Type1Set:
    if math.isfinite(a) and math.isfinite(c):
        return Triangular(a, b, c, height)
    return _trapezoid(a, b, b, c, height)


def _ramp(start: float, end: float, height: float) -> Type1Set:
    if start == end:
        raise InvalidValue("start and end", (start, end), "two different numbers")
    if start < end:
        return Trapezoidal(start, end, math.inf, math.inf, height)
    return Trapezoidal(-math.inf, -math.inf, end, start, height)


def _rectangle(start: float, end: float, height: float) -> Type1Set:
    left, right = min(start, end), max(start, end)
    if height == 1.0:
        return Interval(left, right)
    return Trapezoidal(left, left, right, right, height)


def _bell(center: float, width: float, slope: float, height: float) -> Type1Set:
    if height == 1.0 and width > 0.0 and slope > 0.0:
        return Bell(center, width, slope)
    return NamedShape("bell", (center, width, slope), height)


def _sigmoid(inflection: float, slope: float, height: float) -> Type1Set:
    if height == 1.0:
        return Sigmoid(inflection, slope)
    return NamedShape("sigmoid", (inflection, slope), height)


def _shape(name: str) -> Callable[..., Type1Set]:
    return lambda *numbers: NamedShape(name, numbers[:-1], numbers[-1])


_TERMS: dict[str, tuple[int, Callable[..., Type1Set]]] = {
    "Arc": (2, _shape("arc")),
    "Bell": (3, _bell),
    "Binary": (2, _shape("binary")),
    "Concave": (2, _shape("concave")),
    "Cosine": (2, _shape("cosine")),
    "Gaussian": (2, lambda mean, sigma, height: Gaussian(mean, abs(sigma), height)),
    "GaussianProduct": (4, _shape("gaussian_product")),
    "PiShape": (4, lambda a, b, c, d, height: PiShaped(a, b, c, d, height)),
    "Ramp": (2, _ramp),
    "Rectangle": (2, _rectangle),
    "SemiEllipse": (2, _shape("semi_ellipse")),
    "Sigmoid": (2, _sigmoid),
    "SigmoidDifference": (4, _shape("sigmoid_difference")),
    "SigmoidProduct": (4, _shape("sigmoid_product")),
    "Spike": (2, _shape("spike")),
    "SShape": (2, lambda a, b, height: PiShaped(a, b, math.inf, math.inf, height)),
    "Trapezoid": (4, _trapezoid),
    "Triangle": (3, _triangle),
    "ZShape": (2, lambda a, b, height: PiShaped(-math.inf, -math.inf, a, b, height)),
}
"""Terms with the number of their parameters; their constructors take the height last."""

KINDS = (*_TERMS, "Constant", "Discrete", "Linear")
"""Terms that are defined by numbers; "Function" is defined by a text."""


def is_monotonic(kind: str) -> bool:
    """Return whether fuzzylite can invert terms of a kind, which Tsukamoto's systems need."""
    return kind in _MONOTONIC


def term_of(kind: str, numbers: list[float], inputs: int | None) -> Any:
    """Return the term for a term of fuzzylite.

    Parameters
    ----------
    kind : str
        Class of the term in fuzzylite.
    numbers : list of float
        Parameters of the term, and its height if it has one.
    inputs : int, or None
        Number of inputs, for a term of an output.

    Raises
    ------
    NotExpressible
        If this package has no such set.
    InvalidValue
        If the parameters are not those of the term.
    """
    if kind not in KINDS:
        raise NotExpressible(
            f"the term {kind!r}", "fuzzy2", f"known are {', '.join((*KINDS, 'Function'))}"
        )
    if kind == "Constant" and inputs is not None:
        if len(numbers) != 1 or not math.isfinite(numbers[0]):
            raise InvalidValue("the value", numbers, "a finite number")
        return Constant(numbers[0], numbers[0])
    if kind == "Constant":
        return NamedShape("constant", tuple(numbers))
    if kind == "Linear":
        return _linear(numbers, inputs)
    if kind == "Discrete":
        height = numbers[-1] if len(numbers) % 2 else 1.0
        return NamedShape("discrete", tuple(numbers[: len(numbers) // 2 * 2]), height)
    count, make = _TERMS[kind]
    if len(numbers) not in (count, count + 1):
        raise InvalidValue("the parameters", numbers, f"{count} numbers, or one more, the height")
    return make(*numbers[:count], numbers[count] if len(numbers) > count else 1.0)


def _linear(numbers: list[float], inputs: int | None) -> LinearFunction:
    if inputs is None:
        raise NotExpressible("the term 'Linear' of an input", "fuzzy2", "it is not a set")
    if len(numbers) not in (inputs, inputs + 1) or not all(map(math.isfinite, numbers)):
        raise InvalidValue(
            "the parameters",
            numbers,
            f"{inputs} finite numbers, one for each input, and perhaps the constant",
        )
    return LinearFunction(
        numbers[inputs] if len(numbers) > inputs else 0.0, tuple(numbers[:inputs])
    )


def clamped(term: Any, ends: tuple[float, float]) -> Any:
    """Return a term of an input whose values are limited to its range (``lock-range``).

    Raises
    ------
    NotExpressible
        If the term does not have straight sides and continues beyond the range.
    """
    left, right = ends
    if not isinstance(term, Triangular | Trapezoidal | Interval | NamedShape):
        raise _unlocked(term)
    if isinstance(term, NamedShape) and term.shape != "discrete":
        raise _unlocked(term)
    points = sorted({left, right, *(p for p in term.landmarks.tolist() if left < p < right)})
    inside = [float(grade) for grade in term(points)]
    if not isinstance(term, NamedShape):
        a, b, c, d = corners_of(term)
        if (a == b and left < a < right) or (c == d and left < d < right):
            # Points cannot express a jump.
            raise _unlocked(term)
        if (a >= left or inside[0] == 0.0) and (d <= right or inside[-1] == 0.0):
            level = (a > left or inside[0] == 0.0) and (d < right or inside[-1] == 0.0)
            if level:
                return term
    return NamedShape(
        "discrete", tuple(v for pair in zip(points, inside, strict=True) for v in pair)
    )


def _unlocked(term: Any) -> NotExpressible:
    return NotExpressible(
        f"lock-range of an input with the term {repr(term)[:60]}",
        "fuzzy2",
        "inputs are not held within a range, and only straight sides can be continued level",
    )


def corners_of(term: Any) -> tuple[float, float, float, float]:
    """Return the corners of a set with straight sides."""
    if isinstance(term, Triangular):
        return term.left, term.peak, term.peak, term.right
    if isinstance(term, Interval):
        return term.left, term.left, term.right, term.right
    return term.a, term.b, term.c, term.d


def text_of(term: Any, where: str) -> str:
    """Return a term in fuzzylite's syntax, without its name.

    Raises
    ------
    NotExpressible
        If fuzzylite has no such term.
    """
    if isinstance(term, Constant):
        if term.left != term.right:
            raise NotExpressible(f"the interval {term.left, term.right}", where, "it has numbers")
        return f"Constant {number(term.left)}"
    if isinstance(term, LinearFunction):
        return _words("Linear", [*term.slopes, term.constant])
    if isinstance(term, FormulaFunction):
        return f"Function {term.text}"
    if isinstance(term, FormulaSet):
        return f"Function {term.formula}"
    name, numbers, height = _parts(term, where)
    return _words(name, [*numbers, *([] if height == 1.0 else [height])])


def number(value: float) -> str:
    """Return a number with enough digits to read it back exactly."""
    return repr(float(value))


def _words(name: str, numbers: list[float]) -> str:
    return " ".join([name, *map(number, numbers)])


_NAMED = {
    "arc": "Arc",
    "bell": "Bell",
    "binary": "Binary",
    "concave": "Concave",
    "cosine": "Cosine",
    "discrete": "Discrete",
    "gaussian_product": "GaussianProduct",
    "semi_ellipse": "SemiEllipse",
    "sigmoid": "Sigmoid",
    "sigmoid_difference": "SigmoidDifference",
    "sigmoid_product": "SigmoidProduct",
    "spike": "Spike",
}


def _parts(term: Any, where: str) -> tuple[str, list[float], float]:
    """Return name, parameters and height of a set."""
    if isinstance(term, NamedShape):
        if term.shape == "constant":
            return "Constant", [term.scale * term.parameters[0]], 1.0
        return _NAMED[term.shape], list(term.parameters), term.scale
    if type(term) in _WRITTEN:
        return _WRITTEN[type(term)](term)
    if isinstance(term, Trapezoidal):
        return _trapezoid_parts(term, where)
    if isinstance(term, TwoSidedGaussian) and all(map(math.isfinite, term.sigma)):
        (left, right), (first, second) = term.mean, term.sigma
        return "GaussianProduct", [left, first, right, second], 1.0
    if isinstance(term, SampledSet) and term.grades[0] == term.grades[-1] == 0.0:
        pairs = zip(term.points.tolist(), term.grades.tolist(), strict=True)
        return "Discrete", [value for pair in pairs for value in pair], 1.0
    raise NotExpressible(f"the set {repr(term)[:80]}", where, "it has no such term")


def _two_sigmoids(term: Any) -> tuple[str, list[float], float]:
    (left, right), (rising, falling) = term.center, term.slope
    return type(term).__name__, [left, rising, falling, right], 1.0


def _trapezoid_parts(term: Trapezoidal, where: str) -> tuple[str, list[float], float]:
    a, b, c, d = term.a, term.b, term.c, term.d
    left, right = math.isinf(a), math.isinf(d)
    if left and right:
        raise NotExpressible(f"the set {term!r}", where, "it is everything")
    if right and a < b:
        return "Ramp", [a, b], term.height
    if left and c < d:
        return "Ramp", [d, c], term.height
    return "Trapezoid", [a, c if left else b, b if right else c, d], term.height


def _pi_parts(term: PiShaped) -> tuple[str, list[float], float]:
    if math.isinf(term.a) and math.isfinite(term.d):
        return "ZShape", [term.c, term.d], term.height
    if math.isinf(term.d) and math.isfinite(term.a):
        return "SShape", [term.a, term.b], term.height
    return "PiShape", [term.a, term.b, term.c, term.d], term.height


_WRITTEN: dict[type, Callable[[Any], tuple[str, list[float], float]]] = {
    Gaussian: lambda term: ("Gaussian", [term.mean, term.sigma], term.height),
    Triangular: lambda term: ("Triangle", [term.left, term.peak, term.right], term.height),
    Interval: lambda term: ("Rectangle", [term.left, term.right], 1.0),
    PiShaped: _pi_parts,
    Bell: lambda term: ("Bell", [term.center, term.width, term.slope], 1.0),
    Sigmoid: lambda term: ("Sigmoid", [term.center, term.slope], 1.0),
    SigmoidDifference: _two_sigmoids,
    SigmoidProduct: _two_sigmoids,
}
