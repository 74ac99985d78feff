"""Robots from SDF files move as the joints of the file, taken as constraints of free bodies."""

from __future__ import annotations

import logging
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

import psp3
from psp3.description.sdf import read_sdf
from psp3.errors import InvalidRobotFile
from psp3.multibody.equations import Coupling, Hinge
from tests.free_bodies import Gear, compared
from tests.psp3.description import sdf_mechanisms as made

TOLERANCE = 1e-11
"""Relative; both sides solve linear systems with rounding of 1e-16 and conditions of up to 1e3."""

DAMPED = {"damping": (0.3,), "friction": (0.1,), "stiffness": (0.7,), "rest": (0.2,)}
LIMITED = (
    "<limit><lower>-1</lower><upper>1.5</upper><effort>3</effort><velocity>4</velocity></limit>"
)


def damped_slider() -> tuple[list[made.Link], list[made.Hung]]:
    """Return a slider-crank of which every joint has damping, so that a copy closes it."""
    links, joints = made.slider_crank("slide")
    return links, [joint._replace(damping=(0.4,)) for joint in joints]


def load(
    directory: Path,
    mechanism: tuple[list[made.Link], list[made.Hung]],
    actuated: list[str],
    version: str = "1.9",
) -> psp3.ClosedLoopRobot:
    """Return the robot of a mechanism that is written to a file."""
    path = directory / "robot.sdf"
    path.write_text(made.sdf(*mechanism, version), encoding="utf-8")
    return psp3.ClosedLoopRobot.from_sdf(path, actuated)


Mechanism = Callable[[], tuple[list[made.Link], list[made.Hung]]]


@pytest.mark.parametrize(
    ("mechanism", "actuated", "freedoms"),
    [
        (made.four_bar, ["A"], 1),
        (made.four_bar, ["C"], 1),
        (lambda: made.four_bar(**DAMPED), ["A"], 1),
        (lambda: made.four_bar(LIMITED), ["D"], 1),
        (lambda: made.slider_crank("slide"), ["A"], 1),
        (lambda: made.slider_crank("pin"), ["slide"], 1),
        (damped_slider, ["A"], 1),
        (made.rod, ["crank_joint"], 2),
        (lambda: made.rod(damping=(0.2,)), ["crank_joint"], 2),
        (lambda: made.rod("universal"), ["crank_joint"], 1),
        (lambda: made.rod("revolute2"), ["rocker_joint"], 1),
        (made.floating, ["A", "screw"], 8),
    ],
)
@pytest.mark.parametrize("version", ["1.6", "1.9"])
def test_dynamics_are_those_of_free_bodies(
    mechanism: Mechanism, actuated: list[str], freedoms: int, version: str, tmp_path: Path
) -> None:
    described = mechanism()
    robot = load(tmp_path, described, actuated, version)
    assert robot.mobility.degrees_of_freedom == freedoms
    rng = np.random.default_rng(len(actuated))
    found = compared(robot, made.free_bodies(*described), rng, reach=0.05)
    assert max(found) < TOLERANCE, found


def test_gearbox_couples_the_angles_from_its_reference_body(tmp_path: Path) -> None:
    described = made.geared()
    robot = load(tmp_path, described, ["motor", "foot"])
    # From the base, the rotor turns by −motor about the gearbox's axis, the arm by −elbow about
    # axis2; the second is −0.2 times the first.
    mechanism = made.free_bodies(*described, [Gear("elbow", "motor", -0.2)])
    found = compared(robot, mechanism, np.random.default_rng(3), reach=0.3)
    assert max(found) < TOLERANCE, found
    q = robot.configuration([0.5, 0.0])
    elbow = robot.model.joints[robot.model.getJointId("elbow")].idx_q
    assert_allclose(q[elbow], -0.1, atol=1e-12)


def test_mimicking_axis_follows_with_offset_and_reference(tmp_path: Path) -> None:
    links, joints = made.geared()
    mimic = (
        '<mimic joint="motor"><multiplier>-3</multiplier><offset>0.4</offset><reference>0.1'
        "</reference></mimic>"
    )
    joints = [joints[0], joints[1], joints[2]._replace(more=(mimic, ""))]
    robot = load(tmp_path, (links, joints), ["motor", "foot"], "1.11")
    q = robot.configuration([0.5, 0.0])
    elbow = robot.model.joints[robot.model.getJointId("elbow")].idx_q
    assert_allclose(q[elbow], -3.0 * (0.5 - 0.1) + 0.4, atol=1e-12)


def test_older_thread_pitch_is_left_handed_and_in_radians_per_meter(tmp_path: Path) -> None:
    links, joints = made.floating()
    old = "<thread_pitch>-20</thread_pitch>"
    joints = [*joints[:-1], joints[-1]._replace(element=old, pitch=0.05)]
    robot = load(tmp_path, (links, joints), ["A", "screw"], "1.6")
    mechanism = made.free_bodies(links, joints)
    found = compared(robot, mechanism, np.random.default_rng(1), reach=0.1)
    assert max(found) < TOLERANCE, found


@pytest.mark.parametrize("name", ["five_bar", "planar_3rrr", "gough_stewart"])
def test_twins_of_shipped_robots_have_the_same_dynamics(name: str, tmp_path: Path) -> None:
    robot = psp3.load(name)
    path = tmp_path / "twin.sdf"
    path.write_text(twin(robot), encoding="utf-8")
    other = psp3.ClosedLoopRobot.from_sdf(path, robot.actuated)
    rng = np.random.default_rng(0)
    # The twin's coordinates are zero where the shipped robot is at home.
    for _ in range(3):
        step = rng.uniform(-0.05, 0.05, len(robot.reference))
        speeds = rng.uniform(-1.0, 1.0, len(step))
        one = robot.equation_of_motion(robot.reference + step, speeds)
        two = other.equation_of_motion(step, speeds)
        for ours, theirs in zip(one, two, strict=True):
            assert_allclose(theirs, ours, rtol=0.0, atol=1e-12 * max(1.0, np.abs(ours).max()))


def twin(robot: psp3.ClosedLoopRobot) -> str:
    """Return a robot as an SDF file, in its home; its points that coincide as ball joints."""
    model, data = robot.model, robot.model.createData()
    pin.forwardKinematics(model, data, robot.q0)
    text = ""
    for number in range(1, model.njoints):
        inertia = model.inertias[number]
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = inertia.inertia
        entries = {"ixx": xx, "ixy": xy, "ixz": xz, "iyy": yy, "iyz": yz, "izz": zz}
        moments = "".join(f"<{tag}>{float(value)!r}</{tag}>" for tag, value in entries.items())
        text += (
            f'<link name="body{number}">{made.pose(data.oMi[number])}<inertial>'
            f"{made.pose(pin.SE3(np.eye(3), inertia.lever))}<mass>{float(inertia.mass)!r}</mass>"
            f"<inertia>{moments}</inertia></inertial></link>"
        )
        joint = model.joints[number].createData()
        model.joints[number].calc(joint, np.zeros(model.joints[number].nq))
        screw = np.asarray(joint.S).ravel()
        kind = "prismatic" if np.any(screw[:3]) else "revolute"
        axis = screw[:3] if kind == "prismatic" else screw[3:]
        at = model.joints[number].idx_v
        damping = float(model.damping[at])
        friction = float(model.upperDryFrictionLimit[at])
        parent = model.parents[number]
        text += (
            f'<joint name="{model.names[number]}" type="{kind}"><parent>'
            f"{f'body{parent}' if parent else 'world'}</parent><child>body{number}</child><axis>"
            f"<xyz>{' '.join(f'{x:.17g}' for x in axis)}</xyz><dynamics><damping>{damping!r}"
            f"</damping><friction>{friction!r}</friction></dynamics></axis></joint>"
        )
    for number, loop in enumerate(robot.constraint_models):
        assert loop.type == pin.ContactType.CONTACT_3D
        ends = [f"body{end}" if end else "world" for end in (loop.joint1_id, loop.joint2_id)]
        text += (
            f'<joint name="loop{number}" type="ball"><parent>{ends[0]}</parent><child>{ends[1]}'
            f"</child>{made.pose(loop.joint2_placement)}</joint>"
        )
    return f'<sdf version="1.9"><model name="{robot.title}">{text}</model></sdf>'


def test_numbers_of_joints_are_those_of_the_file(tmp_path: Path) -> None:
    more = LIMITED.replace("-1<", "-1e16<").replace("1.5<", " inf <")
    links, joints = made.four_bar(more, **DAMPED)
    path = tmp_path / "robot.sdf"
    path.write_text(made.sdf(links, joints), encoding="utf-8")
    parts = read_sdf(path, ["A"])
    at = parts.model.joints[parts.model.getJointId("A")].idx_v
    assert parts.model.lowerPositionLimit[at] == -np.inf
    assert parts.model.upperPositionLimit[at] == np.inf
    assert (parts.model.upperEffortLimit[at], parts.model.upperVelocityLimit[at]) == (3.0, 4.0)
    assert (parts.model.damping[at], parts.model.upperDryFrictionLimit[at]) == (0.3, 0.1)
    assert parts.springs == dict.fromkeys("ABCD", (0.7, 0.2))


def test_a_plain_hinge_closes_a_loop_as_a_hinge_and_one_with_forces_stays(tmp_path: Path) -> None:
    path = tmp_path / "robot.sdf"
    links, joints = made.four_bar()
    path.write_text(made.sdf(links, joints), encoding="utf-8")
    parts = read_sdf(path, ["A"])
    (hinge,) = parts.equations
    assert isinstance(hinge, Hinge)
    assert hinge.name == "C"
    assert list(parts.model.names)[1:] == ["A", "B", "D"]
    # With damping in the joint that would be cut, a plain one is cut instead.
    joints[-1] = joints[-1]._replace(damping=(0.1,))
    path.write_text(made.sdf(links, joints), encoding="utf-8")
    parts = read_sdf(path, ["A"])
    assert [one.name for one in parts.equations] == ["B"]


def test_welded_links_are_one_body_also_in_a_loop(tmp_path: Path) -> None:
    links, joints = made.four_bar()
    half = links[1]._replace(name="half", place=links[1].place * made.place(0.1, 0.1, 0.0))
    weld = made.Hung("weld", "fixed", "coupler", "half", half.place)
    joints[-1] = joints[-1]._replace(child="half")
    described = [*links, half], [*joints, weld]
    robot = load(tmp_path, described, ["A"])
    assert robot.model.njoints == 4
    found = compared(robot, made.free_bodies(*described), np.random.default_rng(1), reach=0.1)
    assert max(found) < TOLERANCE, found


def test_a_second_part_that_floats_is_held_where_it_is(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    links, joints = made.floating()
    loose = made.link("loose", made.place(1.0, 2.0, 3.0))
    robot = load(tmp_path, ([loose, *links], joints), ["A", "screw"])
    assert robot.coordinates == ("A", "screw", "root_joint")
    assert len(robot.locked) == 6
    assert "loose_root_joint_x" in caplog.text
    frame = robot.model.getFrameId("trunk", pin.FrameType.BODY)
    base = robot.model.joints[robot.model.getJointId("root_joint")].id
    assert robot.model.frames[frame].parentJoint == base


# What is said, and what is refused

BODY = "<inertial><mass>2</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>"
HINGE = (
    '<joint name="j" type="revolute"><parent>world</parent><child>a</child>'
    "<axis><xyz>0 1 0</xyz></axis></joint>"
)


def model(*parts: str, version: str = "1.9") -> str:
    """Return a file with one model."""
    return f'<sdf version="{version}"><model name="m">{"".join(parts)}</model></sdf>'


def read(directory: Path, text: str, actuated: list[str] | None = None) -> psp3.ClosedLoopRobot:
    """Return a robot of a text."""
    path = directory / "robot.sdf"
    path.write_text(text, encoding="utf-8")
    return psp3.ClosedLoopRobot.from_sdf(path, ["j"] if actuated is None else actuated)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (model(), "no <link>"),
        (model(f'<link name="a">{BODY}</link>', HINGE.replace("revolute", "hinge")), "'hinge'"),
        (model(f'<link name="a">{BODY}</link>', HINGE.replace(">a<", ">b<")), "'b'"),
        (model(f'<link name="a">{BODY}</link>', HINGE.replace("0 1 0", "0 0 0")), "no direction"),
        (model(f'<link name="a">{BODY}</link>', HINGE.replace("0 1 0", "0 1 ٠")), "finite numbers"),
        (model(f'<link name="a">{BODY}</link>', HINGE.replace("axis", "axes")), "needs an <axis>"),
        (
            model(f'<link name="a">{BODY}</link>', HINGE.replace("revolute", "universal")),
            "needs an <axis2>",
        ),
        (
            model(f'<link name="a">{BODY}</link>', HINGE.replace("revolute", "screw")),
            "thread_pitch",
        ),
        (model(f'<link name="a">{BODY}</link>' * 2, HINGE), "two of 'a'"),
        (model(f'<link name="a">{BODY.replace("2", "-2")}</link>', HINGE), "mass -2 is negative"),
        (model(f'<link name="a">{BODY.replace("2", "1_0")}</link>', HINGE), "'1_0'"),
        (model(f'<link name="a">{BODY.replace("2", "0x10")}</link>', HINGE), "'0x10'"),
        (model(f'<link name="a">{BODY.replace("2", "inf")}</link>', HINGE), "'inf'"),
        (model(f'<link name="a">{BODY.replace("2", "2 3")}</link>', HINGE), "'2 3'"),
        (
            model(f'<link name="a"><inertial auto="true">{BODY}</inertial></link>', HINGE),
            "expand-auto-inertials",
        ),
        (model(f'<link name="a"><kinematic>1</kinematic>{BODY}</link>', HINGE), "kinematic"),
        (
            model(
                f'<link name="a">{BODY}</link>',
                HINGE.replace("</xyz>", "</xyz><limit><lower>1</lower><upper>0</upper></limit>"),
            ),
            "above its upper",
        ),
        (
            model(
                f'<link name="a">{BODY}</link>',
                HINGE.replace("</xyz>", "</xyz><dynamics><damping>-1</damping></dynamics>"),
            ),
            "damping -1 is negative",
        ),
        (model(f'<link name="a">{BODY}</link>', HINGE, '<drake:joint name="x"/>'), "drake:joint"),
        (
            model(
                f'<link name="a">{BODY}</link>',
                HINGE,
                '<joint name="g" type="gearbox"><parent>a</parent><child>b</child><axis/><axis2/>'
                "<gearbox_reference_body>world</gearbox_reference_body></joint>",
                f'<link name="b">{BODY}</link>',
            ),
            "no revolute joint about its axis ",
        ),
        ("<robot name='m'/>", "from_urdf"),
    ],
)
def test_what_is_wrong_is_named(text: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(InvalidRobotFile) as caught:
        read(tmp_path, text)
    assert said in caught.value.reason


def test_without_motors_the_joints_are_named(tmp_path: Path) -> None:
    path = tmp_path / "robot.sdf"
    path.write_text(model(f'<link name="a">{BODY}</link>', HINGE), encoding="utf-8")
    with pytest.raises(InvalidRobotFile, match=r"actuated=\[\.\.\.\]\), of j"):
        psp3.ClosedLoopRobot.from_sdf(path)
    with pytest.raises(InvalidRobotFile, match="its joints are j"):
        psp3.ClosedLoopRobot.from_sdf(path, ["k"])


def test_a_static_joint_cannot_be_actuated(tmp_path: Path) -> None:
    text = model("<static>1</static>", f'<link name="a">{BODY}</link>', HINGE)
    with pytest.raises(InvalidRobotFile, match="welded or static"):
        read(tmp_path, text)


def test_a_link_without_inertia_has_that_of_the_format(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    robot = read(tmp_path, model('<link name="a"/>', HINGE))
    assert_allclose(robot.mass_matrix([0.3]), [[1.0]])
    assert "1 kg and 1 kg m²: a" in caplog.text


def test_what_is_left_out_is_logged(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    link = (
        '<link name="a"><gravity>false</gravity><enable_wind>true</enable_wind><velocity_decay>'
        f"<linear>0.1</linear></velocity_decay>{BODY}</link>"
    )
    ball = (
        '<joint name="b" type="ball"><parent>a</parent><child>c</child><axis><dynamics>'
        "<friction>1</friction></dynamics></axis></joint>"
    )
    path = tmp_path / "robot.sdf"
    path.write_text(model(link, HINGE, ball, f'<link name="c">{BODY}</link>'), encoding="utf-8")
    with caplog.at_level(logging.WARNING):
        read_sdf(path, ["j"])
    for said in ("lack of gravity of link a", "wind", "drag", "dry friction of ball joint b"):
        assert said in caplog.text


def test_gravity_is_that_of_the_world(tmp_path: Path) -> None:
    inner = model(f'<link name="a">{BODY}</link>', HINGE).split(">", 1)[1].removesuffix("</sdf>")
    for version, world, expected in (
        ("1.9", "<gravity>0 1 -2</gravity>", [0.0, 1.0, -2.0]),
        ("1.5", "<physics><gravity>0 1 -2</gravity></physics>", [0.0, 1.0, -2.0]),
        ("1.9", "", [0.0, 0.0, -9.8]),
    ):
        text = f'<sdf version="{version}"><world name="w">{world}{inner}</world></sdf>'
        assert_allclose(read(tmp_path, text).model.gravity.linear, expected)
    alone = read(tmp_path, model(f'<link name="a">{BODY}</link>', HINGE))
    assert_allclose(alone.model.gravity.linear, [0.0, 0.0, -9.81])


def test_shapes_are_where_the_file_has_them(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    visuals = "".join(
        f'<visual name="{n}"><pose>{n} 0 0 0 0 0</pose><geometry>{shape}</geometry><material>'
        "<diffuse>1 0 0 1</diffuse></material></visual>"
        for n, shape in enumerate(
            (
                "<box><size>1 2 3</size></box>",
                "<cylinder><radius>1</radius><length>2</length></cylinder>",
                "<plane/>",
                "<mesh><uri>nowhere.stl</uri></mesh>",
            )
        )
    )
    robot = read(
        tmp_path, model(f'<link name="a"><pose>0 0 5 0 0 0</pose>{visuals}{BODY}</link>', HINGE)
    )
    shapes = list(robot.visual_model.geometryObjects)
    assert [shape.name for shape in shapes] == ["a_0", "a_1"]
    assert_allclose(shapes[1].placement.translation, [1.0, 0.0, 0.0])
    assert_allclose(shapes[1].meshColor, [1.0, 0.0, 0.0, 1.0])
    assert "nowhere.stl (no such file)" in caplog.text
    with pytest.raises(InvalidRobotFile, match="positive <radius>"):
        read(tmp_path, model(f'<link name="a">{visuals.replace(">1<", ">0<")}{BODY}</link>', HINGE))


def test_couplings_name_their_joints(tmp_path: Path) -> None:
    robot = load(tmp_path, made.geared(), ["motor", "foot"])
    (gear,) = [one for one in robot.equations if isinstance(one, Coupling)]
    assert gear.name == "gear"
    assert (robot.model.names[gear.y], robot.model.names[gear.x]) == ("elbow", "motor")
