"""Base parameters.

How many there are and what moves together, against counts by hand, closed forms and other models.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import psp3
from psp3.errors import InvalidArray, UncertainRank
from psp3.identification.base_parameters import base_parameters, independent_columns
from psp3.identification.unknowns import all_parameters, equal_bodies
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from psp3.thesis.table_3_1 import numbers_of_table_3_1
from psp3.three_psp.parameters import Parameters
from tests.helpers import Array
from tests.psp3.identification.test_regressor import random_motions
from tests.psp3.identification.test_unknowns import LEGS


@pytest.fixture(scope="module")
def of_table() -> object:
    return base_parameters(numbers_of_table_3_1(psp3.load("psp3")))


def test_the_3_psp_has_seven_of_eleven_numbers(of_table) -> None:
    """The closed form takes ten numbers, three of which are d, h and g.

    Seven masses and moments move it.
    """
    assert of_table.names == (
        "nut_mass + 3 ball_mass",
        "ball_axial_inertia",
        "ball_transverse_inertia",
        "star_mass",
        "star_inertia_x",
        "star_inertia_y",
        "star_inertia_z",
    )
    assert of_table.undetermined == ("nut_inertia_x", "nut_inertia_y", "nut_inertia_z")


def test_what_moves_together_in_the_3_psp_is_what_its_closed_form_takes_together(of_table) -> None:
    """The seven numbers of Parameters.as_array span the same space as K.

    They are linear functions of the eleven.
    """

    def taken(values: Array) -> Array:
        nut, ball, star, axial, transverse = values[0], values[4], values[7], values[5], values[6]
        parameters = Parameters(
            nut_mass=nut,
            nut_inertia=tuple(values[1:4]),
            ball_mass=ball,
            ball_axial_inertia=axial,
            ball_transverse_inertia=transverse,
            star_mass=star,
            star_inertia=tuple(values[8:11]),
        )
        return parameters.as_array()[2:9]

    names = of_table.unknowns.names
    order = [
        "nut_mass",
        *(f"nut_inertia_{x}" for x in "xyz"),
        "ball_mass",
        "ball_axial_inertia",
        "ball_transverse_inertia",
        "star_mass",
    ]
    assert names == (*order, *(f"star_inertia_{x}" for x in "xyz"))
    base = np.ones(11)
    columns = np.array([taken(base + unit) - taken(base) for unit in np.eye(11)]).T
    assert np.linalg.matrix_rank(columns) == 7
    assert np.linalg.matrix_rank(np.concatenate([columns, of_table.grouping]), tol=1e-9) == 7


def test_legs_of_the_3_psp_have_sixteen_base_parameters() -> None:
    """Of 50 general numbers.

    Whatever slides on a screw has one mass, and nothing else of a nut is seen.
    """
    base = base_parameters(equal_bodies(psp3.load("psp3"), LEGS))
    assert len(base.columns) == 16
    assert "m(a1) + m(phi1) + m(theta1) + m(lambda1)" in base.names
    assert "m(b1)" in base.names
    assert set(base.undetermined) >= {
        f"{kind}(a1)" for kind in ("mx", "my", "mz", "Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz")
    }


@pytest.mark.parametrize(
    ("name", "count", "why"),
    [
        # An arm of two links in a vertical plane has 6: two first moments and a moment of inertia
        # of each. A mass at the pin that closes the loop can be moved from one elbow link to the
        # other: 2 * 6 - 1.
        ("five_bar", 11, "2 * 6 - 1"),
        # In a level plane gravity does not tell first moments: the shoulder link has its moment
        # alone, the elbow link also two first moments, 4 in a leg; the platform has 4, its mass
        # too. Masses at three pins can be moved across them: 3 * 4 + 4 - 3.
        ("planar_3rrr", 13, "3 * 4 + 4 - 3"),
    ],
)
def test_planar_robots_have_as_many_as_counted_by_hand(name: str, count: int, why: str) -> None:
    base = base_parameters(all_parameters(psp3.load(name)))
    assert len(base.columns) == count, why
    np.testing.assert_array_equal(base.grouping[:, base.columns], np.eye(count))


def arm(lengths: tuple[float, float]) -> ClosedLoopRobot:
    """Two links that swing about y in the plane of gravity, with masses anywhere."""
    model = pin.Model()
    first = model.addJoint(0, pin.JointModelRY(), pin.SE3.Identity(), "first")
    second = model.addJoint(
        first, pin.JointModelRY(), pin.SE3(np.eye(3), np.array([lengths[0], 0.0, 0.0])), "second"
    )
    for joint, mass, center in ((first, 1.0, [0.3, 0.1, 0.2]), (second, 0.5, [0.2, 0.0, 0.1])):
        model.appendBodyToJoint(
            joint, pin.Inertia(mass, np.array(center), np.eye(3)), pin.SE3.Identity()
        )
    model.lowerPositionLimit[:], model.upperPositionLimit[:] = -3.0, 3.0
    return ClosedLoopRobot(model, [], ["first", "second"])


def test_two_links_have_the_base_parameters_of_the_textbook() -> None:
    """W. Khalil and E. Dombre, Modeling, Identification and Control of Robots.

    The second mass is a point at the first one's end.
    """
    length = 0.7
    base = base_parameters(all_parameters(arm((length, 0.4))))
    assert base.names == (
        f"mx(first) + {length} m(second)",
        "mz(first)",
        f"Iyy(first) + {length**2:.4g} m(second)",
        "mx(second)",
        "mz(second)",
        "Iyy(second)",
    )


@pytest.mark.parametrize("name", ["five_bar", "tricept"])
def test_forces_depend_on_base_parameters_alone(name: str) -> None:
    """Other engines of thought: two models with the same base parameters need the same forces.

    By RNEA; others do not.

    Changes that K does not see are scaled so that masses stay positive; forces must agree to the
    rounding of their size.
    """
    robot = psp3.load(name)
    base = base_parameters(all_parameters(robot))
    rng = np.random.default_rng(4)
    scale = np.abs(base.unknowns.believed)
    # Changes of what is believed to be zero are left out: bodies without mass stay without.
    unseen = np.linalg.svd(base.grouping * scale)[2][len(base.columns) :].T
    change = scale * (unseen @ rng.normal(size=unseen.shape[1]))
    change *= 0.5 / np.max(np.abs(change[scale > 0.0]) / scale[scale > 0.0])
    assert np.abs(change).max() > 1e-2
    motion = random_motions(name, 5)
    forces = robot.inverse_dynamics(*motion)

    def with_parameters(values: Array) -> Array:
        model = robot.model.copy()
        for joint, row in enumerate(base.unknowns.expand(values).reshape(-1, 10), start=1):
            if row[0] > 0.0:
                model.inertias[joint] = pin.Inertia.FromDynamicParameters(row)
        return ClosedLoopRobot(
            model, robot.constraint_models, robot.actuated, robot.q0
        ).inverse_dynamics(*motion)

    size = float(np.abs(forces).max())
    np.testing.assert_allclose(
        with_parameters(base.unknowns.believed + change), forces, atol=1e-10 * size
    )
    seen = scale * np.linalg.svd(base.grouping * scale)[2][0] * 0.5
    assert np.abs(with_parameters(base.unknowns.believed + seen) - forces).max() > 1e-3 * size


def test_the_regressor_of_base_parameters_gives_the_same_forces(of_table) -> None:
    """1e-10 of forces of some 100 N."""
    motion = random_motions("psp3", 10)
    columns, known = of_table.forces_of(*motion)
    assert columns.shape == (10, 3, 7)
    np.testing.assert_allclose(
        columns @ of_table.believed + known,
        of_table.unknowns.robot.inverse_dynamics(*motion),
        atol=1e-10,
    )


def test_nearest_shares_a_change_in_proportion(of_table) -> None:
    """By hand: a kilogram more on nut_mass + 3 ball_mass goes to both.

    By the squares of what is believed times the coefficients.
    """
    believed = of_table.believed
    np.testing.assert_allclose(of_table.nearest(believed), of_table.unknowns.believed, atol=1e-15)
    wanted = believed.copy()
    wanted[0] += 1.0
    found = dict(zip(of_table.unknowns.names, of_table.nearest(wanted), strict=True))
    p = Parameters()
    total = p.nut_mass**2 + 9.0 * p.ball_mass**2
    assert found["nut_mass"] == pytest.approx(p.nut_mass + p.nut_mass**2 / total, rel=1e-12)
    assert found["ball_mass"] == pytest.approx(
        p.ball_mass + 3.0 * p.ball_mass**2 / total, rel=1e-12
    )
    assert found["nut_inertia_y"] == p.nut_inertia[1]
    np.testing.assert_allclose(of_table.values(list(found.values())), wanted, rtol=1e-12)


def test_the_result_does_not_depend_on_the_random_motions() -> None:
    """Other motions, the same combinations; coefficients to 1e-8, after a condition of some 1e3."""
    unknowns = all_parameters(psp3.load("five_bar"))
    one, other = (base_parameters(unknowns, np.random.default_rng(seed)) for seed in (10, 11))
    np.testing.assert_array_equal(one.columns, other.columns)
    np.testing.assert_allclose(one.grouping, other.grouping, atol=1e-8)
    again = base_parameters(unknowns, np.random.default_rng(10))
    np.testing.assert_array_equal(one.grouping, again.grouping)


@settings(max_examples=50, deadline=None)
@given(rank=st.integers(1, 6), extra=st.integers(0, 6), seed=st.integers(0, 2**32 - 1))
def test_independent_columns_rebuild_the_matrix(rank: int, extra: int, seed: int) -> None:
    """W = W1 K for random matrices of known rank.

    Columns have very different lengths, and some are zero.
    """
    rng = np.random.default_rng(seed)
    matrix = rng.normal(size=(30, rank)) @ np.column_stack(
        [np.eye(rank), rng.integers(-2, 3, size=(rank, extra))]
    )
    matrix = matrix[:, rng.permutation(rank + extra)] * 10.0 ** rng.integers(
        -3, 4, size=rank + extra
    )
    columns, grouping = independent_columns(matrix)
    assert len(columns) == rank
    np.testing.assert_allclose(
        matrix[:, columns] @ grouping, matrix, atol=1e-10 * np.abs(matrix).max()
    )
    # Each is independent of those before it: the first that are.
    for count in range(matrix.shape[1] + 1):
        expected = (
            np.linalg.matrix_rank(
                matrix[:, :count] / np.maximum(np.linalg.norm(matrix[:, :count], axis=0), 1e-300)
            )
            if count
            else 0
        )
        assert np.count_nonzero(columns < count) == expected


def test_columns_that_are_nearly_the_same_are_refused() -> None:
    """Each of 40 columns leaves 2e-9 of its length beside those before it.

    But together they are flatter than that.
    """
    rng = np.random.default_rng(0)
    basis = np.linalg.qr(rng.normal(size=(100, 41)))[0]
    matrix = basis[:, :1] + 2e-9 * np.cumsum(basis[:, 1:], axis=1)
    with pytest.raises(UncertainRank, match="take fewer unknowns"):
        independent_columns(matrix)


def test_bad_values_are_refused(of_table) -> None:
    for bad in (np.zeros(6), np.full(7, np.nan)):
        with pytest.raises(InvalidArray):
            of_table.nearest(bad)
    with pytest.raises(InvalidArray):
        of_table.values(np.zeros(7))
