"""Identification: unbiased, with standard errors that mean what they say.

From noisy simulated measurements.
"""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest

import psp3
from psp3.errors import CorrelatedResiduals, InvalidArray, InvalidValue, PoorExcitation
from psp3.identification.base_parameters import BaseParameters, base_parameters
from psp3.identification.excitation import exciting_motion
from psp3.identification.least_squares import Identified, _weighted_least_squares, identify
from psp3.identification.unknowns import all_parameters
from psp3.thesis.table_3_1 import numbers_of_table_3_1
from psp3.trajectories.fourier_series import FourierSeries
from tests.helpers import Array

PERIOD, HARMONICS, COUNT = 4.0, 3, 30
BALLS = ["ball_axial_inertia", "ball_transverse_inertia"]
TIMES = np.arange(COUNT) * PERIOD / COUNT


@pytest.fixture(scope="module")
def base() -> BaseParameters:
    return base_parameters(numbers_of_table_3_1(psp3.load("psp3")).without(BALLS))


@pytest.fixture(scope="module")
def motion(base: BaseParameters) -> FourierSeries:
    return exciting_motion(
        base, 1.0, 10.0, [-0.1] * 3, [0.1] * 3, period=PERIOD, harmonics=HARMONICS, draws=5, steps=4
    )


def measured(
    base: BaseParameters,
    motion: FourierSeries,
    t: Array,
    position_noise: float,
    force_noise: Array,
    seed: int,
) -> Identified:
    rng = np.random.default_rng(seed)
    joints = motion.joints(t)
    forces = base.unknowns.robot.inverse_dynamics(*joints)
    noisy = (
        joints[0] + position_noise * rng.normal(size=forces.shape),
        forces + force_noise * rng.normal(size=forces.shape),
    )
    return identify(base, t, *noisy, PERIOD, HARMONICS)


def test_without_noise_it_finds_what_is_there(base: BaseParameters, motion: FourierSeries) -> None:
    """1e-10 relative: rounding times a condition of some 10."""
    found = measured(base, motion, TIMES, 0.0, np.zeros(3), 0)
    np.testing.assert_allclose(found.values, base.believed, rtol=1e-10)
    np.testing.assert_allclose(found.unknowns, base.unknowns.believed, rtol=1e-9)
    np.testing.assert_allclose(found.motion.sines, motion.sines, atol=1e-13)
    assert found.degrees_of_freedom == 3 * COUNT - len(base.columns)


def test_a_robot_of_which_nothing_is_believed_rightly(
    base: BaseParameters, motion: FourierSeries
) -> None:
    """Measured is another robot than the believed one, by the closed form: its numbers come out."""
    other = psp3.load(
        "psp3",
        parameters=replace(
            psp3.Parameters(), star_mass=4.0, nut_mass=9.5, star_inertia=(0.1, 0.09, 0.15)
        ),
    )
    joints = motion.joints(TIMES)
    found = identify(base, TIMES, joints[0], other.inverse_dynamics(*joints), PERIOD, HARMONICS)
    np.testing.assert_allclose(found.values, [9.5 + 3.0 * 0.357, 4.0, 0.1, 0.09, 0.15], rtol=1e-9)


@pytest.fixture(scope="module")
def repeated(base: BaseParameters, motion: FourierSeries) -> list[Identified]:
    """Both noises matter.

    Errors in position make a third to a half of the variances, forces of unlike quality the rest.
    That one in a hundred warns of correlation by chance is tested below.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", CorrelatedResiduals)
        return [
            measured(base, motion, TIMES, 2e-4, np.array([0.03, 0.06, 0.12]), seed)
            for seed in range(60)
        ]


def test_estimates_are_unbiased(base: BaseParameters, repeated: list[Identified]) -> None:
    """The mean of 60 seeds is within three standard errors of the mean.

    For each of five parameters.
    """
    values = np.array([found.values for found in repeated])
    error = values.std(axis=0, ddof=1) / np.sqrt(len(values))
    assert (np.abs(values.mean(axis=0) - base.believed) < 3.0 * error).all()


def test_standard_errors_are_those_of_many_seeds(repeated: list[Identified]) -> None:
    """A standard deviation of 60 is uncertain by 1/sqrt(120), 9 %; 30 % is three of these.

    So it is for the correlations.
    """
    values = np.array([found.values for found in repeated])
    stated = np.mean([found.covariance for found in repeated], axis=0)
    np.testing.assert_allclose(values.std(axis=0, ddof=1), np.sqrt(np.diag(stated)), rtol=0.3)
    scale = np.sqrt(np.diag(stated))
    np.testing.assert_allclose(np.corrcoef(values.T), stated / np.outer(scale, scale), atol=0.4)


def test_noise_of_positions_is_in_the_standard_errors(
    base: BaseParameters, motion: FourierSeries, repeated: list[Identified]
) -> None:
    """Forces alone would explain much less than what many seeds show.

    The second term of the covariance is needed.
    """
    noise = np.array([0.03, 0.06, 0.12])
    columns, _ = base.forces_of(*motion.joints(TIMES))
    weighted = (columns / noise[:, None]).reshape(-1, columns.shape[-1])
    of_forces = np.sqrt(np.diag(np.linalg.inv(weighted.T @ weighted)))
    spread = np.std([found.values for found in repeated], axis=0)
    assert (spread > 1.3 * of_forces).any()


def test_a_share_of_the_samples_tells_how_positions_matter(
    base: BaseParameters, motion: FourierSeries, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of 400 samples every fourth stands for all: the standard errors are the same.

    Nearly all of them is noise of the positions. The sums are means of smooth periodic functions,
    but the last of the 100 points is a sample before the period's end, and not four: a weight of
    1 % at one place, for which 2 % are allowed. Without the factor they would be a quarter.
    """
    times = np.arange(400) * PERIOD / 400
    errors = []
    for count in (400, 100):
        monkeypatch.setattr("psp3.identification.least_squares.SENSITIVITY_SAMPLES", count)
        found = measured(base, motion, times, 1e-3, np.full(3, 1e-4), 3)
        errors.append(np.sqrt(np.diag(found.covariance)))
    np.testing.assert_allclose(errors[1], errors[0], rtol=0.02)


def test_intervals_hold_the_truth_as_often_as_they_say(
    base: BaseParameters, repeated: list[Identified]
) -> None:
    """60 seeds of five intervals.

    If those of a seed were all alike, the share would be uncertain by 2.8 %; three of these are
    allowed.
    """
    inside = [
        (found.intervals[:, 0] <= base.believed) & (base.believed <= found.intervals[:, 1])
        for found in repeated
    ]
    assert abs(np.mean(inside) - 0.95) < 3.0 * np.sqrt(0.95 * 0.05 / 60)


def test_noise_is_found_joint_by_joint(repeated: list[Identified]) -> None:
    """Positions to 2 % by 60 seeds of 23 degrees of freedom.

    What positions do to forces is added to their noise, so it is no less.
    """
    np.testing.assert_allclose(
        np.sqrt(np.mean([found.position_noise**2 for found in repeated], axis=0)), 2e-4, rtol=0.06
    )
    forces = np.sqrt(np.mean([found.force_noise**2 for found in repeated], axis=0))
    assert (forces > 0.95 * np.array([0.03, 0.06, 0.12])).all()
    assert (forces < 1.5 * np.array([0.03, 0.06, 0.12])).all()


def test_least_squares_are_unbiased_and_cover_over_2000_seeds(
    base: BaseParameters, motion: FourierSeries
) -> None:
    """Exact positions and 2000 seeds: a mean within 3.5 standard errors.

    And intervals that hold 95 % to 2 %, four times 0.5 %.
    """
    columns, _ = base.forces_of(*motion.joints(TIMES))
    noise, rng = np.array([0.3, 0.6, 1.2]), np.random.default_rng(0)
    z = []
    for _ in range(2000):
        values, information, _, _ = _weighted_least_squares(
            columns, columns @ base.believed + noise * rng.normal(size=(COUNT, 3))
        )
        z.append((values - base.believed) / np.sqrt(np.diag(np.linalg.inv(information))))
    assert (np.abs(np.mean(z, axis=0)) < 3.5 / np.sqrt(2000)).all()
    coverage = np.mean(np.abs(z) < 1.988, axis=0)  # Student, 85 degrees of freedom
    assert (np.abs(coverage - 0.95) < 0.02).all()


def identified_with(
    base: BaseParameters, motion: FourierSeries, correlation: float, count: int
) -> tuple[list[Identified], list[CorrelatedResiduals]]:
    """Many experiments with both noises, and the warnings: forces correlated from row to row."""
    joints, rng = motion.joints(TIMES), np.random.default_rng(11)
    exact = base.unknowns.robot.inverse_dynamics(*joints)
    found = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        for _ in range(count):
            noise = rng.standard_normal(exact.shape)
            for k in range(1, COUNT):
                noise[k] *= np.sqrt(1.0 - correlation**2)
                noise[k] += correlation * noise[k - 1]
            forces = exact + np.array([0.3, 0.6, 1.2]) * noise
            positions = joints[0] + 2e-4 * rng.standard_normal(exact.shape)
            found.append(identify(base, TIMES, positions, forces, PERIOD, HARMONICS))
    assert all(isinstance(warning.message, CorrelatedResiduals) for warning in caught)
    return found, [warning.message for warning in caught]  # type: ignore[misc]


def test_independent_noise_hardly_ever_warns(base: BaseParameters, motion: FourierSeries) -> None:
    """1 % of 60: more than four come once in 3000 such tests."""
    found, caught = identified_with(base, motion, 0.0, 60)
    assert len(caught) <= 4
    assert abs(np.mean([one.residual_correlation for one in found])) < 0.2


def test_correlated_noise_always_warns(base: BaseParameters, motion: FourierSeries) -> None:
    """Noise with a correlation of 0.8: 30 of 30, with the numbers and what to do."""
    found, caught = identified_with(base, motion, 0.8, 30)
    assert len(caught) == 30
    warning = caught[0]
    assert warning.joint in base.unknowns.robot.actuated
    joint = base.unknowns.robot.actuated.index(warning.joint)
    assert warning.correlation == found[0].residual_correlation[joint] > 0.4
    assert warning.samples == COUNT
    share = (1.0 - warning.correlation) / (1.0 + warning.correlation)
    assert warning.effective == pytest.approx(COUNT * share)
    assert warning.correlation**warning.step <= 0.1 < warning.correlation ** (warning.step - 1)
    assert f"every {warning.step}th sample" in str(warning)


def test_negative_correlation_makes_intervals_too_wide_and_does_not_warn(
    base: BaseParameters, motion: FourierSeries
) -> None:
    """Noise with a correlation of −0.8: 40 times five intervals, of which 99.7 % held in 1500.

    Were it 95 % of them, so few misses as two in 200 would come once in 400 such tests.
    """
    found, caught = identified_with(base, motion, -0.8, 40)
    assert not caught
    assert np.mean([one.residual_correlation for one in found]) < -0.5
    ends = np.array([one.intervals for one in found])
    missed = (base.believed < ends[..., 0]) | (base.believed > ends[..., 1])
    assert missed.sum() <= 2


def test_order_of_the_samples_does_not_matter(base: BaseParameters, motion: FourierSeries) -> None:
    """Correlation is that of neighbors in time, wherever they stand in the table."""
    rng = np.random.default_rng(12)
    joints = motion.joints(TIMES)
    forces = base.unknowns.robot.inverse_dynamics(*joints)
    forces = forces + np.cumsum(rng.standard_normal(forces.shape), axis=0)
    shuffled = rng.permutation(COUNT)
    found = []
    for rows in (np.arange(COUNT), shuffled):
        with pytest.warns(CorrelatedResiduals) as caught:
            found.append(
                identify(base, TIMES[rows], joints[0][rows], forces[rows], PERIOD, HARMONICS)
            )
        assert len(caught) == 1
    np.testing.assert_allclose(
        found[0].residual_correlation, found[1].residual_correlation, atol=1e-9
    )


def test_weights_beat_equal_weights(base: BaseParameters, motion: FourierSeries) -> None:
    """Forces of very unlike quality.

    The errors of 200 seeds are smaller than those of plain least squares, for every parameter.
    """
    columns, _ = base.forces_of(*motion.joints(TIMES))
    noise, rng = np.array([0.05, 0.5, 5.0]), np.random.default_rng(1)
    weighted, plain = [], []
    for _ in range(200):
        forces = columns @ base.believed + noise * rng.normal(size=(COUNT, 3))
        weighted.append(_weighted_least_squares(columns, forces)[0])
        plain.append(
            np.linalg.lstsq(columns.reshape(-1, columns.shape[-1]), forces.ravel(), rcond=None)[0]
        )
    assert (np.std(weighted, axis=0) < 0.8 * np.std(plain, axis=0)).all()


def test_errors_fall_with_the_root_of_the_number_of_samples(
    base: BaseParameters, motion: FourierSeries
) -> None:
    """Four and sixteen times the samples.

    Errors of 300 seeds fall by 2 and 4, each uncertain by 4 %; so do standard errors.
    """
    rng, errors, stated = np.random.default_rng(2), [], []
    for count in (30, 120, 480):
        columns, _ = base.forces_of(*motion.joints(np.arange(count) * PERIOD / count))
        exact = columns @ base.believed
        fits = [
            _weighted_least_squares(columns, exact + 0.5 * rng.normal(size=exact.shape))[:2]
            for _ in range(300)
        ]
        errors.append(np.std([values for values, _ in fits], axis=0))
        stated.append(
            np.mean(
                [np.sqrt(np.diag(np.linalg.inv(information))) for _, information in fits], axis=0
            )
        )
    for sizes in (errors, stated):
        np.testing.assert_allclose(sizes[0] / sizes[1], 2.0, rtol=0.2)
        np.testing.assert_allclose(sizes[0] / sizes[2], 4.0, rtol=0.2)


def test_a_simulated_robot_under_control_is_identified(
    base: BaseParameters, motion: FourierSeries
) -> None:
    """All of it: computed torque that believes in another star tracks the motion.

    Positions and applied forces are read with noise.

    Each estimate is within four of its standard errors. Tracking is bad, so the motion has
    harmonics that were not asked for. Without ``held`` forces and accelerations are a millisecond
    apart.
    """
    real = psp3.load(
        "psp3",
        parameters=replace(psp3.Parameters(), star_mass=3.0, star_inertia=(0.08, 0.08, 0.15)),
    )
    run = psp3.simulate(
        real,
        psp3.ComputedTorque(base.unknowns.robot, kp=400.0, kv=40.0),
        motion,
        duration=2.0 * PERIOD,
    )
    # The second period, in which the start is forgotten; every 20th sample.
    part = slice(int(PERIOD / 0.002), int(2.0 * PERIOD / 0.002), 20)
    rng = np.random.default_rng(3)
    positions = run.positions[part] + 1e-5 * rng.normal(size=(100, 3))
    forces = run.torque[part] + 0.2 * rng.normal(size=(100, 3))
    found = identify(base, run.t[part], positions, forces, PERIOD, harmonics=8, held=0.002)
    truth = np.array([7.175 + 3.0 * 0.357, 3.0, 0.08, 0.08, 0.15])
    assert (np.abs(found.values - truth) < 4.0 * found.standard_errors).all()
    assert (found.standard_errors / truth < 0.5).all()
    assert found.standard_errors[1] / 3.0 < 0.02


def test_held_forces_belong_to_the_middle(base: BaseParameters, motion: FourierSeries) -> None:
    """Forces of half a period later, without noise, are explained with ``held`` and not without."""
    t, held = TIMES, 0.02
    forces = base.unknowns.robot.inverse_dynamics(*motion.joints(t + 0.5 * held))
    right = identify(base, t, motion.joints(t)[0], forces, PERIOD, HARMONICS, held=held)
    with pytest.warns(CorrelatedResiduals):
        wrong = identify(base, t, motion.joints(t)[0], forces, PERIOD, HARMONICS)
    np.testing.assert_allclose(right.values, base.believed, rtol=1e-9)
    assert np.abs(wrong.values / base.believed - 1.0).max() > 1e-3


def test_a_five_bar_is_identified_in_full() -> None:
    """Another robot, all eleven combinations, both noises.

    Each within four standard errors, and bodies that can exist.
    """
    robot = psp3.load("five_bar")
    base = base_parameters(all_parameters(robot))
    motion = exciting_motion(
        base,
        3.0,
        20.0,
        [-1.2, 0.0],
        [0.0, 1.2],
        period=PERIOD,
        harmonics=HARMONICS,
        draws=5,
        steps=3,
    )
    t = np.arange(80) * PERIOD / 80
    found = measured(base, motion, t, 1e-4, np.full(2, 0.01), 4)
    assert (np.abs(found.values - base.believed) < 4.0 * found.standard_errors).all()
    np.testing.assert_allclose(base.values(found.unknowns), found.values, atol=1e-12)
    assert [body.joint for body in found.bodies] == list(robot.model.names)[1:]


def test_bodies_that_cannot_exist_are_reported(base: BaseParameters, motion: FourierSeries) -> None:
    """Forces of a star of negative mass.

    The estimate is right about them, and says what is wrong.
    """
    columns, _ = base.forces_of(*motion.joints(TIMES))
    values = base.believed.copy()
    values[1] = -1.0
    _, known = base.forces_of(*motion.joints(TIMES))
    found = identify(
        base, TIMES, motion.joints(TIMES)[0], columns @ values + known, PERIOD, HARMONICS
    )
    flaws = {body.joint: body.flaws for body in found.bodies}
    assert "negative mass" in flaws["b1"]
    assert flaws["phi1"] == ()
    # The printed nut cannot exist either, and no force can tell.
    assert flaws["a1"] == ("a moment of inertia greater than the sum of the other two",)


def test_a_motion_that_tells_too_little_is_refused(base: BaseParameters) -> None:
    """All nuts together, without tilt: three rows say the same of five parameters."""
    t = TIMES
    lift = FourierSeries(np.zeros(3), [[0.05] * 3], [[0.0] * 3], PERIOD, base.unknowns.robot)
    joints = lift.joints(t)
    with pytest.raises(PoorExcitation, match="of 5"):
        identify(base, t, joints[0], base.unknowns.robot.inverse_dynamics(*joints), PERIOD, 1)


@pytest.mark.parametrize(
    ("change", "error"),
    [
        ({"t": np.arange(29.0)}, InvalidArray),
        ({"t": np.full(30, np.inf)}, InvalidArray),
        ({"positions": np.zeros((30, 2))}, InvalidArray),
        ({"positions": np.full((30, 3), np.nan)}, InvalidArray),
        ({"forces": np.zeros((29, 3))}, InvalidArray),
        ({"forces": np.full((30, 3), np.nan)}, InvalidArray),
        ({"forces": "text"}, InvalidArray),
        ({"period": 0.0}, InvalidValue),
        ({"harmonics": -1}, InvalidValue),
        ({"held": -0.1}, InvalidValue),
        ({"harmonics": 15}, PoorExcitation),
    ],
)
def test_bad_measurements_are_refused(
    base: BaseParameters, change: dict[str, object], error: type[Exception]
) -> None:
    arguments: dict[str, object] = {
        "t": TIMES,
        "positions": np.zeros((30, 3)),
        "forces": np.zeros((30, 3)),
        "period": PERIOD,
    }
    with pytest.raises(error):
        identify(base, **(arguments | change))  # type: ignore[arg-type]
