"""Grammar of rules in words, which :mod:`fuzzy2.systems.rules` uses."""

from __future__ import annotations

import functools
import re
from collections.abc import Mapping
from typing import Any, NamedTuple

from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedCharacters, UnexpectedToken

from fuzzy2.errors import InvalidRule
from fuzzy2.support.number_text import number_of
from fuzzy2.systems.antecedents import And, Antecedent, Hedged, Is, Not, Or
from fuzzy2.systems.hedges import ANY, Hedge

_END = r'(?=[\s"()]|$)'
_GRAMMAR = rf"""
rule: IF either THEN said [ELSE said] [weight]
?either: both (OR both)*
?both: one (AND one)*
?one: NOT one -> negated
    | "(" either ")"
    | clause
clause: _name IS words
words: (NOT | MORE_OR_LESS | WORD | QUOTED)+
_name: WORD | QUOTED
said: _conclusion (AND _conclusion)*
_conclusion: clause | "(" clause ")"
weight: WITH WORD | "(" WORD ")"

MORE_OR_LESS.3: /more\s+or\s+less{_END}/i
IF.2: /if{_END}/i
IS.2: /is{_END}/i
AND.2: /and{_END}/i
OR.2: /or{_END}/i
NOT.2: /not{_END}/i
THEN.2: /then{_END}/i
ELSE.2: /else{_END}/i
WITH.2: /with{_END}/i
WORD: /[^\s"()#][^\s"()]*(?=[\s()]|$)/
QUOTED: /"(?:[^"\\]|\\.)*"(?=[\s()]|$)/
COMMENT: /#.*/s
SPACE: /\s+/
%ignore COMMENT
%ignore SPACE
"""
_TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|[()]|[^\s"()]+')
_SHOWN = {
    "IF": '"IF"',
    "IS": '"is"',
    "AND": '"and"',
    "RPAR": "a closing parenthesis",
    "THEN": '"THEN"',
    "$END": "the end",
}


class Words(NamedTuple):
    """A rule as it is written, with names."""

    asked: Antecedent
    said: tuple[tuple[str, str, bool], ...]
    otherwise: tuple[tuple[str, str, bool], ...]
    weight: float


@functools.cache
def _parser() -> Lark:
    return Lark(_GRAMMAR, start="rule", parser="lalr", lexer="basic", propagate_positions=True)


def parsed(text: str, number: int, hedges: Mapping[str, Hedge]) -> Words:
    """Return the rule that a line of text states.

    Raises
    ------
    InvalidRule
        If the text is not a rule; the message names the word and what was expected there.
    """
    return _Reader(text, number, hedges).rule(_tree(text, number))


def parsed_hedged(
    text: str, number: int, hedges: Mapping[str, Hedge]
) -> tuple[Antecedent, list[tuple[str, list[str], str]], float]:
    """Return the rule of a line of text whose conclusions may be hedged, too.

    The result is the antecedent, the variables, hedges and terms of the conclusions, and the
    weight. ``else`` is refused.

    Raises
    ------
    InvalidRule
        If the text is not such a rule; the message names the word and what was expected there.
    """
    return _Reader(text, number, hedges).hedged_rule(_tree(text, number))


def _tree(text: str, number: int) -> Tree[Token]:
    try:
        return _parser().parse(text)
    except UnexpectedCharacters as error:
        raise InvalidRule(number, text, _misplaced(text, error.pos_in_stream or 0)) from None
    except UnexpectedToken as error:
        raise InvalidRule(number, text, _unexpected(text, error)) from None


def _misplaced(text: str, position: int) -> str:
    return f"has a double quote out of place at {text[position : position + 20]!r}"


def _unexpected(text: str, error: UnexpectedToken) -> str:
    end = error.token.type == "$END"
    position = len(text) if end else error.token.start_pos
    before = _TOKEN.findall(text[:position])[-3:]
    known = set(error.accepts or error.expected)
    if "WORD" in known and not (before and before[-1] == "("):
        after_is = bool(before) and (before[-1].lower() == "is" or "IS" not in known)
        asks_term = after_is and before[-1].lower() in ("is", "not")
        wanted = f"the name of a {'term' if asks_term and _after_is(before) else 'variable'}"
        if known - {"WORD", "QUOTED", "NOT", "MORE_OR_LESS", "LPAR"}:
            # A term has been read there already.
            wanted = _listed(known)
    else:
        wanted = _listed(known)
    if end:
        return f"ends where {wanted} is expected"
    where = f'after "{" ".join(before)}"' if before else "at its start"
    return f"has {str(error.token)!r} {where}, where {wanted} is expected"


def _after_is(before: list[str]) -> bool:
    words = [word.lower() for word in before]
    return words[-1] == "is" or ("is" in words and words[-1] == "not")


def _listed(known: set[str]) -> str:
    order = [name for name in ("IF", "IS", "AND", "RPAR", "THEN", "$END") if name in known]
    if "AND" in order and "IS" in order:
        order.remove("IS")
    if not order:
        return "a number" if "WORD" in known else "a parenthesis"
    return " or ".join(_SHOWN[name] for name in order)


class _Reader:
    """Names and trees of one parsed line."""

    def __init__(self, text: str, number: int, hedges: Mapping[str, Hedge]) -> None:
        self.text, self.number, self.hedges = text, number, hedges

    def error(self, reason: str) -> InvalidRule:
        return InvalidRule(self.number, self.text, reason)

    def rule(self, tree: Tree[Token]) -> Words:
        parts = [part for part in tree.children if isinstance(part, Tree)]
        asked = self.asked(parts[0])
        said = [part for part in parts[1:] if part.data == "said"]
        weight = next((part for part in parts[1:] if part.data == "weight"), None)
        return Words(
            asked,
            self.said(said[0]),
            self.said(said[1]) if len(said) > 1 else (),
            1.0 if weight is None else self.weight(weight),
        )

    def hedged_rule(
        self, tree: Tree[Token]
    ) -> tuple[Antecedent, list[tuple[str, list[str], str]], float]:
        parts = [part for part in tree.children if isinstance(part, Tree)]
        said = [part for part in parts[1:] if part.data == "said"]
        weight = next((part for part in parts[1:] if part.data == "weight"), None)
        if len(said) > 1:
            raise self.error('has "else", which this format has no word for')
        found = []
        for clause in said[0].children:
            if isinstance(clause, Tree):
                variable, words, term = self.clause(clause)
                if term is None:
                    raise self.error(f"says that {variable!r} is anything")
                found.append((variable, words, term))
        return self.asked(parts[0]), found, 1.0 if weight is None else self.weight(weight)

    def weight(self, tree: Tree[Token]) -> float:
        written = str(tree.children[-1])
        weight = number_of(written)
        if not 0.0 <= weight <= 1.0:
            raise self.error(f"has the weight {written!r}, which must be a number from 0 to 1")
        return weight

    def asked(self, tree: Any) -> Antecedent:
        parts = [part for part in tree.children if isinstance(part, Tree)]
        if tree.data == "clause":
            variable, words, term = self.clause(tree)
            clause: Antecedent = Is(variable, term)
            for word in reversed(words):
                clause = Not(clause) if word == "not" else Hedged(self.hedges[word], clause)
            return clause
        if tree.data == "negated":
            return Not(self.asked(parts[0]))
        found = tuple(self.asked(part) for part in parts)
        return And(found) if tree.data == "both" else Or(found)

    def said(self, tree: Tree[Token]) -> tuple[tuple[str, str, bool], ...]:
        found = []
        for clause in tree.children:
            if not isinstance(clause, Tree):
                continue
            variable, words, term = self.clause(clause)
            if term is None or any(word != "not" for word in words):
                raise self.error(
                    f"has a hedge before the term of the output {variable!r}; hedges belong to the "
                    "antecedent, and THEN takes a term, or not and a term"
                )
            found.append((variable, term, len(words) % 2 == 1))
        return tuple(found)

    def clause(self, tree: Tree[Token]) -> tuple[str, list[str], str | None]:
        """Return variable, hedges and ``not`` from left to right, and term (None for *any*)."""
        variable = _plain(tree.children[0])
        words = list(tree.children[-1].children)  # type: ignore[union-attr]
        last = words[-1]
        if last.type not in ("WORD", "QUOTED"):
            raise self.error(f'has nothing after "{last}", where the name of a term is expected')
        before = [" ".join(str(word).split()).lower() for word in words[:-1]]
        for word, token in zip(before, words[:-1], strict=True):
            if word != "not" and (token.type == "QUOTED" or word not in self.hedges):
                raise self.error(
                    f"has {str(token)!r} before {_plain(last)!r}, which is not a hedge (known: "
                    f"{', '.join(self.hedges)}); a name with a blank in it stands in double quotes"
                )
        anything = last.type == "WORD" and str(last).lower() == ANY
        return variable, before, None if anything else _plain(last)


def _plain(token: Any) -> str:
    """Return a name without its quotes."""
    if token.type == "QUOTED":
        return re.sub(r"\\(.)", r"\1", str(token)[1:-1], flags=re.DOTALL)
    return str(token)
