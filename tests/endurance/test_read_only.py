"""On a file system that cannot be written, what saves says so, and what reads works."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fuzzy2
import psp3
from fuzzy2.errors import FileNotWritten
from psp3.benchmark import Benchmark
from psp3.errors import StudyFileNotWritable
from psp3.thesis.replication import reproduce
from psp3.visualize import Scene

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def read_only(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Return a folder of a file system that is mounted to be read, with one file in it."""
    folder = tmp_path_factory.mktemp("read_only")
    if shutil.which("mount") is None:
        pytest.skip("mount is not installed")
    mounted = subprocess.run(["mount", "-t", "tmpfs", "tmpfs", folder], capture_output=True)
    if mounted.returncode != 0:
        pytest.skip("file systems can be mounted by root alone")
    try:
        fuzzy2.save(fuzzy2.Gaussian(0.0, 1.0), folder / "there.json")
        subprocess.run(["mount", "-o", "remount,ro", folder], check=True)
        yield folder
    finally:
        subprocess.run(["umount", "--lazy", folder], check=True)


def system() -> fuzzy2.Type1System:
    sets = [fuzzy2.Gaussian(0.0, 1.0), fuzzy2.Gaussian(1.0, 1.0)]
    return fuzzy2.Type1System([sets], [[0], [1]], [[0.0], [1.0]])


def result() -> psp3.Result:
    robot = psp3.load("psp3")
    return psp3.simulate(robot, psp3.PD(), psp3.trajectories.Helix(robot=robot), 0.02)


def controller() -> Any:
    robot = psp3.load("psp3")
    return psp3.FuzzyComputedTorque("t1", robot).fit(psp3.trajectories.Helix(robot=robot), 0.5)


def pose_map() -> Any:
    grid = {"x": np.linspace(-0.1, 0.1, 3), "z": np.linspace(0.2, 0.3, 3)}
    return psp3.Workspace(psp3.load("five_bar"), "tip", ("x", "z")).map(grid)


SAVES: dict[str, Callable[[Path], object]] = {
    "system.json": lambda path: fuzzy2.save(system(), path),
    "system.fis": lambda path: fuzzy2.save(system(), path),
    "system.fml": lambda path: fuzzy2.save(system(), path),
    "there.json": lambda path: fuzzy2.save(system(), path),
    "result.npz": lambda path: result().save(path),
    "controller.json": lambda path: controller().save(path),
    "map.json": lambda path: pose_map().save(path),
    "scene.html": lambda path: Scene(psp3.load("five_bar")).write_html(path),
    "benchmark": lambda path: Benchmark(path, ["lqr"], ["psp3"], seeds=1, duration=0.1).run(1),
    "reproduced": lambda path: reproduce(path, quick=True),
    "study.sqlite": lambda path: psp3.Study(path, [psp3.Run("ctc", duration=0.02)]).run(1),
}


@pytest.mark.parametrize("name", SAVES)
def test_whatever_saves_says_that_it_cannot(name: str, read_only: Path) -> None:
    path = read_only / name
    with pytest.raises((FileNotWritten, StudyFileNotWritable), match="read-only") as refused:
        SAVES[name](path)
    assert str(path) in str(refused.value)
    assert [one.name for one in read_only.iterdir()] == ["there.json"]


def test_what_is_there_is_read(read_only: Path) -> None:
    assert fuzzy2.load(read_only / "there.json")(0.0) == 1.0
