"""Keys of 24 bytes that identify runs in a file, and the runs of a study by key.

A key is a hash of the setting, which is all fields but the seed, followed by the seed. The keys of
a million runs take 24 MB; the ``Run`` objects are made on access.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from hashlib import blake2b
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from psp3.checks import checked_kind, listed
from psp3.errors import InvalidValue
from psp3.study.columns import Column, RunColumns, blocks_of
from psp3.study.grids import Grid
from psp3.study.run import (
    AMOUNTS,
    LARGEST_INTEGER,
    LEAST_SNR_OF_PLANT,
    Run,
    Value,
    field_types,
    values_of,
    variation_of,
)
from psp3.study.table import Table

SHARED = ("duration",)
"""Fields that are the same in all runs of a file. Errors are sums over this time, and sums over
different times must not share a table.
"""

SETTING_BYTES, SEED_BYTES = 16, 8

KEYS = np.dtype(f"S{SETTING_BYTES + SEED_BYTES}")
"""NumPy type of the keys. NumPy drops trailing zero bytes, but keys of one length still stay
different.
"""

Keys = NDArray[np.bytes_]

_SEED = list(field_types()).index("seed")
_NAMES = tuple(name for name in field_types() if name != "seed")


def setting_values(run: Run) -> tuple[Value, ...]:
    """Return the values of all fields but the seed, in their order."""
    values = values_of(run)
    return values[:_SEED] + values[_SEED + 1 :]


def setting_names() -> tuple[str, ...]:
    """Return the names of all fields but the seed, in their order."""
    return _NAMES


def setting_key(values: tuple[Value, ...]) -> bytes:
    """Return the key of a setting: a hash of the text of its values in order.

    Numbers are written with enough digits to be unique.
    """
    text = repr(values)
    if "-0.0" in text:
        # Equal numbers must give one setting.
        text = repr(tuple(v + 0.0 if type(v) is float else v for v in values))
    return blake2b(text.encode(), digest_size=SETTING_BYTES).digest()


def setting_keys(runs: RunColumns) -> list[bytes]:
    """Return the keys of the settings of many runs; text that all share is written once."""
    words, columns = [], []
    for name in _NAMES:
        column = runs.columns[name]
        if len(column) == 1:
            words.append(_word(column[0]).replace("%", "%%"))
        else:
            known = {value: _word(value) for value in set(column)}
            words.append("%s")
            columns.append(map(known.__getitem__, column))
    frame = f"({', '.join(words)})"
    texts = zip(*columns, strict=True) if columns else itertools.repeat((), len(runs))
    return [blake2b((frame % text).encode(), digest_size=SETTING_BYTES).digest() for text in texts]


def _word(value: Value) -> str:
    return repr(value + 0.0) if type(value) is float else repr(value)


def key(run: Run) -> bytes:
    """Return the key of a run in canonical form."""
    return setting_key(setting_values(run)) + run.seed.to_bytes(SEED_BYTES, "big")


def as_keys(content: bytes | bytearray) -> Keys:
    """Return concatenated keys as an array."""
    return np.frombuffer(content, dtype=KEYS)


def is_seed(value: object) -> bool:
    """Return whether a value is a seed."""
    return type(value) is int and 0 <= value <= LARGEST_INTEGER


def checked_runs(runs: Iterable[Run]) -> Sequence[Run]:
    """Return runs as a sequence; raise :class:`InvalidValue` if an item is not a run."""
    requirement = "a list of runs, or a grid of them"
    if isinstance(runs, Grid | Runs):
        return runs
    several = listed("runs", runs, requirement)
    for run in several:
        checked_kind("runs", run, Run, requirement)
    return several


class Runs(Sequence[Run]):
    """The runs of a study, each once and in canonical form, in the order given.

    Parameters
    ----------
    runs : iterable of Run
        A sequence is kept without a copy, and read again on access.

    Attributes
    ----------
    keys : (N,) ndarray of bytes
        Keys of the runs.
    shared : dict
        Values of the fields in :data:`SHARED`.

    Raises
    ------
    InvalidValue, UnknownName
        If there are no runs, if they differ in :data:`SHARED` fields, or if one is invalid; see
        :meth:`psp3.study.run.Run.check`.
    """

    def __init__(self, runs: Iterable[Run]) -> None:
        self._source = checked_runs(runs)
        self.shared: dict[str, Any] = {}
        content = bytearray()
        source = self._source
        for block in source.blocks() if isinstance(source, Grid) else blocks_of(source):
            content += b"".join(self._keys_of(block))
        if not content:
            raise InvalidValue("runs", [], "at least one run")
        keys, first = np.unique(as_keys(content), return_index=True)
        order = np.argsort(first)
        self.keys: Keys = keys[order]
        self._places = first[order].astype(np.int64)

    def _keys_of(self, block: RunColumns) -> list[bytes]:
        """Return the keys of the canonical forms of runs, after a check."""
        keys = [b""] * len(block)
        for places in _alike(block):
            runs = block if len(places) == len(block) else block.taken(places)
            first = runs[0]
            self._check(first)
            changed: dict[str, Column] = {
                name: (value,) for name, value in first.canonical_changes().items()
            }
            if first.variation_follows_noise:
                changed["mean_variation"] = [variation_of(v) for v in runs.columns["snr_db"]]
            if not first.counts_seed:
                changed["seed"] = (0,)
            runs = runs.changed(changed)
            seeds: Any = runs.column("seed")
            for place, setting, seed in zip(places, setting_keys(runs), seeds, strict=True):
                keys[place] = setting + seed.to_bytes(SEED_BYTES, "big")
        return keys

    def _check(self, run: Run) -> None:
        run.check()
        for name in SHARED:
            value = getattr(run, name)
            if self.shared.setdefault(name, value) != value:
                raise InvalidValue(
                    name,
                    value,
                    "the same in all runs of a study, because errors are summed over it; others "
                    f"have {self.shared[name]}",
                )

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
        """Return the rows of a table that belong to these runs."""
        settings = setting_keys(table.settings)
        content = bytearray()
        for number, seed in zip(table.setting.tolist(), table.seeds.tolist(), strict=True):
            content += settings[number] + seed.to_bytes(SEED_BYTES, "big")
        return table.taken(np.flatnonzero(np.isin(as_keys(content), self.keys)))

    def missing(self, keys: Keys) -> NDArray[np.int64]:
        """Return the indices of the runs whose keys are not among these, in order."""
        there = np.isin(self.keys, keys)
        return np.flatnonzero(~there)


def _alike(runs: RunColumns) -> list[Sequence[int]]:
    """Return groups of indices of runs that share the outcome of check and canonical form.

    For its amounts, its signal-to-noise ratio and its seeds, both only ask whether they are valid,
    and whether they are zero, infinite or not given.
    """
    classes = [_classes(name, runs.columns[name]) for name in runs.differing]
    if not classes:
        return [range(len(runs))]
    found: dict[tuple[object, ...], list[int]] = {}
    try:
        for place, one in enumerate(zip(*classes, strict=True)):
            found.setdefault(one, []).append(place)
    except TypeError:
        # A value that cannot be hashed is invalid, and the check says so.
        for run in runs:
            run.check()
        raise
    return list(found.values())


def _classes(name: str, column: Column) -> Sequence[object]:
    if name in AMOUNTS:
        return [_USUAL if type(v) is float and 0.0 < v < math.inf else (type(v), v) for v in column]
    if name == "snr_db":
        least = LEAST_SNR_OF_PLANT
        return [
            _USUAL if type(v) is float and least <= v < math.inf else (type(v), v) for v in column
        ]
    if name in ("seed", "learning_seed"):
        return [_USUAL if is_seed(v) else (type(v), v) for v in column]
    if set(map(type, column)) <= {field_types()[name], type(None)}:
        return column
    # True and 1.0 equal 1, but not all three are valid values.
    return list(zip(map(type, column), column, strict=True))


_USUAL = "usual"
