"""Three plants integrate the same robot by independent routes and must agree, also with friction.

Closed forms say where they go.
"""

from __future__ import annotations

import numpy as np

import psp3
from psp3.drives import Drive
from psp3.simulation.runge_kutta import RungeKutta
from tests.psp3.simulation.plants import after

ROBOT = psp3.load("psp3")


def test_runge_kutta_is_of_fourth_order() -> None:
    """Free motion over 0.2 s from a tilted state.

    Halving the step divides the error by 16 (12 to 20 allowed for round-off and tail).
    """
    heights, speeds, forces = (
        np.array([-0.05, 0.08, 0.02]),
        np.array([1.0, -0.8, 0.3]),
        ROBOT.gravity(np.zeros(3)),
    )

    def end(steps: int) -> np.ndarray:
        plant = RungeKutta(ROBOT, steps)
        plant.start(heights, speeds)
        state = plant.advance(forces, 0.2)
        assert state is not None
        return np.concatenate(state)

    exact = end(4000)
    ratio = np.abs(end(10) - exact).max() / np.abs(end(20) - exact).max()
    assert 12.0 < ratio < 20.0


# Drives


def test_steps_that_end_at_events_keep_their_order() -> None:
    """Three nuts with friction, two of which come to rest within 0.3 s.

    Halving the step divides the error by 16 all the same.
    """
    drive = Drive(20.0, 1.0)
    state = [0.02, -0.03, 0.05], [0.3, -0.2, 0.05], [90.0, 80.0, 85.0], 0.3
    exact = np.concatenate(after(RungeKutta(ROBOT, 2400, drive), *state))
    assert (exact[3:] == 0.0).sum() == 3
    errors = [
        np.abs(np.concatenate(after(RungeKutta(ROBOT, steps, drive), *state)) - exact).max()
        for steps in (30, 60)
    ]
    assert 12.0 < errors[0] / errors[1] < 20.0
