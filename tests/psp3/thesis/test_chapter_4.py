"""Control-law partitioning: errors by eq. 4.18 in closed form, and where simulations stop."""

from __future__ import annotations

import math

import numpy as np
import pytest

from psp3.errors import InvalidArray, InvalidValue, MotionDiverged
from psp3.thesis.chapter_4 import Desired, PartitionedControl, simulate_tracking
from psp3.thesis.chapter_4_systems import (
    DampingCase,
    MassSpringDamper,
    SecondOrderSystem,
    critical_damping,
    cubic_spring,
)


def moving(t: float) -> Desired:
    """Return a motion with two frequencies, its rates written out by hand."""
    return Desired(
        0.6 * math.sin(1.3 * t) + 0.2 * math.cos(2.9 * t),
        0.78 * math.cos(1.3 * t) - 0.58 * math.sin(2.9 * t),
        -1.014 * math.sin(1.3 * t) - 1.682 * math.cos(2.9 * t),
    )


SYSTEMS = {
    "mass-spring-damper": MassSpringDamper(2.0, 0.5, 3.0).system(),
    "cubic spring": cubic_spring(2.0, 0.5, 30.0),
    "pendulum with quadratic drag": SecondOrderSystem(
        lambda _: 1.7, lambda x, v: 9.81 * math.sin(x) + 0.3 * v * abs(v)
    ),
    "mass that varies with the position": SecondOrderSystem(
        lambda x: 1.0 + x * x, lambda x, v: x * v * v + 2.0 * x
    ),
}


@pytest.mark.parametrize("name", list(SYSTEMS))
@pytest.mark.parametrize(("kp", "kv"), [(25.0, 10.0), (25.0, 2.0), (9.0, 10.0), (10.0, 1.0)])
def test_partitioned_control_makes_any_error_obey_the_linear_equation(
    name: str, kp: float, kv: float
) -> None:
    """Closed form of eq. 4.18 against the simulated non-linear loop.

    1e-8 is what DOP853 leaves at tolerance 1e-10.
    """
    control = PartitionedControl.of(SYSTEMS[name], kp, kv)
    t = np.linspace(0.0, 6.0, 121)
    tracking = simulate_tracking(SYSTEMS[name], control, moving, t, position=-1.0, speed=0.4)
    expected = control.error_dynamics.response(t, 0.2 + 1.0, 0.78 - 0.4)
    np.testing.assert_allclose(tracking.error, expected.position, rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(tracking.error_speed, expected.speed, rtol=0.0, atol=1e-7)


def test_started_on_the_path_the_exact_model_leaves_no_error() -> None:
    """Thesis section 4.2.5; the rest, 1e-9 m, is the integrator's."""
    start = moving(0.0)
    system = SYSTEMS["cubic spring"]
    control = PartitionedControl.of(system, 25.0, 10.0)
    tracking = simulate_tracking(
        system, control, moving, np.linspace(0.0, 5.0, 51), start.position, start.speed
    )
    assert np.abs(tracking.error).max() < 1e-9
    # With no error the force is the inverse dynamics of the desired motion.
    inverse = [
        2.0 * m.acceleration + 0.5 * m.speed + 30.0 * m.position**3 for m in map(moving, tracking.t)
    ]
    np.testing.assert_allclose(tracking.force, inverse, rtol=0.0, atol=1e-6)


def test_a_wrong_model_leaves_the_error_that_theory_gives() -> None:
    """A stiffness that is too small by d leaves e'' + kv e' + (kp + d/m) e = (d/m) x_d.

    At a constant x_d, e = (d/m) x_d / (kp + d/m).
    """
    plant, difference, kp = MassSpringDamper(2.0, 0.5, 3.0), 1.0, 16.0
    model = MassSpringDamper(2.0, 0.5, 3.0 - difference).system()
    control = PartitionedControl.of(model, kp, critical_damping(kp))
    tracking = simulate_tracking(
        plant.system(), control, lambda _: Desired(0.3, 0.0, 0.0), [0.0, 20.0], 0.0, 0.0
    )
    assert tracking.error[-1] == pytest.approx(
        difference / 2.0 * 0.3 / (kp + difference / 2.0), abs=1e-9
    )


def test_servo_at_rest_in_zero_is_the_regulator_of_eq_4_14() -> None:
    control = PartitionedControl.of(SYSTEMS["cubic spring"], 25.0, 10.0)
    assert control.servo(Desired(0.0, 0.0, 0.0), 0.3, -0.2) == pytest.approx(
        -25.0 * 0.3 + 10.0 * 0.2, rel=1e-15
    )
    assert control.force(Desired(0.0, 0.0, 0.0), 0.3, -0.2) == pytest.approx(
        2.0 * -5.5 + 0.5 * -0.2 + 30.0 * 0.027, rel=1e-14
    )


def test_error_dynamics_says_whether_the_servo_gains_are_stable() -> None:
    system = SYSTEMS["cubic spring"]
    assert (
        PartitionedControl.of(system, 25.0, critical_damping(25.0)).error_dynamics.damping_case
        is DampingCase.CRITICALLY_DAMPED
    )
    assert not PartitionedControl.of(system, 25.0, -1.0).error_dynamics.is_stable
    assert not PartitionedControl.of(system, -25.0, 10.0).error_dynamics.is_stable


@pytest.mark.parametrize("value", [math.nan, -math.inf, "stiff", None, [1.0, 2.0]])
def test_refuses_gains_and_positions_that_are_not_numbers(value: float) -> None:
    system = MassSpringDamper(1.0, 1.0, 4.0).system()
    control = PartitionedControl.of(system, 1.0, 1.0)
    with pytest.raises(InvalidValue, match=r"^kv must be"):
        PartitionedControl.of(system, 1.0, value)
    with pytest.raises(InvalidValue, match=r"^position must be"):
        simulate_tracking(system, control, moving, [0.0, 1.0], value, 0.0)


@pytest.mark.parametrize(
    ("t", "error"),
    [
        ([0.0, 0.0], InvalidValue),
        ([1.0, 0.0], InvalidValue),
        ([0.0], InvalidArray),
        ([[0.0, 1.0]], InvalidArray),
        ([0.0, math.inf], InvalidArray),
    ],
)
def test_simulation_refuses_times_that_do_not_increase(
    t: list[float], error: type[Exception]
) -> None:
    system = SYSTEMS["cubic spring"]
    with pytest.raises(error, match="t must be"):
        simulate_tracking(system, PartitionedControl.of(system, 1.0, 1.0), moving, t, 0.0, 0.0)


@pytest.mark.parametrize("power", [2, 3])
def test_a_motion_without_end_stops_with_time_state_and_force(power: int) -> None:
    """The motion x'' = x^p from x = 1 at rest reaches infinity in finite time.

    The model that leaves that force standing is wrong.
    """
    system = SecondOrderSystem(lambda _: 1.0, lambda x, _: -(float(x) ** power))
    control = PartitionedControl(lambda _: 1.0, lambda x, v: 0.0, 0.0, 0.0)
    # For p = 2 and 3 energy gives the time to infinity, ∫ dx / sqrt(2 (xᵖ⁺¹ − 1) / (p + 1)).
    infinity = {2: 2.974, 3: 1.854}[power]
    with pytest.raises(MotionDiverged, match="diverges at t = ") as caught:
        simulate_tracking(system, control, lambda _: Desired(0.0, 0.0, 0.0), [0.0, 10.0], 1.0, 0.0)
    assert caught.value.time == pytest.approx(infinity, abs=1e-3)
    assert caught.value.position > 1e3
    assert caught.value.speed > 1e3
    assert caught.value.force == 0.0


def test_a_motion_that_outgrows_the_numbers_stops() -> None:
    """From x = 1 at rest x'' = 100 x is cosh(10 t), whose cube overflows at 23.7 s."""
    system = SecondOrderSystem(lambda _: 1.0, lambda x, v: 0.0)
    control = PartitionedControl(lambda _: 1.0, lambda x, v: 0.0 * x**3, -100.0, 0.0)
    with pytest.raises(MotionDiverged, match="force inf N") as caught:
        simulate_tracking(system, control, lambda _: Desired(0.0, 0.0, 0.0), [0.0, 30.0], 1.0, 0.0)
    assert caught.value.time == pytest.approx(23.73, abs=0.2)


def test_a_force_that_is_not_a_number_stops_the_simulation() -> None:
    system = SYSTEMS["cubic spring"]
    control = PartitionedControl(system.mass, lambda x, v: math.nan if x > 0.5 else 0.0, 25.0, 10.0)
    with pytest.raises(MotionDiverged, match="force nan N"):
        simulate_tracking(system, control, lambda _: Desired(1.0, 0.0, 0.0), [0.0, 5.0], 0.0, 0.0)


def test_a_mass_that_runs_out_stops_the_simulation() -> None:
    system = SecondOrderSystem(lambda x: 1.0 - x, lambda x, v: 0.0)
    with pytest.raises(InvalidValue, match="mass at x = 1"):
        simulate_tracking(
            system,
            PartitionedControl.of(system, 4.0, 1.0),
            lambda _: Desired(2.0, 0.0, 0.0),
            [0.0, 5.0],
            0.0,
            0.0,
        )
