"""What tests of the core share: small robots with every kind of joint, open and closed."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest

from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.helpers import ROBOTS_WITH_LIE_GROUPS, ROBOTS_WITH_LOOPS, Array
from tests.psp3.multibody.flat import Flat, flat_of


@pytest.fixture(
    scope="module",
    params=ROBOTS_WITH_LOOPS + ROBOTS_WITH_LIE_GROUPS,
    ids=lambda builder: builder.__name__,
)
def parts(request: pytest.FixtureRequest) -> SimpleNamespace:
    parts: SimpleNamespace = request.param()
    # Motors turn with the joints; a ball's are alike about all axes, and a free body has none.
    armature = np.linspace(0.01, 0.05, parts.model.nv)
    for joint in list(parts.model.joints)[1:]:
        if joint.nq in (4, 7):
            armature[joint.idx_v : joint.idx_v + joint.nv] = 0.03 if joint.nq == 4 else 0.0
    parts.model.armature = armature
    return parts


@pytest.fixture(scope="module")
def robot(parts: SimpleNamespace) -> ClosedLoopRobot:
    return ClosedLoopRobot(parts.model, parts.constraint_models, parts.actuated, parts.q0)


@pytest.fixture
def flat(parts: SimpleNamespace) -> Flat:
    return flat_of(parts)


@pytest.fixture
def pose(parts: SimpleNamespace, robot: ClosedLoopRobot) -> Array:
    """Return a closed configuration that is not the reference."""
    rng = np.random.default_rng(21)
    position = robot.reference + rng.uniform(-0.15, 0.15, len(robot.actuated))
    return np.asarray(robot.dynamics("pinocchio").configuration(position))  # type: ignore[attr-defined]


@pytest.fixture
def anywhere(parts: SimpleNamespace) -> Array:
    """Return a configuration that leaves the loops open."""
    step = np.random.default_rng(22).uniform(-0.4, 0.4, parts.model.nv)
    return np.asarray(pin.integrate(parts.model, parts.q0, step))
