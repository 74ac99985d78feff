r"""A system as a vector of parameters, with the objective of fine-tuning and its gradient.

The gradient is analytic and goes through the exact type reduction. Each end is an extreme over all
switch points, so that its derivative is that of the weighted average at the switch point that was
found (with W the sum of the weights there):

.. math:: \frac{\partial y_l}{\partial w_r} = \frac{z_r - y_l}{W}, \qquad
          \frac{\partial y_l}{\partial z_r} = \frac{w_r}{W}

Where two switch points give the same end the output has a kink, and the derivative is that of one
of them.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.reduction.interval import generalized_centroid
from fuzzy2.sets.interval_type2 import GaussianUncertainMean, GaussianUncertainSigma
from fuzzy2.sets.shapes import Gaussian
from fuzzy2.support.checks import Array
from fuzzy2.systems.consequents import Linear
from fuzzy2.systems.fuzzifiers import Fuzzifier, SingletonFuzzifier
from fuzzy2.systems.system import FuzzySystem, IntervalType2System, Type1System

_BLOCK = 2**20  # products of samples, rules and outputs held in memory at once


class TunableSystem:
    r"""A system as a vector of parameters, with the objective and its gradient.

    The vector holds, for every term, its mean(s) :math:`m / a` and the logarithm(s) of its standard
    deviation(s), then the consequents :math:`z / s`: numbers, or all left and then all right ends;
    a and s are the scales of input and output. Of linear consequents it holds the coefficients
    :math:`c_0 / s` and :math:`a_i c_i / s`; spreads of theirs stay as they are.

    Parameters
    ----------
    system : Type1System or IntervalType2System
        See :func:`fuzzy2.learning.fine_tuning.fine_tune`.
    input_scales : (p,) array_like
        Units a of the means, above 0.
    output_scales : (m,) array_like
        Units s of outputs and consequents, above 0.

    Raises
    ------
    NotApplicable
        If the system has parts that cannot be tuned.
    """

    def __init__(
        self, system: FuzzySystem, input_scales: ArrayLike, output_scales: ArrayLike
    ) -> None:
        _check_tunable(system)
        self._given = system
        self._input_scales = np.asarray(input_scales, dtype=float)
        self._output_scales = np.asarray(output_scales, dtype=float)
        given = system.consequents
        self._linear = given if isinstance(given, Linear) else None
        self._intervals = np.asarray(
            given.coefficients if isinstance(given, Linear) else given, dtype=float
        )
        self._has_intervals = self._linear is None and self._intervals.ndim == 3
        values: list[float] = []
        self._starts: list[list[int]] = []
        # Pairs of parameters that must stay in order.
        self._pairs: list[tuple[int, int]] = []
        for terms, scale in zip(system.inputs, self._input_scales, strict=True):
            starts = []
            for term in terms:
                starts.append(len(values))
                means, sigmas = _means(term), _sigmas(term)
                for group, numbers in (
                    (0, [mean / scale for mean in means]),
                    (len(means), [float(np.log(s)) for s in sigmas]),
                ):
                    if len(numbers) == 2:
                        self._pairs.append((starts[-1] + group, starts[-1] + group + 1))
                    values.extend(numbers)
            self._starts.append(starts)
        self._first_consequent = len(values)
        scaled = self._intervals / self._consequent_scales()
        tail = np.moveaxis(scaled, -1, 0).ravel() if self._has_intervals else scaled.ravel()
        if self._has_intervals:
            half = tail.size // 2
            self._pairs.extend(
                (self._first_consequent + k, self._first_consequent + half + k) for k in range(half)
            )
        self.parameters: Array = np.concatenate([values, tail])

    def admissible(self, parameters: Array) -> Array:
        """Return parameters with pairs that have passed each other put on their middle."""
        corrected = parameters.copy()
        if self._pairs:
            low, high = np.array(self._pairs).T
            crossed = corrected[low] > corrected[high]
            middle = 0.5 * (corrected[low[crossed]] + corrected[high[crossed]])
            corrected[low[crossed]] = corrected[high[crossed]] = middle
        return corrected

    def _consequent_scales(self) -> Array:
        """Return the units of the consequents."""
        if self._linear is not None:
            return np.asarray(self._output_scales[:, np.newaxis] / [1.0, *self._input_scales])
        return self._output_scales[:, np.newaxis] if self._has_intervals else self._output_scales

    def _terms(self, parameters: Array) -> list[list[Any]]:
        changed: list[list[Any]] = []
        for terms, starts, scale in zip(
            self._given.inputs, self._starts, self._input_scales, strict=True
        ):
            row = []
            for term, start in zip(terms, starts, strict=True):
                count = len(_means(term))
                means = tuple(float(mean) for mean in scale * parameters[start : start + count])
                sigmas = tuple(
                    float(s)
                    for s in np.exp(parameters[start + count : start + count + len(_sigmas(term))])
                )
                mean, sigma = (
                    (means if len(means) == 2 else means[0]),
                    (sigmas if len(sigmas) == 2 else sigmas[0]),
                )
                row.append(dataclasses.replace(term, mean=mean, sigma=sigma))
            changed.append(row)
        return changed

    def _consequents(self, parameters: Array) -> Any:
        tail = parameters[self._first_consequent :]
        if self._linear is not None:
            values = tail.reshape(self._intervals.shape) * self._consequent_scales()
            return Linear(values, self._linear.spreads)
        if self._has_intervals:
            ends = np.moveaxis(tail.reshape(2, *self._intervals.shape[:2]), 0, -1)
            return np.asarray(ends * self._output_scales[:, np.newaxis])
        return np.asarray(tail.reshape(self._intervals.shape) * self._output_scales)

    def system(self, parameters: Array) -> FuzzySystem:
        """Return the system that has these parameters; everything else is as given.

        Parameters
        ----------
        parameters : (P,) ndarray
            Parameters with their pairs in order, see :meth:`admissible`.

        Returns
        -------
        Type1System or IntervalType2System
            A new system.
        """
        # Consequents of one name are no longer one and the same.
        return self._given.replace(
            inputs=self._terms(parameters),
            consequents=self._consequents(parameters),
            consequent_names=None,
        )

    def objective(self, parameters: Array, X: Array, y: Array) -> tuple[float, Array]:
        """Return the objective and its gradient.

        Parameters
        ----------
        parameters : (P,) ndarray
            Parameters with their pairs in order.
        X : (N, p) ndarray
            Inputs.
        y : (N, m) ndarray
            Outputs.

        Returns
        -------
        error : float
            Mean squared error, in units of the output scales.
        gradient : (P,) ndarray
            Its derivatives with respect to the parameters.

        Raises
        ------
        InvalidValue
            If no rule fires at a sample.
        """
        terms, consequents = self._terms(parameters), self._consequents(parameters)
        if not self._has_intervals and self._linear is None:
            consequents = np.stack([consequents, consequents], axis=-1)
        step = max(1, _BLOCK // (len(self._given.rules) * self._given.n_outputs))
        error, gradient = 0.0, np.zeros_like(parameters)
        for start in range(0, len(X), step):
            rows = slice(start, start + step)
            error += self._add(terms, consequents, X[rows], y[rows], gradient, start)
        count = y.size
        return error / count, gradient / count

    def _add(
        self,
        terms: list[list[Any]],
        consequents: Any,
        X: Array,
        y: Array,
        gradient: Array,
        first_sample: int,
    ) -> float:
        """Add the gradient of a block's sum of squared errors, and return that sum."""
        grades = [
            np.stack(
                [
                    np.stack([term.lower(X[:, i]), term.upper(X[:, i])], axis=-1)
                    for term in of_input
                ],
                axis=1,
            )
            for i, of_input in enumerate(terms)
        ]
        rules, minimum = self._given.rules, self._given.t_norm.name == "min"
        antecedents = np.stack(
            [
                np.where(
                    (rules[:, i] >= 0)[:, np.newaxis], of_input[:, np.maximum(rules[:, i], 0)], 1.0
                )
                for i, of_input in enumerate(grades)
            ],
            axis=-1,
        )  # (n, R, 2, p)
        firing = antecedents.min(axis=-1) if minimum else antecedents.prod(axis=-1)
        silent = np.flatnonzero(~(firing[..., 1].max(axis=1) > 0.0))
        if silent.size:
            raise InvalidValue(
                f"X[{first_sample + silent[0]}]",
                X[silent[0]],
                "where some rule fires, for the system to have an output",
            )
        # (n or 1, R, m, 2)
        intervals = consequents.at(X) if self._linear is not None else consequents[np.newaxis]
        # (n, m, 2)
        reduced = generalized_centroid(
            np.moveaxis(intervals, 2, 1), firing[:, np.newaxis], self._given.method
        )

        residual = (reduced.mean(axis=-1) - y) / self._output_scales
        # derivative with respect to each end: 2 r / s, times 1/2
        slope = residual / self._output_scales
        by_firing = np.zeros_like(firing)
        by_consequent = np.zeros_like(intervals)  # (n or 1, R, m, 2)
        for end in (0, 1):
            offset = intervals[..., end] - reduced[:, np.newaxis, :, end]  # (n, R, m)
            # Upper weights draw the left end to the left and the right end to the right.
            takes_upper = offset < 0.0 if end == 0 else offset > 0.0
            weight = np.where(takes_upper, firing[..., 1, np.newaxis], firing[..., 0, np.newaxis])
            total = weight.sum(axis=1, keepdims=True)
            # One rule alone with no lower firing: its point is the end, and all of its weight is
            # the upper one.
            alone = total[:, 0] <= 0.0
            if alone.any():
                on_end = (offset == 0.0) & alone[:, np.newaxis]
                weight = np.where(on_end, firing[..., 1, np.newaxis], weight)
                total = weight.sum(axis=1, keepdims=True)
            share = slope[:, np.newaxis] / total
            moved = share * weight
            if self._linear is None:
                moved = moved.sum(axis=0, keepdims=True)
            by_consequent[..., end] += moved
            by_weight = share * offset
            by_firing[..., 1] += np.where(takes_upper, by_weight, 0.0).sum(axis=-1)
            by_firing[..., 0] += np.where(takes_upper, 0.0, by_weight).sum(axis=-1)

        for i, of_input in enumerate(terms):
            by_grade = by_firing * _others(antecedents, i, minimum)
            for t, term in enumerate(of_input):
                asks = rules[:, i] == t
                along = by_grade[:, asks].sum(axis=1)  # (n, 2)
                start = self._starts[i][t]
                # (n, 2, parameters of the term)
                slopes = _grade_slopes(term, X[:, i], grades[i][:, t])
                derivative = np.einsum("ne,nek->k", along, slopes)
                derivative[: len(_means(term))] *= self._input_scales[i]
                gradient[start : start + derivative.size] += derivative
        gradient[self._first_consequent :] += self._consequent_slopes(by_consequent, X)
        return float((residual**2).sum())

    def _consequent_slopes(self, by_consequent: Array, X: Array) -> Array:
        """Return the derivatives by the parameters of the consequents.

        From those by both ends of the consequents (n or 1, R, m, 2).
        """
        scales = self._consequent_scales()
        if self._linear is not None:
            with_constant = np.concatenate([np.ones((len(X), 1)), X], axis=1)
            slopes = np.einsum("nrm,ni->rmi", by_consequent.sum(axis=-1), with_constant)
            return np.asarray((slopes * scales).ravel())
        if self._has_intervals:
            return np.asarray(np.moveaxis(by_consequent[0] * scales, -1, 0).ravel())
        return np.asarray((by_consequent[0].sum(axis=-1) * scales).ravel())


def _others(antecedents: Array, i: int, minimum: bool) -> Array:
    """Return the derivative (n, R, 2) of the firing strength by the grade of input i."""
    if minimum:
        # Of equal grades the first is the smallest.
        return np.asarray((antecedents.argmin(axis=-1) == i).astype(float))
    # The product of the others: dividing the whole by the grade would fail where that underflows.
    return np.asarray(np.delete(antecedents, i, axis=-1).prod(axis=-1))


def _grade_slopes(term: Any, x: Array, grades: Array) -> Array:
    """Return the derivatives (n, 2, k) of lower and upper grade (n, 2).

    They are by the means and the logarithms of the sigmas.
    """
    means, sigmas = _means(term), _sigmas(term)
    slopes = np.zeros((x.size, 2, len(means) + len(sigmas)))
    for end in (0, 1):
        if len(means) == 2:
            below, above = x < means[0], x > means[1]
            beyond_middle = x > 0.5 * means[0] + 0.5 * means[1]
            which = np.where(beyond_middle, 0, 1) if end == 0 else np.where(above, 1, 0)
            deviation = x - np.asarray(means)[which]
            if end == 1:  # between the means the upper grade is 1 and stays so
                deviation = np.where(below | above, deviation, 0.0)
            for k in (0, 1):
                slopes[:, end, k] = np.where(
                    which == k, grades[:, end] * deviation / sigmas[0] / sigmas[0], 0.0
                )
            slopes[:, end, 2] = grades[:, end] * (deviation / sigmas[0]) ** 2
        else:
            sigma, k = (sigmas[end], end) if len(sigmas) == 2 else (sigmas[0], 0)
            deviation = x - means[0]
            slopes[:, end, 0] = grades[:, end] * deviation / sigma / sigma
            slopes[:, end, 1 + k] = grades[:, end] * (deviation / sigma) ** 2
    return slopes


def _means(term: Any) -> tuple[float, ...]:
    return tuple(term.mean) if isinstance(term, GaussianUncertainMean) else (term.mean,)


def _sigmas(term: Any) -> tuple[float, ...]:
    return tuple(term.sigma) if isinstance(term, GaussianUncertainSigma) else (term.sigma,)


def _check_tunable(system: FuzzySystem) -> None:
    what = "fine-tuning"
    if not isinstance(system, Type1System | IntervalType2System):
        raise NotApplicable(what, f"it takes a type-1 or an interval type-2 system, not {system!r}")
    if isinstance(system.rules, tuple) or any(
        part is not None for part in (system.weights, system.silent, system.default_outputs)
    ):
        raise NotApplicable(
            what,
            "it takes rules that join terms by and, without weights, of which each speaks of every "
            "output, and no default outputs",
        )
    for name, terms in zip(system.input_names, system.inputs, strict=True):
        for term in terms:
            if not isinstance(term, Gaussian | GaussianUncertainMean | GaussianUncertainSigma):
                raise NotApplicable(what, f"the term {term!r} of {name} is no Gaussian")
    if not isinstance(system.consequents, np.ndarray | Linear):
        raise NotApplicable(
            what,
            "the consequents are neither numbers nor intervals nor linear; put the sets' centroids "
            "in their place",
        )
    given = system.fuzzifier
    fuzzifiers = () if given is None else (given,) if isinstance(given, Fuzzifier) else given
    singleton = all(isinstance(one, SingletonFuzzifier) for one in fuzzifiers)
    if (
        system.t_norm.name not in ("product", "min")
        or system.type_reduction != "center_of_sets"
        or not singleton
    ):
        raise NotApplicable(
            what, "it needs the product or minimum t-norm, center of sets and a singleton fuzzifier"
        )
