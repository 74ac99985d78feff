"""Rules of a system in JSON, as numbers of terms or as trees.

A tree is ``{"is": [input, term]}`` (``null`` for any term), ``{"and": [...]}``, ``{"or": [...]}``,
``{"not": ...}``, or ``{"hedge": "very", "power": 2.0, "of": ...}``, in which
``"function": "intensify"`` or ``"relax"``, or ``"factor": 0.5``, may stand in place of the power.
"""

from __future__ import annotations

from typing import Any

from fuzzy2.errors import Fuzzy2Error, NotExpressible
from fuzzy2.files.json_kinds import (
    INTEGER,
    NUMBER,
    TEXT,
    Json,
    Kind,
    at,
    choice_of,
    malformed,
    read_list,
    shown,
    table_of,
)
from fuzzy2.systems.antecedents import And, Antecedent, Hedged, Is, Not, Or
from fuzzy2.systems.hedges import NAMED_FUNCTIONS, Hedge, Scaled

_FUNCTIONS = choice_of(NAMED_FUNCTIONS, "function of a hedge")
_TABLE = table_of(INTEGER, "whole numbers (R, p), or trees", 2)


def _write_tree(tree: Antecedent, path: str) -> Json:
    match tree:
        case And(parts):
            return {"and": [_write_tree(part, path) for part in parts]}
        case Or(parts):
            return {"or": [_write_tree(part, path) for part in parts]}
        case Not(part):
            return {"not": _write_tree(part, path)}
        case Hedged(hedge, part):
            if isinstance(hedge.function, Scaled):
                of = _write_tree(part, path)
                return {"hedge": hedge.name, "factor": hedge.function.factor, "of": of}
            known = [name for name, own in NAMED_FUNCTIONS.items() if own is hedge.function]
            if known:
                of = _write_tree(part, path)
                return {"hedge": hedge.name, "function": known[0], "of": of}
            if hedge.power is None:
                raise NotExpressible(
                    f"the hedge {hedge.name!r}{at(path)}", "JSON", "it is a Python function"
                )
            return {"hedge": hedge.name, "power": hedge.power, "of": _write_tree(part, path)}
    return {"is": [tree.variable, tree.term]}


def _read_tree(value: Json, path: str) -> Antecedent:
    if not isinstance(value, dict):
        raise malformed(path, f"expected a tree, got {shown(value)}")
    names = sorted(value)
    if names == ["is"]:
        pair = read_list(value["is"], f"{path}.is")
        if len(pair) != 2:
            raise malformed(f"{path}.is", f"expected two, got {len(pair)}")
        term = None if pair[1] is None else INTEGER.read(pair[1], f"{path}.is[1]")
        return Is(INTEGER.read(pair[0], f"{path}.is[0]"), term)
    if names in (["and"], ["or"]):
        parts = read_list(value[names[0]], f"{path}.{names[0]}")
        read = tuple(_read_tree(part, f"{path}.{names[0]}[{i}]") for i, part in enumerate(parts))
        return And(read) if names == ["and"] else Or(read)
    if names == ["not"]:
        return Not(_read_tree(value["not"], f"{path}.not"))
    if names == ["hedge", "of", "power"]:
        try:
            hedge = Hedge(
                TEXT.read(value["hedge"], f"{path}.hedge"),
                NUMBER.read(value["power"], f"{path}.power"),
            )
        except Fuzzy2Error as error:
            raise malformed(path, str(error)) from error
        return Hedged(hedge, _read_tree(value["of"], f"{path}.of"))
    if names == ["factor", "hedge", "of"]:
        factor = NUMBER.read(value["factor"], f"{path}.factor")
        if not 0.0 <= factor <= 1.0:
            raise malformed(f"{path}.factor", f"expected a number in [0, 1], got {factor}")
        hedge = Hedge(TEXT.read(value["hedge"], f"{path}.hedge"), function=Scaled(factor))
        return Hedged(hedge, _read_tree(value["of"], f"{path}.of"))
    if names == ["function", "hedge", "of"]:
        function = _FUNCTIONS.read(value["function"], f"{path}.function")
        hedge = Hedge(
            TEXT.read(value["hedge"], f"{path}.hedge"), function=NAMED_FUNCTIONS[function]
        )
        return Hedged(hedge, _read_tree(value["of"], f"{path}.of"))
    raise malformed(path, f"expected is, and, or, not, or hedge with power and of, got {names}")


def _write_rules(rules: Any, path: str) -> Json:
    if isinstance(rules, tuple):
        return [_write_tree(tree, f"{path}[{i}]") for i, tree in enumerate(rules)]
    return _TABLE.write(rules, path)


def _read_rules(value: Json, path: str) -> Any:
    rows = read_list(value, path)
    if rows and isinstance(rows[0], dict):
        return tuple(_read_tree(row, f"{path}[{i}]") for i, row in enumerate(rows))
    return _TABLE.read(value, path)


RULES = Kind(_write_rules, _read_rules)
"""Rules of a system."""
