r"""Learning a rule base from samples: table look-up (Wang and Mendel), and three learners like it.

For type-1, interval and general type-2 systems.

Every input's range is partitioned by Gaussian terms, and each cell of the grid of terms is a rule;
or clusters of the samples are the rules, and their projections on the inputs the terms. What the
rules say is read from the samples. Means of type-2 terms are uncertain to both sides by a share of
the range, see :mod:`fuzzy2.learning.noise` for how much; rules are chosen by the memberships in the
*principal* terms, with the mean in its middle, so that systems of all three kinds learned from the
same samples have the same rules and differ in nothing but their uncertainty. Without uncertainty
they are the same system.

:class:`WangMendel` follows scikit-learn's conventions and does not need it.

Source: L.-X. Wang and J. M. Mendel, "Generating fuzzy rules by learning from examples", IEEE
Transactions on Systems, Man, and Cybernetics 22(6), 1992.
"""

from __future__ import annotations

import dataclasses
import inspect
import math
import sys
import warnings
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fuzzy2.errors import FeatureNamesWarning, InvalidValue, NotFitted, UnknownName, WrongFeatures
from fuzzy2.learning.clustering import Clusters, fuzzy_c_means
from fuzzy2.learning.consequents import (
    COMPLETIONS,
    Quantizer,
    check_support,
    rules_from_all,
    strict_rules,
)
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
    whole_number,
)
from fuzzy2.learning.samples import column_names, ranges_of, table_of_outputs, table_of_samples
from fuzzy2.sets.shapes import Gaussian
from fuzzy2.support.checks import Array, positive, real
from fuzzy2.systems.general_type2 import GeneralType2System
from fuzzy2.systems.system import FuzzySystem, IntervalType2System, Type1System

LEARNERS = ("strongest", "strict", "average", "ridge")
"""Names of the ways to the rules' consequents, see :class:`WangMendel`."""

PARTITIONS = ("grid", "clusters")
"""Names of where terms and rules come from, see :class:`WangMendel`."""

MOST_RULES = 2**20
"""Rules of the largest grid that is filled."""

MOST_RIDGE_RULES = 2**13
"""Rules of the largest grid whose least-squares problem is solved: its matrix takes half a
gigabyte.
"""


class WangMendel:
    r"""Learning of fuzzy rules from samples, with scikit-learn's conventions.

    The rules are the cells of the grid of all inputs' terms, or clusters of the samples.
    ``learner`` says what a rule's consequent is:

    - ``"strongest"``, this package's default: that of the sample that fires the rule most (the
      first of several), so that no cell stays empty.
    - ``"strict"``: the table look-up of Wang and Mendel as published. Every sample makes one rule,
      of the terms in which its inputs (and output) have most membership; its degree is the t-norm
      of these memberships; of rules for the same cell the one of the highest degree stays. Cells
      without a rule are completed as ``completion`` says.
    - ``"average"``: the average of all samples, weighted with how strongly they fire the rule.
    - ``"ridge"``: the consequents c that minimize
      :math:`\frac{1}{N} \sum_n \lVert y_n - \sum_r \phi_{nr} c_r \rVert^2
      + \lambda \sum_r \lVert c_r - \bar c_r \rVert^2`,
      with :math:`\phi` the firing strengths of the type-1 system over their sum and :math:`\bar c`
      the averages: least squares where the samples say something, the average where they do not.

    Firing here is that of the principal (type-1) terms.

    Parameters
    ----------
    n_terms : int or sequence of p ints
        Number of Gaussian terms of every input; one number for all of them if terms come from
        clusters, which is that of the rules, too.
    kind : {"it2", "t1", "gt2"}
        Kind of system: interval type-2, type-1, or general type-2.
    mean_variation : float
        Uncertainty of the terms' means, to either side, as a share of each input's range; 0 is
        type-1. See :func:`fuzzy2.learning.noise.mean_variation_from_snr`. Not used by
        ``kind="t1"``.
    learner : {"strongest", "strict", "average", "ridge"}
        How consequents are found.
    completion : {"nearest", "average", "none"}
        What the strict learner does about empty cells: takes the rule of the nearest cell
        (distances between cells are those of their centers, in shares of the inputs' ranges; the
        highest degree decides between equally near ones), averages all rules with the inverse
        squares of their distances as weights, or leaves the cells without a rule.
    ridge : float
        Weight :math:`\lambda` of the ridge learner, above 0.
    output_terms : int or None
        None: consequents are values. A number K: every output's range is partitioned by K Gaussian
        terms of the same mean variation, a consequent is the term whose mean is nearest, and enters
        the system as that term's centroid (an interval for "it2" and "gt2", whose output terms are
        both interval type-2).
    t_norm : {"product", "min"}
        How the memberships of a rule's antecedents are combined.
    reduction : {"alpha_planes", "gaussian"}
        Type reduction of ``kind="gt2"``, see
        :class:`fuzzy2.systems.general_type2.GeneralType2System`.
    levels : int
        Number of α-planes of ``kind="gt2"``.
    partition : {"grid", "clusters"}
        Where terms and rules come from. On the grid the terms lie evenly over the range of the
        samples, see :func:`gaussian_partition`, and every combination of them is a rule. With
        clusters, fuzzy c-means comes first: each of ``n_terms`` clusters of the inputs is a rule,
        and its projections are its terms (:func:`cluster_partition`). Many inputs then need no more
        rules than few, and there are rules only where samples are. Inputs count in shares of their
        ranges; not for the strict learner.
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
        Names of the columns, if the samples were a table with names; then they name the system's
        inputs, too.
    best_firing_ : (R,) ndarray
        Greatest firing of each rule by a sample, before completion.
    rule_samples_ : (R, m) ndarray of int
        Sample from which a rule has its consequent; -1 where it is no single sample's. For
        "strongest" and "strict".
    output_terms_ : tuple of m tuples of sets
        Terms of the outputs, if ``output_terms`` is a number.
    output_rules_ : (R, m) ndarray of int
        Number of the output term of every rule, -1 where completion averaged, if ``output_terms``
        is a number.
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

    def __init__(  # noqa: PLR0913 (public: an estimator names each parameter here)
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
        changed = (
            f"{name}={value!r}"
            for name, value in self.get_params().items()
            if not _same(value, defaults[name].default)
        )
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
        names = sorted(
            name for name in inspect.signature(type(self).__init__).parameters if name != "self"
        )
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
            If samples or parameters are not what they must be; an input (or output, if it has
            terms) that has the same value in all samples is named.
        UnknownName
            If ``kind``, ``learner``, ``completion``, ``t_norm``, ``reduction`` or ``partition`` is
            unknown.
        UnsupportedRule
            If no sample fires some rule by more than 0.001; the strict learner needs no such
            sample.
        """
        self._check_parameters()
        names = column_names(X)
        inputs = table_of_samples("X", X)
        if inputs.shape[0] < 2:
            raise InvalidValue(
                "X",
                f"{inputs.shape[0]} sample",
                "a table of at least 2 samples, which span a range",
            )
        outputs, one_column = table_of_outputs(y, len(inputs))
        count = inputs.shape[1]
        input_names = (
            tuple(names) if names is not None else tuple(f"x{i + 1}" for i in range(count))
        )
        ranges = ranges_of("input", input_names, inputs)
        output_names = column_names(y)
        if output_names is None or len(output_names) != outputs.shape[1]:
            output_names = [f"y{j + 1}" for j in range(outputs.shape[1])]

        partition = (
            self._partition_by_clusters(inputs, ranges)
            if self.partition == "clusters"
            else self._partition_evenly(ranges)
        )
        terms, principal, rules, clusters = partition
        grades = [grades_in(inputs[:, i], principal[i]) for i in range(count)]
        words = [term_names(len(of_input)) for of_input in terms]
        combine: Callable[..., Array] = np.multiply if self.t_norm == "product" else np.minimum

        quantizer = None
        if self.output_terms is not None:
            kind = "t1" if self.kind == "t1" else "it2"
            output_ranges = ranges_of("output", output_names, outputs)
            quantizer = Quantizer(output_ranges, self.output_terms, kind, self.mean_variation)
        if self.learner == "strict":
            learned = strict_rules(grades, outputs, combine, quantizer, self.completion)
        else:
            learned = rules_from_all(grades, outputs, combine, rules, self.learner, self.ridge)
            check_support(learned, input_names, words)
            if quantizer is not None:
                learned = learned._replace(
                    values=None, terms=quantizer.nearest(learned.point_values())
                )
        consequents = learned.consequents(quantizer)

        options: dict[str, Any] = {
            "input_names": input_names,
            "output_names": tuple(output_names),
            "term_names": words,
        }
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
        terms = [
            gaussian_partition(*ends, number, self.kind, self.mean_variation)
            for ends, number in zip(ranges, numbers, strict=True)
        ]
        # Of all kinds the same numbers to the last digit, so that equal grades are settled in the
        # same way.
        principal = [
            principal_terms(*ends, number) for ends, number in zip(ranges, numbers, strict=True)
        ]
        return _Partition(terms, principal, None, None)

    def _partition_by_clusters(
        self, inputs: Array, ranges: list[tuple[float, float]]
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
        clusters = fuzzy_c_means((inputs - least) / widths, number, self.fuzzifier, self.rng)
        placed = dataclasses.replace(
            clusters, centers=least + widths * clusters.centers, spreads=widths * clusters.spreads
        )
        terms, rules = cluster_partition(placed, widths, self.kind, self.mean_variation)
        principal, _ = cluster_partition(placed, widths, "t1")
        return _Partition(terms, gaussian_terms(principal), rules, clusters)

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
            If there is no system yet; scikit-learn's ``NotFittedError`` as well, if that is
            imported.
        InvalidValue, NotNumbers, WrongFeatures
            If the inputs are not finite numbers, or not those of :meth:`fit`.
        """
        values = self._system()(self._inputs(X))
        return values[:, 0] if self._one_column else values

    def predict_interval(self, X: ArrayLike) -> Array:
        """Return the type-reduced intervals of the system.

        They show what the uncertainty of the terms does to the output. They are no confidence
        intervals: how often they cover the truth is not known.

        Parameters
        ----------
        X : (n, p) array_like
            Inputs.

        Returns
        -------
        (n, 2) or (n, m, 2) ndarray
            Left and right ends, NaN where no rule fires. Of ``kind="gt2"`` those of the lowest
            α-plane, or two standard deviations to both sides of the mean under
            ``reduction="gaussian"``.

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
        r"""Return the coefficient of determination.

        It is :math:`R^2 = 1 - \sum_n (y_n - \hat y_n)^2 / \sum_n (y_n - \bar y)^2`.

        Parameters
        ----------
        X : (n, p) array_like
            Inputs.
        y : (n,) or (n, m) array_like
            True outputs.

        Returns
        -------
        float
            At most 1; the plain average over the outputs. An output that is constant counts 1 if it
            is met exactly and else 0. NaN if no rule fires at some input.

        Raises
        ------
        NotFitted, InvalidValue, NotNumbers, WrongFeatures
            See :meth:`predict`; also if ``y`` has not as many outputs as in :meth:`fit`.
        """
        predicted = self._system()(self._inputs(X))
        truth, _ = table_of_outputs(y, len(predicted))
        if truth.shape != predicted.shape:
            raise InvalidValue("y", truth.shape, f"of {predicted.shape[1]} outputs, as in fit")
        residual = ((truth - predicted) ** 2).sum(axis=0)
        total = ((truth - truth.mean(axis=0)) ** 2).sum(axis=0)
        with np.errstate(divide="ignore", invalid="ignore"):
            determination = np.where(
                total > 0.0, 1.0 - residual / total, np.where(residual == 0.0, 1.0, 0.0)
            )
        return float(np.where(np.isnan(residual), np.nan, determination).mean())

    def __sklearn_is_fitted__(self) -> bool:
        """Tell scikit-learn whether there is a system."""
        return hasattr(self, "system_")

    def __sklearn_tags__(self) -> Any:
        """Return scikit-learn's description of the estimator.

        Only scikit-learn itself asks for it.
        """
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
            whole_number("output_terms", self.output_terms, 2)

    def _check_size(self, rules: int) -> None:
        if self.learner == "strict" and self.completion == "none":
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

    def _forget(self) -> None:
        for name in (
            "feature_names_in_",
            "rule_samples_",
            "output_terms_",
            "output_rules_",
            "clusters_",
        ):
            self.__dict__.pop(name, None)

    def _system(self) -> FuzzySystem:
        if not hasattr(self, "system_"):
            raise _not_fitted(type(self).__name__)
        return self.system_

    def _inputs(self, X: ArrayLike) -> Array:
        names, known = column_names(X), getattr(self, "feature_names_in_", None)
        if names is not None and known is not None and list(known) != names:
            raise WrongFeatures(
                type(self).__name__, self.n_features_in_, len(names), tuple(known), tuple(names)
            )
        if (names is None) != (known is None):
            warnings.warn(FeatureNamesWarning(type(self).__name__, known is not None), stacklevel=3)
        inputs = table_of_samples("X", X)
        if inputs.shape[1] != self.n_features_in_:
            raise WrongFeatures(type(self).__name__, self.n_features_in_, inputs.shape[1])
        return inputs


class _Partition(NamedTuple):
    """Terms of every input, rules and clusters.

    Terms are the principal ones. Rules (R, p) are there where they are not all combinations, and
    clusters where there are some.
    """

    terms: Sequence[tuple[Term, ...]]
    principal: Sequence[tuple[Gaussian, ...]]
    rules: Integers | None
    clusters: Clusters | None


def _terms_per_input(n_terms: int | Sequence[int], count: int) -> list[int]:
    if np.ndim(n_terms) == 0:
        return [whole_number("n_terms", n_terms, 1)] * count
    numbers = [whole_number("n_terms", number, 1) for number in np.asarray(n_terms).ravel()]
    if len(numbers) != count:
        raise InvalidValue(
            "n_terms", n_terms, f"one whole number, or one for each of the {count} inputs"
        )
    return numbers


def _same(value: Any, default: Any) -> bool:
    return type(value) is type(default) and bool(np.all(value == default))


def _not_fitted(name: str) -> NotFitted:
    """Return the error for an estimator without a system.

    It is scikit-learn's as well where that is imported.
    """
    exceptions: Any = sys.modules.get("sklearn.exceptions")
    if exceptions is None:
        return NotFitted(name)

    # a base that is known at run time only
    class NotFittedForScikitLearn(NotFitted, exceptions.NotFittedError):  # type: ignore[misc]
        """Both this package's error and scikit-learn's."""

        def __reduce__(self) -> tuple[type[NotFitted], tuple[str]]:
            return NotFitted, (self.estimator,)

    NotFittedForScikitLearn.__name__ = NotFittedForScikitLearn.__qualname__ = NotFitted.__name__
    return NotFittedForScikitLearn(name)
