"""Inputs by position, keyword, mapping and data frame are one and the same."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import fuzzy2
from fuzzy2.errors import InvalidValue
from fuzzy2.systems import (
    FuzzySystem,
    GeneralType2System,
    IntervalType2System,
    Type1System,
)
from fuzzy2.systems.parallel import ParallelSystem

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
        (Frame(a=[1.0], c=[2.0]), r"b has none, got \['a', 'c'\]"),
        (Frame(d=[1.0], c=[2.0]), r"a, b have none, got \['d', 'c'\]"),
    ],
)
def test_what_does_not_name_the_inputs_is_refused(given: Any, said: str) -> None:
    with pytest.raises(InvalidValue, match=said):
        SYSTEM(given)


def test_columns_of_a_frame_are_taken_in_order_where_nobody_named_the_inputs() -> None:
    system = Type1System([[G(0, 1)], [G(1, 1)]], [[0, -1], [-1, 0]], [[0.0], [1.0]])
    np.testing.assert_array_equal(system(Frame(p=[0.3], q=[0.6])), system([[0.3, 0.6]]))


def test_a_column_that_occurs_twice_is_refused() -> None:
    pandas = pytest.importorskip("pandas")
    with pytest.raises(InvalidValue, match="one column for each input: a is repeated"):
        SYSTEM(pandas.DataFrame([[1.0, 2.0, 3.0]] * 2, columns=["a", "a", "b"]))


def test_a_mask_is_refused_with_what_was_given() -> None:
    masked = np.ma.masked_invalid([1.0, np.inf])
    with pytest.raises(InvalidValue, match=r"without a mask.*got masked_array\(data=\[1\.0, --\]"):
        SYSTEM(masked)


@pytest.mark.parametrize("name", ["firing", "coverage", "validity", "gradient", "type_reduced"])
@pytest.mark.parametrize("kind", [Type1System, IntervalType2System, GeneralType2System])
def test_every_question_matches_columns_by_name(kind: type[FuzzySystem], name: str) -> None:
    """Also those that a plane of a general type-2 system answers."""
    terms = SYSTEM.inputs
    if kind is GeneralType2System:
        terms = tuple(tuple(fuzzy2.GaussianType2Set(one, 0.1) for one in own) for own in terms)
    system = kind(terms, SYSTEM.rules, SYSTEM.consequents, input_names=["a", "b"])
    a, b = np.array([0.1, 0.5]), np.array([2.0, 1.0])
    ask = getattr(system, name)
    np.testing.assert_array_equal(ask(Frame(b=b, a=a)), ask(np.stack([a, b], axis=-1)))
    np.testing.assert_array_equal(
        list(system.embedded_outputs({"b": 2.0, "a": 0.1}, 3)),
        list(system.embedded_outputs([0.1, 2.0], 3)),
    )
    with pytest.raises(InvalidValue, match="have none"):
        ask(Frame(c=b, d=a))


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


@pytest.mark.parametrize("kind", [Type1System, IntervalType2System, GeneralType2System])
def test_data_frames_of_pandas_give_data_frames(kind: type[FuzzySystem]) -> None:
    """Index and names of outputs are kept, and columns found by name in whatever order."""
    pandas = pytest.importorskip("pandas")
    system = kind(
        SYSTEM.inputs,
        SYSTEM.rules,
        np.arange(4.0).reshape(2, 2),
        input_names=["a", "b"],
        output_names=["p", "q"],
    )
    frame = pandas.DataFrame({"b": [2.0, 1.0], "a": [0.1, 0.5]}, index=["first", "last"])
    expected = system(frame[["a", "b"]].to_numpy())
    found = system(frame)
    assert list(found.columns) == ["p", "q"]
    assert list(found.index) == ["first", "last"]
    np.testing.assert_array_equal(found.to_numpy(), expected)
    row = system(frame.loc["last"])
    assert (list(row.index), row.name) == (["p", "q"], "last")
    np.testing.assert_array_equal(row.to_numpy(), expected[1])
    both = ParallelSystem([system, system.replace(output_names=["r", "s"])])(frame)
    assert list(both.columns) == ["p", "q", "r", "s"]
    np.testing.assert_array_equal(both.to_numpy(), np.hstack([expected, expected]))


def test_rows_of_pandas_are_matched_by_name_or_refused() -> None:
    pandas = pytest.importorskip("pandas")
    assert SYSTEM(pandas.Series([0.1, 2.0]))["y"] == SYSTEM([0.1, 2.0])[0]
    assert SYSTEM(pandas.Series([2.0, 0.1], index=["b", "a"]))["y"] == SYSTEM([0.1, 2.0])[0]
    with pytest.raises(InvalidValue, match="b has none"):
        SYSTEM(pandas.Series([0.1, 2.0], index=["a", "c"]))
