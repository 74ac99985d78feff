"""Consequents of rules: numbers, sets, and linear functions of the inputs."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import InvalidValue
from fuzzy2.sets.general_type2 import GeneralType2Set
from fuzzy2.support.checks import Array, reals
from fuzzy2.systems.terms import AnySet


class Linear:
    r"""Consequents of Takagi, Sugeno and Kang.

    :math:`z_{rj}(x) = c_{rj0} + \sum_i c_{rji} x_i`, with a spread if they are intervals.

    Parameters
    ----------
    coefficients : (R, m, p + 1) array_like
        Constant term first, then the slopes.
    spreads : (R, m, p + 1) array_like, optional
        Half-widths of the coefficients; then :math:`z` is an interval of half-width
        :math:`s_{rj0} + \sum_i s_{rji} |x_i|`.
    """

    def __init__(self, coefficients: ArrayLike, spreads: ArrayLike | None = None) -> None:
        self.coefficients = np.array(reals("coefficients", coefficients))
        self.spreads = np.array(
            np.zeros_like(self.coefficients) if spreads is None else reals("spreads", spreads)
        )
        # A system that has them does not change.
        self.coefficients.flags.writeable = self.spreads.flags.writeable = False
        if self.coefficients.ndim != 3 or not np.isfinite(self.coefficients).all():
            raise InvalidValue(
                "coefficients", self.coefficients, "finite numbers of shape (R, m, p + 1)"
            )
        if (
            self.spreads.shape != self.coefficients.shape
            or not (self.spreads >= 0.0).all()
            or not np.isfinite(self.spreads).all()
        ):
            raise InvalidValue(
                "spreads", self.spreads, "finite, not negative, of the shape of the coefficients"
            )

    def at(self, X: Array) -> Array:
        """Return the consequents (n, R, m, 2) at inputs (n, p)."""
        with_constant = np.concatenate([np.ones((len(X), 1)), X], axis=1)
        middle = np.einsum("rmi,ni->nrm", self.coefficients, with_constant)
        spread = np.einsum("rmi,ni->nrm", self.spreads, np.abs(with_constant))
        return np.stack([middle - spread, middle + spread], axis=-1)


def as_sets(consequents: Any) -> list[list[Any]] | None:
    """Return sets as a list of lists, or None if they are no sets."""
    if isinstance(consequents, np.ndarray) and consequents.dtype.kind != "O":
        return None
    try:
        rows = [
            [row] if isinstance(row, AnySet) or row is None else list(row) for row in consequents
        ]
    except TypeError:
        return None
    if not any(isinstance(item, AnySet) for row in rows for item in row):
        return None
    return rows


def centroid_interval(item: Any) -> tuple[float, float]:
    """Centroid of a consequent, which is computed once.

    Of a general type-2 set that of its lowest plane.
    """
    ends = np.ravel(
        item.alpha_plane(1.0).centroid() if isinstance(item, GeneralType2Set) else item.centroid()
    )
    return float(ends[0]), float(ends[-1])
