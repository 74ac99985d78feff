"""IEEE 1855: documents in the layout of the standard.

Round trips, and what is refused at which line.
"""

from __future__ import annotations

import contextlib
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy2.errors import MalformedFile, NotExpressible
from fuzzy2.files.fis import parse_fis
from fuzzy2.files.fml import format_fml, parse_fml, read_fml, write_fml
from fuzzy2.sets.derived import Complement
from fuzzy2.sets.interval_type2 import GaussianUncertainMean
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.smooth_shapes import Bell, PiShaped, TwoSidedGaussian
from fuzzy2.sets.type1 import SampledSet, Singleton
from fuzzy2.systems import IntervalType2System, Linear, Type1System
from tests.fuzzy2.files.test_fis import TIPPER as TIPPER_FIS

TIPPER = """\
<?xml version="1.0" encoding="UTF-8"?>
<fuzzySystem xmlns="http://www.ieee1855.org" name="tipper">
  <knowledgeBase>
    <fuzzyVariable name="service" scale="" domainleft="0.0" domainright="10.0" type="input">
      <fuzzyTerm name="poor" complement="false"><gaussianShape param1="0.0" param2="1.5"/>\
</fuzzyTerm>
      <fuzzyTerm name="good" complement="false"><gaussianShape param1="5.0" param2="1.5"/>\
</fuzzyTerm>
      <fuzzyTerm name="excellent" complement="false"><gaussianShape param1="10.0" param2="1.5"/>\
</fuzzyTerm>
    </fuzzyVariable>
    <fuzzyVariable name="food" domainleft="0.0" domainright="10.0" type="input">
      <fuzzyTerm name="rancid"><trapezoidShape param1="-2" param2="0" param3="1" param4="3"/>\
</fuzzyTerm>
      <fuzzyTerm name="delicious"><trapezoidShape param1="7" param2="9" param3="10" param4="12"/>\
</fuzzyTerm>
    </fuzzyVariable>
    <fuzzyVariable name="tip" domainleft="0.0" domainright="30.0" type="output" accumulation="MAX" \
defuzzifier="COG" defaultValue="0.0">
      <fuzzyTerm name="cheap"><triangularShape param1="0.0" param2="5.0" param3="10.0"/></fuzzyTerm>
      <fuzzyTerm name="average"><triangularShape param1="10.0" param2="15.0" param3="20.0"/>\
</fuzzyTerm>
      <fuzzyTerm name="generous"><triangularShape param1="20.0" param2="25.0" param3="30.0"/>\
</fuzzyTerm>
    </fuzzyVariable>
  </knowledgeBase>
  <mamdaniRuleBase name="rulebase1" activationMethod="MIN" andMethod="MIN" orMethod="MAX">
    <rule name="rule1" orMethod="MAX" connector="or" weight="1.0">
      <antecedent>
        <clause><variable>food</variable><term>rancid</term></clause>
        <clause><variable>service</variable><term>poor</term></clause>
      </antecedent>
      <consequent><then><clause><variable>tip</variable><term>cheap</term></clause></then>\
</consequent>
    </rule>
    <rule name="rule2" connector="or">
      <antecedent><clause><variable>service</variable><term> good </term></clause></antecedent>
      <consequent><then><clause><variable>tip</variable><term>average</term></clause></then>\
</consequent>
    </rule>
    <rule name="rule3" connector="OR" weight="1.0">
      <antecedent>
        <clause><variable>service</variable><term>excellent</term></clause>
        <clause><variable>food</variable><term>delicious</term></clause>
      </antecedent>
      <consequent><then><clause><variable>tip</variable><term>generous</term></clause></then>\
</consequent>
    </rule>
  </mamdaniRuleBase>
</fuzzySystem>
"""

TSK = """\
<fuzzySystem xmlns="http://www.ieee1855.org" name="tsk">
  <knowledgeBase>
    <fuzzyVariable name="a" domainleft="0" domainright="10">
      <fuzzyTerm name="low"><leftLinearShape param1="2" param2="4"/></fuzzyTerm>
    </fuzzyVariable>
    <fuzzyVariable name="b" domainleft="0" domainright="10">
      <fuzzyTerm name="high"><rightLinearShape param1="2" param2="4"/></fuzzyTerm>
    </fuzzyVariable>
    <tskVariable name="y" scale="" type="output" combination="WA" defaultValue="0.0">
      <tskTerm name="fixed" order="0"><tskValue>1.5</tskValue></tskTerm>
      <tskTerm name="plane" order="1"><tskValue>1.0</tskValue><tskValue>2.0</tskValue>\
<tskValue>3.0</tskValue></tskTerm>
    </tskVariable>
  </knowledgeBase>
  <tskRuleBase name="rules" activationMethod="MIN" andMethod="PROD">
    <tskRule name="r1" andMethod="PROD">
      <antecedent><clause><variable>a</variable><term>low</term></clause><clause>\
<variable>b</variable><term>high</term></clause></antecedent>
      <tskConsequent><tskThen><tskClause><variable>y</variable><term>plane</term></tskClause>\
</tskThen></tskConsequent>
    </tskRule>
    <tskRule name="r2" connector="and">
      <antecedent><clause><variable>b</variable><term>high</term></clause></antecedent>
      <tskConsequent><tskThen><tskClause><variable>y</variable><term>fixed</term></tskClause>\
</tskThen></tskConsequent>
    </tskRule>
  </tskRuleBase>
</fuzzySystem>
"""


def test_the_tipper_is_that_of_matlab_but_for_the_grid() -> None:
    """The same system as in MATLAB's file, on another number of points.

    The reader of that is tested against published numbers.
    """
    system, other = parse_fml(TIPPER), parse_fis(TIPPER_FIS)
    assert (system.inputs, system.term_names) == (other.inputs, other.term_names)
    assert sorted(system.rules.tolist()) == sorted(other.rules.tolist())
    X = np.random.default_rng(0).uniform(0.0, 10.0, size=(50, 2))
    # Both are Riemann sums of piecewise linear functions on 30; 0.3 apart, their kinks cost about
    # 0.3² / 30.
    np.testing.assert_allclose(system(X), other(X), atol=0.01)
    on_its_grid = Type1System(
        system.inputs,
        system.rules,
        system.consequents,
        t_norm="min",
        type_reduction="centroid",
        resolution=other.resolution,
    )
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
            '<gaussianShape param="0.0"',
            "<gaussianShape> has no attribute 'param1'",
        ),
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
            'param1="0.0" param2="-1.5"',
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
        (TIPPER, 'defuzzifier="COG"', 'defuzzifier="MOM"', "known is COG"),
        (
            TIPPER,
            'activationMethod="MIN"',
            'activationMethod="PROD"',
            "a system has one t-norm for both",
        ),
        (TIPPER, 'andMethod="MIN"', 'andMethod="custom_and"', "known are MIN, PROD"),
        (TIPPER, 'accumulation="MAX"', 'accumulation="custom_sum"', "known are MAX, PROBOR"),
        (
            TIPPER,
            '<rule name="rule1" orMethod="MAX"',
            '<rule name="rule1" orMethod="PROBOR"',
            "one rule for each alternative",
        ),
        (TIPPER, '"or" weight="1.0"', '"or" weight="0.5"', "rules have no weights"),
        (
            TIPPER,
            "<clause><variable>food",
            '<clause modifier="very"><variable>food',
            "the modifier 'very'",
        ),
        (
            TSK,
            "<tskClause><variable>y</variable><term>fixed",
            '<tskClause modifier="not"><variable>y</variable><term>fixed',
            "have a compl",
        ),
        (
            TIPPER,
            "<clause><variable>service</variable><term>poor",
            "<clause><variable>food</variable><term>rancid",
            "two clauses",
        ),
        (TIPPER, "</then>", "</then><else/>", "where it does not fire"),
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
            "  <mamdaniRuleBase",
            "<anYaRuleBase/>\n  <mamdaniRuleBase",
            "rule bases are of Mamdani or TSK",
        ),
        (
            TIPPER,
            "    <fuzzyVariable",
            "<anYaDataCloud/>\n    <fuzzyVariable",
            "variables are fuzzy, or outputs of TSK",
        ),
        (TSK, 'combination="WA"', 'combination="custom_x"', "the weighted average"),
        (
            TSK,
            '<tskRule name="r1" andMethod="PROD"',
            '<tskRule name="r1" andMethod="MIN"',
            "a system has one t-norm",
        ),
        (
            TSK,
            '<tskRule name="r1" andMethod="PROD"',
            '<tskRule name="r1" connector="or"',
            "one rule for each alternative",
        ),
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
    with pytest.raises(NotExpressible, match="a rule that says nothing about other"):
        parse_fml(TIPPER[:end] + other.replace("PROBOR", "MAX") + TIPPER[end:])


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
        options |= {"type_reduction": "centroid", "t_conorm": conorm}
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
    np.testing.assert_array_equal(read.rules, system.rules)
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
    assert system.term_names[1] == ("rancid", "delicious", "not rancid")
    on_its_grid = Type1System(
        system.inputs,
        system.rules,
        system.consequents,
        t_norm="min",
        type_reduction="centroid",
        resolution=other.resolution,
    )
    X = np.random.default_rng(0).uniform(0.0, 10.0, size=(50, 2))
    np.testing.assert_allclose(on_its_grid(X), other(X), rtol=1e-12)
    written = format_fml(system)
    assert written.count('complement="true"') == 3
    np.testing.assert_array_equal(parse_fml(written)(X), system(X))
    assert format_fml(parse_fml(written)) == written


def test_names_and_domains_of_outputs_are_kept() -> None:
    system = parse_fml(TIPPER.replace('domainright="30.0"', 'domainright="35.0"'))
    assert system.consequent_names == (
        ("cheap",),
        ("cheap",),
        ("average",),
        ("generous",),
        ("generous",),
    )
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


G, N = Gaussian(0, 1), [[1.0]]


@pytest.mark.parametrize(
    ("system", "said"),
    [
        (IntervalType2System([[GaussianUncertainMean((0, 1), 1)]], [[0]], N), "type-1 sets only"),
        (
            Type1System([[G]], [[0]], [G], type_reduction="center_of_sums"),
            "its accumulation unites",
        ),
        (Type1System([[G]], [[0]], [G]), "type reduction 'center_of_sets'"),
        (Type1System([[G]], [[0]], [[[1.0, 2.0]]]), "its constants are crisp"),
        (Type1System([[Bell(0, 1, 2)]], [[0]], N), "it has no such shape"),
        (Type1System([[PiShaped(0, 1, 2, 3)]], [[0]], N), "it has no such shape"),
        (Type1System([[TwoSidedGaussian((0, 1), (1, 2))]], [[0]], N), "it has no such shape"),
        (Type1System([[Complement(Complement(G))]], [[0]], N), "it has no such shape"),
        (Type1System([[Gaussian(0, 1, 0.5)]], [[0]], N), "its membership functions reach 1"),
        (
            Type1System([[SampledSet([0, 1], [0.5, 0]), G]], [[0]], N),
            "let its first and last grade be 0",
        ),
        (
            Type1System([[Trapezoidal(-math.inf, -math.inf, math.inf, math.inf), G]], [[1]], N),
            "it has no such shape",
        ),
        (Type1System([[G]], [[-1]], N), "a rule that asks for nothing"),
        (Type1System([[G]], [[0]], N, input_names=["y1"]), "an input and an output of one name"),
        (Type1System([[G]], [[0]], N, term_names=[["a\x00"]]), "the name 'a\\x00'"),
    ],
)
def test_what_fml_cannot_say_is_refused(system: Any, said: str) -> None:
    with pytest.raises(NotExpressible, match="cannot be expressed in FML") as caught:
        format_fml(system)
    assert said in str(caught.value)


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
