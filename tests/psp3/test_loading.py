"""The robot's files.

URDF numbers are those of the parameter class, poses close the loops, names are known.
"""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import psp3
from psp3.description.parts import ROBOT_FILES, ROBOTS
from psp3.description.srdf import reference_poses
from psp3.description.urdf import read_tree
from psp3.errors import InvalidRobotFile, UnknownName
from psp3.three_psp.model import set_parameters

LEGS = (1, 2, 3)
CHAIN = ("a", "phi", "theta", "lambda", "b")


def test_load_returns_what_example_robot_data_returns_and_the_loops() -> None:
    robot = psp3.load("psp3")
    assert isinstance(robot, psp3.PSP3)
    assert (robot.model.nq, robot.model.nv) == (15, 15)
    assert isinstance(robot.data, pin.Data)
    assert isinstance(robot.visual_model, pin.GeometryModel)
    assert robot.visual_model.ngeoms > 0
    assert len(robot.constraint_models) == 2
    assert robot.actuated == ("a1", "a2", "a3")
    assert robot.parameters == psp3.Parameters()
    assert robot.q0.shape == (15,)


def test_default_arguments_load_the_default_robot() -> None:
    assert (
        psp3.load().parameters
        == psp3.load("psp3", parameters="default").parameters
        == psp3.PARAMETER_SETS["default"]
    )


def test_loads_do_not_share_what_can_be_changed() -> None:
    """One robot with a longer tool must leave the next one alone."""
    before = psp3.load("psp3").forward_kinematics(np.zeros(3)).tip[2]
    psp3.load("psp3", psp3.Parameters(tool_length=0.5))
    assert psp3.load("psp3").forward_kinematics(np.zeros(3)).tip[2] == before == 0.070


@pytest.mark.parametrize("name", ["psp4", "", "PSP3", None])
def test_unknown_robot_is_refused_with_the_known_names(name: str) -> None:
    with pytest.raises(UnknownName, match="known are psp3, five_bar") as caught:
        psp3.load(name)
    assert caught.value.name == name
    assert caught.value.known == ROBOTS
    assert isinstance(caught.value, ValueError)


@pytest.mark.parametrize("parameters", ["table_9_9", "", None])
def test_unknown_parameter_set_is_refused_with_the_known_names(parameters: str) -> None:
    with pytest.raises(UnknownName, match="default, table_3_1, table_5_1"):
        psp3.load("psp3", parameters)


@pytest.mark.parametrize("parameters", [["default"], {"screw_radius": 0.2}])
def test_parameters_of_a_wrong_kind_are_refused(parameters: object) -> None:
    with pytest.raises(psp3.PSP3Error):
        psp3.load("psp3", parameters)  # type: ignore[arg-type]


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


def test_reference_poses_close_the_loops_and_are_those_of_the_closed_form() -> None:
    """Every pose of the SRDF: loops and joint values to 1e-12.

    Loops are open by less, and joint values are those of the closed form.
    """
    robot = psp3.load("psp3")
    poses = reference_poses(robot.model, ROBOT_FILES / "psp3.srdf")
    assert set(poses) >= {"home", "tilted", "low", "high"}
    lower, upper = robot.stroke
    data = robot.model.createData()
    index = [robot.model.joints[robot.model.getJointId(name)].idx_q for name in robot.actuated]
    for q in poses.values():
        pin.framesForwardKinematics(robot.model, data, q)
        first, second, third = (
            data.oMf[robot.model.getFrameId(f"star{leg}_center")] for leg in LEGS
        )
        for other in (second, third):
            assert np.abs(pin.log6(first.actInv(other)).vector).max() < 1e-12
        assert_allclose(q, robot.configuration(q[index]), rtol=0, atol=1e-12)
        assert (lower <= q[index]).all()
        assert (q[index] <= upper).all()
        assert (robot.model.lowerPositionLimit <= q).all()
        assert (q <= robot.model.upperPositionLimit).all()
    assert_allclose(poses["home"], robot.q0, rtol=0, atol=1e-15)
    assert_allclose(
        robot.forward_kinematics(poses["tilted"][index]).rotation[2, 2],
        np.cos(np.radians(25)),
        rtol=1e-14,
    )


def test_reference_poses_fit_a_robot_of_other_lengths() -> None:
    """Poses that the model carries along are poses of this robot.

    Loops open by less than 1e-12 with screws farther apart.
    """
    robot = psp3.load("psp3", psp3.Parameters(screw_radius=0.25))
    noc = psp3.NaturalOrthogonalComplement(robot)
    for pose in robot.model.referenceConfigurations:
        assert np.abs(noc.constraint(pose.data())).max() < 1e-12, pose.key()


def test_stroke_is_that_of_the_urdf() -> None:
    lower, upper = psp3.load("psp3").stroke
    assert_array_equal(lower, np.full(3, -0.4))
    assert_array_equal(upper, np.full(3, 0.4))


def test_the_files_load_without_the_parameter_class_too() -> None:
    """URDF, SRDF and loop file alone give the default robot's dynamics; 1e-12 relative."""
    from_files = psp3.ClosedLoopRobot.from_urdf(
        ROBOT_FILES / "psp3.urdf", ROBOT_FILES / "psp3.yaml", ROBOT_FILES / "psp3.srdf"
    )
    robot = psp3.load("psp3")
    heights, speeds = [0.05, -0.02, 0.1], [0.3, 0.1, -0.2]
    for found, expected in zip(
        from_files.equation_of_motion(heights, speeds),
        robot.equation_of_motion(heights, speeds),
        strict=True,
    ):
        assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())
    assert_allclose(from_files.q0, robot.q0, rtol=0, atol=1e-15)


def test_robot_files_are_installed_beside_the_code() -> None:
    for name in ("psp3.urdf", "psp3.srdf", "psp3.yaml"):
        assert (ROBOT_FILES / name).is_file()


@pytest.mark.parametrize("text", ["", "<robot", "<robot name='x'><link/></robot>"])
def test_urdf_that_pinocchio_cannot_read_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "bad.urdf"
    path.write_text(text)
    with pytest.raises(InvalidRobotFile) as caught:
        read_tree(path)
    assert caught.value.path == path
