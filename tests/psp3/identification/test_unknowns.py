"""Unknowns.

All parameters, equal bodies once, the numbers of Table 3.1, and those that are taken as known.
"""

from __future__ import annotations

import numpy as np
import pytest

import psp3
from psp3.errors import InvalidArray, InvalidValue, UnknownName
from psp3.identification.regressor import standard_parameters
from psp3.identification.unknowns import all_parameters, equal_bodies
from psp3.thesis.table_3_1 import numbers_of_table_3_1
from tests.robot_samplers import random_poses

LEGS = [
    tuple(f"{joint}{leg}" for leg in (1, 2, 3)) for joint in ("a", "phi", "theta", "lambda", "b")
]


@pytest.mark.parametrize("name", ["psp3", "five_bar", "delta"])
def test_all_parameters_expand_to_those_of_the_model(name: str) -> None:
    """Exactly: a permutation adds nothing to rounding. Masses come last."""
    robot = psp3.load(name)
    unknowns = all_parameters(robot)
    np.testing.assert_array_equal(unknowns.expand(unknowns.believed), standard_parameters(robot))
    bodies = len(unknowns.names) // 10
    assert all(name.startswith("m(") for name in unknowns.names[-bodies:])
    assert not any(name.startswith("m(") for name in unknowns.names[:-bodies])


def test_legs_of_the_3_psp_are_equal() -> None:
    """In the joints' own axes all three legs have the same numbers: 50 unknowns are as good as 150.

    1e-15 is rounding of the mean.
    """
    robot = psp3.load("psp3")
    unknowns = equal_bodies(robot, LEGS)
    assert len(unknowns.names) == 50
    np.testing.assert_allclose(
        unknowns.expand(unknowns.believed), standard_parameters(robot), atol=1e-15
    )


def test_an_inertia_across_the_star_breaks_the_equality_of_legs() -> None:
    """The star of table_5_1 is not symmetric, and the mean over its legs is another star."""
    robot = psp3.load("psp3", parameters="table_5_1")
    unknowns = equal_bodies(robot, LEGS)
    assert np.abs(unknowns.expand(unknowns.believed) - standard_parameters(robot)).max() > 1e-3


def test_what_is_known_moves_to_the_other_side() -> None:
    """The sum of both parts stays, to the rounding of forces of some 100 N."""
    robot, rng = psp3.load("psp3"), np.random.default_rng(3)
    unknowns = numbers_of_table_3_1(robot)
    fewer = unknowns.without(["nut_mass", "star_inertia_z"]).without(["ball_axial_inertia"])
    assert len(fewer.names) == len(unknowns.names) - 3
    assert "nut_mass" not in fewer.names
    motion = random_poses("psp3", 5, rng), rng.normal(size=(5, 3)), rng.normal(size=(5, 3))
    columns, known = fewer.forces_of(*motion)
    assert np.abs(known).min() > 10.0
    np.testing.assert_allclose(
        columns @ fewer.believed + known, robot.inverse_dynamics(*motion), atol=1e-11
    )
    np.testing.assert_allclose(fewer.expand(fewer.believed), standard_parameters(robot), atol=1e-14)


def test_bad_input_is_refused() -> None:
    robot, five_bar = psp3.load("psp3"), psp3.load("five_bar")
    with pytest.raises(UnknownName, match="a9"):
        equal_bodies(robot, [("a1", "a9")])
    with pytest.raises(InvalidValue, match="groups"):
        equal_bodies(robot, [("a1", "a2"), ("a2", "a3")])
    with pytest.raises(InvalidValue, match="groups"):
        equal_bodies(robot, [()])
    with pytest.raises(InvalidValue, match="3-PSP"):
        numbers_of_table_3_1(five_bar)  # type: ignore[arg-type]
    unknowns = all_parameters(five_bar)
    with pytest.raises(UnknownName, match="nut_mass"):
        unknowns.without(["nut_mass"])
    for bad in (np.zeros(39), np.full(40, np.nan)):
        with pytest.raises(InvalidArray):
            unknowns.expand(bad)
