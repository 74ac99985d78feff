"""Files of fuzzylite: what is read, what is refused by name, and round trips.

The numbers are worked out here by brute force, from fuzzylite's documentation;
``tests/cross/test_fuzzylite.py`` asks the program itself.
"""

from __future__ import annotations

import math
import random
import re
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from fuzzy2 import ParallelSystem, Type1System, from_json, to_json
from fuzzy2.errors import Fuzzy2Error, MalformedFile, NotExpressible
from fuzzy2.files.fll import format_fll, parse_fll, read_fll, write_fll
from tests.fuzzy2.files.engines import CHAIN, FORMULAS, HYBRID, TERMS, TSUKAMOTO, inputs_of

POINTS = 200


def midpoints(low: float, high: float) -> np.ndarray:
    return low + (high - low) * (np.arange(POINTS) + 0.5) / POINTS


def triangle(x: np.ndarray | float, a: float, b: float, c: float) -> np.ndarray:
    return np.interp(x, [a, b, c], [0.0, 1.0, 0.0])


def test_a_hybrid_engine_against_brute_force() -> None:
    """One output by Mamdani, one by Takagi and Sugeno, with weights, or, not and a default."""
    system = parse_fll(HYBRID)
    assert isinstance(system, ParallelSystem)
    assert system.output_names == ("power", "price")
    grid = midpoints(0.0, 1.0)
    for heat, wind in np.random.default_rng(3).uniform(0.0, 10.0, (50, 2)):
        cold = float(np.interp(heat, [2.0, 6.0], [1.0, 0.0]))
        hot = float(np.interp(heat, [4.0, 9.0], [0.0, 1.0]))
        windy = math.exp(-((wind - 8.0) ** 2) / (2.0 * 2.0**2))
        first = cold + windy - cold * windy
        second = 0.5 * hot * (1.0 - windy) ** 2
        clipped = [
            np.minimum(first, triangle(grid, 0.5, 0.75, 1.0)),
            np.minimum(second, triangle(grid, 0.0, 0.25, 0.5)),
        ]
        united = clipped[0] + clipped[1] - clipped[0] * clipped[1]
        power = (grid * united).sum() / united.sum()
        third, fourth = cold, hot * windy
        price = (third * (2.0 * heat - wind + 1.0) + fourth * 7.0) / (third + fourth)
        expected = [power, price if third + fourth > 0.0 else -1.0]
        np.testing.assert_allclose(system([heat, wind]), expected, rtol=1e-12)


def test_no_rule_fires() -> None:
    assert np.isnan(parse_fll(CHAIN)([5.0])).all()
    assert parse_fll(HYBRID.replace("Ramp 4 9", "Ramp 9 10"))([7.0, 0.0])[1] == -1.0


def test_an_output_in_a_condition_stands_for_its_rules() -> None:
    system = parse_fll(CHAIN)
    grid = midpoints(0.0, 1.0)
    for x in np.linspace(0.05, 0.95, 19):
        dark, bright = triangle(x, 0.0, 0.25, 0.7), triangle(x, 0.3, 0.75, 1.0)
        low, high = triangle(grid, 0.0, 0.25, 0.5), triangle(grid, 0.5, 0.75, 1.0)
        # Two rules speak of "low"; a hedge before a conclusion is on its firing.
        degree = max(bright, dark**2)
        first = np.maximum.reduce(
            [np.minimum(dark, high), np.minimum(bright, low), np.minimum(dark**2, low)]
        )
        second = np.minimum(math.sqrt(degree), high)
        for got, grades in zip(system([x]), (first, second), strict=True):
            expected = (grid * grades).sum() / grades.sum() if grades.any() else math.nan
            np.testing.assert_allclose(got, expected, rtol=1e-12)


def test_tsukamoto_asks_beyond_the_range() -> None:
    """Closed forms of the points at which terms have a grade, whatever the range says."""
    system = parse_fll(TSUKAMOTO)
    x = np.linspace(-9.0, 9.0, 37)
    low, high = 1.0 / (1.0 + np.exp(0.5 * x)), 1.0 / (1.0 + np.exp(-0.5 * x))
    points = {
        "ramps": (0.6 - 0.2 * low, 0.25 * high),
        "sigmoids": (0.5 - np.log(1.0 / low - 1.0) / -30.0, 0.83 - np.log(1.0 / high - 1.0) / 30.0),
        "concaves": (0.1 * -1.0 / -low * -1.0 + 0.3, -0.1 / high + 1.1),
    }
    points["concaves"] = ((0.5 - 0.4) / low + 2.0 * 0.4 - 0.5, (0.9 - 1.0) / high + 2.0 - 0.9)
    got = system(x[:, np.newaxis])
    for j, name in enumerate(system.output_names):
        first, second = points[name]
        expected = (low * first + high * second) / (low + high)
        np.testing.assert_allclose(got[:, j], expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("text", [HYBRID, CHAIN, TSUKAMOTO, TERMS, FORMULAS], ids="hcstf")
def test_round_trips(tmp_path: Path, text: str) -> None:
    system = parse_fll(text)
    write_fll(system, tmp_path / "engine.fll")
    X = inputs_of(system)
    expected = system(X)
    for again in (read_fll(tmp_path / "engine.fll"), from_json(to_json(system))):
        assert type(again) is type(system)
        np.testing.assert_allclose(again(X), expected, rtol=1e-9, atol=1e-9)
    assert format_fll(read_fll(tmp_path / "engine.fll"), "engine") == format_fll(system, "engine")


REFUSED: list[tuple[Callable[[str], str], str, str]] = [
    (lambda t: t.replace("Constant 7", "Function power/price"), "line 45", "uses 'price'"),
    (lambda t: t.replace("Triangle 0 0.25 0.5", "Function 3*x"), "line 13", "leave [0, 1]"),
    (lambda t: t.replace("Ramp 6 2", "Function x/2"), "line 2", "leave [0, 1]"),
    (lambda t: t.replace("default: -1", "default: -1\n  lock-previous: true"), "line 27", "lock"),
    (lambda t: t.replace("activation: General", "activation: First 1", 1), "line 35", "First"),
    (lambda t: t.replace("heat\n", "heat\n  enabled: false\n", 1), "line 3", "disabled"),
    (lambda t: t.replace("Centroid 200", "Center 3"), "line 17", "Center 3"),
    (
        lambda t: t.replace("conjunction: AlgebraicProduct", "conjunction: none", 1),
        "line 38",
        '"and"',
    ),
]


@pytest.mark.parametrize(("change", "place", "what"), REFUSED)
def test_what_a_system_cannot_be_is_named(
    change: Callable[[str], str], place: str, what: str
) -> None:
    assert change(HYBRID) != HYBRID
    with pytest.raises(NotExpressible) as refused:
        parse_fll(change(HYBRID))
    assert place in str(refused.value)
    assert what in str(refused.value)


def test_formulas_against_brute_force() -> None:
    system = parse_fll(FORMULAS)
    step = 2.0 / 100
    grid = step * (np.arange(100) + 0.5)
    weak = np.where(grid < 0.75, np.maximum(0.0, 1.0 - grid), 0.0)
    strong = np.clip(2.0 * grid - 2.5, 0.0, 1.0)
    for a, b in np.random.default_rng(3).uniform((-2.0, 0.0), (2.0, 4.0), (50, 2)):
        some = math.exp(-((b - 2.0) ** 2) / 2.0)
        high = float(np.interp(a, [-1.0, 1.0], [0.0, 1.0]))
        first, second = some / (1.0 + math.exp(3.0 * a)), 0.5 * high
        said = [math.sin(2.0 * a) * b**2, a - 2.0 * b + 0.5, -3.0]
        fired = [first, second, 1.0 - some]
        wave = float(np.dot(fired, said) / sum(fired))
        united = np.maximum(np.minimum(first, weak), np.minimum(second, strong))
        expected = [wave, abs(wave - a) % 2.0, (grid * united).sum() / united.sum()]
        np.testing.assert_allclose(system([a, b]), expected, rtol=1e-11)


def test_where_the_last_output_would_stay_there_is_nothing_new() -> None:
    held = HYBRID.replace("default: -1", "default: nan\n  lock-previous: true")
    held = held.replace("Ramp 4 9", "Ramp 9 10")
    assert math.isnan(parse_fll(held)([7.0, 0.0])[1])


MALFORMED: list[tuple[str, str, str, str]] = [
    ("range: 0 10", "range: 10 0", "line 4", "range: <low> <high>"),
    ("Ramp 6 2", "Ramp 6", "line 5", "2 numbers"),
    ("Ramp 6 2", "Function 1 +", "line 5", "the formula"),
    ("Constant 7", "Function open(7)", "line 28", "a function in a formula"),
    ("Ramp 6 2", "Function wind/10", "line 5", "x alone"),
    ("Ramp 6 2", "Ramp 6 two", "line 5", "'two'"),
    ("Ramp 6 2", "Ramp 6 ٢", "line 5", "'٢'"),
    ("Ramp 6 2", "Ramp 6 1_0", "line 5", "'1_0'"),
    ("Centroid 200", "Centroid ２００", "line 17", "from 2 to 1000000 points"),
    ("with 0.5", "with 0_1", "line 38", "'0_1'"),
    ("heat is hot", "heat is hit", "line 38", "'hot'"),
    ("power is high", "pover is high", "line 37", "'power'"),
    ("OutputVariable: power", "Output: power", "line 13", "OutputVariable"),
    ("with 0.5", "with 1.5", "line 38", "1.5"),
    ("defuzzifier: Centroid", "defuzzifer: Centroid", "line 17", "'defuzzifier'"),
]


@pytest.mark.parametrize(("old", "new", "place", "said"), MALFORMED)
def test_what_is_wrong_is_said_with_its_line(old: str, new: str, place: str, said: str) -> None:
    assert old in HYBRID
    with pytest.raises(MalformedFile) as error:
        parse_fll(HYBRID.replace(old, new, 1))
    assert said in error.value.reason
    assert error.value.place == place


def test_locked_inputs_go_on_level() -> None:
    """Held within 0 to 10, so that a term that is whole at the end is whole beyond."""
    free = HYBRID.replace("Linear 2 -1 1", "Constant 3")
    locked = free.replace("range: 0 10", "range: 3 8\n  lock-range: true", 1)
    system, inside = parse_fll(locked), parse_fll(free)
    for heat in (-5.0, 3.0, 4.0, 8.0, 20.0):
        held = min(max(heat, 3.0), 8.0)
        np.testing.assert_allclose(system([heat, 5.0]), inside([held, 5.0]), rtol=1e-12)


@pytest.mark.parametrize(
    "rule",
    [
        "if " + "(" * 5000 + "heat is hot" + ")" * 5000 + " then power is low",
        "if " + "(heat is hot or " * 3000 + "heat is hot" + ")" * 3000 + " then power is low",
        "if heat is " + "not " * 20000 + "hot then power is low",
        "if " + "(" * 50000,
    ],
)
def test_deep_nesting(rule: str) -> None:
    text = HYBRID.replace(
        "rule: if heat is cold or", f"rule: {rule}\n  rule: if heat is cold or", 1
    )
    start = time.process_time()
    said = ""
    try:
        parse_fll(text)
    except Fuzzy2Error as error:
        said = str(error)
    assert not said or "line 37" in said
    assert time.process_time() - start < 5.0


def test_a_chain_of_rules_that_doubles_with_every_link() -> None:
    rule = "  rule: if first is low and first is low then first is low\n"
    text = CHAIN.replace("conjunction: none", "conjunction: Minimum") + rule * 60
    with pytest.raises(NotExpressible, match="chain of rules"):
        parse_fll(text)


WORDS = ["(", ")", "nan", "inf", "1e400", "not", "is", "and", "or", "#", ":", "\n", "-", "any", "é"]


@pytest.mark.parametrize("seed", range(150))
def test_mutated_files_are_read_or_refused(seed: int) -> None:
    rng = random.Random(seed)
    text = list(rng.choice([HYBRID, CHAIN, TSUKAMOTO, TERMS]))
    for _ in range(rng.choice([1, 1, 3, 10])):
        place = rng.randrange(len(text))
        kind = rng.random()
        if kind < 0.4:
            del text[place : place + rng.choice([1, 5, 80])]
        elif kind < 0.7:
            text[place:place] = rng.choice(WORDS)
        else:
            start = rng.randrange(len(text))
            text[place:place] = text[start : start + 40]
    begin = time.process_time()
    refusal: Fuzzy2Error | None = None
    try:
        system = parse_fll("".join(text))
        system(np.zeros(len(system.input_names)))
    except Fuzzy2Error as error:
        refusal = error
    assert not isinstance(refusal, MalformedFile) or re.fullmatch(r"line \d+", refusal.place)
    assert time.process_time() - begin < 5.0


def test_what_fll_cannot_hold() -> None:
    system = parse_fll(CHAIN)
    assert isinstance(system, Type1System)
    for changed, what in (
        (system.replace(integration="exact"), 'integration="exact"'),
        (system.replace(type_reduction="height"), "'height'"),
        (system.replace(input_names=["a b"]), "'a b'"),
    ):
        with pytest.raises(NotExpressible, match=re.escape(what)):
            format_fll(changed)
