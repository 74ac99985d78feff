"""Systems of all three types.

Against NumPy written out, against each other at zero uncertainty, and what they refuse.
"""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from numpy.typing import NDArray

import fuzzy2
from fuzzy2.errors import InvalidValue, NotApplicable, UnknownName
from fuzzy2.sets.sigmoids import Sigmoid
from fuzzy2.systems import GeneralType2System, IntervalType2System, Linear, Type1System
from tests.fuzzy2.systems.by_hand import (
    GRID_RULES,
    by_hand,
    gaussian,
    principal,
    strengths_by_hand,
    uncertain,
)

Array = NDArray[np.float64]


@pytest.mark.parametrize("norm", ["product", "min"])
def test_interval_system_by_hand(norm: str, consequents: Array, X: Array) -> None:
    """1e-12, the bar of exact reduction."""
    rules = GRID_RULES.copy()
    rules[3, 1] = rules[5, :2] = -1
    system = IntervalType2System(uncertain(), rules, consequents, t_norm=norm)
    found = system.type_reduced(X)
    for x, interval in zip(X, found, strict=True):
        np.testing.assert_allclose(
            interval, by_hand(uncertain(), rules, consequents, x, norm), atol=1e-12
        )
    np.testing.assert_allclose(system(X), found.mean(axis=-1), atol=1e-14)
    for x, strengths in zip(X, system.firing(X), strict=True):
        np.testing.assert_allclose(
            strengths, strengths_by_hand(uncertain(), rules, x, norm), atol=1e-14
        )


def test_far_from_all_rules_the_outputs_stay_exact(consequents: Array) -> None:
    """Firing strengths down to 1e-300 that differ by a hundred orders of magnitude.

    The outputs are those of the exact search.
    """
    X = np.random.default_rng(6).uniform(-30.0, 30.0, size=(300, 3))
    system = IntervalType2System(uncertain(), GRID_RULES, consequents)
    firing = system.firing(X)
    expected = fuzzy2.generalized_centroid(
        np.moveaxis(np.stack([consequents, consequents], -1), 1, 0), firing[:, np.newaxis], "scan"
    )
    # Below, the products themselves have lost their digits, and the system goes by logarithms.
    whole = firing[..., 1].max(axis=1) > 1e-280
    assert 0 < np.count_nonzero(whole) < len(X)
    np.testing.assert_allclose(system.type_reduced(X)[whole], expected[whole], atol=1e-12)


@pytest.mark.parametrize("norm", ["product", "min"])
@pytest.mark.parametrize(
    "reduction", ["center_of_sets", "height", "modified_height", "centroid", "center_of_sums"]
)
def test_without_uncertainty_all_types_are_the_type_1_system(
    norm: str, reduction: str, X: Array
) -> None:
    """Zero mean variation and zero secondary spread: 1e-12 relative, the project's bar."""
    sets = [fuzzy2.Gaussian(mean=m, sigma=0.3) for m in np.linspace(-2.0, 2.0, 8)]
    options = {"t_norm": norm, "type_reduction": reduction, "resolution": 101}
    crisp = Type1System(gaussian(), GRID_RULES, sets, **options)
    interval = IntervalType2System(uncertain(0.0), GRID_RULES, sets, **options)
    general = GeneralType2System(principal(0.0), GRID_RULES, sets, **options)
    expected = crisp(X[:8])
    np.testing.assert_allclose(interval(X[:8]), expected, rtol=1e-12)
    np.testing.assert_allclose(general(X[:8]), expected, rtol=1e-12)
    np.testing.assert_allclose(
        interval.type_reduced(X[:8])[..., 0], interval.type_reduced(X[:8])[..., 1], rtol=1e-12
    )


def test_one_rule_fired() -> None:
    """Height reduction gives a point (eq. 1.77).

    Center of sets gives the consequent's centroid interval (eq. 1.82).
    """
    terms = [[fuzzy2.Triangular(-1.0, 0.0, 1.0), fuzzy2.Triangular(4.0, 5.0, 6.0)]]
    sets = [
        fuzzy2.GaussianUncertainMean(mean=(1.0, 2.0), sigma=0.5),
        fuzzy2.GaussianUncertainMean(mean=(5.0, 6.0), sigma=0.5),
    ]
    height = IntervalType2System(terms, [[0], [1]], sets, type_reduction="height").type_reduced(
        [0.2]
    )
    assert height[0, 0] == height[0, 1] == pytest.approx(1.5)
    center = IntervalType2System(terms, [[0], [1]], sets).type_reduced([0.2])
    np.testing.assert_allclose(center[0], sets[0].centroid(), rtol=1e-12)


def test_matlab_tipper() -> None:
    """Published: evalfis of MATLAB's tipper example gives 7.0169 at (2, 1) and 20.3414 at (7, 8).

    5e-5 is the print's rounding.
    """
    service = [fuzzy2.Gaussian(mean=m, sigma=1.5) for m in (0.0, 5.0, 10.0)]
    food = [fuzzy2.Trapezoidal(-2.0, 0.0, 1.0, 3.0), fuzzy2.Trapezoidal(7.0, 9.0, 10.0, 12.0)]
    tips = [
        fuzzy2.Triangular(0.0, 5.0, 10.0),
        fuzzy2.Triangular(10.0, 15.0, 20.0),
        fuzzy2.Triangular(20.0, 25.0, 30.0),
    ]
    # "service is poor or food is rancid" by De Morgan needs the maximum of two grades: with rules
    # joined by the maximum that is two rules with the same consequent.
    rules = [[0, -1], [-1, 0], [1, -1], [2, -1], [-1, 1]]
    system = Type1System(
        [service, food],
        rules,
        [tips[0], tips[0], tips[1], tips[2], tips[2]],
        t_norm="min",
        type_reduction="centroid",
        resolution=101,
        integration="sum",
    )
    np.testing.assert_allclose(system([[2.0, 1.0], [7.0, 8.0]])[:, 0], [7.0169, 20.3414], atol=5e-5)


def test_the_domain_of_shoulders_ends_where_they_are_almost_flat() -> None:
    """A sigmoid never reaches its height.

    It is at 0.98 of it four reciprocal slopes behind its center.
    """
    system = Type1System([[Sigmoid(-1.0, -4.0), Sigmoid(1.0, 2.0)]], [[0], [1]], [[0.0], [1.0]])
    np.testing.assert_allclose(system.domain(), [[-2.0, 3.0]], rtol=1e-14)
    assert system.validate().ok


def test_other_t_norms(consequents: Array, X: Array) -> None:
    """Łukasiewicz and a function of one's own, written out."""
    for norm, combine in (
        ("lukasiewicz", lambda a, b: np.maximum(a + b - 1.0, 0.0)),
        (lambda a, b: a * b, lambda a, b: a * b),
    ):
        system = IntervalType2System(uncertain(), GRID_RULES, consequents, t_norm=norm)
        grades = [
            [(t.lower(X[:, i]), t.upper(X[:, i])) for t in terms]
            for i, terms in enumerate(uncertain())
        ]
        for r, rule in enumerate(GRID_RULES):
            for end in (0, 1):
                expected = combine(
                    combine(grades[0][rule[0]][end], grades[1][rule[1]][end]),
                    grades[2][rule[2]][end],
                )
                np.testing.assert_allclose(system.firing(X)[:, r, end], expected, atol=1e-15)


def test_non_singleton_fuzzifiers(consequents: Array, X: Array) -> None:
    """Gaussian inputs of type 1 and interval type 2 against the supremum on a fine grid.

    1e-5 is the grid's error.
    """
    x = X[0]
    grid = np.linspace(-8.0, 8.0, 40_001)
    for shape in (
        fuzzy2.Gaussian(mean=0.0, sigma=0.3),
        fuzzy2.GaussianUncertainSigma(mean=0.0, sigma=(0.2, 0.4)),
    ):
        fuzzifier = fuzzy2.NonSingletonFuzzifier(shape)
        firing = IntervalType2System(
            uncertain(), GRID_RULES, consequents, fuzzifier=fuzzifier
        ).firing(x)
        for r, rule in enumerate(GRID_RULES):
            expected = [1.0, 1.0]
            for i, t in enumerate(rule):
                term = uncertain()[i][t]
                expected[0] *= float((shape.lower(grid - x[i]) * term.lower(grid)).max())
                expected[1] *= float((shape.upper(grid - x[i]) * term.upper(grid)).max())
            np.testing.assert_allclose(firing[r], expected, atol=1e-5)
    general = fuzzy2.GaussianType2Set(principal=fuzzy2.Gaussian(mean=0.0, sigma=0.3), sigma=0.02)
    system = GeneralType2System(
        gaussian(),
        GRID_RULES,
        consequents,
        fuzzifier=fuzzy2.NonSingletonFuzzifier(general),
        levels=2,
    )
    plane = IntervalType2System(
        gaussian(),
        GRID_RULES,
        consequents,
        fuzzifier=fuzzy2.NonSingletonFuzzifier(general.alpha_plane(0.5)),
    )
    np.testing.assert_allclose(system.alpha_cuts(x)[:, 0], plane.type_reduced(x), atol=1e-12)
    with pytest.raises(InvalidValue, match="shape of a fuzzifier"):
        IntervalType2System(
            uncertain(), GRID_RULES, consequents, fuzzifier=fuzzy2.NonSingletonFuzzifier(general)
        )
    with pytest.raises(InvalidValue, match="fuzzifier"):
        IntervalType2System(
            uncertain(), GRID_RULES, consequents, fuzzifier=[fuzzy2.SingletonFuzzifier()]
        )
    plain = IntervalType2System(
        uncertain(), GRID_RULES, consequents, fuzzifier=fuzzy2.SingletonFuzzifier()
    )
    np.testing.assert_array_equal(
        plain(X), IntervalType2System(uncertain(), GRID_RULES, consequents)(X)
    )


def test_rules_in_words(X: Array) -> None:
    """The same system from words, rule objects and numbers.

    A misspelled term names the rule and the nearest name.
    """
    low_high = dict(zip(("Low", "High"), uncertain()[0], strict=True))
    inputs = {"error": low_high, "rate": low_high}
    outputs = {"force": {"weak": 1.0, "strong": (2.0, 3.0)}, "light": {"off": 0.0, "on": 1.0}}
    text = """
    IF error is Low and rate is Low THEN force is weak and light is off
    if rate is High then force is strong and light is on
    """
    system = IntervalType2System(inputs, text, outputs)
    numbers = IntervalType2System(
        uncertain()[:2],
        [[0, 0], [-1, 1]],
        np.array([[[1.0, 1.0], [0.0, 0.0]], [[2.0, 3.0], [1.0, 1.0]]]),
    )
    np.testing.assert_array_equal(system.type_reduced(X[:, :2]), numbers.type_reduced(X[:, :2]))
    assert (system.input_names, system.output_names) == (("error", "rate"), ("force", "light"))
    assert system.consequent_names == (("weak", "off"), ("strong", "on"))
    objects = [
        fuzzy2.Rule({"error": "Low", "rate": "Low"}, {"force": "weak", "light": "off"}),
        fuzzy2.Rule({"rate": "High"}, {"force": "strong", "light": "on"}),
    ]
    np.testing.assert_array_equal(
        IntervalType2System(inputs, objects, outputs)(X[:, :2]), system(X[:, :2])
    )
    with pytest.raises(fuzzy2.Fuzzy2Error, match=r"rule 1.*Low"):
        IntervalType2System(inputs, "IF error is Lwo THEN force is weak and light is off", outputs)
    with pytest.raises(InvalidValue, match="inputs"):
        IntervalType2System(uncertain()[:2], text, outputs)


def test_rules_in_words_are_replaced_by_others_in_words() -> None:
    """They take the terms of the outputs from the system, and leave its weights behind."""
    terms = {"Low": fuzzy2.Triangular(-1.0, 0.0, 1.0), "High": fuzzy2.Triangular(0.0, 1.0, 2.0)}
    outputs = {"force": {"weak": 1.0, "strong": 3.0}}
    first = "IF error is Low THEN force is weak WITH 0.5; IF error is High THEN force is strong"
    second = "IF error is not Low THEN force is weak; IF error is Low THEN force is strong"
    system = Type1System({"error": terms}, first.replace("; ", "\n"), outputs)
    assert system.weights is not None
    replaced = system.replace(rules=second.replace("; ", "\n"))
    made = Type1System({"error": terms}, second.replace("; ", "\n"), outputs)
    X = np.linspace(0.0, 1.0, 11)[:, None]
    np.testing.assert_array_equal(replaced(X), made(X))
    # Grades of Low and of its complement: the average of 3 and 1 by hand.
    np.testing.assert_allclose(replaced(X), 3.0 * (1.0 - X) + 1.0 * X, atol=1e-15)
    assert replaced.weights is None
    assert replaced.consequent_names == (("weak",), ("strong",))


@pytest.mark.parametrize("direct", ["eiasc", "nie_tan", "wu_mendel", "begian_melek_mendel"])
def test_consequents_at_the_ends_of_the_floats(direct: str, X: Array) -> None:
    """They are averaged as those of order 1, whose distances are floats."""
    ends = np.where(np.arange(8) % 2, 1.0, -1.0)[:, None]
    small = IntervalType2System(uncertain(), GRID_RULES, ends, method=direct)
    huge = small.replace(consequents=1.7e308 * ends)
    np.testing.assert_allclose(huge(X) / 1.7e308, small(X), atol=1e-14)
    np.testing.assert_allclose(
        huge.type_reduced(X[:5]) / 1.7e308, small.type_reduced(X[:5]), atol=1e-14
    )
    np.testing.assert_allclose(huge.firing(X), small.firing(X), atol=1e-15)


def test_shapes(consequents: Array, X: Array) -> None:
    for system in (
        IntervalType2System(uncertain(), GRID_RULES, consequents),
        GeneralType2System(principal(), GRID_RULES, consequents),
        Type1System(gaussian(), GRID_RULES, consequents),
    ):
        grid = X[:24].reshape(2, 3, 4, 3)
        assert system(grid).shape == (2, 3, 4, 4)
        assert system.type_reduced(grid).shape == (2, 3, 4, 4, 2)
        assert system.firing(grid).shape == (2, 3, 4, 8, 2)
        assert system.validity(grid).shape == (2, 3, 4)
        assert system(X[0]).shape == (4,)
        assert system(X[:0]).shape == (0, 4)
        np.testing.assert_allclose(system(grid)[1, 2, 3], system(X[23]), rtol=1e-14)
        np.testing.assert_array_equal(system(list(X[0])), system(X[0]))
        np.testing.assert_array_equal(system(X[:, ::-1][0]), system(np.array(X[0, ::-1])))


def test_systems_cross_process_boundaries(consequents: Array, X: Array) -> None:
    """Studies send systems to worker processes."""
    for system in (
        IntervalType2System(uncertain(), GRID_RULES, consequents),
        GeneralType2System(principal(), GRID_RULES, consequents),
    ):
        np.testing.assert_array_equal(pickle.loads(pickle.dumps(system))(X), system(X))


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        ({"inputs": []}, InvalidValue, "inputs"),
        ({"inputs": [[fuzzy2.Gaussian(0.0, 1.0)], [], []]}, InvalidValue, "inputs"),
        ({"inputs": [["low"], ["low"], ["low"]]}, InvalidValue, "input 1"),
        ({"rules": [[0, 0]]}, InvalidValue, "rules"),
        ({"rules": [[0.0, 1.0, 0.0]] * 8}, InvalidValue, "whole numbers"),
        ({"rules": [[0, 2, 0]] * 8}, InvalidValue, "rule 1, input 2"),
        ({"rules": [[0, -2, 0]] * 8}, InvalidValue, "rule 1, input 2"),
        ({"consequents": np.zeros((7, 1))}, InvalidValue, "consequents"),
        ({"consequents": np.full((8, 1), np.nan)}, InvalidValue, "consequents"),
        ({"consequents": np.tile([2.0, 1.0], (8, 1, 1))}, InvalidValue, "left ends"),
        ({"consequents": "high"}, InvalidValue, "consequents"),
        ({"consequents": Linear(np.zeros((8, 1, 3)))}, InvalidValue, "coefficients"),
        ({"t_norm": "median"}, UnknownName, "min"),
        ({"type_reduction": "weighted"}, UnknownName, "center_of_sets"),
        ({"method": "karnik"}, UnknownName, "eiasc"),
        ({"type_reduction": "centroid"}, NotApplicable, "not sets"),
        ({"resolution": 1}, InvalidValue, "resolution"),
        ({"input_names": ["a", "b"]}, InvalidValue, "input_names"),
        ({"input_names": ["a", "b", "a"]}, InvalidValue, "different"),
        ({"term_names": [["a", "b"]]}, InvalidValue, "term_names"),
        ({"consequent_names": [["a"]] * 7}, InvalidValue, "consequent_names"),
        ({"consequent_names": [["a", "b"]] * 8}, InvalidValue, "consequent_names"),
        ({"input_ranges": [[0.0, 1.0]] * 2}, InvalidValue, "input_ranges"),
        ({"output_ranges": [[1.0, 1.0]]}, InvalidValue, "output_ranges"),
        ({"output_ranges": [[0.0, np.inf]]}, InvalidValue, "output_ranges"),
    ],
)
def test_malformed_systems_are_refused(
    change: dict[str, object], error: type[Exception], words: str
) -> None:
    arguments: dict[str, object] = {
        "inputs": uncertain(),
        "rules": GRID_RULES,
        "consequents": np.zeros((8, 1)),
    } | change
    with pytest.raises(error, match=words):
        IntervalType2System(**arguments)  # type: ignore[arg-type]


def test_a_type_1_system_takes_no_type_2_terms() -> None:
    with pytest.raises(InvalidValue, match="type-1 set"):
        Type1System(uncertain(), GRID_RULES, np.zeros((8, 1)))
    with pytest.raises(InvalidValue, match="interval type-2"):
        IntervalType2System(principal(), GRID_RULES, np.zeros((8, 1)))


@pytest.mark.parametrize(
    "bad", [[0.0, 0.0], [0.0, np.nan, 0.0], [0.0, np.inf, 0.0], 1.0, "far", [[0.0], [1.0]]]
)
def test_malformed_inputs_are_refused(bad: object, consequents: Array) -> None:
    for system in (
        IntervalType2System(uncertain(), GRID_RULES, consequents),
        GeneralType2System(principal(), GRID_RULES, consequents),
    ):
        for method in (system, system.type_reduced, system.firing, system.validity):
            with pytest.raises(InvalidValue, match="X"):
                method(bad)  # type: ignore[operator]


@pytest.mark.parametrize("size", [0, 2, 4, 6])
def test_plain_rows_of_another_length_are_refused(size: int, consequents: Array) -> None:
    """The compiled loop must not take them for no rows, or for several.

    It would read or write beyond its arrays.
    """
    system = IntervalType2System(uncertain(), GRID_RULES, consequents)
    for evaluate in (system, system.type_reduced):
        with pytest.raises(InvalidValue, match=r"of shape \(\.\.\., 3\)"):
            evaluate(np.zeros(size))


def test_rows_of_every_make_are_read(consequents: Array, X: Array) -> None:
    """Lists, strided, read-only, single-precision and integer rows.

    The same as a plain row, and nothing is compiled for them.
    """
    from fuzzy2.systems import kernels

    system = IntervalType2System(uncertain(), GRID_RULES, consequents)
    x = np.array([0.5, -1.0, 0.25])
    expected = system(x)
    compiled_for = len(kernels.evaluate_row.signatures), len(kernels.evaluate.signatures)
    fixed = x.copy()
    fixed.setflags(write=False)
    for same in (
        x.tolist(),
        np.repeat(x, 2)[::2],
        fixed,
        x.astype(np.float32),
        np.broadcast_to(x, (2, 3))[1],
    ):
        np.testing.assert_array_equal(system(same), expected)
    np.testing.assert_array_equal(system(np.array([1, -1, 0])), system([1.0, -1.0, 0.0]))
    assert (len(kernels.evaluate_row.signatures), len(kernels.evaluate.signatures)) == compiled_for
