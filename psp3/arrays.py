"""Checks of array arguments that every module shares: finite numbers of the right shape, or an error that says which."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from psp3.errors import InvalidArray

Array = NDArray[np.float64]


def finite_rows(name: str, values: ArrayLike, width: int) -> Array:
    """Return ``values`` as a contiguous array of shape (..., width) of finite numbers.

    Raises
    ------
    InvalidArray
        If the last dimension is not ``width`` or an entry is not a finite number.
    """
    try:
        array = np.ascontiguousarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InvalidArray(name, f"(..., {width})", values) from error
    if array.shape[-1:] != (width,) or np.ndim(values) == 0 or not np.isfinite(array).all():
        raise InvalidArray(name, f"(..., {width})", array)
    return array
