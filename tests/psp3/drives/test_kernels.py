"""Stick and slip.

Gauss's principle against its conditions written out, brute force, and a solver of smooth problems.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from psp3.drives import kernels


def problem(seed: int, joints: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Mass, forces, drives and speeds of a random state.

    About half of the joints rest, and some have no friction.
    """
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(joints, joints))
    drives = np.zeros((joints, 3))
    drives[:, kernels.DRY] = rng.uniform(0.0, 2.0, joints) * (rng.random(joints) < 0.8)
    return (
        root @ root.T + 0.3 * np.eye(joints),
        2.0 * rng.normal(size=joints),
        drives,
        rng.normal(size=joints) * (rng.random(joints) < 0.5),
    )


def chosen(
    mass: np.ndarray, net: np.ndarray, drives: np.ndarray, speeds: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    slip, acceleration = np.zeros(len(net)), np.empty(len(net))
    if kernels.slip_of(drives, speeds, slip):
        kernels.choose_slip(mass, net, drives, speeds, slip)
    kernels.accelerations(mass, net, drives, slip, acceleration)
    return slip, acceleration


@settings(max_examples=300, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), joints=st.integers(1, 8))
def test_accelerations_obey_the_law_of_dry_friction(seed: int, joints: int) -> None:
    """The friction that is left, net − M a, is in F Sgn of the speed.

    At rest of the acceleration; 1e-10 is rounding of M a.
    """
    mass, net, drives, speeds = problem(seed, joints)
    slip, acceleration = chosen(mass, net, drives, speeds)
    friction, dry = net - mass @ acceleration, drives[:, kernels.DRY]
    for i in range(joints):
        assert abs(friction[i]) <= dry[i] + 1e-10
        if dry[i] > 0.0 and (speeds[i] != 0.0 or acceleration[i] != 0.0):
            direction = np.sign(speeds[i] or acceleration[i])
            assert friction[i] == pytest.approx(direction * dry[i], abs=1e-10)
            assert slip[i] == direction
        if dry[i] > 0.0 and slip[i] == 0.0:
            assert acceleration[i] == speeds[i] == 0.0


@pytest.mark.parametrize("seed", range(40))
def test_the_choice_is_the_only_one(seed: int) -> None:
    """All lawful combinations of stick and slip have the kernel's accelerations.

    Of four joints, all that obey the law.
    """
    mass, net, drives, speeds = problem(seed, 4)
    found = []
    for slips in itertools.product((-1.0, 0.0, 1.0), repeat=4):
        slip, dry = np.array(slips), drives[:, kernels.DRY]
        moving = np.flatnonzero(slip)
        acceleration = np.zeros(4)
        acceleration[moving] = np.linalg.solve(
            mass[np.ix_(moving, moving)], (net - dry * slip)[moving]
        )
        friction = net - mass @ acceleration
        held = (slip == 0.0) & (speeds == 0.0) & (np.abs(friction) <= dry)
        sliding = (
            (slip * speeds > 0.0)
            | ((speeds == 0.0) & (slip * acceleration > 0.0))
            | ((dry == 0.0) & (slip == 1.0))
        )
        if (held | sliding).all():
            found.append(acceleration)
    assert found
    np.testing.assert_allclose(
        found, np.tile(chosen(mass, net, drives, speeds)[1], (len(found), 1)), rtol=0.0, atol=1e-12
    )


@pytest.mark.parametrize("seed", range(10))
def test_it_is_the_least_constraint(seed: int) -> None:
    """SciPy's L-BFGS-B on the same convex problem, with x split in two parts that are not negative.

    It stops at about 1e-6.
    """
    mass, net, drives, speeds = problem(seed, 5)
    dry = drives[:, kernels.DRY]
    at_rest = speeds == 0.0
    linear = net - np.where(at_rest, 0.0, dry * np.sign(speeds))

    def cost(parts: np.ndarray) -> tuple[float, np.ndarray]:
        x = parts[:5] - parts[5:]
        slope = mass @ x - linear
        penalty = np.where(at_rest, dry, 0.0)
        value = 0.5 * x @ mass @ x - linear @ x + penalty @ (parts[:5] + parts[5:])
        return float(value), np.concatenate([slope + penalty, -slope + penalty])

    best = minimize(
        cost,
        np.zeros(10),
        jac=True,
        bounds=[(0.0, None)] * 10,
        options={"ftol": 1e-16, "gtol": 1e-10, "maxiter": 5000},
    )
    np.testing.assert_allclose(
        chosen(mass, net, drives, speeds)[1], best.x[:5] - best.x[5:], rtol=0.0, atol=1e-5
    )


def test_many_joints_take_no_longer_than_needed() -> None:
    """Forty coupled joints at rest.

    3 to the 40th combinations, and the law holds for the one found.
    """
    rng = np.random.default_rng(1)
    root = rng.normal(size=(40, 40))
    mass, net = root @ root.T / 40.0 + np.eye(40), 3.0 * rng.normal(size=40)
    drives = np.zeros((40, 3))
    drives[:, kernels.DRY] = 2.0
    slip, acceleration = chosen(mass, net, drives, np.zeros(40))
    friction = net - mass @ acceleration
    assert 5 < np.count_nonzero(slip == 0.0) < 35
    assert (np.abs(friction) <= 2.0 + 1e-12).all()
    np.testing.assert_allclose(friction[slip != 0.0], 2.0 * slip[slip != 0.0], rtol=1e-12)
    assert (slip * acceleration >= 0.0).all()


def test_at_the_limit_it_still_sticks_and_beyond_it_lets_go() -> None:
    """One joint of 2 kg with 5 N of friction."""
    mass, drives, at_rest = np.array([[2.0]]), np.array([[0.0, 0.0, 5.0]]), np.zeros(1)
    assert chosen(mass, np.array([5.0]), drives, at_rest)[0] == 0.0
    slip, acceleration = chosen(mass, np.array([-5.0 * (1.0 + 1e-10)]), drives, at_rest)
    assert slip == -1.0
    assert acceleration == pytest.approx(-2.5e-10, rel=1e-5)


def test_what_turned_back_is_stopped() -> None:
    drives = np.array([[0.0, 0.0, 1.0]] * 3 + [[0.0, 0.0, 0.0]])
    speeds, slip = np.array([-1e-9, 0.2, 0.0, -0.3]), np.array([1.0, 1.0, 0.0, 1.0])
    kernels.stop_what_turned_back(drives, speeds, slip)
    np.testing.assert_array_equal(speeds, [0.0, 0.2, 0.0, -0.3])
    np.testing.assert_array_equal(slip, [0.0, 1.0, 0.0, 1.0])
