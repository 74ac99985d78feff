"""Rules of systems in words."""

from __future__ import annotations

import fuzzy2
from fuzzy2.systems.antecedents import And, Hedged, Is
from fuzzy2.systems.hedges import HEDGES
from fuzzy2.systems.words import rules_in_words

TERMS = [fuzzy2.Triangular(-1.0, 0.0, 1.0), fuzzy2.Triangular(0.0, 1.0, 2.0)]


def test_rules_in_words_come_back_as_they_were_written() -> None:
    text = "IF a is not very Low and (b is High or b is Low) THEN p is off with 0.5"
    named = dict(zip(("Low", "High"), TERMS, strict=True))
    system = fuzzy2.Type1System({"a": named, "b": named}, text, {"p": {"off": 0.0, "on": 1.0}})
    assert rules_in_words(system) == [text]


def test_numbers_intervals_functions_and_sets_are_said_as_what_they_are() -> None:
    rules = [[0, -1], [1, 1]]
    points = fuzzy2.Type1System([TERMS, TERMS], rules, [[[1.0, 1.0]], [[2.0, 3.0]]])
    assert rules_in_words(points) == [
        "IF x1 is term1 THEN y1 is 1",
        "IF x1 is term2 and x2 is term2 THEN y1 is [2, 3]",
    ]
    linear = points.replace(consequents=fuzzy2.Linear([[[1.0, -2.0, 0.0]], [[0.0, 0.5, 3.0]]]))
    assert rules_in_words(linear, 1) == ["IF x1 is term1 THEN y1 is 1 - 2 x1"]
    sets = points.replace(consequents=[[TERMS[0]], [TERMS[1]]])
    assert rules_in_words(sets)[0].endswith(f"THEN y1 is {TERMS[0]!r}")


def test_a_hedge_of_a_group_is_shown_though_no_rule_in_words_has_one() -> None:
    tree = Hedged(HEDGES["very"], And((Is(0, 0), Is(1, 1))))
    system = fuzzy2.Type1System([TERMS, TERMS], (tree,), [[1.0]])
    (shown,) = rules_in_words(system)
    assert "term1" in shown
    assert "very" in shown
