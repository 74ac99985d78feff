"""Tests that are answered once for all are in the kernels that they are said to be in."""

from __future__ import annotations

import ast
import inspect
import pkgutil
import textwrap

import pytest

from psp3.symbolic.guards import GUARDS


def tests_of(name: str) -> set[str]:
    """Return all that a kernel asks, also as a part of a test."""
    kernel = pkgutil.resolve_name(name)
    tree = ast.parse(textwrap.dedent(inspect.getsource(getattr(kernel, "py_func", kernel))))
    asked: list[ast.expr] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.If | ast.While | ast.IfExp):
            asked.append(node.test)
    found = set()
    for test in asked:
        found |= {ast.unparse(part) for part in ast.walk(test) if isinstance(part, ast.expr)}
    return found | {
        ast.unparse(part)
        for node in ast.walk(tree)
        if isinstance(node, ast.BoolOp)
        for part in node.values
    }


@pytest.mark.parametrize("guard", GUARDS, ids=" ".join)
def test_a_guard_is_a_test_of_its_kernel(guard: tuple[str, str]) -> None:
    kernel, test = guard
    assert test in tests_of(kernel)
