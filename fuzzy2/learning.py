r"""Learning a rule base from samples by table look-up (Wang and Mendel), for type-1, interval and general type-2 systems.

Every input's range is partitioned by Gaussian terms, and each cell of the grid of terms is a rule; or clusters of the samples are the
rules, and their projections on the inputs the terms. What the rules say is read from the samples. Means of type-2 terms are uncertain
to both sides by a share of the range, see :mod:`fuzzy2.noise` for how much; rules are chosen by the memberships in the *principal*
terms, with the mean in its middle, so that systems of all three kinds learned from the same samples have the same rules and differ in
nothing but their uncertainty. Without uncertainty they are the same system.

:class:`WangMendel` follows scikit-learn's conventions and does not need it.

Source: L.-X. Wang and J. M. Mendel, "Generating fuzzy rules by learning from examples", IEEE Transactions on Systems, Man, and
Cybernetics 22(6), 1992.
"""

from __future__ import annotations

import dataclasses
import inspect
import itertools
import math
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fuzzy2.checks import Array, positive, real, reals
from fuzzy2.clustering import Clusters, fuzzy_c_means
from fuzzy2.errors import (
    FeatureNamesWarning,
    InvalidValue,
    NotFitted,
    NotNumbers,
    UnknownName,
    UnsupportedRule,
    WrongFeatures,
)
from fuzzy2.general_type2 import GaussianType2Set
from fuzzy2.interval_type2 import GaussianUncertainMean
from fuzzy2.systems import FuzzySystem, GeneralType2System, IntervalType2System, Type1System
from fuzzy2.type1 import Gaussian

Term = Gaussian | GaussianUncertainMean | GaussianType2Set
Integers = NDArray[np.int64]

KINDS = ("t1", "it2", "gt2")
"""Kinds of systems: type-1, interval type-2, general type-2."""

LEARNERS = ("strongest", "strict", "average", "ridge")
"""Names of the ways to the rules' consequents, see :class:`WangMendel`."""

PARTITIONS = ("grid", "clusters")
"""Names of where terms and rules come from, see :class:`WangMendel`."""

COMPLETIONS = ("nearest", "average", "none")
"""Names of what the strict learner does about cells without a sample."""

LEAST_FIRING = 1e-3
"""Firing below which no sample says anything about a rule."""

MOST_RULES = 2**20
"""Rules of the largest grid that is filled."""

MOST_RIDGE_RULES = 2**13
"""Rules of the largest grid whose least-squares problem is solved: its matrix takes half a gigabyte."""

_CROSSING = 2.0 * math.sqrt(2.0 * math.log(2.0))  # full width of a Gaussian at half its height, in standard deviations
_BLOCK = 2**22  # firing strengths held in memory at once


def gaussian_partition(least: float, greatest: float, n_terms: int = 2, kind: str = "it2", mean_variation: float = 0.0) -> tuple[Term, ...]:
    r"""Return Gaussian terms that partition a range evenly; neighbors cross at a membership of 1/2.

    .. math::

        m_k = a + k\,d, \quad d = \frac{b - a}{K - 1}, \quad \sigma = \frac{d}{2\sqrt{2\ln 2}}, \qquad k = 0, \dots, K - 1

    A single term has its mean in the middle of the range and membership 1/2 at both ends. With a crossing of 1/2 the memberships of
    two neighbors add up to between 1 and 17/16 everywhere between their means: no part of the range counts much more than another.

    Parameters
    ----------
    least, greatest : float
        Ends a < b of the range.
    n_terms : int
        Number K of terms, at least 1.
    kind : {"t1", "it2", "gt2"}
        Type-1 Gaussians; Gaussians with uncertain mean :math:`m_k \pm \nu (b - a)`; or Gaussian principal memberships with
        Gaussian secondary grades of standard deviation :math:`\nu (b - a)\, e^{-1/2} / (\sqrt{3}\,\sigma)`, which is to first
        order what a mean spread evenly over that interval does to the membership where that is steepest.
    mean_variation : float
        Distance :math:`\nu` of the smallest and the largest mean from the middle as a share of the range, at least 0; 0 is type-1. Not
        used by "t1".

    Returns
    -------
    tuple of sets
        The terms in ascending order.

    Raises
    ------
    InvalidValue
        If the range has no width, or a number is outside of what it can be.
    UnknownName
        If the kind is unknown.
    """
    least, greatest = real("least", least), real("greatest", greatest)
    if not least < greatest:
        raise InvalidValue("greatest", greatest, f"above least, {least!r}")
    count = _whole("n_terms", n_terms, 1)
    if kind not in KINDS:
        raise UnknownName("kind of system", kind, KINDS)
    variation = real("mean_variation", mean_variation)
    if variation < 0.0:
        raise InvalidValue("mean_variation", mean_variation, "at least 0")
    width = greatest - least
    means = np.linspace(least, greatest, count) if count > 1 else np.array([0.5 * least + 0.5 * greatest])
    sigmas = np.full(count, width / max(count - 1, 1) / _CROSSING)
    return _gaussian_terms(means, sigmas, kind, variation * width)


def _gaussian_terms(means: Array, sigmas: Array, kind: str, reach: float) -> tuple[Term, ...]:
    """Return Gaussian terms of a kind whose means are uncertain by ``reach`` to both sides; see :func:`gaussian_partition`."""
    pairs = list(zip(means.tolist(), sigmas.tolist(), strict=True))
    if kind == "t1":
        return tuple(Gaussian(mean, sigma) for mean, sigma in pairs)
    if kind == "it2":
        return tuple(GaussianUncertainMean((mean - reach, mean + reach), sigma) for mean, sigma in pairs)
    return tuple(GaussianType2Set(Gaussian(mean, sigma), reach * math.exp(-0.5) / (math.sqrt(3.0) * sigma)) for mean, sigma in pairs)


def cluster_partition(
    clusters: Clusters, widths: ArrayLike, kind: str = "it2", mean_variation: float = 0.0
) -> tuple[tuple[tuple[Term, ...], ...], Integers]:
    r"""Return the projections of clusters on the inputs as Gaussian terms, and a rule for each cluster.

    The term of cluster k on input i has the center :math:`v_{ki}` for its mean and the spread of the cluster's samples along that input,

    .. math:: \sigma_{ki}^2 = \frac{\sum_n u_{nk}^m (x_{ni} - v_{ki})^2}{\sum_n u_{nk}^m},

    for its standard deviation. (M. Sugeno and T. Yasukawa, "A fuzzy-logic-based approach to qualitative modeling", IEEE Transactions on
    Fuzzy Systems 1(1), 1993, for rules by projection.)

    Parameters
    ----------
    clusters : Clusters
        K clusters of samples of p inputs, see :func:`fuzzy2.fuzzy_c_means`.
    widths : (p,) array_like
        What the mean variation is a share of, such as the inputs' ranges; above 0.
    kind, mean_variation
        See :func:`gaussian_partition`.

    Returns
    -------
    terms : tuple of p tuples of K sets
        The terms of every input in ascending order of their means.
    rules : (K, p) ndarray of int
        Which term of each input belongs to each cluster.

    Raises
    ------
    InvalidValue
        If all samples of a cluster have the same value of an input, so that it has no width there, or a number is outside of what it can
        be.
    UnknownName
        If the kind is unknown.
    """
    if kind not in KINDS:
        raise UnknownName("kind of system", kind, KINDS)
    variation = real("mean_variation", mean_variation)
    if variation < 0.0:
        raise InvalidValue("mean_variation", mean_variation, "at least 0")
    centers, spreads = clusters.centers, clusters.spreads
    reaches = reals("widths", widths)
    if reaches.shape != centers.shape[1:] or not ((reaches > 0.0) & np.isfinite(reaches)).all():
        raise InvalidValue("widths", reaches, f"{centers.shape[1]} finite numbers above 0")
    flat = np.argwhere(~(spreads > 0.0))
    if len(flat):
        k, i = (int(index) for index in flat[0])
        wanted = f"clusters with a width along every input; cluster {k + 1} has none along input {i + 1}: take fewer clusters"
        raise InvalidValue("clusters", spreads[k], wanted)
    order = np.argsort(centers, axis=0, kind="stable")
    terms = tuple(
        _gaussian_terms(centers[order[:, i], i], spreads[order[:, i], i], kind, float(variation * reaches[i])) for i in range(len(reaches))
    )
    return terms, np.asarray(np.argsort(order, axis=0), dtype=np.int64)


def term_names(n_terms: int) -> tuple[str, ...]:
    """Return names for the terms of a partition in ascending order: Low, Mid and High for up to three, else with numbers."""
    known: dict[int, tuple[str, ...]] = {1: ("Any",), 2: ("Low", "High"), 3: ("Low", "Mid", "High")}
    return known.get(n_terms) or tuple(f"Level{k + 1}" for k in range(n_terms))


class WangMendel:
    r"""Table look-up learning of fuzzy rules (Wang and Mendel), with scikit-learn's conventions.

    The rules are the cells of the grid of all inputs' terms, or clusters of the samples. ``learner`` says what a rule's consequent is:

    - ``"strongest"``: that of the sample that fires the rule most (the first of several), so that no cell stays empty.
    - ``"strict"``: the procedure as published. Every sample makes one rule, of the terms in which its inputs (and output) have most
      membership; its degree is the t-norm of these memberships; of rules for the same cell the one of the highest degree stays.
      Cells without a rule are completed as ``completion`` says.
    - ``"average"``: the average of all samples, weighted with how strongly they fire the rule.
    - ``"ridge"``: the consequents c that minimize
      :math:`\frac{1}{N} \sum_n \lVert y_n - \sum_r \phi_{nr} c_r \rVert^2 + \lambda \sum_r \lVert c_r - \bar c_r \rVert^2`, with
      :math:`\phi` the firing strengths of the type-1 system over their sum and :math:`\bar c` the averages: least squares where the
      samples say something, the average where they do not.

    Firing here is that of the principal (type-1) terms.

    Parameters
    ----------
    n_terms : int or sequence of p ints
        Number of Gaussian terms of every input; one number for all of them if terms come from clusters, which is that of the rules, too.
    kind : {"it2", "t1", "gt2"}
        Kind of system: interval type-2, type-1, or general type-2.
    mean_variation : float
        Uncertainty of the terms' means, to either side, as a share of each input's range; 0 is type-1. See
        :func:`fuzzy2.noise.mean_variation_from_snr`. Not used by ``kind="t1"``.
    learner : {"strongest", "strict", "average", "ridge"}
        How consequents are found.
    completion : {"nearest", "average", "none"}
        What the strict learner does about empty cells: takes the rule of the nearest cell (distances between cells are those of
        their centers, in shares of the inputs' ranges; the highest degree decides between equally near ones), averages all rules
        with the inverse squares of their distances as weights, or leaves the cells without a rule.
    ridge : float
        Weight :math:`\lambda` of the ridge learner, above 0.
    output_terms : int or None
        None: consequents are values. A number K: every output's range is partitioned by K Gaussian terms of the same mean variation,
        a consequent is the term whose mean is nearest, and enters the system as that term's centroid (an interval for "it2"
        and "gt2", whose output terms are both interval type-2).
    t_norm : {"product", "min"}
        How the memberships of a rule's antecedents are combined.
    reduction : {"alpha_planes", "gaussian"}
        Type reduction of ``kind="gt2"``, see :class:`fuzzy2.systems.GeneralType2System`.
    levels : int
        Number of α-planes of ``kind="gt2"``.
    partition : {"grid", "clusters"}
        Where terms and rules come from. On the grid the terms lie evenly over the range of the samples, see :func:`gaussian_partition`,
        and every combination of them is a rule. With clusters, fuzzy c-means comes first: each of ``n_terms`` clusters of the
        inputs is a rule, and its projections are its terms (:func:`cluster_partition`). Many inputs then need no more rules than few,
        and there are rules only where samples are. Inputs count in shares of their ranges; not for the strict learner.
    fuzzifier : float
        Of the clusters, see :func:`fuzzy2.fuzzy_c_means`.
    rng : numpy.random.Generator, optional
        Of the clusters' starts; seeded with 0 at every call of :meth:`fit` by default.

    Attributes
    ----------
    system_ : Type1System, IntervalType2System or GeneralType2System
        The system that was learned.
    n_features_in_, n_outputs_ : int
        Numbers of inputs and outputs.
    feature_names_in_ : (p,) ndarray of str
        Names of the columns, if the samples were a table with names; then they name the system's inputs, too.
    best_firing_ : (R,) ndarray
        Greatest firing of each rule by a sample, before completion.
    rule_samples_ : (R, m) ndarray of int
        Sample from which a rule has its consequent; -1 where it is no single sample's. For "strongest" and "strict".
    output_terms_ : tuple of m tuples of sets
        Terms of the outputs, if ``output_terms`` is a number.
    output_rules_ : (R, m) ndarray of int
        Number of the output term of every rule, -1 where completion averaged, if ``output_terms`` is a number.
    clusters_ : Clusters
        What fuzzy c-means found, in shares of the inputs' ranges, if the rules are clusters.
    """

    system_: FuzzySystem
    n_features_in_: int
    n_outputs_: int
    feature_names_in_: NDArray[np.object_]
    best_firing_: Array
    rule_samples_: Integers
    output_terms_: tuple[tuple[Term, ...], ...]
    output_rules_: Integers
    clusters_: Clusters

    def __init__(
        self,
        n_terms: int | Sequence[int] = 2,
        kind: str = "it2",
        mean_variation: float = 0.1,
        learner: str = "strongest",
        completion: str = "nearest",
        ridge: float = 1e-3,
        output_terms: int | None = None,
        t_norm: str = "product",
        reduction: str = "alpha_planes",
        levels: int = 5,
        partition: str = "grid",
        fuzzifier: float = 2.0,
        rng: np.random.Generator | None = None,
    ) -> None:
        # Stored as given and checked by fit, so that a grid search can set them in any order.
        self.n_terms = n_terms
        self.kind = kind
        self.mean_variation = mean_variation
        self.learner = learner
        self.completion = completion
        self.ridge = ridge
        self.output_terms = output_terms
        self.t_norm = t_norm
        self.reduction = reduction
        self.levels = levels
        self.partition = partition
        self.fuzzifier = fuzzifier
        self.rng = rng

    def __repr__(self) -> str:
        defaults = inspect.signature(type(self).__init__).parameters
        changed = (f"{name}={value!r}" for name, value in self.get_params().items() if not _same(value, defaults[name].default))
        return f"{type(self).__name__}({', '.join(changed)})"

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """Return the parameters by name.

        Parameters
        ----------
        deep : bool
            Not used: no parameter is an estimator.

        Returns
        -------
        dict
            Parameters as they were given.
        """
        names = sorted(name for name in inspect.signature(type(self).__init__).parameters if name != "self")
        return {name: getattr(self, name) for name in names}

    def set_params(self, **parameters: Any) -> Self:
        """Set parameters by name; the next :meth:`fit` uses them.

        Parameters
        ----------
        **parameters
            New values.

        Returns
        -------
        WangMendel
            The estimator itself.

        Raises
        ------
        UnknownName
            If there is no such parameter; then none is set.
        """
        known = self.get_params()
        for name in parameters:
            if name not in known:
                raise UnknownName(f"parameter of {type(self).__name__}", name, tuple(known))
        for name, value in parameters.items():
            setattr(self, name, value)
        return self

    def fit(self, X: ArrayLike, y: ArrayLike) -> Self:
        """Learn the rules from samples.

        Parameters
        ----------
        X : (N, p) array_like
            Inputs; N is at least 2.
        y : (N,) or (N, m) array_like
            Outputs.

        Returns
        -------
        WangMendel
            The estimator itself, with :attr:`system_`.

        Raises
        ------
        InvalidValue, NotNumbers
            If samples or parameters are not what they must be; an input (or output, if it has terms) that has the same value in all
            samples is named.
        UnknownName
            If ``kind``, ``learner``, ``completion``, ``t_norm``, ``reduction`` or ``partition`` is unknown.
        UnsupportedRule
            If no sample fires some rule by more than 0.001; the strict learner needs no such sample.
        """
        self._check_parameters()
        names = _column_names(X)
        inputs = _table("X", X)
        if inputs.shape[0] < 2:
            raise InvalidValue("X", f"{inputs.shape[0]} sample", "a table of at least 2 samples, which span a range")
        outputs, one_column = _outputs(y, len(inputs))
        count = inputs.shape[1]
        input_names = tuple(names) if names is not None else tuple(f"x{i + 1}" for i in range(count))
        ranges = _ranges("input", input_names, inputs)
        output_names = _column_names(y)
        if output_names is None or len(output_names) != outputs.shape[1]:
            output_names = [f"y{j + 1}" for j in range(outputs.shape[1])]

        partition = self._partition_by_clusters(inputs, ranges) if self.partition == "clusters" else self._partition_evenly(ranges)
        terms, principal, rules, clusters = partition
        grades = [_grades_in(inputs[:, i], principal[i]) for i in range(count)]
        words = [term_names(len(of_input)) for of_input in terms]
        combine: Callable[..., Array] = np.multiply if self.t_norm == "product" else np.minimum

        quantizer = None
        if self.output_terms is not None:
            kind = "t1" if self.kind == "t1" else "it2"
            output_ranges = _ranges("output", output_names, outputs)
            quantizer = _Quantizer(output_ranges, self.output_terms, kind, self.mean_variation)
        if self.learner == "strict":
            learned = _strict(grades, outputs, combine, quantizer, self.completion)
        else:
            learned = _from_all(grades, outputs, combine, rules, self.learner, self.ridge)
            _check_support(learned, input_names, words)
            if quantizer is not None:
                learned = learned._replace(values=None, terms=quantizer.nearest(learned.point_values()))
        consequents = learned.consequents(quantizer)

        options: dict[str, Any] = {"input_names": input_names, "output_names": tuple(output_names), "term_names": words}
        system: FuzzySystem
        if self.kind == "t1":
            system = Type1System(terms, learned.rules, consequents, self.t_norm, **options)
        elif self.kind == "it2":
            system = IntervalType2System(terms, learned.rules, consequents, self.t_norm, **options)
        else:
            options |= {"reduction": self.reduction, "levels": self.levels}
            system = GeneralType2System(terms, learned.rules, consequents, self.t_norm, **options)

        self._forget()
        self.system_, self._one_column = system, one_column
        self.n_features_in_, self.n_outputs_ = count, outputs.shape[1]
        if names is not None:
            self.feature_names_in_ = np.array(names, dtype=object)
        self.best_firing_ = learned.best_firing
        if learned.samples is not None:
            self.rule_samples_ = learned.samples
        if quantizer is not None and learned.terms is not None:
            self.output_terms_, self.output_rules_ = quantizer.terms, learned.terms
        if clusters is not None:
            self.clusters_ = clusters
        return self

    def _partition_evenly(self, ranges: list[tuple[float, float]]) -> _Partition:
        numbers = _terms_per_input(self.n_terms, len(ranges))
        self._check_size(math.prod(numbers))
        terms = [gaussian_partition(*ends, number, self.kind, self.mean_variation) for ends, number in zip(ranges, numbers, strict=True)]
        # Of all kinds the same numbers to the last digit, so that equal grades are settled in the same way.
        principal = [_principal_terms(*ends, number) for ends, number in zip(ranges, numbers, strict=True)]
        return _Partition(terms, principal, None, None)

    def _partition_by_clusters(self, inputs: Array, ranges: list[tuple[float, float]]) -> _Partition:
        if self.learner == "strict":
            raise InvalidValue("learner", self.learner, "another one with partition='clusters', where every rule is a cluster's")
        number = _whole("n_terms", self.n_terms, 1)
        self._check_size(number)
        least, greatest = np.array(ranges).T
        widths = greatest - least
        clusters = fuzzy_c_means((inputs - least) / widths, number, self.fuzzifier, self.rng)
        placed = dataclasses.replace(clusters, centers=least + widths * clusters.centers, spreads=widths * clusters.spreads)
        terms, rules = cluster_partition(placed, widths, self.kind, self.mean_variation)
        principal, _ = cluster_partition(placed, widths, "t1")
        return _Partition(terms, _principal(principal), rules, clusters)

    def predict(self, X: ArrayLike) -> Array:
        """Return the crisp outputs of the system.

        Parameters
        ----------
        X : (n, p) array_like
            Inputs.

        Returns
        -------
        (n,) or (n, m) ndarray
            Outputs, of one or two dimensions as those of :meth:`fit`; NaN where no rule fires.

        Raises
        ------
        NotFitted
            If there is no system yet; scikit-learn's ``NotFittedError`` as well, if that is imported.
        InvalidValue, NotNumbers, WrongFeatures
            If the inputs are not finite numbers, or not those of :meth:`fit`.
        """
        values = self._system()(self._inputs(X))
        return values[:, 0] if self._one_column else values

    def predict_interval(self, X: ArrayLike) -> Array:
        """Return the type-reduced intervals of the system.

        They show what the uncertainty of the terms does to the output. They are no confidence intervals: how often they cover the
        truth is not known.

        Parameters
        ----------
        X : (n, p) array_like
            Inputs.

        Returns
        -------
        (n, 2) or (n, m, 2) ndarray
            Left and right ends, NaN where no rule fires. Of ``kind="gt2"`` those of the lowest α-plane, or two standard deviations
            to both sides of the mean under ``reduction="gaussian"``.

        Raises
        ------
        NotFitted, InvalidValue, NotNumbers, WrongFeatures
            See :meth:`predict`.
        """
        system = self._system()
        reduced = system.type_reduced(self._inputs(X))
        if isinstance(system, GeneralType2System) and system.reduction == "gaussian":
            mean, reach = reduced[..., 0], 2.0 * reduced[..., 1]
            reduced = np.stack([mean - reach, mean + reach], axis=-1)
        return reduced[:, 0] if self._one_column else reduced

    def score(self, X: ArrayLike, y: ArrayLike) -> float:
        r"""Return the coefficient of determination, :math:`R^2 = 1 - \sum_n (y_n - \hat y_n)^2 / \sum_n (y_n - \bar y)^2`.

        Parameters
        ----------
        X : (n, p) array_like
            Inputs.
        y : (n,) or (n, m) array_like
            True outputs.

        Returns
        -------
        float
            At most 1; the plain average over the outputs. An output that is constant counts 1 if it is met exactly and else 0.
            NaN if no rule fires at some input.

        Raises
        ------
        NotFitted, InvalidValue, NotNumbers, WrongFeatures
            See :meth:`predict`; also if ``y`` has not as many outputs as in :meth:`fit`.
        """
        predicted = self._system()(self._inputs(X))
        truth, _ = _outputs(y, len(predicted))
        if truth.shape != predicted.shape:
            raise InvalidValue("y", truth.shape, f"of {predicted.shape[1]} outputs, as in fit")
        residual = ((truth - predicted) ** 2).sum(axis=0)
        total = ((truth - truth.mean(axis=0)) ** 2).sum(axis=0)
        with np.errstate(divide="ignore", invalid="ignore"):
            determination = np.where(total > 0.0, 1.0 - residual / total, np.where(residual == 0.0, 1.0, 0.0))
        return float(np.where(np.isnan(residual), np.nan, determination).mean())

    def __sklearn_is_fitted__(self) -> bool:
        """Tell scikit-learn whether there is a system."""
        return hasattr(self, "system_")

    def __sklearn_tags__(self) -> Any:
        """Return scikit-learn's description of the estimator; only scikit-learn itself asks for it."""
        from sklearn.utils import InputTags, RegressorTags, Tags, TargetTags

        return Tags(
            estimator_type="regressor",
            target_tags=TargetTags(required=True, multi_output=True),
            regressor_tags=RegressorTags(),
            input_tags=InputTags(),
        )

    def _check_parameters(self) -> None:
        choices = (
            ("kind of system", self.kind, KINDS),
            ("learner", self.learner, LEARNERS),
            ("completion", self.completion, COMPLETIONS),
            ("partition", self.partition, PARTITIONS),
            ("t-norm of a rule base that is learned", self.t_norm, ("product", "min")),
        )
        for what, name, known in choices:
            if name not in known:
                raise UnknownName(what, name, known)
        positive("ridge", self.ridge)
        if real("mean_variation", self.mean_variation) < 0.0:
            raise InvalidValue("mean_variation", self.mean_variation, "at least 0")
        if self.output_terms is not None:
            _whole("output_terms", self.output_terms, 2)

    def _check_size(self, rules: int) -> None:
        if self.learner == "strict" and self.completion == "none":
            return
        most = MOST_RIDGE_RULES if self.learner == "ridge" else MOST_RULES
        if rules > most:
            remedy = "or use partition='clusters', or learner='strict' with completion='none', which have rules where samples are"
            raise InvalidValue("n_terms", self.n_terms, f"so few that there are at most {most:,} rules, not {rules:,}; {remedy}")

    def _forget(self) -> None:
        for name in ("feature_names_in_", "rule_samples_", "output_terms_", "output_rules_", "clusters_"):
            self.__dict__.pop(name, None)

    def _system(self) -> FuzzySystem:
        if not hasattr(self, "system_"):
            raise _not_fitted(type(self).__name__)
        return self.system_

    def _inputs(self, X: ArrayLike) -> Array:
        names, known = _column_names(X), getattr(self, "feature_names_in_", None)
        if names is not None and known is not None and list(known) != names:
            raise WrongFeatures(type(self).__name__, self.n_features_in_, len(names), tuple(known), tuple(names))
        if (names is None) != (known is None):
            warnings.warn(FeatureNamesWarning(type(self).__name__, known is not None), stacklevel=3)
        inputs = _table("X", X)
        if inputs.shape[1] != self.n_features_in_:
            raise WrongFeatures(type(self).__name__, self.n_features_in_, inputs.shape[1])
        return inputs


class _Partition(NamedTuple):
    """Terms of every input, the principal ones, rules (R, p) where they are not all combinations, and clusters where there are some."""

    terms: Sequence[tuple[Term, ...]]
    principal: Sequence[tuple[Gaussian, ...]]
    rules: Integers | None
    clusters: Clusters | None


class _Learned(NamedTuple):
    """Rules with consequents as values (R, m), intervals (R, m, 2) or numbers of output terms (R, m)."""

    rules: Integers
    best_firing: Array
    values: Array | None
    terms: Integers | None
    samples: Integers | None

    def point_values(self) -> Array:
        assert self.values is not None
        return self.values

    def consequents(self, quantizer: _Quantizer | None) -> Array:
        if self.values is not None:
            return self.values
        assert self.terms is not None
        assert quantizer is not None
        return quantizer.intervals(self.terms)


class _Quantizer:
    """Output terms: which is nearest to a value, and what its centroid is."""

    def __init__(self, ranges: list[tuple[float, float]], n_terms: int, kind: str, mean_variation: float) -> None:
        self.terms = tuple(gaussian_partition(*ends, n_terms, kind, mean_variation) for ends in ranges)
        self.principal = [_principal_terms(*ends, n_terms) for ends in ranges]
        self.means = np.array([[term.mean for term in row] for row in self.principal])
        self.centroids = np.array([[_centroid(term) for term in row] for row in self.terms])

    def nearest(self, values: Array) -> Integers:
        """Return the numbers (N, m) of the terms with the means nearest to the values (N, m), in which they have most membership."""
        return np.asarray(np.abs(values[..., np.newaxis] - self.means).argmin(axis=-1), dtype=np.int64)

    def memberships(self, values: Array, numbers: Integers) -> Array:
        """Return the memberships (N, m) of the values in terms (N, m), the principal ones."""
        columns = (_grades_in(values[:, j], self.principal[j]) for j in range(values.shape[1]))
        return np.stack([np.take_along_axis(grades, numbers[:, [j]], axis=1)[:, 0] for j, grades in enumerate(columns)], axis=1)

    def intervals(self, numbers: Integers) -> Array:
        """Return the centroids (R, m, 2) of terms (R, m)."""
        return np.asarray(self.centroids[np.arange(len(self.terms)), numbers])


def _from_all(
    grades: list[Array], outputs: Array, combine: Callable[..., Array], given: Integers | None, learner: str, ridge: float
) -> _Learned:
    """Let every rule, given or of the grid, take its consequent from all samples."""
    rules = _all_cells([of_input.shape[1] for of_input in grades]) if given is None else given
    best, sample = np.full(len(rules), -1.0), np.zeros(len(rules), dtype=np.int64)
    weight, moment = np.zeros(len(rules)), np.zeros((len(rules), outputs.shape[1]))
    for rows, firing in _firing_blocks(grades, combine, given):
        winner = firing.argmax(axis=0)
        strength = firing[winner, np.arange(len(rules))]
        stronger = strength > best  # not >=: the first of equally strong samples stays
        best, sample = np.where(stronger, strength, best), np.where(stronger, winner + rows.start, sample)
        weight += firing.sum(axis=0)
        moment += firing.T @ outputs[rows]
    if learner == "strongest":
        return _Learned(rules, best, outputs[sample], None, np.repeat(sample[:, np.newaxis], outputs.shape[1], axis=1))
    # A rule that nothing fires is refused later, and must not warn before.
    average = moment / np.maximum(weight, np.finfo(float).tiny)[:, np.newaxis]
    if learner == "average":
        return _Learned(rules, best, average, None, None)
    gram, right_side = np.zeros((len(rules), len(rules))), np.zeros_like(moment)
    for rows, firing in _firing_blocks(grades, combine, given):
        shares = firing / firing.sum(axis=1, keepdims=True)
        gram += shares.T @ shares
        right_side += shares.T @ (outputs[rows] - shares @ average)
    gram = gram / len(outputs) + ridge * np.eye(len(rules))
    return _Learned(rules, best, average + np.linalg.solve(gram, right_side / len(outputs)), None, None)


def _strict(grades: list[Array], outputs: Array, combine: Callable[..., Array], quantizer: _Quantizer | None, completion: str) -> _Learned:
    """Let every sample make a rule, settle conflicts by degree, and complete the cells that have no rule."""
    own = np.stack([of_input.argmax(axis=1) for of_input in grades], axis=1)
    antecedent = _reduced(combine, [of_input.max(axis=1) for of_input in grades])
    degree = np.repeat(antecedent[:, np.newaxis], outputs.shape[1], axis=1)
    numbers = None
    if quantizer is not None:
        numbers = quantizer.nearest(outputs)
        degree = combine(degree, quantizer.memberships(outputs, numbers))
    covered, cell = np.unique(own, axis=0, return_inverse=True)
    cell = cell.reshape(-1)
    samples = np.empty((len(covered), outputs.shape[1]), dtype=np.int64)
    for j in range(outputs.shape[1]):
        # Stable, so that the first of equal degrees comes first; the last written, which is the first in order, stays.
        order = np.argsort(-degree[:, j], kind="stable")[::-1]
        samples[cell[order], j] = order
    columns = np.arange(outputs.shape[1])
    degrees = degree[samples, columns]
    best = np.zeros(len(covered))
    np.maximum.at(best, cell, antecedent)
    if completion == "none":
        values = outputs[samples, columns] if numbers is None else None
        return _Learned(covered, best, values, None if numbers is None else numbers[samples, columns], samples)

    shape = [of_input.shape[1] for of_input in grades]
    rules = _all_cells(shape)
    position = np.ravel_multi_index(tuple(covered.T), shape)
    has_rule = np.zeros(len(rules), dtype=bool)
    has_rule[position] = True
    empty = np.flatnonzero(~has_rule)
    full_samples = np.full((len(rules), outputs.shape[1]), -1, dtype=np.int64)
    full_samples[position] = samples
    firing = np.zeros(len(rules))
    for _, block in _firing_blocks(grades, combine):
        firing = np.maximum(firing, block.max(axis=0))
    scale = np.maximum(np.array(shape) - 1.0, 1.0)
    if completion == "nearest":
        donors = full_samples.copy()
        for c in empty:
            distance = _squared_distances(covered, rules[c], scale)
            # Squares of sums of shares; equal distances differ by rounding.
            near = distance <= distance.min() * (1.0 + 1e-12)
            donors[c] = samples[np.where(near[:, np.newaxis], degrees, -1.0).argmax(axis=0), columns]
        values = outputs[donors, columns] if numbers is None else None
        return _Learned(rules, firing, values, None if numbers is None else numbers[donors, columns], full_samples)
    known = outputs[samples, columns] if quantizer is None or numbers is None else quantizer.intervals(numbers[samples, columns])
    values = np.empty((len(rules), *known.shape[1:]))
    values[position] = known
    for c in empty:
        share = 1.0 / _squared_distances(covered, rules[c], scale)
        values[c] = np.tensordot(share / share.sum(), known, axes=1)
    terms = None
    if numbers is not None:
        terms = np.full((len(rules), outputs.shape[1]), -1, dtype=np.int64)
        terms[position] = numbers[samples, columns]
    return _Learned(rules, firing, values, terms, full_samples)


def _squared_distances(cells: Integers, cell: Integers, scale: Array) -> Array:
    return np.asarray((((cells - cell) / scale) ** 2).sum(axis=1))


def _check_support(learned: _Learned, names: Sequence[str], words: Sequence[Sequence[str]]) -> None:
    weakest = int(np.argmin(learned.best_firing))
    firing = float(learned.best_firing[weakest])
    if firing < LEAST_FIRING:
        clauses = (f"{name} is {of_input[k]}" for name, of_input, k in zip(names, words, learned.rules[weakest], strict=True))
        raise UnsupportedRule(weakest + 1, " and ".join(clauses), firing, LEAST_FIRING, int((learned.best_firing < LEAST_FIRING).sum()))


def _all_cells(shape: Sequence[int]) -> Integers:
    """Return the grid's cells (R, p), the last input fastest."""
    return np.array(list(itertools.product(*map(range, shape))), dtype=np.int64)


def _firing_blocks(grades: list[Array], combine: Callable[..., Array], rules: Integers | None = None) -> Iterator[tuple[slice, Array]]:
    """Yield blocks of samples with their firing strengths (n, R) of the rules, by default of :func:`_all_cells`."""
    count, size = len(grades[0]), math.prod(of_input.shape[1] for of_input in grades) if rules is None else len(rules)
    step = max(1, _BLOCK // size)
    for start in range(0, count, step):
        rows = slice(start, min(start + step, count))
        if rules is not None:
            yield rows, _reduced(combine, [of_input[rows][:, asked] for of_input, asked in zip(grades, rules.T, strict=True)])
            continue
        firing = grades[0][rows]
        for of_input in grades[1:]:
            firing = combine(firing[:, :, np.newaxis], of_input[rows, np.newaxis, :]).reshape(len(firing), -1)
        yield rows, firing


def _reduced(combine: Callable[..., Array], arrays: list[Array]) -> Array:
    result = arrays[0]
    for array in arrays[1:]:
        result = combine(result, array)
    return result


def _principal_terms(least: float, greatest: float, n_terms: int) -> tuple[Gaussian, ...]:
    return _principal([gaussian_partition(least, greatest, n_terms, "t1")])[0]


def _principal(inputs: Sequence[tuple[Term, ...]]) -> list[tuple[Gaussian, ...]]:
    """Return the same terms, which are type-1 Gaussians, as what they are."""
    return [tuple(term for term in terms if isinstance(term, Gaussian)) for terms in inputs]


def _grades_in(x: Array, terms: Sequence[Gaussian]) -> Array:
    """Return the memberships (N, K) of points (N,)."""
    return np.stack([term.membership(x) for term in terms], axis=1)


def _centroid(term: Term) -> tuple[float, float]:
    assert not isinstance(term, GaussianType2Set)
    if isinstance(term, Gaussian) or term.mean[0] == term.mean[1]:
        # The centroid of a Gaussian is its mean; quadrature would put rounding in its place.
        mean = term.mean if isinstance(term, Gaussian) else term.mean[0]
        return mean, mean
    return term.centroid()


def _whole(name: str, value: object, least: int) -> int:
    if isinstance(value, bool | np.bool_) or not isinstance(value, int | np.integer) or value < least:
        raise InvalidValue(name, value, f"a whole number of at least {least}")
    return int(value)


def _terms_per_input(n_terms: int | Sequence[int], count: int) -> list[int]:
    if np.ndim(n_terms) == 0:
        return [_whole("n_terms", n_terms, 1)] * count
    numbers = [_whole("n_terms", number, 1) for number in np.asarray(n_terms).ravel()]
    if len(numbers) != count:
        raise InvalidValue("n_terms", n_terms, f"one whole number, or one for each of the {count} inputs")
    return numbers


def _ranges(what: str, names: Sequence[str], columns: Array) -> list[tuple[float, float]]:
    """Return the range of every column; refuse one that has none."""
    least, greatest = columns.min(axis=0), columns.max(axis=0)
    for name, low, high in zip(names, least, greatest, strict=True):
        if not low < high:
            remedy = "leave it out" if what == "input" else "learn it without output terms"
            raise InvalidValue(f"{what} {name}", low, f"different in at least two samples, since its terms partition its range; {remedy}")
    return [(float(low), float(high)) for low, high in zip(least, greatest, strict=True)]


def _table(name: str, values: Any) -> Array:
    """Return samples as a table of finite floats, or say what is wrong with them."""
    if hasattr(values, "toarray") and hasattr(values, "nnz"):
        raise NotNumbers(name, "it is a sparse matrix; pass a dense array, such as its toarray()")
    array = np.asarray(values)
    if array.dtype.kind == "c":
        raise InvalidValue(name, array.dtype, "real: Complex data not supported")
    if array.dtype.kind not in "fiub":
        try:
            array = array.astype(np.float64)
        except TypeError as error:
            raise NotNumbers(name, str(error)) from error
        except ValueError as error:
            raise InvalidValue(name, array, f"numbers ({error})") from error
    table = np.ascontiguousarray(array, dtype=np.float64)
    if table.ndim != 2:
        raise InvalidValue(name, table.shape, "of shape (n, p), a row for each sample. Reshape your data: a single sample is (1, p)")
    if 0 in table.shape:
        empty = "sample" if table.shape[0] == 0 else "feature"
        raise InvalidValue(name, f"0 {empty}(s) (shape={table.shape}) while a minimum of 1 is required.", "a table that is not empty")
    if not np.isfinite(table).all():
        row, column = (int(index) for index in np.argwhere(~np.isfinite(table))[0])
        raise InvalidValue(f"{name}[{row}, {column}]", float(table[row, column]), "finite, not NaN or infinity")
    return table


def _outputs(y: Any, count: int) -> tuple[Array, bool]:
    """Return the outputs as a table (N, m), and whether they were one column without a second dimension."""
    if y is None:
        raise InvalidValue("y", None, "the outputs of the samples: WangMendel requires y to be passed, but the target y is None")
    one_column = np.asarray(y).ndim == 1
    table = _table("y", np.asarray(y)[:, np.newaxis] if one_column else y)
    if len(table) != count:
        raise InvalidValue("y", table.shape, f"of {count} rows, one for each sample of X")
    return table, one_column


def _column_names(table: Any) -> list[str] | None:
    """Return the names of a data frame's columns, if all of them are strings."""
    columns = getattr(table, "columns", None)
    if columns is None:
        return None
    names = list(columns)
    return names if names and all(isinstance(name, str) for name in names) else None


def _same(value: Any, default: Any) -> bool:
    return type(value) is type(default) and bool(np.all(value == default))


def _not_fitted(name: str) -> NotFitted:
    """Return the error for an estimator without a system, which is scikit-learn's as well where that is imported."""
    exceptions: Any = sys.modules.get("sklearn.exceptions")
    if exceptions is None:
        return NotFitted(name)

    class NotFittedForScikitLearn(NotFitted, exceptions.NotFittedError):  # type: ignore[misc] # a base that is known at run time only
        """Both this package's error and scikit-learn's."""

        def __reduce__(self) -> tuple[type[NotFitted], tuple[str]]:
            return NotFitted, (self.estimator,)

    NotFittedForScikitLearn.__name__ = NotFittedForScikitLearn.__qualname__ = NotFitted.__name__
    return NotFittedForScikitLearn(name)
