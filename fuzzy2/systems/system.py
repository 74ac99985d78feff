r"""Type-1, interval type-2 and general type-2 fuzzy logic systems.

A system has any number of inputs and outputs and one rule base (eq. 1.63–1.83, 1.117–1.124).

A system consists of inputs (a list of sets for each input), rules (which select a set of each
input) and consequents. It is evaluated in three steps: membership grades, firing intervals
:math:`[\underline f_r, \overline f_r]` of the rules (the meet of the grades of their antecedents,
eq. 1.79), and type reduction of the consequents, weighted with the firing intervals. The
type-reduced set is the output with its uncertainty, and its middle is the crisp output. **Where no
rule fires, the output is NaN, never 0**; :meth:`validate` finds such regions. Gaussians fire
everywhere. Where firing strengths underflow and only their ratios matter, they are computed as
logarithms, also through *or*, *not* and hedges. Far from all terms, the output of a type-1 system
is the consequent of the nearest rule. The type-reduced interval of an interval type-2 system is
usually wide there, because upper and lower strengths differ greatly. NaN then means that the
formula of a strength gives 0: beyond the ends of bounded terms, or for tiny grades under the
Łukasiewicz, the drastic or the nilpotent t-norm. User-defined t-norms and hedges still give NaN
after an underflow, because their formulas are unknown.

Gaussian, triangular and trapezoidal terms under a named t-norm are evaluated in one compiled loop.
All other sets and t-norms are evaluated in NumPy, which is slower.
"""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fuzzy2.errors import (
    ApproximationWarning,
    DefaultReductionWarning,
    InvalidValue,
    NotApplicable,
    ReadOnly,
)
from fuzzy2.operations.t_norms import T_CONORMS, T_NORMS, BinaryFunction, TConorm, TNorm
from fuzzy2.operations.t_norms import t_conorm as conorm_named
from fuzzy2.operations.t_norms import t_norm as norm_named
from fuzzy2.sets.interval_type2 import IntervalType2Set
from fuzzy2.sets.type1 import Type1Set
from fuzzy2.support.checks import (
    Array,
    binary_exponent,
    generator,
    known_name,
    of_kind,
    real,
    reals,
    whole_number,
)
from fuzzy2.support.markup import Markup
from fuzzy2.support.pieces import flat_pieces
from fuzzy2.support.shown import Shown
from fuzzy2.systems.antecedents import strength, trees_of
from fuzzy2.systems.consequents import Formulas, FunctionsOfInputs
from fuzzy2.systems.construction import (
    check_inputs,
    checked_consequents,
    checked_defaults,
    checked_fuzzifiers,
    checked_names,
    checked_output_terms,
    checked_ranges,
    checked_rules,
    checked_shares,
    checked_terms,
    checked_weights,
    listed_terms,
    names_of_consequents,
    read_rules,
)
from fuzzy2.systems.embedded import embedded_averages
from fuzzy2.systems.explanation import Explanation, explained
from fuzzy2.systems.fuzzifiers import Fuzzifier
from fuzzy2.systems.gradients import Differentiable, gradient
from fuzzy2.systems.hedges import Hedge, known_hedges
from fuzzy2.systems.log_firing import VANISHED, log_firing, log_grades, log_norms, lost
from fuzzy2.systems.named_inputs import by_name, like_inputs
from fuzzy2.systems.operators import (
    CRISP_ONLY,
    DIRECT_METHODS,
    INTEGRATIONS,
    METHODS,
    POINTS,
    aggregation,
)
from fuzzy2.systems.operators import (
    type_reduction as reduction_named,
)
from fuzzy2.systems.output_tables import tables_of
from fuzzy2.systems.outputs import Operators, Outputs, hangs_on_ratios
from fuzzy2.systems.pictures import html_of
from fuzzy2.systems.report import Report, found_in
from fuzzy2.systems.rules import Rule
from fuzzy2.systems.table import Supplement, table_of
from fuzzy2.systems.term_rows import TermRows
from fuzzy2.systems.terms import range_of

_FLOAT = np.dtype(np.float64)


class FuzzySystem(Shown):
    """Base of the three kinds of systems.

    Use :class:`Type1System`, :class:`IntervalType2System` or :class:`GeneralType2System`. Systems
    are immutable: their arrays are read-only, and :meth:`replace` returns another system.

    Parameters
    ----------
    inputs : list of lists of sets, or mapping from names to mappings from names to sets
        The terms of every input.
    rules : (R, p) array_like of int, or text or rule objects
        Number of each input's term in each rule; -1 for an input that a rule does not use.
        Alternatively, trees of :mod:`fuzzy2.systems.antecedents`, or rules in words
        (:mod:`fuzzy2.systems.rules`), ``IF error is not Small or rate is very Large THEN force is
        Weak``, as text with one rule per line or as :class:`fuzzy2.Rule` objects. With rules in
        words, inputs must have names, and the consequents are the terms of the outputs by name.
    consequents : (R, m) or (R, m, 2) array_like, Linear, sets, or mapping of mappings
        Numbers, intervals, linear functions of the inputs, or sets: one per rule, or a list per
        rule with one per output, None where a rule has no consequent for an output. For rules in
        words, the terms of each output by name: numbers, intervals or sets.
    t_norm : str or callable
        T-norm of *and*: ``"product"``, ``"min"``, any name in :mod:`fuzzy2.operations.t_norms`, or
        a function.
    type_reduction : str
        ``"center_of_sets"``, ``"centroid"``, or any other name in :mod:`fuzzy2.systems.operators`,
        which describes them. All except center of sets, the default, and the weighted sum need
        consequents that are sets. ``"bisector"``, the maxima and ``"tsukamoto"`` need type-1
        systems.
    method : str
        Exact method of type reduction, see :func:`fuzzy2.generalized_centroid`; all of them give
        the same result. Or an approximate method: ``"nie_tan"``, ``"wu_mendel"`` or
        ``"begian_melek_mendel"``.
    t_conorm : str or callable
        T-conorm that unites the output sets of the rules; ``"sum"`` adds them up.
    disjunction : str or callable
        T-conorm of *or*.
    implication : str or callable
        T-norm that clips or scales a rule's output set by its firing; ``t_norm`` by default.
    weights : (R,) array_like, optional
        Weights of the rules in [0, 1], which are factors of the firing.
    silent : (R, m) array_like of bool, optional
        Where a rule has no consequent for an output; the values of ``consequents`` there are
        ignored.
    default_outputs : sequence of m numbers, optional
        Outputs where no rule fires, None for NaN.
    shares : (float, float)
        Weights of the lower and the upper average under ``"begian_melek_mendel"``.
    hedges : mapping from words to Hedge or callable, optional
        Hedges of rules in words, in addition to those of :mod:`fuzzy2.systems.hedges`.
    integration : {"exact", "sum", "trapezoidal", "midpoint", "left"}
        How the centroid of united sets is computed. ``"exact"`` integrates it to 1e-6 of the
        output's range or better (:mod:`fuzzy2.systems.united`). ``"sum"`` adds up ``resolution``
        points from end to end, as MATLAB does; ``"trapezoidal"`` takes trapezoids between them, as
        Octave does. ``"midpoint"`` takes the middles of ``resolution`` equal pieces, as fuzzylite
        does, and ``"left"`` their left ends, as jFuzzyLogic does.
    fuzzifier : Fuzzifier, or one for each input
        How inputs become fuzzy sets, see :mod:`fuzzy2.systems.fuzzifiers`; singleton by default.
    input_names, output_names : sequence of str, optional
        Names; ``x1, x2, ...`` and ``y1, y2, ...`` by default.
    term_names : sequence of sequences of str, optional
        Names of the terms of every input; ``term1, ...`` by default.
    consequent_names : sequence of sequences of str, optional
        Name of the consequent of each rule (R,) for each output (m,), for files. With rules in
        words they are the names of the terms.
    input_ranges, output_ranges : (p, 2) and (m, 2) array_like, optional
        Ends of the variables' domains. Those of the outputs are the ends of the output grid; by
        default the grid ends with the consequents. Those of the inputs are for files.
    resolution : int
        Number of points of the output grid, unless integration is exact.
    output_terms : sequence of mappings, optional
        All terms of each output by name, including those that no rule uses, for files.

    Raises
    ------
    InvalidValue
        If shapes do not match, if a rule uses a term that does not exist, or if a set is of a kind
        that the system does not accept.
    UnknownName
        If a t-norm, a type reduction or a method is unknown.
    NotApplicable
        If a type reduction does not suit the consequents or the kind of system.
    """

    _kinds: tuple[type, ...] = ()
    _kind_names = ""

    def __init__(  # noqa: PLR0913 (public: what a system is, and its names and ranges)
        self,
        inputs: Sequence[Sequence[Any]] | Mapping[str, Mapping[str, Any]],
        rules: ArrayLike | str | Iterable[str | Rule],
        consequents: Any,
        t_norm: str | TNorm | BinaryFunction = "product",
        type_reduction: str | None = None,
        method: str = "eiasc",
        *,
        t_conorm: str | TConorm | BinaryFunction = "max",
        disjunction: str | TConorm | BinaryFunction = "max",
        implication: str | TNorm | BinaryFunction | None = None,
        weights: ArrayLike | None = None,
        silent: ArrayLike | None = None,
        default_outputs: Sequence[float | None] | None = None,
        shares: Sequence[float] = (0.5, 0.5),
        hedges: Mapping[str, Hedge | Callable[[Array], Array]] | None = None,
        integration: str = "exact",
        fuzzifier: Fuzzifier | Sequence[Fuzzifier] | None = None,
        input_names: Sequence[str] | None = None,
        output_names: Sequence[str] | None = None,
        term_names: Sequence[Sequence[str]] | None = None,
        consequent_names: Sequence[Sequence[str]] | None = None,
        input_ranges: ArrayLike | None = None,
        output_ranges: ArrayLike | None = None,
        resolution: int = 501,
        output_terms: Sequence[Mapping[str, Any]] | None = None,
    ) -> None:
        self.hedges = known_hedges(hedges)
        if isinstance(inputs, Mapping):
            for terms in inputs.values():
                of_kind("inputs", terms, Mapping, "a mapping from names to sets for each input")
            input_names, term_names = list(inputs), [list(terms) for terms in inputs.values()]
            inputs = [list(terms.values()) for terms in inputs.values()]
        if isinstance(consequents, Mapping):
            said = read_rules(rules, consequents, input_names, term_names, self.hedges)
            rules, consequents, consequent_names = said.rules, said.consequents, said.names
            output_names, output_terms = said.output_names, said.output_terms
            silent = said.silent
            if weights is None:
                weights = said.weights
            if said.of_sets and type_reduction is None:
                warnings.warn(DefaultReductionWarning(), stacklevel=2)
        self.inputs: tuple[tuple[Any, ...], ...] = listed_terms(inputs)
        self.input_ranges = checked_ranges("input_ranges", input_ranges, len(self.inputs))
        check_inputs(self.inputs, self._kinds, self._kind_names, self.input_ranges is not None)
        self.rules = checked_rules(rules, self.inputs)
        count = len(self.rules)
        self.t_norm, self.t_conorm = norm_named(t_norm), aggregation(t_conorm)
        self.disjunction = conorm_named(disjunction)
        self.implication = self.t_norm if implication is None else norm_named(implication)
        self.type_reduction = reduction_named(
            "center_of_sets" if type_reduction is None else type_reduction
        )
        self.method = known_name("type-reduction method", method, METHODS)
        self.integration = known_name("integration", integration, INTEGRATIONS)
        self.shares, self.fuzzifier = checked_shares(shares), fuzzifier
        self.fuzzifiers = checked_fuzzifiers(
            fuzzifier, len(self.inputs), self._kinds, self._kind_names
        )
        self.resolution = whole_number("resolution", resolution, 2)
        checked = checked_consequents(
            consequents,
            silent,
            count,
            len(self.inputs),
            (self._kinds, self._kind_names),
            self.type_reduction == "center_of_sets",
        )
        self.consequents, self.consequent_sets = checked.given, checked.sets
        self.consequent_intervals, self.silent = checked.intervals, checked.silent
        self._check_reduction()
        self.n_outputs = int(self.consequent_intervals.shape[1])
        self.weights = checked_weights(weights, count)
        self.default_outputs = checked_defaults(default_outputs, self.n_outputs)
        self.input_names = checked_names("input_names", input_names, len(self.inputs), "x")
        # Default names must not be matched with the columns of a data frame.
        self._named = self.input_names != checked_names("input_names", None, len(self.inputs), "x")
        self.output_names = checked_names("output_names", output_names, self.n_outputs, "y")
        self.term_names = checked_terms(term_names, self.inputs)
        self.consequent_names = names_of_consequents(consequent_names, count, self.n_outputs)
        self.output_ranges = checked_ranges("output_ranges", output_ranges, self.n_outputs)
        self.output_terms = checked_output_terms(output_terms, self.n_outputs)
        self._table = self._compiled_table()
        self._fast = self._table is not None and self._is_compiled
        self._outputs = self._prepared_outputs()
        self._reducer = self._compiled_outputs()
        # Looked up once, because a control loop calls a system a thousand times a second.
        self._kernels = _kernels()
        self._evaluate_row = self._kernels.evaluate_row

    def _compiled_outputs(self) -> Any:
        """Return the compiled loop and its tables for outputs other than exact center of sets."""
        if self._fast or self._table is None or self._outputs is None:
            return None
        return tables_of(self._outputs, self._table, self._compiled_defaults())

    @property
    def reducer(self) -> Any:
        """The tables of :mod:`fuzzy2.systems.output_tables`; None if there are none."""
        return self._reducer

    def _check_reduction(self) -> None:
        kind = self.type_reduction
        if kind not in POINTS and self.consequent_sets is None:
            raise NotApplicable(
                f"type reduction {kind!r}", "the consequents are not sets; use center_of_sets"
            )
        if kind in CRISP_ONLY and not isinstance(self, Type1System):
            raise NotApplicable(
                f"type reduction {kind!r}",
                "it is defined for type-1 systems; take centroid, or a Type1System",
            )

    @property
    def _is_huge(self) -> bool:
        """Whether distances between consequents may overflow."""
        return binary_exponent(self.consequent_intervals) > 0

    @property
    def _is_compiled(self) -> bool:
        """Whether the compiled loop can evaluate this system completely."""
        return (
            self.type_reduction == "center_of_sets"
            and self.method not in DIRECT_METHODS
            and not isinstance(self.consequents, FunctionsOfInputs)
            and not self._is_huge
        )

    @property
    def _operators(self) -> Operators:
        return Operators(
            self.type_reduction,
            self.method,
            self.shares,
            self.implication,
            self.t_conorm,
            self.integration,
            self.resolution,
        )

    def _prepared_outputs(self) -> Outputs:
        return Outputs(
            self._operators,
            self.consequents,
            self.consequent_sets,
            self.consequent_intervals,
            self.silent,
            self.output_ranges,
        )

    def __setattr__(self, name: str, value: Any) -> None:
        if not name.startswith("_") and name in self.__dict__:
            raise ReadOnly(f"a {type(self).__name__}", name)
        object.__setattr__(self, name, value)

    def __delattr__(self, name: str) -> None:
        raise ReadOnly(f"a {type(self).__name__}", name)

    def replace(self, **changes: Any) -> Self:
        """Return a system with some arguments replaced.

        Parameters
        ----------
        **changes
            Arguments of the constructor by name. New rules in words use the output terms of this
            system if it has their names; its weights are not kept then.

        Returns
        -------
        FuzzySystem
            A system of the same kind; all other arguments are unchanged.

        Raises
        ------
        InvalidValue
            If an argument is unknown, or the resulting system is invalid.
        """
        names = {
            name: kind
            for made in (FuzzySystem, type(self))
            for name, kind in inspect.signature(made).parameters.items()
            if kind.kind is not kind.VAR_KEYWORD
        }
        for name in changes:
            if name not in names:
                raise InvalidValue("an argument of replace", name, f"one of {', '.join(names)}")
        of_words = {"rules", "consequents"} & changes.keys()
        if (of_words and isinstance(changes.get("consequents"), Mapping)) or (
            isinstance(changes.get("rules"), str)
        ):
            if "consequents" not in changes and self.output_terms is not None:
                terms = zip(self.output_names, self.output_terms, strict=True)
                changes["consequents"] = dict(terms)
            for name in ("weights", "silent", "consequent_names", "output_terms"):
                changes.setdefault(name, None)
        kept = {name: getattr(self, name) for name in names if name not in changes}
        with warnings.catch_warnings():
            # The warning was already given when this system was made.
            warnings.simplefilter("ignore", ApproximationWarning)
            return type(self)(**kept, **changes)

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
        # Arrays that are read from a pickle are writable.
        for name in ("rules", "consequents", "consequent_intervals", "weights", "silent"):
            value = state[name]
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    def _compiled_table(self) -> Array | None:
        """Return the system as one array for the compiled loop, or None if it has none."""
        # A user-defined function may have the name of a known one.
        if self.t_norm != T_NORMS.get(self.t_norm.name) or self.fuzzifiers is not None:
            return None
        rows = TermRows()
        for number, terms in enumerate(self.inputs):
            for term in terms:
                if not rows.add(number, term, self.kernel_row(term)):
                    return None
        trees = isinstance(self.rules, tuple)
        table = table_of(
            [len(terms) for terms in self.inputs],
            None if trees else self.rules,
            # If consequents are huge, the table serves for firing only.
            0.0 * self.consequent_intervals if self._is_huge else self.consequent_intervals,
            self.t_norm.name,
            rows.rows,
            Supplement(
                self.rules if trees else None,
                self.disjunction.name
                if self.disjunction == T_CONORMS.get(self.disjunction.name)
                else None,
                self.weights,
                self.silent,
                self._compiled_defaults(),
            ),
        )
        return None if table is None else rows.appended(table)

    def _compiled_defaults(self) -> Array | None:
        return self.default_outputs

    def kernel_row(self, term: Any) -> tuple[float, ...] | None:
        """Return the kernel row of a term, or None if the compiled loop cannot evaluate it."""
        row: tuple[float, ...] | None = term.kernel_row()
        return row

    # Evaluation

    @property
    def table(self) -> Array | None:
        """The system as an array for :mod:`fuzzy2.systems.kernels`; None if there is no such array.

        The array is a copy.
        """
        return self._table.copy() if self._is_compiled and self._table is not None else None

    def _ordered_inputs(self, X: Any) -> Array:
        """Return inputs, given by position or by name, as an array in the order of the inputs."""
        return reals("X", by_name(X, self.input_names, self._named))

    def _ordered_outputs(self, y: Any) -> Array:
        """Return measured outputs, given by position or by name, in the order of the outputs."""
        default = checked_names("output_names", None, self.n_outputs, "y")
        # A single column needs no name to be recognized.
        named = self.n_outputs > 1 and self.output_names != default
        return reals("y", by_name(y, self.output_names, named, "y", "output"))

    def _rows(self, X: ArrayLike) -> tuple[tuple[int, ...], Array]:
        """Return the leading shape and the inputs as (n, p)."""
        given = X if type(X) is np.ndarray and X.dtype.kind == "f" else self._ordered_inputs(X)
        if given.shape[-1:] != (len(self.inputs),) or given.ndim == 0:
            raise InvalidValue("X", given.shape, f"of shape (..., {len(self.inputs)})")
        # Arrays are made writable, because numba would compile every loop again for read-only ones.
        ready = given.dtype is _FLOAT and given.flags.carray
        rows = given if ready else np.require(given, np.float64, ["C", "W"])
        return given.shape[:-1], rows.reshape(-1, len(self.inputs))

    def _refuse(self, rows: Array) -> None:
        bad = np.flatnonzero(~np.isfinite(rows).all(axis=1))
        if bad.size:
            raise InvalidValue("X", rows[bad[0]], "finite")

    def __call__(self, X: Any = None, /, **named: ArrayLike) -> Array:
        """Return the crisp outputs, the middles of the type-reduced intervals.

        Parameters
        ----------
        X : (..., p) array_like, mapping or data frame
            Inputs, or their values by name, which are broadcast.
        **named
            Inputs as keyword arguments instead, ``system(error=0.1, rate=0.0)``.

        Returns
        -------
        (..., m) ndarray
            Outputs; NaN where no rule fires. For a DataFrame of pandas, a DataFrame with its index
            and the names of the outputs is returned, and for a row of one a Series.

        Raises
        ------
        InvalidValue
            If the inputs are not finite or have a wrong shape.
        """
        # Subclasses such as masked arrays take the slow path, because the compiled loop would
        # ignore the mask.
        if self._fast and type(X) is np.ndarray:
            out = np.empty(self.n_outputs)
            try:
                done = self._evaluate_row(self._table, X, out)
            except TypeError:
                # The fast path takes one contiguous row of floats; everything else takes the
                # general path.
                done = 0
            if done and not named:
                return out
        given = self._given(X, named)
        outputs: Array = like_inputs(self._crisp(given), given, self.output_names)
        return outputs

    def _crisp(self, X: Any) -> Array:
        """Return the crisp outputs (..., m) of any array of inputs."""
        if self._fast:
            return self._evaluate(X, crisp=True)
        # Both ends are halved first, because their sum may overflow.
        return np.asarray((0.5 * self.type_reduced(X)).sum(axis=-1))

    def _given(self, X: Any, named: Mapping[str, ArrayLike]) -> Any:
        """Return the inputs, given by position or by name."""
        if named and X is not None:
            raise InvalidValue("X", X, "left out where inputs are given by name")
        return named if X is None and named else X

    def type_reduced(self, X: ArrayLike) -> Array:
        """Return the type-reduced intervals.

        Parameters
        ----------
        X : (..., p) array_like
            Inputs.

        Returns
        -------
        (..., m, 2) ndarray
            Left and right ends; NaN where no rule fires. They are not confidence intervals: their
            coverage probability is not known.

        Raises
        ------
        InvalidValue
            If the inputs are not finite or have a wrong shape.
        """
        if self._fast and type(X) is np.ndarray:
            out = np.empty(2 * self.n_outputs)
            try:
                done = self._evaluate_row(self._table, X, out)
            except TypeError:
                done = 0
            if done:
                return out.reshape(-1, 2)
        if self._fast:
            return self._evaluate(X, crisp=False)
        shape, rows = self._rows(X)
        self._refuse(rows)
        return self._intervals(rows).reshape(*shape, self.n_outputs, 2)

    def _intervals(self, rows: Array) -> Array:
        """Return the type-reduced intervals (n, m, 2) of finite inputs (n, p)."""
        if self._reducer is None:
            return self._or_default(self._reduced(rows))
        from fuzzy2.systems.compiled_outputs import reduced_by_loop

        found, refused = reduced_by_loop(self._reducer, rows, self.n_outputs)
        if refused.any():
            found[refused] = self._or_default(self._reduced(rows[refused]))
        return found

    def _or_default(self, reduced: Array) -> Array:
        """Return intervals (n, m, 2) in which missing outputs are replaced with the defaults."""
        if self.default_outputs is None:
            return reduced
        defaults = self.default_outputs[:, np.newaxis]
        return np.where(np.isnan(reduced), defaults, reduced)

    def _reduced(self, rows: Array) -> Array:
        """Return the type-reduced intervals (n, m, 2); NaN where no rule fires."""
        strengths = self._firing(rows)
        reduced = self._outputs(rows, strengths)
        far, logarithms = self._lost(rows, strengths)
        if far.size:
            reduced[far] = self._outputs.in_logarithms(rows[far], logarithms)
        return reduced

    def _lost(self, rows: Array, strengths: Array) -> tuple[NDArray[np.intp], Array]:
        """Return where firing intervals (n, R, 2) underflow, and their logarithms there.

        It is only valid for systems that depend on ratios of firing strengths only.
        """
        far = np.flatnonzero(lost(strengths, self.silent))
        if not (far.size and self._has_logarithms and hangs_on_ratios(self._operators)):
            return far[:0], strengths[:0]
        logarithms = self._log_firing(rows[far])
        # A strength whose formula gives 0 has not underflowed.
        underflows = (logarithms[..., 1] > -np.inf) & (strengths[far, :, 1] < VANISHED)
        some = underflows.any(axis=1)
        return far[some], logarithms[some]

    @property
    def _has_logarithms(self) -> bool:
        """Whether t-norm and t-conorm, if any, are known for logarithms."""
        known = self.t_norm == T_NORMS.get(self.t_norm.name)
        either = self.disjunction == T_CONORMS.get(self.disjunction.name)
        return known and (either or not isinstance(self.rules, tuple))

    def _log_firing(self, rows: Array) -> Array:
        """Return the logarithms of the firing intervals (n, R, 2), even where these underflow."""
        either = self.disjunction.name if isinstance(self.rules, tuple) else "max"
        norms = log_norms(self.t_norm.name, either)
        return log_firing(self._log_grades(rows), self.rules, self.weights, norms)

    def _evaluate(self, X: ArrayLike, crisp: bool) -> Array:
        """Return outputs or intervals for any array of inputs."""
        shape, rows = self._rows(X)
        results: Array = np.empty(
            (*shape, self.n_outputs) if crisp else (*shape, self.n_outputs, 2)
        )
        out = results.reshape(-1, self.n_outputs if crisp else 2 * self.n_outputs)
        for given, found in flat_pieces(rows, out):
            if self._kernels.evaluate(self._table, given, 0.0, crisp, found) >= 0:
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
            If the inputs are not finite or have a wrong shape.
        """
        shape, rows = self._rows(X)
        self._refuse(rows)
        return self._firing(rows).reshape(*shape, len(self.rules), 2)

    def _firing(self, rows: Array) -> Array:
        if self._table is not None:
            out = np.empty((len(rows), len(self.rules), 2))
            for given, found in flat_pieces(rows, out):
                self._kernels.firing(self._table, given, 0.0, found)
            return out
        return self._combine(self._grades(rows))

    def coverage(self, X: ArrayLike) -> Array:
        """Return the upper firing strength of the rule that fires most.

        Parameters
        ----------
        X : (..., p) array_like
            Inputs.

        Returns
        -------
        (...,) ndarray
            Strengths; for a general type-2 system, those on the plane α = 1. They are 0 where no
            rule fires or all strengths underflow.

        Raises
        ------
        InvalidValue
            If the inputs are not finite or have a wrong shape.
        """
        return np.asarray(self.firing(X)[..., 1].max(axis=-1))

    def _grades(self, rows: Array) -> list[Array]:
        """Return lower and upper grades (n, terms, 2) of every input."""
        if self.fuzzifiers is not None:
            return [
                np.stack(
                    [fuzzifier.firing(term, rows[:, i], self.t_norm) for term in terms], axis=1
                )
                if terms
                else np.empty((len(rows), 0, 2))
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
            if terms
            else np.empty((len(rows), 0, 2))
            for i, terms in enumerate(self.inputs)
        ]

    def _log_grades(self, rows: Array) -> list[Array]:
        """Return the logarithms of :meth:`_grades`, even where the grades underflow."""
        grades = self._grades(rows)
        if self.fuzzifiers is not None:
            with np.errstate(divide="ignore"):
                return [np.log(of_input) for of_input in grades]
        return [
            log_grades(terms, rows[:, i], of_input)
            for i, (terms, of_input) in enumerate(zip(self.inputs, grades, strict=True))
        ]

    def _combine(self, grades: list[Array]) -> Array:
        if isinstance(self.rules, tuple):
            fired = [strength(tree, grades, self.t_norm, self.disjunction) for tree in self.rules]
            strengths = np.stack(fired, axis=1)
        else:
            strengths = np.ones((len(grades[0]), len(self.rules), 2))
            for i, of_input in enumerate(grades):
                asked = self.rules[:, i]
                if not (asked >= 0).any():
                    continue
                chosen = of_input[:, np.maximum(asked, 0)]
                strengths = np.where(
                    (asked >= 0)[:, np.newaxis], self.t_norm(strengths, chosen), strengths
                )
        # The two ends are rounded differently, which must not swap them.
        np.minimum(strengths[..., 0], strengths[..., 1], out=strengths[..., 0])
        return strengths if self.weights is None else strengths * self.weights[:, np.newaxis]

    def gradient(self, X: ArrayLike) -> Array:
        r"""Return the derivatives of the crisp outputs with respect to the inputs.

        They are :math:`\partial y_j / \partial x_i`.

        The derivatives are analytic (:mod:`fuzzy2.systems.gradients`) for center of sets, height,
        modified height, their α-planes and the Gaussian corollary, with singleton fuzzifiers, terms
        that have a ``derivative``, and continuous named t-norms. In all other cases they are
        sixth-order differences: for all other type reductions, t-norms and fuzzifiers; for the
        methods ``"nie_tan"``, ``"wu_mendel"`` and ``"begian_melek_mendel"``; for rules with *or*,
        *not*, groups or hedges, and rules without a consequent for some output; for default
        outputs; for consequents that are formulas; and if terms are functional or sampled type-2
        sets, Gaussian type-2 sets whose spread is a function, or user-defined sets.
        :attr:`without_formula` names the first part of the rules, consequents and methods that has
        no formula.

        At a kink the analytic derivative is the right-hand one, toward greater :math:`x_i`, and
        jumps of memberships are ignored. Differences mix both sides within 3/1000 of the terms'
        range.

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
            If the inputs are not finite or have a wrong shape.
        """
        shape, rows = self._rows(X)
        self._refuse(rows)
        return gradient(self, rows).reshape(*shape, self.n_outputs, len(self.inputs))

    @property
    def without_formula(self) -> str | None:
        """Part of the system for which :meth:`gradient` has no formula; None if there is none."""
        if self.type_reduction not in ("center_of_sets", "height", "modified_height"):
            return f"type reduction {self.type_reduction!r}"
        if isinstance(self.rules, tuple):
            return "rules with or, not or hedges"
        if isinstance(self.consequents, Formulas):
            return "consequents that are formulas"
        if self.silent is not None or self.default_outputs is not None:
            return "rules that leave outputs out, and default outputs"
        return f"the method {self.method!r}" if self.method in DIRECT_METHODS else None

    @property
    def planes(self) -> Sequence[tuple[float, Differentiable]]:
        """Systems whose weighted sum is the crisp output, with their weights; otherwise empty."""
        return ()

    @property
    def middles(self) -> Array | None:
        """Points that the Gaussian corollary averages, (R, m); None for other systems."""
        return None

    # Looking at a system

    def explain(self, x: ArrayLike) -> Explanation:
        """Return an explanation of the output at one input: the rules that decided it.

        Parameters
        ----------
        x : (p,) array_like, or mapping
            One input.

        Returns
        -------
        Explanation
            The explanation. Printing it shows the rules in words, ranked by their shares;
            ``.view()`` draws the inference with one row for each rule.

        Raises
        ------
        InvalidValue
            If the input is not finite, has a wrong shape, or is not a single input.
        """
        return explained(self, x)

    @property
    def explained_by(self) -> Sequence[tuple[float, FuzzySystem]]:
        """Type-1 or interval type-2 systems, with weights, whose weighted sum is the output."""
        return ((1.0, self),)

    def one_row(self, x: ArrayLike) -> Array:
        """Return one input as an array (1, p)."""
        return self._rows(x)[1]

    def log_firing(self, rows: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Return the logarithms of firing intervals (n, R, 2), and where (n,) they underflow.

        Only there they differ from the logarithms of :meth:`firing`.
        """
        strengths = self._firing(rows)
        far, of_far = self._lost(rows, strengths)
        with np.errstate(divide="ignore"):
            logarithms = np.log(strengths)
        logarithms[far] = of_far
        return logarithms, np.isin(np.arange(len(rows)), far)

    def _repr_html_(self) -> Markup:
        return html_of(self)

    def validity(self, X: ArrayLike) -> Array:
        r"""Return the validity measure: how far firing strengths are from crisp (eq. 1.88, 1.104).

        It is :math:`\sum \Delta_r / \sum h_r`.

        Parameters
        ----------
        X : (..., p) array_like
            Inputs.

        Returns
        -------
        (...,) ndarray
            The measure, which is 0 where all firing strengths are crisp. The thesis's approximate
            reducers need it much smaller than 1. NaN where no rule fires.

        Raises
        ------
        InvalidValue
            If the inputs are not finite or have a wrong shape.
        """
        strengths = self.firing(X)
        low, high = strengths[..., 0].sum(axis=-1), strengths[..., 1].sum(axis=-1)
        with np.errstate(invalid="ignore"):
            ratio: Array = np.where(high > 0.0, (high - low) / (high + low), np.nan)
        return ratio

    def domain(self) -> Array:
        """Return the range of each input, (p, 2).

        It goes from the peak of the lowest term to that of the highest. For an input without terms
        it is the given range.
        """
        ranges = self.input_ranges or ((0.0, 0.0),) * len(self.inputs)
        return np.array(
            [
                range_of(terms) if terms else ends
                for terms, ends in zip(self.inputs, ranges, strict=True)
            ]
        )

    def validate(
        self, points: int = 15, threshold: float = 1e-3, domain: ArrayLike | None = None
    ) -> Report:
        """Look for uncovered regions, unused terms, and rules that repeat or contradict each other.

        No rule fires in an uncovered region, and no rule uses an unused term.

        Parameters
        ----------
        points : int
            Grid points per input. A grid of more than 100 000 points is replaced with a seeded
            sample of that size.
        threshold : float
            A point is covered if some rule's upper firing strength is above this value.
        domain : (p, 2) array_like, optional
            Ranges of the inputs to check; :meth:`domain` by default.

        Returns
        -------
        Report
            The findings; ``report.ok`` is true if there are none.

        Raises
        ------
        InvalidValue
            If ``points`` is not a whole number of at least 2.
        """
        points, least = whole_number("points", points, 2), real("threshold", threshold)
        ranges = self.domain() if domain is None else reals("domain", domain)
        if (
            ranges.shape != (len(self.inputs), 2)
            or not np.isfinite(ranges).all()
            or (ranges[:, 0] > ranges[:, 1]).any()
        ):
            raise InvalidValue("domain", ranges, f"finite ranges of shape ({len(self.inputs)}, 2)")
        trees = self.rules if isinstance(self.rules, tuple) else trees_of(self.rules)
        return found_in(
            lambda grid: self.coverage(grid) > least,
            ranges,
            points,
            trees,
            (self.input_names, self.term_names),
            self._agree,
        )

    def _agree(self, a: int, b: int) -> bool | None:
        """Return whether two rules have the same consequents; None if their outputs differ."""
        silent = np.zeros((len(self.rules), self.n_outputs), bool)
        if self.silent is not None:
            silent = self.silent
        both = ~silent[a] & ~silent[b]
        same = np.array([self._same(a, b, j) for j in range(self.n_outputs)])
        if not same[both].all():
            return False
        return True if np.array_equal(silent[a], silent[b]) else None

    def _same(self, a: int, b: int, j: int) -> bool:
        """Return whether two rules have the same consequent for an output."""
        if self.consequent_sets is not None:
            return bool(self.consequent_sets[a][j] == self.consequent_sets[b][j])
        if isinstance(self.consequents, FunctionsOfInputs):
            return bool(self.consequents.said(a, j) == self.consequents.said(b, j))
        return np.array_equal(self.consequent_intervals[a, j], self.consequent_intervals[b, j])

    def embedded_outputs(
        self, x: ArrayLike, count: int = 1000, rng: np.random.Generator | None = None
    ) -> Iterator[Array]:
        """Yield outputs of type-1 systems that are embedded in the system (Fig. 7).

        A type-2 system can be viewed as a collection of type-1 systems.

        Each of them takes one number from the firing interval of every rule and one from every
        consequent. The first ones belong to all switch points of the first output, with the upper
        weights on either side; random choices follow. All outputs lie in the type-reduced interval.

        Parameters
        ----------
        x : (p,) array_like
            One input.
        count : int
            Number of random type-1 systems.
        rng : numpy.random.Generator, optional
            Source of the random choices; seeded with 0 by default.

        Yields
        ------
        (m,) ndarray
            Output of one embedded type-1 system.
        """
        shape, rows = self._rows(x)
        self._refuse(rows)
        if shape or self.type_reduction != "center_of_sets" or self.silent is not None:
            raise NotApplicable(
                "embedded_outputs",
                "it needs one input, center of sets and rules with a consequent for every output",
            )
        strengths = self._firing(rows)[0]
        intervals = (
            self.consequents.at(rows)[0]
            if isinstance(self.consequents, FunctionsOfInputs)
            else self.consequent_intervals
        )
        yield from embedded_averages(
            strengths,
            intervals,
            whole_number("count", count, 0),
            np.random.default_rng(0) if rng is None else generator("rng", rng),
        )


class Type1System(FuzzySystem):
    """Type-1 fuzzy logic system.

    Its output is crisp, and its type-reduced interval is a point unless its consequents are
    intervals.

    Parameters
    ----------
    inputs, rules, consequents, t_norm, type_reduction, method
        See :class:`FuzzySystem`; all sets are type-1 sets.
    """

    _kinds = (Type1Set,)
    _kind_names = "a type-1 set"


class IntervalType2System(FuzzySystem):
    """Interval type-2 fuzzy logic system, which may mix type-1 and interval type-2 terms.

    Parameters
    ----------
    inputs, rules, consequents, t_norm, type_reduction, method
        See :class:`FuzzySystem`; all sets are type-1 or interval type-2 sets.
    """

    _kinds = (Type1Set, IntervalType2Set)
    _kind_names = "a type-1 or an interval type-2 set"


def _kernels() -> Any:
    """Return the compiled loops, which load numba when the first system is made."""
    from fuzzy2.support.compiled import only_for
    from fuzzy2.systems import kernels
    from fuzzy2.systems.firing_kernels import HEADER

    only_for(kernels.evaluate_row, np.zeros(HEADER), np.zeros(1), np.zeros(1))
    return kernels
