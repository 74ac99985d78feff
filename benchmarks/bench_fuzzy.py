"""Compare fuzzy2 with the installed fuzzy libraries, and measure how its cost grows.

Run by ``make bench``.

The system is that of the thesis's estimators: 4 inputs with 2 Gaussian terms of uncertain mean
each, 16 rules, 21 outputs, center of sets. ``timing.py`` explains how calls are timed.

The other libraries are not dependencies. ``ferrifuzz`` and ``pyit2fls`` take part if they can be
imported, and the output says whether they solve the same problem. Ferrifuzz has no Gaussian of
uncertain mean, but any pair of Gaussians, so uncertain standard deviation replaces it, at the same
cost. PyIT2FLS takes part twice. Its center of sets computes the centroids of the consequents in
every call, while fuzzy2 does this once, when the system is made. Its TSK system with constant
consequents has no centroids.
"""

from __future__ import annotations

import argparse
import itertools
import math
import statistics
import subprocess
import sys
import time
import tracemalloc
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from timing import (
    EMPTY_CALL,
    bar_and_verdict,
    bar_scale,
    empty_call,
    environment,
    measure,
    write_results,
)

from fuzzy2.errors import ApproximationWarning
from fuzzy2.reduction.interval import METHODS, centroid
from fuzzy2.reduction.kernels import EIASC, end_of_interval
from fuzzy2.sets.gaussian_type2 import GaussianType2Set
from fuzzy2.sets.interval_type2 import GaussianUncertainMean, GaussianUncertainSigma
from fuzzy2.sets.shapes import Gaussian
from fuzzy2.systems import GeneralType2System, IntervalType2System, Type1System

Peer: TypeAlias = tuple[Callable[[], object], NDArray[np.float64], NDArray[np.float64]]
"""A call, its return value, and that of fuzzy2 for the same system."""

INPUTS, OUTPUTS, BATCH = 4, 21, 10_000
X = np.array([0.31, -0.22, 0.47, 0.05])

CALL, BATCH_ITEM = "fuzzy2, interval type-2", "fuzzy2, interval type-2, batch, an item"
COROLLARY, PLANES = "fuzzy2, general type-2, corollary", "fuzzy2, general type-2, 5 α-planes"
TYPE1_ITEM, TYPE1_SHARE = "fuzzy2, type-1, batch, an item", 0.65
CENTROID, ITS_KERNEL, KERNELS = "centroid of 100 points", "its kernel alone", 3.0
FERRIFUZZ, PYIT2FLS, PYIT2FLS_TSK = (
    "ferrifuzz",
    "PyIT2FLS, center of sets",
    "PyIT2FLS, TSK with constants",
)
BARS = {CALL: 4.0, BATCH_ITEM: 1.6, COROLLARY: 20.0, PLANES: 50.0}  # [us]
LEAST_RATIOS = {FERRIFUZZ: 8.0, PYIT2FLS: 500.0, PYIT2FLS_TSK: 500.0}
SECONDS_OVER_NUMPY = 0.1


def rule_base(
    terms: int = 2, outputs: int = OUTPUTS
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return all rules over four inputs, and random consequents."""
    rules = np.array(list(itertools.product(range(terms), repeat=INPUTS)))
    return rules, np.random.default_rng(0).normal(size=(len(rules), outputs))


def interval_system(
    terms: int = 2, outputs: int = OUTPUTS, method: str = "eiasc"
) -> IntervalType2System:
    """Return an interval type-2 system with that many terms per input."""
    middles = np.linspace(-1.0, 1.0, terms)
    sigma = 1.2 / terms
    sets = [
        GaussianUncertainMean(mean=(m - 0.15 * sigma, m + 0.15 * sigma), sigma=sigma)
        for m in middles.tolist()
    ]
    return IntervalType2System([sets] * INPUTS, *rule_base(terms, outputs), method=method)


def contenders() -> dict[str, Callable[[], object]]:
    """Return functions to time, by name, all with the same input."""
    system = interval_system()
    rules, consequents = rule_base()
    type1 = Type1System([[Gaussian(-1.0, 0.6), Gaussian(1.0, 0.6)]] * INPUTS, rules, consequents)
    gaussian = [
        [GaussianType2Set(principal=Gaussian(m, 0.6), sigma=0.02) for m in (-1.0, 1.0)]
    ] * INPUTS
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ApproximationWarning)
        corollary = GeneralType2System(gaussian, rules, consequents, reduction="gaussian")
    planes = GeneralType2System(gaussian, rules, consequents, levels=5)
    batch = np.random.default_rng(1).uniform(-1.0, 1.0, size=(BATCH, INPUTS))
    functions: dict[str, Callable[[], object]] = {
        EMPTY_CALL: empty_call(),
        CALL: lambda: system(X),
        "fuzzy2, interval type-2, both ends": lambda: system.type_reduced(X),
        "fuzzy2, type-1": lambda: type1(X),
        BATCH_ITEM: lambda: system(batch),
        TYPE1_ITEM: lambda: type1(batch),
        COROLLARY: lambda: corollary(X),
        PLANES: lambda: planes(X),
    }
    peers: dict[str, Callable[[], Peer]] = {
        FERRIFUZZ: ferrifuzz,
        PYIT2FLS: pyit2fls,
        PYIT2FLS_TSK: pyit2fls_tsk,
    }
    for name, peer in peers.items():
        try:
            functions[name], outputs, expected = peer()
        except ImportError as error:
            print(f"{name} takes no part: {error}")
            continue
        print(
            f"{name} differs from fuzzy2 by {np.abs(outputs - expected).max():.1e} at most; the "
            f"outputs go to {np.abs(expected).max():.2f}"
        )
    return functions


def same_system(consequents: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return fuzzy2's outputs for the system of the other libraries.

    Its terms have uncertain standard deviations.
    """
    sets = [GaussianUncertainSigma(mean=m, sigma=(0.5, 0.7)) for m in (-1.0, 1.0)]
    return IntervalType2System([sets] * INPUTS, rule_base()[0], consequents)(X)


def ferrifuzz() -> Peer:
    """Return the call of the system in ferrifuzz, its outputs, and those of fuzzy2."""
    import ferrifuzz as peer

    system = peer.FuzzySystem(and_method="product", type_reduction="cos")
    for i in range(INPUTS):
        variable = peer.Variable(f"x{i}", -10.0, 10.0)
        for t, mean in enumerate((-1.0, 1.0)):
            variable[f"t{t}"] = peer.mf.it2(
                peer.mf.gaussian(mean, 0.7), peer.mf.gaussian(mean, 0.5)
            )
        system.add_input(variable)
    rules, consequents = rule_base()
    for j in range(OUTPUTS):
        variable = peer.Variable(f"y{j}", -10.0, 10.0)
        for r, value in enumerate(consequents[:, j].tolist()):
            variable[f"r{r}"] = peer.mf.singleton(value)
        system.add_output(variable)
    for r, rule in enumerate(rules.tolist()):
        antecedents = " AND ".join(f"x{i} IS t{t}" for i, t in enumerate(rule))
        system.add_rule(
            f"IF {antecedents} THEN " + " AND ".join(f"y{j} IS r{r}" for j in range(OUTPUTS))
        )
    values = X.tolist()
    outputs = dict(zip(system.output_names(), system.evaluate(values), strict=True))
    return (
        lambda: system.evaluate(values),
        np.array([outputs[f"y{j}"] for j in range(OUTPUTS)]),
        same_system(consequents),
    )


def pyit2fls() -> Peer:
    """Return the call of the system in PyIT2FLS, its outputs, and those of fuzzy2.

    Its consequents are sets.
    """
    import pyit2fls as peer

    universe = np.linspace(-10.0, 10.0, 100)
    system = peer.IT2Mamdani(
        peer.product_t_norm, peer.max_s_norm, method="CoSet", algorithm="EIASC"
    )

    def conclude(value: float) -> object:
        return peer.IT2FS_Gaussian_UncertStd(universe, [value, 0.6, 0.2, 1.0])

    call = _filled(system, universe, conclude)
    outputs = [sum(interval) / 2.0 for interval in call().values()]
    # The centroids are the same: of the same sets, sampled at the same points.
    sets = [
        [GaussianUncertainSigma(mean=value, sigma=(0.5, 0.7)) for value in row]
        for row in rule_base()[1].tolist()
    ]
    centroids = np.array(
        [
            [centroid(universe, one.lower(universe), one.upper(universe)) for one in row]
            for row in sets
        ]
    )
    return call, np.array(outputs), same_system(centroids)


def pyit2fls_tsk() -> Peer:
    """Return the call of the system in PyIT2FLS, its outputs, and those of fuzzy2.

    Its consequents are numbers.
    """
    import pyit2fls as peer

    system = peer.IT2TSK(peer.product_t_norm, peer.max_s_norm)
    no_slope = {f"x{i}": 0.0 for i in range(INPUTS)}
    call = _filled(
        system, np.linspace(-10.0, 10.0, 100), lambda value: {"const": value, **no_slope}
    )
    return call, np.array(list(call().values())), same_system(rule_base()[1])


def _filled(
    system: Any, universe: NDArray[np.float64], conclude: Callable[[float], object]
) -> Callable[[], dict[str, Any]]:
    """Give a system of PyIT2FLS its inputs, outputs and rules, and return its call."""
    import pyit2fls as peer

    terms = [peer.IT2FS_Gaussian_UncertStd(universe, [mean, 0.6, 0.2, 1.0]) for mean in (-1.0, 1.0)]
    for i in range(INPUTS):
        system.add_input_variable(f"x{i}")
    for j in range(OUTPUTS):
        system.add_output_variable(f"y{j}")
    rules, consequents = rule_base()
    for rule, values in zip(rules.tolist(), consequents.tolist(), strict=True):
        system.add_rule(
            [(f"x{i}", terms[t]) for i, t in enumerate(rule)],
            [(f"y{j}", conclude(value)) for j, value in enumerate(values)],
        )
    point = {f"x{i}": value for i, value in enumerate(X.tolist())}
    return lambda: system.evaluate(point)


def print_calls(medians: dict[str, float]) -> None:
    """Print the table of single calls."""
    scale, base = bar_scale(medians), medians[CALL]
    print(f"\n{'one call from Python':44s}{'µs':>10s}{'× fuzzy2':>10s}{'bar [µs]':>11s}")
    for name, median in medians.items():
        bar = BARS[name] * scale if name in BARS else None
        print(f"{name:44s}{median:10.2f}{median / base:10.2f}{bar_and_verdict(median, bar)}")
    for name, least in LEAST_RATIOS.items():
        if name in medians:
            ratio = medians[name] / base
            print(
                f"fuzzy2 is {ratio:.1f} times as fast as {name};{'':3s}bar: "
                f"{bar_and_verdict(ratio, least, at_least=True).strip()}"
            )


def growth_of_systems(rounds: int) -> dict[str, dict[str, float]]:
    """Return microseconds of one call by the number of rules and by the number of outputs."""
    systems = {f"rules {terms**INPUTS}": interval_system(terms) for terms in (2, 3, 4, 6, 8)}
    systems |= {
        f"outputs {outputs}": interval_system(outputs=outputs) for outputs in (1, 3, 10, 30, 100)
    }
    functions: dict[str, Callable[[], object]] = {
        name: lambda s=system: s(X) for name, system in systems.items()
    }  # type: ignore[misc]
    medians = measure(functions, rounds)
    tables: dict[str, dict[str, float]] = {"rules": {}, "outputs": {}}
    for name, median in medians.items():
        what, count = name.split()
        tables[what][count] = median
    return tables


def growth_of_centroids(rounds: int) -> dict[str, dict[str, float]]:
    """Return microseconds of one exact centroid, by method and number of grid points."""
    fuzzy_set = GaussianUncertainMean(mean=(4.0, 6.0), sigma=1.5)
    functions: dict[str, Callable[[], object]] = {}
    for method in METHODS:
        for count in (100, 1000, 10_000, 100_000):
            x = np.linspace(0.0, 10.0, count)
            low, high = fuzzy_set.lower(x), fuzzy_set.upper(x)
            functions[f"{method} {count}"] = lambda x=x, low=low, high=high, m=method: centroid(
                x, low, high, m
            )  # type: ignore[misc]
    tables: dict[str, dict[str, float]] = {method: {} for method in METHODS}
    for name, median in measure(functions, rounds).items():
        method, number = name.split()
        tables[method][number] = median
    return tables


def centroid_and_kernel(rounds: int) -> dict[str, float]:
    """Return microseconds of one exact centroid of 100 points, and of its search alone."""
    fuzzy_set, x = GaussianUncertainMean(mean=(4.0, 6.0), sigma=1.5), np.linspace(0.0, 10.0, 100)
    low, high = fuzzy_set.lower(x), fuzzy_set.upper(x)
    below, above = np.empty(100), np.empty(100)
    functions: dict[str, Callable[[], object]] = {
        CENTROID: lambda: centroid(x, low, high),
        ITS_KERNEL: lambda: (
            end_of_interval(x, high, low, True, EIASC, below, above),
            end_of_interval(x, low, high, False, EIASC, below, above),
        ),
    }
    return measure(functions, rounds)


def print_centroid(medians: dict[str, float], calls: dict[str, float]) -> None:
    """Print a centroid's time relative to its kernel, and type-1 relative to type-2."""
    for what, ratio, bar in (
        (f"{CENTROID}, in times of {ITS_KERNEL}", medians[CENTROID] / medians[ITS_KERNEL], KERNELS),
        ("a batch of type-1 / interval type-2", calls[TYPE1_ITEM] / calls[BATCH_ITEM], TYPE1_SHARE),
    ):
        print(f"{what:54s}{ratio:10.2f}{bar_and_verdict(ratio, bar)}")


def print_growth(title: str, tables: dict[str, dict[str, float]]) -> None:
    """Print rows of times with the growth exponent of each.

    An exponent of 1 is linear; N log N from 100 to 100 000 gives 1.13.
    """
    for name, times in tables.items():
        counts = [int(count) for count in times]
        values = list(times.values())
        exponent = math.log(values[-1] / values[0]) / math.log(counts[-1] / counts[0])
        header = "".join(f"{count:>10d}" for count in counts)
        print(f"\n{f'{title} {name}':44s}{header}{'exponent':>10s}")
        print(f"{'[µs]':44s}" + "".join(f"{value:10.2f}" for value in values) + f"{exponent:10.2f}")


def batch_memory() -> dict[str, float]:
    """Return the peak memory of a batch in addition to its inputs.

    It is in bytes per item, by the size of the batch.
    """
    system = interval_system()
    peaks = {}
    for count in (1000, 10_000, 100_000):
        batch = np.random.default_rng(1).uniform(-1.0, 1.0, size=(count, INPUTS))
        tracemalloc.start()
        system(batch)
        peaks[str(count)] = tracemalloc.get_traced_memory()[1] / count
        tracemalloc.stop()
    return peaks


def import_seconds(rounds: int) -> dict[str, float]:
    """Return median wall times of fresh interpreters.

    They import NumPy alone, NumPy and fuzzy2 (whose names are imported at first use), or both with
    a first call.
    """
    first_call = "fuzzy2.GaussianUncertainMean(mean=(4.0, 6.0), sigma=1.5).centroid()"
    programs = {
        "numpy": "import numpy",
        "numpy, fuzzy2": "import numpy, fuzzy2",
        "numpy, fuzzy2, first call": f"import numpy, fuzzy2; {first_call}",
    }
    samples: dict[str, list[float]] = {name: [] for name in programs}
    for _ in range(rounds):
        for name, program in programs.items():
            start = time.perf_counter()
            subprocess.run([sys.executable, "-c", program], check=True)
            samples[name].append(time.perf_counter() - start)
    return {name: statistics.median(values) for name, values in samples.items()}


def main() -> None:
    """Print the tables and write ``results/bench_fuzzy.json``."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=100, help="samples per row")
    parser.add_argument(
        "--out", type=Path, default=Path("results/bench_fuzzy.json"), help="where the numbers go"
    )
    arguments = parser.parse_args()
    versions = environment("numpy", "numba")
    print(f"medians of {arguments.rounds} samples ({', '.join(map(' '.join, versions.items()))})")
    medians = measure(contenders(), arguments.rounds)
    for name in (BATCH_ITEM, TYPE1_ITEM):
        medians[name] /= BATCH
    print_calls(medians)
    one_centroid = centroid_and_kernel(arguments.rounds)
    print_centroid(one_centroid, medians)
    systems = growth_of_systems(arguments.rounds)
    print_growth("one call, by", systems)
    centroids = growth_of_centroids(max(5, arguments.rounds // 5))
    print_growth("centroid, by points,", centroids)
    memory = batch_memory()
    print(
        f"\n{'peak memory of a batch, bytes an item':44s}"
        + ", ".join(f"{peak:.0f} of {count}" for count, peak in memory.items())
    )
    imports = import_seconds(max(5, arguments.rounds // 10))
    over = imports["numpy, fuzzy2"] - imports["numpy"]
    print(
        f"{'import fuzzy2, over import numpy':44s}{over:10.3f} "
        f"s{bar_and_verdict(over, SECONDS_OVER_NUMPY)}"
    )
    first = imports["numpy, fuzzy2, first call"] - imports["numpy"]
    print(f"{'import fuzzy2 and a first centroid':44s}{first:10.3f} s")
    results = {
        "versions": versions,
        "microseconds": medians,
        "centroid": one_centroid,
        "growth": {"systems": systems, "centroid": centroids},
        "batch_bytes_an_item": memory,
        "import_seconds": imports,
    }
    write_results(arguments.out, results)


if __name__ == "__main__":
    main()
