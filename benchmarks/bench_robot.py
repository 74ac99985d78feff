"""Measure one call of the robot's functions from Python.

They are compared with Pinocchio and MuJoCo on the same tree. Batches are measured state by state
and many states at a time, on one core and on all. Run by ``make bench``.

``timing.py`` explains how calls are timed.
"""

from __future__ import annotations

import argparse
import os
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
from psp3.three_psp import closed_form

# [us]
BARS = {
    "forward_kinematics": 3.0,
    "equation_of_motion": 5.0,
    "inverse_dynamics": 4.0,
    "forward_dynamics": 5.0,
}

BATCHES = (10_000, 100_000)
STATE_BY_STATE, ONE_CORE, ALL_CORES = "state by state", "many states, one core", "all cores"
# Ratio of many states at a time on one core to state by state, in CPU time.
BATCH_BAR = 0.3
# Ratios of two cores to one: wall time on an idle machine, and CPU time.
SPEED_UP_BAR, CPU_BAR = 1.7, 1.1


def contenders() -> dict[str, Callable[[], object]]:
    """Return functions to time, by name, all at the same state."""
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
    text = (ROBOT_FILES / "psp3.urdf").read_text(encoding="utf-8")
    engine = mujoco.MjModel.from_xml_string(
        text.replace("<compiler ", '<compiler discardvisual="true" fusestatic="false" ')
    )
    state = mujoco.MjData(engine)
    functions["mujoco.mj_forward (tree only)"] = lambda: mujoco.mj_forward(engine, state)
    return functions


def batch_times(rows: int, rounds: int = 200) -> dict[str, dict[str, float]]:
    """Return median wall and CPU times of inverse dynamics [µs per state] by method.

    CPU time is that of all threads. For one core, this thread is bound to a core during the
    measurement.
    """
    robot, rng = psp3.load("psp3"), np.random.default_rng(0)
    heights, speeds = rng.uniform(0.1, 0.3, (rows, 3)), rng.uniform(-0.3, 0.3, (rows, 3))
    accelerations, out = rng.uniform(-1.0, 1.0, (rows, 3)), np.empty(3 * rows)
    p = robot.parameters.as_array()
    flat = [array.reshape(-1) for array in (heights, speeds, accelerations)]

    def many() -> object:
        return robot.inverse_dynamics(heights, speeds, accelerations)

    all_cores = os.sched_getaffinity(0)
    ways: dict[str, tuple[set[int], Callable[[], object]]] = {
        STATE_BY_STATE: (
            {max(all_cores)},
            lambda: closed_form.inverse_dynamics(*flat, p, out),
        ),
        ONE_CORE: ({max(all_cores)}, many),
        ALL_CORES: (all_cores, many),
    }
    samples: dict[str, list[tuple[float, float]]] = {name: [] for name in ways}
    try:
        for _ in range(rounds):
            for name, (cores, function) in ways.items():
                os.sched_setaffinity(0, cores)
                function()
                wall, cpu = time.perf_counter(), time.process_time()
                function()
                samples[name].append((time.perf_counter() - wall, time.process_time() - cpu))
    finally:
        os.sched_setaffinity(0, all_cores)
    return {
        name: {
            "wall": statistics.median(wall for wall, _ in taken) / rows * 1e6,
            "cpu": statistics.median(cpu for _, cpu in taken) / rows * 1e6,
        }
        for name, taken in samples.items()
    }


def print_batches(batches: dict[str, dict[str, dict[str, float]]]) -> None:
    """Print the tables of batches with their bars."""
    cores = len(os.sched_getaffinity(0))
    print(
        f"\ninverse dynamics of a batch, µs a state ({cores} cores, load {os.getloadavg()[0]:.1f} "
        "processes; bars of wall time hold where nothing else runs)\n"
    )
    print(f"{'':45s}{'wall':>9s}{'CPU':>9s}")
    for rows, times in batches.items():
        for name, time_of in times.items():
            print(f"{rows + ' states, ' + name:45s}{time_of['wall']:9.4f}{time_of['cpu']:9.4f}")
        one, two = times[ONE_CORE], times[ALL_CORES]
        ratio = one["cpu"] / times[STATE_BY_STATE]["cpu"]
        print(f"{'CPU beside state by state':45s}{ratio:9.2f}{bar_and_verdict(ratio, BATCH_BAR)}")
        # The bars are for two cores, and the short batch is too short for a second thread.
        speed_up, cpu = one["wall"] / two["wall"], two["cpu"] / one["cpu"]
        bars = (SPEED_UP_BAR, CPU_BAR) if cores == 2 and int(rows) == max(BATCHES) else (None, None)
        print(
            f"{'speed-up by all cores':45s}{speed_up:9.2f}"
            f"{bar_and_verdict(speed_up, bars[0], at_least=True)}"
        )
        print(f"{'CPU beside one core':45s}{cpu:9.2f}{bar_and_verdict(cpu, bars[1])}")


def simulation_times(rounds: int = 5) -> dict[str, float]:
    """Return the median wall time of a 10 s simulation at 2 ms [s], by controller."""
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
    batches = {str(rows): batch_times(rows) for rows in BATCHES}
    print_batches(batches)
    simulations = simulation_times()
    print()
    for name, seconds in simulations.items():
        print(
            f"10 s simulation at 2 ms, RK4, {name:16s}{seconds:9.3f} s   (bar 0.15 s for "
            "ComputedTorque)"
        )
    write_results(
        arguments.out,
        {
            "versions": versions,
            "microseconds": medians,
            "batches": batches,
            "cores": len(os.sched_getaffinity(0)),
            "simulation_seconds": simulations,
        },
    )


if __name__ == "__main__":
    main()
