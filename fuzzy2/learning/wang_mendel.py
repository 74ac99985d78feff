r"""Learning of rule bases from samples: table look-up (Wang and Mendel) and three variants.

It learns type-1, interval type-2 and general type-2 systems.

Every input's range is partitioned into Gaussian terms, and each cell of the grid of terms is a
rule. Alternatively, clusters of the samples are the rules, and their projections on the inputs are
the terms. The consequents are learned from the samples. Means of type-2 terms are uncertain on both
sides by a share of the range; see :mod:`fuzzy2.learning.noise` for a suitable share. Rules are
chosen by the memberships in the *principal* terms, which have their means in the middle. So systems
of all three kinds that are learned from the same samples have the same rules and differ only in
their uncertainty. Without uncertainty they are equal.

:class:`WangMendel` follows scikit-learn's conventions but does not need scikit-learn.

Source: L.-X. Wang and J. M. Mendel, "Generating fuzzy rules by learning from examples", IEEE
Transactions on Systems, Man, and Cybernetics 22(6), 1992.
"""

from __future__ import annotations

import dataclasses
import math
import warnings
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import CompletedRules, InvalidValue
from fuzzy2.learning.clustering import Clusters, checked_fuzzifier, fuzzy_c_means
from fuzzy2.learning.consequents import (
    COMPLETIONS,
    LEAST_FIRING,
    Learned,
    Quantizer,
    check_support,
    rules_from_all,
    strict_rules,
)
from fuzzy2.learning.estimator import Regressor
from fuzzy2.learning.partition import (
    KINDS,
    Integers,
    Term,
    cluster_partition,
    gaussian_partition,
    gaussian_terms,
    grades_in,
    principal_terms,
    term_names,
    terms_per_input,
)
from fuzzy2.learning.samples import Samples, ranges_of, samples_of
from fuzzy2.sets.shapes import Gaussian
from fuzzy2.support.checks import Array, generator, known_name, positive, real, whole_number
from fuzzy2.systems.general_type2 import REDUCTIONS, GeneralType2System
from fuzzy2.systems.system import FuzzySystem, IntervalType2System, Type1System

LEARNERS = ("strongest", "strict", "average", "ridge")
"""Names of the learners of consequents, see :class:`WangMendel`."""

PARTITIONS = ("grid", "clusters")
"""Names of the sources of terms and rules, see :class:`WangMendel`."""

MOST_RULES = 2**20
"""Greatest number of rules of a grid."""

MOST_RIDGE_RULES = 2**13
"""Greatest number of rules of a grid for the ridge learner; the matrix of its least-squares problem
then takes half a gigabyte."""


class WangMendel(Regressor):
    r"""Learner of fuzzy rules from samples, which follows scikit-learn's conventions.

    The rules are the cells of the grid of all inputs' terms, or clusters of the samples.
    ``learner`` chooses how the consequent of a rule is learned:

    - ``"strongest"``, the default: the output of the sample that fires the rule most (the first of
      several), so no cell stays empty.
    - ``"strict"``: the table look-up as Wang and Mendel published it. Every sample makes one rule
      from the terms in which its inputs (and its output) have the greatest membership. The degree
      of the rule is the t-norm of these memberships, and among rules for the same cell the one with
      the highest degree is kept. Cells without a rule are completed according to ``completion``.
    - ``"average"``: the average of the outputs of all samples, weighted with their firing of the
      rule.
    - ``"ridge"``: the consequents c that minimize
      :math:`\frac{1}{N} \sum_n \lVert y_n - \sum_r \phi_{nr} c_r \rVert^2
      + \lambda \sum_r \lVert c_r - \bar c_r \rVert^2`,
      where :math:`\phi` are the firing strengths of the type-1 system divided by their sum and
      :math:`\bar c` the averages. They follow from least squares where samples determine them, and
      stay near the averages elsewhere.

    Firing here means that of the principal (type-1) terms.

    Parameters
    ----------
    n_terms : int or sequence of p ints
        Number of Gaussian terms of every input. If terms come from clusters, one number for all
        inputs, which is also the number of rules.
    kind : {"it2", "t1", "gt2"}
        Kind of system: interval type-2, type-1, or general type-2.
    mean_variation : float
        Uncertainty of the terms' means on either side, as a share of each input's range; 0 makes
        type-1 terms. See :func:`fuzzy2.learning.noise.mean_variation_from_snr`. Ignored by
        ``kind="t1"``.
    learner : {"strongest", "strict", "average", "ridge"}
        How consequents are learned.
    completion : {"nearest", "average", "none", "refuse"}
        How empty cells are handled. For the strict learner a cell is empty if no sample makes a
        rule for it, and for the others if no sample fires it by more than 0.001. ``"nearest"``
        takes the rule of the nearest cell. Distances are those between the cells' centers, in
        shares of the inputs' ranges, and the highest degree or firing decides between equally near
        cells. ``"average"`` averages all rules with the inverse squares of their distances as
        weights, ``"none"`` leaves the cells without a rule, and ``"refuse"`` raises
        :class:`fuzzy2.errors.UnsupportedRule`.
    ridge : float or None
        Weight :math:`\lambda` of the ridge learner, above 0. With None, generalized
        cross-validation chooses it separately for every output
        (:mod:`fuzzy2.learning.cross_validation`); it is nearly 0 if samples have no noise.
    output_terms : int or None
        With None, consequents are values. With a number K, every output's range is partitioned into
        K Gaussian terms with the same mean variation. The consequent is then the term with the
        nearest mean, which enters the system as its centroid (an interval for "it2" and "gt2",
        whose output terms are both interval type-2).
    t_norm : {"product", "min"}
        T-norm that combines the memberships of a rule's antecedents.
    reduction : {"alpha_planes", "gaussian"}
        Type reduction of ``kind="gt2"``, see
        :class:`fuzzy2.systems.general_type2.GeneralType2System`.
    levels : int
        Number of α-planes of ``kind="gt2"``.
    partition : {"grid", "clusters"}
        Source of terms and rules. ``"grid"`` spaces the terms evenly over the range of the samples,
        see :func:`gaussian_partition`, and makes a rule of every combination of them.
        ``"clusters"`` runs fuzzy c-means first: each of ``n_terms`` clusters of the inputs is a
        rule, and its projections are the terms (:func:`cluster_partition`). Then many inputs need
        no more rules than few, and there are only rules where there are samples. Inputs are scaled
        by their ranges for the clustering. The strict learner does not support clusters.
    fuzzifier : float
        Fuzzifier of the clusters, see :func:`fuzzy2.fuzzy_c_means`.
    rng : numpy.random.Generator, optional
        Source of the clustering's starts; by default it is seeded with 0 at every call of
        :meth:`fit`.

    Attributes
    ----------
    system_ : Type1System, IntervalType2System or GeneralType2System
        The learned system.
    n_features_in_, n_outputs_ : int
        Numbers of inputs and outputs.
    feature_names_in_ : (p,) ndarray of str
        Names of the columns, if the samples were a table with names; they are also the names of the
        system's inputs.
    best_firing_ : (R,) ndarray
        Greatest firing of each rule by a sample, before completion.
    rule_samples_ : (R, m) ndarray of int
        Number of the sample that determines a rule's consequent; -1 if it is not a single sample.
        For "strongest" and "strict".
    output_terms_ : tuple of m tuples of sets
        Terms of the outputs, if ``output_terms`` is a number.
    output_rules_ : (R, m) ndarray of int
        Number of the output term of every rule, or -1 if completion averaged rules; only if
        ``output_terms`` is a number.
    clusters_ : Clusters
        Result of fuzzy c-means, in shares of the inputs' ranges, if the rules are clusters.
    """

    # A few samples with ten inputs, as in scikit-learn's check, do not fill a grid, so a score for
    # them is meaningless. The tag tells scikit-learn not to require a good one.
    _poor_score = True
    _learned = ("rule_samples_", "output_terms_", "output_rules_", "clusters_")

    best_firing_: Array
    rule_samples_: Integers
    output_terms_: tuple[tuple[Term, ...], ...]
    output_rules_: Integers
    clusters_: Clusters

    def __init__(  # noqa: PLR0913 (public: an estimator names each parameter here)
        self,
        n_terms: int | Sequence[int] = 2,
        kind: str = "it2",
        mean_variation: float = 0.1,
        learner: str = "strongest",
        completion: str = "nearest",
        ridge: float | None = 1e-3,
        output_terms: int | None = None,
        t_norm: str = "product",
        reduction: str = "alpha_planes",
        levels: int = 5,
        partition: str = "grid",
        fuzzifier: float = 2.0,
        rng: np.random.Generator | None = None,
    ) -> None:
        # Parameters are stored as given and checked by fit, so that a grid search can set them in
        # any order.
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

    def fit(self, X: ArrayLike, y: ArrayLike, sample_weight: ArrayLike | None = None) -> Self:
        """Learn the rules from samples.

        Parameters
        ----------
        X : (N, p) array_like
            Inputs, with N of at least 2.
        y : (N,) or (N, m) array_like
            Outputs.
        sample_weight : (N,) array_like, optional
            Weight of each sample, 1 by default. Where a single sample determines a rule
            (``"strongest"`` and ``"strict"``), only the weight 0 has an effect.

        Returns
        -------
        WangMendel
            The estimator itself, with :attr:`system_`.

        Raises
        ------
        InvalidValue, NotNumbers
            If samples or parameters are invalid. The message names an input (or an output with
            terms) that has the same value in all samples.
        UnknownName
            If ``kind``, ``learner``, ``completion``, ``t_norm``, ``reduction`` or ``partition`` is
            unknown.
        UnsupportedRule
            If no sample fires some rule by more than 0.001 and ``completion`` is ``"refuse"``, or
            if no rule at all is fired that much.

        Warns
        -----
        CompletedRules
            If rules of the grid were completed or left out. The strict learner does not warn,
            because that is expected of it.
        """
        self._check_parameters()
        samples = samples_of(type(self).__name__, X, y, sample_weight)
        ranges = ranges_of("input", samples.input_names, samples.inputs)
        partition = (
            self._partition_by_clusters(samples.inputs, ranges, samples.weights)
            if self.partition == "clusters"
            else self._partition_evenly(ranges)
        )
        grades = [
            grades_in(column, terms)
            for column, terms in zip(samples.inputs.T, partition.principal, strict=True)
        ]
        quantizer = None
        if self.output_terms is not None:
            kind = "t1" if self.kind == "t1" else "it2"
            output_ranges = ranges_of("output", samples.output_names, samples.outputs)
            quantizer = Quantizer(output_ranges, self.output_terms, kind, self.mean_variation)
        words = [term_names(len(of_input)) for of_input in partition.terms]
        learned = self._rules(grades, samples, partition.rules, quantizer, words)

        options: dict[str, Any] = {
            "input_names": samples.input_names,
            "output_names": samples.output_names,
            "term_names": words,
        }
        system = self._system_of(
            partition.terms, learned.rules, learned.consequents(quantizer), options
        )

        self._remember(samples)
        self.system_ = system
        self.best_firing_ = learned.best_firing
        if learned.samples is not None:
            # Numbers refer to all given samples.
            known = np.append(samples.numbers, -1)
            self.rule_samples_ = known[learned.samples]
        if quantizer is not None and learned.terms is not None:
            self.output_terms_, self.output_rules_ = quantizer.terms, learned.terms
        if partition.clusters is not None:
            self.clusters_ = partition.clusters
        return self

    def _rules(
        self,
        grades: list[Array],
        samples: Samples,
        given: Integers | None,
        quantizer: Quantizer | None,
        words: Sequence[Sequence[str]],
    ) -> Learned:
        combine: Callable[..., Array] = np.multiply if self.t_norm == "product" else np.minimum
        if self.learner == "strict":
            learned = strict_rules(grades, samples.outputs, combine, quantizer, self.completion)
            if self.completion == "refuse":
                check_support(learned, samples.input_names, words)
            return learned
        # Every cluster has its samples, and there is no grid in which it could have neighbors.
        completion = self.completion if given is None else "refuse"
        learned = rules_from_all(
            grades,
            samples.outputs,
            combine,
            given,
            self.learner,
            self.ridge,
            completion,
            samples.weights,
        )
        total = len(learned.rules)
        if given is None and completion == "none":
            total = math.prod(of_input.shape[1] for of_input in grades)
        silent = learned.best_firing < LEAST_FIRING
        count = total - int((~silent).sum())
        if given is not None:
            pass  # every cluster has samples, even if all firing strengths are small
        elif completion == "refuse" or silent.all():
            check_support(learned, samples.input_names, words)
        elif count:
            warnings.warn(CompletedRules(count, total, completion), stacklevel=3)
        if quantizer is not None:
            learned = learned._replace(values=None, terms=quantizer.nearest(learned.point_values()))
        return learned

    def _system_of(
        self, terms: Any, rules: Integers, consequents: Array, options: dict[str, Any]
    ) -> FuzzySystem:
        if self.kind == "t1":
            return Type1System(terms, rules, consequents, self.t_norm, **options)
        if self.kind == "it2":
            return IntervalType2System(terms, rules, consequents, self.t_norm, **options)
        options |= {"reduction": self.reduction, "levels": self.levels}
        return GeneralType2System(terms, rules, consequents, self.t_norm, **options)

    def _partition_evenly(self, ranges: list[tuple[float, float]]) -> _Partition:
        numbers = terms_per_input(self.n_terms, len(ranges))
        self._check_size(math.prod(numbers))
        terms = [
            gaussian_partition(*ends, number, self.kind, self.mean_variation)
            for ends, number in zip(ranges, numbers, strict=True)
        ]
        # All kinds must get bitwise equal numbers, so that ties between equal grades are resolved
        # in the same way.
        principal = [
            principal_terms(*ends, number) for ends, number in zip(ranges, numbers, strict=True)
        ]
        return _Partition(terms, principal, None, None)

    def _partition_by_clusters(
        self, inputs: Array, ranges: list[tuple[float, float]], weights: Array
    ) -> _Partition:
        if self.learner == "strict":
            raise InvalidValue(
                "learner",
                self.learner,
                "another one with partition='clusters', where every rule is a cluster's",
            )
        number = whole_number("n_terms", self.n_terms, 1)
        self._check_size(number)
        least, greatest = np.array(ranges).T
        widths = greatest - least
        scaled = (inputs - least) / widths
        clusters = fuzzy_c_means(scaled, number, self.fuzzifier, self.rng, sample_weight=weights)
        placed = dataclasses.replace(
            clusters, centers=least + widths * clusters.centers, spreads=widths * clusters.spreads
        )
        terms, rules = cluster_partition(placed, widths, self.kind, self.mean_variation)
        principal, _ = cluster_partition(placed, widths, "t1")
        return _Partition(terms, gaussian_terms(principal), rules, clusters)

    def _check_parameters(self) -> None:
        choices = (
            ("kind of system", self.kind, KINDS),
            ("learner", self.learner, LEARNERS),
            ("completion", self.completion, COMPLETIONS),
            ("partition", self.partition, PARTITIONS),
            ("t-norm of a rule base that is learned", self.t_norm, ("product", "min")),
        )
        for what, name, known in choices:
            known_name(what, name, known)
        if self.ridge is not None:
            positive("ridge", self.ridge)
        if real("mean_variation", self.mean_variation) < 0.0:
            raise InvalidValue("mean_variation", self.mean_variation, "at least 0")
        if self.output_terms is not None:
            whole_number("output_terms", self.output_terms, 2)
        # Parameters that only other kinds or partitions use are checked, too, so that a mistake is
        # reported at once.
        known_name("reduction", self.reduction, REDUCTIONS)
        whole_number("levels", self.levels, 1)
        checked_fuzzifier(self.fuzzifier)
        if self.rng is not None:
            generator("rng", self.rng)

    def _check_size(self, rules: int) -> None:
        if self.learner == "strict" and self.completion in ("none", "refuse"):
            return
        most = MOST_RIDGE_RULES if self.learner == "ridge" else MOST_RULES
        if rules > most:
            remedy = (
                "or use partition='clusters', or learner='strict' with completion='none', which "
                "have rules where samples are"
            )
            raise InvalidValue(
                "n_terms",
                self.n_terms,
                f"so few that there are at most {most:,} rules, not {rules:,}; {remedy}",
            )


class _Partition(NamedTuple):
    """Terms of every input, rules and clusters.

    The terms are the principal ones. ``rules`` (R, p) is None if they are all combinations, and
    ``clusters`` is None if there are none.
    """

    terms: Sequence[tuple[Term, ...]]
    principal: Sequence[tuple[Gaussian, ...]]
    rules: Integers | None
    clusters: Clusters | None
