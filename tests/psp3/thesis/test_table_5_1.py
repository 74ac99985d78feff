"""What printed matrices imply: intervals against brute force, and the findings about Table 5.1."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import psp3
from psp3 import published
from psp3.errors import InvalidArray, InvalidValue
from psp3.identification.base_parameters import BaseParameters, base_parameters
from psp3.identification.unknowns import all_parameters
from psp3.thesis.table_3_1 import numbers_of_table_3_1
from psp3.thesis.table_5_1 import ROUNDING_OF_TABLE_5_1, Implied, implied_parameters
from psp3.three_psp.robot import PSP3
from tests.helpers import Array

BALLS = ["ball_axial_inertia", "ball_transverse_inertia"]


@pytest.fixture(scope="module")
def robot() -> PSP3:
    return psp3.load("psp3", parameters="table_5_1")


@pytest.fixture(scope="module")
def whole(robot: PSP3) -> Implied:
    return implied_parameters(base_parameters(numbers_of_table_3_1(robot)))


@pytest.fixture(scope="module")
def determined(robot: PSP3) -> Implied:
    """With nuts and ball joints as Table 3.1 prints them.

    Four numbers and g are left, and a number of ball mass.
    """
    return implied_parameters(
        base_parameters(numbers_of_table_3_1(robot).without(["nut_mass", *BALLS]))
    )


def with_numbers(base: BaseParameters, values: Array, gravity: float) -> PSP3:
    found = dict(zip(base.unknowns.names, base.nearest(values), strict=True))
    parameters = psp3.PARAMETER_SETS["table_5_1"]
    moments = ("star_inertia_x", "star_inertia_y", "star_inertia_z")
    change = {
        name: value
        for name, value in found.items()
        if not name.startswith(("star_inertia", "nut_inertia"))
    }
    return psp3.load(
        "psp3",
        parameters=replace(
            parameters,
            **change,
            star_inertia=tuple(found[name] for name in moments),
            gravity=gravity,
        ),
    )


def errors(robot: PSP3) -> tuple[float, float]:
    """Largest errors of M and G of Table 5.1, by the closed form."""
    pose = published.TABLE_5_1_HEIGHTS[1]
    mass, gravity = robot.mass_matrix(pose), robot.gravity(pose)
    return float(np.abs(mass - published.TABLE_5_1_MASS).max()), float(
        np.abs(gravity - published.TABLE_5_1_GRAVITY).max()
    )


def accelerations(mass: Array) -> tuple[Array, Array]:
    """Return the least and greatest g by which mass matrices (N, 3, 3) fit.

    They print the gravity vector of Table 5.1, G = g M 1.
    """
    sums = mass.sum(axis=2)
    low, high = (
        (published.TABLE_5_1_GRAVITY + sign * ROUNDING_OF_TABLE_5_1) / sums for sign in (-1.0, 1.0)
    )
    return low.max(axis=1), high.min(axis=1)


def test_table_5_1_is_explained_to_its_last_digit(whole: Implied, determined: Implied) -> None:
    """Its nine numbers of M and G are those of a rigid 3-PSP to 0.13 of half a unit.

    7 base parameters, of which 5 combinations show.
    """
    assert whole.misfit == pytest.approx(0.128, abs=5e-4)
    assert len(whole.base.columns) == 7
    assert whole.rank == 5
    assert determined.rank == len(determined.base.columns) == 5


def test_the_nearest_parameters_reproduce_the_print(whole: Implied, determined: Implied) -> None:
    """By the closed form, which is no part of the fit.

    All nine numbers to half a unit, with 1 % for the solver's tolerance.
    """
    for found in (whole, determined):
        mass = with_numbers(found.base, found.nearest, 9.806).mass_matrix(
            published.TABLE_5_1_HEIGHTS[1]
        )
        low, high = accelerations(mass[np.newaxis])
        assert found.gravity[0] - 1e-7 <= low[0] <= high[0] + 1e-7 <= found.gravity[1] + 2e-7
        assert (
            max(errors(with_numbers(found.base, found.nearest, 0.5 * (low[0] + high[0]))))
            <= 1.01 * ROUNDING_OF_TABLE_5_1
        )
    assert errors(psp3.load("psp3", parameters="table_5_1"))[0] > 100 * ROUNDING_OF_TABLE_5_1


def test_what_the_print_says_about_the_masses(whole: Implied, determined: Implied) -> None:
    """Total mass and g by hand from the sums of the print.

    The ball's mass and the star's begin with the digits of Table 3.1.
    """
    total = whole.interval([3.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    printed = published.TABLE_5_1_MASS.sum()
    assert total[0] < printed < total[1]
    assert total[1] - total[0] < 2 * 9 * ROUNDING_OF_TABLE_5_1
    low, high = whole.gravity
    assert low < published.TABLE_5_1_GRAVITY.sum() / printed < high
    assert (round(low, 4), round(high, 4)) == (9.8059, 9.8062)
    intervals = {
        name: determined.interval(row)
        for name, row in zip(determined.base.names, np.eye(5), strict=True)
    }
    np.testing.assert_allclose(intervals["ball_mass"], (0.35744, 0.35755), atol=1e-5)
    np.testing.assert_allclose(intervals["star_mass"], (1.75867, 1.75896), atol=1e-5)
    np.testing.assert_allclose(intervals["star_inertia_x"], (0.064275, 0.064298), atol=1e-6)
    np.testing.assert_allclose(intervals["star_inertia_y"], (0.128256, 0.128279), atol=1e-6)
    assert intervals["star_inertia_z"][0] < 0.06451 < intervals["star_inertia_z"][1]


def test_one_pose_cannot_tell_the_ball_joints_from_the_star(whole: Implied) -> None:
    """By the closed form: along the null space M stays, to 1e-12 of 10 kg.

    Off it, it does not.
    """
    base, pose = whole.base, published.TABLE_5_1_HEIGHTS[1]
    assert whole.null_space.shape == (7, 2)
    before = with_numbers(base, base.believed, 9.806).mass_matrix(pose)
    for change in whole.null_space.T:
        other = with_numbers(base, base.believed * (1.0 + 0.1 * change), 9.806)
        np.testing.assert_allclose(other.mass_matrix(pose), before, atol=1e-11)
        # At another pose it shows.
        elsewhere = [0.0, 0.2, 0.1]
        first = with_numbers(base, base.believed, 9.806)
        assert np.abs(other.mass_matrix(elsewhere) - first.mass_matrix(elsewhere)).max() > 1e-7
    for name, row in zip(base.names, np.eye(7), strict=True):
        low, high = whole.interval(row)
        assert (low == -np.inf and high == np.inf) == (
            name in (*BALLS, "star_inertia_x", "star_inertia_y", "star_inertia_z")
        )


def test_intervals_hold_all_that_explains_the_print(determined: Implied) -> None:
    """Brute force: of 400 000 random robots the fitting ones lie in the intervals.

    They reach over most of the intervals. Fitting are those whose M and G print as they should.
    """
    base, rng = determined.base, np.random.default_rng(0)
    pose = published.TABLE_5_1_HEIGHTS[1]
    intervals = np.array([determined.interval(row) for row in np.eye(5)])
    middle, half = intervals.mean(axis=1), 0.5 * np.ptp(intervals, axis=1)
    drawn = middle + half * rng.uniform(-1.3, 1.3, size=(400_000, 5))
    # M is linear in the numbers, so six robots by the closed form give all.
    first = with_numbers(base, middle, 9.806).mass_matrix(pose)
    slopes = np.array(
        [
            with_numbers(base, middle + unit * half, 9.806).mass_matrix(pose) - first
            for unit in np.eye(5)
        ]
    )
    mass = first + np.einsum("sk,kij->sij", (drawn - middle) / half, slopes)
    low, high = accelerations(mass)
    good = (np.abs(mass - published.TABLE_5_1_MASS).max(axis=(1, 2)) <= ROUNDING_OF_TABLE_5_1) & (
        low <= high
    )
    assert np.count_nonzero(good) > 100
    # 1 % of the half width is more than what the second order of 1/g and the solver's tolerance
    # leave out.
    assert (np.abs(drawn[good] - middle) <= 1.01 * half).all()
    assert (np.ptp(drawn[good], axis=0) > 0.5 * np.ptp(intervals, axis=1)).all()


def test_a_symmetric_star_explains_nothing(robot: PSP3) -> None:
    """M11 is not M33 though a1 = a3.

    With equal moments in its plane the star misses half their difference, 0.269 kg, whatever they
    are.
    """
    unknowns = numbers_of_table_3_1(robot)
    x, y = unknowns.names.index("star_inertia_x"), unknowns.names.index("star_inertia_y")
    expansion = unknowns.expansion.copy()
    expansion[:, x] += expansion[:, y]
    keep = [j for j in range(len(unknowns.names)) if j != y]
    symmetric = replace(
        unknowns,
        names=tuple(unknowns.names[j] for j in keep),
        expansion=expansion[:, keep],
        believed=unknowns.believed[keep],
    )
    found = implied_parameters(base_parameters(symmetric))
    mass = published.TABLE_5_1_MASS
    assert found.misfit * ROUNDING_OF_TABLE_5_1 == pytest.approx(
        0.5 * (mass[0, 0] - mass[2, 2]), rel=1e-3
    )
    assert np.isnan(found.nearest).all()
    assert np.isnan(found.interval(np.eye(6)[0])).all()
    assert np.isnan(found.gravity).all()


def test_another_robot_and_its_own_matrices() -> None:
    """A five-bar: its matrices, rounded, are explained, by what is believed above all.

    Intervals hold the truth, g's too.
    """
    robot = psp3.load("five_bar")
    unknowns = all_parameters(robot)
    base = base_parameters(unknowns)
    shown = [
        name
        for name, value in zip(base.unknowns.names, unknowns.believed, strict=True)
        if value == 0.0
    ]
    base = base_parameters(unknowns.without(shown))
    pose = np.array([-0.4, 0.7])
    mass, gravity = np.round(robot.mass_matrix(pose), 4), np.round(robot.gravity(pose), 4)
    found = implied_parameters(base, pose, mass, gravity)
    assert found.misfit <= 1.0
    assert found.rank < len(base.columns)
    combination = np.random.default_rng(0).normal(size=len(base.columns))
    low, high = found.interval(combination)
    assert low <= combination @ base.believed <= high


@pytest.mark.parametrize(
    ("change", "error"),
    [
        ({"positions": np.zeros(2)}, InvalidArray),
        ({"mass": np.eye(2)}, InvalidArray),
        ({"mass": np.arange(9.0).reshape(3, 3)}, InvalidArray),
        ({"mass": np.full((3, 3), np.nan)}, InvalidArray),
        ({"mass": "text"}, InvalidArray),
        ({"gravity": np.full(3, np.inf)}, InvalidArray),
        ({"rounding": 0.0}, InvalidValue),
    ],
)
def test_bad_input_is_refused(
    whole: Implied, change: dict[str, object], error: type[Exception]
) -> None:
    with pytest.raises(error):
        implied_parameters(whole.base, **change)  # type: ignore[arg-type]
    with pytest.raises(InvalidArray):
        whole.interval(np.zeros(6))


def test_what_is_believed_to_be_zero_or_weightless_is_refused() -> None:
    base = base_parameters(all_parameters(psp3.load("planar_3rrr")))
    with pytest.raises(InvalidValue, match="not zero in the robot's model"):
        implied_parameters(base, np.full(3, 0.9), np.eye(3), np.ones(3))
    floating = psp3.load("psp3", parameters=psp3.Parameters(gravity=0.0))
    with pytest.raises(InvalidValue, match="gravity of the model"):
        implied_parameters(base_parameters(numbers_of_table_3_1(floating).without(["star_mass"])))
