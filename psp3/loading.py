"""Load a robot by its name, or from its file."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal, overload

from psp3.checks import checked_kind
from psp3.description.parts import MJCF_ROBOTS, ROBOT_FILES, ROBOTS
from psp3.description.xml import read_xml
from psp3.errors import InvalidRobotFile, InvalidValue, UnknownRobot
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from psp3.three_psp.model import load_psp3
from psp3.three_psp.parameters import Parameters
from psp3.three_psp.robot import PSP3

READERS = {"robot": "from_urdf", "mujoco": "from_mjcf", "sdf": "from_sdf"}
"""The class method that reads a file, by the file's outermost element."""

ENDINGS = (".urdf", ".xml", ".mjcf", ".sdf", ".world", ".xacro")
"""File name endings of robot files; anything else is the name of a robot."""

SDF_ENDINGS = (".sdf", ".world")
"""File name endings that only SDF files have."""


@overload
def load(name: Literal["psp3"] = "psp3", parameters: str | Parameters = "default") -> PSP3: ...


@overload
def load(
    name: str | Path, parameters: str | Parameters = "default", **options: Any
) -> ClosedLoopRobot: ...


def load(
    name: str | Path = "psp3", parameters: str | Parameters = "default", **options: Any
) -> ClosedLoopRobot:
    """Load a robot that comes with the package, or one from its file.

    Parameters
    ----------
    name : str or path
        ``"psp3"``, the 3-PSP, which has a closed form; or a robot whose loops are closed by
        iteration: ``"five_bar"``, ``"planar_3rrr"``, ``"delta"``, ``"gough_stewart"`` or
        ``"tricept"``, which the thesis shows, or ``"planar_4rrr"``, ``"jansen"``, ``"agile_eye"``,
        ``"hexa"``, ``"gripper"`` or ``"biped"`` (``urdf/README.md`` describes them); or a file that
        ends in ``.urdf``, ``.xml``, ``.mjcf``, ``.sdf`` or ``.world``. The outermost element
        decides the format, unless the ending is that of an SDF. If ``loops`` and ``srdf`` are not
        given, the files ``my.yaml`` (loops) and ``my.srdf`` (poses) beside ``my.urdf`` are used
        where they exist.
    parameters : str or Parameters
        Numbers of the 3-PSP: ``"default"``, ``"table_3_1"``, ``"table_5_1"`` (see
        :mod:`psp3.three_psp.parameters`) or your own. The other robots have only the numbers in
        their files.
    **options
        For any robot but the 3-PSP, the options of :meth:`psp3.ClosedLoopRobot.from_urdf`,
        :meth:`psp3.ClosedLoopRobot.from_mjcf` or ``from_sdf``: ``actuated``, ``free``,
        ``coordinates``, ``closures``, ...

    Returns
    -------
    PSP3 or ClosedLoopRobot
        The robot: ``.model .data .q0 .visual_model`` as with example-robot-data,
        ``.constraint_models`` and ``.actuated`` for the loops, and kinematics and dynamics in the
        actuated coordinates.

    Raises
    ------
    UnknownRobot, UnknownName
        If the robot or the parameter set is unknown; a :class:`ValueError` that lists the known
        names.
    InvalidRobotFile
        If a file is missing or malformed, or its format is not supported.
    InvalidValue
        If parameters are given for a robot other than the 3-PSP, or options for the 3-PSP.
    """
    wanted = "the name of a robot, or the path of its file"
    checked_kind("name", name, (str, Path), wanted)
    checked_kind("parameters", parameters, (str, Parameters), "a name, or Parameters")
    if name == "psp3":
        if options:
            raise InvalidValue(
                "options",
                ", ".join(options),
                "none for robot 'psp3'; ClosedLoopRobot.from_urdf takes them with its files",
            )
        return load_psp3(parameters)
    if parameters != "default":
        raise InvalidValue(
            "parameters",
            parameters,
            f"'default' for robot {str(name)!r}: only 'psp3' has other sets",
        )
    if name in MJCF_ROBOTS:
        # Joints with springs move even without a motor.
        return ClosedLoopRobot.from_mjcf(ROBOT_FILES / f"{name}.xml", **{"free": "keep", **options})
    if name in ROBOTS:
        return _from_urdf(ROBOT_FILES / f"{name}.urdf", options)
    if isinstance(name, Path) or (isinstance(name, str) and name.lower().endswith(ENDINGS)):
        return _from_file(Path(name), options)
    raise UnknownRobot(name, ROBOTS)


def _from_file(path: Path, options: dict[str, Any]) -> ClosedLoopRobot:
    """Return the robot of a file, read in the format that its outermost element names."""
    if path.suffix.lower() == ".xacro":
        raise InvalidRobotFile(
            path, "is a macro file: expand it first, with xacro robot.urdf.xacro > robot.urdf"
        )
    # The SDF reader accepts what SDFormat's library accepts, which is not always strict XML.
    tag = "sdf" if path.suffix.lower() in SDF_ENDINGS else read_xml(path, None).tag
    if tag not in READERS:
        raise InvalidRobotFile(
            path,
            f"its outermost element is <{tag}>; robots are read from {', '.join(READERS)}",
        )
    if tag == "robot":
        return _from_urdf(path, options)
    robot: ClosedLoopRobot = getattr(ClosedLoopRobot, READERS[tag])(path, **options)
    return robot


def _from_urdf(path: Path, options: dict[str, Any]) -> ClosedLoopRobot:
    """Return the robot of a URDF, with the loop file and the poses beside it."""
    for option, ending in (("loops", ".yaml"), ("srdf", ".srdf")):
        if path.with_suffix(ending).is_file():
            options = {option: path.with_suffix(ending), **options}
    return ClosedLoopRobot.from_urdf(path, **options)
