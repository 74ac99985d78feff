"""MuJoCo as a plant: what comes from MuJoCo, what ends a simulation, what is refused.

How near it is to ours: tests/cross.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import psp3
from psp3.drives import Drive
from psp3.errors import InvalidArray, InvalidValue, MissingPackage
from psp3.simulation.mujoco import MuJoCo
from psp3.simulation.runge_kutta import RungeKutta

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is in the extras mujoco and test")

ROBOT = psp3.load("psp3")
TILTED = np.array([0.05, -0.02, 0.01])


def moved(plant: Any, forces: Any, periods: int, start: Any = TILTED) -> np.ndarray:
    """Return heights and speeds, (periods, 6), under constant forces from rest."""
    plant.start(np.array(start), np.zeros(3))
    # A plant may hand out its own state, which changes.
    return np.array(
        [
            np.concatenate(plant.advance(np.array(forces, dtype=float), 0.002))
            for _ in range(periods)
        ]
    )


def test_without_mujoco_the_error_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(
        MissingPackage, match=r"mujoco cannot be imported.*pip install 'psp3\[mujoco\]'"
    ) as caught:
        MuJoCo(ROBOT)
    assert caught.value.extra == "mujoco"


def test_the_module_does_not_import_mujoco() -> None:
    """It is an extra, so whoever has it not can still import everything."""
    import subprocess

    code = "import sys, psp3.simulation.mujoco; sys.exit('mujoco' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_the_weight_is_in_balance() -> None:
    """Under G nothing moves, but for what the closures give way until they carry.

    1e-7 m/s, which is less than 1e-4 g for a step.
    """
    states = moved(MuJoCo(ROBOT), ROBOT.gravity(TILTED), 500)
    assert_allclose(states[-1, :3], TILTED, rtol=0.0, atol=5e-7)


def test_a_start_forgets_what_was_before() -> None:
    """Bit for bit, though MuJoCo begins its iterations with the last solution."""
    plant = MuJoCo(ROBOT)
    first = moved(plant, [120.0, 60.0, 80.0], 20)
    assert_array_equal(moved(plant, [120.0, 60.0, 80.0], 20), first)


def test_loops_stay_closed() -> None:
    """In free fall with 1 m/s from nut to nut they open by less than a micrometer."""
    plant = MuJoCo(ROBOT)
    plant.start(np.zeros(3), np.array([0.5, -0.5, 0.2]))
    gaps = []
    for _ in range(100):
        assert plant.advance(np.zeros(3), 0.002) is not None
        gaps.append(plant.gap)
    assert 0.0 < max(gaps) < 1e-6


# Motors


def test_motors_give_what_they_can_and_no_more() -> None:
    """The limit as an argument: as our plant with forces that are cut off.

    To 1e-5 m and m/s, which is what closures give way at 10 m/s².
    """
    wanted, cut = np.array([500.0, -30.0, 95.0]), np.array([90.0, -30.0, 90.0])
    limited = moved(MuJoCo(ROBOT, torque_limit=90.0), wanted, 50)
    assert_allclose(limited, moved(RungeKutta(ROBOT), cut, 50), rtol=0.0, atol=1e-5)
    assert_array_equal(limited, moved(MuJoCo(ROBOT, torque_limit=[90.0, 90.0, 90.0]), wanted, 50))


def test_by_default_motors_have_the_effort_limit_of_the_model() -> None:
    """1000 N in the URDF. A larger one as an argument replaces it."""
    assert_array_equal(moved(MuJoCo(ROBOT), [4000.0] * 3, 5), moved(MuJoCo(ROBOT), [1000.0] * 3, 5))
    strong = moved(MuJoCo(ROBOT, torque_limit=5000.0), [4000.0] * 3, 5, start=np.zeros(3))
    # Level, the robot of 26.5 kg moves like a mass point: (12 000 N − weight) / mass over 10 ms.
    speed = (12_000.0 / 26.496 - 9.81) * 0.01
    assert_allclose(strong[-1, 3:], speed, rtol=1e-5)


# Ends of joints


@pytest.mark.parametrize("step", [1, 4])
def test_stops_stop(step: int) -> None:
    """Pushed up at 0.1 m, nuts come to rest there.

    How far they are in at most is a step's way at their speed, 1 m/s.

    At rest the stop gives way by the excess force over its stiffness, which is that of a spring of
    two steps: some 1e-6 m.
    """
    plant = MuJoCo(ROBOT, step, limits=([-0.1] * 3, [0.1] * 3))
    states = moved(plant, ROBOT.gravity(np.zeros(3)) + 40.0, 500, start=np.zeros(3))
    assert states[:, :3].max() < 0.1 + 1.2 * 0.002 / step
    assert states[:, 3:].max() > 0.9
    assert_allclose(states[-1, :3], 0.1, rtol=0.0, atol=1e-4 / step**2)
    assert_allclose(states[-1, 3:], 0.0, rtol=0.0, atol=1e-4)


def test_a_simulation_with_stops_inside_the_stroke_runs_through() -> None:
    """PD without gravity compensation sags by 87 mm.

    A stop holds it at 50 mm, and our plant, which has none, goes down further.
    """
    hold = psp3.trajectories.Hold(robot=ROBOT)
    stopped = psp3.simulate(
        ROBOT, psp3.PD(), hold, 3.0, plant=MuJoCo(ROBOT, limits=([-0.05] * 3, [0.4] * 3))
    )
    free = psp3.simulate(ROBOT, psp3.PD(), hold, 3.0)
    assert_allclose(stopped.heights[-1], -0.05, rtol=0.0, atol=1e-4)
    assert_allclose(free.heights[-1], -0.0866, rtol=0.0, atol=2e-3)


def test_beyond_the_stroke_a_simulation_ends() -> None:
    hold = psp3.trajectories.Hold(robot=ROBOT)
    with pytest.raises(psp3.errors.SimulationDiverged, match="a nut ran off its screw"):
        psp3.simulate(ROBOT, psp3.PD(kp=0.0, kv=0.0), hold, 2.0, plant=MuJoCo(ROBOT))


# What ends a simulation


def test_a_state_that_mujoco_finds_bad_is_none_and_nothing_is_printed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """MuJoCo itself prints its warnings, writes them to a file where it is, and begins anew."""
    monkeypatch.chdir(tmp_path)
    plant = MuJoCo(ROBOT, torque_limit=1e12)
    plant.start(np.zeros(3), np.zeros(3))
    before = mujoco.get_mju_user_warning()
    states = [plant.advance(np.array([1e12, -1e12, 3e11]), 0.002) for _ in range(5)]
    assert states[-1] is None
    assert mujoco.get_mju_user_warning() is before
    assert list(tmp_path.iterdir()) == []
    assert capfd.readouterr() == ("", "")


def test_a_torn_loop_is_none() -> None:
    """Closures nearly off, and one nut pulled up: its third of the star leaves the others."""
    plant = MuJoCo(ROBOT)
    plant.start(TILTED, np.zeros(3))
    plant.model.eq_solimp[:] = 1e-4
    states = [plant.advance(np.array([200.0, 0.0, 0.0]), 0.002) for _ in range(100)]
    assert states[0] is not None
    assert states[-1] is None


# Arguments


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"steps": 0}, "steps must be a whole number of at least 1"),
        ({"drive": 3.0}, "drive must be a Drive, or one for each of the 3"),
        ({"drive": [Drive()] * 2}, "drive must be a Drive, or one for each of the 3"),
        ({"torque_limit": -1.0}, "torque_limit must be one positive number or 3"),
        ({"torque_limit": [1.0, 2.0]}, "torque_limit must be one positive number or 3"),
        ({"torque_limit": np.nan}, "torque_limit must be one positive number or 3"),
        ({"limits": ([0.1] * 3, [-0.1] * 3)}, "limits must be 3 lowest and 3 highest positions"),
        ({"limits": ([0.1] * 2, [0.2] * 2)}, "limits must be 3 lowest and 3 highest positions"),
        ({"limits": ([-np.inf] * 3, [0.2] * 3)}, "limits must be 3 lowest and 3 highest positions"),
    ],
)
def test_arguments_are_checked(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidValue, match=message):
        MuJoCo(ROBOT, **arguments)


def test_numbers_must_be_numbers() -> None:
    with pytest.raises(InvalidArray, match="limits"):
        MuJoCo(ROBOT, limits=("low", "high"))
    with pytest.raises(InvalidArray, match="heights"):
        MuJoCo(ROBOT).start(np.array([0.0, np.nan, 0.0]), np.zeros(3))


@pytest.mark.parametrize("forces", [1e9, 1e300, np.inf, -np.inf, np.nan])
@pytest.mark.parametrize("duration", [1e-300, 1e-9, 0.002, 1.0, 1e300, np.inf, np.nan])
def test_extreme_forces_and_steps_are_finite_or_refused(forces: float, duration: float) -> None:
    """What MuJoCo cannot compute it says in a warning, which ends the simulation: None."""
    plant = MuJoCo(ROBOT)
    plant.start(TILTED, np.zeros(3))
    if not (np.isfinite(forces) and np.isfinite(duration)):
        with pytest.raises((InvalidArray, InvalidValue)):
            plant.advance(np.full(3, forces), duration)
        return
    found = plant.advance(np.full(3, forces), duration)
    if found is None:
        assert duration > 0.01
    else:
        assert np.isfinite(found).all()


@pytest.mark.parametrize(("kp", "kv"), [(1e9, 1e9), (1e9, 1.0), (1e300, 0.0), (0.0, 1e300)])
def test_extreme_gains_are_finite_or_refused(kp: float, kv: float) -> None:
    controller = psp3.ComputedTorque(ROBOT, kp, kv)
    way = psp3.trajectories.Helix(robot=ROBOT)
    try:
        with np.errstate(all="ignore"):
            result = psp3.simulate(ROBOT, controller, way, 0.05, plant=MuJoCo(ROBOT))
    except psp3.PSP3Error:
        return
    for numbers in (result.positions, result.speeds, result.torque):
        assert np.isfinite(numbers).all()
