r"""Compiled closure equations of a tree: residual, Jacobian, and acceleration due to velocities.

With :math:`R_1, p_1, R_2, p_2` the two frames of a closure, its residual is :math:`R_1^T (p_2 -
p_1)`, followed by :math:`\log R_1^T R_2` for a frame closure, or by the first two entries of
:math:`R_1^T R_2 e_z` for a hinge. The residual of a spin is a component of a ball joint's
quaternion, relative to the quaternion at which the spin is zero: the component of its vector part
along the axis. All rows are in the axes of the first frame, so they do not depend on the place of a
group's base. The Jacobian is the exact derivative, also if the loops are open.
"""

from __future__ import annotations

import math

from fuzzy2.support.compiled import scalar
from psp3.multibody.placement import compose
from psp3.multibody.tree import (
    AT_CLOSURE_FRAMES,
    AT_CLOSURES,
    AT_CONFIGURATION,
    AT_DRIVEN,
    AT_FACTORS,
    AT_FRAMES,
    AT_GROUPS,
    AT_HERE,
    AT_JOINT_SPEEDS,
    AT_PATHS,
    AT_PLACEMENTS,
    AT_RESIDUAL,
    AT_RIGHT,
    AT_SCREWS,
    AT_TURN,
    AT_VELOCITIES,
    CLOSURE_INTEGERS,
    CLOSURE_KIND,
    CLOSURE_NUMBERS,
    COUPLED_SPEED,
    COUPLING,
    DRIVEN_AT,
    ELEMENTS,
    FACTOR_AT,
    FIRST_CLOSURE,
    FIRST_END,
    FIRST_PATH,
    FIRST_ROW,
    FRAME,
    GROUP_COLUMNS,
    GROUP_DRIVERS,
    GROUP_INTEGERS,
    GROUP_ROW,
    GROUP_ROWS,
    HINGE,
    LARGEST_DEGREE,
    PATH_CLOSURE,
    PATH_COLUMN,
    PATH_INTEGERS,
    PATH_SIGN,
    PATH_VELOCITY,
    POINT,
    SECOND_END,
    SPIN,
)


@scalar
def polynomial(numbers, at, x, derivative):
    """Return the value of a polynomial, or of one of its derivatives."""
    value = 0.0
    for k in range(LARGEST_DEGREE, derivative - 1, -1):
        factor = 1.0
        for j in range(derivative):
            factor *= float(k - j)
        value = value * x + factor * numbers[at + k]
    return value


@scalar
def turned(numbers, at, memory, q, k, derivative):
    """Return the residual of a spin, or its derivative by the k-th angular velocity."""
    a, b = at + 3, q
    w = numbers[a + 3] * memory[b + 3]
    x = y = z = 0.0
    for i in range(3):
        w += numbers[a + i] * memory[b + i]
    x = (
        numbers[a + 3] * memory[b]
        - numbers[a] * memory[b + 3]
        - numbers[a + 1] * memory[b + 2]
        + numbers[a + 2] * memory[b + 1]
    )
    y = (
        numbers[a + 3] * memory[b + 1]
        - numbers[a + 1] * memory[b + 3]
        - numbers[a + 2] * memory[b]
        + numbers[a] * memory[b + 2]
    )
    z = (
        numbers[a + 3] * memory[b + 2]
        - numbers[a + 2] * memory[b + 3]
        - numbers[a] * memory[b + 1]
        + numbers[a + 1] * memory[b]
    )
    nx, ny, nz = numbers[at], numbers[at + 1], numbers[at + 2]
    if derivative == 0:
        return nx * x + ny * y + nz * z
    if k == 0:
        return 0.5 * (w * nx + ny * z - nz * y)
    if k == 1:
        return 0.5 * (w * ny + nz * x - nx * z)
    return 0.5 * (w * nz + nx * y - ny * x)


@scalar
def _spin_change(numbers, at, memory, q, v, z):
    """Return the rate, at angular velocities v, of a spin's derivative along z."""
    # The residual is n · u with the quaternion (u, w); its derivative, 0.5 (w n + n × u) · z, is
    # linear in (u, w), and these change by 0.5 (w ω + u × ω) and −0.5 u · ω. A quaternion's second
    # derivative along ω and z is −0.25 (ω · z) times itself plus 0.25 times its product with ω × z.
    n_u = turned(numbers, at, memory, q, 0, 0)
    value = (
        -0.25
        * n_u
        * (memory[v] * memory[z] + memory[v + 1] * memory[z + 1] + memory[v + 2] * memory[z + 2])
    )
    cx = memory[v + 1] * memory[z + 2] - memory[v + 2] * memory[z + 1]
    cy = memory[v + 2] * memory[z] - memory[v] * memory[z + 2]
    cz = memory[v] * memory[z + 1] - memory[v + 1] * memory[z]
    value += 0.5 * (
        turned(numbers, at, memory, q, 0, 1) * cx
        + turned(numbers, at, memory, q, 1, 1) * cy
        + turned(numbers, at, memory, q, 2, 1) * cz
    )
    return value


@scalar
def _logarithm(memory, at, row):
    """Write the rotation vector of R_1ᵀ R_2."""
    r0 = r1 = r2 = r3 = r4 = r5 = r6 = r7 = r8 = 0.0
    for k in range(3):
        a, b = at + 3 * k, at + 12 + 3 * k
        x, y, z = memory[a], memory[a + 1], memory[a + 2]
        u, v, w = memory[b], memory[b + 1], memory[b + 2]
        r0, r1, r2 = r0 + x * u, r1 + x * v, r2 + x * w
        r3, r4, r5 = r3 + y * u, r4 + y * v, r5 + y * w
        r6, r7, r8 = r6 + z * u, r7 + z * v, r8 + z * w
    x, y, z = 0.5 * (r7 - r5), 0.5 * (r2 - r6), 0.5 * (r3 - r1)
    sine = math.sqrt(x * x + y * y + z * z)
    cosine = 0.5 * (r0 + r4 + r8 - 1.0)
    angle = math.atan2(sine, cosine)
    if sine > 1e-7:
        factor = angle / sine
        memory[row], memory[row + 1], memory[row + 2] = factor * x, factor * y, factor * z
    elif cosine > 0.0:
        memory[row], memory[row + 1], memory[row + 2] = x, y, z
    else:
        # At half a turn the axis is the longest column of R + 1.
        if r0 >= r4 and r0 >= r8:
            x, y, z = r0 + 1.0, r3, r6
        elif r4 >= r8:
            x, y, z = r1, r4 + 1.0, r7
        else:
            x, y, z = r2, r5, r8 + 1.0
        factor = angle / math.sqrt(x * x + y * y + z * z)
        memory[row], memory[row + 1], memory[row + 2] = factor * x, factor * y, factor * z


@scalar
def _place_end(tree, numbers, memory, end, at, into):
    """Write the frame of a closure, whose placement in its element or the base is at ``at``."""
    if end >= 0:
        compose(memory, tree[AT_PLACEMENTS] + 12 * end, numbers, at, memory, into)
        return
    for i in range(9):
        memory[into + i] = numbers[at + i]
    for i in range(9, 12):
        memory[into + i] = numbers[at + i] - memory[tree[AT_HERE] + i - 9]


@scalar
def residual_of(tree, numbers, memory, group):
    """Write frames and residual of a group's closures; return the residual's largest entry."""
    configuration = tree[AT_CONFIGURATION]
    frames = tree[AT_FRAMES]
    closures = tree[AT_CLOSURES]
    in_elements = tree[AT_CLOSURE_FRAMES]
    g = tree[AT_GROUPS] + GROUP_INTEGERS * group
    first = tree[AT_RESIDUAL] + tree[g + GROUP_ROW]
    for closure in range(tree[g + FIRST_CLOSURE], tree[g + GROUP_INTEGERS + FIRST_CLOSURE]):
        c, f = closures + CLOSURE_INTEGERS * closure, frames + 24 * closure
        at = in_elements + CLOSURE_NUMBERS * closure
        kind, row = tree[c + CLOSURE_KIND], first + tree[c + FIRST_ROW]
        one, two = tree[c + FIRST_END], tree[c + SECOND_END]
        if kind == COUPLING:
            x = memory[configuration + two]
            memory[row] = memory[configuration + one] - polynomial(numbers, at, x, 0)
            continue
        if kind == SPIN:
            memory[row] = turned(numbers, at, memory, configuration + one, 0, 0)
            continue
        for side in range(2):
            end = one if side == 0 else two
            _place_end(tree, numbers, memory, end, at + 12 * side, f + 12 * side)
        dx, dy, dz = (
            memory[f + 21] - memory[f + 9],
            memory[f + 22] - memory[f + 10],
            memory[f + 23] - memory[f + 11],
        )
        for i in range(3):
            memory[row + i] = memory[f + i] * dx + memory[f + 3 + i] * dy + memory[f + 6 + i] * dz
        if kind == FRAME:
            _logarithm(memory, f, row + 3)
        elif kind == HINGE:
            for i in range(2):
                memory[row + 3 + i] = (
                    memory[f + i] * memory[f + 14]
                    + memory[f + 3 + i] * memory[f + 17]
                    + memory[f + 6 + i] * memory[f + 20]
                )
    largest = 0.0
    for row in range(first, first + tree[g + GROUP_ROWS]):
        size = abs(memory[row])
        # Written so that NaN counts as large.
        largest = largest if size <= largest else size
    return largest


@scalar
def _turn(memory, row, at):
    """Write the derivative of a rotation vector by the angular velocity in its own axes, (3, 3)."""
    x, y, z = memory[row], memory[row + 1], memory[row + 2]
    square = x * x + y * y + z * z
    factor = 1.0 / 12.0 + square / 720.0
    if square > 1e-4:
        angle = math.sqrt(square)
        factor = 1.0 / square - 0.5 / (angle * math.tan(0.5 * angle))
    memory[at], memory[at + 4], memory[at + 8] = (
        1.0 - factor * (y * y + z * z),
        1.0 - factor * (x * x + z * z),
        1.0 - factor * (x * x + y * y),
    )
    memory[at + 1], memory[at + 3] = factor * x * y - 0.5 * z, factor * x * y + 0.5 * z
    memory[at + 2], memory[at + 6] = factor * x * z + 0.5 * y, factor * x * z - 0.5 * y
    memory[at + 5], memory[at + 7] = factor * y * z - 0.5 * x, factor * y * z + 0.5 * x


@scalar
def jacobian(tree, numbers, memory, group):
    """Write the derivative of a group's residual by its dependent and its independent speeds.

    The pose is that of the last residual that was written.
    """
    configuration = tree[AT_CONFIGURATION]
    frames = tree[AT_FRAMES]
    screws = tree[AT_SCREWS]
    turn = tree[AT_TURN]
    closures = tree[AT_CLOSURES]
    in_elements = tree[AT_CLOSURE_FRAMES]
    paths = tree[AT_PATHS]
    g = tree[AT_GROUPS] + GROUP_INTEGERS * group
    rows, first = tree[g + GROUP_ROWS], tree[AT_RESIDUAL] + tree[g + GROUP_ROW]
    factor_at, driven_at = (
        tree[AT_FACTORS] + tree[g + FACTOR_AT],
        tree[AT_DRIVEN] + tree[g + DRIVEN_AT],
    )
    for i in range(factor_at, factor_at + rows * tree[g + GROUP_COLUMNS]):
        memory[i] = 0.0
    for i in range(driven_at, driven_at + rows * tree[g + GROUP_DRIVERS]):
        memory[i] = 0.0
    last_closure = -1
    for path in range(tree[g + FIRST_PATH], tree[g + GROUP_INTEGERS + FIRST_PATH]):
        p = paths + PATH_INTEGERS * path
        closure, column = tree[p + PATH_CLOSURE], tree[p + PATH_COLUMN]
        c, f = closures + CLOSURE_INTEGERS * closure, frames + 24 * closure
        kind, row = tree[c + CLOSURE_KIND], tree[c + FIRST_ROW]
        sign = float(tree[p + PATH_SIGN])
        k = row + (factor_at + rows * column if column >= 0 else driven_at + rows * (-1 - column))
        if kind == COUPLING:
            at = in_elements + CLOSURE_NUMBERS * closure
            x = memory[configuration + tree[c + SECOND_END]]
            memory[k] += 1.0 if sign > 0.0 else -polynomial(numbers, at, x, 1)
            continue
        if kind == SPIN:
            at = in_elements + CLOSURE_NUMBERS * closure
            q, axis = configuration + tree[c + FIRST_END], tree[p + PATH_VELOCITY]
            memory[k] += turned(numbers, at, memory, q, axis - tree[c + COUPLED_SPEED], 1)
            continue
        s = screws + 6 * tree[p + PATH_VELOCITY]
        x, y, z = memory[f + 21], memory[f + 22], memory[f + 23]
        wx, wy, wz = sign * memory[s + 3], sign * memory[s + 4], sign * memory[s + 5]
        vx = sign * memory[s] + wy * z - wz * y
        vy = sign * memory[s + 1] + wz * x - wx * z
        vz = sign * memory[s + 2] + wx * y - wy * x
        for i in range(3):
            memory[k + i] += memory[f + i] * vx + memory[f + 3 + i] * vy + memory[f + 6 + i] * vz
        if kind == POINT:
            continue
        if kind == FRAME:
            if closure != last_closure:
                _turn(memory, first + row + 3, turn)
                last_closure = closure
            ax = memory[f + 12] * wx + memory[f + 15] * wy + memory[f + 18] * wz
            ay = memory[f + 13] * wx + memory[f + 16] * wy + memory[f + 19] * wz
            az = memory[f + 14] * wx + memory[f + 17] * wy + memory[f + 20] * wz
            for i in range(3):
                memory[k + 3 + i] += (
                    memory[turn + 3 * i] * ax
                    + memory[turn + 3 * i + 1] * ay
                    + memory[turn + 3 * i + 2] * az
                )
        else:
            # Rate of the second frame's z axis, in the first frame's axes.
            x, y, z = memory[f + 14], memory[f + 17], memory[f + 20]
            ax, ay, az = wy * z - wz * y, wz * x - wx * z, wx * y - wy * x
            for i in range(2):
                memory[k + 3 + i] += (
                    memory[f + i] * ax + memory[f + 3 + i] * ay + memory[f + 6 + i] * az
                )


@scalar
def accelerated(tree, numbers, memory, group, speeds, X, rate):
    """Write the rate of change of J z in a closed group, for constant joint speeds z.

    The memory holds z at ``speeds``, the twists of all elements for z at X, and the rates of these
    twists at ``rate``. If z are the speeds of the motion itself, the result is the second
    derivative of the residual without joint accelerations.
    """
    configuration = tree[AT_CONFIGURATION]
    frames = tree[AT_FRAMES]
    joint_speeds = tree[AT_JOINT_SPEEDS]
    right = tree[AT_RIGHT]
    closures = tree[AT_CLOSURES]
    V = tree[AT_VELOCITIES]
    in_elements = tree[AT_CLOSURE_FRAMES]
    base = tree[ELEMENTS]
    g = tree[AT_GROUPS] + GROUP_INTEGERS * group
    for closure in range(tree[g + FIRST_CLOSURE], tree[g + GROUP_INTEGERS + FIRST_CLOSURE]):
        c, f = closures + CLOSURE_INTEGERS * closure, frames + 24 * closure
        kind, row = tree[c + CLOSURE_KIND], right + tree[c + FIRST_ROW]
        one, two = tree[c + FIRST_END], tree[c + SECOND_END]
        if kind == COUPLING:
            at = in_elements + CLOSURE_NUMBERS * closure
            speed = tree[c + COUPLED_SPEED]
            memory[row] = (
                -polynomial(numbers, at, memory[configuration + two], 2)
                * memory[joint_speeds + speed]
                * memory[speeds + speed]
            )
            continue
        if kind == SPIN:
            at = in_elements + CLOSURE_NUMBERS * closure
            speed = tree[c + COUPLED_SPEED]
            v = joint_speeds + speed
            memory[row] = _spin_change(numbers, at, memory, configuration + one, v, speeds + speed)
            continue
        a = 6 * (one if one >= 0 else base)
        b = 6 * (two if two >= 0 else base)
        x, y, z = memory[f + 21], memory[f + 22], memory[f + 23]
        ax = ay = az = 0.0
        for side in range(2):
            end = a if side == 0 else b
            sign = -1.0 if side == 0 else 1.0
            e, k, r = V + end, X + end, rate + end
            # Speed of the point, rotated by the field of velocities.
            vx = memory[e] + memory[e + 4] * z - memory[e + 5] * y
            vy = memory[e + 1] + memory[e + 5] * x - memory[e + 3] * z
            vz = memory[e + 2] + memory[e + 3] * y - memory[e + 4] * x
            wx, wy, wz = memory[k + 3], memory[k + 4], memory[k + 5]
            bx, by, bz = memory[r + 3], memory[r + 4], memory[r + 5]
            ax += sign * (memory[r] + by * z - bz * y + wy * vz - wz * vy)
            ay += sign * (memory[r + 1] + bz * x - bx * z + wz * vx - wx * vz)
            az += sign * (memory[r + 2] + bx * y - by * x + wx * vy - wy * vx)
        for i in range(3):
            memory[row + i] = memory[f + i] * ax + memory[f + 3 + i] * ay + memory[f + 6 + i] * az
        if kind == POINT:
            continue
        # Rate of the relative angular velocity of the two frames, as seen from the first.
        k, m, r, t = X + a, X + b, rate + a, rate + b
        a += V
        wx, wy, wz = memory[a + 3], memory[a + 4], memory[a + 5]
        ux, uy, uz = (
            memory[m + 3] - memory[k + 3],
            memory[m + 4] - memory[k + 4],
            memory[m + 5] - memory[k + 5],
        )
        ax = memory[t + 3] - memory[r + 3] - (wy * uz - wz * uy)
        ay = memory[t + 4] - memory[r + 4] - (wz * ux - wx * uz)
        az = memory[t + 5] - memory[r + 5] - (wx * uy - wy * ux)
        if kind == HINGE:
            x, y, z = memory[f + 14], memory[f + 17], memory[f + 20]
            ax, ay, az = ay * z - az * y, az * x - ax * z, ax * y - ay * x
        for i in range(3 if kind == FRAME else 2):
            memory[row + 3 + i] = (
                memory[f + i] * ax + memory[f + 3 + i] * ay + memory[f + 6 + i] * az
            )
