"""The robot on disk as people see it.

Visuals of the URDF, reference poses of the SRDF, and the recipe in urdf/README.md.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin
import pytest

import psp3

FILES = Path(__file__).parents[2] / "urdf"
SHAPES = {"box", "cylinder", "sphere"}
JOINTS = [f"{joint}{leg}" for leg in (1, 2, 3) for joint in ("a", "phi", "theta", "lambda", "b")]

# Heights over the stroke with the star tilted by up to 35 degrees, the working range of the
# machine.
RNG = np.random.default_rng(0)
POSES = [
    psp3.load().inverse_kinematics(height=height, tilt=tilt, azimuth=azimuth)
    for height, tilt, azimuth in RNG.uniform(
        [-0.25, 0.0, -np.pi], [0.25, np.radians(35.0), np.pi], (60, 3)
    )
]


@pytest.fixture(scope="module")
def model() -> pin.Model:
    return pin.buildModelFromUrdf(str(FILES / "psp3.urdf"))


@pytest.fixture(scope="module")
def visuals(model: pin.Model) -> pin.GeometryModel:
    return pin.buildGeomFromUrdf(model, str(FILES / "psp3.urdf"), pin.GeometryType.VISUAL)


def shapes_of(model: pin.Model, visuals: pin.GeometryModel, joint: str) -> list[pin.GeometryObject]:
    return [
        shape for shape in visuals.geometryObjects if shape.parentJoint == model.getJointId(joint)
    ]


def columns(visuals: pin.GeometryModel) -> list[pin.GeometryObject]:
    """Screws and guide shafts: the long cylinders of the base."""
    return [
        shape
        for shape in visuals.geometryObjects
        if shape.parentJoint == 0
        and isinstance(shape.geometry, coal.Cylinder)
        and shape.geometry.halfLength > 0.4
    ]


def placed(model: pin.Model, visuals: pin.GeometryModel, heights: np.ndarray) -> dict[str, pin.SE3]:
    data, placements = model.createData(), visuals.createData()
    pin.updateGeometryPlacements(
        model, data, visuals, placements, psp3.load().configuration(heights)
    )
    return {
        shape.name: placement.copy()
        for shape, placement in zip(visuals.geometryObjects, placements.oMg, strict=True)
    }


def height_range(shape: pin.GeometryObject) -> tuple[float, float]:
    """Lowest and highest z of a shape, in the frame of its joint."""
    shape.geometry.computeLocalAABB()
    box = shape.geometry.aabb_local
    x, y, z = np.meshgrid(*np.stack([box.min_, box.max_], axis=-1))
    corners = (
        np.stack([x, y, z], axis=-1).reshape(-1, 3) @ shape.placement.rotation.T
        + shape.placement.translation
    )
    return corners[:, 2].min(), corners[:, 2].max()


def test_only_primitives_in_named_colors() -> None:
    root = ElementTree.parse(FILES / "psp3.urdf").getroot()
    colors = {material.get("name") for material in root.findall("material")}
    assert {child.tag for geometry in root.iter("geometry") for child in geometry} == SHAPES
    assert {material.get("name") for material in root.findall("link/visual/material")} == colors
    for link in (
        "base",
        *(f"{name}{leg}" for name in ("nut", "ball_lambda", "star") for leg in (1, 2, 3)),
    ):
        assert root.find(f"link[@name='{link}']/visual") is not None, link


def test_pinocchio_keeps_every_color(visuals: pin.GeometryModel) -> None:
    """A material that Pinocchio does not find turns gray (0.9, 0.9, 0.9) in silence."""
    root = ElementTree.parse(FILES / "psp3.urdf").getroot()
    wanted = {material.find("color").get("rgba") for material in root.findall("material")}
    found = {tuple(shape.meshColor) for shape in visuals.geometryObjects}
    assert visuals.ngeoms == len(root.findall("link/visual"))
    np.testing.assert_allclose(
        sorted(found), sorted(tuple(map(float, color.split())) for color in wanted), atol=1e-12
    )


@pytest.mark.parametrize("height", [-0.4, 0.4])
def test_the_nuts_have_their_whole_stroke(
    model: pin.Model, visuals: pin.GeometryModel, height: float
) -> None:
    """Between the bearings, which are the nearest shapes of the base above and below."""
    ranges = [height_range(shape) for shape in shapes_of(model, visuals, "a1")]
    lowest, highest = (
        height + min(low for low, _ in ranges),
        height + max(high for _, high in ranges),
    )
    at_the_columns = [
        height_range(shape)
        for shape in visuals.geometryObjects
        if shape.parentJoint == 0 and shape not in columns(visuals)
    ]
    assert max(high for _, high in at_the_columns if high < 0) < lowest
    assert highest < min(low for low, _ in at_the_columns if low > 0)


def test_the_tool_ends_at_the_tip(model: pin.Model, visuals: pin.GeometryModel) -> None:
    """To 1e-9 m; every number in the file has six decimals."""
    highest = max(height_range(shape)[1] for shape in shapes_of(model, visuals, "b1"))
    tip = model.frames[model.getFrameId("tip")].placement.translation
    np.testing.assert_allclose([0.0, 0.0, highest], tip, atol=1e-9)


def test_the_machine_has_a_threefold_axis(model: pin.Model, visuals: pin.GeometryModel) -> None:
    """Turned by 120 degrees, the base's shapes cover themselves.

    To 2e-6 m, for the file has 6 decimals.
    """

    def description(turn: float) -> list[tuple[float, ...]]:
        rotation = pin.rpy.rpyToMatrix(0.0, 0.0, turn)
        rows = []
        for shape in visuals.geometryObjects:
            if shape.parentJoint == 0:
                shape.geometry.computeLocalAABB()
                size = shape.geometry.aabb_local.max_
                axis = (
                    rotation @ shape.placement.rotation[:, 0]
                    if isinstance(shape.geometry, coal.Box)
                    else np.zeros(3)
                )
                rows.append((*size, *(rotation @ shape.placement.translation), *axis))
        return sorted(tuple(np.round(row, 4) + 0.0) for row in rows)

    np.testing.assert_allclose(description(2.0 * np.pi / 3.0), description(0.0), atol=2e-4)


@pytest.mark.slow
def test_each_arm_slides_through_its_ball_and_sticks_out(
    model: pin.Model, visuals: pin.GeometryModel
) -> None:
    """Loops closed by psp3, shapes placed by Pinocchio.

    The arm's axis meets the ball's center (1e-7 m: six decimals in the file).
    """
    for heights in POSES:
        placements = placed(model, visuals, heights)
        for leg in (1, 2, 3):
            ball = next(
                s
                for s in shapes_of(model, visuals, f"lambda{leg}")
                if isinstance(s.geometry, coal.Sphere)
            )
            arm = max(
                (
                    s
                    for s in shapes_of(model, visuals, f"b{leg}")
                    if isinstance(s.geometry, coal.Cylinder)
                ),
                key=lambda s: s.geometry.halfLength,
            )
            in_arm = placements[arm.name].actInv(placements[ball.name]).translation
            np.testing.assert_allclose(in_arm[:2], 0.0, atol=1e-7)
            assert abs(in_arm[2]) + ball.geometry.radius < arm.geometry.halfLength


@pytest.mark.slow
def test_arms_and_columns_stay_clear_of_each_other(
    model: pin.Model, visuals: pin.GeometryModel
) -> None:
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    for heights in POSES:
        placements = placed(model, visuals, heights)
        for leg in (1, 2, 3):
            for arm in shapes_of(model, visuals, f"b{leg}"):
                for column in columns(visuals):
                    ends = []
                    for shape in (arm, column):
                        ends += [
                            shape.geometry,
                            coal.Transform3s(
                                placements[shape.name].rotation, placements[shape.name].translation
                            ),
                        ]
                    assert coal.distance(*ends, request, result) > 0.003


def test_reference_poses_close_the_loops(model: pin.Model) -> None:
    """To 1e-12 m and rad, with frames placed by Pinocchio."""
    pin.loadReferenceConfigurations(model, str(FILES / "psp3.srdf"))
    poses = {entry.key(): entry.data() for entry in model.referenceConfigurations}
    assert set(poses) == {"home", "tilted", "low", "high"}
    data = model.createData()
    for q in poses.values():
        pin.framesForwardKinematics(model, data, q)
        first, *others = (data.oMf[model.getFrameId(f"star{leg}_center")] for leg in (1, 2, 3))
        for other in others:
            np.testing.assert_allclose(pin.log6(first.actInv(other)).vector, 0.0, atol=1e-12)
        assert (model.lowerPositionLimit <= q).all()
        assert (q <= model.upperPositionLimit).all()
    np.testing.assert_array_equal(poses["home"], [0.0, 0.0, 0.0, 0.0, 0.181] * 3)
    pin.framesForwardKinematics(model, data, poses["tilted"])
    axis = data.oMf[model.getFrameId("tip")].rotation[:, 2]
    assert np.degrees(np.arccos(axis[2])) == pytest.approx(25.0, abs=1e-9)
    assert np.degrees(np.arctan2(axis[1], axis[0])) == pytest.approx(30.0, abs=1e-9)


def test_reference_poses_name_every_joint() -> None:
    root = ElementTree.parse(FILES / "psp3.srdf").getroot()
    for state in root.findall("group_state"):
        assert [joint.get("name") for joint in state] == JOINTS


def test_the_recipe_of_the_readme_closes_the_loops(monkeypatch: pytest.MonkeyPatch) -> None:
    """Newton's method of the README and the closed form agree to 1e-12 m and rad."""
    (recipe,) = re.findall(
        r"```python\n(.*?)```", (FILES / "README.md").read_text(encoding="utf-8"), flags=re.DOTALL
    )
    monkeypatch.chdir(FILES)
    names: dict[str, object] = {}
    exec(compile(recipe, "urdf/README.md", "exec"), names)
    np.testing.assert_allclose(
        names["q"], psp3.load().configuration([0.05, 0.0, -0.02]), atol=1e-12
    )
