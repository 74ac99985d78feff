"""Forces linear in the consequents: against forces and differences computed otherwise."""

from __future__ import annotations

import numpy as np
import pytest

from psp3.fuzzy_control import force_regressor as regressor


def problem(joints: int, rules: int = 5, samples: int = 7) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(joints)
    root = rng.normal(size=(rules, joints, joints))
    return {
        "means": rng.normal(size=(rules, joints)),
        "M": root @ np.swapaxes(root, 1, 2),
        "C": rng.normal(size=(rules, joints, joints)),
        "G": rng.normal(size=(rules, joints)),
        "a": rng.normal(size=(samples, joints)),
        "v": rng.normal(size=(samples, joints)),
        "w": rng.normal(size=(samples, joints)),
    }


def basis(x: np.ndarray, means: np.ndarray) -> np.ndarray:
    firing = np.exp(-0.5 * ((x[..., np.newaxis, :] - means) ** 2).sum(axis=-1))
    return np.asarray(firing / firing.sum(axis=-1, keepdims=True))


@pytest.mark.parametrize("joints", [1, 2, 3, 6])
def test_columns_times_consequents_are_the_forces(joints: int) -> None:
    """Against M a + C v + G of averaged matrices; 1e-12 is rounding of numbers near 10."""
    p = problem(joints)
    phi = basis(p["a"], p["means"])
    first, second = np.triu_indices(joints)
    found = np.einsum("sire,re->si", regressor.mass_columns(phi, p["w"]), p["M"][:, first, second])
    rows = p["C"].reshape(len(p["C"]), -1)
    found += np.einsum("sire,re->si", regressor.coriolis_columns(phi, p["v"]), rows)
    found += np.einsum("sire,re->si", regressor.gravity_columns(phi, joints), p["G"])
    for s, weights in enumerate(phi):
        M, C, G = (np.tensordot(weights, p[name], axes=1) for name in "MCG")
        np.testing.assert_allclose(found[s], M @ p["w"][s] + C @ p["v"][s] + G, atol=1e-12)


@pytest.mark.parametrize("joints", [1, 2, 3])
def test_the_derived_coriolis_force_is_that_of_lagranges_equations(joints: int) -> None:
    r"""C v = d(M v)/dt at constant v, less half the gradient of v^T M v, by central differences.

    Their error is of the order of 1e-5 squared, and rounding over 1e-5 is 1e-10.
    """
    p, h = problem(joints), 1e-5

    def mass(a: np.ndarray) -> np.ndarray:
        return np.tensordot(basis(a, p["means"]), p["M"], axes=1)

    slopes = np.stack(
        [
            (basis(p["a"] + h * e, p["means"]) - basis(p["a"] - h * e, p["means"])) / (2.0 * h)
            for e in np.eye(joints)
        ],
        axis=-1,
    )
    first, second = np.triu_indices(joints)
    columns = regressor.derived_coriolis_columns(slopes, p["v"])
    found = np.einsum("sire,re->si", columns, p["M"][:, first, second])
    for a, v, force in zip(p["a"], p["v"], found, strict=True):
        rise = (mass(a + h * v) - mass(a - h * v)) / (2.0 * h) @ v
        gradient = [
            (v @ (mass(a + h * e) - mass(a - h * e)) @ v) / (2.0 * h) for e in np.eye(joints)
        ]
        np.testing.assert_allclose(force, rise - 0.5 * np.array(gradient), atol=1e-8)


@pytest.mark.parametrize("joints", [1, 2, 3])
def test_the_derived_coriolis_force_of_other_speeds_is_that_of_christoffels_symbols(
    joints: int,
) -> None:
    """Entry by entry, of slopes that are any numbers; 1e-12 is rounding of numbers near 10."""
    p = problem(joints)
    slopes = np.random.default_rng(1).normal(size=(len(p["a"]), len(p["M"]), joints))
    first, second = np.triu_indices(joints)
    columns = regressor.derived_coriolis_columns(slopes, p["v"], p["w"])
    found = np.einsum("sire,re->si", columns, p["M"][:, first, second])
    for s, slope in enumerate(slopes):
        # D[k] is the derivative of M by position k.
        D = np.einsum("rk,rij->kij", slope, p["M"])
        for i in range(joints):
            C = [
                0.5
                * sum((D[k, i, j] + D[j, i, k] - D[i, j, k]) * p["v"][s, k] for k in range(joints))
                for j in range(joints)
            ]
            assert found[s, i] == pytest.approx(np.dot(C, p["w"][s]), abs=1e-12 * 100.0)
