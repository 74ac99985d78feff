"""Bad input to the robot's public surface: a project error that names the value, never a number.

Loop files, robots with other trees, the complement and the parameters refuse their own bad input in
their own test files.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

import psp3
from psp3.errors import (
    InvalidArray,
    InvalidValue,
    JointLimitExceeded,
    PSP3Error,
    UnreachablePose,
    UnreachableTip,
)

FOLDED = np.array([0.0, -0.5, 0.5])
"""Nut 1 between the others, 1 m apart: the angle there is above 120 degrees, so arm 1 would have to
be negative.
"""

METHODS: dict[str, list[str]] = {
    "forward_kinematics": ["heights"],
    "configuration": ["heights"],
    "tip_jacobian": ["heights"],
    "mass_matrix": ["heights"],
    "gravity": ["heights"],
    "potential_energy": ["heights"],
    "inverse_kinematics_tip": ["tip"],
    "coriolis_matrix": ["heights", "speeds"],
    "equation_of_motion": ["heights", "speeds"],
    "kinetic_energy": ["heights", "speeds"],
    "velocity": ["positions", "speeds"],
    "inverse_dynamics": ["heights", "speeds", "accelerations"],
    "forward_dynamics": ["heights", "speeds", "forces"],
    "rates_of_tip": ["heights", "velocity", "acceleration"],
}
POSITIONS = [
    (method, position) for method, names in METHODS.items() for position in range(len(names))
]
OF_A_POSE = [method for method in METHODS if method != "inverse_kinematics_tip"]


@pytest.fixture(scope="module")
def robot() -> psp3.PSP3:
    return psp3.load("psp3")


def call(robot: psp3.PSP3, method: str, position: int, value: Any) -> Any:
    """Call a method with good arguments but one."""
    arguments: list[Any] = [np.zeros(3) for _ in METHODS[method]]
    arguments[position] = value
    return getattr(robot, method)(*arguments)


@pytest.mark.parametrize(("method", "position"), POSITIONS)
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_numbers_that_are_not_finite_are_refused(
    robot: psp3.PSP3, method: str, position: int, value: float
) -> None:
    """Alone and in one row of a batch; the error carries the argument as it was given."""
    bad = np.array([0.0, value, 0.0])
    batch = np.zeros((4, 3))
    batch[2] = bad
    for argument in (bad, list(bad), batch):
        with pytest.raises(InvalidArray, match=METHODS[method][position]) as caught:
            call(robot, method, position, argument)
        assert_array_equal(caught.value.array, argument)
        assert isinstance(caught.value, ValueError)
        assert "finite" in str(caught.value)


@pytest.mark.parametrize(("method", "position"), POSITIONS)
@pytest.mark.parametrize(
    "bad",
    [
        0.1,
        [],
        [0.1, 0.2],
        np.zeros(4),
        np.zeros((3, 1)),
        np.zeros((2, 2)),
        np.zeros((3, 0)),
        None,
        "high",
        ["a", "b", "c"],
        {"a1": 0.1},
    ],
    ids=[
        "scalar",
        "empty",
        "two",
        "four",
        "column",
        "square",
        "no columns",
        "None",
        "text",
        "texts",
        "mapping",
    ],
)
def test_wrong_shapes_and_kinds_are_refused(
    robot: psp3.PSP3, method: str, position: int, bad: Any
) -> None:
    with pytest.raises(InvalidArray, match=METHODS[method][position]):
        call(robot, method, position, bad)


def test_ragged_rows_are_refused(robot: psp3.PSP3) -> None:
    """The error's own message must not trip over what cannot become an array."""
    for method, position in POSITIONS:
        with pytest.raises(InvalidArray, match=METHODS[method][position]):
            call(robot, method, position, [[0.1, 0.2, 0.3], [0.1, 0.2]])


def test_complex_numbers_are_refused(robot: psp3.PSP3) -> None:
    """A complex step would otherwise lose its imaginary part and give a derivative of 0."""
    for method, position in POSITIONS:
        with pytest.raises(InvalidArray, match=METHODS[method][position]):
            call(robot, method, position, np.array([0.1 + 1e-20j, 0.2, 0.3]))


@pytest.mark.parametrize(
    "method", [name for name, arguments in METHODS.items() if len(arguments) > 1]
)
def test_leading_dimensions_that_do_not_go_together_are_refused(
    robot: psp3.PSP3, method: str
) -> None:
    arguments = [np.zeros((2 + k, 3)) for k in range(len(METHODS[method]))]
    with pytest.raises(InvalidArray, match=METHODS[method][0]):
        getattr(robot, method)(*arguments)


@pytest.mark.parametrize("leg", [0, 1, 2])
@pytest.mark.parametrize("method", OF_A_POSE)
def test_heights_with_an_arm_that_is_not_positive_are_refused(
    robot: psp3.PSP3, method: str, leg: int
) -> None:
    """Each arm in turn, alone and in a batch.

    The arm lengths of that row come by the law of cosines.
    """
    folded = np.roll(FOLDED, leg)
    for heights in (folded, np.stack([np.zeros(3), folded, np.zeros(3)])):
        with pytest.raises(UnreachablePose, match=r"70\.53") as caught:
            call(robot, method, 0, heights)
        assert_array_equal(caught.value.heights, folded)
        assert isinstance(caught.value, ValueError)
        x, y, z = np.roll(caught.value.arms, -leg)
        assert x < 0.0 < min(y, z)
        # Two arms at 120 degrees: l² = x² + y² + x y for the sides, whatever the signs.
        d = robot.parameters.screw_radius
        assert_allclose(y * y + z * z + y * z, 3 * d * d + 1.0, rtol=1e-12)
        assert_allclose(x * x + y * y + x * y, 3 * d * d + 0.25, rtol=1e-12)


@given(lean=st.floats(0.0, 2.0), azimuth=st.floats(0.0, 2.0 * np.pi))
def test_heights_are_valid_exactly_where_all_arms_are_positive(
    robot: psp3.PSP3, lean: float, azimuth: float
) -> None:
    """The largest angle of the nut triangle decides: below 120 degrees valid, above not.

    1e-9 on either side is left out.
    """
    angles = 2.0 * np.pi / 3.0 * np.arange(3)
    heights = lean * np.cos(angles - azimuth)
    nuts = np.stack([0.181 * np.cos(angles), 0.181 * np.sin(angles), heights], axis=-1)
    cosines = []
    for k in range(3):
        first, second = nuts[(k + 1) % 3] - nuts[k], nuts[(k + 2) % 3] - nuts[k]
        cosines.append(first @ second / np.linalg.norm(first) / np.linalg.norm(second))
    if min(cosines) > -0.5 + 1e-9:
        assert robot.forward_kinematics(heights).arms.min() > 0.0
        assert np.isfinite(robot.mass_matrix(heights)).all()
    elif min(cosines) < -0.5 - 1e-9:
        with pytest.raises(UnreachablePose):
            robot.forward_kinematics(heights)
        with pytest.raises(UnreachablePose):
            robot.mass_matrix(heights)


@pytest.mark.parametrize(
    "heights", [[1e200, 0.0, 0.0], [0.0, 1e160, -1e160], [1e308, -1e308, 1e308]]
)
def test_absurd_heights_are_refused_without_a_warning(
    robot: psp3.PSP3, heights: list[float]
) -> None:
    """Squares overflow; that must end in the project's error, not in numpy's warning."""
    for method in OF_A_POSE:
        with pytest.raises(PSP3Error):
            call(robot, method, 0, heights)


def test_absurd_speeds_are_not_blamed_on_the_heights(robot: psp3.PSP3) -> None:
    """Finite arguments whose answer overflows.

    An error, and not the one that says to bring the heights closer together.
    """
    with pytest.raises(PSP3Error) as caught:
        robot.forward_dynamics([0.1, 0.0, 0.0], [1e200, 0.0, 0.0], np.zeros(3))
    assert not isinstance(caught.value, UnreachablePose)


@pytest.mark.parametrize("model", ["closed_form", "core", "noc", "pinocchio"])
def test_models_of_the_machine_refuse_a_folded_triangle(robot: psp3.PSP3, model: str) -> None:
    with pytest.raises(UnreachablePose if model == "closed_form" else JointLimitExceeded):
        robot.dynamics(model).equation_of_motion(FOLDED, np.zeros(3))


@pytest.mark.parametrize("model", ["closed_form", "core", "pinocchio", "noc"])
@pytest.mark.parametrize("bad", [[np.nan, 0, 0], [0, 0], "abc", None, np.zeros((3, 1))])
def test_every_model_refuses_malformed_states(robot: psp3.PSP3, model: str, bad: Any) -> None:
    dynamics = robot.dynamics(model)
    with pytest.raises(InvalidArray):
        dynamics.equation_of_motion(bad, np.zeros(3))
    with pytest.raises(InvalidArray):
        dynamics.equation_of_motion(np.zeros(3), bad)


@pytest.mark.parametrize("tilt", [np.radians(90), np.radians(120), -np.radians(90), 7.0])
def test_inverse_kinematics_refuses_tilts_of_90_degrees_and_more(
    robot: psp3.PSP3, tilt: float
) -> None:
    for argument in (tilt, [0.1, tilt, 0.2]):
        with pytest.raises(InvalidValue, match="90 degrees") as caught:
            robot.inverse_kinematics(height=0.0, tilt=argument, azimuth=0.3)
        assert caught.value.name == "tilt"
        assert abs(caught.value.value) == abs(tilt)
        assert isinstance(caught.value, ValueError)


def test_inverse_kinematics_refuses_tilts_that_need_a_negative_arm(robot: psp3.PSP3) -> None:
    with pytest.raises(UnreachablePose, match=r"70\.53") as caught:
        robot.inverse_kinematics(height=0.0, tilt=np.radians(75), azimuth=np.pi / 2)
    assert caught.value.arms.min() < 0.0


@pytest.mark.parametrize("name", ["height", "tilt", "azimuth"])
@pytest.mark.parametrize("value", [np.nan, np.inf, "x", None, [0.0, np.nan]])
def test_inverse_kinematics_refuses_what_is_not_finite(
    robot: psp3.PSP3, name: str, value: Any
) -> None:
    with pytest.raises(InvalidArray, match=name):
        robot.inverse_kinematics(**{"height": 0.0, "tilt": 0.1, "azimuth": 0.2, name: value})


def test_a_tip_out_of_reach_is_refused_with_the_reach_at_its_azimuth(robot: psp3.PSP3) -> None:
    """30 mm toward screw 1, where the reach is 23.9 mm.

    Both numbers stand in the message and as attributes.
    """
    tip = np.array([0.030, 0.0, 0.1])
    with pytest.raises(UnreachableTip, match=r"30\.0 mm.*23\.9 mm") as caught:
        robot.inverse_kinematics_tip(tip)
    error = caught.value
    assert isinstance(error, ValueError)
    assert isinstance(error, PSP3Error)
    assert_array_equal(error.tip, tip)
    assert (error.radius, error.azimuth) == (0.030, 0.0)
    assert_allclose(error.reach, np.sqrt(0.070**2 + 0.181**2 / 4) - 0.181 / 2, rtol=1e-11)


def test_the_first_tip_out_of_reach_in_a_batch_is_named(robot: psp3.PSP3) -> None:
    """The circle of radius 30 mm: out of reach everywhere, so its first point is named.

    Then a batch with one bad point.
    """
    angles = np.linspace(0.0, 2.0 * np.pi, 12)
    circle = np.stack([0.03 * np.cos(angles), 0.03 * np.sin(angles), 0 * angles], axis=-1)
    with pytest.raises(UnreachableTip, match=r"23\.9 mm"):
        robot.inverse_kinematics_tip(circle)
    tips = np.zeros((2, 3, 3))
    tips[1, 0] = [0.0, 0.05, 0.2]
    with pytest.raises(UnreachableTip) as caught:
        robot.inverse_kinematics_tip(tips)
    assert_array_equal(caught.value.tip, [0.0, 0.05, 0.2])
    assert_allclose(caught.value.azimuth, np.pi / 2, rtol=1e-15)
    assert caught.value.reach > 0.0239


@pytest.mark.parametrize("tip", [[1e3, 0, 0], [1e308, 1e308, 0], [-1e9, 1e9, 0.0]])
def test_absurd_tips_are_refused_quickly_and_without_a_warning(
    robot: psp3.PSP3, tip: list[float]
) -> None:
    with pytest.raises(UnreachableTip):
        robot.inverse_kinematics_tip(tip)


def test_every_error_is_a_value_error_of_the_project(robot: psp3.PSP3) -> None:
    """Code that knows nothing of psp3 catches ValueError; code that does catches PSP3Error."""
    provocations: list[Callable[[], Any]] = [
        lambda: psp3.load("psp4"),
        lambda: psp3.load("psp3", "table_9_9"),
        lambda: robot.dynamics("lagrange"),
        lambda: robot.forward_kinematics([np.nan, 0, 0]),
        lambda: robot.forward_kinematics(FOLDED),
        lambda: robot.inverse_kinematics_tip([0.03, 0, 0]),
        lambda: robot.inverse_kinematics(0.0, 2.0, 0.0),
        lambda: robot.frame_jacobian(np.zeros(3), "elbow"),
        lambda: psp3.Parameters(star_mass=-1.0),
    ]
    for provoke in provocations:
        with pytest.raises(PSP3Error) as caught:
            provoke()
        assert isinstance(caught.value, ValueError)
