"""The Pinocchio model of the 3-PSP, read from its files, with the numbers of a parameter set."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin

from fuzzy2.support.interpreted import few_calls
from psp3.description.loop_file import constraint_models, read_loops
from psp3.description.parts import ROBOT_FILES
from psp3.description.reference_configurations import set_reference_configuration
from psp3.description.srdf import reference_poses
from psp3.description.urdf import read_tree
from psp3.three_psp.parameters import Parameters, named_parameters
from psp3.three_psp.robot import PSP3


def load_psp3(parameters: str | Parameters) -> PSP3:
    """Return the 3-PSP with the numbers of a parameter set."""
    numbers = named_parameters(parameters)
    model, visual_model = read_tree(ROBOT_FILES / "psp3.urdf")
    set_parameters(model, numbers)
    loops = read_loops(ROBOT_FILES / "psp3.yaml")
    closures = constraint_models(model, loops, ROBOT_FILES / "psp3.yaml")
    home = reference_poses(model, ROBOT_FILES / "psp3.srdf")["home"]
    for leg in (1, 2, 3):
        home[model.joints[model.getJointId(f"b{leg}")].idx_q] = numbers.screw_radius
    robot = PSP3(model, closures, loops.actuated, home, visual_model, numbers)
    robot.urdf, robot.srdf = ROBOT_FILES / "psp3.urdf", ROBOT_FILES / "psp3.srdf"
    for pose in list(model.referenceConfigurations):
        # The poses in the file are for the default screw radius. Their tilts are kept, so that
        # every pose remains possible.
        heights = np.array(pose.data())[
            [model.joints[model.getJointId(name)].idx_q for name in loops.actuated]
        ]
        wider = numbers.screw_radius / Parameters().screw_radius
        with few_calls():
            moved = robot.configuration(heights.mean() + wider * (heights - heights.mean()))
        set_reference_configuration(model, pose.key(), moved)
    return robot


def set_parameters(model: pin.Model, parameters: Parameters) -> None:
    """Write parameters into a model read from ``psp3.urdf``.

    These are screw and tip positions, masses, inertias and gravity.

    Parameters
    ----------
    model : pinocchio.Model
        The model, changed in place.
    parameters : Parameters
        The numbers. The last body of each chain gets a third of the star's mass and inertia.
    """
    p = parameters
    ball = {
        axis: _diagonal(
            p.ball_mass,
            [p.ball_axial_inertia if axis == i else p.ball_transverse_inertia for i in range(3)],
        )
        for axis in range(3)
    }
    third = _diagonal(p.star_mass / 3.0, np.array(p.star_inertia) / 3.0)
    for leg in (1, 2, 3):
        joint = {
            name: model.getJointId(f"{name}{leg}") for name in ("a", "phi", "theta", "lambda", "b")
        }
        placement = model.jointPlacements[joint["a"]]
        azimuth = 2.0 * np.pi * (leg - 1) / 3.0
        placement.translation = p.screw_radius * np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
        model.jointPlacements[joint["a"]] = placement
        model.inertias[joint["a"]] = _diagonal(p.nut_mass, p.nut_inertia)
        # The large moment of each body of the ball joint is about the body's own joint axis.
        (
            model.inertias[joint["phi"]],
            model.inertias[joint["theta"]],
            model.inertias[joint["lambda"]],
        ) = ball[1], ball[0], ball[2]
        model.inertias[joint["b"]] = model.frames[
            model.getFrameId(f"star{leg}_center")
        ].placement.act(third)
    tip = model.frames[model.getFrameId("tip")]
    tip.placement = model.frames[model.getFrameId("star1_center")].placement * pin.SE3(
        np.eye(3), np.array([0.0, 0.0, p.tool_length])
    )
    model.gravity = pin.Motion(np.array([0.0, 0.0, -p.gravity]), np.zeros(3))


def _diagonal(mass: float, moments: Any) -> pin.Inertia:
    return pin.Inertia(mass, np.zeros(3), np.diag(np.asarray(moments, dtype=float)))
