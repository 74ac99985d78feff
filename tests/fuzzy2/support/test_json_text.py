"""JSON documents: what ``json`` passes over in silence is refused with its place."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzy2.errors import MalformedFile
from fuzzy2.support.bounded_files import MOST_PARTS
from fuzzy2.support.json_text import parse_json

VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(),
    lambda inside: st.lists(inside) | st.dictionaries(st.text(), inside),
)


@given(VALUES)
def test_whatever_json_writes_is_read(value: object) -> None:
    assert parse_json(json.dumps(value)) == value


@pytest.mark.parametrize(
    ("text", "place", "said"),
    [
        ('{"a": 1,\n "b" 2}', "line 2, column 6", "Expecting ':' delimiter"),
        ('{"a": 1, "a": 1}', "$.a", "is given twice"),
        ('{"b": [0, {"c": {"a": 1, "d": 2, "a": 1}}]}', "$.b[1].c.a", "is given twice"),
        ('{"b": [[{"a": 1, "a": 2}]]}', "$.b[0][0].a", "is given twice"),
        ('{"a": NaN}', "$", "NaN is not a number of JSON"),
        ("[-Infinity]", "$", "-Infinity is not a number of JSON"),
        ("[" * 100_000, "$", "is nested too deeply"),
        ('{"a":' * 100_000 + "1" + "}" * 100_000, "$", "is nested too deeply"),
        ('{"a\\ud800": 1}', "$", "has half of a pair of characters, '\\ud800'"),
        ("1" * 5000, "$", "Exceeds the limit"),
        ("", "line 1, column 1", "Expecting value"),
        ("[1e999]", "$", "1e999 is too large"),
        ("[" + "[]," * MOST_PARTS + "[]]", "$", "more than 1000000 lists, objects and names"),
    ],
    ids=range(13),
)
def test_what_is_none_is_refused_with_its_place(text: str, place: str, said: str) -> None:
    with pytest.raises(MalformedFile) as caught:
        parse_json(text, "file")
    assert (caught.value.source, caught.value.place) == ("file", place)
    assert said in caught.value.reason
