r"""Motors of a robot: the forces they produce, and the motor forces for wanted forces.

With B what each motor drives, a column of joint velocities each, motor forces :math:`\tau` are
forces :math:`A \tau` along the coordinates, :math:`A = L^T B`. Where motors are more than the
coordinates that they command, many forces do the same, and those of least norm are taken; where
coordinates are more, the accelerations of the first ones can be asked for, and the others follow
(partial feedback linearization: M. W. Spong, Partial feedback linearization of underactuated
mechanical systems, IROS 1994):

.. math:: S M^{-1} (A \tau - h) = \ddot q_c, \qquad \ddot q_c = S \ddot q,

with h the forces of a motion without acceleration, and S the rows of the coordinates asked for.
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
"""Share of the largest singular value up to which one counts as zero."""

LEFT_OVER = 1e-8
"""Share of what is wanted that may be missed, by rounding."""


class Driven(NamedTuple):
    r"""Drives and the joints' own dry friction, as the equation of motion in coordinates has them.

    A drive elsewhere moves at :math:`\omega = c^T \dot q` with its column c. It weighs, brakes and
    rubs along :math:`L^T c`. Where it follows one coordinate alone, it rests when that rests, and
    its dry friction holds it, as much as its lever there makes of it; where it follows several, its
    dry friction has the sign of its speed.
    """

    coordinates: Array
    """Reflected inertia, viscous and dry friction at each coordinate, (n, 3)."""
    columns: Array
    """What joint velocities each drive elsewhere turns with, (nv, w)."""
    elsewhere: Array
    """Reflected inertia, viscous and dry friction of each of these, (w, 3)."""
    follows: Indices
    """The coordinate that each follows alone, or −1, (w,)."""
    joints: Indices
    """Velocities of the joints whose own dry friction is among these numbers."""


class Motors(NamedTuple):
    """What the motors of a robot drive, and where they are among its coordinates."""

    names: tuple[str, ...]
    matrix: Array
    """B, (nv, m)."""
    speeds: Indices
    """Velocity of each coordinate, (n,)."""
    base_coordinates: int
    """Coordinates of a floating base, which are the last: 7, in a plane 4, or none."""
    model: pin.Model
    followed: Indices
    """The coordinate that each joint velocity follows alone, or −1, (nv,)."""

    @property
    def are_coordinates(self) -> bool:
        """Whether each coordinate is that of a motor, in the same order."""
        n = len(self.speeds)
        return self.matrix.shape[1] == n and bool((self.matrix[self.speeds] == np.eye(n)).all())

    def without_drives(self) -> Driven:
        """Return no drives, the joints' own dry friction being left to their own forces."""
        none, n, nv = np.zeros(0, dtype=np.int64), len(self.speeds), self.model.nv
        return Driven(np.zeros((n, 3)), np.zeros((nv, 0)), np.zeros((0, 3)), none, none)

    def driven(self, drives: Array) -> Driven:
        """Return drives of motors, (m, 3), and the joints' own dry friction.

        Of joints that follow several coordinates the friction is left to the joints' own forces.
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
        """Return the coordinate that all joints of a column follow alone, or −1."""
        found = set(self.followed[np.flatnonzero(column)].tolist())
        return found.pop() if len(found) == 1 else -1


def least_norm(matrix: Array, wanted: Array, names: Sequence[str], what: str = "forces") -> Array:
    """Return the shortest motor forces (..., m) that do what is wanted, (..., k).

    Parameters
    ----------
    matrix : (..., k, m) ndarray
        What each motor does.
    wanted : (..., k) ndarray
        What they are to do together.
    names : sequence of str
        Coordinates, for the error.
    what : str
        ``"forces"`` or ``"accelerations"``.

    Raises
    ------
    UnreachableForces
        If some of it cannot be done.
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
    """Return the shortest motor forces (..., m) of accelerations of all coordinates, or the first.

    Parameters
    ----------
    actuation : (..., n, m) ndarray
        A.
    along : callable
        Forces along the coordinates (..., n) of accelerations (..., n) in this state.
    mass : callable
        The mass matrix (..., n, n) in this state, which fewer accelerations need.
    accelerations : (..., n) or (..., k) array_like
        Of the coordinates; fewer are those of the first k, and the others follow.
    names : sequence of str
        The coordinates.

    Raises
    ------
    UnreachableForces
        If the motors cannot.
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
    """Return the shortest motor forces (..., m) that accelerate the first coordinates as wanted.

    Parameters
    ----------
    mass : (..., n, n) ndarray
    bias : (..., n) ndarray
        Forces of the same motion without acceleration.
    actuation : (..., n, m) ndarray
        A.
    accelerations : (..., k) ndarray
        Of the first k coordinates; the others follow.
    names : sequence of str
        The coordinates.

    Raises
    ------
    UnreachableForces
        If the motors cannot accelerate these coordinates so.
    """
    k = accelerations.shape[-1]
    both = np.linalg.solve(mass, np.concatenate([actuation, bias[..., np.newaxis]], axis=-1))
    free, made = both[..., :k, -1], both[..., :k, :-1]
    return least_norm(made, accelerations + free, names[:k], "accelerations")
