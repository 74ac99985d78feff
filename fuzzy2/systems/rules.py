"""Rules as text and as objects: ``IF x1 is Low and x2 is High THEN y is Medium``.

Keywords (``IF``, ``is``, ``and``, ``THEN``) are written in any case; names of variables and terms
are compared letter by letter. A name with a blank in it, or one that is a keyword, stands in double
quotes: ``IF "air temperature" is "very low" THEN ...``. An input that a rule does not mention can
be anything. A line that starts with ``#`` is a comment.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fuzzy2.errors import InvalidRule, InvalidValue

Clauses = tuple[tuple[str, str], ...]
"""Pairs of a variable and one of its terms, in the order in which they are written."""

Vocabulary = Mapping[str, Iterable[str]]
"""Names of the terms of each variable, as a dictionary of them or in a list; the order gives them
their numbers.
"""

LEAST_LIKENESS = 0.5
"""Names that have less in common are not suggested: twice the letters that match over all
letters.
"""

KEYWORDS = ("if", "is", "and", "then", "or", "not")

_WORD = re.compile(r'"(?P<quoted>(?:[^"\\]|\\.)*)"(?=\s|$)|(?P<plain>[^\s"]+)(?=\s|$)')


@dataclass(frozen=True)
class Rule:
    """One rule; ``str(rule)`` is its text.

    Parameters
    ----------
    antecedents, consequents : tuple of (variable, term) pairs
        What is asked of the inputs, and what is said of the outputs. A dictionary from variables to
        terms is taken, too.

    Raises
    ------
    InvalidRule
        If there are no antecedents or no consequents, or a variable is mentioned twice.
    """

    antecedents: Clauses
    consequents: Clauses

    def __init__(
        self,
        antecedents: Mapping[str, str] | Iterable[tuple[str, str]],
        consequents: Mapping[str, str] | Iterable[tuple[str, str]],
    ) -> None:
        for side, clauses in (("antecedents", antecedents), ("consequents", consequents)):
            pairs = clauses.items() if isinstance(clauses, Mapping) else clauses
            object.__setattr__(self, side, tuple((variable, term) for variable, term in pairs))
        problem = _problem_of(self)
        if problem:
            raise InvalidRule(1, str(self), problem)

    def __str__(self) -> str:
        both = (
            " and ".join(f"{_quoted(variable)} is {_quoted(term)}" for variable, term in side)
            for side in self._sides
        )
        return "IF {} THEN {}".format(*both)

    @property
    def _sides(self) -> tuple[Clauses, Clauses]:
        return self.antecedents, self.consequents


def parse_rule(text: str, number: int = 1) -> Rule:
    """Return the rule that a line of text states.

    Parameters
    ----------
    text : str
        ``IF <variable> is <term> and ... THEN <variable> is <term> and ...``.
    number : int
        Its number in the rule base, for the error message.

    Returns
    -------
    Rule
        The rule; its names are not looked up.

    Raises
    ------
    InvalidRule
        If the text is no rule, with what was expected at which word.
    """
    reader = _Reader(text, number)
    reader.expect("if")
    antecedents = reader.clauses("then")
    reader.expect("then")
    consequents = reader.clauses(None)
    try:
        return Rule(antecedents, consequents)
    except InvalidRule as error:
        raise InvalidRule(number, reader.text, error.reason) from None


def parse_rules(
    rules: str | Iterable[str | Rule], inputs: Vocabulary, outputs: Vocabulary
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the rules as numbers of terms.

    Parameters
    ----------
    rules : str, or iterable of str and Rule
        Text with a rule a line, or rules as lines and objects. Empty lines and comments (``#``) are
        skipped.
    inputs, outputs : mapping from names to terms
        The terms of each variable by name; a dictionary from terms to sets will do.

    Returns
    -------
    antecedents : (R, p) array of int
        Number of the term of each input, from 0; -1 for an input that the rule does not mention.
    consequents : (R, m) array of int
        Number of the term of each output, from 0.

    Raises
    ------
    InvalidRule
        If a rule cannot be read, uses an unknown name (the nearest known one is suggested), or
        leaves an output out.
    InvalidValue
        If a variable is both an input and an output, or there is no rule.
    """
    known_inputs, known_outputs = (
        {name: list(terms) for name, terms in side.items()} for side in (inputs, outputs)
    )
    shared = sorted(known_inputs.keys() & known_outputs.keys())
    if shared:
        raise InvalidValue("outputs", shared, "variables that are not inputs")
    lines = rules.splitlines() if isinstance(rules, str) else list(rules)
    stated = [
        line
        for line in lines
        if isinstance(line, Rule) or (line.strip() and not line.lstrip().startswith("#"))
    ]
    if not stated:
        raise InvalidValue("rules", rules, "at least one rule")
    antecedents = np.full((len(stated), len(known_inputs)), -1)
    consequents = np.full((len(stated), len(known_outputs)), -1)
    for row, line in enumerate(stated):
        rule = line if isinstance(line, Rule) else parse_rule(line, row + 1)
        text = str(line).strip()
        _number_terms(
            antecedents[row],
            rule.antecedents,
            ("input", known_inputs),
            ("output", known_outputs),
            row + 1,
            text,
        )
        _number_terms(
            consequents[row],
            rule.consequents,
            ("output", known_outputs),
            ("input", known_inputs),
            row + 1,
            text,
        )
        silent = [
            name for name, term in zip(known_outputs, consequents[row], strict=True) if term < 0
        ]
        if silent:
            raise InvalidRule(
                row + 1,
                text,
                f"says nothing about the output {silent[0]!r}; each rule must give every output "
                "a term",
            )
    return antecedents, consequents


def make_rules(
    antecedents: ArrayLike, consequents: ArrayLike, inputs: Vocabulary, outputs: Vocabulary
) -> list[Rule]:
    """Return the rule objects of arrays of numbers of terms; the inverse of :func:`parse_rules`.

    Parameters
    ----------
    antecedents : (R, p) array_like of int
        Number of the term of each input; -1 for an input that is not used.
    consequents : (R, m) array_like of int
        Number of the term of each output.
    inputs, outputs : mapping from names to terms
        The terms of each variable by name.

    Returns
    -------
    list of R Rule
        The rules.

    Raises
    ------
    InvalidValue
        If an array has another shape, or a number is none of a term.
    InvalidRule
        If a rule uses no input.
    """
    sides = [
        _named(name, numbers, {variable: list(terms) for variable, terms in side.items()}, smallest)
        for name, numbers, side, smallest in (
            ("antecedents", antecedents, inputs, -1),
            ("consequents", consequents, outputs, 0),
        )
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
    """Return rules as text, one a line, which :func:`parse_rules` reads back.

    For arguments and errors see :func:`make_rules`.
    """
    return "\n".join(map(str, make_rules(antecedents, consequents, inputs, outputs)))


def nearest_name(name: str, known: Iterable[str]) -> str | None:
    """Return the known name that is most like the given one, or None.

    Upper and lower case are alike. None means that none is like it.
    """
    likeness = {
        candidate: difflib.SequenceMatcher(None, candidate.lower(), name.lower()).ratio()
        for candidate in known
    }
    best = max(likeness, key=lambda candidate: likeness[candidate], default=None)
    return best if best is not None and likeness[best] >= LEAST_LIKENESS else None


def unknown_name(kind: str, name: str, known: Iterable[str]) -> str:
    """Return in words that a name is unknown, and which known one is most like it."""
    suggestion = nearest_name(name, known)
    return f"unknown {kind} {name!r}{f'; did you mean {suggestion!r}?' if suggestion else ''}"


class _Reader:
    """Words of one rule, read one after the other."""

    def __init__(self, text: str, number: int) -> None:
        self.text, self.number, self.next = text.strip(), number, 0
        self.words: list[tuple[str, bool]] = []
        position = 0
        while position < len(self.text):
            word = _WORD.match(self.text, position)
            if word is None:
                raise self.error(
                    f"has a double quote out of place at {self.text[position : position + 20]!r}"
                )
            quoted = word["quoted"]
            self.words.append(
                (word["plain"], False)
                if quoted is None
                else (re.sub(r"\\(.)", r"\1", quoted), True)
            )
            position = word.end()
            while position < len(self.text) and self.text[position].isspace():
                position += 1

    def error(self, reason: str) -> InvalidRule:
        return InvalidRule(self.number, self.text, reason)

    @property
    def keyword(self) -> str | None:
        """Return the next word if it is a keyword, in lower case."""
        if self.next == len(self.words):
            return None
        word, quoted = self.words[self.next]
        return word.lower() if not quoted and word.lower() in KEYWORDS else None

    def expect(self, keyword: str) -> None:
        if self.keyword != keyword:
            raise self.unexpected(keyword.upper() if keyword in ("if", "then") else keyword)
        self.next += 1

    def unexpected(self, *expected: str) -> InvalidRule:
        wanted = " or ".join(f'"{word}"' if word.lower() in KEYWORDS else word for word in expected)
        if self.keyword == "or":
            return self.error('"or" is not known: write one rule for each alternative')
        if self.keyword == "not":
            return self.error('"not" is not known: make the complement a term of its own')
        if self.next == len(self.words):
            return self.error(f"ends where {wanted} is expected")
        before = " ".join(word for word, _ in self.words[: self.next][-3:])
        where = f'after "{before}"' if before else "at its start"
        return self.error(f"has {self.words[self.next][0]!r} {where}, where {wanted} is expected")

    def name(self, kind: str) -> str:
        if self.next == len(self.words) or self.keyword is not None:
            raise self.unexpected(f"the name of a {kind}")
        self.next += 1
        return self.words[self.next - 1][0]

    def clauses(self, end: str | None) -> Clauses:
        """Return the clauses up to a keyword, or to the end of the text."""
        found = []
        while True:
            variable = self.name("variable")
            self.expect("is")
            found.append((variable, self.name("term")))
            if self.keyword == end and (end is not None or self.next == len(self.words)):
                return tuple(found)
            if self.keyword != "and":
                raise self.unexpected("and", *([end.upper()] if end else ["the end"]))
            self.next += 1


def _problem_of(rule: Rule) -> str | None:
    for name, clauses in (("IF", rule.antecedents), ("THEN", rule.consequents)):
        if not clauses:
            return f"has nothing after {name}"
        variables = [variable for variable, _ in clauses]
        twice = next((variable for variable in variables if variables.count(variable) > 1), None)
        if twice is not None:
            return f"mentions {twice!r} twice after {name}"
        broken = next(
            (
                word
                for clause in clauses
                for word in clause
                if word.splitlines() not in ([word], [])
            ),
            None,
        )
        if broken is not None:
            return f"has a line break in the name {broken!r}"
    return None


def _quoted(name: str) -> str:
    if name and not re.search(r'[\s"]', name) and name.lower() not in KEYWORDS:
        return name
    return '"' + re.sub(r'(["\\])', r"\\\1", name) + '"'


def _number_terms(
    row: NDArray[np.int64],
    clauses: Clauses,
    side: tuple[str, dict[str, list[str]]],
    other_side: tuple[str, dict[str, list[str]]],
    number: int,
    text: str,
) -> None:
    """Write the numbers of the terms of one side of a rule into its row."""
    (kind, known), (other_kind, others) = side, other_side
    places = {name: place for place, name in enumerate(known)}
    for variable, term in clauses:
        if variable in others:
            reason = f"uses the {other_kind} {variable!r} as an {kind}"
            raise InvalidRule(number, text, f"{reason}; the {kind}s are {', '.join(known)}")
        if variable not in known:
            raise InvalidRule(
                number,
                text,
                _unknown(f"there is no {kind} {variable!r}", f"{kind}s", variable, known),
            )
        if term not in known[variable]:
            raise InvalidRule(
                number,
                text,
                _unknown(
                    f"{kind} {variable!r} has no term {term!r}", "terms", term, known[variable]
                ),
            )
        row[places[variable]] = known[variable].index(term)


def _unknown(what: str, kinds: str, name: str, known: Iterable[str]) -> str:
    suggestion = nearest_name(name, known)
    return (
        f"{what}{f'; did you mean {suggestion!r}?' if suggestion else ''} (known {kinds}: "
        f"{', '.join(known) or 'none'})"
    )


def _named(
    name: str, numbers: ArrayLike, known: dict[str, list[str]], smallest: int
) -> list[Clauses]:
    table = np.asarray(numbers)
    if table.ndim != 2 or table.shape[1] != len(known) or table.dtype.kind not in "iu":
        raise InvalidValue(name, table, f"whole numbers of shape (R, {len(known)})")
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
