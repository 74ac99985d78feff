"""Self-contained HTML pages: style, tables and drawings."""

from __future__ import annotations

import base64
import re
from collections.abc import Iterable, Sequence

from fuzzy2.support.markup import Markup, element, joined

STYLE = """
:root { color-scheme: light dark; --text: #1a1a1a; --ground: #ffffff; --line: #d9d9d9; --soft: \
#f4f6f8; --muted: #5c5c5c;
  --link: #0072b2; }
@media (prefers-color-scheme: dark) {
  :root { --text: #ececec; --ground: #14171c; --line: #333942; --soft: #1d2229; --muted: #a0a4ab; \
--link: #56b4e9; } }
* { box-sizing: border-box; }
body { font: 16px/1.5 system-ui, sans-serif; color: var(--text); background: var(--ground);
  max-width: 86rem; margin: 0 auto; padding: 1rem; overflow-wrap: break-word; }
h1 { font-size: 1.5rem; line-height: 1.25; } h2 { font-size: 1.15rem; line-height: 1.3; \
margin-top: 2.4rem; }
.lead { font-size: 1.15rem; } .lead, .answer, .note, figcaption { max-width: 54rem; }
.answer { background: var(--soft); border-left: 4px solid var(--link); padding: .6rem 1rem .6rem \
2rem; }
.answer li { margin: .4rem 0; }
.beside { display: grid; gap: 0 2rem; grid-template-columns: \
repeat(auto-fit, minmax(min(22rem, 100%), 1fr)); max-width: 68rem; }
details { border-top: 1px solid var(--line); } details h2 { display: inline; margin: 0; }
summary { padding: .6rem 0; cursor: pointer; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .88rem; font-variant-numeric: tabular-nums; }
th, td { text-align: left; padding: .35rem .6rem; border-bottom: 1px solid var(--line); \
vertical-align: top; }
th { line-height: 1.3; max-width: 9rem; } td.numbers { white-space: pre; }
th, td { overflow-wrap: normal; } td.long { overflow-wrap: anywhere; } \
td:last-child { min-width: 7rem; }
.note, figcaption { color: var(--muted); font-size: .9rem; }
figure { margin: 1.5rem 0; }
img { max-width: 100%; height: auto; background: #ffffff; border-radius: 4px; display: block; }
nav li { margin: .15rem 0; } nav ul { padding-left: 1.2rem; columns: 2 22rem; font-size: .9rem; }
a { color: var(--link); }
"""

_STACKED = """@media (max-width: WIDTH) {
  TABLE, TABLE :is(tbody, tr) { display: block; }
  TABLE thead { display: none; }
  TABLE tr { border-bottom: 1px solid var(--line); padding: .5rem 0; }
  TABLE td { display: grid; grid-template-columns: minmax(0, 9rem) minmax(0, 1fr); gap: .8rem; \
border: 0; padding: .15rem 0; min-width: 0; overflow-wrap: anywhere; }
  TABLE td::before { content: attr(data-heading); color: var(--muted); }
  TABLE td:first-child { font-weight: 600; } TABLE td::before { font-weight: 400; }
  TABLE td[data-heading=""] { grid-template-columns: 1fr; }
  TABLE td[data-heading=""]::before { display: none; }
  TABLE td.numbers { white-space: pre-wrap; } }
"""
"""Style of a table in a narrow window: each row is a list of headings and cells, so no column is
hidden."""

MANY, CROWD = 6, 9
"""Greatest number of columns of a table that fits into a small window, and of one whose intervals
fit into any window.
"""

LONGEST_WORD = 24
"""Greatest length of a word in a cell that is not broken."""

for _table, _width in ((".wide.many table", "80rem"), (".wide table", "48rem")):
    STYLE += _STACKED.replace("TABLE", _table).replace("WIDTH", _width)

POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"
"""Content security policy of a page: no script runs in it, and it loads nothing."""

NO_BREAK = "\N{NO-BREAK SPACE}"

_UNBROKEN = re.compile(r"\([^()\s]+ to [^()\s]+\)|[\d.]+ (?:%|dB|m²?|(?:to|of|at) [\d.]+)")
"""Parts of a cell that must not be broken."""


def page(title: str, *content: str) -> Markup:
    """Return a page with a title and content below it."""
    head = element(
        "head",
        element("meta", charset="utf-8"),
        element("meta", http_equiv="Content-Security-Policy", content=POLICY),
        element("meta", name="viewport", content="width=device-width, initial-scale=1"),
        element("title", title),
        element("style", Markup(STYLE)),
    )
    body = element("body", element("main", element("h1", title), *content))
    return joined([Markup("<!doctype html>"), element("html", head, body, lang="en"), "\n"])


def drawing(svg: bytes, caption: str, description: str) -> Markup:
    """Return a drawing with its caption and alternative text."""
    image = base64.b64encode(svg).decode("ascii")
    shown = element("img", alt=f"{caption} {description}", src=f"data:image/svg+xml;base64,{image}")
    return element("figure", shown, element("figcaption", caption))


def lead(text: str) -> Markup:
    """Return the opening sentence of a page."""
    return element("p", text, class_="lead")


def side_by_side(*content: str) -> Markup:
    """Return parts of a page side by side, or one below the other in a narrow window."""
    return element("div", *content, class_="beside")


def folded(anchor: str, title: str, *content: str) -> Markup:
    """Return a folded part of a page, which shows only its title until it is opened."""
    summary = element("summary", element("h2", title, id=anchor))
    return element("details", summary, *content)


def table(
    anchor: str, title: str, columns: Sequence[str], rows: Iterable[Sequence[str]], note: str
) -> Markup:
    """Return a table with its heading, the target of ``anchor``, above and its note below."""
    return joined([element("h2", title, id=anchor), table_alone(anchor, columns, rows, note)])


def table_alone(
    anchor: str, columns: Sequence[str], rows: Iterable[Sequence[str]], note: str
) -> Markup:
    """Return a table with its note below; its heading has the id ``anchor``.

    Each cell holds the heading of its column, which is shown beside it in a narrow window.
    """
    is_crowded = len(columns) > CROWD
    head = element("tr", *(element("th", column, scope="col") for column in columns))
    body = (
        element("tr", *(_cell(*cell, is_crowded) for cell in zip(row, columns, strict=True)))
        for row in rows
    )
    cells = element("table", element("thead", head), element("tbody", *body))
    kind = "wide many" if len(columns) > MANY else "wide"
    box = element("div", cells, class_=kind, tabindex="0", role="region", aria_labelledby=anchor)
    return joined([box, note_below(note)])


def listed(texts: Iterable[str], **attributes: str) -> Markup:
    """Return texts and markup as a list."""
    return element("ul", *(element("li", text) for text in texts), **attributes)


def contents(links: Iterable[tuple[str, str]]) -> Markup:
    """Return links to anchors of the page, each with its text."""
    found = (element("a", text, href=f"#{anchor}") for anchor, text in links)
    return element("nav", listed(found), aria_label="Contents")


def note_below(text: str) -> Markup:
    """Return a note."""
    return element("p", text, class_="note")


def _cell(text: str, heading: str, is_crowded: bool) -> Markup:
    """Return a cell that wraps between words, but keeps numbers with unit, sign and interval.

    In a table with many columns intervals wrap, too. Rows of numbers that are separated by two
    spaces never wrap.
    """
    if "  " in text:
        return element("td", text, class_="numbers", data_heading=heading)
    if not is_crowded:
        text = _UNBROKEN.sub(lambda found: found[0].replace(" ", NO_BREAK), text)
    if max(map(len, text.split()), default=0) > LONGEST_WORD:
        return element("td", text, class_="long", data_heading=heading)
    return element("td", text, data_heading=heading)
