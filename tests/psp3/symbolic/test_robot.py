"""Any robot on symbols, against its own numbers, Pinocchio's steps, and differences."""

from __future__ import annotations

import casadi
import numpy as np
import pinocchio as pin
import pytest

import psp3
from psp3.errors import InvalidValue, UnknownName
from psp3.symbolic import SymbolicRobot
from psp3.symbolic.robot import DIFFERENTIABLE
from tests.helpers import Array

RIGID = ("five_bar", "delta", "gough_stewart", "psp3")
OTHERS = ("planar_3rrr", "planar_4rrr", "tricept", "hexa", "jansen", "biped", "gripper")
"""Redundant loops; more motors than freedoms; a passive leg; ball joints; one freedom; a floating
base; springs, tendon and couplings. The agile eye's own loops contradict each other by 1e-6.
"""

ROUNDING = 1e-10
"""Of the largest entry: the same operations in another order; 4e-14 is what was seen."""


@pytest.fixture(scope="module", params=(*RIGID, *OTHERS))
def symbolic(request: pytest.FixtureRequest) -> SymbolicRobot:
    return SymbolicRobot(psp3.load(request.param))


def states(symbolic: SymbolicRobot, count: int = 10) -> list[tuple[Array, Array, Array, Array]]:
    """Return positions, closed configurations, speeds, and accelerations or forces."""
    robot, rng = symbolic.robot, np.random.default_rng(7)
    home = robot.q0[robot.coordinates_q]
    n, found = symbolic.joints, []
    for _ in range(count):
        # A quaternion among the coordinates stays one.
        moved = 0.05 * rng.uniform(-1.0, 1.0, home.size) * (home.size == n)
        positions = home + moved
        q = robot.configuration(positions)
        found.append((positions, q, rng.uniform(-1.0, 1.0, n), rng.uniform(-2.0, 2.0, n)))
    return found


def assert_same(found: casadi.DM, expected: Array, tolerance: float = ROUNDING) -> None:
    expected = np.asarray(expected)
    largest = max(np.abs(expected).max(), 1e-3)
    assert np.abs(found.full().reshape(expected.shape) - expected).max() <= tolerance * largest


def test_dynamics_are_those_of_the_robot(symbolic: SymbolicRobot) -> None:
    robot = symbolic.robot
    for positions, q, speeds, third in states(symbolic):
        forces = robot.inverse_dynamics(positions, speeds, third)
        assert_same(symbolic.inverse_dynamics(q, speeds, third), forces)
        accelerations = robot.forward_dynamics(positions, speeds, third)
        assert_same(symbolic.forward_dynamics(q, speeds, third), accelerations)
        M, C, G = robot.equation_of_motion(positions, speeds)
        for found, expected in zip(symbolic.equation_of_motion(q, speeds), (M, C, G), strict=True):
            assert_same(found, expected)
        assert_same(symbolic.mass_matrix(q), M)
        assert_same(symbolic.coriolis_matrix(q, speeds), C)
        assert_same(symbolic.gravity(q), G)
        assert_same(symbolic.actuation_matrix(q), robot.actuation_matrix(positions))


def test_frames_are_where_the_robot_has_them(symbolic: SymbolicRobot) -> None:
    robot = symbolic.robot
    frames = {robot.model.frames[-1].name, robot.model.frames[robot.model.nframes // 2].name}
    for name in frames:
        frame = symbolic.frame(name)
        for positions, q, _, _ in states(symbolic, 3):
            placement = robot.frame_placement(positions, name)
            position, rotation, jacobian = frame(q)
            assert_same(position, placement[:3, 3])
            assert_same(rotation, placement[:3, :3])
            assert_same(jacobian, robot.frame_jacobian(positions, name))


def test_configuration_moves_as_pinocchio_integrates(symbolic: SymbolicRobot) -> None:
    """By central differences of a step of 1e-6, whose rounding is 1e-10."""
    model, h = symbolic.robot.model, 1e-6
    for positions, q, speeds, _ in states(symbolic, 3):
        v = symbolic.robot.velocity(positions, speeds)
        assert_same(symbolic.complement(q) @ speeds, v)
        ahead, behind = pin.integrate(model, q, h * v), pin.integrate(model, q, -h * v)
        rates = symbolic.configuration_rates(q, speeds)
        assert_same(rates, (ahead - behind) / (2.0 * h), 1e-8)


def test_closure_equations_are_zero_and_stay_so_along_the_loops(symbolic: SymbolicRobot) -> None:
    q, speeds = casadi.SX.sym("q", symbolic.robot.model.nq), casadi.SX.sym("v", symbolic.joints)
    residual = symbolic.closure_equations(q)
    along = casadi.jtimes(residual, q, symbolic.configuration_rates(q, speeds))
    change = casadi.Function("change", [q, speeds], [along])
    for _, closed, v, _ in states(symbolic, 3):
        assert np.abs(symbolic.closure_equations(closed).full()).max() < 1e-9
        assert np.abs(change(closed, v).full()).max() < 1e-9
        open_ = closed.copy()
        # The last joint is dependent, or a coordinate of a floating base's legs.
        others = np.setdiff1d(np.arange(closed.size), symbolic.robot.coordinates_q)
        open_[others] += 0.01
        assert np.abs(symbolic.closure_equations(open_).full()).max() > 1e-4


def test_closure_equations_are_the_gaps_of_points() -> None:
    """Loops of the planar five-bar join its tip in 3D: gaps as Pinocchio places the frames."""
    robot = psp3.load("five_bar")
    symbolic, data = SymbolicRobot(robot), robot.model.createData()
    rng = np.random.default_rng(1)
    for _ in range(5):
        q = robot.q0 + rng.uniform(-0.3, 0.3, robot.model.nq)
        pin.forwardKinematics(robot.model, data, q)
        (loop,) = robot.constraint_models
        one = data.oMi[loop.joint1_id] * loop.joint1_placement
        two = data.oMi[loop.joint2_id] * loop.joint2_placement
        gap = one.actInv(two.translation)
        found = symbolic.closure_equations(q).full().ravel()
        assert np.sort(np.abs(found)) == pytest.approx(np.sort(np.abs(gap)), abs=1e-12)


@pytest.mark.parametrize("name", RIGID)
def test_derivatives_are_the_analytic_ones_and_those_of_differences(name: str) -> None:
    symbolic = SymbolicRobot(psp3.load(name))
    robot, n = symbolic.robot, symbolic.joints
    inverse = symbolic.derivatives("inverse_dynamics")
    forward = symbolic.derivatives("forward_dynamics")
    assert inverse.name_out() == ["by_positions", "by_speeds", "by_accelerations"]
    assert forward.name_out() == ["by_positions", "by_speeds", "by_forces"]
    for a, q, v, w in states(symbolic, 3):
        expected = psp3.inverse_dynamics_derivatives(robot, a, v, w)
        for found, matrix in zip(inverse(q, v, w), expected, strict=True):
            assert_same(found, matrix)
        expected = psp3.forward_dynamics_derivatives(robot, a, v, w)
        for found, matrix in zip(forward(q, v, w), expected, strict=True):
            assert_same(found, matrix)
        steps = 1e-5 * np.eye(n)
        slopes = [robot.inverse_dynamics(a + e, v, w) for e in (*steps, *-steps)]
        differences = (np.array(slopes[:n]) - np.array(slopes[n:])).T / 2e-5
        # Rounding of forces over the step.
        assert_same(inverse(q, v, w)[0], differences, 1e-7)


def test_the_complement_changes_with_the_configuration() -> None:
    """Of a five-bar, by differences of the robot's own; the largest change is not small."""
    symbolic = SymbolicRobot(psp3.load("five_bar"))
    robot, by_positions = symbolic.robot, symbolic.derivatives("complement")
    a, h = robot.reference + 0.1, 1e-5
    found = by_positions(robot.configuration(a)).full()
    ends = [robot.closure(a + e).complement for e in (*h * np.eye(2), *-h * np.eye(2))]
    expected = [(ends[k] - ends[2 + k]) / (2.0 * h) for k in range(2)]
    assert np.abs(found).max() > 0.1
    for k in range(2):
        change = found[:, k].reshape(2, -1).T
        assert np.abs(change - expected[k]).max() < 1e-8


def test_derivatives_of_derivatives_are_finite() -> None:
    symbolic = SymbolicRobot(psp3.load("five_bar"))
    q, v = casadi.SX.sym("q", symbolic.robot.model.nq), casadi.SX.sym("v", 2)
    power = casadi.dot(v, symbolic.inverse_dynamics(q, v, v))
    hessian, _ = casadi.hessian(power, casadi.vertcat(q, v))
    found = casadi.Function("second", [q, v], [hessian])(symbolic.robot.q0, [0.1, 0.2]).full()
    assert np.isfinite(found).all()
    assert np.abs(found).max() > 1e-3


def test_what_is_no_robot_or_no_function_is_refused() -> None:
    with pytest.raises(InvalidValue, match=r"psp3\.load"):
        SymbolicRobot("delta")  # type: ignore[arg-type]
    symbolic = SymbolicRobot(psp3.load("five_bar"))
    with pytest.raises(UnknownName, match="inverse_dynamics"):
        symbolic.derivatives("inverse")
    with pytest.raises(UnknownName, match="tip"):
        symbolic.frame("nowhere")
    assert "five_bar" in repr(symbolic)


def test_all_functions_that_are_named_have_derivatives() -> None:
    symbolic = SymbolicRobot(psp3.load("five_bar"))
    for name in DIFFERENTIABLE:
        columns = getattr(symbolic, name).numel_out()
        assert symbolic.derivatives(name).size_out(0) == (columns, symbolic.joints)
