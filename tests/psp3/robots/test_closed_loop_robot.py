"""The Pinocchio path on any tree with loops.

Closing them, projected dynamics, and what is refused.
"""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import psp3
from psp3.description.parts import ROBOT_FILES
from psp3.description.srdf import reference_poses
from psp3.description.urdf import read_tree
from psp3.dynamics.projected import ProjectedDynamics
from psp3.errors import (
    ClosureFailed,
    InvalidArray,
    InvalidRobotFile,
    JointLimitExceeded,
    MobilityMismatch,
    PSP3Error,
    UnknownName,
)
from psp3.kinematics.task_driven import without_limits
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.helpers import ROBOTS_WITH_LOOPS, Array, derivative


def build(parts: SimpleNamespace) -> ClosedLoopRobot:
    return ClosedLoopRobot(parts.model, parts.constraint_models, parts.actuated, parts.q0)


def nearby(robot: ClosedLoopRobot, rng: np.random.Generator, count: int) -> Array:
    """Actuated positions within 0.15 (rad, m) of the reference pose."""
    home = [
        robot.q0[robot.model.joints[robot.model.getJointId(name)].idx_q] for name in robot.actuated
    ]
    return np.array(home) + rng.uniform(-0.15, 0.15, size=(count, len(home)))


def residual(robot: ClosedLoopRobot, q: Array) -> Array:
    """Relative placement of the loop's two frames, from Pinocchio's placements alone."""
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, q)
    (loop,) = robot.constraint_models
    relative = (data.oMi[loop.joint1_id] * loop.joint1_placement).actInv(
        data.oMi[loop.joint2_id] * loop.joint2_placement
    )
    return np.asarray(
        pin.log6(relative).vector
        if loop.type == pin.ContactType.CONTACT_6D
        else relative.translation
    )


@pytest.fixture(scope="module", params=ROBOTS_WITH_LOOPS, ids=lambda builder: builder.__name__)
def robot(request: pytest.FixtureRequest) -> ClosedLoopRobot:
    return build(request.param())


@pytest.fixture(scope="module")
def star() -> psp3.PSP3:
    return psp3.load("psp3")


# Closing loops


@pytest.mark.parametrize("leg", [0, 1, 2])
def test_a_joint_beyond_its_limits_is_named(star: psp3.PSP3, leg: int) -> None:
    """The slider of the leg that is lifted too far, 1e-9 m from the closed form's arm.

    Newton's method ends near rounding.
    """
    heights = 1.2 * np.eye(3)[leg]
    with pytest.raises(JointLimitExceeded) as caught:
        build(star).configuration(heights)
    assert caught.value.joint == f"b{leg + 1}"
    assert_allclose(
        caught.value.position, star.forward_kinematics(heights).arms[leg], rtol=0.0, atol=1e-9
    )


def test_configuration_closes_the_loops_at_the_given_positions(robot: ClosedLoopRobot) -> None:
    """1e-13: Newton's method runs until the residual stops falling.

    Actuated joints stand exactly where they were put.
    """
    positions = nearby(robot, np.random.default_rng(0), 20)
    q = robot.configuration(positions)
    assert q.shape == (20, robot.model.nq)
    index = [robot.model.joints[robot.model.getJointId(name)].idx_q for name in robot.actuated]
    assert_array_equal(q[:, index], positions)
    assert max(np.abs(residual(robot, row)).max() for row in q) < 1e-13


def test_reference_pose_need_only_nearly_close_the_loops() -> None:
    """Off by up to 0.02 in every joint; the actuated joints are not moved."""
    for builder in ROBOTS_WITH_LOOPS:
        parts = builder()
        guess = parts.q0 + np.random.default_rng(1).uniform(-0.02, 0.02, parts.q0.size)
        robot = ClosedLoopRobot(parts.model, parts.constraint_models, parts.actuated, guess)
        assert np.abs(residual(robot, robot.q0)).max() < 1e-13
        index = [parts.model.joints[parts.model.getJointId(name)].idx_q for name in parts.actuated]
        assert_array_equal(robot.q0[index], guess[index])


def test_continuation_keeps_to_the_assembly_mode() -> None:
    """A crank turned all the way round, degree by degree or at once.

    The rocker never flips to its mirror image. 1e-11 rad.
    """
    robot = build(ROBOTS_WITH_LOOPS[0]())
    crank = robot.q0[:1]
    q = robot.configuration(crank)
    for angle in np.radians(np.arange(1, 361)):
        q = robot.configuration(crank + angle, guess=q)
    at_once = robot.configuration(crank + 2.0 * np.pi)
    assert_allclose(q, at_once, rtol=0, atol=1e-11)
    assert_allclose(np.cos(q[1:] - robot.q0[1:]), 1.0, rtol=1e-12)


def test_far_poses_are_reached_from_home_without_wrapping_an_angle(star: psp3.PSP3) -> None:
    """Heights 0.6 m apart (tilts to 66 degrees).

    Newton's method finds the closed form's angles, not those plus 2 pi. 1e-10.
    """
    heights = [
        [0.0, 0.35, -0.35],
        [-0.6, 0.0, 0.0],
        [0.6, 0.0, 0.0],
        [0.0, 0.6, 0.0],
        [0.3, -0.3, 0.3],
        [5.0, 5.1, 4.9],
    ]
    assert_allclose(
        star.dynamics("core").configuration(heights),
        star.configuration(heights),
        rtol=0,
        atol=1e-10,
    )


def test_positions_beyond_the_workspace_are_refused() -> None:
    """Coupler and rocker end up in one line at a crank angle of 134 degrees, by the law of cosines.

    No farther, but up to 1e-3 rad.
    """
    parts = ROBOTS_WITH_LOOPS[1]()
    robot = build(parts)
    (loop,) = parts.constraint_models
    crank, ground = 0.2, 0.45
    stretched = sum(
        np.hypot(*placement.translation[:2])
        for placement in (loop.joint1_placement, loop.joint2_placement)
    )
    dead_point = np.arccos((crank**2 + ground**2 - stretched**2) / (2.0 * crank * ground))
    assert np.abs(residual(robot, robot.configuration([dead_point - 1e-3]))).max() < 1e-13
    with pytest.raises(ClosureFailed) as caught:
        robot.configuration([dead_point + 1e-3])
    assert_array_equal(caught.value.positions, [dead_point + 1e-3])
    assert 0.9 < caught.value.reached < 1.0
    assert caught.value.residual > 0.0


@pytest.mark.slow
def test_a_reference_pose_that_cannot_be_closed_is_refused() -> None:
    """Base hinges farther apart than all links together."""
    parts = ROBOTS_WITH_LOOPS[1]()
    placement = parts.model.jointPlacements[3]
    placement.translation = np.array([5.0, 0.0, 0.0])
    parts.model.jointPlacements[3] = placement
    with pytest.raises(PSP3Error):
        build(parts)


# Dynamics


def test_velocity_keeps_the_loops_closed(robot: ClosedLoopRobot) -> None:
    """Derivative of the configuration along the actuated joints' motion.

    By eighth-order differences, to 1e-8.
    """
    rng = np.random.default_rng(2)
    positions = nearby(robot, rng, 3)
    speeds = rng.normal(size=positions.shape)
    expected = derivative(lambda t: robot.configuration(positions + t * speeds), 5e-3)
    assert_allclose(
        robot.velocity(positions, speeds), expected, rtol=0, atol=1e-8 * np.abs(expected).max()
    )


def test_mass_matrix_is_that_of_the_kinetic_energy_and_gravity_the_slope_of_the_potential_energy(
    robot: ClosedLoopRobot,
) -> None:
    """Energies from sums over the bodies: 2 T(v) = v'Mv at three speeds, G by differences.

    1e-8 relative.
    """
    rng = np.random.default_rng(3)
    positions = nearby(robot, rng, 5)
    mass, gravity = robot.mass_matrix(positions), robot.gravity(positions)
    for _ in range(3):
        speeds = rng.normal(size=positions.shape)
        assert_allclose(
            robot.kinetic_energy(positions, speeds),
            0.5 * np.einsum("ni,nij,nj->n", speeds, mass, speeds),
            rtol=1e-11,
        )
    for k, unit in enumerate(np.eye(len(robot.actuated))):
        slope = derivative(lambda t, unit=unit: robot.potential_energy(positions + t * unit), 5e-3)
        assert_allclose(gravity[:, k], slope, rtol=0, atol=1e-8 * np.abs(gravity).max())


def test_coriolis_matrix_is_that_of_the_christoffel_symbols(robot: ClosedLoopRobot) -> None:
    """C_ij = 1/2 sum_k (dM_ij/dq_k + dM_ik/dq_j - dM_jk/dq_i) v_k.

    With differences of M; 1e-7 relative.
    """
    rng = np.random.default_rng(4)
    positions = nearby(robot, rng, 4)
    speeds = rng.normal(size=positions.shape)
    n = len(robot.actuated)
    slopes = np.stack(
        [
            derivative(lambda t, u=unit: robot.mass_matrix(positions + t * u), 5e-3)
            for unit in np.eye(n)
        ],
        axis=-1,
    )
    symbols = 0.5 * (slopes + slopes.swapaxes(-1, -2) - np.moveaxis(slopes, -1, 1))
    expected = np.einsum("nijk,nk->nij", symbols, speeds)
    assert_allclose(
        robot.coriolis_matrix(positions, speeds),
        expected,
        rtol=0,
        atol=1e-7 * np.abs(expected).max(),
    )


def test_inverse_dynamics_is_the_equation_of_motion(robot: ClosedLoopRobot) -> None:
    """RNEA along L and its rate, against M, C, G; 1e-11 relative."""
    rng = np.random.default_rng(5)
    positions = nearby(robot, rng, 10)
    speeds, accelerations = rng.normal(size=(2, *positions.shape))
    mass, coriolis, gravity = robot.equation_of_motion(positions, speeds)
    expected = (
        np.einsum("nij,nj->ni", mass, accelerations)
        + np.einsum("nij,nj->ni", coriolis, speeds)
        + gravity
    )
    assert_allclose(
        robot.inverse_dynamics(positions, speeds, accelerations),
        expected,
        rtol=0,
        atol=1e-11 * np.abs(expected).max(),
    )


def test_forward_dynamics_is_undone_by_inverse_dynamics(robot: ClosedLoopRobot) -> None:
    """Pinocchio's constraintDynamics on one side, projected RNEA on the other.

    1e-8 relative for redundant closures too, where the proximal iteration replaces the exact
    solution.
    """
    rng = np.random.default_rng(6)
    positions = nearby(robot, rng, 10)
    speeds, forces = rng.normal(size=(2, *positions.shape))
    accelerations = robot.forward_dynamics(positions, speeds, forces)
    assert_allclose(
        robot.inverse_dynamics(positions, speeds, accelerations), forces, rtol=0, atol=1e-8
    )


def test_constrained_accelerations_keep_the_loops_closed(robot: ClosedLoopRobot) -> None:
    """Second derivative of the closure along the motion vanishes.

    By differences along q + v t + a t²/2; 1e-6 of the accelerations.
    """
    rng = np.random.default_rng(7)
    (positions,) = nearby(robot, rng, 1)
    speeds, forces = rng.normal(size=(2, len(robot.actuated)))
    q = robot.configuration(positions)
    v = robot.velocity(positions, speeds)
    a = ProjectedDynamics(robot).constrained_accelerations(q, v, forces)

    def opening(t: float) -> Array:
        return derivative(lambda s: residual(robot, q + (t + s) * v + 0.5 * (t + s) ** 2 * a), 5e-3)

    assert np.abs(opening(0.0)).max() < 1e-9 * np.abs(v).max()
    assert np.abs(derivative(opening, 5e-3)).max() < 1e-7 * np.abs(a).max()


def test_coriolis_matrix_at_rest_is_zero(robot: ClosedLoopRobot) -> None:
    n = len(robot.actuated)
    assert_array_equal(
        robot.coriolis_matrix(nearby(robot, np.random.default_rng(8), 1), np.zeros((1, n))),
        np.zeros((1, n, n)),
    )


def test_frame_jacobian_is_the_derivative_of_the_frame(star: psp3.PSP3) -> None:
    """Tip position by differences and angular velocity by the rotation's rate; 1e-8."""
    tree = star.dynamics("core")
    heights, frame = np.array([0.03, -0.05, 0.1]), star.model.getFrameId("tip")

    def placement(a: Array) -> Any:
        data = star.model.createData()
        pin.framesForwardKinematics(star.model, data, tree.configuration(a))
        return data.oMf[frame]

    jacobian = tree.frame_jacobian(heights, "tip")
    assert jacobian.shape == (6, 3)
    rotation = placement(heights).rotation
    for k, unit in enumerate(np.eye(3)):
        linear = derivative(lambda t, u=unit: placement(heights + t * u).translation, 5e-3)
        angular = derivative(
            lambda t, u=unit: pin.log3(placement(heights + t * u).rotation @ rotation.T), 5e-3
        )
        assert_allclose(jacobian[:, k], np.concatenate([linear, angular]), rtol=0, atol=1e-8)


def test_a_robot_without_loops_is_plain_crba_and_rnea() -> None:
    """Pinocchio's sample arm with every joint driven; 1e-12 relative."""
    model = pin.buildSampleModelManipulator()
    robot = ClosedLoopRobot(model, [], list(model.names)[1:])
    rng = np.random.default_rng(9)
    q, v, a = rng.normal(size=(3, model.nv))
    data = model.createData()
    mass = pin.crba(model, data, q)
    mass = np.triu(mass) + np.triu(mass, 1).T
    assert_allclose(robot.mass_matrix(q), mass, rtol=0, atol=1e-12 * np.abs(mass).max())
    forces = pin.rnea(model, data, q, v, a)
    assert_allclose(
        robot.inverse_dynamics(q, v, a), forces, rtol=0, atol=1e-12 * np.abs(forces).max()
    )
    assert_allclose(robot.forward_dynamics(q, v, forces), a, rtol=0, atol=1e-10)
    assert_array_equal(robot.configuration(q), q)


# Shapes


def test_batches_are_loops_of_singles(robot: ClosedLoopRobot) -> None:
    """To 1e-12 of the largest entry: rows that are near each other start from one another's pose.

    So loops are closed to 1e-14 m by other steps.
    """
    rng = np.random.default_rng(10)
    n = len(robot.actuated)
    positions = nearby(robot, rng, 4).reshape(2, 2, n)
    speeds = rng.normal(size=(2, n))
    mass, coriolis, gravity = robot.equation_of_motion(positions, speeds)
    assert (mass.shape, coriolis.shape, gravity.shape) == ((2, 2, n, n), (2, 2, n, n), (2, 2, n))
    for index in np.ndindex(2, 2):
        single = robot.equation_of_motion(positions[index], speeds[index[1]])
        for whole, part in zip((mass, coriolis, gravity), single, strict=True):
            assert_allclose(
                whole[index], part, rtol=0.0, atol=1e-12 * np.abs(part).max(initial=1.0)
            )


@pytest.mark.parametrize("step", [0.09, 0.002])
def test_rows_of_a_walk_are_those_of_the_row_alone(step: float) -> None:
    """Each row is closed as if it were alone, not along all rows before it; 1e-9 rad.

    On walks that turn around poses which a five-bar without limits cannot pass straight.
    """
    bounded, rng, answered = psp3.load("five_bar"), np.random.default_rng(0), 0
    robot = ClosedLoopRobot(
        without_limits(bounded.model), bounded.constraint_models, bounded.actuated, bounded.q0
    )
    for _ in range(200):
        angle = rng.uniform(0.0, 2.0 * np.pi) + np.cumsum(rng.normal(0.1, 0.15, 64))
        way = np.cumsum(step * np.stack([np.cos(angle), np.sin(angle)], axis=1), axis=0)
        try:
            found = robot.configuration(robot.reference + way)
        except ClosureFailed:
            continue
        answered += 1
        alone = np.array([robot.configuration(row) for row in robot.reference + way])
        assert_allclose(found, alone, rtol=0.0, atol=1e-9)
    assert answered > 30


SHAPES = {
    "configuration": (1, (15,)),
    "mass_matrix": (1, (3, 3)),
    "gravity": (1, (3,)),
    "potential_energy": (1, ()),
    "velocity": (2, (15,)),
    "coriolis_matrix": (2, (3, 3)),
    "kinetic_energy": (2, ()),
    "inverse_dynamics": (3, (3,)),
    "forward_dynamics": (3, (3,)),
}


@pytest.mark.parametrize("shape", [(), (2,), (1, 2)])
def test_leading_dimensions_are_kept(star: psp3.PSP3, shape: tuple[int, ...]) -> None:
    tree = star.dynamics("core")
    for method, (count, tail) in SHAPES.items():
        assert np.shape(getattr(tree, method)(*[np.zeros((*shape, 3))] * count)) == (
            *shape,
            *tail,
        ), method
    assert tree.frame_jacobian(np.zeros((*shape, 3)), "tip").shape == (*shape, 6, 3)


def test_an_empty_batch_keeps_its_shape(star: psp3.PSP3) -> None:
    tree, empty = star.dynamics("core"), np.zeros((2, 0, 3))
    for method, (count, tail) in SHAPES.items():
        assert np.shape(getattr(tree, method)(*[empty] * count)) == (2, 0, *tail), method
    assert tree.frame_jacobian(empty, "tip").shape == (2, 0, 6, 3)


# What is refused


@pytest.mark.parametrize("actuated", [("a1", "a2"), ("a1",), ()])
def test_actuated_joints_that_do_not_match_the_mobility_are_refused(
    star: psp3.PSP3, actuated: tuple[str, ...]
) -> None:
    with pytest.raises(MobilityMismatch, match="3 degrees of freedom") as caught:
        ClosedLoopRobot(star.model, star.constraint_models, actuated, star.q0, free="refuse")
    assert caught.value.mobility.degrees_of_freedom == 3
    assert caught.value.actuated == actuated


def test_mobility_counts_independent_closures_only() -> None:
    """The planar four-bar closed with 6D has 4 joints, 6 equations, 1 degree of freedom.

    The equations are those of the closure.
    """
    parts = ROBOTS_WITH_LOOPS[0]()
    robot = ClosedLoopRobot(parts.model, parts.constraint_models, ("j1", "j3"), parts.q0)
    assert robot.mobility.degrees_of_freedom == 1
    assert (robot.coordinates, robot.mobility.over_actuation) == (("j1",), 1)


def test_a_name_that_is_no_joint_is_refused(star: psp3.PSP3) -> None:
    with pytest.raises(PSP3Error, match="a4"):
        ClosedLoopRobot(star.model, star.constraint_models, ("a1", "a2", "a4"), star.q0)


def test_joints_that_do_not_determine_the_others_are_refused(star: psp3.PSP3) -> None:
    """Right in number, wrong in kind: the same joint twice.

    At home also two nuts and their tilt toward each other.
    """
    with pytest.raises(PSP3Error):
        ClosedLoopRobot(star.model, star.constraint_models, ("a1", "a2", "a2"), star.q0)


@pytest.mark.parametrize("q0", [np.zeros(3), np.full(15, np.nan), "home"])
def test_a_malformed_reference_pose_is_refused(star: psp3.PSP3, q0: Any) -> None:
    with pytest.raises(PSP3Error):
        ClosedLoopRobot(star.model, star.constraint_models, star.actuated, q0)


@pytest.mark.parametrize("guess", [np.zeros(3), np.full(15, np.nan)])
def test_a_malformed_guess_is_refused(star: psp3.PSP3, guess: Array) -> None:
    with pytest.raises(PSP3Error):
        star.dynamics("core").configuration(np.zeros(3), guess=guess)


def test_joints_in_an_order_that_pinocchio_gets_wrong() -> None:
    """The tree fork a-b, a-c-d with d added after another root's child.

    ``crba`` is wrong there, by itself, and says nothing.
    """

    def tree(order: tuple[str, ...]) -> pin.Model:
        model, parents = pin.Model(), {"a": "universe", "b": "a", "c": "universe", "d": "b"}
        for name in order:
            joint = model.addJoint(
                model.getJointId(parents[name]),
                pin.JointModelRX(),
                pin.SE3(np.eye(3), np.array([0.0, 0.3, 0.1])),
                name,
            )
            model.appendBodyToJoint(
                joint,
                pin.Inertia(1.0, np.array([0.0, 0.2, 0.0]), 0.1 * np.eye(3)),
                pin.SE3.Identity(),
            )
        return model

    def kinetic_energy_error(model: pin.Model) -> float:
        q, v, data = np.full(4, 0.3), np.arange(1.0, 5.0), model.createData()
        upper = np.triu(pin.crba(model, data, q))
        mass = upper + np.triu(upper, 1).T
        return abs(0.5 * float(v @ mass @ v) - float(pin.computeKineticEnergy(model, data, q, v)))

    sound, disordered = tree(("a", "b", "d", "c")), tree(("a", "b", "c", "d"))
    assert kinetic_energy_error(sound) < 1e-12
    # If this ever fails, Pinocchio has been mended and the refusal can go.
    assert kinetic_energy_error(disordered) > 0.1
    first = ClosedLoopRobot(sound, [], ("a", "b", "c", "d"))
    second = ClosedLoopRobot(disordered, [], ("a", "b", "c", "d"))
    q, v, a = np.random.default_rng(0).normal(size=(3, 5, 4))
    assert_allclose(
        second.inverse_dynamics(q, v, a), first.inverse_dynamics(q, v, a), rtol=0.0, atol=1e-12
    )
    assert_allclose(second.mass_matrix(q), first.mass_matrix(q), rtol=0.0, atol=1e-12)


def test_unknown_frame_is_refused(star: psp3.PSP3) -> None:
    with pytest.raises(UnknownName, match=r"elbow.*star1_center") as caught:
        star.dynamics("core").frame_jacobian(np.zeros(3), "elbow")
    assert caught.value.name == "elbow"


@pytest.mark.parametrize(
    "bad", [[np.nan, 0, 0], [0, np.inf, 0], [0, 0], np.zeros((3, 1)), 1.0, None, "abc"]
)
@pytest.mark.parametrize(
    ("method", "count"),
    [("configuration", 1), ("mass_matrix", 1), ("coriolis_matrix", 2), ("forward_dynamics", 3)],
)
def test_arguments_that_are_not_finite_rows_are_refused(
    star: psp3.PSP3, method: str, count: int, bad: Any
) -> None:
    """In every position."""
    tree = star.dynamics("core")
    for position in range(count):
        arguments: list[Any] = [np.zeros(3)] * count
        arguments[position] = bad
        with pytest.raises(InvalidArray):
            getattr(tree, method)(*arguments)


def test_shapes_that_do_not_go_together_are_refused(star: psp3.PSP3) -> None:
    with pytest.raises(InvalidArray):
        star.dynamics("core").equation_of_motion(np.zeros((2, 3)), np.zeros((5, 3)))


# Files


URDF, SRDF, YAML = (ROBOT_FILES / f"psp3.{end}" for end in ("urdf", "srdf", "yaml"))


@pytest.mark.parametrize("which", ["urdf", "loops", "srdf"])
def test_missing_files_are_refused_by_path(tmp_path: Path, which: str) -> None:
    files = {"urdf": URDF, "loops": YAML, "srdf": SRDF, which: tmp_path / f"missing.{which}"}
    with pytest.raises(InvalidRobotFile) as caught:
        ClosedLoopRobot.from_urdf(**files)
    assert caught.value.path == files[which]


@pytest.mark.parametrize(
    ("old", "new", "missing"),
    [
        ('name="star3_center"', 'name="hub3"', "star3_center"),
        ('link="star3_center"', 'link="hub3"', "star3_center"),
        ('name="a2"', 'name="nut2_slide"', "a2"),
    ],
)
def test_a_urdf_without_a_frame_or_joint_that_the_loop_file_names_is_refused(
    tmp_path: Path, old: str, new: str, missing: str
) -> None:
    text = URDF.read_text()
    assert old in text
    if "star3_center" in old:
        # A link has its name in two places.
        text = text.replace('name="star3_center"', 'name="hub3"').replace(
            'link="star3_center"', 'link="hub3"'
        )
    urdf = tmp_path / "renamed.urdf"
    urdf.write_text(text.replace(old, new))
    with pytest.raises(InvalidRobotFile, match=missing) as caught:
        ClosedLoopRobot.from_urdf(urdf, YAML)
    assert caught.value.path == YAML


def test_a_loop_file_with_too_few_motors_is_refused(tmp_path: Path) -> None:
    loops = tmp_path / "two.yaml"
    loops.write_text(YAML.read_text().replace("[a1, a2, a3]", "[a1, a2]"))
    with pytest.raises(MobilityMismatch, match="a1, a2"):
        ClosedLoopRobot.from_urdf(URDF, loops, SRDF, free="refuse")


def test_a_loop_file_with_a_loop_less_is_refused(tmp_path: Path) -> None:
    loops = tmp_path / "one.yaml"
    loops.write_text(
        "closed_loop: [[star1_center, star2_center]]\ntype: ['6d']\nname_mot: [a1, a2, a3]\n"
    )
    with pytest.raises(MobilityMismatch) as caught:
        ClosedLoopRobot.from_urdf(URDF, loops, SRDF, free="refuse")
    assert caught.value.mobility.degrees_of_freedom == 9


def test_without_reference_poses_the_robot_starts_from_neutral() -> None:
    """All sliders at 0, and the loops closed from there."""
    robot = ClosedLoopRobot.from_urdf(URDF, YAML)
    assert_allclose(robot.configuration(np.zeros(3)), psp3.load("psp3").q0, rtol=0, atol=1e-12)


@pytest.mark.parametrize("text", ["", "<robot", "not xml at all"])
def test_srdf_that_cannot_be_read_is_refused(tmp_path: Path, text: str) -> None:
    srdf = tmp_path / "bad.srdf"
    srdf.write_text(text)
    model, _ = read_tree(URDF)
    with pytest.raises(InvalidRobotFile) as caught:
        reference_poses(model, srdf)
    assert caught.value.path == srdf


def test_an_srdf_without_home_is_refused(tmp_path: Path) -> None:
    """The caller named a file of poses.

    Starting from neutral without a word would hide that the one it needs is missing.
    """
    srdf = tmp_path / "other.srdf"
    srdf.write_text(SRDF.read_text().replace('name="home"', 'name="park"'))
    with pytest.raises(InvalidRobotFile, match="home"):
        ClosedLoopRobot.from_urdf(URDF, YAML, srdf)
