r"""The workspace of the robot.

The module computes the parasitic motion, arm lengths and conditioning of every pose, and the
borders of the workspace.

Only differences of the nut heights matter: lifting all nuts together lifts the star and changes
nothing else. There are two borders of the orientation of the star:

* an arm length becomes zero, see :func:`largest_tilt`: the mechanical limit, at a tilt of 70.53° or
  more;
* the map from star orientation to the tip's horizontal position folds, see :func:`fold_tilt`:
  orientations beyond it are possible, but the tip then moves back from the border of its reach,
  :func:`reach_boundary`, and no longer determines the pose.

Between them there is no singularity of actuation: :attr:`WorkspaceMap.actuation_determinant` stays
positive. In the model with fifteen coordinates, each ball joint is three hinges. This adds a
singularity that the machine does not have, with the middle hinge at ±90°.
:attr:`WorkspaceMap.hinge_angle` shows how near it is, and :attr:`WorkspaceMap.closure_condition`
the loss of digits.

:mod:`psp3.kinematics.singularities` and :mod:`psp3.kinematics.workspace` compute the same for any
robot, without closed forms.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike

from psp3.checks import Array, checked_kind, finite_array, finite_rows
from psp3.errors import InvalidArray, InvalidValue
from psp3.three_psp.geometry import SCREW_AZIMUTHS
from psp3.three_psp.robot import PSP3

BISECTIONS = 60
"""Number of bisections of an interval of angles: more than double precision can resolve."""


@dataclass(frozen=True)
class WorkspaceMap:
    """Properties of a set of poses; each field has the leading dimensions of the poses.

    If a pose does not exist, all fields but ``tilt`` and ``azimuth`` are NaN.

    Parameters
    ----------
    heights : (..., 3) ndarray
        Nut heights [m].
    tilt, azimuth : (...,) ndarray
        Angle of the star's axis from the vertical, and the direction toward which it leans [rad].
    center : (..., 3) ndarray
        Center of the star in base axes [m].
    parasitic_motion : (...,) ndarray
        Parasitic motion: distance of the center from the vertical axis, a side effect of tilting
        [m].
    arms : (..., 3) ndarray
        Arm lengths [m].
    tip : (..., 3) ndarray
        Tip in base axes [m].
    tip_condition : (...,) ndarray
        Condition number (2-norm) of the tip Jacobian, which is infinite on the fold.
    mass_condition : (...,) ndarray
        Condition number (2-norm) of the mass matrix.
    actuation_determinant : (...,) ndarray
        Determinant of the six wrenches by which the ball joints hold the star while the screws are
        locked [m³].
    hinge_angle : (...,) ndarray
        Largest angle of the three middle hinges of the ball joints; less than the tilt, so never
        90° [rad].
    closure_condition : (...,) ndarray
        Condition number (2-norm) of the columns of the constraint Jacobian that belong to the
        joints without a motor, in m and rad.
    travel : (...,) ndarray
        Range of heights of the star at this orientation within the ends of the screws; negative if
        the stroke is too short for the orientation [m].
    """

    heights: Array
    tilt: Array
    azimuth: Array
    center: Array
    parasitic_motion: Array
    arms: Array
    tip: Array
    tip_condition: Array
    mass_condition: Array
    actuation_determinant: Array
    hinge_angle: Array
    closure_condition: Array
    travel: Array


def tilt_and_azimuth(rotation: ArrayLike) -> tuple[Array, Array]:
    """Return the tilt of a star and the azimuth toward which it leans.

    Parameters
    ----------
    rotation : (..., 3, 3) array_like
        Rotation from star axes to base axes.

    Returns
    -------
    tilt, azimuth : (...,) ndarray
        Angle between the star's axis and the vertical, and direction of the axis's horizontal part;
        0 if it has none [rad].
    """
    matrices = finite_array("rotation", rotation)
    if matrices.shape[-2:] != (3, 3):
        raise InvalidArray("rotation", "(..., 3, 3)", rotation)
    axis = matrices[..., :, 2]
    horizontal = np.hypot(axis[..., 0], axis[..., 1])
    # Adding 0.0 turns −0.0 into 0.0, whose arctangent would be π.
    return np.arctan2(horizontal, axis[..., 2]), np.arctan2(axis[..., 1] + 0.0, axis[..., 0] + 0.0)


def map_at_heights(robot: PSP3, heights: ArrayLike) -> WorkspaceMap:
    r"""Return the properties of poses that are given by nut heights.

    The six wrenches of the ball joints, two for each arm, across it and along the normal of the
    star's plane, have the determinant :math:`\sqrt3\, s A`, with :math:`s` the sum of the arm
    lengths and :math:`A = \frac{\sqrt3}{4} (b_1 b_2 + b_2 b_3 + b_3 b_1)` the area of the nut
    triangle. The middle hinge of the ball joint on screw k has the angle
    :math:`\sin\theta_k = \sin\theta \sin(\alpha_k - \phi)`, for a star that leans by :math:`\theta`
    toward :math:`\phi`.

    Parameters
    ----------
    robot : PSP3
        The robot.
    heights : (..., 3) array_like
        Nut heights [m].

    Returns
    -------
    WorkspaceMap
        Fields with the leading dimensions of ``heights``.

    Raises
    ------
    InvalidArray
        If the heights are not finite or of another shape.
    UnreachablePose
        If an arm length is not positive.
    """
    _check_psp3(robot)
    a = finite_rows("heights", heights, 3)
    pose = robot.forward_kinematics(a)
    tilt, azimuth = tilt_and_azimuth(pose.rotation)
    b = pose.arms
    pairs = (b * np.roll(b, -1, axis=-1)).sum(axis=-1)
    lower, upper = robot.stroke
    return WorkspaceMap(
        heights=a,
        tilt=tilt,
        azimuth=azimuth,
        center=pose.center,
        parasitic_motion=np.hypot(pose.center[..., 0], pose.center[..., 1]),
        arms=b,
        tip=pose.tip,
        tip_condition=np.linalg.cond(robot.tip_jacobian(a)),
        mass_condition=np.linalg.cond(robot.mass_matrix(a)),
        actuation_determinant=0.75 * b.sum(axis=-1) * pairs,
        hinge_angle=np.arcsin(
            np.abs(
                np.sin(tilt)[..., np.newaxis] * np.sin(SCREW_AZIMUTHS - azimuth[..., np.newaxis])
            ).max(axis=-1)
        ),
        closure_condition=_closure_condition(robot, a),
        travel=(upper - a).min(axis=-1) - (lower - a).max(axis=-1),
    )


def map_over_tilt(robot: PSP3, tilt: ArrayLike, azimuth: ArrayLike) -> WorkspaceMap:
    """Return the properties of orientations of the star, with its center at the height 0.

    Parameters
    ----------
    robot : PSP3
        The robot.
    tilt, azimuth : (...,) array_like
        Angle of the star's axis from the vertical, within [0, π/2), and the direction toward which
        it leans [rad]. They are broadcast against each other: (N, 1) and (K,) make a map of N by K
        poses.

    Returns
    -------
    WorkspaceMap
        Fields with the broadcast dimensions; NaN if an arm length would not be positive.

    Raises
    ------
    InvalidArray
        If an angle is not finite.
    InvalidValue
        If a tilt is negative or 90° or more.
    """
    _check_psp3(robot)
    theta, phi = _angles(tilt=tilt, azimuth=azimuth)
    if theta.size and not (theta.min() >= 0.0 and theta.max() < 0.5 * np.pi):
        wrong = theta.min() if theta.min() < 0.0 else theta.max()
        raise InvalidValue("tilt", float(wrong), "at least 0 and less than 90 degrees (pi/2 rad)")
    # On the border itself an arm length is zero, and rounding would decide whether a pose is valid.
    rows = np.flatnonzero(theta <= largest_tilt(phi) - 1e-12)
    some = map_at_heights(
        robot, robot.inverse_kinematics(0.0, theta.reshape(-1)[rows], phi.reshape(-1)[rows])
    )
    whole = {}
    for field in fields(WorkspaceMap):
        values = getattr(some, field.name)
        array = np.full((theta.size, *values.shape[1:]), np.nan)
        array[rows] = values
        whole[field.name] = array.reshape((*theta.shape, *values.shape[1:]))
    return WorkspaceMap(**whole | {"tilt": theta.copy(), "azimuth": phi.copy()})


def map_over_reach(robot: PSP3, share: ArrayLike, azimuth: ArrayLike) -> WorkspaceMap:
    """Return the properties of tip positions within reach, with the star's center at the height 0.

    The poses are those of the branch that is connected to home. The grid is over orientations of
    the star, not over tip positions, so that it follows the border of the reach: in each row the
    tip moves from the vertical axis to the border.

    Parameters
    ----------
    robot : PSP3
        The robot.
    share : (...,) array_like
        Tilt as a share of the tilt at the fold, within [0, 1].
    azimuth : (...,) array_like
        Direction toward which the star leans [rad], broadcast against ``share``.

    Returns
    -------
    WorkspaceMap
        Fields with the broadcast dimensions.

    Raises
    ------
    InvalidArray
        If an argument is not finite.
    InvalidValue
        If a share is not within [0, 1].
    """
    _check_psp3(robot)
    rho, phi = _angles(share=share, azimuth=azimuth)
    if rho.size and not (rho.min() >= 0.0 and rho.max() <= 1.0):
        raise InvalidValue(
            "share", float(rho.min() if rho.min() < 0.0 else rho.max()), "within [0, 1]"
        )
    directions, place = np.unique(phi, return_inverse=True)
    return map_over_tilt(robot, rho * fold_tilt(robot, directions)[place].reshape(rho.shape), phi)


def largest_tilt(azimuth: ArrayLike) -> Array:
    r"""Return the tilt at which an arm length vanishes.

    It depends on the direction toward which the star leans.

    .. math:: \tan^2(\theta/2) = -1 / \big(2 \min_k \cos(2\phi + \alpha_k)\big)

    This follows from the arm lengths of :func:`psp3.three_psp.geometry.heights_of_tilt`. It does
    not depend on the dimensions of the robot.

    Parameters
    ----------
    azimuth : (...,) array_like
        Direction toward which the star leans [rad].

    Returns
    -------
    (...,) ndarray
        Largest tilt, between 70.53° and 90° [rad].

    Raises
    ------
    InvalidArray
        If an azimuth is not finite.
    """
    (phi,) = _angles(azimuth=azimuth)
    least = np.cos(2.0 * phi[..., np.newaxis] + SCREW_AZIMUTHS).min(axis=-1)
    tilt: Array = 2.0 * np.arctan(np.sqrt(-0.5 / least))
    return tilt


def fold_tilt(robot: PSP3, azimuth: ArrayLike) -> Array:
    """Return the tilt at which the tip reaches its border, where its Jacobian becomes singular.

    Parameters
    ----------
    robot : PSP3
        The robot.
    azimuth : (...,) array_like
        Direction toward which the star leans [rad].

    Returns
    -------
    (...,) ndarray
        Tilt at the fold, 33° to 38° for the thesis's robot [rad]; the largest tilt if the map of a
        long tool has no fold.

    Raises
    ------
    InvalidArray
        If an azimuth is not finite.
    """
    _check_psp3(robot)
    (phi,) = _angles(azimuth=azimuth)
    # Slightly below the tilt where an arm length is zero, because there is no Jacobian beyond it.
    end = largest_tilt(phi) * (1.0 - 1e-9)
    # If there is a second root, it is far beyond the first, so sixteen steps do not skip both.
    scan = end[..., np.newaxis] * np.linspace(0.0, 1.0, 17)
    folded = _tip_determinant(robot, scan, phi[..., np.newaxis]) <= 0.0
    first = np.where(folded.any(axis=-1), folded.argmax(axis=-1), 16)
    upper = np.take_along_axis(scan, first[..., np.newaxis], axis=-1)[..., 0]
    lower = np.take_along_axis(scan, first[..., np.newaxis] - 1, axis=-1)[..., 0]
    for _ in range(BISECTIONS):
        middle = 0.5 * (lower + upper)
        beyond = _tip_determinant(robot, middle, phi) <= 0.0
        lower, upper = np.where(beyond, lower, middle), np.where(beyond, middle, upper)
    tilt: Array = lower
    return tilt


def reach_boundary(robot: PSP3, azimuth: ArrayLike) -> Array:
    r"""Return the horizontal border of the tip's reach.

    The star leans toward the given directions.

    The border is a curve with three cusps, at the azimuths 60°, 180° and 300°. It is nearest to the
    vertical axis at the azimuths of the screws, at the distance :math:`\sqrt{h^2 + d^2/4} - d/2`.
    :meth:`psp3.PSP3.tip_reach` gives the distance for an azimuth of the tip.

    Parameters
    ----------
    robot : PSP3
        The robot.
    azimuth : (...,) array_like
        Direction toward which the star leans [rad].

    Returns
    -------
    (..., 2) ndarray
        Points x, y of the border in base axes [m].

    Raises
    ------
    InvalidArray
        If an azimuth is not finite.
    """
    _check_psp3(robot)
    (phi,) = _angles(azimuth=azimuth)
    heights = robot.inverse_kinematics(0.0, fold_tilt(robot, phi), phi)
    return robot.forward_kinematics(heights).tip[..., :2]


def _closure_condition(robot: PSP3, heights: Array) -> Array:
    q = robot.configuration(heights)
    jacobians = [
        robot.constraint_jacobian(row)[:, robot.dependent_v]
        for row in q.reshape(-1, robot.model.nq)
    ]
    width = robot.dependent_v.size
    condition: Array = np.linalg.cond(np.reshape(jacobians, (len(jacobians), width, width)))
    return condition.reshape(heights.shape[:-1])


def _tip_determinant(robot: PSP3, tilt: Array, azimuth: Array) -> Array:
    determinant: Array = np.linalg.det(
        robot.tip_jacobian(robot.inverse_kinematics(0.0, tilt, azimuth))
    )
    return determinant


def _check_psp3(robot: object) -> None:
    checked_kind("robot", robot, PSP3, "a 3-PSP, as psp3.load() returns it")


def _angles(**arguments: ArrayLike) -> list[Array]:
    """Return finite float arrays, broadcast against each other."""
    arrays = []
    for name, value in arguments.items():
        arrays.append(finite_array(name, value))
    try:
        return [array.copy() for array in np.broadcast_arrays(*arrays)]
    except ValueError as error:
        raise InvalidArray(
            " and ".join(arguments), "(...,) that can be broadcast", arrays[0]
        ) from error
