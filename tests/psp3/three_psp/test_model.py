"""The model of the 3-PSP: the numbers of the parameter class are those of its description."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import psp3
from psp3.description.parts import ROBOT_FILES
from psp3.description.urdf import read_tree
from psp3.three_psp.model import set_parameters

LEGS = (1, 2, 3)

CHAIN = ("a", "phi", "theta", "lambda", "b")


def test_urdf_holds_the_numbers_of_the_parameter_class() -> None:
    """The file as Pinocchio reads it, before any parameter is written, against the default set.

    1e-16: thirds and sines are written with seventeen digits.
    """
    as_read, _ = read_tree(ROBOT_FILES / "psp3.urdf")
    written, _ = read_tree(ROBOT_FILES / "psp3.urdf")
    set_parameters(written, psp3.Parameters())
    assert (
        list(as_read.names)
        == list(written.names)
        == ["universe", *(f"{joint}{leg}" for leg in LEGS for joint in CHAIN)]
    )
    for joint in range(1, as_read.njoints):
        assert_allclose(
            as_read.jointPlacements[joint].homogeneous,
            written.jointPlacements[joint].homogeneous,
            rtol=0,
            atol=1e-16,
        )
        assert_allclose(
            as_read.inertias[joint].toDynamicParameters(),
            written.inertias[joint].toDynamicParameters(),
            rtol=0,
            atol=1e-16,
        )
    for one, other in zip(as_read.frames, written.frames, strict=True):
        assert one.name == other.name
        assert_allclose(one.placement.homogeneous, other.placement.homogeneous, rtol=0, atol=1e-16)
    assert_array_equal(as_read.gravity.vector, written.gravity.vector)


def test_urdf_text_holds_table_3_1() -> None:
    """The XML itself, so that an error in both the file and the loader shows."""
    parameters = psp3.Parameters()
    root = ElementTree.parse(ROBOT_FILES / "psp3.urdf").getroot()
    links = {link.get("name"): link for link in root.iter("link")}
    joints = {joint.get("name"): joint for joint in root.iter("joint")}

    def inertial(name: str) -> tuple[float, list[float]]:
        element = links[name].find("inertial")
        assert element is not None
        mass, inertia = element.find("mass"), element.find("inertia")
        assert mass is not None
        assert inertia is not None
        assert all(float(inertia.get(key, "nan")) == 0.0 for key in ("ixy", "ixz", "iyz"))
        return float(mass.get("value", "nan")), [
            float(inertia.get(key, "nan")) for key in ("ixx", "iyy", "izz")
        ]

    axial, transverse = parameters.ball_axial_inertia, parameters.ball_transverse_inertia
    for leg in LEGS:
        assert inertial(f"nut{leg}") == (parameters.nut_mass, list(parameters.nut_inertia))
        # The large moment is about the body's own joint axis.
        for joint, axis in {"phi": 1, "theta": 0, "lambda": 2}.items():
            moments = [axial if i == axis else transverse for i in range(3)]
            assert inertial(f"ball_{joint}{leg}") == (parameters.ball_mass, moments)
            element = joints[f"{joint}{leg}"].find("axis")
            assert element is not None
            assert element.get("xyz", "").split()[axis] == "1"
        mass, moments = inertial(f"star{leg}")
        assert_allclose(mass, parameters.star_mass / 3, rtol=1e-15)
        assert_allclose(moments, np.array(parameters.star_inertia) / 3, rtol=1e-15)
    assert set(links) == {
        "base",
        "tip",
        *(
            f"{name}{leg}"
            for name in ("nut", "ball_phi", "ball_theta", "ball_lambda", "star")
            for leg in LEGS
        ),
    } | {f"star{leg}_center" for leg in LEGS}


@pytest.mark.parametrize("parameters", tuple(psp3.PARAMETER_SETS))
def test_the_thirds_of_the_star_add_up_to_the_star(parameters: str) -> None:
    """At home, about the star's center in base axes; 1e-15 is rounding."""
    robot = psp3.load("psp3", parameters)
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, robot.q0)
    thirds = [
        data.oMi[joint].act(robot.model.inertias[joint])
        for joint in (robot.model.getJointId(f"b{leg}") for leg in LEGS)
    ]
    whole = thirds[0] + thirds[1] + thirds[2]
    assert_allclose(whole.mass, robot.parameters.star_mass, rtol=1e-15)
    assert_allclose(whole.lever, np.zeros(3), rtol=0, atol=1e-15)
    assert_allclose(whole.inertia, np.diag(robot.parameters.star_inertia), rtol=0, atol=1e-15)


def test_total_mass_of_the_tree_is_26_496_kg() -> None:
    model = psp3.load("psp3").model
    assert sum(model.inertias[joint].mass for joint in range(1, model.njoints)) == pytest.approx(
        26.496, rel=1e-14
    )
    assert pin.computeTotalMass(model) == pytest.approx(26.496, rel=1e-14)


def test_parameters_reach_every_part_of_the_model() -> None:
    """Numbers that differ from the file's in every field.

    Positions to 1e-16, everything else exact.
    """
    own = psp3.Parameters(
        screw_radius=0.25,
        tool_length=0.09,
        nut_mass=3.0,
        nut_inertia=(0.1, 0.2, 0.15),
        ball_mass=0.2,
        ball_axial_inertia=3e-4,
        ball_transverse_inertia=2e-4,
        star_mass=1.5,
        star_inertia=(0.03, 0.06, 0.09),
        gravity=1.62,
    )
    model = psp3.load("psp3", own).model
    for leg in LEGS:
        angle = 2 * np.pi * (leg - 1) / 3
        assert_allclose(
            model.jointPlacements[model.getJointId(f"a{leg}")].translation,
            [0.25 * np.cos(angle), 0.25 * np.sin(angle), 0],
            atol=1e-16,
        )
        nut = model.inertias[model.getJointId(f"a{leg}")]
        assert nut.mass == 3.0
        assert_array_equal(nut.inertia, np.diag([0.1, 0.2, 0.15]))
        for joint, axis in {"phi": 1, "theta": 0, "lambda": 2}.items():
            ball = model.inertias[model.getJointId(f"{joint}{leg}")]
            assert ball.mass == 0.2
            assert_array_equal(
                ball.inertia, np.diag([3e-4 if i == axis else 2e-4 for i in range(3)])
            )
        assert model.inertias[model.getJointId(f"b{leg}")].mass == 0.5
    assert_allclose(
        model.frames[model.getFrameId("tip")].placement.translation, [0, 0, 0.09], atol=1e-16
    )
    assert_array_equal(model.gravity.linear, [0, 0, -1.62])


def test_stroke_is_that_of_the_urdf() -> None:
    lower, upper = psp3.load("psp3").stroke
    assert_array_equal(lower, np.full(3, -0.4))
    assert_array_equal(upper, np.full(3, 0.4))
