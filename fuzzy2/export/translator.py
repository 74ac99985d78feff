"""Translate compiled kernels to C99, from their own source.

There is one truth: the Python source that numba compiles is also what becomes C. A kernel is
translated for what is known of its arguments. Tables are ``static const`` arrays, numbers that are
known are written down, branches that are never taken are left out, and a function of which nothing
is unknown is called here and now.

What a kernel may use is in ``docs/concepts/kernels.md``: numbers, flat arrays and parts of them,
NamedTuples of these, counted loops, branches, and calls of other kernels.
"""

from __future__ import annotations

import ast
import inspect
import math
import re
import textwrap
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fuzzy2.errors import NotExportable
from fuzzy2.export.function import Translation
from fuzzy2.export.numbers import Precision
from fuzzy2.export.values import (
    BOOL,
    INT,
    NOTHING,
    REAL,
    Record,
    Row,
    Scalar,
    Table,
    Type,
    Value,
)


@dataclass
class Instance:
    """A kernel translated for what is known of its arguments."""

    name: str
    result: Type
    known: Any
    passed: tuple[int, ...]
    text: str = ""


@dataclass
class Program:
    """All C functions, types and tables that what is exported needs.

    Parameters
    ----------
    prefix : str
        What names begin with.
    precision : Precision
        How numbers are written.
    unrolled : frozenset of str
        Names of kernels whose counted loops are written out where their count is known: each pass
        is then translated for what is known in it.
    replaced : dict of str to number
        Numbers of the kernels' modules, by name, that are others in this code.
    """

    prefix: str
    precision: Precision
    unrolled: frozenset[str] = frozenset()
    replaced: dict[str, float] = field(default_factory=dict)
    instances: dict[Any, Instance] = field(default_factory=dict)
    order: list[Instance] = field(default_factory=list)
    records: dict[str, tuple[str, str]] = field(default_factory=dict)
    tables: dict[str, Table] = field(default_factory=dict)
    open: list[Any] = field(default_factory=list)
    names: set[str] = field(default_factory=set)

    def c_type(self, kind: Type) -> str:
        """Return the name of a type in C."""
        if isinstance(kind, Scalar):
            return {"real": self.precision.type, "bool": "int"}.get(kind.name, kind.name)
        if isinstance(kind, Row):
            what = "whole" if kind.item == INT else "real"
            access = "table" if kind.constant else "row"
            name = f"{self.prefix}_{what}_{access}" + ("2" if len(kind.shape) == 2 else "")
            item = self.c_type(kind.item)
            sizes = "int n; int m;" if len(kind.shape) == 2 else "int n;"
            constant = "const " if kind.constant else ""
            self.records.setdefault(name, (name, f"{constant}{item} *p; {sizes}"))
            return name
        members = " ".join(f"{self.c_type(part)} {name};" for name, part in kind.fields)
        key = f"{kind.name} {members}"
        if key not in self.records:
            self.records[key] = self._name(_snake(kind.name)), members
        return self.records[key][0]

    def table(self, table: Table) -> str:
        """Return the name in C of a table, which is written down."""
        known = self.tables.setdefault(table.name, table)
        if known.numbers is not table.numbers and not np.array_equal(
            known.numbers, table.numbers, equal_nan=known.numbers.dtype.kind == "f"
        ):
            raise NotExportable(table.name, "two tables of one name", "report it: a fault of ours")
        return f"{self.prefix}_{table.name}"

    def written(self, value: Value) -> Value:
        """Return a thing that is known with its numbers written down."""
        if isinstance(value.known, dict):
            parts = {name: self.written(part) for name, part in value.known.items()}
            return Value(value.type, value.code, parts)
        if isinstance(value.type, Scalar) and value.known is not None:
            return self.precision.number(value.known, value.type)
        return value

    def handed(self, value: Value) -> Value:
        """Return a value as it is handed over: what is known gets a place and sizes."""
        code = value.code
        if isinstance(value.type, Row) and isinstance(value.known, Table):
            sizes = ", ".join(str(size) for size in value.type.shape)
            place = f"{self.table(value.known)} + {value.known.start}"
            code = f"({self.c_type(value.type)}){{{place}, {sizes}}}"
        elif isinstance(value.type, Record) and value.is_known:
            code = self.literal(value)
        return Value(value.type, code, value.known)

    def literal(self, value: Value) -> str:
        """Return a record written out."""
        codes = ", ".join(self.handed(part).code for part in value.known.values())
        return f"({self.c_type(value.type)}){{{codes}}}"

    def call(self, function: Callable[..., Any], arguments: list[Value]) -> Value:
        """Return what a call of a kernel stands for; it is translated if it is not yet."""
        body = body_for(function, arguments[0] if arguments else None)
        key = (body, *(argument.key for argument in arguments))
        if key in self.open:
            wanted = "kernels that do not call themselves"
            raise NotExportable(body.__name__, "it calls itself", wanted)
        if key not in self.instances:
            self.open.append(key)
            self.instances[key] = self._translated(body, arguments)
            self.open.pop()
        instance = self.instances[key]
        if instance.known is not None:
            return instance.known
        codes = ", ".join(arguments[i].code for i in instance.passed)
        return Value(instance.result, f"{instance.name}({codes})")

    def _translated(self, body: Callable[..., Any], arguments: list[Value]) -> Instance:
        translation = Translation(self, body, arguments)
        if arguments and all(argument.is_known for argument in arguments):
            translation.translate()
            if isinstance(translation.result, Scalar) and translation.result != NOTHING:
                number = body(*(python_of(argument) for argument in arguments))
                known = self.precision.number(number, translation.result)
                return Instance("", translation.result, known, ())
        name = self._name(body.__name__.lstrip("_"))
        translation.translate()
        instance = Instance(
            name, translation.result, None, translation.passed, translation.text(name)
        )
        self.order.append(instance)
        return instance

    def reserved(self, name: str) -> str:
        """Keep a name for a function that users call; return that of the kernel which had it.

        That is its new one, or the name itself if no kernel had it.
        """
        if name not in self.names:
            self.names.add(name)
            return name
        other = self._name(name.removeprefix(f"{self.prefix}_"))
        for instance in self.order:
            instance.name = other if instance.name == name else instance.name
            instance.text = re.sub(rf"\b{name}\b", other, instance.text)
        return other

    def _name(self, base: str) -> str:
        name, count = f"{self.prefix}_{base}", 1
        while name in self.names:
            count += 1
            name = f"{self.prefix}_{base}_{count}"
        self.names.add(name)
        return name

    def types(self) -> str:
        """Return the declarations of all types."""
        return "\n".join(
            f"typedef struct {{ {members} }} {name};" for name, members in self.records.values()
        )

    def constants(self, words: set[str]) -> str:
        """Return the definitions of the tables whose names are among the words."""
        return "\n".join(
            self._table_text(table)
            for name, table in self.tables.items()
            if f"{self.prefix}_{name}" in words
        )

    def _table_text(self, table: Table) -> str:
        whole = table.numbers.dtype.kind in "iub"
        numbers = table.numbers.tolist() or [0]
        texts = [str(int(n)) if whole else self.precision.literal(n) for n in numbers]
        item = "int" if whole else self.precision.type
        lines = textwrap.fill(", ".join(texts), 96, initial_indent="    ", subsequent_indent="    ")
        return f"static const {item} {self.prefix}_{table.name}[{len(numbers)}] = {{\n{lines}\n}};"

    def functions(self) -> str:
        """Return the definitions of all functions, each before it is called."""
        return "\n".join(instance.text for instance in self.order)


def body_for(function: Any, first: Value | None) -> Callable[..., Any]:
    """Return the Python function of a kernel, or of one that is chosen by its first argument."""
    bodies = getattr(function, "bodies", None)
    if bodies is not None:
        kind = first.type.name if first is not None and isinstance(first.type, Record) else ""
        found = [body for table, body in bodies.items() if table.__name__ == kind]
        if not found:
            raise NotExportable(function.__name__, f"no body for {kind or 'this'}", "another table")
        function = found[0]
    return getattr(function, "py_func", function)


def python_of(value: Value) -> Any:
    """Return the Python object that a known value stands for."""
    if isinstance(value.known, Table):
        assert isinstance(value.type, Row)
        size = math.prod(int(n or 0) for n in value.type.shape)
        part = value.known.numbers[value.known.start : value.known.start + size]
        return part.reshape(value.type.shape)
    if isinstance(value.known, dict):
        return _Fields({name: python_of(part) for name, part in value.known.items()})
    return value.known


class _Fields:
    """A record for a Python function that asks for fields by name, or all in order."""

    def __init__(self, fields: dict[str, Any]) -> None:
        self.__dict__.update(fields)

    def __iter__(self) -> Iterable[Any]:
        return iter(self.__dict__.values())


def source_of(body: Callable[..., Any]) -> ast.FunctionDef:
    """Return the syntax of a kernel."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(body))).body[0]
    assert isinstance(tree, ast.FunctionDef)
    return tree


def _snake(name: str) -> str:
    return "".join("_" + c.lower() if c.isupper() and i else c.lower() for i, c in enumerate(name))


__all__ = ["BOOL", "INT", "REAL", "Program", "Value", "body_for", "source_of"]
