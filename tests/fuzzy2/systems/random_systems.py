"""Random systems of every kind that a compiled loop knows, for property-based tests."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st

import fuzzy2
from fuzzy2.systems.antecedents import And, Hedged, Is, Not, Or
from fuzzy2.systems.consequents import Formulas
from fuzzy2.systems.hedges import Hedge, Scaled, intensify, relax
from fuzzy2.systems.operators import AVERAGES, DIRECT_METHODS, MAXIMA, TYPE_REDUCTIONS
from fuzzy2.systems.table import CONORMS, NORMS

places = st.integers(-16, 16).map(lambda k: k / 8.0)
widths = st.integers(1, 12).map(lambda k: k / 8.0)
heights = st.sampled_from([1.0, 1.0, 0.75])

triangles = st.builds(lambda m, a, b: fuzzy2.Triangular(m - a, m, m + b), places, widths, widths)
trapezoids = st.builds(
    lambda m, a, b, c: fuzzy2.Trapezoidal(m - a, m, m + b, m + b + c),
    places,
    widths,
    widths,
    widths,
)
shoulders = st.builds(
    lambda m, a: fuzzy2.Trapezoidal(m - a, m, np.inf, np.inf), places, widths
) | st.builds(lambda m, a: fuzzy2.Trapezoidal(-np.inf, -np.inf, m, m + a), places, widths)
gaussians = st.builds(fuzzy2.Gaussian, places, widths)
bounded = triangles | trapezoids | gaussians
others = (
    st.builds(fuzzy2.Bell, places, widths, widths)
    | st.builds(fuzzy2.Sigmoid, places, widths | widths.map(lambda s: -s))
    | st.builds(lambda m, a, b: fuzzy2.PiShaped(m - a, m, m + b, m + 2 * b), places, widths, widths)
    | gaussians.map(lambda item: item.sample(np.linspace(-3.0, 3.0, 13)))
)
type_1 = bounded | shoulders | others
uncertain = st.builds(
    lambda m, w, s: fuzzy2.GaussianUncertainMean((m, m + w), s), places, widths, widths
) | st.builds(
    lambda m, a, b: fuzzy2.IntervalType2Set(
        lower=fuzzy2.Triangular(m - a, m, m + a, 0.75), upper=fuzzy2.Triangular(m - a, m, m + a + b)
    ),
    places,
    widths,
    widths,
)
general = st.builds(
    lambda item, s: fuzzy2.GaussianType2Set(item, s), gaussians, st.sampled_from([0.02, 0.1])
)
monotonic = st.builds(
    lambda m, a: fuzzy2.Trapezoidal(m - a, m + a, np.inf, np.inf), places, widths
) | st.builds(fuzzy2.Sigmoid, places, widths.map(lambda s: -4.0 * s))
TERMS = {
    fuzzy2.Type1System: type_1,
    fuzzy2.IntervalType2System: type_1 | uncertain,
    fuzzy2.GeneralType2System: general | gaussians,
}
HEDGES = (
    Hedge("very", 2.0),
    Hedge("somewhat", 0.5),
    Hedge("more", function=intensify),
    Hedge("less", function=relax),
    Hedge("partly", function=Scaled(0.4)),
)
TEXTS = ("a", "2 * a - 1", "sin(a) + 0.5", "a^2", "1 / a", "log(a)", "max(a, 0.25)", "gt(a, 0)")


@st.composite
def antecedents(draw: Any, counts: list[int], depth: int = 2) -> Any:
    """Draw what a rule asks for."""
    kind = draw(st.sampled_from(["is", "and", "or", "not", "hedge"] if depth else ["is"]))
    if kind == "is":
        variable = draw(st.integers(0, len(counts) - 1))
        return Is(variable, draw(st.none() | st.integers(0, counts[variable] - 1)))
    below = antecedents(counts, depth - 1)
    if kind in ("and", "or"):
        parts = tuple(draw(st.lists(below, min_size=2, max_size=3)))
        return And(parts) if kind == "and" else Or(parts)
    part = draw(below)
    return Not(part) if kind == "not" else Hedged(draw(st.sampled_from(HEDGES)), part)


@st.composite
def rules_of(draw: Any, counts: list[int]) -> Any:
    """Draw rules, as numbers of terms or as trees."""
    size = draw(st.integers(1, 6))
    if draw(st.booleans()):
        asked = st.tuples(*(st.integers(-1, count - 1) for count in counts))
        return np.array(draw(st.lists(asked, min_size=size, max_size=size)))
    return draw(st.lists(antecedents(counts), min_size=size, max_size=size))


def an_array(draw: Any, *shape: int) -> Any:
    size = int(np.prod(shape))
    return np.reshape(draw(st.lists(places, min_size=size, max_size=size)), shape)


@st.composite
def consequents_of(draw: Any, kind: type, size: int, inputs: int, reduction: str) -> Any:
    """Draw what rules say."""
    outputs = draw(st.integers(1, 2))
    if reduction == "tsukamoto":
        return [draw(st.lists(monotonic, min_size=outputs, max_size=outputs)) for _ in range(size)]
    of_sets = reduction not in ("center_of_sets", "weighted_sum", "united_average", "united_sum")
    if of_sets:
        drawn = bounded if kind is fuzzy2.Type1System else bounded | uncertain
        if reduction in ("centroid", "bisector", *MAXIMA) and draw(st.integers(0, 5)) == 0:
            drawn = places.map(lambda m: fuzzy2.Triangular(m, m, m))
        few = draw(st.lists(drawn, min_size=1, max_size=3))
        sets = st.lists(st.sampled_from(few), min_size=outputs, max_size=outputs)
        return [draw(sets) for _ in range(size)]
    form = draw(st.sampled_from(["numbers", "intervals", "linear", "formulas"]))
    if form == "linear":
        spreads = abs(an_array(draw, size, outputs, inputs + 1)) * draw(st.sampled_from([0, 0.1]))
        return fuzzy2.Linear(an_array(draw, size, outputs, inputs + 1), spreads)
    if form == "formulas":
        rows = st.lists(st.sampled_from(TEXTS), min_size=outputs, max_size=outputs)
        return Formulas([draw(rows) for _ in range(size)], ["a", "b", "c"][:inputs])
    if form == "intervals":
        return np.sort(an_array(draw, size, outputs, 2))
    return np.round(an_array(draw, size, outputs))


@st.composite
def systems(draw: Any, kinds: tuple[type, ...] = tuple(TERMS)) -> Any:
    """Draw a system."""
    kind = draw(st.sampled_from(kinds))
    inputs = draw(st.integers(1, 3))
    terms = [draw(st.lists(TERMS[kind], min_size=1, max_size=3)) for _ in range(inputs)]
    rules = draw(rules_of([len(one) for one in terms]))
    reductions = [*TYPE_REDUCTIONS] if kind is fuzzy2.Type1System else ["centroid", *AVERAGES[:-1]]
    reduction = draw(st.sampled_from(reductions))
    size = len(rules)
    said = draw(consequents_of(kind, size, inputs, reduction))
    outputs = said.shape[1] if hasattr(said, "shape") else len(said[0])
    defaults = st.none() | st.lists(st.none() | places, min_size=outputs, max_size=outputs)
    weights = st.lists(st.sampled_from([1.0, 0.5, 0.0]), min_size=size, max_size=size)
    bounded_ends = draw(st.booleans()) and reduction == "tsukamoto"
    options: dict[str, Any] = {
        "t_norm": draw(st.sampled_from(NORMS)),
        "disjunction": draw(st.sampled_from(CONORMS)),
        "t_conorm": draw(st.sampled_from(["max", "max", "sum", *CONORMS])),
        "implication": draw(st.sampled_from(["min", "product", *NORMS])),
        "type_reduction": reduction,
        "method": draw(st.sampled_from(["eiasc", "eiasc", *DIRECT_METHODS])),
        "integration": draw(st.sampled_from(["exact", "sum", "trapezoidal", "midpoint", "left"])),
        "resolution": draw(st.integers(2, 40)),
        "shares": (0.25, 0.75),
        "weights": draw(st.none() | weights),
        "default_outputs": draw(defaults),
        "output_ranges": [(-4.0, 4.0)] * outputs if bounded_ends else None,
    }
    if kind is fuzzy2.GeneralType2System:
        options["levels"] = draw(st.integers(1, 3))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return kind(terms, rules, said, **options)
        except fuzzy2.Fuzzy2Error:
            assume(False)


def states(system: Any, count: int = 40) -> Any:
    """Return inputs near the terms and far away from them, also on their kinks."""
    rng = np.random.default_rng(3)
    scales = rng.choice([0.5, 2.0, 2.0, 60.0], size=(count, 1))
    X = rng.normal(size=(count, len(system.inputs))) * scales
    return np.where(rng.random(X.shape) < 0.3, np.round(X * 8.0) / 8.0, X)
