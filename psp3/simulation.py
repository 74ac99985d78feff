"""Simulate a robot under a controller that is called once a control period and whose force is held in between."""

from __future__ import annotations

import math
import operator
import os
import zipfile
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from psp3.arrays import Array, as_floats, checked_count, checked_positive, one_row
from psp3.closed_loop_robot import ClosedLoopRobot
from psp3.collisions import check_clearance
from psp3.controllers import Controller
from psp3.errors import InvalidResultFile, InvalidTorque, InvalidValue, SimulationDiverged
from psp3.plants import NO_POSE, Plant, RungeKutta
from psp3.robot import PSP3
from psp3.trajectories import Motion, Trajectory, check_stroke, tip_of

FORMAT = "psp3-result-2"
"""Written into every result file; a file with another mark is refused."""

JOINTS = -1
"""Stands for the number of actuated joints in a shape."""

_ARRAYS: dict[str, tuple[int, ...]] = {"t": (), "heights": (JOINTS,), "speeds": (JOINTS,), "torque": (JOINTS,), "tip": (3,)}
"""What every result holds: shape of a sample."""

_REPORTED: dict[str, tuple[tuple[int, ...], type]] = {
    "covered": ((), np.bool_),
    "fell_back": ((), np.bool_),
    "torque_interval": ((JOINTS, 2), np.float64),
}
"""What a controller may say of its last call: shape and type of each."""


@dataclass(frozen=True)
class Result:
    """What happened in a simulation, sampled at every control period.

    Parameters
    ----------
    t : (N,) ndarray
        Times, from 0 [s].
    heights, speeds : (N, n) ndarray
        Nut heights [m] and speeds [m/s]; of another robot than the 3-PSP, positions and speeds of its actuated joints.
    desired : Motion
        Desired ``.heights .speeds .accelerations``, each (N, n), and ``.tip`` (N, 3).
    torque : (N, n) ndarray
        Forces of the actuated joints applied from each sample on [N], at revolute joints torques [N m]. As motor torques:
        ``drive.motor_torque(result.torque)``.
    tip : (N, 3) ndarray
        Tip in base axes [m]; of another robot its frame ``tip``, and NaN if it has none.
    covered, fell_back : (N,) ndarray of bool, optional
        Whether the controller was inside its trained range, and whether it fell back on its average; of controllers that say so.
    torque_interval : (N, n, 2) ndarray, optional
        Torque as the fuzzy number that was defuzzified, see :attr:`psp3.FuzzyComputedTorque.torque_interval` [N].
    """

    t: Array
    heights: Array
    speeds: Array
    desired: Motion
    torque: Array
    tip: Array
    covered: NDArray[np.bool_] | None = None
    fell_back: NDArray[np.bool_] | None = None
    torque_interval: Array | None = None

    @property
    def positions(self) -> Array:
        """The heights by the name that fits every robot: positions of the actuated joints, (N, n)."""
        return self.heights

    def save(self, path: str | Path) -> Path:
        """Write the result to an ``.npz`` file, all at once, and return its path.

        Parameters
        ----------
        path : path
            The file; an existing one is replaced only when the new one is complete.
        """
        path = Path(path)
        arrays = {name: getattr(self, name) for name in _ARRAYS}
        arrays |= {f"desired_{name}": values for name, values in self.desired._asdict().items()}
        arrays |= {name: getattr(self, name) for name in _REPORTED if getattr(self, name) is not None}
        partial = path.with_name(path.name + ".part")
        try:
            with partial.open("wb") as file:
                np.savez_compressed(file, format=np.array(FORMAT), **arrays)
            os.replace(partial, path)
        finally:
            partial.unlink(missing_ok=True)
        return path


def load_result(path: str | Path) -> Result:
    """Read a result that :meth:`Result.save` wrote.

    Parameters
    ----------
    path : path
        The ``.npz`` file.

    Returns
    -------
    Result

    Raises
    ------
    InvalidResultFile
        If the file is missing, truncated, of another kind or version, or its arrays do not fit together.
    """
    try:
        # Opened here, because np.load leaves a file that it cannot read open.
        with Path(path).open("rb") as file:
            archive = np.load(file, allow_pickle=False)
            content = {name: archive[name] for name in archive.files}
    except (OSError, ValueError, EOFError, AttributeError, zipfile.BadZipFile, zlib.error) as error:
        raise InvalidResultFile(path, f"is not a whole result file ({getattr(error, 'strerror', None) or error})") from error
    found = str(content.pop("format", "none"))
    if found != FORMAT:
        raise InvalidResultFile(path, f"has format {found!r}, this version reads {FORMAT!r}")
    shapes = _ARRAYS | {f"desired_{name}": (3,) if name == "tip" else (JOINTS,) for name in Motion._fields}
    if not set(shapes) <= set(content) <= set(shapes) | set(_REPORTED):
        raise InvalidResultFile(path, f"must hold the arrays {', '.join(sorted(shapes))}; it holds {', '.join(sorted(content))}")
    samples, joints = content["t"].shape, content["heights"].shape[-1:]
    for name, array in content.items():
        shape, kind = _REPORTED.get(name) or (shapes[name], np.float64)
        whole = (*samples, *(joints[0] if length == JOINTS and joints else length for length in shape))
        if len(samples) != 1 or array.shape != whole or array.dtype != kind:
            raise InvalidResultFile(path, f"array {name} has shape {array.shape} and type {array.dtype}")
    desired = Motion(*(content[f"desired_{name}"] for name in Motion._fields))
    reported = {name: content.get(name) for name in _REPORTED}
    return Result(content["t"], content["heights"], content["speeds"], desired, content["torque"], content["tip"], **reported)


def simulate(
    robot: ClosedLoopRobot,
    controller: Controller,
    trajectory: Trajectory,
    duration: float,
    period: float = 0.002,
    *,
    initial_heights: ArrayLike | None = None,
    initial_speeds: ArrayLike | None = None,
    torque_limit: ArrayLike | None = None,
    encoder_resolution: ArrayLike = 0.0,
    delay: int = 0,
    plant: Plant | None = None,
    clearance: float | None = None,
    progress: Callable[[float], None] | None = None,
) -> Result:
    """Let a controller track a trajectory.

    The whole desired motion is computed and checked for reach and stroke before the first step is taken.

    Parameters
    ----------
    robot : ClosedLoopRobot
        The robot that is simulated, with n actuated joints.
    controller : Controller
        Called at every control period, at the end of the simulation too; its force is held until the next call. If it has attributes
        ``covered``, ``fell_back`` or ``torque_interval``, the result has them for every sample.
    trajectory : Trajectory
        The desired motion.
    duration : float
        Time to simulate [s]; the last sample is the last whole control period in it.
    period : float
        Control period [s]; 2 ms is the thesis's real-time budget.
    initial_heights, initial_speeds : (n,) array_like, optional
        Where the robot starts [m], [m/s]; by default on the trajectory, at rest.
    torque_limit : float or (n,) array_like, optional
        Largest absolute force of a joint [N]; a controller that asks for more gets this much. Of a motor torque: ``drive.force(1.27)``.
    encoder_resolution : float or (n,) array_like
        Travel of a joint from one count of its encoder to the next [m or rad]; 0, a perfect one, by default. Otherwise the controller sees
        positions rounded to counts, and as speeds the differences of the last two positions over the period, as a drive without a
        tachometer does: half a period late, in steps of the resolution over the period, and 0 at the first sample.
    delay : int
        Whole control periods by which forces come late, for the time that measuring, computing and transmitting take. The first force
        acts from the start until the second arrives.
    plant : Plant, optional
        What integrates the robot, see :mod:`psp3.plants`; ``RungeKutta(robot)`` by default.
    clearance : float, optional
        Least distance that links must keep from each other along the desired motion [m]; not looked at by default.
    progress : callable, optional
        Called with the simulated time after every hundredth of the steps.

    Returns
    -------
    Result
        What happened, not what the controller saw of it; ``torque`` is what was applied, after limit and delay.

    Raises
    ------
    InvalidValue, InvalidArray
        If an argument is malformed.
    UnreachableTip, UnreachablePose, ClosureFailed, JointLimitExceeded, StrokeExceeded, CollisionFound
        If the robot cannot make the desired motion, or start where it is to.
    InvalidTorque
        If the controller returns something else than n finite numbers.
    SimulationDiverged
        If a nut runs off its screw or another actuated joint leaves its limits, an arm runs off its ball joint, the loops cannot be closed
        any more, or the numbers overflow. This error and the one before it carry time, state and torque, and the part simulated so far
        as ``error.result``.
    """
    duration, period = checked_positive("duration", duration), checked_positive("period", period)
    # The small excess keeps rounding from losing the last of 5200 periods of 2 ms in 10.4 s.
    steps = int(duration / period * (1.0 + 1e-12) + 1e-9)
    if steps < 1:
        raise InvalidValue("duration", duration, f"at least one period of {period} s")
    n = len(robot.actuated)
    limit = None if torque_limit is None else _one_or_each("torque_limit", torque_limit, n)
    if limit is not None and not (limit > 0.0).all():
        raise InvalidValue("torque_limit", torque_limit, f"one positive number or {n}")
    encoder = Encoder(_one_or_each("encoder_resolution", encoder_resolution, n), period)
    delay = checked_count("delay", delay, 0)
    t: Array = period * np.arange(steps + 1, dtype=np.float64)
    desired = trajectory(t)
    if desired.heights.shape[-1] != n:
        raise InvalidValue("trajectory", trajectory, f"a motion of {n} actuated joints")
    check_stroke(robot, t, desired)
    if clearance is not None:
        check_clearance(robot, desired.heights, t, clearance)
    heights = desired.heights[0] if initial_heights is None else one_row("initial_heights", initial_heights, n)
    speeds = np.zeros(n) if initial_speeds is None else one_row("initial_speeds", initial_speeds, n)
    tip_of(robot, heights)
    lower, upper = robot.limits
    if (heights < lower).any() or (heights > upper).any():
        raise InvalidValue("initial_heights", heights.tolist(), f"within the stroke, {lower.tolist()} to {upper.tolist()} m")

    all_heights, all_speeds, all_asked, all_torque = np.empty((4, steps + 1, n))
    reported: dict[str, Any] = {
        name: np.empty((steps + 1, *(n if length == JOINTS else length for length in shape)), kind)
        for name, (shape, kind) in _REPORTED.items()
        if hasattr(controller, name)
    }
    low, high = lower.tolist(), upper.tolist()

    def result(samples: int) -> Result:
        return Result(
            t[:samples],
            all_heights[:samples],
            all_speeds[:samples],
            Motion(*(array[:samples] for array in desired)),
            all_torque[:samples],
            _tips(robot, all_heights[:samples]),
            **{name: array[:samples] for name, array in reported.items()},
        )

    controller.reset()
    plant = RungeKutta(robot) if plant is None else plant
    plant.start(heights, speeds)
    report_every = max(1, steps // 100)
    times = t.tolist()
    for k, now in enumerate(map(Motion._make, zip(*desired, strict=True))):
        all_heights[k], all_speeds[k] = heights, speeds
        # The controller gets copies of its own: what it does to them changes nothing here.
        returned = controller.torque(times[k], *encoder.read(all_heights[k], all_speeds[k]), now)
        torque = _finite_row(returned, n)
        if torque is None:
            raise InvalidTorque(
                f"the controller {type(controller).__name__} returned something else than {n} finite forces",
                times[k], heights.copy(), speeds.copy(), np.asarray(returned, dtype=object), result(k),
            )  # fmt: skip
        if limit is not None:
            torque = np.clip(torque, -limit, limit)
        all_asked[k] = torque
        torque = all_torque[k] = all_asked[max(k - delay, 0)]
        for name, array in reported.items():
            array[k] = getattr(controller, name)
        if k == steps:
            break
        state = plant.advance(torque, period)
        inside = state is not None and _is_between(low, state[0].tolist(), high)
        if state is None or not inside:
            ran_off = "a nut ran off its screw" if isinstance(robot, PSP3) else "an actuated joint left its limits"
            message = "the robot left the poses it can take" if state is None else ran_off
            last_heights, last_speeds = (all_heights[k], all_speeds[k]) if state is None else state
            raise SimulationDiverged(message, times[k] + period, last_heights, last_speeds, torque, result(k + 1))
        heights, speeds = state
        if progress is not None and (k + 1) % report_every == 0:
            progress(times[k + 1])
    return result(steps + 1)


def _tips(robot: ClosedLoopRobot, positions: Array) -> Array:
    """Return the tip at the positions reached, NaN where another engine than ours went through a pose that is none here."""
    try:
        return tip_of(robot, positions)
    except NO_POSE:
        if len(positions) == 1:
            return np.full((1, 3), np.nan)
        return np.concatenate([_tips(robot, row[np.newaxis]) for row in positions])


class Encoder:
    """What a drive sees of its joints, see ``encoder_resolution`` of :func:`simulate`."""

    def __init__(self, resolution: Array, period: float) -> None:
        if not (resolution >= 0.0).all():
            raise InvalidValue("encoder_resolution", resolution.tolist(), "not negative")
        self._resolution, self._period = resolution, period
        self._coarse = resolution > 0.0
        self._is_perfect = not self._coarse.any()
        self._last: Array | None = None

    def read(self, positions: Array, speeds: Array) -> tuple[Array, Array]:
        """Return the positions and speeds that a controller sees, each (n,)."""
        if self._is_perfect:
            return positions.copy(), speeds.copy()
        with np.errstate(divide="ignore", invalid="ignore"):  # of perfect encoders among others
            counted = np.where(self._coarse, self._resolution * np.floor(positions / self._resolution + 0.5), positions)
        last = counted if self._last is None else self._last
        self._last = counted
        return counted.copy(), np.where(self._coarse, (counted - last) / self._period, speeds)


def _is_between(low: list[float], values: list[float], high: list[float]) -> bool:
    """Whether none of the values is outside its limits, nor NaN; for three numbers faster than arrays."""
    return all(map(operator.le, low, values)) and all(map(operator.le, values, high))


def _finite_row(values: object, width: int) -> Array | None:
    """Return ``values`` as finite floats of shape (width,), or None."""
    try:
        array = np.asarray(values, dtype=np.float64)
        # Infinite entries of opposite sign make NaN, so one sum sees every bad number.
        return array if array.shape == (width,) and math.isfinite(sum(array.tolist())) else None
    except (TypeError, ValueError):
        return None


def _one_or_each(name: str, values: ArrayLike, joints: int) -> Array:
    """Return one number, or one for each joint, as (n,)."""
    array = as_floats(name, values, f"() or ({joints},)")
    if np.shape(values) not in ((), (joints,)) or not np.isfinite(array).all():
        raise InvalidValue(name, values, f"one finite number or {joints}")
    return np.array(np.broadcast_to(array, joints))
