"""The workspace.

Every quantity against Newton closure and finite differences, every border against a search by brute
force.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

import psp3
from psp3.errors import InvalidArray, InvalidValue, UnreachablePose, UnreachableTip
from psp3.kinematics.singularities import SingularityAnalysis
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from psp3.three_psp import workspace
from psp3.three_psp.workspace import WorkspaceMap

Array = NDArray[np.float64]

ROBOT = psp3.load("psp3")

d, h = ROBOT.parameters.screw_radius, ROBOT.parameters.tool_length

HEIGHTS = np.random.default_rng(0).uniform(-0.15, 0.15, size=(20, 3))

AROUND = np.radians(np.arange(-180.0, 180.0, 15.0))


@pytest.fixture(scope="module")
def newton() -> ClosedLoopRobot:
    """Close the loops with Newton's method, which knows nothing of the closed form."""
    robot = ROBOT.dynamics("core")
    assert type(robot) is ClosedLoopRobot
    return robot


@pytest.fixture(scope="module")
def here() -> WorkspaceMap:
    return workspace.map_at_heights(ROBOT, HEIGHTS)


def frames(robot: ClosedLoopRobot, heights: Array) -> tuple[pin.SE3, Array, Array]:
    """Return the star, the tip and the three nuts by Pinocchio's forward kinematics."""
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.configuration(heights))
    star = data.oMf[robot.model.getFrameId("star1_center")]
    tip = data.oMf[robot.model.getFrameId("tip")].translation.copy()
    nuts = np.array([data.oMi[robot.model.getJointId(f"a{leg}")].translation for leg in (1, 2, 3)])
    return star, tip, nuts


def horizontal_tip(tilt: float, azimuth: float, robot: psp3.PSP3 = ROBOT) -> Array:
    return robot.forward_kinematics(robot.inverse_kinematics(0.0, tilt, azimuth)).tip[:2]


def spanned(tilt: float, azimuth: float, robot: psp3.PSP3 = ROBOT) -> float:
    """Signed area that the tip sweeps for unit steps in tilt and azimuth.

    By central differences.
    """
    step = 1e-5
    along, across = (
        (
            horizontal_tip(tilt + a, azimuth + b, robot)
            - horizontal_tip(tilt - a, azimuth - b, robot)
        )
        / (2.0 * step)
        for a, b in ((step, 0.0), (0.0, step))
    )
    return float(along[0] * across[1] - along[1] * across[0])


def test_poses_agree_with_newton_closure(newton: ClosedLoopRobot, here: WorkspaceMap) -> None:
    """Newton stops at 1e-12 m, rad; its errors reach the pose amplified by less than ten.

    Angles lose what tilting divides by.
    """
    for k, heights in enumerate(HEIGHTS):
        star, tip, nuts = frames(newton, heights)
        axis = star.rotation[:, 2]
        np.testing.assert_allclose(here.center[k], star.translation, atol=1e-11)
        np.testing.assert_allclose(here.tip[k], tip, atol=1e-11)
        np.testing.assert_allclose(
            here.arms[k], np.linalg.norm(nuts - star.translation, axis=-1), atol=1e-11
        )
        np.testing.assert_allclose(
            here.parasitic_motion[k], np.linalg.norm(star.translation[:2]), atol=1e-11
        )
        np.testing.assert_allclose(np.cos(here.tilt[k]), axis[2], atol=1e-11)
        np.testing.assert_allclose(
            np.tan(here.tilt[k]) * np.exp(1j * here.azimuth[k]),
            (axis[0] + 1j * axis[1]) / axis[2],
            atol=1e-10,
        )


def test_conditions_agree_with_finite_differences_and_the_projected_tree(
    newton: ClosedLoopRobot, here: WorkspaceMap
) -> None:
    """Differences over 1e-5 m are good to 1e-9; a condition number multiplies that by itself.

    M comes from CRBA of the tree.
    """
    step = 1e-5
    for k, heights in enumerate(HEIGHTS[:8]):
        columns = [
            frames(newton, heights + step * e)[1] - frames(newton, heights - step * e)[1]
            for e in np.eye(3)
        ]
        singular = np.linalg.svd(np.stack(columns, axis=-1) / (2.0 * step), compute_uv=False)
        np.testing.assert_allclose(here.tip_condition[k], singular[0] / singular[-1], rtol=1e-6)
        eigenvalues = np.linalg.eigvalsh(newton.mass_matrix(heights))
        np.testing.assert_allclose(
            here.mass_condition[k], eigenvalues[-1] / eigenvalues[0], rtol=1e-9
        )


def test_actuation_determinant_is_that_of_the_wrenches_on_the_star(
    newton: ClosedLoopRobot, here: WorkspaceMap
) -> None:
    """The joint of an arm can push the star across the arm and along the normal.

    Not along the arm, where the slider gives way.
    """
    for k, heights in enumerate(HEIGHTS):
        star, _, nuts = frames(newton, heights)
        normal, wrenches = star.rotation[:, 2], []
        for nut in nuts:
            lever = nut - star.translation
            along = lever / np.linalg.norm(lever)
            wrenches += [
                np.concatenate([force, np.cross(lever, force)])
                for force in (np.cross(normal, along), normal)
            ]
        determinant = abs(np.linalg.det(np.array(wrenches)))
        np.testing.assert_allclose(here.actuation_determinant[k], determinant, rtol=1e-9)
    assert (here.actuation_determinant > 0.0).all()


def test_there_is_no_actuation_singularity_up_to_the_border() -> None:
    """At home the determinant is 3/4 · 3d · 3d², and no tilt makes it smaller."""
    shares = np.linspace(0.0, 0.9999, 60)[:, np.newaxis]
    poses = workspace.map_over_tilt(ROBOT, shares * workspace.largest_tilt(AROUND), AROUND)
    np.testing.assert_allclose(poses.actuation_determinant.min(), 6.75 * d**3, rtol=1e-12)


def test_middle_hinges_stay_away_from_the_gimbal(newton: ClosedLoopRobot) -> None:
    """Their angles as Newton's method finds them, to 1e-11.

    Up to the border they are below the tilt, which is below 90°.
    """
    rng = np.random.default_rng(11)
    poses = workspace.map_over_tilt(
        ROBOT, rng.uniform(0.0, 1.0, 40), rng.uniform(-np.pi, np.pi, 40)
    )
    hinges = [
        newton.model.joints[newton.model.getJointId(f"theta{leg}")].idx_q for leg in (1, 2, 3)
    ]
    found = [np.abs(newton.configuration(heights)[hinges]).max() for heights in poses.heights]
    np.testing.assert_allclose(poses.hinge_angle, found, atol=1e-10)
    border = workspace.map_over_tilt(ROBOT, 0.9999 * workspace.largest_tilt(AROUND), AROUND)
    assert (border.hinge_angle <= border.tilt + 1e-12).all()
    assert border.hinge_angle.max() < 0.5 * np.pi


def test_condition_of_the_closures_is_that_of_other_routes(here: WorkspaceMap) -> None:
    """The natural orthogonal complement's own Jacobian.

    And the generic analysis with a meter for a length; 13.7 at home.
    """
    noc, generic = (
        psp3.NaturalOrthogonalComplement(ROBOT),
        SingularityAnalysis(ROBOT, "tip", ("x", "y", "z"), length=1.0),
    )
    q = ROBOT.configuration(HEIGHTS)
    np.testing.assert_allclose(
        here.closure_condition,
        np.linalg.cond(noc.constraint_jacobian(q)[..., ROBOT.dependent_v]),
        rtol=1e-10,
    )
    np.testing.assert_allclose(
        here.closure_condition, generic.measures(q).closure_condition, rtol=1e-10
    )
    assert workspace.map_at_heights(ROBOT, np.zeros(3)).closure_condition == pytest.approx(
        13.7, abs=0.05
    )


def test_generic_measures_of_the_tip_are_those_of_the_closed_form(here: WorkspaceMap) -> None:
    """Condition and orientation of the tip's Jacobian by null spaces of the closures.

    The generic route to the same map, to 1e-9.
    """
    measures = SingularityAnalysis(ROBOT, "tip", ("x", "y", "z")).measures(
        ROBOT.configuration(HEIGHTS)
    )
    np.testing.assert_allclose(measures.condition, here.tip_condition, rtol=1e-9)
    determinant = np.linalg.det(ROBOT.tip_jacobian(HEIGHTS))
    np.testing.assert_array_equal(
        measures.orientation * np.sign(determinant),
        measures.orientation[0] * np.sign(determinant[0]),
    )
    np.testing.assert_array_equal(measures.assembly, measures.assembly[0])


def test_a_map_without_any_pose_is_empty() -> None:
    """A tilt of 89° toward 45°, where an arm vanishes before."""
    poses = workspace.map_over_tilt(ROBOT, [np.radians(89.0)], np.radians(45.0))
    assert np.isnan([poses.hinge_angle, poses.closure_condition, poses.travel]).all()


def test_travel_is_what_the_spread_of_the_heights_leaves_of_the_stroke(here: WorkspaceMap) -> None:
    """The stroke is 0.8 m on every screw.

    Lifting changes nothing; a nut at each end leaves nothing.
    """
    np.testing.assert_allclose(here.travel, 0.8 - np.ptp(HEIGHTS, axis=-1), atol=1e-15)
    np.testing.assert_allclose(
        workspace.map_at_heights(ROBOT, HEIGHTS + 0.1).travel, here.travel, atol=1e-15
    )
    assert workspace.map_at_heights(ROBOT, [0.5, 0.5, -0.4]).travel < 0.0


def test_parasitic_motion_follows_the_closed_form_of_tilt_and_azimuth() -> None:
    """Center x + iy = d sin²θ/(4 cos θ) [τ² e^{4iφ} − e^{−2iφ}], with τ = tan(θ/2).

    Rounding only.
    """
    tilt = np.radians(np.linspace(0.0, 60.0, 13))[:, np.newaxis]
    poses = workspace.map_over_tilt(ROBOT, tilt, AROUND)
    expected = d * np.sin(tilt) ** 2 / (4.0 * np.cos(tilt))
    expected = expected * (np.tan(0.5 * tilt) ** 2 * np.exp(4j * AROUND) - np.exp(-2j * AROUND))
    np.testing.assert_allclose(
        poses.center[..., 0] + 1j * poses.center[..., 1], expected, atol=1e-15
    )
    np.testing.assert_allclose(poses.parasitic_motion, np.abs(expected), atol=1e-15)
    np.testing.assert_allclose(poses.center[..., 2], 0.0, atol=1e-15)


def test_tilt_and_azimuth_are_those_that_were_asked_for() -> None:
    """Rounding, which the azimuth sees divided by the tilt, 0.01 at least."""
    rng = np.random.default_rng(3)
    tilt, azimuth = rng.uniform(0.01, 1.2, 200), rng.uniform(-np.pi, np.pi, 200)
    rotation = ROBOT.forward_kinematics(ROBOT.inverse_kinematics(0.0, tilt, azimuth)).rotation
    found = workspace.tilt_and_azimuth(rotation)
    np.testing.assert_allclose(found[0], tilt, atol=1e-13)
    np.testing.assert_allclose(found[1], azimuth, atol=1e-12)
    level = np.eye(3)
    level[:2, 2] = -0.0
    np.testing.assert_array_equal(workspace.tilt_and_azimuth(level), 0.0)


@given(tilt=st.floats(0.05, 1.2), azimuth=st.floats(-np.pi, np.pi), turn=st.sampled_from([1, 2]))
def test_turning_by_a_third_shifts_the_arms_and_changes_no_cost(
    tilt: float, azimuth: float, turn: int
) -> None:
    """120° symmetry, to 1e-7 of conditions.

    Except beside the fold, where conditions are their own amplification.
    """
    angle = 2.0 * np.pi * turn / 3.0
    one = workspace.map_over_tilt(ROBOT, tilt, azimuth)
    other = workspace.map_over_tilt(ROBOT, tilt, azimuth + angle)
    np.testing.assert_allclose(other.arms, np.roll(one.arms, turn), rtol=1e-9)
    np.testing.assert_allclose(other.parasitic_motion, one.parasitic_motion, rtol=1e-9)
    np.testing.assert_allclose(other.mass_condition, one.mass_condition, rtol=1e-9)
    np.testing.assert_allclose(
        1.0 / other.tip_condition, 1.0 / one.tip_condition, rtol=1e-7, atol=1e-9
    )
    turned = np.exp(1j * angle) * (one.tip[0] + 1j * one.tip[1])
    np.testing.assert_allclose(other.tip[0] + 1j * other.tip[1], turned, atol=1e-12)


def test_largest_tilt_is_where_inverse_kinematics_begins_to_refuse() -> None:
    """Bisection on the refusal, to 1e-12 rad; the least is arccos(1/3), 70.53°.

    Every 30° from 0° an arm lasts up to 90°.
    """

    def refused(tilt: float, azimuth: float) -> bool:
        try:
            ROBOT.inverse_kinematics(0.0, tilt, azimuth)
        except UnreachablePose:
            return True
        return False

    azimuths = np.append(np.random.default_rng(2).uniform(-np.pi, np.pi, 10), np.pi / 6.0)
    for azimuth, found in zip(azimuths, workspace.largest_tilt(azimuths), strict=True):
        low, high = 0.0, 0.5 * np.pi - 1e-9
        while high - low > 1e-12:
            middle = 0.5 * (low + high)
            low, high = (low, middle) if refused(middle, azimuth) else (middle, high)
        np.testing.assert_allclose(found, low, atol=1e-9)
    assert workspace.largest_tilt(np.linspace(-np.pi, np.pi, 721)).min() == pytest.approx(
        np.arccos(1.0 / 3.0), abs=1e-14
    )
    np.testing.assert_allclose(
        workspace.largest_tilt(np.radians([0.0, 60.0, 120.0, 180.0])), 0.5 * np.pi, atol=1e-7
    )


@pytest.mark.parametrize("tool_length", [0.01, 0.07, 0.12])
def test_fold_is_the_first_tilt_at_which_the_swept_area_vanishes(tool_length: float) -> None:
    """Walk outward until the area changes its sign.

    The differences are good to 1e-9 of the area, so 1e-7 rad in its root.
    """
    robot = psp3.load("psp3", parameters=psp3.Parameters(tool_length=tool_length))
    azimuths = np.append(
        np.random.default_rng(1).uniform(-np.pi, np.pi, 5), [0.0, np.pi / 6.0, np.pi]
    )
    for azimuth, found in zip(azimuths, workspace.fold_tilt(robot, azimuths), strict=True):
        low = high = 0.005
        while spanned(high, azimuth, robot) > 0.0:
            low, high = high, high + 0.005
        while high - low > 1e-10:
            middle = 0.5 * (low + high)
            low, high = (middle, high) if spanned(middle, azimuth, robot) > 0.0 else (low, middle)
        np.testing.assert_allclose(found, low, atol=1e-7)


def test_tip_of_the_thesis_folds_at_33_to_38_degrees_and_that_of_a_long_tool_not_everywhere() -> (
    None
):
    fold = np.degrees(workspace.fold_tilt(ROBOT, AROUND))
    assert 33.0 < fold.min() < 34.0
    assert 37.0 < fold.max() < 38.0
    crane = psp3.load("psp3", parameters=psp3.Parameters(tool_length=2.0))
    np.testing.assert_allclose(
        workspace.fold_tilt(crane, np.pi / 6.0), workspace.largest_tilt(np.pi / 6.0), rtol=1e-8
    )


def test_reach_boundary_is_where_inverse_kinematics_ends() -> None:
    """At 23.9 mm in closed form.

    Elsewhere as found by complex arithmetic, and by asking for tips on both sides of the border.
    """
    border = workspace.reach_boundary(ROBOT, AROUND)
    radius, azimuth = np.hypot(*border.T), np.arctan2(border[:, 1], border[:, 0])
    np.testing.assert_allclose(radius.min(), np.sqrt(h**2 + d**2 / 4.0) - d / 2.0, rtol=1e-14)
    assert 1e3 * radius.min() == pytest.approx(23.9, abs=0.05)
    np.testing.assert_allclose(radius, ROBOT.tip_reach(azimuth), rtol=1e-12)
    for x, y in border:
        ROBOT.inverse_kinematics_tip([0.999 * x, 0.999 * y, 0.1])
        with pytest.raises(UnreachableTip):
            ROBOT.inverse_kinematics_tip([1.001 * x, 1.001 * y, 0.1])


def test_map_over_tilt_is_empty_exactly_where_inverse_kinematics_refuses() -> None:
    tilt, azimuth = (
        np.radians(np.linspace(0.0, 89.0, 24))[:, np.newaxis],
        np.radians(np.linspace(-180.0, 180.0, 25)),
    )
    poses = workspace.map_over_tilt(ROBOT, tilt, azimuth)
    empty = 0
    for index in np.ndindex(24, 25):
        asked = float(tilt[index[0], 0]), float(azimuth[index[1]])
        np.testing.assert_array_equal([poses.tilt[index], poses.azimuth[index]], asked)
        values = [
            getattr(poses, name)[index]
            for name in ("heights", "center", "arms", "tip", "parasitic_motion", "travel")
        ]
        try:
            heights = ROBOT.inverse_kinematics(0.0, *asked)
        except UnreachablePose:
            empty += 1
            assert all(np.isnan(value).all() for value in values)
        else:
            np.testing.assert_array_equal(poses.heights[index], heights)
            assert all(np.isfinite(value).all() for value in values)
    assert 0 < empty < 24 * 25 / 3


def test_map_over_reach_holds_the_poses_of_the_tip_on_the_branch_of_home() -> None:
    """Inverse kinematics of the tip leads back to the heights.

    The condition, below 100 up to a share of 0.97, amplifies rounding.
    """
    poses = workspace.map_over_reach(ROBOT, np.linspace(0.0, 0.97, 12)[:, np.newaxis], AROUND)
    np.testing.assert_allclose(ROBOT.inverse_kinematics_tip(poses.tip), poses.heights, atol=1e-12)
    np.testing.assert_allclose(poses.heights[0], 0.0, atol=1e-15)
    rim = workspace.map_over_reach(ROBOT, 1.0, AROUND)
    np.testing.assert_allclose(rim.tip[:, :2], workspace.reach_boundary(ROBOT, AROUND), atol=1e-12)
    assert (rim.tip_condition > 1e7).all()


@pytest.mark.parametrize("shape", [(), (4,), (2, 3)])
def test_maps_keep_leading_dimensions(shape: tuple[int, ...]) -> None:
    for poses in (
        workspace.map_at_heights(ROBOT, np.zeros((*shape, 3))),
        workspace.map_over_tilt(ROBOT, np.full(shape, 0.3), 0.0),
        workspace.map_over_reach(ROBOT, 0.5, np.full(shape, 0.3)),
    ):
        numbers = (
            "tilt",
            "tip_condition",
            "travel",
            "actuation_determinant",
            "hinge_angle",
            "closure_condition",
        )
        assert {getattr(poses, name).shape for name in numbers} == {shape}
        assert {poses.heights.shape, poses.arms.shape, poses.tip.shape, poses.center.shape} == {
            (*shape, 3)
        }


@pytest.mark.parametrize(
    ("call", "error", "value"),
    [
        (lambda: workspace.map_at_heights(ROBOT, [np.nan, 0.0, 0.0]), InvalidArray, "nan"),
        (lambda: workspace.map_at_heights(ROBOT, [-0.6, 0.0, 0.6]), UnreachablePose, "0.6"),
        (lambda: workspace.map_over_tilt(ROBOT, -0.1, 0.0), InvalidValue, "-0.1"),
        (lambda: workspace.map_over_tilt(ROBOT, 0.5 * np.pi, 0.0), InvalidValue, "1.57"),
        (lambda: workspace.map_over_tilt(ROBOT, np.inf, 0.0), InvalidArray, "inf"),
        (
            lambda: workspace.map_over_tilt(ROBOT, np.zeros(3), np.zeros(4)),
            InvalidArray,
            "tilt and azimuth",
        ),
        (lambda: workspace.map_over_reach(ROBOT, 1.2, 0.0), InvalidValue, "1.2"),
        (lambda: workspace.map_over_reach(ROBOT, -0.2, 0.0), InvalidValue, "-0.2"),
        (lambda: workspace.fold_tilt(ROBOT, np.nan), InvalidArray, "azimuth"),
        (lambda: workspace.largest_tilt("north"), InvalidArray, "north"),
        (lambda: workspace.reach_boundary(ROBOT, [0.0, np.inf]), InvalidArray, "inf"),
    ],
)
def test_bad_input_is_refused_by_name_and_value(
    call: object, error: type[Exception], value: str
) -> None:
    with pytest.raises(error, match=value):
        call()  # type: ignore[operator]
