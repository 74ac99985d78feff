"""The tree of the 3-PSP in MuJoCo: what becomes of the nuts' inertia, which no body can have.

The dynamics is in test_mujoco_robots.py.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import psp3
from psp3.description.parts import ROBOT_FILES
from tests.mujoco_projection import engine, mujoco


@pytest.fixture(scope="module")
def robot() -> psp3.PSP3:
    return psp3.load("psp3")


@pytest.fixture(scope="module")
def model() -> Any:
    return engine("psp3")


def test_mujoco_refuses_the_nut_as_printed() -> None:
    """So balanceinertia is needed, and what it changes has to be looked at."""
    text = (ROBOT_FILES / "psp3.urdf").read_text(encoding="utf-8")
    assert text.count(' balanceinertia="true"') == 1
    with pytest.raises(ValueError, match="inertia"):
        mujoco.MjModel.from_xml_string(text.replace(' balanceinertia="true"', ""))


def test_balancing_changes_the_nuts_only(robot: psp3.PSP3, model: Any) -> None:
    """All other bodies are those of the URDF to 1e-12.

    A nut gets the mean of its moments, and never turns.
    """
    world_and_base, frames = 2, 4
    assert model.nbody == world_and_base + 15 + frames
    for joint in range(1, robot.model.njoints):
        name = robot.model.names[joint]
        body = model.jnt_bodyid[mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name)]
        ours = robot.model.inertias[joint]
        rotation = np.empty(9)
        mujoco.mju_quat2Mat(rotation, model.body_iquat[body])
        rotation = rotation.reshape(3, 3)
        inertia = rotation @ np.diag(model.body_inertia[body]) @ rotation.T
        assert_allclose(model.body_mass[body], ours.mass, rtol=1e-12)
        assert_allclose(model.body_ipos[body], ours.lever, rtol=0, atol=1e-12)
        if name[0] == "a":
            assert_allclose(inertia, np.mean([0.003, 0.39, 0.3294]) * np.eye(3), rtol=0, atol=1e-12)
        else:
            assert_allclose(inertia, ours.inertia, rtol=0, atol=1e-12)
