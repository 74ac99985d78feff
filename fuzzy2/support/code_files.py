"""Files of machine code that several processes may write at once, and that a disk may damage.

Numba numbers the files of a function's code, one for each combination of argument types, and takes
the next free number from an index. Two processes that compile one function for different types at
the same time take the same number. The index of one process then leads to the code of the other,
which silently computes something else. Here the name of a file follows from the types and the
sources, so only equal code has the same name.

Numba keeps code as long as the file of its function is unchanged, even if the function calls others
whose files have changed. Here code is kept as long as all modules that
:mod:`fuzzy2.support.code_stamp` finds are unchanged.

Python without docstrings and assertions (``-OO``) makes different bytecode from the same sources,
but the machine code is the same. So machine code is identified by the sources, not by the bytecode.

Numba stores code beside the sources. Here it is in a folder of the user
(:mod:`fuzzy2.support.code_folder`), so nothing is left behind when a package is uninstalled.

Numba runs the content of any file. Here a file begins with a checksum. If a file is damaged, or
cannot be read or written, the code is compiled again with a warning instead of an error.
"""

from __future__ import annotations

import contextlib
import hashlib
import pickle
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

from numba.core.caching import CompileResultCacheImpl, FunctionCache, IndexDataCacheFile

from fuzzy2.errors import CodeNotKept
from fuzzy2.support.code_folder import code_folder, name_for
from fuzzy2.support.code_stamp import COMPILER, VERSIONS, stamp_of_kernels

CHECKSUM = hashlib.sha256().digest_size
"""Number of bytes of the checksum, at the beginning of a file."""


def _folder_of(module: str) -> Path | None:
    package = sys.modules.get(module.partition(".")[0])
    paths = list(getattr(package, "__path__", ()))
    return Path(paths[0]) if paths else None


def _digest(*parts: bytes) -> Any:
    found = hashlib.sha256(VERSIONS.encode())
    for part in parts:
        found.update(part)
    return found


class CodeFiles(IndexDataCacheFile):
    """The files of one function's code, and their index."""

    @classmethod
    def instead_of(cls, files: IndexDataCacheFile, module: str) -> CodeFiles:
        """Return files in the same place, identified by the sources.

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
        own._source_stamp = (own._source_stamp, stamp_of_kernels(*sorted(folders)))
        # Another version of numba or Python uses another name, so a file of this name is either
        # usable or damaged.
        base = own._index_name.removesuffix(".nbi")
        own._index_name = f"{base}.{_digest().hexdigest()[:8]}.nbi"
        own._index_path = own._data_path(own._index_name)
        kept: CodeFiles = own
        return kept

    def save(self, key: Any, data: Any) -> None:
        """Store code for its types; the index never leads to a file that does not exist yet.

        Parameters
        ----------
        key : tuple
            Types for which the code is compiled.
        data : object
            The code.
        """
        files: Any = self  # numba's own functions have no types
        what = files._dump((files._source_stamp, key))
        base = files._index_name.removesuffix(".nbi")
        name = f"{base}.{_digest(what).hexdigest()[:20]}.nbc"
        files._save_data(name, data)
        # The index is read as late as possible. If two processes write at once, one may lose its
        # entry and compile again.
        files._save_index({**files._load_index(), key: name})

    def _load_index(self) -> Any:
        found = self._read(self._index_name)
        if found is None:
            return {}
        stamp, names = found
        return names if stamp == self._source_stamp else {}

    def _save_index(self, overloads: Any) -> None:
        files: Any = self
        stamp, names = self._read(self._index_name) or (self._source_stamp, {})
        self._write(self._index_name, (self._source_stamp, overloads))
        if stamp == self._source_stamp:
            return
        # Of other sources: no index leads to them any more.
        for name in names.values():
            with contextlib.suppress(OSError):
                Path(files._data_path(name)).unlink()

    def _load_data(self, name: str) -> Any:
        return self._read(name)

    def _save_data(self, name: str, data: Any) -> None:
        self._write(name, data)

    def _read(self, name: str) -> Any:
        """Return the content of a file, or None if it is missing or damaged."""
        files: Any = self
        try:
            content = Path(files._data_path(name)).read_bytes()
        except FileNotFoundError:
            return None
        except OSError as error:
            _warn(files._cache_path, f"a file there cannot be read ({error.strerror})")
            return None
        pickled = content[CHECKSUM:]
        # The checksum includes the name, so that one file cannot stand in for another.
        if content[:CHECKSUM] != _digest(name.encode(), pickled).digest():
            _warn(files._cache_path, "a file there is damaged")
            return None
        return pickle.loads(pickled)

    def _write(self, name: str, content: Any) -> None:
        files: Any = self
        pickled = files._dump(content)
        with files._open_for_write(files._data_path(name)) as file:
            file.write(_digest(name.encode(), pickled).digest())
            file.write(pickled)


class _Place:
    """The place of a function's code files, with the interface that numba expects."""

    def __init__(self, folder: Path, function: Any, path: Path) -> None:
        self._folder, self._path = folder, path
        self._line = function.__code__.co_firstlineno
        # Numba names it in its own warnings.
        self._py_file = str(path)

    @classmethod
    def from_function(cls, function: Callable[..., Any], file: str) -> _Place | None:
        """Return the place for a function of a file; None if code cannot be stored."""
        root, path = code_folder(), Path(file).absolute()
        if root is None or not path.is_file():
            return None
        return cls(root / name_for(path.parent), function, path)

    def ensure_cache_path(self) -> None:
        """Make the folder."""
        self._folder.mkdir(mode=0o700, exist_ok=True)

    def get_cache_path(self) -> str:
        """Return the folder."""
        return str(self._folder)

    def get_source_stamp(self) -> str:
        """Return a number that identifies the state of the function's sources."""
        return hashlib.sha256(self._path.read_bytes()).hexdigest()

    def get_disambiguator(self) -> str:
        """Return a text that distinguishes functions of the same name."""
        return str(self._line)


class _Code(CompileResultCacheImpl):
    _locator_classes: list[type[object]] = [_Place]  # noqa: RUF012 (of numba, as it declares it)


class CodeCache(FunctionCache):
    """Machine code of one function on disk, as far as the disk allows.

    Parameters
    ----------
    function : callable
        The function.

    Raises
    ------
    RuntimeError
        If there is no writable folder.
    """

    _impl_class = _Code

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)  # type: ignore[no-untyped-call]
        files = self._cache_file
        self._cache_file = CodeFiles.instead_of(files, function.__module__)

    def _index_key(self, sig: Any, codegen: Any) -> Any:
        """Return the key of code: types and machine, and for nested functions also the bytecode.

        Other functions are identified by their file, line and name.
        """
        found: Any = super()._index_key(sig, codegen)  # type: ignore[no-untyped-call]
        return found if "<" in self._py_func.__qualname__ else found[:2]

    def save_overload(self, sig: Any, data: Any) -> None:
        """Store code if possible; a failure only costs a later compilation.

        Parameters
        ----------
        sig : object
            Types for which the code is compiled.
        data : object
            The code.
        """
        try:
            super().save_overload(sig, data)  # type: ignore[no-untyped-call]
        except OSError as error:
            _warn(self.cache_path, f"no file can be written there ({error.strerror})")


def _warn(folder: str, why: str) -> None:
    warnings.warn(CodeNotKept(folder, why), stacklevel=2)
