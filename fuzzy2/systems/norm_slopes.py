"""Right-hand derivatives of the t-norms that have a formula."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fuzzy2.operations.t_norms import T_NORMS, TNorm
from fuzzy2.support.checks import Array

SlopeRule = Callable[[Array, Array, Array, Array], Array]
"""Takes two grades, each followed by its derivative, and returns the derivative of their t-norm."""


def _of_product(a: Array, a_rate: Array, b: Array, b_rate: Array) -> Array:
    return a * b_rate + b * a_rate


def _of_minimum(a: Array, a_rate: Array, b: Array, b_rate: Array) -> Array:
    return np.where(a < b, a_rate, np.where(b < a, b_rate, np.minimum(a_rate, b_rate)))


def _of_lukasiewicz(a: Array, a_rate: Array, b: Array, b_rate: Array) -> Array:
    rate = a_rate + b_rate
    return np.where(a + b > 1.0, rate, np.where(a + b < 1.0, 0.0, np.maximum(rate, 0.0)))


def _of_hamacher(a: Array, a_rate: Array, b: Array, b_rate: Array) -> Array:
    union = a + b - a * b
    # Near (0, 0) the t-norm is homogeneous, like half of the harmonic mean.
    both = a_rate + b_rate
    at_zero = np.where(both > 0.0, a_rate * b_rate / np.where(both > 0.0, both, 1.0), 0.0)
    safe = np.where(union > 0.0, union, 1.0)
    return np.where(union > 0.0, (b / safe) ** 2 * a_rate + (a / safe) ** 2 * b_rate, at_zero)


def _of_einstein(a: Array, a_rate: Array, b: Array, b_rate: Array) -> Array:
    return (b * (2.0 - b) * a_rate + a * (2.0 - a) * b_rate) / (1.0 + (1.0 - a) * (1.0 - b)) ** 2


# Functions that combine the right-hand derivatives of two grades into that of their t-norm.
SLOPE_RULES: dict[TNorm, SlopeRule] = {
    T_NORMS["product"]: _of_product,
    T_NORMS["min"]: _of_minimum,
    T_NORMS["lukasiewicz"]: _of_lukasiewicz,
    T_NORMS["hamacher"]: _of_hamacher,
    T_NORMS["einstein"]: _of_einstein,
}
