"""Desired motions of the tip or of the joints.

Inverse kinematics converts a path of the tip to nut heights with their rates.

A trajectory is called with a time or an array of times and returns a :class:`Motion`. Paths of the
tip are for the 3-PSP only, because its inverse kinematics is known; paths of the actuated joints
are for any robot. The call raises an error if the robot cannot follow the path.
:meth:`Trajectory.check` also checks the limits of the actuated joints, and a simulation does so
before it starts.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.support.described import Described
from psp3.checks import Array, checked_robot
from psp3.collisions.motion import check_clearance
from psp3.errors import InvalidValue, UnknownName
from psp3.robots.robot import Robot
from psp3.trajectories.motion import Motion, check_stroke, completed, finite_times, tip_of

SPACES = ("tip", "joints")
"""Names of the spaces of a path."""


@cache
def _default_robot() -> Robot:
    from psp3.loading import load

    return load("psp3")


class Trajectory(Described):
    """Base of the trajectories: a path in time, of the tip or of the actuated joints.

    A subclass implements ``_path(t)``, the position on the path with its velocity and acceleration,
    or overrides ``__call__``.

    Parameters
    ----------
    robot : Robot, optional
        The robot that moves; ``psp3.load("psp3")`` by default.
    space : str, optional
        ``"tip"``, a path of the tip in base axes [m], or ``"joints"``, a path of the n actuated
        joints [m or rad], or of the coordinates that the motors command (``robot.commanded``). The
        default is the tip for a 3-PSP, and the joints for any other robot.

    Raises
    ------
    UnknownName
        If there is no such space.
    InvalidValue
        If the path is one of the tip and the robot is not a 3-PSP.
    """

    duration: float | None = None
    """Time after which the robot rests [s]; None if it never does."""

    def __init__(self, robot: Robot | None = None, space: str | None = None) -> None:
        if robot is not None:
            checked_robot(robot)
        self.robot: Robot = _default_robot() if robot is None else robot
        has_inverse = self.robot.has_inverse_of_tip
        self.space = ("tip" if has_inverse else "joints") if space is None else space
        if self.space not in SPACES:
            raise UnknownName("space", space, SPACES)
        if self.space == "tip" and not has_inverse:
            raise InvalidValue(
                "space",
                "tip",
                "'joints': only the tip of the 3-PSP has an inverse kinematics",
            )

    def _facts(self) -> dict[str, Any]:
        duration = None if self.duration is None else f"{self.duration:g} s"
        return {**self._shape(), "duration": duration, "space": self.space, "robot": self.robot}

    def _shape(self) -> dict[str, Any]:
        """Return the parameters of a subclass's path, see :class:`Described`."""
        return {}

    @property
    def width(self) -> int:
        """Number of coordinates of a point on the path."""
        return 3 if self.space == "tip" else self.robot.commanded

    def __call__(self, t: ArrayLike) -> Motion:
        r"""Return the desired motion at given times.

        .. math:: \dot a = J^{-1} \dot x, \qquad \ddot a = J^{-1} (\ddot x - \dot J \dot a)

        Parameters
        ----------
        t : (...,) array_like
            Times from the start [s].

        Returns
        -------
        Motion
            ``.positions .speeds .accelerations``, each (..., n), and ``.tip`` (..., 3).

        Raises
        ------
        InvalidArray
            If a time is not finite.
        InvalidValue
            If the motion is too fast or too long for floating-point numbers.
        UnreachableTip
            If the tip would have to leave its reach.
        UnreachablePose, ClosureFailed, JointLimitExceeded
            If the robot cannot take a pose of the joints.
        """
        point, velocity, acceleration = self._finite_path(finite_times(t))
        if self.space == "joints":
            return Motion(point, velocity, acceleration, tip_of(self.robot, point))
        return Motion(*self.robot.motion_of_tip(point, velocity, acceleration), point)

    def _finite_path(self, t: Array) -> tuple[Array, Array, Array]:
        """Return the path; raise :class:`InvalidValue` if its numbers overflow."""
        try:
            with np.errstate(all="ignore"):
                path = self._path(t)
        except OverflowError:
            path = (np.full(1, np.nan),) * 3
        if not all(np.isfinite(part).all() for part in path):
            raise InvalidValue(
                type(self).__name__,
                "a motion whose numbers overflow",
                "slower, with a longer period or duration, or shorter if it is very long",
            )
        return path

    def _path(self, t: Array) -> tuple[Array, Array, Array]:
        raise NotImplementedError(
            f"{type(self).__name__} must return a position with its velocity and acceleration"
        )

    def check(self, t: ArrayLike, clearance: float | None = None) -> Motion:
        """Return the motion at given times, provided that the robot can make it.

        Parameters
        ----------
        t : (N,) array_like
            Times [s].
        clearance : float, optional
            Smallest allowed distance between links [m]; not checked by default.

        Returns
        -------
        Motion
            As from a call.

        Raises
        ------
        InvalidArray, UnreachableTip, UnreachablePose, ClosureFailed, JointLimitExceeded
            As from a call.
        StrokeExceeded
            If a nut would have to leave its screw, or another actuated joint its limits.
        CollisionFound
            If two links would come closer to each other than ``clearance``.
        """
        motion = self(t)
        check_stroke(self.robot, np.asarray(t, dtype=float), motion)
        if clearance is not None:
            check_clearance(self.robot, completed(self.robot, motion.positions), t, clearance)
        return motion
