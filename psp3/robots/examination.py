"""Report on a robot: its parts, changes that were made on loading, and doubts about its file."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from psp3.closure.structure import TOLD_MISMATCH, closure_names, robot_size
from psp3.multibody.equations import Coupling, Hinge
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from psp3.robots.inertias import impossible
from psp3.robots.second_opinion import Opinion, mujoco_opinion

LIGHT = 1e-9
"""A coordinate moves nothing if it moves less than this share of what another one moves."""


HELD = (
    ("", False, 'actuated=[...] names more motors, free="keep" makes them coordinates'),
    ("the spin of ", True, "nothing for a rod; else hold or drive it (joint_type)"),
)
"""Held motions: their names, whether each is the spin of a ball joint, and the remedy."""


class Finding(NamedTuple):
    """A problem that the owner of a file should know about, and its remedy."""

    what: str
    remedy: str


class Examination(NamedTuple):
    """What a robot is made of."""

    title: str
    bodies: int
    """Number of moving bodies."""
    mass: float
    """Mass of the moving bodies [kg]."""
    joints: int
    motors: tuple[str, ...]
    coordinates: tuple[str, ...]
    loops: tuple[tuple[str, str], ...]
    """Name and kind of each closure."""
    mobility: str
    """Degrees of freedom, in words."""
    held: tuple[str, ...]
    """Held motions, which no motor commands."""
    redundant_equations: int
    mismatch: tuple[float, ...]
    """Residual of redundant loops [m], [rad], and how far it moved home [m, rad]."""
    size: float
    """Largest distance between its joints [m]."""
    mujoco: str
    """MuJoCo's reading of the file compared with this one, if MuJoCo reads such files and is
    installed.
    """
    findings: tuple[Finding, ...]


def examine(robot: ClosedLoopRobot) -> Examination:
    """Examine a robot after loading.

    Parameters
    ----------
    robot : ClosedLoopRobot
        The robot.

    Returns
    -------
    Examination
        Its parts, with findings about held motions, motors that other motors determine, joints
        beyond their limits, loops that contradict themselves, bodies with an impossible inertia,
        coordinates that move almost no mass, and differences from MuJoCo's reading.
    """
    opinion = mujoco_opinion(robot)
    closures = [*robot.constraint_models, *robot.equations]
    return Examination(
        title=robot.title,
        bodies=robot.model.njoints - 1,
        mass=float(sum(inertia.mass for inertia in list(robot.model.inertias)[1:])),
        joints=robot.model.njoints - 1,
        motors=robot.actuated,
        coordinates=robot.coordinates,
        loops=tuple(zip(closure_names(closures), map(_kind, closures), strict=True)),
        mobility=str(robot.mobility),
        held=tuple(map(str, robot.locked)),
        redundant_equations=robot.mobility.redundant_equations,
        mismatch=tuple(robot.closure_mismatch),
        size=robot_size(robot.model, robot.q0),
        mujoco=opinion.summary,
        findings=(
            *_of_motions(robot),
            *_of_limits(robot),
            *_of_loops(robot),
            *_of_inertias(robot.model),
            *_of_mass_matrix(robot),
            *_of_opinion(opinion),
        ),
    )


def _kind(closure: Any) -> str:
    if isinstance(closure, Coupling):
        return "coupling"
    if isinstance(closure, Hinge):
        return "hinge"
    return "6d" if closure.type == pin.ContactType.CONTACT_6D else "3d"


def _of_motions(robot: ClosedLoopRobot) -> list[Finding]:
    findings = []
    for kind, is_spin, remedy in HELD:
        joints = [one.joint for one in robot.locked if (one.spin is not None) == is_spin]
        if joints:
            # A ball joint that is held about several axes is listed once.
            names = ", ".join(dict.fromkeys(joints))
            findings.append(Finding(f"no motor commands {kind}{names}: held at home", remedy))
    if robot.mobility.over_actuation:
        followers = ", ".join(robot.mobility.dependent_actuators)
        findings.append(
            Finding(
                f"{robot.mobility.over_actuation} more motors than freedoms: {followers} could "
                "be left out",
                "actuator_forces shares the work between them; preload has what they can do "
                "against each other",
            )
        )
    return findings


def _of_limits(robot: ClosedLoopRobot) -> list[Finding]:
    if not robot.without_limits:
        return []
    return [
        Finding(
            f"the reference pose has {'; '.join(map(str, robot.without_limits))}: these limits are "
            "not kept",
            "correct the ranges, or give a closed pose within them (home in an SRDF or key frame)",
        )
    ]


def _of_opinion(opinion: Opinion) -> list[Finding]:
    if not opinion.disagreements:
        return []
    return [
        Finding(
            f"MuJoCo reads {len(opinion.disagreements)} numbers of this file otherwise",
            "compare the two readings above; if ours is wrong, please report it",
        )
    ]


def _of_loops(robot: ClosedLoopRobot) -> list[Finding]:
    length, angle, moved = robot.closure_mismatch
    if max(length / robot_size(robot.model, robot.q0), angle) <= TOLD_MISMATCH:
        return []
    return [
        Finding(
            f"the loops contradict each other by {length:.2g} m and {angle:.2g} rad; they are "
            f"closed as well as they can be, and home was moved by {moved:.2g} (m, rad)",
            "write the file with more digits: forward dynamics is as good as its digits",
        )
    ]


def _of_inertias(model: pin.Model) -> list[Finding]:
    findings = []
    for name, inertia in list(zip(model.names, model.inertias, strict=True))[1:]:
        what = impossible(inertia)
        if what:
            findings.append(
                Finding(
                    f"what joint {name!r} carries has an inertia that no rigid body has: {what}",
                    "take mass, center and moments from one source",
                )
            )
    return findings


def _of_mass_matrix(robot: ClosedLoopRobot) -> list[Finding]:
    """Report a coordinate that moves no mass, because forward dynamics divides by its inertia."""
    diagonal = np.diag(robot.mass_matrix(robot.reference))
    lightest = np.flatnonzero(diagonal <= LIGHT * diagonal.max())
    return [
        Finding(
            f"coordinate {k + 1} moves next to nothing ({diagonal[k]:.2g} beside "
            f"{diagonal.max():.2g} kg or kg m²)",
            "give its bodies their mass and inertia, or its motor an armature",
        )
        for k in lightest
    ]
