"""Compiled densities of clouds of data; :mod:`fuzzy2.systems.anya` is their face."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fuzzy2.support.checks import Array
from fuzzy2.support.compiled import compiled, scalar


@scalar
def densities_in(
    data: Array,
    starts: NDArray[np.int64],
    asked: NDArray[np.int64],
    x: Array,
    xo: int,
    away: Array,
    out: Array,
    oo: int,
) -> None:
    """Do as ``relative_densities`` for the finite row at ``xo``; densities go to ``oo`` and on.

    ``away`` is room for a number a cloud.
    """
    for c in range(away.size):
        away[c] = 0.0
        count = starts[c + 1] - starts[c]
        for k in range(starts[c], starts[c + 1]):
            # Half of it, for a distance may be no float.
            away[c] += abs(0.5 * x[xo + c] - 0.5 * data[k]) / count
    nearest, total = math.inf, 0.0
    for i in range(asked.size):
        nearest = min(nearest, away[asked[i]])
    for i in range(asked.size):
        # Relative to the greatest, for all of them may be tiny.
        density = (0.5 + nearest) / (0.5 + away[asked[i]])
        out[oo + i] = density
        total += density
    for i in range(asked.size):
        out[oo + i] /= total


@compiled
def relative_densities(
    data: Array, starts: NDArray[np.int64], asked: NDArray[np.int64], x: Array, out: Array
) -> int:
    """Write the relative densities (rows, R) of flat inputs.

    Return -1 or the first row that is not finite. ``data`` holds the clouds one after the other,
    ``starts`` where each begins and the last ends, ``asked`` the cloud of each antecedent.
    """
    clouds = starts.size - 1
    away = np.empty(clouds)
    for i in range(x.size):
        if not math.isfinite(x[i]):
            return i // clouds
    for row in range(x.size // clouds):
        densities_in(data, starts, asked, x, row * clouds, away, out, row * asked.size)
    return -1
