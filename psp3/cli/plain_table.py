"""Tables of texts from files, whose cells are never read as markup or terminal controls."""

from __future__ import annotations

from typing import Any

from rich.table import Table
from rich.text import Text

from fuzzy2.errors import printable


class PlainTable(Table):
    """A rich table whose titles, headings and cells are shown verbatim."""

    def __init__(self, title: str, note: str, **how: Any) -> None:
        super().__init__(title=plain(title), caption=plain(note) if note else None, **how)

    def add_column(self, header: Any = "", *others: Any, **how: Any) -> None:
        """Add a column below a heading."""
        super().add_column(plain(header), *others, **how)

    def add_row(self, *cells: Any, **how: Any) -> None:
        """Add a row of texts."""
        super().add_row(*map(plain, cells), **how)


def plain(text: Any) -> Any:
    """Return a text that rich shows verbatim; other objects are returned unchanged."""
    return Text(printable(text)) if isinstance(text, str) else text
