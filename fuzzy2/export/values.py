"""Values in translated kernels: their types, their C code, and known numbers."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from fuzzy2.support.checks import Array


@dataclass(frozen=True)
class Scalar:
    """A number: ``real``, ``int`` or ``bool``."""

    name: str


REAL, INT, BOOL, NOTHING = Scalar("real"), Scalar("int"), Scalar("bool"), Scalar("void")


@dataclass(frozen=True)
class Row:
    """Part of an array of one or two dimensions: its beginning and its sizes.

    ``item`` is REAL or INT, ``constant`` is true for a read-only part, and ``shape`` has None for
    each size that is only known at run time.
    """

    item: Scalar
    constant: bool
    shape: tuple[int | None, ...]


@dataclass(frozen=True)
class Record:
    """Named values: a NamedTuple, or a tuple with the names ``f0``, ``f1`` and so on.

    ``made`` is the class of the NamedTuple, if known.
    """

    name: str
    fields: tuple[tuple[str, Any], ...]
    made: Any = field(default=None, compare=False)

    def __getitem__(self, name: str) -> Any:
        """Return the type of a field."""
        return dict(self.fields)[name]


Type = Scalar | Row | Record


@dataclass(frozen=True)
class Table:
    """Known numbers, from a place on: an array in C.

    ``numbers`` is flat. Two tables are equal if they are the same array object.
    """

    name: str
    numbers: Array = field(compare=False)
    start: int = 0


@dataclass(frozen=True)
class Value:
    """Value of an expression.

    ``known`` is a number, a :class:`Table`, a dict of the values of a record, or None.
    """

    type: Type
    code: str
    known: Any = None

    @property
    def is_known(self) -> bool:
        """Whether no part of it has to be passed at run time."""
        if isinstance(self.type, Record):
            return isinstance(self.known, dict) and all(v.is_known for v in self.known.values())
        if isinstance(self.type, Row):
            return self.known is not None and None not in self.type.shape
        return self.known is not None

    @property
    def key(self) -> Any:
        """Key that distinguishes the translated functions for different values of an argument."""
        if isinstance(self.known, dict):
            return self.type, tuple((name, value.key) for name, value in self.known.items())
        if isinstance(self.known, float) and self.known != self.known:
            return self.type, "nan"
        return self.type, type(self.known).__name__, self.known


def joined(one: Type, other: Type) -> Type:
    """Return the common type of a variable that has values of both types."""
    if one == other:
        return one
    if isinstance(one, Scalar) and isinstance(other, Scalar):
        order = [BOOL, INT, REAL]
        return max(one, other, key=order.index)
    if isinstance(one, Row) and isinstance(other, Row) and one.item == other.item:
        same = tuple(a if a == b else None for a, b in zip(one.shape, other.shape, strict=True))
        return Row(one.item, one.constant or other.constant, same)
    if isinstance(one, Record) and isinstance(other, Record) and one.name == other.name:
        pairs = zip(one.fields, other.fields, strict=True)
        return Record(one.name, tuple((a[0], joined(a[1], b[1])) for a, b in pairs))
    raise TypeError(one, other)
