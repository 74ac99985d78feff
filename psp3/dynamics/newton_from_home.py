r"""Close loops as in the thesis (eq. 3.15): by iteration, starting at home.

The actuated joints move from home to the wanted positions in short steps. Each step predicts the
other joints with L (eq. 3.16) and corrects them with Newton's method,

.. math:: q^u \leftarrow q^u - (\Phi^u)^{-1} \phi(q),

so that the assembly mode stays that of home. The thesis does not state the path from home to the
goal. For the 3-PSP, an iteration without intermediate steps is enough. For a Delta it finds other
assembly modes, or none.

This module shares no code with the compiled closure that :class:`psp3.ClosedLoopRobot` uses, nor
with the closed form of the 3-PSP. The caller provides constraints, Jacobian and complement: the
natural orthogonal complement its own, and :mod:`psp3.dynamics.projected` those of Pinocchio.
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
"""The largest predicted motion of a joint in one step [m, rad]."""

LARGEST_CORRECTION = 0.3
"""The largest correction of a joint by Newton's method, as a share of the step. A larger one could
lead to another assembly mode.
"""

LARGEST_REPAIR = 1.0
"""Home is refused if a joint must move by more than this to close the loops [m, rad]."""

ON_THE_WAY = 1e-7
"""Residual at which the next step is taken [m, rad]; only the last closure is exact."""

CLOSED = 1e-11
"""Residual that the last closure must reach [m, rad]; Newton's method usually ends at 1e-16."""

LAST_CORRECTION = 1e-8
"""Newton's method ends after a correction below this [m, rad]. The remaining error is its square,
which is rounding.
"""

LARGEST_SHARE = 10.0
"""At other poses, rounded loops may stay open by this many times the residual near home."""

MOST_CORRECTIONS = 25
"""If a predicted configuration needs more corrections than this, it is not near a closed one."""

SHORTEST_STEP = 1e-6
"""The motion stops if a step must be shorter than this share of the way."""

MOST_STEPS = 2000
"""The largest number of steps. No motion of a robot needs more."""


class Closed(NamedTuple):
    """A closed configuration, with the matrices that were computed there."""

    q: Array
    """Joint positions, (nq,)."""
    jacobian: Array
    """Constraint Jacobian, (m, nv)."""
    complement: Array
    """L, (nv, n)."""
    inverse: Array
    """The inverse of the Jacobian's un-actuated columns, (nv − n, m)."""


class NewtonFromHome:
    """Newton's method with given constraints, from home in short steps.

    Parameters
    ----------
    model : pinocchio.Model
        The tree.
    names : sequence of str
        Its actuated joints, of one coordinate each, in the order of the positions.
    home : (nq,) ndarray
        Configuration to start from (eq. 3.15). It need only nearly close the loops.
    constraint : callable
        The residual of the loops, (m,), and its derivative, (m, nv), at a configuration (nq,). If
        the loops are open, the error of the derivative may be as large as the residual.
    complement : callable
        Returns L, (nv, n), and the inverse of the derivative's un-actuated columns, (nv − n, m),
        from a closed configuration and the derivative there.
    dependent : (u,) ndarray of int, optional
        Velocities of the dependent joints; all but the actuated ones by default.
    mismatch : float
        Smallest residual of rounded loops [m, rad].
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

        The last call of ``constraint`` was at this configuration.

        Raises
        ------
        ClosureFailed
            If the way from home ends earlier, at the border of the workspace or at a singularity.
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
            # The end is copied, so that it has no rounding error.
            predicted[self._places] = positions if goal == 1.0 else start + goal * way
            found = self._next(at, predicted, (goal - done) * fastest, goal == 1.0)
            if found is None:
                step = 0.5 * (goal - done)
                continue
            if goal == 1.0:
                return found
            at, done, step = found, goal, 2.0 * (goal - done)
        # The residual if only the motors moved on.
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
        # The determinant has the other sign beyond a fold, and on the other branch before the fold.
        if np.linalg.det(at.inverse @ jacobian[:, self._dependent]) <= 0.0:
            return None
        return Closed(q, jacobian, complement, inverse)

    def _corrected(self, q: Array, exactly: bool) -> tuple[Array, float, float, Array]:
        """Return the configuration that Newton's method finds by moving un-actuated joints only.

        Also return the residual, the largest total motion of a joint, and the Jacobian. The
        iteration stops if the residual is small enough for the next step or, for an exact answer,
        if a correction is small.
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

    It is found by elimination. If that fails, or would move a joint by more than is allowed,
    singular values are used and the small ones are omitted. (The normal equations lose digits,
    which the next correction recovers.)
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
