"""The numbers of Table 3.1 that identification would find."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import psp3
from psp3.identification.regressor import standard_parameters
from psp3.thesis.table_3_1 import numbers_of_table_3_1
from tests.robot_samplers import random_poses


@pytest.mark.parametrize("parameters", ["default", "table_3_1", "table_5_1"])
def test_numbers_of_table_3_1_give_the_inverse_dynamics(parameters: str) -> None:
    """Against the closed form, which knows nothing of standard parameters.

    1e-10 of forces of some 100 N.
    """
    robot = psp3.load("psp3", parameters=parameters)
    rng = np.random.default_rng(0)
    positions = random_poses("psp3", 10, rng)
    speeds, accelerations = rng.normal(size=(2, 10, 3))
    unknowns = numbers_of_table_3_1(robot)
    columns, known = unknowns.forces_of(positions, speeds, accelerations)
    np.testing.assert_allclose(
        columns @ unknowns.believed,
        robot.inverse_dynamics(positions, speeds, accelerations),
        atol=1e-10,
    )
    assert not known.any()
    np.testing.assert_allclose(
        unknowns.expand(unknowns.believed), standard_parameters(robot), atol=1e-14
    )


def test_numbers_of_table_3_1_are_linear_over_any_distance() -> None:
    """A robot with all numbers drawn anew, against the closed form of that robot.

    1e-9 of forces of some 1000 N.
    """
    robot, rng = psp3.load("psp3"), np.random.default_rng(2)
    unknowns = numbers_of_table_3_1(robot)
    drawn = dict(zip(unknowns.names, rng.uniform(0.5, 5.0, len(unknowns.names)), strict=True))
    other = psp3.load(
        "psp3",
        parameters=replace(
            robot.parameters,
            **{
                name: drawn[name]
                for name in (
                    "nut_mass",
                    "ball_mass",
                    "star_mass",
                    "ball_axial_inertia",
                    "ball_transverse_inertia",
                )
            },
            nut_inertia=tuple(drawn[f"nut_inertia_{axis}"] for axis in "xyz"),
            star_inertia=tuple(drawn[f"star_inertia_{axis}"] for axis in "xyz"),
        ),
    )
    positions = random_poses("psp3", 10, rng)
    speeds, accelerations = rng.normal(size=(2, 10, 3))
    forces = unknowns.forces_of(positions, speeds, accelerations)[0] @ np.array(
        list(drawn.values())
    )
    np.testing.assert_allclose(
        forces, other.inverse_dynamics(positions, speeds, accelerations), atol=1e-9
    )
