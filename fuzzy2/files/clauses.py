"""Rules without nested groups, as most formats write them: clauses joined with *and* or *or*."""

from __future__ import annotations

from typing import NamedTuple

from fuzzy2.systems.antecedents import And, Antecedent, Hedged, Not, Or
from fuzzy2.systems.hedges import Hedge


class Clause(NamedTuple):
    """``input is term`` in a flat rule, with its modifiers: ``"not"`` and hedges.

    The outermost modifier comes first.
    """

    input: int
    term: int
    changes: tuple[str | Hedge, ...] = ()


def clauses_of_rule(asked: Antecedent) -> tuple[bool, tuple[Clause, ...]] | None:
    """Return the antecedent of a flat rule: whether it joins with *or*, and its clauses.

    Clauses are ``input is term``, with hedges and *not* before them. A clause that always holds is
    left out of a conjunction. The result is None if the rule is not flat.
    """
    match asked:
        case And(parts) | Or(parts):
            either = isinstance(asked, Or)
            found: list[Clause] = []
            for part in parts:
                inside = clauses_of_rule(part)
                if inside is None or (len(inside[1]) > 1 and inside[0] != either):
                    return None
                if either and not inside[1]:
                    return None
                found += inside[1]
            return (either and len(found) > 1, tuple(found))
        case Not(part) | Hedged(_, part):
            inside = clauses_of_rule(part)
            if inside is None or len(inside[1]) != 1:
                return None
            change = asked.hedge if isinstance(asked, Hedged) else "not"
            clause = inside[1][0]
            return False, (clause._replace(changes=(change, *clause.changes)),)
    if asked.term is None:
        return False, ()
    return False, (Clause(int(asked.variable), int(asked.term)),)
