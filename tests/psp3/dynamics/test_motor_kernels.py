"""Shortest motor forces, compiled, against NumPy's pseudo-inverse."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from psp3.dynamics.motor_kernels import shortest


@given(
    rows=st.integers(1, 6),
    motors=st.integers(1, 6),
    rank=st.integers(1, 6),
    seed=st.integers(0, 10**6),
)
def test_forces_are_those_of_the_pseudo_inverse(
    rows: int, motors: int, rank: int, seed: int
) -> None:
    """Of matrices of any rank, and what they can do; 1e-12 times their condition, below 1e4."""
    rng = np.random.default_rng(seed)
    rank = min(rank, rows, motors)
    left, right = (np.linalg.qr(rng.normal(size=(n, n)))[0][:, :rank] for n in (rows, motors))
    matrix = left @ np.diag(10.0 ** rng.uniform(-2.0, 2.0, rank)) @ right.T
    wanted, out = matrix @ rng.normal(size=motors), np.empty(motors)
    assert shortest(matrix, wanted, out)
    expected = np.linalg.pinv(matrix, rcond=1e-9) @ wanted
    assert_allclose(out, expected, rtol=0.0, atol=1e-8 * np.abs(expected).max(initial=1e-3))


@given(seed=st.integers(0, 10**6))
def test_what_motors_cannot_do_is_refused(seed: int) -> None:
    """Two motors that do the same along three coordinates, and forces that are not of that kind."""
    rng = np.random.default_rng(seed)
    column, share = rng.normal(size=3), rng.uniform(0.5, 2.0)
    matrix, out = np.stack([column, share * column], axis=1), np.empty(2)
    across = np.cross(column, rng.normal(size=3))
    assert shortest(matrix, 2.0 * column, out)
    assert_allclose(matrix @ out, 2.0 * column, rtol=0.0, atol=1e-12)
    assert not shortest(matrix, 2.0 * column + across / np.linalg.norm(across), out)
    assert not shortest(matrix, np.full(3, np.nan), out)


def test_motors_that_do_nothing_do_what_is_nothing() -> None:
    out = np.empty(2)
    assert shortest(np.zeros((1, 2)), np.zeros(1), out)
    assert not out.any()
    assert not shortest(np.zeros((1, 2)), np.ones(1), out)
