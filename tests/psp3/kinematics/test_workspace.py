"""Maps, borders and rays of any robot against closed-form inverse kinematics and areas.

Files against damage.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.optimize import brentq

import psp3
from psp3.errors import ClosureFailed, InvalidArray, InvalidValue, UnknownName
from psp3.kinematics.border import Boundary
from psp3.kinematics.pose_map import KinematicMap, Status
from psp3.kinematics.tasks import TASK_COORDINATES
from psp3.kinematics.workspace import Workspace
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.closed_form_kinematics import Delta, FiveBar, GoughStewart, PlanarThreeRRR, around
from tests.helpers import Array

REACH = FiveBar().crank + FiveBar().rod
HOLE = FiveBar().rod - FiveBar().crank


@pytest.fixture(scope="module")
def five_bar() -> Workspace:
    return Workspace(psp3.load("five_bar"), "tip", ("x", "z"))


@pytest.fixture(scope="module")
def plane(five_bar: Workspace) -> KinematicMap:
    return five_bar.map({"x": np.linspace(-0.45, 0.45, 26), "z": np.linspace(-0.51, 0.51, 28)})


def nodes(poses: KinematicMap) -> Array:
    return np.stack(np.meshgrid(*poses.grid.values(), indexing="ij"), axis=-1)


# Maps over a task


def test_five_bar_reaches_what_both_legs_reach(plane: KinematicMap) -> None:
    """Two rings around the shafts, inside both: reachable exactly there, wherever a node is."""
    distances = np.linalg.norm(nodes(plane)[..., np.newaxis, :] - FiveBar().shafts, axis=-1)
    assert np.abs(distances - REACH).min() > 1e-4
    assert np.abs(distances - HOLE).min() > 1e-4
    assert_array_equal(plane.reachable, ((distances > HOLE) & (distances < REACH)).all(axis=-1))


def test_positions_and_joints_of_the_map_are_those_of_the_closed_form(
    five_bar: Workspace, plane: KinematicMap
) -> None:
    """The working mode of home everywhere, so up to full turns around the shafts.

    Newton's 1e-13 near the border.
    """
    reached = plane.reachable
    assert_allclose(plane.position[reached][:, [0, 2]], nodes(plane)[reached], atol=1e-12)
    cranks = plane.configuration[reached][:, five_bar.analysis.robot.actuated_q]
    assert_allclose(np.cos(cranks - FiveBar().inverse(nodes(plane)[reached])), 1.0, atol=1e-9)
    assert np.isnan(plane.configuration[~reached]).all()
    assert np.isnan(plane.margin[~reached]).all()


def test_status_of_the_five_bar(five_bar: Workspace, plane: KinematicMap) -> None:
    """Limits of cranks and elbows, and the side of the line through the elbows, by the closed form.

    Below the shafts, away from turns.
    """
    geometry, points = FiveBar(), nodes(plane)
    below = plane.reachable & (points[..., 1] < -0.09)
    positions = geometry.inverse(points[below])
    bends = np.pi - np.arccos(
        (
            geometry.crank**2
            + geometry.rod**2
            - np.linalg.norm(points[below][:, np.newaxis] - geometry.shafts, axis=-1) ** 2
        )
        / (2.0 * geometry.crank * geometry.rod)
    )
    within = (np.abs(positions) <= 1.5).all(axis=1) & (bends <= 2.6).all(axis=1)
    assert_array_equal(plane.status[below] > Status.BEYOND_LIMIT, within)
    margin = five_bar.analysis.length * np.minimum(1.5 - np.abs(positions), 2.6 - bends).min(axis=1)
    assert_allclose(plane.margin[below], margin, atol=1e-9)
    assert 0 < plane.usable.sum() < plane.reachable.sum()


def test_area_of_the_five_bar_is_that_of_the_rings(rings: Boundary) -> None:
    """Lens of two circles less two holes, to 0.3 % for straight chords of up to 52 mm.

    Points of it to a thousandth of edges of 38 mm.
    """
    spacing = float(np.ptp(FiveBar().shafts[:, 0]))
    lens = 2.0 * REACH**2 * np.arccos(spacing / (2.0 * REACH)) - 0.5 * spacing * np.sqrt(
        4.0 * REACH**2 - spacing**2
    )
    expected = lens - 2.0 * np.pi * HOLE**2
    assert_allclose(rings.area, expected, rtol=3e-3)
    distances = np.linalg.norm(rings.segments[..., np.newaxis, :] - FiveBar().shafts, axis=-1)
    assert_allclose(
        np.minimum(np.abs(distances - REACH), np.abs(distances - HOLE)).min(axis=-1), 0.0, atol=5e-5
    )


def test_usable_region_ends_at_a_limit_or_a_singularity(
    five_bar: Workspace, plane: KinematicMap, rings: Boundary
) -> None:
    """Every point of the border is at a limit of the closed form's angles.

    Or its measure is the least allowed; to 30 µm.
    """
    border = five_bar.boundary(plane)
    assert border.area < rings.area
    points = border.segments[:, 0]
    positions = np.mod(FiveBar().inverse(points) + np.pi, 2.0 * np.pi) - np.pi
    q = np.array(
        [
            five_bar_configuration(five_bar.analysis.robot, *row, point)
            for row, point in zip(positions, points, strict=True)
        ]
    )
    measures = five_bar.analysis.measures(q)
    bends = np.abs(np.mod(q[:, five_bar.analysis.robot.dependent_v] + np.pi, 2.0 * np.pi) - np.pi)
    limits = np.minimum(np.abs(1.5 - np.abs(positions)), np.abs(2.6 - bends)).min(axis=1)
    singular = np.minimum(np.abs(measures.end_effector - 0.01), np.abs(measures.actuation - 0.01))
    assert np.minimum(limits, singular).max() < 1e-2
    assert (limits < 1e-3).any()
    assert (singular < 1e-3).any()


def five_bar_configuration(
    robot: ClosedLoopRobot, first: float, second: float, tip: Array
) -> Array:
    """Angles of cranks and rods by the directions of their links.

    A link that hangs has the angle 0.
    """
    rods = tip - FiveBar().elbows([first, second])
    directions = np.arctan2(-rods[:, 0], -rods[:, 1])
    q = np.empty(4)
    q[robot.actuated_q] = first, second
    for leg, angle in ((1, directions[0] - first), (2, directions[1] - second)):
        q[robot.model.joints[robot.model.getJointId(f"leg{leg}_elbow")].idx_q] = angle
    return q


def test_three_rrr_is_cut_by_its_singularity() -> None:
    """At a turn of -32° the determinant of the closed form changes its sign within reach.

    Across it poses are reached, and not usable.
    """
    geometry, angle = PlanarThreeRRR(), np.radians(-32.0)
    space = Workspace(psp3.load("planar_3rrr"), "tip", ("x", "y", "rz"), singular_below=0.0)
    axis = np.linspace(-0.12, 0.12, 21)
    poses = space.map({"x": axis, "y": axis}, held={"rz": angle})
    assert poses.held == {"rz": angle}
    pose = np.concatenate([nodes(poses), np.full((21, 21, 1), angle)], axis=-1)
    reachable = np.isfinite(geometry.inverse(pose)).all(axis=-1)
    assert_array_equal(poses.reachable, reachable)
    home = np.sign(np.linalg.det(geometry.jacobian(np.zeros(3))))
    same = np.full((21, 21), True)
    same[reachable] = np.sign(np.linalg.det(geometry.jacobian(pose[reachable]))) == home
    within = poses.margin >= 0.0
    assert_array_equal(poses.status[within] >= Status.APART, True)
    # Of the parts on the side of home only one is usable.
    assert same[poses.usable].all()
    assert (poses.status[within & ~same] == Status.APART).all()
    assert (poses.status == Status.APART).sum() > 20 < same[reachable].sum()


def test_usable_poses_hang_together(plane: KinematicMap) -> None:
    """Above the shafts the five-bar's angles are within limits again.

    On the side of home after two singularities, so cut off all the same.

    Flooded by hand from the node nearest to home.
    """
    good = plane.status >= Status.APART
    x, z = plane.grid.values()
    waiting, seen = [(int(np.abs(x).argmin()), int(np.abs(z + 0.35).argmin()))], set()
    while waiting:
        node = waiting.pop()
        if node in seen or not (0 <= node[0] < x.size and 0 <= node[1] < z.size) or not good[node]:
            continue
        seen.add(node)
        waiting += [(node[0] + i, node[1] + j) for i, j in ((1, 0), (-1, 0), (0, 1), (0, -1))]
    assert {tuple(node) for node in np.argwhere(plane.usable).tolist()} == seen
    above = (plane.status == Status.APART) & (nodes(plane)[..., 1] > 0.1)
    assert above.any()
    assert_array_equal(plane.measures.orientation[above], plane.measures.orientation[min(seen)])
    assert not plane.usable[nodes(plane)[..., 1] > 0.0].any()


def test_margins_are_those_of_the_joints_one_by_one() -> None:
    """Platform leaning both ways.

    Legs in meters, hinges in meters of arc, of joints found by their names.
    """
    robot = psp3.load("gough_stewart")
    space = Workspace(robot, "tip", TASK_COORDINATES, length=0.25)
    poses = space.map({"rx": np.linspace(-0.4, 0.4, 5), "ry": np.linspace(-0.4, 0.4, 5)})
    assert poses.reachable.all()
    for index in np.ndindex(5, 5):
        margins = []
        for name in list(robot.model.names)[1:]:
            at = robot.model.joints[robot.model.getJointId(name)].idx_q
            value, lower, upper = (
                vector[at]
                for vector in (
                    poses.configuration[index],
                    robot.model.lowerPositionLimit,
                    robot.model.upperPositionLimit,
                )
            )
            margins.append(
                min(value - lower, upper - value) * (1.0 if name.endswith("length") else 0.25)
            )
        assert_allclose(poses.margin[index], min(margins), rtol=1e-12)
        assert (poses.status[index] == Status.BEYOND_LIMIT) == (min(margins) < 0.0)


# Maps over the actuators


def test_five_bar_over_its_cranks() -> None:
    """The elbows may be no farther apart than two rods.

    The tip is on the side of home, as the intersection of two circles has it.
    """
    geometry, robot = FiveBar(), psp3.load("five_bar")
    space = Workspace(robot, "tip", ("x", "z"), over="actuators")
    around_home = np.linspace(-0.9, 0.9, 27)
    poses = space.map(
        {
            name: value + around_home
            for name, value in zip(robot.actuated, robot.reference, strict=True)
        }
    )
    positions = nodes(poses)
    elbows = geometry.elbows(positions)
    apart = np.linalg.norm(elbows[..., 0, :] - elbows[..., 1, :], axis=-1)
    assert_array_equal(poses.reachable, apart < 2.0 * geometry.rod)
    reached = poses.reachable
    assert_allclose(
        poses.position[reached][:, [0, 2]], geometry.forward(positions[reached]), atol=1e-7
    )
    assert_allclose(
        poses.configuration[reached][:, robot.actuated_q], positions[reached], atol=1e-15
    )
    # Cranks of leg 1 or 2 in line with their rods: the tip's Jacobian changes its sign.
    flips = poses.measures.orientation[reached] * np.sign(
        np.linalg.det(geometry.jacobian(positions[reached]))
    )
    assert_array_equal(flips, flips[0])
    assert {Status.USABLE, Status.APART} <= set(poses.status[reached].tolist())


def test_3_psp_over_its_nuts_is_its_closed_form() -> None:
    """The generic route against psp3's own kinematics, on three coordinates at once.

    1e-11: Newton's method.
    """
    robot = psp3.load("psp3")
    space = Workspace(robot, "tip", ("x", "y", "z"), over="actuators")
    axis = np.linspace(-0.1, 0.1, 5)
    poses = space.map({"a1": axis, "a2": axis, "a3": axis})
    assert poses.status.shape == (5, 5, 5)
    assert poses.reachable.all()
    assert_allclose(poses.position, robot.forward_kinematics(nodes(poses)).tip, atol=1e-11)
    assert_allclose(
        poses.measures.condition, np.linalg.cond(robot.tip_jacobian(nodes(poses))), rtol=1e-7
    )
    determinant = np.linalg.det(robot.tip_jacobian(nodes(poses)))
    assert_allclose(poses.measures.manipulability, np.abs(determinant), rtol=1e-9)


# Rays


def without_limits(robot: ClosedLoopRobot) -> ClosedLoopRobot:
    model = robot.model.copy()
    model.lowerPositionLimit, model.upperPositionLimit = (
        np.full(model.nq, -np.inf),
        np.full(model.nq, np.inf),
    )
    return ClosedLoopRobot(model, robot.constraint_models, robot.actuated, robot.q0)


def ends(
    five_bar: Workspace,
    direction: dict[str, float],
    singular_below: float = 0.0,
    over: str = "task",
) -> tuple[float, str]:
    robot = without_limits(five_bar.analysis.robot)
    reach = Workspace(robot, "tip", ("x", "z"), over, singular_below=singular_below).distance(
        direction, 1.5
    )
    return reach.distance, reach.ends


def test_rays_of_the_five_bar(five_bar: Workspace) -> None:
    """From home down until both legs are stretched; up until the rods are in line.

    Cranks apart until they are. Closed form, 1e-10.
    """
    depth = -float(FiveBar().forward(five_bar.analysis.robot.reference)[1])
    found, why = ends(five_bar, {"z": -1.0})
    assert_allclose(found, np.sqrt(REACH**2 - 0.01) - depth, atol=1e-10)
    assert why == "end_effector"
    swing = np.arcsin(0.9)
    found, why = ends(five_bar, {"z": 1.0})
    assert_allclose(found, depth - FiveBar().crank * np.cos(swing), atol=1e-10)
    assert why == "actuation"
    directions = dict(
        zip(five_bar.analysis.robot.actuated, FiveBar().outward.tolist(), strict=True)
    )
    found, why = ends(five_bar, directions, over="actuators")
    assert_allclose(found, swing - 0.6, atol=1e-10)
    assert why == "actuation"
    # With its limits the robot is stopped on the way up, where its elbows are bent by 2.6 rad.
    reach = five_bar.distance({"z": 1.0}, 1.5)
    assert (reach.ends, reach.joint[4:]) == ("limit", "_elbow")
    assert_allclose(
        np.abs(reach.configuration[five_bar.analysis.robot.dependent_v]), 2.6, atol=1e-9
    )


def test_a_ray_ends_sooner_if_it_has_to_stay_away_from_singularities(five_bar: Workspace) -> None:
    """Where the measure falls to what was asked for, and half a direction is twice as far."""
    near, far = ends(five_bar, {"z": -1.0}, singular_below=0.1)[0], ends(five_bar, {"z": -1.0})[0]
    assert near < far
    reach = Workspace(five_bar.analysis.robot, "tip", ("x", "z"), singular_below=0.1).distance(
        {"z": -0.5}, 3.0
    )
    assert_allclose(reach.distance, 2.0 * near, rtol=1e-9)
    assert_allclose(five_bar.analysis.measures(reach.configuration).end_effector, 0.1, rtol=1e-6)


def test_a_ray_ends_at_the_limit_of_a_joint() -> None:
    """The Gough-Stewart platform is lifted until its legs are 0.95 m long, all at once.

    By symmetry any of them is right.
    """
    robot = psp3.load("gough_stewart")
    reach = Workspace(robot, "tip", TASK_COORDINATES).distance({"z": 1.0}, 1.0)
    flat = GoughStewart().feet - GoughStewart().corners
    assert_allclose(reach.distance, np.sqrt(0.95**2 - (flat[0] ** 2).sum()) - 0.7, atol=1e-10)
    assert reach.ends == "limit"
    assert reach.joint in robot.actuated
    assert_allclose(reach.configuration[robot.actuated_q], 0.95, atol=1e-10)


def test_tip_of_the_3_psp_reaches_the_closed_forms_border() -> None:
    """sqrt(h² + d²/4) - d/2 = 23.9 mm toward screw 1, and the closed form's border elsewhere.

    By following the robot until it ends.
    """
    robot = psp3.load("psp3")
    space = Workspace(robot, "tip", ("x", "y", "z"), singular_below=0.0)
    for azimuth in (0.0, 0.4, np.pi / 3.0, 2.5):
        reach = space.distance({"x": float(np.cos(azimuth)), "y": float(np.sin(azimuth))}, 0.1)
        assert_allclose(reach.distance, robot.tip_reach(azimuth), atol=1e-10)
        assert reach.ends == "end_effector"
    assert_allclose(
        space.distance({"x": 1.0}, 0.1).distance,
        np.sqrt(0.070**2 + 0.181**2 / 4.0) - 0.181 / 2.0,
        atol=1e-10,
    )


def test_delta_ends_where_its_platform_can_turn() -> None:
    """Where the normals of the three parallelograms come to lie in a plane, by the closed form.

    A singularity of constraint, to 1e-6.
    """
    robot = without_limits(psp3.load("delta"))
    start = robot.frame_placement(robot.reference, "tip")[:3, 3]
    way = np.array([-0.165, 0.286, -0.126]) - start
    space = Workspace(robot, "tip", ("x", "y", "z"), singular_below=0.0)
    reach = space.distance(dict(zip("xyz", way.tolist(), strict=True)), 1.0)
    assert reach.ends == "constraint"

    def volume(share: float) -> float:
        tip = start + share * way
        rods = (tip - Delta().elbows(Delta().inverse(tip))) / Delta().rod
        return float(np.linalg.det(np.cross(rods, around(Delta().azimuths + 0.5 * np.pi, 1.0))))

    assert_allclose(reach.distance, brentq(volume, 0.7, 0.9), atol=1e-6)


def test_a_ray_that_nothing_ends_goes_as_far_as_it_may(five_bar: Workspace) -> None:
    reach = five_bar.distance({"x": 1.0}, 0.01)
    assert (reach.distance, reach.ends, reach.joint) == (0.01, "farthest", "")
    assert_allclose(five_bar.analysis.positions(reach.configuration)[0], 0.01, atol=1e-12)


def test_a_ray_that_starts_beyond_a_limit_has_no_length(
    five_bar: Workspace, plane: KinematicMap
) -> None:
    x, z = nodes(plane)[plane.status == Status.BEYOND_LIMIT][0]
    reach = five_bar.distance({"x": 1.0}, 0.1, start={"x": float(x), "z": float(z)})
    assert (reach.distance, reach.ends) == (0.0, "limit")
    assert reach.joint in five_bar.analysis.robot.model.names


# Robots without loops, and without limits


def arm() -> ClosedLoopRobot:
    """Two links in the plane, 0.5 m and 0.3 m."""
    model = pin.Model()
    first = model.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), "shoulder")
    second = model.addJoint(
        first, pin.JointModelRZ(), pin.SE3(np.eye(3), np.array([0.5, 0.0, 0.0])), "elbow"
    )
    model.addFrame(
        pin.Frame(
            "hand", second, 0, pin.SE3(np.eye(3), np.array([0.3, 0.0, 0.0])), pin.FrameType.OP_FRAME
        )
    )
    return ClosedLoopRobot(model, [], ("shoulder", "elbow"), [0.3, 1.2])


@pytest.fixture(scope="module")
def ring() -> tuple[Workspace, KinematicMap]:
    space = Workspace(arm(), "hand", ("x", "y"))
    axis = np.linspace(-0.85, 0.83, 30)
    return space, space.map({"x": axis, "y": axis})


@pytest.fixture(scope="module")
def circles(ring: tuple[Workspace, KinematicMap]) -> Boundary:
    return ring[0].boundary(ring[1], Status.BEYOND_LIMIT)


@pytest.fixture(scope="module")
def rings(five_bar: Workspace, plane: KinematicMap) -> Boundary:
    return five_bar.boundary(plane, Status.BEYOND_LIMIT)


def test_arm_reaches_a_ring(ring: tuple[Workspace, KinematicMap], circles: Boundary) -> None:
    """Radii 0.2 and 0.8 m, to a thousandth of edges of 58 mm.

    Without limits the margin is infinite. Straight chords cost 0.3 % of area.
    """
    _, poses = ring
    assert_allclose(circles.area, np.pi * (0.8**2 - 0.2**2), rtol=3e-3)
    radii = np.linalg.norm(circles.segments, axis=-1)
    assert_allclose(np.minimum(np.abs(radii - 0.8), np.abs(radii - 0.2)), 0.0, atol=6e-5)
    assert (poses.margin[poses.reachable] == np.inf).all()
    assert set(poses.status.ravel().tolist()) <= {
        Status.UNREACHABLE,
        Status.SINGULAR,
        Status.USABLE,
    }


def test_distance_from_the_border_is_that_from_the_circles(circles: Boundary) -> None:
    """To the sagitta of chords of up to 82 mm: 1.1 mm on the outer, 4.2 mm on the inner circle."""
    points = np.random.default_rng(7).uniform(-0.5, 0.5, size=(4, 50, 2))
    radii = np.linalg.norm(points, axis=-1)
    assert_allclose(
        circles.distance(points), np.minimum(np.abs(radii - 0.8), np.abs(radii - 0.2)), atol=4.2e-3
    )


def test_distance_from_a_segment_by_brute_force() -> None:
    border = Boundary(
        np.array([[[0.0, 0.0], [1.0, 0.0]], [[1.0, 0.0], [1.0, 2.0]], [[3.0, 3.0], [3.0, 3.0]]]),
        0.0,
    )
    points = np.random.default_rng(8).uniform(-1.0, 4.0, size=(30, 2))
    dense = np.concatenate(
        [
            start + np.linspace(0.0, 1.0, 4001)[:, np.newaxis] * (end - start)
            for start, end in border.segments
        ]
    )
    expected = np.linalg.norm(points[:, np.newaxis] - dense, axis=-1).min(axis=1)
    assert_allclose(border.distance(points), expected, atol=1e-6)
    assert Boundary(np.zeros((0, 2, 2)), 0.0).distance([0.0, 0.0]) == np.inf


def test_a_grid_that_the_robot_does_not_reach_is_empty() -> None:
    poses = Workspace(arm(), "hand", ("x", "y")).map({"x": [2.0, 2.1], "y": [0.0, 0.1]})
    assert not poses.reachable.any()
    assert np.isnan(poses.measures.actuation).all()


def test_one_coordinate_and_values_held(five_bar: Workspace) -> None:
    poses = five_bar.map({"z": np.linspace(-0.45, -0.2, 6)}, held={"x": 0.05})
    assert poses.status.shape == (6,)
    assert poses.held == {"x": 0.05}
    assert_allclose(poses.position[:, 0], 0.05, atol=1e-12)
    assert five_bar.map({"z": [-0.4, -0.3]}).held == {"x": five_bar.reference["x"]}


def test_border_of_a_map_over_one_coordinate_is_refused(five_bar: Workspace) -> None:
    with pytest.raises(InvalidValue, match="two coordinates"):
        five_bar.boundary(five_bar.map({"z": [-0.4, -0.3]}))


def test_border_between_a_length_and_an_angle_has_no_area() -> None:
    space = Workspace(psp3.load("planar_3rrr"), "tip", ("x", "y", "rz"))
    with pytest.raises(InvalidValue, match="same unit"):
        space.boundary(space.map({"x": [0.0, 0.01], "rz": [0.0, 0.1]}))


def test_reaching_a_node_does_not_depend_on_the_grids_density(five_bar: Workspace) -> None:
    """Continuation goes from node to node, however far they are apart."""
    coarse = five_bar.map({"x": np.linspace(-0.3, 0.3, 4), "z": np.linspace(-0.4, -0.1, 4)})
    fine = five_bar.map({"x": np.linspace(-0.3, 0.3, 13), "z": np.linspace(-0.4, -0.1, 13)})
    assert_array_equal(coarse.status, fine.status[::4, ::4])
    reached = coarse.reachable
    assert_allclose(
        coarse.configuration[reached], fine.configuration[::4, ::4][reached], atol=1e-10
    )


def test_singular_poses_lie_along_the_closed_forms_locus() -> None:
    """Cranks of the five-bar swung together.

    The lowest measure of the end effector is where the closed form's determinant vanishes.
    """
    geometry, robot = FiveBar(), psp3.load("five_bar")
    space = Workspace(robot, "tip", ("x", "z"), over="actuators")
    first = np.linspace(-1.0, 1.4, 49)
    poses = space.map({"leg1_shoulder": first}, held={"leg2_shoulder": 0.6})

    def determinant(angle: float) -> float:
        return float(np.linalg.det(geometry.jacobian([angle, 0.6])))

    reached = poses.reachable
    signs = np.sign([determinant(angle) for angle in first[reached]])
    change = np.flatnonzero(signs[:-1] != signs[1:])
    assert change.size > 0
    for k in change:
        locus = brentq(determinant, first[reached][k], first[reached][k + 1])
        q = robot.configuration([locus, 0.6])
        assert space.analysis.measures(q).end_effector < 1e-7
        assert poses.measures.orientation[reached][k] == -poses.measures.orientation[reached][k + 1]


# Bad input


@pytest.mark.parametrize(
    ("call", "error", "match"),
    [
        (lambda space: space.map({}), InvalidValue, "grid"),
        (lambda space: space.map({"y": [0.0, 1.0]}), UnknownName, "'y'"),
        (lambda space: space.map({"x": [0.0]}), InvalidArray, "ascending"),
        (lambda space: space.map({"x": [0.1, 0.0]}), InvalidArray, "ascending"),
        (lambda space: space.map({"x": [0.0, np.nan]}), InvalidArray, "nan"),
        (lambda space: space.map({"x": [[0.0, 1.0]]}), InvalidArray, "ascending"),
        (lambda space: space.map({"x": "wide"}), InvalidArray, "wide"),
        (lambda space: space.map({"x": 0.0}), InvalidArray, "grid"),
        (lambda space: space.map({"x": [0.0, 0.1]}, held={"x": 0.0}), InvalidValue, "held"),
        (lambda space: space.map({"x": [0.0, 0.1]}, held={"rz": 0.0}), UnknownName, "rz"),
        (lambda space: space.map({"x": [0.0, 0.1]}, held={"z": np.inf}), InvalidValue, "held"),
        (lambda space: space.map({"x": [0.0, 0.1]}, held={"z": "low"}), InvalidValue, "low"),
        (lambda space: space.distance({}, 1.0), InvalidValue, "direction"),
        (lambda space: space.distance({"x": 0.0}, 1.0), InvalidValue, "direction"),
        (lambda space: space.distance({"x": np.nan}, 1.0), InvalidValue, "direction"),
        (lambda space: space.distance({"x": np.inf}, 1.0), InvalidValue, "direction"),
        (lambda space: space.distance({"q": 1.0}, 1.0), UnknownName, "q"),
        (lambda space: space.distance({"x": 1.0}, 0.0), InvalidValue, "farthest"),
        (lambda space: space.distance({"x": 1.0}, 1.0, start={"x": np.nan}), InvalidValue, "start"),
        (lambda space: space.distance({"x": 1.0}, 1.0, start={"z": -2.0}), ClosureFailed, "-2"),
        (
            lambda space: Workspace(space.analysis.robot, "tip", ("x", "z"), over="moon"),
            UnknownName,
            "moon",
        ),
        (lambda space: Workspace(space.analysis.robot, "moon", ("x", "z")), UnknownName, "moon"),
        (lambda space: Workspace(space.analysis.robot, "tip", ("x",)), InvalidValue, "as many"),
        (
            lambda space: Workspace(space.analysis.robot, "tip", ("x", "z"), singular_below=-0.1),
            InvalidValue,
            "singular_below",
        ),
        (
            lambda space: Workspace(space.analysis.robot, "tip", ("x", "z"), length=0.0),
            InvalidValue,
            "length",
        ),
        (
            lambda space: Boundary(np.zeros((1, 2, 2)), 0.0).distance([np.nan, 0.0]),
            InvalidArray,
            "nan",
        ),
    ],
)
def test_bad_input_is_refused(
    call: Callable[[Any], object], error: type[Exception], match: str, five_bar: Workspace
) -> None:
    with pytest.raises(error, match=match):
        call(five_bar)


@pytest.mark.parametrize("at_least", [Status.UNREACHABLE, 7, "usable", None])
def test_borders_of_nothing_are_refused(
    at_least: Any, five_bar: Workspace, plane: KinematicMap
) -> None:
    with pytest.raises(InvalidValue, match="at_least"):
        five_bar.boundary(plane, at_least)


def test_a_map_of_another_workspace_is_refused(plane: KinematicMap) -> None:
    with pytest.raises(InvalidValue, match="of this workspace"):
        Workspace(arm(), "hand", ("x", "y")).boundary(plane)


def test_four_rrr_ends_where_a_leg_is_stretched() -> None:
    """More motors than coordinates: sideways, the two legs behind the platform are 0.34 m long."""
    space = Workspace(psp3.load("planar_4rrr"), "tip", ("x", "y", "rz"), singular_below=0.0)
    apart = (0.3 - 0.08) / np.sqrt(2.0)
    expected = np.sqrt(0.34**2 - apart**2) - apart
    for name, sign in (("x", 1.0), ("x", -1.0), ("y", 1.0), ("y", -1.0)):
        reach = space.distance({name: sign}, 1.0)
        assert reach.ends == "end_effector"
        assert reach.distance == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("name", ["hexa", "planar_4rrr"])
def test_robots_with_held_or_more_motors_over_their_coordinates(name: str) -> None:
    """Configurations are those of the robot itself, of which limits do not matter here."""
    robot = psp3.load(name)
    task = ("x", "y", "z", "rx", "ry", "rz") if name == "hexa" else ("x", "y", "rz")
    space = Workspace(robot, "tip", task, over="actuators")
    assert space.coordinates == robot.coordinates
    first = robot.coordinates[0]
    values = space.reference[first] + np.array([-0.05, 0.05])
    poses = space.map({first: values})
    for value, q in zip(values, poses.configuration, strict=True):
        positions = robot.reference.copy()
        positions[0] = value
        np.testing.assert_allclose(q, robot.configuration(positions), rtol=0.0, atol=1e-11)


@pytest.mark.parametrize("name", ["gripper", "biped"])
def test_robots_whose_coordinates_follow_are_refused(name: str) -> None:
    with pytest.raises(InvalidValue, match=r"follow .*free='lock'"):
        Workspace(psp3.load(name), "tip", ("x", "y", "z"))
