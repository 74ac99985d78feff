"""Pages of HTML that need nothing else: their style, tables and drawings."""

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

POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"
"""What a page may do: be looked at. No script runs in it, and it loads nothing."""

NO_BREAK = "\N{NO-BREAK SPACE}"

_UNBROKEN = re.compile(r"\([^()\s]+ to [^()\s]+\)|[\d.]+ (?:%|dB|m²?|(?:to|of|at) [\d.]+)")
"""Parts of a cell that are read as one."""


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
    """Return a drawing with its caption, and with words for those who cannot see it."""
    image = base64.b64encode(svg).decode("ascii")
    shown = element("img", alt=f"{caption} {description}", src=f"data:image/svg+xml;base64,{image}")
    return element("figure", element("div", shown, class_="wide"), element("figcaption", caption))


def table(
    anchor: str, title: str, columns: Sequence[str], rows: Iterable[Sequence[str]], note: str
) -> Markup:
    """Return a table below its heading, to which ``anchor`` leads, and above its note."""
    head = element("tr", *(element("th", column, scope="col") for column in columns))
    body = (element("tr", *map(_cell, row)) for row in rows)
    cells = element("table", element("thead", head), element("tbody", *body))
    return joined(
        [
            element("h2", title, id=anchor),
            element(
                "div", cells, class_="wide", tabindex="0", role="region", aria_labelledby=anchor
            ),
            note_below(note),
        ]
    )


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


def _cell(text: str) -> Markup:
    """Return a cell, whose words wrap, but no number leaves its unit, sign or interval.

    Rows of numbers, which two spaces divide, stay as they are.
    """
    if "  " in text:
        return element("td", text, class_="numbers")
    return element("td", _UNBROKEN.sub(lambda found: found[0].replace(" ", NO_BREAK), text))
