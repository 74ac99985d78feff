"""The readers of psp3, with what tells whether they read right.

Robots in URDF and MJCF are compared with what Python and MuJoCo read, by the tests of
:mod:`tests.cross`. Tables, arrays and documents are compared with what stands in the file.
"""

from __future__ import annotations

import csv
import functools
import io
import json
import os
import tempfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from psp3.description.loop_file import read_loops
from psp3.description.meshes import read_mesh
from psp3.description.parts import ROBOT_FILES
from psp3.description.srdf import excluded_by_srdf, reference_poses
from psp3.description.urdf import read_tree
from psp3.errors import PSP3Error
from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
from psp3.kinematics.pose_map import KinematicMap
from psp3.loading import load
from psp3.simulation.result import Result, load_result
from psp3.study import grid
from psp3.study.file import StudyFile
from psp3.study.run import METRICS, Run
from psp3.trajectories.motion import Motion
from psp3.trajectories.recorded import FromCSV
from tests.cross import test_mutated_mjcf, test_mutated_sdf, test_mutated_urdf
from tests.hostile import byte_mutants, json_mutants, npz_mutants, text_mutants, xml_mutants
from tests.hostile.mutant import SAME, Mutant
from tests.hostile.reader import Reader, Trial
from tests.hostile.text_mutants import Language

SEEDS = Path(__file__).parent / "seeds" / "psp3"

YAML = Language(
    (
        *("!!python/object/apply:os.system", "&a", "*a", "<<:", "2001-99-99", "!!int", "!!float x"),
        *("!!bool", "!!binary", "!!set", "!!omap", "? ", "---", "...", "%YAML 9.9", "|", ">"),
        *("{", "}", "[", "]", ":", "-", "~"),
    ),
    "# nothing",
    nested=("[", "]"),
)
TABLE = Language(
    (",", ";", "\t", '"', "1,0", "t", "x", "nan", "inf"), nested=('"', '"'), blanks=False
)
MESH = Language(
    ("v", "f", "vt", "usemtl", "facet", "endsolid", "vertex", "1//2", "-1", "0"), blanks=False
)
SRDF = Language(
    ("<joint/>", "<!--", "-->", "<![CDATA[", "&amp;", "<group_state>"),
    "<!-- nothing -->",
    nested=("<group>", "</group>"),
)

LOOPS = """\
closed_loop: [[tip, leg2_end], [other, body:base]]
type: [3d, hinge]
name_mot:
  - leg1_shoulder
  - leg2_shoulder
joint_name: [elbow]
joint_type: [spherical]
"""

SPLINE = "t,x,y,z\n0,0,0,0.1\n0.5,0.01,0.002,0.1\n1.0,0.02,0,0.11\n1.5,0.01,0.001,0.1\n2,0,0,0.1\n"
JOINTS = """\
t, a1,a2,a3 ,note
0,0.1,0.1,0.1,1
0.5,0.11,.1,0.1,1
1.0,1.2e-1,0.1,0.1,1
2.0,0.1,0.1,0.1,1
"""

OBJECT = (
    "# a tetrahedron\nv 0 0 0\nv 1 0 0\nv 0 1.5 0\nv 0 0 2\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
)

POSES = """\
<robot name="five_bar">
  <group_state name="home" group="all">
    <joint name="leg1_shoulder" value="-0.6"/>
    <joint name="leg1_elbow" value="1.464"/>
    <joint name="leg2_shoulder" value="0.6"/>
  </group_state>
  <group_state name="other" group="all"><joint name="leg2_elbow" value="-1.25"/></group_state>
  <disable_collisions link1="a" link2="b" reason="Never"/>
</robot>
"""


@dataclass(frozen=True)
class Crossed:
    """A reader whose mutants and second readings are those of the tests across engines."""

    name: str
    check: Callable[[int, Path], tuple[Mutant, str, str]]
    """Takes a number and a path; returns the mutant, the result and what is wrong."""

    def trial(self, number: int, path: Path) -> Trial:
        """Return what comes of the mutant of a number."""
        begun = sum(os.times()[:2])
        mutant, result, fault = self.check(number, path)
        return Trial(mutant, result, fault, sum(os.times()[:2]) - begun)


@functools.cache
def _root(text: str) -> ElementTree.Element:
    return ElementTree.fromstring(text)


def _mutant_of(text: str, number: int) -> Mutant:
    rng = np.random.default_rng([number, 77])
    if rng.random() < 0.15:
        return text_mutants.changed(text, SRDF, rng)._replace(number=number, claim="")
    return xml_mutants.mutant(_root(text), rng)._replace(number=number)


def _urdf(number: int, path: Path) -> tuple[Mutant, str, str]:
    names = list(test_mutated_urdf.FILES)
    mutant = _mutant_of(test_mutated_urdf.FILES[names[number % len(names)]], number)
    try:
        result = test_mutated_urdf.check(mutant, path.with_suffix(".urdf"))
        return mutant, "told" if result == "told and read" else result, ""
    except AssertionError as error:
        return mutant, "read", str(error)


def _mjcf(number: int, path: Path) -> tuple[Mutant, str, str]:
    mutant = _mutant_of(test_mutated_mjcf.FILE, number)
    was_read, fault = test_mutated_mjcf.check(mutant, path.with_suffix(".xml"))
    return mutant, "read" if was_read else "refused", fault


def _sdf(number: int, path: Path) -> tuple[Mutant, str, str]:
    what, content = test_mutated_sdf.mutant(number)
    with test_mutated_sdf.told_of() as told:
        result, fault = test_mutated_sdf.check(number, path.with_suffix(".sdf"), told)
    return Mutant(number, what, content), result, fault


def _loops(path: Path) -> str:
    return repr(read_loops(path))


@functools.cache
def _five_bar() -> Any:
    return read_tree(ROBOT_FILES / "five_bar.urdf")[0]


@functools.cache
def _three_psp() -> Any:
    return load("psp3")


def _poses(path: Path) -> str:
    poses = reference_poses(_five_bar().copy(), path)
    return repr({name: pose.tolist() for name, pose in poses.items()}) + repr(
        excluded_by_srdf(path)
    )


def _spline(path: Path) -> tuple[str, str]:
    motion = FromCSV(path, _three_psp())
    knots = motion._spline
    # The numbers of each row but the last, which the curve ends with.
    return motion.space, repr(np.column_stack([knots.x[:-1], knots.c[-1]]).tolist())


def second_table(content: bytes, value: tuple[str, str]) -> str:
    """Compare with the columns that a spreadsheet shows, where each is named once."""
    rows = [
        row for row in csv.reader(io.StringIO(content.decode("utf-8-sig"))) if "".join(row).strip()
    ]
    head = [name.strip() for name in rows[0]]
    columns = ("t", "x", "y", "z") if value[0] == "tip" else ("t", "a1", "a2", "a3")
    if any(head.count(name) != 1 for name in columns):
        return f"its columns are {head}"
    if any(len(row) != len(head) for row in rows):
        return "its rows are not of one length"
    theirs = [[float(row[head.index(name)]) for name in columns] for row in rows[1:-1]]
    ours = json.loads(value[1])
    if ours == theirs:
        return ""
    return f"there is {theirs}, and here is {ours}"


def _mesh(path: Path) -> str:
    mesh = read_mesh(path)
    return repr((mesh.vertices.tolist(), mesh.faces.tolist()))


def _binary_stl() -> bytes:
    corners = np.arange(36, dtype="<f4").reshape(4, 9) ** 1.5
    triangles = b"".join(bytes(12) + row.tobytes() + bytes(2) for row in corners)
    return b"binary".ljust(80) + (4).to_bytes(4, "little") + triangles


TEXT_STL = (
    "solid a\n"
    + "".join(
        f"facet normal 0 0 1\nouter loop\nvertex 0 {k} 0\nvertex 1.5 {k} 0\nvertex 0 {k} 1\n"
        "endloop\nendfacet\n"
        for k in range(3)
    )
    + "endsolid a\n"
)


@functools.cache
def _result() -> bytes:
    rng, n = np.random.default_rng(0), 6
    desired = Motion(*(rng.normal(size=(n, 3)) for _ in range(4)))
    arrays = (rng.normal(size=(n, 3)) for _ in range(4))
    positions, speeds, torque, tip = arrays
    result = Result(0.1 * np.arange(n), positions, speeds, desired, torque, tip)
    with tempfile.TemporaryDirectory() as folder:
        return result.save(Path(folder, "run.npz")).read_bytes()


def _arrays(path: Path) -> str:
    result = load_result(path)
    return repr(
        [
            np.asarray(one).tolist()
            for one in (*result.desired, *vars(result).values())
            if isinstance(one, np.ndarray)
        ]
    )


def _map(path: Path) -> str:
    read = KinematicMap.load(path)
    with tempfile.TemporaryDirectory() as folder:
        return read.save(Path(folder, "again.json")).read_text(encoding="utf-8")


def _controller(path: Path) -> str:
    read = FuzzyComputedTorque.load(path)
    with tempfile.TemporaryDirectory() as folder:
        return read.save(Path(folder, "again.json")).read_text(encoding="utf-8")


def second_document(content: bytes, value: str) -> str:
    """Look whether what was read says the same as the document."""
    given, read = json.loads(content.decode("utf-8-sig")), json.loads(value)
    return next(
        (found for name in given if (found := _other(given[name], read.get(name), f"$.{name}"))), ""
    )


def _other(given: Any, read: Any, path: str) -> str:
    if isinstance(given, dict) and isinstance(read, dict):
        return next(
            (
                found
                for name in given
                if (found := _other(given[name], read.get(name), f"{path}.{name}"))
            ),
            "",
        )
    if isinstance(given, list) and isinstance(read, list) and len(given) == len(read):
        pairs = enumerate(zip(given, read, strict=True))
        return next((found for k, pair in pairs if (found := _other(*pair, f"{path}[{k}]"))), "")
    if isinstance(given, int | float) and isinstance(read, int | float):
        return "" if float(given) == float(read) else f"{path} is {given}, and {read} was read"
    return "" if given == read else f"{path} is {given!r:.60}, and {read!r:.60} was read"


@functools.cache
def _study() -> bytes:
    """Return the file of a study whose metrics are invented."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "study.sqlite")
        with StudyFile(path, {"duration": Run().duration}).adding() as additions:
            runs = grid(controller=["t1", "pd"], snr_db=20.0, seed=range(4))
            additions.add(
                (run, {name: run.seed + 0.1 * k for k, name in enumerate(METRICS)}) for run in runs
            )
        return path.read_bytes()


def _rows(path: Path) -> str:
    with suppress(FileNotFoundError):
        path.with_name(f"{path.name}-journal").unlink()
    return repr([str(row) for row in StudyFile(path).rows()])


def _text(language: Language) -> Callable[[bytes, np.random.Generator], Mutant]:
    return lambda seed, rng: text_mutants.changed(seed.decode(), language, rng)


def _xml(seed: bytes, rng: np.random.Generator) -> Mutant:
    if rng.random() < 0.5:
        return text_mutants.changed(seed.decode(), SRDF, rng)
    return xml_mutants.mutant(_root(seed.decode()), rng)


def _untold(
    change: Callable[[bytes, np.random.Generator], Mutant],
) -> Callable[[bytes, np.random.Generator], Mutant]:
    """Return mutants that claim nothing but what has no meaning."""

    def changed(seed: bytes, rng: np.random.Generator) -> Mutant:
        mutant = change(seed, rng)
        return mutant if mutant.claim == SAME else mutant._replace(claim="")

    return changed


@functools.cache
def robot_readers() -> tuple[Reader | Crossed, ...]:
    """Return all readers of psp3."""
    one = functools.partial(Reader, refusals=PSP3Error)
    json_seed = {name: (SEEDS / f"{name}.json").read_bytes() for name in ("map", "controller")}
    return (
        Crossed("urdf", _urdf),
        Crossed("mjcf", _mjcf),
        Crossed("sdf", _sdf),
        one("loops", ".yaml", seeds=(LOOPS.encode(),), change=_untold(_text(YAML)), read=_loops),
        one("srdf", ".srdf", seeds=(POSES.encode(),), change=_xml, read=_poses),
        one(
            "csv",
            ".csv",
            seeds=(SPLINE.encode(), JOINTS.encode()),
            change=_untold(_text(TABLE)),
            read=_spline,
            second=second_table,
        ),
        one(
            "study",
            ".sqlite",
            seeds=(_study(),),
            # Rows, and what is said of all of them, have checksums.
            change=lambda seed, rng: byte_mutants.damaged(seed, rng, SAME),
            read=_rows,
        ),
        one("obj", ".obj", seeds=(OBJECT.encode(),), change=_untold(_text(MESH)), read=_mesh),
        one("stl", ".stl", seeds=(_binary_stl(),), change=byte_mutants.damaged, read=_mesh),
        one(
            "stl text", ".stl", seeds=(TEXT_STL.encode(),), change=_untold(_text(MESH)), read=_mesh
        ),
        one("result", ".npz", seeds=(_result(),), change=npz_mutants.changed, read=_arrays),
        one(
            "map",
            ".json",
            seeds=(json_seed["map"],),
            change=json_mutants.changed,
            read=_map,
            second=second_document,
        ),
        one(
            "controller",
            ".json",
            seeds=(json_seed["controller"],),
            change=json_mutants.changed,
            read=_controller,
            second=second_document,
        ),
    )
