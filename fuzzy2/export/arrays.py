"""Arrays and parts of arrays in kernels: entries, rows, slices, sizes, and memory."""

from __future__ import annotations

import ast
import math
from abc import ABC

from fuzzy2.export.c_text import bare
from fuzzy2.export.frame import Frame, Known
from fuzzy2.export.values import BOOL, INT, REAL, Record, Row, Scalar, Table, Value


class Arrays(Frame, ABC):
    """Translates operations on arrays."""

    def subscript(self, node: ast.Subscript, known: Known) -> Value:
        """Translate an entry or a part of an array, or an entry of a tuple."""
        whole = self.expression(node.value, known)
        if isinstance(whole.type, Record):
            return self._of_tuple(node, whole, known)
        if not isinstance(whole.type, Row):
            raise self.refused(node, "a number has no entries")
        self._of_two_dimensions(node, whole)
        if isinstance(node.slice, ast.Slice):
            return self._part(node, whole, node.slice, known)
        parts = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        if len(parts) > len(whole.type.shape):
            raise self.refused(node, "an array has fewer dimensions than indices")
        places = [self._counted_from(whole, i, self.place(p, known)) for i, p in enumerate(parts)]
        for axis, place in enumerate(places):
            self._within(node, place, whole.type.shape[axis])
        if len(whole.type.shape) == 1:
            return self._entry(whole, places[0])
        column = self.size(whole, 1)
        row = self.sum("*", places[0], column)
        if len(places) == 2:
            return self._entry(whole, self.sum("+", row, places[1]))
        return self._piece(whole, row, column)

    def _of_tuple(self, node: ast.Subscript, whole: Value, known: Known) -> Value:
        """Translate an entry of a tuple, or its first entries."""
        assert isinstance(whole.type, Record)
        names = [name for name, _ in whole.type.fields]
        match node.slice:
            case ast.Slice(lower=None, upper=ast.Constant(value=int() as end), step=None):
                return self.record(
                    "tuple", [(name, self.field(whole, name)) for name in names[:end]]
                )
            case ast.Slice():
                raise self.refused(node, "a part of a tuple must begin with its first entry")
        number = self.place(node.slice, known).known
        if number is None:
            raise self.refused(node, "the index of a tuple's entry must be known")
        if not -len(names) <= number < len(names):
            raise self.refused(node, f"a tuple of {len(names)} does not have this entry")
        return self.field(whole, names[number])

    def place(self, node: ast.expr, known: Known) -> Value:
        """Translate an index or a size."""
        place = self.expression(node, known)
        if place.type == BOOL:
            place = self.cast(place, INT)
        if place.type != INT:
            raise self.refused(node, "an index must be a whole number")
        return place

    def _counted_from(self, whole: Value, axis: int, place: Value) -> Value:
        """Return an index; a known negative index counts from the end."""
        if place.known is not None and place.known < 0:
            return self.sum("+", self.size(whole, axis), place)
        return place

    def _within(self, node: ast.AST, place: Value, size: int | None) -> None:
        """Refuse a known index beyond the end of an array of known size."""
        if place.known is None or size is None:
            return
        if not 0 <= place.known < size:
            raise self.refused(node, f"index {place.known} of {size} entries")

    def sum(self, sign: str, left: Value, right: Value) -> Value:
        """Return a sum, difference or product of whole numbers."""
        number = self.program.precision.number
        a, b = left.known, right.known
        if a is not None and b is not None:
            return number(a + b if sign == "+" else a - b if sign == "-" else a * b, INT)
        # Adding 0 changes nothing.
        if b == (1 if sign == "*" else 0):
            return left
        if (sign == "+" and a == 0) or (sign == "*" and a == 1):
            return right
        if sign == "*" and 0 in (a, b):
            return number(0, INT)
        return Value(INT, f"({left.code} {sign} {right.code})")

    def size(self, whole: Value, axis: int) -> Value:
        """Return the number of entries of an array along an axis."""
        assert isinstance(whole.type, Row)
        size = whole.type.shape[axis]
        if size is not None:
            return self.program.precision.number(size, INT)
        return Value(INT, self.place_and_sizes(whole)[1 + axis])

    def _entry(self, whole: Value, place: Value) -> Value:
        assert isinstance(whole.type, Row)
        table = whole.known
        if isinstance(table, Table):
            if place.known is not None:
                entry = table.numbers[table.start + place.known]
                return self.program.precision.number(entry, whole.type.item)
            start = self.program.precision.number(table.start, INT)
            name = self.program.table(table)
            return Value(whole.type.item, f"{name}[{bare(self.sum('+', start, place).code)}]")
        begin = self.place_and_sizes(whole)[0]
        if " " in begin:
            begin = f"({begin})"
        return Value(whole.type.item, f"{begin}[{bare(place.code)}]")

    def _part(self, node: ast.Subscript, whole: Value, part: ast.Slice, known: Known) -> Value:
        assert isinstance(whole.type, Row)
        if part.step is not None or len(whole.type.shape) != 1:
            raise self.refused(node, "a part must have one dimension and no step")
        start, end = self.program.precision.number(0, INT), self.size(whole, 0)
        if part.lower is not None:
            start = self._counted_from(whole, 0, self.place(part.lower, known))
        if part.upper is not None:
            end = self._counted_from(whole, 0, self.place(part.upper, known))
        size = whole.type.shape[0]
        if None not in (start.known, end.known, size) and not 0 <= start.known <= end.known <= size:
            raise self.refused(node, f"entries {start.known} to {end.known} of {size}")
        return self._piece(whole, start, self._difference(end, start))

    def _difference(self, end: Value, start: Value) -> Value:
        """Return end - start; ``o + n`` minus ``o`` gives n."""
        longer = end.code.startswith(f"({start.code} + ") and end.code.endswith(")")
        if start.known is None and longer:
            rest = end.code[len(start.code) + 4 : -1]
            if rest.isdigit():
                return self.program.precision.number(int(rest), INT)
        return self.sum("-", end, start)

    def _piece(self, whole: Value, start: Value, size: Value) -> Value:
        """Return the ``size`` entries that begin at ``start``."""
        assert isinstance(whole.type, Row)
        kind = Row(whole.type.item, whole.type.constant, (size.known,))
        table = whole.known
        if isinstance(table, Table):
            here = None
            if start.known is not None and size.known is not None:
                here = Table(table.name, table.numbers, table.start + start.known)
            begin = self.sum("+", self.program.precision.number(table.start, INT), start)
            place = f"{self.program.table(table)} + {begin.code}"
            return Value(kind, self.struct(kind, place, size.code), here)
        place = self.place_and_sizes(whole)[0]
        if start.known != 0:
            place = f"{place} + {start.code}"
        return Value(kind, self.struct(kind, place, size.code))

    def _of_two_dimensions(self, node: ast.AST, whole: Value) -> None:
        """Refuse arrays with more than two dimensions."""
        assert isinstance(whole.type, Row)
        if not 1 <= len(whole.type.shape) <= 2:
            raise self.refused(node, "an array must have one or two dimensions")

    def shape(self, node: ast.Attribute, whole: Value) -> Value:
        """Translate ``array.shape`` and ``array.size``."""
        assert isinstance(whole.type, Row)
        self._of_two_dimensions(node, whole)
        sizes = [self.size(whole, axis) for axis in range(len(whole.type.shape))]
        if node.attr == "shape":
            return self.record("tuple", [(f"f{i}", size) for i, size in enumerate(sizes)])
        if node.attr == "size":
            return sizes[0] if len(sizes) == 1 else self.sum("*", sizes[0], sizes[1])
        raise self.refused(node, "an array in a kernel does not have this attribute")

    def reshaped(self, node: ast.Call, whole: Value, known: Known) -> Value:
        """Translate ``array.reshape(n, m)``."""
        assert isinstance(whole.type, Row)
        sizes = [self.place(argument, known) for argument in node.args]
        if not 1 <= len(sizes) <= 2:
            raise self.refused(node, "an array must have at most two dimensions")
        shape = tuple(size.known for size in sizes)
        if any(size is not None and size < 0 for size in shape):
            raise self.refused(node, "a size must not be negative")
        known_sizes, had = [n for n in shape if n is not None], whole.type.shape
        if None not in (*shape, *had) and math.prod(known_sizes) != math.prod(n or 0 for n in had):
            raise self.refused(node, f"an array of shape {had} cannot have the shape {shape}")
        kind = Row(whole.type.item, whole.type.constant, shape)
        codes = [size.code for size in sizes]
        table = whole.known
        if isinstance(table, Table):
            here = table if None not in kind.shape else None
            place = f"{self.program.table(table)} + {table.start}"
            return Value(kind, self.struct(kind, place, *codes), here)
        return Value(kind, self.struct(kind, self.place_and_sizes(whole)[0], *codes))

    def memory(self, node: ast.Call, zeros: bool, known: Known) -> Value:
        """Translate ``np.empty`` and ``np.zeros``, whose size must be known."""
        if len(node.args) != 1:
            raise self.refused(node, "memory must hold floats")
        shape = node.args[0].elts if isinstance(node.args[0], ast.Tuple) else [node.args[0]]
        sizes = [self.place(size, known) for size in shape]
        if any(size.known is None for size in sizes):
            raise self.refused(node, "the size of memory must be known when the code is written")
        if not 1 <= len(sizes) <= 2 or min(size.known for size in sizes) < 0:
            raise self.refused(node, "memory must have at most two dimensions and no negative size")
        self.count += 1
        buffer = f"memory_{self.count}"
        total = max(math.prod(size.known for size in sizes), 1)
        self.buffers.append(f"    {self.program.precision.type} {buffer}[{total}];")
        kind = Row(REAL, False, tuple(size.known for size in sizes))
        place = buffer
        if zeros:
            # Memory is cleared at each call, and in each pass of a loop.
            place = f"{self.program.cleared()}({buffer}, {total})"
        return Value(kind, self.struct(kind, place, *(size.code for size in sizes)))

    def filled(self, target: ast.Subscript, value: Value, known: Known, space: str) -> list[str]:
        """Translate ``array[a:b] = value``."""
        part = self.subscript(ast.Subscript(target.value, target.slice, ast.Load()), known)
        assert isinstance(part.type, Row)
        if part.type.constant:
            raise self.refused(target, "the table is read-only")
        i, row = self.temporary("i", INT), self.temporary("part", part.type)
        lines = [f"{space}{row} = {part.code};"]
        if isinstance(value.type, Row):
            other = self.temporary("other", value.type)
            lines.append(f"{space}{other} = {self.handed(value).code};")
            item = self.cast(Value(value.type.item, f"{other}.p[{i}]"), part.type.item).code
        elif isinstance(value.type, Scalar):
            kind = part.type.item
            item = self.cast(value, kind).code
            if value.known is None:
                # Evaluated once, because it may read entries that are written.
                name = self.temporary("value", kind)
                lines.append(f"{space}{name} = {bare(item)};")
                item = name
        else:
            raise self.refused(target, "a part of an array cannot be set to several values")
        return [
            *lines,
            f"{space}for ({i} = 0; {i} < {row}.n; {i}++) {{",
            f"{space}    {row}.p[{i}] = {bare(item)};",
            f"{space}}}",
        ]
