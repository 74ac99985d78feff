r"""From a motion of the tip to the forces of the screws.

This is the thesis's inverse dynamics (Figures 27, 28 and 31).

Inverse kinematics gives the nut heights and their rates along the tip's path, and the equation of
motion gives the forces:

.. math:: \tau = M(a)\, \ddot a + C(a, \dot a)\, \dot a + G(a) \qquad \text{(eq. 3.1)}
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from psp3.checks import Array
from psp3.dynamics.dynamics_model import DynamicsModel
from psp3.errors import InvalidArray, InvalidValue
from psp3.trajectories.motion import Motion, finite_times
from psp3.trajectories.trajectory import Trajectory


@dataclass(frozen=True)
class ScrewForces:
    """A motion with its screw forces, sampled in time.

    Parameters
    ----------
    t : (N,) ndarray
        Times [s].
    motion : Motion
        ``.positions .speeds .accelerations .tip``, each (N, 3).
    inertial, coriolis, gravity : (N, 3) ndarray
        The three terms of eq. 3.1 [N]. If a robot has more motors than coordinates, they are those
        of the motors, each with the least norm.
    """

    t: Array
    motion: Motion
    inertial: Array
    coriolis: Array
    gravity: Array

    @property
    def forces(self) -> Array:
        """Forces along the screws, the sum of the three terms, of shape (N, 3) [N]."""
        total: Array = self.inertial + self.coriolis + self.gravity
        return total

    def columns(self) -> dict[str, Array]:
        """Return everything as columns of a table, each of shape (N,), in SI units.

        Returns
        -------
        dict of str to ndarray
            ``t``, the tip ``x y z``, then ``a1 a2 a3`` and likewise ``speed``, ``acceleration`` and
            ``force``. With the names as the first line, :class:`psp3.trajectories.recorded.FromCSV`
            can read the table.
        """
        columns = {"t": self.t, **dict(zip("xyz", self.motion.tip.T, strict=True))}
        for name, values in (
            ("a", self.motion.positions),
            ("speed", self.motion.speeds),
            ("acceleration", self.motion.accelerations),
            ("force", self.forces),
        ):
            columns |= {f"{name}{k}": column for k, column in enumerate(values.T, start=1)}
        return columns


def screw_forces(
    trajectory: Trajectory, t: ArrayLike, model: DynamicsModel | None = None
) -> ScrewForces:
    """Return the screw forces of a trajectory.

    Parameters
    ----------
    trajectory : Trajectory
        The motion.
    t : (N,) array_like
        Times [s].
    model : DynamicsModel, optional
        Model that gives M, C and G; by default the trajectory's robot in closed form.
        ``robot.dynamics("noc")`` is the thesis's own method.

    Returns
    -------
    ScrewForces

    Raises
    ------
    InvalidArray
        If the times are not finite or not a list.
    InvalidValue
        If some of the robot's coordinates are not commanded by its motors.
    UnreachableTip, StrokeExceeded
        If the robot cannot make the motion.
    """
    times = finite_times(t)
    if times.ndim != 1:
        raise InvalidArray("t", "(N,)", times)
    robot = trajectory.robot
    if robot.commanded < len(robot.coordinates_v):
        followers = ", ".join(robot.coordinates[robot.commanded :])
        raise InvalidValue(
            "robot of a motion whose forces are asked for",
            robot.title,
            f"one whose motors command all coordinates: {followers} follow as the forces let them; "
            "simulate finds both",
        )
    motion = trajectory.check(times)
    M, C, G = (robot if model is None else model).equation_of_motion(
        motion.positions, motion.speeds
    )
    return ScrewForces(
        times,
        motion,
        *(
            robot.allocated_forces(motion.positions, forces)
            for forces in (
                np.einsum("nij,nj->ni", M, motion.accelerations),
                np.einsum("nij,nj->ni", C, motion.speeds),
                G,
            )
        ),
    )
