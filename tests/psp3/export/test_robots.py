"""Robots in C answer as the core does: every number to the last bit, refusals and NaN alike.

Both sides run the same operations in the same order, and the C library is the same, so nothing may
differ. Some hundred states are asked, or ten thousand with ``make export-states``, before a
release.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
import pytest

import fuzzy2
import psp3
from fuzzy2.errors import InvalidValue as Fuzzy2InvalidValue
from fuzzy2.errors import NotExportable
from fuzzy2.export.c_code import CCode
from fuzzy2.export.systems import c_code_of
from psp3.errors import InvalidValue, UnknownName
from psp3.export.face import c_code
from psp3.export.robots import FUNCTIONS
from psp3.kinematics.task_driven import TaskDrivenRobot
from psp3.multibody import motion
from psp3.multibody.closing import MOST_ATTEMPTS, MOST_ITERATIONS
from psp3.multibody.core import Core
from psp3.multibody.tree import AT_BEFORE, AT_REPORT
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from psp3.robots.stepping import DrivenTables, forces_of_all, forces_of_first
from tests.c_code import (
    BEFORE_A_RELEASE,
    PRECISIONS,
    STATES,
    Library,
    checked_at_run_time,
    compiled,
    functions_of,
    same,
    warnings_of,
)
from tests.helpers import Array
from tests.project_folder import check_statically, needs_c, needs_clang, needs_cppcheck
from tests.psp3.export.robots_of_all_kinds import MAKERS, States, some_frames

pytestmark = pytest.mark.slow


class Beside:
    """A robot's core beside its C code, each with a memory of its own."""

    def __init__(self, robot: Any, library: Library, frames: list[str]) -> None:
        self.robot, self.library, self.core = robot, library, robot._core
        self.last = self.core.last_pose()
        self.n, self.nq = len(robot.coordinates_v), robot.model.nq
        self.frames = [(frame, re.sub(r"\W", "_", frame)) for frame in frames]
        self.table = robot.compiled_table()
        tree = self.core.tree
        self.pose, self.report = int(tree[AT_BEFORE]), int(tree[AT_REPORT])

    def reset(self) -> None:
        """Begin with the reference pose on both sides."""
        self.library.call("reset")
        self.last.forget()

    def differences(self, q: Array, v: Array, a: Array) -> list[str]:
        """Return the functions that answer otherwise."""
        n, still = self.n, np.zeros(self.n)
        square = 2 * n * n + n
        asked: list[tuple[str, int, int, tuple[Any, Any], tuple[Any, ...], Any]] = [
            ("inverse_dynamics", motion.INVERSE_DYNAMICS, n, (v, a), (v, a), slice(None)),
            ("forward_dynamics", motion.FORWARD_DYNAMICS, n, (v, a), (v, a), slice(None)),
            ("configuration", motion.CONFIGURATION, self.nq, (v, a), (), slice(None)),
            ("equation_of_motion", motion.EQUATION_OF_MOTION, square, (v, v), (v,), slice(None)),
            ("mass_matrix", motion.EQUATION_OF_MOTION, square, (still,) * 2, (), slice(n * n)),
        ]
        columns = np.arange(6 * n).reshape(n, 6).T.ravel()
        for frame, prefix in self.frames:
            numbers = (still, self.robot.frame_table(frame))
            for what, part in (("placement", slice(12)), ("jacobian", 12 + columns)):
                asked.append((f"{prefix}_{what}", motion.FRAME, 12 + 6 * n, numbers, (), part))
        found = []
        for name, question, width, others, arguments, part in asked:
            out = np.empty(width)
            is_answered = self.core.ask_one(question, q, *others, out, self.last)
            right = 0 if is_answered else int(self.last.memory[self.report + 3])
            code, written = self.library.call(name, q, *arguments)
            if not self._is_right(code, np.concatenate(written), right, out[part]):
                found.append(f"{name}: {code}, and {right}")
        if isinstance(self.table, DrivenTables):
            found += self._motors(q, v, a)
        return found

    def _is_right(self, code: int, written: Array, right: int, out: Array) -> bool:
        memory, report = self.library.part("memory"), self.library.part("report")
        if code != right:
            return False
        if code == 0:
            remembered = same(memory[: self.pose], self.last.memory[: self.pose])
            return remembered and same(written, out)
        open_by = self.last.memory[self.report : self.report + 3]
        return bool(np.isnan(written).all()) and (code != 1 or same(report, open_by))

    def _motors(self, q: Array, v: Array, a: Array) -> list[str]:
        """Compare the motors' forces with those that compiled loops tell the motors."""
        commanded, forces = self.robot.commanded, np.empty(len(self.robot.actuated))
        table, memory = self.table, self.library.part("memory")
        start = memory if self.library.part("closed")[0] == 1 else self.core._reference
        table.memory[: self.pose] = start[: self.pose]
        asked, kernel = (a, forces_of_all)
        if commanded < self.n:
            asked, kernel = a[:commanded].copy(), forces_of_first
        is_done = kernel(table, q, v, asked, forces)
        code, (written,) = self.library.call("actuator_forces", q, v, asked)
        # The core has not been asked, and goes on from where the code is.
        self.last.memory[: self.pose] = memory[: self.pose]
        self.last.is_closed = int(self.library.part("closed")[0])
        right = same(written, forces) if is_done else bool(np.isnan(written).all())
        return [] if right and (code == 0) == is_done else [f"actuator_forces: {code}"]


class Built(NamedTuple):
    """A robot, and its code in double precision, compiled."""

    robot: Any
    code: CCode
    library: Path


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Built]:
    """Return a function that makes a robot and compiles its code, once."""

    @functools.cache
    def build(name: str) -> Built:
        folder = tmp_path_factory.mktemp(name)
        robot = MAKERS[name](folder)
        code = c_code(robot, name=name, frames=some_frames(robot))
        return Built(robot, code, compiled(code, folder))

    return build


@pytest.mark.parametrize("name", MAKERS)
def test_every_number_is_the_same(name: str, built: Any) -> None:
    robot, code, library = built(name)
    beside = Beside(robot, Library(code, library), some_frames(robot))
    states, codes = States(robot), set()
    for count in range(STATES):
        if count % 5 == 0:
            beside.reset()
        q, v, a = states.next()
        assert not beside.differences(q, v, a), (count, q, v, a)
        codes.add(beside.library.call("configuration", q)[0])
        beside.reset()
    # Some of the states are none.
    assert 0 in codes
    assert codes != {0}


WITH_EVERY_FUNCTION = ("over_actuated", "gripper")
"""Robots whose code has, together, every function that is in any robot's: cppcheck reads it."""


def test_some_robots_have_every_function(built: Any) -> None:
    functions = {name: functions_of(built(name).code) for name in MAKERS}
    every = set().union(*functions.values())
    assert len(every) > 80
    assert every == set().union(*(functions[name] for name in WITH_EVERY_FUNCTION))


@needs_c
@needs_clang
@needs_cppcheck
@pytest.mark.parametrize("name", MAKERS)
def test_compilers_sanitizers_and_cppcheck_have_nothing_to_say(
    name: str, built: Any, tmp_path: Path
) -> None:
    """No address that is not its own, nothing undefined, no warning, also at NaN and far away.

    What gcc warns of when it optimizes would fail the tests that compare numbers, here and in
    ``test_single.py``. The code of single precision differs in its types and literals alone: of it
    clang tells what it warns of, and it runs under the sanitizers before a release. Then cppcheck
    reads the code of all robots, and else that of those which have every function.
    """
    robot = built(name).robot
    single = c_code(robot, name=name, precision="single", frames=some_frames(robot))
    single.write(tmp_path / "single")
    assert warnings_of("clang", tmp_path / "single") == ""
    for code in (built(name).code, single)[: len(PRECISIONS)]:
        folder = tmp_path / f"run_{code.precision.name}"
        checked_at_run_time(code, folder, "clang", {"positions": robot.reference}, 30)
        if name in WITH_EVERY_FUNCTION or BEFORE_A_RELEASE:
            code.write(folder / "code")
            check_statically(folder / "code")


def test_the_functions_of_the_class_are_the_same(tmp_path: Path) -> None:
    """What users call in Python, with the last pose as guess, and without."""
    robot, rng = psp3.load("delta"), np.random.default_rng(3)
    code = psp3.export_c(robot, tmp_path, frames=["tip"], name="delta")
    library, last = Library(code, compiled(code, tmp_path)), robot.last_pose()
    assert (tmp_path / "delta.c").read_text(encoding="utf-8") == code.source
    library.call("reset")
    for _ in range(50):
        q = robot.reference + 0.05 * rng.normal(size=3)
        v, a = rng.normal(size=3), rng.normal(size=3)
        _, (forces,) = library.call("inverse_dynamics", q, v, a)
        assert same(forces, robot.inverse_dynamics(q, v, a, guess=last))
        library.call("reset")
        assert same(library.call("mass_matrix", q)[1][0], robot.mass_matrix(q))
        library.call("reset")
        _, (placement,) = library.call("tip_placement", q)
        right = robot.frame_placement(q, "tip")
        assert same(placement, np.concatenate([right[:3, :3].ravel(), right[:3, 3]]))
        library.call("reset")
        _, (jacobian,) = library.call("tip_jacobian", q)
        assert same(jacobian, robot.frame_jacobian(q, "tip"))
        library.call("reset")
        library.call("inverse_dynamics", q, v, a)
        last.forget()
        robot.inverse_dynamics(q, v, a, guess=last)


def test_motors_get_the_forces_that_python_says(tmp_path: Path) -> None:
    """Of least norm: NumPy's pseudo-inverse, to rounding of matrices whose condition is below 1e3.

    Forces are some N, so 1e-9 N is a thousand times what rounding makes of them.
    """
    robot, rng = psp3.load("planar_4rrr"), np.random.default_rng(4)
    code = c_code(robot, name="planar_4rrr")
    library = Library(code, compiled(code, tmp_path))
    for _ in range(50):
        q = robot.reference + 0.05 * rng.normal(size=robot.reference.size)
        v, a = rng.normal(size=q.size), rng.normal(size=q.size)
        library.call("reset")
        done, (forces,) = library.call("actuator_forces", q, v, a)
        assert done == 0
        right = robot.actuator_forces(q, v, a)
        np.testing.assert_allclose(forces, right, rtol=1e-9, atol=1e-9)


def test_the_same_functions_run_in_python(tmp_path: Path) -> None:
    """Whoever writes cases for the code has the right values there."""
    robot = psp3.load("five_bar")
    code = c_code(robot, name="five_bar", frames=["tip"])
    library, rng = Library(code, compiled(code, tmp_path)), np.random.default_rng(0)
    parts = {part.name: part for one in code.functions for part in one.arguments}
    state = [
        np.zeros(int(part.size or 1), dtype=np.int64 if part.is_whole else float)
        for part in parts.values()
        if part.role == "state"
    ]
    code.functions[0].in_python(*state)
    library.call("reset")
    for function in code.functions[1:]:
        given = [
            (robot.reference if one.name == "positions" else 0.0) + 0.1 * rng.normal(size=one.size)
            for one in function.visible
            if one.role == "in"
        ]
        out = [np.zeros(int(one.size or 1)) for one in function.visible if one.role == "out"]
        became = function.in_python(*state, *given, *out)
        name = function.name.removeprefix("five_bar_")
        right, written = library.call(name, *given)
        assert became == right == 0
        assert same(np.concatenate(written), np.concatenate(out)), name


def test_fewer_attempts_end_sooner_and_say_how_far_they_came(tmp_path: Path) -> None:
    robot = psp3.load("five_bar")
    code = c_code(robot, name="five_bar", most_attempts=1)
    assert f"no call takes more than {MOST_ITERATIONS} of them" in code.header
    library = Library(code, compiled(code, tmp_path))
    library.call("reset")
    near, far = robot.reference + 0.1, robot.reference + np.array([0.5, 0.4])
    done, (q,) = library.call("configuration", near)
    assert done == 0
    assert same(q, robot.configuration(near))
    done, (q,) = library.call("configuration", far)
    assert done == 1
    assert np.isnan(q).all()
    share, residual, group = library.part("report")
    assert 0.0 < share < 1.0
    assert residual > 1e-3
    assert group == 0.0
    # It begins with the reference pose again.
    assert library.call("configuration", near)[0] == 0
    assert f"{MOST_ATTEMPTS} parts of the way" in c_code(robot).header
    with pytest.raises(InvalidValue, match="most_attempts"):
        c_code(robot, most_attempts=0)


def test_what_is_not_asked_for_takes_no_memory(tmp_path: Path) -> None:
    """Numbers in the struct of the 6-UPS: 853 of the pose, and what comes and goes."""
    robot, sizes = psp3.load("gough_stewart"), []
    q, zeros = robot.reference + 0.01, np.zeros(6)
    some = (["configuration"], ["inverse_dynamics"], ["forward_dynamics"], None)
    for count, functions in enumerate(some):
        code = c_code(robot, name=f"g{count}", functions=functions)
        library = Library(code, compiled(code, tmp_path))
        sizes.append(library.part("memory").size)
        library.call("reset")
        if functions is None or functions == ["inverse_dynamics"]:
            _, (forces,) = library.call("inverse_dynamics", q, zeros, zeros)
            assert same(forces, robot.inverse_dynamics(q, zeros, zeros))
    assert sizes == sorted(sizes)
    assert sizes[1] < 0.4 * robot._core.size
    assert [one.name for one in c_code(robot, functions=["configuration"]).functions] == [
        "gough_stewart_reset",
        "gough_stewart_configuration",
    ]


def test_the_header_says_what_stands_where() -> None:
    robot = psp3.load("biped")
    header = c_code(robot, frames=["tip"] if robot.model.existFrame("tip") else []).header
    for name in (*robot.coordinates, *robot.actuated, *list(robot.model.names)[1:]):
        assert name in header
    assert "free fall is (0.0, 0.0, -9.81) m/s²" in header
    assert "quaternion (x, y, z, w)" in header
    assert f"written by psp3 {psp3.__version__}" in header
    assert re.search(r"\b[0-9a-f]{16} is its hash", header)
    for code in range(6):
        assert re.search(rf"^ \* {code}  ", header, re.M), code


def _words(header: str) -> str:
    """Return the comments of a header in one line."""
    return " ".join(re.sub(r"^ \* ", "", header, flags=re.M).split())


def _listed(header: str, title: str) -> list[str]:
    """Return the names below a title of the header, in order; their numbers count from 0."""
    found = re.search(rf"^ \* {title}:\n((?: \* +\d+  .*\n)+)", header, re.M)
    if found is None:
        return []
    rows = [re.fullmatch(r" \* +(\d+)  (.*)", line) for line in found[1].splitlines()]
    assert [int(row[1]) for row in rows if row] == list(range(len(rows)))
    return [row[2] for row in rows if row]


@pytest.mark.parametrize("name", MAKERS)
def test_lists_of_the_header_are_the_order_and_size_of_arrays(name: str, built: Any) -> None:
    """Also of robots with fewer motors than coordinates, or more, and of those that float."""
    robot, code, compiled_code = built(name)
    sizes = dict(re.findall(r"(\w+)\[(\d+)\](?=[,)])", code.header))
    positions = _listed(code.header, "Positions of coordinates")
    speeds = _listed(code.header, "Speeds, accelerations and forces") or positions
    joints = _listed(code.header, "Coordinates of all joints, q")
    motors = _listed(code.header, "Motors") or speeds
    of = {"positions": positions, "speeds": speeds, "forces": speeds, "q": joints}
    of |= {"motor_forces": motors} if "motor_forces" in sizes else {}
    assert {one: int(sizes[one]) for one in of} == {one: len(names) for one, names in of.items()}
    assert [int(sizes[one]) for one in "MCGJ"] == [
        *(len(speeds) ** 2,) * 2,
        len(speeds),
        6 * len(speeds),
    ]
    asked = re.findall(r"const double accelerations\[(\d+)\]", code.header)
    commanded = len(speeds) if robot.drives_coordinates else robot.commanded
    assert {int(count) for count in asked} == {len(speeds), commanded}
    # Each position is where the lists say that it is among the coordinates of all joints.
    library, states = Library(code, compiled_code), States(robot)
    for _ in range(20):
        q, _, _ = states.next()
        library.call("reset")
        done, (written,) = library.call("configuration", q)
        if done == 0:
            assert same(written[[joints.index(one) for one in positions]], q)


def test_speeds_of_a_floating_base_are_those_that_the_header_says(tmp_path: Path) -> None:
    """Linear, then angular, in its own axes: the columns of its Jacobian are those of R."""
    robot = MAKERS["biped"](tmp_path)
    base = robot.coordinates[-1]
    code = c_code(robot, name="biped", frames=[base])
    told = f"{base}: position, then quaternion (x, y, z, w) of unit length; its speeds are linear, "
    assert told + "then angular, in its own axes" in _words(code.header)
    library, q = Library(code, compiled(code, tmp_path)), robot.reference.copy()
    # Turned by 0.6 rad about an axis between x and y.
    q[-7:] = [0.3, -0.2, 1.0, *(np.sin(0.3) * np.array([0.6, 0.8, 0.0])), np.cos(0.3)]
    library.call("reset")
    done, (placement,) = library.call(f"{base}_placement", q)
    _, (J,) = library.call(f"{base}_jacobian", q)
    R, J = placement[:9].reshape(3, 3), J.reshape(6, -1)
    assert done == 0
    start = robot.model.jointPlacements[robot.model.getJointId(base)]
    np.testing.assert_array_equal(start.rotation, np.eye(3))
    np.testing.assert_allclose(placement[9:], start.translation + q[-7:-4], rtol=0.0, atol=1e-15)
    right = pin.Quaternion(q[-4:]).matrix()
    # Sums of a few numbers about 1: some roundings.
    np.testing.assert_allclose(R, right, rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(J[:3, -6:-3], R, rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(J[3:, -3:], R, rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(J[3:, -6:-3], 0.0, rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(J[:3, -3:], 0.0, rtol=0.0, atol=1e-15)


def test_balls_are_told_as_quaternions(tmp_path: Path) -> None:
    header = _words(c_code(MAKERS["hexa"](tmp_path)).header)
    assert ": quaternion (x, y, z, w) of unit length; its speeds are angular" in header
    assert "What they are" not in c_code(MAKERS["five_bar"](tmp_path)).header


def test_fuzzy_systems_are_written_as_fuzzy2_does() -> None:
    """Here as there, so that one name writes all; and what is none of these is refused."""
    terms = [[fuzzy2.Gaussian(m, 0.5) for m in (-1.0, 1.0)]]
    system = fuzzy2.Type1System(terms, [[0], [1]], [[1.0], [2.0]])
    assert c_code(system, name="rules").source == c_code_of(system, name="rules").source
    with pytest.raises(NotExportable, match="a robot, a controller"):
        c_code(3.0)


def test_gravity_is_that_of_the_model(tmp_path: Path) -> None:
    robot = psp3.load("five_bar")
    robot.model.gravity.linear = np.array([1.0, 2.0, 3.0])
    code = c_code(robot, name="five_bar")
    library, zeros = Library(code, compiled(code, tmp_path)), np.zeros(2)
    library.call("reset")
    robot.model.gravity.linear = np.array([1.0, 2.0, 3.0])
    _, (forces,) = library.call("inverse_dynamics", robot.reference, zeros, zeros)
    assert same(forces, robot.inverse_dynamics(robot.reference, zeros, zeros))


def test_what_cannot_be_written_is_refused() -> None:
    class Heavier(ClosedLoopRobot):
        """A robot with dynamics of its own."""

    robot = psp3.load("five_bar")
    heavier = Heavier(robot.model, robot.constraint_models, robot.actuated, robot.q0)
    for thing in (heavier, TaskDrivenRobot(robot, "tip", ("x", "z"))):
        with pytest.raises(NotExportable, match="of the same parts"):
            c_code(thing)
    with pytest.raises(UnknownName, match="frame"):
        c_code(robot, frames=["nose"])
    with pytest.raises(InvalidValue, match="name"):
        c_code(robot, name=b"arm")  # type: ignore[arg-type]
    for name in ("", "my arm", "3-PSP", "int"):
        with pytest.raises(Fuzzy2InvalidValue, match="a letter first, no word of C"):
            c_code(robot, name=name)
    with pytest.raises(UnknownName, match="inverse_dynamics"):
        c_code(robot, functions=["dynamics"])
    with pytest.raises(InvalidValue, match="functions"):
        c_code(robot, functions=[])
    with pytest.raises(NotExportable, match="another one is tip in C"):
        c_code(robot, frames=["tip", "tip"])
    assert set(FUNCTIONS) >= {"inverse_dynamics", "jacobian"}
    assert isinstance(robot._core, Core)
