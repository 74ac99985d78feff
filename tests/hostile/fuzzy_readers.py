"""The readers of fuzzy2, with what tells whether they read right.

Whatever is read is asked for a few outputs, and some of it is written in its own format and as JSON
and read again. JSON is compared with the document value by value; FML and ``.fis`` with evaluators
that share nothing with the package.
"""

from __future__ import annotations

import functools
import json
import math
import re
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

import fuzzy2
from fuzzy2.errors import Fuzzy2Error, NotExpressible
from fuzzy2.files.fcl import format_fcl, parse_fcl, read_fcl
from fuzzy2.files.fis import format_fis, parse_fis, read_fis
from fuzzy2.files.fll import format_fll, parse_fll, read_fll
from fuzzy2.files.fml import format_fml, parse_fml, read_fml
from fuzzy2.files.json_files import from_json, to_json
from fuzzy2.support.formula import Formula
from fuzzy2.systems.general_type2 import GeneralType2System
from fuzzy2.systems.rules import parse_rule
from tests.fuzzy2.files import engines, fcl_texts, fis_texts, fml_texts
from tests.fuzzy2.files.fml_by_hand import ByHand
from tests.fuzzy2.files.toolbox import Toolbox
from tests.hostile import json_mutants, text_mutants, xml_mutants
from tests.hostile.mutant import Mutant
from tests.hostile.reader import Reader
from tests.hostile.text_mutants import Language

POINTS = 3
"""At so many inputs a system is asked."""


def asked(system: Any, count: int = POINTS) -> np.ndarray:
    """Return inputs within the ranges of a system, within [-1, 1] where it has none."""
    ranges = getattr(system, "input_ranges", None) or [(-1.0, 1.0)] * len(system.input_names)
    low, high = np.clip(np.transpose(ranges), -1e100, 1e100)
    return low + (high - low) * np.random.default_rng(0).uniform(size=(count, len(low)))


def answers(system: Any) -> str:
    """Return the outputs of a system, as a text in which NaN equals NaN."""
    return str(np.asarray(system(asked(system))).tolist())


def said(thing: Any) -> str:
    """Return all that a system says, as a text."""
    try:
        return json.dumps(to_json(thing))
    except NotExpressible:
        return f"{type(thing).__name__} {answers(thing)}"


def whole(
    read: Callable[[Path], Any], write: Callable[[Any], str], parse: Callable[[str], Any]
) -> Any:
    """Return a reader that goes through a file's own format and JSON, too."""

    def reading(path: Path) -> str:
        system = read(path)
        if not _is_chosen(path):
            return said(system)
        here = np.asarray(system(asked(system)))
        for back in (lambda: parse(write(system)), lambda: from_json(to_json(system))):
            try:
                again = back()
            except NotExpressible:
                continue
            np.testing.assert_allclose(
                again(asked(system)), here, rtol=1e-7, atol=1e-9 * _scale(here)
            )
        return said(system)

    return reading


def _is_chosen(path: Path) -> bool:
    """Return whether a file is one of the few that are evaluated, which takes longest."""
    return zlib.crc32(path.read_bytes()) % 4 == 0


def _scale(values: np.ndarray) -> float:
    finite = np.abs(values[np.isfinite(values)])
    return 1.0 + float(finite.max(initial=0.0))


def _close(ours: Any, theirs: Any) -> str:
    ours, theirs = np.asarray(ours, dtype=float), np.asarray(theirs, dtype=float)
    if np.allclose(ours, theirs, rtol=1e-6, atol=1e-6 * _scale(theirs), equal_nan=True):
        return ""
    return f"another evaluator finds {theirs.tolist()}, and here are {ours.tolist()}"


def second_fis(content: bytes, value: str) -> str:
    """Compare with the toolbox in a hundred lines, where it has an opinion."""
    text = content.decode("utf-8-sig")
    # It knows no scales and lags.
    if zlib.crc32(content) % 4 or re.search(r"\]\s*,\s*\[", text):
        return ""
    system = parse_fis(text)
    if not isinstance(system, fuzzy2.FuzzySystem):
        return ""
    try:
        other = Toolbox(text)
        with np.errstate(all="ignore"):
            theirs = [other(list(x)) for x in asked(system)]
    except Exception:  # it knows a part of the format, and checks nothing
        return ""
    return _close(system(asked(system)), theirs)


def second_fml(content: bytes, value: str) -> str:
    """Compare with the evaluator of IEEE 1855, where it has an opinion."""
    if zlib.crc32(content) % 4:
        return ""
    text = content.decode("utf-8-sig")
    system = parse_fml(text)
    try:
        other = ByHand(text)
        X = asked(system)
        with np.errstate(all="ignore"):
            theirs = other(X)
    except Exception:  # it knows a part of the standard, and checks nothing
        return ""
    return _close(system(X), theirs) if np.shape(theirs) == np.shape(system(X)) else ""


def second_json(content: bytes, value: str) -> str:
    """Look whether each value of the document is in what was read, at its place."""
    document = json.loads(content.decode("utf-8-sig"))
    return _missing(document, json.loads(value), "$")


def _missing(given: Any, read: Any, path: str) -> str:
    if isinstance(given, dict) and isinstance(read, dict):
        places = [(f"{path}.{key}", one, read.get(key, ...)) for key, one in given.items()]
    elif isinstance(given, list) and isinstance(read, list) and len(given) == len(read):
        places = [(f"{path}[{k}]", *pair) for k, pair in enumerate(zip(given, read, strict=True))]
    elif isinstance(given, int | float) and isinstance(read, int | float):
        return "" if float(given) == float(read) else f"{path} is {given}, and {read} was read"
    elif path.endswith(".rules") or "].rules[" in path or ".rules[" in path:
        return ""  # rules in words are written anew
    elif path.endswith(".weights") and isinstance(given, list) and read is None:
        return "" if all(one == 1.0 for one in given) else f"{path} is {given}, and None was read"
    else:
        return "" if given == read else f"{path} is {given!r:.60}, and {read!r:.60} was read"
    return next(
        (found for place in places if (found := _missing(place[1], place[2], place[0]))), ""
    )


def _xml(seed: bytes, rng: np.random.Generator) -> Mutant:
    if rng.random() < 0.3:
        return text_mutants.changed(seed.decode(), FML, rng)
    return xml_mutants.mutant(_root(seed), rng)


@functools.cache
def _root(seed: bytes) -> ElementTree.Element:
    ElementTree.register_namespace("", "http://www.ieee1855.org")
    return ElementTree.fromstring(seed)


def _text(language: Language) -> Callable[[bytes, np.random.Generator], Mutant]:
    return lambda seed, rng: text_mutants.changed(seed.decode(), language, rng)


FML = Language(
    (
        "<rule/>",
        "</rule>",
        "<!--",
        "-->",
        "<![CDATA[",
        "]]>",
        "&amp;",
        "&#0;",
        "<?fuzzy2 a?>",
        "xmlns=''",
    ),
    "<!-- nothing -->",
    r"<\?xml.*?\?>",
    ("<fuzzyTerm>", "</fuzzyTerm>"),
)
FIS = Language(
    (
        "[Rules]",
        "[Input1]",
        "[Output2]",
        "MF1=",
        "'",
        "[",
        "]",
        "Inf",
        "pi",
        "-pi/0",
        ",",
        ":",
        "0.99",
    ),
    "% nothing",
    # Version, which is nobody's, and how a rule of one clause joins what it asks.
    r"^Version=.*$|: [12]$",
    ("[", "]"),
)
FLL = Language(
    (
        "Engine:",
        "InputVariable:",
        "rule:",
        "term:",
        "if",
        "not",
        "any",
        "(",
        ")",
        "#",
        ":",
        "inf",
        "Function",
    ),
    "# nothing",
    # Ranges count where all inputs have one, or the output is a set. Formulas are kept as texts.
    r"^ *range:.*$|Function .*$",
)
FCL = Language(
    (
        "(*",
        "*)",
        "/*",
        "//",
        ";",
        ":=",
        "END_VAR",
        "RULE 9 :",
        "NOT",
        "TERM",
        "(",
        ")",
        "..",
        "FUNCTION",
    ),
    "// nothing",
    r"RULE \d+|RANGE := .*$|FUNCTION .*$",
)
ANY = FLL._replace(silent=r"^Version=.*$|: [12]$|<\?xml.*$|Function .*$|^ *range:.*$")
WORDS = Language(
    ("if", "is", "not", "and", "or", "then", "else", "with", "(", ")", '"', "\\", "#", "very")
)
FORMULA = Language(
    ("(", ")", "^", "**", ".-", "!", "~", "and", "or", "pi", "sin(", ",", "%", "e", "x")
)

RULES = (
    'IF e is N and (de is not very "big one" or de is any) THEN u is P and v is not Z with 0.5',
    "if not (a is more or less low or b is high) then y is far else y is near (0.25)",
)
FORMULAS = ("1/(1 + exp(3*x))", "max(x, 0.25) ^ 2 - .5e-1*x % 3 + !(x and ~1) ** -2", "pi()*x")


def _without_comments(text: str) -> str:
    text = re.sub(r"\(\*.*?\*\)|/\*.*?\*/", "", text, flags=re.DOTALL)
    return "\n".join(re.sub(r"(//|#).*$|^\s*%.*$", "", line).rstrip() for line in text.split("\n"))


def _bytes(*texts: str) -> tuple[bytes, ...]:
    return tuple(_without_comments(text).encode() for text in texts)


def _general() -> GeneralType2System:
    sets = [fuzzy2.GaussianType2Set(fuzzy2.Gaussian(mean, 1.0), 0.1) for mean in (-1.0, 1.0)]
    return GeneralType2System([sets], [[0], [1]], [[-1.0], [2.0]], levels=3)


@functools.cache
def json_seeds() -> tuple[bytes, ...]:
    """Return documents of systems of all kinds, of sets and of rules."""
    things = (
        parse_fis(fis_texts.TIPPER),
        parse_fis(fis_texts.TYPE2),
        parse_fll(engines.HYBRID),
        parse_fll(engines.CHAIN),
        parse_fll(engines.FORMULAS),
        parse_fml(fml_texts.TIPPER_OF_CLOUDS),
        _general(),
        fuzzy2.GaussianUncertainMean((-0.5, 0.5), 2.0),
        fuzzy2.Trapezoidal(-math.inf, -math.inf, 0.0, 1.0),
        [parse_rule(RULES[0])],
    )
    return tuple(json.dumps(to_json(thing)).encode() for thing in things)


def _json(path: Path) -> str:
    thing = fuzzy2.load(path)
    systems = fuzzy2.FuzzySystem | fuzzy2.ParallelSystem | fuzzy2.AnYaSystem
    if isinstance(thing, systems) and _is_chosen(path):
        answers(thing)
    return said(thing)


def _formula(path: Path) -> str:
    formula = Formula(_decoded(path))
    names = {name: np.linspace(-2.0, 2.0, 5) for name in formula.names}
    return str(np.broadcast_to(formula.at(names), 5).tolist()) + str(formula.numbers)


def _decoded(path: Path) -> str:
    return path.read_bytes().decode("utf-8", "replace")


def _fis_path(name: str) -> str:
    return (Path(fis_texts.__file__).parent / "cases" / name).read_text(encoding="utf-8")


@functools.cache
def fuzzy_readers() -> tuple[Reader, ...]:
    """Return all readers of fuzzy2."""
    fis = _bytes(
        fis_texts.TIPPER,
        fis_texts.TYPE2,
        fis_texts.OPEN_TYPE2,
        _fis_path("weights_sugeno_or_max.fis"),
        _fis_path("mom.fis"),
    )
    fml = tuple(
        text.encode()
        for text in (
            fml_texts.TIPPER,
            fml_texts.TSK,
            fml_texts.TIPPER_WITH_POLYNOMIAL,
            fml_texts.TIPPER_OF_CLOUDS,
        )
    )
    fll = _bytes(engines.HYBRID, engines.CHAIN, engines.TSUKAMOTO, engines.FORMULAS)
    fcl = _bytes(fcl_texts.BRAKE[: fcl_texts.BRAKE.index("FUNCTION_BLOCK other")])
    one = functools.partial(Reader, refusals=Fuzzy2Error)
    return (
        one(
            "fis",
            ".fis",
            seeds=fis,
            change=_text(FIS),
            read=whole(read_fis, format_fis, parse_fis),
            second=second_fis,
        ),
        one(
            "fml",
            ".fml",
            seeds=fml,
            change=_xml,
            read=whole(read_fml, format_fml, parse_fml),
            second=second_fml,
        ),
        one(
            "fll", ".fll", seeds=fll, change=_text(FLL), read=whole(read_fll, format_fll, parse_fll)
        ),
        one(
            "fcl",
            ".fcl",
            seeds=fcl,
            change=_text(FCL),
            read=whole(lambda path: read_fcl(path, block="brake"), format_fcl, parse_fcl),
        ),
        one(
            "json",
            ".json",
            seeds=json_seeds(),
            change=json_mutants.changed,
            read=_json,
            second=second_json,
        ),
        one("any", ".txt", seeds=(*fis[:1], *fml[:1], *fll[:1]), change=_text(ANY), read=_json),
        one(
            "rule",
            ".txt",
            seeds=_bytes(*RULES),
            change=_text(WORDS),
            read=lambda path: str(parse_rule(_decoded(path))),
        ),
        one("formula", ".txt", seeds=_bytes(*FORMULAS), change=_text(FORMULA), read=_formula),
    )
