"""Compiled densities of clouds of data; :mod:`fuzzy2.systems.anya` is their face."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fuzzy2.support.checks import Array
from fuzzy2.support.compiled import compiled


@compiled
def relative_densities(
    data: Array, starts: NDArray[np.int64], asked: NDArray[np.int64], x: Array, out: Array
) -> int:
    """Write the relative densities (rows, R) of flat inputs.

    Return -1 or the first row that is not finite. ``data`` holds the clouds one after the other,
    ``starts`` where each begins and the last ends, ``asked`` the cloud of each antecedent.
    """
    clouds, antecedents = starts.size - 1, asked.size
    away = np.empty(clouds)
    for row in range(x.size // clouds):
        for c in range(clouds):
            at = x[row * clouds + c]
            if not math.isfinite(at):
                return row
            away[c] = 0.0
            count = starts[c + 1] - starts[c]
            for k in range(starts[c], starts[c + 1]):
                # Half of it, for a distance may be no float.
                away[c] += abs(0.5 * at - 0.5 * data[k]) / count
        nearest, total = math.inf, 0.0
        for i in range(antecedents):
            nearest = min(nearest, away[asked[i]])
        for i in range(antecedents):
            # Relative to the greatest, for all of them may be tiny.
            density = (0.5 + nearest) / (0.5 + away[asked[i]])
            out[row * antecedents + i] = density
            total += density
        for i in range(antecedents):
            out[row * antecedents + i] /= total
    return -1
