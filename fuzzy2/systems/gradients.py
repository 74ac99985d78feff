r"""Derivatives of the crisp output of a fuzzy logic system with respect to its inputs.

An end of a type-reduced interval is the least or the greatest of many weighted averages
(eq. 1.116), so by the envelope theorem its derivative is that of the average at which it is
attained, the switch point being held,

.. math::

    \frac{\partial y}{\partial x_i} = \frac{1}{\sum_r w_r}
    \sum_r \left[(z_r - y) \frac{\partial w_r}{\partial x_i}
    + w_r \frac{\partial z_r}{\partial x_i}\right],

where the second term is there for :class:`fuzzy2.Linear` consequents only. The derivatives of the
weights follow from those of the terms' memberships (:meth:`fuzzy2.sets.type1.Type1Set.derivative`)
by the rule of the t-norm: the product rule, or under the minimum that of the smallest grade.

All of it is differentiated from the right, toward greater :math:`x_i`, which makes a difference at
kinks only: corners of memberships, equal grades under the minimum, a consequent that equals the
output so that the switch point passes it, and :math:`x_i = 0` for linear consequents with a spread.
Of equal grades the one that falls fastest counts; of the averages at a switch point that is passed,
for the left end the one that falls fastest and for the right end the one that rises fastest.

What has no formula here is differentiated by differences of the crisp output.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import NotApplicable
from fuzzy2.operations.t_norms import T_NORMS, TNorm
from fuzzy2.sets.gaussian_type2 import GaussianType2Set
from fuzzy2.support.checks import Array
from fuzzy2.systems.consequents import Linear
from fuzzy2.systems.relative_firing import VANISHED, log_grades, slopes_of_logarithms
from fuzzy2.systems.terms import domain_of, highest_point, spread

TIE = 1e-13
"""A consequent equals the output where they differ by less than this, relative to the largest
consequent: some roundings.
"""

_BLOCK = 1 << 20  # numbers in the largest array that is held at once: 8 MiB

_CONSTANT = np.zeros((1, 1, 1, 1, 2))  # derivatives of points that do not move, as (n, m, R, p, 2)

_Rule = Callable[[Array, Array, Array, Array], Array]


class Differentiable(Protocol):
    """What the derivatives of a system are made from."""

    @property
    def inputs(self) -> Sequence[Sequence[Any]]:
        """Terms of every input."""
        ...

    @property
    def rules(self) -> Any:
        """Number of the term of each input that a rule asks for, −1 for none, (R, p), or trees."""
        ...

    @property
    def weights(self) -> Array | None:
        """What the firing of each rule is multiplied by, (R,); None for 1."""
        ...

    @property
    def implication(self) -> TNorm:
        """How a rule's firing scales its output set."""
        ...

    @property
    def without_formula(self) -> str | None:
        """What a system has for which there is no formula; None if nothing."""
        ...

    @property
    def consequents(self) -> Any:
        """Consequents as they were given."""
        ...

    @property
    def consequent_sets(self) -> Sequence[Sequence[Any]] | None:
        """Consequents that are sets, by rule and output; None if they are none."""
        ...

    @property
    def consequent_intervals(self) -> Array:
        """Ends of the consequents, (R, m, 2)."""
        ...

    @property
    def fuzzifiers(self) -> Any:
        """A fuzzifier for each input; None if all are singleton."""
        ...

    @property
    def t_norm(self) -> TNorm:
        """How the grades of a rule are combined."""
        ...

    @property
    def type_reduction(self) -> str:
        """Name of the way from firing intervals to a type-reduced set."""
        ...

    @property
    def n_outputs(self) -> int:
        """Number of outputs m."""
        ...

    @property
    def planes(self) -> Sequence[tuple[float, Differentiable]]:
        """Systems that the crisp output is a weighted sum of, with their weights; else none."""
        ...

    @property
    def middles(self) -> Array | None:
        """Points that the Gaussian corollary averages, (R, m); None for other systems."""
        ...

    def domain(self) -> Array:
        """Return the range of each input, (p, 2)."""
        ...

    def relative_firing(self, rows: Array) -> Array:
        """Return firing intervals (n, R, 2) of which only the ratios count if they underflow."""
        ...

    def __call__(self, X: ArrayLike) -> Array:
        """Return the crisp outputs (..., m)."""
        ...

    def type_reduced(self, X: ArrayLike) -> Array:
        """Return the type-reduced intervals (..., m, 2)."""
        ...


def gradient(system: Differentiable, rows: Array) -> Array:
    """Return the derivatives of the crisp outputs.

    By formula where there is one and by differences elsewhere.

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
    """Return the derivatives of the crisp outputs from the right, by formula.

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
        If the system has a part without a formula; which ones have is said at
        :meth:`fuzzy2.systems.system.FuzzySystem.gradient`.
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
        if norm not in _RULES:
            raise NotApplicable(
                "the derivative by formula", f"none is known for the t-norm {norm.name!r}"
            )
    slopes = np.empty((len(rows), system.n_outputs, len(system.inputs)))
    # The larger of the weights' derivatives, (n, R, 2, p), and the points of all outputs, (n, m,
    # R).
    step = max(1, _BLOCK // (len(system.rules) * max(2 * len(system.inputs), system.n_outputs)))
    for start in range(0, len(rows), step):
        block = rows[start : start + step]
        slopes[start : start + step] = _of_block(system, block)
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
        Derivatives; NaN where no rule fires, or none within three steps.
    """
    slopes = np.empty((len(rows), system.n_outputs, len(system.inputs)))
    for i, (terms, ends) in enumerate(zip(system.inputs, system.domain(), strict=True)):
        left, right = domain_of(terms) if terms else ends
        step = 1e-3 * (right - left)
        shift = np.zeros(len(system.inputs))
        shift[i] = step
        near, middle, far = (system(rows + k * shift) - system(rows - k * shift) for k in (1, 2, 3))
        slopes[..., i] = (45.0 * near - 9.0 * middle + far) / (60.0 * step)
    return slopes


def _of_block(system: Differentiable, rows: Array) -> Array:
    """Return the derivatives (n, m, p) at inputs (n, p).

    The weights of all of them are in memory.
    """
    strengths, rates = _firing(system, rows)
    vanished = strengths[..., 1].max(axis=1) < VANISHED
    if system.middles is None and vanished.any():
        strengths[vanished], rates[vanished] = _relative_firing(system, rows[vanished])
    slopes = np.empty((len(rows), system.n_outputs, len(system.inputs)))
    if system.middles is not None:
        crisp = system(rows)  # by the Gaussian corollary, which is the type-1 system in the middle
        slopes[:] = _left_end(
            system.middles.T[np.newaxis], _CONSTANT[..., 0], crisp, strengths, rates
        )
    else:
        reduced = system.type_reduced(rows)
        for outputs, points, rises, weights, changes in _outputs(system, rows, strengths, rates):
            left = _left_end(
                points[..., 0], rises[..., 0], reduced[:, outputs, 0], weights, changes
            )
            right = _left_end(
                -points[..., 1], -rises[..., 1], -reduced[:, outputs, 1], weights, changes
            )
            slopes[:, outputs] = 0.5 * (left - right)
        crisp = reduced.mean(axis=-1)
    return np.where(np.isnan(crisp)[..., np.newaxis], np.nan, slopes)


def _firing(system: Differentiable, rows: Array) -> tuple[Array, Array]:
    """Return the firing intervals (n, R, 2) and their derivatives (n, R, 2, p)."""
    rule = _RULES[system.t_norm]
    strengths = np.ones((len(rows), len(system.rules), 2))
    rates = np.zeros((*strengths.shape, len(system.inputs)))
    for i, terms in enumerate(system.inputs):
        if not terms:
            continue
        grades, slopes = _grades_and_slopes(system, terms, rows[:, i])
        asked = system.rules[:, i]
        # Only the rules that ask for this input: to the others it makes no difference.
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


def _relative_firing(system: Differentiable, rows: Array) -> tuple[Array, Array]:
    """Return what :func:`_firing` does, both divided by the greatest strength of a row."""
    strengths = system.relative_firing(rows)
    shape = (*strengths.shape, len(system.inputs))
    # Of inputs that play no part in a rule the grade is 1.
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
    return strengths, strengths[..., np.newaxis] * log_slopes


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

    Twice the principal one for the Gaussian corollary.
    """
    if isinstance(term, GaussianType2Set):
        return term.principal, term.principal
    return term.lower, term.upper


def _outputs(
    system: Differentiable, rows: Array, strengths: Array, rates: Array
) -> Iterator[tuple[slice, Array, Array, Array, Array]]:
    """Yield outputs that share weights.

    Yield their points (n or 1, m, R, 2) with the derivatives of those, and the weights with theirs.
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
        changes = _RULES[system.implication](
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


def _left_end(points: Array, rises: Array, y: Array, weights: Array, rates: Array) -> Array:
    r"""Return the derivatives (n, m, p) from the right of left ends y (n, m).

    The least averages of points with weights from intervals.

    Points are (n or 1, m, R) with the derivatives ``rises`` (n, m, R, p), or 1 along any axis,
    weights (n, R, 2) with ``rates`` (n, R, 2, p). Any weight of a point that equals y gives the
    same y, but not the same derivative.
    """
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        # Relative to the largest weight: products of tiny ones would underflow.
        largest = weights[..., 1].max(axis=1)[:, np.newaxis, np.newaxis]
        weights, rates = weights / largest, rates / largest[..., np.newaxis]
        away = points - y[..., np.newaxis]
        tied = np.abs(away) <= TIE * np.abs(points).max(axis=-1, keepdims=True)
        below, above = (away < 0.0) & ~tied, (away > 0.0) & ~tied
        moment = (
            np.where(below, away, 0.0) @ rates[:, :, 1]
            + np.where(above, away, 0.0) @ rates[:, :, 0]
        )
        weight = np.where(
            below, weights[:, np.newaxis, :, 1], np.where(above, weights[:, np.newaxis, :, 0], 0.0)
        )
        mass = weight.sum(axis=-1)[..., np.newaxis]
        if rises.any():
            moment = moment + np.einsum(
                "nmr,nmrp->nmp", weight, np.broadcast_to(rises, (*away.shape, moment.shape[-1]))
            )
        slopes = moment / mass
        some = tied.any(axis=-1)
        if some.any():
            item, output = np.nonzero(some)
            low, high = np.moveaxis(
                np.where(tied[some][..., np.newaxis], weights[item], 0.0), -1, 0
            )
            theirs = np.broadcast_to(rises, (*away.shape, moment.shape[-1]))[item, output]
            slopes[some] = _least_slope(
                moment[some], mass[some], theirs, low[..., np.newaxis], high[..., np.newaxis]
            )
    return np.asarray(slopes)


def _least_slope(moment: Array, mass: Array, rises: Array, low: Array, high: Array) -> Array:
    """Return the derivatives (k, p) of ends that equal points.

    These points may have any weight from low to high (k, R, 1).

    Of all their choices the one that falls fastest counts (Danskin's theorem). It is a generalized
    centroid, too, of the derivatives of the points, (k, R, p), and found by Karnik and Mendel's
    iteration.
    """
    least: Array = (moment + (high * rises).sum(axis=1)) / (mass + high.sum(axis=1))
    while True:
        chosen = np.where(rises <= least[:, np.newaxis], high, low)
        candidate = (moment + (chosen * rises).sum(axis=1)) / (mass + chosen.sum(axis=1))
        less = candidate < least
        if not less.any():
            return least
        least = np.where(less, candidate, least)


def _of_product(a: Array, a_rate: Array, b: Array, b_rate: Array) -> Array:
    return a * b_rate + b * a_rate


def _of_minimum(a: Array, a_rate: Array, b: Array, b_rate: Array) -> Array:
    return np.where(a < b, a_rate, np.where(b < a, b_rate, np.minimum(a_rate, b_rate)))


def _of_lukasiewicz(a: Array, a_rate: Array, b: Array, b_rate: Array) -> Array:
    rate = a_rate + b_rate
    return np.where(a + b > 1.0, rate, np.where(a + b < 1.0, 0.0, np.maximum(rate, 0.0)))


def _of_hamacher(a: Array, a_rate: Array, b: Array, b_rate: Array) -> Array:
    union = a + b - a * b
    # Near (0, 0) the t-norm is homogeneous, like half of the harmonic mean.
    both = a_rate + b_rate
    at_zero = np.where(both > 0.0, a_rate * b_rate / np.where(both > 0.0, both, 1.0), 0.0)
    safe = np.where(union > 0.0, union, 1.0)
    return np.where(union > 0.0, (b / safe) ** 2 * a_rate + (a / safe) ** 2 * b_rate, at_zero)


def _of_einstein(a: Array, a_rate: Array, b: Array, b_rate: Array) -> Array:
    return (b * (2.0 - b) * a_rate + a * (2.0 - a) * b_rate) / (1.0 + (1.0 - a) * (1.0 - b)) ** 2


# How the derivatives of two grades make that of their combination, from the right.
_RULES: dict[TNorm, _Rule] = {
    T_NORMS["product"]: _of_product,
    T_NORMS["min"]: _of_minimum,
    T_NORMS["lukasiewicz"]: _of_lukasiewicz,
    T_NORMS["hamacher"]: _of_hamacher,
    T_NORMS["einstein"]: _of_einstein,
}
