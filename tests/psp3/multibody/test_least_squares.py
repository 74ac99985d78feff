"""Factors and least squares of a group's equations, against NumPy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from psp3.multibody.flatten import _ends
from psp3.multibody.least_squares import factor, orientation, reflect, solve, solve_transposed
from tests.helpers import Array

SEEDS = st.integers(0, 2**32 - 1)


class Factored:
    """A matrix as kernels hold it, column by column, with its reflections and a right side."""

    def __init__(self, matrix: Array, pattern: Array | None = None) -> None:
        rows, columns = self.shape = matrix.shape
        pattern = np.ones(matrix.shape, dtype=bool) if pattern is None else pattern
        entries = {(int(i), int(j)) for i, j in np.argwhere(pattern)}
        self.ends = np.array(_ends(rows, columns, entries), dtype=np.int64)
        self.memory = np.concatenate(
            [matrix.T.ravel(), np.full(columns, np.nan), np.full(max(rows, columns), np.nan)]
        )
        self.places = rows * columns, rows * columns + columns
        self.pivot = factor(self.ends, self.memory, 0, 0, self.places[0], rows, columns)

    @property
    def _after(self) -> tuple[Any, ...]:
        return self.ends, self.memory, 0, 0, self.places[0], *self.shape, self.places[1]

    @property
    def right(self) -> Array:
        """The right side, and then the solution."""
        return self.memory[self.places[1] :]

    def solved(self, right: Array) -> Array:
        """Return the solution by least squares."""
        self.right[: len(right)] = right
        solve(*self._after)
        return self.right[: self.shape[1]].copy()

    def solved_transposed(self, right: Array) -> Array:
        """Return the shortest solution of the transposed equations."""
        self.right[: len(right)] = right
        solve_transposed(*self._after)
        return self.right[: self.shape[0]].copy()


def random_matrix(seed: int, legs: list[int], shared: int, extra: int) -> tuple[Array, Array]:
    """Return a matrix of legs with columns of their own, and columns that all share.

    Its rows are those of the legs, in order, with as many as it has columns and some more; the
    pattern says what is not zero.
    """
    rng = np.random.default_rng(seed)
    columns = sum(legs) + shared
    pattern = np.zeros((0, columns), dtype=bool)
    for leg, width in enumerate(legs):
        first = sum(legs[:leg])
        rows = np.zeros((width + (shared if leg == len(legs) - 1 else 0) + extra, columns), bool)
        rows[:, first : first + width] = True
        rows[:, columns - shared :] = True
        pattern = np.concatenate([pattern, rows])
    return np.where(pattern, rng.normal(size=pattern.shape), 0.0), pattern


SHAPES = st.tuples(
    SEEDS, st.lists(st.integers(1, 4), min_size=1, max_size=4), st.integers(0, 3), st.integers(0, 2)
)


@given(SHAPES)
def test_solution_is_that_of_least_squares(shape: Any) -> None:
    """Of legs with zeros in the others' columns; 1e-12 times the square of the condition number."""
    matrix, pattern = random_matrix(*shape)
    condition = np.linalg.cond(matrix)
    assume(condition < 1e4)
    right = np.random.default_rng(1).normal(size=len(matrix))
    found = Factored(matrix, pattern).solved(right)
    expected = np.linalg.lstsq(matrix, right, rcond=None)[0]
    assert_allclose(found, expected, rtol=0.0, atol=1e-13 * condition**2 + 1e-13)
    # Zeros that are skipped change nothing but rounding.
    assert_allclose(Factored(matrix).solved(right), found, rtol=0.0, atol=1e-13 * condition**2)


@given(SHAPES)
def test_rows_that_repeat_others_change_nothing(shape: Any) -> None:
    matrix, _ = random_matrix(*shape)
    condition = np.linalg.cond(matrix)
    assume(condition < 1e4)
    right = matrix @ np.random.default_rng(2).normal(size=matrix.shape[1])
    found = Factored(np.concatenate([matrix, matrix])).solved(np.concatenate([right, right]))
    assert_allclose(
        found, Factored(matrix).solved(right), rtol=0.0, atol=1e-13 * condition**2 + 1e-13
    )


@given(SHAPES)
def test_transposed_solution_is_the_shortest(shape: Any) -> None:
    """Of the equations Aᵀ x = y by NumPy's pseudo-inverse, which is the one of least length."""
    matrix, pattern = random_matrix(*shape)
    condition = np.linalg.cond(matrix)
    assume(condition < 1e4)
    right = np.random.default_rng(3).normal(size=matrix.shape[1])
    found = Factored(matrix, pattern).solved_transposed(right)
    expected = np.linalg.pinv(matrix.T) @ right
    assert_allclose(found, expected, rtol=0.0, atol=1e-13 * condition**2 + 1e-13)


@given(SEEDS, st.integers(1, 8))
def test_signs_are_those_of_the_determinant(seed: int, order: int) -> None:
    """Of the pivot and of elimination with pivoting, against NumPy's."""
    matrix = np.random.default_rng(seed).normal(size=(order, order))
    sign, logarithm = np.linalg.slogdet(matrix)
    assume(np.linalg.cond(matrix) < 1e6)
    factored = Factored(matrix)
    assert np.sign(factored.pivot) == sign
    assert orientation(matrix.T.ravel(), 0, order) == sign
    # The pivots' product is the determinant.
    diagonal = factored.memory[: order**2].reshape(order, order).diagonal()
    assert_allclose(np.log(np.abs(diagonal)).sum(), logarithm, rtol=0.0, atol=1e-9)
    assert abs(factored.pivot) == np.abs(diagonal).min()


def test_signs_of_permutations_and_zeros() -> None:
    """Where elimination must exchange columns, and where there is nothing to eliminate."""
    swap = np.array([[0.0, 1.0], [1.0, 0.0]])
    assert Factored(swap).pivot == -1.0
    assert orientation(swap.ravel(), 0, 2) == -1.0
    assert Factored(np.diag([1.0, -2.0, 3.0])).pivot == -1.0
    assert orientation(np.diag([1.0, -2.0, 3.0]).ravel(), 0, 3) == -1.0
    assert orientation(np.zeros(4), 0, 2) == 0.0
    assert orientation(np.zeros(0), 0, 0) == 1.0


@given(SEEDS, st.sampled_from([1e-10, 1e-12, 0.0]))
def test_dependent_columns_are_seen(seed: int, new: float) -> None:
    rng = np.random.default_rng(seed)
    matrix = rng.normal(size=(6, 3))
    matrix[:, 2] = matrix[:, 0] - 2.0 * matrix[:, 1] + new * rng.normal(size=6)
    assert Factored(matrix).pivot == 0.0


@pytest.mark.parametrize("matrix", [np.ones((3, 2)), np.zeros((2, 2)), np.full((3, 3), np.nan)])
def test_ones_nothing_and_no_numbers_have_no_independent_columns(matrix: Array) -> None:
    assert Factored(matrix).pivot == 0.0


def test_a_column_that_is_new_by_a_millionth_is_independent() -> None:
    """It leaves six digits."""
    matrix = np.array([[1.0, 1.0], [0.0, 1e-6]])
    assert_allclose(abs(Factored(matrix).pivot), 1e-6, rtol=1e-9)


def test_reflections_are_those_of_the_factors() -> None:
    """One after the other they bring each column to R, and keep lengths; 1e-14."""
    matrix = np.random.default_rng(4).normal(size=(5, 3))
    factored = Factored(matrix)
    upper = np.triu(factored.memory[:15].reshape(3, 5).T[:3])
    for column in range(3):
        factored.right[:] = matrix[:, column]
        for k in range(3):
            reflect(
                factored.ends, factored.memory, 0, 0, factored.places[0], 5, k, factored.places[1]
            )
        expected = np.concatenate([upper[:, column], np.zeros(2)])
        assert_allclose(factored.right, expected, rtol=0.0, atol=1e-14)
