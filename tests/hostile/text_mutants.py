"""Text files whose numbers, words and lines are changed at random."""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np

from tests.hostile.byte_mutants import damaged
from tests.hostile.mutant import SAME, Mutant
from tests.hostile.spelled_numbers import NUMBER, respelled

_TOKEN = re.compile(r"\w+|\s+|[^\w\s]")


class Language(NamedTuple):
    """What mutants of a text file know of its format."""

    words: tuple[str, ...] = ()
    """What may be put anywhere."""
    comment: str = ""
    """A line that says nothing, where the format has any."""
    silent: str = r"(?!)"
    """Where numbers say nothing."""
    nested: tuple[str, str] = ("(", ")")
    """What is nested."""
    blanks: bool = True
    """Whether blanks at the ends of lines, and lines of blanks, say nothing."""


def changed(text: str, language: Language, rng: np.random.Generator) -> Mutant:
    """Return a text that was changed."""
    kinds = (
        _number,
        _number,
        _number,
        _token,
        _token,
        _line,
        _line,
        _lookalike,
        _lookalike,
        _deep,
        _bytes,
        _bytes,
    )
    return kinds[int(rng.integers(len(kinds)))](text, language, rng)


def _choice(rng: np.random.Generator, count: int) -> int:
    return int(rng.integers(count))


def _number(text: str, language: Language, rng: np.random.Generator) -> Mutant:
    """Write one number in another way."""
    silent = [found.span() for found in re.finditer(language.silent, text, re.MULTILINE)]
    numbers = list(NUMBER.finditer(text))
    if not numbers:
        return _token(text, language, rng)
    found = numbers[_choice(rng, len(numbers))]
    written, what, claim = respelled(found[0], rng)
    if any(begin <= found.start() < end for begin, end in silent):
        claim = ""
    line = text[text.rfind("\n", 0, found.start()) + 1 :].splitlines()[0].strip()
    changed = text[: found.start()] + written + text[found.end() :]
    return Mutant(0, f"{what} for {found[0]} in {line[:60]!r}", changed.encode(), claim)


def _token(text: str, language: Language, rng: np.random.Generator) -> Mutant:
    """Remove, double, exchange or misspell a word, or put in another one."""
    tokens = _TOKEN.findall(text)
    place, other = _choice(rng, len(tokens)), _choice(rng, len(tokens))
    words = (*language.words, "\0", "\u2028", "\x1b[31m", "é", "🤖", "'", '"', "\n", "nan", "0", "")
    word = words[_choice(rng, len(words))]
    old = tokens[place]
    changes = {
        "remove": [""],
        "double": [old, old],
        "that of another": [tokens[other]],
        "put in": [old, f" {word} "],
        "replace": [word],
        "case": [old.swapcase()],
        "misspell": [f"{old}s"],
        "long": [old * 300],
    }
    what = list(changes)[_choice(rng, len(changes))]
    tokens[place : place + 1] = changes[what]
    return Mutant(
        0, f"{what} {old[:20]!r} ({word!r})", "".join(tokens).encode("utf-8", "surrogatepass")
    )


def _line(text: str, language: Language, rng: np.random.Generator) -> Mutant:
    """Remove, double, exchange, move, join or indent lines."""
    lines = text.split("\n")
    place, other = _choice(rng, len(lines)), _choice(rng, len(lines))
    line = lines[place]
    what = ("remove", "double", "exchange", "move", "join", "indent", "repeat")[_choice(rng, 7)]
    if what == "remove":
        del lines[place]
    elif what == "double":
        lines.insert(place, line)
    elif what == "exchange":
        lines[place], lines[other] = lines[other], line
    elif what == "move":
        lines.insert(other, lines.pop(place))
    elif what == "join" and place + 1 < len(lines):
        lines[place : place + 2] = [f"{line} {lines[place + 1]}"]
    elif what == "indent":
        lines[place] = f"   \t{line}"
    else:
        lines[place:place] = [line] * 100
    return Mutant(0, f"{what} {line.strip()[:40]!r}", "\n".join(lines).encode())


def _lookalike(text: str, language: Language, rng: np.random.Generator) -> Mutant:
    """Change what has no meaning: the ends of lines, the mark of UTF-8, blanks, comments."""
    lines = text.split("\n")
    place = _choice(rng, len(lines))
    changes = {
        "Windows lines": text.replace("\n", "\r\n"),
        "mark of UTF-8": f"\ufeff{text}",
        "line behind": f"{text}\n",
        "no line behind": text.rstrip("\n"),
    }
    if language.blanks:
        changes["blanks behind"] = "\n".join(f"{line} \t" for line in lines)
        changes["empty line"] = "\n".join([*lines[:place], "", *lines[place:]])
    if language.comment:
        changes["comment"] = "\n".join([*lines[:place], language.comment, *lines[place:]])
    what = list(changes)[_choice(rng, len(changes))]
    return Mutant(0, what, changes[what].encode(), SAME)


def _deep(text: str, language: Language, rng: np.random.Generator) -> Mutant:
    """Nest something thousands of times."""
    tokens = _TOKEN.findall(text)
    place = _choice(rng, len(tokens))
    depth = (5, 20, 50, 200, 200, 200, 3000, 3000)[_choice(rng, 8)]
    opened, closed = language.nested
    middle = opened * depth + tokens[place] + closed * depth
    return Mutant(
        0, f"{depth} deep", "".join([*tokens[:place], middle, *tokens[place + 1 :]]).encode()
    )


def _bytes(text: str, language: Language, rng: np.random.Generator) -> Mutant:
    return damaged(text.encode(), rng)
