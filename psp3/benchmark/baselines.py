"""The entries that come with the package.

All have the same servo. Computed torque has the gains of the task. PD has these gains times the
mass matrix of the reference pose. The weights of the regulator are chosen for the same stiffness
and, if possible, the same damping. The board says what each entry knows about the robot.

Only the fuzzy entries are given the signal-to-noise ratio, which sets the footprint of uncertainty
of type-2 (:func:`fuzzy2.mean_variation_from_snr`), as in the thesis.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from fuzzy2.learning.anfis import ANFIS
from fuzzy2.learning.partition import KINDS
from psp3.benchmark import regressors
from psp3.benchmark.entries import MODEL, SAMPLES, Course, Entry, of_regressor
from psp3.benchmark.readings import NONE, READINGS
from psp3.benchmark.regressors import Standardized
from psp3.control.classical import ComputedTorque, GravityCompensatedPD
from psp3.control.controller import Controller
from psp3.control.linear_quadratic_regulator import LinearQuadraticRegulator
from psp3.fuzzy_control.adaptive import AdaptiveFuzzyComputedTorque
from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
from psp3.fuzzy_control.records import NOISE_OF_THE_STUDY
from psp3.fuzzy_control.rule_bases import LEARNERS

REFERENCE = "ctc"
"""Name of exact computed torque, the reference for efforts; it is on every board."""

CLUSTERS = 8
"""Number of rules of ANFIS, one for each cluster of the samples."""

EPOCHS = 20
"""Greatest number of epochs of ANFIS."""


def _computed_torque(course: Course) -> Controller:
    task = course.task
    return ComputedTorque(task.robot, task.kp, task.kv)


def _pd_with_gravity(course: Course) -> Controller:
    task = course.task
    mass = task.robot.mass_matrix(task.robot.reference)
    return GravityCompensatedPD(task.robot, task.kp * mass, task.kv * mass)


def _regulator(course: Course) -> Controller:
    r"""Return the regulator that weighs accelerations against positions and speeds.

    With :math:`R = M^{-2}` and :math:`Q` of :math:`k_p^2` and :math:`k_v^2 - 2 k_p` a unit mass
    would get the gains :math:`k_p` and :math:`k_v`. A regulator's damping ratio is at least
    :math:`1 / \sqrt 2`, its value without weight on speeds, so servos with less damping get this
    one.
    """
    task: Any = course.task
    inverse = np.linalg.inv(task.robot.mass_matrix(task.robot.reference))
    of_speeds = max(task.kv**2 - 2.0 * task.kp, 0.0)
    weights = np.repeat([task.kp**2, of_speeds], task.joints)
    R = inverse.T @ inverse
    return LinearQuadraticRegulator(task.robot, np.diag(weights), 0.5 * (R + R.T), course.period)


def _fuzzy(kind: str, learner: str, course: Course) -> FuzzyComputedTorque:
    """Return the fuzzy controller; it draws the same noise on the same samples as a lesson."""
    task, noise = course.task, None
    if course.reading != NONE:
        noise = READINGS[course.reading].noise
    controller = FuzzyComputedTorque(
        kind,
        task.robot,
        kp=task.kp,
        kv=task.kv,
        learner=learner,
        snr_db=np.inf if noise is None else course.snr_db,
    )
    rng = np.random.default_rng(course.noise)
    return controller.learn(
        task.recorded, len(course.lesson.inputs), rng, noise or NOISE_OF_THE_STUDY
    )


def _adaptive(course: Course) -> Controller:
    return AdaptiveFuzzyComputedTorque(_fuzzy("it2", "average", course))


def _anfis(rng: np.random.Generator) -> Standardized:
    return Standardized(ANFIS(CLUSTERS, partition="clusters", most_epochs=EPOCHS, rng=rng))


def _of_made(make: Any, name: str, course: Course) -> Controller:
    return of_regressor(make(course.rng), course, name)


def _regressing(name: str, make: Any, draws: bool) -> Entry:
    return Entry(name, SAMPLES, partial(_of_made, make, name), draws)


BASELINES: dict[str, Entry] = {
    entry.name: entry
    for entry in (
        Entry(REFERENCE, MODEL, _computed_torque),
        Entry("pd-gravity", MODEL, _pd_with_gravity),
        Entry("lqr", MODEL, _regulator),
        *(
            Entry(f"{kind}-{learner}", SAMPLES, partial(_fuzzy, kind, learner))
            for kind in KINDS
            for learner in LEARNERS
        ),
        _regressing("anfis", _anfis, True),
        Entry("adaptive", SAMPLES, _adaptive),
        _regressing("gaussian-process", regressors.gaussian_process, False),
        _regressing("neural-network", regressors.neural_network, True),
        _regressing("ridge", regressors.ridge, False),
    )
}
"""Entries that come with the package, by name."""

NEED_SCIKIT_LEARN = ("gaussian-process", "neural-network", "ridge")
"""Entries that need scikit-learn."""
