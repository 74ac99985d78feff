"""Print the tables of ``docs/how_to/learn_any_robot.md``: learned computed torque of three robots.

Run by ``python docs/make_learning.py``, which takes some minutes.
"""

from __future__ import annotations

import logging
import sys
from collections.abc import Callable

import numpy as np

import psp3
from psp3.checks import Array
from psp3.control.classical import critically_damped_gains
from psp3.control.controller import Controller
from psp3.errors import SimulationStopped, UnusableEstimate
from psp3.fuzzy_control.numbers import output_names, pack
from psp3.fuzzy_control.records import Record
from psp3.identification.base_parameters import base_parameters
from psp3.identification.unknowns import all_parameters
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from psp3.study.statistics import ratio_of_geometric_means
from psp3.trajectories.fourier_series import FourierSeries
from psp3.trajectories.sway import Sway
from psp3.trajectories.trajectory import Trajectory

ROBOTS = ("five_bar", "delta", "gough_stewart")
SEEDS = 10
SNR = 20.0
DURATION = 3.0
SAMPLES = 600
RULES = 16
MOTIONS = ((1,), (1, 11, 12, 13))
"""Seeds of the motions that forces are measured on: one of 3 s, and four."""

KP, KV = critically_damped_gains(20.0)


def exciting(robot: ClosedLoopRobot, seed: int = 1) -> FourierSeries:
    """Return a motion of five harmonics about the reference, which repeats after 3 s."""
    rng, sway = np.random.default_rng(seed), Sway(robot=robot)
    shares = 0.35 * sway.amplitudes / np.arange(1, 6)[:, np.newaxis]
    sines, cosines = (rng.normal(size=shares.shape) * shares for _ in range(2))
    return FourierSeries(sway.center, sines, cosines, DURATION, robot)


def error_on(robot: ClosedLoopRobot, controller: Controller, path: Trajectory) -> float:
    """Return the root mean square of the error of a run that starts on the path with its speed."""
    speeds = path(0.0).speeds
    try:
        result = psp3.simulate(robot, controller, path, DURATION, initial_speeds=speeds)
    except SimulationStopped:
        return float("nan")
    return float(np.sqrt(((result.positions - result.desired.positions) ** 2).mean()))


def motion_record(robot: ClosedLoopRobot, motion: tuple[Array, Array, Array]) -> Record:
    """Return exact M, C and G on a motion."""
    inputs, (a, v, _) = robot.learning_inputs, motion
    numbers = pack(*robot.equation_of_motion(a, v))
    t = np.asarray(0.002 * np.arange(len(a)), dtype=np.float64)
    return Record(t, a, v, inputs.of(a, v), numbers, inputs.names, output_names(a.shape[1]))


def rows_of(name: str, say: Callable[[str], None]) -> None:
    """Say the rows of one robot."""
    robot = psp3.load(name)
    paths: dict[str, Trajectory] = {"trained": exciting(robot), "untrained": Sway(robot=robot)}
    motion = exciting(robot).joints(np.arange(0.0, DURATION, 0.002))
    recorded = motion_record(robot, motion)
    exact = {w: error_on(robot, psp3.ComputedTorque(robot, KP, KV), p) for w, p in paths.items()}
    noisy: dict[tuple[str, str], list[float]] = {}
    for where, path in paths.items():
        cells = [f"{1e6 * exact[where]:.3g}"]
        for kind in ("t1", "it2", "gt2"):
            clean = psp3.FuzzyComputedTorque(kind, robot, kp=KP, kv=KV)
            cells.append(f"{1e6 * error_on(robot, clean.learn(recorded), path):.3g}")
        for kind in ("t1", "it2", "gt2"):
            errors = noisy.setdefault((where, kind), [])
            for seed in range(SEEDS):
                one = psp3.FuzzyComputedTorque(kind, robot, kp=KP, kv=KV, snr_db=SNR)
                one.learn(recorded, SAMPLES, np.random.default_rng(seed))
                errors.append(error_on(robot, one, path))
            cells.append(f"{1e6 * np.median(errors):.3g}")
        say(f"| {name} | {where} | {' | '.join(cells)} |")
    for seeds in MOTIONS:
        rows_of_forces(name, robot, paths, seeds, say)


def rows_of_forces(
    name: str,
    robot: ClosedLoopRobot,
    paths: dict[str, Trajectory],
    seeds: tuple[int, ...],
    say: Callable[[str], None],
) -> None:
    """Say the rows of learning from forces on motions: all with noise of the same ratio."""
    t = np.arange(0.0, DURATION, 0.002 if len(seeds) == 1 else 0.004)
    several = zip(*(exciting(robot, seed).joints(t) for seed in seeds), strict=True)
    a, v, w = (np.concatenate(parts) for parts in several)
    motion = a, v, w
    recorded, forces = motion_record(robot, motion), robot.inverse_dynamics(*motion)
    size = 10.0 ** (-SNR / 20.0) * np.sqrt((forces**2).mean(axis=0))
    for coriolis in ("rules", "mass"):
        options = {"kp": KP, "kv": KV, "coriolis": coriolis, "rules": RULES}
        try:
            psp3.FuzzyComputedTorque("t1", robot, **options).learn_from_motion(*motion, forces)
        except UnusableEstimate:
            say(f"| {name} | {len(seeds)} | {coriolis} | refused |")
            continue
        exact = psp3.FuzzyComputedTorque("t1", robot, **options).learn(recorded, len(forces))
        errors: dict[tuple[str, str], list[float]] = {}
        missed = []
        for seed in range(SEEDS):
            measured = forces + size * np.random.default_rng(seed).normal(size=forces.shape)
            learned = {
                "forces": psp3.FuzzyComputedTorque("t1", robot, **options).learn_from_motion(
                    *motion, measured
                ),
                "M, C and G": psp3.FuzzyComputedTorque("t1", robot, snr_db=SNR, **options).learn(
                    recorded, len(forces), np.random.default_rng(seed)
                ),
            }
            for source, controller in learned.items():
                for where, path in paths.items():
                    found = errors.setdefault((source, where), [])
                    found.append(error_on(robot, controller, path))
            M, C, G = learned["forces"].estimate(a, v)
            said = np.einsum("sij,sj->si", M, w) + np.einsum("sij,sj->si", C, v) + G
            missed.append(np.sqrt((((said - forces) / size) ** 2).mean()))
        for where, path in paths.items():
            reference = error_on(robot, exact, path)
            of_forces, of_numbers = (errors[s, where] for s in ("forces", "M, C and G"))
            ratios = [
                ratio_of_geometric_means(of_forces, other)
                for other in ([reference] * SEEDS, of_numbers)
            ]
            means = [1e6 * np.exp(np.mean(np.log(e))) for e in (of_numbers, of_forces)]
            cells = [f"{1e6 * reference:.3g}", *(f"{mean:.3g}" for mean in means)]
            cells += map(str, ratios)
            say(f"| {name} | {len(seeds)} | {where} | {coriolis} | {' | '.join(cells)} |")
        share = 10.0 ** (-SNR / 20.0) * np.sqrt(np.mean(np.square(missed)))
        known = len(base_parameters(all_parameters(robot)).columns)
        least = 10.0 ** (-SNR / 20.0) * np.sqrt(known / forces.size)
        say(
            f"{name}, {len(seeds)}, C from {coriolis}: misses {share:.2%} of the forces, "
            f"{known} base parameters {least:.2%}"
        )


if __name__ == "__main__":
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    for robot_name in sys.argv[1:] or ROBOTS:
        rows_of(robot_name, logging.getLogger(__name__).info)
