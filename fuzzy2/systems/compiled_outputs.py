"""The compiled loop for each kind of tables that :mod:`fuzzy2.systems.output_tables` makes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fuzzy2.support.checks import Array, binary_exponent
from fuzzy2.support.pieces import pieces
from fuzzy2.systems.monotonic_rows import Monotonics, monotonic_points
from fuzzy2.systems.output_kernels import Points, averages
from fuzzy2.systems.sampled_rows import samples
from fuzzy2.systems.union_rows import Unions, unions


def reduced_by_loop(tables: Any, rows: Array, outputs: int) -> tuple[Array, NDArray[np.bool_]]:
    """Return the type-reduced intervals (n, m, 2) of finite inputs (n, p), and refused rows.

    ``refused`` (n,) marks the rows without an answer yet, because their numbers are huge or the
    memory is too small.
    """
    found, refused = np.empty((len(rows), outputs, 2)), np.zeros(len(rows), bool)
    if isinstance(tables, Points) and binary_exponent(rows):
        refused[:] = True
        return found, refused
    for part in pieces(len(rows)):
        _reduce(tables, rows[part], found[part], refused[part])
    return found, refused


def _reduce(tables: Any, rows: Array, found: Array, refused: NDArray[np.bool_]) -> None:
    flat = rows.ravel()
    if isinstance(tables, Points):
        averages(tables, flat, found.ravel())
    elif isinstance(tables, Unions):
        unions(tables, flat, found.ravel(), refused)
    elif isinstance(tables, Monotonics):
        crisp = np.empty(found.shape[:2])
        monotonic_points(tables, flat, crisp.ravel())
        found[:] = crisp[..., np.newaxis]
    else:
        samples(tables, flat, found.ravel())
