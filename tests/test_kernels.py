"""Kernels of the core keep to the small subset of Python that ``docs/architecture.md`` names.

It is what can be written in C line by line. Nothing is run here: the text is read.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Iterator
from pathlib import Path

import pytest

CORE = Path(__file__).resolve().parents[1] / "psp3" / "multibody"
DECORATORS = {"scalar"}
BUILT_IN = {"abs", "float", "int", "max", "min", "range"}
MATHEMATICS = {"atan2", "cos", "inf", "sin", "sqrt", "tan"}

STATEMENTS = (
    ast.AnnAssign,
    ast.Assign,
    ast.AugAssign,
    ast.Continue,
    ast.Expr,
    ast.For,
    ast.If,
    ast.Return,
)
EXPRESSIONS = (
    ast.Attribute,
    ast.BinOp,
    ast.BoolOp,
    ast.Call,
    ast.Compare,
    ast.Constant,
    ast.IfExp,
    ast.Name,
    ast.Subscript,
    ast.Tuple,
    ast.UnaryOp,
)
OPERATORS = (ast.Add, ast.Sub, ast.Mult, ast.Div, ast.FloorDiv, ast.Mod, ast.Not, ast.USub)
COMPARISONS = (ast.Eq, ast.NotEq, ast.Lt, ast.LtE, ast.Gt, ast.GtE)


def kernels() -> dict[str, tuple[str, ast.FunctionDef]]:
    """Return the kernels of the core by name, each with its module."""
    found = {}
    for path in sorted(CORE.glob("*.py")):
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.FunctionDef):
                names = {item.id for item in node.decorator_list if isinstance(item, ast.Name)}
                if names & DECORATORS:
                    assert node.name not in found, "two kernels of one name"
                    found[node.name] = path.stem, node
    return found


KERNELS = kernels()


def parts(kernel: ast.FunctionDef) -> Iterator[ast.AST]:
    """Yield the nodes of a kernel's body without its docstring and without types."""
    waiting: list[ast.AST] = list(kernel.body[1:])
    while waiting:
        node = waiting.pop()
        yield node
        if isinstance(node, ast.AnnAssign):
            waiting += [node.target, *([node.value] if node.value else [])]
        else:
            waiting += ast.iter_child_nodes(node)


def called(kernel: ast.FunctionDef) -> set[str]:
    return {
        node.func.id
        for node in parts(kernel)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    }


def test_there_are_kernels_in_every_module_that_computes() -> None:
    modules = {module for module, _ in KERNELS.values()}
    assert modules == {path.stem for path in CORE.glob("*.py")} - {
        "__init__",
        "core",
        "equations",
        "first_answers",
        "flatten",
        "named_frames",
        "tree",
    }
    assert len(KERNELS) > 50


@pytest.mark.parametrize("name", KERNELS)
def test_a_kernel_has_nothing_but_the_subset(name: str) -> None:
    """Numbers, entries of flat arrays, counted loops and branches."""
    _, kernel = KERNELS[name]
    assert ast.get_docstring(kernel)
    arguments = kernel.args
    assert not any((arguments.vararg, arguments.kwarg, arguments.kwonlyargs, arguments.defaults))
    for node in parts(kernel):
        where = f"line {getattr(node, 'lineno', '?')}: {ast.dump(node)[:80]}"
        if isinstance(node, ast.stmt):
            assert isinstance(node, STATEMENTS), where
        elif isinstance(node, ast.expr):
            assert isinstance(node, EXPRESSIONS), where
        elif isinstance(node, ast.operator | ast.unaryop):
            assert isinstance(node, OPERATORS), where
        elif isinstance(node, ast.cmpop):
            assert isinstance(node, COMPARISONS), where
        if isinstance(node, ast.Constant):
            assert isinstance(node.value, bool | int | float), where
        elif isinstance(node, ast.For):
            counts = node.iter
            assert isinstance(counts, ast.Call), where
            assert isinstance(counts.func, ast.Name), where
            assert counts.func.id == "range", where
            assert isinstance(node.target, ast.Name), where
        elif isinstance(node, ast.Call):
            assert not node.keywords, where
            if isinstance(node.func, ast.Name):
                assert node.func.id in BUILT_IN or node.func.id in KERNELS, where
            else:
                assert isinstance(node.func, ast.Attribute), where
        elif isinstance(node, ast.Attribute):
            assert isinstance(node.value, ast.Name), where
            owner = node.value.id
            assert node.attr in MATHEMATICS if owner == "math" else node.attr == "shape", where
            assert owner != "math" or hasattr(math, node.attr), where


@pytest.mark.parametrize("name", KERNELS)
def test_tuples_only_hand_several_numbers_to_as_many_names(name: str) -> None:
    _, kernel = KERNELS[name]
    handed = set()
    for node in parts(kernel):
        if isinstance(node, ast.Assign):
            target, value = node.targets[0], node.value
            if isinstance(target, ast.Tuple):
                assert isinstance(value, ast.Tuple), "every name gets its number there"
                assert len(target.elts) == len(value.elts)
                handed |= {id(target), id(value)}
    assert {id(node) for node in parts(kernel) if isinstance(node, ast.Tuple)} == handed


def test_no_kernel_comes_back_to_itself() -> None:
    """Neither directly nor through others: kernels are ranked by what they call."""
    left = {name: called(kernel) & set(KERNELS) for name, (_, kernel) in KERNELS.items()}
    while left:
        done = {name for name, needs in left.items() if not needs & set(left)}
        assert done, f"these call each other: {sorted(left)}"
        left = {name: needs for name, needs in left.items() if name not in done}


@pytest.mark.parametrize("name", KERNELS)
def test_names_are_the_kernels_own_or_constants(name: str) -> None:
    """Constants are in capitals, and nothing changes them."""
    _, kernel = KERNELS[name]
    own = {argument.arg for argument in kernel.args.args}
    nodes = [node for node in parts(kernel) if isinstance(node, ast.Name)]
    own |= {node.id for node in nodes if isinstance(node.ctx, ast.Store)}
    others = {node.id for node in nodes} - own - BUILT_IN - set(KERNELS) - {"math"}
    assert all(other.isupper() for other in others), others
