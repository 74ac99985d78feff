"""Files of the Fuzzy Control Language: what is read and refused, and round trips with the others.

Numbers are worked out here, by the standard's integrals and by jFuzzyLogic's sums.
"""

from __future__ import annotations

import math
import random
import re
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy2 import Linear, ParallelSystem, Trapezoidal, Triangular, Type1System, from_json, to_json
from fuzzy2.errors import (
    Fuzzy2Error,
    InvalidValue,
    MalformedFile,
    NotExpressible,
    UnknownName,
)
from fuzzy2.files.fcl import format_fcl, parse_fcl, read_fcl, write_fcl
from fuzzy2.files.fll import format_fll, parse_fll
from fuzzy2.systems.antecedents import And, Antecedent, Hedged, Is, Not, Or
from fuzzy2.systems.hedges import HEDGES
from tests import examples
from tests.fuzzy2.files.engines import HYBRID, inputs_of
from tests.fuzzy2.files.fcl_texts import BRAKE


def expected(speed: float, gap: float, grid: np.ndarray) -> list[float]:
    """Answers by the definitions; the force is a mean over a grid."""
    low, high = np.interp(speed, [0, 40], [1, 0]), np.interp(speed, [20, 60], [0, 1])
    near, far = np.interp(gap, [0, 50], [1, 0]), 1.0 / (1.0 + abs((gap - 100.0) / 20.0) ** 6)
    one = low + far - low * far
    two = 0.5 * high * (1.0 - far)
    three, four = (1.0 - low) * near, high
    weak = np.interp(grid, [0, 10, 20], [0, 1, 0])
    strong = np.interp(grid, [10, 20, 30], [0, 1, 1])
    union = np.maximum(np.minimum(one, weak), np.minimum(two, strong))
    loud = max(two, three)
    return [
        float((grid * union).sum() / union.sum()),
        float(8.0 * loud / (one + loud)),
        float((one * speed + four * (0.5 * speed - 2.0 * gap + 1.0)) / (one + four)),
    ]


@pytest.mark.parametrize("dialect", ["iec", "jfuzzylogic"])
def test_a_block_against_brute_force(dialect: str) -> None:
    system = parse_fcl(BRAKE, block="brake", dialect=dialect)
    assert isinstance(system, ParallelSystem)
    assert system.output_names == ("force", "horn", "plan")
    if dialect == "iec":  # a million middles are within 1e-9 of the integral
        grid, tolerance = (np.arange(10**6) + 0.5) * 30.0 / 10**6, 1e-8
    else:
        grid, tolerance = np.arange(1000) * 0.03, 1e-12
    for speed, gap in np.random.default_rng(1).uniform([0, 0], [60, 100], (20, 2)):
        np.testing.assert_allclose(
            system([speed, gap]), expected(speed, gap, grid), rtol=tolerance, atol=1e-12
        )


def test_blocks_by_name() -> None:
    assert parse_fcl(BRAKE, block="OTHER")([0.3]) == pytest.approx([1.0], abs=1e-9)
    with pytest.raises(UnknownName) as error:
        parse_fcl(BRAKE, block="third")
    assert error.value.known == ("brake", "other")
    with pytest.raises(InvalidValue, match="block must be the name of one of brake, other"):
        parse_fcl(BRAKE)
    with pytest.raises(UnknownName, match="dialect"):
        parse_fcl(BRAKE, block="other", dialect="iso")


def test_formulas_of_inputs_and_of_outputs_before_theirs() -> None:
    text = BRAKE.replace("FUNCTION speed", "FUNCTION LN(Speed + 1) * gap - HORN^2", 1)
    system, plain = parse_fcl(text, block="brake"), parse_fcl(BRAKE, block="brake")
    log = parse_fcl(
        BRAKE.replace("FUNCTION speed", "FUNCTION log(speed)*gap", 1), "s", "brake", "jfuzzylogic"
    )
    for speed, gap in np.random.default_rng(2).uniform((21.0, 1.0), (39.0, 49.0), (20, 2)):
        low, high = 1.0 - speed / 40.0, (speed - 20.0) / 40.0
        far = 1.0 / (1.0 + abs((gap - 100.0) / 20.0) ** 6)
        first, horn = low + far - low * far, plain([speed, gap])[1]
        slow = speed * 0.5 - 2.0 * gap + 1.0
        said = math.log(speed + 1.0) * gap - horn**2
        expected = (first * said + high * slow) / (first + high)
        np.testing.assert_allclose(system([speed, gap])[2], expected, rtol=1e-12)
        expected = (first * math.log10(speed) * gap + high * slow) / (first + high)
        np.testing.assert_allclose(log([speed, gap])[2], expected, rtol=1e-12)
    again = parse_fcl(format_fcl(system))
    X = np.random.default_rng(2).uniform((0.0, 1.0), (60.0, 99.0), (20, 2))
    np.testing.assert_allclose(again(X), system(X), rtol=1e-12)


@pytest.mark.parametrize("default", ["DEFAULT = 0;", "DEFAULT = 0"])
def test_a_default_may_be_spelled_as_jfuzzylogic_forgives(default: str) -> None:
    """Its parser goes on after a wrong sign and a missing semicolon."""
    system = parse_fcl(BRAKE.replace("DEFAULT := 0;", default, 1), block="brake")
    assert system.systems[0].default_outputs.tolist() == [0.0]
    X = np.random.default_rng(0).uniform([0, 0], [60, 100], (50, 2))
    np.testing.assert_array_equal(system(X), parse_fcl(BRAKE, block="brake")(X))


def test_a_block_may_have_hyphens_in_its_name() -> None:
    """JFML exports its systems so."""
    text = BRAKE.replace("Function_Block brake", "FUNCTION_BLOCK brake-MAMDANI-2")
    X = np.random.default_rng(2).uniform((0.0, 1.0), (60.0, 99.0), (20, 2))
    expected = parse_fcl(BRAKE, block="brake")(X)
    np.testing.assert_array_equal(parse_fcl(text, block="Brake-Mamdani-2")(X), expected)


def test_no_rule_fires() -> None:
    system = parse_fcl(BRAKE.replace("(0, 1) (40, 0)", "(0, 0) (1, 1) (2, 0)"), block="brake")
    force, horn, _ = system([10.0, -1e60])
    assert force == 0.0
    assert math.isnan(horn)


@pytest.mark.parametrize(
    ("old", "new", "place", "said"),
    [
        ("METHOD : COG;", "METHOD : CG;", 18, "METHOD : CG"),
        ("AND : PROD;", "AND : PROOD;", 31, "AND : PROOD"),
        ("(40, 0)", "(forty, 0)", 7, "'forty'"),
        ("FUNCTION speed", "FUNCTION LOG(speed)", 27, "natural in fuzzylite"),
        ("FUNCTION speed", "FUNCTION Force * plan", 32, "uses 'plan'"),
        ("TERM silent := 0", "TERM silent := SINGLETONS (0, 1)", 21, "SINGLETONS"),
        ("METHOD : COG;", "LOCK : PREVIOUS; METHOD : COG;", 18, "take DEFAULT := NC"),
        ("DEFAULT := 0;", "DEFAULT := 0 | NC;", 18, "take the number alone, or NC"),
        (
            "END_RULEBLOCK",
            "END_RULEBLOCK RULEBLOCK b AND : MIN; RULE 1 : IF speed IS low AND gap IS near THEN "
            "force IS weak; END_RULEBLOCK",
            3,
            "say ACCU in its DEFUZZIFY",
        ),
        (
            "END_RULEBLOCK",
            "END_RULEBLOCK RULEBLOCK b AND : MIN; ACCU : MAX; RULE 1 : IF speed IS low AND gap IS "
            "near THEN force IS weak; END_RULEBLOCK",
            32,
            "let the blocks of its rules have the same",
        ),
    ],
)
def test_what_a_system_cannot_be_is_named(old: str, new: str, place: int, said: str) -> None:
    assert old in BRAKE
    with pytest.raises(NotExpressible, match=re.escape(said)) as error:
        parse_fcl(BRAKE.replace(old, new, 1), block="brake")
    assert f"line {place}" in error.value.what


@pytest.mark.parametrize(
    ("old", "new", "place", "said"),
    [
        ("Speed IS LOW", "Speed IS LOOW", 32, "LOOW"),
        ("THEN plan IS slow", "THEN plane IS slow", 36, "plane"),
        ("TRAPE 10 20 30 30", "TRAPE 10 20 30", 17, "4 numbers"),
        ("(20, 0) (60, 1)", "(60, 0) (20, 1)", 8, "ascending"),
        ("DEFAULT := 0;", "DEFAULT : 0;", 18, "DEFAULT"),
        ("END_RULEBLOCK", "", 38, "FUNCTION_BLOCK"),
        (
            "silent := 0;\n  TERM loud := 8",
            "silent := (0,0) (1,1) (2,0); TERM loud := (0,0) (1,1)",
            22,
            r"METHOD : COGS of 'horn' averages .* Triangular\(left=0\.0, .*; take COG",
        ),
        ("goes on *)", "goes on", 1, r"the comment \(\* has no end; close it with \*\)"),
        ("/* OR follows */", "/* OR follows", 31, r"the comment /\* has no end"),
        ("// one line", "@", 4, "expected .*VAR"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(old: str, new: str, place: int, said: str) -> None:
    assert old in BRAKE
    with pytest.raises(MalformedFile, match=said) as error:
        parse_fcl(BRAKE.replace(old, new, 1), block="brake")
    assert error.value.place == f"line {place}"


def test_an_output_says_how_rules_of_two_blocks_accumulate() -> None:
    """ACCU of DEFUZZIFY counts, whatever the blocks say."""
    one = BRAKE
    for method, word in (("COG", "BSUM"), ("COGS", "MAX"), ("COGF", "NSUM")):
        one = one.replace(f"METHOD : {method};", f"METHOD : {method}; ACCU : {word};", 1)
    rule = one.index("  RULE 2")
    second = "END_RULEBLOCK RULEBLOCK second AND : PROD; ACT : MIN;\n"
    both = parse_fcl(one[:rule] + second + one[rule:], block="brake")
    X = np.random.default_rng(0).uniform([0, 0], [60, 100], (20, 2))
    np.testing.assert_array_equal(both(X), parse_fcl(one, block="brake")(X))


def test_round_trips(tmp_path: Path) -> None:
    system = parse_fcl(BRAKE, block="brake")
    X = np.random.default_rng(0).uniform([0, 0], [60, 100], (100, 2))
    write_fcl(system, tmp_path / "a brake.fcl")
    again = read_fcl(tmp_path / "a brake.fcl")
    np.testing.assert_allclose(again(X), system(X), rtol=1e-9, atol=1e-9, equal_nan=True)
    json = from_json(to_json(system))
    np.testing.assert_allclose(json(X), system(X), rtol=1e-9, atol=1e-9, equal_nan=True)


def test_the_integral_of_each_format_is_asked_for() -> None:
    """FLL sums over middles and FCL integrates; neither writes what the other one means."""
    system = next(one for one in parse_fll(HYBRID).systems if one.output_names == ("power",))
    with pytest.raises(NotExpressible, match='replace\\(integration="exact"\\)'):
        format_fcl(system)
    exact = system.replace(integration="exact")
    X = inputs_of(system)
    np.testing.assert_allclose(parse_fcl(format_fcl(exact))(X), exact(X), rtol=1e-9)
    with pytest.raises(NotExpressible, match='replace\\(integration="midpoint"\\)'):
        format_fll(exact)


numbers = st.floats(-10.0, 10.0).map(lambda value: round(value, 3))
grades = st.sampled_from([0.25, 0.5, 1.0])


@st.composite
def terms(draw: st.DrawFn) -> Triangular | Trapezoidal:
    corners = sorted(draw(st.lists(numbers, min_size=4, max_size=4, unique=True)))
    if draw(st.booleans()):
        return Triangular(corners[0], corners[1], corners[2], draw(grades))
    return Trapezoidal(*corners, draw(grades))


@st.composite
def trees(draw: st.DrawFn, inputs: int, depth: int = 2) -> Antecedent:
    if depth == 0 or draw(st.booleans()):
        tree: Antecedent = Is(draw(st.integers(0, inputs - 1)), draw(st.integers(0, 1)))
        for _ in range(draw(st.integers(0, 2))):
            hedge = HEDGES[draw(st.sampled_from(["very", "somewhat"]))]
            tree = Not(tree) if draw(st.booleans()) else Hedged(hedge, tree)
        return tree
    kind = draw(st.sampled_from([And, Or]))
    parts = draw(st.lists(trees(inputs, depth - 1), min_size=2, max_size=3))
    return kind(tuple(parts))


@st.composite
def systems(draw: st.DrawFn) -> Type1System:
    """Return a system of numbers or linear functions, which both formats hold."""
    p, m, count = draw(st.integers(1, 3)), draw(st.integers(1, 2)), draw(st.integers(1, 5))
    rng = np.random.default_rng(draw(st.integers(0, 2**31)))
    consequents = rng.normal(size=(count, m))
    of_functions = draw(st.booleans())
    return Type1System(
        [[draw(terms()), draw(terms())] for _ in range(p)],
        tuple(draw(trees(p)) for _ in range(count)),
        Linear(rng.normal(size=(count, m, p + 1))) if of_functions else consequents,
        t_norm=draw(st.sampled_from(["min", "product", "lukasiewicz", "einstein"])),
        disjunction=draw(st.sampled_from(["max", "probabilistic", "lukasiewicz"])),
        weights=rng.uniform(0.1, 1.0, count) if draw(st.booleans()) else None,
        default_outputs=[draw(st.sampled_from([None, 1.5])) for _ in range(m)],
        input_ranges=[(-10.0, 10.0)] * p,
        output_ranges=[(-5.0, 5.0)] * m,
    )


@given(systems())
@settings(max_examples=examples(100), deadline=None)
def test_systems_go_through_every_format(system: Type1System) -> None:
    X = inputs_of(system, 30)
    want = system(X)
    through_fll = parse_fll(format_fll(system))
    through_json = from_json(to_json(through_fll))
    through_fcl = parse_fcl(format_fcl(through_json))
    back = parse_fll(format_fll(through_fcl))
    for again in (through_fll, through_json, through_fcl, back):
        np.testing.assert_allclose(again(X), want, rtol=1e-9, atol=1e-9, equal_nan=True)


WORDS = ["(", ")", "(*", "*)", "/*", ";", ":=", "nan", "1e400", "NOT", "is", "END_VAR", "\n", "é"]


@pytest.mark.parametrize("seed", range(150))
def test_mutated_files_are_read_or_refused(seed: int) -> None:
    rng = random.Random(seed)
    text = list(BRAKE)
    for _ in range(rng.choice([1, 1, 2, 5])):
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
        system = parse_fcl("".join(text), block=rng.choice(["brake", "other"]))
        system(np.zeros(len(system.input_names)))
    except Fuzzy2Error as error:
        refusal = error
    assert not isinstance(refusal, MalformedFile) or re.fullmatch(r"line \d+", refusal.place)
    assert time.process_time() - begin < 5.0
