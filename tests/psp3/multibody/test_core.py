"""The core from Python: memory of callers and threads, and arrays that users give."""

from __future__ import annotations

import pickle
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

import psp3
from psp3.description.parts import ROBOTS
from psp3.errors import ClosureFailed, InvalidValue, SingularConfiguration
from psp3.multibody.core import Core, NoAnswer
from psp3.multibody.equations import Coupling
from psp3.multibody.motion import CONFIGURATION, INVERSE_DERIVATIVES, INVERSE_DYNAMICS, answer
from psp3.multibody.tree import POSITIONS
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.helpers import (
    Array,
    derivative,
    free_body_carried_by_an_arm,
    spatial_loop_of_every_joint,
)
from tests.psp3.closure.linkages import five_bar

SEEDS = st.integers(0, 2**32 - 1)


@pytest.fixture(scope="module")
def delta() -> Any:
    return psp3.load("delta")


def states(robot: Any, count: int, seed: int = 0) -> tuple[Array, Array, Array]:
    rng, n = np.random.default_rng(seed), len(robot.actuated)
    return (
        robot.reference + rng.uniform(-0.15, 0.15, (count, n)),
        rng.normal(size=(count, n)),
        rng.normal(size=(count, n)),
    )


# The last pose


@given(SEEDS)
def test_a_walk_with_its_last_pose_has_the_answers_of_single_states(delta: Any, seed: int) -> None:
    """Of all questions that take one; 1e-11 relative."""
    rng, last = np.random.default_rng(seed), delta.last_pose()
    walk = delta.reference + np.cumsum(rng.uniform(-0.05, 0.05, (8, 3)), axis=0)
    for x in walk:
        v, a = rng.normal(size=(2, 3))
        for ask in (delta.inverse_dynamics, delta.forward_dynamics):
            cold = ask(x, v, a)
            warm = ask(x, v, a, guess=last)
            assert last.is_closed
            assert_allclose(warm, cold, rtol=0.0, atol=1e-11 * (1.0 + np.abs(cold).max()))
        warm = delta.configuration(x, guess=last)
        assert_allclose(warm, delta.configuration(x), rtol=0.0, atol=1e-12)


def test_a_last_pose_that_is_forgotten_or_refused_begins_again(delta: Any) -> None:
    """To the bit as from the reference."""
    x, rest, last = delta.reference + 0.1, np.zeros(3), delta.last_pose()
    cold = delta.inverse_dynamics(x, rest, rest)
    delta.inverse_dynamics(x + 0.1, rest, rest, guess=last)
    last.forget()
    assert_array_equal(delta.inverse_dynamics(x, rest, rest, guess=last), cold)
    with pytest.raises((ClosureFailed, SingularConfiguration)):
        delta.inverse_dynamics(x + 3.0, rest, rest, guess=last)
    assert not last.is_closed
    assert_array_equal(delta.inverse_dynamics(x, rest, rest, guess=last), cold)


def test_a_last_pose_goes_through_many_rows(delta: Any) -> None:
    x, v, a = states(delta, 5)
    last = delta.last_pose()
    many = delta.inverse_dynamics(x, v, a, guess=last)
    cold = delta.inverse_dynamics(x, v, a)
    assert_allclose(many, cold, rtol=0.0, atol=1e-11 * np.abs(many).max())
    at = delta.configuration(x[-1], guess=last)
    assert_allclose(at, delta.configuration(x[-1]), rtol=0.0, atol=1e-12)


def test_the_last_pose_of_another_robot_is_refused(delta: Any) -> None:
    other, rest = five_bar(), np.zeros(2)
    for rows in (other.reference, other.reference[np.newaxis]):
        with pytest.raises(InvalidValue, match="last_pose"):
            other.inverse_dynamics(rows, rest, rest, guess=delta.last_pose())


# Threads


def test_eight_threads_on_one_robot_get_the_right_numbers(delta: Any) -> None:
    """States by states, with the last pose and in batches: to the bit what one thread gets.

    With it to rounding: 1e-10 relative.
    """
    x, v, a = states(delta, 400, seed=1)
    expected = np.array([delta.inverse_dynamics(*state) for state in zip(x, v, a, strict=True)])
    batch = delta.inverse_dynamics(x, v, a)

    def work(thread: int) -> tuple[Array, Array, Array]:
        order = np.random.default_rng(thread).permutation(len(x))
        last, single, warm = delta.last_pose(), np.empty_like(x), np.empty_like(x)
        for k in order:
            single[k] = delta.inverse_dynamics(x[k], v[k], a[k])
            warm[k] = delta.inverse_dynamics(x[k], v[k], a[k], guess=last)
        return single, warm, delta.inverse_dynamics(x, v, a)

    with ThreadPoolExecutor(8) as pool:
        for single, warm, many in pool.map(work, range(8)):
            assert_array_equal(single, expected)
            assert_array_equal(many, batch)
            assert_allclose(warm, expected, rtol=0.0, atol=1e-10 * np.abs(expected).max())


def test_memory_that_another_thread_took_is_made_anew(delta: Any) -> None:
    """Between the question whether there is some and the answer."""

    class Taken(list[Array]):
        def __bool__(self) -> bool:
            return True

    expected = delta.inverse_dynamics(*(state[0] for state in states(delta, 1)))
    core = delta._core
    core._spare = Taken()
    assert_array_equal(delta.inverse_dynamics(*(state[0] for state in states(delta, 1))), expected)
    core._spare = []


@pytest.mark.parametrize("count", [1, 63, 64, 65, 200])
def test_answers_do_not_depend_on_how_many_threads_share_the_rows(
    delta: Any, count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    motion = states(delta, count, seed=2)
    shared = delta.inverse_dynamics(*motion)
    monkeypatch.setattr(
        "psp3.multibody.core.first_refused_row", lambda part, count, grain: part(0, count)
    )
    assert_array_equal(delta.inverse_dynamics(*motion), shared)


@pytest.mark.parametrize("way", ["path", "guess", "last pose"])
def test_one_thread_returns_to_python_between_pieces(
    delta: Any, way: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """So that Ctrl-C ends it; bit for bit the same answers as of one piece, and the same errors."""
    positions, speeds, _ = states(delta, 700, seed=3)
    pieces: list[int] = []
    answered = Core._answer

    def counted(core: Core, *arguments: Any) -> int:
        pieces.append(len(arguments[4]))
        return answered(core, *arguments)

    def found(rows: Array) -> Array:
        if way == "path":
            return np.asarray(delta.configurations_along(rows))
        guess = delta.last_pose() if way == "last pose" else delta.q0
        return np.asarray(delta.inverse_dynamics(rows, speeds, speeds, guess=guess))

    monkeypatch.setattr(Core, "_answer", counted)
    at_once = [slice(0, 700)]
    monkeypatch.setattr("psp3.multibody.core.pieces", lambda rows, first: at_once)
    whole = found(positions)
    assert pieces == [700]
    monkeypatch.undo()
    monkeypatch.setattr(Core, "_answer", counted)
    # None is short: they stay as large as the first one, a block.
    monkeypatch.setattr("fuzzy2.support.pieces.SHORT", 0.0)
    monkeypatch.setattr("fuzzy2.support.pieces.LONG", np.inf)
    assert_array_equal(found(positions), whole)
    assert pieces[1:] == [64] * 10 + [60]
    positions[300, 0] += 10.0
    with pytest.raises(ClosureFailed) as caught:
        found(positions)
    assert_array_equal(caught.value.positions, positions[300])


def test_of_rows_that_are_refused_the_first_is_told() -> None:
    """In whichever block it is."""
    robot = five_bar()
    x = np.tile(robot.reference, (300, 1))
    x[[140, 141, 280]] = np.pi, 0.0
    x[140, 0] += 0.01
    with pytest.raises(ClosureFailed) as caught:
        robot.configuration(x)
    assert_array_equal(caught.value.positions, x[140])


# Arrays


def test_arrays_of_other_kinds_are_answered_without_compiling_anew(delta: Any) -> None:
    """Whole numbers, lists, strides, and what cannot be written to."""
    delta.inverse_dynamics(delta.reference, np.zeros(3), np.zeros(3))
    whole = np.zeros(3, dtype=np.int64)
    expected = delta.inverse_dynamics(np.zeros(3), np.zeros(3), np.zeros(3))
    strided, locked = np.zeros((3, 2))[:, 0], np.zeros(3)
    locked.flags.writeable = False
    single = np.zeros(3, dtype=np.float32)
    for other in (whole, [0, 0, 0], (0.0, 0.0, 0.0), strided, locked, single):
        assert_array_equal(delta.inverse_dynamics(other, other, other), expected)
    assert len(answer.signatures) == 1  # type: ignore[attr-defined]


def test_gravity_is_read_from_the_model_at_every_call() -> None:
    robot: Any = psp3.load("delta")
    x, rest = robot.reference, np.zeros(3)
    once = robot.inverse_dynamics(x, rest, rest)
    robot.model.gravity = pin.Motion(2.0 * robot.model.gravity.linear, np.zeros(3))
    assert_allclose(robot.inverse_dynamics(x, rest, rest), 2.0 * once, rtol=1e-12)


def test_a_core_that_cannot_close_says_so() -> None:
    robot = five_bar()
    with pytest.raises(NoAnswer) as caught:
        Core(
            robot.model,
            robot.constraint_models,
            robot.actuated_v,
            np.array([np.pi, 0.3, 0.0, 0.3]),
        )
    assert caught.value.row == 0
    assert caught.value.residual > 0.05


def test_a_core_is_pickled_with_its_reference() -> None:
    """To the bit, though the memory of calls is left behind."""
    robot = five_bar()
    core = robot._core
    again: Core = pickle.loads(pickle.dumps(core))
    assert_array_equal(again.q0, core.q0)
    x, out = robot.reference[np.newaxis] + 0.1, np.empty((2, 1, 2))
    for one, place in ((core, out[0]), (again, out[1])):
        one.ask(INVERSE_DYNAMICS, x, x, x, place)
    assert_array_equal(out[0], out[1])
    q = np.empty((1, 4))
    again.ask(CONFIGURATION, robot.reference[np.newaxis], x, x, q)
    assert_array_equal(q[0], core.q0)


# Small robots


def test_a_single_joint_is_a_robot_too() -> None:
    """A pendulum: Pinocchio returns its Jacobian as a vector. G = m g r sin φ, M = m r²."""
    model = pin.Model()
    joint = model.addJoint(0, pin.JointModelRY(), pin.SE3.Identity(), "pivot")
    model.appendBodyToJoint(
        joint, pin.Inertia(2.0, np.array([0.0, 0.0, -0.5]), np.zeros((3, 3))), pin.SE3.Identity()
    )
    model.addFrame(
        pin.Frame(
            "bob", joint, 0, pin.SE3(np.eye(3), np.array([0.0, 0.0, -0.5])), pin.FrameType.OP_FRAME
        )
    )
    robot = ClosedLoopRobot(model, [], ["pivot"])
    angle = np.array([[0.3], [-1.0]])
    assert_allclose(robot.gravity(angle), 2.0 * 9.81 * 0.5 * np.sin(angle), rtol=1e-12)
    assert_allclose(robot.mass_matrix(angle), np.full((2, 1, 1), 0.5), rtol=1e-12)
    assert_allclose(
        robot.frame_jacobian(angle, "bob")[:, 0, 0], -0.5 * np.cos(angle[:, 0]), rtol=1e-12
    )


# Frames


def _moved(robot: Any, positions: Array, speed: int, amount: float) -> Array:
    """Return positions after an independent joint has moved by an amount at unit speed."""
    v = np.zeros(robot.model.nv)
    v[robot.coordinates_v[speed]] = amount
    q = robot.q0.copy()
    q[robot.coordinates_q] = positions
    return np.asarray(pin.integrate(robot.model, q, v)[robot.coordinates_q])


def _coupled() -> ClosedLoopRobot:
    """Return an arm of three joints, the last a polynomial of the second."""
    model = pin.Model()
    for number, joint in enumerate((pin.JointModelRZ(), pin.JointModelRY(), pin.JointModelPX())):
        placement = pin.SE3(pin.utils.rotate("x", 0.3 * number), np.array([0.2, -0.1, 0.3]))
        model.addJoint(number, joint, placement, f"j{number + 1}")
        model.appendBodyToJoint(number + 1, pin.Inertia.Random(), pin.SE3.Identity())
    for joint in range(4):
        placement = pin.SE3(pin.utils.rotate("y", 0.4), np.array([0.1, 0.2, 0.3]))
        model.addFrame(pin.Frame(f"f{joint}", joint, 0, placement, pin.FrameType.OP_FRAME))
    coupling = Coupling("gear", 3, 2, (0.1, 0.5, -0.3, 0.2))
    return ClosedLoopRobot(model, [], ["j1", "j2"], equations=[coupling])


def _robot_with_frames(name: str) -> Any:
    if name == "coupled":
        return _coupled()
    if name in ROBOTS:
        robot = psp3.load(name)
        return robot.dynamics("core") if isinstance(robot, psp3.PSP3) else robot
    parts = {"free body": free_body_carried_by_an_arm, "every joint": spatial_loop_of_every_joint}[
        name
    ]()
    for joint in range(parts.model.njoints):
        placement = pin.SE3(pin.utils.rotate("y", 0.4), np.array([0.1, 0.2, 0.3]))
        parts.model.addFrame(pin.Frame(f"f{joint}", joint, 0, placement, pin.FrameType.OP_FRAME))
    # Without the loop the body is a floating base, with a quaternion among the coordinates.
    loops = [] if name == "free body" else parts.constraint_models
    return ClosedLoopRobot(parts.model, loops, parts.actuated, parts.q0)


@pytest.mark.parametrize("name", [*ROBOTS, "coupled", "free body", "every joint"])
def test_frames_are_where_pinocchio_has_them_and_move_as_they_change(name: str) -> None:
    """Placement by Pinocchio's forward kinematics of the closed configuration, 1e-13 m.

    The Jacobian by its differences of eighth order, 1e-9, and by Pinocchio's Jacobian times the
    differences of the configuration, which no kernel of L is part of, 1e-9. And by Pinocchio's
    Jacobian times the core's own L, 1e-13: the differences are what leaves the digits.
    """
    robot = _robot_with_frames(name)
    model, data, rng = robot.model, robot.model.createData(), np.random.default_rng(5)
    n, x = len(robot.coordinates_v), robot.reference
    for k in range(n):
        x = _moved(robot, x, k, rng.uniform(-0.05, 0.05))
    q, complement = robot.configuration(x), robot.closure(x).complement
    slopes = np.column_stack(
        [
            derivative(
                lambda t, k=k: pin.difference(
                    model, q, robot.configuration(_moved(robot, x, k, t))
                ),
                2e-3,
            )
            for k in range(n)
        ]
    )
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    for index, frame in enumerate(model.frames):
        found = robot.frame_jacobian(x, frame.name)
        assert_allclose(
            robot.frame_placement(x, frame.name), data.oMf[index].homogeneous, rtol=0, atol=1e-13
        )
        whole = pin.getFrameJacobian(model, data, index, axes).reshape(6, model.nv)
        scale = 1.0 + np.abs(found).max()
        assert_allclose(found, whole @ complement, rtol=0, atol=1e-13 * scale)
        assert_allclose(found, whole @ slopes, rtol=0, atol=1e-9 * scale)


def test_frames_of_many_states_are_those_of_each(delta: Any) -> None:
    x, _, _ = states(delta, 130)
    for ask in (delta.frame_jacobian, delta.frame_placement):
        whole = ask(x.reshape(13, 10, 3), "tip")
        single = np.array([ask(row, "tip") for row in x])
        assert_allclose(whole.reshape(single.shape), single, rtol=0, atol=1e-12)
    with pytest.raises(ClosureFailed):
        delta.frame_jacobian(delta.reference + np.array([0.0, 50.0, 0.0]), "tip")


def test_derivatives_along_a_part_of_a_joint_are_refused() -> None:
    """Of a ball that only turns about two of its axes; its dynamics are there."""
    model = pin.Model()
    model.addJoint(0, pin.JointModelSpherical(), pin.SE3.Identity(), "ball")
    model.appendBodyToJoint(1, pin.Inertia.Random(), pin.SE3.Identity())
    for independent, is_refused in (([0, 1], True), ([0, 1, 2], False)):
        held = [v for v in range(3) if v not in independent]
        core = Core(model, [], np.array(independent), pin.neutral(model), held)
        n = len(independent)
        p, rest = core.tree[POSITIONS], np.zeros((1, n))
        positions = core.q0[np.newaxis, :p]
        core.ask(INVERSE_DYNAMICS, positions, rest, rest, np.empty((1, n)))
        out = np.empty((1, 3 * n * n))
        if is_refused:
            with pytest.raises(InvalidValue, match=r"coordinates=\[\.\.\.\].*'ball'"):
                core.ask(INVERSE_DERIVATIVES, positions, rest, rest, out)
        else:
            core.ask(INVERSE_DERIVATIVES, positions, rest, rest, out)
            assert np.isfinite(out).all()


# Size


def _scaled(robot: Any, size: float) -> tuple[Any, Array]:
    """Return a robot with all lengths times a number, and what its coordinates are multiplied by.

    Masses stay, and times: gravity grows with the lengths.
    """
    model, factors = robot.model.copy(), np.ones(robot.model.nq)
    model.gravity = pin.Motion(size * robot.model.gravity.linear, np.zeros(3))
    for index in range(1, model.njoints):
        place, body, joint = (
            model.jointPlacements[index],
            model.inertias[index],
            model.joints[index],
        )
        model.jointPlacements[index] = pin.SE3(place.rotation, size * place.translation)
        model.inertias[index] = pin.Inertia(body.mass, size * body.lever, size**2 * body.inertia)
        if joint.shortname().startswith("JointModelP"):
            factors[joint.idx_q] = size
    model.lowerPositionLimit = model.lowerPositionLimit * factors
    model.upperPositionLimit = model.upperPositionLimit * factors
    loops = [
        pin.RigidConstraintModel(
            loop.type,
            model,
            *(loop.joint1_id, _resized(loop.joint1_placement, size)),
            *(loop.joint2_id, _resized(loop.joint2_placement, size)),
            loop.reference_frame,
        )
        for loop in robot.constraint_models
    ]
    return ClosedLoopRobot(model, loops, robot.actuated, robot.q0 * factors), factors


def _resized(place: Any, size: float) -> Any:
    return pin.SE3(place.rotation, size * place.translation)


@pytest.mark.parametrize("size", [1e-3, 1e3])
@pytest.mark.parametrize("name", ["five_bar", "gough_stewart"])
def test_a_robot_of_another_size_is_the_same_robot(name: str, size: float) -> None:
    """Torques grow with the square of the size, and forces with the size, to 1e-10.

    The closures of a robot of 1 mm are solved to 1e-13 m, as those of one of 1 m: 3e-12 of its size
    is what is left.
    """
    robot = psp3.load(name)
    x, v, a = states(robot, 10)
    x = robot.reference + 0.2 * (x - robot.reference)
    other, factors = _scaled(robot, size)
    f = factors[robot.actuated_q]
    assert other.mobility.degrees_of_freedom == robot.mobility.degrees_of_freedom
    assert other.closure_mismatch.length < 1e-11 * size
    assert_allclose(
        other.configuration(f * x) / factors, robot.configuration(x), rtol=0, atol=1e-10
    )
    forces = robot.inverse_dynamics(x, v, a)
    found = other.inverse_dynamics(f * x, f * v, f * a) * f / size**2
    assert_allclose(found, forces, rtol=0, atol=1e-10 * np.abs(forces).max())


@pytest.mark.parametrize("name", ["gripper", "five_bar"])
def test_memory_that_nothing_has_written_changes_nothing(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Neither answers nor the reference memory, which exported code contains."""
    empty: Any = np.empty
    found = []
    for garbage in (np.nan, 1.5):

        def filled(*shape: Any, garbage: float = garbage, **options: Any) -> Any:
            out = empty(*shape, **options)
            if out.dtype == float:
                out.fill(garbage)
            return out

        with monkeypatch.context() as patch:
            patch.setattr(np, "empty", filled)
            robot = psp3.load(name)
            speeds = np.full(len(robot.coordinates_v), 0.1)
            answers = [
                robot.inverse_dynamics(robot.reference + 0.01 * k, speeds, speeds) for k in range(3)
            ]
        found.append((robot._core._reference.tobytes(), np.array(answers).tobytes()))
    assert found[0] == found[1]
