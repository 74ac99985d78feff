r"""Systems whose rules depend on the density of data clouds: AnYa by Angelov and Yager.

IEEE Std 1855-2016 defines a rule base for them. Instead of a membership function, a rule has a
cloud, which is a set of data of one input. The rule fires by the density of its cloud around the
input, relative to the densities of the other rules.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import InvalidValue, NotApplicable, ReadOnly
from fuzzy2.support.checks import Array, reals, whole_number
from fuzzy2.support.checks import listed as checked_list
from fuzzy2.support.markup import Markup, joined
from fuzzy2.support.pieces import flat_pieces
from fuzzy2.support.shown import Shown
from fuzzy2.systems.antecedents import Is
from fuzzy2.systems.construction import checked_names
from fuzzy2.systems.explainable import Explainable
from fuzzy2.systems.explanation import Explanation
from fuzzy2.systems.gradients import analytic_gradient, central_differences
from fuzzy2.systems.named_inputs import by_name, like_inputs
from fuzzy2.systems.pictures import listed, titled
from fuzzy2.systems.system import FuzzySystem
from fuzzy2.systems.words import rules_in_words

STEP = 1e-3
"""Step of differences, relative to a cloud's range plus 1, the scale of the densities."""


@dataclass(frozen=True, repr=False)
class CloudExplanation(Explanation):
    """Explanation of an output of an AnYa system; its picture shows the inner system.

    Parameters
    ----------
    inference : Explanation
        The explanation of the inner system, whose inputs are the relative densities.
    """

    inference: Explanation

    @property
    def pictured(self) -> Explanation:
        """The explanation that is drawn."""
        return self.inference


class AnYaSystem(Shown):
    r"""System of rules whose antecedents are clouds of data.

    The density of the cloud :math:`d_1, \dots, d_m` around its input x, and the firing of
    antecedent i, which uses cloud c(i), are

    .. math::

        \gamma = \frac{m}{m + \sum_k |d_k - x|}, \qquad
        \lambda_i = \frac{\gamma_{c(i)}}{\sum_j \gamma_{c(j)}}

    Parameters
    ----------
    clouds : sequence of sequence of float
        Data of each input; each cloud needs at least one number.
    asked : sequence of R int
        Number of the cloud of each antecedent.
    consequents : FuzzySystem
        The inner system, whose inputs are the R firings. Each input has one term whose grade is the
        firing itself, ``Trapezoidal(0.0, 1.0, inf, inf)``. The rules use this term, or its
        complement for *else*.
    input_names : sequence of str, optional
        Names of the inputs; ``"x1"``, ``"x2"``, … by default.

    Raises
    ------
    InvalidValue
        If a cloud is empty or not finite, or if numbers of inputs, clouds and firings do not match.

    References
    ----------
    P. Angelov and R. Yager, *Simplified fuzzy rule-based systems using non-parametric antecedents
    and relative data density*, IEEE Workshop on Evolving and Adaptive Intelligent Systems, 2011.
    """

    def __init__(
        self,
        clouds: Sequence[ArrayLike],
        asked: Sequence[int],
        consequents: FuzzySystem,
        input_names: Sequence[str] | None = None,
    ) -> None:
        self.clouds = tuple(
            np.array(reals("clouds", cloud))
            for cloud in checked_list("clouds", clouds, "a list of the data of each input")
        )
        for cloud in self.clouds:
            if cloud.ndim != 1 or not cloud.size or not np.isfinite(cloud).all():
                raise InvalidValue("clouds", cloud, "finite numbers, at least one in each cloud")
            cloud.flags.writeable = False
        numbers = f"numbers of the {len(self.clouds)} clouds"
        self.asked = tuple(
            whole_number("asked", one, 0) for one in checked_list("asked", asked, numbers)
        )
        if not all(one < len(self.clouds) for one in self.asked):
            raise InvalidValue("asked", asked, numbers)
        if not isinstance(consequents, FuzzySystem) or len(consequents.inputs) != len(self.asked):
            raise InvalidValue(
                "consequents", consequents, f"a system of {len(self.asked)} inputs, the firings"
            )
        self.consequents = consequents
        sizes = [cloud.size for cloud in self.clouds]
        self._data = np.concatenate(self.clouds)
        self._starts = np.cumsum([0, *sizes])
        self._cloud_of = np.array(self.asked, dtype=np.int64)
        self._named = input_names is not None
        self.input_names = checked_names("input_names", input_names, len(self.clouds), "x")

    def __setattr__(self, name: str, value: Any) -> None:
        if name in self.__dict__:
            raise ReadOnly("an AnYaSystem", name)
        object.__setattr__(self, name, value)

    @property
    def output_names(self) -> tuple[str, ...]:
        """Names of the outputs."""
        return tuple(self.consequents.output_names)

    def __repr__(self) -> str:
        return f"AnYaSystem({len(self.clouds)} clouds, {self.consequents!r})"

    def relative_densities(self, X: Any) -> Array:
        """Return the firing of the antecedents; the values of all antecedents add up to 1.

        Parameters
        ----------
        X : (..., p) array_like, mapping or data frame
            Inputs, one for each cloud.

        Returns
        -------
        (..., R) ndarray
            Relative densities.

        Raises
        ------
        InvalidValue
            If the inputs are not finite or have a wrong shape.
        """
        from fuzzy2.systems.anya_kernels import relative_densities

        x = self._checked(X)
        rows = np.require(x, np.float64, ["C", "W"])
        out = np.empty((*x.shape[:-1], len(self.asked)))
        inputs, found = rows.reshape(-1, x.shape[-1]), out.reshape(-1, len(self.asked))
        clouds = self._data, self._starts, self._cloud_of
        for given, densities in flat_pieces(inputs, found):
            if relative_densities(*clouds, given, densities) >= 0:
                raise InvalidValue("X", x, "finite")
        return out

    def _checked(self, X: Any) -> Array:
        """Return the inputs (..., p), given as an array or by name."""
        x = reals("X", by_name(X, self.input_names, self._named))
        if x.shape[-1:] != (len(self.clouds),):
            raise InvalidValue("X", x.shape, f"of shape (..., {len(self.clouds)})")
        return x

    def __call__(self, X: Any = None, /, **named: ArrayLike) -> Array:
        """Return the crisp outputs (..., m) of inputs (..., p), or of inputs by name.

        Parameters
        ----------
        X : (..., p) array_like, mapping or data frame
            Inputs.
        **named
            Inputs as keyword arguments instead of ``X``.

        Returns
        -------
        (..., m) ndarray
            Outputs. For a DataFrame or Series of pandas, the same type is returned, see
            :class:`fuzzy2.FuzzySystem`.

        Raises
        ------
        InvalidValue
            If the inputs are not finite or have a wrong shape.
        """
        if named and X is not None:
            raise InvalidValue("X", X, "left out where inputs are given by name")
        given = named if X is None and named else X
        crisp = self.consequents(self.relative_densities(given))
        outputs: Array = like_inputs(crisp, given, self.output_names)
        return outputs

    def type_reduced(self, X: ArrayLike) -> Array:
        """Return the type-reduced intervals (..., m, 2); see :meth:`FuzzySystem.type_reduced`.

        Parameters
        ----------
        X : (..., p) array_like, mapping or data frame
            Inputs.

        Raises
        ------
        InvalidValue
            If the inputs are not finite or have a wrong shape.
        """
        return self.consequents.type_reduced(self.relative_densities(X))

    def firing(self, X: ArrayLike) -> Array:
        """Return the firing intervals (..., R, 2) of the rules of the inner system.

        Parameters
        ----------
        X : (..., p) array_like, mapping or data frame
            Inputs.

        Raises
        ------
        InvalidValue
            If the inputs are not finite or have a wrong shape.
        """
        return self.consequents.firing(self.relative_densities(X))

    def gradient(self, X: ArrayLike) -> Array:
        r"""Return the derivatives of the crisp outputs with respect to the inputs.

        They follow from the chain rule, with :math:`\delta_{ij} = 1` where antecedent i uses cloud
        j and 0 elsewhere,

        .. math::

            \frac{\partial \lambda_i}{\partial x_j}
            = \lambda_i \left(\delta_{ij} - \sum_k \lambda_k \delta_{kj}\right)
            \frac{\partial \ln \gamma_j}{\partial x_j}, \qquad
            \frac{\partial \ln \gamma_j}{\partial x_j}
            = - \frac{\sum_k \operatorname{sign}(x_j - d_k)}{m + \sum_k |x_j - d_k|}

        if the inner system has an analytic derivative (:meth:`FuzzySystem.gradient`), and from
        sixth-order differences otherwise. A density has a kink at each datum, where the formula
        gives the right-hand derivative.

        Parameters
        ----------
        X : (..., p) array_like, mapping or data frame
            Inputs.

        Returns
        -------
        (..., m, p) ndarray
            Derivatives; NaN where no rule fires.

        Raises
        ------
        InvalidValue
            If the inputs are not finite or have a wrong shape.
        """
        x = self._checked(X)
        rows = x.reshape(-1, len(self.clouds))
        firing = self.relative_densities(rows)
        try:
            found = analytic_gradient(self.consequents, firing) @ self._slopes(rows, firing)
        except NotApplicable:
            steps = STEP * np.array([1.0 + np.ptp(cloud) for cloud in self.clouds])
            found = central_differences(self, rows, steps)
        return np.asarray(found.reshape(*x.shape[:-1], len(self.output_names), len(self.clouds)))

    def _slopes(self, rows: Array, firing: Array) -> Array:
        """Return the derivatives (n, R, p) of relative densities (n, R)."""
        slopes = np.empty_like(rows)
        for j, cloud in enumerate(self.clouds):
            apart = rows[:, j, np.newaxis] - cloud
            side = np.where(apart >= 0.0, 1.0, -1.0).mean(axis=-1)
            slopes[:, j] = -side / (1.0 + np.abs(apart).mean(axis=-1))
        asks = self._cloud_of[:, np.newaxis] == np.arange(len(self.clouds))
        own = asks - (firing @ asks)[:, np.newaxis]
        return np.asarray(firing[..., np.newaxis] * own * slopes[:, np.newaxis])

    def explain(self, x: ArrayLike) -> CloudExplanation:
        """Return an explanation of the output at one input: the rules that decided it.

        Parameters
        ----------
        x : (p,) array_like, or mapping
            One input.

        Returns
        -------
        CloudExplanation
            See :meth:`FuzzySystem.explain`. An antecedent reads "input is dense" for the cloud of
            that input.

        Raises
        ------
        InvalidValue
            If the input is not finite, has a wrong shape, or is not a single input.
        """
        row = self._checked(x)
        if row.ndim != 1:
            raise InvalidValue("x", row.shape[:-1], "one input: a row of numbers, or one by name")
        inner = self.consequents.explain(self.relative_densities(row))
        return CloudExplanation(
            # Only names are taken from this object; the picture is that of the inner system.
            cast(Explainable, self),
            np.array(row),
            inner.outputs,
            inner.reduced,
            inner.firing,
            inner.shares,
            tuple(self.rules_in_words()),
            inner,
        )

    def rules_in_words(self) -> list[str]:
        """Return the text of each rule, ``IF food is dense THEN tip is Low``."""
        return rules_in_words(self.consequents, asks=self._asks)

    def _asks(self, leaf: Is) -> Is:
        name = self.input_names[self.asked[int(leaf.variable)]]
        return Is(name, None if leaf.term is None else "dense")

    def _repr_html_(self) -> Markup:
        return joined([titled(self), listed(self.rules_in_words())])
