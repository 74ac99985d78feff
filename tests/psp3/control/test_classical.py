"""Controllers against the equations they implement.

Written out with Pinocchio's model, and against the error dynamics that they promise.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

import psp3
from psp3.control.classical import critically_damped_gains
from psp3.errors import InvalidArray, InvalidValue
from psp3.thesis.chapter_4_systems import MassSpringDamper, critical_damping
from psp3.trajectories import Helix, Hold, Motion
from tests.helpers import derivative

ROBOT = psp3.load("psp3")
PINOCCHIO = ROBOT.dynamics("pinocchio")
RNG = np.random.default_rng(5)


def states(count: int) -> list[tuple[np.ndarray, np.ndarray, Motion]]:
    helix = Helix(robot=ROBOT)
    return [
        (RNG.uniform(-0.1, 0.1, 3), RNG.normal(size=3), helix(float(t)))
        for t in RNG.uniform(0.0, 10.0, count)
    ]


def test_feed_forward_is_the_inverse_dynamics_of_the_desired_motion() -> None:
    """Pinocchio's RNEA of the same motion; 1e-9 relative is the bar between the two models."""
    for heights, speeds, desired in states(5):
        torque = psp3.FeedForward(ROBOT).torque(0.0, heights, speeds, desired)
        np.testing.assert_allclose(
            torque,
            PINOCCHIO.inverse_dynamics(desired.heights, desired.speeds, desired.accelerations),
            rtol=1e-9,
        )


def test_pd_and_gravity_and_pid_are_their_equations() -> None:
    for heights, speeds, desired in states(5):
        feedback = np.array(
            [
                1000.0 * (desired.heights[k] - heights[k]) + 100.0 * (desired.speeds[k] - speeds[k])
                for k in range(3)
            ]
        )
        np.testing.assert_allclose(
            psp3.PD().torque(0.0, heights, speeds, desired), feedback, rtol=1e-15
        )
        compensated = psp3.GravityCompensatedPD(ROBOT).torque(0.0, heights, speeds, desired)
        np.testing.assert_allclose(compensated - feedback, PINOCCHIO.gravity(heights), rtol=1e-9)
        np.testing.assert_allclose(
            psp3.PID().torque(0.0, heights, speeds, desired), feedback, rtol=1e-15
        )


@pytest.mark.parametrize("name", ["closed_form", "pinocchio", "noc"])
def test_computed_torque_makes_the_robot_a_unit_mass(name: str) -> None:
    """Pinocchio's constraintDynamics under the torque must accelerate as the servo asks (eq. 4.17).

    1e-8 is that engine's bar.
    """
    controller = psp3.ComputedTorque(ROBOT.dynamics(name), 10.0, 1.0)
    for heights, speeds, desired in states(3):
        torque = controller.torque(0.0, heights, speeds, desired)
        servo = (
            desired.accelerations + (desired.speeds - speeds) + 10.0 * (desired.heights - heights)
        )
        np.testing.assert_allclose(
            PINOCCHIO.forward_dynamics(heights, speeds, torque), servo, rtol=1e-8, atol=1e-8
        )


def test_computed_torque_takes_any_model_that_offers_m_c_and_g() -> None:
    class ThreeMethods:
        mass_matrix, coriolis_matrix, gravity = (
            PINOCCHIO.mass_matrix,
            PINOCCHIO.coriolis_matrix,
            PINOCCHIO.gravity,
        )

    heights, speeds, desired = states(1)[0]
    torque = psp3.ComputedTorque(
        ThreeMethods()  # type: ignore[arg-type]
    ).torque(0.0, heights, speeds, desired)
    np.testing.assert_allclose(
        torque, psp3.ComputedTorque(ROBOT).torque(0.0, heights, speeds, desired), rtol=1e-9
    )
    with pytest.raises(InvalidValue, match="mass_matrix"):
        psp3.ComputedTorque(object())  # type: ignore[arg-type]


@pytest.mark.parametrize(("kp", "kv"), [(10.0, 1.0), (100.0, 20.0)])
def test_error_under_computed_torque_obeys_its_linear_equation(kp: float, kv: float) -> None:
    """Solve ë + kv ė + kp e = 0 by the matrix exponential.

    A held torque lags by half a period, an error of first order in it, which Richardson's
    extrapolation of two periods removes; 2e-7 m, 1e-5 of the error, is what second order leaves.
    """
    helix = Helix(robot=ROBOT)
    runs = [
        psp3.simulate(ROBOT, psp3.ComputedTorque(ROBOT, kp, kv), helix, 1.0, period=period)
        for period in (4e-4, 2e-4)
    ]
    coarse, fine = (
        (run.desired.heights - run.heights)[::every]
        for run, every in zip(runs, (250, 500), strict=True)
    )
    initial = np.stack([np.zeros(3), helix(0.0).speeds])
    exact = np.array(
        [(expm(np.array([[0.0, 1.0], [-kp, -kv]]) * t) @ initial)[0] for t in runs[1].t[::500]]
    )
    np.testing.assert_allclose(2.0 * fine - coarse, exact, atol=2e-7)


def test_critical_damping_is_that_of_chapter_4() -> None:
    controller = psp3.ComputedTorque.critically_damped(ROBOT, kp=25.0)
    assert controller.kv == 10.0
    assert (
        MassSpringDamper(mass=1.0, damping=controller.kv, stiffness=controller.kp).damping_case.name
        == "CRITICALLY_DAMPED"
    )


def test_pd_sags_by_the_weight_over_its_gain_and_the_others_do_not() -> None:
    """The equilibrium kp·e = G, solved by fixed-point iteration.

    10 s are 50 time constants, what is left is below 1e-9 m.
    """
    hold = Hold(robot=ROBOT)
    target = hold(0.0).heights
    sagged = target.copy()
    for _ in range(50):
        sagged = target - ROBOT.gravity(sagged) / 1000.0
    pd = psp3.simulate(ROBOT, psp3.PD(), hold, 10.0)
    np.testing.assert_allclose(pd.heights[-1], sagged, atol=1e-9)
    compensated = psp3.simulate(
        ROBOT, psp3.GravityCompensatedPD(ROBOT), hold, 2.0, initial_positions=target + 0.01
    )
    assert np.abs(compensated.heights[-1] - target).max() < 1e-6
    pid = psp3.simulate(ROBOT, psp3.PID(), hold, 10.0)
    assert np.abs(pid.heights[-1] - target).max() < 1e-6


def test_pid_forgets_when_it_is_reset() -> None:
    controller, hold = psp3.PID(), Hold(robot=ROBOT)
    first = psp3.simulate(ROBOT, controller, hold, 0.5)
    again = psp3.simulate(ROBOT, controller, hold, 0.5)
    np.testing.assert_array_equal(first.torque, again.torque)


def test_pid_integrates_by_the_trapezoidal_rule() -> None:
    controller, desired = psp3.PID(kp=0.0, kv=0.0, ki=1.0), Hold(robot=ROBOT)(0.0)
    times = np.linspace(0.0, 1.0, 11)
    for t in times:
        torque = controller.torque(float(t), np.array([t, t**2, 0.0]), np.zeros(3), desired)
    np.testing.assert_allclose(
        torque, [-np.trapezoid(times, times), -np.trapezoid(times**2, times), 0.0], atol=1e-15
    )


BAD_GAINS = [
    lambda: psp3.PD(-1.0),
    lambda: psp3.PD(kv=np.nan),
    lambda: psp3.PID(ki=np.inf),
    lambda: psp3.ComputedTorque(ROBOT, kp=-1.0),
    lambda: psp3.ComputedTorque.critically_damped(ROBOT, -1.0),
]


@pytest.mark.parametrize("build", BAD_GAINS)
def test_bad_gains_are_refused(build: object) -> None:
    with pytest.raises(InvalidValue, match="not negative"):
        build()  # type: ignore[operator]


@pytest.mark.parametrize("heights", [np.zeros(3), np.array([0.05, -0.05, 0.02])])
def test_designed_gains_put_all_poles_in_one_place_and_have_the_bandwidth(
    heights: np.ndarray,
) -> None:
    """Of computed torque and of PD with gravity, on the robot's own dynamics.

    The closed loop by differences.

    (s + w)² is the characteristic polynomial of every coordinate, so A + w nilpotent of second
    order, to 1e-7 w²; and the position follows a command of the bandwidth's frequency with 1/√2 of
    its amplitude, to 1e-7.
    """
    bandwidth, mass = 6.0, ROBOT.mass_matrix(heights)
    zero = np.zeros(3)
    start = np.concatenate([heights, zero])
    # With what each turns a command into an acceleration: M⁻¹ kp of PD; computed torque multiplies
    # by M first.
    ctc, pd = (critically_damped_gains(bandwidth, moved) for moved in (1.0, mass))
    for controller, command in (
        (psp3.ComputedTorque(ROBOT, *ctc), ctc[0] * np.eye(3)),
        (psp3.GravityCompensatedPD(ROBOT, *pd), np.linalg.solve(mass, pd[0])),
    ):
        desired = Motion(heights, zero, zero, zero)

        def acceleration(
            x: np.ndarray, controller: psp3.PD = controller, desired: Motion = desired
        ) -> np.ndarray:
            return PINOCCHIO.forward_dynamics(
                x[:3], x[3:], controller.torque(0.0, x[:3], x[3:], desired)
            )

        rows = np.stack(
            [derivative(lambda t, u=unit: acceleration(start + t * u), 2e-3) for unit in np.eye(6)],
            axis=-1,
        )
        A = np.block([[np.zeros((3, 3)), np.eye(3)], [rows]])
        pole = bandwidth / np.sqrt(np.sqrt(2.0) - 1.0)
        shifted = A + pole * np.eye(6)
        np.testing.assert_allclose(shifted @ shifted, 0.0, atol=1e-7 * pole**2)
        response = np.linalg.solve(
            1j * bandwidth * np.eye(6) - A, np.vstack([np.zeros((3, 3)), command])
        )[:3]
        np.testing.assert_allclose(np.abs(response), np.sqrt(0.5) * np.eye(3), atol=1e-7)


def test_designed_gains_are_those_of_chapter_4() -> None:
    kp, kv = critically_damped_gains(2.0)
    assert kv == pytest.approx(critical_damping(kp), rel=1e-15)
    heavy = critically_damped_gains(2.0, 3.0)
    assert heavy == (3.0 * kp, 3.0 * kv)
    np.testing.assert_array_equal(
        critically_damped_gains(2.0, np.diag([3.0, 1.0]))[0], np.diag([3.0 * kp, kp])
    )


def test_a_matrix_of_gains_couples_the_screws() -> None:
    """Row by row; a multiple of the unit matrix is the gain alone."""
    heights, speeds, desired = states(1)[0]
    kp, kv = RNG.uniform(0.0, 100.0, size=(2, 3, 3))
    torque = psp3.PD(kp, kv).torque(0.0, heights, speeds, desired)
    expected = [
        sum(
            kp[i, k] * (desired.heights - heights)[k] + kv[i, k] * (desired.speeds - speeds)[k]
            for k in range(3)
        )
        for i in range(3)
    ]
    np.testing.assert_allclose(torque, expected, rtol=1e-12)
    one, other = psp3.PID(5.0 * np.eye(3), 2.0 * np.eye(3)), psp3.PID(5.0, 2.0)
    np.testing.assert_allclose(
        one.torque(0.0, heights, speeds, desired),
        other.torque(0.0, heights, speeds, desired),
        rtol=1e-15,
    )


@pytest.mark.parametrize(
    "gain",
    [
        np.zeros(3),
        np.zeros((2, 3)),
        np.full((3, 3), np.nan),
        [[1.0, "a"], [0.0, 1.0]],
        np.eye(3) * 1j,
    ],
)
def test_gains_that_are_no_square_matrix_are_refused(gain: object) -> None:
    for build in (
        lambda: psp3.PD(gain),
        lambda: psp3.PD(kv=gain),
        lambda: critically_damped_gains(1.0, gain),
    ):  # type: ignore[arg-type]
        with pytest.raises(InvalidArray):
            build()


@pytest.mark.parametrize("bandwidth", [0.0, -1.0, np.nan, np.inf, "fast"])
def test_a_bandwidth_that_is_none_is_refused(bandwidth: object) -> None:
    with pytest.raises(InvalidValue, match="bandwidth"):
        critically_damped_gains(bandwidth)  # type: ignore[arg-type]
