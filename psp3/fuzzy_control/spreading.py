"""Choose points of a set that cover it evenly, each the farthest from those before."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from psp3.checks import Array


def spread_evenly(points: Array, count: int) -> NDArray[np.intp]:
    """Return the indices of points (N, p), in shares of their ranges, that cover all evenly.

    The first is the one farthest from the middle of the ranges, and each next one the farthest from
    all before, so every prefix covers all. The greatest distance of a point from its nearest chosen
    one is at most twice that of the best choice (T. F. Gonzalez, "Clustering to minimize the
    maximum intercluster distance", Theoretical Computer Science 38, 1985).
    """
    chosen = [int(np.argmax(((points - 0.5) ** 2).sum(axis=1)))]
    nearest = ((points - points[chosen[0]]) ** 2).sum(axis=1)
    while len(chosen) < count:
        chosen.append(int(np.argmax(nearest)))
        np.minimum(nearest, ((points - points[chosen[-1]]) ** 2).sum(axis=1), out=nearest)
    return np.array(chosen)
