"""Translation of compiled kernels to C99, from their Python source.

There is a single source: the Python code that numba compiles is also translated to C. A kernel is
translated for the known values of its arguments. Tables become ``static const`` arrays, known
numbers become literals, branches that are never taken are left out, and a call whose arguments are
all known is evaluated during the translation.

``docs/concepts/kernels.md`` lists what kernels may contain: numbers, flat arrays and parts of them,
NamedTuples of these, counted loops, branches, and calls of other kernels.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from fuzzy2.errors import NotExportable
from fuzzy2.export.definitions import Definitions, Instance
from fuzzy2.export.function import Translation
from fuzzy2.export.values import BOOL, NOTHING, Record, Row, Scalar, Table, Value


@dataclass
class Program(Definitions):
    """Kernels translated to C functions, with the types and tables that they need."""

    def call(self, function: Callable[..., Any], arguments: list[Value]) -> Value:
        """Return the value of a call of a kernel, which is translated first if necessary."""
        body = body_for(function, arguments[0] if arguments else None)
        if body.__name__ in self.never:
            return self.precision.number(False, BOOL)
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
            known: Value = instance.known
            return known
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


def body_for(function: Any, first: Value | None) -> Callable[..., Any]:
    """Return the Python function of a kernel, or of the body that its first argument chooses."""
    bodies = getattr(function, "bodies", None)
    if bodies is not None:
        kind = first.type.name if first is not None and isinstance(first.type, Record) else ""
        found = [body for table, body in bodies.items() if table.__name__ == kind]
        if not found:
            raise NotExportable(function.__name__, f"no body for {kind or 'this'}", "another table")
        function = found[0]
    body: Callable[..., Any] = getattr(function, "py_func", function)
    return body


def python_of(value: Value) -> Any:
    """Return the Python object for a known value."""
    if isinstance(value.known, Table):
        assert isinstance(value.type, Row)
        size = math.prod(int(n or 0) for n in value.type.shape)
        part = value.known.numbers[value.known.start : value.known.start + size]
        return part.reshape(value.type.shape)
    if isinstance(value.known, dict):
        assert isinstance(value.type, Record)
        parts = [python_of(part) for part in value.known.values()]
        return value.type.made(*parts) if value.type.made else tuple(parts)
    return value.known
