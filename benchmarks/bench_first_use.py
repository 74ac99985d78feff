"""Measure how long somebody waits who uses the package for the first time, and then again.

Run by ``make bench``. Each command is started with an empty cache folder, where it compiles what it
needs, and three times more. Time is that of the processor, of the process and all that it starts.

``python benchmarks/bench_first_use.py --clone`` also does what the README tells first: it clones
the repository, installs (which downloads a GiB), and shows a machine that moves.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from timing import environment, write_results

ROOT = Path(__file__).resolve().parents[1]
AGAIN = 3
"""So many times a command is repeated; the least time counts."""

LOADED = "from psp3 import load; robot = load({!r})"
ASKED = f"{LOADED}; robot.inverse_dynamics(robot.reference, *[0 * robot.reference] * 2)"
PROGRAMS = {
    "import numba, pinocchio": "import numba, pinocchio",
    'psp3.load("psp3")': LOADED.format("psp3"),
    'psp3.load("gough_stewart") and its inverse dynamics': ASKED.format("gough_stewart"),
}
COMMANDS = (
    "--help",
    "info",
    "pose --heights 0.05,0,-0.02",
    "simulate",
    "simulate --controller it2",
    "view delta --record page.html",
)


def cpu_seconds(command: Sequence[str | Path], cache: Path, folder: Path) -> float:
    """Return the processor time of a command with a cache folder [s]."""
    environ = {**os.environ, "XDG_CACHE_HOME": str(cache)}
    # An installed package keeps its byte code.
    environ.pop("PYTHONDONTWRITEBYTECODE", None)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, cwd=folder, env=environ, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def first_and_again(command: Sequence[str | Path]) -> tuple[float, float]:
    """Return the processor times of a command that finds nothing compiled, and of the next ones."""
    with tempfile.TemporaryDirectory() as name:
        folder, cache = Path(name), Path(name, "cache")
        cache.mkdir()
        first = cpu_seconds(command, cache, folder)
        return first, min(cpu_seconds(command, cache, folder) for _ in range(AGAIN))


def clone_and_view() -> Mapping[str, float]:
    """Return the processor times from a clone to a recorded motion, and on to the main job [s].

    The page is recorded instead of served, because a server has no end.
    """
    with tempfile.TemporaryDirectory() as name:
        folder, cache, clone = Path(name), Path(name, "cache"), Path(name, "clone")
        cache.mkdir()
        subprocess.run(["git", "clone", "--quiet", ROOT, clone], check=True)
        installed = cpu_seconds(["make", ".venv/.run"], cache, clone)
        psp3 = clone / ".venv" / "bin" / "psp3"
        shown = cpu_seconds([psp3, "view", "--record", "page.html"], cache, folder)
        reproduced = cpu_seconds(["make", "reproduce"], cache, clone)
        return {"make view": installed + shown, "make reproduce": reproduced}


def main() -> None:
    """Print the times and keep them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "results" / "bench_first_use.json")
    parser.add_argument("--clone", action="store_true", help="clone, install and show, too")
    arguments = parser.parse_args()
    command = Path(sys.executable).with_name("psp3")
    everything: dict[str, list[str | Path]] = {
        **{name: [sys.executable, "-c", program] for name, program in PROGRAMS.items()},
        **{f"psp3 {words}": [command, *words.split()] for words in COMMANDS},
    }
    print(f"{'processor time [s]':56s}{'first':>9s}{'again':>9s}")
    times = {}
    for name, one in everything.items():
        times[name] = first_and_again(one)
        print(f"{name:56s}{times[name][0]:9.2f}{times[name][1]:9.2f}", flush=True)
    results = {"versions": environment("pin", "numba", "numpy"), "seconds": times}
    if arguments.clone:
        results["clone"] = clone_and_view()
        for name, seconds in results["clone"].items():
            print(f"{name:56s}{seconds:9.1f}")
    write_results(arguments.out, results)


if __name__ == "__main__":
    main()
