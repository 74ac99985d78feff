r"""The forces of a motion as a linear function of the rules' consequents for M, C and G.

At a state each rule base weights its rules with basis functions :math:`\phi_r` that add up to 1,
and

.. math:: \tau = \sum_r \phi_r \left(M_r \ddot a + C_r \dot a + G_r\right)
          = Y(a, \dot a, \ddot a)\, c,

with the consequents c of all rules. M is symmetric, and c contains its upper triangle. If C is the
derivative of M (:mod:`psp3.fuzzy_control.christoffel_kernels`), it has no consequents of its own,
and

.. math:: C \dot a = \sum_r \Big( (\nabla \phi_r \cdot \dot a)\, M_r \dot a
          - \tfrac12 \nabla \phi_r\; \dot a^T M_r \dot a \Big).

Adaptive control (:mod:`psp3.fuzzy_control.slotine_li`) multiplies C with speeds v that differ from
the speeds C depends on,

.. math:: C v = \tfrac12 \sum_r \Big( (\nabla \phi_r \cdot \dot a)\, M_r v
          + (\nabla \phi_r \cdot v)\, M_r \dot a - \nabla \phi_r\; \dot a^T M_r v \Big).
"""

from __future__ import annotations

import numpy as np

from psp3.checks import Array


def mass_columns(phi: Array, accelerations: Array) -> Array:
    """Return the columns of M's consequents, (N, n, R, n (n + 1) / 2).

    ``phi`` are basis functions (N, R), accelerations (N, n).
    """
    n = accelerations.shape[1]
    return np.asarray(phi[:, np.newaxis, :, np.newaxis] * _times_symmetric(accelerations, n))


def coriolis_columns(phi: Array, speeds: Array) -> Array:
    """Return the columns of C's consequents, row by row, (N, n, R, n²)."""
    n = speeds.shape[1]
    rows = np.einsum("ij,sk->sijk", np.eye(n), speeds).reshape(len(speeds), n, n * n)
    return np.asarray(phi[:, np.newaxis, :, np.newaxis] * rows[:, :, np.newaxis, :])


def gravity_columns(phi: Array, joints: int) -> Array:
    """Return the columns of G's consequents, (N, n, R, n)."""
    return np.asarray(phi[:, np.newaxis, :, np.newaxis] * np.eye(joints)[:, np.newaxis, :])


def derived_coriolis_columns(
    slopes: Array, speeds: Array, multiplied: Array | None = None
) -> Array:
    """Return the forces of the C that is derived from M, as columns of M's consequents.

    ``slopes`` (N, R, n) are those of the basis functions along the positions, and ``multiplied``
    (N, n) is the vector that C multiplies, by default the speeds; the columns are those of M, (N,
    n, R, n (n + 1) / 2).
    """
    n = speeds.shape[1]
    others = speeds if multiplied is None else multiplied
    moved, moved_others = (_times_symmetric(v, n)[:, :, 0] for v in (speeds, others))
    energy = np.einsum("si,sie->se", others, moved)
    along, along_others = (np.einsum("srk,sk->sr", slopes, v) for v in (speeds, others))
    rise = np.einsum("sr,sie->sire", along, moved_others)
    turn = np.einsum("sr,sie->sire", along_others, moved)
    return np.asarray(0.5 * (rise + turn - np.einsum("sri,se->sire", slopes, energy)))


def _times_symmetric(vectors: Array, joints: int) -> Array:
    """Return the matrices (N, n, 1, n (n + 1) / 2) from upper triangles of M to M v."""
    first, second = np.triu_indices(joints)
    entries = np.arange(len(first))
    out = np.zeros((len(vectors), joints, 1, len(first)))
    out[:, first, 0, entries] = vectors[:, second]
    out[:, second, 0, entries] = vectors[:, first]
    return out
