"""Inertias of meshes in MJCF files are those that MuJoCo compiles.

Of every format that it reads, moved, turned, scaled and mirrored; and of no mesh that is not
needed.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from psp3.description.mesh_inertia import KINDS, hull
from psp3.description.mjcf import read_mjcf
from psp3.description.mujoco_opinion import mujoco_disagreements
from psp3.errors import InvalidRobotFile
from tests.cross.test_mjcf_files import INERTIA, assert_same, model, read
from tests.helpers import Array
from tests.psp3.description.test_meshes import binary_stl, msh, obj, text_stl

pytest.importorskip("mujoco", reason="MuJoCo is in the extras mujoco and test")

SOLID = hull(np.random.default_rng(3).uniform(-0.5, 1.5, (30, 3)).astype(np.float32).astype(float))

ROUNDED = 1e-8
"""MuJoCo's iteration for the principal axes of a mesh stops at 1e-9."""


def bare_obj(vertices: Array, faces: Array) -> bytes:
    """Return an OBJ of vertices and triangles alone: MuJoCo takes no others without textures."""
    lines = obj(vertices, faces).decode().splitlines()
    places = [line for line in lines if line.startswith("v ")]
    triangles = ["f {} {} {}".format(*(face + 1)) for face in faces]
    return "\n".join(places + triangles).encode()


FILES = {"part.stl": binary_stl, "part.obj": bare_obj, "part.msh": lambda v, f: msh(v, f, 0, 0)}
PLACES = [
    "",
    'scale=".1 .2 .3"',
    'scale=".1 -.2 .3"',
    'refpos=".1 .2 .3" refquat="1 .2 .3 .4" scale="-.1 .2 -.3"',
]


def of_mesh(asset: str, geom: str = "") -> str:
    return model(
        '<body name="a" pos="1 2 3"><joint axis="1 0 0"/><joint axis="0 1 0" pos="0 0 1"/><joint/>'
        f'<geom type="mesh" mesh="part" pos=".1 .2 .3" euler=".3 .2 .1" {geom}/>'
        '<geom size=".1" pos="1 0 0"/></body>',
        f"<asset>{asset}</asset>",
        compiler='angle="radian" meshdir="meshes"',
    )


def write(directory: Path, name: str) -> None:
    (directory / "meshes").mkdir()
    (directory / "meshes" / name).write_bytes(FILES[name](SOLID.vertices, SOLID.faces))


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("name", list(FILES))
def test_files_of_every_format(tmp_path: Path, name: str, place: str) -> None:
    write(tmp_path, name)
    assert_same(*read(tmp_path, of_mesh(f'<mesh file="{name}" {place}/>')), ROUNDED)
    assert mujoco_disagreements(tmp_path / "robot.xml") == []


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("geom", ["", 'density="20"', 'mass="3"'])
def test_every_kind(tmp_path: Path, kind: str, geom: str) -> None:
    write(tmp_path, "part.stl")
    assert_same(
        *read(tmp_path, of_mesh(f'<mesh file="part.stl" inertia="{kind}"/>', geom)), ROUNDED
    )


def test_vertices_in_the_file(tmp_path: Path) -> None:
    vertices = " ".join(f"{number:.9g}" for number in SOLID.vertices.ravel())
    faces = " ".join(str(corner) for corner in SOLID.faces.ravel())
    for more in ("", f'face="{faces}"'):
        text = of_mesh(f'<mesh name="part" vertex="{vertices}" {more}/>')
        assert_same(*read(tmp_path, text), ROUNDED)


def test_the_shell_of_a_geom(tmp_path: Path) -> None:
    """As files for older versions of MuJoCo say it: what is read is the shell of the mesh."""
    write(tmp_path, "part.stl")
    path = tmp_path / "robot.xml"
    path.write_text(of_mesh('<mesh file="part.stl"/>', 'shellinertia="true"'))
    found = read_mjcf(path, []).model.inertias[3]
    path.write_text(of_mesh('<mesh file="part.stl" inertia="shell"/>'))
    assert found.isApprox(read_mjcf(path, []).model.inertias[3], 1e-14)


def test_no_file_is_asked_of_what_has_an_inertia_or_cannot_move(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """A base without joints, and an arm with an inertia: both lack their meshes, and are told."""
    path = tmp_path / "robot.xml"
    geom = '<geom type="mesh" mesh="lost"/>'
    path.write_text(
        model(
            f'<body name="base">{geom}<body name="arm"><joint/>{INERTIA}{geom}</body></body>',
            '<asset><mesh file="lost.stl"/></asset>',
        )
    )
    assert read_mjcf(path, []).model.inertias[1].mass == 1.3
    assert "lost.stl cannot be read and is not drawn (no such file)" in caplog.text


@pytest.mark.parametrize(
    ("asset", "geom", "reason"),
    [
        ('<mesh file="part.stl"/>', "", "the inertia of mesh 'part' is needed, and cannot be"),
        ("", "", "<asset> has no mesh 'part'"),
        ('<mesh name="part" inertia="thin"/>', "", "must be one of legacy, exact, convex, shell"),
        ('<mesh name="part"/>', "", "neither a file nor the coordinates of four vertices"),
        ('<mesh name="part" vertex="0 0 0 1 0 0 0 1 0 1 1 0"/>', "", "has no volume"),
        ('<mesh name="part" vertex="0 0 0 1 0 0 0 1 0 0 0 1" face="0 1 9"/>', "", "below 4"),
        ('<mesh name="part" vertex="0 0 0 1 0 0 0 1 0 0 0 1" face="0 1 2"/>', "", "is zero"),
        ('<mesh name="part" vertex="0 0 0 1 0 0 0 1 0 0 0 1" refquat="0 0 0 0"/>', "", "direction"),
        ('<mesh name="part" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/>', 'mass="-1"', "negative mass"),
    ],
)
def test_what_is_wrong_is_said(tmp_path: Path, asset: str, geom: str, reason: str) -> None:
    path = tmp_path / "robot.xml"
    path.write_text(of_mesh(asset, geom))
    with pytest.raises(InvalidRobotFile) as caught:
        read_mjcf(path, [])
    assert reason in caught.value.reason


def test_a_text_file_is_read_that_mujoco_does_not_take(tmp_path: Path) -> None:
    """The other form of STL has the same inertia, and MuJoCo's refusal is told."""
    write(tmp_path, "part.stl")
    path = tmp_path / "robot.xml"
    path.write_text(of_mesh('<mesh file="part.stl"/>'))
    expected = read_mjcf(path, []).model.inertias[3]
    (tmp_path / "meshes" / "part.stl").write_bytes(text_stl(SOLID.vertices, SOLID.faces))
    assert read_mjcf(path, []).model.inertias[3].isApprox(expected, 1e-12)
    (told,) = mujoco_disagreements(path)
    assert told.what == "file"
    assert "STL" in str(told)
