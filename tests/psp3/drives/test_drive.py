"""Drives: motor and joint do the same work, and what makes no sense is refused.

How they move is tested with the plants.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from psp3.drives import NO_DRIVE, Drive, drive_table
from psp3.errors import InvalidArray, InvalidValue


def test_motor_and_joint_do_the_same_work() -> None:
    """A screw of 10 mm per revolution.

    Power and kinetic energy on both sides, at a nut speed of 0.3 m/s; 1e-15 relative is rounding.
    """
    drive = Drive(motor_inertia=2e-4, lead=0.010)
    force, speed = np.array([[90.0, -30.0, 0.0]]), 0.3
    motor_speed = 2.0 * np.pi * speed / 0.010
    np.testing.assert_allclose(drive.motor_torque(force) * motor_speed, force * speed, rtol=1e-15)
    np.testing.assert_allclose(drive.force(drive.motor_torque(force)), force, rtol=1e-15)
    assert 0.5 * drive.reflected_inertia * speed**2 == pytest.approx(
        0.5 * 2e-4 * motor_speed**2, rel=1e-15
    )


def test_of_a_revolute_joint_the_lead_is_the_gear_ratio() -> None:
    """A gear of 50 to 1: 50 times the torque, 2500 times the inertia."""
    drive = Drive(motor_inertia=1e-5, lead=2.0 * np.pi / 50.0)
    assert float(drive.force(0.2)) == pytest.approx(10.0, rel=1e-15)
    assert drive.reflected_inertia == pytest.approx(0.025, rel=1e-15)


def test_without_arguments_it_is_not_there() -> None:
    np.testing.assert_array_equal(drive_table(NO_DRIVE, 4), np.zeros((4, 3)))
    assert Drive(lead=0.01).reflected_inertia == 0.0


def test_one_for_all_joints_or_one_for_each() -> None:
    one, other = Drive(3.0, 2.0, 1e-4, 0.01), Drive(coulomb_friction=1.0)
    row = [1e-4 * (200.0 * np.pi) ** 2, 2.0, 3.0]
    np.testing.assert_allclose(drive_table(one, 2), [row, row], rtol=1e-15)
    np.testing.assert_allclose(drive_table([one, other], 2), [row, [0.0, 0.0, 1.0]], rtol=1e-15)


@pytest.mark.parametrize("name", ["coulomb_friction", "viscous_friction", "motor_inertia", "lead"])
@pytest.mark.parametrize("value", [-1.0, np.nan, np.inf, "1", True, [1.0]])
def test_numbers_that_make_no_sense_are_refused(name: str, value: Any) -> None:
    with pytest.raises(InvalidValue) as caught:
        Drive(**{name: value})
    assert caught.value.name == name


@pytest.mark.parametrize(
    "build",
    [
        lambda: Drive(lead=0.0),
        lambda: Drive(motor_inertia=1e-4),
        lambda: Drive(5.0).motor_torque(1.0),
        lambda: Drive(5.0).force([1.0]),
    ],
)
def test_a_motor_needs_a_lead(build: Any) -> None:
    with pytest.raises(InvalidValue, match="lead"):
        build()


@pytest.mark.parametrize("drive", [None, 1.0, [], [NO_DRIVE], [NO_DRIVE, 5.0, NO_DRIVE], "drive"])
def test_drives_are_those_of_the_joints(drive: Any) -> None:
    with pytest.raises(InvalidValue, match="each of the 3"):
        drive_table(drive, 3)


def test_forces_are_numbers() -> None:
    with pytest.raises(InvalidArray):
        Drive(lead=0.01).motor_torque("much")
