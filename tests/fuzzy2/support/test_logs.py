"""What modules log: names of others in it do nothing to a terminal."""

from __future__ import annotations

import logging
from pathlib import Path

import pytest

from fuzzy2.support.logs import logger_named

ROOT = Path(__file__).resolve().parents[3]


def test_messages_are_printable(caplog: pytest.LogCaptureFixture) -> None:
    logger_named("fuzzy2.tried").warning("%s of %d", "a\x1b[2J\r", 3)
    logger_named("fuzzy2.tried").warning("100 %")
    assert [record.getMessage() for record in caplog.records] == [r"a\x1b[2J\x0d of 3", "100 %"]


def test_a_logger_that_is_asked_for_twice_is_one() -> None:
    assert logger_named("fuzzy2.tried") is logger_named("fuzzy2.tried")
    assert len(logging.getLogger("fuzzy2.tried").filters) == 1


@pytest.mark.parametrize("root", ["fuzzy2", "psp3"])
def test_every_warning_goes_through_it(root: str) -> None:
    for path in sorted((ROOT / root).rglob("*.py")):
        source = path.read_text(encoding="utf-8")
        if path.name != "logs.py" and "logger.warning" in source:
            assert "logger = logger_named(__name__)" in source, path
