"""A report on a robot: its parts, what was changed to make it move, and doubts about its file."""

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
"""A coordinate that moves this share of what another one does moves nothing."""


HELD = (
    ("", False, 'actuated=[...] names more motors, free="keep" makes them coordinates'),
    ("the spin of ", True, "nothing, of a rod; of more, hold or drive it (joint_type)"),
)
"""Motions that are held: what they are called, whether a ball's, and what can be done."""


class Finding(NamedTuple):
    """Something that the owner of a file should know, and what can be done about it."""

    what: str
    remedy: str


class Examination(NamedTuple):
    """What a robot is made of."""

    title: str
    bodies: int
    """Bodies that move."""
    mass: float
    """Of these [kg]."""
    joints: int
    motors: tuple[str, ...]
    coordinates: tuple[str, ...]
    loops: tuple[tuple[str, str], ...]
    """Name and kind of each closure."""
    mobility: str
    """Degrees of freedom, in words."""
    held: tuple[str, ...]
    """Motions that no motor commands, and that are held."""
    redundant_equations: int
    mismatch: tuple[float, ...]
    """How far redundant loops stay open [m], [rad], and how far that moved home [m, rad]."""
    size: float
    """How far apart its joints are [m]."""
    mujoco: str
    """How well MuJoCo agrees about the file, if it reads such files and is installed."""
    findings: tuple[Finding, ...]


def examine(robot: ClosedLoopRobot) -> Examination:
    """Look at a robot that was loaded.

    Parameters
    ----------
    robot : ClosedLoopRobot
        The robot.

    Returns
    -------
    Examination
        What it is made of, with findings of motions that are held, motors that others determine,
        joints that are beyond their limits, loops that contradict themselves, bodies that have an
        inertia that no rigid body has, coordinates that move next to nothing, and of what MuJoCo
        reads otherwise.
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
            # A ball that is held in several directions once.
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
    """Tell a coordinate that moves nothing: forward dynamics divides by its inertia."""
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
