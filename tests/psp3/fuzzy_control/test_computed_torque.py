"""The fuzzy controller.

Against fuzzy arithmetic, the crisp controller, other kinds, and files that were tampered with.
"""

from __future__ import annotations

import copy
import json
import math
import re
import warnings
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

import fuzzy2
import psp3
from fuzzy2.errors import UnsupportedRule
from fuzzy2.reduction.general import alpha_plane_defuzzify, cut_centroid
from fuzzy2.systems import GeneralType2System
from psp3.errors import (
    InvalidArray,
    InvalidControllerFile,
    InvalidTorque,
    InvalidValue,
    NotTrained,
    UnknownName,
    UnreachablePose,
    UnusableEstimate,
)
from psp3.fuzzy_control import kernels
from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
from psp3.fuzzy_control.records import OUTPUT_NAMES, Record, pack, record, unpack
from psp3.study.execution import execute
from psp3.study.run import Run
from psp3.three_psp.parameters import Parameters
from psp3.trajectories import Circle, Helix, Hold, Line, Motion

ROBOT = psp3.load("psp3")
HELIX = Helix(robot=ROBOT)

KINDS: dict[str, dict[str, Any]] = {
    "t1": {"kind": "t1"},
    "it2": {"kind": "it2"},
    "gt2": {"kind": "gt2"},
    "corollary": {"kind": "gt2", "reduction": "gaussian"},
}
pytestmark = pytest.mark.filterwarnings("ignore:the Gaussian corollary:fuzzy2.ApproximationWarning")


@pytest.fixture(scope="module")
def recorded() -> Record:
    return record(ROBOT, HELIX)


@pytest.fixture(scope="module")
def trained(recorded: Record) -> dict[str, FuzzyComputedTorque]:
    """Return a controller of every kind, learned from the same noisy samples at 15 dB."""
    return {name: learned(recorded, **options) for name, options in KINDS.items()}


def learned(recorded: Record, seed: int = 3, **options: Any) -> FuzzyComputedTorque:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fuzzy2.ApproximationWarning)
        return FuzzyComputedTorque(robot=ROBOT, **{"snr_db": 15.0} | options).learn(
            recorded, rng=np.random.default_rng(seed)
        )


def assert_same(one: kernels.Fuzzy, other: kernels.Fuzzy) -> None:
    """Whether two controllers are the same to the last bit."""
    for field, its in zip(one, other, strict=True):
        np.testing.assert_array_equal(field, its)


def states(count: int, seed: int = 0) -> list[tuple[np.ndarray, np.ndarray, Motion]]:
    """Return states around the helix, inside and outside of the trained range."""
    rng = np.random.default_rng(seed)
    desired = HELIX(rng.uniform(0.0, 10.4, count))
    heights = desired.heights + rng.normal(0.0, 0.02, (count, 3))
    speeds = desired.speeds + rng.normal(0.0, 0.1, (count, 3))
    return [(heights[k], speeds[k], Motion(*(array[k] for array in desired))) for k in range(count)]


# Fuzzy numbers to the last step


@pytest.mark.parametrize("order", ["first", "last"])
@pytest.mark.parametrize("name", KINDS)
def test_the_torque_is_that_of_fuzzy_arithmetic(
    recorded: Record, trained: dict[str, FuzzyComputedTorque], name: str, order: str
) -> None:
    """Fuzzy arithmetic in NumPy on the systems' own type-reduced outputs.

    1e-12 relative to the largest screw force. The interval is the same in either order.
    """
    controller = trained[name]
    if order == "last":
        controller = learned(recorded, defuzzify="last", **KINDS[name])
    for heights, speeds, desired in states(200):
        fast = controller.torque(0.0, heights, speeds, desired)
        number = controller.torque_number(heights, speeds, desired)
        np.testing.assert_allclose(
            fast, controller.defuzzify(number), rtol=0.0, atol=1e-12 * np.abs(fast).max()
        )
        assert not controller.fell_back
        if isinstance(number, fuzzy2.GaussianNumber):
            expected = np.stack([number.mean, number.sigma], axis=-1)
        else:
            planes = number if number.ndim == 2 else number.reshape(1, 3)
            expected = planes[0].interval()
        np.testing.assert_allclose(
            controller.torque_interval, expected, rtol=0.0, atol=1e-12 * np.abs(expected).max()
        )
        if name in ("it2", "gt2"):
            assert (controller.torque_interval[:, 0] <= fast).all()
            assert (fast <= controller.torque_interval[:, 1]).all()


@given(
    st.sampled_from(list(KINDS)),
    st.lists(st.floats(-0.3, 0.3), min_size=3, max_size=3),
    st.lists(st.floats(-5.0, 5.0), min_size=3, max_size=3),
    st.lists(st.floats(-50.0, 50.0), min_size=3, max_size=3),
    st.floats(0.0, 10.4),
)
def test_both_ways_agree_at_any_state(
    trained: dict[str, FuzzyComputedTorque],
    name: str,
    heights: list[float],
    speeds: list[float],
    accelerations: list[float],
    t: float,
) -> None:
    """Terms of up to 1e3 N cancel in the torque, so 1e-12 is relative to the sum of their sizes."""
    controller = trained[name]
    desired = HELIX(t)._replace(accelerations=np.array(accelerations))
    M, C, G = controller.estimate(heights, speeds)
    servo = desired.accelerations + desired.speeds - speeds + 10.0 * (desired.heights - heights)
    scale = np.abs(M) @ np.abs(servo) + np.abs(C) @ np.abs(speeds) + np.abs(G)
    fast = controller.torque(0.0, np.array(heights), np.array(speeds), desired)
    slow = controller.defuzzify(controller.torque_number(heights, speeds, desired))
    assert (np.abs(fast - slow) <= 1e-12 * scale).all()
    assert (np.abs(fast - (M @ servo + C @ speeds + G)) <= 1e-12 * scale).all()


def test_spreads_of_the_torque_are_sums_of_absolute_spreads(
    trained: dict[str, FuzzyComputedTorque],
) -> None:
    """Theorem 1.4 written out with the lowest and highest torque.

    Those that any M, C and G within their intervals give (interval type-2).
    """
    controller = trained["it2"]
    heights, speeds, desired = states(1, seed=4)[0]
    controller.torque(0.0, heights, speeds, desired)
    servo = desired.accelerations + desired.speeds - speeds + 10.0 * (desired.heights - heights)
    M, C, G = (
        number.interval()  # type: ignore[call-arg]
        for number in controller.estimated_numbers(heights, speeds)
    )
    lowest = (
        np.sort(M * servo[:, np.newaxis]).sum(axis=1)
        + np.sort(C * speeds[:, np.newaxis]).sum(axis=1)
        + G
    )[:, 0]
    highest = (
        np.sort(M * servo[:, np.newaxis]).sum(axis=1)
        + np.sort(C * speeds[:, np.newaxis]).sum(axis=1)
        + G
    )[:, 1]
    np.testing.assert_allclose(
        controller.torque_interval, np.stack([lowest, highest], axis=-1), rtol=1e-12
    )
    assert (highest - lowest > 1.0).all()


@pytest.mark.parametrize("name", ["t1", "it2", "corollary"])
def test_of_affine_numbers_the_order_makes_no_difference(recorded: Record, name: str) -> None:
    """Theorems 1.4 and 1.5: M, C and G made crisp first, and the middle of the fuzzy torque.

    1e-12 relative to the largest screw force.
    """
    controller = learned(recorded, defuzzify="last", **KINDS[name])
    for heights, speeds, desired in states(50, seed=8):
        servo = desired.accelerations + desired.speeds - speeds + 10.0 * (desired.heights - heights)
        M, C, G = controller.estimate(heights, speeds)
        number = controller.torque_number(heights, speeds, desired)
        middle = (
            number.mean
            if isinstance(number, fuzzy2.GaussianNumber)
            else number.interval().mean(axis=-1)
        )
        torque = controller.torque(0.0, heights, speeds, desired)
        bar = 1e-12 * np.abs(torque).max()
        np.testing.assert_allclose(M @ servo + C @ speeds + G, middle, rtol=0.0, atol=bar)
        np.testing.assert_allclose(torque, middle, rtol=0.0, atol=bar)


def fuzzy_torque_by_cuts(
    controller: FuzzyComputedTorque, heights: np.ndarray, speeds: np.ndarray, desired: Motion
) -> list[fuzzy2.FuzzyNumber]:
    """Return the three fuzzy torques by the extension principle, level by level.

    Entries are fuzzy numbers of any shape, products with servo and speeds the extremes over the
    corners.
    """
    system = controller.system_
    assert isinstance(system, GeneralType2System)
    x = np.array(
        [
            heights[0] - heights[1],
            heights[0] - heights[2],
            speeds[0] - speeds[1],
            speeds[0] - speeds[2],
        ]
    )
    cuts = system.alpha_cuts(np.clip(x, *controller.ranges_))
    # Below the lowest level nothing is known; the ends of exact reductions are nested but for
    # rounding.
    left = np.maximum.accumulate(np.concatenate([cuts[:, :1, 0], cuts[..., 0]], axis=1), axis=1)
    right = np.minimum.accumulate(np.concatenate([cuts[:, :1, 1], cuts[..., 1]], axis=1), axis=1)
    entries = fuzzy2.FuzzyNumber(
        left, np.maximum(left[:, -1:], right), np.concatenate([[0.0], system.alphas])
    )
    servo = desired.accelerations + desired.speeds - speeds + 10.0 * (desired.heights - heights)
    torques = []
    for i in range(3):
        torque = entries[15 + i]
        for j in range(3):
            mass = entries[{0: 0, 1: 1, 2: 2, 11: 3, 12: 4, 22: 5}[10 * min(i, j) + max(i, j)]]
            torque = torque + mass * servo[j] + entries[6 + 3 * i + j] * speeds[j]
        torques.append(torque)
    return torques


@pytest.mark.parametrize("levels", [1, 2, 5, 20])
def test_last_is_the_centroid_of_the_torque_by_the_extension_principle(
    recorded: Record, levels: int
) -> None:
    """Eq. 1.68 for the torque of fuzzy numbers of any shape, and eq. 1.69 for its membership.

    The first is the same number by other formulas, 1e-11 relative to the largest force. The second
    are sums over 20 001 points, which see the jump at the lowest level to within their distance.
    """
    controller = learned(recorded, kind="gt2", levels=levels, defuzzify="last")
    for number, (heights, speeds, desired) in enumerate(states(40, seed=9)):
        torque = controller.torque(0.0, heights, speeds, desired)
        expected = fuzzy_torque_by_cuts(controller, heights, speeds, desired)
        np.testing.assert_allclose(
            torque,
            [float(one.defuzzify()) for one in expected],
            rtol=0.0,
            atol=1e-11 * np.abs(torque).max(),
        )
        if number < 5 and levels > 1:
            for one, force in zip(expected, torque, strict=True):
                low, high = one.interval(0.0)
                x = np.linspace(low, high, 20_001)
                grades = one.membership(x)
                assert force == pytest.approx(
                    (x * grades).sum() / grades.sum(), abs=1e-4 * (high - low)
                )


def cuts_on_the_path(controller: FuzzyComputedTorque, recorded: Record) -> list[np.ndarray]:
    """Return α-cuts of M, C, G and the torque at every 50th state of the training run, in NumPy.

    Of shapes (n, ..., L, 2); and the accelerations that the servo asks for (n, 3).
    """
    a, v = recorded.heights[::50], recorded.speeds[::50]
    desired = HELIX(0.002 * np.arange(len(recorded.heights))[::50])
    servo = desired.accelerations + desired.speeds - v + 10.0 * (desired.heights - a)
    M, C, G = (
        np.moveaxis(number.interval(), 0, -2)  # type: ignore[call-arg]
        for number in controller.estimated_numbers(a, v)
    )
    torque = G
    for cuts, factors in ((M, servo), (C, v)):
        products = cuts * factors[:, np.newaxis, :, np.newaxis, np.newaxis]
        torque = torque + np.sort(products, axis=-1).sum(axis=2)
    return [M, C, G, torque, servo]


def rms(difference: np.ndarray) -> float:
    return float(np.sqrt((difference**2).mean()))


def test_five_planes_with_straight_sides_are_nearer_to_many_than_a_staircase(
    recorded: Record,
) -> None:
    """What the page says of them, at 20 dB and the states of the training run.

    The set whose grade is the highest level of the cuts that a point is in has the centroid
    Σ Δα c w / Σ Δα w of middles c and widths w.
    """
    for seed in range(3):
        five, many = (
            cuts_on_the_path(
                learned(recorded, seed, kind="gt2", snr_db=20.0, levels=levels), recorded
            )[3]
            for levels in (5, 400)
        )
        expected = cut_centroid(np.arange(1, 401) / 400, many)
        widths = five[..., 1] - five[..., 0]
        staircase = (five.mean(axis=-1) * widths).sum(axis=-1) / widths.sum(axis=-1)
        straight = rms(cut_centroid(np.arange(1, 6) / 5, five) - expected)
        assert straight < 0.2
        assert rms(staircase - expected) > 1.8 * straight


def paired_ratio(errors: np.ndarray) -> tuple[np.ndarray, int, int]:
    """Return how much smaller the second of two errors (seeds, 2) is, from pairs that are finite.

    The geometric mean of the ratio with its 95 % interval (Student's t of the logarithms), in how
    many pairs the second is smaller, and how many there are.
    """
    logarithms = np.diff(np.log(errors[np.isfinite(errors).all(axis=1)])).ravel()
    reach = stats.t.ppf(0.975, logarithms.size - 1) * stats.sem(logarithms)
    ratios = np.exp(logarithms.mean() + reach * np.array([0.0, -1.0, 1.0]))
    return ratios, int((logarithms < 0.0).sum()), logarithms.size


def what_the_order_does(recorded: Record, snr_db: float, seeds: int = 30) -> dict[str, list[float]]:
    """Return the numbers of a row of each of the page's tables: of the torque, and of tracking."""
    differences, errors = [], np.empty((seeds, 3))
    for seed in range(seeds):
        for k, (kind, order) in enumerate((("it2", "first"), ("gt2", "first"), ("gt2", "last"))):
            run = Run(kind, snr_db=snr_db, seed=seed, defuzzify=order)
            errors[seed, k] = execute(run)["sum_of_squared_errors"]
        controller = FuzzyComputedTorque("gt2", ROBOT, snr_db=snr_db, defuzzify="last")
        # The study's source of noise.
        controller.learn(recorded, rng=np.random.default_rng([seed, 0]))
        *entries, torque, servo = cuts_on_the_path(controller, recorded)
        alphas = controller.system_.alphas  # type: ignore[attr-defined]
        last = cut_centroid(alphas, torque)
        for defuzzify in (alpha_plane_defuzzify, cut_centroid):
            M, C, G = (defuzzify(alphas, cuts) for cuts in entries)
            first = np.einsum("nij,nj->ni", M, servo) + G
            differences.append(last - first - np.einsum("nij,nj->ni", C, recorded.speeds[::50]))
    of_torques = [
        statistic
        for difference in (np.array(differences[0::2]), np.array(differences[1::2]))
        for statistic in (rms(difference), float(np.abs(difference).max()))
    ]
    tracking: list[float] = list(np.nanmedian(errors, axis=0))
    for pair in (errors[:, 1:], errors[:, [0, 2]]):
        ratios, better, count = paired_ratio(pair)
        tracking += [*ratios, better, count]
    return {"torque": of_torques, "tracking": [*tracking, *np.isnan(errors).sum(axis=0)]}


PAGE = Path(__file__).resolve().parents[3] / "docs" / "concepts" / "fuzzy_computed_torque.md"


@pytest.mark.slow
def test_the_page_says_what_the_order_does(recorded: Record) -> None:
    """Its two tables, row by row, to the digits printed: seeds 0 to 29 of the study."""
    text = PAGE.read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\d+) dB \|(.*)\|$", text, flags=re.MULTILINE)
    assert [row[0] for row in rows] == 2 * ["20", "15", "10"]
    for (snr_db, of_torque), (_, of_tracking) in zip(rows[:3], rows[3:], strict=True):
        found = what_the_order_does(recorded, float(snr_db))
        for row, values in ((of_torque, found["torque"]), (of_tracking, found["tracking"])):
            for printed, value in zip(re.findall(r"[\d.]+", row), values, strict=True):
                unit = 10.0 ** -len(printed.partition(".")[2])
                assert value == pytest.approx(float(printed), abs=0.51 * unit)


def test_numbers_of_other_shapes_must_be_defuzzified_last() -> None:
    """A mass that is the triangle (0, 0, 1), times a servo of 1, plus gravity within [0, 1].

    The cut of their sum at level α is [0, 2 − α], so its centroid is ∫(2 − α)²dα / 2∫(2 − α)dα =
    (7/3)/3 = 7/9, and 1/3 + 1/2 = 5/6 if each is defuzzified first. Ends of cuts are linear in the
    level, where the quadrature is exact: 1e-12.
    """
    mass = fuzzy2.FuzzyNumber.of(fuzzy2.Triangular(0.0, 0.0, 1.0))
    gravity = fuzzy2.FuzzyNumber.of(fuzzy2.IntervalNumber(0.5, 0.5))
    last = (mass * 1.0 + gravity).defuzzify()
    first = mass.defuzzify() * 1.0 + gravity.defuzzify()
    assert last == pytest.approx(7.0 / 9.0, abs=1e-12)
    assert first == pytest.approx(5.0 / 6.0, abs=1e-12)


# How the kinds differ


@pytest.mark.parametrize("mean_variation", [0.0, 0.05, 0.34, 3.0])
def test_the_corollarys_torque_is_that_of_type_1(recorded: Record, mean_variation: float) -> None:
    """Whatever the uncertainty, to 1e-12; only the spread is new."""
    type1 = learned(recorded, kind="t1")
    corollary = learned(recorded, kind="gt2", reduction="gaussian", mean_variation=mean_variation)
    for heights, speeds, desired in states(100):
        expected = type1.torque(0.0, heights, speeds, desired)
        found = corollary.torque(0.0, heights, speeds, desired)
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())
        mean, sigma = corollary.torque_interval.T
        np.testing.assert_array_equal(mean, found)
        assert (sigma > 0.0).all() if mean_variation else (sigma == 0.0).all()


def test_the_corollary_warns_where_it_is_far_from_exact(recorded: Record) -> None:
    with pytest.warns(fuzzy2.ApproximationWarning, match="Gaussian corollary"):
        FuzzyComputedTorque("gt2", ROBOT, mean_variation=0.34, reduction="gaussian").learn(recorded)


def test_product_grades_add_variances(
    trained: dict[str, FuzzyComputedTorque], tmp_path: Path
) -> None:
    """Under product secondary grades Theorem 1.5 adds squares.

    Written out here from the deviations of M, C and G.
    """
    content = json.loads(trained["corollary"].save(tmp_path / "controller.json").read_text())
    content["system"]["grade_t_norm"] = "product"
    (tmp_path / "controller.json").write_text(json.dumps(content))
    controller = FuzzyComputedTorque.load(tmp_path / "controller.json", ROBOT)
    for heights, speeds, desired in states(20):
        torque = controller.torque(0.0, heights, speeds, desired)
        servo = desired.accelerations + desired.speeds - speeds + 10.0 * (desired.heights - heights)
        M, C, G = (
            number.sigma  # type: ignore[union-attr]
            for number in controller.estimated_numbers(heights, speeds)
        )
        expected = np.sqrt((M**2) @ servo**2 + (C**2) @ speeds**2 + G**2)
        np.testing.assert_allclose(controller.torque_interval[:, 1], expected, rtol=1e-12)
        np.testing.assert_allclose(
            torque, trained["t1"].torque(0.0, heights, speeds, desired), rtol=1e-11
        )
        assert (
            expected
            < trained["corollary"]
            .torque_number(heights, speeds, desired)  # type: ignore[union-attr]
            .sigma
        ).all()


def test_without_noise_all_kinds_are_the_same_controller(recorded: Record) -> None:
    """Whole closed loops at an infinite signal-to-noise ratio, where the mean variation is zero.

    1e-12 relative.
    """
    runs = {}
    for name, options in KINDS.items():
        controller = learned(recorded, snr_db=math.inf, **options)
        assert controller.mean_variation == 0.0
        runs[name] = psp3.simulate(ROBOT, controller, HELIX, 10.4)
    for name in ("it2", "gt2", "corollary"):
        np.testing.assert_allclose(runs[name].torque, runs["t1"].torque, rtol=1e-12)
        np.testing.assert_allclose(runs[name].heights, runs["t1"].heights, rtol=0.0, atol=1e-12)
    # The controller tracks: within 3 cm of the path, of which 2.7 cm are the start from rest.
    assert np.abs(runs["t1"].heights - runs["t1"].desired.heights).max() < 0.03


def test_with_noise_type_2_is_another_controller(trained: dict[str, FuzzyComputedTorque]) -> None:
    heights, speeds, desired = states(1)[0]
    t1, it2, gt2 = (
        trained[name].torque(0.0, heights, speeds, desired) for name in ("t1", "it2", "gt2")
    )
    assert min(np.abs(t1 - it2).max(), np.abs(it2 - gt2).max(), np.abs(t1 - gt2).max()) > 0.1


# What is learned


def test_estimates_are_those_of_the_training_path(recorded: Record) -> None:
    """Relative root mean square over the 10.4 s of the training run.

    No noise, learner "ridge", per element of M and G.

    The bar is 2 % for M and G as matrices. The off-diagonal elements of M are a hundredth of the
    diagonal ones: 4 to 6 % of themselves is 0.05 % of M. C is 0.1 to 0.3 kg/s, times speeds of 0.1
    m/s nothing to the torque of 87 N, and is 20 % off.
    """
    controller = learned(recorded, kind="t1", snr_db=math.inf, learner="ridge")
    error = pack(*controller.estimate(recorded.heights, recorded.speeds)) - recorded.outputs
    relative = dict(
        zip(OUTPUT_NAMES, np.sqrt(np.mean(error**2, axis=0)) / recorded.rms, strict=True)
    )
    M, C, G = (
        np.sqrt((found**2).sum() / (exact**2).sum())
        for found, exact in zip(unpack(error), unpack(recorded.outputs), strict=True)
    )
    assert M < 0.004
    assert G < 0.002
    assert C < 0.25
    assert max(relative[name] for name in ("M11", "M22", "M33", "G1", "G2", "G3")) < 0.004
    assert max(relative[name] for name in ("M12", "M13", "M23")) < 0.06
    assert max(value for name, value in relative.items() if name.startswith("C")) < 0.25


def test_m_is_exactly_symmetric(trained: dict[str, FuzzyComputedTorque]) -> None:
    for controller in trained.values():
        M = controller.estimate(*(np.array([state[k] for state in states(50)]) for k in (0, 1)))[0]
        np.testing.assert_array_equal(M, M.swapaxes(-1, -2))


def test_noise_is_that_of_the_definition(recorded: Record) -> None:
    """Rules of "strongest" are samples.

    What noise does to them is exactly the generator's numbers times rms · 10^(−S/20).
    """
    clean = learned(recorded, kind="t1", snr_db=math.inf).system_.consequents
    samples = recorded.outputs[recorded.sample(209)]
    source = [int(np.flatnonzero((samples == rule).all(axis=1))[0]) for rule in clean]
    draws = np.random.default_rng(11).standard_normal((209, 18))
    for snr in (20.0, 10.0, 0.0):
        noisy = learned(recorded, seed=11, kind="t1", snr_db=snr).system_.consequents
        power = np.mean(recorded.outputs**2, axis=0)
        np.testing.assert_array_equal(
            noisy, samples[source] + np.sqrt(power) * 10.0 ** (-snr / 20.0) * draws[source]
        )


def test_noise_has_the_ratio_that_is_asked_for(recorded: Record) -> None:
    """Over 5201 samples with one rule each the power ratio is 15 dB within 0.34 dB.

    That is 4·4.34·√(2/5201), four deviations of χ².
    """
    noise: list[np.ndarray] = []

    class Listening(np.random.Generator):
        def standard_normal(  # type: ignore[override]
            self, *arguments: Any, **options: Any
        ) -> np.ndarray:
            noise.append(super().standard_normal(*arguments, **options))
            return noise[-1]

    FuzzyComputedTorque("t1", ROBOT, snr_db=15.0, learner="average").learn(
        recorded, 5201, Listening(np.random.PCG64(0))
    )
    amplitude = recorded.rms * 10.0 ** (-15.0 / 20.0)
    ratio = 10.0 * np.log10(
        (recorded.outputs**2).mean(axis=0) / ((noise[0] * amplitude) ** 2).mean(axis=0)
    )
    np.testing.assert_allclose(ratio, 15.0, atol=0.34)


def test_noise_is_new_unless_a_generator_is_given(recorded: Record) -> None:
    first, second = (
        FuzzyComputedTorque("t1", ROBOT, snr_db=20.0).learn(recorded) for _ in range(2)
    )
    assert not np.array_equal(first.system_.consequents, second.system_.consequents)
    clean = FuzzyComputedTorque("t1", ROBOT).learn(recorded, rng=np.random.default_rng(0))
    np.testing.assert_array_equal(
        clean.system_.consequents,
        FuzzyComputedTorque("t1", ROBOT).learn(recorded).system_.consequents,
    )


@pytest.mark.parametrize("snr", [math.inf, 40.0, 15.0, -10.0])
def test_the_mean_variation_follows_the_ratio(recorded: Record, snr: float) -> None:
    """Formula of the rule: 0.4 / (1 + 10^((S − 30)/20)); type-1 has none.

    The terms' means reach that far.
    """
    expected = 0.4 / (1.0 + 10.0 ** ((snr - 30.0) / 20.0))
    controller = FuzzyComputedTorque("it2", ROBOT, snr_db=snr)
    assert controller.mean_variation == pytest.approx(expected, rel=1e-14)
    assert FuzzyComputedTorque("t1", ROBOT, snr_db=snr, mean_variation=0.3).mean_variation == 0.0
    assert FuzzyComputedTorque("it2", ROBOT, snr_db=snr, mean_variation=0.1).mean_variation == 0.1
    term = learned(recorded, snr_db=math.inf, mean_variation=0.1).system_.inputs[0][0]
    span = np.ptp(recorded.inputs[recorded.sample(209)], axis=0)[0]
    assert term.mean[1] - term.mean[0] == pytest.approx(0.2 * span, rel=1e-12)


def test_ranges_and_average_are_those_of_the_samples(
    trained: dict[str, FuzzyComputedTorque], recorded: Record
) -> None:
    inputs = recorded.inputs[recorded.sample(209)]
    for controller in trained.values():
        np.testing.assert_array_equal(controller.ranges_, [inputs.min(axis=0), inputs.max(axis=0)])
        np.testing.assert_allclose(
            controller.fallback_, sum(controller.system_.consequents) / 16, rtol=1e-14
        )
        assert controller.system_.input_names == ("Δq12", "Δq13", "Δq̇12", "Δq̇13")
        assert controller.system_.output_names == OUTPUT_NAMES


@pytest.mark.parametrize("options", [{"kind": "t1"}, {"kind": "it2"}, {"kind": "gt2"}])
def test_wider_terms_have_the_same_rules(recorded: Record, options: dict[str, Any]) -> None:
    before, after = learned(recorded, **options), learned(recorded, term_width=2.0, **options)
    np.testing.assert_array_equal(after.system_.consequents, before.system_.consequents)
    np.testing.assert_array_equal(after.ranges_, before.ranges_)
    for old, new in zip(before.system_.inputs, after.system_.inputs, strict=True):
        for one, other in zip(old, new, strict=True):
            first, second = (
                term.principal if isinstance(term, fuzzy2.GaussianType2Set) else term
                for term in (one, other)
            )
            assert (second.mean, second.sigma) == (first.mean, 2.0 * first.sigma)


@pytest.mark.parametrize("kind", ["t1", "it2", "gt2"])
def test_terms_that_leave_the_path_uncovered_are_refused(recorded: Record, kind: str) -> None:
    """At the least width that is taken every estimate on the samples is finite.

    The greatest firing is 0.5^(4/width²) at the worst.
    """
    with pytest.raises(
        InvalidValue, match="term_width must be large enough for a rule to fire everywhere"
    ):
        learned(recorded, kind=kind, term_width=0.001)
    narrow = learned(recorded, kind=kind, term_width=0.1, snr_db=math.inf)
    chosen = recorded.sample(209)
    assert all(
        np.isfinite(part).all()
        for part in narrow.estimate(recorded.heights[chosen], recorded.speeds[chosen])
    )


def test_terms_without_end_give_the_average_over_the_rules(recorded: Record) -> None:
    """With terms a thousand ranges wide all rules fire alike.

    1e-4 is more than what is left of their difference, 1e-5.
    """
    controller = learned(recorded, kind="t1", term_width=1e3)
    outputs = np.asarray(controller.system_(recorded.inputs[::50]))
    np.testing.assert_allclose(
        outputs, np.broadcast_to(controller.fallback_, outputs.shape), rtol=1e-4, atol=1e-4
    )


def test_fit_tracks_records_and_learns(recorded: Record) -> None:
    fitted = FuzzyComputedTorque("t1", ROBOT).fit(HELIX)
    assert_same(fitted.controller, learned(recorded, kind="t1", snr_db=math.inf).controller)
    # The recording servo has the gains of the controller.
    stiff = FuzzyComputedTorque("t1", ROBOT, kp=100.0, kv=20.0).fit(HELIX, 2.0, samples=50)
    again = FuzzyComputedTorque("t1", ROBOT, kp=100.0, kv=20.0).learn(
        record(ROBOT, HELIX, 2.0, kp=100.0, kv=20.0), 50
    )
    assert_same(stiff.controller, again.controller)


def test_threads_can_learn_at_the_same_time(recorded: Record) -> None:
    with ThreadPoolExecutor(4) as pool:
        tables = list(pool.map(lambda seed: learned(recorded, seed % 2).controller, range(8)))
    for seed, table in enumerate(tables):
        assert_same(table, tables[seed % 2])


# Outside of the trained range, and estimates that cannot be used


def test_outside_inputs_are_clamped(trained: dict[str, FuzzyComputedTorque]) -> None:
    """The same M, C and G as at the nearest inputs within.

    Those are realized by moving nuts 2 and 3.
    """
    for controller in trained.values():
        least, greatest = controller.ranges_
        for heights, speeds, desired in states(100, seed=6):
            torque = controller.torque(0.0, heights, speeds, desired)
            x = np.array(
                [
                    heights[0] - heights[1],
                    heights[0] - heights[2],
                    speeds[0] - speeds[1],
                    speeds[0] - speeds[2],
                ]
            )
            assert controller.covered == bool(((least <= x) & (x <= greatest)).all())
            near = np.minimum(np.maximum(x, least), greatest)
            a = np.array([heights[0], heights[0] - near[0], heights[0] - near[1]])
            v = np.array([speeds[0], speeds[0] - near[2], speeds[0] - near[3]])
            M, C, G = unpack(controller.system_(near))
            expected = (
                M
                @ (
                    desired.accelerations
                    + desired.speeds
                    - speeds
                    + 10.0 * (desired.heights - heights)
                )
                + C @ speeds
                + G
            )
            np.testing.assert_allclose(
                torque, expected, rtol=0.0, atol=1e-12 * np.abs(expected).max()
            )
            # Differences of the moved nuts are the ends of the range but for rounding.
            np.testing.assert_allclose(
                unpack(controller.system_(near))[0], controller.estimate(a, v)[0], rtol=1e-12
            )


def test_outside_the_crisp_model_takes_over(recorded: Record) -> None:
    controller = learned(recorded, outside="crisp")
    clamping = learned(recorded)
    exact = psp3.ComputedTorque(ROBOT)
    seen = set()
    for heights, speeds, desired in states(100, seed=7):
        torque = controller.torque(0.0, heights, speeds, desired)
        seen.add(controller.covered)
        expected = (clamping if controller.covered else exact).torque(0.0, heights, speeds, desired)
        np.testing.assert_allclose(torque, expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())
        if not controller.covered:
            np.testing.assert_array_equal(
                controller.torque_interval, np.stack([torque, torque], axis=-1)
            )
    assert seen == {True, False}


def test_at_no_pose_the_crisp_model_says_so_and_the_clamped_one_goes_on(recorded: Record) -> None:
    state = (0.0, np.array([0.0, 1.0, -1.0]), np.zeros(3), HELIX(0.0))
    with pytest.raises(UnreachablePose):
        learned(recorded, outside="crisp").torque(*state)
    assert np.isfinite(learned(recorded).torque(*state)).all()


def spoiled(
    controller: FuzzyComputedTorque, change: Callable[[np.ndarray], None]
) -> FuzzyComputedTorque:
    """Return the controller with other consequents."""
    other = copy.copy(controller)
    consequents = np.array(controller.system_.consequents)
    change(consequents)
    system = controller.system_
    options: dict[str, Any] = {}
    if isinstance(system, GeneralType2System):
        options = {"reduction": system.reduction, "levels": system.levels}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fuzzy2.ApproximationWarning)
        other._take(
            (type(system)(system.inputs, system.rules, consequents, **options),),
            controller.ranges_,
        )
    return other


@pytest.mark.parametrize("name", [*KINDS, "gt2 last"])
def test_an_estimate_without_a_mass_matrix_falls_back_on_the_average(
    recorded: Record, name: str
) -> None:
    """One rule says that M is −40 kg.

    Where it fires most, M is not positive definite, and the average of the rules still is.
    """
    options = KINDS[name.removesuffix(" last")]
    order = "last" if name == "gt2 last" else "first"
    controller = learned(recorded, snr_db=math.inf, mean_variation=0.1, defuzzify=order, **options)

    def negative(consequents: np.ndarray) -> None:
        consequents[0, [0, 3, 5]] = -40.0

    controller = spoiled(controller, negative)
    corner = controller.ranges_[0]
    heights, speeds = (
        np.array([0.0, -corner[0], -corner[1]]),
        np.array([0.0, -corner[2], -corner[3]]),
    )
    desired = HELIX(0.3)
    assert np.linalg.eigvalsh(controller.estimate(heights, speeds)[0])[0] < 0.0
    torque = controller.torque(0.0, heights, speeds, desired)
    assert controller.fell_back
    servo = desired.accelerations + desired.speeds - speeds + 10.0 * (desired.heights - heights)
    M, C, G = unpack(controller.fallback_)
    np.testing.assert_allclose(torque, M @ servo + C @ speeds + G, rtol=1e-14)
    interval = controller.torque_interval
    np.testing.assert_array_equal(interval[:, 0], torque)
    np.testing.assert_array_equal(interval[:, 1], np.zeros(3) if name == "corollary" else torque)
    # Away from that rule nothing falls back.
    far = controller.ranges_[1]
    controller.torque(
        0.0, np.array([0.0, -far[0], -far[1]]), np.array([0.0, -far[2], -far[3]]), desired
    )
    assert not controller.fell_back


@given(st.lists(st.floats(-3.0, 3.0), min_size=6, max_size=6))
def test_what_counts_as_positive_definite_is_what_the_eigenvalues_say(
    trained: dict[str, FuzzyComputedTorque], entries: list[float]
) -> None:
    """One matrix in all 16 rules.

    Matrices within rounding, 1e-9, of a zero eigenvalue may go either way.
    """
    consequents = np.tile([*entries, *np.zeros(12)], (16, 1))
    least = np.linalg.eigvalsh(unpack(consequents[0])[0])[0]
    if abs(least) < 1e-9:
        return
    controller = copy.copy(trained["t1"])
    if least < 0.0:
        system = type(controller.system_)(
            controller.system_.inputs, controller.system_.rules, consequents
        )
        with pytest.raises(UnusableEstimate):
            controller._take((system,), controller.ranges_)
        # With an average that is usable, the rules themselves decide.
        controller = copy.copy(trained["t1"])
        system = type(controller.system_)(
            controller.system_.inputs, controller.system_.rules, consequents
        )
        assert system.table is not None
        controller._packed = kernels.packed(controller.controller._replace(system=system.table))
        controller.torque(0.0, np.zeros(3), np.zeros(3), HELIX(0.0))
        assert controller.fell_back
    else:
        system = type(controller.system_)(
            controller.system_.inputs, controller.system_.rules, consequents
        )
        controller._take((system,), controller.ranges_)
        controller.torque(0.0, np.zeros(3), np.zeros(3), HELIX(0.0))
        assert not controller.fell_back


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e308])
def test_an_estimate_that_is_not_finite_falls_back(recorded: Record, value: float) -> None:
    """A damaged table stands for whatever makes an estimate overflow."""
    controller = learned(recorded, kind="t1", snr_db=math.inf)
    table = controller.controller.system.copy()
    table[-16 * 18 * 4 - 36 : -16 * 18 * 4] = value
    controller._packed = kernels.packed(controller.controller._replace(system=table))
    torque = controller.torque(0.0, *states(1)[0])
    assert controller.fell_back
    assert np.isfinite(torque).all()


def test_without_a_usable_average_there_is_no_controller(recorded: Record) -> None:
    """At −20 dB the noise is ten times the signal.

    With it the average of 16 rules is still 2.5 times.
    """
    with pytest.raises(UnusableEstimate, match="not positive definite") as caught:
        learned(recorded, seed=0, snr_db=-20.0, kind="t1")
    assert np.linalg.eigvalsh(caught.value.mass)[0] <= 0.0


def test_noise_of_the_signals_size_is_survived_by_falling_back(recorded: Record) -> None:
    """At 0 dB rules without a mass matrix are met on the way, and the result says where."""
    controller = learned(recorded, 2, snr_db=0.0, kind="t1")
    assert (np.linalg.eigvalsh(unpack(controller.system_.consequents)[0])[:, 0] < 0.0).any()
    result = None
    try:
        result = psp3.simulate(ROBOT, controller, HELIX, 3.0)
    except psp3.errors.SimulationStopped as error:
        result = error.result
    assert result is not None
    assert result.fell_back is not None
    assert result.fell_back.any()
    assert np.isfinite(result.torque).all()


# What was not learned, and bad input


def test_a_controller_that_has_not_learned_says_so(tmp_path: Path) -> None:
    controller = FuzzyComputedTorque("it2", ROBOT)
    a, v, desired = np.zeros(3), np.zeros(3), HELIX(0.0)
    number = fuzzy2.IntervalNumber(np.zeros(3), np.zeros(3))
    for call in (
        lambda: controller.torque(0.0, a, v, desired),
        lambda: controller.estimate(a, v),
        lambda: controller.estimated_numbers(a, v),
        lambda: controller.torque_number(a, v, desired),
        lambda: controller.defuzzify(number),
        lambda: controller.save(tmp_path / "file.json"),
        lambda: controller.controller,
        lambda: psp3.simulate(ROBOT, controller, HELIX, 1.0),
    ):
        with pytest.raises(NotTrained, match="fit"):
            call()
    assert list(tmp_path.iterdir()) == []
    assert np.isnan(controller.torque_interval).all()
    assert (controller.covered, controller.fell_back) == (False, False)
    assert "not trained" in repr(controller)


def test_what_the_last_call_said_is_forgotten_by_reset_and_kept_over_errors(
    recorded: Record,
) -> None:
    controller = learned(recorded)
    first = controller.torque(0.0, *states(1)[0])
    kept, interval = first.copy(), controller.torque_interval
    with pytest.raises(InvalidArray):
        controller.torque(0.0, np.full(3, np.nan), np.zeros(3), HELIX(0.0))
    np.testing.assert_array_equal(controller.torque_interval, interval)
    controller.torque(0.0, *states(2)[1])
    np.testing.assert_array_equal(first, kept)
    controller.reset()
    assert np.isnan(controller.torque_interval).all()


def test_rows_of_every_form_are_taken(trained: dict[str, FuzzyComputedTorque]) -> None:
    controller = trained["it2"]
    heights, speeds, desired = states(1)[0]
    expected = controller.torque(0.0, heights, speeds, desired)
    frozen = heights.copy()
    frozen.setflags(write=False)
    wide = np.repeat(heights, 2)
    for row in (
        heights.tolist(),
        tuple(heights),
        frozen,
        wide[::2],
        heights.astype(">f8"),
        np.asfortranarray(heights),
    ):
        np.testing.assert_array_equal(
            controller.torque(0.0, row, speeds.tolist(), desired), expected
        )
        np.testing.assert_array_equal(
            controller.torque(
                0.0, heights, speeds, desired._replace(speeds=desired.speeds.tolist())
            ),
            expected,
        )
    whole = controller.torque(
        0.0,
        [0, 0, 0],  # type: ignore[arg-type]
        np.zeros(3, dtype=int),
        desired,
    )
    np.testing.assert_array_equal(whole, controller.torque(0.0, np.zeros(3), np.zeros(3), desired))


BAD_ROWS = [
    np.full(3, np.nan),
    [0.0, np.inf, 0.0],
    np.zeros(2),
    np.zeros((1, 3)),
    np.zeros((3, 1)),
    0.1,
    None,
    "abc",
    np.zeros(3) + 1j,
]


@pytest.mark.parametrize("bad", BAD_ROWS, ids=str)
@pytest.mark.parametrize("place", range(5))
def test_other_rows_are_refused_by_name(
    trained: dict[str, FuzzyComputedTorque], bad: Any, place: int
) -> None:
    rows: list[Any] = [np.zeros(3) for _ in range(5)]
    rows[place] = bad
    desired = Motion(rows[2], rows[3], rows[4], np.zeros(3))
    name = ("positions", "speeds", "desired positions", "desired speeds", "desired accelerations")[
        place
    ]
    for call in (
        lambda: trained["it2"].torque(0.0, rows[0], rows[1], desired),
        lambda: trained["it2"].torque_number(*rows[:2], desired),
    ):
        with pytest.raises(InvalidArray, match=f"^{name} must be"):
            call()


def test_forces_that_overflow_end_a_simulation_as_such(recorded: Record) -> None:
    with pytest.raises(InvalidTorque, match="FuzzyComputedTorque"):
        psp3.simulate(
            ROBOT,
            learned(recorded, kp=1e308, kv=1e308),
            HELIX,
            1.0,
            initial_positions=[0.1, 0.0, 0.0],
        )


@pytest.mark.parametrize(
    ("options", "error"),
    [
        ({"kind": "t2"}, UnknownName),
        ({"kind": None}, UnknownName),
        ({"learner": "Strongest"}, UnknownName),
        ({"reduction": "km"}, UnknownName),
        ({"outside": "ignore"}, UnknownName),
        ({"defuzzify": "middle"}, UnknownName),
        ({"kp": -1.0}, InvalidValue),
        ({"kp": "10"}, InvalidValue),
        ({"kv": None}, InvalidValue),
        ({"kv": math.inf}, InvalidValue),
        ({"kp": True}, InvalidValue),
        ({"n_terms": 0}, InvalidValue),
        ({"n_terms": 2.0}, InvalidValue),
        ({"n_terms": "2"}, InvalidValue),
        ({"levels": 0}, InvalidValue),
        ({"levels": True}, InvalidValue),
        ({"snr_db": math.nan}, InvalidValue),
        ({"snr_db": -math.inf}, InvalidValue),
        ({"snr_db": "15"}, InvalidValue),
        ({"snr_db": True}, InvalidValue),
        ({"snr_db": -1e4}, InvalidValue),
        ({"snr_db": [15.0]}, InvalidValue),
        ({"mean_variation": -0.1}, InvalidValue),
        ({"mean_variation": math.nan}, InvalidValue),
        ({"mean_variation": math.inf}, InvalidValue),
        ({"mean_variation": "0.3"}, InvalidValue),
        ({"robot": "psp3"}, InvalidValue),
    ],
)
def test_other_parameters_are_refused_at_once(
    options: dict[str, Any], error: type[Exception]
) -> None:
    with pytest.raises(error) as caught:
        FuzzyComputedTorque(**{"robot": ROBOT} | options)
    assert isinstance(caught.value, psp3.PSP3Error)


def test_huge_and_tiny_parameters_are_taken(recorded: Record) -> None:
    for options in (
        {"mean_variation": 1e300},
        {"kp": 1e-300, "kv": 0.0},
        {"snr_db": np.float32(15.0)},
        {"snr_db": 10**6},
    ):
        assert np.isfinite(learned(recorded, **options).torque(0.0, *states(1)[0])).all()
    assert np.isfinite(learned(recorded, kind="gt2", levels=200).torque(0.0, *states(1)[0])).all()


def test_rules_that_no_sample_supports_are_named_by_the_inputs(recorded: Record) -> None:
    with pytest.raises(
        UnsupportedRule, match=r"Δq12 is \w+ and Δq13 is \w+ and Δq̇12 is \w+ and Δq̇13 is"
    ):
        FuzzyComputedTorque("t1", ROBOT, n_terms=3).learn(recorded)
    with pytest.raises(UnsupportedRule, match='fewer terms, or take learner="strict"') as caught:
        FuzzyComputedTorque("t1", ROBOT, n_terms=3).learn(recorded)
    assert "completion" not in str(caught.value)
    # The strict learner fills such cells from their neighbors.
    strict = FuzzyComputedTorque("t1", ROBOT, n_terms=3, learner="strict").learn(recorded)
    assert len(strict.system_.rules) == 81


@pytest.mark.parametrize("rng", [0, "x", np.random.RandomState(0)])
def test_noise_needs_a_generator(recorded: Record, rng: Any) -> None:
    with pytest.raises(InvalidValue, match="default_rng"):
        FuzzyComputedTorque("t1", ROBOT, snr_db=15.0).learn(recorded, rng=rng)


def test_a_path_on_which_the_star_does_not_tilt_cannot_be_learned() -> None:
    for path in (Hold(robot=ROBOT), Line([0.0, 0.0, 0.07], [0.0, 0.0, 0.1], 1.0, ROBOT)):
        with pytest.raises(InvalidValue, match="Δq12"):
            FuzzyComputedTorque("it2", ROBOT).fit(path, 1.0)
    with pytest.raises(InvalidValue, match="length of the record"):
        FuzzyComputedTorque("it2", ROBOT).fit(HELIX, 0.1)


def test_a_path_that_was_not_learned_is_not_covered(recorded: Record) -> None:
    """A level circle at twice the speed leaves the range of the speeds.

    The result says at which samples.
    """
    result = psp3.simulate(
        ROBOT, learned(recorded, snr_db=math.inf), Circle(period=1.0, robot=ROBOT), 2.0
    )
    assert result.covered is not None
    assert not result.covered[500:].all()


# Files


@pytest.mark.parametrize("name", KINDS)
def test_controllers_come_back_from_a_file_bit_for_bit(
    trained: dict[str, FuzzyComputedTorque], name: str, tmp_path: Path
) -> None:
    controller = trained[name]
    path = controller.save(tmp_path / "controller.json")
    for robot in (None, ROBOT):
        again = FuzzyComputedTorque.load(path, robot)
        assert_same(again.controller, controller.controller)
        for attribute in (
            "kind",
            "kp",
            "kv",
            "n_terms",
            "learner",
            "snr_db",
            "mean_variation",
            "outside",
            "reduction",
            "levels",
        ):
            assert getattr(again, attribute) == getattr(controller, attribute)
        assert again.robot.parameters == ROBOT.parameters
        for state in states(5):
            np.testing.assert_array_equal(again.torque(0.0, *state), controller.torque(0.0, *state))
            np.testing.assert_array_equal(again.torque_interval, controller.torque_interval)
    assert [file.name for file in tmp_path.iterdir()] == ["controller.json"]
    again.save(tmp_path / "again.json")
    assert (tmp_path / "again.json").read_bytes() == path.read_bytes()


def test_gains_options_and_infinity_come_back(recorded: Record, tmp_path: Path) -> None:
    controller = learned(
        recorded, kind="t1", kp=3.5, kv=0.25, snr_db=math.inf, outside="crisp", learner="ridge"
    )
    again = FuzzyComputedTorque.load(controller.save(tmp_path / "controller.json"))
    assert (again.kp, again.kv, again.snr_db, again.outside, again.learner) == (
        3.5,
        0.25,
        math.inf,
        "crisp",
        "ridge",
    )
    assert_same(again.controller, controller.controller)


def test_controllers_for_another_robot_are_refused(
    trained: dict[str, FuzzyComputedTorque], tmp_path: Path
) -> None:
    path = trained["it2"].save(tmp_path / "controller.json")
    with pytest.raises(InvalidControllerFile, match=r"star_mass 1\.758 \(yours 2\.0\)"):
        FuzzyComputedTorque.load(path, psp3.load("psp3", Parameters(star_mass=2.0)))
    heavy = json.loads(path.read_text())
    heavy["robot"]["star_mass"] = 2.0
    path.write_text(json.dumps(heavy))
    assert FuzzyComputedTorque.load(path).robot.parameters.star_mass == 2.0


@pytest.fixture(scope="module")
def content(
    trained: dict[str, FuzzyComputedTorque], tmp_path_factory: pytest.TempPathFactory
) -> dict[str, Any]:
    path = trained["it2"].save(tmp_path_factory.mktemp("files") / "controller.json")
    loaded: dict[str, Any] = json.loads(path.read_text())
    return loaded


def places(document: Any, prefix: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Return the places in a document, of long lists the first and last only."""
    found = [prefix] if prefix else []
    if isinstance(document, dict):
        for name, value in document.items():
            found += places(value, (*prefix, name))
    elif isinstance(document, list):
        for index in sorted({0, len(document) - 1} if document else set()):
            found += places(document[index], (*prefix, index))
    return found


def changed(document: Any, place: tuple[Any, ...], value: Any = None, drop: bool = False) -> Any:
    spoiled = copy.deepcopy(document)
    inner = spoiled
    for step in place[:-1]:
        inner = inner[step]
    if drop:
        del inner[place[-1]]
    else:
        inner[place[-1]] = value
    return spoiled


OPTIONAL = {
    "input_ranges",
    "output_ranges",
    "term_names",
    "t_norm",
    "t_conorm",
    "type_reduction",
    "method",
    "fuzzifier",
    "resolution",
    "consequent_names",
    "default_outputs",
    "disjunction",
    "implication",
    "integration",
    "output_terms",
    "shares",
    "silent",
    "weights",
}


def test_without_any_of_its_parts_a_file_is_refused(
    content: dict[str, Any], tmp_path: Path
) -> None:
    """But for what the fuzzy system's own constructor has a default for.

    And for the order of defuzzification, which older files do not know.
    """
    path = tmp_path / "controller.json"
    for place in places(content):
        if place[0] == "system" and place[1:2] and place[1] in OPTIONAL:
            continue
        if place == ("defuzzify",):
            continue
        path.write_text(json.dumps(changed(content, place, drop=True)))
        with pytest.raises(InvalidControllerFile, match=r"controller\.json"):
            FuzzyComputedTorque.load(path, ROBOT)


@pytest.mark.parametrize("order", ["first", "last"])
def test_the_order_is_in_the_file_and_files_without_it_defuzzify_first(
    recorded: Record, trained: dict[str, FuzzyComputedTorque], tmp_path: Path, order: str
) -> None:
    controller = learned(recorded, kind="gt2", defuzzify=order)
    path = controller.save(tmp_path / "controller.json")
    content = json.loads(path.read_text())
    assert content["defuzzify"] == order
    loaded = FuzzyComputedTorque.load(path, ROBOT)
    assert_same(loaded.controller, controller.controller)
    assert loaded.order == order
    del content["defuzzify"]
    path.write_text(json.dumps(content))
    older = FuzzyComputedTorque.load(path, ROBOT)
    assert_same(older.controller, trained["gt2"].controller)


WRONG: list[Any] = [None, "nonsense", [], {}, -1.0, math.nan, True, 10**400]


@pytest.mark.slow
@pytest.mark.parametrize("value", WRONG, ids=lambda value: str(value)[:10])
def test_values_of_other_kinds_are_refused_or_harmless(
    content: dict[str, Any], tmp_path: Path, value: Any
) -> None:
    """Only InvalidControllerFile is ever raised, and whatever is loaded has finite torques."""
    path = tmp_path / "controller.json"
    refused = set()
    for place in places(content):
        path.write_text(json.dumps(changed(content, place, value)))
        try:
            controller = FuzzyComputedTorque.load(path, ROBOT)
        except InvalidControllerFile:
            refused.add(place)
            continue
        assert np.isfinite(controller.torque(0.0, *states(1)[0])).all()
    everything = {(name,) for name in content}
    if value == -1.0:
        everything -= {("snr_db",)}
    assert everything <= refused


def swap(content: dict[str, Any], what: str) -> dict[str, Any]:
    names = list(content[what])
    names[0], names[1] = names[1], names[0]
    return {**content, what: names}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda c: {**c, "format": "psp3-fuzzy-computed-torque-0"}, "has format"),
        (lambda c: [c], "format 'list'"),
        (lambda c: swap(c, "inputs"), "has the inputs Δq13, Δq12"),
        (lambda c: swap(c, "outputs"), "has the outputs M12, M11"),
        (lambda c: {**c, "system": swap(c["system"], "input_names")}, "other inputs or outputs"),
        (lambda c: {**c, "system": swap(c["system"], "output_names")}, "other inputs or outputs"),
        (lambda c: {**c, "kind": "t1"}, "kind 't1' and holds IntervalType2System"),
        (lambda c: {**c, "n_terms": 3}, "n_terms 3"),
        (lambda c: {**c, "ranges": c["ranges"][::-1]}, "ranges"),
        (lambda c: {**c, "ranges": [[0.0] * 4, [0.0] * 4]}, "ranges"),
        (lambda c: {**c, "ranges": [row[:3] for row in c["ranges"]]}, "ranges"),
        (lambda c: {**c, "ranges": [[-math.inf] * 4, [math.inf] * 4]}, "-Infinity is not a number"),
        (lambda c: {**c, "robot": {**c["robot"], "wheels": 4}}, "wheels"),
        (
            lambda c: {**c, "system": {**c["system"], "method": "nie_tan"}},
            "compiled loop cannot",
        ),
        (
            lambda c: {
                **c,
                "system": {
                    **c["system"],
                    "consequents": (-np.array(c["system"]["consequents"])).tolist(),
                },
            },
            "positive definite",
        ),
        (
            lambda c: {
                **c,
                "system": {
                    **c["system"],
                    "consequents": np.array(c["system"]["consequents"])[..., None]
                    .repeat(2, 2)
                    .tolist(),
                },
            },
            "number for each rule",
        ),
    ],
)
def test_files_that_do_not_fit_are_refused(
    content: dict[str, Any], tmp_path: Path, change: Callable[[dict[str, Any]], Any], message: str
) -> None:
    path = tmp_path / "controller.json"
    path.write_text(json.dumps(change(content)))
    with pytest.raises(InvalidControllerFile, match=message) as caught:
        FuzzyComputedTorque.load(path)
    assert caught.value.path == path


def test_damaged_files_are_refused(content: dict[str, Any], tmp_path: Path) -> None:
    path = tmp_path / "controller.json"
    whole = json.dumps(content).encode()
    for share in (0.0, 0.01, 0.5, 0.99, 0.99999):
        path.write_bytes(whole[: int(share * len(whole))])
        with pytest.raises(InvalidControllerFile, match="not a whole"):
            FuzzyComputedTorque.load(path)
    for bad in (b"\xff\xfe\x00", b"[" * 100_000, b"not JSON", b"\x00" * 10):
        path.write_bytes(bad)
        with pytest.raises(InvalidControllerFile):
            FuzzyComputedTorque.load(path)
    for nothing in (tmp_path / "missing.json", tmp_path):
        with pytest.raises(InvalidControllerFile):
            FuzzyComputedTorque.load(nothing)
    with pytest.raises(InvalidValue, match="the path of a file"):
        FuzzyComputedTorque.load("a\0b")


@pytest.mark.parametrize("count", [0, 1])
def test_a_motion_of_no_samples_is_refused_by_its_name(count: int) -> None:
    rows = np.full((count, 3), 0.1)
    with pytest.raises(InvalidArray, match=r"positions .*\(N, 3\), N at least 2"):
        FuzzyComputedTorque("t1", ROBOT).learn_from_motion(rows, rows, rows, rows)


def test_a_motion_that_stands_still_is_refused_by_its_name() -> None:
    rows = np.full((50, 3), 0.1)
    with pytest.raises(InvalidValue, match="positions and speeds must be"):
        FuzzyComputedTorque("t1", ROBOT).learn_from_motion(rows, rows, rows, rows)
