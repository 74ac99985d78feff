"""What machine code depends on: the sources of all kernels, and constants that they name."""

from __future__ import annotations

import ast
import functools
import gc
import importlib
import inspect
import itertools
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import fuzzy2
import psp3
from fuzzy2.support.code_stamp import sources_of_kernels
from fuzzy2.support.compile_unit import Kernel

CONSTANTS = """
from {package}.more import FURTHER
ADDED = 1.0 + FURTHER
"""

MORE = """
FURTHER = {value}
"""

INNER = """
from {package}.constants import ADDED
from fuzzy2.support.compiled import compiled

@compiled
def inner(x):
    return x + ADDED
"""

OUTER = """
from {package}.inner import inner
from fuzzy2.support.compiled import compiled

@compiled
def outer(x):
    return 2.0 * inner(x)
"""

ASK = "from {package}.outer import outer; print(outer(1.0), len(outer.stats.cache_hits))"


def written(folder: Path, value: float, package: str = "kernels") -> Path:
    own = folder / package
    own.mkdir(exist_ok=True, parents=True)
    (own / "__init__.py").write_text("", encoding="utf-8")
    for name, text in (
        ("constants", CONSTANTS),
        ("more", MORE),
        ("inner", INNER),
        ("outer", OUTER),
        ("apart", "ELSEWHERE = 1\n"),
    ):
        text = text.format(package=package, value=value)
        (own / f"{name}.py").write_text(text, encoding="utf-8")
    return own


def asked(folder: Path, cache: Path | None = None, package: str = "kernels") -> list[str]:
    """Return what a new process computes, and how often from the disk."""
    environment = {**os.environ, **({} if cache is None else {"NUMBA_CACHE_DIR": str(cache)})}
    # Python's own byte code does not see a change of the same size within a second.
    environment["PYTHONDONTWRITEBYTECODE"] = "1"
    command = [sys.executable, "-c", ASK.format(package=package)]
    done = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, check=True, env=environment
    )
    return done.stdout.split()


@pytest.mark.slow
def test_code_is_forgotten_when_something_that_it_calls_or_names_has_changed(
    tmp_path: Path,
) -> None:
    """In a file that has not changed itself, as after ``git pull``: a function, and a constant."""
    own = written(tmp_path, 0.0)
    assert asked(tmp_path) == ["4.0", "0"]
    assert asked(tmp_path) == ["4.0", "1"]
    # Of a module without compiled functions, through another one.
    written(tmp_path, 4.0)
    assert asked(tmp_path) == ["12.0", "0"]
    (own / "inner.py").write_text(
        INNER.format(package="kernels").replace("x +", "x -"), encoding="utf-8"
    )
    assert asked(tmp_path) == ["-8.0", "0"]
    # What has to do with no kernel changes nothing.
    (own / "apart.py").write_text("ELSEWHERE = 2\n", encoding="utf-8")
    assert asked(tmp_path) == ["-8.0", "1"]


@pytest.mark.slow
def test_two_versions_side_by_side_keep_their_code_apart(tmp_path: Path) -> None:
    """In one folder for code, and one after the other at the same place, as ``git switch`` does."""
    one, other, cache = tmp_path / "one", tmp_path / "other", tmp_path / "cache"
    written(one, 0.0)
    written(other, 4.0)
    for hits in ("0", "1"):
        assert asked(one, cache) == ["4.0", hits]
        assert asked(other, cache) == ["12.0", hits]
    for value, answer in ((4.0, "12.0"), (0.0, "4.0"), (4.0, "12.0")):
        written(one, value)
        assert asked(one, cache)[0] == answer


def test_all_that_kernels_name_counts() -> None:
    """Whatever constant a kernel of either package takes, its modules are among the sources."""
    packages = [Path(next(iter(package.__path__))) for package in (psp3, fuzzy2)]
    found = sources_of_kernels(*packages)
    for path in found:
        package = next(one for one in packages if path.is_relative_to(one))
        importlib.import_module(".".join(path.relative_to(package.parent).with_suffix("").parts))
    named = set()
    for kernel in [one for one in gc.get_objects() if issubclass(type(one), Kernel)]:
        function: Any = kernel.py_func
        path = Path(inspect.getfile(function))
        if any(path.is_relative_to(package) for package in packages):
            named |= {(path, name) for name in function.__code__.co_names}
    modules = set(itertools.chain(*(modules_of(path, name, packages) for path, name in named)))
    assert len(named) > 1000
    assert Path(next(iter(psp3.__path__))) / "multibody" / "tree.py" in modules
    assert modules <= set(found)


@functools.cache
def module(path: Path) -> ast.Module:
    return ast.parse(path.read_bytes())


def modules_of(path: Path, name: str, packages: list[Path]) -> Iterator[Path]:
    """Yield the modules that give a name of a module its value, if it is a constant there."""
    for node in module(path).body:
        if isinstance(node, ast.ImportFrom) and name in [one.name for one in node.names]:
            parts = (node.module or "").split(".")
            for package in packages:
                source = package.parent.joinpath(*parts).with_suffix(".py")
                if source.is_file():
                    yield from modules_of(source, name, packages)
        elif isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            written = {one.id for target in targets for one in names_in(target)}
            if name in written and name.upper() == name:
                yield path
                for one in names_in(node.value):
                    yield from modules_of(path, one.id, packages)


def names_in(node: ast.AST) -> list[ast.Name]:
    return [one for one in ast.walk(node) if isinstance(one, ast.Name)]
