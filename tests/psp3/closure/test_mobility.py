"""Mobility by rank: textbook mechanisms, redundant closures, too few and too many motors."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import psp3
from psp3.closure.mobility import Mobility, mobility
from psp3.errors import ClosureFailed, MobilityMismatch, UnknownName
from tests.helpers import (
    four_bar_closed_with_3d,
    four_bar_closed_with_6d,
    spatial_loop_closed_with_3d,
    spatial_loop_of_every_joint,
)

TEXTBOOK = [
    # builder, degrees of freedom, closure equations, rank
    (four_bar_closed_with_6d, 1, 6, 3),
    (four_bar_closed_with_3d, 1, 3, 2),
    (spatial_loop_closed_with_3d, 2, 3, 3),
    (spatial_loop_of_every_joint, 1, 6, 6),
]


@pytest.mark.parametrize(
    ("builder", "freedoms", "equations", "rank"),
    TEXTBOOK,
    ids=lambda value: getattr(value, "__name__", None),
)
def test_degrees_of_freedom_of_textbook_mechanisms(
    builder: object, freedoms: int, equations: int, rank: int
) -> None:
    assert callable(builder)
    parts = builder()
    found = mobility(parts.model, parts.constraint_models, parts.actuated, parts.q0)
    assert (found.degrees_of_freedom, found.closure_equations, found.rank) == (
        freedoms,
        equations,
        rank,
    )
    assert found.redundant_equations == equations - rank
    assert found.under_actuation == found.over_actuation == 0
    assert found.by_counting == parts.model.nv - equations


def test_counting_equations_is_wrong_where_they_repeat_each_other() -> None:
    """The planar four-bar in space: Chebyshev, Grübler and Kutzbach count −2 degrees of freedom.

    It has one.
    """
    parts = four_bar_closed_with_6d()
    found = mobility(parts.model, parts.constraint_models, ("j1",), parts.q0)
    assert (found.by_counting, found.degrees_of_freedom) == (-2, 1)


def test_too_few_motors_leave_joints_free(star: psp3.PSP3) -> None:
    found = mobility(star.model, star.constraint_models, ("a1", "a2"), star.q0)
    assert (found.under_actuation, found.over_actuation) == (1, 0)
    assert "a3" in found.free_joints
    assert "a1" not in found.free_joints
    assert "under-actuated" in str(found)


def test_too_many_motors_are_named(star: psp3.PSP3) -> None:
    found = mobility(star.model, star.constraint_models, ("a1", "a2", "a3", "b1"), star.q0)
    assert (found.under_actuation, found.over_actuation, found.dependent_actuators) == (
        0,
        1,
        ("b1",),
    )
    assert "over-actuated" in str(found)


def test_right_in_number_but_wrong_in_kind(star: psp3.PSP3) -> None:
    """b1 to b3 are three motors for three degrees of freedom.

    But no set of arm lengths holds the common height.
    """
    found = mobility(star.model, star.constraint_models, ("b1", "b2", "b3"), star.q0)
    assert (found.degrees_of_freedom, found.actuators, found.commanded) == (3, 3, 2)
    assert {"a1", "a2", "a3"} <= set(found.free_joints)
    with pytest.raises(MobilityMismatch) as caught:
        psp3.ClosedLoopRobot(
            star.model, star.constraint_models, ("b1", "b2", "b3"), star.q0, free="refuse"
        )
    assert caught.value.mobility == found


def test_a_singular_reference_pose_does_not_pass_for_the_usual() -> None:
    """A parallelogram laid flat can fold either way.

    Its closures lose a rank there, and there only.
    """
    model = pin.Model()
    body = pin.Inertia(1.0, np.zeros(3), np.eye(3))
    for parent, x, name in ((0, 0.0, "crank"), (1, 0.2, "coupler"), (0, 0.5, "rocker")):
        joint = model.addJoint(
            parent, pin.JointModelRZ(), pin.SE3(np.eye(3), np.array([x, 0.0, 0.0])), name
        )
        model.appendBodyToJoint(joint, body, pin.SE3.Identity())
    loops = pin.StdVec_RigidConstraintModel()
    ends = [pin.SE3(np.eye(3), np.array([x, 0.0, 0.0])) for x in (0.5, 0.2)]
    loops.append(
        pin.RigidConstraintModel(
            pin.ContactType.CONTACT_3D, model, 2, ends[0], 3, ends[1], pin.ReferenceFrame.LOCAL
        )
    )
    assert mobility(model, loops, ("crank",), np.zeros(3)).degrees_of_freedom == 1


def test_a_robot_without_loops_moves_in_every_joint() -> None:
    model = pin.buildSampleModelManipulator()
    found = mobility(model, [], list(model.names)[1:])
    assert found == Mobility(model.nv, model.nv, model.nv, model.nv, 0, 0, (), ())


def test_robots_know_their_mobility(star: psp3.PSP3) -> None:
    assert star.mobility.degrees_of_freedom == 3
    assert str(star.mobility).startswith(
        "3 degrees of freedom (15 joint velocities less 12 independent of 12 closure equations)"
    )


@pytest.mark.parametrize("name", ["a4", "universe"])
def test_a_name_that_is_no_joint_is_refused(star: psp3.PSP3, name: str) -> None:
    with pytest.raises(UnknownName, match="b3"):
        mobility(star.model, star.constraint_models, ("a1", name), star.q0)


@pytest.mark.slow
def test_loops_that_cannot_be_closed_are_refused() -> None:
    parts = four_bar_closed_with_3d()
    parts.constraint_models[0].joint2_placement = pin.SE3(np.eye(3), np.array([9.0, 0.0, 0.0]))
    with pytest.raises(ClosureFailed):
        mobility(parts.model, parts.constraint_models, ("j1",), parts.q0)


@pytest.fixture(scope="module")
def star() -> psp3.PSP3:
    return psp3.load("psp3")
