"""The Python source of a kernel, and the variables that its statements use."""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class KernelSource:
    """Source of a kernel: its place and its syntax tree.

    Parameters
    ----------
    tree : ast.FunctionDef
        The syntax tree, with line numbers relative to the first line of the function.
    file : str
        The file.
    first : int
        Line of the file where the function, or its first decorator, begins.
    names : dict
        Values of its global names.
    """

    tree: ast.FunctionDef
    file: str
    first: int
    names: dict[str, Any]

    def place(self, node: Any) -> str:
        """Return file and line of a node."""
        return f"{self.file}, line {self.first + getattr(node, 'lineno', 1) - 1}"


def source_of(body: Callable[..., Any]) -> KernelSource:
    """Return the source of a Python function."""
    lines, first = inspect.getsourcelines(body)
    tree = ast.parse(textwrap.dedent("".join(lines))).body[0]
    assert isinstance(tree, ast.FunctionDef)
    names = {**body.__globals__, **inspect.getclosurevars(body).nonlocals}
    return KernelSource(tree, inspect.getsourcefile(body) or body.__module__, first, names)


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
