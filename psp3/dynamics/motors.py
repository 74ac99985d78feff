r"""Motors of a robot: the forces that they produce, and the motor forces for wanted forces.

Column j of B holds the joint velocities that motor j drives. Motor forces :math:`\tau` then act as
forces :math:`A \tau` along the coordinates, with :math:`A = L^T B`. If there are more motors than
commanded coordinates, many motor forces have the same effect, and those with the least norm are
chosen. If there are more coordinates, accelerations can be prescribed for the first ones, and the
others follow (partial feedback linearization: M. W. Spong, Partial feedback linearization of
underactuated mechanical systems, IROS 1994):

.. math:: S M^{-1} (A \tau - h) = \ddot q_c, \qquad \ddot q_c = S \ddot q,

with h the forces of a motion without acceleration, and S the rows of the prescribed coordinates.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from psp3.checks import Array, Indices, finite_rows
from psp3.errors import UnreachableForces

RANK = 1e-7
"""Singular values up to this share of the largest one count as zero."""

LEFT_OVER = 1e-8
"""Share of the wanted forces that may be missing because of rounding."""


class Driven(NamedTuple):
    r"""Drives and the joints' own dry friction, as in the equation of motion in coordinates.

    A drive that is not at a coordinate is called a drive elsewhere. With its column c it moves at
    :math:`\omega = c^T \dot q`, and its inertia and friction act along :math:`L^T c`. If it follows
    a single coordinate, it rests when the coordinate rests, and its dry friction, times its lever
    arm, holds the coordinate. If it follows several, its dry friction has the sign of its speed.
    """

    coordinates: Array
    """Reflected inertia, viscous and dry friction at each coordinate, (n, 3)."""
    columns: Array
    """The columns c of the drives elsewhere, (nv, w)."""
    elsewhere: Array
    """Reflected inertia, viscous and dry friction of each of these, (w, 3)."""
    follows: Indices
    """The only coordinate that each of these follows, or −1, (w,)."""
    joints: Indices
    """Velocities of the joints whose own dry friction is included in these numbers."""


class Motors(NamedTuple):
    """The joints that the motors of a robot drive, and their places among its coordinates."""

    names: tuple[str, ...]
    matrix: Array
    """B, (nv, m)."""
    speeds: Indices
    """Velocity of each coordinate, (n,)."""
    base_coordinates: int
    """Coordinates of a floating base, which are the last: 7, in a plane 4, or none."""
    model: pin.Model
    followed: Indices
    """The only coordinate that each joint velocity follows, or −1, (nv,)."""

    @property
    def are_coordinates(self) -> bool:
        """Whether each coordinate is that of a motor, in the same order."""
        n = len(self.speeds)
        return self.matrix.shape[1] == n and bool((self.matrix[self.speeds] == np.eye(n)).all())

    def without_drives(self) -> Driven:
        """Return no drives; the joints' own forces then include their dry friction."""
        none, n, nv = np.zeros(0, dtype=np.int64), len(self.speeds), self.model.nv
        return Driven(np.zeros((n, 3)), np.zeros((nv, 0)), np.zeros((0, 3)), none, none)

    def driven(self, drives: Array) -> Driven:
        """Return drives of motors, (m, 3), and the joints' own dry friction.

        The joints' own forces include the friction of joints that follow several coordinates.
        """
        of_coordinates = np.zeros((len(self.speeds), 3))
        columns, elsewhere = [], []
        for column, row in zip(self.matrix.T, drives, strict=True):
            places = np.flatnonzero(column)
            own = np.flatnonzero(self.speeds == places[0]) if len(places) == 1 else places[:0]
            if own.size and column[places[0]] == 1.0:
                of_coordinates[own[0]] += row
            elif row.any():
                columns.append(column)
                elsewhere.append(row)
        friction = self.model.upperDryFrictionLimit
        of_coordinates[:, 2] += friction[self.speeds]
        rough = (friction > 0.0) & (self.followed >= 0)
        for velocity in np.setdiff1d(np.flatnonzero(rough), self.speeds):
            columns.append(np.eye(self.model.nv)[velocity])
            elsewhere.append(np.array([0.0, 0.0, friction[velocity]]))
        turned = np.array(columns).reshape(-1, self.model.nv).T
        return Driven(
            of_coordinates,
            np.ascontiguousarray(turned),
            np.array(elsewhere).reshape(-1, 3),
            np.array([self._followed_by(column) for column in columns], dtype=np.int64),
            np.union1d(np.flatnonzero(rough), self.speeds[friction[self.speeds] > 0.0]),
        )

    def _followed_by(self, column: Array) -> int:
        """Return the only coordinate that all joints of a column follow, or −1."""
        found = set(self.followed[np.flatnonzero(column)].tolist())
        return found.pop() if len(found) == 1 else -1


def least_norm(matrix: Array, wanted: Array, names: Sequence[str], what: str = "forces") -> Array:
    """Return the shortest motor forces (..., m) that have a wanted effect (..., k).

    Parameters
    ----------
    matrix : (..., k, m) ndarray
        The effect of each motor.
    wanted : (..., k) ndarray
        The wanted effect of all motors together.
    names : sequence of str
        Coordinates, for the error.
    what : str
        ``"forces"`` or ``"accelerations"``.

    Raises
    ------
    UnreachableForces
        If some of it cannot be reached.
    """
    inverse = np.linalg.pinv(matrix, rcond=RANK)
    motors: Array = np.einsum("...mk,...k->...m", inverse, wanted)
    left = np.abs(wanted - np.einsum("...km,...m->...k", matrix, motors))
    size = float(left.max(initial=0.0))
    if size > LEFT_OVER * (1.0 + float(np.abs(wanted).max(initial=0.0))):
        raise UnreachableForces(size, names, what)
    return motors


def forces_of_motors(
    actuation: Array,
    along: Callable[[ArrayLike], Array],
    mass: Callable[[], Array],
    accelerations: ArrayLike,
    names: Sequence[str],
) -> Array:
    """Return the shortest motor forces (..., m) for accelerations of all or the first coordinates.

    Parameters
    ----------
    actuation : (..., n, m) ndarray
        A.
    along : callable
        Forces along the coordinates (..., n) of accelerations (..., n) in this state.
    mass : callable
        The mass matrix (..., n, n) in this state, needed for fewer accelerations.
    accelerations : (..., n) or (..., k) array_like
        Accelerations of the coordinates, or of the first k; the others then follow.
    names : sequence of str
        The coordinates.

    Raises
    ------
    UnreachableForces
        If the motors cannot produce them.
    """
    n = actuation.shape[-2]
    k = (*np.shape(accelerations)[-1:], n)[0]
    if k < n:
        wanted = finite_rows("accelerations", accelerations, k)
        return partly_linearizing(mass(), along(np.zeros(n)), actuation, wanted, names)
    return least_norm(actuation, along(accelerations), names)


def partly_linearizing(
    mass: Array, bias: Array, actuation: Array, accelerations: Array, names: Sequence[str]
) -> Array:
    """Return the shortest motor forces (..., m) for wanted accelerations of the first coordinates.

    Parameters
    ----------
    mass : (..., n, n) ndarray
    bias : (..., n) ndarray
        Forces of the same motion without acceleration.
    actuation : (..., n, m) ndarray
        A.
    accelerations : (..., k) ndarray
        Accelerations of the first k coordinates; the others follow.
    names : sequence of str
        The coordinates.

    Raises
    ------
    UnreachableForces
        If the motors cannot produce these accelerations.
    """
    k = accelerations.shape[-1]
    both = np.linalg.solve(mass, np.concatenate([actuation, bias[..., np.newaxis]], axis=-1))
    free, made = both[..., :k, -1], both[..., :k, :-1]
    return least_norm(made, accelerations + free, names[:k], "accelerations")
