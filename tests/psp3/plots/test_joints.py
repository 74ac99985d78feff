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


def test_more_motors_than_coordinates_are_named_apart() -> None:
    robot = psp3.load("planar_4rrr")
    result = psp3.simulate(robot, psp3.ComputedTorque(robot), Sway(robot=robot), 0.01)
    positions, errors, forces = figure_of_joint_tracking(robot, result, "over-actuated")
    assert len(errors.lines) == 3
    assert [text.get_text() for text in positions.get_legend().get_texts()] == list(
        robot.coordinates
    )
    assert [text.get_text() for text in forces.get_legend().get_texts()] == list(robot.actuated)
    np.testing.assert_array_equal(forces.lines[3].get_ydata(), result.torque[:, 3])
    panels = figure_of_joint_forces(robot, screw_forces(Sway(robot=robot), [0.0, 0.1]), "sway")
    assert [len(panel.lines) for panel in panels] == [3, 3, 3, 4]


def test_what_follows_is_not_drawn_and_a_tendon_has_no_unit() -> None:
    robot = psp3.load("gripper")
    result = psp3.simulate(robot, psp3.ComputedTorque(robot), Sway(robot=robot), 0.01)
    positions, errors, forces = figure_of_joint_tracking(robot, result, "springs")
    np.testing.assert_array_equal(positions.lines[0].get_ydata(), result.positions[:, 0])
    assert len(errors.lines) == len(forces.lines) == 1
    assert [panel.get_ylabel() for panel in (errors, forces)] == ["error [rad]", "force"]
