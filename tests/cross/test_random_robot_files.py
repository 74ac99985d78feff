"""Robots that hypothesis makes up, written to files and read back: the same robots."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, event, given, settings

from psp3.errors import MasslessBody, PSP3Error, UnexportableJoint
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from psp3.robots.mjcf_export import to_mjcf
from tests import examples
from tests.cross.test_random_robots import SEEDS, State, made, somewhere
from tests.strategies.robot_files import WRITTEN, written_urdf
from tests.strategies.robots import JOINTS, Parts, robots, simple_joints

pytestmark = pytest.mark.slow

OF_FILES = settings(
    max_examples=examples(1000, of=25),
    suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow],
)

IN_MJCF = tuple(kind for kind in JOINTS if kind not in ("planar", "free"))

READ_BACK = 1e-9
"""Of the terms of a force: angles of placements are written with all digits, but rounded."""


def is_the_same(read: ClosedLoopRobot, state: State) -> None:
    """Check that a robot that was read has the dynamics of the one that was written."""
    names, first = state.robot.coordinates, read.coordinates
    assert sorted(names) == sorted(first)
    assert len(state.robot.reference) == len(names), "only coordinates of one number have an order"
    order = [names.index(name) for name in first]
    x, v = state.positions[order], state.speeds[order]
    M, C, G = state.robot.equation_of_motion(state.positions, state.speeds)
    mass, coriolis, gravity = read.equation_of_motion(x, v)
    for ours, theirs in (
        (mass, M[np.ix_(order, order)]),
        (coriolis @ v, (C @ state.speeds)[order]),
        (gravity, G[order]),
    ):
        assert np.abs(ours - theirs).max() < READ_BACK * state.size


@OF_FILES
@given(robots(kinds=WRITTEN, bases=(), layouts=("any", "grid"), couplings=False), SEEDS)
def test_a_urdf_with_its_loop_file(parts: Parts, seed: int) -> None:
    """All joints are motors, so that the order of the file chooses nothing but coordinates."""
    parts = parts._replace(actuated=tuple(simple_joints(parts.model)), springs={})
    state = somewhere(made(parts), seed)
    with tempfile.TemporaryDirectory() as folder:
        urdf, yaml, srdf = written_urdf(parts, Path(folder))
        read = ClosedLoopRobot.from_urdf(urdf, yaml, srdf)
    read.model.gravity = parts.model.gravity
    is_the_same(read, state)


@OF_FILES
@given(robots(kinds=IN_MJCF, bases=()), SEEDS)
def test_an_mjcf(parts: Parts, seed: int) -> None:
    """MJCF has no word for a base on a plane, which would be kept: it has slides and a hinge."""
    state = somewhere(made(parts._replace(free="lock")), seed)
    assume(len(state.robot.reference) == len(state.robot.coordinates))
    try:
        text = to_mjcf(state.robot)
    except (UnexportableJoint, MasslessBody) as error:
        event(f"not exported: {type(error).__name__}")
        assume(False)
        raise
    except PSP3Error as error:
        event(f"refused: {error}")
        assume(False)
        raise
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "random.xml"
        file.write_text(text, encoding="utf-8")
        read = ClosedLoopRobot.from_mjcf(file)
    is_the_same(read, state)
