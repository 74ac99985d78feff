"""What the routes read of a robot: loops, motors and home, and the order of its joints."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import psp3
from psp3.dynamics.mechanism import Mechanism, check_order
from psp3.errors import (
    DisorderedJoints,
    InvalidArray,
    MobilityMismatch,
    SingularConfiguration,
    UnknownName,
)
from tests.helpers import four_bar_closed_with_6d


def test_what_is_missing_is_no_loops_every_joint_and_neutral() -> None:
    """As of the robots of example-robot-data, which say None."""
    model = four_bar_closed_with_6d().model
    for robot in (
        SimpleNamespace(model=model),
        SimpleNamespace(model=model, constraint_models=None, actuated=None, q0=None),
    ):
        mechanism = Mechanism(robot)
        assert (mechanism.loops, mechanism.rows) == ([], 0)
        assert mechanism.names == ("j1", "j2", "j3", "j4")
        assert_array_equal(mechanism.actuated, np.arange(4))
        assert mechanism.dependent.size == 0
        assert_array_equal(mechanism.home(), np.zeros(4))


def test_motors_are_in_the_order_of_their_names() -> None:
    parts = four_bar_closed_with_6d()
    parts.actuated = ("j3", "j1")
    mechanism = Mechanism(parts)
    assert_array_equal(mechanism.actuated, [2, 0])
    assert_array_equal(mechanism.dependent, [1, 3])
    assert mechanism.rows == 6
    assert_array_equal(mechanism.home(), parts.q0)


def test_names_and_homes_that_are_none_are_refused() -> None:
    parts = four_bar_closed_with_6d()
    parts.actuated = ("crank",)
    with pytest.raises(UnknownName, match=r"crank.*j1"):
        Mechanism(parts)
    parts.actuated, parts.q0 = ("j1",), np.zeros(3)
    with pytest.raises(InvalidArray, match="q0"):
        Mechanism(parts).home()


def test_complement_solves_the_loops_velocity_equations() -> None:
    """Of random equations, redundant ones too, with numpy's least squares; 1e-12 is rounding."""
    rng = np.random.default_rng(0)
    mechanism = Mechanism(four_bar_closed_with_6d())
    for jacobian in (
        rng.normal(size=(3, 4)),
        rng.normal(size=(6, 3)) @ rng.normal(size=(3, 4)),
    ):
        complement, inverse = mechanism.complement(np.zeros(4), jacobian)
        expected = -np.linalg.lstsq(jacobian[:, 1:], jacobian[:, :1], rcond=1e-9)[0]
        assert_allclose(complement[1:], expected, rtol=1e-12)
        assert complement[0, 0] == 1.0
        assert_allclose(inverse @ jacobian[:, 1:], np.eye(3), rtol=0, atol=1e-12)


def test_motors_too_few_or_too_many_are_refused() -> None:
    parts = four_bar_closed_with_6d()
    jacobian = psp3.NaturalOrthogonalComplement(parts).constraint_jacobian(parts.q0)
    parts.actuated = ("j1", "j2")
    with pytest.raises(MobilityMismatch):
        Mechanism(parts).complement(parts.q0, jacobian)
    parts.actuated = ("j1",)
    with pytest.raises(SingularConfiguration):
        Mechanism(parts).complement(parts.q0, jacobian * [1.0, 1.0, 1.0, 0.0])


def test_the_order_of_joints_is_checked_as_pinocchio_checks_it() -> None:
    """All trees of six joints: refused where ``model.check`` says no, and only there."""
    refused = 0
    for number in range(720):
        model, rest = pin.Model(), number
        for joint in range(1, 7):
            rest, parent = divmod(rest, joint)
            model.addJoint(parent, pin.JointModelRZ(), pin.SE3.Identity(), f"j{joint}")
        if model.check(model.createData()):
            check_order(model)
        else:
            refused += 1
            with pytest.raises(DisorderedJoints):
                check_order(model)
    assert 0 < refused < 720
