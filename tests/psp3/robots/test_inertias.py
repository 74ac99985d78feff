"""Inertias that no body has: refused or told at once, in models from memory and in every format."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import psp3
from psp3.errors import InvalidValue
from psp3.robots.inertias import impossible, turning
from tests.helpers import Array

ROBOT = psp3.load("five_bar")
ORIGIN = np.zeros(3)
TOLD = "no rigid body has the inertia"


def with_body(inertia: pin.Inertia) -> psp3.ClosedLoopRobot:
    """Return the five-bar with another body behind its first elbow, which turns."""
    model = ROBOT.model.copy()
    model.inertias[2] = inertia
    return psp3.ClosedLoopRobot(model, ROBOT.constraint_models, ROBOT.actuated, ROBOT.q0)


@given(
    points=arrays(np.float64, (6, 3), elements=st.floats(-2.0, 2.0, width=32)),
    masses=arrays(np.float64, 6, elements=st.floats(0.5, 3.0, width=32)),
)
def test_whatever_points_make_up_is_possible(points: Array, masses: Array) -> None:
    """Moments as sums over point masses, by the definition: none of them is impossible."""
    center = masses @ points / masses.sum()
    arms = points - center
    inertia = sum(
        mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
        for mass, arm in zip(masses, arms, strict=True)
    )
    assert impossible(pin.Inertia(float(masses.sum()), center, inertia)) == ""


@given(moments=arrays(np.float64, 3, elements=st.floats(0.01, 10.0)))
def test_the_triangle_inequality_decides(moments: Array) -> None:
    """Each moment beside the sum of the other two, in any axes; the border itself left out."""
    turn = pin.rpy.rpyToMatrix(0.3, -0.7, 1.1)
    found = impossible(pin.Inertia(1.0, ORIGIN, turn @ np.diag(moments) @ turn.T))
    excess = 2.0 * moments.max() - moments.sum()
    if abs(excess) > 1e-6 * moments.max():
        assert bool(found) == (excess > 0.0)


@pytest.mark.parametrize(
    "inertia",
    [
        pin.Inertia(np.nan, ORIGIN, np.eye(3)),
        pin.Inertia(np.inf, ORIGIN, np.eye(3)),
        pin.Inertia(-1.0, ORIGIN, np.eye(3)),
        pin.Inertia(1.0, np.array([0.0, np.nan, 0.0]), np.eye(3)),
    ],
    ids=["mass is no number", "infinite", "negative", "center is no number"],
)
def test_a_body_in_memory_that_cannot_be_is_refused(inertia: pin.Inertia) -> None:
    with pytest.raises(InvalidValue, match="leg1_elbow"):
        with_body(inertia)


@pytest.mark.parametrize("value", [np.nan, np.inf, -1.0])
@pytest.mark.parametrize("name", ["armature", "upperDryFrictionLimit"])
def test_numbers_of_joints_that_cannot_be_are_refused(name: str, value: float) -> None:
    model = ROBOT.model.copy()
    setattr(model, name, np.array([0.0, value, 0.0, 0.0]))
    with pytest.raises(InvalidValue, match=name):
        psp3.ClosedLoopRobot(model, ROBOT.constraint_models, ROBOT.actuated, ROBOT.q0)


def test_gravity_and_limits_that_are_no_numbers_are_refused() -> None:
    for name, value in (
        ("gravity", pin.Motion(np.full(6, np.nan))),
        ("upperPositionLimit", np.full(4, np.nan)),
    ):
        model = ROBOT.model.copy()
        setattr(model, name, value)
        with pytest.raises(InvalidValue, match=name):
            psp3.ClosedLoopRobot(model, ROBOT.constraint_models, ROBOT.actuated, ROBOT.q0)


@pytest.mark.parametrize(
    ("inertia", "what"),
    [
        (pin.Inertia(1.0, ORIGIN, np.diag([1.0, 1.0, 3.0])), "33 %"),
        (pin.Inertia(0.0, ORIGIN, np.eye(3)), "no mass"),
    ],
)
def test_a_body_in_memory_that_no_one_has_is_told_once(
    inertia: pin.Inertia, what: str, caplog: pytest.LogCaptureFixture
) -> None:
    with_body(inertia)
    told = [record.getMessage() for record in caplog.records if TOLD in record.getMessage()]
    assert len(told) == 1
    assert what in told[0]
    assert "leg1_elbow" in told[0]


def test_shipped_robots_and_rounded_moments_are_not_told_of(
    caplog: pytest.LogCaptureFixture,
) -> None:
    """The nuts of the 3-PSP have printed moments that no body has, but they do not turn."""
    for name in ("psp3", "five_bar", "delta"):
        psp3.load(name)
    with_body(pin.Inertia(1.0, ORIGIN, np.diag([1.0, 1.0, 2.001])))
    assert TOLD not in caplog.text
    model = psp3.load("psp3").model
    told = {name for name, turns in zip(model.names, turning(model), strict=True) if not turns}
    assert told == {"universe", "a1", "a2", "a3"}


WRITTEN = {
    "arm.urdf": """<robot name="arm"><link name="base"/>
<link name="arm"><inertial><origin xyz="0.1 0 0"/><mass value="1"/>
<inertia ixx="0.1" iyy="0.1" izz="{largest}" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="base"/><child link="arm"/>
<axis xyz="0 1 0"/></joint></robot>""",
    "arm.xml": """<mujoco model="arm"><worldbody><body name="arm">
<joint name="hinge" type="hinge" axis="0 1 0"/>
<inertial pos="0.1 0 0" mass="1" diaginertia="0.1 0.1 {largest}"/></body></worldbody>
<actuator><motor joint="hinge"/></actuator></mujoco>""",
    "arm.sdf": """<sdf version="1.9"><model name="arm"><link name="base"/>
<joint name="weld" type="fixed"><parent>world</parent><child>base</child></joint>
<link name="arm"><inertial><mass>1</mass><pose>0.1 0 0 0 0 0</pose>
<inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>{largest}</izz></inertia></inertial></link>
<joint name="hinge" type="revolute"><parent>base</parent><child>arm</child>
<axis><xyz>0 1 0</xyz></axis></joint></model></sdf>""",
}


@pytest.mark.parametrize("file", [*WRITTEN])
def test_every_reader_tells_or_refuses(
    file: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """What no body has is told, what is negative or no number refused, what is right read."""
    path = tmp_path / file
    path.write_text(WRITTEN[file].format(largest="0.15"))
    psp3.load(path, actuated=["hinge"])
    assert TOLD not in caplog.text
    for wrong in ("nan", "-0.1", "inf"):
        path.write_text(WRITTEN[file].format(largest=wrong))
        with pytest.raises(psp3.PSP3Error):
            psp3.load(path, actuated=["hinge"])
    path.write_text(WRITTEN[file].format(largest="0.3"))
    psp3.load(path, actuated=["hinge"])
    assert TOLD in caplog.text
