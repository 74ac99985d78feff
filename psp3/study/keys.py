"""What identifies a run in a file, in 24 bytes, and the runs of a study by it.

A key is the setting's, which are all fields but the seed, and then the seed. Of a million runs the
keys take 24 MB, and the runs themselves are made when they are wanted.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from hashlib import blake2b
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from psp3.errors import InvalidValue
from psp3.study.run import LARGEST_INTEGER, Run, Value, field_types, values_of
from psp3.study.table import Table

SHARED = ("duration",)
"""Fields that are the same in all runs of a file: errors are summed over that time, and other sums
do not go into one table.
"""

SETTING_BYTES, SEED_BYTES = 16, 8

KEYS = np.dtype(f"S{SETTING_BYTES + SEED_BYTES}")
"""Keys as an array holds them. They are all of one length, so that zeros at the end, which NumPy
does not tell from none, make no two of them equal.
"""

REMEMBERED = 50_000
"""Settings whose key is kept while a study is made; in a grid with seeds they come again."""

Keys = NDArray[np.bytes_]

_PLACES = {name: place for place, name in enumerate(field_types())}
_SEED = _PLACES["seed"]
_NAMES = tuple(name for name in field_types() if name != "seed")


def setting_values(run: Run) -> tuple[Value, ...]:
    """Return the values of all fields but the seed, in their order."""
    values = values_of(run)
    return values[:_SEED] + values[_SEED + 1 :]


def setting_names() -> tuple[str, ...]:
    """Return the names of all fields but the seed, in their order."""
    return _NAMES


def setting_key(values: tuple[Value, ...]) -> bytes:
    """Return the key of a setting, of its values in their order: a hash of their text.

    A number is written with as many digits as tell it from every other.
    """
    text = repr(values)
    if "-0.0" in text:
        # Equal numbers are one setting.
        text = repr(tuple(v + 0.0 if type(v) is float else v for v in values))
    return blake2b(text.encode(), digest_size=SETTING_BYTES).digest()


def key(run: Run) -> bytes:
    """Return what identifies a run, of its canonical form."""
    return setting_key(setting_values(run)) + run.seed.to_bytes(SEED_BYTES, "big")


def as_keys(content: bytes | bytearray) -> Keys:
    """Return keys, one after the other in a text of bytes, as an array."""
    return np.frombuffer(content, dtype=KEYS)


def is_seed(value: object) -> bool:
    """Tell whether this is a seed."""
    return type(value) is int and 0 <= value <= LARGEST_INTEGER


class Runs(Sequence[Run]):
    """The runs of a study, each once and in canonical form, in the order in which they were given.

    Parameters
    ----------
    runs : iterable of Run
        A sequence is kept as it is, and asked again for what is wanted.

    Attributes
    ----------
    keys : (N,) ndarray of bytes
        What identifies them.
    shared : dict
        Values of the fields in :data:`SHARED`.

    Raises
    ------
    InvalidValue, UnknownName
        If there are no runs, they differ in what all of a file share, or one of them makes no
        sense; see :meth:`psp3.study.run.Run.check`.
    """

    def __init__(self, runs: Iterable[Run]) -> None:
        self._source = runs if isinstance(runs, Sequence) else tuple(runs)
        self.shared: dict[str, Any] = {}
        content = bytearray()
        # A setting's values lead to its key and whether the seed counts.
        known: dict[tuple[Value, ...], tuple[bytes, bool]] = {}
        for run in self._source:
            values = setting_values(run)
            try:
                found = known.get(values) if is_seed(run.seed) else None
            except TypeError:
                # What cannot be hashed is no value of a field, as the check says.
                found = None
            if found is None:
                found = self._looked_at(run)
                if len(known) >= REMEMBERED:
                    known.clear()
                known[values] = found
            setting, counts = found
            content += setting
            content += (run.seed if counts else 0).to_bytes(SEED_BYTES, "big")
        if not content:
            raise InvalidValue("runs", [], "at least one run")
        keys, first = np.unique(as_keys(content), return_index=True)
        order = np.argsort(first)
        self.keys: Keys = keys[order]
        self._places = first[order].astype(np.int64)

    def _looked_at(self, run: Run) -> tuple[bytes, bool]:
        """Return a setting's key, and whether its runs differ by their seeds, after a check."""
        run.check()
        for name in SHARED:
            value = getattr(run, name)
            if self.shared.setdefault(name, value) != value:
                raise InvalidValue(
                    name,
                    value,
                    "the same in all runs of a study, as errors are summed over it; others have "
                    f"{self.shared[name]}",
                )
        values = list(values_of(run))
        for name, value in run.canonical_changes().items():
            values[_PLACES[name]] = value
        del values[_SEED]
        return setting_key(tuple(values)), run.counts_seed

    def __len__(self) -> int:
        return len(self._places)

    def __iter__(self) -> Iterator[Run]:
        return map(self.__getitem__, range(len(self)))

    @overload
    def __getitem__(self, index: int) -> Run: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[Run, ...]: ...

    def __getitem__(self, index: int | slice) -> Run | tuple[Run, ...]:
        if isinstance(index, slice):
            return tuple(self[k] for k in range(*index.indices(len(self))))
        return self._source[int(self._places[index])].canonical()

    def rows_of(self, table: Table) -> Table:
        """Return the rows of a table whose runs are among these."""
        settings = [setting_key(setting_values(run)) for run in table.settings]
        content = bytearray()
        for number, seed in zip(table.setting.tolist(), table.seeds.tolist(), strict=True):
            content += settings[number] + seed.to_bytes(SEED_BYTES, "big")
        return table.taken(np.flatnonzero(np.isin(as_keys(content), self.keys)))

    def missing(self, keys: Keys) -> NDArray[np.int64]:
        """Return the places of the runs that are not among these keys, in order."""
        there = np.isin(self.keys, keys)
        return np.flatnonzero(~there)
