"""Ridge by generalized cross-validation, against its formula term by term."""

from __future__ import annotations

import numpy as np

from fuzzy2.learning.cross_validation import RIDGES, ridge_by_cross_validation


def score(design: np.ndarray, y: np.ndarray, ridge: float) -> float:
    """V of the module, with the matrix H itself."""
    count, width = design.shape
    H = design @ np.linalg.solve(design.T @ design + ridge * np.eye(width), design.T)
    rest = np.eye(count) - H
    return float(count * ((rest @ y) ** 2).sum() / np.trace(rest) ** 2)


def test_the_ridge_has_the_least_score_and_the_coefficients_are_those_of_it() -> None:
    rng = np.random.default_rng(0)
    design = rng.normal(size=(60, 8)) * np.logspace(0, -2, 8)
    targets = design @ rng.normal(size=(8, 3)) + [0.0, 0.1, 3.0] * rng.normal(size=(60, 3))
    found, ridges = ridge_by_cross_validation(design, targets)
    largest = np.linalg.svd(design, compute_uv=False)[0] ** 2
    for j in (1, 2):
        scores = [score(design, targets[:, j], share * largest) for share in RIDGES]
        np.testing.assert_allclose(ridges[j], RIDGES[np.argmin(scores)] * largest, rtol=1e-12)
        matrix = design.T @ design + ridges[j] * np.eye(8)
        expected = np.linalg.solve(matrix, design.T @ targets[:, j])
        np.testing.assert_allclose(found[:, j], expected, rtol=1e-9, atol=1e-12)
    # Without noise next to nothing is shrunk; the more noise, the more.
    np.testing.assert_allclose(ridges[0], RIDGES[0] * largest, rtol=1e-12)
    assert ridges[1] <= ridges[2]


def test_a_triangular_factor_says_the_same_as_the_design_it_is_of() -> None:
    """With the number of samples, which it does not show; to rounding."""
    rng = np.random.default_rng(1)
    design = rng.normal(size=(90, 6)) * np.logspace(0, -2, 6)
    target = design @ rng.normal(size=(6, 1)) + rng.normal(size=(90, 1))
    factor = np.linalg.qr(np.concatenate([design, target], axis=1), mode="r")
    whole = ridge_by_cross_validation(design, target)
    found = ridge_by_cross_validation(factor[:, :-1], factor[:, -1:], 90)
    for ours, theirs in zip(found, whole, strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-9)
