"""Write the findings of :mod:`psp3.thesis.replication` as one self-contained HTML file.

It opens with one sentence, the picture of the machine, the figure of the result and a table of
verdicts. All else is folded under titles that can be opened.
"""

from __future__ import annotations

from pathlib import Path

from fuzzy2.support.markup import Markup, element, joined
from fuzzy2.support.text_files import write_text
from psp3.plots.page import (
    drawing,
    folded,
    lead,
    listed,
    note_below,
    page,
    side_by_side,
    table,
    table_alone,
)
from psp3.thesis.findings import Drawing, Reproduction, Table

TITLE = "3-PSP robot: the thesis's comparison, recomputed"

ANIMATION = "animation.html"
"""The page beside the report."""

OPENING = ("machine", "result")
"""Names of the drawings that the report opens with."""


def _figure(found: Drawing) -> Markup:
    return drawing(found.path.read_bytes(), found.caption, found.description)


def _folded_table(number: int, found: Table, drawings: dict[str, Drawing]) -> Markup:
    anchor = f"table-{number}"
    shown = table_alone(anchor, found.columns, found.rows, found.note)
    figures = (_figure(drawings[name]) for name in found.figures if name in drawings)
    return folded(anchor, found.title, shown, *figures)


def write_report(outcome: Reproduction, path: Path) -> Path:
    """Write the report and return its path.

    Parameters
    ----------
    outcome : Reproduction
        Sentence, answer, tables and drawings; the drawings are embedded.
    path : path
        The HTML file.

    Returns
    -------
    Path
        ``path``.
    """
    drawings = {found.name: found for found in outcome.drawings}
    placed = {*OPENING, *(name for found in outcome.tables for name in found.figures)}
    rest = [_figure(found) for name, found in drawings.items() if name not in placed]
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
    numbered = list(enumerate(outcome.tables))
    opening = (
        table(f"table-{number}", found.title, found.columns, found.rows, found.note)
        for number, found in numbered
        if found.opening
    )
    others = (
        _folded_table(number, found, drawings) for number, found in numbered if not found.opening
    )
    versions = ", ".join(
        f"{name} {number}" for name, number in outcome.numbers.get("versions", {}).items()
    )
    text = page(
        TITLE,
        lead(outcome.sentence),
        side_by_side(*(_figure(drawings[name]) for name in OPENING if name in drawings)),
        joined(opening),
        animation,
        folded("answer", "The results in sentences", listed(outcome.answer, class_="answer")),
        joined(others),
        folded("figures", "Figures 49 to 63, redrawn", *rest) if rest else "",
        note_below(
            f"Computed with {versions}. All numbers are in results.json, all runs in study.sqlite."
        ),
    )
    write_text(text, path)
    return path
