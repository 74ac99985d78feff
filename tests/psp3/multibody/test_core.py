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
from psp3.errors import ClosureFailed, InvalidValue, SingularConfiguration
from psp3.multibody.core import Core, NoAnswer
from psp3.multibody.motion import CONFIGURATION, INVERSE_DYNAMICS, answer
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.helpers import Array
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
