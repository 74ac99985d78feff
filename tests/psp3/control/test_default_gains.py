"""Default gains: the loop they make, and what the motors move."""

from __future__ import annotations

import numpy as np
import pytest

import psp3
from psp3.control.classical import critically_damped_gains
from psp3.control.default_gains import BANDWIDTH, default_gains, moved_mass


@pytest.mark.parametrize("name", ["five_bar", "delta"])
def test_loops_are_critically_damped_with_the_bandwidth(name: str) -> None:
    """M s² + kv s + kp has double poles, real and negative, at one place for all joints."""
    robot = psp3.load(name)
    mass = robot.mass_matrix(robot.reference)
    np.testing.assert_allclose(moved_mass(robot), mass)
    for controller, moved in (("pd", mass), ("pd-gravity", mass), ("ctc", np.eye(len(mass)))):
        gains = default_gains(robot, controller)
        unit = np.eye(len(mass))
        full = (gains[k] if np.ndim(gains[k]) else gains[k] * unit for k in ("kp", "kv"))
        kp, kv = (np.linalg.solve(moved, gain) for gain in full)
        omega = kv[0, 0] / 2.0
        np.testing.assert_allclose(kp, omega**2 * np.eye(len(mass)), rtol=1e-9, atol=1e-6)
        assert omega == pytest.approx(critically_damped_gains(BANDWIDTH)[1] / 2.0)
    assert default_gains(robot, "feed-forward") == {}


def test_integral_of_a_pid_is_a_tenth_of_what_the_least_mass_bears() -> None:
    """The polynomial of the error, m s³ + kv s² + kp s + ki, is stable for ki < kp kv / m."""
    robot = psp3.load("five_bar")
    gains, least = default_gains(robot, "pid"), np.linalg.eigvalsh(moved_mass(robot))[0]
    omega = critically_damped_gains(BANDWIDTH)[1] / 2.0
    assert gains["ki"] == pytest.approx(0.1 * (omega**2 * least) * (2.0 * omega * least) / least)
    # A slope: less than the largest, so all roots are to the left.
    roots = np.roots([least, 2.0 * omega * least, omega**2 * least, gains["ki"]])
    assert roots.real.max() < 0.0


def test_what_follows_gives_way() -> None:
    """The mass of what is commanded is that of the inverse mass matrix's block."""
    robot = psp3.load("gripper")
    k = robot.commanded
    inverse = np.linalg.inv(robot.mass_matrix(robot.reference))
    np.testing.assert_allclose(moved_mass(robot), np.linalg.inv(inverse[:k, :k]), rtol=1e-8)
