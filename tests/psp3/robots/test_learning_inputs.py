"""What the dynamics of robots depend on."""

from __future__ import annotations

import numpy as np

import psp3


def test_inputs_tell_all_that_m_c_and_g_depend_on() -> None:
    """What leaves the inputs as they are leaves M, C and G as they are; 1e-9 of their size."""
    rng = np.random.default_rng(0)
    robot = psp3.load("psp3")
    a, v = 0.02 * rng.normal(size=3), 0.1 * rng.normal(size=3)
    inputs = robot.learning_inputs
    np.testing.assert_allclose(inputs.of(a + 0.1, v + 0.3), inputs.of(a, v), atol=1e-15)
    for one, other in zip(
        robot.equation_of_motion(a, v), robot.equation_of_motion(a + 0.1, v + 0.3), strict=True
    ):
        np.testing.assert_allclose(one, other, atol=1e-9)


def test_of_any_robot_m_and_g_depend_on_positions_and_c_on_speeds_too() -> None:
    robot = psp3.load("five_bar")
    inputs = robot.learning_inputs
    assert inputs.names == (*robot.actuated, *(f"speed of {name}" for name in robot.actuated))
    assert (inputs.of_mass_and_gravity, inputs.of_coriolis) == ((0, 1), (0, 1, 2, 3))
    a, v = np.array([0.1, 0.2]), np.array([3.0, 4.0])
    np.testing.assert_array_equal(inputs.of(a, v), [0.1, 0.2, 3.0, 4.0])
