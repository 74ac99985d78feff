"""Tables of a system's outputs, for the compiled loops that reduce them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fuzzy2.operations.t_norms import T_CONORMS, T_NORMS, TNorm
from fuzzy2.support.checks import Array, binary_exponent
from fuzzy2.systems.averages import heights
from fuzzy2.systems.consequents import Formulas, FunctionsOfInputs, Linear
from fuzzy2.systems.firing_kernels import HEADER, TERM
from fuzzy2.systems.operators import HEIGHTS, SUM, UNIONS
from fuzzy2.systems.outputs import Outputs, hangs_on_ratios
from fuzzy2.systems.table import CONORMS, NORMS
from fuzzy2.systems.term_rows import TermRows
from fuzzy2.systems.terms import spread
from fuzzy2.systems.united import GAUSS, TOLERANCE

WAYS = {"nie_tan": 1, "wu_mendel": 2, "begian_melek_mendel": 3}
"""Codes of the direct methods in :mod:`fuzzy2.systems.output_kernels`."""


def tables_of(outputs: Outputs, table: Array, defaults: Array | None) -> Any:
    """Return the tables of outputs for the loop that can reduce them, or None if none can.

    Parameters
    ----------
    outputs : Outputs
        The outputs.
    table : (k,) ndarray
        Table of the system, see :mod:`fuzzy2.systems.table`.
    defaults : (m,) ndarray, or None
        Outputs where no rule fires.
    """
    kind, count = outputs.operators.type_reduction, outputs.intervals.shape[1]
    missing = np.full(count, np.nan) if defaults is None else np.array(defaults)
    if kind == "tsukamoto":
        return _monotonics(outputs, table, missing)
    if kind not in UNIONS:
        return _points(outputs, table, missing)
    if outputs.operators.integration == "exact":
        found = _unions(outputs, table, missing)
        return found or _sampled(outputs, table, missing)
    return _sampled(outputs, table, missing)


def _code_of(norm: TNorm) -> int | None:
    """Return the code of a t-norm; None for a user-defined one, even if its name is known."""
    return NORMS.index(norm.name) if norm == T_NORMS.get(norm.name) else None


def _united_by(outputs: Outputs) -> int | None:
    """Return the code of the rules' t-conorm, -1 for the sum; None for a user-defined one."""
    by = outputs.aggregation
    if by is None or by is SUM:
        return -1
    return CONORMS.index(by.name) if by == T_CONORMS.get(by.name) else None


def _points(outputs: Outputs, table: Array, missing: Array) -> Any:
    """Return the points that are averaged or summed rule by rule."""
    from fuzzy2.systems.output_kernels import Points

    own, none = outputs.operators, np.empty(0, np.int64)
    codes = [WAYS.get(own.method, 0), 0, int(hangs_on_ratios(own)), 0, 0]
    ends, slopes = np.moveaxis(outputs.intervals, 0, 1), np.empty(0)
    grades, shares = np.empty(0), np.empty(0)
    programs, places, leaders = np.empty(0), none, none
    if own.type_reduction in HEIGHTS:
        code = _code_of(own.implication)
        if code is None:
            return None
        ends, grades, shares = _heights(outputs, ends.shape)
        codes[1] = code
    elif own.type_reduction in ("weighted_sum", "united_sum"):
        codes[0] = 4
    if outputs.same:
        united = _united_by(outputs)
        if united is None:
            return None
        codes[3], leaders = united, _leaders(outputs)
    if isinstance(outputs.consequents, Linear):
        ends, slopes = outputs.consequents.by_input()
    elif isinstance(outputs.consequents, Formulas) and not outputs.consequents.asked:
        programs, places, codes[4] = outputs.consequents.programs()
    elif isinstance(outputs.consequents, FunctionsOfInputs):
        return None
    if binary_exponent(np.concatenate([ends.ravel(), slopes.ravel()])):
        return None
    silent = np.zeros(ends.shape[1::-1]) if outputs.silent is None else outputs.silent
    return Points(
        table,
        np.ravel(ends),
        np.ravel(slopes),
        grades,
        shares,
        np.ascontiguousarray(silent.T, dtype=float).ravel(),
        missing,
        np.array(codes),
        leaders,
        programs,
        places,
        np.array(own.shares),
    )


def _heights(outputs: Outputs, shape: tuple[int, ...]) -> tuple[Array, Array, Array]:
    """Return points (m, R, 2), grades (m R 2,) and factors (m R,) of the height reducers."""
    ends, grades, shares = np.zeros(shape), np.zeros(shape), np.ones(shape[:2])
    modified = outputs.operators.type_reduction == "modified_height"
    for j, rules in enumerate(outputs.speaking):
        if not rules.size:
            continue
        points, at = heights(outputs.sets[j])
        ends[j, rules], grades[j, rules] = points[:, np.newaxis], at
        if modified:
            shares[j, rules] = [1.0 / spread(item) ** 2 for item in outputs.sets[j]]
    return ends, grades.ravel(), shares.ravel() if modified else np.empty(0)


def _leaders(outputs: Outputs) -> NDArray[np.int64]:
    """Return for each rule the first rule (m R,) with the same consequent."""
    rules = len(outputs.intervals)
    leaders = np.tile(np.arange(rules), (len(outputs.same), 1))
    for j, groups in enumerate(outputs.same):
        for group in groups:
            leaders[j, group] = group[0]
    return leaders.ravel()


def _unions(outputs: Outputs, table: Array, missing: Array) -> Any:
    """Return the sets that are united, for integration or for a search of maxima."""
    from fuzzy2.systems.union_rows import Unions

    own, count = outputs.operators, outputs.intervals.shape[1]
    rows, kinks = [np.empty(0)] * count, [np.empty(0)] * count
    set_of = np.full((count, len(outputs.intervals)), -1)
    crisp = True
    for j, united in enumerate(outputs.united):
        if not outputs.speaking[j].size:
            continue
        known = None if united is None else united.compiled_sets
        if united is None or known is None:
            return None
        rows[j], set_of[j, outputs.speaking[j]], kinks[j] = known
        crisp = crisp and united.crisp
    summed, asked = outputs.aggregation is None, _asked(outputs)
    if summed and asked > 1:
        # The sum may have its maximum where none of the sets has one.
        return None
    codes = [own.implication.name == "product", summed, hangs_on_ratios(own), crisp]
    return Unions(
        table,
        np.concatenate(rows),
        np.cumsum([0, *(one.size // (2 * TERM) for one in rows)]),
        np.concatenate(kinks),
        np.cumsum([0, *(one.size for one in kinks)]),
        set_of.ravel(),
        missing,
        np.array([*codes, WAYS.get(own.method, 0), asked], dtype=np.int64),
        np.array(own.shares),
        GAUSS,
        TOLERANCE,
    )


def _asked(outputs: Outputs) -> int:
    """Return the code of the quantity to compute, see :mod:`fuzzy2.systems.crisp_unions`."""
    kind = outputs.operators.type_reduction
    if kind in ("centroid", "center_of_sums"):
        return 0
    if kind == "bisector":
        return 2 if outputs.operators.integration == "midpoint" else 1
    names = ("smallest_of_maxima", "middle_of_maxima", "mean_of_maxima", "largest_of_maxima")
    return 3 + (*names, "smallest_absolute_maximum", "largest_absolute_maximum").index(kind)


def _sampled(outputs: Outputs, table: Array, missing: Array) -> Any:
    """Return the grades of all sets on grids, or at all points if the sets are single points."""
    from fuzzy2.systems.sampled_rows import CERTAIN, Sampled
    from fuzzy2.systems.union_rows import _is_type_1

    own, count = outputs.operators, outputs.intervals.shape[1]
    implied, united = _code_of(own.implication), _united_by(outputs)
    if implied is None or united is None:
        return None
    points, grades = [np.empty(0)] * count, [np.empty(0)] * count
    set_of = np.full((count, len(outputs.intervals)), -1)
    grids: list[Any] = []
    for j, rules in enumerate(outputs.speaking):
        grid = outputs.summed[j] or outputs.united[j]
        if not rules.size or grid is None:
            continue
        known = grid.sampled
        if known is None or binary_exponent(known[0]):
            return None
        points[j], shapes, set_of[j, rules] = known
        grids.append(grid)
        grades[j] = shapes
    crisp = all(grid.crisp for grid in grids)
    way = WAYS.get(own.method, 0)
    if way == 0 and crisp and _is_type_1(table):  # type: ignore[no-untyped-call]
        way = CERTAIN
    grades = [
        shapes[:, 1].ravel() if crisp and shapes.size else shapes.ravel() for shapes in grades
    ]
    codes = [implied, united, hangs_on_ratios(own), crisp, _asked(outputs), way]
    return Sampled(
        table,
        np.concatenate(points),
        np.cumsum([0, *(one.size for one in points)]),
        np.concatenate(grades),
        np.cumsum([0, *(one.size for one in grades)]),
        set_of.ravel(),
        missing,
        np.array([*codes, own.integration == "trapezoidal"], dtype=np.int64),
        np.array(own.shares),
    )


def _monotonics(outputs: Outputs, table: Array, missing: Array) -> Any:
    """Return the tables of monotonic consequents."""
    from fuzzy2.systems.monotonic_rows import Monotonics

    count = outputs.intervals.shape[1]
    rows, number = TermRows(), 0
    set_of = np.full((count, len(outputs.intervals)), -1)
    rising, ends = np.zeros(set_of.shape, np.int64), np.zeros((count, 2))
    bounded = True
    for j, monotonic in enumerate(outputs.monotonic):
        if monotonic is None:
            continue
        ends[j], bounded = monotonic.ends, monotonic.is_bounded
        rising[j, outputs.speaking[j]] = monotonic.rising
        for r, item in zip(outputs.speaking[j], outputs.sets[j], strict=True):
            if not rows.add(0, item, item.kernel_row()):
                return None
            set_of[j, r] = number
            number += 1
    sets = rows.appended(np.concatenate([np.zeros(HEADER), np.ravel(rows.rows)]))
    return Monotonics(
        table, sets, set_of.ravel(), rising.ravel(), ends.ravel(), missing, int(bounded)
    )
