"""State of a kernel's translation: variables, their types, and memory."""

from __future__ import annotations

import ast
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

from fuzzy2.errors import NotExportable
from fuzzy2.export.c_text import RESERVED, members
from fuzzy2.export.definitions import Definitions
from fuzzy2.export.kernel_source import source_of
from fuzzy2.export.values import (
    NOTHING,
    REAL,
    Record,
    Row,
    Scalar,
    Type,
    Value,
    joined,
)

Known = dict[str, Value]
"""Value of each variable at a place in the code."""


class Frame(ABC):
    """Translation of a kernel to C, for known values of some arguments."""

    def __init__(
        self, program: Definitions, body: Callable[..., Any], arguments: list[Value]
    ) -> None:
        self.program, self.body = program, body
        self.source = source_of(body)
        self.tree = self.source.tree
        names = [argument.arg for argument in self.tree.args.args]
        if len(names) != len(arguments):
            raise self.refused(self.tree, "it is called with a wrong number of arguments")
        self.parameters = list(zip(names, arguments, strict=True))
        self.passed = tuple(i for i, (_, v) in enumerate(self.parameters) if not v.is_known)
        self.types: dict[str, Type] = {}
        self.buffers: list[str] = []
        self.result: Type = NOTHING
        self.count = 0
        self.variables = self.source.assigned(self.tree.body) | set(names)
        for name in sorted(self.variables & RESERVED):
            raise self.refused(self.tree, f"{name} is a word of C, which cannot name a variable")

    @abstractmethod
    def expression(self, node: ast.expr, known: Known) -> Value:
        """Translate an expression."""

    def refused(self, node: Any, why: str) -> NotExportable:
        """Return the error for code that cannot be translated to C."""
        text = ast.unparse(node).splitlines()[0] if isinstance(node, ast.AST) else str(node)
        where = f"{self.source.place(node)}, in {self.body.__name__}: {text}"
        return NotExportable(where, why, "code that docs/concepts/kernels.md allows")

    # -------------------------------------------------------------------------------- variables
    def temporary(self, base: str, kind: Type) -> str:
        """Return the name of a new variable."""
        self.count += 1
        name = f"{base}_{self.count}"
        self.types[name] = kind
        return name

    def declare(self, node: Any, name: str, kind: Type) -> None:
        """Record that a variable has values of a type."""
        if name not in self.types:
            self.types[name] = kind
            return
        try:
            self.types[name] = joined(self.types[name], kind)
        except TypeError as error:
            raise self.refused(node, f"{name} has values of different types") from error

    def unknown(self, node: Any, name: str) -> Value:
        """Return a variable of which only the type is known."""
        if name not in self.types:
            raise self.refused(node, f"{name} is a different table in each branch")
        return self.named(name, self.types[name])

    def named(self, name: str, kind: Type) -> Value:
        """Return a variable of a given type."""
        if isinstance(kind, Record):
            fields = {
                field: Value(sizeless(part), f"{name}.{field}") for field, part in kind.fields
            }
            return Value(kind, name, fields)
        return Value(sizeless(kind), name)

    # ------------------------------------------------------------------------------------ types
    def cast(self, value: Value, kind: Type) -> Value:
        """Return a value converted to a type."""
        if value.type == kind or not isinstance(kind, Scalar):
            return self._loosened(value, kind)
        if not isinstance(value.type, Scalar):
            raise self.refused(value.code, f"it is not a {kind.name}")
        if value.known is not None:
            return self.program.precision.number(value.known, kind)
        if kind == REAL:
            return Value(REAL, f"({self.program.precision.type})({value.code})")
        return Value(kind, value.code)

    def common(self, node: Any, one: Value, other: Value) -> Scalar:
        """Return the common type of two numbers."""
        if not (isinstance(one.type, Scalar) and isinstance(other.type, Scalar)):
            raise self.refused(node, "an array is used where a number is expected")
        kind = joined(one.type, other.type)
        assert isinstance(kind, Scalar)
        return kind

    def _loosened(self, value: Value, kind: Type) -> Value:
        """Return a part of an array as read-only if that is required."""
        if (
            isinstance(kind, Row)
            and isinstance(value.type, Row)
            and kind.constant
            and not value.type.constant
        ):
            return Value(kind, self.struct(kind, *self.place_and_sizes(value)))
        return value

    # ------------------------------------------------------------------------ arrays and records
    def struct(self, kind: Row, place: str, *sizes: str) -> str:
        """Return a part of an array as a struct literal."""
        return f"({self.program.c_type(kind)}){{{', '.join((place, *sizes))}}}"

    def place_and_sizes(self, value: Value) -> list[str]:
        """Return the address of an array's first entry, and its sizes."""
        assert isinstance(value.type, Row)
        written = members(value.code)
        return written or [
            f"{value.code}.p",
            *(f"{value.code}.{size}" for size in "nm"[: len(value.type.shape)]),
        ]

    def handed(self, value: Value) -> Value:
        """Return a value as an argument; known tables get their address and sizes."""
        return self.program.handed(value)

    def record(self, name: str, parts: list[tuple[str, Value]]) -> Value:
        """Return several values as a record."""
        kind = Record(name, tuple((field, part.type) for field, part in parts))
        code = ""
        if not all(part.is_known for _, part in parts):
            codes = ", ".join(self.handed(part).code for _, part in parts)
            code = f"({self.program.c_type(forgotten(kind))}){{{codes}}}"
        return Value(kind, code, dict(parts))

    def field(self, whole: Value, name: str) -> Value:
        """Return one value of a record."""
        assert isinstance(whole.type, Record)
        if isinstance(whole.known, dict) and name in whole.known:
            part: Value = whole.known[name]
            return part
        return Value(sizeless(whole.type[name]), f"{whole.code}.{name}")


def sizeless(kind: Type) -> Type:
    """Return the type without sizes that may differ between branches."""
    if isinstance(kind, Row):
        return Row(kind.item, kind.constant, tuple(None for _ in kind.shape))
    return kind


def forgotten(kind: Record) -> Record:
    """Return the type of a record without the sizes of its arrays."""
    return Record(
        kind.name,
        tuple(
            (name, forgotten(part) if isinstance(part, Record) else sizeless(part))
            for name, part in kind.fields
        ),
    )
