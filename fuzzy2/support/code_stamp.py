"""One number for the origin of machine code: the sources of all kernels, and the compiler.

Numba only checks the file of a function. But the functions that it calls and the constants that it
uses may be in other files, and the values of constants are compiled into the code.
"""

from __future__ import annotations

import hashlib
import re
import sys
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

import llvmlite
import numba

MARK = b"support.compiled"
"""Module that all modules with compiled functions import."""

COMPILER = Path(__file__).parent
"""Folder of the code that compiles functions; its sources are included."""

VERSIONS = repr((numba.__version__, llvmlite.__version__, sys.version_info[:3]))
"""Versions of the compiler and of Python."""

_IMPORTED = re.compile(rb"^from ([\w.]+) import (\([^)]*\)|[^\n]*)", re.MULTILINE)
_CONSTANT = re.compile(rb"\b[A-Z][A-Z0-9_]+\b")


@lru_cache(maxsize=16)
def stamp_of_kernels(*packages: Path) -> str:
    """Return a number that identifies all modules of packages that machine code depends on.

    Parameters
    ----------
    *packages : Path
        Folders of packages.
    """
    found = hashlib.sha256()
    for path, source in sorted(sources_of_kernels(*packages).items()):
        name = next(path.relative_to(one.parent) for one in packages if path.is_relative_to(one))
        found.update(b"%d %s " % (len(source), name.as_posix().encode()))
        found.update(source)
    return found.hexdigest()


def sources_of_kernels(*packages: Path) -> dict[Path, bytes]:
    """Return the modules with compiled functions, and those of the constants they import.

    Constants have names in capitals. A module may itself import them from another one.

    Parameters
    ----------
    *packages : Path
        Folders of packages.
    """
    sources = {path: path.read_bytes() for one in packages for path in one.rglob("*.py")}
    found = {
        path: source
        for path, source in sources.items()
        if MARK in source or path.parent == COMPILER
    }
    left = list(found.values())
    while left:
        for path in _modules_of_constants(left.pop(), packages):
            if path in sources and path not in found:
                found[path] = sources[path]
                left.append(sources[path])
    return found


def _modules_of_constants(source: bytes, packages: tuple[Path, ...]) -> Iterator[Path]:
    """Yield the modules from which constants may be imported."""
    for module, names in _IMPORTED.findall(source):
        if _CONSTANT.search(names):
            for package in packages:
                path = package.parent.joinpath(*module.decode().split("."))
                yield path.with_suffix(".py")
                yield path / "__init__.py"
