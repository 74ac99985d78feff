"""MATLAB's files.

The tipper of its documentation, the layouts of type-2 files, round trips, and what is refused at
which line.
"""

from __future__ import annotations

import contextlib
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy2.errors import MalformedFile, NotExpressible
from fuzzy2.files.fis import format_fis, parse_fis, read_fis, write_fis
from fuzzy2.sets.derived import Complement, Truncated
from fuzzy2.sets.gaussian_type2 import GaussianType2Set
from fuzzy2.sets.interval_type2 import (
    GaussianUncertainMean,
    GaussianUncertainSigma,
    IntervalType2Set,
)
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.sigmoids import Sigmoid, SigmoidDifference, SigmoidProduct
from fuzzy2.sets.smooth_shapes import Bell, PiShaped, TwoSidedGaussian
from fuzzy2.sets.type1 import SampledSet, Singleton
from fuzzy2.sets.uncertain_mean import NearestMeanGaussian
from fuzzy2.systems import GeneralType2System, IntervalType2System, Linear, Type1System
from fuzzy2.systems.fuzzifiers import NonSingletonFuzzifier

# tipper.fis of the Fuzzy Logic Toolbox, as its documentation describes it.
TIPPER = """\
[System]
Name='tipper'
Type='mamdani'
Version=2.0
NumInputs=2
NumOutputs=1
NumRules=3
AndMethod='min'
OrMethod='max'
ImpMethod='min'
AggMethod='max'
DefuzzMethod='centroid'

[Input1]
Name='service'
Range=[0 10]
NumMFs=3
MF1='poor':'gaussmf',[1.5 0]
MF2='good':'gaussmf',[1.5 5]
MF3='excellent':'gaussmf',[1.5 10]

[Input2]
Name='food'
Range=[0 10]
NumMFs=2
MF1='rancid':'trapmf',[-2 0 1 3]
MF2='delicious':'trapmf',[7 9 10 12]

% the tip in percent
[Output1]
Name='tip'
Range=[0 30]
NumMFs=3
MF1='cheap':'trimf',[0 5 10]
MF2='average':'trimf',[10 15 20]
MF3='generous':'trimf',[20 25 30]

[Rules]
1 1, 1 (1) : 2
2 0, 2 (1) : 1
3 2, 3 (1) : 2
"""

# The layout that the Fuzzy Logic Toolbox gives a sugfistype2.
TYPE2 = """\
[System]
Name='type2'
Type='sugeno'
Version=3.0
NumInputs=1
NumOutputs=1
NumRules=2
AndMethod='prod'
OrMethod='probor'
ImpMethod='prod'
AggMethod='sum'
DefuzzMethod='wtaver'
TypeReductionMethod='karnikmendel'

[Input1]
Name='e'
Range=[-1 1]
NumMFs=2
MF1='N':'trimf',[-1 -0.5 0.5],[0.8],[0.1 0.2]
MF2='P':'linsmf',[-0.5 0.5],[1],[0.25 0]

[Output1]
Name='u'
Range=[0 1]
NumMFs=2
MF1='low':'constant',[-1]
MF2='high':'linear',[2 1]

[Rules]
1, 1 (1) : 1
2, 2 (1) : 1
"""

# The layout of the open IT2-FLS toolbox.
OPEN_TYPE2 = """\
[System]
Name='open'
Type='sugeno'
Version=2.0
NumInputs=1
NumOutputs=1
NumRules=2
AndMethod='prod'
OrMethod='probor'
ImpMethod='prod'
AggMethod='sum'
DefuzzMethod='wtaver'
TypeRedMethod='Karnik-Mendel'
outputType='interval'

[Input1]
Name='input1'
Range=[-1 1]
NumMFs=2
MF1U='mf1U':'trapmf',[-1.8 -1 0 1 1]
MF1L='mf1L':'trimf',[-1.6 -0.5 0.3 0.3]
MF2U='x-N':'gaussmf',[0.4 1 1]
MF2L='mf2L':'gaussmf',[0.2 1 1]

[Output1]
Name='output1'
CrispInterval='interval'
Range=[-1 1]
NumMFs=2
MF1='mf1':'constant',[-1 -0.9]
MF2='mf2':'constant',[0.5]

[Rules]
1, 1 (1) : 1
2, 2 (1) : 1
"""


def test_the_tipper_gives_what_matlab_documents() -> None:
    """Published by MathWorks, documentation of evalfis, to four decimals.

    The digits after that by a direct sum on its 101 points.
    """
    tips = parse_fis(TIPPER)([[2.0, 1.0], [7.0, 8.0]])
    np.testing.assert_allclose(tips, [[7.0169], [20.3414]], atol=5e-5)
    np.testing.assert_allclose(tips, [[7.016879143126786], [20.34136630526103]], rtol=1e-12)


def test_the_tipper_has_its_names_and_sets() -> None:
    system = parse_fis(TIPPER.replace("\n", "\r\n"))
    assert system.input_names == ("service", "food")
    assert system.output_names == ("tip",)
    assert system.term_names == (("poor", "good", "excellent"), ("rancid", "delicious"))
    assert system.inputs[1] == (Trapezoidal(-2, 0, 1, 3), Trapezoidal(7, 9, 10, 12))
    np.testing.assert_array_equal(system.rules, [[0, -1], [-1, 0], [1, -1], [2, -1], [-1, 1]])
    assert (system.t_norm.name, system.type_reduction, system.resolution) == (
        "min",
        "centroid",
        101,
    )


def test_an_or_rule_is_the_same_as_its_alternatives() -> None:
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


def test_negations_are_complements() -> None:
    """MATLAB's -k is 1 minus the grade of term k, in every rule.

    Written out for the tipper on its 101 points.
    """
    text = TIPPER.replace("1 1, 1 (1) : 2", "-1 1, -1 (1) : 1").replace(
        "3 2, 3 (1) : 2", "-1 -2, 3 (1) : 2"
    )
    system, y = parse_fis(text), np.linspace(0.0, 30.0, 101)
    assert system.term_names == (
        ("poor", "good", "excellent", "not poor"),
        ("rancid", "delicious", "not delicious"),
    )
    assert system.inputs[0][3] == Complement(Gaussian(0, 1.5))
    np.testing.assert_array_equal(system.rules, [[3, 0], [1, -1], [3, -1], [-1, 2]])
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
    assert "-1 1, -3 (1) : 1" in written
    assert "NumMFs=3\nMF1='poor'" in written
    assert "MF3='cheap':'trimf',[0 5 10]" in written
    assert_comes_back(system)


def test_the_complement_of_a_type_2_term_exchanges_its_membership_functions() -> None:
    system = parse_fis(TYPE2.replace("1, 1 (1) : 1", "-1, 1 (1) : 1"))
    low, _, not_low = system.inputs[0]
    x = np.linspace(-1.0, 1.0, 41)
    np.testing.assert_array_equal(not_low.lower(x), 1.0 - low.upper(x))
    np.testing.assert_array_equal(not_low.upper(x), 1.0 - low.lower(x))
    assert_comes_back(system, rtol=1e-9)


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
    np.testing.assert_array_equal(parse_fis(text)(X), system(X))


def test_names_and_ranges_of_outputs_are_kept() -> None:
    system = parse_fis(TIPPER)
    assert system.consequent_names == (
        ("cheap",),
        ("cheap",),
        ("average",),
        ("generous",),
        ("generous",),
    )
    assert (system.input_ranges, system.output_ranges) == (
        ((0.0, 10.0), (0.0, 10.0)),
        ((0.0, 30.0),),
    )
    text = format_fis(system)
    for line in TIPPER[TIPPER.index("[Output1]") : TIPPER.index("[Rules]")].strip().split("\n"):
        assert line in text
    assert text.count("Range=[0 10]") == 2
    assert_comes_back(system)


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


def test_one_name_for_two_consequents_is_refused() -> None:
    system = Type1System([[G]], [[0], [0]], [[1.0], [2.0]], consequent_names=[["a"], ["a"]])
    with pytest.raises(NotExpressible, match="the name 'a' for two consequents of y1"):
        format_fis(system)


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
        (3, "Name='again'", "Name is there twice, first in line 2"),
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
        (18, "MF1='good':'gaussmf',[1.5 0]", None),
        (18, "MF1='':'gaussmf',[1.5 0]", "the name of the membership function is empty"),
        (18, "MF1='poor':'gaussmf',[1.5 0],[2],[0 0]", "in [0, 1]"),
        (30, "[Output2]", None),
        (30, "[Input2]", "the section [Input2] is there twice"),
        (33, "NumMFs=0", None),
        (34, "MF1='cheap':'trimf',[5 0 10]", "trimf: left, peak, right must be in ascending order"),
        (39, "1 1 1, 1 (1) : 2", "expected 2 numbers for the inputs, got 3"),
        (39, "1 3, 1 (1) : 2", "food has membership functions 1 to 2, got '3'"),
        (39, "1 -3, 1 (1) : 2", "food has membership functions 1 to 2, got '-3'"),
        (40, "-1 -2, 1 (1) : 2\n4 0, 1 (1) : 1", None),
        (18, "MF1='poor':'dsigmf',[1 2 1 2]", "dsigmf: center must be different for equal slopes"),
        (39, "1 1.5, 1 (1) : 2", "food has membership functions 1 to 2, got '1.5'"),
        (39, "1 1, 4 (1) : 2", "tip has membership functions 1 to 3, got '4'"),
        (39, "1 1, 1 : 2", "expected '<inputs>, <outputs> (<weight>) : <1 or 2>'"),
        (39, "1 1, 1 (1) : 3", "expected 1 (and) or 2 (or) at the end, got 3"),
        (39, "0 0, 1 (1) : 1", "the rule asks for nothing"),
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
        (TIPPER, "DefuzzMethod='centroid'", "DefuzzMethod='mom'", 12, "known is centroid"),
        (TIPPER, "AndMethod='min'", "AndMethod='mymin'", 8, "known are min, prod"),
        (TIPPER, "ImpMethod='min'", "ImpMethod='prod'", 10, "a system has one t-norm for both"),
        (TIPPER, "AggMethod='max'", "AggMethod='probor'", 39, "one rule for each alternative"),
        (TIPPER, "OrMethod='max'", "OrMethod='probor'", 39, "one rule for each alternative"),
        (TIPPER, "1 1, 1 (1) : 2", "1 1, 1 (0.5) : 2", 39, "rules have no weights"),
        (TYPE2, "1, 1 (1) : 1", "1, -1 (1) : 1", 30, "only sets have a complement"),
        (TIPPER, "1 1, 1 (1) : 2", "1 1, 0 (1) : 2", 39, "each rule gives every output a term"),
        (TIPPER, "'gaussmf',[1.5 0]", "'pimf',[1 5 4 8]", 18, "must not be left of the first one"),
        (TIPPER, "'gaussmf',[1.5 0]", "'mymf',[1.5 2]", 18, "known are trimf"),
        (
            OPEN_TYPE2,
            "'gaussmf',[0.4 1 1]",
            "'gauss2mf',[1 1.5 2 2 0.5]",
            22,
            "TwoSidedGaussian has none",
        ),
        (TYPE2, "'trimf',[-1 -0.5 0.5],[0.8]", "'gaussmf',[1 0],[0.8]", 19, "not documented"),
        (
            TYPE2,
            "'trimf',[-1 -0.5 0.5],[0.8],[0.1 0.2]",
            "'gbellmf',[1 2 0],[0.8],[0 0]",
            19,
            "Bell has none",
        ),
        (TYPE2, "'constant',[-1]", "'cubic',[-1]", 26, "known are constant and linear"),
        (TYPE2, "'linear',[2 1]", "'linear',[2 1 1 0]", 27, "not documented"),
        (TYPE2, "'karnikmendel'", "'mine'", 13, "known are karnikmendel"),
        (OPEN_TYPE2, "'Karnik-Mendel'", "'BMM(0.9,0.3)'", 13, "known are KM"),
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
            "[-1.6 -0.5 0.3 0.3]",
            "[-1.9 -0.5 0.3 0.3]",
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
        }
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


def assert_comes_back(system: Any, open_toolbox: bool = False, rtol: float = 0.0) -> None:
    text = format_fis(system, open_toolbox=open_toolbox)
    read = parse_fis(text)
    assert type(read) is type(system)
    assert read.input_names == system.input_names
    assert read.term_names == system.term_names
    np.testing.assert_array_equal(read.rules, system.rules)
    X = np.random.default_rng(1).uniform(-4.0, 4.0, size=(20, len(system.inputs)))
    np.testing.assert_allclose(read.type_reduced(X), system.type_reduced(X), rtol=rtol, atol=rtol)
    if not rtol:
        assert format_fis(read, open_toolbox=open_toolbox) == text


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


def test_shapes_of_another_name_are_written_as_trapezoids() -> None:
    system = Type1System([[Interval(0, 1), Singleton(2)]], [[0], [1]], [[1.0], [2.0]])
    read = parse_fis(format_fis(system))
    assert read.inputs[0] == (Trapezoidal(0, 0, 1, 1), Trapezoidal(2, 2, 2, 2))
    np.testing.assert_array_equal(read([[0.5], [2.0]]), [[1.0], [2.0]])


def test_sets_that_are_cut_off_at_the_ends_of_the_range_are_written_whole() -> None:
    wide = IntervalType2Set(
        Truncated(Triangular(-2, 0, 2, 0.5), -1, 3), Truncated(Triangular(-2, 0, 2), -1, 3)
    )
    system = IntervalType2System(
        [[G]], [[0], [0]], [wide, Triangular(1, 2, 3)], type_reduction="centroid", resolution=101
    )
    text = format_fis(system)
    assert "Range=[-1 3]" in text
    assert "'trimf',[-2 0 2],[0.5],[0 0]" in text
    assert_comes_back(system)


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
            "the t-norm 'hamacher' cannot be expressed in .fis: it has min and prod only",
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
        (Type1System([[G]], [[-1]], N), "a rule that asks for nothing"),
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
