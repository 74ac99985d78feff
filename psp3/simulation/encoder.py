"""Encoders: positions in counts, speeds as their differences."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from psp3.checks import (
    Array,
    checked_positive,
    finite_array,
)
from psp3.errors import InvalidArray, InvalidValue


class Encoder:
    """What a drive sees of its joints, see ``encoder_resolution`` of :func:`simulate`.

    Of the first coordinates, one a resolution; the others are seen as they are.
    """

    def __init__(self, resolution: ArrayLike, period: float) -> None:
        resolution = finite_array("encoder_resolution", resolution)
        if resolution.ndim != 1:
            raise InvalidArray("encoder_resolution", "(k,)", resolution)
        if not (resolution >= 0.0).all():
            raise InvalidValue("encoder_resolution", resolution.tolist(), "not negative")
        self._resolution, self._period = resolution, checked_positive("period", period)
        self._coarse = resolution > 0.0
        self._is_perfect = not self._coarse.any()
        self._last: Array | None = None

    def read(self, positions: ArrayLike, speeds: ArrayLike) -> tuple[Array, Array]:
        """Return the positions (p,) and speeds (n,) that a controller sees."""
        seen, rates = finite_array("positions", positions), finite_array("speeds", speeds)
        k = len(self._resolution)
        for name, row in (("positions", seen), ("speeds", rates)):
            if row.ndim != 1 or len(row) < k:
                raise InvalidArray(name, f"(n,) of at least {k}", row)
        seen, rates = seen.copy(), rates.copy()
        if self._is_perfect:
            return seen, rates
        seen[:k], rates[:k] = self._counted(seen[:k], rates[:k])
        return seen, rates

    def _counted(self, positions: Array, speeds: Array) -> tuple[Array, Array]:
        with np.errstate(divide="ignore", invalid="ignore"):  # of perfect encoders among others
            counted = np.where(
                self._coarse,
                self._resolution * np.floor(positions / self._resolution + 0.5),
                positions,
            )
        last = counted if self._last is None else self._last
        self._last = counted
        return counted, np.where(self._coarse, (counted - last) / self._period, speeds)
