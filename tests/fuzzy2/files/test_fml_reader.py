"""What is read from documents of IEEE 1855, and what is refused at which line."""

from __future__ import annotations

import contextlib
import math
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy2.errors import MalformedFile, NotExpressible
from fuzzy2.files.fis import parse_fis
from fuzzy2.files.fml import format_fml, parse_fml
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.smooth_shapes import PiShaped, TwoSidedGaussian
from fuzzy2.sets.type1 import SampledSet, Singleton
from fuzzy2.systems.antecedents import leaves
from tests.fuzzy2.files.fis_texts import TIPPER as TIPPER_FIS
from tests.fuzzy2.files.fml_texts import TIPPER, TIPPER_WITH_POLYNOMIAL, TSK


def test_the_tipper_is_that_of_matlab_but_for_the_grid() -> None:
    """The same system as in MATLAB's file, on another number of points.

    The reader of that is tested against published numbers.
    """
    system, other = parse_fml(TIPPER), parse_fis(TIPPER_FIS)
    assert (system.inputs, system.term_names) == (other.inputs, other.term_names)
    assert [set(leaves(tree)) for tree in system.rules] == [
        set(leaves(tree)) for tree in other.rules
    ]
    X = np.random.default_rng(0).uniform(0.0, 10.0, size=(50, 2))
    # Both are Riemann sums of piecewise linear functions on 30; 0.3 apart, their kinks cost about
    # 0.3² / 30.
    np.testing.assert_allclose(system(X), other(X), atol=0.01)
    on_its_grid = system.replace(resolution=other.resolution)
    np.testing.assert_allclose(
        on_its_grid([[2.0, 1.0], [7.0, 8.0]]), [[7.0169], [20.3414]], atol=5e-5
    )


def test_functions_of_takagi_sugeno_and_kang() -> None:
    """Constant first, then the slopes in the order of the variables.

    At (3, 3) both terms have the grade 1/2.
    """
    system = parse_fml(TSK)
    first, second = 0.25 * (1.0 + 2.0 * 3.0 + 3.0 * 3.0), 0.5 * 1.5
    np.testing.assert_allclose(system([3.0, 3.0]), [(first + second) / 0.75], rtol=1e-14)
    assert system.output_names == ("y",)


@pytest.mark.parametrize(
    ("shape", "expected"),
    [
        ('<triangularShape param1="0" param2="1" param3="2"/>', Triangular(0, 1, 2)),
        ('<trapezoidShape param1="0" param2="1" param3="2" param4="3"/>', Trapezoidal(0, 1, 2, 3)),
        ('<gaussianShape param1="1" param2="2"/>', Gaussian(mean=1, sigma=2)),
        ('<rectangularShape param1="1" param2="2"/>', Interval(1, 2)),
        ('<singletonShape param1="1"/>', Singleton(1)),
        ('<rightLinearShape param1="1" param2="2"/>', Trapezoidal(1, 2, math.inf, math.inf)),
        ('<leftLinearShape param1="1" param2="2"/>', Trapezoidal(-math.inf, -math.inf, 1, 2)),
        ('<leftGaussianShape param1="3" param2="2"/>', TwoSidedGaussian((3, 3), (math.inf, 2))),
        ('<rightGaussianShape param1="3" param2="2"/>', TwoSidedGaussian((3, 3), (2, math.inf))),
        ('<sShape param1="3" param2="5"/>', PiShaped(3, 5, math.inf, math.inf)),
        ('<zShape param1="3" param2="5"/>', PiShaped(-math.inf, -math.inf, 3, 5)),
        ('<piShape param1="3" param2="5"/>', PiShaped(3, 5, 5, 7)),
        (
            (
                '<pointSetShape><point x="2" y="0"/><point x="1" y="0"/><point x="1.5" '
                'y="1"/></pointSetShape>'
            ),
            SampledSet([1, 1.5, 2], [0, 1, 0]),
        ),
        (
            '<pointSetShape><point x="2" y="1"/><point x="4" y="0.5"/></pointSetShape>',
            SampledSet([0, 2, 4, 10], [1, 1, 0.5, 0.5]),
        ),
    ],
)
def test_every_shape(shape: str, expected: Any) -> None:
    system = parse_fml(TIPPER.replace('<gaussianShape param1="0.0" param2="1.5"/>', shape))
    assert system.inputs[0][0] == expected


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("MIN", "min"),
        ("PROD", "product"),
        ("BDIF", "lukasiewicz"),
        ("BSUM", "lukasiewicz"),
        ("DRP", "drastic"),
        ("DRS", "drastic"),
        ("EPROD", "einstein"),
        ("HPROD", "hamacher"),
        ("NILMIN", "nilpotent"),
    ],
)
def test_every_t_norm(name: str, expected: str) -> None:
    assert parse_fml(TSK.replace('andMethod="PROD"', f'andMethod="{name}"')).t_norm.name == expected


def line_of(text: str, part: str) -> int:
    return text[: text.index(part)].count("\n") + 1


@pytest.mark.parametrize(
    ("text", "old", "new", "said"),
    [
        (
            TIPPER,
            '<gaussianShape param1="0.0"',
            "<gaussianShape",
            "<gaussianShape> has no attribute 'param1'",
        ),
        (
            TIPPER,
            '<gaussianShape param1="0.0"',
            '<gaussianShape param="0.0"',
            "unknown attribute of <gaussianShape> 'param'; did you mean 'param1'?",
        ),
        (
            TIPPER,
            '<rule name="rule3" connector="OR" weight="1.0">',
            '<rule name="rule3" connector="OR" wieght="1.0">',
            "unknown attribute of <rule> 'wieght'; did you mean 'weight'?",
        ),
        (TIPPER, "<term>rancid", "<term>rancid<b/>", "<term> holds a text, not <b>"),
        (TIPPER, 'weight="1.0">', 'weight="1.0">0.5', "<rule> holds no text, and has '0.5'"),
        (TIPPER, 'param2="1.5"', 'param2="1_5"', "expected a finite number, got '1_5'"),
        (TIPPER, 'param2="1.5"', 'param2="１.5"', "expected a finite number, got '１.5'"),
        (
            TIPPER,
            '<gaussianShape param1="0.0"',
            '<gaussianShape param1="zero"',
            "expected a finite number, got 'zero'",
        ),
        (
            TIPPER,
            '<gaussianShape param1="0.0"',
            '<gaussianShape param1="INF"',
            "expected a finite number, got 'INF'",
        ),
        (
            TIPPER,
            'param1="0.0" param2="1.5"',
            'param1="0.0" param2="-0.0"',
            "gaussianShape: sigma must be a finite number above 0",
        ),
        (
            TIPPER,
            '<gaussianShape param1="0.0"',
            '<gausianShape param1="0.0"',
            "expected <triangularShape> or",
        ),
        (
            TIPPER,
            '<fuzzyTerm name="good" complement="false">',
            '<fuzzyTerm name="poor">',
            "the name 'poor' is given to two terms",
        ),
        (
            TIPPER,
            '<fuzzyVariable name="food"',
            '<fuzzyVariable name="service"',
            "the name 'service' is given to two variables",
        ),
        (TIPPER, '<fuzzyVariable name="food"', "<fuzzyVariable", "has no attribute 'name'"),
        (
            TIPPER,
            'domainright="30.0"',
            'domainright="-30.0"',
            "expected domainleft below domainright",
        ),
        (
            TIPPER,
            'complement="false"',
            'complement="maybe"',
            "expected complement true or false, got 'maybe'",
        ),
        (
            TIPPER,
            '<gaussianShape param1="0.0" param2="1.5"/>',
            '<piShape param1="2" param2="1"/>',
            "must be in ascending order",
        ),
        (TIPPER, 'type="output"', 'type="throughput"', "expected the type input or output"),
        (
            TIPPER,
            "<variable>food</variable><term>r",
            "<variable>fod</variable><term>r",
            "unknown input 'fod'; did you mean 'food'?",
        ),
        (
            TIPPER,
            "<term>rancid",
            "<term>randic",
            "unknown term of 'food' 'randic'; did you mean 'rancid'?",
        ),
        (
            TIPPER,
            "<variable>food</variable><term>rancid",
            "<term>rancid",
            "expected one <variable> and one <term>",
        ),
        (
            TIPPER,
            'connector="OR"',
            'connector="xor"',
            "expected the connector and or or, got 'xor'",
        ),
        (
            TIPPER,
            '"MIN" orMethod="MAX">',
            '"MIN" orMethod="MAX"><comment/>',
            "expected <rule> in <mamdaniRuleBase>, got <comment>",
        ),
        (
            TSK,
            'order="0"',
            'order="1"',
            "expected one value of order 0, or several of order 1, got 1 of order '1'",
        ),
        (TSK, "<tskValue>1.5", "<tskValue>x", "expected a finite number, got 'x'"),
    ],
)
def test_a_malformed_document_names_the_line(text: str, old: str, new: str, said: str) -> None:
    with pytest.raises(MalformedFile) as caught:
        parse_fml(text.replace(old, new, 1), "a.fml")
    assert (caught.value.source, caught.value.place) == ("a.fml", f"line {line_of(text, old)}")
    assert said in caught.value.reason


@pytest.mark.parametrize(
    ("text", "place", "said"),
    [
        ("", "line 1, column 1", "no element found"),
        ("<a>\n<b></a>", "line 2, column 6", "mismatched tag"),
        ("<a/>", "line 1", "expected <fuzzySystem>, got <a>"),
        (
            '<fuzzySystem xmlns="http://example.org"/>',
            "line 1",
            "expected elements of http://www.ieee1855.org, got one of http://example.org",
        ),
        ("<fuzzySystem/>", "line 1", "expected one <knowledgeBase>, got 0"),
        ("<fuzzySystem><knowledgeBase/></fuzzySystem>", "line 1", "there is no rule base"),
        (
            "<fuzzySystem><knowledgeBase/><mamdaniRuleBase/></fuzzySystem>",
            "line 1",
            "at least one input and one output",
        ),
        (
            TSK.replace("<tskValue>3.0</tskValue>", ""),
            "line 9",
            "a slope for each of the 2 inputs, got 2 values",
        ),
        (
            TSK.replace("tskVariable", "thing"),
            "line 9",
            "expected <fuzzyVariable> or <tskVariable>, got <thing>",
        ),
        (
            TSK.replace('domainleft="0"', 'type="output" domainleft="0"', 1),
            "line 3",
            "an output of a TSK rule base is a <tskVariable>",
        ),
        (
            TIPPER.replace("mamdaniRuleBase", "tskRuleBase"),
            "line 13",
            "an output of a TSK rule base is a <tskVariable>",
        ),
        (
            TSK.replace("tskRuleBase", "mamdaniRuleBase"),
            "line 9",
            "a Mamdani rule base has no <tskVariable>",
        ),
        (
            TIPPER[: TIPPER.index("    <rule ")] + "</mamdaniRuleBase></fuzzySystem>",
            "line 19",
            "there are no rules",
        ),
        (
            '<!DOCTYPE a [<!ENTITY b "bbb">]>\n' + TSK,
            "line 1",
            "a document type declaration is not allowed",
        ),
        (
            '<?xml version="1.0"?>\n<!DOCTYPE a SYSTEM "file:///etc/passwd">\n<a/>',
            "line 2",
            "a document type declaration is not allowed",
        ),
        ("<a>&b;</a>", "line 1, column 4", "undefined entity"),
    ],
)
def test_documents_that_are_none(text: str, place: str, said: str) -> None:
    with pytest.raises(MalformedFile) as caught:
        parse_fml(text)
    assert said in caught.value.reason
    assert caught.value.place == place


@pytest.mark.parametrize(
    ("text", "old", "new", "said"),
    [
        (TIPPER, 'defuzzifier="COG"', 'defuzzifier="custom_x"', "known are COG, COA, MOM"),
        (TIPPER, 'andMethod="MIN"', 'andMethod="custom_and"', "known are MIN, PROD"),
        (TIPPER, 'accumulation="MAX"', 'accumulation="custom_sum"', "known are MAX, PROBOR"),
        (
            TIPPER,
            '<rule name="rule1" orMethod="MAX"',
            '<rule name="rule1" orMethod="custom_or"',
            "known are MAX, PROBOR",
        ),
        (
            TIPPER,
            "<clause><variable>food",
            '<clause modifier="above"><variable>food',
            "the modifier 'above'",
        ),
        (
            TSK,
            "<tskClause><variable>y</variable><term>fixed",
            '<tskClause modifier="not"><variable>y</variable><term>fixed',
            "have a compl",
        ),
        (
            TIPPER,
            "<then><clause><variable>tip</variable><term>cheap</term></clause>",
            "<then><clause><variable>tip</variable><term>cheap</term></clause>"
            "<clause><variable>tip</variable><term>cheap</term></clause>",
            "two clauses",
        ),
        (
            TIPPER,
            '<gaussianShape param1="0.0" param2="1.5"/>',
            '<customShape param1="0"/>',
            "no class here has its shape",
        ),
        (
            TIPPER,
            '<gaussianShape param1="0.0" param2="1.5"/>',
            '<pointSetShape interpolationMethod="spline"/>',
            "interpolated linearly",
        ),
        (
            TIPPER,
            "    <fuzzyVariable",
            "<anYaDataCloud/>\n    <fuzzyVariable",
            "only an <anYaRuleBase> uses clouds",
        ),
        (TSK, 'combination="WA"', 'combination="custom_x"', "the weighted average"),
    ],
)
def test_what_a_system_cannot_be_is_refused_with_its_line(
    text: str, old: str, new: str, said: str
) -> None:
    assert old in text
    with pytest.raises(NotExpressible, match="cannot be expressed in fuzzy2") as caught:
        parse_fml(text.replace(old, new, 1), "a.fml")
    assert caught.value.what.startswith(f"a.fml, line {line_of(text, old)}: ")
    assert said in str(caught.value)


def test_two_rule_bases_and_two_accumulations_are_refused() -> None:
    rule_base = TIPPER[TIPPER.index("  <mamdaniRuleBase") : TIPPER.index("</fuzzySystem>")]
    with pytest.raises(NotExpressible, match="a second rule base"):
        parse_fml(TIPPER.replace("</fuzzySystem>", rule_base + "</fuzzySystem>"))
    start, end = TIPPER.index('    <fuzzyVariable name="tip"'), TIPPER.index("  </knowledgeBase>")
    other = TIPPER[start:end].replace('"tip"', '"other"').replace('"MAX"', '"PROBOR"')
    with pytest.raises(NotExpressible, match="another accumulation"):
        parse_fml(TIPPER[:end] + other + TIPPER[end:])
    silent = parse_fml(TIPPER[:end] + other.replace("PROBOR", "MAX") + TIPPER[end:])
    # No rule speaks of the other one, so it keeps its defaultValue.
    assert silent([5.0, 5.0])[1] == 0.0
    rule = TIPPER[TIPPER.index('    <rule name="rule3"') : TIPPER.index("  </mamdaniRuleBase>")]
    with pytest.raises(NotExpressible, match="another orMethod"):
        parse_fml(TIPPER.replace(rule, rule.replace('"rule3"', '"rule3" orMethod="PROBOR"')))


@pytest.mark.parametrize("declared", ["iso-8859-1", "utf-16", "utf-7", "idna", "rot13", "U0TF-8"])
def test_text_is_what_it_is_whatever_encoding_it_declares(declared: str) -> None:
    """It was decoded before: names beyond ASCII stay, and an unknown encoding hinders nobody."""
    text = TIPPER.replace("service", "qualité")
    system = parse_fml(re.sub(r'encoding="[^"]*"', f'encoding="{declared}"', text))
    assert "qualité" in system.input_names
    assert system.input_names == parse_fml(text).input_names


@given(st.sampled_from([TIPPER, TSK]), st.data())
@settings(max_examples=300, deadline=None)
def test_damaged_documents_raise_nothing_else(text: str, data: st.DataObject) -> None:
    start = data.draw(st.integers(0, len(text)))
    end = data.draw(st.integers(start, min(len(text), start + 8)))
    damaged = text[:start] + data.draw(st.text("0123456789-.<>/\"' =\nax", max_size=4)) + text[end:]
    # An error of any other class fails the test.
    with contextlib.suppress(MalformedFile, NotExpressible):
        parse_fml(damaged)


def test_what_rules_say_besides_clauses() -> None:
    """Weights, hedges, *else*, silence: against the firing that they mean, written out."""
    text = TIPPER.replace('connector="or" weight="1.0"', 'connector="or" weight="0.25"')
    text = text.replace(
        "<clause><variable>food</variable><term>rancid",
        '<clause modifier="very"><variable>food</variable><term>rancid',
    )
    start = text.index("</consequent>", text.index('"rule2"'))
    branch = "<else><clause><variable>tip</variable><term>cheap</term></clause></else>"
    system = parse_fml(text[:start] + branch + text[start:])
    x = np.random.default_rng(0).uniform(0.0, 10.0, size=(30, 2))
    poor, good, excellent = (np.exp(-0.5 * ((x[:, 0] - m) / 1.5) ** 2) for m in (0.0, 5.0, 10.0))
    rancid = np.clip((3.0 - x[:, 1]) / 2.0, 0.0, 1.0)
    delicious = np.clip((x[:, 1] - 7.0) / 2.0, 0.0, 1.0)
    fired = np.stack(
        [
            0.25 * np.maximum(rancid**2, poor),
            good,
            1.0 - good,
            np.maximum(excellent, delicious),
        ],
        axis=1,
    )
    np.testing.assert_allclose(system.firing(x)[..., 1], fired, rtol=1e-12, atol=1e-15)


def test_terms_made_of_others() -> None:
    circular = (
        '<fuzzyTerm name="fair"><circularDefinition><or t-conorm="MAX"><termName>good</termName>'
        "<and><termName>poor</termName><termName>excellent</termName></and></or>"
        '</circularDefinition></fuzzyTerm><fuzzyTerm name="excellent" complement="false">'
    )
    aggregated = (
        '<aggregatedFuzzyVariable name="quality"><aggregatedFuzzyTerm name="bad"><and><clause>'
        "<variable>food</variable><term>rancid</term></clause><clause modifier='not'>"
        "<variable>service</variable><term>fair</term></clause></and></aggregatedFuzzyTerm>"
        "</aggregatedFuzzyVariable></knowledgeBase>"
    )
    text = TIPPER.replace('<fuzzyTerm name="excellent" complement="false">', circular)
    text = text.replace("</knowledgeBase>", aggregated).replace(
        "<variable>service</variable><term> good </term>",
        "<variable>quality</variable><term>bad</term>",
    )
    system = parse_fml(text)
    x = np.random.default_rng(0).uniform(0.0, 10.0, size=(30, 2))
    poor, good, excellent = (np.exp(-0.5 * ((x[:, 0] - m) / 1.5) ** 2) for m in (0.0, 5.0, 10.0))
    fair = np.maximum(good, np.minimum(poor, excellent))
    rancid = np.clip((3.0 - x[:, 1]) / 2.0, 0.0, 1.0)
    expected = np.minimum(rancid, 1.0 - fair)
    np.testing.assert_allclose(system.firing(x)[:, 1, 1], expected, rtol=1e-12)
    with pytest.raises(MalformedFile, match="is defined by itself"):
        parse_fml(text.replace("<termName>good</termName>", "<termName>fair</termName>"))


def test_points_of_a_polynomial() -> None:
    """A parabola through three points, cut off where it leaves the grades."""
    shape = (
        '<pointSetShape interpolationMethod="lagrange"><point x="1" y="0"/><point x="3" y="1"/>'
        '<point x="5" y="0"/></pointSetShape>'
    )
    system = parse_fml(TIPPER.replace('<gaussianShape param1="0.0" param2="1.5"/>', shape))
    x = np.linspace(0.0, 10.0, 51)
    expected = np.clip(1.0 - ((x - 3.0) / 2.0) ** 2, 0.0, 1.0)
    np.testing.assert_allclose(system.inputs[0][0](x), expected, atol=1e-12)


def test_jfml_forgets_the_polynomial_and_counts_parameters_again() -> None:
    """What JFML 1.3 answers to its TipperMamdani2, and why it is not the same here.

    JFML makes the shape anew when it has read a document, without the method of interpolation, so
    that points are always joined by lines; and it sums, in single precision, over 2000 points and
    once more over the parameters of the output's shapes. Done so with the sets and the firing
    here, its numbers come out.
    """
    inputs = np.float32(
        [
            [4.065103530883789, 9.099589347839355],
            [0.7863003611564636, 6.526145935058594],
            [4.045518398284912, 1.9851304292678833],
            [7.2965545654296875, 1.7565561532974243],
            [8.8993558883667, 8.223738670349121],
        ]
    ).astype(float)
    of_jfml = [11.04887, 9.49553, 8.047848, 9.977379, 12.526456]
    lines = parse_fml(TIPPER_WITH_POLYNOMIAL.replace("lagrange", "linear"))
    x, points = np.float32(0.0), set(np.float32([0, 1, 2, 3, 4, 5, 10, 15, 20]))
    while x < 20.0:
        points.add(x)
        x += np.float32(20.0) / np.float32(2000.0)
    x = np.array(sorted(points))
    cheap, average, generous = (meaning for (meaning,) in lines.consequent_sets)
    for row, answer in zip(inputs, of_jfml, strict=True):
        united = np.zeros_like(x)
        for meaning, fired in zip((cheap, average, generous), lines.firing(row), strict=True):
            united = np.maximum(united, np.minimum(meaning(x), fired[1])).astype(np.float32)
        moment, area = np.cumsum(x * united)[-1], np.cumsum(united)[-1]
        assert moment.dtype == np.float32
        np.testing.assert_allclose(moment / area, answer, rtol=2e-6)
    # Where the polynomial fires, it is what costs the most; the last input does not ask for it.
    system = parse_fml(TIPPER_WITH_POLYNOMIAL)
    away = np.abs(system(inputs)[:, 0] - of_jfml)
    assert (away[:-1] > 0.03).all()
    assert away[-1] < 1e-4
    fine = np.linspace(0.0, 20.0, system.resolution)
    lagrange = np.polynomial.Polynomial.fit([0, 1, 2, 3, 4], [1.0, 1.0, 0.6, 0.4, 0.0], 4)
    grades = [np.clip(lagrange(fine), 0.0, 1.0), average(fine), generous(fine)]
    for row, answer in zip(inputs, system(inputs)[:, 0], strict=True):
        clipped = [np.minimum(g, f[1]) for g, f in zip(grades, system.firing(row), strict=True)]
        united = np.max(clipped, axis=0)
        np.testing.assert_allclose(united @ fine / united.sum(), answer, rtol=1e-9)


def test_tsukamoto_and_the_maxima() -> None:
    """Where a shoulder has the grade of the firing; and the middle of the highest points."""
    text = TIPPER.replace("mamdaniRuleBase", "tsukamotoRuleBase")
    start, end = text.index('<fuzzyVariable name="tip"'), text.index("  </knowledgeBase>")
    output = (
        '<tsukamotoVariable name="tip" domainleft="0" domainright="30" type="output">'
        '<tsukamotoTerm name="cheap"><leftLinearShape param1="0" param2="10"/></tsukamotoTerm>'
        '<tsukamotoTerm name="average"><rightLinearShape param1="5" param2="15"/></tsukamotoTerm>'
        '<tsukamotoTerm name="generous"><rightLinearShape param1="20" param2="30"/></tsukamotoTerm>'
        "</tsukamotoVariable>"
    )
    system = parse_fml(text[:start] + output + text[end:])
    x = np.array([[3.0, 2.0]])
    fired = system.firing(x)[0, :, 1]
    points = np.array([10.0 * (1.0 - fired[0]), 5.0 + 10.0 * fired[1], 20.0 + 10.0 * fired[2]])
    np.testing.assert_allclose(system(x), [[fired @ points / fired.sum()]], rtol=1e-12)
    middle = parse_fml(TIPPER.replace('defuzzifier="COG"', 'defuzzifier="mom"'))
    np.testing.assert_allclose(middle([5.0, 5.0]), [15.0], atol=1e-6)


def test_tsukamotos_points_may_lie_beyond_the_domain() -> None:
    """As in JFML: a Gaussian has the grade w at m - sigma sqrt(-2 ln w), wherever that is."""
    text = TIPPER.replace("mamdaniRuleBase", "tsukamotoRuleBase")
    start, end = text.index('<fuzzyVariable name="tip"'), text.index("  </knowledgeBase>")
    terms = "".join(
        f'<tsukamotoTerm name="{name}"><rightGaussianShape param1="{mean}" param2="10"/>'
        "</tsukamotoTerm>"
        for name, mean in (("cheap", 5), ("average", 15), ("generous", 25))
    )
    output = (
        '<tsukamotoVariable name="tip" domainleft="0" domainright="30" type="output">'
        f"{terms}</tsukamotoVariable>"
    )
    system = parse_fml(text[:start] + output + text[end:])
    x = np.array([[3.0, 2.5]])
    fired = system.firing(x)[0, :, 1]
    points = np.array([5.0, 15.0, 25.0]) - 10.0 * np.sqrt(-2.0 * np.log(fired))
    assert points.min() < 0.0
    np.testing.assert_allclose(system(x), [[fired @ points / fired.sum()]], rtol=1e-9)
    np.testing.assert_allclose(parse_fml(format_fml(system))(x), system(x), rtol=1e-9)


@pytest.mark.parametrize(("given", "expected"), [("", 0.0), (' defaultValue="NaN"', math.nan)])
def test_a_default_that_is_not_given_is_that_of_the_schema(given: str, expected: float) -> None:
    system = parse_fml(TIPPER.replace(' defaultValue="0.0"', given))
    default = system.default_outputs
    assert default is None if math.isnan(expected) else float(default[0]) == expected
