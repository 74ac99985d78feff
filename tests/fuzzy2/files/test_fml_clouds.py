"""AnYa rule bases of IEEE 1855: as JFML answers, there and back, and what they cannot say."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fuzzy2 import AnYaSystem, Gaussian, Linear, Trapezoidal, Type1System, load, save
from fuzzy2.errors import MalformedFile, NotExpressible
from fuzzy2.files.fml import format_fml, parse_fml
from fuzzy2.systems.antecedents import Is, Not
from tests.fuzzy2.files.fml_texts import TIPPER_OF_CLOUDS

INPUTS = [
    [6.369616985321045, 2.6978671550750732, 0.40973523259162903],
    [0.16527634859085083, 8.132702827453613, 9.127555847167969],
    [6.066357612609863, 7.294965744018555, 5.436249732971191],
]


def test_the_answers_of_jfml() -> None:
    """JFML 1.3 to its TipperAnYa, which it sums up over other points in single precision."""
    system: Any = parse_fml(TIPPER_OF_CLOUDS)
    assert system.input_names == ("food", "service", "quality")
    np.testing.assert_allclose(
        system(INPUTS)[:, 0], [9.162573, 10.924248, 10.136164], rtol=0.0, atol=1e-4 * 20.0
    )


CHANGED = (
    TIPPER_OF_CLOUDS.replace('"rule1"', '"rule1" weight="0.25"')
    .replace(
        "<term>generous</term></clause></then>",
        "<term>generous</term></clause></then><else><clause><variable>tip</variable>"
        "<term>cheap</term></clause></else>",
    )
    .replace("<anYaRuleBase", '<anYaRuleBase activationMethod="PROD"')
    .replace("<dataCloudName>service<", "<dataCloudName>food<")
)


@pytest.mark.parametrize("text", [TIPPER_OF_CLOUDS, CHANGED])
def test_files_come_back(tmp_path: Path, text: str) -> None:
    """Also with weights, *else*, another activation, and a cloud of two rules."""
    system: Any = parse_fml(text)
    again: Any = parse_fml(format_fml(system))
    assert format_fml(again) == format_fml(system)
    np.testing.assert_array_equal(again(INPUTS), system(INPUTS))
    for suffix in (".json", ".fml"):
        save(system, tmp_path / f"tipper{suffix}")
        np.testing.assert_array_equal(load(tmp_path / f"tipper{suffix}")(INPUTS), system(INPUTS))
    for suffix in (".fis", ".t2fis", ".fll", ".fcl"):
        with pytest.raises(NotExpressible, match=rf"AnYaSystem cannot be expressed in {suffix}"):
            save(system, tmp_path / f"tipper{suffix}")


def test_weights_else_and_activation_are_read() -> None:
    system: Any = parse_fml(CHANGED)
    x = np.array(INPUTS)
    gamma = [1.0 / (1.0 + np.abs(x[:, i, None] - cloud).mean(axis=1)) for i, cloud in CLOUDS]
    fired = np.stack(gamma, axis=1) / np.sum(gamma, axis=0)[:, None]
    np.testing.assert_allclose(system.relative_densities(x), fired, rtol=1e-13)
    at = np.linspace(0.0, 20.0, 20_001)
    cheap, average, generous = (np.maximum(0.0, 1.0 - abs(at - c) / 5.0) for c in (5, 10, 15))
    for one, answer in zip(fired, system(x)[:, 0], strict=True):
        united = np.max(
            [0.25 * one[0] * cheap, one[1] * average, one[2] * generous, (1.0 - one[2]) * cheap],
            axis=0,
        )
        np.testing.assert_allclose(answer, at @ united / united.sum(), rtol=1e-12)


CLOUDS = ((0, [1.0, 1.7, 4.0, 3.2]), (0, [1.0, 1.7, 4.0, 3.2]), (2, [8.0, 7.7, 10.0, 8.6]))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("<dataCloudName>food<", "<dataCloudName>fod<", "fod"),
        ("<datum>1.0</datum>", "<datum>one</datum>", "expected a finite number"),
        ("<anYaAntecedent>", "<antecedent/><anYaAntecedent>", "expected <anYaAntecedent> or"),
        ("<dataCloudName>food</dataCloudName>", "", "expected one <dataCloudName>"),
        (' type="output"', ' type="input"', "an input of an AnYa rule base is an <anYaDataCloud>"),
        ('name="food"', 'name="service"', "is given to two variables"),
    ],
)
def test_what_is_malformed(old: str, new: str, said: str) -> None:
    assert old in TIPPER_OF_CLOUDS
    with pytest.raises(MalformedFile, match=re.escape(said)):
        parse_fml(TIPPER_OF_CLOUDS.replace(old, new, 1))
    empty = re.sub("<datum>.*?</datum>", "", TIPPER_OF_CLOUDS)
    with pytest.raises(MalformedFile, match="at least one <datum>"):
        parse_fml(empty)


_OUTPUT = TIPPER_OF_CLOUDS[
    TIPPER_OF_CLOUDS.index("<fuzzyVariable") : TIPPER_OF_CLOUDS.index("</knowledgeBase>")
]
NUMBERS = TIPPER_OF_CLOUDS.replace(
    _OUTPUT,
    '<tskVariable name="tip" type="output" combination="WA">'
    + "".join(
        f'<tskTerm name="{name}" order="0"><tskValue>{value}</tskValue></tskTerm>'
        for name, value in (("cheap", 5.0), ("average", 10.0), ("generous", 15.0))
    )
    + "</tskVariable>",
)
for _word, _other in (
    ("consequent", "tskConsequent"),
    ("then", "tskThen"),
    ("clause", "tskClause"),
):
    NUMBERS = re.sub(rf"(</?){_word}>", rf"\g<1>{_other}>", NUMBERS)
POINTS = TIPPER_OF_CLOUDS.replace(
    _OUTPUT,
    '<tsukamotoVariable name="tip" type="output" combination="WA" domainleft="0" domainright="20">'
    + "".join(
        f'<tsukamotoTerm name="{name}"><{kind} param1="{low}" param2="{high}"/></tsukamotoTerm>'
        for name, kind, low, high in (
            ("cheap", "leftLinearShape", 0.0, 10.0),
            ("average", "rightLinearShape", 5.0, 15.0),
            ("generous", "rightLinearShape", 10.0, 20.0),
        )
    )
    + "</tsukamotoVariable>",
)


def test_numbers_and_sets_of_tsukamoto_are_averaged_by_the_densities(tmp_path: Path) -> None:
    numbers: Any = parse_fml(NUMBERS)
    points: Any = parse_fml(POINTS)
    fired = parse_fml(TIPPER_OF_CLOUDS).relative_densities(INPUTS)
    np.testing.assert_allclose(numbers(INPUTS)[:, 0], fired @ [5.0, 10.0, 15.0], rtol=1e-13)
    at = np.array([10.0, 5.0, 10.0]) + np.array([-10.0, 10.0, 10.0]) * fired
    np.testing.assert_allclose(points(INPUTS)[:, 0], (fired * at).sum(axis=1), rtol=1e-9)
    for system in (numbers, points):
        for suffix in (".json", ".fml"):
            save(system, tmp_path / f"tipper{suffix}")
            again = load(tmp_path / f"tipper{suffix}")
            np.testing.assert_allclose(again(INPUTS), system(INPUTS), rtol=1e-12)


def test_functions_several_kinds_and_weighted_else_are_refused() -> None:
    functions = NUMBERS.replace(
        'order="0"><tskValue>5.0<', 'order="1"><tskValue>1.0</tskValue><tskValue>5.0<', 1
    )
    with pytest.raises(NotExpressible, match=r"functions of 'tip'.*take order 0"):
        parse_fml(functions)
    other = '<tskVariable name="z" combination="WA"/></knowledgeBase>'
    with pytest.raises(NotExpressible, match=r"outputs of several kinds.*take one kind"):
        parse_fml(TIPPER_OF_CLOUDS.replace("</knowledgeBase>", other))
    with pytest.raises(NotExpressible, match="with a weight"):
        parse_fml(CHANGED.replace('"rule3"', '"rule3" weight="0.5"'))


FIRING = Trapezoidal(0.0, 1.0, np.inf, np.inf)
FIRST, SAID = Is(0, 0), [[Gaussian(0.0, 1.0)]]


def of(rules: Any, said: Any = SAID, firing: Any = FIRING, **options: Any) -> AnYaSystem:
    chosen = {"type_reduction": "centroid", **options}
    said = said if isinstance(said, Linear) else said * len(rules)
    consequents = Type1System([[firing]], rules, said, **chosen)
    return AnYaSystem([[1.0, 2.0]], [0], consequents, ["x"])


@pytest.mark.parametrize(
    ("system", "said"),
    [
        (of([FIRST], Linear([[[1.0, 2.0]]]), type_reduction="center_of_sets"), "functions of fir"),
        (of([FIRST], firing=Gaussian(0.0, 1.0)), "use the firing itself"),
        (of([FIRST, Not(Not(FIRST))]), "use the firing itself"),
        (of([FIRST, FIRST]), "2 rules for a firing and 0 against it"),
        (of([Not(FIRST)]), "0 rules for a firing and 1 against it"),
        (of([FIRST, Not(FIRST)], weights=[0.5, 1.0]), "fires by 1 - w f"),
        (of([FIRST], output_names=["x"]), "an input and an output of one name"),
        (of([FIRST], t_conorm="sum"), "its accumulation unites"),
    ],
)
def test_what_fml_cannot_say_of_clouds_is_refused(system: AnYaSystem, said: str) -> None:
    with pytest.raises(NotExpressible, match="cannot be expressed in FML") as caught:
        format_fml(system)
    assert said in str(caught.value)
