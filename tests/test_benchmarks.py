"""What the benchmarks measure is what it says.

The chain of five-bars is a robot, and its loops are closed one by one.
"""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

import psp3
from psp3.multibody.tree import GROUPS
from tests.helpers import relative_error

CHAIN = Path(__file__).resolve().parents[1] / "benchmarks" / "five_bar_chain.py"


@pytest.fixture(scope="module")
def chain() -> Any:
    spec = importlib.util.spec_from_file_location("five_bar_chain", CHAIN)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("count", [1, 3, 7])
def test_a_chain_has_two_freedoms_and_one_group_of_loops_for_each_linkage(
    chain: Any, count: int
) -> None:
    robot = chain.five_bar_chain(count)
    assert (robot.mobility.degrees_of_freedom, robot.mobility.redundant_equations) == (
        2 * count,
        count,
    )
    assert int(robot._core.tree[GROUPS]) == count


def test_dynamics_of_a_chain_are_those_of_the_natural_orthogonal_complement(chain: Any) -> None:
    """M, C v and G to 1e-11, relative; they share the tree and Pinocchio's joints."""
    robot, rng = chain.five_bar_chain(3), np.random.default_rng(0)
    noc = psp3.NaturalOrthogonalComplement(robot)
    positions, speeds = robot.reference + rng.uniform(-0.2, 0.2, (5, 6)), rng.normal(size=(5, 6))
    ours, theirs = (
        robot.equation_of_motion(positions, speeds),
        noc.equation_of_motion(positions, speeds),
    )
    assert relative_error(ours[0], theirs[0]) < 1e-11
    assert (
        relative_error(
            np.einsum("nij,nj->ni", ours[1], speeds), np.einsum("nij,nj->ni", theirs[1], speeds)
        )
        < 1e-11
    )
    assert relative_error(ours[2], theirs[2]) < 1e-11


def test_each_linkage_stands_on_the_tip_of_the_one_before(chain: Any) -> None:
    """At the reference pose all are upright, so tips rise by equal steps."""
    robot = chain.five_bar_chain(4)
    heights = []
    for number in range(4):
        q = robot.configuration(robot.reference)
        pin.forwardKinematics(robot.model, robot.data, q)
        elbow = robot.model.getJointId(f"elbow{number}_left")
        heights.append(
            (
                robot.data.oMi[elbow] * pin.SE3(np.eye(3), np.array([chain.FAR, 0.0, 0.0]))
            ).translation[2]
        )
    np.testing.assert_allclose(np.diff(heights), heights[0], rtol=1e-12)
