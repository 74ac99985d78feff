"""Common functions of the benchmarks.

They are medians of interleaved samples, the time of an empty compiled call, and files of results.

Every function has many short runs, interleaved with those of the others, so a slow spell of the
machine affects all alike. Ratios are valid within one run; absolute times depend on the machine. An
empty compiled call shows the overhead of a call.
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
# [us] time of an empty compiled call up to which the bars hold unchanged
REFERENCE_EMPTY_CALL = 0.8


@compiled
def _empty(x: Any, y: Any) -> int:
    return -1


def empty_call() -> Callable[[], object]:
    """Return a call of a compiled function that takes two small arrays and does nothing."""
    x, y = np.zeros(3), np.zeros(3)
    return lambda: _empty(x, y)


def measure(functions: Mapping[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    """Return the calling thread's median CPU time of one call [µs], by name."""
    samples: dict[str, list[float]] = {name: [] for name in functions}
    loops = {}
    for name, function in functions.items():
        function()
        start = time.thread_time()
        for _ in range(5):
            function()
        # About two milliseconds per sample: long compared with the clock's resolution and cold
        # caches, and short compared with disturbances.
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

    On such a machine even an empty compiled call is slower than expected.
    """
    return max(1.0, medians[EMPTY_CALL] / REFERENCE_EMPTY_CALL)


def bar_and_verdict(value: float, bar: float | None, at_least: bool = False) -> str:
    """Return the cell that shows a bar and whether the value meets it.

    It is empty without a bar.
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
    """Write results as JSON, and make their directory."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(results, indent=2) + "\n", encoding="utf-8")
