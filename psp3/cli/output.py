"""Output of commands: tables, JSON, CSV files, figures, progress and errors."""

from __future__ import annotations

import io
import math
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from rich.progress import Progress
    from rich.table import Table


KEYS = 2
"""Number of columns that identify a row; they are repeated when a table is divided."""


def printable_text(text: str) -> str:
    """Return a text without control characters that a terminal would obey."""
    from fuzzy2.errors import printable

    return printable(text)


def new_table(title: str, *columns: str, note: str = "") -> Table:
    """Return a table with a title and columns."""
    from rich import box

    from psp3.cli.plain_table import PlainTable

    table = PlainTable(
        title,
        note,
        box=box.SIMPLE_HEAD,
        title_justify="left",
        title_style="bold",
        caption_justify="left",
    )
    for number, column in enumerate(columns):
        table.add_column(column, justify="left" if number == 0 else "right", overflow="fold")
    return table


def _is_number(word: str) -> bool:
    return (
        word.replace("\N{MINUS SIGN}", "-")
        .lstrip("+-")
        .replace(".", "", 1)
        .replace("e-", "")
        .isdigit()
    )


def _is_text(column: Sequence[str]) -> bool:
    """Return whether a column holds sentences, which may wrap, instead of numbers."""
    return any(" " in cell and not all(map(_is_number, cell.split())) for cell in column)


def _least_width(heading: str, column: Sequence[str]) -> int:
    """Return the length of a column's longest piece that must not be broken."""
    pieces = [word for cell in column for word in cell.split()] if _is_text(column) else column
    return max(map(len, (*heading.split(), *pieces)), default=0)


def _room_of(widths: Sequence[int]) -> int:
    """Return the width of a table: three spaces between two columns, and one at each end."""
    return sum(width + 3 for width in widths) - 1


def _widened(least: Sequence[int], columns: Sequence[Sequence[str]], room: int) -> list[int]:
    """Return widths of columns that fit; the room that is left goes to the longest sentences."""
    widths = list(least)
    longest = [max(map(len, column), default=0) if _is_text(column) else 0 for column in columns]
    for _ in range(room - _room_of(widths)):
        number = max(range(len(widths)), key=lambda k: longest[k] / max(widths[k], 1))
        if longest[number] > widths[number]:
            widths[number] += 1
    return widths


def _parts(widths: Sequence[int], room: int) -> list[list[int]]:
    """Divide columns into parts that fit, each with the first two columns."""
    parts: list[list[int]] = [[]]
    for number in range(len(widths)):
        wanted = [*parts[-1], number]
        if _room_of([widths[k] for k in wanted]) > room and len(parts[-1]) > KEYS:
            parts.append([*range(KEYS), number])
        else:
            parts[-1] = wanted
    return parts


def _narrow_table(headings: Sequence[str], columns: Sequence[Sequence[str]], room: int) -> Table:
    """Return a table that wraps headings and sentences between words, but never numbers."""
    import textwrap

    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    least = [_least_width(*both) for both in zip(headings, columns, strict=True)]
    for heading, narrowest, width in zip(
        headings, least, _widened(least, columns, room), strict=True
    ):
        # Fixed widths, because rich may choose widths smaller than the longest word.
        table.add_column(Text("\n".join(textwrap.wrap(heading, narrowest))), width=width)
    for row in zip(*columns, strict=True):
        table.add_row(*map(Text, row))
    return table


def show_narrow(title: str, headings: list[str], rows: list[list[str]], note: str = "") -> None:
    """Print a table between its title and a note.

    Columns that do not fit into the terminal, or 80 characters, follow below, with the first two
    columns repeated.
    """
    from rich.console import Console
    from rich.text import Text

    console = Console(highlight=False)
    console.print(Text(printable_text(title), style="bold"))
    headings = [printable_text(heading) for heading in headings]
    columns = list(
        zip(
            *([" ".join(printable_text(cell).split()) for cell in row] for row in rows), strict=True
        )
    )
    widths = [_least_width(*both) for both in zip(headings, columns, strict=True)]
    for part in _parts(widths, console.width):
        some = [headings[k] for k in part], [columns[k] for k in part]
        console.print(_narrow_table(*some, console.width))
    if note:
        console.print(Text(printable_text(note), style="dim"))


def show(*tables: Table) -> None:
    """Print tables."""
    from rich.console import Console

    console = Console(highlight=False)
    for table in tables:
        console.print(table)


def show_text(text: str) -> None:
    """Print a sentence, wrapped between words."""
    from rich.console import Console
    from rich.text import Text

    Console(highlight=False).print(Text(printable_text(text)))


def say(text: object = "", err: bool = False) -> None:
    """Print a line without control characters."""
    typer.echo(printable_text(str(text)), err=err)


def print_json(content: dict[str, Any]) -> None:
    """Print content as JSON; infinity and NaN become null.

    Letters stay readable; other special characters are escaped.
    """
    import json

    from fuzzy2.support.plain_data import plain

    text = json.dumps(plain(content), allow_nan=False, ensure_ascii=False)
    if printable_text(text) != text:
        text = "".join(c if printable_text(c) == c else json.dumps(c)[1:-1] for c in text)
    typer.echo(text)


ROUNDING = 1e-12
"""Numbers up to this share of their scale are rounding errors, and shown as 0."""


def plain_number(value: float, digits: int = 6, scale: float = 1.0) -> str:
    """Return a number as text, with 0 for a rounding error and never -0.

    Parameters
    ----------
    value : float
        The number.
    digits : int
        Significant digits.
    scale : float
        Scale of the number, which decides what is a rounding error.
    """
    return f"{0.0 if abs(value) <= ROUNDING * scale else value:.{digits}g}"


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
        # A program that reads the output gets the exact names; a terminal gets printable ones.
        shown = printable_text(text.getvalue()) if sys.stdout.isatty() else text.getvalue()
        sys.stdout.write(shown)
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
        TextColumn("{task.description}", markup=False),
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
def progress_bars() -> Iterator[tuple[Progress, bool]]:
    """Show progress bars with counts on standard error.

    Also yield whether standard error is a terminal; if not, no bar is drawn.
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
        TextColumn("{task.description}", markup=False),
        TimeRemainingColumn(),
    )
    with Progress(
        *columns, console=console, transient=True, disable=not console.is_terminal
    ) as bars:
        yield bars, console.is_terminal


@contextmanager
def counted_progress(what: str) -> Iterator[Callable[[int, int, float], None]]:
    """Show the number of finished items, their rate and the remaining time on standard error.

    On a terminal this is a bar, otherwise a line after every tenth. The yielded function takes the
    number of finished items, the number of all items, and the rate [1/s].
    """
    tenths = -1
    with progress_bars() as (bars, on_terminal):
        task = None

        def progress(done: int, total: int, rate: float) -> None:
            nonlocal task, tenths
            text = f"{rate:.1f} {what}/s" if rate else ""
            if task is None:
                # Started only now, so the work of an earlier session does not count towards the
                # rate.
                task = bars.add_task(text, total=total, completed=done)
            bars.update(task, completed=done, description=text)
            if not on_terminal and 10 * done // total > tenths:
                tenths = 10 * done // total
                remaining = f", {(total - done) / rate:.0f} s left" if rate and done < total else ""
                say(f"[{done}/{total}] {text}{remaining}".rstrip(), err=True)

        yield progress


def cell_text(value: Any) -> str:
    """Return a number as tables show it, and a dash for None."""
    if value is None:
        return "–"
    if not isinstance(value, float):
        return str(value)
    return "∞" if value == math.inf else "–" if math.isnan(value) else f"{value:.3g}"


OPTIONS = {
    "actuated=[...]": "--actuated NAME,NAME",
    "amplitude=...": "--amplitude A",
    'free="keep"': "--free keep",
    'free="lock"': "--free lock",
    'free="refuse"': "--free refuse",
    'learner="strict"': "--learner strict",
    "n_terms": "--terms",
    "snr_db": "--snr",
    "psp3.load('my_robot.urdf')": "my_robot.urdf",
    "robot.dynamics('noc')": "--model noc",
    "robot.dynamics('pinocchio')": "--model pinocchio",
}
"""Names of remedies in Python, and on the command line."""


REMEDIES = {
    "no such file": "correct its name, or give its folder, too",
    " is a file": "name a directory",
    " is a directory": "name a file",
}
"""Advice for messages with certain endings."""


def _commands_of(context: Any) -> str:
    """Return the names of the commands of a group."""
    return " or ".join(getattr(getattr(context, "command", None), "commands", ()))


def as_options(text: str) -> str:
    """Return a message of the library with its remedies in terms of the command line."""
    for argument, option in OPTIONS.items():
        text = text.replace(argument, option)
    return _with_remedy(_with_option(text))


def _with_option(text: str) -> str:
    """Return a message that begins with the option instead of the parameter's name."""
    name, must, rest = text.partition(" must be ")
    option = "--" + name.replace("_", "-").replace(" ", "-")
    # An option and its value may be two words, or one: --name=value.
    given = {word.partition("=")[0] for word in sys.argv}
    return f"{option}{must}{rest}" if option in given else text


def _with_remedy(text: str) -> str:
    """Return a message with advice added if it has none."""
    for ending, remedy in REMEDIES.items():
        if text.endswith(ending):
            return f"{text}: {remedy}"
    return text


def _refused_by_library(error: Exception) -> str:
    """Return the value that typer's own parser refused without repeating it, if any."""
    details = getattr(error.__cause__, "errors", None)
    if details is None:
        return ""
    # A ``value_error`` comes from our own parsers, whose messages already name the value.
    values = [one["input"] for one in details() if one["type"] != "value_error"]
    return f", got {values[0]!r}" if values else ""


def error_message(error: Exception) -> str | None:
    """Return a short one-line message of an error for a person.

    It is None if the error is not a user's mistake.
    """
    from fuzzy2.support.bounded_files import shortened

    text = _words_of(error)
    return None if text is None else " ".join(shortened(text).split())


def _words_of(error: Exception) -> str | None:
    if hasattr(error, "format_message"):
        context = getattr(error, "ctx", None)
        command = "psp3" if context is None else context.command_path
        # Typer's prefixes are removed: our own messages name their options, and the refused values
        # are clear without them.
        text = (
            error.format_message()
            .removeprefix("Invalid value: ")
            .replace("Value error, ", "")
            .replace("Missing command", f"give a command: {_commands_of(context)}")
            .rstrip(".")
        )
        text = _with_remedy(f"{' '.join(text.split())}{_refused_by_library(error)}")
        return f"{command}: {text} (see {command} --help)"
    if isinstance(error, MemoryError):
        return "psp3: there is not enough memory for this; choose a shorter time or fewer samples"
    from fuzzy2.errors import RaisedOnPurpose

    if isinstance(error, RaisedOnPurpose):
        return f"psp3: {as_options(str(error))}"
    if isinstance(error, OSError):
        missing = isinstance(error, FileNotFoundError)
        reason = "no such file" if missing else error.strerror or str(error)
        named = reason if error.filename is None else f"{error.filename}: {reason}"
        return f"psp3: {_with_remedy(named)}"
    return None
