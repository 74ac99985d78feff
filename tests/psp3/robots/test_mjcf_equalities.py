"""What holds an exported robot together, in the words of MuJoCo.

That MuJoCo moves the shipped ones as we do is shown in tests/cross/test_built_robots.py.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

import psp3
from psp3.errors import InvalidValue
from psp3.multibody.equations import Coupling
from psp3.robots.mjcf_export import to_mjcf
from tests.cross.test_mujoco_structures import ROBOTS, loaded, random_positions
from tests.helpers import Array
from tests.mujoco_null_space import doubled, rod

EXPORTED = [name for name in ROBOTS if name != "rod, its spin locked"]


def numbers(element: ET.Element, attribute: str) -> list[float]:
    return [float(word) for word in element.attrib[attribute].split()]


@pytest.mark.parametrize("name", EXPORTED)
def test_every_structure_comes_back(name: str, tmp_path: Path) -> None:
    """Couplings, tendons, held joints and floating bases: M, C v and G of 5 states to 1e-10.

    A joint that was held is one that an equality holds, so that less is free the second time.
    """
    robot = loaded(tmp_path, *ROBOTS[name][:2])
    again = loaded(tmp_path, to_mjcf(robot), "keep")
    assert (again.coordinates, again.actuated) == (robot.coordinates, robot.actuated)
    assert not again.locked
    rng = np.random.default_rng(0)
    for _ in range(5):
        positions, speeds = random_positions(robot, rng), rng.normal(size=len(robot.coordinates_v))
        for one, other in zip(
            robot.equation_of_motion(positions, speeds),
            again.equation_of_motion(positions, speeds),
            strict=True,
        ):
            assert_allclose(other, one, rtol=0, atol=1e-10 * (1.0 + np.abs(one).max()))


def test_a_held_joint_has_a_constant(tmp_path: Path) -> None:
    robot = loaded(tmp_path, doubled(), "lock")
    root = ET.fromstring(to_mjcf(robot))
    (held,) = root.iter("equality").__next__().findall("joint")
    assert held.attrib["joint1"] == robot.locked[0].joint
    assert "joint2" not in held.attrib
    joint = robot.model.joints[robot.model.getJointId(robot.locked[0].joint)]
    assert numbers(held, "polycoef") == [robot.q0[joint.idx_q], 0.0, 0.0, 0.0, 0.0]


def test_a_coupling_keeps_its_polynomial_and_a_tendon_its_levers() -> None:
    robot = psp3.load("gripper")
    root = ET.fromstring(to_mjcf(robot))
    (coupling,) = (one for one in robot.equations if isinstance(one, Coupling))
    (written,) = next(root.iter("equality")).findall("joint")
    assert numbers(written, "polycoef") == [*coupling.coefficients]
    assert (written.get("joint1"), written.get("joint2")) == ("left_driver", "right_driver")
    (tendon,) = next(root.iter("tendon"))
    assert {part.get("joint"): numbers(part, "coef") for part in tendon} == {
        "right_driver": [0.5],
        "left_driver": [0.5],
    }
    (motor,) = next(root.iter("actuator"))
    assert (motor.get("tendon"), motor.get("joint")) == ("split", None)


def test_a_hinge_is_two_points_of_its_axis() -> None:
    robot = psp3.load("agile_eye")
    root = ET.fromstring(to_mjcf(robot))
    connects = next(root.iter("equality")).findall("connect")
    assert len(connects) == 2 * len(robot.equations)
    sites = {site.get("name"): np.array(numbers(site, "pos")) for site in root.iter("site")}
    for hinge, pair in zip(robot.equations, (connects[:2], connects[2:]), strict=True):
        for side, placement in (
            ("site1", hinge.joint1_placement),
            ("site2", hinge.joint2_placement),
        ):
            first, second = (sites[one.attrib[side]] for one in pair)
            assert_allclose(first, placement.translation, rtol=0, atol=1e-12)
            along = second - first
            assert_allclose(
                along / np.linalg.norm(along), placement.rotation[:, 2], rtol=0, atol=1e-12
            )


@pytest.mark.parametrize("com", [".1 0 .02", "0 0 0"])
def test_a_spin_that_would_be_felt_is_refused(com: str, tmp_path: Path) -> None:
    """Of a rod that is no body of revolution about its line, by its mass or by its moments."""
    robot = loaded(tmp_path, rod(com=com), "lock")
    with pytest.raises(InvalidValue, match="the spin of ball"):
        to_mjcf(robot)


def test_a_spin_that_nobody_feels_is_left_free() -> None:
    robot = psp3.load("hexa")
    root = ET.fromstring(to_mjcf(robot))
    assert sum(joint.get("type") == "ball" for joint in root.iter("joint")) == 7
    assert not next(root.iter("equality")).findall("joint")


def test_a_floating_body_is_free_in_the_world() -> None:
    root = ET.fromstring(to_mjcf(psp3.load("biped")))
    world = next(root.iter("worldbody"))
    (pelvis,) = (one for one in world.findall("body") if one.get("name") == "pelvis")
    assert [one.get("name") for one in pelvis.findall("freejoint")] == ["root"]
    home = numbers(next(root.iter("key")), "qpos")
    assert home[:7] == [0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0]


def standing() -> Array:
    return np.array(pin.SE3ToXYZQUAT(pin.exp6(np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6]))))


def test_a_floating_body_is_where_the_world_says() -> None:
    """A joint may stand anywhere in the neutral pose; MuJoCo counts from the world."""
    mujoco = pytest.importorskip("mujoco", reason="MuJoCo is in the extras mujoco and test")
    from psp3.robots.mjcf_export import mujoco_state

    model = pin.Model()
    place = pin.exp6(np.array([1.0, -2.0, 0.5, 0.3, -0.4, 0.2]))
    root = model.addJoint(0, pin.JointModelFreeFlyer(), place, "root")
    arm = model.addJoint(root, pin.JointModelRX(), pin.SE3.Identity(), "arm")
    for joint in (root, arm):
        body = pin.Inertia(1.0, np.array([0.1, 0.0, 0.2]), np.diag([0.1, 0.12, 0.15]))
        model.appendBodyToJoint(joint, body, pin.SE3.Identity())
    robot = psp3.ClosedLoopRobot(model, [], ("arm",))
    engine = mujoco.MjModel.from_xml_string(to_mjcf(robot))
    data = mujoco.MjData(engine)
    positions, speeds = np.append(0.3, standing()), np.arange(1.0, 8.0)
    q, v = robot.configuration(positions), robot.velocity(positions, speeds)
    data.qpos[:], data.qvel[:] = mujoco_state(robot, q, v)
    mujoco.mj_forward(engine, data)
    engine.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    mujoco.mj_forward(engine, data)
    assert data.energy[1] == pytest.approx(robot.kinetic_energy(positions, speeds), rel=1e-12)
    assert data.energy[0] == pytest.approx(float(robot.potential_energy(positions)), rel=1e-12)
    assert_allclose(
        data.xpos[engine.nbody - 2], (place * pin.XYZQUATToSE3(standing())).translation, atol=1e-14
    )
