"""Exciting motions.

Within the limits at all times, more telling than chance, the same for the same seed.
"""

from __future__ import annotations

import numpy as np
import pytest

import psp3
from psp3.errors import InvalidArray, InvalidValue
from psp3.identification.base_parameters import BaseParameters, base_parameters
from psp3.identification.excitation import exciting_motion, information
from psp3.identification.unknowns import all_parameters
from psp3.thesis.table_3_1 import numbers_of_table_3_1
from psp3.trajectories import Hold
from psp3.trajectories.fourier_series import FourierSeries

PERIOD, SPEED, ACCELERATION = 4.0, 1.0, 5.0
LOWER, UPPER = np.full(3, -0.1), np.array([0.1, 0.12, 0.08])


@pytest.fixture(scope="module")
def base() -> BaseParameters:
    return base_parameters(
        numbers_of_table_3_1(psp3.load("psp3")).without(
            ["ball_axial_inertia", "ball_transverse_inertia"]
        )
    )


@pytest.fixture(scope="module")
def motion(base: BaseParameters) -> FourierSeries:
    return exciting_motion(
        base, SPEED, ACCELERATION, LOWER, UPPER, period=PERIOD, harmonics=3, draws=10, steps=8
    )


def test_it_keeps_its_limits_at_all_times(motion: FourierSeries) -> None:
    """At 100 000 times, far between those that the search looks at; 1e-9 is rounding.

    Some limit is used up to 1 %.
    """
    t = np.linspace(0.0, PERIOD, 100_001)
    terms = motion(t)
    for joint in range(3):
        assert LOWER[joint] - 1e-9 <= terms.positions[:, joint].min()
        assert terms.positions[:, joint].max() <= UPPER[joint] + 1e-9
        assert np.abs(terms.speeds[:, joint]).max() <= SPEED + 1e-9
        assert np.abs(terms.accelerations[:, joint]).max() <= ACCELERATION + 1e-9
        used = [
            max(
                (terms.positions[:, joint].max() - motion.center[joint])
                / (UPPER[joint] - motion.center[joint]),
                (motion.center[joint] - terms.positions[:, joint].min())
                / (motion.center[joint] - LOWER[joint]),
            ),
            np.abs(terms.speeds[:, joint]).max() / SPEED,
            np.abs(terms.accelerations[:, joint]).max() / ACCELERATION,
        ]
        assert max(used) > 0.5


def test_it_tells_more_than_random_motions(base: BaseParameters, motion: FourierSeries) -> None:
    """Than all of 20 random series of full size in the same limits, drawn by another generator."""
    t = np.arange(50) * PERIOD / 50
    best, rng = information(base, motion, t).log_determinant, np.random.default_rng(5)
    for _ in range(20):
        sines, cosines = rng.normal(size=(2, 3, 3))
        fine = FourierSeries(np.zeros(3), sines, cosines, PERIOD).joints(
            np.linspace(0.0, PERIOD, 400)
        )
        size = [
            np.abs(part).max() / limit
            for part, limit in zip(fine, (0.08, SPEED, ACCELERATION), strict=True)
        ]
        shrunk = FourierSeries(
            np.zeros(3), sines / max(size), cosines / max(size), PERIOD, base.unknowns.robot
        )
        assert information(base, shrunk, t).log_determinant < best


@pytest.mark.slow
def test_improving_helps_and_a_seed_repeats(base: BaseParameters) -> None:
    t = np.arange(14) * PERIOD / 14

    def found(steps: int, seed: int) -> FourierSeries:
        rng = np.random.default_rng(seed)
        return exciting_motion(
            base,
            SPEED,
            ACCELERATION,
            LOWER,
            UPPER,
            period=PERIOD,
            harmonics=3,
            draws=2,
            steps=steps,
            rng=rng,
        )

    once, again, longer, other = found(1, 0), found(1, 0), found(8, 0), found(1, 1)
    np.testing.assert_array_equal(once.sines, again.sines)
    assert not np.array_equal(once.sines, other.sines)
    assert (
        information(base, longer, t).log_determinant
        > information(base, once, t).log_determinant + 0.5
    )


def test_information_is_that_of_the_definition(base: BaseParameters, motion: FourierSeries) -> None:
    """With the matrices written out, for forces of different noise.

    1e-9 after a condition of some 1e2.
    """
    t, noise = np.linspace(0.0, 3.0, 20), np.array([0.5, 1.0, 2.0])
    terms = motion(t)
    columns, _ = base.forces_of(*terms[:3])
    stacked = (columns / noise[:, None]).reshape(60, -1)
    found = information(base, motion, t, noise)
    assert found.log_determinant == pytest.approx(
        np.linalg.slogdet(stacked.T @ stacked)[1], abs=1e-9
    )
    assert found.condition == pytest.approx(
        np.linalg.cond(stacked / np.linalg.norm(stacked, axis=0)), rel=1e-9
    )


def test_a_robot_at_rest_tells_next_to_nothing(base: BaseParameters) -> None:
    found = information(
        base, Hold(np.zeros(3), base.unknowns.robot, "joints"), np.linspace(0.0, 1.0, 10)
    )
    assert found.log_determinant == -np.inf
    assert found.condition == np.inf


@pytest.mark.slow
def test_it_finds_its_way_where_most_of_the_range_is_unreachable() -> None:
    """The whole range of a five-bar's cranks, much of which does not close.

    The motion that comes out does.
    """
    robot = psp3.load("five_bar")
    base = base_parameters(all_parameters(robot))
    motion = exciting_motion(base, 4.0, 30.0, period=PERIOD, harmonics=3, draws=5, steps=2)
    terms = motion.check(np.linspace(0.0, PERIOD, 5000))
    assert np.ptp(terms.positions, axis=0).min() > 0.3
    assert information(base, motion, np.linspace(0.0, PERIOD, 60)).condition < 1e4


@pytest.mark.parametrize(
    ("change", "error"),
    [
        ({"largest_speed": 0.0}, InvalidValue),
        ({"largest_speed": [1.0, 1.0]}, InvalidValue),
        ({"largest_acceleration": np.nan}, InvalidValue),
        ({"largest_acceleration": [1.0, -1.0, 1.0]}, InvalidValue),
        ({"lower": [0.2, 0.0, 0.0]}, InvalidValue),
        ({"upper": [0.1, np.inf, 0.1]}, InvalidArray),
        ({"lower": np.zeros(2)}, InvalidArray),
        ({"period": 0.0}, InvalidValue),
        ({"harmonics": 0}, InvalidValue),
        ({"force_noise": 0.0}, InvalidValue),
        ({"force_noise": [1.0, 1.0]}, InvalidValue),
        ({"draws": 0}, InvalidValue),
        ({"steps": 0}, InvalidValue),
    ],
)
def test_bad_input_is_refused(
    base: BaseParameters, change: dict[str, object], error: type[Exception]
) -> None:
    arguments: dict[str, object] = {
        "largest_speed": 1.0,
        "largest_acceleration": 5.0,
        "lower": LOWER,
        "upper": UPPER,
    }
    with pytest.raises(error):
        exciting_motion(base, **(arguments | change))  # type: ignore[arg-type]


def test_a_joint_without_limits_needs_a_range() -> None:
    robot = psp3.load("five_bar")
    model = robot.model.copy()
    model.upperPositionLimit[robot.actuated_q] = np.inf
    free = psp3.ClosedLoopRobot(model, robot.constraint_models, robot.actuated, robot.q0)
    base = base_parameters(all_parameters(free))
    with pytest.raises(InvalidValue, match="finite"):
        exciting_motion(base, 1.0, 5.0)
