"""The robots that people build, against closed forms and mechanics that everybody agrees on.

Kinematics to 1e-10 m and rad, as of the other robots; 1e-14 is reached. The Agile Eye is written
with six digits, so its bar is the 1e-4 that a hundred times its mismatch leaves.
"""

from __future__ import annotations

import importlib
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

import psp3
from psp3.description.parts import ROBOT_FILES, ROBOTS, THESIS_ROBOTS
from psp3.errors import UnreachableForces
from tests.closed_form_kinematics import rotation_xyz
from tests.closed_form_machines import (
    AgileEye,
    CassieLeg,
    Finger,
    Hexa,
    JansenLeg,
    PlanarFourRRR,
)
from tests.helpers import Array, derivative

BUILT = ROBOTS[len(THESIS_ROBOTS) :]
README = (ROBOT_FILES / "README.md").read_text(encoding="utf-8")
TOLERANCE = 1e-10
ROUNDED = 1e-4

# Joint velocities, closure equations, rank, degrees of freedom, motors, of which commanded.
COUNTS = {
    "planar_4rrr": (9, 9, 6, 3, 4, 3),
    "jansen": (7, 9, 6, 1, 1, 1),
    "agile_eye": (7, 10, 4, 3, 3, 3),
    "hexa": (27, 15, 15, 12, 6, 6),
    "gripper": (8, 7, 5, 3, 1, 1),
    "biped": (32, 12, 10, 22, 10, 10),
}


@pytest.fixture(scope="module")
def robots() -> dict[str, psp3.ClosedLoopRobot]:
    return {name: psp3.load(name) for name in BUILT}


@pytest.mark.parametrize("name", BUILT)
def test_mobility_is_what_the_drawing_says(
    name: str, robots: dict[str, psp3.ClosedLoopRobot]
) -> None:
    found = robots[name].mobility
    assert (
        found.joint_velocities,
        found.closure_equations,
        found.rank,
        found.degrees_of_freedom,
        found.actuators,
        found.commanded,
    ) == COUNTS[name]
    assert found.degrees_of_freedom == found.joint_velocities - found.rank


@pytest.mark.parametrize("name", BUILT)
def test_the_readme_describes_the_robot(name: str, robots: dict[str, psp3.ClosedLoopRobot]) -> None:
    """The row of the table: counts, and the moving mass to 0.01 kg."""
    found = re.search(rf"^\| `{name}` \|(.*)\|$", README, flags=re.MULTILINE)
    assert found is not None
    cells = [cell.strip() for cell in found[1].split("|")]
    assert tuple(int(cell) for cell in cells[1:6]) == COUNTS[name][:5]
    mass = sum(inertia.mass for inertia in list(robots[name].model.inertias)[1:])
    assert float(cells[6]) == pytest.approx(mass, abs=0.005)


@pytest.mark.parametrize("name", BUILT)
def test_every_body_can_exist_and_is_drawn(
    name: str, robots: dict[str, psp3.ClosedLoopRobot]
) -> None:
    """Masses and moments of solids; home within the limits, and the frame of the tip."""
    robot = robots[name]
    for inertia in list(robot.model.inertias)[1:]:
        moments = np.linalg.eigvalsh(inertia.inertia)
        assert inertia.mass > 0.001
        assert moments[0] > 0.0
        assert moments[2] < moments[0] + moments[1]
    shapes = robot.visual_model.geometryObjects
    moving = set(range(1, robot.model.njoints))
    assert {shape.parentJoint for shape in shapes} - {0} == moving
    assert all(type(shape.geometry).__name__ in ("Box", "Cylinder", "Sphere") for shape in shapes)
    lower, upper = robot.limits
    assert (lower <= robot.reference).all()
    assert (robot.reference <= upper).all()
    assert robot.model.existFrame("tip")


# Planar 4-RRR


def planar_poses(count: int) -> Array:
    return np.random.default_rng(0).uniform(-1.0, 1.0, (count, 3)) * [0.05, 0.05, 0.4]


def test_planar_4rrr_has_the_crank_angles_of_its_quadratics(
    robots: dict[str, psp3.ClosedLoopRobot],
) -> None:
    robot, closed_form, poses = robots["planar_4rrr"], PlanarFourRRR(), planar_poses(50)
    angles = closed_form.inverse(poses)
    tip = robot.frame_placement(angles[:, :3], "tip")
    found = np.column_stack([tip[:, :2, 3], np.arctan2(tip[:, 1, 0], tip[:, 0, 0])])
    assert_allclose(found, poses, rtol=0, atol=TOLERANCE)
    joint = robot.model.joints[robot.model.getJointId("leg4_shoulder")]
    fourth = robot.configuration(angles[:, :3])[:, joint.idx_q]
    assert_allclose(fourth, angles[:, 3], rtol=0, atol=TOLERANCE)


def test_four_motors_of_a_planar_robot_can_work_against_each_other(
    robots: dict[str, psp3.ClosedLoopRobot],
) -> None:
    """In one way, at every pose: forces along the rods that balance on the platform.

    Of all torques of a motion the ones of least norm have no share in it.
    """
    robot, closed_form, poses = robots["planar_4rrr"], PlanarFourRRR(), planar_poses(20)
    angles = closed_form.inverse(poses)
    for row, expected in zip(angles, closed_form.preload(poses), strict=True):
        preload = robot.preload(row[:3])
        assert preload.shape == (4, 1)
        assert abs(preload[:, 0] @ expected) == pytest.approx(1.0, abs=TOLERANCE)
        torques = robot.actuator_forces(row[:3], [0.5, -0.2, 0.3], [1.0, 2.0, -1.0])
        assert abs(torques @ expected) < TOLERANCE


# Jansen's leg


def test_jansens_foot_is_where_triangles_put_it(
    robots: dict[str, psp3.ClosedLoopRobot],
) -> None:
    """Over a whole turn of the crank, after which the leg stands as before."""
    robot, turn = robots["jansen"], np.linspace(0.3, 0.3 + 2.0 * np.pi, 145)
    configurations = robot.configurations_along(turn[:, None])
    data, foot = robot.model.createData(), []
    for q in configurations:
        pin.framesForwardKinematics(robot.model, data, q)
        foot.append(data.oMf[robot.model.getFrameId("tip")].translation.copy())
    expected = JansenLeg().foot(turn)
    assert_allclose(np.array(foot)[:, [0, 2]], expected, rtol=0, atol=TOLERANCE)
    around = (configurations[-1] - configurations[0]) / (2.0 * np.pi)
    assert_allclose(around, around.round(), rtol=0, atol=TOLERANCE)
    # Rods on the crank turn back once while it turns forward.
    names = list(robot.model.names)[1:]
    assert {name: turns for name, turns in zip(names, around.round(), strict=True) if turns} == {
        "crank_joint": 1.0,
        "rod_j_joint": -1.0,
        "rod_k_joint": -1.0,
    }


def test_jansens_foot_goes_flat_on_the_ground() -> None:
    """What the lengths were bred for: a long level step, and little lift.

    In units of the thirteen numbers the step is 67.9 wide and 22.5 high, and for 155° of a turn the
    foot is within 1 of the ground, on 57 of its way.
    """
    turn = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
    foot = 100.0 * JansenLeg().foot(turn)
    assert_allclose(np.ptp(foot, axis=0), [67.9, 22.5], rtol=0, atol=0.1)
    low = foot[:, 1] < foot[:, 1].min() + 1.0
    assert low.mean() * 360.0 == pytest.approx(155.0, abs=1.0)
    assert np.ptp(foot[low, 0]) == pytest.approx(57.3, abs=0.2)


# Agile Eye


def test_agile_eye_has_the_angles_of_its_direction_cosines(
    robots: dict[str, psp3.ClosedLoopRobot],
) -> None:
    robot, closed_form = robots["agile_eye"], AgileEye()
    rotations = rotation_xyz(np.random.default_rng(0).uniform(-0.5, 0.5, (50, 3)))
    angles = closed_form.angles(rotations)
    tip = robot.frame_placement(angles, "tip")
    assert_allclose(tip[:, :3, :3], rotations, rtol=0, atol=ROUNDED)
    assert_allclose(tip[:, :3, 3], 0.0, rtol=0, atol=ROUNDED)
    jacobian = robot.frame_jacobian(angles, "tip")[:, 3:]
    product = closed_form.rates(rotations) @ jacobian
    assert_allclose(product, np.broadcast_to(np.eye(3), product.shape), rtol=0, atol=ROUNDED)


def test_agile_eye_is_isotropic_at_home(robots: dict[str, psp3.ClosedLoopRobot]) -> None:
    """Condition 1, which it is built for.

    C. M. Gosselin and É. Lavoie, "On the kinematic design of spherical three-degree-of-freedom
    parallel manipulators", International Journal of Robotics Research 12 (1993) 394-402.
    """
    robot = robots["agile_eye"]
    jacobian = robot.frame_jacobian(robot.reference, "tip")[3:]
    assert_allclose(np.linalg.svd(jacobian)[1], 1.0, rtol=0, atol=ROUNDED)
    assert np.linalg.cond(AgileEye().rates(np.eye(3))) == pytest.approx(1.0, abs=1e-12)


def test_agile_eye_says_that_its_digits_do_not_close_it(
    robots: dict[str, psp3.ClosedLoopRobot],
) -> None:
    mismatch = robots["agile_eye"].closure_mismatch
    assert 1e-7 < mismatch.length < 1e-5
    assert 1e-7 < mismatch.angle < 1e-5
    assert all(
        robots[name].closure_mismatch.length < 1e-12 for name in BUILT if name != "agile_eye"
    )


@pytest.fixture
def agile_eye_of(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Callable[[int | None], psp3.ClosedLoopRobot]:
    """Return what writes the Agile Eye with any number of digits, all of them for None."""
    monkeypatch.syspath_prepend(str(ROBOT_FILES))
    script = importlib.import_module("making.agile_eye")

    def written(digits: int | None) -> psp3.ClosedLoopRobot:
        monkeypatch.setattr(script, "DIGITS", digits)
        for name, text in script.agile_eye().texts().items():
            (tmp_path / name).write_text(text, encoding="utf-8")
        return psp3.ClosedLoopRobot.from_urdf(
            tmp_path / "agile_eye.urdf", tmp_path / "agile_eye.yaml", tmp_path / "agile_eye.srdf"
        )

    return written


@pytest.mark.parametrize("digits", [4, 5, 6, 8])
def test_agile_eye_moves_as_the_exact_one_to_its_digits(
    digits: int, agile_eye_of: Callable[[int | None], psp3.ClosedLoopRobot]
) -> None:
    """Within 100 units of the last digit (40 were seen), against the one with all digits.

    A motor holds the weight of the wrist, and what is left for accelerations is a hundredth of it
    here. So these are compared in accelerations that the motors' forces alone would make: beside
    the accelerations themselves, an error in the weight is a hundred times as large, in whichever
    way the loops are closed.
    """
    exact, found, rng = agile_eye_of(None), agile_eye_of(digits), np.random.default_rng(0)
    assert exact.closure_mismatch.length < 1e-14
    bar = 100.0 * 10.0**-digits
    for _ in range(20):
        positions = exact.reference + rng.uniform(-0.3, 0.3, 3)
        speeds, accelerations = rng.uniform(-1.0, 1.0, (2, 3))
        (M, _, G), (M2, _, G2) = (
            robot.equation_of_motion(positions, speeds) for robot in (exact, found)
        )
        forces = exact.inverse_dynamics(positions, speeds, accelerations)
        assert np.abs(M2 - M).max() < bar * np.abs(M).max()
        assert np.abs(G2 - G).max() < bar * np.abs(G).max()
        least = bar * np.abs(np.linalg.solve(M, forces)).max()
        moved = found.forward_dynamics(positions, speeds, forces)
        assert np.abs(moved - accelerations).max() < least
        falls, fell = (
            robot.forward_dynamics(positions, speeds, np.zeros(3)) for robot in (found, exact)
        )
        assert np.abs(falls - fell).max() < bar * np.abs(fell).max()


# Hexa


def test_hexa_has_the_crank_angles_of_its_rods(robots: dict[str, psp3.ClosedLoopRobot]) -> None:
    robot, closed_form, rng = robots["hexa"], Hexa(), np.random.default_rng(0)
    positions = closed_form.home + rng.uniform(-0.02, 0.02, (50, 3))
    rotations = rotation_xyz(rng.uniform(-0.2, 0.2, (50, 3)))
    tip = robot.frame_placement(closed_form.angles(positions, rotations), "tip")
    assert_allclose(tip[:, :3, 3], positions, rtol=0, atol=TOLERANCE)
    assert_allclose(tip[:, :3, :3], rotations, rtol=0, atol=TOLERANCE)
    assert_allclose(robot.reference, 0.0, rtol=0, atol=1e-12)


def test_what_spins_in_a_hexa_are_its_six_rods(robots: dict[str, psp3.ClosedLoopRobot]) -> None:
    """Each about its own line, which at home is that between its two balls."""
    robot = robots["hexa"]
    assert sorted(one.joint for one in robot.locked) == [f"leg{k}_ball" for k in range(1, 7)]
    closed_form = Hexa()
    lines = closed_form.home + closed_form.corners - closed_form.feet
    lines -= closed_form.crank * closed_form.along
    for one in robot.locked:
        assert one.spin is not None
        line = lines[int(one.joint[3]) - 1] / closed_form.rod
        assert abs(one.spin.axis @ line) == pytest.approx(1.0, abs=1e-9)


# Gripper


def finger_states(count: int) -> tuple[Array, Array]:
    """Return angles of both drivers, and of the springs to the right and left."""
    rng = np.random.default_rng(0)
    drivers = rng.uniform(0.1, 0.7, count)
    return drivers, drivers[:, None] + rng.uniform(-0.05, 0.05, (count, 2))


def test_gripper_has_the_fingertips_of_two_five_bars(
    robots: dict[str, psp3.ClosedLoopRobot],
) -> None:
    robot, closed_form = robots["gripper"], Finger()
    assert robot.coordinates == ("right_driver", "right_spring", "left_spring")
    drivers, springs = finger_states(30)
    positions = np.column_stack([drivers, springs])
    for side, name, spring in zip((1.0, -1.0), ("right", "left"), springs.T, strict=True):
        pad = robot.frame_placement(positions, f"{name}_pad")
        expected = closed_form.place(drivers, spring)
        assert_allclose(pad[:, 1, 3], side * expected[:, 0], rtol=0, atol=TOLERANCE)
        assert_allclose(pad[:, 2, 3], expected[:, 1], rtol=0, atol=TOLERANCE)
        turned = side * np.arctan2(pad[:, 2, 1], pad[:, 1, 1])
        assert_allclose(turned, closed_form.angle(drivers, spring), rtol=0, atol=TOLERANCE)


def test_gripper_opens_by_85_mm_and_closes_at_its_drivers_stop() -> None:
    """The stroke that the maker states, and 0.8 rad of the published models, to a millimeter.

    With pads that stay parallel, as they do by the springs until they touch something.
    """
    closed_form = Finger()

    def parallel(driver: float) -> float:
        low, high = driver - 0.1, driver + 0.1
        for _ in range(60):
            middle = 0.5 * (low + high)
            above = closed_form.angle(driver, middle) < 0.0
            low, high = (low, middle) if above else (middle, high)
        return 0.5 * (low + high)

    opening, closed = (2.0 * closed_form.place(a, parallel(a))[0] for a in (0.0, 0.8))
    assert opening == pytest.approx(0.0854, abs=1e-6)
    assert abs(closed) < 2e-3


def test_home_of_the_gripper_is_half_closed_with_parallel_pads(
    robots: dict[str, psp3.ClosedLoopRobot],
) -> None:
    robot = robots["gripper"]
    assert robot.reference[0] == pytest.approx(0.4, abs=1e-12)
    for name in ("right", "left"):
        pad = robot.frame_placement(robot.reference, f"{name}_pad")
        assert_allclose(pad[:3, :3], np.eye(3), rtol=0, atol=1e-12)


def test_gripper_holds_by_virtual_work(robots: dict[str, psp3.ClosedLoopRobot]) -> None:
    """The tendon's force and two springs carry forces on the pads, weights, and nothing else.

    By the closed form's own rates: a lever of one half each for the two coupled drivers. Springs
    are 0.05 N m/rad, at rest at 2.62 rad.
    """
    robot, closed_form = robots["gripper"], Finger()
    push = np.array([3.0, -1.0])  # outward and down, on each pad [N]
    drivers, springs = finger_states(10)
    for driver, pair in zip(drivers, springs, strict=True):
        row = np.array([driver, *pair])
        outside = sum(
            robot.frame_jacobian(row, f"{name}_pad")[1:3].T @ (push * [side, 1.0])
            for name, side in (("right", 1.0), ("left", -1.0))
        )
        by_driver, by_springs = 0.0, []
        for spring in pair:
            along = derivative(lambda t, s=spring: closed_form.place(driver + t, s), 1e-3)  # noqa: B023
            by_driver += push @ along
            across = derivative(lambda t, s=spring: closed_form.place(driver, s + t), 1e-3)  # noqa: B023
            by_springs.append(push @ across)
        assert_allclose(outside, [by_driver, *by_springs], rtol=0, atol=1e-9)
        assert_allclose(robot.actuation_matrix(row)[:, 0], [1.0, 0.0, 0.0], rtol=0, atol=1e-12)
        holding = robot.inverse_dynamics(row, np.zeros(3), np.zeros(3))
        weight = pin.computeGeneralizedGravity(
            robot.model, robot.model.createData(), robot.configuration(row)
        )
        lift = robot.closure(row).complement.T @ weight
        assert_allclose(holding - lift, [0.0, *(0.05 * (pair - 2.62))], rtol=0, atol=1e-12)
    with pytest.raises(UnreachableForces):
        robot.actuator_forces(row, np.zeros(3), np.zeros(3))


# Biped


def biped_state(seed: int) -> tuple[Array, Array, Array]:
    """Return positions, speeds and motors' forces of the biped, its base turned by up to 1 rad."""
    rng, robot = np.random.default_rng(seed), psp3.load("biped")
    positions = robot.reference.copy()
    positions[:14] += rng.uniform(-0.1, 0.1, 14)
    positions[14:] = pin.SE3ToXYZQUAT(pin.exp6(rng.uniform(-1.0, 1.0, 6)))
    return positions, rng.uniform(-1.0, 1.0, 20), rng.uniform(-10.0, 10.0, 10)


def test_biped_is_as_long_as_its_rods(robots: dict[str, psp3.ClosedLoopRobot]) -> None:
    """Angles of the joints are counted from home: hip 0.5, knee -1.2, foot -1.6 rad."""
    robot, leg = robots["biped"], CassieLeg()

    def at(q: Array, name: str) -> float:
        return float(q[robot.model.joints[robot.model.getJointId(name)].idx_q])

    home = closed_tarsus(-1.2)
    arm = toe_crank(-1.6)
    for seed in range(5):
        q = robot.configuration(biped_state(seed)[0])
        for side in ("left", "right"):
            angles = (
                at(q, f"{side}_knee") - 1.2,
                at(q, f"{side}_shin"),
                at(q, f"{side}_tarsus") + home,
                at(q, f"{side}_heel_spring"),
            )
            assert leg.achilles_length(*angles) == pytest.approx(leg.achilles, abs=TOLERANCE)
            crank, foot = at(q, f"{side}_toe") + arm, at(q, f"{side}_foot") - 1.6
            assert leg.plantar_length(crank, foot) == pytest.approx(leg.plantar, abs=TOLERANCE)


def closed_tarsus(knee: float) -> float:
    """Return the tarsus's angle at which the Achilles rod has its length, springs at rest."""
    leg, low, high = CassieLeg(), 1.0, 1.8
    for _ in range(60):
        middle = 0.5 * (low + high)
        longer = leg.achilles_length(knee, 0.0, middle, 0.0) > leg.achilles
        beyond = longer == (leg.achilles_length(knee, 0.0, 1.0, 0.0) < leg.achilles)
        low, high = (low, middle) if beyond else (middle, high)
    return 0.5 * (low + high)


def toe_crank(foot: float) -> float:
    """Return the crank's angle at which the plantar rod has its length, the crank below."""
    leg, low, high = CassieLeg(), -2.2, -1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        longer = leg.plantar_length(middle, foot) > leg.plantar
        beyond = longer == (leg.plantar_length(-2.2, foot) < leg.plantar)
        low, high = (low, middle) if beyond else (middle, high)
    return 0.5 * (low + high)


def test_biped_bends_as_cassie_does() -> None:
    """The standing pose that MuJoCo Menagerie publishes: knee -1.1997, tarsus 1.4267.

    And foot -1.5968 with crank -1.5244 rad. Its rods' ends are rounded to a tenth of a millimeter
    here, and its springs bear the robot there: a hundredth of a radian, four for the short crank.
    """
    assert closed_tarsus(-1.1997) == pytest.approx(1.4267, abs=0.01)
    assert toe_crank(-1.5968) == pytest.approx(-1.5244, abs=0.04)


def test_a_spinning_rod_moves_no_floating_base(robots: dict[str, psp3.ClosedLoopRobot]) -> None:
    held = robots["biped"].locked
    assert [one.joint for one in held] == ["left_achilles", "right_achilles"]
    assert all(one.moving == (one.joint,) for one in held)


def test_biped_falls_freely(robots: dict[str, psp3.ClosedLoopRobot]) -> None:
    """With no force of its motors and its springs at rest, nothing moves but the whole, by g."""
    robot = robots["biped"]
    base = pin.exp6(np.array([0.3, -0.2, 0.9, 0.4, -0.7, 1.1]))
    positions = np.append(robot.reference[:14], pin.SE3ToXYZQUAT(base))
    found = robot.forward_dynamics(positions, np.zeros(20), np.zeros(20))
    expected = np.zeros(20)
    expected[14:17] = base.rotation.T @ [0.0, 0.0, -9.81]
    assert_allclose(found, expected, rtol=0, atol=1e-10)


def test_motors_and_springs_of_a_biped_move_no_center_of_mass(
    robots: dict[str, psp3.ClosedLoopRobot],
) -> None:
    """Whatever they do, it falls by g, and the angular momentum about it stays.

    Both from Pinocchio's sums over the tree, to 1e-9 of the largest force.
    """
    robot, model = robots["biped"], robots["biped"].model
    data, mass = model.createData(), pin.computeTotalMass(model)
    for seed in range(5):
        positions, speeds, forces = biped_state(seed)
        along = robot.actuation_matrix(positions) @ forces
        accelerations = robot.forward_dynamics(positions, speeds, along)
        pose = robot.closure(positions)
        q, v = pose.configuration, robot.velocity(positions, speeds)
        a = pose.complement @ accelerations + robot.drift(q, v)
        pin.computeCentroidalMomentumTimeVariation(model, data, q, v, a)
        assert_allclose(data.dhg.linear, [0.0, 0.0, -9.81 * mass], rtol=0, atol=1e-7)
        assert_allclose(data.dhg.angular, 0.0, rtol=0, atol=1e-7)
        # The rows of the base are the momentum of the whole, seen from the base.
        momentum = pin.computeCentroidalMomentum(model, data, q, v)
        center = pin.SE3(np.eye(3), data.com[0])
        # Its positions are away from where the file has it.
        base = model.jointPlacements[model.getJointId("root")] * pin.XYZQUATToSE3(positions[14:])
        seen = base.actInv(center.act(momentum))
        assert_allclose(robot.mass_matrix(positions)[14:] @ speeds, seen.vector, rtol=0, atol=1e-9)
