"""Load a robot by name, with its model, reference poses, visuals, loop closures and parameters."""

from __future__ import annotations

from typing import Literal, overload

from psp3.description.parts import MJCF_ROBOTS, ROBOT_FILES, ROBOTS
from psp3.errors import InvalidValue, UnknownName
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from psp3.three_psp.model import load_psp3
from psp3.three_psp.parameters import Parameters
from psp3.three_psp.robot import PSP3


@overload
def load(name: Literal["psp3"] = "psp3", parameters: str | Parameters = "default") -> PSP3: ...


@overload
def load(name: str, parameters: str | Parameters = "default") -> ClosedLoopRobot: ...


def load(name: str = "psp3", parameters: str | Parameters = "default") -> ClosedLoopRobot:
    """Load a robot that comes with the package.

    Parameters
    ----------
    name : str
        ``"psp3"``, the 3-PSP, which has a closed form; or a robot whose loops are closed by
        iteration: ``"five_bar"``, ``"planar_3rrr"``, ``"delta"``, ``"gough_stewart"`` or
        ``"tricept"`` of the thesis, or one of what people build: ``"planar_4rrr"``, ``"jansen"``,
        ``"agile_eye"``, ``"hexa"``, ``"gripper"`` or ``"biped"``. ``urdf/README.md`` describes
        them.
    parameters : str or Parameters
        Numbers of the 3-PSP: ``"default"``, ``"table_3_1"``, ``"table_5_1"`` (see
        :mod:`psp3.three_psp.parameters`) or your own. The other robots have those of their files
        only.

    Returns
    -------
    PSP3 or ClosedLoopRobot
        The robot: ``.model .data .q0 .visual_model`` as with example-robot-data,
        ``.constraint_models`` and ``.actuated`` for the loops, and kinematics and dynamics in the
        actuated coordinates.

    Raises
    ------
    UnknownName
        If the robot or the parameter set is unknown; a :class:`ValueError` that lists the known
        names.
    InvalidValue
        If parameters are given for another robot than the 3-PSP.
    """
    if name not in ROBOTS:
        raise UnknownName("robot", name, ROBOTS)
    if name == "psp3":
        return load_psp3(parameters)
    if parameters != "default":
        raise InvalidValue(
            "parameters", parameters, f"'default' for robot {name!r}: only 'psp3' has other sets"
        )
    if name in MJCF_ROBOTS:
        # Their springs move, with or without a motor.
        return ClosedLoopRobot.from_mjcf(ROBOT_FILES / f"{name}.xml", free="keep")
    files = (ROBOT_FILES / f"{name}.{kind}" for kind in ("urdf", "yaml", "srdf"))
    return ClosedLoopRobot.from_urdf(*files)
