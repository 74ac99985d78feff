"""Controllers in C against the compiled loop's own steps."""

from __future__ import annotations

import json
import subprocess
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fuzzy2
import psp3
from fuzzy2.errors import NotExportable
from psp3.errors import InvalidValue
from psp3.export.face import c_code, export_c
from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
from psp3.trajectories import Helix, Sway
from tests.psp3.export.controller_in_c import (
    COMPILERS,
    CompiledStep,
    ControllerInC,
    compile_c,
    different,
    states,
)

needs_gcc = pytest.mark.skipif("gcc" not in COMPILERS, reason="no gcc on this machine")
pytestmark = [
    needs_gcc,
    pytest.mark.filterwarnings("ignore:the Gaussian corollary:fuzzy2.ApproximationWarning"),
]

ROBOTS = {name: psp3.load(name) for name in ("psp3", "delta", "five_bar")}
SPREAD = {"psp3": 0.02, "delta": 0.1, "five_bar": 0.1}
"""How far states are from the reference [m, rad]."""

MANY = [400, pytest.param(10_000, marks=pytest.mark.slow)]
"""States that are compared: a few in a quick run."""


def gains(robot: Any) -> np.ndarray:
    """Return a matrix of gains in which no two entries are the same."""
    n = len(robot.coordinates)
    return 50.0 * np.eye(n) + np.arange(n * n).reshape(n, n)


def regulator(robot: Any) -> Any:
    """Return a regulator that accepts errors of 1 cm (rad/100) for forces of 30 N (N m)."""
    n = len(robot.coordinates)
    return psp3.LinearQuadraticRegulator(robot, 1e4 * np.eye(2 * n), 1e-3 * np.eye(n))


def along_a_path(robot: Any) -> Any:
    """Return a regulator whose gains change, for a fifth of a second."""
    n = len(robot.coordinates)
    path = Sway(robot=robot)
    return psp3.TimeVaryingLinearQuadraticRegulator(
        robot, path, 0.2, 1e4 * np.eye(2 * n), 1e-3 * np.eye(n)
    )


CLASSICAL: dict[str, Callable[[Any], Any]] = {
    "PD": lambda robot: psp3.PD(100.0, 10.0),
    "PD of matrices": lambda robot: psp3.PD(gains(robot), 0.1 * gains(robot)),
    "PID": lambda robot: psp3.PID(100.0, 10.0, 50.0),
    "PD with gravity": psp3.GravityCompensatedPD,
    "feed-forward": psp3.FeedForward,
    "CTC": psp3.ComputedTorque,
    "LQR": regulator,
    "LQR along a path": along_a_path,
}


@pytest.mark.parametrize("count", MANY)
@pytest.mark.parametrize("kind", CLASSICAL)
@pytest.mark.parametrize("name", ROBOTS)
def test_classical_controllers_are_the_compiled_step_to_the_last_bit(
    name: str, kind: str, count: int, tmp_path: Path
) -> None:
    """The robot's model is in the C code, with its loops and the pose of the step before."""
    robot = ROBOTS[name]
    controller = CLASSICAL[kind](robot)
    in_c = ControllerInC(controller, tmp_path, robot=robot)
    rows = states(robot, count, SPREAD[name])
    assert not different(in_c, CompiledStep(controller, robot), rows)


FUZZY: dict[str, dict[str, Any]] = {
    "t1": {"kind": "t1"},
    "it2": {"kind": "it2"},
    "gt2": {"kind": "gt2"},
    "gt2 last": {"kind": "gt2", "defuzzify": "last"},
    "corollary": {"kind": "gt2", "reduction": "gaussian"},
    "crisp outside": {"kind": "it2", "outside": "crisp"},
    "corollary, crisp outside": {"kind": "gt2", "reduction": "gaussian", "outside": "crisp"},
    "average": {"kind": "it2", "learner": "average"},
}
ANY: dict[str, dict[str, Any]] = FUZZY | {
    "C of M": {"kind": "t1", "coriolis": "mass"},
    "C of M, gt2 last": {"kind": "gt2", "coriolis": "mass", "defuzzify": "last"},
}


def trained(name: str, kind: str) -> FuzzyComputedTorque:
    """Return a controller learned from noisy samples of a second and a half."""
    robot = ROBOTS[name]
    path = Helix(robot=robot) if name == "psp3" else Sway(robot=robot)
    options = (FUZZY if name == "psp3" else ANY)[kind]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fuzzy2.ApproximationWarning)
        controller = FuzzyComputedTorque(robot=robot, snr_db=20.0, **options)
        return controller.fit(path, 1.5, rng=np.random.default_rng(5))


@pytest.mark.parametrize("count", MANY)
@pytest.mark.parametrize(
    ("name", "kind"),
    [("psp3", kind) for kind in FUZZY] + [("five_bar", kind) for kind in ANY],
)
def test_learned_controllers_are_the_compiled_step_to_the_last_bit(
    name: str, kind: str, count: int, tmp_path: Path
) -> None:
    """With the torque's interval and both flags; states are inside and outside of the range."""
    controller, robot = trained(name, kind), ROBOTS[name]
    in_c = ControllerInC(controller, tmp_path)
    rows = states(robot, count, SPREAD[name])
    compiled = CompiledStep(controller, robot)
    assert not different(in_c, compiled, rows)
    covered = [compiled.step(*row)[1][-2] for row in rows]
    assert 0.0 in covered
    assert 1.0 in covered


def test_a_learned_controller_of_delta(tmp_path: Path) -> None:
    controller, robot = trained("delta", "crisp outside"), ROBOTS["delta"]
    in_c = ControllerInC(controller, tmp_path)
    rows = states(robot, 400, SPREAD["delta"])
    assert not different(in_c, CompiledStep(controller, robot), rows)
