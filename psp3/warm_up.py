"""Compile every kernel once, so that the first user of a fresh installation does not wait.

``psp3 warm-up`` runs it, and so does ``python -m psp3.warm_up``, which first removes code that was
compiled from older sources.
"""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

import numpy as np

import fuzzy2
import psp3
from fuzzy2.support.code_folder import forget_code

logger = logging.getLogger(__name__)


def warm_up() -> None:
    """Call every compiled function.

    With a writable cache directory, later processes load what this one compiled. Each step is
    logged before it is compiled.
    """
    from psp3.loading import load

    robot = load("psp3")
    logger.info("compiling the closed form of the 3-PSP")
    _warm_up_closed_form(robot)
    logger.info("compiling the core: answers, derivatives and plants of any robot")
    _warm_up_core(load("five_bar"))
    logger.info("compiling controllers and plants of the 3-PSP")
    _warm_up_control(robot)
    logger.info("compiling fuzzy systems")
    _warm_up_fuzzy_systems()


def _warm_up_control(robot: Any) -> None:
    """Compile the loops of the 3-PSP: controllers, drives, runs of a study, adaptation."""
    from psp3.control.classical import ComputedTorque
    from psp3.drives.drive import Drive
    from psp3.fuzzy_control.adaptive import AdaptiveFuzzyComputedTorque
    from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
    from psp3.simulation.constraint_dynamics import ConstraintDynamics
    from psp3.simulation.runge_kutta import RungeKutta
    from psp3.simulation.tracking import simulate
    from psp3.study.execution import execute
    from psp3.study.run import Run
    from psp3.trajectories.paths import Helix

    rest = np.zeros(3)
    simulate(robot, ComputedTorque(robot), Helix(robot=robot), 0.01)
    drive = Drive(coulomb_friction=1.0)
    for plant in (RungeKutta(robot, drive=drive), ConstraintDynamics(robot, drive=drive)):
        simulate(robot, ComputedTorque(robot), Helix(robot=robot), 0.01, plant=plant)
    # Learning a controller compiles its step, and a run the whole loop.
    execute(Run("it2", snr_db=20.0, duration=0.05))
    for name in ("ctc", "lqr", "adaptive-t1"):
        execute(Run(name, duration=0.05))
    controller = FuzzyComputedTorque("t1", robot).fit(Helix(robot=robot), 1.0)
    AdaptiveFuzzyComputedTorque(controller).torque(0.0, rest, rest, Helix(robot=robot)(0.0))


def _warm_up_closed_form(robot: Any) -> None:
    rest = np.zeros(3)
    robot.configuration(rest)
    robot.tip_jacobian(rest)
    robot.inverse_dynamics(rest, rest, rest)
    robot.forward_dynamics(rest, rest, rest)
    robot.kinetic_energy(rest, rest)
    # Enough rows for the kernels of many states.
    rows = np.zeros((8, 3))
    robot.equation_of_motion(rows, rows)
    robot.inverse_dynamics(rows, rows, rows)
    robot.forward_dynamics(rows, rows, rows)


def _warm_up_core(robot: Any) -> None:
    """Compile what every robot with loops uses: loading a robot compiles the core.

    This also compiles the derivatives, and the simulated plants with and without drives.
    """
    from psp3.control.classical import ComputedTorque
    from psp3.control.linear_quadratic_regulator import LinearQuadraticRegulator
    from psp3.drives.drive import Drive
    from psp3.loading import load
    from psp3.simulation.runge_kutta import RungeKutta
    from psp3.simulation.tracking import simulate
    from psp3.trajectories.paths import PointToPoint

    rest, goal = np.zeros(len(robot.actuated)), robot.reference + 0.01
    robot.inverse_dynamics_derivatives(robot.reference, rest, rest)
    way = PointToPoint(robot.reference, goal, 1.0, robot)
    for plant in (RungeKutta(robot), RungeKutta(robot, drive=Drive(coulomb_friction=0.01))):
        simulate(robot, ComputedTorque(robot), way, 0.01, plant=plant)
        # The loop above includes a compiled plant. A controller in Python calls the plant
        # separately.
        plant.start(robot.reference, rest)
        plant.advance(rest, 1e-3)
    _warm_up_learning(robot)
    # The same for a robot whose coordinates are not its motors.
    many = load("planar_4rrr")
    goal = many.reference + 0.01
    way = PointToPoint(many.reference, goal, 1.0, many)
    weights = np.eye(2 * many.commanded), np.eye(many.commanded)
    for controller in (ComputedTorque(many), LinearQuadraticRegulator(many, *weights)):
        simulate(many, controller, way, 0.01)


def _warm_up_learning(robot: Any) -> None:
    """Compile learned controllers of any robot: their steps and loops, and C as M's derivative."""
    from psp3.control.default_gains import default_gains
    from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
    from psp3.fuzzy_control.records import record
    from psp3.simulation.tracking import simulate
    from psp3.trajectories.sway import Sway

    gains, sway = default_gains(robot, "ctc"), Sway(robot=robot)
    recorded = record(robot, sway, sway.period, **gains)
    controller = FuzzyComputedTorque("t1", robot, rules=4, coriolis="mass", **gains)
    simulate(robot, controller.learn(recorded, 100), sway, 0.01)
    # Estimates call a part of the compiled step from Python.
    controller.estimate(robot.reference, np.zeros(len(robot.actuated)))


def _warm_up_fuzzy_systems() -> None:
    from fuzzy2 import (
        AdaptiveConsequents,
        Gaussian,
        GaussianType2Set,
        GeneralType2System,
        IntervalType2System,
        Linear,
        centroid,
        fine_tune,
        generalized_centroid,
    )

    terms, rules, consequents = [[Gaussian(0.0, 1.0)]], [[0]], [[1.0]]
    system = IntervalType2System(terms, rules, consequents)
    general = GeneralType2System(
        [[GaussianType2Set(Gaussian(0.0, 1.0), 0.01)]], rules, consequents, reduction="gaussian"
    )
    for one in (system, general, GeneralType2System(terms, rules, consequents)):
        for x in (np.zeros(1), np.zeros((2, 1))):
            one(x)
            one.type_reduced(x)
            one.firing(x)
    adaptive = AdaptiveConsequents(system)
    adaptive.update(np.zeros(1), np.ones(1))
    adaptive(np.zeros(1))
    fine_tune(system, [[0.0], [1.0]], [0.0, 1.0], np.random.default_rng(0), most_epochs=1)
    generalized_centroid([1.0], [[0.5, 1.0]])
    centroid(np.array([0.0, 1.0]), np.array([0.2, 0.5]), np.array([0.5, 1.0]))
    united = IntervalType2System(
        terms, rules, [[Gaussian(0.0, 1.0)]], type_reduction="centroid", output_ranges=[(-3.0, 3.0)]
    )
    united(np.zeros(1))
    IntervalType2System(terms, rules, Linear([[[0.0, 1.0]]]))(np.zeros(1))


if __name__ == "__main__":
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    # Code of older sources is never used (fuzzy2/support/code_files.py), but would stay on the
    # disk.
    forget_code(*(Path(next(iter(package.__path__))) for package in (psp3, fuzzy2)))
    warm_up()
