"""A demonstration motion for any robot: the motors swing about the reference pose."""

from __future__ import annotations

import numpy as np

from psp3.checks import Array, checked_positive
from psp3.closure.structure import robot_size
from psp3.errors import (
    ClosureFailed,
    InvalidValue,
    JointLimitExceeded,
    NoFiniteAnswer,
    SingularConfiguration,
    StrokeExceeded,
    UnreachablePose,
)
from psp3.kinematics.tasks import rotating
from psp3.robots.robot import Robot
from psp3.trajectories.fourier_series import FourierSeries
from psp3.trajectories.trajectory import Trajectory

LARGEST = 0.4
"""Largest initial amplitude of a joint [rad, or sizes of the robot]."""

ROOM = 0.3
"""Largest initial amplitude as a share of the distance to the nearer limit, or of the whole range
if the reference is at a limit.
"""

AT_A_LIMIT = 0.02
"""A joint that is closer to a limit than this share of its range only moves away from it."""

SAMPLES = 64
"""Number of times at which the motion is checked."""

HALVINGS = 8

ANOTHER_POSE = (
    "a pose home in an SRDF beside the URDF and of the same name, a key frame home in an MJCF, or "
    "q0 of psp3.ClosedLoopRobot"
)
"""How a robot gets another reference pose."""

NO_POSE = (
    ClosureFailed,
    JointLimitExceeded,
    NoFiniteAnswer,
    SingularConfiguration,
    StrokeExceeded,
    UnreachablePose,
)
"""Errors that mean that a robot cannot make a motion."""


class Sway(FourierSeries):
    r"""A periodic motion from rest of all n joints that motors command, each with its own phase.

    .. math:: a_i(t) = a_i(0) + A_i \big( \cos \varphi_i (1 - \cos \omega t)
              + \sin \varphi_i (\sin \omega t - \tfrac12 \sin 2 \omega t) \big), \qquad
              \varphi_i = 2 \pi i / n, \quad \omega = 2 \pi / T

    It starts and returns with speed zero. A joint whose reference is at a limit only moves away
    from it, with :math:`\varphi_i` of 0 or :math:`\pi`. If the coordinates of a robot are not its
    motors, the first ``robot.commanded`` coordinates move in this way, and the others follow.

    Parameters
    ----------
    amplitude : float, optional
        Amplitude A of all joints [m or rad]. By default each joint's amplitude depends on its
        limits and the robot's size, and all are halved until the robot can make the motion.
    period : float
        Time T after which the motion repeats [s].
    robot : Robot, optional
        See :class:`psp3.trajectories.trajectory.Trajectory`.

    Raises
    ------
    InvalidValue
        If a number is not positive, or the robot can hardly move from its reference pose.
    """

    def __init__(
        self, amplitude: float | None = None, period: float = 2.0, robot: Robot | None = None
    ) -> None:
        whose = Trajectory(robot, "joints").robot
        k = whose.commanded
        home = whose.reference[:k]
        still = np.zeros((2, len(home)))
        super().__init__(home, still, still, period, whose)
        lower, upper = (limit[:k] for limit in whose.limits)
        phases = _phases(home, lower, upper)
        if amplitude is not None:
            self._set(home, phases, np.full(len(home), checked_positive("amplitude", amplitude)))
            return
        amplitudes = _amplitudes(whose, home, lower, upper)
        for _ in range(HALVINGS):
            self._set(home, phases, amplitudes)
            try:
                self.check(np.linspace(0.0, self.period, SAMPLES))
            except NO_POSE:
                amplitudes = 0.5 * amplitudes
            else:
                return
        raise InvalidValue(
            "reference pose",
            home.tolist(),
            f"farther from singular poses and limits, because {self.robot.title} can hardly move "
            f"from it (give another: {ANOTHER_POSE}; or a small amplitude=...)",
        )

    @property
    def amplitudes(self) -> Array:
        """Amplitudes :math:`A_i` of the joints, (n,) [m or rad]."""
        found: Array = np.hypot(self.cosines[0], self.sines[0])
        return found

    def _set(self, home: Array, phases: Array, amplitudes: Array) -> None:
        out, across = amplitudes * np.cos(phases), amplitudes * np.sin(phases)
        self.center = home + out
        self.sines, self.cosines = np.stack([across, -0.5 * across]), np.stack([-out, 0.0 * out])


def _phases(home: Array, lower: Array, upper: Array) -> Array:
    """Return the phases of the joints; a joint at a limit moves away from it."""
    phases = 2.0 * np.pi * np.arange(len(home)) / len(home)
    near = AT_A_LIMIT * _range(lower, upper)
    phases = np.where(np.isfinite(near) & (home - lower <= near), 0.0, phases)
    return np.where(np.isfinite(near) & (upper - home <= near), np.pi, phases)


def _amplitudes(robot: Robot, home: Array, lower: Array, upper: Array) -> Array:
    """Return amplitudes that limits and size allow, without a check of the loops."""
    room = np.minimum(home - lower, upper - home)
    between = _range(lower, upper)
    at_a_limit = room <= AT_A_LIMIT * between
    room = np.where(at_a_limit & np.isfinite(between), 0.5 * between, room)
    size = robot_size(robot.model, robot.q0)
    turning = rotating(robot.model)[robot.coordinates_v[: len(home)]]
    return np.minimum(ROOM * room, LARGEST * np.where(turning, 1.0, size))


def _range(lower: Array, upper: Array) -> Array:
    """Return the distances between limits; Pinocchio represents no limit as the largest number."""
    with np.errstate(over="ignore"):
        between: Array = upper - lower
    return between
