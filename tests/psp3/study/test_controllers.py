"""Controllers of runs: gains, regulators and the integral, against what the package offers."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import psp3
from psp3.control.default_gains import default_gains
from psp3.control.linear_quadratic_regulator import LinearQuadraticRegulator
from psp3.errors import InvalidValue
from psp3.study.controllers import controller_of, gains_of, record_of, robot_named
from psp3.study.execution import execute, simulate_run
from psp3.study.run import Run


def test_gains_are_those_of_the_table_unless_given() -> None:
    robot, other = robot_named("psp3"), robot_named("five_bar")
    assert gains_of(Run("pd"), robot) == {"kp": 1000.0, "kv": 100.0}
    assert gains_of(Run("t1"), robot) == {"kp": 10.0, "kv": 1.0}
    assert gains_of(Run("ctc", kp=3.0), robot) == {"kp": 3.0, "kv": 1.0}
    assert gains_of(Run("feed-forward", kp=3.0), robot) == {}
    assert gains_of(Run("ctc", robot="five_bar"), other) == default_gains(other, "ctc")


@pytest.mark.parametrize(("name", "force"), [("lqr", 1.0), ("lqr-stiff", 10.0)])
def test_regulators_weigh_errors_like_forces(name: str, force: float) -> None:
    """Of the 3-PSP by Bryson's rule; of another robot like the forces of computed torque.

    To 1e-7 of the largest gain: the Riccati equation is solved to about the root of rounding.
    """
    robot = robot_named("psp3")
    expected = LinearQuadraticRegulator(
        robot, np.diag([1e4] * 3 + [1e2] * 3), np.eye(3) / force**2
    ).regulator.K
    made: Any = controller_of(Run(name), robot)
    np.testing.assert_allclose(made.regulator.K, expected, rtol=0.0, atol=1e-7 * expected.max())
    other = robot_named("five_bar")
    made = controller_of(Run(name, robot="five_bar"), other)
    stiffness = default_gains(other, "ctc")["kp"] * other.mass_matrix(other.reference)
    forces = force * 0.01 * np.diag(stiffness)
    expected = LinearQuadraticRegulator(
        other, np.diag([1e4] * 2 + [1e2] * 2), np.diag(1.0 / forces**2)
    ).regulator.K
    np.testing.assert_allclose(made.regulator.K, expected, rtol=0.0, atol=1e-7 * expected.max())


def test_integral_in_python_is_the_compiled_one() -> None:
    """The same rule of the trapezoid, 1e-10 m over half a second."""
    run = Run("ctc-integral", duration=0.5, mass_mismatch=0.1)
    compiled = simulate_run(run).result
    controller: Any = controller_of(run, psp3.load("psp3"))
    controller.reset()
    desired = compiled.desired
    for k, t in enumerate(compiled.t):
        now = type(desired)(*(array[k] for array in desired))
        forces = controller.torque(float(t), compiled.heights[k], compiled.speeds[k], now)
        np.testing.assert_allclose(forces, compiled.torque[k], rtol=0.0, atol=1e-9)


def test_record_is_that_of_the_path_and_the_gains_learned_with() -> None:
    one = record_of(Run("t1", learned_on="narrow-helix", kp=100.0, kv=20.0))
    robot = psp3.load("psp3")
    path = psp3.trajectories.Helix(radius=0.012, period=2.0, robot=robot)
    exact = psp3.simulate(robot, psp3.ComputedTorque(robot, 100.0, 20.0), path, 10.4)
    np.testing.assert_allclose(one.heights, exact.heights, rtol=0.0, atol=1e-12)
    assert record_of(Run("t1")) is record_of(Run("it2", snr_db=20.0, seed=3))


def test_noise_of_a_model_at_run_time_needs_a_model_of_ours() -> None:
    with pytest.raises(InvalidValue, match="which has its own M, C and G"):
        execute(Run("adaptive-t1", "online", 20.0, duration=0.1))
