"""Approximate generalized centroid.

Against eq. 1.85 in fuzzy numbers, exact reduction, errata numbers, and where it is exact.
"""

from __future__ import annotations

import pickle
import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from fuzzy2.errors import ApproximationWarning, InvalidValue, NotApplicable, UnknownName
from fuzzy2.numbers import FuzzyNumber, GaussianNumber, IntervalNumber
from fuzzy2.reduction.approximate import (
    VALIDITY_LIMIT,
    ApproximateReduction,
    approximate_centroid,
    approximate_generalized_centroid,
)
from fuzzy2.reduction.interval import generalized_centroid
from fuzzy2.sets.interval_type2 import GaussianUncertainMean
from fuzzy2.sets.shapes import Gaussian, Triangular

NORMS = ("product", "min")
Number = IntervalNumber | GaussianNumber
rng = np.random.default_rng(7)


def random_numbers(
    kind: str, shape: tuple[int, ...], width: float, seed: int = 0
) -> tuple[Number, Number]:
    source = np.random.default_rng(seed)
    c, s = source.normal(size=shape), source.uniform(0.0, 0.4, shape)
    h = source.uniform(0.3, 1.0, shape)
    delta = width * source.uniform(0.5, 1.0, shape) * h
    if kind == "interval":
        return IntervalNumber(c, s), IntervalNumber(h, delta)
    return GaussianNumber(c, s, kind), GaussianNumber(h, delta, kind)


def by_equation_1_85(Z: Number, W: Number) -> Number:
    """Theorem 1.6 literally, in the algebra of fuzzy numbers (Theorems 1.4 and 1.5).

    The reduction itself does not use it.
    """
    c, h = Z.defuzzify(), W.defuzzify()
    total = h.sum(axis=-1, keepdims=True)
    xi = (h * c).sum(axis=-1, keepdims=True) / total
    return ((Z - c) * (h / total)).sum() + ((W - h) * ((c - xi) / total)).sum() + xi[..., 0]


@pytest.mark.parametrize("kind", ["interval", "product", "min"])
@pytest.mark.parametrize("shape", [(1,), (2,), (16,), (5, 16), (2, 3, 7)])
def test_is_theorem_1_6_in_the_algebra_of_fuzzy_numbers(kind: str, shape: tuple[int, ...]) -> None:
    """Both are sums of the same few terms: 1e-13 is rounding."""
    Z, W = random_numbers(kind, shape, 0.3)
    found, expected = approximate_generalized_centroid(Z, W), by_equation_1_85(Z, W)
    assert found.value.shape == expected.shape == shape[:-1]
    assert found.validity.shape == shape[:-1]
    np.testing.assert_allclose(found.value.defuzzify(), expected.defuzzify(), atol=1e-13)
    np.testing.assert_allclose(found.value.interval(0.5), expected.interval(0.5), atol=1e-13)


@pytest.mark.parametrize("kind", ["interval", "min"])
def test_alpha_cuts_agree_with_the_closed_forms(kind: str) -> None:
    """The cuts of both are affine in one width.

    So arithmetic on them is the same up to rounding at levels that are held.
    """
    Z, W = random_numbers(kind, (4, 6), 0.2)
    by_cuts = approximate_generalized_centroid(FuzzyNumber.of(Z), FuzzyNumber.of(W)).value
    closed = approximate_generalized_centroid(Z, W).value
    for alpha in (0.5, 1.0):
        np.testing.assert_allclose(by_cuts.interval(alpha), closed.interval(alpha), atol=1e-12)


def test_validity_measures() -> None:
    """Eq. 1.88 and 1.104 with k = 1, eq. 1.109 with k = 2; cuts count half their support."""
    h, delta = np.array([0.5, 0.3, 0.2]), np.array([0.02, 0.03, 0.05])
    assert approximate_generalized_centroid(
        [1.0, 2.0, 3.0], IntervalNumber(h, delta)
    ).validity == pytest.approx(0.1, abs=1e-15)
    assert approximate_generalized_centroid(
        [1.0, 2.0, 3.0], GaussianNumber(h, delta)
    ).validity == pytest.approx(0.2, abs=1e-15)
    cuts = FuzzyNumber.of(IntervalNumber(h, delta))
    assert approximate_generalized_centroid([1.0, 2.0, 3.0], cuts).validity == pytest.approx(
        0.1, abs=1e-15
    )


@pytest.mark.parametrize("norm", NORMS)
def test_exact_where_weights_are_crisp(norm: str) -> None:
    """Eq. 1.102: the weighted sum of fuzzy points is exact, so it must agree with the algebra.

    Validity is 0.
    """
    Z = GaussianNumber(rng.normal(size=(3, 5)), rng.uniform(0.1, 2.0, (3, 5)), norm)
    h = rng.uniform(0.1, 1.0, 5)
    found = approximate_generalized_centroid(Z, h, norm)
    expected = (Z * (h / h.sum())).sum()
    np.testing.assert_allclose(found.value.mean, expected.mean, atol=1e-14)
    np.testing.assert_allclose(found.value.sigma, expected.sigma, atol=1e-14)
    np.testing.assert_array_equal(found.validity, np.zeros(3))


def test_interval_points_with_crisp_weights_reduce_exactly() -> None:
    """Eq. 1.102 against the exact reducer, which knows nothing of the approximation."""
    Z = IntervalNumber(rng.normal(size=8), rng.uniform(0.1, 2.0, 8))
    h = rng.uniform(0.1, 1.0, 8)
    found = approximate_generalized_centroid(Z, h)
    np.testing.assert_allclose(
        found.value.interval(1.0),
        generalized_centroid(Z.interval(), np.stack([h, h], axis=-1)),
        atol=1e-14,
    )


def test_two_crisp_operands_make_an_interval_without_width() -> None:
    found = approximate_generalized_centroid([1.0, 3.0], [1.0, 3.0])
    assert isinstance(found.value, IntervalNumber)
    assert (float(found.value.center), float(found.value.spread), float(found.validity)) == (
        2.5,
        0.0,
        0.0,
    )


@pytest.mark.parametrize("kind", ["interval", "product", "min"])
def test_one_rule_gives_the_consequent(kind: str) -> None:
    """Eq. 1.77 and 1.82: of one rule the output is its consequent, whatever the weight.

    A crisp consequent gives a point.
    """
    Z, W = random_numbers(kind, (4, 1), 0.5)
    found = approximate_generalized_centroid(Z, W).value
    np.testing.assert_allclose(found.interval(0.6), Z[..., 0].interval(0.6), atol=1e-15)
    point = approximate_generalized_centroid(Z.defuzzify(), W).value
    np.testing.assert_array_equal(point.interval(0.6)[..., 0], point.interval(0.6)[..., 1])


def test_error_against_exact_reduction_is_of_second_order() -> None:
    """A tenth of the uncertainty leaves a hundredth of the error.

    60 to 160 allows for the next order.
    """
    errors = []
    for width in (0.1, 0.01):
        Z, W = random_numbers("interval", (50, 9), width, seed=3)
        Z = IntervalNumber(Z.defuzzify(), 0.0)
        found = approximate_generalized_centroid(Z, W).value
        exact = generalized_centroid(Z.interval(1.0), W.interval(1.0))
        errors.append(np.abs(found.interval(1.0) - exact).max())
    assert 60.0 < errors[0] / errors[1] < 160.0


def test_published_standard_deviation_of_eq_1_108() -> None:
    """The misprint of eq. 1.108 multiplies the two squares.

    It gives nothing near what the theorem, or enumeration, gives.
    """
    Z, W = (
        GaussianNumber([1.0, 2.0, 3.0], [0.2, 0.3, 0.1]),
        GaussianNumber([0.5, 0.8, 0.4], [0.01, 0.02, 0.01]),
    )
    h, m, sigma, delta = W.mean, Z.mean, Z.sigma, W.sigma
    varsigma = float((h * m).sum() / h.sum())
    printed = np.sqrt(((h * sigma) ** 2 * (m - varsigma) ** 2 * delta**2).sum()) / h.sum()
    found = float(approximate_generalized_centroid(Z, W).value.sigma)
    assert found > 20.0 * printed
    # Under the product the cut at exp(-1/2) is the range of the average over the ball of one
    # standard deviation; from any direction the steps to the direction of its gradient converge,
    # for it is almost linear there.
    ends = []
    for sign in (-1.0, 1.0):
        direction = np.zeros(6)
        for _ in range(100):
            z, w = m + sigma * direction[:3], h + delta * direction[3:]
            y = (z * w).sum() / w.sum()
            gradient = sign * np.concatenate([sigma * w, delta * (z - y)]) / w.sum()
            direction = gradient / np.linalg.norm(gradient)
        ends.append(y)
    # The ends differ from the first order by terms of the second; half their distance by terms of
    # the third, 1e-4 here.
    assert found == pytest.approx(0.5 * (ends[1] - ends[0]), abs=1e-4)


def test_no_factor_k_in_eq_1_108() -> None:
    """Under the minimum the α-cut is the exact interval reduction of the α-cuts.

    The spread must match it without a factor k.
    """
    Z, W = (
        GaussianNumber([1.0, 2.0, 3.5], [0.2, 0.3, 0.1], "min"),
        GaussianNumber([0.5, 0.8, 0.4], [0.002, 0.004, 0.002], "min"),
    )
    found = approximate_generalized_centroid(Z, W)
    alpha = np.exp(-0.5)  # one standard deviation
    exact = generalized_centroid(Z.interval(alpha), W.interval(alpha))
    # What is left out is at most 2 max s (sum of Δ) / (sum of h) (eq. 1.97 corrected), plus terms
    # of the second order in Δ.
    np.testing.assert_allclose(
        found.value.interval(alpha), exact, atol=2.0 * 0.3 * 0.008 / 1.7 + 1e-4
    )
    assert abs(2.0 * float(found.value.sigma) - 0.5 * float(np.diff(exact)[0])) > 0.1


def test_centroid_of_a_gaussian_with_uncertain_mean_of_the_errata() -> None:
    """Eq. 1.106 where its condition fails.

    Validity .70 and [4.041, 5.959] where [3.907, 6.093] is exact. Three digits are given.
    """
    x = np.linspace(0.0, 10.0, 101)
    footprint = GaussianUncertainMean(mean=(4.0, 6.0), sigma=1.0).footprint(x)
    W = IntervalNumber(footprint.mean(axis=-1), 0.5 * np.diff(footprint)[..., 0])
    found = approximate_centroid(x, W)
    assert isinstance(found.value, IntervalNumber)
    np.testing.assert_allclose(found.value.interval(1.0), [4.041, 5.959], atol=6e-4)
    assert found.validity == pytest.approx(0.70, abs=6e-3)
    exact = generalized_centroid(x, footprint)
    np.testing.assert_allclose(exact, [3.907, 6.093], atol=6e-4)


def test_centroid_of_a_gaussian_type_2_set_uses_the_minimum() -> None:
    """Eq. 1.112-1.114, written out, for memberships that are meant for the product as well."""
    x = np.linspace(0.0, 4.0, 21)
    m, sigma = Gaussian(2.3, 0.7)(x), 0.01 * Gaussian(2.0, 1.0)(x)
    for norm in NORMS:
        found = approximate_centroid(x, GaussianNumber(m, sigma, norm))
        assert isinstance(found.value, GaussianNumber)
        assert found.value.t_norm == "min"
        varsigma = (x * m).sum() / m.sum()
        assert float(found.value.mean) == pytest.approx(varsigma, abs=1e-14)
        assert float(found.value.sigma) == pytest.approx(
            (np.abs(x - varsigma) * sigma).sum() / m.sum(), abs=1e-14
        )
        assert float(found.validity) == pytest.approx(2.0 * sigma.sum() / m.sum(), abs=1e-14)


def test_centroid_under_the_product_collapses() -> None:
    """Errata: .0375, .0119, .0038 for 11, 101 and 1001 points under the product.

    Under the minimum the width stays.
    """
    widths: dict[str, list[float]] = {"product": [], "min": []}
    for count in (11, 101, 1001):
        x = np.linspace(0.0, 10.0, count)
        principal = Gaussian(5.0, 1.0)(x)
        for norm in NORMS:
            weights = GaussianNumber(principal, 0.1 * principal)
            widths[norm].append(
                float(approximate_generalized_centroid(x, weights, norm).value.sigma)
            )
    # half a unit of the last digit
    np.testing.assert_allclose(widths["product"], [0.0375, 0.0119, 0.0038], atol=5e-5)
    # The sums have converged to their integrals but for the coarsest grid: 2 (0.1) / sqrt(2 pi).
    np.testing.assert_allclose(widths["min"], 0.2 / np.sqrt(2.0 * np.pi), rtol=0.1)


def test_defuzzified_output_does_not_see_the_uncertainty() -> None:
    """Errata on eq. 1.107: the center is the type-1 output for any uncertainty."""
    Z, W = random_numbers("product", (6, 9), 0.0)
    type1 = (Z.defuzzify() * W.defuzzify()).sum(axis=-1) / W.defuzzify().sum(axis=-1)
    for width in (0.01, 0.1, 1.0):
        Z, W = random_numbers("product", (6, 9), width)
        np.testing.assert_allclose(
            approximate_generalized_centroid(Z, W).value.defuzzify(), type1, atol=1e-13
        )


@given(
    c=arrays(float, 5, elements=st.floats(-1.0, 1.0)),
    h=arrays(float, 5, elements=st.floats(0.01, 1.0)),
    scale=st.sampled_from([1e-9, 1e-3, 1.0, 1e9]),
    offset=st.floats(-1e3, 1e3),
)
@settings(max_examples=200, deadline=None)
def test_follows_scale_and_offset_of_the_output(
    c: np.ndarray, h: np.ndarray, scale: float, offset: float
) -> None:
    """An affine change of the points is that of the result, up to rounding at the offset."""
    for W in (
        IntervalNumber(h, 0.1 * h),
        GaussianNumber(h, 0.1 * h),
        GaussianNumber(h, 0.1 * h, "min"),
    ):
        base = approximate_generalized_centroid(c, W).value
        moved = approximate_generalized_centroid(scale * (c + offset), W).value
        tolerance = 1e-14 * scale * (1.0 + abs(offset))
        np.testing.assert_allclose(
            moved.interval(0.5),
            scale * (base.interval(0.5) + offset),
            rtol=0.0,
            atol=4.0 * tolerance,
        )


@given(
    h=arrays(float, 4, elements=st.floats(0.05, 1.0)),
    share=arrays(float, 4, elements=st.floats(0.0, 0.2)),
)
@settings(max_examples=200, deadline=None)
def test_error_is_bounded_by_the_validity(h: np.ndarray, share: np.ndarray) -> None:
    """Crisp points: what eq. 1.91 leaves out is at most v²/(1 - v) of the range of the points.

    Here v is the validity.
    """
    c = np.array([-1.0, 0.2, 0.4, 1.0])
    W = IntervalNumber(h, share * h)
    found = approximate_generalized_centroid(c, W)
    exact = generalized_centroid(c, W.interval())
    v = float(found.validity)
    assert np.abs(found.value.interval() - exact).max() <= 2.0 * v * v / (1.0 - v) + 1e-14


def test_arbitrary_convex_sets_as_points_and_weights() -> None:
    """Eq. 1.85 of triangles: at each level an affine combination of the ends, written out here."""
    Z = [Triangular(0.5, 1.0, 1.2), Triangular(1.8, 2.0, 2.5)]
    W = [Triangular(0.55, 0.6, 0.61), Triangular(0.28, 0.3, 0.34)]
    found = approximate_generalized_centroid(Z, W)
    assert isinstance(found.value, FuzzyNumber)
    c, h = np.array([0.85, 2.15]), np.array([0.58, 0.31])
    xi = (h * c).sum() / h.sum()
    for alpha in (0.5, 1.0):
        z = np.array([fuzzy_set.alpha_cut(alpha) for fuzzy_set in Z]).T - c
        w = np.array([fuzzy_set.alpha_cut(alpha) for fuzzy_set in W]).T - h
        share, slope = h / h.sum(), (c - xi) / h.sum()
        left = (z[0] * share).sum() + np.minimum(w[0] * slope, w[1] * slope).sum() + xi
        right = (z[1] * share).sum() + np.maximum(w[0] * slope, w[1] * slope).sum() + xi
        # The levels held are near 0.5 but not on it for every number; ends are linear between them.
        np.testing.assert_allclose(found.value.interval(alpha), [left, right], atol=1e-12)
    assert found.validity == pytest.approx((0.03 + 0.03) / 0.89, abs=1e-14)


def test_numbers_of_different_kinds_meet_in_alpha_cuts() -> None:
    found = approximate_generalized_centroid(
        IntervalNumber([1.0, 2.0], 0.1), GaussianNumber([0.5, 0.5], 0.01), "min"
    )
    assert isinstance(found.value, FuzzyNumber)
    np.testing.assert_allclose(found.value.interval(1.0), [1.4, 1.6], atol=1e-12)
    with pytest.raises(NotApplicable, match="minimum"):
        approximate_generalized_centroid(
            IntervalNumber([1.0, 2.0], 0.1), GaussianNumber([0.5, 0.5], 0.01), "product"
        )
    with pytest.raises(NotApplicable):
        approximate_generalized_centroid(
            IntervalNumber([1.0, 2.0], 0.1), GaussianNumber([0.5, 0.5], 0.01)
        )


def test_no_rule_fires_is_nan() -> None:
    for W in (
        IntervalNumber([[0.0, 0.0], [0.5, 0.5]], 0.0),
        GaussianNumber([[0.0, 0.0], [0.5, 0.5]], 0.1),
    ):
        found: ApproximateReduction = approximate_generalized_centroid([1.0, 2.0], W)
        np.testing.assert_array_equal(np.isnan(found.value.defuzzify()), [True, False])
        np.testing.assert_array_equal(np.isnan(found.validity), [True, False])
    with pytest.raises(InvalidValue, match="no output"):
        approximate_generalized_centroid([1.0, 2.0], FuzzyNumber.of([0.0, 0.0]))


def test_the_t_norm_given_counts() -> None:
    Z, W = GaussianNumber([1.0, 2.0], 0.1, "min"), GaussianNumber([0.5, 0.4], 0.01, "product")
    with pytest.raises(NotApplicable, match="say which one counts"):
        approximate_generalized_centroid(Z, W)
    narrow, wide = (
        float(approximate_generalized_centroid(Z, W, norm).value.sigma)
        for norm in ("product", "min")
    )
    assert narrow < wide


@pytest.mark.parametrize(
    ("Z", "W", "message"),
    [
        ([1.0, 2.0, 3.0], IntervalNumber([1.0, 1.0], 0.1), "as many points as weights"),
        ([1.0, np.nan], IntervalNumber([1.0, 1.0], 0.1), "Z must be finite"),
        (
            [1.0, 2.0],
            IntervalNumber([1.0, -1.0], 0.1),
            "W must be finite, with centers of at least 0",
        ),
        ([1.0, 2.0], IntervalNumber([1.0, np.inf], 0.1), "W must be finite"),
        (1.0, IntervalNumber([1.0], 0.1), "at least one number"),
        ([], IntervalNumber([], []), "at least one number"),
        ("ab", IntervalNumber([1.0], 0.1), "real numbers"),
    ],
)
def test_refused_operands(Z: object, W: IntervalNumber, message: str) -> None:
    with pytest.raises(InvalidValue, match=message):
        approximate_generalized_centroid(Z, W)


def test_unknown_t_norm() -> None:
    with pytest.raises(UnknownName, match="product, min"):
        approximate_generalized_centroid([1.0], GaussianNumber([1.0], 0.1), "mean")


def test_the_warning_carries_its_values() -> None:
    """Through pickling too, as errors do; the functions themselves never warn."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        rough = approximate_generalized_centroid([1.0, 2.0], IntervalNumber([0.5, 0.5], 0.4))
    assert rough.validity > VALIDITY_LIMIT
    warning = pickle.loads(
        pickle.dumps(ApproximationWarning("a system", float(rough.validity), VALIDITY_LIMIT))
    )
    assert (warning.what, warning.validity, warning.limit) == ("a system", pytest.approx(0.8), 0.1)
    assert "a system has a validity measure of 0.8, above 0.1" in str(warning)
