r"""Singularities of any robot with loops: their kind, their distance, and the motions there.

The joint velocities that keep the loops closed are those in the null space of the constraint
Jacobian :math:`\Phi(q)`. With N an orthonormal basis of it and :math:`\dot q = N w`, there are two
maps: one to the motors, :math:`N_a`, which is the rows of N of their joints (or their combination
for a tendon), and one to the chosen rows of a frame's velocity,

.. math:: \Phi N = 0, \qquad \dot q^a = N_a w, \qquad \dot x = T w, \quad T = J_\text{tree} N .

If :math:`N_a` is invertible, :math:`\dot x = J \dot q^a` with :math:`J = T N_a^{-1}` (the
pseudo-inverse if there are more motors than coordinates). Eliminating w gives :math:`A \dot x = B
\dot q^a`, with :math:`\det A` proportional to :math:`\det N_a` and :math:`\det B` to :math:`\det
T`. There are three kinds of singularities:

* ``actuation``, also called parallel or of the second type: :math:`N_a` loses rank, or equivalently
  the un-actuated columns :math:`\Phi^u` do. The robot can move with its motors locked, and there
  are forces that the motors cannot hold.
* ``end_effector``, also called serial or of the first type: :math:`T` loses rank. The motors can
  move while the frame rests, and there are directions in which the frame cannot move.
* ``constraint``: :math:`\Phi` itself loses rank, so the robot has more degrees of freedom here than
  elsewhere; branches of its motion may meet. The motors are too few to determine the motion, so
  this is also a singularity of actuation.

N and the measures based on it depend only on the mechanism, not on the form of its closure
equations.

Meters and radians are made comparable by a characteristic length: an angle counts as the arc of a
point at that distance from the axis. By default it is the robot's own, see
:func:`characteristic_length`. All singular values are then dimensionless.

Sources: C. Gosselin and J. Angeles, Singularity analysis of closed-loop kinematic chains, IEEE
Transactions on Robotics and Automation 6 (1990), for the two types; F. C. Park and J. W. Kim,
Singularity analysis of closed kinematic chains, Journal of Mechanical Design 121 (1999), for the
two maps; D. Zlatanov, I. A. Bonev and C. M. Gosselin, Constraint singularities of parallel
mechanisms, IEEE International Conference on Robotics and Automation (2002), for the third kind; T.
Yoshikawa, Manipulability of robotic mechanisms, International Journal of Robotics Research 4
(1985); J.-P. Merlet, Jacobian, manipulability, condition number, and accuracy of parallel robots,
Journal of Mechanical Design 128 (2006), for the limits of these numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from fuzzy2.support.described import Described
from psp3.checks import Array, checked_positive, finite_rows, one_row, overflow_refused
from psp3.closure.assembly import jacobian, residual
from psp3.closure.rank import RANK_TOLERANCE, null_space
from psp3.errors import OpenLoops
from psp3.kinematics.tasks import (
    TASK_COORDINATES,
    characteristic_length,
    checked_frame,
    checked_motors,
    checked_task,
    equations_of,
    rotating,
)
from psp3.multibody.flatten import NO_MOTORS, flattened
from psp3.multibody.named_frames import frame_number
from psp3.robots.closed_loop_robot import ClosedLoopRobot

OPEN = 1e-6
"""A configuration is refused if its loops are open by more than this [m, rad]."""

KINDS = ("constraint", "actuation", "end_effector")
"""The three kinds of singularities."""

OPEN_BY_ROUNDING = 10.0
"""Rounded loops may be open by this many times their mismatch, which depends on the pose."""

_CHUNK = 256
"""Number of configurations whose matrices are factored together."""


class Measures(NamedTuple):
    r"""How far configurations are from singularities.

    Each field has the leading dimensions of the configurations, and is dimensionless.

    ``constraint``: smallest over largest singular value of the constraint Jacobian, without
    redundant rows. Zero at a constraint singularity.

    ``actuation``: smallest singular value of :math:`N_a`, between 0 and 1. While the motors move by
    one, all joints together can move by its inverse. Zero if they can move while the motors rest.

    ``end_effector``: smallest singular value of T. While all joints together move by one, the frame
    moves at least this far in every direction of the task. Zero if it cannot move in some
    direction, or rests in some motion.

    ``closure_condition``: condition number of :math:`\Phi^u`, the factor by which errors grow from
    the motors to the other joints.

    ``condition``: condition number of J. One if the frame moves equally well in all directions;
    infinite at singularities of actuation and of the end effector.

    ``manipulability``: product of the singular values of J, which is :math:`\sqrt{\det J J^T}`: the
    volume that unit speeds of the motors give the frame's velocity. Zero at singularities of the
    end effector, infinite at those of actuation.

    ``orientation``: sign of :math:`\det J`, which changes only when one of these singularities is
    crossed. Zero if J is not square.

    ``assembly``: sign of the determinant of the independent rows of :math:`\Phi^u`, which
    distinguishes assembly modes: two configurations with the same motor positions and different
    signs belong to different modes, and every motion between them passes through a singularity of
    actuation. Zero at a constraint singularity.

    ``mobility``: degrees of freedom at this configuration. At a constraint singularity there are
    more than elsewhere, and all values that depend on N are NaN.
    """

    constraint: Array
    actuation: Array
    end_effector: Array
    closure_condition: Array
    condition: Array
    manipulability: Array
    orientation: Array
    assembly: Array
    mobility: Array


class Singularity(NamedTuple):
    """What is singular about a configuration.

    ``kinds`` holds those of :data:`KINDS` that apply; it is empty at a regular configuration. The
    rows of ``locked`` (k, nv) are joint velocities with all motors at rest. The rows of ``still``
    (k, nv) leave the frame at rest in the coordinates of the task; they always exist if the robot
    has more motors than the task has rows. In each row no joint is faster than 1 [m/s, rad/s].
    """

    kinds: tuple[str, ...]
    locked: Array
    still: Array


class SingularityAnalysis(Described):
    """Singularities of a robot with respect to its motors and to a task of one of its frames.

    Parameters
    ----------
    robot : ClosedLoopRobot
        The robot.
    frame : str
        Name of the frame that does the task.
    task : sequence of str
        The rows of the frame's velocity that matter, from :data:`TASK_COORDINATES`: ``("x", "y")``
        for a point in the plane. A frame can be singular for one task and regular for another.
    length : float, optional
        Characteristic length [m]; by default that of :func:`characteristic_length`.

    Attributes
    ----------
    robot, frame, task, length
        As given.

    Raises
    ------
    UnknownName
        If the robot has no such frame, or there is no such task coordinate.
    InvalidValue
        If the task is empty or names a coordinate twice, the length is not positive, or some of the
        robot's coordinates follow its motors.
    """

    def __init__(
        self, robot: ClosedLoopRobot, frame: str, task: Sequence[str], length: float | None = None
    ) -> None:
        self.robot, self.frame = checked_motors(robot), checked_frame(robot, frame)
        self.task = checked_task(task)
        self.length = (
            characteristic_length(robot) if length is None else checked_positive("length", length)
        )
        self._index = frame_number(robot.model, frame)
        self._rows = [TASK_COORDINATES.index(name) for name in self.task]
        # In these matrices the motors are ordinary joints.
        closures = [*robot.constraint_models, *equations_of(robot)]
        self._table = flattened(robot.model, closures, NO_MOTORS)
        mismatch = max(robot.closure_mismatch.length, robot.closure_mismatch.angle)
        self._open = OPEN + OPEN_BY_ROUNDING * mismatch
        self._dependent = np.setdiff1d(np.arange(robot.model.nv), robot.coordinates_v)
        # Velocities times these factors are in m/s; columns of Jacobians are divided by the factors
        # of the joints.
        self._joint_scale = np.where(rotating(robot.model), self.length, 1.0)
        self._row_scale = np.array([self.length if row >= 3 else 1.0 for row in self._rows])
        self._closure_scale = np.where(self._table.is_length, 1.0, self.length)
        with overflow_refused("length"):
            left, _, _ = np.linalg.svd(self._matrices(robot.q0[np.newaxis])[0][0])
        self._independent: Array = left[:, : self._rank].T

    def _facts(self) -> dict[str, Any]:
        return {
            "robot": self.robot,
            "frame": self.frame,
            "task": self.task,
            "length": f"{self.length:.4g} m",
        }

    def positions(self, configurations: ArrayLike) -> Array:
        """Return the position of the frame in base axes.

        Parameters
        ----------
        configurations : (..., nq) array_like
            Pinocchio configurations.

        Returns
        -------
        (..., 3) ndarray
            Positions [m].

        Raises
        ------
        InvalidArray
            If the configurations are not finite or of another shape.
        """
        q = finite_rows("configurations", configurations, self.robot.model.nq)
        out = np.empty((*q.shape[:-1], 3))
        for place, row in zip(out.reshape(-1, 3), q.reshape(-1, q.shape[-1]), strict=True):
            pin.forwardKinematics(self.robot.model, self.robot.data, row)
            place[:] = pin.updateFramePlacement(
                self.robot.model, self.robot.data, self._index
            ).translation
        return out

    def measures(self, configurations: ArrayLike) -> Measures:
        """Return how far configurations are from singularities.

        Parameters
        ----------
        configurations : (..., nq) array_like
            Configurations that close the loops, from ``robot.configuration`` or another source;
            they may be singular.

        Returns
        -------
        Measures
            Fields of shape (...,).

        Raises
        ------
        InvalidArray
            If the configurations are not finite or of another shape.
        OpenLoops
            If one of them does not close the loops.
        """
        q = finite_rows("configurations", configurations, self.robot.model.nq)
        # A copy, because kernels would be compiled again for read-only arrays.
        rows = np.array(q.reshape(-1, q.shape[-1]))
        parts = [
            self._measures(*self._matrices(rows[start : start + _CHUNK]))
            for start in range(0, max(len(rows), 1), _CHUNK)
        ]
        return Measures(
            *(np.concatenate(part).reshape(q.shape[:-1]) for part in zip(*parts, strict=True))
        )

    def classify(self, configuration: ArrayLike, tolerance: float = 1e-6) -> Singularity:
        """Return the kinds of singularities of a configuration, with the singular motions.

        These are the motions with the motors at rest, and those with the frame at rest.

        Parameters
        ----------
        configuration : (nq,) array_like
            A configuration that closes the loops.
        tolerance : float
            Singular values up to this count as zero. Newton's method finds singular configurations
            only to the square root of its accuracy.

        Returns
        -------
        Singularity

        Raises
        ------
        InvalidArray, OpenLoops
            See :meth:`measures`.
        InvalidValue
            If the tolerance is not positive.
        """
        limit = checked_positive("tolerance", tolerance)
        q = np.array(one_row("configuration", configuration, self.robot.model.nq))
        closures, frame = (matrices[0] for matrices in self._matrices(q[np.newaxis]))
        motions = null_space(closures, limit)
        driven, moved = self.robot.motors.T @ motions, frame @ motions
        locked = motions @ null_space(driven, limit, size=1.0)
        still = motions @ null_space(moved, limit, size=1.0)
        free = motions.shape[1]
        found = {
            "constraint": free > self.robot.model.nv - self._rank,
            "actuation": locked.shape[1] > 0,
            "end_effector": free - still.shape[1] < min(len(self.task), self.robot.commanded),
        }
        return Singularity(
            tuple(kind for kind in KINDS if found[kind]),
            self._velocities(locked),
            self._velocities(still),
        )

    @property
    def _rank(self) -> int:
        """Number of independent closure equations in general position.

        It is the number of velocities that depend on the coordinates or are held.
        """
        return self._dependent.size

    def _velocities(self, motions: Array) -> Array:
        """Return homogeneous motions (nv, k) as joint velocities (k, nv), the fastest being 1."""
        velocities = (motions / self._joint_scale[:, np.newaxis]).T
        scaled: Array = velocities / np.abs(velocities).max(axis=1, keepdims=True, initial=1e-300)
        return scaled

    def _matrices(self, rows: Array) -> tuple[Array, Array]:
        """Return constraint Jacobians (N, m, nv) and the task's rows (N, t, nv).

        The rows are those of the frame's Jacobian in the tree. All matrices are dimensionless.
        """
        model, data = self.robot.model, self.robot.data
        closures = np.zeros((len(rows), self._closure_scale.size, model.nv))
        frames = np.empty((len(rows), len(self._rows), model.nv))
        for q, closure, frame in zip(rows, closures, frames, strict=True):
            opening = float(np.abs(residual(self._table, q)).max(initial=0.0))
            if not opening <= self._open:
                raise OpenLoops(opening, self._open)
            closure[:] = jacobian(self._table, q)
            pin.computeJointJacobians(model, data, q)
            pin.updateFramePlacement(model, data, self._index)
            whole = pin.getFrameJacobian(
                model, data, self._index, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
            )
            frame[:] = whole.reshape(6, model.nv)[self._rows]
        closures *= self._closure_scale[:, np.newaxis] / self._joint_scale
        frames *= self._row_scale[:, np.newaxis] / self._joint_scale
        return closures, frames

    def _measures(self, closures: Array, frames: Array) -> Measures:
        count, rank, nv = len(closures), self._rank, self.robot.model.nv
        constraint, closure_condition, mobility = (
            np.ones(count),
            np.ones(count),
            np.full(count, float(nv)),
        )
        motions = np.broadcast_to(np.eye(nv), (count, nv, nv))
        if rank:
            _, values, right = np.linalg.svd(closures)
            constraint = values[:, rank - 1] / values[:, 0]
            # Rounded redundant equations seem independent.
            independent = np.count_nonzero(values > RANK_TOLERANCE * values[:, :1], axis=1)
            mobility = (nv - np.minimum(independent, rank)).astype(float)
            motions = np.swapaxes(right[:, rank:], 1, 2)
            closure_condition = _condition(closures[:, :, self._dependent])
        driven, moved = self.robot.motors.T @ motions, frames @ motions
        measures = Measures(
            constraint=constraint,
            actuation=np.linalg.svd(driven, compute_uv=False)[:, -1].astype(float),
            end_effector=np.linalg.svd(moved, compute_uv=False)[:, -1].astype(float),
            closure_condition=closure_condition,
            condition=np.full(count, np.inf),
            manipulability=np.full(count, np.inf),
            # The sign of each determinant depends on the basis; the sign of their product does not.
            orientation=np.sign(np.linalg.det(driven) * np.linalg.det(moved))
            if driven.shape[1] == driven.shape[2] == len(self.task)
            else np.zeros(count),
            assembly=np.sign(np.linalg.det((self._independent @ closures)[:, :, self._dependent])),
            mobility=mobility,
        )
        regular = measures.actuation > RANK_TOLERANCE
        # With more motors than coordinates, only motor motions that keep the loops closed count.
        inverse = np.linalg.pinv(driven[regular])
        transposed: Array = np.swapaxes(moved[regular] @ inverse, 1, 2).astype(float)
        measures.condition[regular] = _condition(transposed)
        measures.manipulability[regular] = np.linalg.svd(transposed, compute_uv=False).prod(axis=1)
        # If there are more directions than usual, it is not determined which of them belong to N.
        apart = mobility > nv - rank
        measures.actuation[apart], measures.closure_condition[apart], measures.assembly[apart] = (
            0.0,
            np.inf,
            0.0,
        )
        for array in (
            measures.end_effector,
            measures.condition,
            measures.manipulability,
            measures.orientation,
        ):
            array[apart] = np.nan
        return measures


def _condition(matrices: Array) -> Array:
    """Return the condition numbers of matrices (N, m, k); infinite if they are singular."""
    values = np.linalg.svd(matrices, compute_uv=False)
    condition = np.full(len(matrices), np.inf)
    regular = values[:, -1] > RANK_TOLERANCE * values[:, 0]
    condition[regular] = values[regular, 0] / values[regular, -1]
    return condition
