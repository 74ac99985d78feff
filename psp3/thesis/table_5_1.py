r"""What a printed mass matrix and gravity vector say about the robot they were computed for.

Table 5.1, for instance.

At one pose M is linear in the base parameters :math:`\beta`, and so is G but for the acceleration
of free fall g. A printed number is known to half a unit of its last digit, and nothing else is
known of its error: the values that explain all printed numbers fill a polytope, whose extent in any
direction two linear programs find (an interval without probabilities: it holds the true value for
sure).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from psp3 import published
from psp3.checks import Array, as_floats, checked_positive, one_row
from psp3.closure.rank import RANK_TOLERANCE, null_space
from psp3.errors import InvalidArray, InvalidValue
from psp3.identification.base_parameters import BaseParameters

ROUNDING_OF_TABLE_5_1 = 0.5e-4
"""Half a unit of the last digit of Table 5.1 [kg], [N]."""


@dataclass(frozen=True, eq=False)
class Implied:
    """What printed matrices say about base parameters.

    Parameters
    ----------
    base : BaseParameters
        The r numbers that it is about.
    null_space : (r, k) ndarray
        Changes of the base parameters, as shares of what is believed, that leave M and G as they
        are: orthonormal columns.
    misfit : float
        Largest error that no choice of values avoids, in units of the rounding: up to 1, the
        printed numbers are explained.
    nearest : (r,) ndarray
        Values that explain the printed numbers and are nearest to what is believed: with the least
        sum of squares of the changes, g's among them, as shares of what is believed. NaN if nothing
        explains the numbers.
    """

    base: BaseParameters
    null_space: Array
    misfit: float
    nearest: Array
    _rows: Array
    _misses: Array

    @property
    def rank(self) -> int:
        """Number of independent combinations of the base parameters that M and G determine."""
        return len(self.null_space) - len(self.null_space.T)

    def interval(self, combination: ArrayLike) -> tuple[float, float]:
        """Return the least and the greatest value of a combination of base parameters.

        Of those parameters that explain the printed numbers.

        Parameters
        ----------
        combination : (r,) array_like
            Its coefficients.

        Returns
        -------
        low, high : float
            Infinite where the numbers say nothing about it; NaN if nothing explains the numbers.
        """
        coefficients = one_row("combination", combination, len(self.base.columns))
        shares = coefficients * np.abs(self.base.believed)
        if not self.misfit <= 1.0:
            return np.nan, np.nan
        if np.linalg.norm(shares @ self.null_space) > RANK_TOLERANCE * np.linalg.norm(shares):
            return -np.inf, np.inf
        low, high = _extent(np.append(shares, 0.0), self._rows, self._misses)
        believed = float(coefficients @ self.base.believed)
        return believed + low, believed + high

    @property
    def gravity(self) -> tuple[float, float]:
        """Least and greatest acceleration of free fall that explain the printed numbers.

        NaN if nothing does [m/s²].
        """
        if not self.misfit <= 1.0:
            return np.nan, np.nan
        low, high = _extent(
            np.append(np.zeros(len(self.base.columns)), 1.0), self._rows, self._misses
        )
        believed = _fall(self.base)
        return believed / (1.0 + high), believed / (1.0 + low)


def implied_parameters(
    base: BaseParameters,
    positions: ArrayLike = published.TABLE_5_1_HEIGHTS[1],
    mass: ArrayLike = published.TABLE_5_1_MASS,
    gravity: ArrayLike = published.TABLE_5_1_GRAVITY,
    rounding: float = ROUNDING_OF_TABLE_5_1,
) -> Implied:
    r"""Return what a printed mass matrix and gravity vector say about base parameters.

    Those of Table 5.1 by default.

    .. math:: | M_{ij}(\beta) - M_{ij} | \le \epsilon, \qquad
              | g\, \hat G_i(\beta) - G_i | \le \epsilon

    with :math:`\hat G` the gravity at :math:`g = 1`; divided by g, the second is linear in
    :math:`\beta` and :math:`1/g`.

    Parameters
    ----------
    base : BaseParameters
        What is asked for. None of them may be believed to be zero, because changes are counted as
        shares of what is believed.
    positions : (n,) array_like
        Pose of the actuated joints that the matrices belong to [m or rad].
    mass : (n, n) array_like
        The printed mass matrix, symmetric [kg].
    gravity : (n,) array_like
        The printed gravity vector [N].
    rounding : float
        Half a unit of the last printed digit :math:`\epsilon` [kg], [N].

    Returns
    -------
    Implied

    Raises
    ------
    InvalidArray, InvalidValue
        If an argument is malformed, or the robot's model has no gravity.
    """
    robot = base.unknowns.robot
    n, count = len(robot.actuated), len(base.columns)
    pose, weight = one_row("positions", positions, n), one_row("gravity", gravity, n)
    printed = as_floats("mass", mass, f"({n}, {n})")
    if (
        printed.shape != (n, n)
        or not np.isfinite(printed).all()
        or not np.array_equal(printed, printed.T)
    ):
        raise InvalidArray("mass", f"({n}, {n}), symmetric", mass)
    checked_positive("rounding", rounding)
    believed = np.abs(base.believed)
    if not (believed > 0.0).all():
        raise InvalidValue(
            "base",
            base.names[int(np.argmin(believed))],
            "parameters that are believed to be something else than zero",
        )
    _fall(base)

    rest = np.zeros((n + 1, n))
    columns, known = base.forces_of(
        np.tile(pose, (n + 1, 1)), rest, np.concatenate([np.eye(n), rest[:1]])
    )
    upper = np.triu_indices(n)
    columns = np.concatenate([(columns[:n] - columns[n])[upper], columns[n]])
    known = np.concatenate([(known[:n] - known[n])[upper], known[n]])
    numbers = np.concatenate([printed[upper], weight])
    # What is looked for are changes from what is believed: of base parameters and of 1/g, as
    # shares. An error of G is divided by the change of g here, too, which is of second order.
    rows = (
        np.column_stack(
            [columns * believed, np.where(np.arange(len(numbers)) < len(upper[0]), 0.0, -numbers)]
        )
        / rounding
    )
    misses = (numbers - known - columns @ base.believed) / rounding
    misfit, nearest = _misfit(rows, misses), np.full(count, np.nan)
    if misfit <= 1.0:
        nearest = base.believed + believed * _least_changes(rows, misses)[:count]
    return Implied(base, _unseen_changes(rows), misfit, nearest, rows, misses)


def _fall(base: BaseParameters) -> float:
    """Return the acceleration of free fall that the robot's model believes in."""
    fall = float(np.linalg.norm(base.unknowns.robot.model.gravity.linear))
    if fall == 0.0:
        raise InvalidValue("gravity of the model", fall, "positive")
    return fall


def _unseen_changes(rows: Array) -> Array:
    """Return the changes of base parameters that no printed number shows, whatever g is."""
    unseen = null_space(rows, RANK_TOLERANCE)[:-1]
    basis, lengths, _ = np.linalg.svd(unseen, full_matrices=False)
    return np.asarray(basis[:, lengths > RANK_TOLERANCE], dtype=np.float64)


def _misfit(rows: Array, misses: Array) -> float:
    """Return the least t for which changes x exist with all | rows x - misses | up to t."""
    ones = np.ones((len(rows), 1))
    return _solved(
        np.append(np.zeros(rows.shape[1]), 1.0),
        np.block([[rows, -ones], [-rows, -ones]]),
        np.append(misses, -misses),
    )[1]


def _extent(costs: Array, rows: Array, misses: Array) -> tuple[float, float]:
    """Return the least and the greatest value of costs · x.

    Over the changes x with all | rows x - misses | up to 1.
    """
    matrix, bounds = np.concatenate([rows, -rows]), np.append(misses, -misses) + 1.0
    return _solved(costs, matrix, bounds)[1], -_solved(-costs, matrix, bounds)[1]


def _least_changes(rows: Array, misses: Array) -> Array:
    """Return the shortest x with all | rows x - misses | up to 1.

    After C. L. Lawson and R. J. Hanson, Solving Least Squares Problems, 1974.
    """
    from scipy.optimize import nnls

    matrix, bounds = np.concatenate([-rows, rows]), np.append(-misses, misses) - 1.0
    sizes = np.linalg.norm(matrix, axis=1)
    # Least-distance programming: its dual is a least-squares problem in numbers that are not
    # negative.
    dual = np.column_stack([matrix, bounds]).T / sizes
    target = np.append(np.zeros(rows.shape[1]), 1.0)
    residual = dual @ nnls(dual, target)[0] - target
    return np.asarray(-residual[:-1] / residual[-1], dtype=np.float64)


def _solved(costs: Array, matrix: Array, bounds: Array) -> tuple[Array, float]:
    """Return the solution of a linear program and its value."""
    from scipy.optimize import linprog

    # The solver's tolerances are absolute, so every unknown is counted in a unit that a constraint
    # notices.
    units = 1.0 / np.abs(matrix).max(axis=0)
    found = linprog(costs * units, A_ub=matrix * units, b_ub=bounds, bounds=(None, None))
    return np.asarray(found.x, dtype=np.float64) * units, float(found.fun)
