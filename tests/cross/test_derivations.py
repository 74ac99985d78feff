"""Every step of the derivations of chapter 1, as numbers.

Theorem 1.1 (1.16-1.27), 1.3 (1.31-1.42), 1.5 (1.49-1.60), 1.6 (1.89-1.102).

Where a step is misprinted, the test states what was printed and shows that it does not hold.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from fuzzy2.numbers import (
    FuzzyNumber,
    GaussianNumber,
    IntervalNumber,
    gaussian_meet,
    gaussian_meet_error,
)
from fuzzy2.operations.extension import extend
from fuzzy2.operations.join_meet import join, meet
from fuzzy2.operations.joined_sets import supremum
from fuzzy2.reduction.approximate import ApproximateReduction, approximate_generalized_centroid
from fuzzy2.reduction.general import exhaustive_generalized_centroid
from fuzzy2.reduction.interval import generalized_centroid
from fuzzy2.sets.shapes import Gaussian, Trapezoidal, Triangular
from fuzzy2.sets.type1 import SampledSet, Type1Set

# Theorem 1.1
# --------------------------------------------------------------------------------------------------
# Convex normal sets with peaks v1 <= v2 <= v3. They cross left of v1 and right of v3, lest a wrong
# "and" or "or" go unnoticed.

F1, F2, F3 = Triangular(-0.3, 0.3, 1.2), Gaussian(0.5, 0.35), Trapezoidal(0.1, 0.8, 0.8, 1.6)
V1, V2, V3 = 0.3, 0.5, 0.8
# a step of 0.001, with all peaks among the points
THETA = np.round(np.linspace(-0.5, 2.0, 2501), 12)
BELOW, BETWEEN, ABOVE = THETA < V1, (THETA >= V1) & (THETA < V2), THETA >= V2
f1, f2, f3 = F1(THETA), F2(THETA), F3(THETA)

# What comes before the first point of the grid is less than F2 there, 0.02, and plays no part in
# any maximum.
PHI1 = np.minimum(f1, np.maximum.accumulate(f2))
PHI2 = np.minimum(f2, np.maximum.accumulate(f1))


def suprema_up_to(theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return both suprema of eq. 1.17, for which the library never looks at a grid."""
    start = np.full_like(theta, -np.inf)
    return (
        np.minimum(F1(theta), supremum(F2, start, theta)),
        np.minimum(F2(theta), supremum(F1, start, theta)),
    )


def test_1_16_the_join_is_an_enumeration_of_pairs() -> None:
    coarse = np.round(np.linspace(-0.5, 2.0, 126), 12)
    a, b = SampledSet(coarse, F1(coarse)), SampledSet(coarse, F2(coarse))
    best = dict.fromkeys(coarse.tolist(), 0.0)
    for v, grade_v in zip(coarse.tolist(), a.grades, strict=True):
        for w, grade_w in zip(coarse.tolist(), b.grades, strict=True):
            best[max(v, w)] = max(best[max(v, w)], min(grade_v, grade_w))
    found = join(a, b)
    assert isinstance(found, SampledSet)
    np.testing.assert_array_equal(found.points, list(best))
    np.testing.assert_array_equal(found.grades, list(best.values()))


def test_1_17_the_join_is_the_greater_of_two_suprema() -> None:
    np.testing.assert_allclose(join(F1, F2)(THETA), np.maximum(PHI1, PHI2), atol=1e-15)


def test_1_18_below_both_peaks_both_suprema_are_the_minimum() -> None:
    found = suprema_up_to(THETA)
    for phi, by_grid in zip(found, (PHI1, PHI2), strict=True):
        np.testing.assert_allclose(phi[BELOW], np.minimum(f1, f2)[BELOW], atol=1e-15)
        np.testing.assert_allclose(phi, by_grid, atol=1e-15)


def test_1_19_below_both_peaks_it_is_and_where_or_is_printed() -> None:
    found = join(F1, F2)(THETA)[BELOW]
    np.testing.assert_allclose(found, np.minimum(f1, f2)[BELOW], atol=1e-15)
    assert np.abs(found - np.maximum(f1, f2)[BELOW]).max() > 0.1


def test_1_20_between_the_peaks() -> None:
    found = suprema_up_to(THETA)
    np.testing.assert_allclose(found[0][BETWEEN], np.minimum(f1, f2)[BETWEEN], atol=1e-15)
    np.testing.assert_allclose(found[1][BETWEEN], f2[BETWEEN], atol=1e-15)
    for phi, by_grid in zip(found, (PHI1, PHI2), strict=True):
        np.testing.assert_allclose(phi[BETWEEN], by_grid[BETWEEN], atol=1e-15)


def test_1_21_between_the_peaks_the_join_is_the_second_set() -> None:
    np.testing.assert_allclose(join(F1, F2)(THETA)[BETWEEN], f2[BETWEEN], atol=1e-15)


def test_1_22_above_both_peaks_both_suprema_are_the_sets() -> None:
    """The thesis names this range by a v3; it is from v2 on."""
    found = suprema_up_to(THETA)
    np.testing.assert_allclose(found[0][ABOVE], f1[ABOVE], atol=1e-15)
    np.testing.assert_allclose(found[1][ABOVE], f2[ABOVE], atol=1e-15)
    for phi, by_grid in zip(found, (PHI1, PHI2), strict=True):
        np.testing.assert_allclose(phi[ABOVE], by_grid[ABOVE], atol=1e-15)


def test_1_23_above_both_peaks_the_join_is_the_maximum() -> None:
    np.testing.assert_allclose(join(F1, F2)(THETA)[ABOVE], np.maximum(f1, f2)[ABOVE], atol=1e-15)


def join_of_two(
    theta: np.ndarray, first: Type1Set, second: Type1Set, v1: float, v2: float
) -> np.ndarray:
    """Equation 1.24."""
    a, b = first(theta), second(theta)
    return np.where(theta < v1, np.minimum(a, b), np.where(theta < v2, b, np.maximum(a, b)))


def test_1_24_all_three_ranges_and_the_join_is_convex_and_normal() -> None:
    expected = join_of_two(THETA, F1, F2, V1, V2)
    joined = join(F1, F2)
    np.testing.assert_allclose(joined(THETA), expected, atol=1e-15)
    assert joined.is_convex()
    assert joined.is_normal()
    assert SampledSet(THETA, expected).is_convex()
    assert float(joined(V2)) == 1.0
    assert (np.diff(expected[THETA <= V2]) >= 0.0).all()
    assert (np.diff(expected[THETA >= V2]) <= 0.0).all()


def test_1_25_to_1_27_by_induction_to_three_sets() -> None:
    two = join_of_two(THETA, F1, F2, V1, V2)
    by_1_25 = np.where(
        THETA < V2, np.minimum(two, f3), np.where(THETA < V3, f3, np.maximum(two, f3))
    )
    by_1_26 = np.where(THETA < V1, np.minimum(f1, f2), np.where(THETA < V2, f2, np.maximum(f1, f2)))
    np.testing.assert_array_equal(two, by_1_26)
    all_and, all_or = np.minimum(np.minimum(f1, f2), f3), np.maximum(np.maximum(f1, f2), f3)
    by_1_27 = np.select(
        [THETA < V1, THETA < V2, THETA < V3], [all_and, np.minimum(f2, f3), f3], all_or
    )
    np.testing.assert_array_equal(by_1_25, by_1_27)
    for joined in (
        join(F1, F2, F3),
        join(join(F1, F2), F3),
        join(F1, join(F2, F3)),
        join(F3, F1, F2, method="theorem_1_1"),
    ):
        np.testing.assert_allclose(joined(THETA), by_1_27, atol=1e-15)
    assert join(F1, F2, F3).is_convex()
    assert join(F1, F2, F3).is_normal()


def test_1_15_the_meet_as_corrected() -> None:
    """Errata: the third row holds from v_n on, not from v_k.

    v_k is printed. The first row is "or", as printed.
    """
    all_and, all_or = np.minimum(np.minimum(f1, f2), f3), np.maximum(np.maximum(f1, f2), f3)
    corrected = np.select(
        [THETA < V1, THETA < V2, THETA < V3], [all_or, f1, np.minimum(f1, f2)], all_and
    )
    np.testing.assert_allclose(meet(F1, F2, F3)(THETA), corrected, atol=1e-15)
    # Brute force, from above: a pair gives theta as its minimum if one is theta and the other is
    # not smaller.
    suffix = [np.maximum.accumulate(f[::-1])[::-1] for f in (f1, f2)]
    by_pairs = np.maximum(np.minimum(f1, suffix[1]), np.minimum(f2, suffix[0]))
    np.testing.assert_allclose(meet(F1, F2)(THETA), by_pairs, atol=1e-15)
    assert np.abs(np.where(THETA < V1, all_and, corrected) - corrected).max() > 0.1
    # "v_k <= theta" for any k overrides the second row
    as_printed = np.where(THETA >= V1, all_and, all_or)
    assert np.abs(as_printed - corrected).max() > 0.1


# Theorem 1.3
# --------------------------------------------------------------------------------------------------

M1, M2, S1, S2 = 0.6, 0.5, 0.1, 0.2  # the numbers with which the errata compare 1.39
G1, G2 = Gaussian(M1, S1), Gaussian(M2, S2)
MET = meet(G1, G2, t_norm="product")
POSITIVE = np.array([0.05, 0.1, 0.2, 0.3, 0.4, 0.6, 0.8])


def J(v: np.ndarray, theta: float) -> np.ndarray:
    return ((v - M1) / S1) ** 2 + ((theta / v - M2) / S2) ** 2


def H(v: np.ndarray, theta: float, k: float) -> np.ndarray:
    return ((v - M1) / S1) ** 2 + ((theta - M2 * v) / (k * S2)) ** 2


def test_1_31_the_meet_is_an_enumeration_of_products() -> None:
    """Sampled operands, all products.

    No grade is above that of the function, and the best is near it (steps of 0.005).
    """
    u = np.linspace(0.0, 1.0, 201)
    enumerated = meet(SampledSet(u, G1(u)), SampledSet(u, G2(u)), t_norm="product")
    assert isinstance(enumerated, SampledSet)
    assert (enumerated.grades <= MET(enumerated.points) + 1e-8).all()
    for theta in POSITIVE:
        near = np.abs(enumerated.points - theta) <= 0.005
        assert enumerated.grades[near].max() == pytest.approx(float(MET(theta)), abs=0.05)


def test_1_32_and_1_33_at_zero() -> None:
    """One factor is 0 and the other anything.

    With normal sets the greater of both memberships at 0.
    """
    u = np.linspace(0.0, 1.0, 2001)
    by_suprema = max(float(G1(u).max() * G2(0.0)), float(G1(0.0) * G2(u).max()))
    by_normality = max(float(G1(0.0)), float(G2(0.0)))
    assert by_suprema == by_normality
    assert float(MET(0.0)) == pytest.approx(by_normality, abs=1e-15)


def test_1_34_elsewhere_one_factor_follows_from_the_other() -> None:
    """Between theta and 1, where both factors are memberships.

    A grid of 1e-5 is within 1e-8 of a smooth maximum.
    """
    for theta in POSITIVE:
        v = np.linspace(theta, 1.0, 100_001)
        assert float(MET(theta)) == pytest.approx(float((G1(v) * G2(theta / v)).max()), abs=1e-8)


def test_1_35_gaussians_at_zero() -> None:
    expected = max(np.exp(-0.5 * (M1 / S1) ** 2), np.exp(-0.5 * (M2 / S2) ** 2))
    assert float(MET(0.0)) == pytest.approx(expected, abs=1e-15)


def test_1_36_and_1_37_the_supremum_is_an_infimum() -> None:
    for theta in POSITIVE:
        v = np.linspace(theta, 1.0, 100_001)
        np.testing.assert_allclose(
            J(v, theta),
            ((v - M1) / S1) ** 2 + ((theta - M2 * v) / (S2 * v)) ** 2,
            rtol=1e-9,
            atol=1e-9,
        )
        assert float(MET(theta)) == pytest.approx(float(np.exp(-0.5 * J(v, theta).min())), abs=1e-8)


def test_1_37_is_not_convex() -> None:
    """J bends down on a stretch, and has a pole between two minima for a negative product.

    The meet finds the lowest of its minima all the same; a grid of 1e-5 is within 1e-8.
    """
    v = np.linspace(0.05, 1.0, 2001)
    assert (np.diff(J(v, 0.02), 2) < 0.0).any()
    assert (np.diff(J(v, 0.02), 2) > 0.0).any()
    fine = np.linspace(0.02, 1.0, 100_001)
    lowest = float(J(fine, 0.02).min())
    assert float(MET(0.02)) == pytest.approx(np.exp(-0.5 * lowest), abs=1e-8)


def minus_two_logarithms(theta: float) -> float:
    """Return what eq. 1.42 has in its exponent, from the library's meet of the two Gaussians."""
    return float(-2.0 * np.log(gaussian_meet([M1, M2], [S1, S2]).membership(theta)))


def test_1_38_is_1_37_where_k_is_v() -> None:
    """With k = v it is the exact meet, with k = m1 that of eq. 1.42; both by minima on a grid.

    A step of 2e-5 is within its square times half the curvature, 1e-8, of a minimum.
    """
    v = np.linspace(0.1, 1.0, 19)
    np.testing.assert_allclose([H(x, 0.3, x) for x in v], J(v, 0.3), rtol=1e-12, atol=1e-12)
    fine = np.linspace(-0.5, 1.5, 100_001)
    for theta in POSITIVE:
        assert minus_two_logarithms(theta) == pytest.approx(H(fine, theta, M1).min(), abs=1e-7)
        inside = np.linspace(theta, 1.0, 100_001)
        assert float(-2.0 * np.log(MET(theta))) == pytest.approx(
            min(H(x, theta, x) for x in inside[::50]), abs=1e-3
        )


def test_1_39_has_k_squared_in_it() -> None:
    """Errata: 234.7, where the printed formula has 212.5.

    Central differences of a parabola are exact but for rounding.
    """
    k, step = M1, 1e-3
    v = np.array([0.4, 0.5, 0.6]) + 0.0
    second = (H(v + step, 0.3, k) - 2.0 * H(v, 0.3, k) + H(v - step, 0.3, k)) / step**2
    corrected, printed = (
        2.0 / S1**2 + 2.0 * M2**2 / (k**2 * S2**2),
        2.0 / S1**2 + 2.0 * M2**2 / S2**2,
    )
    np.testing.assert_allclose(second, corrected, rtol=1e-7)
    # What a parabola is above its minimum says how it is bent; the minimum is the library's.
    best = (0.3 * M2 * S1**2 + M1 * k**2 * S2**2) / (M2**2 * S1**2 + k**2 * S2**2)
    above = H(best + np.array([-0.2, 0.1]), 0.3, k) - minus_two_logarithms(0.3)
    np.testing.assert_allclose(2.0 * above / np.array([-0.2, 0.1]) ** 2, corrected, rtol=1e-12)
    assert corrected == pytest.approx(234.7, abs=0.05)
    assert printed == pytest.approx(212.5, abs=0.05)


@pytest.mark.parametrize("k", [0.3, M1, 1.0])
def test_1_40_the_minimum_of_the_parabola(k: float) -> None:
    for theta in POSITIVE:
        best = (theta * M2 * S1**2 + M1 * k**2 * S2**2) / (M2**2 * S1**2 + k**2 * S2**2)
        around = best + np.array([-1e-4, 0.0, 1e-4])
        values = H(around, theta, k)
        assert values[1] < values[0]
        assert values[1] < values[2]
        # The slope there is 0: values on both sides are the same but for rounding.
        assert values[0] - values[2] == pytest.approx(0.0, abs=1e-9)
        # The library takes the one for k = m1; another k has another minimum.
        assert (values[1] == pytest.approx(minus_two_logarithms(theta), rel=1e-11, abs=1e-12)) == (
            k == M1 or theta == pytest.approx(M1 * M2)
        )


def test_1_41_the_infimum_for_k_equal_to_the_mean() -> None:
    """Theta minus the product of the means, where "sigma" is printed.

    With another k the denominator has k, and only m1 is symmetric.
    """
    for theta in POSITIVE:
        for k in (0.3, M1, 1.0):
            best = (theta * M2 * S1**2 + M1 * k**2 * S2**2) / (M2**2 * S1**2 + k**2 * S2**2)
            general = (theta - M1 * M2) ** 2 / (M2**2 * S1**2 + k**2 * S2**2)
            assert float(H(np.array(best), theta, k)) == pytest.approx(
                general, rel=1e-12, abs=1e-12
            )
            as_1_41 = (theta - M1 * M2) ** 2 / (M2**2 * S1**2 + M1**2 * S2**2)
            assert minus_two_logarithms(theta) == pytest.approx(as_1_41, rel=1e-11, abs=1e-12)
            assert (general == pytest.approx(as_1_41, rel=1e-9)) == (
                k == M1 or theta == pytest.approx(M1 * M2)
            )


def test_1_42_and_1_30_the_meet_of_gaussians() -> None:
    found = gaussian_meet([M1, M2], [S1, S2])
    for theta in POSITIVE:
        expected = np.exp(-0.5 * (theta - M1 * M2) ** 2 / (M2**2 * S1**2 + M1**2 * S2**2))
        assert float(found.membership(theta)) == pytest.approx(expected, rel=1e-12)
    three = gaussian_meet([0.5, 0.6, 0.7], [0.1, 0.05, 0.08])
    spread = (0.1 * 0.6 * 0.7) ** 2 + (0.05 * 0.5 * 0.7) ** 2 + (0.08 * 0.5 * 0.6) ** 2
    assert (float(three.mean), float(three.sigma)) == (
        pytest.approx(0.21, rel=1e-14),
        pytest.approx(np.sqrt(spread), rel=1e-14),
    )
    # Two at a time is the same, which makes the induction that the thesis leaves to the reader.
    pair = gaussian_meet([0.5, 0.6], [0.1, 0.05])
    assert float(gaussian_meet([pair.mean, 0.7], [pair.sigma, 0.08]).sigma) == pytest.approx(
        np.sqrt(spread), rel=1e-14
    )


@pytest.mark.parametrize(
    ("means", "sigmas", "error"),
    [([0.5, 0.7], [0.05, 0.05], 0.033), ([0.1, 0.2], [0.1, 0.15], 0.234)],
)
def test_1_30_is_an_approximation(means: list[float], sigmas: list[float], error: float) -> None:
    """Errata: the greatest errors against brute force, to three digits."""
    assert gaussian_meet_error(means, sigmas) == pytest.approx(error, abs=1.5e-3)


# Theorem 1.5
# --------------------------------------------------------------------------------------------------

# means and standard deviations of the summands; those with which the errata compare 1.55
P1, Q1, P2, Q2 = 1.0, 0.1, 2.0, 0.2
N1, N2 = Gaussian(P1, Q1), Gaussian(P2, Q2)
SUMS = np.array([2.3, 2.7, 2.9, 3.0, 3.05, 3.4])


@pytest.mark.parametrize("alpha", [2.0, -0.5])
@pytest.mark.parametrize("t_norm", ["min", "product"])
def test_1_49_and_1_50_affine_functions_of_a_gaussian(alpha: float, t_norm: str) -> None:
    """The extension principle on samples, and the substitution.

    T-norms play no part, for one argument and two crisp numbers.
    """
    v = np.linspace(0.5, 1.5, 101)
    image = extend(
        lambda x, a, b: a * x + b,
        SampledSet(v, N1(v)),
        SampledSet([alpha], [1.0]),
        SampledSet([0.3], [1.0]),
        t_norm=t_norm,
    )
    substituted = Gaussian(alpha * P1 + 0.3, abs(alpha) * Q1)
    np.testing.assert_allclose(image.grades, substituted(image.points), atol=1e-12)
    number = GaussianNumber(P1, Q1, t_norm) * alpha + 0.3
    np.testing.assert_allclose(number.membership(image.points), image.grades, atol=1e-12)


def test_1_51_to_1_53_the_sum_under_the_product() -> None:
    """A supremum over one summand, on a grid fine enough for 1e-8, against the algebra."""
    v = np.linspace(0.0, 2.0, 40_001)
    by_supremum = np.array([(N1(v) * N2(theta - v)).max() for theta in SUMS])
    by_1_53 = np.array(
        [
            np.exp(-0.5 * (((v - P1) / Q1) ** 2 + ((theta - v - P2) / Q2) ** 2)).max()
            for theta in SUMS
        ]
    )
    np.testing.assert_allclose(by_supremum, by_1_53, atol=1e-14)
    total = GaussianNumber(P1, Q1, "product") + GaussianNumber(P2, Q2, "product")
    np.testing.assert_allclose(total.membership(SUMS), by_supremum, atol=1e-7)


def sum_objective(v: np.ndarray, theta: float) -> np.ndarray:
    return ((v - P1) / Q1) ** 2 + ((theta - v - P2) / Q2) ** 2


def test_1_54_and_1_55_the_objective_is_convex() -> None:
    """Errata: 250, where the printed formula, which lacks the factor 2, has 125."""
    v, step = np.array([0.7, 1.0, 1.4]), 1e-3
    for theta in SUMS:
        second = (
            sum_objective(v + step, theta)
            - 2.0 * sum_objective(v, theta)
            + sum_objective(v - step, theta)
        ) / step**2
        np.testing.assert_allclose(second, 250.0, rtol=1e-6)
        # What a parabola is above its minimum says how it is bent; the minimum is the library's.
        total = GaussianNumber(P1, Q1, "product") + GaussianNumber(P2, Q2, "product")
        best = (P1 * Q2**2 + (theta - P2) * Q1**2) / (Q1**2 + Q2**2)
        away = np.array([-0.3, 0.2, 0.4])
        lowest = -2.0 * np.log(float(total.membership(theta)))
        np.testing.assert_allclose(
            2.0 * (sum_objective(best + away, theta) - lowest) / away**2, 250.0, rtol=1e-11
        )
    assert pytest.approx(250.0) == 2.0 * (1.0 / Q1**2 + 1.0 / Q2**2)
    assert pytest.approx(125.0) == 1.0 / Q1**2 + 1.0 / Q2**2


def test_1_56_and_1_57_the_minimum_of_the_objective() -> None:
    for theta in SUMS:
        best = (P1 * Q2**2 + (theta - P2) * Q1**2) / (Q1**2 + Q2**2)
        assert 2.0 * (best - P1) / Q1**2 - 2.0 * (theta - best - P2) / Q2**2 == pytest.approx(
            0.0, abs=1e-10
        )
        assert best * (1.0 / Q1**2 + 1.0 / Q2**2) == pytest.approx(
            P1 / Q1**2 + (theta - P2) / Q2**2, rel=1e-13
        )
        expected = (theta - (P1 + P2)) ** 2 / (Q1**2 + Q2**2)
        assert float(sum_objective(np.array(best), theta)) == pytest.approx(
            expected, rel=1e-11, abs=1e-12
        )
    # By induction to n summands.
    sigmas = np.array([0.1, 0.2, 0.05, 0.4])
    total = GaussianNumber([1.0, 2.0, -1.0, 0.5], sigmas, "product").sum()
    assert (float(total.mean), float(total.sigma)) == (
        pytest.approx(2.5),
        pytest.approx(np.sqrt((sigmas**2).sum()), rel=1e-14),
    )


def test_1_58_and_1_59_the_sum_under_the_minimum() -> None:
    v = np.linspace(0.0, 2.0, 40_001)
    by_supremum = np.array([np.minimum(N1(v), N2(theta - v)).max() for theta in SUMS])
    total = GaussianNumber(P1, Q1, "min") + GaussianNumber(P2, Q2, "min")
    # The supremum is a crossing: a grid of 5e-5 misses it by at most half a step times the slope,
    # 0.61 / 0.1.
    np.testing.assert_allclose(total.membership(SUMS), by_supremum, atol=2e-4)
    by_cuts = FuzzyNumber.of(N1) + FuzzyNumber.of(N2)
    # linear between 129 levels
    np.testing.assert_allclose(by_cuts.membership(SUMS), total.membership(SUMS), atol=1e-3)


def test_1_60_the_gaussians_cross_at_the_supremum() -> None:
    for theta in SUMS:
        best = (P1 * Q2 + (theta - P2) * Q1) / (Q1 + Q2)
        grades = float(N1(best)), float(N2(theta - best))
        assert grades[0] == pytest.approx(grades[1], rel=1e-11)
        assert grades[0] == pytest.approx(float(Gaussian(P1 + P2, Q1 + Q2)(theta)), rel=1e-11)
    total = GaussianNumber([1.0, 2.0, -1.0], [0.1, 0.2, 0.05], "min").sum()
    assert (float(total.mean), float(total.sigma)) == (pytest.approx(2.0), pytest.approx(0.35))


# Theorem 1.6
# --------------------------------------------------------------------------------------------------

C, S = np.array([1.0, 2.5, 4.0, 3.0]), np.array([0.3, 0.2, 0.4, 0.1])
W0, D = np.array([0.6, 0.9, 0.3, 0.5]), np.array([0.03, 0.02, 0.04, 0.01])
TOTAL = W0.sum()
XI = (W0 * C).sum() / TOTAL

source = np.random.default_rng(5)
GAMMA, DELTA = S * source.uniform(-1.0, 1.0, (1000, 4)), D * source.uniform(-1.0, 1.0, (1000, 4))
AVERAGE = ((C + GAMMA) * (W0 + DELTA)).sum(axis=-1) / (W0 + DELTA).sum(axis=-1)
R = DELTA.sum(axis=-1) / TOTAL  # relative change of the sum of the weights

SIGNS = np.array(list(itertools.product((-1.0, 1.0), repeat=8)))
CORNERS = S * SIGNS[:, :4], D * SIGNS[:, 4:]
"""Slacks at the ends of all their intervals: where affine functions, and averages, are extreme."""


def average(gamma: np.ndarray, delta: np.ndarray) -> np.ndarray:
    return np.asarray(((C + gamma) * (W0 + delta)).sum(axis=-1) / (W0 + delta).sum(axis=-1))


def ends(values: np.ndarray) -> np.ndarray:
    return np.array([values.min(), values.max()])


def reduced() -> ApproximateReduction[IntervalNumber]:
    """Return what the library makes of the four intervals with interval weights."""
    return approximate_generalized_centroid(IntervalNumber(C, S), IntervalNumber(W0, D))


def exact() -> np.ndarray:
    """Return the exact reduction by the library, which has no part in the approximation."""
    return np.asarray(
        generalized_centroid(IntervalNumber(C, S).interval(), IntervalNumber(W0, D).interval())
    )


def test_1_87_xi_is_divided_by_the_sum_of_the_weights() -> None:
    """The thesis prints the sum of h c divided by one h.

    Then it would not even lie between the points.
    """
    assert C.min() < XI < C.max()
    found = approximate_generalized_centroid(C, IntervalNumber(W0, 0.0))
    assert float(found.value.center) == pytest.approx(XI, rel=1e-14)
    for printed in (W0 * C).sum() / W0:
        assert printed > C.max()


def test_1_89_slack_variables_change_nothing() -> None:
    """Discrete sets about 0, and the average of eq. 1.89 as a function of the slacks.

    By the extension principle.
    """
    slack = np.array([-1.0, 0.0, 1.0])
    grades = np.array([0.4, 1.0, 0.7])
    gammas, deltas = (
        [SampledSet(width * slack, grades) for width in widths[:2]] for widths in (S, D)
    )

    def of_two(g1: np.ndarray, g2: np.ndarray, d1: np.ndarray, d2: np.ndarray) -> np.ndarray:
        first, second = W0[0] + d1, W0[1] + d2
        return (first * (C[0] + g1) + second * (C[1] + g2)) / (first + second)

    by_slacks = extend(of_two, *gammas, *deltas, t_norm="product")
    Z = [SampledSet(c + s * slack, grades) for c, s in zip(C[:2], S[:2], strict=True)]
    W = [SampledSet(h + d * slack, grades) for h, d in zip(W0[:2], D[:2], strict=True)]
    found = exhaustive_generalized_centroid(Z, W, "product").set
    np.testing.assert_allclose(found.points, by_slacks.points, atol=1e-13)
    np.testing.assert_allclose(found.grades, by_slacks.grades, atol=1e-15)


def expanded_parts(gamma: np.ndarray, delta: np.ndarray) -> np.ndarray:
    """Return the numerator of eq. 1.90."""
    return np.asarray(
        (W0 * C).sum()
        + (W0 * gamma).sum(axis=-1)
        + (delta * C).sum(axis=-1)
        + (delta * gamma).sum(axis=-1)
    )


def test_1_90_the_average_expanded() -> None:
    """Errata: the sum of w is the denominator on the left, where the sum of z is printed.

    Its least and greatest value at the corners are the exact reduction.
    """
    expanded = expanded_parts(GAMMA, DELTA) / (TOTAL + DELTA.sum(axis=-1))
    np.testing.assert_allclose(expanded, AVERAGE, rtol=1e-14)
    printed = ((C + GAMMA) * (W0 + DELTA)).sum(axis=-1) / (C + GAMMA).sum(axis=-1)
    assert (np.abs(printed - expanded) > 1.0).all()
    at_corners = expanded_parts(*CORNERS) / (TOTAL + CORNERS[1].sum(axis=-1))
    np.testing.assert_allclose(ends(at_corners), exact(), rtol=1e-13)


def test_1_91_the_reciprocal_to_first_order() -> None:
    """1/(1 + r) - (1 - r) = r²/(1 + r).

    With crisp points it is all that is approximated: the average differs from the center by what
    the approximation says over 1 + r, at the corner where that is extreme.
    """
    exactly, first_order = 1.0 / (TOTAL + DELTA.sum(axis=-1)), (1.0 - R) / TOTAL
    np.testing.assert_allclose(1.0 / (TOTAL * (1.0 + R)), exactly, rtol=1e-14)
    np.testing.assert_allclose(exactly - first_order, R**2 / (1.0 + R) / TOTAL, atol=1e-15)
    found = approximate_generalized_centroid(C, IntervalNumber(W0, D)).value.interval()
    for end, sign in zip(found, (-1.0, 1.0), strict=True):
        delta = sign * D * np.sign(C - XI)
        assert (float(average(np.zeros(4), delta)) - XI) * (
            1.0 + delta.sum() / TOTAL
        ) == pytest.approx(end - XI, rel=1e-12)


def by_1_92(gamma: np.ndarray, delta: np.ndarray) -> np.ndarray:
    return np.asarray(expanded_parts(gamma, delta) / TOTAL * (1.0 - delta.sum(axis=-1) / TOTAL))


def by_1_93(gamma: np.ndarray, delta: np.ndarray) -> np.ndarray:
    c, slack, r = (
        (W0 * C).sum() / TOTAL,
        (W0 * gamma).sum(axis=-1) / TOTAL,
        delta.sum(axis=-1) / TOTAL,
    )
    return np.asarray(
        c
        - r * c
        + slack
        - r * slack
        + (delta * C).sum(axis=-1) / TOTAL
        + (delta * gamma).sum(axis=-1) / TOTAL
    )


def test_1_92_the_average_to_first_order() -> None:
    """What it leaves out is the average times r².

    So its ends at the corners are those of the exact reduction but for the validity squared.
    """
    np.testing.assert_allclose(AVERAGE - by_1_92(GAMMA, DELTA), AVERAGE * R**2, atol=1e-14)
    away = np.abs(ends(by_1_92(*CORNERS)) - exact())
    validity = float(reduced().validity)
    assert (away <= validity**2 * (C + S).max()).all()
    assert (away > 0.0).all()


def test_1_93_leaves_out_two_terms_of_the_second_order() -> None:
    left_out = -R * ((DELTA * C).sum(axis=-1) + (DELTA * GAMMA).sum(axis=-1)) / TOTAL
    np.testing.assert_allclose(by_1_92(GAMMA, DELTA) - by_1_93(GAMMA, DELTA), left_out, atol=1e-14)
    at_corners = np.abs(by_1_92(*CORNERS) - by_1_93(*CORNERS))
    validity = float(reduced().validity)
    assert np.abs(left_out).max() <= at_corners.max() <= validity**2 * (C + S).max()


def by_1_94(gamma: np.ndarray, delta: np.ndarray) -> np.ndarray:
    slack, r = (W0 * gamma).sum(axis=-1) / TOTAL, delta.sum(axis=-1) / TOTAL
    return np.asarray(
        XI
        - XI * r
        + (delta * C).sum(axis=-1) / TOTAL
        + slack
        - r * slack
        + (delta * gamma).sum(axis=-1) / TOTAL
    )


def test_1_94_is_1_93_with_xi() -> None:
    """Without any slack it is the center that the library has."""
    np.testing.assert_allclose(by_1_94(GAMMA, DELTA), by_1_93(GAMMA, DELTA), atol=1e-14)
    assert float(by_1_94(np.zeros(4), np.zeros(4))) == pytest.approx(
        float(reduced().value.center), rel=1e-14
    )


def test_1_95_is_bounded_by_the_sum_of_the_half_widths() -> None:
    """Errata: |sum of delta| is printed, which can vanish while the left side does not.

    At the corners the left side is greatest: the bound by the library's validity holds there, and
    no bound of half its size does.
    """
    left = np.abs((DELTA * GAMMA).sum(axis=-1)) / TOTAL
    assert (left <= S.max() * np.abs(DELTA).sum(axis=-1) / TOTAL + 1e-16).all()
    bound = S.max() * float(reduced().validity)
    at_corners = np.abs((CORNERS[1] * CORNERS[0]).sum(axis=-1)) / TOTAL
    assert left.max() <= at_corners.max() <= bound
    assert at_corners.max() > 0.5 * bound
    assert (left > S.max() * np.abs(R)).any()
    delta, gamma, h = np.array([0.1, -0.1]), np.array([0.3, -0.3]), np.array([1.0, 1.0])
    assert abs((delta * gamma).sum()) / h.sum() == pytest.approx(0.03)
    assert 0.3 * abs(delta.sum()) / h.sum() == 0.0


def test_1_96_the_average_slack_of_the_points() -> None:
    """It is all that is left where the weights are crisp: half the width of the reduction."""
    assert (np.abs((W0 * GAMMA).sum(axis=-1)) / TOTAL <= S.max()).all()
    at_corners = np.abs((W0 * CORNERS[0]).sum(axis=-1)) / TOTAL
    found = approximate_generalized_centroid(IntervalNumber(C, S), IntervalNumber(W0, 0.0)).value
    assert float(found.spread) == pytest.approx(at_corners.max(), rel=1e-14)
    assert float(found.spread) <= S.max()


def test_1_97_both_terms_left_out_are_bounded() -> None:
    """Again by the sum of the half-widths, and not by |sum of delta| as printed."""
    left = np.abs(-R * (W0 * GAMMA).sum(axis=-1) / TOTAL + (DELTA * GAMMA).sum(axis=-1) / TOTAL)
    apart = (
        np.abs(R * (W0 * GAMMA).sum(axis=-1) / TOTAL) + np.abs((DELTA * GAMMA).sum(axis=-1)) / TOTAL
    )
    assert (left <= apart + 1e-16).all()
    bound = 2.0 * S.max() * float(reduced().validity)
    assert (apart <= bound).all()
    assert (left > 2.0 * S.max() * np.abs(R)).any()
    away = np.abs(by_1_94(*CORNERS) - by_1_98(*CORNERS))
    assert 0.0 < left.max() <= away.max() <= bound


def by_1_98(gamma: np.ndarray, delta: np.ndarray) -> np.ndarray:
    return np.asarray((gamma * W0 / TOTAL + delta * (C - XI) / TOTAL).sum(axis=-1) + XI)


def test_1_98_the_affine_approximation() -> None:
    """It is eq. 1.94 without its last two terms.

    Its ends over all corners are what the library returns. A tenth of the uncertainty of the
    weights leaves a tenth of the error (their product).
    """
    found = reduced()
    np.testing.assert_allclose(found.value.interval(), ends(by_1_98(*CORNERS)), rtol=1e-14)
    validity = float(found.validity)
    bound = 2.0 * S.max() * validity + 2.0 * validity**2 * (C + S).max()
    assert (np.abs(found.value.interval() - exact()) <= bound).all()
    slack = (W0 * GAMMA).sum(axis=-1) / TOTAL
    np.testing.assert_allclose(
        by_1_98(GAMMA, DELTA),
        by_1_94(GAMMA, DELTA) + R * slack - (DELTA * GAMMA).sum(axis=-1) / TOTAL,
        atol=1e-14,
    )
    assert np.abs(by_1_98(GAMMA, DELTA) - AVERAGE).max() <= bound
    errors = (
        np.abs(by_1_98(GAMMA, DELTA) - AVERAGE).max(),
        np.abs(by_1_98(GAMMA, 0.1 * DELTA) - average(GAMMA, 0.1 * DELTA)).max(),
    )
    assert 9.0 < errors[0] / errors[1] < 11.0
    # With crisp points both terms vanish, and the error is of the second order.
    crisp = [
        np.abs(by_1_98(0.0 * GAMMA, share * DELTA) - average(0.0 * GAMMA, share * DELTA)).max()
        for share in (1.0, 0.1)
    ]
    assert 90.0 < crisp[0] / crisp[1] < 110.0


def test_1_99_to_1_101_fuzzy_sets_about_zero() -> None:
    """Membership of Z at gamma + c is that of Z - c at gamma.

    Then the affine combination is one of fuzzy numbers (eq. 1.85).
    """
    for norm in ("product", "min"):
        Z, W = GaussianNumber(C, S, norm), GaussianNumber(W0, D, norm)
        about_zero = Z - C
        gamma = np.linspace(-0.5, 0.5, 11)[:, None]
        np.testing.assert_allclose(
            about_zero.membership(gamma), Z.membership(gamma + C), atol=1e-12
        )
        combined = (about_zero * (W0 / TOTAL)).sum() + ((W - W0) * ((C - XI) / TOTAL)).sum() + XI
        found = approximate_generalized_centroid(Z, W).value
        assert float(found.mean) == pytest.approx(float(combined.mean), rel=1e-14)
        assert float(found.sigma) == pytest.approx(float(combined.sigma), rel=1e-13)
    # As an extension: eq. 1.99 on two points with discrete sets, whose ends and peaks are those of
    # the triangles' reduction.
    h, c = W0[:2], C[:2]
    xi, total = (h * c).sum() / h.sum(), h.sum()
    gammas, deltas = (
        [SampledSet([-width, 0.0, width], [0.5, 1.0, 0.5]) for width in widths[:2]]
        for widths in (S, D)
    )
    image = extend(
        lambda g1, g2, d1, d2: (
            (g1 * h[0] + g2 * h[1] + d1 * (c[0] - xi) + d2 * (c[1] - xi)) / total + xi
        ),
        *gammas,
        *deltas,
        t_norm="min",
    )
    triangles = approximate_generalized_centroid(
        [Triangular(c[i] - 2.0 * S[i], c[i], c[i] + 2.0 * S[i]) for i in range(2)],
        [Triangular(h[i] - 2.0 * D[i], h[i], h[i] + 2.0 * D[i]) for i in range(2)],
    )
    np.testing.assert_allclose(triangles.value.interval(0.5), image.support, atol=1e-12)
    np.testing.assert_allclose(triangles.value.interval(1.0), [xi, xi], atol=1e-12)


def test_1_102_exact_where_the_weights_are_crisp() -> None:
    """The average of the points as it is, against eq. 1.98.

    And by enumeration of discrete points.
    """
    exact = ((C + GAMMA) * W0).sum(axis=-1) / TOTAL
    np.testing.assert_allclose(by_1_98(GAMMA, np.zeros(4)), exact, rtol=1e-14)
    Z = [SampledSet([c - s, c, c + s], [0.5, 1.0, 0.5]) for c, s in zip(C, S, strict=True)]
    enumerated = exhaustive_generalized_centroid(Z, W0.tolist()).set
    found = approximate_generalized_centroid(IntervalNumber(C, S), IntervalNumber(W0, 0.0))
    np.testing.assert_allclose(found.value.interval(), enumerated.support, atol=1e-14)
    assert float(found.validity) == 0.0
