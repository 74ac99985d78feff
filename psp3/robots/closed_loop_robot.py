r"""Any robot that is a Pinocchio tree with loop closures, driven in its actuated coordinates.

The loops are Pinocchio constraint models. With :math:`\Phi` their Jacobian, split in the columns of
the actuated and the other joints, all joint velocities follow from the actuated ones (thesis
eq. 3.16–3.17),

.. math:: \dot q = L\, \dot q^a, \qquad
          L = \begin{bmatrix} 1 \\ -(\Phi^u)^{-1} \Phi^a \end{bmatrix},

and the compiled core of :mod:`psp3.multibody` projects the tree's dynamics with :math:`L`. This
module does not use the closed form of the 3-PSP, the thesis's natural orthogonal complement or the
projection of :mod:`psp3.dynamics.projected`, so they can be compared with each other, see
:meth:`ClosedLoopRobot.dynamics`.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from fuzzy2.support.described import Described
from fuzzy2.support.logs import logger_named
from psp3.checks import (
    Array,
    checked_kind,
    checked_names,
    checked_path,
    finite_array,
    finite_rows,
    one_row,
    together,
)
from psp3.closure.passive_limits import PassiveLimits
from psp3.closure.rank import dependent_solver, null_space
from psp3.closure.structure import Structure
from psp3.description.urdf import read_robot
from psp3.drives.drive import Drive, drive_table
from psp3.dynamics.closed_pose import ClosedPose
from psp3.dynamics.derivatives import ForwardDynamicsDerivatives, InverseDynamicsDerivatives
from psp3.dynamics.dynamics_model import DynamicsModel
from psp3.dynamics.motors import Driven, Motors, forces_of_motors, least_norm
from psp3.errors import (
    ClosureFailed,
    InvalidArray,
    InvalidValue,
    JointLimitExceeded,
    NoFiniteAnswer,
    SingularConfiguration,
    UnknownName,
)
from psp3.multibody.closing import SINGULAR
from psp3.multibody.core import Core, LastPose, NoAnswer
from psp3.multibody.equations import Hinge
from psp3.multibody.flatten import Springs
from psp3.multibody.motion import (
    BEYOND_LIMIT,
    COMPLEMENT,
    CONFIGURATION,
    ENERGIES,
    EQUATION_OF_MOTION,
    FORWARD_DERIVATIVES,
    FORWARD_DYNAMICS,
    FRAME,
    INVERSE_DERIVATIVES,
    INVERSE_DYNAMICS,
    MOTION,
    NOT_FINITE,
)
from psp3.multibody.named_frames import frame_number
from psp3.robots.assembly import Assembly, assembled
from psp3.robots.construction import check_parts, named_closures
from psp3.robots.implementations import DYNAMICS_MODELS as DYNAMICS_MODELS
from psp3.robots.implementations import implementation
from psp3.robots.inertias import check_model, warning_of_inertias
from psp3.robots.learning_inputs import LearningInputs, positions_and_speeds
from psp3.robots.loop_forces import ClosureForces, forces_of_motion
from psp3.robots.mismatch import ClosureMismatch, allowance, findings_of_loops, warnings_of
from psp3.robots.pickling import constraints, plain
from psp3.robots.simple_joints import SimpleTree

FREE = ("lock", "keep", "refuse")
"""The options for motions that no motor commands."""

PRELOAD_TOLERANCE = 1e-7
"""Singular values of the actuation matrix up to this share of the largest one count as zero."""

logger = logger_named(__name__)


class ClosedLoopRobot(Described):
    """A robot that is given as a tree, loop closures and actuated joints.

    Arguments and results are in actuated coordinates.

    Methods for frames and their Jacobians may run in one thread at a time, because Pinocchio uses a
    single ``data``; all other methods are thread-safe. A robot can be pickled and copied.

    The gravity of ``model`` may be changed at any time. Other numbers are read when the robot is
    constructed, and later changes would affect only some results: change the model first, then
    construct the robot.

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
        The shapes of the robot.
    equations : sequence of Hinge or Coupling
        Closures for which Pinocchio has no model.
    springs : mapping of str to (float, float), optional
        Stiffness and rest of joints of one degree of freedom [N/m, m or N m, rad].
    tendons : mapping of str to mapping, optional
        Motors that drive several joints: maps a name in ``actuated`` to the lever arm of each
        joint, by the joint's name.
    closures : sequence of (str, str, str)
        Additional closures: two frames and ``"3d"``, ``"6d"`` or ``"hinge"`` (origin and z axis).
        With ``"world"`` as the second frame, the first frame stays at its place in the reference
        configuration, like a foot on the ground.
    free : {"lock", "keep", "refuse"}
        Treatment of motions that no motor commands. ``"lock"`` holds one joint at its position in
        the reference configuration, keeps its inertia, and names it in a warning and in ``locked``.
        ``"keep"`` makes that joint a coordinate in addition to the motors. ``"refuse"`` raises
        :class:`MobilityMismatch`. :mod:`psp3.closure.coordinates` describes how the joint is
        chosen. A floating base is always kept. Hinges replace a ball joint whose spin becomes a
        coordinate, and slides and hinges replace a base in a loop that keeps some of its motions
        (:mod:`psp3.robots.simple_joints`). The model then differs from the given one.
    coordinates : sequence of str, optional
        Joints that are the first coordinates; by default the motors.

    Attributes
    ----------
    actuated_q, actuated_v, dependent_v : ndarray of int
        Places of the actuated joints in configurations and in joint velocities, and places in joint
        velocities of the dependent joints.
    coordinates : tuple of str
        Joints whose positions, speeds and forces all functions take and return; the motors if their
        number is that of the degrees of freedom. Positions have the form of a configuration, and
        speeds and forces that of a velocity: a floating base, which comes last, has 7 positions and
        6 speeds.
    locked : tuple of Locked
        Free motions that are held.
    without_limits : tuple of Beyond
        Joints that are outside their range in the reference pose, because the pose was given or no
        closed pose within all ranges was found. The exceeded limit is removed.
    mobility : Mobility
        Degrees of freedom of the mechanism, and how many of them its motors command.
    closure_mismatch : ClosureMismatch
        How far the loops contradict themselves because of rounded numbers.
    loop_findings : tuple of Finding
        What is doubtful about the loops, with remedies; it is also logged.

    Raises
    ------
    ClosureFailed
        If the loops cannot be closed near the reference configuration.
    RoundedLoops
        If redundant loops contradict themselves by more than rounding, or allow no motion.
    MobilityMismatch
        If nothing can move, or the motors leave free motions and ``free="refuse"``.
    """

    urdf: Path | None = None
    """The URDF it was loaded from, if any; its collision shapes are read on demand."""
    srdf: Path | None = None
    """The SRDF it was loaded with."""
    mjcf: Path | None = None
    """The MJCF file it was loaded from, if any."""

    def __init__(
        self,
        model: pin.Model,
        constraint_models: Sequence[Any],
        actuated: Sequence[str],
        q0: ArrayLike | None = None,
        visual_model: Any = None,
        equations: Sequence[Any] = (),
        springs: Springs | None = None,
        tendons: Mapping[str, Mapping[str, float]] | None = None,
        *,
        closures: Sequence[tuple[str, str, str]] = (),
        free: str = "lock",
        coordinates: Sequence[str] | None = None,
    ) -> None:
        if not isinstance(free, str) or free not in FREE:
            raise UnknownName("treatment of free motions", free, FREE)
        self.options: dict[str, Any] = {
            "equations": tuple(equations) if isinstance(equations, Sequence) else equations,
            "springs": springs,
            "tendons": tendons,
            "free": free,
            "coordinates": coordinates,
        }
        if coordinates is not None:
            self.options["coordinates"] = checked_names("coordinates", coordinates)
        check_parts(model, constraint_models, visual_model, self.options, closures)
        self.actuated = checked_names("actuated", actuated)
        check_model(model)
        twice = [name for name in self.actuated if self.actuated.count(name) > 1]
        if twice:
            raise InvalidValue(
                "actuated", self.actuated, f"each joint once, not {twice[0]!r} twice"
            )
        home = None if q0 is None else one_row("q0", q0, model.nq)
        more = named_closures(model, closures, home)
        loops = [*constraint_models, *(one for one in more if not isinstance(one, Hinge))]
        others = [*equations, *(one for one in more if isinstance(one, Hinge))]
        shapes = visual_model if visual_model is not None else pin.GeometryModel()
        tree = SimpleTree(model, shapes, loops, others, home)
        try:
            with np.errstate(over="ignore", invalid="ignore"):  # of a home with invalid numbers
                made = assembled(tree, self.actuated, self.options)
        except np.linalg.LinAlgError as error:
            raise InvalidValue("q0", tree.home, "a configuration of valid numbers") from error
        self._take(made)

    def _take(self, made: Assembly) -> None:
        """Set a tree whose coordinates are chosen, and close its loops."""
        tree, chosen = made.tree, made.chosen
        model = self.model = tree.model
        self.visual_model = tree.visual_model
        self.constraint_models = pin.StdVec_RigidConstraintModel()
        self.constraint_models.extend(tree.constraint_models)
        self.equations = self.options["equations"] = tuple(tree.equations)
        self._create_data()
        self.motors, self.mobility, self.without_limits = (
            made.motors,
            made.mobility,
            made.without_limits,
        )
        tendons = self.options["tendons"] or {}
        driven = [name for name in self.actuated if name not in tendons]
        joints = [model.joints[model.getJointId(name)] for name in driven]
        self.actuated_q = np.array([joint.idx_q for joint in joints], dtype=np.int64)
        self.actuated_v = np.array([joint.idx_v for joint in joints], dtype=np.int64)
        self.coordinates, self.locked = chosen.names, chosen.locked
        self.coordinates_q, self.coordinates_v = chosen.positions, chosen.speeds
        self._position_count, self._speed_count = len(chosen.positions), len(chosen.speeds)
        self.dependent_v, self._held = made.dependent, chosen.held
        self._limited = PassiveLimits(model, chosen.names)
        self._core = self._settled(made.given, made.found)
        self.q0: Array = self._core.q0
        moved = float(np.abs(pin.difference(model, made.given, self.q0)).max(initial=0.0))
        self.closure_mismatch = ClosureMismatch(made.found.length, made.found.angle, moved)
        worst = made.names[made.found.worst] if made.names else ""
        self.loop_findings = findings_of_loops(model, worst, made.found, moved)
        for one in (*warnings_of(self), warning_of_inertias(model)):
            if one:
                logger.warning("%s", one)

    def _settled(self, guess: Array, found: Structure) -> Core:
        """Return the core at a closed pose with the coordinates of the guess.

        If these coordinates cannot be kept, the pose is the one that closes the loops best.
        """
        mismatch, weakest = allowance(found)

        def core(start: Array) -> Core:
            return Core(
                self.model,
                self._all_closures(),
                self.coordinates_v,
                start,
                self._held,
                self.options["springs"],
                mismatch,
                weakest,
            )

        try:
            return core(guess)
        except NoAnswer as failed:
            refused = self._refused(failed, guess[self.coordinates_q][np.newaxis])
        try:
            return core(found.home)
        except NoAnswer:
            raise refused from None

    def _all_closures(self) -> list[Any]:
        """Return all closures of the tree: loops, other equations, and held spins of balls."""
        spins = [one.spin for one in self.locked if one.spin is not None]
        return [*self.constraint_models, *self.equations, *spins]

    def _create_data(self) -> None:
        """Create Pinocchio's data."""
        self.data = self.model.createData()
        self._constraint_data = pin.StdVec_RigidConstraintData()
        for constraint in self.constraint_models:
            self._constraint_data.append(constraint.createData())

    def __getstate__(self) -> dict[str, Any]:
        # Pinocchio can pickle neither constraints nor their data.
        state = {**self.__dict__, "constraint_models": plain(self.constraint_models)}
        for made in ("data", "_constraint_data"):
            del state[made]
        return state

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.constraint_models = constraints(self.model, state["constraint_models"])
        self._create_data()

    @classmethod
    def from_urdf(
        cls,
        urdf: str | Path,
        loops: str | Path | None = None,
        srdf: str | Path | None = None,
        *,
        actuated: Sequence[str] | None = None,
        free: str = "lock",
        coordinates: Sequence[str] | None = None,
        closures: Sequence[tuple[str, str, str]] = (),
    ) -> ClosedLoopRobot:
        """Load a robot from a URDF, with or without a loop file.

        Parameters
        ----------
        urdf : path
            The URDF file, with the frames that the loops join.
        loops : path, optional
            The loop file, see :mod:`psp3.description.loop_file`. Without one, frames
            ``closing_<name>_1`` and ``closing_<name>_2`` are joined, see
            :mod:`psp3.description.closing_frames`; a URDF without such frames is a tree.
        srdf : path, optional
            Reference poses; the pose ``home`` becomes ``q0``.
        actuated : sequence of str, optional
            Names of the motors. The default is those of the loop file; for a tree, all joints of
            one degree of freedom that do not mimic another.
        free, coordinates, closures
            See the class.

        Raises
        ------
        InvalidRobotFile
            If a file is missing or malformed, or names a frame or joint that does not exist.
        InvalidValue
            If a robot has loops, but neither a loop file nor ``actuated``.
        """
        checked_path("urdf", urdf)
        for name, path in (("loops", loops), ("srdf", srdf)):
            if path is not None:
                checked_path(name, path)
        if actuated is not None:
            actuated = checked_names("actuated", actuated)
        checked_kind("closures", closures, (list, tuple), "a list of two frames and a kind each")
        parts = read_robot(urdf, loops, srdf, actuated, closures)
        robot = cls(*parts, free=free, coordinates=coordinates, closures=closures)
        robot.urdf, robot.srdf = Path(urdf), None if srdf is None else Path(srdf)
        return robot

    @classmethod
    def from_mjcf(
        cls,
        mjcf: str | Path,
        actuated: Sequence[str] | None = None,
        *,
        joint_type: Mapping[str, str] | None = None,
        free: str = "lock",
        coordinates: Sequence[str] | None = None,
        closures: Sequence[tuple[str, str, str]] = (),
    ) -> ClosedLoopRobot:
        """Load a robot from an MJCF file whose loops are equality constraints.

        Parameters
        ----------
        mjcf : path
            The file; :func:`psp3.description.mjcf.read_mjcf` describes its allowed contents.
        actuated : sequence of str, optional
            Names of the actuated joints; those of the file's actuators by default.
        joint_type : mapping of str to str, optional
            Joint types that hinges stand for: maps a joint's name to ``"SPHERICAL"``,
            ``"UJOINT_XY"`` and the like, or ``"FIXED"``, as in a loop file
            (:mod:`psp3.description.joint_replacement`).
        free, coordinates, closures
            See the class.

        Raises
        ------
        InvalidRobotFile
            If the file is missing, malformed or holds something that cannot be read without
            changing the robot.
        """
        from psp3.description.mjcf import read_mjcf

        checked_path("mjcf", mjcf)
        if actuated is not None:
            actuated = checked_names("actuated", actuated)
        if joint_type is not None:
            checked_kind("joint_type", joint_type, Mapping, "a mapping of joints to their types")
        parts = read_mjcf(mjcf, actuated, joint_type)
        robot = cls(*parts, free=free, coordinates=coordinates, closures=closures)
        robot.mjcf = Path(mjcf)
        return robot

    @classmethod
    def from_sdf(
        cls,
        sdf: str | Path,
        actuated: Sequence[str] | None = None,
        *,
        model_paths: Sequence[str | Path] = (),
        free: str = "lock",
        coordinates: Sequence[str] | None = None,
        closures: Sequence[tuple[str, str, str]] = (),
    ) -> ClosedLoopRobot:
        """Load a robot from an SDF file, in which joints may close loops.

        Parameters
        ----------
        sdf : path
            The file; :func:`psp3.description.sdf.read_sdf` describes its allowed contents.
        actuated : sequence of str
            Names of the actuated joints, which an SDF file does not state.
        model_paths : sequence of path, optional
            Folders from which models may be included, in addition to the folder of the file.
        free, coordinates, closures
            See the class.

        Raises
        ------
        InvalidRobotFile
            If the file is missing, malformed, holds something that cannot be read without changing
            the robot, or no joint is named as actuated.
        """
        from psp3.description.sdf import read_sdf

        checked_path("sdf", sdf)
        if actuated is not None:
            actuated = checked_names("actuated", actuated)
        checked_kind("model_paths", model_paths, (list, tuple), "a list of folders")
        for folder in model_paths:
            checked_path("model_paths", folder)
        return cls(
            *read_sdf(sdf, actuated, model_paths),
            free=free,
            coordinates=coordinates,
            closures=closures,
        )

    @property
    def reference(self) -> Array:
        """Positions of the coordinates in the reference configuration ``q0``, (p,) [m or rad]."""
        positions: Array = self.q0[self.coordinates_q]
        return positions

    def _facts(self) -> dict[str, Any]:
        return {
            "name": self.title,
            "degrees_of_freedom": len(self.coordinates_v),
            "motors": self.actuated,
            "loops": len(self.constraint_models) + len(self.equations),
        }

    @property
    def title(self) -> str:
        """Name of the robot in titles."""
        return str(self.model.name)

    @property
    def limit_message(self) -> str:
        """The message when an actuated joint is beyond its limits."""
        return "an actuated joint left its limits"

    @property
    def point_of_force(self) -> Array:
        """Where the force of a sliding motor is drawn, in the axes of its joint, (3,) [m]."""
        return np.zeros(3)

    @property
    def compiled_steps(self) -> Callable[[int, Any], Any]:
        """Function that creates a compiled plant from a number of steps and drives."""
        from psp3.robots.stepping import CoreSteps

        return functools.partial(CoreSteps, self._core, self._motors)

    def compiled_table(self) -> NamedTuple | None:
        """Return the robot's table for compiled loops; None if a subclass changes its dynamics."""
        from psp3.robots.stepping import tables_of_motors

        if type(self) is not ClosedLoopRobot:
            return None
        if self.drives_coordinates:
            return self._core.tables()
        return tables_of_motors(self._core, self._motors)

    @property
    def learning_inputs(self) -> LearningInputs:
        """The inputs of M, C and G: positions, and for C also speeds."""
        return positions_and_speeds(self.coordinates)

    @property
    def limits(self) -> tuple[Array, Array]:
        """Lowest and highest positions of the coordinates, each (p,) [m or rad].

        A floating base has no limits; Pinocchio's are those of its quaternion.
        """
        lower = self.model.lowerPositionLimit[self.coordinates_q]
        upper = self.model.upperPositionLimit[self.coordinates_q]
        joints = self._position_count - self._motors.base_coordinates
        lower[joints:], upper[joints:] = -np.inf, np.inf
        return lower, upper

    def dynamics(self, name: str) -> DynamicsModel:
        """Return one of the implementations of the equation of motion.

        Each closes the loops in its own way. They share the tree and Pinocchio's joints, but no
        compiled function.

        Parameters
        ----------
        name : str
            ``"core"`` (this object), ``"pinocchio"`` (the tree's RNEA and CRBA projected, see
            :class:`psp3.dynamics.projected.ProjectedDynamics`) or ``"noc"`` (the thesis's natural
            orthogonal complement, eq. 3.2–3.4, see :class:`psp3.NaturalOrthogonalComplement`). The
            latter two close the loops with Newton's method from home (eq. 3.15), each with its own
            constraints. All have ``equation_of_motion`` and ``actuator_forces`` of actuated
            positions and speeds; the other methods of ``"noc"`` take q and v of all joints.

        Raises
        ------
        UnknownName
            If there is no implementation of that name; the error lists the known ones.
        InvalidValue
            If ``"noc"`` does not cover a part of the robot.
        """
        return implementation(self, name)

    @property
    def springs(self) -> Springs:
        """Stiffness and rest of joints, by name [N/m, m or N m, rad]."""
        return self.options["springs"] or {}

    # Closing the loops

    def constraint_jacobian(self, q: ArrayLike) -> Array:
        """Return Pinocchio's constraint Jacobian, (m, nv).

        If the loops are closed, it is minus the derivative of the residual.
        """
        q = one_row("q", q, self.model.nq)
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

    @property
    def core(self) -> Core:
        """The compiled core: the tree with its loops as flat arrays."""
        return self._core

    def last_pose(self) -> LastPose | None:
        """Return a memory of the caller's last pose.

        If it is the ``guess``, the loops are closed from that pose, which is faster if the robot
        moves little between two calls. It belongs to one thread at a time.
        """
        return self._core.last_pose()

    def _refused(self, failed: NoAnswer, positions: Array) -> Exception:
        """Return the error that explains why a row of positions (N, n) has no answer."""
        try:
            if failed.outcome == BEYOND_LIMIT:
                self._limited.check(failed.q[np.newaxis])
            if failed.outcome == SINGULAR:
                # Pinocchio's Jacobian shows the cause.
                self._dependent_inverse(failed.q)
                if self._has_mass_matrix(positions[failed.row]):
                    return NoFiniteAnswer(positions[failed.row])
        except (JointLimitExceeded, SingularConfiguration) as error:
            return error
        if failed.outcome == NOT_FINITE:
            return NoFiniteAnswer(positions[failed.row])
        return ClosureFailed(positions[failed.row], failed.residual, failed.share)

    def _has_mass_matrix(self, positions: Array) -> bool:
        """Tell whether there is a mass matrix, so that only it can be singular."""
        rest = np.zeros((1, self._speed_count))
        out = np.empty((1, 2 * rest.size**2 + rest.size))
        try:
            self._core.ask(EQUATION_OF_MOTION, positions[np.newaxis], rest, rest, out, None)
        except NoAnswer:
            return False
        return True

    def _ask(
        self,
        question: int,
        width: int,
        guess: ArrayLike | LastPose | None,
        positions: ArrayLike,
        speeds: ArrayLike,
        third: ArrayLike,
        name_of_third: str = "accelerations",
    ) -> Array:
        """Return the answers of the core, (..., width), for arguments (..., n).

        For an argument that a question does not need, any other argument may be given.
        """
        plain = type(positions) is type(speeds) is type(third) is np.ndarray
        if plain and (guess is None or type(guess) is LastPose):
            # For one state, as in control loops: the kernels check everything that is necessary.
            out = np.empty(width)
            try:
                if self._core.ask_one(question, positions, speeds, third, out, guess):
                    return out
            except TypeError:  # many states, numbers of another kind
                pass
        p, n = self._position_count, self._speed_count
        arrays = together(
            **{
                name: finite_rows(name, value, count)
                for name, value, count in (
                    ("positions", positions, p),
                    ("speeds", speeds, n),
                    (name_of_third, third, n),
                )
            }
        )
        shape, rows = arrays[0].shape[:-1], [array.reshape(-1, array.shape[-1]) for array in arrays]
        if guess is not None and not isinstance(guess, LastPose):
            guess = np.array(one_row("guess", guess, self.model.nq))
        out = np.empty((len(rows[0]), width))
        try:
            self._core.ask(question, rows[0], rows[1], rows[2], out, guess)
        except NoAnswer as failed:
            raise self._refused(failed, rows[0]) from None
        return out.reshape(*shape, width)

    def configuration(
        self, positions: ArrayLike, guess: ArrayLike | LastPose | None = None
    ) -> Array:
        """Return the configurations that close the loops at the given actuated positions.

        Newton's method with continuation starts from the reference pose, so the assembly mode is
        that of the reference.

        Parameters
        ----------
        positions : (..., n) array_like
            Positions of the actuated joints [m or rad].
        guess : (nq,) array_like or LastPose, optional
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
        same = self._position_count == self._speed_count
        rest = positions if same else np.zeros(self._speed_count)
        return self._ask(CONFIGURATION, self.model.nq, guess, positions, rest, rest)

    def configurations_along(self, path: ArrayLike, guess: ArrayLike | None = None) -> Array:
        """Return the configurations along a path.

        Each is reached from the preceding one, so the assembly mode is kept.

        Parameters
        ----------
        path : (N, n) array_like
            Positions of the actuated joints [m or rad], in the order of the path.
        guess : (nq,) array_like, optional
            Configuration from which the first pose is reached; ``q0`` by default.

        Returns
        -------
        (N, nq) ndarray
            Pinocchio configurations.

        Raises
        ------
        InvalidArray, ClosureFailed, JointLimitExceeded
            See :meth:`configuration`.
        """
        rows = finite_rows("positions", path, self._position_count).reshape(
            -1, self._position_count
        )
        start = None if guess is None else np.array(one_row("guess", guess, self.model.nq))
        out = np.empty((len(rows), self.model.nq))
        try:
            rest = np.zeros((len(rows), self._speed_count))
            self._core.ask(CONFIGURATION, rows, rest, rest, out, start, is_path=True)
        except NoAnswer as failed:
            raise self._refused(failed, rows) from None
        return out.reshape(*np.shape(path)[:-1], self.model.nq)

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
        row = one_row("positions", positions, self._position_count)
        nq, n = self.model.nq, self._speed_count
        rest = np.zeros(n)
        both = self._ask(COMPLEMENT, nq + self.model.nv * n, None, row, rest, rest)
        complement = np.ascontiguousarray(both[nq:].reshape(n, self.model.nv).T)
        return ClosedPose(both[:nq].copy(), complement, self._dependent_inverse)

    def _dependent_inverse(self, q: Array) -> Array:
        return dependent_solver(self.constraint_jacobian(q)[:, self.dependent_v])

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
        nq, nv = self.model.nq, self.model.nv
        rest = np.zeros(self._speed_count)
        motion = self._ask(MOTION, nq + 2 * nv, None, positions, speeds, rest)
        return motion[..., nq : nq + nv]

    # Projected dynamics

    def drift(self, q: ArrayLike, v: ArrayLike) -> Array:
        r"""Return the joint accelerations, :math:`\dot L \dot q^a`.

        They are those at constant speeds of the actuated joints.

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
        nq, nv = self.model.nq, self.model.nv
        q, v = one_row("q", q, nq), one_row("v", v, nv)
        motion = self._ask(
            MOTION,
            nq + 2 * nv,
            q,
            q[self.coordinates_q],
            v[self.coordinates_v],
            np.zeros(self._speed_count),
        )
        return motion[nq + nv :]

    def equation_of_motion(
        self,
        positions: ArrayLike,
        speeds: ArrayLike,
        guess: ArrayLike | LastPose | None = None,
    ) -> tuple[Array, Array, Array]:
        r"""Return mass matrix, Coriolis matrix and gravity in actuated coordinates.

        .. math:: M = L^T M_\text{tree} L, \qquad G = L^T g_\text{tree},

        and C as the unique matrix of Christoffel symbols, see :mod:`psp3.multibody.inertia`.

        Parameters
        ----------
        positions, speeds : (..., n) array_like
            Actuated positions and speeds [m, m/s or rad, rad/s].
        guess : (nq,) array_like or LastPose, optional
            Where closing the loops starts; ``q0`` by default.

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
        n = self._speed_count
        packed = self._ask(EQUATION_OF_MOTION, 2 * n * n + n, guess, positions, speeds, speeds)
        square = (*packed.shape[:-1], n, n)
        return (
            packed[..., : n * n].reshape(square),
            packed[..., n * n : 2 * n * n].reshape(square),
            packed[..., 2 * n * n :],
        )

    def mass_matrix(self, positions: ArrayLike, guess: ArrayLike | LastPose | None = None) -> Array:
        """Return the mass matrix M, of shape (..., n, n); see :meth:`equation_of_motion`."""
        return self.equation_of_motion(positions, np.zeros(self._speed_count), guess)[0]

    def coriolis_matrix(self, positions: ArrayLike, speeds: ArrayLike) -> Array:
        """Return the Coriolis matrix C, of shape (..., n, n); see :meth:`equation_of_motion`."""
        return self.equation_of_motion(positions, speeds)[1]

    def gravity(self, positions: ArrayLike) -> Array:
        """Return the gravity vector G, of shape (..., n); see :meth:`equation_of_motion`."""
        return self.equation_of_motion(positions, np.zeros(self._speed_count))[2]

    def inverse_dynamics(
        self,
        positions: ArrayLike,
        speeds: ArrayLike,
        accelerations: ArrayLike,
        guess: ArrayLike | LastPose | None = None,
    ) -> Array:
        r"""Return the actuator forces of a motion.

        They are :math:`\tau = L^T \operatorname{RNEA}(q, \dot q, \ddot q)`.

        Parameters
        ----------
        positions, speeds, accelerations : (..., n) array_like
            Motion of the actuated joints.
        guess : (nq,) array_like or LastPose, optional
            Where closing the loops starts; ``q0`` by default.

        Returns
        -------
        (..., n) ndarray
            Forces [N] or torques [N m] of the actuated joints.

        Raises
        ------
        InvalidArray, ClosureFailed, SingularConfiguration
            See :meth:`configuration`.
        """
        n = self._speed_count
        return self._ask(INVERSE_DYNAMICS, n, guess, positions, speeds, accelerations)

    def actuator_forces(
        self,
        positions: ArrayLike,
        speeds: ArrayLike,
        accelerations: ArrayLike,
        guess: ArrayLike | LastPose | None = None,
    ) -> Array:
        r"""Return the motor forces for a motion; with many motors, those with the least norm.

        They solve :math:`A \tau = y` with :math:`A` from :meth:`actuation_matrix` and y from
        :meth:`inverse_dynamics`. With as many motors as coordinates, both forces are the same.

        Parameters
        ----------
        positions, speeds, accelerations : (..., p), (..., n), (..., n) array_like
            Motion of the coordinates. Fewer accelerations, (..., k), are those of the first k
            coordinates, usually of the ``commanded`` ones, and the others follow from the dynamics
            (partial feedback linearization).

        Returns
        -------
        (..., m) ndarray
            Forces [N] or torques [N m] of the motors, in the order of ``actuated``.

        Raises
        ------
        InvalidArray, ClosureFailed, SingularConfiguration
            See :meth:`configuration`.
        UnreachableForces
            If the motors cannot produce this motion.
        """
        if self.drives_coordinates:
            return self.inverse_dynamics(positions, speeds, accelerations, guess)
        return forces_of_motors(
            self.actuation_matrix(positions),
            lambda rates: self.inverse_dynamics(positions, speeds, rates, guess),
            lambda: self.mass_matrix(positions, guess),
            accelerations,
            self.coordinates,
        )

    def allocated_forces(self, positions: ArrayLike, forces: ArrayLike) -> Array:
        """Return the motor forces with the least norm for forces along the first coordinates.

        Parameters
        ----------
        positions : (..., p) array_like
            Positions of the coordinates.
        forces : (..., k) array_like
            Forces [N] or torques [N m] along the first k coordinates, usually the ``commanded``
            ones. The forces along the others are arbitrary.

        Returns
        -------
        (..., m) ndarray
            Forces of the motors; the given forces if the coordinates are those of the motors.

        Raises
        ------
        UnreachableForces
            If the motors cannot produce them.
        """
        p, n = self._position_count, self._speed_count
        wanted = finite_array("forces", forces)
        k = wanted.shape[-1] if wanted.ndim else 0
        if not 0 < k <= n:
            raise InvalidArray("forces", f"(..., k) of at most {n}", wanted)
        where = finite_rows("positions", positions, p)
        if self.drives_coordinates:
            return wanted
        actuation = self.actuation_matrix(where)[..., :k, :]
        return least_norm(actuation, wanted, self.coordinates[:k])

    @functools.cached_property
    def _motors(self) -> Motors:
        last = self.model.joints[self.model.getJointId(self.coordinates[-1])]
        base = last.nq if last.nq > last.nv > 1 else 0
        matrix = np.ascontiguousarray(self.motors)
        followed = self._core.only_drivers()
        return Motors(self.actuated, matrix, self.coordinates_v, base, self.model, followed)

    @functools.cached_property
    def drives_coordinates(self) -> bool:
        """Whether each coordinate is that of a motor, in the same order."""
        return self._motors.are_coordinates

    @property
    def commanded(self) -> int:
        """Number of coordinates that the motors command; these are the first ones."""
        return int(self.mobility.commanded)

    def actuation_matrix(self, positions: ArrayLike) -> Array:
        r"""Return the matrix from motor forces to forces along the coordinates, :math:`A = L^T B`.

        B has a column for each motor, with a one at its joint, or the lever arms of its tendon. The
        equation of motion is :math:`M a + C v + G = A \tau`.

        Parameters
        ----------
        positions : (..., p) array_like
            Positions of the coordinates [m or rad].

        Returns
        -------
        (..., n, m) ndarray
            The unit matrix if the coordinates are those of the motors.
        """
        nq, nv, n = self.model.nq, self.model.nv, self._speed_count
        rest = np.zeros(n)
        both = self._ask(COMPLEMENT, nq + nv * n, None, positions, rest, rest)
        transposed = both[..., nq:].reshape(*both.shape[:-1], n, nv)
        return np.asarray(transposed @ self.motors)

    def drives_of_coordinates(self, drive: Drive | Sequence[Drive]) -> Driven:
        """Return drives of the motors, and joints' dry friction, as they act on the coordinates.

        Parameters
        ----------
        drive : Drive or sequence of Drive
            The drive of all motors, or of each.

        Returns
        -------
        Driven
            Drives at coordinates, and drives elsewhere.

        Raises
        ------
        InvalidValue
            If the argument is neither a drive nor one drive for each motor.
        """
        return self._motors.driven(drive_table(drive, len(self.actuated)))

    def preload(self, positions: ArrayLike) -> Array:
        """Return a basis of the motor forces that move nothing, (m, k), at one pose.

        If there are more motors than degrees of freedom, they can work against each other;
        otherwise k is 0.

        Parameters
        ----------
        positions : (p,) array_like
            Positions of the coordinates [m or rad].
        """
        row = one_row("positions", positions, self._position_count)
        return null_space(self.actuation_matrix(row), PRELOAD_TOLERANCE, 1.0)

    def closure_forces(
        self, positions: ArrayLike, speeds: ArrayLike, forces: ArrayLike
    ) -> ClosureForces:
        r"""Return the forces in every loop and every joint of one state.

        They are the :math:`\lambda` of :math:`J^T \lambda = f - B \tau`, with f the forces of the
        open tree in the motion that the motor forces cause, and J the derivative of the closure
        equations. For redundant loops, the shortest solution is returned.

        Parameters
        ----------
        positions, speeds : (p,), (n,) array_like
            State of the coordinates.
        forces : (n,) array_like
            Forces along the coordinates: :meth:`actuation_matrix` times the motor forces.

        Returns
        -------
        ClosureForces
            ``.loops`` in the order of ``constraint_models`` and then of ``equations``, without
            couplings, whose forces are along the joints; ``.joints`` in the order of the model.
        """
        row = one_row("positions", positions, self._position_count)
        speed = one_row("speeds", speeds, self._speed_count)
        force = one_row("forces", forces, self._speed_count)
        acceleration = self.forward_dynamics(row, speed, force)
        nq, nv = self.model.nq, self.model.nv
        motion = self._ask(MOTION, nq + 2 * nv, None, row, speed, acceleration)
        q, v, a = motion[:nq], motion[nq : nq + nv], motion[nq + nv :]
        # The forces along the coordinates act at their joints.
        acting = -self.joint_resistance(q, v)
        acting[self.coordinates_v] += force
        found = forces_of_motion(self.model, self._all_closures(), self._held, (q, v, a), acting)
        both = [loop[1:] for loop in found.loops] + [joint[1:] for joint in found.joints]
        if not np.isfinite(both).all():
            raise NoFiniteAnswer(row)
        return found

    def joint_resistance(self, q: ArrayLike, v: ArrayLike) -> Array:
        """Return the forces of springs, damping and dry friction of all joints, (nv,).

        Parameters
        ----------
        q, v : (nq,), (nv,) array_like
            Configuration and joint velocities.
        """
        q, v = one_row("q", q, self.model.nq), one_row("v", v, self.model.nv)
        forces = self.model.damping * v + self.model.upperDryFrictionLimit * np.sign(v)
        for name, (stiffness, rest) in self.springs.items():
            joint = self.model.joints[self.model.getJointId(name)]
            forces[joint.idx_v] += stiffness * (q[joint.idx_q] - rest)
        return np.asarray(forces)

    def forward_dynamics(
        self,
        positions: ArrayLike,
        speeds: ArrayLike,
        forces: ArrayLike,
        guess: ArrayLike | LastPose | None = None,
    ) -> Array:
        """Return the accelerations of the actuated joints under actuator forces.

        They solve the equation of motion in actuated coordinates, see :meth:`equation_of_motion`.

        Parameters
        ----------
        positions, speeds, forces : (..., n) array_like
            State and actuator forces.
        guess : (nq,) array_like or LastPose, optional
            Where closing the loops starts; ``q0`` by default.

        Returns
        -------
        (..., n) ndarray
            Accelerations of the actuated joints.

        Raises
        ------
        InvalidArray, ClosureFailed, SingularConfiguration
            See :meth:`configuration`.
        """
        n = self._speed_count
        return self._ask(FORWARD_DYNAMICS, n, guess, positions, speeds, forces, "forces")

    def inverse_dynamics_derivatives(
        self,
        positions: ArrayLike,
        speeds: ArrayLike,
        accelerations: ArrayLike,
        guess: ArrayLike | LastPose | None = None,
    ) -> InverseDynamicsDerivatives:
        """Return the derivatives of the actuator forces of a motion, along the closed loops.

        See :func:`psp3.dynamics.derivatives.inverse_dynamics_derivatives`; ``guess`` as in
        :meth:`configuration`.
        """
        return InverseDynamicsDerivatives(
            *self._three_matrices(INVERSE_DERIVATIVES, guess, positions, speeds, accelerations)
        )

    def forward_dynamics_derivatives(
        self,
        positions: ArrayLike,
        speeds: ArrayLike,
        forces: ArrayLike,
        guess: ArrayLike | LastPose | None = None,
    ) -> ForwardDynamicsDerivatives:
        """Return the derivatives of the accelerations under actuator forces.

        See :func:`psp3.dynamics.derivatives.forward_dynamics_derivatives`; ``guess`` as in
        :meth:`configuration`.
        """
        return ForwardDynamicsDerivatives(
            *self._three_matrices(FORWARD_DERIVATIVES, guess, positions, speeds, forces, "forces")
        )

    def _three_matrices(
        self, question: int, guess: ArrayLike | LastPose | None, *arguments: Any
    ) -> tuple[Array, Array, Array]:
        """Return three answers that are matrices, each (..., n, n)."""
        n = self._speed_count
        found = self._ask(question, 3 * n * n, guess, *arguments)
        found = found.reshape(*found.shape[:-1], 3, n, n)
        return found[..., 0, :, :], found[..., 1, :, :], found[..., 2, :, :]

    def frame_jacobian(self, positions: ArrayLike, frame: str) -> Array:
        """Return the Jacobian of a frame with respect to the actuated coordinates.

        It is in base axes at the frame's origin.

        Parameters
        ----------
        positions : (..., n) array_like
            Actuated positions.
        frame : str
            Name of a frame of the model. Where a body and a joint share it, the body is meant,
            and ``joint:name`` means the other.

        Returns
        -------
        (..., 6, n) ndarray
            Linear velocity (first three rows) and angular velocity per unit of actuated speed.

        Raises
        ------
        UnknownName
            If the model has no such frame.
        """
        columns = self._ask_of_frame(positions, frame)[..., 12:]
        by_speed = columns.reshape(*columns.shape[:-1], self._speed_count, 6)
        return np.ascontiguousarray(np.swapaxes(by_speed, -1, -2))

    def frame_placement(self, positions: ArrayLike, frame: str) -> Array:
        """Return the placement of a frame in base axes.

        Parameters
        ----------
        positions : (..., n) array_like
            Actuated positions.
        frame : str
            Name of a frame of the model. Where a body and a joint share it, the body is meant,
            and ``joint:name`` means the other.

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
        found = self._ask_of_frame(positions, frame)
        placement: Array = np.zeros((*found.shape[:-1], 4, 4))
        placement[..., :3, :3] = found[..., :9].reshape(*found.shape[:-1], 3, 3)
        placement[..., :3, 3], placement[..., 3, 3] = found[..., 9:12], 1.0
        return placement

    def frame_table(self, frame: str) -> Array:
        """Return a frame as numbers for compiled code, (13,): its element, rotation and position.

        Raises
        ------
        UnknownName
            If the model has no such frame.
        """
        known = self.model.frames[frame_number(self.model, frame)]
        return self._core.frame(known.parentJoint, known.placement)

    def _ask_of_frame(self, positions: ArrayLike, frame: str) -> Array:
        """Return placement and Jacobian of a frame in the core's format, (..., 12 + 6n)."""
        given = finite_rows("positions", positions, self._position_count)
        rows = given.reshape(-1, self._position_count)
        out = np.empty((len(rows), 12 + 6 * self._speed_count))
        numbers = np.tile(self.frame_table(frame), (len(rows), 1))
        try:
            self._core.ask(FRAME, rows, np.zeros((len(rows), self._speed_count)), numbers, out)
        except NoAnswer as failed:
            raise self._refused(failed, rows) from None
        return out.reshape(*given.shape[:-1], out.shape[-1])

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
            See :meth:`configuration`, also for a robot without a tip.
        """
        if self.model.existFrame("tip"):
            return self.frame_placement(positions, "tip")[..., :3, 3]
        configurations = self.configuration(positions)
        return np.full((*configurations.shape[:-1], 3), np.nan)

    has_inverse_of_tip = False
    """Whether :meth:`motion_of_tip` is available: actuated positions for a path of the tip."""

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
            If the robot has no inverse kinematics for its tip.
        """
        raise InvalidValue(
            "robot",
            self.title,
            "one with an inverse kinematics of its tip, as the 3-PSP has; give a path of the "
            "joints",
        )

    def kinetic_energy(self, positions: ArrayLike, speeds: ArrayLike) -> Array:
        """Return the kinetic energy [J], of shape (...,)."""
        return self._ask(ENERGIES, 2, None, positions, speeds, speeds)[..., 0]

    def potential_energy(self, positions: ArrayLike) -> Array:
        """Return the potential energy in the field of gravity and in springs [J], (...,).

        It is zero with all masses at the base's height and all springs at rest.
        """
        rest = np.zeros(self._speed_count)
        return self._ask(ENERGIES, 2, None, positions, rest, rest)[..., 1]
