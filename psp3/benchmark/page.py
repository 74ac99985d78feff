"""The board as one self-contained HTML page, and as numbers."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path

from fuzzy2.plots.style import style
from fuzzy2.support.text_files import write_text
from psp3.benchmark.baselines import REFERENCE
from psp3.benchmark.board import Board, Cell, Score
from psp3.benchmark.entries import SAMPLES as SAMPLES_ONLY
from psp3.benchmark.pictures import as_svg, condition, figure_of_cells, figure_of_times
from psp3.benchmark.readings import NONE, READINGS
from psp3.benchmark.tasks import PATHS, ROBOTS, SAMPLES
from psp3.checks import checked_kind, checked_path
from psp3.plots.page import contents, drawing, listed, note_below, page, table
from psp3.study.statistics import Estimate

TITLE = "Learned computed torque for parallel robots: the board"

COLUMNS = (
    "place",
    "entry",
    "knows",
    "error of the tip [mm]",
    "times the best",
    f"times {REFERENCE}",
    "diverged",
    "step [µs]",
    "training [s]",
    f"effort / {REFERENCE}",
)
"""Columns of the board."""

SHORT_COLUMNS = ("place", "entry", "knows", "mm", "times best", "lost", "µs", "training")
"""Columns of the short board, for little room: error, ratio, diverged, step and training."""


def write_numbers(board: Board, path: str | Path) -> Path:
    """Write the board as JSON and return the path; see :meth:`Board.as_numbers`."""
    checked_kind("board", board, Board, "a board, as Benchmark(...).board() returns it")
    target = checked_path("path", path)
    # In ASCII, because names of files may hold bytes that are not characters.
    text = json.dumps(board.as_numbers(), allow_nan=False, indent=1)
    write_text(text + "\n", target)
    return target


def write_page(board: Board, path: str | Path) -> Path:
    """Write the board as an HTML page and return the path.

    Every name and message is escaped, because entries are files of strangers.
    """
    checked_kind("board", board, Board, "a board, as Benchmark(...).board() returns it")
    target = checked_path("path", path)
    tables = [table("board", "The board", COLUMNS, board_rows(board), board_note(board))]
    if board.ranked:
        with style("light"):
            errors, times = as_svg(figure_of_cells(board)), as_svg(figure_of_times(board))
        tables += [
            drawing(
                errors,
                "Errors in every cell with 95 % intervals, entries in the order of the board; "
                "hollow on the path that was not recorded.",
                "For each robot a panel with a line for each entry.",
            ),
            drawing(
                times,
                "Error over all cells against the time of a step, called from Python.",
                "A point for each entry; better is lower and further left.",
            ),
        ]
    tables += [
        table(
            f"robot-{robot}",
            f"{robot}: error of the tip [mm]",
            ("entry", *(heading(cell) for cell in _cells(board, robot))),
            [
                [score.entry.name, *(_in_cell(score, cell) for cell in _cells(board, robot))]
                for score in board.scores
            ],
            "In brackets 95 % intervals over the seeds, and the share of runs that diverged. A "
            "run that diverged counts as the extent of its path: "
            + "; ".join(
                f"{1e3 * board.extent(cell):.0f} mm on the {cell.path} one"
                for cell in _cells(board, robot)[: len(PATHS)]
            )
            + ".",
        )
        for robot in board.robots
    ]
    links = [("board", "The board"), *((f"robot-{robot}", robot) for robot in board.robots)]
    numbers = board.as_numbers()
    made = (
        f"Computed with psp3 {numbers['versions']['psp3']}, Python "
        f"{numbers['versions']['python']} on {numbers['machine']['system']}. All numbers are in "
        "benchmark.json."
    )
    answer = listed(summary(board), class_="answer")
    write_text(page(TITLE, answer, contents(links), *tables, note_below(made)), target)
    return target


def summary(board: Board) -> list[str]:
    """Return the results in sentences."""
    said = []
    if board.ranked:
        said.append(_who_is_first(board, board.ranked, "of all"))
    learned = [score for score in board.ranked if score.entry.knows == SAMPLES_ONLY]
    if learned and len(learned) < len(board.ranked):
        said.append(_who_is_first(board, learned, "among those that know only the samples"))
    conditions = "; ".join(
        f"{READINGS[reading].title}, {snr_db:g} dB"
        for reading, snr_db in board.conditions
        if reading != NONE
    )
    robots, seeds = ", ".join(board.robots), "seed" if board.seeds == 1 else "seeds"
    said.append(
        f"{len(board.robots)} of {len(ROBOTS)} robots ({robots}), a trained and an untrained path "
        f"each, without noise and with noise {conditions or '(none)'}; {board.seeds} {seeds}, "
        f"runs of {board.duration:g} s, control period {1e3 * board.period:g} ms, {SAMPLES} "
        "samples."
    )
    replaced = ", ".join(
        f"{score.entry.name} {_short(100.0 * score.replaced)} %"
        for score in board.ranked
        if score.replaced > 0.0
    )
    if replaced:
        said.append(
            "Estimates that were not finite or had no positive definite M, which the average of "
            f"the samples replaced: {replaced}."
        )
    said += [f"Without a place: {score.entry.name}, {score.problem}" for score in _placeless(board)]
    return said


def _who_is_first(board: Board, scores: Sequence[Score], among: str) -> str:
    """Return the best of some entries, and those not shown to be worse."""
    first, *others = scores
    text = f"First {among} is {first.entry.name}, {_millimeters(first.error)} mm"
    ties = [
        score.entry.name
        for score in others
        if board.ratio(score.entry.name, first.entry.name).low <= 1.0
    ]
    return text + (f"; not shown to be worse: {', '.join(ties)}." if ties else ".")


def _placeless(board: Board) -> list[Score]:
    return [score for score in board.scores if score.problem]


def board_rows(board: Board) -> list[list[str]]:
    """Return the cells of the board, one row per entry."""
    return [_row(place, score) for place, score in enumerate(board.scores, start=1)]


def short_rows(board: Board) -> list[list[str]]:
    """Return the cells of the short board, one row per entry; only ratios have intervals."""
    return [
        [*row[:3], _short(1e3 * score.error.value), row[4], row[6], *row[7:9]]
        for row, score in zip(board_rows(board), board.scores, strict=True)
    ]


def _row(place: int, score: Score) -> list[str]:
    return [
        "–" if score.problem else str(place),
        score.entry.name,
        score.entry.knows,
        _millimeters(score.error),
        _with_interval(score.to_best),
        _with_interval(score.to_reference),
        "–" if math.isnan(score.diverged) else f"{100.0 * score.diverged:.0f} %",
        _short(1e6 * score.step_time),
        _short(score.training_time),
        _short(score.effort),
    ]


def board_note(board: Board) -> str:
    """Return the explanations below the board."""
    return (
        "Geometric means, over all robots, paths, noises and seeds, of the root mean square "
        "distance of the tip from its desired position; in brackets 95 % intervals, seeds paired. "
        "An entry is not shown to be worse than the best if the interval of its ratio reaches "
        "down to 1. Runs that diverged count as the extent of their path. Training and steps are "
        "medians; steps are called from Python, training is CPU time. The fuzzy entries (t1, it2, "
        f"gt2 and adaptive) are given the signal-to-noise ratio, the others are not. {REFERENCE} "
        "is exact computed torque."
    )


def heading(cell: Cell) -> str:
    """Return the heading above the errors of a cell."""
    return f"{condition(cell)}, {cell.path}"


def _cells(board: Board, robot: str) -> list[Cell]:
    return [cell for cell in board.cells if cell.robot == robot]


def _in_cell(score: Score, cell: Cell) -> str:
    found = score.cells[cell]
    lost = found.diverged.value
    text = _millimeters(found.error)
    return f"{text}, {100.0 * lost:.0f} % diverged" if lost > 0.0 else text


def _millimeters(estimate: Estimate) -> str:
    return _with_interval(estimate, 1e3)


def _with_interval(estimate: Estimate, factor: float = 1.0) -> str:
    text = _short(factor * estimate.value)
    low, high = _short(factor * estimate.low), _short(factor * estimate.high)
    # Errors that do not depend on the seed differ only by rounding, and have no interval.
    if math.isfinite(estimate.low) and low != high:
        text += f" ({low} to {high})"
    return text


def _short(value: float) -> str:
    """Return a number with three significant digits, and a dash for none."""
    if not math.isfinite(value):
        return "–"
    if value == 0.0:
        return "0"
    digits = max(0, 2 - math.floor(math.log10(abs(value))))
    return f"{value:.{digits}f}" if digits < 6 else f"{value:.2g}"
