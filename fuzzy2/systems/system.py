r"""Type-1, interval type-2 and general type-2 fuzzy logic systems.

Many inputs, one rule base, many outputs (eq. 1.63–1.83, 1.117–1.124).

A system is inputs (a list of sets per input), rules (which set of each input a rule asks for) and
consequents. Evaluating it takes three steps: membership grades, firing intervals
:math:`[\underline f_r, \overline f_r]` of the rules (the meet of the grades of their antecedents,
eq. 1.79), and type reduction of the consequents weighted with them. The type-reduced set is the
answer with its uncertainty; its middle is the crisp output. **Where no rule fires there is no
answer: NaN, never 0**; :meth:`validate` says where that is.

Gaussian, triangular and trapezoidal terms under minimum or product are evaluated by one compiled
loop; any other set or t-norm works, too, at NumPy's speed.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import InvalidValue, NotApplicable, UnknownName
from fuzzy2.operations.t_norms import BinaryFunction, TConorm, TNorm
from fuzzy2.operations.t_norms import t_conorm as conorm_named
from fuzzy2.operations.t_norms import t_norm as norm_named
from fuzzy2.reduction.interval import METHODS, generalized_centroid
from fuzzy2.sets.interval_type2 import IntervalType2Set
from fuzzy2.sets.type1 import Type1Set
from fuzzy2.support.checks import Array, reals
from fuzzy2.systems.consequents import Linear
from fuzzy2.systems.construction import (
    check_inputs,
    checked_consequents,
    checked_fuzzifiers,
    checked_names,
    checked_ranges,
    checked_rules,
    names_of_consequents,
    read_rules,
)
from fuzzy2.systems.embedded import embedded_averages
from fuzzy2.systems.fuzzifiers import Fuzzifier
from fuzzy2.systems.gradients import Differentiable, gradient
from fuzzy2.systems.report import Report, grid_over, repeated_rules
from fuzzy2.systems.rules import Rule
from fuzzy2.systems.table import table_of
from fuzzy2.systems.terms import domain_of, highest_point, range_of, spread

TYPE_REDUCTIONS = ("center_of_sets", "height", "modified_height", "centroid", "center_of_sums")
"""Names of the ways from firing intervals to a type-reduced set."""


class FuzzySystem:
    """What the three kinds of systems share.

    Use :class:`Type1System`, :class:`IntervalType2System` or :class:`GeneralType2System`.

    Parameters
    ----------
    inputs : list of lists of sets, or mapping from names to mappings from names to sets
        The terms of every input.
    rules : (R, p) array_like of int, or text or rule objects
        Number of the term of each input that a rule asks for; -1 where the input plays no part. Or
        rules in words, ``IF error is Small and rate is Zero THEN force is Weak``, as text with a
        rule a line or as :class:`fuzzy2.Rule` objects; then inputs have names, and the consequents
        are the terms of the outputs by name.
    consequents : (R, m) or (R, m, 2) array_like, Linear, sets, or mapping of mappings
        Numbers, intervals, linear functions of the inputs, or sets: one per rule, or a list per
        rule with one per output. For rules in words, what each term of each output means: a number,
        an interval or a set.
    t_norm : str or callable
        How the grades of a rule's antecedents are combined: ``"product"``, ``"min"``, any name of
        :mod:`fuzzy2.operations.t_norms`, or a function.
    type_reduction : str
        ``"center_of_sets"`` (consequents by their centroids), ``"height"`` and
        ``"modified_height"`` (by their highest points; the latter divides weights by squared
        spreads), ``"centroid"`` and ``"center_of_sums"`` (on a grid of the output, rules united by
        the t-conorm or summed). All but the first need consequents that are sets.
    method : str
        Exact method of type reduction, see :func:`fuzzy2.generalized_centroid`; they all give the
        same.
    t_conorm : str or callable
        How the rules' outputs are united under ``"centroid"``.
    fuzzifier : Fuzzifier, or one for each input
        How inputs become fuzzy sets, see :mod:`fuzzy2.systems.fuzzifiers`; singleton by default.
    input_names, output_names : sequence of str, optional
        Names; ``x1, x2, ...`` and ``y1, y2, ...`` by default.
    term_names : sequence of sequences of str, optional
        Names of the terms of every input; ``term1, ...`` by default.
    consequent_names : sequence of sequences of str, optional
        Name of what each rule (R,) says of each output (m,), for files; of rules in words, the
        names of the terms.
    input_ranges, output_ranges : (p, 2) and (m, 2) array_like, optional
        Ends of the variables' domains. Those of the outputs are the ends of the output grid, which
        are otherwise the ends of the consequents; those of the inputs are for files.
    resolution : int
        Points of the output grid of ``"centroid"`` and ``"center_of_sums"``.

    Raises
    ------
    InvalidValue
        If shapes do not go together, a rule asks for a term that is not there, or a set is of a
        kind the system cannot take.
    UnknownName
        If a t-norm, a type reduction or a method is unknown.
    """

    _kinds: tuple[type, ...] = ()
    _kind_names = ""

    def __init__(  # noqa: PLR0913 (public: what a system is, and its names and ranges)
        self,
        inputs: Sequence[Sequence[Any]] | Mapping[str, Mapping[str, Any]],
        rules: ArrayLike | str | Iterable[str | Rule],
        consequents: Any,
        t_norm: str | TNorm | BinaryFunction = "product",
        type_reduction: str = "center_of_sets",
        method: str = "eiasc",
        *,
        t_conorm: str | TConorm | BinaryFunction = "max",
        fuzzifier: Fuzzifier | Sequence[Fuzzifier] | None = None,
        input_names: Sequence[str] | None = None,
        output_names: Sequence[str] | None = None,
        term_names: Sequence[Sequence[str]] | None = None,
        consequent_names: Sequence[Sequence[str]] | None = None,
        input_ranges: ArrayLike | None = None,
        output_ranges: ArrayLike | None = None,
        resolution: int = 501,
    ) -> None:
        if isinstance(inputs, Mapping):
            input_names, term_names = list(inputs), [list(terms) for terms in inputs.values()]
            inputs = [list(terms.values()) for terms in inputs.values()]
        if isinstance(consequents, Mapping):
            rules, consequents, output_names, consequent_names = read_rules(
                rules, consequents, input_names, term_names
            )
        self.inputs: tuple[tuple[Any, ...], ...] = tuple(tuple(terms) for terms in inputs)
        check_inputs(self.inputs, self._kinds, self._kind_names)
        self.rules = checked_rules(rules, self.inputs)
        self.t_norm, self.t_conorm = norm_named(t_norm), conorm_named(t_conorm)
        if type_reduction not in TYPE_REDUCTIONS:
            raise UnknownName("type reduction", type_reduction, TYPE_REDUCTIONS)
        if method not in METHODS:
            raise UnknownName("type-reduction method", method, METHODS)
        self.type_reduction, self.method, self.fuzzifier = type_reduction, method, fuzzifier
        self.fuzzifiers = checked_fuzzifiers(
            fuzzifier, len(self.inputs), self._kinds, self._kind_names
        )
        if resolution < 2 or resolution != int(resolution):
            raise InvalidValue("resolution", resolution, "a whole number of at least 2")
        self.resolution = int(resolution)
        self.consequents, self.consequent_sets, self.consequent_intervals = checked_consequents(
            consequents, len(self.rules), len(self.inputs), self._kinds, self._kind_names
        )
        if type_reduction != "center_of_sets" and self.consequent_sets is None:
            raise NotApplicable(
                f"type reduction {type_reduction!r}",
                "the consequents are no sets; use center_of_sets",
            )
        self.n_outputs = int(self.consequent_intervals.shape[1])
        self.input_names = checked_names("input_names", input_names, len(self.inputs), "x")
        self.output_names = checked_names("output_names", output_names, self.n_outputs, "y")
        given = [None] * len(self.inputs) if term_names is None else list(term_names)
        if len(given) != len(self.inputs):
            raise InvalidValue(
                "term_names",
                term_names,
                f"a list of names for each of the {len(self.inputs)} inputs",
            )
        self.term_names = tuple(
            checked_names("term_names", names, len(terms), "term")
            for names, terms in zip(given, self.inputs, strict=True)
        )
        self.consequent_names = names_of_consequents(
            consequent_names, len(self.rules), self.n_outputs
        )
        self.input_ranges = checked_ranges("input_ranges", input_ranges, len(self.inputs))
        self.output_ranges = checked_ranges("output_ranges", output_ranges, self.n_outputs)
        self._table = self._compiled_table()
        self._fast = (
            self._table is not None
            and type_reduction == "center_of_sets"
            and not isinstance(self.consequents, Linear)
        )
        # Looked up once: a control loop calls a system a thousand times a second.
        self._kernels = _kernels()
        self._evaluate_row = self._kernels.evaluate_row

    def __repr__(self) -> str:
        return (
            f"{type(self).__name__}({len(self.inputs)} inputs, {len(self.rules)} rules, "
            f"{self.n_outputs} outputs, t_norm={self.t_norm.name!r}, "
            f"type_reduction={self.type_reduction!r})"
        )

    def __getstate__(self) -> dict[str, Any]:
        return {
            name: value
            for name, value in self.__dict__.items()
            if name not in ("_kernels", "_evaluate_row")
        }

    def __setstate__(self, state: dict[str, Any]) -> None:
        kernels = _kernels()
        self.__dict__.update(state, _kernels=kernels, _evaluate_row=kernels.evaluate_row)

    def _compiled_table(self) -> Array | None:
        """Return the system as one array for the compiled loop, or None if that cannot do it."""
        if self.t_norm.name not in ("min", "product") or self.fuzzifiers is not None:
            return None
        rows = []
        for number, terms in enumerate(self.inputs):
            for term in terms:
                row = self._kernel_row(term)
                if row is None:
                    return None
                rows.append((float(number), *row))
        return table_of(
            self.inputs, self.rules, self.consequent_intervals, self.t_norm.name == "min", rows
        )

    def _kernel_row(self, term: Any) -> tuple[float, ...] | None:
        row: tuple[float, ...] | None = term.kernel_row()
        return row

    # Evaluation

    @property
    def table(self) -> Array | None:
        """The system as the array that :mod:`fuzzy2.systems.kernels` takes; None if it cannot."""
        compiled = self.type_reduction == "center_of_sets" and not isinstance(
            self.consequents, Linear
        )
        return self._table if compiled else None

    def _rows(self, X: ArrayLike) -> tuple[tuple[int, ...], Array]:
        """Return the leading shape and the inputs as (n, p)."""
        given = X if type(X) is np.ndarray and X.dtype.kind == "f" else reals("X", X)
        if given.shape[-1:] != (len(self.inputs),) or np.ndim(X) == 0:
            raise InvalidValue("X", given.shape, f"of shape (..., {len(self.inputs)})")
        # What can be written to, because numba would compile every loop anew for what cannot.
        rows = np.require(given, np.float64, ["C", "W"])
        return given.shape[:-1], rows.reshape(-1, len(self.inputs))

    def _refuse(self, rows: Array) -> None:
        bad = np.flatnonzero(~np.isfinite(rows).all(axis=1))
        if bad.size:
            raise InvalidValue("X", rows[bad[0]], "finite")

    def __call__(self, X: ArrayLike) -> Array:
        """Return the crisp outputs, the middles of the type-reduced intervals.

        Parameters
        ----------
        X : (..., p) array_like
            Inputs.

        Returns
        -------
        (..., m) ndarray
            Outputs; NaN where no rule fires.

        Raises
        ------
        InvalidValue
            If the inputs are not finite or of another shape.
        """
        if self._fast:
            out = np.empty(self.n_outputs)
            try:
                done = self._evaluate_row(self._table, X, out)
            except TypeError:
                # Not a contiguous row of floats: many rows, lists and the like go the longer way.
                done = 0
            return out if done else self._evaluate(X, crisp=True)
        return np.asarray(self.type_reduced(X).mean(axis=-1))

    def type_reduced(self, X: ArrayLike) -> Array:
        """Return the type-reduced intervals.

        Parameters
        ----------
        X : (..., p) array_like
            Inputs.

        Returns
        -------
        (..., m, 2) ndarray
            Left and right ends; NaN where no rule fires. No confidence intervals: how often they
            cover the truth is not known.

        Raises
        ------
        InvalidValue
            If the inputs are not finite or of another shape.
        """
        if self._fast:
            out = np.empty(2 * self.n_outputs)
            try:
                done = self._evaluate_row(self._table, X, out)
            except TypeError:
                done = 0
            return out.reshape(-1, 2) if done else self._evaluate(X, crisp=False)
        shape, rows = self._rows(X)
        self._refuse(rows)
        reduced = self._reduce(rows, self._firing(rows))
        return reduced.reshape(*shape, self.n_outputs, 2)

    def _evaluate(self, X: ArrayLike, crisp: bool) -> Array:
        """Return outputs or intervals of inputs of any make and number."""
        shape, rows = self._rows(X)
        results: Array = np.empty(
            (*shape, self.n_outputs) if crisp else (*shape, self.n_outputs, 2)
        )
        if self._kernels.evaluate(self._table, rows.ravel(), 0.0, crisp, results.ravel()) >= 0:
            self._refuse(rows)
        return results

    def firing(self, X: ArrayLike) -> Array:
        """Return the firing intervals of the rules (eq. 1.79, 1.123).

        Parameters
        ----------
        X : (..., p) array_like
            Inputs.

        Returns
        -------
        (..., R, 2) ndarray
            Lower and upper firing strengths.

        Raises
        ------
        InvalidValue
            If the inputs are not finite or of another shape.
        """
        shape, rows = self._rows(X)
        self._refuse(rows)
        return self._firing(rows).reshape(*shape, len(self.rules), 2)

    def _firing(self, rows: Array) -> Array:
        if self._table is not None:
            out = np.empty((len(rows), len(self.rules), 2))
            self._kernels.firing(self._table, rows.ravel(), 0.0, out.ravel())
            return out
        return self._combine(self._grades(rows))

    def _coverage(self, rows: Array) -> Array:
        """Return the upper firing strength of the rule that fires most, (n,)."""
        strongest: Array = self._firing(rows)[..., 1].max(axis=-1)
        return strongest

    def _grades(self, rows: Array) -> list[Array]:
        """Lower and upper grades (n, terms, 2) of every input."""
        if self.fuzzifiers is not None:
            return [
                np.stack(
                    [fuzzifier.firing(term, rows[:, i], self.t_norm) for term in terms], axis=1
                )
                for i, (terms, fuzzifier) in enumerate(
                    zip(self.inputs, self.fuzzifiers, strict=True)
                )
            ]
        return [
            np.stack(
                [
                    np.stack([term.lower(rows[:, i]), term.upper(rows[:, i])], axis=-1)
                    for term in terms
                ],
                axis=1,
            )
            for i, terms in enumerate(self.inputs)
        ]

    def _combine(self, grades: list[Array]) -> Array:
        strengths = np.ones((len(grades[0]), len(self.rules), 2))
        for i, of_input in enumerate(grades):
            asked = self.rules[:, i]
            chosen = of_input[:, np.maximum(asked, 0)]
            strengths = np.where(
                (asked >= 0)[:, np.newaxis], self.t_norm(strengths, chosen), strengths
            )
        return strengths

    def _reduce(self, rows: Array, strengths: Array) -> Array:
        """Type-reduced intervals (n, m, 2) of firing intervals (n, R, 2)."""
        if self.type_reduction == "center_of_sets":
            if isinstance(self.consequents, Linear):
                intervals = self.consequents.at(rows)
                return generalized_centroid(
                    np.moveaxis(intervals, 2, 1), strengths[:, np.newaxis], self.method
                )
            intervals = np.moveaxis(self.consequent_intervals, 1, 0)
            return generalized_centroid(
                intervals[np.newaxis], strengths[:, np.newaxis], self.method
            )
        assert self.consequent_sets is not None
        ranges = self.output_ranges or (None,) * self.n_outputs
        columns = ([row[j] for row in self.consequent_sets] for j in range(self.n_outputs))
        return np.stack(
            [
                self._reduce_output(sets, ends, strengths)
                for sets, ends in zip(columns, ranges, strict=True)
            ],
            axis=1,
        )

    def _reduce_output(
        self, sets: list[Any], ends: tuple[float, float] | None, strengths: Array
    ) -> Array:
        if self.type_reduction in ("height", "modified_height"):
            points = np.array([highest_point(item) for item in sets])
            heights = np.array(
                [
                    [float(item.lower(at)), float(item.upper(at))]
                    for item, at in zip(sets, points, strict=True)
                ]
            )
            weights = self.t_norm(strengths, heights)
            if self.type_reduction == "modified_height":
                weights = weights / np.array([spread(item) for item in sets])[:, np.newaxis] ** 2
            return generalized_centroid(points, weights, self.method)
        grid = np.linspace(*(ends or domain_of(sets)), self.resolution)
        shapes = np.array([[item.lower(grid), item.upper(grid)] for item in sets])
        reduced = np.empty((len(strengths), 2))
        for start in range(0, len(strengths), 64):
            # A block at a time, so that memory stays that of a block however many inputs there are.
            block = strengths[start : start + 64]
            clipped = self.t_norm(block[..., np.newaxis], shapes[np.newaxis])
            if self.type_reduction == "centroid":
                united = (
                    self.t_conorm.reduce(clipped, axis=1) if clipped.shape[1] > 1 else clipped[:, 0]
                )
            else:
                united = clipped.sum(axis=1)
            reduced[start : start + 64] = generalized_centroid(
                grid, np.moveaxis(united, 1, 2), self.method
            )
        return reduced

    def gradient(self, X: ArrayLike) -> Array:
        r"""Return the derivatives of the crisp outputs by the inputs.

        They are :math:`\partial y_j / \partial x_i`.

        Analytic (:mod:`fuzzy2.systems.gradients`) for center of sets, height, modified height,
        their α-planes and the Gaussian corollary, with singleton fuzzifiers and terms that have a
        ``derivative``, under the continuous t-norms that have a name. All else by sixth-order
        differences: centroid, center of sums, other t-norms and fuzzifiers, and functional or
        sampled type-2 sets, Gaussian ones whose spread is a function, and sets of one's own among
        the terms.

        At a kink the analytic derivative is that of the right side, toward greater :math:`x_i`, and
        a jump of a membership counts for nothing; differences mix both sides within 3/1000 of the
        terms' range.

        Parameters
        ----------
        X : (..., p) array_like
            Inputs.

        Returns
        -------
        (..., m, p) ndarray
            Derivatives; NaN where no rule fires.

        Raises
        ------
        InvalidValue
            If the inputs are not finite or of another shape.
        """
        shape, rows = self._rows(X)
        self._refuse(rows)
        return gradient(self, rows).reshape(*shape, self.n_outputs, len(self.inputs))

    @property
    def planes(self) -> Sequence[tuple[float, Differentiable]]:
        """Systems that the crisp output is a weighted sum of, with their weights; else none."""
        return ()

    @property
    def middles(self) -> Array | None:
        """Points that the Gaussian corollary averages, (R, m); None for other systems."""
        return None

    # Looking at a system

    def validity(self, X: ArrayLike) -> Array:
        r"""Return how far the firing strengths are from crisp (eq. 1.88, 1.104).

        It is :math:`\sum \Delta_r / \sum h_r`.

        Parameters
        ----------
        X : (..., p) array_like
            Inputs.

        Returns
        -------
        (...,) ndarray
            0 where all firing is crisp; the thesis's approximate reducers need it small against 1.
            NaN where no rule fires.

        Raises
        ------
        InvalidValue
            If the inputs are not finite or of another shape.
        """
        strengths = self.firing(X)
        low, high = strengths[..., 0].sum(axis=-1), strengths[..., 1].sum(axis=-1)
        with np.errstate(invalid="ignore"):
            ratio: Array = np.where(high > 0.0, (high - low) / (high + low), np.nan)
        return ratio

    def domain(self) -> Array:
        """Return the range of each input, (p, 2).

        It goes from the peak of the lowest term to that of the highest.
        """
        return np.array([range_of(terms) for terms in self.inputs])

    def validate(
        self, points: int = 15, threshold: float = 1e-3, domain: ArrayLike | None = None
    ) -> Report:
        """Look for uncovered regions, unused terms and rules that disagree or repeat.

        No rule covers such a region or uses such a term; such rules repeat or contradict each
        other.

        Parameters
        ----------
        points : int
            Grid points per input; with many inputs a seeded sample of 100 000 points of the grid is
            looked at.
        threshold : float
            A point counts as covered if some rule's upper firing strength is above this.
        domain : (p, 2) array_like, optional
            Ranges of the inputs to look at; :meth:`domain` by default.

        Returns
        -------
        Report
            What was found; ``report.ok`` if nothing.

        Raises
        ------
        InvalidValue
            If ``points`` is no whole number of at least 2.
        """
        if isinstance(points, bool) or not isinstance(points, int | np.integer) or points < 2:
            raise InvalidValue(
                "points",
                points,
                "a whole number of at least 2, the grid points per input; ranges go into domain",
            )
        ranges = self.domain() if domain is None else reals("domain", domain)
        if (
            ranges.shape != (len(self.inputs), 2)
            or not np.isfinite(ranges).all()
            or (ranges[:, 0] > ranges[:, 1]).any()
        ):
            raise InvalidValue("domain", ranges, f"finite ranges of shape ({len(self.inputs)}, 2)")
        grid = grid_over(ranges, points)
        covered = np.concatenate(
            [
                self._coverage(grid[start : start + 4096]) > threshold
                for start in range(0, len(grid), 4096)
            ]
        )
        unused = [
            (self.input_names[i], self.term_names[i][t])
            for i, terms in enumerate(self.inputs)
            for t in range(len(terms))
            if t not in self.rules[:, i]
        ]
        duplicates, conflicts = repeated_rules(self.rules, self._same_consequent)
        return Report(grid[~covered], float(covered.mean()), unused, duplicates, conflicts)

    def _same_consequent(self, a: int, b: int) -> bool:
        if self.consequent_sets is not None:
            return self.consequent_sets[a] == self.consequent_sets[b]
        if isinstance(self.consequents, Linear):
            both = (self.consequents.coefficients, self.consequents.spreads)
            return all(np.array_equal(values[a], values[b]) for values in both)
        return np.array_equal(self.consequent_intervals[a], self.consequent_intervals[b])

    def embedded_outputs(
        self, x: ArrayLike, count: int = 1000, rng: np.random.Generator | None = None
    ) -> Iterator[Array]:
        """Yield outputs of type-1 systems that the system contains (Fig. 7).

        A type-2 system is many type-1 systems at once.

        Each takes one number from the firing interval of every rule and one from every consequent:
        first the two extreme choices of all switch points of the first output, then random ones.
        All outputs lie in the type-reduced interval.

        Parameters
        ----------
        x : (p,) array_like
            One input.
        count : int
            How many random type-1 systems.
        rng : numpy.random.Generator, optional
            Where the random choices come from; seeded with 0 by default.

        Yields
        ------
        (m,) ndarray
            Output of one embedded type-1 system.
        """
        shape, rows = self._rows(x)
        self._refuse(rows)
        if shape or self.type_reduction != "center_of_sets":
            raise NotApplicable("embedded_outputs", "it takes one input of a center-of-sets system")
        strengths = self._firing(rows)[0]
        intervals = (
            self.consequents.at(rows)[0]
            if isinstance(self.consequents, Linear)
            else self.consequent_intervals
        )
        yield from embedded_averages(
            strengths, intervals, count, np.random.default_rng(0) if rng is None else rng
        )


class Type1System(FuzzySystem):
    """Type-1 fuzzy logic system.

    Its output is crisp, and its type-reduced interval a point unless its consequents are intervals.

    Parameters
    ----------
    inputs, rules, consequents, t_norm, type_reduction, method
        See :class:`FuzzySystem`; all sets of type 1.
    """

    _kinds = (Type1Set,)
    _kind_names = "a type-1 set"


class IntervalType2System(FuzzySystem):
    """Interval type-2 fuzzy logic system: terms of type 1 and interval type-2 terms mix freely.

    Parameters
    ----------
    inputs, rules, consequents, t_norm, type_reduction, method
        See :class:`FuzzySystem`; sets of type 1 or interval type-2 sets.
    """

    _kinds = (Type1Set, IntervalType2Set)
    _kind_names = "a type-1 or an interval type-2 set"


def rebuilt(system: FuzzySystem, **changes: Any) -> FuzzySystem:
    """Return a type-1 or interval type-2 system anew, with other values of some arguments.

    Parameters
    ----------
    system : Type1System or IntervalType2System
        The system.
    **changes
        Arguments of its constructor by name.

    Returns
    -------
    Type1System or IntervalType2System
        A system of the same kind; all arguments that are not named are as they were.
    """
    names = [name for name in inspect.signature(FuzzySystem).parameters if name not in changes]
    return type(system)(**{name: getattr(system, name) for name in names}, **changes)


def _kernels() -> Any:
    """Return the compiled loops; numba is loaded with the first system."""
    from fuzzy2.support.compiled import only_for
    from fuzzy2.systems import kernels

    only_for(kernels.evaluate_row, np.zeros(kernels.HEADER), np.zeros(1), np.zeros(1))
    return kernels
