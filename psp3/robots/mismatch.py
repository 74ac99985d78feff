"""Loops that are inconsistent by rounding, and other likely mistakes of a file.

What is allowed, refused and told when a robot is made of its parts.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from psp3.closure.structure import EXACT, LARGEST_MISMATCH, TOLD_MISMATCH, WEAK, Structure
from psp3.errors import MobilityMismatch, RoundedLoops
from psp3.robots.simple_joints import is_round

ALLOWED_MISMATCH = 10.0
"""Elsewhere in the workspace loops may stay open by so many times what was found near home."""


MOVES = 1e-3
"""Share of a motion from which on a joint takes part in it."""


class ClosureMismatch(NamedTuple):
    """How far a robot's loops contradict themselves, and what that did to its home."""

    length: float
    """How far redundant closure equations stay open in position [m]."""
    angle: float
    """And in direction [rad]."""
    home_moved: float
    """How far the reference pose is from the one that was given, in any joint [m, rad]."""


def allowance(found: Structure) -> tuple[float, float]:
    """Return the residual that loops may keep by rounding, and the weakest pivot that counts."""
    if found.mismatch <= EXACT:
        return 0.0, 0.0
    # In meters and radians at once: the kernels look at the largest.
    return ALLOWED_MISMATCH * max(found.length, found.angle), 3.0 * found.dropped


def refuse(
    found: Structure,
    found_mobility: Any,
    actuated: Sequence[str],
    names: Sequence[str],
) -> None:
    """Refuse a mechanism that does not move, or whose loops do not agree."""
    freedoms = found_mobility.degrees_of_freedom
    if found.mismatch > LARGEST_MISMATCH or (freedoms == 0 and found.mismatch > EXACT):
        raise RoundedLoops(names[found.worst], found.length, found.angle, freedoms)
    if freedoms == 0:
        raise MobilityMismatch(found_mobility, actuated)


def warnings_of(robot: Any, loop: str, found: Structure) -> list[str]:
    """Return what is told of a robot: rounded loops, limits not kept, and motions that are held.

    ``loop`` is the one that is most open.
    """
    told = []
    if found.mismatch > TOLD_MISMATCH:
        told.append(
            f"{robot.title}: redundant loops contradict each other by {found.length:.2g} m and "
            f"{found.angle:.2g} rad, most of all {loop!r}; they are closed as well as they can be, "
            f"and home was moved by {robot.closure_mismatch.home_moved:.2g} (m, rad): more digits "
            f"would close them (robot.closure_mismatch){_if_exact(robot.model, found)}"
        )
    if found.is_stuck:
        joints = _stuck(robot.model, found)
        these = f"of {', '.join(joints)} " if joints else ""
        told.append(
            f"{robot.title}: home is a singular pose that the loops do not leave: a motion {these}"
            f"counts as free ({found.freedoms} degrees of freedom), though the loops hold it "
            "farther on: make a joint of it fixed, or give another closed pose (home in an SRDF or "
            "a key frame)"
        )
    if robot.without_limits:
        told.append(
            f"{robot.title}: the reference pose has {'; '.join(map(str, robot.without_limits))}, "
            "so that these limits are not kept: correct them, or give a closed pose within them "
            "(home in an SRDF or a key frame)"
        )
    if robot.options["free"] == "keep":
        # Nothing feels how a round rod has turned; what else is held, hinges cannot replace.
        felt = [one for one in robot.locked if one.spin and not is_round(robot.model, one.spin)]
        remedy = "its ball has damping, friction or armature, so that no hinges can replace it"
    else:
        felt = list(robot.locked)
        remedy = 'free="keep" makes them coordinates, free="refuse" refuses the robot'
    if felt:
        told.append(
            f"{robot.title}: no motor commands these motions, which are held where they are: "
            f"{'; '.join(map(str, felt))}; a body that would turn keeps its inertia where it is, "
            f"also off its axis ({remedy})"
        )
    return told


def _if_exact(model: Any, found: Structure) -> str:
    """Return what follows if the numbers are not rounded, where that cannot be told."""
    exact = found.exact
    if exact is None:
        return ""
    free, held = _moving(found), ~_moving(exact)
    joints = _names(model, free & held)
    remedy = (
        f"make {', '.join(joints)} fixed, which cannot move then"
        if joints
        else f"hold its motions by longer levers, by {WEAK:.0e} of the strongest and more"
    )
    return (
        f"; but if its numbers are exact, it has {exact.freedoms} instead of {found.freedoms} "
        f"degrees of freedom, for the loops hold the others, by {exact.kept:.1g} of the strongest: "
        f"{remedy}"
    )


def _stuck(model: Any, found: Structure) -> list[str]:
    """Return the joints that seem to move, and do not."""
    ways = [np.abs(pin.difference(model, found.home, pose)) for pose in found.poses]
    return _names(model, _moving(found) & (np.max(ways, axis=0) < MOVES))


def _moving(found: Structure) -> Any:
    """Return which velocities take part in a motion, at any pose, (nv,)."""
    return np.max([np.linalg.norm(basis, axis=1) for basis in found.motions], axis=0) > MOVES


def _names(model: Any, velocities: Any) -> list[str]:
    """Return the joints of some velocities."""
    return [
        str(name)
        for name, joint in zip(list(model.names)[1:], list(model.joints)[1:], strict=True)
        if velocities[joint.idx_v : joint.idx_v + joint.nv].any()
    ]
