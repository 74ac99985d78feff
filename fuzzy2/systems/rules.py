"""Rules as text and as objects: ``IF x1 is Low and x2 is not High THEN y is Medium``.

An antecedent joins clauses with ``and``, ``or``, ``not`` and parentheses; ``and`` binds tighter
than ``or``. A term may be negated and hedged, as in ``x1 is not very Low``
(:mod:`fuzzy2.systems.hedges`), and ``x1 is any`` always holds. After ``THEN`` come terms of outputs
or their complements, as in ``y is not Small``; a rule may leave outputs out. The terms after
``ELSE`` are concluded to the degree to which the antecedent does not hold, and ``with 0.5`` gives
the weight of the rule, a factor of its firing::

    IF (x1 is Low or x2 is very High) and x1 is not Medium THEN y is Small ELSE y is Large with 0.5

Keywords and hedges are case-insensitive; names of variables and terms are case-sensitive. A name
that contains a blank or a parenthesis, or that is a keyword, must be in double quotes: ``IF "air
temperature" is "very low" THEN ...``. An input that a rule does not mention can have any value. A
``#`` at the start of a line or after a blank begins a comment.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fuzzy2.errors import InvalidRule, InvalidValue
from fuzzy2.support.checks import listed, of_kind, reals, share
from fuzzy2.systems.antecedents import (
    And,
    Antecedent,
    Hedged,
    Is,
    Not,
    Or,
    clauses_of,
    leaves,
    mapped,
    rows_of,
)
from fuzzy2.systems.hedges import ANY, HEDGES, Hedge

KEYWORDS = ("if", "is", "and", "then", "or", "not", "else", "with")


class Negated(NamedTuple):
    """Complement of a term, in the consequent of a rule."""

    term: str


Clauses: TypeAlias = tuple[tuple[str, str], ...]
"""Pairs of a variable and one of its terms, in the order in which they are written."""

Conclusions: TypeAlias = tuple[tuple[str, str | Negated], ...]
"""Pairs of an output and its term, which may be negated."""

Vocabulary = Mapping[str, Iterable[str]]
"""Names of the terms of each variable, as a dictionary or a list; their order determines their
numbers."""

LEAST_LIKENESS = 0.5
"""Names with a smaller similarity, twice the matching letters over all letters, are not suggested.
"""


@dataclass(frozen=True)
class Rule:
    """One rule; ``str(rule)`` is its text.

    Parameters
    ----------
    antecedents : tuple of (variable, term) pairs, or a tree
        Conditions on the inputs: pairs that must all hold, or a tree of
        :mod:`fuzzy2.systems.antecedents` with names. A dictionary from variables to terms is
        accepted, too. A tree that is a plain conjunction is converted to pairs.
    consequents : tuple of (variable, term) pairs
        Terms of the outputs; a term may be :class:`Negated`. A dictionary is accepted, too.
    weight : float
        Factor of the rule's firing, in [0, 1].
    otherwise : tuple of (variable, term) pairs
        Terms of the outputs to the degree to which the antecedent does not hold.

    Raises
    ------
    InvalidRule
        If there are no antecedents or no consequents, if a variable occurs in two pairs, or if the
        weight is out of range.
    """

    antecedents: Clauses | Antecedent
    consequents: Conclusions
    weight: float = 1.0
    otherwise: Conclusions = ()

    def __init__(
        self,
        antecedents: Mapping[str, str] | Iterable[tuple[str, str]] | Antecedent,
        consequents: Mapping[str, str | Negated] | Iterable[tuple[str, str | Negated]],
        weight: float = 1.0,
        otherwise: Mapping[str, str | Negated] | Iterable[tuple[str, str | Negated]] = (),
    ) -> None:
        object.__setattr__(self, "antecedents", _simplest(antecedents))
        object.__setattr__(self, "weight", share("weight", weight))
        for side, clauses in (("consequents", consequents), ("otherwise", otherwise)):
            object.__setattr__(self, side, _pairs(side, clauses))
        problem = _problem_of(self)
        if problem:
            raise InvalidRule(1, str(self), problem)

    @property
    def tree(self) -> Antecedent:
        """The antecedent as a tree with names."""
        if not isinstance(self.antecedents, tuple):
            return self.antecedents
        clauses = tuple(Is(variable, term) for variable, term in self.antecedents)
        return clauses[0] if len(clauses) == 1 else And(clauses)

    def __str__(self) -> str:
        if isinstance(self.antecedents, tuple):
            asked = " and ".join(_clause(variable, term) for variable, term in self.antecedents)
        else:
            asked = antecedent_in_words(self.antecedents)
        text = f"IF {asked} THEN {_conclusions(self.consequents)}"
        if self.otherwise:
            text += f" ELSE {_conclusions(self.otherwise)}"
        return text if self.weight == 1.0 else f"{text} with {self.weight!r}"


class RuleBase(NamedTuple):
    """Rules with numbers of inputs and terms.

    ``trees`` are the antecedents of R rules. ``said`` (R, m) holds the number of each output's
    term, or -1 where a rule has no consequent; ``negated`` (R, m) tells whether its complement is
    meant. ``weights`` (R,) are factors of the firing.
    """

    trees: tuple[Antecedent, ...]
    said: NDArray[np.int64]
    negated: NDArray[np.bool_]
    weights: NDArray[np.float64]


def parse_rule(text: str, number: int = 1, hedges: Mapping[str, Hedge] = HEDGES) -> Rule:
    """Return the rule that a line of text states.

    Parameters
    ----------
    text : str
        ``IF <variable> is <term> and ... THEN <variable> is <term> and ...``; see above.
    number : int
        Number of the rule in the rule base, for the error message.
    hedges : mapping from words to Hedge
        Hedges by their words in lower case.

    Returns
    -------
    Rule
        The rule; its names are not checked.

    Raises
    ------
    InvalidRule
        If the text is not a rule; the message names the word and what was expected there.
    """
    from fuzzy2.systems.rule_grammar import parsed

    stripped = text.strip()
    words = parsed(stripped, number, hedges)
    said, otherwise = (
        tuple((variable, Negated(term) if negated else term) for variable, term, negated in side)
        for side in (words.said, words.otherwise)
    )
    try:
        return Rule(words.asked, said, words.weight, otherwise)
    except InvalidRule as error:
        raise InvalidRule(number, stripped, error.reason) from None


def read_rule_base(
    rules: str | Iterable[str | Rule],
    inputs: Vocabulary,
    outputs: Vocabulary,
    hedges: Mapping[str, Hedge] = HEDGES,
) -> RuleBase:
    """Return rules with numbers; a rule with ``ELSE`` becomes two.

    Parameters
    ----------
    rules : str, or iterable of str and Rule
        Text with one rule per line, or rules as lines and objects. Empty lines and comments (``#``)
        are skipped.
    inputs, outputs : mapping from names to terms
        The terms of each variable by name, for instance as dictionaries from terms to sets.
    hedges : mapping from words to Hedge
        Hedges by their words in lower case.

    Returns
    -------
    RuleBase
        The rules.

    Raises
    ------
    InvalidRule
        If a rule cannot be read, or uses an unknown name (the nearest known one is suggested).
    InvalidValue
        If a variable is both an input and an output, or there is no rule.
    """
    known_inputs, known_outputs = _words("inputs", inputs), _words("outputs", outputs)
    shared = sorted(known_inputs.keys() & known_outputs.keys())
    if shared:
        raise InvalidValue("outputs", shared, "variables that are not inputs")
    requirement = "text with a rule a line, or a list of rules"
    lines = rules.splitlines() if isinstance(rules, str) else listed("rules", rules, requirement)
    for line in lines:
        of_kind("rules", line, (Rule, str), requirement)
    stated = [
        line
        for line in lines
        if isinstance(line, Rule) or (line.strip() and not line.lstrip().startswith("#"))
    ]
    if not stated:
        raise InvalidValue("rules", rules, "at least one rule")
    trees: list[Antecedent] = []
    said: list[tuple[list[int], list[bool]]] = []
    weights = []
    for number, line in enumerate(stated, start=1):
        rule = line if isinstance(line, Rule) else parse_rule(line, number, hedges)
        text = str(line).strip()
        lookup = _Lookup(number, text, known_inputs, known_outputs)
        tree = mapped(rule.tree, lookup.asked)
        for asked, conclusions in ((tree, rule.consequents), (Not(tree), rule.otherwise)):
            if conclusions:
                trees.append(asked)
                said.append(lookup.said(conclusions))
                weights.append(rule.weight)
    return RuleBase(
        tuple(trees),
        np.array([numbers for numbers, _ in said], dtype=np.int64),
        np.array([negated for _, negated in said], dtype=bool),
        np.array(weights),
    )


def parse_rules(
    rules: str | Iterable[str | Rule], inputs: Vocabulary, outputs: Vocabulary
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return rules whose antecedents are conjunctions, as numbers of terms.

    Parameters
    ----------
    rules, inputs, outputs
        See :func:`read_rule_base`.

    Returns
    -------
    antecedents : (R, p) array of int
        Number of the term of each input, from 0; -1 for an input that the rule does not mention.
    consequents : (R, m) array of int
        Number of the term of each output, from 0; -1 where the rule has no consequent for an
        output.

    Raises
    ------
    InvalidRule
        If a rule cannot be read, uses an unknown name, or cannot be expressed with numbers of
        terms.
    InvalidValue
        See :func:`read_rule_base`.
    """
    base = read_rule_base(rules, inputs, outputs)
    for number, (tree, negated, weight) in enumerate(
        zip(base.trees, base.negated, base.weights, strict=True), start=1
    ):
        if clauses_of(tree) is None or negated.any() or weight != 1.0:
            raise InvalidRule(
                number,
                str(tree),
                "says more than terms joined by and, which numbers of terms cannot hold; give the "
                "rules to a system as they are",
            )
    rows = rows_of(base.trees, len(inputs))
    assert rows is not None
    return rows, base.said


def make_rules(
    antecedents: ArrayLike, consequents: ArrayLike, inputs: Vocabulary, outputs: Vocabulary
) -> list[Rule]:
    """Return the rule objects for arrays of numbers of terms; the inverse of :func:`parse_rules`.

    Parameters
    ----------
    antecedents : (R, p) array_like of int
        Number of the term of each input; -1 for an input that is not used.
    consequents : (R, m) array_like of int
        Number of the term of each output; -1 where the rule has no consequent for an output.
    inputs, outputs : mapping from names to terms
        The terms of each variable by name.

    Returns
    -------
    list of R Rule
        The rules.

    Raises
    ------
    InvalidValue
        If an array has a wrong shape, or a number is not that of a term.
    InvalidRule
        If a rule has no antecedent or no consequent.
    """
    sides = [
        _named("antecedents", antecedents, _words("inputs", inputs), -1),
        _named("consequents", consequents, _words("outputs", outputs), -1),
    ]
    if len(sides[0]) != len(sides[1]):
        raise InvalidValue(
            "consequents", len(sides[1]), f"as many as the antecedents, {len(sides[0])}"
        )
    made = []
    for number, (asked, said) in enumerate(zip(*sides, strict=True), start=1):
        try:
            made.append(Rule(asked, said))
        except InvalidRule as error:
            raise InvalidRule(number, error.text, error.reason) from None
    return made


def format_rules(
    antecedents: ArrayLike, consequents: ArrayLike, inputs: Vocabulary, outputs: Vocabulary
) -> str:
    """Return rules as text with one rule per line, which :func:`parse_rules` reads back.

    For arguments and errors see :func:`make_rules`.
    """
    return "\n".join(map(str, make_rules(antecedents, consequents, inputs, outputs)))


def nearest_name(name: str, known: Iterable[str]) -> str | None:
    """Return the known name that is most similar to a given one, or None.

    The case is ignored. The result is None if no known name is similar.
    """
    likeness = {
        candidate: difflib.SequenceMatcher(None, candidate.lower(), name.lower()).ratio()
        for candidate in known
    }
    best = max(likeness, key=lambda candidate: likeness[candidate], default=None)
    return best if best is not None and likeness[best] >= LEAST_LIKENESS else None


def unknown_name(kind: str, name: str, known: Iterable[str]) -> str:
    """Return a message that a name is unknown, with the most similar known name."""
    suggestion = nearest_name(name, known)
    return f"unknown {kind} {name!r}{f'; did you mean {suggestion!r}?' if suggestion else ''}"


def _words(side: str, variables: Vocabulary) -> dict[str, list[str]]:
    """Return the terms of each variable by name."""
    requirement = "a mapping from names of variables to their terms"
    of_kind(side, variables, Mapping, requirement)
    return {name: list(listed(side, terms, requirement)) for name, terms in variables.items()}


def _simplest(asked: Any) -> Clauses | Antecedent:
    """Return pairs if they express the tree, otherwise the tree."""
    if isinstance(asked, Is | And | Or | Not | Hedged):
        clauses = clauses_of(asked)
        if clauses is None or any(clause.term is None for clause in clauses):
            return asked
        return tuple((str(clause.variable), str(clause.term)) for clause in clauses)
    return _pairs("antecedents", asked)


def _pairs(side: str, clauses: Any) -> Clauses:
    """Return one side of a rule as pairs of a variable and its term, both by name."""
    requirement = "a mapping from variables to terms, or pairs of these"
    given = clauses.items() if isinstance(clauses, Mapping) else clauses
    pairs = tuple(listed(side, pair, requirement) for pair in listed(side, given, requirement))
    if not all(
        len(pair) == 2 and isinstance(pair[0], str) and isinstance(pair[1], str | Negated)
        for pair in pairs
    ):
        raise InvalidValue(side, clauses, requirement)
    return pairs


def _problem_of(rule: Rule) -> str | None:
    asked = rule.antecedents
    pairs = (
        asked
        if isinstance(asked, tuple)
        else tuple((leaf.variable, leaf.term) for leaf in leaves(asked))
    )
    sides = [("IF", pairs, isinstance(asked, tuple)), ("THEN", rule.consequents, True)]
    if rule.otherwise:
        sides.append(("ELSE", rule.otherwise, True))
    for name, clauses, once in sides:
        if not clauses:
            return f"has nothing after {name}"
        variables = [variable for variable, _ in clauses]
        twice = next((variable for variable in variables if variables.count(variable) > 1), None)
        if twice is not None and once:
            return f"mentions {twice!r} twice after {name}"
        names: list[Any] = [word for clause in clauses for word in (clause[0], _term_of(clause[1]))]
        broken = next(
            (word for word in names if word is not None and word.splitlines() not in ([word], [])),
            None,
        )
        if broken is not None:
            return f"has a line break in the name {broken!r}"
    return None if 0.0 <= rule.weight <= 1.0 else f"has the weight {rule.weight}, not in [0, 1]"


def _term_of(said: Any) -> Any:
    return said.term if isinstance(said, Negated) else said


def quoted(name: str) -> str:
    """Return a name as it is written in a rule."""
    plain = name and not re.search(r'[\s"()]', name) and not name.startswith("#")
    if plain and name.lower() not in (*KEYWORDS, ANY):
        return name
    return '"' + re.sub(r'(["\\])', r"\\\1", name) + '"'


def _clause(variable: Any, term: Any) -> str:
    if term is None:
        return f"{quoted(variable)} is {ANY}"
    if isinstance(term, Negated):
        return f"{quoted(variable)} is not {quoted(term.term)}"
    return f"{quoted(variable)} is {quoted(term)}"


def _conclusions(clauses: Conclusions) -> str:
    return " and ".join(_clause(variable, term) for variable, term in clauses)


def antecedent_in_words(tree: Antecedent, within: str = "or") -> str:
    """Return a tree in words, with parentheses where an operator around it binds tighter."""
    match tree:
        case Is(variable, term):
            return _clause(variable, term)
        case And(parts):
            text = " and ".join(antecedent_in_words(part, "and") for part in parts)
            return f"({text})" if within != "or" and len(parts) > 1 else text
        case Or(parts):
            text = " or ".join(antecedent_in_words(part, "in or") for part in parts)
            return f"({text})" if within != "or" and len(parts) > 1 else text
    words: list[str] = []
    inner: Antecedent = tree
    while isinstance(inner, Not | Hedged):
        words.append("not" if isinstance(inner, Not) else inner.hedge.name)
        inner = inner.part
    if isinstance(inner, Is):
        term = ANY if inner.term is None else quoted(str(inner.term))
        return f"{quoted(str(inner.variable))} is {' '.join(words)} {term}"
    if isinstance(tree, Not):
        return f"not ({antecedent_in_words(tree.part)})"
    # A hedged group has no shorter form in words than the group of its hedged parts.
    raise InvalidValue("antecedents", tree, "hedges of single terms; a group in words has none")


class _Lookup:
    """Looks up the numbers of the names in one rule."""

    def __init__(
        self,
        number: int,
        text: str,
        inputs: dict[str, list[str]],
        outputs: dict[str, list[str]],
    ) -> None:
        self.number, self.text = number, text
        self.inputs, self.outputs = inputs, outputs
        self.places = {name: place for place, name in enumerate(inputs)}

    def asked(self, clause: Is) -> Is:
        variable, term = str(clause.variable), clause.term
        if term is None:
            self.check_variable(variable, "input")
            return Is(self.places[variable], None)
        return Is(self.places.get(variable, -1), self.term(variable, str(term), "input"))

    def said(self, conclusions: Conclusions) -> tuple[list[int], list[bool]]:
        numbers = {
            variable: self.term(variable, _term_of(term), "output")
            for variable, term in conclusions
        }
        negated = {variable for variable, term in conclusions if isinstance(term, Negated)}
        return (
            [numbers.get(name, -1) for name in self.outputs],
            [name in negated for name in self.outputs],
        )

    def check_variable(self, variable: str, kind: str) -> dict[str, list[str]]:
        known, others = self.inputs, self.outputs
        other_kind = "output"
        if kind == "output":
            known, others, other_kind = others, known, "input"
        if variable in others:
            reason = f"uses the {other_kind} {variable!r} as an {kind}"
            raise InvalidRule(
                self.number, self.text, f"{reason}; the {kind}s are {', '.join(known)}"
            )
        if variable not in known:
            reason = _unknown(f"there is no {kind} {variable!r}", f"{kind}s", variable, known)
            raise InvalidRule(self.number, self.text, reason)
        return known

    def term(self, variable: str, term: str, kind: str) -> int:
        known = self.check_variable(variable, kind)[variable]
        if term not in known:
            reason = _unknown(f"{kind} {variable!r} has no term {term!r}", "terms", term, known)
            raise InvalidRule(self.number, self.text, reason)
        return known.index(term)


def _unknown(what: str, kinds: str, name: str, known: Iterable[str]) -> str:
    suggestion = nearest_name(name, known)
    return (
        f"{what}{f'; did you mean {suggestion!r}?' if suggestion else ''} (known {kinds}: "
        f"{', '.join(known) or 'none'})"
    )


def _named(
    name: str, numbers: ArrayLike, known: dict[str, list[str]], smallest: int
) -> list[Clauses]:
    requirement = f"whole numbers of shape (R, {len(known)})"
    reals(name, numbers, requirement)
    table = np.asarray(numbers)
    if table.ndim != 2 or table.shape[1] != len(known) or table.dtype.kind not in "iu":
        raise InvalidValue(name, table, requirement)
    sizes = np.array([len(terms) for terms in known.values()])
    if not ((table >= smallest) & (table < sizes)).all():
        raise InvalidValue(name, table, f"numbers of terms from {smallest}, below {sizes.tolist()}")
    return [
        tuple(
            (variable, terms[term])
            for (variable, terms), term in zip(known.items(), row, strict=True)
            if term >= 0
        )
        for row in table.tolist()
    ]
