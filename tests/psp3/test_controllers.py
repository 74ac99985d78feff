"""Controllers against the equations they implement, written out with Pinocchio's model, and against the error dynamics they promise."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

import psp3
from psp3.errors import InvalidValue
from psp3.second_order import MassSpringDamper
from psp3.trajectories import Helix, Hold, Motion

ROBOT = psp3.load("psp3")
PINOCCHIO = ROBOT.dynamics("pinocchio")
RNG = np.random.default_rng(5)


def states(count: int) -> list[tuple[np.ndarray, np.ndarray, Motion]]:
    helix = Helix(robot=ROBOT)
    return [
        (RNG.uniform(-0.1, 0.1, 3), RNG.normal(size=3), helix(float(t)))
        for t in RNG.uniform(0.0, 10.0, count)
    ]  # fmt: skip


def test_feed_forward_is_the_inverse_dynamics_of_the_desired_motion() -> None:
    """Pinocchio's RNEA of the same motion; 1e-9 relative is the bar between the two models."""
    for heights, speeds, desired in states(5):
        torque = psp3.FeedForward(ROBOT).torque(0.0, heights, speeds, desired)
        np.testing.assert_allclose(torque, PINOCCHIO.inverse_dynamics(desired.heights, desired.speeds, desired.accelerations), rtol=1e-9)


def test_pd_and_gravity_and_pid_are_their_equations() -> None:
    for heights, speeds, desired in states(5):
        feedback = np.array([1000.0 * (desired.heights[k] - heights[k]) + 100.0 * (desired.speeds[k] - speeds[k]) for k in range(3)])
        np.testing.assert_allclose(psp3.PD().torque(0.0, heights, speeds, desired), feedback, rtol=1e-15)
        compensated = psp3.GravityCompensatedPD(ROBOT).torque(0.0, heights, speeds, desired)
        np.testing.assert_allclose(compensated - feedback, PINOCCHIO.gravity(heights), rtol=1e-9)
        np.testing.assert_allclose(psp3.PID().torque(0.0, heights, speeds, desired), feedback, rtol=1e-15)


@pytest.mark.parametrize("name", ["closed_form", "pinocchio", "noc"])
def test_computed_torque_makes_the_robot_a_unit_mass(name: str) -> None:
    """Pinocchio's constraintDynamics under the torque must accelerate as the servo asks (eq. 4.17); 1e-8 is that engine's bar."""
    controller = psp3.ComputedTorque(ROBOT.dynamics(name), 10.0, 1.0)
    for heights, speeds, desired in states(3):
        torque = controller.torque(0.0, heights, speeds, desired)
        servo = desired.accelerations + (desired.speeds - speeds) + 10.0 * (desired.heights - heights)
        np.testing.assert_allclose(PINOCCHIO.forward_dynamics(heights, speeds, torque), servo, rtol=1e-8, atol=1e-8)


def test_computed_torque_takes_any_model_that_offers_m_c_and_g() -> None:
    class ThreeMethods:
        mass_matrix, coriolis_matrix, gravity = PINOCCHIO.mass_matrix, PINOCCHIO.coriolis_matrix, PINOCCHIO.gravity

    heights, speeds, desired = states(1)[0]
    torque = psp3.ComputedTorque(ThreeMethods()).torque(0.0, heights, speeds, desired)  # type: ignore[arg-type]
    np.testing.assert_allclose(torque, psp3.ComputedTorque(ROBOT).torque(0.0, heights, speeds, desired), rtol=1e-9)
    with pytest.raises(InvalidValue, match="mass_matrix"):
        psp3.ComputedTorque(object())  # type: ignore[arg-type]


@pytest.mark.parametrize(("kp", "kv"), [(10.0, 1.0), (100.0, 20.0)])
def test_error_under_computed_torque_obeys_its_linear_equation(kp: float, kv: float) -> None:
    """Solve ë + kv ė + kp e = 0 by the matrix exponential.

    A held torque lags by half a period, an error of first order in
    it, which Richardson's extrapolation of two periods removes; 2e-7 m, 1e-5 of the error, is what second order leaves.
    """
    helix = Helix(robot=ROBOT)
    runs = [psp3.simulate(ROBOT, psp3.ComputedTorque(ROBOT, kp, kv), helix, 1.0, period=period) for period in (4e-4, 2e-4)]
    coarse, fine = ((run.desired.heights - run.heights)[::every] for run, every in zip(runs, (250, 500), strict=True))
    initial = np.stack([np.zeros(3), helix(0.0).speeds])
    exact = np.array([(expm(np.array([[0.0, 1.0], [-kp, -kv]]) * t) @ initial)[0] for t in runs[1].t[::500]])
    np.testing.assert_allclose(2.0 * fine - coarse, exact, atol=2e-7)


def test_critical_damping_is_that_of_chapter_4() -> None:
    controller = psp3.ComputedTorque.critically_damped(ROBOT, kp=25.0)
    assert controller.kv == 10.0
    assert MassSpringDamper(mass=1.0, damping=controller.kv, stiffness=controller.kp).damping_case.name == "CRITICALLY_DAMPED"


def test_pd_sags_by_the_weight_over_its_gain_and_the_others_do_not() -> None:
    """The equilibrium kp·e = G, solved by fixed-point iteration; 10 s are 50 time constants, what is left is below 1e-9 m."""
    hold = Hold(robot=ROBOT)
    target = hold(0.0).heights
    sagged = target.copy()
    for _ in range(50):
        sagged = target - ROBOT.gravity(sagged) / 1000.0
    pd = psp3.simulate(ROBOT, psp3.PD(), hold, 10.0)
    np.testing.assert_allclose(pd.heights[-1], sagged, atol=1e-9)
    compensated = psp3.simulate(ROBOT, psp3.GravityCompensatedPD(ROBOT), hold, 2.0, initial_heights=target + 0.01)
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
    np.testing.assert_allclose(torque, [-np.trapezoid(times, times), -np.trapezoid(times**2, times), 0.0], atol=1e-15)


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
