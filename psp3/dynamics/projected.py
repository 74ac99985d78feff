r"""Dynamics of the tree by Pinocchio's RNEA and CRBA, projected onto motions with closed loops.

With :math:`L` from Pinocchio's constraint Jacobian, :math:`\dot q = L \dot q^a`, and the drift
:math:`\dot L \dot q^a` from the accelerations of the joined frames,

.. math:: M = L^T M_\text{tree} L, \qquad G = L^T g_\text{tree}, \qquad
          \tau = L^T \operatorname{RNEA}(q, L \dot q^a, L \ddot q^a + \dot L \dot q^a).

The tests compare all other computations of a robot with this one and with the natural orthogonal
complement, because it uses none of this package's compiled code.
:mod:`psp3.dynamics.newton_from_home` closes the loops, with residuals and Jacobian from Pinocchio.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from fuzzy2.support.described import Described
from psp3.checks import Array, applied_to_rows, one_row
from psp3.closure.coordinates import floating_base
from psp3.closure.passive_limits import PassiveLimits
from psp3.dynamics.closed_pose import ClosedPose
from psp3.dynamics.derivatives import ForwardDynamicsDerivatives, InverseDynamicsDerivatives
from psp3.dynamics.joined_frames import JoinedFrames
from psp3.dynamics.mechanism import HasTree, Mechanism, check_order
from psp3.dynamics.more_equations import JointElements, MoreEquations
from psp3.dynamics.motors import forces_of_motors
from psp3.dynamics.newton_from_home import Closed, NewtonFromHome
from psp3.dynamics.projected_derivatives import projected_derivatives
from psp3.errors import InvalidValue, NoFiniteAnswer


class ProjectedDynamics(Described):
    r"""Projected RNEA and CRBA of a tree with loops, in actuated coordinates.

    Only one thread at a time may use an object, because it has a single ``data``.

    Parameters
    ----------
    robot : HasTree
        A robot, or any object with a Pinocchio ``model``. Loops, motors and home are read as in
        :class:`psp3.NaturalOrthogonalComplement`. Motors are joints of one coordinate.

    Attributes
    ----------
    model, data : pinocchio.Model, pinocchio.Data
        The tree, and its data.
    constraint_models : pinocchio.StdVec_RigidConstraintModel
        The loop closures.
    actuated : tuple of str
        Names of the actuated joints, in the order of all actuated coordinates.
    actuated_v, dependent_v : ndarray of int
        Places of the actuated joints in joint velocities, and of the others.
    """

    def __init__(self, robot: HasTree) -> None:
        self._robot, self._mechanism = robot, Mechanism(robot)
        self.model = self._mechanism.model
        self.data = self.model.createData()
        # Velocity forces come from a copy without gravity, because next to the weight they would
        # lose half of their digits.
        self._weightless = self.model.copy()
        self._weightless.gravity = pin.Motion.Zero()
        self.constraint_models = pin.StdVec_RigidConstraintModel()
        self.constraint_models.extend(self._mechanism.loops)
        self._constraint_data = pin.StdVec_RigidConstraintData()
        for loop in self.constraint_models:
            self._constraint_data.append(loop.createData())
        # Items of a Pinocchio vector are slow to create, so they are created once.
        self._states = [self._constraint_data[i] for i in range(len(self._constraint_data))]
        self.actuated = self._mechanism.names
        self.actuated_v = self._mechanism.actuated
        self.dependent_v = self._mechanism.dependent
        self._limited = PassiveLimits(self.model, self.actuated)
        self._frames = JoinedFrames(self._mechanism)
        self._more = MoreEquations(self.model, self._mechanism.equations)
        self._elements = JointElements(self.model, self._mechanism.springs)
        joints = [self.model.joints[self.model.getJointId(name)] for name in self.actuated]
        self._widths = sum(joint.nq for joint in joints), self.actuated_v.size
        # If subtrees are not contiguous, CRBA is silently wrong, but RNEA is right.
        self._crba_holds = bool(self.model.check(self.data))
        self._upper = np.triu(np.ones((self.model.nv, self.model.nv)))
        self._rest = np.zeros(self.model.nv)

    def _facts(self) -> dict[str, Any]:
        return {"robot": self._robot, "motors": self.actuated}

    def __reduce__(self) -> tuple[type[ProjectedDynamics], tuple[HasTree]]:
        # Pinocchio pickles neither constraints nor what it computes of them.
        return type(self), (self._robot,)

    # Closing the loops

    def _constraint(self, q: Array) -> tuple[Array, Array]:
        """Return Pinocchio's constraint Jacobian, and the function of which it is the derivative.

        If the loops are closed, they are minus the residual and minus its derivative. If they are
        open, the Jacobian is only nearly the derivative, which is enough for Newton's method.
        """
        pin.computeJointJacobians(self.model, self.data, q)
        others, rows = self._more.at(self.data, q)
        if not self._mechanism.loops:
            return others, rows
        for loop, state in zip(self._mechanism.loops, self._states, strict=True):
            # Without this call the Jacobian below is silently wrong.
            loop.calc(self.model, self.data, state)
        jacobian = pin.getConstraintsJacobian(
            self.model, self.data, self.constraint_models, self._constraint_data
        )
        # For a model with a single degree of freedom Pinocchio returns a vector.
        jacobian = jacobian.reshape(-1, self.model.nv)
        if not self._more.rows:
            return self._frames.opening(self._states), jacobian
        residual = np.concatenate([self._frames.opening(self._states), others])
        return residual, np.concatenate([jacobian, rows])

    def _openings(self, q: Array, v: Array) -> Array:
        """Return the opening accelerations of all closures, (m,), for the last RNEA call."""
        opening = self._frames.accelerations(self.data, self._states)
        if not self._more.rows:
            return opening
        return np.concatenate([opening, self._more.accelerations(self.data, q, v)])

    @functools.cached_property
    def _from_home(self) -> NewtonFromHome:
        closures = [*self._mechanism.loops, *self._mechanism.equations]
        return NewtonFromHome(
            self.model,
            self.actuated,
            self._mechanism.home(),
            self._constraint,
            self._mechanism.complement,
            self._mechanism.dependent,
            self._mechanism.mismatch,
            may_float=floating_base(self.model, closures) is not None,
        )

    def _closed(self, positions: Array) -> Closed:
        found = self._from_home.closed(positions)
        self._limited.check(found.q[np.newaxis])
        return found

    def _map(
        self, function: Callable[..., Array], shape: tuple[int, ...], **arguments: ArrayLike
    ) -> Array:
        # First of all, so that a home that is none is found without a pose, too.
        _ = self._from_home
        p, n = self._widths

        def finite(position: Array, *others: Array) -> Array:
            with np.errstate(over="ignore", invalid="ignore"):
                found = function(position, *others)
            if not np.isfinite(found).all():
                raise NoFiniteAnswer(position)
            return found

        return applied_to_rows(
            finite,
            shape,
            **{
                name: (values, p if name == "positions" else n)
                for name, values in arguments.items()
            },
        )

    def configuration(self, positions: ArrayLike) -> Array:
        """Return the configurations that close the loops, by Newton's method from home.

        Parameters
        ----------
        positions : (..., n) array_like
            Positions of the actuated joints [m or rad].

        Returns
        -------
        (..., nq) ndarray
            Configurations, closed to rounding, in the assembly mode of home.

        Raises
        ------
        InvalidArray
            If the positions are not finite or of another shape.
        InvalidValue
            If an actuated joint has more than one coordinate.
        ClosureFailed
            If a pose cannot be reached from home without opening a loop.
        JointLimitExceeded
            If an un-actuated joint would be beyond its limits.
        SingularConfiguration, MobilityMismatch
            If the actuated joints do not determine the others at home, or determine each other.
        """
        return self._map(lambda row: self._closed(row).q, (self.model.nq,), positions=positions)

    def complement(self, positions: ArrayLike) -> Array:
        """Return L, all joint velocities per unit of actuated speed (eq. 3.17), (..., nv, n).

        Argument and errors as in :meth:`configuration`.
        """
        shape = self.model.nv, self.actuated_v.size
        return self._map(lambda row: self._closed(row).complement, shape, positions=positions)

    def closure(self, positions: ArrayLike) -> ClosedPose:
        """Return the closed configuration of one pose, (n,), together with L.

        Errors as in :meth:`configuration`.
        """
        found = self._closed(one_row("positions", positions, self._widths[0]))
        return ClosedPose(found.q, found.complement, lambda q: found.inverse)

    def drift(self, q: Array, v: Array) -> Array:
        r"""Return the joint accelerations :math:`\dot L \dot q^a` at constant motor speeds.

        The arguments are a closed configuration and joint velocities, (nv,), as in
        :meth:`psp3.ClosedLoopRobot.drift`.
        """
        q, v = one_row("q", q, self.model.nq), one_row("v", v, self.model.nv)
        _, jacobian = self._constraint(q)
        _, inverse = self._mechanism.complement(q, jacobian)
        found = self._drift(q, v, inverse)
        if not np.isfinite(found).all():
            raise NoFiniteAnswer(q)
        return found

    def _drift(self, q: Array, v: Array, inverse: Array) -> Array:
        accelerations = np.zeros(self.model.nv)
        pin.rnea(self._weightless, self.data, q, v, self._rest)
        opening = self._openings(q, v)
        accelerations[self.dependent_v] = -inverse @ opening
        return accelerations

    def _uniform(self, q: Array, velocities: Array) -> tuple[Array, Array]:
        """Return forces and opening accelerations for constant joint velocities (nv, k).

        These are the forces without gravity, (nv, k), and the accelerations with which the loops
        open, (m, k).
        """
        count = velocities.shape[1]
        rows = self._frames.rows + self._more.rows
        forces, openings = np.empty_like(velocities), np.empty((rows, count))
        for k, v in enumerate(velocities.T):
            forces[:, k] = pin.rnea(self._weightless, self.data, q, v, self._rest)
            openings[:, k] = self._openings(q, v)
        return forces, openings

    # Dynamics

    def _tree_mass(self, q: Array, complement: Array) -> Array:
        """Return the product of the tree's mass matrix and L, (nv, n)."""
        if self._crba_holds:
            upper = pin.crba(self.model, self.data, q) * self._upper
            product = upper @ complement + upper.T @ complement
            product -= upper.diagonal()[:, np.newaxis] * complement
            return np.asarray(product)
        columns = [
            pin.rnea(self._weightless, self.data, q, self._rest, column) for column in complement.T
        ]
        return np.stack(columns, axis=1)

    def equation_of_motion(
        self, positions: ArrayLike, speeds: ArrayLike
    ) -> tuple[Array, Array, Array]:
        r"""Return mass matrix, Coriolis matrix and gravity in actuated coordinates.

        The results are those of :meth:`psp3.ClosedLoopRobot.equation_of_motion`, computed in
        another way: M and G are projected, and the quadratic form :math:`h(v) = C(v)\,v`, projected
        from RNEA, gives the columns of C by polarization, :math:`C(v) e_j = \tfrac12 [h(v + e_j) -
        h(v) - h(e_j)]`. Errors as in :meth:`configuration`.
        """
        n = self.actuated_v.size

        def one(position: Array, speed: Array) -> Array:
            q, _, complement, inverse = self._closed(position)
            tree = self._tree_mass(q, complement)
            coriolis = np.zeros((n, n))
            # The unit vectors are scaled to the speed, because subtracting forms of very different
            # size would lose digits.
            scale = float(np.abs(speed).max(initial=0.0))
            if scale > 0.0:
                units = scale * np.eye(n)
                motions = np.concatenate([speed[np.newaxis], speed + units, units]).T
                forces, openings = self._uniform(q, complement @ motions)
                form = complement.T @ forces - tree[self.dependent_v].T @ (inverse @ openings)
                coriolis = (form[:, 1 : n + 1] - form[:, :1] - form[:, n + 1 :]) / (2.0 * scale)
            gravity = pin.computeGeneralizedGravity(self.model, self.data, q)
            if self._elements.are_there:
                damping = self._elements.of_speeds(complement @ speed)
                coriolis = coriolis + complement.T @ (damping[:, np.newaxis] * complement)
                gravity = gravity + self._elements.of_positions(q)
            return np.concatenate(
                [(complement.T @ tree).ravel(), coriolis.ravel(), complement.T @ gravity]
            )

        packed = self._map(one, (2 * n * n + n,), positions=positions, speeds=speeds)
        square = (*packed.shape[:-1], n, n)
        return (
            packed[..., : n * n].reshape(square),
            packed[..., n * n : 2 * n * n].reshape(square),
            packed[..., 2 * n * n :],
        )

    def mass_matrix(self, positions: ArrayLike) -> Array:
        """Return the mass matrix M, of shape (..., n, n); see :meth:`equation_of_motion`."""
        return self.equation_of_motion(positions, np.zeros(self.actuated_v.size))[0]

    def coriolis_matrix(self, positions: ArrayLike, speeds: ArrayLike) -> Array:
        """Return the Coriolis matrix C, of shape (..., n, n); see :meth:`equation_of_motion`."""
        return self.equation_of_motion(positions, speeds)[1]

    def gravity(self, positions: ArrayLike) -> Array:
        """Return the gravity vector G, of shape (..., n); see :meth:`equation_of_motion`."""
        return self.equation_of_motion(positions, np.zeros(self.actuated_v.size))[2]

    def inverse_dynamics(
        self, positions: ArrayLike, speeds: ArrayLike, accelerations: ArrayLike
    ) -> Array:
        r"""Return the actuator forces of a motion, :math:`\tau = L^T \operatorname{RNEA}`.

        As :meth:`psp3.ClosedLoopRobot.inverse_dynamics`; errors as in :meth:`configuration`.
        """

        def one(position: Array, speed: Array, acceleration: Array) -> Array:
            return self._forces(self._closed(position), speed, acceleration)

        return self._map(
            one,
            (self.actuated_v.size,),
            positions=positions,
            speeds=speeds,
            accelerations=accelerations,
        )

    def _forces(self, found: Closed, speed: Array, acceleration: Array) -> Array:
        """Return the actuator forces of a motion at one closed configuration."""
        q, L = found.q, found.complement
        v = L @ speed
        joints = L @ acceleration + self._drift(q, v, found.inverse)
        forces = pin.rnea(self.model, self.data, q, v, joints)
        if self._elements.are_there:
            forces = forces + self._elements.resistance(q, v)
        return np.asarray(L.T @ forces)

    def actuator_forces(
        self, positions: ArrayLike, speeds: ArrayLike, accelerations: ArrayLike
    ) -> Array:
        """Return the motor forces for a motion, those with the least norm if there are many motors.

        As in :meth:`psp3.ClosedLoopRobot.actuator_forces`, there may be fewer accelerations.
        """
        if self._mechanism.drives_coordinates:
            return self.inverse_dynamics(positions, speeds, accelerations)
        return forces_of_motors(
            np.swapaxes(self.complement(positions), -1, -2) @ self._mechanism.motors,
            lambda rates: self.inverse_dynamics(positions, speeds, rates),
            lambda: self.mass_matrix(positions),
            accelerations,
            self.actuated,
        )

    def forward_dynamics(self, positions: ArrayLike, speeds: ArrayLike, forces: ArrayLike) -> Array:
        r"""Return the accelerations of the actuated joints under actuator forces.

        They solve :math:`L^T M_\text{tree} L\, \ddot q^a = \tau - L^T \operatorname{RNEA}` of the
        uniform motion. As :meth:`psp3.ClosedLoopRobot.forward_dynamics`; errors as in
        :meth:`configuration`.
        """

        def one(position: Array, speed: Array, force: Array) -> Array:
            found = self._closed(position)
            left = force - self._forces(found, speed, np.zeros_like(speed))
            mass = found.complement.T @ self._tree_mass(found.q, found.complement)
            return np.asarray(np.linalg.solve(mass, left))

        return self._map(
            one, (self.actuated_v.size,), positions=positions, speeds=speeds, forces=forces
        )

    # The whole tree

    def inverse_dynamics_derivatives(
        self, positions: ArrayLike, speeds: ArrayLike, accelerations: ArrayLike
    ) -> InverseDynamicsDerivatives:
        """Return the derivatives of the forces of a motion.

        As :func:`psp3.dynamics.derivatives.inverse_dynamics_derivatives`, from Pinocchio's of the
        tree.

        Raises
        ------
        InvalidValue
            If the robot is more than a tree with exact closures at points or frames.
        """
        n = self.actuated_v.size
        if self._more.rows or self._elements.are_there or self._mechanism.mismatch > 1e-9:
            raise InvalidValue(
                "robot",
                f"{self.model.name} with couplings, hinges, held spins, springs, damping "
                "or rounded loops",
                "a tree with exact closures at points or frames and nothing else for derivatives "
                "by robot.dynamics('pinocchio') (robot.inverse_dynamics_derivatives covers every "
                "robot)",
            )
        found = self._map(
            lambda a, v, w: projected_derivatives(self, self.closure(a), v, w),
            (3, n, n),
            positions=positions,
            speeds=speeds,
            accelerations=accelerations,
        )
        return InverseDynamicsDerivatives(*np.moveaxis(found, -3, 0))

    def forward_dynamics_derivatives(
        self, positions: ArrayLike, speeds: ArrayLike, forces: ArrayLike
    ) -> ForwardDynamicsDerivatives:
        """Return the derivatives of the accelerations under forces.

        As :func:`psp3.dynamics.derivatives.forward_dynamics_derivatives`; errors as in
        :meth:`inverse_dynamics_derivatives`.
        """
        accelerations = self.forward_dynamics(positions, speeds, forces)
        by_positions, by_speeds, mass = self.inverse_dynamics_derivatives(
            positions, speeds, accelerations
        )
        inverse = np.asarray(np.linalg.inv(mass), dtype=np.float64)
        return ForwardDynamicsDerivatives(-inverse @ by_positions, -inverse @ by_speeds, inverse)

    @functools.cached_property
    def _solver(self) -> ConstraintSolver:
        mechanism = self._mechanism
        is_redundant = mechanism.rows > mechanism.dependent.size
        return ConstraintSolver(mechanism.model, self.constraint_models, is_redundant)

    def constrained_accelerations(self, q: Array, v: Array, forces: Array) -> Array:
        """Return all joint accelerations of the tree under actuator forces.

        They come from Pinocchio's ``constraintDynamics``, which is exact if the loops close
        exactly. For a redundant loop with rounded numbers it is not exact, but
        :meth:`forward_dynamics` is.

        Parameters
        ----------
        q : (nq,) ndarray
            Configuration. If it leaves the loops slightly open, the constraint models' Baumgarte
            gains close them again.
        v : (nv,) ndarray
            Joint velocities.
        forces : (n,) ndarray
            Actuator forces.

        Returns
        -------
        (nv,) ndarray
            Joint accelerations.

        Raises
        ------
        DisorderedJoints
            If the tree's joints are not chain by chain, for which the answer would be wrong.
        """
        joint_forces = np.zeros(self.model.nv)
        q, v = one_row("q", q, self.model.nq), one_row("v", v, self.model.nv)
        joint_forces[self._mechanism.actuated] = one_row(
            "forces", forces, len(self._mechanism.actuated)
        )
        found = self._solver.accelerations(q, v, joint_forces)
        if not np.isfinite(found).all():
            raise NoFiniteAnswer(q)
        return found


class ConstraintSolver:
    """Pinocchio's ``constraintDynamics``, prepared once, with data for this use only.

    If several Pinocchio algorithms shared the constraint data, results would be silently wrong.

    Parameters
    ----------
    model : pinocchio.Model
        The tree.
    constraint_models : pinocchio.StdVec_RigidConstraintModel
        Its closures.
    is_redundant : bool
        Whether some closure equations follow from others.

    Raises
    ------
    DisorderedJoints
        If the tree's joints are not chain by chain, for which the answer would be wrong.
    """

    def __init__(
        self,
        model: pin.Model,
        constraint_models: pin.StdVec_RigidConstraintModel,
        is_redundant: bool,
    ) -> None:
        check_order(model)
        self._model, self._data = model, model.createData()
        self._constraint_models = constraint_models
        self._constraint_data = pin.StdVec_RigidConstraintData()
        for loop in constraint_models:
            self._constraint_data.append(loop.createData())
        # Redundant closures make the constraint inertia singular; the proximal iteration then
        # converges to the same motion.
        self._settings = pin.ProximalSettings(
            1e-12, 1e-12, 1e-6 if is_redundant else 0.0, 50 if is_redundant else 1
        )
        pin.initConstraintDynamics(
            self._model, self._data, self._constraint_models, self._constraint_data
        )

    def accelerations(self, q: Array, v: Array, joint_forces: Array) -> Array:
        """Return all joint accelerations, (nv,), under forces on all joints, (nv,)."""
        return np.array(
            pin.constraintDynamics(
                self._model,
                self._data,
                q,
                v,
                joint_forces,
                self._constraint_models,
                self._constraint_data,
                self._settings,
            )
        )
