"""The compiled kernels.

What they return for bad rows, and those that no method of the robot uses.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.integrate import solve_ivp

import psp3
from psp3.three_psp import closed_form, stepping
from tests.helpers import Array, random_heights

P = psp3.Parameters().as_array()
D, H = 0.181, 0.070
GOOD, BAD = [0.0, 0.05, 0.1], [0.0, -0.5, 0.5]


def runge_kutta(
    state: Array, forces: Array, duration: float, steps: int, parameters: Array = P
) -> Array:
    state, scratch = state.copy(), np.empty(6)
    for _ in range(steps):
        stepping.runge_kutta_step(state, forces, duration / steps, parameters, scratch)
    return state


@pytest.mark.parametrize(
    ("kernel", "inputs", "width"),
    [
        ("forward_kinematics", 1, 18),
        ("configuration", 1, 15),
        ("tip_jacobian", 1, 9),
        ("equation_of_motion", 2, 21),
        ("energies", 2, 2),
        ("inverse_dynamics", 3, 3),
        ("forward_dynamics", 3, 3),
    ],
)
@pytest.mark.parametrize("bad", [BAD, [np.nan, 0.0, 0.0], [0.0, np.inf, 0.0], [0.0, 0.0, -np.inf]])
def test_kernels_return_the_first_row_they_refuse(
    kernel: str, inputs: int, width: int, bad: list[float]
) -> None:
    """Rows before it are written, and -1 means that all are."""
    function = getattr(closed_form, kernel)
    heights = np.array([GOOD, GOOD, bad, GOOD, bad])
    rest = [np.zeros(heights.size)] * (inputs - 1)
    out = np.full(width * len(heights), -7.0)
    assert function(heights.reshape(-1), *rest, P, out) == 2
    assert (out[: 2 * width] != -7.0).all()
    assert (
        function(heights[:2].reshape(-1), *(array[:6] for array in rest), P, out[: 2 * width]) == -1
    )


@pytest.mark.parametrize("position", [1, 2])
@pytest.mark.parametrize("kernel", ["inverse_dynamics", "forward_dynamics"])
def test_dynamics_kernels_refuse_rates_and_forces_that_are_not_finite(
    kernel: str, position: int
) -> None:
    arguments = [np.array(GOOD * 3), np.zeros(9), np.zeros(9)]
    arguments[position][4] = np.nan
    assert getattr(closed_form, kernel)(*arguments, P, np.empty(9)) == 1


def test_inverse_kinematics_kernel_returns_the_first_tip_out_of_reach() -> None:
    tips = np.array([[0.0, 0.0, 0.1], [0.02, 0.0, 0.1], [0.03, 0.0, 0.1], [np.nan, 0.0, 0.0]])
    assert closed_form.inverse_kinematics_tip(tips.reshape(-1), P, np.empty(12)) == 2
    assert closed_form.inverse_kinematics_tip(tips[3:].reshape(-1), P, np.empty(3)) == 0


def test_slope_of_a_tip_lies_before_the_fold_in_every_direction() -> None:
    """tan(tilt) of the slope found is at most that of the fold along its direction.

    That is 38 degrees at most; the tip is hit to 1e-16 m.
    """
    for azimuth in np.linspace(0.0, 2.0 * np.pi, 37):
        x, y = 0.0238 * np.cos(azimuth), 0.0238 * np.sin(azimuth)
        u, v = closed_form.tip_slope(x, y, D, H)
        assert np.hypot(u, v) < np.tan(np.radians(38.0))
        c = 1.0 / np.sqrt(1.0 + u * u + v * v)
        p = complex(u, v)
        # Tip by complex arithmetic, as in the module's docstring.
        tip = 0.25 * D * (c**3 / (1 + c) ** 2 * p**4 - c * p.conjugate() ** 2) + H * c * p
        assert abs(tip - complex(x, y)) < 1e-16


def test_the_branch_of_home_is_told_by_the_sign_of_the_determinant() -> None:
    """Claim of the module, on a grid.

    For tools of 10 to 150 mm, d tip / d slope changes sign once below the tilt of 60 degrees.

    The determinant comes from the tip's Jacobian with respect to the heights, which is (d tip / d
    slope) times a constant.
    """
    tilts = np.radians(np.linspace(0.0, 60.0, 241))
    azimuths = np.radians(np.linspace(0.0, 360.0, 121))
    for tool in (0.010, 0.030, 0.070, 0.110, 0.150):
        robot = psp3.load("psp3", psp3.Parameters(tool_length=tool))
        heights = robot.inverse_kinematics(0.0, tilts[:, np.newaxis], azimuths)
        positive = np.linalg.det(robot.tip_jacobian(heights)) > 0.0
        assert positive[0].all()
        assert not positive[-1].any()
        assert (np.count_nonzero(positive[1:] != positive[:-1], axis=0) == 1).all()


def test_runge_kutta_step_converges_to_an_independent_integrator_with_fourth_order() -> None:
    """DOP853 at rtol 1e-13 over 0.5 s under constant forces.

    Halving the step divides the error by 16 (12 to 20 is the same order).
    """
    robot = psp3.load("psp3")
    state = np.array([0.0, 0.05, -0.03, 0.2, -0.3, 0.4])
    forces = np.array([90.0, 80.0, 95.0])

    def rate(_: float, y: Array) -> Array:
        return np.concatenate([y[3:], robot.forward_dynamics(y[:3], y[3:], forces)])

    exact = solve_ivp(rate, (0.0, 0.5), state, method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    errors = [
        np.abs(runge_kutta(state, forces, 0.5, steps) - exact).max() for steps in (10, 20, 40)
    ]
    assert 12.0 < errors[0] / errors[1] < 20.0
    assert 12.0 < errors[1] / errors[2] < 20.0
    assert np.abs(runge_kutta(state, forces, 0.5, 500) - exact).max() < 1e-11


def test_runge_kutta_step_hands_on_nan_when_a_pose_stops_being_valid() -> None:
    """The integrator cannot raise; whoever drives it sees NaN, not a plausible number."""
    state = np.array([0.0, -0.44, 0.44, 0.0, -50.0, 50.0])
    assert np.isnan(runge_kutta(state, np.zeros(3), 0.1, 10)).any()


def test_advance_takes_the_steps_and_says_whether_the_machine_can_be_there() -> None:
    """The loop in compiled code against the loop here, bit for bit.

    False for a pose with a negative arm and for NaN.
    """
    forces = np.array([90.0, 80.0, 95.0])
    state = np.array([0.0, 0.05, -0.03, 0.2, -0.3, 0.4])
    expected = runge_kutta(state, forces, 0.02, 20)
    assert stepping.advance(state, forces, 0.001, 20, P, np.empty(6)) is True
    assert_array_equal(state, expected)
    assert (
        stepping.advance(
            np.array([0.0, -0.44, 0.44, 0.0, -50.0, 50.0]), forces, 0.01, 10, P, np.empty(6)
        )
        is False
    )
    # No step at all: the state is judged as it is.
    assert (
        stepping.advance(np.array([*BAD, 0.0, 0.0, 0.0]), forces, 0.001, 0, P, np.empty(6)) is False
    )
    assert (
        stepping.advance(np.array([*GOOD, np.nan, 0.0, 0.0]), forces, 0.001, 0, P, np.empty(6))
        is False
    )


def test_tip_rates_equal_the_tip_jacobian() -> None:
    """J times the nut speeds gives back the tip's velocity; 1e-12 relative, away from the fold."""
    rng = np.random.default_rng(0)
    robot = psp3.load("psp3")
    heights = random_heights(rng, 100, largest_difference=0.1)
    velocity, acceleration = rng.normal(size=(2, 100, 3))
    speeds, accelerations = robot.rates_of_tip(heights, velocity, acceleration)
    jacobian = robot.tip_jacobian(heights)
    assert_allclose(np.einsum("nij,nj->ni", jacobian, speeds), velocity, rtol=0, atol=1e-12)
    # The same with the accelerations of a motion that starts from rest.
    _, from_rest = robot.rates_of_tip(heights, np.zeros(3), acceleration)
    assert_allclose(np.einsum("nij,nj->ni", jacobian, from_rest), acceleration, rtol=0, atol=1e-12)
    assert np.abs(accelerations - from_rest).max() > 1e-3


def test_nothing_is_singular_at_the_level_pose() -> None:
    """A tilt of 1e-12 and none at all give the same answers to 1e-10: no angle is evaluated."""
    robot = psp3.load("psp3")
    level, nearly = np.zeros(3), np.array([0.0, 1e-12, -2e-12])
    speeds = np.array([0.1, -0.2, 0.3])
    for a, b in zip(
        robot.equation_of_motion(level, speeds),
        robot.equation_of_motion(nearly, speeds),
        strict=True,
    ):
        assert_allclose(a, b, rtol=0, atol=1e-10)
    assert_array_equal(robot.forward_kinematics(level).center, np.zeros(3))
    assert_array_equal(robot.forward_kinematics(level).rotation, np.eye(3))
