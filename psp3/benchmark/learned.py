r"""Computed torque with M, C and G of any regressor.

.. math:: \tau = \hat M\,(\ddot a_d + k_v \dot e + k_p e) + \hat C \dot a + \hat G
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from psp3.benchmark.readings import Lesson
from psp3.checks import Array
from psp3.control.controller import Stateless
from psp3.errors import InvalidEntry
from psp3.fuzzy_control.numbers import unpack
from psp3.trajectories.motion import Motion


class Regressor(Protocol):
    """What an entry gives that learns M, C and G."""

    def fit(self, X: Array, Y: Array) -> object:
        """Learn from inputs X (N, p) and outputs Y (N, m)."""
        ...

    def predict(self, X: Array) -> Array:
        """Return outputs (K, m) at inputs X (K, p)."""
        ...


class LearnedComputedTorque(Stateless):
    """Computed torque whose M, C and G are what a regressor predicts.

    Nothing is done to what it says: units are SI, inputs are not clipped. Only an estimate that is
    not finite, or whose M is not positive definite, is replaced by the average of what was learned
    from, as in :class:`psp3.FuzzyComputedTorque`.

    Parameters
    ----------
    regressor : Regressor
        What predicts; it learns here.
    lesson : Lesson
        What it learns from.
    inputs_of : callable
        Returns the inputs (p,) at positions and speeds, (n,) each.
    kp, kv : float
        Gains of the servo [1/s²], [1/s].
    name : str
        What the entry is called in errors.

    Attributes
    ----------
    fell_back : bool
        Whether the last estimate was replaced.

    Raises
    ------
    InvalidEntry
        If ``predict`` returns something else than numbers (1, m).
    """

    def __init__(
        self,
        regressor: Regressor,
        lesson: Lesson,
        inputs_of: Callable[[Array, Array], Array],
        kp: float,
        kv: float,
        name: str,
    ) -> None:
        self._regressor, self._inputs_of, self._name = regressor, inputs_of, name
        self.kp, self.kv = kp, kv
        self._width = lesson.outputs.shape[1]
        # Copies: what an entry does to its samples is no business of the next one.
        regressor.fit(lesson.inputs.copy(), lesson.outputs.copy())
        self._average, self.fell_back = lesson.outputs.mean(axis=0), False

    def estimate(self, positions: Array, speeds: Array) -> tuple[Array, Array, Array]:
        """Return M (n, n), C (n, n) and G (n,) as they are used, at one state."""
        inputs = self._inputs_of(positions, speeds)[np.newaxis]
        said = np.asarray(self._regressor.predict(inputs), dtype=np.float64)
        if said.shape != (1, self._width):
            raise InvalidEntry(
                self._name,
                f"predict returned shape {said.shape} for inputs {inputs.shape}; it must be "
                f"{(1, self._width)}, M, C and G stacked as in the Y of fit",
            )
        M, C, G = unpack(said[0])
        self.fell_back = not (np.isfinite(said).all() and _is_positive_definite(M))
        return unpack(self._average) if self.fell_back else (M, C, G)

    def torque(self, t: float, positions: Array, speeds: Array, desired: Motion) -> Array:
        """Return the forces, (n,) [N or N m]."""
        M, C, G = self.estimate(positions, speeds)
        servo = (
            desired.accelerations
            + self.kv * (desired.speeds - speeds)
            + self.kp * (desired.positions - positions)
        )
        forces: Array = M @ servo + C @ speeds + G
        return forces


def _is_positive_definite(M: Array) -> bool:
    try:
        np.linalg.cholesky(M)
    except np.linalg.LinAlgError:
        return False
    return True
