"""``psp3 dynamics``: the library's numbers, by another way."""

from __future__ import annotations

import numpy as np
import pytest

import psp3
from tests.psp3.cli.answers import Run, words


@pytest.mark.parametrize("parameters", ["default", "table_5_1"])
def test_dynamics_agrees_with_the_projected_tree(psp3_command: Run, parameters: str) -> None:
    """Another implementation; the bar between the two is 1e-9 of the largest entry."""
    a, v, w = [0.15, 0.25, 0.15], [-0.1, 0.2, 0.3], [1.0, -2.0, 0.5]
    options = (
        "--heights",
        "0.15,0.25,0.15",
        "--speeds",
        "-0.1,0.2,0.3",
        "--accelerations",
        "1,-2,0.5",
        "--parameters",
        parameters,
    )
    found = psp3_command("dynamics", *options, "--json").json
    M, C, G = (
        psp3.load("psp3", parameters=parameters).dynamics("pinocchio").equation_of_motion(a, v)
    )
    for name, expected in (("M", M), ("C", C), ("G", G), ("forces", M @ w + C @ v + G)):
        np.testing.assert_allclose(
            found[name], expected, rtol=0.0, atol=1e-9 * np.abs(expected).max()
        )
    assert "kg/s" in psp3_command("dynamics", *options).out


def test_dynamics_rests_unless_told_otherwise(psp3_command: Run) -> None:
    found = psp3_command("dynamics", "--heights", "0.1,0,-0.1", "--json").json
    np.testing.assert_array_equal(found["forces"], found["G"])
    np.testing.assert_array_equal(np.abs(found["C"]), 0.0)


@pytest.mark.parametrize("name", ["five_bar", "delta"])
def test_dynamics_of_any_robot(psp3_command: Run, name: str) -> None:
    """Against the projected tree, which shares no kernel with what the command calls."""
    robot = psp3.load(name)
    n = len(robot.actuated)
    a, v, w = robot.reference, 0.1 * np.arange(1, n + 1), -0.5 * np.ones(n)
    state = [",".join(map(repr, row.tolist())) for row in (v, w)]
    found = psp3_command(
        "dynamics", name, f"--speeds={state[0]}", f"--accelerations={state[1]}", "--json"
    ).json
    M, C, G = robot.dynamics("pinocchio").equation_of_motion(a, v)
    for key, expected in (("M", M), ("C", C), ("G", G), ("forces", M @ w + C @ v + G)):
        np.testing.assert_allclose(
            found[key], expected, rtol=0.0, atol=1e-9 * np.abs(expected).max()
        )
    assert found["coordinates"] == list(robot.actuated)
    assert f"M of {name}" in words(psp3_command("dynamics", name).out)


def test_dynamics_of_many_coordinates_fit_a_terminal(psp3_command: Run) -> None:
    """Columns are numbered, and what does not fit comes below; what motors cannot do is said."""
    out = psp3_command("dynamics", "biped").out
    lines = out.splitlines()
    assert max(map(len, lines)) <= 80
    assert "the motors cannot bring about this motion" in words(out)
    rows = [line.split() for line in lines if "left_knee" in line]
    mass = psp3.load("biped").mass_matrix(psp3.load("biped").reference)
    assert [float(cell) for cell in rows[0][2:]] == pytest.approx(
        mass[3, : len(rows[0]) - 2], rel=1e-4, abs=1e-12
    )
