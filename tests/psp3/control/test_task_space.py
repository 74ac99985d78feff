"""Computed torque on a frame.

Its error dynamics, its singular border, and that it is computed torque on the path.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.integrate import solve_ivp

import psp3
from psp3.control.task_space import TaskSpaceComputedTorque, damped_reciprocals
from psp3.errors import InvalidValue, PSP3Error, UnknownName
from psp3.kinematics.frames import FrameMotion, frame_motion, point_motion
from psp3.simulation.runge_kutta import RungeKutta
from psp3.trajectories import Hold, Motion, PointToPoint
from tests.helpers import Array

ROBOT = psp3.load()
REACH = float(ROBOT.tip_reach(0.0))
HEIGHT = ROBOT.parameters.tool_length
TASKS = {
    "psp3": ("x", "y", "z"),
    "five_bar": ("x", "z"),
    "planar_3rrr": ("x", "y", "rz"),
    "delta": ("x", "y", "z"),
    "gough_stewart": ("x", "y", "z", "rx", "ry", "rz"),
    "tricept": ("x", "y", "z"),
}
"""As many coordinates of the tip as each robot has motors."""

NOWHERE = Motion(*np.full((4, 3), np.nan))
"""Desired motion of the joints for a controller that has a path of its own."""


def nearby(
    robot: psp3.ClosedLoopRobot, rng: np.random.Generator, size: float
) -> tuple[Array, Array]:
    """Return positions and speeds near the reference pose."""
    n = len(robot.actuated)
    return robot.reference + rng.uniform(-size, size, n), rng.uniform(-1.0, 1.0, n) * 10.0 * size


def sampled(
    controller: TaskSpaceComputedTorque, tip: Array, duration: float, period: float = 0.002
) -> tuple[Array, Array, Array]:
    """Let the 3-PSP start at rest with its tip at a point.

    Return the tips, the screw forces less the weight, and the last heights.
    """
    plant, heights, speeds = RungeKutta(ROBOT), ROBOT.inverse_kinematics_tip(tip), np.zeros(3)
    plant.start(heights, speeds)
    tips, forces = np.empty((2, round(duration / period), 3))
    for k in range(len(tips)):
        force = controller.torque(k * period, heights, speeds, NOWHERE)
        tips[k], forces[k] = ROBOT.forward_kinematics(heights).tip, force - ROBOT.gravity(heights)
        state = plant.advance(force, period)
        assert isinstance(state, tuple)
        heights, speeds = np.array(state[0]), np.array(state[1])
    return tips, forces, heights


def toward(azimuth: float, radius: float) -> Array:
    return np.array([radius * np.cos(azimuth), radius * np.sin(azimuth), HEIGHT])


def to_and_fro(
    radius: float, azimuth: float = 0.0, rate: float = np.pi
) -> Callable[[float], FrameMotion]:
    """Return a straight path through the axis: the tip swings out to a radius and back."""
    ray = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])

    def path(t: float) -> FrameMotion:
        s, c = radius * np.sin(rate * t), radius * np.cos(rate * t)
        return point_motion(s * ray + [0.0, 0.0, HEIGHT], rate * c * ray, -(rate**2) * s * ray)

    return path


# Error dynamics


@pytest.mark.parametrize("name", TASKS)
def test_error_obeys_its_second_order_equation(name: str) -> None:
    r"""At random states, by forward dynamics.

    :math:`\ddot x = \ddot x_d + k_v \dot e + k_p e` to 1e-7 of accelerations of up to 10.
    """
    robot, rng = psp3.load(name), np.random.default_rng(0)
    controller = TaskSpaceComputedTorque(robot, kp=25.0, kv=4.0, task=TASKS[name])
    rows = controller.space.rows
    for _ in range(5):
        (positions, speeds), (goal, goal_speeds) = (
            nearby(robot, rng, 0.03),
            nearby(robot, rng, 0.03),
        )
        goal_accelerations = rng.normal(size=len(robot.actuated))
        desired = frame_motion(robot, goal, goal_speeds, goal_accelerations)
        torque = controller.torque(
            0.0,
            positions,
            speeds,
            Motion(goal, goal_speeds, goal_accelerations, desired.placement[:3, 3]),
        )
        here = frame_motion(
            robot, positions, speeds, robot.forward_dynamics(positions, speeds, torque)
        )
        error = controller.space.error(desired.placement, here.placement)
        expected = (
            desired.acceleration[rows]
            + 4.0 * (desired.velocity - here.velocity)[rows]
            + 25.0 * error
        )
        assert_allclose(here.acceleration[rows], expected, atol=1e-7)
        assert np.abs(here.acceleration[rows]).max() > 0.1


@pytest.mark.parametrize(
    ("name", "offset"), [("psp3", [0.004, -0.006, 0.01]), ("planar_3rrr", [0.02, -0.01, 0.3])]
)
def test_error_dies_out_as_the_oscillator_does(name: str, offset: list[float]) -> None:
    """Started off a resting goal, at rest.

    The closed form of a damped oscillator, 1e-6 of the offset; DOP853 at 1e-10.

    Of the planar robot one coordinate is an angle, about a fixed axis.
    """
    robot = psp3.load(name)
    kp, kv = 30.0, 3.0
    rest = np.zeros(len(robot.actuated))
    goal = frame_motion(robot, robot.reference, rest, rest)
    controller = TaskSpaceComputedTorque(robot, kp, kv, path=lambda t: goal, task=TASKS[name])
    space, n = controller.space, len(rest)
    start = robot.reference.copy()
    for _ in range(20):
        # Newton's method for the pose that is off by the offset.
        left = space.error(robot.frame_placement(start, "tip"), goal.placement) - offset
        start -= np.linalg.solve(space.jacobian(start), left)

    def rates(t: float, state: Array) -> Array:
        torque = controller.torque(t, state[:n], state[n:], NOWHERE)
        return np.concatenate([state[n:], robot.forward_dynamics(state[:n], state[n:], torque)])

    times = np.linspace(0.0, 0.8, 5)
    solution = solve_ivp(
        rates,
        (0.0, 0.8),
        np.concatenate([start, rest]),
        method="DOP853",
        t_eval=times,
        rtol=1e-10,
        atol=1e-12,
    )
    damping, frequency = 0.5 * kv, np.sqrt(kp - 0.25 * kv**2)
    fading = np.exp(-damping * times) * (
        np.cos(frequency * times) + damping / frequency * np.sin(frequency * times)
    )
    for state, share in zip(solution.y.T, fading, strict=True):
        error = space.error(robot.frame_placement(state[:n], "tip"), goal.placement)
        assert_allclose(error, share * np.array(offset), atol=1e-6 * np.abs(offset).max())


def test_orientation_and_position_of_a_platform_come_to_rest_at_the_goal() -> None:
    """Six coordinates of a Gough–Stewart platform, 0.2 rad about an oblique axis.

    Critically damped, 1e-3 of it is left after 0.95 s.
    """
    robot = psp3.load("gough_stewart")
    rest = np.zeros(6)
    goal = frame_motion(robot, robot.reference, rest, rest)
    controller = TaskSpaceComputedTorque(
        robot, 100.0, 20.0, path=lambda t: goal, task=TASKS["gough_stewart"]
    )
    space, offset = controller.space, np.array([0.02, -0.03, 0.02, 0.1, -0.1, 0.14])
    start = robot.reference.copy()
    for _ in range(20):
        start -= 0.7 * np.linalg.solve(
            space.jacobian(start),
            space.error(robot.frame_placement(start, "tip"), goal.placement) - offset,
        )
    size = np.abs(space.error(robot.frame_placement(start, "tip"), goal.placement))

    def rates(t: float, state: Array) -> Array:
        torque = controller.torque(t, state[:6], state[6:], NOWHERE)
        return np.concatenate([state[6:], robot.forward_dynamics(state[:6], state[6:], torque)])

    end = solve_ivp(rates, (0.0, 0.95), np.concatenate([start, rest]), rtol=1e-5, atol=1e-7).y[
        :6, -1
    ]
    left = np.abs(space.error(goal.placement, robot.frame_placement(end, "tip")))
    assert size[3:].max() > 0.1
    # (1 + ωt) exp(−ωt) at ωt = 9.5.
    assert left.max() < 1.1 * 7.9e-4 * size.max()


def test_on_the_path_it_is_computed_torque_in_joint_space() -> None:
    """Without an error both feed the same motion forward, to rounding."""
    helix = psp3.trajectories.Helix(robot=ROBOT)
    joints, task = (
        psp3.ComputedTorque(ROBOT, 100.0, 20.0),
        TaskSpaceComputedTorque(ROBOT, 100.0, 20.0),
    )
    for t in (0.1, 0.7, 1.3):
        now = helix(t)
        assert_allclose(
            task.torque(t, now.heights, now.speeds, now),
            joints.torque(t, now.heights, now.speeds, now),
            atol=1e-9,
        )


def test_near_a_resting_goal_it_is_computed_torque_in_joint_space() -> None:
    """There the tip's error is J times that of the heights, up to squares.

    A tenth of the error leaves a hundredth of the difference.
    """
    joints, task = (
        psp3.ComputedTorque(ROBOT, 100.0, 20.0),
        TaskSpaceComputedTorque(ROBOT, 100.0, 20.0),
    )
    rng = np.random.default_rng(0)
    for tip in ([0.01, 0.005, HEIGHT], [-0.02, 0.01, 0.1]):
        goal = Hold(tip, ROBOT)(0.0)
        off, rate = rng.uniform(-1.0, 1.0, (2, 3)) * [[1e-3], [1e-2]]
        states = [(goal.heights + size * off, size * rate) for size in (1.0, 0.1)]
        large, small = (
            np.linalg.norm(task.torque(0.0, *state, goal) - joints.torque(0.0, *state, goal))
            for state in states
        )
        assert large / small == pytest.approx(100.0, rel=0.1)


def test_it_follows_the_helix_in_a_simulation() -> None:
    """Started at rest: of an initial error of speed of 63 mm/s nothing is left.

    After 1.3 s there is only what comes of holding a force for 2 ms.
    """
    helix = psp3.trajectories.Helix(robot=ROBOT)
    result = psp3.simulate(ROBOT, TaskSpaceComputedTorque(ROBOT, 100.0, 20.0), helix, 1.5)
    assert np.linalg.norm(result.tip - result.desired.tip, axis=1)[-100:].max() < 3e-5
    assert np.linalg.norm(result.tip - result.desired.tip, axis=1).max() > 1e-3


# Damping


def test_nothing_is_damped_away_from_the_border() -> None:
    """Where the smallest singular value is above the threshold, bit for bit.

    On the helix it is 2.4 times the threshold.
    """
    helix = psp3.trajectories.Helix(robot=ROBOT)
    damped, plain = TaskSpaceComputedTorque(ROBOT), TaskSpaceComputedTorque(ROBOT, damped_below=0.0)
    for t in np.linspace(0.0, 2.0, 9):
        now = helix(t)
        least = np.linalg.svd(ROBOT.tip_jacobian(now.heights), compute_uv=False)[-1]
        assert least > 2.4 * damped.threshold
        assert_array_equal(
            damped.torque(t, now.heights, now.speeds, now),
            plain.torque(t, now.heights, now.speeds, now),
        )


def test_threshold_of_the_3_psp() -> None:
    """At home, a unit of nut speed tilts the star by √(2/3)/d, and the tip moves h times as fast.

    15 % of that.
    """
    d = ROBOT.parameters.screw_radius
    assert TaskSpaceComputedTorque(ROBOT).threshold == pytest.approx(
        0.15 * np.sqrt(2.0 / 3.0) * HEIGHT / d, rel=1e-12
    )


def test_damped_reciprocals() -> None:
    r"""The reciprocal from the threshold on, with a continuous slope; σ/λ² at zero.

    At most 1.0664/ε, where 3s⁴ − s² = 1 for s = σ/ε.
    """
    epsilon = 0.05
    above = np.linspace(epsilon, 1.0, 50)
    assert_array_equal(damped_reciprocals(above, epsilon), 1.0 / above)
    step = 1e-6
    slope = (
        damped_reciprocals(epsilon, epsilon) - damped_reciprocals(epsilon - step, epsilon)
    ) / step
    assert slope == pytest.approx(-1.0 / epsilon**2, rel=1e-3)
    assert damped_reciprocals(0.0, epsilon) == 0.0
    assert damped_reciprocals(1e-9, epsilon) == pytest.approx(1e-9 / epsilon**2)
    s = np.sqrt((1.0 + np.sqrt(13.0)) / 6.0)
    largest = s / (1.0 - s**2 + s**4) / epsilon
    assert largest == pytest.approx(1.0664 / epsilon, rel=1e-4)
    assert damped_reciprocals(np.linspace(0.0, 0.2, 20_001), epsilon).max() == pytest.approx(
        largest, rel=1e-6
    )
    assert np.isinf(damped_reciprocals(0.0, 0.0))


def test_forces_are_continuous_across_the_threshold_and_the_fold() -> None:
    """Along a ray out, at a given speed and servo command.

    Four times finer steps change the forces by a fourth.
    """
    controller = TaskSpaceComputedTorque(ROBOT, path=lambda t: point_motion([0.03, 0.0, HEIGHT]))

    def largest_change(count: int) -> float:
        tilt = np.radians(np.linspace(32.0, 40.0, count))
        rows = ROBOT.inverse_kinematics(0.0, tilt, 0.0)
        speeds = 0.5 * np.gradient(rows, tilt, axis=0)
        forces = np.array(
            [controller.torque(0.0, a, v, NOWHERE) for a, v in zip(rows, speeds, strict=True)]
        )
        return float(np.abs(np.diff(forces, axis=0)).max())

    assert largest_change(1601) / largest_change(401) == pytest.approx(0.25, rel=0.1)


# The border


def test_a_path_to_within_a_tenth_of_a_millimeter_of_the_fold() -> None:
    """Started at rest, so off the path.

    The damped law stays on this side, at less than 60 N beside the weight; the plain one runs off.
    """
    path = to_and_fro(REACH - 1e-4)
    tips, forces, _ = sampled(
        TaskSpaceComputedTorque(ROBOT, 25.0, 3.0, path=path), toward(0.0, 0.0), 4.0
    )
    assert np.abs(forces).max() < 60.0
    assert np.linalg.norm(tips[-1] - path(3.998).placement[:3, 3]) < 1e-3
    assert tips[:, 0].max() <= REACH
    with pytest.raises(PSP3Error):
        sampled(
            TaskSpaceComputedTorque(ROBOT, 25.0, 3.0, path=path, damped_below=0.0),
            toward(0.0, 0.0),
            4.0,
        )


def test_forces_at_the_fold_are_bounded() -> None:
    """A path that touches the fold itself at t = 0.5 s and 2.5 s.

    Plain inversion takes twenty times the force.
    """
    path, largest = to_and_fro(REACH), {}
    for share in (0.15, 0.0):
        controller = TaskSpaceComputedTorque(ROBOT, 100.0, 20.0, path=path, damped_below=share)
        _, forces, _ = sampled(controller, toward(0.0, 0.0), 2.6)
        largest[share] = np.abs(forces).max()
    assert largest[0.15] < 60.0
    assert largest[0.0] > 20.0 * largest[0.15]


def test_along_the_border_the_bend_of_the_border_counts() -> None:
    """A fast motion along the border, below half of the threshold, with the goal outside.

    There the law asks that the smallest singular value s of the tip's Jacobian, a pure number for
    three screws and three coordinates, obey s'' = -2 w s' - w² (s - floor), w² = kp. s'' is taken
    from s itself along the motion: differences in steps of 1 ms, with the closed form's Jacobian
    and accelerations.
    """
    controller = TaskSpaceComputedTorque(
        ROBOT, 100.0, 20.0, path=lambda _: point_motion(toward(0.3, REACH + 0.01))
    )
    azimuth, omega = 0.3, 10.0

    def smallest(heights: Array) -> float:
        return float(np.linalg.svd(ROBOT.tip_jacobian(heights), compute_uv=False)[-1])

    outward = ROBOT.inverse_kinematics_tip(
        toward(azimuth, float(ROBOT.tip_reach(azimuth)) * (1.0 - 2e-3))
    )
    inward = ROBOT.inverse_kinematics_tip(toward(azimuth, 0.8 * REACH))
    goal, low, high = 0.4 * controller.threshold, outward, inward
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if smallest(middle) < goal else (low, middle)
    heights = 0.5 * (low + high)
    step = 1e-5
    gradient = np.array(
        [(smallest(heights + h) - smallest(heights - h)) / (2.0 * step) for h in step * np.eye(3)]
    )
    # Along the border and a little inward, so that it need not brake.
    along = np.cross(gradient, [1.0, 1.0, 1.0])
    speeds = 0.3 * along / np.linalg.norm(along) + 1e-3 * gradient / np.linalg.norm(gradient)
    force = controller.torque(0.0, heights, speeds, NOWHERE)
    accelerations = ROBOT.forward_dynamics(heights, speeds, force)
    time = 1e-3
    values = [
        smallest(heights + t * speeds + 0.5 * t**2 * accelerations) for t in (-time, 0.0, time)
    ]
    rate, second = (values[2] - values[0]) / (2.0 * time), np.diff(values, 2)[0] / time**2
    wanted = -2.0 * omega * rate - omega**2 * (values[1] - 0.25 * controller.threshold)
    bend = np.diff([smallest(heights + t * speeds) for t in (-time, 0.0, time)], 2)[0] / time**2
    assert rate > 0.0
    assert abs(bend) > 0.5 * abs(wanted)
    assert second == pytest.approx(wanted, abs=0.02 * abs(bend))


@pytest.mark.parametrize("azimuth", np.radians([0.0, 25.0, 120.0, 200.0]))
def test_beyond_the_fold_the_tip_stops_at_the_border_and_comes_back(azimuth: float) -> None:
    """A goal 5 mm out of reach: the tip comes to rest within 0.15 mm of the border.

    With the goal inside again it goes there, to 1 µm.

    It does so on the branch connected to home: the inverse kinematics has the same heights.
    """
    reach = float(ROBOT.tip_reach(azimuth))
    goal = {False: toward(azimuth, reach + 0.005), True: toward(azimuth, 0.01)}
    controller = TaskSpaceComputedTorque(
        ROBOT, 100.0, 20.0, path=lambda t: point_motion(goal[t >= 1.2])
    )
    tips, forces, heights = sampled(controller, toward(azimuth, 0.015), 3.2, 0.004)
    last = tips[299]
    border = ROBOT.tip_reach(np.arctan2(last[1], last[0]))
    assert border - 1.5e-4 < np.hypot(last[0], last[1]) <= border
    assert np.linalg.norm(last - tips[280]) < 1e-5
    assert np.linalg.norm(tips[-1] - goal[True]) < 1e-6
    assert_allclose(ROBOT.inverse_kinematics_tip(tips[-1]), heights, atol=1e-6)
    assert np.abs(forces).max() < 500.0


def test_a_fast_push_beyond_the_fold_does_not_get_through() -> None:
    """Underdamped gains and a path 2 mm out of reach at 80 mm/s.

    The star stays on this side, where det J > 0.
    """
    controller = TaskSpaceComputedTorque(ROBOT, 10.0, 1.0, path=to_and_fro(REACH + 0.002))
    signs = []
    inner = controller.torque

    def watched(t: float, heights: Array, speeds: Array, desired: Motion) -> Array:
        signs.append(np.linalg.det(ROBOT.tip_jacobian(heights)))
        return inner(t, heights, speeds, desired)

    controller.torque = watched  # type: ignore[method-assign]
    _, forces, _ = sampled(controller, toward(0.0, 0.0), 4.0)
    assert min(signs) > 0.0
    assert np.abs(forces).max() < 300.0


def test_in_a_simulation_it_needs_no_reachable_path_of_its_own() -> None:
    """The simulation checks the trajectory; where the tip shall go is the controller's."""
    controller = TaskSpaceComputedTorque(
        ROBOT, 100.0, 20.0, path=lambda t: point_motion([0.02, 0.0, HEIGHT])
    )
    result = psp3.simulate(ROBOT, controller, Hold(robot=ROBOT), 2.0)
    # (1 + ωt) exp(−ωt) at ωt = 20 of 20 mm is 1e-9 m.
    assert_allclose(result.tip[-1], [0.02, 0.0, HEIGHT], atol=1e-8)


def test_another_robot_in_a_simulation() -> None:
    """The Delta, driven at its tip along a motion of its joints, from rest off the path."""
    robot = psp3.load("delta")
    path = PointToPoint(robot.reference, robot.reference + np.array([0.1, -0.05, 0.08]), 0.3, robot)
    result = psp3.simulate(
        robot,
        TaskSpaceComputedTorque(robot, 400.0, 40.0),
        path,
        0.5,
        initial_positions=robot.reference + 0.02,
    )
    left = np.linalg.norm(result.tip - result.desired.tip, axis=1)
    assert left[0] > 1e-3
    # (1 + ωt) exp(−ωt) at ωt = 10 of the start is 5e-4.
    assert left[-1] < 1e-3 * left[0]


# What is refused


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ({"kp": -1.0}, InvalidValue, "kp"),
        ({"kv": np.nan}, InvalidValue, "kv"),
        ({"damped_below": -0.1}, InvalidValue, "damped_below"),
        ({"damped_below": 1.0}, InvalidValue, "below 1"),
        ({"task": ("x", "y")}, InvalidValue, "as many coordinates"),
        ({"task": ("x", "y", "w")}, UnknownName, "'w'"),
        ({"task": ("x", "y", "rz")}, InvalidValue, "determine the pose"),
        ({"frame": "tool"}, UnknownName, "'tool'"),
    ],
)
def test_bad_arguments_are_refused(
    arguments: dict[str, object], error: type[Exception], words: str
) -> None:
    with pytest.raises(error, match=words):
        TaskSpaceComputedTorque(ROBOT, **arguments)


def test_a_plane_that_the_robot_cannot_leave_is_refused() -> None:
    """The five-bar moves in x and z."""
    with pytest.raises(InvalidValue, match="determine the pose"):
        TaskSpaceComputedTorque(psp3.load("five_bar"), task=("x", "y"))
