"""Compiled steps of computed torque on a frame, for :mod:`psp3.control.task_space`."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from fuzzy2.support.compiled import compiled
from psp3.checks import Array, Indices
from psp3.control.controller import steer
from psp3.dynamics.compiled_robot import write_forces
from psp3.multibody.closing import CLOSED
from psp3.multibody.inertia import complement
from psp3.multibody.motion import accelerate_with, move_with, place_frame, reach, write_frame
from psp3.multibody.tree import AT_ACCELERATIONS, AT_HERE, AT_ROOM, AT_VELOCITIES, INDEPENDENT

FLOOR = 0.25
"""Floor of the smallest singular value, as a share of the threshold."""

FIRST_DIFFERENCE, SECOND_DIFFERENCE = 1e-5, 1e-4
"""Steps of the finite differences for the first and second derivative of the smallest singular
value, as shares of the robot's length. A second difference loses twice the digits.
"""

MOST_SWEEPS = 30
"""Most sweeps of Jacobi's method, which needs five or six, because it converges quadratically."""

ORTHOGONAL = 4e-15
"""Two columns count as orthogonal below this cosine of their angle, a few rounding errors."""

VELOCITY, ACCELERATION, MOTION = 12, 18, 24
"""Indices where the velocity (6) and the acceleration (6) of a frame begin, after its placement
(12)."""


class TaskLaw(NamedTuple):
    """Computed torque on a frame.

    Gains ``kp`` and ``kv``; the ``threshold`` of the smallest singular value; the ``sign`` of the
    determinant at the reference; the robot's ``length`` [m]; the ``frame`` (13,), see
    :data:`psp3.multibody.motion.FRAME_NUMBERS`; ``rows`` (n,) of the task in a velocity of six
    dimensions, and whether it has a rotation, ``turns``; ``row_scales`` and ``column_scales`` (n,)
    that make the Jacobian dimensionless; ``model`` the table of the robot's tree.
    """

    kp: float
    kv: float
    threshold: float
    sign: float
    length: float
    frame: Array
    rows: Indices
    turns: bool
    row_scales: Array
    column_scales: Array
    model: Any


@compiled
def _write_motion(
    law: TaskLaw, positions: Array, speeds: Array, accelerations: Array, out: Array
) -> bool:
    """Write placement, velocity and acceleration of the frame (24,) in base axes.

    Return whether the robot can take the pose.
    """
    tree, numbers, memory = law.model.tree, law.model.numbers, law.model.memory
    if reach(tree, numbers, memory, positions) != CLOSED:
        return False
    n = int(tree[INDEPENDENT])
    # The complement takes the first vector of the scratch space.
    at, others = int(tree[AT_ROOM]) + n, int(tree[AT_ROOM]) + 2 * n
    for j in range(n):
        memory[at + j], memory[others + j] = speeds[j], accelerations[j]
    move_with(tree, memory, at)
    accelerate_with(tree, numbers, memory, others)
    place_frame(tree, memory, law.frame, 0, out, 0)
    e, here = int(law.frame[0]), int(tree[AT_HERE])
    V, A = int(tree[AT_VELOCITIES]) + 6 * e, int(tree[AT_ACCELERATIONS]) + 6 * e
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        x, y = out[9 + j], out[9 + k]
        out[VELOCITY + i] = memory[V + i] + memory[V + 3 + j] * y - memory[V + 3 + k] * x
        out[ACCELERATION + i] = memory[A + i] + memory[A + 3 + j] * y - memory[A + 3 + k] * x
        out[VELOCITY + 3 + i], out[ACCELERATION + 3 + i] = memory[V + 3 + i], memory[A + 3 + i]
    for i in range(3):
        # A term that spatial accelerations lack, because their point of reference does not move
        # with the frame.
        j, k = (i + 1) % 3, (i + 2) % 3
        turned = memory[V + 3 + j] * out[VELOCITY + k] - memory[V + 3 + k] * out[VELOCITY + j]
        out[ACCELERATION + i] += turned
        out[9 + i] += memory[here + i]
    return True


@compiled
def _write_jacobian(law: TaskLaw, columns: Array) -> None:
    """Write the scaled Jacobian of the task at the present pose, column by column (n, n)."""
    tree, n = law.model.tree, law.rows.size
    whole = np.empty(12 + 6 * n)
    complement(tree, law.model.numbers, law.model.memory, 0.0)
    write_frame(tree, law.model.memory, law.frame, 0, whole, 0)
    for j in range(n):
        for i in range(n):
            entry = whole[12 + 6 * j + law.rows[i]]
            columns[j, i] = law.row_scales[i] * entry / law.column_scales[j]


@compiled
def _product(rows: Array, i: int, j: int) -> float:
    """Return the scalar product of two rows of a matrix."""
    total = 0.0
    for k in range(rows.shape[1]):
        total += rows[i, k] * rows[j, k]
    return total


@compiled
def _turn(rows: Array, i: int, j: int, cosine: float, sine: float) -> None:
    """Rotate two rows of a matrix in their plane."""
    for k in range(rows.shape[1]):
        first, second = rows[i, k], rows[j, k]
        rows[i, k], rows[j, k] = cosine * first - sine * second, sine * first + cosine * second


@compiled
def make_orthogonal(columns: Array, right: Array) -> None:
    r"""Rotate columns (n, n), stored as rows, in place until they are orthogonal.

    The same rotations act on a unit matrix, ``right`` (n, n). The result are the singular vectors:
    columns are :math:`\sigma_j u_j`, and rows of ``right`` are :math:`v_j`. This is the one-sided
    Jacobi method, M. R. Hestenes, Inversion of matrices by biorthogonalization and related results,
    1958; small singular values keep their digits (J. Demmel and K. Veselić, Jacobi's method is more
    accurate than QR, 1992).
    """
    n = columns.shape[0]
    for i in range(n):
        for j in range(n):
            right[i, j] = 1.0 if i == j else 0.0
    for _ in range(MOST_SWEEPS):
        is_done = True
        for i in range(n - 1):
            for j in range(i + 1, n):
                a, b, c = _product(columns, i, i), _product(columns, j, j), _product(columns, i, j)
                if not abs(c) > ORTHOGONAL * math.sqrt(a) * math.sqrt(b):
                    continue
                is_done = False
                slope = (b - a) / (2.0 * c)
                tangent = math.copysign(1.0, slope) / (abs(slope) + math.hypot(1.0, slope))
                cosine = 1.0 / math.hypot(1.0, tangent)
                _turn(columns, i, j, cosine, cosine * tangent)
                _turn(right, i, j, cosine, cosine * tangent)
        if is_done:
            break


@compiled
def _sign_of_determinant(matrix: Array) -> float:
    """Return the sign of a determinant, 0 if singular; the matrix is overwritten."""
    n, sign = matrix.shape[0], 1.0
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(matrix[i, k]) > abs(matrix[best, k]):
                best = i
        if matrix[best, k] == 0.0:
            return 0.0
        if best != k:
            sign = -sign
            for j in range(n):
                matrix[k, j], matrix[best, j] = matrix[best, j], matrix[k, j]
        sign = math.copysign(sign, sign * matrix[k, k])
        for i in range(k + 1, n):
            factor = matrix[i, k] / matrix[k, k]
            for j in range(k, n):
                matrix[i, j] -= factor * matrix[k, j]
    return sign


@compiled
def _smallest(columns: Array) -> float:
    """Return the shortest of orthogonal columns: the smallest singular value."""
    least = math.inf
    for j in range(columns.shape[0]):
        # In this form NaN is passed on.
        length = math.sqrt(_product(columns, j, j))
        least = least if length >= least else length
    return least


@compiled
def _signed_smallest(law: TaskLaw, positions: Array) -> float:
    """Return the smallest singular value at positions, negative beyond the singularity.

    It is NaN if the robot cannot take the pose.
    """
    n = law.rows.size
    if reach(law.model.tree, law.model.numbers, law.model.memory, positions) != CLOSED:
        return math.nan
    columns, other = np.empty((n, n)), np.empty((n, n))
    _write_jacobian(law, columns)
    for i in range(n):
        for j in range(n):
            other[i, j] = columns[i, j]
    sign = _sign_of_determinant(other)
    make_orthogonal(columns, other)
    return law.sign * sign * _smallest(columns)


@compiled
def _moved_smallest(law: TaskLaw, positions: Array, way: Array, share: float) -> float:
    """Return the smallest singular value after a share of a scaled displacement from positions."""
    moved = np.empty(positions.size)
    for j in range(moved.size):
        moved[j] = positions[j] + share * way[j] / law.column_scales[j]
    value: float = _signed_smallest(law, moved)
    return value


@compiled
def _write_gradient(law: TaskLaw, positions: Array, gradient: Array) -> None:
    """Write the gradient of the smallest singular value by scaled positions."""
    n, step = gradient.size, FIRST_DIFFERENCE * law.length
    way = np.zeros(n)
    for j in range(n):
        way[j] = 1.0
        ahead = _moved_smallest(law, positions, way, step)
        gradient[j] = (ahead - _moved_smallest(law, positions, way, -step)) / (2.0 * step)
        way[j] = 0.0


@compiled
def _curvature(law: TaskLaw, positions: Array, speeds: Array, value: float) -> float:
    """Return the second derivative in time of the smallest singular value at scaled speeds."""
    square = 0.0
    for j in range(speeds.size):
        square += speeds[j] * speeds[j]
    if square == 0.0:
        return 0.0
    time = SECOND_DIFFERENCE * law.length / math.sqrt(square)
    ahead = _moved_smallest(law, positions, speeds, time)
    return (ahead - 2.0 * value + _moved_smallest(law, positions, speeds, -time)) / (time * time)


@compiled
def _along(gradient: Array, motion: Array) -> float:
    """Return the scalar product of two vectors."""
    total = 0.0
    for j in range(gradient.size):
        total += gradient[j] * motion[j]
    return total


@compiled
def _correct(
    law: TaskLaw, positions: Array, speeds: Array, columns: Array, right: Array, out: Array
) -> None:
    """Correct scaled accelerations to keep the smallest singular value above its floor."""
    n, epsilon, omega = out.size, law.threshold, math.sqrt(law.kp)
    gradient, scaled, direction = np.empty(n), np.empty(n), np.zeros(n)
    for j in range(n):
        scaled[j] = law.column_scales[j] * speeds[j]
    value = _signed_smallest(law, positions)
    _write_gradient(law, positions, gradient)
    height, rate = value - FLOOR * epsilon, _along(gradient, scaled)
    least = -2.0 * omega * rate - omega * omega * height
    if rate < 0.0:
        # The distance is bounded, because the braking is infinite at the floor itself, which a
        # sampled controller may reach.
        least += rate * rate / (2.0 * max(height, 0.25 * FLOOR * epsilon))
    lacking = least - _along(gradient, out) - _curvature(law, positions, scaled, value)
    if lacking <= 0.0:
        return
    for i in range(n):
        share = _along(right[i], gradient) / (_product(columns, i, i) + epsilon * epsilon)
        for j in range(n):
            direction[j] += share * right[i, j]
    x = min(max(2.0 * (1.0 - value / epsilon), 0.0), 1.0)
    size = x * x * (3.0 - 2.0 * x) * lacking / max(_along(gradient, direction), 1e-300)
    for j in range(n):
        out[j] += size * direction[j]


@compiled
def _write_accelerations(
    law: TaskLaw, positions: Array, speeds: Array, servo: Array, out: Array
) -> None:
    """Write the accelerations of the coordinates that give the frame those of the servo.

    The robot is at the positions. The frame gets the servo's accelerations as far as possible.
    """
    n, epsilon = out.size, law.threshold
    columns, right = np.empty((n, n)), np.empty((n, n))
    _write_jacobian(law, columns)
    make_orthogonal(columns, right)
    for j in range(n):
        out[j] = 0.0
    for k in range(n):
        square, share = _product(columns, k, k), 0.0
        damping = max(epsilon - square / epsilon, 0.0) if epsilon > 0.0 else 0.0
        for i in range(n):
            share += columns[k, i] * (law.row_scales[i] * servo[i])
        for j in range(n):
            out[j] += right[k, j] * (share / (square + damping * damping))
    if _smallest(columns) < epsilon:
        _correct(law, positions, speeds, columns, right, out)
    for j in range(n):
        out[j] /= law.column_scales[j]


@compiled
def write_rotation_between(wanted: Array, found: Array, out: Array, o: int) -> None:
    r"""Write the remaining rotation :math:`\log (R_d R^\top)` (3,), from entry o on.

    Both arguments begin with their rotations, row by row. The computation is by the quaternion and
    starts with its largest entry, so angles up to a half turn keep their digits.
    """
    turn = np.empty(9)
    for i in range(3):
        for j in range(3):
            total = 0.0
            for k in range(3):
                total += wanted[3 * i + k] * found[3 * j + k]
            turn[3 * i + j] = total
    trace = turn[0] + turn[4] + turn[8]
    x, y, z = turn[7] - turn[5], turn[2] - turn[6], turn[3] - turn[1]
    w = 1.0 + trace
    if trace < 0.0:
        if turn[0] >= turn[4] and turn[0] >= turn[8]:
            w, x, y, z = x, 1.0 + turn[0] - turn[4] - turn[8], turn[1] + turn[3], turn[2] + turn[6]
        elif turn[4] >= turn[8]:
            w, x, y, z = y, turn[1] + turn[3], 1.0 + turn[4] - turn[0] - turn[8], turn[5] + turn[7]
        else:
            w, x, y, z = z, turn[2] + turn[6], turn[5] + turn[7], 1.0 + turn[8] - turn[0] - turn[4]
    length = math.sqrt(x * x + y * y + z * z)
    # Of the two quaternions of a rotation, this is the one of the smaller angle.
    angle = 2.0 * math.atan2(math.copysign(length, w), abs(w))
    share = angle / length if length != 0.0 else 0.0
    out[o], out[o + 1], out[o + 2] = share * x, share * y, share * z


@compiled
def _write_servo(law: TaskLaw, goal: Array, now: Array, servo: Array) -> None:
    """Write the servo's accelerations of the task, minus those caused by the joints' speeds."""
    error = np.empty(6)
    for i in range(3):
        error[i] = goal[9 + i] - now[9 + i]
    if law.turns:
        write_rotation_between(goal, now, error, 3)
    for i in range(servo.size):
        row = int(law.rows[i])
        rate = goal[VELOCITY + row] - now[VELOCITY + row]
        wanted = goal[ACCELERATION + row] + law.kv * rate + law.kp * error[row]
        servo[i] = wanted - now[ACCELERATION + row]


@steer.register(TaskLaw)
@compiled
def task_space_step(
    law: TaskLaw,
    sample: int,
    t: float,
    positions: Array,
    speeds: Array,
    desired: Array,
    out: Array,
) -> bool:
    """Write the forces (m,) of computed torque on a frame; return whether they are finite."""
    n = speeds.size
    goal, now, servo, still = np.empty(MOTION), np.empty(MOTION), np.empty(n), np.zeros(n)
    accelerations = np.empty(n)
    there = _write_motion(law, desired[:n], desired[n : 2 * n], desired[2 * n :], goal)
    if not (there and _write_motion(law, positions, speeds, still, now)):
        out[:] = math.nan
        return False
    _write_servo(law, goal, now, servo)
    _write_accelerations(law, positions, speeds, servo, accelerations)
    if not write_forces(law.model, positions, speeds, accelerations, out):
        out[:] = math.nan
        return False
    total = 0.0
    for j in range(out.size):
        total += out[j]
    return math.isfinite(total)
