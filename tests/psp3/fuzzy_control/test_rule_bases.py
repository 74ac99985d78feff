"""Rule bases of any robot: learned, in the loop, from forces, and in files."""

from __future__ import annotations

import math
import warnings
from typing import Any

import numpy as np
import pytest

import fuzzy2
import psp3
from psp3.control.classical import critically_damped_gains
from psp3.errors import InvalidValue
from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
from psp3.fuzzy_control.numbers import pack, unpack
from psp3.fuzzy_control.records import Record, record
from psp3.fuzzy_control.rule_bases import RuleOptions, learned_system, partition_by_clusters
from psp3.simulation.runge_kutta import RungeKutta
from psp3.trajectories.fourier_series import FourierSeries
from psp3.trajectories.motion import Motion
from psp3.trajectories.sway import Sway

KP, KV = critically_damped_gains(20.0)
ROBOTS = {name: psp3.load(name) for name in ("five_bar", "delta", "gough_stewart")}


class InPython(RungeKutta):
    """The same plant, which the compiled loop does not know."""


def exciting(name: str) -> FourierSeries:
    """Return a motion of five harmonics about the reference."""
    robot, rng = ROBOTS[name], np.random.default_rng(1)
    sway = Sway(robot=robot)
    shares = 0.35 * sway.amplitudes / np.arange(1, 6)[:, np.newaxis]
    sines, cosines = (rng.normal(size=shares.shape) * shares for _ in range(2))
    return FourierSeries(sway.center, sines, cosines, 3.0, robot)


@pytest.fixture(scope="module")
def records() -> dict[str, Record]:
    return {
        name: record(robot, Sway(robot=robot), 2.0, kp=KP, kv=KV) for name, robot in ROBOTS.items()
    }


def learned(name: str, recorded: Record, kind: str = "it2", **options: Any) -> FuzzyComputedTorque:
    variation = 0.0 if kind == "t1" else 0.02
    controller = FuzzyComputedTorque(
        kind, ROBOTS[name], **{"kp": KP, "kv": KV, "mean_variation": variation} | options
    )
    with warnings.catch_warnings():
        # That the Gaussian corollary is an approximation is not what is tested.
        warnings.simplefilter("ignore", fuzzy2.ApproximationWarning)
        return controller.learn(recorded)


def rms_error(result: psp3.Result) -> float:
    return float(np.sqrt(((result.positions - result.desired.positions) ** 2).mean()))


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize(
    ("kind", "options"),
    [
        ("t1", {}),
        ("it2", {}),
        ("it2", {"coriolis": "mass"}),
        ("gt2", {"levels": 2}),
        ("gt2", {"reduction": "gaussian"}),
    ],
)
def test_the_compiled_loop_does_what_the_python_loop_does(
    records: dict[str, Record], name: str, kind: str, options: dict[str, Any]
) -> None:
    """To the last bit: it is the same step."""
    controller, robot = learned(name, records[name], kind, **options), ROBOTS[name]
    path = Sway(robot=robot)
    compiled = psp3.simulate(robot, controller, path, 0.1)
    python = psp3.simulate(robot, controller, path, 0.1, plant=InPython(robot))
    for what in ("positions", "torque", "torque_interval", "covered", "fell_back"):
        np.testing.assert_array_equal(getattr(compiled, what), getattr(python, what))


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("coriolis", ["rules", "mass"])
@pytest.mark.parametrize("kind", ["t1", "it2", "gt2"])
def test_the_torque_is_that_of_the_estimates(
    records: dict[str, Record], name: str, coriolis: str, kind: str
) -> None:
    """Kernel against fuzzy systems called by themselves, in NumPy; 1e-9 is rounding."""
    controller = learned(name, records[name], kind, coriolis=coriolis)
    desired = Motion(*(array[700] for array in Sway(robot=ROBOTS[name])(records[name].t)))
    a, v = records[name].positions[500], records[name].speeds[500]
    torque = controller.torque(0.0, a, v, desired)
    assert not controller.fell_back
    servo = desired.accelerations + KV * (desired.speeds - v) + KP * (desired.positions - a)
    M, C, G = controller.estimate(a, v)
    np.testing.assert_allclose(torque, M @ servo + C @ v + G, rtol=1e-9, atol=1e-9)
    number = controller.torque_number(a, v, desired)
    np.testing.assert_allclose(controller.defuzzify(number), torque, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("name", ROBOTS)
def test_without_noise_the_trained_path_is_tracked_within_thrice_the_exact_error(
    records: dict[str, Record], name: str
) -> None:
    robot = ROBOTS[name]
    path = Sway(robot=robot)
    exact = rms_error(psp3.simulate(robot, psp3.ComputedTorque(robot, KP, KV), path, 2.0))
    for kind in ("t1", "it2", "gt2"):
        # Without noise the mean variation is 0, and all types say the same.
        controller = FuzzyComputedTorque(kind, robot, kp=KP, kv=KV).learn(records[name])
        assert rms_error(psp3.simulate(robot, controller, path, 2.0)) <= 3.0 * exact


@pytest.mark.parametrize("coriolis", ["rules", "mass"])
@pytest.mark.parametrize("name", ["five_bar", "delta"])
def test_from_forces_alone_the_robot_is_tracked_nearly_as_with_its_own_dynamics(
    name: str, coriolis: str
) -> None:
    robot, path = ROBOTS[name], exciting(name)
    t = np.arange(0.0, 3.0, 0.004)
    motion = path.joints(t)
    forces = robot.inverse_dynamics(*motion)
    controller = FuzzyComputedTorque("t1", robot, kp=KP, kv=KV, coriolis=coriolis)
    controller.learn_from_motion(*motion, forces)
    M, C, G = controller.estimate(motion[0], motion[1])
    assert (np.linalg.eigvalsh(M) > 0.0).all()
    found = np.einsum("sij,sj->si", M, motion[2]) + np.einsum("sij,sj->si", C, motion[1]) + G
    # What 32 rules leave of the forces.
    assert np.sqrt(((found - forces) ** 2).mean() / (forces**2).mean()) < 2e-3
    exact = rms_error(psp3.simulate(robot, psp3.ComputedTorque(robot, KP, KV), path, 3.0))
    assert rms_error(psp3.simulate(robot, controller, path, 3.0)) <= 3.0 * exact


def test_a_derived_c_makes_m_dot_less_twice_c_skew(records: dict[str, Record]) -> None:
    """Of what the controller estimates, M-dot by central differences: 1e-7 of C's 1e-2."""
    controller = learned("delta", records["delta"], "t1", coriolis="mass")
    a, v, h = records["delta"].positions[300], records["delta"].speeds[300], 1e-5
    ends = [controller.estimate(a + s * h * v, v)[0] for s in (1.0, -1.0)]
    twice = (ends[0] - ends[1]) / (2.0 * h) - 2.0 * controller.estimate(a, v)[1]
    np.testing.assert_allclose(twice, -twice.T, atol=1e-7)


def test_a_grid_of_up_to_256_rules_and_clusters_beyond(records: dict[str, Record]) -> None:
    recorded = records["five_bar"]
    grid = learned("five_bar", recorded, "t1", n_terms=2)
    assert [len(system.rules) for system in grid.systems_] == [4, 16]
    # A sway passes by the corners of a finer grid, of which samples everywhere say something.
    with pytest.raises(fuzzy2.errors.UnsupportedRule):
        learned("five_bar", recorded, "t1", n_terms=5)
    robot, rng = ROBOTS["five_bar"], np.random.default_rng(4)
    a, v = robot.reference + rng.uniform(-0.3, 0.3, (600, 2)), rng.uniform(-1.0, 1.0, (600, 2))
    everywhere = Record(
        *(np.arange(600.0), a, v, np.hstack([a, v]), pack(*robot.equation_of_motion(a, v))),
        *(recorded.input_names, recorded.output_names),
    )
    mixed = learned("five_bar", everywhere, "t1", n_terms=5)
    assert [len(system.rules) for system in mixed.systems_] == [25, 32]
    assert [len(s.rules) for s in learned("five_bar", recorded, rules=9).systems_] == [9, 9]


def test_where_the_exact_model_takes_over_it_does(records: dict[str, Record]) -> None:
    """Outside of the trained range; the forces are those of computed torque, to rounding."""
    robot, recorded = ROBOTS["five_bar"], records["five_bar"]
    controller = learned("five_bar", recorded, outside="crisp")
    desired = Motion(*(array[0] for array in Sway(robot=robot)(recorded.t[:1])))
    a, v = robot.reference + np.array([0.3, -0.3]), np.array([5.0, 5.0])
    torque = controller.torque(0.0, a, v, desired)
    assert not controller.covered
    exact = psp3.ComputedTorque(robot, KP, KV).torque(0.0, a, v, desired)
    np.testing.assert_allclose(torque, exact, rtol=1e-9)


def test_what_cannot_be_learned_is_refused_by_name(records: dict[str, Record]) -> None:
    with pytest.raises(InvalidValue, match="whose coordinates are its motors"):
        FuzzyComputedTorque("t1", psp3.load("biped"))
    with pytest.raises(InvalidValue, match="recorded"):
        FuzzyComputedTorque("t1", ROBOTS["delta"]).learn(records["five_bar"])
    with pytest.raises(InvalidValue, match="coriolis"):
        FuzzyComputedTorque("t1", psp3.load("psp3"), coriolis="mass")
    still = np.zeros((50, 2))
    with pytest.raises(InvalidValue, match="every joint moves"):
        FuzzyComputedTorque("t1", ROBOTS["five_bar"]).learn_from_motion(still, still, still, still)
    several = learned("five_bar", records["five_bar"])
    with pytest.raises(InvalidValue, match="systems_"):
        several.system_  # noqa: B018


def test_records_of_any_robot_hold_its_m_c_and_g(records: dict[str, Record]) -> None:
    """Of some rows to rounding: the loops are closed from other rows than in the whole record."""
    recorded, robot = records["delta"], ROBOTS["delta"]
    for found, expected in zip(
        unpack(recorded.outputs[::200]),
        robot.equation_of_motion(recorded.positions[::200], recorded.speeds[::200]),
        strict=True,
    ):
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("number", [4, 10**6])
def test_no_more_rules_than_different_samples_and_no_memory_for_them(number: int) -> None:
    """A million clusters would have distances of terabytes."""
    samples = np.array([[0.0, 1.0], [1.0, 0.0], [0.5, 0.5], [0.5, 0.5]])
    options = RuleOptions("t1", None, number, 0.0, "average", "karnik_mendel", 5, 1.0, 256)
    with pytest.raises(InvalidValue, match="at most 3, the number of different samples"):
        partition_by_clusters(options, samples, number)
    # Who gave no number of rules is told of what was given.
    with pytest.raises(InvalidValue, match=f"samples must be at least {number} that differ"):
        partition_by_clusters(options._replace(rules=None), samples, number)
    with pytest.raises(InvalidValue, match="needs a grid: give n_terms"):
        partition_by_clusters(options._replace(learner="strict"), samples, 2)


@pytest.mark.parametrize(
    ("learner", "most"), [("strongest", 32), ("least-squares", 9), ("ridge", 9), ("strict", 32)]
)
def test_a_grid_that_is_too_large_is_refused_with_the_largest(learner: str, most: int) -> None:
    """Of four inputs: 2^20 rules are 32 terms, and 2^13 rules some nine."""
    options = RuleOptions(*("t1", most + 1, None, 0.0, learner, "alpha_planes", 5, 1.0, math.inf))
    samples = np.random.default_rng(0).uniform(size=(20, 4))
    with pytest.raises(InvalidValue, match=f"n_terms must be at most {most}: .*, got {most + 1}"):
        learned_system(options, samples, ("a", "b", "c", "d"), samples)
