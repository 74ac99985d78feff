"""What a robot file holds, and where the files of the shipped robots are."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from psp3.checks import Array
from psp3.errors import InvalidRobotFile

MOST_SPEEDS = 150
"""Joints, and speeds of all of them, of a robot that is read from a file: times of its first pose
and of its memory grow with the third power and more.
"""


def check_number(path: str | Path, count: int, what: str) -> None:
    """Raise :class:`InvalidRobotFile` if there are more joints or speeds than are read."""
    if count > MOST_SPEEDS:
        raise InvalidRobotFile(
            path,
            f"has {count} {what}, and at most {MOST_SPEEDS} are read: make joints that need not "
            "move fixed, or read the mechanisms of a scene one at a time",
        )


class RobotParts(NamedTuple):
    """What the files of a robot hold.

    In the order in which :class:`psp3.ClosedLoopRobot` takes it.
    """

    model: Any
    """The tree, a ``pinocchio.Model``."""
    constraint_models: Any
    """The loops, a ``pinocchio.StdVec_RigidConstraintModel``."""
    actuated: tuple[str, ...]
    """Names of the actuated joints."""
    q0: Array | None
    """The pose ``home``, (nq,), where the files have it."""
    visual_model: Any
    """The shapes, a ``pinocchio.GeometryModel``."""
    equations: tuple[Any, ...] = ()
    """Closures that Pinocchio has no model of: hinges and couplings."""
    springs: dict[str, tuple[float, float]] = {}  # noqa: RUF012 - never changed
    """Stiffness and rest of joints that have a spring."""
    tendons: dict[str, dict[str, float]] = {}  # noqa: RUF012 - never changed
    """Motors that drive several joints, with the lever of each."""


ROBOT_FILES = Path(__file__).resolve().parents[1] / "urdf"
"""Directory of the robot description files that come with the package."""

THESIS_ROBOTS = ("psp3", "five_bar", "planar_3rrr", "delta", "gough_stewart", "tricept")
"""Names of the robots of the thesis's figures, whose motors are as many as their freedoms."""

MJCF_ROBOTS = ("hexa", "gripper", "biped")
"""Names of those whose file is an MJCF, since a URDF has no words for what they have."""

ROBOTS = (*THESIS_ROBOTS, "planar_4rrr", "jansen", "agile_eye", *MJCF_ROBOTS)
"""Names of the robots that come with the package."""
