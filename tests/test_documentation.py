"""Sphinx builds the documentation without a warning, and what it builds is whole."""

from __future__ import annotations

import html
import importlib.util
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import typer
from selenium import webdriver

import fuzzy2
import psp3
from psp3.cli.entry import app
from tests.page_helpers import wait_for

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        any(importlib.util.find_spec(module) is None for module in ("sphinx", "myst_nb", "furo")),
        reason="Sphinx, MyST-NB and Furo are not installed: make docs",
    ),
]

ROOT = Path(__file__).resolve().parents[1]
SHOWN = (
    "gallery.md",
    "robots.md",
    "results.md",
    "thesis.md",
    "concepts/natural_orthogonal_complement.md",
    "how_to/benchmark.md",
)
"""Pages that are looked at in the browser: thumbnails, wide tables, equations, code."""

BESIDE = """
const found = [], width = document.documentElement.clientWidth;
if (document.documentElement.scrollWidth > width) found.push("the page scrolls sideways");
for (const one of document.querySelectorAll("article *")) {
  if (one.closest("pre, div.formula, .table-wrapper, .katex")) continue;
  const box = one.getBoundingClientRect();
  if (box.width && (box.right > width + 1 || box.left < -1))
    found.push(`<${one.tagName}> ${one.textContent.trim().slice(0, 40)}`);
}
if (arguments[0])
  for (const one of document.querySelectorAll("article .table-wrapper"))
    if (one.scrollWidth > one.clientWidth + 1) found.push(`table ${one.textContent.slice(0, 60)}`);
for (const one of document.querySelectorAll(".formula:not(:has(.katex))"))
  found.push(`not drawn: ${one.textContent}`);
return found;
"""

UNDRAWN = """
return arguments[0].filter((equation) => {
  try { katex.renderToString(equation, { strict: false }); return false; }
  catch (error) { return true; }
});
"""

FORMULA = re.compile(r'<(?:div|span) class="formula"[^>]*>(.*?)</(?:div|span)>', re.DOTALL)
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


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build all pages, with a plain theme, whose pages do not each repeat the contents of all.

    It takes half the time. The documentation is built from a copy, since its reference is written
    beside its pages.
    """
    folder = tmp_path_factory.mktemp("whole")
    for entry in ROOT.iterdir():
        if entry.name != "docs":
            (folder / entry.name).symlink_to(entry)
    made = shutil.ignore_patterns("_build", "api", "notebooks")
    shutil.copytree(ROOT / "docs", folder / "docs", ignore=made)
    return build(folder / "docs", "-D", "html_theme=basic", "-D", "toc_object_entries=0")


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build some pages with the theme of the documentation, and the README as one of them.

    They lead to pages that are not built, of which no warning is wanted.
    """
    docs = tmp_path_factory.mktemp("shown") / "docs"
    docs.mkdir()
    (docs / "pictures").symlink_to(ROOT / "docs" / "pictures")
    for page in SHOWN:
        (docs / page).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / "docs" / page, docs / page)
    readme = (ROOT / "README.md").read_text(encoding="utf-8").replace("](docs/", "](")
    (docs / "readme.md").write_text(readme, encoding="utf-8")
    names = "\n".join(("readme", *(page.removesuffix(".md") for page in SHOWN)))
    (docs / "index.md").write_text(f"# Pages\n\n$a = b$\n\n```{{toctree}}\n{names}\n```\n")
    (docs / "conf.py").write_text(
        f"""import runpy

globals().update(runpy.run_path({str(ROOT / "docs" / "conf.py")!r}))
html_static_path = [{str(ROOT / "docs" / "_static")!r}]
suppress_warnings = ["myst", "toc", "ref"]


def setup(app):
    app.connect("html-page-context", add_katex)
    app.add_html_math_renderer("formula", (formula, None), (formula, None))
"""
    )
    return build(docs)


def test_documentation_builds_without_warnings_and_has_every_public_name(whole: Path) -> None:
    """Of the reference: names that the packages offer, under the modules they are defined in."""
    from sphinx.util.inventory import InventoryFile

    with (whole / "objects.inv").open("rb") as file:
        inventory = InventoryFile.load(file, "", lambda uri, name: name)
    known = {
        entry for kind, entries in inventory.items() if kind.startswith("py:") for entry in entries
    }
    for package in (psp3, fuzzy2):
        for public in package.__all__:
            module = getattr(getattr(package, public), "__module__", None)
            assert module is None or f"{module}.{public}" in known, f"{package.__name__}.{public}"
    assert load_from_elsewhere(whole) == []


def test_reference_has_no_private_modules(whole: Path) -> None:
    """Kernels and helpers are for who changes the packages, and are read in their source."""
    pages = {page.stem for page in (whole / "api").glob("*.html")}
    assert len(pages) > 100
    assert not [name for name in pages if "kernels" in name or "._" in name]
    assert "psp3.multibody.closing" not in pages


def test_command_line_page_has_every_command(whole: Path) -> None:
    text = (whole / "api" / "command_line.html").read_text(encoding="utf-8")
    for command in commands("psp3", app):
        assert f">{command}<" in text, command


def commands(path: str, group: typer.Typer) -> list[str]:
    """Return all commands of a group and of the groups in it."""
    found = [
        f"{path} {one.name or one.callback.__name__.replace('_', '-')}"
        for one in group.registered_commands
        if one.callback
    ]
    for inner in group.registered_groups:
        assert inner.typer_instance is not None
        found += commands(f"{path} {inner.typer_instance.info.name}", inner.typer_instance)
    return found


def test_theme_of_the_documentation_needs_no_network(shown: Path) -> None:
    assert "furo" in (shown / "index.html").read_text(encoding="utf-8")
    assert load_from_elsewhere(shown) == []


@pytest.mark.parametrize("size", [(390, 844), (1440, 900)], ids=["phone", "desktop"])
def test_no_page_scrolls_sideways(
    browser: webdriver.Chrome, shown: Path, size: tuple[int, int]
) -> None:
    """On a phone code, equations and tables scroll by themselves; on a desktop no table has to.

    What is beside the window otherwise is named, and formulas are drawn.
    """
    width, height = size
    browser.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride",
        {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False},
    )
    for page in ("readme", *(page.removesuffix(".md") for page in SHOWN)):
        browser.get((shown / f"{page}.html").as_uri())
        found = browser.execute_script(BESIDE, width > 1000)
        assert found == [], f"{page}: {found}"


def test_every_equation_can_be_drawn(browser: webdriver.Chrome, shown: Path, whole: Path) -> None:
    """Of the pages and of the docstrings, by the KaTeX that comes with them."""
    equations = {
        html.unescape(equation)
        for page in whole.rglob("*.html")
        for equation in FORMULA.findall(page.read_text(encoding="utf-8"))
    }
    assert len(equations) > 300
    browser.get((shown / "index.html").as_uri())
    assert browser.execute_script(UNDRAWN, sorted(equations)) == []


@pytest.mark.parametrize(
    ("words", "page"),
    [
        ("urdf", "robot_files"),
        ("stewart platform", "how_to/any_robot"),
        ("delta robot", "how_to/any_robot"),
        ("inverse dynamics of closed chains", "how_to/constrained_inverse_dynamics"),
        ("c code", "how_to/export"),
        ("fmu", "how_to/fmu"),
        ("anfis", "how_to/anfis"),
        ("matlab", "coming_from/matlab"),
    ],
)
def test_search_finds_the_page_first(
    browser: webdriver.Chrome, whole: Path, words: str, page: str
) -> None:
    """The search of the built pages, as a reader uses it."""
    browser.get((whole / "search.html").as_uri() + f"?q={words.replace(' ', '+')}")
    wait_for(browser, "document.querySelector('#search-results li a')")
    first = browser.execute_script("return document.querySelector('#search-results li a').href")
    assert f"/{page}.html" in first
