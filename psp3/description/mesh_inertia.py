"""Compute volume and inertia of bodies whose surface is a mesh.

The body is divided into pyramids from its center to each triangle. Their volumes are signed, so
parts outside the body cancel. MuJoCo computes the inertia of a mesh in one of four ways, which the
attribute ``inertia`` of its asset ``mesh`` selects: ``exact`` as above; ``legacy`` with absolute
volumes, which is right for convex bodies only; ``convex`` for the convex hull; ``shell`` for a thin
sheet.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from psp3.checks import Array
from psp3.description.meshes import Mesh

KINDS = ("legacy", "exact", "convex", "shell")
"""The ways to compute the inertia of a mesh; the first is MuJoCo's default."""

LEAST_VOLUME = 1e-15
"""A volume [m³] or an area [m²] up to this counts as zero: MuJoCo's ``mjMINVAL``."""

LEAST_AREA = LEAST_VOLUME**0.5
"""Triangles up to this area have no direction [m²]."""


class MeshInertia(NamedTuple):
    """A homogeneous body of density one whose surface is a mesh."""

    volume: float
    """Its volume [m³]; for a shell, its area [m²]."""
    center: Array
    """Its center of mass, (3,) [m]."""
    inertia: Array
    """Its inertia about the center, (3, 3) [m⁵]; for a shell [m⁴]."""


def mesh_inertia(mesh: Mesh, kind: str) -> MeshInertia:
    r"""Return volume, center and inertia of a body whose surface is a mesh.

    With vertices :math:`a, b, c` of each triangle, seen from the center of the body, and the volume
    :math:`V_i = a \cdot (b \times c) / 6` of its pyramid, the second moments are

    .. math:: P = \sum_i \frac{V_i}{20} \big( s s^T + a a^T + b b^T + c c^T \big),
       \quad s = a + b + c,

    and the inertia is :math:`\mathrm{tr}(P)\,1 - P`. For a shell, :math:`V_i / 20` is replaced by
    the area of the triangle over 12.

    Parameters
    ----------
    mesh : Mesh
        The surface, counterclockwise seen from outside.
    kind : {"legacy", "exact", "convex", "shell"}
        The way to compute the inertia.

    Returns
    -------
    MeshInertia

    Raises
    ------
    ValueError
        If the surface has no volume, or its triangles point inward or are oriented inconsistently.
    """
    if kind == "convex":
        mesh = hull(mesh.vertices)
    if kind == "exact" and _is_inconsistent(mesh):
        raise ValueError("its triangles are not all oriented alike")
    corners = mesh.vertices[mesh.faces]
    doubled = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = 0.5 * np.linalg.norm(doubled, axis=1)
    if areas.sum() < LEAST_VOLUME:
        raise ValueError("its area is zero")
    centers = corners.mean(axis=1)
    middle = areas @ centers / areas.sum()
    if kind == "shell":
        center, volume = middle, float(areas.sum())
    else:
        parts = _pyramids(corners - middle, kind)
        volume = float(parts.sum())
        if volume < LEAST_VOLUME:
            raise ValueError(
                "its triangles are turned inside out" if volume < 0.0 else "its volume is zero"
            )
        center = parts @ (0.75 * centers + 0.25 * middle) / volume
    corners = corners - center
    # MuJoCo computes the volumes again about the center. For "legacy" this changes them.
    weights = areas / 12.0 if kind == "shell" else _pyramids(corners, kind) / 20.0
    volume = float(weights.sum()) * (12.0 if kind == "shell" else 20.0)
    sums = corners.sum(axis=1)
    moments = np.einsum("i,ij,ik->jk", weights, sums, sums) + np.einsum(
        "i,inj,ink->jk", weights, corners, corners
    )
    return MeshInertia(volume, center, np.trace(moments) * np.eye(3) - moments)


def _pyramids(corners: Array, kind: str) -> Array:
    """Return the signed volumes of the pyramids from the origin to triangles, (m,)."""
    volumes = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    return np.abs(volumes) if kind == "legacy" else np.asarray(volumes)


def hull(vertices: Array) -> Mesh:
    """Return the convex hull of points (n, 3); raise :class:`ValueError` if it has no volume."""
    try:
        found = ConvexHull(vertices)
    except QhullError:
        raise ValueError("its convex hull has no volume") from None
    corners = vertices[found.simplices]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inward = np.einsum("ij,ij->i", normals, found.equations[:, :3]) < 0.0
    faces = np.where(inward[:, np.newaxis], found.simplices[:, ::-1], found.simplices)
    return Mesh(vertices, faces)


def _is_inconsistent(mesh: Mesh) -> bool:
    """Tell whether two triangles traverse an edge in the same direction."""
    corners = mesh.vertices[mesh.faces]
    doubled = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    faces = mesh.faces[0.5 * np.linalg.norm(doubled, axis=1) > LEAST_AREA]
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    return len(np.unique(edges, axis=0)) < len(edges)
