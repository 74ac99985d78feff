"""Compiled densities of data clouds, which :mod:`fuzzy2.systems.anya` calls."""

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
    """Do as ``relative_densities`` for the finite row at ``xo``; write densities from ``oo`` on.

    ``away`` is scratch space for one number per cloud.
    """
    for c in range(away.size):
        away[c] = 0.0
        count = starts[c + 1] - starts[c]
        for k in range(starts[c], starts[c + 1]):
            # Half of the distance is used, because the distance may overflow.
            away[c] += abs(0.5 * x[xo + c] - 0.5 * data[k]) / count
    nearest, total = math.inf, 0.0
    for i in range(asked.size):
        nearest = min(nearest, away[asked[i]])
    for i in range(asked.size):
        # Values are taken relative to the greatest, because all of them may be tiny.
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

    Return -1, or the number of the first row that is not finite. ``data`` holds the clouds one
    after the other, ``starts`` the places where each begins and where the last ends, and ``asked``
    the cloud of each antecedent.
    """
    clouds = starts.size - 1
    away = np.empty(clouds)
    for i in range(x.size):
        if not math.isfinite(x[i]):
            return i // clouds
    for row in range(x.size // clouds):
        densities_in(data, starts, asked, x, row * clouds, away, out, row * asked.size)
    return -1
