"""A folder that ``write_project`` wrote, made and run as its user does."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest

from tests.processes import ENVIRONMENT

REQUIRED = os.environ.get("REQUIRED_CLIENTS", "").split()

STRICT = "-O2 -Werror"
SANITIZED = (
    "-g -O0 -Werror -fsanitize=address,undefined,float-cast-overflow -fno-sanitize-recover=all"
)


def needs(client: str, *tools: str) -> pytest.MarkDecorator:
    """Skip a test where tools are missing, but not where all of a client's tests must run."""
    missing = [tool for tool in tools if shutil.which(tool) is None]
    reason = f"not installed: {', '.join(missing)} (apt-get install {client})"
    return pytest.mark.skipif(bool(missing) and client not in REQUIRED, reason=reason)


needs_c = needs("gcc", "gcc", "make")
needs_clang = needs("clang", "clang", "make")
needs_cppcheck = needs("cppcheck", "cppcheck")


def make(folder: Path, *words: str, flags: str = STRICT) -> str:
    """Run make, and return what it prints; another status than 0 is an error."""
    done = subprocess.run(
        ["make", "-C", str(folder), f"CFLAGS={flags}", *words],
        env=ENVIRONMENT,
        capture_output=True,
        encoding="utf-8",
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def asked(folder: Path, text: str, *words: str) -> tuple[int, str, str]:
    """Return status, output and errors of ``main`` for lines."""
    done = subprocess.run(
        [str(folder / "main"), *words], input=text, capture_output=True, encoding="utf-8"
    )
    return done.returncode, done.stdout, done.stderr


def lines(rows: Iterable[Iterable[float]]) -> str:
    """Return rows of numbers as lines that lose nothing."""
    return "".join(" ".join(repr(float(number)) for number in row) + "\n" for row in rows)


def numbers(text: str) -> np.ndarray:
    """Return lines of numbers as rows."""
    return np.array([line.split() for line in text.splitlines()], dtype=float)


def check_statically(folder: Path) -> None:
    """Run cppcheck over all files with code; anything that it says is an error.

    ``cases.c`` has tables of numbers alone, and takes it longer than all the others.
    """
    sources = sorted(path for path in folder.rglob("*.c") if path.name != "cases.c")
    assert sources
    done = subprocess.run(
        [
            *("cppcheck", "--std=c99", "--error-exitcode=1", "--quiet"),
            *("--enable=warning,performance,portability", *map(str, sources)),
        ],
        capture_output=True,
        encoding="utf-8",
    )
    assert done.returncode == 0, done.stderr
