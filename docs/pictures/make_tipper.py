"""Draw why the tipper of the README answers what it answers, as MATLAB's ``ruleview`` does.

Run by ``make pictures``, or ``python docs/pictures/make_tipper.py``.
"""

from __future__ import annotations

import re

from make_figures import HERE, save
from matplotlib.figure import Figure

import fuzzy2
from fuzzy2.plots.style import style


def tipper() -> fuzzy2.Type1System:
    """Return the system that the README makes."""
    text = (HERE.parents[1] / "README.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL)
    (code,) = (block for block in blocks if "tipper = " in block)
    names: dict[str, fuzzy2.Type1System] = {}
    exec(code.partition("fuzzy2.save")[0], names)
    return names["tipper"]


def main() -> None:
    """Write the figure beside this file."""
    with style():
        figure = Figure(figsize=(6.4, 4.2), layout="constrained")
        explanation = tipper().explain([8.0, 6.0])
        fuzzy2.plots.figure_of_inference(explanation, axes=figure.subplots(3, 3).ravel())
        save(figure, "tipper")


if __name__ == "__main__":
    main()
