"""What commands compile: nothing for one-off questions, and else it is told."""

from __future__ import annotations

import io
import json
import subprocess
import sys
from pathlib import Path

import pytest

from fuzzy2.support.announcements import Compilation
from psp3.cli import compilation
from psp3.cli.compilation import compilation_shown
from tests.processes import ENVIRONMENT

ONE_OFF = (
    "info",
    "info gough_stewart",
    "check five_bar",
    "pose --tip 0.01,0,0.07",
    "pose --heights -0.6,0,0.6",
    "pose gough_stewart",
    "pose delta --positions 9,9,9",
    "dynamics --heights 0,0.01,0 --speeds 1,0,0",
    "dynamics tricept",
)

COUNTED = """
import contextlib, io, json, sys
from numba.core import event
from psp3.cli import entry

class Counter(event.Listener):
    def on_start(self, event):
        compiled.append(event.data["dispatcher"].py_func.__name__)
    def on_end(self, event):
        pass

compiled, found = [], {}
event.register("numba:compile", Counter())
for command in json.loads(sys.argv[1]):
    sys.argv = ["psp3", *command.split()]
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        try:
            entry.main()
        except SystemExit as end:
            found[command] = end.code, len(compiled)
print(json.dumps(found))
"""


@pytest.mark.slow
def test_one_off_commands_compile_nothing(tmp_path: Path) -> None:
    """With an empty cache, as after ``pip install``; refused poses take the same way."""
    done = subprocess.run(
        [sys.executable, "-c", COUNTED, json.dumps(ONE_OFF)],
        env={**ENVIRONMENT, "NUMBA_CACHE_DIR": str(tmp_path / "cache")},
        capture_output=True,
        encoding="utf-8",
        check=True,
    )
    found = json.loads(done.stdout)
    refused = {"pose --heights -0.6,0,0.6", "pose delta --positions 9,9,9"}
    assert found == {one: [2 if one in refused else 0, 0] for one in ONE_OFF}
    assert not list(tmp_path.rglob("*.nb?"))


class Terminal(io.StringIO):
    """Where a person reads along."""

    def isatty(self) -> bool:
        """Return that it is one."""
        return True


def test_a_long_compilation_is_told_with_its_progress(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """On a terminal in a line that is gone at last, and else in one line and no more."""
    coming = Compilation("psp3.multibody.motion.answer", 14.3)
    with compilation_shown(coming):
        pass
    told = "compiling once, about 14 s: psp3.multibody.motion.answer\n"
    assert capsys.readouterr() == ("", told)
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr(compilation, "REDRAWN", 0.0)
    with compilation_shown(coming):
        while "%" not in terminal.getvalue():
            pass
    assert terminal.getvalue().startswith(told + "\r0%")
    assert terminal.getvalue().endswith("\r  \r")
