"""Sphinx builds the documentation from here.

Run by ``make docs``, or ``sphinx-build -W docs results/docs``. No network is needed.
"""

from __future__ import annotations

import base64
import html
import importlib
import json
import pkgutil
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.transforms.post_transforms import SphinxPostTransform
from sphinx.util import logging
from sphinx.util.nodes import make_refnode

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

import fuzzy2  # noqa: E402
import psp3  # noqa: E402

project = "psp3 and fuzzy2"
author = "The psp3 developers"
copyright = author
version = release = psp3.__version__

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
exclude_patterns = ["_build", "pictures", "**/.ipynb_checkpoints"]

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
html_math_renderer = "mathml"
html_show_copyright = False
html_copy_source = False

PACKAGES = (psp3, fuzzy2)
API, NOTEBOOKS = HERE / "api", HERE / "notebooks"


def modules(package: Any) -> Iterator[str]:
    """Yield the names of a package's public modules."""
    for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
        if not module.name.rpartition(".")[2].startswith("_"):
            yield module.name


def write_api_pages(app: Sphinx) -> None:
    """Write a page for every module, before Sphinx looks for pages."""
    API.mkdir(exist_ok=True)
    pages = {}
    for package in PACKAGES:
        name, names = package.__name__, list(modules(package))
        toctree = "\n".join(f"   {module}" for module in names)
        homes = "\n".join(f"- ``{name}.{public}``" for public in sorted(package.__all__))
        pages[name] = (
            f"{name}\n{'=' * len(name)}\n\n.. automodule:: {name}\n\nImported by name\n"
            f"----------------\n\n{homes}\n\n"
            f"Modules\n-------\n\n.. toctree::\n   :maxdepth: 1\n\n{toctree}\n"
        )
        for module in names:
            pages[module] = (
                f"{module}\n{'=' * len(module)}\n\n.. automodule:: {module}\n   :members:\n"
                "   :show-inheritance:\n"
            )
    for stale in {page.stem for page in API.glob("*.rst")} - set(pages):
        (API / f"{stale}.rst").unlink()
    for name, text in pages.items():
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


# What docutils does not know: sizes and operators, which need no command here, and dots.
UNKNOWN_COMMANDS = (
    (r"\\(?:mathop|[bB]igg?[lr]?)(?![a-zA-Z])", ""),
    (r"\\dots(?![a-zA-Z])", r"\\ldots"),
)


ACCENTS = frozenset("˙¨ˆ˜~^_¯ˇ→")
MATHML = "http://www.w3.org/1998/Math/MathML"


def accents_above(markup: str) -> str:
    """Return MathML in which accents are above their letters and indices beside them.

    Docutils puts the index of an accented letter below it; and an accent that is marked as one is
    drawn into the letter by browsers that find no mathematical font.
    """
    ElementTree.register_namespace("", MATHML)
    root = ElementTree.fromstring(
        re.sub(r"&(?!lt;|gt;|amp;|#)\w+;", lambda entity: html.unescape(entity[0]), markup)
    )
    for element in root.iter():
        parts, kind = list(element), element.tag.removeprefix(f"{{{MATHML}}}")
        if kind not in ("mover", "munderover") or parts[-1].text not in ACCENTS:
            continue
        for marked in (element, parts[-1]):
            marked.attrib.pop("accent", None)
        if kind == "munderover":
            letter, index, accent = parts
            accented = ElementTree.Element(f"{{{MATHML}}}mover")
            accented.extend([letter, accent])
            element.tag = f"{{{MATHML}}}msub"
            element[:] = [accented, index]
    return ElementTree.tostring(root, encoding="unicode")


def mathml(translator: Any, node: nodes.Element, as_block: bool) -> None:
    """Write an equation as MathML, which browsers show by themselves: no script, no network."""
    equation = node.astext()
    for command, substitute in UNKNOWN_COMMANDS:
        equation = re.sub(command, substitute, equation)
    try:
        markup = accents_above("".join(tex2mathml(equation, as_block=as_block)))
    except (MathError, AttributeError) as error:
        # The second is how the library stumbles over a row that ends outside of an array.
        logging.getLogger(__name__).warning(
            "equation cannot be written as MathML: %s", error, location=node
        )
        raise nodes.SkipNode from None
    translator.body.append(
        f'<div class="equation" tabindex="0">{markup}</div>' if as_block else markup
    )
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    """Register what is defined here."""
    app.connect("builder-inited", write_api_pages)
    app.connect("builder-inited", copy_notebooks)
    app.add_post_transform(LinkNames)
    app.add_html_math_renderer(
        "mathml",
        (lambda translator, node: mathml(translator, node, as_block=False), None),
        (lambda translator, node: mathml(translator, node, as_block=True), None),
    )
    return {"parallel_read_safe": True, "parallel_write_safe": True}
