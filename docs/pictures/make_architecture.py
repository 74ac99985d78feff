"""Draw the layers of both packages anew, as ``pyproject.toml`` orders them.

Run by ``make pictures``, or ``python docs/pictures/make_architecture.py``.
"""

from __future__ import annotations

import tomllib
from pathlib import Path

from make_figures import BLUE, arrow, box, diagram, save
from matplotlib.axes import Axes

from fuzzy2.plots.style import style

CONTRACTS = tomllib.loads(
    (Path(__file__).resolve().parents[2] / "pyproject.toml").read_text(encoding="utf-8")
)["tool"]["importlinter"]["contracts"]
WIDTH, MARGIN, PITCH, HEIGHT, GAP = 4.3, 0.42, 0.37, 0.27, 0.1  # [inch]


def layers_of(root: str) -> list[list[str]]:
    """Return the packages of every layer, from the top."""
    (layers,) = (
        contract["layers"] for contract in CONTRACTS if contract.get("containers") == [root]
    )
    return [[name.strip() for name in layer.split("|")] for layer in layers]


def for_any_robot() -> set[str]:
    """Return the packages that may not name the 3-PSP."""
    (sources,) = (
        contract["source_modules"]
        for contract in CONTRACTS
        if contract.get("forbidden_modules") == ["psp3.three_psp"]
    )
    return set(sources)


def draw_layers(axes: Axes, root: str, title: str, top: float) -> float:
    """Draw a package with its layers from the top down; return where it ends."""
    layers, general = layers_of(root), for_any_robot()
    bottom = top - 0.4 - PITCH * len(layers)
    box(axes, WIDTH / 2, (top + bottom) / 2, "", WIDTH, top - bottom, linewidth=1.6)
    axes.text(0.15, top - 0.2, title, va="center", fontsize=10.0, weight="bold")
    inside = WIDTH - MARGIN - 0.12
    for number, names in enumerate(layers):
        y = top - 0.4 - PITCH * (number + 0.5) + 0.04
        width = (inside - GAP * (len(names) - 1)) / len(names)
        for place, name in enumerate(names):
            x = MARGIN + width / 2 + place * (width + GAP)
            marked = {"edgecolor": BLUE, "linewidth": 2.4} if f"{root}.{name}" in general else {}
            box(axes, x, y, name, width, HEIGHT, **marked)
            # An identifier in the file, by which a test finds what is drawn.
            axes.patches[-1].set_gid(f"{root}.{name}")
    arrow(axes, (0.2, top - 0.45), (0.2, bottom + 0.12))
    return bottom


def architecture() -> None:
    """Draw psp3 above fuzzy2, each with its layers, and the one arrow between them."""
    rows = len(layers_of("psp3")) + len(layers_of("fuzzy2"))
    height = PITCH * rows + 2 * 0.4 + 0.45 + 0.5
    figure, axes = diagram(WIDTH, height, (-0.04, WIDTH + 0.04), (-height + 0.02, 0.04))
    bottom = draw_layers(axes, "psp3", "psp3", 0.0)
    arrow(axes, (WIDTH / 2, bottom), (WIDTH / 2, bottom - 0.45), linewidth=2.0)
    axes.text(WIDTH / 2 + 0.15, bottom - 0.22, "uses", va="center", fontsize=9.0)
    bottom = draw_layers(axes, "fuzzy2", "fuzzy2, which knows nothing of robots", bottom - 0.45)
    axes.text(
        WIDTH / 2,
        bottom - 0.1,
        "Imports run down, as the arrows do.\nThick blue frame: for any robot, never the 3-PSP.",
        ha="center",
        va="top",
        fontsize=9.0,
    )
    save(figure, "architecture")


if __name__ == "__main__":
    with style("light"):
        architecture()
