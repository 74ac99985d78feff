"""General type-2 systems: alpha planes, the Gaussian corollary, and what has no meaning."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from numpy.typing import NDArray

import fuzzy2
from fuzzy2.errors import ApproximationWarning, NotApplicable
from fuzzy2.systems import GeneralType2System, IntervalType2System, Type1System
from tests.fuzzy2.systems.by_hand import (
    GRID_RULES,
    gaussian,
    principal,
    uncertain,
)

Array = NDArray[np.float64]


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


def test_united_points_are_the_same_on_all_planes() -> None:
    """Domains of single points have no width, which no range of an output may have."""
    points = [[fuzzy2.Triangular(m, m, m)] for m in np.linspace(-1.0, 2.5, 8)]
    alike = [[fuzzy2.Triangular(0.5, 0.5, 0.5)]] * 8
    X = np.random.default_rng(3).uniform(-1.0, 1.0, (5, 3))
    for sets in (points, alike):
        system = GeneralType2System(gaussian(), GRID_RULES, sets, type_reduction="centroid")
        centers = [[item.centroid()] for (item,) in sets]
        # The product leaves points at the height of the firing, as center of sets weighs them.
        right = GeneralType2System(gaussian(), GRID_RULES, centers, t_conorm="sum")
        if sets is alike:
            np.testing.assert_allclose(system(X), np.full((5, 1), 0.5), rtol=1e-14)
        else:
            np.testing.assert_allclose(system(X), right(X), rtol=1e-12)


@pytest.mark.parametrize("t_norm", ["product", "min"])
def test_a_default_holds_on_all_planes_or_on_none(t_norm: str) -> None:
    """Beyond the end of the only term its grade is 0, and may be above 0 on the lower plane alone.

    Without a default the lowest cut is known, and the answer is not.
    """
    term = fuzzy2.GaussianType2Set(fuzzy2.Triangular(-1.0, 0.0, 1.0), sigma=0.02)
    x = [[3.0], [0.05]]

    def system(defaults: list[float | None] | None) -> GeneralType2System:
        return GeneralType2System(
            [[term]], [[0]], [[4.0, 8.0]], t_norm, levels=2, default_outputs=defaults
        )

    without = system(None).alpha_cuts(x)
    np.testing.assert_array_equal(np.isnan(without[0, :, :, 0]), [[False, True]] * 2)
    np.testing.assert_array_equal(system(None)(x), [[np.nan, np.nan], [4.0, 8.0]])
    some = system([1.0, None])
    cuts = some.alpha_cuts(x)
    np.testing.assert_array_equal(cuts[0, 0], np.ones((2, 2)))
    np.testing.assert_array_equal(cuts[0, 1], without[0, 1])
    np.testing.assert_array_equal(cuts[1], without[1])
    np.testing.assert_array_equal(some(x), [[1.0, np.nan], [4.0, 8.0]])
