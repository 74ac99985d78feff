"""What machine code was made from, as one number: the sources of all kernels, and the compiler.

Numba looks at the file of a function only. But what the function calls has files of its own, and so
have the constants that it names: their values are written into the code.
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
"""What modules with compiled functions import."""

COMPILER = Path(__file__).parent
"""Where compiled functions are made; what stands there counts, too."""

VERSIONS = repr((numba.__version__, llvmlite.__version__, sys.version_info[:3]))
"""Who made the code, and of which Python it is."""

_IMPORTED = re.compile(rb"^from ([\w.]+) import (\([^)]*\)|[^\n]*)", re.MULTILINE)
_CONSTANT = re.compile(rb"\b[A-Z][A-Z0-9_]+\b")


@lru_cache(maxsize=16)
def stamp_of_kernels(*packages: Path) -> str:
    """Return a number of all modules of some packages that machine code depends on.

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
    """Return the modules that have compiled functions, or constants that these take from elsewhere.

    Constants are names in capitals. Those of one module may come from another one in turn.

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
    """Yield where the modules may be from which constants are imported."""
    for module, names in _IMPORTED.findall(source):
        if _CONSTANT.search(names):
            for package in packages:
                path = package.parent.joinpath(*module.decode().split("."))
                yield path.with_suffix(".py")
                yield path / "__init__.py"
