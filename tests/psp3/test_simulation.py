"""The simulation loop: what it records, when it stops, and that nothing simulated is lost."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import psp3
from psp3.errors import (
    InvalidArray,
    InvalidResultFile,
    InvalidTorque,
    InvalidValue,
    SimulationDiverged,
    StrokeExceeded,
    UnreachablePose,
    UnreachableTip,
)
from psp3.plants import RungeKutta
from psp3.trajectories import Helix, Hold, Motion

ROBOT = psp3.load("psp3")
HELIX = Helix(robot=ROBOT)


class Recording:
    """A controller that writes down what it was given and asks for fixed forces."""

    def __init__(self, torque: object = (80.0, 85.0, 90.0), bad_from: float = np.inf) -> None:
        self.torque_given, self.bad_from = torque, bad_from
        self.calls: list[tuple[float, np.ndarray, np.ndarray, Motion]] = []
        self.resets = 0

    def reset(self) -> None:
        """Count the calls."""
        self.resets += 1

    def torque(self, t: float, heights: np.ndarray, speeds: np.ndarray, desired: Motion) -> object:
        """Write the arguments down and spoil them."""
        self.calls.append((t, heights.copy(), speeds.copy(), desired))
        heights[:] = speeds[:] = np.nan  # what a controller does to its arguments must change nothing
        return self.torque_given if t >= self.bad_from or self.bad_from == np.inf else np.full(3, 87.0)


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
    """PD 4.66 and CTC 0.0185 at one sample per 0.05 s were found by an independent simulation; 1 % covers their rounding."""
    from psp3.metrics import integral_of_squared_error, sum_of_squared_errors

    pd = psp3.simulate(ROBOT, psp3.PD(), HELIX, 10.4)
    ctc = psp3.simulate(ROBOT, psp3.ComputedTorque(ROBOT), HELIX, 10.4)
    assert sum_of_squared_errors(pd) == pytest.approx(4.66, rel=0.01)
    assert sum_of_squared_errors(ctc) == pytest.approx(0.0185, rel=0.01)
    # The sag alone: 0.0225 m² (T − 0.106 s), a formula of the same source.
    assert integral_of_squared_error(pd) == pytest.approx(0.0225 * (10.4 - 0.106), rel=0.01)


def test_computed_torque_started_on_the_path_has_no_error_but_that_of_the_hold() -> None:
    """The held torque lags by half a period.

    That is an acceleration error of jerk · T/2. The helix turns at 3.14 rad/s, the servo's
    natural frequency is 3.16: the error is that over kv · 3.14, 0.5 mm at 2 ms, and proportional to the period.
    """
    errors = []
    for period in (0.002, 0.0002):
        result = psp3.simulate(ROBOT, psp3.ComputedTorque(ROBOT), HELIX, 2.0, period, initial_speeds=HELIX(0.0).speeds)
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

    Relative speeds below 0.1 m/s, RK4 at 1 ms: kinetic energy of the relative motion drifts by
    less than 1e-9 of itself in 2 s. A held torque cannot carry a weight that changes, so gravity is off.
    """
    weightless = psp3.load("psp3", psp3.Parameters(gravity=0.0))
    result = psp3.simulate(
        weightless, Recording(np.zeros(3)), Hold(robot=weightless), 2.0, 0.001,
        initial_heights=[0.02, -0.03, 0.05], initial_speeds=[0.06, -0.05, -0.01],
    )  # fmt: skip
    energy = weightless.kinetic_energy(result.heights, result.speeds)
    mean = (result.speeds[0] @ weightless.mass_matrix(result.heights[0]).sum(axis=0)) / weightless.parameters.total_mass
    relative = energy[0] - 0.5 * weightless.parameters.total_mass * mean**2
    assert np.abs(energy - energy[0]).max() < 1e-9 * relative
    assert np.ptp(result.heights @ [1.0, -1.0, 0.0]) > 0.05


def test_torque_limit_clips_what_the_plant_gets() -> None:
    result = psp3.simulate(ROBOT, Recording((300.0, -300.0, 86.0)), Hold(robot=ROBOT), 0.01, torque_limit=[100.0, 90.0, 50.0])
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
    np.testing.assert_allclose(error.result.heights[:, 0], 0.5 * acceleration * error.result.t**2, atol=1e-12)
    assert error.time == pytest.approx(np.sqrt(0.8 / acceleration), abs=0.002)


def test_an_impossible_pose_ends_the_simulation() -> None:
    with pytest.raises(SimulationDiverged, match="left the poses") as caught:
        psp3.simulate(ROBOT, Recording((0.0, 1e6, -1e6)), Hold(robot=ROBOT), 1.0, period=0.01)
    assert caught.value.result.t.size == 1


@pytest.mark.parametrize("torque", [(np.nan, 0.0, 0.0), (np.inf, -np.inf, 0.0), (1.0, 2.0), "none", None, [[1.0, 2.0, 3.0]]])
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
        ({"initial_heights": [0.0, 0.0]}, InvalidArray),
        ({"initial_speeds": [0.0, np.nan, 0.0]}, InvalidArray),
        ({"initial_heights": [0.0, 1.0, -1.0]}, UnreachablePose),
        ({"initial_heights": [0.0, 0.0, 0.5]}, InvalidValue),
        ({"trajectory": Helix(radius=0.030, robot=ROBOT)}, UnreachableTip),
        ({"trajectory": Helix(rise=1.0, robot=ROBOT)}, StrokeExceeded),
    ],
)
def test_bad_arguments_are_refused_before_the_first_step(arguments: dict[str, object], error: type[Exception]) -> None:
    controller = Recording()
    given = {"trajectory": HELIX, "duration": 1.0} | arguments
    with pytest.raises(error) as caught:
        psp3.simulate(ROBOT, controller, **given)  # type: ignore[arg-type]
    assert isinstance(caught.value, psp3.PSP3Error)
    assert controller.calls == []


def test_progress_reports_a_hundred_times() -> None:
    seen: list[float] = []
    psp3.simulate(ROBOT, psp3.PD(), HELIX, 1.0, progress=seen.append)
    np.testing.assert_allclose(seen, 0.01 * np.arange(1, 101), atol=1e-12)


def test_results_come_back_from_a_file_bit_for_bit(tmp_path: Path) -> None:
    result = psp3.simulate(ROBOT, psp3.PD(), HELIX, 0.1)
    path = result.save(tmp_path / "run.npz")
    loaded = psp3.load_result(path)
    for name in ("t", "heights", "speeds", "torque", "tip"):
        np.testing.assert_array_equal(getattr(loaded, name), getattr(result, name))
    for mine, other in zip(result.desired, loaded.desired, strict=True):
        np.testing.assert_array_equal(mine, other)
    assert [file.name for file in tmp_path.iterdir()] == ["run.npz"]


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.9, 0.999])
def test_a_truncated_file_is_refused(tmp_path: Path, share: float) -> None:
    path = psp3.simulate(ROBOT, psp3.PD(), HELIX, 0.1).save(tmp_path / "run.npz")
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    with pytest.raises(InvalidResultFile, match=r"run\.npz"):
        psp3.load_result(path)


def test_a_damaged_file_is_refused(tmp_path: Path) -> None:
    """One flipped byte in the data of any array is seen by the checksum or the decompressor."""
    path = psp3.simulate(ROBOT, psp3.PD(), HELIX, 0.1).save(tmp_path / "run.npz")
    content = bytearray(path.read_bytes())
    for place in range(1000, len(content) - 2000, 3001):
        damaged = content.copy()
        damaged[place] ^= 0xFF
        path.write_bytes(bytes(damaged))
        with pytest.raises(InvalidResultFile):
            psp3.load_result(path)


def test_files_of_another_kind_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "other.npz"
    np.savez(path, t=np.zeros(3))
    with pytest.raises(InvalidResultFile, match="format 'none'"):
        psp3.load_result(path)
    np.savez(path, format=np.array("psp3-result-2"), t=np.zeros(3))
    with pytest.raises(InvalidResultFile, match="must hold"):
        psp3.load_result(path)
    names = ["t", "heights", "speeds", "torque", "tip", *(f"desired_{name}" for name in Motion._fields)]
    np.savez(path, format=np.array("psp3-result-2"), **{name: np.zeros(3) for name in names})
    with pytest.raises(InvalidResultFile, match="shape"):
        psp3.load_result(path)
    np.savez(path, allow_pickle=True, t=np.array([{}]))
    with pytest.raises(InvalidResultFile):
        psp3.load_result(path)
    with pytest.raises(InvalidResultFile):
        psp3.load_result(tmp_path / "missing.npz")
    np.save(tmp_path / "array.npy", np.zeros(3))
    with pytest.raises(InvalidResultFile):
        psp3.load_result(tmp_path / "array.npy")
