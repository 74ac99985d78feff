"""fuzzylite evaluates what is written, and what it writes itself is evaluated here.

Files of FLL go through pyfuzzylite, which does not know FIS; those of FIS through the program of
version 6, which Debian has as ``fuzzylite``. pyfuzzylite asks for an older NumPy than we do, but
works with ours; so it is in no extra, and ``pip install --no-deps pyfuzzylite`` adds it. Its
examples come with it. It sums over points as we
do then, so that both agree to rounding; only Tsukamoto's points of grades near 1 magnify that.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from fuzzy2 import ParallelSystem, Type1System
from fuzzy2.files.fis import parse_fis, read_fis, write_fis
from fuzzy2.files.fll import format_fll, parse_fll, read_fll
from tests.fuzzy2.files.engines import CHAIN, FORMULAS, HYBRID, TERMS, TSUKAMOTO, inputs_of
from tests.fuzzy2.files.fis_texts import TIPPER

REQUIRED = "fuzzylite" in os.environ.get("REQUIRED_CLIENTS", "").split()
if REQUIRED:
    import fuzzylite
else:
    fuzzylite = pytest.importorskip(
        "fuzzylite", reason="pyfuzzylite is not installed (pip install --no-deps pyfuzzylite)"
    )

EXAMPLES = sorted((Path(fuzzylite.__file__).parent / "examples").rglob("*.fll"))


def answers(text: str, X: np.ndarray) -> np.ndarray:
    """Return the outputs (n, m) of an engine of fuzzylite."""
    engine = fuzzylite.FllImporter().from_string(text)
    engine.input_values = X
    engine.process()
    return np.asarray(engine.output_values, dtype=float).reshape(len(X), -1)


def compare(system: Type1System | ParallelSystem, text: str, X: np.ndarray) -> None:
    with np.errstate(all="ignore"):
        want = answers(text, X)
    np.testing.assert_allclose(system(X), want, rtol=1e-8, atol=1e-8, equal_nan=True)


@pytest.mark.parametrize("text", [HYBRID, CHAIN, TSUKAMOTO, TERMS, FORMULAS], ids="hcstf")
def test_our_engines(text: str) -> None:
    system = parse_fll(text)
    compare(system, text, inputs_of(system))
    compare(system, format_fll(system), inputs_of(system))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_its_examples(path: Path) -> None:
    system = read_fll(path)
    X = inputs_of(system, 50)
    compare(system, path.read_text(encoding="utf-8"), X)
    compare(system, format_fll(system), X)


def test_there_are_examples() -> None:
    assert len(EXAMPLES) > 50


needs_the_program = pytest.mark.skipif(
    shutil.which("fuzzylite") is None and not REQUIRED,
    reason="the program is not installed (apt-get install fuzzylite)",
)


def run(*words: str | Path) -> None:
    subprocess.run(["fuzzylite", *map(str, words)], check=True, capture_output=True)


def answers_of_the_program(path: Path, X: np.ndarray) -> np.ndarray:
    """Return the outputs (n, m) that version 6 has for a file of FIS."""
    given, found = path.with_suffix(".in"), path.with_suffix(".out")
    np.savetxt(given, X, fmt="%.17g")
    what = ("-i", path, "-if", "fis", "-o", found, "-of", "fld", "-d", given, "-decimals", "15")
    run(*what, "-dinputs", "false", "-dheader", "false")
    return np.loadtxt(found, ndmin=2)


def compare_with_the_program(path: Path) -> None:
    """To 1e-5: the program passes over rules that fire by less than 1e-6."""
    system = read_fis(path)
    X = inputs_of(system)
    np.testing.assert_allclose(system(X), answers_of_the_program(path, X), rtol=1e-5, atol=1e-5)


@needs_the_program
@pytest.mark.parametrize("letter", "mt")
def test_fis_that_the_program_writes(letter: str, tmp_path: Path) -> None:
    """Its examples of Mamdani and of Takagi and Sugeno, over the 100 pieces of version 6."""
    path = tmp_path / "example.fis"
    run("-example", letter, "-o", path, "-of", "fis")
    assert "fuzzylite 6" in path.read_text(encoding="utf-8")
    compare_with_the_program(path)


@needs_the_program
@pytest.mark.parametrize("method", ["centroid", "som", "lom"])
def test_fis_that_the_program_reads(method: str, tmp_path: Path) -> None:
    system = parse_fis(TIPPER.replace("'centroid'", f"'{method}'"), dialect="fuzzylite")
    write_fis(system, tmp_path / "tipper.fis", dialect="fuzzylite")
    compare_with_the_program(tmp_path / "tipper.fis")
