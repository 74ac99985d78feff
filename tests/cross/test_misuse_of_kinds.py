"""Things of the wrong kind, and calls out of order: an error on purpose, never a foreign one.

A robot where a controller is wanted, a controller where a robot is, a class where one of its
objects is, a number where a file is, a set where a system is, and what is asked before it was
trained.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fuzzy2
import psp3
from fuzzy2 import plots as fuzzy_plots
from fuzzy2.errors import RaisedOnPurpose
from psp3 import benchmark, plots, trajectories, visualize

LOW = fuzzy2.Gaussian(0.0, 1.0)
SYSTEM = fuzzy2.Type1System([[LOW]], [[0]], [[1.0]])


@functools.cache
def robot() -> Any:
    return psp3.load("psp3")


@functools.cache
def held() -> Any:
    return trajectories.Hold((0.0, 0.0, 0.1), robot=robot())


def untrained() -> Any:
    return psp3.FuzzyComputedTorque("t1", robot())


def study(folder: Path) -> psp3.Study:
    return psp3.Study(folder / "study.sqlite", [psp3.Run("pd", duration=0.01)])


ZERO = np.zeros(3)
WEIGHTS = np.eye(6), np.eye(3)

WRONG: dict[str, Callable[[Path], Any]] = {
    # of another kind
    "study of a number": lambda _: psp3.Study(3),  # type: ignore[arg-type]
    "study of a robot": lambda folder: psp3.Study(folder / "a.sqlite", [robot()]),
    "benchmark of a text": lambda folder: benchmark.Benchmark(folder, robots="delta"),
    "page of nothing": lambda folder: benchmark.write_page(None, folder / "page.html"),
    "entry of a number": lambda _: benchmark.load_entry(3),  # type: ignore[arg-type]
    "training with nothing": lambda _: untrained().fit(None),
    "training with a robot": lambda _: untrained().fit(robot()),
    "controller of a name": lambda _: psp3.FuzzyComputedTorque("t1", "five_bar"),
    "controller of a controller": lambda _: psp3.FuzzyComputedTorque("t1", psp3.PD()),
    "adaptation of PD": lambda _: psp3.AdaptiveFuzzyComputedTorque(psp3.PD()),
    "controller file of a number": lambda _: psp3.FuzzyComputedTorque.load(3),
    "result file of nothing": lambda _: psp3.load_result(None),
    "model of nothing": lambda _: psp3.ComputedTorque(None),
    "model of a controller": lambda _: psp3.ComputedTorque(psp3.PD()),
    "regulator of a controller": lambda _: psp3.LinearQuadraticRegulator(psp3.PD(), *WEIGHTS),
    "regulator along nothing": lambda _: psp3.TimeVaryingLinearQuadraticRegulator(
        robot(), None, 0.1, *WEIGHTS
    ),
    "robot and controller swapped": lambda _: psp3.simulate(psp3.PD(), robot(), held(), 0.01),
    "a robot as a controller": lambda _: psp3.simulate(robot(), robot(), held(), 0.01),
    "a class as a controller": lambda _: psp3.simulate(robot(), psp3.PD, held(), 0.01),
    "scene of a name": lambda _: visualize.Scene("psp3"),
    "viewer of a name": lambda _: visualize.Viewer("psp3"),
    "port of a text": lambda _: visualize.Viewer(robot(), "x"),
    "animation of nothing": lambda folder: visualize.write_animation(
        robot(), None, folder / "page.html"
    ),
    "figure of nothing": lambda _: plots.figure_of_tracking(None, ""),
    "figure of a robot": lambda _: plots.figure_of_differences(robot(), ""),
    "figure of a name": lambda _: plots.figure_of_joint_tracking("psp3", None, ""),
    "forces of nothing": lambda _: plots.figure_of_torques(None),
    "forces of joints of nothing": lambda _: plots.figure_of_joint_forces(robot(), None, ""),
    "workspace of nothing": lambda _: plots.figure_of_workspace(robot(), None),
    "sweep of a list": lambda _: plots.figure_of_sweep([1], ""),
    "C of nothing": lambda folder: psp3.export_c(None, folder),
    "FMU of a number": lambda _: psp3.export_fmu(3, 3),
    "progress that cannot be called": lambda folder: study(folder).run(progress=3),
    "scheduler of a number": lambda folder: study(folder).run(scheduler=3),
    "workers of a text": lambda folder: study(folder).run(workers="many"),
    "summary of a number": lambda _: psp3.statistics.summarize(3),
    "a set in a type-1 system": lambda _: fuzzy2.Type1System([[UNCERTAIN]], [[0]], [[1.0]]),
    "a general set in an interval system": lambda _: fuzzy2.IntervalType2System(
        [[fuzzy2.GaussianType2Set(LOW, 0.1)]], [[0]], [[1.0]]
    ),
    "adaptation of a set": lambda _: fuzzy2.AdaptiveConsequents(LOW),
    "tuning of a set": lambda _: fuzzy2.fine_tune(
        LOW, [[1.0], [2.0]], [1.0, 2.0], np.random.default_rng(0)
    ),
    "defuzzified system": lambda _: fuzzy2.defuzzify(SYSTEM),
    "cardinality of a system": lambda _: fuzzy2.cardinality(SYSTEM),
    "set in C": lambda folder: fuzzy2.export_c(LOW, folder),
    "file of a number": lambda _: fuzzy2.load(3),
    "explanation of nothing": lambda _: fuzzy_plots.figure_of_inference(None),
    "picture of a number": lambda _: fuzzy_plots.figure_of_sets(3),
    "type-1 set from above": lambda _: fuzzy_plots.figure_from_above(LOW),
    "number in space": lambda _: fuzzy_plots.figure_in_space(3),
    "slices of a type-1 set": lambda _: fuzzy_plots.figure_of_secondaries(LOW, [0.0]),
    "operations on a number": lambda _: fuzzy_plots.figure_of_operations(3, LOW),
    "response of a set": lambda _: fuzzy_plots.figure_of_response(LOW),
    "surface over one input": lambda _: fuzzy_plots.figure_of_rule_surface(SYSTEM),
    # out of order
    "board before a run": lambda folder: benchmark.Benchmark(
        folder / "none", entries=("pd-gravity",), robots=("psp3",), seeds=1, duration=0.1
    ).board(),
    "torque before training": lambda _: untrained().torque(0.0, ZERO, ZERO, held()(0.0)),
    "estimate before training": lambda _: untrained().estimate(ZERO, ZERO),
    "file before training": lambda folder: untrained().save(folder / "controller.json"),
    "adaptation before training": lambda _: psp3.AdaptiveFuzzyComputedTorque(untrained()),
    "monitor before learning": lambda _: psp3.Monitor().update(0.0, 1.0),
    "prediction before learning": lambda _: fuzzy2.WangMendel().predict([[1.0]]),
    "explanation before learning": lambda _: fuzzy2.ANFIS().explain([1.0]),
    "classes before learning": lambda _: fuzzy2.FuzzyClassifier().predict_proba([[1.0]]),
}
UNCERTAIN = fuzzy2.GaussianUncertainMean((0.0, 1.0), 1.0)


@pytest.mark.parametrize("wrong", WRONG.values(), ids=WRONG)
def test_the_wrong_kind_is_refused(wrong: Callable[[Path], Any], tmp_path: Path) -> None:
    with pytest.raises(RaisedOnPurpose):
        wrong(tmp_path)
