"""The command that ranks anybody's learned computed torque."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from psp3.cli.options import RUNS, folder_path
from psp3.cli.output import counted_progress, say, show_narrow, show_text
from psp3.cli.shared import refuse_workers_of_scheduler, resumable


def benchmark(
    entries: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="ENTRY",
            help="Names of entries, your own files (*.py), or all; default all. Exact computed "
            "torque, ctc, always takes part.",
            show_default=False,
        ),
    ] = None,
    out: Annotated[
        Path,
        typer.Option(
            parser=folder_path,
            metavar="DIR",
            help="Directory to write to; it is made if it does not exist.",
        ),
    ] = Path("benchmark"),
    robot: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            rich_help_panel=RUNS,
            help="Robot: psp3, delta or gough_stewart; default all three.",
        ),
    ] = None,
    reading: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            rich_help_panel=RUNS,
            help="Where the noise is, besides runs without noise: outputs (default), variance, "
            "unit, gravity, mass-coriolis, inputs, measurement, or all.",
        ),
    ] = None,
    snr: Annotated[
        list[float] | None,
        typer.Option(
            metavar="DB",
            rich_help_panel=RUNS,
            help="Signal-to-noise ratio (dB); default 20.",
        ),
    ] = None,
    seeds: Annotated[
        int,
        typer.Option(
            min=1, metavar="COUNT", rich_help_panel=RUNS, help="Number of seeds, counted from 0."
        ),
    ] = 10,
    duration: Annotated[
        float, typer.Option(metavar="S", rich_help_panel=RUNS, help="Length of a run (s).")
    ] = 5.0,
    workers: Annotated[
        int | None,
        typer.Option(
            min=1,
            metavar="COUNT",
            help="Number of processes that do the runs; default one per core.",
        ),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS",
            help="Address of a dask scheduler, tcp://HOST:PORT: its workers, with one thread "
            "each, do the runs.",
        ),
    ] = None,
) -> None:
    """Rank learned computed torque on three robots.

    Entries learn M, C and G from noisy samples, and control the robot on the recorded path and on
    another one. Writes DIR/benchmark.html and DIR/benchmark.json and prints the ranking. Runs in
    DIR/benchmark.sqlite are not repeated, so the same command resumes after a stop. Options of runs
    can be given more than once. Files of entries are executed as Python code.
    """
    refuse_workers_of_scheduler(workers, scheduler)
    from psp3.benchmark.benchmark import ALL, NUMBERS, PAGE, Benchmark
    from psp3.benchmark.page import (
        SHORT_COLUMNS,
        board_note,
        short_rows,
        summary,
        write_numbers,
        write_page,
    )
    from psp3.benchmark.readings import READINGS
    from psp3.benchmark.tasks import ROBOTS

    chosen = reading or [next(iter(READINGS))]
    asked = Benchmark(
        out,
        entries or [ALL],
        robot or ROBOTS,
        tuple(READINGS) if ALL in chosen else chosen,
        snr or [20.0],
        seeds,
        duration,
    )
    with resumable(out), counted_progress("trials") as progress:
        asked.run(workers, scheduler, progress)
    board = asked.board()
    show_narrow("The board", list(SHORT_COLUMNS), short_rows(board), board_note(board))
    for sentence in summary(board):
        show_text(f"• {sentence}")
    for path in (write_page(board, out / PAGE), write_numbers(board, out / NUMBERS)):
        say(path)
