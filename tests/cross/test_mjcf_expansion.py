"""What stands for several elements of an MJCF file is written out as MuJoCo does.

Each a small file of a kind that people have, with masses, inertias, places, mass matrices and
forces of the tree, and the gaps of its loops, compared with what MuJoCo compiles.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

from psp3.description.mjcf import read_mjcf
from psp3.description.mujoco_opinion import mujoco_disagreements
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.cross.test_mjcf_files import INERTIA, assert_same, in_mujoco, model, read

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is in the extras mujoco and test")

ARM = f'<body name="a" pos=".3 0 .1"><joint name="j" axis="1 2 0" pos="0 .1 0"/>{INERTIA}'

TREES = {
    "frames in each other, around everything": """<frame pos="0 0 1" euler="10 70 0">
      <frame euler="0 0 40" childclass="heavy"><body name="a" pos=".3 0 .1" euler="20 0 0">
        <frame pos=".1 .2 0" axisangle="1 1 0 50"><joint name="j" axis="1 2 0" pos="0 .1 0"/>
          <geom type="capsule" size=".1" fromto="0 0 0 .2 .3 .4"/>\
<geom size=".1" fromto=".1 0 0 .2 .3 .9"/><geom size=".1 .2 .3"/>
          <site name="s" pos="1 0 0" zaxis="1 1 1"/>\
<site name="t" type="capsule" size=".1" fromto="0 0 0 1 2 3"/></frame>
      </body></frame></frame>""",
    "an inertia in a frame": f"""<body name="a"><frame pos="0 .1 0" euler="0 30 0">{INERTIA}\
<joint/></frame></body>""",
    "copies that turn": f"""<replicate count="11" sep="-" offset=".3 .1 0" euler="0 0 33">
      <body name="a" pos=".5 0 0"><joint name="j" axis="0 1 0"/>{INERTIA}<site name="s"/></body>
      <site name="w" pos="1 0 0"/></replicate>""",
    "copies of copies in a frame": f"""<frame euler="0 20 0"><replicate count="2" offset="0 0 1">
      <replicate count="3" sep="_" offset=".5 0 0" euler="30 0 0">{ARM}</body></replicate>
      </replicate></frame>""",
    "copies in a body": f"""{ARM}<replicate count="2" offset="0 .4 0" euler="0 90 0">
      <body name="b" pos="0 0 .2"><joint name="k"/>{INERTIA}</body>
      <geom size=".1 .1 .2" pos="0 0 1"/></replicate></body>""",
    "no copies": f'{ARM}<replicate count="0"><geom size="1"/></replicate></body>',
}

CLASSES = """<default><geom type="box"/><default class="heavy"><geom density="3000"/>\
<joint armature=".3"/></default></default>"""


@pytest.mark.parametrize("angle", ["degree", "radian"])
@pytest.mark.parametrize("kind", list(TREES))
def test_frames_and_copies(tmp_path: Path, kind: str, angle: str) -> None:
    text = model(TREES[kind], CLASSES, compiler=f'angle="{angle}" eulerseq="zxy"')
    assert_same(*read(tmp_path, text))
    assert mujoco_disagreements(tmp_path / "robot.xml") == []


def test_joints_that_mjcf_names_are_the_motors_of_copies(tmp_path: Path) -> None:
    text = model(
        f'<replicate count="2" offset="1 0 0">{ARM}</body></replicate>',
        '<actuator><motor joint="j1"/><motor joint="j0"/></actuator>',
    )
    path = tmp_path / "robot.xml"
    path.write_text(text)
    assert read_mjcf(path).actuated == ("j1", "j0")


CHILD = f"""<mujoco model="kid">
  <compiler angle="radian" eulerseq="zyx" boundmass="3" balanceinertia="true" autolimits="false"/>
  <default><joint armature="2"/><default class="quick"><joint damping="3"/></default></default>
  <asset><mesh name="m" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset>
  <worldbody><site name="foot" pos="0 1 0"/><frame name="F" pos="5 0 0">
    <body name="a" pos="1 0 0" euler="0.2 0.4 1" childclass="quick">
      <joint name="j" range="0 1" limited="true" axis="0 1 0"/>{INERTIA}
      <body name="in" pos="0 0 .3"><joint name="i" axis="1 0 0" ref=".2"/>
        <geom type="mesh" mesh="m" density="20"/><site name="tip" pos="0 0 .2"/></body></body>
    </frame>
    <body name="b"><joint name="k" type="slide"/>{INERTIA}</body></worldbody>
  <tendon><fixed name="t"><joint joint="j" coef="1"/><joint joint="i" coef="-2"/></fixed></tendon>
  <equality><joint joint1="j" joint2="i" polycoef="0 1 .5 0 0"/><joint joint1="j" joint2="k"/>
    <connect site1="tip" site2="foot"/><connect body1="in" body2="a" anchor="0 0 .1"/></equality>
  <actuator><motor joint="i"/><motor joint="k" name="mk"/><motor tendon="t"/></actuator>
</mujoco>"""

ATTACHED = {
    "a body": '<frame pos="0 1 1" euler="0 0 9"><attach model="{0}" body="a" prefix="L-"/></frame>',
    "a frame": '<attach model="{0}" frame="F" prefix="L-"/>',
    "all of it": '<attach model="{0}" prefix="L-"/>',
    "two of it": (
        '<attach model="{0}" body="a" prefix="L-"/><frame euler="90 0 0"><attach model="{0}" '
        'prefix="R-"/></frame>'
    ),
}


@pytest.mark.parametrize("named", [True, False])
@pytest.mark.parametrize("kind", list(ATTACHED))
def test_attached_models(tmp_path: Path, kind: str, named: bool) -> None:
    """With classes, settings and units of their own, and what refers to attached elements alone."""
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "kid.xml").write_text(CHILD)
    name = 'name="other"' if named else ""
    text = model(
        f"{ARM}{ATTACHED[kind].format('other' if named else 'kid')}</body>",
        '<default><joint armature="7"/></default>',
        f'<asset><model {name} file="parts/kid.xml"/></asset>',
        '<actuator><motor joint="j"/></actuator>',
        compiler='angle="degree"',
    )
    parts, engine = read(tmp_path, text)
    assert_same(parts, engine)
    assert mujoco_disagreements(tmp_path / "robot.xml") == []
    kinds = [int(kind) for kind in engine.eq_type]
    assert len(parts.equations) == kinds.count(int(mujoco.mjtEq.mjEQ_JOINT))
    assert len(parts.constraint_models) == kinds.count(int(mujoco.mjtEq.mjEQ_CONNECT))
    names = [
        engine.joint(engine.actuator_trnid[number, 0]).name
        if engine.actuator_trntype[number] == mujoco.mjtTrn.mjTRN_JOINT
        else engine.tendon(engine.actuator_trnid[number, 0]).name
        for number in range(engine.nu)
    ]
    assert read_mjcf(tmp_path / "robot.xml").actuated == tuple(names)
    # Armature, damping and limits are those of the files that the joints come from.
    for number in range(engine.njnt):
        joint = parts.model.joints[parts.model.getJointId(engine.joint(number).name)]
        own = engine.jnt_dofadr[number]
        assert parts.model.armature[joint.idx_v] == engine.dof_armature[own]
        assert parts.model.damping[joint.idx_v] == np.ravel(engine.dof_damping)[own]
        limited = np.isfinite(parts.model.upperPositionLimit[joint.idx_q])
        assert limited == bool(engine.jnt_limited[number])


def test_a_part_of_the_file_itself_is_attached_once_more(tmp_path: Path) -> None:
    text = model(
        f'{ARM}</body><frame pos="0 0 2" euler=".4 0 0"><attach body="a" prefix="B"/></frame>',
        '<actuator><motor joint="j"/></actuator>',
    )
    parts, engine = read(tmp_path, text)
    assert_same(parts, engine)
    assert engine.nu == 2
    assert read_mjcf(tmp_path / "robot.xml").actuated == ("j", "Bj")


def test_a_loop_of_a_free_body_closes_where_the_file_has_it(tmp_path: Path) -> None:
    """A table on a free joint, held by three legs at points of its own.

    MuJoCo finds the second point of each loop where the table stands in the file, turned and away
    from the origin. Gaps at random states to 1e-12.
    """
    leg = (
        f'<body name="l{{0}}" pos="{{1}}"><joint type="ball"/>{INERTIA}<body name="p{{0}}" '
        f'pos="0 0 .4"><joint name="slide{{0}}" type="slide"/>{INERTIA}</body></body>'
    )
    table = f'<body name="top" pos=".1 .2 1" euler=".3 .1 .2"><freejoint/>{INERTIA}</body>'
    places = ("0 0 0", "1 0 0", "0 1 .1")
    legs = "".join(leg.format(number, place) for number, place in enumerate(places))
    loops = "".join(
        f'<connect body1="p{number}" body2="top" anchor="0 0 .5"/>' for number in range(3)
    )
    text = model(table + legs, f"<equality>{loops}</equality>")
    parts, engine = read(tmp_path, text)
    assert_same(parts, engine)
    rng = np.random.default_rng(4)
    for _ in range(5):
        q = pin.integrate(
            parts.model, pin.neutral(parts.model), 0.3 * rng.normal(size=parts.model.nv)
        )
        theirs, _ = in_mujoco(parts, engine, q, np.zeros(parts.model.nv))
        data = parts.model.createData()
        pin.forwardKinematics(parts.model, data, q)
        for number, loop in enumerate(parts.constraint_models):
            first = data.oMi[loop.joint1_id] * loop.joint1_placement
            second = data.oMi[loop.joint2_id] * loop.joint2_placement
            gap = theirs.efc_pos[3 * number : 3 * number + 3]
            assert_allclose(first.translation - second.translation, gap, rtol=0, atol=1e-12)
    # Where the file has everything the loops are closed.
    robot = ClosedLoopRobot.from_mjcf(
        tmp_path / "robot.xml", ["slide0", "slide1", "slide2"], free="keep"
    )
    assert_allclose(robot.q0, pin.neutral(robot.model), rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    "compiler",
    [
        'settotalmass="7"',
        'settotalmass="2" boundmass="1"',
        'inertiagrouprange="1 2"',
        'inertiafromgeom="true" inertiagrouprange="0 0"',
    ],
)
def test_settings_of_all_masses(
    tmp_path: Path, compiler: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One body of geoms of several groups, one with an inertia, and one that stands still."""
    # MuJoCo writes a warning of "settotalmass" into a file where it runs.
    monkeypatch.chdir(tmp_path)
    bodies = f"""<body name="a"><joint axis="1 0 0"/><joint axis="0 1 0"/><geom size=".2"/>
      <geom type="box" size=".1 .2 .3" pos="1 0 0" group="1"/>\
<geom type="box" size=".2 .1 .1" pos="0 1 0" group="2"/>
      <body name="b" pos="0 0 1"><joint/><joint axis="1 1 0"/>{INERTIA}\
<geom size=".1" pos="1 0 0"/></body></body>
      <body name="still"><geom type="box" size=".1 .1 .1"/></body>"""
    assert_same(*read(tmp_path, model(bodies, compiler=compiler)))
    assert mujoco_disagreements(tmp_path / "robot.xml") == []


@pytest.mark.parametrize("kind", ["SPHERICAL", "UJOINT_XY", "FIXED"])
def test_joints_stand_for_others(tmp_path: Path, kind: str) -> None:
    """The tree with the other joint written out has the same mass matrix, to 1e-12."""
    other = {
        "SPHERICAL": '<joint name="j" type="ball"/>',
        "UJOINT_XY": '<joint name="j_X" axis="1 0 0"/><joint name="j_Y" axis="0 1 0"/>',
        "FIXED": "",
    }[kind]
    text = model(
        f'<body name="base"><joint name="b"/>{INERTIA}<body name="a" pos=".1 .2 .3" '
        f'euler=".4 .5 .6"><joint name="j" ref=".3"/>{INERTIA}<body name="c" pos="0 0 .3">'
        f'<joint name="k" axis="0 1 0"/>{INERTIA}</body></body></body>'
    )
    path = tmp_path / "robot.xml"
    path.write_text(text)
    found = read_mjcf(path, [], {"j": kind}).model
    (tmp_path / "other").mkdir()
    expected, _ = read(tmp_path / "other", text.replace('<joint name="j" ref=".3"/>', other))
    assert list(found.names) == list(expected.model.names)
    q = pin.integrate(found, pin.neutral(found), np.linspace(0.2, 0.9, found.nv))
    one, two = (pin.crba(tree, tree.createData(), q) for tree in (found, expected.model))
    assert_allclose(np.triu(one), np.triu(two), rtol=0, atol=1e-12)
    robot = ClosedLoopRobot.from_mjcf(path, ["k"], joint_type={"j": "FIXED"})
    assert "j" not in robot.model.names
