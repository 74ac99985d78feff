"""Kernels of systems for one row of inputs, as exported code calls them.

Each kind of system is a NamedTuple of tables, and has its body of :func:`outputs_of`.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from fuzzy2.support.checks import Array
from fuzzy2.support.compiled import chosen_by_table
from fuzzy2.systems.anya_kernels import densities_in
from fuzzy2.systems.corollary_kernels import corollary_in
from fuzzy2.systems.kernels import crisp_planes_in, evaluate_in, work_size
from fuzzy2.systems.output_kernels import Points, average_in
from fuzzy2.systems.union_rows import Unions, room_size, unite_in


class Averaged(NamedTuple):
    """Center of sets, exactly: ``table`` as :mod:`fuzzy2.systems.kernels` takes it."""

    table: Array


class Planes(NamedTuple):
    """The same on the α-planes of one table: half-widths and weights of each."""

    table: Array
    widths: Array
    alphas: Array


class Corollary(NamedTuple):
    """The Gaussian corollary: means and standard deviations of the consequents (R m,)."""

    table: Array
    middles: Array
    spreads: Array


class Pair(NamedTuple):
    """Two systems of the same inputs, the outputs of the first one first."""

    first: Any
    second: Any
    outputs: int


class Nothing(NamedTuple):
    """No α-plane at all: sums begin with it."""

    start: float


class Level(NamedTuple):
    """An α-plane that is a system of its own, with its share in the outputs, and those below it.

    ``defaults`` (m,) are its outputs where no rule fires; NaN for none.
    """

    below: Any
    system: Any
    share: float
    defaults: Array


class Clouds(NamedTuple):
    """Clouds of data, one after the other, where each begins, and whom antecedents ask for."""

    data: Array
    starts: Any
    asked: Any
    consequents: Any


@chosen_by_table
def outputs_of(system: Any, x: Array, out: Array) -> bool:
    """Write the outputs (m,) at finite inputs (p,); return whether there are any."""
    raise NotImplementedError


def answer(system, x, out):
    """Write the outputs and return 1, or NaN and 0 where an input is not finite."""
    finite = True
    for i in range(x.size):
        finite = finite and math.isfinite(x[i])
    if finite and outputs_of(system, x, out):
        return 1
    for j in range(out.size):
        out[j] = math.nan
    return 0


@outputs_of.register(Averaged)
def _of_averaged(system, x, out):
    """Write the outputs of center of sets."""
    work = np.empty(work_size(system.table))
    evaluate_in(system.table, x, 0, 0.0, True, work, out, 0)
    return True


@outputs_of.register(Planes)
def _of_planes(system, x, out):
    """Write the middles on the α-planes, weighted with α."""
    work, middles = np.empty(work_size(system.table)), np.empty(out.size)
    crisp_planes_in(system.table, x, 0, system.widths, system.alphas, work, middles, out, 0)
    return True


@outputs_of.register(Corollary)
def _of_corollary(system, x, out):
    """Write the means of the Gaussian corollary."""
    work, moments = np.empty(work_size(system.table)), np.empty(2 * int(system.table[3]))
    corollary_in(
        system.table, x, 0, system.middles, system.spreads, False, work, moments, 0
    )  # the outputs do not depend on the secondary t-norm
    for j in range(out.size):
        out[j] = moments[2 * j]
    return True


@outputs_of.register(Points)
def _of_points(system, x, out):
    """Write the middles of averages of points."""
    work, intervals = np.empty(work_size(system.table)), np.empty(2 * out.size)
    average_in(system, x, 0, work, intervals, 0)
    for j in range(out.size):
        out[j] = 0.5 * intervals[2 * j] + 0.5 * intervals[2 * j + 1]
    return True


@outputs_of.register(Unions)
def _of_unions(system, x, out):
    """Write the middles of centroids of united sets, if there is room for their pieces."""
    work, room = np.empty(work_size(system.table)), np.empty(room_size(system))
    intervals = np.empty(2 * out.size)
    done = unite_in(system, x, 0, work, room, intervals, 0)
    for j in range(out.size):
        out[j] = 0.5 * intervals[2 * j] + 0.5 * intervals[2 * j + 1]
    return done


@outputs_of.register(Pair)
def _of_pair(system, x, out):
    """Write the outputs of both systems."""
    first = outputs_of(system.first, x, out[: system.outputs])
    return outputs_of(system.second, x, out[system.outputs :]) and first


@outputs_of.register(Nothing)
def _of_nothing(system, x, out):
    """Begin a sum."""
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
        middle = system.defaults[j] if math.isnan(middles[j]) else middles[j]
        out[j] += system.share * middle
    return below and done


@outputs_of.register(Clouds)
def _of_clouds(system, x, out):
    """Write the outputs of rules that ask how dense clouds are about the inputs."""
    away, firing = np.empty(x.size), np.empty(system.asked.size)
    densities_in(system.data, system.starts, system.asked, x, 0, away, firing, 0)
    return outputs_of(system.consequents, firing, out)
