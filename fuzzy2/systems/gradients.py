r"""Derivatives of the crisp output of a fuzzy logic system with respect to its inputs.

An end of a type-reduced interval is the least or the greatest of many weighted averages (eq.
1.116). By the envelope theorem, its derivative is that of the average at which it is attained, with
a fixed switch point:

.. math::

    \frac{\partial y}{\partial x_i} = \frac{1}{\sum_r w_r}
    \sum_r \left[(z_r - y) \frac{\partial w_r}{\partial x_i}
    + w_r \frac{\partial z_r}{\partial x_i}\right],

The second term only occurs for :class:`fuzzy2.Linear` consequents. The derivatives of the weights
follow from those of the terms' memberships (:meth:`fuzzy2.sets.type1.Type1Set.derivative`): by the
product rule, or under the minimum as the derivative of the smallest grade.

All derivatives are taken from the right, toward greater :math:`x_i`. That only matters at kinks: at
corners of memberships, for equal grades under the minimum, where a consequent equals the output so
that the switch point passes it, and at :math:`x_i = 0` for linear consequents with a spread. Among
equal grades, the one that falls fastest is used. Among the averages at a switch point that is being
passed, the left end uses the one that falls fastest, and the right end the one that rises fastest.

Systems without a formula are differentiated by differences of the crisp output.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fuzzy2.errors import NotApplicable
from fuzzy2.operations.t_norms import TNorm
from fuzzy2.sets.gaussian_type2 import GaussianType2Set
from fuzzy2.support.checks import Array
from fuzzy2.systems.consequents import Linear
from fuzzy2.systems.end_slopes import left_end, scaled_for
from fuzzy2.systems.log_firing import log_grades, slopes_of_logarithms
from fuzzy2.systems.norm_slopes import SLOPE_RULES
from fuzzy2.systems.terms import domain_of, highest_point, spread

_BLOCK = 1 << 20  # numbers in the largest array that is held in memory at once: 8 MiB

_CONSTANT = np.zeros((1, 1, 1, 1, 2))  # derivatives of constant points (n, m, R, p, 2)


class Differentiable(Protocol):
    """Interface that derivatives need of a system."""

    @property
    def inputs(self) -> Sequence[Sequence[Any]]:
        """Terms of every input."""
        ...

    @property
    def rules(self) -> Any:
        """Number of each input's term in a rule (R, p), -1 for none; or trees."""
        ...

    @property
    def weights(self) -> Array | None:
        """Weights of the rules (R,); None if all are 1."""
        ...

    @property
    def implication(self) -> TNorm:
        """T-norm that combines a rule's firing with its output set."""
        ...

    @property
    def without_formula(self) -> str | None:
        """Part of the system for which there is no formula; None if there is none."""
        ...

    @property
    def consequents(self) -> Any:
        """Consequents as given."""
        ...

    @property
    def consequent_sets(self) -> Sequence[Sequence[Any]] | None:
        """Consequents that are sets, by rule and output; None if they are not sets."""
        ...

    @property
    def consequent_intervals(self) -> Array:
        """Ends of the consequents, (R, m, 2)."""
        ...

    @property
    def fuzzifiers(self) -> Any:
        """A fuzzifier for each input; None if all are singleton fuzzifiers."""
        ...

    @property
    def t_norm(self) -> TNorm:
        """T-norm that combines the grades of a rule."""
        ...

    @property
    def type_reduction(self) -> str:
        """Name of the type reduction."""
        ...

    @property
    def n_outputs(self) -> int:
        """Number of outputs m."""
        ...

    @property
    def planes(self) -> Sequence[tuple[float, Differentiable]]:
        """Systems whose weighted sum is the crisp output, with their weights; otherwise empty."""
        ...

    @property
    def middles(self) -> Array | None:
        """Points that the Gaussian corollary averages, (R, m); None for other systems."""
        ...

    def domain(self) -> Array:
        """Return the range of each input, (p, 2)."""
        ...

    def log_firing(self, rows: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Return the logarithms of firing intervals, and where the intervals underflow."""
        ...

    def __call__(self, X: ArrayLike) -> Array:
        """Return the crisp outputs (..., m)."""
        ...

    def type_reduced(self, X: ArrayLike) -> Array:
        """Return the type-reduced intervals (..., m, 2)."""
        ...


def gradient(system: Differentiable, rows: Array) -> Array:
    """Return the derivatives of the crisp outputs.

    They follow from the formula if there is one, and from differences otherwise.

    Parameters
    ----------
    system : FuzzySystem
        The system.
    rows : (n, p) array
        Finite inputs.

    Returns
    -------
    (n, m, p) array
        Derivatives; NaN where no rule fires.
    """
    try:
        return analytic_gradient(system, rows)
    except NotApplicable:
        return gradient_by_differences(system, rows)


def analytic_gradient(system: Differentiable, rows: Array) -> Array:
    """Return the right-hand derivatives of the crisp outputs by the formula.

    Parameters
    ----------
    system : FuzzySystem
        The system.
    rows : (n, p) array
        Finite inputs.

    Returns
    -------
    (n, m, p) array
        Derivatives; NaN where no rule fires.

    Raises
    ------
    NotApplicable
        If the system has a part without a formula;
        :meth:`fuzzy2.systems.system.FuzzySystem.gradient` lists the parts that have one.
    """
    planes = system.planes
    if planes:
        return np.asarray(sum(share * analytic_gradient(plane, rows) for share, plane in planes))
    if system.without_formula is not None:
        raise NotApplicable(
            "the derivative by formula", f"none is known for {system.without_formula}"
        )
    if system.fuzzifiers is not None:
        raise NotApplicable(
            "the derivative by formula", "none is known for non-singleton fuzzifiers"
        )
    for norm in (system.t_norm, system.implication):
        if norm not in SLOPE_RULES:
            raise NotApplicable(
                "the derivative by formula", f"none is known for the t-norm {norm.name!r}"
            )
    slopes = np.empty((len(rows), system.n_outputs, len(system.inputs)))
    # Size of the larger of two arrays: the weights' derivatives (n, R, 2, p) and the points of all
    # outputs (n, m, R).
    step = max(1, _BLOCK // (len(system.rules) * max(2 * len(system.inputs), system.n_outputs)))
    for start in range(0, len(rows), step):
        block = rows[start : start + step]
        slopes[start : start + step] = _of_block(system, block)
        if system.middles is None:
            logarithms, far = system.log_firing(block)
            if far.any():
                slopes[start : start + step][far] = _far_away(system, block[far], logarithms[far])
    return slopes


def gradient_by_differences(system: Differentiable, rows: Array) -> Array:
    """Return the derivatives of the crisp outputs by central differences of sixth order.

    The step is 1/1000 of the range of an input's terms. Within three steps of a kink the result
    lies between the slopes on both sides.

    Parameters
    ----------
    system : FuzzySystem
        The system.
    rows : (n, p) array
        Finite inputs.

    Returns
    -------
    (n, m, p) array
        Derivatives; NaN where no rule fires, here or at one of the points within three steps.
    """
    ranges = [
        domain_of(terms) if terms else ends
        for terms, ends in zip(system.inputs, system.domain(), strict=True)
    ]
    return central_differences(system, rows, np.array([1e-3 * (b - a) for a, b in ranges]))


def central_differences(function: Callable[[Array], Array], rows: Array, steps: Array) -> Array:
    """Return sixth-order central differences (n, m, p) of a function from (n, p) to (n, m)."""
    slopes = []
    for step, shift in zip(steps, np.diag(steps), strict=True):
        near, middle, far = (
            function(rows + k * shift) - function(rows - k * shift) for k in (1, 2, 3)
        )
        slopes.append((45.0 * near - 9.0 * middle + far) / (60.0 * step))
    return np.stack(slopes, axis=-1)


def _of_block(system: Differentiable, rows: Array) -> Array:
    """Return the derivatives (n, m, p) at inputs (n, p).

    The weights at all inputs of the block are in memory.
    """
    strengths, rates = _firing(system, rows)
    slopes = np.empty((len(rows), system.n_outputs, len(system.inputs)))
    if system.middles is not None:
        crisp = system(rows)  # equals the type-1 system of the principal memberships
        slopes[:] = left_end(
            system.middles.T[np.newaxis], _CONSTANT[..., 0], crisp, strengths, rates
        )
    else:
        reduced = system.type_reduced(rows)
        for outputs, points, rises, weights, changes in _outputs(system, rows, strengths, rates):
            left = left_end(points[..., 0], rises[..., 0], reduced[:, outputs, 0], weights, changes)
            right = left_end(
                -points[..., 1], -rises[..., 1], -reduced[:, outputs, 1], weights, changes
            )
            slopes[:, outputs] = 0.5 * (left - right)
        crisp = reduced.mean(axis=-1)
    return np.where(np.isnan(crisp)[..., np.newaxis], np.nan, slopes)


def _firing(system: Differentiable, rows: Array) -> tuple[Array, Array]:
    """Return the firing intervals (n, R, 2) and their derivatives (n, R, 2, p)."""
    rule = SLOPE_RULES[system.t_norm]
    strengths = np.ones((len(rows), len(system.rules), 2))
    rates = np.zeros((*strengths.shape, len(system.inputs)))
    for i, terms in enumerate(system.inputs):
        if not terms:
            continue
        grades, slopes = _grades_and_slopes(system, terms, rows[:, i])
        asked = system.rules[:, i]
        # Only the rules that use this input depend on it.
        used = np.flatnonzero(asked >= 0)
        grade, own = grades[:, asked[used]], strengths[:, used]
        rate = np.zeros((len(rows), len(used), 2, len(system.inputs)))
        rate[..., i] = slopes[:, asked[used]]
        rates[:, used] = rule(own[..., np.newaxis], rates[:, used], grade[..., np.newaxis], rate)
        strengths[:, used] = system.t_norm(own, grade)
    if system.weights is not None:
        strengths *= system.weights[:, np.newaxis]
        rates *= system.weights[:, np.newaxis, np.newaxis]
    return strengths, rates


def _far_away(system: Differentiable, rows: Array, logarithms: Array) -> Array:
    """Return the derivatives (n, m, p) at inputs where firing strengths underflow.

    Relative to the greatest weight that an end uses, the weights that it uses do not underflow.
    """
    if system.t_norm.name not in ("min", "product"):
        return gradient_by_differences(system, rows)
    rates = _log_rates(system, rows)
    reduced = system.type_reduced(rows)
    # The outputs multiply the weights by factors.
    ones = np.ones_like(logarithms)
    slopes = np.empty((len(rows), system.n_outputs, len(system.inputs)))
    for outputs, points, rises, factors, _ in _outputs(system, rows, ones, np.zeros_like(rates)):
        weights = logarithms + np.log(factors)
        for j in range(system.n_outputs)[outputs]:
            k = j - outputs.indices(system.n_outputs)[0]
            ends = []
            for sign, end in ((1.0, 0), (-1.0, 1)):
                own = sign * points[:, k : k + 1, :, end]
                y = sign * reduced[:, j : j + 1, end]
                own_rises = sign * rises[:, min(k, rises.shape[1] - 1)][:, np.newaxis, ..., end]
                near = scaled_for(own[:, 0], y, weights)
                ends.append(left_end(own, own_rises, y, near, near[..., np.newaxis] * rates))
            slopes[:, j] = 0.5 * (ends[0] - ends[1])[:, 0]
    return slopes


def _log_rates(system: Differentiable, rows: Array) -> Array:
    """Return the derivatives (n, R, 2, p) of the logarithms of firing strengths."""
    shape = (len(rows), len(system.rules), 2, len(system.inputs))
    # An input that a rule does not use has the grade 1.
    logarithms, log_slopes = np.zeros(shape), np.zeros(shape)
    for i, terms in enumerate(system.inputs):
        used = np.flatnonzero(system.rules[:, i] >= 0)
        if not used.size:
            continue
        asked = system.rules[used, i]
        grades, slopes = _grades_and_slopes(system, terms, rows[:, i])
        own = log_grades(terms, rows[:, i], grades)
        logarithms[..., i][:, used] = own[:, asked]
        own = slopes_of_logarithms(terms, rows[:, i], grades, slopes)
        log_slopes[..., i][:, used] = own[:, asked]
    if system.t_norm.name == "min":
        least = logarithms.argmin(axis=-1)[..., np.newaxis] == np.arange(shape[-1])
        log_slopes = np.where(least, log_slopes, 0.0)
    return log_slopes


def _grades_and_slopes(
    system: Differentiable, terms: Sequence[Any], x: Array
) -> tuple[Array, Array]:
    """Return the grades (n, terms, 2) of an input x (n,), and their derivatives."""
    ends = [_ends(system, term) for term in terms]
    grades = [np.stack([end.membership(x) for end in pair], axis=-1) for pair in ends]
    slopes = [np.stack([end.derivative(x) for end in pair], axis=-1) for pair in ends]
    return np.stack(grades, axis=1), np.stack(slopes, axis=1)


def _ends(system: Differentiable, term: Any) -> tuple[Any, Any]:
    """Return the lower and the upper membership function of a term.

    For the Gaussian corollary both are the principal membership function.
    """
    if isinstance(term, GaussianType2Set):
        return term.principal, term.principal
    return term.lower, term.upper


def _outputs(
    system: Differentiable, rows: Array, strengths: Array, rates: Array
) -> Iterator[tuple[slice, Array, Array, Array, Array]]:
    """Yield the outputs in groups that share their weights.

    Each group has its points (n or 1, m, R, 2) with their derivatives, and its weights with theirs.
    """
    if system.type_reduction == "center_of_sets" and not isinstance(system.consequents, Linear):
        yield (
            slice(None),
            np.moveaxis(system.consequent_intervals, 1, 0)[np.newaxis],
            _CONSTANT,
            strengths,
            rates,
        )
        return
    for j in range(system.n_outputs):
        output = slice(j, j + 1)
        if isinstance(system.consequents, Linear):
            points = np.moveaxis(system.consequents.at(rows)[:, :, output], 2, 1)
            yield (
                output,
                points,
                _rises(system.consequents, rows, j)[:, np.newaxis],
                strengths,
                rates,
            )
            continue
        assert system.consequent_sets is not None
        sets = [row[j] for row in system.consequent_sets]
        peaks = np.array([highest_point(item) for item in sets])
        heights = np.array(
            [
                [float(item.lower(at)), float(item.upper(at))]
                for item, at in zip(sets, peaks, strict=True)
            ]
        )
        weights = system.implication(strengths, heights)
        changes = SLOPE_RULES[system.implication](
            strengths[..., np.newaxis], rates, heights[..., np.newaxis], np.zeros(1)
        )
        if system.type_reduction == "modified_height":
            widths = np.array([spread(item) for item in sets])
            weights, changes = (
                weights / widths[:, np.newaxis] ** 2,
                changes / widths[:, np.newaxis, np.newaxis] ** 2,
            )
        yield (
            output,
            np.stack([peaks, peaks], axis=-1)[np.newaxis, np.newaxis],
            _CONSTANT,
            weights,
            changes,
        )


def _rises(consequents: Linear, rows: Array, output: int) -> Array:
    """Return the derivatives (n, R, p, 2) of both ends of the linear consequents for one output."""
    middle = consequents.coefficients[:, output, 1:]
    half = consequents.spreads[:, output, 1:] * np.where(rows >= 0.0, 1.0, -1.0)[:, np.newaxis]
    return np.stack([middle - half, middle + half], axis=-1)
