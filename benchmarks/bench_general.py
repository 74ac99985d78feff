"""Measure robots with loops in general beside Pinocchio, MuJoCo and Drake.

Also how the cost grows with the loops. Run by ``make bench``.

See ``timing.py`` for how.
"""

from __future__ import annotations

import argparse
import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
from five_bar_chain import five_bar_chain
from timing import (
    EMPTY_CALL,
    bar_and_verdict,
    bar_scale,
    empty_call,
    environment,
    measure,
    write_results,
)

import psp3
from psp3.description.parts import ROBOT_FILES, ROBOTS

CLOSURE_BARS = {"five_bar": 300.0, "gough_stewart": 1000.0}  # [us]
CHAINS = (1, 2, 5, 10, 20, 50)
CLOSURE, INVERSE, FORWARD = (
    "closure, from the reference pose",
    "inverse_dynamics",
    "forward_dynamics",
)


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


def contenders(name: str) -> dict[str, Callable[[], object]]:
    """Functions to time on one robot, by name, all at the same state."""
    robot = psp3.load(name)
    tree = robot.dynamics("core") if isinstance(robot, psp3.PSP3) else robot
    rng = np.random.default_rng(0)
    positions, speeds, accelerations, forces = state_of(tree, rng)
    closure = tree.closure(positions)
    q, v = closure.configuration, closure.complement @ speeds
    functions: dict[str, Callable[[], object]] = {
        EMPTY_CALL: empty_call(),
        CLOSURE: lambda: tree.configuration(positions),
        INVERSE: lambda: tree.inverse_dynamics(positions, speeds, accelerations),
        "equation_of_motion": lambda: tree.equation_of_motion(positions, speeds),
        FORWARD: lambda: tree.forward_dynamics(positions, speeds, forces),
        "pin.constraintDynamics, loops closed already": lambda: tree.constrained_accelerations(
            q, v, forces
        ),
        "pin.rnea (tree only)": lambda: pin.rnea(tree.model, tree.data, q, v, v),
    }
    functions.update(mujoco_calls(tree, q, v))
    functions.update(drake_calls(name, tree, q, v))
    return functions


def mujoco_calls(
    robot: psp3.ClosedLoopRobot, q: np.ndarray, v: np.ndarray
) -> dict[str, Callable[[], object]]:
    """MuJoCo's dynamics of the exported robot, its loops soft constraints as exported."""
    try:
        import mujoco
    except ImportError:
        return {}
    from psp3.robots.mjcf_export import mujoco_state, to_mjcf

    engine = mujoco.MjModel.from_xml_string(to_mjcf(robot))
    state = mujoco.MjData(engine)
    state.qpos[:], state.qvel[:] = mujoco_state(robot, q, v)
    return {
        "mujoco.mj_forward": lambda: mujoco.mj_forward(engine, state),
        "mujoco.mj_inverse": lambda: mujoco.mj_inverse(engine, state),
    }


def drake_calls(
    name: str, robot: psp3.ClosedLoopRobot, q: np.ndarray, v: np.ndarray
) -> dict[str, Callable[[], object]]:
    """Drake's discrete step of 2 ms of the URDF, where Drake is installed.

    Its loops are constraints of the contact solver.
    """
    try:
        from pydrake.math import RigidTransform
        from pydrake.multibody.parsing import Parser
        from pydrake.multibody.plant import DiscreteContactApproximation, MultibodyPlant
    except ImportError:
        return {}
    from psp3.description.loop_file import read_loops

    # It warns of the nuts' inertia, which the README of the robot files explains.
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
        # A changed input, so that the step of before is not handed out again.
        plant.get_actuation_input_port().FixValue(
            context, np.zeros(plant.num_actuators())
        ) if plant.num_actuators() else None
        plant.SetPositionsAndVelocities(context, state)
        return plant.EvalUniquePeriodicDiscreteUpdate(context)

    return {"Drake, one discrete step of 2 ms": step}


def chain_functions(count: int) -> dict[str, Callable[[], object]]:
    """Return the functions whose cost is to grow with the number of loops."""
    robot = five_bar_chain(count)
    positions, speeds, accelerations, forces = state_of(robot, np.random.default_rng(count))
    return {
        CLOSURE: lambda: robot.configuration(positions),
        INVERSE: lambda: robot.inverse_dynamics(positions, speeds, accelerations),
        FORWARD: lambda: robot.forward_dynamics(positions, speeds, forces),
    }


def main() -> None:
    """Print a table for each robot and one for the chains, and write both as JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=30)
    parser.add_argument("--output", type=Path, default=Path("results/bench_general.json"))
    arguments = parser.parse_args()
    robots: dict[str, dict[str, float]] = {}
    for name in ROBOTS:
        medians = measure(contenders(name), arguments.rounds)
        robots[name] = medians
        scale = bar_scale(medians)
        print(f"\n{name:50s}{'us':>10s}{'x inverse_dynamics':>20s}{'bar':>11s}")
        for function, value in medians.items():
            bar = CLOSURE_BARS.get(name) if function == CLOSURE else None
            bar = bar * scale if bar is not None else None
            print(
                f"{function:50s}{value:10.1f}{value / medians[INVERSE]:20.2f}"
                f"{bar_and_verdict(value, bar)}"
            )
    chains: dict[int, dict[str, float]] = {
        count: measure(chain_functions(count), arguments.rounds) for count in CHAINS
    }
    print(
        f"\n{'five-bars in a chain':24s}" + "".join(f"{f'{name} [us]':>45s}" for name in chains[1])
    )
    for count, medians in chains.items():
        print(f"{count:24d}" + "".join(f"{value:45.1f}" for value in medians.values()))
    growth = {
        name: exponent({count: chains[count][name] for count in CHAINS if count >= 10})
        for name in chains[1]
    }
    for name, power in growth.items():
        print(f"from 10 to 50 loops {name} grows with their number to the power of {power:.2f}")
    results: dict[str, Any] = {
        "versions": environment("psp3", "pin", "numpy", "numba"),
        "robots": robots,
        "chains": chains,
        "growth": growth,
    }
    write_results(arguments.output, results)


def exponent(times: dict[int, float]) -> float:
    """Return the slope of time over number, both in logarithms, by least squares."""
    return float(np.polyfit(np.log(list(times)), np.log(list(times.values())), 1)[0])


if __name__ == "__main__":
    main()
