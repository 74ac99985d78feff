"""``psp3 warm-up``."""

from __future__ import annotations

import logging
from pathlib import Path

import pytest

from fuzzy2.support.code_folder import code_folder
from tests.psp3.cli.answers import Run


def test_it_compiles_all_and_says_where_the_code_is(
    psp3_command: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """What compiles all has tests of its own."""
    module, done = logging.getLogger("psp3.warm_up"), []

    def compile_all() -> None:
        module.info("compiling fuzzy systems")
        done.append(True)

    monkeypatch.setattr("psp3.warm_up.warm_up", compile_all)
    assert psp3_command("warm-up") == (0, f"{code_folder()}\n", "compiling fuzzy systems\n")
    assert done == [True]
    assert (module.level, module.handlers) == (logging.NOTSET, [])
