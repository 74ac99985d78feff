"""Mesh files of every format that is read, written here byte by byte, and what is refused."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from psp3.description.meshes import LARGEST_DRAWN, MOST_TRIANGLES, Mesh, not_opened, read_mesh
from psp3.errors import InvalidFile
from tests.helpers import Array

VERTICES = np.array([[0.0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def binary_stl(vertices: Array, faces: Array, header: bytes = b"") -> bytes:
    triangles = (
        struct.pack("<12fH", 0, 0, 0, *vertices[face].ravel(), 0) for face in np.asarray(faces)
    )
    return header.ljust(80) + struct.pack("<I", len(faces)) + b"".join(triangles)


def text_stl(vertices: Array, faces: Array) -> bytes:
    def facet(face: Array) -> str:
        corners = "".join("vertex {} {} {}\n".format(*vertices[corner]) for corner in face)
        return f"facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n"

    return f"solid part\n{''.join(map(facet, faces))}endsolid part\n".encode()


def obj(vertices: Array, faces: Array) -> bytes:
    places = "".join("v {} {} {}\n".format(*vertex) for vertex in vertices)
    corners = "".join(f"f {a + 1}/1/1 {b + 1}//2 {c - len(vertices)}\n" for a, b, c in faces)
    return f"# a comment\no part\n{places}vt 0 0\nvn 0 0 1\n{corners}".encode()


def msh(vertices: Array, faces: Array, normals: int = 4, textures: int = 4) -> bytes:
    return (
        struct.pack("<4i", len(vertices), normals, textures, len(faces))
        + vertices.astype("<f4").tobytes()
        + bytes(4 * (3 * normals + 2 * textures))
        + faces.astype("<i4").tobytes()
    )


FORMATS = {
    "part.stl": binary_stl(VERTICES, FACES),
    "text.STL": text_stl(VERTICES, FACES),
    "solid.stl": binary_stl(VERTICES, FACES, b"solid by a program that calls binary files so"),
    "part.obj": obj(VERTICES, FACES),
    "part.msh": msh(VERTICES, FACES),
    "bare.msh": msh(VERTICES, FACES, 0, 0),
}


def corners(mesh: Mesh) -> set[tuple[float, ...]]:
    """Return the triangles, each from its smallest corner on, whatever the order of vertices."""
    found = set()
    for face in mesh.faces:
        places = [tuple(mesh.vertices[corner]) for corner in face]
        first = places.index(min(places))
        found.add(sum(places[first:] + places[:first], ()))
    return found


@pytest.mark.parametrize("name", list(FORMATS))
def test_every_format_has_the_same_triangles(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_bytes(FORMATS[name])
    mesh = read_mesh(path)
    assert mesh.vertices.shape == (4, 3)
    assert corners(mesh) == corners(Mesh(VERTICES, FACES))


def test_a_polygon_is_cut_into_a_fan(tmp_path: Path) -> None:
    path = tmp_path / "square.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nf -4 -3 -2\n")
    assert_array_equal(read_mesh(path).faces, [[0, 1, 2], [0, 2, 3], [0, 1, 2]])


BAD = {
    "no.stl": (None, "no such file"),
    "part.dae": (b"", "is not a supported mesh file; these end in .stl, .obj, .msh"),
    "pointer.stl": (b"version https://git-lfs.github.com/spec/v1", "neither the text form nor"),
    "short.stl": (binary_stl(VERTICES, FACES)[:-1], "neither the text form nor"),
    "two.stl": (b"solid\nvertex 0 0 0\nvertex 1 0 0\n", "a triangle without three corners"),
    "word.stl": (b"solid\nvertex 0 0 x\n", "is not a valid STL file"),
    "empty.stl": (b"solid\nendsolid\n", "has no triangles"),
    "infinite.stl": (text_stl(np.full((3, 3), np.inf), np.array([[0, 1, 2]])), "not finite"),
    "empty.obj": (b"", "has no triangles"),
    "word.obj": (b"v 0 0 zero\n", "is not a valid OBJ file"),
    "beyond.obj": (b"v 0 0 0\nf 1 2 3\n", "refers to a vertex beyond its 1"),
    "flat.obj": (b"v 0 0\nv 1 0\nv 0 1\nf 1 2 3\n", "beyond its 2"),
    "short.msh": (b"1", "is not a valid MSH file"),
    "negative.msh": (struct.pack("<4i", -1, 0, 0, 0), "a negative count"),
    "long.msh": (msh(VERTICES, FACES) + b"1234", "its size does not match its counts"),
}


@pytest.mark.parametrize("name", list(BAD))
def test_what_is_wrong_is_said(tmp_path: Path, name: str) -> None:
    content, reason = BAD[name]
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InvalidFile) as caught:
        read_mesh(path)
    assert reason in caught.value.reason
    assert caught.value.path == path


def test_polygons_of_too_many_corners_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.obj"
    path.write_text("v 0 0 0\nf" + " 1" * (MOST_TRIANGLES + 1))
    with pytest.raises(InvalidFile, match="more than 1000000 triangles"):
        read_mesh(path)


def test_what_is_no_mesh_by_its_name_or_kind_is_not_opened(tmp_path: Path) -> None:
    (tmp_path / "there.STL").write_bytes(b"")
    (tmp_path / "folder.obj").mkdir()
    (tmp_path / "device.dae").symlink_to("/dev/zero")
    assert "no mesh's" in not_opened("/etc/passwd")
    assert "no mesh's" in not_opened("package://a/../../etc/passwd", [tmp_path])
    assert not_opened(str(tmp_path / "folder.obj")) == "is no file"
    assert not_opened(f"file://{tmp_path / 'device.dae'}") == "is no file"
    assert not_opened(str(tmp_path / "there.STL")) == ""
    assert not_opened("package://there.STL", [tmp_path / "folder.obj", tmp_path]) == ""
    assert not_opened("package://device.dae", [tmp_path]) == "is no file"
    assert not_opened("none.stl") == ""


def test_a_mesh_that_is_too_large_is_not_opened(tmp_path: Path) -> None:
    path = tmp_path / "large.stl"
    with path.open("wb") as file:
        file.truncate(LARGEST_DRAWN + 1)
    assert "larger than 256 MiB" in not_opened(str(path))
    with pytest.raises(InvalidFile, match="larger than 32 MiB"):
        read_mesh(path)
