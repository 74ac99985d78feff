"""What is read from an MJCF file is what MuJoCo reads.

Places, mass matrices, forces and loops, at configurations of no special kind.
"""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

from psp3.description.mjcf import read_mjcf
from psp3.description.parts import RobotParts
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.helpers import Array, derivative

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is in the extras mujoco and test")

INERTIA = (
    '<inertial pos="0.02 -0.01 0.05" quat="1 0.3 -0.2 0.1" mass="1.3" diaginertia="0.02 0.03 '
    '0.04"/>'
)


def model(bodies: str, *sections: str, compiler: str = 'angle="radian"') -> str:
    return (
        '<mujoco model="m"><compiler '
        f"{compiler}/>{''.join(sections)}<worldbody>{bodies}</worldbody></mujoco>"
    )


def read(directory: Path, text: str, actuated: list[str] | None = None) -> tuple[RobotParts, Any]:
    """Return a file as we read it, and as MuJoCo compiles it."""
    path = directory / "robot.xml"
    path.write_text(text, encoding="utf-8")
    return read_mjcf(path, [] if actuated is None else actuated), mujoco.MjModel.from_xml_path(
        str(path)
    )


def joints(parts: RobotParts, engine: Any) -> list[tuple[Any, int, int, int]]:
    """For every joint of MuJoCo.

    Ours of the same name, its type, and where its coordinates and velocities start.
    """
    found = []
    for number in range(engine.njnt):
        name = mujoco.mj_id2name(engine, mujoco.mjtObj.mjOBJ_JOINT, number)
        ours = parts.model.joints[parts.model.getJointId(name) if name else number + 1]
        found.append(
            (
                ours,
                int(engine.jnt_type[number]),
                int(engine.jnt_qposadr[number]),
                int(engine.jnt_dofadr[number]),
            )
        )
    return found


def in_mujoco(parts: RobotParts, engine: Any, q: Array, v: Array) -> tuple[Any, Array]:
    """Return MuJoCo's data at a state of ours, and a matrix.

    The matrix takes our velocities to its own.
    """
    data, change = mujoco.MjData(engine), np.zeros((engine.nv, parts.model.nv))
    for ours, kind, position, velocity in joints(parts, engine):
        part = q[ours.idx_q : ours.idx_q + ours.nq]
        block = np.eye(ours.nv)
        if kind == mujoco.mjtJoint.mjJNT_FREE:
            place = parts.model.jointPlacements[ours.id] * pin.XYZQUATToSE3(part)
            x, y, z, w = pin.Quaternion(place.rotation).coeffs()
            data.qpos[position : position + 7] = [*place.translation, w, x, y, z]
            # MuJoCo has the linear velocity of a free body in world axes.
            block[:3, :3] = place.rotation
        elif kind == mujoco.mjtJoint.mjJNT_BALL:
            x, y, z, w = part
            data.qpos[position : position + 4] = [w, x, y, z]
        else:
            data.qpos[position] = part[0] + engine.qpos0[position]
        change[velocity : velocity + ours.nv, ours.idx_v : ours.idx_v + ours.nv] = block
    data.qvel[:] = change @ v
    mujoco.mj_forward(engine, data)
    return data, change


def mass_matrix(engine: Any, data: Any) -> Array:
    mass = np.empty((engine.nv, engine.nv))
    for row, unit in zip(mass, np.eye(engine.nv), strict=True):
        mujoco.mj_mulM(engine, data, row, unit)
    return mass


def assert_same(parts: RobotParts, engine: Any, share: float = 1e-10) -> None:
    """Places of all bodies and sites to 1e-12.

    Mass matrix, weight and velocity forces to 1e-10 of the largest entry, or another share.
    """
    ours, data = parts.model, parts.model.createData()
    assert (ours.nv, ours.nq) == (engine.nv, engine.nq)
    rng = np.random.default_rng(0)
    for _ in range(3):
        v = rng.normal(size=ours.nv)
        q = pin.integrate(ours, pin.neutral(ours), rng.normal(size=ours.nv))
        theirs, change = in_mujoco(parts, engine, q, np.zeros(ours.nv))
        pin.framesForwardKinematics(ours, data, q)
        for kind, frame, count, position, rotation in (
            (mujoco.mjtObj.mjOBJ_BODY, pin.FrameType.BODY, engine.nbody, theirs.xpos, theirs.xmat),
            (
                mujoco.mjtObj.mjOBJ_SITE,
                pin.FrameType.OP_FRAME,
                engine.nsite,
                theirs.site_xpos,
                theirs.site_xmat,
            ),
        ):
            for number in range(count):
                name = mujoco.mj_id2name(engine, kind, number)
                if name:
                    place = data.oMf[ours.getFrameId(name, frame)]
                    assert_allclose(
                        place.translation, position[number], rtol=0, atol=1e-12, err_msg=name
                    )
                    assert_allclose(
                        place.rotation.ravel(), rotation[number], rtol=0, atol=1e-12, err_msg=name
                    )
        mass = change.T @ mass_matrix(engine, theirs) @ change
        found = pin.crba(ours, data, q)
        assert_allclose(
            np.triu(found) + np.triu(found, 1).T, mass, rtol=0, atol=share * np.abs(mass).max()
        )
        weight = change.T @ theirs.qfrc_bias
        found = pin.rnea(ours, data, q, np.zeros(ours.nv), np.zeros(ours.nv))
        assert_allclose(found, weight, rtol=0, atol=share * max(np.abs(weight).max(), 1.0))
        if mujoco.mjtJoint.mjJNT_FREE not in engine.jnt_type:
            # The two engines derive the velocity of a free body in different axes, and with it the
            # velocity forces.
            theirs, _ = in_mujoco(parts, engine, q, v)
            found = pin.rnea(ours, data, q, v, np.zeros(ours.nv))
            assert_allclose(
                found,
                theirs.qfrc_bias,
                rtol=0,
                atol=share * max(np.abs(theirs.qfrc_bias).max(), 1.0),
            )


ORIENTATIONS = [
    'quat="2 0.4 -0.6 1"',
    'axisangle="1 2 -3 {}"',
    'euler="{} 0.4 -0.7"',
    'xyaxes="2 0.1 0 0.3 1 0.4"',
    'zaxis="1 2 3"',
    'zaxis="0 0 -2"',
    'zaxis="0 0 0.5"',
]


@pytest.mark.parametrize("orientation", ORIENTATIONS)
@pytest.mark.parametrize("angle", ["radian", "degree"])
def test_orientations(tmp_path: Path, orientation: str, angle: str) -> None:
    """Of a body, of a site, of the axes of an inertia, and of a geom.

    The geom has a mass and no position of its own.
    """
    turned = orientation.format(0.9 if angle == "radian" else 52.0)
    inertia = f'<inertial pos="0.1 0.2 0.3" {turned} mass="2" diaginertia="0.1 0.2 0.25"/>'
    inner = (
        '<body name="b" pos="0.3 0 0.1"><joint axis="1 0 0"/><geom type="box" size="0.1 0.2 '
        f'0.3" {turned}/></body>'
    )
    body = (
        f'<body name="a" pos="1 2 3" {turned}><joint axis="0 1 1"/>{inertia}<site name="s" '
        f'pos="1 0 0" {turned}/>{inner}</body>'
    )
    assert_same(*read(tmp_path, model(body, compiler=f'angle="{angle}"')))


@pytest.mark.parametrize("sequence", ["xyz", "zyx", "XYZ", "zXy", "ZYZ"])
def test_sequences_of_euler_angles(tmp_path: Path, sequence: str) -> None:
    """Small letters turn about axes that turn along, capitals about those of the parent."""
    body = f'<body name="a" euler="20 50 -70"><joint/>{INERTIA}</body>'
    assert_same(*read(tmp_path, model(body, compiler=f'eulerseq="{sequence}"')))


def test_angles_are_degrees_unless_the_file_says_radian(tmp_path: Path) -> None:
    body = f'<body name="a" euler="20 50 -70"><joint range="-30 60"/>{INERTIA}</body>'
    parts, engine = read(tmp_path, model(body, compiler=""))
    assert_same(parts, engine)
    assert_allclose(
        [parts.model.lowerPositionLimit[0], parts.model.upperPositionLimit[0]],
        np.radians([-30.0, 60.0]),
        rtol=1e-15,
    )


def test_classes(tmp_path: Path) -> None:
    """A class has what its parent class has.

    A body's childclass holds for what is in it until another one, or a class, is given.
    """
    default = """<default><joint armature="0.3" axis="1 0 0"/>\
<geom density="500" size="0.1 0.2 0.3"/>
      <default class="outer"><geom type="box"/><joint axis="0 1 0" damping="2"/>
        <default class="inner"><joint axis="0 0 1"/><geom density="800"/></default></default>
      <default class="slides"><joint type="slide" axis="0 1 1"/></default><site pos="0.1 0.2 0.3"/>\
</default>"""
    body = """<body name="a" childclass="outer"><joint name="y"/><geom/>
      <body name="b" pos="0.1 0.2 0.3"><joint name="z" class="inner"/>\
<geom class="inner" pos="0.1 0 0"/><site name="s"/>
        <body name="c" childclass="slides"><joint name="slide"/><geom type="ellipsoid"/>
          <body name="d" pos="0 0 0.4"><joint name="x" class="main" armature="0.1"/>\
<geom class="outer" mass="2"/></body>
        </body></body></body>"""
    parts, engine = read(tmp_path, model(body, default))
    assert_same(parts, engine)
    order = [joint.idx_v for joint, *_ in joints(parts, engine)]
    assert_allclose(parts.model.armature[order], engine.dof_armature, rtol=0, atol=0)
    assert_allclose(parts.model.damping[order], np.ravel(engine.dof_damping), rtol=0, atol=0)


def test_several_joints_of_a_body_away_from_its_origin(tmp_path: Path) -> None:
    """The first moves the body with all others.

    Pinocchio's own reader would make one composite joint of them.
    """
    body = f"""<body name="a" pos="0.3 0.2 0.1" euler="0.3 0.2 0.1">
      <joint name="j1" type="slide" axis="1 2 3"/><joint name="j2" pos="0.1 0.2 0.3" axis="0 1 0"/>
      <joint name="j3" pos="-0.1 0 0.2" axis="1 0 1"/>{INERTIA}<site name="s" pos="0.1 0 0"/>
      <body name="b" pos="0 0 0.5"><joint name="ball" type="ball" pos="0.1 -0.2 0.3" \
armature="0.02"/>{INERTIA}
        <body name="c" pos="0.2 0 0"><joint name="j4" pos="0 0.3 0"/>\
<joint name="j5" axis="1 0 0" pos="0 0 0.1"/>{INERTIA}</body>
      </body></body>"""
    parts, engine = read(tmp_path, model(body))
    assert list(parts.model.names)[1:] == ["j1", "j2", "j3", "ball", "j4", "j5"]
    assert_same(parts, engine)


def test_several_bodies_on_the_world_and_bodies_without_joints(tmp_path: Path) -> None:
    """Pinocchio's own reader would take the first one alone, and forget where it stands."""
    bodies = f"""<body name="a" pos="1 2 3" euler="0.3 0 0">{INERTIA}<site name="s"/>\
<body name="b" pos="0 0 1"><joint/>{INERTIA}
        <body name="welded" pos="0.3 0.2 0.1" euler="0 1 0">{INERTIA}<body name="d" pos="1 0 0">\
<joint axis="0 1 0"/>{INERTIA}</body></body>
      </body></body><body name="c" pos="-1 0 0"><joint type="slide"/>{INERTIA}</body>\
<site name="t" pos="0 0 4"/>"""
    assert_same(*read(tmp_path, model(bodies)))


def test_free_bodies(tmp_path: Path) -> None:
    bodies = f"""<body name="a" pos="1 2 3" euler="0.3 0.2 0.1"><freejoint name="f"/>{INERTIA}
      <body name="b" pos="0 0 1"><joint name="j"/>{INERTIA}</body></body>
      <body name="c" pos="-1 0 0"><joint name="g" type="free"/>{INERTIA}</body>"""
    assert_same(*read(tmp_path, model(bodies)))


GEOMS = [
    '<geom type="sphere" size="0.2"/>',
    '<geom size="0.2" pos="0.3 0.2 0.1"/>',
    '<geom type="capsule" size="0.1 0.3" density="700" euler="1 2 3"/>',
    '<geom type="capsule" size="0.1" fromto="0.1 0.2 0.3 -0.4 0.5 0.9"/>',
    '<geom type="cylinder" size="0.1 0.3" mass="3" pos="0.1 0.2 0.3" zaxis="1 1 1"/>',
    '<geom type="cylinder" size="0.1" fromto="0 0 0 0 0 -1"/>',
    '<geom type="ellipsoid" size="0.1 0.2 0.3" quat="1 1 0 0"/>',
    '<geom type="ellipsoid" size="0.1" fromto="0.1 0.2 0.3 -0.4 0.5 0.9"/>',
    '<geom type="box" size="0.1 0.2 0.3" contype="0" conaffinity="0"/>',
    '<geom type="box" size="0.1" fromto="0.1 0.2 0.3 -0.4 0.5 0.9"/>',
    (
        '<geom type="sphere" size="0.3"/><geom type="box" size="0.1 0.2 0.3" pos="1 0 0" group="4" '
        'mass="2"/><geom size="1" mass="0"/>'
    ),
]


@pytest.mark.parametrize("geoms", GEOMS)
def test_inertia_of_bodies_that_give_none(tmp_path: Path, geoms: str) -> None:
    assert_same(
        *read(
            tmp_path,
            model(
                '<body name="a"><joint axis="1 0 0"/><joint axis="0 1 0"/><joint pos="1 2 '
                f'3"/>{geoms}</body>'
            ),
        )
    )


@pytest.mark.parametrize(
    "compiler",
    [
        'inertiafromgeom="true"',
        'inertiafromgeom="false"',
        'boundmass="2"',
        'boundinertia="0.035"',
        'boundmass="5" boundinertia="1"',
        'balanceinertia="true" boundinertia="0.01"',
    ],
)
def test_settings_that_change_inertias(tmp_path: Path, compiler: str) -> None:
    """The last moments are such as no body has, which MuJoCo takes only if it may balance them."""
    odd = (
        '<inertial pos="0.1 0 0" mass="1" fullinertia="0.1 0.2 0.9 0.01 0.02 0.03"/>'
        if "balance" in compiler
        else INERTIA
    )
    body = (
        '<body name="a"><joint axis="1 0 0"/><joint axis="0 1 0"/><joint pos="1 2 '
        f'3"/>{odd}<geom size="0.3"/></body>'
    )
    assert_same(*read(tmp_path, model(body, compiler=compiler)))


def test_full_inertias(tmp_path: Path) -> None:
    body = (
        '<body name="a"><joint axis="1 0 0"/><joint axis="0 1 0"/><inertial pos="1 2 3" mass="2" '
        'fullinertia="3 2 4 0.1 0.2 0.3"/></body>'
    )
    assert_same(*read(tmp_path, model(body)))


@pytest.mark.parametrize(
    "option",
    ['<option gravity="1 -2 3"/>', "<option><flag gravity='disable'/></option>", "<option/>"],
)
def test_gravity(tmp_path: Path, option: str) -> None:
    assert_same(
        *read(
            tmp_path,
            model(f'<body name="a"><joint axis="1 0 0" pos="0 1 0"/>{INERTIA}</body>', option),
        )
    )


def test_included_files(tmp_path: Path) -> None:
    """In the middle of the tree and around it, one in the other, with the classes of both."""
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "arm.xml").write_text(
        '<mujocoinclude><body name="b" pos="0 0 1"><joint '
        f'class="y"/>{INERTIA}</body></mujocoinclude>'
    )
    classes = (
        '<mujoco><default><default class="y"><joint axis="0 1 0"/></default></default><include '
        'file="frame.xml"/></mujoco>'
    )
    (tmp_path / "classes.xml").write_text(classes)
    (tmp_path / "frame.xml").write_text('<mujoco><compiler angle="radian"/></mujoco>')
    text = f"""<mujoco model="m"><include file="classes.xml"/><worldbody>\
<body name="a" euler="0.3 0.2 0"><joint/>{INERTIA}
      <include file="parts/arm.xml"/></body></worldbody></mujoco>"""
    assert_same(*read(tmp_path, text))


@pytest.mark.parametrize("angle", ["radian", "degree"])
@pytest.mark.parametrize("automatic", ["true", "false"])
def test_limits_and_reference_positions(tmp_path: Path, angle: str, automatic: str) -> None:
    """MuJoCo's limits are those of its own coordinate, which is ``ref`` where ours is zero."""
    body = f"""<body name="a">{INERTIA}
      <joint name="j1" range="-1 2" ref="0.3" limited="true" actuatorfrcrange="-2 5" \
actuatorfrclimited="true"/>
      <body name="b"><joint name="j2" type="slide" range="-1 2" ref="0.3" limited="true"/>{INERTIA}
      <body name="c"><joint name="j3" range="-1 2" limited="false" actuatorfrcrange="-2 5" \
actuatorfrclimited="false"/>{INERTIA}
      <body name="d"><joint name="j4" type="slide" frictionloss="0.7" damping="0.2" \
armature="0.1"/>{INERTIA}</body></body></body></body>"""
    parts, engine = read(
        tmp_path, model(body, compiler=f'angle="{angle}" autolimits="{automatic}"')
    )
    assert_same(parts, engine)
    ours = parts.model
    for number, name in enumerate(("j1", "j2", "j3", "j4")):
        joint = ours.joints[ours.getJointId(name)]
        limited = bool(engine.jnt_limited[number])
        limits = (
            engine.jnt_range[number] - engine.qpos0[number]
            if limited
            else np.array([-np.inf, np.inf])
        )
        assert_allclose(
            [ours.lowerPositionLimit[joint.idx_q], ours.upperPositionLimit[joint.idx_q]],
            limits,
            rtol=1e-15,
        )
        effort = (
            engine.jnt_actfrcrange[number]
            if engine.jnt_actfrclimited[number]
            else [-np.inf, np.inf]
        )
        assert_allclose(
            [ours.lowerEffortLimit[joint.idx_v], ours.upperEffortLimit[joint.idx_v]], effort
        )
        assert ours.damping[joint.idx_v] == engine.dof_damping.reshape(4, -1)[number, 0]
        assert (
            ours.upperDryFrictionLimit[joint.idx_v]
            == -ours.lowerDryFrictionLimit[joint.idx_v]
            == engine.dof_frictionloss[number]
        )
        assert ours.armature[joint.idx_v] == engine.dof_armature[number]


def test_key_frames(tmp_path: Path) -> None:
    """Every kind of coordinate: MuJoCo puts the bodies where we have them, to 1e-12."""
    bodies = f"""<body name="a" pos="1 2 3" euler="0.3 0.2 0.1">\
<freejoint name="f"/>{INERTIA}<body name="b" pos="0 0 1">
      <joint name="j" ref="0.4"/><joint name="s" type="slide" ref="-0.2"/>{INERTIA}<body name="c">\
<joint name="ball" type="ball"/>{INERTIA}
      </body></body></body>"""
    poses = {
        "other": "0 0 0 1 0 0 0 0 0 1 0 0 0",
        "home": "1 0.5 2 0.8 0.1 0.2 0.3 0.9 0.3 0.5 0.4 -0.6 0.2",
    }
    keys = "".join(f'<key name="{name}" qpos="{qpos}"/>' for name, qpos in poses.items())
    parts, engine = read(
        tmp_path, model(bodies, f'<keyframe>{keys}<key qpos="{poses["home"]}"/></keyframe>')
    )
    assert_allclose(parts.q0, parts.model.referenceConfigurations["home"], rtol=0, atol=0)
    for number, name in enumerate(poses):
        theirs = mujoco.MjData(engine)
        mujoco.mj_resetDataKeyframe(engine, theirs, number)
        mujoco.mj_forward(engine, theirs)
        data = parts.model.createData()
        pin.framesForwardKinematics(parts.model, data, parts.model.referenceConfigurations[name])
        for body in "abc":
            place = data.oMf[parts.model.getFrameId(body, pin.FrameType.BODY)]
            assert_allclose(place.translation, theirs.body(body).xpos, rtol=0, atol=1e-12)
            assert_allclose(place.rotation.ravel(), theirs.body(body).xmat, rtol=0, atol=1e-12)


# Loops


TREE = f"""<body name="a" pos="0.1 0.2 0.3" euler="0.3 0.2 0.1">\
<joint name="j1" pos="0.1 0 0.2" axis="0 1 1" ref="0.4"/>{INERTIA}
    <site name="sa" pos="0.1 0.2 0.3" euler="1 0 0.5"/>
    <body name="b" pos="0 0 0.5"><joint name="j2" pos="0 0.1 0" axis="1 0 0"/>{INERTIA}</body>\
</body>
  <body name="c" pos="0.5 0 0.1" euler="0 1 0"><joint name="j3" pos="0.2 0 0"/>{INERTIA}
    <body name="d" pos="0.2 0.3 0"><joint name="j4" type="slide"/>{INERTIA}<site name="sd" pos="0 \
0.2 0.3" euler="0 1 0.5"/></body>
    <body name="e" pos="0 0 1" euler="0 0 1">{INERTIA}</body></body>
  <site name="sw" pos="1 1 0" euler="0.2 0.5 0"/>"""
POINTS = [
    '<connect body1="b" body2="d" anchor="0.1 0.2 0.3"/>',
    '<connect body1="d" body2="b" anchor="0.1 0.2 0.3"/>',
    '<connect name="to_the_world" body1="e" anchor="0.1 0.2 0.3"/>',
    '<connect body1="world" body2="b" anchor="0.1 0.2 0.3"/>',
    '<connect site1="sa" site2="sd"/>',
    '<connect site1="sd" site2="sw"/>',
]
FRAMES = [
    '<weld body1="b" body2="d"/>',
    '<weld body1="b" body2="e" anchor="0.2 0.1 0"/>',
    '<weld body1="a"/>',
    '<weld body1="b" body2="d" relpose="0.1 0.2 0.3 1 0.4 0.3 0.2"/>',
    '<weld body1="b" body2="d" relpose="0.1 0.2 0.3 0 0 0 0"/>',
    '<weld body1="b" body2="e" relpose="0.1 0.2 0.3 1 0.4 0.3 0.2" anchor="0.3 0.2 0.1"/>',
    '<weld site1="sa" site2="sd"/>',
    '<weld site1="sw" site2="sa"/>',
]


def openings(parts: RobotParts, q: Array) -> tuple[Array, Array, Array]:
    """Return by how much each loop is open.

    The vector between its points in world axes, its length, and the angle between its frames.
    """
    data = parts.model.createData()
    pin.forwardKinematics(parts.model, data, q)
    vectors, angles = [], []
    for loop in parts.constraint_models:
        first, second = (
            data.oMi[loop.joint1_id] * loop.joint1_placement,
            data.oMi[loop.joint2_id] * loop.joint2_placement,
        )
        vectors.append(second.translation - first.translation)
        angles.append(np.linalg.norm(pin.log3(first.rotation.T @ second.rotation)))
    return np.array(vectors), np.linalg.norm(vectors, axis=-1), np.array(angles)


@pytest.mark.parametrize("equality", POINTS + FRAMES)
def test_loops_are_open_by_as_much(tmp_path: Path, equality: str) -> None:
    """Of configurations of no special kind.

    The vector between the points, and the sine of half the angle, to 1e-12.

    MuJoCo's residual is in world axes; of a weld, the vector part of the quaternion between the
    frames.
    """
    parts, engine = read(tmp_path, model(TREE, f"<equality>{equality}</equality>"))
    assert_same(parts, engine)
    assert len(parts.constraint_models) == 1
    rng = np.random.default_rng(1)
    for _ in range(5):
        q = rng.normal(size=parts.model.nq)
        theirs, _ = in_mujoco(parts, engine, q, np.zeros(parts.model.nv))
        residual = theirs.efc_pos[: theirs.ne]
        (vector,), _, (angle,) = openings(parts, q)
        assert_allclose(-residual[:3], vector, rtol=0, atol=1e-12)
        if equality in FRAMES:
            assert residual.size == 6
            assert_allclose(
                np.linalg.norm(residual[3:]), np.abs(np.sin(0.5 * angle)), rtol=0, atol=1e-12
            )


def test_which_loops_are_active(tmp_path: Path) -> None:
    """Their order is that of the file, and their names are theirs, or those of the bodies."""
    default = (
        '<default><equality active="false"/><default class="on"><equality '
        'active="true"/></default></default>'
    )
    equality = """<equality><connect class="on" name="first" body1="b" body2="d" anchor="0 0 0"/>\
<weld body1="a" body2="d"/>
      <joint joint1="j1" joint2="j2"/><weld class="on" body1="b" body2="c"/></equality>"""
    parts, engine = read(tmp_path, model(TREE, default, equality))
    assert [loop.name for loop in parts.constraint_models] == ["first", "b-c"]
    assert list(engine.eq_active0) == [1, 0, 0, 1]


FOUR_BAR = f"""<body name="crank"><joint name="crank"/>{INERTIA}
    <body name="coupler" pos="0.2 0 0"><joint name="coupler"/>{INERTIA}<site name="tip" pos="0.35 \
0 0.01"/></body></body>
  <body name="rocker" pos="0.45 0 0"><joint name="rocker" ref="0.5"/>{INERTIA}
    <body name="end" pos="0.4 0 0.01"><joint name="pin"/>{INERTIA}<site name="top"/></body>\
</body>"""
CLOSED = [
    '<equality><connect site1="tip" site2="top"/></equality>',
    '<equality><weld body1="coupler" body2="end" relpose="0.35 0 0.01 1 0 0 0"/></equality>',
]


@pytest.mark.parametrize("equality", CLOSED)
def test_a_linkage_closes_and_moves_as_in_mujoco(tmp_path: Path, equality: str) -> None:
    """MuJoCo agrees that the loops are closed, to 1e-12.

    M, C v and G of its tree on the null space of its constraints, to 1e-8 relative.

    The rate of the null space is a derivative of eighth order, good to 1e-10. The fourth hinge is
    idle where a point closes the linkage, so there it is a motor of its own.
    """
    motors = ["crank", "pin"] if "connect" in equality else ["crank"]
    actuators = "".join(f'<motor joint="{name}"/><position joint="{name}"/>' for name in motors)
    option = '<option gravity="1 -7 -3"/>'
    key = '<keyframe><key name="home" qpos="1 -0.6 1.7 -0.8"/></keyframe>'
    path = tmp_path / "four_bar.xml"
    path.write_text(model(FOUR_BAR, option, equality, f"<actuator>{actuators}</actuator>", key))
    parts = read_mjcf(path)
    assert parts.actuated == tuple(motors)
    robot, engine = ClosedLoopRobot(*parts), mujoco.MjModel.from_xml_path(str(path))
    rng = np.random.default_rng(2)
    for _ in range(5):
        positions = robot.q0[
            [parts.model.joints[parts.model.getJointId(name)].idx_q for name in motors]
        ] + rng.uniform(-0.3, 0.3, len(motors))
        speeds = rng.normal(size=len(motors))
        q, v = robot.configuration(positions), robot.velocity(positions, speeds)
        still, change = in_mujoco(parts, engine, q, np.zeros(parts.model.nv))
        assert np.abs(still.efc_pos[: still.ne]).max() < 1e-12
        jacobian = still.efc_J.reshape(-1, engine.nv)[: still.ne] @ change
        _, values, right = np.linalg.svd(jacobian)
        null = right[np.count_nonzero(values > 1e-9 * values[0]) :].T
        motor_rows = null[
            [parts.model.joints[parts.model.getJointId(name)].idx_v for name in motors]
        ]
        L = null @ np.linalg.inv(motor_rows)
        assert_allclose(L @ speeds, v, rtol=0, atol=1e-9)
        mass, coriolis, gravity = robot.equation_of_motion(positions, speeds)
        tree = change.T @ mass_matrix(engine, still) @ change
        assert_allclose(mass, L.T @ tree @ L, rtol=0, atol=1e-8 * np.abs(mass).max())
        assert_allclose(
            gravity, L.T @ change.T @ still.qfrc_bias, rtol=0, atol=1e-8 * np.abs(gravity).max()
        )
        moving, _ = in_mujoco(parts, engine, q, v)
        # The accelerations at constant motor speeds.
        rate = derivative(
            lambda time, at=positions, along=speeds: robot.velocity(at + time * along, along), 1e-2
        )
        forces = L.T @ (change.T @ (moving.qfrc_bias - still.qfrc_bias) + tree @ rate)
        assert_allclose(
            coriolis @ speeds, forces, rtol=0, atol=1e-8 * max(np.abs(forces).max(), 1.0)
        )


def test_what_is_not_read_of_the_forces_is_logged(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    body = (
        f'<body name="a" gravcomp="1"><joint name="j" type="ball" stiffness="3"/>{INERTIA}</body>'
    )
    body += f'<body name="b"><joint name="k"/>{INERTIA}</body>'
    with caplog.at_level(logging.WARNING, "psp3"):
        read(
            tmp_path,
            model(
                body,
                '<option density="1.2"/>',
                '<tendon><fixed name="t" stiffness="1"><joint joint="k" coef="1"/></fixed>'
                "</tendon>",
            ),
        )
    assert (
        "does not know: spring of joint j, tendon t, buoyancy of body a, fluid (density)"
        in caplog.text
    )
