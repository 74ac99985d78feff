"""Octave's fuzzy-logic-toolkit: what it ships, and what is written for it, evaluated by both."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fuzzy2
from fuzzy2.files.fis import parse_fis, read_fis, write_fis
from fuzzy2.systems.antecedents import And, Hedged, Is, Not, Or
from fuzzy2.systems.hedges import HEDGES
from tests.fuzzy2.files.fis_texts import TIPPER

REQUIRED = "octave" in os.environ.get("REQUIRED_CLIENTS", "").split()
SHIPPED = sorted(Path("/usr/share/octave/packages").glob("fuzzy-logic-toolkit-*/*.fis"))
MISSING = shutil.which("octave-cli") is None or not SHIPPED

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        MISSING and not REQUIRED,
        reason="octave-cli and its toolbox are not installed "
        "(apt-get install octave-fuzzy-logic-toolkit)",
    ),
]

# Where no rule fires its evalfis stops with an error, which is no answer, as NaN is here.
EVALUATE = """\
pkg load fuzzy-logic-toolkit
fis = readfis('{fis}');
x = load('{inputs}');
y = NaN(rows(x), columns(fis.output));
for i = 1:rows(x)
  try
    y(i, :) = evalfis(x(i, :), fis);
  end
end
out = fopen('{outputs}', 'w');
for i = 1:rows(y)
  fprintf(out, '%.17g ', y(i, :));
  fprintf(out, '\\n');
end
fclose(out);
"""


def evalfis(path: Path, X: Any, folder: Path) -> Any:
    """Return what Octave makes of inputs (n, p)."""
    names = {"fis": path, "inputs": folder / "x.txt", "outputs": folder / "y.txt"}
    np.savetxt(names["inputs"], X, fmt="%.17g")
    (folder / "evaluate.m").write_text(EVALUATE.format(**names), encoding="utf-8")
    # Octave itself tells in words what was wrong, which the assertion shows.
    done = subprocess.run(
        ["octave-cli", "--no-gui", "--quiet", str(folder / "evaluate.m")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return np.loadtxt(names["outputs"], ndmin=2)


def inputs_of(system: Any, count: int = 100) -> Any:
    low, high = np.array(system.input_ranges).T
    return np.random.default_rng(0).uniform(low, high, size=(count, len(low)))


def test_the_client_and_its_demos_are_there() -> None:
    assert shutil.which("octave-cli") is not None
    assert len(SHIPPED) == 6


@pytest.mark.parametrize("path", SHIPPED, ids=[path.stem for path in SHIPPED])
def test_its_demos_give_the_same_numbers(path: Path, tmp_path: Path) -> None:
    """To 1e-9: both take the same 101 points in double precision; measured is 6e-14."""
    system = read_fis(path, dialect="octave")
    X = inputs_of(system)
    np.testing.assert_allclose(system(X), evalfis(path, X, tmp_path), rtol=1e-9, atol=1e-9)


def tipper(**replaced: str) -> Any:
    text = TIPPER.replace("[7 9 10 12]", "[5 9 10 12]").replace("[-2 0 1 3]", "[-2 0 1 6]")
    for key, value in replaced.items():
        start = text.index(f"{key}='")
        text = text[:start] + f"{key}='{value}'" + text[text.index("\n", start) :]
    return parse_fis(text, dialect="octave")


def sugeno(**options: Any) -> Any:
    """Return a system of which two rules say the same number, and one nothing of an output."""
    terms = [fuzzy2.Triangular(-4, -2, 1), fuzzy2.Gaussian(0.0, 1.5), fuzzy2.Sigmoid(1.0, 2.0)]
    rules = [
        And((Is(0, 0), Not(Is(1, 1)))),
        Or((Is(0, 1), Is(1, 2))),
        And((Hedged(HEDGES["very"], Is(0, 2)), Is(1, 1))),
        Is(1, 0),
    ]
    return fuzzy2.Type1System(
        [terms, terms],
        rules,
        [[1.0, 2.0], [3.0, None], [1.0, -1.0], [4.0, 0.5]],
        weights=[1.0, 0.5, 1.0, 0.25],
        input_ranges=[[-2.0, 2.0]] * 2,
        **options,
    )


@pytest.mark.parametrize(
    "system",
    [
        tipper(),
        tipper(AndMethod="einstein_product", OrMethod="einstein_sum", ImpMethod="prod"),
        tipper(AndMethod="hamacher_product", OrMethod="algebraic_sum", AggMethod="sum"),
        tipper(AndMethod="bounded_difference", ImpMethod="hamacher_product"),
        tipper(AggMethod="algebraic_sum", OrMethod="bounded_sum"),
        tipper(DefuzzMethod="mom"),
        tipper(DefuzzMethod="som"),
        tipper(DefuzzMethod="lom"),
        sugeno(),
        sugeno(t_norm="min", type_reduction="united_average", disjunction="probabilistic"),
        sugeno(type_reduction="united_average", t_conorm="probabilistic"),
        sugeno(type_reduction="weighted_sum"),
    ],
    ids=str,
)
def test_what_is_written_for_it_gives_the_same_numbers(system: Any, tmp_path: Path) -> None:
    """To 1e-9: what differs is the order of sums."""
    path = tmp_path / "written.fis"
    write_fis(system, path, dialect="octave")
    X = inputs_of(system, 40)
    np.testing.assert_allclose(evalfis(path, X, tmp_path), system(X), rtol=1e-9, atol=1e-9)
