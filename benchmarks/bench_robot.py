"""Measure one call from Python of the robot's functions.

Beside Pinocchio and MuJoCo on the same tree. Run by ``make bench``.

See ``timing.py`` for how.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
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
from psp3.description.parts import ROBOT_FILES

# [us]
BARS = {
    "forward_kinematics": 3.0,
    "equation_of_motion": 5.0,
    "inverse_dynamics": 4.0,
    "forward_dynamics": 5.0,
}


def contenders() -> dict[str, Callable[[], object]]:
    """Functions to time, by name, all at the same state."""
    robot = psp3.load("psp3")
    heights, speeds = np.array([0.15, 0.25, 0.17]), np.array([0.25, 0.22, 0.20])
    accelerations, forces = np.array([0.1, -0.2, 0.3]), np.array([86.0, 87.0, 88.0])
    noc, pinocchio_path = robot.dynamics("noc"), robot.dynamics("pinocchio")
    model, data = robot.model, robot.model.createData()
    q = robot.configuration(heights)
    v = noc.L(q) @ speeds
    a, tau = np.zeros(model.nv), np.zeros(model.nv)
    closures, closure_data = pin.StdVec_RigidConstraintModel(), pin.StdVec_RigidConstraintData()
    for closure in robot.constraint_models:
        closures.append(closure)
        closure_data.append(closure.createData())
    pin.initConstraintDynamics(model, data, closures, closure_data)
    settings = pin.ProximalSettings(1e-12, 0.0, 1)
    functions: dict[str, Callable[[], object]] = {
        EMPTY_CALL: empty_call(),
        "forward_kinematics": lambda: robot.forward_kinematics(heights),
        "equation_of_motion": lambda: robot.equation_of_motion(heights, speeds),
        "inverse_dynamics": lambda: robot.inverse_dynamics(heights, speeds, accelerations),
        "forward_dynamics": lambda: robot.forward_dynamics(heights, speeds, forces),
        "inverse_kinematics_tip": lambda: robot.inverse_kinematics_tip(
            np.array([0.01, 0.005, 0.1])
        ),
        "configuration": lambda: robot.configuration(heights),
        "pin.rnea (tree only)": lambda: pin.rnea(model, data, q, v, a),
        "pin.crba (tree only)": lambda: pin.crba(model, data, q),
        "pin.constraintDynamics": lambda: pin.constraintDynamics(
            model, data, q, v, tau, closures, closure_data, settings
        ),
        "Pinocchio path: inverse_dynamics": lambda: pinocchio_path.inverse_dynamics(
            heights, speeds, accelerations
        ),
        "NOC: equation_of_motion": lambda: noc.equation_of_motion(heights, speeds),
    }
    try:
        import mujoco
    except ImportError:
        return functions
    # MuJoCo refuses the nuts' inertia; balancing it changes nothing, because nuts do not turn.
    text = (ROBOT_FILES / "psp3.urdf").read_text(encoding="utf-8")
    options = (
        '<mujoco><compiler balanceinertia="true" discardvisual="true" fusestatic="false"/></mujoco>'
    )
    engine = mujoco.MjModel.from_xml_string(
        text.replace('<robot name="psp3">', f'<robot name="psp3">{options}')
    )
    state = mujoco.MjData(engine)
    functions["mujoco.mj_forward (tree only)"] = lambda: mujoco.mj_forward(engine, state)
    return functions


def simulation_times(rounds: int = 5) -> dict[str, float]:
    """Median wall time of a 10 s simulation at 2 ms in seconds, by controller."""
    robot = psp3.load("psp3")
    helix = psp3.trajectories.Helix(robot=robot)
    times = {}
    for controller in (psp3.PD(), psp3.ComputedTorque(robot)):
        psp3.simulate(robot, controller, helix, 0.1)
        samples = []
        for _ in range(rounds):
            start = time.perf_counter()
            psp3.simulate(robot, controller, helix, 10.0)
            samples.append(time.perf_counter() - start)
        times[type(controller).__name__] = statistics.median(samples)
    return times


def main() -> None:
    """Print the table and write ``results/bench_robot.json``."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=100, help="samples per row")
    parser.add_argument(
        "--out", type=Path, default=Path("results/bench_robot.json"), help="where the numbers go"
    )
    arguments = parser.parse_args()
    medians = measure(contenders(), arguments.rounds)
    scale, base = bar_scale(medians), medians["equation_of_motion"]
    versions = environment("pin", "numba")
    print(
        f"one call from Python, median of {arguments.rounds} samples "
        f"({', '.join(map(' '.join, versions.items()))})\n"
    )
    print(f"{'function':36s}{'µs':>9s}{'× equation_of_motion':>22s}{'bar [µs]':>11s}")
    for name, median in medians.items():
        bar = BARS[name] * scale if name in BARS else None
        print(f"{name:36s}{median:9.2f}{median / base:22.2f}{bar_and_verdict(median, bar)}")
    simulations = simulation_times()
    print()
    for name, seconds in simulations.items():
        print(
            f"10 s simulation at 2 ms, RK4, {name:16s}{seconds:9.3f} s   (bar 0.15 s for "
            "ComputedTorque)"
        )
    write_results(
        arguments.out,
        {"versions": versions, "microseconds": medians, "simulation_seconds": simulations},
    )


if __name__ == "__main__":
    main()
