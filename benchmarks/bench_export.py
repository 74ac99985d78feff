"""Compare the time of a step in C with the same step from Python, and with fuzzylite's C++.

Run by ``make bench``; it needs a C compiler (``gcc``).

Each function is compiled as in its Makefile, with ``-O2``. It runs over the inputs of its test,
alternating with calls from Python on the same inputs, and processor time is measured. Robots repeat
a feasible motion, in C and in Python, starting each call from the previous pose. fuzzylite takes
part if its library can be linked (Debian's ``libfuzzylite-dev`` and ``g++``). It reads the type-1
systems as FLL, and the difference of its outputs is printed. They differ because it ignores rules
with a firing strength below 1e-6, the only rules that fire for some inputs far outside.
"""

from __future__ import annotations

import argparse
import itertools
import shutil
import statistics
import subprocess
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from timing import environment, write_results

import fuzzy2
import psp3
from fuzzy2.export.project import CASES, inputs_of, write_project
from fuzzy2.export.project_calls import short_name
from fuzzy2.support.checks import Array
from psp3.export import typical_inputs
from psp3.export.face import c_code
from psp3.export.project import export_project
from psp3.trajectories.motion import Motion

HERE = Path(__file__).parent / "export"
SAMPLE = 0.05
"""Approximate duration of a sample [s]."""

LIBRARY = "-lfuzzylite-static"

ROBOTS = ("psp3", "five_bar", "delta", "gough_stewart", "hexa")
PERIOD = 2.0
"""Duration of a robot's motion [s]; its states are 10 ms apart."""


@dataclass(frozen=True)
class Contender:
    """A function in C, and the equivalent call from Python for each of its inputs."""

    name: str
    thing: Any
    function: str
    calls: list[Callable[[], object]]
    fll: str | None = None
    inputs: Mapping[str, Array] | None = None
    """Inputs of the C function, if they differ from those of its folder's test."""


def systems() -> dict[str, Any]:
    """Return systems of the thesis's size: 4 inputs with 2 terms each, 16 rules, 21 outputs."""
    rules = np.array(list(itertools.product(range(2), repeat=4)))
    consequents = np.random.default_rng(0).normal(size=(16, 21))
    ranges = [(-1.5, 1.5)] * 4
    options: dict[str, Any] = {"input_ranges": ranges, "output_ranges": [(-4.0, 4.0)] * 21}
    crisp = [[fuzzy2.Gaussian(m, 0.6) for m in (-1.0, 1.0)]] * 4
    uncertain = [[fuzzy2.GaussianUncertainMean((m - 0.1, m + 0.1), 0.6) for m in (-1.0, 1.0)]] * 4
    general = [
        [
            fuzzy2.GaussianType2Set(principal=fuzzy2.Gaussian(m, 0.6), sigma=0.02)
            for m in (-1.0, 1.0)
        ]
    ] * 4
    return {
        "type-1": fuzzy2.Type1System(crisp, rules, consequents, **options),
        "interval type-2": fuzzy2.IntervalType2System(uncertain, rules, consequents, **options),
        "general type-2, 5 α-planes": fuzzy2.GeneralType2System(
            general, rules, consequents, levels=5, **options
        ),
    }


def finite(*inputs: Array) -> list[tuple[Array, ...]]:
    """Return the finite rows of inputs, for the timed program."""
    return [
        rows for rows in zip(*inputs, strict=True) if all(np.isfinite(row).all() for row in rows)
    ]


def of_systems() -> list[Contender]:
    """Return the fuzzy systems among the contenders."""
    found = []
    for name, system in systems().items():
        calls: list[Callable[[], object]] = [
            lambda x=x, s=system: s(x) for (x,) in finite(inputs_of(system))
        ]
        fll = "rules.fll" if name == "type-1" else None
        found.append(Contender(name, system, "evaluate", calls, fll))
    return found


def of_controllers() -> list[Contender]:
    """Return computed torque of the 3-PSP, exact and learned."""
    robot = psp3.load("psp3")
    helix = psp3.trajectories.Helix(radius=0.020, period=2.0, rise=0.010)
    inputs = typical_inputs.of_controller(robot)
    states = finite(*(inputs[name] for name in ("t", "positions", "speeds", "desired")))
    learned = psp3.FuzzyComputedTorque("it2", robot, learner="average").fit(helix)
    controllers = {
        "computed torque, exact, psp3": psp3.ComputedTorque(robot, kp=10.0, kv=1.0),
        "computed torque, it2, psp3": learned,
    }
    found = []
    for name, controller in controllers.items():
        calls: list[Callable[[], object]] = []
        for t, positions, speeds, desired in states:
            motion = Motion(*desired.reshape(3, 3), tip=np.full(3, np.nan))
            calls.append(
                lambda c=controller, t=float(t[0]), p=positions, v=speeds, d=motion: c.torque(
                    t, p, v, d
                )
            )
        found.append(Contender(name, controller, "step", calls))
    return found


def of_robots() -> list[Contender]:
    """Return inverse and forward dynamics of robots, over a feasible motion."""
    found = []
    for name in ROBOTS:
        robot = psp3.load(name)
        motion = psp3.trajectories.Sway(robot=robot, period=PERIOD)(
            np.linspace(0.0, PERIOD, CASES, endpoint=False)
        )
        q, v, a = motion.positions, motion.speeds, motion.accelerations
        forces = robot.inverse_dynamics(q, v, a)
        inputs = {"positions": q, "heights": q, "speeds": v, "accelerations": a, "forces": forces}
        for function, third in (("inverse_dynamics", a), ("forward_dynamics", forces)):
            ask, last = getattr(robot, function), robot.last_pose()
            calls: list[Callable[[], object]] = [
                lambda ask=ask, last=last, rows=rows: ask(*rows, guess=last)
                for rows in finite(q, v, third)
            ]
            title = f"{function.replace('_', ' ')}, {name}"
            found.append(Contender(title, robot, function, calls, inputs=inputs))
    return found


class Timed:
    """A contender's program in C, and fuzzylite's if it takes part."""

    def __init__(self, contender: Contender, folder: Path) -> None:
        self.contender, self.folder = contender, folder
        if contender.inputs is None:
            code = export_project(contender.thing, folder, name="step")
        else:
            code = c_code(contender.thing, name="step", functions=[contender.function])
            write_project(code, folder, contender.inputs)
        names = [short_name(code, function) for function in code.functions]
        self.number = names.index(contender.function)
        flags = ["-std=c99", "-O2", "-ffp-contract=off", "-I", "."]
        sources = [str(HERE / "step.c"), "step.c", "calls.c", "cases.c"]
        self._compile("gcc", *flags, *sources, "-lm", "-o", "timed")
        self.peer = self._fuzzylite() if contender.fll else None
        self.rounds = {"C": self._rounds(self.c, 1), "fuzzylite": 1}
        if self.peer:
            self.rounds["fuzzylite"] = self._rounds(self.fuzzylite, 1)

    def _compile(self, *command: str) -> None:
        subprocess.run(command, cwd=self.folder, check=True)

    def _fuzzylite(self) -> str | None:
        if shutil.which("g++") is None or not Path("/usr/include/fl/Headers.h").is_file():
            print("fuzzylite takes no part: apt-get install g++ libfuzzylite-dev")
            return None
        self._compile("g++", "-O2", "-w", str(HERE / "fuzzylite.cpp"), LIBRARY, "-o", "peer")
        system = self.contender.thing
        fuzzy2.save(system, self.folder / "rules.fll")
        self.rows = np.array([x for (x,) in finite(inputs_of(system))])
        return "fuzzylite"

    def _rounds(self, timed: Callable[[int], float], rounds: int) -> int:
        """Return the number of rounds for a sample of the right duration."""
        a_round = timed(rounds) * 1e-9 * len(self.contender.calls)
        return max(1, round(SAMPLE / max(a_round, 1e-7)))

    def c(self, rounds: int) -> float:
        """Return nanoseconds of a call in C."""
        words = ["./timed", str(self.number), str(rounds)]
        said = subprocess.run(words, cwd=self.folder, stdout=subprocess.PIPE, check=False)
        return float(said.stdout)

    def fuzzylite(self, rounds: int) -> float:
        """Return nanoseconds of a call of fuzzylite."""
        return self._answers(rounds)[0]

    def difference(self) -> float:
        """Return the greatest difference of fuzzylite's outputs, if it has any.

        It ignores rules with a firing strength below 1e-6.
        """
        return float(np.nanmax(np.abs(self._answers(1)[1] - self.contender.thing(self.rows))))

    def _answers(self, rounds: int) -> tuple[float, Array]:
        text = "\n".join(" ".join(map(repr, row)) for row in self.rows.tolist())
        said = subprocess.run(
            ["./peer", "rules.fll", str(rounds)],
            cwd=self.folder,
            input=text,
            stdout=subprocess.PIPE,
            encoding="utf-8",
            check=False,
        )
        first, *rest = said.stdout.splitlines()
        return float(first), np.array([line.split() for line in rest], dtype=float)

    def python(self) -> float:
        """Return nanoseconds of a call from Python."""
        calls, count = self.contender.calls, 0
        start = time.thread_time()
        while (spent := time.thread_time() - start) < SAMPLE:
            for call in calls:
                call()
            count += len(calls)
        return spent / count * 1e9


def measured(timed: Timed, rounds: int) -> dict[str, list[float]]:
    """Return interleaved samples, in microseconds, by implementation."""
    ways: dict[str, Callable[[], float]] = {
        "C": lambda: timed.c(timed.rounds["C"]),
        "Python": timed.python,
    }
    if timed.peer:
        ways["fuzzylite"] = lambda: timed.fuzzylite(timed.rounds["fuzzylite"])
    samples: dict[str, list[float]] = {name: [] for name in ways}
    for _ in range(rounds):
        for name, way in ways.items():
            samples[name].append(1e-3 * way())
    return samples


def ratio(samples: dict[str, list[float]], name: str) -> dict[str, float]:
    """Return an implementation's time over that of C: median and quartiles."""
    turns = np.divide(samples[name], samples["C"])
    low, middle, high = np.quantile(turns, [0.25, 0.5, 0.75])
    return {"median": float(middle), "low": float(low), "high": float(high)}


def main() -> None:
    """Print the table and write ``results/bench_export.json``."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=9, help="samples per row")
    parser.add_argument(
        "--out", type=Path, default=Path("results/bench_export.json"), help="where the numbers go"
    )
    arguments = parser.parse_args()
    if shutil.which("gcc") is None:
        print("nothing is measured: there is no gcc (apt-get install gcc)")
        return
    versions = environment("numpy", "numba", "pin")
    said = ", ".join(map(" ".join, versions.items()))
    print(f"medians of {arguments.rounds} samples, quartiles of ratios ({said})\n")
    print(f"{'one call [µs]':34s}{'C':>9s}{'Python':>9s}{'fuzzylite':>11s}   in times of C")
    results: dict[str, dict[str, float]] = {}
    times_of_c: dict[str, dict[str, dict[str, float]]] = {}
    for contender in [*of_systems(), *of_controllers(), *of_robots()]:
        with tempfile.TemporaryDirectory() as folder:
            timed = Timed(contender, Path(folder))
            samples = measured(timed, arguments.rounds)
            differs = timed.difference() if timed.peer else None
        found = {name: statistics.median(values) for name, values in samples.items()}
        ratios = {name: ratio(samples, name) for name in samples if name != "C"}
        results[contender.name], times_of_c[contender.name] = found, ratios
        peer = f"{found['fuzzylite']:11.3f}" if "fuzzylite" in found else f"{'':11s}"
        shown = ", ".join(
            f"{name} {r['median']:.1f} ({r['low']:.1f} to {r['high']:.1f})"
            for name, r in ratios.items()
        )
        print(f"{contender.name:34s}{found['C']:9.3f}{found['Python']:9.2f}{peer}   {shown}")
        if differs is not None:
            print(f"{'':34s}fuzzylite's outputs differ by at most {differs:.1e}")
    written = {"versions": versions, "microseconds": results, "times of C": times_of_c}
    write_results(arguments.out, written)


if __name__ == "__main__":
    main()
