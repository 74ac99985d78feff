"""Simulate a robot under a controller that is called once a control period and whose force is held in between."""

from __future__ import annotations

import math
import os
import zipfile
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from psp3.arrays import Array, checked_positive, one_row
from psp3.controllers import Controller
from psp3.errors import InvalidResultFile, InvalidTorque, InvalidValue, SimulationDiverged
from psp3.plants import Plant, RungeKutta
from psp3.robot import PSP3
from psp3.trajectories import Motion, Trajectory, check_stroke

FORMAT = "psp3-result-2"
"""Written into every result file; a file with another mark is refused."""

_REPORTED: dict[str, tuple[tuple[int, ...], type]] = {
    "covered": ((), np.bool_),
    "fell_back": ((), np.bool_),
    "torque_interval": ((3, 2), np.float64),
}
"""What a controller may say of its last call: shape and type of each."""


@dataclass(frozen=True)
class Result:
    """What happened in a simulation, sampled at every control period.

    Parameters
    ----------
    t : (N,) ndarray
        Times, from 0 [s].
    heights, speeds : (N, 3) ndarray
        Nut heights [m] and speeds [m/s].
    desired : Motion
        Desired ``.heights .speeds .accelerations .tip``, each (N, 3).
    torque : (N, 3) ndarray
        Screw forces applied from each sample on [N].
    tip : (N, 3) ndarray
        Tip in base axes [m].
    covered, fell_back : (N,) ndarray of bool, optional
        Whether the controller was inside its trained range, and whether it fell back on its average; of controllers that say so.
    torque_interval : (N, 3, 2) ndarray, optional
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

    def save(self, path: str | Path) -> Path:
        """Write the result to an ``.npz`` file, all at once, and return its path.

        Parameters
        ----------
        path : path
            The file; an existing one is replaced only when the new one is complete.
        """
        path = Path(path)
        arrays = {name: getattr(self, name) for name in ("t", "heights", "speeds", "torque", "tip")}
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
    expected = {"t", "heights", "speeds", "torque", "tip", *(f"desired_{name}" for name in Motion._fields)}
    if not expected <= set(content) <= expected | set(_REPORTED):
        raise InvalidResultFile(path, f"must hold the arrays {', '.join(sorted(expected))}; it holds {', '.join(sorted(content))}")
    samples = content["t"].shape
    for name, array in content.items():
        shape, kind = _REPORTED.get(name, ((), np.float64) if name == "t" else ((3,), np.float64))
        if len(samples) != 1 or array.shape != (*samples, *shape) or array.dtype != kind:
            raise InvalidResultFile(path, f"array {name} has shape {array.shape} and type {array.dtype}")
    desired = Motion(*(content[f"desired_{name}"] for name in Motion._fields))
    reported = {name: content.get(name) for name in _REPORTED}
    return Result(content["t"], content["heights"], content["speeds"], desired, content["torque"], content["tip"], **reported)


def simulate(
    robot: PSP3,
    controller: Controller,
    trajectory: Trajectory,
    duration: float,
    period: float = 0.002,
    *,
    initial_heights: ArrayLike | None = None,
    initial_speeds: ArrayLike | None = None,
    torque_limit: ArrayLike | None = None,
    plant: Plant | None = None,
    progress: Callable[[float], None] | None = None,
) -> Result:
    """Let a controller track a trajectory.

    The whole desired motion is computed and checked for reach and stroke before the first step is taken.

    Parameters
    ----------
    robot : PSP3
        The robot that is simulated.
    controller : Controller
        Called at every control period, at the end of the simulation too; its force is held until the next call. If it has attributes
        ``covered``, ``fell_back`` or ``torque_interval``, the result has them for every sample.
    trajectory : Trajectory
        The desired motion.
    duration : float
        Time to simulate [s]; the last sample is the last whole control period in it.
    period : float
        Control period [s]; 2 ms is the thesis's real-time budget.
    initial_heights, initial_speeds : (3,) array_like, optional
        Where the robot starts [m], [m/s]; by default on the trajectory, at rest.
    torque_limit : float or (3,) array_like, optional
        Largest absolute screw force [N]; a controller that asks for more gets this much.
    plant : Plant, optional
        What integrates the robot, see :mod:`psp3.plants`; ``RungeKutta(robot)`` by default.
    progress : callable, optional
        Called with the simulated time after every hundredth of the steps.

    Returns
    -------
    Result

    Raises
    ------
    InvalidValue, InvalidArray
        If an argument is malformed.
    UnreachableTip, StrokeExceeded
        If the robot cannot make the desired motion.
    InvalidTorque
        If the controller returns something else than three finite numbers.
    SimulationDiverged
        If a nut runs off its screw, an arm off its ball joint, or the numbers overflow. This error and the one before it carry
        time, state and torque, and the part simulated so far as ``error.result``.
    """
    duration, period = checked_positive("duration", duration), checked_positive("period", period)
    # The small excess keeps rounding from losing the last of 5200 periods of 2 ms in 10.4 s.
    steps = int(duration / period * (1.0 + 1e-12) + 1e-9)
    if steps < 1:
        raise InvalidValue("duration", duration, f"at least one period of {period} s")
    t: Array = period * np.arange(steps + 1, dtype=np.float64)
    desired = trajectory(t)
    check_stroke(robot, t, desired)
    limit = _torque_limit(torque_limit)
    heights = desired.heights[0] if initial_heights is None else one_row("initial_heights", initial_heights, 3)
    speeds = np.zeros(3) if initial_speeds is None else one_row("initial_speeds", initial_speeds, 3)
    robot.forward_kinematics(heights)
    lower, upper = robot.stroke
    if (heights < lower).any() or (heights > upper).any():
        raise InvalidValue("initial_heights", heights.tolist(), f"within the stroke, {lower.tolist()} to {upper.tolist()} m")

    all_heights, all_speeds, all_torque = np.empty((3, steps + 1, 3))
    reported: dict[str, Any] = {
        name: np.empty((steps + 1, *shape), kind) for name, (shape, kind) in _REPORTED.items() if hasattr(controller, name)
    }
    (low1, low2, low3), (high1, high2, high3) = (lower.tolist(), upper.tolist())

    def result(samples: int) -> Result:
        return Result(
            t[:samples],
            all_heights[:samples],
            all_speeds[:samples],
            Motion(*(array[:samples] for array in desired)),
            all_torque[:samples],
            robot.forward_kinematics(all_heights[:samples]).tip,
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
        returned = controller.torque(times[k], all_heights[k].copy(), all_speeds[k].copy(), now)
        torque = _three_numbers(returned)
        if torque is None:
            raise InvalidTorque(
                f"the controller {type(controller).__name__} returned something else than three finite forces",
                times[k], heights.copy(), speeds.copy(), np.asarray(returned, dtype=object), result(k),
            )  # fmt: skip
        if limit is not None:
            torque = np.clip(torque, -limit, limit)
        all_torque[k] = torque
        for name, array in reported.items():
            array[k] = getattr(controller, name)
        if k == steps:
            break
        state = plant.advance(torque, period)
        inside = False
        if state is not None:
            a1, a2, a3 = state[0].tolist()
            inside = low1 <= a1 <= high1 and low2 <= a2 <= high2 and low3 <= a3 <= high3
        if state is None or not inside:
            message = "the robot left the poses it can take" if state is None else "a nut ran off its screw"
            last_heights, last_speeds = (all_heights[k], all_speeds[k]) if state is None else state
            raise SimulationDiverged(message, times[k] + period, last_heights, last_speeds, torque, result(k + 1))
        heights, speeds = state
        if progress is not None and (k + 1) % report_every == 0:
            progress(times[k + 1])
    return result(steps + 1)


def _three_numbers(values: object) -> Array | None:
    """Return ``values`` as three finite floats, or None."""
    try:
        array = np.asarray(values, dtype=np.float64)
        one, two, three = array.tolist()
        # Infinite entries of opposite sign make NaN, so one sum sees every bad number.
        return array if math.isfinite(one + two + three) else None
    except (TypeError, ValueError):
        return None


def _torque_limit(limit: ArrayLike | None) -> Array | None:
    if limit is None:
        return None
    array = np.asarray(limit, dtype=float)
    if array.shape not in ((), (3,)) or not (array > 0.0).all() or not np.isfinite(array).all():
        raise InvalidValue("torque_limit", limit, "one positive number or three")
    return array
