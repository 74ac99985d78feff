"""Triangles of mesh files.

The formats are STL (binary and text), OBJ and MuJoCo's MSH.
"""

from __future__ import annotations

import itertools
import stat
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fuzzy2.support.bounded_files import content_of, not_read
from psp3.checks import Array, Indices
from psp3.errors import InvalidFile

STL_HEADER = 84
"""Bytes before the first triangle of a binary STL file."""

STL_TRIANGLE = np.dtype(
    [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")], align=False
)
"""The layout of a triangle in a binary STL file."""

READ_SUFFIXES = (".stl", ".obj", ".msh")
"""File name endings of meshes that are read."""

DRAWN_SUFFIXES = (*READ_SUFFIXES, ".dae", ".ply", ".off", ".3ds", ".gltf", ".glb", ".x", ".bvh")
"""File name endings of meshes that are drawn."""

LARGEST_MESH = 32 * 2**20
"""The largest mesh file whose inertia is computed [bytes]."""

LARGEST_DRAWN = 256 * 2**20
"""The largest mesh file that is drawn [bytes]."""

MOST_TRIANGLES = 1_000_000
"""The largest number of triangles of a mesh whose inertia is computed."""


class Mesh(NamedTuple):
    """A surface of triangles."""

    vertices: Array
    """Its vertices, (n, 3) [m, in the scale of the file]."""
    faces: Indices
    """The vertices of each triangle, (m, 3), counterclockwise seen from outside."""


def read_mesh(path: Path) -> Mesh:
    """Return the triangles of a mesh file.

    Parameters
    ----------
    path : path
        The file; the ending of its name, in upper or lower case, gives its format.

    Returns
    -------
    Mesh
        Its vertices and triangles. Polygons with more corners are cut into triangles.

    Raises
    ------
    InvalidFile
        If the file is missing, of another format, malformed, or has a vertex that is not finite.
    """
    suffix = path.suffix.lower()
    if suffix not in READ_SUFFIXES:
        raise InvalidFile(
            path, f"is not a supported mesh file; these end in {', '.join(READ_SUFFIXES)}"
        )
    try:
        content = content_of(path, LARGEST_MESH)
    except OSError as error:
        raise InvalidFile(path, not_read(error)) from error
    try:
        mesh = {".stl": _stl, ".obj": _obj, ".msh": _msh}[suffix](content)
    except (ValueError, IndexError, OverflowError) as error:
        raise InvalidFile(path, f"is not a valid {suffix[1:].upper()} file ({error})") from error
    if not len(mesh.faces):
        raise InvalidFile(path, "has no triangles")
    if not np.isfinite(mesh.vertices).all():
        raise InvalidFile(path, "has a vertex that is not finite")
    if mesh.faces.min() < 0 or mesh.faces.max() >= len(mesh.vertices):
        raise InvalidFile(
            path, f"has a triangle that refers to a vertex beyond its {len(mesh.vertices)}"
        )
    return mesh


def not_opened(name: str, folders: Iterable[Path] = ()) -> str:
    """Return why a mesh that a robot file names must not be opened; an empty text if it may be.

    A robot file may name any file of the machine. A file is opened only if its ending is that of a
    mesh, it is a regular file and it is not too large. A missing file is reported by the reader of
    the mesh.

    Parameters
    ----------
    name : str
        The path of the file, or its ``package://`` or ``file://`` address.
    folders : iterable of path
        Folders in which packages are searched.
    """
    scheme, is_address, rest = name.partition("://")
    path = Path(rest if is_address else name)
    if path.suffix.lower() not in DRAWN_SUFFIXES:
        return f"its name is no mesh's; those end in {', '.join(DRAWN_SUFFIXES)}"
    for folder in folders if is_address and scheme != "file" else [Path()]:
        try:
            status = (folder / path).stat()
        except (OSError, ValueError):
            continue
        if not stat.S_ISREG(status.st_mode):
            return "is no file"
        if status.st_size > LARGEST_DRAWN:
            return f"is larger than {LARGEST_DRAWN // 2**20} MiB"
        return ""
    return ""


def _stl(content: bytes) -> Mesh:
    if len(content) >= STL_HEADER:
        # The text form begins with "solid", but so do some binary files: their size decides.
        count = int.from_bytes(content[STL_HEADER - 4 : STL_HEADER], "little")
        if len(content) == STL_HEADER + count * STL_TRIANGLE.itemsize:
            corners = np.frombuffer(content, STL_TRIANGLE, count, STL_HEADER)["corners"]
            return _joined(corners.astype(float).reshape(-1, 3))
    if not content.lstrip().startswith(b"solid"):
        raise ValueError("neither the text form nor the size of the binary one")
    words = content.split()
    texts = [
        [float(number) for number in words[at + 1 : at + 4]]
        for at, word in enumerate(words)
        if word == b"vertex"
    ]
    return _joined(np.array(texts, dtype=float).reshape(-1, 3))


def _joined(corners: Array) -> Mesh:
    """Return triangles from rows of corners, three each; equal corners become one vertex."""
    if len(corners) % 3:
        raise ValueError("a triangle without three corners")
    vertices, faces = np.unique(corners, axis=0, return_inverse=True)
    return Mesh(vertices, faces.reshape(-1, 3).astype(np.int64))


def _obj(content: bytes) -> Mesh:
    vertices: list[list[float]] = []
    faces: list[list[int]] = []
    for line in content.decode("utf-8", "replace").splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append([float(number) for number in words[1:4]])
        elif words[:1] == ["f"]:
            # A corner is vertex/texture/normal; numbers count from one, or backward from the last
            # if negative.
            corners = [int(word.split("/")[0]) for word in words[1:]]
            places = [at - 1 if at > 0 else len(vertices) + at for at in corners]
            if len(faces) + len(places) > MOST_TRIANGLES:
                raise ValueError(f"more than {MOST_TRIANGLES} triangles")
            faces += [[places[0], *pair] for pair in itertools.pairwise(places[1:])]
    return Mesh(
        # In single precision, as rendering engines store it.
        np.array(vertices, dtype=np.float32).astype(float).reshape(-1, 3),
        np.array(faces, dtype=np.int64).reshape(-1, 3),
    )


def _msh(content: bytes) -> Mesh:
    vertices, normals, textures, faces = (int(n) for n in np.frombuffer(content, "<i4", 4))
    if min(vertices, normals, textures, faces) < 0:
        raise ValueError("a negative count")
    numbers = 3 * vertices + 3 * normals + 2 * textures
    if len(content) != 16 + 4 * (numbers + 3 * faces):
        raise ValueError("its size does not match its counts")
    places = np.frombuffer(content, "<f4", 3 * vertices, 16).astype(float)
    corners = np.frombuffer(content, "<i4", 3 * faces, 16 + 4 * numbers).astype(np.int64)
    return Mesh(places.reshape(-1, 3), corners.reshape(-1, 3))
