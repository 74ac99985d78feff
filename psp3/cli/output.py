"""What commands print and write: tables, JSON, CSV files, figures, progress and errors."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from rich.progress import Progress
    from rich.table import Table


def new_table(title: str, *columns: str, note: str = "") -> Table:
    """Return a table with a title and columns."""
    from rich import box
    from rich.table import Table

    table = Table(
        title=title,
        box=box.SIMPLE_HEAD,
        title_justify="left",
        title_style="bold",
        caption=note or None,
        caption_justify="left",
    )
    for number, column in enumerate(columns):
        table.add_column(column, justify="left" if number == 0 else "right", overflow="fold")
    return table


def _narrow_table(headings: list[str], rows: list[list[str]]) -> Table:
    """Return a table that fits 80 columns.

    It breaks headings and sentences between words, and numbers never.
    """
    import textwrap

    from rich import box
    from rich.table import Table
    from rich.text import Text

    def is_number(word: str) -> bool:
        return (
            word.replace("\N{MINUS SIGN}", "-")
            .lstrip("+-")
            .replace(".", "", 1)
            .replace("e-", "")
            .isdigit()
        )

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    cells = [[" ".join(cell.split()) for cell in row] for row in rows]
    for heading, column in zip(headings, zip(*cells, strict=True), strict=True):
        sentences = any(" " in cell and not all(map(is_number, cell.split())) for cell in column)
        longest = max(
            map(
                len,
                (
                    *heading.split(),
                    *(word for cell in column for word in (cell.split() if sentences else [cell])),
                    "",
                ),
            )
        )
        table.add_column(
            Text("\n".join(textwrap.wrap(heading, longest))),
            no_wrap=not sentences,
            min_width=longest,
        )
    for row in cells:
        table.add_row(*map(Text, row))
    return table


def show_narrow(title: str, headings: list[str], rows: list[list[str]], note: str = "") -> None:
    """Print a table that fits 80 columns between its title and a note."""
    from rich.console import Console
    from rich.text import Text

    console = Console(highlight=False)
    console.print(Text(title, style="bold"))
    console.print(_narrow_table(headings, rows))
    if note:
        console.print(Text(note, style="dim"))


def show(*tables: Table) -> None:
    """Print tables."""
    from rich.console import Console

    console = Console(highlight=False)
    for table in tables:
        console.print(table)


def print_json(content: dict[str, Any]) -> None:
    """Print content as JSON; numbers that JSON does not know are null."""
    import json

    from fuzzy2.support.plain_data import plain

    typer.echo(json.dumps(plain(content), allow_nan=False, ensure_ascii=False))


def fixed(values: Any, digits: int = 6) -> list[str]:
    """Numbers as text with a fixed number of digits, without negative zeros."""
    return [
        f"{round(float(value), digits) + 0.0:.{digits}f}" if math.isfinite(value) else "∞"
        for value in values
    ]


def write_csv(path: Path, columns: dict[str, Any]) -> None:
    """Write columns of numbers to a CSV file, or to standard output."""
    import csv

    from fuzzy2.support.text_files import write_text

    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*(values.tolist() for values in columns.values()), strict=True))
    if path == Path("-"):
        typer.echo(text.getvalue(), nl=False)
    else:
        write_text(text.getvalue(), path)


def draw_figure(path: Path, draw: Callable[[], Any]) -> None:
    """Save a figure in the style of this package."""
    from fuzzy2.plots.style import style
    from fuzzy2.support.text_files import written_whole

    with style():
        drawn = draw()[0].get_figure(root=True)
        with written_whole(path, "wb") as file:
            drawn.savefig(file, format=path.suffix[1:])


@contextmanager
def progress_bar(description: str, total: float) -> Iterator[Callable[[float], None]]:
    """Show a progress bar on standard error, if that is a terminal."""
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        Progress,
        TaskProgressColumn,
        TextColumn,
        TimeRemainingColumn,
    )

    console = Console(stderr=True)
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TimeRemainingColumn(),
    )
    with Progress(
        *columns, console=console, transient=True, disable=not console.is_terminal
    ) as bar:
        task = bar.add_task(description, total=total)
        yield lambda done: bar.update(task, completed=done)


@contextmanager
def counted_progress() -> Iterator[tuple[Progress, bool]]:
    """Show bars of things done, of how many, on standard error.

    Also say whether that is a terminal; if not, no bar is drawn.
    """
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeRemainingColumn,
    )

    console = Console(stderr=True, highlight=False)
    columns = (
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.description}"),
        TimeRemainingColumn(),
    )
    with Progress(
        *columns, console=console, transient=True, disable=not console.is_terminal
    ) as bars:
        yield bars, console.is_terminal


def cell_text(value: Any) -> str:
    """Return a number as it stands in a table."""
    if not isinstance(value, float):
        return str(value)
    return "∞" if value == math.inf else "–" if math.isnan(value) else f"{value:.3g}"


def error_message(error: Exception) -> str | None:
    """Return what a person needs to read of an error, in one line.

    None if it is none that a person made.
    """
    if hasattr(error, "format_message"):
        context = getattr(error, "ctx", None)
        command = "psp3" if context is None else context.command_path
        # The prefixes are typer's: what we say ourselves names its options, and the values that it
        # refuses speak for themselves.
        text = (
            error.format_message()
            .removeprefix("Invalid value: ")
            .replace("Value error, ", "")
            .rstrip(".")
        )
        return f"{command}: {' '.join(text.split())} (see {command} --help)"
    if isinstance(error, MemoryError):
        return "psp3: this takes more memory than there is; ask for less time or fewer samples"
    from fuzzy2.errors import RaisedOnPurpose

    if isinstance(error, RaisedOnPurpose):
        return f"psp3: {' '.join(str(error).split())}"
    if isinstance(error, OSError):
        reason = error.strerror or str(error)
        return (
            f"psp3: {error.filename}: {reason}" if error.filename is not None else f"psp3: {reason}"
        )
    return None
