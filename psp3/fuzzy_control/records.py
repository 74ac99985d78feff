r"""Records of the crisp computed-torque controller on a trajectory.

The fuzzy estimators of chapter 5 learn from these records.

M, C and G are functions of positions and speeds. Those of the 3-PSP do not change when all nuts
rise together, so they are functions of four differences (Table 5.2),

.. math:: x = (\Delta q_{12}, \Delta q_{13}, \Delta\dot q_{12}, \Delta\dot q_{13}), \qquad
          \Delta q_{1k} = a_1 - a_k,

and of these alone. For any robot, ``robot.learning_inputs`` gives the inputs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fuzzy2.support.described import Described
from psp3.checks import Array, finite_rows
from psp3.control.classical import ComputedTorque
from psp3.errors import InvalidValue, UnknownName
from psp3.fuzzy_control.numbers import output_names, pack, unpack
from psp3.fuzzy_control.spreading import spread_evenly
from psp3.published import DURATION
from psp3.robots.learning_inputs import (
    LearningInputs,
    differences_of_three,
    positions_and_speeds,
)
from psp3.robots.robot import Robot
from psp3.simulation.tracking import simulate
from psp3.trajectories.trajectory import Trajectory

__all__ = ["pack", "unpack"]

INPUT_NAMES = differences_of_three().names
"""Inputs of the estimators of the 3-PSP, in order [m, m, m/s, m/s]."""

OUTPUT_NAMES = output_names(3)
"""Outputs of the estimators of the 3-PSP, in order: the upper triangle of M [kg], C [kg/s] and G
[N].
"""

REFERENCES = ("mean-square", "variance", "unit")
"""Powers that a signal-to-noise ratio can refer to: the mean square of a signal, mean included, its
variance, or 1 in the unit of the signal (0 dBW).
"""

ENTRIES = ("all", "gravity", "mass-coriolis")
"""Choices of the noisy outputs of a record: all, G alone, or M and C alone."""

STILL = 1e-9
"""An input whose range is below this counts as constant, because the rest is rounding [m, m/s].
"""


def learning_inputs(robot: Robot) -> LearningInputs:
    """Return the inputs that a robot declares for its dynamics, or else positions and speeds.

    Raises
    ------
    InvalidValue
        If its coordinates are not its motors.
    """
    if not getattr(robot, "drives_coordinates", False):
        named = getattr(robot, "title", robot)
        raise InvalidValue(
            "robot",
            named,
            "a robot whose coordinates are its motors; for others the forces along the "
            "coordinates are not those of the motors",
        )
    given: LearningInputs | None = getattr(robot, "learning_inputs", None)
    return positions_and_speeds(robot.coordinates) if given is None else given


def differences(heights: ArrayLike, speeds: ArrayLike) -> Array:
    """Return the four difference inputs of the estimators of the 3-PSP.

    Parameters
    ----------
    heights, speeds : (..., 3) array_like
        Nut heights [m] and speeds [m/s].

    Returns
    -------
    (..., 4) ndarray
        Differences in the order of ``INPUT_NAMES``.

    Raises
    ------
    InvalidArray
        If an argument is not finite numbers of that shape.
    """
    a, v = finite_rows("heights", heights, 3), finite_rows("speeds", speeds, 3)
    return differences_of_three().of(*np.broadcast_arrays(a, v))


@dataclass(frozen=True, repr=False)
class Record(Described):
    """A recorded run.

    Parameters
    ----------
    t : (N,) ndarray
        Times [s].
    positions, speeds : (N, n) ndarray
        Positions [m or rad] and speeds [m/s or rad/s]; for the 3-PSP those of its nuts.
    inputs : (N, p) ndarray
        Inputs of the robot's dynamics along the run; for the 3-PSP four differences.
    outputs : (N, K) ndarray
        Exact M, C and G along the run, in the order of :func:`psp3.fuzzy_control.numbers.pack`.
    input_names, output_names : tuple of str
        Names of the columns; by default those of the 3-PSP.
    """

    t: Array
    positions: Array
    speeds: Array
    inputs: Array
    outputs: Array
    input_names: tuple[str, ...] = INPUT_NAMES
    output_names: tuple[str, ...] = OUTPUT_NAMES
    _chosen: dict[int, NDArray[np.intp]] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )

    def _facts(self) -> dict[str, Any]:
        return {
            "duration": f"{self.t[-1] if len(self.t) else 0.0:g} s",
            "samples": len(self.t),
            "inputs": self.input_names,
            "outputs": self.output_names,
        }

    @property
    def heights(self) -> Array:
        """Positions, which are nut heights for the 3-PSP, (N, n) [m]."""
        return self.positions

    @property
    def rms(self) -> Array:
        """Root mean square of every output over the run, mean included, (K,).

        It is the amplitude of the signal that the noise is scaled by.
        """
        return NOISE_OF_THE_STUDY.amplitudes(self.outputs)

    def sample(self, count: int) -> NDArray[np.intp]:
        """Return the indices of samples that cover the recorded inputs evenly.

        Each next sample is the recorded point that is farthest from all samples taken before, with
        distances in shares of the inputs' ranges. The first is the point farthest from the middle
        of the ranges. So every prefix of this order covers the whole record.

        Parameters
        ----------
        count : int
            Number of samples, at least 2 and at most that of the record.

        Returns
        -------
        (count,) ndarray of int
            Indices in ascending order.

        Raises
        ------
        InvalidValue
            If the count is outside of these limits, or an input does not change at all.
        """
        if (
            isinstance(count, bool)
            or not isinstance(count, int | np.integer)
            or not 2 <= count <= len(self.t)
        ):
            raise InvalidValue(
                "samples",
                count,
                f"a whole number from 2 to {len(self.t)}, the length of the record",
            )
        if count not in self._chosen:
            # Cached, because a study learns many times from the same samples with different noise.
            self._chosen[count] = self._spread_evenly(count)
        return self._chosen[count].copy()

    def _spread_evenly(self, count: int) -> NDArray[np.intp]:
        span = ranges_of_moving(self.inputs, self.input_names)
        points = (self.inputs - self.inputs.min(axis=0)) / span
        return np.sort(spread_evenly(points, count))


def ranges_of_moving(inputs: Array, names: Sequence[str], what: str = "trajectory") -> Array:
    """Return the ranges (p,) of inputs (N, p), or raise :class:`InvalidValue` if one is still.

    The error names ``what`` the inputs belong to.
    """
    span: Array = np.ptp(inputs, axis=0)
    if not (span > STILL).all():
        still = ", ".join(name for name, width in zip(names, span, strict=True) if width <= STILL)
        wanted = "one on which every input changes; choose a path on which every joint moves"
        if tuple(names) == INPUT_NAMES:
            wanted = (
                "one on which every difference input changes; choose a path that tilts the star "
                "both ways"
            )
        raise InvalidValue(what, still, wanted)
    return span


@dataclass(frozen=True)
class RecordNoise:
    r"""What "noise of S dB on a record" means: white Gaussian noise on some of its signals.

    .. math:: y_t = x_t + \sqrt{P\,10^{-S/10}}\;\varepsilon_t, \qquad \varepsilon_t \sim N(0, 1)

    for each signal. The thesis defines neither the power P nor which signals x are noisy, and both
    decide whether type-2 is better.

    Parameters
    ----------
    reference : str
        Definition of P, one of ``REFERENCES``: the mean square of x over the whole record, its
        variance, or 1.
    entries : str
        Which outputs are noisy, one of ``ENTRIES``.
    of_inputs : bool
        Whether the noise is on the recorded inputs instead of the outputs.

    Raises
    ------
    UnknownName
        If a name is unknown.
    """

    reference: str = "mean-square"
    entries: str = "all"
    of_inputs: bool = False

    def __post_init__(self) -> None:
        for what, name, known in (
            ("reference of the signal-to-noise ratio", self.reference, REFERENCES),
            ("choice of noisy entries", self.entries, ENTRIES),
        ):
            if not isinstance(name, str) or name not in known:
                raise UnknownName(what, name, known)

    def amplitudes(self, signals: Array) -> Array:
        r"""Return the amplitude :math:`\sqrt P` of noise of 0 dB.

        Parameters
        ----------
        signals : (N, K) ndarray
            K signals over a whole record.

        Returns
        -------
        (K,) ndarray
            Amplitudes in the units of the signals.
        """
        if self.reference == "mean-square":
            return np.asarray(np.sqrt(np.mean(signals**2, axis=0)))
        if self.reference == "variance":
            return np.asarray(np.std(signals, axis=0))
        return np.ones(signals.shape[1])

    def output_amplitudes(self, recorded: Record) -> Array:
        """Return the amplitudes of noise of 0 dB on every output, in the outputs' units.

        It is zero for outputs without noise.

        Parameters
        ----------
        recorded : Record
            The whole record.

        Returns
        -------
        (K,) ndarray
            Amplitudes in the order of ``recorded.output_names``.
        """
        gravity = np.array([name.startswith("G") for name in recorded.output_names])
        chosen = {"all": gravity | ~gravity, "gravity": gravity, "mass-coriolis": ~gravity}
        return np.where(chosen[self.entries], self.amplitudes(recorded.outputs), 0.0)

    def added(
        self,
        recorded: Record,
        chosen: NDArray[np.intp],
        snr_db: float,
        rng: np.random.Generator,
    ) -> tuple[Array, Array]:
        """Return inputs and outputs of chosen samples, with the noise added.

        The power is that of the whole record, so it does not depend on the samples.

        Parameters
        ----------
        recorded : Record
            The whole record.
        chosen : (N,) ndarray of int
            Indices of the samples.
        snr_db : float
            Signal-to-noise ratio S [dB].
        rng : numpy.random.Generator
            Source of random numbers.

        Returns
        -------
        inputs : (N, p) ndarray
            In the order of ``recorded.input_names``.
        outputs : (N, K) ndarray
            In the order of ``recorded.output_names``.
        """
        inputs, outputs = recorded.inputs[chosen], recorded.outputs[chosen]
        ratio = 10.0 ** (-snr_db / 20.0)
        if self.of_inputs:
            amplitude = self.amplitudes(recorded.inputs) * ratio
            return inputs + amplitude * rng.standard_normal(inputs.shape), outputs
        amplitude = self.output_amplitudes(recorded) * ratio
        return inputs, outputs + amplitude * rng.standard_normal(outputs.shape)


NOISE_OF_THE_STUDY = RecordNoise()
"""The default noise: on all of M, C and G, relative to their mean squares.
"""


def record(
    robot: Robot,
    trajectory: Trajectory,
    duration: float = DURATION,
    period: float = 0.002,
    kp: float = 10.0,
    kv: float = 1.0,
) -> Record:
    """Track a trajectory with the crisp computed-torque controller and record it.

    The run starts at rest on the trajectory. Inputs and exact dynamics are recorded.

    Parameters
    ----------
    robot : Robot
        The robot, whose M, C and G are recorded.
    trajectory : Trajectory
        The desired motion.
    duration, period : float
        Length of the run and control period [s].
    kp, kv : float
        Gains of the controller, see :class:`psp3.control.classical.ComputedTorque`.

    Returns
    -------
    Record

    Raises
    ------
    InvalidValue, UnreachableTip, StrokeExceeded, SimulationStopped
        As from :func:`psp3.simulation.tracking.simulate`; or if the robot's coordinates are not its
        motors.
    """
    inputs = learning_inputs(robot)
    result = simulate(robot, ComputedTorque(robot, kp, kv), trajectory, duration, period)
    outputs = pack(*robot.equation_of_motion(result.positions, result.speeds))
    return Record(
        result.t,
        result.positions,
        result.speeds,
        inputs.of(result.positions, result.speeds),
        outputs,
        inputs.names,
        output_names(result.positions.shape[1]),
    )
