"""One function that exports any supported object as C."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

from fuzzy2.errors import NotExportable
from fuzzy2.export import systems
from fuzzy2.export.c_code import CCode
from fuzzy2.systems.anya import AnYaSystem
from fuzzy2.systems.parallel import ParallelSystem
from fuzzy2.systems.system import FuzzySystem
from psp3.export import controllers, robots


def _code_of_system(
    thing: Any, *, precision: Literal["double", "single"] = "double", name: str | None = None
) -> CCode | None:
    """Return the C code of a fuzzy system; None if the thing is not one."""
    if not isinstance(thing, FuzzySystem | ParallelSystem | AnYaSystem):
        return None
    return systems.c_code_of(thing, precision=precision, name="system" if name is None else name)


KINDS: tuple[Callable[..., CCode | None], ...] = (
    robots.code_of,
    controllers.code_of,
    _code_of_system,
)
"""Exporters. Each takes the thing, the name, the precision and further options, and returns None
for things that it does not export.
"""


def c_code(
    thing: Any,
    *,
    precision: Literal["double", "single"] = "double",
    name: str | None = None,
    **options: Any,
) -> CCode:
    """Return the C code of a thing without writing it, see :func:`export_c`."""
    for code_of in KINDS:
        code = code_of(thing, precision=precision, name=name, **options)
        if code is not None:
            return code
    wanted = "a robot, a controller that the compiled loop takes or its file, or a fuzzy system"
    raise NotExportable(type(thing).__name__, "it is none of the supported objects", wanted)


def export_c(
    thing: Any,
    path: str | Path,
    *,
    precision: Literal["double", "single"] = "double",
    name: str | None = None,
    **options: Any,
) -> CCode:
    """Write a robot, a controller or a fuzzy system as one self-contained .c and .h file in C99.

    The code is translated from the kernels that Python runs. In double precision, and with the same
    C library functions, its numbers are the same to the last bit. It allocates no memory and needs
    only ``math.h``.

    Parameters
    ----------
    thing : robot, controller, fuzzy system, or path
        What to write, see :mod:`psp3.export.robots`, :mod:`psp3.export.controllers` and
        :func:`fuzzy2.export_c`; or the file of a controller.
    path : path
        The folder for the files.
    precision : {"double", "single"}
        Precision of all numbers.
    name : str, optional
        Prefix of all names, and stem of the file names: an identifier of C.
    **options
        Further options of the kind of thing.

    Returns
    -------
    CCode
        The text of both files, and a description of their functions.

    Raises
    ------
    fuzzy2.errors.NotExportable
        If the thing cannot be written in C.
    """
    code = c_code(thing, precision=precision, name=name, **options)
    code.write(path)
    return code
