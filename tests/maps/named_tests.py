"""Tests by the names that the maps give them, and what they call."""

from __future__ import annotations

import ast
import pkgutil
from collections.abc import Iterator
from functools import cache, cached_property
from pathlib import Path

TESTS = Path(__file__).resolve().parents[1]

Definition = ast.FunctionDef | ast.ClassDef | ast.Assign | ast.AnnAssign


@cache
def functions_of(file: str) -> frozenset[str]:
    """Return the names of the functions of a file below tests/, not of those within others."""
    return frozenset(
        name for name, node in _names_of(file).items() if isinstance(node, ast.FunctionDef)
    )


def calls(test: str, function: str) -> bool:
    """Tell whether a test calls a function, itself or through what it uses of the tests.

    A function is called by its name, as an attribute, or from a table of functions, which is where
    parameters of tests come from; a class also through its methods. A property has only to be read.
    """
    file, name = test.split("::")
    called, read = _used_by(file, name)
    target: object = pkgutil.resolve_name(function)
    is_property = isinstance(target, property | cached_property)
    return function.rsplit(".", 1)[1] in (read if is_property else called)


@cache
def _used_by(file: str, name: str) -> tuple[frozenset[str], frozenset[str]]:
    """Return the names that a test calls, and the attributes that it reads.

    With those of the functions, fixtures and constants that it uses, of its own file, of those it
    imports from the tests, and of the conftest files above.
    """
    called, read = set[str](), set[str]()
    seen, waiting = set[tuple[str, str]](), [(file, name)]
    while waiting:
        place = waiting.pop()
        if place in seen:
            continue
        seen.add(place)
        node = _names_of(place[0])[place[1]]
        called |= set(_called_in(node))
        read |= {part.attr for part in ast.walk(node) if isinstance(part, ast.Attribute)}
        for used in _names_in(node):
            found = _defined_at(place[0], used)
            if found is not None:
                waiting.append(found)
    return frozenset(called), frozenset(read)


@cache
def _names_of(file: str) -> dict[str, Definition]:
    """Return what a file defines at its top, by name."""
    found: dict[str, Definition] = {}
    for node in _tree_of(file).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found[node.name] = node
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            for target in targets:
                found |= {part.id: node for part in ast.walk(target) if isinstance(part, ast.Name)}
    return found


@cache
def _imports_of(file: str) -> dict[str, tuple[str, str]]:
    """Return the names that a file imports from the tests, with file and name there."""
    found = {}
    for node in ast.walk(_tree_of(file)):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("tests."):
            source = "/".join(str(node.module).split(".")[1:]) + ".py"
            if (TESTS / source).is_file():
                found |= {name.asname or name.name: (source, name.name) for name in node.names}
    return found


@cache
def _tree_of(file: str) -> ast.Module:
    return ast.parse((TESTS / file).read_text(encoding="utf-8"))


def _defined_at(file: str, name: str) -> tuple[str, str] | None:
    """Return the file that defines a name as another one sees it; None if no test file does."""
    if name in _names_of(file):
        return file, name
    if name in _imports_of(file):
        source, there = _imports_of(file)[name]
        return _defined_at(source, there)
    for folder in Path(file).parents:
        fixtures = (folder / "conftest.py").as_posix()
        if (TESTS / fixtures).is_file() and name in _names_of(fixtures):
            return fixtures, name
    return None


def _names_in(node: ast.AST) -> Iterator[str]:
    """Yield names that are read, and those of arguments, which may be fixtures."""
    for part in ast.walk(node):
        if isinstance(part, ast.Name) and isinstance(part.ctx, ast.Load):
            yield part.id
        elif isinstance(part, ast.arg):
            yield part.arg


def _called_in(node: ast.AST) -> Iterator[str]:
    """Yield the last names of what is called or handed on, and classes whose methods are called."""
    for part in ast.walk(node):
        handed_on: list[ast.expr] = []
        if isinstance(part, ast.Call):
            handed_on = [part.func, *part.args, *(keyword.value for keyword in part.keywords)]
            owner = part.func.value if isinstance(part.func, ast.Attribute) else None
            name = _last_name(owner)
            if name is not None and name[:1].isupper():
                yield name
        elif isinstance(part, ast.List | ast.Tuple):
            handed_on = part.elts
        elif isinstance(part, ast.Dict):
            handed_on = part.values
        elif isinstance(part, ast.For | ast.comprehension):
            handed_on = [part.iter]
        yield from (name for name in map(_last_name, handed_on) if name is not None)


def _last_name(node: ast.expr | None) -> str | None:
    if isinstance(node, ast.Attribute):
        return node.attr
    return node.id if isinstance(node, ast.Name) else None
