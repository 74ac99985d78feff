"""Simulate a robot under a controller.

The controller is called once a control period, and its force is held in between.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from psp3.checks import (
    Array,
    check_periods,
    checked_count,
    checked_positive,
    checked_robot,
    one_or_each,
    one_row,
)
from psp3.collisions.motion import check_clearance
from psp3.control.controller import Controller, may_be_compiled, widths_of
from psp3.control.feedback import check_feedback
from psp3.errors import InvalidTorque, InvalidValue, NoFiniteAnswer, SimulationDiverged
from psp3.robots.robot import Robot
from psp3.simulation.arguments import as_object, check_objects, finite_row, set_report
from psp3.simulation.kernels import LEFT_POSES, NO_FORCE, WHOLE
from psp3.simulation.loop import Ended, Wiring, compiled_loop, new_track, python_loop
from psp3.simulation.plant import NO_POSE, Plant
from psp3.simulation.result import JOINTS, REPORTED, Result
from psp3.simulation.runge_kutta import RungeKutta
from psp3.trajectories.motion import Motion, check_stroke, completed, motion_at
from psp3.trajectories.trajectory import Trajectory

MOST_STEPS = 10**8
"""Greatest number of samples that fits into memory."""

INSTANT = 1e-9
"""Part of a period in which a robot with a finite acceleration stays where it is."""

NO_ACCELERATION = (
    f"the robot's accelerations have no finite answer: {NoFiniteAnswer.REMEDY}; the simulation "
    "ended"
)


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
    """Simulate a controller that tracks a trajectory.

    The whole desired motion is computed and checked for reach and stroke before the first step is
    taken.

    Parameters
    ----------
    robot : Robot
        The robot to simulate, with n actuated joints. If its coordinates are not its motors, the
        state is that of the coordinates, positions (p,) and speeds (n,); forces are those of its m
        motors; and the desired motion is that of the first k coordinates, which the motors command,
        while the others are passive.
    controller : Controller
        Called at every control period, also at the end of the simulation; its force is held until
        the next call. If it has attributes ``covered``, ``fell_back`` or ``torque_interval``, the
        result has them for every sample.
    trajectory : Trajectory
        The desired motion of the k commanded coordinates; usually k is n.
    duration : float
        Time to simulate [s]; the last sample is the last whole control period in it.
    period : float
        Control period [s]; 2 ms is the thesis's real-time budget.
    initial_positions, initial_speeds : (p,), (n,) array_like, optional
        Initial positions and speeds [m], [m/s]; by default on the trajectory and at rest, with
        passive coordinates as in the reference pose.
    torque_limit : float or (m,) array_like, optional
        Largest absolute force of a joint [N], to which the controller's force is limited. For a
        motor torque use ``drive.force(1.27)``.
    encoder_resolution : float or (k,) array_like
        Travel of a joint per count of its encoder [m or rad]; by default 0, a perfect encoder.
        Otherwise the controller sees positions rounded to counts. The speeds that it sees are
        differences of the last two positions over the period, as in a drive without a tachometer:
        half a period late, in steps of the resolution over the period, and 0 at the first sample.
    delay : int
        Number of control periods by which forces are delayed, for the time of measurement,
        computation and transmission. The first force acts from the start until the second arrives.
    plant : Plant, optional
        The integrator of the robot, see :mod:`psp3.simulation.runge_kutta`; ``RungeKutta(robot)``
        by default.
    clearance : float, optional
        Least distance between links along the desired motion [m]; not checked by default.
    progress : callable, optional
        Called with the simulated time after every hundredth of the steps.

    Returns
    -------
    Result
        The true motion, not the one that the controller saw; ``torque`` is the applied force, after
        limit and delay.

    Raises
    ------
    InvalidValue, InvalidArray
        If an argument is malformed, or the trajectory or the plant returns something malformed.
    UnreachableTip, UnreachablePose, ClosureFailed
        If the robot cannot make the desired motion, or cannot take the initial state.
    JointLimitExceeded, StrokeExceeded, CollisionFound
        For the same reason.
    InvalidTorque
        If the controller does not return m finite numbers.
    SimulationDiverged
        If a nut runs off its screw or another actuated joint leaves its limits, an arm runs off its
        ball joint, the loops cannot be closed any more, the numbers overflow, or a motion has no
        mass and no inertia. This error and ``InvalidTorque`` hold time, state and torque, and the
        part simulated so far as ``error.result``.
    """
    checked_robot(robot)
    check_objects(controller=controller, trajectory=trajectory, plant=plant, progress=progress)
    duration, period = checked_positive("duration", duration), checked_positive("period", period)
    # The small excess keeps the last of 5200 periods of 2 ms in 10.4 s in spite of rounding.
    check_periods(duration, period, MOST_STEPS)
    steps = int(duration / period * (1.0 + 1e-12) + 1e-9)
    if steps < 1:
        raise InvalidValue("duration", duration, f"at least one period of {period} s")
    check_feedback(robot, controller)
    m, k = len(robot.actuated), robot.commanded
    limit = None if torque_limit is None else one_or_each("torque_limit", torque_limit, m)
    if limit is not None and not (limit > 0.0).all():
        raise InvalidValue("torque_limit", torque_limit, f"one positive number or {m}")
    resolution = one_or_each("encoder_resolution", encoder_resolution, k)
    if not (resolution >= 0.0).all():
        raise InvalidValue("encoder_resolution", resolution.tolist(), "not negative")
    delay = checked_count("delay", delay, 0)
    t: Array = period * np.arange(steps + 1, dtype=np.float64)
    desired = motion_at(trajectory, t, k)
    check_stroke(robot, t, desired)
    if clearance is not None:
        check_clearance(robot, completed(robot, desired.positions), t, clearance)
    reference, n = robot.reference, len(robot.coordinates_v)
    positions = (
        completed(robot, desired.positions[0])
        if initial_positions is None
        else one_row("initial_positions", initial_positions, len(reference))
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

    infinite = np.full(m, np.inf)
    wiring = Wiring(period, lower, upper, infinite if limit is None else limit, resolution, delay)
    plant = RungeKutta(robot) if plant is None else plant
    return _Experiment(robot, controller, plant, wiring, t, desired, progress).run(
        np.concatenate([positions, speeds])
    )


class _Experiment:
    """A loop to run, and the errors for the ways in which it can end."""

    def __init__(
        self,
        robot: Robot,
        controller: Controller,
        plant: Plant,
        wiring: Wiring,
        t: Array,
        desired: Motion,
        progress: Callable[[float], None] | None,
    ) -> None:
        self._robot, self._controller, self._plant = robot, controller, plant
        self._wiring, self._desired, self._progress = wiring, desired, progress
        self._every = max(1, (len(t) - 1) // 100)
        self._reported: dict[str, Any] = {}
        said = controller.numbers_said if may_be_compiled(controller) else 0
        self._positions, self._motors = len(wiring.low), len(wiring.limit)
        widths = self._positions + len(robot.coordinates_v), self._motors
        self._track = new_track(t, desired, said, widths)

    def run(self, state: Array) -> Result:
        """Return the result from a state (p + n,) on, or raise the reason for an early end."""
        self._controller.reset()
        compiled = self._plant.compiled if type(self._plant) is RungeKutta else None
        table = None
        if compiled is not None and may_be_compiled(self._controller):
            table = self._controller.table(self._robot.compiled_table(), widths_of(self._robot))
        ended = self._in_python(state) if table is None else self._compiled(table, compiled, state)
        if ended.why == WHOLE:
            return self._result(ended.samples)
        raise self._error(ended)

    def _compiled(self, table: Any, plant: Any, state: Array) -> Ended:
        p, controller, track = self._positions, self._controller, self._track
        self._plant.start(state[:p], state[p:])
        every = None if self._progress is None else self._every
        ended = compiled_loop(
            table, plant, self._wiring, track, state, progress=self._tell, every=every
        )
        self._reported = controller.take(table, track.wrote[: ended.samples])  # type: ignore[attr-defined]
        if ended.why == NO_FORCE:
            # Called again in Python, because the controller may raise an error with the reason.
            k, seen = ended.samples, np.asarray(ended.returned)
            now = Motion(*(array[k] for array in self._desired))
            returned = controller.torque(float(track.t[k]), seen[:p].copy(), seen[p:].copy(), now)
            ended = ended._replace(state=track.states[k].copy(), returned=returned)
        elif ended.why == LEFT_POSES:
            ended = ended._replace(state=track.states[ended.samples - 1].copy())
        return ended

    def _in_python(self, state: Array) -> Ended:
        n, controller = self._motors, self._controller
        count = len(self._track.t)
        self._reported = {
            name: np.empty((count, *(n if length == JOINTS else length for length in shape)), kind)
            for name, (shape, kind) in REPORTED.items()
            if hasattr(controller, name)
        }

        def after(k: int) -> None:
            for name, array in self._reported.items():
                set_report(array, k, controller, name)
            self._tell(k)

        return python_loop(
            controller,
            self._plant,
            self._wiring,
            self._track,
            self._desired,
            state,
            lambda returned: finite_row(returned, n),
            after,
        )

    def _tell(self, sample: int) -> None:
        """Report progress at every hundredth of the steps."""
        is_due = 0 < sample < len(self._track.t) and sample % self._every == 0
        if self._progress is not None and is_due:
            self._progress(float(self._track.t[sample]))

    def _result(self, samples: int) -> Result:
        track, p = self._track, self._positions
        positions = np.ascontiguousarray(track.states[:samples, :p])
        return Result(
            track.t[:samples],
            positions,
            np.ascontiguousarray(track.states[:samples, p:]),
            Motion(*(array[:samples] for array in self._desired)),
            track.applied[:samples],
            _tips(self._robot, positions),
            **{name: array[:samples] for name, array in self._reported.items()},
        )

    def _error(self, ended: Ended) -> Exception:
        k, n, p, track = ended.samples, self._motors, self._positions, self._track
        state = ended.state[:p], ended.state[p:]
        if ended.why == NO_FORCE:
            name = type(self._controller).__name__
            return InvalidTorque(
                f"the controller {name} returned something else than {n} finite forces",
                float(track.t[k]),
                *state,
                as_object(ended.returned),
                self._result(k),
            )
        time, message = float(track.t[k - 1]) + self._wiring.period, self._robot.limit_message
        if ended.why == LEFT_POSES:
            message = "the robot left the poses it can take"
            if self._is_stuck(*state, track.applied[k - 1]):
                time, message = float(track.t[k - 1]), NO_ACCELERATION
        return SimulationDiverged(message, time, *state, track.applied[k - 1], self._result(k))

    def _is_stuck(self, positions: Array, speeds: Array, forces: Array) -> bool:
        """Tell whether a state has no finite acceleration, so that not a pose is the reason."""
        self._plant.start(positions.copy(), speeds.copy())
        # A motor's inertia can be enough, which only the plant knows.
        if self._plant.advance(forces.copy(), INSTANT * self._wiring.period) is not None:
            return False
        robot = self._robot
        if not robot.drives_coordinates:
            forces = robot.actuation_matrix(positions) @ forces
        try:
            robot.forward_dynamics(positions, speeds, forces)
        except NoFiniteAnswer:
            return True
        except NO_POSE:
            pass
        return False


def _tips(robot: Robot, positions: Array) -> Array:
    """Return the tip at the given positions, NaN where there is none.

    Another engine may pass through a pose that this package cannot close.
    """
    try:
        return robot.tip(positions)
    except NO_POSE:
        if len(positions) == 1:
            return np.full((1, 3), np.nan)
        return np.concatenate([_tips(robot, row[np.newaxis]) for row in positions])
