"""Frames on the simulation's own time, and tracks that a browser interpolates."""

from __future__ import annotations

import numpy as np
import pytest

import psp3
from psp3.errors import InvalidValue
from psp3.visualize.animation import FRAME_RATE, clip, frames_of

ROBOT = psp3.load()


def test_frames_of_a_result_are_its_samples_at_even_times() -> None:
    """A period of 1/90 s puts every third sample on a frame, so nothing is interpolated.

    1e-12 is rounding.
    """
    helix = psp3.trajectories.Helix(robot=ROBOT)
    result = psp3.simulate(ROBOT, psp3.PD(), helix, 1.0, 1.0 / 90.0)
    frames = frames_of(result)
    np.testing.assert_allclose(np.diff(frames.time), 1.0 / FRAME_RATE, atol=1e-12)
    for values, samples in (
        (frames.positions, result.heights),
        (frames.tip, result.tip),
        (frames.desired_positions, result.desired.heights),
        (frames.desired_tip, result.desired.tip),
        (frames.force, result.torque),
    ):
        assert values is not None
        np.testing.assert_allclose(values, samples[::3], atol=1e-11)


def test_frames_of_a_trajectory_end_where_it_rests() -> None:
    line = psp3.trajectories.Line([0.0, 0.0, 0.07], [0.01, 0.0, 0.09], 0.8, robot=ROBOT)
    frames = frames_of(line)
    assert frames.time[-1] == 0.8
    assert frames.tip is not None
    np.testing.assert_allclose(frames.tip[-1], [0.01, 0.0, 0.09], atol=1e-12)
    np.testing.assert_allclose(
        ROBOT.forward_kinematics(frames.positions).tip, frames.tip, atol=1e-12
    )
    assert (frames.desired_positions, frames.desired_tip, frames.force) == (None, None, None)
    assert frames_of(line, 2.0).time[-1] == 2.0


@pytest.mark.parametrize("duration", [None, 0.0, -1.0, np.nan, np.inf])
def test_a_trajectory_without_an_end_needs_a_time(duration: float | None) -> None:
    with pytest.raises(InvalidValue, match=r"this Helix never rests, got"):
        frames_of(psp3.trajectories.Helix(robot=ROBOT), duration)


def test_only_what_moves_has_a_track() -> None:
    seconds = np.array([0.0, 0.5, 1.0])
    still, up, around = (
        np.ones((3, 3)),
        np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 2.0], [0.0, 0.0, 3.0]]),
        np.eye(3),
    )
    tracks = {
        name: track
        for values in ({"position": up, "scale": still}, {"position": around})
        for track in clip("/node", seconds, values)["clip"]["tracks"]
        for name in [track["name"]]
    }
    assert set(tracks) == {".position[z]", ".position"}
    assert (tracks[".position[z]"]["type"], tracks[".position"]["type"]) == ("number", "vector3")
    np.testing.assert_array_equal(tracks[".position[z]"]["values"], [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(tracks[".position"]["values"], np.eye(3).ravel())
    assert clip("/node", seconds, {"position": still})["clip"]["tracks"] == []
