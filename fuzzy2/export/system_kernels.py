"""Kernels of systems for one row of inputs, as exported code calls them.

Each kind of system is a NamedTuple of tables, and has its body of :func:`outputs_of`.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from fuzzy2.support.checks import Array
from fuzzy2.support.compiled import chosen_by_table
from fuzzy2.systems.corollary_kernels import corollary_in
from fuzzy2.systems.kernels import crisp_planes_in, evaluate_in, work_size


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


class Clouds(NamedTuple):
    """Clouds of data, one after the other, where each begins, and whom antecedents ask for."""

    data: Array
    starts: Any
    asked: Any
    consequents: Any


@chosen_by_table
def outputs_of(system: Any, x: Array, out: Array) -> None:
    """Write the outputs (m,) at finite inputs (p,)."""


def answer(system, x, out):
    """Write the outputs, or NaN where an input is not finite; return whether all are."""
    for i in range(x.size):
        if not math.isfinite(x[i]):
            for j in range(out.size):
                out[j] = math.nan
            return 0
    outputs_of(system, x, out)
    return 1


@outputs_of.register(Averaged)
def _of_averaged(system, x, out):
    """Write the outputs of center of sets."""
    work = np.empty(work_size(system.table))
    evaluate_in(system.table, x, 0, 0.0, True, work, out, 0)


@outputs_of.register(Planes)
def _of_planes(system, x, out):
    """Write the middles on the α-planes, weighted with α."""
    work, middles = np.empty(work_size(system.table)), np.empty(out.size)
    crisp_planes_in(system.table, x, 0, system.widths, system.alphas, work, middles, out, 0)


@outputs_of.register(Corollary)
def _of_corollary(system, x, out):
    """Write the means of the Gaussian corollary."""
    work, moments = np.empty(work_size(system.table)), np.empty(2 * int(system.table[3]))
    corollary_in(
        system.table, x, 0, system.middles, system.spreads, False, work, moments, 0
    )  # the outputs do not depend on the secondary t-norm
    for j in range(out.size):
        out[j] = moments[2 * j]


@outputs_of.register(Pair)
def _of_pair(system, x, out):
    """Write the outputs of both systems."""
    outputs_of(system.first, x, out[: system.outputs])
    outputs_of(system.second, x, out[system.outputs :])


@outputs_of.register(Clouds)
def _of_clouds(system, x, out):
    """Write the outputs of rules that ask how dense clouds are about the inputs."""
    firing = np.empty(system.asked.size)
    densities = np.empty(x.size)
    for i in range(x.size):
        start, end = system.starts[i], system.starts[i + 1]
        distance = 0.0
        for k in range(start, end):
            distance += abs(x[i] - system.data[k])
        densities[i] = 1.0 / (1.0 + distance / float(end - start))
    total = 0.0
    for r in range(system.asked.size):
        firing[r] = densities[system.asked[r]]
        total += firing[r]
    for r in range(system.asked.size):
        firing[r] /= total
    outputs_of(system.consequents, firing, out)
