"""General type-2 sets of every kind, for the tests of what all of them can do."""

from __future__ import annotations

import math

import numpy as np

from fuzzy2.sets.derived import Truncated
from fuzzy2.sets.functional_type2 import FunctionalType2Set
from fuzzy2.sets.gaussian_type2 import GaussianType2Set
from fuzzy2.sets.general_type2 import GeneralType2Set, SampledType2Set, ZSlices
from fuzzy2.sets.interval_type2 import (
    GaussianUncertainSigma,
)
from fuzzy2.sets.shapes import Gaussian, Triangular
from fuzzy2.sets.type1 import SampledSet

BLURRED = GaussianType2Set(principal=Gaussian(mean=0.0, sigma=1.0), sigma=0.1, domain=(-4.0, 4.0))

PROPORTIONAL = GaussianType2Set(
    principal=Gaussian(0.0, 1.0), sigma=lambda x: 0.2 * np.exp(-0.5 * x**2), domain=(-6.0, 6.0)
)


def triangle_at(x: float) -> Triangular:
    top = math.exp(-x * x)
    return Triangular(0.5 * top, 0.7 * top, top)


TRIANGLES = FunctionalType2Set(function=triangle_at, left=-3.0, right=3.0, knots=(0.0,))

SLICED = ZSlices(
    (0.5, 1.0), (GaussianUncertainSigma(5.0, (0.5, 1.5)), GaussianUncertainSigma(5.0, (0.8, 1.2)))
)

DISCRETE = SampledType2Set(
    [2.0, 0.0, 1.0],
    [
        SampledSet([0.0, 0.5], [1.0, 0.4]),
        SampledSet([0.2, 0.4, 0.6], [0.5, 1.0, 0.5]),
        SampledSet([0.8, 1.0], [0.7, 1.0]),
    ],
)

SETS: dict[str, GeneralType2Set] = {
    "gaussian": BLURRED,
    "gaussian of varying sigma": PROPORTIONAL,
    "crisp gaussian": GaussianType2Set(Gaussian(0.0, 1.0), 0.0),
    "functional": TRIANGLES,
    "zslices": SLICED,
    "sampled": DISCRETE,
    "partially discrete": SampledType2Set(
        [0.0, 1.0], [Triangular(0.1, 0.2, 0.5), Truncated(Gaussian(0.7, 0.1), 0.0, 1.0)]
    ),
}
