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


def published_series(end: int, delay: int = 170, step: float = 0.1) -> np.ndarray:
    """Return x(0), x(1), ... as the program that Jang's paper was made with prints them.

    As above, but for two differences, which chaos makes another stretch of the series: the delayed
    value stands still within a step of Runge and Kutta, and it is that of 169 steps ago, for the
    program stores the result of a step where it looks for the value of ``delay`` steps ago. Six
    digits are printed.

    Source: R. Jang, mackeyglass.c, EECS Department, UC Berkeley, 1992, as
    ``datasets/mackeyglass/mackeyglass.c`` of github.com/phmferreira/project_ST_OS_ELMK has it.
    """
    steps = round(end / step)
    x, stored = np.zeros(steps + 1), np.zeros(delay)
    x[0] = 1.2
    for k in range(steps):
        before = stored[k % delay]
        gain = 0.2 * before / (1.0 + before**10)
        k1 = gain - 0.1 * x[k]
        k2 = gain - 0.1 * (x[k] + 0.5 * step * k1)
        k3 = gain - 0.1 * (x[k] + 0.5 * step * k2)
        k4 = gain - 0.1 * (x[k] + step * k3)
        stored[k % delay] = x[k + 1] = x[k] + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return x[:: round(1.0 / step)].round(6)


def ndei(predicted: np.ndarray, truth: np.ndarray) -> float:
    """Return the nondimensional error index: root mean square error over standard deviation."""
    return float(np.sqrt(np.mean((predicted - truth) ** 2)) / truth.std())
