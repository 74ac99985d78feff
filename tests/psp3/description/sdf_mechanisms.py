"""Mechanisms that are written as SDF files, and as free bodies to compare with.

All is given in the world where the file has it; the two descriptions are made of that apart.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from tests.free_bodies import Body, Connection, FreeBodies, Gear
from tests.helpers import Array

AXES = ("axis", "axis2")


class Link(NamedTuple):
    """A link with the frame of its inertia."""

    name: str
    place: pin.SE3
    mass: float
    center: pin.SE3
    moments: tuple[float, float, float]


class Hung(NamedTuple):
    """A joint between links; the parent ``""`` is the world."""

    name: str
    kind: str
    parent: str
    child: str
    place: pin.SE3
    axes: tuple[tuple[float, float, float], ...] = ()
    more: tuple[str, ...] = ("", "")
    """What else is said of each axis."""
    element: str = ""
    """What else is said of the joint."""
    damping: tuple[float, ...] = ()
    stiffness: tuple[float, ...] = ()
    rest: tuple[float, ...] = ()
    friction: tuple[float, ...] = ()
    pitch: float = 0.0


def place(x: float, y: float, z: float, *angles: float) -> pin.SE3:
    """Return a place by position and roll, pitch, yaw."""
    turn = pin.rpy.rpyToMatrix(*angles) if angles else np.eye(3)
    return pin.SE3(turn, np.array([x, y, z]))


def link(name: str, at: pin.SE3, mass: float = 1.3) -> Link:
    """Return a link of no special inertia."""
    return Link(name, at, mass, place(0.02, -0.01, 0.05, 0.3, -0.2, 0.1), (0.02, 0.03, 0.04))


def pose(at: pin.SE3, attributes: str = "") -> str:
    """Return a pose with all digits."""
    numbers = [*at.translation, *pin.rpy.matrixToRpy(at.rotation)]
    return f"<pose{attributes}>{' '.join(f'{x:.17g}' for x in numbers)}</pose>"


def sdf(links: list[Link], joints: list[Hung], version: str = "1.9") -> str:
    """Return an SDF file of one model."""
    places = {one.name: one.place for one in links}
    text = ""
    for one in links:
        x, y, z = one.moments
        text += (
            f'<link name="{one.name}">{pose(one.place)}<inertial>{pose(one.center)}'
            f"<mass>{one.mass!r}</mass><inertia><ixx>{x}</ixx><iyy>{y}</iyy><izz>{z}</izz>"
            "<ixy>0</ixy><ixz>0</ixz><iyz>0</iyz></inertia></inertial></link>"
        )
    for joint in joints:
        text += (
            f'<joint name="{joint.name}" type="{joint.kind}"><parent>{joint.parent or "world"}'
            f"</parent><child>{joint.child}</child>"
            f"{pose(places[joint.child].actInv(joint.place))}{joint.element}"
        )
        dynamics = (joint.damping, joint.friction, joint.stiffness, joint.rest)
        tags = ("damping", "friction", "spring_stiffness", "spring_reference")
        for number, axis in enumerate(joint.axes):
            said = "".join(
                f"<{tag}>{values[number]!r}</{tag}>"
                for tag, values in zip(tags, dynamics, strict=True)
                if len(values) > number
            )
            text += (
                f"<{AXES[number]}><xyz>{' '.join(map(repr, axis))}</xyz>"
                f"<dynamics>{said}</dynamics>{joint.more[number]}</{AXES[number]}>"
            )
        text += "</joint>"
    return f'<sdf version="{version}"><model name="m">{text}</model></sdf>'


def free_bodies(
    links: list[Link], joints: list[Hung], gears: list[Gear] | None = None
) -> FreeBodies:
    """Return the same mechanism as free bodies."""
    places = {one.name: one.place for one in links} | {"": pin.SE3.Identity()}
    bodies = []
    for one in links:
        turn = one.center.rotation
        matrix = turn @ np.diag(one.moments) @ turn.T
        bodies.append(Body(one.name, pin.Inertia(one.mass, one.center.translation, matrix)))
    connections = []
    for joint in joints:
        if joint.kind == "gearbox":
            continue
        axes: tuple[Array, ...] = tuple(np.array(a) / np.linalg.norm(a) for a in joint.axes)
        kind = {"continuous": "revolute", "revolute2": "universal"}.get(joint.kind, joint.kind)
        connections.append(
            Connection(
                joint.name,
                kind,
                joint.parent,
                joint.child,
                places[joint.parent].actInv(joint.place),
                places[joint.child].actInv(joint.place),
                axes,
                joint.pitch,
                joint.damping,
                joint.stiffness,
                joint.rest,
                joint.friction,
            )
        )
    return FreeBodies(bodies, connections, gears or [])


Z, OBLIQUE = (0.0, 0.0, 1.0), (0.3, -0.2, 0.9)


def four_bar(more: str = "", **dynamics: tuple[float, ...]) -> tuple[list[Link], list[Hung]]:
    """Return a four-bar in an oblique plane, its coupler carried by two joints."""
    base = place(0.1, 0.2, 0.3, 0.4, -0.5, 0.6)
    links = [
        link("crank", base * place(0.02, 0.0, 0.01)),
        link("coupler", base * place(0.12, 0.16, 0.05, 0.1, 0.2, 0.3)),
        link("rocker", base * place(0.45, 0.02, 0.0, 0.0, 0.0, -0.2)),
    ]
    at = {
        "A": ("", "crank", (0.0, 0.0, 0.0)),
        "D": ("", "rocker", (0.45, 0.0, 0.0)),
        "B": ("crank", "coupler", (0.12, 0.16, 0.0)),
        "C": ("rocker", "coupler", (0.5, 0.3, 0.0)),
    }
    joints = [
        Hung(name, "revolute", *ends, base * place(*x), (Z,), (more, ""), **dynamics)
        for name, (*ends, x) in at.items()
    ]
    return links, joints


def slider_crank(closing: str) -> tuple[list[Link], list[Hung]]:
    """Return a crank, rod and slider, whose last joint in the file is one of the slider's two."""
    base = place(0.0, 0.0, 0.5, 0.2, 0.3, -0.1)
    links = [
        link("crank", base),
        link("rod", base * place(0.1, 0.15, 0.02)),
        link("slider", base * place(0.5, 0.0, 0.0, 0.3, 0.0, 0.0)),
    ]
    slides = Hung(
        "slide", "prismatic", "", "slider", base * place(0.5, 0.0, 0.0), ((1.0, 0.0, 0.0),)
    )
    pin_ = Hung("pin", "revolute", "rod", "slider", base * place(0.5, 0.0, 0.0), (Z,))
    joints = [
        Hung("A", "revolute", "", "crank", base, (Z,)),
        Hung("B", "revolute", "crank", "rod", base * place(0.1, 0.15, 0.0), (Z,)),
    ]
    return links, joints + ([pin_, slides] if closing == "slide" else [slides, pin_])


def rod(closing: str = "ball", **dynamics: tuple[float, ...]) -> tuple[list[Link], list[Hung]]:
    """Return a crank, a rod, and a rocker about an oblique axis: a spatial four-bar."""
    links = [
        link("crank", place(0.0, 0.0, 0.0, 0.1, 0.2, 0.3)),
        link("rod", place(0.15, 0.1, 0.05, -0.3, 0.1, 0.5), 0.4),
        link("rocker", place(0.6, 0.0, 0.0, 0.2, 0.0, -0.4)),
    ]
    tip = place(0.55, 0.35, 0.25, 0.2, -0.1, 0.3)
    axes = ((1.0, 0.0, 0.0), (0.1, 1.0, 0.2))
    joints = [
        Hung("crank_joint", "revolute", "", "crank", place(0.0, 0.0, 0.0), (OBLIQUE,)),
        Hung("rocker_joint", "revolute", "", "rocker", place(0.6, 0.0, 0.0), ((1.0, 0.0, 0.3),)),
        Hung(
            "ball",
            "ball",
            "crank",
            "rod",
            place(0.15, 0.1, 0.05),
            (Z,) if dynamics else (),
            **dynamics,
        ),
        Hung("tip", closing, "rod", "rocker", tip, axes if closing != "ball" else ()),
    ]
    return links, joints


def floating() -> tuple[list[Link], list[Hung]]:
    """Return a trunk that nothing holds, with a four-bar and a screw on it."""
    base = place(0.1, 0.2, 0.3, 0.4, -0.5, 0.6)
    links, joints = four_bar()
    trunk = link("trunk", base * place(0.2, -0.3, 0.1), 5.0)
    nut = link("nut", base * place(0.2, -0.5, 0.1), 0.7)
    joints = [one._replace(parent=one.parent or "trunk") for one in joints]
    screw = Hung(
        "screw",
        "screw",
        "trunk",
        "nut",
        nut.place,
        (OBLIQUE,),
        element="<screw_thread_pitch>0.3</screw_thread_pitch>",
        pitch=0.3 / (2.0 * np.pi),
    )
    return [trunk, *links, nut], [*joints, screw]


def geared() -> tuple[list[Link], list[Hung]]:
    """Return a motor that drives an arm on the same base through a gearbox of opposite axes."""
    links = [
        link("base", place(0.0, 0.0, 0.1)),
        link("rotor", place(0.1, 0.0, 0.3), 0.2),
        link("arm", place(0.3, 0.0, 0.1, 0.1, 0.2, 0.3)),
    ]
    joints = [
        Hung("foot", "revolute", "", "base", place(0.0, 0.0, 0.1), ((0.0, 1.0, 0.2),)),
        Hung("motor", "revolute", "base", "rotor", place(0.1, 0.0, 0.3), (Z,)),
        # This one has the base for a child, so that its angle counts the other way.
        Hung("elbow", "revolute", "arm", "base", place(0.3, 0.0, 0.1), (Z,)),
        Hung(
            "gear",
            "gearbox",
            "rotor",
            "arm",
            place(0.3, 0.0, 0.1),
            ((0.0, 0.0, -1.0), Z),
            element="<gearbox_ratio>0.2</gearbox_ratio><gearbox_reference_body>base"
            "</gearbox_reference_body>",
        ),
    ]
    return links, joints
