"""Computed torque with M, C and G of any regressor."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from psp3.benchmark.readings import Lesson
from psp3.checks import Array
from psp3.errors import InvalidEntry
from psp3.study.entries import PredictedComputedTorque


class Regressor(Protocol):
    """What an entry gives that learns M, C and G."""

    def fit(self, X: Array, Y: Array) -> object:
        """Learn from inputs X (N, p) and outputs Y (N, m)."""
        ...

    def predict(self, X: Array) -> Array:
        """Return outputs (K, m) at inputs X (K, p)."""
        ...


class LearnedComputedTorque(PredictedComputedTorque):
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
        super().__init__(kp, kv)
        self._regressor, self._inputs_of, self._name = regressor, inputs_of, name
        self._width = lesson.outputs.shape[1]
        # Copies: what an entry does to its samples is no business of the next one.
        regressor.fit(lesson.inputs.copy(), lesson.outputs.copy())
        self.average = lesson.outputs.mean(axis=0)

    def predicted(self, positions: Array, speeds: Array) -> Array:
        """Return what the regressor predicts (m,) at a state."""
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
