"""The Mackey–Glass series, and how far a prediction is from it."""

from __future__ import annotations

import numpy as np


def mackey_glass(end: int, delay: float = 17.0, step: float = 0.1) -> np.ndarray:
    """Return x(0), x(1), ... of dx/dt = 0.2 x(t - delay) / (1 + x(t - delay)^10) - 0.1 x.

    By Runge and Kutta's method with x(0) = 1.2 and nothing before.
    """
    steps, late = round(end / step), round(delay / step)
    x = np.zeros(steps + 1)
    x[0] = 1.2

    def rate(now: float, before: float) -> float:
        return 0.2 * before / (1.0 + before**10) - 0.1 * now

    for k in range(steps):
        first = x[k - late] if k >= late else 0.0
        last = x[k - late + 1] if k + 1 >= late else 0.0
        middle = 0.5 * (first + last)
        k1 = rate(x[k], first)
        k2 = rate(x[k] + 0.5 * step * k1, middle)
        k3 = rate(x[k] + 0.5 * step * k2, middle)
        k4 = rate(x[k] + step * k3, last)
        x[k + 1] = x[k] + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return x[:: round(1.0 / step)]


def ndei(predicted: np.ndarray, truth: np.ndarray) -> float:
    """Return the nondimensional error index: root mean square error over standard deviation."""
    return float(np.sqrt(np.mean((predicted - truth) ** 2)) / truth.std())
