"""Inertias of a URDF: an impossible one is refused, unless its body as a whole has a possible one.

Links that fixed joints join are one body. Public files give impossible moments to small parts of a
large body, such as an antenna on a robot's base. Such a part is logged as a warning, and only the
sum over the body must be possible. Links that are fixed to the world do not move and need no
inertia.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from fuzzy2.support.logs import logger_named
from psp3.checks import Array
from psp3.description.xml import check_inertia, described, negative_moment, numbers
from psp3.errors import InvalidRobotFile

logger = logger_named(__name__)


class _Mass(NamedTuple):
    """Moments of a mass about an origin, of orders zero to two, which can be added.

    Pinocchio's own inertias cannot be negative, so they cannot hold such a part.
    """

    mass: float
    first: Array
    second: Array
    """Moments of inertia, (3, 3)."""

    @property
    def central(self) -> Array:
        """Moments of inertia about the center of mass, (3, 3)."""
        center = self.first / self.mass if self.mass else np.zeros(3)
        return np.asarray(self.second + self.mass * pin.skewSquare(center, center))

    def moved(self, place: pin.SE3) -> _Mass:
        """Return the moments in other axes, in which the present axes have a placement."""
        center = self.first / self.mass if self.mass else np.zeros(3)
        turn, there = place.rotation, place.act(center)
        second = turn @ self.central @ turn.T - self.mass * pin.skewSquare(there, there)
        return _Mass(self.mass, self.mass * there, second)

    def with_other(self, other: _Mass) -> _Mass:
        """Return the sum of two masses with the same axes."""
        return _Mass(self.mass + other.mass, self.first + other.first, self.second + other.second)


NOTHING = _Mass(0.0, np.zeros(3), np.zeros((3, 3)))

ENTRIES = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def check_inertias(
    path: Path,
    links: Mapping[str, ElementTree.Element],
    joints: Mapping[str, ElementTree.Element],
) -> None:
    """Check the inertias of all links of a tree, after everything else was checked.

    Raises
    ------
    InvalidRobotFile
        If an inertia lacks something, a mass is negative, or a body has a negative moment.
    """
    own = {name: inertia for name, link in links.items() if (inertia := _inertia(path, link))}
    wrong = [name for name, inertia in own.items() if _moment(inertia) is not None]
    if not wrong:
        return
    above = {
        _of(joint, "child"): (_of(joint, "parent"), joint.get("type") == "fixed", joint)
        for joint in joints.values()
    }
    bodies: dict[str, _Mass] = {}
    carrier: dict[str, str] = {}
    for name in links:
        carrier[name], place = _carrier(path, name, above)
        if name in own:
            before = bodies.get(carrier[name], NOTHING)
            bodies[carrier[name]] = before.with_other(own[name].moved(place))
    for name in wrong:
        body = carrier[name]
        # The root of the tree stands still.
        if body in above:
            if list(carrier.values()).count(body) == 1:
                check_inertia(path, links[name], own[name].mass, own[name].central)
            moment = _moment(bodies[body])
            if moment is not None:
                raise InvalidRobotFile(
                    path,
                    f"{described(links[name])}: a principal moment of inertia is negative, "
                    f"{_moment(own[name]):.6g} kg m², and with all that is fixed to it, "
                    f"{moment:.6g} kg m²",
                )
    logger.warning(
        "%s: a principal moment of inertia is negative, but what these links are fixed to can be a "
        "body, and is taken as one: %s",
        path,
        ", ".join(wrong),
    )


def _inertia(path: Path, link: ElementTree.Element) -> _Mass | None:
    """Return the inertia of a link in its axes; None if it has none."""
    inertial = link.find("inertial")
    if inertial is None:
        return None
    mass, inertia = inertial.find("mass"), inertial.find("inertia")
    if mass is None or inertia is None:
        raise InvalidRobotFile(path, f"{described(link)}: <inertial> needs <mass> and <inertia>")
    xx, xy, xz, yy, yz, zz = (_numbers(path, inertia, entry, 1)[0] for entry in ENTRIES)
    amount = float(_numbers(path, mass, "value", 1)[0])
    if amount < 0.0:
        raise InvalidRobotFile(path, f"{described(link)}: the mass {amount:g} is negative")
    matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return _Mass(amount, np.zeros(3), matrix).moved(_origin(path, inertial))


def _moment(inertia: _Mass) -> float | None:
    return negative_moment(inertia.mass, inertia.central)


def _carrier(
    path: Path, name: str, above: Mapping[str, tuple[str, bool, ElementTree.Element]]
) -> tuple[str, pin.SE3]:
    """Follow fixed joints upward from a link; return the last link, and the placement in it."""
    place = pin.SE3.Identity()
    while name in above and above[name][1]:
        name, _, joint = above[name]
        place = _origin(path, joint) * place
    return name, place


def _origin(path: Path, element: ElementTree.Element) -> pin.SE3:
    origin = element.find("origin")
    if origin is None:
        return pin.SE3.Identity()
    x, angles = (_numbers(path, origin, word, 3) for word in ("xyz", "rpy"))
    return pin.SE3(pin.rpy.rpyToMatrix(*angles), x)


def _numbers(path: Path, element: ElementTree.Element, attribute: str, count: int) -> Array:
    found = numbers(path, element, attribute, count)
    return np.zeros(count) if found is None else found


def _of(joint: ElementTree.Element, role: str) -> str:
    element = joint.find(role)
    return "" if element is None else element.get("link", "")
