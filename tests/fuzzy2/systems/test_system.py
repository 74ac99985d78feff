"""Systems of all three types.

Against NumPy written out, against each other at zero uncertainty, and what they refuse.
"""

from __future__ import annotations

import itertools
import pickle
import warnings

import numpy as np
import pytest
from numpy.typing import NDArray

import fuzzy2
from fuzzy2.errors import ApproximationWarning, InvalidValue, NotApplicable, UnknownName
from fuzzy2.sets.sigmoids import Sigmoid
from fuzzy2.systems import GeneralType2System, IntervalType2System, Linear, Type1System
from fuzzy2.systems.kernels import LANES

Array = NDArray[np.float64]
GRID_RULES = np.array(list(itertools.product(range(2), repeat=3)))
CENTERS = (-1.0, 1.0)
MANY = LANES + 7
"""More rows than the compiled loop takes at a time, and some that are left over."""


def uncertain(width: float = 0.2) -> list[list[fuzzy2.GaussianUncertainMean]]:
    return [
        [fuzzy2.GaussianUncertainMean(mean=(c - width, c + width), sigma=0.8) for c in CENTERS]
        for _ in range(3)
    ]


def gaussian() -> list[list[fuzzy2.Gaussian]]:
    return [[fuzzy2.Gaussian(mean=c, sigma=0.8) for c in CENTERS] for _ in range(3)]


def principal(sigma: float = 0.05) -> list[list[fuzzy2.GaussianType2Set]]:
    return [
        [
            fuzzy2.GaussianType2Set(principal=fuzzy2.Gaussian(mean=c, sigma=0.8), sigma=sigma)
            for c in CENTERS
        ]
        for _ in range(3)
    ]


@pytest.fixture(scope="module")
def consequents() -> Array:
    return np.random.default_rng(0).normal(size=(8, 4))


@pytest.fixture(scope="module")
def X() -> Array:
    return np.random.default_rng(1).uniform(-2.0, 2.0, size=(40, 3))


def by_hand(
    inputs: list[list[fuzzy2.GaussianUncertainMean]], rules: Array, z: Array, x: Array, norm: str
) -> Array:
    """Type-reduced intervals by enumeration of all switch points.

    From the sets' own membership functions.
    """
    firing = []
    for rule in rules:
        ends = []
        for end in ("lower", "upper"):
            grades = [float(getattr(inputs[i][t], end)(x[i])) for i, t in enumerate(rule) if t >= 0]
            ends.append(min(grades, default=1.0) if norm == "min" else float(np.prod(grades)))
        firing.append(ends)
    low, high = np.array(firing).T
    intervals = []
    for j in range(z.shape[1]):
        order = np.argsort(z[:, j])
        points, averages = z[order, j], ([], [])
        for k in range(len(points) + 1):
            for end, (first, second) in enumerate(((high, low), (low, high))):
                weights = np.concatenate([first[order][:k], second[order][k:]])
                averages[end].append(weights @ points / weights.sum())
        intervals.append((min(averages[0]), max(averages[1])))
    return np.array(intervals)


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


@pytest.mark.parametrize(
    "terms",
    [
        uncertain(),
        gaussian(),
        [
            [fuzzy2.GaussianUncertainSigma(mean=c, sigma=(0.5, 0.9)) for c in CENTERS]
            for _ in range(3)
        ],
        [[fuzzy2.Triangular(c - 2.5, c, c + 2.5) for c in CENTERS] for _ in range(3)],
        [
            [fuzzy2.Trapezoidal(c - 2.5, c - 0.5, c + 0.5, c + 2.5, height=0.9) for c in CENTERS]
            for _ in range(3)
        ],
        [
            [
                fuzzy2.Gaussian(mean=-1.0, sigma=1.0),
                fuzzy2.GaussianUncertainMean(mean=(0.5, 1.0), sigma=0.7),
            ]
            for _ in range(3)
        ],
    ],
)
@pytest.mark.parametrize("norm", ["product", "min"])
def test_compiled_loop_and_numpy_agree(
    terms: list[list[object]], norm: str, consequents: Array, X: Array
) -> None:
    """The same system by the compiled loop and by the sets themselves, to 1e-13.

    The sets are used because a fuzzifier's detour is forced.
    """
    fast = IntervalType2System(terms, GRID_RULES, consequents, t_norm=norm)
    slow = IntervalType2System(terms, GRID_RULES, consequents, t_norm=norm)
    assert fast._fast
    slow._table, slow._fast = None, False
    np.testing.assert_allclose(fast.firing(X), slow.firing(X), atol=1e-15)
    np.testing.assert_allclose(fast.type_reduced(X), slow.type_reduced(X), atol=1e-13)


def test_interval_consequents_and_many_scales(X: Array) -> None:
    """Intervals as consequents, against the generalized centroid.

    With outputs from 1e-9 to 1e9 in one rule base.
    """
    rng = np.random.default_rng(5)
    scales = 10.0 ** np.arange(-9, 10, 3)
    z = np.sort(rng.normal(size=(8, scales.size, 2)), axis=-1) * scales[:, np.newaxis]
    system = IntervalType2System(uncertain(), GRID_RULES, z)
    firing = system.firing(X)
    for j, scale in enumerate(scales):
        expected = fuzzy2.generalized_centroid(z[:, j], firing, "scan")
        np.testing.assert_allclose(
            system.type_reduced(X)[:, j],
            expected,
            rtol=0.0,
            atol=1e-12 * scale * np.abs(z[:, j] / scale).max(),
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
    np.testing.assert_allclose(system.type_reduced(X), expected, atol=1e-12)


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


def test_symmetric_consequents_center_of_sets_is_height(X: Array) -> None:
    """For normal, convex, symmetric consequents both take the same points (after eq. 1.78).

    1e-10 is the centroid's quadrature.
    """
    sets = [fuzzy2.Gaussian(mean=m, sigma=0.3) for m in np.linspace(-2.0, 2.0, 8)]
    by_sets, by_height = (
        IntervalType2System(uncertain(), GRID_RULES, sets, type_reduction=name)
        for name in ("center_of_sets", "height")
    )
    np.testing.assert_allclose(by_sets.type_reduced(X), by_height.type_reduced(X), atol=1e-10)


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
    )
    np.testing.assert_allclose(system([[2.0, 1.0], [7.0, 8.0]])[:, 0], [7.0169, 20.3414], atol=5e-5)


def test_linear_consequents(X: Array) -> None:
    """TSK: with exact linear consequents that agree the output is that function.

    It is that linear function whatever fires; 1e-12.
    """
    slopes = np.array([[0.5, 1.0, -2.0, 0.25]])
    system = IntervalType2System(
        uncertain(), GRID_RULES, Linear(np.broadcast_to(slopes, (8, 1, 4)))
    )
    np.testing.assert_allclose(system(X)[:, 0], 0.5 + X @ [1.0, -2.0, 0.25], atol=1e-12)
    rng = np.random.default_rng(7)
    coefficients, spreads = rng.normal(size=(8, 2, 4)), 0.1 * rng.random((8, 2, 4))
    system = IntervalType2System(uncertain(), GRID_RULES, Linear(coefficients, spreads))
    x = X[0]
    firing = system.firing(x)
    for j in range(2):
        middle = coefficients[:, j] @ [1.0, *x]
        half = spreads[:, j] @ [1.0, *np.abs(x)]
        expected = fuzzy2.generalized_centroid(np.stack([middle - half, middle + half], -1), firing)
        np.testing.assert_allclose(system.type_reduced(x)[j], expected, atol=1e-12)


def test_alpha_planes_are_interval_systems(consequents: Array, X: Array) -> None:
    """Each plane of the compiled loop against an interval system, to 1e-12.

    The system is made of the terms' own alpha-planes.
    """
    system = GeneralType2System(principal(), GRID_RULES, consequents, levels=4)
    cuts = system.alpha_cuts(X)
    assert cuts.shape == (40, 4, 4, 2)
    for level, alpha in enumerate(system.alphas):
        plane = IntervalType2System(
            [[t.alpha_plane(alpha) for t in terms] for terms in principal()],
            GRID_RULES,
            consequents,
        )
        np.testing.assert_allclose(cuts[:, :, level], plane.type_reduced(X), atol=1e-12)
    np.testing.assert_allclose(
        system(X), cuts.mean(axis=-1) @ (system.alphas / system.alphas.sum()), rtol=1e-13
    )
    assert (np.diff(cuts[..., 0], axis=-1) >= -1e-12).all(), "cuts are nested"
    np.testing.assert_array_equal(system.type_reduced(X), cuts[..., 0, :])


def test_general_type_2_consequents_have_a_centroid_on_every_plane(X: Array) -> None:
    """Each plane against the interval system of the planes of terms and consequents.

    Firing included; 1e-12.
    """
    sets = [
        fuzzy2.GaussianType2Set(
            principal=fuzzy2.Gaussian(mean=m, sigma=0.3), sigma=0.05, domain=(-4.0, 4.0)
        )
        for m in np.linspace(-2.0, 2.0, 8)
    ]
    system = GeneralType2System(principal(), GRID_RULES, sets, levels=3)
    cuts = system.alpha_cuts(X[:5])
    for level, alpha in enumerate(system.alphas):
        terms = [[t.alpha_plane(alpha) for t in of_input] for of_input in principal()]
        plane = IntervalType2System(terms, GRID_RULES, [item.alpha_plane(alpha) for item in sets])
        np.testing.assert_allclose(cuts[:, :, level], plane.type_reduced(X[:5]), atol=1e-12)
        if level == 0:
            np.testing.assert_allclose(system.firing(X[:5]), plane.firing(X[:5]), atol=1e-14)
            assert (system.firing(X[:5])[..., 0] < system.firing(X[:5])[..., 1]).all()
    with pytest.raises(NotApplicable, match="consequents"):
        GeneralType2System(principal(), GRID_RULES, sets, reduction="gaussian")
    unbounded = [fuzzy2.GaussianType2Set(principal=item.principal, sigma=0.05) for item in sets]
    with pytest.raises(NotApplicable):
        GeneralType2System(principal(), GRID_RULES, unbounded)


def test_validate_looks_at_the_principal_memberships() -> None:
    """Low planes of Gaussian secondaries reach above 0 everywhere.

    The gap between the terms must still be found.
    """
    terms = [
        [
            fuzzy2.GaussianType2Set(principal=fuzzy2.Gaussian(mean=m, sigma=0.2), sigma=0.05)
            for m in (-2.0, 2.0)
        ]
    ]
    report = GeneralType2System(terms, [[0], [1]], [[0.0], [1.0]]).validate(points=41)
    assert 0.3 < report.coverage < 0.6


@pytest.mark.parametrize("grades", ["min", "product"])
def test_gaussian_corollary_is_the_type_1_system_with_a_spread(
    grades: str, consequents: Array, X: Array
) -> None:
    """The crisp output does not depend on the uncertainty at all (eq. 1.107).

    The spread is eq. 1.108 written out, to 1e-12.
    """
    expected = Type1System(gaussian(), GRID_RULES, consequents)(X)
    for sigma in (0.001, 0.05):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ApproximationWarning)
            system = GeneralType2System(
                principal(sigma), GRID_RULES, consequents, reduction="gaussian", grade_t_norm=grades
            )
        np.testing.assert_allclose(system(X), expected, rtol=1e-12)
        x = X[3]
        grade = np.array(
            [[float(t.principal(x[i])) for t in terms] for i, terms in enumerate(principal(sigma))]
        )
        m = np.array([np.prod([grade[i, t] for i, t in enumerate(rule)]) for rule in GRID_RULES])
        s = np.array(
            [
                np.sqrt(sum((sigma * m[r] / grade[i, t]) ** 2 for i, t in enumerate(rule)))
                for r, rule in enumerate(GRID_RULES)
            ]
        )
        for j in range(4):
            away = consequents[:, j] - expected[3, j]
            spread = (
                np.sqrt(((away * s) ** 2).sum())
                if grades == "product"
                else (np.abs(away) * s).sum()
            )
            np.testing.assert_allclose(
                system.type_reduced(x)[j], [expected[3, j], spread / m.sum()], rtol=1e-12
            )
        assert system.validity(x) == pytest.approx(2.0 * s.sum() / m.sum(), rel=1e-12)


@pytest.mark.parametrize("grades", ["min", "product"])
def test_interval_consequents_of_the_corollary_reach_two_standard_deviations(
    grades: str, X: Array
) -> None:
    """Crisp terms, so that eq. 1.108 keeps the consequents' part alone.

    Sums of h (right − left)/4 over sum h; 1e-12.
    """
    z = np.sort(np.random.default_rng(8).normal(size=(8, 1, 2)), axis=-1)
    system = GeneralType2System(
        gaussian(), GRID_RULES, z, reduction="gaussian", grade_t_norm=grades
    )
    h = Type1System(gaussian(), GRID_RULES, np.zeros((8, 1))).firing(X[0])[:, 0]
    parts = h * (z[:, 0, 1] - z[:, 0, 0]) / 4.0
    spread = (np.sqrt((parts**2).sum()) if grades == "product" else parts.sum()) / h.sum()
    np.testing.assert_allclose(
        system.type_reduced(X[0])[0], [h @ z[:, 0].mean(axis=1) / h.sum(), spread], rtol=1e-12
    )


def test_one_warning_at_construction_and_none_per_call(consequents: Array, X: Array) -> None:
    with pytest.warns(ApproximationWarning) as caught:
        system = GeneralType2System(principal(0.05), GRID_RULES, consequents, reduction="gaussian")
    assert len(caught) == 1
    system(X)
    GeneralType2System(principal(0.001), GRID_RULES, consequents, reduction="gaussian")


def test_no_rule_fires_is_nan_and_validate_says_where() -> None:
    terms = [[fuzzy2.Triangular(0.0, 1.0, 2.0), fuzzy2.Triangular(4.0, 5.0, 6.0)]]
    system = Type1System(terms, [[0], [1]], [[1.0], [2.0]])
    assert np.isnan(system([[3.0]])).all()
    assert np.isnan(system.type_reduced([3.0])).all()
    assert np.isnan(system.validity([3.0]))
    report = system.validate(points=41)
    assert not report.ok
    np.testing.assert_allclose(
        [report.uncovered.min(), report.uncovered.max()], [2.0, 4.0], atol=0.1
    )
    assert "no rule fires on" in str(report)


def test_the_domain_of_shoulders_ends_where_they_are_almost_flat() -> None:
    """A sigmoid never reaches its height.

    It is at 0.98 of it four reciprocal slopes behind its center.
    """
    system = Type1System([[Sigmoid(-1.0, -4.0), Sigmoid(1.0, 2.0)]], [[0], [1]], [[0.0], [1.0]])
    np.testing.assert_allclose(system.domain(), [[-2.0, 3.0]], rtol=1e-14)
    assert system.validate().ok


def test_validate_finds_unused_terms_duplicates_and_conflicts() -> None:
    rules = [[0, 0], [0, 0], [0, 0], [1, 0]]
    system = IntervalType2System(
        uncertain()[:2],
        rules,
        [[1.0], [1.0], [2.0], [3.0]],
        input_names=["e", "de"],
        term_names=[["N", "P"]] * 2,
    )
    report = system.validate()
    assert report.unused_terms == [("de", "P")]
    assert report.duplicate_rules == [(0, 1)]
    assert report.conflicting_rules == [(0, 2)]
    assert IntervalType2System(uncertain(), GRID_RULES, np.ones((8, 1))).validate().ok


def test_embedded_type_1_systems_fill_the_interval(consequents: Array, X: Array) -> None:
    """Fig. 7: all within the type-reduced interval.

    Its ends are among them for the first output; 1e-12.
    """
    system = IntervalType2System(uncertain(), GRID_RULES, consequents)
    outputs = np.array(list(system.embedded_outputs(X[0], 500, np.random.default_rng(3))))
    interval = system.type_reduced(X[0])
    assert (outputs >= interval[:, 0] - 1e-12).all()
    assert (outputs <= interval[:, 1] + 1e-12).all()
    np.testing.assert_allclose([outputs[:, 0].min(), outputs[:, 0].max()], interval[0], atol=1e-12)


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
        ({"type_reduction": "centroid"}, NotApplicable, "no sets"),
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
    "options",
    [
        {"grade_t_norm": "product"},
        {"reduction": "gaussian", "t_norm": "min"},
        {"reduction": "gaussian", "inputs": uncertain()},
    ],
)
def test_general_systems_refuse_what_has_no_meaning(options: dict[str, object]) -> None:
    """Product grades under alpha-planes depend on the grid.

    The corollary needs Gaussian grades and the product.
    """
    arguments: dict[str, object] = {
        "inputs": principal(),
        "rules": GRID_RULES,
        "consequents": np.zeros((8, 1)),
    } | options
    with pytest.raises(NotApplicable):
        GeneralType2System(**arguments)  # type: ignore[arg-type]


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


@pytest.mark.parametrize("norm", ["product", "min"])
@pytest.mark.parametrize("crisp", [True, False])
def test_many_rows_give_what_each_row_gives(norm: str, crisp: bool) -> None:
    """To the last bit: rows side by side take the steps of a single row in the same order.

    The rows reach far out, where lower firing strengths vanish, firing strengths differ by more
    digits than a float has or no rule fires, and consequents repeat, so that comparisons tie.
    """
    generator = np.random.default_rng(5)
    z = np.round(generator.normal(size=(8, 4)), 1)
    z[:, 1] = 1.0
    intervals = np.stack([z, z + np.abs(np.round(generator.normal(size=z.shape), 1))], axis=-1)
    X = np.concatenate(
        [
            generator.uniform(-2.0, 2.0, (200, 3)),
            generator.uniform(-40.0, 40.0, (150, 3)),
            np.zeros((5, 3)),
        ]
    )
    for consequents in (z, intervals):
        system = IntervalType2System(uncertain(), GRID_RULES, consequents, t_norm=norm)
        evaluate = system if crisp else system.type_reduced
        assert np.isnan(evaluate(X)).any()
        np.testing.assert_array_equal(evaluate(X), np.array([evaluate(x) for x in X]))


def test_many_rows_whose_lower_firing_strengths_all_vanish(consequents: Array) -> None:
    """Means so uncertain that every lower grade underflows to 0.

    Each end is that of the extreme consequent alone, exactly.

    Upper grades are 1 everywhere, so a rule may take any weight from 0 to 1.
    """
    system = IntervalType2System(uncertain(width=60.0), GRID_RULES, consequents)
    X = np.random.default_rng(6).uniform(-2.0, 2.0, (MANY, 3))
    assert (system.firing(X) == [0.0, 1.0]).all()
    extremes = np.stack([consequents.min(axis=0), consequents.max(axis=0)], axis=-1)
    np.testing.assert_array_equal(system.type_reduced(X), np.broadcast_to(extremes, (MANY, 4, 2)))


def test_many_rows_whose_end_is_a_consequent_itself() -> None:
    """One consequent lies on the end that all others make.

    So the comparison that finds the switch point ties, up to rounding.

    Many rows give to the last bit what one gives, and 1e-12 is the bar of exact reduction.
    """
    generator = np.random.default_rng(7)
    for x in generator.uniform(-2.0, 2.0, (20, 3)):
        z, k = generator.normal(size=(8, 1)), int(generator.integers(8))
        strengths, others = (
            IntervalType2System(uncertain(), GRID_RULES, z).firing(x),
            np.arange(8) != k,
        )
        z[k] = fuzzy2.generalized_centroid(z[others, 0], strengths[others])[0]
        system = IntervalType2System(uncertain(), GRID_RULES, z)
        found = system.type_reduced(np.tile(x, (MANY, 1)))
        np.testing.assert_array_equal(found, np.broadcast_to(system.type_reduced(x), found.shape))
        np.testing.assert_allclose(
            found[0], by_hand(uncertain(), GRID_RULES, z, x, "product"), rtol=0.0, atol=1e-12
        )


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


@pytest.mark.parametrize("points", [1, 2.5, True, [[-3.0, 3.0]], None])
def test_validate_takes_a_number_of_points(points: object, consequents: Array) -> None:
    with pytest.raises(InvalidValue, match="points"):
        IntervalType2System(
            uncertain(),
            GRID_RULES,
            consequents,  # type: ignore[arg-type]
        ).validate(points)
