"""Find a first closed configuration of a robot whose file leaves its loops slightly open."""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np
import pinocchio as pin

from psp3.checks import Array, checked_kind, one_row
from psp3.errors import ClosureFailed
from psp3.multibody.closing import LARGEST_REPAIR
from psp3.multibody.first_answers import first_answer
from psp3.multibody.flatten import FlatTree
from psp3.multibody.motion import EQUATIONS
from psp3.multibody.tree import COORDINATES, ROWS, SIZE, VELOCITIES

NONE = np.empty(0)

ASSEMBLED = 1e-9
"""Residual at which the exact closure takes over a first configuration [m, rad]."""

MOST_EVALUATIONS = 100
"""The largest number of evaluations of the equations from one start. If the loops can be closed, 10
to 50 are enough; along a valley that ends open, the search would not end.
"""


class _TimeIsUp(Exception):
    """Leaves SciPy's search, which cannot be stopped in another way."""


def residual(flat: FlatTree, q: Array) -> Array:
    """Return the residuals of all closures at a configuration [m, rad].

    In the order of the groups.
    """
    checked_kind("flat", flat, FlatTree, "a tree, as flattened returns it")
    return _equations(flat, one_row("q", q, int(flat.integers[COORDINATES])), 0)[0]


def jacobian(flat: FlatTree, q: Array) -> Array:
    """Return the derivative of all residuals by all dependent joints, (m, nv).

    In the order of the groups.
    """
    return _equations(flat, q, int(flat.integers[ROWS]))[1]


def _equations(flat: FlatTree, q: Array, rows: int) -> tuple[Array, Array]:
    size, velocities = int(flat.integers[ROWS]), int(flat.integers[VELOCITIES])
    memory, out, none = np.empty(int(flat.integers[SIZE])), np.empty(size + rows * velocities), NONE
    at, tree, numbers = np.array(q, dtype=float), flat.integers, flat.numbers
    first_answer(EQUATIONS, 1, 1, 0, tree, numbers, none, none, memory, at, none, none, out)
    return out[:size], out[size:].reshape(rows, velocities)


def assembled(model: pin.Model, flat: FlatTree, q0: Array) -> Array:
    """Return a configuration near ``q0``, within the joint limits, that closes the loops.

    All joints move, including the actuated ones.

    Newton's method with the shortest steps is enough near a closed configuration. Otherwise SciPy's
    trust-region least squares minimizes the residual, from ``q0`` and then from up to 30 random
    configurations around it.

    Parameters
    ----------
    model : pinocchio.Model
        The tree.
    flat : FlatTree
        The tree and its loops, flattened without motors.
    q0 : (nq,) ndarray
        Where to start.

    Returns
    -------
    (nq,) ndarray
        Closed to about 1e-9; the exact closure does the rest.

    Raises
    ------
    ClosureFailed
        If no start leads to a closed configuration.
    """
    checked_kind("model", model, pin.Model, "a pinocchio.Model")
    q0 = one_row("q0", q0, model.nq)
    lower, upper = _tangent_limits(model, q0)
    nearest = by_short_steps(model, flat, q0)
    if nearest is not None:
        way = pin.difference(model, q0, nearest)
        if (lower <= way).all() and (way <= upper).all():
            return nearest
    least = np.inf
    for q, size in nearly_closed(model, flat, q0):
        least = min(least, size)
        if size < ASSEMBLED:
            return q
    raise ClosureFailed(q0, least, 0.0)


def nearly_closed(
    model: pin.Model, flat: FlatTree, q0: Array, deadline: float = np.inf
) -> Iterator[tuple[Array, float]]:
    """Yield configurations with the smallest residuals, each with its residual [m, rad].

    SciPy's trust-region least squares finds them within the joint limits, from ``q0`` and then from
    30 random configurations around it. The search ends early at a deadline, in CPU time of the
    process [s].
    """
    # Imported here, because most robots never need it.
    from scipy.optimize import least_squares

    lower, upper = _tangent_limits(model, q0)
    rng = np.random.default_rng(0)

    def open_by(step: Array) -> Array:
        if time.process_time() > deadline:
            raise _TimeIsUp
        return residual(flat, pin.integrate(model, q0, step))

    def slope(step: Array) -> Array:
        q = pin.integrate(model, q0, step)
        return np.asarray(jacobian(flat, q) @ pin.dIntegrate(model, q0, step)[1])

    for attempt in range(31):
        spread = 0.0 if attempt == 0 else 0.1 * attempt
        # The library requires a start strictly inside the limits.
        inside = 1e-6 * np.minimum(upper - lower, 1.0)
        start = np.clip(spread * rng.uniform(-1.0, 1.0, model.nv), lower + inside, upper - inside)
        try:
            solution = least_squares(
                open_by,
                start,
                jac=slope,
                bounds=(lower, upper),
                xtol=1e-15,
                ftol=1e-15,
                gtol=1e-15,
                max_nfev=MOST_EVALUATIONS,
            )
        except _TimeIsUp:
            return
        yield (
            np.asarray(pin.integrate(model, q0, solution.x)),
            float(np.abs(solution.fun).max(initial=0.0)),
        )


def by_short_steps(model: pin.Model, flat: FlatTree, q: Array) -> Array | None:
    """Return the configuration that Newton's method finds, or None if it is too far away.

    It uses the shortest steps. The greatest distance is that by which a guess may be off.
    """
    moved = np.zeros(model.nv)
    for _ in range(20):
        gap = residual(flat, q)
        if np.abs(gap).max(initial=0.0) < ASSEMBLED:
            return q
        step = -np.linalg.lstsq(jacobian(flat, q), gap, rcond=1e-9)[0]
        moved += np.abs(step)
        if not moved.max() <= LARGEST_REPAIR:
            return None
        q = pin.integrate(model, q, step)
    return None


def _tangent_limits(model: pin.Model, q0: Array) -> tuple[Array, Array]:
    """Return how far each degree of freedom may move from q0 before it reaches a limit.

    The distance is infinite without a limit.
    """
    lower, upper = np.full(model.nv, -np.inf), np.full(model.nv, np.inf)
    for joint in list(model.joints)[1:]:
        if joint.nq != joint.nv:
            continue
        q, v = (
            slice(joint.idx_q, joint.idx_q + joint.nq),
            slice(joint.idx_v, joint.idx_v + joint.nv),
        )
        low, high = model.lowerPositionLimit[q] - q0[q], model.upperPositionLimit[q] - q0[q]
        # Pinocchio's placeholder for no limit is the largest floating-point number. A start beyond
        # a limit is allowed.
        lower[v] = np.where(low < -1e100, -np.inf, np.minimum(low, -1e-3))
        upper[v] = np.where(high > 1e100, np.inf, np.maximum(high, 1e-3))
    return lower, upper
