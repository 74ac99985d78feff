r"""Test whether standard parameters are those of bodies that can exist.

A body of non-negative density has a positive semi-definite pseudo-inertia matrix, and only such
bodies do (P. M. Wensing, S. Kim and J.-J. E. Slotine, Linear matrix inequalities for physically
consistent inertial parameter identification, IEEE Robotics and Automation Letters, 2018). This
condition includes that the mass is not negative and that the principal moments obey the triangle
inequality.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from psp3.checks import Array, checked_robot, one_row
from psp3.robots.closed_loop_robot import ClosedLoopRobot

ROUNDING = 1e-12
"""A negative number up to this relative size counts as a rounded zero."""


@dataclass(frozen=True, eq=False)
class Body:
    """A body that is described by its ten standard parameters.

    Parameters
    ----------
    joint : str
        The joint that carries it.
    mass : float
        Mass [kg].
    center : (3,) ndarray
        Center of mass in the joint's axes [m]; NaN without mass.
    moments : (3,) ndarray
        Principal moments of inertia about the center of mass, ascending [kg m²]; NaN without mass.
    flaws : tuple of str
        Impossible properties; empty if the body can exist.
    """

    joint: str
    mass: float
    center: Array
    moments: Array
    flaws: tuple[str, ...]

    @property
    def physical(self) -> bool:
        """Whether such a body can exist."""
        return not self.flaws


def bodies(robot: ClosedLoopRobot, parameters: ArrayLike) -> tuple[Body, ...]:
    r"""Return the bodies that standard parameters describe, and whether each can exist.

    A body can exist if

    .. math:: \begin{bmatrix} \tfrac12 \operatorname{tr}(I)\, 1 - I & m c \\
              (m c)^T & m \end{bmatrix} \succeq 0

    Parameters
    ----------
    robot : ClosedLoopRobot
        The robot of the bodies.
    parameters : (10 B,) array_like
        Standard parameters in the order of
        :func:`psp3.identification.regressor.standard_parameters`.

    Returns
    -------
    tuple of Body
        In the order of the model's joints.

    Raises
    ------
    InvalidArray
        If the parameters are not finite or of another number.
    """
    checked_robot(robot)
    rows = one_row("parameters", parameters, 10 * (robot.model.njoints - 1)).reshape(-1, 10)
    return tuple(
        _body(str(joint), row) for joint, row in zip(list(robot.model.names)[1:], rows, strict=True)
    )


def pseudo_inertia(parameters: Array) -> Array:
    """Return the pseudo-inertia matrix (4, 4) of ten standard parameters.

    It contains the second moments of the density [kg m²], the first moments [kg m] and the mass
    [kg].
    """
    mass, moment, inertia = parameters[0], parameters[1:4], _inertia(parameters)
    matrix = np.empty((4, 4))
    matrix[:3, :3] = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    matrix[:3, 3] = matrix[3, :3] = moment
    matrix[3, 3] = mass
    return matrix


def _inertia(parameters: Array) -> Array:
    xx, xy, yy, xz, yz, zz = parameters[4:]
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _body(joint: str, parameters: Array) -> Body:
    mass = float(parameters[0])
    center, moments, flaws = np.full(3, np.nan), np.full(3, np.nan), []
    if mass == 0.0:
        if parameters[1:].any():
            flaws.append("no mass, but moments")
        return Body(joint, mass, center, moments, tuple(flaws))
    center = parameters[1:4] / mass
    about_center = _inertia(parameters) - mass * (
        center @ center * np.eye(3) - np.outer(center, center)
    )
    moments = np.asarray(np.linalg.eigvalsh(about_center), dtype=np.float64)
    if mass < 0.0:
        flaws.append("negative mass")
    # Moments about the center of mass are differences of terms of this size.
    allowed = ROUNDING * (np.abs(parameters[4:]).max() + abs(mass) * float(center @ center))
    if moments[0] < -allowed:
        flaws.append("negative moment of inertia")
    if moments[0] + moments[1] < moments[2] - allowed:
        flaws.append("a moment of inertia greater than the sum of the other two")
    return Body(joint, mass, center, moments, tuple(flaws))
