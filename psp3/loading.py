"""Load a robot by name, with its model, reference poses, visuals, loop closures and parameters."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal, overload

import numpy as np
import pinocchio as pin

from psp3.closed_loop_robot import ClosedLoopRobot
from psp3.errors import InvalidValue, UnknownName
from psp3.loops import constraint_models, read_loops
from psp3.parameters import Parameters, named_parameters
from psp3.robot import PSP3
from psp3.robot_files import read_tree, reference_poses

ROBOT_FILES = Path(__file__).resolve().parent / "urdf"
"""Directory of the robot description files that come with the package."""

ROBOTS = ("psp3", "five_bar", "planar_3rrr", "delta", "gough_stewart", "tricept")
"""Names of the robots that come with the package."""


@overload
def load(name: Literal["psp3"] = "psp3", parameters: str | Parameters = "default") -> PSP3: ...


@overload
def load(name: str, parameters: str | Parameters = "default") -> ClosedLoopRobot: ...


def load(name: str = "psp3", parameters: str | Parameters = "default") -> ClosedLoopRobot:
    """Load a robot that comes with the package.

    Parameters
    ----------
    name : str
        ``"psp3"``, the 3-PSP, which has a closed form, or ``"five_bar"``, ``"planar_3rrr"``, ``"delta"``, ``"gough_stewart"`` or
        ``"tricept"``, whose loops are closed by iteration. ``urdf/README.md`` describes them.
    parameters : str or Parameters
        Numbers of the 3-PSP: ``"default"``, ``"table_3_1"``, ``"table_5_1"`` (see :mod:`psp3.parameters`) or your own. The other
        robots have those of their files only.

    Returns
    -------
    PSP3 or ClosedLoopRobot
        The robot: ``.model .data .q0 .visual_model`` as with example-robot-data, ``.constraint_models`` and ``.actuated`` for
        the loops, and kinematics and dynamics in the actuated coordinates.

    Raises
    ------
    UnknownName
        If the robot or the parameter set is unknown; a :class:`ValueError` that lists the known names.
    InvalidValue
        If parameters are given for another robot than the 3-PSP.
    """
    if name not in ROBOTS:
        raise UnknownName("robot", name, ROBOTS)
    if name == "psp3":
        return _load_psp3(parameters)
    if parameters != "default":
        raise InvalidValue("parameters", parameters, f"'default' for robot {name!r}: only 'psp3' has other sets")
    files = (ROBOT_FILES / f"{name}.{kind}" for kind in ("urdf", "yaml", "srdf"))
    return ClosedLoopRobot.from_urdf(*files)


def _load_psp3(parameters: str | Parameters) -> PSP3:
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
        # The file's poses are those of the default screw radius; their tilts are kept, so that every pose stays possible.
        heights = np.array(pose.data())[[model.joints[model.getJointId(name)].idx_q for name in loops.actuated]]
        wider = numbers.screw_radius / Parameters().screw_radius
        model.referenceConfigurations[pose.key()] = robot.configuration(heights.mean() + wider * (heights - heights.mean()))
    return robot


def set_parameters(model: pin.Model, parameters: Parameters) -> None:
    """Write parameters into a model read from ``psp3.urdf``: screw and tip positions, masses, inertias, gravity.

    Parameters
    ----------
    model : pinocchio.Model
        The model, changed in place.
    parameters : Parameters
        The numbers. A third of the star's mass and inertia goes to the end of each chain.
    """
    p = parameters
    ball = {
        axis: _diagonal(p.ball_mass, [p.ball_axial_inertia if axis == i else p.ball_transverse_inertia for i in range(3)])
        for axis in range(3)
    }
    third = _diagonal(p.star_mass / 3.0, np.array(p.star_inertia) / 3.0)
    for leg in (1, 2, 3):
        joint = {name: model.getJointId(f"{name}{leg}") for name in ("a", "phi", "theta", "lambda", "b")}
        placement = model.jointPlacements[joint["a"]]
        azimuth = 2.0 * np.pi * (leg - 1) / 3.0
        placement.translation = p.screw_radius * np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
        model.jointPlacements[joint["a"]] = placement
        model.inertias[joint["a"]] = _diagonal(p.nut_mass, p.nut_inertia)
        # Each body of the ball joint has its large moment about its own joint's axis.
        model.inertias[joint["phi"]], model.inertias[joint["theta"]], model.inertias[joint["lambda"]] = ball[1], ball[0], ball[2]
        model.inertias[joint["b"]] = model.frames[model.getFrameId(f"star{leg}_center")].placement.act(third)
    tip = model.frames[model.getFrameId("tip")]
    tip.placement = model.frames[model.getFrameId("star1_center")].placement * pin.SE3(np.eye(3), np.array([0.0, 0.0, p.tool_length]))
    model.gravity = pin.Motion(np.array([0.0, 0.0, -p.gravity]), np.zeros(3))


def _diagonal(mass: float, moments: Any) -> pin.Inertia:
    return pin.Inertia(mass, np.zeros(3), np.diag(np.asarray(moments, dtype=float)))
