"""In a locale whose decimal sign is a comma, numbers are read and written as anywhere else."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.processes import ENVIRONMENT, ROOT

WORK = """
import hashlib, locale, sys
from pathlib import Path
import numpy as np
import fuzzy2, psp3

if sys.argv[1] != "C":
    locale.setlocale(locale.LC_ALL, sys.argv[1])
    assert locale.localeconv()["decimal_point"] == ","
    assert locale.format_string("%.1f", 0.5) == "0,5"
robot = psp3.load("delta")
text = [psp3.to_mjcf(robot)]
for name in ("psp3", "delta", "five_bar", "hexa"):
    other = psp3.load(name)
    speeds = np.full(len(other.coordinates_v), 0.5)
    text.append(repr(other.inverse_dynamics(other.reference, speeds, speeds)))
sets = {"low": fuzzy2.Triangular(-1.5, 0.0, 1.5), "high": fuzzy2.Triangular(0.5, 1.0, 1.5)}
system = fuzzy2.Type1System(
    {"a": sets, "b": sets},
    "IF a is low AND b is low THEN y is low\\nIF a is high THEN y is high WITH 0.25",
    {"y": sets},
    type_reduction="centroid",
    input_ranges=[(0.0, 1.5)] * 2,
    output_ranges=[(0.0, 1.5)],
)
integration = {
    "fis": {"integration": "sum", "resolution": 101},
    "fll": {"integration": "midpoint", "resolution": 100},
}
for ending in ("json", "fis", "fll", "fcl", "fml"):
    path = Path(f"system.{ending}")
    fuzzy2.save(system.replace(**integration.get(ending, {})), path)
    text += [path.read_text(), repr(fuzzy2.load(path)([0.25, 0.75]))]
motion = psp3.trajectories.Helix()
result = psp3.simulate(psp3.load("psp3"), psp3.PD(), motion, 0.02)
rows = ["t,a1,a2,a3", "0.0,0.15,0.25,0.2", "0.5,0.2,0.2,0.2", "1.0,0.1,0.2,0.2", "2.0,0.1,0.2,0.25"]
Path("motion.csv").write_text("\\n".join(rows))
text.append(repr(psp3.trajectories.FromCSV("motion.csv")(np.array([0.3]))))
text.append(repr(result.positions[-1]))
print(hashlib.sha256("".join(text).encode()).hexdigest())
"""


@pytest.fixture(scope="module")
def german(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the locale de_DE, made here: few machines have it."""
    folder = tmp_path_factory.mktemp("locales")
    if shutil.which("localedef") is None:
        pytest.skip("localedef is not installed")
    command = ["localedef", "-i", "de_DE", "-f", "UTF-8", str(folder / "de_DE.UTF-8")]
    if subprocess.run(command, capture_output=True).returncode != 0:
        pytest.skip("the source of the locale de_DE is not installed")
    return folder


@pytest.mark.slow
def test_numbers_have_points(german: Path, tmp_path: Path) -> None:
    found = []
    for name in ("C", "de_DE.UTF-8"):
        environment = {**os.environ, **ENVIRONMENT, "LOCPATH": str(german), "LC_ALL": name}
        folder = tmp_path / name
        folder.mkdir()
        command = [sys.executable, "-c", WORK, name]
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        found.append(done.stdout)
    assert found[0] == found[1]


@pytest.mark.slow
def test_the_command_line_writes_points(german: Path, tmp_path: Path) -> None:
    found = []
    for name in ("C", "de_DE.UTF-8"):
        environment = {**os.environ, **ENVIRONMENT, "LOCPATH": str(german), "LC_ALL": name}
        command = [sys.executable, "-m", "psp3.cli.entry", "dynamics", "psp3"]
        done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        found.append(done.stdout)
    assert found[0] == found[1]
