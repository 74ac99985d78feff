"""Inputs by position, keyword, mapping and data frame are one and the same."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import fuzzy2
from fuzzy2.errors import InvalidValue
from fuzzy2.systems import Type1System

G = fuzzy2.Gaussian
TERMS = {"a": {"low": G(0, 1), "high": G(1, 1)}, "b": {"low": G(0, 2), "high": G(3, 1)}}
SYSTEM = Type1System(
    TERMS,
    "IF a is low THEN y is s\nIF b is high and a is high THEN y is t",
    {"y": {"s": 0.0, "t": 1.0}},
)


class Frame:
    """What a data frame is made of here: names of columns, and columns by name."""

    def __init__(self, **columns: Any) -> None:
        self.columns, self._values = list(columns), columns

    def __getitem__(self, name: str) -> Any:
        return self._values[name]


def test_all_ways_are_one() -> None:
    a, b = np.array([0.1, 0.5]), np.array([2.0, 1.0])
    expected = SYSTEM(np.stack([a, b], axis=-1))
    np.testing.assert_array_equal(SYSTEM(a=a, b=b), expected)
    np.testing.assert_array_equal(SYSTEM({"b": b, "a": a}), expected)
    np.testing.assert_array_equal(SYSTEM(Frame(b=b, other=a, a=a)), expected)
    np.testing.assert_array_equal(SYSTEM(a=0.1, b=2.0), expected[0])
    np.testing.assert_array_equal(SYSTEM(a=a, b=2.0)[0], expected[0])
    np.testing.assert_array_equal(SYSTEM.firing({"b": b, "a": a}).shape, (2, 2, 2))


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"a": 1.0}, "b has none"),
        ({"a": 1.0, "c": 1.0}, "unknown input 'c'"),
        ({"a": [1.0, 2.0], "b": [1.0, 2.0, 3.0]}, "shapes that go together"),
        (Frame(a=[1.0], c=[2.0]), "b has none"),
    ],
)
def test_what_does_not_name_the_inputs_is_refused(given: Any, said: str) -> None:
    with pytest.raises(InvalidValue, match=said):
        SYSTEM(given)


def test_columns_of_a_frame_are_taken_in_order_where_nobody_named_the_inputs() -> None:
    system = Type1System([[G(0, 1)], [G(1, 1)]], [[0, -1], [-1, 0]], [[0.0], [1.0]])
    np.testing.assert_array_equal(system(Frame(p=[0.3], q=[0.6])), system([[0.3, 0.6]]))


@pytest.mark.parametrize(
    "bad",
    [
        np.ma.masked_array([1.0, 2.0], mask=[False, True]),
        [1.0 + 0.0j, 2.0],
        ["1.0", "2.0"],
        np.array(["1.0", 2.0], dtype=object),
        np.array(["2020-01-01", "2020-01-02"], dtype="datetime64[D]"),
        [10**400, 1.0],
    ],
)
def test_what_is_no_row_of_numbers_is_refused(bad: Any) -> None:
    with pytest.raises(InvalidValue):
        SYSTEM(bad)
    with pytest.raises(InvalidValue):
        fuzzy2.generalized_centroid(bad, [[0.5, 1.0], [0.5, 1.0]])


def test_inputs_come_in_one_way() -> None:
    with pytest.raises(InvalidValue, match="left out"):
        SYSTEM([0.0, 1.0], a=1.0)
