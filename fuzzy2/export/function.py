"""Translation of one kernel to a function in C: its statements, and the known values after each."""

from __future__ import annotations

import ast

from fuzzy2.export.c_text import bare, comment, ends, otherwise, without_idle, words_of
from fuzzy2.export.expressions import Expressions
from fuzzy2.export.frame import Known, forgotten
from fuzzy2.export.kernel_source import jumps
from fuzzy2.export.values import INT, NOTHING, Record, Row, Scalar, Table, Type, Value, joined

MOST_PASSES = 16
"""Greatest number of passes of a loop that is unrolled, in functions that allow it."""


class Translation(Expressions):
    """Translation of a kernel to C, for known values of some arguments."""

    def translate(self) -> None:
        """Translate the body, repeatedly until the types of all variables are found."""
        before: dict[str, Type] | None = None
        changed = self.source.assigned(self.tree.body)
        while before != self.types:
            before = self.types
            self.types = {name: kind for name, kind in before.items() if name in self.variables}
            self.buffers, self.count = [], 0
            self.lines: list[str] = []
            known: Known = {}
            for name, value in self.parameters:
                if not value.is_known:
                    self.declare(self.tree, name, value.type)
                    known[name] = self._parameter(name, value)
                elif name in changed and isinstance(value.type, Scalar):
                    # A parameter with a known initial value may be assigned later, so it needs a
                    # variable in C.
                    self.lines += self._assign_name(self.tree, name, value, known, "    ")
                else:
                    known[name] = value
            self.lines += self.block(self.tree.body, known, 1)

    def _parameter(self, name: str, value: Value) -> Value:
        """Return a parameter by its name, with the known values of its fields."""
        known = value.known
        if isinstance(value.type, Record) and isinstance(known, dict):
            known = {
                field: part if part.is_known else self._parameter(f"{name}.{field}", part)
                for field, part in known.items()
            }
        elif isinstance(value.type, Record | Row):
            known = None
        return Value(value.type, name, known)

    def text(self, name: str) -> str:
        """Return the function as C."""
        parameters = [
            f"{self.program.c_type(self.types[self.parameters[i][0]])} {self.parameters[i][0]}"
            for i in self.passed
        ]
        names = {self.parameters[i][0] for i in self.passed}
        lines = without_idle(self.lines, set(self.types) - names)
        used = words_of("\n".join(lines))
        declared = [
            f"    {self.program.c_type(kind)} {variable};"
            for variable, kind in self.types.items()
            if variable not in names and variable in used
        ]
        buffers = [line for line in self.buffers if line.split("[")[0].split()[-1] in used]
        idle = [f"    (void){variable};" for variable in sorted(names - used)]
        title = (ast.get_docstring(self.tree) or self.tree.name).splitlines()[0]
        head = (
            f"static {self.program.c_type(self.result)} {name}({', '.join(parameters) or 'void'})"
        )
        body = "\n".join([*declared, *buffers, *idle, *lines])
        return f"/* {comment(title)} */\n{head}\n{{\n{body}\n}}\n"

    # ------------------------------------------------------------------------------- statements
    def block(self, body: list[ast.stmt], known: Known, depth: int) -> list[str]:
        """Translate statements in order, and update ``known`` accordingly."""
        lines: list[str] = []
        for statement in body:
            lines += self.statement(statement, known, depth)
            if lines and ends(lines[-1]):
                break
        return lines

    def statement(self, node: ast.stmt, known: Known, depth: int) -> list[str]:
        """Translate a statement."""
        try:
            return self._statement(node, known, depth)
        except OverflowError as error:
            raise self.refused(node, str(error)) from error

    def _statement(self, node: ast.stmt, known: Known, depth: int) -> list[str]:
        space = "    " * depth
        match node:
            case ast.Expr(value=ast.Constant()) | ast.Pass():
                return []
            case ast.Expr(value=value):
                said = self.expression(value, known)
                return [] if said.is_known else [f"{space}{said.code};"]
            case ast.Return(value=value):
                return self._return(node, value, known, space)
            case ast.Continue():
                return [f"{space}continue;"]
            case ast.Break():
                return [f"{space}break;"]
            case ast.If():
                return self._branch(node, known, depth)
            case ast.While():
                return self._while(node, known, depth)
            case ast.For():
                return self._for(node, known, depth)
            case ast.AugAssign(target=target):
                said = self.expression(self.source.combined(node), known)
                return self._assign(target, said, known, space)
            case ast.AnnAssign(target=target, value=value) if value is not None:
                return self._assign_node(target, value, known, space)
            case ast.Assign(targets=targets, value=value):
                return self._assign_all(targets, value, known, space)
        raise self.refused(node, "a kernel cannot contain this statement")

    def _return(
        self, node: ast.Return, value: ast.expr | None, known: Known, space: str
    ) -> list[str]:
        if value is None or (isinstance(value, ast.Constant) and value.value is None):
            return [f"{space}return;"]
        said = self.expression(value, known)
        kind = forgotten(said.type) if isinstance(said.type, Record) else said.type
        try:
            self.result = kind if self.result == NOTHING else joined(self.result, kind)
        except TypeError as error:
            raise self.refused(node, "results have different types") from error
        return [f"{space}return {bare(self.cast(self.handed(said), self.result).code)};"]

    def _branch(self, node: ast.If, known: Known, depth: int) -> list[str]:
        test = self.condition(node.test, known)
        if test.known is not None:
            return self.block(node.body if test.known else node.orelse, known, depth)
        space, then, other = "    " * depth, dict(known), dict(known)
        body = self.block(node.body, then, depth + 1)
        rest = self.block(node.orelse, other, depth + 1)
        lines = [f"{space}if ({bare(test.code)}) {{", *body]
        if rest:
            lines += otherwise(rest, space)
        lines.append(f"{space}}}")
        if body and ends(body[-1]):
            _become(known, other)
        elif rest and ends(rest[-1]):
            _become(known, then)
        else:
            _become(known, self._after_either(node, then, other))
        return lines

    def _after_either(self, node: ast.If, one: Known, other: Known) -> Known:
        """Return the values that are known after either of two branches."""
        after: Known = {}
        for name in one.keys() & other.keys():
            a, b = one[name], other[name]
            if a.key == b.key and a.code == b.code:
                after[name] = a
            elif name in self.types:
                after[name] = self.unknown(node, name)
        return after

    # ------------------------------------------------------------------------------------ loops
    def _forget(self, node: ast.stmt, body: list[ast.stmt], known: Known) -> None:
        """Forget the known values of variables that a loop changes."""
        for name in self.source.assigned(body):
            if name in known:
                known[name] = self.unknown(node, name)

    def _learn(self, body: list[ast.stmt], known: Known) -> None:
        """Declare variables that first appear in a loop, because they also exist after it."""
        for name in self.source.assigned(body):
            if name not in known and name in self.types:
                known[name] = self.named(name, self.types[name])

    def _while(self, node: ast.While, known: Known, depth: int) -> list[str]:
        if node.orelse:
            raise self.refused(node, "a loop cannot have an else")
        self._forget(node, node.body, known)
        within = dict(known)
        test = self.condition(node.test, within)
        if test.known is False:
            return []
        space = "    " * depth
        body = self.block(node.body, within, depth + 1)
        self._forget(node, node.body, known)
        self._learn(node.body, known)
        return [f"{space}while ({bare(test.code)}) {{", *body, f"{space}}}"]

    def _for(self, node: ast.For, known: Known, depth: int) -> list[str]:
        call, target = node.iter, node.target
        if (
            not isinstance(call, ast.Call)
            or not isinstance(call.func, ast.Name)
            or call.func.id != "range"
            or not 1 <= len(call.args) <= 3
            or not isinstance(target, ast.Name)
            or node.orelse
        ):
            raise self.refused(node, "a for loop must count over range(...) and have no else")
        parts = [self.place(argument, known) for argument in call.args]
        number = self.program.precision.number
        start = parts[0] if len(parts) > 1 else number(0, INT)
        stop = parts[1] if len(parts) > 1 else parts[0]
        step = parts[2] if len(parts) > 2 else number(1, INT)
        if not step.known:
            raise self.refused(node, "the step must be known and not 0")
        if start.known is not None and stop.known is not None:
            counts = range(start.known, stop.known, step.known)
            if not counts:
                return []
            written_out = self.body.__name__ in self.program.unrolled
            if written_out and len(counts) <= MOST_PASSES and not jumps(node.body):
                return self._unrolled(node, target.id, counts, known, depth)
        return self._counted(node, target.id, (start, stop, step), known, depth)

    def _unrolled(
        self, node: ast.For, name: str, counts: range, known: Known, depth: int
    ) -> list[str]:
        space, lines = "    " * depth, []
        for count in counts:
            value = self.program.precision.number(count, INT)
            lines += [f"{space}{{", *self._assign_name(node, name, value, known, f"{space}    ")]
            body = self.block(node.body, known, depth + 1)
            lines += [*body, f"{space}}}"]
            if body and ends(body[-1]):
                break
        return lines

    def _counted(
        self,
        node: ast.For,
        name: str,
        bounds: tuple[Value, Value, Value],
        known: Known,
        depth: int,
    ) -> list[str]:
        start, stop, step = bounds
        space, lines = "    " * depth, []
        # Python's loop variable differs from C's counter if the loop changes it, and after the
        # loop.
        own = self.source.assigned(node.body)
        apart = name in own or self.source.is_read_beyond_its_loops(name)
        end = stop.code
        if stop.known is None and (not end.isidentifier() or end in own or end == name):
            end = self.temporary("end", INT)
            lines.append(f"{space}{end} = {bare(stop.code)};")
        begin = bare(start.code)
        self.declare(node, name, INT)
        self._forget(node, node.body, known)
        counter = self.temporary("pass", INT) if apart else name
        within = dict(known)
        within[name] = Value(self.types[name], name)
        sign = "<" if step.known > 0 else ">"
        move = {1: f"{counter}++", -1: f"{counter}--"}.get(step.known)
        move = move or f"{counter} {'+' if step.known > 0 else '-'}= {abs(step.known)}"
        lines.append(f"{space}for ({counter} = {begin}; {counter} {sign} {end}; {move}) {{")
        if apart:
            value = self.cast(Value(INT, counter), self.types[name])
            lines.append(f"{space}    {name} = {value.code};")
        lines += self.block(node.body, within, depth + 1)
        self._forget(node, node.body, known)
        self._learn(node.body, known)
        known[name] = Value(self.types[name], name)
        return [*lines, f"{space}}}"]

    # ------------------------------------------------------------------------------ assignments
    def _assign_all(
        self, targets: list[ast.expr], value: ast.expr, known: Known, space: str
    ) -> list[str]:
        if len(targets) == 1:
            return self._assign_node(targets[0], value, known, space)
        said, lines = self._held(self.expression(value, known), space)
        for target in targets:
            lines += self._assign(target, said, known, space)
        return lines

    def _held(self, value: Value, space: str) -> tuple[Value, list[str]]:
        """Return a value that stays while others are written, and the lines that save it."""
        if value.is_known:
            return value, []
        name = self.temporary("value", value.type)
        return self.named(name, value.type), [f"{space}{name} = {bare(value.code)};"]

    def _assign_node(
        self, target: ast.expr, value: ast.expr, known: Known, space: str
    ) -> list[str]:
        if not isinstance(target, ast.Tuple):
            return self._assign(target, self.expression(value, known), known, space)
        if isinstance(value, ast.Tuple):
            if len(target.elts) != len(value.elts):
                raise self.refused(value, "the tuple has a different number of values")
            pairs = zip(target.elts, value.elts, strict=True)
            return self._together(list(pairs), known, space)
        said = self.expression(value, known)
        if not isinstance(said.type, Record) or len(said.type.fields) != len(target.elts):
            raise self.refused(value, "the tuple has a different number of values")
        fields = [field for field, _ in said.type.fields]
        lines: list[str] = []
        if not said.is_known and not said.code.isidentifier():
            name = self.temporary("parts", forgotten(said.type))
            lines.append(f"{space}{name} = {bare(said.code)};")
            said = self.named(name, said.type)
        for part, field in zip(target.elts, fields, strict=True):
            if isinstance(part, ast.Name) and part.id == "_":
                continue
            lines += self._assign(part, self.field(said, field), known, space)
        return lines

    def _together(
        self, pairs: list[tuple[ast.expr, ast.expr]], known: Known, space: str
    ) -> list[str]:
        """Assign several values at once: all are evaluated before any is written."""
        lines, held = [], []
        before: set[str] = set()
        writes = False
        for target, source in pairs:
            value = self.expression(source, known)
            # Arrays may share memory under different names.
            looks_up = not value.is_known and ("[" in value.code or "(" in value.code[1:])
            if words_of(value.code) & before or (looks_up and writes):
                value, kept = self._held(value, space)
                lines += kept
            held.append(value)
            writes = writes or isinstance(target, ast.Subscript)
            if isinstance(target, ast.Name):
                before.add(target.id)
        for (target, _), value in zip(pairs, held, strict=True):
            lines += self._assign(target, value, known, space)
        return lines

    def _assign(self, target: ast.expr, value: Value, known: Known, space: str) -> list[str]:
        match target:
            case ast.Name(id=name):
                return self._assign_name(target, name, value, known, space)
            case ast.Subscript():
                whole = self.expression(target.value, known)
                if isinstance(whole.type, Row) and whole.type.constant:
                    raise self.refused(target, "the table is read-only")
                place = self.expression(target, known)
                if isinstance(place.type, Row):
                    return self.filled(target, value, known, space)
                return [f"{space}{place.code} = {bare(self.cast(value, place.type).code)};"]
            case ast.Tuple(elts=elts) if isinstance(value.type, Record):
                if len(elts) != len(value.type.fields):
                    raise self.refused(target, "the tuple has a different number of values")
                lines = []
                for part, (field, _) in zip(elts, value.type.fields, strict=True):
                    lines += self._assign(part, self.field(value, field), known, space)
                return lines
        raise self.refused(target, "it cannot be assigned")

    def _assign_name(
        self, node: ast.AST, name: str, value: Value, known: Known, space: str
    ) -> list[str]:
        if isinstance(value.type, Record) and value.is_known:
            known[name] = value
            return []
        self.declare(node, name, value.type)
        code = self.cast(self.handed(value), self.types[name]).code
        known[name] = self._after(name, value)
        return [f"{space}{name} = {bare(code)};"] if code != name else []

    def _after(self, name: str, value: Value) -> Value:
        """Return the known value of a variable after an assignment."""
        kind = self.types[name]
        if isinstance(value.type, Scalar):
            if value.known is not None and value.type == kind:
                return value
            return Value(kind, name)
        if isinstance(value.type, Row):
            assert isinstance(kind, Row)
            if isinstance(value.known, Table) and kind.constant:
                return value
            # Sizes are known here, but not in every branch.
            return Value(Row(kind.item, kind.constant, value.type.shape), name)
        parts = value.known if isinstance(value.known, dict) else {}
        fields = {}
        for field, part_kind in value.type.fields:
            part = parts.get(field)
            known = part is not None and part.is_known
            fields[field] = part if known else Value(part_kind, f"{name}.{field}")
        return Value(value.type, name, fields)


def _become(known: Known, other: Known) -> None:
    known.clear()
    known.update(other)
