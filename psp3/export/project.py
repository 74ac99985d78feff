"""A folder with exported C code, a program, a test and a Makefile."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

from fuzzy2.export.c_code import CCode, Mixed
from fuzzy2.export.project import export_project as export_system
from fuzzy2.export.project import write_project
from fuzzy2.files.formats import load as load_system
from fuzzy2.support.text_files import read_text
from psp3.export import typical_inputs
from psp3.export.controllers import robot_of
from psp3.export.face import c_code
from psp3.export.robot_text import LONGEST
from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
from psp3.fuzzy_control.controller_files import FORMAT, FORMAT_OF_ANY
from psp3.fuzzy_control.kernels import NO_MODEL
from psp3.loading import ENDINGS, READERS
from psp3.loading import load as load_robot
from psp3.robots.robot import Robot


def opened(source: str | Path, robot: Any = None) -> Any:
    """Return the robot of a name, or the robot, controller or fuzzy system in a file.

    Parameters
    ----------
    source : str or path
        The name or the file.
    robot : Robot, optional
        The robot of a trained controller that does not come with the package.

    Raises
    ------
    UnknownRobot
        If there is neither a file nor a robot of this name.
    PSP3Error, fuzzy2.errors.Fuzzy2Error, OSError
        Errors of the reader of the file.
    """
    path, suffix = Path(source), Path(source).suffix.lower()
    if is_robot(source):
        return load_robot(path if suffix else str(source))
    if suffix == ".json" and _format_of(path) in (FORMAT, FORMAT_OF_ANY):
        return FuzzyComputedTorque.load(path, robot)
    return load_system(path)


def is_robot(source: str | Path) -> bool:
    """Return whether a source is the name of a robot, or the file of one.

    Parameters
    ----------
    source : str or path
        The name or the file.
    """
    path, suffix = Path(source), Path(source).suffix.lower()
    if not suffix and not path.is_file():
        return True
    return suffix in ENDINGS and (suffix != ".xml" or _outermost(path) in READERS)


def export_project(
    thing: Any,
    folder: str | Path,
    *,
    precision: Literal["double", "single"] = "double",
    name: str | None = None,
    **options: Any,
) -> CCode:
    """Write a robot, a controller or a fuzzy system in C, with a program, a test and a Makefile.

    The test has 200 cases, each of which calls every function once, and Python's results.

    Parameters
    ----------
    thing, precision, name, **options
        See :func:`psp3.export_c`.
    folder : path
        The folder to write to; it is made if it does not exist.

    Returns
    -------
    CCode
        The code, with a description of its functions.

    Raises
    ------
    fuzzy2.errors.NotExportable
        If the thing cannot be written in C.
    fuzzy2.errors.FileInTheWay
        If the folder has a file of one of these names that is not an unchanged earlier export.
    """
    if hasattr(thing, "input_names"):
        prefix = "system" if name is None else name
        return export_system(thing, folder, precision=precision, name=prefix)
    code = c_code(thing, precision=precision, name=name, **options)
    if isinstance(thing, Robot):
        write_project(code, folder, typical_inputs.of_robot(thing))
        return code
    robot = options.get("robot") or robot_of(thing)
    write_project(_runnable(code, robot), folder, typical_inputs.of_controller(robot))
    return code


def _runnable(code: CCode, robot: Any) -> CCode:
    """Return a description whose functions also run in Python.

    A controller without a model has none in C. In Python the compiler needs a model, although no
    number of it is used.
    """
    functions = tuple(
        replace(one, known=tuple(_with_model(known, robot) for known in one.known))
        for one in code.functions
    )
    return replace(code, functions=functions)


def _with_model(known: Any, robot: Any) -> Any:
    if isinstance(known, Mixed):
        return replace(known, thing=_with_model(known.thing, robot))
    if isinstance(getattr(known, "model", None), type(NO_MODEL)):
        return known._replace(model=robot.compiled_table())
    return known


def identifier(source: str | Path) -> str:
    """Return a name in C for a thing's name or the stem of its file.

    Parameters
    ----------
    source : str or path
        The name or the file.

    Returns
    -------
    str
        Letters, digits and underscores, a letter first.
    """
    name = re.sub(r"\W", "_", Path(source).stem, flags=re.ASCII)[:LONGEST]
    return name if name[:1].isalpha() else f"code_{name}"


def _outermost(path: Path) -> str:
    """Return the name of the outermost element of an XML file."""
    found = re.search(
        r"<([A-Za-z_][\w.-]*)", re.sub(r"<!--.*?-->", "", read_text(path), flags=re.S)
    )
    return found[1] if found else ""


def _format_of(path: Path) -> Any:
    """Return the format that a JSON file states, if any."""
    try:
        content = json.loads(read_text(path))
    except (ValueError, RecursionError):
        return None
    return content.get("format") if isinstance(content, dict) else None
