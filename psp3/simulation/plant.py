"""What a simulation needs of a plant, and what plants with drives have in common."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from psp3.checks import Array
from psp3.drives.drive import Drive, drive_table
from psp3.dynamics.dynamics_model import StateAfterState
from psp3.errors import (
    ClosureFailed,
    InvalidArray,
    InvalidValue,
    JointLimitExceeded,
    SingularConfiguration,
    UnreachablePose,
)
from psp3.robots.robot import Robot

NO_POSE = (
    InvalidArray,
    InvalidValue,
    UnreachablePose,
    ClosureFailed,
    JointLimitExceeded,
    SingularConfiguration,
)
"""What robots raise for a state that is none of theirs, once a state has been accepted."""


class Plant(Protocol):
    """What the simulation needs of a plant."""

    def start(self, positions: Array, speeds: Array) -> None:
        """Put the robot into a state."""
        ...

    def advance(self, forces: Array, duration: float) -> tuple[Array, Array] | None:
        """Return positions and speeds after some time under constant forces.

        None if the robot left the poses it can take.
        """
        ...


class DrivenPlant:
    """A robot with drives in Python, in actuated coordinates.

    What is common to the ways to integrate it.

    Raises
    ------
    InvalidValue
        If the robot's coordinates are not those of its motors.
    """

    def __init__(self, robot: Robot, drive: Drive | Sequence[Drive]) -> None:
        from psp3.drives import kernels as drive_kernels

        if not robot.drives_coordinates:
            raise InvalidValue(
                f"robot of {type(self).__name__}",
                robot.title,
                "one whose coordinates are those of its motors; RungeKutta takes any",
            )
        self._robot, self._kernels, self._joints = robot, drive_kernels, len(robot.actuated)
        self._drives = drive_table(drive, self._joints)
        # The joints' own friction, too, can hold them.
        self._own_friction = np.array(robot.model.upperDryFrictionLimit[robot.coordinates_v])
        self._drives[:, drive_kernels.DRY] += self._own_friction
        self._is_driven, self._is_dry = (
            bool(self._drives.any()),
            self._drives[:, drive_kernels.DRY] > 0.0,
        )
        self._slip = np.ones(self._joints)
        self._states = StateAfterState(robot)

    def _balance(self, q: Array, v: Array, forces: Array) -> tuple[Array, Array]:
        """Return M + J, and what is left of the forces for acceleration and dry friction."""
        inertia, viscous, _ = self._drives.T
        return (
            self._states.ask(self._robot.mass_matrix, q) + np.diag(inertia),
            forces
            - self._states.ask(self._robot.inverse_dynamics, q, v, np.zeros_like(v))
            + self._own_friction * np.sign(v)
            - viscous * v,
        )

    def _accelerations(self, q: Array, v: Array, forces: Array) -> Array:
        """Return the derivative of v while the slip of the joints is constant."""
        if self._is_driven:
            return self._joint_accelerations(*self._balance(q, v, forces))
        accelerations: Array = self._states.ask(self._robot.forward_dynamics, q, v, forces)
        return accelerations

    def _joint_accelerations(self, mass: Array, net: Array) -> Array:
        out = np.empty(self._joints)
        self._kernels.accelerations(mass, net, self._drives, self._slip, out)
        return out

    def _choose_slip(self, q: Array, v: Array, speeds: Array, forces: Array) -> None:
        """Find out which joints stick, and which way the others slip."""
        if self._kernels.slip_of(self._drives, speeds, self._slip):
            self._kernels.choose_slip(
                *self._balance(q, v, forces), self._drives, speeds, self._slip
            )
