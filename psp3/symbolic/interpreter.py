"""Evaluate kernels of the package on symbols, from their Python source.

A kernel is scalar code: numbers, flat arrays and counting loops. If the condition of a branch is
known, for example because it depends only on the tables of a robot or a fuzzy system, one way is
followed. If it depends on a symbol, both ways are evaluated from the same memory, and CasADi's
``if_else`` selects between their changes and results. The same is done for a loop that may end
early. So the resulting functions are those of the kernels, including their kinks.

Some conditions only check whether the kernel can handle a pose or a number, or whether a step can
be skipped. :mod:`psp3.symbolic.guards` has fixed answers for them.
"""

from __future__ import annotations

import ast
import functools
import inspect
import math
import sys
import textwrap
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

from psp3.symbolic.guards import GUARDS
from psp3.symbolic.memory import Changes, Journal, Piece, chosen
from psp3.symbolic.numbers import (
    BINARY,
    CALLS,
    COMPARISONS,
    FUNCTIONS,
    SX,
    Number,
    casadi,
    choice,
    is_symbol,
    negated,
    opposite,
    whole,
)

CONSTANTS = {"inf": math.inf, "nan": math.nan, "pi": math.pi}

DEEPEST = 200_000
"""Python's recursion limit: a search among n rules nests n ways."""


class Signal(NamedTuple):
    """How a statement ends: it continues, leaves a loop or a turn of it, or returns a value."""

    kind: str
    value: Any = None


NEXT, BREAK, CONTINUE = Signal("next"), Signal("break"), Signal("continue")


class Split(NamedTuple):
    """A statement that ends in one way if a condition is true, and in another way otherwise.

    The memory is as before both ways; each way stores its changes.
    """

    condition: SX
    one: Any
    changes: Changes
    other: Any
    other_changes: Changes


class Way(NamedTuple):
    """One way under a condition: how it ends, with a signal or a split, and its changes."""

    condition: SX
    end: Any
    changes: Changes


def _ways(way: Way) -> Iterator[Way]:
    """Yield the ways of a split way, each starting from the memory before all of them."""
    if not isinstance(way.end, Split):
        yield way
        return
    split = way.end
    holds = casadi.logic_and(way.condition, split.condition)
    yield from _ways(Way(holds, split.one, Changes({**way.changes, **split.changes})))
    fails = casadi.logic_and(way.condition, opposite(split.condition))
    yield from _ways(Way(fails, split.other, Changes({**way.changes, **split.other_changes})))


class Kernel(NamedTuple):
    """A parsed kernel: its place, parameters and body, and the names that it uses."""

    name: str
    parameters: tuple[str, ...]
    body: list[ast.stmt]
    globals: dict[str, Any]


@functools.cache
def _read(function: Any) -> Kernel:
    """Return the source of a function that was passed uncompiled."""
    (definition,) = ast.parse(textwrap.dedent(inspect.getsource(function))).body
    assert isinstance(definition, ast.FunctionDef)
    name = f"{function.__module__}.{function.__name__}"
    parameters = tuple(argument.arg for argument in definition.args.args)
    return Kernel(name, parameters, definition.body, function.__globals__)


@functools.cache
def _text(node: ast.AST) -> str:
    return ast.unparse(node)


@contextmanager
def _deep() -> Iterator[None]:
    before = sys.getrecursionlimit()
    sys.setrecursionlimit(max(before, DEEPEST))
    try:
        yield
    finally:
        sys.setrecursionlimit(before)


class Interpreter:
    """Evaluates kernels whose arrays hold symbols."""

    def __init__(self) -> None:
        self._journal = Journal()

    def call(self, kernel: Any, *arguments: Any) -> Any:
        """Call a kernel, and return its result.

        Parameters
        ----------
        kernel : callable
            A compiled function of the package.
        *arguments
            Numbers, symbols, NamedTuples, and arrays as :class:`psp3.symbolic.memory.Piece`, which
            are written to.

        Raises
        ------
        TypeError
            If an index or the number of turns of a loop depends on a symbol.
        """
        with _deep():
            return self._call(kernel, arguments)

    def _call(self, kernel: Any, arguments: Any) -> Any:
        if hasattr(kernel, "bodies"):
            kernel = kernel.bodies[type(arguments[0])]
        known = _read(getattr(kernel, "py_func", kernel))
        scope = _Scope(self, known, dict(zip(known.parameters, arguments, strict=True)))
        signal = self.after(scope.block(known.body), lambda s: Signal("return") if s is NEXT else s)
        return signal.value

    def write(self, container: Any, index: Any, value: Any) -> None:
        """Write an entry of an array or a variable."""
        self._journal.write(container, index, value)

    def both(self, condition: SX, one: Callable[[], Any], other: Callable[[], Any]) -> Any:
        """Return how two ways from one memory end, and merge their changes in the memory.

        Ways that end alike become one, so that the following statements are evaluated once for each
        kind of end, independent of the number of branches before.
        """
        ways: dict[str, Way] = {}
        for holds, run in ((condition, one), (opposite(condition), other)):
            for way in _ways(Way(holds, *self._journal.tried(run))):
                known = ways.get(way.end.kind)
                ways[way.end.kind] = way if known is None else self._united(known, way)
        first, *others = ways.values()
        if not others:
            self._journal.redo(first.changes)
            return first.end
        last = others[-1]
        rest, changes = last.end, last.changes
        for way in reversed([first, *others[:-1]]):
            rest = Split(way.condition, way.end, way.changes, rest, changes)
            changes = Changes()
        return rest

    def _united(self, one: Way, other: Way) -> Way:
        """Merge two ways that end alike into one."""
        holds = casadi.logic_or(one.condition, other.condition)
        changes = self._journal.merged(one.condition, one.changes, other.changes)
        if one.end.value is None:
            return Way(holds, other.end, changes)
        value = chosen(one.condition, one.end.value, other.end.value)
        return Way(holds, Signal(one.end.kind, value), changes)

    def after(self, signal: Any, proceed: Callable[[Signal], Any]) -> Any:
        """Return how the following statements end, for each way in which one may have ended."""
        if not isinstance(signal, Split):
            return proceed(signal)

        def resumed(changes: Changes, end: Any) -> Callable[[], Any]:
            def run() -> Any:
                self._journal.redo(changes)
                return self.after(end, proceed)

            return run

        return self.both(
            signal.condition,
            resumed(signal.changes, signal.one),
            resumed(signal.other_changes, signal.other),
        )


class _Scope:
    """One call of a kernel: its variables, and how its statements and expressions are evaluated."""

    def __init__(self, interpreter: Interpreter, kernel: Kernel, names: dict[str, Any]) -> None:
        self._interpreter, self._kernel, self._names = interpreter, kernel, names

    # Statements

    def block(self, body: list[ast.stmt]) -> Any:
        """Return how a sequence of statements ends."""
        for k, statement in enumerate(body):
            signal = self._statement(statement)
            if signal is NEXT:
                continue
            if isinstance(signal, Split):
                return self._interpreter.after(signal, functools.partial(self._on, body[k + 1 :]))
            return signal
        return NEXT

    def _on(self, rest: list[ast.stmt], signal: Signal) -> Any:
        """Return how a block ends after one of its statements has ended in a way."""
        return self.block(rest) if signal is NEXT else signal

    def _statement(self, node: ast.stmt) -> Any:
        evaluate: Any = _STATEMENTS.get(type(node))
        if evaluate is None:
            raise TypeError(f"{self._kernel.name}, line {node.lineno}: {_text(node)}")
        return evaluate(self, node)

    def _assign(self, node: ast.Assign) -> Signal:
        value = self.value(node.value)
        for target in node.targets:
            self._give(target, value)
        return NEXT

    def _assign_typed(self, node: ast.AnnAssign) -> Signal:
        assert node.value is not None
        self._give(node.target, self.value(node.value))
        return NEXT

    def _assign_more(self, node: ast.AugAssign) -> Signal:
        target = node.target
        read = ast.copy_location(_loaded(target), target)
        value = BINARY[type(node.op)](self.value(read), self.value(node.value))
        self._give(target, value)
        return NEXT

    def _give(self, target: ast.expr, value: Any) -> None:
        if isinstance(target, ast.Name):
            self._interpreter.write(self._names, target.id, value)
        elif isinstance(target, ast.Tuple):
            for one, part in zip(target.elts, value, strict=True):
                self._give(one, part)
        else:
            assert isinstance(target, ast.Subscript)
            whole_array: Piece = self.value(target.value)
            if isinstance(target.slice, ast.Slice):
                part = self._part(whole_array, target.slice)
                for at in range(part.start, part.start + part.size):
                    self._interpreter.write(part.cells, at, value)
            else:
                at = whole_array.place(self.value(target.slice))
                self._interpreter.write(whole_array.cells, at, value)

    def _expression(self, node: ast.Expr) -> Signal:
        if not isinstance(node.value, ast.Constant):
            self.value(node.value)
        return NEXT

    def _return(self, node: ast.Return) -> Signal:
        return Signal("return", None if node.value is None else self.value(node.value))

    def _if(self, node: ast.If) -> Any:
        test = self._test(node.test)
        if is_symbol(test):
            return self._interpreter.both(
                test, lambda: self.block(node.body), lambda: self.block(node.orelse)
            )
        return self.block(node.body if test else node.orelse)

    def _for(self, node: ast.For) -> Any:
        return self._turns(node, list(self.value(node.iter)))

    def _turns(self, node: ast.For, numbers: list[int]) -> Any:
        for k, number in enumerate(numbers):
            self._give(node.target, number)
            signal = self._turn(node.body)
            if signal is not NEXT:
                others = functools.partial(self._turns, node, numbers[k + 1 :])
                return self._left(signal, others)
        return NEXT

    def _while(self, node: ast.While) -> Any:
        while True:
            test = self._test(node.test)
            if is_symbol(test):
                return self._interpreter.both(test, lambda: self._again(node), lambda: NEXT)
            if not test:
                return NEXT
            signal = self._turn(node.body)
            if signal is not NEXT:
                return self._left(signal, lambda: self._while(node))

    def _again(self, node: ast.While) -> Any:
        return self._left(self._turn(node.body), lambda: self._while(node))

    def _turn(self, body: list[ast.stmt]) -> Any:
        """Return how a turn of a loop ends; ways that both go on to the next turn become one."""
        return self._interpreter.after(self.block(body), lambda s: NEXT if s is CONTINUE else s)

    def _left(self, signal: Any, others: Callable[[], Any]) -> Any:
        """Return how a loop ends after a turn; ways that have not left it continue."""

        def end(signal: Signal) -> Any:
            if signal is NEXT:
                return others()
            return NEXT if signal is BREAK else signal

        return self._interpreter.after(signal, end)

    # Expressions

    def value(self, node: ast.expr) -> Any:
        evaluate: Any = _EXPRESSIONS.get(type(node))
        if evaluate is None:
            raise TypeError(f"{self._kernel.name}, line {node.lineno}: {_text(node)}")
        return evaluate(self, node)

    def _test(self, node: ast.expr) -> Number:
        """Return whether a condition is true: known, a symbol, or the guards' answer."""
        value = self.value(node)
        if not is_symbol(value):
            return value
        guard = GUARDS.get((self._kernel.name, _text(node)))
        return value if guard is None else guard

    def _constant(self, node: ast.Constant) -> Any:
        return node.value

    def _name(self, node: ast.Name) -> Any:
        try:
            return self._names[node.id]
        except KeyError:
            return self._kernel.globals[node.id]

    def _binary(self, node: ast.BinOp) -> Number:
        return BINARY[type(node.op)](self.value(node.left), self.value(node.right))

    def _unary(self, node: ast.UnaryOp) -> Number:
        if isinstance(node.op, ast.Not):
            return opposite(self._test(node.operand))
        return negated(self.value(node.operand))

    def _compare(self, node: ast.Compare) -> Number:
        left, holds = self.value(node.left), True
        for sign, other in zip(node.ops, node.comparators, strict=True):
            right = self.value(other)
            holds = _and(holds, COMPARISONS[type(sign)](left, right))
            left = right
        return holds

    def _both_or_one(self, node: ast.BoolOp) -> Number:
        return self._of_truths(node.values, isinstance(node.op, ast.And))

    def _of_truths(self, nodes: list[ast.expr], all_of_them: bool) -> Number:
        test = self._test(nodes[0])
        if len(nodes) == 1:
            return test
        rest = functools.partial(self._of_truths, nodes[1:], all_of_them)
        if not is_symbol(test):
            return rest() if bool(test) == all_of_them else test
        if all_of_them:
            return self._either(test, rest, lambda: False)
        return self._either(test, lambda: True, rest)

    def _either(self, test: SX, one: Callable[[], Any], other: Callable[[], Any]) -> Any:
        return self._interpreter.both(
            test, lambda: Signal("value", one()), lambda: Signal("value", other())
        ).value

    def _choice(self, node: ast.IfExp) -> Any:
        test = self._test(node.test)
        if is_symbol(test):
            return self._either(
                test, lambda: self.value(node.body), lambda: self.value(node.orelse)
            )
        return self.value(node.body if test else node.orelse)

    def _tuple(self, node: ast.Tuple) -> tuple[Any, ...]:
        return tuple(self.value(part) for part in node.elts)

    def _ends(self, node: ast.Slice) -> slice:
        first, end = (None if e is None else whole(self.value(e)) for e in (node.lower, node.upper))
        return slice(first, end)

    def _part(self, whole_array: Piece, node: ast.Slice) -> Piece:
        return whole_array.part(self._ends(node))

    def _subscript(self, node: ast.Subscript) -> Any:
        whole_array = self.value(node.value)
        if isinstance(node.slice, ast.Slice):
            if isinstance(whole_array, tuple):
                return whole_array[self._ends(node.slice)]
            return self._part(whole_array, node.slice)
        index = self.value(node.slice)
        if isinstance(whole_array, tuple):
            return whole_array[index]
        if len(whole_array.shape) == 2 and not isinstance(index, tuple):
            return whole_array.row(index)
        return whole_array.cells[whole_array.place(index)]

    def _attribute(self, node: ast.Attribute) -> Any:
        if isinstance(node.value, ast.Name) and node.value.id == "math":
            return CONSTANTS[node.attr]
        return getattr(self.value(node.value), node.attr)

    def _called(self, node: ast.Call) -> Any:
        arguments = [self.value(argument) for argument in node.args]
        if isinstance(node.func, ast.Attribute):
            return self._method(node.func, arguments)
        assert isinstance(node.func, ast.Name)
        function = self._kernel.globals.get(node.func.id)
        if function is None:
            return CALLS[node.func.id](*arguments)
        if isinstance(function, type):
            return function(*arguments)
        return self._interpreter._call(function, arguments)

    def _method(self, node: ast.Attribute, arguments: list[Any]) -> Any:
        if isinstance(node.value, ast.Name) and node.value.id == "math":
            return FUNCTIONS[node.attr](*arguments)
        if isinstance(node.value, ast.Name) and node.value.id == "np":
            shape = arguments[0] if isinstance(arguments[0], tuple) else (arguments[0],)
            sizes = tuple(whole(size) for size in shape)
            nothing = {"empty": math.nan, "zeros": 0.0}[node.attr]
            return Piece([nothing] * math.prod(sizes), 0, sizes)
        whole_array: Piece = self.value(node.value)
        assert node.attr == "reshape", node.attr
        return Piece(whole_array.cells, whole_array.start, tuple(whole(size) for size in arguments))


@functools.cache
def _loaded(target: ast.expr) -> ast.expr:
    """Return the expression that reads the target of an assignment."""
    return ast.parse(ast.unparse(target), mode="eval").body


def _and(one: Number, other: Number) -> Number:
    if not is_symbol(one):
        return other if one else one
    if not is_symbol(other):
        return one if other else other
    return choice(one, other, False)


_STATEMENTS = {
    ast.AnnAssign: _Scope._assign_typed,
    ast.Assign: _Scope._assign,
    ast.AugAssign: _Scope._assign_more,
    ast.Break: lambda scope, node: BREAK,
    ast.Continue: lambda scope, node: CONTINUE,
    ast.Expr: _Scope._expression,
    ast.For: _Scope._for,
    ast.If: _Scope._if,
    ast.Pass: lambda scope, node: NEXT,
    ast.Return: _Scope._return,
    ast.While: _Scope._while,
}

_EXPRESSIONS = {
    ast.Attribute: _Scope._attribute,
    ast.BinOp: _Scope._binary,
    ast.BoolOp: _Scope._both_or_one,
    ast.Call: _Scope._called,
    ast.Compare: _Scope._compare,
    ast.Constant: _Scope._constant,
    ast.IfExp: _Scope._choice,
    ast.Name: _Scope._name,
    ast.Subscript: _Scope._subscript,
    ast.Tuple: _Scope._tuple,
    ast.UnaryOp: _Scope._unary,
}
