"""MATLAB's files: what is written is read back."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy2.files.fis import format_fis, parse_fis, read_fis, write_fis
from fuzzy2.sets.derived import Truncated
from fuzzy2.sets.interval_type2 import (
    GaussianUncertainSigma,
    IntervalType2Set,
)
from fuzzy2.sets.shapes import Gaussian, Trapezoidal, Triangular
from fuzzy2.sets.sigmoids import Sigmoid, SigmoidDifference, SigmoidProduct
from fuzzy2.sets.smooth_shapes import Bell, PiShaped, TwoSidedGaussian
from fuzzy2.sets.uncertain_mean import NearestMeanGaussian
from fuzzy2.systems import IntervalType2System, Linear, Type1System
from fuzzy2.systems.antecedents import And, Is, Not, Or
from tests.fuzzy2.files.fis_texts import OPEN_TYPE2, TIPPER, TYPE2


def test_negations_are_complements() -> None:
    """MATLAB's -k is 1 minus the grade of term k, in every rule.

    Written out for the tipper on its 101 points.
    """
    text = TIPPER.replace("1 1, 1 (1) : 2", "-1 1, -1 (1) : 1").replace(
        "3 2, 3 (1) : 2", "-1 -2, 3 (1) : 2"
    )
    system, y = parse_fis(text), np.linspace(0.0, 30.0, 101)
    assert system.term_names == (("poor", "good", "excellent"), ("rancid", "delicious"))
    assert system.rules[0] == And((Not(Is(0, 0)), Is(1, 0)))
    assert system.rules[2] == Or((Not(Is(0, 0)), Not(Is(1, 1))))
    cheap, average, generous = (
        np.maximum(1.0 - abs(y - peak) / 5.0, 0.0) for peak in (5.0, 15.0, 25.0)
    )
    for service, food in np.random.default_rng(2).uniform(0.0, 10.0, size=(50, 2)):
        poor, good = (np.exp(-0.5 * ((service - mean) / 1.5) ** 2) for mean in (0.0, 5.0))
        rancid, delicious = (
            np.clip((3.0 - food) / 2.0, 0.0, 1.0),
            np.clip((food - 7.0) / 2.0, 0.0, 1.0),
        )
        clipped = [np.minimum(min(1.0 - poor, rancid), 1.0 - cheap), np.minimum(good, average)]
        united = np.max([*clipped, np.minimum(max(1.0 - poor, 1.0 - delicious), generous)], axis=0)
        np.testing.assert_allclose(system([service, food]), [y @ united / united.sum()], rtol=1e-12)
    written = format_fis(system)
    assert "-1 1, -1 (1) : 1" in written
    assert "-1 -2, 3 (1) : 2" in written
    assert "NumMFs=3\nMF1='poor'" in written
    assert "MF1='cheap':'trimf',[0 5 10]" in written
    assert_comes_back(system)


def test_the_complement_of_a_type_2_term_exchanges_its_membership_functions() -> None:
    system = parse_fis(TYPE2.replace("1, 1 (1) : 1", "-1, 1 (1) : 1"))
    low = system.inputs[0][0]
    x = np.linspace(-1.0, 1.0, 41)
    fired = system.firing(x[:, None])[:, 0]
    np.testing.assert_array_equal(fired[:, 0], 1.0 - low.upper(x))
    np.testing.assert_array_equal(fired[:, 1], 1.0 - low.lower(x))
    assert_comes_back(system, rtol=1e-9)


def test_names_and_ranges_of_outputs_are_kept() -> None:
    system = parse_fis(TIPPER)
    assert system.consequent_names == (("cheap",), ("average",), ("generous",))
    assert (system.input_ranges, system.output_ranges) == (
        ((0.0, 10.0), (0.0, 10.0)),
        ((0.0, 30.0),),
    )
    text = format_fis(system)
    for line in TIPPER[TIPPER.index("[Output1]") : TIPPER.index("[Rules]")].strip().split("\n"):
        assert line in text
    assert text.count("Range=[0 10]") == 2
    assert_comes_back(system)


numbers = st.integers(-20, 20).map(lambda k: k / 7.0)
widths = st.integers(1, 20).map(lambda k: k / 7.0)
triangles = st.builds(lambda a, b, c: Triangular(a, a + b, a + b + c), numbers, widths, widths)
shapes = st.one_of(
    triangles,
    st.builds(
        lambda a, b, c, d: Trapezoidal(a, a + b, a + b + c, a + b + c + d),
        numbers,
        widths,
        widths,
        widths,
    ),
    st.builds(lambda a, b: Trapezoidal(-math.inf, -math.inf, a, a + b), numbers, widths),
    st.builds(lambda a, b: Trapezoidal(a, a + b, math.inf, math.inf), numbers, widths),
    st.builds(Gaussian, numbers, widths),
    st.builds(Bell, numbers, widths, widths),
    st.builds(Sigmoid, numbers, widths),
    st.builds(lambda a, b, s: NearestMeanGaussian((a, a + b), s), numbers, widths, widths),
    st.builds(
        lambda a, b, c, d: PiShaped(a, a + b, a + b + c, a + b + c + d),
        numbers,
        widths,
        widths,
        widths,
    ),
    st.builds(lambda a, b: PiShaped(-math.inf, -math.inf, a, a + b), numbers, widths),
    st.builds(lambda a, b: PiShaped(a, a + b, math.inf, math.inf), numbers, widths),
    st.builds(
        lambda a, b, s, t: TwoSidedGaussian((a, b), (s, s + t)), numbers, numbers, widths, widths
    ),
    st.builds(lambda a, s: TwoSidedGaussian((a, a), (math.inf, s)), numbers, widths),
    st.builds(
        lambda a, b, s, t: SigmoidDifference((a, a + b), (s, t)), numbers, widths, widths, widths
    ),
    st.builds(lambda a, b, s, t: SigmoidProduct((a, b), (s, -t)), numbers, numbers, widths, widths),
)
scaled = st.one_of(
    st.builds(
        lambda mean, sigma, height: IntervalType2Set(
            Gaussian(mean, sigma, height), Gaussian(mean, sigma)
        ),
        numbers,
        widths,
        st.just(0.7),
    ),
    st.builds(
        lambda one, i, j, height: IntervalType2Set(
            Triangular(
                one.left + i / 8 * (one.peak - one.left),
                one.peak,
                one.right - j / 8 * (one.right - one.peak),
                height,
            ),
            one,
        ),
        triangles,
        st.integers(0, 7),
        st.integers(0, 7),
        st.sampled_from([0.5, 1.0]),
    ),
    st.builds(
        lambda a, b: IntervalType2Set(
            PiShaped(a, a + b, a + b, a + 2 * b, 0.4), PiShaped(a, a + b, a + b, a + 2 * b)
        ),
        numbers,
        widths,
    ),
)
any_pair = scaled | st.builds(
    lambda mean, a, b: GaussianUncertainSigma(mean, (a, a + b)), numbers, widths, widths
)


@st.composite
def systems(draw: st.DrawFn, kind: type, terms: st.SearchStrategy[Any], consequents_of: str) -> Any:
    p, m, count = draw(st.integers(1, 3)), draw(st.integers(1, 2)), draw(st.integers(1, 4))
    inputs = [draw(st.lists(terms, min_size=1, max_size=3)) for _ in range(p)]
    rules = np.array(
        [[draw(st.integers(-1, len(of_input) - 1)) for of_input in inputs] for _ in range(count)]
    )
    rules[(rules < 0).all(axis=1), 0] = 0
    rng = np.random.default_rng(draw(st.integers(0, 99)))
    options: dict[str, Any] = {"t_norm": draw(st.sampled_from(["min", "product"]))}
    consequents: Any
    if consequents_of == "sets":
        of_output = (
            terms
            if kind is IntervalType2System
            else triangles | st.builds(Gaussian, numbers, widths)
        )
        pool = draw(st.lists(of_output, min_size=1, max_size=3))
        consequents = [[draw(st.sampled_from(pool)) for _ in range(m)] for _ in range(count)]
        options |= {
            "resolution": 101,
            "type_reduction": draw(st.sampled_from(["centroid", "center_of_sums"])),
            "integration": "sum",
        }
        if options["type_reduction"] == "centroid":
            options |= {"t_conorm": draw(st.sampled_from(["max", "probabilistic"]))}
    elif consequents_of == "linear":
        consequents = Linear(rng.normal(size=(count, m, p + 1)))
    else:
        consequents = rng.integers(-3, 3, size=(count, m)) / 3.0
        if consequents_of == "intervals":
            consequents = np.stack(
                [consequents, consequents + rng.integers(0, 2, size=(count, m))], axis=-1
            )
    names = draw(
        st.lists(
            st.text("aß '[]:,%=1", min_size=1, max_size=5), min_size=p, max_size=p, unique=True
        )
    )
    return kind(inputs, rules, consequents, **options, input_names=names)


def assert_same_rules(read: Any, system: Any) -> None:
    if isinstance(system.rules, tuple):
        assert read.rules == system.rules
    else:
        np.testing.assert_array_equal(read.rules, system.rules)


def assert_comes_back(system: Any, open_toolbox: bool = False, rtol: float = 0.0) -> None:
    text = format_fis(system, open_toolbox=open_toolbox)
    read = parse_fis(text)
    assert type(read) is type(system)
    assert read.input_names == system.input_names
    assert read.term_names == system.term_names
    assert_same_rules(read, system)
    X = np.random.default_rng(1).uniform(-4.0, 4.0, size=(20, len(system.inputs)))
    np.testing.assert_allclose(read.type_reduced(X), system.type_reduced(X), rtol=rtol, atol=rtol)
    if not rtol:
        assert format_fis(read, open_toolbox=open_toolbox) == text


@pytest.mark.slow
@given(
    st.one_of(
        systems(Type1System, shapes, "numbers"),
        systems(Type1System, shapes, "linear"),
        systems(Type1System, triangles | st.builds(Gaussian, numbers, widths), "sets"),
    )
)
@settings(max_examples=150, deadline=None)
def test_type_1_systems_come_back_the_same(system: Any) -> None:
    """Bit for bit: numbers have all their digits, and output sets lie on the same grid."""
    assert_comes_back(system)


@pytest.mark.slow
@given(
    st.one_of(
        systems(IntervalType2System, scaled, consequents)
        for consequents in ("numbers", "linear", "sets")
    )
)
@settings(max_examples=100, deadline=None)
def test_type_2_systems_come_back(system: Any) -> None:
    """Lags divide and multiply by widths.

    1e-9 is far above their rounding, and far below any mistake.
    """
    assert_comes_back(system, rtol=1e-9)


@given(
    st.one_of(
        systems(IntervalType2System, any_pair | shapes, consequents)
        for consequents in ("numbers", "intervals", "linear")
    )
)
@settings(max_examples=100, deadline=None)
def test_systems_come_back_through_the_open_toolbox(system: Any) -> None:
    assert_comes_back(system, open_toolbox=True)


@pytest.mark.parametrize("system", [parse_fis(TIPPER), parse_fis(TYPE2), parse_fis(OPEN_TYPE2)])
def test_files_come_back(tmp_path: Path, system: Any) -> None:
    path = tmp_path / ("größe.t2fis" if np.ndim(system.consequents) == 3 else "größe.fis")
    write_fis(system, path)
    assert "Name='größe'" in path.read_text(encoding="utf-8")
    X = np.random.default_rng(1).uniform(-1.0, 1.0, size=(20, len(system.inputs)))
    np.testing.assert_allclose(read_fis(path)(X), system(X), rtol=1e-12)


def test_sets_that_are_cut_off_at_the_ends_of_the_range_are_written_whole() -> None:
    wide = IntervalType2Set(
        Truncated(Triangular(-2, 0, 2, 0.5), -1, 3), Truncated(Triangular(-2, 0, 2), -1, 3)
    )
    system = IntervalType2System(
        [[Gaussian(0, 1)]],
        [[0], [0]],
        [wide, Triangular(1, 2, 3)],
        type_reduction="centroid",
        resolution=101,
        integration="sum",
    )
    text = format_fis(system)
    assert "Range=[-1 3]" in text
    assert "'trimf',[-2 0 2],[0.5],[0 0]" in text
    assert_comes_back(system)
