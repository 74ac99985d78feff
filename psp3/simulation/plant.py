"""The interface of a plant, and the common parts of plants with drives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from fuzzy2.support.described import Described
from psp3.checks import Array
from psp3.drives.drive import Drive
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
from psp3.simulation.rates import RatesOfConfiguration

NO_POSE = (
    InvalidArray,
    InvalidValue,
    UnreachablePose,
    ClosureFailed,
    JointLimitExceeded,
    SingularConfiguration,
)
"""Errors that robots raise during a motion for a state that they cannot take."""


class Plant(Protocol):
    """The interface that the simulation needs from a plant."""

    def start(self, positions: Array, speeds: Array) -> None:
        """Set the state."""
        ...

    def advance(self, forces: Array, duration: float) -> tuple[Array, Array] | None:
        """Return positions and speeds after a time under constant forces.

        It is None if the robot left its reachable poses.
        """
        ...


class DrivenPlant(Described):
    """A robot with drives in Python, in its coordinates.

    It is the common part of all integrators. Forces are those of the motors.
    """

    def __init__(self, robot: Robot, drive: Drive | Sequence[Drive]) -> None:
        from psp3.drives import kernels as drive_kernels

        self._robot, self._kernels = robot, drive_kernels
        self._joints, self._positions = len(robot.coordinates_v), len(robot.reference)
        self._driven = robot.drives_of_coordinates(drive)
        self._drives = self._driven.coordinates.copy()
        # The joints' own friction can hold them, too.
        self._own_friction = np.array(robot.model.upperDryFrictionLimit[robot.coordinates_v])
        self._followers = np.setdiff1d(self._driven.joints, robot.coordinates_v)
        self._states = StateAfterState(robot)
        self._tree_rates = RatesOfConfiguration(robot.model)
        self._take_dry_friction(robot.reference)
        self._is_driven = bool(self._drives.any() or self._driven.follows.size)
        self._is_dry = self._drives[:, drive_kernels.DRY] > 0.0
        self._slip = np.ones(self._joints)

    def _facts(self) -> dict[str, Any]:
        return {"robot": self._robot}

    def _joint_speeds(self, q: Array) -> Array:
        """Return the velocities of all joints at each coordinate's unit speed, (n, nv)."""
        speeds: Array = self._robot.velocity(q, np.eye(self._joints))
        return speeds

    def _take_dry_friction(self, q: Array) -> Array:
        """Set the dry friction at a pose; return levers of drives not at coordinates, (n, w)."""
        dry, follows = self._kernels.DRY, self._driven.follows
        if not follows.size:
            return np.empty((self._joints, 0))
        levers: Array = self._joint_speeds(q) @ self._driven.columns
        self._drives[:, dry] = self._driven.coordinates[:, dry]
        alone = np.flatnonzero(follows >= 0)
        held = np.abs(levers[follows[alone], alone]) * self._driven.elsewhere[alone, dry]
        np.add.at(self._drives[:, dry], follows[alone], held)
        return levers

    def _sliding_friction(self, speeds: Array) -> Array:
        """Return the dry friction of drives that several coordinates move, (w,)."""
        friction = self._driven.elsewhere[:, self._kernels.DRY] * np.sign(speeds)
        return np.where(self._driven.follows >= 0, 0.0, friction)

    def _along(self, q: Array, forces: Array) -> Array:
        """Return the forces along the coordinates, (n,), of the motors' forces (m,)."""
        if self._robot.drives_coordinates:
            return forces
        along: Array = self._robot.actuation_matrix(q) @ forces
        return along

    def _rates(self, q: Array, v: Array) -> Array:
        """Return the rates of the positions (p,), which are speeds except for a floating base."""
        if len(q) == len(v):
            return v
        whole, speeds = self._whole(q), np.zeros(self._robot.model.nv)
        speeds[self._robot.coordinates_v] = v
        return self._tree_rates(whole, speeds)[self._robot.coordinates_q]

    def _normalized(self, q: Array) -> Array:
        """Return positions with a quaternion of unit length."""
        if self._positions == self._joints:
            return q
        return self._tree_rates.normalized(self._whole(q))[self._robot.coordinates_q]

    def _whole(self, q: Array) -> Array:
        """Return a configuration with these coordinates; other joints have arbitrary positions."""
        whole = self._robot.q0.copy()
        whole[self._robot.coordinates_q] = q
        return whole

    def _balance(self, q: Array, v: Array, forces: Array) -> tuple[Array, Array]:
        """Return M + J, and the forces that remain for acceleration and dry friction."""
        inertia, viscous, _ = self._drives.T
        mass = self._states.ask(self._robot.mass_matrix, q) + np.diag(inertia)
        net = (
            self._along(q, forces)
            - self._states.ask(self._robot.inverse_dynamics, q, v, np.zeros_like(v))
            + self._own_friction * np.sign(v)
            - viscous * v
        )
        if self._driven.follows.size:
            more, brake = self._elsewhere(q, v)
            mass, net = mass + more, net - brake
        return mass, net

    def _elsewhere(self, q: Array, v: Array) -> tuple[Array, Array]:
        """Return the mass of drives not at coordinates, and their forces at zero acceleration."""
        robot, driven, levers = self._robot, self._driven, self._take_dry_friction(q)
        whole, all_speeds = robot.configuration(q), robot.velocity(q, v)
        inertia, viscous, _ = driven.elsewhere.T
        speeds = v @ levers
        forces = inertia * (robot.drift(whole, all_speeds) @ driven.columns) + viscous * speeds
        forces += self._sliding_friction(speeds)
        # Friction that holds passive joints must not be counted again in the joints' forces.
        followers = self._joint_speeds(q)[:, self._followers]
        own = robot.model.upperDryFrictionLimit[self._followers] * np.sign(v @ followers)
        return (levers * inertia) @ levers.T, levers @ forces - followers @ own

    def _accelerations(self, q: Array, v: Array, forces: Array) -> Array:
        """Return the derivative of v while the joints' slip is constant."""
        if self._is_driven:
            return self._joint_accelerations(*self._balance(q, v, forces))
        accelerations: Array = self._states.ask(
            self._robot.forward_dynamics, q, v, self._along(q, forces)
        )
        return accelerations

    def _joint_accelerations(self, mass: Array, net: Array) -> Array:
        out = np.empty(self._joints)
        self._kernels.accelerations(mass, net, self._drives, self._slip, out)
        return out

    def _choose_slip(self, q: Array, v: Array, speeds: Array, forces: Array) -> None:
        """Determine which joints stick, and the direction in which the others slip."""
        if self._kernels.slip_of(self._drives, speeds, self._slip):
            self._kernels.choose_slip(
                *self._balance(q, v, forces), self._drives, speeds, self._slip
            )
