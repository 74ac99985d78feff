"""C as the derivative of a learned M, against differences of M."""

from __future__ import annotations

import numpy as np
import pytest

from psp3.fuzzy_control.christoffel_kernels import christoffel_room, derived, write_christoffel


@pytest.mark.parametrize("joints", [1, 2, 3])
def test_c_is_made_of_christoffel_symbols_and_m_dot_less_twice_c_is_skew(joints: int) -> None:
    """M by numbers at either side; error of central differences 1e-5 squared, rounding 1e-10."""
    rng, h, rules = np.random.default_rng(joints), 1e-5, 6
    means, sigmas = rng.normal(size=(rules, joints)), rng.uniform(0.5, 2.0, (rules, joints))
    entries = joints * (joints + 1) // 2
    mass = rng.normal(size=(rules, entries))
    ranges = np.array([[-9.0] * joints, [9.0] * joints])
    data = derived(np.arange(joints), ranges, means, sigmas, mass)
    places = np.stack([np.arange(joints), np.full(joints, -1)]).astype(float)
    first, second = np.triu_indices(joints)

    def matrix(a: np.ndarray) -> np.ndarray:
        firing = np.exp(-0.5 * (((a - means) / sigmas) ** 2).sum(axis=-1))
        out = np.zeros((joints, joints))
        out[first, second] = out[second, first] = firing / firing.sum() @ mass
        return out

    a, v = rng.normal(size=(2, joints))
    numbers = np.zeros(entries + joints**2 + joints)
    room = np.empty(christoffel_room(data, joints))
    write_christoffel(data, places, a, v, room, numbers)
    C = numbers[entries : entries + joints**2].reshape(joints, joints)
    rates = np.array([(matrix(a + h * e) - matrix(a - h * e)) / (2 * h) for e in np.eye(joints)])
    expected = 0.5 * (
        np.einsum("kij,k->ij", rates, v)
        + np.einsum("jik,k->ij", rates, v)
        - np.einsum("ijk,k->ij", rates, v)
    )
    np.testing.assert_allclose(C, expected, atol=1e-8)
    twice = np.einsum("kij,k->ij", rates, v) - 2.0 * C
    np.testing.assert_allclose(twice, -twice.T, atol=1e-8)
