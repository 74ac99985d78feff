"""Write what :mod:`psp3.reproduce` found as one HTML file that needs nothing else."""

from __future__ import annotations

import base64
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from psp3.reproduce import Reproduction, Table

STYLE = """
:root { color-scheme: light dark; --text: #1a1a1a; --ground: #ffffff; --line: #d9d9d9; --soft: #f4f6f8; --muted: #5c5c5c; }
@media (prefers-color-scheme: dark) {
  :root { --text: #ececec; --ground: #14171c; --line: #333942; --soft: #1d2229; --muted: #a0a4ab; } }
body { font: 16px/1.5 system-ui, sans-serif; color: var(--text); background: var(--ground);
  max-width: 60rem; margin: 0 auto; padding: 1rem; }
h1 { font-size: 1.5rem; line-height: 1.25; } h2 { font-size: 1.15rem; margin-top: 2.2rem; }
.answer { background: var(--soft); border-left: 4px solid #0072b2; padding: .6rem 1rem; }
.answer li { margin: .3rem 0; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .9rem; font-variant-numeric: tabular-nums; }
th { white-space: normal !important; }
th, td { text-align: left; padding: .35rem .7rem; border-bottom: 1px solid var(--line); white-space: pre; vertical-align: top; }
td:last-child { white-space: normal; min-width: 9rem; } .note { color: var(--muted); font-size: .9rem; max-width: 46rem; }
img { width: 100%; height: auto; background: #ffffff; border-radius: 4px; }
figure { margin: 1rem 0; } figcaption { color: var(--muted); font-size: .9rem; }
a { color: #0072b2; } @media (prefers-color-scheme: dark) { a { color: #56b4e9; } }
"""

CAPTIONS = {
    "figure_52": (
        "Figure 52: PD. Heights and speeds of the three nuts and the path of the tip; solid: actual, dashed: desired. "
        "The heights lag by the sag under gravity, the speeds agree."
    ),
    "figure_53": "Figure 53: CTC. The error of the start from rest dies out within about ten seconds at the thesis's gains.",
}


def _table(table: Table) -> str:
    head = "".join(f"<th scope='col'>{escape(column)}</th>" for column in table.columns)
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in table.rows)
    return (
        f"<h2>{escape(table.title)}</h2><div class='wide'><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>"
        f"<p class='note'>{escape(table.note)}</p>"
    )


def write_report(outcome: Reproduction, path: Path) -> Path:
    """Write the report and return its path.

    Parameters
    ----------
    outcome : Reproduction
        Answer, tables and the paths of the figures, which are embedded.
    path : path
        The HTML file.
    """
    figures = []
    for file in outcome.files:
        if file.suffix == ".svg":
            caption = CAPTIONS[file.stem]
            image = base64.b64encode(file.read_bytes()).decode("ascii")
            figures.append(
                f"<figure><img alt='{escape(caption, quote=True)}' src='data:image/svg+xml;base64,{image}'>"
                f"<figcaption>{escape(caption)}</figcaption></figure>"
            )
    animation = (
        "<p>The robot in motion, PD beside CTC: <a href='animation.html'>animation.html</a>, in the same folder.</p>"
        if any(file.name == "animation.html" for file in outcome.files)
        else ""
    )
    answer = "".join(f"<li>{escape(sentence)}</li>" for sentence in outcome.answer)
    tables = "".join(_table(table) for table in outcome.tables)
    path.write_text(
        "<!doctype html><html lang='en'><head><meta charset='utf-8'><meta name='viewport' content='width=device-width, initial-scale=1'>"
        f"<title>3-PSP robot: the thesis's comparison, recomputed</title><style>{STYLE}</style></head><body>"
        f"<h1>3-PSP robot: the thesis's comparison, recomputed</h1><ul class='answer'>{answer}</ul>{animation}{tables}"
        f"<h2>Figures</h2>{''.join(figures)}</body></html>\n",
        encoding="utf-8",
    )
    return path
