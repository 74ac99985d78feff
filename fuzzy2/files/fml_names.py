"""Meaning of the names in FML documents for norms and membership functions."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.smooth_shapes import PiShaped, TwoSidedGaussian
from fuzzy2.sets.type1 import Singleton, Type1Set
from fuzzy2.systems.hedges import HEDGES, Hedge

NAMESPACE = "http://www.ieee1855.org"

T_NORMS = {
    "MIN": "min",
    "PROD": "product",
    "BSUM": "lukasiewicz",
    "BDIF": "lukasiewicz",
    "DRS": "drastic",
    "DRP": "drastic",
    "EPROD": "einstein",
    "HPROD": "hamacher",
    "NILMIN": "nilpotent",
}
"""T-norms, in capital letters; documents may use any case."""

T_CONORMS = {
    "MAX": "max",
    "PROBOR": "probabilistic",
    "BSUM": "lukasiewicz",
    "DRS": "drastic",
    "ESUM": "einstein",
    "HSUM": "hamacher",
    "NILMAX": "nilpotent",
}

RULE_BASES = {
    "mamdaniRuleBase": "mamdani",
    "tskRuleBase": "tsk",
    "tsukamotoRuleBase": "tsukamoto",
    "anYaRuleBase": "anya",
}

FIRING = Trapezoidal(0.0, 1.0, math.inf, math.inf)
"""Term of an input that is a firing; its grade is the firing itself."""

DEFUZZIFIERS = {
    "COG": "centroid",
    "COA": "bisector",
    "MOM": "middle_of_maxima",
    "LM": "smallest_of_maxima",
    "RM": "largest_of_maxima",
}
"""Defuzzifiers. JFML's mean of maxima is the middle between the first and the last."""

OWN_INSTRUCTION = "fuzzy2"
"""Target of the processing instruction that stores how this package integrates."""

OWN_WORDS = ("integration", "resolution")
"""Words of the processing instruction."""

SAMPLE_POINTS = 20001
"""Points of a sum for the center of gravity, which the standard defines as an integral."""

MODIFIERS = {
    "very": HEDGES["very"],
    "extremely": HEDGES["extremely"],
    "somewhat": HEDGES["somewhat"],
    "more_or_less": Hedge("more_or_less", 1.0 / 3.0),
    "plus": Hedge("plus", 1.25),
    "intensify": Hedge(
        "intensify", function=lambda g: np.where(g <= 0.5, 2.0 * g**2, 1.0 - 2.0 * (1.0 - g) ** 2)
    ),
    "seldom": Hedge(
        "seldom",
        function=lambda g: np.where(g <= 0.5, np.sqrt(0.5 * g), 1.0 - np.sqrt(0.5 * (1.0 - g))),
    ),
}
"""Monotonically increasing hedges of the standard's annex A."""

SHAPES: dict[str, tuple[int, Callable[..., Type1Set]]] = {
    "triangularShape": (3, Triangular),
    "trapezoidShape": (4, Trapezoidal),
    "gaussianShape": (2, lambda mean, sigma: Gaussian(mean, abs(sigma))),
    "rectangularShape": (2, Interval),
    "singletonShape": (1, Singleton),
    "rightLinearShape": (2, lambda a, b: Trapezoidal(a, b, math.inf, math.inf)),
    "leftLinearShape": (2, lambda a, b: Trapezoidal(-math.inf, -math.inf, a, b)),
    "rightGaussianShape": (
        2,
        lambda mean, sigma: TwoSidedGaussian((mean, mean), (abs(sigma), math.inf)),
    ),
    "leftGaussianShape": (
        2,
        lambda mean, sigma: TwoSidedGaussian((mean, mean), (math.inf, abs(sigma))),
    ),
    # If the parameters are not in order, JFML makes a step at the first one.
    "sShape": (2, lambda a, b: PiShaped(a, max(a, b), math.inf, math.inf)),
    "zShape": (2, lambda a, b: PiShaped(-math.inf, -math.inf, a, max(a, b))),
    "piShape": (2, lambda foot, top: PiShaped(foot, top, top, top + (top - foot))),
}
"""Shapes with the number of their parameters."""

_ADDRESS = "networkAddress"
_VARIABLE = ("name", "type", "scale", "defaultValue", _ADDRESS)
_DOMAIN = ("domainleft", "domainright")
_RULE = ("name", "connector", "andMethod", "orMethod", "weight", _ADDRESS)
_RULE_BASE = ("name", "activationMethod", "andMethod", "orMethod", _ADDRESS)

TEXTS = ("datum", "tskValue", "termName", "dataCloudName", "variable", "term")
"""Elements that hold a text, and nothing else."""

_BARE = ("antecedent", "anYaAntecedent", "consequent", "tskConsequent", "circularDefinition")
_BRANCHES = ("then", "else", "tskThen", "tskElse")

ATTRIBUTES: dict[str, tuple[str, ...]] = {
    **dict.fromkeys((*_BARE, *_BRANCHES, *TEXTS), ()),
    "termName": ("complement",),
    "fuzzySystem": ("name", _ADDRESS),
    "knowledgeBase": ("name", _ADDRESS),
    "fuzzyVariable": (*_VARIABLE, *_DOMAIN, "accumulation", "defuzzifier"),
    "tsukamotoVariable": (*_VARIABLE, *_DOMAIN, "combination"),
    "tskVariable": (*_VARIABLE, *_DOMAIN, "combination"),
    "aggregatedFuzzyVariable": ("name", "type", _ADDRESS),
    "anYaDataCloud": ("name", _ADDRESS),
    "fuzzyTerm": ("name", "complement"),
    "tsukamotoTerm": ("name", "complement"),
    "aggregatedFuzzyTerm": ("name",),
    "tskTerm": ("name", "order"),
    "pointSetShape": ("interpolationMethod", "degree"),
    "pointSetMonotonicShape": ("interpolationMethod",),
    "point": ("x", "y"),
    "and": ("t-norm",),
    "or": ("t-conorm",),
    "clause": ("modifier",),
    "tskClause": ("modifier",),
    **dict.fromkeys(RULE_BASES, _RULE_BASE),
    **dict.fromkeys(("rule", "tskRule", "anYaRule"), _RULE),
    **{name: tuple(f"param{i + 1}" for i in range(count)) for name, (count, _) in SHAPES.items()},
}
"""Attributes of elements, by the schema."""


def named_shape(term: Type1Set) -> tuple[str, tuple[float, ...]] | None:
    """Return name and parameters of a set's shape; None if FML does not have the shape."""
    return next((name(term) for kind, name in _NAMES.items() if isinstance(term, kind)), None)


def _named_trapezoid(one: Trapezoidal) -> tuple[str, tuple[float, ...]] | None:
    if math.isfinite(one.a) and math.isfinite(one.d):
        return "trapezoidShape", (one.a, one.b, one.c, one.d)
    if math.isfinite(one.a):
        return "rightLinearShape", (one.a, one.b)
    return ("leftLinearShape", (one.c, one.d)) if math.isfinite(one.d) else None


def _named_shoulder(one: TwoSidedGaussian) -> tuple[str, tuple[float, ...]] | None:
    if math.isinf(one.sigma[0]):
        return "leftGaussianShape", (one.mean[1], one.sigma[1])
    return ("rightGaussianShape", (one.mean[0], one.sigma[0])) if math.isinf(one.sigma[1]) else None


def _named_pi(one: PiShaped) -> tuple[str, tuple[float, ...]] | None:
    if math.isinf(one.d) and math.isfinite(one.a):
        return "sShape", (one.a, one.b)
    if math.isinf(one.a) and math.isfinite(one.d):
        return "zShape", (one.c, one.d)
    mirrored = one.b == one.c and one.d == one.b + (one.b - one.a)
    return ("piShape", (one.a, one.b)) if mirrored else None


_NAMES: dict[type[Type1Set], Callable[[Any], tuple[str, tuple[float, ...]] | None]] = {
    Triangular: lambda one: ("triangularShape", (one.left, one.peak, one.right)),
    Gaussian: lambda one: ("gaussianShape", (one.mean, one.sigma)),
    Interval: lambda one: ("rectangularShape", (one.left, one.right)),
    Singleton: lambda one: ("singletonShape", (one.point,)),
    Trapezoidal: _named_trapezoid,
    TwoSidedGaussian: _named_shoulder,
    PiShaped: _named_pi,
}
