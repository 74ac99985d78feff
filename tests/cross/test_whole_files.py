"""Whatever writes a file of either package leaves the old one whole when it fails."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

import fuzzy2
import psp3
from fuzzy2.files.fis import write_fis
from fuzzy2.files.fml import write_fml
from psp3.cli.output import draw_figure, write_csv
from psp3.kinematics.workspace import Workspace
from psp3.thesis.findings import Reproduction
from psp3.thesis.report import write_report
from psp3.visualize import Scene

OLD = "what was there before"


def system() -> fuzzy2.Type1System:
    terms = {"Low": fuzzy2.Gaussian(0.0, 1.0), "High": fuzzy2.Gaussian(1.0, 1.0)}
    return fuzzy2.Type1System({"x": terms}, [[0], [1]], [[0.0], [1.0]], input_ranges=[(0.0, 1.0)])


def save_result(path: Path) -> None:
    robot = psp3.load("psp3")
    psp3.simulate(robot, psp3.PD(), psp3.trajectories.Hold(robot=robot), 0.01).save(path)


def save_map(path: Path) -> None:
    space = Workspace(psp3.load("five_bar"), "tip", ("x", "z"))
    space.map({"x": np.array([0.0, 0.01]), "z": np.array([-0.3, -0.29])}).save(path)


def save_controller(path: Path) -> None:
    robot = psp3.load("psp3")
    controller = psp3.FuzzyComputedTorque("t1", robot)
    controller.fit(psp3.trajectories.Helix(robot=robot)).save(path)


def export_study(path: Path) -> None:
    study = psp3.Study(path.with_name("study.sqlite"), [psp3.Run("pd", duration=0.1)])
    study.run()
    study.export(path)


WRITERS: dict[str, Callable[[Path], object]] = {
    "set.json": lambda path: fuzzy2.save(fuzzy2.Gaussian(0.0, 1.0), path),
    "system.fis": lambda path: write_fis(system(), path),
    "system.fml": lambda path: write_fml(system(), path),
    "result.npz": save_result,
    "map.json": save_map,
    "controller.json": save_controller,
    "study.csv": export_study,
    "columns.csv": lambda path: write_csv(path, {"t": np.zeros(3)}),
    "figure.png": lambda path: draw_figure(path, lambda: (Figure().subplots(),)),
    "figure.svg": lambda path: draw_figure(path, lambda: (Figure().subplots(),)),
    "scene.html": lambda path: Scene(psp3.load("psp3")).write_html(path),
    "report.html": lambda path: write_report(Reproduction(), path),
}


@pytest.mark.parametrize("name", WRITERS)
def test_a_writer_that_fails_leaves_the_old_file_and_nothing_else(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Names that writers of whole files like to take for their own.
    others = {f"{name}.part", f".{name}.part", f"{name}.tmp", f"{name}~"}
    path = tmp_path / name
    for entry in (path, *(tmp_path / other for other in others)):
        entry.write_text(OLD)

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    def written() -> set[str]:
        return {entry.name for entry in tmp_path.iterdir()} - {"study.sqlite"}

    with monkeypatch.context() as patch:
        patch.setattr("os.fsync", full)
        with pytest.raises(OSError, match="No space left on device") as caught:
            WRITERS[name](path)
    assert caught.value.filename == str(path)
    assert path.read_text() == OLD
    assert written() == {name, *others}

    WRITERS[name](path)
    assert OLD.encode() not in path.read_bytes()
    assert written() == {name, *others}
    assert all((tmp_path / other).read_text() == OLD for other in others)
