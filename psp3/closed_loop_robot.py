r"""Any robot that Pinocchio holds as a tree with loop closures, driven in its actuated coordinates: the Pinocchio path.

The loops are Pinocchio constraint models. With :math:`\Phi` their Jacobian, split in the columns of the actuated and the
other joints, all joint velocities follow from the actuated ones (thesis eq. 3.16–3.17),

.. math:: \dot q = L\, \dot q^a, \qquad L = \begin{bmatrix} 1 \\ -(\Phi^u)^{-1} \Phi^a \end{bmatrix},

and the tree's dynamics, from Pinocchio's RNEA and CRBA, is projected with :math:`L`. Nothing here uses the closed form of
the 3-PSP or the thesis's natural orthogonal complement, so each of the three checks the others.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from psp3.arrays import Array, finite_rows, one_row, together
from psp3.errors import ClosureFailed, InvalidRobotFile, JointLimitExceeded, MobilityMismatch, SingularConfiguration, UnknownName
from psp3.loops import constraint_models, read_loops
from psp3.rank import dependent_solver
from psp3.robot_files import read_tree, reference_poses

CLOSURE_TOLERANCE = 1e-13
"""Residual at which a closure is accepted at once [m, rad]; Newton's method usually ends at 1e-16."""

LARGEST_PREDICTED_STEP = 0.3
"""Continuation toward a pose moves no joint by more than this between two closures [m, rad], so no assembly mode is skipped."""


class ClosedLoopRobot:
    """A robot given as a tree, loop closures and actuated joints; arguments and results are in actuated coordinates.

    One object serves one thread at a time, because it computes in one ``data``.

    Parameters
    ----------
    model : pinocchio.Model
        The tree.
    constraint_models : sequence of pinocchio.RigidConstraintModel
        The loop closures, in the frame ``LOCAL``. May be empty.
    actuated : sequence of str
        Names of the actuated joints, in the order of all actuated coordinates.
    q0 : (nq,) array_like, optional
        Reference configuration, from which other poses are reached; ``neutral`` by default. It need only nearly close the loops.
    visual_model : pinocchio.GeometryModel, optional
        What the robot looks like.

    Raises
    ------
    ClosureFailed
        If the loops cannot be closed near the reference configuration.
    MobilityMismatch
        If the number of actuated joints is not the number of degrees of freedom that the loops leave.
    """

    def __init__(
        self,
        model: pin.Model,
        constraint_models: Sequence[Any],
        actuated: Sequence[str],
        q0: ArrayLike | None = None,
        visual_model: Any = None,
    ) -> None:
        self.model = model
        self.data = model.createData()
        # Velocity forces are read off a copy without gravity: beside the weight they would lose half their digits.
        self._weightless = model.copy()
        self._weightless.gravity = pin.Motion.Zero()
        self.visual_model = visual_model if visual_model is not None else pin.GeometryModel()
        self.constraint_models = pin.StdVec_RigidConstraintModel()
        self.constraint_models.extend(list(constraint_models))
        self.actuated = tuple(actuated)
        for name in self.actuated:
            if not model.existJointName(name):
                raise UnknownName("actuated joint", name, tuple(model.names)[1:])
        joints = [model.joints[model.getJointId(name)] for name in self.actuated]
        self._actuated_q = np.array([joint.idx_q for joint in joints], dtype=int)
        self._actuated_v = np.array([joint.idx_v for joint in joints], dtype=int)
        self._dependent_v = np.setdiff1d(np.arange(model.nv), self._actuated_v)
        self._constraint_data = pin.StdVec_RigidConstraintData()
        self._dynamics_data = pin.StdVec_RigidConstraintData()
        for constraint in self.constraint_models:
            self._constraint_data.append(constraint.createData())
            # Constraint data must not be shared between algorithms of Pinocchio: results would be silently wrong.
            self._dynamics_data.append(constraint.createData())
        self.q0 = pin.neutral(model) if q0 is None else one_row("q0", q0, model.nq)
        self._check_mobility()
        self.q0 = self._close(self.q0, self.q0[self._actuated_q])

    @classmethod
    def from_urdf(cls, urdf: str | Path, loops: str | Path, srdf: str | Path | None = None) -> ClosedLoopRobot:
        """Load a robot from a URDF and a loop file.

        Parameters
        ----------
        urdf : path
            The tree, with the frames that the loops join.
        loops : path
            The loop file, in the keys of :mod:`psp3.loops`.
        srdf : path, optional
            Reference poses; the pose ``home`` becomes ``q0``.

        Raises
        ------
        InvalidRobotFile
            If a file is missing or malformed, or a frame or joint it names does not exist.
        """
        model, visual_model = read_tree(urdf)
        content = read_loops(loops)
        closures = constraint_models(model, content, loops)
        q0 = None
        if srdf is not None:
            poses = reference_poses(model, srdf)
            if "home" not in poses:
                raise InvalidRobotFile(srdf, f"has no pose 'home'; it has {', '.join(poses) or 'none'}")
            q0 = poses["home"]
        return cls(model, closures, content.actuated, q0, visual_model)

    def _check_mobility(self) -> None:
        jacobian, _ = self._constraint(self.q0)
        rank = int(np.linalg.matrix_rank(jacobian, tol=1e-7 * max(1.0, np.abs(jacobian).max(initial=0.0)))) if jacobian.size else 0
        if self.model.nv - rank != len(self.actuated):
            raise MobilityMismatch(self.model.nv - rank, self.actuated)

    # Closing the loops

    def _constraint(self, q: Array) -> tuple[Array, Array]:
        """Pinocchio's constraint Jacobian, which is minus the derivative of the residual at closure, and the residual."""
        pin.computeJointJacobians(self.model, self.data, q)
        residuals = [np.zeros(0)]
        for constraint, data in zip(self.constraint_models, self._constraint_data, strict=True):
            # Without this call the Jacobian below is silently wrong.
            constraint.calc(self.model, self.data, data)
            if constraint.type == pin.ContactType.CONTACT_6D:
                residuals.append(pin.log6(data.c1Mc2).vector)
            else:
                residuals.append(data.c1Mc2.translation)
        if not len(self.constraint_models):
            return np.zeros((0, self.model.nv)), residuals[0]
        jacobian = pin.getConstraintsJacobian(self.model, self.data, self.constraint_models, self._constraint_data)
        return jacobian, np.concatenate(residuals)

    def _newton(self, q: Array) -> tuple[Array, float]:
        """Close the loops with the un-actuated joints only; return the configuration and its residual."""
        best, last = q, np.inf
        for _ in range(20):
            jacobian, residual = self._constraint(q)
            size = float(np.abs(residual).max(initial=0.0))
            if not size < last:
                break
            best, last = q, size
            if size == 0.0:
                break
            step = np.zeros(self.model.nv)
            step[self._dependent_v] = dependent_solver(jacobian[:, self._dependent_v]) @ residual
            q = pin.integrate(self.model, q, step)
        return best, last

    def _close(self, guess: Array, positions: Array) -> Array:
        """Follow the assembly mode of ``guess`` to the given actuated positions."""
        # Absorb a guess that does not quite close the loops at its own actuated positions.
        q, residual = self._newton(guess)
        start = q[self._actuated_q]
        done, step = 0.0, 1.0
        failure = ClosureFailed(positions, residual, 0.0)
        if residual > CLOSURE_TOLERANCE:
            raise failure
        while done < 1.0:
            velocity = self._orthogonal_complement(q) @ (positions - start)
            fastest = float(np.abs(velocity).max(initial=0.0))
            step = min(step, 1.0 - done, LARGEST_PREDICTED_STEP / fastest if fastest > 0.0 else 1.0)
            goal = 1.0 if done + step > 1.0 - 1e-12 else done + step
            predicted = pin.integrate(self.model, q, (goal - done) * velocity)
            predicted[self._actuated_q] = start + goal * (positions - start)
            try:
                closed, residual = self._newton(predicted)
            except SingularConfiguration:
                residual = np.inf
            moved = pin.difference(self.model, predicted, closed) if residual < CLOSURE_TOLERANCE else np.full(1, np.inf)
            if np.abs(moved).max(initial=0.0) < LARGEST_PREDICTED_STEP:
                q, done, step = closed, goal, 2.0 * step
            else:
                step = 0.5 * step
                if step < 1e-6:
                    raise ClosureFailed(positions, residual, done)
        return q

    def _map(self, function: Callable[..., Array], shape: tuple[int, ...], **arguments: ArrayLike) -> Array:
        """Apply a function of rows (n,), with a result of the given shape, to arguments (..., n)."""
        width = len(self.actuated)
        arrays = together(**{name: finite_rows(name, values, width) for name, values in arguments.items()})
        rows = zip(*(array.reshape(-1, width) for array in arrays), strict=True)
        return np.array([function(*row) for row in rows]).reshape(arrays[0].shape[:-1] + shape)

    def configuration(self, positions: ArrayLike, guess: ArrayLike | None = None) -> Array:
        """Return the configurations that close the loops at the given actuated positions.

        Newton's method with continuation from the reference pose, so the assembly mode is that of the reference.

        Parameters
        ----------
        positions : (..., n) array_like
            Positions of the actuated joints [m or rad].
        guess : (nq,) array_like, optional
            A configuration of the wanted assembly mode to start from; ``q0`` by default.

        Returns
        -------
        (..., nq) ndarray
            Pinocchio configurations.

        Raises
        ------
        InvalidArray
            If the positions are not finite or of another shape.
        ClosureFailed
            If the pose cannot be reached without opening a loop.
        JointLimitExceeded
            If an un-actuated joint would be beyond its limits.
        """
        start = self.q0 if guess is None else one_row("guess", guess, self.model.nq)
        return self._map(lambda row: self._within_limits(self._close(start, row)), (self.model.nq,), positions=positions)

    def _within_limits(self, q: Array) -> Array:
        """Return q, provided that no un-actuated joint is beyond its limits; those of the motors are not its business."""
        # Without the universe: Pinocchio's placeholder claims one coordinate, the last of q.
        for name, joint in zip(list(self.model.names)[1:], list(self.model.joints)[1:], strict=True):
            if joint.nq != 1 or name in self.actuated:
                continue
            position, lower, upper = (
                float(vector[joint.idx_q]) for vector in (q, self.model.lowerPositionLimit, self.model.upperPositionLimit)
            )
            if not lower <= position <= upper:
                raise JointLimitExceeded(str(name), position, lower, upper)
        return q

    def velocity(self, positions: ArrayLike, speeds: ArrayLike) -> Array:
        r"""Return the velocities of all joints, :math:`\dot q = L \dot q^a` (eq. 3.16).

        Parameters
        ----------
        positions, speeds : (..., n) array_like
            Actuated positions and speeds.

        Returns
        -------
        (..., nv) ndarray
            Joint velocities in the order of the model.

        Raises
        ------
        InvalidArray, ClosureFailed, SingularConfiguration
            See :meth:`configuration`.
        """
        return self._map(lambda position, speed: self._closed(position)[1] @ speed, (self.model.nv,), positions=positions, speeds=speeds)

    # Projected dynamics

    def _orthogonal_complement(self, q: Array) -> Array:
        """L of eq. 3.17 at a closed configuration."""
        jacobian, _ = self._constraint(q)
        return self._complement_of(jacobian)[0]

    def _complement_of(self, jacobian: Array) -> tuple[Array, Array]:
        solver = dependent_solver(jacobian[:, self._dependent_v])
        complement = np.zeros((self.model.nv, len(self.actuated)))
        complement[self._actuated_v] = np.eye(len(self.actuated))
        complement[self._dependent_v] = -solver @ jacobian[:, self._actuated_v]
        return complement, solver

    def _closed(self, positions: Array) -> tuple[Array, Array, Array]:
        """Return configuration, L and the solver for the un-actuated joints at the given positions."""
        q = self.configuration(positions)
        jacobian, _ = self._constraint(q)
        return (q, *self._complement_of(jacobian))

    def _drift(self, q: Array, v: Array, solver: Array) -> Array:
        """Joint accelerations that keep the loops closed while the actuated joints move uniformly: dL/dt times speeds."""
        pin.forwardKinematics(self.model, self.data, q, v, np.zeros(self.model.nv))
        drift = [np.zeros(0)]
        for constraint in self.constraint_models:
            first = pin.getFrameAcceleration(
                self.model, self.data, constraint.joint1_id, constraint.joint1_placement, pin.ReferenceFrame.LOCAL
            )
            second = pin.getFrameAcceleration(
                self.model, self.data, constraint.joint2_id, constraint.joint2_placement, pin.ReferenceFrame.LOCAL
            )
            relative = (self.data.oMi[constraint.joint1_id] * constraint.joint1_placement).actInv(
                self.data.oMi[constraint.joint2_id] * constraint.joint2_placement
            )
            if constraint.type == pin.ContactType.CONTACT_6D:
                drift.append((first - relative.act(second)).vector)
            else:
                # Points, not frames, coincide: their classical accelerations agree.
                points = [
                    pin.getFrameClassicalAcceleration(self.model, self.data, joint, placement, pin.ReferenceFrame.LOCAL).linear
                    for joint, placement in (
                        (constraint.joint1_id, constraint.joint1_placement),
                        (constraint.joint2_id, constraint.joint2_placement),
                    )
                ]
                drift.append(points[0] - relative.rotation @ points[1])
        acceleration = np.zeros(self.model.nv)
        acceleration[self._dependent_v] = -solver @ np.concatenate(drift)
        return acceleration

    def _velocity_forces(self, q: Array, complement: Array, solver: Array, speeds: Array) -> Array:
        """C(q, speeds) speeds: projected RNEA of the uniform motion of the actuated joints, without gravity."""
        v = complement @ speeds
        forces: Array = complement.T @ pin.rnea(self._weightless, self.data, q, v, self._drift(q, v, solver))
        return forces

    def equation_of_motion(self, positions: ArrayLike, speeds: ArrayLike) -> tuple[Array, Array, Array]:
        r"""Return mass matrix, Coriolis matrix and gravity in actuated coordinates.

        .. math:: M = L^T M_\text{tree} L, \qquad G = L^T g_\text{tree},

        and C as the unique matrix of Christoffel symbols: the quadratic form :math:`h(v) = C(v)\,v`, projected from RNEA, gives
        its columns by polarization, :math:`C(v) e_j = \tfrac12 [h(v + e_j) - h(v) - h(e_j)]`.

        Parameters
        ----------
        positions, speeds : (..., n) array_like
            Actuated positions and speeds [m, m/s or rad, rad/s].

        Returns
        -------
        M : (..., n, n) ndarray
        C : (..., n, n) ndarray
        G : (..., n) ndarray

        Raises
        ------
        InvalidArray, ClosureFailed, SingularConfiguration
            See :meth:`configuration`.
        """
        n = len(self.actuated)

        def one(position: Array, speed: Array) -> Array:
            q, complement, solver = self._closed(position)
            tree = pin.crba(self.model, self.data, q)
            tree = np.triu(tree) + np.triu(tree, 1).T
            mass = complement.T @ tree @ complement
            gravity = complement.T @ pin.computeGeneralizedGravity(self.model, self.data, q)
            coriolis = np.zeros((n, n))
            # The unit vectors are scaled to the speed: subtracting forms of very different size would lose digits.
            scale = float(np.abs(speed).max(initial=0.0))
            if scale > 0.0:
                base = self._velocity_forces(q, complement, solver, speed)
                for j, unit in enumerate(scale * np.eye(n)):
                    both = self._velocity_forces(q, complement, solver, speed + unit)
                    alone = self._velocity_forces(q, complement, solver, unit)
                    coriolis[:, j] = (both - base - alone) / (2.0 * scale)
            return np.concatenate([mass.ravel(), coriolis.ravel(), gravity])

        packed = self._map(one, (2 * n * n + n,), positions=positions, speeds=speeds)
        square = (*packed.shape[:-1], n, n)
        return packed[..., : n * n].reshape(square), packed[..., n * n : 2 * n * n].reshape(square), packed[..., 2 * n * n :]

    def mass_matrix(self, positions: ArrayLike) -> Array:
        """Return the mass matrix M, of shape (..., n, n); see :meth:`equation_of_motion`."""
        return self.equation_of_motion(positions, np.zeros(len(self.actuated)))[0]

    def coriolis_matrix(self, positions: ArrayLike, speeds: ArrayLike) -> Array:
        """Return the Coriolis matrix C, of shape (..., n, n); see :meth:`equation_of_motion`."""
        return self.equation_of_motion(positions, speeds)[1]

    def gravity(self, positions: ArrayLike) -> Array:
        """Return the gravity vector G, of shape (..., n); see :meth:`equation_of_motion`."""
        return self.equation_of_motion(positions, np.zeros(len(self.actuated)))[2]

    def inverse_dynamics(self, positions: ArrayLike, speeds: ArrayLike, accelerations: ArrayLike) -> Array:
        r"""Return the actuator forces of a motion, :math:`\tau = L^T \operatorname{RNEA}(q, \dot q, \ddot q)`.

        Parameters
        ----------
        positions, speeds, accelerations : (..., n) array_like
            Motion of the actuated joints.

        Returns
        -------
        (..., n) ndarray
            Forces [N] or torques [N m] of the actuated joints.

        Raises
        ------
        InvalidArray, ClosureFailed, SingularConfiguration
            See :meth:`configuration`.
        """

        def one(position: Array, speed: Array, acceleration: Array) -> Array:
            q, complement, solver = self._closed(position)
            v = complement @ speed
            forces: Array = complement.T @ pin.rnea(self.model, self.data, q, v, complement @ acceleration + self._drift(q, v, solver))
            return forces

        return self._map(one, (len(self.actuated),), positions=positions, speeds=speeds, accelerations=accelerations)

    def constrained_accelerations(self, q: Array, v: Array, forces: Array) -> Array:
        """Return all joint accelerations of the tree under actuator forces, from Pinocchio's ``constraintDynamics``.

        Parameters
        ----------
        q : (nq,) ndarray
            Configuration. Where it leaves the loops a little open, the constraint models' Baumgarte gains close them again.
        v : (nv,) ndarray
            Joint velocities.
        forces : (n,) ndarray
            Actuator forces.

        Returns
        -------
        (nv,) ndarray
            Joint accelerations.
        """
        tau = np.zeros(self.model.nv)
        tau[self._actuated_v] = forces
        # Redundant closures make the constraint inertia singular; the proximal iteration then converges to the same motion.
        rows = sum(constraint.residualSize() for constraint in self.constraint_models)
        redundant = rows > self.model.nv - len(self.actuated)
        settings = pin.ProximalSettings(1e-12, 1e-12, 1e-6 if redundant else 0.0, 50 if redundant else 1)
        pin.initConstraintDynamics(self.model, self.data, self.constraint_models, self._dynamics_data)
        acceleration = pin.constraintDynamics(self.model, self.data, q, v, tau, self.constraint_models, self._dynamics_data, settings)
        return np.array(acceleration)

    def forward_dynamics(self, positions: ArrayLike, speeds: ArrayLike, forces: ArrayLike) -> Array:
        """Return the accelerations of the actuated joints under actuator forces, from Pinocchio's ``constraintDynamics``.

        Parameters
        ----------
        positions, speeds, forces : (..., n) array_like
            State and actuator forces.

        Returns
        -------
        (..., n) ndarray
            Accelerations of the actuated joints.

        Raises
        ------
        InvalidArray, ClosureFailed, SingularConfiguration
            See :meth:`configuration`.
        """

        def one(position: Array, speed: Array, force: Array) -> Array:
            q, complement, _ = self._closed(position)
            accelerations: Array = self.constrained_accelerations(q, complement @ speed, force)[self._actuated_v]
            return accelerations

        return self._map(one, (len(self.actuated),), positions=positions, speeds=speeds, forces=forces)

    def frame_jacobian(self, positions: ArrayLike, frame: str) -> Array:
        """Return the Jacobian of a frame with respect to the actuated coordinates, in base axes at the frame's origin.

        Parameters
        ----------
        positions : (..., n) array_like
            Actuated positions.
        frame : str
            Name of a frame of the model.

        Returns
        -------
        (..., 6, n) ndarray
            Linear velocity (first three rows) and angular velocity per unit of actuated speed.

        Raises
        ------
        UnknownName
            If the model has no such frame.
        """
        if not self.model.existFrame(frame):
            raise UnknownName("frame", frame, [known.name for known in self.model.frames])
        index = self.model.getFrameId(frame)

        def one(position: Array) -> Array:
            q, complement, _ = self._closed(position)
            pin.computeJointJacobians(self.model, self.data, q)
            pin.updateFramePlacements(self.model, self.data)
            jacobian = pin.getFrameJacobian(self.model, self.data, index, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
            return np.asarray(jacobian @ complement)

        return self._map(one, (6, len(self.actuated)), positions=positions)

    def kinetic_energy(self, positions: ArrayLike, speeds: ArrayLike) -> Array:
        """Return the kinetic energy [J], of shape (...,)."""

        def one(position: Array, speed: Array) -> Array:
            q, complement, _ = self._closed(position)
            return np.asarray(pin.computeKineticEnergy(self.model, self.data, q, complement @ speed))

        return self._map(one, (), positions=positions, speeds=speeds)

    def potential_energy(self, positions: ArrayLike) -> Array:
        """Return the potential energy in the field of gravity [J], of shape (...,); zero with all masses at the base's height."""

        def one(position: Array) -> Array:
            return np.asarray(pin.computePotentialEnergy(self.model, self.data, self.configuration(position)))

        return self._map(one, (), positions=positions)
