"""Explanations in words and HTML."""

from __future__ import annotations

import numpy as np
import pytest

import fuzzy2
from fuzzy2.errors import InvalidValue

TERMS = {"Low": fuzzy2.Triangular(-1.0, 0.0, 1.0), "High": fuzzy2.Triangular(0.0, 1.0, 2.0)}
RULES = """
IF a is Low and b is Low THEN p is off
IF a is High or b is High THEN p is on
"""


def system(**options: object) -> fuzzy2.Type1System:
    outputs = {"p": {"off": 0.0, "on": 10.0}}
    return fuzzy2.Type1System({"a": TERMS, "b": TERMS}, RULES, outputs, "min", **options)  # type: ignore[arg-type]


def test_the_rules_that_decided_are_printed_from_the_strongest_on() -> None:
    """By hand: firing 0.3 and 0.7, whose sum is 1."""
    explanation = system().explain([0.7, 0.2])
    assert str(explanation).splitlines() == [
        "p = 7 at a = 0.7, b = 0.2",
        "   70.0 %  rule 2 (fires 0.7): IF a is High or b is High THEN p is on",
        "   30.0 %  rule 1 (fires 0.3): IF a is Low and b is Low THEN p is off",
    ]
    np.testing.assert_array_equal(explanation.ranking(), [1, 0])
    assert explanation.text(1).splitlines()[-1] == "   30.0 %  1 other rule"
    assert repr(explanation) == "<Explanation of p = 7, 2 rules>"
    assert str(system().explain({"a": 0.7, "b": 0.2})) == str(explanation)


def test_intervals_and_intervals_of_firing_are_printed() -> None:
    terms = [fuzzy2.GaussianUncertainMean((m - 0.1, m + 0.1), 0.5) for m in (0.0, 1.0)]
    found = fuzzy2.IntervalType2System([terms], [[0], [1]], [[0.0], [1.0]])
    left, right = found.type_reduced([0.3])[0]
    headline, first, _ = str(found.explain([0.3])).splitlines()
    assert headline == f"y1 = {0.5 * (left + right):.6g}, in [{left:.6g}, {right:.6g}], at x1 = 0.3"
    assert " to " in first


def test_where_no_rule_fires_that_is_said() -> None:
    assert str(system().explain([5.0, 5.0])).endswith("  no rule fires")
    explained = system(default_outputs=[3.0]).explain([5.0, 5.0])
    assert str(explained) == "p = 3 at a = 5, b = 5\n  no rule fires; the default output"


def test_names_are_escaped_in_html() -> None:
    outputs = {"<p>": {"&off": 0.0, "on": 1.0}}
    rules = 'IF "<b>x</b>" is Low THEN <p> is &off\nIF "<b>x</b>" is High THEN <p> is on'
    named = fuzzy2.Type1System({"<b>x</b>": TERMS}, rules, outputs)
    for shown in (named.explain([0.25])._repr_html_(), named._repr_html_()):
        assert "<b>x" not in shown
        assert "&lt;b&gt;x&lt;/b&gt;" in shown
        assert "&amp;off" in shown
    assert "75.0 %" in named.explain([0.25])._repr_html_()


def test_one_input_is_explained_at_a_time() -> None:
    with pytest.raises(InvalidValue, match="one input"):
        system().explain([[0.1, 0.2], [0.3, 0.4]])
    with pytest.raises(InvalidValue, match="finite"):
        system().explain([0.1, float("nan")])


def test_learners_explain_what_they_predict() -> None:
    rng = np.random.default_rng(0)
    X = rng.normal(size=(80, 2))
    model = fuzzy2.ANFIS(most_epochs=1).fit(X, X[:, 0] - X[:, 1])
    explanation = model.explain(X[3])
    np.testing.assert_allclose(explanation.outputs[0], model.predict(X[3:4])[0])
    assert "not fitted yet" in fuzzy2.ANFIS()._repr_html_()
    assert "x1" in model._repr_html_()
    with pytest.raises(InvalidValue, match="one input"):
        model.explain(X[:2])
    with pytest.raises(fuzzy2.Fuzzy2Error, match="fit"):
        fuzzy2.ANFIS().explain(X[0])
