r"""Online adaptation of consequents: bounded recursive least squares with forgetting.

At an input x the crisp output of a system is linear in its consequents, with the fuzzy basis
functions as coefficients,

.. math:: y(x) = \tfrac12 \sum_r \left(\phi^l_r(x)\, c^l_r + \phi^r_r(x)\, c^r_r\right), \qquad
          \phi_r = \frac{w_r}{\sum_s w_s},

where w are the weights at which the left or the right end of the type-reduced interval is attained:
upper firing strengths up to the switch point and lower ones after it, or the reverse. For a type-1
system they are the firing strengths. So recursive least squares can correct the consequents with
one sample after another. For each output they minimize

.. math:: \sum_{n=1}^{N} \lambda^{N-n} \left(y_n - \phi_n^T c\right)^2
          + \kappa\, \lVert c - c_0 \rVert^2,

Old samples fade with the forgetting factor :math:`\lambda`, and the trained consequents :math:`c_0`
keep their weight :math:`\kappa`. Without that weight, exponential forgetting would lose the
consequents of rules that do not fire for a while, and their covariance would grow without bound
until the next sample throws them off (wind-up). With it, the covariance never exceeds
:math:`1/\kappa`, and rules that no longer fire return to their trained consequents.

The switch points depend on the consequents. Each sample is used with the switch points at its time,
which makes the problem linear. A type-1 system has no switch points, so its minimum is exact.

Sources: L.-X. Wang and J. M. Mendel, "Fuzzy basis functions, universal approximation, and
orthogonal least-squares learning", IEEE Transactions on Neural Networks 3(5), 1992; J. M. Mendel,
"Computing derivatives in interval type-2 fuzzy logic systems", IEEE Transactions on Fuzzy Systems
12(1), 2004, for the switch points; R. Kulhavý and M. B. Zarrop, "On a general concept of
forgetting", International Journal of Control 58(4), 1993, for forgetting toward a prior that stays.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.support.checks import Array, finite_rows, of_kind, positive, real, reals
from fuzzy2.support.described import Described
from fuzzy2.support.pieces import pieces
from fuzzy2.systems.system import FuzzySystem, IntervalType2System, Type1System


class AdaptiveConsequents(Described):
    r"""A fuzzy system whose consequents adapt to incoming samples.

    Parameters
    ----------
    system : Type1System or IntervalType2System
        The trained system, with center of sets, a named t-norm, Gaussian, triangular or trapezoidal
        terms, and consequents that are numbers or intervals. It is not changed.
    forgetting : float
        Forgetting factor :math:`\lambda`, in (0, 1]: a sample has half its weight after :math:`\log
        2 / (1 - \lambda)` others.
    trust : float
        Weight :math:`\kappa` of the trained consequents, above 0. They weigh as much as
        :math:`\kappa` samples that each fire a single rule.
    bounds : pair of array_like, optional
        Least and greatest consequents. Their shapes broadcast to that of the system's consequents,
        (R, m) or (R, m, 2). The minimum is then taken within these bounds. There are no bounds by
        default.

    Raises
    ------
    NotApplicable
        If the output of the system does not have the form above, or the compiled loop cannot
        compute it.
    InvalidValue
        If an argument is outside its range, or the trained consequents are outside the bounds.
    """

    def __init__(
        self,
        system: FuzzySystem,
        forgetting: float = 0.99,
        trust: float = 1.0,
        bounds: tuple[ArrayLike, ArrayLike] | None = None,
    ) -> None:
        self.forgetting, self.trust = real("forgetting", forgetting), positive("trust", trust)
        if not 0.0 < self.forgetting <= 1.0:
            raise InvalidValue("forgetting", forgetting, "above 0 and at most 1")
        of_kind("system", system, FuzzySystem, "a fuzzy system")
        self._given, self._table = system, _adaptable_table(system)
        given = np.asarray(system.consequents, dtype=float)
        self._is_interval = given.ndim == 3
        self._trained = _by_output(given)
        self._prior = np.full(len(system.rules) * (2 if self._is_interval else 1), self.trust)
        self._lower, self._upper = self._checked_bounds(bounds, given.shape)
        self.reset()

    def _facts(self) -> dict[str, Any]:
        return {
            "system": repr(self._given),
            "forgetting": self.forgetting,
            "trust": self.trust,
        }

    def _checked_bounds(self, bounds: Any, shape: tuple[int, ...]) -> tuple[Array, Array]:
        if bounds is None:
            shape_of_all = (len(self._trained), self._prior.size)
            return np.full(shape_of_all, -np.inf), np.full(shape_of_all, np.inf)
        try:
            least, greatest = (np.broadcast_to(reals("bounds", ends), shape) for ends in bounds)
        except (TypeError, ValueError) as error:
            raise InvalidValue(
                "bounds",
                bounds,
                f"two arrays that broadcast to {shape}, least and greatest consequents",
            ) from error
        if not ((least <= self._given.consequents) & (self._given.consequents <= greatest)).all():
            raise InvalidValue("bounds", bounds, "around the trained consequents")
        return self._flat(_by_output(least) - self._trained), self._flat(
            _by_output(greatest) - self._trained
        )

    def _flat(self, ends: Array) -> Array:
        """Return numbers (m, 2, R) as parameters (m, n)."""
        return np.ascontiguousarray(
            ends.reshape(len(ends), -1) if self._is_interval else ends[:, 0]
        )

    def reset(self) -> None:
        """Return to the trained consequents, and forget all samples."""
        outputs, _, rules = self._trained.shape
        size = self._prior.size
        self._information, self._right, self._moved = (
            np.zeros((outputs, size, size)),
            np.zeros((outputs, size)),
            np.zeros((outputs, size)),
        )
        self._consequents = self._trained.copy()
        self._orders = np.tile(np.arange(rules, dtype=np.int64), (outputs, 2, 1))

    def update(self, X: ArrayLike, y: ArrayLike) -> Array:
        """Learn from one sample, or from several samples in order.

        Parameters
        ----------
        X : (..., p) array_like, mapping or data frame
            Inputs. Named columns are matched with the system's inputs, as in ``system(X)``.
        y : (..., m) array_like, mapping or data frame
            Measured outputs. Several named columns are matched with the names of the outputs.

        Returns
        -------
        (..., m) ndarray
            Error of the system at each sample before it learned from the sample. Where firing
            strengths underflow, their ratios follow from logarithms, as in the system. NaN where no
            rule fires, beyond the ends of bounded terms; such a sample does not affect any rule and
            is skipped.

        Raises
        ------
        InvalidValue
            If there is no sample, or inputs or outputs are not finite or have a wrong shape. None
            of the samples has then been used.
        """
        from fuzzy2.learning import adaptation_kernels

        inputs, shape = _rows("X", self._given._ordered_inputs(X), len(self._given.inputs))
        outputs, other = _rows("y", self._given._ordered_outputs(y), self._given.n_outputs)
        if shape != other:
            wanted = f"of shape {(*shape, self._given.n_outputs)}, one row for each of X"
            raise InvalidValue("y", (*other, self._given.n_outputs), wanted)
        if not len(inputs):
            raise InvalidValue("X", (*shape, len(self._given.inputs)), "at least one sample")
        errors = np.empty_like(outputs)
        for part in pieces(len(inputs)):
            adaptation_kernels.learn(
                self._table,
                inputs[part],
                outputs[part],
                self._trained,
                self._lower,
                self._upper,
                self._prior,
                self.forgetting,
                self._information,
                self._right,
                self._moved,
                self._consequents,
                self._orders,
                errors[part],
            )
        return errors.reshape(*shape, self._given.n_outputs)

    def __call__(self, X: ArrayLike) -> Array:
        """Return the crisp outputs (..., m) at inputs (..., p), as :attr:`system` does.

        The current consequents are used.

        Raises
        ------
        InvalidValue
            If the inputs are not finite or have a wrong shape.
        """
        from fuzzy2.learning import adaptation_kernels

        inputs, shape = _rows("X", self._given._ordered_inputs(X), len(self._given.inputs))
        out = np.empty((len(inputs), self._given.n_outputs))
        table, consequents, orders = self._table, self._consequents, self._orders.copy()
        for part in pieces(len(inputs)):
            adaptation_kernels.evaluate(table, inputs[part], consequents, orders, out[part])
        return out.reshape(*shape, self._given.n_outputs)

    @property
    def consequents(self) -> Array:
        """Current consequents, (R, m) or (R, m, 2) like the trained ones."""
        ends = np.moveaxis(self._consequents, -1, 0)
        return ends.copy() if self._is_interval else ends[..., 0].copy()

    @property
    def covariance(self) -> Array:
        r"""Covariance of each output's consequents, (m, n, n), at most :math:`1/\kappa`.

        Its unit is the variance of the output's samples.

        n is R, or 2 R for intervals (left ends, then right ends). The covariance is the inverse of
        the matrix of the least-squares problem.
        """
        upper = np.triu(self._information)
        whole = upper + np.swapaxes(np.triu(self._information, 1), -1, -2) + np.diag(self._prior)
        return np.asarray(np.linalg.inv(whole))

    @property
    def system(self) -> FuzzySystem:
        """A new system with the current consequents; everything else is as trained."""
        return self._given.replace(consequents=self.consequents)


def _rows(name: str, array: Array, width: int) -> tuple[Array, tuple[int, ...]]:
    """Return finite values (..., width) as rows, and their leading shape."""
    finite_rows(name, array, array.shape[-1:] == (width,), f"(..., {width})")
    # Arrays are made writable, because numba would compile every loop again for read-only ones.
    rows: Array = np.require(array, np.float64, ["C", "W"]).reshape(-1, width)
    return rows, array.shape[:-1]


def _by_output(consequents: Array) -> Array:
    """Return consequents (R, m) or (R, m, 2) as (m, 2, R), left and right ends."""
    ends = np.stack([consequents, consequents], axis=-1) if consequents.ndim == 2 else consequents
    return np.array(np.moveaxis(ends, 0, -1), dtype=np.float64, order="C")


def _adaptable_table(system: FuzzySystem) -> Array:
    """Return the system as the compiled loops take it.

    Raise an error that says why its consequents cannot be adapted.
    """
    what = "adaptation of consequents"
    if not isinstance(system, Type1System | IntervalType2System):
        raise NotApplicable(what, f"it takes a type-1 or an interval type-2 system, not {system!r}")
    if system.type_reduction != "center_of_sets" or not isinstance(system.consequents, np.ndarray):
        raise NotApplicable(
            what,
            "it needs center of sets, and consequents that are numbers or intervals; of sets "
            "take their centroids",
        )
    if system.silent is not None or system.default_outputs is not None:
        raise NotApplicable(what, "each rule needs a consequent for every output, without defaults")
    if system.table is None:
        raise NotApplicable(
            what,
            "it needs a t-norm that has a name, singleton fuzzifiers, and Gaussian, triangular or "
            "trapezoidal terms",
        )
    return system.table
