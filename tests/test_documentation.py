"""Sphinx builds the documentation without a warning, and what it builds is whole."""

from __future__ import annotations

import importlib.util
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import fuzzy2
import psp3

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        any(importlib.util.find_spec(module) is None for module in ("sphinx", "myst_nb", "furo")),
        reason="Sphinx, MyST-NB and Furo are not installed: make docs",
    ),
]

ROOT = Path(__file__).resolve().parents[1]
FROM_ELSEWHERE = re.compile(r'<(?:script|link|img)\b[^>]*(?:src|href)="(?:https?:)?//')


def build(docs: Path, *options: str) -> Path:
    """Build the pages of a folder, with warnings as errors; return where they are."""
    built = docs.parent / "html"
    command = ["sphinx", "-W", "--keep-going", "-q", "-b", "html", "-d", f"{built}.doctrees"]
    done = subprocess.run(
        [sys.executable, "-m", *command, *options, str(docs), str(built)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        encoding="utf-8",
    )
    assert done.returncode == 0, done.stderr
    return built


def load_from_elsewhere(pages: Path) -> list[str]:
    """Return the pages for which a browser needs the network."""
    return [
        page.name
        for page in pages.rglob("*.html")
        if FROM_ELSEWHERE.search(page.read_text(encoding="utf-8"))
    ]


def test_documentation_builds_without_warnings_and_has_every_public_name(tmp_path: Path) -> None:
    """Of the reference: names that the packages offer, under the modules they are defined in.

    With a plain theme, whose pages do not each repeat the contents of all: it takes half the time.
    The documentation is built from a copy, since its reference is written beside its pages.
    """
    from sphinx.util.inventory import InventoryFile

    for entry in ROOT.iterdir():
        if entry.name != "docs":
            (tmp_path / entry.name).symlink_to(entry)
    made = shutil.ignore_patterns("_build", "api", "notebooks")
    shutil.copytree(ROOT / "docs", tmp_path / "docs", ignore=made)
    plain = ("-D", "html_theme=basic", "-D", "toc_object_entries=0")
    pages = build(tmp_path / "docs", *plain)
    with (pages / "objects.inv").open("rb") as file:
        inventory = InventoryFile.load(file, "", lambda uri, name: name)
    known = {
        entry for kind, entries in inventory.items() if kind.startswith("py:") for entry in entries
    }
    for package in (psp3, fuzzy2):
        for public in package.__all__:
            module = getattr(getattr(package, public), "__module__", None)
            assert module is None or f"{module}.{public}" in known, f"{package.__name__}.{public}"
    assert load_from_elsewhere(pages) == []


def test_theme_of_the_documentation_needs_no_network(tmp_path: Path) -> None:
    """A page of one equation and one block of code, under the settings of the documentation."""
    docs = tmp_path / "docs"
    docs.mkdir()
    (docs / "index.md").write_text("# Page\n\n$a = b$\n\n```python\nprint(1)\n```\n")
    (docs / "conf.py").write_text(
        f"""import runpy

globals().update(runpy.run_path({str(ROOT / "docs" / "conf.py")!r}))
html_static_path = [{str(ROOT / "docs" / "_static")!r}]


def setup(app):
    app.connect("html-page-context", add_katex)
    app.add_html_math_renderer("formula", (formula, None), (formula, None))
"""
    )
    pages = build(docs)
    assert "furo" in (pages / "index.html").read_text(encoding="utf-8")
    assert load_from_elsewhere(pages) == []
