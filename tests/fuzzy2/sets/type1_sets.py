"""Type-1 sets of every kind, for the tests of what all of them can do."""

from __future__ import annotations

import math

import numpy as np

from fuzzy2.sets.derived import Complement, FunctionalSet, Truncated
from fuzzy2.sets.lagged import Lagged
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.sigmoids import Sigmoid, SigmoidDifference, SigmoidProduct
from fuzzy2.sets.smooth_shapes import Bell, PiShaped, TwoSidedGaussian
from fuzzy2.sets.type1 import SampledSet, Singleton, Type1Set


def parabola(x: np.ndarray) -> np.ndarray:
    return np.maximum(1.0 - x**2, 0.0)


SETS: dict[str, Type1Set] = {
    "gaussian": Gaussian(mean=0.3, sigma=0.7),
    "low gaussian": Gaussian(mean=-2.0, sigma=0.1, height=0.6),
    "triangular": Triangular(left=-1.0, peak=0.5, right=3.0),
    "low triangular": Triangular(left=-1.0, peak=0.5, right=3.0, height=0.4),
    "right-angled": Triangular(left=0.0, peak=0.0, right=2.0),
    "trapezoidal": Trapezoidal(0.0, 1.0, 2.0, 4.0),
    "left shoulder": Trapezoidal(0.0, 0.0, 2.0, 4.0, height=0.8),
    "endless shoulder": Trapezoidal(-math.inf, -math.inf, 1.0, 2.0),
    "bell": Bell(center=1.0, width=2.0, slope=2.5),
    "rising sigmoid": Sigmoid(center=1.0, slope=3.0),
    "falling sigmoid": Sigmoid(center=1.0, slope=-3.0),
    "singleton": Singleton(0.25),
    "interval": Interval(-1.0, 2.0),
    "point": Interval(2.0, 2.0),
    "sampled": SampledSet([3.0, 0.0, 1.0], [0.0, 0.0, 0.9]),
    "functional": FunctionalSet(parabola, -1.0, 1.0),
    "truncated": Truncated(Gaussian(0.2, 0.4), 0.0, 1.0),
    "pi": PiShaped(-1.0, 0.5, 1.0, 3.0),
    "low s": PiShaped(-1.0, 2.0, math.inf, math.inf, height=0.7),
    "z": PiShaped(-math.inf, -math.inf, 0.0, 2.0),
    "two-sided gaussian": TwoSidedGaussian(mean=(0.0, 1.0), sigma=(0.5, 1.5)),
    "crossed gaussian": TwoSidedGaussian(mean=(1.0, 0.0), sigma=(0.5, 1.5)),
    "gaussian shoulder": TwoSidedGaussian(mean=(1.0, 1.0), sigma=(math.inf, 0.5)),
    "sigmoid difference": SigmoidDifference(center=(-1.0, 2.0), slope=(5.0, 5.0)),
    "sigmoid product": SigmoidProduct(center=(-1.0, 2.0), slope=(4.0, -9.0)),
    "rising sigmoid product": SigmoidProduct(center=(-1.0, 2.0), slope=(4.0, 9.0)),
    "not z": Complement(PiShaped(-math.inf, -math.inf, 0.0, 2.0)),
    "not rising sigmoid": Complement(Sigmoid(1.0, 3.0)),
    "lagged": Lagged(Gaussian(0.3, 0.7), (0.2, 0.5), 0.8),
    "scaled bell": Lagged(Bell(1.0, 2.0, 2.5), (0.0, 0.0), 0.5),
    "lagged sigmoid": Lagged(Sigmoid(1.0, 3.0), (0.3, 0.0), 0.9),
}
