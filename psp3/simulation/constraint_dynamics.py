"""A plant that is the whole tree, under Pinocchio's ``constraintDynamics``."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from psp3.checks import Array, checked_not_negative
from psp3.description.parts import RobotParts
from psp3.drives.drive import NO_DRIVE, Drive, drive_table
from psp3.dynamics.projected import ProjectedDynamics
from psp3.robots.robot import Robot
from psp3.simulation.runge_kutta import FixedSteps


class ConstraintDynamics(FixedSteps):
    r"""The whole tree under Pinocchio's ``constraintDynamics``.

    It is integrated with classical Runge–Kutta steps.

    The loops are constraints on accelerations, so integration errors would open them slowly;
    Baumgarte's stabilization adds :math:`2\omega \dot\phi + \omega^2 \phi` to pull them shut. Motor
    inertia is Pinocchio's armature, friction a force on the joint.

    Parameters
    ----------
    robot : Robot
        Any robot with loops.
    frequency : float
        :math:`\omega` [1/s]; critically damped. Zero switches stabilization off.
    steps : int
        Integration steps in a control period.
    drive : Drive or sequence of Drive
        Friction and motor inertia of all actuated joints, or of each.
    """

    def __init__(
        self,
        robot: Robot,
        frequency: float = 20.0,
        steps: int = 1,
        drive: Drive | Sequence[Drive] = NO_DRIVE,
    ) -> None:
        frequency = checked_not_negative("frequency", frequency)
        closures = pin.StdVec_RigidConstraintModel()
        for closure in robot.constraint_models:
            stabilized = pin.RigidConstraintModel(closure)
            stabilized.setBaumgarteCorrectorParameters(
                pin.BaumgarteCorrectorParameters(frequency**2, 2.0 * frequency)
            )
            closures.append(stabilized)
        joints = [robot.model.joints[robot.model.getJointId(name)] for name in robot.actuated]
        places, rows = (
            np.array([joint.idx_q for joint in joints]),
            np.array([joint.idx_v for joint in joints]),
        )
        model = robot.model.copy()
        armature = np.array(model.armature)
        armature[rows] += drive_table(drive, len(joints))[:, 0]
        model.armature = armature
        self._tree = ProjectedDynamics(
            RobotParts(model, closures, robot.actuated, robot.q0, robot.visual_model)
        )
        super().__init__(robot, steps, drive)
        self._places, self._rows = places, rows
        self.q, self.v = robot.q0, np.zeros(model.nv)

    def start(self, positions: Array, speeds: Array) -> None:
        """Put the robot into a state; positions and speeds of the actuated joints."""
        self.q = self._robot.configuration(positions)
        self.v = self._robot.velocity(positions, speeds)

    def _is_pose(self) -> bool:
        return bool(np.isfinite(self.q).all() and np.isfinite(self.v).all())

    def _moved(self, q: Array, way: Array) -> Array:
        return np.asarray(pin.integrate(self._robot.model, q, way))

    def _balance(self, q: Array, v: Array, forces: Array) -> tuple[Array, Array]:
        """Return M + J as the inverse of what unit forces do.

        And the force that would do what the forces do.
        """

        def rows(force: Array) -> Array:
            return self._tree.constrained_accelerations(q, v, force)[self._rows]

        applied = rows(forces - self._drives[:, self._kernels.VISCOUS] * v[self._rows])
        idle = rows(np.zeros(self._joints))
        mass = np.linalg.inv(np.stack([rows(unit) - idle for unit in np.eye(self._joints)], axis=1))
        return mass, mass @ applied

    def _accelerations(self, q: Array, v: Array, forces: Array) -> Array:
        if self._is_driven:
            _, viscous, dry = self._drives.T
            friction = dry * self._slip
            sticks = self._slip == 0.0
            if sticks.any():
                mass, net = self._balance(q, v, forces)
                friction[sticks] = (net - mass @ self._joint_accelerations(mass, net))[sticks]
            acceleration = self._tree.constrained_accelerations(
                q, v, forces - viscous * v[self._rows] - friction
            )
            # What sticks rests to the last bit, not only to rounding.
            acceleration[self._rows[sticks]] = 0.0
            return acceleration
        return self._tree.constrained_accelerations(q, v, forces)
