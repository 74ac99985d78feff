"""Definitions of a C file: types, tables, functions, and reserved names."""

from __future__ import annotations

import re
import textwrap
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fuzzy2.errors import NotExportable
from fuzzy2.export.c_text import words_of
from fuzzy2.export.numbers import Precision
from fuzzy2.export.values import INT, Record, Row, Scalar, Table, Type, Value


@dataclass
class Instance:
    """A kernel translated for known values of some arguments."""

    name: str
    result: Type
    known: Any
    passed: tuple[int, ...]
    text: str = ""


@dataclass
class Definitions(ABC):
    """All C functions, types and tables that the exported functions need.

    Parameters
    ----------
    prefix : str
        Prefix of all names.
    precision : Precision
        Precision of the numbers.
    unrolled : frozenset of str
        Names of kernels whose counted loops are unrolled if their count is known. Each pass is then
        translated with its known values.
    never : frozenset of str
        Names of kernels that return false wherever they are called in the exported code.
    replaced : dict of str to number
        Constants of the kernels' modules, by name, that have other values in this code.
    """

    prefix: str
    precision: Precision
    unrolled: frozenset[str] = frozenset()
    replaced: dict[str, float] = field(default_factory=dict)
    never: frozenset[str] = frozenset()
    instances: dict[Any, Instance] = field(default_factory=dict)
    order: list[Instance] = field(default_factory=list)
    records: dict[str, tuple[str, str]] = field(default_factory=dict)
    tables: dict[str, Table] = field(default_factory=dict)
    open: list[Any] = field(default_factory=list)
    names: set[str] = field(default_factory=set)
    helpers: dict[str, str] = field(default_factory=dict)

    def extreme(self, name: str, which: str) -> str:
        """Return the name of the function for ``min`` or ``max``, with Python's result for NaN."""
        item = self.precision.type if which == "real" else "int"
        sign = "<" if name == "min" else ">"
        return self._helper(
            f"{name}_{which}", f"{item} {{}}({item} a, {item} b)", f"return b {sign} a ? b : a;"
        )

    def division(self, name: str) -> str:
        """Return the name of the function for ``quotient`` or ``remainder`` of whole numbers."""
        if name == "quotient":
            body = "return b == 0 ? 0 : a / b - (a % b != 0 && (a < 0) != (b < 0));"
        else:
            body = "return b == 0 ? 0 : a % b + (a % b != 0 && (a < 0) != (b < 0) ? b : 0);"
        return self._helper(name, "int {}(int a, int b)", body)

    def absolute(self) -> str:
        """Return the name of the function for the absolute value of whole numbers."""
        return self._helper("absolute", "int {}(int a)", "return a < 0 ? -a : a;")

    def real_remainder(self) -> str:
        """Return the name of the function for ``%`` of reals, which has the sign of the divisor."""
        item, zero = self.precision.type, self.precision.literal(0.0)
        body = f"{item} rest = {self.precision.function('fmod')}(a, b);\n"
        body += f"    if (rest == {zero}) {{\n"
        body += f"        return {self.precision.function('copysign')}({zero}, b);\n    }}\n"
        body += f"    return (b < {zero}) != (rest < {zero}) ? rest + b : rest;"
        return self._helper("real_remainder", f"{item} {{}}({item} a, {item} b)", body)

    def cleared(self) -> str:
        """Return the name of the function that fills memory with zeros and returns it."""
        item = self.precision.type
        body = "int i;\n    for (i = 0; i < n; i++) {\n        p[i] = 0;\n    }\n    return p;"
        return self._helper("cleared", f"{item} *{{}}({item} *p, int n)", body)

    def _helper(self, name: str, head: str, body: str) -> str:
        """Return the name of a helper function that replaces a built-in function of Python."""
        own = f"{self.prefix}_{name}"
        self.names.add(own)
        self.helpers[own] = f"static {head.format(own)}\n{{\n    {body}\n}}"
        return own

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
        """Return the name in C of a table, which is added to the definitions."""
        known = self.tables.setdefault(table.name, table)
        if known.numbers is not table.numbers and not np.array_equal(
            known.numbers, table.numbers, equal_nan=known.numbers.dtype.kind == "f"
        ):
            raise NotExportable(table.name, "two tables have the same name", "a report of this bug")
        return f"{self.prefix}_{table.name}"

    def handed(self, value: Value) -> Value:
        """Return a value as an argument; a known table gets its address and sizes."""
        code = value.code
        if isinstance(value.type, Row) and isinstance(value.known, Table):
            sizes = ", ".join(str(size) for size in value.type.shape)
            place = f"{self.table(value.known)} + {value.known.start}"
            code = f"({self.c_type(value.type)}){{{place}, {sizes}}}"
        elif isinstance(value.type, Record) and value.is_known:
            code = self.literal(value)
        return Value(value.type, code, value.known)

    def literal(self, value: Value) -> str:
        """Return a record as a struct literal."""
        codes = ", ".join(self.handed(part).code for part in value.known.values())
        return f"({self.c_type(value.type)}){{{codes}}}"

    @abstractmethod
    def call(self, function: Callable[..., Any], arguments: list[Value]) -> Value:
        """Return the value of a call of a kernel, which is translated first if necessary."""

    def reserved(self, name: str) -> str:
        """Reserve a name for an exported function; return the new name of a kernel that had it.

        If no kernel had the name, the name itself is returned.
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

    def definitions(self, calls: str) -> str:
        """Return the definitions of all types, tables and functions that calls need.

        Each is defined before it is used. Objects that were only read while the code was written
        are left out.
        """
        texts = {instance.name: instance.text for instance in self.order} | self.helpers
        wanted: set[str] = set()
        waiting = [calls]
        while waiting:
            found = words_of(waiting.pop())
            waiting += [texts[word] for word in found & texts.keys() - wanted]
            wanted |= found
        types, needed = [], set(wanted)
        # Structs may contain those before them.
        for name, members in reversed(self.records.values()):
            if name in needed:
                needed |= words_of(members)
                types.append(f"typedef struct {{ {members} }} {name};")
        tables = [
            self._table_text(table)
            for table in self.tables.values()
            if f"{self.prefix}_{table.name}" in wanted
        ]
        parts = [
            "\n".join(reversed(types)),
            "\n".join(tables),
            *(text for name, text in self.helpers.items() if name in wanted),
            "\n".join(one.text for one in self.order if one.name in wanted),
        ]
        return "\n\n".join(part for part in parts if part)

    def _table_text(self, table: Table) -> str:
        whole = table.numbers.dtype.kind in "iub"
        numbers = table.numbers.tolist() or [0]
        texts = [str(int(n)) if whole else self.precision.literal(n) for n in numbers]
        item = "int" if whole else self.precision.type
        lines = textwrap.fill(", ".join(texts), 96, initial_indent="    ", subsequent_indent="    ")
        return f"static const {item} {self.prefix}_{table.name}[{len(numbers)}] = {{\n{lines}\n}};"


def _snake(name: str) -> str:
    return "".join("_" + c.lower() if c.isupper() and i else c.lower() for i, c in enumerate(name))
