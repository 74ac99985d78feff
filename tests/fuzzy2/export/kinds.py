"""A system of every kind that can be exported."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

import fuzzy2
from fuzzy2.systems.consequents import Formulas
from fuzzy2.systems.hedges import Hedge, Scaled, intensify, relax
from fuzzy2.systems.operators import MAXIMA

RULES = np.array(list(itertools.product(range(3), repeat=2)))
CENTERS = (-1.0, 0.0, 1.0)


def numbers(*shape: int) -> Any:
    return np.random.default_rng(sum(shape)).normal(size=shape)


def gaussians(width: float = 0.05) -> list[list[Any]]:
    return [[fuzzy2.GaussianUncertainMean((m - width, m + width), 0.4) for m in CENTERS]] * 2


def type_1(**options: Any) -> Any:
    terms = [[fuzzy2.Gaussian(m, 0.4) for m in CENTERS]] * 2
    options.setdefault("consequents", numbers(9, 3))
    return fuzzy2.Type1System(terms, RULES, **options)


def interval(**options: Any) -> Any:
    options.setdefault("consequents", numbers(9, 2))
    return fuzzy2.IntervalType2System(gaussians(), RULES, **options)


def of_terms(terms: list[Any], **options: Any) -> Any:
    return fuzzy2.IntervalType2System([terms, terms], RULES, numbers(9, 1), **options)


def planes(shape: Any = None, **options: Any) -> Any:
    principals = [
        fuzzy2.Gaussian(m, 0.5) if shape is None else shape(m - 1.0, m, m + 1.0) for m in CENTERS
    ]
    terms = [[fuzzy2.GaussianType2Set(one, 0.01) for one in principals]] * 2
    options.setdefault("consequents", numbers(9, 2))
    return fuzzy2.GeneralType2System(terms, RULES, **options)


def slices() -> Any:
    terms = [
        fuzzy2.ZSlices((0.5, 1.0), (pair(m), fuzzy2.IntervalType2Set(triangle(m), triangle(m))))
        for m in CENTERS
    ]
    return fuzzy2.GeneralType2System(
        [terms, terms], RULES, numbers(9, 2), method="nie_tan", default_outputs=[None, 3.0]
    )


def with_or_not_hedges() -> Any:
    words = [
        "IF a is low or b is very high THEN y is small",
        "IF a is not low and b is low THEN y is large and z is small",
    ]
    terms = {"low": fuzzy2.Triangular(-2.0, -1.0, 1.0), "high": fuzzy2.Gaussian(1.0, 0.5)}
    return fuzzy2.IntervalType2System(
        {"a": terms, "b": terms},
        "\n".join(words),
        {"y": {"small": -1.0, "large": 1.5}, "z": {"small": (0.5, 1.0)}},
        default_outputs=[None, 7.0],
        weights=[0.5, 1.0],
    )


def side_by_side() -> Any:
    parts = [interval().replace(output_names=["u", "v"]), planes().replace(output_names=["p", "q"])]
    return fuzzy2.ParallelSystem([type_1(), *parts])


def of_clouds() -> Any:
    fires = [fuzzy2.Trapezoidal(0.0, 1.0, np.inf, np.inf)]
    inference = fuzzy2.Type1System([fires, fires], [[0, -1], [-1, 0]], [[1.0], [2.0]])
    return fuzzy2.AnYaSystem([numbers(5), numbers(9)], [0, 1], inference)


def sets(shape: Any) -> list[list[Any]]:
    return [[shape(m)] for m in np.linspace(-2.0, 2.0, 9)]


def triangle(m: float) -> Any:
    return fuzzy2.Triangular(m - 1.0, m, m + 1.0)


def gaussian(m: float) -> Any:
    return fuzzy2.Gaussian(m, 0.6)


def uncertain(m: float) -> Any:
    return fuzzy2.GaussianUncertainMean((m, m + 0.3), 0.5)


def pair(m: float) -> Any:
    return fuzzy2.IntervalType2Set(fuzzy2.Triangular(m - 0.7, m, m + 0.7, 0.8), triangle(m))


def learned(estimator: Any) -> Any:
    rng = np.random.default_rng(0)
    X = rng.uniform(-1.0, 1.0, (60, 2))
    y = X[:, 0] * X[:, 1]
    if isinstance(estimator, fuzzy2.FuzzyClassifier):
        return estimator.fit(X, y > 0.0)
    return estimator.fit(X, y)


LINEAR = fuzzy2.Linear(numbers(9, 2, 3))
UNCERTAIN_LINEAR = fuzzy2.Linear(numbers(9, 2, 3), abs(numbers(9, 3, 3))[:, :2])
MIXED = [fuzzy2.Sigmoid(-0.5, -5.0), fuzzy2.Bell(0.0, 0.5, 2.0), fuzzy2.PiShaped(0, 1, 2, 3)]
OTHERS = [
    fuzzy2.TwoSidedGaussian((-1.0, 0.0), (0.4, 0.3)),
    fuzzy2.SigmoidDifference((0.0, 1.0), (5.0, 6.0)),
    fuzzy2.SigmoidProduct((0.0, 2.0), (5.0, -6.0)),
]

TERMS = [[fuzzy2.Gaussian(m, 0.4) for m in CENTERS], [triangle(m) for m in CENTERS]]


def united(shape: Any = gaussian, **options: Any) -> Any:
    """Return a type-1 system whose output sets are united."""
    return fuzzy2.Type1System(TERMS, RULES, sets(shape), **options)


def on_a_grid(shape: Any, **options: Any) -> Any:
    options.setdefault("type_reduction", "centroid")
    return interval(consequents=sets(shape), integration="sum", resolution=31, **options)


def point(m: float) -> Any:
    return fuzzy2.Triangular(m, m, m)


def own(m: float) -> Any:
    return fuzzy2.FunctionalSet(lambda x: np.exp(-abs(x - m)), m - 3.0, m + 3.0, [m])


def rising(m: float) -> Any:
    return fuzzy2.Trapezoidal(m - 1.0, m + 1.0, np.inf, np.inf)


def sigmoid(m: float) -> Any:
    return fuzzy2.Sigmoid(m, 3.0 if m > 0.0 else -4.0)


def hedged(function: Any, word: str = "oddly") -> Any:
    terms = {"low": fuzzy2.GaussianUncertainMean((-1.1, -0.9), 0.5), "high": triangle(1.0)}
    return fuzzy2.IntervalType2System(
        {"a": terms, "b": terms},
        f"IF a is {word} low and b is low THEN y is small\n"
        f"IF a is not {word} high or b is {word} not high THEN y is large",
        {"y": {"small": -1.0, "large": 1.5}},
        hedges={word: Hedge(word, function=function)},
    )


def repeated(kind: type = fuzzy2.Type1System, **options: Any) -> Any:
    """Return a system of which several rules say the same."""
    terms = TERMS if kind is fuzzy2.Type1System else gaussians()
    return kind(terms, RULES, np.round(numbers(9, 2)), **options)


def of_formulas(kind: Any = fuzzy2.Type1System, texts: Any = None, **options: Any) -> Any:
    terms = TERMS if kind is fuzzy2.Type1System else gaussians()
    texts = FORMULAS if texts is None else texts
    return kind(terms, RULES, Formulas([[text] for text in texts], ["a", "b"]), **options)


FORMULAS = [
    *("sin(a) * exp(-b)", "a^2 + b / 2", "max(a, b) - min(a, 0.5)", "sqrt(abs(a * b))"),
    *("round(a * 3) % 2 - fmod(b, 0.3)", "atan2(a, b) + tanh(a)", "gt(a, b) or !le(b, 0.2)"),
    *("floor(a) + ceil(b)", "log1p(abs(a)) + pi"),
]
HOLES = ["log(a)", "1 / (a - b)", "sqrt(b)", *FORMULAS[3:]]
"""Formulas that are no finite number everywhere."""

KINDS: dict[str, Any] = {
    "type-1": type_1,
    "interval": lambda: interval(t_norm="min"),
    "interval product": interval,
    "t-norm hamacher": lambda: interval(t_norm="hamacher"),
    "planes": planes,
    "corollary": lambda: planes(reduction="gaussian"),
    "planes of their own": slices,
    "planes, nie-tan": lambda: planes(method="nie_tan"),
    "planes, wu-mendel": lambda: planes(method="wu_mendel"),
    "planes, silent": lambda: planes(default_outputs=[0.5, None]),
    "planes of united outputs": lambda: planes(
        consequents=sets(triangle),
        type_reduction="centroid",
        t_norm="min",
        integration="sum",
        resolution=41,
    ),
    "planes of triangles": lambda: planes(fuzzy2.Triangular, t_norm="min"),
    "or, not, hedges, weights, silence, defaults": with_or_not_hedges,
    "side by side": side_by_side,
    "clouds": of_clouds,
    "linear": lambda: type_1(consequents=LINEAR),
    "linear interval": lambda: interval(consequents=UNCERTAIN_LINEAR),
    "nie-tan": lambda: interval(method="nie_tan"),
    "wu-mendel": lambda: interval(method="wu_mendel"),
    "wu-mendel linear": lambda: interval(method="wu_mendel", consequents=UNCERTAIN_LINEAR),
    "begian-melek-mendel": lambda: interval(method="begian_melek_mendel", shares=(0.3, 0.7)),
    "weighted sum": lambda: interval(type_reduction="weighted_sum"),
    "height": lambda: interval(consequents=sets(uncertain), type_reduction="height"),
    "modified height": lambda: interval(
        consequents=sets(uncertain), type_reduction="modified_height", t_norm="min"
    ),
    "mamdani": lambda: type_1(consequents=sets(triangle), type_reduction="centroid", t_norm="min"),
    "mamdani product": lambda: type_1(consequents=sets(gaussian), type_reduction="centroid"),
    "sums": lambda: type_1(consequents=sets(triangle), type_reduction="center_of_sums"),
    "sum on a grid": lambda: united(
        type_reduction="centroid", integration="sum", resolution=51, t_norm="min"
    ),
    "trapezoids on a grid": lambda: united(
        triangle,
        type_reduction="center_of_sums",
        integration="trapezoidal",
        resolution=51,
        default_outputs=[0.5],
    ),
    "interval on a grid": lambda: on_a_grid(uncertain, t_norm="min"),
    "interval on a grid, product, probabilistic": lambda: on_a_grid(pair, t_conorm="probabilistic"),
    "nie-tan on a grid": lambda: on_a_grid(uncertain, method="nie_tan"),
    "wu-mendel on a grid": lambda: on_a_grid(uncertain, method="wu_mendel"),
    "functions of one's own on a grid": lambda: united(
        own, type_reduction="centroid", integration="sum", resolution=41, t_norm="hamacher"
    ),
    "bisector on a grid": lambda: united(
        type_reduction="bisector", integration="sum", resolution=51, t_norm="min"
    ),
    "fuzzylite's bisector": lambda: united(
        type_reduction="bisector", integration="midpoint", resolution=51, t_norm="min"
    ),
    "jFuzzyLogic's mean of maxima": lambda: united(
        type_reduction="mean_of_maxima", integration="left", resolution=51, t_norm="min"
    ),
    "bisector": lambda: united(type_reduction="bisector", t_norm="min"),
    "bisector of sums": lambda: united(triangle, type_reduction="bisector", t_conorm="sum"),
    **{
        kind: lambda kind=kind: united(type_reduction=kind, t_norm="min", default_outputs=[9.0])
        for kind in MAXIMA
    },
    "maxima, product": lambda: united(triangle, type_reduction="middle_of_maxima"),
    "points": lambda: united(point, type_reduction="centroid", t_norm="min"),
    "bisector of points": lambda: united(point, type_reduction="bisector"),
    "tsukamoto": lambda: united(sigmoid, type_reduction="tsukamoto"),
    "tsukamoto within a range": lambda: united(
        rising, type_reduction="tsukamoto", t_norm="min", output_ranges=[(-3.0, 2.5)]
    ),
    "intensify": lambda: hedged(intensify),
    "relax": lambda: hedged(relax),
    "a part's weight": lambda: hedged(Scaled(0.3)),
    "united average": lambda: repeated(type_reduction="united_average"),
    "united sum, interval": lambda: repeated(
        fuzzy2.IntervalType2System, type_reduction="united_sum", t_conorm="sum"
    ),
    "united average, interval": lambda: repeated(
        fuzzy2.IntervalType2System, type_reduction="united_average", t_conorm="probabilistic"
    ),
    "formulas": of_formulas,
    "formulas, interval": lambda: of_formulas(fuzzy2.IntervalType2System),
    "formulas, sum": lambda: of_formulas(type_reduction="weighted_sum"),
    "formulas with holes": lambda: of_formulas(texts=HOLES, default_outputs=[4.0]),
    "intervals, type-1": lambda: type_1(consequents=np.sort(numbers(9, 2, 2))),
    "samples": lambda: of_terms([gaussian(m).sample(np.linspace(-3, 3, 25)) for m in CENTERS]),
    "triangles": lambda: of_terms([pair(m) for m in CENTERS]),
    "other shapes": lambda: of_terms(MIXED, t_norm="min"),
    "more shapes": lambda: of_terms(OTHERS),
    "wang-mendel": lambda: learned(fuzzy2.WangMendel(3, kind="it2", mean_variation=0.1)),
    "anfis": lambda: learned(fuzzy2.ANFIS(2, most_epochs=2)),
    "classifier": lambda: learned(fuzzy2.FuzzyClassifier(1, most_epochs=3)),
}
"""Systems and learners by what is special about them."""

JUMPING = frozenset(
    {
        *MAXIMA,
        *("bisector on a grid", "fuzzylite's bisector", "jFuzzyLogic's mean of maxima"),
        *("maxima, product", "bisector of points"),
        *("formulas", "formulas, interval", "formulas, sum", "formulas with holes"),
    }
)
"""Those whose outputs jump: from one point of a grid, or one of two sets that are equally high, to
another, or where a formula compares or rounds.
"""

SLOW: dict[str, Any] = {
    "interval mamdani": lambda: interval(
        consequents=sets(uncertain), type_reduction="centroid", t_norm="min"
    ),
    "nie-tan mamdani": lambda: interval(
        consequents=sets(uncertain), type_reduction="centroid", method="nie_tan", t_norm="min"
    ),
}
"""The same, of which an input takes half a millisecond and more."""
