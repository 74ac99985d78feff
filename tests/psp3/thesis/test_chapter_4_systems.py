"""Second-order systems.

Against SciPy's integrator, its matrix exponential, numpy's roots and 60-digit power series.
"""

from __future__ import annotations

import math
from decimal import Decimal, localcontext

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from psp3.errors import InvalidArray, InvalidValue
from psp3.thesis.chapter_4_systems import (
    DampingCase,
    MassSpringDamper,
    critical_damping,
    cubic_spring,
)

CASES = {
    DampingCase.OVERDAMPED: MassSpringDamper(1.0, 10.0, 4.0),
    DampingCase.UNDERDAMPED: MassSpringDamper(1.0, 1.0, 4.0),
    DampingCase.CRITICALLY_DAMPED: MassSpringDamper(1.0, 4.0, 4.0),
}


def signed(bound: float) -> st.SearchStrategy[float]:
    """Draw numbers up to ``bound``, zero included, whose squares do not underflow."""
    return st.one_of(st.just(0.0), st.floats(1e-100, bound), st.floats(-bound, -1e-100))


masses = st.floats(0.01, 100.0)
stiffnesses = st.floats(0.01, 100.0)
ratios = st.floats(0.0, 20.0)
# Damping ratios that differ from 1 by anything from one rounding error to a tenth.
near_critical = st.builds(
    lambda sign, exponent: 1.0 + sign * 10.0**exponent,
    st.sampled_from([-1.0, 1.0]),
    st.floats(-16.0, -1.0),
)
states = st.tuples(signed(1.0), signed(1.0))


def damped(mass: float, stiffness: float, ratio: float) -> MassSpringDamper:
    return MassSpringDamper(mass, ratio * 2.0 * math.sqrt(mass * stiffness), stiffness)


def matrix(system: MassSpringDamper) -> NDArray[np.float64]:
    return np.array([[0.0, 1.0], [-system.stiffness / system.mass, -system.damping / system.mass]])


def power_series(
    system: MassSpringDamper, t: float, position: float, speed: float
) -> tuple[float, float]:
    """Taylor series of the solution from m x'' = −b x' − k x alone, in 60 digits."""
    with localcontext() as context:
        context.prec = 60
        m, b, k, time = (
            Decimal(system.mass),
            Decimal(system.damping),
            Decimal(system.stiffness),
            Decimal(t),
        )
        # term and next_term are x⁽ⁿ⁾ tⁿ/n! and x⁽ⁿ⁺¹⁾ tⁿ/n!.
        term, next_term, x, v, n = Decimal(position), Decimal(speed), Decimal(0), Decimal(0), 0
        while n < 20 or abs(term) + abs(next_term) > Decimal("1e-45"):
            x, v, n = x + term, v + next_term, n + 1
            term, next_term = next_term * time / n, -(b * next_term + k * term) / m * time / n
        return float(x), float(v)


@pytest.mark.parametrize("case", list(DampingCase))
def test_response_agrees_with_the_integrated_equation_of_motion(case: DampingCase) -> None:
    """DOP853 at relative tolerance 1e-12 is good to about 1e-10 over these ten seconds."""
    system, t = CASES[case], np.linspace(0.0, 10.0, 101)
    assert system.damping_case is case

    def rates(_: float, state: NDArray[np.float64]) -> NDArray[np.float64]:
        acceleration = -(system.damping * state[1] + system.stiffness * state[0]) / system.mass
        return np.array([state[1], acceleration])

    integrated = solve_ivp(
        rates, (0.0, 10.0), [-1.0, 0.7], method="DOP853", t_eval=t, rtol=1e-12, atol=1e-13
    ).y
    np.testing.assert_allclose(system.response(t, -1.0, 0.7), integrated, rtol=0.0, atol=1e-10)


@given(
    masses, stiffnesses, st.one_of(ratios, near_critical, st.just(1.0)), states, st.floats(0.0, 3.0)
)
def test_response_agrees_with_the_matrix_exponential(
    mass: float, stiffness: float, ratio: float, state: tuple[float, float], periods: float
) -> None:
    """The exponential is good to some ulps of the size of the scaled matrix.

    Here that is at most 20 · 2 · 19 rad.
    """
    system = damped(mass, stiffness, ratio)
    frequency = math.sqrt(stiffness / mass)
    t = periods * 2.0 * math.pi / frequency
    # In the units (x, speed/frequency) both states have the same size.
    scale = np.array([1.0, frequency])
    found = np.array(system.response(t, state[0], state[1] * frequency)) / scale
    expected = expm(matrix(system) * scale / scale[:, None] * t) @ np.array(state)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=5e-13 * max(1.0, ratio * periods))


@given(
    masses, stiffnesses, st.one_of(near_critical, st.floats(0.0, 3.0)), states, st.floats(0.0, 8.0)
)
def test_response_agrees_with_an_exact_power_series(
    mass: float, stiffness: float, ratio: float, state: tuple[float, float], phase: float
) -> None:
    """A closed form with (e^{s2 t} − e^{s1 t}) / (s2 − s1) would be off.

    By 1e-8 near critical damping; 1e-14 is some 50 ulps.
    """
    system = damped(mass, stiffness, ratio)
    frequency = math.sqrt(stiffness / mass)
    found = system.response(phase / frequency, state[0], state[1] * frequency)
    expected = power_series(system, phase / frequency, state[0], state[1] * frequency)
    np.testing.assert_allclose(
        np.array(found) / [1.0, frequency],
        np.array(expected) / [1.0, frequency],
        rtol=0.0,
        atol=1e-14,
    )


@pytest.mark.parametrize(
    "system",
    [
        MassSpringDamper(2.0, -1.0, 3.0),
        MassSpringDamper(2.0, -12.0, 3.0),
        MassSpringDamper(2.0, 1.0, -3.0),
        MassSpringDamper(2.0, -1.0, -3.0),
        MassSpringDamper(2.0, -critical_damping(3.0, 2.0), 3.0),
        MassSpringDamper(2.0, 0.0, 3.0),
        MassSpringDamper(2.0, 1.0, 0.0),
        MassSpringDamper(2.0, 0.0, 0.0),
        MassSpringDamper(2.0, 0.0, -3.0),
    ],
    ids=repr,
)
def test_response_of_systems_that_do_not_return(system: MassSpringDamper) -> None:
    """Negative and zero coefficients, too; 1e-13 relative to a motion that may have grown."""
    assert not system.is_stable
    for t in (0.0, 0.1, 1.0, 3.0):
        np.testing.assert_allclose(
            system.response(t, -1.0, 0.7),
            power_series(system, t, -1.0, 0.7),
            rtol=1e-13,
            atol=1e-14,
        )


@pytest.mark.parametrize(("damping", "stiffness", "t"), [(1e4, 1e-4, 1e8), (-1e4, -1e-4, 0.005)])
def test_motion_with_poles_of_very_different_size_stays_accurate(
    damping: float, stiffness: float, t: float
) -> None:
    """Poles 12 orders apart: eq. 4.5 as printed loses the small one.

    Cosh and sinh of δt overflow or cancel (1e-13: exp of 50).
    """
    system = MassSpringDamper(1.0, damping, stiffness)
    with localcontext() as context:
        context.prec = 60
        b, k, time = Decimal(system.damping), Decimal(system.stiffness), Decimal(t)
        root = (b * b - 4 * k).sqrt()
        first, second = (-b - root) / 2, (-b + root) / 2
        slow, fast = (second * time).exp(), (first * time).exp()
        of_position = (
            (second * fast - first * slow) / (second - first),
            first * second * (fast - slow) / (second - first),
        )
        of_speed = (
            (slow - fast) / (second - first),
            (second * slow - first * fast) / (second - first),
        )
    np.testing.assert_allclose(system.poles, [float(first), float(second)], rtol=1e-15)
    np.testing.assert_allclose(
        system.response(t, 1.0, 0.0), [float(number) for number in of_position], rtol=1e-13
    )
    np.testing.assert_allclose(
        system.response(t, 0.0, 1.0), [float(number) for number in of_speed], rtol=1e-13
    )


def test_poles_of_huge_coefficients_do_not_overflow() -> None:
    np.testing.assert_allclose(
        MassSpringDamper(1.0, 1e200, 1.0).poles, [-1e200, -1e-200], rtol=1e-15
    )
    np.testing.assert_allclose(
        MassSpringDamper(1e-200, 1.0, 1e200).poles,
        1e200 * (-0.5 + np.sqrt(0.75) * np.array([-1j, 1j])),
        rtol=1e-14,
    )


@given(masses, stiffnesses, ratios, states, st.floats(0.0, 2.0), st.floats(0.0, 2.0))
def test_responses_compose(
    mass: float,
    stiffness: float,
    ratio: float,
    state: tuple[float, float],
    first: float,
    second: float,
) -> None:
    """Moving on from where the motion is after t1 is the motion after t1 + t2.

    1e-12 is rounding of the phases.
    """
    system = damped(mass, stiffness, ratio)
    halfway = system.response(first, *state)
    frequency = max(1.0, math.sqrt(stiffness / mass))
    size = max(1.0, 1.0 / math.sqrt(stiffness / mass))
    stepped, direct = system.response(second, *halfway), system.response(first + second, *state)
    np.testing.assert_allclose(stepped.position, direct.position, rtol=0.0, atol=1e-12 * size)
    np.testing.assert_allclose(stepped.speed, direct.speed, rtol=0.0, atol=1e-12 * frequency)


@given(masses, stiffnesses, ratios, states)
def test_energy_of_a_passive_system_never_rises_and_leaves_through_the_damper(
    mass: float, stiffness: float, ratio: float, state: tuple[float, float]
) -> None:
    """The work of the damper comes from a Gauss rule of 40 points.

    It is good to 1e-10 over one radian.
    """
    system = damped(mass, stiffness, ratio)
    frequency = math.sqrt(stiffness / mass)
    nodes, weights = np.polynomial.legendre.leggauss(40)
    span = 1.0 / frequency / max(1.0, ratio)
    t = np.concatenate([[0.0], 0.5 * span * (nodes + 1.0), [span]])
    response = system.response(t, state[0], state[1] * frequency)
    energy = system.energy(*response)
    assert (np.diff(energy) <= 1e-14 * energy[0]).all()
    work = 0.5 * span * weights @ (system.damping * response.speed[1:-1] ** 2)
    assert energy[0] - energy[-1] == pytest.approx(work, rel=1e-10, abs=1e-12 * energy[0] + 1e-300)


@given(masses, signed(100.0), signed(100.0))
def test_poles_agree_with_the_eigenvalues_of_the_companion_matrix(
    mass: float, damping: float, stiffness: float
) -> None:
    """Near a double root an eigenvalue is good to the root of the rounding error only.

    Elsewhere this is 1e-13 as well.
    """
    system = MassSpringDamper(mass, damping, stiffness)
    expected = np.roots([mass, damping, stiffness])
    expected = expected[np.lexsort((expected.imag, expected.real))]
    size = max(abs(expected).max(), math.sqrt(abs(stiffness) / mass), 1e-150)
    gap = abs(expected[1] - expected[0]) / size
    tolerance = 1e-13 / gap if gap > 1e-6 else 2e-7
    np.testing.assert_allclose(system.poles, expected, rtol=0.0, atol=tolerance * size)


@given(masses, signed(100.0), signed(100.0))
def test_poles_solve_the_characteristic_equation_in_the_order_of_eq_4_5(
    mass: float, damping: float, stiffness: float
) -> None:
    """Sum −b/m and product k/m to a few ulps of their terms."""
    system = MassSpringDamper(mass, damping, stiffness)
    first, second = system.poles
    np.testing.assert_allclose(
        first + second, -damping / mass, rtol=1e-14, atol=1e-14 * abs(first) + abs(second) * 1e-14
    )
    np.testing.assert_allclose(first * second, stiffness / mass, rtol=1e-14, atol=1e-290)
    assert first.real <= second.real
    assert first.imag <= 0.0 <= second.imag
    assert system.is_stable == (damping > 0.0 and stiffness > 0.0)
    if system.is_stable:
        assert second.real < 0.0


@given(st.floats(1e-6, 1e6), st.floats(1e-6, 1e6))
def test_critical_damping_is_recognized_in_spite_of_rounding(mass: float, stiffness: float) -> None:
    for damping in (
        critical_damping(stiffness, mass),
        2.0 * math.sqrt(mass * stiffness),
        math.sqrt(4.0 * mass * stiffness),
    ):
        system = MassSpringDamper(mass, damping, stiffness)
        assert system.damping_case is DampingCase.CRITICALLY_DAMPED
        assert system.poles[0] == system.poles[1] == -damping / (2.0 * mass)
    critical = critical_damping(stiffness, mass)
    assert (
        MassSpringDamper(mass, critical * (1.0 - 1e-12), stiffness).damping_case
        is DampingCase.UNDERDAMPED
    )
    assert (
        MassSpringDamper(mass, critical * (1.0 + 1e-12), stiffness).damping_case
        is DampingCase.OVERDAMPED
    )


def test_critical_damping_returns_fastest_without_crossing() -> None:
    """What section 4.2.2 says of the three cases, with one spring.

    2 % settling time and sign changes.
    """
    t = np.linspace(0.0, 30.0, 30001)
    settled, crossings = {}, {}
    for case, system in CASES.items():
        x = system.response(t, -1.0, 0.0).position
        settled[case] = t[np.nonzero(np.abs(x) > 0.02)[0][-1]]
        crossings[case] = np.count_nonzero(np.diff(np.sign(x[np.abs(x) > 1e-12])))
    assert settled[DampingCase.CRITICALLY_DAMPED] == min(settled.values())
    assert crossings[DampingCase.OVERDAMPED] == crossings[DampingCase.CRITICALLY_DAMPED] == 0
    assert crossings[DampingCase.UNDERDAMPED] >= 5


def test_response_broadcasts_and_takes_scalars() -> None:
    system = CASES[DampingCase.UNDERDAMPED]
    scalar = system.response(0.5, 1.0, 0.0)
    assert scalar.position.shape == scalar.speed.shape == ()
    grid = system.response(np.linspace(0.0, 1.0, 5), np.ones((3, 1)), 0.0)
    assert grid.position.shape == grid.speed.shape == (3, 5)
    np.testing.assert_array_equal(grid.position[1, 2], scalar.position)
    start = system.response(0.0, -1.0, 0.3)
    assert (start.position, start.speed) == (-1.0, 0.3)


@given(masses, signed(50.0), signed(50.0), stiffnesses, ratios)
def test_regulation_gains_give_the_closed_loop_that_was_asked_for(
    mass: float, damping: float, stiffness: float, wanted: float, ratio: float
) -> None:
    """The gains undo the plant's own b and k, so the differences cancel to the rounding of 50."""
    plant = MassSpringDamper(mass, damping, stiffness)
    critical = plant.regulated(*plant.regulation_gains(wanted))
    assert critical.stiffness == pytest.approx(wanted, abs=1e-13)
    assert critical.damping**2 == pytest.approx(4.0 * mass * wanted, rel=1e-12, abs=1e-11)
    asked = ratio + 0.1
    assert plant.regulated(*plant.regulation_gains(wanted, asked)).damping == pytest.approx(
        asked, abs=1e-13
    )


def test_regulator_acts_as_the_force_of_eq_4_6() -> None:
    """The plant integrated with f = −kp x − kv x' moves as the closed loop.

    As its closed form says (1e-9: DOP853).
    """
    plant, kp, kv = MassSpringDamper(2.0, 0.5, 3.0), 7.0, 1.5
    t = np.linspace(0.0, 5.0, 51)

    def rates(_: float, state: NDArray[np.float64]) -> NDArray[np.float64]:
        force = -kp * state[0] - kv * state[1]
        return np.array(
            [state[1], (force - plant.damping * state[1] - plant.stiffness * state[0]) / plant.mass]
        )

    integrated = solve_ivp(
        rates, (0.0, 5.0), [-1.0, 0.0], method="DOP853", t_eval=t, rtol=1e-11, atol=1e-12
    ).y
    np.testing.assert_allclose(
        plant.regulated(kp, kv).response(t, -1.0, 0.0), integrated, rtol=0.0, atol=1e-9
    )


@pytest.mark.parametrize(
    ("kp", "kv", "stable"),
    [(0.0, 0.0, True), (-5.0, 0.0, False), (0.0, -2.0, False), (-5.0, 5.0, False)],
)
def test_gains_that_make_the_closed_loop_unstable_say_so(
    kp: float, kv: float, stable: bool
) -> None:
    """Thesis section 4.2.3: a negative b' or k' magnifies the error.

    Here it grows a hundredfold, or is gone.
    """
    closed_loop = MassSpringDamper(1.0, 1.0, 4.0).regulated(kp, kv)
    assert closed_loop.is_stable is stable
    assert (closed_loop.poles.real < 0.0).all() == stable
    size = np.hypot(*closed_loop.response(60.0, -1.0, 0.0))
    assert size < 1e-10 if stable else size > 100.0


@pytest.mark.parametrize("mass", [0.0, -1.0, math.nan, math.inf, "heavy", None])
def test_refuses_a_mass_that_is_not_positive(mass: float) -> None:
    with pytest.raises(InvalidValue, match="mass must be"):
        MassSpringDamper(mass, 1.0, 1.0)
    with pytest.raises(InvalidValue, match="mass must be"):
        cubic_spring(mass, 1.0, 1.0)
    with pytest.raises(InvalidValue, match="mass must be"):
        critical_damping(1.0, mass)


@pytest.mark.parametrize("value", [math.nan, -math.inf, "stiff", None, [1.0, 2.0]])
def test_refuses_coefficients_and_gains_that_are_not_numbers(value: float) -> None:
    with pytest.raises(InvalidValue, match=r"^damping must be"):
        MassSpringDamper(1.0, value, 1.0)
    with pytest.raises(InvalidValue, match=r"^stiffness must be"):
        MassSpringDamper(1.0, 1.0, value)
    with pytest.raises(InvalidValue, match=r"^kp must be"):
        MassSpringDamper(1.0, 1.0, 4.0).regulated(value, 0.0)


@pytest.mark.parametrize("stiffness", [0.0, -4.0, math.nan])
def test_refuses_gains_for_a_closed_loop_that_cannot_be_stable(stiffness: float) -> None:
    system = MassSpringDamper(1.0, 1.0, 4.0)
    with pytest.raises(InvalidValue, match="stiffness"):
        critical_damping(stiffness)
    with pytest.raises(InvalidValue, match="stiffness of the closed loop"):
        system.regulation_gains(stiffness)
    with pytest.raises(InvalidValue, match="damping of the closed loop"):
        system.regulation_gains(4.0, stiffness)


def test_response_refuses_what_it_cannot_answer() -> None:
    system = CASES[DampingCase.UNDERDAMPED]
    with pytest.raises(InvalidArray, match=r"t must be finite"):
        system.response([0.0, math.nan], 1.0, 0.0)
    with pytest.raises(InvalidArray, match=r"speed must be finite"):
        system.response(0.0, 1.0, "fast")  # type: ignore[arg-type]
    with pytest.raises(InvalidValue, match=r"not negative, got -0.5"):
        system.response([1.0, -0.5], 1.0, 0.0)
    with pytest.raises(InvalidValue, match=r"grows by e in 1 s"):
        MassSpringDamper(1.0, 0.0, -1.0).response(800.0, 1.0, 0.0)
