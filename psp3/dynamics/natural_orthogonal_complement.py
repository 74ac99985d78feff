r"""The thesis's dynamics: the natural orthogonal complement (eq. 3.2–3.4 and 3.6–3.36).

The complement :math:`T` maps the actuated speeds to the twists of all bodies,
:math:`t = T \dot q^a`. Twists that the loops allow do no work against the constraint forces, so
projecting the Newton–Euler equations of the free bodies with :math:`T` removes those forces and
leaves

.. math:: M = T^T M_\text{total} T, \qquad
          C = T^T M_\text{total} \dot T + T^T \Omega M_\text{total} T, \qquad G = -T^T w^g.

If a printed equation is wrong (see each function), the correct one is implemented. Joint quantities
(placements, joint Jacobians and their rates, inertias) come from Pinocchio. Everything else is in
this module and in :mod:`psp3.dynamics.newton_from_home`, which closes the loops. So the code works
for any tree with named actuated joints, with or without loops. It uses only the robot's tree,
loops, motor names and reference configuration, and never calls ``robot.configuration``.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from fuzzy2.support.described import Described
from psp3.checks import Array, applied_to_rows
from psp3.closure.passive_limits import PassiveLimits
from psp3.dynamics.mechanism import HasTree, Mechanism
from psp3.dynamics.motors import forces_of_motors
from psp3.dynamics.newton_from_home import Closed, NewtonFromHome
from psp3.errors import InconsistentVelocity, InvalidValue, NoFiniteAnswer, OpenLoops

CLOSURE_TOLERANCE = 1e-6
"""Dynamics is refused if a loop is open by more than this [m, rad]."""

VELOCITY_TOLERANCE = 1e-8
"""A velocity is refused if it violates the loops by more than this share of its size."""


def _skew(vectors: Array) -> Array:
    """Cross-product matrices, (..., 3) to (..., 3, 3)."""
    matrices = np.zeros((*vectors.shape, 3))
    x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
    matrices[..., 0, 1], matrices[..., 0, 2], matrices[..., 1, 2] = -z, y, -x
    matrices[..., 1, 0], matrices[..., 2, 0], matrices[..., 2, 1] = z, -y, x
    return matrices


def _motion_cross(twist: Array) -> Array:
    """Matrix of the cross product of motions, for twists ordered [v; ω] as in Pinocchio."""
    matrix = np.zeros((6, 6))
    matrix[:3, :3] = matrix[3:, 3:] = pin.skew(twist[3:])
    matrix[:3, 3:] = pin.skew(twist[:3])
    return matrix


def _block_diagonal(blocks: Array) -> Array:
    """Matrix of blocks (r, 6, 6), (6 r, 6 r)."""
    bodies = np.arange(len(blocks))
    matrix = np.zeros((len(blocks), 6, len(blocks), 6))
    matrix[bodies, :, bodies, :] = blocks
    return matrix.reshape(6 * len(blocks), -1)


def _size(values: Array) -> float:
    return float(np.abs(values).max(initial=0.0))


class _Loop:
    """A loop closure: its two frames, and the joints that move them."""

    def __init__(self, loop: Any, moves: Array, first_row: int) -> None:
        self.first, self.second = loop.joint1_id, loop.joint2_id
        self.in_first, self.in_second = loop.joint1_placement, loop.joint2_placement
        self.is_6d = loop.type == pin.ContactType.CONTACT_6D
        self.rows = slice(first_row, first_row + int(loop.residualSize()))
        self.moves_second = moves[self.second]
        self.difference = moves[self.second] - moves[self.first]


class _Tree:
    """The constant properties of a tree: joints, bodies and loops; and Pinocchio's data."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.model = model = mechanism.model
        self.data = model.createData()
        self.actuated, self.dependent = mechanism.actuated, mechanism.dependent
        self.joints = range(1, model.njoints)
        # Joint j moves body i if it lies between the base and body i.
        moves = np.zeros((model.njoints, model.nv))
        for body in self.joints:
            for ancestor in list(model.supports[body])[1:]:
                joint = model.joints[ancestor]
                moves[body, joint.idx_v : joint.idx_v + joint.nv] = 1.0
        self.moves = moves[1:, np.newaxis, :]
        bodies = [model.inertias[joint] for joint in self.joints]
        self.masses = np.array([body.mass for body in bodies])
        self.levers = np.array([body.lever for body in bodies])
        self.inertias = np.array([body.inertia for body in bodies])
        self.rows, self.loops = 0, list[_Loop]()
        for loop in mechanism.loops:
            self.loops.append(_Loop(loop, moves, self.rows))
            self.rows += int(loop.residualSize())

    def frames(self) -> list[tuple[Any, Any]]:
        """Return the placements of the two frames of every loop, from Pinocchio's current data."""
        placements = self.data.oMi
        return [
            (placements[loop.first] * loop.in_first, placements[loop.second] * loop.in_second)
            for loop in self.loops
        ]

    def constraint(self, q: Array) -> tuple[Array, Array]:
        """Return φ and Φ at one configuration; Pinocchio's data then holds its placements."""
        jacobian = pin.computeJointJacobians(self.model, self.data, q)
        residual, derivative = np.empty(self.rows), np.empty((self.rows, self.model.nv))
        for loop, (first, second) in zip(self.loops, self.frames(), strict=True):
            relative = first.actInv(second)
            # Twist of the second frame relative to the first, in axes of the second, per unit of
            # joint velocity.
            change, moved = second.toActionMatrixInverse(), jacobian * loop.difference
            if loop.is_6d:
                residual[loop.rows] = pin.log6(relative).vector
                # With Jlog6 this is the derivative of the logarithm even if the loops are open;
                # Pinocchio's is not.
                derivative[loop.rows] = (pin.Jlog6(relative) @ change) @ moved
            else:
                residual[loop.rows] = relative.translation
                derivative[loop.rows] = (relative.rotation @ change[:3]) @ moved
        return residual, derivative

    def weights(self) -> Array:
        """Return the weights of the bodies as wrenches, (6 r,) (eq. 3.36a)."""
        wrenches = np.zeros((len(self.masses), 6))
        wrenches[:, 3:] = np.outer(self.masses, self.model.gravity.linear)
        return wrenches.ravel()


class _State:
    """The thesis's quantities at one configuration and one velocity, each computed once.

    Pinocchio's placements are read when they are first needed, so only the most recent state is
    valid.
    """

    def __init__(self, tree: _Tree, q: Array) -> None:
        self._tree, self._q = tree, q
        self.constraint, self.jacobian = tree.constraint(q)
        self._joint_jacobian = np.array(tree.data.J)

    @classmethod
    def where_closed(cls, tree: _Tree, found: Closed) -> _State:
        """Return the state at which the loops were just closed."""
        state = cls.__new__(cls)
        state._tree, state._q, state.jacobian = tree, found.q, found.jacobian
        state._joint_jacobian = np.array(tree.data.J)
        state._solved = found.complement, found.inverse
        return state

    def moving(self, v: Array) -> _State:
        """Set a velocity, which must keep the loops closed."""
        # L comes first, so that a singular configuration is reported as singular.
        _ = self._solved
        residual, tolerance = _size(self.jacobian @ v), VELOCITY_TOLERANCE * _size(v)
        if not residual <= tolerance:
            raise InconsistentVelocity(residual, tolerance)
        self._v = v
        tree = self._tree
        pin.computeJointJacobiansTimeVariation(tree.model, tree.data, self._q, v)
        self._joint_jacobian_dot = np.array(tree.data.dJ)
        return self

    def closed(self) -> _State:
        """Refuse loops that are open."""
        residual = _size(self.constraint)
        if not residual <= CLOSURE_TOLERANCE:
            raise OpenLoops(residual, CLOSURE_TOLERANCE)
        return self

    @functools.cached_property
    def _solved(self) -> tuple[Array, Array]:
        return self._tree.mechanism.complement(self._q, self.jacobian)

    @property
    def L(self) -> Array:
        """Eq. 3.17."""
        return self._solved[0]

    @functools.cached_property
    def _ratio(self) -> Array:
        """The product of the inverse of Φ^u and Φ^a."""
        return self._solved[1] @ self.jacobian[:, self._tree.actuated]

    @functools.cached_property
    def _jacobian_dot(self) -> Array:
        tree, jacobian, rate = self._tree, self._joint_jacobian, self._joint_jacobian_dot
        rows = np.empty((tree.rows, tree.model.nv))
        for loop, (first, second) in zip(tree.loops, tree.frames(), strict=True):
            relative = first.actInv(second)
            # The axes of the second frame rotate with it.
            turning = _motion_cross(jacobian @ (loop.moves_second * self._v))
            twist_rate = second.toActionMatrixInverse() @ (
                (rate - turning @ jacobian) * loop.difference
            )
            if loop.is_6d:
                # A velocity that keeps the loops closed leaves the relative placement, and so
                # Jlog6, constant.
                rows[loop.rows] = pin.Jlog6(relative) @ twist_rate
            else:
                # The relative rotation also rotates the rows, but this term is zero for every
                # velocity that keeps the loops closed, and only its product with L is used.
                rows[loop.rows] = relative.rotation @ twist_rate[:3]
        return rows

    @property
    def L_dot(self) -> Array:
        """From Φ L = 0."""
        rate = np.zeros_like(self.L)
        rate[self._tree.dependent] = -self._solved[1] @ (self._jacobian_dot @ self.L)
        return rate

    @functools.cached_property
    def _placements(self) -> Array:
        """Placements of the bodies, (r, 4, 4)."""
        placements = self._tree.data.oMi
        return np.array([placements[joint].homogeneous for joint in self._tree.joints])

    @functools.cached_property
    def _lever(self) -> Array:
        """Cross-product matrices of the centers of mass in world axes, (r, 3, 3)."""
        rotations, origins = self._placements[:, :3, :3], self._placements[:, :3, 3]
        return _skew((rotations @ self._tree.levers[..., np.newaxis])[..., 0] + origins)

    @functools.cached_property
    def K(self) -> Array:
        """Eq. 3.27 to 3.30."""
        jacobian, moves = self._joint_jacobian, self._tree.moves
        twists = np.empty((len(moves), 6, moves.shape[-1]))
        twists[:, :3] = moves * jacobian[3:]
        # Pinocchio's columns are twists at the world's origin: e_j × (0 − r_0j) becomes e_j × r_j
        # at the center of mass.
        twists[:, 3:] = moves * (jacobian[:3] - self._lever @ jacobian[3:])
        return twists.reshape(-1, moves.shape[-1])

    @functools.cached_property
    def _twists(self) -> Array:
        """The twists of the bodies, (r, 6)."""
        twists: Array = (self.K @ self._v).reshape(-1, 6)
        return twists

    @functools.cached_property
    def K_dot(self) -> Array:
        """Rate of K."""
        jacobian, rate, moves = self._joint_jacobian, self._joint_jacobian_dot, self._tree.moves
        twists = np.empty((len(moves), 6, moves.shape[-1]))
        twists[:, :3] = moves * rate[3:]
        twists[:, 3:] = moves * (
            rate[:3] - self._lever @ rate[3:] - _skew(self._twists[:, 3:]) @ jacobian[3:]
        )
        return twists.reshape(-1, moves.shape[-1])

    @functools.cached_property
    def T(self) -> Array:
        """Eq. 3.33."""
        return self.K[:, self._tree.actuated] - self.K[:, self._tree.dependent] @ self._ratio

    @functools.cached_property
    def T_dot(self) -> Array:
        """Eq. 3.35, its third and fourth term together."""
        actuated, dependent = self._tree.actuated, self._tree.dependent
        turned = self._jacobian_dot[:, dependent] @ self._ratio - self._jacobian_dot[:, actuated]
        return (
            self.K_dot[:, actuated]
            - self.K_dot[:, dependent] @ self._ratio
            + self.K[:, dependent] @ (self._solved[1] @ turned)
        )

    # Matrices of the free bodies are stored as blocks, (r, 6, 6); all other entries are zero.

    @functools.cached_property
    def M_blocks(self) -> Array:
        """Eq. 3.36b."""
        rotations, blocks = self._placements[:, :3, :3], np.zeros((len(self._placements), 6, 6))
        blocks[:, :3, :3] = rotations @ self._tree.inertias @ rotations.swapaxes(1, 2)
        for axis in (3, 4, 5):
            blocks[:, axis, axis] = self._tree.masses
        return blocks

    @property
    def Omega_blocks(self) -> Array:
        """Eq. 3.36c."""
        blocks = np.zeros((len(self._twists), 6, 6))
        blocks[:, :3, :3] = _skew(self._twists[:, :3])
        return blocks

    @functools.cached_property
    def _momentum(self) -> Array:
        """The product of M_total and T, body by body, (r, 6, n)."""
        return self.M_blocks @ self.T.reshape(-1, 6, self.T.shape[1])

    @property
    def mass(self) -> Array:
        """Eq. 3.2."""
        return self.T.T @ self._momentum.reshape(self.T.shape)

    @property
    def coriolis(self) -> Array:
        """Eq. 3.3."""
        rate = self.T_dot.reshape(self._momentum.shape)
        forces = self.M_blocks @ rate + self.Omega_blocks @ self._momentum
        return self.T.T @ forces.reshape(self.T.shape)

    @property
    def gravity(self) -> Array:
        """Eq. 3.4."""
        return -self.T.T @ self._tree.weights()

    def forces(self, speeds: Array, accelerations: Array) -> Array:
        """Eq. 3.1."""
        return self.mass @ accelerations + self.coriolis @ speeds + self.gravity


class NaturalOrthogonalComplement(Described):
    """Natural orthogonal complement of a tree with loops.

    All methods take full Pinocchio vectors ``q`` (..., nq) and ``v`` (..., nv) with
    ``v = L(q) @ speeds``; any other velocity is refused. Rows of L and columns of K follow
    ``robot.model``. A twist is [ω; v] in world axes at the body's center of mass, and the bodies
    are the links of the tree, one per joint, in the order of ``body_names``.

    Parameters
    ----------
    robot : HasTree
        Any object with a Pinocchio ``model``. Optional attributes, as in
        :class:`psp3.ClosedLoopRobot` and the robots of example-robot-data, are
        ``constraint_models`` (default: no loops), ``actuated`` (default: every joint) and ``q0``,
        the configuration from which the loops are closed (default: ``neutral`` of the model).
    """

    def __init__(self, robot: HasTree) -> None:
        if not isinstance(getattr(robot, "model", None), pin.Model):
            raise InvalidValue("robot", robot, "a robot with a Pinocchio model")
        self.robot = robot
        self.model = robot.model
        self._mechanism = Mechanism(robot)
        self._tree = _Tree(self._mechanism)
        self._actuated = self._mechanism.actuated
        self._twist_rows = 6 * len(self._tree.joints)
        self.body_names: tuple[str, ...] = tuple(map(self._body_name, self._tree.joints))
        """Names of the bodies, in the order of the rows of K and T."""

    def _facts(self) -> dict[str, Any]:
        return {"robot": self.robot, "bodies": len(self.body_names)}

    def __reduce__(self) -> tuple[type[NaturalOrthogonalComplement], tuple[HasTree]]:
        # Pinocchio can pickle neither constraints nor their data.
        return type(self), (self.robot,)

    def _body_name(self, joint: int) -> str:
        for frame in self.model.frames:
            if frame.type == pin.FrameType.BODY and frame.parentJoint == joint:
                return str(frame.name)
        return str(self.model.names[joint])

    @functools.cached_property
    def _from_home(self) -> NewtonFromHome:
        # Created on demand: if the caller has configurations, home need not close the loops.
        return NewtonFromHome(
            self.model,
            self._mechanism.names,
            self._mechanism.home(),
            self._tree.constraint,
            self._mechanism.complement,
            self._mechanism.dependent,
        )

    @functools.cached_property
    def _limited(self) -> PassiveLimits:
        return PassiveLimits(self.model, self._mechanism.names)

    # Rows: Pinocchio takes one configuration at a time

    def _at(
        self, function: Callable[[_State], Array], shape: tuple[int, ...], q: ArrayLike
    ) -> Array:
        return applied_to_rows(
            lambda row: function(_State(self._tree, row)), shape, q=(q, self.model.nq)
        )

    def _moving(
        self,
        function: Callable[[_State], Array],
        shape: tuple[int, ...],
        q: ArrayLike,
        v: ArrayLike,
    ) -> Array:
        return applied_to_rows(
            lambda q, v: function(_State(self._tree, q).moving(v)),
            shape,
            q=(q, self.model.nq),
            v=(v, self.model.nv),
        )

    def _found(self, positions: Array) -> Closed:
        """Return the closed configuration at one row of actuated positions."""
        found = self._from_home.closed(positions)
        self._limited.check(found.q[np.newaxis])
        return found

    def _closed(self, positions: Array, speeds: Array) -> _State:
        """Return the state there with actuated speeds."""
        found = self._found(positions)
        return _State.where_closed(self._tree, found).moving(found.complement @ speeds)

    # The thesis's quantities

    def constraint(self, q: ArrayLike) -> Array:
        r"""Return the constraints :math:`\phi(q)`, zero where the loops are closed (eq. 3.6).

        A 6D loop has six rows, the logarithm of the relative placement of its two frames. A 3D loop
        has three rows, their distance in axes of the first. The printed eq. 3.13 uses the Cayley
        form of each frame's rotation, which is singular at 180° and therefore already inaccurate
        near home; the logarithm of the *relative* rotation is not.

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
        return self._at(lambda state: state.constraint, (self._tree.rows,), q)

    def constraint_jacobian(self, q: ArrayLike) -> Array:
        r"""Return the constraint Jacobian :math:`\Phi = \partial\phi/\partial q` (eq. 3.19).

        It is also correct if the loops are open.

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
        return self._at(lambda state: state.jacobian, (self._tree.rows, self.model.nv), q)

    def configuration(self, positions: ArrayLike) -> Array:
        r"""Return the configurations that close the loops, by iteration from home (eq. 3.15).

        Newton's method on :meth:`constraint` with :meth:`constraint_jacobian`, in steps that keep
        the assembly mode of home, the robot's ``q0`` (for the 3-PSP :math:`q^u_0 = [0, \dots, 0, d,
        d, d]`: hinges straight, and arm lengths equal to the distance of the screws from the axis).

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
        # Home is checked first, so that a wrong one is also reported if there are no poses.
        _ = self._from_home
        return applied_to_rows(
            lambda row: self._found(row).q,
            (self.model.nq,),
            positions=(positions, self._actuated.size),
        )

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
        return self._at(lambda state: state.L, (self.model.nv, self._actuated.size), q)

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
        return self._moving(lambda state: state.L_dot, (self.model.nv, self._actuated.size), q, v)

    def K(self, q: ArrayLike) -> Array:
        r"""Return the twists of all bodies per unit of joint velocity (eq. 3.27–3.30).

        That is :math:`t_i = K_i \dot q`.

        Column j of :math:`K_i = [A_i; B_i]` is :math:`[e_j; e_j \times r_j]` for a revolute joint,
        with :math:`r_j` from the joint to the body's center of mass, and :math:`[0; e_j]` for a
        prismatic one, provided that the joint lies between the base and body i; otherwise it is
        zero. (Printed eq. 3.29 has 0 in both parts for a prismatic joint, and does not mention
        joints that do not move body i. Eq. 3.30 splits the rows of K instead of the columns.)

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
        return self._at(lambda state: state.K, (self._twist_rows, self.model.nv), q)

    def K_dot(self, q: ArrayLike, v: ArrayLike) -> Array:
        """Return the rate of K, of shape (..., 6 r, nv).

        Arguments and errors as in :meth:`L_dot`.
        """
        return self._moving(lambda state: state.K_dot, (self._twist_rows, self.model.nv), q, v)

    def T(self, q: ArrayLike) -> Array:
        r"""Return the natural orthogonal complement, :math:`t = T \dot q^a` (eq. 3.31).

        .. math:: T = K^a - K^u (\Phi^u)^{-1} \Phi^a = K L \qquad (3.33, 3.32)

        (Printed eq. 3.33 agrees only if :math:`K^a, K^u` are columns of K.)

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
        return self._at(lambda state: state.T, (self._twist_rows, self._actuated.size), q)

    def T_dot(self, q: ArrayLike, v: ArrayLike) -> Array:
        r"""Return the rate of T (eq. 3.35).

        .. math::

            \dot T = \dot K^a - \dot K^u (\Phi^u)^{-1} \Phi^a
            + K^u (\Phi^u)^{-1} \dot\Phi^u (\Phi^u)^{-1} \Phi^a
            - K^u (\Phi^u)^{-1} \dot\Phi^a

        (The printed equation has :math:`\dot\Phi^a` in the third term, but the derivative of the
        inverse gives :math:`\dot\Phi^u`.)

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
        return self._moving(
            lambda state: state.T_dot, (self._twist_rows, self._actuated.size), q, v
        )

    def M_total(self, q: ArrayLike) -> Array:
        r"""Return the block-diagonal mass matrix of the free bodies (eq. 3.36b).

        Its blocks are :math:`M_i = \operatorname{diag}(R I_i R^T, m_i 1)`.

        (The printed equation has :math:`I_i`, which is correct only in the body's own axes.)

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
        return self._at(
            lambda state: _block_diagonal(state.M_blocks), (self._twist_rows, self._twist_rows), q
        )

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
            rotate with the body.

        Raises
        ------
        InvalidArray, InconsistentVelocity, SingularConfiguration
            See :meth:`L_dot`.
        """
        return self._moving(
            lambda state: _block_diagonal(state.Omega_blocks),
            (self._twist_rows, self._twist_rows),
            q,
            v,
        )

    def w_g(self) -> Array:
        r"""Return the weights of the bodies as wrenches, :math:`w^g_i = [0; m_i g]` (eq. 3.36a).

        (The printed equation has :math:`+m_i g` along z; with :math:`G = -T^T w^g` it must point
        down.)

        Returns
        -------
        (6 r,) ndarray
            [N m] and [N], in world axes.
        """
        return self._tree.weights()

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
        return self._at(
            lambda state: state.closed().mass, (self._actuated.size, self._actuated.size), q
        )

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
        n = self._actuated.size
        return applied_to_rows(
            lambda q, v: _State(self._tree, q).closed().moving(v).coriolis,
            (n, n),
            q=(q, self.model.nq),
            v=(v, self.model.nv),
        )

    def gravity(self, q: ArrayLike) -> Array:
        r"""Return :math:`G = -T^T w^g` (eq. 3.4), of shape (..., n).

        Errors as in :meth:`mass_matrix`.
        """
        return self._at(lambda state: state.closed().gravity, (self._actuated.size,), q)

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
            state = _State(self._tree, q).closed().moving(v)
            return state.forces(v[self._actuated], accelerations)

        n = self._actuated.size
        return applied_to_rows(
            one, (n,), q=(q, self.model.nq), v=(v, self.model.nv), accelerations=(accelerations, n)
        )

    def equation_of_motion(
        self, positions: ArrayLike, speeds: ArrayLike
    ) -> tuple[Array, Array, Array]:
        """Return M, C and G at actuated positions and speeds.

        So a controller can use the thesis's model. Every call closes the loops again, see
        :meth:`configuration`.

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
        n = self._actuated.size

        def one(positions: Array, speeds: Array) -> Array:
            state = self._closed(positions, speeds)
            return np.concatenate([state.mass.ravel(), state.coriolis.ravel(), state.gravity])

        packed = applied_to_rows(
            one, (2 * n * n + n,), positions=(positions, n), speeds=(speeds, n)
        )
        square = (*packed.shape[:-1], n, n)
        return (
            packed[..., : n * n].reshape(square),
            packed[..., n * n : 2 * n * n].reshape(square),
            packed[..., 2 * n * n :],
        )

    def actuator_forces(
        self, positions: ArrayLike, speeds: ArrayLike, accelerations: ArrayLike
    ) -> Array:
        r"""Return the actuator forces of a motion of the actuated joints (eq. 3.1).

        .. math:: \tau = M(a)\, \ddot a + C(a, \dot a)\, \dot a + G(a)

        Parameters
        ----------
        positions, speeds, accelerations : (..., n) array_like
            Motion of the actuated joints, or of the coordinates if these are not the motors. Fewer
            accelerations are allowed as in :meth:`psp3.ClosedLoopRobot.actuator_forces`.

        Returns
        -------
        (..., n) ndarray
            Forces [N], or torques [N m] for hinges. If the motors are not the coordinates, these
            are the forces of the m motors with the least norm.

        Raises
        ------
        InvalidArray, ClosureFailed, JointLimitExceeded, SingularConfiguration
            See :meth:`equation_of_motion`.
        """
        if self._mechanism.drives_coordinates:
            return self._forces(positions, speeds, accelerations)
        L = self.L(self.configuration(positions))
        return forces_of_motors(
            np.swapaxes(L, -1, -2) @ self._mechanism.motors,
            lambda rates: self._forces(positions, speeds, rates),
            lambda: self.equation_of_motion(positions, speeds)[0],
            accelerations,
            self._mechanism.names,
        )

    def _forces(self, positions: ArrayLike, speeds: ArrayLike, accelerations: ArrayLike) -> Array:
        """Return the forces along the coordinates, (..., n)."""
        n = self._actuated.size

        def one(positions: Array, speeds: Array, accelerations: Array) -> Array:
            with np.errstate(over="ignore", invalid="ignore"):
                found = self._closed(positions, speeds).forces(speeds, accelerations)
            if not np.isfinite(found).all():
                raise NoFiniteAnswer(positions)
            return found

        return applied_to_rows(
            one,
            (n,),
            positions=(positions, n),
            speeds=(speeds, n),
            accelerations=(accelerations, n),
        )
