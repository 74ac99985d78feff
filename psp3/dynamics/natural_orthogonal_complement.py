r"""The thesis's dynamics, equation by equation.

The natural orthogonal complement (eq. 3.2–3.4 and 3.6–3.36).

The complement :math:`T` maps the actuated speeds to the twists of all bodies,
:math:`t = T \dot q^a`. Twists that the loops allow do no work against the constraint forces, so
projecting the Newton–Euler equations of the free bodies with :math:`T` removes those forces and
leaves

.. math:: M = T^T M_\text{total} T, \qquad
          C = T^T M_\text{total} \dot T + T^T \Omega M_\text{total} T, \qquad G = -T^T w^g.

Where the printed equations are wrong (see each function), what is right is implemented. Joint
quantities (placements, joint Jacobians and their rates, inertias) come from Pinocchio; everything
else is here and in :mod:`psp3.dynamics.newton_from_home`, which closes the loops, so any tree with
loops and named actuated joints can be treated, one without loops included. Of the robot only its
tree, its loops, the names of its motors and its reference configuration are used: no
``robot.configuration`` is ever called.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from psp3.checks import Array, applied_to_rows, finite_rows, one_row, together
from psp3.closure.mobility import mobility
from psp3.closure.rank import dependent_solver
from psp3.dynamics.newton_from_home import NewtonFromHome
from psp3.errors import InconsistentVelocity, MobilityMismatch, OpenLoops, UnknownName
from psp3.robots.passive_limits import PassiveLimits

CLOSURE_TOLERANCE = 1e-6
"""Dynamics is refused where a loop is open by more than this [m, rad]."""

MOBILITY_TOLERANCE = 1e-5
"""L must satisfy the loops' velocity equations to this share; far above rounding, far below a wrong
number of actuators.
"""

VELOCITY_TOLERANCE = 1e-8
"""A velocity is refused where it violates the loops by more than this share of its size."""


def _skew(vectors: Array) -> Array:
    """Cross-product matrices, (..., 3) to (..., 3, 3)."""
    matrices = np.zeros((*vectors.shape, 3))
    x, y, z = np.moveaxis(vectors, -1, 0)
    matrices[..., 0, 1], matrices[..., 0, 2], matrices[..., 1, 2] = -z, y, -x
    matrices[..., 1, 0], matrices[..., 2, 0], matrices[..., 2, 1] = z, -y, x
    return matrices


def _motion_cross(twist: Array) -> Array:
    """Matrix of the cross product of motions, for twists ordered [v; ω] as in Pinocchio."""
    matrix = np.zeros((6, 6))
    matrix[:3, :3] = matrix[3:, 3:] = _skew(twist[3:])
    matrix[:3, 3:] = _skew(twist[:3])
    return matrix


class NaturalOrthogonalComplement:
    """Natural orthogonal complement of a tree with loops.

    All methods take full Pinocchio vectors ``q`` (..., nq) and ``v`` (..., nv) with
    ``v = L(q) @ speeds``; any other velocity is refused. Rows of L and columns of K follow
    ``robot.model``. A twist is [ω; v] in world axes at the body's center of mass, and the bodies
    are the links of the tree, one per joint, in the order of ``body_names``.

    Parameters
    ----------
    robot : object
        Anything with a Pinocchio ``model``; ``constraint_models`` (none: no loops) and ``actuated``
        (none: every joint), as :class:`psp3.ClosedLoopRobot` and the robots of example-robot-data
        have them; and ``q0``, the configuration from which the loops are closed (none: ``neutral``
        of the model).
    """

    def __init__(self, robot: Any) -> None:
        self.robot = robot
        self.model = robot.model
        self._data = self.model.createData()
        # The robots of example-robot-data say None where they have no loops.
        self._loops = list(getattr(robot, "constraint_models", None) or ())
        known = tuple(self.model.names)[1:]
        self._names = tuple(getattr(robot, "actuated", None) or known)
        for name in self._names:
            if name not in known:
                raise UnknownName("actuated joint", name, known)
        joints = [self.model.joints[self.model.getJointId(name)] for name in self._names]
        self._actuated = np.concatenate(
            [np.arange(joint.idx_v, joint.idx_v + joint.nv) for joint in joints]
        )
        self._dependent = np.setdiff1d(np.arange(self.model.nv), self._actuated)
        bodies = self.model.njoints - 1
        self._rows = sum(loop.residualSize() for loop in self._loops)
        self._twist_rows = 6 * bodies
        self._joints = range(1, bodies + 1)
        # Joint j moves body i if it lies between the base and body i.
        self._moves = np.zeros((bodies + 1, self.model.nv))
        for body in self._joints:
            for ancestor in list(self.model.supports[body])[1:]:
                joint = self.model.joints[ancestor]
                self._moves[body, joint.idx_v : joint.idx_v + joint.nv] = 1.0
        self.body_names: tuple[str, ...] = tuple(self._body_name(joint) for joint in self._joints)
        """Names of the bodies, in the order of the rows of K and T."""

    def _body_name(self, joint: int) -> str:
        for frame in self.model.frames:
            if frame.type == pin.FrameType.BODY and frame.parentJoint == joint:
                return str(frame.name)
        return str(self.model.names[joint])

    @functools.cached_property
    def _from_home(self) -> NewtonFromHome:
        # Only when it is asked for: whoever has configurations needs no home that closes the loops.
        home = getattr(self.robot, "q0", None)
        return NewtonFromHome(
            self.model,
            self._names,
            pin.neutral(self.model) if home is None else one_row("q0", home, self.model.nq),
            self._constraint,
            self._constraint_jacobian,
            self._complement,
        )

    @functools.cached_property
    def _limited(self) -> PassiveLimits:
        return PassiveLimits(self.model, self._names)

    # Rows: one configuration at a time, because Pinocchio takes one at a time

    def _at(
        self, function: Callable[[Array], Array], shape: tuple[int, ...], q: ArrayLike
    ) -> Array:
        return applied_to_rows(function, shape, q=(q, self.model.nq))

    def _moving(
        self,
        function: Callable[[Array, Array], Array],
        shape: tuple[int, ...],
        q: ArrayLike,
        v: ArrayLike,
    ) -> Array:
        return applied_to_rows(function, shape, q=(q, self.model.nq), v=(v, self.model.nv))

    def _place(self, q: Array, v: Array | None = None) -> None:
        """Let Pinocchio compute placements and joint Jacobians at q, with rates if v is given."""
        if v is None:
            pin.computeJointJacobians(self.model, self._data, q)
        else:
            pin.computeJointJacobiansTimeVariation(self.model, self._data, q, v)

    def _closure_frames(self, loop: Any) -> list[tuple[Any, Array]]:
        """Placement of the two frames of a loop and the joints that move each."""
        return [
            (self._data.oMi[joint] * placement, self._moves[joint])
            for joint, placement in (
                (loop.joint1_id, loop.joint1_placement),
                (loop.joint2_id, loop.joint2_placement),
            )
        ]

    def _constraint(self, q: Array) -> Array:
        self._place(q)
        residuals = [np.zeros(0)]
        for loop in self._loops:
            (first, _), (second, _) = self._closure_frames(loop)
            relative = first.actInv(second)
            residuals.append(
                pin.log6(relative).vector
                if loop.type == pin.ContactType.CONTACT_6D
                else relative.translation
            )
        return np.concatenate(residuals)

    def _constraint_jacobian(self, q: Array) -> Array:
        self._place(q)
        jacobian = np.array(self._data.J)
        rows = [np.zeros((0, self.model.nv))]
        for loop in self._loops:
            (first, moves_first), (second, moves_second) = self._closure_frames(loop)
            relative = first.actInv(second)
            # Twist of the second frame relative to the first, in axes of the second, per unit of
            # joint velocity.
            twist = second.toActionMatrixInverse() @ (
                jacobian * moves_second - jacobian * moves_first
            )
            if loop.type == pin.ContactType.CONTACT_6D:
                # Jlog6 makes this the derivative of the logarithm away from closure too, where
                # Pinocchio's is not.
                rows.append(pin.Jlog6(relative) @ twist)
            else:
                rows.append(relative.rotation @ twist[:3])
        return np.concatenate(rows)

    def _constraint_jacobian_dot(self, q: Array, v: Array) -> Array:
        self._place(q, v)
        jacobian, rate = np.array(self._data.J), np.array(self._data.dJ)
        rows = [np.zeros((0, self.model.nv))]
        for loop in self._loops:
            (first, moves_first), (second, moves_second) = self._closure_frames(loop)
            relative = first.actInv(second)
            to_second = second.toActionMatrixInverse()
            difference = jacobian * moves_second - jacobian * moves_first
            # The axes of the second frame turn with it.
            twist_rate = to_second @ (
                rate * moves_second
                - rate * moves_first
                - _motion_cross((jacobian * moves_second) @ v) @ difference
            )
            if loop.type == pin.ContactType.CONTACT_6D:
                # A velocity that keeps the loops closed leaves the relative placement, and so
                # Jlog6, constant.
                rows.append(pin.Jlog6(relative) @ twist_rate)
            else:
                # The relative rotation turns the rows, too, but what it turns vanishes for every
                # velocity that keeps the loops closed, and only its product with L is ever used.
                rows.append(relative.rotation @ twist_rate[:3])
        return np.concatenate(rows)

    def _complement(self, q: Array) -> tuple[Array, Array, Array]:
        """L, the inverse of Φ^u and Φ at one configuration."""
        jacobian = self._constraint_jacobian(q)
        inverse = dependent_solver(jacobian[:, self._dependent])
        complement = np.zeros((self.model.nv, self._actuated.size))
        complement[self._actuated] = np.eye(self._actuated.size)
        complement[self._dependent] = -inverse @ jacobian[:, self._actuated]
        # With more actuated joints than degrees of freedom no L keeps the loops closed, and the
        # pseudo-inverse only comes near.
        if np.abs(jacobian @ complement).max(initial=0.0) > MOBILITY_TOLERANCE * np.abs(
            jacobian
        ).max(initial=1.0):
            raise MobilityMismatch(mobility(self.model, self._loops, self._names, q), self._names)
        return complement, inverse, jacobian

    def _check_velocity(self, q: Array, v: Array) -> None:
        # L itself, not only Φ, so that a singular configuration is reported as what it is.
        _, _, jacobian = self._complement(q)
        residual = float(np.abs(jacobian @ v).max(initial=0.0))
        tolerance = VELOCITY_TOLERANCE * float(np.abs(v).max(initial=0.0))
        if not residual <= tolerance:
            raise InconsistentVelocity(residual, tolerance)

    def _check_closed(self, q: Array) -> None:
        residual = float(np.abs(self._constraint(q)).max(initial=0.0))
        if not residual <= CLOSURE_TOLERANCE:
            raise OpenLoops(residual, CLOSURE_TOLERANCE)

    def _complement_dot(self, q: Array, v: Array) -> Array:
        self._check_velocity(q, v)
        complement, inverse, _ = self._complement(q)
        rate = np.zeros_like(complement)
        rate[self._dependent] = -inverse @ (self._constraint_jacobian_dot(q, v) @ complement)
        return rate

    def _centers(self) -> Array:
        """Centers of mass of the bodies in world axes, (r, 3)."""
        return np.array(
            [self._data.oMi[joint].act(self.model.inertias[joint].lever) for joint in self._joints]
        )

    def _twists(self, q: Array) -> Array:
        """K at one configuration."""
        self._place(q)
        jacobian = np.array(self._data.J)
        moves = self._moves[1:, np.newaxis, :]
        angular = moves * jacobian[3:]
        # Pinocchio's columns are twists at the world's origin: e_j × (0 − r_0j) becomes e_j × r_j
        # at the center of mass.
        linear = moves * (jacobian[:3] - _skew(self._centers()) @ jacobian[3:])
        return np.concatenate([angular, linear], axis=1).reshape(-1, self.model.nv)

    def _twists_dot(self, q: Array, v: Array) -> Array:
        self._check_velocity(q, v)
        velocities = (self._twists(q) @ v).reshape(-1, 6)[:, 3:]
        self._place(q, v)
        jacobian, rate = np.array(self._data.J), np.array(self._data.dJ)
        moves = self._moves[1:, np.newaxis, :]
        angular = moves * rate[3:]
        linear = moves * (
            rate[:3] - _skew(self._centers()) @ rate[3:] - _skew(velocities) @ jacobian[3:]
        )
        return np.concatenate([angular, linear], axis=1).reshape(-1, self.model.nv)

    def _natural(self, q: Array) -> Array:
        twists = self._twists(q)
        _, inverse, jacobian = self._complement(q)
        dependent, actuated = self._dependent, self._actuated
        return twists[:, actuated] - twists[:, dependent] @ inverse @ jacobian[:, actuated]

    def _natural_dot(self, q: Array, v: Array) -> Array:
        twists, rate = self._twists(q), self._twists_dot(q, v)
        _, inverse, jacobian = self._complement(q)
        jacobian_dot = self._constraint_jacobian_dot(q, v)
        dependent, actuated = self._dependent, self._actuated
        ratio = inverse @ jacobian[:, actuated]
        return (
            rate[:, actuated]
            - rate[:, dependent] @ ratio
            + twists[:, dependent] @ inverse @ jacobian_dot[:, dependent] @ ratio
            - twists[:, dependent] @ inverse @ jacobian_dot[:, actuated]
        )

    def _total_mass(self, q: Array) -> Array:
        self._place(q)
        total = np.zeros((6 * len(self._joints), 6 * len(self._joints)))
        for i, joint in enumerate(self._joints):
            inertia, rotation = self.model.inertias[joint], self._data.oMi[joint].rotation
            block = slice(6 * i, 6 * i + 3)
            total[block, block] = rotation @ inertia.inertia @ rotation.T
            block = slice(6 * i + 3, 6 * i + 6)
            total[block, block] = inertia.mass * np.eye(3)
        return total

    def _spin(self, q: Array, v: Array) -> Array:
        self._check_velocity(q, v)
        rates = (self._twists(q) @ v).reshape(-1, 6)[:, :3]
        spin = np.zeros((6 * len(rates), 6 * len(rates)))
        for i, block in enumerate(_skew(rates)):
            spin[6 * i : 6 * i + 3, 6 * i : 6 * i + 3] = block
        return spin

    def _mass(self, q: Array) -> Array:
        self._check_closed(q)
        natural = self._natural(q)
        mass: Array = natural.T @ self._total_mass(q) @ natural
        return mass

    def _coriolis(self, q: Array, v: Array) -> Array:
        self._check_closed(q)
        natural, total = self._natural(q), self._total_mass(q)
        coriolis: Array = natural.T @ (
            total @ self._natural_dot(q, v) + self._spin(q, v) @ total @ natural
        )
        return coriolis

    def _weight(self, q: Array) -> Array:
        self._check_closed(q)
        return -self._natural(q).T @ self.w_g()

    # The thesis's quantities

    def constraint(self, q: ArrayLike) -> Array:
        r"""Return the constraints :math:`\phi(q)`, zero where the loops are closed (eq. 3.6).

        Six rows per 6D loop, the logarithm of the relative placement of its two frames; three rows
        per 3D loop, their distance in axes of the first. The printed eq. 3.13 takes the Cayley form
        of each frame's rotation, which is singular at 180° and therefore bad near home already; the
        logarithm of the *relative* rotation is not.

        Parameters
        ----------
        q : (..., nq) array_like
            Configurations, closed or not.

        Returns
        -------
        (..., m) ndarray
            Residuals [m, rad].

        Raises
        ------
        InvalidArray
            If q is not finite or of another shape.
        """
        return self._at(self._constraint, (self._rows,), q)

    def constraint_jacobian(self, q: ArrayLike) -> Array:
        r"""Return the constraint Jacobian :math:`\Phi = \partial\phi/\partial q` (eq. 3.19).

        It holds away from closure, too.

        Its columns of the actuated joints are :math:`\Phi^a` (3.20), the others :math:`\Phi^u`
        (3.21). Pinocchio's own constraint Jacobian is minus this one at closure.

        Parameters
        ----------
        q : (..., nq) array_like
            Configurations, closed or not.

        Returns
        -------
        (..., m, nv) ndarray

        Raises
        ------
        InvalidArray
            If q is not finite or of another shape.
        """
        return self._at(self._constraint_jacobian, (self._rows, self.model.nv), q)

    def configuration(self, positions: ArrayLike) -> Array:
        r"""Return the configurations that close the loops, by iteration from home (eq. 3.15).

        Newton's method on :meth:`constraint` with :meth:`constraint_jacobian`, in steps that keep
        the assembly mode of home, the robot's ``q0`` (of the 3-PSP :math:`q^u_0 = [0, \dots, 0,
        d, d, d]`: hinges straight, arms as long as the screws are off the axis).

        Parameters
        ----------
        positions : (..., n) array_like
            Positions of the actuated joints [m or rad].

        Returns
        -------
        (..., nq) ndarray
            Configurations, closed to rounding.

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
        closed = applied_to_rows(
            self._from_home.configuration,
            (self.model.nq,),
            positions=(positions, self._actuated.size),
        )
        self._limited.check(closed.reshape(-1, self.model.nq))
        return closed

    def L(self, q: ArrayLike) -> Array:
        r"""Return the joint orthogonal complement, :math:`\dot q = L \dot q^a` (eq. 3.16).

        .. math:: L = \begin{bmatrix} 1 \\ -(\Phi^u)^{-1} \Phi^a \end{bmatrix} \qquad (3.17)

        Parameters
        ----------
        q : (..., nq) array_like
            Configurations.

        Returns
        -------
        (..., nv, n) ndarray
            Rows in the order of the model, columns in the order of the actuated joints.

        Raises
        ------
        InvalidArray
            If q is not finite or of another shape.
        SingularConfiguration
            If the actuated joints do not determine the others, as in a gimbal configuration.
        """
        return self._at(
            lambda row: self._complement(row)[0], (self.model.nv, self._actuated.size), q
        )

    def L_dot(self, q: ArrayLike, v: ArrayLike) -> Array:
        r"""Return the rate of L, from :math:`\Phi L = 0`.

        :math:`\dot L^u = -(\Phi^u)^{-1} \dot\Phi L`.

        Parameters
        ----------
        q, v : (..., nq), (..., nv) array_like
            Configurations and velocities ``v = L(q) @ speeds``.

        Returns
        -------
        (..., nv, n) ndarray

        Raises
        ------
        InvalidArray, InconsistentVelocity, SingularConfiguration
            If an argument is malformed, the velocity would open the loops, or the configuration is
            singular.
        """
        return self._moving(self._complement_dot, (self.model.nv, self._actuated.size), q, v)

    def K(self, q: ArrayLike) -> Array:
        r"""Return the twists of all bodies per unit of joint velocity (eq. 3.27–3.30).

        That is :math:`t_i = K_i \dot q`.

        Column j of :math:`K_i = [A_i; B_i]` is :math:`[e_j; e_j \times r_j]` for a revolute joint,
        with :math:`r_j` from the joint to the body's center of mass, and :math:`[0; e_j]` for a
        prismatic one, provided that the joint lies between the base and body i; else it is zero.
        (Printed 3.29 has 0 in both parts for a prismatic joint, and nothing on the joints that do
        not move body i; 3.30 splits the rows of K where the columns are meant.)

        Parameters
        ----------
        q : (..., nq) array_like
            Configurations.

        Returns
        -------
        (..., 6 r, nv) ndarray

        Raises
        ------
        InvalidArray
            If q is not finite or of another shape.
        """
        return self._at(self._twists, (self._twist_rows, self.model.nv), q)

    def K_dot(self, q: ArrayLike, v: ArrayLike) -> Array:
        """Return the rate of K, of shape (..., 6 r, nv).

        Arguments and errors as in :meth:`L_dot`.
        """
        return self._moving(self._twists_dot, (self._twist_rows, self.model.nv), q, v)

    def T(self, q: ArrayLike) -> Array:
        r"""Return the natural orthogonal complement, :math:`t = T \dot q^a` (eq. 3.31).

        .. math:: T = K^a - K^u (\Phi^u)^{-1} \Phi^a = K L \qquad (3.33, 3.32)

        (The print of 3.33 agrees only if :math:`K^a, K^u` are columns of K.)

        Parameters
        ----------
        q : (..., nq) array_like
            Configurations.

        Returns
        -------
        (..., 6 r, n) ndarray

        Raises
        ------
        InvalidArray, SingularConfiguration
            See :meth:`L`.
        """
        return self._at(self._natural, (self._twist_rows, self._actuated.size), q)

    def T_dot(self, q: ArrayLike, v: ArrayLike) -> Array:
        r"""Return the rate of T (eq. 3.35).

        .. math::

            \dot T = \dot K^a - \dot K^u (\Phi^u)^{-1} \Phi^a
            + K^u (\Phi^u)^{-1} \dot\Phi^u (\Phi^u)^{-1} \Phi^a
            - K^u (\Phi^u)^{-1} \dot\Phi^a

        (Printed with :math:`\dot\Phi^a` in the third term, where the derivative of the inverse
        gives :math:`\dot\Phi^u`.)

        Parameters
        ----------
        q, v : (..., nq), (..., nv) array_like
            Configurations and velocities ``v = L(q) @ speeds``.

        Returns
        -------
        (..., 6 r, n) ndarray

        Raises
        ------
        InvalidArray, InconsistentVelocity, SingularConfiguration
            See :meth:`L_dot`.
        """
        return self._moving(self._natural_dot, (self._twist_rows, self._actuated.size), q, v)

    def M_total(self, q: ArrayLike) -> Array:
        r"""Return the block-diagonal mass matrix of the free bodies (eq. 3.36b).

        Its blocks are :math:`M_i = \operatorname{diag}(R I_i R^T, m_i 1)`.

        (Printed with :math:`I_i` as it is, which holds in the body's own axes only.)

        Parameters
        ----------
        q : (..., nq) array_like
            Configurations.

        Returns
        -------
        (..., 6 r, 6 r) ndarray
            [kg m²] and [kg].

        Raises
        ------
        InvalidArray
            If q is not finite or of another shape.
        """
        return self._at(self._total_mass, (self._twist_rows, self._twist_rows), q)

    def Omega(self, q: ArrayLike, v: ArrayLike) -> Array:
        r"""Return the angular velocities in blocks (eq. 3.36c).

        They are :math:`\Omega_i = \operatorname{diag}(\omega_i \times, 0)`.

        Parameters
        ----------
        q, v : (..., nq), (..., nv) array_like
            Configurations and velocities ``v = L(q) @ speeds``.

        Returns
        -------
        (..., 6 r, 6 r) ndarray
            [rad/s]. It acts on the angular part only: the momentum of a center of mass does not
            turn with the body.

        Raises
        ------
        InvalidArray, InconsistentVelocity, SingularConfiguration
            See :meth:`L_dot`.
        """
        return self._moving(self._spin, (self._twist_rows, self._twist_rows), q, v)

    def w_g(self) -> Array:
        r"""Return the weights of the bodies as wrenches, :math:`w^g_i = [0; m_i g]` (eq. 3.36a).

        (Printed as :math:`+m_i g` along z; with :math:`G = -T^T w^g` it must point down.)

        Returns
        -------
        (6 r,) ndarray
            [N m] and [N], in world axes.
        """
        gravity = self.model.gravity.linear
        return np.concatenate(
            [
                np.concatenate([np.zeros(3), self.model.inertias[joint].mass * gravity])
                for joint in self._joints
            ]
        )

    def mass_matrix(self, q: ArrayLike) -> Array:
        r"""Return :math:`M = T^T M_\text{total} T` (eq. 3.2).

        Parameters
        ----------
        q : (..., nq) array_like
            Closed configurations.

        Returns
        -------
        (..., n, n) ndarray

        Raises
        ------
        InvalidArray, OpenLoops, SingularConfiguration
            If q is malformed, does not close the loops, or is singular.
        """
        return self._at(self._mass, (self._actuated.size, self._actuated.size), q)

    def coriolis_matrix(self, q: ArrayLike, v: ArrayLike) -> Array:
        r"""Return :math:`C = T^T M_\text{total} \dot T + T^T \Omega M_\text{total} T` (eq. 3.3).

        Parameters
        ----------
        q, v : (..., nq), (..., nv) array_like
            Closed configurations and velocities ``v = L(q) @ speeds``.

        Returns
        -------
        (..., n, n) ndarray

        Raises
        ------
        InvalidArray, OpenLoops, InconsistentVelocity, SingularConfiguration
            See :meth:`mass_matrix` and :meth:`L_dot`.
        """
        return self._moving(self._coriolis, (self._actuated.size, self._actuated.size), q, v)

    def gravity(self, q: ArrayLike) -> Array:
        r"""Return :math:`G = -T^T w^g` (eq. 3.4), of shape (..., n).

        Errors as in :meth:`mass_matrix`.
        """
        return self._at(self._weight, (self._actuated.size,), q)

    def inverse_dynamics(self, q: ArrayLike, v: ArrayLike, accelerations: ArrayLike) -> Array:
        r"""Return the actuator forces :math:`\tau = M \ddot q^a + C \dot q^a + G` (eq. 3.1).

        Parameters
        ----------
        q, v : (..., nq), (..., nv) array_like
            Closed configurations and velocities ``v = L(q) @ speeds``.
        accelerations : (..., n) array_like
            Accelerations of the actuated joints.

        Returns
        -------
        (..., n) ndarray

        Raises
        ------
        InvalidArray, OpenLoops, InconsistentVelocity, SingularConfiguration
            See :meth:`coriolis_matrix`.
        """

        def one(q: Array, v: Array, accelerations: Array) -> Array:
            forces: Array = (
                self._mass(q) @ accelerations
                + self._coriolis(q, v) @ v[self._actuated]
                + self._weight(q)
            )
            return forces

        n = self._actuated.size
        return applied_to_rows(
            one, (n,), q=(q, self.model.nq), v=(v, self.model.nv), accelerations=(accelerations, n)
        )

    def equation_of_motion(
        self, positions: ArrayLike, speeds: ArrayLike
    ) -> tuple[Array, Array, Array]:
        """Return M, C and G at actuated positions and speeds.

        So that a controller can be driven by the thesis's model. The loops are closed anew in every
        call, see :meth:`configuration`.

        Parameters
        ----------
        positions, speeds : (..., n) array_like
            Positions and speeds of the actuated joints.

        Returns
        -------
        M : (..., n, n) ndarray
        C : (..., n, n) ndarray
        G : (..., n) ndarray

        Raises
        ------
        InvalidArray
            If an argument is not finite or of another shape.
        ClosureFailed, JointLimitExceeded, SingularConfiguration
            If the robot has no closed configuration there, see :meth:`configuration`.
        """
        q, v, _ = self._state(positions=positions, speeds=speeds)
        return self.mass_matrix(q), self.coriolis_matrix(q, v), self.gravity(q)

    def actuator_forces(
        self, positions: ArrayLike, speeds: ArrayLike, accelerations: ArrayLike
    ) -> Array:
        r"""Return the actuator forces of a motion of the actuated joints (eq. 3.1).

        .. math:: \tau = M(a)\, \ddot a + C(a, \dot a)\, \dot a + G(a)

        Parameters
        ----------
        positions, speeds, accelerations : (..., n) array_like
            Motion of the actuated joints.

        Returns
        -------
        (..., n) ndarray
            Forces [N], of hinges torques [N m].

        Raises
        ------
        InvalidArray, ClosureFailed, JointLimitExceeded, SingularConfiguration
            See :meth:`equation_of_motion`.
        """
        q, v, (acceleration,) = self._state(
            positions=positions, speeds=speeds, accelerations=accelerations
        )
        return self.inverse_dynamics(q, v, acceleration)

    def _state(self, **motion: ArrayLike) -> tuple[Array, Array, list[Array]]:
        """Return q and v at actuated positions and speeds, and what else of the motion is given."""
        n = self._actuated.size
        positions, rates, *others = together(
            **{name: finite_rows(name, values, n) for name, values in motion.items()}
        )
        q = self.configuration(positions)
        return q, np.einsum("...ij,...j->...i", self.L(q), rates), others
