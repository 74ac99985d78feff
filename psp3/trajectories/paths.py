"""Paths given by formulas: helix, circle, hold, line and point to point."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from psp3.checks import Array, checked_finite, checked_not_negative, checked_positive, one_row
from psp3.robots.robot import Robot
from psp3.trajectories.trajectory import Trajectory


def _home(robot: Robot) -> Array:
    """Return the tip of a robot in its home pose."""
    return robot.tip(robot.reference)


class Helix(Trajectory):
    r"""A helix about the vertical axis, the thesis's trajectory.

    .. math:: x(t) = \big( r \cos\omega t,\; r \sin\omega t,\; z_0 + \dot z t \big), \qquad
              \omega = 2\pi / T

    Parameters
    ----------
    radius : float
        Radius r [m]. The tip's reach is smallest at the azimuths of the screws, 23.9 mm.
    period : float
        Time T for one turn [s].
    rise : float
        Vertical speed [m/s].
    height : float, optional
        Height of the tip at the start [m]; that of the home pose by default.
    robot : Robot, optional
        See :class:`Trajectory`.

    Raises
    ------
    InvalidValue
        If the radius is negative, the period is not positive, a number is not finite, or the robot
        is not a 3-PSP.
    """

    def __init__(
        self,
        radius: float = 0.020,
        period: float = 2.0,
        rise: float = 0.010,
        height: float | None = None,
        robot: Robot | None = None,
    ) -> None:
        super().__init__(robot, "tip")
        self.radius = checked_not_negative("radius", radius)
        self.period = checked_positive("period", period)
        self.rise = checked_finite("rise", rise)
        self.height = (
            float(_home(self.robot)[2]) if height is None else checked_finite("height", height)
        )

    def _shape(self) -> dict[str, Any]:
        return {
            "radius": f"{self.radius:g} m",
            "period": f"{self.period:g} s",
            "rise": f"{self.rise:g} m/s",
        }

    def _path(self, t: Array) -> tuple[Array, Array, Array]:
        omega = 2.0 * np.pi / self.period
        x, y = self.radius * np.cos(omega * t), self.radius * np.sin(omega * t)
        zero = np.zeros_like(t)
        return (
            np.stack([x, y, self.height + self.rise * t], axis=-1),
            np.stack([-omega * y, omega * x, zero + self.rise], axis=-1),
            np.stack([-(omega**2) * x, -(omega**2) * y, zero], axis=-1),
        )


class Circle(Helix):
    """A level circle about the vertical axis: a :class:`Helix` that does not rise.

    Parameters
    ----------
    radius, period, height, robot
        See :class:`Helix`.
    """

    def __init__(
        self,
        radius: float = 0.020,
        period: float = 2.0,
        height: float | None = None,
        robot: Robot | None = None,
    ) -> None:
        super().__init__(radius, period, 0.0, height, robot)


class Hold(Trajectory):
    """A constant position: the robot rests.

    Parameters
    ----------
    point : array_like, optional
        Position of the tip, (3,) [m], or of the actuated joints, (n,) [m or rad]; by default that
        of the home or reference pose.
    robot, space
        See :class:`Trajectory`.
    """

    duration = 0.0

    def __init__(
        self,
        point: ArrayLike | None = None,
        robot: Robot | None = None,
        space: str | None = None,
    ) -> None:
        super().__init__(robot, space)
        if point is None:
            self.point = (
                _home(self.robot)
                if self.space == "tip"
                else self.robot.reference[: self.robot.commanded]
            )
        else:
            self.point = one_row("point", point, self.width)

    def _shape(self) -> dict[str, Any]:
        return {"point": self.point}

    def _path(self, t: Array) -> tuple[Array, Array, Array]:
        point = np.broadcast_to(self.point, (*t.shape, self.width)).copy()
        return point, np.zeros_like(point), np.zeros_like(point)


class _Segment(Trajectory):
    """A straight path from one point to another, in a given time, at rest before and after."""

    def __init__(
        self,
        start: ArrayLike,
        end: ArrayLike,
        duration: float,
        robot: Robot | None = None,
        space: str | None = None,
    ) -> None:
        super().__init__(robot, space)
        self.start, self.end = one_row("start", start, self.width), one_row("end", end, self.width)
        self.duration: float = checked_positive("duration", duration)

    def _shape(self) -> dict[str, Any]:
        return {"start": self.start, "end": self.end}

    def _progress(self, x: Array) -> tuple[Array, Array, Array]:
        """Return the share of the way at the share x of the time, with its first two derivatives.

        Both shares are within [0, 1].
        """
        raise NotImplementedError

    def _path(self, t: Array) -> tuple[Array, Array, Array]:
        moving = (t >= 0.0) & (t <= self.duration)
        share, rate, curvature = self._progress(np.clip(t / self.duration, 0.0, 1.0))
        way = self.end - self.start
        return (
            self.start + share[..., np.newaxis] * way,
            np.where(moving, rate / self.duration, 0.0)[..., np.newaxis] * way,
            np.where(moving, curvature / self.duration**2, 0.0)[..., np.newaxis] * way,
        )


class Line(_Segment):
    r"""A straight line at constant speed.

    :math:`x(t) = x_0 + (x_1 - x_0)\, t/T`, at rest before and after.

    The speed jumps at both ends; :class:`PointToPoint` starts and stops smoothly.

    Parameters
    ----------
    start, end : array_like
        Tip, (3,) [m], or actuated joints, (n,) [m or rad], at time 0 and at time ``duration``.
    duration : float
        Time T from start to end [s].
    robot, space
        See :class:`Trajectory`.
    """

    def _progress(self, x: Array) -> tuple[Array, Array, Array]:
        return x, np.ones_like(x), np.zeros_like(x)


class PointToPoint(_Segment):
    r"""A straight line from rest to rest with continuous acceleration.

    The progress is the quintic :math:`s = 10x^3 - 15x^4 + 6x^5`, :math:`x = t/T`.

    Parameters
    ----------
    start, end, duration, robot, space
        See :class:`Line`.
    """

    def _progress(self, x: Array) -> tuple[Array, Array, Array]:
        return (
            x**3 * (10.0 - 15.0 * x + 6.0 * x**2),
            30.0 * x**2 * (1.0 - x) ** 2,
            60.0 * x * (1.0 - x) * (1.0 - 2.0 * x),
        )
