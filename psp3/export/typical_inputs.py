"""What functions in C are tested with: states about the motions that a robot can make."""

from __future__ import annotations

import numpy as np

from fuzzy2.export.project_cases import CASES, drawn
from psp3.checks import Array
from psp3.robots.robot import Robot
from psp3.trajectories.motion import Motion
from psp3.trajectories.paths import Helix
from psp3.trajectories.sway import Sway

PERIOD = 0.05
"""From one case to the next [s]."""

ERROR = 0.02
"""Of what is found, as a share of the range of what is desired."""

REACH = 0.02
"""Of the tip about its place at the reference, along each axis [m]."""


def of_robot(robot: Robot) -> dict[str, Array]:
    """Return inputs of the functions of a robot, by the names of their arguments.

    Positions and speeds are about the reference, as far as the robot sways; coordinates that follow
    stay there. Forces are what such motions take.

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
    """Return inputs of the functions of a controller, by the names of their arguments.

    The desired motion is the helix of the 3-PSP, another robot sways; what is found is near it.

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
    """Return how far each of several numbers goes from its middle, (n,)."""
    reach: Array = np.ptp(samples, axis=0) / 2.0
    return reach


def _about(middle: Array, reach: Array) -> tuple[Array, Array]:
    """Return a range about a middle (n,); what has no reach stays there."""
    width = np.zeros(len(middle))
    width[: len(reach)] = reach
    return middle - width, middle + width
