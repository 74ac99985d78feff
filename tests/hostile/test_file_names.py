"""Odd names of files on the command line: each is read and written under this name alone."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

import psp3
from fuzzy2.errors import printable
from psp3.benchmark import benchmark
from tests.psp3.benchmark.made import outcome_of
from tests.psp3.cli.answers import Run

FIVE_BAR = Path(psp3.__file__).parent / "urdf" / "five_bar"

NAMES = (
    b'-dash a b it\'s "q"',
    b"--help",
    b"new\nline not\xffutf8",
    b"esc\x1b[31m bell\x07\r \xe2\x80\xaeback",
    rb"[bold]x[red] :smile: $\foo$ %s{x};$(true) #part?q=1&r=*",
    b"x" * 200,
)
"""Each for the shell, for options, for lines, for terminals, for markup, and for the disk."""


ENTRY = """
class Nothing:
    def fit(self, X, Y):
        self.width = Y.shape[1]

    def predict(self, X):
        return [[0.0] * self.width] * len(X)
"""


@pytest.fixture(autouse=True)
def no_trials(monkeypatch: pytest.MonkeyPatch) -> None:
    """Learn nothing, and track nothing: here it is about names."""
    outcome = outcome_of({"trained": 1e-3, "untrained": 2e-3})
    monkeypatch.setattr(benchmark, "execute", lambda *_: outcome)


@pytest.mark.slow
@pytest.mark.parametrize("raw", NAMES, ids=repr)
def test_files_are_read_and_written_under_their_names(
    psp3_command: Run, tmp_path: Path, raw: bytes
) -> None:
    name = os.fsdecode(raw)
    robot = [f"{name}{end}" for end in (".urdf", ".yaml")]
    for end in (".urdf", ".yaml", ".srdf"):
        shutil.copy(FIVE_BAR.with_suffix(end), tmp_path / f"{name}{end}")
    (tmp_path / f"{name}.py").write_text(ENTRY)
    outputs = [f"--figure={name}.svg", f"--csv={name}.csv", f"--out={name}.npz"]
    answers = [
        psp3_command("simulate", "--duration=0.02", *outputs, "--", *robot),
        psp3_command("view", f"--record={name}.html", f"--result={name}.npz", "--", *robot),
        psp3_command("check", "--", *robot),
        psp3_command("check", "--json", "--", *robot),
        psp3_command("benchmark", "--robot=delta", f"--out={name}", "--", f"{name}.py"),
    ]
    assert [answer.status for answer in answers] == [0] * len(answers)
    missing = psp3_command("info", "--", f"{name} is not there.urdf")
    assert missing.status == 2
    assert printable(name).replace("\n", " ") in missing.err
    for answer in (*answers, missing):
        assert printable(answer.out + answer.err) == answer.out + answer.err
    found = {os.fsencode(path.name) for path in tmp_path.iterdir()}
    ends = ("", ".urdf", ".yaml", ".srdf", ".svg", ".csv", ".npz", ".html", ".py")
    assert found == {raw + end.encode() for end in ends}
    assert {path.name for path in (tmp_path / name).iterdir()} >= {"benchmark.html"}
