"""Ctrl-C at any moment leaves nothing behind: what is asked afterwards is answered as before.

A signal raises KeyboardInterrupt in the middle of the work, at moments that a seed chooses.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
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

TIMES = 15
"""Interrupts of each work."""

PRESSED_AGAIN = 1.0
"""After how long somebody presses Ctrl-C once more [s]."""

MOST_PRESSED = 3


def is_heard(work: Callable[[], object], seconds: float) -> bool:
    """Do some work again and again, interrupt it after a time, and tell whether that ended it.

    The time is that of the process. Python passes over an interrupt in a finalizer; then it comes
    again, as a user would press the keys again. Where Python or NumPy compare in C what has methods
    in Python, they make another error of an interrupt: ``KeyError`` of a dictionary, ``TypeError``
    of an array.
    """
    raised = []

    def raise_in_the_middle(*_: object) -> None:
        raised.append(True)
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGPROF, raise_in_the_middle)
    try:
        signal.setitimer(signal.ITIMER_PROF, seconds, PRESSED_AGAIN)
        while len(raised) < MOST_PRESSED:
            work()
    except (KeyboardInterrupt, KeyError, TypeError):
        if not raised:
            raise
        return True
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
    return False


def simulated(robot: Any, plant: Any) -> Callable[[], bytes]:
    controller = psp3.ComputedTorque(robot, 100.0, 20.0)
    way = PointToPoint(robot.reference, robot.reference + 0.02, 0.3, robot)

    def work() -> bytes:
        result = psp3.simulate(robot, controller, way, 0.4, plant=plant)
        return result.positions.tobytes() + result.torque.tobytes()

    return work


Work = Callable[[], bytes]


def simulated_psp3() -> Work:
    robot = psp3.load("psp3")
    return simulated(robot, RungeKutta(robot))


def simulated_delta() -> Work:
    robot: Any = psp3.load("delta")
    return simulated(robot, RungeKutta(robot, 3))


def simulated_in_mujoco() -> Work:
    robot: Any = psp3.load("delta")
    return simulated(robot, psp3.MuJoCo(robot))


def batch(name: str, count: int) -> Work:
    robot: Any = psp3.load(name)
    rows = robot.reference + np.linspace(-0.1, 0.1, count)[:, np.newaxis]
    return lambda: robot.inverse_dynamics(rows, rows, rows).tobytes()


def path() -> Work:
    robot: Any = psp3.load("delta")
    rows = robot.reference + np.linspace(-0.1, 0.1, 3000)[:, np.newaxis]
    return lambda: robot.configurations_along(rows).tobytes()


def last_pose() -> Work:
    """Return a batch from the last pose, which is forgotten: answers would differ by rounding."""
    robot: Any = psp3.load("delta")
    rows = robot.reference + np.linspace(-0.1, 0.1, 3000)[:, np.newaxis]
    guess = robot.last_pose()

    def work() -> bytes:
        guess.forget()
        return bytes(robot.inverse_dynamics(rows, rows, rows, guess=guess).tobytes())

    return work


def fitted(learner: Any) -> Work:
    x = np.random.default_rng(3).uniform(0.0, 1.0, (200, 2))
    y = x[:, 0] * x[:, 1]
    return lambda: learner.fit(x, y).predict(x).tobytes()


def fitted_torque() -> Work:
    robot: Any = psp3.load("psp3")
    controller = psp3.FuzzyComputedTorque("it2", robot)
    state = robot.reference, np.zeros(3)
    way = Circle(robot=robot)
    return lambda: np.asarray(controller.fit(way, 2.0).estimate(*state)[0]).tobytes()


WORKS: dict[str, Callable[[], Work]] = {
    "simulate": simulated_psp3,
    "simulate any robot": simulated_delta,
    "simulate in MuJoCo": simulated_in_mujoco,
    "batch": lambda: batch("delta", 3000),
    "batch of the 3-PSP": lambda: batch("psp3", 30_000),
    "path": path,
    "last pose": last_pose,
    "fit ANFIS": lambda: fitted(fuzzy2.ANFIS(n_terms=3)),
    "fit Wang-Mendel": lambda: fitted(fuzzy2.WangMendel(n_terms=5)),
    "fit": fitted_torque,
    "load": lambda: lambda: psp3.to_mjcf(psp3.load("delta")).encode(),
}
"""What is interrupted, with the same objects again and again."""


@pytest.mark.slow
# Of interrupts in finalizers Python says that it passes over them.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("name", WORKS)
def test_interrupted_work_is_done_as_before_the_next_time(name: str) -> None:
    work = WORKS[name]()
    expected = work()
    rng = np.random.default_rng(7)
    for _ in range(TIMES):
        assert is_heard(work, rng.uniform(1e-4, 0.2))
    assert work() == expected


COMPILED = """
import numpy as np, signal, sys, time
import fuzzy2
means = [fuzzy2.Gaussian(m, 0.3) for m in (0.0, 1.0)]
rules, numbers = [[0, 0], [0, 1], [1, 0], [1, 1]], [[0.0], [1.0], [2.0], [4.0]]
system = fuzzy2.Type1System([means] * 2, rules, numbers)

def interrupt(*_):
    if armed:
        came.append(True)
        signal.raise_signal(signal.SIGINT)

signal.signal(signal.SIGINT, signal.default_int_handler)

signal.signal(signal.SIGPROF, interrupt)
rng, count, came, armed = np.random.default_rng({seed}), 0, [], []
while True:
    came.clear()
    try:
        # Of what has been compiled the next attempt may find nothing: twice as long each time, so
        # that all of them take a few times as long as to compile once, on however slow a machine.
        # And again, where Python passes over an interrupt, as in a finalizer.
        moment = rng.uniform(0.05, 0.1 * 2.0**count)
        signal.setitimer(signal.ITIMER_PROF, moment, 1.0)
        armed.append(True)
        found = system([[0.2, 0.7]])
        low, high = fuzzy2.centroid([1.0, 2.0, 3.0], [0.1, 0.2, 0.1], [0.5, 0.6, 0.9])
        armed.clear()
        break
    except (KeyboardInterrupt, KeyError, TypeError):
        armed.clear()
        if not came:
            raise
        count += 1
signal.setitimer(signal.ITIMER_PROF, 0.0)
print(count, found[0, 0].hex(), low.hex(), high.hex())
"""


@pytest.mark.slow
def test_a_compiler_that_was_interrupted_compiles_the_next_time(tmp_path: Path) -> None:
    """In an empty folder for code, which then holds what is right."""
    environment = {**os.environ, **ENVIRONMENT, "NUMBA_CACHE_DIR": str(tmp_path)}
    answers = []
    for number in (1, 101):
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
