"""Shapes and distances.

Against certified bounds by projections, closed forms of the 3-PSP, and the symmetry of the machine.
"""

from __future__ import annotations

from pathlib import Path

import coal
import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import psp3
from psp3.collisions.model import CollisionModel, _attached, collision_model
from psp3.description.parts import ROBOT_FILES
from psp3.errors import (
    InvalidArray,
    InvalidRobotFile,
    InvalidValue,
    OverlappingShapes,
    UnknownName,
    UnreachablePose,
)
from psp3.three_psp.workspace import largest_tilt
from tests.convex_distance import bounds, projection, solid
from tests.helpers import SCREW_AZIMUTHS, Array, four_bar_closed_with_3d

ROBOT = psp3.load()
MODEL = collision_model(ROBOT)

# From urdf/psp3.urdf: bushing, frame of the nut (edge of its plates), columns and arms [m].
BUSHING, EDGE = 0.0145, np.array([0.017, 0.030])
COLUMN_OFFSET, SCREW, SHAFT, ARM = 0.055, 0.009, 0.012, 0.0095

ROUNDED = 2e-6
"""Numbers in the file have six decimals: of places [m], and of angles times lengths up to a
meter.
"""


def random_poses(
    count: int, largest_tilt: float, seed: int = 0, least_tilt: float = 0.0
) -> tuple[Array, Array, Array]:
    """Heights (count, 3) with tilt and azimuth (count,)."""
    rng = np.random.default_rng(seed)
    tilt, azimuth = rng.uniform(least_tilt, largest_tilt, count), rng.uniform(-np.pi, np.pi, count)
    return ROBOT.inverse_kinematics(rng.uniform(-0.2, 0.2, count), tilt, azimuth), tilt, azimuth


def arm_direction(tilt: Array, azimuth: Array, leg: int) -> Array:
    """Direction of an arm in the axes of its leg.

    The shortest rotation that tilts the star, on the x axis (Rodrigues).
    """
    n = np.stack(
        [
            np.sin(tilt) * np.cos(azimuth - SCREW_AZIMUTHS[leg]),
            np.sin(tilt) * np.sin(azimuth - SCREW_AZIMUTHS[leg]),
        ]
    )
    cosine = np.cos(tilt)
    return np.stack(
        [1.0 - n[0] ** 2 / (1.0 + cosine), -n[0] * n[1] / (1.0 + cosine), -n[0]], axis=-1
    )


def pair(first: str, second: str) -> int:
    return MODEL.pairs.index((first, second) if (first, second) in MODEL.pairs else (second, first))


# Shapes


def test_every_shape_is_one_that_is_drawn() -> None:
    """Of the same link, size and place: what is checked is what is seen."""

    def described(geometry: pin.GeometryModel) -> set[tuple[object, ...]]:
        rows = set()
        for shape in geometry.geometryObjects:
            shape.geometry.computeLocalAABB()
            numbers = [
                *shape.geometry.aabb_local.max_,
                *shape.placement.translation,
                *shape.placement.rotation.ravel(),
            ]
            rows.add(
                (
                    ROBOT.model.frames[shape.parentFrame].name,
                    type(shape.geometry).__name__,
                    *np.round(numbers, 6) + 0.0,
                )
            )
        return rows

    visuals = pin.buildGeomFromUrdf(
        ROBOT.model, str(ROBOT_FILES / "psp3.urdf"), pin.GeometryType.VISUAL
    )
    assert described(MODEL.shapes) <= described(visuals)
    assert len(described(MODEL.shapes)) == MODEL.shapes.ngeoms


@pytest.mark.parametrize("seed", [0, 1])
def test_distances_are_certified(seed: int) -> None:
    """Every pair of links: between a lower and an upper bound found without coal; 3e-8 m.

    Coal's tolerance and the gap of the bounds.
    """
    heights, _, _ = random_poses(1, np.radians(34.0), seed)
    found = MODEL.distances(heights[0])
    data, placed = ROBOT.model.createData(), MODEL.shapes.createData()
    pin.updateGeometryPlacements(
        ROBOT.model, data, MODEL.shapes, placed, ROBOT.configuration(heights[0])
    )
    solids = [solid(shape, placed.oMg[k]) for k, shape in enumerate(MODEL.shapes.geometryObjects)]
    least = np.full((len(MODEL.pairs), 2), np.inf)
    for entry in MODEL.shapes.collisionPairs:
        k = pair(MODEL.links[entry.first], MODEL.links[entry.second])
        first, second = solids[entry.first], solids[entry.second]
        apart = (
            np.linalg.norm(first.translation - second.translation)
            - np.linalg.norm(first.size)
            - np.linalg.norm(second.size)
        )
        # Balls around the solids tell which of them are too far to matter.
        if apart < found[k] + 1e-6:
            least[k] = np.minimum(least[k], bounds(first, second))
    assert (least[:, 0] - 3e-8 <= found).all()
    assert (found <= least[:, 1] + 3e-8).all()


def test_nearest_points_are_as_far_apart_as_the_links() -> None:
    """They lie on the shapes, to 1e-6 m.

    The points of two surfaces are found to the root of the distance's tolerance only.
    """
    heights, _, _ = random_poses(10, np.radians(34.0))
    for row in heights:
        nearest = MODEL.nearest(row)
        assert nearest.distance == pytest.approx(MODEL.distances(row).min(), abs=1e-12)
        assert np.linalg.norm(nearest.points[1] - nearest.points[0]) == pytest.approx(
            nearest.distance, abs=1e-7
        )
        data, placed = ROBOT.model.createData(), MODEL.shapes.createData()
        pin.updateGeometryPlacements(
            ROBOT.model, data, MODEL.shapes, placed, ROBOT.configuration(row)
        )
        for link, point in zip(nearest.links, nearest.points, strict=True):
            off = [
                np.linalg.norm(projection(solid(shape, placed.oMg[k]), point) - point)
                for k, shape in enumerate(MODEL.shapes.geometryObjects)
                if MODEL.links[k] == link
            ]
            assert min(off) < 1e-6


def test_results_do_not_depend_on_what_was_measured_before() -> None:
    heights, _, _ = random_poses(5, np.radians(34.0))
    forward = MODEL.distances(heights)
    assert_array_equal(MODEL.distances(heights[::-1])[::-1], forward)


def test_overlapping_links_share_a_point() -> None:
    """At a tilt of 38° toward screw 1 the bushing is 1.3 mm inside its nut.

    A point of one is within the other.
    """
    heights = ROBOT.inverse_kinematics(0.0, np.radians(38.0), 0.0)
    nearest = MODEL.nearest(heights)
    assert nearest.links == ("nut1", "ball_lambda1")
    assert nearest.distance < -1e-3
    data, placed = ROBOT.model.createData(), MODEL.shapes.createData()
    pin.updateGeometryPlacements(
        ROBOT.model, data, MODEL.shapes, placed, ROBOT.configuration(heights)
    )
    solids = {name: [] for name in nearest.links}
    for k, shape in enumerate(MODEL.shapes.geometryObjects):
        if MODEL.links[k] in solids:
            solids[MODEL.links[k]].append(solid(shape, placed.oMg[k]))
    (bushing,), point = solids["ball_lambda1"], nearest.points.mean(axis=0)
    plates = [body for body in solids["nut1"] if body.kind == "box"]
    # Alternating projections end in a common point, if there is one.
    shared = []
    for plate in plates:
        x = point
        for _ in range(2000):
            x = projection(plate, projection(bushing, x))
        shared.append(np.linalg.norm(projection(bushing, x) - x))
    assert min(shared) < 1e-12


# Closed forms


def test_clearance_of_bushing_and_frame() -> None:
    """Axis of the bushing and edge of the plate are two lines.

    They are z0 cos φ − x0 sin φ apart at the pitch φ of the arm.
    """
    heights, tilt, azimuth = random_poses(60, np.radians(40.0), least_tilt=np.radians(28.0))
    distances = MODEL.distances(heights)
    for leg in range(3):
        x, _, z = arm_direction(tilt, azimuth, leg).T
        pitch = np.arctan2(np.abs(z), x)
        expected = EDGE[1] * np.cos(pitch) - EDGE[0] * np.sin(pitch) - BUSHING
        # At less pitch the cups at the sides may be nearer: up to a tilt of 40° the arm turns by
        # 7.6°, and they are 4.7 mm away.
        steep = (expected < 0.0046) & (expected > 0.0)
        assert steep.sum() > 5
        found = distances[steep, pair(f"nut{leg + 1}", f"ball_lambda{leg + 1}")]
        assert_allclose(found, expected[steep], atol=ROUNDED)


def test_arms_pass_their_columns() -> None:
    """Screw and shaft stand 55 mm to either side of the ball joint.

    So their axes are 55 mm · cos ψ from the arm's, ψ its heading.
    """
    heights, tilt, azimuth = random_poses(40, np.radians(45.0), 3)
    distances = MODEL.distances(heights)
    for leg in range(3):
        x, y, _ = arm_direction(tilt, azimuth, leg).T
        expected = COLUMN_OFFSET * np.cos(np.arctan2(y, x)) - max(SCREW, SHAFT) - ARM
        assert_allclose(distances[:, pair("base", f"star{leg + 1}")], expected, atol=ROUNDED)


def test_no_arm_ever_touches_its_column() -> None:
    """While all arms are longer than 0, cos ψ stays above √3/2.

    The arm stays 26 mm away from the shaft.

    The star's center is then inside the nut triangle, seen from above an equilateral one, and from
    a corner of it everything inside lies within 30° of the middle.
    """
    azimuth = np.linspace(0.0, 2.0 * np.pi, 721)
    for share in np.linspace(0.05, 0.999, 20):
        tilt = share * largest_tilt(azimuth)
        for leg in range(3):
            x, y, _ = arm_direction(tilt, azimuth, leg).T
            assert np.cos(np.arctan2(y, x)).min() > np.sqrt(0.75)
    assert COLUMN_OFFSET * np.sqrt(0.75) - SHAFT - ARM > 0.026


def test_the_machine_has_a_threefold_symmetry() -> None:
    """Heights passed on to the next leg.

    The same distances, between the next bodies (the star is one); 4e-6 m, rounding of the file.
    """
    heights, _, _ = random_poses(6, np.radians(34.0), 5)

    def of_bodies(rows: Array, turn: int) -> dict[frozenset[str], Array]:
        least: dict[frozenset[str], Array] = {}
        for k, links in enumerate(MODEL.pairs):
            names = []
            for link in links:
                leg = f"{(int(link[-1]) - 1 + turn) % 3 + 1}" if link[-1].isdigit() else ""
                names.append("star" if link.startswith("star") else link.rstrip("123") + leg)
            key = frozenset(names)
            least[key] = np.minimum(least.get(key, np.inf), rows[:, k])
        return least

    here, there = (
        of_bodies(MODEL.distances(heights), 1),
        of_bodies(MODEL.distances(np.roll(heights, 1, axis=1)), 0),
    )
    assert here.keys() == there.keys()
    for key, distances in here.items():
        assert_allclose(distances, there[key], atol=4e-6)


def test_lifting_the_robot_changes_nothing_between_moving_links() -> None:
    """To 2e-8 m, twice coal's tolerance."""
    heights, _, _ = random_poses(5, np.radians(34.0), 7)
    moving = [k for k, links in enumerate(MODEL.pairs) if "base" not in links]
    assert_allclose(
        MODEL.distances(heights + 0.013)[:, moving], MODEL.distances(heights)[:, moving], atol=2e-8
    )


# Other robots


def balls_on_four_bar(radius: float = 0.02) -> tuple[psp3.ClosedLoopRobot, pin.GeometryModel]:
    """Return a linkage with three balls.

    One on the base beside the path of the coupler's end, one on the coupler, and one on the rocker.
    """
    parts = four_bar_closed_with_3d()
    robot = psp3.ClosedLoopRobot(parts.model, parts.constraint_models, parts.actuated, parts.q0)
    shapes = pin.GeometryModel()
    for name, joint, place in (
        ("base", 0, [0.05, 0.15, 0.1]),
        ("coupler", 2, [0.15, 0.0, 0.1]),
        ("rocker", 3, [0.0, 0.1, 0.0]),
    ):
        shapes.addGeometryObject(
            pin.GeometryObject(
                name, joint, pin.SE3(np.eye(3), np.array(place)), coal.Sphere(radius)
            )
        )
    return robot, shapes


def test_any_robot_whose_shapes_are_made_in_code() -> None:
    """Balls: the distance of their middles less the radii.

    Links without a name have that of their joint. 1e-8 m: coal's tolerance.
    """
    robot, shapes = balls_on_four_bar()
    model = CollisionModel(robot, shapes)
    assert model.pairs == (("universe", "j2"),)
    assert {(one.first, one.second) for one in model.excluded} == {("universe", "j3"), ("j2", "j3")}
    positions = np.linspace(0.6, 1.6, 11)[:, None]
    data = robot.model.createData()
    for row, found in zip(positions, model.distances(positions), strict=True):
        pin.forwardKinematics(robot.model, data, robot.configuration(row))
        middle = data.oMi[2].act(np.array([0.15, 0.0, 0.1]))
        assert found == pytest.approx([np.linalg.norm(middle - [0.05, 0.15, 0.1]) - 0.04], abs=1e-8)


@pytest.mark.parametrize("shape", [(), (4,), (2, 3)])
def test_distances_have_the_leading_dimensions_of_the_positions(shape: tuple[int, ...]) -> None:
    heights, _, _ = random_poses(int(np.prod(shape)), 0.5)
    assert MODEL.distances(heights.reshape(*shape, 3)).shape == (*shape, len(MODEL.pairs))


def test_shapes_stay_on_their_links_where_the_robot_has_other_joints_than_the_file() -> None:
    """A hinge of the file that the robot has as a ball joint, elsewhere on the same link.

    In the neutral pose nothing has moved.
    """

    def arm(joint: object, at: float, link: float) -> pin.Model:
        model = pin.Model()
        index = model.addJoint(0, joint, pin.SE3(np.eye(3), np.array([at, 0.0, 0.0])), "joint")
        placement = pin.SE3(pin.utils.rotate("z", 0.4), np.array([link, 0.0, 0.0]))
        model.addFrame(pin.Frame("arm", index, 0, placement, pin.FrameType.BODY))
        return model

    of_file, of_robot = arm(pin.JointModelRZ(), 1.0, 0.0), arm(pin.JointModelSpherical(), 0.7, 0.3)
    shapes = pin.GeometryModel()
    frame = of_file.getFrameId("arm")
    shapes.addGeometryObject(
        pin.GeometryObject(
            "ball", 1, frame, pin.SE3(np.eye(3), np.array([0.1, 0.2, 0.0])), coal.Sphere(0.1)
        )
    )
    moved = _attached(shapes, of_file, of_robot, Path("some.urdf"))
    places = []
    for model, geometry in ((of_file, shapes), (of_robot, moved)):
        placed = geometry.createData()
        pin.updateGeometryPlacements(
            model, model.createData(), geometry, placed, pin.neutral(model)
        )
        places.append(placed.oMg[0].homogeneous)
    assert_allclose(places[1], places[0], atol=1e-15)
    assert moved.geometryObjects[0].parentJoint == 1
    assert moved.geometryObjects[0].parentFrame == of_robot.getFrameId("arm")


# What is refused


def test_links_that_overlap_at_the_reference_pose_are_refused() -> None:
    """The visuals have the ball in its cups; excluded, with a reason, they pass."""
    with pytest.raises(OverlappingShapes, match="'nut1' and 'ball_lambda1'") as caught:
        CollisionModel(ROBOT, ROBOT.visual_model)
    assert set(caught.value.pairs) == {(f"nut{leg}", f"ball_lambda{leg}") for leg in (1, 2, 3)}
    assert min(caught.value.depths) > 0.0
    cups = [(f"nut{leg}", f"ball_lambda{leg}", "the ball turns in its cups") for leg in (1, 2, 3)]
    assert ("nut1", "ball_lambda1") not in CollisionModel(ROBOT, ROBOT.visual_model, cups).pairs


def test_shapes_of_other_dimensions_are_refused() -> None:
    wider = psp3.load(parameters=psp3.Parameters(screw_radius=0.2))
    with pytest.raises(InvalidRobotFile, match=r"joint 'a1' .* 0\.019"):
        collision_model(wider)
    longer = psp3.load(parameters=psp3.Parameters(tool_length=0.1))
    with pytest.raises(InvalidRobotFile, match=r"frame 'tip' .* 0\.03"):
        collision_model(longer)
    assert collision_model(psp3.load(parameters="table_5_1")).pairs == MODEL.pairs


def test_another_robots_file_is_refused() -> None:
    parts = four_bar_closed_with_3d()
    other = psp3.ClosedLoopRobot(parts.model, parts.constraint_models, parts.actuated, parts.q0)
    with pytest.raises(InvalidRobotFile, match="no link 'base'"):
        collision_model(other, ROBOT_FILES / "psp3.urdf")
    with pytest.raises(InvalidValue, match="urdf"):
        collision_model(other)
    with pytest.raises(InvalidRobotFile, match="no such file"):
        collision_model(ROBOT, ROBOT_FILES / "none.urdf")


def test_a_file_without_shapes_is_refused(tmp_path: Path) -> None:
    text = (ROBOT_FILES / "psp3.urdf").read_text(encoding="utf-8")
    path = tmp_path / "bare.urdf"
    path.write_text("\n".join(line for line in text.splitlines() if "<collision>" not in line))
    with pytest.raises(InvalidRobotFile, match="no <collision> element"):
        collision_model(ROBOT, path)


def test_shapes_must_be_convex_and_some() -> None:
    with pytest.raises(InvalidValue, match="without shapes"):
        CollisionModel(ROBOT, pin.GeometryModel())
    mesh = coal.BVHModelOBBRSS()
    shapes = pin.GeometryModel()
    shapes.addGeometryObject(pin.GeometryObject("mesh", 1, pin.SE3.Identity(), mesh))
    with pytest.raises(InvalidValue, match="convex"):
        CollisionModel(ROBOT, shapes)


def test_excluded_links_must_exist() -> None:
    with pytest.raises(UnknownName, match="nut9"):
        CollisionModel(ROBOT, MODEL.shapes, [("nut9", "base", "?")])


def test_bad_positions_are_refused() -> None:
    for bad in ([0.0, 0.0], [np.nan, 0.0, 0.0]):
        with pytest.raises(InvalidArray):
            MODEL.distances(bad)
        with pytest.raises(InvalidArray):
            MODEL.nearest(bad)
    with pytest.raises(UnreachablePose):
        MODEL.distances([0.5, -0.5, 0.0])
