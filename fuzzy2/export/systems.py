"""Fuzzy systems as C99: which kernels and tables say what a system says."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import numpy as np

from fuzzy2.errors import NotExportable
from fuzzy2.export.c_code import Argument, CCode, CWriter, Known
from fuzzy2.export.system_kernels import Averaged, Clouds, Corollary, Pair, Planes, answer
from fuzzy2.systems.anya import AnYaSystem
from fuzzy2.systems.general_type2 import GeneralType2System
from fuzzy2.systems.parallel import ParallelSystem
from fuzzy2.systems.system import FuzzySystem


def export_c(
    system: Any,
    path: str | Path,
    *,
    precision: Literal["double", "single"] = "double",
    name: str = "system",
) -> CCode:
    """Write a fuzzy system as one self-contained .c and .h file of C99.

    The code is translated from the kernels that evaluate the system here, and gives the same
    numbers in double precision. It takes no memory from the heap, does not call itself, writes to
    no global variables and needs nothing but ``math.h``.

    Parameters
    ----------
    system : FuzzySystem, ParallelSystem, AnYaSystem, or a fitted learner
        What is written; of a learner its ``system_``, so a classifier answers with the grades of
        its classes.
    path : str or Path
        Folder for ``name.h`` and ``name.c``; it is made if it is not there.
    precision : {"double", "single"}
        Of all numbers; single for processors whose floating-point unit knows no other.
    name : str
        Prefix of all names, and the name of the files.

    Returns
    -------
    CCode
        The text of both files, and what is in them.

    Raises
    ------
    NotExportable
        If a part of the system has no form in C; it is named, with what to take in its place.
    NotFitted
        If a learner has not learned.
    InvalidValue
        If ``name`` is no name in C.
    UnknownName
        If there is no such precision.
    """
    code = c_code_of(system, precision=precision, name=name)
    code.write(path)
    return code


def c_code_of(
    system: Any, *, precision: Literal["double", "single"] = "double", name: str = "system"
) -> CCode:
    """Return what :func:`export_c` writes."""
    system = system_of(system)
    writer = CWriter(name, precision, _about(system, precision))
    inputs, outputs = system.input_names, system.output_names
    writer.add(
        "evaluate",
        "Write the outputs of the system.",
        answer,
        [
            Known("system", tables_of(system)),
            Argument("x", f"the inputs: {_listed(inputs)}", len(inputs)),
            Argument("out", f"the outputs: {_listed(outputs)}", len(outputs), "out"),
        ],
        "1, or 0 where there is no answer, because an input is not finite or united sets need more "
        "memory than there is: then all outputs are NaN. Where no rule fires an output is NaN, "
        "too, unless it has a default",
    )
    return writer.code()


def system_of(thing: Any) -> Any:
    """Return the system that something is or has learned."""
    if hasattr(thing, "fit"):
        thing = thing._system()
    if not isinstance(thing, FuzzySystem | ParallelSystem | AnYaSystem):
        raise NotExportable(
            f"a {type(thing).__name__}", "it is no fuzzy system", "a system, or a fitted learner"
        )
    return thing


def tables_of(system: Any) -> Any:
    """Return the tables of a system, for :func:`fuzzy2.export.system_kernels.outputs_of`.

    Raises
    ------
    NotExportable
        If there are none.
    """
    if isinstance(system, ParallelSystem):
        return _side_by_side(list(system.systems))
    if isinstance(system, AnYaSystem):
        sizes = [cloud.size for cloud in system.clouds]
        return Clouds(
            np.concatenate(system.clouds),
            np.cumsum([0, *sizes]),
            np.array(system.asked),
            tables_of(system.consequents),
        )
    if isinstance(system, GeneralType2System):
        return _of_general(system)
    if system.table is not None:
        return Averaged(system.table)
    for tables in (system.averaged_points, system.united_sets):
        if tables is not None:
            return tables
    raise _without_table(system)


def _side_by_side(systems: list[FuzzySystem]) -> Any:
    first, *rest = systems
    if not rest:
        return tables_of(first)
    return Pair(tables_of(first), _side_by_side(rest), first.n_outputs)


def _of_general(system: GeneralType2System) -> Any:
    table = system.table
    if table is None or not (system.in_one_loop or system.reduction == "gaussian"):
        raise _without_table(system)
    if system.reduction == "gaussian":
        middles, spreads = system.moments
        return Corollary(table, middles.ravel(), spreads.ravel())
    return Planes(table, system.widths, system.alphas)


def _without_table(system: FuzzySystem) -> NotExportable:
    return NotExportable(f"{system!r}", "no kernel knows it", "Gaussians, center of sets")


def _about(system: Any, precision: str) -> list[str]:
    """Return the paragraphs of the header."""
    return [
        f"{system!r} in {precision} precision.",
        "Inputs and outputs have the units that the system was made with.",
    ]


def _listed(names: Any) -> str:
    return ", ".join(f"[{i}] {name}" for i, name in enumerate(names))
