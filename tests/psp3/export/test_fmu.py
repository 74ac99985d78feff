"""FMUs, in FMPy: a program for FMUs that knows nothing of this package.

Numbers are compared without a tolerance: the C code does the operations of the compiled loop in the
same order, and the sine, cosine and square root of Python and of the compiler are those of one
library.
"""

from __future__ import annotations

import math
import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest

import fuzzy2
import psp3
from psp3.control.default_gains import default_gains
from psp3.errors import InvalidValue, SourceOnlyFMU, UnknownName
from psp3.export import fmu
from psp3.export.fmu import export_fmu
from psp3.simulation.runge_kutta import RungeKutta
from tests.project_folder import check_statically, needs_cppcheck
from tests.psp3.export.controllers_of_all_kinds import CLASSICAL, OPTIONS, trained
from tests.psp3.export.fmu_in_fmpy import PERIOD, VERSIONS, Control, Plant
from tests.psp3.export.robots_of_all_kinds import MAKERS

ROOT = Path(__file__).resolve().parents[3]
ROBOTS = ("psp3", "five_bar", "delta")

with_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="there is no gcc")
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror")


def trajectory(robot: Any) -> Any:
    """Return a motion of the robot."""
    if robot.has_inverse_of_tip:
        return psp3.trajectories.Helix(robot=robot)
    return psp3.trajectories.Sway(robot=robot)


def computed_torque(robot: Any) -> Any:
    gains = {"kp": 100.0, "kv": 20.0}
    if not robot.has_inverse_of_tip:
        gains = default_gains(robot, "ctc")
    return psp3.ComputedTorque(robot, **gains)


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    """Return a function that exports a thing once."""
    if shutil.which("gcc") is None:
        pytest.skip("there is no gcc")
    done: dict[tuple[str, str], Path] = {}

    def write(name: str, make: Callable[[], Any], version: str = "2.0", **options: Any) -> Path:
        if (name, version) not in done:
            path = tmp_path_factory.mktemp("fmus") / f"{name}.fmu"
            done[name, version] = export_fmu(make(), path, version=version, **options).path
        return done[name, version]

    return write


@pytest.fixture
def unoptimized(monkeypatch: pytest.MonkeyPatch) -> None:
    """Compile what a test alone needs without optimization, which takes most of its time.

    Numbers are the same, and FMUs that several tests share are optimized.
    """
    monkeypatch.setattr(fmu, "FLAGS", tuple(flag.replace("-O2", "-O0") for flag in fmu.FLAGS))


@pytest.fixture(params=VERSIONS)
def version(request: pytest.FixtureRequest) -> str:
    """Return a version of FMI."""
    return str(request.param)


@pytest.fixture
def plant(written: Any, version: str, tmp_path: Path) -> Iterator[Callable[..., Plant]]:
    """Return a function that opens the plant of a robot."""
    opened = []

    def open_it(name: str, robot: Any = None, **options: Any) -> Plant:
        robot = psp3.load(name) if robot is None else robot
        path = written("_".join([name, *options]), lambda: robot, version, **options)
        opened.append(Plant(path, tmp_path / str(len(opened))))
        return opened[-1]

    yield open_it
    for one in opened:
        one.free()


@pytest.fixture
def control(written: Any, version: str, tmp_path: Path) -> Iterator[Callable[..., Control]]:
    """Return a function that opens a controller."""
    opened = []

    def open_it(name: str, controller: Any, **options: Any) -> Control:
        path = written(f"{name}_control", lambda: controller, version, **options)
        opened.append(Control(path, tmp_path / f"control_{len(opened)}"))
        return opened[-1]

    yield open_it
    for one in opened:
        one.free()


def assert_same(found: Any, expected: Any) -> None:
    for field in ("positions", "speeds", "torque"):
        np.testing.assert_array_equal(getattr(found, field), getattr(expected, field))


# Side by side with the simulation.


@pytest.mark.slow
@pytest.mark.parametrize("name", ROBOTS)
def test_plant_controller_and_both_are_those_of_simulate(
    name: str, plant: Any, control: Any
) -> None:
    robot = psp3.load(name)
    path, controller = trajectory(robot), computed_torque(robot)
    right = psp3.simulate(robot, controller, path, duration=0.6)
    ours, theirs = plant(name), control(name, controller)
    for result in (
        psp3.simulate(robot, controller, path, duration=0.6, plant=ours),
        psp3.simulate(robot, theirs, path, duration=0.6),
        psp3.simulate(robot, theirs, path, duration=0.6, plant=ours),
    ):
        assert_same(result, right)


@pytest.mark.slow
@pytest.mark.parametrize("name", ROBOTS)
def test_steps_taken_in_parallel_bring_forces_one_period_late(
    name: str, plant: Any, control: Any
) -> None:
    """As most programs do: outputs are read, handed over, and all FMUs go on."""
    robot = psp3.load(name)
    path, controller = trajectory(robot), computed_torque(robot)
    right = psp3.simulate(robot, controller, path, duration=0.3, delay=1)
    ours, theirs = plant(name), control(name, controller)
    desired = path(right.t)
    ours.start(right.positions[0], right.speeds[0])
    theirs.enter({})
    for k, t in enumerate(right.t):
        positions, speeds = ours.state()
        np.testing.assert_array_equal(positions, right.positions[k])
        theirs.give(positions, speeds, [rows[k] for rows in desired[:3]])
        if k == 0:
            # Before the first step outputs belong to inputs, and remembering is left for the step.
            theirs.forces()
            theirs.finish()
        forces = theirs.forces()
        np.testing.assert_array_equal(forces, right.torque[k])
        ours.set(ours.of("force"), list(forces))
        theirs.step(t, PERIOD)
        ours.step(t, PERIOD)


COSIMULATION = """
import sys
from pathlib import Path
import numpy as np
from libcosimpy.CosimEnums import CosimVariableType
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave
import psp3
robot, steps = psp3.load("delta"), 100
places = [{}, {}]
run = CosimExecution.from_step_size(2_000_000)
for i, path in enumerate(sys.argv[1:3]):
    assert run.add_local_slave(CosimLocalSlave(path, f"fmu{i}")) == i
    names = Path(path).with_suffix(".txt").read_text().split()
    places[i] = {name: place for place, name in enumerate(names)}
for joint in robot.coordinates:
    for source, name in ((1, f"force_{joint}"), (0, f"position_{joint}"), (0, f"speed_{joint}")):
        there = 1 - source
        run.connect_real_variables(source, places[source][name], there, places[there][name])
for joint, goal in zip(robot.coordinates, np.load(sys.argv[3]), strict=True):
    run.real_initial_value(1, places[1][f"desired_position_{joint}"], float(goal))
seen = CosimObserver.create_time_series(2 * steps)
run.add_observer(seen)
outputs = [places[0][f"position_{joint}"] for joint in robot.coordinates]
for place in outputs:
    seen.start_time_series(0, place, CosimVariableType.REAL)
run.step(steps)
rows = [seen.time_series_real_samples(0, place, 1, steps)[2] for place in outputs]
np.save(sys.argv[4], np.array(rows, dtype=float).T)
"""


@pytest.mark.slow
def test_program_in_which_fmus_are_coupled_makes_the_same_motion(
    written: Any, tmp_path: Path
) -> None:
    """libcosim, a program in C++ that reads FMUs by FMI Library, lets both take steps in parallel.

    In a process of its own, which libcosim writes much into.
    """
    pytest.importorskip("libcosimpy", reason="libcosim is not installed")
    robot = psp3.load("delta")
    controller, goal = computed_torque(robot), robot.reference + 0.01 * np.arange(1, 4)
    paths = written("delta", lambda: robot), written("delta_control", lambda: controller)
    for path in paths:
        with zipfile.ZipFile(path) as archive:
            root = ElementTree.fromstring(archive.read("modelDescription.xml"))
        names = [str(one.get("name")) for one in root.iter("ScalarVariable")]
        path.with_suffix(".txt").write_text("\n".join(names), encoding="utf-8")
    np.save(tmp_path / "goal.npy", goal)
    files = [str(path) for path in (*paths, tmp_path / "goal.npy", tmp_path / "found.npy")]
    run([sys.executable, "-c", COSIMULATION, *files], tmp_path)
    right = psp3.simulate(
        robot,
        controller,
        psp3.trajectories.Hold(goal, robot=robot),
        duration=100 * PERIOD,
        delay=1,
        initial_positions=robot.reference,
    )
    np.testing.assert_array_equal(np.load(tmp_path / "found.npy"), right.positions[1:])


@pytest.mark.slow
def test_fmpy_s_own_loop_makes_the_same_motion(written: Any, version: str) -> None:
    """1e-9 [rad]: FMPy interpolates the forces between the times that it is given."""
    fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed")
    robot = psp3.load("five_bar")
    right = psp3.simulate(robot, computed_torque(robot), trajectory(robot), duration=0.6)
    names = [f"force_{motor}" for motor in robot.actuated]
    kinds = [(name, np.float64) for name in ("time", *names)]
    forces = np.array(
        [(t, *row) for t, row in zip(right.t, right.torque, strict=True)], dtype=kinds
    )
    joints = list(robot.coordinates)
    start = {f"start_position_{j}": x for j, x in zip(joints, right.positions[0], strict=True)}
    start |= {f"start_speed_{j}": x for j, x in zip(joints, right.speeds[0], strict=True)}
    found = fmpy.simulate_fmu(
        str(written("five_bar", lambda: robot, version)),
        stop_time=0.6,
        output_interval=PERIOD,
        start_values=start,
        input=forces,
    )
    assert len(found) == len(right.t)
    for i, joint in enumerate(joints):
        np.testing.assert_allclose(
            found[f"position_{joint}"], right.positions[:, i], rtol=0.0, atol=1e-9
        )


@pytest.mark.usefixtures("unoptimized")
@pytest.mark.slow
def test_drives_steps_and_long_communication_steps(plant: Any) -> None:
    """Dry friction, two steps of integration in a period, and forces held for two periods."""
    robot, drive = psp3.load("five_bar"), psp3.Drive(coulomb_friction=0.05, viscous_friction=0.1)
    own = RungeKutta(robot, steps=2, drive=drive)
    ours = plant("five_bar", robot, steps=2, drive=drive)
    own.start(robot.reference, np.zeros(2))
    ours.start(robot.reference, np.zeros(2))
    for k in range(100):
        forces = [0.3 * math.sin(0.2 * k), 0.1]
        for _ in range(2):
            right = own.advance(np.array(forces), PERIOD)
        for found, expected in zip(ours.advance(forces, 2.0 * PERIOD), right, strict=True):
            np.testing.assert_array_equal(found, expected)
    # Friction is there: without it the same forces lead elsewhere.
    free = RungeKutta(robot, steps=2)
    free.start(robot.reference, np.zeros(2))
    assert abs(free.advance(np.array([0.3, 0.1]), 0.1)[0] - right[0]).max() > 1e-3


@pytest.mark.usefixtures("unoptimized")
@pytest.mark.slow
@pytest.mark.parametrize("name", ["biped", "gripper"])
def test_robot_whose_coordinates_follow(name: str, plant: Any) -> None:
    """One whose base floats, and one whose springs move, for some 16 ms to a limit."""
    robot = psp3.load(name)
    own, ours = RungeKutta(robot), plant(name, robot)
    speeds = np.zeros(len(robot.coordinates_v))
    own.start(robot.reference, speeds)
    ours.start(robot.reference, speeds)
    for _ in range(5):
        right = own.advance(np.full(len(robot.actuated), 0.1), PERIOD)
        found = ours.advance(np.full(len(robot.actuated), 0.1), PERIOD)
        np.testing.assert_array_equal(found[0], right[0])
        np.testing.assert_array_equal(found[1], right[1])
    assert abs(right[0] - robot.reference).max() > 1e-6


def test_units_of_a_base_that_floats(tmp_path: Path, no_gcc: None) -> None:
    with pytest.warns(SourceOnlyFMU):
        written = export_fmu(psp3.load("biped"), tmp_path / "biped.fmu")
    units = {one.name: one.unit for one in written.variables}
    assert units["position_root_1"] == "m"
    assert units["position_root_7"] == ""
    assert units["speed_root_6"] == "rad/s"


def copied(name: str, folder: Path) -> Any:
    """Return a robot from files of a user's own: URDF, and loops and poses beside it."""
    for file in (ROOT / "psp3" / "urdf").glob(f"{name}.*"):
        shutil.copy(file, folder / f"my own{file.suffix}")
    return psp3.load(folder / "my own.urdf")


OF_FILES: dict[str, Callable[[Path], Any]] = {
    "urdf": lambda folder: copied("planar_3rrr", folder),
    "over_actuated": MAKERS["over_actuated"],
}
"""Of a URDF, and of MJCF with more motors than coordinates."""


class InPython(RungeKutta):
    """A plant whose loop is in Python, as those of FMUs are."""


@pytest.mark.usefixtures("unoptimized")
@pytest.mark.slow
@pytest.mark.parametrize("kind", OF_FILES)
def test_robots_of_files_are_those_of_simulate(kind: str, plant: Any, tmp_path: Path) -> None:
    robot = OF_FILES[kind](tmp_path)
    controller, path = computed_torque(robot), psp3.trajectories.Sway(robot=robot)
    found, right, compiled = (
        psp3.simulate(robot, controller, path, duration=0.2, plant=one)
        for one in (plant(kind, robot), InPython(robot), None)
    )
    assert_same(found, right)
    # 1e-9: compiled loops share forces out among motors in another way than Python, to rounding.
    np.testing.assert_allclose(found.positions, compiled.positions, rtol=0.0, atol=1e-9)


@pytest.mark.usefixtures("unoptimized")
@pytest.mark.slow
@pytest.mark.parametrize("version", ["2.0"])
@pytest.mark.parametrize(
    "kind", [*(one for one in CLASSICAL if "psp3" in CLASSICAL[one].robots), *OPTIONS]
)
def test_controllers_of_every_kind_are_those_of_simulate(
    kind: str, control: Any, version: str
) -> None:
    """Their forces are the same code under all versions: one is enough."""
    robot = psp3.load("psp3" if kind in CLASSICAL else "five_bar")
    made = CLASSICAL[kind].make(robot) if kind in CLASSICAL else trained(robot, kind)
    path = trajectory(robot)
    right = psp3.simulate(robot, made, path, duration=0.1)
    ours = control(f"kind {[*CLASSICAL, *OPTIONS].index(kind)}", made, robot=robot)
    assert_same(psp3.simulate(robot, ours, path, duration=0.1), right)


@pytest.mark.slow
def test_largest_forces_are_the_limits_of_simulate(
    plant: Any, capfd: pytest.CaptureFixture[str]
) -> None:
    """Those that the FMU was written with, and others that are set; none of them stays."""
    robot = psp3.load("five_bar")
    controller, path = computed_torque(robot), trajectory(robot)
    free = psp3.simulate(robot, controller, path, duration=0.3)
    limits = 0.7 * abs(free.torque).max(axis=0)
    ours = plant("five_bar", robot, torque_limit=limits)
    for settings, limit in ((None, limits), ({"largest_force": 0.9 * limits}, 0.9 * limits)):
        ours.settings = settings
        right = psp3.simulate(robot, controller, path, duration=0.3, torque_limit=limit)
        assert (right.torque[: len(free.torque)] != free.torque).any()
        found = psp3.simulate(robot, controller, path, duration=0.3, plant=ours)
        np.testing.assert_array_equal(found.positions, right.positions)
        np.testing.assert_array_equal(found.speeds, right.speeds)
    for wrong in (0.0, -1.0, math.nan):
        ours.settings = {"largest_force": [1.0, wrong]}
        with pytest.raises(Exception, match=r"fmi\dExitInitializationMode"):
            ours.start(robot.reference, np.zeros(2))
        assert "largest_force_leg2_shoulder is not positive" in capfd.readouterr().out


def learned(kind: str = "it2", **options: Any) -> Any:
    helix = psp3.trajectories.Helix()
    robot = psp3.load("psp3")
    made = psp3.FuzzyComputedTorque(kind, robot, kp=100.0, kv=20.0, snr_db=20.0, **options)
    return made.fit(helix)


REMEMBER = {
    "pid": psp3.PID,
    "it2": learned,
    "adaptive": lambda: psp3.AdaptiveFuzzyComputedTorque(learned("t1", learner="average")),
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", REMEMBER)
def test_controllers_that_remember_or_learned(kind: str, control: Any) -> None:
    robot, path = psp3.load("psp3"), psp3.trajectories.Helix()
    controller = REMEMBER[kind]()
    ours = control(kind, controller, robot=robot)
    for _ in range(2):
        # Twice: a reset forgets the integral, and what was adapted.
        controller.reset()
        right = psp3.simulate(robot, controller, path, duration=0.4)
        found = psp3.simulate(robot, ours, path, duration=0.4)
        assert_same(found, right)
    if kind == "it2":
        low, high = (ours.get(ours.of(f"force_{end}")) for end in ("low", "high"))
        assert (np.array(low) <= right.torque[-1]).all()
        assert (right.torque[-1] <= np.array(high)).all()
        assert (np.array(low) < np.array(high)).any()


@pytest.mark.slow
def test_file_of_a_controller_is_what_it_was_trained_to_be(tmp_path: Path) -> None:
    controller = learned()
    saved = controller.save(tmp_path / "controller.json")
    one = export_fmu(controller, tmp_path / "it2.fmu")
    other = export_fmu(saved, tmp_path / "again.fmu", name="it2")
    assert one.guid == other.guid


# What FMPy says of the files.


@pytest.mark.slow
@with_gcc
@pytest.mark.parametrize("name", ROBOTS)
def test_fmpy_finds_nothing_wrong(name: str, written: Any, version: str) -> None:
    validation = pytest.importorskip("fmpy.validation", reason="FMPy is not installed")
    robot = psp3.load(name)
    assert validation.validate_fmu(str(written(name, lambda: robot, version))) == []
    path = written(f"{name}_control", lambda: computed_torque(robot), version)
    assert validation.validate_fmu(str(path)) == []


@with_gcc
def test_build_description_is_that_of_the_standard(tmp_path: Path) -> None:
    """Its schema comes with FMPy, which does not look at the file."""
    fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed")
    etree = pytest.importorskip("lxml.etree", reason="lxml is not installed")
    path = export_fmu(arm("a"), tmp_path / "arm.fmu", version="3.0").path
    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
        root = etree.fromstring(archive.read("sources/buildDescription.xml"))
    schemas = Path(fmpy.__file__).parent / "schema" / "fmi3"
    etree.XMLSchema(file=str(schemas / "fmi3BuildDescription.xsd")).assertValid(root)
    listed = {f"sources/{file.get('name')}" for file in root.iter("SourceFile")}
    assert listed == {name for name in names if name.endswith(".c")}


@pytest.mark.slow
def test_state_is_saved_restored_and_carried_to_another_instance(plant: Any) -> None:
    ours, other = plant("delta"), plant("delta")
    robot = psp3.load("delta")
    ours.start(robot.reference, np.zeros(3))
    other.start(robot.reference, np.zeros(3))
    forces = np.array([0.5, -0.2, 0.1])
    for _ in range(20):
        ours.advance(forces, PERIOD)
    state = ours.fmi.save()
    packed = ours.fmi.pack(state)
    right = [ours.advance(forces, PERIOD) for _ in range(20)]
    # The other one has stayed where it was.
    np.testing.assert_array_equal(other.state()[0], robot.reference)
    ours.fmi.restore(state)
    carried = other.fmi.unpack(packed)
    other.fmi.restore(carried)
    for one in (ours, other):
        one.steps = 20
        for expected in right:
            np.testing.assert_array_equal(one.advance(forces, PERIOD), expected)
    ours.fmi.forget(state)
    other.fmi.forget(carried)
    with pytest.raises(Exception, match=r"fmi\dDe[sS]erializeFMU[sS]tate"):
        ours.fmi.unpack(packed[:-1])


# What goes wrong is said, and not more than that goes wrong.


@pytest.mark.slow
def test_pose_that_cannot_be_reached_is_an_error_and_a_reset_mends_it(
    plant: Any, capfd: pytest.CaptureFixture[str]
) -> None:
    robot, ours = psp3.load("five_bar"), plant("five_bar")
    ours.start(robot.reference, np.zeros(2))
    first = ours.advance([0.1, 0.1], PERIOD)
    with pytest.raises(Exception, match=r"fmi\dDoStep"):
        _push(ours)
    said = capfd.readouterr().out
    with pytest.raises(psp3.errors.SimulationDiverged) as diverged:
        psp3.simulate(
            robot, _Constant([5.0, 5.0]), psp3.trajectories.Hold(robot=robot), duration=2.0
        )
    # At the same time as the simulation.
    assert f"at {diverged.value.time:.9g} s: " in said
    assert "beyond its limits" in said
    with pytest.raises(Exception, match=r"fmi\dDoStep"):
        ours.advance([0.0, 0.0], PERIOD)
    assert "reset the FMU" in capfd.readouterr().out
    ours.start(robot.reference, np.zeros(2))
    np.testing.assert_array_equal(ours.advance([0.1, 0.1], PERIOD), first)


def _push(plant: Plant) -> None:
    for _ in range(1000):
        plant.advance([5.0, 5.0], PERIOD)


class _Constant:
    def __init__(self, forces: list[float]) -> None:
        self.forces = np.array(forces)

    def reset(self) -> None:
        """Forget nothing."""

    def torque(self, t: float, positions: Any, speeds: Any, desired: Any) -> Any:
        """Return the forces, but for the first step."""
        return self.forces if t > 0.0 else np.array([0.1, 0.1])


@pytest.mark.slow
def test_loops_that_do_not_close_and_numbers_that_are_none(
    plant: Any, control: Any, capfd: pytest.CaptureFixture[str]
) -> None:
    robot = psp3.load("five_bar")
    ours = plant("five_bar")
    with pytest.raises(Exception, match=r"fmi\dExitInitializationMode"):
        ours.start([-1.4, 1.4], np.zeros(2))
    assert "its loops cannot be closed" in capfd.readouterr().out
    with pytest.raises(Exception, match=r"fmi\dExitInitializationMode"):
        ours.start([-1.6, 0.6], np.zeros(2))
    assert "leg1_shoulder is beyond its limits, -1.5 to 1.5 rad" in capfd.readouterr().out
    ours.start(robot.reference, np.zeros(2))
    with pytest.raises(Exception, match=r"fmi\dDoStep"):
        ours.advance([math.nan, 0.0], PERIOD)
    theirs = control("five_bar", computed_torque(robot))
    theirs.begin({})
    theirs.give([math.nan, 0.0], np.zeros(2), np.zeros((3, 2)))
    with pytest.raises(Exception, match=r"fmi\dDoStep"):
        theirs.step(0.0, PERIOD)
    assert "forces are not finite" in capfd.readouterr().out


@pytest.mark.slow
def test_wrong_calls_are_refused_with_a_reason(
    plant: Any, capfd: pytest.CaptureFixture[str]
) -> None:
    ours = plant("five_bar")
    robot = psp3.load("five_bar")
    ours.start(robot.reference, np.zeros(2))

    def refused(call: Callable[[], Any], why: str) -> None:
        with pytest.raises(Exception, match=r"fmi\d"):
            call()
        assert why in capfd.readouterr().out

    refused(lambda: ours.step(0.0, 0.003), "is none of whole periods of 0.002 s")
    refused(lambda: ours.step(0.001, 0.002), "is none of whole periods of 0.002 s")
    refused(lambda: ours.step(0.0, 0.0), "is none of whole periods of 0.002 s")
    refused(lambda: ours.set(ours.of("position"), [0.0, 0.0]), "is an output")
    refused(lambda: ours.set(ours.of("start_speed"), [0.0, 0.0]), "is a parameter")
    refused(lambda: ours.get([1000]), "no variable of value reference 1000")
    refused(lambda: ours.fmi.none_of([0]), "real numbers")
    refused(lambda: ours.fmi.enter(0.0), "reset it first")
    # None of this has changed anything: times that are off by rounding are taken.
    right = RungeKutta(robot)
    right.start(robot.reference, np.zeros(2))
    ours.step(1e-12, PERIOD + 1e-13)
    np.testing.assert_array_equal(ours.state(), right.advance(np.zeros(2), PERIOD))


@pytest.mark.slow
def test_start_at_another_time(plant: Any, control: Any) -> None:
    """Time of a plant is none of its motion; of a controller's integral only differences are."""
    robot, controller = psp3.load("five_bar"), psp3.PID(kp=5.0, kv=1.0, ki=10.0)
    ours, theirs = plant("five_bar"), control("five_bar_pid", controller, robot=robot)
    desired, forces = np.zeros((3, 2)), []
    for start in (0.0, 1.0):
        ours.begin({"start_position": robot.reference}, start)
        theirs.begin({}, start)
        for k in range(5):
            theirs.give(*ours.state(), desired)
            theirs.step(start + k * PERIOD, PERIOD)
            forces.append(theirs.forces())
            ours.set(ours.of("force"), list(forces[-1]))
            ours.step(start + k * PERIOD, PERIOD)
    # 1e-12: times that are seconds later have fewer digits.
    np.testing.assert_allclose(forces[5:], forces[:5], rtol=0.0, atol=1e-12)
    assert abs(np.diff(forces[:5], axis=0)).min() > 0.0


@pytest.mark.slow
@with_gcc
def test_page_says_what_happens(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its blocks for FMPy, too, which the tests of pages leave out."""
    pytest.importorskip("fmpy", reason="FMPy is not installed")
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs" / "how_to" / "fmu.md").read_text(encoding="utf-8")
    printed: list[str] = []
    names: dict[str, Any] = {"print": lambda *words: printed.append(" ".join(map(str, words)))}
    found = re.findall(r"^```(?:python|py)\n(.*?)^```", page, flags=re.MULTILINE | re.DOTALL)
    assert len(found) == 2
    for code in found:
        exec(compile(code, "fmu.md", "exec"), names)
    assert printed[-1] == "0.0"
    assert abs(names["found"] - names["goal"]).max() < 1e-3


# The archive.


def test_description_says_what_each_variable_is(tmp_path: Path, no_gcc: None) -> None:
    with pytest.warns(SourceOnlyFMU, match="there is no gcc"):
        written = export_fmu(psp3.load("psp3"), tmp_path / "my robot.fmu")
    assert (written.name, written.period, written.has_binary) == ("my_robot", 0.002, False)
    with zipfile.ZipFile(tmp_path / "my robot.fmu") as archive:
        assert archive.testzip() is None
        names = archive.namelist()
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    assert not [name for name in names if name.startswith("binaries")]
    listed = {f"sources/{file.get('name')}" for file in root.iter("File")}
    assert listed == {name for name in names if name.endswith(".c")}
    variables = {one.get("name"): one for one in root.iter("ScalarVariable")}
    assert list(variables) == [one.name for one in written.variables]
    force, height, start = (
        variables[name] for name in ("force_a1", "position_a1", "start_position_a1")
    )
    assert (force.get("causality"), force[0].attrib) == ("input", {"start": "0.0", "unit": "N"})
    assert (height.get("causality"), height[0].attrib) == ("output", {"unit": "m"})
    home = psp3.load("psp3").reference[0]
    assert start.get("causality") == "parameter"
    assert start[0].attrib == {"start": repr(float(home)), "unit": "m"}
    places = [int(one.get("valueReference", -1)) for one in variables.values()]
    assert places == list(range(len(variables)))
    with pytest.warns(SourceOnlyFMU):
        again = export_fmu(psp3.load("psp3"), tmp_path / "again.fmu", name="my_robot")
    assert again.guid == written.guid
    assert (tmp_path / "again.fmu").read_bytes() == (tmp_path / "my robot.fmu").read_bytes()
    with pytest.warns(SourceOnlyFMU):
        other = export_fmu(psp3.load("psp3"), tmp_path / "again.fmu", name="my_robot", steps=2)
    assert other.guid != written.guid


@pytest.fixture
def no_gcc(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fmu.shutil, "which", lambda _: None)


def arm(*names: str, title: str = "arm") -> Any:
    """Return an arm whose joints, of which the first has limits, have names."""
    model, body = pin.Model(), pin.Inertia(1.0, np.array([0.1, 0.02, 0.3]), 0.01 * np.eye(3))
    for k, name in enumerate(names):
        at = pin.SE3(np.eye(3), np.array([0.1, 0.2, 0.3]))
        joint = model.addJoint(k, pin.JointModelRZ(), at, name)
        model.appendBodyToJoint(joint, body, pin.SE3.Identity())
    model.name = title
    model.lowerPositionLimit[0], model.upperPositionLimit[0] = -1.0, 1.0
    return psp3.ClosedLoopRobot(model, [], list(names))


@pytest.mark.usefixtures("unoptimized")
@pytest.mark.slow
@with_gcc
def test_names_of_all_kinds_are_in_the_file_and_in_the_log(
    tmp_path: Path, version: str, capfd: pytest.CaptureFixture[str]
) -> None:
    """Names that XML, C and formats have other uses for, and more than fits in a short line."""
    validation = pytest.importorskip("fmpy.validation", reason="FMPy is not installed")
    names = ('a"b\\c??/d %s', "*/ <&>'x", "é日本", "n" * 700)
    robot = arm(*names, title='*/ ??/ "<&> %n')
    path = export_fmu(robot, tmp_path / "odd name é.fmu", version=version).path
    assert validation.validate_fmu(str(path)) == []
    ours = Plant(path, tmp_path)
    assert list(ours.places)[: len(names)] == [f"force_{name}" for name in names]
    assert ours.description.description.startswith(robot.title)
    with pytest.raises(Exception, match=r"fmi\dExitInitializationMode"):
        ours.start([2.0, 0.0, 0.0, 0.0], np.zeros(4))
    assert f"at 0 s: {names[0]} is beyond its limits, -1 to 1 rad" in capfd.readouterr().out
    with pytest.raises(Exception, match=r"fmi\dExitInitializationMode"):
        ours.begin({"largest_force": [1.0, 1.0, 1.0, 0.0]})
    assert f"largest_force_{names[3]} is not positive" in capfd.readouterr().out
    with zipfile.ZipFile(path) as archive:
        archive.extractall(tmp_path)
    for file in ("code_odd_name_.c", f"fmi{version[0]}.c"):
        run(["gcc", *STRICT, "-c", file, "-o", "/dev/null"], tmp_path / "sources")
    ours.free()


def test_names_that_no_fmu_can_hold_are_refused(tmp_path: Path, no_gcc: None) -> None:
    place = tmp_path / "x.fmu"
    for odd in ("\x01", "\n", "\t", "\x7f"):
        with pytest.raises(fuzzy2.errors.NotExportable, match="no FMU can hold") as refused:
            export_fmu(arm(f"a{odd}b"), place)
        assert repr(f"force_a{odd}b") in str(refused.value)
    with pytest.raises(fuzzy2.errors.NotExportable, match="no FMU can hold"):
        export_fmu(arm("a", title="x\x02"), place)
    # The motion of a base is numbered, and a joint may be called as one of its numbers.
    model, body = pin.Model(), pin.Inertia(1.0, np.zeros(3), 0.01 * np.eye(3))
    for parent, (name, kind) in enumerate(
        (("root", pin.JointModelFreeFlyer()), ("root_1", pin.JointModelRZ()))
    ):
        joint = model.addJoint(parent, kind, pin.SE3.Identity(), name)
        model.appendBodyToJoint(joint, body, pin.SE3.Identity())
    floating = psp3.ClosedLoopRobot(model, [], ["root_1"], free="keep")
    with pytest.raises(fuzzy2.errors.NotExportable, match="2 of its variables would be called"):
        export_fmu(floating, place)
    assert not place.exists()


@pytest.mark.usefixtures("unoptimized")
@pytest.mark.parametrize(
    ("file", "name"),
    [
        *(("model", "model"), ("Instance", "Instance"), ("fmi2", "fmi2"), ("double", "double")),
        *(
            ("_x", "_x"),
            ("-dash", "_dash"),
            ("3 PSP", "model_3_PSP"),
            ("é", "_"),
            ("x" * 250, "x" * 200),
        ),
    ],
)
@with_gcc
def test_files_of_all_names_make_models(file: str, name: str, tmp_path: Path) -> None:
    """Words of C, and what else is called so in an FMU, are in nobody's way."""
    written = export_fmu(arm("a"), tmp_path / f"{file}.fmu")
    assert (written.name, written.has_binary) == (name, True)
    with zipfile.ZipFile(written.path) as archive:
        names = archive.namelist()
    assert len(names) == len(set(names)) == 7
    assert f"binaries/linux64/{name}.so" in names


def test_things_that_are_no_fmu_are_refused_by_name(tmp_path: Path, no_gcc: None) -> None:
    robot, place = psp3.load("psp3"), tmp_path / "x.fmu"
    changed = psp3.load("psp3")
    changed.__class__ = Changed
    with pytest.raises(fuzzy2.errors.NotExportable, match="dict cannot be written in C"):
        export_fmu({}, place)
    with pytest.raises(fuzzy2.errors.NotExportable, match="give the robot: robot="):
        export_fmu(psp3.PD(), place)
    with pytest.raises(fuzzy2.errors.NotExportable, match="_Constant"):
        export_fmu(_Constant([0.0, 0.0, 0.0]), place, robot=robot)
    with pytest.raises(fuzzy2.errors.NotExportable, match="Changed"):
        export_fmu(changed, place)
    with pytest.raises(InvalidValue, match="identifier of C"):
        export_fmu(robot, place, name="3-PSP")
    with pytest.raises(InvalidValue, match="period"):
        export_fmu(robot, place, period=-1.0)
    with pytest.raises(InvalidValue, match="at most 1e\\+06 s"):
        export_fmu(robot, place, period=1e30)
    with pytest.raises(InvalidValue, match="at most 200 letters"):
        export_fmu(robot, place, name="x" * 201)
    with pytest.raises(InvalidValue, match=r"ends in \.fmu, got '.*x\.zip'"):
        export_fmu(robot, tmp_path / "x.zip")
    with pytest.raises(UnknownName, match=r"version of FMI '1\.0'; known are 2\.0, 3\.0"):
        export_fmu(robot, place, version="1.0")
    for limit in (0.0, [1.0, -1.0, 1.0], [1.0, 2.0], math.nan, "much"):
        with pytest.raises(ValueError, match="torque_limit"):
            export_fmu(robot, place, torque_limit=limit)
    for option in ({"steps": 2}, {"torque_limit": 1.0}, {"drive": psp3.Drive(1.0)}):
        with pytest.raises(InvalidValue, match="a controller has none"):
            export_fmu(psp3.PD(), place, robot=robot, **option)
    assert not list(tmp_path.iterdir())


class Changed(psp3.PSP3):
    """A robot with dynamics of its own."""


DRIVER_OF_TWO = """
#include "fmi2.c"
#define FMI(name) fmi2##name
#define OK fmi2OK
#define ERROR fmi2Error
static int live;
static void *some(size_t count, size_t size) { live++; return calloc(count, size); }
static void no_more(void *what) { live -= what != NULL; free(what); }
static void told(void *e, const char *n, fmi2Status s, const char *c, const char *m, ...)
{ (void)e; (void)n; (void)s; (void)c; puts(m); }
static const fmi2CallbackFunctions calls = {told, some, no_more, NULL, NULL};
static void *made(const char *guid)
{ return fmi2Instantiate("100 percent", fmi2CoSimulation, guid, "", &calls, 0, 0); }
static int begun(void *c)
{
    return fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0) || fmi2EnterInitializationMode(c)
           || fmi2ExitInitializationMode(c);
}
static int stepped(void *c, double t, double d) { return fmi2DoStep(c, t, d, 1); }
static int got(void *c, const unsigned int *p, double *v)
{ return fmi2GetReal(c, p, MODEL_VALUES, v); }
static int set_one(void *c, unsigned int p, double v) { return fmi2SetReal(c, &p, 1, &v); }
static int none(void *c, const unsigned int *p) { return fmi2SetInteger(c, p, 1, NULL); }
static int saved(void *c, void **s) { return fmi2GetFMUstate(c, s); }
static int restored(void *c, void *s) { return fmi2SetFMUstate(c, s); }
static int forgotten(void *c, void **s) { return fmi2FreeFMUstate(c, s); }
"""

DRIVER_OF_THREE = """
#include "fmi3.c"
#define FMI(name) fmi3##name
#define OK fmi3OK
#define ERROR fmi3Error
static int live;
static void told(void *e, fmi3Status s, const char *c, const char *m)
{ (void)e; (void)s; (void)c; puts(m); }
static void *made(const char *token)
{
    return fmi3InstantiateCoSimulation("100 percent", token, "", false, false, false, false, NULL,
                                       0, NULL, told, NULL);
}
static int begun(void *c)
{
    return fmi3EnterInitializationMode(c, false, 0.0, 0.0, false, 0.0)
           || fmi3ExitInitializationMode(c);
}
static int stepped(void *c, double t, double d)
{
    bool a, b, e;
    double last;
    int status = fmi3DoStep(c, t, d, true, &a, &b, &e, &last);
    return status ? status : a || b || e || last < t + 0.999 * d;
}
static int got(void *c, const unsigned int *p, double *v)
{
    unsigned int time = MODEL_VALUES;
    double now;
    return fmi3GetFloat64(c, p, MODEL_VALUES, v, MODEL_VALUES)
           || fmi3GetFloat64(c, &time, 1, &now, 1) || now < 0.0;
}
static int set_one(void *c, unsigned int p, double v) { return fmi3SetFloat64(c, &p, 1, &v, 1); }
static int none(void *c, const unsigned int *p) { return fmi3SetInt32(c, p, 1, NULL, 1); }
static int saved(void *c, void **s) { return fmi3GetFMUState(c, s); }
static int restored(void *c, void *s) { return fmi3SetFMUState(c, s); }
static int forgotten(void *c, void **s) { return fmi3FreeFMUState(c, s); }
"""

DRIVER = """
int main(void)
{
    unsigned int all[MODEL_VALUES], i;
    double values[MODEL_VALUES], later[MODEL_VALUES], others[MODEL_VALUES];
    void *state = NULL, *c = made(MODEL_GUID), *d = made(MODEL_GUID);
    if (!c || !d || made("other")) return 1;
    for (i = 0; i < MODEL_VALUES; i++) all[i] = i;
    if (begun(c) || begun(d)) return 2;
    /* Two at once, one of which is given something else. */
    if (set_one(d, 0, 0.01)) return 3;
    for (i = 0; i < 20; i++) if (stepped(c, 0.002 * i, 0.002) || stepped(d, 0.002 * i, 0.002))
        return 4;
    if (saved(c, &state)) return 5;
    if (stepped(c, 0.04, 0.02) || got(c, all, later) || got(d, all, others)) return 6;
    if (memcmp(others, later, sizeof later) == 0) return 7;
    if (restored(c, state) || stepped(c, 0.04, 0.02) || got(c, all, values)) return 8;
    if (memcmp(values, later, sizeof values) != 0) return 9;
    /* The state of one is carried to the other. */
    if (restored(d, state) || set_one(d, 0, values[0]) || stepped(d, 0.04, 0.02)) return 10;
    if (got(d, all, others) || memcmp(others, later, sizeof later) != 0) return 11;
    if (none(c, all) != ERROR) return 12;
    if (set_one(c, MODEL_VALUES + 1, 0.0) != ERROR) return 13;
    forgotten(c, &state);
    FMI(Terminate)(c);
    if (stepped(c, 0.06, 0.002) != ERROR) return 14;
    if (FMI(Reset)(c) != OK || begun(c) || stepped(c, 0.0, 0.002)) return 15;
    FMI(FreeInstance)(c);
    FMI(FreeInstance)(d);
    FMI(FreeInstance)(NULL);
    for (i = 0; i < 1000; i++) {
        c = made(MODEL_GUID);
        if (!c || begun(c) || stepped(c, 0.0, 0.002)) return 16;
        FMI(FreeInstance)(c);
    }
    return live;
}
"""


@pytest.fixture
def unpacked(written: Any, version: str, tmp_path: Path) -> Callable[[str], Path]:
    """Return a function that returns the folder with the sources of a plant or a controller."""

    def unpack(thing: str) -> Path:
        robot = psp3.load("five_bar")
        path = written("five_bar", lambda: robot, version)
        if thing == "controller":
            path = written("five_bar_control", lambda: computed_torque(robot), version)
        with zipfile.ZipFile(path) as archive:
            archive.extractall(tmp_path)
        return tmp_path / "sources"

    return unpack


@pytest.mark.slow
@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@pytest.mark.parametrize("thing", ["plant", "controller"])
def test_sources_compile_without_a_warning_and_run_without_a_fault(
    compiler: str, thing: str, version: str, unpacked: Any
) -> None:
    """Under the sanitizers of addresses, leaks and undefined behavior, if the compiler has them."""
    if shutil.which(compiler) is None:
        pytest.skip(f"there is no {compiler}")
    sources = unpacked(thing)
    driver = (DRIVER_OF_TWO if version == "2.0" else DRIVER_OF_THREE) + DRIVER
    (sources / "driver.c").write_text(driver, encoding="utf-8")
    model = next(one.name for one in sources.glob("code_*.c"))
    for file in (model, f"fmi{version[0]}.c"):
        run([compiler, *STRICT, "-c", file, "-o", "/dev/null"], sources)
    sanitized = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g"]
    command = [compiler, "-std=c99", "-o", "driver", "driver.c", model, "-lm"]
    if subprocess.run([*command, *sanitized], cwd=sources, capture_output=True).returncode != 0:
        run(command, sources)
    said = run(["./driver"], sources)
    assert "modelDescription.xml belongs to another FMU" in said
    assert "all variables of this FMU are real numbers" in said
    assert "there is no variable of value reference" in said


@pytest.mark.slow
@needs_cppcheck
@pytest.mark.parametrize("thing", ["plant", "controller"])
def test_cppcheck_has_nothing_to_say(thing: str, unpacked: Any) -> None:
    check_statically(unpacked(thing))


def run(command: list[str], folder: Path) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, (done.returncode, done.stdout, done.stderr)
    return done.stdout


@pytest.mark.slow
@with_gcc
def test_declarations_are_those_of_the_standard(version: str, unpacked: Any) -> None:
    """The header of the standard comes with FMPy: functions that differ would not compile."""
    fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed")
    sources, fmi = unpacked("plant"), f"fmi{version[0]}"
    headers = Path(fmpy.__file__).parent / "c-code"
    command = ["gcc", "-std=c99", "-Wall", "-Werror", f"-I{headers}", "-include"]
    run([*command, f"{fmi}Functions.h", "-c", f"{fmi}.c", "-o", "fmi.o"], sources)
    header = (headers / f"{fmi}Functions.h").read_text(encoding="utf-8")
    declared = set(re.findall(rf"^\s*FMI\d_Export \w+TYPE\s+({fmi}\w+);", header, re.MULTILINE))
    words = run(["nm", "--defined-only", "fmi.o"], sources).split()
    defined = {word for word in words if word.startswith(fmi)}
    assert defined <= declared
    # Those of model exchange are not for co-simulation.
    assert (
        declared - defined
        == {
            "2.0": {
                *("fmi2EnterEventMode", "fmi2NewDiscreteStates", "fmi2EnterContinuousTimeMode"),
                *("fmi2CompletedIntegratorStep", "fmi2SetTime", "fmi2SetContinuousStates"),
                *("fmi2GetDerivatives", "fmi2GetEventIndicators", "fmi2GetContinuousStates"),
                "fmi2GetNominalsOfContinuousStates",
            },
            # Programs look for all of them.
            "3.0": set(),
        }[version]
    )
