r"""The 3-PSP parallel robot.

It has three vertical ball screws, a ball joint on each nut, and a slider along each arm of a star.

One object holds the robot as Pinocchio sees it (tree, loop closures, poses, visuals) and answers
every question about its kinematics and dynamics in the nut heights :math:`a`, through the compiled
closed form of :mod:`psp3.three_psp.closed_form`. There are three other implementations of its
dynamics, see :meth:`PSP3.dynamics`.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn

import numpy as np
from numpy.typing import ArrayLike

from psp3.checks import (
    Array,
    applied_to_rows,
    as_floats,
    checked_kind,
    finite_rows,
    one_row,
    together,
)
from psp3.dynamics.dynamics_model import DynamicsModel
from psp3.errors import InvalidArray, InvalidValue, UnknownName, UnreachablePose, UnreachableTip
from psp3.multibody.core import LastPose
from psp3.robots import implementations
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from psp3.robots.learning_inputs import LearningInputs, differences_of_three
from psp3.three_psp.geometry import arm_lengths, heights_of_tilt, tip_reach
from psp3.three_psp.parameters import Parameters

if TYPE_CHECKING:
    import pinocchio as pin

DYNAMICS_MODELS = ("closed_form", *implementations.DYNAMICS_MODELS)
"""Names of the four implementations of the equation of motion."""

SCREW_IN_NUT = np.array([0.0, -0.055, 0.0])
"""The point where the screw passes through the nut, in the axes of the leg [m]; see the visuals of
psp3.urdf.
"""


class Pose:
    """Pose of the star in base axes [m].

    ``center`` (..., 3), ``rotation`` (..., 3, 3), ``arms`` (..., 3) and ``tip`` (..., 3).

    The four are views of one buffer.
    """

    __slots__ = ("_buffer",)

    def __init__(self, buffer: Array) -> None:
        self._buffer = buffer

    @property
    def center(self) -> Array:
        """Center of the star, where its arms meet, of shape (..., 3) [m]."""
        return self._buffer[..., 0:3]

    @property
    def rotation(self) -> Array:
        """Rotation of the star, from star axes to base axes, of shape (..., 3, 3)."""
        return self._buffer[..., 3:12].reshape(*self._buffer.shape[:-1], 3, 3)

    @property
    def arms(self) -> Array:
        """Arm lengths b_1, b_2, b_3 between the center and the ball joints, (..., 3) [m]."""
        return self._buffer[..., 12:15]

    @property
    def tip(self) -> Array:
        """Tip of the tool, of shape (..., 3) [m]."""
        return self._buffer[..., 15:18]

    def __repr__(self) -> str:
        return (
            f"Pose(center={self.center!r}, rotation={self.rotation!r}, arms={self.arms!r}, "
            f"tip={self.tip!r})"
        )


class PSP3(ClosedLoopRobot):
    """The 3-PSP robot in closed form; get one from :func:`psp3.load`.

    Every method accepts leading batch dimensions, and all heights at which the three arm lengths
    are positive. Trajectories and the simulation check the stroke of the screws, ``stroke``. To
    change ``parameters``, create another robot: later changes of ``model``, including its gravity,
    have no effect.

    Parameters
    ----------
    model, constraint_models, actuated, q0, visual_model
        See :class:`psp3.ClosedLoopRobot`.
    parameters : Parameters
        The numbers that the closed form uses; those of ``model`` must agree.
    """

    def __init__(
        self,
        model: pin.Model,
        constraint_models: Sequence[Any],
        actuated: Sequence[str],
        q0: ArrayLike,
        visual_model: Any,
        parameters: Parameters,
    ) -> None:
        checked_kind("parameters", parameters, Parameters, "psp3.Parameters")
        super().__init__(model, constraint_models, actuated, q0, visual_model)
        self.parameters = parameters
        self._load_kernels()
        self._p = parameters.as_array()
        self._configuration_order = np.array(
            [
                model.joints[model.getJointId(f"{joint}{leg}")].idx_q
                for leg in (1, 2, 3)
                for joint in ("a", "phi", "theta", "lambda", "b")
            ]
        )

    def _load_kernels(self) -> None:
        """Select the closed form; the compiled one when more than a few calls are expected."""
        from psp3.three_psp import many_states
        from psp3.three_psp.few_states import KernelsOnDemand

        self._kernels: Any = KernelsOnDemand(self)
        self._of_many = many_states.first_refused_row

    def __getstate__(self) -> dict[str, Any]:
        state = super().__getstate__()
        # A module cannot be pickled.
        del state["_kernels"], state["_of_many"]
        return state

    def __setstate__(self, state: dict[str, Any]) -> None:
        super().__setstate__(state)
        self._load_kernels()

    @property
    def stroke(self) -> tuple[Array, Array]:
        """Lowest and highest nut heights, each of shape (3,) [m].

        They are the limits of the actuated joints.
        """
        return self.limits

    @property
    def title(self) -> str:
        """Name of the robot in titles."""
        return "3-PSP robot"

    @property
    def limit_message(self) -> str:
        """Message for a nut beyond the ends of its screw."""
        return "a nut ran off its screw"

    @property
    def point_of_force(self) -> Array:
        """Where the screw passes through the nut, in the axes of the leg, (3,) [m]."""
        return SCREW_IN_NUT

    @property
    def learning_inputs(self) -> LearningInputs:
        """The four differences on which M, C and G depend; the mean height does not matter."""
        return differences_of_three()

    @property
    def compiled_steps(self) -> Callable[[int, Any], Any]:
        """Function that creates a compiled plant from a number of steps and drives."""
        from psp3.three_psp.stepping import ClosedFormSteps

        return functools.partial(ClosedFormSteps, self._p)

    def last_pose(self) -> None:
        """Return None: a closed form does not search for poses."""

    def compiled_table(self) -> NamedTuple | None:
        """Return the robot's table for compiled loops; None if a subclass changes its dynamics."""
        from psp3.three_psp.stepping import closed_form_table

        return closed_form_table(self._p) if type(self) is PSP3 else None

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
        """Return answers of the core, which starts from the poses of the closed form."""

        def one(row: Array, speed: Array, other: Array) -> Array:
            start = self.configuration(row) if guess is None else guess
            return super(PSP3, self)._ask(question, width, start, row, speed, other, name_of_third)

        return applied_to_rows(
            one,
            (width,),
            positions=(positions, 3),
            speeds=(speeds, 3),
            **{name_of_third: (third, 3)},
        )

    def dynamics(self, name: str) -> DynamicsModel:
        """Return one of the four implementations of the equation of motion.

        The closed form shares only its parameters with the others. The others share the tree and
        Pinocchio's joints, and each closes the loops in its own way.

        Parameters
        ----------
        name : str
            ``"closed_form"`` (this object); ``"core"`` (the same parts as a
            :class:`psp3.ClosedLoopRobot`, computed like any robot); ``"pinocchio"`` or ``"noc"``,
            see :meth:`psp3.ClosedLoopRobot.dynamics`.

        Raises
        ------
        UnknownName
            If there is no implementation of that name; the error lists the known ones.
        """
        if name == "closed_form":
            return self
        if name == "core":
            return ClosedLoopRobot(
                self.model, self.constraint_models, self.actuated, self.q0, self.visual_model
            )
        if name not in DYNAMICS_MODELS:
            raise UnknownName("dynamics model", name, DYNAMICS_MODELS)
        return super().dynamics(name)

    # Kinematics

    def forward_kinematics(self, heights: ArrayLike) -> Pose:
        """Return the pose of the star for given nut heights.

        Parameters
        ----------
        heights : (..., 3) array_like
            Nut heights [m].

        Returns
        -------
        Pose
            ``.center`` (..., 3), ``.rotation`` (..., 3, 3), ``.arms`` (..., 3) and ``.tip`` (...,
            3), in base axes [m]. The star never rotates about its own axis: its torsion is zero.

        Raises
        ------
        InvalidArray
            If the heights are not finite or of another shape.
        UnreachablePose
            If an arm length is not positive.
        """
        a = _three("heights", heights)
        out = np.empty(18 if a.ndim == 1 else (*a.shape[:-1], 18))
        if a.ndim == 1:
            row = self._kernels.forward_kinematics(a, self._p, out)
        else:
            row = self._of_many("forward_kinematics", (a,), self._p, out)
        if row >= 0:
            self._refuse(row, heights=a)
        return Pose(out)

    def configuration(self, heights: ArrayLike, guess: ArrayLike | LastPose | None = None) -> Array:
        r"""Return the Pinocchio configuration that closes the loops (eq. 3.5).

        With :math:`(x, y)` the star's slope in the axes of leg k: :math:`\tan\varphi_k = x`,
        :math:`\sin\theta_k = -c y`, :math:`\tan\lambda_k = -\kappa x y / (1 - \kappa y^2)`, where
        :math:`\kappa = c^2/(1+c)`.

        Parameters
        ----------
        heights : (..., 3) array_like
            Nut heights [m].
        guess : (15,) array_like or LastPose, optional
            As of a :class:`psp3.ClosedLoopRobot`; the closed form needs none.

        Returns
        -------
        (..., 15) ndarray
            Joint positions in the order of ``robot.model`` [m, rad].

        Raises
        ------
        InvalidArray, UnreachablePose
            See :meth:`forward_kinematics`.
        """
        if guess is not None:
            self._check_guess(guess)
        a = _three("heights", heights)
        out = np.empty((*a.shape[:-1], 15))
        if a.ndim == 1:
            row = self._kernels.configuration(a, self._p, out)
        else:
            row = self._of_many("configuration", (a,), self._p, out)
        if row >= 0:
            self._refuse(row, heights=a)
        q = np.empty_like(out)
        q[..., self._configuration_order] = out
        return q

    def inverse_kinematics(self, height: ArrayLike, tilt: ArrayLike, azimuth: ArrayLike) -> Array:
        """Return the nut heights that hold the star's center at a height and its axis at a tilt.

        See :func:`psp3.three_psp.geometry.heights_of_tilt` for the equation.

        Parameters
        ----------
        height : (...,) array_like
            Height of the star's center [m].
        tilt, azimuth : (...,) array_like
            Angle of the star's axis from the vertical, and the direction toward which it leans
            [rad].

        Returns
        -------
        (..., 3) ndarray
            Nut heights [m].

        Raises
        ------
        InvalidArray, InvalidValue, UnreachablePose
            If an argument is not finite, the tilt is 90 degrees or more, or an arm would not be
            longer than 0.
        """
        return heights_of_tilt(height, tilt, azimuth, self.parameters.screw_radius)

    def inverse_kinematics_tip(self, tip: ArrayLike) -> Array:
        """Return the nut heights that put the tip at a point, on the branch connected to home.

        Parameters
        ----------
        tip : (..., 3) array_like
            Points in base axes [m].

        Returns
        -------
        (..., 3) ndarray
            Nut heights [m].

        Raises
        ------
        InvalidArray
            If the points are not finite or of another shape.
        UnreachableTip
            If a point lies beyond the fold; the error names the reach at its azimuth, see
            :meth:`tip_reach`.
        """
        points = _three("tip", tip)
        out = np.empty_like(points)
        if points.ndim == 1:
            row = self._kernels.inverse_kinematics_tip(points, self._p, out)
        else:
            row = self._of_many("inverse_kinematics_tip", (points,), self._p, out)
        if row >= 0:
            point = points.reshape(-1, 3)[row]
            if not np.isfinite(point).all():
                raise InvalidArray("tip", "(..., 3)", points)
            azimuth = float(np.arctan2(point[1], point[0]))
            raise UnreachableTip(
                point, float(np.hypot(point[0], point[1])), azimuth, float(self.tip_reach(azimuth))
            )
        return out

    def tip_reach(self, azimuth: ArrayLike) -> Array:
        """Return how far the tip can move from the vertical axis at an azimuth [m].

        See :func:`psp3.three_psp.geometry.tip_reach`.
        """
        return tip_reach(azimuth, self.parameters.screw_radius, self.parameters.tool_length)

    def tip_jacobian(self, heights: ArrayLike) -> Array:
        """Return the Jacobian of the tip's position with respect to the nut heights.

        Parameters
        ----------
        heights : (..., 3) array_like
            Nut heights [m].

        Returns
        -------
        (..., 3, 3) ndarray
            Derivative of tip coordinate i (base axes) with respect to height k, dimensionless.

        Raises
        ------
        InvalidArray, UnreachablePose
            See :meth:`forward_kinematics`.
        """
        a = _three("heights", heights)
        out = np.empty((*a.shape, 3))
        if a.ndim == 1:
            row = self._kernels.tip_jacobian(a, self._p, out.ravel())
        else:
            row = self._of_many("tip_jacobian", (a,), self._p, out.reshape(-1, 9))
        if row >= 0:
            self._refuse(row, heights=a)
        return out

    def position_jacobian(self, positions: ArrayLike, frame: str) -> Array:
        """Return the Jacobian of a frame's origin, (..., 3, 3); see :meth:`tip_jacobian`."""
        return (
            self.tip_jacobian(positions)
            if frame == "tip"
            else super().position_jacobian(positions, frame)
        )

    def tip(self, positions: ArrayLike) -> Array:
        """Return the tip in base axes, of shape (..., 3) [m]; see :meth:`forward_kinematics`."""
        return self.forward_kinematics(positions).tip

    has_inverse_of_tip = True
    """The tip's inverse kinematics is known."""

    def motion_of_tip(
        self, point: Array, velocity: Array, acceleration: Array
    ) -> tuple[Array, Array, Array]:
        """Return nut heights, speeds and accelerations for a motion of the tip.

        Parameters
        ----------
        point, velocity, acceleration : (..., 3) ndarray
            Motion of the tip in base axes [m], [m/s], [m/s²].

        Raises
        ------
        InvalidArray, UnreachableTip, UnreachablePose
            See :meth:`inverse_kinematics_tip` and :meth:`rates_of_tip`.
        """
        heights = self.inverse_kinematics_tip(point)
        return heights, *self.rates_of_tip(heights, velocity, acceleration)

    def rates_of_tip(
        self, heights: ArrayLike, velocity: ArrayLike, acceleration: ArrayLike
    ) -> tuple[Array, Array]:
        r"""Return nut speeds and accelerations for a motion of the tip.

        .. math:: \dot a = J^{-1} \dot x, \qquad \ddot a = J^{-1} (\ddot x - \dot J \dot a).

        Parameters
        ----------
        heights : (..., 3) array_like
            Nut heights of the tip's positions, from :meth:`inverse_kinematics_tip` [m].
        velocity, acceleration : (..., 3) array_like
            Velocity [m/s] and acceleration [m/s²] of the tip in base axes.

        Returns
        -------
        speeds, accelerations : (..., 3) ndarray
            Rates of the nut heights [m/s], [m/s²].

        Raises
        ------
        InvalidArray, UnreachablePose
            See :meth:`forward_kinematics`.
        """
        a, dx, ddx = together(
            heights=_three("heights", heights),
            velocity=finite_rows("velocity", velocity, 3),
            acceleration=finite_rows("acceleration", acceleration, 3),
        )
        speeds, accelerations = np.empty_like(a), np.empty_like(a)
        if a.ndim == 1:
            row = self._kernels.tip_rates(a, dx, ddx, self._p, speeds, accelerations)
        else:
            row = self._of_many("tip_rates", (a, dx, ddx), self._p, speeds, accelerations)
        if row >= 0:
            self._refuse(row, heights=a, velocity=dx, acceleration=ddx)
        return speeds, accelerations

    # Dynamics

    def equation_of_motion(
        self,
        heights: ArrayLike,
        speeds: ArrayLike,
        guess: ArrayLike | LastPose | None = None,
    ) -> tuple[Array, Array, Array]:
        r"""Return mass matrix, Coriolis matrix and gravity vector in one call (eq. 3.1–3.4).

        .. math:: M(a)\, \ddot a + C(a, \dot a)\, \dot a + G(a) = \tau

        Parameters
        ----------
        heights, speeds : (..., 3) array_like
            Nut heights [m] and speeds [m/s].
        guess : (15,) array_like or LastPose, optional
            As of a :class:`psp3.ClosedLoopRobot`; the closed form needs none.

        Returns
        -------
        M : (..., 3, 3) ndarray
            Symmetric, positive definite [kg].
        C : (..., 3, 3) ndarray
            The only matrix with the right C v for which dM/dt − 2C is skew and C (1, 1, 1) = 0
            [kg/s].
        G : (..., 3) ndarray
            Weight carried by each screw, g M 1 [N].

        Raises
        ------
        InvalidArray, UnreachablePose
            See :meth:`forward_kinematics`.
        """
        if guess is not None:
            self._check_guess(guess)
        a, v = _three("heights", heights), _three("speeds", speeds)
        if a.shape != v.shape:
            a, v = together(heights=a, speeds=v)
        if a.ndim == 1:
            # For one state, as in a control loop, returning plain slices saves a fifth of the time.
            out = np.empty(21)
            if self._kernels.equation_of_motion(a, v, self._p, out) >= 0:
                self._refuse(0, heights=a, speeds=v)
            return out[:9].reshape(3, 3), out[9:18].reshape(3, 3), out[18:]
        out = np.empty((*a.shape[:-1], 21))
        row = self._of_many("equation_of_motion", (a, v), self._p, out)
        if row >= 0:
            self._refuse(row, heights=a, speeds=v)
        square = (*a.shape[:-1], 3, 3)
        return out[..., :9].reshape(square), out[..., 9:18].reshape(square), out[..., 18:]

    def mass_matrix(self, heights: ArrayLike, guess: ArrayLike | LastPose | None = None) -> Array:
        """Return the mass matrix M (eq. 3.2), of shape (..., 3, 3) [kg].

        See :meth:`equation_of_motion`.
        """
        return self.equation_of_motion(heights, _REST, guess)[0]

    def coriolis_matrix(self, heights: ArrayLike, speeds: ArrayLike) -> Array:
        """Return the Coriolis matrix C (eq. 3.3), of shape (..., 3, 3) [kg/s].

        See :meth:`equation_of_motion`.
        """
        return self.equation_of_motion(heights, speeds)[1]

    def gravity(self, heights: ArrayLike) -> Array:
        """Return the gravity vector G (eq. 3.4), of shape (..., 3) [N].

        See :meth:`equation_of_motion`.
        """
        return self.equation_of_motion(heights, _REST)[2]

    def inverse_dynamics(
        self,
        heights: ArrayLike,
        speeds: ArrayLike,
        accelerations: ArrayLike,
        guess: ArrayLike | LastPose | None = None,
    ) -> Array:
        r"""Return the screw forces of a motion, :math:`\tau = M \ddot a + C \dot a + G` (eq. 3.1).

        Parameters
        ----------
        heights, speeds, accelerations : (..., 3) array_like
            Nut heights [m], speeds [m/s] and accelerations [m/s²].
        guess : (15,) array_like or LastPose, optional
            As of a :class:`psp3.ClosedLoopRobot`; the closed form needs none.

        Returns
        -------
        (..., 3) ndarray
            Forces along the screws [N].

        Raises
        ------
        InvalidArray, UnreachablePose
            See :meth:`forward_kinematics`.
        """
        if guess is not None:
            self._check_guess(guess)
        a, v, w = (
            _three("heights", heights),
            _three("speeds", speeds),
            _three("accelerations", accelerations),
        )
        if not a.shape == v.shape == w.shape:
            a, v, w = together(heights=a, speeds=v, accelerations=w)
        out = np.empty(a.shape)
        if a.ndim == 1:
            row = self._kernels.inverse_dynamics(a, v, w, self._p, out)
        else:
            row = self._of_many("inverse_dynamics", (a, v, w), self._p, out)
        if row >= 0:
            self._refuse(row, heights=a, speeds=v, accelerations=w)
        return out

    def forward_dynamics(
        self,
        heights: ArrayLike,
        speeds: ArrayLike,
        forces: ArrayLike,
        guess: ArrayLike | LastPose | None = None,
    ) -> Array:
        r"""Return the accelerations under given screw forces.

        They are :math:`\ddot a = M^{-1} (\tau - C \dot a - G)`.

        Parameters
        ----------
        heights, speeds, forces : (..., 3) array_like
            Nut heights [m], speeds [m/s] and forces along the screws [N].
        guess : (15,) array_like or LastPose, optional
            As of a :class:`psp3.ClosedLoopRobot`; the closed form needs none.

        Returns
        -------
        (..., 3) ndarray
            Accelerations of the nuts [m/s²].

        Raises
        ------
        InvalidArray, UnreachablePose
            See :meth:`forward_kinematics`.
        """
        if guess is not None:
            self._check_guess(guess)
        a, v, f = _three("heights", heights), _three("speeds", speeds), _three("forces", forces)
        if not a.shape == v.shape == f.shape:
            a, v, f = together(heights=a, speeds=v, forces=f)
        out = np.empty(a.shape)
        if a.ndim == 1:
            row = self._kernels.forward_dynamics(a, v, f, self._p, out)
        else:
            row = self._of_many("forward_dynamics", (a, v, f), self._p, out)
        if row >= 0:
            self._refuse(row, heights=a, speeds=v, forces=f)
        return out

    def _energies(self, heights: ArrayLike, speeds: ArrayLike) -> Array:
        a, v = together(heights=_three("heights", heights), speeds=_three("speeds", speeds))
        out = np.empty((*a.shape[:-1], 2))
        if a.ndim == 1:
            row = self._kernels.energies(a, v, self._p, out)
        else:
            row = self._of_many("energies", (a, v), self._p, out)
        if row >= 0:
            self._refuse(row, heights=a, speeds=v)
        return out

    def kinetic_energy(self, heights: ArrayLike, speeds: ArrayLike) -> Array:
        """Return the kinetic energy, half v'Mv, of shape (...,) [J]."""
        return self._energies(heights, speeds)[..., 0]

    def potential_energy(self, heights: ArrayLike) -> Array:
        """Return the potential energy V with G = dV/da, of shape (...,) [J].

        It is zero with all masses at the base's height.
        """
        return self._energies(heights, _REST)[..., 1]

    def _check_guess(self, guess: ArrayLike | LastPose) -> None:
        """Refuse what no robot accepts as a guess, although the closed form needs none."""
        if not isinstance(guess, LastPose):
            one_row("guess", guess, self.model.nq)

    def _refuse(self, row: int, **arguments: Array) -> NoReturn:
        """Raise the error that belongs to the first row a kernel refused."""
        for name, array in arguments.items():
            if not np.isfinite(array.reshape(-1, 3)[row]).all():
                raise InvalidArray(name, "(..., 3)", array)
        heights = arguments["heights"].reshape(-1, 3)[row]
        arms = arm_lengths(heights, self.parameters.screw_radius)
        if (arms > 0.0).all():
            others = {
                name: array.reshape(-1, 3)[row].tolist()
                for name, array in arguments.items()
                if name != "heights"
            }
            raise InvalidValue(" and ".join(others), others, "small enough for a finite result")
        raise UnreachablePose(heights, arms)


_REST = np.zeros(3)
_FLOAT = np.dtype(np.float64)


def _three(name: str, values: ArrayLike) -> Array:
    """Return ``values`` as a contiguous float array of shape (..., 3).

    The kernels check whether they are finite.
    """
    # Numba would compile every kernel again for a read-only array.
    ready = type(values) is np.ndarray and values.dtype is _FLOAT and values.flags.carray
    array: Array = np.ascontiguousarray(values) if ready else as_floats(name, values, "(..., 3)")
    if array.shape != (3,) and (array.shape[-1] != 3 or np.ndim(values) == 0):
        raise InvalidArray(name, "(..., 3)", values)
    return array
