"""Worst errors against quadrature, brute force and eigenvalues; least disturbances against LPs."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import linprog

from psp3.bounds.error_dynamics import (
    SLOWEST,
    ErrorDynamics,
    least_disturbance,
    powers,
    share_of_period,
)
from psp3.errors import InvalidValue

RATIOS = st.one_of(st.floats(0.05, 3.0), st.just(1.0))


def impulse_response(kp: float, kv: float, t: float) -> float:
    """Return what a unit impulse makes of e'' + kv e' + kp e, by its roots."""
    middle, square = 0.5 * kv, 0.25 * kv**2 - kp
    if abs(square) < 1e-12 * kp:
        return t * math.exp(-middle * t)
    if square > 0.0:
        root = math.sqrt(square)
        return (math.exp((root - middle) * t) - math.exp((-root - middle) * t)) / (2.0 * root)
    root = math.sqrt(-square)
    return math.exp(-middle * t) * math.sin(root * t) / root


@given(kp=st.floats(0.1, 1000.0), ratio=RATIOS)
def test_without_a_period_it_is_the_integral_of_the_absolute_impulse_response(
    kp: float, ratio: float
) -> None:
    """By quadrature from one change of sign to the next, until e^-30 is left, within 1e-8."""
    kv = 2.0 * ratio * math.sqrt(kp)
    slowest = 0.5 * kv - math.sqrt(max(0.25 * kv**2 - kp, 0.0))
    piece = 1.0 / slowest if ratio >= 1.0 else math.pi / math.sqrt(kp - 0.25 * kv**2)
    count = math.ceil(30.0 / slowest / piece)
    parts = [
        quad(
            lambda t: abs(impulse_response(kp, kv, t)),
            piece * number,
            piece * (number + 1),
            epsabs=1e-12 / kp,
            epsrel=1e-10,
        )[0]
        for number in range(count)
    ]
    assert ErrorDynamics(kp, kv).worst_error() == pytest.approx(sum(parts), rel=1e-8)


def final_errors(loop: ErrorDynamics, disturbances: np.ndarray, parts: int) -> np.ndarray:
    """Return the last errors under disturbances (steps, B), held over the parts of each period.

    Kinematics only: the servo acceleration is held, the rest is position and speed.
    """
    part = loop.period / parts
    error, rate = np.zeros((2, disturbances.shape[1]))
    servo = np.zeros(disturbances.shape[1])
    for step, disturbance in enumerate(disturbances):
        if step % parts == 0:
            servo = loop.kp * error + loop.kv * rate
        acceleration = -(servo + disturbance)
        error = error + part * rate + 0.5 * part**2 * acceleration
        rate = rate + part * acceleration
    return error


@pytest.mark.parametrize(
    ("kp", "kv", "period"),
    [(100.0, 20.0, 0.02), (100.0, 5.0, 0.04), (100.0, 30.0, 0.05), (400.0, 18.0, 0.08)],
)
def test_the_worst_disturbance_is_found_by_brute_force(kp: float, kv: float, period: float) -> None:
    """Unit disturbances of each tenth of a period, one by one, say what the worst one is.

    The last error is linear in them, so it is greatest where each has the sign of its effect. It
    changes sign within a tenth at most once a half wave, which loses some 1e-4; it is never more.
    """
    loop, parts, periods = ErrorDynamics(kp, kv, period), 10, 160
    effects = final_errors(loop, np.eye(parts * periods), parts)
    bang_bang = np.sign(effects)[:, np.newaxis]
    reached = float(final_errors(loop, bang_bang, parts)[0])
    assert reached == pytest.approx(np.abs(effects).sum(), rel=1e-10)
    assert 0.999 * loop.worst_error() <= reached <= loop.worst_error() * (1.0 + 1e-9)
    noise = np.random.default_rng(0).choice([-1.0, 1.0], size=(parts * periods, 50))
    assert np.abs(final_errors(loop, noise, parts)).max() <= loop.worst_error()


@pytest.mark.parametrize("ratio", [0.2, 0.5, 1.0, 2.0])
def test_short_periods_come_near_to_none(ratio: float) -> None:
    """A tenth of the period is a tenth of the distance, within a third.

    Where nothing changes sign a constant disturbance is the worst, held or not, to rounding of some
    1e4 terms.
    """
    kp, kv = 50.0, 2.0 * ratio * math.sqrt(50.0)
    limit = ErrorDynamics(kp, kv).worst_error()
    coarse, fine = (ErrorDynamics(kp, kv, period).worst_error() - limit for period in (1e-3, 1e-4))
    if ratio >= 1.0:
        assert max(abs(coarse), abs(fine)) < 1e-11 * limit
    else:
        assert 0.0 < fine < 0.01 * limit
        assert coarse / fine == pytest.approx(10.0, rel=0.3)


@given(kp=st.floats(0.1, 1e4), kv=st.floats(0.1, 1e3), period=st.floats(1e-3, 1.0))
def test_gains_that_do_not_settle_are_refused_as_eigenvalues_say(
    kp: float, kv: float, period: float
) -> None:
    """Not asked nearer to the edge than rounding of the eigenvalues, or the slowest loop."""
    h = period
    step = np.array([[1.0, h], [0.0, 1.0]]) - np.outer([0.5 * h**2, h], [kp, kv])
    radius = np.abs(np.linalg.eigvals(step)).max()
    assume(abs(radius - 1.0) > 1e-6 and h * min(kp / kv, 0.5 * kv) > SLOWEST)
    if radius > 1.0:
        with pytest.raises(InvalidValue, match="period must be below"):
            ErrorDynamics(kp, kv, period)
    else:
        np.testing.assert_allclose(ErrorDynamics(kp, kv, period).step, step, rtol=1e-13, atol=1e-12)


@pytest.mark.parametrize(
    ("arguments", "match"),
    [
        ((0.0, 1.0), "kp"),
        ((1.0, -1.0), "kv"),
        ((1.0, 1.0, -0.1), "period"),
        ((1e-9, 1.0, 1e-3), "1e\\+06 periods"),
    ],
)
def test_other_bad_arguments_are_refused(arguments: tuple[float, ...], match: str) -> None:
    with pytest.raises(InvalidValue, match=match):
        ErrorDynamics(*arguments)


def test_powers_are_those_of_numpy() -> None:
    step = ErrorDynamics(100.0, 20.0, 0.004).step
    found = powers(step, 37)
    expected = [np.linalg.matrix_power(step, number) for number in range(37)]
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-14)


@given(
    alpha=st.floats(-100.0, 100.0),
    beta=st.floats(-5.0, 5.0),
    period=st.sampled_from([1e-3, 0.02, 1.0]),
)
def test_share_of_a_period_is_an_integral(alpha: float, beta: float, period: float) -> None:
    """The midpoint rule of 20 000 points, whose error is that of one kink."""
    s = (np.arange(20_000) + 0.5) / 20_000 * period
    expected = float(np.abs(alpha * (period - s) + beta).mean()) * period
    size = period * (abs(alpha) * period + abs(beta))
    found = float(share_of_period(np.array([alpha, beta]), period))
    assert abs(found - expected) <= 1e-8 * size


@pytest.mark.slow
@given(moved=st.floats(-3.0, 3.0), sped=st.floats(-3.0, 3.0), period=st.sampled_from([0.1, 1.0]))
def test_no_smaller_disturbance_explains_a_period(moved: float, sped: float, period: float) -> None:
    """A linear program over 100 parts of the period; one part has a mean of two signs."""
    assume(abs(moved) + abs(sped) > 0.1)
    parts = 100
    part = period / parts
    left = period - part * (np.arange(parts) + 0.5)
    equations = np.stack([np.full(parts, part), part * left])
    room = np.concatenate([np.eye(parts), -np.eye(parts)])
    program = linprog(
        np.append(np.zeros(parts), 1.0),
        np.hstack([room, -np.ones((2 * parts, 1))]),
        np.zeros(2 * parts),
        np.hstack([equations, np.zeros((2, 1))]),
        [sped, moved],
        bounds=[(None, None)] * (parts + 1),
    )
    found = float(least_disturbance(np.array(moved), np.array(sped), period))
    assert found == pytest.approx(program.fun, rel=1e-3)
    assert found <= program.fun * (1.0 + 1e-7)
