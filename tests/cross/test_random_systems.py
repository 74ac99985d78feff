"""What fuzzy systems of every kind must keep, whatever hypothesis makes them of."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, event, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import fuzzy2
from fuzzy2.errors import NotApplicable, NotExpressible
from fuzzy2.systems.consequents import Formulas, FunctionsOfInputs, Linear
from fuzzy2.systems.operators import CRISP_ONLY, DIRECT_METHODS, UNIONS
from fuzzy2.systems.table import CONORMS, NORMS
from tests import examples
from tests.fuzzy2.files.test_formats import ROUTES, expressed
from tests.fuzzy2.systems.random_systems import places, rules_of, states, systems, widths
from tests.fuzzy2.systems.test_output_tables import is_continuous
from tests.helpers import Array

pytestmark = [
    pytest.mark.slow,
    # Infinite answers of formulas and of sums far away are told by numpy, too.
    pytest.mark.filterwarnings("ignore::RuntimeWarning"),
    pytest.mark.filterwarnings("ignore::fuzzy2.errors.ApproximationWarning"),
]

OF_SYSTEMS = settings(
    max_examples=examples(2000, of=40),
    suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow],
)

GOES_BY = 1e-9
"""What ends of an interval, and hulls, may be missed by, of the size of the numbers."""

BISECTED = 1e-5
"""Halves of an area that is known to 1e-11 of it are so wide where sets are cut low."""


def size_of(*numbers: Array) -> float:
    """Return the largest of the finite numbers, at least 1."""
    return max(1.0, *(float(np.abs(one[np.isfinite(one)]).max(initial=0.0)) for one in numbers))


def fires(system: Any, x: Array) -> Any:
    """Return at which inputs every rule fires not at all, or not just barely (n,)."""
    fired = system.firing(x)[..., 1]
    if fired.ndim > 2:
        fired = fired[..., 0, :]
    return ((fired == 0.0) | (fired > 1e-200)).all(axis=-1) & (fired > 0.0).any(axis=-1)


@OF_SYSTEMS
@given(systems())
def test_the_type_reduced_interval_contains_the_output(system: Any) -> None:
    """And the output is its middle, where no approximate method is asked for."""
    assume(system.method not in DIRECT_METHODS)
    x = states(system)
    interval, crisp = system.type_reduced(x), system(x)
    known = np.isfinite(interval).all(axis=-1)
    # A formula may be infinite. Where a higher plane fires no rule, there is no answer, though the
    # lowest cut is known.
    general = isinstance(system, fuzzy2.GeneralType2System)
    reduced = system.alpha_cuts(x).reshape(*crisp.shape, -1) if general else interval
    np.testing.assert_array_equal(np.isnan(crisp), np.isnan(reduced).any(axis=-1))
    known &= np.isfinite(reduced).all(axis=-1)
    interval, crisp = interval[known], crisp[known]
    atol = GOES_BY * size_of(interval)
    assert (interval[:, 0] <= interval[:, 1] + atol).all()
    assert (interval[:, 0] - atol <= crisp).all()
    assert (crisp <= interval[:, 1] + atol).all()


@OF_SYSTEMS
@given(systems())
def test_outputs_are_within_the_hull_of_the_consequents(system: Any) -> None:
    """Of numbers and intervals their ends, of sets the ends of their supports.

    Sums over a grid may miss what fires, and give the default.
    """
    assume(not isinstance(system.consequents, FunctionsOfInputs))
    assume(system.type_reduction not in ("weighted_sum", "united_sum", "tsukamoto"))
    x = states(system)
    x = x[fires(system, x)]
    assume(len(x))
    if system.type_reduction in UNIONS or system.type_reduction.endswith("height"):
        supports = np.array([[one.support for one in row] for row in system.consequent_sets])
    else:
        supports = system.consequent_intervals
    low, high = supports[..., 0].min(axis=0), supports[..., 1].max(axis=0)
    assume(np.isfinite(low).all() and np.isfinite(high).all())
    found = [system(x)]
    if system.method not in DIRECT_METHODS:
        found.append(np.moveaxis(system.type_reduced(x), -1, 0).reshape(-1, len(low)))
    for one in found:
        atol = GOES_BY * size_of(low, high)
        inside = (low - atol <= one) & (one <= high + atol)
        default = np.nan if system.default_outputs is None else system.default_outputs
        assert (inside | np.isnan(one) | (one == default)).all()


@OF_SYSTEMS
@given(systems((fuzzy2.Type1System,)))
def test_a_type_1_system_is_an_interval_system_without_uncertainty(system: Any) -> None:
    """To 1e-9, whatever the method: lower and upper grades are the same."""
    assume(system.type_reduction not in CRISP_ONLY)
    x = states(system)
    x = x[fires(system, x)]
    assume(len(x))
    try:
        other = fuzzy2.IntervalType2System(
            system.inputs,
            system.rules,
            system.consequents,
            **{
                name: getattr(system, name)
                for name in (
                    "t_norm",
                    "type_reduction",
                    "method",
                    "t_conorm",
                    "disjunction",
                    "implication",
                    "weights",
                    "silent",
                    "default_outputs",
                    "shares",
                    "integration",
                    "output_ranges",
                    "resolution",
                )
            },
        )
    except NotApplicable as error:
        event(str(error))
        assume(False)
        raise
    expected, found = system(x), other(x)
    allowed = GOES_BY * size_of(expected)
    np.testing.assert_allclose(found, expected, rtol=GOES_BY, atol=allowed)


def reordered(consequents: Any, order: Any) -> Any:
    """Return consequents whose rules stand in another order."""
    if isinstance(consequents, Linear):
        return Linear(consequents.coefficients[order], consequents.spreads[order])
    if isinstance(consequents, Formulas):
        return Formulas([consequents.formulas[r] for r in order], consequents.names)
    return [consequents[r] for r in order]


@OF_SYSTEMS
@given(systems(), st.randoms(use_true_random=False))
def test_rules_stand_in_any_order(system: Any, chance: Any) -> None:
    """To 1e-9: sums round otherwise; where an output jumps, rounding may choose another one."""
    assume(is_continuous(system))
    order = list(range(len(system.rules)))
    chance.shuffle(order)
    changes: dict[str, Any] = {
        "rules": [system.rules[r] for r in order],
        "consequents": reordered(system.consequents, order),
        "consequent_names": None,
    }
    for name in ("weights", "silent"):
        if getattr(system, name) is not None:
            changes[name] = np.asarray(getattr(system, name))[order]
    other, x = system.replace(**changes), states(system)
    x = x[fires(system, x)]
    assume(len(x))
    expected, found = system(x), other(x)
    allowed = BISECTED if system.type_reduction == "bisector" else GOES_BY
    np.testing.assert_allclose(found, expected, rtol=allowed, atol=allowed * size_of(expected))


@st.composite
def nested(draw: st.DrawFn) -> tuple[Any, Any]:
    """Draw two interval systems, of which the second knows less: wider terms and consequents."""
    inputs, outputs = draw(st.integers(1, 2)), 1
    numbers = [draw(st.integers(1, 3)) for _ in range(inputs)]
    sure, unsure = [], []
    for count in numbers:
        means = [draw(places) for _ in range(count)]
        sigmas = [sorted(draw(st.lists(widths, min_size=4, max_size=4))) for _ in means]
        pairs = list(zip(means, sigmas, strict=True))
        sure.append([fuzzy2.GaussianUncertainSigma(m, (s[1], s[2])) for m, s in pairs])
        unsure.append([fuzzy2.GaussianUncertainSigma(m, (s[0], s[3])) for m, s in pairs])
    rules = draw(rules_of(numbers))
    shape = (len(rules), outputs, 4)
    ends = np.sort(draw(arrays(float, shape, elements=places)), axis=-1)
    options = {
        "t_norm": draw(st.sampled_from(["product", "min", *NORMS])),
        "disjunction": draw(st.sampled_from(["max", *CONORMS])),
        "method": draw(st.sampled_from(["eiasc", "km", "ekm", "iasc", "scan"])),
    }
    kind: Callable[..., Any] = fuzzy2.IntervalType2System
    return (
        kind(sure, rules, ends[..., 1:3], **options),
        kind(unsure, rules, ends[..., [0, 3]], **options),
    )


@OF_SYSTEMS
@given(nested())
def test_who_knows_less_answers_with_more(pair: tuple[Any, Any]) -> None:
    """The interval of the wider system contains that of the narrower one."""
    sure, unsure = pair
    x = states(sure)
    x = x[fires(sure, x) & fires(unsure, x)]
    assume(len(x))
    inner, outer = sure.type_reduced(x), unsure.type_reduced(x)
    known = np.isfinite(inner).all(axis=-1) & np.isfinite(outer).all(axis=-1)
    inner, outer = inner[known], outer[known]
    assert (outer[..., 0] <= inner[..., 0] + GOES_BY).all()
    assert (inner[..., 1] <= outer[..., 1] + GOES_BY).all()


@OF_SYSTEMS
@given(systems())
def test_one_row_is_as_many(system: Any) -> None:
    """Rows alone and together: 1e-12, or a neighbor where rounding chooses."""
    x = states(system, 12)
    together, single = system(x), np.array([system(row) for row in x])
    if is_continuous(system):
        np.testing.assert_allclose(single, together, rtol=1e-12, atol=1e-12 * size_of(together))
    else:
        same = np.isclose(single, together, rtol=1e-9, atol=1e-9, equal_nan=True)
        assert same.mean() > 0.8


@OF_SYSTEMS
@given(systems(), st.sampled_from(ROUTES))
def test_what_a_format_can_say_comes_back(system: Any, route: Any) -> None:
    """To 1e-9, or the format refuses it: no system becomes another one without a word."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fuzzy2.errors.ApproximationWarning)
        again = expressed(system, route)
    if again is None:
        event(f"{route.__name__} refuses")
        with pytest.raises(NotExpressible):
            route(system)
        return
    event(f"{route.__name__} says it")
    x = states(system)
    x = x[fires(system, x)]
    assume(len(x))
    expected, found = system(x), again(x)
    if not is_continuous(system):
        same = np.isclose(found, expected, rtol=1e-9, atol=1e-9, equal_nan=True)
        assert same.mean() > 0.8
        return
    allowed = BISECTED if system.type_reduction == "bisector" else GOES_BY
    np.testing.assert_allclose(found, expected, rtol=allowed, atol=allowed * size_of(expected))
