"""General type-2 systems, evaluated by α-planes or by the Gaussian corollary."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import ApproximationWarning, NotApplicable
from fuzzy2.numbers.affine import GaussianNumber
from fuzzy2.operations.t_norms import BinaryFunction, TNorm
from fuzzy2.reduction.approximate import VALIDITY_LIMIT, approximate_generalized_centroid
from fuzzy2.sets.general_type2 import GeneralType2Set
from fuzzy2.sets.interval_type2 import IntervalType2Set
from fuzzy2.sets.type1 import Type1Set
from fuzzy2.support.checks import Array, known_name, whole_number
from fuzzy2.support.pieces import flat_pieces
from fuzzy2.systems.consequents import FunctionsOfInputs
from fuzzy2.systems.fuzzifiers import NonSingletonFuzzifier
from fuzzy2.systems.gradients import Differentiable
from fuzzy2.systems.operators import DIRECT_METHODS
from fuzzy2.systems.rules import Rule
from fuzzy2.systems.system import FuzzySystem, IntervalType2System
from fuzzy2.systems.terms import domain_of, highest_point

REDUCTIONS = ("alpha_planes", "gaussian")
"""How general type-2 outputs are reduced."""


class GeneralType2System(FuzzySystem):
    r"""General type-2 fuzzy logic system, evaluated by α-planes or by the Gaussian corollary.

    The α-planes are reduced exactly; the corollary is the approximation of the thesis.

    If secondary grades are combined by the minimum, the α-plane of a firing set follows from the
    α-planes of its terms. So every α-plane is an interval type-2 system that is reduced exactly,
    and the crisp output is the average of the middles weighted with α. The Gaussian corollary (eq.
    1.107–1.109) treats the firing of the rules as Gaussian numbers instead. Its crisp output is
    that of the type-1 system of the principal memberships, whatever the uncertainty, and only its
    standard deviation adds information.

    Parameters
    ----------
    inputs, rules, consequents, t_norm, type_reduction, method, **options
        See :class:`FuzzySystem`; the sets may be of any type.
    reduction : {"alpha_planes", "gaussian"}
        Evaluation by α-planes or by the Gaussian corollary.
    levels : int
        Number of α-planes, at :math:`\alpha = 1/L, 2/L, \dots, 1`.
    grade_t_norm : {"min", "product"}
        T-norm of the secondary grades. α-planes need the minimum; the Gaussian corollary accepts
        both.

    Raises
    ------
    NotApplicable
        If α-planes are requested with the product of secondary grades, whose result would depend on
        the grid. The Gaussian corollary raises it for terms without Gaussian secondary grades, for
        a t-norm other than the product, and for a type reduction other than center of sets.
    """

    _kinds = (Type1Set, IntervalType2Set, GeneralType2Set)
    _kind_names = "a fuzzy set"

    def __init__(
        self,
        inputs: Sequence[Sequence[Any]] | Mapping[str, Mapping[str, Any]],
        rules: ArrayLike | str | Iterable[str | Rule],
        consequents: Any,
        t_norm: str | TNorm | BinaryFunction = "product",
        type_reduction: str | None = None,
        method: str = "eiasc",
        *,
        reduction: Literal["alpha_planes", "gaussian"] = "alpha_planes",
        levels: int = 5,
        grade_t_norm: str = "min",
        **options: Any,
    ) -> None:
        known_name("reduction", reduction, REDUCTIONS)
        levels = whole_number("levels", levels, 1)
        known_name("t-norm of secondary grades", grade_t_norm, ("min", "product"))
        self.reduction, self.levels, self.grade_t_norm = reduction, int(levels), grade_t_norm
        self.alphas = np.arange(1, self.levels + 1) / self.levels
        # Half-widths of the α-planes of a Gaussian, in standard deviations.
        self._widths = np.sqrt(-2.0 * np.log(self.alphas))
        super().__init__(inputs, rules, consequents, t_norm, type_reduction, method, **options)
        # The fast path of interval systems would ignore the secondary grades.
        self._fast = False
        self._planes: list[IntervalType2System] | None = None
        left, right = np.moveaxis(self.consequent_intervals, -1, 0)
        # An interval consequent is treated as a Gaussian whose ends are two standard deviations
        # from its mean.
        self._middles, self._spreads = 0.5 * (left + right), 0.25 * (right - left)
        uncertain = self.consequent_sets is not None and any(
            isinstance(item, GeneralType2Set) for row in self.consequent_sets for item in row
        )
        # The loop over the planes uses the same consequents for all planes, but general type-2
        # consequents have a different centroid on each.
        self._one_loop = (
            self._table is not None
            and self._is_compiled
            and self.default_outputs is None
            and not uncertain
        )
        if reduction == "gaussian":
            if uncertain:
                raise NotApplicable(
                    "the Gaussian corollary",
                    "its consequents are numbers, intervals, or sets of type 1 or interval type 2",
                )
            self._check_corollary()
            self._warn_of_validity()
        elif grade_t_norm != "min":
            raise NotApplicable(
                "reduction by alpha-planes",
                "it needs minimum secondary grades; under the product it depends on the grid",
            )
        elif uncertain or method in DIRECT_METHODS:
            # A consequent without a centroid on its planes is refused here, not at the first call.
            self._plane(0)

    @property
    def planes(self) -> Sequence[tuple[float, Differentiable]]:
        """Weight and interval type-2 system of every α-plane.

        There are none under the Gaussian corollary.
        """
        if self.reduction == "gaussian":
            return ()
        shares = self.alphas / self.alphas.sum()
        return [(float(share), self._plane(level)) for level, share in enumerate(shares)]

    @property
    def explained_by(self) -> Sequence[tuple[float, FuzzySystem]]:
        """The α-planes with their weights; for the corollary, the principal system alone."""
        if self.reduction == "gaussian":
            return ((1.0, self._plane(self.levels - 1)),)
        shares = self.alphas / self.alphas.sum()
        return [(float(share), self._plane(level)) for level, share in enumerate(shares)]

    @property
    def middles(self) -> Array | None:
        """Middles of the consequents under the Gaussian corollary, (R, m); None for α-planes."""
        return self._middles if self.reduction == "gaussian" else None

    @property
    def in_one_loop(self) -> bool:
        """Whether one table serves all α-planes, which then differ only in ``widths``."""
        return self._one_loop

    @property
    def widths(self) -> Array:
        """Half-widths of the α-planes of a Gaussian at ``alphas``, (L,), in standard deviations.

        :mod:`fuzzy2.systems.kernels` uses them.
        """
        return self._widths

    @property
    def moments(self) -> tuple[Array, Array]:
        """Means and standard deviations of the consequents as Gaussian numbers, (R, m) each.

        :mod:`fuzzy2.systems.kernels` uses them.
        """
        return self._middles, self._spreads

    def kernel_row(self, term: Any) -> tuple[float, ...] | None:
        """Return the kernel row of a term, or None if the compiled loop cannot evaluate it."""
        from fuzzy2.sets.gaussian_type2 import GaussianType2Set

        if isinstance(term, GaussianType2Set):
            principal = term.principal.kernel_row()
            # Kind 2 of the kernels: a Gaussian principal membership with one standard deviation for
            # all vertical slices and an unbounded domain.
            unbounded = np.isinf(term.domain).all()
            if principal is None or principal[0] != 0 or callable(term.sigma) or not unbounded:
                return None
            return (2.0, *principal[1:7], float(term.sigma), 0.0)
        row: tuple[float, ...] | None = term.kernel_row()
        return row

    def alpha_cuts(self, X: ArrayLike) -> Array:
        """Return the α-cuts of the type-reduced set.

        Parameters
        ----------
        X : (..., p) array_like
            Inputs.

        Returns
        -------
        (..., m, L, 2) ndarray
            Ends of the cuts at ``alphas``; NaN on planes where no rule fires. If an output has a
            default and no rule fires on some plane, all planes of the output have the default.

        Raises
        ------
        InvalidValue
            If the inputs are not finite or have a wrong shape.
        """
        shape, rows = self._rows(X)
        self._refuse(rows)
        if self._one_loop:
            planes = np.empty((len(rows), self.levels, self.n_outputs, 2))
            for given, found in flat_pieces(rows, planes):
                self._kernels.evaluate_planes(self._table, given, self._widths, found)
        else:
            planes = np.stack(
                [self._plane(level).type_reduced(rows) for level in range(self.levels)], axis=1
            )
        cuts = planes.swapaxes(1, 2)
        if self.default_outputs is not None:
            # If some plane has no answer, the output has none, and all planes take the default.
            silent = np.isnan(cuts).any(axis=(-2, -1), keepdims=True)
            defaults = self.default_outputs[:, np.newaxis, np.newaxis]
            cuts = np.where(silent & ~np.isnan(defaults), defaults, cuts)
        return cuts.reshape(*shape, self.n_outputs, self.levels, 2)

    def _prepared_outputs(self) -> Any:
        # Each α-plane has its own table.
        return None

    def _compiled_defaults(self) -> Array | None:
        # A plane on which no rule fires invalidates the output, so all planes become NaN.
        return None

    def _firing(self, rows: Array) -> Array:
        """Return the firing intervals on the lowest α-plane."""
        if self._table is None:
            return self._plane(0)._firing(rows)
        out = np.empty((len(rows), len(self.rules), 2))
        width = float(self._widths[0])
        for given, found in flat_pieces(rows, out):
            self._kernels.firing(self._table, given, width, found)
        return out

    def coverage(self, X: ArrayLike) -> Array:
        """Return the upper firing strength (...,) of the rule that fires most, for α = 1."""
        # A low plane of a Gaussian secondary is above 0 everywhere. Only the highest plane, α = 1,
        # shows where rules really fire.
        return self._plane(self.levels - 1).coverage(X)

    def embedded_outputs(
        self, x: ArrayLike, count: int = 1000, rng: np.random.Generator | None = None
    ) -> Iterator[Array]:
        """Yield outputs of type-1 systems embedded in the lowest α-plane.

        See :meth:`FuzzySystem.embedded_outputs`.
        """
        yield from self._plane(0).embedded_outputs(x, count, rng)

    def _plane(self, level: int) -> IntervalType2System:
        """Return the interval type-2 system of one α-plane."""
        if self._planes is None:
            self._planes = []
            ranges = self.output_ranges
            if (
                ranges is None
                and self.consequent_sets is not None
                and self.type_reduction in ("centroid", "center_of_sums")
            ):
                # All planes use one grid. Grids of different planes would differ, and the cuts
                # would not be nested.
                ranges = tuple(
                    domain_of([row[j] for row in self.consequent_sets if row[j] is not None])
                    for j in range(self.n_outputs)
                )
                if any(left == right for left, right in ranges):
                    # A singleton is the same on all planes.
                    ranges = None
            for alpha in self.alphas:

                def cut(item: Any, alpha: float = float(alpha)) -> Any:
                    return item.alpha_plane(alpha) if isinstance(item, GeneralType2Set) else item

                fuzzifiers = self.fuzzifiers and tuple(
                    NonSingletonFuzzifier(cut(one.shape))
                    if isinstance(one, NonSingletonFuzzifier)
                    else one
                    for one in self.fuzzifiers
                )
                consequents = self.consequents
                if self.consequent_sets is not None:
                    consequents = [
                        [None if item is None else cut(item) for item in row]
                        for row in self.consequent_sets
                    ]
                plane = IntervalType2System(
                    [[cut(term) for term in terms] for terms in self.inputs],
                    self.rules,
                    consequents,
                    self.t_norm,
                    self.type_reduction,
                    self.method,
                    t_conorm=self.t_conorm,
                    disjunction=self.disjunction,
                    implication=self.implication,
                    weights=self.weights,
                    silent=self.silent,
                    shares=self.shares,
                    integration=self.integration,
                    fuzzifier=fuzzifiers,
                    input_names=self.input_names,
                    input_ranges=self.input_ranges,
                    output_ranges=ranges,
                    resolution=self.resolution,
                )
                self._planes.append(plane)
        return self._planes[level]

    def _crisp(self, X: Any) -> Array:
        """Return the crisp outputs (..., m), as :class:`GeneralType2System` describes."""
        if self.reduction == "gaussian":
            return self._corollary(X)[..., 0]
        if self._one_loop:
            shape, rows = self._rows(X)
            out = np.empty((len(rows), self.n_outputs))
            evaluate = self._kernels.evaluate_crisp_planes
            for given, found in flat_pieces(rows, out):
                if evaluate(self._table, given, self._widths, self.alphas, found) >= 0:
                    self._refuse(rows)
            return out.reshape(*shape, self.n_outputs)
        middles = self.alpha_cuts(X).mean(axis=-1)
        crisp = np.zeros(middles.shape[:-1])
        # The sum runs plane by plane, because a matrix product would add up in another order.
        for k, share in enumerate(self.alphas / self.alphas.sum()):
            crisp += share * middles[..., k]
        return crisp

    def type_reduced(self, X: ArrayLike) -> Array:
        """Return the lowest α-cut (..., m, 2), or mean and standard deviation.

        Mean and standard deviation are returned under the Gaussian corollary.

        Parameters
        ----------
        X : (..., p) array_like
            Inputs.

        Returns
        -------
        (..., m, 2) ndarray
            Ends of the cut at ``alphas[0]``, or (mean, standard deviation); NaN where no rule
            fires.

        Raises
        ------
        InvalidValue
            If the inputs are not finite or have a wrong shape.
        """
        if self.reduction == "gaussian":
            return self._corollary(X)
        return self.alpha_cuts(X)[..., 0, :]

    def _check_corollary(self) -> None:
        from fuzzy2.sets.gaussian_type2 import GaussianType2Set

        name = "the Gaussian corollary"
        if (
            isinstance(self.rules, tuple)
            or self.method in DIRECT_METHODS
            or any(part is not None for part in (self.weights, self.silent, self.default_outputs))
        ):
            raise NotApplicable(
                name,
                "its rules must join terms with and, have no weights and a consequent for every "
                "output; it needs an exact method and no default outputs",
            )
        if (
            self.t_norm.name != "product"
            or self.type_reduction != "center_of_sets"
            or self.fuzzifiers is not None
        ):
            raise NotApplicable(
                name, "it needs the product t-norm, center of sets and a singleton fuzzifier"
            )
        if isinstance(self.consequents, FunctionsOfInputs):
            raise NotApplicable(
                name, "its consequents are numbers or sets, not functions of the inputs"
            )
        for terms in self.inputs:
            for term in terms:
                if not isinstance(term, GaussianType2Set | Type1Set):
                    raise NotApplicable(name, f"{term!r} has no Gaussian secondary grades")

    def _numbers(self, rows: Array) -> tuple[Array, Array]:
        """Return mean and standard deviation of every rule's firing, (n, R) each, by eq. 1.30."""
        from fuzzy2.sets.gaussian_type2 import GaussianType2Set

        mean = np.ones((len(rows), len(self.rules)))
        variance = np.zeros_like(mean)
        for i, terms in enumerate(self.inputs):
            x = rows[:, i]
            principal = np.stack(
                [
                    (t.principal if isinstance(t, GaussianType2Set) else t).membership(x)
                    for t in terms
                ],
                axis=1,
            )
            sigma = np.stack(
                [
                    t.spread(x) if isinstance(t, GaussianType2Set) else np.zeros_like(x)
                    for t in terms
                ],
                axis=1,
            )
            asked = self.rules[:, i]
            m = np.where(asked >= 0, principal[:, np.maximum(asked, 0)], 1.0)
            s = np.where(asked >= 0, sigma[:, np.maximum(asked, 0)], 0.0)
            variance = variance * m**2 + mean**2 * s**2
            mean = mean * m
        return mean, np.sqrt(variance)

    def _corollary(self, X: ArrayLike) -> Array:
        """Return mean and standard deviation of every output, (..., m, 2)."""
        shape, rows = self._rows(X)
        if self._table is not None:
            out = np.empty((len(rows), self.n_outputs, 2))
            product = self.grade_t_norm == "product"
            middles, spreads = self._middles.ravel(), self._spreads.ravel()
            from fuzzy2.systems.corollary_kernels import evaluate_corollary

            for given, found in flat_pieces(rows, out):
                if evaluate_corollary(self._table, given, middles, spreads, product, found) >= 0:
                    self._refuse(rows)
            return out.reshape(*shape, self.n_outputs, 2)
        self._refuse(rows)
        mean, sigma = self._numbers(rows)
        points = GaussianNumber(self._middles.T, self._spreads.T, self._number_norm)
        weights = GaussianNumber(mean[:, np.newaxis], sigma[:, np.newaxis], self._number_norm)
        value = approximate_generalized_centroid(points, weights, self._number_norm).value
        assert isinstance(value, GaussianNumber)
        return np.stack([value.mean, value.sigma], axis=-1).reshape(*shape, self.n_outputs, 2)

    @property
    def _number_norm(self) -> Literal["product", "min"]:
        return "product" if self.grade_t_norm == "product" else "min"

    def validity(self, X: ArrayLike) -> Array:
        r"""Return the validity measure of the approximation (eq. 1.109).

        It is :math:`k \sum \Delta_r / \sum h_r` with k = 2 for the corollary.

        Parameters
        ----------
        X : (..., p) array_like
            Inputs.

        Returns
        -------
        (...,) ndarray
            The measure, which is much smaller than 1 where the corollary can be trusted. For
            α-planes it is that of the lowest plane's firing intervals.

        Raises
        ------
        InvalidValue
            If the inputs are not finite or have a wrong shape.
        """
        if self.reduction != "gaussian":
            return self._plane(0).validity(X)
        shape, rows = self._rows(X)
        self._refuse(rows)
        mean, sigma = self._numbers(rows)
        with np.errstate(invalid="ignore", divide="ignore"):
            ratio = np.where(
                mean.sum(axis=1) > 0.0, 2.0 * sigma.sum(axis=1) / mean.sum(axis=1), np.nan
            )
        return np.asarray(ratio.reshape(shape))

    def _warn_of_validity(self) -> None:
        """Warn once, at construction, if the corollary is inaccurate.

        The accuracy is checked at the middles of the terms.
        """
        centers = [[highest_point(term) for term in terms] for terms in self.inputs]
        rows = np.array(
            [
                [
                    points[max(t, 0)] if t >= 0 else points[0]
                    for t, points in zip(rule, centers, strict=True)
                ]
                for rule in self.rules
            ]
        )
        worst = float(np.nanmax(self.validity(rows)))
        if worst > VALIDITY_LIMIT:
            warnings.warn(
                ApproximationWarning(
                    "the Gaussian corollary of this system", worst, VALIDITY_LIMIT
                ),
                stacklevel=4,
            )
