"""Loops that rounding makes inconsistent, and other likely mistakes in a file.

The module decides what is allowed, refused and logged when a robot is constructed.
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
"""Elsewhere in the workspace, loops may stay open by this many times the residual near home."""


MOVES = 1e-3
"""Smallest share of a motion with which a joint takes part in it."""


class Finding(NamedTuple):
    """A problem that the owner of a file should know about, and its remedy."""

    what: str
    remedy: str

    def __str__(self) -> str:
        return f"{self.what}: {self.remedy}"


class ClosureMismatch(NamedTuple):
    """How far a robot's loops contradict themselves, and how far this moved its home."""

    length: float
    """Position residual of redundant closure equations [m]."""
    angle: float
    """Their angular residual [rad]."""
    home_moved: float
    """Largest difference of any joint between the reference pose and the given one [m, rad]."""


def allowance(found: Structure) -> tuple[float, float]:
    """Return the residual that rounding may leave in loops, and the weakest pivot that counts."""
    if found.mismatch <= EXACT:
        return 0.0, 0.0
    # Meters and radians are not distinguished, because the kernels compare the largest residual.
    return ALLOWED_MISMATCH * max(found.length, found.angle), 3.0 * found.dropped


def refuse(
    found: Structure,
    found_mobility: Any,
    actuated: Sequence[str],
    names: Sequence[str],
) -> None:
    """Refuse a mechanism that cannot move, or whose loops contradict each other."""
    freedoms = found_mobility.degrees_of_freedom
    if found.mismatch > LARGEST_MISMATCH or (freedoms == 0 and found.mismatch > EXACT):
        raise RoundedLoops(names[found.worst], found.length, found.angle, freedoms)
    if freedoms == 0:
        raise MobilityMismatch(found_mobility, actuated)


def findings_of_loops(
    model: Any, loop: str, found: Structure, home_moved: float
) -> tuple[Finding, ...]:
    """Return what is doubtful about loops: rounded ones, and a home that they do not leave.

    ``loop`` names the loop that is most open. The warnings of a robot and its examination both say
    this.
    """
    findings = []
    if found.mismatch > TOLD_MISMATCH:
        # A home that was searched for is closed to less than this.
        is_moved = home_moved > TOLD_MISMATCH
        moved = f", and home was moved by {home_moved:.2g} (m, rad)" if is_moved else ""
        findings.append(
            Finding(
                f"redundant loops contradict each other by {found.length:.2g} m and "
                f"{found.angle:.2g} rad, most of all {loop!r}; they are closed as well as they can "
                f"be{moved}",
                "write the file with more digits, because forward dynamics is as good as they are"
                f"{_if_exact(model, found)}",
            )
        )
    if found.is_stuck:
        joints = _stuck(model, found)
        these = f"of {', '.join(joints)} " if joints else ""
        findings.append(
            Finding(
                f"home is a singular pose that the loops do not leave: a motion {these}counts as "
                f"free ({found.freedoms} degrees of freedom), although the loops block it farther "
                "on",
                "make one of its joints fixed, or give another closed pose (home in an SRDF or a "
                "key frame)",
            )
        )
    return tuple(findings)


def warnings_of(robot: Any) -> list[str]:
    """Return the warnings about a robot: doubtful loops, removed limits and held motions."""
    told = [f"{robot.title}: {finding}" for finding in robot.loop_findings]
    if robot.without_limits:
        told.append(
            f"{robot.title}: the reference pose has {'; '.join(map(str, robot.without_limits))}, "
            "so these limits are not enforced: correct them, or give a closed pose within them "
            "(home in an SRDF or a key frame)"
        )
    if robot.options["free"] == "keep":
        # The spin of a round rod has no effect. Other held spins are those that hinges cannot
        # replace.
        felt = [one for one in robot.locked if one.spin and not is_round(robot.model, one.spin)]
        remedy = "its ball has damping, friction or armature, so that no hinges can replace it"
    else:
        felt = list(robot.locked)
        remedy = 'free="keep" makes them coordinates, free="refuse" refuses the robot'
    if felt:
        told.append(
            f"{robot.title}: no motor commands these motions, which are held where they are: "
            f"{'; '.join(map(str, felt))}; a body whose spin is held does not spin, even if its "
            f"inertia is not symmetric about the axis ({remedy})"
        )
    return told


def _if_exact(model: Any, found: Structure) -> str:
    """Return what holds if the numbers are exact, if that cannot be excluded."""
    exact = found.exact
    if exact is None:
        return ""
    free, held = _moving(found), ~_moving(exact)
    joints = _names(model, free & held)
    remedy = (
        f"make {', '.join(joints)} fixed, because they cannot move then"
        if joints
        else f"make the levers longer, until they hold with {WEAK:.0e} of the strongest"
    )
    return (
        f"; but if its numbers are exact, it has {exact.freedoms} instead of {found.freedoms} "
        f"degrees of freedom, because the loops block the others, with {exact.kept:.1g} of the "
        f"strongest: {remedy}"
    )


def _stuck(model: Any, found: Structure) -> list[str]:
    """Return the joints whose motion counts as free, and that no pose has moved."""
    ways = [np.abs(pin.difference(model, found.home, pose)) for pose in found.poses]
    return _names(model, _moving(found) & (np.max(ways, axis=0) < MOVES))


def _moving(found: Structure) -> Any:
    """Return whether each velocity takes part in a motion at any pose, (nv,)."""
    return np.max([np.linalg.norm(basis, axis=1) for basis in found.motions], axis=0) > MOVES


def _names(model: Any, velocities: Any) -> list[str]:
    """Return the joints of some velocities."""
    return [
        str(name)
        for name, joint in zip(list(model.names)[1:], list(model.joints)[1:], strict=True)
        if velocities[joint.idx_v : joint.idx_v + joint.nv].any()
    ]
