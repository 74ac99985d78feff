"""How systems are written to MATLAB's files, and what these cannot say."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from fuzzy2.errors import NotExpressible
from fuzzy2.files.fis import format_fis, parse_fis
from fuzzy2.sets.derived import Complement, Truncated
from fuzzy2.sets.gaussian_type2 import GaussianType2Set
from fuzzy2.sets.interval_type2 import (
    GaussianUncertainMean,
)
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.sigmoids import Sigmoid
from fuzzy2.sets.type1 import SampledSet, Singleton
from fuzzy2.systems import GeneralType2System, IntervalType2System, Linear, Type1System
from fuzzy2.systems.fuzzifiers import NonSingletonFuzzifier


def test_a_complement_whose_set_is_no_term_makes_one() -> None:
    """The set becomes a term of its own; the answers stay the same."""
    terms = {
        "x": {
            "not low": Complement(G),
            "low": Triangular(0, 1, 2),
            "not": Complement(Sigmoid(0, 1)),
        }
    }
    system = Type1System(
        [*(list(of.values()) for of in terms.values())],
        [[0], [1], [2]],
        [[1.0], [2.0], [4.0]],
        term_names=[[*terms["x"]]],
    )
    text = format_fis(system)
    assert [line for line in text.split("\n") if line.startswith("MF")][:3] == [
        "MF1='low':'trimf',[0 1 2]",
        "MF2='not not low':'gaussmf',[1 0]",
        "MF3='not not':'sigmf',[1 0]",
    ]
    assert "-2, 1 (1) : 1\n1, 2 (1) : 1\n-3, 3 (1) : 1" in text
    X = np.linspace(-3.0, 3.0, 31)[:, np.newaxis]
    # The complement is Python's in one, the compiled loop's in the other: exponentials of two
    # libraries may differ by a rounding.
    np.testing.assert_allclose(parse_fis(text)(X), system(X), rtol=1e-15)


def test_one_name_for_two_consequents_is_refused() -> None:
    system = Type1System([[G]], [[0], [0]], [[1.0], [2.0]], consequent_names=[["a"], ["a"]])
    with pytest.raises(NotExpressible, match="the name 'a' for two consequents of y1"):
        format_fis(system)


def test_shapes_of_another_name_are_written_as_trapezoids() -> None:
    system = Type1System([[Interval(0, 1), Singleton(2)]], [[0], [1]], [[1.0], [2.0]])
    read = parse_fis(format_fis(system))
    assert read.inputs[0] == (Trapezoidal(0, 0, 1, 1), Trapezoidal(2, 2, 2, 2))
    np.testing.assert_array_equal(read([[0.5], [2.0]]), [[1.0], [2.0]])


def test_a_set_that_is_cut_off_within_the_range_is_refused() -> None:
    system = Type1System(
        [[G]], [[0], [0]], [Truncated(G, -1, 1), Triangular(-2, 0, 2)], type_reduction="centroid"
    )
    with pytest.raises(
        NotExpressible,
        match=(
            r"Truncated.* cannot be expressed in \.fis: it has no membership function of that "
            r"shape"
        ),
    ):
        format_fis(system)


G, N = Gaussian(0, 1), [[1.0]]


@pytest.mark.parametrize(
    ("system", "said"),
    [
        (
            GeneralType2System([[GaussianType2Set(G, 0.1)]], [[0]], N, t_norm="min"),
            "GeneralType2System cannot be expressed in .fis",
        ),
        (
            Type1System([[G]], [[0]], N, fuzzifier=NonSingletonFuzzifier(G)),
            "the fuzzifier NonSingletonFuzzifier",
        ),
        (
            Type1System([[G]], [[0]], N, t_norm="hamacher"),
            "the t-norm 'hamacher' cannot be expressed in .fis: it has min, prod only",
        ),
        (Type1System([[G]], [[0]], N, t_norm=lambda a, b: a * b), "it is a Python function"),
        (Type1System([[G]], [[0]], [G]), "type reduction 'center_of_sets'"),
        (
            Type1System([[G]], [[0]], [G], type_reduction="centroid", t_conorm="einstein"),
            "the t-conorm 'einstein'",
        ),
        (Type1System([[G]], [[0]], [[[1.0, 2.0]]]), "the interval [1.0, 2.0] as a consequent"),
        (
            Type1System([[G]], [[0]], Linear([[[1.0, 2.0]]], [[[1.0, 0.0]]])),
            "linear consequents with spreads",
        ),
        (Type1System([[Gaussian(0, 1, 0.5)]], [[0]], N), "its membership functions reach 1"),
        (
            Type1System([[SampledSet([0, 1], [0, 1])]], [[0]], N),
            "it has no membership function of that shape",
        ),
        (
            Type1System([[Trapezoidal(-math.inf, -math.inf, math.inf, math.inf), G]], [[1]], N),
            "no membership function of that shape",
        ),
        (Type1System([[G]], [[-1]], N), "a rule without an antecedent"),
        (Type1System([[G]], [[0]], N, input_names=["a\nb"]), "the name 'a\\nb'"),
        (
            IntervalType2System([[GaussianUncertainMean((0, 1), 1)]], [[0]], N),
            "not the upper one, scaled and lagged",
        ),
    ],
)
def test_what_the_format_cannot_say_is_refused(system: Any, said: str) -> None:
    with pytest.raises(NotExpressible) as caught:
        format_fis(system)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("system", "said"),
    [
        (Type1System([[G]], [[0]], N), "type-2 systems only"),
        (IntervalType2System([[G]], [[0]], [G], type_reduction="centroid"), "Sugeno systems only"),
        (
            IntervalType2System([[GaussianUncertainMean((0, 1), 1)]], [[0]], N),
            "no membership function of that shape",
        ),
    ],
)
def test_what_the_open_toolbox_cannot_say_is_refused(system: Any, said: str) -> None:
    with pytest.raises(NotExpressible, match=r"cannot be expressed in \.t2fis") as caught:
        format_fis(system, open_toolbox=True)
    assert said in str(caught.value)


def test_what_the_program_would_integrate_otherwise_is_refused() -> None:
    """The error names what to take, and what is taken so comes back equal."""
    system = Type1System(
        [[Triangular(-2, -1, 1), Triangular(-1, 1, 2)]],
        [[0], [1]],
        [Triangular(0, 1, 2), Triangular(1, 2, 3)],
        type_reduction="centroid",
        output_ranges=[(0, 3)],
        default_outputs=[0.5],
    )
    X = np.linspace(-1.5, 1.5, 20)[:, np.newaxis]
    for dialect, integration, points in (
        ("matlab", "sum", 101),
        ("octave", "trapezoidal", 101),
        ("fuzzylite", "midpoint", 100),
    ):
        for other in ("exact", "sum", "trapezoidal", "midpoint", "left"):
            own = system.replace(integration=other, resolution=points, default_outputs=None)
            if other != integration:
                with pytest.raises(NotExpressible, match=rf"integrat.*{integration}"):
                    format_fis(own, dialect=dialect)
                continue
            read = parse_fis(format_fis(own, dialect=dialect), dialect=dialect)
            np.testing.assert_allclose(read(X), own(X), rtol=1e-12)
            with pytest.raises(NotExpressible, match=f"resolution={points}"):
                format_fis(own.replace(resolution=77), dialect=dialect)
    own = system.replace(integration="sum", resolution=101)
    with pytest.raises(NotExpressible, match=r"the default 0.5 .* replace\(default_outputs=None"):
        format_fis(own)
