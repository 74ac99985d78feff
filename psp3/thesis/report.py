"""Write what :mod:`psp3.thesis.replication` found as one HTML file that needs nothing else."""

from __future__ import annotations

from pathlib import Path

from fuzzy2.support.markup import Markup, element, joined
from fuzzy2.support.text_files import write_text
from psp3.plots.page import contents, drawing, listed, note_below, page, table
from psp3.thesis.findings import Drawing, Reproduction, Table

TITLE = "3-PSP robot: the thesis's comparison, recomputed"

ANIMATION = "animation.html"
"""The page beside the report."""


def _figure(found: Drawing) -> Markup:
    return drawing(found.path.read_bytes(), found.caption, found.description)


def _table(number: int, found: Table, drawings: dict[str, Drawing]) -> Markup:
    shown = table(f"table-{number}", found.title, found.columns, found.rows, found.note)
    figures = (_figure(drawings[name]) for name in found.figures if name in drawings)
    return joined([shown, *figures])


def write_report(outcome: Reproduction, path: Path) -> Path:
    """Write the report and return its path.

    Parameters
    ----------
    outcome : Reproduction
        Answer, tables and drawings; these are embedded.
    path : path
        The HTML file.

    Returns
    -------
    Path
        ``path``.
    """
    drawings = {found.name: found for found in outcome.drawings}
    placed = {name for found in outcome.tables for name in found.figures}
    rest = (_figure(found) for name, found in drawings.items() if name not in placed)
    animation = (
        element(
            "p",
            "The robot in motion, type-1 beside type-2, with desired and actual paths of the tip: ",
            element("a", ANIMATION, href=ANIMATION),
            ", in the same folder.",
        )
        if any(file.name == ANIMATION for file in outcome.files)
        else ""
    )
    links = [(f"table-{number}", found.title) for number, found in enumerate(outcome.tables)]
    opening, tables = (
        joined(
            _table(number, found, drawings)
            for number, found in enumerate(outcome.tables)
            if found.opening == first
        )
        for first in (True, False)
    )
    versions = ", ".join(
        f"{name} {number}" for name, number in outcome.numbers.get("versions", {}).items()
    )
    text = page(
        TITLE,
        opening,
        listed(outcome.answer, class_="answer"),
        animation,
        contents([*links, ("figures", "Figures")]),
        tables,
        element("h2", "Figures", id="figures"),
        *rest,
        note_below(
            f"Computed with {versions}. All numbers are in results.json, all runs in study.sqlite."
        ),
    )
    write_text(text, path)
    return path
