r"""Bounds on a robot's parameters from a printed mass matrix and gravity vector.

Table 5.1 is the default.

At one pose M is linear in the base parameters :math:`\beta`, and so is G apart from the
acceleration of free fall g. The error of a printed number is at most half a unit of its last digit.
The parameters that agree with all printed numbers form a polytope. Two linear programs find its
extent in any direction, an interval that is certain to hold the true value.
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
    """Bounds on base parameters from printed matrices.

    Parameters
    ----------
    base : BaseParameters
        The r base parameters.
    null_space : (r, k) ndarray
        Changes of the base parameters, relative to the model's values, that do not change M and G:
        orthonormal columns.
    misfit : float
        Least possible value of the largest error, in units of the rounding. If it is at most 1,
        some parameters explain the printed numbers.
    nearest : (r,) ndarray
        Values that explain the printed numbers and are nearest to the model: they have the least
        sum of squared relative changes, including that of g. NaN if no values explain the numbers.
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
        """Return the least and greatest value of a linear combination of base parameters.

        The range is over all parameters that explain the printed numbers.

        Parameters
        ----------
        combination : (r,) array_like
            Its coefficients.

        Returns
        -------
        low, high : float
            Infinite if the numbers do not bound it; NaN if no parameters explain the numbers.
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

        NaN if none does [m/s²].
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
    r"""Return the bounds on base parameters from a printed mass matrix and gravity vector.

    The default matrices are those of Table 5.1.

    .. math:: | M_{ij}(\beta) - M_{ij} | \le \epsilon, \qquad
              | g\, \hat G_i(\beta) - G_i | \le \epsilon

    with :math:`\hat G` the gravity at :math:`g = 1`; divided by g, the second is linear in
    :math:`\beta` and :math:`1/g`.

    Parameters
    ----------
    base : BaseParameters
        The base parameters. None may be zero in the model, because changes are relative to the
        model's values.
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
            "base parameters that are not zero in the robot's model",
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
    # The unknowns are relative changes of the base parameters and of 1/g from the model's values.
    # Here an error of G is also divided by the change of g, which is an effect of second order.
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
    """Return the acceleration of free fall in the robot's model."""
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

    The changes x satisfy | rows x - misses | ≤ 1 in every row.
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

    # The solver's tolerances are absolute, so every unknown is scaled to have a noticeable effect
    # on a constraint.
    units = 1.0 / np.abs(matrix).max(axis=0)
    found = linprog(costs * units, A_ub=matrix * units, b_ub=bounds, bounds=(None, None))
    return np.asarray(found.x, dtype=np.float64) * units, float(found.fun)
