r"""Sets, rule bases and systems as JSON, without pickle.

A file only describes objects, so reading it cannot run code.

A document is an object with ``"format": "fuzzy2"``, the ``"version"`` of the schema, the class of
the saved object under ``"type"``, and the arguments of its constructor by name::

    {"format": "fuzzy2", "version": 1, "type": "GaussianUncertainMean",
     "mean": [-0.5, 0.5], "sigma": 2.0}

A set within a set or a system is such an object without format and version. Numbers have enough
digits to read back the same float bit for bit; infinite numbers are the strings ``"inf"`` and
``"-inf"``. Arguments with a default may be left out. A rule base has the type ``"RuleBase"`` and
``"rules"``, a list of texts (see :mod:`fuzzy2.systems.rules`). The JSON Schema of documents is
``fuzzy2/files/schema.json``.

An object that is defined by a Python function, such as a `FunctionalSet`, cannot be written; sample
it first.
"""

from __future__ import annotations

import inspect
import json
import os
import re
from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from fuzzy2.errors import Fuzzy2Error, InvalidRule, InvalidValue, MalformedFile, NotExpressible
from fuzzy2.files.json_kinds import (
    ANY_NUMBER,
    INTEGER,
    NUMBER,
    TEXT,
    TRUTH,
    Json,
    Kind,
    at,
    choice_of,
    list_of,
    malformed,
    mapping_of,
    norm_of,
    or_none,
    pair_of,
    read_list,
    shown,
    table_of,
)
from fuzzy2.files.json_rules import RULES
from fuzzy2.operations.t_norms import T_CONORMS, T_NORMS
from fuzzy2.sets.derived import Complement, Truncated
from fuzzy2.sets.formula_set import FormulaSet
from fuzzy2.sets.gaussian_type2 import GaussianType2Set
from fuzzy2.sets.general_type2 import AlphaPlane, GeneralType2Set, SampledType2Set, ZSlices
from fuzzy2.sets.interval_type2 import (
    EmbeddedSet,
    GaussianUncertainMean,
    GaussianUncertainSigma,
    IntervalType2Set,
)
from fuzzy2.sets.lagged import Lagged
from fuzzy2.sets.named_shape import SHAPES, NamedShape
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.sigmoids import Sigmoid, SigmoidDifference, SigmoidProduct
from fuzzy2.sets.smooth_shapes import Bell, PiShaped, TwoSidedGaussian
from fuzzy2.sets.type1 import SampledSet, Singleton, Type1Set
from fuzzy2.sets.uncertain_mean import FarthestMeanGaussian, NearestMeanGaussian
from fuzzy2.sets.vertical_slices import Staircase
from fuzzy2.support.json_text import parse_json
from fuzzy2.support.text_files import read_text, write_text
from fuzzy2.systems.anya import AnYaSystem
from fuzzy2.systems.consequents import Formulas, Linear, OutputOf
from fuzzy2.systems.fuzzifiers import NonSingletonFuzzifier, SingletonFuzzifier
from fuzzy2.systems.general_type2 import GeneralType2System
from fuzzy2.systems.operators import AGGREGATIONS, INTEGRATIONS, METHODS, TYPE_REDUCTIONS
from fuzzy2.systems.parallel import ParallelSystem
from fuzzy2.systems.rules import Rule, parse_rule, unknown_name
from fuzzy2.systems.system import FuzzySystem, IntervalType2System, Type1System

FORMAT: Final = "fuzzy2"
"""Tag that identifies a document."""

SCHEMA_VERSION: Final = 1
"""Version of the schema that is written, and so far the only one that is read."""

RULE_BASE: Final = "RuleBase"
"""Type of a document that holds rules."""


def _thing(base: type | tuple[type, ...], name: str) -> Kind:
    """Return the kind of objects with a type that is a subclass of ``base``."""

    def read(value: Json, path: str) -> object:
        thing = _read_object(value, path)
        if not isinstance(thing, base):
            raise malformed(f"{path}.type", f"expected {name}, got {type(thing).__name__!r}")
        return thing

    # Both functions are defined below, because their table needs the kinds.
    return Kind(lambda value, path: _write_object(value, path), read)


_NUMBERS, _PAIR, _ANY_PAIR = list_of(NUMBER), pair_of(NUMBER), pair_of(ANY_NUMBER)
_TYPE1 = _thing(Type1Set, "a type-1 set")
_INTERVAL = _thing(IntervalType2Set, "an interval type-2 set")
_PLANE = _thing((Type1Set, IntervalType2Set), "a type-1 or interval type-2 set")

_SET = _thing((Type1Set, IntervalType2Set, GeneralType2Set), "a set")
_NAMES = list_of(TEXT)


def _write_consequents(value: Any, path: str) -> Json:
    if isinstance(value, Linear | Formulas):
        return _write_object(value, path)
    return (
        _NUMBER_TABLE.write(value, path)
        if isinstance(value, np.ndarray)
        else _SET_TABLE.write(value, path)
    )


def _read_consequents(value: Json, path: str) -> Any:
    if isinstance(value, dict):
        return _thing((Linear, Formulas), "Linear or Formulas").read(value, path)
    rows = read_list(value, path)
    of_sets = any(isinstance(item, dict) for row in rows if isinstance(row, list) for item in row)
    return _SET_TABLE.read(value, path) if of_sets else _NUMBER_TABLE.read(value, path)


_NUMBER_TABLE = table_of(
    NUMBER, "numbers (R, m) or (R, m, 2), or a list of sets for each rule", 2, 3
)
_INPUTS = list_of(list_of(_SET))
_SET_TABLE = list_of(list_of(or_none(_SET)))
_COEFFICIENTS = table_of(NUMBER, "numbers (R, m, p + 1)", 3)


def _write_numbers(value: Any, path: str) -> Json:
    return _NUMBERS.write(value.tolist(), path)


def _write_defaults(value: Any, path: str) -> Json:
    return [None if np.isnan(one) else float(one) for one in value]


def _write_meaning(value: Any, path: str) -> Json:
    if isinstance(value, Type1Set | IntervalType2Set | GeneralType2Set):
        return _SET.write(value, path)
    return np.asarray(value, dtype=float).tolist()


def _read_meaning(value: Json, path: str) -> Any:
    if isinstance(value, dict):
        return _SET.read(value, path)
    return _PAIR.read(value, path) if isinstance(value, list) else NUMBER.read(value, path)


_TERMS = mapping_of(Kind(_write_meaning, _read_meaning), "terms")
_OTHERS = mapping_of(_thing(OutputOf, "the output of another system"), "outputs")

_SYSTEM: dict[str, Kind] = {
    "inputs": _INPUTS,
    "rules": RULES,
    "consequents": Kind(_write_consequents, _read_consequents),
    "t_norm": norm_of(T_NORMS, "t-norm"),
    "type_reduction": choice_of(TYPE_REDUCTIONS, "type reduction"),
    "method": choice_of(METHODS, "method of type reduction"),
    "t_conorm": norm_of(AGGREGATIONS, "t-conorm"),
    "disjunction": norm_of(T_CONORMS, "t-conorm"),
    "implication": norm_of(T_NORMS, "t-norm"),
    "weights": or_none(Kind(_write_numbers, _NUMBERS.read)),
    "silent": or_none(Kind(lambda value, path: value.tolist(), list_of(list_of(TRUTH)).read)),
    "default_outputs": or_none(Kind(_write_defaults, list_of(or_none(NUMBER)).read)),
    "shares": _PAIR,
    "integration": choice_of(INTEGRATIONS, "integration"),
    "fuzzifier": or_none(_thing((SingletonFuzzifier, NonSingletonFuzzifier), "a fuzzifier")),
    "input_names": _NAMES,
    "output_names": _NAMES,
    "term_names": list_of(_NAMES),
    "consequent_names": or_none(list_of(_NAMES)),
    "input_ranges": or_none(list_of(_PAIR)),
    "output_ranges": or_none(list_of(_PAIR)),
    "resolution": INTEGER,
    "output_terms": or_none(list_of(_TERMS)),
}

_FIELDS: dict[type, dict[str, Kind]] = {
    Gaussian: {"mean": NUMBER, "sigma": NUMBER, "height": NUMBER},
    Triangular: {"left": NUMBER, "peak": NUMBER, "right": NUMBER, "height": NUMBER},
    Trapezoidal: {
        "a": ANY_NUMBER,
        "b": ANY_NUMBER,
        "c": ANY_NUMBER,
        "d": ANY_NUMBER,
        "height": NUMBER,
    },
    Bell: {"center": NUMBER, "width": NUMBER, "slope": NUMBER},
    Sigmoid: {"center": NUMBER, "slope": NUMBER},
    Singleton: {"point": NUMBER},
    Interval: {"left": NUMBER, "right": NUMBER},
    SampledSet: {"points": _NUMBERS, "grades": _NUMBERS},
    Truncated: {"whole": _TYPE1, "left": NUMBER, "right": NUMBER},
    Lagged: {"whole": _TYPE1, "lags": _PAIR, "scale": NUMBER},
    PiShaped: {
        "a": ANY_NUMBER,
        "b": ANY_NUMBER,
        "c": ANY_NUMBER,
        "d": ANY_NUMBER,
        "height": NUMBER,
    },
    NamedShape: {
        "shape": choice_of(SHAPES, "shape"),
        "parameters": list_of(ANY_NUMBER),
        "scale": NUMBER,
    },
    FormulaSet: {"formula": TEXT, "left": NUMBER, "right": NUMBER},
    TwoSidedGaussian: {"mean": _PAIR, "sigma": _ANY_PAIR},
    SigmoidDifference: {"center": _PAIR, "slope": _PAIR},
    SigmoidProduct: {"center": _PAIR, "slope": _PAIR},
    Complement: {"whole": _TYPE1},
    NearestMeanGaussian: {"mean": _PAIR, "sigma": NUMBER},
    FarthestMeanGaussian: {"mean": _PAIR, "sigma": NUMBER},
    EmbeddedSet: {"footprint": _INTERVAL, "edges": _NUMBERS, "shares": _NUMBERS},
    Staircase: {"levels": _NUMBERS, "lefts": _NUMBERS, "rights": _NUMBERS},
    IntervalType2Set: {"lower": _TYPE1, "upper": _TYPE1},
    GaussianUncertainMean: {"mean": _PAIR, "sigma": NUMBER},
    GaussianUncertainSigma: {"mean": NUMBER, "sigma": _PAIR},
    AlphaPlane: {"lower": _TYPE1, "upper": _TYPE1, "alpha": NUMBER},
    GaussianType2Set: {"principal": _TYPE1, "sigma": NUMBER, "domain": _ANY_PAIR},
    SampledType2Set: {"points": _NUMBERS, "slices": list_of(_TYPE1)},
    ZSlices: {"alphas": _NUMBERS, "planes": list_of(_PLANE)},
    SingletonFuzzifier: {},
    NonSingletonFuzzifier: {"shape": _SET},
    Linear: {"coefficients": _COEFFICIENTS, "spreads": _COEFFICIENTS},
    Formulas: {"formulas": list_of(_NAMES), "names": _NAMES, "others": _OTHERS},
    OutputOf: {"system": _thing(FuzzySystem, "a system"), "output": INTEGER},
    Type1System: _SYSTEM,
    IntervalType2System: _SYSTEM,
    ParallelSystem: {"systems": list_of(_thing(FuzzySystem, "a system"))},
    AnYaSystem: {
        "clouds": list_of(Kind(_write_numbers, _NUMBERS.read)),
        "asked": list_of(INTEGER),
        "consequents": _thing(FuzzySystem, "a system"),
        "input_names": _NAMES,
    },
    GeneralType2System: {
        **_SYSTEM,
        "reduction": choice_of(("alpha_planes", "gaussian"), "reduction"),
        "levels": INTEGER,
        "grade_t_norm": choice_of(("min", "product"), "t-norm of secondary grades"),
    },
}


def _write_object(value: object, path: str) -> dict[str, Json]:
    fields = _FIELDS.get(type(value))
    if fields is None:
        raise NotExpressible(f"{type(value).__name__}{at(path)}", "JSON", _reason(value, path))
    if callable(getattr(value, "sigma", None)):
        raise NotExpressible(
            f"the function sigma{at(path)}",
            "JSON",
            "only numbers can be written; sample the set first",
        )
    written = {
        name: kind.write(getattr(value, name), f"{path}.{name}") for name, kind in fields.items()
    }
    return {"type": type(value).__name__, **written}


def _reason(value: Any, path: str) -> str:
    """Return why an object without a schema cannot be written, and what can be written instead."""
    if hasattr(value, "function"):
        return "it is given by a Python function; sample it first"
    for name in ("system_", "system"):
        if isinstance(getattr(value, name, None), FuzzySystem):
            return f"it is not a system itself; save its {name}"
    if callable(getattr(value, "fit", None)):
        return "it has learned nothing yet; call fit, and save its system_"
    known = "a system, a set or a list of rules" if path == "$" else "of a class of this package"
    return f"it is not {known}"


def _read_object(value: Json, path: str) -> object:
    if not isinstance(value, dict):
        raise malformed(path, f"expected an object, got {shown(value)}")
    if "type" not in value:
        raise malformed(path, 'has no "type"')
    classes = {known.__name__: known for known in _FIELDS}
    name = TEXT.read(value["type"], f"{path}.type")
    if name not in classes:
        raise malformed(f"{path}.type", unknown_name("class", name, classes))
    fields, optional = _FIELDS[classes[name]], _optional(classes[name])
    for given in value:
        if given != "type" and given not in fields:
            raise malformed(f"{path}.{given}", unknown_name(f"field of {name}", given, fields))
    for field in fields:
        if field not in value and field not in optional:
            raise malformed(path, f"{name} needs {field!r}")
    arguments = {
        field: kind.read(value[field], f"{path}.{field}")
        for field, kind in fields.items()
        if field in value
    }
    if issubclass(classes[name], FuzzySystem):
        # Systems behaved like this before the field existed.
        arguments.setdefault("integration", "sum")
    try:
        return classes[name](**arguments)
    except Fuzzy2Error as error:
        raise malformed(path + _place(error, fields), str(error)) from error


def _place(error: Fuzzy2Error, fields: Mapping[str, Kind]) -> str:
    """Return the place in an object where the constructor found an error."""
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
    # A system passes options that it does not use on to its base class.
    constructors = (of, FuzzySystem) if issubclass(of, FuzzySystem) else (of,)
    parameters = [
        parameter
        for constructor in constructors
        for parameter in inspect.signature(constructor).parameters.values()
    ]
    return frozenset(
        parameter.name for parameter in parameters if parameter.default is not parameter.empty
    )


def to_json(thing: object) -> dict[str, Json]:
    """Return a set, a rule base or a system as a JSON document.

    Parameters
    ----------
    thing : set, system, or sequence of Rule
        The object to write.

    Returns
    -------
    dict
        The document, of dictionaries, lists, strings and finite numbers.

    Raises
    ------
    NotExpressible
        If the object is, or contains, something that is defined by a Python function; the message
        says where.
    """
    head: dict[str, Json] = {"format": FORMAT, "version": SCHEMA_VERSION}
    if isinstance(thing, Sequence) and thing and all(isinstance(rule, Rule) for rule in thing):
        return {**head, "type": RULE_BASE, "rules": [str(rule) for rule in thing]}
    return {**head, **_write_object(thing, "$")}


def from_json(document: Mapping[str, Json]) -> Any:
    """Return the object of a JSON document; the inverse of :func:`to_json`.

    Parameters
    ----------
    document : mapping
        The document.

    Returns
    -------
    set, system, or list of Rule
        The object.

    Raises
    ------
    MalformedFile
        If it is not such a document; ``place`` is the path within it, such as
        ``$.inputs[0][1].sigma``.
    """
    if not isinstance(document, Mapping):
        raise malformed("$", f"expected an object, got {shown(document)}")
    if document.get("format") != FORMAT:
        raise malformed("$.format", f'expected "{FORMAT}", got {shown(document.get("format"))}')
    version = document.get("version")
    if isinstance(version, bool) or version != SCHEMA_VERSION:
        raise malformed(
            "$.version", f"this release reads version {SCHEMA_VERSION}, got {shown(version)}"
        )
    content = {name: value for name, value in document.items() if name not in ("format", "version")}
    try:
        return (
            _read_rules(content) if content.get("type") == RULE_BASE else _read_object(content, "$")
        )
    except RecursionError:
        raise malformed("$", "is nested too deeply") from None


def _read_rules(content: dict[str, Json]) -> list[Rule]:
    for given in content:
        if given not in ("type", "rules"):
            raise malformed(f"$.{given}", unknown_name(f"field of {RULE_BASE}", given, ["rules"]))
    rules = []
    for i, text in enumerate(read_list(content.get("rules"), "$.rules")):
        try:
            rules.append(parse_rule(TEXT.read(text, f"$.rules[{i}]"), i + 1))
        except InvalidRule as error:
            raise malformed(f"$.rules[{i}]", str(error)) from error
    if not rules:
        raise malformed("$.rules", "expected at least one rule")
    return rules


def save(thing: object, path: str | os.PathLike[str]) -> None:
    """Write a set, a rule base or a system to a JSON file.

    Parameters
    ----------
    thing : set, system, or sequence of Rule
        The object to write.
    path : str or path-like
        The file; an existing file is replaced.

    Raises
    ------
    NotExpressible
        If the object cannot be written as JSON; see :func:`to_json`.
    FileNotWritten
        If the file cannot be written; an existing file is kept.
    """
    write_text(
        json.dumps(to_json(thing), indent=2, ensure_ascii=False, allow_nan=False) + "\n", path
    )


def load(path: str | os.PathLike[str]) -> Any:
    """Return the object of a JSON file.

    Parameters
    ----------
    path : str or path-like
        A file that :func:`save` wrote, or one written by hand.

    Returns
    -------
    set, system, or list of Rule
        The object.

    Raises
    ------
    MalformedFile
        If it is not JSON (``place`` is the line and column), or not such a document (``place`` is
        the path within it).
    OSError
        If the file cannot be read.
    """
    document = parse_json(read_text(path), str(path))
    try:
        return from_json(document)
    except MalformedFile as error:
        raise MalformedFile(str(path), error.place, error.reason) from error
