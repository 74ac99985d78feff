"""Files of machine code that several processes may write at the same time.

Numba numbers the files of a function's code, one for each types of arguments, and looks in an index
for the next free number. Two processes that compile one function for different types at the same
time take the same number: the index of one then leads to the code of the other, which computes
something else without an error. Here the name of a file follows from what it is compiled for and
from, so that nothing but the same code has the same name.

Numba keeps code as long as the file of its function is the same, though the function calls others
whose files have changed. Here code is kept as long as all modules of its package, and of this one,
that have compiled functions are the same.
"""

from __future__ import annotations

import hashlib
import sys
from functools import lru_cache
from pathlib import Path
from typing import Any

from numba.core.caching import IndexDataCacheFile

MARK = b"support.compiled"
"""What modules with compiled functions import."""

COMPILER = Path(__file__).parent
"""Where compiled functions are made; what stands there counts, too."""


@lru_cache(maxsize=16)
def stamp_of_kernels(folder: Path) -> str:
    """Return a number of all modules below a folder that have compiled functions."""
    found = hashlib.sha256()
    for path in sorted(folder.rglob("*.py")):
        source = path.read_bytes()
        if MARK in source or path.parent == COMPILER:
            found.update(b"%d %s " % (len(source), path.relative_to(folder).as_posix().encode()))
            found.update(source)
    return found.hexdigest()


def _folder_of(module: str) -> Path | None:
    package = sys.modules.get(module.partition(".")[0])
    paths = list(getattr(package, "__path__", ()))
    return Path(paths[0]) if paths else None


class CodeFiles(IndexDataCacheFile):
    """The files of one function's code, and their index."""

    @classmethod
    def instead_of(cls, files: IndexDataCacheFile, module: str) -> CodeFiles:
        """Return files in the same place, for the same sources.

        Parameters
        ----------
        files : IndexDataCacheFile
            Numba's files of a function.
        module : str
            Name of the function's module.
        """
        own: Any = cls.__new__(cls)
        own.__dict__.update(files.__dict__)
        folders = {COMPILER.parent, _folder_of(module) or COMPILER.parent}
        stamps = tuple(stamp_of_kernels(folder) for folder in sorted(folders))
        own._source_stamp = (own._source_stamp, stamps)
        kept: CodeFiles = own
        return kept

    def save(self, key: Any, data: Any) -> None:
        """Keep code under its types, so that an index never leads to what is not yet there.

        Parameters
        ----------
        key : tuple
            What it is compiled for.
        data : object
            The code.
        """
        files: Any = self  # numba's own functions have no types
        what = files._dump((files._source_stamp, key))
        base = files._index_name.removesuffix(".nbi")
        name = f"{base}.{hashlib.sha256(what).hexdigest()[:20]}.nbc"
        files._save_data(name, data)
        # Read as late as possible: of two processes one may lose its entry, and compiles again.
        files._save_index({**files._load_index(), key: name})
