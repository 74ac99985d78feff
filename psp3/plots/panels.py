"""The panels that figures are drawn into, and what they have in common."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes

from psp3.errors import InvalidValue

Panels = tuple[Axes, ...]


def given_panels(axes: Sequence[Axes] | None, count: int) -> Panels | None:
    """Return the panels to draw into, None if none are given; refuse a wrong number of them."""
    if axes is None:
        return None
    panels = tuple(np.ravel(np.asarray(axes, dtype=object)))
    if len(panels) != count:
        raise InvalidValue("axes", len(panels), f"{count} axes for this figure")
    return panels


def muted() -> str:
    """Color for what is not data.

    That of the ticks, which every theme sets against its background.
    """
    return str(rcParams["xtick.color"])
