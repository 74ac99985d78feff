"""Entries that come with the package: each runs, and each is what its name says."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fuzzy2 import WangMendel
from psp3 import ComputedTorque, FuzzyComputedTorque
from psp3.benchmark.baselines import BASELINES, NEED_SCIKIT_LEARN, REFERENCE
from psp3.benchmark.entries import Course
from psp3.benchmark.readings import READINGS, lesson
from psp3.benchmark.tasks import ROBOTS, SAMPLES, task
from psp3.benchmark.trial import NOISE, Trial, execute

PERIOD = 0.004


def course(name: str, reading: str = "outputs", snr_db: float = 20.0, seed: int = 0) -> Course:
    of_robot, noise = task(name), (seed, NOISE)
    taught = lesson(of_robot, reading, snr_db, np.random.default_rng(noise), SAMPLES)
    return Course(of_robot, taught, reading, snr_db, noise, np.random.default_rng(seed), PERIOD)


@pytest.mark.slow
@pytest.mark.parametrize("name", BASELINES)
def test_every_entry_does_a_trial_of_the_3_psp_without_losing_it(name: str) -> None:
    """Half a second is too short to be lost without noise, whatever was learned."""
    outcome = execute(Trial("psp3", duration=0.5), BASELINES[name])
    assert outcome["error"] is None
    assert not any(run["diverged"] for run in outcome["runs"].values())


@pytest.mark.parametrize("name", ROBOTS)
def test_the_adaptive_entry_takes_part_on_every_robot(name: str) -> None:
    """It goes on learning there: a second call answers the same state otherwise."""
    given = course(name)
    controller, rest = BASELINES["adaptive"].make(given), given.task.robot.reference
    still = np.zeros(given.task.joints)
    wanted = given.task.paths["trained"](0.0)._replace(positions=rest + 0.01)
    forces = [controller.torque(t, rest, still, wanted) for t in (0.0, PERIOD, 30.0 * PERIOD)]
    assert np.isfinite(forces).all()
    assert not np.array_equal(forces[0], forces[2])


def test_the_reference_is_exact_and_the_rest_of_the_names_stand() -> None:
    assert isinstance(BASELINES[REFERENCE].make(course("delta")), ComputedTorque)
    assert set(NEED_SCIKIT_LEARN) < set(BASELINES)
    assert {f"{kind}-average" for kind in ("t1", "it2", "gt2")} < set(BASELINES)


@pytest.mark.parametrize("name", ROBOTS)
def test_pd_has_the_stiffness_of_computed_torque_at_the_reference(name: str) -> None:
    """A small error there makes the same force, at rest and with no wish to accelerate."""
    given = course(name)
    of_robot = given.task
    rest = of_robot.robot.reference
    still, error = np.zeros(of_robot.joints), 1e-5 * np.arange(1, of_robot.joints + 1)
    wanted = of_robot.paths["trained"](0.0)._replace(
        positions=rest + error, speeds=still, accelerations=still
    )
    forces = [
        BASELINES[entry].make(given).torque(0.0, rest, still, wanted)
        for entry in (REFERENCE, "pd-gravity")
    ]
    np.testing.assert_allclose(*forces, rtol=1e-8)


@pytest.mark.parametrize(
    ("name", "of_gravity"), [("psp3", 0.05), ("delta", 0.16), ("gough_stewart", 0.13)]
)
def test_regulator_has_about_the_servo_of_computed_torque(name: str, of_gravity: float) -> None:
    """A unit mass would get kp and kv, but no damping ratio below 0.7.

    A period of 4 ms takes some percent of them. Gravity is a spring of its own, of up to 15 % of kp
    where it changes with the pose, and the regulator knows it.
    """
    given = course(name)
    n, kp, kv = given.task.joints, given.task.kp, given.task.kv
    controller: object = BASELINES["lqr"].make(given)
    K = controller.regulator.K  # type: ignore[attr-defined]
    mass = given.task.robot.mass_matrix(given.task.robot.reference)
    stiffness, damping = np.hsplit(np.linalg.solve(mass, K), 2)
    np.testing.assert_allclose(stiffness, kp * np.eye(n), atol=of_gravity * kp)
    expected = max(kv, np.sqrt(2.0 * kp))
    np.testing.assert_allclose(damping, expected * np.eye(n), atol=0.05 * expected)


@pytest.mark.parametrize("reading", [name for name in READINGS if name != "measurement"])
def test_fuzzy_entries_learn_from_the_very_samples_of_the_lesson(reading: str) -> None:
    """Rules learned from the lesson by hand are the same, number by number."""
    given = course("psp3", reading)
    entry = BASELINES["t1-average"].make(given)
    assert isinstance(entry, FuzzyComputedTorque)
    by_hand = WangMendel(2, "t1", 0.0, "average", "refuse").fit(*given.lesson).system_
    a, v = given.task.recorded.positions[::500], given.task.recorded.speeds[::500]
    inputs = np.clip(given.task.inputs_of(a, v), *entry.ranges_)
    expected = np.asarray(by_hand(inputs))
    np.testing.assert_array_equal(np.asarray(entry.system_(inputs)), expected)


def test_noise_at_run_time_teaches_nobody_wrong() -> None:
    entry = BASELINES["t1-average"].make(course("psp3", "measurement"))
    assert entry.snr_db == math.inf  # type: ignore[attr-defined]
