"""Draw the picture in the guide to optimal control anew, from the guide's own code.

Run by ``make pictures``, or ``python docs/pictures/make_optimal_control.py``.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
from make_figures import MUTED, save
from matplotlib.figure import Figure

from fuzzy2.plots.style import CYCLES, style

PAGE = Path(__file__).parents[1] / "how_to" / "optimal_control.md"


def planned() -> dict[str, Any]:
    """Return the names of the guide after its plan is made."""
    names: dict[str, Any] = {"__name__": "__main__", "print": lambda *_: None}
    for code in re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL):
        exec(code, names)
        if "knots" in names:
            break
    return names


def main() -> None:
    """Write ``fastest_run.svg``."""
    names = planned()
    time, forces, limit = 1e3 * names["knots"], names["planned"], names["PLANNED"]
    with style():
        figure = Figure(figsize=(7.0, 4.4), layout="constrained")
        above, below = figure.subplots(2, sharex=True, height_ratios=(2, 1))
        for side in (-limit, limit):
            above.axhline(side, color=MUTED, linewidth=0.8, linestyle="--")
        # Within an interval from one end to the other; jumps are drawn between intervals.
        ends = np.repeat(time, 2)[1:-1]
        looks = zip(("-", (0, (5, 1.5)), (0, (1.5, 1))), CYCLES["light"], strict=False)
        for motor, (line, color) in enumerate(looks):
            label = f"motor {motor + 1}"
            above.plot(ends, forces[:, :, motor].ravel(), color=color, linestyle=line, label=label)
        above.set_ylabel("torque [N m]")
        above.set_ylim(-1.15 * limit, 1.15 * limit)
        above.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False)
        below.plot(time, names["rates"], color=CYCLES["light"][0])
        below.set_ylabel("rate along\nthe path [1/s]")
        below.set_xlabel("time [ms]")
        save(figure, "fastest_run")


if __name__ == "__main__":
    main()
