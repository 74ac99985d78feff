"""Sphinx builds the documentation from here.

Run by ``make docs``, or ``sphinx-build -W docs results/docs``. No network is needed.
"""

from __future__ import annotations

import base64
import html
import importlib
import json
import re
import sys
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.addnodes import index, pending_xref
from sphinx.application import Sphinx
from sphinx.ext.autodoc.mock import mock
from sphinx.transforms import SphinxTransform
from sphinx.transforms.post_transforms import SphinxPostTransform
from sphinx.util.nodes import make_refnode

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
sys.path.insert(0, str(HERE))

from reference_pages import pages  # noqa: E402

from psp3.version import __version__  # noqa: E402

project = "psp3 and fuzzy2"
author = "The psp3 developers"
copyright = author
version = release = __version__

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
exclude_patterns = ["_build", "pictures", "play", "**/.ipynb_checkpoints"]

# Notebooks are committed with their outputs and executed by the tests. Widgets need a kernel;
# without one their pictures remain.
nb_execution_mode = "off"
nb_ipywidgets_js: dict[str, dict[str, str]] = {}
myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 3

autodoc_member_order = "bysource"
# Of the extra ``symbolic``, which the documentation does not need.
autodoc_mock_imports = ["casadi"]
# Types are in the docstrings, with shapes and units, which annotations do not have.
autodoc_typehints = "none"
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False
napoleon_preprocess_types = False

html_theme = "furo"
html_title = project
html_static_path = ["_static"]
html_css_files = ["narrow.css"]
html_extra_path = [str(HERE / "play" / "play.html")]
html_math_renderer = "formula"
html_show_copyright = False
html_copy_source = False

API, NOTEBOOKS = HERE / "api", HERE / "notebooks"


def write_reference(app: Sphinx) -> None:
    """Write the pages of the reference before Sphinx looks for pages."""
    API.mkdir(exist_ok=True)
    with mock(autodoc_mock_imports):
        written = pages()
    for stale in {page.stem for page in API.glob("*.rst")} - set(written):
        (API / f"{stale}.rst").unlink()
    for name, text in written.items():
        page = API / f"{name}.rst"
        if not page.exists() or page.read_text(encoding="utf-8") != text:
            page.write_text(text, encoding="utf-8")


def copy_notebooks(app: Sphinx) -> None:
    """Copy the notebooks of the repository to where Sphinx looks for pages."""
    NOTEBOOKS.mkdir(exist_ok=True)
    originals = {
        notebook.name: notebook for notebook in (HERE.parent / "notebooks").glob("*.ipynb")
    }
    for stale in {copy.name for copy in NOTEBOOKS.glob("*.ipynb")} - set(originals):
        (NOTEBOOKS / stale).unlink()
    for name, original in originals.items():
        copy, content = NOTEBOOKS / name, with_pictures_beside(original)
        if not copy.exists() or copy.read_text(encoding="utf-8") != content:
            copy.write_text(content, encoding="utf-8")


def with_pictures_beside(original: Path) -> str:
    """Return a notebook whose attached pictures are files: attachments MyST-NB does not know."""
    notebook = json.loads(original.read_text(encoding="utf-8"))
    for cell in notebook["cells"]:
        for picture, content in cell.pop("attachments", {}).items():
            file = NOTEBOOKS / f"{original.stem}_{picture}"
            data = base64.b64decode(content["image/png"])
            if not file.exists() or file.read_bytes() != data:
                file.write_bytes(data)
            cell["source"] = [
                line.replace(f"attachment:{picture}", file.name) for line in cell["source"]
            ]
    return json.dumps(notebook, ensure_ascii=False, indent=1) + "\n"


SEARCHED = {
    "robot_files": ("URDF", "MJCF", "SDF", "SRDF", "robot files", "mimic"),
    "how_to/any_robot": (
        "closed chains",
        "closed loops",
        "parallel robots",
        "Stewart platform",
        "Gough–Stewart platform",
        "hexapod",
        "Delta robot",
        "five-bar linkage",
    ),
    "how_to/constrained_inverse_dynamics": ("inverse dynamics of closed chains",),
    "how_to/export": ("C code", "code generation", "microcontroller", "C99"),
    "how_to/fmu": ("FMU", "FMI", "Simulink", "co-simulation"),
    "how_to/anfis": ("ANFIS",),
    "how_to/files": ("fis file", "FML", "fuzzy files"),
    "how_to/studies": ("confidence intervals",),
    "how_to/optimal_control": ("CasADi", "trajectory optimization"),
    "how_to/collisions_and_task_space": ("collisions", "task space"),
    "coming_from/matlab": ("MATLAB", "Fuzzy Logic Toolbox"),
    "api/command_line": ("command line", "CLI"),
}
"""Words that people search for, with the page that should come first."""


class WordsOfSearch(SphinxTransform):
    """Put the words of :data:`SEARCHED` into the index of their page, which the search prefers."""

    default_priority = 500

    def apply(self, **kwargs: Any) -> None:
        """Add one index node with all words, which leads to the beginning of the page."""
        words = SEARCHED.get(self.env.docname, ())
        if words:
            target = nodes.target("", "", ids=["searched"])
            entries = [("single", word, "searched", "main", None) for word in words]
            self.document.insert(0, [index(entries=entries, inline=False), target])


MOTIONS = {"controllers": "3-PSP under two controllers", "delta": "Delta"}
"""Recorded motions, see ``docs/play/make_play.py``, and the titles of their pages."""


def write_motions(app: Sphinx, error: Exception | None) -> None:
    """Write a page of each recorded motion, with MeshCat in it, beside the pages of the text."""
    from psp3.visualize.scene import page

    if error is not None or app.builder.format != "html":
        return
    for name, title in MOTIONS.items():
        commands = (HERE / "play" / f"{name}.json").read_text(encoding="utf-8")
        (Path(app.outdir) / f"motion_{name}.html").write_text(page(commands, title), "utf-8")


class BreakableTitles(SphinxPostTransform):
    """Let the titles of the reference, which are names of modules, break after dots.

    On a narrow screen they would break within words.
    """

    default_priority = 900

    def run(self, **kwargs: Any) -> None:
        """Put a place to break after every dot of the first title."""
        title = next(iter(self.document.findall(nodes.title)), None)
        if title is None or not self.env.docname.startswith("api/"):
            return
        for text in list(title.findall(nodes.Text)):
            pieces: list[nodes.Node] = []
            for piece in re.split(r"(?<=[._])", text.astext()):
                pieces += [nodes.Text(piece), nodes.raw("", "<wbr>", format="html")]
            text.parent.replace(text, pieces[:-1])


class LinkNames(SphinxPostTransform):
    """Link names of this library that are set as code to their reference.

    For instance ``psp3.load``.
    """

    default_priority = 5

    def run(self, **kwargs: Any) -> None:
        """Replace every literal that is such a name.

        Where both packages have an error of that name, say which is meant.
        """
        objects = self.env.domains.python_domain.objects
        for reference in list(self.document.findall(pending_xref)):
            module, target = reference.get("py:module") or "", reference.get("reftarget")
            if reference.get("refdomain") != "py":
                continue
            known = [
                f"{module.split('.')[0]}.errors.{target}",
                f"{module}.{target}",
                imported_home(module, target),
            ]
            meant = next((name for name in known if name in objects), None)
            if meant is not None:
                reference["reftarget"], reference["refspecific"] = meant, False
            elif sum(name.endswith(f".{target}") for name in objects) > 1:
                # A word, such as the K of an equation, that is also the name of more than one thing
                # elsewhere.
                reference.replace_self(reference.children)
        for node in list(self.document.findall(nodes.literal)):
            name = node.astext().removesuffix("()")
            if not re.fullmatch(r"(psp3|fuzzy2)(\.\w+)+", name) or isinstance(
                node.parent, nodes.reference | nodes.title
            ):
                continue
            home = name if name in objects else home_of(name)
            if home in objects:
                entry = objects[home]
                node.replace_self(
                    make_refnode(
                        self.app.builder,
                        self.env.docname,
                        entry.docname,
                        entry.node_id,
                        node.deepcopy(),
                        home,
                    )
                )


def imported_home(module: str, name: str) -> str:
    """Return where a class or function that a module imports by its bare name is defined."""
    if not module or not name.isidentifier():
        return ""
    thing = getattr(importlib.import_module(module), name, None)
    return f"{getattr(thing, '__module__', '')}.{name}"


def home_of(name: str) -> str:
    """Return where the object of a re-exported name is defined.

    For instance ``psp3.loading.load`` for ``psp3.load``.
    """
    package, public, *rest = name.split(".")
    thing = (
        getattr(importlib.import_module(package), public, None)
        if public in importlib.import_module(package).__all__
        else None
    )
    module = getattr(thing, "__module__", None)
    return ".".join([module, public, *rest]) if module else name


def formula(translator: Any, node: nodes.Element) -> None:
    """Write an equation as TeX, which KaTeX draws in the browser.

    Its script and fonts are in ``_static/katex``: no network, and no font of the reader's machine.
    An equation of several lines without an environment is aligned at its signs.
    """
    equation, as_block = node.astext().strip(), isinstance(node, nodes.math_block)
    if as_block:
        parts = [part.strip() for part in re.split(r"\n\s*\n", equation)]
        equation = r" \\ ".join(parts)
        if r"\\" in equation and not equation.startswith(r"\begin"):
            equation = rf"\begin{{aligned}} {equation} \end{{aligned}}"
    text = html.escape(equation)
    translator.body.append(
        f'<div class="formula" tabindex="0">{text}</div>'
        if as_block
        else f'<span class="formula">{text}</span>'
    )
    raise nodes.SkipNode


def add_katex(app: Sphinx, page: str, template: str, context: dict[str, Any], tree: Any) -> None:
    """Load KaTeX on pages that have formulas."""
    if 'class="formula"' in context.get("body", ""):
        app.add_css_file("katex/katex.min.css")
        app.add_js_file("katex/katex.min.js")
        app.add_js_file("katex/draw.js")


def setup(app: Sphinx) -> dict[str, bool]:
    """Register what is defined here."""
    app.connect("builder-inited", write_reference)
    app.connect("builder-inited", copy_notebooks)
    app.connect("build-finished", write_motions)
    app.connect("html-page-context", add_katex)
    app.add_transform(WordsOfSearch)
    app.add_post_transform(LinkNames)
    app.add_post_transform(BreakableTitles)
    app.add_html_math_renderer("formula", (formula, None), (formula, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
