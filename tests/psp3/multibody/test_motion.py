"""What the core answers, against dense formulas by NumPy and Pinocchio, and its properties."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
import scipy.linalg
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.polynomial import Polynomial
from numpy.testing import assert_allclose, assert_array_equal

from psp3.dynamics.projected import ProjectedDynamics
from psp3.multibody.closing import CLOSED, OPEN, SINGULAR, settled
from psp3.multibody.equations import Coupling
from psp3.multibody.motion import (
    BEYOND_LIMIT,
    BLOCK,
    COMPLEMENT,
    CONFIGURATION,
    ENERGIES,
    EQUATION_OF_MOTION,
    FORWARD_DYNAMICS,
    INVERSE_DYNAMICS,
    MOTION,
    NOT_FINITE,
    answer,
    runge_kutta,
    start_from,
)
from psp3.multibody.tree import (
    AT_BEFORE,
    AT_CONFIGURATION,
    AT_FREE_FALL,
    AT_JOINTS,
    AT_LIMITS,
    AT_REPORT,
    AT_RESTS,
    COORDINATES,
    FRAME,
    HINGE,
    JOINT_NUMBERS,
    POINT,
    VELOCITIES,
)
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.helpers import (
    ROBOTS_WITH_LIE_GROUPS,
    ROBOTS_WITH_LOOPS,
    Array,
    derivative,
    spatial_loop_closed_with_3d,
)
from tests.psp3.multibody.flat import (
    Flat,
    dense_complement,
    flat_of,
    flat_with,
    symmetric,
)
from tests.psp3.multibody.test_loops import whole_jacobian

QUARTIC = [0.1, 0.8, -0.3, 0.2, 0.05]
QUESTIONS = range(7)


class Asked:
    """A tree with its reference pose, of which questions are asked as C would ask them."""

    def __init__(self, flat: Flat, q0: Array) -> None:
        self.flat = flat
        flat.part(AT_CONFIGURATION, len(q0))[:] = q0
        assert settled(*flat.all) == CLOSED
        self.reference, self.gravity = flat.memory.copy(), np.array(self.free_fall)

    @property
    def free_fall(self) -> Array:
        """The tree's acceleration of gravity, to be read and written."""
        return self.flat.numbers[self.flat.at(AT_FREE_FALL) :][:3]

    @property
    def start(self) -> Array:
        """The reference configuration."""
        return self.reference[: self.flat.count(COORDINATES)]

    def width(self, question: int) -> int:
        """Return how many numbers an answer has."""
        n, nv, nq = self.flat.n, self.flat.count(VELOCITIES), self.flat.count(COORDINATES)
        return [nq, nq + n * nv, n, n, 2 * n * n + n, 2, nq + 2 * nv][question]

    def ask(
        self,
        question: int,
        positions: Array,
        second: Array,
        third: Array,
        *,
        memory: Array | None = None,
        is_warm: int = 0,
        is_path: int = 0,
    ) -> tuple[int, Array]:
        """Return the first row that has no answer, and the answers (N, w), of rows (N, n)."""
        out = np.empty((len(positions), self.width(question)))
        memory = np.full(len(self.reference), np.nan) if memory is None else memory
        flat = [
            np.ascontiguousarray(part, dtype=float).ravel() for part in (positions, second, third)
        ]
        row = answer(
            question,
            len(positions),
            is_warm,
            is_path,
            self.flat.tree,
            self.flat.numbers,
            self.gravity,
            self.reference,
            memory,
            *flat,
            out.reshape(-1),
        )
        return row, out

    def one(self, question: int, *motion: Array) -> Array:
        """Return the answer about one state, from the reference."""
        row, out = self.ask(question, *(np.array([part]) for part in motion))
        assert row == -1
        return out[0]

    def equation(self, position: Array, speed: Array) -> tuple[Array, Array, Array]:
        """Return M, C and G."""
        n, packed = self.flat.n, self.one(EQUATION_OF_MOTION, position, speed, speed)
        return packed[: n * n].reshape(n, n), packed[n * n : -n].reshape(n, n), packed[-n:]


@pytest.fixture(scope="module")
def asked(parts: SimpleNamespace) -> Asked:
    return Asked(flat_of(parts), parts.q0)


def motion_near(robot: ClosedLoopRobot, seed: int) -> tuple[Array, Array, Array]:
    rng, n = np.random.default_rng(seed), len(robot.actuated)
    return robot.reference + rng.uniform(-0.15, 0.15, n), rng.normal(size=n), rng.normal(size=n)


# Against another implementation


@pytest.mark.parametrize("seed", range(3))
def test_answers_are_those_of_the_projected_tree(
    robot: ClosedLoopRobot, asked: Asked, seed: int
) -> None:
    """M, C, G, forces and accelerations by NumPy, which closes its own loops; 1e-10 relative."""
    tree = ProjectedDynamics(robot)
    x, v, a = motion_near(robot, seed)
    for ours, theirs in zip(asked.equation(x, v), tree.equation_of_motion(x, v), strict=True):
        assert_allclose(ours, theirs, rtol=0.0, atol=1e-10 * np.abs(theirs).max())
    forces = tree.inverse_dynamics(x, v, a)
    scale = np.abs(forces).max()
    assert_allclose(asked.one(INVERSE_DYNAMICS, x, v, a), forces, rtol=0.0, atol=1e-10 * scale)
    found = asked.one(FORWARD_DYNAMICS, x, v, forces)
    assert_allclose(found, a, rtol=0.0, atol=1e-9 * max(1.0, scale))


def test_accelerations_are_those_of_pinocchios_constraint_dynamics(
    robot: ClosedLoopRobot, asked: Asked
) -> None:
    """Of the whole tree with its loops as constraints; 1e-8 relative."""
    x, v, force = motion_near(robot, 4)
    q, L = robot.closure(x).configuration, robot.closure(x).complement
    theirs = ProjectedDynamics(robot).constrained_accelerations(q, L @ v, force)[robot.actuated_v]
    found = asked.one(FORWARD_DYNAMICS, x, v, force)
    assert_allclose(found, theirs, rtol=0.0, atol=1e-8 * max(1.0, np.abs(theirs).max()))


def test_a_motion_is_of_all_joints(
    parts: SimpleNamespace, robot: ClosedLoopRobot, asked: Asked
) -> None:
    """Configuration, L v, and the accelerations that Pinocchio finds for their motors' ones."""
    x, v, force = motion_near(robot, 5)
    nq, nv = parts.model.nq, parts.model.nv
    tree = ProjectedDynamics(robot)
    q = tree.configuration(x)
    speeds = dense_complement(parts, q) @ v
    theirs = ProjectedDynamics(robot).constrained_accelerations(q, speeds, force)
    found = asked.one(MOTION, x, v, theirs[robot.actuated_v])
    # A quaternion and its opposite are the same turn.
    gap = pin.difference(parts.model, found[:nq], q)
    assert np.abs(gap).max() < 1e-10
    assert_allclose(found[nq : nq + nv], speeds, rtol=0.0, atol=1e-10)
    scale = max(1.0, np.abs(theirs).max())
    assert_allclose(found[nq + nv :], theirs, rtol=0.0, atol=1e-8 * scale)
    both = asked.one(COMPLEMENT, x, x, x)
    assert_array_equal(both[:nq], found[:nq])
    complement = both[nq:].reshape(-1, nv).T
    assert_allclose(complement, dense_complement(parts, q), rtol=0.0, atol=1e-10)
    assert_array_equal(asked.one(CONFIGURATION, x, x, x), found[:nq])


def test_energies_are_those_of_the_tree(
    parts: SimpleNamespace, robot: ClosedLoopRobot, asked: Asked
) -> None:
    """½ vᵀ M v of the whole tree, and Pinocchio's potential; 1e-12 relative."""
    x, v, _ = motion_near(robot, 6)
    q = ProjectedDynamics(robot).configuration(x)
    speeds, data = dense_complement(parts, q) @ v, parts.model.createData()
    mass = symmetric(pin.crba(parts.model, data, q))
    kinetic, potential = asked.one(ENERGIES, x, v, v)
    assert_allclose(kinetic, 0.5 * speeds @ mass @ speeds, rtol=1e-11)
    expected = pin.computePotentialEnergy(parts.model, data, q)
    assert_allclose(potential, expected, rtol=0.0, atol=1e-11)


# What the shipped robots have not: springs, damping, hinges, couplings


def test_springs_and_damping_are_in_forces_and_accelerations(parts: SimpleNamespace) -> None:
    """Dense: Lᵀ (RNEA + damping + springs); forward dynamics turns it around. 1e-10 relative."""
    flat, rng = flat_of(parts), np.random.default_rng(111)
    joints = flat.numbers[flat.at(AT_JOINTS) :][: JOINT_NUMBERS * flat.nv].reshape(
        -1, JOINT_NUMBERS
    )
    rests = flat.numbers[flat.at(AT_RESTS) :][: parts.model.nq]
    joints[:, 1] = rng.uniform(1.0, 2.0, flat.nv)
    stiffness = np.zeros(flat.nv)
    for joint in list(parts.model.joints)[1:]:
        if joint.nq == joint.nv:
            own = slice(joint.idx_v, joint.idx_v + joint.nv)
            stiffness[own] = joints[own, 2] = rng.uniform(1.0, 2.0, joint.nv)
    rests[:] = rng.normal(size=parts.model.nq)
    asked = Asked(flat, parts.q0)
    n, nv, nq = flat.n, flat.nv, parts.model.nq
    at = [parts.model.joints[parts.model.getJointId(name)].idx_q for name in parts.actuated]
    x, v, a = asked.start[at] + 0.1, rng.normal(size=n), rng.normal(size=n)
    motion = asked.one(MOTION, x, v, a)
    q, joint_speeds, joint_accelerations = motion[:nq], motion[nq : nq + nv], motion[nq + nv :]
    forces = pin.rnea(parts.model, parts.model.createData(), q, joint_speeds, joint_accelerations)
    forces += joints[:, 1] * joint_speeds
    for joint in list(parts.model.joints)[1:]:
        if joint.nq == joint.nv:
            own, there = (slice(first, first + joint.nv) for first in (joint.idx_v, joint.idx_q))
            forces[own] += stiffness[own] * (q[there] - rests[there])
    expected = dense_complement(parts, q).T @ forces
    found = asked.one(INVERSE_DYNAMICS, x, v, a)
    assert_allclose(found, expected, rtol=0.0, atol=1e-10 * np.abs(expected).max())
    assert_allclose(asked.one(FORWARD_DYNAMICS, x, v, found), a, rtol=0.0, atol=1e-9)


def coupled_pendulums() -> tuple[pin.Model, Asked]:
    """Return two pendulums on one cart-like slider; the second's angle is a quartic of the first's.

    The first and the slider are independent.
    """
    model = pin.Model()
    slide = model.addJoint(0, pin.JointModelPX(), pin.SE3.Identity(), "slide")
    rng = np.random.default_rng(112)
    for name, kind in (("x", pin.JointModelRY()), ("y", pin.JointModelRX())):
        place = pin.SE3(np.eye(3), rng.normal(size=3))
        joint = model.addJoint(slide, kind, place, name)
        inertia = pin.Inertia(1.5, rng.normal(size=3), 0.1 * np.eye(3))
        model.appendBodyToJoint(joint, inertia, pin.SE3.Identity())
    model.appendBodyToJoint(
        slide, pin.Inertia(2.0, np.zeros(3), 0.1 * np.eye(3)), pin.SE3.Identity()
    )
    flat = flat_with(model, [Coupling("", 3, 2, tuple(QUARTIC))], [1, 0])
    return model, Asked(flat, np.array([0.0, 0.2, Polynomial(QUARTIC)(0.2)]))


def test_a_coupling_moves_as_its_polynomial_says() -> None:
    """Dense, with L and its rate by NumPy's polynomials; independent are x and the slider. 1e-12.

    y = p(x), so L = [[0, 1], [1, 0], [p', 0]], and ÿ = p' ẍ + p'' ẋ².
    """
    model, asked = coupled_pendulums()
    data, rng, p = model.createData(), np.random.default_rng(113), Polynomial(QUARTIC)
    for _ in range(10):
        (x, slide), v, a = rng.uniform(-0.8, 0.8, 2), rng.normal(size=2), rng.normal(size=2)
        slope, bend = p.deriv()(x), p.deriv(2)(x)
        L = np.array([[0.0, 1.0], [1.0, 0.0], [slope, 0.0]])
        drift = np.array([0.0, 0.0, bend * v[0] ** 2])
        q = np.array([slide, x, p(x)])
        forces = L.T @ pin.rnea(model, data, q, L @ v, L @ a + drift)
        position = np.array([x, slide])
        found = asked.one(INVERSE_DYNAMICS, position, v, a)
        assert_allclose(found, forces, rtol=0.0, atol=1e-12 * np.abs(forces).max())
        assert_allclose(asked.one(CONFIGURATION, position, v, a), q, rtol=0.0, atol=1e-13)
        mass, coriolis, gravity = asked.equation(position, v)
        dense = L.T @ symmetric(pin.crba(model, data, q)) @ L
        assert_allclose(mass, dense, rtol=0.0, atol=1e-12 * np.abs(dense).max())
        assert_allclose(mass @ a + coriolis @ v + gravity, forces, rtol=0.0, atol=1e-11)
        assert_allclose(asked.one(FORWARD_DYNAMICS, position, v, forces), a, rtol=0.0, atol=1e-11)


def spatial(kind: int) -> tuple[pin.Model, Asked, Array, list[int]]:
    """Return two arms whose ends a closure of a kind joins, and a closed configuration."""
    model, rng = pin.Model(), np.random.default_rng(114)
    ends = []
    for arm in range(2):
        joint = 0
        for number in range(5):
            axis = rng.normal(size=3)
            joint = model.addJoint(
                joint,
                pin.JointModelRevoluteUnaligned(axis / np.linalg.norm(axis)),
                pin.SE3(pin.exp3(rng.normal(size=3)), 0.3 * rng.normal(size=3)),
                f"arm{arm}_{number}",
            )
            inertia = pin.Inertia(1.0, 0.1 * rng.normal(size=3), 0.02 * np.eye(3))
            model.appendBodyToJoint(joint, inertia, pin.SE3.Identity())
        ends.append(joint)
    q, data = rng.uniform(-1.0, 1.0, 10), model.createData()
    pin.forwardKinematics(model, data, q)
    first = pin.SE3(pin.exp3(rng.normal(size=3)), 0.2 * rng.normal(size=3))
    second = data.oMi[ends[1]].actInv(data.oMi[ends[0]] * first)
    loop = pin.RigidConstraintModel(
        pin.ContactType.CONTACT_6D,
        model,
        ends[0],
        first,
        ends[1],
        second,
        pin.ReferenceFrame.LOCAL,
    )
    # As many joints stay independent as the closure leaves; those that hold the loop best do not.
    slopes = whole_jacobian(flat_with(model, [(loop, kind)], []), q)
    _, _, order = scipy.linalg.qr(slopes, pivoting=True)
    motors = sorted(int(v) for v in order[len(slopes) :])
    return model, Asked(flat_with(model, [(loop, kind)], motors), q), q, motors


@pytest.mark.parametrize("kind", [POINT, HINGE, FRAME])
def test_dynamics_with_every_kind_of_closure_are_the_dense_formulas(kind: int) -> None:
    """L by differences of configurations, and its rate: M, C v + G and forces. 1e-7 relative.

    Nothing of the closure's Jacobian enters what is compared with.
    """
    model, asked, q0, motors = spatial(kind)
    n, data, rng = asked.flat.n, model.createData(), np.random.default_rng(115)
    x = q0[motors] + rng.uniform(-0.02, 0.02, n)
    v, a = 0.3 * rng.normal(size=(2, n))

    def configuration(position: Array) -> Array:
        return asked.one(CONFIGURATION, position, v, a)

    def moving(t: float) -> Array:
        return configuration(x + t * v + 0.5 * t**2 * a)

    q = configuration(x)
    L = np.column_stack(
        [derivative(lambda t, u=unit: configuration(x + t * u), 1e-3) for unit in np.eye(n)]
    )
    assert_allclose(L[motors], np.eye(n), rtol=0.0, atol=1e-12)
    speed = derivative(moving, 1e-3)
    assert_allclose(speed, L @ v, rtol=0.0, atol=1e-8)
    acceleration = derivative(lambda t: derivative(lambda s: moving(t + s), 1e-3), 1e-3)
    forces = L.T @ pin.rnea(model, data, q, speed, acceleration)
    found = asked.one(INVERSE_DYNAMICS, x, v, a)
    assert_allclose(found, forces, rtol=0.0, atol=1e-7 * np.abs(forces).max())
    mass, coriolis, gravity = asked.equation(x, v)
    dense = L.T @ symmetric(pin.crba(model, data, q)) @ L
    assert_allclose(mass, dense, rtol=0.0, atol=1e-8 * np.abs(dense).max())
    assert_allclose(mass @ a + coriolis @ v + gravity, found, rtol=1e-11, atol=1e-11)
    assert_allclose(asked.one(FORWARD_DYNAMICS, x, v, found), a, rtol=0.0, atol=1e-10)


# Properties


BUILDERS = ROBOTS_WITH_LOOPS + ROBOTS_WITH_LIE_GROUPS
KNOWN: dict[int, tuple[Asked, Array, ClosedLoopRobot]] = {}


def known(number: int) -> tuple[Asked, Array, ClosedLoopRobot]:
    """Return a robot, asked, with its reference position; made once."""
    if number not in KNOWN:
        parts = BUILDERS[number]()
        robot = ClosedLoopRobot(parts.model, parts.constraint_models, parts.actuated, parts.q0)
        KNOWN[number] = Asked(flat_of(parts), parts.q0), robot.reference, robot
    return KNOWN[number]


NUMBERS = st.integers(0, len(BUILDERS) - 1)


def within(size: float) -> Any:
    """Return two numbers, of which a robot with one freedom takes the first."""
    return arrays(np.float64, 2, elements=st.floats(-size, size))


@given(NUMBERS, within(0.15), within(3.0))
def test_rate_of_the_mass_matrix_less_twice_c_is_skew(
    number: int, way: Array, speed: Array
) -> None:
    """Ṁ by differences along the motion; 1e-8 of entries of the order of 1 to 100."""
    asked, reference, _ = known(number)
    n = asked.flat.n
    x, v = reference + way[:n], speed[:n]
    mass, coriolis, _ = asked.equation(x, v)
    rate = derivative(lambda t: asked.equation(x + t * v, v)[0], 1e-3)
    skew = rate - 2.0 * coriolis
    assert_allclose(skew + skew.T, np.zeros((n, n)), rtol=0.0, atol=1e-8 * (1 + np.abs(rate).max()))
    assert_array_equal(mass, mass.T)
    assert np.linalg.eigvalsh(mass)[0] > 0.0


@given(NUMBERS, within(0.15), within(3.0), within(10.0))
def test_power_of_the_motors_is_the_rate_of_the_energy(
    number: int, way: Array, speed: Array, acceleration: Array
) -> None:
    """By differences of both energies along the motion; 1e-7 relative to what power there is."""
    asked, reference, _ = known(number)
    n = asked.flat.n
    x, v, a = reference + way[:n], speed[:n], acceleration[:n]
    force = asked.one(INVERSE_DYNAMICS, x, v, a)

    def energy(t: float) -> Array:
        return np.array(asked.one(ENERGIES, x + t * v + 0.5 * t**2 * a, v + t * a, v).sum())

    rate = derivative(energy, 1e-3)
    assert_allclose(force @ v, rate, rtol=0.0, atol=1e-7 * (1.0 + np.abs(force * v).sum()))


def size_of_terms(asked: Asked, x: Array, v: Array, a: Array) -> float:
    """Return the size of the terms of a force: these may cancel, but not their rounding."""
    mass, coriolis, gravity = map(np.abs, asked.equation(x, v))
    return float((mass @ np.abs(a) + coriolis @ np.abs(v) + gravity).max())


@given(NUMBERS, st.integers(0, 2**32 - 1))
@example(3, 97)
def test_a_warm_start_changes_rounding_only(number: int, seed: int) -> None:
    """A walk with the last pose kept, and each of its poses from the reference.

    1e-11 of the terms of which the answer is the sum. In the example terms of 160 N m cancel to
    0.05, and poses that agree to 1.4e-15 rad leave 2e-11.
    """
    asked, reference, _ = known(number)
    n, rng = asked.flat.n, np.random.default_rng(seed)
    memory = np.full(len(asked.reference), np.nan)
    walk = reference + np.cumsum(rng.uniform(-0.03, 0.03, (8, n)), axis=0)
    v, a = rng.normal(size=(2, n))
    for step, x in enumerate(walk):
        motion = [part[np.newaxis] for part in (x, v, a)]
        row, warm = asked.ask(INVERSE_DYNAMICS, *motion, memory=memory, is_warm=int(step > 0))
        assert row == -1
        cold = asked.one(INVERSE_DYNAMICS, x, v, a)
        atol = 1e-11 * (1.0 + size_of_terms(asked, x, v, a))
        assert_allclose(warm[0], cold, rtol=0.0, atol=atol)


@given(NUMBERS, st.integers(0, 2**32 - 1), st.sampled_from(list(QUESTIONS)))
def test_rows_are_single_states_in_any_order(number: int, seed: int, question: int) -> None:
    """Far from each other and near; a row near the one before starts there. 1e-11 relative."""
    asked, reference, _ = known(number)
    n, rng = asked.flat.n, np.random.default_rng(seed)
    x = reference + rng.uniform(-0.15, 0.15, (9, n))
    v, a = rng.normal(size=(2, 9, n))
    order = rng.permutation(9)
    row, out = asked.ask(question, x, v, a)
    assert row == -1
    _, turned = asked.ask(question, x[order], v[order], a[order])
    for one, other, *motion in zip(out[order], turned, x[order], v[order], a[order], strict=True):
        single = asked.one(question, *motion)
        atol = 1e-11 * (1.0 + np.abs(single).max())
        assert_allclose(one, single, rtol=0.0, atol=atol)
        assert_allclose(other, single, rtol=0.0, atol=atol)


@given(NUMBERS, st.integers(0, 2**32 - 1), st.sampled_from(list(QUESTIONS)))
def test_the_same_question_has_the_same_answer_whatever_the_memory_held(
    number: int, seed: int, question: int
) -> None:
    """To the bit; and nothing outside the memory is written."""
    asked, reference, _ = known(number)
    n, rng = asked.flat.n, np.random.default_rng(seed)
    motion = reference + rng.uniform(-0.15, 0.15, (3, n)), *rng.normal(size=(2, 3, n))
    before = asked.flat.tree.copy(), asked.flat.numbers.copy(), asked.reference.copy()
    answers = []
    for held in (np.nan, 1e300, -0.0):
        memory = np.full(len(asked.reference) + 64, held)
        row, out = asked.ask(question, *motion, memory=memory)
        assert row == -1
        answers.append(out)
        assert_array_equal(memory[-64:], np.full(64, held))
    assert_array_equal(answers[0], answers[1])
    assert_array_equal(answers[0], answers[2])
    after = asked.flat.tree, asked.flat.numbers, asked.reference
    for one, other in zip(before, after, strict=True):
        assert_array_equal(one, other)


@given(NUMBERS, st.integers(0, 2**32 - 1))
def test_forward_dynamics_turns_inverse_dynamics_around(number: int, seed: int) -> None:
    """1e-9 relative to what forces and condition make of rounding."""
    asked, reference, _ = known(number)
    n, rng = asked.flat.n, np.random.default_rng(seed)
    x, v, a = reference + rng.uniform(-0.15, 0.15, n), rng.normal(size=n), rng.normal(size=n)
    force = asked.one(INVERSE_DYNAMICS, x, v, a)
    found = asked.one(FORWARD_DYNAMICS, x, v, force)
    assert_allclose(found, a, rtol=0.0, atol=1e-9 * (1.0 + np.abs(force).max()))


# Rows


def test_many_rows_are_single_rows_block_by_block(asked: Asked, robot: ClosedLoopRobot) -> None:
    """More than two blocks along a path; 1e-10."""
    rows = 2 * BLOCK + 5
    way = np.linspace(0.0, 0.15, rows)[:, np.newaxis] * np.ones(asked.flat.n)
    x, zero = robot.reference + way, np.zeros((rows, asked.flat.n))
    row, out = asked.ask(INVERSE_DYNAMICS, x, zero, zero)
    assert row == -1
    for k in (0, 1, BLOCK - 1, BLOCK, BLOCK + 1, rows - 1):
        single = asked.one(INVERSE_DYNAMICS, x[k], zero[k], zero[k])
        assert_allclose(out[k], single, rtol=0.0, atol=1e-10 * (1.0 + np.abs(single).max()))
    # A block begins from the reference: to the bit the same as alone.
    _, alone = asked.ask(INVERSE_DYNAMICS, x[BLOCK:], zero[BLOCK:], zero[BLOCK:])
    assert_array_equal(out[BLOCK:], alone)


def test_no_rows_and_rows_of_another_size(asked: Asked) -> None:
    nothing = np.zeros((0, asked.flat.n))
    assert asked.ask(INVERSE_DYNAMICS, nothing, nothing, nothing)[0] == -1
    one, wide = np.zeros((1, asked.flat.n)), np.zeros((1, asked.flat.n + 1))
    for motion in ((wide, one, one), (one, wide, one), (one, one, wide)):
        assert asked.ask(INVERSE_DYNAMICS, *motion)[0] == -2


def test_the_first_row_without_an_answer_is_told_with_what_became_of_it() -> None:
    """Beyond a limit, past what the links reach, and with speeds beyond all numbers."""
    parts = spatial_loop_closed_with_3d()
    asked = Asked(flat_of(parts), parts.q0)
    x = np.tile(asked.start[:2], (3, 1))
    one, report = np.ones((3, 2)), asked.flat.at(AT_REPORT) + 3
    memory = asked.reference.copy()

    def outcome(positions: Array, speeds: Array) -> tuple[int, int]:
        row, _ = asked.ask(INVERSE_DYNAMICS, positions, speeds, one, memory=memory)
        return row, int(memory[report])

    far = x.copy()
    far[1, 1] += 5.0
    row, what = outcome(far, one)
    assert row == 1
    assert what in (OPEN, SINGULAR)
    fast = one.copy()
    fast[2] = 1e200
    assert outcome(x, fast) == (2, NOT_FINITE)
    limits = asked.flat.numbers[asked.flat.at(AT_LIMITS) :][: 2 * parts.model.nq].reshape(-1, 2)
    limits[4, 1] = asked.start[4] - 0.1
    assert outcome(x, one) == (0, BEYOND_LIMIT)
    limits[4] = -np.inf, np.inf
    assert asked.ask(INVERSE_DYNAMICS, x, one, one, memory=memory)[0] == -1


def test_gravity_is_the_one_that_is_given(asked: Asked, robot: ClosedLoopRobot) -> None:
    """Twice as much is twice the force at rest; 1e-12."""
    x, rest = robot.reference, np.zeros(asked.flat.n)
    once = asked.one(INVERSE_DYNAMICS, x, rest, rest)
    given, asked.gravity = asked.gravity, 2.0 * asked.gravity
    twice = asked.one(INVERSE_DYNAMICS, x, rest, rest)
    asked.gravity = given
    assert_allclose(twice, 2.0 * once, rtol=1e-12)
    assert_array_equal(asked.one(INVERSE_DYNAMICS, x, rest, rest), once)


def test_a_pose_is_copied_as_a_whole(asked: Asked) -> None:
    memory = np.full(len(asked.reference), np.nan)
    start_from(asked.flat.tree, asked.reference, memory)
    first = asked.flat.at(AT_BEFORE)
    assert_array_equal(memory[:first], asked.reference[:first])
    assert np.isnan(memory[first:]).all()


# Steps


def test_steps_are_those_of_the_classical_runge_kutta_method(
    asked: Asked, robot: ClosedLoopRobot
) -> None:
    """Written out with the accelerations of single states; 1e-12 after twenty steps."""
    n, h, steps = asked.flat.n, 1e-3, 20
    x, v, force = robot.reference + 0.05, np.full(n, 0.3), np.full(n, 0.7)
    memory, reached, states = asked.reference.copy(), np.concatenate([x, v]), []
    asked.free_fall[:] = asked.gravity
    for _ in range(steps // 2):
        assert runge_kutta(asked.flat.tree, asked.flat.numbers, memory, reached, force, h, 2)
        states.append(reached.copy())

    def rate(state: Array) -> Array:
        accelerations = asked.one(FORWARD_DYNAMICS, state[:n], state[n:], force)
        return np.concatenate([state[n:], accelerations])

    state = np.concatenate([x, v])
    for step in range(steps):
        one = rate(state)
        two = rate(state + 0.5 * h * one)
        three = rate(state + 0.5 * h * two)
        four = rate(state + h * three)
        state = state + h / 6.0 * (one + 2.0 * two + 2.0 * three + four)
        if step % 2:
            assert_allclose(states[step // 2], state, rtol=0.0, atol=1e-12)


def test_steps_end_where_there_is_no_pose(asked: Asked, robot: ClosedLoopRobot) -> None:
    """A huge force drives the linkage beyond what its links reach, or to no number."""
    n, memory = asked.flat.n, asked.reference.copy()
    state, force = np.concatenate([robot.reference, np.zeros(n)]), np.full(n, np.inf)
    before = state.copy()
    assert not runge_kutta(asked.flat.tree, asked.flat.numbers, memory, state, force, 1e-2, 50)
    assert_array_equal(state, before)
