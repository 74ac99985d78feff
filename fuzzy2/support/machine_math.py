"""Functions of ``math`` as in compiled code, with a result for every number.

Python's functions raise an error if there is no finite result, and their results are plain floats,
which raise an error when divided by zero. ``hypot`` is that of the C library, because Python's
rounds differently.
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
            # The functions listed here are undefined there; none of them has a pole.
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
