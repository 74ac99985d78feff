"""``psp3 export c``: the folder that it writes answers as Python does."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

import fuzzy2
import psp3
from psp3.description.parts import ROBOT_FILES
from tests.project_folder import asked, lines, make, needs_c, numbers
from tests.psp3.cli.answers import Run, words

SYSTEM = fuzzy2.Type1System(
    {"error": {"small": fuzzy2.Gaussian(0.0, 1.0), "large": fuzzy2.Gaussian(3.0, 1.0)}},
    "IF error is small THEN force is weak \n IF error is large THEN force is strong",
    {"force": {"weak": 1.0, "strong": 5.0}},
    input_ranges=[(0.0, 4.0)],
)


@needs_c
@pytest.mark.parametrize("file", ["my-rules.fis", "my-rules.fll", "my-rules.json"])
def test_fuzzy_system_of_a_file(psp3_command: Run, file: str) -> None:
    fuzzy2.save(SYSTEM, file)
    answer = psp3_command("export", "c", file, "--out", "folder")
    assert answer.status == 0
    said = "my_rules.c and my_rules.h are in folder, with 1 function; "
    assert said + "'make -C folder test' compares what they answer with Python" in words(answer.out)
    folder = Path("folder")
    make(folder)
    assert "passed" in make(folder, "test")
    X = np.linspace(-2.0, 6.0, 9)[:, None]
    found = numbers(asked(folder, lines(X))[1])
    np.testing.assert_array_equal(found[:, 1:], fuzzy2.load(file)(X))


@needs_c
def test_robot_of_a_name_in_single_precision(psp3_command: Run) -> None:
    answer = psp3_command(
        *("export", "c", "five_bar", "--out", "folder"),
        *("--precision", "single", "--name", "linkage"),
    )
    assert answer.status == 0
    folder = Path("folder")
    make(folder)
    assert "passed" in make(folder, "test")
    assert "float positions[2]" in (folder / "linkage.h").read_text(encoding="utf-8")
    robot = psp3.load("five_bar")
    state = np.concatenate([robot.reference + 0.1, [0.3, -0.2], [1.0, 2.0]])
    status, out, _ = asked(folder, lines([state]), "inverse_dynamics")
    want = robot.inverse_dynamics(*np.split(state, 3))
    assert status == 0
    # Single precision rounds to 6e-8; the linkage's equations are well conditioned here.
    np.testing.assert_allclose(numbers(out)[0, 1:], want, rtol=2e-5)


@needs_c
def test_controller_of_a_file(psp3_command: Run) -> None:
    """Bit for bit the torque of the controller that was saved."""
    robot = psp3.load("psp3")
    helix = psp3.trajectories.Helix(robot=robot)
    controller = psp3.FuzzyComputedTorque("t1", robot, learner="average").fit(helix)
    controller.save("trained.json")
    assert psp3_command("export", "c", "trained.json", "--out", "folder").status == 0
    folder = Path("folder")
    make(folder)
    assert "passed" in make(folder, "test")
    wanted = helix(np.array([0.3]))
    desired = type(wanted)(*(one[0] for one in wanted))
    state = [0.3, *(desired.positions + 0.001), *(desired.speeds - 0.01)]
    row = [*state, *desired.positions, *desired.speeds, *desired.accelerations]
    found = numbers(asked(folder, lines([row]), "step")[1])[0]
    want = controller.torque(0.3, np.array(state[1:4]), np.array(state[4:]), desired)
    np.testing.assert_array_equal(found[1:4], want)


@needs_c
def test_controller_with_limits_of_a_robot_from_files(psp3_command: Run) -> None:
    """Options of the robot are those of other commands; the forces are limited, and else equal."""
    for ending in ("urdf", "srdf"):
        shutil.copy(ROBOT_FILES / f"five_bar.{ending}", f"mine.{ending}")
    shutil.copy(ROBOT_FILES / "five_bar.yaml", "closed.yaml")
    robot = psp3.load("mine.urdf", loops="closed.yaml")
    path = psp3.trajectories.Sway(robot=robot)
    controller = psp3.FuzzyComputedTorque("t1", robot, learner="average").fit(path, 1.5)
    controller.save("trained.json")
    wanted = path(np.array([0.3]))
    desired = type(wanted)(*(one[0] for one in wanted))
    state = [0.3, *(desired.positions + 0.2), *(desired.speeds - 0.1)]
    want = controller.torque(0.3, np.array(state[1:3]), np.array(state[3:]), desired)
    limits = np.array([0.5, 2.0]) * abs(want)
    answer = psp3_command(
        *("export", "c", "trained.json", "mine.urdf", "--loops", "closed.yaml", "--out", "folder"),
        *("--torque-limit", ",".join(map(repr, limits.tolist()))),
    )
    assert answer.status == 0
    folder = Path("folder")
    make(folder)
    assert "passed" in make(folder, "test")
    row = [*state, *desired.positions, *desired.speeds, *desired.accelerations]
    found = numbers(asked(folder, lines([row]), "step")[1])[0]
    np.testing.assert_array_equal(found[1:3], np.clip(want, -limits, limits))


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (("five_bar", "psp3", "--out", "f"), "five_bar is a robot: leave out psp3"),
        (("five_bar", "--torque-limit", "1", "--out", "f"), "five_bar, which is not a controller"),
        (("x.json", "--actuated", "a", "--out", "f"), "--actuated is an option of a robot"),
        (("nobody", "--out", "f"), "nobody"),
        (("missing.fis", "--out", "f"), "missing.fis: no such file"),
        (("missing.json", "--out", "f"), "missing.json: no such file"),
        (("five_bar", "--out", "no/where"), "there is no directory no"),
        (("five_bar", "--out", "file"), "file is not a directory"),
        (("five_bar",), "Missing option '--out'"),
        (("five_bar", "--out", "f", "--name", "main"), "name must be none of calls"),
        (("five_bar", "--out", "f", "--precision", "half"), "'half' is not one of"),
    ],
)
def test_what_is_refused(psp3_command: Run, given: tuple[str, ...], message: str) -> None:
    Path("file").touch()
    answer = psp3_command("export", "c", *given)
    assert (answer.status, answer.out) == (2, "")
    assert message in words(answer.err)
    assert not Path("f").exists()


def test_group_alone_names_its_commands(psp3_command: Run) -> None:
    answer = psp3_command("export")
    assert answer.status == 2
    assert "c or fmu" in answer.err
