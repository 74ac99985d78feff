"""A folder around C code: a program, a test with expected values, a Makefile and a README.

Everything is generated from the description of the functions,
:class:`fuzzy2.export.c_code.CFunction`, whatever they compute. The expected values are the results
of the kernels in Python.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np

from fuzzy2.errors import InvalidValue
from fuzzy2.export import project_calls
from fuzzy2.export.c_code import CCode
from fuzzy2.export.project_cases import CASES, Cases, drawn
from fuzzy2.export.project_files import replace_files
from fuzzy2.export.project_readme import readme
from fuzzy2.export.systems import c_code_of, system_of
from fuzzy2.support.checks import Array
from fuzzy2.systems.anya import AnYaSystem
from fuzzy2.systems.parallel import ParallelSystem

RESERVED = ("calls", "cases", "main", "runner", "test")
"""Names of the files in the folder that are not files of the code."""

TEMPLATES = Path(__file__).parent / "templates"

CPUS = {
    "double": "-mcpu=cortex-m7 -mfpu=fpv5-d16",
    "single": "-mcpu=cortex-m4 -mfpu=fpv4-sp-d16",
}
"""Compiler options for a Cortex-M with floating-point hardware of this precision."""


def write_project(code: CCode, folder: str | Path, inputs: Mapping[str, Array]) -> list[Path]:
    """Write code with a program, a test, a Makefile and a README; return the paths of all files.

    Files of an earlier export are replaced, see :mod:`fuzzy2.export.project_files`.

    Parameters
    ----------
    code : CCode
        The code, whose files are written as well.
    folder : path
        The folder, which is created if necessary.
    inputs : mapping of str to ndarray (CASES, n)
        Inputs of the test cases for each argument that is read, by name, see
        :func:`fuzzy2.export.project_cases.drawn`. If an array has more columns than the argument,
        its first columns are used.

    Raises
    ------
    InvalidValue
        If the name of the code is that of another file in the folder, or if an argument has no
        inputs.
    FileInTheWay
        If the folder has a file with one of the names that was not left there unchanged by an
        export.
    """
    if code.name in RESERVED:
        wanted = f"none of {', '.join(RESERVED)}, which are names of files around the code"
        raise InvalidValue("name", code.name, wanted)
    cases = Cases(code, inputs)
    texts = {
        "calls.h": project_calls.header(code),
        "calls.c": project_calls.source(code),
        "cases.h": cases.header(),
        "cases.c": cases.source(),
        "README.md": readme(code),
    }
    for name in ("main.c", "test.c", "Makefile", "stack.awk"):
        text = (TEMPLATES / name).read_text(encoding="utf-8")
        texts[name] = text.replace("@NAME@", code.name).replace("@CPU@", CPUS[code.precision.name])
    texts |= {f"{code.name}.h": code.header, f"{code.name}.c": code.source}
    return replace_files(texts, Path(folder))


def export_project(
    system: Any,
    folder: str | Path,
    *,
    precision: Literal["double", "single"] = "double",
    name: str = "system",
) -> CCode:
    """Write a fuzzy system in C with a program, a test, a Makefile and a README.

    Parameters
    ----------
    system, precision, name
        See :func:`fuzzy2.export_c`.
    folder : path
        The folder, which is created if necessary.

    Raises
    ------
    NotExportable, NotFitted, InvalidValue, UnknownName
        As :func:`fuzzy2.export_c` does.
    FileInTheWay
        As :func:`write_project` does.
    """
    code = c_code_of(system, precision=precision, name=name)
    write_project(code, folder, {"x": inputs_of(system)})
    return code


def inputs_of(system: Any) -> Array:
    """Return test inputs of a fuzzy system, most of them within its ranges.

    Parameters
    ----------
    system : FuzzySystem, ParallelSystem, AnYaSystem, or a fitted learner

    Returns
    -------
    ndarray (CASES, inputs)
    """
    one = system_of(system)
    if isinstance(one, AnYaSystem):
        return drawn(*np.transpose([(cloud.min(), cloud.max()) for cloud in one.clouds]))
    if isinstance(one, ParallelSystem):
        one = one.systems[0]
    return drawn(*np.transpose(one.domain() if one.input_ranges is None else one.input_ranges))


__all__ = ["CASES", "drawn", "export_project", "inputs_of", "write_project"]
