"""Files of all formats: what is in a file says how it is read, its name how it is written."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from fuzzy2.errors import MalformedFile, NotExpressible, UnknownName
from fuzzy2.files import json_files
from fuzzy2.files.fcl import read_fcl, write_fcl
from fuzzy2.files.fis import read_fis, write_fis
from fuzzy2.files.fll import read_fll, write_fll
from fuzzy2.files.fml import read_fml, write_fml
from fuzzy2.support.checks import named_path
from fuzzy2.support.text_files import read_text
from fuzzy2.systems.anya import AnYaSystem
from fuzzy2.systems.parallel import ParallelSystem
from fuzzy2.systems.system import FuzzySystem


class Format(NamedTuple):
    """A format: its suffixes, what tells it by the text, and how it is read and written."""

    suffixes: tuple[str, ...]
    is_text: Callable[[str], bool]
    read: Callable[..., Any]
    write: Callable[..., None]


_SYSTEM_HEADER = re.compile(r"^\s*\[\s*System\s*\]", re.MULTILINE)
_ENGINE = re.compile(r"^\s*(Engine|InputVariable|OutputVariable)\s*:", re.MULTILINE)
_FUNCTION_BLOCK = re.compile(r"^\s*FUNCTION_BLOCK\b", re.MULTILINE | re.IGNORECASE)

FORMATS = (
    Format(
        (".json",),
        lambda text: text.lstrip()[:1] == "{",
        json_files.load,
        json_files.save,
    ),
    Format((".fml", ".xml"), lambda text: text.lstrip()[:1] == "<", read_fml, write_fml),
    Format(
        (".fis", ".t2fis"),
        lambda text: _SYSTEM_HEADER.search(text) is not None,
        read_fis,
        write_fis,
    ),
    Format((".fll",), lambda text: _ENGINE.search(text) is not None, read_fll, write_fll),
    Format((".fcl",), lambda text: _FUNCTION_BLOCK.search(text) is not None, read_fcl, write_fcl),
)
"""The formats, in the order in which a text is tried."""

SUFFIXES = tuple(suffix for one in FORMATS for suffix in one.suffixes)
"""Suffixes of all formats."""


def load(path: str | os.PathLike[str], **options: Any) -> Any:
    """Return what a file describes, whatever its format.

    What is in the file decides: JSON, FML, ``.fis`` with its kin ``.t2fis``, ``.fll`` or ``.fcl``.
    If that says nothing, the suffix does.

    Parameters
    ----------
    path : str or path-like
        The file.
    **options
        What the reader of the format takes: ``dialect="octave"`` for ``.fis``, see
        :mod:`fuzzy2.files.fis`; ``block`` and ``dialect`` for ``.fcl``, see
        :mod:`fuzzy2.files.fcl`.

    Returns
    -------
    FuzzySystem, or set or list of Rule
        A system; of JSON, whatever was saved.

    Raises
    ------
    MalformedFile
        If it is of no format that is known, or not as its format prescribes; ``place`` is the
        line, or the path within a JSON document.
    NotExpressible
        If it describes what a system here cannot be; it names the line.
    OSError
        If it cannot be read.
    """
    text = read_text(named_path(path))
    found = next((one for one in FORMATS if one.is_text(text)), None) or _by_suffix(path)
    if found is None:
        raise MalformedFile(
            str(path),
            "line 1",
            "it is no JSON, no FML and no .fis, and its name says nothing: known are "
            + ", ".join(SUFFIXES),
        )
    return found.read(path, **options)


def save(thing: Any, path: str | os.PathLike[str], **options: Any) -> None:
    """Write a system, a set or rules to a file, in the format of its suffix, whole or not at all.

    Parameters
    ----------
    thing : FuzzySystem, or set or sequence of Rule
        What is to be written; all but systems can be written as JSON only.
    path : str or path-like
        The file; one that exists is replaced. Without a suffix it is JSON.
    **options
        What the writer of the format takes: ``dialect="octave"`` for ``.fis``.

    Raises
    ------
    UnknownName
        If the suffix is of no format.
    NotExpressible
        If the format has no way to write it.
    FileNotWritten
        If the file cannot be written; what was there before remains.
    """
    suffix = Path(named_path(path)).suffix
    found = _by_suffix(path) if suffix else FORMATS[0]
    if found is None:
        raise UnknownName("suffix of a file", suffix, SUFFIXES)
    if not isinstance(thing, FuzzySystem | ParallelSystem | AnYaSystem) and found is not FORMATS[0]:
        raise NotExpressible(type(thing).__name__, suffix, "only systems can; use JSON")
    found.write(thing, path, **options)


def _by_suffix(path: str | os.PathLike[str]) -> Format | None:
    suffix = Path(path).suffix.lower()
    return next((one for one in FORMATS if suffix in one.suffixes), None)
