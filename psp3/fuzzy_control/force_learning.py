r"""Learn rules for M, C and G from forces, which can be measured, unlike M, C and G themselves.

The consequents c of all rules minimize

.. math:: \sum_{n, i} \frac{(\tau_{ni} - Y_{ni} c)^2}{\langle \tau_i^2 \rangle}
          + \lambda\, \lVert D\,(c - \bar c) \rVert^2,

with Y from :mod:`psp3.fuzzy_control.force_regressor`. :math:`\bar c` is the best fit to the forces
with one M and C for all rules and a separate G for each. If no sample determines the M and C of a
rule, the rule takes those of :math:`\bar c`. D weights changes of M, C and G by their average
forces, and :math:`\lambda` is chosen by generalized cross-validation
(:mod:`fuzzy2.learning.cross_validation`).

For a long motion, Y and the forces are reduced block by block to a triangular factor, which has the
same minimum. So all samples count, and none must be kept.

**Positive definite M.** For every type of fuzzy system, a fuzzy average of positive definite
matrices is positive definite, so M is positive definite if the M of every rule is. This can be
required: the minimum is then over consequents with :math:`M_r \succeq \mu I`, where :math:`\mu` is
a share of the least eigenvalue of the M of :math:`\bar c`. This problem is convex, and the
alternating direction method of multipliers solves it (S. Boyd, N. Parikh, E. Chu, B. Peleato and J.
Eckstein, "Distributed optimization and statistical learning via the alternating direction method of
multipliers", Foundations and Trends in Machine Learning 3(1), 2011). Without the requirement only
the average over the rules is certain to be positive definite, and it replaces an estimate that is
not.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from fuzzy2.learning.cross_validation import ridge_by_cross_validation
from psp3.checks import Array
from psp3.errors import UnusableEstimate
from psp3.fuzzy_control import force_regressor as regressor

BLOCK = 1024
"""Number of samples that are added to the triangular factor at a time."""

LEAST_SHARE = 0.05
"""Least eigenvalue of a rule's M, as a share of that of the common M of all rules."""

ITERATIONS = 5000
"""Most iterations of the constrained problem; a few hundred are typical."""

TOLERANCE = 1e-9
"""The constrained problem is solved at this change and violation, relative to the consequents."""


class Samples(NamedTuple):
    """The data that rules are learned from, sample by sample.

    ``speeds``, ``accelerations`` and ``forces`` (N, n); basis functions ``of_mass`` (N, R) of the
    rules for M and G and ``of_coriolis`` (N, S) of those for C, or None; ``slopes`` (N, R, n) of
    the first along the positions if C is the derivative of M, otherwise None.
    """

    speeds: Array
    accelerations: Array
    forces: Array
    of_mass: Array
    of_coriolis: Array | None
    slopes: Array | None


class Consequents(NamedTuple):
    """The rules' upper triangles of M (R, n (n + 1) / 2), G (R, n), and C (S, n²) or None."""

    mass: Array
    gravity: Array
    coriolis: Array | None


def regressor_blocks(samples: Samples) -> list[Array]:
    """Return the columns of M's, G's and C's consequents, (N, n, rules, numbers) each."""
    n = samples.speeds.shape[1]
    mass = regressor.mass_columns(samples.of_mass, samples.accelerations)
    if samples.slopes is not None:
        mass = mass + regressor.derived_coriolis_columns(samples.slopes, samples.speeds)
    blocks = [mass, regressor.gravity_columns(samples.of_mass, n)]
    if samples.of_coriolis is not None:
        blocks.append(regressor.coriolis_columns(samples.of_coriolis, samples.speeds))
    return blocks


def learn_consequents(samples: Samples, positive_definite: bool) -> Consequents:
    """Return the consequents that explain the forces best.

    Raises
    ------
    UnusableEstimate
        If a positive definite M is required, and the common M of all rules is not positive
        definite.
    """
    count, n = samples.forces.size, samples.forces.shape[1]
    design, targets, shapes = _reduced(samples)
    ends = np.cumsum([rules * numbers for rules, numbers in shapes])
    blocks = [
        block.reshape(len(design), *shape)
        for block, shape in zip(np.split(design, ends[:-1], axis=1), shapes, strict=True)
    ]
    one, scales = _one_model(blocks, targets, count, n)
    prior = np.concatenate([consequents.ravel() for consequents in one])
    weights = np.concatenate(
        [np.tile(scale, rules) for scale, (rules, _) in zip(scales, shapes, strict=True)]
    )
    left_over = targets - (design @ prior)[:, np.newaxis]
    scaled = design / weights
    moved, ridges = ridge_by_cross_validation(scaled, left_over, count)
    found = prior + moved[:, 0] / weights
    if positive_definite:
        least = LEAST_SHARE * _least_eigenvalue(one[0], n)
        if not least > 0.0:
            raise UnusableEstimate(_matrices(one[0][:1], n)[0], _told_apart(samples))
        problem = scaled, left_over[:, 0], float(ridges[0]), prior, weights
        found = _within(*problem, shapes[0], n, least, found)
    parts = [
        part.reshape(shape) for part, shape in zip(np.split(found, ends[:-1]), shapes, strict=True)
    ]
    return Consequents(parts[0], parts[1], parts[2] if len(parts) > 2 else None)


def _told_apart(samples: Samples) -> float:
    """Return the part of the accelerations that is not a function of the positions.

    It is the residual of least squares on the basis functions, so rules for G cannot explain it.
    """
    w = samples.accelerations
    left = w - samples.of_mass @ np.linalg.lstsq(samples.of_mass, w, rcond=None)[0]
    return float(np.linalg.norm(left) / (np.linalg.norm(w) or 1.0))


def _reduced(samples: Samples) -> tuple[Array, Array, list[tuple[int, ...]]]:
    """Return Y and forces, of mean square 1, as a triangular factor, and the shapes of Y's blocks.

    Each block of columns has rules and numbers.
    """
    sizes = np.sqrt((samples.forces**2).mean(axis=0))
    sizes = np.where(sizes > 0.0, sizes, 1.0)
    factor: Array | None = None
    shapes: list[tuple[int, ...]] = []
    for start in range(0, len(samples.forces), BLOCK):
        block = slice(start, start + BLOCK)
        some = samples._replace(
            **{name: a[block] for name, a in samples._asdict().items() if a is not None}
        )
        parts, measured = regressor_blocks(some), (some.forces / sizes).ravel()
        shapes = [part.shape[2:] for part in parts]
        columns = [part / sizes[:, np.newaxis, np.newaxis] for part in parts]
        rows = np.concatenate(
            [*(c.reshape(measured.size, -1) for c in columns), measured[:, np.newaxis]], axis=1
        )
        grown = rows if factor is None else np.concatenate([factor, rows])
        factor = np.asarray(np.linalg.qr(grown, mode="r"))
    assert factor is not None
    return factor[:, :-1], factor[:, -1:], shapes


def _one_model(
    blocks: Sequence[Array], targets: Array, count: int, joints: int
) -> tuple[list[Array], list[Array]]:
    """Return the consequents (rules, numbers) of each block with common M and C, and scales.

    The scale of a change of M, C or G is the root mean square of its force.
    """
    scales, parts = [], []
    for place, block in enumerate(blocks):
        columns = block.sum(axis=1)
        # Off-diagonal entries of M occur twice in the matrix.
        twice = _twice(joints) if place == 0 else np.ones(columns.shape[1])
        scales.append((np.sqrt((columns**2).sum() / (count * columns.shape[1])) or 1.0) * twice)
        # G varies more with the pose than M and C, so each rule has its own G.
        own = [columns, block.reshape(len(targets), -1)] if place == 1 else [columns]
        both = np.concatenate(own, axis=1)
        parts.append(both / np.resize(scales[-1], both.shape[1]))
    found = ridge_by_cross_validation(np.concatenate(parts, axis=1), targets, count)[0][:, 0]
    ends = np.cumsum([part.shape[1] for part in parts])
    one = []
    for part, scale, block in zip(np.split(found, ends[:-1]), scales, blocks, strict=True):
        consequents = part.reshape(-1, len(scale)) / scale
        if len(consequents) > 1:
            # The mean G of all rules, and the difference of each rule.
            consequents = consequents[0] + consequents[1:]
        one.append(np.broadcast_to(consequents, block.shape[1:]))
    return one, scales


def _twice(joints: int) -> Array:
    """Return √2 for the off-diagonal entries of an upper triangle, and 1 for the diagonal."""
    first, second = np.triu_indices(joints)
    return np.where(first == second, 1.0, np.sqrt(2.0))


def _within(
    design: Array,
    targets: Array,
    ridge: float,
    prior: Array,
    weights: Array,
    shape: tuple[int, ...],
    joints: int,
    least: float,
    unconstrained: Array,
) -> Array:
    """Return the minimum over consequents whose M's have eigenvalues of at least ``least``."""
    count = shape[0] * shape[1]
    mass = unconstrained[:count].reshape(shape)
    if np.linalg.eigvalsh(_matrices(mass, joints)).min() >= least:
        return unconstrained
    # With these scaled changes, the distance of two M's is that over all entries of the matrices.
    gram = design.T @ design
    values, vectors = np.linalg.eigh(gram + ridge * np.eye(len(prior)))
    right, penalty = design.T @ targets, float(np.sqrt(values[0] * values[-1]))
    x = weights * (unconstrained - prior)
    z, dual = x.copy(), np.zeros_like(x)
    for _ in range(ITERATIONS):
        pull = vectors.T @ (right + penalty * (z - dual))
        x = vectors @ (pull / (values + penalty))
        last, z = z, x + dual
        mass = (prior + z / weights)[:count].reshape(shape)
        projected = _raised(mass, joints, least)
        z = z.copy()
        z[:count] = (weights * (np.concatenate([projected.ravel(), prior[count:]]) - prior))[:count]
        dual += x - z
        size = TOLERANCE * max(float(np.linalg.norm(z)), 1e-300)
        if np.linalg.norm(x - z) <= size and np.linalg.norm(z - last) <= size:
            break
    return np.asarray(prior + z / weights)


def _raised(triangles: Array, joints: int, least: float) -> Array:
    """Return the nearest upper triangles (R, k) of matrices with eigenvalues of at least that."""
    values, vectors = np.linalg.eigh(_matrices(triangles, joints))
    raised = (vectors * np.maximum(values, least)[:, np.newaxis]) @ np.swapaxes(vectors, -1, -2)
    return np.asarray(raised[:, *np.triu_indices(joints)])


def _matrices(triangles: Array, joints: int) -> Array:
    """Return the symmetric matrices (R, n, n) of upper triangles (R, n (n + 1) / 2)."""
    first, second = np.triu_indices(joints)
    out = np.empty((len(triangles), joints, joints))
    out[:, first, second] = out[:, second, first] = triangles
    return out


def _least_eigenvalue(triangles: Array, joints: int) -> float:
    return float(np.linalg.eigvalsh(_matrices(triangles, joints)).min())
