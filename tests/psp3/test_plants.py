"""Three plants integrate the same robot by independent routes and must agree."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import psp3
from psp3.errors import InvalidValue
from psp3.plants import ConstraintDynamics, DormandPrince, RungeKutta
from psp3.trajectories import Helix

ROBOT = psp3.load("psp3")


def run(plant: object, duration: float = 0.5) -> psp3.Result:
    return psp3.simulate(ROBOT, psp3.ComputedTorque(ROBOT), Helix(robot=ROBOT), duration, plant=plant)  # type: ignore[arg-type]


def test_the_three_plants_agree() -> None:
    """Tree with constraint forces against closed form: Runge–Kutta errors of 2 ms steps are 1e-12 m; DOP853 runs at 1e-12."""
    closed = run(RungeKutta(ROBOT))
    for plant in (RungeKutta(ROBOT, steps=4), DormandPrince(ROBOT), ConstraintDynamics(ROBOT)):
        other = run(plant)
        np.testing.assert_allclose(other.heights, closed.heights, atol=1e-11)
        np.testing.assert_allclose(other.speeds, closed.speeds, atol=1e-10)


def test_runge_kutta_is_of_fourth_order() -> None:
    """Free motion over 0.2 s from a tilted state: halving the step divides the error by 16 (12 to 20 allowed for round-off and tail)."""
    heights, speeds, forces = np.array([-0.05, 0.08, 0.02]), np.array([1.0, -0.8, 0.3]), ROBOT.gravity(np.zeros(3))

    def end(steps: int) -> np.ndarray:
        plant = RungeKutta(ROBOT, steps)
        plant.start(heights, speeds)
        state = plant.advance(forces, 0.2)
        assert state is not None
        return np.concatenate(state)

    exact = end(4000)
    ratio = np.abs(end(10) - exact).max() / np.abs(end(20) - exact).max()
    assert 12.0 < ratio < 20.0


def test_baumgarte_pulls_open_loops_shut() -> None:
    """Loops opened by hand by 1e-4: with stabilization at 20/s the gap after 1 s is exp(−20)·(1 + 20) of it, without it stays."""
    gaps = {}
    for frequency in (0.0, 20.0):
        plant = ConstraintDynamics(ROBOT, frequency)
        plant.start(np.zeros(3), np.zeros(3))
        plant.q = plant.q + 1e-4 * np.random.default_rng(0).normal(size=15)
        for _ in range(500):
            assert plant.advance(ROBOT.gravity(np.zeros(3)), 0.002) is not None
        frames = [ROBOT.model.getFrameId(f"star{k}_center") for k in (1, 2)]
        data = ROBOT.model.createData()
        pin.framesForwardKinematics(ROBOT.model, data, plant.q)
        gaps[frequency] = np.abs(pin.log6(data.oMf[frames[0]].actInv(data.oMf[frames[1]])).vector).max()
    assert gaps[0.0] > 5e-5
    assert gaps[20.0] < 1e-9


def test_no_plant_goes_on_beyond_the_poses_of_the_machine() -> None:
    """Huge opposite forces on two screws must end every closed-form plant, not return numbers."""
    for plant in (RungeKutta(ROBOT), DormandPrince(ROBOT)):
        plant.start(np.zeros(3), np.zeros(3))
        assert plant.advance(np.array([0.0, 1e6, -1e6]), 0.01) is None


@pytest.mark.parametrize(
    "build",
    [lambda: RungeKutta(ROBOT, 0), lambda: RungeKutta(ROBOT, 1.5), lambda: DormandPrince(ROBOT, -1.0),  # type: ignore[arg-type]
     lambda: ConstraintDynamics(ROBOT, np.nan), lambda: ConstraintDynamics(ROBOT, steps=0)],
)  # fmt: skip
def test_bad_settings_are_refused(build: object) -> None:
    with pytest.raises(InvalidValue):
        build()  # type: ignore[operator]
