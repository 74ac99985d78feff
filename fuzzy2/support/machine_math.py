"""Functions of ``math`` as compiled code has them: with an answer for every number.

Python's own raise errors where there is no finite answer, and their results are plain numbers,
which cannot be divided by zero. ``hypot`` is the C library's; Python's is another.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from math import inf as inf
from math import isfinite as isfinite
from math import nan as nan

import numpy as np

Number = np.float64


def _of_the_machine(function: Callable[..., float]) -> Callable[..., Number]:
    def answered(*numbers: float) -> Number:
        try:
            return Number(function(*numbers))
        except ValueError:
            # Of functions that have no value there; none of them has a pole.
            return Number(nan)

    return answered


sqrt = _of_the_machine(math.sqrt)
sin = _of_the_machine(math.sin)
cos = _of_the_machine(math.cos)
tan = _of_the_machine(math.tan)
atan = _of_the_machine(math.atan)
atan2 = _of_the_machine(math.atan2)


def hypot(x: float, y: float) -> Number:
    """Return the length of a vector in the plane."""
    return Number(np.hypot(x, y))
