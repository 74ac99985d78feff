r"""ANFIS: Takagi–Sugeno–Kang systems learned from samples by hybrid learning.

Consequents are linear functions of the inputs and follow from least squares. An outer iteration
learns the means and standard deviations of the Gaussian terms, see :mod:`fuzzy2.learning.hybrid`.
Systems are type-1, or interval type-2 with a given footprint of uncertainty that learning does not
change.

Source: J.-S. R. Jang, "ANFIS: adaptive-network-based fuzzy inference system", IEEE Transactions on
Systems, Man, and Cybernetics 23(3), 1993.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import InvalidValue
from fuzzy2.learning.clustering import checked_fuzzifier, fuzzy_c_means
from fuzzy2.learning.estimator import Regressor
from fuzzy2.learning.hybrid import Data, History, Learner, State
from fuzzy2.learning.partition import (
    Integers,
    principal_terms,
    term_names,
    terms_per_input,
)
from fuzzy2.learning.premises import Premises
from fuzzy2.learning.samples import Samples, ranges_of, samples_of
from fuzzy2.learning.subtractive import subtractive_clustering
from fuzzy2.sets.interval_type2 import GaussianUncertainMean
from fuzzy2.sets.shapes import Gaussian
from fuzzy2.support.checks import (
    Array,
    generator,
    known_name,
    positive,
    real,
    reals,
    whole_number,
)
from fuzzy2.support.one_thread import one_thread
from fuzzy2.systems.consequents import Linear
from fuzzy2.systems.system import FuzzySystem, IntervalType2System, Type1System

KINDS = ("t1", "it2")
PARTITIONS = ("grid", "clusters", "subtractive")

RIDGES = (1e-11, 1e-8, 1e-5, 1e-2)
"""Weights of the coefficients from which the held-out samples choose."""

MOST_COEFFICIENTS = 2**14
"""Greatest number of coefficients of an output, whose least squares are solved in every epoch."""

WIDENINGS, EPOCHS_OF_WIDENING = 20, 2
"""Steps in which an interval system's footprint grows from zero width, and epochs of each step."""

OVERLAP = 3.0
"""Initial standard deviation of a cluster's terms, relative to that of its samples.

Linear consequents are valid beyond the samples of a cluster and need to blend with their neighbors.
"""


class ANFIS(Regressor):
    r"""Adaptive-network-based fuzzy inference system, with scikit-learn's conventions.

    First-order Takagi–Sugeno–Kang rules, *IF x1 is Low and x2 is High THEN y = c0 + c1 x1 + c2 x2*,
    with Gaussian terms under the product. Each epoch takes one Levenberg–Marquardt step in the
    means and standard deviations, with the least-squares consequents for them. Training ends when
    the error, or the error over held-out samples, no longer falls. If samples were held out,
    training is repeated on all samples with that number of epochs.

    Parameters
    ----------
    n_terms : int or sequence of p ints
        Number of terms of every input; with ``partition="clusters"``, the number of rules. An input
        with a single term does not distinguish rules and only enters the consequents.
    kind : {"t1", "it2"}
        Type-1 terms, or interval type-2 terms with uncertain means. Type reduction and its gradient
        are exact.
    partition : {"grid", "clusters", "subtractive"}
        ``"grid"`` makes a rule of every combination of the inputs' terms. ``"clusters"`` makes a
        rule with its own terms of each of ``n_terms`` clusters of the inputs (fuzzy c-means).
        ``"subtractive"`` makes a rule of each cluster of inputs and outputs with a given ``radius``
        (subtractive clustering), which determines their number.
    mean_variation : float
        Distance of the two uncertain means from their middle, as a share of each input's range. It
        is not learned, so the width of the footprint is kept. Used by ``kind="it2"``.
    ridge : float or sequence of floats
        Weight :math:`\lambda` of the squared coefficients, above 0, for inputs and outputs in units
        of their standard deviations. If several are given, the held-out samples choose one; without
        held-out samples, the first is used.
    most_epochs : int
        Epochs at most.
    patience : int
        Epochs without a smaller error over the held-out samples after which training stops. The
        error of an interval system jumps, so it stops after that many epochs without an error below
        1.3 times the smallest. If the last error is within that factor, all samples are learned
        until their error no longer falls.
    validation_share : float
        Share of the samples to hold out, at least 0 and below 1. With 0 there is no early stopping.
    fuzzifier : float
        Fuzzifier of the clusters, see :func:`fuzzy2.fuzzy_c_means`.
    radius : float
        Radius of the clusters with ``partition="subtractive"``, see
        :func:`fuzzy2.subtractive_clustering`.
    rng : numpy.random.Generator, optional
        Chooses the held-out samples and the starts of the clustering; by default it is seeded with
        0 at every call of :meth:`fit`.

    Attributes
    ----------
    system_ : Type1System or IntervalType2System
        The learned system, with :class:`fuzzy2.Linear` consequents.
    n_features_in_, n_outputs_ : int
        Numbers of inputs and outputs.
    feature_names_in_ : (p,) ndarray of str
        Names of the columns, if the samples were a table with names.
    training_errors_ : (E + 1,) ndarray
        Mean squared error over the training samples, before the first and after every epoch, in
        units of the outputs' variances.
    validation_errors_ : ndarray
        The same over the held-out samples, in the run that chose the number of epochs; empty if no
        samples were held out.
    n_iter_ : int
        Number of epochs E.
    ridge_ : float
        The ridge that was chosen.
    """

    _learned = ()

    training_errors_: Array
    validation_errors_: Array
    n_iter_: int
    ridge_: float

    def __init__(
        self,
        n_terms: int | Sequence[int] = 2,
        kind: str = "t1",
        partition: str = "grid",
        mean_variation: float = 0.025,
        ridge: float | Sequence[float] = RIDGES,
        most_epochs: int = 100,
        patience: int = 10,
        validation_share: float = 0.2,
        fuzzifier: float = 2.0,
        radius: float = 0.5,
        rng: np.random.Generator | None = None,
    ) -> None:
        # Parameters are stored as given and checked by fit, so that a grid search can set them in
        # any order.
        self.n_terms = n_terms
        self.kind = kind
        self.partition = partition
        self.mean_variation = mean_variation
        self.ridge = ridge
        self.most_epochs = most_epochs
        self.patience = patience
        self.validation_share = validation_share
        self.fuzzifier = fuzzifier
        self.radius = radius
        self.rng = rng

    def fit(self, X: ArrayLike, y: ArrayLike, sample_weight: ArrayLike | None = None) -> Self:
        """Learn premises and consequents from samples.

        Parameters
        ----------
        X : (N, p) array_like
            Inputs, with N of at least 2.
        y : (N,) or (N, m) array_like
            Outputs.
        sample_weight : (N,) array_like, optional
            Weight of each sample, 1 by default.

        Returns
        -------
        ANFIS
            The estimator itself, with :attr:`system_`.

        Raises
        ------
        InvalidValue, NotNumbers
            If samples or parameters are invalid. The message names an input that has the same value
            in all samples.
        UnknownName
            If ``kind`` or ``partition`` is unknown.
        """
        self._check_parameters()
        samples = samples_of(type(self).__name__, X, y, sample_weight)
        ranges = np.array(ranges_of("input", samples.input_names, samples.inputs))
        rng = np.random.default_rng(0) if self.rng is None else self.rng
        units = _Units.of(samples)
        layout = self._layout(samples, ranges, rng)
        data = units.scaled(samples.inputs, samples.outputs, samples.weights)
        start = np.concatenate(
            [
                (layout.means - units.middles[layout.owners]) / units.widths[layout.owners],
                np.log(layout.sigmas / units.widths[layout.owners]),
            ]
        )
        reaches = np.zeros(len(layout.owners))
        if self.kind == "it2":
            spans = (ranges[:, 1] - ranges[:, 0]) / units.widths
            reaches = self.mean_variation * spans[layout.owners]
        with one_thread():
            history, chosen, premises = self._learned_from(layout, start, reaches, data, rng)
        self._remember(samples)
        self.system_ = _system(samples, units, premises, history)
        self.training_errors_ = np.array(history.training_errors)
        self.validation_errors_ = np.array(chosen.errors)
        self.ridge_ = chosen.ridge
        self.n_iter_ = len(history.training_errors) - 1
        return self

    def _learned_from(
        self,
        layout: _Layout,
        start: Array,
        reaches: Array,
        data: Data,
        rng: np.random.Generator,
    ) -> tuple[History, _Chosen, Premises]:
        """Return the last run over all samples, and the settings chosen for it."""
        ridges = [float(ridge) for ridge in np.ravel(self.ridge)]
        parts = _held_back(data, self.validation_share, rng)
        premises = Premises(layout.owners, layout.rules, np.zeros_like(reaches))
        history, chosen = self._run(premises, start, None, data, parts, ridges)
        if (reaches > 0.0).any():
            # The interval system starts from the fully trained type-1 system. Stopping the type-1
            # training early would be a matter of chance, and so would be the result of the interval
            # training.
            learner = Learner(premises, data, chosen.ridge)
            whole = learner.learn(history.state, self.most_epochs, None, self.patience)
            # The result still depends on the starting point, so the better of two runs is kept.
            premises = Premises(layout.owners, layout.rules, reaches)
            runs = []
            for state in (
                whole.state,
                self._widened(layout, reaches, whole.state, data, chosen.ridge),
            ):
                start, coefficients = state.parameters, state.coefficients
                runs.append(self._run(premises, start, coefficients, data, parts, [chosen.ridge]))
            history, chosen = min(runs, key=lambda run: run[0].state.cost)
        return history, chosen, premises

    def _widened(
        self, layout: _Layout, reaches: Array, state: State, data: Data, ridge: float
    ) -> State:
        """Return a type-1 state after its footprint has grown nearly to its full width.

        The error of an interval system has a kink wherever a switch point changes, and learning can
        stop at any of many kinks. If the footprint grows gradually, few switch points change at a
        time.
        """
        for step in range(1, WIDENINGS):
            premises = Premises(layout.owners, layout.rules, step / WIDENINGS * reaches)
            learner = Learner(premises, data, ridge)
            start = learner.solved(state.parameters, state.coefficients)
            epochs = min(EPOCHS_OF_WIDENING, self.most_epochs)
            state = learner.learn(start, epochs, None, self.patience).state
        return state

    def _run(
        self,
        premises: Premises,
        start: Array,
        coefficients: Array | None,
        data: Data,
        parts: tuple[Data, Data] | None,
        ridges: list[float],
    ) -> tuple[History, _Chosen]:
        """Let the held-out samples choose ridge and epochs, and learn from all samples."""
        chosen = _Chosen(ridges[0], self.most_epochs, [])
        if parts is not None:
            part, rest = parts
            for ridge in ridges:
                learner = Learner(premises, part, ridge)
                tried = learner.learn(
                    learner.solved(start, coefficients), self.most_epochs, rest, self.patience
                )
                errors = tried.validation_errors
                if not chosen.errors or min(errors) < min(chosen.errors):
                    # The held-out error is as good at the end. An interval system stops at an
                    # arbitrary kink of its objective, so there is no reason for all samples to stop
                    # at the same epoch.
                    epochs = tried.best_epoch
                    if premises.is_interval and epochs == len(errors) - 1:
                        epochs = self.most_epochs
                    chosen = _Chosen(ridge, epochs, errors)
        learner = Learner(premises, data, chosen.ridge)
        first = learner.solved(start, coefficients)
        return learner.learn(first, chosen.epochs, None, self.patience), chosen

    def _layout(self, samples: Samples, ranges: Array, rng: np.random.Generator) -> _Layout:
        count = len(ranges)
        if self.partition == "subtractive":
            found = subtractive_clustering(
                np.concatenate([samples.inputs, samples.outputs], axis=1),
                self.radius,
                sample_weight=samples.weights,
            )
            number = len(found.centers)
            self._check_size(number, count)
            return _Layout(
                np.tile(np.arange(count), number),
                np.arange(number * count).reshape(number, count),
                found.centers[:, :count].ravel(),
                np.tile(found.sigmas[:count], number),
            )
        if self.partition == "clusters":
            number = whole_number("n_terms", self.n_terms, 1)
            self._check_size(number, count)
            widths = ranges[:, 1] - ranges[:, 0]
            clusters = fuzzy_c_means(
                (samples.inputs - ranges[:, 0]) / widths,
                number,
                self.fuzzifier,
                rng,
                sample_weight=samples.weights,
            )
            narrow = clusters.spreads <= 0.0
            # A cluster that is a single point along an input is given the distance to its neighbors
            # as its width there.
            spreads = np.where(narrow, 1.0 / number, clusters.spreads)
            return _Layout(
                np.tile(np.arange(count), number),
                np.arange(number * count).reshape(number, count),
                (ranges[:, 0] + widths * clusters.centers).ravel(),
                (OVERLAP * widths * spreads).ravel(),
            )
        numbers = terms_per_input(self.n_terms, count)
        self._check_size(math.prod(numbers), count)
        terms = [
            principal_terms(low, high, number)
            for (low, high), number in zip(ranges.tolist(), numbers, strict=True)
        ]
        first = np.cumsum([0, *numbers[:-1]])
        cells = np.array(list(itertools.product(*map(range, numbers))), dtype=np.int64)
        return _Layout(
            np.repeat(np.arange(count), numbers),
            cells + first,
            np.array([term.mean for row in terms for term in row]),
            np.array([term.sigma for row in terms for term in row]),
        )

    def _check_size(self, rules: int, inputs: int) -> None:
        most = MOST_COEFFICIENTS // (inputs + 1)
        if rules > most:
            remedy = "" if self.partition == "clusters" else "; partition='clusters' needs fewer"
            raise InvalidValue(
                "n_terms",
                self.n_terms,
                f"so few that there are at most {most:,} rules, not {rules:,}{remedy}",
            )

    def _check_parameters(self) -> None:
        for what, name, known in (
            ("kind of ANFIS", self.kind, KINDS),
            ("partition", self.partition, PARTITIONS),
        ):
            known_name(what, name, known)
        ridges = reals("ridge", self.ridge, "a number above 0, or several")
        if not ridges.size or not ((ridges > 0.0) & (ridges < np.inf)).all():
            raise InvalidValue("ridge", self.ridge, "a number above 0, or several")
        checked_fuzzifier(self.fuzzifier)
        positive("radius", self.radius)
        if real("mean_variation", self.mean_variation) < 0.0:
            raise InvalidValue("mean_variation", self.mean_variation, "at least 0")
        whole_number("most_epochs", self.most_epochs, 0)
        whole_number("patience", self.patience, 1)
        if not 0.0 <= real("validation_share", self.validation_share) < 1.0:
            raise InvalidValue("validation_share", self.validation_share, "at least 0 and below 1")
        if self.rng is not None:
            generator("rng", self.rng)


class _Chosen(NamedTuple):
    """Ridge, number of epochs, and the errors over the held-out samples that chose them."""

    ridge: float
    epochs: int
    errors: list[float]


class _Layout(NamedTuple):
    """Terms of all inputs in one row, and the rules (R, p) that use them."""

    owners: Integers
    rules: Integers
    means: Array
    sigmas: Array


class _Units(NamedTuple):
    """Middles and standard deviations of inputs and outputs."""

    middles: Array
    widths: Array
    output_middles: Array
    output_widths: Array

    @classmethod
    def of(cls, samples: Samples) -> _Units:
        """Return the units of samples; the unit of a constant output is 1."""
        found = []
        for table in (samples.inputs, samples.outputs):
            middle = np.average(table, axis=0, weights=samples.weights)
            width = np.sqrt(np.average((table - middle) ** 2, axis=0, weights=samples.weights))
            # The standard deviation of a constant column is 0 or a rounding error.
            flat = ~(np.ptp(table, axis=0) > 0.0) | ~(width > 0.0)
            found += [middle, np.where(flat, 1.0, width)]
        return cls(*found)

    def scaled(self, inputs: Array, outputs: Array, weights: Array) -> Data:
        """Return samples in these units."""
        return Data(
            (inputs - self.middles) / self.widths,
            (outputs - self.output_middles) / self.output_widths,
            weights,
        )


def _held_back(data: Data, share: float, rng: np.random.Generator) -> tuple[Data, Data] | None:
    """Return the training samples and the held-out samples, or None if nothing is held out.

    Equal samples stay together, because repeating a sample must have the same effect as doubling
    its weight.
    """
    _, group = np.unique(np.column_stack([data.X, data.y]), axis=0, return_inverse=True)
    group = group.reshape(-1)
    count = int(group.max()) + 1
    number = round(share * count)
    if number == 0 or count - number < 2:
        return None
    held = np.zeros(count, dtype=bool)
    held[rng.permutation(count)[:number]] = True
    rows = held[group]
    learned, checked = (
        Data(data.X[part], data.y[part], data.weights[part]) for part in (~rows, rows)
    )
    return learned, checked


def _system(samples: Samples, units: _Units, premises: Premises, history: History) -> FuzzySystem:
    """Return the system in the units of the samples, with its terms in ascending order."""
    owners, state = premises.owners, history.state
    count = len(owners)
    widths = units.widths[owners]
    means = units.middles[owners] + widths * state.parameters[:count]
    sigmas = widths * np.exp(state.parameters[count:])
    reaches = widths * premises.reaches
    terms: list[list[Any]] = []
    position = np.empty(count, dtype=np.int64)
    for i in range(len(units.widths)):
        own = np.flatnonzero(owners == i)
        own = own[np.argsort(means[own], kind="stable")]
        position[own] = np.arange(len(own))
        terms.append(
            [
                GaussianUncertainMean(
                    (float(means[t] - reaches[t]), float(means[t] + reaches[t])), float(sigmas[t])
                )
                if premises.is_interval
                else Gaussian(float(means[t]), float(sigmas[t]))
                for t in own
            ]
        )
    scaled = state.coefficients  # (R, m, p + 1)
    slopes = units.output_widths[:, np.newaxis] * scaled[..., 1:] / units.widths
    constants = units.output_middles + units.output_widths * scaled[..., 0] - slopes @ units.middles
    coefficients = np.concatenate([constants[..., np.newaxis], slopes], axis=-1)
    make = IntervalType2System if premises.is_interval else Type1System
    return make(
        terms,
        position[premises.rules],
        Linear(coefficients),
        input_names=samples.input_names,
        output_names=samples.output_names,
        term_names=[term_names(len(row)) for row in terms],
    )
