"""Encoders: positions in counts, and speeds from their differences."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from psp3.checks import Array, as_floats, checked_positive, finite_array
from psp3.errors import InvalidArray, InvalidValue


class Encoder:
    """The readings that a drive has of its joints, see ``encoder_resolution`` of :func:`simulate`.

    There is one resolution for each of the first coordinates; the others are seen exactly.
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
        """Return the positions (p,) and speeds (n,) that a controller sees.

        In a motion that diverges they may be NaN.
        """
        seen, rates = as_floats("positions", positions, "(p,)"), as_floats("speeds", speeds, "(n,)")
        k = len(self._resolution)
        for name, row in (("positions", seen), ("speeds", rates)):
            if row.ndim != 1 or len(row) < k or not row.size:
                raise InvalidArray(name, f"(n,) of at least {k}", row)
        seen, rates = seen.copy(), rates.copy()
        if self._is_perfect:
            return seen, rates
        seen[:k], rates[:k] = self._counted(seen[:k], rates[:k])
        return seen, rates

    def _counted(self, positions: Array, speeds: Array) -> tuple[Array, Array]:
        # Divisions by zero come from perfect encoders among others, and from motions that diverge.
        with np.errstate(divide="ignore", invalid="ignore"):
            counted = np.where(
                self._coarse,
                self._resolution * np.floor(positions / self._resolution + 0.5),
                positions,
            )
            last = counted if self._last is None else self._last
            rates = (counted - last) / self._period
        self._last = counted
        return counted, np.where(self._coarse, rates, speeds)
