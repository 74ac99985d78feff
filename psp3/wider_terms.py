"""Whether what type-2 gains is averaging over rules: type-1 controllers with wider terms, on the same rules.

The footprints of type-2 terms reach over more of each input's range than type-1 terms do, so more rules fire, and the noise in their
consequents averages out. Type-1 terms with a greater standard deviation do the same without any type-2 logic. If that gains as much,
averaging is what gains.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from fuzzy2.systems import Type1System
from fuzzy2.type1 import Gaussian
from psp3 import control_kernels as kernels
from psp3.arrays import Array
from psp3.errors import InvalidValue
from psp3.fuzzy_computed_torque import FuzzyComputedTorque
from psp3.robot import PSP3
from psp3.runs import TRAJECTORIES, Run, Samples, measure, trained
from psp3.simulation import Result
from psp3.trajectories import Motion


def widened(controller: FuzzyComputedTorque, width: float) -> FuzzyComputedTorque:
    """Give the Gaussian terms of a trained type-1 controller another standard deviation, and leave its rules as they are.

    Parameters
    ----------
    controller : FuzzyComputedTorque
        Trained controller of kind ``"t1"``; it is changed.
    width : float
        What the standard deviations are multiplied with.

    Returns
    -------
    FuzzyComputedTorque
        The controller itself.

    Raises
    ------
    InvalidValue
        If the width is not positive, or the controller is of another kind.
    """
    if not (np.isfinite(width) and width > 0.0):
        raise InvalidValue("width", width, "finite and positive")
    system = controller.system_
    if not isinstance(system, Type1System):
        raise InvalidValue("controller", controller.kind, "of kind 't1'")
    terms = [[Gaussian(term.mean, width * term.sigma) for term in terms if isinstance(term, Gaussian)] for terms in system.inputs]
    wider = Type1System(terms, system.rules, system.consequents)
    wider.output_names = system.output_names
    controller._take(wider, controller.ranges_)
    return controller


def errors_by_seed(robot: PSP3, run: Run, width: float, seeds: int, workers: int | None = None) -> Array:
    """Return the sum of squared errors of a type-1 run with wider terms, for each seed.

    Parameters
    ----------
    robot : PSP3
        The robot of the run.
    run : Run
        A run of ``"t1"`` under the reading ``"parameters"``.
    width : float
        See :func:`widened`.
    seeds : int
        Number of seeds, from 0 on.
    workers : int, optional
        Number of threads; all cores of this process unless given.

    Returns
    -------
    (seeds,) ndarray
        Sums of squared errors [m²]; NaN where the run diverged. At width 1 they are those of :func:`psp3.runs.execute`.
    """
    t: Array = run.period * np.arange(round(run.duration / run.period) + 1, dtype=np.float64)
    desired = TRAJECTORIES[run.trajectory](robot)(t)
    wanted = np.concatenate([desired.heights, desired.speeds, desired.accelerations], axis=1)

    def one(seed: int) -> float:
        seeded = replace(run, seed=seed)
        controller = widened(trained(seeded, robot, np.random.default_rng([seed, 0])), width)
        return measure(_simulate(controller, robot, t, desired, wanted, run.period), seeded)["sum_of_squared_errors"]

    with ThreadPoolExecutor(workers or len(os.sched_getaffinity(0))) as executor:
        return np.array(list(executor.map(one, range(seeds))))


def _simulate(controller: FuzzyComputedTorque, robot: PSP3, t: Array, desired: Motion, wanted: Array, period: float) -> Samples:
    parameters, none = robot.parameters.as_array(), (np.empty((0, 6)), np.empty((0, 18)))
    samples = np.empty((len(t), 11))
    state = np.concatenate([desired.heights[0], np.zeros(3)])
    done = kernels.run(controller.controller, parameters, parameters, wanted, state, period, *none, samples)
    heights, speeds, torque = (samples[:done, i : i + 3].copy() for i in (0, 3, 6))
    result = Result(
        t[:done], heights, speeds, Motion(*(array[:done] for array in desired)), torque, robot.forward_kinematics(heights).tip,
        covered=samples[:done, 9] > 0.0, fell_back=samples[:done, 10] > 0.0,
    )  # fmt: skip
    return Samples(result, len(t))
