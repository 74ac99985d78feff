"""Names of operators in the formats, and operators that no format can express."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fuzzy2.errors import NotExpressible
from fuzzy2.operations.t_norms import T_CONORMS, T_NORMS
from fuzzy2.systems.operators import AGGREGATIONS
from fuzzy2.systems.system import FuzzySystem


def check_operators(system: FuzzySystem, where: str) -> None:
    """Refuse operators without a name, which no format can express.

    Raises
    ------
    NotExpressible
        If there is one.
    """
    norms: tuple[tuple[str, Any, Mapping[str, Any]], ...] = (
        ("t-norm", system.t_norm, T_NORMS),
        ("implication", system.implication, T_NORMS),
        ("t-conorm", system.t_conorm, AGGREGATIONS),
        ("disjunction", system.disjunction, T_CONORMS),
    )
    for kind, norm, known in norms:
        if known.get(norm.name) is not norm:
            raise NotExpressible(f"the {kind} {norm.name!r}", where, "it is a Python function")


def known_as(name: str, known: Mapping[str, str], what: str, where: str) -> str:
    """Return a format's name for one of our names, the first one in its table.

    Raises
    ------
    NotExpressible
        If the format has no such name.
    """
    word = next((theirs for theirs, ours in known.items() if ours == name), None)
    if word is None:
        raise NotExpressible(f"the {what} {name!r}", where, f"it has {', '.join(known)} only")
    return word
