"""Draw the board of the benchmark anew, from the table of ``docs/how_to/benchmark.md``.

Run by ``make pictures``, or ``python docs/pictures/make_board.py``.
"""

from __future__ import annotations

import re

from make_figures import BLUE, HERE, VERMILLION, save
from matplotlib.figure import Figure

from fuzzy2.plots.style import style

ROW = re.compile(r"^\| \d+ \| `([^`]+)` \| (the model|samples) \| ([\d.]+) \|", re.MULTILINE)


def rows() -> list[tuple[str, str, float]]:
    """Return every entry with what it knows and its error [mm], the best first."""
    text = (HERE.parent / "how_to" / "benchmark.md").read_text(encoding="utf-8")
    return [(entry, knows, float(error)) for entry, knows, error in ROW.findall(text)]


def main() -> None:
    """Write the figure beside this file."""
    found = rows()
    with style():
        figure = Figure(figsize=(6.4, 4.6), layout="constrained")
        axes = figure.subplots()
        for knows, color, hatch in (("the model", BLUE, ""), ("samples", VERMILLION, "//")):
            places = [place for place, row in enumerate(found) if row[1] == knows]
            axes.barh(
                places,
                [found[place][2] for place in places],
                color=color if not hatch else "none",
                edgecolor=color,
                hatch=hatch,
                label={"the model": "knows the model", "samples": "learns from samples"}[knows],
            )
        axes.set_yticks(range(len(found)), [entry for entry, _, _ in found], fontsize=8.0)
        axes.invert_yaxis()
        axes.set_xscale("log")
        axes.set_xlabel("error of the tip [mm]")
        axes.set_title(f"{len(found)} controllers on three robots")
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.25))
        save(figure, "board")


if __name__ == "__main__":
    main()
