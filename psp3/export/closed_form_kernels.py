"""The functions of the 3-PSP's C code: kernels of its closed form, for one state.

These functions are translated to C, and also run in Python. Each returns a code; unless it is
``DONE``, the results are NaN.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from psp3.checks import Array, Indices
from psp3.three_psp import closed_form
from psp3.three_psp.closed_form import (
    inverse_kinematics_tip,
    tip_jacobian,
)

DONE, REFUSED = range(2)
"""Codes: done; no such pose of the robot, or a number that is not finite."""

_configuration = closed_form.configuration
_equation_of_motion = closed_form.equation_of_motion
_forward_dynamics = closed_form.forward_dynamics
_forward_kinematics = closed_form.forward_kinematics
_inverse_dynamics = closed_form.inverse_dynamics


class ThreePSP(NamedTuple):
    """The robot as translated kernels take it."""

    parameters: Array
    order: Indices
    """Indices of the legs' heights, angles and arm lengths in a configuration, (15,)."""


def ended(row, out):
    """Return the code of a kernel of the closed form; after a refusal set the results to NaN."""
    if row == -1:
        return DONE
    for i in range(out.size):
        out[i] = math.nan
    return REFUSED


def forward_kinematics(robot, heights, center, rotation, arms, tip):
    """Write the pose of the star."""
    out = np.empty(18)
    code = ended(_forward_kinematics(heights, robot.parameters, out), out)
    for i in range(3):
        center[i], arms[i], tip[i] = out[i], out[12 + i], out[15 + i]
    for i in range(9):
        rotation[i] = out[3 + i]
    return code


def configuration(robot, heights, q):
    """Write the coordinates of all joints (15)."""
    out = np.empty(15)
    code = ended(_configuration(heights, robot.parameters, out), out)
    for i in range(15):
        q[robot.order[i]] = out[i]
    return code


def tip_heights(robot, tip, heights):
    """Write the heights that put the tip at a point."""
    return ended(inverse_kinematics_tip(tip, robot.parameters, heights), heights)


def jacobian(robot, heights, J):
    """Write the Jacobian of the tip (3, 3)."""
    return ended(tip_jacobian(heights, robot.parameters, J), J)


def inverse_dynamics(robot, heights, speeds, accelerations, forces):
    """Write the screw forces of a motion."""
    row = _inverse_dynamics(heights, speeds, accelerations, robot.parameters, forces)
    return ended(row, forces)


def forward_dynamics(robot, heights, speeds, forces, accelerations):
    """Write the accelerations under screw forces."""
    row = _forward_dynamics(heights, speeds, forces, robot.parameters, accelerations)
    return ended(row, accelerations)


def equation_of_motion(robot, heights, speeds, M, C, G):
    """Write mass matrix (3, 3), Coriolis matrix (3, 3) and gravity (3)."""
    out = np.empty(21)
    code = ended(_equation_of_motion(heights, speeds, robot.parameters, out), out)
    for i in range(9):
        M[i], C[i] = out[i], out[9 + i]
    for i in range(3):
        G[i] = out[18 + i]
    return code


def mass(robot, heights, M):
    """Write the mass matrix (3, 3), as :func:`equation_of_motion` does at rest."""
    speeds, C, G = np.zeros(3), np.empty(9), np.empty(3)
    return equation_of_motion(robot, heights, speeds, M, C, G)
