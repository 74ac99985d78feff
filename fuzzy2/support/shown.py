"""How things show themselves: a picture by ``view()``, and HTML with a small one in notebooks.

Small pictures are plain SVG, made without a plotting library; who draws the others is said in
:mod:`fuzzy2.support.viewers`.
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
"""Colors of curves; those of Okabe and Ito, which color-blind people tell apart."""

Curve = tuple[Array, Array]
"""Lower and upper grades at the points of a small picture."""


class Shown:
    """What can be looked at."""

    def view(self, axes: Any = None) -> tuple[Any, ...]:
        """Draw this; see :func:`fuzzy2.view`.

        Parameters
        ----------
        axes : Axes or sequence of them, optional
            Those of a new figure by default.

        Returns
        -------
        tuple of Axes
            The axes; ``axes[0].figure`` is the figure to save or to show.
        """
        drawn: tuple[Any, ...] = viewer()(self, axes)
        return drawn

    def _repr_html_(self) -> Markup:
        """Return what a notebook shows."""
        return element("code", repr(self))


def captioned(picture: Markup, text: str) -> Markup:
    """Return a picture with a text below, of which nothing is taken for HTML."""
    caption = element("figcaption", element("code", text))
    return element("figure", picture, caption, style="margin:0;display:inline-block")


def table(rows: Sequence[Sequence[str]]) -> Markup:
    """Return rows of cells, texts or markup, as a table."""
    cells = (joined(element("td", cell, style=LEFT) for cell in row) for row in rows)
    return element("table", *(element("tr", row) for row in cells))


def small_picture(
    ends: tuple[float, float], curves: Sequence[Curve], points: Array, name: str
) -> Markup:
    """Return curves between ``ends`` as SVG; ``name`` is read to those who cannot see it.

    Parameters
    ----------
    ends : (float, float)
        Ends of the abscissa.
    curves : sequence of pairs of (N,) arrays
        Lower and upper grades; their area is filled where they differ.
    points : (N,) array
        Where the grades are.
    name : str
        What is shown.
    """
    left, right = ends
    # Divided first: the distance of the ends may be no float.
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
