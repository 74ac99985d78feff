"""Joint ranges: poses inside them, and ranges that no closed pose keeps."""

from __future__ import annotations

import logging
import time
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import psp3
from psp3.closure.ranges import freed, how_far_beyond, within_limits
from tests.helpers import Array


def tree(*ranges: tuple[float, float]) -> pin.Model:
    """Return a chain of hinges with these limits."""
    model = pin.Model()
    for number, (low, high) in enumerate(ranges):
        joint = model.addJoint(
            number, pin.JointModelRZ(), pin.SE3.Identity(), f"hinge{number}", *np.ones((2, 1)),
            np.array([low]), np.array([high]),
        )  # fmt: skip
        model.appendBodyToJoint(joint, pin.Inertia.Random(), pin.SE3.Identity())
    return model


def test_a_configuration_is_brought_inside_and_not_onto_a_limit() -> None:
    model = tree((0.2, 1.2), (-np.inf, -0.4), (-1.0, 1.0), (2.0, -2.0))
    inside = within_limits(model, np.zeros(4))
    assert inside == pytest.approx([0.25, -0.45, 0.0, 0.0])
    assert how_far_beyond(model, inside) == 0.0
    assert how_far_beyond(model, np.zeros(4)) == pytest.approx(0.6)
    assert how_far_beyond(model, np.array([0.2 - 1e-8, -0.4 + 1e-8, 0.0, 0.0])) == 0.0


def test_limits_that_home_is_beyond_are_taken_away_and_no_others() -> None:
    model = tree((0.2, 1.2), (-1.0, -0.4), (-1.0, 1.0), (0.0, 1.0))
    made, beyond = freed(model, np.array([0.0, 0.0, 0.5, -1e-9]))
    assert [str(one) for one in beyond] == ["hinge0 at 0, below 0.2", "hinge1 at 0, above -0.4"]
    assert made.lowerPositionLimit == pytest.approx([-np.inf, -1.0, -1.0, -1e-9])
    assert made.upperPositionLimit == pytest.approx([1.2, np.inf, 1.0, 1.0])
    # The model that was given stays as it was.
    assert model.lowerPositionLimit[0] == 0.2
    assert freed(model, np.array([0.3, -0.5, 0.0, 0.0]))[0] is model


def leg(folder: Path, ram: str, femur: str, knee: str, home: str = "") -> Path:
    """Write a leg with a ram from hip to heel; femur and shank have 0.36 m each."""
    inertial = '<inertial pos="0 0 -.1" mass="1" diaginertia=".01 .01 .01"/>'
    path = folder / "leg.xml"
    path.write_text(
        f"""<mujoco><compiler angle="radian"/><worldbody>
        <body name="ram"><joint name="length" type="slide" axis="0 0 -1" range="{ram}"/>{inertial}
         <site name="a"/></body>
        <body name="femur"><joint name="femur" axis="0 1 0" range="{femur}"/>{inertial}
         <body name="shank" pos=".36 0 0"><joint name="knee" axis="0 1 0" range="{knee}"/>
          {inertial}<site name="b" pos="-.36 0 0"/></body></body>
        </worldbody><equality><connect site1="a" site2="b"/></equality>
        <actuator><motor joint="length"/></actuator>{home}</mujoco>""",
        encoding="utf-8",
    )
    return path


def in_leg(length: float) -> Array:
    """Return ram, femur and knee of a leg of so many meters, by trigonometry."""
    angle = np.arcsin(length / 0.72)
    return np.array([length, angle, -2.0 * angle])


def test_a_home_within_all_ranges_is_found_where_there_is_one(tmp_path: Path) -> None:
    """Ranges that leave a small corner: the ram from 0.5 m, and the knee up to 1.7."""
    robot = psp3.ClosedLoopRobot.from_mjcf(leg(tmp_path, ".5 .7", ".17 1.2", "-1.7 -.35"))
    assert not robot.without_limits
    assert robot.reference[0] >= 0.5
    assert robot.q0 == pytest.approx(in_leg(robot.reference[0]), abs=1e-9)
    assert robot.configuration(robot.reference) == pytest.approx(robot.q0, abs=1e-9)


def test_ranges_that_contradict_the_loops_are_told_and_left_out(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """The ram from 0.5 m asks for a knee of −1.53 and more: up to −1 there is none.

    As in public files, whose zero pose is outside. The robot still answers, at home and away from
    the limits that it keeps.
    """
    begun = time.process_time()
    with caplog.at_level(logging.WARNING):
        robot = psp3.ClosedLoopRobot.from_mjcf(leg(tmp_path, ".5 .7", ".17 1.2", "-1 -.35"))
    assert time.process_time() - begun < 5.0
    assert robot.without_limits
    for one in robot.without_limits:
        assert f"{one.joint} at {one.position:.6g}" in caplog.text
        assert one.limit in (0.5, -1.0)
    for step in (-0.05, -0.02, 0.0):
        q = robot.configuration(robot.reference + step)
        assert q == pytest.approx(in_leg(q[0]), abs=1e-9)


def test_a_given_home_outside_the_ranges_is_kept(tmp_path: Path) -> None:
    numbers = " ".join(f"{one:.17g}" for one in in_leg(0.6))
    home = f'<keyframe><key name="home" qpos="{numbers}"/></keyframe>'
    robot = psp3.ClosedLoopRobot.from_mjcf(leg(tmp_path, ".1 .7", ".17 1.2", "-1 -.35", home))
    assert robot.q0 == pytest.approx(in_leg(0.6), abs=1e-12)
    assert [one.joint for one in robot.without_limits] == ["knee"]
    # From the fold of the leg to nearly straight, beyond a limit that home is beyond.
    assert robot.configuration([0.65]) == pytest.approx(in_leg(0.65), abs=1e-9)


def test_from_a_home_at_a_limit_motions_away_from_it_are_answered(tmp_path: Path) -> None:
    numbers = " ".join(f"{one:.17g}" for one in in_leg(0.3))
    home = f'<keyframe><key name="home" qpos="{numbers}"/></keyframe>'
    knee = f"-2.4 {in_leg(0.3)[2]:.17g}"
    robot = psp3.ClosedLoopRobot.from_mjcf(leg(tmp_path, ".1 .7", "0 1.2", knee, home))
    assert not robot.without_limits
    for length in (0.3, 0.3 + 1e-6, 0.31, 0.5):
        assert robot.configuration([length]) == pytest.approx(in_leg(length), abs=1e-9)
    with pytest.raises(psp3.errors.JointLimitExceeded, match="knee"):
        robot.configuration([0.29])
