"""Robots put together from poses whose loops are open."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

from psp3.closure import NO_MOTORS, assembled, flattened, residual
from psp3.closure.assembly import MOST_EVALUATIONS, nearly_closed
from psp3.errors import ClosureFailed
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.psp3.closure.linkages import away, five_bar


def test_an_open_tree_is_assembled_within_its_joint_limits(parts: SimpleNamespace) -> None:
    """From configurations that leave the loops open by tenths.

    The residual falls below 1e-9 and limits hold.
    """
    table, rng = (
        flattened(parts.model, parts.constraint_models, NO_MOTORS),
        np.random.default_rng(12),
    )
    for _ in range(3):
        start = away(parts, rng)
        assert np.abs(residual(table, start)).max() > 1e-3
        assert np.abs(residual(table, assembled(parts.model, table, start))).max() < 1e-9


def test_a_robot_near_its_closure_is_assembled_without_the_optimizer(
    parts: SimpleNamespace, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Loading any robot asks for this, and the optimizer's import takes longer than the rest."""
    table, rng = (
        flattened(parts.model, parts.constraint_models, NO_MOTORS),
        np.random.default_rng(15),
    )
    monkeypatch.setattr(
        "scipy.optimize.least_squares", lambda *_, **__: pytest.fail("the optimizer was asked")
    )
    start = pin.integrate(parts.model, parts.q0, rng.uniform(-0.02, 0.02, parts.model.nv))
    closed = assembled(parts.model, table, start)
    assert np.abs(residual(table, closed)).max() < 1e-9
    # The shortest way: what the start was off by, and not more.
    assert np.linalg.norm(pin.difference(parts.model, start, closed)) <= 1.05 * np.linalg.norm(
        pin.difference(parts.model, start, parts.q0)
    )


def test_a_robot_without_a_reference_pose_is_assembled() -> None:
    """With all joints at zero the legs do not meet."""
    robot = five_bar()
    without = ClosedLoopRobot(robot.model, robot.constraint_models, robot.actuated)
    assert (
        np.abs(
            residual(flattened(without.model, without.constraint_models, NO_MOTORS), without.q0)
        ).max()
        < 1e-13
    )


def test_links_too_short_to_meet_are_refused_with_the_residual() -> None:
    robot = five_bar()
    loops = pin.StdVec_RigidConstraintModel()
    loop = pin.RigidConstraintModel(robot.constraint_models[0])
    # Five meters apart.
    loop.joint2_placement = pin.SE3(np.eye(3), np.array([0.0, 0.0, 5.0]))
    loops.append(loop)
    with pytest.raises(ClosureFailed) as caught:
        ClosedLoopRobot(robot.model, loops, robot.actuated)
    assert_allclose(caught.value.residual, 5.0, rtol=0.2)


def test_a_search_along_a_valley_that_ends_open_comes_to_an_end() -> None:
    """Two links of 1 m whose ends are to meet 3 m away, in ever smaller steps if nothing ends them.

    Each start may ask for the equations so often, and for the derivatives no more often.
    """
    model = pin.Model()
    for name, at in (("a", 0.0), ("b", 3.0)):
        place = pin.SE3(np.eye(3), np.array([at, 0.0, 0.0]))
        joint = model.addJoint(0, pin.JointModelRZ(), place, name)
        model.appendBodyToJoint(joint, pin.Inertia.Random(), pin.SE3.Identity())
    tip = pin.SE3(np.eye(3), np.array([1.0, 0.0, 0.0]))
    loop = pin.RigidConstraintModel(
        pin.ContactType.CONTACT_3D, model, 1, tip, 2, tip, pin.ReferenceFrame.LOCAL
    )
    flat = flattened(model, [loop], NO_MOTORS)
    asked = 0

    def counted(*arguments: object) -> object:
        nonlocal asked
        asked += 1
        return residual(*arguments)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("psp3.closure.assembly.residual", counted)
        _, least = next(nearly_closed(model, flat, np.array([0.3, 2.0])))
    assert asked <= MOST_EVALUATIONS + 2
    assert_allclose(least, 1.0, rtol=0, atol=1e-6)
