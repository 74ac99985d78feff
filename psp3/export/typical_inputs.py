"""Inputs for tests of functions in C: states around motions that a robot can make."""

from __future__ import annotations

import numpy as np

from fuzzy2.export.project_cases import CASES, drawn
from psp3.checks import Array
from psp3.robots.robot import Robot
from psp3.trajectories.motion import Motion
from psp3.trajectories.paths import Helix
from psp3.trajectories.sway import Sway

PERIOD = 0.05
"""Time between consecutive cases [s]."""

ERROR = 0.02
"""Deviation of the measured state, as a share of the range of the desired one."""

REACH = 0.02
"""Amplitude of the tip around its reference position, along each axis [m]."""


def of_robot(robot: Robot) -> dict[str, Array]:
    """Return inputs for the functions of a robot, by argument name.

    Positions and speeds vary around the reference pose as far as the robot sways; passive
    coordinates stay there. Forces are those of such motions.

    Parameters
    ----------
    robot : Robot

    Returns
    -------
    dict of str to ndarray (CASES, n)
    """
    motion = Sway(robot=robot)(np.linspace(0.0, 2.0, 65))
    home, n = robot.reference, len(robot.coordinates_v)
    positions = _about(home, _reach(motion.positions))
    speeds = _about(np.zeros(n), _reach(motion.speeds))
    accelerations = _about(np.zeros(n), _reach(motion.accelerations))
    M, _, G = robot.equation_of_motion(home, np.zeros(n))
    forces = (G - (most := np.abs(M) @ accelerations[1]), G + most)
    ranges = {
        **dict.fromkeys(("positions", "heights"), positions),
        "speeds": speeds,
        "accelerations": accelerations,
        "forces": forces,
    }
    if robot.has_inverse_of_tip:
        tip = np.asarray(robot.tip(home))
        ranges["tip"] = (tip - REACH, tip + REACH)
    return {name: drawn(*ends, seed) for seed, (name, ends) in enumerate(ranges.items())}


def of_controller(robot: Robot) -> dict[str, Array]:
    """Return inputs for the functions of a controller, by argument name.

    The desired motion is the helix for the 3-PSP, and sway for other robots; the measured state is
    near it.

    Parameters
    ----------
    robot : Robot

    Returns
    -------
    dict of str to ndarray (CASES, n)
    """
    path = Helix(robot=robot) if robot.has_inverse_of_tip else Sway(robot=robot)
    times = PERIOD * np.arange(CASES)
    motion: Motion = path(times)
    errors = {
        name: drawn(-ERROR * reach, ERROR * reach, seed)
        for seed, (name, reach) in enumerate(
            (("positions", _reach(motion.positions)), ("speeds", _reach(motion.speeds)))
        )
    }
    home, n = robot.reference, len(robot.coordinates_v)
    positions, speeds = np.tile(home, (CASES, 1)), np.zeros((CASES, n))
    k = motion.positions.shape[1]
    positions[:, :k] = motion.positions + errors["positions"]
    speeds[:, :k] = motion.speeds + errors["speeds"]
    desired = np.concatenate([motion.positions, motion.speeds, motion.accelerations], axis=1)
    return {"t": times[:, None], "positions": positions, "speeds": speeds, "desired": desired}


def _reach(samples: Array) -> Array:
    """Return how far each of several numbers moves from its middle, (n,)."""
    reach: Array = np.ptp(samples, axis=0) / 2.0
    return reach


def _about(middle: Array, reach: Array) -> tuple[Array, Array]:
    """Return a range about a middle (n,); a number without reach stays there."""
    width = np.zeros(len(middle))
    width[: len(reach)] = reach
    return middle - width, middle + width
