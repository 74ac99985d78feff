"""JSON: what is read, and what Python's parser would pass over."""

from __future__ import annotations

import json

import pytest

from fuzzy2.support.bounded_files import MOST_PARTS
from fuzzy2.support.json_documents import json_document


def test_documents_are_read() -> None:
    content = {"a": [1, 2.5, -1e-320, None, True], "b": {"a": "[{:"}}
    assert json_document(json.dumps(content)) == content


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('{"a": 1, "b": 2, "a": 3}', "the key 'a' is there twice"),
        ('[{"a": {"b": 1, "b": 1}}]', "the key 'b' is there twice"),
        ("[NaN]", "NaN is not a number of JSON"),
        ("[-Infinity]", "-Infinity is not a number"),
        ("[1e999]", "1e999 is too large"),
        ("9" * 5000, "limit"),
        ("[" * 100_000 + "]" * 100_000, "nested too deeply"),
        ("[" + "[]," * MOST_PARTS + "[]]", "more than 1000000 lists, objects and keys"),
        ("[1,]", "line 1 column"),
        ("", "line 1 column 1"),
    ],
    ids=range(10),
)
def test_what_says_two_things_or_too_much_is_refused(text: str, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        json_document(text)
