"""Translate one kernel to a function in C."""

from __future__ import annotations

import ast
import inspect
import math
import operator
import re
import textwrap
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from fuzzy2.errors import NotExportable
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
    joined,
)

if TYPE_CHECKING:
    from fuzzy2.export.translator import Program

COMPARISONS: dict[type, tuple[str, Callable[[Any, Any], bool]]] = {
    ast.Lt: ("<", operator.lt),
    ast.LtE: ("<=", operator.le),
    ast.Gt: (">", operator.gt),
    ast.GtE: (">=", operator.ge),
    ast.Eq: ("==", operator.eq),
    ast.NotEq: ("!=", operator.ne),
}
SUMS: dict[type, tuple[str, Callable[[Any, Any], Any]]] = {
    ast.Add: ("+", operator.add),
    ast.Sub: ("-", operator.sub),
    ast.Mult: ("*", operator.mul),
}
FUNCTIONS = {
    "sqrt": "sqrt",
    "exp": "exp",
    "expm1": "expm1",
    "log": "log",
    "log1p": "log1p",
    "sin": "sin",
    "cos": "cos",
    "tan": "tan",
    "asin": "asin",
    "acos": "acos",
    "atan": "atan",
    "atan2": "atan2",
    "tanh": "tanh",
    "hypot": "hypot",
    "floor": "floor",
    "ceil": "ceil",
    "copysign": "copysign",
    "fabs": "fabs",
}
TESTS = {"isfinite": math.isfinite, "isnan": math.isnan, "isinf": math.isinf}
# Loops of at most so many passes are written out in functions whose loops may be.
MOST_PASSES = 16

Known = dict[str, Value]


class Translation:
    """A kernel on its way to C, for what is known of its arguments."""

    def __init__(self, program: Program, body: Callable[..., Any], arguments: list[Value]) -> None:
        self.program, self.body = program, body
        self.globals = {**body.__globals__, **inspect.getclosurevars(body).nonlocals}
        tree = ast.parse(textwrap.dedent(inspect.getsource(body))).body[0]
        assert isinstance(tree, ast.FunctionDef)
        self.tree = tree
        names = [argument.arg for argument in tree.args.args]
        if len(names) != len(arguments):
            self.refuse(tree, "it is called with another number of arguments")
        self.parameters = list(zip(names, arguments, strict=True))
        self.passed = tuple(i for i, (_, v) in enumerate(self.parameters) if not v.is_known)
        self.types: dict[str, Type] = {}
        self.buffers: list[str] = []
        self.result: Type = NOTHING
        self.lines: list[str] = []
        self.count = 0
        self._variables = _assigned(self.tree.body) | set(names)

    def refuse(self, node: Any, why: str) -> None:
        """Raise the error of what cannot be said in C."""
        line = getattr(node, "lineno", 0)
        text = ast.unparse(node) if isinstance(node, ast.AST) else str(node)
        if isinstance(node, ast.stmt):
            text = text.splitlines()[0]
        where = f"{self.body.__module__}.{self.body.__name__}, line {line}: {text}"
        raise NotExportable(where, why, "what docs/concepts/kernels.md lists")

    # ------------------------------------------------------------------------------------ whole
    def translate(self) -> None:
        """Translate the body: again, until all types of its variables are found."""
        before: dict[str, Type] | None = None
        while before != self.types:
            before = self.types
            self.types = {name: kind for name, kind in before.items() if name in self._variables}
            self.buffers, self.count = [], 0
            known: Known = {}
            for name, value in self.parameters:
                known[name] = value if value.is_known else self._parameter(name, value)
                if not value.is_known:
                    self._declare(name, value.type)
            self.lines = self.block(self.tree.body, known, 1)

    def _parameter(self, name: str, value: Value) -> Value:
        """Return a parameter: by its name, with what of its fields is known beforehand."""
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
        lines = _without_idle(self.lines, set(self.types) - names)
        used = _words("\n".join(lines))
        declared = [
            f"    {self.program.c_type(kind)} {variable};"
            for variable, kind in self.types.items()
            if variable not in names and variable in used
        ]
        buffers = [line for line in self.buffers if line.split("[")[0].split()[-1] in used]
        idle = [f"    (void){variable};" for variable in sorted(names - used)]
        title = (ast.get_docstring(self.tree) or self.tree.name).splitlines()[0]
        title = title.replace("``", "").replace("*/", "* /")
        head = (
            f"static {self.program.c_type(self.result)} {name}({', '.join(parameters) or 'void'})"
        )
        body = "\n".join([*declared, *buffers, *idle, *lines])
        return f"/* {title} */\n{head}\n{{\n{body}\n}}\n"

    # ------------------------------------------------------------------------------- statements
    def block(self, body: list[ast.stmt], known: Known, depth: int) -> list[str]:
        """Translate statements in order; ``known`` follows what they do."""
        lines: list[str] = []
        for statement in body:
            lines += self.statement(statement, known, depth)
            if lines and _ends(lines[-1]):
                break
        return lines

    def statement(self, node: ast.stmt, known: Known, depth: int) -> list[str]:
        """Translate a statement."""
        space = "    " * depth
        match node:
            case ast.Expr(value=ast.Constant()):
                return []
            case ast.Pass():
                return []
            case ast.Expr(value=value):
                said = self.expression(value, known)
                return [] if said.is_known else [f"{space}{said.code};"]
            case ast.Return(value=value):
                return self._return(value, known, space)
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
            case ast.AugAssign(target=target, op=op, value=value):
                read = ast.parse(ast.unparse(target), mode="eval").body
                whole = ast.copy_location(ast.BinOp(read, op, value), node)
                return self._assign(target, self.expression(whole, known), known, space)
            case ast.AnnAssign(target=target, value=value) if value is not None:
                return self._assign_node(target, value, known, space)
            case ast.Assign(targets=targets, value=value):
                return self._assign_all(targets, value, known, space)
        self.refuse(node, "no statement of a kernel")
        return []

    def _return(self, value: ast.expr | None, known: Known, space: str) -> list[str]:
        if value is None or (isinstance(value, ast.Constant) and value.value is None):
            return [f"{space}return;"]
        if isinstance(value, ast.Tuple):
            parts = [self.expression(part, known) for part in value.elts]
            said = self.record("tuple", [(f"f{i}", part) for i, part in enumerate(parts)])
        else:
            said = self.expression(value, known)
        kind = said.type
        if isinstance(kind, Record):
            kind = _forgotten(kind)
            if not said.code:
                codes = ", ".join(_bare(self.handed(part).code) for part in said.known.values())
                said = Value(said.type, f"({self.program.c_type(kind)}){{{codes}}}", said.known)
        self.result = kind if self.result == NOTHING else joined(self.result, kind)
        return [f"{space}return {self.cast(said, self.result).code};"]

    def _branch(self, node: ast.If, known: Known, depth: int) -> list[str]:
        test = self.expression(node.test, known)
        if test.known is not None:
            return self.block(node.body if test.known else node.orelse, known, depth)
        space, then, other = "    " * depth, dict(known), dict(known)
        lines = [f"{space}if ({_bare(test.code)}) {{"]
        body = self.block(node.body, then, depth + 1)
        lines += body
        rest = self.block(node.orelse, other, depth + 1)
        if rest:
            lines += [f"{space}}} else {{", *rest]
        lines.append(f"{space}}}")
        if body and _ends(body[-1]):
            _become(known, other)
        elif rest and _ends(rest[-1]):
            _become(known, then)
        else:
            _become(known, self._common(then, other))
        return lines

    def _common(self, one: Known, other: Known) -> Known:
        """Return what is known after either of two ways."""
        common: Known = {}
        for name in one.keys() & other.keys():
            a, b = one[name], other[name]
            common[name] = a if a.key == b.key and a.code == b.code else self._unknown(name)
        return common

    def _unknown(self, name: str) -> Value:
        """Return a variable of which nothing is known but its type."""
        return self._named(name, self.types[name])

    def _named(self, name: str, kind: Type) -> Value:
        if isinstance(kind, Record):
            fields = {
                field: Value(_sizeless(part), f"{name}.{field}") for field, part in kind.fields
            }
            return Value(kind, name, fields)
        return Value(_sizeless(kind), name)

    def _forget(self, body: list[ast.stmt], known: Known) -> None:
        """Forget what is known of variables that a loop changes."""
        for name in _assigned(body):
            if name in known:
                if name not in self.types:
                    self.refuse(body[0], f"the parameter {name} is changed in a loop")
                known[name] = self._unknown(name)

    def _while(self, node: ast.While, known: Known, depth: int) -> list[str]:
        self._forget(node.body, known)
        within = dict(known)
        if isinstance(node.test, ast.Constant) and node.test.value is True:
            code = "1"
        else:
            code = _bare(self.expression(node.test, within).code)
        space = "    " * depth
        lines = [f"{space}while ({code}) {{", *self.block(node.body, within, depth + 1)]
        self._forget(node.body, known)
        self._learn(node.body, known)
        return [*lines, f"{space}}}"]

    def _learn(self, body: list[ast.stmt], known: Known) -> None:
        """Variables that first appear in a loop are variables after it, too."""
        for name in _assigned(body):
            if name not in known and name in self.types:
                known[name] = self._unknown(name)

    def _for(self, node: ast.For, known: Known, depth: int) -> list[str]:
        if not (
            isinstance(node.iter, ast.Call)
            and isinstance(node.iter.func, ast.Name)
            and node.iter.func.id == "range"
            and isinstance(node.target, ast.Name)
            and not node.orelse
        ):
            self.refuse(node, "no counted loop")
        assert isinstance(node.iter, ast.Call)
        assert isinstance(node.target, ast.Name)
        ends = [self.expression(argument, known) for argument in node.iter.args]
        one = self.program.precision.number(1, INT)
        start, stop, step = self.program.precision.number(0, INT), ends[0], one
        if len(ends) > 1:
            start, stop = ends[0], ends[1]
        if len(ends) > 2:
            step = ends[2]
        if not step.known:
            self.refuse(node, "a step that is not known")
        counts = None
        if start.known is not None and stop.known is not None:
            counts = range(start.known, stop.known, step.known)
            if not counts:
                return []
        if counts is not None and self.body.__name__ in self.program.unrolled:
            if len(counts) <= MOST_PASSES:
                return self._unrolled(node, counts, known, depth)
        return self._counted(node, (start, stop, step), known, depth)

    def _unrolled(self, node: ast.For, counts: range, known: Known, depth: int) -> list[str]:
        assert isinstance(node.target, ast.Name)
        lines = []
        for count in counts:
            lines += ["    " * depth + "{"]
            value = self.program.precision.number(count, INT)
            lines += self._assign(node.target, value, known, "    " * (depth + 1))
            lines += self.block(node.body, known, depth + 1) + ["    " * depth + "}"]
        return lines

    def _counted(
        self, node: ast.For, ends: tuple[Value, Value, Value], known: Known, depth: int
    ) -> list[str]:
        assert isinstance(node.target, ast.Name)
        start, stop, step = ends
        space, lines = "    " * depth, []
        name = node.target.id
        if name != "_" and name in _assigned(node.body):
            self.refuse(node, f"{name} is changed in its loop")
        end = stop.code
        if stop.known is None and not stop.code.isidentifier():
            end = self.temporary("end", INT)
            lines.append(f"{space}{end} = {_bare(stop.code)};")
        elif stop.code in _assigned(node.body):
            end = self.temporary("end", INT)
            lines.append(f"{space}{end} = {stop.code};")
        if name == "_" or name not in _read(node.body) | _read(self.tree.body):
            name = self.temporary("pass", INT)
        else:
            self._declare(name, INT)
        self._forget(node.body, known)
        known[name] = Value(INT, name)
        within = dict(known)
        sign = "<" if step.known > 0 else ">"
        move = f"{name}++" if step.known == 1 else f"{name} += {step.known}"
        if step.known == -1:
            move = f"{name}--"
        lines.append(f"{space}for ({name} = {_bare(start.code)}; {name} {sign} {end}; {move}) {{")
        lines += self.block(node.body, within, depth + 1)
        self._forget(node.body, known)
        self._learn(node.body, known)
        return [*lines, f"{space}}}"]

    def temporary(self, base: str, kind: Type) -> str:
        """Return the name of a new variable."""
        self.count += 1
        name = f"{base}_{self.count}"
        self.types[name] = kind
        return name

    def _declare(self, name: str, kind: Type) -> None:
        self.types[name] = joined(self.types[name], kind) if name in self.types else kind

    # ------------------------------------------------------------------------------ assignments
    def _assign_all(
        self, targets: list[ast.expr], value: ast.expr, known: Known, space: str
    ) -> list[str]:
        if len(targets) == 1:
            return self._assign_node(targets[0], value, known, space)
        said = self.expression(value, known)
        lines = []
        if said.known is None and not said.code.isidentifier():
            name = self.temporary("value", said.type)
            lines.append(f"{space}{name} = {_bare(said.code)};")
            said = Value(said.type, name)
        for target in targets:
            lines += self._assign(target, said, known, space)
        return lines

    def _assign_node(
        self, target: ast.expr, value: ast.expr, known: Known, space: str
    ) -> list[str]:
        if not isinstance(target, ast.Tuple):
            return self._assign(target, self.expression(value, known, target), known, space)
        if isinstance(value, ast.Tuple):
            pairs = zip(target.elts, value.elts, strict=True)
            return self._together(list(pairs), known, space)
        said = self.expression(value, known)
        if not isinstance(said.type, Record):
            self.refuse(value, "no tuple")
        assert isinstance(said.type, Record)
        lines = []
        if not said.is_known and (said.known is None or not said.code.isidentifier()):
            name = self.temporary("parts", said.type)
            lines.append(f"{space}{name} = {_bare(said.code)};")
            said = self._named(name, said.type)
        for part, field in zip(target.elts, said.type.fields, strict=True):
            if isinstance(part, ast.Name) and part.id == "_":
                continue
            lines += self._assign(part, said.known[field[0]], known, space)
        return lines

    def _together(
        self, pairs: list[tuple[ast.expr, ast.expr]], known: Known, space: str
    ) -> list[str]:
        """Assign several values at once: all are found before any is written."""
        values = [self.expression(value, known, target) for target, value in pairs]
        written = [ast.unparse(target) for target, _ in pairs]
        lines, held = [], []
        for i, value in enumerate(values):
            words = set(re.findall(r"[A-Za-z_]\w*", value.code))
            before = {name.split("[")[0] for name in written[:i]}
            if value.known is None and words & before:
                name = self.temporary("value", value.type)
                lines.append(f"{space}{name} = {_bare(value.code)};")
                value = self._named(name, value.type)
                # It stands for what was found before; the order of the others does not matter.
            held.append(value)
        # What is held comes before what is written.
        for (target, _), value in zip(pairs, held, strict=True):
            lines += self._assign(target, value, known, space)
        return lines

    def _assign(self, target: ast.expr, value: Value, known: Known, space: str) -> list[str]:
        match target:
            case ast.Name(id=name):
                return self._assign_name(name, value, known, space)
            case ast.Subscript(value=whole, slice=ast.Slice() as part):
                return self._fill(ast.Subscript(whole, part, ast.Load()), value, known, space)
            case ast.Subscript():
                place = self.expression(target, known)
                kind = self.expression(target.value, known).type
                if isinstance(kind, Row) and kind.constant:
                    self.refuse(target, "a table that nobody may write to")
                return [f"{space}{place.code} = {_bare(self.cast(value, place.type).code)};"]
            case ast.Tuple(elts=elts) if isinstance(value.type, Record):
                lines = []
                for part, (field, _) in zip(elts, value.type.fields, strict=True):
                    lines += self._assign(part, self._field(value, field), known, space)
                return lines
        self.refuse(target, "no place to write to")
        return []

    def _fill(self, target: ast.Subscript, value: Value, known: Known, space: str) -> list[str]:
        part = self.expression(target, known)
        assert isinstance(part.type, Row)
        i = self.temporary("i", INT)
        row = self.temporary("part", part.type)
        item = value.code
        lines = [f"{space}{row} = {_bare(part.code)};"]
        if isinstance(value.type, Row):
            other = self.temporary("other", value.type)
            lines.append(f"{space}{other} = {_bare(value.code)};")
            item = f"{other}.p[{i}]"
        else:
            item = self.cast(value, part.type.item).code
        size = "*".join(f"{row}.{s}" for s in ("n", "m")[: len(part.type.shape)])
        return [
            *lines,
            f"{space}for ({i} = 0; {i} < {size}; {i}++) {{",
            f"{space}    {row}.p[{i}] = {_bare(item)};",
            f"{space}}}",
        ]

    def _assign_name(self, name: str, value: Value, known: Known, space: str) -> list[str]:
        if name in dict(self.parameters) and name not in self.types:
            # A parameter that is known becomes a variable: it has no place in C until then.
            self._declare(name, value.type)
        if isinstance(value.type, Record) and value.is_known:
            known[name] = value
            return []
        self._declare(name, value.type)
        code = self.cast(value, self.types[name]).code
        known[name] = self._after(name, value)
        return [f"{space}{name} = {_bare(code)};"] if code != name else []

    def _after(self, name: str, value: Value) -> Value:
        """Return what is known of a variable that was given a value."""
        if isinstance(value.type, Scalar):
            if value.known is not None and value.type == self.types[name]:
                return value
            return Value(self.types[name], name)
        if isinstance(value.type, Row):
            if value.is_known:
                return value
            return Value(value.type, name)
        parts = value.known if isinstance(value.known, dict) else {}
        fields = {}
        for field, kind in value.type.fields:
            part = parts.get(field)
            fields[field] = (
                part if part is not None and part.is_known else Value(kind, f"{name}.{field}")
            )
        return Value(value.type, name, fields)

    def cast(self, value: Value, kind: Type) -> Value:
        """Return a value as one of a type."""
        if value.type == kind or not isinstance(kind, Scalar):
            return self._loosened(value, kind)
        if not isinstance(value.type, Scalar):
            self.refuse(value.code, f"no {kind.name}")
        assert isinstance(value.type, Scalar)
        if value.known is not None:
            return self.program.precision.number(value.known, kind)
        if kind == REAL:
            return Value(REAL, f"({self.program.precision.type})({value.code})")
        return Value(kind, value.code)

    def _loosened(self, value: Value, kind: Type) -> Value:
        """Return a part of an array as one that is not to be written to, where that is asked."""
        if isinstance(kind, Row) and isinstance(value.type, Row):
            if kind.constant and not value.type.constant:
                one = self.once(value)
                sizes = ", ".join(f"{one}.{s}" for s in ("n", "m")[: len(kind.shape)])
                return Value(kind, f"({self.program.c_type(kind)}){{{one}.p, {sizes}}}")
        return value

    def once(self, value: Value) -> str:
        """Return a name for a value that is asked more than once."""
        if value.code.replace(".", "_").isidentifier():
            return value.code
        self.refuse(value.code, "give it a name first")
        return ""

    # ------------------------------------------------------------------------------ expressions
    def expression(self, node: ast.expr, known: Known, target: ast.expr | None = None) -> Value:
        """Translate an expression."""
        number = self.program.precision.number
        match node:
            case ast.Constant(value=bool() as value):
                return number(value, BOOL)
            case ast.Constant(value=int() as value):
                return number(value, INT)
            case ast.Constant(value=float() as value):
                return number(value, REAL)
            case ast.Name(id=name):
                return self._variable(node, name, known)
            case ast.BinOp():
                return self._binary(node, known)
            case ast.UnaryOp(op=op, operand=operand):
                return self._unary(node, op, self.expression(operand, known))
            case ast.BoolOp():
                return self._logical(node, known)
            case ast.Compare():
                return self._comparison(node, known)
            case ast.IfExp():
                return self._choice(node, known)
            case ast.Subscript():
                return self._subscript(node, known)
            case ast.Attribute():
                return self._attribute(node, known)
            case ast.Call():
                return self._call(node, known, target)
            case ast.Tuple(elts=elts):
                parts = [self.expression(part, known) for part in elts]
                return self.record("tuple", [(f"f{i}", part) for i, part in enumerate(parts)])
        self.refuse(node, "no expression of a kernel")
        raise AssertionError

    def _variable(self, node: ast.AST, name: str, known: Known) -> Value:
        if name in known:
            return known[name]
        if name in self.globals:
            thing = self.program.replaced.get(name, self.globals[name])
            for kind, scalar in ((bool, BOOL), (int, INT), (float, REAL)):
                if isinstance(thing, kind):
                    return self.program.precision.number(thing, scalar)
            if isinstance(thing, tuple) and hasattr(thing, "_fields"):
                from fuzzy2.export.values import value_of

                return value_of(name.lower(), thing)
        if name in self.types:
            return self._unknown(name)
        self.refuse(node, f"{name} is no number")
        raise AssertionError

    def _binary(self, node: ast.BinOp, known: Known) -> Value:
        left, right = self.expression(node.left, known), self.expression(node.right, known)
        if not (isinstance(left.type, Scalar) and isinstance(right.type, Scalar)):
            self.refuse(node, "an operation on whole arrays")
        if isinstance(node.op, ast.Pow):
            return self._power(node, left, right)
        if isinstance(node.op, ast.Div):
            left, right = self.cast(left, REAL), self.cast(right, REAL)
            return Value(REAL, f"({left.code} / {right.code})")
        if isinstance(node.op, ast.FloorDiv | ast.Mod):
            return self._whole_division(node, left, right)
        if type(node.op) not in SUMS:
            self.refuse(node, "no operation of a kernel")
        sign, operation = SUMS[type(node.op)]
        kind = joined(joined(left.type, right.type), INT)
        assert isinstance(kind, Scalar)
        if left.known is not None and right.known is not None and kind == INT:
            return self.program.precision.number(operation(left.known, right.known), kind)
        left, right = self.cast(left, kind), self.cast(right, kind)
        if kind == INT:
            # Nothing is added, nothing changes.
            if sign in "+-" and right.known == 0:
                return left
            if sign == "+" and left.known == 0:
                return right
            if sign == "*" and 0 in (left.known, right.known):
                return self.program.precision.number(0, INT)
            if sign == "*" and right.known == 1:
                return left
            if sign == "*" and left.known == 1:
                return right
        return Value(kind, f"({left.code} {sign} {right.code})")

    def _whole_division(self, node: ast.BinOp, left: Value, right: Value) -> Value:
        if not (left.type == INT and right.type == INT):
            self.refuse(node, "a whole division of numbers that are not whole")
        remainder = isinstance(node.op, ast.Mod)
        if left.known is not None and right.known is not None:
            number = left.known % right.known if remainder else left.known // right.known
            return self.program.precision.number(number, INT)
        # Indices and sizes are never negative: C, which rounds towards zero, says the same.
        return Value(INT, f"({left.code} {'%' if remainder else '/'} {right.code})")

    def _power(self, node: ast.BinOp, left: Value, right: Value) -> Value:
        exponent = right.known
        if left.known is not None and exponent is not None:
            return self.program.precision.number(
                left.known**exponent, REAL if left.type == REAL else INT
            )
        if isinstance(exponent, int) and exponent >= 1:
            code, factor = "", self.cast(left, REAL).code if left.type == REAL else left.code
            # By squares, in the order in which numba multiplies.
            while exponent:
                if exponent & 1:
                    code = f"({code} * {factor})" if code else factor
                exponent >>= 1
                if exponent:
                    factor = f"({factor} * {factor})"
            return Value(left.type, code)
        x, y = self.cast(left, REAL).code, self.cast(right, REAL).code
        return Value(REAL, f"{self.program.precision.function('pow')}({x}, {y})")

    def _unary(self, node: ast.AST, op: ast.unaryop, value: Value) -> Value:
        if isinstance(op, ast.Not):
            if value.known is not None:
                return self.program.precision.number(not value.known, BOOL)
            return Value(BOOL, f"(!{value.code})")
        if not isinstance(op, ast.USub):
            self.refuse(node, "no operation of a kernel")
        if value.known is not None:
            assert isinstance(value.type, Scalar)
            return self.program.precision.number(-value.known, value.type)
        return Value(value.type, f"(-{value.code})")

    def _logical(self, node: ast.BoolOp, known: Known) -> Value:
        stops = isinstance(node.op, ast.Or)
        codes = []
        for part in node.values:
            value = self.expression(part, known)
            if value.known is None:
                codes.append(value.code)
            elif bool(value.known) == stops:
                if not codes:
                    return self.program.precision.number(stops, BOOL)
                codes.append("1" if stops else "0")
                break
        if not codes:
            return self.program.precision.number(not stops, BOOL)
        if len(codes) == 1:
            return Value(BOOL, codes[0])
        return Value(BOOL, "(" + (" || " if stops else " && ").join(codes) + ")")

    def _comparison(self, node: ast.Compare, known: Known) -> Value:
        if isinstance(node.ops[0], ast.In | ast.NotIn):
            return self._membership(node, known)
        codes = []
        left = self.expression(node.left, known)
        for op, other in zip(node.ops, node.comparators, strict=True):
            if type(op) not in COMPARISONS:
                self.refuse(node, "no comparison of a kernel")
            sign, compare = COMPARISONS[type(op)]
            right = self.expression(other, known)
            if left.known is not None and right.known is not None:
                if not compare(left.known, right.known):
                    return self.program.precision.number(False, BOOL)
            else:
                kind = joined(left.type, right.type)
                a, b = self.cast(left, kind), self.cast(right, kind)
                codes.append(f"({a.code} {sign} {b.code})")
            left = right
        if not codes:
            return self.program.precision.number(True, BOOL)
        return Value(BOOL, codes[0] if len(codes) == 1 else "(" + " && ".join(codes) + ")")

    def _membership(self, node: ast.Compare, known: Known) -> Value:
        """Translate ``a in (b, c)``, which is ``a == b or a == c``."""
        others = node.comparators[0]
        if not isinstance(others, ast.Tuple):
            self.refuse(node, "no comparison of a kernel")
        assert isinstance(others, ast.Tuple)
        equal: list[ast.expr] = [
            ast.Compare(node.left, [ast.Eq()], [other]) for other in others.elts
        ]
        one_of: ast.expr = ast.BoolOp(ast.Or(), equal)
        if isinstance(node.ops[0], ast.NotIn):
            one_of = ast.UnaryOp(ast.Not(), one_of)
        return self.expression(ast.fix_missing_locations(ast.copy_location(one_of, node)), known)

    def _choice(self, node: ast.IfExp, known: Known) -> Value:
        test = self.expression(node.test, known)
        if test.known is not None:
            return self.expression(node.body if test.known else node.orelse, known)
        one, other = self.expression(node.body, known), self.expression(node.orelse, known)
        kind = joined(one.type, other.type)
        one, other = self.cast(one, kind), self.cast(other, kind)
        return Value(kind, f"({test.code} ? {one.code} : {other.code})")

    # ----------------------------------------------------------------------------------- arrays
    def _subscript(self, node: ast.Subscript, known: Known) -> Value:
        whole = self.expression(node.value, known)
        if isinstance(whole.type, Record):
            return self._of_tuple(node, whole, known)
        if not isinstance(whole.type, Row):
            self.refuse(node, "an entry of a number")
        assert isinstance(whole.type, Row)
        if isinstance(node.slice, ast.Slice):
            return self._part(node, whole, node.slice, known)
        parts = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        places = [self._place(part, known) for part in parts]
        shape = whole.type.shape
        if len(places) == len(shape) == 2:
            column = self._size(whole, 1)
            row = self._sum("*", places[0], column)
            return self._entry(whole, self._sum("+", row, places[1]))
        if len(places) == 1 and len(shape) == 2:
            column = self._size(whole, 1)
            start = self._sum("*", places[0], column)
            return self._piece(whole, start, column, shape[1])
        if len(places) != len(shape):
            self.refuse(node, "too many places")
        place = places[0]
        if place.known is not None and place.known < 0:
            place = self._sum("+", self._size(whole, 0), place)
        return self._entry(whole, place)

    def _of_tuple(self, node: ast.Subscript, whole: Value, known: Known) -> Value:
        """Return an entry of a tuple, or some of the first ones."""
        assert isinstance(whole.type, Record)
        names = [name for name, _ in whole.type.fields]
        part = node.slice
        if isinstance(part, ast.Slice):
            if part.lower is not None or part.step is not None or part.upper is None:
                self.refuse(node, "other parts of a tuple than the first")
            end = self._place(part.upper, known).known
            if end is not None:
                parts = [self._field(whole, name) for name in names[:end]]
                return self.record("tuple", [(f"f{i}", one) for i, one in enumerate(parts)])
        else:
            place = self._place(part, known).known
            if place is not None:
                return self._field(whole, names[place])
        self.refuse(node, "an entry of a tuple whose number is not known")
        raise AssertionError

    def _place(self, node: ast.expr, known: Known) -> Value:
        place = self.expression(node, known)
        if place.type == BOOL:
            place = self.cast(place, INT)
        if place.type != INT:
            self.refuse(node, "a place that is no whole number")
        return place

    def _sum(self, sign: str, left: Value, right: Value) -> Value:
        """Return a sum or product of whole numbers."""
        code = {"+": ast.Add(), "-": ast.Sub(), "*": ast.Mult()}[sign]
        held = {"a": left, "b": right}
        return self._binary(ast.BinOp(ast.Name("a"), code, ast.Name("b")), held)

    def _size(self, whole: Value, axis: int) -> Value:
        assert isinstance(whole.type, Row)
        size = whole.type.shape[axis]
        if size is not None:
            return self.program.precision.number(size, INT)
        return Value(INT, f"{whole.code}.{'nm'[axis]}")

    def _entry(self, whole: Value, place: Value) -> Value:
        assert isinstance(whole.type, Row)
        table = whole.known
        if isinstance(table, Table):
            if place.known is not None:
                entry = table.numbers[table.start + place.known]
                return self.program.precision.number(entry, whole.type.item)
            name = self.program.table(table)
            start = self.program.precision.number(table.start, INT)
            return Value(whole.type.item, f"{name}[{_bare(self._sum('+', start, place).code)}]")
        return Value(whole.type.item, f"{whole.code}.p[{_bare(place.code)}]")

    def _part(self, node: ast.Subscript, whole: Value, part: ast.Slice, known: Known) -> Value:
        assert isinstance(whole.type, Row)
        if part.step is not None or len(whole.type.shape) != 1:
            self.refuse(node, "a part of a table of two dimensions, or with steps")
        start = self.program.precision.number(0, INT)
        if part.lower is not None:
            start = self._place(part.lower, known)
        end = self._size(whole, 0) if part.upper is None else self._place(part.upper, known)
        size = self._difference(end, start)
        return self._piece(whole, start, size, size.known)

    def _difference(self, end: Value, start: Value) -> Value:
        """Return end - start; ``o + n`` less ``o`` is n."""
        if start.known is None and end.known is None:
            if end.code.startswith(f"({start.code} + ") and end.code.endswith(")"):
                rest = end.code[len(start.code) + 4 : -1]
                if rest.isdigit():
                    return self.program.precision.number(int(rest), INT)
        return self._sum("-", end, start)

    def _piece(self, whole: Value, start: Value, size: Value, known_size: int | None) -> Value:
        assert isinstance(whole.type, Row)
        kind = Row(whole.type.item, whole.type.constant, (known_size,))
        name = self.program.c_type(kind)
        table = whole.known
        if isinstance(table, Table):
            here = None
            if start.known is not None and known_size is not None:
                here = Table(table.name, table.numbers, table.start + start.known)
            begin = self._sum("+", self.program.precision.number(table.start, INT), start)
            code = f"{self.program.table(table)} + {begin.code}"
            return Value(kind, f"({name}){{{code}, {size.code}}}", here)
        return Value(kind, f"({name}){{{whole.code}.p + {start.code}, {size.code}}}")

    def _whole_code(self, value: Value) -> Value:
        """Return an array of known numbers as one that can be handed over."""
        return value

    def _attribute(self, node: ast.Attribute, known: Known) -> Value:
        if isinstance(node.value, ast.Name) and node.value.id in ("math", "np"):
            number = {"nan": math.nan, "inf": math.inf, "pi": math.pi}.get(node.attr)
            if number is None:
                self.refuse(node, "no number of math")
            return self.program.precision.number(number, REAL)
        whole = self.expression(node.value, known)
        if isinstance(whole.type, Record):
            return self._field(whole, node.attr)
        if not isinstance(whole.type, Row):
            self.refuse(node, "a part of a number")
        assert isinstance(whole.type, Row)
        sizes = [self._size(whole, axis) for axis in range(len(whole.type.shape))]
        if node.attr == "shape":
            return self.record("tuple", [(f"f{i}", size) for i, size in enumerate(sizes)])
        if node.attr == "size":
            return sizes[0] if len(sizes) == 1 else self._sum("*", sizes[0], sizes[1])
        self.refuse(node, "nothing that an array has in a kernel")
        raise AssertionError

    def _field(self, whole: Value, name: str) -> Value:
        assert isinstance(whole.type, Record)
        if isinstance(whole.known, dict) and name in whole.known:
            part: Value = whole.known[name]
            return part
        return Value(_sizeless(whole.type[name]), f"{whole.code}.{name}")

    def record(self, name: str, parts: list[tuple[str, Value]]) -> Value:
        """Return several values together."""
        kind = Record(name, tuple((field, part.type) for field, part in parts))
        code = ""
        if not all(part.is_known for _, part in parts):
            codes = ", ".join(_bare(self.handed(part).code) for _, part in parts)
            code = f"({self.program.c_type(_forgotten(kind))}){{{codes}}}"
        return Value(kind, code, dict(parts))

    def handed(self, value: Value) -> Value:
        """Return a value as it is handed over: tables of known numbers get a place and sizes."""
        return self.program.handed(value)

    # ------------------------------------------------------------------------------------ calls
    def _call(self, node: ast.Call, known: Known, target: ast.expr | None) -> Value:
        if node.keywords:
            self.refuse(node, "arguments by name")
        if isinstance(node.func, ast.Attribute):
            return self._method(node, node.func, known, target)
        if not isinstance(node.func, ast.Name):
            self.refuse(node, "no call of a kernel")
        assert isinstance(node.func, ast.Name)
        name = node.func.id
        function = self.globals.get(name)
        if function is None:
            arguments = [self.expression(argument, known) for argument in node.args]
            return self._built_in(node, name, arguments)
        arguments = [self.expression(argument, known) for argument in node.args]
        if isinstance(function, type) and hasattr(function, "_fields"):
            return self.record(
                function.__name__, list(zip(function._fields, arguments, strict=True))
            )
        if not callable(function):
            self.refuse(node, f"{name} is no kernel")
        return self.program.call(function, [self._argument(a, node) for a in arguments])

    def _argument(self, value: Value, node: ast.AST) -> Value:
        return value if value.is_known else self.handed(value)

    def _built_in(self, node: ast.Call, name: str, values: list[Value]) -> Value:
        number = self.program.precision.number
        if name in ("min", "max"):
            best = values[0]
            for value in values[1:]:
                kind = joined(best.type, value.type)
                assert isinstance(kind, Scalar)
                if best.known is not None and value.known is not None and kind == INT:
                    best = number(
                        max(best.known, value.known)
                        if name == "max"
                        else min(best.known, value.known),
                        INT,
                    )
                    continue
                a, b = self.cast(best, kind), self.cast(value, kind)
                which = "real" if kind == REAL else "int"
                best = Value(
                    kind, f"{self.program.prefix}_{name}_{which}({_bare(a.code)}, {_bare(b.code)})"
                )
            return best
        value = values[0]
        if name == "abs":
            if value.type == REAL:
                return Value(
                    REAL, f"{self.program.precision.function('fabs')}({_bare(value.code)})"
                )
            if value.known is not None:
                return number(abs(value.known), INT)
            self.refuse(node, "the absolute value of a whole number")
        if name == "int":
            if value.known is not None:
                return number(int(value.known), INT)
            return Value(INT, value.code if value.type != REAL else f"(int){value.code}")
        if name == "float":
            return self.cast(value, REAL)
        if name == "bool":
            return value if value.type == BOOL else Value(BOOL, f"({value.code} != 0)")
        self.refuse(node, f"{name} is no kernel")
        raise AssertionError

    def _method(
        self, node: ast.Call, function: ast.Attribute, known: Known, target: ast.expr | None
    ) -> Value:
        if isinstance(function.value, ast.Name) and function.value.id == "math":
            values = [self.expression(argument, known) for argument in node.args]
            if function.attr in TESTS:
                return Value(BOOL, f"({function.attr}({self.cast(values[0], REAL).code}) != 0)")
            if function.attr not in FUNCTIONS:
                self.refuse(node, "no function of math.h")
            codes = ", ".join(_bare(self.cast(value, REAL).code) for value in values)
            name = self.program.precision.function(FUNCTIONS[function.attr])
            return Value(REAL, f"{name}({codes})")
        if isinstance(function.value, ast.Name) and function.value.id == "np":
            if function.attr in ("empty", "zeros"):
                return self._memory(node, function.attr == "zeros", known)
            self.refuse(node, "no function of NumPy in a kernel")
        whole = self.expression(function.value, known)
        if function.attr == "reshape" and isinstance(whole.type, Row):
            return self._reshaped(node, whole, known)
        self.refuse(node, "nothing that an array does in a kernel")
        raise AssertionError

    def _reshaped(self, node: ast.Call, whole: Value, known: Known) -> Value:
        assert isinstance(whole.type, Row)
        sizes = [self._place(argument, known) for argument in node.args]
        kind = Row(whole.type.item, whole.type.constant, tuple(size.known for size in sizes))
        name = self.program.c_type(kind)
        codes = ", ".join(size.code for size in sizes)
        table = whole.known
        if isinstance(table, Table):
            here = table if None not in kind.shape else None
            code = f"{self.program.table(table)} + {table.start}"
            return Value(kind, f"({name}){{{code}, {codes}}}", here)
        pointer = re.fullmatch(r"\(\w+\)\{(.*), [^,]*\}", whole.code)
        begin = pointer[1] if pointer else f"{whole.code}.p"
        return Value(kind, f"({name}){{{begin}, {codes}}}")

    def _memory(self, node: ast.Call, zeros: bool, known: Known) -> Value:
        shape = node.args[0].elts if isinstance(node.args[0], ast.Tuple) else [node.args[0]]
        sizes = [self._place(size, known) for size in shape]
        if any(size.known is None for size in sizes):
            self.refuse(node, "memory whose size is not known")
        numbers = tuple(size.known for size in sizes)
        self.count += 1
        buffer = f"memory_{self.count}"
        item = self.program.precision.type
        clear = " = {0}" if zeros else ""
        self.buffers.append(f"    {item} {buffer}[{max(math.prod(numbers), 1)}]{clear};")
        kind = Row(REAL, False, numbers)
        codes = ", ".join(str(size) for size in numbers)
        return Value(kind, f"({self.program.c_type(kind)}){{{buffer}, {codes}}}")


def _sizeless(kind: Type) -> Type:
    """Return the type without sizes that may differ from one way to another."""
    if isinstance(kind, Row):
        return Row(kind.item, kind.constant, tuple(None for _ in kind.shape))
    return kind


def _forgotten(kind: Record) -> Record:
    return Record(
        kind.name,
        tuple(
            (name, _forgotten(part) if isinstance(part, Record) else _sizeless(part))
            for name, part in kind.fields
        ),
    )


def _become(known: Known, other: Known) -> None:
    known.clear()
    known.update(other)


def _ends(line: str) -> bool:
    """Whether nothing that follows the line is reached."""
    return bool(re.match(r"\s*(return\b|continue;|break;)", line))


def _bare(code: str) -> str:
    """Return an expression without parentheses about all of it."""
    if not (code.startswith("(") and code.endswith(")")):
        return code
    depth = 0
    for i, letter in enumerate(code):
        depth += {"(": 1, ")": -1}.get(letter, 0)
        if depth == 0 and i + 1 < len(code):
            return code
    return code[1:-1]


def _assigned(body: list[ast.stmt]) -> set[str]:
    """Return the names of the variables that statements give values to."""
    return {
        node.id
        for statement in body
        for node in ast.walk(statement)
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
    }


def _read(body: list[ast.stmt]) -> set[str]:
    return {
        node.id
        for statement in body
        for node in ast.walk(statement)
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)
    }


def _words(code: str) -> set[str]:
    """Return the names in C code, but for those of members."""
    return set(re.findall(r"(?<![\w.>])[A-Za-z_]\w*", code))


def _without_idle(lines: list[str], variables: set[str]) -> list[str]:
    """Return lines without assignments to variables that nobody reads."""
    while True:
        heard = "\n".join(re.sub(r"^\s*\w+ = ", "", line) for line in lines)
        read = _words(heard)
        kept = []
        for line in lines:
            match = re.match(r"(\s*)(\w+) = (.*);$", line)
            if match and match[2] in variables and match[2] not in read:
                if re.search(r"\w\(", match[3]):
                    kept.append(f"{match[1]}(void){match[3]};")
                continue
            kept.append(line)
        if kept == lines:
            return lines
        lines = kept
