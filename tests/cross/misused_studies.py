"""Good arguments of what psp3 offers beside robots: controllers, studies, benchmark and figures.

See tests.misuse.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import psp3
from psp3 import benchmark, plots, study, trajectories, visualize
from psp3.fuzzy_control.records import NOISE_OF_THE_STUDY, record
from psp3.study import statistics
from psp3.three_psp.workspace import map_over_tilt
from psp3.trajectories.screw_forces import screw_forces
from tests.misuse import Call, parameters_of
from tests.psp3.bounds.synthetic import constant

ANYTHING = ("*",)
NONE = ("None",)
A_TEXT = ("text",)
NAMES = ("text", "mapping")
"""A controller of a study may be anybody's, and of a mapping the keys are taken."""
ANY_LENGTH = ("one entry too many", "one entry too few")
HEIGHTS, SPEEDS = np.array([0.11, 0.1, 0.09]), np.array([0.1, -0.1, 0.0])
METRIC = "sum_of_squared_errors"


@functools.cache
def robot() -> Any:
    return psp3.load("psp3")


@functools.cache
def path() -> Any:
    return trajectories.Hold((0.0, 0.0, 0.1), robot=robot())


@functools.cache
def helix() -> Any:
    return trajectories.Helix(robot=robot())


@functools.cache
def recorded() -> Any:
    return record(robot(), helix(), 2.0)


@functools.cache
def learned() -> Any:
    return psp3.FuzzyComputedTorque("it2", robot()).learn(recorded(), 200)


@functools.cache
def result() -> Any:
    return psp3.simulate(robot(), psp3.PD(), path(), 0.1)


@functools.cache
def forces() -> Any:
    return screw_forces(helix(), 0.01 * np.arange(20))


def nothing(_: object) -> None:
    """Read no number of a thing: a figure, a file, a controller."""


def torque_of(make: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function that makes a controller, and asks it for one torque."""

    def made(**given: Any) -> Any:
        controller = make(**given)
        controller.reset()
        return controller.torque(0.0, HEIGHTS, SPEEDS, path()(0.0))

    return made


def of_controllers() -> Iterator[tuple[str, Call]]:
    """Yield how controllers are made that learn nothing."""
    model = robot()
    gains = {"kp": 100.0, "kv": 10.0}
    made: dict[str, tuple[Callable[..., Any], dict[str, Any]]] = {
        "PD": (psp3.PD, {**gains, "model": model}),
        "PID": (psp3.PID, {**gains, "ki": 5.0, "model": model}),
        "GravityCompensatedPD": (psp3.GravityCompensatedPD, {"model": model, **gains}),
        "ComputedTorque": (psp3.ComputedTorque, {"model": model, **gains}),
        "ComputedTorque.critically_damped": (
            psp3.ComputedTorque.critically_damped,
            {"model": model, "kp": 10.0},
        ),
        "FeedForward": (psp3.FeedForward, {"model": model}),
    }
    for name, (make, given) in made.items():
        takes = {"model": NONE} if name in ("PD", "PID") else {}
        yield name, Call(torque_of(make), given, takes)
    Q, R = np.eye(6), 1e-3 * np.eye(3)
    regulated = {"robot": model, "Q": Q, "R": R, "period": 0.002, "positions": None}
    yield "LinearQuadraticRegulator", Call(torque_of(psp3.LinearQuadraticRegulator), regulated)
    along = {"robot": model, "trajectory": path(), "duration": 0.01, "Q": Q, "R": R}
    yield (
        "TimeVaryingLinearQuadraticRegulator",
        Call(
            torque_of(psp3.TimeVaryingLinearQuadraticRegulator),
            {**along, "period": 0.002, "terminal": None},
        ),
    )
    tip = {"path": None, "frame": "tip", "task": ("x", "y", "z"), "damped_below": 0.15}
    yield (
        "TaskSpaceComputedTorque",
        Call(
            torque_of(psp3.TaskSpaceComputedTorque),
            {"robot": model, "kp": 10.0, "kv": 1.0, **tip},
        ),
    )


def of_learned_controllers(folder: Path) -> Iterator[tuple[str, Call]]:
    """Yield controllers that learn, and what they answer."""
    options = {"kind": "t1", "robot": robot(), "kp": 10.0, "kv": 1.0, "n_terms": 2, "rules": None}
    options |= {"learner": None, "coriolis": "rules", "snr_db": math.inf, "mean_variation": None}
    options |= {"levels": 5, "reduction": "alpha_planes", "outside": "clamp", "term_width": 1.0}
    options |= {"defuzzify": "first"}
    optional = {"robot": NONE, "n_terms": NONE, "snr_db": ("infinite",)}
    yield (
        "FuzzyComputedTorque",
        Call(psp3.FuzzyComputedTorque, options, optional, reads=nothing),
    )
    controller = learned()
    state = {"heights": HEIGHTS, "speeds": SPEEDS}
    of_the_state: dict[str, dict[str, Any]] = {
        "estimate": state,
        "estimated_numbers": state,
        "torque_number": {**state, "desired": path()(0.0)},
    }
    for name, given in of_the_state.items():
        yield f"FuzzyComputedTorque.{name}", Call(getattr(controller, name), given)
    number = controller.torque_number(HEIGHTS, SPEEDS, path()(0.0))
    yield "FuzzyComputedTorque.defuzzify", Call(controller.defuzzify, {"number": number})
    yield (
        "FuzzyComputedTorque.with_systems",
        Call(controller.with_systems, {"systems": list(controller.systems_)}, reads=nothing),
    )
    yield (
        "FuzzyComputedTorque.terms_of",
        Call(controller.terms_of, {"place": controller.places[0]}),
    )
    taught = {"samples": 40, "rng": None}

    def untaught() -> psp3.FuzzyComputedTorque:
        return psp3.FuzzyComputedTorque("t1", robot())

    yield (
        "FuzzyComputedTorque.fit",
        Call(
            lambda **given: untaught().fit(**given),
            {"trajectory": helix(), "duration": 1.0, **taught},
            {"samples": NONE},
            reads=nothing,
        ),
    )
    yield (
        "FuzzyComputedTorque.learn",
        Call(
            lambda **given: untaught().learn(**given),
            {"recorded": recorded(), **taught, "noise": NOISE_OF_THE_STUDY},
            {"samples": NONE},
            reads=nothing,
        ),
    )
    motion = helix()(0.05 * np.arange(40.0))
    moved = {"positions": motion.positions, "speeds": motion.speeds}
    moved |= {"accelerations": motion.accelerations}
    moved["forces"] = robot().inverse_dynamics(*moved.values())
    yield (
        "FuzzyComputedTorque.learn_from_motion",
        Call(
            lambda **given: psp3.FuzzyComputedTorque("t1", robot()).learn_from_motion(**given),
            {**moved, "positive_definite": False},
            reads=nothing,
        ),
    )
    file = controller.save(folder / "controller.json")
    yield (
        "FuzzyComputedTorque.load",
        Call(
            psp3.FuzzyComputedTorque.load,
            {"path": file, "robot": robot()},
            {"robot": NONE},
            reads=nothing,
        ),
    )
    yield (
        "FuzzyComputedTorque.save",
        Call(controller.save, {"path": folder / "other.json"}, {"path": A_TEXT}, reads=nothing),
    )
    adaptive = {"controller": controller, "memory": None, "trust": None, "reach": 0.5, "lag": None}
    yield (
        "AdaptiveFuzzyComputedTorque",
        Call(torque_of(psp3.AdaptiveFuzzyComputedTorque), adaptive),
    )


def of_the_monitor() -> Iterator[tuple[str, Call]]:
    """Yield the monitor, and what it says of signals."""
    t, signal = np.linspace(0.0, 1.0, 20), np.abs(np.sin(np.arange(20.0)))

    def taught() -> psp3.Monitor:
        return psp3.Monitor().learn([(t, signal)])

    limits = {"quantile": 0.999, "hysteresis": 0.05, "time_constant": 0.05}
    yield "Monitor", Call(psp3.Monitor, limits)
    for name in ("filtered", "watch"):
        yield f"Monitor.{name}", Call(getattr(taught(), name), {"t": t, "signal": signal})
    yield "Monitor.learn", Call(psp3.Monitor().learn, {"runs": [(t, signal)]})
    yield (
        "Monitor.update",
        Call(lambda t, value: taught().update(t, value), {"t": 0.1, "value": 0.2}),
    )


def of_statistics(table: Any) -> Iterator[tuple[str, Call]]:
    """Yield statistics of numbers, and of the table of a study."""
    values, other = np.array([1.0, 2.0, 4.0, 3.0, 2.5]), np.array([2.0, 2.5, 5.0, 3.0, 3.5])
    drawn = {"rng": None}
    for name in ("mean", "median"):
        yield name, Call(getattr(statistics, name), {"values": values, **drawn}, LEFT_OUT)
    pairs = {"first": values, "second": other}
    for name in ("paired_difference", "ratio_of_means"):
        yield name, Call(getattr(statistics, name), {**pairs, **drawn}, LEFT_OUT)
    yield (
        "ratio_of_geometric_means",
        Call(statistics.ratio_of_geometric_means, pairs, LEFT_OUT),
    )
    happened = {"events": np.array([True, False, True])}
    yield "share", Call(statistics.share, happened, {"events": ("empty",)})
    yield (
        "summarize",
        Call(statistics.summarize, {"rows": table, "metric": METRIC, **drawn}),
    )
    yield "check_metric", Call(statistics.check_metric, {"metric": METRIC})
    both = {"rows": table, "controller": "ctc", "baseline": "pd", "metric": METRIC}
    yield "compare", Call(statistics.compare, {**both, **drawn})


NOT_FINITE = ("NaN entry", "infinite entry")
LEFT_OUT = {
    "values": ("empty", *ANY_LENGTH, *NOT_FINITE),
    "first": NOT_FINITE,
    "second": NOT_FINITE,
}
"""Values that are not finite are those of runs that diverged. Of none the mean is NaN."""


def of_studies(folder: Path) -> Iterator[tuple[str, Call]]:
    """Yield runs, studies and their tables."""
    made = psp3.Run()
    fields = {name: getattr(made, name) for name in parameters_of(psp3.Run)}
    yield (
        "Run",
        Call(
            lambda **given: psp3.Run(**given).check(),
            fields,
            {name: NONE for name, value in fields.items() if value is None}
            | {"snr_db": ("infinite",)},
        ),
    )
    file = folder / "study.sqlite"
    runs = [psp3.Run(name, duration=0.1, seed=seed) for name in ("pd", "ctc") for seed in (0, 1)]
    psp3.Study(file, runs).run()
    kept = psp3.Study(file)
    yield (
        "Study",
        Call(psp3.Study, {"path": file, "runs": None}, {"path": A_TEXT}, reads=nothing),
    )
    yield (
        "Study.run",
        Call(
            psp3.Study(file, runs).run,
            {"workers": 1, "scheduler": None, "progress": None},
            {"workers": NONE},
        ),
    )
    yield (
        "Study.rows",
        Call(
            lambda **given: kept.rows(**given).metrics,
            {"controller": "pd", "seed": [0]},
            {"controller": NAMES, "seed": ("one entry too few",)},
        ),
    )
    yield (
        "Study.export",
        Call(kept.export, {"path": folder / "out.csv"}, {"path": A_TEXT}, reads=nothing),
    )
    table = kept.table() if hasattr(kept, "table") else kept.rows()
    yield from of_statistics(table)
    yield "Table.column", Call(table.column, {"name": "controller"})
    yield "Table.values", Call(table.values, {"metric": METRIC})
    yield "Table.run", Call(table.run, {"index": 0}, reads=nothing)
    yield "Table.taken", Call(table.taken, {"rows": np.array([0, 1])})
    yield "Table.of", Call(study.Table.of, {"rows": table}, reads=nothing)
    yield (
        "grid",
        Call(
            lambda **given: list(psp3.grid(**given)),
            {"controller": ["pd"], "seed": [0, 1], "snr_db": 20.0},
            {"controller": NAMES, "snr_db": ("infinite",)},
            reads=nothing,
        ),
    )


def of_benchmark(folder: Path) -> Iterator[tuple[str, Call]]:
    """Yield the benchmark and what is written of it."""
    good: dict[str, Any] = {"directory": folder / "bench", "entries": ("pd-gravity",)}
    good |= {"robots": ("psp3",), "readings": ("outputs",), "levels": (20.0,), "seeds": 1}
    good |= {"duration": 0.1, "period": 0.004}
    empty = dict.fromkeys(("entries", "levels", "readings"), ("empty", *ANY_LENGTH))
    yield (
        "Benchmark",
        Call(benchmark.Benchmark, good, {**empty, "directory": A_TEXT}, reads=nothing),
    )
    ready = benchmark.Benchmark(**{**good, "entries": ()})
    ready.run(workers=1)
    board = ready.board()
    yield (
        "Benchmark.run",
        Call(
            ready.run,
            {"workers": 1, "scheduler": None, "progress": None},
            {"workers": NONE},
        ),
    )
    yield (
        "Benchmark.trials",
        Call(lambda seeds: list(ready.trials(seeds)), {"seeds": 1}, {"seeds": NONE}, nothing),
    )
    yield "Board.extent", Call(board.extent, {"cell": board.cells[0]})
    name = next(iter(ready.entries))
    yield "Board.ratio", Call(board.ratio, {"name": name, "other": name})
    for write in (benchmark.write_page, benchmark.write_numbers):
        target = {"board": board, "path": folder / "board"}
        yield write.__name__, Call(write, target, {"path": A_TEXT}, reads=nothing)
    own = folder / "mine.py"
    own.write_text(ENTRY)
    yield "load_entry", Call(benchmark.load_entry, {"path": own}, reads=nothing)


ENTRY = """
class Mine:
    def fit(self, X, Y):
        return self

    def predict(self, X):
        return X
"""


def of_figures() -> Iterator[tuple[str, Call]]:
    """Yield figures; what they draw is no number."""
    machine, one = robot(), result()
    tilts = np.linspace(0.0, 0.3, 3)[:, np.newaxis]
    poses = map_over_tilt(machine, tilts, np.linspace(-np.pi, np.pi, 5))
    tube = psp3.TrackingTube(
        [constant(np.full(3, 0.1 * k)) for k in range(1, 20)], 100.0, 20.0, 0.5
    )
    around = constant(np.full(3, 0.1))
    titled: dict[str, Any] = {"title": "a title", "axes": None}
    arguments: dict[str, dict[str, Any]] = {
        "figure_of_tracking": {"result": one, **titled},
        "figure_of_differences": {"result": one, **titled},
        "figure_of_joint_tracking": {"robot": machine, "result": one, **titled},
        "figure_of_joint_forces": {"robot": machine, "forces": forces(), **titled},
        "figure_of_torques": {"forces": forces(), "axes": None},
        "figure_of_workspace": {"robot": machine, "poses": poses, "over": "tilt", "axes": None},
        "figure_of_tube": {"tube": tube, "results": [around], "axes": None},
        "figure_of_sweep": {
            "series": {"pd": {0.0: (1.0, 0.5, 2.0)}},
            "label": "error",
            "axes": None,
        },
    }
    texts = {"title": A_TEXT, "label": A_TEXT}
    for name, given in arguments.items():
        yield name, Call(getattr(plots, name), given, texts, reads=nothing)


def of_pages(folder: Path) -> Iterator[tuple[str, Call]]:
    """Yield scenes, and what else writes a file."""
    machine, one = robot(), result()
    yield "Scene", Call(visualize.Scene, {"robot": machine}, reads=nothing)
    shown = {"positions": HEIGHTS, "desired": HEIGHTS + 0.01, "force": 10.0 * SPEEDS}
    yield (
        "Scene.show",
        Call(
            lambda **given: visualize.Scene(machine).show(**given),
            shown,
            dict.fromkeys(("desired", "force"), NONE),
            reads=nothing,
        ),
    )
    yield (
        "Scene.animate",
        Call(
            lambda **given: visualize.Scene(machine).animate(**given),
            {"motions": path(), "duration": 0.1},
            reads=nothing,
        ),
    )
    scene = visualize.Scene(machine).show(HEIGHTS)
    page = {"path": folder / "page.html"}
    written: dict[str, Any] = {"takes": {"path": A_TEXT}, "reads": nothing}
    yield "Scene.write_html", Call(scene.write_html, page, **written)

    def served(**given: Any) -> None:
        visualize.Viewer(**given).close()

    yield "Viewer", Call(served, {"robot": machine, "port": 0}, reads=nothing)
    yield (
        "write_animation",
        Call(visualize.write_animation, {"robot": machine, "results": one, **page}, **written),
    )


def of_exports(folder: Path) -> Iterator[tuple[str, Call]]:
    """Yield what writes C."""
    reads: dict[str, Any] = {"reads": nothing}
    in_c = {
        "thing": psp3.ComputedTorque(robot()),
        "path": folder / "c",
        "precision": "double",
        "name": "arm",
    }
    yield "export_c", Call(psp3.export_c, in_c, {"name": NONE, "path": A_TEXT}, **reads)

    def without_a_binary(**given: Any) -> Any:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("psp3.export.fmu._compiled", lambda *_: (None, "it is left out"))
            return psp3.export_fmu(**given)

    unit = {"thing": robot(), "path": folder / "arm.fmu", "robot": None, "period": 0.002}
    unit |= {"steps": 1, "drive": psp3.Drive(), "torque_limit": None, "name": "arm"}
    yield (
        "export_fmu",
        Call(without_a_binary, {**unit, "version": "2.0"}, {"name": NONE}, **reads),
    )


def rows(folder: Path) -> dict[str, Call]:
    """Return the table: what is public, with good arguments."""
    return dict(
        (
            *of_controllers(),
            *of_learned_controllers(folder),
            *of_the_monitor(),
            *of_studies(folder),
            *of_benchmark(folder),
            *of_figures(),
            *of_pages(folder),
            *of_exports(folder),
        )
    )
