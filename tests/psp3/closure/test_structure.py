"""Rank and mismatch of closure equations: rounded loops, singular poses, starts without a home."""

from __future__ import annotations

import logging
import time
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

import psp3
from psp3.closure.mobility import mobility
from psp3.closure.structure import (
    LARGEST_MISMATCH,
    TOLD_MISMATCH,
    Structure,
    _Equations,
    robot_size,
    structure,
)
from psp3.errors import LoopsDoNotClose, MobilityMismatch, RoundedLoops
from psp3.multibody.flatten import NO_MOTORS, flattened
from tests.helpers import Array
from tests.psp3.closure.rounded import (
    EXACT,
    LINKAGES,
    Parts,
    flat_triangle,
    four_bar,
    in_plane,
    short_lever,
    small_four_bar,
)

DIGITS = (4, 5, 6, 8, 10, 12)


def robot_of(parts: Parts, **options: Any) -> psp3.ClosedLoopRobot:
    return psp3.ClosedLoopRobot(
        parts.model, parts.loops, parts.motors, np.zeros(parts.model.nq), **options
    )


@pytest.mark.parametrize("name", list(LINKAGES))
@pytest.mark.parametrize("digits", DIGITS)
def test_rounded_loops_load_and_move_as_the_exact_robot(name: str, digits: int) -> None:
    """Of the same rank, with accelerations and forces within 100 units of the last digit.

    Three ways of turning the frames about their axes, four states each. About 30 were seen, the
    bar asks for 100.
    """
    builder, freedoms, rank = LINKAGES[name]
    for seed in range(3):
        exact, found = robot_of(builder(EXACT, seed)), robot_of(builder(digits, seed))
        for robot in (exact, found):
            assert (robot.mobility.degrees_of_freedom, robot.mobility.rank) == (freedoms, rank)
            assert robot.mobility.commanded == freedoms
        assert exact.closure_mismatch.length < 1e-13
        assert 0.0 < found.closure_mismatch.length < 10.0 * 10.0**-digits
        assert found.closure_mismatch.home_moved < 100.0 * 10.0**-digits
        rng = np.random.default_rng(0)
        for _ in range(4):
            x, s, a, tau = rng.uniform(-1.0, 1.0, (4, freedoms))
            for question, third in (("forward_dynamics", tau), ("inverse_dynamics", a)):
                ours = getattr(found, question)(0.2 * x, s, third)
                theirs = getattr(exact, question)(0.2 * x, s, third)
                error = np.abs(ours - theirs).max() / np.abs(theirs).max()
                assert error < 100.0 * 10.0**-digits


@pytest.mark.parametrize("name", list(LINKAGES))
@given(digits=st.sampled_from(DIGITS), seed=st.integers(0, 9), data=st.data())
def test_the_freedoms_do_not_depend_on_which_joints_are_motors(
    name: str, digits: int, seed: int, data: st.DataObject
) -> None:
    builder, freedoms, rank = LINKAGES[name]
    parts = builder(digits, seed)
    joints = list(parts.model.names)[1:]
    chosen = data.draw(st.lists(st.sampled_from(joints), unique=True))
    found = mobility(parts.model, parts.loops, chosen, np.zeros(parts.model.nq))
    assert (found.degrees_of_freedom, found.rank) == (freedoms, rank)


@pytest.mark.parametrize("digits", [EXACT, 12, 8, 6])
@pytest.mark.parametrize(
    "motors", [["large crank"], ["small crank"], ["small crank", "small rocker"]]
)
def test_a_small_loop_in_a_large_robot_is_no_rounding(digits: int, motors: list[str]) -> None:
    """Its equations are weak in the size of the robot, by 1e-3, and strong in their own."""
    parts = small_four_bar(digits)
    found = mobility(parts.model, parts.loops, motors, np.zeros(parts.model.nq))
    assert (found.degrees_of_freedom, found.rank) == (2, 4)


def test_a_rounded_loop_says_once_how_far_it_stays_open(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        robot_of(four_bar(12))
        assert not caplog.records
        robot = robot_of(four_bar(4))
        robot.forward_dynamics([0.1], [0.2], [0.3])
    (record,) = caplog.records
    told = record.getMessage()
    assert "'coupler-rocker'" in told
    assert f"{robot.closure_mismatch.length:.2g} m" in told
    assert f"home was moved by {robot.closure_mismatch.home_moved:.2g}" in told
    assert robot.closure_mismatch.length > TOLD_MISMATCH


def parallelogram(angle: float, digits: int) -> Parts:
    """Return a parallelogram whose crank stands at an angle from flat, where it can fold."""
    x, y = 0.2 * np.cos(angle), 0.2 * np.sin(angle)
    return four_bar(digits, corners=((0.0, 0.0), (x, y), (x + 0.5, y), (0.5, 0.0)))


@pytest.mark.parametrize("digits", [EXACT, 9, 6])
@pytest.mark.parametrize("angle", [0.0, 1e-4, 1e-2, 0.1])
def test_redundancy_is_told_from_a_singular_pose(angle: float, digits: int) -> None:
    """Flat, or nearly, its three equations have rank 1 there, and 2 elsewhere."""
    parts = parallelogram(angle, digits)
    flat = flattened(parts.model, parts.loops, NO_MOTORS)
    motors = np.eye(3)[:, :1]
    found = structure(parts.model, flat, np.zeros(3), motors)
    assert found.rank == 2


def structure_of(parts: Parts) -> Structure:
    flat = flattened(parts.model, parts.loops, NO_MOTORS)
    return structure(parts.model, flat, np.zeros(parts.model.nq), np.zeros((parts.model.nv, 0)))


@pytest.mark.parametrize("bend", [1e-6, 1e-5, 1e-4, 1e-3, 3e-3, 1e-2])
def test_bars_that_are_nearly_stretched_are_exact_and_held(bend: float) -> None:
    """Their home is near a singular pose, where a loose reading explains some motion of theirs."""
    found = structure_of(flat_triangle(bend))
    assert (found.rank, found.freedoms) == (4, 2)
    assert found.mismatch < 1e-11
    assert found.exact is None
    assert not found.is_stuck


@pytest.mark.parametrize("name", list(LINKAGES))
def test_the_basis_of_the_motions_does_not_matter(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It differs between machines, and may be any; the poses that are examined are the same."""
    parts = LINKAGES[name][0](EXACT, 0)
    found = structure_of(parts)
    rng, decomposed = np.random.default_rng(5), _Equations.decomposed

    def turned(equations: _Equations, q: Array) -> tuple[Array, Array, Array]:
        left, values, right = decomposed(equations, q)
        any_basis, _ = np.linalg.qr(rng.normal(size=(found.freedoms, found.freedoms)))
        return left, values, np.concatenate([right[: found.rank], any_basis @ right[found.rank :]])

    monkeypatch.setattr(_Equations, "decomposed", turned)
    again = structure_of(parts)
    assert len(again.poses) == len(found.poses) > 5
    np.testing.assert_allclose(again.poses, found.poses, atol=1e-9)


@pytest.mark.parametrize("bend", [1e-5, 1e-3, 1e-2])
def test_what_is_rigid_near_a_singular_pose_is_refused_as_rigid(bend: float) -> None:
    with pytest.raises(MobilityMismatch, match="0 degrees of freedom"):
        robot_of(flat_triangle(bend, beside=False))


@pytest.mark.parametrize("bend", [0.0, 1e-8])
def test_bars_that_are_stretched_close_exactly_where_they_are(bend: float) -> None:
    """What holds them is of second order, so that one motion of theirs is free at home."""
    found = structure_of(flat_triangle(bend))
    assert found.is_stuck
    assert (found.rank, found.freedoms) == (3, 3)
    assert found.mismatch < 1e-11
    np.testing.assert_array_equal(found.home, 0.0)


def test_a_short_lever_cannot_be_told_from_rounding_and_both_are_known() -> None:
    """Two points that are 0.7 mm apart on 1 m are one point, or hold a plate exactly."""
    found = structure_of(short_lever(7e-4, turntable=False))
    assert found.freedoms == 2
    assert 1e-4 < found.mismatch < 1e-3
    assert found.exact is not None
    assert found.exact.freedoms == 1
    assert found.exact.mismatch < 1e-11
    longer = structure_of(short_lever(7e-3, turntable=False))
    assert (longer.freedoms, longer.exact) == (1, None)


@pytest.mark.parametrize("name", list(LINKAGES))
def test_rounded_loops_of_four_digits_have_no_other_reading(name: str) -> None:
    """Or one of fewer freedoms, which is told."""
    builder, freedoms, _ = LINKAGES[name]
    found = structure_of(builder(4))
    assert found.freedoms == freedoms
    assert found.exact is None or found.exact.freedoms < freedoms


def test_a_tilted_hinge_is_told_and_a_bent_loop_refused() -> None:
    """A misalignment counts as rounding up to 2e-3 of the size, and is told; more is refused."""
    for tilt in (1e-4, 1e-3):
        parts = four_bar(EXACT)
        parts.model.jointPlacements[2] = parts.model.jointPlacements[2] * pin.SE3(
            pin.utils.rotate("x", tilt), np.zeros(3)
        )
        robot = robot_of(parts)
        assert robot.mobility.degrees_of_freedom == 1
        assert 0.01 * tilt < robot.closure_mismatch.length < tilt
    parts.model.jointPlacements[2] = parts.model.jointPlacements[2] * pin.SE3(
        pin.utils.rotate("x", 0.2), np.zeros(3)
    )
    with pytest.raises((RoundedLoops, LoopsDoNotClose, MobilityMismatch)) as caught:
        robot_of(parts)
    assert "0 degrees of freedom" in str(caught.value) or "coupler-rocker" in str(caught.value)


def test_loops_too_short_are_refused_within_five_seconds_by_name() -> None:
    parts = four_bar(EXACT)
    loop = parts.loops[0]
    loop.joint1_placement = pin.SE3(np.eye(3), np.array([9.0, 0.0, 0.0]))
    begun = time.process_time()
    with pytest.raises(LoopsDoNotClose, match="coupler-rocker") as caught:
        robot_of(parts)
    assert time.process_time() - begun < 5.0
    assert caught.value.residual > LARGEST_MISMATCH
    assert caught.value.tried > 3


def test_a_start_outside_the_ranges_is_brought_inside(tmp_path: Path) -> None:
    """A leg with a ram whose ranges leave out zero, the folded pose, where it is singular."""
    inertial = '<inertial pos="0 0 -.1" mass="1" diaginertia=".01 .01 .01"/>'
    (tmp_path / "leg.xml").write_text(
        f"""<mujoco><compiler angle="radian"/><worldbody>
        <body name="ram"><joint name="length" type="slide" axis="0 0 -1" range=".13 .7"/>{inertial}
         <site name="a"/></body>
        <body name="femur"><joint name="femur" axis="0 1 0" range=".17 1.2"/>{inertial}
         <body name="shank" pos=".36 0 0"><joint name="knee" axis="0 1 0" range="-2.4 -.35"/>
          {inertial}<site name="b" pos="-.36 0 0"/></body></body>
        </worldbody><equality><connect site1="a" site2="b"/></equality>
        <actuator><motor joint="length"/></actuator></mujoco>""",
        encoding="utf-8",
    )
    robot = psp3.ClosedLoopRobot.from_mjcf(tmp_path / "leg.xml")
    model = robot.model
    assert (model.lowerPositionLimit <= robot.q0).all()
    assert (robot.q0 <= model.upperPositionLimit).all()
    # Femur and shank are as long, so that the ram is twice the sine of the femur's angle.
    for length in (0.2, 0.4, 0.6):
        q = robot.configuration([length])
        assert q[1] == pytest.approx(np.arcsin(length / 0.72), abs=1e-12)


def test_the_size_of_a_robot_is_how_far_its_joints_are_apart() -> None:
    parts = four_bar(EXACT)
    places = np.array([in_plane(*c).translation for c in ((0, 0), (0.12, 0.16), (0.45, 0))])
    expected = np.linalg.norm(np.ptp(places, axis=0))
    assert robot_size(parts.model, np.zeros(3)) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_small_and_large_robots_are_judged_alike(scale: float) -> None:
    """Lengths are measured in sizes of the robot."""
    corners = scale * np.array([[0.0, 0.0], [0.12, 0.16], [0.52, 0.3], [0.45, 0.0]])
    parts = four_bar(5, corners=corners)
    flat = flattened(parts.model, parts.loops, NO_MOTORS)
    found = structure(parts.model, flat, np.zeros(3), np.eye(3)[:, :1])
    alike = four_bar(5)
    same = structure(
        alike.model, flattened(alike.model, alike.loops, NO_MOTORS), np.zeros(3), np.eye(3)[:, :1]
    )
    assert found.rank == same.rank == 2
    assert 0.1 < found.mismatch / same.mismatch < 10.0


LINK = """<link name="{}"><inertial><mass value="1"/><origin xyz="0 0 0" rpy="0 0 0"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
JOINT = """<joint name="{}" type="{}"><parent link="{}"/><child link="{}"/>
<origin xyz="{} 0 {}" rpy="0 0 0"/><axis xyz="{}"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint>"""


def slider_crank(folder: Path, offset: float, slide: float) -> Path:
    """Write a crank of 0.1 m and a rod of 0.35 m, which ends on a slide that starts at a place."""
    parts = [LINK.format(name) for name in ("base", "crank", "rod", "piston")]
    parts += [
        JOINT.format("turn", "revolute", "base", "crank", 0.0, 0.0, "0 -1 0"),
        JOINT.format("pin", "revolute", "crank", "rod", 0.1, 0.0, "0 -1 0"),
        JOINT.format("slide", "prismatic", "base", "piston", slide, offset, "1 0 0"),
        '<link name="end"/>',
        '<joint name="tip" type="fixed"><parent link="rod"/><child link="end"/>'
        '<origin xyz="0.35 0 0" rpy="0 0 0"/></joint>',
    ]
    (folder / "engine.urdf").write_text(f'<robot name="engine">{"".join(parts)}</robot>', "utf-8")
    (folder / "engine.yaml").write_text(
        "closed_loop: [[end, piston]]\ntype: [3d]\nname_mot: [slide]\n", "utf-8"
    )
    return folder / "engine.urdf"


@pytest.mark.parametrize("offset", [0.0, 0.03])
def test_a_home_that_is_searched_for_is_not_at_the_dead_center_of_a_motor(
    tmp_path: Path, offset: float
) -> None:
    """At the dead center of an engine its piston cannot turn the crank.

    At a tenth of the greatest leverage, the piston has at least 0.5 mm to go.
    """
    robot = psp3.load(slider_crank(tmp_path, offset, slide=0.0))
    (place,) = robot.reference
    nearest, farthest = (np.sqrt(reach**2 - offset**2) for reach in (0.25, 0.45))
    assert nearest + 5e-4 < place < farthest - 5e-4
    away = robot.configuration(robot.reference + np.array([[5e-4], [-5e-4]]))
    assert np.isfinite(away).all()


def test_a_neutral_pose_that_closes_the_loops_is_no_home_where_it_is_singular(
    tmp_path: Path,
) -> None:
    """Stretched, the engine is at its dead center, where its piston determines nothing."""
    robot = psp3.load(slider_crank(tmp_path, 0.0, slide=0.45))
    assert abs(robot.reference[0]) > 5e-4
    assert np.isfinite(robot.inverse_dynamics(robot.reference, [0.0], [1.0])).all()
