"""Make the controller of a run from its name."""

from __future__ import annotations

import importlib
import threading
from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from fuzzy2.learning.noise import mean_variation_from_snr
from psp3.checks import Array
from psp3.control.classical import PD, ComputedTorque, FeedForward, GravityCompensatedPD
from psp3.control.controller import Controller, Widths
from psp3.control.default_gains import default_gains, moved_mass
from psp3.control.kernels import COMPUTED_TORQUE, classical
from psp3.control.linear_quadratic_regulator import LinearQuadraticRegulator
from psp3.errors import InvalidValue
from psp3.fuzzy_control.adaptive import AdaptiveFuzzyComputedTorque
from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
from psp3.fuzzy_control.records import Record, RecordNoise, record
from psp3.loading import load
from psp3.published import TABLE_6_1
from psp3.study.entries import EstimatedComputedTorque, is_estimator
from psp3.study.paths import names_of_paths, path_named
from psp3.study.run import ADAPTIVE, FUZZY, Run

INTEGRAL_SHARE = 0.3
"""Integral gain of ``ctc-integral`` as a share of kp kv; the loop is unstable above a share of 1.
With the gains of Table 6.1 the gain is 3 1/s³.
"""

ACCEPTABLE_ERROR, ACCEPTABLE_SPEED_ERROR = 0.01, 0.1
"""Errors that cost the regulators as much as the forces below (Bryson's rule) [m or rad, per s]."""

REGULATOR_FORCES = {"lqr": 1.0, "lqr-stiff": 10.0}
"""Motor forces of the 3-PSP that cost the regulators as much as these errors [N]. The first gives a
stiffness of 99 N/m; computed torque has 93 N/m. For another robot, these numbers are factors on the
forces that computed torque exerts for these errors.
"""


ONE_AT_A_TIME = threading.RLock()
"""Held while a robot that threads share computes its frames, because Pinocchio writes them to one
shared buffer."""


class WithIntegral(ComputedTorque):
    r"""Computed torque with an integral of the error, for the compiled loop.

    .. math:: \tau = M \big(\ddot a_d + k_v \dot e + k_p e + k_i \int e\, dt\big) + C
              \dot a + G
    """

    def __init__(self, model: Any, kp: float, kv: float, ki: float) -> None:
        super().__init__(model, kp, kv)
        self.ki, self._integral = ki, 0.0
        self._last: tuple[float, Array] | None = None

    def reset(self) -> None:
        """Forget the integral, and the pose of the last call."""
        super().reset()
        self._integral, self._last = 0.0, None

    def torque(self, t: float, positions: Array, speeds: Array, desired: Any) -> Array:
        """Return the forces (n,) [N or N m], and update the integral."""
        error = desired.positions - positions[: len(desired.positions)]
        if self._last is not None:
            self._integral = self._integral + 0.5 * (t - self._last[0]) * (error + self._last[1])
        self._last = (t, error)
        wanted = desired.accelerations + self.ki * self._integral
        return super().torque(t, positions, speeds, desired._replace(accelerations=wanted))

    def table(self, robot: Any, widths: Widths) -> NamedTuple | None:
        """Return the controller as the compiled loop takes it, or None."""
        model = self._model_table(widths)
        if model is None:
            return None
        return classical(COMPUTED_TORQUE, self.kp, self.kv, model, widths, self.ki)


class WithNoisyModel:
    """A controller with noise on its model's numbers; it works in the compiled loop only.

    Parameters
    ----------
    controller : controller
        A controller whose table has the field ``added``.
    added : (N, K) ndarray
        What is added to the upper triangle of M, C and G at each sample.
    """

    def __init__(self, controller: Any, added: Array) -> None:
        self._controller, self._added = controller, added
        self.numbers_said = getattr(controller, "numbers_said", 0)
        self.reset, self.take = controller.reset, getattr(controller, "take", None)

    def table(self, robot: Any, widths: Widths) -> NamedTuple:
        """Return the controller's table with the noise added."""
        make = getattr(self._controller, "table", lambda robot, widths: None)
        table = make(robot, widths)
        if table is None or not hasattr(table, "added"):
            raise InvalidValue(
                "reading",
                "online",
                f"another one for {type(self._controller).__name__}, which has its own M, C and G",
            )
        noisy: NamedTuple = table._replace(added=self._added)
        return noisy


def controller_of(run: Run, robot: Any) -> Controller:
    """Return the controller of a run, trained if it learns.

    Parameters
    ----------
    run : Run
        The run.
    robot : Robot
        The robot as the controller knows it.

    Returns
    -------
    Controller

    Raises
    ------
    InvalidValue
        If the named object cannot be imported or is not a controller, or if the controller does not
        work for this robot.
    fuzzy2.errors.InvalidValue, fuzzy2.errors.UnsupportedRule, UnusableEstimate
        If the rules cannot be learned.
    """
    if run.controller in FUZZY:
        fuzzy: Controller = _fuzzy(run, robot)
        return fuzzy
    gains = gains_of(run, robot)
    if run.controller in REGULATOR_FORCES:
        regulator: Controller = _regulator(run.controller, run.robot, run.parameters, run.period)
        return regulator
    makers: dict[str, Callable[..., Any]] = {
        "feed-forward": FeedForward,
        "pd-gravity": GravityCompensatedPD,
        "ctc": ComputedTorque,
    }
    if run.controller in makers:
        made: Controller = makers[run.controller](robot, **gains)
        return made
    if run.controller == "pd":
        return PD(**gains, **({} if robot.drives_coordinates else {"model": robot}))
    if run.controller == "ctc-integral":
        return WithIntegral(robot, **gains, ki=INTEGRAL_SHARE * gains["kp"] * gains["kv"])
    named: Controller = _of_place(run, robot)
    return named


def gains_of(run: Run, robot: Any) -> dict[str, Any]:
    """Return the gains of a run's controller: its own, or the default ones, see :class:`Run`."""
    forces = run.controller in ("pd", "pd-gravity")
    if run.controller == "feed-forward":
        return {}
    if run.robot == "psp3":
        gains: dict[str, Any] = dict(
            zip(("kp", "kv"), TABLE_6_1["PD" if forces else "CTC"], strict=True)
        )
    else:
        gains = default_gains(robot, run.controller)
    return gains | {
        name: value for name, value in (("kp", run.kp), ("kv", run.kv)) if value is not None
    }


def noise_of(run: Run) -> RecordNoise:
    """Return the noise on a record that the run's signal-to-noise ratio stands for."""
    return RecordNoise(run.snr_reference, run.noisy_entries, run.reading == "inputs")


def trained(run: Run, robot: Any, rng: np.random.Generator) -> FuzzyComputedTorque:
    """Return the trained fuzzy controller of a run.

    ``rng`` is the source of the noise on the record.
    """
    variation = (
        float(mean_variation_from_snr(run.snr_db))
        if run.mean_variation is None
        else run.mean_variation
    )
    gains = gains_of(run, robot)
    controller = FuzzyComputedTorque(
        ADAPTIVE.get(run.controller, run.controller),
        robot,
        **gains,
        n_terms=run.n_terms,
        learner=run.learner,
        snr_db=run.snr_db if run.reading in ("parameters", "inputs") else np.inf,
        mean_variation=variation,
        levels=run.levels,
        reduction=run.reduction,
        outside=run.outside,
        term_width=run.term_width,
        defuzzify=run.defuzzify,
    )
    return controller.learn(record_of(run), run.samples, rng, noise_of(run))


def _fuzzy(run: Run, robot: Any) -> Any:
    seed = run.seed if run.learning_seed is None else run.learning_seed
    controller = trained(run, robot, np.random.default_rng([seed, 0]))
    return AdaptiveFuzzyComputedTorque(controller) if run.controller in ADAPTIVE else controller


def _of_place(run: Run, robot: Any) -> Any:
    """Return the controller of ``"module:Name"``."""
    module, _, name = run.controller.partition(":")
    try:
        maker = getattr(importlib.import_module(module), name)
    except (ImportError, AttributeError) as error:
        raise InvalidValue(
            "controller",
            run.controller,
            f"the module and name of an object that can be imported ({error}); put the directory "
            "of a file into PYTHONPATH, and on a cluster do so on every worker",
        ) from error
    if isinstance(maker, type) and is_estimator(maker):
        # An estimator does not take the robot, so it is called without arguments.
        return _estimated(run, robot, maker())
    made = maker(robot)
    if is_estimator(made):
        return _estimated(run, robot, made)
    if not callable(getattr(made, "torque", None)) or not callable(getattr(made, "reset", None)):
        raise InvalidValue(
            "controller",
            run.controller,
            "a callable that takes the robot and returns a controller with reset() and torque(t, "
            "positions, speeds, desired), or an estimator with fit(X, Y) and predict(X)",
        )
    return made


def _estimated(run: Run, robot: Any, estimator: Any) -> EstimatedComputedTorque:
    seed = run.seed if run.learning_seed is None else run.learning_seed
    gains = gains_of(run, robot)
    snr_db = run.snr_db if run.reading in ("parameters", "inputs") else np.inf
    return EstimatedComputedTorque(estimator, robot, **gains).learn(
        record_of(run), run.samples, snr_db, np.random.default_rng([seed, 0]), noise_of(run)
    )


# Cached, because many runs of a study share a robot and loading one costs more than a run.


@lru_cache(maxsize=8)
def robot_named(name: str, parameters: str = "default") -> Any:
    """Return a robot, the same object in every call."""
    return load(name, parameters=parameters) if name == "psp3" else load(name)


@lru_cache(maxsize=16)
def _recorded(
    robot_name: str, parameters: str, path: str, kp: float | None, kv: float | None
) -> Record:
    robot = robot_named(robot_name, parameters)
    run = Run("ctc", robot=robot_name, kp=kp, kv=kv)
    trajectory = path_named(path, robot_name, robot, np.random.default_rng(0))
    with ONE_AT_A_TIME:
        return record(robot, trajectory, **gains_of(run, robot))


def record_of(run: Run) -> Record:
    """Return the record of exact computed torque that a run's rules are learned from."""
    path = names_of_paths(run.robot)[0] if run.learned_on is None else run.learned_on
    own = (run.kp, run.kv) if run.learns else (None, None)
    return _recorded(run.robot, run.parameters, path, *own)


@lru_cache(maxsize=8)
def _regulator(
    controller: str, robot_name: str, parameters: str, period: float
) -> LinearQuadraticRegulator:
    robot = robot_named(robot_name, parameters)
    n = robot.commanded
    forces = np.full(n, REGULATOR_FORCES[controller])
    if robot_name != "psp3":
        kp = default_gains(robot, "ctc")["kp"]
        forces = forces * kp * ACCEPTABLE_ERROR * np.diag(moved_mass(robot))
    weights = np.repeat([1.0 / ACCEPTABLE_ERROR**2, 1.0 / ACCEPTABLE_SPEED_ERROR**2], n)
    return LinearQuadraticRegulator(robot, np.diag(weights), np.diag(1.0 / forces**2), period)
