"""Loops closed by Newton's method from home.

Against the closed form and the compiled closure, which share no code with it.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import psp3
from psp3.description.parts import THESIS_ROBOTS
from psp3.dynamics.newton_from_home import NewtonFromHome
from psp3.dynamics.projected import ProjectedDynamics
from psp3.errors import (
    ClosureFailed,
    InvalidArray,
    InvalidValue,
    JointLimitExceeded,
    SingularConfiguration,
)
from tests.helpers import ROBOTS_WITH_LIE_GROUPS, ROBOTS_WITH_LOOPS, Array, random_heights
from tests.robot_samplers import random_poses


def test_home_is_that_of_equation_3_15() -> None:
    """All hinges at 0 and the arms d long; 1e-15 m is rounding."""
    robot = psp3.load("psp3")
    q = psp3.NaturalOrthogonalComplement(robot).configuration(np.zeros(3))
    expected = np.zeros(15)
    for leg in (1, 2, 3):
        expected[robot.model.joints[robot.model.getJointId(f"b{leg}")].idx_q] = 0.181
    assert_allclose(q, expected, rtol=0, atol=1e-15)


def test_configurations_are_those_of_the_closed_form() -> None:
    """200 poses with tilts up to 48 degrees; 1e-12 m and rad.

    Newton's method leaves 1e-15, and the closures' condition number is at most 300 here.
    """
    robot = psp3.load("psp3")
    heights = random_heights(np.random.default_rng(31), 200)
    found = psp3.NaturalOrthogonalComplement(robot).configuration(heights)
    assert_allclose(found, robot.configuration(heights), rtol=0, atol=1e-12)
    assert_array_equal(found[:, robot.actuated_q], heights)


@pytest.mark.parametrize("name", THESIS_ROBOTS[1:])
def test_configurations_of_the_other_robots_are_those_of_the_compiled_closure(name: str) -> None:
    """Ten poses drawn from the whole workspace by the literature's inverse kinematics; 1e-11.

    The residual is 1e-15, and the poses keep 5 % of home's determinants.
    """
    robot = psp3.load(name)
    noc = psp3.NaturalOrthogonalComplement(robot)
    positions = random_poses(name, 10, np.random.default_rng(32))
    found = noc.configuration(positions)
    assert_allclose(found, robot.configuration(positions), rtol=0, atol=1e-11)
    assert_array_equal(found[:, robot.actuated_q], positions)
    assert np.abs(noc.constraint(found)).max() < 1e-13


@pytest.mark.parametrize("builder", [*ROBOTS_WITH_LOOPS, *ROBOTS_WITH_LIE_GROUPS])
def test_loops_through_every_kind_of_joint_close(builder: Any) -> None:
    """Redundant closures, ball joints, a free body, an angle as cosine and sine.

    Up to 0.5 rad from home, against the compiled closure; 1e-12 in the tangent space.
    """
    parts = builder()
    robot = psp3.ClosedLoopRobot(parts.model, parts.constraint_models, parts.actuated, parts.q0)
    noc = psp3.NaturalOrthogonalComplement(parts)
    shifts = 0.5 * np.linspace(-1.0, 1.0, 5)[:, np.newaxis] * np.eye(len(parts.actuated))[0]
    for positions in robot.reference + shifts:
        expected = robot.configuration(positions)
        off = pin.difference(parts.model, expected, noc.configuration(positions))
        assert np.abs(off).max() < 1e-12


def test_steps_keep_the_assembly_mode_where_one_iteration_does_not() -> None:
    """A Delta: Newton's method straight from home misses most of these 20 poses.

    Written out with numpy alone. Of the 3-PSP it finds all of them.
    """
    missed = {}
    for name in ("psp3", "delta"):
        robot, rng = psp3.load(name), np.random.default_rng(3)
        noc = psp3.NaturalOrthogonalComplement(robot)
        positions = random_heights(rng, 20) if name == "psp3" else random_poses(name, 20, rng)
        places = robot.actuated_q
        # Every joint of these two trees has one coordinate, its velocity index.
        others = robot.dependent_v
        closed = noc.configuration(positions)
        straight = []
        for row in positions:
            q = np.array(robot.q0)
            q[places] = row
            for _ in range(50):
                slope = noc.constraint_jacobian(q)[:, others]
                q[others] -= np.linalg.lstsq(slope, noc.constraint(q), rcond=1e-9)[0]
            straight.append(q)
        missed[name] = int((np.abs(np.array(straight) - closed).max(axis=1) > 1e-6).sum())
    assert missed["psp3"] == 0
    assert missed["delta"] > 10


def folding() -> tuple[psp3.ClosedLoopRobot, Array]:
    """Return a five-bar and cranks so far apart that its rods do not meet."""
    return psp3.load("five_bar"), np.array([-1.5, 1.5])


def test_the_border_of_the_workspace_ends_the_way() -> None:
    """At the same share of it as the compiled closure's, to 1e-3."""
    robot, apart = folding()
    noc = psp3.NaturalOrthogonalComplement(robot)
    with pytest.raises(ClosureFailed) as theirs:
        robot.configuration(apart)
    with pytest.raises(ClosureFailed, match="past a singularity") as caught:
        noc.equation_of_motion(apart, np.zeros(2))
    assert 0.0 < caught.value.reached < 1.0
    assert caught.value.reached == pytest.approx(theirs.value.reached, abs=1e-3)
    assert_array_equal(caught.value.positions, apart)
    assert caught.value.residual > 0.01


def test_limits_of_the_other_joints_are_kept() -> None:
    """Legs that would pull an arm through its ball joint, as the compiled closure refuses them."""
    robot = psp3.load("psp3")
    for model in (robot.dynamics("noc"), robot.dynamics("pinocchio")):
        with pytest.raises(JointLimitExceeded) as caught:
            model.actuator_forces([0.0, -0.5, 0.5], np.zeros(3), np.zeros(3))
        assert (caught.value.joint, caught.value.lower) == ("b1", 0.0)
        assert caught.value.position < 0.0


@pytest.mark.parametrize("heights", [[1e200, 1e200, 1e200], [0.0, 0.0, 1e10], [1e4, 1e4, 1e4]])
def test_absurd_positions_are_refused_soon(heights: list[float]) -> None:
    """Not after as many steps as they are far."""
    with pytest.raises(ClosureFailed):
        psp3.load("psp3").dynamics("noc").equation_of_motion(heights, np.zeros(3))


def complement_of(robot: Any, q0: Array) -> psp3.NaturalOrthogonalComplement:
    return psp3.NaturalOrthogonalComplement(
        SimpleNamespace(
            model=robot.model,
            constraint_models=robot.constraint_models,
            actuated=robot.actuated,
            q0=q0,
        )
    )


def test_a_home_that_is_a_little_open_is_closed() -> None:
    """Every joint without a motor off by up to 0.02 rad or m; the same answers, to 1e-12."""
    robot, rng = psp3.load("delta"), np.random.default_rng(33)
    q0 = np.array(robot.q0)
    q0[robot.dependent_v] += rng.uniform(-0.02, 0.02, len(robot.dependent_v))
    positions = random_poses("delta", 3, rng)
    assert_allclose(
        complement_of(robot, q0).configuration(positions),
        robot.configuration(positions),
        rtol=0,
        atol=1e-12,
    )


def test_a_home_that_is_none_is_refused() -> None:
    """A five-bar whose cranks are too far apart for its rods."""
    robot, apart = folding()
    q0 = np.array(robot.q0)
    q0[robot.actuated_q] = apart
    with pytest.raises(ClosureFailed) as caught:
        complement_of(robot, q0).configuration(robot.reference)
    assert caught.value.reached == 0.0
    assert caught.value.residual > 0.01


class Waves:
    """Two sliders x and y, held together by sin 10 y = 0.9 sin 10 x; x is driven.

    From home y stays below 0.12. Other assembly modes, y + 0.2 pi and so on, have the same sign of
    the determinant, so that it does not tell them apart. Configurations at which the complement was
    asked for are in ``closed``.
    """

    def __init__(self) -> None:
        self.model = pin.Model()
        for name, parent in (("x", 0), ("y", 1)):
            self.model.addJoint(parent, pin.JointModelPX(), pin.SE3.Identity(), name)
        self.closed: list[Array] = []
        self.fail_at = -1

    def constraint(self, q: Array) -> tuple[Array, Array]:
        """Return the residual and its derivative."""
        x, y = 10.0 * q
        return (
            np.array([np.sin(y) - 0.9 * np.sin(x)]),
            10.0 * np.array([[-0.9 * np.cos(x), np.cos(y)]]),
        )

    def complement(self, q: Array, slope: Array) -> tuple[Array, Array]:
        """Return L and the inverse."""
        if len(self.closed) == self.fail_at:
            self.fail_at = -1
            raise SingularConfiguration(0, 1, np.inf)
        self.closed.append(q)
        return np.array([[1.0], [-slope[0, 0] / slope[0, 1]]]), 1.0 / slope[:, 1:]

    def closed_at(self, x: float) -> float:
        """Return y at x."""
        way = NewtonFromHome(self.model, ["x"], np.zeros(2), self.constraint, self.complement)
        return float(way.closed(np.array([x])).q[1])


@pytest.mark.parametrize("x", [0.3, -1.0, 2.0])
def test_large_corrections_are_not_trusted(x: float) -> None:
    """The branch of home, in closed form; 1e-12. And no step is longer than 0.25 m, by a third."""
    waves = Waves()
    assert waves.closed_at(x) == pytest.approx(np.arcsin(0.9 * np.sin(10.0 * x)) / 10.0, abs=1e-12)
    steps = np.abs(np.diff(waves.closed, axis=0)).max(axis=1)
    assert steps.max() <= 0.33


def shifted(away: float) -> Array:
    """Return x and y at x = 0.5 of two sliders that y = x + away holds together."""
    slope = np.array([[-1.0, 1.0]])
    way = NewtonFromHome(
        Waves().model,
        ["x"],
        np.zeros(2),
        lambda q: (np.array([q[1] - q[0] - away]), slope),
        lambda q, slope: (np.ones((2, 1)), np.ones((1, 1))),
    )
    return way.closed(np.array([0.5])).q


def test_a_home_that_closes_far_away_is_refused() -> None:
    """By one step of 1.2 m, which may lead to anything but what was meant; 0.8 m is taken."""
    assert_allclose(shifted(0.8), [0.5, 1.3], rtol=0, atol=1e-15)
    with pytest.raises(ClosureFailed, match="after 0 %"):
        shifted(1.2)


def test_a_singular_step_is_made_shorter() -> None:
    """A step that happens to end at a singularity is not the end of the way."""
    waves = Waves()
    waves.fail_at = 3
    assert waves.closed_at(1.0) == pytest.approx(np.arcsin(0.9 * np.sin(10.0)) / 10.0, abs=1e-12)
    assert waves.fail_at == -1


@pytest.mark.parametrize("route", [psp3.NaturalOrthogonalComplement, ProjectedDynamics])
def test_a_loop_that_is_said_twice_changes_nothing(route: Any) -> None:
    """Redundant equations, whose corrections come from the normal ones; 1e-12 m and rad."""
    robot = psp3.load("psp3")
    twice = SimpleNamespace(
        model=robot.model,
        constraint_models=[*robot.constraint_models, *robot.constraint_models],
        actuated=robot.actuated,
        q0=robot.q0,
    )
    heights = random_heights(np.random.default_rng(36), 20)
    expected = robot.configuration(heights)
    assert_allclose(route(twice).configuration(heights), expected, rtol=0, atol=1e-12)


def test_a_step_whose_equations_are_singular_is_the_shortest_that_serves() -> None:
    """Two sliders y and z of which the loop knows only the sum, at a home that is 0.2 m open.

    Elimination fails; by singular values each moves by 0.1 m. That no motor determines them is
    said afterwards.
    """
    model = pin.Model()
    for parent, name in enumerate("xyz"):
        model.addJoint(parent, pin.JointModelPX(), pin.SE3.Identity(), name)
    slope = np.array([[-1.0, 1.0, 1.0], [-2.0, 2.0, 2.0]])
    closed = []

    def complement(q: Array, jacobian: Array) -> tuple[Array, Array]:
        closed.append(q)
        raise SingularConfiguration(1, 2, np.inf)

    with pytest.raises(SingularConfiguration):
        NewtonFromHome(
            model,
            ["x"],
            np.zeros(3),
            lambda q: (slope @ q - 0.2 * slope[:, 1], slope),
            complement,
        )
    assert_allclose(closed, [[0.0, 0.1, 0.1]], rtol=0, atol=1e-15)


def test_without_loops_the_positions_are_the_configuration() -> None:
    robot = psp3.load("five_bar")
    arm = SimpleNamespace(model=robot.model, constraint_models=[], actuated=None)
    positions = np.random.default_rng(34).uniform(-1.0, 1.0, (3, 4))
    assert_array_equal(psp3.NaturalOrthogonalComplement(arm).configuration(positions), positions)


def test_a_motor_of_several_coordinates_is_refused() -> None:
    """A free body has seven; what it is asked for is one position a motor."""
    model = pin.Model()
    model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "base")
    noc = psp3.NaturalOrthogonalComplement(SimpleNamespace(model=model))
    with pytest.raises(InvalidValue, match="one coordinate"):
        noc.configuration(np.zeros(6))


def test_shapes_and_malformed_positions() -> None:
    noc = psp3.NaturalOrthogonalComplement(psp3.load("psp3"))
    heights = random_heights(np.random.default_rng(35), 6)
    found = noc.configuration(heights.reshape(2, 3, 3))
    assert found.shape == (2, 3, 15)
    assert_array_equal(found[1, 2], noc.configuration(heights[5]))
    assert noc.configuration(np.zeros((0, 3))).shape == (0, 15)
    for bad in ([0.0, np.nan, 0.0], np.zeros(2), "home", None):
        with pytest.raises(InvalidArray, match="positions"):
            noc.configuration(bad)
