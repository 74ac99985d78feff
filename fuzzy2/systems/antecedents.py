"""Antecedents of rules as trees of *and*, *or*, *not* and hedges over ``input is term``.

Variables and terms are names in rules in words, and numbers in a system. Intervals of grades are
propagated through a tree end by end, and the ends are swapped where a function decreases. If an
input occurs twice in a tree, its occurrences are treated as independent, so the resulting interval
contains the true one but can be wider.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from fuzzy2.errors import InvalidValue
from fuzzy2.operations.t_norms import T_CONORMS, TConorm, TNorm
from fuzzy2.support.checks import Array
from fuzzy2.systems.hedges import Hedge, Scaled, intensify, relax


@dataclass(frozen=True)
class Is:
    """The clause ``variable is term``; the term ``None`` stands for any value.

    Parameters
    ----------
    variable : str or int
        Name or number of an input.
    term : str, int or None
        Name or number of one of its terms.
    """

    variable: str | int
    term: str | int | None


@dataclass(frozen=True)
class And:
    """All parts hold."""

    parts: tuple[Antecedent, ...]


@dataclass(frozen=True)
class Or:
    """At least one part holds."""

    parts: tuple[Antecedent, ...]


@dataclass(frozen=True)
class Not:
    """The part does not hold."""

    part: Antecedent


@dataclass(frozen=True)
class Hedged:
    """The part holds as strictly as the word of a hedge says."""

    hedge: Hedge
    part: Antecedent


Antecedent: TypeAlias = Is | And | Or | Not | Hedged


def leaves(tree: Antecedent) -> Iterator[Is]:
    """Yield the clauses ``variable is term`` of a tree from left to right."""
    match tree:
        case Is():
            yield tree
        case And(parts) | Or(parts):
            for part in parts:
                yield from leaves(part)
        case Not(part) | Hedged(_, part):
            yield from leaves(part)


def mapped(tree: Antecedent, change: Callable[[Is], Antecedent]) -> Antecedent:
    """Return a tree with its leaves replaced."""
    match tree:
        case And(parts):
            return And(tuple(mapped(part, change) for part in parts))
        case Or(parts):
            return Or(tuple(mapped(part, change) for part in parts))
        case Not(part):
            return Not(mapped(part, change))
        case Hedged(hedge, part):
            return Hedged(hedge, mapped(part, change))
    return change(tree)


def clauses_of(tree: Antecedent) -> tuple[Is, ...] | None:
    """Return the leaves of a conjunction of different inputs; None for any other tree."""
    parts = tree.parts if isinstance(tree, And) else (tree,)
    flat: list[Is] = []
    for part in parts:
        if not isinstance(part, Is):
            return None
        flat.append(part)
    variables = [part.variable for part in flat]
    return tuple(flat) if len(set(variables)) == len(variables) else None


def rows_of(trees: Sequence[Antecedent], inputs: int) -> NDArray[np.int64] | None:
    """Return rules as numbers of terms (R, p), or None if a tree is not a plain conjunction."""
    rows = np.full((len(trees), inputs), -1, dtype=np.int64)
    for row, tree in zip(rows, trees, strict=True):
        clauses = clauses_of(tree)
        if clauses is None:
            return None
        for clause in clauses:
            row[int(clause.variable)] = -1 if clause.term is None else clause.term
    return rows


def trees_of(rules: NDArray[np.int64]) -> tuple[Antecedent, ...]:
    """Return the trees of rules that are given as numbers of terms (R, p)."""
    trees: list[Antecedent] = []
    for row in rules.tolist():
        asked = tuple(Is(i, term) for i, term in enumerate(row) if term >= 0)
        trees.append(asked[0] if len(asked) == 1 else And(asked) if asked else Is(0, None))
    return tuple(trees)


def check_numbers(tree: Any, counts: Sequence[int], number: int) -> None:
    """Refuse invalid trees, and numbers of inputs and terms that do not exist.

    Raises
    ------
    InvalidValue
        If a tree is invalid; the message names the rule.
    """
    what = f"rule {number}"
    if isinstance(tree, And | Or):
        if not isinstance(tree.parts, tuple) or not tree.parts:
            raise InvalidValue(what, tree, "made of parts, at least one in each And and Or")
        for part in tree.parts:
            check_numbers(part, counts, number)
    elif isinstance(tree, Not | Hedged):
        check_numbers(tree.part, counts, number)
    elif not isinstance(tree, Is):
        raise InvalidValue(what, tree, "a tree of Is, And, Or, Not and Hedged")
    elif not _is_number(tree.variable, len(counts)):
        raise InvalidValue(what, tree, f"about inputs from 0, below {len(counts)}")
    elif tree.term is not None and not _is_number(tree.term, counts[int(tree.variable)]):
        raise InvalidValue(
            what, tree, f"about terms of the input from 0, below {counts[int(tree.variable)]}"
        )


def _is_number(value: Any, count: int) -> bool:
    whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
    return whole and 0 <= value < count


def strength(
    tree: Antecedent,
    grades: Sequence[Array],
    both: TNorm,
    either: TConorm,
    negated: bool = False,
) -> Array:
    """Return the firing intervals (n, 2) of a tree.

    Complements are moved down to the terms by De Morgan's laws, because 1 - (1 - g) would lose a
    small g by rounding.

    Parameters
    ----------
    tree : Is, And, Or, Not or Hedged
        Antecedent of a rule, by numbers.
    grades : sequence of p (n, terms, 2) arrays
        Grades of each input in its terms.
    both, either : TNorm and TConorm
        What *and* and *or* mean.
    negated : bool
        Whether to return the strength of its complement.
    """
    match tree:
        case Is(variable, term):
            of_input = grades[int(variable)]
            found = np.ones((len(of_input), 2)) if term is None else of_input[:, int(term)]
            return 1.0 - found[:, ::-1] if negated else found
        case And(parts) | Or(parts):
            own = [strength(part, grades, both, either, negated) for part in parts]
            if isinstance(tree, And):
                return dual_conorm(both)(*own) if negated else both(*own)
            return either.dual(*own) if negated else either(*own)
        case Not(part):
            return strength(part, grades, both, either, not negated)
        case Hedged(hedge, part):
            hedged = np.sort(hedge(strength(part, grades, both, either)), axis=-1)
            return 1.0 - hedged[:, ::-1] if negated else hedged


def dual_conorm(norm: TNorm) -> TConorm:
    """Return the t-conorm that De Morgan's laws assign to a t-norm."""
    known = next((one for one in T_CONORMS.values() if one.dual == norm), None)
    return known or TConorm(f"dual of {norm.name}", lambda a, b: 1.0 - norm(1.0 - a, 1.0 - b), norm)


# Steps of a tree for the compiled loop, which evaluates them with a stack. A number from 0 is that
# of a term, whose grade is pushed. BOTH_NOT and EITHER_NOT combine complements, with the t-norm
# dual to the t-conorm of *or*, and with the t-conorm dual to the t-norm of *and*. A hedge is
# followed by a number: its power, its factor, or a number that is not used.
ONE, AND, OR, NOT, POWER, BOTH_NOT, EITHER_NOT = -1, -2, -3, -4, -5, -6, -7
INTENSIFY, RELAX, SCALED = -8, -9, -10


def program_of(
    tree: Antecedent, offsets: Sequence[int], negated: bool = False
) -> list[float] | None:
    """Return the steps that compute a tree's strength in the compiled loop, or None if it cannot.

    ``offsets`` are the numbers of the first terms of the inputs, counted over all inputs;
    ``negated`` is as in :func:`strength`.
    """
    match tree:
        case Is(variable, term):
            leaf = [ONE if term is None else float(offsets[int(variable)] + int(term))]
            return [*leaf, NOT] if negated else leaf
        case And(parts) | Or(parts):
            steps: list[float] = []
            joined = (AND, EITHER_NOT) if isinstance(tree, And) else (OR, BOTH_NOT)
            for i, part in enumerate(parts):
                own = program_of(part, offsets, negated)
                if own is None:
                    return None
                steps += own
                if i:
                    steps.append(joined[negated])
            return steps
        case Not(part):
            return program_of(part, offsets, not negated)
        case Hedged(hedge, part):
            own = program_of(part, offsets)
            step = hedge_step(hedge)
            if own is None or step is None:
                return None
            return [*own, *step, *([NOT] if negated else [])]


def hedge_step(hedge: Hedge) -> tuple[float, float] | None:
    """Return the code of a hedge and its number, or None for a user-defined function."""
    if hedge.power is not None:
        return POWER, hedge.power
    if isinstance(hedge.function, Scaled):
        return SCALED, hedge.function.factor
    known = {intensify: INTENSIFY, relax: RELAX}
    code = next((known[one] for one in known if one is hedge.function), None)
    return None if code is None else (code, 0.0)


def depth_of(tree: Antecedent) -> int:
    """Return the greatest number of values on the stack."""
    match tree:
        case And(parts) | Or(parts):
            return max(depth_of(part) + (1 if i else 0) for i, part in enumerate(parts))
        case Not(part) | Hedged(_, part):
            return depth_of(part)
    return 1
