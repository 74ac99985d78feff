r"""Gaussian premises as a vector of parameters, with the basis functions of linear consequents.

Under the product the logarithm of a rule's firing is a sum. So the shares of the rules,

.. math:: \phi_r = \frac{w_r}{\sum_s w_s}, \qquad
          \log w_r = -\frac{1}{2} \sum_i \frac{u_{ri}^2}{\sigma_{ri}^2},

are accurate even if all firing strengths are tiny. With uncertain means :math:`m \pm \rho`, the
distance :math:`|u| = |x - m|` is smaller by :math:`\rho` in the upper membership (but not below 0)
and larger by :math:`\rho` in the lower membership. Both ends of the type-reduced interval are then
averages :math:`\sum_r \phi_r z_r`, with upper weights on one side of the end and lower weights on
the other. They are found exactly, and the output is their middle. For fixed switch points it is
linear in the consequents, and its derivatives are those of the averages.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy2.reduction.interval import generalized_centroid
from fuzzy2.support.checks import Array


class End(NamedTuple):
    """Shares of the rules at one end of the interval, and which of their weights are upper ones."""

    shares: Array
    """Shares (N, R); each row adds up to 1."""
    takes_upper: NDArray[np.bool_] | None
    """Whether a weight is the upper one, (N, R); None if upper and lower weights are equal."""


class Grades(NamedTuple):
    """Scaled distances of samples from terms, (N, T), for the lower and the upper membership."""

    lower: Array
    upper: Array


class Premises:
    """Terms and rules; means and logarithms of standard deviations are parameters.

    Parameters
    ----------
    owners : (T,) ndarray of int
        Number of the input of each term.
    rules : (R, p) ndarray of int
        Number of each input's term in each rule, among all T terms.
    reaches : (T,) ndarray
        Uncertainty of each mean on either side, at least 0; it is not learned.
    """

    def __init__(self, owners: NDArray[np.int64], rules: NDArray[np.int64], reaches: Array) -> None:
        self.owners, self.rules, self.reaches = owners, rules, reaches
        self.uses = np.zeros((len(rules), len(owners)))
        self.uses[np.arange(len(rules))[:, np.newaxis], rules] = 1.0
        self.is_interval = bool((reaches > 0.0).any())

    def grades(self, parameters: Array, X: Array) -> Grades:
        """Return the distances (N, T) from the terms, in standard deviations."""
        means, sigmas = self._split(parameters)
        distance = X[:, self.owners] - means
        if not self.is_interval:
            scaled = distance / sigmas
            return Grades(scaled, scaled)
        size, sign = np.abs(distance), np.where(distance < 0.0, -1.0, 1.0)
        return Grades(
            sign * (size + self.reaches) / sigmas,
            sign * np.maximum(size - self.reaches, 0.0) / sigmas,
        )

    def ends(self, grades: Grades, z: Array | None) -> list[End]:
        """Return the shares of the rules at both ends, for consequents z (N, R).

        Without uncertainty both ends have the same shares, and z is not used.
        """
        upper = -0.5 * (grades.upper**2 @ self.uses.T)
        largest = upper.max(axis=1, keepdims=True)
        high = np.exp(upper - largest)
        if not self.is_interval:
            return [End(high / high.sum(axis=1, keepdims=True), None)]
        assert z is not None
        low = np.exp(-0.5 * (grades.lower**2 @ self.uses.T) - largest)
        reduced = generalized_centroid(np.stack([z, z], axis=-1), np.stack([low, high], axis=-1))
        found = []
        for end in (0, 1):
            away = z - reduced[:, [end]]
            takes_upper = away <= 0.0 if end == 0 else away >= 0.0
            weights = np.where(takes_upper, high, low)
            mass = weights.sum(axis=1, keepdims=True)
            # By rounding, all points may lie beyond the end; the end is then the nearest point.
            lost = ~(mass[:, 0] > 0.0)
            if lost.any():
                nearest = np.abs(away[lost]).argmin(axis=1)
                takes_upper[lost, nearest] = True
                weights[lost, nearest] = mass[lost] = 1.0
            found.append(End(weights / mass, takes_upper))
        return found

    def basis(self, ends: list[End], with_constant: Array) -> Array:
        """Return the basis functions (N, R (p + 1)) of the consequents' coefficients."""
        shares = np.mean([end.shares for end in ends], axis=0)
        rows: Array = (shares[:, :, np.newaxis] * with_constant[:, np.newaxis]).reshape(
            len(shares), -1
        )
        return rows

    def slopes(self, parameters: Array, grades: Grades, ends: list[End], z: Array) -> Array:
        """Return the derivatives (N, 2 T) of the output with respect to the parameters."""
        _, sigmas = self._split(parameters)
        by_mean, by_spread = np.zeros_like(grades.upper), np.zeros_like(grades.upper)
        for shares, takes_upper in ends:
            output = (shares * z).sum(axis=1, keepdims=True)
            moved = shares * (z - output) / len(ends)
            parts = (
                [(moved, grades.upper)]
                if takes_upper is None
                else [
                    (np.where(takes_upper, moved, 0.0), grades.upper),
                    (np.where(takes_upper, 0.0, moved), grades.lower),
                ]
            )
            for part, scaled in parts:
                along = part @ self.uses
                by_mean += along * scaled / sigmas
                by_spread += along * scaled**2
        return np.concatenate([by_mean, by_spread], axis=1)

    def _split(self, parameters: Array) -> tuple[Array, Array]:
        count = len(self.owners)
        return parameters[:count], np.exp(parameters[count:])
