"""Which compiled loop reduces which tables; :mod:`fuzzy2.systems.output_tables` makes them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fuzzy2.support.checks import Array, binary_exponent
from fuzzy2.systems.monotonic_rows import Monotonics, monotonic_points
from fuzzy2.systems.output_kernels import Points, averages
from fuzzy2.systems.sampled_rows import samples
from fuzzy2.systems.union_rows import Unions, unions


def reduced_by_loop(tables: Any, rows: Array, outputs: int) -> tuple[Array, NDArray[np.bool_]]:
    """Return the type-reduced intervals (n, m, 2) of finite inputs (n, p), and what is refused.

    Where it is refused (n,), because numbers are huge or there is no room, a row has no answer yet.
    """
    found, flat = np.empty((len(rows), outputs, 2)), rows.ravel()
    refused = np.zeros(len(rows), bool)
    if isinstance(tables, Points):
        if binary_exponent(rows):
            refused[:] = True
        else:
            averages(tables, flat, found.ravel())
    elif isinstance(tables, Unions):
        unions(tables, flat, found.ravel(), refused)
    elif isinstance(tables, Monotonics):
        crisp = np.empty((len(rows), outputs))
        monotonic_points(tables, flat, crisp.ravel())
        found[:] = crisp[..., np.newaxis]
    else:
        samples(tables, flat, found.ravel())
    return found, refused
