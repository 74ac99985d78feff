"""Controllers that are written in C: every kind that the package has, each on several robots."""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import fuzzy2
import psp3
from psp3.study.controllers import WithIntegral
from psp3.trajectories import Helix, Sway
from tests.psp3.export.controller_in_c import states
from tests.psp3.export.robots_of_all_kinds import MAKERS

States = list[tuple[Any, ...]]

SPREAD = {"psp3": 0.02, "walker": 0.02, "rod": 0.02}
"""How far states are from the reference [m, rad]; 0.1 of other robots."""


@cache
def robot_of(name: str) -> Any:
    """Return a robot of the package, or one of those for export."""
    if name == "psp3":
        return psp3.load(name)
    with tempfile.TemporaryDirectory() as folder:
        return MAKERS[name](Path(folder))


class Kind(NamedTuple):
    """A kind of controller.

    How it is made, the ``robots`` that it is tested on, one of which has its code ``checked`` by
    other compilers, and how far its forces may be off in single precision, as a share of the
    largest.
    """

    make: Callable[[Any], Any]
    robots: tuple[str, ...]
    single: float
    checked: str = "psp3"


DIRECT, CLOSED, FAR, LEARNED = 1e-6, 1e-5, 5e-3, 2e-6
"""Bounds: a few roundings of 6e-8; with a model, which sums up tens of them; of regulators, whose
forces grow with the model's where desired poses are far out, near singular ones; of rules, whose
weights are a few roundings off.
"""

FLOATING, FEWER = "walker", "gripper"
"""Four motors and a floating base; one motor, which two springs follow."""

WITHOUT_MODEL = ("psp3", "planar_4rrr", FLOATING)
"""The second has more motors than coordinates."""


def gains(robot: Any) -> np.ndarray:
    """Return a matrix of gains in which no two entries are the same."""
    k = robot.commanded
    return 50.0 * np.eye(k) + np.arange(k * k).reshape(k, k)


def regulator(robot: Any) -> Any:
    """Return a regulator that accepts errors of 1 cm (rad/100) for forces of 30 N (N m)."""
    n = len(robot.coordinates)
    weight = 1e-3 * np.eye(robot.commanded)
    return psp3.LinearQuadraticRegulator(robot, 1e4 * np.eye(2 * n), weight)


def along_a_path(robot: Any) -> Any:
    """Return a regulator whose gains change, for a fifth of a second."""
    n = len(robot.coordinates)
    path = Sway(robot=robot)
    return psp3.TimeVaryingLinearQuadraticRegulator(
        robot, path, 0.2, 1e4 * np.eye(2 * n), 1e-3 * np.eye(n)
    )


TASKS = {
    "five_bar": ("x", "z"),
    "planar_4rrr": ("x", "y", "rz"),
    "gough_stewart": ("x", "y", "z", "rx", "ry", "rz"),
}
"""Coordinates of a tip that is not moved along three axes."""


def on_a_frame(robot: Any) -> Any:
    """Return computed torque on the tip, which states come near the border of its reach with."""
    task = TASKS.get(robot.title, ("x", "y", "z"))
    return psp3.TaskSpaceComputedTorque(robot, 25.0, 4.0, task=task, damped_below=0.6)


CLASSICAL: dict[str, Kind] = {
    "PD": Kind(lambda robot: psp3.PD(100.0, 10.0, robot), WITHOUT_MODEL, DIRECT),
    "PD of matrices": Kind(
        lambda robot: psp3.PD(gains(robot), 0.1 * gains(robot), robot), WITHOUT_MODEL, DIRECT
    ),
    "PID": Kind(
        lambda robot: psp3.PID(4000.0, 300.0, 50.0, robot), (*WITHOUT_MODEL[:2], FEWER), DIRECT
    ),
    "PD with gravity": Kind(psp3.GravityCompensatedPD, (*WITHOUT_MODEL, FEWER), CLOSED),
    "feed-forward": Kind(psp3.FeedForward, ("psp3", "delta", FEWER, FLOATING), CLOSED),
    "CTC": Kind(
        psp3.ComputedTorque, ("psp3", "delta", "five_bar", "planar_4rrr", FEWER), CLOSED, "delta"
    ),
    "CTC of a robot that floats": Kind(
        lambda robot: psp3.ComputedTorque(robot, 100.0, 20.0), (FLOATING,), CLOSED, FLOATING
    ),
    "CTC with an integral": Kind(
        lambda robot: WithIntegral(robot, 100.0, 20.0, 30.0),
        ("psp3", "delta", "planar_4rrr"),
        CLOSED,
    ),
    "LQR": Kind(regulator, ("psp3", "five_bar", "planar_4rrr", "rod"), FAR, "planar_4rrr"),
    "LQR along a path": Kind(along_a_path, ("psp3", "five_bar", "planar_4rrr"), FAR),
    "on a frame": Kind(
        on_a_frame,
        ("psp3", "delta", "five_bar", "planar_4rrr", "gough_stewart"),
        CLOSED,
        "five_bar",
    ),
}

OPTIONS: dict[str, dict[str, Any]] = {
    "t1": {"kind": "t1"},
    "it2": {"kind": "it2"},
    "gt2": {"kind": "gt2"},
    "gt2 last": {"kind": "gt2", "defuzzify": "last"},
    "corollary": {"kind": "gt2", "reduction": "gaussian"},
    "crisp outside": {"kind": "it2", "outside": "crisp"},
    "gt2 last, crisp outside": {"kind": "gt2", "defuzzify": "last", "outside": "crisp"},
    "corollary, crisp outside": {"kind": "gt2", "reduction": "gaussian", "outside": "crisp"},
    "average": {"kind": "it2", "learner": "average"},
    "C of M": {"kind": "t1", "coriolis": "mass"},
    "C of M, it2": {"kind": "it2", "coriolis": "mass"},
    "C of M, gt2 last": {"kind": "gt2", "coriolis": "mass", "defuzzify": "last"},
    "C of M, corollary": {"kind": "gt2", "coriolis": "mass", "reduction": "gaussian"},
}
"""Of controllers that learn."""


def path_of(robot: Any) -> Any:
    """Return the helix of the 3-PSP, or another robot's sway."""
    return Helix(robot=robot) if robot.has_inverse_of_tip else Sway(robot=robot)


def trained(robot: Any, kind: str) -> Any:
    """Return a controller learned from noisy samples of a second and a half."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fuzzy2.ApproximationWarning)
        controller = psp3.FuzzyComputedTorque(robot=robot, snr_db=20.0, **OPTIONS[kind])
        return controller.fit(path_of(robot), 1.5, rng=np.random.default_rng(5))


LEARNS = ("psp3", "five_bar", "delta")
"""Robots whose coordinates are their motors, as those must be that are learned from."""

DERIVES = ("five_bar", "delta", "planar_3rrr")
"""Robots whose C may come from M."""


def _learned(kind: str) -> Kind:
    robots = DERIVES if kind.startswith("C of M") else LEARNS
    return Kind(lambda robot: trained(robot, kind), robots, LEARNED, robots[0])


def _adaptive(kind: str) -> Kind:
    robots = DERIVES if kind.startswith("C of M") else LEARNS
    return Kind(
        lambda robot: psp3.AdaptiveFuzzyComputedTorque(trained(robot, kind)),
        robots,
        LEARNED,
        robots[0],
    )


FUZZY = {kind: _learned(kind) for kind in OPTIONS}
ADAPTIVE = {
    f"adaptive, {kind}": _adaptive(kind)
    for kind in ("t1", "it2", "average", "C of M", "C of M, it2")
}

KINDS = CLASSICAL | FUZZY | ADAPTIVE


@cache
def made(kind: str, name: str) -> Any:
    """Return a controller of a robot, the same one in every test."""
    return KINDS[kind].make(robot_of(name))


def states_of(kind: str, name: str, count: int) -> States:
    """Return states that a controller is given: what adapts follows a path, others are anywhere."""
    robot = robot_of(name)
    if kind in ADAPTIVE:
        return _along(robot, count)
    rows = states(robot, count, SPREAD.get(name, 0.1))
    turn = {7: 4, 4: 2}.get(getattr(robot.compiled_table(), "base", 0), 0)
    for _, positions, _, _ in rows:
        # A quaternion, or cosine and sine, of unit length, but for numbers that are none.
        if turn and np.isfinite(positions).all():
            positions[-turn:] /= np.linalg.norm(positions[-turn:])
    return rows


def _along(robot: Any, count: int) -> States:
    """Return states on the path, with errors of 3 mm (mrad): the rules learn from what comes."""
    t, rng = 0.002 * np.arange(count), np.random.default_rng(0)
    motion = path_of(robot)(t)
    positions = motion.positions + rng.normal(0.0, 0.003, motion.positions.shape)
    speeds = motion.speeds + rng.normal(0.0, 0.02, positions.shape)
    desired = np.concatenate(motion[:3], axis=1)
    rows = list(zip(t.tolist(), positions, speeds, desired, strict=True))
    rows[count // 2][1][0] = np.nan  # a reading that is none: nothing is learned from it
    return rows
