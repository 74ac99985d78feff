"""The stamp: what a trial runs is in it, and every byte of that changes it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from psp3.benchmark import stamp
from tests.processes import ENVIRONMENT

RUNS = """
import sys
from psp3.benchmark.baselines import BASELINES
from psp3.benchmark.trial import Trial, execute
for robot in ("psp3", "delta"):
    for name in ("lqr", "gt2-average", "adaptive", "anfis"):
        execute(Trial(robot, "outputs", 20.0, 0, 0.04), BASELINES[name])
for name, module in sys.modules.items():
    if name.partition(".")[0] in ("psp3", "fuzzy2") and module.__file__:
        print(module.__file__)
"""


@pytest.mark.slow
def test_every_module_that_a_trial_loads_is_in_the_stamp() -> None:
    """In a Python of its own, of what the packages load themselves."""
    found = subprocess.run(
        [sys.executable, "-c", RUNS], env=ENVIRONMENT, capture_output=True, text=True, check=True
    )
    loaded = {Path(line) for line in found.stdout.split()}
    assert len(loaded) > 50
    assert loaded <= set(stamp.sources().values())


def test_files_of_the_three_robots_are_in_the_stamp_and_pages_are_not() -> None:
    names = set(stamp.sources())
    assert {"urdf/psp3.urdf", "urdf/delta.yaml", "urdf/gough_stewart.srdf"} <= names
    assert not names & {"psp3/benchmark/page.py", "psp3/cli/entry.py", "fuzzy2/plots/style.py"}


def test_a_changed_byte_and_a_new_name_change_the_stamp(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "one.py").write_text("a = 1\n", "utf-8")
    found = []
    for name, text in (("one.py", "a = 1\n"), ("one.py", "a = 2\n"), ("two.py", "a = 2\n")):
        (tmp_path / "one.py").write_text(text, "utf-8")
        there = {name: tmp_path / "one.py"}
        monkeypatch.setattr(stamp, "sources", there.copy)
        found.append(stamp.stamp.__wrapped__())
    assert len(set(found)) == 3
