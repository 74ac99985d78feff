"""An object of every public class, made in a few words, and what is asked of it."""

from __future__ import annotations

import functools
import importlib
import inspect
import types
import warnings
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

import fuzzy2
import psp3
from psp3.benchmark import Benchmark, Entry
from psp3.bounds import ErrorDynamics
from psp3.collisions import Contact, Report
from psp3.errors import CorrelatedResiduals
from psp3.identification import identify
from psp3.identification.base_parameters import base_parameters
from psp3.identification.unknowns import all_parameters
from psp3.simulation import Encoder
from psp3.symbolic import SymbolicPSP3, SymbolicRobot
from psp3.trajectories import (
    Circle,
    FromCSV,
    Helix,
    Hold,
    Line,
    PointToPoint,
    Sway,
    Waypoints,
    measured_motion,
)

MODULES = (
    "psp3",
    "psp3.trajectories",
    "psp3.simulation",
    "psp3.drives",
    "psp3.collisions",
    "psp3.identification",
    "psp3.bounds",
    "psp3.benchmark",
    "psp3.study",
    "psp3.visualize",
    "psp3.symbolic",
    "fuzzy2",
    "fuzzy2.learning",
    "fuzzy2.numbers",
    "fuzzy2.systems",
)

NONE_OF_THEIR_OWN = {
    "FuzzySystem": "the base of the systems",
    "GeneralType2Set": "the base of general type-2 sets",
    "Trajectory": "the base of trajectories",
    "Type1Set": "the base of type-1 sets",
    "Scene": "a connection to a browser's page",
    "Viewer": "a server with its port",
}


def public_classes() -> dict[str, type]:
    """Return all public classes but errors, by name."""
    found: dict[str, type] = {}
    for name in MODULES:
        module = importlib.import_module(name)
        for one in module.__all__:
            what = getattr(module, one)
            if isinstance(what, type) and not issubclass(what, BaseException):
                # Two packages may have a word for two things.
                is_other = found.get(one, what) is not what
                found[f"{name}.{one}" if is_other else one] = what
    return found


@functools.cache
def psp() -> Any:
    return psp3.load("psp3")


@functools.cache
def delta() -> Any:
    return psp3.load("delta")


@functools.cache
def five_bar() -> Any:
    return psp3.load("five_bar")


@functools.cache
def result() -> psp3.Result:
    return psp3.simulate(psp(), psp3.ComputedTorque(psp(), 100.0, 20.0), Helix(), 0.1)


@functools.cache
def controller() -> psp3.FuzzyComputedTorque:
    return psp3.FuzzyComputedTorque("it2", psp()).fit(Helix(), 0.5)


def terms() -> list[list[Any]]:
    return [[fuzzy2.Gaussian(m, 0.3) for m in (0.0, 1.0)]] * 2


RULES = [[0, 0], [0, 1], [1, 0], [1, 1]]
NUMBERS = [[0.0], [1.0], [2.0], [4.0]]


def square(x: Any) -> Any:
    return np.clip(1.0 - x * x, 0.0, 1.0)


def moved(x: float) -> Any:
    return fuzzy2.Gaussian(0.5 * x, 0.2)


def samples() -> tuple[Any, Any]:
    x = np.random.default_rng(5).uniform(0.0, 1.0, (60, 2))
    return x, x[:, 0] * x[:, 1]


def identified() -> Any:
    base = base_parameters(all_parameters(five_bar()))
    t = np.arange(120) / 120.0
    motion = psp3.exciting_motion(base, 1.0, 3, steps=1)
    joints = motion.joints(t)
    with warnings.catch_warnings():
        # Measurements without noise leave roundings as residuals, of which neighbors are alike.
        warnings.simplefilter("ignore", CorrelatedResiduals)
        return identify(base, t, joints[0], five_bar().inverse_dynamics(*joints), 1.0, 3)


def tabled(folder: Path) -> Any:
    study = psp3.Study(folder / "tabled.sqlite", [psp3.Run("ctc", duration=0.02)])
    study.run(1)
    return study.rows()


def benchmark(folder: Path) -> Benchmark:
    return Benchmark(folder, ["pd-gravity"], ["psp3"], seeds=1, duration=0.1)


def board(folder: Path) -> Any:
    asked = benchmark(folder)
    asked.run(1)
    return asked.board()


def nothing(course: Any) -> Any:
    return None


def measured(folder: Path) -> Path:
    path = folder / "motion.csv"
    t = np.linspace(0.0, 1.0, 101)
    rows = np.column_stack([t, *(0.01 * np.sin(t + k) for k in range(3))])
    table = np.column_stack([rows, np.ones((101, 3))])
    columns = "t,a1,a2,a3,force1,force2,force3"
    np.savetxt(path, table, delimiter=",", header=columns, comments="")
    return path


EXAMPLES: dict[str, Callable[[Path], Any]] = {
    # Robots and what they are made of.
    "PSP3": lambda _: psp(),
    "ClosedLoopRobot": lambda _: delta(),
    "Parameters": lambda _: psp3.Parameters(),
    "Pose": lambda _: psp().forward_kinematics([0.1, 0.2, 0.15]),
    "NaturalOrthogonalComplement": lambda _: psp3.NaturalOrthogonalComplement(psp()),
    "Drive": lambda _: psp3.Drive(1.0, 2.0, 0.001, 0.02),
    "SingularityAnalysis": lambda _: psp3.SingularityAnalysis(five_bar(), "tip", ["x", "z"]),
    "Workspace": lambda _: psp3.Workspace(five_bar(), "tip", ["x", "z"]),
    "SymbolicPSP3": lambda _: SymbolicPSP3(psp()),
    "SymbolicRobot": lambda _: SymbolicRobot(five_bar()),
    # Controllers and what is kept of them.
    "PD": lambda _: psp3.PD(),
    "PID": lambda _: psp3.PID(),
    "FeedForward": lambda _: psp3.FeedForward(psp()),
    "GravityCompensatedPD": lambda _: psp3.GravityCompensatedPD(psp()),
    "ComputedTorque": lambda _: psp3.ComputedTorque(delta()),
    "FuzzyComputedTorque": lambda _: controller(),
    "AdaptiveFuzzyComputedTorque": lambda _: psp3.AdaptiveFuzzyComputedTorque(controller()),
    "TaskSpaceComputedTorque": lambda _: psp3.TaskSpaceComputedTorque(delta()),
    "LinearQuadraticRegulator": lambda _: psp3.LinearQuadraticRegulator(
        delta(), np.eye(6), np.eye(3)
    ),
    "TimeVaryingLinearQuadraticRegulator": lambda _: psp3.TimeVaryingLinearQuadraticRegulator(
        delta(),
        PointToPoint(delta().reference, delta().reference + 0.1, 0.1, delta()),
        0.1,
        np.eye(6),
        np.eye(3),
    ),
    "Monitor": lambda _: psp3.Monitor(),
    "ConformalIntervals": lambda _: psp3.ConformalIntervals(
        np.arange(90.0).reshape(30, 3), np.arange(90.0).reshape(30, 3, 1) + np.array([-1.0, 2.0])
    ),
    "TrackingTube": lambda _: psp3.TrackingTube([result()] * 30, 100.0, 20.0),
    "ErrorDynamics": lambda _: ErrorDynamics(100.0, 20.0),
    # Motions, simulations, studies.
    "Circle": lambda _: Circle(),
    "Helix": lambda _: Helix(robot=psp()),
    "Hold": lambda _: Hold(),
    "Line": lambda _: Line([0.0, 0.0, 0.4], [0.01, 0.0, 0.4], 1.0),
    "PointToPoint": lambda _: PointToPoint(
        delta().reference, delta().reference + 0.1, 1.0, delta()
    ),
    "Sway": lambda _: Sway(robot=delta()),
    "Waypoints": lambda _: Waypoints([0.0, 1.0], [[0.0, 0.0, 0.4], [0.01, 0.0, 0.4]]),
    "FromCSV": lambda folder: FromCSV(measured(folder), psp()),
    "MeasuredMotion": lambda folder: measured_motion(measured(folder), psp()),
    "Motion": lambda _: result().desired,
    "Result": lambda _: result(),
    "Encoder": lambda _: Encoder(np.full(3, 0.01), 0.002),
    "MuJoCo": lambda _: psp3.MuJoCo(delta()),
    "Run": lambda _: psp3.Run(),
    "Study": lambda folder: psp3.Study(folder / "runs.sqlite", [psp3.Run(duration=0.1)]),
    "Grid": lambda _: psp3.grid(seed=range(3)),
    "Table": lambda folder: tabled(folder),
    "Benchmark": lambda folder: benchmark(folder),
    "Board": lambda folder: board(folder),
    "Entry": lambda _: Entry("mine", "nothing", nothing),
    "fuzzy2.systems.Report": lambda _: fuzzy2.Type1System(
        [[fuzzy2.Gaussian(0.0, 0.1), fuzzy2.Gaussian(1.0, 0.1)]], [[0], [1]], [[0.0], [1.0]]
    ).validate(),
    "Report": lambda _: Report(
        np.arange(2.0),
        np.ones(2),
        np.zeros(2, dtype=np.int64),
        (("a", "b"),),
        0.0,
        Contact(0.0, delta().reference, None),
        None,
    ),
    "Contact": lambda _: Contact(0.0, delta().reference, None),
    "Identified": lambda _: identified(),
    # Sets, systems and learners.
    "ANFIS": lambda _: fuzzy2.ANFIS().fit(*samples()),
    "AdaptiveConsequents": lambda _: fuzzy2.AdaptiveConsequents(
        fuzzy2.Type1System(terms(), RULES, NUMBERS)
    ),
    "AnYaSystem": lambda _: fuzzy2.AnYaSystem(
        [[1.0, 3.0], [5.0]],
        [0, 1],
        fuzzy2.Type1System([[fuzzy2.Gaussian(0.0, 1.0)] * 2] * 2, [[0, 0], [1, 1]], [[0.0], [1.0]]),
    ),
    "Bell": lambda _: fuzzy2.Bell(0.0, 1.0, 2.0),
    "Clusters": lambda _: fuzzy2.fuzzy_c_means(samples()[0], 3),
    "Complement": lambda _: fuzzy2.Complement(fuzzy2.Gaussian(0.0, 1.0)),
    "FineTuning": lambda _: fuzzy2.fine_tune(
        fuzzy2.Type1System(terms(), RULES, NUMBERS), *samples(), np.random.default_rng(1)
    ),
    "FunctionalSet": lambda _: fuzzy2.FunctionalSet(square, -1.0, 1.0),
    "FunctionalType2Set": lambda _: fuzzy2.FunctionalType2Set(moved, 0.0, 1.0),
    "FuzzyClassifier": lambda _: fuzzy2.FuzzyClassifier().fit(samples()[0], samples()[1] > 0.25),
    "FuzzyNumber": lambda _: fuzzy2.FuzzyNumber([0.0, 1.0], [3.0, 2.0], [0.0, 1.0]),
    "Gaussian": lambda _: fuzzy2.Gaussian(0.0, 1.0),
    "GaussianNumber": lambda _: fuzzy2.GaussianNumber(0.0, 1.0),
    "GaussianType2Set": lambda _: fuzzy2.GaussianType2Set(fuzzy2.Gaussian(0.0, 1.0), 0.1),
    "GaussianUncertainMean": lambda _: fuzzy2.GaussianUncertainMean((0.0, 1.0), 1.0),
    "GaussianUncertainSigma": lambda _: fuzzy2.GaussianUncertainSigma(0.0, (1.0, 2.0)),
    "GeneralType2System": lambda _: fuzzy2.GeneralType2System(
        [[fuzzy2.GaussianType2Set(one, 0.1) for one in row] for row in terms()], RULES, NUMBERS
    ),
    "Interval": lambda _: fuzzy2.Interval(0.0, 1.0),
    "IntervalNumber": lambda _: fuzzy2.IntervalNumber(0.0, 1.0),
    "IntervalType2Set": lambda _: fuzzy2.IntervalType2Set(
        fuzzy2.Gaussian(0.0, 1.0), fuzzy2.Gaussian(0.0, 2.0)
    ),
    "IntervalType2System": lambda _: fuzzy2.IntervalType2System(
        [[fuzzy2.GaussianUncertainMean((m, m + 0.1), 0.3) for m in (0.0, 1.0)]] * 2, RULES, NUMBERS
    ),
    "Linear": lambda _: fuzzy2.Linear(np.ones((4, 1, 3))),
    "NamedShape": lambda _: fuzzy2.NamedShape("cosine", (0.0, 1.0)),
    "NonSingletonFuzzifier": lambda _: fuzzy2.NonSingletonFuzzifier(fuzzy2.Gaussian(0.0, 0.1)),
    "ParallelSystem": lambda _: fuzzy2.ParallelSystem(
        [fuzzy2.Type1System(terms(), RULES, NUMBERS, output_names=[name]) for name in "ab"]
    ),
    "PiShaped": lambda _: fuzzy2.PiShaped(0.0, 1.0, 2.0, 3.0),
    "Rule": lambda _: fuzzy2.Rule({"x": "low"}, {"y": "high"}),
    "SampledSet": lambda _: fuzzy2.SampledSet([0.0, 1.0, 2.0], [0.0, 1.0, 0.0]),
    "SampledType2Set": lambda _: fuzzy2.SampledType2Set(
        [0.0, 1.0], [fuzzy2.Interval(0.0, 0.5), fuzzy2.Interval(0.2, 0.9)]
    ),
    "Sigmoid": lambda _: fuzzy2.Sigmoid(0.0, 1.0),
    "SigmoidDifference": lambda _: fuzzy2.SigmoidDifference((0.0, 1.0), (1.0, 1.0)),
    "SigmoidProduct": lambda _: fuzzy2.SigmoidProduct((0.0, 1.0), (1.0, -1.0)),
    "Singleton": lambda _: fuzzy2.Singleton(1.0),
    "SingletonFuzzifier": lambda _: fuzzy2.SingletonFuzzifier(),
    "Trapezoidal": lambda _: fuzzy2.Trapezoidal(0.0, 1.0, 2.0, 3.0),
    "Triangular": lambda _: fuzzy2.Triangular(0.0, 1.0, 2.0),
    "TwoSidedGaussian": lambda _: fuzzy2.TwoSidedGaussian((0.0, 1.0), (1.0, 2.0)),
    "Type1System": lambda _: fuzzy2.Type1System(terms(), RULES, NUMBERS),
    "WangMendel": lambda _: fuzzy2.WangMendel().fit(*samples()),
    "ZSlices": lambda _: fuzzy2.ZSlices(
        (0.5, 1.0),
        (
            fuzzy2.IntervalType2Set(fuzzy2.Gaussian(0.0, 1.0), fuzzy2.Gaussian(0.0, 2.0)),
            fuzzy2.Gaussian(0.0, 1.5),
        ),
    ),
}


NO_NUMBERS = ("_spare", "_kernels", "_is_compiled", "_partly")
"""Attributes that hold room for answers, and what is compiled, which each copy does by itself."""


def numbers_in(thing: Any, seen: frozenset[int] = frozenset()) -> Any:
    """Return all numbers and words that an object holds, as plain data that can be compared."""
    if id(thing) in seen:
        return "itself"
    within = seen | {id(thing)}
    if isinstance(thing, np.ndarray):
        if thing.dtype == object:
            return [numbers_in(one, within) for one in thing.ravel()]
        return str(thing.dtype), thing.shape, thing.tobytes()
    if isinstance(thing, str | bytes | int | float | complex | type | Path | None):
        return repr(thing)
    if isinstance(thing, Mapping):
        return {str(key): numbers_in(value, within) for key, value in thing.items()}
    if isinstance(thing, list | tuple | set | frozenset):
        return [numbers_in(one, within) for one in thing]
    if isinstance(thing, types.FunctionType | types.BuiltinFunctionType | types.ModuleType):
        return thing.__name__
    # Pinocchio's, MuJoCo's and CasADi's are asked, below.
    if type(thing).__module__.split(".")[0] not in ("psp3", "fuzzy2"):
        return type(thing).__name__
    return {
        name: numbers_in(value, within)
        for name, value in sorted(getattr(thing, "__dict__", {}).items())
        if name not in NO_NUMBERS
        and not isinstance(_of_class(thing, name), functools.cached_property)
    }


def _of_class(thing: Any, name: str) -> Any:
    """Return what the class has of that name. What is made when it is asked for is not held."""
    return inspect.getattr_static(type(thing), name, None)


X, T = np.array([[0.2, 0.7], [0.4, 0.1]]), np.linspace(0.0, 0.1, 5)


def answers(one: Any) -> list[bytes]:
    """Return what an object answers to a question of its kind, or nothing where it only holds."""
    for kind, question in QUESTIONS.items():
        if hasattr(one, kind) if isinstance(kind, str) else isinstance(one, kind):
            return [np.asarray(found).tobytes() for found in question(one)]
    return []


def _symbolic(one: Any) -> Iterator[Any]:
    q = one.robot.reference if isinstance(one, SymbolicPSP3) else one.robot.q0
    n = len(one.robot.reference)
    yield one.inverse_dynamics(q, np.full(n, 0.1), np.full(n, 0.2))


def _forces(one: Any) -> Iterator[Any]:
    positions = getattr(one, "robot", one).reference + 0.01
    yield from one.equation_of_motion(positions, np.full(3, 0.1))


def _in_mujoco(one: Any) -> Iterator[Any]:
    one.start(delta().reference, np.zeros(3))
    for _ in range(5):
        yield from one.advance(np.zeros(3), 0.001)


def _adapted(one: Any) -> Iterator[Any]:
    one.reset()
    yield one.update(X, np.ones((2, 1)))
    yield one(X)


def _torques(one: Any) -> Iterator[Any]:
    robot = delta() if isinstance(one, OF_THE_DELTA) else psp()
    if isinstance(one, psp3.ComputedTorque):
        robot = one.model
    way = PointToPoint(robot.reference, robot.reference + 0.01, 0.1, robot)
    one.reset()
    for k in range(3):
        wanted = way(np.array([0.002 * k]))
        desired = type(wanted)(*(None if row is None else row[0] for row in wanted))
        yield one.torque(0.002 * k, robot.reference, np.full(3, 0.01), desired)


OF_THE_DELTA = (
    psp3.TaskSpaceComputedTorque,
    psp3.LinearQuadraticRegulator,
    psp3.TimeVaryingLinearQuadraticRegulator,
)

QUESTIONS: dict[Any, Callable[[Any], Any]] = {
    SymbolicPSP3 | SymbolicRobot: _symbolic,
    "equation_of_motion": _forces,
    psp3.FuzzyComputedTorque | psp3.AdaptiveFuzzyComputedTorque: _torques,
    psp3.PD | psp3.PID | psp3.FeedForward | psp3.GravityCompensatedPD: _torques,
    psp3.ComputedTorque | OF_THE_DELTA[0] | OF_THE_DELTA[1] | OF_THE_DELTA[2]: _torques,
    psp3.trajectories.Trajectory: lambda one: one(T)[:3],
    psp3.MuJoCo: _in_mujoco,
    psp3.TrackingTube: lambda one: [one.around(result())],
    psp3.SingularityAnalysis: lambda one: one.measures(five_bar().q0),
    fuzzy2.FuzzySystem | fuzzy2.AnYaSystem | fuzzy2.ParallelSystem: lambda one: [one(X)],
    fuzzy2.AdaptiveConsequents: _adapted,
    "predict": lambda one: [one.predict(X)],
    fuzzy2.Type1Set: lambda one: [one(X)],
    fuzzy2.IntervalType2Set: lambda one: [one.footprint(X)],
    fuzzy2.GeneralType2Set: lambda one: [one.alpha_plane(0.5).footprint(X)],
    "membership": lambda one: [one.membership(X[0])],
}
"""What is asked of a kind, or of what has an attribute of this name; of several, the first."""
