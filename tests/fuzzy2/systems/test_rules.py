"""Rules as text.

What is read is compared with tables written by hand, and with what hypothesis made the text from.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzy2.errors import InvalidRule, InvalidValue
from fuzzy2.systems.antecedents import And, Antecedent, Hedged, Is, Not, Or
from fuzzy2.systems.hedges import HEDGES
from fuzzy2.systems.rules import (
    KEYWORDS,
    Negated,
    Rule,
    format_rules,
    make_rules,
    nearest_name,
    parse_rule,
    parse_rules,
    read_rule_base,
)

INPUTS = {"x1": ["Low", "Medium", "High"], "x2": ["Low", "High"]}
OUTPUTS = {"y": ["Small", "Large"]}
TWO_OUTPUTS = {"y1": ["A", "B"], "y2": ["A", "B", "C"]}


def test_a_rule_base_becomes_two_tables() -> None:
    text = """
    # corners first
    IF x1 is Low and x2 is Low THEN y is Small
    if X2 IS High AND X1 iS Medium then y Is Large

    If X2 is High THEN y is Small
    """.replace("X", "x")
    antecedents, consequents = parse_rules(text, INPUTS, OUTPUTS)
    np.testing.assert_array_equal(antecedents, [[0, 0], [1, 1], [-1, 1]])
    np.testing.assert_array_equal(consequents, [[0], [1], [0]])
    assert antecedents.dtype == np.int64


def test_several_outputs_in_any_order() -> None:
    lines = ["IF x1 is Low THEN y2 is C and y1 is B", Rule({"x2": "High"}, {"y1": "A", "y2": "B"})]
    antecedents, consequents = parse_rules(lines, INPUTS, TWO_OUTPUTS)
    np.testing.assert_array_equal(antecedents, [[0, -1], [-1, 1]])
    np.testing.assert_array_equal(consequents, [[1, 2], [0, 1]])


def test_terms_may_be_given_with_their_sets() -> None:
    inputs = {"x1": {"Low": object(), "High": object()}}
    antecedents, _ = parse_rules("IF x1 is High THEN y is Large", inputs, OUTPUTS)
    np.testing.assert_array_equal(antecedents, [[1]])


def test_names_that_are_no_words_stand_in_quotes() -> None:
    rule = parse_rule(r'IF "air temperature" is "very \"low\"" and "is" is a\b THEN "then" is "#"')
    assert rule == Rule({"air temperature": 'very "low"', "is": r"a\b"}, {"then": "#"})
    assert parse_rule(str(rule)) == rule


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("x1 is Low THEN y is Small", "has 'x1' at its start, where \"IF\" is expected"),
        ("IF x1 is Low", 'ends where "and" or "THEN" is expected'),
        ("IF x1 Low THEN y is Small", 'has \'Low\' after "IF x1", where "is" is expected'),
        ("IF x1 is THEN y is Small", "where the name of a term is expected"),
        ("IF THEN y is Small", "has 'THEN' after \"IF\", where the name of a variable is expected"),
        ("IF x1 is Low THEN", "ends where the name of a variable is expected"),
        ("IF x1 is Low and THEN y is Small", "the name of a variable is expected"),
        ("IF x1 is Low THEN y is Small THEN y is Large", 'where "and" or the end is expected'),
        ("IF (x1 is Low or x2 is Low THEN y is Small", "a closing parenthesis is expected"),
        ("IF x1 is not THEN y is Small", "the name of a term is expected"),
        ("IF x1 is vrey Low THEN y is Small", "has 'vrey' before 'Low', which is not a hedge"),
        ("IF x1 is Low THEN y is very Small", "hedges belong to the antecedent"),
        ("IF x1 is Low THEN y is Small with 2", "has the weight '2', which must be a number"),
        ("IF x1 is Low THEN y is Small ELSE", "the name of a variable is expected"),
        ('IF "x1 is Low THEN y is Small', "double quote out of place"),
        ('IF x1 is Low"er" THEN y is Small', "double quote out of place at 'Low"),
        ("IF x1 is Low THEN y is Small and y is Large", "mentions 'y' twice after THEN"),
        ("IF x1 is Lwo THEN y is Small", "did you mean 'Low'? (known terms: Low, Medium, High)"),
        ("IF x1 is low THEN y is Small", "input 'x1' has no term 'low'; did you mean 'Low'?"),
        (
            "IF x3 is Low THEN y is Small",
            "there is no input 'x3'; did you mean 'x1'? (known inputs: x1, x2)",
        ),
        ("IF qqq is Low THEN y is Small", "there is no input 'qqq' (known inputs: x1, x2)"),
        ("IF x1 is Low THEN y is Smal", "output 'y' has no term 'Smal'; did you mean 'Small'?"),
        ("IF x1 is Low THEN x2 is High", "uses the input 'x2' as an output; the outputs are y"),
        ("IF y is Small THEN y is Large", "uses the output 'y' as an input; the inputs are x1, x2"),
    ],
)
def test_what_is_wrong_is_said_with_the_rule(text: str, said: str) -> None:
    good = "IF x1 is Low THEN y is Small"
    with pytest.raises(InvalidRule) as caught:
        parse_rules([good, "  " + text], INPUTS, OUTPUTS)
    assert said in str(caught.value)
    assert str(caught.value).startswith(f"rule 2 ({text}) ")
    assert (caught.value.number, caught.value.text) == (2, text)


def test_of_an_output_that_is_left_out_a_rule_says_nothing() -> None:
    _, consequents = parse_rules("IF x1 is Low THEN y1 is A", INPUTS, TWO_OUTPUTS)
    np.testing.assert_array_equal(consequents, [[0, -1]])


@pytest.mark.parametrize(
    "asked",
    ["x1 is Low or x2 is Low", "x1 is not Low", "x1 is very Low", "x1 is Low and x1 is High"],
)
def test_numbers_of_terms_cannot_hold_trees(asked: str) -> None:
    with pytest.raises(InvalidRule, match="says more than terms joined by and"):
        parse_rules(f"IF {asked} THEN y is Small", INPUTS, OUTPUTS)


def test_a_rule_is_read_as_a_tree() -> None:
    """``and`` before ``or``, hedges from right to left, ``ELSE`` as a second rule."""
    text = (
        "if (x1 is Low or x2 is not VERY High) and x1 is more  or less Medium "
        "then y is Small else y is not Large with .5  # a comment"
    )
    base = read_rule_base(text, INPUTS, OUTPUTS)
    very, roughly = HEDGES["very"], HEDGES["more or less"]
    tree = And((Or((Is(0, 0), Not(Hedged(very, Is(1, 1))))), Hedged(roughly, Is(0, 1))))
    assert base.trees == (tree, Not(tree))
    assert base.said.tolist() == [[0], [1]]
    assert base.negated.tolist() == [[False], [True]]
    assert base.weights.tolist() == [0.5, 0.5]
    loose = parse_rule("IF x1 is Low or x1 is High and x2 is any THEN y is Small").tree
    assert loose == Or((Is("x1", "Low"), And((Is("x1", "High"), Is("x2", None)))))


def test_weights_and_parentheses_as_matlab_shows_rules() -> None:
    rule = parse_rule("If (x1 is Low) and (x2 is High) then (y is Small) (0.25)")
    assert rule == Rule({"x1": "Low", "x2": "High"}, {"y": "Small"}, 0.25)


_words = st.sampled_from(["a", "b c", "if", "any", "(x)"])
_trees = st.recursive(
    st.builds(Is, _words, _words | st.none()),
    lambda parts: (
        st.builds(lambda some: And(tuple(some)), st.lists(parts, min_size=2, max_size=3))
        | st.builds(lambda some: Or(tuple(some)), st.lists(parts, min_size=2, max_size=3))
        | st.builds(Not, parts)
        | st.builds(Hedged, st.sampled_from(list(HEDGES.values())), st.builds(Is, _words, _words))
    ),
    max_leaves=8,
)


@given(_trees, st.floats(0.0, 1.0), st.booleans())
def test_a_tree_in_words_is_read_back(tree: Antecedent, weight: float, otherwise: bool) -> None:
    rule = Rule(
        tree, {"y": Negated("very"), "z": "with"}, weight, {"y": "else"} if otherwise else {}
    )
    assert parse_rule(str(rule)) == rule


def test_rule_bases_that_make_no_sense() -> None:
    with pytest.raises(InvalidValue, match="at least one rule"):
        parse_rules("# nothing\n\n", INPUTS, OUTPUTS)
    with pytest.raises(InvalidValue, match="not inputs"):
        parse_rules("IF x1 is Low THEN x1 is Low", INPUTS, {"x1": ["Low"]})


def test_a_rule_object_must_say_something() -> None:
    with pytest.raises(InvalidRule, match="has nothing after IF"):
        Rule({}, {"y": "Small"})
    with pytest.raises(InvalidRule, match="has nothing after THEN"):
        Rule({"x": "Low"}, {})
    with pytest.raises(InvalidRule, match="has a line break in the name"):
        Rule({"x": "Low\nHigh"}, {"y": "Small"})


def test_tables_that_are_none() -> None:
    with pytest.raises(InvalidValue, match=r"antecedents must be whole numbers of shape \(R, 2\)"):
        make_rules([[0.5, 1.0]], [[0]], INPUTS, OUTPUTS)
    with pytest.raises(
        InvalidValue, match=r"antecedents must be numbers of terms from -1, below \[3, 2\]"
    ):
        make_rules([[0, 2]], [[0]], INPUTS, OUTPUTS)
    with pytest.raises(InvalidValue, match="consequents must be numbers of terms from -1"):
        make_rules([[0, 1]], [[-2]], INPUTS, OUTPUTS)
    with pytest.raises(InvalidRule, match="has nothing after THEN"):
        make_rules([[0, 1]], [[-1]], INPUTS, OUTPUTS)
    with pytest.raises(InvalidValue, match="as many as the antecedents"):
        make_rules([[0, 1]], [[0], [1]], INPUTS, OUTPUTS)
    with pytest.raises(InvalidRule, match=r"rule 2 .* has nothing after IF"):
        make_rules([[0, 1], [-1, -1]], [[0], [1]], INPUTS, OUTPUTS)


def test_the_nearest_name_ignores_case_first() -> None:
    assert nearest_name("HIGH", ["Low", "High"]) == "High"
    assert nearest_name("Hgih", ["Low", "High"]) == "High"
    assert nearest_name("zzz", ["Low", "High"]) is None


names = st.text(st.characters(exclude_categories=("Cs",)), max_size=6).filter(
    lambda name: name.splitlines() in ([name], [])
)
names = names | st.sampled_from([*KEYWORDS, "IF", "Then", 'a"b', "a b", "\\", '"', "#x"])


@st.composite
def rule_bases(
    draw: st.DrawFn,
) -> tuple[np.ndarray, np.ndarray, dict[str, list[str]], dict[str, list[str]]]:
    variables = draw(st.lists(names, min_size=2, max_size=5, unique=True))
    terms = {
        variable: draw(st.lists(names, min_size=1, max_size=4, unique=True))
        for variable in variables
    }
    p = draw(st.integers(1, len(variables) - 1))
    inputs, outputs = (
        {name: terms[name] for name in side} for side in (variables[:p], variables[p:])
    )
    rows = draw(st.integers(1, 5))
    sizes, output_sizes = ([len(side[name]) for name in side] for side in (inputs, outputs))
    antecedents = np.array(
        [[draw(st.integers(-1, size - 1)) for size in sizes] for _ in range(rows)]
    )
    antecedents[(antecedents < 0).all(axis=1), 0] = 0
    consequents = np.array(
        [[draw(st.integers(0, size - 1)) for size in output_sizes] for _ in range(rows)]
    )
    return antecedents, consequents, inputs, outputs


@given(rule_bases())
def test_formatting_and_parsing_are_inverse(
    rule_base: tuple[np.ndarray, np.ndarray, dict[str, list[str]], dict[str, list[str]]],
) -> None:
    antecedents, consequents, inputs, outputs = rule_base
    text = format_rules(antecedents, consequents, inputs, outputs)
    found = parse_rules(text, inputs, outputs)
    np.testing.assert_array_equal(found[0], antecedents)
    np.testing.assert_array_equal(found[1], consequents)
    assert (
        parse_rules(make_rules(*found, inputs, outputs), inputs, outputs)[0].tolist()
        == antecedents.tolist()
    )


@given(
    st.text(max_size=40)
    | st.lists(
        st.sampled_from(["IF", "x1", "is", "Low", "and", "THEN", "y", "Small", '"', "not"])
    ).map(" ".join)
)
def test_any_text_is_a_rule_or_an_invalid_rule(text: str) -> None:
    try:
        rule = parse_rule(text)
    except InvalidRule:
        return
    assert parse_rule(str(rule)) == rule
