"""Two sets and a system, for the tests of figures of them."""

from __future__ import annotations

from fuzzy2.sets.functional_type2 import FunctionalType2Set
from fuzzy2.sets.gaussian_type2 import GaussianType2Set
from fuzzy2.sets.interval_type2 import (
    GaussianUncertainMean,
)
from fuzzy2.sets.shapes import Gaussian, Triangular
from fuzzy2.systems import IntervalType2System

FUZZY = GaussianType2Set(principal=Gaussian(5.0, 1.0), sigma=0.1)

TRIANGLES = FunctionalType2Set(lambda x: Triangular(0.2, 0.5, 0.9), 0.0, 2.0)

TERMS = [GaussianUncertainMean(mean=(m - 0.1, m + 0.1), sigma=0.5) for m in (-1.0, 0.0, 1.0)]

RULES = [[i, j] for i in range(3) for j in range(3)]

CONSEQUENTS = [[i * j + 0.5 * i, -1.0] for i, j in RULES]

SYSTEM = IntervalType2System(
    [TERMS, TERMS],
    RULES,
    CONSEQUENTS,
    input_names=["a [m]", "b [m]"],
    output_names=["force [N]", "other"],
)
