"""The files of the shipped robots, opened as they are by other tools where these are installed.

MuJoCo is among the extras; Drake, PyBullet and yourdfpy are not
(``pip install drake pybullet yourdfpy``). Masses of all bodies are ours, and what has no mass has
none there.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from psp3.description.mjcf import read_mjcf
from psp3.description.parts import MJCF_ROBOTS, ROBOT_FILES, ROBOTS

URDFS = [name for name in ROBOTS if name not in MJCF_ROBOTS]

pytestmark = pytest.mark.filterwarnings("ignore")


def tree(name: str) -> pin.Model:
    """Return Pinocchio's tree of a file."""
    if name in MJCF_ROBOTS:
        return read_mjcf(ROBOT_FILES / f"{name}.xml").model
    return pin.buildModelFromUrdf(str(ROBOT_FILES / f"{name}.urdf"))


def masses(model: pin.Model) -> list[float]:
    return sorted(inertia.mass for inertia in list(model.inertias)[1:])


@pytest.mark.parametrize("name", ROBOTS)
def test_mujoco(name: str) -> None:
    mujoco = pytest.importorskip("mujoco")
    kind = "xml" if name in MJCF_ROBOTS else "urdf"
    model, ours = mujoco.MjModel.from_xml_path(str(ROBOT_FILES / f"{name}.{kind}")), tree(name)
    assert model.nv == ours.nv
    assert np.allclose(sorted(model.body_mass[1:]), masses(ours), rtol=1e-12)


@pytest.mark.parametrize("name", ROBOTS)
def test_drake(name: str) -> None:
    """A URDF floats there until it is welded to the world."""
    pytest.importorskip("pydrake")
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant

    plant, ours = MultibodyPlant(0.0), tree(name)
    kind = "xml" if name in MJCF_ROBOTS else "urdf"
    Parser(plant).AddModels(str(ROBOT_FILES / f"{name}.{kind}"))
    plant.Finalize()
    assert plant.num_velocities() == ours.nv + (0 if name in MJCF_ROBOTS else 6)
    found = plant.CalcTotalMass(plant.CreateDefaultContext())
    assert found == pytest.approx(sum(masses(ours)), rel=1e-12)


@pytest.mark.parametrize("name", URDFS)
def test_pybullet(name: str) -> None:
    bullet = pytest.importorskip("pybullet")
    client, ours = bullet.connect(bullet.DIRECT), tree(name)
    try:
        body = bullet.loadURDF(str(ROBOT_FILES / f"{name}.urdf"), physicsClientId=client)
        count = bullet.getNumJoints(body, client)
        found = [
            bullet.getDynamicsInfo(body, link, physicsClientId=client)[0]
            for link in range(-1, count)
        ]
    finally:
        bullet.disconnect(client)
    assert np.allclose(sorted(mass for mass in found if mass), masses(ours), rtol=1e-12)


@pytest.mark.parametrize("name", URDFS)
def test_yourdfpy(name: str) -> None:
    yourdfpy = pytest.importorskip("yourdfpy")
    robot, ours = yourdfpy.URDF.load(str(ROBOT_FILES / f"{name}.urdf")), tree(name)
    assert sorted(robot.actuated_joint_names) == sorted(list(ours.names)[1:])
    found = [link.inertial.mass for link in robot.link_map.values() if link.inertial]
    assert np.allclose(sorted(mass for mass in found if mass), masses(ours), rtol=1e-12)
