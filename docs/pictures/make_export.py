"""Draw what is exported, and as what, anew.

Run by ``make pictures``, or ``python docs/pictures/make_export.py``.
"""

from __future__ import annotations

from make_figures import arrow, box, diagram, save

from fuzzy2.plots.style import style

FROM = {"robot": 1.1, "controller": 0.0, "fuzzy system": -1.1}
TO = {
    "C99 for a drive\nor a microcontroller": 1.1,
    "FMU for Simulink,\nModelica tools, …": 0.0,
    "symbols for CasADi:\noptimal control": -1.1,
}
WAYS = ((1.1, 1.1), (1.1, 0.0), (1.1, -1.1), (0.0, 1.1), (0.0, 0.0), (0.0, -1.1), (-1.1, 1.1))


def main() -> None:
    """Write the figure beside this file."""
    with style():
        figure, axes = diagram(6.4, 3.1, (-3.2, 3.2), (-1.55, 1.55))
        for text, y in FROM.items():
            box(axes, -2.2, y, text, 1.9, 0.7)
        for text, y in TO.items():
            box(axes, 2.05, y, text, 2.2, 0.7)
        for start, end in WAYS:
            arrow(axes, (-1.25, start), (0.95, end))
        save(figure, "export")


if __name__ == "__main__":
    main()
