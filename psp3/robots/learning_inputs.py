"""The inputs from which the M, C and G of a robot can be learned."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from psp3.checks import Array, Indices


class LearningInputs(NamedTuple):
    r"""Inputs of the learned dynamics of a robot, and which matrices depend on which inputs.

    Each input is a position or a speed, or the difference of two,

    .. math:: x_i = s_{p_i} - s_{m_i}, \qquad s = (a, \dot a).

    Parameters
    ----------
    names : tuple of str
        Names of the p inputs.
    plus, minus : (p,) ndarray of int
        Places in positions and speeds (2n,); -1 of ``minus`` for none.
    of_mass_and_gravity : tuple of int
        Numbers of the inputs that M and G depend on.
    of_coriolis : tuple of int
        Numbers of the inputs that C depends on. If these are the same, one rule base is enough.
    """

    names: tuple[str, ...]
    plus: Indices
    minus: Indices
    of_mass_and_gravity: tuple[int, ...]
    of_coriolis: tuple[int, ...]

    def of(self, positions: Array, speeds: Array) -> Array:
        """Return the inputs (..., p) at positions and speeds, (..., n) each."""
        state = np.concatenate([positions, speeds], axis=-1)
        less = np.where(self.minus >= 0, state[..., self.minus], 0.0)
        return np.asarray(state[..., self.plus] - less)


def positions_and_speeds(joints: Sequence[str]) -> LearningInputs:
    """Return inputs that serve any robot.

    M and G depend on the positions of its joints; C also depends on their speeds.
    """
    n = len(joints)
    names = (*joints, *(f"speed of {joint}" for joint in joints))
    places = np.arange(2 * n)
    return LearningInputs(names, places, np.full(2 * n, -1), tuple(range(n)), tuple(range(2 * n)))


def differences_of_three() -> LearningInputs:
    """Return the four differences of Table 5.2, for a robot that can rise as a whole."""
    return LearningInputs(
        ("Δq12", "Δq13", "Δq̇12", "Δq̇13"),
        np.array([0, 0, 3, 3]),
        np.array([1, 2, 4, 5]),
        (0, 1, 2, 3),
        (0, 1, 2, 3),
    )
