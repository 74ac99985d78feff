"""Pinocchio's derivatives along the closed loops against those of the core, which know no other."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from psp3.dynamics.derivatives import forward_dynamics_derivatives, inverse_dynamics_derivatives
from psp3.dynamics.projected import ProjectedDynamics
from psp3.dynamics.projected_derivatives import projected_derivatives
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.psp3.dynamics.test_derivatives import BUILDERS, states


@pytest.fixture(scope="module", params=BUILDERS)
def robot(request: pytest.FixtureRequest) -> ClosedLoopRobot:
    return BUILDERS[request.param]()


def test_they_are_those_of_the_core(robot: ClosedLoopRobot) -> None:
    """Every kind of joint and closure; 1e-10 of the largest entry.

    Either closes the loops by itself, to rounding times the loops' condition number.
    """
    tree = ProjectedDynamics(robot)
    for a, v, w in states(robot, 5):
        for function in (inverse_dynamics_derivatives, forward_dynamics_derivatives):
            for found, expected in zip(
                function(tree, a, v, w), function(robot, a, v, w), strict=True
            ):
                assert_allclose(found, expected, rtol=0, atol=1e-10 * np.abs(expected).max())


def test_they_are_there_for_a_pose_of_any_origin(robot: ClosedLoopRobot) -> None:
    """The robot closes its loops in the core, and says what its drift is; 1e-10 again."""
    ((a, v, w),) = states(robot, 1)
    found = projected_derivatives(robot, robot.closure(a), v, w)
    for one, expected in zip(found, robot.inverse_dynamics_derivatives(a, v, w), strict=True):
        assert_allclose(one, expected, rtol=0, atol=1e-10 * np.abs(expected).max())


def test_rows_are_singles() -> None:
    robot = BUILDERS["spatial_loop_closed_with_3d"]()
    tree = ProjectedDynamics(robot)
    rows = [np.array(column) for column in zip(*states(robot, 3), strict=True)]
    for function in (inverse_dynamics_derivatives, forward_dynamics_derivatives):
        whole = function(tree, *rows)
        for row in range(3):
            for one, part in zip(whole, function(tree, *(x[row] for x in rows)), strict=True):
                assert_array_equal(one[row], part)
