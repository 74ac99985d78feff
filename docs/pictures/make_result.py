"""Draw the result of the comparison anew.

Run by ``make pictures``, or ``python docs/pictures/make_result.py``; half a minute.
"""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

from make_figures import save
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import psp3
from fuzzy2.plots.style import style
from psp3.published import TABLE_6_3
from psp3.study.execution import execute
from psp3.study.run import Run
from psp3.study.statistics import Estimate, mean

SEEDS = 30
NOISE = (20.0, 15.0, 10.0)
WIDE = 3.0
SERIES = {
    "type-1": Run("t1"),
    "type-2": Run("it2"),
    f"type-1, terms {WIDE:g} × as wide": Run("t1", term_width=WIDE),
    "type-1, rules that average": Run("t1", learner="average"),
    "type-2, rules that average": Run("it2", learner="average"),
}
MARKERS = ("o", "s", "^", "D", "v")


def errors() -> dict[str, list[Estimate]]:
    """Return the mean error of every series at every noise level."""
    with tempfile.TemporaryDirectory() as directory:
        runs = {
            (name, snr): [replace(run, snr_db=snr, seed=seed) for seed in range(SEEDS)]
            for name, run in SERIES.items()
            for snr in NOISE
        }
        study = psp3.Study(
            Path(directory) / "study.sqlite", [run for group in runs.values() for run in group]
        )
        study.run()
        found = {
            Run(**{name: row[name] for name in Run.__dataclass_fields__}): row[
                "sum_of_squared_errors"
            ]
            for row in study.rows()
        }
        return {
            name: [mean([found[run.canonical()] for run in runs[name, snr]]) for snr in NOISE]
            for name in SERIES
        }


def draw(axes: Axes, found: dict[str, list[Estimate]]) -> None:
    """Draw errors with their intervals, and those of exact computed torque and of PD as lines."""
    for place, (name, estimates) in enumerate(found.items()):
        x = [at + 0.12 * (place - 2) for at in range(len(NOISE))]
        values = [estimate.value for estimate in estimates]
        spread = [[e.value - e.low for e in estimates], [e.high - e.value for e in estimates]]
        axes.errorbar(
            x, values, yerr=spread, linestyle="none", marker=MARKERS[place], capsize=3.0, label=name
        )
    for name, kind in (("PD", "pd"), ("exact computed torque", "ctc")):
        value = execute(Run(kind))["sum_of_squared_errors"]
        axes.axhline(value, linestyle="--", linewidth=1.0, color="0.5")
        printed = TABLE_6_3["PD" if kind == "pd" else "CTC"]
        place = (0.5 if kind == "pd" else 1.0, value)
        text = f"{name} (printed {printed:g})"
        axes.annotate(
            text, place, xytext=(0, -4), textcoords="offset points", ha="center", va="top"
        )
    axes.set_xticks(range(len(NOISE)), [f"{snr:g} dB" for snr in NOISE])
    axes.set_xlabel("signal-to-noise ratio of the records")
    axes.set_ylabel("sum of squared errors [m²]")
    axes.set_yscale("log")
    axes.set_ylim(bottom=0.01)
    # Above the legend, which is as close to the curves as it can be without hiding any.
    axes.set_title(f"Type-2 gains by averaging ({SEEDS} seeds)", pad=56.0)
    axes.legend(
        ncols=2,
        loc="lower center",
        bbox_to_anchor=(0.5, 1.0),
        frameon=False,
        columnspacing=1.0,
        handletextpad=0.2,
    )


def main() -> None:
    """Write the figure beside this file."""
    with style():
        figure = Figure(figsize=(4.8, 4.8), layout="constrained")
        draw(figure.subplots(), errors())
        save(figure, "result")


if __name__ == "__main__":
    main()
