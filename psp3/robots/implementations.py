"""Implementations of the equation of motion of any robot, by name."""

from __future__ import annotations

from typing import Any

from psp3.closure.structure import EXACT
from psp3.dynamics.dynamics_model import DynamicsModel
from psp3.errors import InvalidValue, UnknownName

DYNAMICS_MODELS = ("core", "pinocchio", "noc")
"""Names of the implementations of the equation of motion of any robot."""


def implementation(robot: Any, name: str) -> DynamicsModel:
    """Return an implementation of a robot's equation of motion, one of ``DYNAMICS_MODELS``.

    Raises
    ------
    UnknownName
        If there is no implementation of that name; the error lists the known ones.
    InvalidValue
        If the thesis's method does not cover a part of the robot.
    """
    if name == "core":
        core: DynamicsModel = robot
        return core
    unknown = unknown_to_the_thesis(robot)
    if unknown and name == "noc":
        raise InvalidValue(
            "robot",
            f"{robot.title} with {unknown}",
            "a tree with closures at points or frames and nothing else for robot.dynamics('noc') "
            "(robot.dynamics('pinocchio') covers every robot)",
        )
    if name == "pinocchio":
        from psp3.dynamics.projected import ProjectedDynamics

        return ProjectedDynamics(robot)
    if name == "noc":
        from psp3.dynamics.natural_orthogonal_complement import NaturalOrthogonalComplement

        return NaturalOrthogonalComplement(robot)
    raise UnknownName("dynamics model", name, DYNAMICS_MODELS)


def unknown_to_the_thesis(robot: Any) -> str:
    """Return the parts of the robot that the thesis's method does not cover; empty if none."""
    mismatch = robot.closure_mismatch
    parts = {
        "hinges or couplings": bool(robot.equations),
        "a ball whose spin is held": any(one.spin is not None for one in robot.locked),
        "springs": bool(robot.springs),
        "a floating base": len(robot.coordinates_q) != len(robot.coordinates_v),
        "joint damping": bool(robot.model.damping.any()),
        "dry friction": bool(robot.model.upperDryFrictionLimit.any()),
        "loops closed in the least-squares sense": max(mismatch.length, mismatch.angle) > EXACT,
    }
    return ", ".join(part for part, is_there in parts.items() if is_there)
