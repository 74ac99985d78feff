"""Robots and controllers as functional mock-up units (FMUs), for Simulink, OpenModelica, Dymola, ….

An FMU is a zip archive with a description of its variables, source code in C, and a binary for each
platform that it is compiled for. The FMUs of this package are for co-simulation with FMI 2.0 or
3.0. They advance by a whole number of periods with constant inputs, and give the numbers of
:func:`psp3.simulate`.
"""

from __future__ import annotations

import hashlib
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import uuid
import warnings
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from fuzzy2.errors import NotExportable
from fuzzy2.support.text_files import written_whole
from psp3.checks import (
    checked_kind,
    checked_path,
    checked_positive,
    checked_robot,
    checked_steps,
    known_name,
)
from psp3.drives.drive import NO_DRIVE, Drive
from psp3.errors import InvalidValue, SourceOnlyFMU
from psp3.export.fmu_controller import controller_model
from psp3.export.fmu_fmi2 import FMI2
from psp3.export.fmu_fmi3 import FMI3
from psp3.export.fmu_glue import glue
from psp3.export.fmu_model import Model, Variable
from psp3.export.fmu_plant import plant_model
from psp3.export.fmu_standard import Standard
from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque

FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-fvisibility=hidden", "-shared")
"""Compiler flags. Without floating-point contraction the numbers are those of the compiled loop."""

_C_FILES, _SHARED = Path(__file__).with_name("fmi"), "instance.h"
_LONGEST = 200
"""Greatest length of an identifier, which leaves room for endings in a file name."""

LONGEST_PERIOD = 1e6
"""Longest control period [s]; a longer one is a mistake."""

_BEGINNING = (1980, 1, 1, 0, 0, 0)
_STANDARDS = {standard.version: standard for standard in (FMI2, FMI3)}


@dataclass(frozen=True)
class FMU:
    """An FMU that was written.

    Parameters
    ----------
    path : Path
        The file.
    name : str
        The identifier of the model.
    guid : str
        Its unique identifier; the same code and variables give the same one.
    variables : tuple of Variable
        Its variables, in the order of their value references.
    period : float
        The shortest communication step [s], of which all are multiples.
    has_binary : bool
        Whether it has a binary for Linux, in addition to source code.
    """

    path: Path
    name: str
    guid: str
    variables: tuple[Variable, ...]
    period: float
    has_binary: bool


def export_fmu(
    thing: Any,
    path: str | Path,
    *,
    robot: Any = None,
    period: float = 0.002,
    steps: int = 1,
    drive: Drive | Sequence[Drive] = NO_DRIVE,
    torque_limit: ArrayLike | None = None,
    name: str | None = None,
    version: str = "2.0",
) -> FMU:
    """Write a robot or a controller as an FMU for co-simulation, FMI 2.0 or 3.0.

    A robot's inputs are the forces of its motors, and its outputs are its positions and speeds, in
    the steps of :class:`psp3.simulation.runge_kutta.RungeKutta`. A controller's inputs are
    positions, speeds and the desired motion at the beginning of a step, and its outputs are the
    forces. Parameters of a robot are its initial positions and speeds, and the largest forces of
    its motors.

    The numbers are those of :func:`psp3.simulate` with the same period. Most programs step robot
    and controller in parallel; the forces then arrive one period late, as with
    ``simulate(delay=1)``. If the controller takes each step first, there is no delay.

    Parameters
    ----------
    thing : Robot, controller, or path
        What to write: a robot, a controller, or the file of a trained controller.
    path : path
        The file to write, ``*.fmu``.
    robot : Robot, optional
        The robot of the controller, if it does not know its robot.
    period : float
        The control period; all communication steps are multiples of it [s].
    steps : int
        Integration steps of a robot in a period.
    drive : Drive or sequence of Drive
        Friction and motor inertia of a robot's actuated joints.
    torque_limit : float or (m,) array_like, optional
        Initial value of the largest force of a robot's motors, as in :func:`psp3.simulate` [N], [N
        m]; no limit by default.
    name : str, optional
        The identifier of the model; by default from the name of the file.
    version : {"2.0", "3.0"}
        Version of FMI.

    Returns
    -------
    FMU
        The FMU that was written. It has a binary if this is Linux on x86-64 with ``gcc``, and
        always source code.

    Raises
    ------
    fuzzy2.errors.NotExportable
        If the thing cannot be written in C, or FMI cannot hold its names.
    InvalidValue
        If an argument is malformed.
    UnknownName
        If there is no such version.

    Warns
    -----
    SourceOnlyFMU
        If the FMU has no binary.
    """
    path, period = checked_path("path", path), checked_positive("period", period)
    if period > LONGEST_PERIOD:
        raise InvalidValue("period", period, f"at most {LONGEST_PERIOD:g} s")
    if path.suffix.lower() != ".fmu":
        raise InvalidValue("path", str(path), "a name that ends in .fmu")
    if name is not None:
        checked_kind("name", name, str, "an identifier of C")
    identifier = _identifier(path.stem) if name is None else name
    if not re.fullmatch(rf"[A-Za-z_]\w{{0,{_LONGEST - 1}}}", identifier, re.ASCII):
        wanted = f"an identifier of C: at most {_LONGEST} letters, digits and underscores"
        raise InvalidValue("name", name, wanted)
    steps, standard = checked_steps(steps), _standard(version)
    if robot is not None:
        checked_robot(robot)
        if hasattr(thing, "compiled_steps"):
            raise InvalidValue("robot", robot, "left out: it is for controllers")
    if isinstance(thing, str | Path):
        thing = FuzzyComputedTorque.load(thing, robot)
    if hasattr(thing, "torque") and hasattr(thing, "reset"):
        if steps != 1 or drive != NO_DRIVE or torque_limit is not None:
            given = (steps, drive, torque_limit)
            raise InvalidValue(
                "steps, drive or torque_limit", given, "left out: a controller has none"
            )
        model = controller_model(thing, robot, identifier, period)
    elif hasattr(thing, "compiled_steps"):
        model = plant_model(thing, identifier, period, steps, drive, torque_limit)
    else:
        wanted = "a robot, a controller, or the file of a trained controller"
        raise NotExportable(type(thing).__name__, "it is no model", wanted)
    return _written(model, path, standard)


def _standard(version: str) -> Standard:
    """Return the functions of a version of FMI."""
    known_name("version of FMI", version, _STANDARDS)
    return _STANDARDS[version]


def _identifier(text: str) -> str:
    """Return an identifier of C that resembles a text."""
    word = re.sub(r"\W+", "_", text, flags=re.ASCII)
    beginning = "" if word[:1].isalpha() or word[:1] == "_" else "model_"
    return f"{beginning}{word}"[:_LONGEST]


def _written(model: Model, path: Path, standard: Standard) -> FMU:
    """Write an FMU."""
    code = model.code
    files = {f"{code.name}.h": code.header, f"{code.name}.c": code.source}
    files |= {
        name: (_C_FILES / name).read_text(encoding="utf-8") for name in (standard.face, _SHARED)
    }
    # The identifier of the FMU is a hash of everything except itself.
    guid = _guid([*files.values(), glue(model, ""), standard.description(model, "", [])])
    files["model.h"] = glue(model, guid)
    sources = [file for file in files if file.endswith(".c")]
    binary, why_not = _compiled(files, sources, model.name)
    description = standard.description(model, guid, sources)
    contents: dict[str, str | bytes] = {"modelDescription.xml": description}
    files |= standard.about_sources(model, sources)
    contents |= {f"sources/{file}": text for file, text in files.items()}
    if binary is None:
        warnings.warn(SourceOnlyFMU(path, why_not), stacklevel=3)
    else:
        contents[f"binaries/{standard.platform}/{model.name}.so"] = binary
    _zip(contents, path)
    return FMU(path, model.name, guid, model.variables, model.period, binary is not None)


def _guid(texts: list[str]) -> str:
    digest = hashlib.sha256("\0".join(texts).encode()).digest()
    return f"{{{uuid.UUID(bytes=digest[:16])}}}"


def _compiled(files: dict[str, str], sources: list[str], name: str) -> tuple[bytes | None, str]:
    """Return a shared library, or None and the reason."""
    if sys.platform != "linux" or platform.machine() != "x86_64":
        return None, "binaries are made on Linux for x86-64 only"
    compiler = shutil.which("gcc")
    if compiler is None:
        return None, "there is no gcc"
    with tempfile.TemporaryDirectory() as folder:
        for file, text in files.items():
            Path(folder, file).write_text(text, encoding="utf-8")
        command = [compiler, *FLAGS, "-o", f"{name}.so", *sources, "-lm"]
        run = subprocess.run(command, cwd=folder, capture_output=True, check=False)
        if run.returncode != 0:
            return None, f"gcc: {run.stderr.decode(errors='replace').strip()[:500]}"
        return Path(folder, f"{name}.so").read_bytes(), ""


def _zip(contents: dict[str, str | bytes], path: Path) -> None:
    """Write a zip archive that depends only on its contents."""
    with (
        written_whole(path, "wb") as file,
        zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive,
    ):
        for place, content in contents.items():
            entry = zipfile.ZipInfo(place, _BEGINNING)
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            archive.writestr(entry, content)
