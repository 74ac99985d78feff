"""Antecedents as text in the syntax of fuzzylite and IEC 61131-7."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from fuzzy2.errors import NotExpressible
from fuzzy2.systems.antecedents import And, Antecedent, Hedged, Is, Not, Or
from fuzzy2.systems.hedges import Hedge

Clause = Callable[[str, list[str], str | None], str]
"""Text of a variable, its hedges and ``not`` from left to right, and a term, None for any."""


def written(
    tree: Antecedent,
    hedges: Mapping[str, Hedge],
    clause: Clause,
    where: str,
    negation: bool,
) -> str:
    """Return a tree as text.

    Parameters
    ----------
    tree : And, Or, Not, Hedged or Is
        The antecedent, with names.
    hedges : mapping
        Hedges of the format.
    clause : callable
        Function that writes a clause.
    where : str
        The format.
    negation : bool
        Whether the format allows *not* before a parenthesis.

    Raises
    ------
    NotExpressible
        If the format cannot express a part.
    """

    def text(one: Antecedent, within: str) -> str:
        words: list[str] = []
        inner = one
        while isinstance(inner, Not | Hedged):
            words.append("not" if isinstance(inner, Not) else word_of(inner.hedge, hedges, where))
            inner = inner.part
        if isinstance(inner, Is):
            term = None if inner.term is None else str(inner.term)
            return clause(str(inner.variable), words, term)
        assert isinstance(inner, And | Or)
        if words and (not negation or any(word != "not" for word in words)):
            raise NotExpressible(
                f'"{" ".join(words)}" before parentheses', where, "it stands before terms there"
            )
        joint = "and" if isinstance(inner, And) else "or"
        joined = f" {joint} ".join(text(part, joint) for part in inner.parts)
        if words:
            return "not (" * len(words) + joined + ")" * len(words)
        return (
            joined if within in ("", joint) and (within == "" or joint == "or") else f"({joined})"
        )

    return text(tree, "")


def outer_words(
    tree: Antecedent, hedges: Mapping[str, Hedge], where: str
) -> tuple[Antecedent, list[str]]:
    """Return the condition within ``not`` and hedges, and these modifiers from left to right.

    A single clause is returned as a whole, without modifiers.
    """
    words: list[str] = []
    inner = tree
    while isinstance(inner, Not | Hedged):
        words.append("not" if isinstance(inner, Not) else word_of(inner.hedge, hedges, where))
        inner = inner.part
    return (tree, []) if isinstance(inner, Is) else (inner, words)


def word_of(hedge: Hedge, hedges: Mapping[str, Hedge], where: str) -> str:
    """Return a format's name for a hedge.

    Raises
    ------
    NotExpressible
        If the format has no such name.
    """
    for word, known in hedges.items():
        if hedge.power == known.power and hedge.function is known.function:
            return word
    raise NotExpressible(
        f"the hedge {hedge.name!r}", where, f"known are {', '.join(hedges) or 'none'}"
    )
