"""The main job: the thesis's comparison."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from psp3.cli.options import folder_path
from psp3.cli.output import progress_bars, say, show_narrow
from psp3.cli.shared import resumable


def reproduce(
    out: Annotated[
        Path,
        typer.Option(
            parser=folder_path,
            metavar="DIR",
            help="Directory to write to; it is made if it does not exist.",
        ),
    ] = Path("results"),
    seeds: Annotated[
        int,
        typer.Option(
            min=1,
            metavar="COUNT",
            help="Number of seeds of Table 6.3; other comparisons take 10 at most.",
        ),
    ] = 30,
    quick: Annotated[
        bool,
        typer.Option(
            "--quick", help="A quick look in seconds: two seeds, no animation.", show_default=False
        ),
    ] = False,
) -> None:
    """Run the main job: the thesis's results, recomputed.

    Every number is shown beside the printed one. Writes a report, figures, an animation and all
    numbers, and prints the main tables. Runs in DIR/study.sqlite are not repeated, so the same
    command resumes after a stop.
    """
    from rich.console import Console
    from rich.text import Text

    from psp3.thesis.replication import reproduce as run

    with resumable(out), _reproduce_progress() as (progress, run_progress):
        outcome = run(out, quick=quick, progress=progress, seeds=seeds, run_progress=run_progress)
    console = Console(highlight=False)
    for content in outcome.tables:
        if not content.detail:
            show_narrow(content.title, content.columns, content.rows, content.note)
            console.print()
    for sentence in outcome.answer:
        console.print(Text(f"• {sentence}"))
    hidden = sum(content.detail for content in outcome.tables)
    console.print(
        Text(f"• {hidden} more tables and {len(outcome.drawings)} figures are in the report.")
    )
    console.print()
    for path in outcome.files:
        # Printed without rich, which would wrap long paths.
        say(path if path.is_relative_to(out) else out / path.name)


@contextmanager
def _reproduce_progress() -> Iterator[
    tuple[Callable[[str, int, int], None], Callable[[int, int, float], None]]
]:
    """Show the steps of the main job and the runs of its study on standard error.

    In a log file each step is a line.
    """
    with progress_bars() as (bars, on_terminal):
        task, runs = bars.add_task("", total=None), bars.add_task("runs", total=None, visible=False)

        def progress(description: str, done: int, total: int) -> None:
            bars.update(task, description=description, completed=done, total=total)
            if not on_terminal and done < total:
                say(f"[{done + 1}/{total}] {description}", err=True)

        def run_progress(done: int, total: int, rate: float) -> None:
            bars.update(
                runs,
                description=f"runs, {rate:.0f} a second",
                completed=done,
                total=total,
                visible=done < total,
            )

        yield progress, run_progress
