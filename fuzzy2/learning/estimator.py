"""Common base of the estimators, which follow scikit-learn's conventions without importing it."""

from __future__ import annotations

import inspect
import sys
import warnings
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fuzzy2.errors import FeatureNamesWarning, InvalidValue, NotFitted, UnknownName, WrongFeatures
from fuzzy2.learning.samples import (
    Samples,
    column_names,
    table_of_outputs,
    table_of_samples,
    weights_of,
)
from fuzzy2.support.checks import Array, binary_exponent, reals
from fuzzy2.support.markup import Markup, element, joined
from fuzzy2.support.shown import Shown
from fuzzy2.systems.explanation import Explanation
from fuzzy2.systems.general_type2 import GeneralType2System
from fuzzy2.systems.pictures import titled
from fuzzy2.systems.system import FuzzySystem


class Estimator(Shown):
    """Parameters by name, and inputs that are checked against those of ``fit``.

    A subclass stores its parameters as given, and ``fit`` makes a system.
    """

    _learned: ClassVar[tuple[str, ...]] = ()
    """Attributes that only some calls of :meth:`fit` set."""

    system_: FuzzySystem
    n_features_in_: int
    n_outputs_: int
    _one_column: bool
    feature_names_in_: NDArray[np.object_]

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
            Ignored, because no parameter is an estimator.

        Returns
        -------
        dict
            Parameters as given.
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
        Self
            The estimator itself.

        Raises
        ------
        UnknownName
            If there is no such parameter; none is set then.
        """
        known = self.get_params()
        for name in parameters:
            if name not in known:
                raise UnknownName(f"parameter of {type(self).__name__}", name, tuple(known))
        for name, value in parameters.items():
            setattr(self, name, value)
        return self

    def __sklearn_is_fitted__(self) -> bool:
        """Tell scikit-learn whether there is a system."""
        return hasattr(self, "system_")

    def _remember(self, samples: Samples) -> None:
        """Forget the last fit, and store the properties of the new samples."""
        for name in ("feature_names_in_", *self._learned):
            self.__dict__.pop(name, None)
        self.n_features_in_, self.n_outputs_ = samples.inputs.shape[1], samples.outputs.shape[1]
        self._one_column = samples.one_column
        if samples.named:
            self.feature_names_in_ = np.array(samples.input_names, dtype=object)

    def _system(self) -> FuzzySystem:
        if not hasattr(self, "system_"):
            raise _not_fitted(type(self).__name__)
        return self.system_

    def explain(self, x: ArrayLike) -> Explanation:
        """Return an explanation of a prediction: the rules that decided it.

        Parameters
        ----------
        x : (p,) or (1, p) array_like
            One input.

        Returns
        -------
        Explanation
            See :meth:`fuzzy2.FuzzySystem.explain`. The outputs of a classifier are the grades of
            the classes.

        Raises
        ------
        NotFitted, InvalidValue, NotNumbers, WrongFeatures
            See :meth:`predict`; also if there is more than one input.
        """
        system = self._system()
        if hasattr(x, "to_frame") and np.ndim(x) == 1:
            x = x.to_frame().T  # a row of a data frame keeps its names
        values = x if column_names(x) is not None else reals("x", x)
        rows = self._inputs(values if np.ndim(values) == 2 else np.asarray(values)[np.newaxis])
        if len(rows) != 1:
            raise InvalidValue("x", rows.shape, "one input")
        return system.explain(rows[0])

    def _repr_html_(self) -> Markup:
        fitted = hasattr(self, "system_")
        shown = self.system_._repr_html_() if fitted else element("p", "not fitted yet")
        return joined([titled(self), shown])

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


class Regressor(Estimator):
    """Estimator that predicts numbers, the outputs of the learned system."""

    _poor_score: ClassVar[bool] = False
    """Tag for scikit-learn: whether few samples with many inputs lead to a poor score."""

    def predict(self, X: ArrayLike) -> Array:
        """Return the crisp outputs of the system.

        Parameters
        ----------
        X : (n, p) array_like
            Inputs.

        Returns
        -------
        (n,) or (n, m) ndarray
            Outputs with as many dimensions as those of :meth:`fit`; NaN where no rule fires. It is
            an array even if ``X`` is a data frame, as for all estimators of scikit-learn;
            ``system_(X)`` returns a data frame.

        Raises
        ------
        NotFitted
            If there is no system yet. The error is also scikit-learn's ``NotFittedError`` if
            scikit-learn is imported.
        InvalidValue, NotNumbers, WrongFeatures
            If the inputs are not finite numbers, or not those of :meth:`fit`.
        """
        values = self._system()(self._inputs(X))
        return values[:, 0] if self._one_column else values

    def predict_interval(self, X: ArrayLike) -> Array:
        """Return the type-reduced intervals of the system.

        They show the effect of the terms' uncertainty on the output. They are not confidence
        intervals: their coverage probability is not known.

        Parameters
        ----------
        X : (n, p) array_like
            Inputs.

        Returns
        -------
        (n, 2) or (n, m, 2) ndarray
            Left and right ends; NaN where no rule fires. For ``kind="gt2"`` they are those of the
            lowest α-plane, or with ``reduction="gaussian"`` two standard deviations on both sides
            of the mean.

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

    def score(self, X: ArrayLike, y: ArrayLike, sample_weight: ArrayLike | None = None) -> float:
        r"""Return the coefficient of determination.

        It is :math:`R^2 = 1 - \sum_n (y_n - \hat y_n)^2 / \sum_n (y_n - \bar y)^2`.

        Parameters
        ----------
        X : (n, p) array_like
            Inputs.
        y : (n,) or (n, m) array_like
            True outputs.
        sample_weight : (n,) array_like, optional
            Weight of each sample, 1 by default.

        Returns
        -------
        float
            The score, at most 1, averaged over the outputs. A constant output scores 1 if it is
            predicted exactly and 0 otherwise. NaN if no rule fires at some input.

        Raises
        ------
        NotFitted, InvalidValue, NotNumbers, WrongFeatures
            See :meth:`predict`; also if ``y`` does not have as many outputs as in :meth:`fit`.
        """
        predicted = self._system()(self._inputs(X))
        truth, _ = table_of_outputs(y, len(predicted))
        if truth.shape != predicted.shape:
            raise InvalidValue("y", truth.shape, f"of {predicted.shape[1]} outputs, as in fit")
        weights = weights_of(sample_weight, len(predicted))
        # The score has no unit, so the values can be scaled before they are squared.
        exponent = binary_exponent(np.stack([truth, predicted]))
        truth, predicted = np.ldexp(truth, -exponent), np.ldexp(predicted, -exponent)
        residual = weights @ (truth - predicted) ** 2
        total = weights @ (truth - weights @ truth / weights.sum()) ** 2
        with np.errstate(divide="ignore", invalid="ignore"):
            determination = np.where(
                total > 0.0, 1.0 - residual / total, np.where(residual == 0.0, 1.0, 0.0)
            )
        return float(np.where(np.isnan(residual), np.nan, determination).mean())

    def __sklearn_tags__(self) -> Any:
        """Return scikit-learn's description of the estimator.

        Only scikit-learn calls it.
        """
        from sklearn.utils import InputTags, RegressorTags, Tags, TargetTags

        return Tags(
            estimator_type="regressor",
            target_tags=TargetTags(required=True, multi_output=True),
            regressor_tags=RegressorTags(poor_score=self._poor_score),
            input_tags=InputTags(),
        )


def _same(value: Any, default: Any) -> bool:
    return type(value) is type(default) and bool(np.all(value == default))


def _not_fitted(name: str) -> NotFitted:
    """Return the error for an estimator without a system.

    It is also scikit-learn's error if scikit-learn is imported.
    """
    exceptions: Any = sys.modules.get("sklearn.exceptions")
    if exceptions is None:
        return NotFitted(name)

    # a base class that is only known at run time
    class NotFittedForScikitLearn(NotFitted, exceptions.NotFittedError):  # type: ignore[misc]
        """Both this package's error and scikit-learn's."""

        def __reduce__(self) -> tuple[type[NotFitted], tuple[str]]:
            return NotFitted, (self.estimator,)

    NotFittedForScikitLearn.__name__ = NotFittedForScikitLearn.__qualname__ = NotFitted.__name__
    return NotFittedForScikitLearn(name)
