"""Memory that a process holds, and how it grows when the same thing is done again and again.

It is known in two ways. What is in use, in :func:`in_use`, is counted to the byte, so that a leak
shows after some calls; but who asks the system for memory past the C library is not seen. What the
system has given, in :func:`held`, is all there is, but comes in large parts: it takes many calls.

``python -m tests.endurance.memory`` looks at what is held: it does ten million cheap calls in all,
and loads every shipped robot a thousand times; that takes hours. With a number it does so many
calls, and a ten-thousandth of that many loads. With names behind it, those alone.
"""

from __future__ import annotations

import ctypes
import functools
import gc
import os
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np

import fuzzy2
import psp3
from psp3.description.parts import ROBOTS
from psp3.simulation.runge_kutta import RungeKutta

ROUNDS = 10
"""Parts of a run after which memory is looked at; the first half is to settle."""

WINDOWS = 5
"""Parts of a short run, of which the median counts: a cache that fills does so in one or two."""


class Use(NamedTuple):
    """Memory in use: bytes of the C library's, and blocks of Python's own, of 512 at most."""

    bytes: float
    blocks: float


class _Mallinfo2(ctypes.Structure):
    _fields_ = [
        (name, ctypes.c_size_t)
        for name in (
            *("arena", "ordblks", "smblks", "hblks", "hblkhd"),
            *("usmblks", "fsmblks", "uordblks", "fordblks", "keepcost"),
        )
    ]


@functools.cache
def _mallinfo2() -> Callable[[], Any]:
    function: Any = ctypes.CDLL(None).mallinfo2
    function.restype = _Mallinfo2
    return cast("Callable[[], Any]", function)


def in_use() -> Use:
    """Return what is in use: of C, C++ and arrays in bytes, of Python's small objects in blocks."""
    gc.collect()
    # What types have been asked for: Python keeps the last 4096 names, each as often as C made it.
    getattr(sys, "_clear_internal_caches", sys._clear_type_cache)()
    info = _mallinfo2()()
    return Use(float(info.uordblks + info.hblkhd), float(sys.getallocatedblocks()))


def growth(call: Callable[[], object], count: int) -> Use:
    """Return by how much the memory in use grows with a call, the median of windows of so many."""
    for _ in range(count):
        call()
    # Made before, so that looking takes no memory of its own.
    looks = np.zeros((WINDOWS + 1, 2))
    looks[0] = in_use()
    for window in range(WINDOWS):
        for _ in range(count):
            call()
        looks[window + 1] = in_use()
    grown = np.median(np.diff(looks, axis=0), axis=0) / count
    return Use(float(grown[0]), float(grown[1]))


def held() -> int:
    """Return the bytes that this process holds for itself, after what can be freed is."""
    gc.collect()
    _malloc_trim()
    fields = Path("/proc/self/statm").read_text(encoding="utf-8").split()
    return (int(fields[1]) - int(fields[2])) * os.sysconf("SC_PAGE_SIZE")


@functools.cache
def _trim() -> Callable[[int], int]:
    trim: Callable[[int], int] = ctypes.CDLL(None).malloc_trim
    return trim


def _malloc_trim() -> None:
    # What is free in the middle of the heap goes back, too, and is not taken for a leak.
    _trim()(0)


def slope(call: Callable[[], object], count: int) -> float:
    """Return by how many bytes memory grows with a call, of so many.

    The median of the slopes between any two looks at it in the second half (Theil and Sen): a
    cache that fills once is no slope, and one look that meets something else changes nothing.
    """
    each = max(1, count // ROUNDS)
    looks = []
    for _ in range(ROUNDS):
        for _ in range(each):
            call()
        looks.append(held())
    late = looks[ROUNDS // 2 - 1 :]
    slopes = [
        (late[j] - late[i]) / ((j - i) * each)
        for i in range(len(late))
        for j in range(i + 1, len(late))
    ]
    return float(np.median(slopes))


def calls() -> dict[str, Callable[[], object]]:
    """Return cheap calls of every kind, by name."""
    robot, other = psp3.load("psp3"), psp3.load("delta")
    heights, joints = robot.reference + 0.01, other.reference + 0.01
    three, guess = np.full(3, 0.1), other.last_pose()
    terms = [[fuzzy2.Gaussian(m, 0.3) for m in (0.0, 1.0)]] * 2
    wide = [[fuzzy2.GaussianUncertainMean((m, m + 0.1), 0.3) for m in (0.0, 1.0)]] * 2
    rules, numbers = [[0, 0], [0, 1], [1, 0], [1, 1]], [[0.0], [1.0], [2.0], [4.0]]
    one, two = (
        fuzzy2.Type1System(terms, rules, numbers),
        fuzzy2.IntervalType2System(wide, rules, numbers),
    )
    adaptive = fuzzy2.AdaptiveConsequents(one)
    x, points, low, high = np.array([0.2, 0.7]), np.arange(9.0), np.full(9, 0.2), np.full(9, 0.9)
    controller = psp3.ComputedTorque(robot, 100.0, 20.0)
    desired = psp3.trajectories.Helix(robot=robot)(np.array([0.0]))
    wanted = type(desired)(*(row[0] for row in desired))
    steps = RungeKutta(other)
    steps.start(other.reference, np.zeros(3))
    inputs = np.tile(x, (300, 1))
    return {
        "PSP3.inverse_dynamics": lambda: robot.inverse_dynamics(heights, three, three),
        "PSP3.forward_dynamics": lambda: robot.forward_dynamics(heights, three, three),
        "PSP3.forward_kinematics": lambda: robot.forward_kinematics(heights),
        "PSP3, refused": lambda: refused(
            lambda: robot.inverse_dynamics(heights * np.nan, three, three)
        ),
        "inverse_dynamics": lambda: other.inverse_dynamics(joints, three, three),
        "inverse_dynamics, last pose": lambda: other.inverse_dynamics(
            joints, three, three, guess=guess
        ),
        "configuration": lambda: other.configuration(joints),
        "refused": lambda: refused(lambda: other.configuration(joints + 9.0)),
        "RungeKutta.advance": lambda: steps.advance(np.zeros(3), 1e-9),
        "ComputedTorque.torque": lambda: controller.torque(0.0, heights, three, wanted),
        "Type1System": lambda: one(x),
        "Type1System of rows": lambda: one(inputs),
        "IntervalType2System": lambda: two(x),
        "IntervalType2System, refused": lambda: refused(lambda: two(x * np.nan)),
        "AdaptiveConsequents": lambda: adaptive.update(x, [1.0]),
        "centroid": lambda: fuzzy2.centroid(points, low, high),
        "Gaussian": lambda: fuzzy2.Gaussian(0.0, 1.0)(0.5),
        "t_norm": lambda: fuzzy2.t_norm("product")(0.5, 0.5),
        "parse_rules": lambda: fuzzy2.parse_rules(
            "IF a is low THEN b is high", {"a": ["low"]}, {"b": ["high"]}
        ),
        "Run": lambda: psp3.Run(seed=1),
    }


def loads(folder: Path) -> dict[str, Callable[[], object]]:
    """Return what loads each shipped robot, and a file with each reader, by name."""
    robot = psp3.load("psp3")
    found: dict[str, Callable[[], object]] = {
        f"load {name}": functools.partial(psp3.load, name) for name in ROBOTS
    }
    sets = {name: fuzzy2.Triangular(m - 1.0, m, m + 1.0) for name, m in (("low", 0), ("high", 1))}
    system = fuzzy2.Type1System(
        {"a": sets, "b": sets},
        "IF a is low AND b is low THEN y is low\nIF a is high THEN y is high",
        {"y": sets},
        type_reduction="centroid",
        input_ranges=[(0.0, 1.0)] * 2,
        output_ranges=[(0.0, 1.0)],
    )
    integration = {
        "fis": {"integration": "sum", "resolution": 101},
        "fll": {"integration": "midpoint", "resolution": 100},
    }
    for ending in ("json", "fis", "fll", "fcl", "fml"):
        fuzzy2.save(system.replace(**integration.get(ending, {})), folder / f"system.{ending}")
        found[f"load .{ending}"] = functools.partial(fuzzy2.load, folder / f"system.{ending}")
    pd = psp3.GravityCompensatedPD(robot)
    result = psp3.simulate(robot, pd, psp3.trajectories.Helix(robot=robot), 0.1)
    result.save(folder / "result.npz")
    found["load_result"] = lambda: psp3.load_result(folder / "result.npz")
    fuzzy = psp3.FuzzyComputedTorque("it2", robot).fit(psp3.trajectories.Helix(robot=robot), 1.0)
    fuzzy.save(folder / "controller.json")
    found["load a controller"] = lambda: psp3.FuzzyComputedTorque.load(
        folder / "controller.json", robot
    )
    rows = np.column_stack([np.linspace(0.0, 1.0, 50)] * 2 + [np.zeros((50, 2))])
    np.savetxt(folder / "motion.csv", rows, delimiter=",", header="t,a1,a2,a3", comments="")
    found["FromCSV"] = lambda: psp3.trajectories.FromCSV(folder / "motion.csv", robot)
    study = folder / "runs.sqlite"
    psp3.Study(study, [psp3.Run("ctc", duration=0.02)]).run(1)
    found["Study.rows"] = lambda: list(psp3.Study(study).rows())
    found["to_mjcf"] = lambda: psp3.to_mjcf(psp3.load("delta"))
    found["unreadable"] = lambda: refused(lambda: fuzzy2.load(folder / "motion.csv"))
    return found


def refused(call: Callable[[], object]) -> None:
    """Do what is refused."""
    try:
        call()
    except (psp3.PSP3Error, fuzzy2.Fuzzy2Error):
        return
    raise AssertionError("was not refused")


def main(count: int = 10_000_000, *names: str) -> None:
    """Print the slope of everything, with as many calls of each as share the number."""
    with tempfile.TemporaryDirectory() as folder:
        cheap, dear = calls(), loads(Path(folder))
        for kind, number in ((cheap, count // len(cheap)), (dear, max(20, count // 10_000))):
            for name, call in kind.items():
                if names and name not in names:
                    continue
                call()
                begun = time.monotonic()
                grown = slope(call, number)
                seconds = time.monotonic() - begun
                sys.stdout.write(f"{name}\t{number}\t{grown:.3f} bytes\t{seconds:.1f} s\n")
                sys.stdout.flush()


if __name__ == "__main__":
    main(*map(int, sys.argv[1:2]), *sys.argv[2:])
