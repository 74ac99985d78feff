"""Systems that can be tuned, and samples to tune them with."""

from __future__ import annotations

from typing import Any

import numpy as np

from fuzzy2.sets.interval_type2 import GaussianUncertainMean, GaussianUncertainSigma
from fuzzy2.sets.shapes import Gaussian
from fuzzy2.systems import FuzzySystem, IntervalType2System, Linear, Type1System

RULES = np.array([[0, 0], [0, 1], [1, 0], [1, 1], [2, -1]])


def systems(rng: np.random.Generator, t_norm: str) -> dict[str, FuzzySystem]:
    """Systems with every kind of term that can be tuned.

    One rule does not use an input, and consequents are numbers, intervals or linear.
    """
    numbers = rng.normal(size=(5, 2)) * [1.0, 40.0]
    intervals = np.stack(
        [numbers - rng.uniform(0.1, 0.5, (5, 2)), numbers + rng.uniform(0.1, 0.5, (5, 2))], axis=-1
    )
    slopes = rng.normal(size=(5, 2, 2)) * [[1.0, 0.05], [30.0, 1.0]]
    linear = Linear(
        np.concatenate([numbers[..., np.newaxis], slopes], axis=-1),
        0.1 * rng.uniform(size=(5, 2, 3)),
    )
    type1 = [
        [Gaussian(-1.0, 0.8), Gaussian(1.0, 0.9), Gaussian(0.2, 1.5, height=0.7)],
        [Gaussian(-20.0, 12.0), Gaussian(15.0, 14.0)],
    ]
    mixed: list[list[Any]] = [
        [
            GaussianUncertainMean((-1.3, -0.8), 0.8),
            GaussianUncertainSigma(1.0, (0.6, 1.1)),
            Gaussian(0.2, 1.5),
        ],
        [GaussianUncertainMean((-24.0, -18.0), 12.0), GaussianUncertainMean((12.0, 19.0), 14.0)],
    ]
    return {
        "type-1": Type1System(type1, RULES, numbers, t_norm),
        "type-1, intervals": Type1System(type1, RULES, intervals, t_norm),
        "interval type-2": IntervalType2System(mixed, RULES, numbers, t_norm),
        "type-1, linear": Type1System(type1, RULES, linear, t_norm),
        "interval type-2, linear": IntervalType2System(mixed, RULES, linear, t_norm),
        "interval type-2, intervals": IntervalType2System(mixed, RULES, intervals, t_norm),
    }


def samples(rng: np.random.Generator, count: int = 40) -> tuple[np.ndarray, np.ndarray]:
    X = rng.uniform([-2.0, -30.0], [2.0, 30.0], (count, 2))
    return X, np.stack([np.sin(X[:, 0]), X[:, 1] + 5.0 * X[:, 0] ** 2], axis=1)
