r"""Geometry of the 3-PSP robot that need not be fast.

It contains the inverse kinematics from the tilt, and the reach of the tip.

The map from the star's slope to the tip's horizontal position has a fold where its derivative is
singular. The fold is a curve with three cusps (nearly a deltoid) around the vertical axis, and on
the branch that is connected to home the tip cannot go beyond it. At azimuth 0 the reach is exactly
:math:`\sqrt{h^2 + d^2/4} - d/2`, 23.9 mm for the thesis's robot.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from psp3.checks import (
    Array,
    checked_positive,
    finite_array,
    finite_rows,
    overflow_refused,
    together,
)
from psp3.errors import InvalidValue, UnreachablePose

SCREW_AZIMUTHS = np.array([0.0, 2.0 * np.pi / 3.0, 4.0 * np.pi / 3.0])
"""Azimuths of the three screws [rad]."""

LARGEST_TIP_SLOPE = math.sqrt(3.0)
"""Tangent of the largest tilt in the search for a given tip, 60 degrees; the fold is at 33 to 38
degrees.

Beyond the fold the determinant of the tip's map is negative up to tilts of 70 degrees (checked on a
grid for tools of 10 to 150 mm), so a positive determinant below this slope identifies the branch
that is connected to home.
"""


def _column(name: str, values: ArrayLike) -> Array:
    """Return finite numbers of any shape (...,) as (..., 1)."""
    return finite_array(name, values)[..., np.newaxis]


def heights_of_tilt(
    height: ArrayLike, tilt: ArrayLike, azimuth: ArrayLike, screw_radius: float
) -> Array:
    r"""Return the nut heights that hold the star's center at a height and its axis at a tilt.

    .. math::

        b_k = d\, \frac{1 + \cos\theta}{2 \cos\theta}
        \Big[ 1 + 2 \tan^2\tfrac\theta2 \cos(2\phi + \alpha_k) \Big], \qquad
        a_k = z_C - b_k \sin\theta \cos(\phi - \alpha_k).

    Parameters
    ----------
    height : (...,) array_like
        Height :math:`z_C` of the star's center above the base frame [m].
    tilt : (...,) array_like
        Angle :math:`\theta` between the star's axis and the vertical [rad].
    azimuth : (...,) array_like
        Direction :math:`\phi` toward which the star's axis leans [rad].
    screw_radius : float
        Distance :math:`d` from the center of the base to each screw [m].

    Returns
    -------
    (..., 3) ndarray
        Nut heights [m].

    Raises
    ------
    InvalidArray
        If an argument is not finite.
    InvalidValue
        If the tilt is 90° or more.
    UnreachablePose
        If an arm length is negative or zero, which happens only at a tilt of at least 70.53°.
    """
    z, theta, phi = together(
        height=_column("height", height),
        tilt=_column("tilt", tilt),
        azimuth=_column("azimuth", azimuth),
    )
    if (np.abs(theta) >= 0.5 * np.pi).any():
        raise InvalidValue("tilt", float(np.abs(theta).max()), "less than 90 degrees (pi/2 rad)")
    half = np.tan(0.5 * theta) ** 2
    cosine = np.cos(theta)
    arms = (
        checked_positive("screw_radius", screw_radius)
        * (1.0 + cosine)
        / (2.0 * cosine)
        * (1.0 + 2.0 * half * np.cos(2.0 * phi + SCREW_AZIMUTHS))
    )
    heights: Array = z - arms * np.sin(theta) * np.cos(phi - SCREW_AZIMUTHS)
    valid = (arms > 0.0).all(axis=-1)
    if not valid.all():
        first = np.unravel_index(int(np.argmin(valid)), valid.shape)
        raise UnreachablePose(heights[first], arms[first])
    return heights


def arm_lengths(heights: ArrayLike, screw_radius: float) -> Array:
    r"""Return the signed arm lengths of the star, from the sides of the nut triangle.

    The star's center is the Fermat point of the triangle. With :math:`l_k` the side opposite nut k,
    :math:`A` the area and :math:`\Sigma = l_1^2 + l_2^2 + l_3^2`,

    .. math:: s = \sum_k b_k = \sqrt{\Sigma/2 + 2\sqrt3 A}, \qquad
              b_k = (s^2 + \Sigma - 3 l_k^2) / (3 s).

    Parameters
    ----------
    heights : (..., 3) array_like
        Nut heights [m].
    screw_radius : float
        Distance :math:`d` from the center of the base to each screw [m].

    Returns
    -------
    (..., 3) ndarray
        Arm lengths [m]; negative if the Fermat point lies outside the triangle, which the machine
        cannot reach.

    Raises
    ------
    InvalidArray
        If the heights are not finite or of another shape.
    """
    a, d = finite_rows("heights", heights, 3), checked_positive("screw_radius", screw_radius)
    nuts = np.stack(
        np.broadcast_arrays(d * np.cos(SCREW_AZIMUTHS), d * np.sin(SCREW_AZIMUTHS), a),
        axis=-1,
    )
    # Absurd heights overflow to lengths that are not numbers. The caller's check gives a better
    # message than a numpy warning.
    with np.errstate(over="ignore", invalid="ignore"):
        return _fermat_arms(nuts)


def _fermat_arms(nuts: Array) -> Array:
    """Signed distances from the Fermat point of triangles (..., 3, 3) to their corners."""
    edges = np.roll(nuts, -2, axis=-2) - np.roll(nuts, -1, axis=-2)
    squares = (edges**2).sum(axis=-1)
    area = 0.5 * np.linalg.norm(
        np.cross(edges[..., 0, :], edges[..., 1, :]), axis=-1, keepdims=True
    )
    total = squares.sum(axis=-1, keepdims=True)
    length = np.sqrt(0.5 * total + 2.0 * np.sqrt(3.0) * area)
    arms: Array = (length**2 + total - 3.0 * squares) / (3.0 * length)
    return arms


def _tip_map(slope: complex, d: float, h: float) -> tuple[complex, float]:
    """Horizontal tip position of a slope, and the determinant of its derivative.

    It uses complex arithmetic, not the kernels.
    """
    s = abs(slope) ** 2
    c = (1.0 + s) ** -0.5
    g = c**3 / (1.0 + c) ** 2
    conjugate = slope.conjugate()
    tip = 0.25 * d * (g * slope**4 - c * conjugate**2) + h * c * slope
    # Derivatives with respect to p and its conjugate; c and g depend on s = p p*.
    c_s = -0.5 * c**3
    g_s = c * c * (3.0 + c) / (1.0 + c) ** 3 * c_s
    along = 0.25 * d * (
        4.0 * g * slope**3 + g_s * conjugate * slope**4 - c_s * conjugate**3
    ) + h * (c + c_s * s)
    across = (
        0.25 * d * (g_s * slope**5 - 2.0 * c * conjugate - c_s * slope * conjugate**2)
        + h * c_s * slope**2
    )
    return tip, abs(along) ** 2 - abs(across) ** 2


def _fold(direction: float, d: float, h: float) -> complex:
    """Tip position on the fold, for a slope toward ``direction``."""
    ray = np.exp(1j * direction)
    # The determinant falls from h² at the level pose. With a very long tool it is still positive at
    # the tilt of 60 degrees where the compiled inverse kinematics ends.
    size = LARGEST_TIP_SLOPE
    if _tip_map(size * ray, d, h)[1] < 0.0:
        size = _root(lambda t: _tip_map(t * ray, d, h)[1], 0.0, size)
    return _tip_map(size * ray, d, h)[0]


def _root(function: Callable[[float], float], lower: float, upper: float) -> float:
    """Return where a function changes its sign, to 1e-14 (Chandrupatla, 1997).

    Written here because importing ``scipy.optimize`` takes a quarter of the time of ``psp3 info``.
    """
    x1, x2 = lower, upper
    f1, f2 = function(x1), function(x2)
    share = 0.5
    while True:
        x = x1 + share * (x2 - x1)
        f = function(x)
        if (f > 0.0) == (f1 > 0.0):
            x3, f3 = x1, f1
        else:
            x3, f3, x2, f2 = x2, f2, x1, f1
        x1, f1 = x, f
        best, at_best = (x1, f1) if abs(f1) < abs(f2) else (x2, f2)
        least = (1e-14 * abs(best) + 1e-15) / abs(x2 - x1)
        if least > 0.5 or at_best == 0.0:
            return best
        xi, phi = (x1 - x2) / (x3 - x2), (f1 - f2) / (f3 - f2)
        share = 0.5
        # Only here does the parabola through the three points, turned by 90°, stay between them.
        if phi**2 < xi and (1.0 - phi) ** 2 < 1.0 - xi:
            share = f1 / (f2 - f1) * f3 / (f2 - f3)
            share += (x3 - x1) / (x2 - x1) * f1 / (f3 - f1) * f2 / (f3 - f2)
        share = min(1.0 - least, max(least, share))


SHORTEST_TOOL = 1e-12
"""The shortest tool, as a share of the screw radius; the reach of a shorter one is lost in
rounding.
"""


def tip_reach(azimuth: ArrayLike, screw_radius: float, tool_length: float) -> Array:
    r"""Return how far the tip can move from the vertical axis at an azimuth.

    The poses are on the branch that is connected to home.

    Parameters
    ----------
    azimuth : (...,) array_like
        Direction of the tip from the vertical axis [rad].
    screw_radius, tool_length : float
        :math:`d` and :math:`h` [m].

    Returns
    -------
    (...,) ndarray
        Radius of the fold [m]; :math:`\sqrt{h^2 + d^2/4} - d/2` at the azimuths of the screws,
        where it is smallest. With a tool longer than 0.866 d there is no fold up to the tilt of 60°
        where the inverse kinematics ends; the result is then the radius at that tilt.

    Raises
    ------
    InvalidArray
        If an azimuth is not finite.
    """
    d, h = (
        checked_positive("screw_radius", screw_radius),
        checked_positive("tool_length", tool_length),
    )

    def reach(angle: float) -> float:
        # One third of the curve, mirrored: between a screw's azimuth and the cusp half-way to the
        # next one the tip's azimuth rises from 0 to 60 degrees with the slope's direction.
        folded = angle % (2.0 * np.pi / 3.0)
        folded = min(folded, 2.0 * np.pi / 3.0 - folded)
        lower, upper = 0.0, np.pi / 3.0
        if folded < 1e-9:
            direction = lower
        elif folded > upper - 1e-9:
            direction = upper
        else:
            direction = _root(lambda b: np.angle(_fold(b, d, h)) - folded, lower, upper)
        return abs(_fold(direction, d, h))

    if h < SHORTEST_TOOL * d:
        raise InvalidValue("tool_length", h, f"at least {SHORTEST_TOOL * d:.3g} m")
    angles = finite_array("azimuth", azimuth)
    with overflow_refused("screw_radius and tool_length"):
        found = [reach(float(angle)) for angle in angles.ravel()]
    return np.array(found).reshape(angles.shape)
