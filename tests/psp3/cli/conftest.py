"""The command line, run by the tests in their own process."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from psp3.cli import entry as cli
from tests.processes import ENVIRONMENT
from tests.psp3.cli.answers import Answer, Run


@pytest.fixture
def psp3_command(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> Run:
    """Run the command line in this process, in an empty directory, in 80 columns."""
    monkeypatch.chdir(tmp_path)
    for name in ("COLUMNS", "NO_COLOR", "TERM"):
        monkeypatch.setenv(name, ENVIRONMENT[name])

    def run(*arguments: object) -> Answer:
        monkeypatch.setattr(sys, "argv", ["psp3", *map(str, arguments)])
        with pytest.raises(SystemExit) as end:
            cli.main()
        assert isinstance(end.value.code, int)
        return Answer(end.value.code, *capsys.readouterr())

    return run
