"""What the main job finds.

Tables of printed and computed values, verdicts in words, sentences of the answer, drawings.
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
"""Verdict on a number that agrees because something was chosen to make it agree."""


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
        What the reader must know, in words.
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
    """A figure in a file, and in words.

    ``path`` is the file, ``caption`` is shown below it, ``description`` is read to those who cannot
    see it.
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
    """What :func:`psp3.thesis.replication.reproduce` found.

    Parameters
    ----------
    sentence : str
        What came out, in one sentence.
    tables : list of Table
        Printed and computed values side by side.
    answer : list of str
        What came out, in sentences.
    results : dict of Result
        Simulations by name.
    numbers : dict
        Everything in numbers, for a machine.
    drawings : list of Drawing
        Figures.
    files : list of Path
        Everything that was written.
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
    """Say in words how a number compares with the printed one, and why.

    Parameters
    ----------
    computed, printed : float
        The numbers, both positive.
    spread : (2,) tuple of float, optional
        Spread of single runs, where the computed number is a mean of many. The printed one is a
        single run, so whether it lies within is said.
    reason : str
        Why the numbers agree no better, or agree: no verdict stands without it.
    fitted : bool
        Whether something was chosen so that the numbers agree, which then reproduces nothing.

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
    # Unbroken spaces, or the sign would end a line in narrow tables.
    times = f"×\N{NO-BREAK SPACE}{ratio:.2g}"
    said = "" if spread is None else place_in(spread, printed)
    return (
        f"{'same order' if 1.0 / SAME_ORDER <= ratio <= SAME_ORDER else 'not reproduced'} "
        f"({times}): {reason}" + (f"; printed {said}" if said else "")
    )


def place_in(spread: tuple[float, float], printed: float) -> str:
    """Say whether a printed number, one run, lies within the spread of single runs.

    Nothing is said without a spread.
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
        Of the errors, controller minus baseline, paired by seed.
    controller, baseline : str
        Their names.

    Returns
    -------
    str
        The better one, or that neither was shown to be.
    """
    if difference.high < 0.0:
        return f"{controller} better"
    if difference.low > 0.0:
        return f"{baseline} better"
    return "no difference shown"


def significant(value: float) -> str:
    """Return a number with three significant digits, as in tables of errors.

    Six decimals at most, no exponent, and a dash for none.
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

    And with the number of seeds that it stands on where that is not ``seeds``.
    """
    text = significant(estimate.value)
    if np.isfinite(estimate.low) and estimate.low != estimate.high:
        text += f" ({significant(estimate.low)} to {significant(estimate.high)})"
    return text if seeds is None or estimate.count == seeds else f"{text}, n = {estimate.count}"


def as_numbers(estimate: Estimate) -> dict[str, float | int | str]:
    """Return an estimate for a machine."""
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

    Within ``bar`` they count as matched, and None says they cannot be reproduced; ``reason`` says
    why.
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
