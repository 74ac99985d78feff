"""Export of fuzzy systems to C99: kernels and tables that compute a system's outputs."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Literal

import numpy as np

from fuzzy2.errors import NotExportable
from fuzzy2.export.c_code import Argument, CCode, CWriter, Known
from fuzzy2.export.numbers import Precision
from fuzzy2.export.refusals import refusal_of, refusal_of_planes
from fuzzy2.export.system_kernels import (
    Averaged,
    Clouds,
    Corollary,
    Defaulted,
    Level,
    Nothing,
    Pair,
    Planes,
    answer,
    interval,
)
from fuzzy2.export.unanswered import warn_of_unanswered
from fuzzy2.support.formula_kernels import left_out
from fuzzy2.systems.anya import AnYaSystem
from fuzzy2.systems.consequents import Linear
from fuzzy2.systems.firing_kernels import HEADER, TERM
from fuzzy2.systems.general_type2 import GeneralType2System
from fuzzy2.systems.operators import CRISP_ONLY
from fuzzy2.systems.parallel import ParallelSystem
from fuzzy2.systems.shape_kernels import SAMPLES
from fuzzy2.systems.system import FuzzySystem, Type1System


def export_c(
    system: Any,
    path: str | Path,
    *,
    precision: Literal["double", "single"] = "double",
    name: str = "system",
) -> CCode:
    """Write a fuzzy system as one self-contained .c and .h file of C99.

    The code is translated from the kernels that evaluate the system in Python, and gives the same
    numbers in double precision. It does not allocate memory, is not recursive, does not write to
    global variables and needs only ``math.h``.

    Parameters
    ----------
    system : FuzzySystem, ParallelSystem, AnYaSystem, or a fitted learner
        The system. For a learner it is ``system_``, so the outputs of a classifier are the grades
        of its classes.
    path : str or Path
        Folder for ``name.h`` and ``name.c``, which is created if necessary.
    precision : {"double", "single"}
        Precision of all numbers. Use single precision for processors whose floating-point unit does
        not support double precision.
    name : str
        Prefix of all names, and the name of the files.

    Returns
    -------
    CCode
        The text of both files, with a description of their functions.

    Raises
    ------
    NotExportable
        If a part of the system cannot be written in C. The message names the part and its
        replacement.
    NotFitted
        If a learner is not fitted.
    InvalidValue
        If ``name`` is not an identifier in C.
    UnknownName
        If there is no such precision.

    Warns
    -----
    UnansweredInC
        If the code has no answer at some inputs within the ranges, where Python has one.
    """
    code = c_code_of(system, precision=precision, name=name)
    code.write(path)
    return code


def c_code_of(
    system: Any, *, precision: Literal["double", "single"] = "double", name: str = "system"
) -> CCode:
    """Return the code that :func:`export_c` writes."""
    system = system_of(system)
    tables = Known("system", tables_of(system))
    each = getattr(system, "systems", [system])
    for one in each:
        if isinstance(one, FuzzySystem):
            warn_of_unanswered(one, _tabled(one), name)
    constants, never = without_shapes(each), _functions_left_out(each)
    about = _about(system, Precision(precision).name)
    writer = CWriter(name, precision, about, constants=constants, never=never)
    inputs, outputs = system.input_names, system.output_names
    x = Argument("x", f"the inputs: {_listed(inputs, _ranges(system))}", len(inputs))
    out = Argument("out", f"the outputs: {_listed(outputs)}", len(outputs), "out")
    returns = (
        "1, or 0 where there is no answer, because an input is not finite or united sets need more "
        "memory than there is: then all numbers are NaN. Where no rule fires an output is NaN, "
        "too, unless it has a default"
    )
    does = "Write the outputs of the system."
    writer.add("evaluate", does, answer, [tables, x, out], returns)
    if has_intervals(system):
        listed = f"left and right end, one after the other, of {_listed(outputs)}"
        if getattr(system, "reduction", "") == "gaussian":
            listed = f"mean and standard deviation, one after the other, of {_listed(outputs)}"
        ends = Argument("ends", listed, 2 * len(outputs), "out")
        does = (
            "Write the type-reduced intervals of the outputs, those of the lowest α-plane if any."
        )
        writer.add("interval", does, interval, [tables, x, ends], returns)
    return writer.code()


def has_intervals(system: Any) -> bool:
    """Return whether an output of a system may be an interval with a width."""
    if isinstance(system, ParallelSystem):
        return any(has_intervals(one) for one in system.systems)
    if isinstance(system, AnYaSystem):
        return has_intervals(system.consequents)
    if system.method in ("nie_tan", "begian_melek_mendel") or system.type_reduction in CRISP_ONLY:
        return False
    left, right = np.moveaxis(system.consequent_intervals, -1, 0)
    uncertain = bool((left < right).any())
    if isinstance(system.consequents, Linear):
        uncertain = bool((system.consequents.spreads > 0.0).any())
    return uncertain or not isinstance(system, Type1System)


def system_of(thing: Any) -> Any:
    """Return a system, or the system of a learner."""
    if hasattr(thing, "fit"):
        thing = thing._system()
    if not isinstance(thing, FuzzySystem | ParallelSystem | AnYaSystem):
        raise NotExportable(
            f"a {type(thing).__name__}", "it is not a fuzzy system", "a system, or a fitted learner"
        )
    return thing


def without_shapes(systems: Iterable[Any]) -> dict[str, float]:
    """Return replacements for kernels that leave out the shapes of terms that no system uses.

    Gaussians and trapezoids are always included. Without other shapes, ``pow`` and its tables are
    not needed.
    """
    for system in (part for one in systems for part in _tabled(one)):
        table, reducer = getattr(system, "table", None), getattr(system, "reducer", None)
        if table is None:
            table = getattr(reducer, "table", None)
        if table is None or hasattr(reducer, "sets"):
            return {}
        kinds = table[HEADER + 1 : HEADER + TERM * int(table[1]) : TERM]
        if (kinds >= SAMPLES).any():
            return {}
    return {"SAMPLES": math.inf}


def _tabled(system: Any) -> list[Any]:
    """Return the systems whose tables are exported: the α-planes if each has its own tables."""
    is_one = not isinstance(system, GeneralType2System) or system.reduction == "gaussian"
    if is_one or (system.table is not None and system.in_one_loop):
        return [system]
    return [plane for _, plane in system.explained_by]


def _functions_left_out(systems: Iterable[Any]) -> tuple[str, ...]:
    """Return the names of formula functions that no formula of a system uses."""
    programs = [
        part.reducer.programs.tolist()
        for system in systems
        for _, part in getattr(system, "explained_by", ())
        if hasattr(part.reducer, "programs")
    ]
    return left_out(programs)


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
    if system.reducer is not None:
        return system.reducer
    raise refusal_of(system)


def _side_by_side(systems: list[FuzzySystem]) -> Any:
    first, *rest = systems
    if not rest:
        return tables_of(first)
    return Pair(tables_of(first), _side_by_side(rest), first.n_outputs)


def _of_general(system: GeneralType2System) -> Any:
    """Return one table for all α-planes if possible, otherwise the tables of each plane."""
    table = system.table
    if system.reduction == "gaussian":
        if table is None:
            raise refusal_of(system)
        middles, spreads = system.moments
        product = int(system.grade_t_norm == "product")
        return Corollary(table, middles.ravel(), spreads.ravel(), product)
    if table is not None and system.in_one_loop:
        return Planes(table, system.widths, system.alphas)
    levels: Any = Nothing(0.0)
    for share, plane in system.explained_by:
        try:
            tables = tables_of(plane)
        except NotExportable as error:
            raise refusal_of_planes(system, error) from error
        levels = Level(levels, tables, share, int(isinstance(levels, Nothing)))
    if system.default_outputs is None:
        return levels
    return Defaulted(levels, np.array(system.default_outputs))


def _about(system: Any, precision: str) -> list[str]:
    """Return the paragraphs of the header."""
    return [
        f"{system!r} in {precision} precision.",
        "Inputs and outputs have the units that the system was made with.",
    ]


def _ranges(system: Any) -> Any:
    first = system.systems[0] if isinstance(system, ParallelSystem) else system
    return getattr(first, "input_ranges", None)


def _listed(names: Any, ranges: Any = None) -> str:
    ends = [""] * len(names) if ranges is None else [f" in [{a:g}, {b:g}]" for a, b in ranges]
    pairs = zip(names, ends, strict=True)
    return ", ".join(f"[{i}] {name}{end}" for i, (name, end) in enumerate(pairs))
