"""URDFs changed at random are read as Python reads them, or refused.

What Pinocchio is told is compared with a second reading of the same bytes by Python's library
alone: bodies that fixed joints join, places, axes, limits, resistance and couplings. 5000 mutants
by hand: ``MUTANTS=5000 pytest tests/cross/test_mutated_urdf.py``.
"""

from __future__ import annotations

import os
import xml.etree.ElementTree as ElementTree
from collections import Counter
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from psp3.description.parts import ROBOT_FILES, RobotParts
from psp3.description.urdf import read_robot
from psp3.errors import PSP3Error
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.helpers import Array
from tests.hostile.mutant import Mutant, faults, outcome
from tests.hostile.xml_mutants import mutants

COUNT = int(os.environ.get("MUTANTS", "240"))

INERTIA = "<inertia ixx='0.02' ixy='0.001' ixz='0' iyy='0.03' iyz='-0.002' izz='0.04'/>"
BODY = (
    "<inertial><origin xyz='0.1 0.02 -0.03' rpy='0.3 -0.2 0.1'/><mass value='0.22'/>{}</inertial>"
)
LIMIT = "<limit lower='-1.5' upper='1.25' effort='7' velocity='5'/>"
GEARS = f"""<?xml version='1.0'?>
<robot name='gears'>
  <material name='blue'><color rgba='0 0 0.8 1'/></material>
  <link name='base'/>
  <link name='crank'>{BODY.format(INERTIA)}
    <visual><origin xyz='0 0 0.1'/><geometry><box size='0.1 0.2 0.3'/></geometry>
      <material name='blue'/></visual>
    <collision><geometry><sphere radius='0.1'/></geometry></collision></link>
  <link name='wheel'>{BODY.format(INERTIA)}</link>
  <link name='tip'>{BODY.format(INERTIA)}</link>
  <link name='slider'>{BODY.format(INERTIA)}</link>
  <joint name='one' type='revolute'><origin xyz='0.1 0 0.2' rpy='0.5 0.25 -1'/>
    <parent link='base'/><child link='crank'/><axis xyz='0 0.6 0.8'/>{LIMIT}
    <dynamics damping='0.3' friction='0.1'/></joint>
  <joint name='two' type='continuous'><origin xyz='0.3 0 0'/><parent link='crank'/>
    <child link='wheel'/><axis xyz='0 0 1'/><mimic joint='one' multiplier='-2' offset='0.1'/>
  </joint>
  <joint name='still' type='fixed'><origin xyz='0.2 0.1 0' rpy='0 0 1.5'/><parent link='wheel'/>
    <child link='tip'/></joint>
  <joint name='slide' type='prismatic'><origin xyz='0 0 0.5'/><parent link='base'/>
    <child link='slider'/>{LIMIT}</joint>
</robot>"""

FILES = {"gears": GEARS} | {
    name: (ROBOT_FILES / f"{name}.urdf").read_text(encoding="utf-8") for name in ("psp3", "tricept")
}


# A second reading


class Body(NamedTuple):
    """What moves as one: mass, and its first and second moments in the axes of its joint."""

    mass: float
    first: Array
    second: Array


def words(element: ElementTree.Element | None, key: str, default: str) -> Array:
    text = default if element is None else element.get(key, default)
    return np.array([float(word) for word in text.split()])


def rotation(rpy: Array) -> Array:
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def placed(element: ElementTree.Element | None) -> Array:
    origin = None if element is None else element.find("origin")
    place = np.eye(4)
    place[:3, :3] = rotation(words(origin, "rpy", "0 0 0"))
    place[:3, 3] = words(origin, "xyz", "0 0 0")
    return place


def moments(mass: float, center: Array, inertia: Array) -> Body:
    """Return a body by its inertia about its center; second moments are about the origin."""
    return Body(
        mass,
        mass * center,
        inertia + mass * (center @ center * np.eye(3) - np.outer(center, center)),
    )


def inertia_of(link: ElementTree.Element, place: Array) -> Body:
    """Return a link's body in axes in which the link is placed."""
    inertial = link.find("inertial")
    if inertial is None:
        return Body(0.0, np.zeros(3), np.zeros((3, 3)))
    entries = {
        key: words(inertial.find("inertia"), f"i{key}", "0")[0]
        for key in ("xx", "xy", "xz", "yy", "yz", "zz")
    }
    local = np.array([[entries["".join(sorted(a + b))] for b in "xyz"] for a in "xyz"])
    whole = place @ placed(inertial)
    turn = whole[:3, :3]
    mass = words(inertial.find("mass"), "value", "0")[0]
    return moments(float(mass), whole[:3, 3], turn @ local @ turn.T)


class Tree(NamedTuple):
    """What a URDF says of the motion, by the names of its joints."""

    bodies: dict[str, Body]
    places: dict[str, tuple[str, Array]]
    joints: dict[str, ElementTree.Element]
    masses: float
    """All that stand anywhere in the file."""


def tree_of(content: bytes) -> Tree:
    root = ElementTree.fromstring(content.lstrip())
    links = {link.get("name", ""): link for link in root.findall("link")}
    joints = {joint.get("name", ""): joint for joint in root.findall("joint")}
    below: dict[str, list[str]] = {}
    for name, joint in joints.items():
        parent = joint.find("parent")
        assert parent is not None
        below.setdefault(parent.get("link", ""), []).append(name)
    children = {joint.find("child").get("link") for joint in joints.values()}  # type: ignore[union-attr]
    (first,) = [name for name in links if name not in children]
    bodies, places = {"universe": inertia_of(links[first], np.eye(4))}, {}
    waiting = [(first, "universe", np.eye(4))]
    while waiting:
        link, body, place = waiting.pop()
        for name in below.get(link, ()):
            here, child = place @ placed(joints[name]), joints[name].find("child").get("link")  # type: ignore[union-attr]
            if joints[name].get("type") == "fixed":
                added = inertia_of(links[child], here)
                bodies[body] = Body(*(a + b for a, b in zip(bodies[body], added, strict=True)))
                waiting.append((child, body, here))
            else:
                places[name] = body, here
                bodies[name] = inertia_of(links[child], np.eye(4))
                waiting.append((child, name, np.eye(4)))
    masses = sum(float(words(mass, "value", "0")[0]) for mass in root.iter("mass"))
    return Tree(bodies, places, joints, masses)


def same(found: Any, expected: Any, what: str) -> None:
    found, expected = np.asarray(found, dtype=float), np.asarray(expected, dtype=float)
    if not (np.isfinite(expected).all() and np.isfinite(found).all()):
        return  # a product of numbers that are finite
    scale = max(1.0, np.abs(expected).max(initial=0.0))
    # Rotations twice in another order: some roundings, of the largest number.
    assert np.abs(found - expected).max(initial=0.0) <= 1e-11 * scale, (what, found, expected)


def compare(parts: RobotParts, tree: Tree, told: str) -> None:
    """Compare what Pinocchio was told with the second reading."""
    model = parts.model
    assert set(model.names) == set(tree.bodies)
    total = 0.0
    for name, body in tree.bodies.items():
        index = model.getJointId(name)
        mine = model.inertias[index]
        total += mine.mass
        if model.joints[index].shortname() == "JointModelPlanar":
            continue  # its body stands in axes that were turned
        same(mine.mass, body.mass, f"mass of {name}")
        if np.isfinite(body.second).all() and body.mass > 0.0:
            found = moments(mine.mass, np.array(mine.lever), np.array(mine.inertia))
            same(found.first, body.first, f"center of {name}")
            same(found.second, body.second, f"inertia of {name}")
    if "not read" not in told:
        same(total, tree.masses, "all masses of the file")
    for name, (above, place) in tree.places.items():
        index = model.getJointId(name)
        joint, element = model.joints[index], tree.joints[name]
        assert model.names[model.parents[index]] == above
        kind = element.get("type")
        axis = words(element.find("axis"), "xyz", "1 0 0")
        axis = axis / np.abs(axis).max()
        axis = axis / np.linalg.norm(axis)
        found = model.jointPlacements[index].homogeneous
        same(found[:3, 3], place[:3, 3], f"place of {name}")
        if kind == "planar":
            same(found[:3, 2], place[:3, :3] @ axis, f"plane of {name}")
        else:
            same(found, place, f"axes of {name}")
        if kind in ("revolute", "continuous", "prismatic"):
            data = joint.createData()
            joint.calc(data, np.array([1.0, 0.0])[: joint.nq])
            motion = np.asarray(data.S).ravel()
            same(motion[:3] if kind == "prismatic" else motion[3:], axis, f"axis of {name}")
            check_numbers(model, joint, element, kind)


def check_numbers(model: Any, joint: Any, element: ElementTree.Element, kind: str) -> None:
    """Compare limits and resistance of a joint."""
    limit, dynamics = element.find("limit"), element.find("dynamics")
    if kind != "continuous" and limit is not None and set(limit.attrib) & {"lower", "upper"}:
        same(model.lowerPositionLimit[joint.idx_q], words(limit, "lower", "0"), "lower")
        same(model.upperPositionLimit[joint.idx_q], words(limit, "upper", "0"), "upper")
    if limit is not None:
        same(model.upperEffortLimit[joint.idx_v], words(limit, "effort", "0"), "effort")
        same(model.upperVelocityLimit[joint.idx_v], words(limit, "velocity", "0"), "velocity")
    same(model.damping[joint.idx_v], words(dynamics, "damping", "0"), "damping")
    same(model.upperDryFrictionLimit[joint.idx_v], words(dynamics, "friction", "0"), "friction")


def couplings(tree: Tree) -> list[tuple[str, str, tuple[float, float]]]:
    found = []
    for name, element in tree.joints.items():
        mimic = element.find("mimic")
        if mimic is not None and element.get("type") != "fixed":
            numbers = tuple(
                float(words(mimic, key, default)[0])
                for key, default in (("offset", "0"), ("multiplier", "1"))
            )
            found.append((name, mimic.get("joint", ""), numbers))
    return found  # type: ignore[return-value]


def check(mutant: Mutant, path: Path) -> str:
    """Return what became of a mutant; raise where that is wrong."""
    found = outcome(mutant, path, read_robot, PSP3Error)
    what = f"{mutant.number} ({mutant.what})"
    assert not faults(found), f"{what}: {faults(found)}"
    if found.refused is not None:
        return "refused"
    tree = tree_of(mutant.content)
    try:
        compare(found.value, tree, found.told)
    except AssertionError as error:
        raise AssertionError(f"{what}: {error}") from error
    model = found.value.model
    assert [
        (model.names[one.y], model.names[one.x], one.coefficients) for one in found.value.equations
    ] == couplings(tree), what
    return "told and read" if found.told else "read"


@pytest.mark.parametrize("name", FILES)
def test_a_changed_urdf_is_read_as_python_reads_it_or_refused(name: str, tmp_path: Path) -> None:
    results = Counter(
        check(mutant, tmp_path / "mutant.urdf")
        for mutant in mutants(FILES[name], COUNT // len(FILES), seed=len(name))
    )
    # Neither is everything refused, nor is everything read.
    assert results["read"] > 0.2 * results.total()
    assert results["refused"] > 0.2 * results.total()


def test_a_changed_urdf_makes_a_whole_robot_or_is_refused(tmp_path: Path) -> None:
    """Up to the dynamics at rest; a refusal may come from there too."""

    def whole(path: Path) -> Array:
        robot = ClosedLoopRobot.from_urdf(path)
        rest = np.zeros(len(robot.coordinates_v))
        return robot.inverse_dynamics(robot.reference, rest, rest)

    for mutant in mutants(GEARS, COUNT // 3, seed=9):
        found = outcome(mutant, tmp_path / "mutant.urdf", whole, PSP3Error)
        assert not faults(found), (mutant.number, mutant.what, faults(found))
        assert found.refused is not None or np.isfinite(found.value).all()


def test_the_original_files_pass(tmp_path: Path) -> None:
    for name, text in FILES.items():
        mutant = Mutant(0, name, text.encode())
        assert check(mutant, tmp_path / "original.urdf") in ("read", "told and read")
