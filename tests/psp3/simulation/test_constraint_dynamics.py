"""The plant that holds its loops by constraints of Pinocchio."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

import psp3
from psp3.simulation.constraint_dynamics import ConstraintDynamics

ROBOT = psp3.load("psp3")


def test_baumgarte_pulls_open_loops_shut() -> None:
    """Loops opened by hand by 1e-4.

    With stabilization at 20/s the gap after 1 s is exp(−20)·(1 + 20) of it, without it stays.
    """
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
        gaps[frequency] = np.abs(
            pin.log6(data.oMf[frames[0]].actInv(data.oMf[frames[1]])).vector
        ).max()
    assert gaps[0.0] > 5e-5
    assert gaps[20.0] < 1e-9
