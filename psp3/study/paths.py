"""Desired motions for the runs of a study, by name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from psp3.checks import Array
from psp3.trajectories.fourier_series import FourierSeries
from psp3.trajectories.paths import Circle, Helix, Hold, PointToPoint
from psp3.trajectories.recorded import Waypoints
from psp3.trajectories.sway import Sway
from psp3.trajectories.trajectory import Trajectory

PathOf = Callable[[Any], Trajectory]

FAST_SWAY = 1.0
"""Duration of the fast sway [s]; the sway for learning takes twice as long."""


def _square(robot: Any) -> Trajectory:
    """Return a square with sides of 24 mm, one corner per second, that rises like the helix."""
    angles = 0.5 * np.pi * np.arange(11)
    across = 0.012 * np.sqrt(2.0)
    rise = robot.parameters.tool_length + 0.010 * np.arange(11)
    return Waypoints(
        np.arange(11.0),
        np.stack([across * np.cos(angles), across * np.sin(angles), rise], axis=-1),
        robot,
    )


def _small_sway(robot: Any) -> Trajectory:
    """Return a sway of half the amplitudes, within the learned region."""
    whole = Sway(robot=robot)
    home = robot.reference[: robot.commanded]
    return FourierSeries(
        home + 0.5 * (whole.center - home),
        0.5 * whole.sines,
        0.5 * whole.cosines,
        whole.period,
        robot,
    )


TRAJECTORIES: dict[str, PathOf] = {
    "helix": lambda robot: Helix(robot=robot),
    "circle": lambda robot: Circle(robot=robot),
    "line": lambda robot: PointToPoint((-0.02, 0.0, 0.07), (0.02, 0.01, 0.12), 10.0, robot),
    "fast-helix": lambda robot: Helix(period=1.0, robot=robot),
    "fastest-helix": lambda robot: Helix(period=0.4, robot=robot),
    "large-helix": lambda robot: Helix(radius=0.0235, robot=robot),
    "waypoints": _square,
}
"""Trajectories of the 3-PSP by name; the estimators are trained on the first."""

TRAJECTORIES_OF_OTHERS: dict[str, PathOf] = {
    "sway": lambda robot: Sway(robot=robot),
    "fast-sway": lambda robot: Sway(period=FAST_SWAY, robot=robot),
    "small-sway": _small_sway,
    "hold": lambda robot: Hold(robot=robot),
}
"""Trajectories of any other robot by name; the estimators are trained on the first."""

TRAINED_RADIUS = 0.012
"""Radius of the narrow helix [m]."""

RADII, PERIODS = (0.007, TRAINED_RADIUS), (2.0, 3.0)
"""Ranges from which the radius [m] and the time for a turn [s] of helices are drawn; the narrow
helix has the largest radius and the shortest time.
"""

WIDE_RADIUS, FASTER = 0.022, 2.0
"""Radius [m] after the departure, and factor on the speed."""

EVENT, CHANGE = 5.0, 1.0
"""Time of the event, and duration of a change of speed or radius [s]."""


class DepartingHelix(Trajectory):
    r"""A helix whose speed and radius change smoothly from one value to another.

    .. math:: x = \big(r \cos\varphi,\; r \sin\varphi,\; z_0 + \dot z t\big), \qquad
              r = r_0 + (r_1 - r_0)\, b(t), \quad
              \dot\varphi = \tfrac{2\pi}{T} \big(1 + (q - 1)\, b(t)\big)

    with the smooth step b from 0 to 1 that has no speed and no acceleration at its ends,
    :math:`b(s) = 10 s^3 - 15 s^4 + 6 s^5`.

    Parameters
    ----------
    radius, period, phase : float
        Radius [m], time for a turn [s] and azimuth [rad] at the start.
    last_radius, speed_up : float
        Radius at the end [m], and factor q of the speed there.
    robot : PSP3
        See :class:`psp3.trajectories.trajectory.Trajectory`.

    Attributes
    ----------
    height : float
        Level :math:`z_0`, that of the tip in the home pose [m].
    """

    def __init__(
        self,
        radius: float,
        period: float,
        phase: float,
        last_radius: float,
        speed_up: float,
        robot: Any,
    ) -> None:
        super().__init__(robot, "tip")
        self.radius, self.period, self.phase = radius, period, phase
        self.last_radius, self.speed_up = last_radius, speed_up
        self.height = robot.parameters.tool_length

    def _path(self, t: Array) -> tuple[Array, Array, Array]:
        s = np.clip((t - EVENT) / CHANGE, 0.0, 1.0)
        # The step, its integral over time, and its derivatives.
        step, rate = s**3 * (10.0 - 15.0 * s + 6.0 * s**2), 30.0 * s**2 * (1.0 - s) ** 2 / CHANGE
        bend = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / CHANGE**2
        area = CHANGE * s**4 * (2.5 - 3.0 * s + s**2) + np.maximum(t - EVENT - CHANGE, 0.0)
        omega, gain, growth = (
            2.0 * np.pi / self.period,
            self.speed_up - 1.0,
            self.last_radius - self.radius,
        )
        angle, turn, hurry = (
            self.phase + omega * (t + gain * area),
            omega * (1.0 + gain * step),
            omega * gain * rate,
        )
        r, out, push = self.radius + growth * step, growth * rate, growth * bend
        cosine, sine, zero = np.cos(angle), np.sin(angle), np.zeros_like(t)
        along, across = push - r * turn**2, 2.0 * out * turn + r * hurry
        return (
            np.stack([r * cosine, r * sine, self.height + 0.01 * t], axis=-1),
            np.stack(
                [out * cosine - r * turn * sine, out * sine + r * turn * cosine, zero + 0.01],
                axis=-1,
            ),
            np.stack(
                [along * cosine - across * sine, along * sine + across * cosine, zero], axis=-1
            ),
        )


def _drawn(last_radius: float, speed_up: float) -> Callable[[Any, np.random.Generator], Trajectory]:
    """Return a function that draws helices departing to a radius (0 keeps it) and speed."""

    def draw(robot: Any, rng: np.random.Generator) -> Trajectory:
        radius, period = rng.uniform(*RADII), rng.uniform(*PERIODS)
        phase = rng.uniform(0.0, 2.0 * np.pi)
        return DepartingHelix(radius, period, phase, last_radius or radius, speed_up, robot)

    return draw


NARROW = "narrow-helix"
"""The helix to learn on; it encloses all drawn ones."""

TRAJECTORIES_OF_MONITORS: dict[str, Callable[[Any, np.random.Generator], Trajectory]] = {
    NARROW: lambda robot, rng: Helix(radius=TRAINED_RADIUS, period=PERIODS[0], robot=robot),
    "drawn-helix": _drawn(0.0, 1.0),
    "drawn-helix-faster": _drawn(0.0, FASTER),
    "drawn-helix-wider": _drawn(WIDE_RADIUS, 1.0),
}
"""Trajectories of the 3-PSP on which monitors are tried: the narrow helix, and helices within it
that the seed draws. The last two depart from the learned region at :data:`EVENT`.
"""

DRAWN = tuple(name for name in TRAJECTORIES_OF_MONITORS if name != NARROW)
"""Names of the trajectories that depend on the seed."""


def names_of_paths(robot: str) -> tuple[str, ...]:
    """Return the names of a robot's trajectories; the first is the one for learning."""
    if robot == "psp3":
        return *TRAJECTORIES, *TRAJECTORIES_OF_MONITORS
    return tuple(TRAJECTORIES_OF_OTHERS)


def path_named(name: str, robot_name: str, robot: Any, rng: np.random.Generator) -> Trajectory:
    """Return a trajectory by name; ``rng`` draws the ones in :data:`DRAWN`."""
    if name in TRAJECTORIES_OF_MONITORS:
        return TRAJECTORIES_OF_MONITORS[name](robot, rng)
    known = TRAJECTORIES if robot_name == "psp3" else TRAJECTORIES_OF_OTHERS
    return known[name](robot)
