"""Estimators of other packages as controllers: computed torque with what they predict."""

from __future__ import annotations

from typing import Any

import numpy as np

from psp3.checks import Array
from psp3.control.controller import SaysNothing, Stateless
from psp3.errors import InvalidValue
from psp3.fuzzy_control.numbers import unpack
from psp3.fuzzy_control.records import Record, RecordNoise, learning_inputs
from psp3.robots.robot import Robot
from psp3.trajectories.motion import Motion

SAMPLES = 209
"""Number of samples that an estimator learns from by default."""


class PredictedComputedTorque(Stateless):
    r"""Computed torque with predicted M, C and G; subclasses make the prediction.

    .. math:: \tau = \hat M (\ddot a_d + k_v \dot e + k_p e) + \hat C \dot a + \hat G

    A prediction that is not finite, or whose M is not positive definite, is replaced by an average.

    Parameters
    ----------
    kp, kv : float
        Gains of the servo [1/s², 1/s].

    Attributes
    ----------
    average : (K,) ndarray
        Upper triangle of M, then C and G; it takes the place of an unusable prediction.
    fell_back : bool
        Whether it took the place of the last prediction.
    """

    average: Array

    def __init__(self, kp: float, kv: float) -> None:
        self.kp, self.kv, self.fell_back = kp, kv, False

    def predicted(self, positions: Array, speeds: Array) -> Array:
        """Return the upper triangle of M, then C and G, (K,), at a state."""
        raise NotImplementedError

    def estimate(self, positions: Array, speeds: Array) -> tuple[Array, Array, Array]:
        """Return the M (n, n), C (n, n) and G (n,) that the controller uses at a state."""
        numbers = self.predicted(positions, speeds)
        M, C, G = unpack(numbers)
        self.fell_back = not (np.isfinite(numbers).all() and _is_positive_definite(M))
        return unpack(self.average) if self.fell_back else (M, C, G)

    def torque(self, t: float, positions: Array, speeds: Array, desired: Motion) -> Array:
        """Return the forces (n,) [N or N m]."""
        M, C, G = self.estimate(positions, speeds)
        servo = (
            desired.accelerations
            + self.kv * (desired.speeds - speeds)
            + self.kp * (desired.positions - positions)
        )
        forces: Array = M @ servo + C @ speeds + G
        return forces


class EstimatedComputedTorque(SaysNothing, PredictedComputedTorque):
    """Computed torque with M, C and G as an estimator predicts them.

    An estimator has ``fit(X, Y)`` and ``predict(X)``, as in scikit-learn: X (N, p) are the inputs
    of the robot's dynamics (:attr:`psp3.fuzzy_control.records.Record.inputs`), scaled to mean 0 and
    deviation 1, and Y (N, K) the upper triangle of M, then C and G, scaled likewise. As with the
    fuzzy controllers, inputs outside of the trained range are clamped to it, and the average of the
    training data replaces a prediction whose M is not positive definite.

    Parameters
    ----------
    estimator : object
        The estimator.
    robot : Robot
        The robot; only the inputs that its dynamics depend on are taken from it.
    kp, kv : float
        Gains of the servo [1/s², 1/s].

    Raises
    ------
    InvalidValue
        If ``estimator`` has no ``fit`` and ``predict``, or the robot's coordinates are not its
        motors.
    """

    def __init__(self, estimator: Any, robot: Robot, kp: float, kv: float) -> None:
        if not is_estimator(estimator):
            raise InvalidValue("estimator", estimator, "what has fit(X, Y) and predict(X)")
        super().__init__(kp, kv)
        self.estimator, self._inputs = estimator, learning_inputs(robot)
        self.covered = False

    def learn(
        self,
        recorded: Record,
        samples: int | None,
        snr_db: float,
        rng: np.random.Generator,
        noise: RecordNoise,
    ) -> EstimatedComputedTorque:
        """Learn from samples of a record with noise on them; return the controller itself."""
        chosen = recorded.sample(SAMPLES if samples is None else samples)
        X, Y = recorded.inputs[chosen], recorded.outputs[chosen]
        if np.isfinite(snr_db):
            X, Y = noise.added(recorded, chosen, snr_db, rng)
        self._range = X.min(axis=0), X.max(axis=0)
        self._of_inputs, self._of_outputs = scale_of(X), scale_of(Y)
        self.average = self._of_outputs[0]
        self.estimator.fit(
            *(
                (values - middle) / spread
                for values, (middle, spread) in ((X, self._of_inputs), (Y, self._of_outputs))
            )
        )
        return self

    def predicted(self, positions: Array, speeds: Array) -> Array:
        """Return the estimator's prediction (K,) at a state, in the units of M, C and G."""
        x = self._inputs.of(positions, speeds)
        nearest = np.clip(x, *self._range)
        self.covered = bool((nearest == x).all())
        (middle, spread), (mean, deviation) = self._of_inputs, self._of_outputs
        predicted = np.asarray(self.estimator.predict(((nearest - middle) / spread)[np.newaxis]))
        return np.asarray(predicted.reshape(-1) * deviation + mean)


def is_estimator(value: object) -> bool:
    """Return whether an object has ``fit`` and ``predict``."""
    return all(callable(getattr(value, name, None)) for name in ("fit", "predict"))


def scale_of(values: Array) -> tuple[Array, Array]:
    """Return mean and standard deviation of each column; a constant column gets deviation 1."""
    spread = values.std(axis=0)
    return values.mean(axis=0), np.where(spread > 0.0, spread, 1.0)


def _is_positive_definite(M: Array) -> bool:
    try:
        np.linalg.cholesky(M)
    except np.linalg.LinAlgError:
        return False
    return True
