"""The plants of a simulation agree with one another, with drives and without."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import psp3
from psp3.description.parts import THESIS_ROBOTS
from psp3.drives import NO_DRIVE, Drive
from psp3.errors import InvalidValue
from psp3.simulation.constraint_dynamics import ConstraintDynamics
from psp3.simulation.dormand_prince import DormandPrince
from psp3.simulation.plant import Plant
from psp3.simulation.runge_kutta import RungeKutta
from psp3.trajectories import Helix, PointToPoint
from tests.psp3.simulation.plants import after

ROBOT = psp3.load("psp3")

CORE = ROBOT.dynamics("core")
PINOCCHIO = ROBOT.dynamics("pinocchio")

MASS, WEIGHT = ROBOT.parameters.total_mass, ROBOT.parameters.total_mass * 9.81

DRIVE = Drive(coulomb_friction=20.0, viscous_friction=5.0, motor_inertia=1e-5, lead=0.010)

PLANTS: dict[str, Callable[..., Plant]] = {
    "closed form": lambda drive: RungeKutta(ROBOT, drive=drive),
    "actuated coordinates": lambda drive: RungeKutta(
        CORE,  # type: ignore[arg-type]
        drive=drive,
    ),
    "reference": lambda drive: DormandPrince(ROBOT, drive=drive),
    "tree": lambda drive: ConstraintDynamics(ROBOT, drive=drive),
}


def run(plant: Plant, duration: float = 0.5) -> psp3.Result:
    return psp3.simulate(
        ROBOT, psp3.ComputedTorque(ROBOT), Helix(robot=ROBOT), duration, plant=plant
    )


def test_the_three_plants_agree() -> None:
    """Tree with constraint forces against closed form.

    Runge–Kutta errors of 2 ms steps are 1e-12 m; DOP853 runs at 1e-12.
    """
    closed = run(RungeKutta(ROBOT))
    for plant in (RungeKutta(ROBOT, steps=4), DormandPrince(ROBOT), ConstraintDynamics(ROBOT)):
        other = run(plant)
        np.testing.assert_allclose(other.heights, closed.heights, atol=1e-11)
        np.testing.assert_allclose(other.speeds, closed.speeds, atol=1e-10)


def test_no_plant_goes_on_beyond_the_poses_of_the_machine() -> None:
    """Huge opposite forces on two screws must end every closed-form plant, not return numbers."""
    for plant in (RungeKutta(ROBOT), DormandPrince(ROBOT)):
        plant.start(np.zeros(3), np.zeros(3))
        assert plant.advance(np.array([0.0, 1e6, -1e6]), 0.01) is None


@pytest.mark.parametrize("name", PLANTS)
def test_without_a_drive_nothing_changes(name: str) -> None:
    """Not a bit of it."""
    plain = {
        "closed form": RungeKutta(ROBOT),
        "actuated coordinates": RungeKutta(CORE),  # type: ignore[arg-type]
        "reference": DormandPrince(ROBOT),
        "tree": ConstraintDynamics(ROBOT),
    }
    state = [0.02, -0.03, 0.05], [0.3, -0.2, 0.05], [90.0, 80.0, 85.0], 0.1, 10
    np.testing.assert_array_equal(after(PLANTS[name](NO_DRIVE), *state), after(plain[name], *state))


@pytest.mark.parametrize("name", PLANTS)
@pytest.mark.parametrize("viscous", [0.0, 8.0])
def test_all_nuts_together_are_a_block_that_slides_to_rest(name: str, viscous: float) -> None:
    r"""A level star that only rises is a mass m = 26.5 kg + 3 J: closed form.

    From v0 with B the viscous and c the constant deceleration: it rests after (m/B) ln(1 + B v0/(m
    c)), or v0/c without B, and has gone (m/B)(v0 − c t). A hundredth before, the speed is c 0.01 s
    plus terms in B; afterwards, nothing moves. 1e-10 m: the steps of 2 ms are exact without B and
    leave 1e-14 with it, and the tree's loops are closed to 1e-11.
    """
    drive = Drive(12.0, viscous, 2e-5, 0.010)
    mass, friction, v0 = MASS + 3.0 * 2e-5 * (200.0 * np.pi) ** 2, 36.0, 0.1
    force = (WEIGHT - 20.0) / 3.0
    c, b = (friction + 20.0) / mass, 3.0 * viscous / mass
    duration = np.log1p(b * v0 / c) / b if b else v0 / c
    way = (v0 - c * duration) / b if b else 0.5 * v0**2 / c
    periods = int(duration / 0.002) + 2
    heights, speeds = after(
        PLANTS[name](drive), [0.0] * 3, [v0] * 3, [force] * 3, 0.002 * periods, periods
    )
    np.testing.assert_allclose(heights, way, rtol=0.0, atol=1e-10)
    np.testing.assert_array_equal(speeds, 0.0)
    before = duration - 0.01
    heights, speeds = after(PLANTS[name](drive), [0.0] * 3, [v0] * 3, [force] * 3, before, periods)
    expected = (v0 + c / b) * np.exp(-b * before) - c / b if b else v0 - c * before
    np.testing.assert_allclose(speeds, expected, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("name", PLANTS)
def test_below_its_friction_a_nut_does_not_creep(name: str) -> None:
    """Forces off balance by up to 99.9 % of the friction, either way, on a tilted star.

    Not a bit of motion, however long.
    """
    heights, drive = np.array([0.03, -0.02, 0.01]), Drive(15.0, 3.0)
    forces = ROBOT.gravity(heights) + 15.0 * np.array([0.999, -0.999, 0.5])
    periods = {"closed form": 50_000}.get(name, 20)
    found, speeds = after(
        PLANTS[name](drive), heights, np.zeros(3), forces, 0.002 * periods, periods
    )
    np.testing.assert_array_equal(speeds, 0.0)
    # The tree's own closed form of these heights is not theirs to the last bit.
    np.testing.assert_allclose(found, heights, rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("name", PLANTS)
def test_above_its_friction_a_nut_lets_go_alone(name: str) -> None:
    """Screw 1 is pulled with 10 N more than its friction, and the others stick.

    So nut 1 is a mass on a rail, M11(a1) a'' + C11 a' = f − G1 − F, integrated with M, C and G of
    Pinocchio's path by DOP853. The others' friction stays below its limit all the while, or they
    could not be taken to stick. 1e-9 m: the steps of 2 ms leave 1e-12, the tree's loops are closed
    to 1e-11.
    """
    heights, drive = np.array([0.01, -0.02, 0.03]), Drive(15.0)
    forces = ROBOT.gravity(heights) + np.array([25.0, 3.0, -2.0])

    def terms(a1: float, v1: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        M, C, G = PINOCCHIO.equation_of_motion(
            np.array([a1, -0.02, 0.03]), np.array([v1, 0.0, 0.0])
        )
        return M[:, 0], C[:, 0] * v1, G

    def rates(_: float, state: np.ndarray) -> list[float]:
        M, c, G = terms(*state)
        return [state[1], (forces[0] - 15.0 - c[0] - G[0]) / M[0]]

    expected = solve_ivp(
        rates, (0.0, 0.2), [heights[0], 0.0], method="DOP853", rtol=1e-12, atol=1e-13
    )
    for a1, v1 in expected.y.T:
        M, c, G = terms(a1, v1)
        assert (np.abs(forces - c - G - M * rates(0.0, np.array([a1, v1]))[1])[1:] < 15.0).all()
    found, speeds = after(PLANTS[name](drive), heights, np.zeros(3), forces, 0.2, 100)
    assert found[0] == pytest.approx(expected.y[0, -1], abs=1e-9)
    assert speeds[0] == pytest.approx(expected.y[1, -1], abs=1e-8)
    np.testing.assert_array_equal(speeds[1:], 0.0)
    np.testing.assert_allclose(found[1:], heights[1:], rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("name", PLANTS)
def test_a_slowly_growing_pull_lets_a_nut_go_when_it_exceeds_its_friction(name: str) -> None:
    """In steps of 0.1 N: at 14.9 N it rests, at 15.1 N it moves."""
    plant, weight = PLANTS[name](Drive(15.0)), ROBOT.gravity(np.zeros(3))
    plant.start(np.zeros(3), np.zeros(3))
    for pull in (14.7, 14.8, 14.9, 15.1):
        state = plant.advance(weight + pull, 0.002)
        assert state is not None
        assert (state[1] > 0.0).all() == (pull > 15.0)
        assert (state[1] == 0.0).all() == (pull < 15.0)


@pytest.mark.parametrize("viscous", [0.0, 4.0])
def test_work_is_kinetic_and_potential_energy_and_heat(viscous: float) -> None:
    """Constant forces on a tilted star whose nuts come to rest one by one.

    Motors put in f · Δa; dry friction takes F |Δa| of every nut, none of which turns back; viscous
    friction takes the integral of B v², by Gauss's quadrature between the events with cubic
    interpolation, in periods of 0.2 ms. Without B all but the integration of the motion is exact,
    1e-11 J of 1 J; with it the quadrature of periods with an event leaves 1e-9 J.
    """
    drive = Drive(20.0, viscous, 1e-5, 0.010)
    heights, speeds, period = np.array([-0.03, 0.05, 0.02]), np.array([0.4, -0.3, 0.1]), 2e-4
    forces = ROBOT.gravity(heights) + np.array([3.0, -2.0, 1.0])
    plant = RungeKutta(ROBOT, drive=drive)
    plant.start(heights, speeds)
    states = [(heights, speeds)]
    for _ in range(2000):
        state = plant.advance(forces, period)
        assert state is not None
        states.append((state[0].copy(), state[1].copy()))
    a, v = (np.array(rows) for rows in zip(*states, strict=True))
    assert (v[-1] == 0.0).all()
    assert not ((v[1:] * v[:-1]) < 0.0).any()
    energy = (
        ROBOT.kinetic_energy(a, v)
        + 0.5 * drive.reflected_inertia * (v**2).sum(axis=1)
        + ROBOT.potential_energy(a)
    )
    way = np.diff(a, axis=0)
    # The middle speed of a cubic with these ends; then Simpson's rule.
    middle = 1.5 * way / period - 0.25 * (v[1:] + v[:-1])
    heat = 20.0 * np.abs(way) + viscous * period / 6.0 * (
        v[1:] ** 2 + 4.0 * middle**2 + v[:-1] ** 2
    )
    balance = np.cumsum((forces * way - heat).sum(axis=1)) - (energy[1:] - energy[0])
    assert np.abs(balance).max() < (1e-9 if viscous else 1e-11)
    assert heat.sum() > 0.5


def stick_and_slip(plant: Plant, duration: float = 0.8) -> psp3.Result:
    """Steer along a helix with a PD controller soft enough for the nuts to stick.

    Every nut turns back on it.
    """
    controller = psp3.GravityCompensatedPD(ROBOT, 5000.0, 50.0)
    return psp3.simulate(ROBOT, controller, Helix(0.02, 1.0, robot=ROBOT), duration, plant=plant)


def test_plants_with_drives_agree_through_stick_and_slip() -> None:
    """As without drives, to 1e-11 m and 1e-10 m/s, for events are found to the last bit.

    The tree's loops are open by some 1e-11 m.
    """
    closed = stick_and_slip(PLANTS["closed form"](DRIVE))
    stuck = closed.speeds == 0.0
    # It is about what is tested: nuts come to rest, stay for several periods, and go on, the other
    # way round too.
    assert ((stuck[1:] & ~stuck[:-1]).sum(axis=0) >= 1).all()
    assert (stuck[1:] & stuck[:-1]).sum() > 10
    assert ((~stuck[1:] & stuck[:-1]).sum(axis=0) >= 1).all()
    for name, duration in (("actuated coordinates", 0.2), ("reference", 0.4), ("tree", 0.8)):
        other = stick_and_slip(PLANTS[name](DRIVE), duration)
        n = len(other.t)
        np.testing.assert_array_equal(other.speeds == 0.0, stuck[:n])
        np.testing.assert_allclose(
            other.heights, closed.heights[:n], rtol=0.0, atol=1e-10 if name == "tree" else 1e-11
        )
        np.testing.assert_allclose(
            other.speeds, closed.speeds[:n], rtol=0.0, atol=1e-8 if name == "tree" else 1e-10
        )


def test_every_joint_can_have_its_own_drive() -> None:
    """Screw 2 without friction, screw 3 with a heavy motor.

    The three plants agree, and differ from equal drives.
    """
    drives = [Drive(20.0), NO_DRIVE, Drive(5.0, 2.0, 1e-4, 0.010)]
    closed = stick_and_slip(RungeKutta(ROBOT, drive=drives), 0.2)
    for other in (DormandPrince(ROBOT, drive=drives), ConstraintDynamics(ROBOT, drive=drives)):
        np.testing.assert_allclose(
            stick_and_slip(other, 0.2).heights, closed.heights, rtol=0.0, atol=1e-10
        )
    assert (
        np.abs(stick_and_slip(RungeKutta(ROBOT, drive=DRIVE), 0.2).heights - closed.heights).max()
        > 1e-3
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in THESIS_ROBOTS if name != "psp3"])
def test_plants_of_any_robot_agree_with_and_without_drives(name: str) -> None:
    """Computed torque on a path of 0.1 s.

    Friction is a tenth of the largest weight, so that some joints stick at first.

    1e-9: the two with Runge–Kutta steps of 2 ms leave 1e-12 of a motion this slow; the tree's loops
    open by less than 1e-10.
    """
    robot = psp3.load(name)
    reference = robot.reference
    goal = reference + 0.05 * np.random.default_rng(0).uniform(-1.0, 1.0, reference.size)
    inertia = float(np.diag(robot.mass_matrix(reference)).mean())
    friction = max(0.1 * float(np.abs(robot.gravity(reference)).max()), 1e-3 * inertia)
    for drive in (NO_DRIVE, Drive(friction, friction, 0.05 * inertia, 2.0 * np.pi)):

        def motion(plant: Plant) -> psp3.Result:
            return psp3.simulate(
                robot,
                psp3.ComputedTorque(robot, 400.0, 40.0),
                PointToPoint(reference, goal, 0.1, robot),
                0.03,
                plant=plant,
            )

        fixed = motion(RungeKutta(robot, drive=drive))
        assert np.abs(fixed.positions[-1] - reference).max() > 1e-3
        for other in (DormandPrince(robot, drive=drive), ConstraintDynamics(robot, drive=drive)):
            np.testing.assert_allclose(
                motion(other).positions, fixed.positions, rtol=0.0, atol=1e-9
            )


def test_a_pose_that_no_loop_allows_ends_every_plant_of_any_robot() -> None:
    """The cranks of the five-bar are torn apart."""
    robot = psp3.load("five_bar")
    for plant in (RungeKutta(robot), DormandPrince(robot)):
        plant.start(robot.reference, np.zeros(2))
        states = [plant.advance(np.array([-1e3, 1e3]), 0.05) for _ in range(3)]
        assert states[-1] is None


@pytest.mark.parametrize(
    "build",
    [
        lambda: RungeKutta(ROBOT, 0),
        lambda: RungeKutta(ROBOT, 1.5),
        lambda: DormandPrince(ROBOT, -1.0),  # type: ignore[arg-type]
        lambda: ConstraintDynamics(ROBOT, np.nan),
        lambda: ConstraintDynamics(ROBOT, steps=0),
        lambda: RungeKutta(ROBOT, drive=[DRIVE]),
        lambda: DormandPrince(ROBOT, drive=None),
        lambda: ConstraintDynamics(ROBOT, drive=5.0),
    ],  # type: ignore[arg-type]
)
def test_bad_settings_are_refused(build: object) -> None:
    with pytest.raises(InvalidValue):
        build()  # type: ignore[operator]
