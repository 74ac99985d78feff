"""Singularities.

Measures against closed-form Jacobians and the complement L, kinds against poses that geometry says
are singular.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.linalg import eigh
from scipy.optimize import brentq

import psp3
from psp3.errors import InvalidArray, InvalidValue, OpenLoops, UnknownName
from psp3.kinematics.singularities import SingularityAnalysis
from psp3.kinematics.task_driven import TaskDrivenRobot
from psp3.kinematics.tasks import TASK_COORDINATES
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from psp3.three_psp.workspace import fold_tilt, largest_tilt
from tests.closed_form_kinematics import (
    Delta,
    FiveBar,
    GoughStewart,
    PlanarThreeRRR,
    Tricept,
    around,
    rotation_xyz,
)
from tests.helpers import ROBOTS_WITH_LIE_GROUPS, ROBOTS_WITH_LOOPS, Array
from tests.psp3.kinematics.robots import TASKS, built, scales
from tests.robot_samplers import reachable


def gough_stewart_jacobian(poses: Array) -> Array:
    return np.linalg.inv(GoughStewart().rates(poses[:, :3], rotation_xyz(poses[:, 3:])))


JACOBIANS: dict[str, Callable[[Array, Array], Array]] = {
    "five_bar": lambda poses, positions: FiveBar().jacobian(positions),
    "planar_3rrr": lambda poses, positions: PlanarThreeRRR().jacobian(poses),
    "delta": lambda poses, positions: Delta().jacobian(positions),
    "gough_stewart": lambda poses, positions: gough_stewart_jacobian(poses),
    "tricept": lambda poses, positions: Tricept().jacobian(poses),
}


@pytest.fixture(scope="module")
def analyses(robots: dict[str, ClosedLoopRobot]) -> dict[str, SingularityAnalysis]:
    return {name: SingularityAnalysis(robot, "tip", TASKS[name]) for name, robot in robots.items()}


# Measures


@pytest.mark.parametrize("name", TASKS)
def test_jacobian_measures_are_those_of_the_closed_form(
    name: str, analyses: dict[str, SingularityAnalysis]
) -> None:
    """Condition and volume of the textbook's Jacobian, made homogeneous.

    1e-8: Newton's 1e-13 divided by the sampler's least hold.

    The sign of its determinant, up to one sign for the whole robot, is the orientation.
    """
    analysis, sample = analyses[name], reachable(name, 60, np.random.default_rng(3))
    robot = analysis.robot
    rows = np.array(
        [analysis.length if coordinate.startswith("r") else 1.0 for coordinate in TASKS[name]]
    )
    columns = scales(robot, analysis.length)[robot.actuated_v]
    jacobian = rows[:, np.newaxis] * JACOBIANS[name](sample.poses, sample.positions) / columns
    measures = analysis.measures(robot.configuration(sample.positions))
    values = np.linalg.svd(jacobian, compute_uv=False)
    assert_allclose(measures.condition, values[:, 0] / values[:, -1], rtol=1e-8)
    assert_allclose(
        measures.manipulability,
        np.sqrt(np.linalg.det(jacobian @ np.swapaxes(jacobian, 1, 2))),
        rtol=1e-8,
    )
    same = measures.orientation * np.sign(np.linalg.det(jacobian))
    assert set(measures.orientation) <= {-1.0, 1.0}
    assert_array_equal(same, same[0])
    assert_array_equal(measures.mobility, len(robot.actuated))


@pytest.mark.parametrize(
    "parts",
    [*ROBOTS_WITH_LOOPS, *ROBOTS_WITH_LIE_GROUPS, *TASKS],
    ids=lambda parts: getattr(parts, "__name__", parts),
)
def test_measures_follow_from_the_complement(
    parts: Any, robots: dict[str, ClosedLoopRobot]
) -> None:
    """Independent route: L of the closure and J of the frame, not null spaces.

    The joints move by at most |L| for a unit of the motors, so actuation is 1/|L|; the least motion
    of the frame for a unit of the joints is the root of the least eigenvalue of the pencil (JᵀJ,
    LᵀL). 1e-8, because roots halve the digits of an eigenvalue.
    """
    robot = robots[parts] if isinstance(parts, str) else built(parts())
    frame, task = (
        ("tip", TASKS[parts])
        if isinstance(parts, str)
        else (robot.model.names[2], TASK_COORDINATES)
    )
    if not robot.model.existFrame(frame):
        robot.model.addFrame(pin.Frame(frame, 2, 0, pin.SE3.Identity(), pin.FrameType.OP_FRAME))
        robot = ClosedLoopRobot(robot.model, robot.constraint_models, robot.actuated, robot.q0)
    analysis = SingularityAnalysis(robot, frame, task, length=0.3)
    scale = scales(robot, 0.3)
    rng = np.random.default_rng(5)
    for _ in range(5):
        positions = robot.reference + rng.uniform(-0.03, 0.03, len(robot.actuated))
        closure = robot.closure(positions)
        motions = scale[:, np.newaxis] * closure.complement / scale[robot.actuated_v]
        rows = [TASK_COORDINATES.index(name) for name in task]
        jacobian = robot.frame_jacobian(positions, frame)[rows] / scale[robot.actuated_v]
        jacobian *= np.array([0.3 if row >= 3 else 1.0 for row in rows])[:, np.newaxis]
        measures = analysis.measures(closure.configuration)
        assert_allclose(measures.actuation, 1.0 / np.linalg.norm(motions, 2), rtol=1e-9)
        if len(task) >= len(robot.actuated):
            least = eigh(jacobian.T @ jacobian, motions.T @ motions, eigvals_only=True)[0]
            assert_allclose(measures.end_effector, np.sqrt(max(least, 0.0)), rtol=1e-8, atol=1e-8)
        constraint = (
            robot.constraint_jacobian(closure.configuration)[:, robot.dependent_v]
            / scale[robot.dependent_v]
        )
        values = np.linalg.svd(
            constraint * closure_rows(robot, 0.3)[:, np.newaxis], compute_uv=False
        )
        assert_allclose(
            measures.closure_condition, values[0] / values[robot.dependent_v.size - 1], rtol=1e-9
        )


def closure_rows(robot: ClosedLoopRobot, length: float) -> Array:
    """Scales of the rows of Pinocchio's constraint Jacobian."""
    rows: list[float] = []
    for constraint in robot.constraint_models:
        rows += [1.0] * 3 + ([length] * 3 if constraint.type == pin.ContactType.CONTACT_6D else [])
    return np.array(rows)


def test_measures_do_not_depend_on_how_the_closures_are_written(
    robots: dict[str, ClosedLoopRobot],
) -> None:
    """A closure's frames the other way round, and turned.

    Another constraint Jacobian of the same mechanism. Rounding only.
    """
    robot = robots["gough_stewart"]
    turned, closures = pin.SE3(pin.utils.rpyToMatrix(0.3, -1.0, 2.0), np.zeros(3)), []
    for one in robot.constraint_models:
        sides = (
            (one.joint2_id, one.joint2_placement * turned),
            (one.joint1_id, one.joint1_placement * turned),
        )
        closures.append(
            pin.RigidConstraintModel(
                one.type, robot.model, *sides[0], *sides[1], pin.ReferenceFrame.LOCAL
            )
        )
    other = ClosedLoopRobot(robot.model, closures, robot.actuated, robot.q0)
    q = robot.configuration(
        robot.reference + np.random.default_rng(1).uniform(-0.05, 0.05, size=(10, 6))
    )
    one, two = (
        SingularityAnalysis(each, "tip", TASK_COORDINATES).measures(q) for each in (robot, other)
    )
    # The sign of the closures' own determinant is theirs, but it is the same one everywhere.
    assert_array_equal(one.assembly * two.assembly, one.assembly[0] * two.assembly[0])
    for name in ("actuation", "end_effector", "condition", "manipulability", "orientation"):
        assert_allclose(getattr(one, name), getattr(two, name), rtol=1e-11)


def planar_five_bar(size: float) -> ClosedLoopRobot:
    """Return a five-bar linkage in the plane z = 0.

    Shafts 0.3 apart, cranks 0.2, rods 0.35, times a size; with a frame ``point``.
    """
    model = pin.Model()
    ends = []
    for x, crank, elbow in ((-0.15, 2.2, -1.6), (0.15, 0.9, 1.6)):
        first = model.addJoint(
            0,
            pin.JointModelRZ(),
            pin.SE3(np.eye(3), size * np.array([x, 0.0, 0.0])),
            f"crank{len(ends)}",
        )
        second = model.addJoint(
            first,
            pin.JointModelRZ(),
            pin.SE3(np.eye(3), size * np.array([0.2, 0.0, 0.0])),
            f"rod{len(ends)}",
        )
        ends.append((second, pin.SE3(np.eye(3), size * np.array([0.35, 0.0, 0.0])), crank, elbow))
    model.addFrame(pin.Frame("point", ends[0][0], 0, ends[0][1], pin.FrameType.OP_FRAME))
    closure = pin.RigidConstraintModel(
        pin.ContactType.CONTACT_3D, model, *ends[0][:2], *ends[1][:2], pin.ReferenceFrame.LOCAL
    )
    q0 = np.array([angle for end in ends for angle in end[2:]])
    # Nearly closed: the class does the rest.
    return ClosedLoopRobot(model, [closure], ("crank0", "crank1"), q0)


def test_measures_do_not_depend_on_the_size_of_the_robot() -> None:
    """All lengths ten times as large, the characteristic length among them: the same numbers.

    Rounding only.
    """
    small, large = planar_five_bar(0.1), planar_five_bar(1.0)
    one, two = (SingularityAnalysis(robot, "point", ("x", "y")) for robot in (small, large))
    assert_allclose(two.length, 10.0 * one.length, rtol=1e-9)
    positions = large.reference + np.random.default_rng(0).uniform(-0.2, 0.2, size=(20, 2))
    for a, b in zip(
        one.measures(small.configuration(positions)),
        two.measures(large.configuration(positions)),
        strict=True,
    ):
        assert_allclose(a, b, rtol=1e-9)


def arm() -> ClosedLoopRobot:
    """Two links in the plane, 0.5 m and 0.3 m, without loops, with a frame ``hand``."""
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
    return ClosedLoopRobot(model, [], ("shoulder", "elbow"))


def test_arm_without_loops() -> None:
    """Yoshikawa's example: the manipulability of two links is l1 l2 |sin q2|.

    No singularity of actuation without loops.
    """
    analysis = SingularityAnalysis(arm(), "hand", ("x", "y"), length=0.4)
    q = np.random.default_rng(2).uniform(-3.0, 3.0, size=(2, 15, 2))
    measures = analysis.measures(q)
    assert_allclose(measures.manipulability, 0.15 * np.abs(np.sin(q[..., 1])) / 0.4**2, rtol=1e-12)
    assert_array_equal(measures.orientation, np.sign(np.sin(q[..., 1])))
    assert_array_equal(measures.actuation, 1.0)
    assert_array_equal(measures.constraint, 1.0)
    assert analysis.classify([0.7, 0.0]).kinds == ("end_effector",)
    assert analysis.classify([0.7, 0.1]).kinds == ()


def test_arm_that_only_has_to_point_is_redundant_but_not_singular() -> None:
    """One coordinate, two motors: something always moves without it, and that is no singularity.

    Stretched along x it is one in x.
    """
    analysis = SingularityAnalysis(arm(), "hand", ("x",), length=0.4)
    found = analysis.classify([0.7, 0.3])
    assert found.kinds == ()
    assert found.still.shape == (1, 2)
    jacobian = -np.array([0.5 * np.sin(0.7) + 0.3 * np.sin(1.0), 0.3 * np.sin(1.0)])
    assert_allclose(found.still @ jacobian, 0.0, atol=1e-15)
    assert analysis.classify([0.0, 0.0]).kinds == ("end_effector",)
    assert analysis.measures([0.7, 0.3]).orientation == 0.0


def test_arm_with_more_coordinates_than_motors_is_singular_only_where_a_motor_is_lost() -> None:
    """Position and angle of the hand, with two motors: the rank cannot be three.

    Both motors move the hand in every pose, since the angle is the sum of theirs and the elbow
    moves the hand; with position alone the stretched arm is singular.
    """
    whole = SingularityAnalysis(arm(), "hand", ("x", "y", "rz"), length=0.4)
    assert whole.classify([0.7, 0.3]).kinds == ()
    assert whole.classify([0.7, 0.0]).kinds == ()
    assert whole.classify([0.7, 0.3]).still.shape == (0, 2)
    alone = SingularityAnalysis(arm(), "hand", ("x", "y"), length=0.4)
    assert alone.classify([0.7, 0.0]).kinds == ("end_effector",)
    one = SingularityAnalysis(arm(), "hand", ("rz",), length=0.4)
    assert one.classify([0.7, 0.0]).kinds == ()


# Singular poses that geometry knows


def five_bar_configuration(
    robot: ClosedLoopRobot, first: float, second: float, tip: Array
) -> Array:
    """Angles of cranks and rods of legs 1 and 2 by the directions of their links.

    A link that hangs has the angle 0.
    """
    elbows = FiveBar().elbows([first, second])
    rods = tip - elbows
    directions = np.arctan2(-rods[:, 0], -rods[:, 1])
    names = {
        "leg1_shoulder": first,
        "leg1_elbow": directions[0] - first,
        "leg2_shoulder": second,
        "leg2_elbow": directions[1] - second,
    }
    return configuration_of(robot, names)


def configuration_of(robot: ClosedLoopRobot, joints: dict[str, float]) -> Array:
    q = np.full(robot.model.nq, np.nan)
    for name, value in joints.items():
        q[robot.model.joints[robot.model.getJointId(name)].idx_q] = value
    assert np.isfinite(q).all()
    return q


def test_five_bar_whose_rods_are_in_line(
    robots: dict[str, ClosedLoopRobot], analyses: dict[str, SingularityAnalysis]
) -> None:
    """Then the point can move across the rods with both motors locked.

    In the middle, the cranks swung outward by arcsin 0.9.
    """
    robot, analysis = robots["five_bar"], analyses["five_bar"]
    swing = np.arcsin(0.9)
    first, second = FiveBar().outward * swing
    elbows = FiveBar().elbows([first, second])
    assert_allclose(np.linalg.norm(elbows[0] - elbows[1]), 2.0 * FiveBar().rod, rtol=1e-15)
    q = five_bar_configuration(robot, first, second, elbows.mean(axis=0))
    found, measures = analysis.classify(q, tolerance=1e-10), analysis.measures(q)
    assert found.kinds == ("actuation",)
    assert measures.actuation < 1e-12
    assert measures.condition == measures.manipulability == np.inf
    assert found.locked.shape == (1, 4)
    assert_allclose(found.locked[0, robot.actuated_v], 0.0, atol=1e-12)
    # The rods turn about their elbows with opposite speeds, which lifts the point.
    rods = robot.dependent_v
    assert_allclose(np.abs(found.locked[0, rods]), 1.0, rtol=1e-12)
    assert found.locked[0, rods].prod() < 0.0
    assert found.still.shape == (0, 4)


def test_five_bar_with_a_stretched_leg(
    robots: dict[str, ClosedLoopRobot], analyses: dict[str, SingularityAnalysis]
) -> None:
    """The point is on the border of its reach: no motion of the motors moves it along the leg.

    The other leg is bent.
    """
    robot, analysis = robots["five_bar"], analyses["five_bar"]
    first = 0.5
    reach = FiveBar().crank + FiveBar().rod
    along = -np.array([np.sin(first), np.cos(first)])
    tip = FiveBar().shafts[0] + reach * along
    second = float(FiveBar().inverse(tip)[1])
    q = five_bar_configuration(robot, first, second, tip)
    found, measures = analysis.classify(q, tolerance=1e-10), analysis.measures(q)
    assert found.kinds == ("end_effector",)
    assert measures.end_effector < 1e-12
    assert measures.manipulability < 1e-12
    # The point at rest, crank and rod of the stretched leg turn: ways of the point 0.48 θ' + 0.28
    # φ' = 0.
    assert found.still.shape == (1, 4)
    crank, rod = (
        robot.model.joints[robot.model.getJointId(f"leg1_{joint}")].idx_v
        for joint in ("shoulder", "elbow")
    )
    assert_allclose(found.still[0, crank] / found.still[0, rod], -FiveBar().rod / reach, rtol=1e-9)
    others = np.setdiff1d(np.arange(4), [crank, rod])
    assert_allclose(found.still[0, others], 0.0, atol=1e-12)


def test_five_bar_with_both_at_once(
    robots: dict[str, ClosedLoopRobot], analyses: dict[str, SingularityAnalysis]
) -> None:
    """Gosselin's third type.

    Cranks and base make an equilateral triangle, so the elbows coincide, and leg 1 is stretched.
    """
    first, second = -FiveBar().outward * np.pi / 6.0
    elbows = FiveBar().elbows([first, second])
    assert_allclose(elbows[0], elbows[1], atol=1e-15)
    tip = elbows[0] + FiveBar().rod / FiveBar().crank * (elbows[0] - FiveBar().shafts[0])
    q = five_bar_configuration(robots["five_bar"], first, second, tip)
    found = analyses["five_bar"].classify(q, tolerance=1e-10)
    assert found.kinds == ("actuation", "end_effector")
    assert found.locked.shape == found.still.shape == (1, 4)


def three_rrr_configuration(robot: ClosedLoopRobot, pose: Array) -> Array:
    """All joints by the directions of the links, from closed-form inverse kinematics."""
    geometry = PlanarThreeRRR()
    positions, home = geometry.inverse(pose), geometry.inverse(np.zeros(3))

    def rods(place: Array, angles: Array) -> Array:
        x, y = (geometry.placed_corners(place) - geometry.elbows(angles)).T
        return np.arctan2(y, x)

    turned = rods(pose, positions)
    names = {f"leg{leg}_shoulder": positions[leg - 1] for leg in (1, 2, 3)}
    cranks = positions + geometry.azimuths + np.pi
    for leg in (1, 2, 3):
        elbow = turned[leg - 1] - cranks[leg - 1]
        names[f"leg{leg}_elbow"] = np.mod(elbow + np.pi, 2.0 * np.pi) - np.pi
    names["leg1_wrist"] = pose[2] - (turned - rods(np.zeros(3), home))[0]
    return configuration_of(robot, names)


def test_three_rrr_whose_rods_meet_in_a_point(
    robots: dict[str, ClosedLoopRobot], analyses: dict[str, SingularityAnalysis]
) -> None:
    """Forces along lines through one point have no moment about it: the platform can turn there.

    Found by turning the platform off-center.

    The point is where the lines of two rods meet; the third passes it by less than 1e-12 m.
    """
    geometry, place = PlanarThreeRRR(), (0.02, -0.03)

    def determinant(angle: float) -> float:
        return float(np.linalg.det(geometry.rates(np.array([*place, angle]))[0]))

    angles = np.linspace(-1.2, 0.0, 49)
    values = np.array([determinant(angle) for angle in angles])
    crossing = np.flatnonzero(np.sign(values[:-1]) != np.sign(values[1:]))[0]
    angle = brentq(determinant, angles[crossing], angles[crossing + 1], xtol=1e-15)
    pose = np.array([*place, angle])
    elbows, corners = geometry.elbows(geometry.inverse(pose)), geometry.placed_corners(pose)
    rods = (corners - elbows) / geometry.rod
    share = np.linalg.solve(np.stack([rods[0], -rods[1]], axis=1), elbows[1] - elbows[0])[0]
    meeting = elbows[0] + share * rods[0]
    x, y = meeting - elbows[2]
    assert abs(x * rods[2, 1] - y * rods[2, 0]) < 1e-12
    analysis, robot = analyses["planar_3rrr"], robots["planar_3rrr"]
    found = analysis.classify(three_rrr_configuration(robot, pose), tolerance=1e-9)
    assert found.kinds == ("actuation",)
    # The free motion turns the platform about that point.
    q = three_rrr_configuration(robot, pose)
    pin.computeJointJacobians(robot.model, robot.data, q)
    pin.updateFramePlacements(robot.model, robot.data)
    twist = (
        pin.getFrameJacobian(
            robot.model,
            robot.data,
            robot.model.getFrameId("tip"),
            pin.ReferenceFrame.LOCAL_WORLD_ALIGNED,
        )
        @ found.locked[0]
    )
    pole = np.array(place) + np.array([-twist[1], twist[0]]) / twist[5]
    assert_allclose(pole, meeting, atol=1e-8)
    before, after = (
        analysis.measures(
            three_rrr_configuration(robot, np.array([*place, angle + step]))
        ).orientation
        for step in (-1e-4, 1e-4)
    )
    assert before == -after != 0.0


def test_signs_tell_what_is_crossed(
    robots: dict[str, ClosedLoopRobot], analyses: dict[str, SingularityAnalysis]
) -> None:
    """Closed-form poses on both sides.

    Rods of the five-bar in line, its leg stretched, and the Delta's platform free to turn.
    """

    def signs(analysis: SingularityAnalysis, *configurations: Array) -> tuple[bool, bool]:
        found = analysis.measures(np.array(configurations))
        assert_array_equal(np.abs(found.assembly), 1.0)
        return bool(found.orientation[0] != found.orientation[1]), bool(
            found.assembly[0] != found.assembly[1]
        )

    robot, geometry = robots["five_bar"], FiveBar()
    tips = np.array([[0.0, -0.08], [0.0, -0.1]])
    rods_in_line = [five_bar_configuration(robot, *geometry.inverse(tip), tip) for tip in tips]
    assert signs(analyses["five_bar"], *rods_in_line) == (True, True)
    tip = geometry.shafts[0] + 0.47 * np.array([-0.3, -np.sqrt(0.91)])
    outward, other = geometry.inverse(tip)
    inward = (
        2.0 * np.arctan2(-(tip - geometry.shafts[0])[0], -(tip - geometry.shafts[0])[1]) - outward
    )
    stretched = [five_bar_configuration(robot, first, other, tip) for first in (outward, inward)]
    assert signs(analyses["five_bar"], *stretched) == (True, False)
    home = Delta().forward(np.zeros(3))
    way = np.array([-0.165, 0.286, -0.126]) - home
    turning = [delta_configuration(robots["delta"], home + share * way) for share in (0.80, 0.82)]
    assert signs(analyses["delta"], *turning) == (False, True)


@pytest.mark.parametrize("height", [0.55, 0.7, 0.8])
def test_gough_stewart_platform_turned_by_90_degrees(
    height: float, robots: dict[str, ClosedLoopRobot]
) -> None:
    """Hexagons of the same kind, the upper one turned by a quarter.

    E. F. Fichter, A Stewart platform-based manipulator (1986).

    The configuration is one of the robot driven at its platform, which goes there and beyond.
    """
    robot = robots["gough_stewart"]
    rates = GoughStewart().rates(
        np.array([0.0, 0.0, height]), np.asarray(pin.utils.rotate("z", 0.5 * np.pi))
    )
    assert abs(np.linalg.det(rates)) < 1e-16
    driven = TaskDrivenRobot(robot, "tip", TASK_COORDINATES)
    path = [
        [0.0, 0.0, height, 0.0, 0.0, angle]
        for angle in (0.5, 1.0, 0.5 * np.pi - 1e-3, 0.5 * np.pi, 0.5 * np.pi + 1e-3)
    ]
    q = driven.configurations_along(path)[:, : robot.model.nq]
    analysis = SingularityAnalysis(robot, "tip", TASK_COORDINATES)
    measures = analysis.measures(q)
    assert measures.actuation[3] < 1e-12 < 1e-4 < measures.actuation[[2, 4]].min()
    assert measures.orientation[2] == -measures.orientation[4]
    found = analysis.classify(q[3], tolerance=1e-9)
    assert found.kinds == ("actuation",)
    assert_allclose(found.locked[:, robot.actuated_v], 0.0, atol=1e-9)


def delta_configuration(robot: ClosedLoopRobot, tip: Array) -> Array:
    """Return all joints from closed-form inverse kinematics.

    A rod is pitched about y, then swung about x, against an arm.
    """
    geometry = Delta()
    positions = geometry.inverse(tip)
    names: dict[str, float] = {"platform_z": 0.0}
    for leg, (azimuth, angle, rod) in enumerate(
        zip(geometry.azimuths, positions, tip - geometry.elbows(positions), strict=True), start=1
    ):
        outward, sideways, up = np.asarray(pin.utils.rotate("z", -azimuth)) @ rod / geometry.rod
        swing, pitch = np.arcsin(sideways), np.arctan2(-outward, -up)
        names[f"leg{leg}_shoulder"] = angle
        for number in (1, 2):
            names |= {
                f"leg{leg}_rod{number}_pitch": pitch - angle,
                f"leg{leg}_rod{number}_swing": swing,
            }
        if leg == 1:
            # The platform stays level.
            names |= {"platform_x": -swing, "platform_y": -pitch}
    return configuration_of(robot, names)


def delta_rods(tip: Array) -> Array:
    geometry = Delta()
    return (tip - geometry.elbows(geometry.inverse(tip))) / geometry.rod


def delta_normals(tip: Array) -> Array:
    """Return the normals of the three parallelograms.

    Moments about these are all that the rods can hold.
    """
    return np.cross(delta_rods(tip), around(Delta().azimuths + 0.5 * np.pi, 1.0))


def test_delta_whose_rods_lie_in_a_plane(robots: dict[str, ClosedLoopRobot]) -> None:
    """Nothing holds the platform across that plane.

    Its motion is one along the normal. Found by the volume of the three directions.
    """

    def tip_at(height: float) -> Array:
        return np.array([-0.165, 0.286, height])

    robot = robots["delta"]
    tip = tip_at(
        brentq(lambda height: np.linalg.det(delta_rods(tip_at(height))), -0.05, 0.1, xtol=1e-15)
    )
    found = SingularityAnalysis(robot, "tip", ("x", "y", "z")).classify(
        delta_configuration(robot, tip), tolerance=1e-9
    )
    assert found.kinds == ("actuation",)
    pin.computeJointJacobians(robot.model, robot.data, delta_configuration(robot, tip))
    pin.updateFramePlacements(robot.model, robot.data)
    frame = robot.model.getFrameId("tip")
    motion = (
        pin.getFrameJacobian(robot.model, robot.data, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        @ found.locked[0]
    )
    assert_allclose(delta_rods(tip) @ motion[:3] / np.linalg.norm(motion[:3]), 0.0, atol=1e-8)
    assert_allclose(motion[3:], 0.0, atol=1e-9)


def test_delta_whose_platform_can_turn(robots: dict[str, ClosedLoopRobot]) -> None:
    """Its constraint singularity.

    The normals of the parallelograms in one plane, and the platform turns about the normal of that.

    R. Di Gregorio, Determination of singularities in Delta-like manipulators, International Journal
    of Robotics Research 23 (2004). On the way outward, over leg 2, this comes before the rods lie
    in a plane.
    """
    geometry, robot = Delta(), robots["delta"]
    home = geometry.forward(np.zeros(3))
    way = np.array([-0.165, 0.286, -0.126]) - home
    share = brentq(
        lambda share: np.linalg.det(delta_normals(home + share * way)), 0.7, 0.9, xtol=1e-15
    )
    tip = home + share * way
    volumes = np.array(
        [np.linalg.det(delta_rods(home + s * way)) for s in np.linspace(0.0, share, 50)]
    )
    assert (volumes < -0.1).all()
    analysis, q = (
        SingularityAnalysis(robot, "tip", ("x", "y", "z")),
        delta_configuration(robot, tip),
    )
    found = analysis.classify(q, tolerance=1e-9)
    assert found.kinds == ("constraint", "actuation")
    pin.computeJointJacobians(robot.model, robot.data, q)
    pin.updateFramePlacements(robot.model, robot.data)
    frame = robot.model.getFrameId("tip")
    motion = (
        pin.getFrameJacobian(robot.model, robot.data, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        @ found.locked[0]
    )
    turn = motion[3:] / np.linalg.norm(motion[3:])
    assert_allclose(delta_normals(tip) @ turn, 0.0, atol=1e-8)
    # Turning takes the rods' ends along, so the platform moves, too; no rod becomes longer.
    ends = around(geometry.azimuths, geometry.platform)
    assert_allclose(
        (delta_rods(tip) * (motion[:3] + np.cross(motion[3:], ends))).sum(axis=1), 0.0, atol=1e-9
    )
    near = analysis.measures(
        np.array([delta_configuration(robot, home + (share - s) * way) for s in (1e-2, 1e-3)])
    )
    assert_array_equal(near.mobility, 3)
    assert_allclose(near.constraint[0] / near.constraint[1], 10.0, rtol=0.1)


def parallelogram() -> ClosedLoopRobot:
    """Crank and rocker of 0.2 m, base and coupler of 0.5 m; the reference pose is upright."""
    model = pin.Model()
    crank = model.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), "crank")
    coupler = model.addJoint(
        crank, pin.JointModelRZ(), pin.SE3(np.eye(3), np.array([0.2, 0.0, 0.0])), "coupler"
    )
    rocker = model.addJoint(
        0, pin.JointModelRZ(), pin.SE3(np.eye(3), np.array([0.5, 0.0, 0.0])), "rocker"
    )
    ends = (
        (coupler, pin.SE3(np.eye(3), np.array([0.5, 0.0, 0.0]))),
        (rocker, pin.SE3(np.eye(3), np.array([0.2, 0.0, 0.0]))),
    )
    closure = pin.RigidConstraintModel(
        pin.ContactType.CONTACT_3D, model, *ends[0], *ends[1], pin.ReferenceFrame.LOCAL
    )
    model.addFrame(
        pin.Frame(
            "middle",
            coupler,
            0,
            pin.SE3(np.eye(3), np.array([0.25, 0.0, 0.0])),
            pin.FrameType.OP_FRAME,
        )
    )
    return ClosedLoopRobot(model, [closure], ("crank",), [1.0, -1.0, 1.0])


def test_flat_parallelogram_has_a_freedom_more() -> None:
    """All links in line: parallelogram and antiparallelogram meet.

    The closures lose rank, and the crank does not decide which it becomes.

    The textbook's constraint singularity. Near it the smallest singular value shrinks with the
    angle.
    """
    analysis = SingularityAnalysis(parallelogram(), "middle", ("y",))
    measures = analysis.measures(
        np.array([[angle, -angle, angle] for angle in (0.2, 0.02, 0.002, 0.0)])
    )
    assert_array_equal(measures.mobility, [1, 1, 1, 2])
    assert_allclose(measures.constraint[1:3] / measures.constraint[:2], 0.1, rtol=0.02)
    assert measures.constraint[3] < 1e-15
    assert measures.actuation[3] == 0.0
    assert np.isnan(
        [
            measures.end_effector[3],
            measures.condition[3],
            measures.manipulability[3],
            measures.orientation[3],
        ]
    ).all()
    assert measures.closure_condition[3] == np.inf
    found = analysis.classify(np.zeros(3))
    assert found.kinds == ("constraint", "actuation")
    assert_allclose(found.locked[:, 0], 0.0, atol=1e-15)
    assert analysis.classify([0.2, -0.2, 0.2]).kinds == ()


# The 3-PSP

AROUND = np.radians(np.arange(-170.0, 181.0, 25.0))


@pytest.fixture(scope="module")
def star() -> psp3.PSP3:
    return psp3.load("psp3")


def test_tip_of_the_3_psp_is_singular_on_the_closed_forms_fold_and_its_orientation_is_not(
    star: psp3.PSP3,
) -> None:
    """Bisection in the closed form gives the tilt.

    The generic measure of the tip vanishes there, that of the orientation does not.
    """
    q = star.configuration(star.inverse_kinematics(0.0, fold_tilt(star, AROUND), AROUND))
    tip = SingularityAnalysis(star, "tip", ("x", "y", "z")).measures(q)
    assert tip.end_effector.max() < 1e-9
    assert tip.actuation.min() > 0.1
    orientation = SingularityAnalysis(star, "tip", ("z", "rx", "ry")).measures(q)
    assert orientation.end_effector.min() > 0.1
    assert (orientation.orientation == orientation.orientation[0]).all()
    inside, outside = (
        SingularityAnalysis(star, "tip", ("x", "y", "z"))
        .measures(
            star.configuration(
                star.inverse_kinematics(0.0, share * fold_tilt(star, AROUND), AROUND)
            )
        )
        .orientation
        for share in (0.999, 1.001)
    )
    assert_array_equal(inside, -outside)
    assert_array_equal(np.abs(inside), 1.0)


def test_3_psp_has_no_singularity_of_actuation_or_constraint(star: psp3.PSP3) -> None:
    """As the closed form's determinant √3 s A > 0 says.

    Up to the tilt where an arm vanishes, the least measures stay away from zero.
    """
    shares = np.linspace(0.0, 0.999, 40)[:, np.newaxis]
    tilt, azimuth = np.broadcast_arrays(
        np.minimum(shares * largest_tilt(AROUND), np.radians(80.0)), AROUND
    )
    q = star.configuration(star.inverse_kinematics(0.0, tilt, azimuth))
    measures = SingularityAnalysis(star, "tip", ("z", "rx", "ry")).measures(q)
    assert measures.actuation.min() > 0.02
    assert measures.constraint.min() > 0.02
    assert_array_equal(measures.orientation, measures.orientation[0, 0])
    assert_array_equal(measures.mobility, 3)


def test_gimbal_of_three_hinges_in_place_of_a_ball_joint() -> None:
    r"""A body on a driven hinge about x, and beside it a chain of hinges to the same body.

    The chain turns about y, x and z, as in the legs of the 3-PSP.

    At the angle t of the middle hinge the axes of the outer two make an angle of 90° - t, so that
    the singular values of the three axes are 1 and √(1 ± sin t). At 90° the outer two turn about
    one line, against each other, whatever the motor does.
    """
    model = pin.Model()
    driven = model.addJoint(0, pin.JointModelRX(), pin.SE3.Identity(), "driven")
    last = 0
    for name, joint in (
        ("phi", pin.JointModelRY()),
        ("theta", pin.JointModelRX()),
        ("lambda", pin.JointModelRZ()),
    ):
        last = model.addJoint(last, joint, pin.SE3.Identity(), name)
    model.addFrame(pin.Frame("body", driven, 0, pin.SE3.Identity(), pin.FrameType.OP_FRAME))
    sides = (driven, pin.SE3.Identity()), (last, pin.SE3.Identity())
    closure = pin.RigidConstraintModel(
        pin.ContactType.CONTACT_6D, model, *sides[0], *sides[1], pin.ReferenceFrame.LOCAL
    )
    robot = ClosedLoopRobot(model, [closure], ("driven",), np.zeros(4))
    analysis = SingularityAnalysis(robot, "body", ("rx",), length=0.1)
    angles = np.radians([-89.0, -45.0, 0.0, 60.0, 89.0])
    s = np.abs(np.sin(angles))
    measures = analysis.measures(np.outer(angles, [1.0, 0.0, 1.0, 0.0]))
    assert_allclose(measures.closure_condition, np.sqrt((1.0 + s) / (1.0 - s)), rtol=1e-10)
    assert_allclose(measures.actuation, np.sqrt(0.5), rtol=1e-12)
    found = analysis.classify(0.5 * np.pi * np.array([1.0, 0.0, 1.0, 0.0]))
    assert found.kinds == ("constraint", "actuation")
    assert_allclose(np.abs(found.locked), [[0.0, 1.0, 0.0, 1.0]], atol=1e-12)


# Bad input


@pytest.mark.parametrize(
    ("call", "error", "match"),
    [
        (lambda robot: SingularityAnalysis(robot, "moon", ("x",)), UnknownName, "moon"),
        (lambda robot: SingularityAnalysis(robot, "tip", ("x", "yaw")), UnknownName, "yaw"),
        (lambda robot: SingularityAnalysis(robot, "tip", ()), InvalidValue, "task"),
        (lambda robot: SingularityAnalysis(robot, "tip", ("x", "x")), InvalidValue, "each once"),
        (
            lambda robot: SingularityAnalysis(robot, "tip", ("x",), length=0.0),
            InvalidValue,
            "length",
        ),
        (
            lambda robot: SingularityAnalysis(robot, "tip", ("x",), length=np.inf),
            InvalidValue,
            "length",
        ),
        (
            lambda robot: SingularityAnalysis(robot, "tip", ("x",)).measures([0.0, 1.0]),
            InvalidArray,
            "configurations",
        ),
        (
            lambda robot: SingularityAnalysis(robot, "tip", ("x",)).measures(np.full(4, np.nan)),
            InvalidArray,
            "nan",
        ),
        (
            lambda robot: SingularityAnalysis(robot, "tip", ("x",)).measures(
                robot.q0 + 0.1 * np.eye(4)[1]
            ),
            OpenLoops,
            "open by",
        ),
        (
            lambda robot: SingularityAnalysis(robot, "tip", ("x",)).classify(
                np.tile(robot.q0, (2, 1))
            ),
            InvalidArray,
            "configuration",
        ),
        (
            lambda robot: SingularityAnalysis(robot, "tip", ("x",)).classify(
                robot.q0, tolerance=0.0
            ),
            InvalidValue,
            "tolerance",
        ),
        (
            lambda robot: SingularityAnalysis(robot, "tip", ("x",)).positions("here"),
            InvalidArray,
            "configurations",
        ),
    ],
)
def test_bad_input_is_refused(
    call: Callable[[Any], object],
    error: type[Exception],
    match: str,
    robots: dict[str, ClosedLoopRobot],
) -> None:
    with pytest.raises(error, match=match):
        call(robots["five_bar"])


@pytest.mark.parametrize("shape", [(), (0,), (3,), (2, 3)])
def test_shapes(shape: tuple[int, ...], analyses: dict[str, SingularityAnalysis]) -> None:
    analysis = analyses["five_bar"]
    q = np.broadcast_to(analysis.robot.q0, (*shape, 4))
    assert {np.shape(values) for values in analysis.measures(q)} == {shape}
    assert analysis.positions(q).shape == (*shape, 3)


def test_many_configurations_are_those_one_by_one(analyses: dict[str, SingularityAnalysis]) -> None:
    """More than are factored at once."""
    analysis = analyses["five_bar"]
    positions = analysis.robot.reference + np.random.default_rng(9).uniform(
        -0.2, 0.2, size=(300, 2)
    )
    q = analysis.robot.configuration(positions)
    together = analysis.measures(q)
    for row in (0, 255, 256, 299):
        for whole, one in zip(together, analysis.measures(q[row]), strict=True):
            assert_array_equal(whole[row], one)
    assert_allclose(analysis.positions(q)[:, [0, 2]], FiveBar().forward(positions), atol=1e-12)


@pytest.mark.parametrize(
    ("name", "frame", "task", "options"),
    [
        ("hexa", "tip", ("x", "y", "z", "rx", "ry", "rz"), {}),
        ("agile_eye", "tip", ("rx", "ry", "rz"), {}),
        ("planar_4rrr", "tip", ("x", "y", "rz"), {}),
        ("gripper", "right_pad", ("y",), {"free": "lock"}),
    ],
    ids=["balls held in spin", "hinges and rounding", "more motors", "joints held and a tendon"],
)
def test_measures_of_what_is_no_loop_or_no_joint(
    name: str, frame: str, task: tuple[str, ...], options: dict[str, str]
) -> None:
    """Against the Jacobian of the core, which knows equations, and what the motors' speeds are.

    1e-9 of the measures; loops with six digits are open by 1e-6, which is what they agree to.
    """
    robot = psp3.load(name, **options)
    analysis = SingularityAnalysis(robot, frame, task)
    rows = [TASK_COORDINATES.index(one) for one in task]
    scale = np.array([analysis.length if row >= 3 else 1.0 for row in rows])
    bar = 1e-4 if name == "agile_eye" else 1e-9
    for shift in (0.0, 0.03):
        a = robot.reference + shift * np.arange(1, len(robot.reference) + 1) / 6.0
        jacobian = scale[:, np.newaxis] * robot.frame_jacobian(a, frame)[rows]
        # All motors turn, and turning counts as the way at the characteristic length.
        of_motors = jacobian @ np.linalg.pinv(robot.actuation_matrix(a).T) / analysis.length
        values = np.linalg.svd(of_motors, compute_uv=False)
        found = analysis.measures(robot.configuration(a))
        assert found.condition == pytest.approx(values[0] / values[-1], rel=bar)
        assert found.manipulability == pytest.approx(values.prod(), rel=bar)
        assert found.mobility == len(robot.coordinates)
