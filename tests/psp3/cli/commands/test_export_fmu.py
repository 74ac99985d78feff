"""``psp3 export fmu``: an FMU, and what it says of it."""

from __future__ import annotations

import shutil
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import pytest

import fuzzy2
import psp3
from psp3.description.parts import ROBOT_FILES
from psp3.export import fmu
from tests.psp3.cli.answers import Run, words


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("gcc") is None, reason="there is no gcc")
def test_robot_from_its_name(psp3_command: Run) -> None:
    answer = psp3_command("export", "fmu", "five_bar", "--out", "mine.fmu", "--period", 0.001)
    assert answer.status == 0
    assert "inputs: force_leg1_shoulder, force_leg2_shoulder\n" in answer.out
    assert answer.out.endswith(
        "mine.fmu holds source code and a binary; steps are multiples of 0.001 s\n"
    )
    with zipfile.ZipFile("mine.fmu") as archive:
        assert "binaries/linux64/mine.so" in archive.namelist()


def copied(name: str, folder: Path) -> None:
    """Copy a robot's files, the loops under another name."""
    shutil.copy(ROBOT_FILES / f"{name}.urdf", folder / "mine.urdf")
    shutil.copy(ROBOT_FILES / f"{name}.yaml", folder / "closed.yaml")


def parameters(path: str) -> dict[str, float]:
    """Return the first values of an FMU's parameters by their names."""
    with zipfile.ZipFile(path) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    found = [one for one in root.iter() if one.get("causality") == "parameter"]
    return {
        one.attrib["name"]: float((one if one.get("start") else one[0]).attrib["start"])
        for one in found
    }


@pytest.mark.slow
def test_robot_of_files_with_drives_and_limits_is_that_of_python(
    psp3_command: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same options as of other commands; the same FMU as from Python, to the last byte."""
    monkeypatch.setattr(fmu.shutil, "which", lambda _: None)
    copied("five_bar", Path())
    motors = "leg2_shoulder,leg1_shoulder"
    answer = psp3_command(
        *("export", "fmu", "mine.urdf", "--loops", "closed.yaml", "--actuated", motors),
        *("--out", "cli.fmu", "--name", "mine", "--fmi", "3.0", "--torque-limit", "1.5,2"),
        *("--coulomb-friction", "0.05", "--viscous-friction", "0.1,0.2", "--steps", 2),
        *("--motor-inertia", "1e-5", "--lead", "0.5,0.6"),
    )
    assert answer.status == 0
    assert "inputs: force_leg2_shoulder, force_leg1_shoulder\n" in answer.out
    limits = {"largest_force_leg2_shoulder": 1.5, "largest_force_leg1_shoulder": 2.0}
    assert parameters("cli.fmu").items() >= limits.items()
    robot = psp3.load("mine.urdf", loops="closed.yaml", actuated=tuple(motors.split(",")))
    drives = [psp3.Drive(0.05, 0.1, 1e-5, 0.5), psp3.Drive(0.05, 0.2, 1e-5, 0.6)]
    options = {"steps": 2, "torque_limit": [1.5, 2.0], "name": "mine"}
    with pytest.warns(fmu.SourceOnlyFMU):
        psp3.export_fmu(robot, "api.fmu", version="3.0", drive=drives, **options)
    assert Path("cli.fmu").read_bytes() == Path("api.fmu").read_bytes()


@pytest.mark.slow
def test_controller_of_a_robot_from_files(
    psp3_command: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fmu.shutil, "which", lambda _: None)
    copied("five_bar", Path())
    options = {"loops": "closed.yaml", "actuated": ("leg1_shoulder", "leg2_shoulder")}
    robot = psp3.load("mine.urdf", **options)
    controller = psp3.FuzzyComputedTorque("t1", robot, learner="average")
    controller.fit(psp3.trajectories.Sway(robot=robot), 1.5).save("trained.json")
    answer = psp3_command(
        *("export", "fmu", "trained.json", "mine.urdf", "--loops", "closed.yaml"),
        *("--actuated", "leg1_shoulder,leg2_shoulder", "--out", "control.fmu"),
    )
    assert answer.status == 0
    assert "outputs: force_leg1_shoulder, force_leg2_shoulder" in answer.out


@pytest.mark.slow
def test_trained_controller_from_its_file(
    psp3_command: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fmu.shutil, "which", lambda _: None)
    robot = psp3.load("psp3")
    psp3.FuzzyComputedTorque("t1", robot).fit(psp3.trajectories.Helix()).save("t1.json")
    answer = psp3_command("export", "fmu", "t1.json", "--out", "t1.fmu", "--name", "law")
    assert answer.status == 0
    assert "outputs: force_a1, force_a2, force_a3" in answer.out
    assert "t1.fmu holds only source code" in answer.out
    assert "there is no gcc" in words(answer.err)
    with zipfile.ZipFile("t1.fmu") as archive:
        assert "sources/code_law.c" in archive.namelist()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (("five_bar", "delta"), "five_bar is a robot: leave out delta"),
        (("x.json", "--free", "keep"), "--free is an option of a robot: give the robot of x.json"),
        (("delta", "--torque-limit", "1,2"), "--torque-limit 1,2 has 2 numbers; 3 are needed"),
        (("delta", "--torque-limit", "-1"), "is not a list of positive numbers"),
        (("delta", "--motor-inertia", "1"), "lead must be given where the motor has inertia"),
        (("delta", "--coulomb-friction", "-1"), "--coulomb-friction must be"),
        (("delta", "--fmi", "1.0"), "'1.0' is not one of"),
        (("delta", "--actuated", "nobody"), "the robot has no joint 'nobody'"),
        (("psp3", "--free", "lock"), "--free does not apply to the 3-PSP"),
        (("rules.fis",), "rules.fis: no such file"),
        (("system.json", "--steps", "2"), "--steps does not apply to system.json, which is no"),
        (("system.json",), "it is no model"),
        (("system.json", "psp3"), "ROBOT is for controllers, but system.json is not a controller"),
    ],
)
def test_what_is_refused(psp3_command: Run, given: tuple[str, ...], message: str) -> None:
    rules = "IF a is low THEN b is small"
    terms = {"a": {"low": fuzzy2.Gaussian(0.0, 1.0)}}
    fuzzy2.save(fuzzy2.Type1System(terms, rules, {"b": {"small": 1.0}}), "system.json")
    answer = psp3_command("export", "fmu", *given, "--out", "x.fmu")
    assert (answer.status, answer.out) == (2, "")
    assert message in words(answer.err)
    assert not Path("x.fmu").exists()


def test_mistakes_are_said_in_one_line(psp3_command: Run) -> None:
    answer = psp3_command("export", "fmu", "five_bar")
    assert (answer.status, answer.out) == (2, "")
    assert "Missing option '--out'" in answer.err
    answer = psp3_command("export", "fmu", "five_bar", "--out", "no_folder/x.fmu")
    assert "there is no directory no_folder" in answer.err
    answer = psp3_command("export", "fmu", "five_bar", "--out", "x.txt")
    assert "x.txt: the name of an FMU must end in .fmu" in answer.err
    assert not Path("x.txt").exists()
    answer = psp3_command("export", "fmu", "five_bar", "--out", "x.fmu", "--name", "3 PSP")
    assert "identifier of C" in answer.err
    assert not Path("x.fmu").exists()
