"""Write what :mod:`psp3.thesis.replication` found as one HTML file that needs nothing else."""

from __future__ import annotations

from html import escape
from pathlib import Path

from fuzzy2.support.text_files import write_text
from psp3.plots.page import drawing, page, table
from psp3.thesis.findings import Drawing, Reproduction, Table

TITLE = "3-PSP robot: the thesis's comparison, recomputed"


def _figure(found: Drawing) -> str:
    return drawing(found.path.read_bytes(), found.caption, found.description)


def _table(number: int, found: Table, drawings: dict[str, Drawing]) -> str:
    figures = "".join(_figure(drawings[name]) for name in found.figures if name in drawings)
    return table(f"table-{number}", found.title, found.columns, found.rows, found.note) + figures


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
    rest = "".join(_figure(found) for name, found in drawings.items() if name not in placed)
    animation = (
        "<p>The robot in motion, type-1 beside type-2, with desired and actual paths of the tip: "
        "<a href='animation.html'>animation.html</a>, in the same folder.</p>"
        if any(file.name == "animation.html" for file in outcome.files)
        else ""
    )
    answer = "".join(f"<li>{escape(sentence)}</li>" for sentence in outcome.answer)
    contents = "".join(
        f"<li><a href='#table-{number}'>{escape(found.title)}</a></li>"
        for number, found in enumerate(outcome.tables)
    )
    opening, tables = (
        "".join(
            _table(number, found, drawings)
            for number, found in enumerate(outcome.tables)
            if found.opening == first
        )
        for first in (True, False)
    )
    versions = ", ".join(
        f"{name} {number}" for name, number in outcome.numbers.get("versions", {}).items()
    )
    body = (
        f"{opening}<ul class='answer'>{answer}</ul>{animation}<nav "
        f"aria-label='Contents'><ul>{contents}<li><a "
        f"href='#figures'>Figures</a></li></ul></nav>{tables}<h2 "
        f"id='figures'>Figures</h2>{rest}<p class='note'>Computed with {escape(versions)}. All "
        "numbers are in results.json, all runs in study.sqlite.</p>"
    )
    write_text(page(TITLE, body), path)
    return path
