"""A system as one array, for the compiled loops."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fuzzy2.support.checks import Array


def table_of(
    inputs: Sequence[Sequence[Any]],
    rules: NDArray[np.int64],
    intervals: Array,
    minimum: bool,
    rows: list[tuple[float, ...]],
) -> Array:
    """Return a center-of-sets system as one array, laid out as the kernels read it.

    Parameters
    ----------
    inputs : sequence of sequences of sets
        The terms of every input.
    rules : (R, p) ndarray
        Number of the term of each input that a rule asks for, or -1.
    intervals : (R, m, 2) ndarray
        The consequents.
    minimum : bool
        Whether the t-norm is the minimum; else it is the product.
    rows : list of tuples
        Number of the input and kernel row of each term.

    Returns
    -------
    (k,) ndarray
        The table.
    """
    count, outputs = intervals.shape[:2]
    offsets = np.cumsum([0, *(len(terms) for terms in inputs[:-1])])
    antecedents = np.where(rules >= 0, rules + offsets, -1)
    left, right = intervals[..., 0], intervals[..., 1]
    least, greatest = left.min(axis=0), right.max(axis=0)
    return np.concatenate(
        [
            [
                len(inputs),
                len(rows),
                count,
                outputs,
                0.0 if minimum else 1.0,
                0.0,
            ],
            np.ravel(rows),
            antecedents.ravel(),
            np.concatenate([left - least, greatest - right], axis=1).ravel(),
            least,
            greatest,
            np.sort(left - least, axis=0).T.ravel(),
            np.sort(greatest - right, axis=0).T.ravel(),
            np.argsort(left - least, axis=0, kind="stable").T.ravel(),
            np.argsort(greatest - right, axis=0, kind="stable").T.ravel(),
        ]
    ).astype(float)
