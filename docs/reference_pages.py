"""The pages of the reference, which Sphinx makes of docstrings, and that of the command line.

Public is what ``docs/architecture.md`` says: names of the facades, and the modules in its table.
They are grouped as users think, not as packages are layered.
"""

from __future__ import annotations

import ast
import importlib
import inspect
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent


class Group(NamedTuple):
    """A page of the reference: its title, what it is about, and the packages on it."""

    title: str
    about: str
    packages: tuple[str, ...]


GROUPS = {
    "robots": Group(
        "Robots",
        "Load a robot from a URDF, MJCF or SDF file or by its name, and ask for its kinematics: "
        "closed loops, mobility, workspace, singularities, collisions.",
        (
            "psp3.loading",
            "psp3.robots",
            "psp3.three_psp",
            "psp3.description",
            "psp3.closure",
            "psp3.kinematics",
            "psp3.collisions",
        ),
    ),
    "dynamics": Group(
        "Dynamics",
        "Forward and inverse dynamics of closed chains, their derivatives, linearization, "
        "drives, identification of masses, and symbols for CasADi.",
        ("psp3.dynamics", "psp3.multibody", "psp3.drives", "psp3.identification", "psp3.symbolic"),
    ),
    "control": Group(
        "Control",
        "Controllers with the exact model and with a learned one, and the bounds that they keep.",
        ("psp3.control", "psp3.fuzzy_control", "psp3.bounds"),
    ),
    "simulation": Group(
        "Simulation",
        "Desired motions, the loop of controller and plant, results, and how to see them.",
        ("psp3.trajectories", "psp3.simulation", "psp3.visualize", "psp3.plots"),
    ),
    "study": Group(
        "Study",
        "Many runs with statistics, the benchmark of learned controllers, and the thesis.",
        ("psp3.study", "psp3.benchmark", "psp3.thesis", "psp3.published"),
    ),
    "fuzzy_sets": Group(
        "Fuzzy sets",
        "Sets of type 1, interval type 2 and general type 2, their operations, fuzzy numbers, "
        "and type reduction.",
        ("fuzzy2.sets", "fuzzy2.operations", "fuzzy2.numbers", "fuzzy2.reduction"),
    ),
    "systems": Group(
        "Systems",
        "Fuzzy systems: rules, inference, explanations, and figures.",
        ("fuzzy2.systems", "fuzzy2.plots"),
    ),
    "learning": Group(
        "Learning",
        "Rules from data: ANFIS, Wang–Mendel, clustering, classification, fine tuning.",
        ("fuzzy2.learning",),
    ),
    "files": Group(
        "Files and export",
        "Files of MATLAB, Octave, fuzzylite, IEC and IEEE; C code and FMUs.",
        ("fuzzy2.files", "fuzzy2.export", "psp3.export", "fuzzy2.support"),
    ),
    "errors": Group(
        "Errors",
        "Every error that is raised on purpose.",
        ("psp3.errors", "fuzzy2.errors"),
    ),
}


def facades_and_modules() -> tuple[list[str], set[str]]:
    """Return the facades and the public modules that ``docs/architecture.md`` names."""
    page = (HERE / "architecture.md").read_text(encoding="utf-8")
    said = page.partition("## What is public")[2].partition("\n## ")[0]
    facades = re.findall(r"`((?:psp3|fuzzy2)[.\w]*)`", said.partition("`tests/")[0])
    modules = {
        f"{package}.{name}"
        for package, names in re.findall(r"^\| `([.\w]+)` \| (.*) \|$", said, flags=re.MULTILINE)
        for name in re.findall(r"`(\w+)`", names)
    }
    return facades, modules


def offered(facade: str) -> Iterator[tuple[str, str]]:
    """Yield the names that a facade offers, each with the module that it is from.

    A module that is offered as a whole has the name ``""``.
    """
    file = inspect.getsourcefile(importlib.import_module(facade))
    assert file is not None
    for node in ast.walk(ast.parse(Path(file).read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                if alias.asname != alias.name or alias.name.startswith("_"):
                    continue
                whole = f"{node.module}.{alias.name}"
                is_module = inspect.ismodule(getattr(importlib.import_module(facade), alias.name))
                yield (whole, "") if is_module else (node.module, alias.name)


def documented() -> dict[str, dict[str, str]]:
    """Return what is public: by its module every name, with the name by which it is imported.

    Of modules that are public as a whole the dictionary has the key ``""``, too.
    """
    facades, modules = facades_and_modules()
    found: dict[str, dict[str, str]] = {module: {"": module} for module in sorted(modules)}
    for facade in sorted(facades, key=lambda name: name.count(".")):
        for module, name in offered(facade):
            if name:
                found.setdefault(module, {}).setdefault(name, f"{facade}.{name}")
    return {module: found[module] for module in sorted(found)}


def summary(thing: Any) -> str:
    """Return the first sentences of a docstring, in one line."""
    first = (inspect.getdoc(thing) or "").partition("\n\n")[0]
    return " ".join(first.split())


def heading(text: str, mark: str = "=") -> str:
    """Return a heading of reStructuredText."""
    return f"{text}\n{mark * len(text)}\n\n"


def module_page(module: str, names: Mapping[str, str]) -> str:
    """Return the page of a module: all of it, or the names that are public."""
    members = "" if "" in names else f" {', '.join(sorted(names))}"
    return (
        f"{heading(module)}.. automodule:: {module}\n   :members:{members}\n   :show-inheritance:\n"
    )


def group_page(group: Group, found: Mapping[str, Mapping[str, str]]) -> str:
    """Return the page of a group: what can be imported, in a table, and the pages of modules."""
    modules = [
        module
        for package in group.packages
        for module in found
        if module == package or module.startswith(f"{package}.")
    ]
    rows = []
    for module in modules:
        loaded = importlib.import_module(module)
        for name, public in sorted(found[module].items()):
            if name:
                target, about = f"{module}.{name}", summary(getattr(loaded, name))
                if isinstance(getattr(loaded, name), dict | tuple | float | int | str):
                    about = ""
            else:
                target, about = module, summary(loaded)
            role = "mod" if not name else "obj"
            rows.append(f"   * - :py:{role}:`{public} <{target}>`\n     - {about}\n")
    pages = "\n".join(f"   {module}" for module in modules)
    return (
        f"{heading(group.title)}{group.about}\n\n.. list-table::\n   :widths: 40 60\n\n"
        f"{''.join(rows)}\n.. toctree::\n   :hidden:\n\n{pages}\n"
    )


def plain(text: str) -> str:
    """Return a text with the marks of reStructuredText escaped, and options set as code.

    Elsewhere Sphinx makes one dash of two.
    """
    escaped = re.sub(r"([\\*`|_])", r"\\\1", " ".join(text.split()))
    return re.sub(r"(?<!\S)(--[a-z][a-z-]*)", r"``\1``", escaped)


def command_line_page() -> str:
    """Return the page of the commands, made of what ``--help`` says."""
    import typer

    from psp3.cli.entry import app

    root = typer.main.get_command(app)
    text = (
        f"{heading('Command line')}What ``psp3 COMMAND --help`` says. {plain(root.help or '')} "
        f"{plain(root.epilog or '')}\n\n"
    )
    return text + "".join(_sections(root, "psp3"))


def _sections(command: Any, path: str) -> Iterator[str]:
    for name, sub in command.commands.items():
        whole = f"{path} {name}"
        if hasattr(sub, "commands"):
            yield from _sections(sub, whole)
            continue
        context = type(sub).context_class(sub, info_name=whole)
        pieces = " ".join(sub.collect_usage_pieces(context))
        usage = pieces.replace("[[", "[").replace("]]", "]")
        said = "\n\n".join(plain(part) for part in inspect.cleandoc(sub.help or "").split("\n\n"))
        yield f"{heading(whole, '-')}{said}\n\n.. code-block:: sh\n\n   {whole} {usage}\n\n"
        for parameter in sub.get_params(context):
            record = parameter.get_help_record(context)
            if record is not None and parameter.name != "help":
                yield f"``{record[0]}``\n   {plain(record[1]) or '…'}\n\n"


def pages() -> dict[str, str]:
    """Return every page of the reference by its name, without suffix."""
    found = documented()
    grouped = {name: group_page(group, found) for name, group in GROUPS.items()}
    listed = "".join(grouped.values())
    missing = [module for module in found if f"\n   {module}\n" not in listed]
    if missing:
        raise ValueError(f"these modules are in no group of docs/reference_pages.py: {missing}")
    modules = {module: module_page(module, names) for module, names in found.items()}
    return {**grouped, **modules, "command_line": command_line_page()}
