"""Fuzzy systems as C99: which kernels and tables say what a system says."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Literal

import numpy as np

from fuzzy2.errors import NotExportable
from fuzzy2.export.c_code import Argument, CCode, CWriter, Known
from fuzzy2.export.system_kernels import (
    Averaged,
    Clouds,
    Corollary,
    Level,
    Nothing,
    Pair,
    Planes,
    answer,
)
from fuzzy2.operations.t_norms import T_CONORMS, T_NORMS
from fuzzy2.systems.anya import AnYaSystem
from fuzzy2.systems.consequents import Formulas
from fuzzy2.systems.firing_kernels import HEADER, TERM
from fuzzy2.systems.general_type2 import GeneralType2System
from fuzzy2.systems.parallel import ParallelSystem
from fuzzy2.systems.shape_kernels import SAMPLES
from fuzzy2.systems.system import FuzzySystem
from fuzzy2.systems.term_rows import TermRows


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
    constants = without_shapes(getattr(system, "systems", [system]))
    writer = CWriter(name, precision, _about(system, precision), constants=constants)
    inputs, outputs = system.input_names, system.output_names
    writer.add(
        "evaluate",
        "Write the outputs of the system.",
        answer,
        [
            Known("system", tables_of(system)),
            Argument("x", f"the inputs: {_listed(inputs, _ranges(system))}", len(inputs)),
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


def without_shapes(systems: Iterable[Any]) -> dict[str, float]:
    """Return numbers of kernels that leave out the shapes of terms, where no system has one.

    Gaussians and trapezoids are none of these. Without shapes ``pow`` and its tables are spared.
    """
    for system in systems:
        table = getattr(system, "table", None)
        if table is None:
            return {}
        kinds = table[HEADER + 1 : HEADER + TERM * int(table[1]) : TERM]
        if (kinds >= SAMPLES).any():
            return {}
    return {"SAMPLES": math.inf}


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
    """Return one table for all α-planes where there is one, else the tables of each."""
    table = system.table
    if system.reduction == "gaussian":
        if table is None:
            raise _without_table(system)
        middles, spreads = system.moments
        return Corollary(table, middles.ravel(), spreads.ravel())
    if table is not None and system.in_one_loop:
        return Planes(table, system.widths, system.alphas)
    defaults = np.full(system.n_outputs, np.nan)
    if system.default_outputs is not None:
        defaults = np.array(system.default_outputs)
    levels: Any = Nothing(0.0)
    for share, plane in system.explained_by:
        try:
            tables = tables_of(plane)
        except NotExportable as error:
            raise NotExportable(
                f"an α-plane, of it {error.what}",
                error.why,
                f"{error.remedy}; or Gaussian type-2 sets under center of sets by an exact method, "
                "without default outputs, which takes all planes from one table",
            ) from error
        levels = Level(levels, tables, share, defaults)
    return levels


def _without_table(system: FuzzySystem) -> NotExportable:
    """Return the error that names the part of a system that no kernel knows."""
    for name, terms, words in zip(
        system.input_names, system.inputs, system.term_names, strict=True
    ):
        for term, word in zip(terms, words, strict=True):
            if not TermRows().add(0, term, system.kernel_row(term)):
                return NotExportable(
                    f"the term {word!r} of {name!r}, {term!r:.80}",
                    "no kernel knows this set",
                    "its samples, term.sample(points), between which it is linear",
                )
    if system.fuzzifiers is not None:
        return NotExportable(
            "the fuzzifier",
            "no kernel knows how it fires a term",
            "a singleton fuzzifier, and as terms what this one makes of them: "
            "SampledSet(points, fuzzifier.firing(term, points, system.t_norm)[:, 1])",
        )
    for what, norm, known in (
        ("the t-norm", system.t_norm, T_NORMS),
        ("the t-conorm of or", system.disjunction, T_CONORMS),
        ("the implication", system.implication, T_NORMS),
    ):
        if norm != known.get(norm.name):
            return NotExportable(
                f"{what}, {norm.name!r}",
                "no kernel knows this function",
                f"one of {', '.join(known)}",
            )
    return _of_outputs(system)


def _of_outputs(system: FuzzySystem) -> NotExportable:
    if isinstance(system.consequents, Formulas):
        return NotExportable(
            "consequents that are formulas", "no kernel evaluates text", "fuzzy2.Linear or numbers"
        )
    kind = system.type_reduction
    if kind in ("centroid", "center_of_sums"):
        if system.integration != "exact":
            return NotExportable(
                f"integration {system.integration!r}",
                "kernels integrate exactly",
                "system.replace(integration='exact')",
            )
        return NotExportable(
            "the output sets",
            "kernels unite Gaussians and trapezoids, by the maximum or the sum, clipped by the "
            "minimum or scaled by the product, under an exact method, 'nie_tan' or "
            "'begian_melek_mendel'",
            "these, or type_reduction='center_of_sets', which takes the centroid of any set",
        )
    if isinstance(system.rules, tuple) and system.table is None and kind == "center_of_sets":
        return NotExportable(
            "a hedge of the rules",
            "kernels know powers of grades",
            "fuzzy2.systems.hedges.Hedge(word, power=...)",
        )
    return NotExportable(
        f"type reduction {kind!r}",
        "no kernel knows it",
        "system.replace(type_reduction='center_of_sets'), 'height', 'centroid' or 'weighted_sum'",
    )


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
