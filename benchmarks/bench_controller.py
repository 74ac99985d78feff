"""Measure one control step from Python for every controller of chapter 6.

It also measures whole runs in a study. Run by ``make bench``.

``timing.py`` explains how calls are timed. Runs are those of Table 6.3 at 20 dB. Workers are
threads, because the loop of a run is compiled and releases the interpreter lock.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
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
from psp3.control.controller import Controller
from psp3.fuzzy_control.records import record
from psp3.study.execution import execute
from psp3.study.run import Run

BARS = {"t1": 6.0, "it2": 8.0, "gt2, 5 α-planes": 60.0}  # [us]
RUN_BAR = 0.12  # [s] for 10 s at 2 ms
SNR = 20.0
MEMORY_RUNS = 10_000


def contenders() -> dict[str, Callable[[], object]]:
    """Return functions to time, by name, all at the same state on the helix."""
    robot = psp3.load("psp3")
    helix = psp3.trajectories.Helix(robot=robot)
    recorded = record(robot, helix)
    desired = helix(1.234)
    heights, speeds = desired.heights + 0.001, 0.98 * desired.speeds
    controllers: dict[str, Controller] = {
        "PD": psp3.PD(),
        "CTC, closed form": psp3.ComputedTorque(robot),
        "CTC, Pinocchio": psp3.ComputedTorque(robot.dynamics("pinocchio")),
        "CTC, NOC": psp3.ComputedTorque(robot.dynamics("noc")),
    }
    for name, kind in zip(BARS, ("t1", "it2", "gt2"), strict=True):
        controllers[name] = psp3.FuzzyComputedTorque(kind, robot, snr_db=SNR).learn(
            recorded, rng=np.random.default_rng(0)
        )
    functions: dict[str, Callable[[], object]] = {EMPTY_CALL: empty_call()}
    for name, controller in controllers.items():
        functions[name] = lambda torque=controller.torque: torque(0.0, heights, speeds, desired)
    return functions


def seconds_a_run(controller: str, runs: int) -> float:
    """Return the median wall time of a run of 10 s on one core."""
    execute(Run(controller, snr_db=SNR, duration=10.0))
    times = []
    for seed in range(runs):
        start = time.perf_counter()
        execute(Run(controller, snr_db=SNR, duration=10.0, seed=seed))
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def runs_a_second(workers: int, runs: int) -> float:
    """Return how many runs per second a number of threads does, for interval type-2."""
    todo = [Run("it2", snr_db=SNR, duration=10.0, seed=seed) for seed in range(runs)]
    with ThreadPoolExecutor(workers) as pool:
        start = time.perf_counter()
        list(pool.map(execute, todo))
        return runs / (time.perf_counter() - start)


def memory_of_a_study(runs: int) -> dict[str, float]:
    """Return peak memory [MB] before and after a study, and the size of its file.

    The study has a given number of short runs.
    """
    script = (
        "import resource, sys, psp3\n"
        "peak = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024\n"
        "grid = lambda seeds: psp3.grid(controller='ctc', reading='measurement', snr_db=20.0, "
        "duration=0.05, seed=range(seeds))\n"
        "psp3.Study(sys.argv[1], grid(100)).run()\n"
        "before = peak()\n"
        "psp3.Study(sys.argv[1], grid(int(sys.argv[2]))).run()\n"
        "print(before, peak())\n"
    )
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory) / "study.sqlite"
        output = subprocess.run(
            [sys.executable, "-c", script, str(path), str(runs)],
            check=True,
            capture_output=True,
            text=True,
        ).stdout
        before, after = (float(number) for number in output.split())
        return {"before": before, "after": after, "file": path.stat().st_size / 1e6}


def main() -> None:
    """Print the tables and write ``results/bench_controller.json``."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=100, help="samples per row")
    parser.add_argument("--runs", type=int, default=40, help="runs of each controller")
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("results/bench_controller.json"),
        help="where the numbers go",
    )
    arguments = parser.parse_args()
    medians = measure(contenders(), arguments.rounds)
    scale, base = bar_scale(medians), medians["PD"]
    versions = environment("pin", "numba", "numpy")
    print(
        f"one control step from Python, median of {arguments.rounds} samples "
        f"({', '.join(map(' '.join, versions.items()))})\n"
    )
    print(f"{'controller':24s}{'µs':>9s}{'× PD':>9s}{'share of 2 ms':>15s}{'bar [µs]':>11s}")
    for name, median in medians.items():
        bar = BARS[name] * scale if name in BARS else None
        print(
            f"{name:24s}{median:9.2f}{median / base:9.2f}{median / 2000.0:15.3%}"
            f"{bar_and_verdict(median, bar)}"
        )
    print("\na run of 10 s at 2 ms in the study, learning included, on one core")
    runs = {name: seconds_a_run(name, arguments.runs) for name in ("pd", "ctc", "t1", "it2", "gt2")}
    for name, seconds in runs.items():
        verdict = f"   bar {RUN_BAR} s " + ("met" if seconds <= RUN_BAR else "MISSED")
        print(f"{name:24s}{seconds:9.4f} s{verdict if name == 'it2' else ''}")
    counts = sorted({1, 2, 4, os.cpu_count() or 1})
    rates = {workers: runs_a_second(workers, arguments.runs) for workers in counts}
    print(f"\nthreads, on {os.cpu_count()} cores")
    for workers, rate in rates.items():
        print(f"{workers:3d} workers{rate:9.1f} runs/s   × {rate / rates[1]:.2f}")
    memory = memory_of_a_study(MEMORY_RUNS)
    print(
        f"\na study of {MEMORY_RUNS} short runs: peak memory {memory['before']:.0f} MB before, "
        f"{memory['after']:.0f} MB after, file {memory['file']:.1f} MB"
    )
    results = {
        "versions": versions,
        "microseconds": medians,
        "run_seconds": runs,
        "runs_per_second": rates,
        "study_megabytes": memory,
    }
    write_results(arguments.out, results)


if __name__ == "__main__":
    main()
