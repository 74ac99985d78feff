r"""A system as a vector of parameters, with the objective of fine-tuning and its gradient.

The gradient is analytic and includes the exact type reduction. Each end is an extreme over all
switch points, so its derivative is that of the weighted average at the optimal switch point (W is
the sum of the weights there):

.. math:: \frac{\partial y_l}{\partial w_r} = \frac{z_r - y_l}{W}, \qquad
          \frac{\partial y_l}{\partial z_r} = \frac{w_r}{W}

Where two switch points give the same end, the output has a kink, and the derivative for one of them
is used.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.sets.interval_type2 import GaussianUncertainMean, GaussianUncertainSigma
from fuzzy2.sets.shapes import Gaussian
from fuzzy2.support.checks import Array
from fuzzy2.support.pieces import pieces
from fuzzy2.systems.consequents import Linear
from fuzzy2.systems.fuzzifiers import Fuzzifier, SingletonFuzzifier
from fuzzy2.systems.system import FuzzySystem, IntervalType2System, Type1System


class TunableSystem:
    r"""A system as a vector of parameters, with the objective and its gradient.

    The vector holds, for every term, its mean(s) :math:`m / a` and the logarithm(s) of its standard
    deviation(s), then the consequents :math:`z / s`: numbers, or all left and then all right ends;
    a and s are the scales of input and output. For linear consequents it holds the coefficients
    :math:`c_0 / s` and :math:`a_i c_i / s`; their spreads are not tuned.

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
        self._input_scales = np.array(input_scales, dtype=float)
        self._output_scales = np.array(output_scales, dtype=float)
        given = system.consequents
        self._linear = given if isinstance(given, Linear) else None
        self._intervals = np.asarray(
            given.coefficients if isinstance(given, Linear) else given, dtype=float
        )
        self._has_intervals = self._linear is None and self._intervals.ndim == 3
        values: list[float] = []
        spreads: list[int] = []
        self._starts: list[list[int]] = []
        # Pairs of parameters whose order must be kept.
        self._pairs: list[tuple[int, int]] = []
        for terms, scale in zip(system.inputs, self._input_scales, strict=True):
            starts = []
            for term in terms:
                starts.append(len(values))
                means, sigmas = _means(term), _sigmas(term)
                first = starts[-1] + len(means)
                spreads.extend(range(first, first + len(sigmas)))
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
        self._spreads = np.array(spreads)
        self._compiled: Any = None

    def admissible(self, parameters: Array) -> Array:
        """Return parameters in which pairs that have crossed are set to their middle."""
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
        """Return the system with these parameters; everything else is as given.

        Parameters
        ----------
        parameters : (P,) ndarray
            Parameters with their pairs in order, see :meth:`admissible`.

        Returns
        -------
        Type1System or IntervalType2System
            A new system.
        """
        # Consequents with the same name may differ now.
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
            If no rule fires at a sample, or if parameters are so large that terms or the error
            overflow.
        """
        gradient = np.zeros_like(parameters)
        return self._mean(parameters, X, y, True, gradient), gradient / y.size

    def error(self, parameters: Array, X: Array, y: Array) -> float:
        """Return the objective alone; see :meth:`objective`."""
        return self._mean(parameters, X, y, False, np.empty(0))

    def _mean(self, parameters: Array, X: Array, y: Array, slopes: bool, gradient: Array) -> float:
        # Numba is imported with the first objective, not before.
        from fuzzy2.learning.tuning_kernels import add_squares

        sigmas = np.exp(parameters[self._spreads])
        if not (np.isfinite(parameters).all() and np.isfinite(sigmas).all() and (sigmas > 0).all()):
            raise InvalidValue("parameters", parameters, "those of terms that there can be")
        in_units = np.ascontiguousarray(y / self._output_scales)
        inputs, total = np.ascontiguousarray(X), 0.0
        for part in pieces(len(X)):
            samples = inputs[part], in_units[part]
            total, silent = add_squares(
                self._layout(), parameters, *samples, slopes, gradient, total
            )
            if silent >= 0:
                row = part.start + silent
                raise InvalidValue(
                    f"X[{row}]", X[row], "where some rule fires, for the system to have an output"
                )
        if not np.isfinite(total):
            raise InvalidValue("the squared error", total, "a number; the parameters are too large")
        return float(total / y.size)

    def _layout(self) -> Any:
        """Return the system in the layout of the compiled objective."""
        if self._compiled is None:
            from fuzzy2.learning.tuning_kernels import (
                CERTAIN,
                INTERVALS,
                LINEAR,
                NUMBERS,
                UNCERTAIN_MEAN,
                UNCERTAIN_SIGMA,
                Layout,
            )

            kinds = {GaussianUncertainMean: UNCERTAIN_MEAN, GaussianUncertainSigma: UNCERTAIN_SIGMA}
            counts = [len(terms) for terms in self._given.inputs]
            terms = [term for of_input in self._given.inputs for term in of_input]
            offsets = np.cumsum([0, *counts[:-1]])
            shape = (len(self._given.rules), self._given.n_outputs, len(counts) + 1)
            spreads, consequents = np.zeros(shape), INTERVALS if self._has_intervals else NUMBERS
            if self._linear is not None:
                spreads, consequents = self._linear.spreads / self._consequent_scales(), LINEAR
            known = [kinds.get(type(term), CERTAIN) for term in terms]
            certain = not any(known) and not self._has_intervals and not spreads.any()
            self._compiled = Layout(
                np.repeat(np.arange(len(counts)), counts),
                np.array(known),
                np.array([start for starts in self._starts for start in starts]),
                np.log([getattr(term, "height", 1.0) for term in terms]),
                np.where(self._given.rules >= 0, self._given.rules + offsets, -1),
                self._input_scales,
                spreads,
                int(certain),
                int(self._given.t_norm.name == "min"),
                consequents,
                self._first_consequent,
            )
        return self._compiled


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
            "its rules must join terms with and, have no weights and a consequent for every "
            "output; there must be no default outputs",
        )
    for name, terms in zip(system.input_names, system.inputs, strict=True):
        for term in terms:
            if not isinstance(term, Gaussian | GaussianUncertainMean | GaussianUncertainSigma):
                raise NotApplicable(what, f"the term {term!r} of {name} is not a Gaussian")
    if not isinstance(system.consequents, np.ndarray | Linear):
        raise NotApplicable(
            what,
            "the consequents must be numbers, intervals or linear functions; replace sets with "
            "their centroids",
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
