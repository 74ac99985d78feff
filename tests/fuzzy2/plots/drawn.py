"""What was drawn, read back from the axes."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

Array = NDArray[np.float64]


def curve(axes: Axes, label: str) -> Array:
    """Return the data of the line with that label, (2, N)."""
    (line,) = (line for line in axes.lines if line.get_label() == label)
    return np.array(line.get_data(), dtype=float)


def band(axes: Axes, label: str | None = None, index: int = 0) -> Array:
    """Return the corners of a filled band, (N, 2): of the one with that label, or by its index."""
    fills: Any = [one for one in axes.collections if label is None or one.get_label() == label]
    return np.asarray(fills[index].get_paths()[0].vertices)


def edges(corners: Array, x: float) -> tuple[float, float]:
    """Return lower and upper edge of a band at the drawn point nearest to x."""
    nearest = corners[np.argmin(np.abs(corners[:, 0] - x)), 0]
    at = corners[corners[:, 0] == nearest, 1]
    return float(at.min()), float(at.max())
