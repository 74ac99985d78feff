"""Names and units of the variables of an FMU.

A unit is written as FMI does: ``"N.m"``, ``"rad/s2"``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from psp3.export.fmu_model import Causality, Variable
from psp3.kinematics.tasks import rotating


@dataclass(frozen=True)
class Names:
    """Names and units of a robot's positions (p), speeds (n) and motors (m).

    Parameters
    ----------
    positions, speeds, motors : tuple of (str, str)
        Each name with the unit of a position; the unit is empty if there is none or it is unknown.
    commanded : int
        Number of positions that the motors command, which come first.
    """

    positions: tuple[tuple[str, str], ...]
    speeds: tuple[tuple[str, str], ...]
    motors: tuple[tuple[str, str], ...]
    commanded: int

    @classmethod
    def of(cls, robot: Any) -> Names:
        """Return the names and units of a robot."""
        turning, model = rotating(robot.model), robot.model
        positions: list[tuple[str, str]] = []
        speeds: list[tuple[str, str]] = []
        for name in robot.coordinates:
            joint = model.joints[model.getJointId(name)]
            units = ["rad" if turning[joint.idx_v + k] else "m" for k in range(joint.nv)]
            speeds += _numbered(name, units)
            # A floating base has its position first, and then a quaternion, or cosine and sine.
            way = units if joint.nq == joint.nv else [unit for unit in units if unit == "m"]
            positions += _numbered(name, [*way, *[""] * (joint.nq - len(way))])
        joints = {
            name: "rad" if turning[joint.idx_v] else "m"
            for name, joint in zip(model.names, model.joints, strict=True)
            if joint.nv == 1
        }
        # The unit of a tendon is not known.
        motors = tuple((name, joints.get(name, "")) for name in robot.actuated)
        return cls(tuple(positions), tuple(speeds), motors, robot.commanded)


def _numbered(name: str, units: list[str]) -> list[tuple[str, str]]:
    if len(units) == 1:
        return [(name, units[0])]
    return [(f"{name}_{k}", unit) for k, unit in enumerate(units, 1)]


def force(unit: str) -> str:
    """Return the unit of the force at a joint with positions of a unit."""
    return {"m": "N", "rad": "N.m"}.get(unit, "")


def variables(
    kind: str,
    about: str,
    joints: Iterable[tuple[str, str]],
    unit_of: Callable[[str], str],
    causality: Causality,
    start: Any = None,
) -> list[Variable]:
    """Return a variable for each joint.

    Parameters
    ----------
    kind : str
        Prefix of the names, such as ``"position"``.
    about : str
        Description of each, before the name of its joint.
    joints : iterable of (str, str)
        Names, with the units of positions.
    unit_of : callable
        Returns the unit, given that of a position.
    causality : {"parameter", "input", "output"}
        Causality of all.
    start : ndarray, optional
        Initial values; zeros by default.
    """
    return [
        Variable(
            f"{kind}_{name}",
            f"{about} of {name}",
            unit_of(unit),
            causality,
            0.0 if start is None else float(start[i]),
        )
        for i, (name, unit) in enumerate(joints)
    ]


def position(unit: str) -> str:
    """Return the unit of a position, from which the other units are derived."""
    return unit


def speed(unit: str) -> str:
    """Return the unit of a speed."""
    return f"{unit}/s" if unit else ""


def acceleration(unit: str) -> str:
    """Return the unit of an acceleration."""
    return f"{unit}/s2" if unit else ""
