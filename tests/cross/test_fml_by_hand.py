"""FML against an evaluator of its own, on documents of all rule bases, and on ours at random."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings

from fuzzy2.errors import NotExpressible
from fuzzy2.files.fml import format_fml, parse_fml
from fuzzy2.systems.operators import UNIONS
from fuzzy2.systems.system import Type1System
from tests import examples
from tests.fuzzy2.files.fml_by_hand import ByHand
from tests.fuzzy2.files.fml_texts import (
    TIPPER,
    TIPPER_OF_CLOUDS,
    TIPPER_WITH_POLYNOMIAL,
    TSK,
)
from tests.fuzzy2.files.test_fml_clouds import NUMBERS, POINTS
from tests.fuzzy2.files.test_formats import systems

TSUKAMOTO = (
    TIPPER[: TIPPER.index('    <fuzzyVariable name="tip"')]
    + """\
    <tsukamotoVariable name="tip" type="output" domainleft="0" domainright="20" combination="WA">
      <tsukamotoTerm name="cheap"><leftLinearShape param1="0" param2="10"/></tsukamotoTerm>
      <tsukamotoTerm name="average"><zShape param1="5" param2="15"/></tsukamotoTerm>
      <tsukamotoTerm name="generous"><leftGaussianShape param1="2" param2="3"/></tsukamotoTerm>
    </tsukamotoVariable>
"""
    + TIPPER[TIPPER.index("  </knowledgeBase>") :].replace("mamdaniRuleBase", "tsukamotoRuleBase")
)


def difference(text: str) -> float:
    """Return the greatest difference of answers to 100 inputs, in widths of the outputs' domains.

    It is infinite where one has an answer and the other has none.
    """
    system, other = parse_fml(text), ByHand(text)
    X = other.inputs(100)
    found, expected = system(X), other(X)
    if (np.isnan(found) != np.isnan(expected)).any():
        return float("inf")
    return float(np.nanmax(np.abs(found - expected) / other.ranges(), initial=0.0))


@pytest.mark.parametrize(
    "text",
    [TIPPER, TSK, TIPPER_WITH_POLYNOMIAL, TIPPER_OF_CLOUDS, TSUKAMOTO, NUMBERS, POINTS],
    ids=["mamdani", "tsk", "polynomial", "anya", "tsukamoto", "anya-tsk", "anya-tsukamoto"],
)
def test_documents(text: str) -> None:
    assert difference(text) <= 1e-9


@given(systems())
@settings(max_examples=examples(60), deadline=None)
def test_what_is_written(system: Type1System) -> None:
    """Documents say what systems do, apart from their reader.

    But for maxima, which a grid may find elsewhere where two are equal.
    """
    if system.type_reduction in UNIONS:
        system = system.replace(type_reduction="centroid", integration="sum", resolution=20001)
    try:
        text = format_fml(system)
    except NotExpressible:
        return
    other = ByHand(text)
    X = other.inputs(20)
    found, expected = system(X), other(X)
    if system.default_outputs is None:
        np.testing.assert_array_equal(np.isnan(found), np.isnan(expected))
    assert np.nanmax(np.abs(found - expected), initial=0.0) <= 1e-9
