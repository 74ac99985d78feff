"""What the benchmarks share.

Medians of interleaved samples, what an empty compiled call costs, results on disk.

Many short runs of every function, one after another, so that a slow spell of the machine hits all
alike. Ratios compare within one run; absolute times depend on the machine. An empty compiled call
shows what a call costs before anything is computed.
"""

from __future__ import annotations

import json
import platform
import statistics
import time
from collections.abc import Callable, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from fuzzy2.support.compiled import compiled

EMPTY_CALL = "empty compiled call"
# [us] what an empty compiled call may cost for the bars to hold as they are
REFERENCE_EMPTY_CALL = 0.8


@compiled
def _empty(x: Any, y: Any) -> int:
    return -1


def empty_call() -> Callable[[], object]:
    """Return a call of a compiled function of two small arrays that does nothing."""
    x, y = np.zeros(3), np.zeros(3)
    return lambda: _empty(x, y)


def measure(functions: Mapping[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    """Return the median CPU time of one call in microseconds, by name, of the calling thread."""
    samples: dict[str, list[float]] = {name: [] for name in functions}
    loops = {}
    for name, function in functions.items():
        function()
        start = time.thread_time()
        for _ in range(5):
            function()
        # About two milliseconds a sample: long against the clock and cold caches, short against
        # what disturbs.
        loops[name] = max(1, round(2e-3 / ((time.thread_time() - start) / 5 + 1e-9)))
    for _ in range(rounds):
        for name, function in functions.items():
            count = range(loops[name])
            start = time.thread_time()
            for _ in count:
                function()
            samples[name].append((time.thread_time() - start) / len(count) * 1e6)
    return {name: statistics.median(values) for name, values in samples.items()}


def bar_scale(medians: Mapping[str, float]) -> float:
    """Return the factor by which bars are raised on a slow machine.

    There even an empty compiled call is slower than it should be.
    """
    return max(1.0, medians[EMPTY_CALL] / REFERENCE_EMPTY_CALL)


def bar_and_verdict(value: float, bar: float | None, at_least: bool = False) -> str:
    """Return the column of a table that shows a bar and whether the value meets it.

    Both are there if there is a bar.
    """
    if bar is None:
        return f"{'':>11s}"
    met = value >= bar if at_least else value <= bar
    return f"{bar:11.1f}{' met' if met else ' MISSED'}"


def environment(*packages: str) -> dict[str, str]:
    """Return the versions of Python and of packages."""
    return {
        "Python": platform.python_version(),
        **{package: version(package) for package in packages},
    }


def write_results(path: Path, results: Mapping[str, Any]) -> None:
    """Write results as JSON, with the directory they go to."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(results, indent=2) + "\n", encoding="utf-8")
