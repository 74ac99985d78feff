"""Write ``docs/benchmarks.md`` from what ``make bench`` left in ``results/``.

Run by ``python docs/make_benchmarks.py [directory]``.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
NAMES = ("robot", "controller", "fuzzy", "general", "first_use")
EMPTY = "empty compiled call"

HEAD = """# Benchmarks

*Written by `docs/make_benchmarks.py` from the results of `make bench` of {date}; do not edit. \
Versions: {versions}.*

Times depend on the machine and on what else runs on it. The functions of a table were timed in \
turn, in many short samples, and the tables give
the medians. So a slow machine slows all functions of a table alike. Compare times within a \
table, not with those of another machine. "Empty
compiled call" is the cost of any compiled call from Python, before anything is computed. To \
measure on your own machine, run

```sh
make bench && python docs/make_benchmarks.py
```
"""

ROBOT = """## The robot

Each row is one call from Python at one state. "Tree only" means that Pinocchio or MuJoCo \
computes the same tree without closing the loops. The
rows "Pinocchio path" and "NOC" (natural orthogonal complement) are our other two implementations \
of the equation of motion. They are for
comparison and not for speed: they close the loops by iteration from home, in NumPy.

{table}

A simulation of 10 s at 2 ms with Runge–Kutta steps takes {simulations}.

The next table gives the time of inverse dynamics for each state of a batch. "State by state" \
uses the kernel of single calls. "Many states" uses
a kernel that computes several states in one instruction, on one core, or on all {cores} where \
that is faster. CPU time is the sum over all
threads.

{batches}
"""

CONTROLLER = """## One control step

Each row is one call of `torque` from Python, at one state on the helix. The last column is the \
share of the control period of 2 ms. CTC is
computed torque; t1, it2 and gt2 are fuzzy computed torque of type 1, interval type 2 and general \
type 2.

{table}

The thesis measured 255 ms for a step of computed torque with the exact model, and learned a model \
for this reason.

Whole runs of 10 s in a study, learning included, on one core: {runs}.
"""

FUZZY = """## Type-2 inference

The system has 4 inputs with 2 Gaussian terms each, 16 rules, 21 outputs, and center of sets. If \
other libraries are installed, they solve the
same system, with equal outputs.

{table}

How the time of one call of the interval type-2 system grows:

{growth}

Time of an exact centroid of an interval type-2 set on a grid, by the number of points:

{centroids}

A batch takes {bytes} bytes of memory for each item beyond its inputs. `import fuzzy2` adds \
{seconds} to `import numpy`, because nothing is
imported before it is used. The import together with a first centroid adds {first}.
"""


GENERAL = """## Robots with loops in general

The table gives the CPU time of one call from Python near the reference pose. Positions move by \
0.2 mm or mrad from call to call. The 3-PSP is
computed without its closed form. Our functions close the loops to rounding error in every call, \
starting from the reference pose or from the
pose of the call before. MuJoCo has loops as soft constraints, exported as on the page \
[engines](engines.md). Drake, if it is installed, takes
one step of 2 ms with its loops in the contact solver. Pinocchio's `constraintDynamics` gets a \
pose that is already closed.

{robots}

As a geometric mean over the robots, `inverse_dynamics` takes {inverse} × and `forward_dynamics` \
{forward} × the time of `mj_forward` (from the
pose before).

The next table is for chains of five-bars, each mounted on the tip of the one before:

{chains}

![Cost of a call against the number of loops, by our core, MuJoCo and Pinocchio, on logarithmic \
axes](pictures/cost_of_loops.svg)

From 1 to 50 loops the time grows with their number to the power of {growth}.
"""

FIRST_USE = """## First use

The table gives the processor time of whole programs and commands, measured on {date}. "First" is \
with an empty cache folder, where functions are
compiled once; "again" is the least of three more.

{times}

{clone}"""

CLONE = """From a new clone, `make view` takes {view} s of processor time until a machine moves, \
and a download of 1 GiB. After that, `make reproduce`
takes {reproduce} s, of which most is for compiling everything once."""


def digits(value: float) -> str:
    """Return a number with two significant digits, and without exponent."""
    return f"{value:.2g}" if value < 100.0 else f"{round(value, 2 - len(str(int(value)))):.0f}"


def table(medians: Mapping[str, float], base: str, *columns: tuple[str, float]) -> str:
    """Return a table of times and of their ratios to that of ``base``.

    Further columns (heading, divisor) are percentages.
    """
    heads = ["", "µs", f"× {base}", *(heading for heading, _ in columns)]
    lines = ["| " + " | ".join(heads) + " |", "|---" * len(heads) + "|"]
    for name, value in medians.items():
        cells = [
            name,
            digits(value),
            digits(value / medians[base]),
            *(f"{digits(100.0 * value / divisor)} %" for _, divisor in columns),
        ]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def grid(rows: Mapping[str, Mapping[str, float]]) -> str:
    """Return a table of times with one line for each entry; all have the same keys."""
    keys = list(next(iter(rows.values())))
    lines = ["| | " + " | ".join(keys) + " |", "|---" * (len(keys) + 1) + "|"]
    lines += [
        f"| {name} [µs] | " + " | ".join(digits(value) for value in row.values()) + " |"
        for name, row in rows.items()
    ]
    return "\n".join(lines)


def columns(measured: Mapping[str, Mapping[str, float]]) -> str:
    """Return a table of times: a column for each entry and a line for each name that occurs."""
    names = list(dict.fromkeys(name for medians in measured.values() for name in medians))
    lines = ["| [µs] | " + " | ".join(measured) + " |", "|---" * (len(measured) + 1) + "|"]
    lines += [
        f"| {name} | "
        + " | ".join(digits(of[name]) if name in of else "" for of in measured.values())
        + " |"
        for name in names
    ]
    return "\n".join(lines)


def batch_table(batches: Mapping[str, Mapping[str, Mapping[str, float]]]) -> str:
    """Return the table of batches: wall and CPU time, by number of states and how it is done."""
    lines = ["| | wall [µs] | CPU [µs] |", "|---|---|---|"]
    lines += [
        f"| {int(rows):,} states, {way} | {digits(times['wall'])} | {digits(times['cpu'])} |"
        for rows, ways in batches.items()
        for way, times in ways.items()
    ]
    return "\n".join(lines)


def first_use(measured: Mapping[str, Any], date: str) -> str:
    """Return the section about first use; what needs a clone is there if it was measured."""
    lines = ["| [s] | first | again |", "|---|---|---|"]
    lines += [
        f"| `{name}` | {digits(first)} | {digits(again)} |"
        for name, (first, again) in measured["seconds"].items()
    ]
    clone = measured.get("clone")
    whole = {name.removeprefix("make "): f"{time:.0f}" for name, time in (clone or {}).items()}
    said = CLONE.format(**whole) if clone else ""
    return FIRST_USE.format(date=date, times="\n".join(lines), clone=said).rstrip() + "\n"


def page(results: Mapping[str, Any], date: str) -> str:
    """Return the page for the results of the benchmarks."""
    robot, controller, fuzzy, general, first = (results[name] for name in NAMES)
    versions = {
        name: version for result in results.values() for name, version in result["versions"].items()
    }
    added = fuzzy["import_seconds"]["numpy, fuzzy2"] - fuzzy["import_seconds"]["numpy"]
    called = fuzzy["import_seconds"]["numpy, fuzzy2, first call"] - fuzzy["import_seconds"]["numpy"]
    simulations = " and ".join(
        f"{digits(seconds)} s under {name}" for name, seconds in robot["simulation_seconds"].items()
    )
    runs = ", ".join(
        f"{name} {digits(1e3 * seconds)} ms" for name, seconds in controller["run_seconds"].items()
    )
    return "\n".join(
        [
            HEAD.format(
                date=date,
                versions=", ".join(f"{name} {version}" for name, version in versions.items()),
            ),
            ROBOT.format(
                table=table(robot["microseconds"], "equation_of_motion"),
                simulations=simulations,
                batches=batch_table(robot["batches"]),
                cores=robot["cores"],
            ),
            CONTROLLER.format(
                table=table(controller["microseconds"], "PD", ("of 2 ms", 2000.0)), runs=runs
            ),
            FUZZY.format(
                table=table(fuzzy["microseconds"], "fuzzy2, interval type-2"),
                growth="\n\n".join(
                    grid({f"by {name}": row}) for name, row in fuzzy["growth"]["systems"].items()
                ),
                centroids=grid(fuzzy["growth"]["centroid"]),
                bytes=digits(list(fuzzy["batch_bytes_an_item"].values())[-1]),
                # Less than this is the scatter of starting an interpreter, and may be negative.
                seconds=f"{digits(added)} s" if added >= 0.01 else "less than 0.01 s",
                first=f"{digits(called)} s",
            ),
            GENERAL.format(
                robots=columns(general["robots"]),
                chains=columns(
                    {
                        f"{count} loop{'s' * (int(count) > 1)}": times
                        for count, times in general["chains"].items()
                    }
                ),
                inverse=f"{general['means']['inverse_dynamics, from the pose before']:.2f}",
                forward=f"{general['means']['forward_dynamics, from the pose before']:.2f}",
                growth=", ".join(
                    f"{power:.2f} ({name})" for name, power in general["growth"].items()
                ),
            ),
            first_use(first, date),
        ]
    )


def main() -> None:
    """Write the page; the directory of the results may be given."""
    directory = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE.parent / "results"
    files = [directory / f"bench_{name}.json" for name in NAMES]
    missing = [str(file) for file in files if not file.is_file()]
    if missing:
        sys.exit(f"no results of make bench: {', '.join(missing)}")
    results = {
        name: json.loads(file.read_text(encoding="utf-8"))
        for name, file in zip(NAMES, files, strict=True)
    }
    date = (
        datetime.fromtimestamp(max(file.stat().st_mtime for file in files), UTC).date().isoformat()
    )
    (HERE / "benchmarks.md").write_text(page(results, date), encoding="utf-8")
    draw_cost_of_loops(results["general"]["chains"])


def draw_cost_of_loops(chains: Mapping[str, Mapping[str, float]]) -> None:
    """Draw how the cost of a call grows with the number of loops."""
    from matplotlib.figure import Figure

    from fuzzy2.plots.style import style

    counts = [int(count) for count in chains]
    with style("light"):
        figure = Figure(figsize=(6.0, 4.0), layout="constrained")
        axes = figure.add_subplot()
        for marker, name in zip("os^Dv", next(iter(chains.values())), strict=False):
            times = [medians[name] for medians in chains.values()]
            axes.loglog(counts, times, marker=marker, label=name)
        axes.set(
            title="Five-bars in a chain",
            xlabel="number of loops",
            ylabel="CPU time of a call [µs]",
        )
        axes.legend()
        figure.savefig(HERE / "pictures" / "cost_of_loops.svg", metadata={"Date": None})


if __name__ == "__main__":
    main()
