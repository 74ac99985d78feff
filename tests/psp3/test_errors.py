"""Errors: one family, each with the values it is about, in the message and as attributes."""

from __future__ import annotations

import inspect
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fuzzy2
import fuzzy2.errors
from psp3 import errors
from psp3.closure.mobility import Mobility

HEIGHTS = np.array([0.1, 0.2, 0.3])

EXAMPLES = [
    (
        errors.UnknownName("robot", "psp4", ["psp3", "delta"]),
        {"name": "psp4", "known": ("psp3", "delta")},
        ["robot 'psp4'", "psp3, delta"],
    ),
    (
        errors.UnknownRobot("psp4", ["psp3", "delta"]),
        {"name": "psp4", "known": ("psp3", "delta")},
        ["robot 'psp4'", "psp3, delta", "psp3.load('my_robot.urdf')"],
    ),
    (
        errors.InvalidArray("heights", "(..., 3)", np.array([1.0, np.nan, 2.0])),
        {"name": "heights"},
        ["heights", "(..., 3)", "1 of its entries not finite", "nan"],
    ),
    (
        errors.InvalidArray("speeds", "(..., 3)", np.zeros((2, 4))),
        {"name": "speeds"},
        ["speeds", "shape (2, 4)"],
    ),
    (
        errors.InvalidArray("heights", "(..., 3)", "text"),
        {"name": "heights", "array": "text"},
        ["'text'"],
    ),
    (
        errors.InvalidValue("tilt", 2.0, "less than pi/2"),
        {"name": "tilt", "value": 2.0},
        ["tilt", "less than pi/2", "2.0"],
    ),
    (
        errors.UnreachablePose(HEIGHTS, np.array([0.2, -0.01, 0.2])),
        {"heights": HEIGHTS, "arms": np.array([0.2, -0.01, 0.2])},
        ["0.1", "-0.01", "70.53"],
    ),
    (
        errors.UnreachableTip(np.array([0.03, 0.0, 0.1]), 0.03, 0.5, 0.0239),
        {"tip": np.array([0.03, 0.0, 0.1]), "radius": 0.03, "azimuth": 0.5, "reach": 0.0239},
        ["30.0 mm", "28.6 degrees", "23.9 mm"],
    ),
    (
        errors.StrokeExceeded(1.25, HEIGHTS, np.full(3, -0.4), np.full(3, 0.4)),
        {"time": 1.25, "heights": HEIGHTS, "lower": np.full(3, -0.4), "upper": np.full(3, 0.4)},
        ["1.25 s", "0.2", "-0.4", "0.4"],
    ),
    (
        errors.OpenLoops(0.0123, 1e-6),
        {"residual": 0.0123, "tolerance": 1e-6},
        ["0.0123", "1e-06", "robot.configuration(heights)"],
    ),
    (
        errors.ClosureFailed(HEIGHTS, 0.5, 0.25),
        {"positions": HEIGHTS, "residual": 0.5, "reached": 0.25},
        ["0.2", "0.5", "25 %"],
    ),
    (
        errors.ClosureFailed(np.zeros(0), 0.5, 0.0),
        {"residual": 0.5},
        ["the loops could not be closed near the reference pose"],
    ),
    (
        errors.JointLimitExceeded("b1", -0.031, 0.0, 0.6),
        {"joint": "b1", "position": -0.031, "lower": 0.0, "upper": 0.6},
        ["'b1'", "-0.031", "0 to 0.6"],
    ),
    (
        errors.InconsistentVelocity(0.75, 1e-8),
        {"residual": 0.75, "tolerance": 1e-8},
        ["0.75", "1e-08", "v = L(q) @ speeds"],
    ),
    (
        errors.SingularConfiguration(11, 12, 1.5e16),
        {"rank": 11, "needed": 12, "condition": 1.5e16},
        ["11 of 12", "1.5e+16"],
    ),
    (
        errors.NoFiniteAnswer(HEIGHTS),
        {"positions": HEIGHTS},
        ["0.2", "smaller speeds or forces", "mass or inertia"],
    ),
    (
        errors.MobilityMismatch(Mobility(3, 2, 2, 15, 12, 12, ("a3", "b3"), ()), ["a1", "a2"]),
        {"actuated": ("a1", "a2")},
        ["3 degrees of freedom", "2 actuated", "a1, a2", "a3, b3 can still move"],
    ),
    (
        errors.UnphysicalInertia("nut1", np.array([0.003, 0.3294, 0.39])),
        {"body": "nut1", "moments": np.array([0.003, 0.3294, 0.39])},
        ["'nut1'", "0.39", "none may exceed"],
    ),
    (
        errors.MasslessBody("cross", True, 1),
        {"body": "cross", "closed": True, "children": 1},
        ["'cross' has no mass", "a loop closes on it"],
    ),
    (
        errors.UnexportableJoint("j1", "it turns and slides at once"),
        {"joint": "j1", "reason": "it turns and slides at once"},
        ["'j1'", "turns and slides"],
    ),
    (
        errors.NoStabilizingSolution(np.array([0.5 + 0.0j, -1.0 + 0.0j]), 0.002),
        {"poles": np.array([0.5 + 0.0j, -1.0 + 0.0j]), "period": 0.002},
        ["0.5", "unit circle", "0.002 s"],
    ),
    (
        errors.DisorderedJoints("d", "b"),
        {"joint": "d", "parent": "b"},
        ["'d'", "'b'", "finish every chain"],
    ),
    (
        errors.UnsupportedJoint("glide", "JointModelPlanar"),
        {"joint": "glide", "kind": "JointModelPlanar"},
        ["'glide'", "JointModelPlanar"],
    ),
    (
        errors.PoorExcitation("base parameters", 5, 7),
        {"what": "base parameters", "rank": 5, "needed": 7},
        ["5 of 7 base parameters", "richer motion"],
    ),
    (
        errors.InvalidRobotFile("some.yaml", "lacks the key type"),
        {"reason": "lacks the key type"},
        ["some.yaml", "lacks the key type"],
    ),
    (
        errors.OverlappingShapes([("nut1", "ball_lambda1")], [0.005]),
        {"pairs": (("nut1", "ball_lambda1"),), "depths": (0.005,)},
        ["'nut1' and 'ball_lambda1' by 5 mm", "disable_collisions"],
    ),
    (
        errors.CollisionFound(0.62, ("nut1", "ball_lambda1"), 0.0, 0.0, 0.7, -0.0024),
        {
            "time": 0.62,
            "links": ("nut1", "ball_lambda1"),
            "distance": 0.0,
            "clearance": 0.0,
            "worst_time": 0.7,
            "worst_distance": -0.0024,
        },
        ["t = 0.62 s", "'nut1' and 'ball_lambda1' touch", "0.7 s, 2.4 mm in each other"],
    ),
    (
        errors.InvalidEntry("mine.py", "must have one class"),
        {"path": Path("mine.py"), "reason": "must have one class"},
        ["mine.py", "must have one class"],
    ),
    (
        errors.InvalidControllerFile("some.json", "lacks 'kp'"),
        {"reason": "lacks 'kp'"},
        ["some.json", "lacks 'kp'"],
    ),
    (
        errors.UnusableEstimate(-np.eye(3)),
        {"mass": -np.eye(3)},
        ["-1.", "not positive definite", "more samples or less noise"],
    ),
    (
        errors.UnusableEstimate(-np.eye(3), 0.0125),
        {"mass": -np.eye(3), "told_apart": 0.0125},
        ["-1.", "a share of 0.013 of the accelerations", "more harmonics"],
    ),
    (
        errors.InvalidTrajectoryFile("some.csv", "no rows"),
        {"reason": "no rows"},
        ["some.csv", "no rows"],
    ),
    (
        errors.InvalidMapFile("some.json", "cut off"),
        {"reason": "cut off"},
        ["some.json", "cut off"],
    ),
    (
        errors.InvalidResultFile("some.npz", "cut off"),
        {"reason": "cut off"},
        ["some.npz", "cut off"],
    ),
    (
        errors.InvalidStudyFile("some.sqlite", "damaged"),
        {"reason": "damaged"},
        ["some.sqlite", "damaged"],
    ),
    (
        errors.StudyMismatch("some.sqlite", "format version", 2, 1),
        {"what": "format version", "found": 2, "expected": 1},
        ["some.sqlite", "format version is 2, not 1", "another file"],
    ),
    (
        errors.LoopsDoNotClose(np.zeros(3), 0.25, "tip-top", 31),
        {"residual": 0.25, "loop": "tip-top", "tried": 31},
        ["31 starts", "loop 'tip-top'", "0.25", "home"],
    ),
    (
        errors.RoundedLoops("tip-top", 0.01, 0.02, 0),
        {"loop": "tip-top", "length": 0.01, "angle": 0.02, "freedoms": 0},
        ["'tip-top'", "0.01 m", "0.02 rad", "0 degrees of freedom", "more digits"],
    ),
    (
        errors.DependentCoordinates("m2", ["m1", "p1"]),
        {"joint": "m2", "others": ("m1", "p1")},
        ["'m2'", "m1, p1", "coordinates=[...]"],
    ),
    (
        errors.DependentCoordinates("", []),
        {"joint": "", "others": ()},
        ["coordinates=[...]", "FIXED"],
    ),
    (
        errors.UnreachableForces(0.5, ["m1", "p1"]),
        {"residual": 0.5, "coordinates": ("m1", "p1")},
        ["0.5 (N or N m)", "m1, p1", "forward_dynamics"],
    ),
]


@pytest.mark.parametrize(
    ("error", "attributes", "words"),
    EXAMPLES,
    ids=lambda value: type(value).__name__ if isinstance(value, Exception) else "",
)
def test_error_carries_its_values_and_names_them(
    error: Exception, attributes: dict[str, object], words: list[str]
) -> None:
    assert isinstance(error, errors.PSP3Error)
    assert isinstance(error, ValueError)
    for name, value in attributes.items():
        np.testing.assert_array_equal(getattr(error, name), value)
    for word in words:
        assert word in str(error)
    assert "\n" not in str(error)


@pytest.mark.parametrize(
    ("error", "attributes", "words"),
    EXAMPLES,
    ids=lambda value: type(value).__name__ if isinstance(value, Exception) else "",
)
def test_error_survives_the_way_back_from_a_worker_process(
    error: Exception, attributes: dict[str, object], words: list[str]
) -> None:
    """Studies run in worker processes.

    An error that cannot be unpickled takes the whole pool down instead of being reported.
    """
    copy = pickle.loads(pickle.dumps(error))
    assert type(copy) is type(error)
    assert str(copy) == str(error)
    for name, value in attributes.items():
        np.testing.assert_array_equal(getattr(copy, name), value)


def test_every_error_about_an_argument_has_an_example_here() -> None:
    """Those that end a motion on the way are RuntimeErrors and are tested where they are raised."""
    classes = [
        cls
        for _, cls in inspect.getmembers(errors, inspect.isclass)
        if issubclass(cls, errors.PSP3Error)
    ]
    assert {cls for cls in classes if issubclass(cls, ValueError)} - {errors.InvalidFile} == {
        type(error) for error, _, _ in EXAMPLES
    }
    assert all(
        issubclass(cls, ValueError | RuntimeError) for cls in classes if cls is not errors.PSP3Error
    )


def test_a_warning_carries_its_values_and_the_remedy() -> None:
    """Correlation 0.8 falls to a tenth within 11 samples, and 0.01 is less than that at once."""
    warning = errors.CorrelatedResiduals("a1", 0.8, 7.25, 90, 10.0)
    assert isinstance(warning, UserWarning)
    assert (warning.joint, warning.correlation, warning.deviation) == ("a1", 0.8, 7.25)
    assert (warning.samples, warning.effective, warning.step) == (90, 10.0, 11)
    for word in ("'a1'", "0.80", "7.2", "90 samples", "10 independent", "every 11th sample"):
        assert word in str(warning)
    assert str(pickle.loads(pickle.dumps(warning))) == str(warning)
    for correlation in (0.01, 1.0, -0.5):
        assert errors.CorrelatedResiduals("a1", correlation, 3.0, 90, 90.0).step == 2


def test_errors_about_files_are_caught_by_their_base() -> None:
    about_files = [error for error, _, _ in EXAMPLES if type(error).__name__.endswith("File")]
    assert len(about_files) == 6
    for error in about_files:
        assert isinstance(error, errors.InvalidFile)
        assert str(error) == f"{error.path}: {error.reason}"


def test_what_both_packages_call_the_same_is_caught_by_either() -> None:
    """A wrong value stays one, whichever package finds it."""
    for name in ("UnknownName", "InvalidValue"):
        ours, theirs = getattr(errors, name), getattr(fuzzy2.errors, name)
        assert issubclass(ours, theirs)
        assert issubclass(ours, errors.PSP3Error)
        assert not issubclass(theirs, errors.PSP3Error)
    # Nothing else of this package passes for an error of the other.
    assert {
        name
        for name, cls in inspect.getmembers(errors, inspect.isclass)
        if issubclass(cls, fuzzy2.Fuzzy2Error)
    } == {"UnknownName", "UnknownRobot", "InvalidValue"}


@pytest.mark.parametrize("kind", [errors.InvalidValue, fuzzy2.errors.InvalidValue])
def test_a_long_value_is_cut_short(kind: Any) -> None:
    assert str(kind("a", "x" * 100, "b")) == f"a must be b, got {'x' * 100!r}"
    assert len(str(kind("a", "x" * 500, "b"))) < 150


def test_an_interrupted_study_survives_the_way_back_from_a_worker_process() -> None:
    error = errors.StudyInterrupted("some.sqlite", 3, 10)
    copy = pickle.loads(pickle.dumps(error))
    assert (type(copy), copy.path, copy.done, copy.total) == (
        errors.StudyInterrupted,
        error.path,
        3,
        10,
    )
    assert not isinstance(copy, Exception)


@pytest.mark.parametrize("shape", [(2, 3), (4, 3), (12,), (2, 2, 3), (500, 3)])
def test_messages_stay_on_one_line(shape: tuple[int, ...]) -> None:
    """Numpy breaks lines between rows and at 75 characters.

    The command line promises one clear line.
    """
    values = np.linspace(0.123456, 0.987654, int(np.prod(shape))).reshape(shape)
    for error in (
        errors.InvalidArray("heights", "(..., 3)", np.where(values < 0.2, np.nan, values)),
        errors.UnreachablePose(values, values),
        errors.ClosureFailed(values, 0.5, 0.2),
    ):
        assert "\n" not in str(error)


def test_long_arrays_do_not_flood_the_message() -> None:
    error = errors.InvalidArray("heights", "(..., 3)", np.full((10_000, 3), np.nan))
    assert "30000 of its entries" in str(error)
    assert len(str(error)) < 400
