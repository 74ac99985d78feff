"""What has no form in C is named, and what is given in its place exports."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fuzzy2
from fuzzy2.errors import NotExportable
from fuzzy2.systems.consequents import FunctionsOfInputs
from tests.fuzzy2.export.kinds import gaussian, hedged, interval, numbers, own, type_1, united

pytestmark = pytest.mark.filterwarnings("ignore::fuzzy2.ApproximationWarning")


def exponential(height: float = 1.0) -> Any:
    return fuzzy2.FunctionalSet(lambda x: height * np.exp(-np.abs(x)), -5.0, 5.0, [0.0])


class Cubic(FunctionsOfInputs):
    """Consequents of one's own."""

    shape = (9, 1)

    def at(self, X: Any) -> Any:
        """Return the cube of the first input."""
        return np.broadcast_to(X[:, :1, None, None] ** 3, (len(X), 9, 1, 2))

    def said(self, r: int, j: int) -> Any:
        """Return what is never the same."""
        return r, j


TERMS: dict[str, Any] = {
    "a function": lambda: exponential(),
    "an interval type-2 set of functions": lambda: fuzzy2.IntervalType2Set(
        lower=exponential(0.5), upper=exponential()
    ),
    "a general type-2 set with bounds": lambda: fuzzy2.GaussianType2Set(
        fuzzy2.Gaussian(0.0, 0.8), 0.1, domain=(-2.0, 2.0)
    ),
}


@pytest.mark.parametrize("kind", TERMS)
def test_code_of_the_remedy_tabulates_the_set_that_is_named(kind: str, tmp_path: Path) -> None:
    made = fuzzy2.GeneralType2System if "general" in kind else fuzzy2.IntervalType2System
    terms = [[fuzzy2.Gaussian(1.0, 0.6), TERMS[kind]()], [fuzzy2.Gaussian(0.0, 1.0)]]
    system = made(terms, [[0, 0], [1, 0]], [[0.0], [2.0]], input_names=["rate", "error"])
    with pytest.raises(NotExportable, match=r"system\.inputs\[0\]\[1\], the term 'term2'") as told:
        fuzzy2.export_c(system, tmp_path)
    assert "'rate'" in told.value.what
    assert type(terms[0][1]).__name__ in told.value.what
    names = {"system": system, "fuzzy2": fuzzy2, "numpy": np}
    exec(told.value.remedy.partition(": ")[2], names)
    tabulated: Any = names["system"]
    fuzzy2.export_c(tabulated, tmp_path)
    x = np.random.default_rng(0).uniform(-1.5, 1.5, (200, 2))
    # A kink between two points is cut off by a quarter of their distance, which is 1/20 at most,
    # times the change of the slope there, which is 1 at most.
    np.testing.assert_allclose(tabulated(x), system(x), atol=0.0125)


REFUSED: dict[str, Any] = {
    r"the t-norm, '<lambda>'": lambda: interval(t_norm=lambda a, b: a * b),
    r"the implication, '<lambda>'": lambda: united(
        type_reduction="centroid", implication=lambda a, b: a * b
    ),
    r"the t-conorm that unites what rules say, '<lambda>'": lambda: united(
        type_reduction="bisector", integration="sum", t_conorm=lambda a, b: np.maximum(a, b)
    ),
    r"the fuzzifier": lambda: type_1(
        fuzzifier=fuzzy2.NonSingletonFuzzifier(fuzzy2.Gaussian(0.0, 0.1))
    ),
    r"the hedge 'oddly' of rule 1": lambda: hedged(np.square),
    r"consequents of type Cubic": lambda: type_1(consequents=Cubic()),
    r"the output sets FunctionalSet under 'centroid', without a grid.*integration='sum'": (
        lambda: united(own, type_reduction="centroid")
    ),
    r"the output sets Gaussian under 'mean_of_maxima'.*of their sums nothing but": lambda: united(
        gaussian, type_reduction="mean_of_maxima", t_conorm="sum"
    ),
    r"the output sets FunctionalSet cannot.*samples": lambda: united(
        lambda _: fuzzy2.FunctionalSet(lambda x: (x + 20.0) / 40.0, -20.0, 20.0),
        type_reduction="tsukamoto",
    ),
    r"type reduction 'weighted_sum' of numbers up to 1e\+300": lambda: type_1(
        consequents=np.full((9, 1), 1e300), type_reduction="weighted_sum"
    ),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_has_no_kernel_is_named(what: str, tmp_path: Path) -> None:
    with pytest.raises(NotExportable, match=what):
        fuzzy2.export_c(REFUSED[what](), tmp_path)


@pytest.mark.parametrize("what", [what for what in REFUSED if "without a grid" in what])
def test_a_grid_is_what_the_remedy_says_it_is(what: str, tmp_path: Path) -> None:
    system = REFUSED[what]()
    on_a_grid = system.replace(integration="sum", resolution=501)
    fuzzy2.export_c(on_a_grid, tmp_path)
    x = numbers(50, 2) * 0.5
    # Half a step of the grid, of sets from -5 to 5.
    np.testing.assert_allclose(on_a_grid(x), system(x), atol=0.02)
