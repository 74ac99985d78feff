"""What is read from MATLAB's files.

The tipper of its documentation, the layouts of type-2 files, and what is refused at which line.
"""

from __future__ import annotations

import contextlib
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy2.errors import MalformedFile, NotExpressible
from fuzzy2.files.fis import format_fis, parse_fis
from fuzzy2.files.fis_names import is_of_octave
from fuzzy2.sets.interval_type2 import (
    GaussianUncertainSigma,
    IntervalType2Set,
)
from fuzzy2.sets.shapes import Gaussian, Trapezoidal, Triangular
from fuzzy2.sets.sigmoids import Sigmoid, SigmoidDifference, SigmoidProduct
from fuzzy2.sets.smooth_shapes import Bell, PiShaped, TwoSidedGaussian
from fuzzy2.sets.uncertain_mean import NearestMeanGaussian
from fuzzy2.systems import IntervalType2System, Type1System
from fuzzy2.systems.antecedents import And, Hedged, Is, Not, Or
from fuzzy2.systems.hedges import HEDGES
from tests.fuzzy2.files.fis_texts import CROSSING, OPEN_TYPE2, TIPPER, TYPE2
from tests.fuzzy2.files.toolbox import Toolbox


def test_the_tipper_gives_what_matlab_documents() -> None:
    """Published by MathWorks, documentation of evalfis, to four decimals.

    The digits after that by a direct sum on its 101 points.
    """
    tips = parse_fis(TIPPER)([[2.0, 1.0], [7.0, 8.0]])
    np.testing.assert_allclose(tips, [[7.0169], [20.3414]], atol=5e-5)
    np.testing.assert_allclose(tips, [[7.016879143126786], [20.34136630526103]], rtol=1e-12)


def test_what_says_that_a_file_is_of_octave() -> None:
    """Its name in a comment, or a norm or defuzzifier that MATLAB has not."""
    assert not is_of_octave(TIPPER)
    assert not is_of_octave("% made with the Fuzzy Logic Toolbox\n" + TIPPER)
    for text in (
        "## This file is part of the fuzzy-logic-toolkit.\n" + TIPPER,
        TIPPER.replace("AndMethod='min'", "AndMethod = 'hamacher_product'"),
        TIPPER.replace("AggMethod='max'", "AggMethod='bounded_sum'"),
        TIPPER.replace("DefuzzMethod='centroid'", "DefuzzMethod='centroid_integral'"),
    ):
        assert is_of_octave(text)
        system = parse_fis(text)
        assert (system.integration, system.resolution) == ("trapezoidal", 101)
        assert parse_fis(text.replace("_integral", ""), dialect="matlab").integration == "sum"
    by_fuzzylite = "# by fuzzylite\n" + TIPPER.replace("='min'", "='einstein_product'")
    assert parse_fis(by_fuzzylite).integration == "midpoint"


def test_the_integral_of_octave_is_of_trapezoids() -> None:
    """Its ``trapz (x, x.*y) / trapz (x, y)`` on 101 points of [0, 30], written out."""
    text = TIPPER.replace("DefuzzMethod='centroid'", "DefuzzMethod='centroid_integral'")
    text = text.replace("3 2, 3 (1) : 2", "3 2, -3 (1) : 2")
    system, y = parse_fis(text), np.linspace(0.0, 30.0, 101)
    cheap, average, generous = (
        np.maximum(1.0 - abs(y - peak) / 5.0, 0.0) for peak in (5.0, 15.0, 25.0)
    )
    for service, food in np.random.default_rng(4).uniform(0.0, 10.0, size=(100, 2)):
        poor, good, excellent = np.exp(-0.5 * ((service - np.array([0, 5, 10])) / 1.5) ** 2)
        rancid, delicious = np.clip([(3.0 - food) / 2.0, (food - 7.0) / 2.0], 0.0, 1.0)
        united = np.minimum(max(poor, rancid), cheap)
        united = np.maximum(united, np.minimum(good, average))
        united = np.maximum(united, np.minimum(max(excellent, delicious), 1.0 - generous))
        expected = np.trapezoid(y * united, y) / np.trapezoid(united, y)
        np.testing.assert_allclose(system([service, food]), [expected], rtol=1e-12)


def test_the_tipper_has_its_names_and_sets() -> None:
    system = parse_fis(TIPPER.replace("\n", "\r\n"))
    assert system.input_names == ("service", "food")
    assert system.output_names == ("tip",)
    assert system.term_names == (("poor", "good", "excellent"), ("rancid", "delicious"))
    assert system.inputs[1] == (Trapezoidal(-2, 0, 1, 3), Trapezoidal(7, 9, 10, 12))
    assert system.rules == (Or((Is(0, 0), Is(1, 0))), Is(0, 1), Or((Is(0, 2), Is(1, 1))))
    assert (system.t_norm.name, system.type_reduction, system.resolution) == (
        "min",
        "centroid",
        101,
    )


def test_an_or_rule_fires_as_its_best_alternative() -> None:
    """Against the maximum of the clipped sets, written out; rounding only."""
    system, y = parse_fis(TIPPER), np.linspace(0.0, 30.0, 101)
    cheap, average, generous = (
        np.maximum(1.0 - abs(y - peak) / 5.0, 0.0) for peak in (5.0, 15.0, 25.0)
    )
    for service, food in np.random.default_rng(2).uniform(0.0, 10.0, size=(50, 2)):
        poor, good, excellent = (
            np.exp(-0.5 * ((service - mean) / 1.5) ** 2) for mean in (0.0, 5.0, 10.0)
        )
        rancid, delicious = (
            np.clip((3.0 - food) / 2.0, 0.0, 1.0),
            np.clip((food - 7.0) / 2.0, 0.0, 1.0),
        )
        clipped = [
            np.minimum(max(poor, rancid), cheap),
            np.minimum(good, average),
            np.minimum(max(excellent, delicious), generous),
        ]
        united = np.max(clipped, axis=0)
        np.testing.assert_allclose(system([service, food]), [y @ united / united.sum()], rtol=1e-12)


def test_scale_and_lags_of_a_type_2_file() -> None:
    """The lower membership function begins where the upper one has the grade of the lag."""
    system = parse_fis(TYPE2)
    assert isinstance(system, IntervalType2System)
    low, high = system.inputs[0]
    assert low.upper == Triangular(-1, -0.5, 0.5)
    assert low.lower.height == 0.8
    np.testing.assert_allclose(low.upper(low.lower.support), [0.1, 0.2], rtol=1e-12)
    assert high == IntervalType2Set(
        Trapezoidal(-0.25, 0.5, math.inf, math.inf), Trapezoidal(-0.5, 0.5, math.inf, math.inf)
    )
    np.testing.assert_array_equal(system.consequents.coefficients, [[[-1.0, 0.0]], [[1.0, 2.0]]])
    # Only the second rule fires at 0.8: the output is its own, 2 x + 1.
    np.testing.assert_allclose(system([0.8]), [2.6], rtol=1e-12)
    assert system.method == "km"


def test_pairs_of_membership_functions_of_the_open_toolbox() -> None:
    system = parse_fis(OPEN_TYPE2)
    assert isinstance(system, IntervalType2System)
    assert system.term_names == (("mf1", "x-N"),)
    first = IntervalType2Set(Triangular(-1.6, -0.5, 0.3, height=0.3), Trapezoidal(-1.8, -1, 0, 1))
    assert system.inputs[0] == (first, GaussianUncertainSigma(1.0, (0.2, 0.4)))
    np.testing.assert_array_equal(system.consequents, [[[-1.0, -0.9]], [[0.5, 0.5]]])


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("'trimf',[0 1 2]", Triangular(0, 1, 2)),
        ("'trapmf',[0, 1, 2, 3]", Trapezoidal(0, 1, 2, 3)),
        ("'trapmf',[-Inf -Inf 2 3]", Trapezoidal(-math.inf, -math.inf, 2, 3)),
        ("'linsmf',[1 2]", Trapezoidal(1, 2, math.inf, math.inf)),
        ("'linzmf',[1 2]", Trapezoidal(-math.inf, -math.inf, 1, 2)),
        ("'gaussmf',[-1.5e0 .5]", Gaussian(0.5, 1.5)),
        ("'gauss2mf',[2 1 2 3]", NearestMeanGaussian((1, 3), 2)),
        ("'gbellmf',[2 4 6]", Bell(center=6, width=2, slope=4)),
        ("'sigmf',[-2 4]", Sigmoid(center=4, slope=-2)),
        ("'gauss2mf',[2 4 -1 8]", TwoSidedGaussian((4, 8), (2, 1))),
        ("'gauss2mf',[2 8 2 4]", TwoSidedGaussian((8, 4), (2, 2))),
        ("'gauss2mf',[Inf 3 2 3]", TwoSidedGaussian((3, 3), (math.inf, 2))),
        ("'smf',[1 8]", PiShaped(1, 8, math.inf, math.inf)),
        ("'zmf',[3 7]", PiShaped(-math.inf, -math.inf, 3, 7)),
        ("'pimf',[1 4 5 10]", PiShaped(1, 4, 5, 10)),
        # Feet beyond the shoulders make a step midway.
        ("'smf',[4 2]", PiShaped(3, 3, math.inf, math.inf)),
        ("'pimf',[4 2 7 5]", PiShaped(3, 3, 6, 6)),
        ("'dsigmf',[5 2 5 7]", SigmoidDifference(center=(2, 7), slope=(5, 5))),
        ("'psigmf',[2 3 -5 8]", SigmoidProduct(center=(3, 8), slope=(2, -5))),
    ],
)
def test_every_shape(line: str, expected: Any) -> None:
    """Parameters in the order of the toolbox's documentation of each membership function."""
    system = parse_fis(TIPPER.replace("'gaussmf',[1.5 0]", line))
    assert system.inputs[0][0] == expected


def test_output_sets_are_cut_off_at_the_range() -> None:
    """As MATLAB does, which takes points of the range only: against its 101 points."""
    system = parse_fis(TIPPER.replace("'trimf',[0 5 10]", "'trimf',[-10 0 10]"))
    y = np.linspace(0.0, 30.0, 101)
    sets = np.clip(
        [(10.0 - y) / 10.0, 1.0 - abs(y - 15.0) / 5.0, 1.0 - abs(y - 25.0) / 5.0], 0.0, 1.0
    )
    grades = np.array([1.0, np.exp(-0.5 * (5.0 / 1.5) ** 2), np.exp(-0.5 * (10.0 / 1.5) ** 2)])
    united = np.minimum(grades[:, None], sets).max(axis=0)
    np.testing.assert_allclose(system([0.0, 5.0]), [y @ united / united.sum()], rtol=1e-12)


def test_the_grid_of_an_output_is_that_of_its_range() -> None:
    """MATLAB's 101 points reach from end to end of the range, beyond the sets of the output too."""
    system, y = (
        parse_fis(TIPPER.replace("Range=[0 30]", "Range=[-5 40]")),
        np.linspace(-5.0, 40.0, 101),
    )
    united = np.maximum(1.0 - abs(y - 15.0) / 5.0, 0.0)
    others = [
        np.minimum(np.maximum(1.0 - abs(y - peak) / 5.0, 0.0), np.exp(-0.5 * (5.0 / 1.5) ** 2))
        for peak in (5.0, 25.0)
    ]
    np.testing.assert_allclose(
        system([5.0, 5.0]),
        [y @ np.max([united, *others], axis=0) / np.max([united, *others], axis=0).sum()],
    )


def edited(text: str, line: int, replacement: str) -> str:
    lines = text.split("\n")
    lines[line - 1] = replacement
    return "\n".join(lines)


@pytest.mark.parametrize(
    ("line", "replacement", "said"),
    [
        (3, "Type='fuzzy'", "expected 'mamdani' or 'sugeno', got 'fuzzy'"),
        (3, "Typ='mamdani'", "unknown key 'Typ'; did you mean 'Type'?"),
        (3, "Type=mamdani", "expected Type='...', got 'mamdani'"),
        (3, "Type: mamdani", "expected <key>=<value>"),
        (3, "Name='again'", "Name occurs twice, first in line 2"),
        (5, "NumInputs=two", "expected a whole number for NumInputs, got 'two'"),
        (5, "NumInputs=0", "a system needs at least one input"),
        (7, "NumRules=4", "NumRules is 4, but there are 3 rules"),
        (15, "", None),
        (16, "Range=[10 0]", "expected Range=[low high], got '[10 0]'"),
        (16, "Range=__import__('os')", "expected Range=[low high]"),
        (17, "NumMFs=2", None),
        (18, "MF1='poor':'gaussmf',[1.5 x]", "expected a number, got 'x'"),
        (18, "MF1='poor':'gaussmf',[1.5]", "gaussmf: the parameters must be 2 numbers, got [1.5]"),
        (18, "MF1='poor':'gaussmf',[0 5]", "gaussmf: sigma must be a finite number above 0"),
        (18, "MF1='poor','gaussmf',[1.5 0]", "expected '<name>':'<kind>',[parameters]"),
        (18, "MF1='':'gaussmf',[1.5 0]", "the name of the membership function is empty"),
        (18, "MF1='poor':'gaussmf',[1.5 0],[2],[0 0]", "in [0, 1]"),
        (30, "[Output2]", None),
        (30, "[Input2]", "the section [Input2] occurs twice"),
        (33, "NumMFs=0", None),
        (34, "MF1='cheap':'trimf',[5 0 10]", "trimf: left, peak, right must be in ascending order"),
        (39, "1 1 1, 1 (1) : 2", "expected 2 numbers for the inputs, got 3"),
        (39, "1 3, 1 (1) : 2", "food has membership functions 1 to 2, got '3'"),
        (39, "1 -3, 1 (1) : 2", "food has membership functions 1 to 2, got '-3'"),
        (40, "-1 -2, 1 (1) : 2\n4 0, 1 (1) : 1", None),
        (18, "MF1='poor':'dsigmf',[1 2 1 2]", "dsigmf: center must be different for equal slopes"),
        (39, "1 1.5, 1 (1) : 2", "food has membership functions 1 to 2, got '1.5'"),
        (39, "1 1.000000003, 1 (1) : 2", "membership functions 1 to 2, got '1.000000003'"),
        (18, "MF1='poor':'gaussmf',[１.5 0]", "expected a number, got '１.5'"),
        (17, "NumMFs=٣", "expected a whole number for NumMFs, got '٣'"),
        (39, "1 1, 4 (1) : 2", "tip has membership functions 1 to 3, got '4'"),
        (39, "1 1, 1 : 2", "expected '<inputs>, <outputs> (<weight>) : <1 or 2>'"),
        (39, "1 1, 1 (1) : 3", "expected 1 (and) or 2 (or) at the end, got 3"),
        (39, "0 0, 1 (1) : 1", "the rule has no antecedent"),
    ],
)
def test_a_malformed_file_names_the_line(line: int, replacement: str, said: str | None) -> None:
    with pytest.raises(MalformedFile) as caught:
        parse_fis(edited(TIPPER, line, replacement), "tipper.fis")
    assert caught.value.source == "tipper.fis"
    if said is None:
        assert caught.value.place.startswith("line ")
    else:
        assert (caught.value.place, said in caught.value.reason) == (f"line {line}", True), str(
            caught.value
        )


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("", "line 1"),
        ("x", "line 1"),
        ("[Rules]\n1, 1 (1) : 1", "line 1"),
        (TIPPER.replace("[Rules]", "[Rule]"), "line 38"),
        (TIPPER[: TIPPER.index("[Rules]")], "line 1"),
        (TIPPER.replace("NumInputs=2", "NumInputs=3"), "line 1"),
        (TIPPER.replace("NumInputs=2", "NumInputs=1"), "line 22"),
        (TIPPER.replace("NumMFs=3", "NumMFs=2"), "line 20"),
        (TIPPER.replace("Name='food'", "Name='service'"), "line 1"),
    ],
)
def test_sections_that_do_not_go_together(text: str, place: str) -> None:
    with pytest.raises(MalformedFile) as caught:
        parse_fis(text)
    assert caught.value.place == place


@pytest.mark.parametrize(
    ("text", "old", "new", "line", "reason"),
    [
        (TIPPER, "DefuzzMethod='centroid'", "DefuzzMethod='mine'", 12, "known are centroid"),
        (TIPPER, "Type='mamdani'", "Type='unknown'", 3, "known are mamdani"),
        (TIPPER, "AndMethod='min'", "AndMethod='mymin'", 8, "known are min, prod"),
        (TIPPER, "OrMethod='max'", "OrMethod='sum'", 9, "known are max, probor"),
        (TYPE2, "1, 1 (1) : 1", "1, -1 (1) : 1", 30, "only sets have a complement"),
        (TIPPER, "1 1, 1 (1) : 2", "1.01 1, 1 (1) : 2", 39, "it is not a power"),
        (TIPPER, "1 1, 1 (1) : 2", "1 1, 1.2 (1) : 2", 39, "dialect='octave'"),
        (TIPPER, "'gaussmf',[1.5 0]", "'pimf',[1 5 4 8]", 18, "must not be left of the first one"),
        (TIPPER, "'gaussmf',[1.5 0]", "'mymf',[1.5 2]", 18, "known are trimf"),
        (TIPPER, "'gaussmf',[1.5 0]", "'sigmf',[0 2]", 18, "1/2 everywhere"),
        (TYPE2, "'trimf',[-1 -0.5 0.5],[0.8]", "'trimf',[-1 -0.5 0.5],[0]", 19, "above 0"),
        (TYPE2, "'constant',[-1]", "'cubic',[-1]", 26, "known are constant and linear"),
        (TYPE2, "'linear',[2 1]", "'linear',[2 1 1 0]", 27, "must be above"),
        (TYPE2, "'karnikmendel'", "'mine'", 13, "known are karnikmendel"),
        (OPEN_TYPE2, "'Karnik-Mendel'", "'BMM(0.9)'", 13, "known are KM"),
        (OPEN_TYPE2, "'Karnik-Mendel'", "'BMM(1e,2)'", 13, "BMM(a,b)"),
    ],
)
def test_what_a_system_cannot_be_is_refused_with_its_line(
    text: str, old: str, new: str, line: int, reason: str
) -> None:
    assert old in text
    with pytest.raises(NotExpressible, match="cannot be expressed in fuzzy2") as caught:
        parse_fis(text.replace(old, new, 1), "a.fis")
    assert caught.value.what.startswith(f"a.fis, line {line}: ")
    assert reason in caught.value.reason


@pytest.mark.parametrize(
    ("text", "old", "new", "said"),
    [
        (
            OPEN_TYPE2,
            "[-1.8 -1 0 1 1]",
            "[-0.9 -0.5 0 1 1]",
            "the pair: lower must be at most upper everywhere, but at x = ",
        ),
        (OPEN_TYPE2, "MF1L=", "MF3L=", "has no MF1L"),
        (
            TYPE2,
            "'linear',[2 1]",
            "'linear',[2 1 3]",
            "expected 2 numbers, a slope for each input and the constant, got 3",
        ),
        (
            TYPE2,
            "'constant',[-1]",
            "'constant',[2 1]",
            "expected one number, or the ends of an interval",
        ),
        (TYPE2, "'constant',[-1]", "'constant',[Inf]", "expected finite numbers"),
    ],
)
def test_malformed_type_2_files(text: str, old: str, new: str, said: str) -> None:
    with pytest.raises(MalformedFile, match="line ") as caught:
        parse_fis(text.replace(old, new, 1))
    assert said in caught.value.reason


@given(st.sampled_from([TIPPER, TYPE2, OPEN_TYPE2]), st.data())
@settings(max_examples=300, deadline=None)
def test_damaged_files_raise_nothing_else(text: str, data: st.DataObject) -> None:
    start = data.draw(st.integers(0, len(text)))
    end = data.draw(st.integers(start, min(len(text), start + 8)))
    damaged = (
        text[:start] + data.draw(st.text("0123456789-.'[](),:=\n aMF", max_size=4)) + text[end:]
    )
    # An error of any other class fails the test.
    with contextlib.suppress(MalformedFile, NotExpressible):
        parse_fis(damaged)


def edits(text: str, *pairs: tuple[str, str]) -> str:
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new, 1)
    return text


SUGENO = edits(
    TIPPER,
    ("'mamdani'", "'sugeno'"),
    ("'centroid'", "'wtaver'"),
    ("'trimf',[0 5 10]", "'constant',[5]"),
    ("'trimf',[10 15 20]", "'linear',[1 -2 15]"),
    ("'trimf',[20 25 30]", "'constant',[25 0 0 0]"),
)


@pytest.mark.parametrize(
    "text",
    [
        edits(TIPPER, ("1 1, 1 (1) : 2", "1 -1, 1 (0.5) : 2")),
        edits(TIPPER, ("AndMethod='min'", "AndMethod='prod'"), ("2 0, 2", "-2 1, -2")),
        edits(TIPPER, ("ImpMethod='min'", "ImpMethod='prod'"), ("(1) : 1", "(0.3) : 1")),
        edits(TIPPER, ("AggMethod='max'", "AggMethod='probor'")),
        edits(TIPPER, ("AggMethod='max'", "AggMethod='sum'"), ("'max'", "'probor'")),
        edits(TIPPER, ("'centroid'", "'mom'")),
        edits(TIPPER, ("'centroid'", "'som'"), ("Range=[0 30]", "Range=[-10 30]")),
        edits(TIPPER, ("'centroid'", "'lom'"), ("[0 5 10]", "[-40 -35 0]"), ("[0 30]", "[-50 30]")),
        edits(TIPPER, ("'gaussmf',[1.5 0]", "'gbellmf',[2 3 0 0]")),
        edits(TIPPER, ("[1.5 5]", "[1.5 pi]"), ("%", "# also a comment\n%")),
        SUGENO,
        edits(SUGENO, ("'wtaver'", "'wtsum'"), ("1 1, 1 (1)", "1 1, 1 (0.7)")),
        edits(
            SUGENO, ("AndMethod='min'", "AndMethod='prod'"), ("3 2, 3 (1) : 2", "3 -2, 3 (1) : 1")
        ),
    ],
)
def test_against_the_toolbox_in_a_hundred_lines(text: str) -> None:
    """To 1e-9: the same sums in another order; `toolbox.py` is written from the documentation."""
    system, other = parse_fis(text), Toolbox(text)
    X = np.random.default_rng(3).uniform(0.0, 10.0, size=(60, 2))
    np.testing.assert_allclose(system(X), [other(list(x)) for x in X], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("method", ["KM", "EKM", "IASC", "EIASC", "EODS", "NT", "BMM(0.9,0.3)"])
def test_type_2_against_the_toolbox_in_a_hundred_lines(method: str) -> None:
    """Exact methods against all switch points, to 1e-9."""
    text = OPEN_TYPE2.replace("Karnik-Mendel", method)
    system, other = parse_fis(text), Toolbox(text)
    # Where a lower grade of all rules is 0, the average of Begian, Melek and Mendel has no answer.
    X = np.random.default_rng(3).uniform(-1.0, 0.2, size=(60, 1))
    np.testing.assert_allclose(system(X), [other(list(x)) for x in X], rtol=1e-9, atol=1e-9)


def test_a_rule_may_be_silent_and_an_input_without_terms() -> None:
    text = edits(
        SUGENO,
        ("NumInputs=2", "NumInputs=3"),
        ("[Output1]", "[Input3]\nName='c'\nRange=[0 0]\nNumMFs=0\n\n[Output1]"),
        ("'linear',[1 -2 15]", "'linear',[1 -2 3 15]"),
        ("1 1, 1 (1) : 2", "1 1 0, 1 (1) : 2"),
        ("2 0, 2 (1) : 1", "2 0 0, 2 (1) : 1"),
        ("3 2, 3 (1) : 2", "3 2 0, 3 (1) : 2"),
    )
    system, other = parse_fis(text), Toolbox(text)
    X = np.random.default_rng(3).uniform(0.0, 10.0, size=(40, 3))
    np.testing.assert_allclose(system(X), [other(list(x)) for x in X], rtol=1e-9)


def test_hedges_of_fuzzylite_and_of_octave() -> None:
    text = edits(TIPPER, ("2 0, 2 (1) : 1", "2.3 -1.05, 2 (1) : 1"))
    for dialect in ("matlab", "octave"):
        tree = parse_fis(text, dialect=dialect).rules[1]
        assert tree == And(
            (Hedged(HEDGES["extremely"], Is(0, 1)), Not(Hedged(HEDGES["somewhat"], Is(1, 0))))
        )


def test_names_that_terms_share_are_told_apart() -> None:
    system = parse_fis(edits(TIPPER, ("MF2='good'", "MF2='poor'")))
    assert system.term_names[0] == ("poor", "poor_2", "excellent")


def test_sets_that_cross_are_averaged_as_they_are_by_nie_and_tan() -> None:
    """What the toolbox computes: lower and upper firing each counts once, whichever is greater."""
    system = parse_fis(CROSSING)
    assert isinstance(system, Type1System)
    crossed = 0
    for x in np.linspace(-1.0, 1.0, 101):
        upper = float(np.interp(x, [-0.9, -0.5, 0.0, 0.5], [0.0, 1.0, 1.0, 0.0]))
        lower = float(0.3 * np.interp(x, [-1.6, -0.5, 0.3], [0.0, 1.0, 0.0]))
        crossed += lower > upper
        other = [math.exp(-((x - 1.0) ** 2) / (2.0 * sigma**2)) for sigma in (0.4, 0.2)]
        said = 0.5 * ((2.0 * x + 1.0) + (-x + 0.5))
        first, second = upper + lower, sum(other)
        expected = (first * said + second * 0.5) / (first + second)
        np.testing.assert_allclose(system([x]), [expected], rtol=1e-12)
    assert crossed > 3


@pytest.mark.parametrize("number", ["-2", "5.5", "-pi/2"])
def test_a_single_number_needs_no_brackets(number: str) -> None:
    """MATLAB evaluates the text, to which brackets around one number mean nothing."""
    X = np.random.default_rng(0).uniform(0.0, 10.0, (20, 2))
    bare, bracketed = (
        parse_fis(edits(SUGENO, ("'constant',[5]", f"'constant',{text}")))
        for text in (number, f"[{number}]")
    )
    np.testing.assert_array_equal(bare(X), bracketed(X))
    for bad in ("", "-2 3", "[2", "2]", "two"):
        with pytest.raises(MalformedFile):
            parse_fis(edits(SUGENO, ("'constant',[5]", f"'constant',{bad}")))


@pytest.mark.parametrize("low", [0.0, -2.0])
@pytest.mark.parametrize("method", ["Karnik-Mendel", "WM", "BMM(0.3,0.6)"])
def test_a_linear_function_for_each_end(low: float, method: str) -> None:
    """Against both ends as intervals of numbers at each input, and there and back."""
    slope = (1.0, 2.0) if low == 0.0 else (2.0, 1.0)
    others = ("Karnik-Mendel", method), ("Range=[-1 1]", f"Range=[{low} {low + 2.0}]")
    old = "'constant',[-1 -0.9]"
    X = np.linspace(low, low + 2.0, 31)[:, np.newaxis]
    expected = [
        parse_fis(
            edits(
                OPEN_TYPE2,
                *others,
                (old, f"'constant',[{slope[0] * x - 1.0!r} {slope[1] * x!r}]"),
            )
        )([x])
        for x in X[:, 0].tolist()
    ]
    text = edits(OPEN_TYPE2, *others, (old, f"'linear',[{slope[0]} -1 {slope[1]} 0]"))
    system = parse_fis(text)
    np.testing.assert_allclose(system(X), expected, rtol=1e-12, atol=1e-12)
    again = format_fis(system, open_toolbox=True)
    np.testing.assert_allclose(parse_fis(again)(X), expected, rtol=1e-12, atol=1e-12)


def test_an_end_of_zeros_is_an_end() -> None:
    text = edits(OPEN_TYPE2, ("'constant',[-1 -0.9]", "'linear',[0 -1 0 0]"))
    constants = edits(OPEN_TYPE2, ("'constant',[-1 -0.9]", "'constant',[-1 0]"))
    np.testing.assert_allclose(parse_fis(text)([0.3]), parse_fis(constants)([0.3]), rtol=1e-12)


@pytest.mark.parametrize(
    ("parameters", "low"), [("1 0 2 1", -1.0), ("1 0 1 -1", -1.0), ("2 0 1 1", 0.0)]
)
def test_linear_ends_that_cross_are_refused(parameters: str, low: float) -> None:
    text = edits(
        OPEN_TYPE2,
        ("Range=[-1 1]", f"Range=[{low} 1]"),
        ("'constant',[-1 -0.9]", f"'linear',[{parameters}]"),
    )
    with pytest.raises(NotExpressible, match=r"line 30: a linear function for each end.*'NT'"):
        parse_fis(text)
    parse_fis(edits(text, ("'Karnik-Mendel'", "'NT'")))


def test_a_number_that_two_terms_share_counts_on() -> None:
    """MATLAB reads terms one after the other, and one of its own demos repeats a number."""
    again = parse_fis(edits(TIPPER, ("MF3='excellent'", "MF2='excellent'")))
    assert again.term_names[0] == parse_fis(TIPPER).term_names[0]
    X = np.random.default_rng(0).uniform(0.0, 10.0, (20, 2))
    np.testing.assert_array_equal(again(X), parse_fis(TIPPER)(X))
