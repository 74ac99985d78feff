"""Analytic derivatives.

Against a complex step where a closed form takes one, against differences everywhere, and against
what must hold.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import psp3
from psp3.description.parts import THESIS_ROBOTS
from psp3.dynamics.derivatives import forward_dynamics_derivatives, inverse_dynamics_derivatives
from psp3.errors import InvalidArray
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from psp3.three_psp import closed_form
from tests.helpers import ROBOTS_WITH_LOOPS, Array, _robot, derivative, random_states

COMPLEX_STEP = 1e-30
"""A step of this size has no truncation error, and complex steps have no rounding error."""


def complex_step(function: Callable[[Array], Array], x: Array) -> Array:
    """Return the derivative (m, n) of an analytic function (n,) -> (m,), to rounding."""
    return np.stack(
        [np.imag(function(x + 1j * COMPLEX_STEP * unit)) / COMPLEX_STEP for unit in np.eye(x.size)],
        axis=-1,
    )


def differences(function: Callable[[Array], Array], x: Array, step: float) -> Array:
    """Return the derivative of a function (n,) -> (m,) by eighth-order differences, as (m, n)."""
    return np.stack(
        [derivative(lambda t, u=unit: function(x + t * u), step) for unit in np.eye(x.size)],
        axis=-1,
    )


# Robots of every kind of joint and closure


def ball_in_a_loop() -> SimpleNamespace:
    """Return a loop, closed as a whole with a ball joint before the motor's.

    A ball joint has four coordinates and three speeds.
    """
    joints = [
        (0, pin.JointModelSpherical(), np.zeros(3)),
        (1, pin.JointModelRX(), np.array([0.2, 0.0, 0.0])),
        (0, pin.JointModelRX(), np.array([0.4, 0.1, 0.0])),
        (3, pin.JointModelRY(), np.array([0.0, 0.1, 0.2])),
        (4, pin.JointModelPZ(), np.array([0.1, 0.1, 0.2])),
        (5, pin.JointModelRUBZ(), np.array([0.1, 0.1, 0.2])),
    ]
    q0 = [0.1, 0.2, -0.1, np.sqrt(0.94), 0.3, 0.1, 0.2, -0.3, np.cos(0.3), np.sin(0.3)]
    return _robot(joints, (6, 2, pin.ContactType.CONTACT_6D), q0, ("j2", "j3"))


def free_platform() -> SimpleNamespace:
    """Return a free body, in seven coordinates, held by an arm of six motors."""
    arm = [
        pin.JointModelRZ(),
        pin.JointModelRY(),
        pin.JointModelPX(),
        pin.JointModelRX(),
        pin.JointModelRY(),
        pin.JointModelRX(),
    ]
    joints: list[tuple[int, Any, Array]] = [(0, pin.JointModelFreeFlyer(), np.zeros(3))]
    joints += [
        (k if k > 1 else 0, joint, np.array([0.1, 0.05 * k, 0.1]))
        for k, joint in enumerate(arm, start=1)
    ]
    q0 = [0.3, 0.2, 0.5, 0.1, 0.2, -0.1, np.sqrt(0.94), 0.3, 0.4, 0.1, 0.5, -0.3, 0.2]
    return _robot(
        joints, (1, 7, pin.ContactType.CONTACT_6D), q0, ("j2", "j3", "j4", "j5", "j6", "j7")
    )


def held_at_the_base(kind: Any, base_first: bool) -> SimpleNamespace:
    """Return an arm of seven joints whose end is held by the base itself.

    At a point or as a whole.
    """
    axes = [
        pin.JointModelRZ(),
        pin.JointModelRY(),
        pin.JointModelPX(),
        pin.JointModelRX(),
        pin.JointModelRY(),
        pin.JointModelRX(),
    ]
    joints = [
        (k, joint, np.array([0.1, 0.05 * k, 0.1]))
        for k, joint in enumerate([*axes, pin.JointModelRZ()])
    ]
    actuated = ("j1", "j5", "j6", "j7") if kind == pin.ContactType.CONTACT_3D else ("j4",)
    robot = _robot(joints, (7, 1, kind), [0.3, 0.4, 0.1, 0.5, -0.3, 0.2, 0.1], actuated)
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, robot.q0)
    (loop,) = robot.constraint_models
    fixed = data.oMi[7] * loop.joint1_placement
    if kind == pin.ContactType.CONTACT_3D:
        # Turned against the arm's frame, so that nothing rests on the two frames being parallel.
        fixed.rotation = pin.utils.rotate("y", 0.7) @ pin.utils.rotate("x", -0.4)
    sides = [(7, loop.joint1_placement), (0, fixed)]
    first, second = reversed(sides) if base_first else sides
    robot.constraint_models = pin.StdVec_RigidConstraintModel()
    robot.constraint_models.append(
        pin.RigidConstraintModel(kind, robot.model, *first, *second, pin.ReferenceFrame.LOCAL)
    )
    return robot


def build(parts: SimpleNamespace) -> ClosedLoopRobot:
    return ClosedLoopRobot(parts.model, parts.constraint_models, parts.actuated, parts.q0)


def arm_without_loops() -> ClosedLoopRobot:
    model = pin.buildSampleModelManipulator()
    return ClosedLoopRobot(
        model, [], list(model.names)[1:], np.array([0.3, -0.4, 0.5, 0.6, -0.7, 0.8])
    )


def geared(parts: SimpleNamespace) -> ClosedLoopRobot:
    parts.model.armature = np.linspace(0.1, 0.5, parts.model.nv)
    return build(parts)


BUILDERS: dict[str, Callable[[], ClosedLoopRobot]] = {
    **{
        builder.__name__: (lambda builder=builder: build(builder()))
        for builder in ROBOTS_WITH_LOOPS
    },
    "ball in a loop": lambda: build(ball_in_a_loop()),
    "free platform": lambda: build(free_platform()),
    **{
        f"{kind.name}, {order}": (
            lambda kind=kind, base_first=order == "base first": build(
                held_at_the_base(kind, base_first)
            )
        )
        for kind, order in itertools.product(
            (pin.ContactType.CONTACT_3D, pin.ContactType.CONTACT_6D), ("base first", "base second")
        )
    },
    "rotors": lambda: geared(ROBOTS_WITH_LOOPS[2]()),
    "arm without loops": arm_without_loops,
    **{name: (lambda name=name: psp3.load(name)) for name in THESIS_ROBOTS},
    "psp3 by Newton": lambda: psp3.load("psp3").dynamics("core"),  # type: ignore[return-value]
}


@pytest.fixture(scope="module", params=BUILDERS)
def robot(request: pytest.FixtureRequest) -> ClosedLoopRobot:
    return BUILDERS[request.param]()


def states(
    robot: ClosedLoopRobot, count: int, reach: float = 0.05
) -> list[tuple[Array, Array, Array]]:
    """Positions near the reference pose, speeds and accelerations (or forces) of the order of 1."""
    rng, n = np.random.default_rng(11), len(robot.coordinates_v)
    return [
        (robot.reference + rng.uniform(-reach, reach, n), *rng.normal(size=(2, n)))
        for _ in range(count)
    ]


# Against differences


def test_derivatives_of_inverse_dynamics_are_its_differences(robot: ClosedLoopRobot) -> None:
    """Every kind of joint and closure.

    1e-9 of the largest entry, of which eighth-order differences leave at most a tenth.

    Forces are linear in the accelerations and quadratic in the speeds, so there large steps have no
    error but rounding.
    """
    for a, v, w in states(robot, 2):
        found = inverse_dynamics_derivatives(robot, a, v, w)
        expected = (
            differences(lambda x: robot.inverse_dynamics(x, v, w), a, 2e-3),  # noqa: B023
            differences(lambda x: robot.inverse_dynamics(a, x, w), v, 0.1),  # noqa: B023
            differences(lambda x: robot.inverse_dynamics(a, v, x), w, 0.1),  # noqa: B023
        )
        for one, other in zip(found, expected, strict=True):
            assert_allclose(one, other, rtol=0, atol=1e-9 * np.abs(other).max())


def test_derivatives_of_forward_dynamics_are_its_differences(robot: ClosedLoopRobot) -> None:
    """Of Pinocchio's constraintDynamics, or of the 3-PSP's closed form.

    1e-8 of the largest entry: proximal steps are not exact.
    """
    for a, v, f in states(robot, 2):
        found = forward_dynamics_derivatives(robot, a, v, f)
        expected = (
            differences(lambda x: robot.forward_dynamics(x, v, f), a, 2e-3),  # noqa: B023
            differences(lambda x: robot.forward_dynamics(a, x, f), v, 0.1),  # noqa: B023
            differences(lambda x: robot.forward_dynamics(a, v, x), f, 0.1),  # noqa: B023
        )
        for one, other in zip(found, expected, strict=True):
            assert_allclose(one, other, rtol=0, atol=1e-8 * np.abs(other).max())


# Against a complex step


class FiveBar:
    """A planar five-bar linkage written out by hand.

    In operations that complex numbers pass through unharmed.

    Two cranks of 0.3 m at (0, 0) and (0.25, 0), two rods of 0.5 m between their ends and the point
    where the rods meet. Of every link the mass, the center of mass along and across it, and the
    moment of inertia about the center of mass.
    """

    base, crank, rod, gravity = np.array([0.25, 0.0]), 0.3, 0.5, np.array([-1.5, -9.0])
    links = (
        (1.1, 0.14, 0.01, 0.011),
        (0.9, 0.16, -0.02, 0.012),
        (0.8, 0.22, 0.015, 0.021),
        (0.7, 0.27, -0.012, 0.023),
    )

    def robot(self) -> ClosedLoopRobot:
        """Return the same linkage as a tree whose rods meet in a point.

        One closure equation of three is redundant.
        """
        model = pin.Model()
        model.gravity = pin.Motion(np.array([*self.gravity, 0.0]), np.zeros(3))
        # Chain by chain: Pinocchio's matrices are silently wrong in trees that are not numbered so.
        for link, parent, x in (
            (0, 0, 0.0),
            (2, 1, self.crank),
            (1, 0, self.base[0]),
            (3, 3, self.crank),
        ):
            joint = model.addJoint(
                parent,
                pin.JointModelRZ(),
                pin.SE3(np.eye(3), np.array([x, 0.0, 0.0])),
                f"j{link + 1}",
            )
            mass, along, across, inertia = self.links[link]
            body = pin.Inertia(mass, np.array([along, across, 0.0]), np.diag([0.01, 0.01, inertia]))
            model.appendBodyToJoint(joint, body, pin.SE3.Identity())
        end = pin.SE3(np.eye(3), np.array([self.rod, 0.0, 0.0]))
        loops = pin.StdVec_RigidConstraintModel()
        loops.append(
            pin.RigidConstraintModel(
                pin.ContactType.CONTACT_3D, model, 2, end, 4, end, pin.ReferenceFrame.LOCAL
            )
        )
        cranks = np.array([2.2, 0.9])
        first, second = (self._rods(cranks)[k] for k in (0, 1))
        rods = np.array([np.arctan2(first[1], first[0]), np.arctan2(second[1], second[0])]) - cranks
        return ClosedLoopRobot(
            model, loops, ("j1", "j2"), np.stack([cranks, rods], axis=-1).ravel()
        )

    def _rods(self, angles: Array) -> tuple[Array, Array]:
        """Directions of the two rods when they meet above."""
        ends = self.crank * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        ends[1] += self.base
        way = ends[1] - ends[0]
        distance = np.sqrt(way[0] ** 2 + way[1] ** 2)
        height = np.sqrt(self.rod**2 - distance**2 / 4.0)
        point = 0.5 * (ends[0] + ends[1]) + height / distance * np.array([-way[1], way[0]])
        return (point - ends[0]) / self.rod, (point - ends[1]) / self.rod

    def inverse_dynamics(self, angles: Array, speeds: Array, accelerations: Array) -> Array:
        """Return the motors' torques by the principle of virtual work."""

        def across(direction: Array) -> Array:
            return np.array([-direction[1], direction[0]])

        cranks = [np.array([np.cos(angle), np.sin(angle)]) for angle in angles]
        rods = self._rods(angles)
        matrix = self.rod * np.stack([across(rods[0]), -across(rods[1])], axis=-1)

        def rates(of_cranks: Array) -> Array:
            """Angular velocities of the four links."""
            gap = self.crank * (of_cranks[1] * across(cranks[1]) - of_cranks[0] * across(cranks[0]))
            return np.concatenate([of_cranks, np.linalg.solve(matrix, gap)])

        def centers(of_links: Array, squares: Array) -> list[Array]:
            """Velocities of the four centers of mass.

            Accelerations, if given the squares of the angular velocities.
            """

            def swing(link: int, arm: Array) -> Array:
                return of_links[link] * across(arm) - squares[link] * arm

            arms = [
                along * direction + side * across(direction)
                for direction, (_, along, side, _) in zip([*cranks, *rods], self.links, strict=True)
            ]
            carried = [0.0, 0.0, *(swing(k, self.crank * cranks[k]) for k in (0, 1))]
            return [carried[link] + swing(link, arm) for link, arm in enumerate(arms)]

        omega = rates(speeds)
        # Toward the base, what turning alone pulls the point where the rods meet, along one way and
        # along the other.
        pulls = [
            omega[k] ** 2 * self.crank * cranks[k] + omega[k + 2] ** 2 * self.rod * rods[k]
            for k in (0, 1)
        ]
        alpha = rates(accelerations) + np.concatenate(
            [np.zeros(2), np.linalg.solve(matrix, pulls[0] - pulls[1])]
        )
        moved = centers(alpha, omega**2)
        torques = []
        for virtual in map(rates, np.eye(2)):
            paths = centers(virtual, np.zeros(4))
            work = [
                mass * np.sum((moved[link] - self.gravity) * paths[link])
                + inertia * alpha[link] * virtual[link]
                for link, (mass, _, _, inertia) in enumerate(self.links)
            ]
            torques.append(sum(work))
        return np.array(torques)


def test_derivatives_of_a_five_bar_are_the_complex_step_of_its_closed_form() -> None:
    """Written out by hand and differentiated without any error.

    1e-12 of the largest entry is what the closure's rounding leaves.
    """
    by_hand = FiveBar()
    robot = by_hand.robot()
    for a, v, w in states(robot, 10, reach=0.3):
        assert_allclose(
            robot.inverse_dynamics(a, v, w),
            by_hand.inverse_dynamics(a, v, w),
            rtol=1e-11,
            atol=1e-11,
        )
        found = inverse_dynamics_derivatives(robot, a, v, w)
        expected = (
            complex_step(lambda x: by_hand.inverse_dynamics(x, v, w), a),  # noqa: B023
            complex_step(lambda x: by_hand.inverse_dynamics(a, x, w), v),  # noqa: B023
            complex_step(lambda x: by_hand.inverse_dynamics(a, v, x), w),  # noqa: B023
        )
        for one, other in zip(found, expected, strict=True):
            assert_allclose(one, other, rtol=0, atol=1e-12 * max(1.0, np.abs(other).max()))


def complex_closed_form() -> Any:
    """Return the closed form's own source.

    Not compiled and with the functions of complex numbers.
    """
    source = Path(str(closed_form.__file__)).read_text(encoding="utf-8")
    for old, new in (
        ("import math\n", "import cmath as math\n"),
        (
            "from fuzzy2.support.compiled import compiled, inlined\n",
            "compiled = inlined = lambda f: f\n",
        ),
    ):
        assert old in source
        source = source.replace(old, new)
    module = ModuleType("complex_closed_form")
    exec(compile(source, str(closed_form.__file__), "exec"), module.__dict__)
    # Complex numbers have no order, so whether a pose is valid cannot be asked of them.
    module.__dict__["_is_valid"] = lambda *_: True
    return module


def test_derivatives_of_the_3_psp_are_the_complex_step_of_its_closed_form() -> None:
    """Pinocchio's tree and loops against formulas that know neither, differentiated without error.

    1e-10 of the largest entry.

    Tilts up to 48 degrees, where the loops' condition number of 1e3 leaves rounding errors of
    1e-12.
    """
    module, robot = complex_closed_form(), psp3.load("psp3")
    p = robot.parameters.as_array()

    def forces(a: Array, v: Array, w: Array) -> Array:
        out = np.empty(3, dtype=complex)
        assert module.inverse_dynamics(a, v, w, p, out) < 0
        return out

    rng = np.random.default_rng(12)
    heights, speeds = random_states(rng, 20)
    accelerations = rng.normal(size=heights.shape)
    found = inverse_dynamics_derivatives(robot, heights, speeds, accelerations)
    for row, (a, v, w) in enumerate(zip(heights, speeds, accelerations, strict=True)):
        expected = (
            complex_step(lambda x: forces(x, v, w), a),  # noqa: B023
            complex_step(lambda x: forces(a, x, w), v),  # noqa: B023
            complex_step(lambda x: forces(a, v, x), w),  # noqa: B023
        )
        for one, other in zip(found, expected, strict=True):
            assert_allclose(one[row], other, rtol=0, atol=1e-10 * np.abs(other).max())


# What must hold


def test_forward_and_inverse_derivatives_undo_each_other(robot: ClosedLoopRobot) -> None:
    """The inverse dynamics of the changed acceleration is the changed force.

    Along any change of state and force; 1e-9.
    """
    (a, v, f), n = states(robot, 1)[0], len(robot.actuated)
    w = robot.forward_dynamics(a, v, f)
    inverse, forward = (
        inverse_dynamics_derivatives(robot, a, v, w),
        forward_dynamics_derivatives(robot, a, v, f),
    )
    assert_allclose(inverse.by_accelerations @ forward.by_forces, np.eye(n), rtol=0, atol=1e-9)
    for by_state, of_forces in zip(forward[:2], inverse[:2], strict=True):
        assert_allclose(
            inverse.by_accelerations @ by_state + of_forces,
            0.0,
            rtol=0,
            atol=1e-9 * max(1.0, np.abs(of_forces).max()),
        )


def test_mass_matrix_and_slope_of_gravity_are_symmetric(robot: ClosedLoopRobot) -> None:
    """At rest the derivative by positions is the second derivative of the potential energy.

    Speeds do not matter to first order.
    """
    (a, _, _) = states(robot, 1)[0]
    rest = np.zeros(len(robot.actuated))
    by_positions, by_speeds, mass = inverse_dynamics_derivatives(robot, a, rest, rest)
    assert_allclose(
        by_positions, by_positions.T, rtol=0, atol=1e-11 * max(1.0, np.abs(by_positions).max())
    )
    assert_array_equal(by_speeds, np.zeros_like(by_speeds))
    assert_allclose(mass, robot.mass_matrix(a), rtol=0, atol=1e-11 * np.abs(mass).max())


def test_lifting_the_3_psp_changes_no_force() -> None:
    """Forces depend on differences of heights and of speeds alone.

    So rows of both derivatives add up to zero; 1e-11 of the entries.
    """
    robot = psp3.load("psp3")
    rng = np.random.default_rng(13)
    heights, speeds = random_states(rng, 20)
    by_positions, by_speeds, mass = inverse_dynamics_derivatives(
        robot, heights, speeds, rng.normal(size=heights.shape)
    )
    for matrix in (by_positions, by_speeds):
        assert np.abs(matrix.sum(axis=-1)).max() < 1e-11 * np.abs(matrix).max()
    assert_allclose(
        mass.sum(axis=(-2, -1)), sum(inertia.mass for inertia in robot.model.inertias), rtol=1e-12
    )


# Shapes and what is refused


@pytest.fixture(scope="module")
def star() -> psp3.PSP3:
    return psp3.load("psp3")


@pytest.mark.parametrize("function", [inverse_dynamics_derivatives, forward_dynamics_derivatives])
def test_batches_are_loops_of_singles(function: Callable[..., tuple[Array, Array, Array]]) -> None:
    robot = build(ROBOTS_WITH_LOOPS[2]())
    rng = np.random.default_rng(14)
    positions = robot.reference + rng.uniform(-0.05, 0.05, size=(2, 3, 2))
    speeds, third = rng.normal(size=(3, 2)), rng.normal(size=2)
    whole = function(robot, positions, speeds, third)
    assert [matrix.shape for matrix in whole] == [(2, 3, 2, 2)] * 3
    for index in np.ndindex(2, 3):
        for one, part in zip(
            whole, function(robot, positions[index], speeds[index[1]], third), strict=True
        ):
            assert_allclose(one[index], part, rtol=0.0, atol=1e-11 * np.abs(part).max())
    assert [
        matrix.shape for matrix in function(robot, np.zeros((2, 0, 2)), np.zeros(2), third)
    ] == [(2, 0, 2, 2)] * 3


@pytest.mark.parametrize("bad", [[np.nan, 0.0, 0.0], [0.0, 0.0], 1.0, None, "abc"])
@pytest.mark.parametrize("position", [0, 1, 2])
@pytest.mark.parametrize("function", [inverse_dynamics_derivatives, forward_dynamics_derivatives])
def test_arguments_that_are_not_finite_rows_are_refused(
    star: psp3.PSP3, function: Callable[..., Any], position: int, bad: Any
) -> None:
    arguments: list[Any] = [np.zeros(3)] * 3
    arguments[position] = bad
    with pytest.raises(InvalidArray):
        function(star, *arguments)
