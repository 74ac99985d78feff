"""The same tree in MuJoCo: mass matrix, bias and gravity projected on the closures' null space, engine against engine."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import psp3
from psp3.loading import ROBOT_FILES
from tests.helpers import Array, random_states, relative_error

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is in the extras mujoco and test")

STARS = ("star1", "star2", "star3")


@pytest.fixture(scope="module")
def robot() -> psp3.PSP3:
    return psp3.load("psp3")


@pytest.fixture(scope="module")
def engine() -> Any:
    """MuJoCo's model of the URDF as it is, but for a compiler tag.

    The printed nut inertia violates the triangle inequality, which MuJoCo accepts only with balanceinertia.
    """
    text = (ROBOT_FILES / "psp3.urdf").read_text(encoding="utf-8")
    tag = '<mujoco><compiler balanceinertia="true" discardvisual="true" fusestatic="true"/></mujoco>'
    assert text.count('<robot name="psp3">') == 1
    return mujoco.MjModel.from_xml_string(text.replace('<robot name="psp3">', f'<robot name="psp3">{tag}'))


def test_mujoco_refuses_the_nut_as_printed() -> None:
    """So the tag above is needed, and what it changes has to be looked at."""
    with pytest.raises(ValueError, match="inertia"):
        mujoco.MjModel.from_xml_path(str(ROBOT_FILES / "psp3.urdf"))


def test_balancing_changes_the_nuts_only(robot: psp3.PSP3, engine: Any) -> None:
    """All other bodies are those of the URDF to 1e-12; a nut gets the mean of its moments, and never turns."""
    assert engine.nbody == 16
    for joint in range(1, robot.model.njoints):
        name = robot.model.names[joint]
        body = engine.jnt_bodyid[mujoco.mj_name2id(engine, mujoco.mjtObj.mjOBJ_JOINT, name)]
        ours = robot.model.inertias[joint]
        rotation = np.empty(9)
        mujoco.mju_quat2Mat(rotation, engine.body_iquat[body])
        rotation = rotation.reshape(3, 3)
        inertia = rotation @ np.diag(engine.body_inertia[body]) @ rotation.T
        assert_allclose(engine.body_mass[body], ours.mass, rtol=1e-12)
        assert_allclose(engine.body_ipos[body], ours.lever, rtol=0, atol=1e-12)
        if name[0] == "a":
            assert_allclose(inertia, np.mean([0.003, 0.39, 0.3294]) * np.eye(3), rtol=0, atol=1e-12)
        else:
            assert_allclose(inertia, ours.inertia, rtol=0, atol=1e-12)


def projected(engine: Any, robot: psp3.PSP3, heights: Array, speeds: Array) -> tuple[Array, Array, Array]:
    """M, C v and G of one state from MuJoCo: its mass matrix, bias, Jacobians and their rates, projected with numpy."""
    data = mujoco.MjData(engine)
    names = list(robot.model.names)[1:]
    address = [mujoco.mj_name2id(engine, mujoco.mjtObj.mjOBJ_JOINT, name) for name in names]
    q = robot.configuration(heights)
    ours = [robot.model.joints[robot.model.getJointId(name)].idx_q for name in names]
    data.qpos[engine.jnt_qposadr[address]] = q[ours]
    actuated = [engine.jnt_dofadr[mujoco.mj_name2id(engine, mujoco.mjtObj.mjOBJ_JOINT, f"a{leg}")] for leg in (1, 2, 3)]
    dependent = [i for i in range(engine.nv) if i not in actuated]
    bodies = [mujoco.mj_name2id(engine, mujoco.mjtObj.mjOBJ_BODY, name) for name in STARS]

    def closures(function: Any) -> Array:
        """Twists of the thirds relative to the first, at the hub, per unit of joint velocity (or their rates)."""
        parts = []
        for body in bodies:
            linear, angular = np.zeros((3, engine.nv)), np.zeros((3, engine.nv))
            function(engine, data, linear, angular, data.xpos[bodies[0]], body)
            parts.append(np.concatenate([linear, angular]))
        return np.concatenate([parts[1] - parts[0], parts[2] - parts[0]])

    mujoco.mj_forward(engine, data)
    # MuJoCo agrees that the loops are closed here.
    for body in bodies[1:]:
        assert_allclose(data.xpos[body], data.xpos[bodies[0]], rtol=0, atol=1e-12)
    gravity = np.array(data.qfrc_bias)
    jacobian = closures(mujoco.mj_jac)
    solve = np.linalg.inv(jacobian[:, dependent])
    complement = np.zeros((engine.nv, 3))
    complement[actuated] = np.eye(3)
    complement[dependent] = -solve @ jacobian[:, actuated]
    data.qvel[:] = complement @ speeds
    mujoco.mj_forward(engine, data)
    drift = np.zeros(engine.nv)
    drift[dependent] = -solve @ closures(mujoco.mj_jacDot) @ data.qvel
    mass = np.empty((engine.nv, engine.nv))
    # Column by column: the storage of the whole matrix differs between versions of MuJoCo.
    for row, unit in zip(mass, np.eye(engine.nv), strict=True):
        mujoco.mj_mulM(engine, data, row, unit)
    velocity_forces = np.array(data.qfrc_bias) - gravity
    return complement.T @ mass @ complement, complement.T @ (velocity_forces + mass @ drift), complement.T @ gravity


def test_projected_dynamics_agree(robot: psp3.PSP3, engine: Any) -> None:
    """M, C v and G of 100 random states; 1e-9 relative to the largest entry of each."""
    heights, speeds = random_states(np.random.default_rng(0), 100)
    mass, coriolis, gravity = robot.equation_of_motion(heights, speeds)
    theirs = [projected(engine, robot, a, v) for a, v in zip(heights, speeds, strict=True)]
    assert relative_error(mass, np.array([state[0] for state in theirs])) < 1e-9
    assert relative_error(np.einsum("nij,nj->ni", coriolis, speeds), np.array([state[1] for state in theirs])) < 1e-9
    assert relative_error(gravity, np.array([state[2] for state in theirs])) < 1e-9
