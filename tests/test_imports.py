"""The order of imports, with those that are for types only, which import-linter leaves out."""

from __future__ import annotations

import ast
import graphlib
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
CONTRACTS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"][
    "importlinter"
]["contracts"]


def name_of(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


SOURCES = {
    name_of(path): path for package in ("psp3", "fuzzy2") for path in (ROOT / package).rglob("*.py")
}


def imported(path: Path) -> Iterator[str]:
    """Yield the modules of the packages that a module imports: at its head, inside, for types."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module in SOURCES:
            for alias in node.names:
                submodule = f"{node.module}.{alias.name}"
                yield submodule if submodule in SOURCES else node.module
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in SOURCES)


IMPORTS = {name: set(imported(path)) - {name} for name, path in SOURCES.items()}


def test_imports_are_seen() -> None:
    """Of each kind one: at the head, in a function, for types."""
    assert "psp3.robots.closed_loop_robot" in IMPORTS["psp3.loading"]
    assert "psp3.description.mjcf" in IMPORTS["psp3.robots.closed_loop_robot"]
    assert "psp3.fuzzy_control.computed_torque" in IMPORTS["psp3.plots.control"]


def test_no_module_imports_itself_by_way_of_others() -> None:
    """Of a circle the error names the modules."""
    graphlib.TopologicalSorter(IMPORTS).prepare()


@pytest.mark.parametrize("root", ["psp3", "fuzzy2"])
def test_no_import_goes_up(root: str) -> None:
    """Layers as in ``pyproject.toml``; those beside each other do not know each other."""
    (layers,) = (
        contract["layers"] for contract in CONTRACTS if contract.get("containers") == [root]
    )
    height = {
        f"{root}.{name.strip()}": -number
        for number, layer in enumerate(layers)
        for name in layer.split("|")
    }

    def package(module: str) -> str:
        return ".".join(module.split(".")[:2])

    upward = [
        f"{source} -> {target}"
        for source, targets in IMPORTS.items()
        for target in targets
        if package(source) in height
        and package(target) in height
        and package(source) != package(target)
        and height[package(target)] >= height[package(source)]
    ]
    assert upward == []


def test_few_modules_stand_outside_of_packages() -> None:
    """Each of them is what all others stand on, or what stands on all others."""
    outside = {
        root: sorted(path.stem for path in (ROOT / root).glob("*.py"))
        for root in ("psp3", "fuzzy2")
    }
    assert outside["fuzzy2"] == ["__init__", "errors"]
    assert outside["psp3"] == [
        "__init__",
        "checks",
        "errors",
        "loading",
        "published",
        "version",
        "warm_up",
    ]


def test_only_the_3_psp_and_its_thesis_ask_whether_a_robot_is_one() -> None:
    """Everything else serves every robot alike, through the methods of the robot."""
    asked = [
        f"{name}:{node.lineno}"
        for name, path in SOURCES.items()
        if not name.startswith(("psp3.three_psp", "psp3.thesis", "psp3.fuzzy_control"))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call)
        and ast.unparse(node.func) == "isinstance"
        and "PSP3" in {name.id for name in ast.walk(node.args[1]) if isinstance(name, ast.Name)}
    ]
    assert asked == []
