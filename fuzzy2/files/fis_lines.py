"""Lines of a ``.fis`` file: sections with entries, and the values of entries."""

from __future__ import annotations

import math
import re
from collections.abc import Container
from typing import NamedTuple

from fuzzy2.files.source import Source
from fuzzy2.systems.rules import unknown_name

_KEYS_OF_SYSTEM = (
    "Name",
    "Type",
    "Version",
    "NumInputs",
    "NumOutputs",
    "NumRules",
    "AndMethod",
    "OrMethod",
    "ImpMethod",
    "AggMethod",
    "DefuzzMethod",
    "TypeReductionMethod",
    "TypeRedMethod",
    "outputType",
    "CrispInterval",
)

# The last keys come from early versions of fuzzylite and have no effect.
_KEYS_OF_VARIABLE = (
    "Name",
    "Range",
    "NumMFs",
    "CrispInterval",
    "Enabled",
    "Default",
    "LockRange",
    "LockPrevious",
    "LockValid",
    "LockValidOutput",
    "LockOutputRange",
)

NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*(?:[eE][+-]?[0-9]+)?|\.[0-9]+(?:[eE][+-]?[0-9]+)?|[iI]nf)"
QUOTED = r"'((?:[^']|'')*)'"
VECTOR = r"\[([^\]']*)\]"
# MATLAB evaluates the text, so a single number needs no brackets.
PARAMETERS = r"(\[[^\]']*\]|[^\s\[\],;']+)"


class Line(NamedTuple):
    """Value after the equals sign, or a rule, with its line number."""

    number: int
    value: str


class Section(NamedTuple):
    """Lines after a header such as ``[Input1]``."""

    name: str
    number: int
    entries: dict[str, Line]
    rules: list[Line]


class FisLines(Source):
    """One text, divided into sections; ``dialect`` determines its meaning."""

    def __init__(self, text: str, source: str, dialect: str) -> None:
        super().__init__(source)
        self.dialect = dialect
        self.sections = self._sections(text)

    def _sections(self, text: str) -> dict[str, Section]:
        sections: dict[str, Section] = {}
        current = None
        for number, line in enumerate(re.split(r"\r\n|\r|\n", text), start=1):
            stripped = line.strip()
            if self.dialect == "fuzzylite":
                stripped = re.split("//|#", stripped)[0].rstrip()
            if not stripped or stripped.startswith(("%", "#", "//")):
                continue
            if header := re.fullmatch(
                r"\[\s*(System|Rules|(?:Input|Output)\s*[0-9]+)\s*\]", stripped
            ):
                name = "".join(header[1].split())
                if name in sections:
                    raise self.malformed(number, f"the section [{name}] occurs twice")
                current = sections[name] = Section(name, number, {}, [])
            elif current is None:
                raise self.malformed(number, f"expected [System], got {stripped[:40]!r}")
            elif current.name == "Rules":
                current.rules.append(Line(number, stripped))
            else:
                self._add_entry(current, number, stripped)
        if "System" not in sections:
            raise self.malformed(1, "there is no section [System]")
        return sections

    def _add_entry(self, section: Section, number: int, line: str) -> None:
        entry = re.fullmatch(r"(\w+)\s*=\s*(.*)", line)
        if entry is None:
            raise self.malformed(number, f"expected <key>=<value>, got {line[:40]!r}")
        known = _KEYS_OF_SYSTEM if section.name == "System" else _KEYS_OF_VARIABLE
        words = {word.lower(): word for word in known}
        key = re.sub("(?i)^mf", "MF", words.get(entry[1].lower(), entry[1]))
        if key not in known and (
            section.name == "System" or not re.fullmatch(r"MF[0-9]+[UL]?", key)
        ):
            raise self.malformed(number, unknown_name("key", key, known))
        if key in section.entries and re.fullmatch(r"MF[0-9]+", key):
            # MATLAB uses the order of the membership functions; one of its own demos has a number
            # twice.
            key = f"MF{sum(one.startswith('MF') for one in section.entries) + 1}"
        if key in section.entries:
            raise self.malformed(
                number, f"{key} occurs twice, first in line {section.entries[key].number}"
            )
        section.entries[key] = Line(number, entry[2])

    def entry(self, section: Section, key: str) -> Line:
        """Return a required entry."""
        if key not in section.entries:
            raise self.malformed(section.number, f"the section [{section.name}] has no {key}")
        return section.entries[key]

    def string(self, section: Section, key: str, default: str | None = None) -> str:
        """Return a quoted string; if it is missing, return the default, if there is one."""
        if default is not None and key not in section.entries:
            return default
        line = self.entry(section, key)
        quoted = re.fullmatch(QUOTED, line.value)
        if quoted is None:
            raise self.malformed(line.number, f"expected {key}='...', got {line.value[:40]!r}")
        return quoted[1].replace("''", "'")

    def count(self, section: Section, key: str) -> int:
        """Return a whole number."""
        line = self.entry(section, key)
        if not re.fullmatch(r"[0-9]{1,9}", line.value):
            raise self.malformed(
                line.number, f"expected a whole number for {key}, got {line.value[:40]!r}"
            )
        return int(line.value)

    def vector(self, number: int, text: str) -> list[float]:
        """Return numbers separated by blanks or commas."""
        words = re.split(r"[\s,;]+", text.strip(" \t,;")) if text.strip(" \t,;") else []
        return [self._number(number, word) for word in words]

    def _number(self, number: int, word: str) -> float:
        if re.fullmatch(NUMBER, word):
            return float(word)
        # MATLAB evaluates arbitrary expressions here; in practice only fractions of pi occur.
        part = re.fullmatch(rf"([+-]?)(?:({NUMBER})\*)?pi(?:/({NUMBER}))?", word)
        if part is None or float(part[3] or 1.0) == 0.0:
            raise self.malformed(number, f"expected a number, got {word[:40]!r}")
        value = float(part[2] or 1.0) * math.pi / float(part[3] or 1.0)
        return -value if part[1] == "-" else value

    def choice(self, section: Section, key: str, known: dict[str, str], default: str) -> str:
        """Return the meaning of a word, which may be missing."""
        name = self.string(section, key, default) or default
        if name not in known:
            line = section.entries[key].number
            raise self.refused(line, f"{key}={name!r}", f"known are {', '.join(known)}")
        return known[name]


def unlike(name: str, names: Container[str]) -> str:
    """Return a name, with a number if it is taken, because terms may share a name."""
    found, count = name, 1
    while found in names:
        count += 1
        found = f"{name}_{count}"
    return found


def quoted(name: str) -> str:
    """Return a name in quotes; quotes within it are doubled."""
    return "'" + name.replace("'", "''") + "'"
