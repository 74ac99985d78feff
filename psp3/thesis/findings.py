"""The findings of the main job.

They are tables of printed and computed values, verdicts in words, sentences of the answer, and
drawings.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from psp3.checks import Array
from psp3.simulation.result import Result
from psp3.study.statistics import Estimate

REPRODUCED = 0.05
"""Relative difference up to which a printed number counts as reproduced, or as matched by a fit."""

SAME_ORDER = 3.0
"""Factor up to which a number is of the same order as the printed one."""

MATCHED = "matched by a fit"
"""Verdict on a number that agrees because a parameter was fitted to it."""


@dataclass(frozen=True)
class Table:
    """A table to show.

    Parameters
    ----------
    title : str
        Its title.
    columns : list of str
        Headings.
    rows : list of list of str
        Cells.
    note : str
        Explanation below the table.
    figures : tuple of str
        Names of the drawings that belong to it.
    detail : bool
        Whether it is for the report only, not for the terminal.
    opening : bool
        Whether the report shows it unfolded, above the others.
    """

    title: str
    columns: list[str]
    rows: list[list[str]]
    note: str = ""
    figures: tuple[str, ...] = ()
    detail: bool = False
    opening: bool = False


@dataclass(frozen=True)
class Drawing:
    """A figure in a file, with texts.

    ``path`` is the file, ``caption`` is shown below it, and ``description`` is the alternative text
    for screen readers.
    """

    path: Path
    caption: str
    description: str

    @property
    def name(self) -> str:
        """Name of the file without its suffix."""
        return self.path.stem


@dataclass
class Reproduction:
    """The findings of :func:`psp3.thesis.replication.reproduce`.

    Parameters
    ----------
    sentence : str
        The result in one sentence.
    tables : list of Table
        Printed and computed values side by side.
    answer : list of str
        The results in sentences.
    results : dict of Result
        Simulations by name.
    numbers : dict
        All numbers, for ``results.json``.
    drawings : list of Drawing
        Figures.
    files : list of Path
        All files that were written.
    """

    sentence: str = ""
    tables: list[Table] = field(default_factory=list)
    answer: list[str] = field(default_factory=list)
    results: dict[str, Result] = field(default_factory=dict)
    numbers: dict[str, Any] = field(default_factory=dict)
    drawings: list[Drawing] = field(default_factory=list)
    files: list[Path] = field(default_factory=list)


def verdict(
    computed: float,
    printed: float,
    spread: tuple[float, float] | None = None,
    *,
    reason: str,
    fitted: bool = False,
) -> str:
    """Compare a number with the printed one in words, with the reason.

    Parameters
    ----------
    computed, printed : float
        The numbers, both positive.
    spread : (2,) tuple of float, optional
        Spread of single runs, if the computed number is a mean of many runs. The printed number is
        one run, so the verdict says whether it lies within the spread.
    reason : str
        Why the numbers agree, or do not agree better. Every verdict needs a reason.
    fitted : bool
        Whether a parameter was fitted to make the numbers agree. Then the verdict is "matched by a
        fit" instead of "reproduced".

    Returns
    -------
    str
        "reproduced" or "matched by a fit", "same order" or "not reproduced", the difference or
        ratio, and the reason.
    """
    if not np.isfinite(computed):
        return "not reproduced: every run diverged"
    ratio = computed / printed
    if abs(ratio - 1.0) <= REPRODUCED:
        words = MATCHED if fitted else "reproduced"
        return f"{words} ({100 * (ratio - 1):+.1f} %): {reason}"
    # Non-breaking spaces, because narrow tables would otherwise wrap after the sign.
    times = f"×\N{NO-BREAK SPACE}{ratio:.2g}"
    said = "" if spread is None else place_in(spread, printed)
    return (
        f"{'same order' if 1.0 / SAME_ORDER <= ratio <= SAME_ORDER else 'not reproduced'} "
        f"({times}): {reason}" + (f"; printed {said}" if said else "")
    )


def place_in(spread: tuple[float, float], printed: float) -> str:
    """Say whether a printed number, one run, lies within the spread of single runs.

    The text is empty without a spread.
    """
    if not np.isfinite(spread).all():
        return ""
    within = spread[0] <= printed <= spread[1]
    return f"{'within' if within else 'outside of'} the spread of single runs"


def better(difference: Estimate, controller: str, baseline: str) -> str:
    """Say in words which of two controllers has the smaller error.

    Parameters
    ----------
    difference : Estimate
        Difference of the errors, controller minus baseline, paired by seed.
    controller, baseline : str
        Their names.

    Returns
    -------
    str
        The better controller, or that no difference was shown.
    """
    if difference.high < 0.0:
        return f"{controller} better"
    if difference.low > 0.0:
        return f"{baseline} better"
    return "no difference shown"


def significant(value: float) -> str:
    """Return a number with three significant digits, as in tables of errors.

    It has at most six decimals and no exponent; no number is shown as a dash.
    """
    if not np.isfinite(value):
        return "–"
    if value == 0.0:
        return "0"
    if abs(value) < 1e-6:
        return "< 0.000001"
    digits = max(0, 2 - int(np.floor(np.log10(abs(value)))))
    return f"{value:.{min(digits, 6)}f}"


def with_interval(estimate: Estimate, seeds: int | None = None) -> str:
    """Return a value with its interval.

    The number of seeds behind it follows if that differs from ``seeds``.
    """
    text = significant(estimate.value)
    if np.isfinite(estimate.low) and estimate.low != estimate.high:
        text += f" ({significant(estimate.low)} to {significant(estimate.high)})"
    return text if seeds is None or estimate.count == seeds else f"{text}, n = {estimate.count}"


def as_numbers(estimate: Estimate) -> dict[str, float | int | str]:
    """Return an estimate as numbers for ``results.json``."""
    return {
        "value": estimate.value,
        "low": estimate.low,
        "high": estimate.high,
        "seeds": estimate.count,
        "estimand": estimate.estimand,
        "method": estimate.method,
    }


def compared(
    label: str, printed: Array, computed: Array, bar: float | None, reason: str
) -> list[list[str]]:
    """Return rows of a matrix as printed and as computed with parameters that were fitted to it.

    Rows within ``bar`` count as matched; a ``bar`` of None means that they cannot be reproduced.
    ``reason`` says why.
    """
    rows = []
    for number, (old, new) in enumerate(
        zip(np.atleast_2d(printed), np.atleast_2d(computed), strict=True), start=1
    ):
        gap = float(np.abs(old - new).max())
        words = (
            f"not reproducible: {reason}"
            if bar is None
            else f"{MATCHED if gap <= bar else 'not matched'}, to {gap:.4f}: {reason}"
        )
        rows.append(
            [
                label.format(number),
                *("  ".join(f"{value: .4f}" for value in values) for values in (old, new)),
                words,
            ]
        )
    return rows
