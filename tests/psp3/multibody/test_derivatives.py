"""Derivatives in the core against eighth-order differences of its forces, and against Pinocchio's.

With what joints have of their own, on every kind of joint and of closure.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import psp3
from psp3.description.parts import ROBOTS
from psp3.errors import ClosureFailed, InvalidArray
from psp3.multibody.closing import CLOSED
from psp3.multibody.equations import Coupling, Hinge, Spin
from psp3.multibody.flatten import flattened
from psp3.multibody.motion import (
    FORWARD_DERIVATIVES,
    FORWARD_DYNAMICS,
    INVERSE_DERIVATIVES,
    INVERSE_DYNAMICS,
    answer,
    assemble,
    derivatives,
)
from psp3.multibody.tree import (
    AT_CONFIGURATION,
    AT_INDEPENDENT_Q,
    AT_JOINTS,
    AT_RESTS,
    COORDINATES,
    FRICTION,
    JOINT_NUMBERS,
    POSITIONS,
    SIZE,
    VELOCITIES,
)
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.helpers import ROBOTS_WITH_LIE_GROUPS, Array, _robot
from tests.psp3.dynamics.test_derivatives import BUILDERS, build, differences, states

EVERY_ROBOT = {
    **{name: builder for name, builder in BUILDERS.items() if name != "psp3"},
    **{
        builder.__name__: (lambda builder=builder: build(builder()))
        for builder in ROBOTS_WITH_LIE_GROUPS
    },
}

ANGLES = np.array([0.3, 0.4, 0.1, 0.5, -0.3, 0.2, 0.1])
"""Of the seven joints of an arm."""


def of_their_own(tree: Any, numbers: Array) -> None:
    """Give all joints motors with inertia, damping and springs."""
    rng, first, rests = np.random.default_rng(3), int(tree[AT_JOINTS]), int(tree[AT_RESTS])
    count = JOINT_NUMBERS * int(tree[VELOCITIES])
    numbers[first : first + count] = rng.uniform(0.1, 1.0, count)
    # Dry friction jumps where a joint turns around, as it does between differences.
    numbers[first + FRICTION : first + count : JOINT_NUMBERS] = 0.0
    numbers[rests : rests + int(tree[COORDINATES])] = 0.1


@pytest.fixture(scope="module", params=EVERY_ROBOT)
def robot(request: pytest.FixtureRequest) -> ClosedLoopRobot:
    robot = EVERY_ROBOT[request.param]()
    of_their_own(robot._core.tree, robot._core.numbers)
    return robot


def test_whatever_joints_have_of_their_own(robot: ClosedLoopRobot) -> None:
    """1e-9 of the largest entry, of which eighth-order differences leave at most a third."""
    for a, v, w in states(robot, 2):
        for found, function in (
            (robot.inverse_dynamics_derivatives(a, v, w), robot.inverse_dynamics),
            (robot.forward_dynamics_derivatives(a, v, w), robot.forward_dynamics),
        ):
            expected = (
                differences(lambda x: function(x, v, w), a, 2e-3),  # noqa: B023
                differences(lambda x: function(a, x, w), v, 0.1),  # noqa: B023
                differences(lambda x: function(a, v, x), w, 0.1),  # noqa: B023
            )
            for one, other in zip(found, expected, strict=True):
                assert_allclose(one, other, rtol=0, atol=1e-9 * np.abs(other).max())


def test_dry_friction_turns_with_the_joints() -> None:
    """Of all joints, a ball's, too; 1e-9, in steps in which no joint turns around."""
    robot = EVERY_ROBOT["spatial_loop_of_every_joint"]()
    numbers, first = robot._core.numbers, int(robot._core.tree[AT_JOINTS])
    count = JOINT_NUMBERS * robot.model.nv
    numbers[first + FRICTION : first + count : JOINT_NUMBERS] = np.linspace(
        0.5, 1.5, robot.model.nv
    )
    for a, v, w in states(robot, 3):
        signs = [np.sign(robot.velocity(a + step, v)) for step in (-0.004, 0.0, 0.004)]
        assert (signs[0] == signs[1]).all()
        assert (signs[1] == signs[2]).all()
        found = robot.inverse_dynamics_derivatives(a, v, w)
        expected = (
            differences(lambda x: robot.inverse_dynamics(x, v, w), a, 1e-3),  # noqa: B023
            differences(lambda x: robot.inverse_dynamics(a, x, w), v, 1e-3),  # noqa: B023
        )
        for one, other in zip(found[:2], expected, strict=True):
            assert_allclose(one, other, rtol=0, atol=1e-9 * np.abs(other).max())


def test_a_derivative_by_speeds_is_twice_the_coriolis_matrix() -> None:
    """Where nothing damps: Christoffel symbols know nothing of these kernels.

    1e-12 of the largest entry. Motors with inertia of their own are in both.
    """
    for name in ("rotors", "spatial_loop_of_every_joint", *ROBOTS):
        if name == "biped":
            # Velocities of a floating base are no derivatives of its coordinates.
            continue
        robot = psp3.load(name) if name in ROBOTS else EVERY_ROBOT[name]()
        ((a, v, w),) = states(robot, 1)
        _, coriolis, _ = robot.equation_of_motion(a, v)
        by_speeds = robot.inverse_dynamics_derivatives(a, v, w).by_speeds
        assert_allclose(by_speeds, 2.0 * coriolis, rtol=0, atol=1e-12 * np.abs(by_speeds).max())


def test_a_pose_stays_true() -> None:
    """Other questions about the last pose are answered as before, to the last bit."""
    robot = psp3.load("gough_stewart")
    (a, v, w), (b, _, _) = states(robot, 2)
    for question in (robot.inverse_dynamics_derivatives, robot.forward_dynamics_derivatives):
        asked, other = robot.last_pose(), robot.last_pose()
        robot.inverse_dynamics(a, v, w, guess=asked)
        robot.inverse_dynamics(a, v, w, guess=other)
        question(a, v, w, guess=asked)
        for position in (a, b):
            assert_array_equal(
                robot.inverse_dynamics(position, v, w, guess=asked),
                robot.inverse_dynamics(position, v, w, guess=other),
            )


def test_a_last_pose_changes_derivatives_by_rounding_only() -> None:
    robot = psp3.load("delta")
    (a, v, w), (b, _, _) = states(robot, 2)
    last = robot.last_pose()
    robot.inverse_dynamics_derivatives(b, v, w, guess=last)
    for found, expected in zip(
        robot.inverse_dynamics_derivatives(a, v, w, guess=last),
        robot.inverse_dynamics_derivatives(a, v, w),
        strict=True,
    ):
        assert_allclose(found, expected, rtol=0, atol=1e-11 * np.abs(expected).max())


def test_what_has_no_answer_is_refused_as_everywhere() -> None:
    robot = psp3.load("five_bar")
    rest = np.zeros(2)
    for function in (robot.inverse_dynamics_derivatives, robot.forward_dynamics_derivatives):
        with pytest.raises(ClosureFailed):
            function(robot.reference + np.array([2.0, -2.0]), rest, rest)
        with pytest.raises(InvalidArray, match="speeds"):
            function(robot.reference, rest[:1], rest)
    with pytest.raises(InvalidArray, match="forces"):
        robot.forward_dynamics_derivatives(robot.reference, rest, [np.nan, 0.0])


# Closures that no file has yet, and independent joints of many freedoms


class Asked:
    """A flattened tree whose joints have motors, damping and springs, and what it answers."""

    def __init__(self, flat: Any, gravity: Array, q0: Array) -> None:
        self.tree, self.numbers, self.gravity = flat.integers, flat.numbers, gravity
        of_their_own(self.tree, self.numbers)
        self.memory = np.full(int(self.tree[SIZE]), np.nan)
        at = int(self.tree[AT_CONFIGURATION])
        self.memory[at : at + q0.size] = q0
        assert assemble(self.tree, self.numbers, self.memory) == CLOSED
        self.reference = self.memory.copy()
        first, n = int(self.tree[AT_INDEPENDENT_Q]), int(self.tree[POSITIONS])
        self.home = self.memory[at + self.tree[first : first + n]]
        """Independent coordinates of the reference."""

    def __call__(self, question: int, width: int, a: Array, v: Array, third: Array) -> Array:
        """Return the answer to a question about one state."""
        out = np.empty(width)
        arrays = self.tree, self.numbers, self.gravity, self.reference, self.memory
        dynamics = {
            INVERSE_DERIVATIVES: INVERSE_DYNAMICS,
            FORWARD_DERIVATIVES: FORWARD_DYNAMICS,
        }
        if question in dynamics:
            forces = np.empty(len(v))
            assert answer(dynamics[question], 1, 0, 0, *arrays, a, v, third, forces) == -1
            assert derivatives(question, self.tree, self.numbers, self.memory, out) == CLOSED
        else:
            assert answer(question, 1, 0, 0, *arrays, a, v, third, out) == -1
        return out


def asked(model: pin.Model, closures: list[Any], motors: list[int], q0: Array) -> Asked:
    """Return a tree closed by hinges, couplings and spins."""
    flat = flattened(model, closures, np.array(motors, dtype=np.int64))
    return Asked(flat, model.gravity.linear, q0)


def arm() -> SimpleNamespace:
    """Return an arm of seven joints."""
    axes = [
        pin.JointModelRZ(),
        pin.JointModelRY(),
        pin.JointModelPX(),
        pin.JointModelRX(),
        pin.JointModelRY(),
        pin.JointModelRX(),
        pin.JointModelRZ(),
    ]
    joints = [(k, joint, np.array([0.1, 0.05 * k, 0.1])) for k, joint in enumerate(axes)]
    return _robot(joints, (7, 1, pin.ContactType.CONTACT_6D), list(ANGLES), ("j1",))


def hinge(model: pin.Model, q0: Array, first: int, second: int) -> Hinge:
    """Return a closure of two joints, whose frames are turned about the hinge."""
    data = model.createData()
    pin.forwardKinematics(model, data, q0)
    place = data.oMi[max(first, second)] * pin.SE3(
        pin.utils.rotate("x", 0.3), np.array([0.25, 0.05, 0.1])
    )
    turned = place * pin.SE3(pin.utils.rotate("z", 0.7), np.zeros(3))
    ends = data.oMi[first].actInv(place), data.oMi[second].actInv(turned)
    return Hinge("", first, ends[0], second, ends[1])


def coupled_in_a_loop() -> Asked:
    """Return an arm held by a hinge, two of whose joints follow each other: one freedom."""
    model = arm().model
    y, x = ANGLES[3], ANGLES[1]
    bend = [0.5, 0.3, 0.1, 0.2]
    constant = y - sum(c * x ** (k + 1) for k, c in enumerate(bend))
    closures = [hinge(model, ANGLES, 0, 7), Coupling("", 4, 2, (constant, *bend))]
    return asked(model, closures, [0], ANGLES)


def held_by_a_hinge(first: int, second: int, motors: list[int]) -> Asked:
    """Return an arm whose end is held by the base, or by its own first link."""
    model = arm().model
    return asked(model, [hinge(model, ANGLES, first, second)], motors, ANGLES)


def two_couplings() -> Asked:
    """Return an arm two of whose joints follow others; nothing is held."""
    model = arm().model
    closures = [
        Coupling("", 4, 2, (0.1, 0.5, 0.3, -0.2, 0.15)),
        Coupling("", 6, 4, (0.0, 1.0, -0.5, 0.0, 0.3)),
    ]
    return asked(model, closures, [0, 1, 2, 4, 6], ANGLES)


def rod_on_balls() -> Asked:
    """Return an arm whose end a rod on two balls holds, which does not spin about itself."""
    axes = [pin.JointModelRZ(), pin.JointModelRY(), pin.JointModelSpherical()]
    joints = [(k, joint, np.array([0.1, 0.05 * k, 0.1])) for k, joint in enumerate(axes)]
    ball = pin.Quaternion(pin.utils.rpyToMatrix(0.3, -0.2, 0.4)).coeffs()
    q0 = np.array([0.3, 0.4, *ball])
    parts = _robot(joints, (3, 0, pin.ContactType.CONTACT_3D), list(q0), ("j1",))
    axis = np.array([0.25, 0.05, 0.1]) / np.linalg.norm([0.25, 0.05, 0.1])
    return asked(parts.model, [*parts.constraint_models, Spin("", 3, axis, ball)], [0], q0)


@pytest.mark.parametrize(
    ("build_one", "n"),
    [
        (lambda: held_by_a_hinge(7, 0, [1, 4]), 2),
        (lambda: held_by_a_hinge(0, 7, [1, 4]), 2),
        (lambda: held_by_a_hinge(7, 1, [0, 4]), 2),
        (lambda: held_by_a_hinge(1, 7, [0, 4]), 2),
        (coupled_in_a_loop, 1),
        (two_couplings, 5),
        (rod_on_balls, 1),
    ],
    ids=[
        "end on base",
        "base on end",
        "end on link",
        "link on end",
        "coupled",
        "coupled only",
        "spin",
    ],
)
def test_hinges_couplings_and_spins(build_one: Any, n: int) -> None:
    """1e-9 of the largest entry; steps are small because singular poses are near."""
    tree, rng = build_one(), np.random.default_rng(3)
    a = tree.home + rng.uniform(-0.05, 0.05, n)
    v, w = rng.normal(size=(2, n))
    found = tree(INVERSE_DERIVATIVES, 3 * n * n, a, v, w).reshape(3, n, n)

    def forces(a: Array, v: Array, w: Array) -> Array:
        return np.asarray(tree(INVERSE_DYNAMICS, n, a, v, w))

    expected = (
        differences(lambda x: forces(x, v, w), a, 2e-4),
        differences(lambda x: forces(a, x, w), v, 0.1),
        differences(lambda x: forces(a, v, x), w, 0.1),
    )
    for one, other in zip(found, expected, strict=True):
        assert_allclose(one, other, rtol=0, atol=1e-9 * np.abs(other).max())


def floating(base: str) -> SimpleNamespace:
    """Return a free flyer or a planar joint that carries an arm with a ball."""
    axes = [
        pin.JointModelPlanar() if base == "planar" else pin.JointModelFreeFlyer(),
        pin.JointModelRY(),
        pin.JointModelSpherical(),
        pin.JointModelPX(),
        pin.JointModelRX(),
    ]
    joints = [(k, joint, np.array([0.1, 0.05 * k, 0.1])) for k, joint in enumerate(axes)]
    pose = [0.3, 0.2, 0.6, 0.8]
    if base != "planar":
        pose = [0.3, 0.2, 0.5, 0.1, 0.2, -0.1, np.sqrt(0.94)]
    q0 = [*pose, 0.3, 0.5, 0.5, 0.5, 0.5, 0.1, 0.2]
    return _robot(joints, (1, 5, pin.ContactType.CONTACT_6D), q0, ("j2",))


@pytest.mark.parametrize("question", [INVERSE_DERIVATIVES, FORWARD_DERIVATIVES])
@pytest.mark.parametrize("base", ["free", "planar"])
def test_all_speeds_of_a_floating_tree_are_those_of_pinocchio(base: str, question: int) -> None:
    """Pinocchio's derivatives of RNEA, along and at constant twists of the free joints.

    1e-12 of the largest entry. The arm's speeds come first, in an order of their own.
    """
    parts, rng = floating(base), np.random.default_rng(5)
    model, data, nv = parts.model, parts.model.createData(), parts.model.nv
    first = 3 if base == "planar" else 6
    order = np.concatenate([rng.permutation(np.arange(first, nv)), np.arange(first)])
    flat = flattened(model, [], order)
    q = pin.integrate(model, parts.q0, rng.normal(size=nv))
    v, w = rng.normal(size=(2, nv))
    tree = Asked(flat, model.gravity.linear, q)
    joints = tree.numbers[int(tree.tree[AT_JOINTS]) :][: JOINT_NUMBERS * nv].reshape(nv, -1)
    joints[:, 2] = 0.0
    model.armature = joints[:, 0].copy()
    forces = pin.rnea(model, data, q, v, w) + joints[:, 1] * v
    by_q, by_v, upper = (part.copy() for part in pin.computeRNEADerivatives(model, data, q, v, w))
    mass = np.triu(upper) + np.triu(upper, 1).T
    expected = [part[np.ix_(order, order)] for part in (by_q, by_v + np.diag(joints[:, 1]), mass)]
    third = w
    if question == FORWARD_DERIVATIVES:
        third, inverse = forces, np.linalg.inv(expected[2])
        expected = [-inverse @ expected[0], -inverse @ expected[1], inverse]
    # The positions are those of the reference, so that nothing is moved.
    found = tree(question, 3 * nv * nv, tree.home, v[order], third[order])
    for one, other in zip(found.reshape(3, nv, nv), expected, strict=True):
        assert_allclose(one, other, rtol=0, atol=1e-12 * np.abs(other).max())
