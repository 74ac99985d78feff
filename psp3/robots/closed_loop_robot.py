r"""Any robot that Pinocchio holds as a tree with loop closures, driven in its actuated coordinates.

The Pinocchio path.

The loops are Pinocchio constraint models. With :math:`\Phi` their Jacobian, split in the columns of
the actuated and the other joints, all joint velocities follow from the actuated ones (thesis
eq. 3.16–3.17),

.. math:: \dot q = L\, \dot q^a, \qquad
          L = \begin{bmatrix} 1 \\ -(\Phi^u)^{-1} \Phi^a \end{bmatrix},

and the tree's dynamics, from Pinocchio's RNEA and CRBA, is projected with :math:`L`. Nothing here
uses the closed form of the 3-PSP, the thesis's natural orthogonal complement or the projection of
:mod:`psp3.dynamics.projected`, so each of them checks the others, see
:meth:`ClosedLoopRobot.dynamics`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from psp3.checks import Array, applied_to_rows, finite_rows, one_row
from psp3.closure.assembly import assembled
from psp3.closure.kernels import SINGULAR, close, drift
from psp3.closure.mobility import mobility
from psp3.closure.passive_limits import PassiveLimits
from psp3.closure.rank import dependent_solver
from psp3.closure.table import NO_MOTORS, flattened
from psp3.description.urdf import read_robot
from psp3.dynamics.closed_pose import ClosedPose
from psp3.dynamics.dynamics_model import DynamicsModel
from psp3.dynamics.mechanism import check_order
from psp3.errors import (
    ClosureFailed,
    InvalidValue,
    MobilityMismatch,
    UnknownName,
)

DYNAMICS_MODELS = ("core", "pinocchio", "noc")
"""Names of the implementations of the equation of motion of any robot."""


class ClosedLoopRobot:
    """A robot given as a tree, loop closures and actuated joints.

    Arguments and results are in actuated coordinates.

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
        Reference configuration, from which other poses are reached; ``neutral`` by default. It need
        only nearly close the loops.
    visual_model : pinocchio.GeometryModel, optional
        What the robot looks like.

    Attributes
    ----------
    actuated_q, actuated_v, dependent_v : ndarray of int
        Places of the actuated joints in configurations and in joint velocities, and of the other
        joints in joint velocities.
    mobility : Mobility
        How many ways the mechanism can move, and how many of them its motors command.

    Raises
    ------
    ClosureFailed
        If the loops cannot be closed near the reference configuration.
    DisorderedJoints
        If the tree's joints are not chain by chain.
    MobilityMismatch
        If the number of actuated joints is not the number of degrees of freedom that the loops
        leave.
    """

    urdf: Path | None = None
    """The URDF it was loaded from, if it was; its collision shapes are read when they are asked
    for.
    """
    srdf: Path | None = None
    """The SRDF it was loaded with."""

    def __init__(
        self,
        model: pin.Model,
        constraint_models: Sequence[Any],
        actuated: Sequence[str],
        q0: ArrayLike | None = None,
        visual_model: Any = None,
    ) -> None:
        check_order(model)
        self.model = model
        self.data = model.createData()
        # Velocity forces are read off a copy without gravity: beside the weight they would lose
        # half their digits.
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
        self.actuated_q = np.array([joint.idx_q for joint in joints], dtype=np.int64)
        self.actuated_v = np.array([joint.idx_v for joint in joints], dtype=np.int64)
        self.dependent_v = np.setdiff1d(np.arange(model.nv), self.actuated_v)
        self._constraint_data = pin.StdVec_RigidConstraintData()
        self._dynamics_data = pin.StdVec_RigidConstraintData()
        for constraint in self.constraint_models:
            self._constraint_data.append(constraint.createData())
            # Constraint data must not be shared between algorithms of Pinocchio: results would be
            # silently wrong.
            self._dynamics_data.append(constraint.createData())
        self._limited = PassiveLimits(model, self.actuated)
        self._table = flattened(model, self.constraint_models, self.actuated_v)
        if q0 is None:
            start = assembled(
                model, flattened(model, self.constraint_models, NO_MOTORS), pin.neutral(model)
            )
        else:
            start = one_row("q0", q0, model.nq)
        self.mobility = mobility(model, self.constraint_models, self.actuated, start)
        if self.mobility.under_actuation or self.mobility.over_actuation:
            raise MobilityMismatch(self.mobility, self.actuated)
        self.q0: Array = self._close(start[self.actuated_q][np.newaxis], start)[0][0]

    @classmethod
    def from_urdf(
        cls, urdf: str | Path, loops: str | Path, srdf: str | Path | None = None
    ) -> ClosedLoopRobot:
        """Load a robot from a URDF and a loop file.

        Parameters
        ----------
        urdf : path
            The tree, with the frames that the loops join.
        loops : path
            The loop file, in the keys of :mod:`psp3.description.loop_file`.
        srdf : path, optional
            Reference poses; the pose ``home`` becomes ``q0``.

        Raises
        ------
        InvalidRobotFile
            If a file is missing or malformed, or a frame or joint it names does not exist.
        """
        robot = cls(*read_robot(urdf, loops, srdf))
        robot.urdf, robot.srdf = Path(urdf), None if srdf is None else Path(srdf)
        return robot

    @classmethod
    def from_mjcf(cls, mjcf: str | Path, actuated: Sequence[str] | None = None) -> ClosedLoopRobot:
        """Load a robot from an MJCF file whose loops are equality constraints.

        Parameters
        ----------
        mjcf : path
            The file; what it may hold is said in :func:`psp3.description.mjcf.read_mjcf`.
        actuated : sequence of str, optional
            Names of the actuated joints; those of the file's actuators by default.

        Raises
        ------
        InvalidRobotFile
            If the file is missing, malformed or holds something that cannot be read without
            changing the robot.
        """
        from psp3.description.mjcf import read_mjcf

        return cls(*read_mjcf(mjcf, actuated))

    @property
    def reference(self) -> Array:
        """Actuated positions of the reference configuration ``q0``, (n,) [m or rad]."""
        positions: Array = self.q0[self.actuated_q]
        return positions

    @property
    def title(self) -> str:
        """What the robot is called where it is shown."""
        return str(self.model.name)

    @property
    def limit_message(self) -> str:
        """What is said when an actuated joint is beyond its limits."""
        return "an actuated joint left its limits"

    @property
    def point_of_force(self) -> Array:
        """Where the force of a sliding motor is drawn, in the axes of its joint, (3,) [m]."""
        return np.zeros(3)

    @property
    def compiled_steps(self) -> Callable[[int, Any], Any] | None:
        """How to make a compiled plant from a number of steps and drives; None if there is none."""
        return None

    @property
    def limits(self) -> tuple[Array, Array]:
        """Lowest and highest positions of the actuated joints, each (n,) [m or rad]."""
        return self.model.lowerPositionLimit[self.actuated_q], self.model.upperPositionLimit[
            self.actuated_q
        ]

    def dynamics(self, name: str) -> DynamicsModel:
        """Return one of the implementations of the equation of motion.

        Each closes the loops in its own way. They share the tree and Pinocchio's joints, and no
        compiled function.

        Parameters
        ----------
        name : str
            ``"core"`` (this object), ``"pinocchio"`` (the tree's RNEA and CRBA projected, see
            :class:`psp3.dynamics.projected.ProjectedDynamics`) or ``"noc"`` (the thesis's natural
            orthogonal complement, eq. 3.2–3.4, see :class:`psp3.NaturalOrthogonalComplement`). The
            latter two close the loops by Newton's method from home (eq. 3.15), each on its own
            constraints.

        Raises
        ------
        UnknownName
            If there is no implementation of that name; the error lists the known ones.
        """
        if name == "core":
            return self
        if name == "pinocchio":
            from psp3.dynamics.projected import ProjectedDynamics

            return ProjectedDynamics(self)
        if name == "noc":
            from psp3.dynamics.natural_orthogonal_complement import NaturalOrthogonalComplement

            return NaturalOrthogonalComplement(self)
        raise UnknownName("dynamics model", name, DYNAMICS_MODELS)

    # Closing the loops

    def constraint_jacobian(self, q: Array) -> Array:
        """Return Pinocchio's constraint Jacobian, (m, nv).

        Minus the derivative of the residual where the loops are closed.
        """
        if not len(self.constraint_models):
            return np.zeros((0, self.model.nv))
        pin.computeJointJacobians(self.model, self.data, q)
        for constraint, data in zip(self.constraint_models, self._constraint_data, strict=True):
            # Without this call the Jacobian below is silently wrong.
            constraint.calc(self.model, self.data, data)
        jacobian: Array = pin.getConstraintsJacobian(
            self.model, self.data, self.constraint_models, self._constraint_data
        )
        return jacobian

    def _close(
        self, rows: Array, guess: Array, along: bool = False, complements: bool = False
    ) -> tuple[Array, Array]:
        """Return configurations, and on demand complements L, for actuated positions (N, n)."""
        nv, n = self.model.nv, len(self.actuated)
        configurations, report = np.empty((len(rows), self.model.nq)), np.empty(4)
        out = np.zeros((len(rows) if complements else 0, nv, n))
        if complements:
            out[:, self.actuated_v, np.arange(n)] = 1.0
        # Numba would compile the kernel anew for an array that is read-only.
        start = np.array(guess)
        failed = close(self._table, start, rows, along, configurations, out, report)
        if failed < 0:
            return configurations, out
        if report[0] == SINGULAR:
            # What is wrong is told by Pinocchio's Jacobian.
            self._dependent_inverse(configurations[failed])
        raise ClosureFailed(rows[failed], float(report[2]), float(report[1]))

    def _map(
        self, function: Callable[..., Array], shape: tuple[int, ...], **arguments: ArrayLike
    ) -> Array:
        """Apply a function of rows (n,) to arguments (..., n).

        Its result has the given shape.
        """
        width = len(self.actuated)
        return applied_to_rows(
            function, shape, **{name: (values, width) for name, values in arguments.items()}
        )

    def configuration(self, positions: ArrayLike, guess: ArrayLike | None = None) -> Array:
        """Return the configurations that close the loops at the given actuated positions.

        Newton's method with continuation from the reference pose, so the assembly mode is that of
        the reference.

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
        return self._configurations(positions, guess, along=False)

    def configurations_along(self, path: ArrayLike, guess: ArrayLike | None = None) -> Array:
        """Return the configurations along a path.

        Each is reached from the one before, so that the assembly mode is kept.

        Parameters
        ----------
        path : (N, n) array_like
            Positions of the actuated joints [m or rad], in the order of the path.
        guess : (nq,) array_like, optional
            Where the path is entered from; ``q0`` by default.

        Returns
        -------
        (N, nq) ndarray
            Pinocchio configurations.

        Raises
        ------
        InvalidArray, ClosureFailed, JointLimitExceeded
            See :meth:`configuration`.
        """
        return self._configurations(path, guess, along=True)

    def _configurations(self, positions: ArrayLike, guess: ArrayLike | None, along: bool) -> Array:
        rows = finite_rows("positions", positions, len(self.actuated))
        start = self.q0 if guess is None else one_row("guess", guess, self.model.nq)
        configurations, _ = self._close(rows.reshape(-1, len(self.actuated)), start, along)
        self._limited.check(configurations)
        shaped: Array = configurations.reshape(*rows.shape[:-1], self.model.nq)
        return shaped

    def closure(self, positions: ArrayLike) -> ClosedPose:
        """Return the closed configuration of one pose together with L.

        Parameters
        ----------
        positions : (n,) array_like
            Positions of the actuated joints [m or rad].

        Returns
        -------
        ClosedPose
            ``.configuration`` (nq,), ``.complement`` (nv, n) and ``.dependent_inverse`` (nv − n,
            m).

        Raises
        ------
        InvalidArray, ClosureFailed, JointLimitExceeded
            See :meth:`configuration`.
        SingularConfiguration
            If the actuated joints do not determine the others here.
        """
        row = one_row("positions", positions, len(self.actuated))
        configurations, complements = self._close(
            row[np.newaxis], self._start(row), complements=True
        )
        self._limited.check(configurations)
        return ClosedPose(configurations[0], complements[0], self._dependent_inverse)

    def _dependent_inverse(self, q: Array) -> Array:
        return dependent_solver(self.constraint_jacobian(q)[:, self.dependent_v])

    def _start(self, row: Array) -> Array:
        """Return the configuration from which the loops are closed."""
        return self.q0

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
        return self._map(
            lambda position, speed: self.closure(position).complement @ speed,
            (self.model.nv,),
            positions=positions,
            speeds=speeds,
        )

    # Projected dynamics

    def _at(self, position: Array) -> tuple[Array, Array]:
        closure = self.closure(position)
        return closure.configuration, closure.complement

    def drift(self, q: Array, v: Array) -> Array:
        r"""Return the joint accelerations, :math:`\dot L \dot q^a`.

        They hold while the actuated joints move uniformly.

        Parameters
        ----------
        q : (nq,) ndarray
            A closed configuration.
        v : (nv,) ndarray
            Joint velocities that keep the loops closed.

        Returns
        -------
        (nv,) ndarray
            Joint accelerations, zero for the actuated joints.

        Raises
        ------
        SingularConfiguration
            If the actuated joints do not determine the others here.
        """
        accelerations = np.zeros(self.model.nv)
        if not drift(self._table, q, v, accelerations):
            self._dependent_inverse(q)
        return accelerations

    def _velocity_forces(self, q: Array, complement: Array, speeds: Array) -> Array:
        """C(q, speeds) speeds by RNEA.

        It is the projected RNEA of the uniform motion of the actuated joints, without gravity.
        """
        v = complement @ speeds
        forces: Array = complement.T @ pin.rnea(self._weightless, self.data, q, v, self.drift(q, v))
        return forces

    def equation_of_motion(
        self, positions: ArrayLike, speeds: ArrayLike
    ) -> tuple[Array, Array, Array]:
        r"""Return mass matrix, Coriolis matrix and gravity in actuated coordinates.

        .. math:: M = L^T M_\text{tree} L, \qquad G = L^T g_\text{tree},

        and C as the unique matrix of Christoffel symbols: the quadratic form
        :math:`h(v) = C(v)\,v`, projected from RNEA, gives its columns by polarization,
        :math:`C(v) e_j = \tfrac12 [h(v + e_j) - h(v) - h(e_j)]`.

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
            q, complement = self._at(position)
            tree = pin.crba(self.model, self.data, q)
            tree = np.triu(tree) + np.triu(tree, 1).T
            mass = complement.T @ tree @ complement
            gravity = complement.T @ pin.computeGeneralizedGravity(self.model, self.data, q)
            coriolis = np.zeros((n, n))
            # The unit vectors are scaled to the speed: subtracting forms of very different size
            # would lose digits.
            scale = float(np.abs(speed).max(initial=0.0))
            if scale > 0.0:
                base = self._velocity_forces(q, complement, speed)
                for j, unit in enumerate(scale * np.eye(n)):
                    both = self._velocity_forces(q, complement, speed + unit)
                    alone = self._velocity_forces(q, complement, unit)
                    coriolis[:, j] = (both - base - alone) / (2.0 * scale)
            return np.concatenate([mass.ravel(), coriolis.ravel(), gravity])

        packed = self._map(one, (2 * n * n + n,), positions=positions, speeds=speeds)
        square = (*packed.shape[:-1], n, n)
        return (
            packed[..., : n * n].reshape(square),
            packed[..., n * n : 2 * n * n].reshape(square),
            packed[..., 2 * n * n :],
        )

    def mass_matrix(self, positions: ArrayLike) -> Array:
        """Return the mass matrix M, of shape (..., n, n); see :meth:`equation_of_motion`."""
        return self.equation_of_motion(positions, np.zeros(len(self.actuated)))[0]

    def coriolis_matrix(self, positions: ArrayLike, speeds: ArrayLike) -> Array:
        """Return the Coriolis matrix C, of shape (..., n, n); see :meth:`equation_of_motion`."""
        return self.equation_of_motion(positions, speeds)[1]

    def gravity(self, positions: ArrayLike) -> Array:
        """Return the gravity vector G, of shape (..., n); see :meth:`equation_of_motion`."""
        return self.equation_of_motion(positions, np.zeros(len(self.actuated)))[2]

    def inverse_dynamics(
        self, positions: ArrayLike, speeds: ArrayLike, accelerations: ArrayLike
    ) -> Array:
        r"""Return the actuator forces of a motion.

        They are :math:`\tau = L^T \operatorname{RNEA}(q, \dot q, \ddot q)`.

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
            q, complement = self._at(position)
            v = complement @ speed
            forces: Array = complement.T @ pin.rnea(
                self.model, self.data, q, v, complement @ acceleration + self.drift(q, v)
            )
            return forces

        return self._map(
            one,
            (len(self.actuated),),
            positions=positions,
            speeds=speeds,
            accelerations=accelerations,
        )

    def actuator_forces(
        self, positions: ArrayLike, speeds: ArrayLike, accelerations: ArrayLike
    ) -> Array:
        """Return the forces of the motors for a motion; see :meth:`inverse_dynamics`.

        The motors are as many as the coordinates, so that both are the same.
        """
        return self.inverse_dynamics(positions, speeds, accelerations)

    def constrained_accelerations(self, q: Array, v: Array, forces: Array) -> Array:
        """Return all joint accelerations of the tree under actuator forces.

        From Pinocchio's ``constraintDynamics``.

        Parameters
        ----------
        q : (nq,) ndarray
            Configuration. Where it leaves the loops a little open, the constraint models' Baumgarte
            gains close them again.
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
        tau[self.actuated_v] = forces
        # Redundant closures make the constraint inertia singular; the proximal iteration then
        # converges to the same motion.
        rows = sum(constraint.residualSize() for constraint in self.constraint_models)
        redundant = rows > self.model.nv - len(self.actuated)
        settings = pin.ProximalSettings(
            1e-12, 1e-12, 1e-6 if redundant else 0.0, 50 if redundant else 1
        )
        pin.initConstraintDynamics(
            self.model, self.data, self.constraint_models, self._dynamics_data
        )
        acceleration = pin.constraintDynamics(
            self.model, self.data, q, v, tau, self.constraint_models, self._dynamics_data, settings
        )
        return np.array(acceleration)

    def forward_dynamics(self, positions: ArrayLike, speeds: ArrayLike, forces: ArrayLike) -> Array:
        """Return the accelerations of the actuated joints under actuator forces.

        From Pinocchio's ``constraintDynamics``.

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
            q, complement = self._at(position)
            accelerations: Array = self.constrained_accelerations(q, complement @ speed, force)[
                self.actuated_v
            ]
            return accelerations

        return self._map(
            one, (len(self.actuated),), positions=positions, speeds=speeds, forces=forces
        )

    def frame_jacobian(self, positions: ArrayLike, frame: str) -> Array:
        """Return the Jacobian of a frame by the actuated coordinates.

        In base axes at the frame's origin.

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
        index = self._frame(frame)

        def one(position: Array) -> Array:
            q, complement = self._at(position)
            pin.computeJointJacobians(self.model, self.data, q)
            pin.updateFramePlacements(self.model, self.data)
            jacobian = pin.getFrameJacobian(
                self.model, self.data, index, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
            )
            # Of a model with a single degree of freedom Pinocchio returns a vector.
            return np.asarray(jacobian.reshape(6, self.model.nv) @ complement)

        return self._map(one, (6, len(self.actuated)), positions=positions)

    def frame_placement(self, positions: ArrayLike, frame: str) -> Array:
        """Return the placement of a frame in base axes.

        Parameters
        ----------
        positions : (..., n) array_like
            Actuated positions.
        frame : str
            Name of a frame of the model.

        Returns
        -------
        (..., 4, 4) ndarray
            Homogeneous transforms: rotation, and position [m].

        Raises
        ------
        UnknownName
            If the model has no such frame.
        InvalidArray, ClosureFailed, JointLimitExceeded
            See :meth:`configuration`.
        """
        index = self._frame(frame)
        configurations = self.configuration(positions)

        def one(q: Array) -> Array:
            pin.forwardKinematics(self.model, self.data, q)
            placement: Array = pin.updateFramePlacement(self.model, self.data, index).homogeneous
            return placement

        rows = [one(q) for q in configurations.reshape(-1, self.model.nq)]
        return np.array(rows).reshape(*configurations.shape[:-1], 4, 4)

    def position_jacobian(self, positions: ArrayLike, frame: str) -> Array:
        """Return the Jacobian of a frame's origin, (..., 3, n).

        These are the upper rows of :meth:`frame_jacobian`, whose arguments it takes.
        """
        return self.frame_jacobian(positions, frame)[..., :3, :]

    def tip(self, positions: ArrayLike) -> Array:
        """Return the origin of the frame ``tip`` in base axes, (..., 3) [m]; NaN without one.

        Parameters
        ----------
        positions : (..., n) array_like
            Actuated positions.

        Raises
        ------
        InvalidArray, ClosureFailed, JointLimitExceeded
            See :meth:`configuration`; also of a robot without a tip.
        """
        if self.model.existFrame("tip"):
            return self.frame_placement(positions, "tip")[..., :3, 3]
        configurations = self.configuration(positions)
        return np.full((*configurations.shape[:-1], 3), np.nan)

    has_inverse_of_tip = False
    """Whether :meth:`motion_of_tip` can be asked for: actuated positions of a path of the tip."""

    def motion_of_tip(
        self, point: Array, velocity: Array, acceleration: Array
    ) -> tuple[Array, Array, Array]:
        """Return actuated positions, speeds and accelerations for a motion of the tip.

        Parameters
        ----------
        point, velocity, acceleration : (..., 3) ndarray
            Motion of the tip in base axes [m], [m/s], [m/s²].

        Raises
        ------
        InvalidValue
            If the robot has no inverse kinematics of its tip.
        """
        raise InvalidValue(
            "robot",
            self.title,
            "one with an inverse kinematics of its tip, as the 3-PSP has; give a path of the "
            "joints",
        )

    def _frame(self, frame: str) -> int:
        if not self.model.existFrame(frame):
            raise UnknownName("frame", frame, [known.name for known in self.model.frames])
        return int(self.model.getFrameId(frame))

    def kinetic_energy(self, positions: ArrayLike, speeds: ArrayLike) -> Array:
        """Return the kinetic energy [J], of shape (...,)."""

        def one(position: Array, speed: Array) -> Array:
            q, complement = self._at(position)
            return np.asarray(
                pin.computeKineticEnergy(self.model, self.data, q, complement @ speed)
            )

        return self._map(one, (), positions=positions, speeds=speeds)

    def potential_energy(self, positions: ArrayLike) -> Array:
        """Return the potential energy in the field of gravity [J], of shape (...,).

        Zero with all masses at the base's height.
        """

        def one(position: Array) -> Array:
            return np.asarray(
                pin.computePotentialEnergy(self.model, self.data, self.configuration(position))
            )

        return self._map(one, (), positions=positions)
