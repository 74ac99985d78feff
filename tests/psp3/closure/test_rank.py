"""Ranks, null spaces and solvers against matrices whose rank is known."""

from __future__ import annotations

import numpy as np
import pytest

from psp3.closure.rank import RANK_TOLERANCE, dependent_solver, null_space, numerical_rank
from psp3.errors import SingularConfiguration


def of_rank(rank: int, rows: int, columns: int) -> np.ndarray:
    rng = np.random.default_rng(rank)
    return rng.normal(size=(rows, rank)) @ rng.normal(size=(rank, columns))


def test_rank_counts_what_is_above_its_share_of_the_largest() -> None:
    values = 5.0 * np.array([1.0, 1e-3, 2.0 * RANK_TOLERANCE, 0.5 * RANK_TOLERANCE, 0.0])
    assert numerical_rank(values) == 3
    assert numerical_rank(values, 1e-2) == 1
    assert numerical_rank(np.zeros(3)) == numerical_rank(np.zeros(0)) == 0


def test_null_space_is_orthonormal_and_all_that_vanishes() -> None:
    matrix = of_rank(3, 6, 5)
    basis = null_space(matrix, 1e-9)
    assert basis.shape == (5, 2)
    np.testing.assert_allclose(basis.T @ basis, np.eye(2), atol=1e-14)
    np.testing.assert_allclose(matrix @ basis, 0.0, atol=1e-13)
    np.testing.assert_array_equal(null_space(np.zeros((0, 4)), 1e-9), np.eye(4))
    # A matrix that is small against the given size vanishes altogether.
    assert null_space(1e-12 * matrix, 1e-9, size=1.0).shape == (5, 5)


def test_the_solver_solves_what_has_a_solution() -> None:
    """Eq. 3.23: the inverse, and with redundant rows the least-squares solution; 1e-12."""
    square, tall = of_rank(4, 4, 4), of_rank(4, 7, 4)
    np.testing.assert_allclose(dependent_solver(square) @ square, np.eye(4), atol=1e-12)
    np.testing.assert_allclose(dependent_solver(tall), np.linalg.pinv(tall), atol=1e-12)
    x = np.arange(4.0)
    np.testing.assert_allclose(dependent_solver(tall) @ (tall @ x), x, atol=1e-12)
    assert dependent_solver(np.zeros((3, 0))).shape == (0, 3)


@pytest.mark.parametrize(
    ("matrix", "rank"), [(of_rank(3, 6, 4), 3), (of_rank(2, 2, 4), 2), (np.zeros((0, 4)), 0)]
)
def test_columns_that_depend_on_each_other_are_refused(matrix: np.ndarray, rank: int) -> None:
    with pytest.raises(SingularConfiguration) as caught:
        dependent_solver(matrix)
    assert (caught.value.rank, caught.value.needed) == (rank, 4)


@pytest.mark.parametrize("rows", [4, 9])
@pytest.mark.parametrize("condition", [1e1, 1e5, 1e8, 0.9e9, 1.1e9, 1e12])
def test_singular_values_decide_however_the_inverse_is_found(rows: int, condition: float) -> None:
    """Matrices of a known condition number: refused beyond 1e9, and only there.

    The inverse is right to the condition number times rounding, a hundredfold.
    """
    rng = np.random.default_rng(rows)
    left, right = (np.linalg.qr(rng.normal(size=(size, 4)))[0] for size in (rows, 4))
    values = np.array([1.0, 0.5, 0.1, 1.0 / condition])
    matrix = 3.0 * (left * values) @ right.T
    if condition * RANK_TOLERANCE > 1.0:
        with pytest.raises(SingularConfiguration) as caught:
            dependent_solver(matrix)
        assert caught.value.rank == 3
    else:
        expected = (right / values) @ left.T / 3.0
        np.testing.assert_allclose(
            dependent_solver(matrix), expected, rtol=0, atol=1e-14 * condition * condition
        )


def test_numbers_whose_squares_overflow_are_solved_without_a_warning() -> None:
    np.testing.assert_allclose(dependent_solver(1e200 * np.eye(3)), 1e-200 * np.eye(3), rtol=1e-12)
