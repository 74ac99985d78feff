"""Learning rules from samples by plain loops, and samples to learn from."""

from __future__ import annotations

import itertools
import math

import numpy as np

Samples = tuple[np.ndarray, np.ndarray]


def corners_and_more(count: int = 60, inputs: int = 2, outputs: int = 3, seed: int = 0) -> Samples:
    """Random samples, and the corners of their box.

    So every cell of a grid of two terms has a sample at its center.
    """
    rng = np.random.default_rng(seed)
    X = (
        np.concatenate(
            [
                rng.uniform(-1.0, 1.0, (count, inputs)),
                list(itertools.product((-1.0, 1.0), repeat=inputs)),
            ]
        )
        * 3.0
        + 1.0
    )
    return X, rng.normal(size=(len(X), outputs))


def loops_partition(column: np.ndarray, count: int) -> list[tuple[float, float]]:
    low, high = min(column), max(column)
    distance = (high - low) / (count - 1)
    return [(low + k * distance, distance / math.sqrt(8.0 * math.log(2.0))) for k in range(count)]


def loops_grade(x: float, term: tuple[float, float]) -> float:
    return math.exp(-((x - term[0]) ** 2) / (2.0 * term[1] ** 2))


def loops_fire(
    x: np.ndarray,
    cell: tuple[int, ...],
    terms: list[list[tuple[float, float]]],
    minimum: bool = False,
) -> float:
    grades = [loops_grade(x[i], terms[i][cell[i]]) for i in range(len(cell))]
    return min(grades) if minimum else math.prod(grades)


def loops_strongest(
    X: np.ndarray, Y: np.ndarray, counts: list[int], minimum: bool
) -> dict[tuple[int, ...], np.ndarray]:
    terms = [loops_partition(X[:, i], counts[i]) for i in range(len(counts))]
    rules = {}
    for cell in itertools.product(*map(range, counts)):
        best = max(range(len(X)), key=lambda n: loops_fire(X[n], cell, terms, minimum))
        rules[cell] = Y[best]
    return rules


def loops_strict(
    X: np.ndarray, Y: np.ndarray, counts: list[int], output_count: int | None
) -> dict[tuple[int, ...], np.ndarray]:
    """Return the value, or number of the output term, of every cell that has a sample."""
    terms = [loops_partition(X[:, i], counts[i]) for i in range(len(counts))]
    rules: dict[tuple[int, ...], np.ndarray] = {}
    degrees: dict[tuple[int, ...], np.ndarray] = {}
    for x, y in zip(X, Y, strict=True):
        cell = tuple(
            max(range(counts[i]), key=lambda k: loops_grade(x[i], terms[i][k]))
            for i in range(len(counts))
        )
        for j in range(Y.shape[1]):
            degree, says = loops_fire(x, cell, terms), float(y[j])
            if output_count is not None:
                of_output = loops_partition(Y[:, j], output_count)
                says = max(range(output_count), key=lambda k: loops_grade(y[j], of_output[k]))
                degree *= loops_grade(y[j], of_output[int(says)])
            rules.setdefault(cell, np.full(Y.shape[1], np.nan))
            degrees.setdefault(cell, np.full(Y.shape[1], -1.0))
            if degree > degrees[cell][j]:
                rules[cell][j], degrees[cell][j] = says, degree
    return rules


def clouds(seed: int = 0) -> Samples:
    """Four clouds of samples of two inputs in different units.

    A straight cut along neither input tells them apart.
    """
    rng = np.random.default_rng(seed)
    middles = np.array([[0.0, 0.0], [1.0, 3.0], [2.0, 1.0], [3.0, 2.0]])
    X = (middles[:, np.newaxis] + 0.2 * rng.normal(size=(4, 25, 2))).reshape(-1, 2) * np.array(
        [1.0, 1e3]
    )
    return X, rng.normal(size=(100, 2))
