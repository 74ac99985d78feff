r"""Compiled closed form of the 3-PSP robot's kinematics and dynamics.

Everything follows from three coordinates that are *linear* in the nut heights: the slope
:math:`p = u + iv = \tan\theta\, e^{i\beta}` of the star (tilt :math:`\theta` toward azimuth
:math:`\beta`) and the mean height,

.. math::

    u + iv = -\frac{2}{3d} \sum_k a_k e^{i\alpha_k}, \qquad \bar a = \frac13 \sum_k a_k, \qquad
    c = \cos\theta = (1 + u^2 + v^2)^{-1/2}.

The star's arms meet at 120° in the plane of the three nuts, so its center is the Fermat point of
the nut triangle, and

.. math::

    C_x + iC_y &= \tfrac d4 \Big[ \tfrac{c^3}{(1+c)^2} p^4 - c\, \bar p^2 \Big], \qquad
    C_z = \bar a + \tfrac d2 \tfrac{c^2}{1+c} \operatorname{Re} p^3, \\
    b_k &= \tfrac{d}{2c} \Big[ 1 + c
    + \tfrac{2c^2}{1+c} \operatorname{Re}(p^2 e^{i\alpha_k}) \Big], \qquad n = c\,(u, v, 1),

where :math:`n` is the star's own axis and its rotation is the shortest one that takes :math:`e_z`
to :math:`n`. No angle is evaluated anywhere, so nothing is singular at the level pose. The change
of coordinates is linear, so the mass matrix and the Coriolis matrix transform like tensors, without
additional terms.

Kernels take flat, contiguous arrays of ``n`` rows and write to a flat array. They return -1, or the
first row that is not finite or whose arm lengths are not all positive. Users call
:mod:`psp3.three_psp.robot`.
"""

from __future__ import annotations

import math

from fuzzy2.support.compiled import compiled, inlined
from psp3.checks import Array
from psp3.three_psp.geometry import LARGEST_TIP_SLOPE

HALF_SQRT3 = 0.8660254037844386

MOST_TIP_STEPS = 1000
"""The largest number of steps of the tip's inverse kinematics along the ray; near its fold it needs
about sixty.
"""

MOST_TIP_ITERATIONS = 40
"""The largest number of Newton steps in each of these."""

SMALLEST_TIP_STEP = 1e-9
"""A point counts as beyond the fold if a step must be shorter than this share of the ray."""

TIP_ROUNDING = 1e-16
"""Rounding of the tip's position, per meter of radius and tool."""

# Columns of the parameter array, see Parameters.as_array.
(
    RADIUS,
    TOOL,
    SLIDING_MASS,
    STAR_MASS,
    STAR_X,
    STAR_Y,
    STAR_Z,
    PHI_INERTIA,
    THETA_INERTIA,
    GRAVITY,
) = range(10)


@inlined
def slope_of_nuts(a1, a2, a3, d):
    """Slope (u, v) and mean height of the plane through the nuts."""
    factor = -2.0 / (3.0 * d)
    return factor * (a1 - 0.5 * (a2 + a3)), factor * HALF_SQRT3 * (a2 - a3), (a1 + a2 + a3) / 3.0


@inlined
def cosine_of_tilt(u, v):
    """Cosine of the tilt, c, and k = c²/(1+c).

    The latter is (1 − c)/(u² + v²) without the division 0/0.
    """
    c = 1.0 / math.sqrt(1.0 + u * u + v * v)
    return c, c * c / (1.0 + c)


@compiled
def _center(u, v, c, k, d):
    """Star center relative to (0, 0, mean height)."""
    p2x, p2y = u * u - v * v, 2.0 * u * v
    k4 = 0.25 * d * k * c / (1.0 + c)
    return (
        k4 * (p2x * p2x - p2y * p2y) - 0.25 * d * c * p2x,
        2.0 * k4 * p2x * p2y + 0.25 * d * c * p2y,
        0.5 * d * k * (u * p2x - v * p2y),
    )


@inlined
def _arms(u, v, c, k, d):
    """Arm lengths b_1, b_2, b_3."""
    p2x, p2y = u * u - v * v, 2.0 * u * v
    scale = 0.5 * d / c
    return (
        scale * (1.0 + c + 2.0 * k * p2x),
        scale * (1.0 + c + 2.0 * k * (-0.5 * p2x - HALF_SQRT3 * p2y)),
        scale * (1.0 + c + 2.0 * k * (-0.5 * p2x + HALF_SQRT3 * p2y)),
    )


@inlined
def is_valid_pose(u, v, c, k, d):
    """Whether the slope is finite and all three arm lengths are positive."""
    b1, b2, b3 = _arms(u, v, c, k, d)
    return b1 > 0.0 and b2 > 0.0 and b3 > 0.0 and b1 + b2 + b3 < math.inf


@inlined
def are_finite(x, y, z):
    """Whether three numbers are finite."""
    return math.isfinite(x) and math.isfinite(y) and math.isfinite(z)


@compiled
def is_finite(array, i):
    """Whether three numbers from ``i`` on are finite."""
    return are_finite(array[i], array[i + 1], array[i + 2])


@inlined
def _term(f, f1, f2, u, v, q, qu, qv, quu, quv, qvv):
    """Value, gradient and second derivatives of f(u² + v²) q(u, v).

    The arguments are f, f', f'' and those of q.
    """
    fu, fv = 2.0 * u * f1, 2.0 * v * f1
    fuu, fuv, fvv = 2.0 * f1 + 4.0 * u * u * f2, 4.0 * u * v * f2, 2.0 * f1 + 4.0 * v * v * f2
    return (
        fu * q + f * qu,
        fv * q + f * qv,
        fuu * q + 2.0 * fu * qu + f * quu,
        fuv * q + fu * qv + fv * qu + f * quv,
        fvv * q + 2.0 * fv * qv + f * qvv,
    )


@inlined
def _center_derivatives(u, v, c, d):
    """Return the derivatives (u, v, uu, uv, vv) of the star center's three coordinates."""
    # c, c^3/(1+c)^2 and c^2/(1+c) with their first and second derivatives with respect to u² + v².
    square = c * c
    c1, c2 = -0.5 * (c * square), 0.75 * (c * (square * square))
    # There is only one division by 1 + c, because divisions take most of the time.
    w = 1.0 / (1.0 + c)
    ww = w * w
    g = c * square * ww
    g_c, g_cc = c * c * (3.0 + c) * (ww * w), 6.0 * c * (ww * ww)
    k = c * c * w
    k_c, k_cc = (2.0 * c + c * c) * ww, 2.0 * (ww * w)
    g1, g2 = g_c * c1, g_cc * c1 * c1 + g_c * c2
    k1, k2 = k_c * c1, k_cc * c1 * c1 + k_c * c2

    uu, vv, uv = u * u, v * v, u * v
    # Re p^4, Im p^4, Re p^3 and their derivatives; those of Re p^2 and Im p^2 are written out
    # below.
    x4 = _term(
        g,
        g1,
        g2,
        u,
        v,
        uu * uu - 6.0 * uu * vv + vv * vv,
        4.0 * u * (uu - 3.0 * vv),
        -4.0 * v * (3.0 * uu - vv),
        12.0 * (uu - vv),
        -24.0 * uv,
        -12.0 * (uu - vv),
    )
    y4 = _term(
        g,
        g1,
        g2,
        u,
        v,
        4.0 * uv * (uu - vv),
        4.0 * v * (3.0 * uu - vv),
        4.0 * u * (uu - 3.0 * vv),
        24.0 * uv,
        12.0 * (uu - vv),
        -24.0 * uv,
    )
    x2 = _term(c, c1, c2, u, v, uu - vv, 2.0 * u, -2.0 * v, 2.0, 0.0, -2.0)
    y2 = _term(c, c1, c2, u, v, 2.0 * uv, 2.0 * v, 2.0 * u, 0.0, 2.0, 0.0)
    z3 = _term(
        k,
        k1,
        k2,
        u,
        v,
        u * (uu - 3.0 * vv),
        3.0 * (uu - vv),
        -6.0 * uv,
        6.0 * u,
        -6.0 * v,
        -6.0 * u,
    )
    q, h = 0.25 * d, 0.5 * d
    x = (
        q * (x4[0] - x2[0]),
        q * (x4[1] - x2[1]),
        q * (x4[2] - x2[2]),
        q * (x4[3] - x2[3]),
        q * (x4[4] - x2[4]),
    )
    y = (
        q * (y4[0] + y2[0]),
        q * (y4[1] + y2[1]),
        q * (y4[2] + y2[2]),
        q * (y4[3] + y2[3]),
        q * (y4[4] + y2[4]),
    )
    z = (h * z3[0], h * z3[1], h * z3[2], h * z3[3], h * z3[4])
    return x, y, z


@compiled
def _tip_derivatives(u, v, c, d, h):
    """Return the derivatives (u, v, uu, uv, vv) of the tip's three coordinates.

    They are those of the center plus h n.
    """
    x, y, z = _center_derivatives(u, v, c, d)
    square = c * c
    c1, c2 = -0.5 * (c * square), 0.75 * (c * (square * square))
    nx = _term(c, c1, c2, u, v, u, 1.0, 0.0, 0.0, 0.0, 0.0)
    ny = _term(c, c1, c2, u, v, v, 0.0, 1.0, 0.0, 0.0, 0.0)
    nz = _term(c, c1, c2, u, v, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return (
        (x[0] + h * nx[0], x[1] + h * nx[1], x[2] + h * nx[2], x[3] + h * nx[3], x[4] + h * nx[4]),
        (y[0] + h * ny[0], y[1] + h * ny[1], y[2] + h * ny[2], y[3] + h * ny[3], y[4] + h * ny[4]),
        (z[0] + h * nz[0], z[1] + h * nz[1], z[2] + h * nz[2], z[3] + h * nz[3], z[4] + h * nz[4]),
    )


@inlined
def _reduced(u, v, c, k, du, dv, p):
    """Mass and Coriolis matrix of the star and the ball bodies' rotations.

    In the coordinates (u, v, mean height).

    Returns the six entries of the mass matrix (uu, uv, vv, uz, vz, zz) and the Coriolis matrix's
    six (uu, uv, vu, vv, zu, zv); its third column is zero. Each rotation enters as in eq. 3.3, W'
    (I (dW/dt + w x W) + w x I W), in axes fixed to the body.
    """
    d, m = p[RADIUS], p[STAR_MASS]
    x, y, z = _center_derivatives(u, v, c, d)
    # Time derivatives of the center's Jacobian.
    xu, xv = x[2] * du + x[3] * dv, x[3] * du + x[4] * dv
    yu, yv = y[2] * du + y[3] * dv, y[3] * du + y[4] * dv
    zu, zv = z[2] * du + z[3] * dv, z[3] * du + z[4] * dv
    m_uu = m * (x[0] * x[0] + y[0] * y[0] + z[0] * z[0])
    m_uv = m * (x[0] * x[1] + y[0] * y[1] + z[0] * z[1])
    m_vv = m * (x[1] * x[1] + y[1] * y[1] + z[1] * z[1])
    c_uu = m * (x[0] * xu + y[0] * yu + z[0] * zu)
    c_uv = m * (x[0] * xv + y[0] * yv + z[0] * zv)
    c_vu = m * (x[1] * xu + y[1] * yu + z[1] * zu)
    c_vv = m * (x[1] * xv + y[1] * yv + z[1] * zv)

    # Angular velocity in star axes, W (du, dv): for the shortest rotation it differs from that in
    # base axes by the sign of z.
    ix, iy, iz = p[STAR_X], p[STAR_Y], p[STAR_Z]
    rate = u * du + v * dv
    dc = -(c * c * c) * rate
    w = 1.0 / (1.0 + c)
    dk = (2.0 * c + c * c) * (w * w) * dc
    s, ds = c * k, dc * k + c * dk
    wxu, wxv = s * u * v, -c + s * v * v
    wyu, wyv = c - s * u * u, -s * u * v
    wzu, wzv = k * v, -k * u
    duv = du * v + u * dv
    dwxu, dwxv = ds * u * v + s * duv, -dc + ds * v * v + 2.0 * s * v * dv
    dwyu, dwyv = dc - ds * u * u - 2.0 * s * u * du, -ds * u * v - s * duv
    dwzu, dwzv = dk * v + k * dv, -dk * u - k * du
    ox, oy, oz = wxu * du + wxv * dv, wyu * du + wyv * dv, wzu * du + wzv * dv
    m_uu += ix * wxu * wxu + iy * wyu * wyu + iz * wzu * wzu
    m_uv += ix * wxu * wxv + iy * wyu * wyv + iz * wzu * wzv
    m_vv += ix * wxv * wxv + iy * wyv * wyv + iz * wzv * wzv
    # Columns of I (dW/dt + w x W) + w x I W. The first cross product is the rotation of the body
    # axes; it vanishes in C v.
    hxu = ix * (dwxu + oy * wzu - oz * wyu) + oy * iz * wzu - oz * iy * wyu
    hyu = iy * (dwyu + oz * wxu - ox * wzu) + oz * ix * wxu - ox * iz * wzu
    hzu = iz * (dwzu + ox * wyu - oy * wxu) + ox * iy * wyu - oy * ix * wxu
    hxv = ix * (dwxv + oy * wzv - oz * wyv) + oy * iz * wzv - oz * iy * wyv
    hyv = iy * (dwyv + oz * wxv - ox * wzv) + oz * ix * wxv - ox * iz * wzv
    hzv = iz * (dwzv + ox * wyv - oy * wxv) + ox * iy * wyv - oy * ix * wxv
    c_uu += wxu * hxu + wyu * hyu + wzu * hzu
    c_uv += wxu * hxv + wyu * hyv + wzu * hzv
    c_vu += wxv * hxu + wyv * hyu + wzv * hzu
    c_vv += wxv * hxv + wyv * hyv + wzv * hzv

    # First and second ball bodies: tan phi = x, sin theta = -c y in the axes of the leg, where (x,
    # y) is the slope.
    c_square = c * c
    dc_square = -2.0 * c_square * c_square * rate
    for leg in range(3):
        if leg == 0:
            ca, sa = 1.0, 0.0
        elif leg == 1:
            ca, sa = -0.5, HALF_SQRT3
        else:
            ca, sa = -0.5, -HALF_SQRT3
        lx, ly = u * ca + v * sa, v * ca - u * sa
        dlx, dly = du * ca + dv * sa, dv * ca - du * sa
        q_square = 1.0 + lx * lx
        q = math.sqrt(q_square)
        # One division gives 1/q² and 1/q.
        phi_x = 1.0 / q_square
        r = q * phi_x
        dq = lx * dlx * r
        dphi_x = -2.0 * lx * dlx * (phi_x * phi_x)
        theta_x, theta_y = lx * ly * c_square * r, -q * c_square
        dtheta_x = (
            (dlx * ly + lx * dly) * c_square * r
            + lx * ly * dc_square * r
            - lx * ly * c_square * dq * phi_x
        )
        dtheta_y = -dq * c_square - q * dc_square
        # Gradients with respect to (u, v) and their time derivatives.
        pu, pv, dpu, dpv = phi_x * ca, phi_x * sa, dphi_x * ca, dphi_x * sa
        tu, tv = theta_x * ca - theta_y * sa, theta_x * sa + theta_y * ca
        dtu, dtv = dtheta_x * ca - dtheta_y * sa, dtheta_x * sa + dtheta_y * ca
        jp, jt = p[PHI_INERTIA], p[THETA_INERTIA]
        m_uu += jp * pu * pu + jt * tu * tu
        m_uv += jp * pu * pv + jt * tu * tv
        m_vv += jp * pv * pv + jt * tv * tv
        c_uu += jp * pu * dpu + jt * tu * dtu
        c_uv += jp * pu * dpv + jt * tu * dtv
        c_vu += jp * pv * dpu + jt * tv * dtu
        c_vv += jp * pv * dpv + jt * tv * dtv
    return m_uu, m_uv, m_vv, m * z[0], m * z[1], m, c_uu, c_uv, c_vu, c_vv, m * zu, m * zv


@inlined
def _equation(a1, a2, a3, v1, v2, v3, p):
    """Whether a state is valid, and its M (upper triangle by rows, 6), C (by rows, 9) and G (3)."""
    d = p[RADIUS]
    u, v, _ = slope_of_nuts(a1, a2, a3, d)
    c, k = cosine_of_tilt(u, v)
    valid = is_valid_pose(u, v, c, k, d) and are_finite(v1, v2, v3)
    du, dv, _ = slope_of_nuts(v1, v2, v3, d)
    m_uu, m_uv, m_vv, m_uz, m_vz, m_zz, c_uu, c_uv, c_vu, c_vv, c_zu, c_zv = _reduced(
        u, v, c, k, du, dv, p
    )
    # Change of coordinates: derivatives of u, v and the mean height with respect to a_1, a_2, a_3
    # are the columns of [[f, -f/2, -f/2], [0, e, -e], [1/3, 1/3, 1/3]].
    f = -2.0 / (3.0 * d)
    g, e, third = -0.5 * f, f * HALF_SQRT3, 1.0 / 3.0
    sliding, gravity = p[SLIDING_MASS], p[GRAVITY]
    # Rows of the transposed change of coordinates times the reduced matrices.
    z = third * m_zz
    mu1, mv1, mz1 = f * m_uu + third * m_uz, f * m_uv + third * m_vz, f * m_uz + z
    mu2, mv2, mz2 = (
        g * m_uu + e * m_uv + third * m_uz,
        g * m_uv + e * m_vv + third * m_vz,
        g * m_uz + e * m_vz + z,
    )
    mu3, mv3, mz3 = (
        g * m_uu - e * m_uv + third * m_uz,
        g * m_uv - e * m_vv + third * m_vz,
        g * m_uz - e * m_vz + z,
    )
    cu1, cv1 = f * c_uu + third * c_zu, f * c_uv + third * c_zv
    cu2, cv2 = g * c_uu + e * c_vu + third * c_zu, g * c_uv + e * c_vv + third * c_zv
    cu3, cv3 = g * c_uu - e * c_vu + third * c_zu, g * c_uv - e * c_vv + third * c_zv
    return (
        valid,
        mu1 * f + mz1 * third + sliding,
        mu1 * g + mv1 * e + mz1 * third,
        mu1 * g - mv1 * e + mz1 * third,
        mu2 * g + mv2 * e + mz2 * third + sliding,
        mu2 * g - mv2 * e + mz2 * third,
        mu3 * g - mv3 * e + mz3 * third + sliding,
        cu1 * f,
        cu1 * g + cv1 * e,
        cu1 * g - cv1 * e,
        cu2 * f,
        cu2 * g + cv2 * e,
        cu2 * g - cv2 * e,
        cu3 * f,
        cu3 * g + cv3 * e,
        cu3 * g - cv3 * e,
        gravity * (sliding + mz1),
        gravity * (sliding + mz2),
        gravity * (sliding + mz3),
    )


@inlined
def _solve(m11, m12, m13, m22, m23, m33, b1, b2, b3):
    """Solve M x = b by Cholesky's method for a symmetric positive definite 3×3 matrix."""
    l11 = math.sqrt(m11)
    l21, l31 = m12 / l11, m13 / l11
    l22 = math.sqrt(m22 - l21 * l21)
    l32 = (m23 - l31 * l21) / l22
    l33 = math.sqrt(m33 - l31 * l31 - l32 * l32)
    y1 = b1 / l11
    y2 = (b2 - l21 * y1) / l22
    y3 = (b3 - l31 * y1 - l32 * y2) / l33
    x3 = y3 / l33
    x2 = (y2 - l32 * x3) / l22
    return (y1 - l21 * x2 - l31 * x3) / l11, x2, x3


@compiled
def forward_kinematics(heights: Array, p: Array, out: Array) -> int:
    """Write star center (3), rotation (9), arm lengths (3) and tip (3) of every row.

    They are 18 numbers each.
    """
    d, h = p[RADIUS], p[TOOL]
    for row in range(heights.size // 3):
        u, v, mean = slope_of_nuts(heights[3 * row], heights[3 * row + 1], heights[3 * row + 2], d)
        c, k = cosine_of_tilt(u, v)
        x, y, z = _center(u, v, c, k, d)
        z += mean
        b1, b2, b3 = _arms(u, v, c, k, d)
        if not (b1 > 0.0 and b2 > 0.0 and b3 > 0.0 and b1 + b2 + b3 < math.inf):
            return row
        o = 18 * row
        out[o], out[o + 1], out[o + 2] = x, y, z
        out[o + 3], out[o + 4], out[o + 5] = 1.0 - k * u * u, -k * u * v, c * u
        out[o + 6], out[o + 7], out[o + 8] = -k * u * v, 1.0 - k * v * v, c * v
        out[o + 9], out[o + 10], out[o + 11] = -c * u, -c * v, c
        out[o + 12], out[o + 13], out[o + 14] = b1, b2, b3
        out[o + 15], out[o + 16], out[o + 17] = x + h * c * u, y + h * c * v, z + h * c
    return -1


@compiled
def configuration(heights: Array, p: Array, out: Array) -> int:
    """Write (a, phi, theta, lambda, b) of legs 1, 2 and 3 of every row.

    They are 15 numbers each (eq. 3.5).
    """
    d = p[RADIUS]
    for row in range(heights.size // 3):
        u, v, _ = slope_of_nuts(heights[3 * row], heights[3 * row + 1], heights[3 * row + 2], d)
        c, k = cosine_of_tilt(u, v)
        if not is_valid_pose(u, v, c, k, d):
            return row
        arms = _arms(u, v, c, k, d)
        for leg in range(3):
            ca = 1.0 if leg == 0 else -0.5
            sa = 0.0 if leg == 0 else (HALF_SQRT3 if leg == 1 else -HALF_SQRT3)
            x, y = u * ca + v * sa, v * ca - u * sa
            o = 15 * row + 5 * leg
            out[o] = heights[3 * row + leg]
            out[o + 1] = math.atan(x)
            out[o + 2] = -math.atan(y / math.sqrt(1.0 + x * x))
            out[o + 3] = math.atan2(-k * x * y, 1.0 - k * y * y)
            out[o + 4] = arms[leg]
    return -1


@compiled
def equation_is_finite(out, o):
    """Whether M, C and G from ``o`` on, and their sum, are finite."""
    total = 0.0
    for j in range(21):
        total += out[o + j]
    return math.isfinite(total)


@compiled
def equation_of_motion(heights: Array, speeds: Array, p: Array, out: Array) -> int:
    """Write M (9), C (9) and G (3) of every row, 21 numbers each (eq. 3.2–3.4)."""
    for row in range(heights.size // 3):
        i = 3 * row
        (
            valid,
            m11,
            m12,
            m13,
            m22,
            m23,
            m33,
            c11,
            c12,
            c13,
            c21,
            c22,
            c23,
            c31,
            c32,
            c33,
            g1,
            g2,
            g3,
        ) = _equation(
            heights[i], heights[i + 1], heights[i + 2], speeds[i], speeds[i + 1], speeds[i + 2], p
        )
        if not valid:
            return row
        o = 21 * row
        out[o], out[o + 1], out[o + 2] = m11, m12, m13
        out[o + 3], out[o + 4], out[o + 5] = m12, m22, m23
        out[o + 6], out[o + 7], out[o + 8] = m13, m23, m33
        out[o + 9], out[o + 10], out[o + 11] = c11, c12, c13
        out[o + 12], out[o + 13], out[o + 14] = c21, c22, c23
        out[o + 15], out[o + 16], out[o + 17] = c31, c32, c33
        out[o + 18], out[o + 19], out[o + 20] = g1, g2, g3
        if not equation_is_finite(out, o):
            return row
    return -1


@compiled
def inverse_dynamics(
    heights: Array, speeds: Array, accelerations: Array, p: Array, out: Array
) -> int:
    """Write the screw forces M a + C v + G of every row (eq. 3.1)."""
    for row in range(heights.size // 3):
        i = 3 * row
        v1, v2, v3 = speeds[i], speeds[i + 1], speeds[i + 2]
        (
            valid,
            m11,
            m12,
            m13,
            m22,
            m23,
            m33,
            c11,
            c12,
            c13,
            c21,
            c22,
            c23,
            c31,
            c32,
            c33,
            g1,
            g2,
            g3,
        ) = _equation(heights[i], heights[i + 1], heights[i + 2], v1, v2, v3, p)
        if not valid:
            return row
        a1, a2, a3 = accelerations[i], accelerations[i + 1], accelerations[i + 2]
        out[i] = m11 * a1 + m12 * a2 + m13 * a3 + c11 * v1 + c12 * v2 + c13 * v3 + g1
        out[i + 1] = m12 * a1 + m22 * a2 + m23 * a3 + c21 * v1 + c22 * v2 + c23 * v3 + g2
        out[i + 2] = m13 * a1 + m23 * a2 + m33 * a3 + c31 * v1 + c32 * v2 + c33 * v3 + g3
        if not is_finite(out, i):
            return row
    return -1


@compiled
def accelerations_of_state(heights, i, speeds, j, f1, f2, f3, p):
    """Accelerations of one state under the given forces; NaN where the pose is not valid."""
    v1, v2, v3 = speeds[j], speeds[j + 1], speeds[j + 2]
    valid, m11, m12, m13, m22, m23, m33, c11, c12, c13, c21, c22, c23, c31, c32, c33, g1, g2, g3 = (
        _equation(heights[i], heights[i + 1], heights[i + 2], v1, v2, v3, p)
    )
    if not valid:
        return math.nan, math.nan, math.nan
    return _solve(
        m11,
        m12,
        m13,
        m22,
        m23,
        m33,
        f1 - c11 * v1 - c12 * v2 - c13 * v3 - g1,
        f2 - c21 * v1 - c22 * v2 - c23 * v3 - g2,
        f3 - c31 * v1 - c32 * v2 - c33 * v3 - g3,
    )


@compiled
def forward_dynamics(heights: Array, speeds: Array, forces: Array, p: Array, out: Array) -> int:
    """Write the accelerations M⁻¹ (tau − C v − G) of every row."""
    for row in range(heights.size // 3):
        i = 3 * row
        x1, x2, x3 = accelerations_of_state(
            heights, i, speeds, i, forces[i], forces[i + 1], forces[i + 2], p
        )
        if not math.isfinite(x1 + x2 + x3):
            return row
        out[i], out[i + 1], out[i + 2] = x1, x2, x3
    return -1


@compiled
def energies(heights: Array, speeds: Array, p: Array, out: Array) -> int:
    """Write kinetic and potential energy of every row, 2 numbers each."""
    d = p[RADIUS]
    for row in range(heights.size // 3):
        i = 3 * row
        v1, v2, v3 = speeds[i], speeds[i + 1], speeds[i + 2]
        valid, m11, m12, m13, m22, m23, m33, _, _, _, _, _, _, _, _, _, _, _, _ = _equation(
            heights[i], heights[i + 1], heights[i + 2], v1, v2, v3, p
        )
        if not valid:
            return row
        u, v, mean = slope_of_nuts(heights[i], heights[i + 1], heights[i + 2], d)
        c, k = cosine_of_tilt(u, v)
        _, _, z = _center(u, v, c, k, d)
        out[2 * row] = (
            0.5 * (m11 * v1 * v1 + m22 * v2 * v2 + m33 * v3 * v3)
            + m12 * v1 * v2
            + m13 * v1 * v3
            + m23 * v2 * v3
        )
        out[2 * row + 1] = p[GRAVITY] * (3.0 * p[SLIDING_MASS] * mean + p[STAR_MASS] * (mean + z))
        if not math.isfinite(out[2 * row] + out[2 * row + 1]):
            return row
    return -1


@compiled
def tip_jacobian(heights: Array, p: Array, out: Array) -> int:
    """Write the Jacobian of the tip with respect to the heights of every row, 9 numbers each."""
    d = p[RADIUS]
    factor = -2.0 / (3.0 * d)
    for row in range(heights.size // 3):
        u, v, _ = slope_of_nuts(heights[3 * row], heights[3 * row + 1], heights[3 * row + 2], d)
        c, k = cosine_of_tilt(u, v)
        if not is_valid_pose(u, v, c, k, d):
            return row
        derivatives = _tip_derivatives(u, v, c, d, p[TOOL])
        for r in range(3):
            along = factor * derivatives[r][0]
            across = factor * HALF_SQRT3 * derivatives[r][1]
            rise = 1.0 / 3.0 if r == 2 else 0.0
            o = 9 * row + 3 * r
            out[o], out[o + 1], out[o + 2] = (
                along + rise,
                -0.5 * along + across + rise,
                -0.5 * along - across + rise,
            )
    return -1


@compiled
def _tip_step(u, v, x, y, d, h):
    """Residual, determinant and Newton step of the map from slope to horizontal tip position."""
    c, k = cosine_of_tilt(u, v)
    cx, cy, _ = _center(u, v, c, k, d)
    rx, ry = x - cx - h * c * u, y - cy - h * c * v
    dx, dy, _ = _tip_derivatives(u, v, c, d, h)
    determinant = dx[0] * dy[1] - dx[1] * dy[0]
    return (
        rx,
        ry,
        determinant,
        (dy[1] * rx - dx[1] * ry) / determinant,
        (dx[0] * ry - dy[0] * rx) / determinant,
    )


@compiled
def tip_slope(x: float, y: float, d: float, h: float) -> tuple[float, float]:
    """Slope (u, v) that puts the tip at (x, y), on the branch connected to home.

    NaN where the tip is out of reach.

    Newton's method follows the ray from the center to (x, y); a step that leaves the branch is
    halved.
    """
    u, v, done, step = 0.0, 0.0, 0.0, 1.0
    tiny = TIP_ROUNDING * (d + h)
    for _ in range(MOST_TIP_STEPS):
        goal = min(1.0, done + step)
        nu, nv = u, v
        good = False
        last = math.inf
        for _ in range(MOST_TIP_ITERATIONS):
            rx, ry, determinant, su, sv = _tip_step(nu, nv, goal * x, goal * y, d, h)
            if not (
                determinant > 0.0 and nu * nu + nv * nv < LARGEST_TIP_SLOPE * LARGEST_TIP_SLOPE
            ):
                break
            residual = math.hypot(rx, ry)
            if residual <= tiny or (residual >= last and residual <= 64.0 * tiny):
                good = True
                break
            if residual > 2.0 * last:
                break
            last = residual
            nu += su
            nv += sv
        if good:
            u, v, done = nu, nv, goal
            step = 2.0 * step
            if not done < 1.0:
                return u, v
        else:
            step = 0.5 * step if done + step < 1.0 else 0.5 * (1.0 - done)
            if step < SMALLEST_TIP_STEP:
                return math.nan, math.nan
    return math.nan, math.nan


@compiled
def inverse_kinematics_tip(tips: Array, p: Array, out: Array) -> int:
    """Write the heights that put the tip at each row of ``tips``.

    Return -1 or the first row out of reach.
    """
    d, h = p[RADIUS], p[TOOL]
    for row in range(tips.size // 3):
        o = 3 * row
        u, v = tip_slope(tips[o], tips[o + 1], d, h)
        c, k = cosine_of_tilt(u, v)
        if not is_valid_pose(u, v, c, k, d):
            return row
        _, _, z = _center(u, v, c, k, d)
        mean = tips[o + 2] - h * c - z
        # The plane through the nuts falls toward the slope's azimuth.
        out[o], out[o + 1], out[o + 2] = (
            mean - d * u,
            mean - d * (-0.5 * u + HALF_SQRT3 * v),
            mean - d * (-0.5 * u - HALF_SQRT3 * v),
        )
        if not is_finite(out, o):
            return row
    return -1


@compiled
def tip_rates(
    heights: Array,
    velocities: Array,
    accelerations: Array,
    p: Array,
    speeds_out: Array,
    accelerations_out: Array,
) -> int:
    """Write nut speeds and accelerations for given tip velocities and accelerations, row by row.

    With x = f(u, v) the tip's horizontal position: (du, dv) = J⁻¹ dx and (ddu, ddv) = J⁻¹ (ddx − dJ
    (du, dv)).
    """
    d, h = p[RADIUS], p[TOOL]
    for row in range(heights.size // 3):
        o = 3 * row
        u, v, _ = slope_of_nuts(heights[o], heights[o + 1], heights[o + 2], d)
        c, k = cosine_of_tilt(u, v)
        if not is_valid_pose(u, v, c, k, d):
            return row
        x, y, z = _tip_derivatives(u, v, c, d, h)
        determinant = x[0] * y[1] - x[1] * y[0]
        vx, vy = velocities[o], velocities[o + 1]
        du, dv = (y[1] * vx - x[1] * vy) / determinant, (x[0] * vy - y[0] * vx) / determinant
        ax = accelerations[o] - (x[2] * du * du + 2.0 * x[3] * du * dv + x[4] * dv * dv)
        ay = accelerations[o + 1] - (y[2] * du * du + 2.0 * y[3] * du * dv + y[4] * dv * dv)
        ddu, ddv = (y[1] * ax - x[1] * ay) / determinant, (x[0] * ay - y[0] * ax) / determinant
        rise = velocities[o + 2] - z[0] * du - z[1] * dv
        lift = (
            accelerations[o + 2]
            - z[0] * ddu
            - z[1] * ddv
            - (z[2] * du * du + 2.0 * z[3] * du * dv + z[4] * dv * dv)
        )
        speeds_out[o], accelerations_out[o] = rise - d * du, lift - d * ddu
        speeds_out[o + 1] = rise - d * (-0.5 * du + HALF_SQRT3 * dv)
        accelerations_out[o + 1] = lift - d * (-0.5 * ddu + HALF_SQRT3 * ddv)
        speeds_out[o + 2] = rise - d * (-0.5 * du - HALF_SQRT3 * dv)
        accelerations_out[o + 2] = lift - d * (-0.5 * ddu - HALF_SQRT3 * ddv)
        # A speed that is not finite makes an acceleration that is not.
        if not is_finite(accelerations_out, o):
            return row
    return -1
