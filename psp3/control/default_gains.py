"""Default gains for any robot: a critically damped loop in the reference pose."""

from __future__ import annotations

from typing import Any

import numpy as np

from psp3.checks import Array
from psp3.control.classical import critically_damped_gains
from psp3.robots.robot import Robot

BANDWIDTH = 20.0
"""Bandwidth of the loop [rad/s]."""

INTEGRAL_SHARE = 0.1
"""Integral gain of a PID, as a share of its stability limit."""

OF_FORCES = ("pd", "pd-gravity", "pid")
"""Names of the controllers whose gains give forces; those of the others give accelerations."""


def default_gains(robot: Robot, controller: str) -> dict[str, Any]:
    r"""Return gains of a critically damped loop in the reference pose.

    See :func:`psp3.control.classical.critically_damped_gains`. A PID has a tenth of the integral
    gain :math:`k_p k_v / m` at which the loop becomes unstable, where m is the least mass that its
    motors move.

    Parameters
    ----------
    robot : Robot
        The robot.
    controller : str
        Name of the controller, as for ``psp3 simulate --controller``.

    Returns
    -------
    dict
        ``kp`` and ``kv``, also ``ki`` for ``"pid"``; empty for ``"feed-forward"``.
    """
    if controller == "feed-forward":
        return {}
    if controller not in OF_FORCES:
        kp, kv = critically_damped_gains(BANDWIDTH)
        return {"kp": kp, "kv": kv}
    mass = moved_mass(robot)
    kp, kv = critically_damped_gains(BANDWIDTH, mass)
    gains = {"kp": kp, "kv": kv}
    if controller == "pid":
        # A mass m with these gains is stable up to ki = kp kv / m. The gains grow with the mass
        # matrix, so the least m decides.
        omega = float(kv[0, 0] / (2.0 * mass[0, 0]))
        least = float(np.linalg.eigvalsh(mass)[0])
        gains["ki"] = INTEGRAL_SHARE * 2.0 * omega**3 * least
    return gains


def moved_mass(robot: Robot) -> Array:
    """Return the mass matrix that the motors feel at the reference, with passive joints free."""
    mass, k = robot.mass_matrix(robot.reference), robot.commanded
    if k == len(mass):
        return mass
    moved: Array = mass[:k, :k] - mass[:k, k:] @ np.linalg.solve(mass[k:, k:], mass[k:, :k])
    return moved
