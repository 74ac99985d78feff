"""Connection degrees, chains and what is fully parallel: counted by hand on the shipped robots."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import psp3
from psp3.closure.chains import connection_degrees, is_fully_parallel, kinematic_chains
from psp3.errors import InvalidValue, UnknownName
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.helpers import four_bar_closed_with_3d, four_bar_closed_with_6d

SHIPPED = ("psp3", "five_bar", "planar_3rrr", "delta", "gough_stewart", "tricept")

# Links in all, with the base; degrees of base and end effector; how many others have which degree.
COUNTED = {
    # Three chains of a nut and three parts of a ball joint; the star is the thirteenth body.
    "psp3": (14, 3, 3, {2: 12}),
    # A ring of five.
    "five_bar": (5, 2, 2, {2: 3}),
    "planar_3rrr": (8, 3, 3, {2: 6}),
    # Upper arms hold two rods each, the platform six. A rod swings on a cross; one of the six has
    # two parts of its ball joint beyond it, the others are closed by theirs.
    "delta": (19, 3, 6, {3: 3, 2: 14}),
    # Legs of two parts on a cross; the first one has two parts of its ball joint.
    "gough_stewart": (22, 6, 6, {2: 20}),
    # Three legs of two parts on a cross, and one without a motor of which the platform is the end.
    "tricept": (13, 4, 4, {2: 11}),
}

CHAINS = {
    "psp3": 3,
    "five_bar": 2,
    "planar_3rrr": 3,
    "delta": 3,
    "gough_stewart": 6,
    "tricept": 4,
}


@pytest.fixture(scope="module")
def robots() -> dict[str, ClosedLoopRobot]:
    return {name: psp3.load(name) for name in SHIPPED}


@pytest.mark.parametrize("name", SHIPPED)
def test_connection_degrees_are_those_counted_by_hand(
    name: str, robots: dict[str, ClosedLoopRobot]
) -> None:
    model = robots[name].model
    degrees = connection_degrees(model, robots[name].constraint_models)
    end = str(model.names[model.frames[model.getFrameId("tip")].parentJoint])
    ends = [link for link in degrees if "universe" in link or end in link]
    others = [degree for link, degree in degrees.items() if link not in ends]
    assert ends[0] == ("universe",)
    assert (
        len(degrees),
        *(degrees[link] for link in ends),
        {k: others.count(k) for k in others},
    ) == (COUNTED[name])


def test_thirds_of_the_star_are_one_link(robots: dict[str, ClosedLoopRobot]) -> None:
    star = robots["psp3"]
    assert connection_degrees(star.model, star.constraint_models)["b1", "b2", "b3"] == 3


@pytest.mark.parametrize("name", SHIPPED)
def test_chains_are_the_legs(name: str, robots: dict[str, ClosedLoopRobot]) -> None:
    """Every motor that does not carry the end effector is in a chain of its own."""
    robot = robots[name]
    chains = kinematic_chains(robot.model, robot.constraint_models)
    assert len(chains) == CHAINS[name]
    assert [sum(motor in chain for chain in chains) for motor in robot.actuated] == [1] * len(
        robot.actuated
    )
    assert max(sum(motor in chain for motor in robot.actuated) for chain in chains) == 1
    assert ("center_universal_x", "center_universal_y") in chains or name != "tricept"


@pytest.mark.parametrize("name", SHIPPED)
def test_all_but_the_tricept_are_fully_parallel(
    name: str, robots: dict[str, ClosedLoopRobot]
) -> None:
    """Its fourth chain has no motor. The 3-PSP is, as the thesis says after Fig. 25."""
    robot = robots[name]
    found = is_fully_parallel(robot.model, robot.constraint_models, robot.actuated, q=robot.q0)
    assert found == (name != "tricept")


def test_motors_of_another_number_or_in_the_wrong_place_make_none(
    robots: dict[str, ClosedLoopRobot],
) -> None:
    star = robots["psp3"]
    for motors in (("a1", "a2"), ("a1", "a2", "a3", "b1"), ("b1", "b2", "b3")):
        assert not is_fully_parallel(star.model, star.constraint_models, motors, q=star.q0)


@pytest.mark.parametrize("builder", [four_bar_closed_with_3d, four_bar_closed_with_6d])
def test_a_ring_has_two_neighbors_everywhere(builder: object) -> None:
    """However it is closed: with a ball joint, or by welding two halves of a bar."""
    assert callable(builder)
    parts = builder()
    degrees = connection_degrees(parts.model, parts.constraint_models)
    assert set(degrees.values()) == {2}
    assert len(degrees) == 4


def arm() -> pin.Model:
    """Three joints in a row, with frames on the base and at the end."""
    model = pin.Model()
    parent = 0
    for name in ("waist", "shoulder", "elbow"):
        parent = model.addJoint(parent, pin.JointModelRX(), pin.SE3.Identity(), name)
    model.addFrame(pin.Frame("tip", parent, 0, pin.SE3.Identity(), pin.FrameType.OP_FRAME))
    model.addFrame(pin.Frame("foot", 0, 0, pin.SE3.Identity(), pin.FrameType.OP_FRAME))
    return model


def test_a_serial_arm_is_one_chain() -> None:
    """Degrees 1 at both ends and 2 between: a simple kinematic chain."""
    model = arm()
    assert list(connection_degrees(model, []).values()) == [1, 2, 2, 1]
    assert kinematic_chains(model, []) == (("waist", "shoulder"),)
    motors = ("waist", "shoulder", "elbow")
    assert not is_fully_parallel(model, [], motors, q=np.zeros(3))


def test_a_single_joint_is_a_chain_without_links_between() -> None:
    model = pin.Model()
    joint = model.addJoint(0, pin.JointModelRX(), pin.SE3.Identity(), "hinge")
    model.addFrame(pin.Frame("tip", joint, 0, pin.SE3.Identity(), pin.FrameType.OP_FRAME))
    assert kinematic_chains(model, []) == ((),)


def test_what_hangs_on_one_end_only_is_no_chain() -> None:
    """A second arm on the base, and one on the end effector."""
    model = arm()
    model.addJoint(0, pin.JointModelRX(), pin.SE3.Identity(), "other arm")
    model.addJoint(3, pin.JointModelRX(), pin.SE3.Identity(), "finger")
    assert kinematic_chains(model, []) == (("waist", "shoulder"),)


def test_frames_that_are_not_there_or_do_not_move_are_refused() -> None:
    with pytest.raises(UnknownName, match="foot"):
        kinematic_chains(arm(), [], "hand")
    with pytest.raises(InvalidValue, match="fixed to the base"):
        kinematic_chains(arm(), [], "foot")
