"""Every controller on MuJoCo and on our plants: the same controller, the same code, two engines."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import psp3
from psp3.description.parts import THESIS_ROBOTS
from psp3.drives import NO_DRIVE, Drive
from psp3.simulation.mujoco import MuJoCo
from psp3.simulation.runge_kutta import RungeKutta

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is in the extras mujoco and test")

ROBOT = psp3.load("psp3")
HELIX = psp3.trajectories.Helix(robot=ROBOT)


def fuzzy(kind: str, **options: Any) -> psp3.FuzzyComputedTorque:
    return psp3.FuzzyComputedTorque(kind, ROBOT, **options).fit(HELIX, rng=np.random.default_rng(0))


CONTROLLERS = {
    "feed-forward": lambda: psp3.FeedForward(ROBOT),
    "PD": psp3.PD,
    "PD with gravity": lambda: psp3.GravityCompensatedPD(ROBOT),
    "PID": psp3.PID,
    "computed torque": lambda: psp3.ComputedTorque(ROBOT),
    "computed torque, orthogonal complement": lambda: psp3.ComputedTorque(ROBOT.dynamics("noc")),
    "type-1": lambda: fuzzy("t1"),
    "interval type-2": lambda: fuzzy("it2", snr_db=20.0),
    "general type-2": lambda: fuzzy("gt2", snr_db=20.0),
}


def difference(
    controller: Any, steps: int, duration: float = 0.4, drive: Drive = NO_DRIVE, engine: Any = None
) -> float:
    """Largest difference of nut heights between MuJoCo and our plant.

    Ours takes four steps and is exact to 1e-14 m.
    """
    plant = MuJoCo(ROBOT, steps, drive=drive)
    if engine is not None:
        plant.model.opt.integrator = engine
    theirs = psp3.simulate(ROBOT, controller, HELIX, duration, plant=plant)
    ours = psp3.simulate(
        ROBOT, controller, HELIX, duration, plant=RungeKutta(ROBOT, 4, drive=drive)
    )
    assert np.abs(ours.heights - ours.desired.heights).max() > 1e-3, "nothing happened"
    return float(np.abs(theirs.heights - ours.heights).max())


@pytest.mark.slow
@pytest.mark.parametrize("name", CONTROLLERS)
def test_every_controller_runs_unchanged_and_tracks_alike(name: str) -> None:
    """With one step of 2 ms to 1e-7 m, where the path is 40 mm wide and servo errors are 10 mm.

    With four steps to 1e-8 m.

    What is left are the closures, springs of two steps: measured are 7e-9 to 2e-8 m, and 3 to 30
    times less with four steps. If anything in MuJoCo's robot were off by 1e-5 of its weight, that
    would be 1e-5 m.
    """
    controller = CONTROLLERS[name]()
    # The thesis's own equations take some 5 ms each.
    short = "complement" in name
    coarse = difference(controller, 1, 0.1 if short else 0.4)
    assert coarse < 1e-7
    if not short:
        fine = difference(controller, 4)
        assert fine < 1e-8
        assert fine < 0.4 * coarse


def test_integrators_of_mujoco() -> None:
    """Its one-step methods are of first order: 2e-4 m at 2 ms, half of it at half the step, to 5 %.

    Runge–Kutta is at 2e-8 m at once.

    The latter's difference falls by more than half with every half of the step, as stiffness and
    stages of the closures do.
    """
    for name in ("EULER", "IMPLICIT", "IMPLICITFAST"):
        engine = getattr(mujoco.mjtIntegrator, f"mjINT_{name}")
        coarse, middle, fine = (
            difference(psp3.ComputedTorque(ROBOT), steps, 0.2, engine=engine) for steps in (1, 2, 4)
        )
        assert coarse < 3e-4
        np.testing.assert_allclose([coarse / middle, middle / fine], 2.0, rtol=0.05)
    coarse, middle, fine = (
        difference(psp3.ComputedTorque(ROBOT), steps, 0.2) for steps in (1, 2, 4)
    )
    assert coarse < 1e-7
    assert middle < 0.5 * coarse
    assert fine < 0.5 * middle


@pytest.mark.parametrize(
    ("drive", "coarse", "fine"),
    [
        (Drive(viscous_friction=30.0), 1e-7, 1e-8),
        (Drive(motor_inertia=1e-4, lead=0.01), 1e-7, 1e-8),
        (Drive(coulomb_friction=8.0), 1e-5, 1e-6),
        (Drive(5.0, 20.0, 1e-4, 0.01), 1e-4, 3e-5),
    ],
    ids=["viscous", "rotor", "dry", "all"],
)
def test_friction_and_motors_are_the_same(drive: Drive, coarse: float, fine: float) -> None:
    """MuJoCo's damping, armature and friction loss against ours, which goes from event to event.

    1 s with one step of 2 ms and with four.

    Smooth ones keep the difference of the closures. Of dry friction MuJoCo makes a strong damper,
    and sees stick and slip at its steps only: 4e-6 m, and less than a tenth of it with four steps.
    With a rotor of 39 kg on every screw and all of it together it is 4e-5 m.
    """
    controller = psp3.ComputedTorque(ROBOT, 100.0, 20.0)
    assert difference(controller, 1, 1.0, drive) < coarse
    assert difference(controller, 4, 1.0, drive) < fine


def test_dry_friction_holds_but_for_a_creep() -> None:
    """30 N against 40 N of friction: our plant stays to the last bit.

    MuJoCo's creeps by 7e-7 m/s, and by a quarter with four steps.
    """
    drive, start = Drive(coulomb_friction=40.0), np.array([0.05, -0.02, 0.01])
    forces = ROBOT.gravity(start) + np.array([30.0, -20.0, 10.0])
    speeds = []
    plants = (
        RungeKutta(ROBOT, drive=drive),
        MuJoCo(ROBOT, 1, drive=drive),
        MuJoCo(ROBOT, 4, drive=drive),
    )
    for plant in plants:
        plant.start(start, np.zeros(3))
        for _ in range(100):
            state = plant.advance(forces, 0.002)
            assert state is not None
        speeds.append(float(np.abs(state[1]).max()))
    assert speeds[0] == 0.0
    assert 1e-8 < speeds[1] < 1e-6
    np.testing.assert_allclose(speeds[1] / speeds[2], 4.0, rtol=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in THESIS_ROBOTS if name != "psp3"])
def test_other_robots(name: str) -> None:
    """Computed torque from 5 mm (or mrad) beside the path.

    Differences are 4e-9 to 2e-7, and less than half of that with four steps.
    """
    robot = psp3.load(name)
    goal = robot.reference + np.linspace(0.02, 0.04, len(robot.actuated))
    way = psp3.trajectories.PointToPoint(robot.reference, goal, 0.2, robot)
    controller, start = psp3.ComputedTorque(robot, 100.0, 20.0), robot.reference - 0.005
    one, four, ours = (
        psp3.simulate(robot, controller, way, 0.2, initial_positions=start, plant=plant).positions
        for plant in (MuJoCo(robot), MuJoCo(robot, 4), RungeKutta(robot))
    )
    coarse, fine = np.abs(one - ours).max(), np.abs(four - ours).max()
    assert coarse < 1e-6
    assert fine < 0.5 * coarse
