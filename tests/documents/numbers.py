"""Every number of a document, tied to where it comes from.

A template is a piece of the document with a field for every number: ``{table_6_3/PD/sag:mm.0f}`` is
the way to a number in the sources and how it is written. What a template gives must be in the
document, and no number of the document may be in none of them, but for those of the
:data:`EXEMPT` kinds.

A field is a path of keys with slashes between them, and a format after the last colon: that of
Python, after a unit that the number is multiplied for (:data:`UNITS`), or ``sig`` for three
significant digits. ``{asserted tests' file::test number}`` is a number that this test asserts.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from psp3.thesis.findings import significant

TESTS = Path(__file__).resolve().parents[1]

UNITS = {"mm": 1e3, "%": 100.0, "ms": 1e3}

EXEMPT = {
    r"\b[Tt]ype-[12]\b": "kinds of fuzzy logic",
    r"\b3-(?:PSP|RRR)\b": "names of robots",
    r"\b0 dBW\b": "a unit of power",
    r"\bPentium 4\b": "name of a processor",
    r"\bconfigurations? \d(?:(?:, | and )\d)*": "columns of Table 5.1",
    r"\b[36]D\b": "kinds of closures",
    r"\b(?:[Cc]hapters?|[Ss]ections?|eqs?\.|Tables?|Theorems?|[Ff]igures?|Figs?\.|[Nn]otebook|steps|frame|tip)"
    r"[ \N{NO-BREAK SPACE}]\d[\d.]*[a-c]?(?:(?:, | and | to |–)\d[\d.]*[a-c]?)*": "places",
    r"^\| \d\.[\d.]*[a-c]?(?:(?:, | and | to )\d\.[\d.]*[a-c]?)*(?=[ ,])": "places in a table",
    r"\[\d\](?!\()": "links to the maps of the chapters",
    r"\b\d(?=√|mk\b|ac\b)|(?<=[<>] )0\b|\[0, 0\]": "formulas",
    r"`seed=range\(\d+\)`|\bfrom \d+ to \d+ seeds\b": "what exercises ask for",
    r"^#+ \d+(?= )": "numbers of headings",
    r"^\d+\.(?= )": "numbers of lists",
    r"\b(?:20(?:, | and | to |/)|15(?:, | and | to |/))*(?:20|15|10) dB": "levels of Table 6.1",
    r"\b95 %": "level of every interval here",
    r"\b2\.5 (?:to|and) 97\.5 %": "points that span the spread of single runs",
}
"""What is no measurement, with what it is instead."""

# Digits that are not part of a word, and words that measure.
NUMBER = re.compile(
    r"(?<![\w.])(?:\d+(?:,\d{3})*(?:\.\d+)?(?:e[-+]?\d+)?|\.\d+)"
    r"|\b(?:half|twice|doubled?|\w+fold)\b"
    r"|\b(?:an?|one|two|three) (?:third|quarter|fifth|sixth|eighth|tenth|hundredth)s?\b"
    r"|\b(?:two|three|four|five|six|seven|eight|nine|ten|twelve|hundred|thousand) times\b"
)
FIELD = re.compile(r"\{([^{}]+)\}")
FENCE = re.compile(r"^(`{3,})[^\n]*\n.*?^\1`*[ \t]*$", flags=re.DOTALL | re.MULTILINE)
NEW_LINE = re.compile(r"\||#|- |\d+\. |!\[|$")


def prose(text: str) -> str:
    """Return a document without blocks of code and targets of links, a paragraph a line.

    Rows of tables, points of lists and headings are lines of their own.
    """
    lines: list[str] = []
    joins = False
    for line in re.sub(r"\]\([^)\s]*\)", "]", FENCE.sub("", text)).splitlines():
        words, is_new = " ".join(line.split(" ")).strip(), NEW_LINE.match(line.strip()) is not None
        if joins and not is_new:
            lines[-1] += f" {words}"
        else:
            lines.append(words)
        joins = bool(words) and not words.startswith(("|", "#"))
    return "\n".join(lines)


def looked_up(path: str, sources: Mapping[str, Any]) -> Any:
    """Return what is at a path, or what a test asserts."""
    if path.startswith("asserted "):
        _, test, number = path.split()
        assert float(number) in constants(*test.split("::")), f"{test} does not assert {number}"
        return number
    found: Any = sources
    for key in path.split("/"):
        found = found[int(key) if isinstance(found, Sequence) else key]
    return found


def written(value: Any, form: str) -> str:
    """Return a value as a template's field writes it."""
    if not form:
        return str(value)
    if form == "sig":
        return significant(value)
    for unit, factor in UNITS.items():
        if form.startswith(unit):
            return format(factor * value, form.removeprefix(unit))
    return format(value, form)


def parts(template: str, sources: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield the words before every field, with what the field gives; at the end words alone."""
    end = 0
    for field in FIELD.finditer(template):
        path, _, form = field[1].rpartition(":")
        if not path or path.startswith("asserted "):
            path, form = field[1], ""
        yield template[end : field.start()], written(looked_up(path, sources), form)
        end = field.end()
    yield template[end:], ""


def rendered(template: str, sources: Mapping[str, Any]) -> str:
    return "".join(words + value for words, value in parts(template, sources))


def free_numbers(text: str) -> list[str]:
    """Return the numbers in a text that are of no exempt kind."""
    return [match[0] for match in NUMBER.finditer(text) if not exempt(text)[match.start()]]


@cache
def exempt(text: str) -> bytes:
    """Return a mark for every letter: whether it is of an exempt kind."""
    marks = bytearray(len(text))
    for pattern in EXEMPT:
        for match in re.finditer(pattern, text, flags=re.MULTILINE):
            marks[match.start() : match.end()] = b"\1" * (match.end() - match.start())
    return bytes(marks)


def problems(text: str, templates: Sequence[str], sources: Mapping[str, Any]) -> list[str]:
    """Return what is wrong with a document, in words: nothing if every number has its source.

    Parameters
    ----------
    text : str
        The document, as :func:`prose` returns it.
    templates : sequence of str
        What it must say.
    sources : mapping
        Where the fields of the templates lead.
    """
    wrong, marks = [], bytearray(exempt(text))
    for template in templates:
        should = rendered(template, sources)
        places = [match.start() for match in re.finditer(re.escape(should), text)]
        for place in places:
            marks[place : place + len(should)] = b"\1" * len(should)
        if not places:
            wrong.append(f"it should say\n    {should}{_nearest(template, text)}")
    for match in NUMBER.finditer(text):
        if not marks[match.start()]:
            around = text[max(0, match.start() - 60) : match.end() + 40].replace("\n", " ⏎ ")
            wrong.append(f"no source says {match[0]!r} of\n    …{around}…")
    return wrong


def _nearest(template: str, text: str) -> str:
    """Return what the document says instead, where only the fields differ."""
    pattern = "[^|]{1,80}?".join(map(re.escape, FIELD.split(template)[::2]))
    match = re.search(pattern, text)
    return f"\nwhere it says\n    {match[0]}" if match is not None and match[0] else ""


@cache
def constants(file: str, test: str) -> frozenset[float]:
    """Return the numbers that a test has, and those of the constants of its file that it names."""
    tree = ast.parse((TESTS / file).read_text(encoding="utf-8"))
    tops = {
        target.id: node.value
        for node in tree.body
        if isinstance(node, ast.Assign)
        for target in node.targets
        if isinstance(target, ast.Name)
    }
    (function,) = (
        node for node in tree.body if isinstance(node, ast.FunctionDef) and node.name == test
    )
    found: set[float] = set()
    for node in ast.walk(function):
        if isinstance(node, ast.Name) and node.id in tops:
            found |= _numbers_in(tops[node.id])
    return frozenset(found | _numbers_in(function))


def _numbers_in(tree: ast.AST) -> set[float]:
    return {
        float(node.value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant)
        and isinstance(node.value, int | float)
        and not isinstance(node.value, bool)
    }
