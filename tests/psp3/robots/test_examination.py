"""What is said about a robot: counts that are known, and faults that were put in."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import psp3
from psp3.robots.examination import examine

FIVE_BAR = psp3.load("five_bar")


def changed(**options: object) -> psp3.ClosedLoopRobot:
    """Return the five-bar with another model or other motors."""
    given = {"model": FIVE_BAR.model, "actuated": FIVE_BAR.actuated} | options
    model, motors = given["model"], given["actuated"]
    return psp3.ClosedLoopRobot(model, FIVE_BAR.constraint_models, motors, FIVE_BAR.q0)  # type: ignore[arg-type]


def test_a_sound_robot_has_no_findings() -> None:
    found = examine(FIVE_BAR)
    assert (found.bodies, found.motors, found.redundant_equations) == (4, FIVE_BAR.actuated, 1)
    assert found.loops == (("tip-leg2_end", "3d"),)
    assert found.mass == pytest.approx(
        sum(inertia.mass for inertia in list(FIVE_BAR.model.inertias)[1:])
    )
    assert found.findings == ()


def test_motors_that_are_missing_or_too_many_are_told() -> None:
    (held,) = examine(changed(actuated=["leg1_shoulder"])).findings
    assert "no motor commands" in held.what
    (more,) = examine(changed(actuated=[*FIVE_BAR.actuated, "leg1_elbow"])).findings
    assert more.what.startswith("1 more motors than freedoms")


def test_motions_that_are_held_are_one_finding_of_a_kind() -> None:
    (spins,) = examine(psp3.load("hexa")).findings
    balls = ", ".join(f"leg{leg}_ball" for leg in range(1, 7))
    assert spins.what == f"no motor commands the spin of {balls}: held at home"
    whats = [one.what for one in examine(psp3.load("biped", free="lock")).findings]
    assert len(whats) == 2
    assert whats[0].startswith("no motor commands left_")
    assert "the spin of" in whats[1]


def test_a_home_beyond_its_limits_is_told() -> None:
    model = FIVE_BAR.model.copy()
    at = model.joints[model.getJointId("leg1_elbow")].idx_q
    model.upperPositionLimit[at] = FIVE_BAR.q0[at] - 0.1
    (found,) = examine(changed(model=model)).findings
    assert f"leg1_elbow at {FIVE_BAR.q0[at]:.6g}, above" in found.what


def test_what_mujoco_reads_otherwise_is_told() -> None:
    robot = psp3.load("five_bar")
    assert float(examine(robot).mujoco.removeprefix("agrees to ")) < 1e-9
    robot.model.inertias[2] = robot.model.inertias[2] + robot.model.inertias[2]
    found = examine(robot)
    assert found.mujoco.startswith("disagrees: the mass that hangs on leg")
    assert "MuJoCo reads" in found.findings[-1].what


@pytest.mark.parametrize("excess", [1e-3, 0.5])
def test_inertia_that_no_body_has_is_told_with_its_size(excess: float) -> None:
    """Moments 1, 1 and 2 are a thin disk's, the border of what can be."""
    model = FIVE_BAR.model.copy()
    moments = 1e-3 * np.diag([1.0, 1.0, 2.0 * (1.0 + excess)])
    model.inertias[2] = pin.Inertia(0.1, np.zeros(3), moments)
    (found,) = examine(changed(model=model)).findings
    share = 100.0 * excess / (1.0 + excess)
    assert f"exceeds the sum of the other two by {share:.2g} %" in found.what
    assert ("rounding may have done it" in found.what) == (excess == 1e-3)


def test_coordinate_that_moves_nothing_is_told() -> None:
    model = FIVE_BAR.model.copy()
    for k in range(1, model.njoints):
        model.inertias[k] = pin.Inertia(1e-14, np.zeros(3), 1e-16 * np.eye(3))
    model.inertias[1] = pin.Inertia(1.0, np.zeros(3), np.eye(3))
    whats = [found.what for found in examine(changed(model=model)).findings]
    assert any("moves next to nothing" in what for what in whats)
