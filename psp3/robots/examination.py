"""Report on a robot: its parts, changes that were made on loading, and doubts about its file."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from psp3.closure.structure import closure_names, robot_size
from psp3.description.mjcf_tree import BETWEEN_JOINTS
from psp3.multibody.equations import Coupling, Hinge
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from psp3.robots.inertias import impossible
from psp3.robots.mismatch import Finding
from psp3.robots.second_opinion import Opinion, mujoco_opinion

LIGHT = 1e-9
"""A coordinate moves nothing if it moves less than this share of what another one moves."""


HELD = (
    ("", False, 'actuated=[...] names more motors, free="keep" makes them coordinates'),
    ("the spin of ", True, "nothing for a rod; else hold or drive it (joint_type)"),
)
"""Held motions: their names, whether each is the spin of a ball joint, and the remedy."""


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
        beyond their limits, loops that contradict themselves or do not leave home, bodies with an
        impossible inertia, moving links without mass, coordinates that move almost no mass, and
        differences from MuJoCo's reading.
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
            *robot.loop_findings,
            *_of_inertias(robot.model),
            *_of_missing_mass(robot.model),
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
        motors = _counted(robot.mobility.over_actuation, "more motor")
        findings.append(
            Finding(
                f"{motors} than freedoms: {followers} could be left out",
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
            f"MuJoCo reads {_counted(len(opinion.disagreements), 'number')} of this file otherwise",
            "compare the two readings above; if ours is wrong, please report it",
        )
    ]


def _counted(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


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


def _of_missing_mass(model: pin.Model) -> list[Finding]:
    """Report links without mass that move, unless a reader made them.

    All that is fixed to each other is one body, named after its first link. Joints that this
    package adds, such as the first one of a universal joint, carry no link.
    """
    names = []
    for number, inertia in list(enumerate(model.inertias))[1:]:
        # An inertia without mass is a finding of its own.
        if inertia.mass == 0.0 and not impossible(inertia):
            names += _links(model, number)[:1]
    if not names:
        return []
    links = f"link {names[0]} has" if len(names) == 1 else f"links {', '.join(names)} have"
    return [
        Finding(
            f"the moving {links} no mass",
            "give mass and inertia, except to a part that stands for no body, such as the cross "
            "of a universal joint",
        )
    ]


def _links(model: pin.Model, joint: int) -> list[str]:
    """Return the links of a file that move with a joint."""
    return [
        str(frame.name)
        for frame in model.frames
        if (frame.parentJoint, frame.type) == (joint, pin.FrameType.BODY)
        and not _is_between_joints(model, frame.name)
    ]


def _is_between_joints(model: pin.Model, name: str) -> bool:
    """Tell whether the reader of MJCF made a body, because another one has several joints."""
    match = BETWEEN_JOINTS.fullmatch(name)
    return match is not None and model.existFrame(match["owner"], pin.FrameType.BODY)


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
