"""What tests of kinematics share."""

from __future__ import annotations

import pytest

import psp3
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.psp3.kinematics.robots import TASKS


@pytest.fixture(scope="module")
def robots() -> dict[str, ClosedLoopRobot]:
    return {name: psp3.load(name) for name in TASKS}
