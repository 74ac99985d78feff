"""Encoders: they count, and speeds are differences of what they count."""

from __future__ import annotations

import numpy as np

import psp3
from psp3.simulation.encoder import Encoder
from psp3.trajectories import Helix, Hold
from tests.psp3.simulation.controllers import Recording

ROBOT = psp3.load("psp3")

HELIX = Helix(robot=ROBOT)


def test_encoders_count_and_their_speeds_are_differences() -> None:
    """Counts of 5 µm: what is seen is a whole number of them, next to the truth.

    Speeds in steps of 2.5 mm/s, half a period late.
    """
    controller = Recording()
    result = psp3.simulate(
        ROBOT,
        controller,
        Hold(robot=ROBOT),
        0.2,
        initial_speeds=[0.1, -0.05, 0.02],
        encoder_resolution=5e-6,
    )
    seen = np.array([call[1] for call in controller.calls])
    speeds = np.array([call[2] for call in controller.calls])
    np.testing.assert_allclose(seen / 5e-6, np.round(result.heights / 5e-6), rtol=0.0, atol=1e-9)
    assert np.abs(seen - result.heights).max() <= 2.5e-6 * (1.0 + 1e-9)
    np.testing.assert_array_equal(speeds[0], 0.0)
    np.testing.assert_array_equal(speeds[1:], np.diff(seen, axis=0) / 0.002)
    # The speed in the middle of a period, within a count.
    np.testing.assert_allclose(
        speeds[1:],
        0.5 * (result.speeds[1:] + result.speeds[:-1]),
        rtol=0.0,
        atol=2.5e-3 * (1.0 + 1e-6),
    )


def test_the_first_reading_has_no_speed_wherever_it_is() -> None:
    """Nothing was counted before; then it is the difference of two counts over the period."""
    encoder = Encoder(np.array([0.1, 0.1]), 0.5)
    seen, speeds = encoder.read(np.array([0.72, -0.31]), np.array([9.0, 9.0]))
    np.testing.assert_allclose(seen, [0.7, -0.3], atol=1e-15)
    np.testing.assert_array_equal(speeds, [0.0, 0.0])
    seen, speeds = encoder.read(np.array([0.98, -0.33]), np.array([9.0, 9.0]))
    np.testing.assert_allclose(speeds, [0.6, 0.0], atol=1e-15)


def test_every_joint_can_have_its_own_encoder() -> None:
    """And a perfect one sees what it sees without any."""
    controller = Recording()
    resolution = [0.0, 1e-3, 1e-5]
    result = psp3.simulate(
        ROBOT,
        controller,
        HELIX,
        0.1,
        encoder_resolution=resolution,
        initial_speeds=[0.05, 0.05, 0.05],
    )
    seen, speeds = (np.array([call[k] for call in controller.calls]) for k in (1, 2))
    np.testing.assert_array_equal(seen[:, 0], result.heights[:, 0])
    np.testing.assert_array_equal(speeds[:, 0], result.speeds[:, 0])
    np.testing.assert_allclose(
        seen[:, 1:] / resolution[1:],
        np.round(result.heights[:, 1:] / resolution[1:]),
        rtol=0.0,
        atol=1e-9,
    )


def test_fine_encoders_are_perfect_ones_but_for_their_late_speeds() -> None:
    """Of 1e-13 m; a controller that uses no speeds cannot tell.

    1e-9 m are 1e-13 m, fed back over 0.5 s.
    """
    controller = psp3.PD(3000.0, 0.0)
    perfect, fine = (
        psp3.simulate(ROBOT, controller, HELIX, 0.5, encoder_resolution=resolution)
        for resolution in (0.0, 1e-13)
    )
    np.testing.assert_allclose(fine.heights, perfect.heights, rtol=0.0, atol=1e-9)
    assert np.abs(fine.heights - perfect.heights).max() > 0.0
