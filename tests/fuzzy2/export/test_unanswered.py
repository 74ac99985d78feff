"""Who exports a system learns where the code has no answer."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fuzzy2
from fuzzy2.errors import UnansweredInC
from fuzzy2.export.systems import c_code_of
from fuzzy2.export.unanswered import INPUTS, _drawn
from tests.fuzzy2.export.in_c import bind, build, needs_gcc

RULES = "IF x is low THEN y is low\nIF x is high THEN y is high"


def with_sets(sigmas: tuple[float, float], **options: Any) -> fuzzy2.IntervalType2System:
    """Return a system whose output sets have lower functions of one width in upper ones."""
    mean = fuzzy2.GaussianUncertainMean
    terms = {"x": {"low": mean((-1.2, -0.8), 0.8), "high": mean((0.8, 1.2), 0.8)}}
    return fuzzy2.IntervalType2System(terms, RULES, output_sets(sigmas), **OUTPUTS, **options)


def on_planes(sigmas: tuple[float, float]) -> fuzzy2.GeneralType2System:
    """Return the like with three α-planes, of which the lowest has no answer most often."""
    terms = {
        name: fuzzy2.GaussianType2Set(principal=fuzzy2.Gaussian(m, 0.8), sigma=0.05)
        for name, m in (("low", -1.0), ("high", 1.0))
    }
    return fuzzy2.GeneralType2System({"x": terms}, RULES, output_sets(sigmas), levels=3, **OUTPUTS)


def output_sets(sigmas: tuple[float, float]) -> dict[str, dict[str, Any]]:
    places = (("low", -2.0), ("high", 2.0))
    return {"y": {name: fuzzy2.GaussianUncertainSigma(m, sigmas) for name, m in places}}


OUTPUTS: dict[str, Any] = {
    "type_reduction": "centroid",
    "output_ranges": [(-3.0, 3.0)],
    "input_ranges": [(-2.0, 2.0)],
}


@needs_gcc
@pytest.mark.parametrize("make", [with_sets, on_planes])
def test_as_many_inputs_are_named_as_the_code_does_not_answer(
    make: Callable[..., Any], tmp_path: Path
) -> None:
    system = make((0.1, 1.0))
    with pytest.warns(UnansweredInC, match="integration='sum'") as caught:
        code = c_code_of(system)
    found = caught[0].message
    assert isinstance(found, UnansweredInC)
    call = bind(build(code, tmp_path), code, code.functions[0])
    out, codes = np.empty(1), []
    for x in _drawn(system):
        codes.append(call(x, out))
        assert codes[-1] == 1 or np.isnan(out[0])
    assert (found.count, found.total) == (codes.count(0), INPUTS)
    assert 0 < found.count < INPUTS
    assert np.isfinite(system(_drawn(system))).all()


@pytest.mark.parametrize(
    "system",
    [
        with_sets((0.1, 1.0), integration="sum", resolution=101),
        with_sets((0.1, 1.0)).replace(type_reduction="center_of_sets"),
    ],
    ids=["on a grid", "center of sets"],
)
def test_what_is_answered_everywhere_has_no_warning(system: fuzzy2.IntervalType2System) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        c_code_of(system)
