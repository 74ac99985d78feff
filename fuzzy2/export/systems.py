"""Fuzzy systems in C99."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from fuzzy2.errors import NotExportable
from fuzzy2.export.c_code import Argument, CCode, CWriter, Known
from fuzzy2.support.checks import Array
from fuzzy2.systems.kernels import evaluate_in, work_size


class System(NamedTuple):
    """The table of a system."""

    table: Array


def write_outputs(system, x, out):
    """Write the outputs at x. Return 1, or 0 where an input is not finite: NaN is written then."""
    work = np.empty(work_size(system.table))
    total = 0.0
    for i in range(x.size):
        total += x[i] - x[i]
    if total != 0.0:
        for j in range(out.size):
            out[j] = total
        return 0
    evaluate_in(system.table, x, 0, 0.0, True, work, out, 0)
    return 1


def export_c(
    system: Any,
    path: str | Path,
    *,
    precision: Literal["double", "single"] = "double",
    name: str = "system",
) -> CCode:
    """Write a fuzzy system as one self-contained .c and .h file."""
    table = getattr(system, "_table", None)
    if table is None:
        raise NotExportable(type(system).__name__, "it has no table", "another system")
    writer = CWriter(name, precision, ["A fuzzy system."])
    p, m = len(system.inputs), system.n_outputs
    writer.add(
        "evaluate",
        "Write the outputs.",
        write_outputs,
        [
            Known("system", System(np.asarray(table))),
            Argument("x", "inputs", p),
            Argument("out", "outputs", m, "out"),
        ],
        "1, or 0 where an input is not finite",
    )
    code = writer.code()
    code.write(path)
    return code
