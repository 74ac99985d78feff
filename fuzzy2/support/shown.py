"""Display of objects: a figure with ``view()``, and HTML with a small picture in notebooks.

Small pictures are plain SVG, made without a plotting library. :mod:`fuzzy2.support.viewers` knows
the function that draws figures.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from fuzzy2.support.checks import Array
from fuzzy2.support.markup import LEFT, Markup, element, joined
from fuzzy2.support.viewers import viewer

WIDTH, HEIGHT = 180.0, 48.0
"""Size of a small picture in pixels."""

COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f7f7f")
"""Colors of curves, from Okabe and Ito, which color-blind people can distinguish."""

Curve = tuple[Array, Array]
"""Lower and upper grades at the points of a small picture."""


class Shown:
    """Base of objects that can be displayed."""

    def view(self, axes: Any = None) -> tuple[Any, ...]:
        """Draw this object; see :func:`fuzzy2.view`.

        Parameters
        ----------
        axes : Axes or sequence of them, optional
            Axes to draw into; by default, those of a new figure.

        Returns
        -------
        tuple of Axes
            The axes; ``axes[0].figure`` is the figure to save or to show.
        """
        drawn: tuple[Any, ...] = viewer()(self, axes)
        return drawn

    def _repr_html_(self) -> Markup:
        """Return the HTML that a notebook shows."""
        return element("code", repr(self))


def captioned(picture: Markup, text: str) -> Markup:
    """Return a picture with a text below it; the text is escaped."""
    caption = element("figcaption", element("code", text))
    return element("figure", picture, caption, style="margin:0;display:inline-block")


def table(rows: Sequence[Sequence[str]]) -> Markup:
    """Return rows of cells, which are texts or markup, as a table."""
    cells = (joined(element("td", cell, style=LEFT) for cell in row) for row in rows)
    return element("table", *(element("tr", row) for row in cells))


def small_picture(
    ends: tuple[float, float], curves: Sequence[Curve], points: Array, name: str
) -> Markup:
    """Return curves between ``ends`` as SVG; ``name`` is its description for screen readers.

    Parameters
    ----------
    ends : (float, float)
        Ends of the horizontal axis.
    curves : sequence of pairs of (N,) arrays
        Lower and upper grades; the area between them is filled.
    points : (N,) array
        Points of the grades.
    name : str
        Description of the picture.
    """
    left, right = ends
    # Divided first, because the distance between the ends may overflow.
    width = max(right / 2.0 - left / 2.0, np.finfo(float).tiny)
    across = 2.0 + (WIDTH - 4.0) * np.clip((points / 2.0 - left / 2.0) / width, 0.0, 1.0)
    shapes = [element("title", name)]
    for n, (lower, upper) in enumerate(curves):
        color = COLORS[n % len(COLORS)]
        top, bottom = (_path(across, grades) for grades in (upper, lower))
        if not np.array_equal(lower, upper):
            area = f"{top} {_path(across[::-1], lower[::-1])}"
            shapes.append(element("polygon", points=area, fill=color, fill_opacity="0.3"))
            shapes.append(_line(bottom, color, stroke_dasharray="3 2"))
        shapes.append(_line(top, color))
    return element(
        "svg",
        *shapes,
        xmlns="http://www.w3.org/2000/svg",
        width=f"{WIDTH:g}",
        height=f"{HEIGHT:g}",
        viewBox=f"0 0 {WIDTH:g} {HEIGHT:g}",
        role="img",
    )


def _path(across: Array, grades: Array) -> str:
    down = HEIGHT - 2.0 - (HEIGHT - 4.0) * np.clip(np.nan_to_num(grades), 0.0, 1.0)
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in zip(across, down, strict=True))


def _line(path: str, color: str, **style: str) -> Markup:
    return element("polyline", points=path, fill="none", stroke=color, **style)
