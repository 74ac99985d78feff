"""What is in a file is told by its content, and everything gets its folder."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import fuzzy2
import psp3
from fuzzy2.errors import NotExportable
from psp3.errors import UnknownRobot
from psp3.export.project import export_project, identifier, opened
from tests.project_folder import (
    SANITIZED,
    asked,
    check_statically,
    make,
    needs_c,
    needs_clang,
    needs_cppcheck,
)
from tests.psp3.export.robots_of_all_kinds import MAKERS

URDF = Path(psp3.__file__).parent / "urdf"


def controller(name: str) -> Any:
    """Return a controller that remembers, or one that learned."""
    robot = psp3.load("psp3")
    if name == "pid":
        return psp3.PID(kp=10.0, kv=1.0, ki=2.0)
    if name == "exact":
        return psp3.ComputedTorque(psp3.load("delta"), kp=100.0, kv=20.0)
    helix = psp3.trajectories.Helix(robot=robot)
    return psp3.FuzzyComputedTorque("it2", robot, learner="average", snr_db=20.0).fit(helix)


def test_files_are_told_apart_by_what_is_in_them(tmp_path: Path) -> None:
    system = fuzzy2.Type1System([[fuzzy2.Gaussian(0.0, 1.0)]], [[0]], [[1.0]])
    (tmp_path / "system.xml").write_text("<!-- <robot> --> <fuzzySystem name='s'/>")
    fuzzy2.save(system, tmp_path / "system.json")
    controller("it2").save(tmp_path / "trained.json")
    assert opened("delta").title == psp3.load("delta").title
    assert opened(URDF / "five_bar.urdf").actuated == psp3.load("five_bar").actuated
    assert isinstance(opened(URDF / "gripper.xml"), psp3.ClosedLoopRobot)
    assert isinstance(opened(tmp_path / "system.json"), fuzzy2.Type1System)
    assert isinstance(opened(tmp_path / "trained.json"), psp3.FuzzyComputedTorque)
    with pytest.raises(UnknownRobot, match="five_bar"):
        opened("nobody")
    # It goes to the reader of FML, which names what it lacks.
    with pytest.raises(fuzzy2.errors.MalformedFile, match=r"system\.xml"):
        opened(tmp_path / "system.xml")


@pytest.mark.parametrize(
    ("source", "name"),
    [("delta", "delta"), ("a/my-rules.v2.fis", "my_rules_v2"), ("3psp.json", "code_3psp")],
)
def test_names_in_c(source: str, name: str) -> None:
    assert identifier(source) == name


@needs_c
@pytest.mark.parametrize("name", ["pid", "exact", "it2"])
@pytest.mark.parametrize("precision", ["double", "single"])
def test_folders_of_controllers_pass_their_test(tmp_path: Path, name: str, precision: Any) -> None:
    options = {"robot": psp3.load("psp3")} if name == "pid" else {}
    export_project(controller(name), tmp_path, precision=precision, **options)
    said = make(tmp_path, "test")
    assert "passed" in said
    # The C library is Python's own.
    assert precision == "single" or "others are at most 0.0e+00" in said


@needs_c
@pytest.mark.slow
@pytest.mark.parametrize("name", ["psp3", "five_bar", "delta", "gripper", "biped"])
@pytest.mark.parametrize("precision", ["double", "single"])
def test_folders_of_robots_pass_their_test(tmp_path: Path, name: str, precision: Any) -> None:
    export_project(psp3.load(name), tmp_path, precision=precision, name=name)
    said = make(tmp_path, "test")
    assert "passed" in said
    assert precision == "single" or "others are at most 0.0e+00" in said


@needs_c
@pytest.mark.slow
def test_folder_of_a_robot_near_singular_poses_passes_its_test(tmp_path: Path) -> None:
    """Some of its cases are so near that one rounding moves an answer by more than a share."""
    export_project(MAKERS["rod"](tmp_path), tmp_path / "rod", precision="single", name="rod")
    assert "passed" in make(tmp_path / "rod", "test")


@needs_c
@pytest.mark.slow
@pytest.mark.parametrize("thing", ["delta", "pid"])
def test_sanitizers_have_nothing_to_say(tmp_path: Path, thing: str) -> None:
    robot = psp3.load(thing if thing == "delta" else "psp3")
    if thing == "delta":
        export_project(robot, tmp_path)
    else:
        export_project(controller(thing), tmp_path, robot=robot)
    make(tmp_path, flags=SANITIZED)
    assert "passed" in make(tmp_path, "test", flags=SANITIZED)
    text = "0.1 0.2\n" if thing == "delta" else "reset\n1\n"
    assert "Sanitizer" not in asked(tmp_path, text)[2]


@pytest.mark.slow
@needs_clang
@needs_cppcheck
@pytest.mark.parametrize("precision", ["double", "single"])
def test_other_compilers_and_cppcheck_have_nothing_to_say(tmp_path: Path, precision: Any) -> None:
    export_project(psp3.load("delta"), tmp_path, precision=precision)
    make(tmp_path, "CC=clang")
    assert "passed" in make(tmp_path, "CC=clang", "test")
    check_statically(tmp_path)


def test_what_has_no_c_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    with pytest.raises(NotExportable):
        export_project(object(), tmp_path / "there")
    assert not (tmp_path / "there").exists()
