"""What a robot file holds, and where the files of the shipped robots are."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from psp3.checks import Array
from psp3.errors import InvalidRobotFile

MOST_SPEEDS = 150
"""The largest number of joints, and of speeds, of a robot from a file. The time to find the first
pose and the memory grow at least with their third power.
"""


def check_number(path: str | Path, count: int, what: str) -> None:
    """Raise :class:`InvalidRobotFile` if there are too many joints or speeds."""
    if count > MOST_SPEEDS:
        raise InvalidRobotFile(
            path,
            f"has {count} {what}, and at most {MOST_SPEEDS} are read: make joints that need not "
            "move fixed, or read the mechanisms of a scene one at a time",
        )


class RobotParts(NamedTuple):
    """What the files of a robot hold.

    The fields are in the order of the arguments of :class:`psp3.ClosedLoopRobot`.
    """

    model: Any
    """The tree, a ``pinocchio.Model``."""
    constraint_models: Any
    """The loops, a ``pinocchio.StdVec_RigidConstraintModel``."""
    actuated: tuple[str, ...]
    """Names of the actuated joints."""
    q0: Array | None
    """The pose ``home``, (nq,); None if the files do not have it."""
    visual_model: Any
    """The shapes, a ``pinocchio.GeometryModel``."""
    equations: tuple[Any, ...] = ()
    """Closures for which Pinocchio has no model: hinges and couplings."""
    springs: dict[str, tuple[float, float]] = {}  # noqa: RUF012 - never changed
    """Stiffness and rest of joints that have a spring."""
    tendons: dict[str, dict[str, float]] = {}  # noqa: RUF012 - never changed
    """Motors that drive several joints, with the lever arm of each joint."""


ROBOT_FILES = Path(__file__).resolve().parents[1] / "urdf"
"""Directory of the robot description files that come with the package."""

THESIS_ROBOTS = ("psp3", "five_bar", "planar_3rrr", "delta", "gough_stewart", "tricept")
"""Names of the robots in the thesis's figures. Each has as many motors as degrees of freedom."""

MJCF_ROBOTS = ("hexa", "gripper", "biped")
"""Names of the robots that have an MJCF file, because a URDF cannot describe them."""

ROBOTS = (*THESIS_ROBOTS, "planar_4rrr", "jansen", "agile_eye", *MJCF_ROBOTS)
"""Names of the robots that come with the package."""
