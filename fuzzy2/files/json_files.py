r"""Sets, rule bases and systems as JSON, without pickle.

A file can describe them, and do nothing else.

A document is an object with ``"format": "fuzzy2"``, the ``"version"`` of the schema, and the thing
itself: its class under ``"type"``, and beside it the arguments of the constructor by name::

    {"format": "fuzzy2", "version": 1, "type": "GaussianUncertainMean",
     "mean": [-0.5, 0.5], "sigma": 2.0}

A set within a set or a system is such an object without format and version. Numbers are written
with the digits that give back the same float, bit for bit; infinite ones are the strings ``"inf"``
and ``"-inf"``. Arguments with a default may be left out. A rule base is of the type ``"RuleBase"``
and has ``"rules"``, a list of texts (see :mod:`fuzzy2.systems.rules`). The JSON Schema of it all is
shipped as ``fuzzy2/files/schema.json``.

What a Python function defines, like a `FunctionalSet`, cannot be written: sample it first.
"""

from __future__ import annotations

import inspect
import json
import math
import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Final, NamedTuple

import numpy as np

from fuzzy2.errors import Fuzzy2Error, InvalidRule, InvalidValue, MalformedFile, NotExpressible
from fuzzy2.operations.t_norms import T_CONORMS, T_NORMS
from fuzzy2.reduction.interval import METHODS
from fuzzy2.sets.derived import Complement, Truncated
from fuzzy2.sets.gaussian_type2 import GaussianType2Set
from fuzzy2.sets.general_type2 import (
    AlphaPlane,
    GeneralType2Set,
    SampledType2Set,
    Staircase,
    ZSlices,
)
from fuzzy2.sets.interval_type2 import (
    EmbeddedSet,
    FarthestMeanGaussian,
    GaussianUncertainMean,
    GaussianUncertainSigma,
    IntervalType2Set,
    NearestMeanGaussian,
)
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.smooth_shapes import (
    Bell,
    PiShaped,
    Sigmoid,
    SigmoidDifference,
    SigmoidProduct,
    TwoSidedGaussian,
)
from fuzzy2.sets.type1 import SampledSet, Singleton, Type1Set
from fuzzy2.support.text_files import read_text, write_text
from fuzzy2.systems.consequents import Linear
from fuzzy2.systems.fuzzifiers import NonSingletonFuzzifier, SingletonFuzzifier
from fuzzy2.systems.general_type2 import GeneralType2System
from fuzzy2.systems.rules import Rule, nearest_name, parse_rule
from fuzzy2.systems.system import TYPE_REDUCTIONS, FuzzySystem, IntervalType2System, Type1System

FORMAT: Final = "fuzzy2"
"""Tag by which a document says what it is."""

SCHEMA_VERSION: Final = 1
"""Version of the schema that is written, and the only one that is read so far."""

LARGEST_INTEGER: Final = 2**31 - 1
"""Largest whole number that is read; there are no such large rule bases or grids."""

RULE_BASE: Final = "RuleBase"
"""Type of a document that holds rules."""

Json = Any
"""What ``json`` makes of a document: dictionaries, lists, strings, numbers, True, False and
None.
"""


class _Kind(NamedTuple):
    """How a value of one kind is written at a path of the document, and read from it."""

    write: Callable[[Any, str], Json]
    read: Callable[[Json, str], Any]


def _malformed(path: str, reason: str) -> MalformedFile:
    return MalformedFile("document", path, reason)


def _shown(value: Json) -> str:
    text = json.dumps(value, ensure_ascii=False, default=repr)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _write_number(value: Any, path: str) -> Json:
    number = float(value)
    if math.isnan(number):
        raise NotExpressible(f"NaN at {path}", "JSON", "it is not a number")
    return number if math.isfinite(number) else "inf" if number > 0.0 else "-inf"


def _read_number(value: Json, path: str) -> float:
    if isinstance(value, int | float) and not isinstance(value, bool):
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if math.isfinite(number):
            return number
    raise _malformed(path, f"expected a finite number, got {_shown(value)}")


def _read_any_number(value: Json, path: str) -> float:
    if value in ("inf", "-inf"):
        return float(value)
    return _read_number(value, path)


def _optionally(kind: _Kind) -> _Kind:
    """Return the kind of things of one kind that may be missing, which is written null."""
    return _Kind(
        lambda value, path: None if value is None else kind.write(value, path),
        lambda value, path: None if value is None else kind.read(value, path),
    )


def _read_list(value: Json, path: str) -> list[Json]:
    if not isinstance(value, list):
        raise _malformed(path, f"expected a list, got {_shown(value)}")
    return value


def _listed(kind: _Kind) -> _Kind:
    """Return the kind of lists of things of one kind."""
    return _Kind(
        lambda values, path: [kind.write(value, f"{path}[{i}]") for i, value in enumerate(values)],
        lambda values, path: [
            kind.read(value, f"{path}[{i}]") for i, value in enumerate(_read_list(values, path))
        ],
    )


def _paired(kind: _Kind) -> _Kind:
    """Return the kind of lists of two things of one kind."""
    listed = _listed(kind)

    def read(values: Json, path: str) -> Any:
        if len(_read_list(values, path)) != 2:
            raise _malformed(path, f"expected two, got {len(values)}")
        return listed.read(values, path)

    return _Kind(listed.write, read)


def _read_integer(value: Json, path: str) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or abs(value) > LARGEST_INTEGER:
        raise _malformed(path, f"expected a whole number, got {_shown(value)}")
    return value


def _depth(value: Json) -> int:
    return 1 + _depth(value[0]) if isinstance(value, list) and value else 0


def _table(of: _Kind, name: str, *dimensions: int) -> _Kind:
    """Return the kind of nested lists whose rows are alike.

    They have one of some numbers of dimensions.
    """

    def write(values: Any, path: str) -> Json:
        kind = of
        for _ in np.shape(values):
            kind = _listed(kind)
        return kind.write(np.asarray(values).tolist(), path)

    def read(value: Json, path: str) -> Any:
        depth = _depth(_read_list(value, path))
        if depth not in dimensions:
            raise _malformed(path, f"expected {name}, got {_shown(value)}")
        kind = of
        for _ in range(depth):
            kind = _listed(kind)
        rows = kind.read(value, path)
        try:
            np.array(rows)
        except ValueError:
            raise _malformed(
                path, f"expected {name}, but its rows are of different lengths"
            ) from None
        return rows

    return _Kind(write, read)


def _choice(known: Iterable[str], name: str) -> _Kind:
    """Return the kind of strings among some."""

    def read(value: Json, path: str) -> str:
        if _read_text(value, path) not in known:
            raise _malformed(path, f"{_unknown(name, value, known)} (known: {', '.join(known)})")
        return str(value)

    return _Kind(lambda value, path: value, read)


def _norm(known: Mapping[str, Any], name: str) -> _Kind:
    """Return the kind of norms, written by name."""

    def write(value: Any, path: str) -> Json:
        written = value.name
        if known.get(written) is not value:
            raise NotExpressible(
                f"the {name} {written!r} at {path}",
                "JSON",
                f"only {', '.join(known)} have names; it is a function",
            )
        return written

    return _Kind(write, _choice(known, name).read)


def _read_text(value: Json, path: str) -> str:
    if not isinstance(value, str):
        raise _malformed(path, f"expected a string, got {_shown(value)}")
    return value


def _thing(base: type | tuple[type, ...], name: str) -> _Kind:
    """Return the kind of objects with a type, which must be a subclass of ``base``."""

    def read(value: Json, path: str) -> object:
        thing = _read_object(value, path)
        if not isinstance(thing, base):
            raise _malformed(f"{path}.type", f"expected {name}, got {type(thing).__name__!r}")
        return thing

    # Both functions are defined below, because the table that they look into needs the kinds.
    return _Kind(lambda value, path: _write_object(value, path), read)


_NUMBER = _Kind(_write_number, _read_number)
_ANY_NUMBER = _Kind(_write_number, _read_any_number)
_NUMBERS, _PAIR, _ANY_PAIR = _listed(_NUMBER), _paired(_NUMBER), _paired(_ANY_NUMBER)
_TYPE1 = _thing(Type1Set, "a type-1 set")
_INTERVAL = _thing(IntervalType2Set, "an interval type-2 set")
_PLANE = _thing((Type1Set, IntervalType2Set), "a type-1 or interval type-2 set")

_SET = _thing((Type1Set, IntervalType2Set, GeneralType2Set), "a set")
_NAMES = _listed(_Kind(lambda value, path: value, _read_text))


def _write_consequents(value: Any, path: str) -> Json:
    if isinstance(value, Linear):
        return _write_object(value, path)
    return (
        _NUMBER_TABLE.write(value, path)
        if isinstance(value, np.ndarray)
        else _SET_TABLE.write(value, path)
    )


def _read_consequents(value: Json, path: str) -> Any:
    if isinstance(value, dict):
        return _thing(Linear, "Linear").read(value, path)
    first = _read_list(value, path)[0] if value else None
    of_sets = isinstance(first, list) and bool(first) and isinstance(first[0], dict)
    return _SET_TABLE.read(value, path) if of_sets else _NUMBER_TABLE.read(value, path)


_NUMBER_TABLE = _table(
    _NUMBER, "numbers (R, m) or (R, m, 2), or a list of sets for each rule", 2, 3
)
_SET_TABLE = _listed(_listed(_SET))
_COEFFICIENTS = _table(_NUMBER, "numbers (R, m, p + 1)", 3)

_SYSTEM: dict[str, _Kind] = {
    "inputs": _SET_TABLE,
    "rules": _table(_Kind(lambda value, path: value, _read_integer), "whole numbers (R, p)", 2),
    "consequents": _Kind(_write_consequents, _read_consequents),
    "t_norm": _norm(T_NORMS, "t-norm"),
    "type_reduction": _choice(TYPE_REDUCTIONS, "type reduction"),
    "method": _choice(METHODS, "method of type reduction"),
    "t_conorm": _norm(T_CONORMS, "t-conorm"),
    "fuzzifier": _optionally(_thing((SingletonFuzzifier, NonSingletonFuzzifier), "a fuzzifier")),
    "input_names": _NAMES,
    "output_names": _NAMES,
    "term_names": _listed(_NAMES),
    "consequent_names": _optionally(_listed(_NAMES)),
    "input_ranges": _optionally(_listed(_PAIR)),
    "output_ranges": _optionally(_listed(_PAIR)),
    "resolution": _Kind(lambda value, path: value, _read_integer),
}

_FIELDS: dict[type, dict[str, _Kind]] = {
    Gaussian: {"mean": _NUMBER, "sigma": _NUMBER, "height": _NUMBER},
    Triangular: {"left": _NUMBER, "peak": _NUMBER, "right": _NUMBER, "height": _NUMBER},
    Trapezoidal: {
        "a": _ANY_NUMBER,
        "b": _ANY_NUMBER,
        "c": _ANY_NUMBER,
        "d": _ANY_NUMBER,
        "height": _NUMBER,
    },
    Bell: {"center": _NUMBER, "width": _NUMBER, "slope": _NUMBER},
    Sigmoid: {"center": _NUMBER, "slope": _NUMBER},
    Singleton: {"point": _NUMBER},
    Interval: {"left": _NUMBER, "right": _NUMBER},
    SampledSet: {"points": _NUMBERS, "grades": _NUMBERS},
    Truncated: {"whole": _TYPE1, "left": _NUMBER, "right": _NUMBER},
    PiShaped: {
        "a": _ANY_NUMBER,
        "b": _ANY_NUMBER,
        "c": _ANY_NUMBER,
        "d": _ANY_NUMBER,
        "height": _NUMBER,
    },
    TwoSidedGaussian: {"mean": _PAIR, "sigma": _ANY_PAIR},
    SigmoidDifference: {"center": _PAIR, "slope": _PAIR},
    SigmoidProduct: {"center": _PAIR, "slope": _PAIR},
    Complement: {"whole": _TYPE1},
    NearestMeanGaussian: {"mean": _PAIR, "sigma": _NUMBER},
    FarthestMeanGaussian: {"mean": _PAIR, "sigma": _NUMBER},
    EmbeddedSet: {"footprint": _INTERVAL, "edges": _NUMBERS, "shares": _NUMBERS},
    Staircase: {"levels": _NUMBERS, "lefts": _NUMBERS, "rights": _NUMBERS},
    IntervalType2Set: {"lower": _TYPE1, "upper": _TYPE1},
    GaussianUncertainMean: {"mean": _PAIR, "sigma": _NUMBER},
    GaussianUncertainSigma: {"mean": _NUMBER, "sigma": _PAIR},
    AlphaPlane: {"lower": _TYPE1, "upper": _TYPE1, "alpha": _NUMBER},
    GaussianType2Set: {"principal": _TYPE1, "sigma": _NUMBER, "domain": _ANY_PAIR},
    SampledType2Set: {"points": _NUMBERS, "slices": _listed(_TYPE1)},
    ZSlices: {"alphas": _NUMBERS, "planes": _listed(_PLANE)},
    SingletonFuzzifier: {},
    NonSingletonFuzzifier: {"shape": _SET},
    Linear: {"coefficients": _COEFFICIENTS, "spreads": _COEFFICIENTS},
    Type1System: _SYSTEM,
    IntervalType2System: _SYSTEM,
    GeneralType2System: {
        **_SYSTEM,
        "reduction": _choice(("alpha_planes", "gaussian"), "reduction"),
        "levels": _Kind(lambda value, path: value, _read_integer),
        "grade_t_norm": _choice(("min", "product"), "t-norm of secondary grades"),
    },
}


def _write_object(value: object, path: str) -> dict[str, Json]:
    fields = _FIELDS.get(type(value))
    if fields is None:
        reason = (
            "it is given by a Python function; sample it first"
            if hasattr(value, "function")
            else "its class has no schema"
        )
        raise NotExpressible(f"{type(value).__name__} at {path}", "JSON", reason)
    if callable(getattr(value, "sigma", None)):
        raise NotExpressible(
            f"the function sigma at {path}",
            "JSON",
            "only numbers can be written; sample the set first",
        )
    written = {
        name: kind.write(getattr(value, name), f"{path}.{name}") for name, kind in fields.items()
    }
    return {"type": type(value).__name__, **written}


def _read_object(value: Json, path: str) -> object:
    if not isinstance(value, dict):
        raise _malformed(path, f"expected an object, got {_shown(value)}")
    if isinstance(value, _Repeated):
        raise _malformed(f"{path}.{value.name}", "is given twice")
    if "type" not in value:
        raise _malformed(path, 'has no "type"')
    classes = {known.__name__: known for known in _FIELDS}
    name = _read_text(value["type"], f"{path}.type")
    if name not in classes:
        raise _malformed(f"{path}.type", _unknown("class", name, classes))
    fields, optional = _FIELDS[classes[name]], _optional(classes[name])
    for given in value:
        if given != "type" and given not in fields:
            raise _malformed(f"{path}.{given}", _unknown(f"field of {name}", given, fields))
    for field in fields:
        if field not in value and field not in optional:
            raise _malformed(path, f"{name} needs {field!r}")
    arguments = {
        field: kind.read(value[field], f"{path}.{field}")
        for field, kind in fields.items()
        if field in value
    }
    try:
        return classes[name](**arguments)
    except Fuzzy2Error as error:
        raise _malformed(path + _place(error, fields), str(error)) from error


def _place(error: Fuzzy2Error, fields: Mapping[str, _Kind]) -> str:
    """Return where in an object the constructor found fault."""
    name = error.name if isinstance(error, InvalidValue) else ""
    if name in fields:
        return f".{name}"
    if found := re.fullmatch(r"rule (\d+), input (\d+)", name):
        return f".rules[{int(found[1]) - 1}][{int(found[2]) - 1}]"
    if found := re.fullmatch(r"a term of input (\d+)", name):
        return f".inputs[{int(found[1]) - 1}]"
    return ".consequents" if name == "a consequent" else ""


def _optional(of: type) -> frozenset[str]:
    """Return the arguments of a constructor that have a default."""
    # A system passes options that it does not use itself on to its base.
    constructors = (of, FuzzySystem) if issubclass(of, FuzzySystem) else (of,)
    parameters = [
        parameter
        for constructor in constructors
        for parameter in inspect.signature(constructor).parameters.values()
    ]
    return frozenset(
        parameter.name for parameter in parameters if parameter.default is not parameter.empty
    )


def _unknown(kind: str, name: str, known: Iterable[str]) -> str:
    suggestion = nearest_name(name, known)
    return f"unknown {kind} {name!r}{f'; did you mean {suggestion!r}?' if suggestion else ''}"


class _Repeated(dict[str, Json]):
    """JSON object in which a name is given twice, which ``json`` would pass over in silence."""

    name: str


def _without_repetition(pairs: list[tuple[str, Json]]) -> dict[str, Json]:
    names = [name for name, _ in pairs]
    repeated = (
        next((name for i, name in enumerate(names) if name in names[:i]), None)
        if len(set(names)) < len(names)
        else None
    )
    if repeated is None:
        return dict(pairs)
    marked = _Repeated(pairs)
    marked.name = repeated
    return marked


def to_json(thing: object) -> dict[str, Json]:
    """Return a set, a rule base or a system as a JSON document.

    Parameters
    ----------
    thing : set, system, or sequence of Rule
        What is to be written.

    Returns
    -------
    dict
        The document, of dictionaries, lists, strings and finite numbers.

    Raises
    ------
    NotExpressible
        If it is, or contains, something that only a Python function defines; it says where.
    """
    head: dict[str, Json] = {"format": FORMAT, "version": SCHEMA_VERSION}
    if isinstance(thing, Sequence) and thing and all(isinstance(rule, Rule) for rule in thing):
        return {**head, "type": RULE_BASE, "rules": [str(rule) for rule in thing]}
    return {**head, **_write_object(thing, "$")}


def from_json(document: Mapping[str, Json]) -> Any:
    """Return what a JSON document describes; the inverse of :func:`to_json`.

    Parameters
    ----------
    document : mapping
        The document.

    Returns
    -------
    set, system, or list of Rule
        What it describes.

    Raises
    ------
    MalformedFile
        If it is no such document; ``place`` is the path within it, such as
        ``$.inputs[0][1].sigma``.
    """
    if not isinstance(document, Mapping):
        raise _malformed("$", f"expected an object, got {_shown(document)}")
    if isinstance(document, _Repeated):
        raise _malformed(f"$.{document.name}", "is given twice")
    if document.get("format") != FORMAT:
        raise _malformed("$.format", f'expected "{FORMAT}", got {_shown(document.get("format"))}')
    version = document.get("version")
    if isinstance(version, bool) or version != SCHEMA_VERSION:
        raise _malformed(
            "$.version", f"this release reads version {SCHEMA_VERSION}, got {_shown(version)}"
        )
    content = {name: value for name, value in document.items() if name not in ("format", "version")}
    try:
        return (
            _read_rules(content) if content.get("type") == RULE_BASE else _read_object(content, "$")
        )
    except RecursionError:
        raise _malformed("$", "is nested too deeply") from None


def _read_rules(content: dict[str, Json]) -> list[Rule]:
    for given in content:
        if given not in ("type", "rules"):
            raise _malformed(f"$.{given}", _unknown(f"field of {RULE_BASE}", given, ["rules"]))
    rules = []
    for i, text in enumerate(_read_list(content.get("rules"), "$.rules")):
        try:
            rules.append(parse_rule(_read_text(text, f"$.rules[{i}]"), i + 1))
        except InvalidRule as error:
            raise _malformed(f"$.rules[{i}]", str(error)) from error
    if not rules:
        raise _malformed("$.rules", "expected at least one rule")
    return rules


def save(thing: object, path: str | os.PathLike[str]) -> None:
    """Write a set, a rule base or a system to a JSON file, whole or not at all.

    Parameters
    ----------
    thing : set, system, or sequence of Rule
        What is to be written.
    path : str or path-like
        The file; one that exists is replaced.

    Raises
    ------
    NotExpressible
        If it cannot be written as JSON; see :func:`to_json`.
    OSError
        If the file cannot be written; what was there before remains.
    """
    write_text(
        json.dumps(to_json(thing), indent=2, ensure_ascii=False, allow_nan=False) + "\n", path
    )


def load(path: str | os.PathLike[str]) -> Any:
    """Return what a JSON file describes.

    Parameters
    ----------
    path : str or path-like
        A file that :func:`save` wrote, or one written by hand.

    Returns
    -------
    set, system, or list of Rule
        What it describes.

    Raises
    ------
    MalformedFile
        If it is not JSON (``place`` is the line and column), or no such document (``place`` is the
        path within it).
    OSError
        If it cannot be read.
    """
    text = read_text(path)
    try:
        document = json.loads(text, object_pairs_hook=_without_repetition)
    except json.JSONDecodeError as error:
        raise MalformedFile(
            str(path), f"line {error.lineno}, column {error.colno}", error.msg
        ) from None
    except RecursionError:
        raise MalformedFile(str(path), "$", "is nested too deeply") from None
    except ValueError as error:  # an integer of thousands of digits
        raise MalformedFile(str(path), "$", str(error)) from None
    try:
        return from_json(document)
    except MalformedFile as error:
        raise MalformedFile(str(path), error.place, error.reason) from error
