"""Exported systems answer as those in Python do, to the last bit."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest

import fuzzy2
from fuzzy2.errors import InvalidValue, NotExportable, UnknownName
from tests.fuzzy2.export.in_c import bind, build, needs_gcc

RULES = np.array(list(itertools.product(range(3), repeat=2)))
RNG = np.random.default_rng(3)


def gaussians(width: float) -> list[list[Any]]:
    return [
        [fuzzy2.GaussianUncertainMean((m - width, m + width), 0.4) for m in (-1.0, 0.0, 1.0)]
        for _ in range(2)
    ]


def type_1() -> Any:
    terms = [[fuzzy2.Gaussian(m, 0.4) for m in (-1.0, 0.0, 1.0)] for _ in range(2)]
    return fuzzy2.Type1System(terms, RULES, RNG.normal(size=(9, 3)))


def interval() -> Any:
    return fuzzy2.IntervalType2System(gaussians(0.05), RULES, RNG.normal(size=(9, 2)), "min")


def planes() -> Any:
    terms = [
        [fuzzy2.GaussianType2Set(fuzzy2.Gaussian(m, 0.5), 0.05) for m in (-1.0, 0.0, 1.0)]
        for _ in range(2)
    ]
    return fuzzy2.GeneralType2System(terms, RULES, RNG.normal(size=(9, 2)))


def corollary() -> Any:
    return planes().replace(reduction="gaussian")


def with_weights() -> Any:
    words = [
        "IF a is low or b is very high THEN y is small",
        "IF a is not low and b is low THEN y is large and z is small",
    ]
    terms = {"low": fuzzy2.Triangular(-2.0, -1.0, 1.0), "high": fuzzy2.Gaussian(1.0, 0.5)}
    return fuzzy2.IntervalType2System(
        {"a": terms, "b": terms},
        "\n".join(words),
        {"y": {"small": -1.0, "large": 1.5}, "z": {"small": (0.5, 1.0)}},
        default_outputs=[None, 7.0],
        weights=[0.5, 1.0],
    )


def side_by_side() -> Any:
    return fuzzy2.ParallelSystem(
        [type_1(), interval().replace(output_names=["u", "v"]), planes().replace(output_names="pq")]
    )


SYSTEMS = [type_1, interval, planes, corollary, with_weights, side_by_side]


def inputs(count: int, width: int) -> Any:
    """Near and far away, where grades underflow."""
    rng = np.random.default_rng(count)
    scales = rng.choice([0.5, 2.0, 40.0, 1e4], size=(count, 1))
    return rng.normal(size=(count, width)) * scales


@needs_gcc
@pytest.mark.filterwarnings("ignore::fuzzy2.ApproximationWarning")
@pytest.mark.parametrize("made", SYSTEMS, ids=lambda made: made.__name__)
def test_ten_thousand_inputs_give_the_same_numbers(made, tmp_path):
    system = made()
    code = fuzzy2.export_c(system, tmp_path)
    run = bind(build(code, tmp_path), code, code.functions[0])
    X = inputs(10_000, len(system.input_names))
    right, outputs = np.asarray(system(X)), np.empty((len(X), len(system.output_names)))
    for x, out in zip(X, outputs, strict=True):
        assert run(x, out) == 1
    np.testing.assert_array_equal(outputs, right)


@needs_gcc
def test_what_is_not_finite_has_no_answer(tmp_path):
    code = fuzzy2.export_c(interval(), tmp_path)
    run = bind(build(code, tmp_path), code, code.functions[0])
    for bad in (np.nan, np.inf, -np.inf):
        out = np.zeros(2)
        assert run(np.array([0.0, bad]), out) == 0
        assert np.isnan(out).all()


def test_what_is_refused():
    with pytest.raises(NotExportable, match="a dict"):
        fuzzy2.export_c({}, ".")
    with pytest.raises(UnknownName, match="half"):
        fuzzy2.export_c(type_1(), ".", precision="half")
    with pytest.raises(InvalidValue, match="a letter first"):
        fuzzy2.export_c(type_1(), ".", name="my system")
