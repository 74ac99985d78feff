"""Panels that figures are drawn into, and their colors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, LinearSegmentedColormap, to_hex, to_rgba
from matplotlib.figure import Figure

from fuzzy2.errors import InvalidValue
from fuzzy2.support.checks import whole_number

Panels = tuple[Axes, ...]


def given_panels(
    axes: Sequence[Axes] | Axes | None,
    count: int,
    error: Callable[[str, object, str], Exception] = InvalidValue,
) -> Panels | None:
    """Return the given panels, or None if none are given; refuse a wrong number of panels.

    ``error`` makes the exception from the argument's name, its value and the requirement.
    """
    if axes is None:
        return None
    panels = tuple(np.ravel(np.asarray(axes, dtype=object)))
    if len(panels) != count or not all(isinstance(panel, Axes) for panel in panels):
        raise error("axes", axes, f"{count} axes of matplotlib for this figure")
    return panels


def new_panels(
    width: float, height: float, rows: int = 1, columns: int = 1, **options: Any
) -> Panels:
    """Return the panels of a new figure."""
    figure = Figure(figsize=(width, height), layout="constrained")
    return tuple(figure.subplots(rows, columns, squeeze=False, **options).flat)


def space_panel(axes: Sequence[Axes] | Axes | None) -> Any:
    """Return the three-dimensional panel to draw into; make a new one if none is given."""
    (panel,) = given_panels(axes, 1) or new_panels(6.0, 4.6, subplot_kw={"projection": "3d"})
    if panel.name != "3d":
        raise InvalidValue("axes", panel.name, 'three-dimensional, made with projection="3d"')
    space: Any = panel
    space.set_box_aspect(None, zoom=0.88)  # labels would be cut off otherwise
    for axis in (space.xaxis, space.yaxis, space.zaxis):
        axis.set_pane_color(to_rgba(rcParams["grid.color"], 0.25))
    return space


def cycle_colors() -> list[str]:
    """Return the colors of the current style, in their order."""
    return [to_hex(color) for color in rcParams["axes.prop_cycle"].by_key()["color"]]


def muted() -> str:
    """Return the color for elements that are not data.

    It is the color of the ticks, which contrasts with the background in every theme.
    """
    return to_hex(rcParams["xtick.color"])


def deep(color: str) -> str:
    """Return the color moved toward that of the text, so that it stands out from the shades."""
    return to_hex(LinearSegmentedColormap.from_list("", [color, rcParams["text.color"]])(0.4))


def shades_of(color: str) -> Colormap:
    """Return a color map for grades from 0 to 1.

    Colors range from transparent, so that sets can overlap, to opaque.
    """
    return LinearSegmentedColormap.from_list(
        "grades", [to_rgba(color, 0.0), to_rgba(color, 0.5), to_rgba(color, 1.0)]
    )


def check_output(output: object, count: int) -> None:
    """Raise :class:`InvalidValue` unless a value is the number of one of ``count`` outputs."""
    if whole_number("output", output, 0) >= count:
        raise InvalidValue("output", output, f"from 0 to {count - 1}")
