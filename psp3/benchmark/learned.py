"""Computed torque with M, C and G from any regressor."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from psp3.benchmark.readings import Lesson
from psp3.checks import Array
from psp3.errors import InvalidEntry
from psp3.study.entries import PredictedComputedTorque


class Regressor(Protocol):
    """The interface of an entry that learns M, C and G."""

    def fit(self, X: Array, Y: Array) -> object:
        """Learn from inputs X (N, p) and outputs Y (N, m)."""
        ...

    def predict(self, X: Array) -> Array:
        """Return outputs (K, m) at inputs X (K, p)."""
        ...


class LearnedComputedTorque(PredictedComputedTorque):
    """Computed torque whose M, C and G are predicted by a regressor.

    Inputs and predictions are used unchanged: units are SI, and inputs are not clamped. Only an
    estimate that is not finite, or whose M is not positive definite, is replaced by the average of
    the samples, as in :class:`psp3.FuzzyComputedTorque`.

    Parameters
    ----------
    regressor : Regressor
        The regressor, which learns here.
    lesson : Lesson
        The samples that it learns from.
    inputs_of : callable
        Returns the inputs (p,) at positions and speeds, (n,) each.
    kp, kv : float
        Gains of the servo [1/s²], [1/s].
    name : str
        The name of the entry in errors.

    Raises
    ------
    InvalidEntry
        If ``predict`` does not return numbers (1, m).
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
        super().__init__(kp, kv)
        self._regressor, self._inputs_of, self._name = regressor, inputs_of, name
        self._width = lesson.outputs.shape[1]
        # Copies, because an entry may change its samples, and the next entry must not see that.
        regressor.fit(lesson.inputs.copy(), lesson.outputs.copy())
        self.average = lesson.outputs.mean(axis=0)

    def predicted(self, positions: Array, speeds: Array) -> Array:
        """Return the regressor's prediction (m,) at a state."""
        inputs = self._inputs_of(positions, speeds)[np.newaxis]
        found = np.asarray(self._regressor.predict(inputs), dtype=np.float64)
        if found.shape != (1, self._width):
            raise InvalidEntry(
                self._name,
                f"predict returned shape {found.shape} for inputs {inputs.shape}; it must be "
                f"{(1, self._width)}, M, C and G stacked as in the Y of fit",
            )
        row: Array = found[0]
        return row
