"""The page of the architecture and its picture say what the packages are.

Its recipes are run by ``test_docs.py``, as the code of every page.
"""

from __future__ import annotations

import ast
import importlib
import importlib.util
import json
import pkgutil
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
SETTINGS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]
ROOTS = ("psp3", "fuzzy2")
SOURCES = [path for folder in (*ROOTS, "urdf") for path in sorted((ROOT / folder).rglob("*.py"))]
LONGEST = 500
FENCE = re.compile(r"^```(\w*)\n(.*?)^```", flags=re.DOTALL | re.MULTILINE)


def section(title: str) -> str:
    """Return what stands below a heading, up to the next one of its level."""
    _, _, rest = PAGE.partition(f"\n## {title}\n")
    assert rest, f"no section {title!r}"
    return rest.partition("\n## ")[0]


def rows(text: str) -> list[list[str]]:
    """Return the cells of all tables, without their heads."""
    lines = re.findall(r"^\|(.*)\|$", text, flags=re.MULTILINE)
    cells = [[cell.strip() for cell in line.split(" | ")] for line in lines]
    return [row for row in cells if row[0].startswith("`") or row[0].isdigit()]


def layers(root: str) -> list[list[str]]:
    (found,) = (
        contract["layers"]
        for contract in SETTINGS["importlinter"]["contracts"]
        if contract.get("containers") == [root]
    )
    return [[f"{root}.{name.strip()}" for name in layer.split("|")] for layer in found]


def facades() -> set[str]:
    """Return the packages that list the names they offer."""
    packages = set(ROOTS) | {
        found.name
        for root in ROOTS
        for found in pkgutil.walk_packages(importlib.import_module(root).__path__, f"{root}.")
        if found.ispkg
    }
    return {name for name in packages if hasattr(importlib.import_module(name), "__all__")}


def public_modules() -> set[str]:
    return {
        f"{package.strip('`')}.{module}"
        for package, modules in rows(section("What is public"))
        for module in re.findall(r"`(\w+)`", modules)
    }


@pytest.mark.parametrize("root", ROOTS)
def test_layers_are_those_of_the_contracts_with_a_line_for_every_package(root: str) -> None:
    lines = [row for row in rows(section("The layers")) if row[1].startswith(f"`{root}.")]
    said = [(int(number), name.strip("`")) for number, name, _ in lines]
    assert said == [
        (number, name) for number, layer in enumerate(layers(root), start=1) for name in layer
    ]
    assert all(len(words.split()) > 1 for _, _, words in lines)
    there = pkgutil.iter_modules(importlib.import_module(root).__path__, f"{root}.")
    assert {name for _, name in said} == {found.name for found in there}


def test_picture_shows_every_package_in_its_place() -> None:
    """Boxes are named in the file; those of one layer stand side by side, others below them."""
    picture = (ROOT / "docs" / "pictures" / "architecture.svg").read_text(encoding="utf-8")
    corners = re.findall(r'<g id="((?:psp3|fuzzy2)\.\w+)">\s*<path d="M ([\d.]+) ([\d.]+)', picture)
    heights = {name: float(y) for name, _, y in corners}
    assert list(heights) == [name for root in ROOTS for layer in layers(root) for name in layer]
    levels = [{heights[name] for name in layer} for root in ROOTS for layer in layers(root)]
    assert all(len(level) == 1 for level in levels)
    assert (order := [level.pop() for level in levels]) == sorted(order)


def test_every_long_file_is_named_with_its_reason_and_no_other() -> None:
    named = {name.strip("`"): why for name, why in rows(section("Files above 500 lines"))}
    lengths = {
        path.relative_to(ROOT).as_posix(): len(path.read_text(encoding="utf-8").splitlines())
        for path in SOURCES
    }
    assert sorted(named) == sorted(name for name, lines in lengths.items() if lines > LONGEST)
    assert all(len(why.split()) >= 4 for why in named.values())


@pytest.mark.skipif(
    importlib.util.find_spec("ruff") is None,
    reason="ruff is not installed: make lint",
)
def test_every_exception_to_ruffs_limits_is_named_and_no_other() -> None:
    """However it is allowed: ruff looks with the limits of the project and without exceptions."""
    lint = SETTINGS["ruff"]["lint"]
    limits = (
        f"lint.mccabe.max-complexity={lint['mccabe']['max-complexity']}",
        f"lint.pylint.max-args={lint['pylint']['max-args']}",
    )
    command = [sys.executable, "-m", "ruff", "check", "--isolated", "--ignore-noqa", "--no-cache"]
    command += ["--select", "C901,PLR0913", "--output-format", "json", "--exit-zero"]
    command += [argument for limit in limits for argument in ("--config", limit)]
    answer = subprocess.run(
        [*command, *ROOTS], cwd=ROOT, capture_output=True, text=True, check=True
    )
    found = set()
    for problem in json.loads(answer.stdout):
        path, start, end = (
            Path(problem["filename"]),
            problem["location"],
            problem["end_location"],
        )
        line = path.read_text(encoding="utf-8").splitlines()[start["row"] - 1]
        name = line[start["column"] - 1 : end["column"] - 1]
        found.add((path.relative_to(ROOT).as_posix(), name))
    named = rows(section("Exceptions to ruff's limits"))
    assert found == {
        (file.strip("`"), name)
        for file, functions, _ in named
        for name in re.findall(r"`(\w+)`", functions)
    }
    assert all(len(why.split()) >= 4 for _, _, why in named)


def test_every_name_and_file_on_the_page_is_there() -> None:
    """Names of modules, classes and functions; files and folders of the repository."""
    words = re.findall(r"`([^`\n]+)`", FENCE.sub("", PAGE))
    names = {word for word in words if re.fullmatch(r"(psp3|fuzzy2)(\.\w+)+", word)}
    paths = {word for word in words if re.fullmatch(r"\w+(/\w+)*(/|\.\w+)", word) and "/" in word}
    assert len(names) > 50
    assert len(paths) > 20
    for name in sorted(names):
        pkgutil.resolve_name(name)
    assert [path for path in sorted(paths) if not (ROOT / path).exists()] == []


def imported_by_pages() -> Iterator[tuple[str, str]]:
    """Yield the modules of ours that code of pages and notebooks imports, with where it does."""
    for page in (ROOT / "README.md", *(ROOT / "docs").rglob("*.md")):
        for language, code in FENCE.findall(page.read_text(encoding="utf-8")):
            if language == "python":
                yield from ((module, page.name) for module in imported(code))
    for notebook in (ROOT / "notebooks").glob("*.ipynb"):
        for cell in json.loads(notebook.read_text(encoding="utf-8"))["cells"]:
            if cell["cell_type"] == "code":
                yield from ((module, notebook.name) for module in imported("".join(cell["source"])))


def imported(code: str) -> Iterator[str]:
    for node in ast.walk(ast.parse(code)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name.startswith(ROOTS))
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith(ROOTS):
            for alias in node.names:
                submodule = f"{node.module}.{alias.name}"
                is_module = importlib.util.find_spec(str(node.module)).submodule_search_locations
                is_module = is_module and importlib.util.find_spec(submodule)
                yield submodule if is_module else str(node.module)


def test_public_are_the_facades_and_what_pages_import_by_its_path() -> None:
    said, _, _ = section("What is public").partition("`tests/")
    assert set(re.findall(r"`((?:psp3|fuzzy2)[.\w]*)`", said)) == facades()
    listed = public_modules()
    for module in listed:
        importlib.import_module(module)
    known = listed | facades()
    assert {(module, page) for module, page in imported_by_pages() if module not in known} == set()
