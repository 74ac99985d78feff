"""Logarithms of firing strengths, for rules whose firing underflows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy2.support.checks import Array
from fuzzy2.support.pieces import pieces
from fuzzy2.systems.antecedents import And, Antecedent, Hedged, Is, Not, Or
from fuzzy2.systems.table import CONORMS, NORMS

VANISHED = 1e-280
"""Firing strengths below this threshold have lost digits to underflow, or are 0."""

_Combine = Callable[[Array, Array], Array]


class LogNorms(NamedTuple):
    """Functions that apply *and* and *or* to logarithms of grades."""

    both: _Combine
    either: _Combine
    both_not: _Combine
    """The t-norm of complements that corresponds to ``either`` for grades."""
    either_not: _Combine
    """The t-conorm of complements that corresponds to ``both`` for grades."""


def log_norms(both: str, either: str) -> LogNorms:
    """Return the functions for a t-norm and a t-conorm, given by name."""
    from fuzzy2.systems.log_firing_kernels import combine_logarithms

    def combine(code: int, is_conorm: bool) -> _Combine:
        def combined(a: Array, b: Array) -> Array:
            first, second = (np.ascontiguousarray(one).ravel() for one in np.broadcast_arrays(a, b))
            out = np.empty(first.size)
            for part in pieces(out.size):
                combine_logarithms(code, is_conorm, first[part], second[part], out[part])
            return out.reshape(np.broadcast_shapes(np.shape(a), np.shape(b)))

        return combined

    first, second = NORMS.index(both), CONORMS.index(either)
    # Duals have the same code.
    return LogNorms(
        combine(first, False), combine(second, True), combine(second, False), combine(first, True)
    )


def lost(strengths: Array, silent: NDArray[np.bool_] | None) -> NDArray[np.bool_]:
    """Return where (n,) an end may depend on firing strengths (n, R, 2) that underflow.

    A lower strength that has not underflowed outweighs all that have. If all upper strengths are
    normal floats, nothing is lost either, because an end uses some upper strength. ``silent`` (R,
    m) marks the rules without a consequent for an output.
    """
    low, high = strengths[..., 0], strengths[..., 1]
    speaking = (
        [slice(None)] if silent is None else [~column for column in silent.T if not all(column)]
    )
    found = np.zeros(len(strengths), dtype=bool)
    for rules in speaking:
        held = (low[:, rules] >= VANISHED).any(axis=1)
        found |= ~held & (high[:, rules] < VANISHED).any(axis=1)
    return found


def log_grades(terms: Sequence[Any], x: Array, grades: Array) -> Array:
    """Return the logarithms of grades (n, terms, 2) of an input x (n,).

    For Gaussians they are parabolas, even where the grades themselves underflow.
    """
    with np.errstate(divide="ignore", over="ignore"):
        found: Array = np.log(grades)
        for t, term in enumerate(terms):
            row = _gaussian_row(term)
            if row is not None:
                near, far = _distances(row, x)
                found[:, t, 1] = np.log(row[6]) - 0.5 * near**2
                found[:, t, 0] = np.minimum(np.log(row[5]) - 0.5 * far**2, found[:, t, 1])
    return found


def slopes_of_logarithms(terms: Sequence[Any], x: Array, grades: Array, slopes: Array) -> Array:
    """Return the derivatives of :func:`log_grades`, for grades with given slopes."""
    found: Array = np.divide(slopes, grades, out=np.zeros_like(grades), where=grades > 0.0)
    for t, term in enumerate(terms):
        row = _gaussian_row(term)
        if row is not None:
            near, far = _distances(row, x)
            found[:, t, 0], found[:, t, 1] = -far / row[3], -near / row[4]
    return found


def _gaussian_row(term: Any) -> tuple[float, ...] | None:
    """Return the kernel row of a Gaussian term; its mean or standard deviation may be uncertain."""
    row: tuple[float, ...] | None = term.kernel_row()
    return row if row is not None and row[0] == 0.0 else None


def _distances(row: tuple[float, ...], x: Array) -> tuple[Array, Array]:
    """Return the distances, in standard deviations, from the nearest and the farthest mean."""
    _, first, last, s_low, s_high, *_ = row
    far = x - np.where(x < 0.5 * (first + last), last, first)
    return (x - np.clip(x, first, last)) / s_high, far / s_low


def log_firing(
    logarithms: Sequence[Array],
    rules: NDArray[np.int64] | tuple[Antecedent, ...],
    weights: Array | None,
    norms: LogNorms,
) -> Array:
    """Return the logarithms of firing intervals.

    Parameters
    ----------
    logarithms : sequence of p (n, terms, 2) arrays
        Logarithms of each input's grades in its terms.
    rules : (R, p) array, or R trees
        Number of each input's term in a rule, or -1; or the antecedents as trees.
    weights : (R,) array, optional
        Weights of the rules.
    norms : LogNorms
        What *and* and *or* mean.

    Returns
    -------
    (n, R, 2) array
        Logarithms; -inf for rules that do not fire.
    """
    if isinstance(rules, tuple):
        fired = np.stack([log_strength(tree, logarithms, norms) for tree in rules], axis=1)
    else:
        fired = np.zeros((len(logarithms[0]), len(rules), 2))
        for i, of_input in enumerate(logarithms):
            used = np.flatnonzero(rules[:, i] >= 0)
            fired[:, used] = norms.both(fired[:, used], of_input[:, rules[used, i]])
    # The two ends are rounded differently, which must not swap them.
    np.minimum(fired[..., 0], fired[..., 1], out=fired[..., 0])
    if weights is not None:
        with np.errstate(divide="ignore"):
            fired += np.log(weights)[:, np.newaxis]
    return fired


def log_strength(
    tree: Antecedent, logarithms: Sequence[Array], norms: LogNorms, negated: bool = False
) -> Array:
    """Return the logarithms (n, 2) of the result of :func:`fuzzy2.systems.antecedents.strength`."""
    match tree:
        case Is(variable, term):
            of_input = logarithms[int(variable)]
            found = np.zeros((len(of_input), 2)) if term is None else of_input[:, int(term)]
            return _log_complement(found) if negated else found
        case And(parts) | Or(parts):
            if isinstance(tree, And):
                combine = norms.either_not if negated else norms.both
            else:
                combine = norms.both_not if negated else norms.either
            found = log_strength(parts[0], logarithms, norms, negated)
            for part in parts[1:]:
                found = combine(found, log_strength(part, logarithms, norms, negated))
            return found
        case Not(part):
            return log_strength(part, logarithms, norms, not negated)
        case Hedged(hedge, part):
            hedged = np.sort(hedge.of_logarithms(log_strength(part, logarithms, norms)), axis=-1)
            return _log_complement(hedged) if negated else hedged


def _log_complement(logarithms: Array) -> Array:
    """Return the logarithms of 1 - f for intervals f (n, 2) that are given as logarithms."""
    turned = logarithms[:, ::-1]
    with np.errstate(divide="ignore"):
        near = np.log(-np.expm1(turned))
        return np.where(turned > -0.5, near, np.log1p(-np.exp(turned)))
