"""A system as one array for the compiled loops."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy2.support.checks import Array
from fuzzy2.systems.antecedents import Antecedent, depth_of, program_of

NORMS = ("min", "product", "lukasiewicz", "drastic", "nilpotent", "hamacher", "einstein")
"""T-norms that the compiled loop supports for *and*, in the order of their codes."""
CONORMS = ("max", "probabilistic", "lukasiewicz", "drastic", "nilpotent", "hamacher", "einstein")
"""T-conorms that the compiled loop supports for *or*, in the order of their codes."""


class Supplement(NamedTuple):
    """The part of a system that goes beyond rules given as numbers of terms.

    Parameters
    ----------
    trees : tuple of R antecedents, or None
        Antecedents of the rules, if one of them is not a plain conjunction.
    conorm : str, or None
        T-conorm of *or*; None if it has no code.
    weights : (R,) ndarray, or None
        Weights of the rules.
    silent : (R, m) ndarray of bool, or None
        Where a rule has no consequent for an output.
    defaults : (m,) ndarray, or None
        Outputs where no rule fires; NaN for none.
    """

    trees: tuple[Antecedent, ...] | None
    conorm: str | None
    weights: Array | None
    silent: NDArray[np.bool_] | None
    defaults: Array | None


def table_of(
    counts: Sequence[int],
    rules: NDArray[np.int64] | None,
    intervals: Array,
    norm: str,
    rows: list[tuple[float, ...]],
    supplement: Supplement,
) -> Array | None:
    """Return a center-of-sets system as one array, laid out as the kernels read it.

    Parameters
    ----------
    counts : sequence of int
        Number of terms of every input.
    rules : (R, p) ndarray, or None
        Number of each input's term in each rule, or -1; None if rules are trees.
    intervals : (R, m, 2) ndarray
        The consequents.
    norm : str
        Name of the t-norm, one of ``NORMS``.
    rows : list of tuples
        Number of the input and kernel row of each term.
    supplement : Supplement
        The part of the system beyond that.

    Returns
    -------
    (k,) ndarray, or None
        The table; None if the compiled loop cannot evaluate the system.
    """
    count, outputs = intervals.shape[:2]
    offsets = np.cumsum([0, *counts[:-1]])
    antecedents = (
        np.full((count, len(counts)), -1)
        if rules is None
        else np.where(rules >= 0, rules + offsets, -1)
    )
    left, right = intervals[..., 0], intervals[..., 1]
    spoken = np.ones((count, outputs), bool) if supplement.silent is None else ~supplement.silent
    least = np.where(spoken, left, np.inf).min(axis=0)
    greatest = np.where(spoken, right, -np.inf).max(axis=0)
    least, greatest = (np.where(np.isfinite(edge), edge, 0.0) for edge in (least, greatest))
    table = np.concatenate(
        [
            [
                len(counts),
                len(rows),
                count,
                outputs,
                float(NORMS.index(norm)),
                0.0,
                0.0,
            ],
            np.ravel(rows),
            antecedents.ravel(),
            np.concatenate([left - least, greatest - right], axis=1).ravel(),
            least,
            greatest,
            np.sort(left - least, axis=0).T.ravel(),
            np.sort(greatest - right, axis=0).T.ravel(),
            np.argsort(left - least, axis=0, kind="stable").T.ravel(),
            np.argsort(greatest - right, axis=0, kind="stable").T.ravel(),
        ]
    ).astype(float)
    if all(part is None for part in (supplement.trees, *supplement[2:])):
        # Adding exponents only pays if there are more terms than rules. On a grid, rules share most
        # of their terms, and there are fewer.
        if norm == "product" and len(rows) > count:
            table[6] = exponents_of(rows)
        return table
    more = supplement_of(supplement, count, outputs, offsets.tolist(), table.size)
    if more is None:
        return None
    table[5] = table.size
    return np.concatenate([table, more])


def exponents_of(rows: list[tuple[float, ...]]) -> float:
    """Return the code of how exponents of terms are added up.

    It is 0 if some term is not Gaussian, 1 if all terms are type-1 Gaussians, and 2 if all are
    Gaussian but not all type-1.
    """
    _, kinds, low_mean, high_mean, low_sigma, high_sigma, low, high, *_ = np.transpose(rows)
    if (kinds != 0.0).any():
        return 0.0
    alike = (low_mean == high_mean) & (low_sigma == high_sigma) & (low == high)
    return 1.0 if alike.all() else 2.0


def supplement_of(
    supplement: Supplement, rules: int, outputs: int, offsets: list[int], start: int
) -> Array | None:
    """Return the supplement as the array that follows a table of ``start`` numbers.

    It begins with four numbers: code of the t-conorm, whether rules are trees, whether a rule has
    no consequent for an output or an output has a default, and deepest stack. Then follow R
    weights, R rows of m (whether a rule has no consequent), m defaults or NaN, R + 1 places where
    the steps of the rules begin, and the steps. It is None if a part cannot be compiled.
    """
    trees, conorm, weights, silent, defaults = supplement
    steps: list[list[float]] = []
    if trees is not None:
        if conorm is None:
            return None
        for tree in trees:
            program = program_of(tree, offsets)
            if program is None:
                return None
            steps.append(program)
    head = [
        0.0 if trees is None or conorm is None else float(CONORMS.index(conorm)),
        float(trees is not None),
        float(silent is not None or defaults is not None),
        float(max((depth_of(tree) for tree in trees), default=1)) if trees is not None else 1.0,
    ]
    body = np.concatenate(
        [
            head,
            np.ones(rules) if weights is None else weights,
            np.zeros(rules * outputs) if silent is None else silent.ravel().astype(float),
            np.full(outputs, np.nan) if defaults is None else defaults,
        ]
    )
    first = start + body.size + rules + 1
    places = first + np.cumsum([0, *(len(program) for program in steps)])
    places = np.full(rules + 1, first) if trees is None else places
    return np.concatenate([body, places, np.ravel([step for one in steps for step in one])])
