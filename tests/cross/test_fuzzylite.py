"""fuzzylite evaluates what is written, and what it writes itself is evaluated here.

pyfuzzylite asks for an older NumPy than we do, but works with ours; so it is in no extra, and
``pip install --no-deps pyfuzzylite`` adds it. Its examples come with it. It sums over points as we
do then, so that both agree to rounding; only Tsukamoto's points of grades near 1 magnify that.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from fuzzy2 import ParallelSystem, Type1System
from fuzzy2.files.fll import format_fll, parse_fll, read_fll
from tests.fuzzy2.files.engines import CHAIN, FORMULAS, HYBRID, TERMS, TSUKAMOTO, inputs_of

if "fuzzylite" in os.environ.get("REQUIRED_CLIENTS", "").split():
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
