r"""Loops closed as the thesis closes them (eq. 3.15): by iteration, starting at home.

The actuated joints are taken from home to where they are wanted in short steps. Each step predicts
the other joints with L (eq. 3.16) and corrects them by Newton's method,

.. math:: q^u \leftarrow q^u - (\Phi^u)^{-1} \phi(q),

so that the assembly mode stays that of home. The thesis does not say how it gets from home to its
goal. One iteration without steps in between is enough for the 3-PSP, but of a Delta it finds other
assembly modes, or none.

Nothing here is shared with the compiled closure of :mod:`psp3.closure` that
:class:`psp3.ClosedLoopRobot` uses, nor with the closed form of the 3-PSP: constraints, Jacobian and
complement are those that it is given. The natural orthogonal complement gives its own, and
:mod:`psp3.dynamics.projected` those of Pinocchio.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from scipy.linalg.lapack import dgesv

from psp3.checks import Array, Indices
from psp3.closure.rank import RANK_TOLERANCE
from psp3.errors import ClosureFailed, InvalidValue, SingularConfiguration

LONGEST_STEP = 0.25
"""No joint is predicted to move by more than this in one step [m, rad]."""

LARGEST_CORRECTION = 0.3
"""Newton's method may move a joint by this share of the step; more could be another assembly mode.
"""

LARGEST_REPAIR = 1.0
"""Home is none if its loops close only after a joint has moved by more than this [m, rad]."""

ON_THE_WAY = 1e-7
"""Residual with which the next step is taken [m, rad]; only the last closure is exact."""

CLOSED = 1e-11
"""Residual that the last closure must reach [m, rad]; Newton's method usually ends at 1e-16."""

LAST_CORRECTION = 1e-8
"""Newton's method ends after a correction below this: it leaves the square of that, which is
rounding [m, rad].
"""

LARGEST_SHARE = 10.0
"""Elsewhere rounded loops may stay open by so many times what was found near home."""

MOST_CORRECTIONS = 25
"""A predicted configuration that needs more corrections than this is not near a closed one."""

SHORTEST_STEP = 1e-6
"""The way ends where this share of it is still too long a step."""

MOST_STEPS = 2000
"""A way of more steps is none that a robot goes."""


class Closed(NamedTuple):
    """A closed configuration, and what was found on the way there."""

    q: Array
    """Joint positions, (nq,)."""
    jacobian: Array
    """Constraint Jacobian, (m, nv)."""
    complement: Array
    """L, (nv, n)."""
    inverse: Array
    """The inverse of the Jacobian's un-actuated columns, (nv − n, m)."""


class NewtonFromHome:
    """Newton's method on given constraints, from home in short steps.

    Parameters
    ----------
    model : pinocchio.Model
        The tree.
    names : sequence of str
        Its actuated joints, of one coordinate each, in the order of the positions.
    home : (nq,) ndarray
        Configuration to start from (eq. 3.15). It need only nearly close the loops.
    constraint : callable
        The residual of the loops, (m,), and its derivative, (m, nv), at a configuration (nq,). Away
        from closure the derivative may be wrong by as much as the residual is off.
    complement : callable
        At a closed configuration, given with that derivative, L, (nv, n), and the inverse of the
        derivative's un-actuated columns, (nv − n, m).
    dependent : (u,) ndarray of int, optional
        Velocities of the joints that follow; all but the actuated ones by default.
    mismatch : float
        Residual that rounded loops keep where they are closed best [m, rad].
    may_float : bool
        Whether the last joint may be a floating base, which no loop contains.
    """

    def __init__(
        self,
        model: pin.Model,
        names: Sequence[str],
        home: Array,
        constraint: Callable[[Array], tuple[Array, Array]],
        complement: Callable[[Array, Array], tuple[Array, Array]],
        dependent: Indices | None = None,
        mismatch: float = 0.0,
        may_float: bool = False,
    ) -> None:
        self._model = model
        self._mismatch = LARGEST_SHARE * mismatch
        joints = [model.joints[model.getJointId(name)] for name in names]
        base = joints.pop() if may_float and joints and joints[-1].nq > joints[-1].nv > 1 else None
        for name, joint in zip(names, joints, strict=False):
            if joint.nq != 1:
                raise InvalidValue("actuated joint", name, "a joint of one coordinate")
        first, count = (0, 0) if base is None else (base.idx_q, base.nq)
        self._base: Indices = np.arange(first, first + count)
        self._places = np.array([joint.idx_q for joint in joints], dtype=np.int64)
        speeds = [joint.idx_v for joint in joints]
        if base is not None:
            speeds += range(base.idx_v, base.idx_v + base.nv)
        others = np.setdiff1d(np.arange(model.nv), speeds)
        self._dependent = others if dependent is None else dependent
        self._constraint, self._complement = constraint, complement
        q, residual, moved, jacobian = self._corrected(home, exactly=True)
        if not residual <= CLOSED + self._mismatch or not moved <= LARGEST_REPAIR:
            raise ClosureFailed(home[self._places], residual, 0.0)
        self._home = Closed(q, jacobian, *self._complement(q, jacobian))

    def closed(self, positions: Array) -> Closed:
        """Return the closed configuration at actuated positions (n,).

        It is also the last one at which the constraint was asked for.

        Raises
        ------
        ClosureFailed
            If the way from home ends before: at the border of the workspace, or at a singularity.
        """
        at, start = self._home, self._home.q[self._places]
        positions, base = positions[: len(start)], positions[len(start) :]
        if base.size:
            q = at.q.copy()
            q[self._base] = base
            _, jacobian = self._constraint(q)
            at = Closed(q, jacobian, *self._complement(q, jacobian))
        way, done, step = positions - start, 0.0, 1.0
        for _ in range(MOST_STEPS):
            velocity = at.complement[:, : len(way)] @ way
            fastest = float(np.abs(velocity).max(initial=0.0))
            step = min(step, LONGEST_STEP / max(fastest, LONGEST_STEP))
            if step < SHORTEST_STEP:
                break
            goal = 1.0 if done + step > 1.0 - 1e-12 else done + step
            predicted = pin.integrate(self._model, at.q, (goal - done) * velocity)
            # Exactly the positions asked for, at the end.
            predicted[self._places] = positions if goal == 1.0 else start + goal * way
            found = self._next(at, predicted, (goal - done) * fastest, goal == 1.0)
            if found is None:
                step = 0.5 * (goal - done)
                continue
            if goal == 1.0:
                return found
            at, done, step = found, goal, 2.0 * (goal - done)
        # How far apart the frames would be if only the motors went on.
        stretched = at.q.copy()
        stretched[self._places] = positions
        raise ClosureFailed(positions, _size(self._constraint(stretched)[0]), done)

    def _next(self, at: Closed, predicted: Array, length: float, last: bool) -> Closed | None:
        """Return the closed configuration near a predicted one, or None if the step is too long."""
        q, residual, moved, jacobian = self._corrected(predicted, exactly=last)
        if not residual <= (CLOSED if last else ON_THE_WAY) + self._mismatch:
            return None
        if not moved <= LARGEST_CORRECTION * length + LAST_CORRECTION:
            return None
        try:
            complement, inverse = self._complement(q, jacobian)
        except SingularConfiguration:
            return None
        # Beyond a fold, and on the other branch before it, the determinant has the other sign.
        if np.linalg.det(at.inverse @ jacobian[:, self._dependent]) <= 0.0:
            return None
        return Closed(q, jacobian, complement, inverse)

    def _corrected(self, q: Array, exactly: bool) -> tuple[Array, float, float, Array]:
        """Return where Newton's method leads, moving the un-actuated joints only.

        With the residual there, how far a joint was moved in all, and the Jacobian there. It stops
        where the residual is small enough to go on or, for an exact answer, where a correction is
        small.
        """
        residual, jacobian = self._constraint(q)
        moved = np.zeros(self._model.nv)
        for _ in range(MOST_CORRECTIONS if self._dependent.size else 0):
            if not exactly and _size(residual) <= ON_THE_WAY:
                break
            correction = np.zeros(self._model.nv)
            correction[self._dependent] = -_least_squares(jacobian[:, self._dependent], residual)
            moved += correction
            q = pin.integrate(self._model, q, correction)
            residual, jacobian = self._constraint(q)
            if _size(correction) <= LAST_CORRECTION or not _size(moved) <= LARGEST_REPAIR:
                break
        return q, _size(residual), _size(moved), jacobian


def _least_squares(slope: Array, residual: Array) -> Array:
    """Return the shortest x for which slope x is nearest to the residual.

    By elimination; where that fails, or wants to move a joint by more than is allowed, by singular
    values, of which the small ones are left out. (The normal equations lose digits, which the next
    correction brings back.)
    """
    rows, columns = slope.shape
    if rows >= columns:
        square, right = (
            (slope, residual) if rows == columns else (slope.T @ slope, slope.T @ residual)
        )
        _, _, solution, failed = dgesv(square, right)
        if not failed and _size(solution) <= LARGEST_REPAIR:
            return np.asarray(solution)
    return np.asarray(np.linalg.lstsq(slope, residual, rcond=RANK_TOLERANCE)[0])


def _size(values: Array) -> float:
    return float(np.maximum.reduce(np.abs(values), axis=None, initial=0.0))
