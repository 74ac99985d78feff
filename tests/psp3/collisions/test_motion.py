"""Collisions along a motion.

The first contact against closed forms, reports, errors, and what the check costs.
"""

from __future__ import annotations

import pickle

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.optimize import brentq

import psp3
from psp3 import collisions
from psp3.collisions.model import CollisionModel, collision_model
from psp3.errors import CollisionFound, InvalidArray, InvalidValue, PSP3Error
from psp3.three_psp.workspace import fold_tilt
from tests.helpers import Array
from tests.psp3.collisions.test_model import (
    BUSHING,
    EDGE,
    ROUNDED,
    arm_direction,
    balls_on_four_bar,
)

ROBOT = psp3.load()
MODEL = collision_model(ROBOT)

LARGEST_PITCH = np.arccos(BUSHING / np.hypot(*EDGE)) - np.arctan2(*EDGE)
"""Pitch of an arm at which its bushing touches the frame of the nut, where z0 cos φ − x0 sin φ is
the bushing's radius: 35.594°.
"""


def tilting(azimuth: float, largest: float = 45.0, samples: int = 151) -> tuple[Array, Array]:
    """Tilts from 30° on, which serve as times, and heights of a star that leans more and more."""
    tilt = np.radians(np.linspace(30.0, largest, samples))
    return tilt, ROBOT.inverse_kinematics(0.0, tilt, azimuth)


def tilt_at_contact(azimuth: float) -> float:
    """Tilt at which the steepest arm has the largest pitch."""

    def excess(tilt: float) -> float:
        pitches = [
            np.arctan2(abs(z), x)
            for x, _, z in (
                arm_direction(np.float64(tilt), np.float64(azimuth), leg) for leg in range(3)
            )
        ]
        return max(pitches) - LARGEST_PITCH

    return float(brentq(excess, 0.1, 1.0))


@pytest.mark.parametrize(
    "azimuth", np.radians([0.0, 10.0, 30.0, 47.0, 60.0, 90.0, 155.0, 240.0, 311.0])
)
def test_first_contact_is_where_the_closed_form_has_it(azimuth: float) -> None:
    """Bushing and frame of the nut, whatever the azimuth.

    2e-6 rad: the file's angles have six decimals, which is 1e-8 m at the end of the bushing, over a
    slope of 0.03 m/rad; the straight way in the heights between two samples, 0.1° apart, is off by
    4e-7 rad; coal's 1e-8 m.
    """
    tilt, heights = tilting(azimuth)
    report = collisions.check(ROBOT, heights, tilt, model=MODEL)
    assert report.first is not None
    assert report.first.time == pytest.approx(tilt_at_contact(azimuth), abs=2e-6)
    nut, ball = report.first.nearest.links
    assert nut.startswith("nut")
    assert ball.startswith("ball")
    assert nut[-1] == ball[-1]
    assert abs(report.first.nearest.distance) < 1e-7
    assert_allclose(
        report.first.positions, ROBOT.inverse_kinematics(0.0, report.first.time, azimuth), atol=1e-6
    )


def test_the_tilt_limit_and_the_fold() -> None:
    """Toward a screw the bushing ends the tilt 2.1° before the tip folds.

    That is 0.08 mm short of its reach; away from one the tip folds first.
    """
    assert np.degrees(LARGEST_PITCH) == pytest.approx(35.594, abs=5e-4)
    for azimuth, contact in ((0.0, 35.594), (30.0, 41.91), (60.0, 35.594)):
        assert np.degrees(tilt_at_contact(np.radians(azimuth))) == pytest.approx(contact, abs=0.005)
    assert np.degrees(fold_tilt(ROBOT, 0.0)) - np.degrees(tilt_at_contact(0.0)) == pytest.approx(
        2.13, abs=0.01
    )
    assert fold_tilt(ROBOT, np.pi / 3.0) < tilt_at_contact(np.pi / 3.0)
    tip = ROBOT.forward_kinematics(ROBOT.inverse_kinematics(0.0, tilt_at_contact(0.0), 0.0)).tip
    assert ROBOT.tip_reach(0.0) - tip[0] == pytest.approx(79e-6, abs=1e-6)


def test_without_its_bushing_the_arm_would_touch_the_frame() -> None:
    """The same formula with the radius of the arm, 9.5 mm: 44.47°."""
    without = CollisionModel(
        ROBOT, MODEL.shapes, [(f"nut{leg}", f"ball_lambda{leg}", "left out") for leg in (1, 2, 3)]
    )
    tilt, heights = tilting(0.0)
    first = collisions.check(ROBOT, heights, tilt, model=without).first
    assert first is not None
    assert first.time == pytest.approx(
        np.arccos(0.0095 / np.hypot(*EDGE)) - np.arctan2(*EDGE), abs=2e-6
    )
    assert first.nearest.links == ("nut1", "star1")


def test_a_clearance_is_met_earlier() -> None:
    """z0 cos φ − x0 sin φ = radius + clearance."""
    tilt, heights = tilting(0.0)
    report = collisions.check(ROBOT, heights, tilt, clearance=0.002, model=MODEL)
    assert report.first is not None
    expected = np.arccos((BUSHING + 0.002) / np.hypot(*EDGE)) - np.arctan2(*EDGE)
    assert report.first.time == pytest.approx(expected, abs=2e-6)
    assert report.first.nearest.distance == pytest.approx(0.002, abs=1e-7)
    assert report.clearance == 0.002


def test_distances_along_the_motion_are_those_of_the_poses() -> None:
    tilt, heights = tilting(np.radians(20.0), 34.0, 12)
    report = collisions.check(ROBOT, heights, tilt, model=MODEL)
    each = MODEL.distances(heights)
    assert_allclose(report.distance, each.min(axis=1), atol=1e-12)
    assert_allclose(each[np.arange(12), report.pair], report.distance, atol=1e-12)
    assert_array_equal(report.time, tilt)
    assert report.pairs == MODEL.pairs
    assert report.first is None
    assert report.nearest.time == tilt[-1]
    assert report.nearest.nearest.distance == pytest.approx(report.distance.min(), abs=1e-12)


def test_the_helix_of_the_study_is_clear() -> None:
    """20 mm lean the star by 22.7°.

    There bushing and frame are z0 cos φ − x0 sin φ − r = 6.6 mm apart.
    """
    t = np.linspace(0.0, 2.0, 61)
    report = collisions.check(
        ROBOT, psp3.trajectories.Helix(robot=ROBOT)(t).heights, t, model=MODEL
    )
    assert report.first is None
    tilt = np.radians(22.71)
    assert report.distance.min() == pytest.approx(
        EDGE[1] * np.cos(tilt) - EDGE[0] * np.sin(tilt) - BUSHING, abs=2e-5
    )


def test_a_contact_at_the_start_is_found() -> None:
    heights = tilting(0.0, 45.0, 10)[1]
    report = collisions.check(ROBOT, heights[::-1], model=MODEL)
    assert report.first is not None
    assert report.first.time == 0.0
    assert_array_equal(report.first.positions, heights[-1])
    assert_array_equal(report.time, np.arange(10.0))
    assert collisions.check(ROBOT, heights[:1], model=MODEL).first is None


def test_links_in_contact_are_an_error_that_says_which_and_when() -> None:
    tilt, heights = tilting(np.radians(120.0))
    with pytest.raises(
        CollisionFound,
        match=r"t = 0\.6212\d+ s links 'nut2' and 'ball_lambda2' touch.*mm in each other",
    ) as caught:
        collisions.check_clearance(ROBOT, heights, tilt, model=MODEL)
    error = caught.value
    assert isinstance(error, PSP3Error)
    assert isinstance(error, ValueError)
    assert error.time == pytest.approx(LARGEST_PITCH, abs=2e-6)
    assert error.links == ("nut2", "ball_lambda2")
    assert (error.clearance, error.worst_time) == (0.0, tilt[-1])
    assert error.worst_distance < -0.003
    assert str(pickle.loads(pickle.dumps(error))) == str(error)
    collisions.check_clearance(ROBOT, heights[:50], tilt[:50], model=MODEL)


def test_the_shapes_are_those_of_the_robots_file_unless_others_are_given() -> None:
    tilt, heights = tilting(0.0, 34.0, 4)
    assert_array_equal(
        collisions.check(ROBOT, heights, tilt).distance,
        collisions.check(ROBOT, heights, tilt, model=MODEL).distance,
    )
    only_arms = CollisionModel(
        ROBOT, MODEL.shapes, [(f"nut{leg}", f"ball_lambda{leg}", "left out") for leg in (1, 2, 3)]
    )
    assert (
        collisions.check(ROBOT, heights, tilt, model=only_arms).distance
        > collisions.check(ROBOT, heights, tilt).distance
    ).all()


def test_another_robot() -> None:
    """Balls on a four-bar linkage.

    They touch where their middles are two radii apart, by Brent's method on the linkage's motion.
    """
    robot, shapes = balls_on_four_bar(0.05)
    model, data = CollisionModel(robot, shapes), robot.model.createData()

    def apart(position: float) -> float:
        pin.forwardKinematics(robot.model, data, robot.configuration([position]))
        return float(
            np.linalg.norm(data.oMi[2].act(np.array([0.15, 0.0, 0.1])) - [0.05, 0.15, 0.1]) - 0.1
        )

    positions = np.linspace(1.0, 2.1, 111)
    touching = np.array([apart(position) for position in positions]) <= 0.0
    assert touching.any()
    assert not touching[0]
    before = positions[np.argmax(touching) - 1]
    expected = brentq(apart, before, before + 0.01, xtol=1e-12)
    report = collisions.check(robot, positions[:, None], positions - 1.0, model=model)
    assert report.first is not None
    assert report.first.time == pytest.approx(expected - 1.0, abs=1e-7)
    assert report.first.nearest.links == ("universe", "j2")


def test_reach_of_the_arms_is_not_a_matter_of_the_columns() -> None:
    """Up to 60° no arm comes nearer than 26 mm to a column.

    Bushings and end stops have long touched by then.
    """
    columns = [
        k
        for k, links in enumerate(MODEL.pairs)
        if links[0] == "base" and links[1].startswith("star")
    ]
    tilt, azimuth = np.meshgrid(
        np.radians([20.0, 40.0, 60.0]), np.radians(np.arange(0.0, 120.0, 20.0))
    )
    assert (
        MODEL.distances(ROBOT.inverse_kinematics(0.0, tilt, azimuth))[..., columns].min()
        > 0.026 - ROUNDED
    )


# What is refused


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ({"positions": [0.0, 0.0, 0.0]}, InvalidArray, r"\(N, 3\)"),
        ({"positions": np.zeros((0, 3))}, InvalidArray, "at least 1"),
        ({"positions": np.zeros((4, 2))}, InvalidArray, "positions"),
        ({"positions": [[0.0, np.nan, 0.0]]}, InvalidArray, "positions"),
        ({"positions": np.zeros((2, 3)), "time": [0.0]}, InvalidArray, "time"),
        ({"positions": np.zeros((2, 3)), "time": [1.0, 1.0]}, InvalidArray, "increasing"),
        ({"positions": np.zeros((2, 3)), "time": [0.0, np.inf]}, InvalidArray, "time"),
        ({"positions": np.zeros((2, 3)), "clearance": -1e-3}, InvalidValue, "clearance"),
        ({"positions": np.zeros((2, 3)), "clearance": np.nan}, InvalidValue, "clearance"),
    ],
)
def test_bad_arguments_are_refused(
    arguments: dict[str, object], error: type[Exception], words: str
) -> None:
    for function in (collisions.check, collisions.check_clearance):
        with pytest.raises(error, match=words):
            function(ROBOT, model=MODEL, **arguments)
