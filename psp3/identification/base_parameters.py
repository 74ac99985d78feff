r"""Base parameters of a robot.

They are the combinations of masses and inertias that actuator forces determine.

Columns of the regressor that depend on others are combined with them. The dependencies are found
numerically, from random motions (M. Gautier, Numerical calculation of the base inertial parameters
of robots, Journal of Robotic Systems, 1991).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice

import numpy as np
from numpy.typing import ArrayLike

from psp3.checks import Array, Indices, checked_kind, checked_random, one_row
from psp3.closure.rank import RANK_TOLERANCE, numerical_rank
from psp3.errors import (
    ClosureFailed,
    JointLimitExceeded,
    SingularConfiguration,
    UncertainRank,
    UnreachablePose,
)
from psp3.identification.unknowns import Unknowns
from psp3.robots.closed_loop_robot import ClosedLoopRobot

UNREACHABLE = (ClosureFailed, JointLimitExceeded, SingularConfiguration, UnreachablePose)
"""Errors that mean that a robot cannot take a pose."""


@dataclass(frozen=True, eq=False)
class BaseParameters:
    r"""Combinations :math:`\beta = K\, \pi` of unknowns on which the actuator forces depend.

    The forces are :math:`\tau = Y_\beta\, \beta + Y \theta_0`.

    Parameters
    ----------
    unknowns : Unknowns
        The p unknowns that are combined.
    columns : (r,) ndarray of int
        The unknown that comes first in each combination, with coefficient 1; it is in no other
        combination.
    grouping : (r, p) ndarray
        The matrix K.
    """

    unknowns: Unknowns
    columns: Indices
    grouping: Array

    @property
    def names(self) -> tuple[str, ...]:
        """The combinations in words, such as ``nut_mass + 3 ball_mass``."""
        return tuple(
            _in_words(row, self.unknowns.names, int(first))
            for row, first in zip(self.grouping, self.columns, strict=True)
        )

    @property
    def believed(self) -> Array:
        """Values that the robot's model has, (r,)."""
        return self.values(self.unknowns.believed)

    @property
    def undetermined(self) -> tuple[str, ...]:
        """Names of the unknowns that do not affect any actuator force."""
        used = np.count_nonzero(self.grouping, axis=0)
        return tuple(
            name for name, count in zip(self.unknowns.names, used, strict=True) if not count
        )

    def values(self, unknowns: ArrayLike) -> Array:
        r"""Return :math:`\beta = K\, \pi` for values (p,) of the unknowns."""
        values: Array = self.grouping @ one_row("unknowns", unknowns, len(self.unknowns.names))
        return values

    def forces_of(
        self, positions: ArrayLike, speeds: ArrayLike, accelerations: ArrayLike
    ) -> tuple[Array, Array]:
        r"""Return the matrix :math:`Y_\beta` (..., n, r) and known forces (..., n).

        The latter are the forces of the known parameters.

        Arguments and errors are those of :func:`psp3.identification.regressor.regressor`.
        """
        full, known = self.unknowns.forces_of(positions, speeds, accelerations)
        return full[..., self.columns], known

    def nearest(self, values: ArrayLike) -> Array:
        r"""Return the unknowns with given base parameters that are nearest to the model's values.

        .. math:: \min_\pi \sum_j \Big( \frac{\pi_j - \hat\pi_j}{s_j} \Big)^2
                  \quad \text{subject to} \quad K\, \pi = \beta

        The scale :math:`s_j` is :math:`|\hat\pi_j|`, or a thousandth of the smallest nonzero value
        if :math:`\hat\pi_j` is zero. So a combination that the forces cannot resolve is divided in
        proportion to the model's values, which is one of many choices that the forces allow.

        Parameters
        ----------
        values : (r,) array_like
            Base parameters.

        Returns
        -------
        (p,) ndarray
        """
        believed = self.unknowns.believed
        sizes = np.abs(believed)
        scales = np.where(sizes > 0.0, sizes, 1e-3 * np.min(sizes[sizes > 0.0], initial=1.0))
        change = one_row("values", values, len(self.columns)) - self.believed
        # Rows are scaled, too, because they have different units, kg and kg m².
        rows = np.linalg.norm(self.grouping * scales, axis=1)
        scaled: Array = np.linalg.pinv(
            self.grouping * scales / rows[:, np.newaxis], rcond=1e-14
        ) @ (change / rows)
        return np.asarray(believed + scales * scaled)


def base_parameters(unknowns: Unknowns, rng: np.random.Generator | None = None) -> BaseParameters:
    """Return the base parameters of a robot, found from its regressor at random motions.

    Parameters
    ----------
    unknowns : Unknowns
        The unknowns to identify.
    rng : numpy.random.Generator, optional
        Source of the random motions; by default the same at every call.

    Returns
    -------
    BaseParameters
        The first unknown of each combination follows from the order of the unknowns.

    Raises
    ------
    UncertainRank
        If rounding hides how many combinations there are.
    """
    checked_kind("unknowns", unknowns, Unknowns, "Unknowns, such as all_parameters(robot)")
    checked_random(rng)
    source = np.random.default_rng(0) if rng is None else rng
    robot, count = unknowns.robot, len(unknowns.names)
    n = len(robot.actuated)
    rows = 10 + 4 * count // n
    motions = np.array(list(islice(_random_motions(robot, source), rows)))
    stacked = unknowns.forces_of(*motions.transpose(1, 0, 2))[0].reshape(-1, count)
    return BaseParameters(unknowns, *independent_columns(stacked))


def independent_columns(matrix: Array) -> tuple[Indices, Array]:
    r"""Return the first independent columns, and the dependence of all columns on them.

    With :math:`W_1` the r independent columns, :math:`W = W_1 K`. A column of W, of shape (N, p),
    counts as dependent if the part of it that is orthogonal to the columns before it is less than
    1e-9 of its length.

    Returns
    -------
    columns : (r,) ndarray of int
    grouping : (r, p) ndarray
        The matrix K, with the unit matrix in the r columns.

    Raises
    ------
    UncertainRank
        If the singular values give another rank.
    """
    lengths = np.linalg.norm(matrix, axis=0)
    lengths[lengths <= RANK_TOLERANCE * lengths.max(initial=0.0)] = np.inf
    scaled = matrix / lengths
    basis = np.zeros((len(matrix), 0))
    columns: list[int] = []
    for j, column in enumerate(scaled.T):
        left = column
        # a second time, because the first pass leaves rounding errors as large as the wanted part
        for _ in range(2):
            left = left - basis @ (basis.T @ left)
        size = float(np.linalg.norm(left))
        if size > RANK_TOLERANCE:
            basis, columns = np.column_stack([basis, left / size]), [*columns, j]
    values = np.linalg.svd(scaled, compute_uv=False)
    rank = numerical_rank(values)
    if rank != len(columns):
        raise UncertainRank(len(columns), rank, values)
    found = np.array(columns, dtype=np.int64)
    grouping = np.linalg.lstsq(scaled[:, found], scaled, rcond=None)[0]
    grouping[np.abs(grouping) < RANK_TOLERANCE] = 0.0
    grouping = grouping * np.where(np.isinf(lengths), 0.0, lengths) / lengths[found, np.newaxis]
    grouping[:, found] = np.eye(rank)
    return found, grouping


def _random_motions(robot: ClosedLoopRobot, rng: np.random.Generator) -> Iterator[Array]:
    """Yield motions (3, n) at random poses that the robot can take.

    A motion is positions, speeds and accelerations.
    """
    lower, upper = robot.limits
    reference, n = robot.reference, len(robot.actuated)
    lower, upper = (
        np.where(np.isfinite(lower), lower, reference - 1.0),
        np.where(np.isfinite(upper), upper, reference + 1.0),
    )
    while True:
        # Moved toward the reference pose by a random share, because the robot can seldom reach the
        # corners of the limits.
        position = reference + rng.uniform() * (rng.uniform(lower, upper) - reference)
        try:
            robot.closure(position)
        except UNREACHABLE:
            continue
        yield np.stack([position, rng.normal(size=n), 10.0 * rng.normal(size=n)])


def _in_words(coefficients: Array, names: tuple[str, ...], first: int) -> str:
    """Return a sum such as ``m(a1) + 0.5 m(b1)``, in the order of the combination."""
    order = [first, *(j for j in range(len(names)) if coefficients[j] != 0.0 and j != first)]
    words = ""
    for j in order:
        size = abs(coefficients[j])
        sign = (
            ("-" if coefficients[j] < 0.0 else "")
            if not words
            else (" - " if coefficients[j] < 0.0 else " + ")
        )
        words += sign + ("" if abs(size - 1.0) < 1e-6 else f"{size:.4g} ") + names[j]
    return words
