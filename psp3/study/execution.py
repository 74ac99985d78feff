"""Execute a run: make its robot, motion, noise and controller from their names, and simulate.

Robots, desired motions and records are the same for many runs of a study and cost more than a run,
so they are kept. Each use of noise has its own stream of random numbers, so runs of one seed can be
paired whatever else they draw.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from fuzzy2.support.deferred_compilation import deferred_compilation
from psp3.checks import Array
from psp3.control.controller import may_be_compiled, widths_of
from psp3.robots.payloads import with_payload
from psp3.simulation import metrics
from psp3.simulation.arguments import finite_row, set_report
from psp3.simulation.kernels import WHOLE
from psp3.simulation.loop import Ended, Wiring, compiled_loop, new_track, new_wires, python_loop
from psp3.simulation.plant import NO_POSE
from psp3.simulation.result import Result
from psp3.study.controllers import (
    ONE_AT_A_TIME,
    WithNoisyModel,
    controller_of,
    noise_of,
    record_of,
    robot_named,
)
from psp3.study.paths import DRAWN, names_of_paths, path_named
from psp3.study.run import Run
from psp3.three_psp.parameters import Parameters
from psp3.three_psp.stepping import ClosedFormSteps
from psp3.trajectories.motion import Motion, check_stroke, completed

PAYLOAD_PER_MISMATCH = 5.0
"""Payload of the 3-PSP at q abs(ε) = 1 [kg]."""

_, OF_READING, OF_MEASUREMENT, OF_PATH, OF_PLANT_BESIDE = range(5)
"""Names of the random streams of a seed. Masses are drawn from the stream of the reading, unless
that reading draws at every sample.
"""


@dataclass(frozen=True)
class Samples:
    """The samples that :func:`simulate_run` returns.

    They hold the result, which may end early, and the flags of the controller.

    Parameters
    ----------
    result : Result
        Samples of the run, with the flags of the controller.
    steps : int
        Number of samples of a complete run.
    noise : (steps, p + n) ndarray, optional
        Measurement noise on positions and speeds.
    """

    result: Result
    steps: int
    noise: Array | None = None


def execute(run: Run) -> dict[str, float]:
    """Do a run and return its metrics by name, see :func:`psp3.simulation.metrics.measured`.

    A run continues when a joint leaves its limits, because the screws of the thesis have no end
    stops.

    Parameters
    ----------
    run : Run
        The run.

    Raises
    ------
    InvalidValue, UnknownName
        As from :meth:`psp3.study.run.Run.check`, or if the controller does not work with this robot
        or reading.
    StrokeExceeded
        If the trajectory leaves the joints' limits within the run's duration.
    InvalidRobotFile, UnknownRobot
        If the robot cannot be loaded.
    fuzzy2.errors.InvalidValue, fuzzy2.errors.UnsupportedRule, UnusableEstimate
        If the rules cannot be learned.
    """
    return measure(simulate_run(run), run)


def measure(samples: Samples, run: Run) -> dict[str, float]:
    """Return the metrics of a simulated run by name, see :func:`execute`."""
    limits = robot_named(run.robot, run.parameters).limits
    return metrics.measured(samples.result, samples.steps, limits)


def simulate_run(run: Run) -> Samples:
    """Simulate a run.

    The loop is compiled and releases the interpreter lock, so threads run side by side. If the
    robot or the controller cannot be compiled, the loop runs in Python.

    Parameters
    ----------
    run : Run
        The run.

    Returns
    -------
    Samples

    Raises
    ------
    InvalidValue, UnknownName, StrokeExceeded, UnusableEstimate
        As from :func:`execute`.
    fuzzy2.errors.InvalidValue, fuzzy2.errors.UnsupportedRule
        As from :func:`execute`.
    """
    run.check()
    robot = robot_named(run.robot, run.parameters)
    drawn = np.random.default_rng([run.seed, OF_PATH])
    t, desired = desired_motion(run, drawn)
    n, p = len(robot.coordinates_v), len(robot.reference)
    state = np.concatenate([completed(robot, desired.positions[0]), np.zeros(n)])
    if run.initial_error > 0.0 or run.initial_speed_error > 0.0:
        # The robot starts at the desired speed, so it is beside the path but does not lag behind it
        # from the first sample on.
        state[p : p + desired.speeds.shape[1]] = desired.speeds[0]
        errors = np.repeat([run.initial_error, run.initial_speed_error], [p, n])
        state += errors * drawn.standard_normal(p + n)
    added, measured = _noise(run, len(t), p, n)
    with deferred_compilation():
        controller: Any = controller_of(run, robot)
    if added is not None:
        controller = WithNoisyModel(controller, added)
    m, infinite = len(robot.actuated), np.full(p, np.inf)
    resolution = np.full(robot.commanded, run.encoder_resolution)
    wiring = Wiring(
        run.period, -infinite, infinite, np.full(m, np.inf), resolution, run.delay, measured
    )
    loop = _Loop(run, robot, controller, wiring, t, desired)
    return Samples(loop.run(plants_of(run, robot), state), len(t), measured)


def desired_motion(run: Run, rng: np.random.Generator) -> tuple[Array, Motion]:
    """Return the times of a run and its desired motion; ``rng`` draws random motions."""
    path = names_of_paths(run.robot)[0] if run.trajectory is None else run.trajectory
    settings = (path, run.robot, run.parameters, run.duration, run.period)
    return _moved(*settings, rng) if path in DRAWN else _kept_motion(*settings)


def plants_of(run: Run, robot: Any) -> tuple[tuple[Any, int | None], ...]:
    """Return the compiled plants of a run, each with the sample at which the next plant begins.

    The last plant has None. The second plant begins when the payload is attached.
    """
    stream = OF_PLANT_BESIDE if run.reading in ("measurement", "online") else OF_READING
    ratio = 10.0 ** (-run.snr_db / 20.0) if run.reading == "plant" else run.mass_mismatch
    masses: tuple[tuple[float, int | None], ...] = ((run.payload, None),)
    if run.payload_from > 0.0:
        masses = ((0.0, round(run.payload_from / run.period)), *masses)
    plants = []
    for payload, end in masses:
        rng = np.random.default_rng([run.seed, stream])
        drive = run.drive
        if run.robot == "psp3":
            parameters = mismatched(robot.parameters, ratio, payload, rng)
            plants.append((ClosedFormSteps(parameters.as_array(), 1, drive), end))
        else:
            other = mismatched_robot(robot, ratio, payload, rng)
            plants.append((other.compiled_steps(1, drive), end))
    return tuple(plants)


def mismatched(
    parameters: Parameters, ratio: float, payload: float, rng: np.random.Generator
) -> Parameters:
    """Return parameters of a 3-PSP with random errors of a given ratio and a payload.

    Parameters
    ----------
    parameters : Parameters
        What the controller believes.
    ratio : float
        q of the table in :mod:`psp3.study.run`; 0 changes nothing.
    payload : float
        Mass on the star besides the random one [kg].
    rng : numpy.random.Generator
        Source of random numbers.

    Returns
    -------
    changed : Parameters
        Masses and inertias times exp(q ε), the star's mass plus both payloads.
    """
    names = ("nut_mass", "ball_mass", "ball_axial_inertia", "ball_transverse_inertia", "star_mass")
    factors = np.exp(ratio * rng.standard_normal(len(names) + 3)).tolist()
    changed = {
        name: getattr(parameters, name) * factor
        for name, factor in zip(names, factors, strict=False)
    }
    inertia = tuple(
        moment * factor
        for moment, factor in zip(parameters.star_inertia, factors[len(names) :], strict=True)
    )
    changed["star_mass"] += payload + PAYLOAD_PER_MISMATCH * ratio * abs(
        float(rng.standard_normal())
    )
    return replace(parameters, star_inertia=inertia, **changed)


def mismatched_robot(robot: Any, ratio: float, payload: float, rng: np.random.Generator) -> Any:
    """Return a robot with random mass errors of a given ratio and a payload at its frame ``tip``.

    Parameters
    ----------
    robot : ClosedLoopRobot
        What the controller believes.
    ratio : float
        q of the table in :mod:`psp3.study.run`; 0 changes nothing.
    payload : float
        Mass at the frame ``tip`` [kg].
    rng : numpy.random.Generator
        Source of random numbers.

    Returns
    -------
    ClosedLoopRobot
        A robot whose bodies each have mass and inertia times one factor exp(q ε); the robot itself
        if nothing changes.

    Raises
    ------
    UnknownName
        If the robot has no such frame.
    """
    if ratio == 0.0 and payload == 0.0:
        return robot
    model = robot.model.copy()
    factors = np.exp(ratio * rng.standard_normal(model.njoints))
    for joint in range(1, model.njoints):
        body = model.inertias[joint]
        # Pinocchio stores the inertia about the center of mass, where it is proportional to the
        # mass.
        model.inertias[joint] = type(body)(
            body.mass * factors[joint], body.lever, body.inertia * factors[joint]
        )
    other = type(robot)(
        model,
        robot.constraint_models,
        robot.actuated,
        robot.q0,
        robot.visual_model,
        **robot.options,
    )
    return with_payload(other, payload) if payload > 0.0 else other


def _noise(run: Run, count: int, p: int, n: int) -> tuple[Array | None, Array | None]:
    """Return the noise on the model's numbers and on the measurements at each sample."""
    rng, ratio = np.random.default_rng([run.seed, OF_READING]), 10.0 ** (-run.snr_db / 20.0)
    added = measured = None
    if run.reading == "measurement" and run.snr_db < math.inf:
        recorded = record_of(run)
        seen = np.concatenate([recorded.positions, recorded.speeds], axis=1)
        measured = ratio * noise_of(run).amplitudes(seen) * rng.standard_normal((count, p + n))
    elif run.reading == "online" and run.snr_db < math.inf:
        amplitudes = ratio * noise_of(run).output_amplitudes(record_of(run))
        added = amplitudes * rng.standard_normal((count, len(amplitudes)))
    if run.position_noise > 0.0 or run.speed_noise > 0.0:
        sizes = np.repeat([run.position_noise, run.speed_noise], [p, n])
        own = np.random.default_rng([run.seed, OF_MEASUREMENT]).standard_normal((count, p + n))
        measured = own * sizes + (0.0 if measured is None else measured)
    return added, measured


class _Loop:
    """The control loop of a run, compiled if both controller and robot allow it."""

    def __init__(
        self, run: Run, robot: Any, controller: Any, wiring: Wiring, t: Array, desired: Motion
    ) -> None:
        self._run, self._robot, self._controller = run, robot, controller
        self._wiring, self._desired = wiring, desired
        widths = len(wiring.low) + len(robot.coordinates_v), len(wiring.limit)
        said = controller.numbers_said if may_be_compiled(controller) else 0
        self._track = new_track(t, desired, said, widths)

    def run(self, plants: tuple[tuple[Any, int | None], ...], state: Array) -> Result:
        """Return the samples from a state on; fewer than all if the robot is lost."""
        controller, track, table = self._controller, self._track, None
        controller.reset()
        if may_be_compiled(controller):
            table = controller.table(self._robot.compiled_table(), widths_of(self._robot))
        if table is None:
            done, said = self._in_python(plants, state)
        else:
            done = self._compiled(table, plants, state)
            said = controller.take(table, track.wrote[:done])
        p = len(self._wiring.low)
        positions = track.states[:done, :p].copy()
        return Result(
            track.t[:done],
            positions,
            track.states[:done, p:].copy(),
            Motion(*(array[:done] for array in self._desired)),
            track.applied[:done].copy(),
            _tips(self._robot, positions),
            **{name: values[:done] for name, values in said.items()},
        )

    def _compiled(
        self, table: Any, plants: tuple[tuple[Any, int | None], ...], state: Array
    ) -> int:
        track, wires, ended = (
            self._track,
            new_wires(self._wiring, len(state)),
            Ended(0, WHOLE, state),
        )
        for plant, end in plants:
            last = None if end is None else min(end, len(track.t))
            ended = compiled_loop(
                *(table, plant, self._wiring, track, ended.state, ended.samples),
                last=last,
                wires=wires,
            )
            if ended.why != WHOLE:
                break
        return ended.samples

    def _in_python(
        self, plants: tuple[tuple[Any, int | None], ...], state: Array
    ) -> tuple[int, dict[str, Any]]:
        controller, count = self._controller, len(self._track.t)
        motors = len(self._wiring.limit)
        said = {
            name: np.zeros(count, bool)
            for name in ("covered", "fell_back")
            if hasattr(controller, name)
        }

        def after(k: int) -> None:
            for name, flags in said.items():
                set_report(flags, k, controller, name)

        ended = python_loop(
            controller,
            _Plants(plants),
            self._wiring,
            self._track,
            self._desired,
            state,
            lambda returned: finite_row(returned, motors),
            after,
        )
        return ended.samples, said


class _Plants:
    """Plants in sequence, for the loop in Python: each starts where the one before ends."""

    def __init__(self, plants: tuple[tuple[Any, int | None], ...]) -> None:
        self._plants, self._sample = list(plants), 0

    def start(self, positions: Array, speeds: Array) -> None:
        """Set the robot's state."""
        self._plants[0][0].start(positions, speeds)
        self._state = positions, speeds

    def advance(self, forces: Array, duration: float) -> tuple[Array, Array] | None:
        """Return the state after a time under constant forces, or None if the robot is lost."""
        plant, end = self._plants[0]
        if end is not None and self._sample >= end:
            self._plants.pop(0)
            plant, end = self._plants[0]
            plant.start(*self._state)
        self._sample += 1
        reached: tuple[Array, Array] | None = plant.advance(forces, duration)
        if reached is not None:
            self._state = reached[0].copy(), reached[1].copy()
        return reached


def _tips(robot: Any, positions: Array) -> Array:
    """Return the tip position at each sample; NaN where the loops do not close."""
    try:
        with ONE_AT_A_TIME:
            found: Array = robot.tip(positions)
        return found
    except NO_POSE:
        return np.full((len(positions), 3), np.nan)


@lru_cache(maxsize=32)
def _kept_motion(
    path: str, robot_name: str, parameters: str, duration: float, period: float
) -> tuple[Array, Motion]:
    rng = np.random.default_rng(0)
    t, motion = _moved(path, robot_name, parameters, duration, period, rng)
    for array in (t, *motion):
        # The results of all runs share these arrays.
        array.setflags(write=False)
    return t, motion


def _moved(
    path: str,
    robot_name: str,
    parameters: str,
    duration: float,
    period: float,
    rng: np.random.Generator,
) -> tuple[Array, Motion]:
    robot = robot_named(robot_name, parameters)
    t: Array = period * np.arange(
        int(duration / period * (1.0 + 1e-12) + 1e-9) + 1, dtype=np.float64
    )
    with ONE_AT_A_TIME:
        motion = path_named(path, robot_name, robot, rng)(t)
    check_stroke(robot, t, motion)
    return t, motion
