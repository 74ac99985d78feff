"""The five robots of urdf/ beside the 3-PSP.

Their files, and their kinematics against closed forms from the literature.

The closed forms (``tests/closed_form_kinematics.py``) hold the lengths a second time and know
nothing of Pinocchio. Positions are compared to 1e-10 m and rad; 1e-14 is reached.
"""

from __future__ import annotations

import importlib
import re
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any
from xml.etree import ElementTree

import coal
import numpy as np
import pinocchio as pin
import pytest
import yaml
from numpy.testing import assert_allclose

import psp3
from psp3.description.parts import MJCF_ROBOTS, ROBOT_FILES, ROBOTS, THESIS_ROBOTS
from psp3.description.srdf import reference_poses
from psp3.errors import InvalidValue, UnknownName
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.closed_form_kinematics import (
    Delta,
    FiveBar,
    GoughStewart,
    PlanarThreeRRR,
    Tricept,
    rotation_xyz,
)
from tests.helpers import Array, relative_error
from tests.robot_samplers import WORKSPACES, Reachable, reachable

NAMES = THESIS_ROBOTS[1:]
POSES = 500
TOLERANCE = 1e-10

README = (ROBOT_FILES / "README.md").read_text(encoding="utf-8")

# Name: joints, closure rows, rank, degrees of freedom.
COUNTS = {
    "five_bar": (4, 3, 2, 2),
    "planar_3rrr": (7, 6, 4, 3),
    "delta": (18, 15, 15, 3),
    "gough_stewart": (21, 15, 15, 6),
    "tricept": (12, 9, 9, 3),
}


@pytest.fixture(scope="module")
def robots() -> dict[str, ClosedLoopRobot]:
    return {name: psp3.load(name) for name in NAMES}


@pytest.fixture(scope="module")
def samples() -> dict[str, Reachable]:
    return {name: reachable(name, POSES, np.random.default_rng(0)) for name in NAMES}


@pytest.fixture(scope="module")
def configurations(
    robots: dict[str, ClosedLoopRobot], samples: dict[str, Reachable]
) -> dict[str, Array]:
    """Every pose closed from the reference pose, none of them helped by its neighbor."""
    return {name: robots[name].configuration(samples[name].positions) for name in NAMES}


@pytest.fixture(scope="module")
def script() -> Iterator[ModuleType]:
    """Return the script; what it imports lies beside it."""
    sys.path.insert(0, str(ROBOT_FILES))
    try:
        yield importlib.import_module("make_robots")
    finally:
        sys.path.remove(str(ROBOT_FILES))


@pytest.fixture(scope="module")
def solids(script: ModuleType) -> ModuleType:
    return importlib.import_module("making.solids")


def tips(robot: ClosedLoopRobot, configurations: Array) -> tuple[Array, Array]:
    """Position (n, 3) and rotation (n, 3, 3) of the frame ``tip``, from Pinocchio."""
    placements = []
    for q in configurations:
        pin.framesForwardKinematics(robot.model, robot.data, q)
        placements.append(robot.data.oMf[robot.model.getFrameId("tip")].homogeneous)
    stack = np.array(placements)
    return stack[:, :3, 3], stack[:, :3, :3]


def largest_gap(name: str, robot: ClosedLoopRobot, configurations: Array) -> float:
    """Largest distance of two frames that the loop file says coincide."""
    pairs = yaml.safe_load((ROBOT_FILES / f"{name}.yaml").read_text(encoding="utf-8"))[
        "closed_loop"
    ]
    indices = [[robot.model.getFrameId(frame) for frame in pair] for pair in pairs]
    largest = 0.0
    for q in configurations:
        pin.framesForwardKinematics(robot.model, robot.data, q)
        first, second = (
            np.array([robot.data.oMf[pair[i]].translation for pair in indices]) for i in (0, 1)
        )
        largest = max(largest, float(np.linalg.norm(first - second, axis=1).max()))
    return largest


# Files


def test_files_are_what_the_script_writes(script: ModuleType, tmp_path: Path) -> None:
    script.main(tmp_path)
    written = sorted(path.name for path in tmp_path.iterdir())
    assert written == sorted(
        f"{name}.{kind}"
        for name in ROBOTS[1:]
        for kind in (("xml",) if name in MJCF_ROBOTS else ("urdf", "srdf", "yaml"))
    )
    for name in written:
        found, expected = (
            (directory / name).read_text(encoding="utf-8") for directory in (ROBOT_FILES, tmp_path)
        )
        # Another processor may round the last of seventeen digits otherwise.
        number = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e-?\d+)?")
        assert number.sub("#", found) == number.sub("#", expected), (
            f"{name}: run urdf/make_robots.py"
        )
        assert_allclose(
            [float(text) for text in number.findall(found)],
            [float(text) for text in number.findall(expected)],
            atol=1e-12,
        )


@pytest.mark.parametrize("name", NAMES)
def test_load_returns_the_robot(name: str, robots: dict[str, ClosedLoopRobot]) -> None:
    robot = robots[name]
    joints, rows, rank, mobility = COUNTS[name]
    assert type(robot) is ClosedLoopRobot
    assert (robot.model.nq, robot.model.nv) == (joints, joints)
    assert sum(constraint.residualSize() for constraint in robot.constraint_models) == rows
    jacobian = robot.constraint_jacobian(robot.q0)
    assert np.linalg.matrix_rank(jacobian, tol=1e-9) == rank
    assert len(robot.actuated) == mobility == joints - rank
    assert robot.model.existFrame("tip")
    assert robot.visual_model.ngeoms > 10
    assert all(
        joint.shortname() not in ("JointModelRUBX", "JointModelRUBY", "JointModelRUBZ")
        for joint in robot.model.joints
    )


@pytest.mark.parametrize("name", NAMES)
def test_parameters_belong_to_the_3psp(name: str) -> None:
    for parameters in ("table_5_1", psp3.Parameters()):
        with pytest.raises(InvalidValue, match="only 'psp3'"):
            psp3.load(name, parameters)


def test_unknown_names_are_answered_with_all_known_ones() -> None:
    with pytest.raises(
        UnknownName, match="psp3, five_bar, planar_3rrr, delta, gough_stewart, tricept"
    ):
        psp3.load("hexaglide")


@pytest.mark.parametrize("name", NAMES)
def test_home_closes_the_loops_within_the_limits(
    name: str, robots: dict[str, ClosedLoopRobot]
) -> None:
    """As written, to 1e-12 m, before any iteration."""
    robot = robots[name]
    poses = reference_poses(robot.model, ROBOT_FILES / f"{name}.srdf")
    assert set(poses) == {"home"}
    assert largest_gap(name, robot, poses["home"][None]) < 1e-12
    assert_allclose(robot.q0, poses["home"], rtol=0, atol=1e-12)
    assert (robot.model.lowerPositionLimit < poses["home"]).all()
    assert (poses["home"] < robot.model.upperPositionLimit).all()
    assert np.isfinite(robot.model.upperPositionLimit - robot.model.lowerPositionLimit).all()


@pytest.mark.parametrize("name", NAMES)
def test_samplers_know_the_limits_of_the_motors(
    name: str, robots: dict[str, ClosedLoopRobot]
) -> None:
    lower, upper = robots[name].limits
    assert_allclose(lower, WORKSPACES[name].limits[0])
    assert_allclose(upper, WORKSPACES[name].limits[1])


@pytest.mark.parametrize("name", NAMES)
def test_every_body_can_exist(name: str, robots: dict[str, ClosedLoopRobot]) -> None:
    """Masses and moments are positive, and no moment exceeds the sum of the others.

    No body is so light that it spoils the tree.
    """
    robot = robots[name]
    for inertia in list(robot.model.inertias)[1:]:
        moments = np.linalg.eigvalsh(inertia.inertia)
        assert inertia.mass > 0.005
        assert moments[0] > 0.0
        assert moments[2] < moments[0] + moments[1]
    tree = pin.crba(robot.model, robot.data, robot.q0)
    assert np.linalg.cond(np.triu(tree) + np.triu(tree, 1).T) < 1e3


def drawn_inertias(name: str, robot: ClosedLoopRobot, solids: ModuleType) -> dict[int, pin.Inertia]:
    """Inertia of each joint's body from the shapes that Pinocchio read, by coal's formulas.

    Each solid, of its color's density.
    """
    densities = {
        tuple(float(part) for part in color.split()): density
        for color, density in solids.MATERIALS.values()
    }
    totals: dict[int, Any] = {}
    for shape in robot.visual_model.geometryObjects:
        if shape.parentJoint == 0:
            continue
        form, density = shape.geometry, densities[tuple(shape.meshColor.round(6))]
        assert isinstance(form, coal.Box | coal.Cylinder | coal.Sphere)
        body = pin.Inertia(
            density * form.computeVolume(), np.zeros(3), density * form.computeMomentofInertia()
        )
        totals[shape.parentJoint] = totals.get(
            shape.parentJoint, pin.Inertia.Zero()
        ) + shape.placement.act(body)
    return totals


@pytest.mark.parametrize(
    ("name", "solid"),
    [("five_bar", r".*"), ("planar_3rrr", r".*"), ("delta", r".*_pitch|platform.*")],
)
def test_bodies_weigh_what_is_drawn(
    name: str, solid: str, robots: dict[str, ClosedLoopRobot], solids: ModuleType
) -> None:
    """Of bodies without tubes, which are drawn as if they were solid.

    1e-4: drawings are written to a micrometer.
    """
    robot = robots[name]
    drawn = drawn_inertias(name, robot, solids)
    compared = [
        joint
        for joint in range(1, robot.model.njoints)
        if re.fullmatch(solid, robot.model.names[joint])
    ]
    assert compared
    for joint in compared:
        ours, theirs = robot.model.inertias[joint], drawn[joint]
        assert_allclose(ours.mass, theirs.mass, rtol=1e-4)
        assert_allclose(ours.lever, theirs.lever, rtol=0, atol=1e-5)
        assert_allclose(
            ours.inertia, theirs.inertia, rtol=0, atol=1e-4 * np.abs(theirs.inertia).max()
        )


def test_a_tube_is_a_cylinder_less_its_bore(solids: ModuleType) -> None:
    start, end = np.array([0.1, -0.2, 0.3]), np.array([0.4, 0.1, -0.1])
    tube = solids.rod(start, end, 0.03, "steel", 0.02).inertia()
    outer, inner = (solids.rod(start, end, radius, "steel").inertia() for radius in (0.03, 0.02))
    assert_allclose(tube.mass, outer.mass - inner.mass, rtol=1e-14)
    assert_allclose(tube.lever, 0.5 * (start + end), rtol=1e-14)
    assert_allclose(tube.inertia, outer.inertia - inner.inertia, rtol=1e-12)
    cylinder = coal.Cylinder(0.03, float(np.linalg.norm(end - start)))
    assert_allclose(
        np.linalg.eigvalsh(outer.inertia),
        7850.0 * np.linalg.eigvalsh(cylinder.computeMomentofInertia()),
        rtol=1e-12,
    )


@pytest.mark.parametrize("name", NAMES)
def test_the_readme_describes_the_robot(name: str, robots: dict[str, ClosedLoopRobot]) -> None:
    """The row of the table.

    Joints, rows, rank, degrees of freedom, moving mass to 0.01 kg, and condition numbers to their
    digits.
    """
    robot = robots[name]
    found = re.search(rf"^\| `{name}` \|(.*)\|$", README, flags=re.MULTILINE)
    assert found is not None
    cells = [cell.strip() for cell in found[1].split("|")]
    assert tuple(int(cell) for cell in cells[1:5]) == COUNTS[name]
    assert float(cells[5]) == pytest.approx(
        sum(inertia.mass for inertia in list(robot.model.inertias)[1:]), abs=0.005
    )
    tree = pin.crba(robot.model, robot.data, robot.q0)
    closures = np.linalg.svd(
        robot.constraint_jacobian(robot.q0)[:, robot.dependent_v], compute_uv=False
    )[: COUNTS[name][2]]
    assert float(cells[6]) == pytest.approx(
        np.linalg.cond(np.triu(tree) + np.triu(tree, 1).T), rel=0.05
    )
    assert float(cells[7]) == pytest.approx(closures[0] / closures[-1], rel=0.05)


@pytest.mark.parametrize("name", NAMES)
def test_visuals_are_primitives_in_named_colors(
    name: str, robots: dict[str, ClosedLoopRobot]
) -> None:
    """Every moving body is drawn, and Pinocchio found every color.

    What it does not find turns gray (0.9, 0.9, 0.9) in silence.
    """
    root = ElementTree.parse(ROBOT_FILES / f"{name}.urdf").getroot()
    assert {child.tag for geometry in root.iter("geometry") for child in geometry} <= {
        "box",
        "cylinder",
        "sphere",
    }
    colors = {color.get("rgba") for color in root.findall("material/color")}
    shapes = robots[name].visual_model.geometryObjects
    assert {tuple(shape.meshColor.round(6)) for shape in shapes} == {
        tuple(float(part) for part in str(color).split()) for color in colors
    }
    assert {shape.parentJoint for shape in shapes} == set(range(robots[name].model.njoints))


# Kinematics


@pytest.mark.parametrize("name", NAMES)
def test_all_reachable_poses_close_from_the_reference_pose(
    name: str,
    robots: dict[str, ClosedLoopRobot],
    configurations: dict[str, Array],
    samples: dict[str, Reachable],
) -> None:
    robot = robots[name]
    assert configurations[name].shape == (POSES, robot.model.nq)
    assert largest_gap(name, robot, configurations[name]) <= TOLERANCE
    assert_allclose(
        configurations[name][:, robot.actuated_q], samples[name].positions, rtol=0, atol=0
    )


def test_five_bar_meets_where_two_circles_do(
    robots: dict[str, ClosedLoopRobot],
    configurations: dict[str, Array],
    samples: dict[str, Reachable],
) -> None:
    """The sampled point is that of the closed loop, assembly mode included.

    So is the intersection of the circles.
    """
    robot, closed_form = robots["five_bar"], FiveBar()
    position, _ = tips(robot, configurations["five_bar"])
    poses, positions = samples["five_bar"]
    assert_allclose(closed_form.forward(positions), poses, rtol=0, atol=TOLERANCE)
    assert_allclose(position[:, ::2], poses, rtol=0, atol=TOLERANCE)
    assert_allclose(position[:, 1], 0.0, rtol=0, atol=TOLERANCE)
    jacobian = robot.frame_jacobian(positions, "tip")
    assert relative_error(jacobian[:, [0, 2]], closed_form.jacobian(positions)) < TOLERANCE


def test_planar_3rrr_has_the_crank_angles_of_its_quadratics(
    robots: dict[str, ClosedLoopRobot],
    configurations: dict[str, Array],
    samples: dict[str, Reachable],
) -> None:
    robot, closed_form = robots["planar_3rrr"], PlanarThreeRRR()
    position, rotation = tips(robot, configurations["planar_3rrr"])
    poses, positions = samples["planar_3rrr"]
    angle = np.arctan2(rotation[:, 1, 0], rotation[:, 0, 0])
    found = np.column_stack([position[:, :2], angle])
    assert_allclose(found, poses, rtol=0, atol=TOLERANCE)
    assert_allclose(position[:, 2], 0.0, rtol=0, atol=TOLERANCE)
    assert_allclose(closed_form.inverse(found), positions, rtol=0, atol=TOLERANCE)
    # Half-angle substitution turns the rod's length into the quadratic of the paper: (k + x) t² - 2
    # y t + (k - x) = 0.
    x, y = np.moveaxis(closed_form.placed_corners(found) - closed_form.shafts, -1, 0)
    k = (x**2 + y**2 + closed_form.crank**2 - closed_form.rod**2) / (2.0 * closed_form.crank)
    t = np.tan(0.5 * (positions + closed_form.azimuths + np.pi))
    assert_allclose(
        ((k + x) * t**2 - 2.0 * y * t + (k - x)) / (1.0 + t**2), 0.0, rtol=0, atol=TOLERANCE
    )
    jacobian = robot.frame_jacobian(positions, "tip")
    assert relative_error(jacobian[:, [0, 1, 5]], closed_form.jacobian(poses)) < TOLERANCE


def test_delta_meets_where_three_spheres_do(
    robots: dict[str, ClosedLoopRobot],
    configurations: dict[str, Array],
    samples: dict[str, Reachable],
) -> None:
    """And its platform never turns."""
    robot, closed_form = robots["delta"], Delta()
    position, rotation = tips(robot, configurations["delta"])
    poses, positions = samples["delta"]
    assert_allclose(closed_form.forward(positions), poses, rtol=0, atol=TOLERANCE)
    assert_allclose(position, poses, rtol=0, atol=TOLERANCE)
    assert_allclose(rotation, np.broadcast_to(np.eye(3), rotation.shape), rtol=0, atol=TOLERANCE)
    assert_allclose(closed_form.inverse(position), positions, rtol=0, atol=TOLERANCE)
    jacobian = robot.frame_jacobian(positions, "tip")
    assert relative_error(jacobian[:, :3], closed_form.jacobian(positions)) < TOLERANCE
    assert np.abs(jacobian[:, 3:]).max() < TOLERANCE


def test_gough_stewart_has_the_leg_lengths_of_its_pose(
    robots: dict[str, ClosedLoopRobot],
    configurations: dict[str, Array],
    samples: dict[str, Reachable],
) -> None:
    robot, closed_form = robots["gough_stewart"], GoughStewart()
    position, rotation = tips(robot, configurations["gough_stewart"])
    poses, positions = samples["gough_stewart"]
    assert_allclose(position, poses[:, :3], rtol=0, atol=TOLERANCE)
    assert_allclose(rotation, rotation_xyz(poses[:, 3:]), rtol=0, atol=TOLERANCE)
    assert_allclose(closed_form.lengths(position, rotation), positions, rtol=0, atol=TOLERANCE)
    rates = closed_form.rates(position, rotation)
    assert_allclose(
        rates @ robot.frame_jacobian(positions, "tip"),
        np.broadcast_to(np.eye(6), rates.shape),
        rtol=0,
        atol=TOLERANCE,
    )


def test_tricept_has_the_leg_lengths_of_its_central_leg(
    robots: dict[str, ClosedLoopRobot],
    configurations: dict[str, Array],
    samples: dict[str, Reachable],
) -> None:
    robot, closed_form = robots["tricept"], Tricept()
    position, rotation = tips(robot, configurations["tricept"])
    poses, positions = samples["tricept"]
    assert_allclose(position, poses, rtol=0, atol=TOLERANCE)
    assert_allclose(rotation, closed_form.platform(poses)[1], rtol=0, atol=TOLERANCE)
    assert_allclose(closed_form.inverse(position), positions, rtol=0, atol=TOLERANCE)
    angles, length = closed_form.central_leg(position)
    center = [
        robot.model.joints[robot.model.getJointId(f"center_{part}")].idx_q
        for part in ("universal_x", "universal_y", "length")
    ]
    assert_allclose(
        configurations["tricept"][:, center],
        np.column_stack([angles, length]),
        rtol=0,
        atol=TOLERANCE,
    )
    jacobian = robot.frame_jacobian(positions, "tip")
    assert relative_error(jacobian[:, :3], closed_form.jacobian(poses)) < TOLERANCE
    # The platform's twist, about its center: three of the legs' rates are its actuators', by the
    # rows [n, b × n].
    arm = rotation[:, :, 2] * -closed_form.tool
    linear = jacobian[:, :3] - np.cross(jacobian[:, 3:], arm[:, :, None], axisa=1, axisb=1, axisc=1)
    rates = closed_form.rates(position - arm, rotation) @ np.concatenate(
        [linear, jacobian[:, 3:]], axis=1
    )
    assert_allclose(rates, np.broadcast_to(np.eye(3), rates.shape), rtol=0, atol=TOLERANCE)


def test_planar_3rrr_looks_the_same_from_all_three_sides(
    robots: dict[str, ClosedLoopRobot], samples: dict[str, Reachable]
) -> None:
    """Handing the state of each leg on to the next turns the robot by 120°.

    That one leg carries the platform must not show.
    """
    robot, positions = robots["planar_3rrr"], samples["planar_3rrr"].positions[:50]
    speeds = np.random.default_rng(1).normal(size=positions.shape)
    mass, coriolis, _ = robot.equation_of_motion(positions, speeds)
    turned_mass, turned_coriolis, _ = robot.equation_of_motion(
        np.roll(positions, 1, axis=1), np.roll(speeds, 1, axis=1)
    )
    assert relative_error(turned_mass, np.roll(mass, (1, 1), axis=(1, 2))) < 1e-9
    assert relative_error(turned_coriolis, np.roll(coriolis, (1, 1), axis=(1, 2))) < 1e-8


MIRRORS: dict[str, Callable[[Array], Array]] = {
    "five_bar": lambda positions: -positions[:, ::-1],
    "delta": lambda positions: positions[:, [0, 2, 1]],
    "gough_stewart": lambda positions: positions[:, [5, 4, 3, 2, 1, 0]],
    "tricept": lambda positions: positions[:, [0, 2, 1]],
}


@pytest.mark.parametrize("name", sorted(MIRRORS))
def test_a_mirrored_robot_reaches_the_mirrored_point(
    name: str, robots: dict[str, ClosedLoopRobot], samples: dict[str, Reachable]
) -> None:
    """The mirror is the plane y = 0, or x = 0 for the five-bar."""
    robot, positions = robots[name], samples[name].positions[:50]
    there, _ = tips(robot, robot.configuration(positions))
    mirrored, _ = tips(robot, robot.configuration(MIRRORS[name](positions)))
    signs = np.array([-1.0, 1.0, 1.0]) if name == "five_bar" else np.array([1.0, -1.0, 1.0])
    assert_allclose(mirrored, signs * there, rtol=0, atol=TOLERANCE)
