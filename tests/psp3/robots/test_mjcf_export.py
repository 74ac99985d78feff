"""What the export writes, and what it refuses.

That it is the same robot is shown in tests/cross/test_mjcf.py, by two other engines.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from types import SimpleNamespace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import psp3
from psp3.description.parts import THESIS_ROBOTS
from psp3.errors import InvalidArray, MasslessBody, UnexportableJoint, UnphysicalInertia
from psp3.robots.mjcf_export import mujoco_state, to_mjcf

ROBOT = psp3.load("psp3")


def element(root: ET.Element, tag: str, name: str) -> ET.Element:
    (found,) = (item for item in root.iter(tag) if item.get("name") == name)
    return found


def numbers(item: ET.Element, attribute: str) -> list[float]:
    return [float(word) for word in item.attrib[attribute].split()]


def arm(*inertias: pin.Inertia, joints: Any = None) -> Any:
    """Return a chain of bodies, each 0.3 m along x from the one before, as the export sees a robot.

    All joints are about z.
    """
    model = pin.Model()
    for number, inertia in enumerate(inertias, start=1):
        joint = joints[number - 1] if joints else pin.JointModelRZ()
        place = pin.SE3(np.eye(3), np.array([0.3, 0.0, 0.0]))
        index = model.addJoint(number - 1, joint, place, f"joint{number}")
        model.appendBodyToJoint(index, inertia, pin.SE3.Identity())
        model.addBodyFrame(f"link{number}", index, pin.SE3.Identity(), 0)
    return SimpleNamespace(
        model=model,
        constraint_models=[],
        actuated=(),
        equations=(),
        locked=(),
        options={"springs": None, "tendons": None},
        q0=pin.neutral(model),
        visual_model=pin.GeometryModel(),
    )


def body(*moments: float, mass: float = 1.0, turn: float = 0.0) -> pin.Inertia:
    """Return an inertia with the given principal moments about turned axes.

    They are turned by an angle about x and z.
    """
    rotation = pin.utils.rotate("x", turn) @ pin.utils.rotate("z", turn)
    return pin.Inertia(mass, np.zeros(3), rotation @ np.diag(moments) @ rotation.T)


NO_MASS = pin.Inertia.Zero()


def test_a_robot_in_words() -> None:
    """What is written of the 3-PSP is what the model has, to the last bit.

    Names, axes, limits, motors, closures, home pose and gravity.
    """
    root = ET.fromstring(to_mjcf(ROBOT))
    model = ROBOT.model
    assert [joint.get("name") for joint in root.iter("joint")] == list(model.names)[1:]
    for name, joint in zip(model.names, model.joints, strict=True):
        if name != "universe":
            written = element(root, "joint", name)
            assert written.get("type") == ("slide" if name[0] in "ab" else "hinge")
            assert numbers(written, "range") == [
                model.lowerPositionLimit[joint.idx_q],
                model.upperPositionLimit[joint.idx_q],
            ]
            assert (name in ROBOT.actuated) == ("actuatorfrcrange" in written.attrib)
    motors = list(next(root.iter("actuator")))
    assert [motor.get("joint") for motor in motors] == ["a1", "a2", "a3"]
    assert numbers(motors[0], "ctrlrange") == [-1000.0, 1000.0]
    welds = list(next(root.iter("equality")))
    assert [(weld.tag, weld.get("site1"), weld.get("site2")) for weld in welds] == [
        ("weld", "star1_center", "star2_center"),
        ("weld", "star1_center", "star3_center"),
    ]
    assert [numbers(weld, "solimp")[:2] for weld in welds] == [[0.9999, 0.9999]] * 2
    assert_array_equal(numbers(element(root, "key", "home"), "qpos"), ROBOT.q0)
    assert numbers(next(root.iter("option")), "gravity") == [0.0, 0.0, -9.81]
    # No robot of ours needs it, and it would change bodies that turn.
    assert next(root.iter("compiler")).get("balanceinertia") == "false"


def test_frames_are_sites_and_shapes_weigh_nothing() -> None:
    root = ET.fromstring(to_mjcf(ROBOT))
    tip = element(root, "site", "tip")
    assert (
        numbers(tip, "pos")
        == ROBOT.model.frames[ROBOT.model.getFrameId("tip")].placement.translation.tolist()
    )
    assert {site.get("name") for site in root.iter("site")} == {
        "star1_center",
        "star2_center",
        "star3_center",
        "tip",
    }
    shapes = list(root.iter("geom"))
    assert shapes[0].attrib == {"contype": "0", "conaffinity": "0", "group": "1", "density": "0"}
    assert len(shapes) == 1 + ROBOT.visual_model.ngeoms
    plate = ROBOT.visual_model.geometryObjects[0]
    assert_array_equal(numbers(element(root, "geom", plate.name), "size"), plate.geometry.halfSide)


@pytest.mark.parametrize("name", THESIS_ROBOTS)
def test_numbers_are_exact(name: str) -> None:
    """Masses and centers of mass of every robot come back from the text without an error."""
    robot = psp3.load(name)
    root = ET.fromstring(to_mjcf(robot))
    parents = {child: parent for parent in root.iter() for child in parent}
    for index in range(1, robot.model.njoints):
        inertial = parents[element(root, "joint", robot.model.names[index])].find("inertial")
        assert inertial is not None
        assert float(inertial.attrib["mass"]) == robot.model.inertias[index].mass
        assert_array_equal(numbers(inertial, "pos"), robot.model.inertias[index].lever)


# Inertias that no body can have


def test_the_nut_only_translates_so_its_inertia_may_be_another() -> None:
    """Printed are 0.003, 0.39 and 0.3294 kg m², which no body has; their mean is written.

    No other body is touched: 1e-15 of rounding.
    """
    root = ET.fromstring(to_mjcf(ROBOT))
    mean = np.mean([0.003, 0.39, 0.3294])
    for name, inertia in zip(
        list(ROBOT.model.names)[1:], list(ROBOT.model.inertias)[1:], strict=True
    ):
        parents = {child: parent for parent in root.iter() for child in parent}
        inertial = parents[element(root, "joint", name)].find("inertial")
        assert inertial is not None
        w, x, y, z = numbers(inertial, "quat")
        rotation = pin.Quaternion(w, x, y, z).toRotationMatrix()
        written = rotation @ np.diag(numbers(inertial, "diaginertia")) @ rotation.T
        assert_allclose(
            written, mean * np.eye(3) if name[0] == "a" else inertia.inertia, rtol=0, atol=1e-15
        )


def test_a_body_that_turns_must_have_a_possible_inertia() -> None:
    """Below a hinge even the body of a slide turns. The error says which body, and its moments."""
    slide, hinge = pin.JointModelPX(), pin.JointModelRZ()
    good, bad = body(1.0, 1.0, 1.0), body(0.003, 0.39, 0.3294, turn=0.3)
    to_mjcf(arm(bad, good, joints=[slide, hinge]))
    with pytest.raises(
        UnphysicalInertia,
        match=r"body 'link2' has the principal moments \[0.003\s*, 0.3294, 0.39\s*\]",
    ) as caught:
        to_mjcf(arm(good, bad, joints=[hinge, slide]))
    assert_allclose(caught.value.moments, [0.003, 0.3294, 0.39], atol=1e-15)
    assert isinstance(caught.value, ValueError)


@pytest.mark.parametrize("turn", [0.0, 0.4])
def test_a_plate_is_a_possible_body(turn: float) -> None:
    """Its moments obey the triangle inequality as an equality, which rounding may break.

    What is put right is 1e-15 of them.
    """
    moments = np.array([0.1, 0.2, 0.1 + 0.2])
    inertial = next(ET.fromstring(to_mjcf(arm(body(*moments, turn=turn)))).iter("inertial"))
    written = np.sort(numbers(inertial, "diaginertia"))
    assert written[0] + written[1] >= written[2]
    assert_allclose(written, moments, rtol=1e-15, atol=1e-15)


def test_a_point_mass_and_a_thin_rod_get_moments_that_do_not_matter() -> None:
    """MuJoCo takes no moment below 1e-15.

    What is written is 1e-14, some 1e-13 of what a point mass has about the next hinge.
    """
    for inertia in (body(0.0, 0.0, 0.0), body(0.0, 0.1, 0.1)):
        inertial = next(ET.fromstring(to_mjcf(arm(inertia))).iter("inertial"))
        assert_allclose(
            numbers(inertial, "diaginertia"), np.diag(inertia.inertia), rtol=1e-13, atol=1.1e-14
        )


# Bodies without mass


def test_a_body_without_mass_is_joined_with_the_next() -> None:
    """The cross of a universal joint: both of its hinges are on one body then, 0.3 m apart."""
    robot = arm(NO_MASS, body(1.0, 1.0, 1.0), joints=[pin.JointModelRZ(), pin.JointModelRY()])
    root = ET.fromstring(to_mjcf(robot))
    assert [item.get("name") for item in root.iter("body")] == ["base", "link2"]
    assert [joint.get("name") for joint in root.iter("joint")] == ["joint1", "joint2"]
    assert numbers(element(root, "joint", "joint1"), "pos") == [-0.3, 0.0, 0.0]
    assert numbers(element(root, "body", "link2"), "pos") == [0.6, 0.0, 0.0]


def test_a_body_without_mass_that_cannot_be_joined_is_named() -> None:
    with pytest.raises(
        MasslessBody, match="'link2' has no mass and it carries 0 bodies instead of one"
    ):
        to_mjcf(arm(body(1.0, 1.0, 1.0), NO_MASS))
    robot = arm(NO_MASS, body(1.0, 1.0, 1.0))
    identity = pin.SE3.Identity()
    robot.constraint_models = [
        pin.RigidConstraintModel(
            pin.ContactType.CONTACT_3D, robot.model, 1, identity, 0, identity, pin.LOCAL
        )
    ]
    with pytest.raises(MasslessBody, match="'link1' has no mass and a loop closes on it"):
        to_mjcf(robot)


# Joints


@pytest.mark.parametrize(
    "joint", [pin.JointModelHX(0.1), pin.JointModelHelicalUnaligned(np.array([0.6, 0.0, 0.8]), 0.1)]
)
def test_a_screw_is_refused(joint: Any) -> None:
    """A joint that turns and slides at once is none of MuJoCo's.

    It would need a constraint of its own.
    """
    with pytest.raises(
        UnexportableJoint,
        match=r"'joint1' cannot be written for MuJoCo.*it turns and slides at once",
    ):
        to_mjcf(arm(body(1.0, 1.0, 1.0), joints=[joint]))


def test_joints_have_the_limits_that_there_are() -> None:
    """Both ends, one end (the other far away), none; armature where there is some."""
    robot = arm(*[body(1.0, 1.0, 1.0)] * 3)
    robot.model.lowerPositionLimit = np.array([-1.0, -0.5, -np.inf])
    robot.model.upperPositionLimit = np.array([2.0, np.inf, np.inf])
    robot.model.armature = np.array([0.0, 0.25, 0.0])
    joints = list(ET.fromstring(to_mjcf(robot)).iter("joint"))
    assert [joint.get("range") for joint in joints] == ["-1 2", "-0.5 10000000000", None]
    assert [joint.get("armature") for joint in joints] == [None, "0.25", None]


def test_effort_limits_that_say_nothing_are_left_out() -> None:
    robot = arm(*[body(1.0, 1.0, 1.0)] * 3)
    robot.actuated = ("joint1", "joint2", "joint3")
    robot.model.upperEffortLimit = np.array([5.0, 0.0, np.inf])
    assert [motor.get("ctrlrange") for motor in ET.fromstring(to_mjcf(robot)).iter("motor")] == [
        "-5 5",
        None,
        None,
    ]


def test_a_ball_with_armature_is_refused() -> None:
    robot = arm(body(1.0, 1.0, 1.0), joints=[pin.JointModelSpherical()])
    robot.model.armature = np.array([0.1, 0.1, 0.1])
    with pytest.raises(
        UnexportableJoint, match=r"'joint1'.*it is a ball or free, and has armature"
    ):
        to_mjcf(robot)


def test_a_body_moves_in_six_ways_at_most() -> None:
    with pytest.raises(
        UnexportableJoint, match=r"'joint2'.*there are 7 degrees of freedom, more than 6"
    ):
        to_mjcf(
            arm(
                NO_MASS, body(1.0, 1.0, 1.0), joints=[pin.JointModelFreeFlyer(), pin.JointModelRX()]
            )
        )


def test_a_state_must_fit_the_model() -> None:
    with pytest.raises(
        InvalidArray, match=r"q must be finite numbers of shape .*15.*, got shape \(14,\)"
    ):
        mujoco_state(ROBOT, ROBOT.q0[1:])
    with pytest.raises(InvalidArray, match="v must be finite"):
        mujoco_state(ROBOT, ROBOT.q0, np.full(15, np.nan))
