"""Inertia of bodies whose surface is a mesh: solids whose inertia is a formula, and MuJoCo."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial import ConvexHull

from psp3.description.mesh_inertia import KINDS, hull, mesh_inertia
from psp3.description.meshes import Mesh
from tests.helpers import Array

SIDES = np.array([0.4, 0.6, 1.0])


def box(sides: Array = SIDES, center: tuple[float, float, float] = (0.3, -0.2, 0.5)) -> Mesh:
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    return hull(center + 0.5 * sides * signs)


@pytest.mark.parametrize("kind", ["legacy", "exact", "convex"])
def test_a_box(kind: str) -> None:
    """To rounding of a dozen triangles."""
    volume, center, inertia = mesh_inertia(box(), kind)
    squares = SIDES**2
    assert volume == pytest.approx(SIDES.prod(), rel=1e-14)
    assert_allclose(center, [0.3, -0.2, 0.5], rtol=0, atol=1e-14)
    expected = np.diag(volume / 12.0 * (squares.sum() - squares))
    assert_allclose(inertia, expected, rtol=0, atol=1e-14)


def test_a_shell() -> None:
    """Of a box: six plates, each moved from its own center."""
    area, center, inertia = mesh_inertia(box(), "shell")
    expected = np.zeros(3)
    for axis in range(3):
        plate = SIDES.copy()
        plate[axis] = 0.0
        one = np.delete(SIDES, axis).prod()
        moved = 0.25 * SIDES[axis] ** 2 * (np.arange(3) != axis)
        expected += 2.0 * one * ((plate**2).sum() - plate**2) / 12.0 + 2.0 * one * moved
    assert area == pytest.approx(2.0 * (0.24 + 0.4 + 0.6), rel=1e-14)
    assert_allclose(center, [0.3, -0.2, 0.5], rtol=0, atol=1e-14)
    assert_allclose(inertia, np.diag(expected), rtol=0, atol=1e-14)


def test_a_hollow_is_taken_out_of_an_exact_body_alone() -> None:
    """A box in a box, turned inside out: exactly their difference, and of the hull the outer one.

    MuJoCo's way of before counts both as solid.
    """
    outer, inner = box(), box(0.5 * SIDES, (0.35, -0.2, 0.5))
    both = Mesh(
        np.concatenate([outer.vertices, inner.vertices]),
        np.concatenate([outer.faces, inner.faces[:, ::-1] + len(outer.vertices)]),
    )
    whole, part = (mesh_inertia(one, "exact") for one in (outer, inner))
    exact = mesh_inertia(both, "exact")
    assert exact.volume == pytest.approx(whole.volume - part.volume, rel=1e-13)
    assert_allclose(
        exact.volume * exact.center,
        whole.volume * whole.center - part.volume * part.center,
        rtol=0,
        atol=1e-14,
    )

    def about_origin(one: object) -> Array:
        volume, center, inertia = one  # type: ignore[misc]
        return np.asarray(
            inertia + volume * (center @ center * np.eye(3) - np.outer(center, center))
        )

    assert_allclose(
        about_origin(exact), about_origin(whole) - about_origin(part), rtol=0, atol=1e-14
    )
    assert mesh_inertia(both, "convex").volume == pytest.approx(whole.volume, rel=1e-13)
    legacy = mesh_inertia(both, "legacy").volume
    assert legacy == pytest.approx(whole.volume + part.volume, rel=1e-13)


def test_a_hull_is_turned_outward() -> None:
    points = np.random.default_rng(0).normal(size=(60, 3))
    mesh = hull(points)
    assert mesh_inertia(mesh, "exact").volume == pytest.approx(ConvexHull(points).volume, rel=1e-12)


def test_what_has_no_inertia_is_said() -> None:
    mesh = box()
    inside_out = Mesh(mesh.vertices, mesh.faces[:, ::-1])
    with pytest.raises(ValueError, match="turned inside out"):
        mesh_inertia(inside_out, "exact")
    one_wrong = mesh.faces.copy()
    one_wrong[0] = one_wrong[0, ::-1]
    with pytest.raises(ValueError, match="not all oriented alike"):
        mesh_inertia(Mesh(mesh.vertices, one_wrong), "exact")
    flat = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
    for kind in ("legacy", "exact"):
        with pytest.raises(ValueError, match="volume is zero"):
            mesh_inertia(flat, kind)
    with pytest.raises(ValueError, match="hull has no volume"):
        mesh_inertia(flat, "convex")
    point = Mesh(np.zeros((3, 3)), np.array([[0, 1, 2]]))
    with pytest.raises(ValueError, match="area is zero"):
        mesh_inertia(point, "shell")


@pytest.mark.parametrize("kind", KINDS)
def test_mujoco_computes_the_same(kind: str) -> None:
    """A body that is not convex, in MuJoCo's single precision of vertices; to 1e-12.

    The inertia to 1e-8: MuJoCo's iteration for the principal axes stops at 1e-9.
    """
    mujoco = pytest.importorskip("mujoco", reason="MuJoCo is in the extras mujoco and test")
    # A box whose top is pressed in to a funnel.
    mesh = box()
    vertices = (
        np.concatenate([mesh.vertices, [[0.32, -0.17, 0.6]]]).astype(np.float32).astype(float)
    )
    top = [index for index, z in enumerate(mesh.vertices[:, 2]) if z > 0.9]
    faces = [list(face) for face in mesh.faces if not set(face) <= set(top)]
    ring = [top[0], top[2], top[3], top[1]]
    faces += [[one, other, 8] for one, other in zip(ring, ring[1:] + ring[:1], strict=True)]
    places = " ".join(map(repr, vertices.ravel().tolist()))
    asset = (
        f'<mesh name="m" inertia="{kind}" vertex="{places}" '
        f'face="{" ".join(str(corner) for face in faces for corner in face)}"/>'
    )
    engine = mujoco.MjModel.from_xml_string(
        f'<mujoco><asset>{asset}</asset><worldbody><body><freejoint/><geom type="mesh" mesh="m" '
        'density="2"/></body></worldbody></mujoco>'
    )
    volume, center, inertia = mesh_inertia(Mesh(vertices, np.array(faces)), kind)
    assert 2.0 * volume == pytest.approx(engine.body_mass[1], rel=1e-12)
    assert_allclose(center, engine.body_ipos[1], rtol=0, atol=1e-12)
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, engine.body_iquat[1])
    axes = turn.reshape(3, 3)
    expected = axes @ np.diag(engine.body_inertia[1]) @ axes.T
    assert_allclose(2.0 * inertia, expected, rtol=0, atol=1e-8 * inertia.max())
