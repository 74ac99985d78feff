"""Simulate a robot under a controller.

It is called once a control period, and its force is held in between.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from psp3.checks import Array, as_floats, checked_count, checked_positive, one_row
from psp3.collisions.motion import check_clearance
from psp3.control.controller import Controller
from psp3.errors import InvalidTorque, InvalidValue, SimulationDiverged
from psp3.robots.robot import Robot
from psp3.simulation.encoder import Encoder
from psp3.simulation.plant import NO_POSE, Plant
from psp3.simulation.result import JOINTS, REPORTED, Result
from psp3.simulation.runge_kutta import RungeKutta
from psp3.trajectories.motion import Motion, check_stroke
from psp3.trajectories.trajectory import Trajectory


def simulate(
    robot: Robot,
    controller: Controller,
    trajectory: Trajectory,
    duration: float,
    period: float = 0.002,
    *,
    initial_positions: ArrayLike | None = None,
    initial_speeds: ArrayLike | None = None,
    torque_limit: ArrayLike | None = None,
    encoder_resolution: ArrayLike = 0.0,
    delay: int = 0,
    plant: Plant | None = None,
    clearance: float | None = None,
    progress: Callable[[float], None] | None = None,
) -> Result:
    """Let a controller track a trajectory.

    The whole desired motion is computed and checked for reach and stroke before the first step is
    taken.

    Parameters
    ----------
    robot : Robot
        The robot that is simulated, with n actuated joints.
    controller : Controller
        Called at every control period, at the end of the simulation too; its force is held until
        the next call. If it has attributes ``covered``, ``fell_back`` or ``torque_interval``, the
        result has them for every sample.
    trajectory : Trajectory
        The desired motion.
    duration : float
        Time to simulate [s]; the last sample is the last whole control period in it.
    period : float
        Control period [s]; 2 ms is the thesis's real-time budget.
    initial_positions, initial_speeds : (n,) array_like, optional
        Where the robot starts [m], [m/s]; by default on the trajectory, at rest.
    torque_limit : float or (n,) array_like, optional
        Largest absolute force of a joint [N]; a controller that asks for more gets this much. Of a
        motor torque: ``drive.force(1.27)``.
    encoder_resolution : float or (n,) array_like
        Travel of a joint from one count of its encoder to the next [m or rad]; 0, a perfect one, by
        default. Otherwise the controller sees positions rounded to counts, and as speeds the
        differences of the last two positions over the period, as a drive without a tachometer does:
        half a period late, in steps of the resolution over the period, and 0 at the first sample.
    delay : int
        Whole control periods by which forces come late, for the time that measuring, computing and
        transmitting take. The first force acts from the start until the second arrives.
    plant : Plant, optional
        What integrates the robot, see :mod:`psp3.simulation.runge_kutta`; ``RungeKutta(robot)`` by
        default.
    clearance : float, optional
        Least distance that links must keep from each other along the desired motion [m]; not looked
        at by default.
    progress : callable, optional
        Called with the simulated time after every hundredth of the steps.

    Returns
    -------
    Result
        What happened, not what the controller saw of it; ``torque`` is what was applied, after
        limit and delay.

    Raises
    ------
    InvalidValue, InvalidArray
        If an argument is malformed.
    UnreachableTip, UnreachablePose, ClosureFailed
        If the robot cannot make the desired motion, or start where it is to.
    JointLimitExceeded, StrokeExceeded, CollisionFound
        For the same reason.
    InvalidTorque
        If the controller returns something else than n finite numbers.
    SimulationDiverged
        If a nut runs off its screw or another actuated joint leaves its limits, an arm runs off its
        ball joint, the loops cannot be closed any more, or the numbers overflow. This error and the
        one before it carry time, state and torque, and the part simulated so far as
        ``error.result``.
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
    if desired.positions.shape[-1] != n:
        raise InvalidValue("trajectory", trajectory, f"a motion of {n} actuated joints")
    check_stroke(robot, t, desired)
    if clearance is not None:
        check_clearance(robot, desired.positions, t, clearance)
    positions = (
        desired.positions[0]
        if initial_positions is None
        else one_row("initial_positions", initial_positions, n)
    )
    speeds = np.zeros(n) if initial_speeds is None else one_row("initial_speeds", initial_speeds, n)
    robot.tip(positions)
    lower, upper = robot.limits
    if (positions < lower).any() or (positions > upper).any():
        raise InvalidValue(
            "initial_positions",
            positions.tolist(),
            f"within the stroke, {lower.tolist()} to {upper.tolist()} m",
        )

    all_positions, all_speeds, all_asked, all_torque = np.empty((4, steps + 1, n))
    reported: dict[str, Any] = {
        name: np.empty((steps + 1, *(n if length == JOINTS else length for length in shape)), kind)
        for name, (shape, kind) in REPORTED.items()
        if hasattr(controller, name)
    }
    low, high = lower.tolist(), upper.tolist()

    def result(samples: int) -> Result:
        return Result(
            t[:samples],
            all_positions[:samples],
            all_speeds[:samples],
            Motion(*(array[:samples] for array in desired)),
            all_torque[:samples],
            _tips(robot, all_positions[:samples]),
            **{name: array[:samples] for name, array in reported.items()},
        )

    controller.reset()
    plant = RungeKutta(robot) if plant is None else plant
    plant.start(positions, speeds)
    report_every = max(1, steps // 100)
    times = t.tolist()
    for k, now in enumerate(map(Motion._make, zip(*desired, strict=True))):
        all_positions[k], all_speeds[k] = positions, speeds
        # The controller gets copies of its own: what it does to them changes nothing here.
        returned = controller.torque(times[k], *encoder.read(all_positions[k], all_speeds[k]), now)
        torque = _finite_row(returned, n)
        if torque is None:
            raise InvalidTorque(
                f"the controller {type(controller).__name__} returned something else than {n} "
                "finite forces",
                times[k],
                positions.copy(),
                speeds.copy(),
                np.asarray(returned, dtype=object),
                result(k),
            )
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
            message = (
                "the robot left the poses it can take" if state is None else robot.limit_message
            )
            last_positions, last_speeds = (
                (all_positions[k], all_speeds[k]) if state is None else state
            )
            raise SimulationDiverged(
                message, times[k] + period, last_positions, last_speeds, torque, result(k + 1)
            )
        positions, speeds = state
        if progress is not None and (k + 1) % report_every == 0:
            progress(times[k + 1])
    return result(steps + 1)


def _tips(robot: Robot, positions: Array) -> Array:
    """Return the tip at the positions reached, NaN where there is none.

    Another engine than ours may go through a pose that is none here.
    """
    try:
        return robot.tip(positions)
    except NO_POSE:
        if len(positions) == 1:
            return np.full((1, 3), np.nan)
        return np.concatenate([_tips(robot, row[np.newaxis]) for row in positions])


def _is_between(low: list[float], values: list[float], high: list[float]) -> bool:
    """Whether none of the values is outside its limits, nor NaN.

    For three numbers faster than arrays.
    """
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
