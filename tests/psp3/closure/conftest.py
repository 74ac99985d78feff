"""What tests of closures share."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.helpers import ROBOTS_WITH_LIE_GROUPS, ROBOTS_WITH_LOOPS


@pytest.fixture(
    scope="module",
    params=ROBOTS_WITH_LOOPS + ROBOTS_WITH_LIE_GROUPS,
    ids=lambda builder: builder.__name__,
)
def parts(request: pytest.FixtureRequest) -> SimpleNamespace:
    parts: SimpleNamespace = request.param()
    return parts


@pytest.fixture(scope="module")
def robot(parts: SimpleNamespace) -> ClosedLoopRobot:
    return ClosedLoopRobot(parts.model, parts.constraint_models, parts.actuated, parts.q0)
