"""The tasks of every entry: robots, paths, the gains of the servo, and the record.

The three robots differ in their inputs: the 3-PSP has four differences, the Delta robot three hinge
angles and their speeds, and the Gough–Stewart platform six leg lengths and their speeds, twelve
inputs. (The five-bar robot would be the easiest, and adds nothing to the Delta robot.)

Each has two paths of one kind. Entries learn from a record of the first, and are scored on both.
The second has four fifths of the size and takes four fifths of the time. All runs start on the path
with its speed, so errors come from the model and not from a jump at the start.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from scipy.spatial.distance import pdist

from psp3.checks import Array, known_name
from psp3.fuzzy_control.records import Record, record
from psp3.loading import load
from psp3.published import DURATION, TABLE_6_1
from psp3.robots.robot import Robot
from psp3.trajectories.motion import Motion
from psp3.trajectories.paths import Helix
from psp3.trajectories.sway import Sway
from psp3.trajectories.trajectory import Trajectory

PATHS = ("trained", "untrained")
"""Names of the two paths of every robot: the recorded one, and the other."""

SMALLER = 0.8
"""Size of the untrained path, and its time for a turn, as shares of those of the trained one."""

SAMPLES = 209
"""Number of samples of the record that an entry learns from, as in the thesis."""

MOST_POINTS = 400
"""Number of points of a path from which its extent is computed."""

STIFF = (100.0, 20.0)
"""Gains of the servo of other robots than the 3-PSP [1/s²], [1/s]: critically damped."""


def _helices(robot: Robot) -> tuple[Trajectory, Trajectory]:
    return (
        Helix(radius=0.020, period=2.0, rise=0.010, robot=robot),
        Helix(radius=SMALLER * 0.020, period=SMALLER * 2.0, rise=0.012, robot=robot),
    )


def _sways(robot: Robot) -> tuple[Trajectory, Trajectory]:
    trained = Sway(period=2.0, robot=robot)
    return trained, Sway(SMALLER * float(trained.amplitudes[0]), SMALLER * 2.0, robot)


class _Kind(NamedTuple):
    """Paths and gains of a robot."""

    paths: Callable[[Robot], tuple[Trajectory, Trajectory]]
    gains: tuple[float, float]


_KINDS = {
    "psp3": _Kind(_helices, TABLE_6_1["CTC"]),
    "delta": _Kind(_sways, STIFF),
    "gough_stewart": _Kind(_sways, STIFF),
}

ROBOTS = tuple(_KINDS)
"""Names of the robots."""


@dataclass(frozen=True)
class Task:
    """A robot with its paths and gains.

    Parameters
    ----------
    name : str
        One of ``ROBOTS``.
    robot : Robot
        The robot.
    paths : dict of Trajectory
        Paths by their names in ``PATHS``.
    kp, kv : float
        Gains of the servo, the same for every entry [1/s²], [1/s].
    """

    name: str
    robot: Robot
    paths: dict[str, Trajectory]
    kp: float
    kv: float

    @cached_property
    def recorded(self) -> Record:
        """The recorded run that entries learn from: exact computed torque on the first path."""
        return record(self.robot, self.paths[PATHS[0]], DURATION, kp=self.kp, kv=self.kv)

    @property
    def joints(self) -> int:
        """Number n of actuated joints."""
        return len(self.robot.reference)

    def inputs_of(self, positions: Array, speeds: Array) -> Array:
        """Return the inputs of M, C and G at positions and speeds (..., n)."""
        return self.robot.learning_inputs.of(positions, speeds)

    def desired(self, path: str, duration: float, period: float) -> tuple[Array, Motion]:
        """Return the times of the control periods [s] and the desired motion at them."""
        t = period * np.arange(int(duration / period * (1.0 + 1e-12) + 1e-9) + 1, dtype=np.float64)
        return t, self.paths[path](t)

    def extent(self, path: str, duration: float, period: float) -> float:
        """Return the greatest distance between two desired positions of the tip [m].

        It is the worst error of a run: a run that loses the robot gets it.
        """
        _, motion = self.desired(path, duration, period)
        # Both ends, and some points between, because all pairs of thousands of points are too many.
        count = min(len(motion.tip), MOST_POINTS)
        some = np.linspace(0, len(motion.tip) - 1, count).round().astype(int)
        return float(pdist(motion.tip[some]).max())


@lru_cache(maxsize=len(ROBOTS))
def task(name: str) -> Task:
    """Return the task of a robot; each robot and record is made once per process.

    Raises
    ------
    UnknownName
        If the benchmark has no such robot.
    """
    known_name("robot of the benchmark", name, ROBOTS)
    kind, robot = _KINDS[name], load(name)
    paths = kind.paths(robot)
    kp, kv = kind.gains
    return Task(name, robot, dict(zip(PATHS, paths, strict=True)), kp, kv)
