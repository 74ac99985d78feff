"""Compare robots with loops with Pinocchio, MuJoCo and Drake.

It also measures how the cost grows with the number of loops. Run by ``make bench``.

``timing.py`` explains how calls are timed.
"""

from __future__ import annotations

import argparse
import itertools
import logging
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
from five_bar_chain import five_bar_chain
from timing import (
    EMPTY_CALL,
    bar_and_verdict,
    empty_call,
    environment,
    measure,
    write_results,
)

import psp3
from psp3.description.parts import ROBOT_FILES, THESIS_ROBOTS
from psp3.dynamics.derivatives import inverse_dynamics_derivatives

CHAINS = (1, 2, 5, 10, 20, 50)
CLOSURE, COLD = "closure, from the reference pose", "inverse_dynamics, from the reference pose"
INVERSE, FORWARD, EQUATION = (
    "inverse_dynamics, from the pose before",
    "forward_dynamics, from the pose before",
    "equation_of_motion, from the pose before",
)
DERIVATIVES, TREE = "inverse_dynamics_derivatives", "pin.computeRNEADerivatives (tree only)"
MJ_FORWARD = "mujoco.mj_forward"
CONSTRAINT = "pin.constraintDynamics, loops closed already"
PERIODS, MJ_PERIODS = "250 Runge-Kutta periods of 2 ms", "250 mujoco.mj_step of 2 ms"

BARS = {
    INVERSE: (MJ_FORWARD, 1.5),
    COLD: (MJ_FORWARD, 2.7),
    FORWARD: (MJ_FORWARD, 1.9),
    EQUATION: (MJ_FORWARD, 5.0),
    DERIVATIVES: (TREE, 12.0),
}
"""The reference of each time, and the largest allowed ratio, on each robot."""

PERIOD_BARS = {"five_bar": 1.4, "gough_stewart": 2.0}
"""The same for 250 periods: four exact evaluations against one with soft loops."""

MEAN_BARS = {INVERSE: 1.0, FORWARD: 1.4}
"""The same for the geometric mean over the robots."""

GROWTH_BAR = 1.15
"""Largest allowed exponent of the growth of time with the number of loops."""


def state_of(robot: psp3.ClosedLoopRobot, rng: np.random.Generator) -> tuple[np.ndarray, ...]:
    """Return positions near the reference, speeds, accelerations and forces."""
    n = len(robot.actuated)
    lower, upper = (np.clip(limit, -1.0, 1.0) for limit in robot.limits)
    positions = robot.reference + 0.1 * rng.uniform(-1.0, 1.0, n) * (upper - lower)
    speeds, accelerations = rng.uniform(-0.5, 0.5, n), rng.uniform(-1.0, 1.0, n)
    return (
        positions,
        speeds,
        accelerations,
        robot.inverse_dynamics(positions, speeds, accelerations),
    )


def to_and_fro(positions: np.ndarray) -> Iterator[np.ndarray]:
    """Yield positions that move as in a control loop, by 0.2 mm or mrad per call."""
    way = [positions + 2e-4 * step for step in range(50)]
    return itertools.cycle([*way, *reversed(way)])


def contenders(name: str) -> dict[str, Callable[[], object]]:
    """Return functions to time on one robot, by name, all near the same state."""
    robot = psp3.load(name)
    tree = robot.dynamics("core") if isinstance(robot, psp3.PSP3) else robot
    rng = np.random.default_rng(0)
    positions, speeds, accelerations, forces = state_of(tree, rng)
    closure = tree.closure(positions)
    q, v = closure.configuration, closure.complement @ speeds
    pose, moving = tree.last_pose(), to_and_fro(positions)
    data = tree.model.createData()
    functions: dict[str, Callable[[], object]] = {
        EMPTY_CALL: empty_call(),
        CLOSURE: lambda: tree.configuration(next(moving)),
        COLD: lambda: tree.inverse_dynamics(next(moving), speeds, accelerations),
        INVERSE: lambda: tree.inverse_dynamics(next(moving), speeds, accelerations, pose),
        FORWARD: lambda: tree.forward_dynamics(next(moving), speeds, forces, pose),
        EQUATION: lambda: tree.equation_of_motion(next(moving), speeds, pose),
        DERIVATIVES: lambda: inverse_dynamics_derivatives(
            tree, next(moving), speeds, accelerations
        ),
        TREE: lambda: pin.computeRNEADerivatives(tree.model, data, q, v, v),
        "pin.rnea (tree only)": lambda: pin.rnea(tree.model, data, q, v, v),
        CONSTRAINT: constraint_dynamics(tree, q, v, forces),
    }
    functions.update(mujoco_calls(tree, q, v))
    functions.update(drake_calls(name, tree, q, v))
    return functions


def constraint_dynamics(
    robot: psp3.ClosedLoopRobot, q: np.ndarray, v: np.ndarray, forces: np.ndarray
) -> Callable[[], object]:
    """Return Pinocchio's own call, without the cost of our wrapper."""
    model, data = robot.model, robot.model.createData()
    loops, loop_data = robot.constraint_models, pin.StdVec_RigidConstraintData()
    for loop in loops:
        loop_data.append(loop.createData())
    tau = np.zeros(model.nv)
    tau[robot.actuated_v] = forces
    redundant = sum(loop.residualSize() for loop in loops) > model.nv - len(robot.actuated)
    settings = pin.ProximalSettings(
        1e-12, 1e-12, 1e-6 if redundant else 0.0, 50 if redundant else 1
    )
    pin.initConstraintDynamics(model, data, loops, loop_data)
    return lambda: pin.constraintDynamics(model, data, q, v, tau, loops, loop_data, settings)


def periods(name: str) -> dict[str, Callable[[], object]]:
    """Return half a second under holding forces, with our plant and with MuJoCo's step."""
    import mujoco

    from psp3.robots.mjcf_export import mujoco_state, to_mjcf
    from psp3.simulation.runge_kutta import RungeKutta

    robot = psp3.load(name)
    tree = robot.dynamics("core") if isinstance(robot, psp3.PSP3) else robot
    rest = np.zeros(len(tree.actuated))
    hold = 1.02 * tree.inverse_dynamics(tree.reference, rest, rest)
    plant = RungeKutta(tree)
    engine = mujoco.MjModel.from_xml_string(to_mjcf(tree))
    engine.opt.timestep = 2e-3
    state = mujoco.MjData(engine)

    def ours() -> None:
        plant.start(tree.reference, rest)
        for _ in range(250):
            plant.advance(hold, 2e-3)

    def theirs() -> None:
        state.qpos[:], state.qvel[:] = mujoco_state(tree, tree.q0, np.zeros(tree.model.nv))
        state.ctrl[:] = hold
        for _ in range(250):
            mujoco.mj_step(engine, state)

    return {PERIODS: ours, MJ_PERIODS: theirs}


def mujoco_calls(
    robot: psp3.ClosedLoopRobot, q: np.ndarray, v: np.ndarray
) -> dict[str, Callable[[], object]]:
    """Return MuJoCo's dynamics of the exported robot, with loops as soft constraints."""
    try:
        import mujoco
    except ImportError:
        return {}
    from psp3.robots.mjcf_export import mujoco_state, to_mjcf

    engine = mujoco.MjModel.from_xml_string(to_mjcf(robot))
    state = mujoco.MjData(engine)
    state.qpos[:], state.qvel[:] = mujoco_state(robot, q, v)
    return {
        MJ_FORWARD: lambda: mujoco.mj_forward(engine, state),
        "mujoco.mj_inverse": lambda: mujoco.mj_inverse(engine, state),
    }


def drake_calls(
    name: str, robot: psp3.ClosedLoopRobot, q: np.ndarray, v: np.ndarray
) -> dict[str, Callable[[], object]]:
    """Return Drake's discrete step of 2 ms for the URDF, if Drake is installed.

    Its loops are constraints of the contact solver.
    """
    try:
        from pydrake.math import RigidTransform
        from pydrake.multibody.parsing import Parser
        from pydrake.multibody.plant import DiscreteContactApproximation, MultibodyPlant
    except ImportError:
        return {}
    from psp3.description.loop_file import read_loops

    # Drake warns about the nuts' inertia, which the README of the robot files explains.
    logging.getLogger("drake").setLevel(logging.ERROR)
    plant = MultibodyPlant(time_step=2e-3)
    plant.SetUseSampledOutputPorts(False)
    plant.set_discrete_contact_approximation(DiscreteContactApproximation.kSap)
    Parser(plant).AddModels(str(ROBOT_FILES / f"{name}.urdf"))
    root = robot.model.frames[1].name
    if root != "world":
        plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(root))
    loops = read_loops(ROBOT_FILES / f"{name}.yaml")
    for (first, second), kind in zip(loops.frames, loops.kinds, strict=True):
        one, two = plant.GetBodyByName(first), plant.GetBodyByName(second)
        if kind == "3d":
            plant.AddBallConstraint(body_A=one, p_AP=np.zeros(3), body_B=two, p_BQ=np.zeros(3))
        else:
            plant.AddWeldConstraint(
                body_A=one, X_AP=RigidTransform(), body_B=two, X_BQ=RigidTransform()
            )
    plant.Finalize()
    context = plant.CreateDefaultContext()
    state = np.zeros(plant.num_positions() + plant.num_velocities())
    for number in range(1, robot.model.njoints):
        joint, theirs = (
            robot.model.joints[number],
            plant.GetJointByName(str(robot.model.names[number])),
        )
        state[theirs.position_start()] = q[joint.idx_q]
        state[plant.num_positions() + theirs.velocity_start()] = v[joint.idx_v]
    plant.SetPositionsAndVelocities(context, state)

    def step() -> object:
        # The input changes, because Drake would otherwise return the cached step.
        plant.get_actuation_input_port().FixValue(
            context, np.zeros(plant.num_actuators())
        ) if plant.num_actuators() else None
        plant.SetPositionsAndVelocities(context, state)
        return plant.EvalUniquePeriodicDiscreteUpdate(context)

    return {"Drake, one discrete step of 2 ms": step}


def chain_functions(count: int) -> dict[str, Callable[[], object]]:
    """Return the functions whose cost is measured against the number of loops."""
    robot = five_bar_chain(count)
    positions, speeds, accelerations, forces = state_of(robot, np.random.default_rng(count))
    pose, moving = robot.last_pose(), to_and_fro(positions)
    closure = robot.closure(positions)
    q, v = closure.configuration, closure.complement @ speeds
    functions: dict[str, Callable[[], object]] = {
        COLD: lambda: robot.inverse_dynamics(next(moving), speeds, accelerations),
        INVERSE: lambda: robot.inverse_dynamics(next(moving), speeds, accelerations, pose),
        CONSTRAINT: constraint_dynamics(robot, q, v, forces),
    }
    functions.update(mujoco_calls(robot, q, v))
    return functions


def main() -> None:
    """Print a table for each robot and one for the chains, and write both as JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=30)
    parser.add_argument("--output", type=Path, default=Path("results/bench_general.json"))
    arguments = parser.parse_args()
    robots: dict[str, dict[str, float]] = {}
    for name in THESIS_ROBOTS:
        robots[name] = measure(contenders(name), arguments.rounds)
        if MJ_FORWARD in robots[name]:
            robots[name].update(measure(periods(name), 5))
        show_robot(name, robots[name])
    means = {name: ratio_over_robots(robots, name) for name in MEAN_BARS}
    for name, ratio in means.items():
        print(
            f"{name}, geometric mean over the robots, x {MJ_FORWARD}: {ratio:.2f}"
            f"{bar_and_verdict(ratio, MEAN_BARS[name])}"
        )
    chains: dict[int, dict[str, float]] = {
        count: measure(chain_functions(count), arguments.rounds) for count in CHAINS
    }
    print(
        f"\n{'five-bars in a chain':24s}" + "".join(f"{f'{name} [us]':>50s}" for name in chains[1])
    )
    for count, medians in chains.items():
        print(f"{count:24d}" + "".join(f"{value:50.1f}" for value in medians.values()))
    growth = {
        name: exponent({count: chains[count][name] for count in CHAINS}) for name in chains[1]
    }
    for name, power in growth.items():
        bar = GROWTH_BAR if name in (COLD, INVERSE) else None
        print(
            f"from 1 to 50 loops {name} grows with their number to the power of {power:.2f}"
            f"{bar_and_verdict(power, bar)}"
        )
    results: dict[str, Any] = {
        "versions": environment("psp3", "pin", "numpy", "numba"),
        "robots": robots,
        "means": means,
        "chains": chains,
        "growth": growth,
    }
    write_results(arguments.output, results)


def show_robot(name: str, medians: dict[str, float]) -> None:
    """Print the times of one robot with their references."""
    bars = dict(BARS)
    if name in PERIOD_BARS:
        bars[PERIODS] = MJ_PERIODS, PERIOD_BARS[name]
    print(f"\n{name:50s}{'us':>10s}{'ratio':>10s}{'bar':>11s}")
    for function, value in medians.items():
        other, bar = bars.get(function, (MJ_FORWARD, None))
        if other not in medians:
            print(f"{function:50s}{value:10.1f}")
            continue
        ratio = value / medians[other]
        print(f"{function:50s}{value:10.1f}{ratio:10.2f}{bar_and_verdict(ratio, bar)}")


def ratio_over_robots(robots: dict[str, dict[str, float]], name: str) -> float:
    """Return the geometric mean of a function's time over MuJoCo's; NaN without MuJoCo."""
    ratios = [
        medians[name] / medians[MJ_FORWARD] for medians in robots.values() if MJ_FORWARD in medians
    ]
    return float(np.exp(np.mean(np.log(ratios)))) if ratios else float("nan")


def exponent(times: dict[int, float]) -> float:
    """Return the slope of time over number, both in logarithms, by least squares."""
    return float(np.polyfit(np.log(list(times)), np.log(list(times.values())), 1)[0])


if __name__ == "__main__":
    main()
