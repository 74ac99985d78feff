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

ROBOTS = {name: psp3.load(name) for name in ("psp3", "delta", "five_bar", "planar_4rrr")}
SPREAD = {"psp3": 0.02, "delta": 0.1, "five_bar": 0.1, "planar_4rrr": 0.1}
"""How far states are from the reference [m, rad]; the last has more motors than coordinates."""

MANY = [400, pytest.param(10_000, marks=pytest.mark.slow)]
"""States that are compared: a few in a quick run."""


def gains(robot: Any) -> np.ndarray:
    """Return a matrix of gains in which no two entries are the same."""
    n = len(robot.coordinates)
    return 50.0 * np.eye(n) + np.arange(n * n).reshape(n, n)


def regulator(robot: Any) -> Any:
    """Return a regulator that accepts errors of 1 cm (rad/100) for forces of 30 N (N m)."""
    n = len(robot.coordinates)
    weight = 1e-3 * np.eye(robot.commanded)
    return psp3.LinearQuadraticRegulator(robot, 1e4 * np.eye(2 * n), weight)


def along_a_path(robot: Any) -> Any:
    """Return a regulator whose gains change, for a fifth of a second."""
    n = len(robot.coordinates)
    path = Sway(robot=robot)
    return psp3.TimeVaryingLinearQuadraticRegulator(
        robot, path, 0.2, 1e4 * np.eye(2 * n), 1e-3 * np.eye(n)
    )


CLASSICAL: dict[str, Callable[[Any], Any]] = {
    "PD": lambda robot: psp3.PD(100.0, 10.0, robot),
    "PD of matrices": lambda robot: psp3.PD(gains(robot), 0.1 * gains(robot), robot),
    "PID": lambda robot: psp3.PID(4000.0, 300.0, 50.0, robot),
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
    in_c, compiled = (
        ControllerInC(controller, tmp_path, robot=robot),
        CompiledStep(controller, robot),
    )
    rows = states(robot, count, SPREAD[name])
    assert not different(in_c, compiled, rows)
    assert sum(compiled.step(*row)[0] for row in rows) > 0.5 * count


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


ADAPTIVE = [("psp3", "t1", {}), ("psp3", "it2", {}), ("five_bar", "it2", {})]
ADAPTIVE += [("five_bar", "t1", {"coriolis": "mass"})]


@pytest.mark.parametrize("count", [400, pytest.param(10_000, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("name", "kind", "options"), ADAPTIVE)
def test_adaptive_controllers_learn_the_same_in_c(
    name: str, kind: str, options: dict[str, Any], count: int, tmp_path: Path
) -> None:
    """Along a path, with errors of 3 mm (mrad): what is learned comes back in the next forces."""
    robot = ROBOTS[name]
    path = Helix(robot=robot) if name == "psp3" else Sway(robot=robot)
    base = FuzzyComputedTorque(kind, robot, snr_db=20.0, **options)
    base.fit(path, 1.5, rng=np.random.default_rng(5))
    controller = psp3.AdaptiveFuzzyComputedTorque(base)
    in_c, compiled = ControllerInC(controller, tmp_path), CompiledStep(controller, robot)
    before = compiled.table.memory.consequents.copy()
    t, rng = 0.002 * np.arange(count), np.random.default_rng(0)
    motion = path(t)
    positions = motion.positions + rng.normal(0.0, 0.003, motion.positions.shape)
    speeds = motion.speeds + rng.normal(0.0, 0.02, positions.shape)
    desired = np.concatenate(motion[:3], axis=1)
    rows = list(zip(t.tolist(), positions, speeds, desired, strict=True))
    rows[count // 2][1][0] = np.nan  # a reading that is none: nothing is learned from it
    assert not different(in_c, compiled, rows)
    assert not np.array_equal(compiled.table.memory.consequents, before)


# Closed loops


WIRES: dict[str, dict[str, Any]] = {
    "nothing": {},
    "limits": {"torque_limit": 1.0},
    "encoders": {"encoder_resolution": 2e-4},
    "delay": {"delay": 2},
    "all": {"torque_limit": 1.0, "encoder_resolution": [1e-4, 0.0, 2e-4], "delay": 1},
}
"""Limits as shares of a force that one step in ten asks for more than."""


@pytest.mark.parametrize("wires", WIRES)
@pytest.mark.parametrize("kind", ["CTC", "PID", "it2"])
def test_a_run_that_c_steers_is_the_compiled_run_to_the_last_bit(
    kind: str, wires: str, tmp_path: Path
) -> None:
    """What lies between is in the C code, or in the loop: 0.4 s of the helix."""
    robot, given, period = ROBOTS["psp3"], dict(WIRES[wires]), 0.002
    controller = CLASSICAL[kind](robot) if kind in CLASSICAL else trained("psp3", kind)
    plain = psp3.simulate(robot, controller, Helix(robot=robot), 0.4, period)
    if "torque_limit" in given:
        given["torque_limit"] *= np.quantile(np.abs(plain.torque), 0.9, axis=0)
    right = psp3.simulate(robot, controller, Helix(robot=robot), 0.4, period, **given)
    options = {"period": period} if given else {}
    in_c = ControllerInC(controller, tmp_path, robot=robot, **given, **options)
    found = psp3.simulate(robot, in_c, Helix(robot=robot), 0.4, period)
    np.testing.assert_array_equal(found.torque, right.torque)
    np.testing.assert_array_equal(found.positions, right.positions)
    assert np.array_equal(plain.torque, right.torque) == (wires == "nothing")


@pytest.mark.parametrize("name", ["delta", "five_bar"])
def test_a_run_of_a_robot_with_loops_that_c_steers(name: str, tmp_path: Path) -> None:
    """The model's pose is remembered from step to step, in C as in the loop."""
    robot = ROBOTS[name]
    controller = psp3.ComputedTorque(robot, 100.0, 20.0)
    right = psp3.simulate(robot, controller, Sway(robot=robot), 0.2)
    in_c = ControllerInC(controller, tmp_path)
    found = psp3.simulate(robot, in_c, Sway(robot=robot), 0.2)
    np.testing.assert_array_equal(found.torque, right.torque)
    np.testing.assert_array_equal(found.positions, right.positions)


# Code


TYPICAL = ["PID", "CTC", "it2", "gt2 last", "crisp outside", "adaptive"]


def typical(kind: str) -> Any:
    if kind == "adaptive":
        return psp3.AdaptiveFuzzyComputedTorque(trained("psp3", "it2"))
    return CLASSICAL[kind](ROBOTS["psp3"]) if kind in CLASSICAL else trained("psp3", kind)


@pytest.mark.parametrize("kind", TYPICAL)
@pytest.mark.parametrize("precision", ["double", "single"])
def test_every_compiler_takes_the_code_without_a_warning(
    kind: str, precision: str, tmp_path: Path
) -> None:
    controller = typical(kind)
    for compiler in COMPILERS:
        code = c_code(controller, robot=ROBOTS["psp3"], precision=precision)
        compile_c(code, tmp_path, compiler)


DRIVER = """
#include <stdio.h>
#include "controller.h"

int main(void)
{
%(declared)s
    double t, given[15];
    int i, done;
%(reset)s
    while (scanf("%%lf", &t) == 1) {
        for (i = 0; i < 15; i++) {
            if (scanf("%%lf", &given[i]) != 1) {
                return 1;
            }
        }
        done = controller_step(%(state)st, given, given + 3, given + 6, %(outs)s);
        printf("%%d %%a\\n", done, out[0]);
    }
    return 0;
}
"""


@pytest.mark.parametrize("kind", TYPICAL)
def test_sanitizers_find_nothing(kind: str, tmp_path: Path) -> None:
    """Addresses, undefined behavior and divisions, in a program of its own; 300 states."""
    controller = typical(kind)
    code = export_c(controller, tmp_path, robot=ROBOTS["psp3"])
    step = code.functions[-1]
    sizes = [argument.size or 1 for argument in step.visible if argument.role == "out"]
    starts = np.cumsum([0, *sizes[:-1]])
    declared = f"    double out[{sum(sizes)}];"
    filled = {
        "declared": declared + ("\n    controller_state state;" if step.has_state else ""),
        "reset": "    controller_reset(&state);" if step.has_state else "",
        "state": "&state, " if step.has_state else "",
        "outs": ", ".join(f"out + {start}" for start in starts),
    }
    (tmp_path / "main.c").write_text(DRIVER % filled)
    program = tmp_path / "program"
    sanitized = ["-g", "-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover"]
    command = ["gcc", "-std=c99", "-O1", "-ffp-contract=off", *sanitized, "-o", str(program)]
    sources = [str(tmp_path / "main.c"), str(tmp_path / "controller.c")]
    done = subprocess.run([*command, *sources, "-lm"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:2000]
    rows = states(ROBOTS["psp3"], 300, SPREAD["psp3"])
    lines = "\n".join(
        " ".join(map(repr, [row[0], *np.concatenate(row[1:]).tolist()])) for row in rows
    )
    ran = subprocess.run([str(program)], input=lines, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr[:2000]
    compiled = CompiledStep(controller, ROBOTS["psp3"])
    for row, line in zip(rows, ran.stdout.splitlines(), strict=True):
        (said, force), (expected, right) = line.split(), compiled.step(*row)
        assert bool(int(said)) == expected
        assert not expected or float.fromhex(force) == right[0]


SINGLE = {"PID": 1e-5, "CTC": 2e-5, "it2": 1e-4, "gt2 last": 1e-4, "crisp outside": 1e-4}
"""Errors of single precision, as shares of the largest force: some hundred roundings of 6e-8; rules
whose order of consequents is a near tie may count twice that.
"""


@pytest.mark.parametrize("kind", SINGLE)
def test_single_precision_is_as_good_as_its_digits(kind: str, tmp_path: Path) -> None:
    controller, robot = typical(kind), ROBOTS["psp3"]
    single = ControllerInC(controller, tmp_path, robot=robot, precision="single")
    compiled = CompiledStep(controller, robot)
    errors, largest = [], 0.0
    for row in states(robot, 400, SPREAD["psp3"]):
        (said, force), (expected, right) = single.step(*row), compiled.step(*row)
        assert said == expected
        if expected:
            errors.append(np.abs(force[:3] - right[:3]).max())
            largest = max(largest, np.abs(right[:3]).max())
    assert 0.0 < max(errors) < SINGLE[kind] * largest


def test_a_model_with_loops_closes_them_in_single_precision(tmp_path: Path) -> None:
    """To ten roundings of 1e-7 of the largest force."""
    robot = ROBOTS["delta"]
    controller = psp3.ComputedTorque(robot)
    single = ControllerInC(controller, tmp_path, precision="single")
    compiled = CompiledStep(controller, robot)
    rows = states(robot, 200, SPREAD["delta"])
    pairs = [(single.step(*row), compiled.step(*row)) for row in rows]
    assert [one[0] for one, _ in pairs] == [other[0] for _, other in pairs]
    errors = [np.abs(one[1] - other[1]).max() for one, other in pairs if other[0]]
    largest = max(np.abs(other[1]).max() for _, other in pairs if other[0])
    assert len(errors) > 100
    assert 0.0 < max(errors) < 3e-6 * largest


def test_the_header_says_what_a_user_must_know() -> None:
    robot = ROBOTS["five_bar"]
    code = c_code(psp3.PID(100.0, 10.0, 50.0), robot=robot, name="arm")
    text = " ".join(code.header.replace("\n *", " ").split())
    for said in (
        f"PID of {robot.title}",
        "leg1_shoulder [rad], leg2_shoulder [rad]",
        "kp = 100",
        "kv = 10",
        "50 times the integral",
        "forces of the motors [N m]",
        "returns: 1, or 0 where the torque is not finite",
        f"by psp3 {psp3.__version__}",
        "int arm_step(arm_state *state, double t, const double positions[2]",
        "void arm_reset(arm_state *state);",
    ):
        assert said in text, said
    controller = trained("psp3", "crisp outside")
    text = c_code(controller).header
    low, high = controller.ranges_[:, 0]
    assert f"{controller.inputs.names[0]}: {low:.9g} to {high:.9g}" in text
    assert "the exact model takes over" in text
    assert "[N]" in text


def test_a_saved_controller_is_written_from_its_file(tmp_path: Path) -> None:
    controller = trained("psp3", "it2")
    path = controller.save(tmp_path / "trained.json")
    assert json.loads(path.read_text())["kind"] == "it2"
    code = export_c(path, tmp_path)
    assert code.source == c_code(controller).source
    assert (tmp_path / "controller.c").read_text() == code.source


def test_python_runs_the_functions_that_are_written() -> None:
    """Cases for the C code come from there."""
    robot = ROBOTS["five_bar"]
    controller = psp3.ComputedTorque(robot)
    reset, step = c_code(controller, robot=robot).functions
    state = {a.name: np.full(a.size or 1, np.nan) for a in step.arguments if a.role == "state"}
    reset.in_python(*state.values())
    compiled = CompiledStep(controller, robot)
    for row in states(robot, 50, SPREAD["five_bar"]):
        torque = np.empty(2)
        with np.errstate(invalid="ignore"):
            done = step.in_python(*state.values(), *row, torque)
        expected, right = compiled.step(*row)
        assert bool(done) == expected
        np.testing.assert_array_equal(torque, right)


def test_what_cannot_be_written_is_refused_with_a_remedy() -> None:
    robot = ROBOTS["psp3"]
    with pytest.raises(NotExportable, match=r"PD .*robot=\.\.\."):
        c_code(psp3.PD())
    with pytest.raises(NotExportable, match=r"TaskSpaceComputedTorque .*not compiled"):
        c_code(psp3.TaskSpaceComputedTorque(robot))
    with pytest.raises(NotExportable, match="not compiled"):
        c_code(psp3.ComputedTorque(robot.dynamics("noc")), robot=robot)
    with pytest.raises(NotExportable, match="str "):
        c_code("psp3")
    controller = psp3.ComputedTorque(robot)
    with pytest.raises(InvalidValue, match=r"period .*seconds"):
        c_code(controller, encoder_resolution=1e-4)
    with pytest.raises(InvalidValue, match="torque_limit"):
        c_code(controller, torque_limit=[1.0, 0.0, 1.0])
    with pytest.raises(InvalidValue, match="encoder_resolution"):
        c_code(controller, encoder_resolution=-1.0, period=0.002)
    with pytest.raises(InvalidValue, match="delay"):
        c_code(controller, delay=-1)
