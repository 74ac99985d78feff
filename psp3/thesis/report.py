"""Write what :mod:`psp3.thesis.replication` found as one HTML file that needs nothing else."""

from __future__ import annotations

import base64
import re
from html import escape
from pathlib import Path

from fuzzy2.support.text_files import write_text
from psp3.thesis.findings import Drawing, Reproduction, Table

STYLE = """
:root { color-scheme: light dark; --text: #1a1a1a; --ground: #ffffff; --line: #d9d9d9; --soft: \
#f4f6f8; --muted: #5c5c5c;
  --link: #0072b2; }
@media (prefers-color-scheme: dark) {
  :root { --text: #ececec; --ground: #14171c; --line: #333942; --soft: #1d2229; --muted: #a0a4ab; \
--link: #56b4e9; } }
* { box-sizing: border-box; }
body { font: 16px/1.5 system-ui, sans-serif; color: var(--text); background: var(--ground);
  max-width: 68rem; margin: 0 auto; padding: 1rem; overflow-wrap: break-word; }
h1 { font-size: 1.5rem; line-height: 1.25; } h2 { font-size: 1.15rem; line-height: 1.3; \
margin-top: 2.4rem; }
.answer { background: var(--soft); border-left: 4px solid var(--link); padding: .6rem 1rem .6rem \
2rem; max-width: 54rem; }
.answer li { margin: .4rem 0; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .88rem; font-variant-numeric: tabular-nums; }
th, td { text-align: left; padding: .35rem .6rem; border-bottom: 1px solid var(--line); \
vertical-align: top; }
th { line-height: 1.3; max-width: 9rem; } td.numbers { white-space: pre; }
th, td { overflow-wrap: normal; } td:last-child { min-width: 7rem; }
@media (max-width: 40rem) { th, td { padding: .3rem .4rem; }
  :is(th, td):first-child { position: sticky; left: 0; background: var(--ground); } }
.note { color: var(--muted); font-size: .9rem; max-width: 54rem; }
figure { margin: 1.5rem 0; } figcaption { color: var(--muted); font-size: .9rem; max-width: 54rem; }
img { width: 100%; min-width: 34rem; height: auto; background: #ffffff; border-radius: 4px; \
display: block; }
nav li { margin: .15rem 0; } nav ul { padding-left: 1.2rem; columns: 2 22rem; font-size: .9rem; }
a { color: var(--link); }
"""

NO_BREAK = "\N{NO-BREAK SPACE}"

_UNBROKEN = re.compile(r"\([^()\s]+ to [^()\s]+\)|[\d.]+ (?:%|dB|m²?|(?:to|of|at) [\d.]+)")
"""Parts of a cell that are read as one."""

TITLE = "3-PSP robot: the thesis's comparison, recomputed"


def _figure(drawing: Drawing) -> str:
    image = base64.b64encode(drawing.path.read_bytes()).decode("ascii")
    return (
        "<figure><div class='wide'><img "
        f"alt='{escape(f'{drawing.caption} {drawing.description}', quote=True)}' "
        f"src='data:image/svg+xml;base64,{image}'></div><figcaption>{escape(drawing.caption)}"
        "</figcaption></figure>"
    )


def _cell(text: str) -> str:
    """Return a cell, whose words wrap, but no number leaves its unit, sign or interval.

    Rows of numbers, which two spaces divide, stay as they are.
    """
    if "  " in text:
        return f"<td class='numbers'>{escape(text)}</td>"
    return f"<td>{escape(_UNBROKEN.sub(lambda found: found[0].replace(' ', NO_BREAK), text))}</td>"


def _table(number: int, table: Table, drawings: dict[str, Drawing]) -> str:
    head = "".join(f"<th scope='col'>{escape(column)}</th>" for column in table.columns)
    body = "".join("<tr>" + "".join(map(_cell, row)) + "</tr>" for row in table.rows)
    figures = "".join(_figure(drawings[name]) for name in table.figures if name in drawings)
    return (
        f"<h2 id='table-{number}'>{escape(table.title)}</h2><div class='wide' tabindex='0' "
        f"role='region' aria-labelledby='table-{number}'><table><thead><tr>{head}</tr></thead>"
        f"<tbody>{body}</tbody></table></div><p class='note'>{escape(table.note)}</p>{figures}"
    )


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
    drawings = {drawing.name: drawing for drawing in outcome.drawings}
    placed = {name for table in outcome.tables for name in table.figures}
    rest = "".join(_figure(drawing) for name, drawing in drawings.items() if name not in placed)
    animation = (
        "<p>The robot in motion, type-1 beside type-2, with desired and actual paths of the tip: "
        "<a href='animation.html'>animation.html</a>, in the same folder.</p>"
        if any(file.name == "animation.html" for file in outcome.files)
        else ""
    )
    answer = "".join(f"<li>{escape(sentence)}</li>" for sentence in outcome.answer)
    contents = "".join(
        f"<li><a href='#table-{number}'>{escape(table.title)}</a></li>"
        for number, table in enumerate(outcome.tables)
    )
    opening, tables = (
        "".join(
            _table(number, table, drawings)
            for number, table in enumerate(outcome.tables)
            if table.opening == first
        )
        for first in (True, False)
    )
    versions = ", ".join(
        f"{name} {number}" for name, number in outcome.numbers.get("versions", {}).items()
    )
    write_text(
        "<!doctype html><html lang='en'><head><meta charset='utf-8'><meta name='viewport' "
        "content='width=device-width, "
        f"initial-scale=1'><title>{escape(TITLE)}</title><style>{STYLE}</style></head><body>"
        f"<main><h1>{escape(TITLE)}</h1>{opening}<ul class='answer'>{answer}</ul>{animation}<nav "
        f"aria-label='Contents'><ul>{contents}<li><a "
        f"href='#figures'>Figures</a></li></ul></nav>{tables}<h2 "
        f"id='figures'>Figures</h2>{rest}<p class='note'>Computed with {escape(versions)}. All "
        "numbers are in results.json, all runs in study.sqlite.</p></main></body></html>\n",
        path,
    )
    return path
