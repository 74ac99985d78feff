"""Files of machine code that several processes may write at the same time.

Numba numbers the files of a function's code, one for each types of arguments, and looks in an index
for the next free number. Two processes that compile one function for different types at the same
time take the same number: the index of one then leads to the code of the other, which computes
something else without an error. Here the name of a file follows from what it is compiled for and
from, so that nothing but the same code has the same name.
"""

from __future__ import annotations

import hashlib
from typing import Any

from numba.core.caching import IndexDataCacheFile


class CodeFiles(IndexDataCacheFile):  # type: ignore[misc]
    """The files of one function's code, and their index."""

    @classmethod
    def instead_of(cls, files: IndexDataCacheFile) -> CodeFiles:
        """Return files in the same place, for the same source."""
        own = cls.__new__(cls)
        own.__dict__.update(files.__dict__)
        return own

    def save(self, key: Any, data: Any) -> None:
        """Keep code under its types, so that an index never leads to what is not yet there.

        Parameters
        ----------
        key : tuple
            What it is compiled for.
        data : object
            The code.
        """
        what = self._dump((self._source_stamp, key))
        base = self._index_name.removesuffix(".nbi")
        name = f"{base}.{hashlib.sha256(what).hexdigest()[:20]}.nbc"
        self._save_data(name, data)
        # Read as late as possible: of two processes one may lose its entry, and compiles again.
        self._save_index({**self._load_index(), key: name})
