"""IEEE 1855: what is written is read back."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy2.files.fis import parse_fis
from fuzzy2.files.fml import format_fml, parse_fml, read_fml, write_fml
from fuzzy2.sets.derived import Complement
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.smooth_shapes import PiShaped, TwoSidedGaussian
from fuzzy2.sets.type1 import SampledSet, Singleton
from fuzzy2.systems import Linear, Type1System
from tests.fuzzy2.files.fis_texts import TIPPER as TIPPER_FIS
from tests.fuzzy2.files.fml_texts import TIPPER, TSK
from tests.fuzzy2.files.test_fis import assert_same_rules

numbers = st.floats(-5.0, 5.0)
widths = st.floats(0.1, 5.0)
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
    st.builds(lambda a, b: Interval(a, a + b), numbers, widths),
    st.builds(Singleton, numbers),
    st.builds(
        lambda a, b, c: SampledSet([a, a + b, a + b + c], [0.0, 1.0, 0.0]), numbers, widths, widths
    ),
    st.builds(lambda a, b: PiShaped(-math.inf, -math.inf, a, a + b), numbers, widths),
    st.builds(lambda a, b: PiShaped(a, a + b, math.inf, math.inf), numbers, widths),
    st.builds(
        lambda a, b: PiShaped(a, b, b, b + (b - a)), st.floats(-5.0, 0.0), st.floats(0.1, 5.0)
    ),
    st.builds(lambda a, s: TwoSidedGaussian((a, a), (math.inf, s)), numbers, widths),
    st.builds(lambda a, s: TwoSidedGaussian((a, a), (s, math.inf)), numbers, widths),
)
shapes |= shapes.map(Complement)


@st.composite
def systems(draw: st.DrawFn) -> Type1System:
    p, m, count = draw(st.integers(1, 3)), draw(st.integers(1, 2)), draw(st.integers(1, 4))
    inputs = [draw(st.lists(shapes, min_size=1, max_size=3)) for _ in range(p)]
    rules = np.array(
        [[draw(st.integers(-1, len(terms) - 1)) for terms in inputs] for _ in range(count)]
    )
    rules[(rules < 0).all(axis=1), 0] = 0
    rng = np.random.default_rng(draw(st.integers(0, 99)))
    options: dict[str, Any] = {
        "t_norm": draw(
            st.sampled_from(["min", "product", "lukasiewicz", "drastic", "einstein", "hamacher"])
        )
    }
    kind = draw(st.sampled_from(["numbers", "linear", "sets"]))
    consequents: Any
    if kind == "sets":
        pool = draw(
            st.lists(triangles | st.builds(Gaussian, numbers, widths), min_size=1, max_size=3)
        )
        consequents = [[draw(st.sampled_from(pool)) for _ in range(m)] for _ in range(count)]
        conorm = draw(
            st.sampled_from(
                [
                    "max",
                    "probabilistic",
                    "lukasiewicz",
                    "drastic",
                    "nilpotent",
                    "hamacher",
                    "einstein",
                ]
            )
        )
        options |= {"type_reduction": "centroid", "t_conorm": conorm, "integration": "sum"}
    else:
        consequents = (
            Linear(rng.normal(size=(count, m, p + 1)))
            if kind == "linear"
            else rng.normal(size=(count, m))
        )
    names = draw(
        st.lists(
            st.text("aß <>&\"' [];", min_size=1, max_size=5),
            min_size=p + m,
            max_size=p + m,
            unique=True,
        )
    )
    return Type1System(
        inputs, rules, consequents, **options, input_names=names[:p], output_names=names[p:]
    )


@given(systems())
@settings(max_examples=150, deadline=None)
def test_systems_come_back_the_same(system: Type1System) -> None:
    """Bit for bit: numbers have all their digits, and output sets lie on the same grid."""
    text = format_fml(system)
    read = parse_fml(text)
    assert (read.inputs, read.input_names, read.output_names) == (
        system.inputs,
        system.input_names,
        system.output_names,
    )
    assert (read.t_norm, read.term_names) == (system.t_norm, system.term_names)
    assert_same_rules(read, system)
    X = np.random.default_rng(1).uniform(-4.0, 4.0, size=(20, len(system.inputs)))
    np.testing.assert_array_equal(read(X), system(X))
    assert format_fml(read) == text


def test_negations_are_complements() -> None:
    """The modifier makes 1 minus the grade, as the complement of a term does.

    Against the same system as a .fis file.
    """
    text = TIPPER.replace(
        "<clause><variable>food</variable><term>ran",
        '<clause modifier="not"><variable>food</variable><term>ran',
    )
    text = text.replace(
        "<then><clause><variable>tip</variable><term>ge",
        '<then><clause modifier="not"><variable>tip</variable><term>ge',
    )
    system = parse_fml(text.replace('"good" complement="false"', '"good" complement="TRUE"'))
    other = parse_fis(
        TIPPER_FIS.replace("1 1, 1", "1 -1, 1")
        .replace("2 0, 2", "-2 0, 2")
        .replace("3 2, 3", "3 2, -3")
    )
    assert system.inputs[0] == (Gaussian(0, 1.5), Complement(Gaussian(5, 1.5)), Gaussian(10, 1.5))
    assert system.term_names[1] == ("rancid", "delicious")
    on_its_grid = system.replace(resolution=other.resolution)
    X = np.random.default_rng(0).uniform(0.0, 10.0, size=(50, 2))
    np.testing.assert_allclose(on_its_grid(X), other(X), rtol=1e-12)
    written = format_fml(system)
    assert written.count('complement="true"') == 2
    assert written.count('modifier="not"') == 1
    np.testing.assert_array_equal(parse_fml(written)(X), system(X))
    assert format_fml(parse_fml(written)) == written


def test_names_and_domains_of_outputs_are_kept() -> None:
    system = parse_fml(TIPPER.replace('domainright="30.0"', 'domainright="35.0"'))
    assert system.consequent_names == (("cheap",), ("average",), ("generous",))
    assert (system.input_ranges, system.output_ranges) == (
        ((0.0, 10.0), (0.0, 10.0)),
        ((0.0, 35.0),),
    )
    text = format_fml(system)
    for part in (
        'name="tip" domainleft="0.0" domainright="35.0"',
        'name="food" domainleft="0.0" domainright="10.0"',
        '"generous"',
    ):
        assert part in text
    assert parse_fml(TSK).output_ranges is None
    assert parse_fml(format_fml(parse_fml(TSK))).consequent_names == (("plane",), ("fixed",))


def test_files_come_back(tmp_path: Path) -> None:
    system = parse_fml(TIPPER)
    write_fml(system, tmp_path / "tip&per.xml")
    assert 'name="tip&amp;per"' in (tmp_path / "tip&per.xml").read_text(encoding="utf-8")
    X = np.random.default_rng(1).uniform(0.0, 10.0, size=(20, 2))
    np.testing.assert_array_equal(read_fml(tmp_path / "tip&per.xml")(X), system(X))
