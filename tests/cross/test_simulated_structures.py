"""Robots whose coordinates are not their motors, simulated: floating, over- and under-actuated.

Motions are compared with MuJoCo's numbers projected on the null space of its equalities, which
:mod:`tests.mujoco_null_space` does, integrated here by the same Runge–Kutta steps.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import psp3
from psp3.control.controller import widths_of
from psp3.drives import NO_DRIVE, Drive
from psp3.errors import InvalidValue, UnreachableForces
from psp3.simulation.constraint_dynamics import ConstraintDynamics
from psp3.simulation.dormand_prince import DormandPrince
from psp3.simulation.metrics import rms_error
from psp3.simulation.mujoco import MuJoCo
from psp3.simulation.plant import Plant
from psp3.simulation.runge_kutta import FixedSteps, RungeKutta
from psp3.trajectories.motion import Motion
from psp3.trajectories.paths import Hold, PointToPoint
from tests.helpers import Array
from tests.mujoco_null_space import NullSpace, biped, five_bar, gripper

LEGS = ("l_hip", "l_motor", "r_hip", "r_motor")
SPRING = 'stiffness="30" springref=".2" damping=".3"'


class Constant:
    """A controller that always returns the same forces."""

    def __init__(self, forces: Array) -> None:
        self.forces = forces

    def reset(self) -> None:
        """Forget nothing."""

    def torque(self, t: float, positions: Array, speeds: Array, desired: Motion) -> Array:
        """Return the forces."""
        return self.forces


def loaded(path: Path, text: str, **options: object) -> psp3.ClosedLoopRobot:
    file = path / "robot.xml"
    file.write_text(text, encoding="utf-8")
    return psp3.ClosedLoopRobot.from_mjcf(file, **options)


def rates_of_positions(robot: psp3.ClosedLoopRobot, state: Array) -> Array:
    """Return how the positions of a state change; a floating base comes last."""
    p = len(robot.reference)
    speeds = state[p:]
    if p == len(speeds):
        return speeds
    x, y, z, w = state[p - 4 : p] / np.linalg.norm(state[p - 4 : p])
    turned = pin.Quaternion(w, x, y, z) * pin.Quaternion(0.0, *speeds[-3:])
    linear = pin.Quaternion(w, x, y, z).toRotationMatrix() @ speeds[-6:-3]
    return np.concatenate([speeds[:-6], linear, 0.5 * turned.coeffs()])


def walked(
    robot: psp3.ClosedLoopRobot, text: str, state: Array, forces: Array, step: float, steps: int
) -> Array:
    """Return the state after Runge–Kutta steps under MuJoCo's accelerations."""
    engine, p = NullSpace(text, robot.model), len(robot.reference)
    none = np.zeros((0, robot.model.nv))

    def rates(state: Array) -> Array:
        positions, speeds = state[:p].copy(), state[p:]
        if p > len(speeds):
            positions[-4:] /= np.linalg.norm(positions[-4:])
        q, v = robot.configuration(positions), robot.velocity(positions, speeds)
        a, _, _ = engine.accelerations(q, v, robot.motors @ forces, none, np.zeros(0))
        return np.concatenate([rates_of_positions(robot, state), a[robot.coordinates_v]])

    for _ in range(steps):
        k1 = rates(state)
        k2 = rates(state + 0.5 * step * k1)
        k3 = rates(state + 0.5 * step * k2)
        k4 = rates(state + step * k3)
        state = state + step / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)
        if p > len(robot.coordinates_v):
            state[p - 4 : p] /= np.linalg.norm(state[p - 4 : p])
    return state


@pytest.mark.parametrize(
    ("text", "free"),
    [
        (biped(*LEGS), "lock"),
        (biped(*LEGS, "l_knee", "r_knee"), "lock"),
        (five_bar("m1", spring=SPRING), "keep"),
        (five_bar("m1", "m2", "p1"), "lock"),
        (gripper(), "keep"),
    ],
    ids=["floating", "floating, six motors", "one motor and a spring", "three motors", "tendon"],
)
def test_motions_are_those_of_mujoco_projected(text: str, free: str, tmp_path: Path) -> None:
    """Under constant motor forces for 0.1 s: to 1e-8 of some 0.1 rad, m and 1 rad/s, m/s."""
    robot, rng = loaded(tmp_path, text, free=free), np.random.default_rng(0)
    p, n, m = len(robot.reference), len(robot.coordinates_v), len(robot.actuated)
    positions, speeds = robot.reference.copy(), rng.uniform(-0.5, 0.5, n)
    forces = rng.uniform(-0.2, 0.2, m)
    if p > n:
        positions[-7:] = pin.SE3ToXYZQUAT(pin.exp6(pin.Motion(rng.uniform(-1.0, 1.0, 6))))
    plant = RungeKutta(robot)
    plant.start(positions, speeds)
    for _ in range(50):
        reached = plant.advance(forces, 0.002)
        assert reached is not None
    expected = walked(robot, text, np.concatenate([positions, speeds]), forces, 0.002, 50)
    np.testing.assert_allclose(np.concatenate(reached), expected, rtol=0.0, atol=1e-8)
    assert np.abs(expected[:p] - positions).max() > 0.02


STRUCTURES: dict[str, Callable[[Path], psp3.ClosedLoopRobot]] = {
    "floating": lambda path: loaded(path, biped(*LEGS)),
    "floating, six motors": lambda path: loaded(path, biped(*LEGS, "l_knee", "r_knee")),
    "one motor and a spring": lambda path: loaded(path, five_bar("m1", spring=SPRING), free="keep"),
    "tendon": lambda path: loaded(path, gripper(), free="keep"),
    "three motors": lambda path: loaded(path, five_bar("m1", "m2", "p1")),
    "planar_4rrr": lambda path: psp3.load("planar_4rrr"),
    "biped": lambda path: psp3.load("biped"),
}


def reached(plant: Plant, state: tuple[Array, Array], forces: Array, periods: int = 4) -> Array:
    """Return positions and speeds after periods of 5 ms under constant motor forces."""
    plant.start(state[0].copy(), state[1].copy())
    for _ in range(periods):
        end = plant.advance(forces, 0.005)
        assert end is not None
    return np.concatenate(end)


def thrown(robot: psp3.ClosedLoopRobot) -> tuple[tuple[Array, Array], Array]:
    """Return a state that moves, a floating base somewhere, and forces of the motors."""
    rng, positions = np.random.default_rng(1), robot.reference.copy()
    n = len(robot.coordinates_v)
    speeds, forces = 0.3 * rng.normal(size=n), 0.3 * rng.normal(size=len(robot.actuated))
    if len(positions) > n:
        positions[-7:] = pin.SE3ToXYZQUAT(pin.exp6(pin.Motion(rng.uniform(-0.5, 0.5, 6))))
    return (positions, speeds), forces


@pytest.mark.parametrize("name", STRUCTURES)
def test_plants_of_any_structure_agree(name: str, tmp_path: Path) -> None:
    """Four routes over 20 ms of some 0.1 m, rad and 1 m/s, rad/s.

    Compiled steps and those in Python are the same, 1e-12. Against DOP853 both leave what steps of
    0.1 ms do: 1e-10, and 1e-7 of the biped, whose stiff springs swing in 5 ms. The tree, whose
    loops open by rounding, takes the same steps of all joints: 1e-9.
    """
    robot = STRUCTURES[name](tmp_path)
    state, forces = thrown(robot)
    compiled = reached(RungeKutta(robot, 50), state, forces)
    assert np.abs(compiled[: len(state[0])] - state[0]).max() > 1e-3
    python = reached(FixedSteps(robot, 50, NO_DRIVE), state, forces)
    np.testing.assert_allclose(python, compiled, rtol=0.0, atol=1e-12)
    reference = reached(DormandPrince(robot, 1e-11), state, forces)
    exact = 1e-7 if name == "biped" else 1e-10
    np.testing.assert_allclose(compiled, reference, rtol=0.0, atol=exact)
    tree = reached(ConstraintDynamics(robot, steps=50), state, forces)
    np.testing.assert_allclose(tree, compiled, rtol=0.0, atol=1e-9)


def test_drives_of_a_floating_robot_stick_and_slip_alike(tmp_path: Path) -> None:
    """Four routes; some motors stick at the end, others slip: 1e-9, and which to the last bit."""
    robot = STRUCTURES["floating"](tmp_path)
    (positions, speeds), forces = thrown(robot)
    speeds[:2] = 0.0
    drive = [Drive(2.0, 0.1), Drive(0.05), Drive(0.1, 0.1, 1e-3, 1.0), NO_DRIVE]
    ends = [
        reached(plant, (positions, speeds), forces)
        for plant in (
            RungeKutta(robot, 50, drive),
            FixedSteps(robot, 50, drive),
            DormandPrince(robot, 1e-11, drive),
            ConstraintDynamics(robot, steps=50, drive=drive),
        )
    ]
    moving = ends[0][len(positions) :][:4]
    assert moving[0] == 0.0 != moving[1]
    for end in ends[1:]:
        np.testing.assert_allclose(end, ends[0], rtol=0.0, atol=1e-9)
        np.testing.assert_array_equal(end == 0.0, ends[0] == 0.0)


@pytest.mark.parametrize("name", ["three motors", "planar_4rrr", "tendon"])
def test_drives_that_are_at_no_coordinate_act_alike(name: str, tmp_path: Path) -> None:
    """Rotors, viscous and dry friction of all motors: four routes, and MuJoCo.

    Compiled steps and those in Python are the same, 1e-12, and those of the tree 1e-9. DOP853 finds
    no event where a drive that follows several coordinates turns round, and so the tendon, which
    does, has no dry friction here; then 1e-9. MuJoCo takes no drive of a tendon; its loops give way
    by what vanishes with its step, and leave 1e-8 with steps of 0.06 ms.
    """
    robot = STRUCTURES[name](tmp_path)
    dry = 0.0 if name == "tendon" else 0.02
    drive = [Drive((1 + i) * dry, 0.05, 1e-3 * (1 + i), 1.0) for i in range(len(robot.actuated))]
    driven = robot.drives_of_coordinates(drive)
    assert driven.elsewhere.shape == (1, 3)
    assert (driven.elsewhere[:, :2] > 0.0).all()
    state, forces = thrown(robot)
    compiled = reached(RungeKutta(robot, 50, drive), state, forces)
    assert np.abs(compiled - reached(RungeKutta(robot, 50), state, forces)).max() > 0.05
    python = reached(FixedSteps(robot, 50, drive), state, forces)
    np.testing.assert_allclose(python, compiled, rtol=0.0, atol=1e-12)
    reference = reached(DormandPrince(robot, 1e-11, drive), state, forces)
    np.testing.assert_allclose(reference, compiled, rtol=0.0, atol=1e-9)
    tree = reached(ConstraintDynamics(robot, steps=50, drive=drive), state, forces)
    np.testing.assert_allclose(tree, compiled, rtol=0.0, atol=1e-9)
    if name != "tendon":
        engine = reached(MuJoCo(robot, 80, drive=drive), state, forces)
        np.testing.assert_allclose(engine, compiled, rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("name", STRUCTURES)
def test_mujoco_moves_any_structure(name: str, tmp_path: Path) -> None:
    """Its loops give way by what vanishes with the square of its step, and speeds with the step.

    So a quarter of the step leaves a sixteenth of what positions miss, and a quarter of what speeds
    do; a third and a half are asked for. After 0.1 s with steps of 0.25 ms positions are within
    1e-5 and speeds within 1e-3. The rods of the biped are free to spin in MuJoCo, and held here, so
    that their inertia about their own axes leaves 5e-7 rad whatever the step.
    """
    robot = STRUCTURES[name](tmp_path)
    state, forces = thrown(robot)
    expected, p = reached(RungeKutta(robot, 20), state, forces, 20), len(state[0])
    errors = []
    for steps in (5, 20):
        missed = np.abs(reached(MuJoCo(robot, steps), state, forces, 20) - expected)
        errors.append((missed[:p].max(), missed[p:].max()))
    assert errors[1][0] < min(1e-5, errors[0][0] / 3.0)
    assert errors[1][1] < min(1e-3, errors[0][1] / 2.0)


def test_plants_say_what_they_cannot_do(tmp_path: Path) -> None:
    tendon = loaded(tmp_path, gripper(), free="keep")
    with pytest.raises(InvalidValue, match="moves several joints"):
        MuJoCo(tendon, drive=Drive(0.1))
    with pytest.raises(InvalidValue, match="moves several joints"):
        MuJoCo(tendon, limits=([-1.0], [1.0]))
    # Its joints turn about the y axis: along that no loop can be closed.
    exact = psp3.load("five_bar")
    loop = pin.RigidConstraintModel(exact.constraint_models[0])
    loop.joint1_placement = loop.joint1_placement * pin.SE3(np.eye(3), np.array([0.0, 1e-5, 0.0]))
    rounded = psp3.ClosedLoopRobot(exact.model, [loop], exact.actuated, exact.q0)
    assert rounded.closure_mismatch.length > 1e-6
    with pytest.raises(InvalidValue, match=r"RungeKutta takes any, got .* contradict"):
        ConstraintDynamics(rounded)


def momenta(robot: psp3.ClosedLoopRobot, result: psp3.Result) -> Array:
    """Return linear and angular momentum about the center of mass, from Pinocchio, (N, 6)."""
    data, rows = robot.model.createData(), []
    q = robot.configuration(result.positions)
    for one in zip(q, robot.velocity(result.positions, result.speeds), strict=True):
        pin.computeCentroidalMomentum(robot.model, data, *one)
        rows.append(data.hg.vector.copy())
    return np.array(rows)


def test_energy_and_momentum_of_a_floating_robot_are_kept(tmp_path: Path) -> None:
    """Without weight and motor forces, over 1 s, in which the trunk turns by half a radian or more.

    Momentum is that about the center of mass. What steps of 8 ms lose of both is of the fourth
    order in the step, so that halving it leaves a sixteenth, until rounding is all that is left:
    steps of 1 ms keep both to 1e-12, the energy of 5 J and the momenta of 11 kg m/s and 0.6 N m s.
    """
    text = biped(*LEGS).replace('gravity="0 -3 -9"', 'gravity="0 0 0"')
    robot, rng = loaded(tmp_path, text), np.random.default_rng(3)
    speeds = rng.uniform(-1.0, 1.0, 10)
    hold, drifts = Hold(robot=robot), []
    for steps in (1, 2, 4, 8):
        result = psp3.simulate(
            robot,
            Constant(np.zeros(4)),
            hold,
            1.0,
            0.008,
            initial_speeds=speeds,
            plant=RungeKutta(robot, steps=steps),
        )
        energy = robot.kinetic_energy(result.positions, result.speeds)
        moved = np.abs(momenta(robot, result) - momenta(robot, result)[0]).max(axis=0)
        drifts.append([np.ptp(energy) / energy[0], moved[:3].max() / 11.0, moved[3:].max() / 0.6])
        quaternions = result.positions[:, -4:]
        np.testing.assert_allclose(np.linalg.norm(quaternions, axis=1), 1.0, rtol=0.0, atol=1e-14)
    turn = pin.Quaternion(*result.positions[0, [10, 7, 8, 9]]).angularDistance(
        pin.Quaternion(*result.positions[-1, [10, 7, 8, 9]])
    )
    assert turn > 0.5
    lost = np.array(drifts)
    assert lost[0].max() < 1e-10
    assert lost[3].max() < 1e-12
    # From one step a period to two, and from two to four.
    order = np.log2(lost[:2] / lost[1:3])
    np.testing.assert_allclose(order, 4.0, rtol=0.0, atol=0.2)


def test_a_falling_robot_falls_as_a_stone_does(tmp_path: Path) -> None:
    """Its center of mass, in the oblique gravity of the file, whatever the motors do inside."""
    robot = loaded(tmp_path, biped(*LEGS))
    controller = psp3.PD(20.0, 2.0)
    path = PointToPoint(robot.reference[:4], robot.reference[:4] + 0.2, 0.5, robot)
    result = psp3.simulate(robot, controller, path, 0.6)
    data = robot.model.createData()
    centers = [
        pin.centerOfMass(robot.model, data, robot.configuration(row)).copy()
        for row in (result.positions[0], result.positions[-1])
    ]
    fall = 0.5 * np.array([0.0, -3.0, -9.0]) * result.t[-1] ** 2
    np.testing.assert_allclose(centers[1] - centers[0], fall, rtol=0.0, atol=1e-9)
    assert result.positions.shape == (301, 11)
    assert result.speeds.shape == (301, 10)
    assert result.torque.shape == result.desired.positions.shape == (301, 4)
    # The feedback brings the legs where they are to be; in free fall nothing holds them off.
    assert np.abs(result.positions[-1, :4] - path.end).max() < 0.03
    again = psp3.load_result(result.save(tmp_path / "run.npz"))
    np.testing.assert_array_equal(again.positions, result.positions)
    np.testing.assert_array_equal(again.torque, result.torque)


@pytest.mark.parametrize("motors", [LEGS, (*LEGS, "l_knee", "r_knee")])
def test_computed_torque_of_a_floating_robot_steers_its_motors(
    motors: tuple[str, ...], tmp_path: Path
) -> None:
    """Their errors obey the servo's equation, whatever the base does.

    From rest on the path they are those of the forces' hold alone, half a period's jerk over kp.
    """
    robot = loaded(tmp_path, biped(*motors))
    assert robot.commanded == 4
    path = PointToPoint(robot.reference[:4], robot.reference[:4] + 0.2, 0.4, robot)
    controller = psp3.ComputedTorque.critically_damped(robot, 2500.0)
    result = psp3.simulate(robot, controller, path, 0.4, 0.001)
    error = np.abs(result.positions[:, :4] - result.desired.positions).max()
    assert 0.0 < error < 2.0 * 60.0 * 0.2 / 0.4**3 * 0.0005 / 2500.0
    # At each sample the commanded accelerations are exactly those that the servo asks for.
    k = 150
    now = Motion(*(array[k] for array in result.desired))
    forces = controller.torque(0.15, result.positions[k], result.speeds[k], now)
    along = robot.actuation_matrix(result.positions[k]) @ forces
    made = robot.forward_dynamics(result.positions[k], result.speeds[k], along)
    wanted = (
        now.accelerations
        + controller.kv * (now.speeds - result.speeds[k, :4])
        + controller.kp * (now.positions - result.positions[k, :4])
    )
    np.testing.assert_allclose(made[:4], wanted, rtol=0.0, atol=1e-9 * np.abs(made).max())


@pytest.mark.parametrize("name", ["computed torque", "feed-forward", "gravity", "pd", "pid", "lqr"])
def test_motors_beyond_the_freedoms_make_the_same_motion(name: str, tmp_path: Path) -> None:
    """A five-bar with two motors and with four, of least norm.

    At each sample their forces do the same, to rounding, and the four together are no larger. In
    between they are held while what they do changes, and the motions differ by 5e-4 rad where
    nothing feeds back.
    """

    def controller(robot: psp3.ClosedLoopRobot) -> object:
        return {
            "computed torque": lambda: psp3.ComputedTorque(robot, 400.0, 40.0),
            "feed-forward": lambda: psp3.FeedForward(robot),
            "gravity": lambda: psp3.GravityCompensatedPD(robot, 40.0, 4.0),
            "pd": lambda: psp3.PD(40.0, 4.0, model=robot),
            "pid": lambda: psp3.PID(40.0, 4.0, 10.0, model=robot),
            "lqr": lambda: psp3.LinearQuadraticRegulator(robot, np.eye(4), 0.01 * np.eye(2)),
        }[name]()

    robots = [
        loaded(tmp_path, five_bar(*motors)) for motors in (("m1", "m2"), ("m1", "m2", "p1", "p2"))
    ]
    path = PointToPoint(robots[0].reference, robots[0].reference + 0.1, 0.2, robots[0])
    start = robots[0].reference + 0.01
    exact, strong = (
        psp3.simulate(robot, controller(robot), path, 0.2, initial_positions=start)
        for robot in robots
    )
    assert strong.torque.shape == (101, 4)
    np.testing.assert_allclose(strong.positions, exact.positions, rtol=0.0, atol=1e-3)
    two, four = (controller(robot) for robot in robots)
    for k in range(0, 101, 10):
        state, now = (exact.positions[k], exact.speeds[k]), Motion(*(a[k] for a in exact.desired))
        if name == "feed-forward":
            # It does not look where the robot is.
            state = now[:2]
        for one in (two, four):
            if name != "pid":
                one.reset()
        alone, together = (one.torque(exact.t[k], *state, now) for one in (two, four))
        along = robots[1].actuation_matrix(state[0]) @ together
        np.testing.assert_allclose(along, alone, rtol=0.0, atol=1e-9 * np.abs(alone).max())
        assert np.linalg.norm(together) < np.linalg.norm(alone)


class InPython(RungeKutta):
    """A plant that no compiled loop takes."""


@pytest.mark.parametrize("name", STRUCTURES)
def test_both_loops_agree_where_coordinates_are_not_motors(name: str, tmp_path: Path) -> None:
    """With encoders, delay and limits of torque, for every controller with a table.

    Forces are of least norm, by other ways: 1e-11 of some 0.1 rad, m, rad/s and 10 N m.
    """
    robot = STRUCTURES[name](tmp_path)
    assert not robot.drives_coordinates
    k = robot.commanded
    path = PointToPoint(robot.reference[:k], robot.reference[:k] + 0.05, 0.1, robot)
    options = {"delay": 1, "encoder_resolution": 1e-5, "torque_limit": 50.0}
    for controller in (
        psp3.ComputedTorque(robot, 400.0, 40.0),
        psp3.FeedForward(robot),
        psp3.GravityCompensatedPD(robot, 40.0, 4.0),
        psp3.PD(20.0, 2.0, model=robot),
        psp3.PID(20.0, 2.0, 10.0, model=robot),
    ):
        assert controller.table(robot.compiled_table(), widths_of(robot)) is not None
        compiled, python = (
            psp3.simulate(robot, controller, path, 0.1, plant=plant, **options)
            for plant in (RungeKutta(robot), InPython(robot))
        )
        assert np.abs(compiled.torque).max() > 0.0
        for field in ("positions", "speeds", "torque"):
            one, other = getattr(compiled, field), getattr(python, field)
            np.testing.assert_allclose(one, other, rtol=0.0, atol=1e-11)


@pytest.mark.parametrize(
    "name", ["one motor and a spring", "tendon", "three motors", "planar_4rrr"]
)
@pytest.mark.parametrize("kind", ["of one pose", "along the path"])
def test_both_loops_agree_under_regulators(name: str, kind: str, tmp_path: Path) -> None:
    """As above, from an error in the start; those along a path command all coordinates."""
    robot = STRUCTURES[name](tmp_path)
    k, n = robot.commanded, len(robot.coordinates_v)
    path = PointToPoint(robot.reference[:k], robot.reference[:k] + 0.05, 0.1, robot)
    # In the order of Q and R; an error of 0.1 in a position counts like a force of 10.
    weights = np.diag([100.0] * n + [1.0] * n), 0.01 * np.eye(k)
    controller: psp3.LinearQuadraticRegulator | psp3.TimeVaryingLinearQuadraticRegulator
    if kind == "of one pose":
        controller = psp3.LinearQuadraticRegulator(robot, *weights)
    elif k == n:
        controller = psp3.TimeVaryingLinearQuadraticRegulator(robot, path, 0.05, *weights)
    else:
        with pytest.raises(InvalidValue, match="command all coordinates"):
            psp3.TimeVaryingLinearQuadraticRegulator(robot, path, 0.05, *weights)
        return
    assert controller.table(robot.compiled_table(), widths_of(robot)) is not None
    options = {"delay": 1, "encoder_resolution": 1e-5, "torque_limit": 50.0}
    start = robot.reference + 0.01
    compiled, python = (
        psp3.simulate(robot, controller, path, 0.1, plant=one, initial_positions=start, **options)
        for one in (RungeKutta(robot), InPython(robot))
    )
    assert np.abs(compiled.torque).max() > 0.1
    for field in ("positions", "speeds", "torque"):
        one, other = getattr(compiled, field), getattr(python, field)
        np.testing.assert_allclose(one, other, rtol=0.0, atol=1e-11)


def test_a_compiled_loop_says_what_motors_cannot_do(tmp_path: Path) -> None:
    """The motor at m1 exerts no force along p1, which is to be commanded."""
    robot = loaded(tmp_path, five_bar("m1", spring=SPRING), free="keep", coordinates=["p1", "m1"])
    hold = Hold(robot.reference[:1] + 0.01, robot)
    with pytest.raises(UnreachableForces, match="p1"):
        psp3.simulate(robot, psp3.PD(20.0, 2.0, model=robot), hold, 0.1)
    steered = psp3.simulate(robot, psp3.ComputedTorque(robot, 400.0, 40.0), hold, 0.05)
    other = psp3.simulate(
        robot, psp3.ComputedTorque(robot, 400.0, 40.0), hold, 0.05, plant=InPython(robot)
    )
    np.testing.assert_allclose(steered.positions, other.positions, rtol=0.0, atol=1e-11)


def test_feedback_that_does_not_know_the_motors_is_refused(tmp_path: Path) -> None:
    robot = loaded(tmp_path, five_bar("m1", "m2", "p1"))
    with pytest.raises(InvalidValue, match="model=robot"):
        psp3.simulate(robot, psp3.PD(40.0, 4.0), Hold(robot=robot), 0.1)


def test_a_spring_and_a_motor_balance(tmp_path: Path) -> None:
    """At rest where the spring's joint needs no force, found by bisection, nothing moves for 1 s.

    And LQR brings both coordinates back from 0.02 rad, though only one has a motor.
    """
    robot = loaded(tmp_path, five_bar("m1", spring=SPRING), free="keep")
    assert robot.coordinates == ("m1", "p1")
    assert robot.commanded == 1

    def needed(angle: float) -> float:
        return float(robot.gravity([robot.reference[0], angle])[1])

    low, high = 0.0, 0.3
    assert needed(low) * needed(high) < 0.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if needed(low) * needed(middle) > 0.0 else (low, middle)
    pose = np.array([robot.reference[0], low])
    hold = Hold(pose[:1], robot)
    for controller in (
        psp3.GravityCompensatedPD(robot, 40.0, 4.0),
        psp3.FeedForward(robot),
        psp3.ComputedTorque(robot),
    ):
        result = psp3.simulate(robot, controller, hold, 1.0, initial_positions=pose)
        assert np.abs(result.positions - pose).max() < 1e-9
        motor = robot.actuator_forces(pose, [0.0, 0.0], [0.0, 0.0])
        np.testing.assert_allclose(result.torque[0], motor, rtol=0.0, atol=1e-9)
    regulator = psp3.LinearQuadraticRegulator(
        robot, np.diag([100.0, 100.0, 1.0, 1.0]), 0.01 * np.eye(1), positions=pose
    )
    back = psp3.simulate(
        robot, regulator, hold, 5.0, initial_positions=pose + np.array([0.02, -0.02])
    )
    assert np.abs(back.positions[-1] - pose).max() < 1e-3


def test_what_the_motors_cannot_accelerate_is_named(tmp_path: Path) -> None:
    """A motor at m1 alone cannot give both coordinates accelerations of their own."""
    robot = loaded(tmp_path, five_bar("m1", spring=SPRING), free="keep")
    positions, speeds = robot.reference, np.array([0.2, -0.1])
    one = robot.actuator_forces(positions, speeds, [1.5])
    made = robot.forward_dynamics(positions, speeds, robot.actuation_matrix(positions) @ one)
    assert made[0] == pytest.approx(1.5, rel=1e-10)
    with pytest.raises(UnreachableForces, match="m1, p1"):
        robot.actuator_forces(positions, speeds, [1.5, 0.0])
    # The spring's joint instead, which the motor moves through the dynamics only.
    other = loaded(tmp_path, five_bar("m1", spring=SPRING), free="keep", coordinates=["p1", "m1"])
    at = other.configuration(robot.configuration(positions)[other.coordinates_q])
    assert np.allclose(at, robot.configuration(positions), atol=1e-12)
    at = at[other.coordinates_q]
    turned = other.actuator_forces(at, speeds[::-1], [0.7])
    made = other.forward_dynamics(at, speeds[::-1], other.actuation_matrix(at) @ turned)
    assert made[0] == pytest.approx(0.7, rel=1e-9)
    with pytest.raises(UnreachableForces, match="p1"):
        other.allocated_forces(at, [1.0])


def test_controllers_that_need_all_coordinates_say_so(tmp_path: Path) -> None:
    floating = loaded(tmp_path, biped(*LEGS))
    with pytest.raises(InvalidValue, match="root"):
        psp3.LinearQuadraticRegulator(floating, np.eye(20), np.eye(4))
    with pytest.raises(InvalidValue, match="root"):
        psp3.TimeVaryingLinearQuadraticRegulator(
            floating, Hold(robot=floating), 0.1, np.eye(20), np.eye(4)
        )


def test_limits_encoders_and_delay_of_a_floating_robot(tmp_path: Path) -> None:
    """A limit for each motor, an encoder for each commanded coordinate; the base is seen."""
    robot = loaded(tmp_path, biped(*LEGS, "l_knee", "r_knee"))
    seen = []

    class Watched(Constant):
        def torque(self, t: float, positions: Array, speeds: Array, desired: Motion) -> Array:
            seen.append((positions, speeds))
            return self.forces + t

    limit = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]) / 10.0
    result = psp3.simulate(
        robot,
        Watched(np.full(6, 0.25)),
        Hold(robot=robot),
        0.1,
        torque_limit=limit,
        encoder_resolution=[1e-3, 0.0, 0.0, 0.0],
        delay=2,
    )
    asked = np.clip(0.25 + result.t[:, np.newaxis], -limit, limit)
    np.testing.assert_allclose(result.torque[2:], asked[:-2], rtol=0.0, atol=1e-15)
    positions, speeds = (np.array(rows) for rows in zip(*seen, strict=True))
    counts = positions[:, 0] / 1e-3
    np.testing.assert_allclose(counts, np.round(counts), rtol=0.0, atol=1e-9)
    np.testing.assert_array_equal(positions[:, 1:], result.positions[:, 1:])
    np.testing.assert_array_equal(speeds[:, 1:], result.speeds[:, 1:])
    error = result.desired.positions - result.positions[:, :4]
    assert rms_error(result) == pytest.approx(np.sqrt((error**2).sum(axis=1).mean()), rel=1e-12)
