"""Good arguments of what psp3 offers beside robots: controllers, studies, benchmark and figures.

See tests.misuse.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import psp3
from psp3 import benchmark, plots, study, trajectories, visualize
from psp3.study import statistics
from tests.misuse import Call, parameters_of

ANYTHING = ("*",)
NONE = ("None",)
A_TEXT = ("text",)
STATE = {"t": 0.1, "heights": np.array([0.11, 0.1, 0.09]), "speeds": np.array([0.1, -0.1, 0.0])}


@functools.cache
def robot() -> Any:
    return psp3.load("psp3")


@functools.cache
def path() -> Any:
    return (
        trajectories.Sway(robot=robot())
        if False
        else trajectories.Hold((0.0, 0.0, 0.1), robot=robot())
    )


@functools.cache
def learned() -> Any:
    return psp3.FuzzyComputedTorque("it2", robot()).fit(
        trajectories.Helix(robot=robot()), duration=2.0, samples=200
    )


@functools.cache
def result() -> Any:
    return psp3.simulate(robot(), psp3.PD(), path(), 0.1)


def torque_of(make: Any) -> Any:
    """Return a function that makes a controller, and asks it for one torque."""

    def made(**given: Any) -> Any:
        controller = make(**given)
        controller.reset()
        return controller.torque(0.0, STATE["heights"], STATE["speeds"], path()(0.0))

    return made


def of_controllers() -> Iterator[tuple[str, Call]]:
    """Yield how controllers are made."""
    model = robot()
    gains = {"kp": 100.0, "kv": 10.0}
    yield "PD", Call(torque_of(psp3.PD), {**gains, "model": model}, {"model": NONE})
    yield "PID", Call(torque_of(psp3.PID), {**gains, "ki": 5.0, "model": model}, {"model": NONE})
    yield (
        "GravityCompensatedPD",
        Call(torque_of(psp3.GravityCompensatedPD), {"model": model, **gains}),
    )
    yield "ComputedTorque", Call(torque_of(psp3.ComputedTorque), {"model": model, **gains})
    yield (
        "ComputedTorque.critically_damped",
        Call(torque_of(psp3.ComputedTorque.critically_damped), {"model": model, "kp": 10.0}),
    )
    yield "FeedForward", Call(torque_of(psp3.FeedForward), {"model": model})
    Q, R = np.eye(6), 1e-3 * np.eye(3)
    yield (
        "LinearQuadraticRegulator",
        Call(
            torque_of(psp3.LinearQuadraticRegulator),
            {"robot": model, "Q": Q, "R": R, "period": 0.002, "positions": None},
            {"positions": NONE},
        ),
    )
    yield (
        "TimeVaryingLinearQuadraticRegulator",
        Call(
            torque_of(psp3.TimeVaryingLinearQuadraticRegulator),
            {
                "robot": model,
                "trajectory": path(),
                "duration": 0.01,
                "Q": Q,
                "R": R,
                "period": 0.002,
                "terminal": None,
            },
            {"terminal": NONE},
        ),
    )
    yield (
        "TaskSpaceComputedTorque",
        Call(
            torque_of(psp3.TaskSpaceComputedTorque),
            {
                "robot": model,
                "kp": 10.0,
                "kv": 1.0,
                "path": None,
                "frame": "tip",
                "task": ("x", "y", "z"),
                "damped_below": 0.15,
            },
            {"path": NONE},
        ),
    )
    options = {
        "kind": "t1",
        "robot": model,
        "kp": 10.0,
        "kv": 1.0,
        "n_terms": 2,
        "rules": None,
        "learner": None,
        "coriolis": "rules",
        "snr_db": math.inf,
        "mean_variation": None,
        "levels": 5,
        "reduction": "alpha_planes",
        "outside": "clamp",
        "term_width": 1.0,
        "defuzzify": "first",
    }
    yield (
        "FuzzyComputedTorque",
        Call(
            psp3.FuzzyComputedTorque,
            options,
            dict.fromkeys(("robot", "rules", "learner", "n_terms", "mean_variation"), NONE),
            reads=lambda made: None,
        ),
    )
    controller = learned()
    named = {"heights": STATE["heights"], "speeds": STATE["speeds"]}
    yield "FuzzyComputedTorque.estimate", Call(controller.estimate, named)
    yield "FuzzyComputedTorque.estimated_numbers", Call(controller.estimated_numbers, named)
    yield (
        "FuzzyComputedTorque.torque_number",
        Call(controller.torque_number, {**named, "desired": path()(0.0)}),
    )
    yield (
        "FuzzyComputedTorque.with_systems",
        Call(controller.with_systems, {"systems": controller.systems}, reads=lambda made: None),
    )

    def fit(**given: Any) -> Any:
        return psp3.FuzzyComputedTorque("t1", robot()).fit(**given)

    yield (
        "FuzzyComputedTorque.fit",
        Call(
            fit,
            {"trajectory": path(), "duration": 0.5, "samples": 40, "rng": None},
            {"rng": NONE, "samples": NONE},
            reads=lambda made: None,
        ),
    )
    yield (
        "AdaptiveFuzzyComputedTorque",
        Call(
            torque_of(psp3.AdaptiveFuzzyComputedTorque),
            {"controller": controller, "memory": None, "trust": None, "reach": 0.5, "lag": None},
            dict.fromkeys(("memory", "trust", "lag"), NONE),
        ),
    )
    t, signal = np.linspace(0.0, 1.0, 20), np.abs(np.sin(np.arange(20.0)))
    yield (
        "Monitor",
        Call(psp3.Monitor, {"quantile": 0.999, "hysteresis": 0.05, "time_constant": 0.05}),
    )
    monitor = psp3.Monitor().learn([(t, signal)])
    yield "Monitor.filtered", Call(monitor.filtered, {"t": t, "signal": signal})
    yield "Monitor.watch", Call(monitor.watch, {"t": t, "signal": signal})
    yield "Monitor.learn", Call(lambda runs: psp3.Monitor().learn(runs), {"runs": [(t, signal)]})
    yield (
        "Monitor.update",
        Call(
            lambda t, value: (
                psp3.Monitor().learn([(np.linspace(0.0, 1.0, 20), signal)]).update(t, value)
            ),
            {"t": 0.1, "value": 0.2},
        ),
    )


def of_statistics() -> Iterator[tuple[str, Call]]:
    """Yield statistics."""
    values, other = np.array([1.0, 2.0, 4.0, 3.0, 2.5]), np.array([2.0, 2.5, 5.0, 3.0, 3.5])
    for name in ("mean", "median"):
        yield (
            name,
            Call(
                getattr(statistics, name),
                {"values": values, "rng": None},
                {"rng": NONE, "values": ("one entry too many", "one entry too few")},
            ),
        )
    for name in ("paired_difference", "ratio_of_means"):
        yield (
            name,
            Call(
                getattr(statistics, name),
                {"first": values, "second": other, "rng": None},
                {"rng": NONE},
            ),
        )
    yield (
        "ratio_of_geometric_means",
        Call(statistics.ratio_of_geometric_means, {"first": values, "second": other}),
    )
    yield "share", Call(statistics.share, {"events": np.array([True, False, True])})


def of_studies(folder: Path) -> Iterator[tuple[str, Call]]:
    """Yield runs, studies and their tables."""
    made = psp3.Run()
    names = parameters_of(psp3.Run)
    empty = [name for name in names if getattr(made, name) is None]
    yield (
        "Run",
        Call(
            lambda **given: psp3.Run(**given).check(),
            {name: getattr(made, name) for name in names},
            {**dict.fromkeys(empty, NONE), "robot": A_TEXT},
        ),
    )
    file = folder / "study.sqlite"
    psp3.Study(file, [psp3.Run("pd", duration=0.02, seed=seed) for seed in (0, 1)]).run()
    kept = psp3.Study(file)
    yield (
        "Study",
        Call(
            psp3.Study,
            {"path": file, "runs": None},
            {"runs": (*NONE,), "path": A_TEXT},
            reads=lambda made: None,
        ),
    )
    yield (
        "Study.run",
        Call(
            psp3.Study(file, [psp3.Run("pd", duration=0.02)]).run,
            {"workers": 1, "scheduler": None, "progress": None},
            {"workers": NONE, "scheduler": NONE, "progress": NONE},
        ),
    )
    yield (
        "Study.export",
        Call(kept.export, {"path": folder / "out.csv"}, {}, reads=lambda path: None),
    )
    table = kept.table()
    yield (
        "summarize",
        Call(
            statistics.summarize,
            {"rows": table, "metric": "sum_of_squared_errors", "rng": None},
            {"rng": NONE},
        ),
    )
    yield (
        "compare",
        Call(
            statistics.compare,
            {
                "rows": table,
                "controller": "pd",
                "baseline": "pd",
                "metric": "sum_of_squared_errors",
                "rng": None,
            },
            {"rng": NONE},
        ),
    )
    yield "check_metric", Call(statistics.check_metric, {"metric": "sum_of_squared_errors"})
    yield "Table.column", Call(table.column, {"name": "controller"})
    yield "Table.values", Call(table.values, {"metric": "sum_of_squared_errors"})
    yield "Table.run", Call(table.run, {"index": 0}, reads=lambda run: None)
    yield "Table.of", Call(study.Table.of, {"rows": table}, reads=lambda made: None)
    yield (
        "Grid",
        Call(
            study.Grid,
            {"choices": {"controller": ["pd"]}},
            {"choices": ("mapping",)},
            reads=lambda made: None,
        ),
    )
    yield (
        "grid",
        Call(
            lambda controller, seed: list(psp3.grid(controller=controller, seed=seed)),
            {"controller": ["pd"], "seed": [0, 1]},
            reads=lambda made: None,
        ),
    )


def of_benchmark(folder: Path) -> Iterator[tuple[str, Call]]:
    """Yield the benchmark and what is written of it."""
    good = {
        "directory": folder / "bench",
        "entries": ("pd-gravity",),
        "robots": ("psp3",),
        "readings": ("outputs",),
        "levels": (20.0,),
        "seeds": 1,
        "duration": 0.1,
        "period": 0.004,
    }
    yield (
        "Benchmark",
        Call(
            benchmark.Benchmark,
            good,
            {"entries": ("empty",), "levels": ("empty",), "directory": A_TEXT},
            reads=lambda made: None,
        ),
    )
    ready = benchmark.Benchmark(**{**good, "entries": ("ctc",)})
    ready.run(workers=1)
    board = ready.board()
    yield (
        "Benchmark.run",
        Call(
            ready.run,
            {"workers": 1, "scheduler": None, "progress": None},
            dict.fromkeys(("workers", "scheduler", "progress"), NONE),
        ),
    )
    yield (
        "Benchmark.trials",
        Call(
            lambda seeds: list(ready.trials(seeds)),
            {"seeds": 1},
            {"seeds": NONE},
            reads=lambda made: None,
        ),
    )
    yield (
        "Board.ratio",
        Call(
            board.ratio,
            {"name": "exact", "other": "exact"}
            if False
            else {"name": next(iter(ready.entries)), "other": next(iter(ready.entries))},
        ),
    )
    for write in (benchmark.write_page, benchmark.write_numbers):
        yield (
            write.__name__,
            Call(
                write,
                {"board": board, "path": folder / "board"},
                {"path": A_TEXT},
                reads=lambda path: None,
            ),
        )
    yield (
        "Entry",
        Call(
            benchmark.Entry,
            {"name": "mine", "knows": "all", "make": len, "draws": False, "mark": ""},
            {"name": A_TEXT, "knows": A_TEXT, "mark": A_TEXT},
        ),
    )


def of_figures(folder: Path) -> Iterator[tuple[str, Call]]:
    """Yield figures and pages."""
    one = result()
    for name in ("figure_of_tracking", "figure_of_differences"):
        yield (
            name,
            Call(
                getattr(plots, name),
                {"result": one, "title": "a title", "axes": None},
                {"title": ANYTHING},
                reads=lambda panels: None,
            ),
        )
    yield (
        "figure_of_joint_tracking",
        Call(
            plots.figure_of_joint_tracking,
            {"robot": robot(), "result": one, "title": "a title", "axes": None},
            {"title": ANYTHING},
            reads=lambda panels: None,
        ),
    )
    yield (
        "figure_of_sweep",
        Call(
            plots.figure_of_sweep,
            {"series": {"pd": {0.0: (1.0, 0.5, 2.0)}}, "label": "error", "axes": None},
            {"label": ANYTHING},
            reads=lambda panels: None,
        ),
    )
    yield "Scene", Call(visualize.Scene, {"robot": robot()}, reads=lambda made: None)
    yield (
        "Scene.show",
        Call(
            visualize.Scene(robot()).show,
            {"positions": STATE["heights"], "desired": None, "force": None},
            {"desired": NONE, "force": NONE},
            reads=lambda made: None,
        ),
    )
    yield (
        "Scene.animate",
        Call(
            visualize.Scene(robot()).animate,
            {"motions": one, "duration": None},
            {"duration": NONE},
            reads=lambda made: None,
        ),
    )
    yield (
        "Viewer",
        Call(visualize.Viewer, {"port": "no port", "robot": robot()})
        if False
        else Call(lambda port: visualize.Viewer(robot(), port), {"port": 0})
        if False
        else Call(visualize.Scene, {"robot": robot()}, reads=lambda made: None),
    )
    yield (
        "write_animation",
        Call(
            visualize.write_animation,
            {"robot": robot(), "results": one, "path": folder / "page.html"},
            {"path": A_TEXT},
            reads=lambda made: None,
        ),
    )
    yield (
        "export_c",
        Call(
            psp3.export_c,
            {"thing": robot(), "path": folder / "c", "precision": "double", "name": "arm"},
            {"name": NONE},
            reads=lambda made: None,
        ),
    )
    yield (
        "export_fmu",
        Call(
            psp3.export_fmu,
            {
                "thing": robot(),
                "path": folder / "arm.fmu",
                "robot": None,
                "period": 0.002,
                "steps": 1,
                "torque_limit": None,
                "name": "arm",
                "version": "2.0",
            },
            {"name": NONE, "torque_limit": NONE, "robot": NONE},
            reads=lambda made: None,
        ),
    )
    yield (
        "load_result",
        Call(
            psp3.load_result, {"path": one.save(folder / "result.npz")}, {}, reads=lambda made: None
        ),
    )
    yield (
        "Result.save",
        Call(one.save, {"path": folder / "other.npz"}, {"path": A_TEXT}, reads=lambda made: None),
    )


def rows(folder: Path) -> dict[str, Call]:
    """Return the table: what is public, with good arguments."""
    return dict(
        (
            *of_controllers(),
            *of_statistics(),
            *of_studies(folder),
            *of_benchmark(folder),
            *of_figures(folder),
        )
    )
