"""The panels that figures are drawn into, and their colors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, LinearSegmentedColormap, to_hex, to_rgba
from matplotlib.figure import Figure

from fuzzy2.errors import InvalidValue

Panels = tuple[Axes, ...]


def given_panels(axes: Sequence[Axes] | Axes | None, count: int) -> Panels | None:
    """Return the panels to draw into, None if none are given; refuse a wrong number of them."""
    if axes is None:
        return None
    panels = tuple(np.ravel(np.asarray(axes, dtype=object)))
    if len(panels) != count:
        raise InvalidValue("axes", len(panels), f"{count} axes for this figure")
    return panels


def new_panels(
    width: float, height: float, rows: int = 1, columns: int = 1, **options: Any
) -> Panels:
    """Return the panels of a new figure."""
    figure = Figure(figsize=(width, height), layout="constrained")
    return tuple(figure.subplots(rows, columns, squeeze=False, **options).flat)


def cycle_colors() -> list[str]:
    """Return the colors of the current style, in their order."""
    return [to_hex(color) for color in rcParams["axes.prop_cycle"].by_key()["color"]]


def muted() -> str:
    """Color for what is not data.

    That of the ticks, which every theme sets against its background.
    """
    return to_hex(rcParams["xtick.color"])


def deep(color: str) -> str:
    """Return a color nearer to that of the text, to stand out from the shades."""
    return to_hex(LinearSegmentedColormap.from_list("", [color, rcParams["text.color"]])(0.4))


def shades_of(color: str) -> Colormap:
    """Return colors for grades from 0 to 1.

    From none at all, so that sets can lie over one another, to full.
    """
    return LinearSegmentedColormap.from_list(
        "grades", [to_rgba(color, 0.0), to_rgba(color, 0.5), to_rgba(color, 1.0)]
    )
