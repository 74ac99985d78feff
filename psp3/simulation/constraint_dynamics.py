"""A plant that integrates the whole tree under Pinocchio's ``constraintDynamics``."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from psp3.checks import Array, checked_not_negative
from psp3.closure.structure import EXACT
from psp3.drives.drive import NO_DRIVE, Drive
from psp3.dynamics.more_equations import MoreEquations
from psp3.dynamics.motors import RANK
from psp3.dynamics.projected import ConstraintSolver
from psp3.errors import InvalidValue
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from psp3.simulation.runge_kutta import FixedSteps


class ConstraintDynamics(FixedSteps):
    r"""The whole tree under Pinocchio's ``constraintDynamics``.

    It is integrated with classical Runge–Kutta steps.

    The loops are constraints on accelerations, so integration errors would open them slowly;
    Baumgarte's stabilization adds :math:`2\omega \dot\phi + \omega^2 \phi` to pull them shut. Motor
    inertia is Pinocchio's armature, or, for a motor that is not at a coordinate, the force that
    accelerates it. Friction, springs and damping are forces on the joints. Pinocchio has no
    constraints for couplings, hinges and held motions. They are kept closed by forces :math:`R^T
    \lambda` along the rows R of their equations, which follow from the effect of unit forces.

    Parameters
    ----------
    robot : ClosedLoopRobot
        A robot whose loops do not contradict each other by rounding.
    frequency : float
        :math:`\omega` [1/s]; critically damped. Zero switches stabilization off.
    steps : int
        Integration steps in a control period.
    drive : Drive or sequence of Drive
        Friction and motor inertia of all actuated joints, or of each.

    Raises
    ------
    InvalidValue
        If loops contradict each other by rounding.
    DisorderedJoints
        If the tree's joints are not ordered chain by chain, because Pinocchio is then wrong.
    """

    def __init__(
        self,
        robot: ClosedLoopRobot,
        frequency: float = 20.0,
        steps: int = 1,
        drive: Drive | Sequence[Drive] = NO_DRIVE,
    ) -> None:
        frequency = checked_not_negative("frequency", frequency)
        mismatch = robot.closure_mismatch
        if max(mismatch.length, mismatch.angle) > EXACT:
            raise InvalidValue(
                "robot of ConstraintDynamics",
                f"{robot.title}, whose loops contradict each other by {mismatch.length:.2g} m and "
                f"{mismatch.angle:.2g} rad",
                "one of more digits, because constraintDynamics errs where loops are rounded; "
                "RungeKutta takes any",
            )
        super().__init__(robot, steps, drive)
        closures = pin.StdVec_RigidConstraintModel()
        for closure in robot.constraint_models:
            stabilized = pin.RigidConstraintModel(closure)
            stabilized.setBaumgarteCorrectorParameters(
                pin.BaumgarteCorrectorParameters(frequency**2, 2.0 * frequency)
            )
            closures.append(stabilized)
        self._places, self._rows = robot.coordinates_q, robot.coordinates_v
        model = robot.model.copy()
        armature = np.array(model.armature)
        armature[self._rows] += self._drives[:, self._kernels.INERTIA]
        model.armature = armature
        is_redundant = robot.mobility.redundant_equations > 0
        self._solver = ConstraintSolver(model, closures, is_redundant)
        self._more = _MoreConstraints(robot, frequency)
        # Friction that can hold a coordinate at rest is counted as its drive's.
        self._dependent_friction = np.array(model.upperDryFrictionLimit)
        self._dependent_friction[self._driven.joints] = 0.0
        self._motors, self._springs = robot.motors, robot.springs
        self.q, self.v = robot.q0, np.zeros(model.nv)

    def start(self, positions: Array, speeds: Array) -> None:
        """Set the state; positions (p,) and speeds (n,) of the coordinates."""
        self.q = self._robot.configuration(positions)
        self.v = self._robot.velocity(positions, speeds)

    def _is_pose(self) -> bool:
        return bool(np.isfinite(self.q).all() and np.isfinite(self.v).all())

    def _rates(self, q: Array, v: Array) -> Array:
        return self._tree_rates(q, v)

    def _normalized(self, q: Array) -> Array:
        return self._tree_rates.normalized(q)

    def _solved(self, q: Array, v: Array, along: Array) -> Array:
        """Return the accelerations of all joints under forces on all joints."""
        inertia, columns = self._driven.elsewhere[:, self._kernels.INERTIA], self._driven.columns
        columns, inertia = columns[:, inertia > 0.0], inertia[inertia > 0.0]
        free = self._solved_without_motors(q, v, along)
        if not inertia.size:
            return free
        moved = [self._solved_without_motors(q, v, along + column) - free for column in columns.T]
        answers = np.stack(moved, axis=1)
        # Each motor loses the force that accelerates its own inertia.
        felt = np.eye(len(inertia)) + inertia[:, np.newaxis] * (columns.T @ answers)
        return np.asarray(free - answers @ np.linalg.solve(felt, inertia * (free @ columns)))

    def _solved_without_motors(self, q: Array, v: Array, along: Array) -> Array:
        """Return the accelerations without the inertia of motors that are not at a coordinate."""
        free = self._solver.accelerations(q, v, along)
        if not self._more.count:
            return free
        rows, wanted = self._more.at(q, v)
        moved = [self._solver.accelerations(q, v, along + row) - free for row in rows]
        answers = np.stack(moved, axis=1)
        # If equations are dependent, the forces of least norm are taken.
        forces = np.linalg.lstsq(rows @ answers, wanted - rows @ free, rcond=RANK)[0]
        return np.asarray(free + answers @ forces)

    def _along_joints(self, q: Array, v: Array, forces: Array, friction: Array) -> Array:
        """Return the forces on all joints: motors, drives, springs, damping and friction."""
        model = self._robot.model
        along: Array = self._motors @ forces - model.damping * v
        along -= self._dependent_friction * np.sign(v)
        for name, (stiffness, rest) in self._springs.items():
            joint = model.joints[model.getJointId(name)]
            along[joint.idx_v] -= stiffness * (q[joint.idx_q] - rest)
        along[self._rows] -= self._drives[:, self._kernels.VISCOUS] * v[self._rows] + friction
        driven, speeds = self._driven, v @ self._driven.columns
        brakes = driven.elsewhere[:, self._kernels.VISCOUS] * speeds
        return np.asarray(along - driven.columns @ (brakes + self._sliding_friction(speeds)))

    def _balance(self, q: Array, v: Array, forces: Array) -> tuple[Array, Array]:
        """Return M + J as the inverse of the accelerations under unit forces.

        Also return the force along the coordinates that is equivalent to all forces.
        """

        def rows(force: Array) -> Array:
            return self._solved(q, v, force)[self._rows]

        self._take_dry_friction(q[self._places])
        applied = rows(self._along_joints(q, v, forces, np.zeros(self._joints)))
        idle = rows(np.zeros(self._robot.model.nv))
        units = np.eye(self._robot.model.nv)[self._rows]
        mass = np.linalg.inv(np.stack([rows(unit) - idle for unit in units], axis=1))
        return mass, mass @ applied

    def _accelerations(self, q: Array, v: Array, forces: Array) -> Array:
        self._take_dry_friction(q[self._places])
        dry = self._drives[:, self._kernels.DRY]
        friction, sticks = dry * self._slip, self._is_dry & (self._slip == 0.0)
        if sticks.any():
            mass, net = self._balance(q, v, forces)
            friction[sticks] = (net - mass @ self._joint_accelerations(mass, net))[sticks]
        along = self._along_joints(q, v, forces, friction)
        acceleration = self._solved(q, v, along)
        # The speed of a sticking joint is set to exactly zero, because it only rounds to that.
        acceleration[self._rows[sticks]] = 0.0
        return acceleration


class _MoreConstraints:
    """Equations for which Pinocchio has no constraints, and velocities that are held at zero."""

    def __init__(self, robot: ClosedLoopRobot, frequency: float) -> None:
        model = robot.model
        spins = [one.spin for one in robot.locked if one.spin is not None]
        self._equations = MoreEquations(model, [*robot.equations, *spins])
        held = np.setdiff1d(np.arange(model.nv), [*robot.coordinates_v, *robot.dependent_v])
        self._held = np.eye(model.nv)[held]
        self.count = self._equations.rows + len(held)
        self._frequency, self._data, self._rest = frequency, model.createData(), np.zeros(model.nv)
        # Accelerations at zero joint acceleration, without free fall.
        self._model = model.copy()
        self._model.gravity = pin.Motion.Zero()

    def at(self, q: Array, v: Array) -> tuple[Array, Array]:
        """Return the rows R, (m, nv), and the required value of R times the accelerations, (m,)."""
        pin.computeJointJacobians(self._model, self._data, q)
        residuals, rows = self._equations.at(self._data, q)
        pin.rnea(self._model, self._data, q, v, self._rest)
        opening = self._equations.accelerations(self._data, q, v)
        omega = self._frequency
        wanted = -opening - 2.0 * omega * (rows @ v) - omega**2 * residuals
        return (
            np.concatenate([rows, self._held]),
            np.concatenate([wanted, -2.0 * omega * (self._held @ v)]),
        )
