"""Controllers in C against the compiled loop's own steps."""

from __future__ import annotations

import functools
import json
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import psp3
from fuzzy2.errors import NotExportable
from fuzzy2.export.c_code import CCode
from psp3.errors import InvalidArray, InvalidValue, PSP3Error
from psp3.export.face import c_code, export_c
from psp3.export.project import export_project
from psp3.kinematics.frames import point_motion
from psp3.trajectories import Helix, Motion, Sway
from tests.c_code import (
    BEFORE_A_RELEASE,
    COMPILERS,
    PRECISIONS,
    STATES,
    functions_of,
    optimization,
    warnings_of,
)
from tests.project_folder import SANITIZED, check_statically, make, needs_clang, needs_cppcheck
from tests.psp3.export.controller_in_c import (
    CompiledStep,
    ControllerInC,
    compared,
    states,
)
from tests.psp3.export.controllers_of_all_kinds import (
    ADAPTIVE,
    FUZZY,
    KINDS,
    along_a_path,
    made,
    regulator,
    robot_of,
    states_of,
)

needs_gcc = pytest.mark.skipif("gcc" not in COMPILERS, reason="no gcc on this machine")
pytestmark = [
    needs_gcc,
    pytest.mark.filterwarnings("ignore:the Gaussian corollary:fuzzy2.ApproximationWarning"),
]

ROBOTS = {name: robot_of(name) for name in ("psp3", "delta", "five_bar")}

EVERY = [
    pytest.param(kind, name, marks=() if name == one.robots[0] else pytest.mark.slow)
    for kind, one in KINDS.items()
    for name in one.robots
]
"""Kinds and robots; one of each in a quick run."""


@functools.cache
def in_single_precision(kind: str, name: str) -> CCode:
    """Return the code of a controller in single precision, the same one in every test."""
    return c_code(made(kind, name), robot=robot_of(name), precision="single")


@pytest.mark.parametrize(("kind", "name"), EVERY)
def test_every_kind_is_the_compiled_step_to_the_last_bit(
    kind: str, name: str, tmp_path: Path
) -> None:
    """Forces, intervals, flags, and where there is no answer.

    The robot's model is in the C code, with its loops and the pose of the step before; what adapts
    learns in C as in Python, from step to step. States are in reach and out of it, and of learned
    rules inside and outside of their range. The code for one robot of a kind is optimized.
    """
    controller, robot = made(kind, name), robot_of(name)
    optimized = optimization(name == KINDS[kind].robots[0])
    in_c = ControllerInC(controller, tmp_path, optimized=optimized, robot=robot)
    compiled = CompiledStep(controller, robot)
    said = compared(in_c, compiled, states_of(kind, name, STATES))
    assert said.different == []
    assert 0.3 * STATES < said.done < STATES
    if kind in FUZZY:
        assert {0.0, 1.0} <= set(said.numbers[:, -2])
    if kind in ADAPTIVE:
        trained_rules = controller.rules.trained
        assert not np.array_equal(compiled.table.memory.consequents, trained_rules)


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
    controller = made(kind, "psp3")
    plain = psp3.simulate(robot, controller, Helix(robot=robot), 0.4, period)
    if "torque_limit" in given:
        given["torque_limit"] *= np.quantile(np.abs(plain.torque), 0.9, axis=0)
    right = psp3.simulate(robot, controller, Helix(robot=robot), 0.4, period, **given)
    options = {"period": period} if given else {}
    in_c = ControllerInC(controller, tmp_path, optimized="-O0", robot=robot, **given, **options)
    found = psp3.simulate(robot, in_c, Helix(robot=robot), 0.4, period)
    np.testing.assert_array_equal(found.torque, right.torque)
    np.testing.assert_array_equal(found.positions, right.positions)
    assert np.array_equal(plain.torque, right.torque) == (wires == "nothing")


RUNS = [
    ("CTC", "delta"),
    ("CTC", "five_bar"),
    ("CTC", "planar_4rrr"),
    ("LQR", "planar_4rrr"),
    ("CTC of a robot that floats", "walker"),
    ("on a frame", "five_bar"),
    ("adaptive, it2", "psp3"),
    ("adaptive, it2", "five_bar"),
]


@pytest.mark.parametrize(("kind", "name"), RUNS)
def test_limits_encoders_and_delay_are_those_of_the_simulation(
    kind: str, name: str, tmp_path: Path
) -> None:
    """Also where motors are more or fewer than coordinates: 0.1 s, from pose to pose in both.

    Resolutions are of the commanded coordinates, limits of the motors.
    """
    robot, controller, period = robot_of(name), made(kind, name), 0.002
    path = Helix(robot=robot) if name == "psp3" else Sway(robot=robot)
    plain = psp3.simulate(robot, controller, path, 0.1, period)
    given = {
        "torque_limit": np.quantile(np.abs(plain.torque), 0.9, axis=0),
        "encoder_resolution": np.linspace(1e-5, 2e-5, robot.commanded),
        "delay": 1,
    }
    right = psp3.simulate(robot, controller, path, 0.1, period, **given)
    in_c = ControllerInC(controller, tmp_path, optimized="-O0", robot=robot, period=period, **given)
    found = psp3.simulate(robot, in_c, path, 0.1, period)
    np.testing.assert_array_equal(found.torque, right.torque)
    np.testing.assert_array_equal(found.positions, right.positions)
    assert not np.array_equal(plain.torque, right.torque)


# Code


CHECKED = [(kind, one.checked) for kind, one in KINDS.items()]

OPTIMIZED_IN_SINGLE = ("CTC", "on a frame", "it2", "gt2", "adaptive, it2")
"""With a model in it, of a task, learned, of planes, and one that adapts."""


WITH_EVERY_FUNCTION = (
    *("PD", "CTC of a robot that floats", "LQR", "on a frame", "C of M, gt2 last"),
    *("corollary, crisp outside", "adaptive, it2", "adaptive, C of M, it2"),
)
"""Kinds whose code has, together, every function that is in any kind's: cppcheck reads it."""


def test_some_kinds_have_every_function() -> None:
    functions = {kind: functions_of(in_single_precision(kind, name)) for kind, name in CHECKED}
    every = set().union(*functions.values())
    assert len(every) > 150
    assert every == set().union(*(functions[kind] for kind in WITH_EVERY_FUNCTION))


@pytest.mark.slow
@needs_clang
@needs_cppcheck
@pytest.mark.parametrize(("kind", "name"), CHECKED)
def test_another_compiler_sanitizers_and_cppcheck_find_nothing(
    kind: str, name: str, tmp_path: Path
) -> None:
    """In a program of 200 cases, which gives Python's numbers under the sanitizers, too.

    Of addresses, undefined behavior, and conversions, which see every step of code that is not
    optimized. The code of single precision differs in its types and literals alone: of it clang
    tells what it warns of, and it runs under the sanitizers before a release. What its numbers are
    is another test's: what adapts to readings that make no motion may learn something else in seven
    digits. Then cppcheck reads the code of all kinds, and else that of those which have every
    function.
    """
    for precision in PRECISIONS:
        folder = tmp_path / precision
        export_project(made(kind, name), folder, precision=precision, robot=robot_of(name))
        make(folder, "CC=clang", "runner", flags=SANITIZED)
        ran = subprocess.run([folder / "runner"], capture_output=True, encoding="utf-8")
        assert ran.stderr == ""
        assert ("passed: 0 differ" if precision == "double" else "differ by more") in ran.stdout
        if kind in WITH_EVERY_FUNCTION or BEFORE_A_RELEASE:
            check_statically(folder)
    in_single_precision(kind, name).write(tmp_path)
    assert warnings_of("clang", tmp_path) == ""


@pytest.mark.parametrize(("kind", "name"), CHECKED)
def test_single_precision_is_as_good_as_its_digits(
    kind: str, name: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    """Of every kind: 400 steps. Errors are shares of the largest force, see :class:`Kind`.

    A pose at the edge of reach may be in it with seven digits and out of it with sixteen: at most
    one in a hundred.
    """
    if (kind, name) == ("adaptive, average", "psp3"):
        why = "a rule's weight jumps where its consequent passes an end: see single_precision.md"
        request.applymarker(pytest.mark.xfail(reason=why, strict=True))
    optimized = optimization(kind in OPTIMIZED_IN_SINGLE)
    single = ControllerInC(in_single_precision(kind, name), tmp_path, optimized=optimized)
    compiled = CompiledStep(made(kind, name), robot_of(name))
    motors, errors, largest, others = len(robot_of(name).actuated), [], 0.0, 0
    for row in states_of(kind, name, 400):
        (said, force), (expected, right) = single.step(*row), compiled.step(*row)
        others += said != expected
        if said and expected:
            errors.append(np.abs(force[:motors] - right[:motors]).max())
            largest = max(largest, np.abs(right[:motors]).max())
    assert others <= 4
    assert 0.0 < max(errors) < KINDS[kind].single * largest


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
        "returns: 1; or 0 if the torque is not finite",
        f"by psp3 {psp3.__version__}",
        "int arm_step(arm_state *state, double t, const double positions[2]",
        "void arm_reset(arm_state *state);",
    ):
        assert said in text, said
    controller = made("crisp outside", "psp3")
    text = c_code(controller).header
    low, high = controller.ranges_[:, 0]
    assert f"{controller.inputs.names[0]}: {low:.9g} to {high:.9g}" in text
    assert "the exact model takes over" in text
    assert "[N]" in text


def test_a_saved_controller_is_written_from_its_file(tmp_path: Path) -> None:
    controller = made("it2", "psp3")
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
    for row in states(robot, 50, 0.1):
        torque = np.empty(2)
        with np.errstate(invalid="ignore"):
            done = step.in_python(*state.values(), *row, torque)
        expected, right = compiled.step(*row)
        assert bool(done) == expected
        np.testing.assert_array_equal(torque, right)


REFUSED = [
    ("walker", regulator, "closures="),
    ("walker", psp3.TaskSpaceComputedTorque, "free='lock'"),
    ("walker", lambda robot: psp3.FuzzyComputedTorque("t1", robot), "not those of the motors"),
    ("planar_4rrr", lambda robot: psp3.FuzzyComputedTorque("t1", robot), "not those of the motors"),
    ("gripper", along_a_path, "LinearQuadraticRegulator takes free coordinates"),
    ("gripper", regulator, "the input must reach every unstable motion"),
]


@pytest.mark.parametrize(("name", "make_controller", "remedy"), REFUSED)
def test_a_robot_that_a_kind_cannot_steer_is_refused_in_python(
    name: str, make_controller: Any, remedy: str
) -> None:
    """So there is nothing that could be written."""
    with pytest.raises(PSP3Error, match=remedy):
        make_controller(robot_of(name))


def test_gains_of_another_size_are_refused_in_python_and_in_c() -> None:
    robot = robot_of("walker")
    controller = psp3.PD(np.eye(5), np.eye(5), robot)
    home, rest, wanted = robot.reference, np.zeros(10), robot.reference[:4]
    desired = Motion(wanted, 0.0 * wanted, 0.0 * wanted, np.zeros(3))
    with pytest.raises(InvalidArray, match=r"\(4, 4\) of 4 commanded"):
        controller.torque(0.0, home, rest, desired)
    with pytest.raises(InvalidArray, match=r"\(4, 4\) of 4 commanded"):
        c_code(controller)


def test_what_cannot_be_written_is_refused_with_a_remedy() -> None:
    robot = ROBOTS["psp3"]
    with pytest.raises(NotExportable, match=r"PD .*robot=\.\.\."):
        c_code(psp3.PD())
    with pytest.raises(NotExportable, match=r"TaskSpaceComputedTorque .*without a path"):
        c_code(psp3.TaskSpaceComputedTorque(robot, path=lambda t: point_motion([0.0, 0.0, 0.1])))
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
