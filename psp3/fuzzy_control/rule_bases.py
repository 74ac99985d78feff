"""Rule bases for M, C and G: those of a robot, how they are learned, and their table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from fuzzy2.errors import UnsupportedRule
from fuzzy2.learning.consequents import rules_from_all
from fuzzy2.learning.partition import (
    Term,
    gaussian_partition,
    gaussian_terms,
    grades_in,
    partition_of_centers,
)
from fuzzy2.learning.wang_mendel import LEARNERS as LEARNERS_OF_RULES
from fuzzy2.learning.wang_mendel import MOST_RIDGE_RULES, MOST_RULES, WangMendel
from fuzzy2.sets.gaussian_type2 import GaussianType2Set
from fuzzy2.sets.shapes import Gaussian
from fuzzy2.systems.firing_kernels import HEADER, TERM
from fuzzy2.systems.general_type2 import GeneralType2System
from fuzzy2.systems.system import FuzzySystem, IntervalType2System, Type1System
from psp3.checks import Array, Indices
from psp3.errors import InvalidValue
from psp3.fuzzy_control import christoffel_kernels, kernels
from psp3.fuzzy_control.force_learning import Samples, learn_consequents
from psp3.fuzzy_control.numbers import count_of_numbers, output_names, places_of
from psp3.fuzzy_control.spreading import spread_evenly
from psp3.robots.learning_inputs import LearningInputs

LEARNERS = (*LEARNERS_OF_RULES, "least-squares")
"""Learners of rules, see :class:`fuzzy2.WangMendel`; the last is its ridge least squares, with a
ridge that generalized cross-validation chooses.
"""

CORIOLIS = ("rules", "mass")
"""Sources of C: rules of its own, or the derivative of M."""

MOST_GRID_RULES = 256
"""Most rules in the grid of one of several rule bases. If its grid would have more, clusters of the
samples become the rules.
"""

CLUSTERS = 32
"""Number of these clusters."""

WIDTH_OF_CLUSTER = 1.5
"""Standard deviation of a cluster's terms, as a share of the distance to the nearest other cluster.
It is wide enough for rules to blend between samples, and narrow enough for each consequent to be
meaningful alone.
"""

RIDGE = 1e-3
"""Ridge of the learner ``"ridge"``, as in :class:`fuzzy2.WangMendel`."""

COMPLETED = (
    'learn on a path that goes there, use fewer terms, or take learner="strict", which completes '
    "rules from their neighbors"
)
"""Advice if no sample fires a rule of a grid."""

_NO_PLANES = np.empty((2, 0))


class Place(NamedTuple):
    """A rule base's place: the indices of its inputs, and of its outputs in the row."""

    columns: tuple[int, ...]
    outputs: Indices


def places_of_bases(inputs: LearningInputs, joints: int, coriolis: str) -> tuple[Place, ...]:
    """Return the places of a robot's rule bases.

    If M, C and G depend on the same inputs there is one base. Otherwise one base has M and G, and
    another has C, if C has rules.
    """
    of_mass, of_coriolis = inputs.of_mass_and_gravity, inputs.of_coriolis
    if coriolis == "rules" and of_mass == of_coriolis:
        return (Place(of_mass, places_of("MCG", joints)),)
    of_both = Place(of_mass, places_of("MG", joints))
    if coriolis == "rules":
        return of_both, Place(of_coriolis, places_of("C", joints))
    if (inputs.plus[list(of_mass)] >= joints).any():
        raise InvalidValue(
            "coriolis",
            coriolis,
            "'rules' for a robot whose M is learned from speeds, too, such as the 3-PSP",
        )
    return (of_both,)


class RuleOptions(NamedTuple):
    """How rules are learned, see :class:`psp3.FuzzyComputedTorque`."""

    kind: str
    n_terms: int | None
    rules: int | None
    mean_variation: float
    learner: str
    reduction: str
    levels: int
    term_width: float
    most_grid_rules: float


class _Named(np.ndarray[Any, np.dtype[np.float64]]):
    """An array with named columns, so that errors of learning mention Δq12 instead of x1."""

    columns: tuple[str, ...]


def terms_of_input(options: RuleOptions, inputs: int) -> tuple[int, bool]:
    """Return the number of terms of every input of a base, and whether they make a grid."""
    terms = options.n_terms
    if options.rules is None and terms is not None and terms**inputs <= options.most_grid_rules:
        return terms, True
    return options.rules or CLUSTERS, False


def learned_system(
    options: RuleOptions, inputs: Array, names: tuple[str, ...], outputs: Array
) -> FuzzySystem:
    """Return the system of one rule base, learned from samples (N, p) and (N, m)."""
    number, on_grid = terms_of_input(options, len(names))
    by_validation = options.learner == "least-squares"
    if on_grid:
        _check_grid(options, len(names))
        learner = WangMendel(
            number,
            options.kind,
            options.mean_variation,
            "ridge" if by_validation else options.learner,
            # Table look-up is published with completion of empty cells; the other learners have no
            # model for a rule without samples.
            "nearest" if options.learner == "strict" else "refuse",
            None if by_validation else RIDGE,
            reduction=options.reduction,
            levels=options.levels,
        )
        table = inputs.view(_Named)
        table.columns = names
        try:
            system = learner.fit(table, outputs).system_
        except UnsupportedRule as error:
            found = error.number, error.text, error.firing, error.least, error.count
            raise UnsupportedRule(*found, COMPLETED) from None
    else:
        partition = partition_by_clusters(options, inputs, number)
        learned = rules_from_all(
            *(principal_grades(partition, inputs), outputs, np.multiply, partition.rules),
            "ridge" if by_validation else options.learner,
            None if by_validation else RIDGE,
        )
        system = system_of(options, partition, learned.point_values(), names)
    if options.term_width != 1.0:
        system = _widened(system, options.term_width)
        uncovered = (system.coverage(inputs) == 0.0).mean()
        if uncovered > 0.0:
            wanted = (
                f"large enough for a rule to fire everywhere on the path; at {uncovered:.0%} of "
                "the samples none does"
            )
            raise InvalidValue("term_width", options.term_width, wanted)
    return system


def _check_grid(options: RuleOptions, inputs: int) -> None:
    """Raise :class:`InvalidValue` where a grid would have more rules than can be learned."""
    ridge = options.learner in ("ridge", "least-squares")
    most, terms = MOST_RIDGE_RULES if ridge else MOST_RULES, options.n_terms or 1
    if terms**inputs > most:
        # Rounded down, except for a whole number with a rounding error.
        fit = int(most ** (1.0 / inputs) + 1e-9)
        wanted = f"at most {fit}: each combination of the terms of {inputs} inputs is a rule"
        raise InvalidValue("n_terms", terms, wanted)


def partition_of(options: RuleOptions, inputs: Array, names: tuple[str, ...]) -> Partition:
    """Return the partition of one base for samples (N, p), on a grid or by clusters."""
    number, on_grid = terms_of_input(options, len(names))
    if not on_grid:
        return partition_by_clusters(options, inputs, number)
    ends = list(zip(inputs.min(axis=0), inputs.max(axis=0), strict=True))
    terms = tuple(
        gaussian_partition(*pair, number, options.kind, options.mean_variation) for pair in ends
    )
    principal = [gaussian_partition(*pair, number, "t1") for pair in ends]
    rules = np.indices([number] * len(ends)).reshape(len(ends), -1).T
    return Partition(terms, tuple(gaussian_terms(principal)), np.ascontiguousarray(rules))


def basis_of(partition: Partition, inputs: Array) -> Array:
    """Return the basis functions (N, R) of the type-1 rules of a partition."""
    means, sigmas = _numbers_of(partition.principal, partition.rules)
    gaps = (inputs[:, np.newaxis] - means) / sigmas
    exponents = -0.5 * (gaps**2).sum(axis=-1)
    firing = np.exp(exponents - exponents.max(axis=1, keepdims=True))
    return np.asarray(firing / firing.sum(axis=1, keepdims=True))


def slopes_of(partition: Partition, inputs: Array) -> Array:
    """Return the slopes (N, R, p) of the basis functions along the inputs."""
    means, sigmas = _numbers_of(partition.principal, partition.rules)
    basis = basis_of(partition, inputs)[..., np.newaxis]
    rates = -(inputs[:, np.newaxis] - means) / sigmas**2
    return np.asarray(basis * (rates - (basis * rates).sum(axis=1, keepdims=True)))


class Partition(NamedTuple):
    """Terms of every input, the type-1 terms in their middles, and which of them a rule asks."""

    terms: tuple[tuple[Term, ...], ...]
    principal: tuple[tuple[Gaussian, ...], ...]
    rules: Indices


def partition_by_clusters(options: RuleOptions, inputs: Array, number: int) -> Partition:
    """Return terms centered on evenly spread samples of (N, p), and a rule for each."""
    if options.learner == "strict":
        wanted = "a learner other than table look-up, which needs a grid: give n_terms, too"
        raise InvalidValue("learner", options.learner, wanted)
    least, widths = inputs.min(axis=0), np.ptp(inputs, axis=0)
    points = (inputs - least) / widths
    # Checked first, because the matrix of all distances may not fit into memory.
    different = len(np.unique(points, axis=0))
    if number > different and options.rules is None:
        wanted = f"at least {number} that differ, one for each rule"
        raise InvalidValue("samples", different, wanted)
    if number > different:
        wanted = f"at most {different}, the number of different samples"
        raise InvalidValue("rules", number, wanted)
    centers = points[spread_evenly(points, number)]
    apart = np.sqrt(((centers[:, np.newaxis] - centers) ** 2).sum(axis=-1))
    np.fill_diagonal(apart, np.inf)
    nearest = apart.min(axis=1)
    # A single rule covers the whole range.
    nearest = np.where(np.isfinite(nearest), nearest, 1.0)
    spreads = WIDTH_OF_CLUSTER * nearest[:, np.newaxis] * widths
    placed = least + widths * centers
    reaches = options.mean_variation * widths
    terms, rules = partition_of_centers(placed, spreads, reaches, options.kind)
    principal, _ = partition_of_centers(placed, spreads, reaches, "t1")
    return Partition(terms, tuple(gaussian_terms(principal)), rules)


def principal_grades(partition: Partition, inputs: Array) -> list[Array]:
    """Return the grades (N, K) of every input in the terms' middles."""
    return [grades_in(x, terms) for x, terms in zip(inputs.T, partition.principal, strict=True)]


def system_of(
    options: RuleOptions, partition: Partition, consequents: Array, names: tuple[str, ...]
) -> FuzzySystem:
    """Return the system of a partition with consequents (R, m)."""
    named: dict[str, Any] = {"input_names": names}
    if options.kind == "gt2":
        named |= {"reduction": options.reduction, "levels": options.levels}
    kind: Any = {"t1": Type1System, "it2": IntervalType2System, "gt2": GeneralType2System}
    system: FuzzySystem = kind[options.kind](partition.terms, partition.rules, consequents, **named)
    return system


def learned_systems(
    options: RuleOptions,
    places: Sequence[Place],
    names: tuple[str, ...],
    inputs: Array,
    outputs: Array,
    joints: int,
) -> tuple[FuzzySystem, ...]:
    """Return the systems of all rule bases, learned from inputs (N, p) and M, C and G (N, K)."""
    of_numbers = output_names(joints)
    return tuple(
        learned_system(
            options,
            np.ascontiguousarray(inputs[:, columns]),
            tuple(names[column] for column in columns),
            np.ascontiguousarray(outputs[:, said]),
        ).replace(output_names=tuple(of_numbers[j] for j in said))
        for columns, said in places
    )


def systems_from_motion(
    options: RuleOptions,
    places: Sequence[Place],
    inputs: LearningInputs,
    motion: tuple[Array, Array, Array],
    forces: Array,
    has_derived_coriolis: bool,
    positive_definite: bool,
) -> tuple[FuzzySystem, ...]:
    """Return the systems of all rule bases, learned from a motion (N, n) each and its forces."""
    positions, speeds, accelerations = motion
    n, x = positions.shape[1], inputs.of(positions, speeds)
    asked = [np.ascontiguousarray(x[:, place.columns]) for place in places]
    names = [tuple(inputs.names[column] for column in place.columns) for place in places]
    partitions = [
        partition_of(options, columns, said) for columns, said in zip(asked, names, strict=True)
    ]
    basis = [
        basis_of(partition, columns) for partition, columns in zip(partitions, asked, strict=True)
    ]
    slopes = None
    if has_derived_coriolis:
        along = slopes_of(partitions[0], asked[0])
        chosen = list(places[0].columns)
        slopes = np.zeros((*along.shape[:2], n))
        for sign, of_state in ((1.0, inputs.plus[chosen]), (-1.0, inputs.minus[chosen])):
            for column, place in enumerate(of_state):
                if 0 <= place < n:
                    slopes[..., place] += sign * along[..., column]
    found = learn_consequents(
        Samples(
            *(speeds, accelerations, forces, basis[0]),
            *(None if has_derived_coriolis else basis[-1], slopes),
        ),
        positive_definite,
    )
    numbers = np.zeros((max(len(b[0]) for b in basis), count_of_numbers(n)))
    of_mass, of_coriolis, of_gravity = (places_of(entries, n) for entries in "MCG")
    numbers[: len(found.mass), of_mass] = found.mass
    numbers[: len(found.gravity), of_gravity] = found.gravity
    if found.coriolis is not None:
        numbers[: len(found.coriolis), of_coriolis] = found.coriolis
    of_numbers = output_names(n)
    return tuple(
        system_of(options, partition, numbers[: len(partition.rules), place.outputs], said).replace(
            output_names=tuple(of_numbers[j] for j in place.outputs)
        )
        for partition, place, said in zip(partitions, places, names, strict=True)
    )


def fallback_of(systems: Sequence[FuzzySystem], places: Sequence[Place], joints: int) -> Array:
    """Return the averages over the rules, (K,); 0 for a C without rules."""
    fallback = np.zeros(count_of_numbers(joints))
    for system, place in zip(systems, places, strict=True):
        fallback[place.outputs] = np.asarray(system.consequents, dtype=float).mean(axis=0)
    return fallback


def principal_terms_of(system: FuzzySystem) -> tuple[Array, Array]:
    """Return means and standard deviations (R, q) of the type-1 terms of each rule."""
    return _numbers_of(system.inputs, np.asarray(system.rules))


def _numbers_of(inputs: Sequence[Sequence[Any]], rules: Indices) -> tuple[Array, Array]:
    numbers = np.array([[_mean_and_sigma(term) for term in terms] for terms in inputs])
    chosen = numbers[np.arange(rules.shape[1]), rules]
    return chosen[..., 0], chosen[..., 1]


def _mean_and_sigma(term: Any) -> tuple[float, float]:
    if isinstance(term, GaussianType2Set):
        term = term.principal
    return float(np.mean(term.mean)), float(term.sigma)


def kind_of(system: FuzzySystem, defuzzify: str) -> int:
    """Return the kind of a controller for the kernels, from the system of one of its bases."""
    if not isinstance(system, GeneralType2System):
        return kernels.INTERVAL
    if system.reduction == "gaussian":
        return kernels.COROLLARY
    return kernels.CENTROID if defuzzify == "last" else kernels.PLANES


def controller_table(
    systems: Sequence[FuzzySystem],
    places: Sequence[Place],
    inputs: LearningInputs,
    ranges: Array,
    joints: int,
    gains: tuple[float, float],
    outside: int,
    defuzzify: str,
    has_derived_coriolis: bool,
) -> kernels.Fuzzy:
    """Return a trained controller as compiled steps take it."""
    first = systems[0]
    kind, product, planes = kind_of(first, defuzzify), False, _NO_PLANES
    moments: list[Array] = []
    if isinstance(first, GeneralType2System):
        if kind == kernels.COROLLARY:
            product = first.grade_t_norm == "product"
        else:
            planes = np.stack([first.alphas, first.widths])
    bases, tables, size, begun = [float(len(systems))], [], 0, 0
    for system, place in zip(systems, places, strict=True):
        assert system.table is not None
        table = np.ravel(system.table)
        if kind == kernels.COROLLARY:
            table = _terms_and_rules(table)
        shape = len(system.rules), len(place.columns), len(place.outputs)
        bases += [size, table.size, begun, *shape, *place.columns, *place.outputs]
        tables.append(table)
        size += table.size
        if isinstance(system, GeneralType2System) and kind == kernels.COROLLARY:
            moments.append(np.ravel(np.stack(system.moments)))
            begun += moments[-1].size
    derived = np.empty(0)
    if has_derived_coriolis:
        columns, entries = list(places[0].columns), joints * (joints + 1) // 2
        means, sigmas = principal_terms_of(first)
        mass = np.asarray(first.consequents, dtype=float)[:, :entries]
        derived = christoffel_kernels.derived(
            np.array(columns), ranges[:, columns], means, sigmas, mass
        )
    arrays = (
        *(ranges, fallback_of(systems, places, joints), planes, np.concatenate(tables)),
        *(np.concatenate(moments) if moments else np.empty(0),),
        *(np.stack([inputs.plus, inputs.minus]), np.array(bases), derived),
    )
    return kernels.Fuzzy(
        *(kind, gains[0], gains[1], outside, int(product)),
        *(np.ascontiguousarray(array, dtype=np.float64) for array in arrays),
    )


def _terms_and_rules(table: Array) -> Array:
    """Return the part of a system's table that the corollary reads, without consequents.

    The moments contain the consequents already. With their ends, distances and orders they would
    fill most of the memory of a drive's controller.
    """
    inputs, terms, rules = (int(count) for count in table[:3])
    return table[: HEADER + TERM * terms + rules * inputs]


def write_derived_coriolis(
    controller: kernels.Fuzzy, inputs: Array, speeds: Array, numbers: Array
) -> None:
    """Write the C from M's derivative to its places in the numbers (K,)."""
    asked, rates = (np.array(row, dtype=np.float64) for row in (inputs, speeds))
    data = controller.derived
    room = np.empty(christoffel_kernels.christoffel_room(data, rates.size))
    christoffel_kernels.write_christoffel(data, controller.inputs, asked, rates, room, numbers)


def _widened(system: FuzzySystem, width: float) -> FuzzySystem:
    """Return the system with the standard deviations of its terms multiplied.

    Everything else is unchanged.
    """
    options: dict[str, Any] = {
        "input_names": system.input_names,
        "output_names": system.output_names,
        "term_names": system.term_names,
    }
    if isinstance(system, GeneralType2System):
        options |= {"reduction": system.reduction, "levels": system.levels}
    terms = [[_wider(term, width) for term in terms] for terms in system.inputs]
    return type(system)(terms, system.rules, system.consequents, system.t_norm, **options)


def _wider(term: Any, width: float) -> Any:
    if isinstance(term, GaussianType2Set):
        return GaussianType2Set(_wider(term.principal, width), term.sigma)
    return type(term)(term.mean, width * term.sigma)
