"""Documents in the layout of IEEE 1855."""

from __future__ import annotations

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


def _variable(name: str, end: int, terms: str, rest: str) -> str:
    return (
        f'<fuzzyVariable name="{name}" domainleft="0.0" domainright="{end}.0" {rest}>{terms}'
        "</fuzzyVariable>"
    )


def _term(name: str, shape: str, *parameters: float) -> str:
    given = " ".join(f'param{i}="{value}"' for i, value in enumerate(parameters, start=1))
    return f'<fuzzyTerm name="{name}"><{shape}Shape {given}/></fuzzyTerm>'


def _rule(number: int, said: str, *asked: tuple[str, str, str]) -> str:
    clauses = "".join(
        f"<clause{modifier}><variable>{variable}</variable><term>{term}</term></clause>"
        for variable, term, modifier in asked
    )
    return (
        f'<rule name="rule{number}" connector="or" orMethod="MAX" weight="1.0"><antecedent>'
        f"{clauses}</antecedent><consequent><then><clause><variable>tip</variable>"
        f"<term>{said}</term></clause></then></consequent></rule>"
    )


_CHEAP = "".join(
    f'<point x="{x}" y="{y}"/>' for x, y in ((0, 1.0), (1, 1.0), (2, 0.6), (3, 0.4), (4, 0.0))
)

TIPPER_WITH_POLYNOMIAL = (
    '<fuzzySystem xmlns="http://www.ieee1855.org" name="tipper - MAMDANI"><knowledgeBase>'
    + _variable(
        "food",
        10,
        _term("rancid", "triangular", 0.0, 2.0, 5.5) + _term("delicious", "rightLinear", 5.5, 10.0),
        'type="input"',
    )
    + _variable(
        "service",
        10,
        _term("poor", "leftGaussian", 0.0, 2.0)
        + _term("good", "gaussian", 5.0, 4.0)
        + _term("excellent", "rightGaussian", 10.0, 2.0),
        'type="input"',
    )
    + _variable(
        "tip",
        20,
        '<fuzzyTerm name="cheap"><pointSetShape interpolationMethod="lagrange">'
        + _CHEAP
        + "</pointSetShape></fuzzyTerm>"
        + _term("average", "triangular", 5.0, 10.0, 15.0)
        + _term("generous", "triangular", 10.0, 15.0, 20.0),
        'type="output" accumulation="MAX" defuzzifier="COG" defaultValue="0.0"',
    )
    + '</knowledgeBase><mamdaniRuleBase name="rules" activationMethod="MIN">'
    + _rule(1, "cheap", ("food", "rancid", ""), ("service", "poor", ' modifier="very"'))
    + _rule(2, "average", ("service", "good", ""))
    + _rule(3, "generous", ("service", "excellent", ""), ("food", "delicious", ""))
    + "</mamdaniRuleBase></fuzzySystem>"
)
"""The system of JFML's example TipperMamdani2."""


def _cloud_rule(number: int, cloud: str, said: str) -> str:
    return (
        f'<anYaRule name="rule{number}"><anYaAntecedent><dataCloudName>{cloud}</dataCloudName>'
        "</anYaAntecedent><consequent><then><clause><variable>tip</variable>"
        f"<term>{said}</term></clause></then></consequent></anYaRule>"
    )


def _cloud(name: str, *data: float) -> str:
    inside = "".join(f"<datum>{value}</datum>" for value in data)
    return f'<anYaDataCloud name="{name}">{inside}</anYaDataCloud>'


TIPPER_OF_CLOUDS = (
    '<fuzzySystem xmlns="http://www.ieee1855.org" name="tipper - AnYa"><knowledgeBase>'
    + _cloud("food", 1.0, 1.7, 4.0, 3.2)
    + _cloud("service", 6.0, 5.7, 7.0, 4.6)
    + _cloud("quality", 8.0, 7.7, 10.0, 8.6)
    + _variable(
        "tip",
        20,
        _term("cheap", "triangular", 0.0, 5.0, 10.0)
        + _term("average", "triangular", 5.0, 10.0, 15.0)
        + _term("generous", "triangular", 10.0, 15.0, 20.0),
        'type="output" accumulation="MAX" defuzzifier="COG" defaultValue="0.0"',
    )
    + '</knowledgeBase><anYaRuleBase name="rules">'
    + _cloud_rule(1, "food", "cheap")
    + _cloud_rule(2, "service", "average")
    + _cloud_rule(3, "quality", "generous")
    + "</anYaRuleBase></fuzzySystem>"
)
"""The system of JFML's example TipperAnYa."""
