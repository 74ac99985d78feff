"""Ctrl-C at any moment leaves nothing behind: what is asked afterwards is answered as before.

An alarm raises KeyboardInterrupt in the middle of the work, at moments that a seed chooses.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fuzzy2
import psp3
from psp3.simulation.runge_kutta import RungeKutta
from psp3.trajectories import Circle, PointToPoint
from tests.processes import ENVIRONMENT

TIMES = 40
"""Interrupts of each work."""


def interrupted(work: Callable[[], object], seconds: float) -> bool:
    """Do some work, and interrupt it after a time; tell whether it was not done before."""

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, interrupt)
    try:
        try:
            signal.setitimer(signal.ITIMER_REAL, seconds)
            work()
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
    except KeyboardInterrupt:
        return True
    finally:
        signal.signal(signal.SIGALRM, before)
    return False


def simulated(robot: Any, plant: Any) -> Callable[[], bytes]:
    controller = psp3.ComputedTorque(robot, 100.0, 20.0)
    way = PointToPoint(robot.reference, robot.reference + 0.02, 0.3, robot)

    def work() -> bytes:
        result = psp3.simulate(robot, controller, way, 0.4, plant=plant)
        return result.positions.tobytes() + result.torque.tobytes()

    return work


def works() -> dict[str, Callable[[], bytes]]:
    """Return what is interrupted, by name; each uses the same objects again and again."""
    psp, delta = psp3.load("psp3"), psp3.load("delta")
    rows = delta.reference + np.linspace(-0.1, 0.1, 3000)[:, np.newaxis]
    guess = delta.last_pose()
    heights = psp.reference + np.linspace(-0.1, 0.1, 30_000)[:, np.newaxis]
    x = np.random.default_rng(3).uniform(0.0, 1.0, (200, 2))
    y = x[:, 0] * x[:, 1]
    anfis, learner = fuzzy2.ANFIS(n_terms=3), fuzzy2.WangMendel(n_terms=5)
    torque = psp3.FuzzyComputedTorque("it2", psp)
    return {
        "simulate": simulated(psp, RungeKutta(psp)),
        "simulate any robot": simulated(delta, RungeKutta(delta, 3)),
        "simulate in MuJoCo": simulated(delta, psp3.MuJoCo(delta)),
        "batch": lambda: delta.inverse_dynamics(rows, rows, rows).tobytes(),
        "batch of the 3-PSP": lambda: psp.inverse_dynamics(heights, heights, heights).tobytes(),
        "path": lambda: delta.configurations_along(rows).tobytes(),
        "last pose": lambda: delta.inverse_dynamics(rows, rows, rows, guess=guess).tobytes(),
        "fit ANFIS": lambda: anfis.fit(x, y).predict(x).tobytes(),
        "fit Wang-Mendel": lambda: learner.fit(x, y).predict(x).tobytes(),
        "fit": lambda: np.asarray(
            torque.fit(Circle(robot=psp), 2.0).estimate(psp.reference, np.zeros(3))[0]
        ).tobytes(),
        "load": lambda: psp3.load("delta").inverse_dynamics(rows[:9], rows[:9], rows[:9]).tobytes(),
    }


@pytest.fixture(scope="module")
def all_works() -> dict[str, Callable[[], bytes]]:
    return works()


NAMES = (
    "simulate",
    "simulate any robot",
    "simulate in MuJoCo",
    "batch",
    "batch of the 3-PSP",
    "path",
    "last pose",
    "fit ANFIS",
    "fit Wang-Mendel",
    "fit",
    "load",
)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_interrupted_work_is_done_as_before_the_next_time(
    name: str, all_works: dict[str, Callable[[], bytes]]
) -> None:
    work = all_works[name]
    expected = work()
    work()
    begun = time.perf_counter()
    work()
    duration = time.perf_counter() - begun
    rng = np.random.default_rng(7)
    count = sum(interrupted(work, max(rng.uniform(0.0, duration), 1e-5)) for _ in range(TIMES))
    assert count > TIMES // 4
    assert work() == expected


def test_all_works_are_interrupted(all_works: dict[str, Callable[[], bytes]]) -> None:
    assert tuple(all_works) == NAMES


COMPILED = """
import numpy as np, signal, sys, time
import fuzzy2
means = [fuzzy2.Gaussian(m, 0.3) for m in (0.0, 1.0)]
rules, numbers = [[0, 0], [0, 1], [1, 0], [1, 1]], [[0.0], [1.0], [2.0], [4.0]]
system = fuzzy2.Type1System([means] * 2, rules, numbers)

def interrupt(*_):
    raise KeyboardInterrupt

signal.signal(signal.SIGALRM, interrupt)
rng, count = np.random.default_rng({seed}), 0
while True:
    signal.setitimer(signal.ITIMER_REAL, rng.uniform(0.001, 0.5 + 0.3 * count))
    try:
        found = system([[0.2, 0.7]])
        low, high = fuzzy2.centroid([1.0, 2.0, 3.0], [0.1, 0.2, 0.1], [0.5, 0.6, 0.9])
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        break
    except KeyboardInterrupt:
        count += 1
print(count, found[0, 0].hex(), low.hex(), high.hex())
"""


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_a_compiler_that_was_interrupted_compiles_the_next_time(seed: int, tmp_path: Path) -> None:
    """In an empty folder for code, which then holds what is right."""
    environment = {**os.environ, **ENVIRONMENT, "NUMBA_CACHE_DIR": str(tmp_path)}
    answers = []
    for number in (seed, seed + 100):
        command = [sys.executable, "-c", COMPILED.format(seed=number)]
        done = subprocess.run(command, env=environment, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        answers.append(done.stdout.split())
    assert int(answers[0][0]) > 1
    means = [fuzzy2.Gaussian(m, 0.3) for m in (0.0, 1.0)]
    rules, numbers = [[0, 0], [0, 1], [1, 0], [1, 1]], [[0.0], [1.0], [2.0], [4.0]]
    expected = fuzzy2.Type1System([means] * 2, rules, numbers)([[0.2, 0.7]])
    ends = fuzzy2.centroid([1.0, 2.0, 3.0], [0.1, 0.2, 0.1], [0.5, 0.6, 0.9])
    for answer in answers:
        assert [float.fromhex(one) for one in answer[1:]] == [*expected[0], *ends]
    assert not list(tmp_path.rglob("*.tmp.*"))
