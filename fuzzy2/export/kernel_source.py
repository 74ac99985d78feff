"""The Python source of a kernel, and the variables that its statements use.

A kernel is translated for every combination of argument types. The code of a robot has hundreds of
such translations, and each of them goes over all loops several times. So the results of searches in
the syntax tree are kept as long as the kernel exists.
"""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections import ChainMap
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any
from weakref import WeakKeyDictionary


@dataclass(frozen=True)
class KernelSource:
    """Source of a kernel: its place and its syntax tree, which must not be changed.

    Parameters
    ----------
    tree : ast.FunctionDef
        The syntax tree, with line numbers relative to the first line of the function.
    file : str
        The file.
    first : int
        Line of the file at which the function, or the first of its decorators, begins.
    names : mapping
        Values of its global names.
    found : dict
        Results of searches, by the kind of search and the identity of the node.
    """

    tree: ast.FunctionDef
    file: str
    first: int
    names: Mapping[str, Any]
    found: dict[Any, Any] = field(compare=False, repr=False)

    def place(self, node: Any) -> str:
        """Return file and line of a node."""
        return f"{self.file}, line {self.first + getattr(node, 'lineno', 1) - 1}"

    def assigned(self, body: list[ast.stmt]) -> frozenset[str]:
        """Return the names of the variables that statements assign, see :func:`assigned`."""
        key = "assigned", id(body)
        if key not in self.found:
            self.found[key] = frozenset(assigned(body))
        names: frozenset[str] = self.found[key]
        return names

    def is_read_beyond_its_loops(self, name: str) -> bool:
        """Return whether the variable of counted loops is read outside them."""
        key = "read", name
        if key not in self.found:
            self.found[key] = read_beyond_its_loops(self.tree.body, name)
        is_read: bool = self.found[key]
        return is_read

    def combined(self, node: ast.AugAssign) -> ast.expr:
        """Return the expression ``a + b`` of the statement ``a += b``."""
        key = "combined", id(node)
        if key not in self.found:
            target = ast.parse(ast.unparse(node.target), mode="eval").body
            whole = ast.copy_location(ast.BinOp(target, node.op, node.value), node)
            self.found[key] = ast.fix_missing_locations(whole)
        expression: ast.expr = self.found[key]
        return expression


_SYNTAX: WeakKeyDictionary[Callable[..., Any], tuple[ast.FunctionDef, str, int, dict[Any, Any]]] = (
    WeakKeyDictionary()
)


def source_of(body: Callable[..., Any]) -> KernelSource:
    """Return the source of a Python function."""
    if body not in _SYNTAX:
        lines, first = inspect.getsourcelines(body)
        tree = ast.parse(textwrap.dedent("".join(lines))).body[0]
        assert isinstance(tree, ast.FunctionDef)
        _SYNTAX[body] = tree, inspect.getsourcefile(body) or body.__module__, first, {}
    tree, file, first, found = _SYNTAX[body]
    # The values of names may change, so they are not kept.
    around = dict(inspect.getclosurevars(body).nonlocals) if body.__closure__ else {}
    return KernelSource(tree, file, first, ChainMap(around, body.__globals__), found)


def assigned(body: list[ast.stmt]) -> set[str]:
    """Return the names of the variables that statements assign."""
    return {name.id for name in _names(body) if isinstance(name.ctx, ast.Store)}


def read(body: list[ast.stmt]) -> set[str]:
    """Return the names that statements read."""
    return {name.id for name in _names(body) if isinstance(name.ctx, ast.Load)}


def _names(body: list[ast.stmt]) -> Iterator[ast.Name]:
    for statement in body:
        for node in ast.walk(statement):
            if isinstance(node, ast.Name):
                yield node


def jumps(body: list[ast.stmt]) -> bool:
    """Return whether statements contain a ``break`` or ``continue`` of the loop around them."""
    for statement in body:
        if isinstance(statement, ast.Break | ast.Continue):
            return True
        if isinstance(statement, ast.If) and jumps([*statement.body, *statement.orelse]):
            return True
    return False


def read_beyond_its_loops(body: list[ast.stmt], name: str) -> bool:
    """Return whether the variable of counted loops is read outside them."""
    waiting: list[ast.AST] = list(body)
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.Name) and node.id == name and isinstance(node.ctx, ast.Load):
            return True
        children = list(ast.iter_child_nodes(node))
        if isinstance(node, ast.For) and ast.unparse(node.target) == name:
            children = [node.iter]
        waiting += children
    return False
