"""Files of all formats: the content selects the reader, and the suffix selects the writer."""

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
    """A format: its suffixes, how its text is recognized, and how it is read and written."""

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
"""The formats, in the order in which they are tried on a text."""

SUFFIXES = tuple(suffix for one in FORMATS for suffix in one.suffixes)
"""Suffixes of all formats."""


def load(path: str | os.PathLike[str], **options: Any) -> Any:
    """Return the content of a file, whatever its format.

    The format is recognized by the content of the file: JSON, FML, ``.fis`` or ``.t2fis``, ``.fll``
    or ``.fcl``. If the content is not conclusive, the suffix decides.

    Parameters
    ----------
    path : str or path-like
        The file.
    **options
        Options of the format's reader: ``dialect="octave"`` for ``.fis``, see
        :mod:`fuzzy2.files.fis`; ``block`` and ``dialect`` for ``.fcl``, see
        :mod:`fuzzy2.files.fcl`.

    Returns
    -------
    FuzzySystem, or set or list of Rule
        A system; for JSON, the object that was saved.

    Raises
    ------
    MalformedFile
        If the format is unknown, or the file violates it; ``place`` is the line, or the path within
        a JSON document.
    NotExpressible
        If this package cannot represent the system; the message names the line.
    OSError
        If the file cannot be read.
    """
    text = read_text(named_path(path))
    found = next((one for one in FORMATS if one.is_text(text)), None) or _by_suffix(path)
    if found is None:
        raise MalformedFile(
            str(path),
            "line 1",
            "it is not JSON, FML or .fis, and its suffix is not known: known are "
            + ", ".join(SUFFIXES),
        )
    return found.read(path, **options)


def save(thing: Any, path: str | os.PathLike[str], **options: Any) -> None:
    """Write a system, a set or rules to a file, in the format of its suffix.

    Parameters
    ----------
    thing : FuzzySystem, or set or sequence of Rule
        The object to write; objects other than systems can only be written as JSON.
    path : str or path-like
        The file; an existing file is replaced. The format is JSON if there is no suffix.
    **options
        Options of the format's writer: ``dialect="octave"`` for ``.fis``.

    Raises
    ------
    UnknownName
        If the suffix is not that of a known format.
    NotExpressible
        If the format cannot express the object.
    FileNotWritten
        If the file cannot be written; an existing file is kept.
    """
    suffix = Path(named_path(path)).suffix
    found = _by_suffix(path) if suffix else FORMATS[0]
    if found is None:
        raise UnknownName("suffix of a file", suffix, SUFFIXES)
    if not isinstance(thing, FuzzySystem | ParallelSystem | AnYaSystem) and found is not FORMATS[0]:
        raise NotExpressible(type(thing).__name__, suffix, _instead(thing))
    found.write(thing, path, **options)


def _instead(thing: Any) -> str:
    """Return why only JSON holds an object that is not a system, or what to save instead of it."""
    try:
        json_files.to_json(thing)
    except NotExpressible as error:
        return f"only systems can; {error.reason}"
    return "only systems can; use JSON"


def _by_suffix(path: str | os.PathLike[str]) -> Format | None:
    suffix = Path(path).suffix.lower()
    return next((one for one in FORMATS if suffix in one.suffixes), None)
