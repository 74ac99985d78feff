"""Kernels of systems for one row of inputs, as exported code calls them.

Each kind of system is a NamedTuple of tables, for which a body of :func:`outputs_of` is registered.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from fuzzy2.support.checks import Array
from fuzzy2.support.compiled import chosen_by_table, scalar
from fuzzy2.systems.anya_kernels import densities_in
from fuzzy2.systems.corollary_kernels import corollary_in
from fuzzy2.systems.kernels import crisp_planes_in, evaluate_in, work_size
from fuzzy2.systems.monotonic_rows import Monotonics, points_in
from fuzzy2.systems.output_kernels import Points, average_in, points_room_size
from fuzzy2.systems.sampled_rows import Sampled, sample_in, sampled_room_size
from fuzzy2.systems.union_rows import Unions, room_size, unite_in


class Averaged(NamedTuple):
    """Exact center of sets; ``table`` is that of :mod:`fuzzy2.systems.kernels`."""

    table: Array


class Planes(NamedTuple):
    """Center of sets on the α-planes of one table, with half-widths and weights of the planes."""

    table: Array
    widths: Array
    alphas: Array


class Corollary(NamedTuple):
    """The Gaussian corollary: means and standard deviations of the consequents (R m,).

    ``product`` is 1 if secondary grades are combined by the product.
    """

    table: Array
    middles: Array
    spreads: Array
    product: int


class Pair(NamedTuple):
    """Two systems with the same inputs; the outputs of the first one come first."""

    first: Any
    second: Any
    outputs: int


class Nothing(NamedTuple):
    """No α-plane, with which the sum over the planes begins."""

    start: float


class Level(NamedTuple):
    """An α-plane that is a system of its own, with its weight, and the planes below it.

    ``is_lowest`` is 1 for the lowest plane.
    """

    below: Any
    system: Any
    share: float
    is_lowest: int


class Defaulted(NamedTuple):
    """A system with the default outputs ``defaults`` (m,), which are NaN for no default."""

    system: Any
    defaults: Array


class Clouds(NamedTuple):
    """Data clouds, one after the other; where each begins, and the clouds of the antecedents."""

    data: Array
    starts: Any
    asked: Any
    consequents: Any


@chosen_by_table
def outputs_of(system: Any, x: Array, out: Array) -> bool:
    """Write the outputs (m,) at finite inputs (p,); return whether there are outputs."""
    raise NotImplementedError


@chosen_by_table
def intervals_of(system: Any, x: Array, ends: Array) -> bool:
    """Write the type-reduced intervals (m, 2), flat; return whether there are outputs."""
    raise NotImplementedError


@scalar
def _finite(x: Array) -> bool:
    """Return whether all inputs are finite."""
    finite = True
    for i in range(x.size):
        finite = finite and math.isfinite(x[i])
    return finite


@scalar
def _nothing(out: Array) -> int:
    """Write NaN and return 0."""
    for j in range(out.size):
        out[j] = math.nan
    return 0


def answer(system, x, out):
    """Write the outputs and return 1, or write NaN and return 0 if an input is not finite."""
    if _finite(x) and outputs_of(system, x, out):
        return 1
    return _nothing(out)


def interval(system, x, ends):
    """Write the type-reduced intervals and return 1, or do as ``answer``."""
    if _finite(x) and intervals_of(system, x, ends):
        return 1
    return _nothing(ends)


@scalar
def _middles(ends: Array, out: Array) -> None:
    """Write the middles of intervals."""
    for j in range(out.size):
        out[j] = 0.5 * ends[2 * j] + 0.5 * ends[2 * j + 1]


@outputs_of.register(Averaged)
def _of_averaged(system, x, out):
    """Write the outputs of center of sets."""
    work = np.empty(work_size(system.table))
    evaluate_in(system.table, x, 0, 0.0, True, work, out, 0)
    return True


@intervals_of.register(Averaged)
def _ends_of_averaged(system, x, ends):
    """Write the ends of center of sets."""
    work = np.empty(work_size(system.table))
    evaluate_in(system.table, x, 0, 0.0, False, work, ends, 0)
    return True


@outputs_of.register(Planes)
def _of_planes(system, x, out):
    """Write the middles on the α-planes, weighted with α."""
    work, middles = np.empty(work_size(system.table)), np.empty(out.size)
    crisp_planes_in(system.table, x, 0, system.widths, system.alphas, work, middles, out, 0)
    return True


@intervals_of.register(Planes)
def _ends_of_planes(system, x, ends):
    """Write the ends on the lowest α-plane."""
    work = np.empty(work_size(system.table))
    evaluate_in(system.table, x, 0, system.widths[0], False, work, ends, 0)
    return True


@outputs_of.register(Corollary)
def _of_corollary(system, x, out):
    """Write the means of the Gaussian corollary."""
    work, moments = np.empty(work_size(system.table)), np.empty(2 * out.size)
    corollary_in(
        system.table, x, 0, system.middles, system.spreads, False, work, moments, 0
    )  # The outputs do not depend on the secondary t-norm.
    for j in range(out.size):
        out[j] = moments[2 * j]
    return True


@intervals_of.register(Corollary)
def _ends_of_corollary(system, x, ends):
    """Write means and standard deviations."""
    work, product = np.empty(work_size(system.table)), system.product == 1
    corollary_in(system.table, x, 0, system.middles, system.spreads, product, work, ends, 0)
    return True


@intervals_of.register(Points)
def _ends_of_points(system, x, ends):
    """Write the ends of averages of points."""
    work = np.empty(points_room_size(system))
    average_in(system, x, 0, work, ends, 0)
    return True


@outputs_of.register(Points)
def _of_points(system, x, out):
    """Write the middles of averages of points."""
    ends = np.empty(2 * out.size)
    intervals_of(system, x, ends)
    _middles(ends, out)
    return True


@intervals_of.register(Unions)
def _ends_of_unions(system, x, ends):
    """Write the ends of the centroids of unions, if the memory suffices for their pieces."""
    work, room = np.empty(work_size(system.table)), np.empty(room_size(system))
    return unite_in(system, x, 0, work, room, ends, 0)


@outputs_of.register(Unions)
def _of_unions(system, x, out):
    """Write the middles of the centroids of unions, if the memory suffices for their pieces."""
    ends = np.empty(2 * out.size)
    done = intervals_of(system, x, ends)
    _middles(ends, out)
    return done


@intervals_of.register(Sampled)
def _ends_of_sampled(system, x, ends):
    """Write the ends of the centroids of sampled unions."""
    work, room = np.empty(work_size(system.table)), np.empty(sampled_room_size(system))
    sample_in(system, x, 0, work, room, ends, 0)
    return True


@outputs_of.register(Sampled)
def _of_sampled(system, x, out):
    """Write the outputs of sampled unions."""
    ends = np.empty(2 * out.size)
    intervals_of(system, x, ends)
    _middles(ends, out)
    return True


@outputs_of.register(Monotonics)
def _of_monotonics(system, x, out):
    """Write Tsukamoto's averages."""
    work = np.empty(work_size(system.table))
    points_in(system, x, 0, work, out, 0)
    return True


@intervals_of.register(Monotonics)
def _ends_of_monotonics(system, x, ends):
    """Write Tsukamoto's averages as both ends."""
    out = np.empty(ends.size // 2)
    outputs_of(system, x, out)
    for j in range(out.size):
        ends[2 * j] = ends[2 * j + 1] = out[j]
    return True


@outputs_of.register(Pair)
def _of_pair(system, x, out):
    """Write the outputs of both systems."""
    first = outputs_of(system.first, x, out[: system.outputs])
    return outputs_of(system.second, x, out[system.outputs :]) and first


@intervals_of.register(Pair)
def _ends_of_pair(system, x, ends):
    """Write the ends of both systems."""
    first = intervals_of(system.first, x, ends[: 2 * system.outputs])
    return intervals_of(system.second, x, ends[2 * system.outputs :]) and first


@outputs_of.register(Nothing)
def _of_nothing(system, x, out):
    """Begin the sum over the α-planes."""
    for j in range(out.size):
        out[j] = system.start
    return x.size > 0


@outputs_of.register(Level)
def _of_level(system, x, out):
    """Add the outputs of an α-plane to those of the planes below it."""
    middles = np.empty(out.size)
    below = outputs_of(system.below, x, out)
    done = outputs_of(system.system, x, middles)
    for j in range(out.size):
        out[j] += system.share * middles[j]
    return below and done


@intervals_of.register(Level)
def _ends_of_level(system, x, ends):
    """Write the ends on the lowest α-plane."""
    if system.is_lowest == 0:
        return intervals_of(system.below, x, ends)
    return intervals_of(system.system, x, ends)


@outputs_of.register(Defaulted)
def _of_defaulted(system, x, out):
    """Write the outputs, or their defaults."""
    done = outputs_of(system.system, x, out)
    for j in range(out.size):
        if math.isnan(out[j]):
            out[j] = system.defaults[j]
    return done


@intervals_of.register(Defaulted)
def _ends_of_defaulted(system, x, ends):
    """Write the ends, or the default of an output without an answer on some α-plane."""
    out = np.empty(ends.size // 2)
    answered = outputs_of(system.system, x, out)
    done = intervals_of(system.system, x, ends)
    for j in range(out.size):
        if math.isnan(out[j]) and not math.isnan(system.defaults[j]):
            ends[2 * j] = ends[2 * j + 1] = system.defaults[j]
    return done and answered


@outputs_of.register(Clouds)
def _of_clouds(system, x, out):
    """Write the outputs of rules that depend on the density of clouds around the inputs."""
    away, firing = np.empty(x.size), np.empty(system.asked.size)
    densities_in(system.data, system.starts, system.asked, x, 0, away, firing, 0)
    return outputs_of(system.consequents, firing, out)


@intervals_of.register(Clouds)
def _ends_of_clouds(system, x, ends):
    """Write the ends of rules that depend on the density of clouds around the inputs."""
    away, firing = np.empty(x.size), np.empty(system.asked.size)
    densities_in(system.data, system.starts, system.asked, x, 0, away, firing, 0)
    return intervals_of(system.consequents, firing, ends)
