"""Which standard parameters a body can have.

Against clouds of mass points, which can exist, and by their definition.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import psp3
from psp3.errors import InvalidArray
from psp3.identification.physical_consistency import bodies, pseudo_inertia
from psp3.identification.regressor import standard_parameters
from tests.helpers import Array

ROBOT = psp3.load("five_bar")


def cloud(masses: Array, points: Array) -> Array:
    """Return the ten parameters of mass points (k,) at (k, 3), by their sums."""
    xx, yy, zz = (masses * points.T**2).sum(axis=1)
    x, y, z = points.T
    xy, xz, yz = (-(masses * first * second).sum() for first, second in ((x, y), (x, z), (y, z)))
    return np.array([masses.sum(), *(masses @ points), yy + zz, xy, xx + zz, xz, yz, xx + yy])


def flaws_of(parameters: Array) -> tuple[str, ...]:
    whole = standard_parameters(ROBOT)
    whole[:10] = parameters
    return bodies(ROBOT, whole)[0].flaws


@settings(max_examples=100, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(1, 8))
def test_clouds_of_points_can_exist(seed: int, count: int) -> None:
    """Points, rods and plates are just possible, and rounding must not push them over.

    They are on the border of what can exist.
    """
    rng = np.random.default_rng(seed)
    parameters = cloud(rng.uniform(0.1, 5.0, count), rng.uniform(-1.0, 1.0, (count, 3)))
    assert flaws_of(parameters) == ()
    assert np.linalg.eigvalsh(pseudo_inertia(parameters)).min() > -1e-12


@settings(max_examples=200, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_flaws_are_what_the_pseudo_inertia_says(seed: int) -> None:
    """Two criteria by different routes.

    Principal moments about the center, and the eigenvalues of one matrix. Borderline cases aside.
    """
    rng = np.random.default_rng(seed)
    parameters = cloud(rng.uniform(0.1, 1.0, 6), rng.uniform(-1.0, 1.0, (6, 3))) + rng.normal(
        size=10
    ) * 10.0 ** rng.uniform(-3.0, 0.5)
    least = float(np.linalg.eigvalsh(pseudo_inertia(parameters)).min())
    if abs(least) > 1e-9 and abs(parameters[0]) > 1e-3:
        assert bool(flaws_of(parameters)) == (least < 0.0)


def test_a_body_is_described_about_its_center_of_mass() -> None:
    """A plate by the textbook: moments m/12 (b², a², a² + b²).

    Shifted by Steiner's theorem and found again. 1e-14 is rounding.
    """
    mass, a, b, center = 3.0, 0.4, 0.2, np.array([0.3, -0.1, 0.5])
    about_center = mass / 12.0 * np.array([b * b, a * a, a * a + b * b])
    inertia = np.diag(about_center) + mass * (
        center @ center * np.eye(3) - np.outer(center, center)
    )
    parameters = np.array(
        [
            mass,
            *(mass * center),
            inertia[0, 0],
            inertia[0, 1],
            inertia[1, 1],
            inertia[0, 2],
            inertia[1, 2],
            inertia[2, 2],
        ]
    )
    whole = np.concatenate([parameters, standard_parameters(ROBOT)[10:]])
    body = bodies(ROBOT, whole)[0]
    assert body.physical
    assert body.joint == "leg1_shoulder"
    assert body.mass == mass
    np.testing.assert_allclose(body.center, center, atol=1e-14)
    np.testing.assert_allclose(body.moments, about_center, atol=1e-14)


@pytest.mark.parametrize(
    ("parameters", "flaw"),
    [
        ([-1.0, 0, 0, 0, 1, 0, 1, 0, 0, 1], "negative mass"),
        ([1.0, 0, 0, 0, -0.1, 0, 1, 0, 0, 1], "negative moment of inertia"),
        (
            [7.175, 0, 0, 0, 0.003, 0, 0.39, 0, 0, 0.3294],
            "a moment of inertia greater than the sum of the other two",
        ),
        # All is well about the joint, but not about the center of mass.
        ([1.0, 2.0, 0, 0, 1, 0, 1, 0, 0, 1], "negative moment of inertia"),
        ([0.0, 0.1, 0, 0, 0, 0, 0, 0, 0, 0], "no mass, but moments"),
    ],
)
def test_flaws_are_named(parameters: list[float], flaw: str) -> None:
    """The third is the nut of Table 3.1."""
    assert flaw in flaws_of(np.array(parameters))


def test_nothing_at_all_is_a_body() -> None:
    assert flaws_of(np.zeros(10)) == ()


@pytest.mark.parametrize("name", ["five_bar", "planar_3rrr", "delta", "gough_stewart", "tricept"])
def test_shipped_robots_can_exist(name: str) -> None:
    robot = psp3.load(name)
    assert all(body.physical for body in bodies(robot, standard_parameters(robot)))


def test_only_the_nuts_of_the_3_psp_cannot() -> None:
    robot = psp3.load("psp3")
    assert [
        body.joint for body in bodies(robot, standard_parameters(robot)) if not body.physical
    ] == ["a1", "a2", "a3"]


@pytest.mark.parametrize("bad", [np.zeros(39), np.full(40, np.nan), "text"])
def test_bad_input_is_refused(bad: object) -> None:
    with pytest.raises(InvalidArray):
        bodies(ROBOT, bad)  # type: ignore[arg-type]
