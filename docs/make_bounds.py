"""Measure how often runs keep a tracking tube, and torques an interval, and how wide these are.

Prints the rows of the tables of ``docs/concepts/bounds.md``, all or some::

    OMP_NUM_THREADS=1 python docs/make_bounds.py
    OMP_NUM_THREADS=1 python docs/make_bounds.py five_bar_learned intervals

A quarter of an hour of one core; least squares this small take ten times as long on more threads.
Everything random has a seed.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
from scipy.stats import spearmanr

import psp3
from psp3.bounds import ConformalIntervals
from psp3.bounds.torque_intervals import SCALES
from psp3.checks import Array
from psp3.fuzzy_control.records import record
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from psp3.study import statistics
from psp3.trajectories.motion import Motion
from psp3.trajectories.trajectory import Trajectory

CALIBRATION, TEST, DRAWS = 60, 200, 40
"""Runs that calibrate and that test, and how often it is drawn which do."""

GAINS = (100.0, 20.0)
"""Of the calibration runs: critically damped."""

DURATION, PERIOD = 6.0, 0.004

SPREAD = 0.05
"""Standard deviation of the logarithms of masses and inertias that the controller believes."""


class Case(NamedTuple):
    """A robot with what is random in a run: seed and gains to a controller.

    ``path`` of the calibration runs and ``other``, a faster one; ``resolution`` of the encoders.
    """

    name: str
    robot: Any
    controller: Callable[[int, float, float], Any]
    path: Trajectory
    other: Trajectory
    resolution: float

    def with_servo(self, seed: int) -> Any:
        """Return a controller with the thesis's gains."""
        return self.controller(seed, 10.0, 1.0)

    def run(self, seed: int, gains: tuple[float, float], path: Trajectory) -> psp3.Result | None:
        """Return a run from the path's own start, or None if it did not reach its end."""
        start = path(np.array([0.0]))
        try:
            return psp3.simulate(
                self.robot,
                self.controller(seed, *gains),
                path,
                DURATION,
                PERIOD,
                initial_positions=start.positions[0],
                initial_speeds=start.speeds[0],
                encoder_resolution=self.resolution,
            )
        except psp3.errors.SimulationDiverged:
            return None


def believed(robot: ClosedLoopRobot, rng: np.random.Generator) -> ClosedLoopRobot:
    """Return the robot as a controller believes it: with masses and inertias that are off."""
    model = robot.model.copy()
    for i, body in enumerate(model.inertias):
        if i and body.mass > 0.0:
            mass, turn = np.exp(SPREAD * rng.standard_normal(2))
            model.inertias[i] = pin.Inertia(body.mass * mass, body.lever, body.inertia * turn)
    options = robot.options
    parts = robot.constraint_models, robot.actuated, robot.q0, robot.visual_model
    return ClosedLoopRobot(model, *parts, **options)


def with_wrong_masses(name: str, amplitude: float, resolution: float) -> Case:
    """Return the case of a robot whose controller believes other masses, seed by seed."""
    robot = psp3.load(name)
    assert isinstance(robot, ClosedLoopRobot)

    def controller(seed: int, kp: float, kv: float) -> psp3.ComputedTorque:
        model = believed(robot, np.random.default_rng(seed))
        return psp3.ComputedTorque(model, kp, kv)

    paths = [psp3.trajectories.Sway(amplitude, period, robot) for period in (2.0, 1.6)]
    return Case(f"{name}, wrong masses", robot, controller, paths[0], paths[1], resolution)


def with_learned_rules(
    name: str, path: Trajectory, other: Trajectory, learner: str | None = None, kind: str = "it2"
) -> Case:
    """Return the case of rules that a robot learned from noisy records, seed by seed."""
    robot: Any = path.robot
    recorded = record(robot, path, 10.4, kp=10.0, kv=1.0)

    def controller(seed: int, kp: float, kv: float) -> psp3.FuzzyComputedTorque:
        fuzzy = psp3.FuzzyComputedTorque(kind, robot, learner=learner, snr_db=20.0, kp=kp, kv=kv)
        return fuzzy.learn(recorded, rng=np.random.default_rng(seed))

    how = "averages" if learner == "average" else "learned"
    return Case(f"{name}, {how} at 20 dB", robot, controller, path, other, 0.0)


def learned_3psp() -> Case:
    """Return the case of the 3-PSP on a helix."""
    robot = psp3.load("psp3")
    helix, faster = (
        psp3.trajectories.Helix(radius=radius, period=period, rise=0.010, robot=robot)
        for radius, period in ((0.020, 2.0), (0.018, 1.6))
    )
    return with_learned_rules("psp3", helix, faster, "average")


AMPLITUDES = {"five_bar": 0.1, "delta": 0.1, "gough_stewart": 0.05}
"""How far other robots sway [rad or m]."""


def learned(name: str, learner: str | None = None) -> Case:
    """Return the case of any other robot, which sways; by default with least squares."""
    robot = psp3.load(name)
    paths = [psp3.trajectories.Sway(AMPLITUDES[name], period, robot) for period in (2.0, 1.6)]
    return with_learned_rules(name, paths[0], paths[1], learner)


KINDS = (
    ("as calibrated", GAINS, False),
    ("gains 400, 40", (400.0, 40.0), False),
    ("a faster path", GAINS, True),
    ("gains 100, 10", (100.0, 10.0), False),
    ("gains 10, 1", (10.0, 1.0), False),
)
"""What tubes are asked for: gains, and whether on the other path."""


def rows_of_tubes(case: Case) -> Iterator[str]:
    """Yield the rows of a robot in the table of tubes.

    Of all runs as calibrated some are drawn to calibrate, and the others test; runs of other gains
    and paths test the tubes of all these draws.
    """
    count = CALIBRATION + TEST
    alike = [case.run(seed, GAINS, case.path) for seed in range(count)]
    source = np.random.default_rng(0)
    draws = [np.arange(count)] + [source.permutation(count) for _ in range(DRAWS)]
    tubes, chosen = [], []
    for draw in draws:
        try:
            tubes.append(psp3.TrackingTube([alike[i] for i in draw[:CALIBRATION]], *GAINS))
        except psp3.errors.InvalidValue:
            # Too many of the runs did not reach their end.
            continue
        chosen.append(draw)
    name = case.name
    if len(tubes) < len(draws):
        name = f"{name} ({len(tubes)} of {len(draws)} draws)"
    for what, gains, elsewhere in KINDS:
        own = [tube.with_gains(*gains) for tube in tubes]
        if what == "as calibrated":
            tests = [[alike[i] for i in draw[CALIBRATION:]] for draw in chosen]
        else:
            path = case.other if elsewhere else case.path
            seeds = range(count, count + TEST)
            tests = [[case.run(seed, gains, path) for seed in seeds]] * len(tubes)
        kept = 100.0 * np.array(
            [
                np.mean([run is not None and tube.holds(run) for run in runs])
                for tube, runs in zip(own, tests, strict=True)
            ]
        )
        widths = np.mean([tube.width for tube in own[1:]], axis=0)
        i = int(np.argmax(widths))
        yield (
            f"| {name} | {what} | {kept[0]:.1f} % | {kept[1:].mean():.1f} % | "
            f"{1e3 * widths[i]:.3g} | {_errors(tests[0], i, widths[i])} |"
        )


def _errors(runs: list[psp3.Result | None], i: int, width: float) -> str:
    """Return worst error of a coordinate, width over it, and median of runs' greatest errors."""
    whole = [run for run in runs if run is not None]
    if len(whole) < len(runs):
        return f"{len(runs) - len(whole)} of {len(runs)} ended early | | "
    errors = [np.abs(run.desired.positions - run.positions)[:, i].max() for run in whole]
    worst = max(errors)
    return f"{1e3 * worst:.3g} | {width / worst:.2f} | {1e3 * float(np.median(errors)):.3g}"


SEEDS, CALIBRATE, ASK = 60, 300, 700
"""Of torque intervals: seeds, and states that calibrate and that are asked."""

NOISE, NEAR = 0.01, 0.1
"""Noise on torques in shares of their root mean square, and how far states are from the path in
shares of its amplitude; speeds five times as far.
"""

HELD = 0.9


def torques_near(
    fuzzy: Any, path: Trajectory, amplitude: float, count: int, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Return noisy torques of the exact model, and the intervals, at states near a path."""
    wanted = path(rng.uniform(1.0, 9.0, count))
    near = NEAR * amplitude
    positions = wanted.positions + rng.normal(0.0, near, wanted.positions.shape)
    speeds = wanted.speeds + rng.normal(0.0, 5.0 * near, wanted.positions.shape)
    servo = wanted.accelerations + fuzzy.kv * (wanted.speeds - speeds)
    servo += fuzzy.kp * (wanted.positions - positions)
    torques = fuzzy.robot.inverse_dynamics(positions, speeds, servo)
    intervals = np.empty((*torques.shape, 2))
    for i, (a, v) in enumerate(zip(positions, speeds, strict=True)):
        fuzzy.torque(0.0, a, v, Motion(*(array[i] for array in wanted)))
        intervals[i] = fuzzy.torque_interval
    noise = NOISE * np.sqrt((torques**2).mean(axis=0))
    return torques + noise * rng.standard_normal(torques.shape), intervals


def row_of_intervals(
    name: str,
    controller: Callable[[int], Any],
    paths: tuple[Trajectory, Trajectory],
    amplitude: float,
) -> str:
    """Return a row of the table of torque intervals.

    A seed draws the rules, where they have noise, the states and the noise on torques. What the
    width is worth is the mean width of intervals that are stretched, over that of constant ones.
    """
    found: list[list[float]] = []
    for seed in range(SEEDS):
        try:
            found.append(one_seed_of_intervals(controller(seed), paths, amplitude, seed))
        except psp3.errors.InvalidValue:
            # Where M was not positive definite at too many states there is no width to stretch.
            continue
    if len(found) < SEEDS:
        name = f"{name} ({len(found)} of {SEEDS} seeds)"
    columns = np.array(found).T
    cells = [
        f"{100.0 * here:.1f} / {100.0 * there:.1f} % | {width:.3g}"
        for here, there, width in columns[:-1].mean(axis=1).reshape(-1, 3)
    ]
    ratio = statistics.ratio_of_means(columns[5], columns[8])
    cells.append(f"{ratio.value:.3f} ({ratio.low:.3f} to {ratio.high:.3f})")
    return f"| {name} | " + " | ".join([*cells, f"{columns[-1].mean():.2f}"]) + " |"


def one_seed_of_intervals(
    fuzzy: Any, paths: tuple[Trajectory, Trajectory], amplitude: float, seed: int
) -> list[float]:
    """Return shares held here and elsewhere with widths, as given and by scale; correlation."""
    rng = np.random.default_rng(seed)
    known, same, else_where = (
        torques_near(fuzzy, where, amplitude, count, rng)
        for where, count in ((paths[0], CALIBRATE), (paths[0], ASK), (paths[1], ASK))
    )
    one = []
    for torques, given in (same, else_where):
        one.append(float(((given[..., 0] <= torques) & (torques <= given[..., 1])).mean()))
    one.append(float(np.diff(same[1]).mean()))
    for scale in SCALES:
        intervals = ConformalIntervals(*known, HELD, scale)
        one += [float(intervals.holds(*asked).mean()) for asked in (same, else_where)]
        one.append(float(np.diff(intervals.around(same[1])).mean()))
    return [*one, correlation(*same)]


def correlation(torques: Array, intervals: Array) -> float:
    """Return how width and error go together: Spearman's coefficient, a mean over the joints."""
    off = np.abs(torques - intervals.mean(axis=-1))
    widths = np.diff(intervals)[..., 0]
    return float(np.mean([spearmanr(a, b).statistic for a, b in zip(widths.T, off.T, strict=True)]))


def rows_of_intervals() -> Iterator[str]:
    """Yield the rows of the table of torque intervals."""
    robot = psp3.load("psp3")
    helix, other = (
        psp3.trajectories.Helix(radius=radius, period=period, rise=rise, robot=robot)
        for radius, period, rise in ((0.020, 2.0, 0.010), (0.015, 1.5, 0.005))
    )
    for kind, variation in (("it2", 0.05), ("it2", 0.2), ("it2", 0.35), ("gt2", 0.2)):
        fuzzy = psp3.FuzzyComputedTorque(
            kind, robot, learner="average", mean_variation=variation
        ).fit(helix)
        name = f"psp3, {kind}, {variation:g}"
        yield row_of_intervals(name, lambda seed, same=fuzzy: same, (helix, other), 0.02)
    for kind in ("it2", "gt2"):
        case = with_learned_rules("psp3", helix, other, "average", kind)
        yield row_of_intervals(f"psp3, {kind}, 20 dB", case.with_servo, (helix, other), 0.02)
    for name, amplitude in AMPLITUDES.items():
        case = learned(name)
        smaller = psp3.trajectories.Sway(0.75 * amplitude, 1.5, case.robot)
        paths = case.path, smaller
        yield row_of_intervals(f"{name}, it2, 20 dB", case.with_servo, paths, amplitude)


CASES: dict[str, Callable[[], Case]] = {
    "psp3": learned_3psp,
    "five_bar_learned": lambda: learned("five_bar"),
    "five_bar": lambda: with_wrong_masses("five_bar", 0.1, 2e-5),
    "delta": lambda: with_wrong_masses("delta", 0.1, 2e-5),
    "delta_learned": lambda: learned("delta"),
    "gough_stewart_learned": lambda: learned("gough_stewart"),
    "gough_stewart_averages": lambda: learned("gough_stewart", "average"),
}

if __name__ == "__main__":
    for asked in sys.argv[1:] or [*CASES, "intervals"]:
        for row in rows_of_intervals() if asked == "intervals" else rows_of_tubes(CASES[asked]()):
            sys.stdout.write(f"{row}\n")
            sys.stdout.flush()
