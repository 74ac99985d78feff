"""``psp3 export fmu``: an FMU, and what it says of it."""

from __future__ import annotations

import shutil
import zipfile
from pathlib import Path

import pytest

import psp3
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
    assert "t1.fmu holds source code alone" in answer.out
    assert "there is no gcc" in words(answer.err)
    with zipfile.ZipFile("t1.fmu") as archive:
        assert "sources/law.c" in archive.namelist()


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
