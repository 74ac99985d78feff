"""Tests that are answered once for all are in the kernels that they are said to be in."""

from __future__ import annotations

import ast
import inspect
import pkgutil
import textwrap

import pytest

from psp3.symbolic.guards import GUARDS


def asked_by(name: str) -> set[str]:
    """Return all that a kernel asks, also as a part of a test."""
    kernel = pkgutil.resolve_name(name)
    tree = ast.parse(textwrap.dedent(inspect.getsource(getattr(kernel, "py_func", kernel))))
    tests: list[ast.expr] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.If | ast.While | ast.IfExp):
            tests.append(node.test)
        elif isinstance(node, ast.BoolOp):
            tests.extend(node.values)
        elif isinstance(node, ast.UnaryOp):
            tests.append(node.operand)
    return {ast.unparse(test) for test in tests}


@pytest.mark.parametrize("guard", GUARDS, ids=" ".join)
def test_a_guard_is_a_test_of_its_kernel(guard: tuple[str, str]) -> None:
    kernel, test = guard
    assert test in asked_by(kernel)
