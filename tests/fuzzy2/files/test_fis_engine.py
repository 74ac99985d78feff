"""FIS in fuzzylite's meaning: read against brute force, and written."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import fuzzy2
from fuzzy2 import ParallelSystem, Type1System
from fuzzy2.errors import MalformedFile, NotExpressible
from fuzzy2.files.fis import format_fis, parse_fis
from fuzzy2.files.fis_engine import is_of_fuzzylite
from fuzzy2.files.fll import format_fll, parse_fll
from tests.fuzzy2.files.engines import CHAIN, FORMULAS, HYBRID, TSUKAMOTO, inputs_of
from tests.fuzzy2.files.fis_texts import TIPPER

MIXED = """\
#Code automatically generated with fuzzylite 6.0.
[System]
Name='mixed'
Type='hybrid'
Version=6.0
NumInputs=2
NumOutputs=3
NumRules=5
AndMethod='prod'
OrMethod='probor'
ImpMethod='min'
AggMethod='max'
DefuzzMethod='centroid'

[Input1]
Name='heat'
Range=[0.000 10.000]
NumMFs=3
MF1='cold':'concavemf',[5.000 2.000]   # falls
MF2='mild':'cosinemf',[5.000 6.000]
MF3='hot':'spikemf',[9.000 4.000]

[Input2]
Name='wind'
Range=[0.000 10.000]
NumMFs=2
MF1='calm':'dsigmf',[4.000 1.000 3.000 5.000]
MF2='windy':'gauss2mf',[1.000 6.000 2.000 8.000]

[Output1]
Name='power'
Range=[0.000 1.000]
NumMFs=2
MF1='low':'trimf',[0.000 0.250 0.500]
MF2='high':'binarymf,[0.600 1.000]

[Output2]
Name='price'
Range=[-20.000 30.000]
NumMFs=2
MF1='rising':'linear',[2.000 -1.000 1.000]
MF2='fixed':'constant',[7.000]

[Output3]
Name='idle'
Range=[0.000 1.000]
NumMFs=1
MF1='none':'constant',[0.000]

[Rules]
# RuleBlock mamdani
1.000 -2.200 , 2.000 0.000 0.000 (1.000) : 1
3.010 1.000 , -1.300 1.000 0.000 (1.000) : 2
# RuleBlock takagiSugeno
2.050 0.000 , 0.000 2.000 0.000 (0.500) : 1
0.990 1.000 , 0.000 2.000 0.000 (1.000) : 1
0.000 0.000 , 0.000 0.000 1.000 (1.000) : 1
"""


def mixed_by_hand(heat: float, wind: float, pieces: int) -> list[float]:
    """Return the outputs of the system above, integrated over so many pieces."""
    cold = 1.0 if heat <= 2.0 else 3.0 / (3.0 + heat - 2.0)
    mild = 0.5 * (1.0 + math.cos(2.0 * math.pi / 6.0 * (heat - 5.0))) if 2.0 < heat < 8.0 else 0.0
    hot = math.exp(-abs(10.0 / 4.0 * (heat - 9.0)))
    calm = abs(
        1.0 / (1.0 + math.exp(-4.0 * (wind - 1.0))) - 1.0 / (1.0 + math.exp(-3.0 * (wind - 5.0)))
    )
    windy = math.exp(-((wind - 6.0) ** 2) / 2.0) if wind < 6.0 else 1.0
    windy *= math.exp(-((wind - 8.0) ** 2) / 8.0) if wind > 8.0 else 1.0
    seldom = math.sqrt(hot / 2.0) if hot <= 0.5 else 1.0 - math.sqrt((1.0 - hot) / 2.0)
    first, second = cold * (1.0 - windy**2), seldom + calm - seldom * calm
    extreme = 2.0 * second**2 if second <= 0.5 else 1.0 - 2.0 * (1.0 - second) ** 2
    not_extreme = 1.0 - extreme
    grid = (np.arange(pieces) + 0.5) / pieces
    low = np.maximum(0.0, 1.0 - np.abs(grid - 0.25) / 0.25)
    high = np.where(grid >= 0.6, 1.0, 0.0)
    united = np.maximum(np.minimum(first, high), np.minimum(not_extreme, low))
    # The hedge of the first conclusion goes on to the second one.
    fired = [not_extreme, 0.5 * math.sqrt(mild), calm]
    said = [2.0 * heat - wind + 1.0, 7.0, 7.0]
    price = float(np.dot(fired, said) / sum(fired))
    return [float((grid * united).sum() / united.sum()), price, math.nan]


NOT_SAID = MIXED.replace("fuzzylite 6.0", "something").replace("Version=6.0\n", "")


@pytest.mark.parametrize(
    ("text", "pieces"),
    [
        (MIXED, 100),
        (MIXED.replace("fuzzylite 6.0", "fuzzylite 7.0"), 1000),
        (NOT_SAID, 100),
        (NOT_SAID.replace("NumRules", "Version=7.0\nNumRules"), 1000),
        (NOT_SAID.replace("NumRules", "Version=2.0\nNumRules"), 100),
        (NOT_SAID.replace("Name='heat'", "Name='heat'\nEnabled=1"), 200),
    ],
    ids=["6", "7", "silent", "version", "matlab", "5"],
)
def test_a_hybrid_system_with_fuzzylites_terms_against_brute_force(
    tmp_path: Path, text: str, pieces: int
) -> None:
    """Pieces of the integral are those of the version that wrote the file."""
    (tmp_path / "mixed.fis").write_text(text, encoding="utf-8")
    system = fuzzy2.load(tmp_path / "mixed.fis")
    assert isinstance(system, ParallelSystem)
    X = inputs_of(system)
    expected = [mixed_by_hand(heat, wind, pieces) for heat, wind in X.tolist()]
    np.testing.assert_allclose(system(X), expected, rtol=1e-12)


def test_what_says_that_a_file_is_of_fuzzylite() -> None:
    assert not is_of_fuzzylite(TIPPER)
    assert is_of_fuzzylite("# Written by fuzzylite 6\n" + TIPPER)
    assert is_of_fuzzylite(TIPPER.replace("Type='mamdani'", "Type='hybrid'"))
    assert is_of_fuzzylite(TIPPER.replace("'gaussmf'", "'spikemf'", 1))
    assert is_of_fuzzylite(TIPPER.replace("[Input1]\n", "[Input1]\nEnabled=1\n"))


def test_a_file_of_matlab_means_another_sum_in_fuzzylite() -> None:
    """MATLAB adds up 101 points with both ends, fuzzylite 6 the middles of 100 pieces."""
    matlab, own = parse_fis(TIPPER), parse_fis(TIPPER, dialect="fuzzylite")
    assert (matlab.integration, matlab.resolution) == ("sum", 101)
    assert (own.integration, own.resolution) == ("midpoint", 100)
    np.testing.assert_allclose(own([4.0, 7.0]), matlab([4.0, 7.0]), atol=0.05)


FALLING = """\
[System]
Name='falling'
Type='tsukamoto'
NumInputs=1
NumOutputs=1
NumRules=2
AndMethod=''
DefuzzMethod='wtaver'
[Input1]
Name='x'
Range=[-5 5]
NumMFs=2
MF1='low':'sigmf',[-1 0]
MF2='high':'sigmf',[2 1]
[Output1]
Name='y'
Range=[0 1]
Default=nan
LockPrevious=1
LockRange=0
NumMFs=2
MF1='b':'rampmf',[0.6 0.4]
MF2='a':'concavemf',[0.9 1]
[Rules]
1.000, 1.000 (1.000) : 1
2.000, 2.000 (1.000) : 1
"""


def test_tsukamotos_terms_are_asked_for_the_point_of_a_grade() -> None:
    system = parse_fis(FALLING)
    for x in np.linspace(-4.5, 4.5, 31):
        first, second = 1.0 / (1.0 + math.exp(x)), 1.0 / (1.0 + math.exp(-2.0 * (x - 1.0)))
        at = [0.6 - 0.2 * first, (0.9 - 1.0) / second + 2.0 - 0.9]
        expected = (first * at[0] + second * at[1]) / (first + second)
        np.testing.assert_allclose(system([x]), [expected], rtol=1e-9)


ASKING = """\
[System]
Name='asking'
Type='sugeno'
NumInputs=1
NumOutputs=2
NumRules=3
DefuzzMethod='wtsum'
[Input1]
Name='x'
Range=[0 2]
NumMFs=2
MF1='low':'trimf',[-2 0 2]
MF1='high':'trimf',[0 2 4]
[Output1]
Name='wave'
Range=[-1 1]
NumMFs=2
MF1='w':'function',[sin ( x ) /2]
MF2='w':'constant',[0.25]
[Output2]
Name='off'
Range=[-1 1]
NumMFs=1
MF1='d':'function',[fabs ( wave-x )]
[Rules]
1, 1 0 (1) : 1
2, 2 0 (1) : 1
0.99, 0 1 (1) : 1
"""


def test_formulas_and_numbers_that_are_given_twice() -> None:
    system = parse_fis(ASKING)
    for x in np.linspace(0.1, 1.9, 11):
        wave = (1.0 - x / 2.0) * math.sin(x) / 2.0 + x / 2.0 * 0.25
        np.testing.assert_allclose(system([x]), [wave, abs(wave - x)], rtol=1e-13)


@pytest.mark.parametrize(
    ("old", "new", "line", "said"),
    [
        ("Type='hybrid'", "Type='unknown'", 4, "known are mamdani"),
        ("'cosinemf'", "'mymf'", 20, "known are binarymf"),
        ("DefuzzMethod='centroid'", "DefuzzMethod='mine'", 13, "known: wtaver"),
        ("AggMethod='max'", "AggMethod='mine'", 12, "known are max"),
        ("1.000 0.000 (1.000) : 2", "1.000 0.000 (0.500) : 2", 53, "use 1"),
        ("Name='heat'", "Name='heat'\nEnabled=0", 17, "leave it out"),
        ("MF2='fixed':'constant',[7.000]", "MF2='fixed':'trimf',[0 1 2]", 38, "wtaver"),
        ("Name='idle'", "Name='idle'\nDefault=0\nLockPrevious=1", 47, "does not remember"),
        ("'trimf',[0.000 0.250 0.500]", "'function',[3*x]", 34, "grades lie in it"),
    ],
)
def test_what_a_system_cannot_be_is_refused(old: str, new: str, line: int, said: str) -> None:
    assert old in MIXED
    with pytest.raises(NotExpressible) as caught:
        parse_fis(MIXED.replace(old, new, 1), "a.fis")
    assert said in caught.value.reason
    assert caught.value.what.startswith(f"a.fis, line {line}: ")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("[5.000 2.000]", "[5.000]", "2 numbers"),
        ("[5.000 2.000]", "[5.000 two]", "expected a number"),
        ("Range=[0.000 10.000]", "Range=[10 0]", "Range=[low high]"),
        ("1.000 -2.200 ,", "1.000 -3.200 ,", "membership functions 1 to 2"),
        ("1.000 -2.200 ,", "1.000 -2.210 ,", "membership functions 1 to 2"),
        ("1.000 -2.200 ,", "1.000 ,", "expected 2 numbers"),
        ("1.000 -2.200 ,", "0.200 2.000 ,", "a hedge of no term"),
        ("1.000 -2.200 ,", "1.000 Inf ,", "membership functions 1 to 2, got inf"),
        ("1.000 -2.200 ,", "1.000000001 -2.200 ,", "1 to 3, got 1.000000001"),
        ("(0.500)", "(1.500)", "a weight from 0 to 1"),
        ("'concavemf',", "concavemf,", "expected '<name>'"),
        ("[Input2]", "[Input3]", "no section [Input2]"),
    ],
)
def test_what_is_wrong_is_said(old: str, new: str, said: str) -> None:
    assert old in MIXED
    with pytest.raises(MalformedFile) as caught:
        parse_fis(MIXED.replace(old, new, 1))
    assert said in caught.value.reason


@pytest.mark.parametrize(
    ("text", "read"),
    [(MIXED, parse_fis), (FALLING, parse_fis), (ASKING, parse_fis), (TSUKAMOTO, parse_fll)],
    ids=["mixed", "falling", "asking", "tsukamoto"],
)
def test_round_trips_through_fis_and_fll(text: str, read: object) -> None:
    assert callable(read)
    system = read(text)
    X = inputs_of(system)
    expected = system(X)
    written = format_fis(system, "again", dialect="fuzzylite")
    for again in (
        parse_fis(written),
        parse_fll(format_fll(system)),
        parse_fis(format_fis(parse_fll(format_fll(system)), dialect="fuzzylite")),
    ):
        assert type(again) is type(system)
        np.testing.assert_allclose(again(X), expected, rtol=1e-12, atol=1e-12)
    assert format_fis(parse_fis(written), "again", dialect="fuzzylite") == written


def test_what_a_file_has_one_word_for_is_refused() -> None:
    with pytest.raises(NotExpressible, match="an input twice"):
        format_fis(parse_fll(CHAIN), dialect="fuzzylite")
    with pytest.raises(NotExpressible, match='"very not" before a term'):
        format_fis(parse_fll(HYBRID), dialect="fuzzylite")
    turned = HYBRID.replace("very not", "not very")
    with pytest.raises(NotExpressible, match=r"resolution=100\).*200 in version 5, 100 in"):
        format_fis(parse_fll(turned.replace("200", "300")), dialect="fuzzylite")
    twice = CHAIN.replace("if first is somewhat low", "if light is bright").replace("200", "100", 1)
    with pytest.raises(NotExpressible, match="outputs integrated over 100 and 200 points"):
        format_fis(parse_fll(twice), dialect="fuzzylite")
    with pytest.raises(NotExpressible, match="a file has one word"):
        format_fis(parse_fll(FORMULAS), dialect="fuzzylite")


@pytest.mark.parametrize(("pieces", "version"), [(200, 5), (100, 6), (1000, 7)])
def test_the_version_that_is_written_says_the_points(pieces: int, version: int) -> None:
    text = HYBRID.replace("very not", "not very").replace("Centroid 200", f"Centroid {pieces}")
    hybrid = parse_fll(text)
    written = format_fis(hybrid, dialect="fuzzylite")
    assert f"Version={version}.0\n" in written
    X = inputs_of(hybrid)
    np.testing.assert_allclose(parse_fis(written)(X), hybrid(X), rtol=1e-12)


def test_a_hybrid_system_is_saved_in_every_format_that_has_it(tmp_path: Path) -> None:
    system = parse_fll(HYBRID)
    X = inputs_of(system)
    for name in ("a.fll", "a.json"):
        fuzzy2.save(system, tmp_path / name)
        np.testing.assert_allclose(fuzzy2.load(tmp_path / name)(X), system(X), rtol=1e-9)
    with pytest.raises(NotExpressible, match="ParallelSystem"):
        fuzzy2.save(system, tmp_path / "a.fis")


def test_a_type_2_system_is_refused() -> None:
    one = fuzzy2.IntervalType2System(
        [[fuzzy2.GaussianUncertainSigma(0.0, (1.0, 2.0))]], [[0]], [[1.0]]
    )
    with pytest.raises(NotExpressible, match="only type-1 systems"):
        format_fis(one, dialect="fuzzylite")
    assert isinstance(parse_fis(FALLING), Type1System)
