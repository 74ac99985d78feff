"""Figures of any robot: what is drawn is what happened."""

from __future__ import annotations

import numpy as np
import pytest

import psp3
from psp3.errors import InvalidValue
from psp3.plots.joints import figure_of_joint_forces, figure_of_joint_tracking
from psp3.trajectories.screw_forces import screw_forces
from psp3.trajectories.sway import Sway

ROBOT = psp3.load("five_bar")


def test_figure_of_tracking_draws_positions_errors_and_forces() -> None:
    result = psp3.simulate(ROBOT, psp3.ComputedTorque(ROBOT), Sway(robot=ROBOT), 0.1)
    panels = figure_of_joint_tracking(ROBOT, result, "computed torque")
    positions, errors, forces = panels
    np.testing.assert_array_equal(positions.lines[0].get_ydata(), result.positions[:, 0])
    np.testing.assert_array_equal(positions.lines[3].get_ydata(), result.desired.positions[:, 1])
    np.testing.assert_array_equal(
        errors.lines[1].get_ydata(), (result.desired.positions - result.positions)[:, 1]
    )
    np.testing.assert_array_equal(forces.lines[1].get_ydata(), result.torque[:, 1])
    assert [panel.get_ylabel().rsplit(" [")[-1] for panel in panels] == ["rad]", "rad]", "N m]"]
    legend = positions.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == list(ROBOT.actuated)
    with pytest.raises(InvalidValue):
        figure_of_joint_tracking(ROBOT, result, "", panels[:2])


def test_figure_of_forces_draws_the_motion_and_its_forces() -> None:
    forces = screw_forces(Sway(robot=ROBOT), np.linspace(0.0, 1.0, 11))
    panels = figure_of_joint_forces(ROBOT, forces, "sway")
    np.testing.assert_array_equal(panels[3].lines[0].get_ydata(), forces.forces[:, 0])
    np.testing.assert_array_equal(panels[1].lines[1].get_ydata(), forces.motion.speeds[:, 1])
    again = figure_of_joint_forces(ROBOT, forces, "sway", panels)
    assert again == panels
