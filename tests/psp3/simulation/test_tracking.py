"""The simulation loop: what it records, when it stops, and that nothing simulated is lost."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import psp3
from psp3.drives import Drive
from psp3.errors import (
    ClosureFailed,
    InvalidArray,
    InvalidTorque,
    InvalidValue,
    SimulationDiverged,
    StrokeExceeded,
    UnreachablePose,
    UnreachableTip,
)
from psp3.simulation.constraint_dynamics import ConstraintDynamics
from psp3.simulation.runge_kutta import RungeKutta
from psp3.trajectories import Helix, Hold, Motion, PointToPoint
from tests.helpers import four_bar_closed_with_3d
from tests.psp3.simulation.controllers import Recording

ROBOT = psp3.load("psp3")

HELIX = Helix(robot=ROBOT)


def test_zero_order_hold_by_hand() -> None:
    """The same loop written out with the plant alone gives the very same numbers."""
    controller = Recording()
    result = psp3.simulate(ROBOT, controller, HELIX, 0.02)
    plant = RungeKutta(ROBOT)
    plant.start(HELIX(0.0).heights, np.zeros(3))
    state = (HELIX(0.0).heights, np.zeros(3))
    for k, (t, heights, speeds, desired) in enumerate(controller.calls):
        assert t == pytest.approx(0.002 * k, abs=1e-15)
        np.testing.assert_array_equal(heights, state[0])
        np.testing.assert_array_equal(speeds, state[1])
        np.testing.assert_array_equal(desired.heights, HELIX(0.002 * k).heights)
        np.testing.assert_array_equal(result.heights[k], state[0])
        np.testing.assert_array_equal(result.torque[k], [80.0, 85.0, 90.0])
        advanced = plant.advance(np.array([80.0, 85.0, 90.0]), 0.002)
        assert advanced is not None
        state = tuple(array.copy() for array in advanced)
    assert len(controller.calls) == 11
    assert controller.resets == 1
    assert result.t.shape == (11,)
    np.testing.assert_array_equal(result.tip, ROBOT.forward_kinematics(result.heights).tip)


def test_thesis_comparison_lands_where_the_design_says() -> None:
    """PD 4.66 and CTC 0.0185 at one sample per 0.05 s were found by an independent simulation.

    1 % covers their rounding.
    """
    from psp3.simulation.metrics import integral_of_squared_error, sum_of_squared_errors

    pd = psp3.simulate(ROBOT, psp3.PD(), HELIX, 10.4)
    ctc = psp3.simulate(ROBOT, psp3.ComputedTorque(ROBOT), HELIX, 10.4)
    assert sum_of_squared_errors(pd) == pytest.approx(4.66, rel=0.01)
    assert sum_of_squared_errors(ctc) == pytest.approx(0.0185, rel=0.01)
    # The sag alone: 0.0225 m² (T − 0.106 s), a formula of the same source.
    assert integral_of_squared_error(pd) == pytest.approx(0.0225 * (10.4 - 0.106), rel=0.01)


def test_computed_torque_started_on_the_path_has_no_error_but_that_of_the_hold() -> None:
    """The held torque lags by half a period.

    That is an acceleration error of jerk · T/2. The helix turns at 3.14 rad/s, the servo's natural
    frequency is 3.16: the error is that over kv · 3.14, 0.5 mm at 2 ms, and proportional to the
    period.
    """
    errors = []
    for period in (0.002, 0.0002):
        result = psp3.simulate(
            ROBOT, psp3.ComputedTorque(ROBOT), HELIX, 2.0, period, initial_speeds=HELIX(0.0).speeds
        )
        errors.append(np.abs(result.desired.heights - result.heights).max())
    assert errors[0] < 7e-4
    assert errors[1] < 0.105 * errors[0]


def test_ten_point_four_seconds_are_five_thousand_two_hundred_periods() -> None:
    result = psp3.simulate(ROBOT, psp3.PD(), HELIX, 10.4)
    assert result.t.size == 5201
    assert result.t[-1] == pytest.approx(10.4, abs=1e-12)
    assert psp3.simulate(ROBOT, psp3.PD(), HELIX, 0.01, period=0.003).t.size == 4


def test_energy_is_kept_through_the_simulation_loop() -> None:
    """Without gravity and forces the energy is kept.

    Relative speeds below 0.1 m/s, RK4 at 1 ms: kinetic energy of the relative motion drifts by less
    than 1e-9 of itself in 2 s. A held torque cannot carry a weight that changes, so gravity is off.
    """
    weightless = psp3.load("psp3", psp3.Parameters(gravity=0.0))
    result = psp3.simulate(
        weightless,
        Recording(np.zeros(3)),
        Hold(robot=weightless),
        2.0,
        0.001,
        initial_positions=[0.02, -0.03, 0.05],
        initial_speeds=[0.06, -0.05, -0.01],
    )
    energy = weightless.kinetic_energy(result.heights, result.speeds)
    mean = (
        result.speeds[0] @ weightless.mass_matrix(result.heights[0]).sum(axis=0)
    ) / weightless.parameters.total_mass
    relative = energy[0] - 0.5 * weightless.parameters.total_mass * mean**2
    assert np.abs(energy - energy[0]).max() < 1e-9 * relative
    assert np.ptp(result.heights @ [1.0, -1.0, 0.0]) > 0.05


def test_torque_limit_clips_what_the_plant_gets() -> None:
    result = psp3.simulate(
        ROBOT,
        Recording((300.0, -300.0, 86.0)),
        Hold(robot=ROBOT),
        0.01,
        torque_limit=[100.0, 90.0, 50.0],
    )
    np.testing.assert_array_equal(result.torque, np.tile([100.0, -90.0, 50.0], (6, 1)))


def test_divergence_carries_state_torque_and_what_was_simulated() -> None:
    with pytest.raises(SimulationDiverged, match=r"ran off its screw at t = 0\.\d+ s") as caught:
        psp3.simulate(ROBOT, Recording((500.0, 500.0, 500.0)), Hold(robot=ROBOT), 5.0)
    error = caught.value
    assert isinstance(error, psp3.PSP3Error)
    assert error.heights.max() > 0.4
    np.testing.assert_array_equal(error.torque, [500.0, 500.0, 500.0])
    assert error.result.t[-1] == pytest.approx(error.time - 0.002)
    # Free flight under constant force, until the stroke ends: x = (F/m − g) t²/2.
    acceleration = 1500.0 / ROBOT.parameters.total_mass - 9.81
    np.testing.assert_allclose(
        error.result.heights[:, 0], 0.5 * acceleration * error.result.t**2, atol=1e-12
    )
    assert error.time == pytest.approx(np.sqrt(0.8 / acceleration), abs=0.002)


def test_an_impossible_pose_ends_the_simulation() -> None:
    with pytest.raises(SimulationDiverged, match="left the poses") as caught:
        psp3.simulate(ROBOT, Recording((0.0, 1e6, -1e6)), Hold(robot=ROBOT), 1.0, period=0.01)
    assert caught.value.result.t.size == 1


@pytest.mark.parametrize(
    "torque",
    [(np.nan, 0.0, 0.0), (np.inf, -np.inf, 0.0), (1.0, 2.0), "none", None, [[1.0, 2.0, 3.0]]],
)
def test_a_torque_that_is_not_three_finite_numbers_stops_the_run(torque: object) -> None:
    with pytest.raises(InvalidTorque, match="Recording") as caught:
        psp3.simulate(ROBOT, Recording(torque, bad_from=0.0199), Hold(robot=ROBOT), 1.0)
    assert caught.value.time == pytest.approx(0.02)
    assert caught.value.result.t.size == 10
    assert np.isfinite(caught.value.result.torque).all()


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        ({"duration": -1.0}, InvalidValue),
        ({"duration": np.nan}, InvalidValue),
        ({"duration": 0.001}, InvalidValue),
        ({"period": -0.002}, InvalidValue),
        ({"period": 0.0}, InvalidValue),
        ({"torque_limit": -5.0}, InvalidValue),
        ({"torque_limit": [1.0, 2.0]}, InvalidValue),
        ({"encoder_resolution": -1e-6}, InvalidValue),
        ({"encoder_resolution": np.nan}, InvalidValue),
        ({"encoder_resolution": [1e-6, 1e-6]}, InvalidValue),
        ({"encoder_resolution": "fine"}, InvalidArray),
        ({"delay": -1}, InvalidValue),
        ({"delay": 0.5}, InvalidValue),
        ({"delay": True}, InvalidValue),
        ({"trajectory": Hold(robot=psp3.load("five_bar"))}, InvalidValue),
        ({"initial_positions": [0.0, 0.0]}, InvalidArray),
        ({"initial_speeds": [0.0, np.nan, 0.0]}, InvalidArray),
        ({"initial_positions": [0.0, 1.0, -1.0]}, UnreachablePose),
        ({"initial_positions": [0.0, 0.0, 0.5]}, InvalidValue),
        ({"trajectory": Helix(radius=0.030, robot=ROBOT)}, UnreachableTip),
        ({"trajectory": Helix(rise=1.0, robot=ROBOT)}, StrokeExceeded),
    ],
)
def test_bad_arguments_are_refused_before_the_first_step(
    arguments: dict[str, object], error: type[Exception]
) -> None:
    controller = Recording()
    given = {"trajectory": HELIX, "duration": 1.0} | arguments
    with pytest.raises(error) as caught:
        psp3.simulate(ROBOT, controller, **given)  # type: ignore[arg-type]
    assert isinstance(caught.value, psp3.PSP3Error)
    assert controller.calls == []


# Encoders and delay


class Noting(RungeKutta):
    """A plant that writes down the forces that arrive."""

    def start(self, heights: np.ndarray, speeds: np.ndarray) -> None:
        """Begin a new list."""
        self.forces: list[np.ndarray] = []
        super().start(heights, speeds)

    def advance(self, forces: np.ndarray, duration: float) -> tuple[np.ndarray, np.ndarray] | None:
        """Go on, and write the forces down."""
        self.forces.append(forces.copy())
        return super().advance(forces, duration)


@pytest.mark.parametrize("delay", [0, 1, 3, 200])
def test_forces_come_late_and_the_first_one_acts_until_then(delay: int) -> None:
    """The plant gets what was asked for some periods ago, limited; the result says so."""

    class Ramp(Recording):
        def torque(
            self, t: float, heights: np.ndarray, speeds: np.ndarray, desired: Motion
        ) -> np.ndarray:
            return np.array([86.0, 87.0, 88.0]) + 10.0 * t

    plant = Noting(ROBOT)
    result = psp3.simulate(
        ROBOT, Ramp(), Hold(robot=ROBOT), 0.2, delay=delay, torque_limit=87.5, plant=plant
    )
    late = np.maximum(0.002 * (np.arange(101) - delay), 0.0)
    expected = np.minimum(np.array([86.0, 87.0, 88.0]) + 10.0 * late[:, None], 87.5)
    np.testing.assert_allclose(result.torque, expected, rtol=1e-14)
    np.testing.assert_array_equal(plant.forces, result.torque[:-1])


def test_a_delayed_loop_is_the_sampled_system_with_one_more_state() -> None:
    """All nuts together under PD are a mass.

    A linear recursion, written out, with the force of the period before.

    x+ = x + T v + T²/2 a, v+ = v + T a, a = f/m − g; the recursion and the plant round differently,
    1e-12 m.
    """
    kp, kv, T, mass = 3000.0, 150.0, 0.01, ROBOT.parameters.total_mass
    hold = Hold(robot=ROBOT)
    result = psp3.simulate(
        ROBOT, psp3.PD(kp, kv), hold, 2.0, T, initial_positions=[0.05] * 3, delay=1
    )
    x, v, last, rows = 0.05, 0.0, None, []
    for _ in range(201):
        rows.append([x, v])
        asked = -3.0 * (kp * x + kv * v)
        acceleration = (asked if last is None else last) / mass - 9.81
        x, v, last = x + T * v + 0.5 * T**2 * acceleration, v + T * acceleration, asked
    np.testing.assert_allclose(
        result.heights, np.tile(np.array(rows)[:, :1], 3), rtol=0.0, atol=1e-12
    )
    np.testing.assert_allclose(
        result.speeds, np.tile(np.array(rows)[:, 1:], 3), rtol=0.0, atol=1e-11
    )


def test_motor_torques_are_a_limit_and_a_result() -> None:
    """A motor of 0.15 N m at a lead of 10 mm is a force of 94 N.

    The start of this motion takes that.
    """
    drive = Drive(motor_inertia=1e-5, lead=0.010)
    result = psp3.simulate(
        ROBOT,
        psp3.GravityCompensatedPD(ROBOT),
        HELIX,
        0.2,
        initial_positions=HELIX(0.0).heights - 0.02,
        torque_limit=drive.force(0.15),
        plant=RungeKutta(ROBOT, drive=drive),
    )
    torque = drive.motor_torque(result.torque)
    assert torque.max() == pytest.approx(0.15, rel=1e-14)
    np.testing.assert_allclose(torque * 2.0 * np.pi / 0.010, result.torque, rtol=1e-14)


# Any robot


@pytest.mark.parametrize("name", ["five_bar", "gough_stewart"])
def test_any_robot_is_simulated(name: str, tmp_path: Path) -> None:
    """Computed torque started on the path.

    From rest to rest in 0.2 s, of which the first half is simulated.

    The force held for T = 1 ms is wrong by an acceleration of jerk · T/2, which a servo turns into
    an error of that over kp; the quintic's jerk is at most 60 · way/(0.2 s)³. Twice that, as it is
    not constant. The tip is the frame, and the file is that of any result.
    """
    robot = psp3.load(name)
    n, way = len(robot.actuated), 0.03
    path = PointToPoint(robot.reference, robot.reference + way, 0.2, robot)
    result = psp3.simulate(robot, psp3.ComputedTorque(robot, 2500.0, 100.0), path, 0.1, 0.001)
    assert result.positions.shape == result.speeds.shape == result.torque.shape == (101, n)
    error = np.abs(result.positions - result.desired.positions).max()
    assert 0.0 < error < 2.0 * 60.0 * way / 0.2**3 * 0.0005 / 2500.0
    np.testing.assert_allclose(
        result.tip, robot.frame_placement(result.positions, "tip")[:, :3, 3], rtol=0.0, atol=1e-12
    )
    loaded = psp3.load_result(result.save(tmp_path / "run.npz"))
    for field in ("t", "heights", "speeds", "torque", "tip"):
        np.testing.assert_array_equal(getattr(loaded, field), getattr(result, field))
    np.testing.assert_array_equal(loaded.desired.positions, result.desired.positions)


def test_a_robot_without_a_tip_has_none() -> None:
    """A crank that swings freely, against the tree under constraint forces: 1e-9 rad.

    Its energy is kept to 1e-10.
    """
    loop = four_bar_closed_with_3d()
    robot = psp3.ClosedLoopRobot(loop.model, loop.constraint_models, loop.actuated, loop.q0)
    hold = Hold(robot=robot)
    np.testing.assert_array_equal(hold(0.0).positions, robot.reference)
    results = [
        psp3.simulate(robot, Recording(np.zeros(1)), hold, 0.2, plant=plant)
        for plant in (None, ConstraintDynamics(robot))
    ]
    np.testing.assert_allclose(results[0].positions, results[1].positions, rtol=0.0, atol=1e-9)
    assert np.isnan(results[0].tip).all()
    assert np.isnan(results[0].desired.tip).all()
    energy = robot.kinetic_energy(results[0].positions, results[0].speeds) + robot.potential_energy(
        results[0].positions
    )
    assert np.ptp(energy) < 1e-10
    assert np.ptp(results[0].positions) > 0.1


def test_any_robot_stops_where_its_joints_end_and_where_its_loops_cannot_close() -> None:
    robot = psp3.load("five_bar")
    hold = Hold(robot=robot)
    with pytest.raises(SimulationDiverged, match="an actuated joint left its limits") as caught:
        psp3.simulate(robot, Recording((0.5, 0.5)), hold, 2.0)
    assert (caught.value.heights > robot.limits[1]).any()
    assert len(caught.value.result.t) > 10
    with pytest.raises(SimulationDiverged, match="left the poses") as caught:
        psp3.simulate(robot, Recording((-50.0, 50.0)), hold, 2.0)
    assert len(caught.value.result.t) > 1
    with pytest.raises(InvalidTorque, match="2 finite forces"):
        psp3.simulate(robot, Recording((1.0, 1.0, 1.0)), hold, 1.0)
    with pytest.raises(StrokeExceeded):
        psp3.simulate(
            robot,
            Recording((1.0, 1.0)),
            PointToPoint(robot.reference, [-1.6, 0.6], 1.0, robot),
            1.0,
        )
    with pytest.raises(ClosureFailed):
        psp3.simulate(robot, Recording((1.0, 1.0)), hold, 1.0, initial_positions=[-2.5, 2.5])


def test_progress_reports_a_hundred_times() -> None:
    seen: list[float] = []
    psp3.simulate(ROBOT, psp3.PD(), HELIX, 1.0, progress=seen.append)
    np.testing.assert_allclose(seen, 0.01 * np.arange(1, 101), atol=1e-12)
