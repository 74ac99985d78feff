"""Tubes: of masses whose disturbances are known, and of robots whose controllers are wrong."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import psp3
from psp3.bounds.conformal import rank_of_bound, scores_needed
from psp3.bounds.tracking_tube import residual_accelerations, runs_needed
from psp3.errors import InvalidValue
from psp3.trajectories.motion import Motion

from .synthetic import KP, KV, PERIOD, constant, disturbed

ACCELERATIONS = arrays(np.float64, (40, 4, 2), elements=st.floats(-3.0, 3.0, width=32))
STARTS = st.tuples(st.floats(-0.1, 0.1), st.floats(-1.0, 1.0))
RUNS = runs_needed(0.9)


def tube_of(bounds: np.ndarray) -> psp3.TrackingTube:
    """Return a tube whose residual bounds are given: all its runs are disturbed by just these."""
    return psp3.TrackingTube([constant(bounds)] * RUNS, KP, KV, share=0.9)


# Residual accelerations


@given(disturbances=ACCELERATIONS, start=STARTS)
def test_residuals_are_no_more_than_what_disturbed(
    disturbances: np.ndarray, start: tuple[float, float]
) -> None:
    """And where the disturbance is constant in a period they are it.

    1e-9 is rounding of positions over h², of 1e-4.
    """
    run = disturbed(disturbances, start)
    found = residual_accelerations(run, KP, KV)
    assert (found <= np.abs(disturbances).max(axis=1) + 1e-9).all()
    held = np.repeat(disturbances[:, :1], 4, axis=1)
    found = residual_accelerations(disturbed(held, start), KP, KV)
    np.testing.assert_allclose(found, np.abs(held[:, 0]), atol=1e-9)


def test_they_are_what_a_wrong_model_did_to_the_force() -> None:
    """Beside M^-1 (tau - inverse dynamics of the servo acceleration) at the samples.

    That is known where a model is, and leaves out what changes within a period: half the period,
    half the difference.
    """
    robot = psp3.load("psp3")
    believed = psp3.load("psp3", parameters=psp3.Parameters(star_mass=6.0))
    path = psp3.trajectories.Helix(radius=0.020, period=2.0, rise=0.010, robot=robot)
    differences = []
    for period in (0.004, 0.002):
        run = psp3.simulate(
            robot, psp3.ComputedTorque(believed, KP, KV), path, duration=1.0, period=period
        )
        h, v, wanted = run.positions, run.speeds, run.desired
        servo = wanted.accelerations + KV * (wanted.speeds - v) + KP * (wanted.positions - h)
        left = run.torque - robot.inverse_dynamics(h, v, servo)
        expected = np.linalg.solve(robot.mass_matrix(h), left[..., np.newaxis])[..., 0]
        found = residual_accelerations(run, KP, KV)
        differences.append(np.abs(found - np.abs(expected[:-1])).max())
        assert np.abs(expected).max() > 1.0
    assert differences[0] < 0.1
    assert differences[0] / differences[1] == pytest.approx(2.0, rel=0.2)


def test_only_coordinates_that_are_commanded_are_asked() -> None:
    run = constant(np.array([0.5]))
    wider = replace(
        run,
        positions=np.hstack([run.positions, np.ones_like(run.positions)]),
        speeds=np.hstack([run.speeds, np.ones_like(run.speeds)]),
    )
    np.testing.assert_array_equal(
        residual_accelerations(wider, KP, KV), residual_accelerations(run, KP, KV)
    )


# The tube


@given(disturbances=ACCELERATIONS, start=STARTS)
def test_who_keeps_the_bounds_keeps_the_tube(
    disturbances: np.ndarray, start: tuple[float, float]
) -> None:
    """The least bounds, and nothing to spare: the run itself made them."""
    run = disturbed(disturbances, start)
    greatest = np.maximum(residual_accelerations(run, KP, KV).max(axis=0), 1e-3)
    # Proportions below a thousandth are not kept, which makes a tube wider.
    assert tube_of(greatest).holds(run)


def test_a_constant_disturbance_reaches_the_edge_of_the_tube() -> None:
    """At damping ratios of 1 and more it is the worst one there is, and 1 / kp is the width."""
    bounds = np.array([0.5, 0.2])
    tube = tube_of(bounds)
    np.testing.assert_allclose(tube.residual, bounds, rtol=1e-9)
    np.testing.assert_allclose(tube.width, bounds / KP, rtol=1e-9)
    run = constant(bounds, periods=400)
    np.testing.assert_allclose(tube.around(run), np.abs(run.positions), rtol=2e-9, atol=1e-15)
    assert tube.holds(run)
    assert not tube.holds(constant(1.001 * bounds, periods=400))
    assert not tube.holds(constant(bounds * [1.0, 1.001], periods=400))


def test_errors_at_the_start_die_out_within_the_tube() -> None:
    run = disturbed(np.zeros((400, 1, 2)), start=(0.1, -0.4))
    tube = tube_of(np.array([1e-3, 1e-3]))
    around = tube.around(run)
    assert tube.holds(run)
    np.testing.assert_allclose(around[0], [0.1, 0.1], rtol=1e-8)
    np.testing.assert_allclose(around[-1], tube.width, rtol=1e-3)


def test_of_exchangeable_runs_as_many_keep_the_tube_as_the_rank_says() -> None:
    """Each run is the new one once, for an order of the others drawn anew.

    With one coordinate and constant disturbances a run keeps the tube just where its disturbance is
    no more than the bound, so that the count is that of the conformal rank: the first tenth, of
    which proportions are taken, has none of one coordinate. Runs that calibrate are drawn among the
    others, so that the count is a mean: 300 draws, within four standard errors.
    """
    source = np.random.default_rng(1)
    sizes = source.lognormal(0.0, 1.0, RUNS + 1)
    runs = [constant(np.array([size])) for size in sizes]
    kept = []
    for _ in range(300):
        new, *others = source.permutation(RUNS + 1)
        tube = psp3.TrackingTube([runs[i] for i in others], KP, KV, share=0.9)
        kept.append(tube.holds(runs[new]))
    calibrating = RUNS - -(-RUNS // 10)
    expected = rank_of_bound(calibrating, 0.9) / (calibrating + 1)
    assert expected >= 0.9
    assert abs(np.mean(kept) - expected) < 4.0 * np.sqrt(expected * (1.0 - expected) / 300)


def test_coordinates_have_bounds_of_their_own() -> None:
    """Radians and meters in one robot: proportions come from runs, and the factor is one."""
    source = np.random.default_rng(0)
    runs = [constant(np.array([5.0, 0.01]) * source.uniform(0.5, 1.0, 2)) for _ in range(60)]
    tube = psp3.TrackingTube(runs, KP, KV, share=0.9)
    assert 300.0 < tube.residual[0] / tube.residual[1] < 800.0
    still = psp3.TrackingTube([constant(np.array([5.0, 0.0]))] * RUNS, KP, KV, share=0.9)
    assert still.residual[1] == pytest.approx(1e-3 * still.residual[0])


def test_runs_that_end_early_need_a_share_of_their_own() -> None:
    runs: list[psp3.Result | None] = [constant(np.array([size])) for size in range(1, 61)]
    whole = psp3.TrackingTube(runs, KP, KV, share=0.9)
    # 6 of 60 give proportions; of 54 the 50th bounds, so that four may fail.
    assert whole.residual[0] == pytest.approx(56.0)
    runs[10:14] = [None] * 4
    assert psp3.TrackingTube(runs, KP, KV, share=0.9).residual[0] == pytest.approx(60.0)
    runs[14] = None
    with pytest.raises(InvalidValue, match="5 of 60 that did not reach their end"):
        psp3.TrackingTube(runs, KP, KV, share=0.9)
    with pytest.raises(InvalidValue, match="one of the first tenth reached its end"):
        psp3.TrackingTube([None] * 30, KP, KV, share=0.9)


@pytest.mark.parametrize("share", [0.5, 0.9, 0.95, 0.99])
def test_too_few_runs_are_refused_with_their_number(share: float) -> None:
    needed, run = runs_needed(share), constant(np.array([1.0]), periods=2)
    psp3.TrackingTube([run] * needed, KP, KV, share)
    with pytest.raises(InvalidValue, match=f"at least {needed} of them for a share of {share:g}"):
        psp3.TrackingTube([run] * (needed - 1), KP, KV, share)


@pytest.mark.parametrize("share", [1e-6, 0.5, 0.9, 0.95, 0.987, 0.999, 1.0 - 1e-12])
def test_no_fewer_runs_would_do_without_those_for_proportions(share: float) -> None:
    needed, scores = runs_needed(share), scores_needed(share)
    assert needed - -(-needed // 10) >= scores
    assert needed - 1 - -(-(needed - 1) // 10) < scores


def test_orders_of_runs_keep_the_tube_as_often_as_they_should() -> None:
    """Brute force over all orders of eight runs, of two coordinates, with ties and failures.

    One of seven calibration runs is for proportions, so that the new run and six others are
    exchangeable whatever that one is: of all orders at least a share 2/3 keep the tube. Where a
    tube is refused nothing is promised, and the order counts as kept: the bound is infinite there.
    """
    sizes = [(1, 3), (1, 3), (2, 1), (3, 3), (2, 1), (4, 1), None, (1, 1)]
    share, kept, refused, failed = 2.0 / 3.0, [], 0, 0
    runs = [None if size is None else constant(np.array(size, dtype=float), 2) for size in sizes]
    # The order within the six does not matter, nor does that of what is equal in them.
    for new, first in itertools.permutations(range(len(runs)), 2):
        rest = [i for i in range(len(runs)) if i not in (new, first)]
        try:
            tube = psp3.TrackingTube([runs[i] for i in (first, *rest)], KP, KV, share)
        except InvalidValue:
            refused += 1
            kept.append(True)
            continue
        run = runs[new]
        failed += run is None
        kept.append(run is not None and tube.holds(run))
    assert refused == 7
    assert failed == 7
    assert np.mean(kept) >= share
    assert not np.all(kept)


def test_runs_that_are_not_finite_are_refused_wherever_they_stand() -> None:
    """One among those for proportions was passed over without a word."""
    run = constant(np.array([1.0]))
    for name, bad in itertools.product(("positions", "speeds"), (np.nan, np.inf)):
        rows = getattr(run, name).copy()
        rows[7] = bad
        broken = replace(run, **{name: rows})
        for where in (0, RUNS):
            runs = [run] * RUNS
            runs.insert(where, broken)
            with pytest.raises(InvalidValue, match=f"{name} that are not finite"):
                psp3.TrackingTube(runs, KP, KV, share=0.9)
        tube = tube_of(np.array([1.0]))
        for asked in (tube.holds, tube.around, lambda run: residual_accelerations(run, KP, KV)):
            with pytest.raises(InvalidValue, match="takes None for it"):
                asked(broken)


def test_runs_of_other_periods_or_coordinates_are_refused() -> None:
    run, other = constant(np.array([1.0])), constant(np.array([1.0, 1.0]))
    slower = disturbed(np.zeros((10, 1, 1)), period=0.02)
    tube = tube_of(np.array([1.0]))
    for wrong, match in ((slower, "a period of 0.02 s"), (other, "2 coordinates")):
        with pytest.raises(InvalidValue, match=match):
            psp3.TrackingTube([run] * RUNS + [wrong], KP, KV, share=0.9)
        with pytest.raises(InvalidValue, match=match):
            tube.holds(wrong)
    longer = disturbed(np.zeros((len(run.t) + 4, 1, 1)), period=PERIOD)
    with pytest.raises(InvalidValue, match="of one duration; give None"):
        psp3.TrackingTube([run] * RUNS + [longer], KP, KV, share=0.9)
    uneven = run.t.copy()
    uneven[3] += 1e-4
    one = Motion(*(array[:1] for array in run.desired))
    short = replace(
        run, t=run.t[:1], positions=run.positions[:1], speeds=run.speeds[:1], desired=one
    )
    for wrong, match in ((replace(run, t=uneven), "even"), (short, "two samples")):
        with pytest.raises(InvalidValue, match=match):
            residual_accelerations(wrong, KP, KV)


@pytest.mark.parametrize("wrong", [3, "run", object()])
def test_what_is_no_run_is_refused(wrong: Any) -> None:
    run = constant(np.array([1.0]))
    tube = tube_of(np.array([1.0]))
    for call in (
        lambda: psp3.TrackingTube([run] * RUNS + [wrong], KP, KV, share=0.9),
        lambda: tube.holds(wrong),
        lambda: tube.around(wrong),
        lambda: residual_accelerations(wrong, KP, KV),
    ):
        with pytest.raises(InvalidValue, match="result must be a run as psp3"):
            call()
    with pytest.raises(InvalidValue, match="result must be a run"):
        tube.holds(None)  # type: ignore[arg-type]
    with pytest.raises(InvalidValue, match="robot must be a robot"):
        tube.tip_width(wrong, [0.0])
    with pytest.raises(InvalidValue, match=r"runs must be a list of runs, .* got 'Result'"):
        psp3.TrackingTube(run, KP, KV)  # type: ignore[arg-type]


def test_other_gains_keep_the_residual_and_lose_the_guarantee() -> None:
    tube = tube_of(np.array([0.4]))
    stiff = tube.with_gains(400.0, 40.0)
    assert tube.is_guaranteed
    assert not stiff.is_guaranteed
    np.testing.assert_allclose(stiff.width, tube.width / 4.0, rtol=1e-9)
    soft = tube.with_gains(100.0, 5.0)
    assert soft.width[0] > tube.width[0]
    assert soft.holds(disturbed(np.full((200, 1, 1), 0.4), kp=100.0, kv=5.0))
    with pytest.raises(InvalidValue, match="period must be below"):
        tube.with_gains(100.0, 3.0 / PERIOD)
    assert repr(tube) == (
        "TrackingTube(kp=100, kv=20, period=0.01 s, 90 % of runs by 10, residual=[0.4], "
        "width=[0.004])"
    )
    assert "gains of no calibration run" in repr(stiff)


# The tip


@pytest.mark.parametrize("name", ["psp3", "five_bar", "delta"])
def test_the_tip_is_no_farther_than_first_order_says(name: str) -> None:
    """A thousand poses of the tube, corners among them.

    What exceeds the bound is of second order: as a share of a tenth of the width it is a tenth. The
    corners reach the bound but for that.
    """
    robot = psp3.load(name)
    path = (
        robot.reference
        + np.random.default_rng(0).uniform(-0.02, 0.02, (5, 3))[:, : len(robot.reference)]
    )
    source = np.random.default_rng(1)
    k = len(robot.reference)
    places = source.uniform(-1.0, 1.0, (1000, 5, k))
    places[:500] = np.sign(places[:500])
    excess = []
    for width in (5e-3, 5e-4):
        bound = tube_of(np.full(k, width * KP)).tip_width(robot, path)
        far = np.linalg.norm(robot.tip(path + width * places) - robot.tip(path), axis=-1)
        assert bound.shape == (5,)
        assert (far.max(axis=0) > 0.9 * bound).all()
        excess.append(float((far.max(axis=0) / bound).max()) - 1.0)
    assert excess[0] < 0.02
    assert excess[1] < max(0.2 * excess[0], 1e-12)


def test_robots_without_a_tip_or_of_other_coordinates_are_refused() -> None:
    tube = tube_of(np.array([0.1, 0.1]))
    robot = psp3.load("psp3")
    with pytest.raises(InvalidValue, match="one of 2 coordinates"):
        tube.tip_width(robot, np.zeros((3, 2)))


# Robots


@pytest.mark.slow
@pytest.mark.parametrize("name", ["five_bar", "delta"])
def test_runs_of_a_robot_whose_masses_are_not_believed_keep_the_tube(name: str) -> None:
    """Payloads that no model knows, drawn for each run, and encoders that count.

    Of 30 new runs at least 26 keep a tube that 90 % keep: fewer have a probability below 5 % if it
    were just that, and the tube is wider than needed.
    """
    robot = psp3.load(name)
    path = psp3.trajectories.Sway(0.1, 1.0, robot)
    start = path(np.array([0.0]))
    source = np.random.default_rng(2)
    runs = [
        psp3.simulate(
            robot,
            psp3.ComputedTorque(psp3.with_payload(robot, float(mass)), KP, KV),
            path,
            duration=1.0,
            period=0.005,
            initial_positions=start.positions[0],
            initial_speeds=start.speeds[0],
            encoder_resolution=1e-5,
        )
        for mass in source.uniform(0.0, 0.05, 60)
    ]
    tube = psp3.TrackingTube(runs[:30], KP, KV, share=0.9)
    assert sum(tube.holds(run) for run in runs[30:]) >= 26
    worst = max(np.abs(run.desired.positions - run.positions).max() for run in runs[30:])
    assert tube.width.max() < 1.5 * worst
