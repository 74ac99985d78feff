r"""A classifier with few fuzzy rules, each of which has a grade for every class.

A rule gives a grade for each class: *IF petal length is low and petal width is low THEN setosa
0.98, versicolor 0.01, virginica 0.01*. The probability of class k is the average of the rules'
grades, weighted with their firing,

.. math:: P(k \mid x) = \sum_r \phi_r(x)\, g_{rk}, \qquad \sum_k g_{rk} = 1,

which is the output of a Takagi–Sugeno–Kang system of order zero. The initial rules are clusters of
each class's samples. Then L-BFGS maximizes the likelihood of the samples over means, standard
deviations and grades.
"""

from __future__ import annotations

import sys
import warnings
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fuzzy2.errors import InvalidValue
from fuzzy2.learning.clustering import fuzzy_c_means
from fuzzy2.learning.estimator import Estimator
from fuzzy2.learning.premises import Premises
from fuzzy2.learning.samples import (
    LEAST_RANGE,
    Samples,
    ranges_of,
    samples_of,
    table_of_samples,
    weights_of,
)
from fuzzy2.sets.shapes import Gaussian
from fuzzy2.support.checks import Array, generator, positive, whole_number
from fuzzy2.systems.system import Type1System

FIRST_GRADE = 2.0
"""Initial logarithm of the ratio between the grades of a rule's own class and another class."""
NARROWEST = 0.2
"""Least initial standard deviation of a term, relative to that of its input."""
LEAST_DOUBT = 1e-12
"""Lower bound of the probability of a sample's class, so that no outlier has an infinite error."""
TELLING = 0.5
"""A rule names an input if some sample's grade there is below this."""

WORDS = ("very low", "low", "medium", "high", "very high")
_LIMITS = (-1.5, -0.5, 0.5, 1.5)  # in standard deviations from the mean


class FuzzyClassifier(Estimator):
    r"""Classifier with readable fuzzy rules, which follows scikit-learn's conventions.

    Parameters
    ----------
    n_rules : int
        Number of initial rules of each class; fewer if a class has fewer different samples.
    ridge : float
        Weight, above 0, of the squared distances of all parameters from their initial values,
        relative to the log-likelihood of the samples. Means are measured in standard deviations of
        the inputs; standard deviations and grades by their logarithms. The more samples there are,
        the less it matters.
    most_epochs : int
        Greatest number of iterations.
    rng : numpy.random.Generator, optional
        Source of the clustering's starts; by default it is seeded with 0 at every call of
        :meth:`fit`.

    Attributes
    ----------
    classes_ : (K,) ndarray
        Labels of the classes.
    system_ : Type1System
        The rules; its outputs are the classes' probabilities.
    grades_ : (R, K) ndarray
        Grade of every rule for every class.
    n_features_in_ : int
        Number of inputs.
    feature_names_in_ : (p,) ndarray of str
        Names of the columns, if the samples were a table with names.
    n_iter_ : int
        Number of iterations.
    """

    classes_: NDArray[Any]
    grades_: Array
    n_iter_: int

    def __init__(
        self,
        n_rules: int = 2,
        ridge: float = 16.0,
        most_epochs: int = 100,
        rng: np.random.Generator | None = None,
    ) -> None:
        # Parameters are stored as given and checked by fit, so that a grid search can set them in
        # any order.
        self.n_rules = n_rules
        self.ridge = ridge
        self.most_epochs = most_epochs
        self.rng = rng

    def fit(self, X: ArrayLike, y: ArrayLike, sample_weight: ArrayLike | None = None) -> Self:
        """Learn rules from samples with known classes.

        Parameters
        ----------
        X : (N, p) array_like
            Inputs.
        y : (N,) array_like
            Labels: whole numbers, text or the like, of at least two classes.
        sample_weight : (N,) array_like, optional
            Weight of each sample, 1 by default.

        Returns
        -------
        FuzzyClassifier
            The estimator itself.

        Raises
        ------
        InvalidValue, NotNumbers
            If samples or parameters are invalid. The message names an input that has the same value
            in all samples.
        """
        number = whole_number("n_rules", self.n_rules, 1)
        positive("ridge", self.ridge)
        whole_number("most_epochs", self.most_epochs, 0)
        table_of_samples("X", X)
        labels = _labels(y)
        # Labels are checked after samples of weight 0 are removed, because a class without any
        # remaining sample does not exist.
        counts = weights_of(sample_weight, len(labels))
        if len(labels) != len(np.asarray(X)):
            raise InvalidValue("y", labels.shape, "a label for each sample of X")
        classes, codes = np.unique(labels[counts > 0.0], return_inverse=True)
        if len(classes) < 2:
            raise InvalidValue("y", classes, "of more than one class")
        every = np.zeros(len(labels))
        every[counts > 0.0] = codes
        samples = samples_of(type(self).__name__, X, every, counts)
        ranges_of("input", samples.input_names, samples.inputs)
        rng = np.random.default_rng(0) if self.rng is None else generator("rng", self.rng)

        middles = np.average(samples.inputs, axis=0, weights=samples.weights)
        squares = (samples.inputs - middles) ** 2
        widths = np.sqrt(np.average(squares, axis=0, weights=samples.weights))
        scaled = (samples.inputs - middles) / widths
        problem = _Likelihood(scaled, codes, samples.weights, number, self.ridge, rng)
        best, iterations = problem.solved(self.most_epochs)

        self._remember(samples)
        self.classes_, self.n_iter_ = classes, iterations
        self._premises, self._parameters = problem.premises, best[: problem.first_grade]
        self._units = middles, widths
        self.grades_ = problem.grades(best)
        self.system_ = self._system_of(samples)
        self._spoken = self._telling(scaled)
        return self

    def predict_proba(self, X: ArrayLike) -> Array:
        """Return the probabilities of the classes, (n, K), for inputs (n, p).

        Raises
        ------
        InvalidValue
            If an input is so far away that its square overflows.
        """
        self._system()
        with np.errstate(over="ignore"):
            inputs = (self._inputs(X) - self._units[0]) / self._units[1]
        if not (np.abs(inputs) < 1.0 / LEAST_RANGE).all():
            wanted = f"within {1.0 / LEAST_RANGE:.0e} standard deviations of what was learned from"
            raise InvalidValue("X", X, wanted)
        grades = self._premises.grades(self._parameters, inputs)
        return np.asarray(self._premises.ends(grades, None)[0].shares @ self.grades_)

    def predict(self, X: ArrayLike) -> NDArray[Any]:
        """Return the most likely labels, (n,), for inputs (n, p)."""
        likely = self.predict_proba(X).argmax(axis=1)
        return np.asarray(self.classes_[likely])

    def score(self, X: ArrayLike, y: ArrayLike, sample_weight: ArrayLike | None = None) -> float:
        """Return the share of samples whose class is predicted correctly."""
        predicted, truth = self.predict(X), _labels(y)
        if truth.shape != predicted.shape:
            raise InvalidValue("y", truth.shape, "a label for each sample of X")
        return float(np.average(predicted == truth, weights=weights_of(sample_weight, len(truth))))

    def rules_in_words(self) -> list[str]:
        """Return the rules as text, with one line per rule.

        A rule only names the inputs that matter to it, for which some sample of ``fit`` has a grade
        below one half.
        """
        system = self._system()
        lines = []
        for asked, grades, spoken in zip(system.rules, self.grades_, self._spoken, strict=True):
            clauses = [
                f"{name} is {names[t].partition(' #')[0]}"
                for name, names, t, said in zip(
                    system.input_names, system.term_names, asked, spoken, strict=True
                )
                if said
            ]
            order = np.argsort(-grades, kind="stable")
            classes = ", ".join(f"{self.classes_[k]} {grades[k]:.2f}" for k in order)
            lines.append(f"IF {' and '.join(clauses) or 'anything'} THEN {classes}")
        return lines

    def __sklearn_tags__(self) -> Any:
        """Return scikit-learn's description of the estimator.

        Only scikit-learn calls it.
        """
        from sklearn.utils import ClassifierTags, InputTags, Tags, TargetTags

        return Tags(
            estimator_type="classifier",
            target_tags=TargetTags(required=True),
            classifier_tags=ClassifierTags(),
            input_tags=InputTags(),
        )

    def _system_of(self, samples: Samples) -> Type1System:
        count = len(self._premises.owners)
        middles, widths = (unit[self._premises.owners] for unit in self._units)
        scaled = self._parameters[:count]
        means, sigmas = middles + widths * scaled, widths * np.exp(self._parameters[count:])
        terms, names, position = [], [], np.empty(count, dtype=np.int64)
        for i in range(samples.inputs.shape[1]):
            own = np.flatnonzero(self._premises.owners == i)
            own = own[np.argsort(means[own], kind="stable")]
            position[own] = np.arange(len(own))
            terms.append([Gaussian(float(means[t]), float(sigmas[t])) for t in own])
            words = [WORDS[int(np.searchsorted(_LIMITS, scaled[t]))] for t in own]
            names.append([f"{word} #{t + 1}" for t, word in enumerate(words)])
        return Type1System(
            terms,
            position[self._premises.rules],
            self.grades_,
            input_names=samples.input_names,
            output_names=[str(label) for label in self.classes_],
            term_names=names,
        )

    def _telling(self, scaled: Array) -> NDArray[np.bool_]:
        """Return which inputs matter to each rule, (R, p)."""
        distance = self._premises.grades(self._parameters, scaled).upper
        least = np.exp(-0.5 * (distance**2).max(axis=0))
        return np.asarray(least[self._premises.rules] < TELLING)


class _Likelihood:
    """Mean negative logarithm of the likelihood, with its gradient, as a function of parameters.

    The parameters are means, logarithms of standard deviations, and logarithms of grades that need
    not be normalized.
    """

    def __init__(
        self,
        X: Array,
        codes: NDArray[np.int64],
        weights: Array,
        number: int,
        ridge: float,
        rng: np.random.Generator,
    ) -> None:
        self.X, self.codes, self.ridge = X, codes, ridge / float(weights.sum())
        self.weights = weights / weights.sum()
        self.classes, inputs = int(codes.max()) + 1, X.shape[1]
        centers, spreads, own = [], [], []
        for k in range(self.classes):
            rows, counts = X[codes == k], weights[codes == k]
            clusters = min(number, len(np.unique(rows, axis=0)))
            found = fuzzy_c_means(rows, clusters, rng=rng, sample_weight=counts)
            middle = np.average(rows, axis=0, weights=counts)
            spread = np.sqrt(np.average((rows - middle) ** 2, axis=0, weights=counts))
            centers.append(found.centers)
            spreads += [spread] * clusters
            own += [k] * clusters
        means, rules = np.concatenate(centers), len(own)
        # The more inputs there are, the less a single one should decide.
        sigmas = np.maximum(spreads, NARROWEST) * np.sqrt(max(inputs / 4.0, 1.0))
        self.premises = Premises(
            np.tile(np.arange(inputs), rules),
            np.arange(rules * inputs).reshape(rules, inputs),
            np.zeros(rules * inputs),
        )
        grades = FIRST_GRADE * (np.array(own)[:, np.newaxis] == np.arange(self.classes))
        self.first_grade = 2 * means.size
        self.start = np.concatenate([means.ravel(), np.log(sigmas).ravel(), grades.ravel()])

    def grades(self, parameters: Array) -> Array:
        """Return the grades of the rules for the classes, (R, K)."""
        logarithms = parameters[self.first_grade :].reshape(-1, self.classes)
        powers = np.exp(logarithms - logarithms.max(axis=1, keepdims=True))
        return np.asarray(powers / powers.sum(axis=1, keepdims=True))

    def __call__(self, parameters: Array) -> tuple[float, Array]:
        """Return the objective and its gradient."""
        premises, by_class = self.premises, self.grades(parameters)
        own = parameters[: self.first_grade]
        distances = premises.grades(own, self.X)
        ends = premises.ends(distances, None)
        shares = ends[0].shares
        likely = (shares * by_class[:, self.codes].T).sum(axis=1) + LEAST_DOUBT
        # The consequents depend on the sample: its output is the probability of its own class.
        slopes = premises.slopes(own, distances, ends, by_class[:, self.codes].T)
        share = -self.weights / likely
        by_grade = np.zeros_like(by_class)
        for k in range(self.classes):
            rows = self.codes == k
            by_grade[:, k] = share[rows] @ shares[rows]
        inner = (by_grade * by_class).sum(axis=1, keepdims=True)
        gradient = np.concatenate([share @ slopes, (by_class * (by_grade - inner)).ravel()])
        moved = parameters - self.start
        value = -self.weights @ np.log(likely) + 0.5 * self.ridge * (moved @ moved)
        return float(value), gradient + self.ridge * moved

    def solved(self, most: int) -> tuple[Array, int]:
        """Return the parameters of the smallest objective found, and the number of iterations."""
        from scipy.optimize import minimize

        if most == 0:
            return self.start, 0
        found = minimize(
            self, self.start, jac=True, method="L-BFGS-B", options={"maxiter": int(most)}
        )
        return np.asarray(found.x), int(found.nit)


def _labels(y: Any) -> NDArray[Any]:
    """Return labels of classes (N,); refuse values that cannot be labels."""
    if y is None:
        raise InvalidValue(
            "y",
            None,
            "the labels of the samples: FuzzyClassifier requires y to be passed, but the target y "
            "is None",
        )
    if isinstance(y, np.ma.MaskedArray):
        raise InvalidValue("y", y, "labels without a mask")
    try:
        labels = np.asarray(y)
    except ValueError as error:  # rows of different lengths
        raise InvalidValue("y", y, "of shape (N,), a label for each sample") from error
    if labels.ndim == 2 and labels.shape[1] == 1:
        exceptions: Any = sys.modules.get("sklearn.exceptions")
        kind = UserWarning if exceptions is None else exceptions.DataConversionWarning
        warnings.warn("A column-vector y was passed when a 1d array was expected", kind, 3)
        labels = labels[:, 0]
    if labels.ndim != 1:
        raise InvalidValue("y", labels.shape, "of shape (N,), a label for each sample")
    if labels.dtype.kind == "f" and not (np.isfinite(labels).all() and (labels % 1 == 0.0).all()):
        raise InvalidValue(
            "y", labels, "labels of classes; Unknown label type: continuous numbers are none"
        )
    return labels
