"""Names of the Fuzzy Control Language for operators, methods and shapes, with their equivalents.

They include the names of IEC 61131-7, jFuzzyLogic and fuzzylite.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np

from fuzzy2.errors import InvalidValue, NotExpressible
from fuzzy2.files.description import SUM, Constant, LinearFunction
from fuzzy2.files.fll_names import KINDS, number, term_of, text_of
from fuzzy2.files.functions import FormulaFunction
from fuzzy2.sets.named_shape import NamedShape
from fuzzy2.sets.shapes import Gaussian, Trapezoidal, Triangular
from fuzzy2.sets.sigmoids import Sigmoid
from fuzzy2.sets.smooth_shapes import Bell, TwoSidedGaussian
from fuzzy2.sets.type1 import SampledSet, Singleton

T_NORMS = {
    "MIN": "min",
    "PROD": "product",
    "BDIF": "lukasiewicz",
    "DMIN": "drastic",
    "DPROD": "drastic",
    "NIPMIN": "nilpotent",
    "NMIN": "nilpotent",
    "HAMACHER": "hamacher",
    "HPROD": "hamacher",
    "EPROD": "einstein",
}

S_NORMS = {
    "MAX": "max",
    "ASUM": "probabilistic",
    "BSUM": "lukasiewicz",
    "DMAX": "drastic",
    "DSUM": "drastic",
    "NIPMAX": "nilpotent",
    "NMAX": "nilpotent",
    "EINSTEIN": "einstein",
    "ESUM": "einstein",
    "HSUM": "hamacher",
}

ACCUMULATIONS = {
    **S_NORMS,
    "PROBOR": "probabilistic",
    # The sum is divided by one number for all points, which does not affect any method.
    "NSUM": SUM,
    "SUM": SUM,
}

DUALS = {
    "min": "max",
    "product": "probabilistic",
    "lukasiewicz": "lukasiewicz",
    "drastic": "drastic",
    "nilpotent": "nilpotent",
    # jFuzzyLogic's pair of operators.
    "hamacher": "einstein",
    "einstein": "einstein",
}
"""T-conorm of *or* if a block only defines *and*."""

METHODS = {
    "COG": "centroid",
    "COA": "bisector",
    "LM": "smallest_of_maxima",
    "RM": "largest_of_maxima",
    "MM": "mean_of_maxima",
}

_COUNTS = {
    "trian": 3,
    "trape": 4,
    "gauss": 2,
    "gauss2": 4,
    "gbell": 3,
    "sigm": 2,
    "dsigm": 4,
    "cosine": 2,
}

SHAPES = tuple(_COUNTS)
"""Shapes of jFuzzyLogic."""


def shape_of(kind: str, numbers: list[float], inputs: int | None, jfuzzylogic: bool) -> Any:
    """Return the term for a shape's name in jFuzzyLogic or fuzzylite.

    Parameters
    ----------
    kind : str
        The name.
    numbers : list of float
        Its parameters.
    inputs : int, or None
        Number of inputs, for a term of an output.
    jfuzzylogic : bool
        Whether ``Cosine``, in this spelling, is jFuzzyLogic's shape instead of fuzzylite's.

    Raises
    ------
    NotExpressible
        If this package has no such set.
    InvalidValue
        If the parameters are not those of the shape.
    """
    name = kind.lower()
    if name not in _COUNTS or (kind in KINDS and not jfuzzylogic):
        known = next((one for one in KINDS if one.lower() == name), None)
        if known is None:
            listed = ", ".join((*SHAPES, *KINDS))
            raise NotExpressible(f"the shape {kind!r}", "fuzzy2", f"known are {listed}")
        return term_of(known, numbers, inputs)
    if len(numbers) != _COUNTS[name]:
        raise InvalidValue("the parameters", numbers, f"{_COUNTS[name]} numbers")
    return _jfuzzylogic(name, numbers)


def _jfuzzylogic(name: str, p: list[float]) -> Any:
    match name:
        case "trian":
            return Triangular(*p)
        case "trape":
            return Trapezoidal(*p)
        case "gauss":
            return Gaussian(p[0], p[1])
        case "gauss2":
            return TwoSidedGaussian((p[0], p[2]), (p[1], p[3]))
        case "gbell":
            return Bell(p[2], p[0], p[1])
        case "sigm":
            return Sigmoid(p[1], p[0])
        case "cosine":
            return NamedShape("cosine", (p[1], 2.0 * p[0]))
    return _dsigm(p)


def _dsigm(p: list[float]) -> Any:
    shape = NamedShape("sigmoid_difference", (p[1], p[0], p[2], p[3]))
    points = np.linspace(shape.landmarks[0], shape.landmarks[-1], 513)
    first, second = Sigmoid(p[1], p[0]), Sigmoid(p[3], p[2])
    if (first(points) < second(points) - 1e-12).any():
        raise NotExpressible(
            "DSIGM whose second sigmoid is above the first one",
            "fuzzy2",
            "the difference is taken without its sign here, and cut off at 0 there",
        )
    return shape


def points_of(points: list[tuple[float, float]]) -> Any:
    """Return the term through points (x, grade), linear between them and constant beyond."""
    places, grades = zip(*points, strict=True)
    if any(after < before for before, after in pairwise(places)):
        raise InvalidValue("the points", places, "in ascending order")
    top = max(grades)
    if 0.0 < top <= 1.0 and len(set(places)) == len(places):
        match [grade / top for grade in grades]:
            case [0.0, 1.0, 0.0]:
                return Triangular(places[0], places[1], places[2], top)
            case [0.0, 1.0, 1.0, 0.0]:
                return Trapezoidal(places[0], places[1], places[2], places[3], top)
            case [0.0, 1.0]:
                return Trapezoidal(places[0], places[1], math.inf, math.inf, top)
            case [1.0, 0.0]:
                return Trapezoidal(-math.inf, -math.inf, places[0], places[1], top)
    return NamedShape("discrete", tuple(value for point in points for value in point))


def universe(terms: list[Any]) -> tuple[float, float] | None:
    """Return the range of an output without one, from its first to its last term.

    A Gaussian extends to 4 standard deviations, a sigmoid to 9 of its widths, and a bell to the
    grade 0.001, as in jFuzzyLogic.
    """
    ends: list[float] = []
    for term in terms:
        match term:
            case Constant():
                ends.append(term.left)
            case LinearFunction() | FormulaFunction():
                return None
            case Gaussian():
                ends += [term.mean - 4.0 * term.sigma, term.mean + 4.0 * term.sigma]
            case Sigmoid():
                reach = 9.0 / abs(term.slope)
                ends += [term.center - reach, term.center + reach]
            case Bell():
                reach = 999.0 ** (1.0 / (2.0 * term.slope)) * term.width
                ends += [term.center - reach, term.center + reach]
            case _:
                ends += term.landmarks.tolist()
    left, right = min(ends), max(ends)
    return (left, right) if left < right else None


def term_text(term: Any, where: str) -> str:
    """Return a term in FCL: points if its sides are straight, otherwise fuzzylite's name.

    Raises
    ------
    NotExpressible
        If there is no such term.
    """
    match term:
        case Constant() if term.left == term.right:
            return number(term.left)
        case Singleton():
            return number(term.point)
        case NamedShape("discrete", parameters, 1.0):
            pairs = zip(parameters[::2], parameters[1::2], strict=True)
            return _points(pairs)
        case SampledSet() if term.grades[0] == term.grades[-1] == 0.0:
            return _points(zip(term.points.tolist(), term.grades.tolist(), strict=True))
        case Triangular():
            return _straight([term.left, term.peak, term.peak, term.right], term.height) or text_of(
                term, where
            )
        case Trapezoidal():
            return _straight([term.a, term.b, term.c, term.d], term.height) or text_of(term, where)
    return text_of(term, where)


def _straight(corners: list[float], height: float) -> str:
    """Return the points of a trapezoid; none if it jumps, which points cannot express."""
    a, b, c, d = corners
    if (a == b and math.isfinite(a)) or (c == d and math.isfinite(d)):
        return ""
    left = [(a, 0.0), (b, height)] if math.isfinite(a) else []
    right = [(c, height), (d, 0.0)] if math.isfinite(d) else []
    return _points(dict([*left, *right]).items())


def _points(pairs: Any) -> str:
    return " ".join(f"({number(x)}, {number(grade)})" for x, grade in pairs)
