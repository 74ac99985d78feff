"""Numbers that every program reads alike."""

from __future__ import annotations

import math

import pytest

from fuzzy2.support.number_text import number_of


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1", 1.0),
        ("-.5", -0.5),
        ("+2.", 2.0),
        ("1.5E-3", 0.0015),
        ("1e999", math.inf),
        ("-Inf", -math.inf),
        ("infinity", math.inf),
    ],
)
def test_numbers(text: str, value: float) -> None:
    assert number_of(text) == value


@pytest.mark.parametrize(
    "text",
    [
        "",
        " 1",
        "1 ",
        "\u00a01",
        "1_0",
        "0x1p-2",
        "１",
        "٣",
        "1d0",
        "1,5",
        "1e",
        ".",
        "nan",
        "5mm",
        "²",
    ],
)
def test_what_some_programs_read_and_others_do_not(text: str) -> None:
    assert math.isnan(number_of(text))
