"""How runs are done: that their fields decide them, and their metrics against definitions."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
import warnings
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fuzzy2
import psp3
from fuzzy2.errors import Fuzzy2Error, UnsupportedRule
from fuzzy2.learning.partition import KINDS
from psp3.control.classical import GravityCompensatedPD
from psp3.control.default_gains import default_gains
from psp3.drives import Drive
from psp3.errors import InvalidValue, StrokeExceeded, UnknownName, UnusableEstimate
from psp3.fuzzy_control.computed_torque import ORDERS, OUTSIDE, REDUCTIONS
from psp3.fuzzy_control.records import ENTRIES, REFERENCES, record
from psp3.simulation import metrics
from psp3.simulation.runge_kutta import RungeKutta
from psp3.study import execution
from psp3.study.controllers import controller_of, robot_named, trained
from psp3.study.execution import execute, mismatched, mismatched_robot, simulate_run
from psp3.study.paths import TRAJECTORIES
from psp3.study.run import CLASSICAL, METRICS, READINGS, Run
from psp3.three_psp.parameters import PARAMETER_SETS
from psp3.trajectories import Helix, Sway

ROBOT = psp3.load("psp3")
HELIX = Helix(robot=ROBOT)
pytestmark = pytest.mark.filterwarnings("ignore:the Gaussian corollary:fuzzy2.ApproximationWarning")


def same(one: dict[str, float], other: dict[str, float]) -> bool:
    """Tell whether metrics are the same, bit for bit, NaN being equal to NaN."""
    return list(one) == list(other) and np.array_equal(
        list(one.values()), list(other.values()), equal_nan=True
    )


# What is done


def test_nothing_is_done_before_the_check(monkeypatch: pytest.MonkeyPatch) -> None:
    def work(*_: object) -> None:
        raise AssertionError("work was done")

    for name in ("robot_named", "controller_of", "desired_motion"):
        monkeypatch.setattr(execution, name, work)
    for wrong in (Run("pid"), Run(snr_db=math.nan), Run(payload=-1.0), Run(duration=0.0)):
        with pytest.raises((UnknownName, InvalidValue)):
            execute(wrong)


def test_every_value_that_is_offered_is_taken() -> None:
    for reference in REFERENCES:
        for entries in ENTRIES:
            run = Run(snr_db=15.0, snr_reference=reference, noisy_entries=entries, duration=0.1)
            assert execute(run)["diverged"] == 0.0
    for name in TRAJECTORIES:
        assert execute(Run("ctc", trajectory=name, duration=0.1))["diverged"] == 0.0
    for name in PARAMETER_SETS:
        assert execute(Run("t1", parameters=name, duration=0.1))["diverged"] == 0.0
    for period in (0.05, 0.01, 0.002, 0.0005):
        assert execute(Run("ctc", period=period, duration=0.1))["end_time"] == pytest.approx(
            0.1, rel=1e-12
        )
    assert execute(Run("pd", duration=0.002))["end_time"] == 0.002


@pytest.mark.parametrize("kind", ["t1", "it2", "gt2"])
def test_terms_too_narrow_for_the_path_are_refused_unless_they_vary_over_all_of_it(
    kind: str,
) -> None:
    with pytest.raises(InvalidValue, match="term_width"):
        execute(Run(kind, term_width=0.001, duration=0.1))
    execute(Run("it2", term_width=0.001, mean_variation=1.0, duration=0.1))
    execute(Run("pd", term_width=0.001, duration=0.1))


def a_run() -> st.SearchStrategy[Run]:
    """Return runs of a twentieth of a second with every field at random."""
    return st.builds(
        Run,
        controller=st.sampled_from((*CLASSICAL, *KINDS)),
        reading=st.sampled_from(READINGS),
        snr_db=st.sampled_from([math.inf, 40.0, 20.0, 10.0]),
        seed=st.integers(0, 3),
        trajectory=st.sampled_from(list(TRAJECTORIES)),
        learner=st.sampled_from(["strongest", "strict", "average", "ridge"]),
        n_terms=st.sampled_from([1, 2]),
        mean_variation=st.sampled_from([None, 0.0, 0.2]),
        levels=st.sampled_from([1, 3, 5]),
        reduction=st.sampled_from(REDUCTIONS),
        outside=st.sampled_from(OUTSIDE),
        samples=st.sampled_from([50, 209]),
        payload=st.sampled_from([0.0, 2.0]),
        coulomb_friction=st.sampled_from([0.0, 10.0]),
        viscous_friction=st.sampled_from([0.0, 3.0]),
        motor_inertia=st.sampled_from([0.0, 1e-5]),
        lead=st.sampled_from([0.005, 0.010]),
        encoder_resolution=st.sampled_from([0.0, 1e-5]),
        delay=st.sampled_from([0, 1]),
        payload_from=st.sampled_from([0.0, 0.03]),
        position_noise=st.sampled_from([0.0, 1e-6]),
        initial_error=st.sampled_from([0.0, 1e-4]),
        learning_seed=st.sampled_from([None, 0]),
        duration=st.just(0.05),
        snr_reference=st.sampled_from(REFERENCES),
        noisy_entries=st.sampled_from(ENTRIES),
        defuzzify=st.sampled_from(ORDERS),
    )


@settings(max_examples=150)
@given(a_run())
def test_a_run_and_its_canonical_form_have_the_same_metrics(run: Run) -> None:
    """Bit for bit; the canonical form of a canonical form is itself.

    It is a run like any other.
    """
    canonical = run.canonical()
    canonical.check()
    assert canonical.canonical() == canonical
    try:
        expected = execute(run)
    except (Fuzzy2Error, UnusableEstimate) as error:
        with pytest.raises(type(error)):
            execute(canonical)
        return
    assert same(execute(canonical), expected)


# Determinism

SOME = [
    Run(controller, reading, 15.0, seed, learner="average", duration=0.4)
    for controller in ("ctc", "t1", "it2", "gt2")
    for reading in READINGS
    for seed in (0, 1)
]


@pytest.fixture(scope="module")
def expected() -> list[dict[str, float]]:
    return [execute(run) for run in SOME]


def test_runs_are_the_same_every_time_and_in_every_thread(expected: list[dict[str, float]]) -> None:
    with ThreadPoolExecutor(4) as pool:
        for found in (
            map(execute, SOME[::-1]),
            pool.map(execute, SOME[::-1]),
            pool.map(execute, SOME[::-1]),
        ):
            assert all(same(one, other) for one, other in zip(found, expected[::-1], strict=True))


def in_a_new_process(runs: list[Run], **environment: str) -> list[dict[str, float]]:
    """Execute runs in threads that start at once, with nothing warm.

    Each may be the first to load, to record and to compile.
    """
    program = (
        "import sys, json, threading\n"
        "from concurrent.futures import ThreadPoolExecutor\n"
        "from psp3.study.execution import execute\n"
        "from psp3.study.run import Run\n"
        "runs = [Run(**fields) for fields in json.loads(sys.stdin.read())]\n"
        "with ThreadPoolExecutor(4) as pool:\n"
        "    print(json.dumps(list(pool.map(execute, runs))))\n"
    )
    text, command = (
        json.dumps([asdict(run) for run in runs]),
        [sys.executable, "-W", "error", "-c", program],
    )
    done = subprocess.run(
        command,
        input=text,
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, **environment},
    )
    found: list[dict[str, float]] = json.loads(done.stdout)
    return found


@pytest.mark.slow
def test_runs_are_the_same_in_a_new_process_whose_threads_start_at_once(
    expected: list[dict[str, float]],
) -> None:
    assert all(
        same(one, other) for one, other in zip(in_a_new_process(SOME), expected, strict=True)
    )


@pytest.mark.slow
def test_runs_agree_with_those_of_another_processor() -> None:
    """An old processor's linear algebra sums in another order, where OpenBLAS is used.

    Whole runs agree to 1e-9, the promised bar.
    """
    some = [
        Run(kind, snr_db=10.0, seed=1, learner=learner)
        for kind in ("t1", "it2", "gt2")
        for learner in ("strongest", "ridge")
    ]
    for run, found in zip(some, in_a_new_process(some, OPENBLAS_CORETYPE="Nehalem"), strict=True):
        assert found == pytest.approx(execute(run), rel=1e-9, nan_ok=True)


def test_seeds_change_every_noisy_run(expected: list[dict[str, float]]) -> None:
    for zero, one in zip(expected[::2], expected[1::2], strict=True):
        blind = zero["sum_of_squared_errors"] == one["sum_of_squared_errors"]
        run = SOME[2 * expected[::2].index(zero)]
        assert blind == (run.controller == "ctc" and run.reading == "parameters")


def test_what_a_result_holds_cannot_spoil_later_runs() -> None:
    """Desired motions are shared among runs, so they are read-only."""
    run = Run("pd", duration=0.1)
    before = execute(run)
    result = simulate_run(run).result
    for array in (result.t, *result.desired):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
    result.heights[:] = result.torque[:] = 0.0
    assert same(execute(run), before)


def test_noise_of_a_seed_is_the_same_at_every_ratio_but_for_its_size() -> None:
    """Forces without feedback of the noise: one step of PD with noisy measurements.

    1e-9: differences of 100 N in 1e-2 N.
    """
    forces = {
        snr: simulate_run(Run("pd", "measurement", snr, 5, duration=0.002)).result.torque[0]
        for snr in (math.inf, 60.0, 40.0, 20.0)
    }
    small, middle, large = (forces[snr] - forces[math.inf] for snr in (60.0, 40.0, 20.0))
    np.testing.assert_allclose(middle, 10.0 * small, rtol=1e-9)
    np.testing.assert_allclose(large, 100.0 * small, rtol=1e-9)
    assert np.abs(small).min() > 1e-3


def test_the_noise_of_the_readings_is_what_the_table_says() -> None:
    """Forces of one sample written out with the generator's numbers.

    1e-9 relative, for feedback multiplies rounding by 1000.
    """
    recorded, start = record(ROBOT, HELIX), HELIX(0.0)
    ratio = 10.0 ** (-20.0 / 20.0)
    draws = np.random.default_rng([5, 1]).standard_normal((2, 6))[0]
    powers = np.concatenate(
        [np.mean(recorded.heights**2, axis=0), np.mean(recorded.speeds**2, axis=0)]
    )
    error = np.sqrt(powers) * ratio * draws
    measured = simulate_run(Run("pd", "measurement", 20.0, 5, duration=0.002)).result.torque[0]
    np.testing.assert_allclose(
        measured, 1000.0 * -error[:3] + 100.0 * (start.speeds - error[3:]), rtol=1e-9
    )

    draws = np.random.default_rng([5, 1]).standard_normal((2, 18))[0]
    M, _, G = ROBOT.equation_of_motion(start.heights, np.zeros(3))
    noise = np.sqrt(np.mean(recorded.outputs**2, axis=0)) * ratio * draws
    online = simulate_run(Run("ctc", "online", 20.0, 5, duration=0.002)).result.torque[0]
    upper = np.zeros((3, 3))
    upper[np.triu_indices(3)] = noise[:6]
    servo = start.accelerations + start.speeds
    np.testing.assert_allclose(
        online, (M + upper + np.triu(upper, 1).T) @ servo + G + noise[15:], rtol=1e-9
    )

    gravity = np.where(np.arange(18) < 15, 0.0, np.std(recorded.outputs, axis=0)) * ratio * draws
    changed = Run(
        "ctc",
        "online",
        20.0,
        5,
        duration=0.002,
        snr_reference="variance",
        noisy_entries="gravity",
    )
    np.testing.assert_allclose(
        simulate_run(changed).result.torque[0], M @ servo + G + gravity[15:], rtol=1e-9
    )

    # The rules' noise is that of the other stream, so that both can be paired.
    controller = trained(Run("t1", "parameters", 20.0, 5), ROBOT, np.random.default_rng([5, 0]))
    samples = recorded.outputs[recorded.sample(209)]
    clean = trained(Run("t1"), ROBOT, np.random.default_rng(0)).system_.consequents
    source = [int(np.flatnonzero((samples == rule).all(axis=1))[0]) for rule in clean]
    draws = np.random.default_rng([5, 0]).standard_normal((209, 18))
    np.testing.assert_allclose(
        controller.system_.consequents, (samples + ratio * recorded.rms * draws)[source], rtol=1e-14
    )


@pytest.mark.parametrize(
    ("options", "matters"),
    [
        ({"controller": "t1"}, False),
        ({"controller": "it2"}, False),
        ({"controller": "gt2", "reduction": "gaussian"}, False),
        ({"controller": "gt2"}, True),
        ({"controller": "gt2", "levels": 1}, False),
        ({"controller": "gt2", "levels": 2}, True),
    ],
)
def test_the_order_of_defuzzification_is_that_of_the_controller(
    options: dict[str, Any], matters: bool
) -> None:
    """First forces of a controller learned by the public way, bit for bit.

    And it is the same number in either order where the canonical form drops it.
    """
    first, last = (
        Run(snr_db=20.0, seed=5, duration=0.002, defuzzify=order, **options)
        for order in ("first", "last")
    )
    controller = psp3.FuzzyComputedTorque(
        options["controller"],
        ROBOT,
        snr_db=20.0,
        defuzzify="last",
        levels=options.get("levels", 5),
        reduction=options.get("reduction", "alpha_planes"),
    ).fit(HELIX, rng=np.random.default_rng([5, 0]))
    desired = HELIX(0.0)
    torque = simulate_run(last).result.torque[0]
    np.testing.assert_array_equal(
        torque, controller.torque(0.0, desired.heights, np.zeros(3), desired)
    )
    assert (first.canonical() != last.canonical()) is matters
    differ = not np.array_equal(torque, simulate_run(first).result.torque[0])
    assert differ is matters


def test_noisy_inputs_are_what_the_rules_are_learned_from() -> None:
    """A controller that learns, by the public way, from a record that was made noisy here."""
    run = Run("it2", "inputs", 20.0, 5)
    recorded = record(ROBOT, HELIX)
    chosen = recorded.sample(209)
    noise = np.random.default_rng([5, 0]).standard_normal((209, 4))
    inputs = recorded.inputs[chosen] + 0.1 * np.sqrt((recorded.inputs**2).mean(axis=0)) * noise
    noisy = replace(
        recorded,
        **{
            name: getattr(recorded, name)[chosen]
            for name in ("t", "positions", "speeds", "outputs")
        },
        inputs=inputs,
    )
    expected = psp3.FuzzyComputedTorque(
        "it2", ROBOT, mean_variation=float(fuzzy2.mean_variation_from_snr(20.0))
    ).learn(noisy, 209)
    found = trained(run, ROBOT, np.random.default_rng([5, 0]))
    np.testing.assert_allclose(found.ranges_, expected.ranges_, rtol=1e-12)
    np.testing.assert_allclose(
        found.system_.consequents, expected.system_.consequents, rtol=1e-12, atol=1e-15
    )
    clean = trained(Run("it2"), ROBOT, np.random.default_rng(0))
    assert np.abs(found.ranges_ - clean.ranges_).min() > 0.0
    assert execute(run) != execute(replace(run, seed=6))


@pytest.mark.parametrize("reading", ["measurement", "online", "plant"])
def test_other_readings_leave_the_rules_alone_and_widen_the_terms_all_the_same(
    reading: str,
) -> None:
    run = Run("it2", reading, 15.0, 4)
    controller = trained(run, ROBOT, np.random.default_rng([4, 0]))
    clean = trained(Run("it2"), ROBOT, np.random.default_rng(0))
    np.testing.assert_array_equal(controller.system_.consequents, clean.system_.consequents)
    assert controller.mean_variation == fuzzy2.mean_variation_from_snr(15.0)
    assert (
        trained(replace(run, mean_variation=0.1), ROBOT, np.random.default_rng(0)).mean_variation
        == 0.1
    )


def test_mismatched_parameters() -> None:
    rng = np.random.default_rng(0)
    nominal = ROBOT.parameters
    assert mismatched(nominal, 0.0, 0.0, rng) == nominal
    assert mismatched(nominal, 0.0, 2.5, rng) == replace(nominal, star_mass=nominal.star_mass + 2.5)
    changed = [mismatched(nominal, 0.1, 0.0, np.random.default_rng(seed)) for seed in range(400)]
    names = ("nut_mass", "ball_mass", "ball_axial_inertia", "ball_transverse_inertia")
    logarithms = np.log(
        [[getattr(one, name) / getattr(nominal, name) for name in names] for one in changed]
    )
    inertias = np.log([np.divide(one.star_inertia, nominal.star_inertia) for one in changed])
    # 400 draws: the mean within 4 · 0.1/20, the deviation within 15 %, four standard errors each.
    for sample in (*logarithms.T, *inertias.T):
        assert abs(sample.mean()) < 0.02
        assert sample.std() == pytest.approx(0.1, rel=0.15)
    # Payload 0.5 kg · |ε|: mean 0.4 kg, on a star whose mass is right on average.
    assert np.mean([one.star_mass for one in changed]) == pytest.approx(
        nominal.star_mass * np.exp(0.005) + 0.5 * np.sqrt(2 / np.pi), abs=0.07
    )
    assert {(one.screw_radius, one.tool_length, one.gravity) for one in changed} == {
        (0.181, 0.07, 9.81)
    }


def test_the_plant_is_the_mismatched_one() -> None:
    """The same run with Python's plant and the parameters drawn from the run's stream.

    The controller keeps the nominal model.

    1e-12 m: products of matrices are summed in another order.
    """
    run = Run("ctc", "plant", 20.0, 3, payload=1.0, duration=0.5)
    real = mismatched(ROBOT.parameters, 0.1, 1.0, np.random.default_rng([3, 1]))
    plant = RungeKutta(psp3.load("psp3", real))
    expected = psp3.simulate(ROBOT, psp3.ComputedTorque(ROBOT), HELIX, 0.5, plant=plant)
    np.testing.assert_allclose(
        simulate_run(run).result.heights, expected.heights, rtol=0.0, atol=1e-12
    )
    heavy = execute(Run("pd-gravity", "plant", payload=3.0, duration=5.0))
    # At rest the payload sags kp-fold: 3 kg · g / 3 screws / 1000 N/m = 9.81 mm, and the helix's
    # own errors add up to 6 mm.
    assert 0.009 < heavy["rms_error"] / math.sqrt(3.0) < 0.013


REALISTIC: dict[str, Any] = {
    "coulomb_friction": 10.0,
    "viscous_friction": 5.0,
    "motor_inertia": 1e-5,
    "lead": 0.010,
    "encoder_resolution": 5e-6,
    "delay": 1,
}


def test_friction_motor_encoder_and_delay_are_those_of_the_simulation() -> None:
    """All at once, with the payload and parameters drawn from the run's stream.

    Bit for bit, since PD multiplies no matrices.
    """
    run = Run("pd", "plant", 20.0, 3, payload=1.0, duration=1.0, **REALISTIC)
    real = psp3.load("psp3", mismatched(ROBOT.parameters, 0.1, 1.0, np.random.default_rng([3, 1])))
    plant = RungeKutta(real, drive=Drive(10.0, 5.0, 1e-5, 0.010))
    expected = psp3.simulate(
        ROBOT, psp3.PD(), HELIX, 1.0, plant=plant, encoder_resolution=5e-6, delay=1
    )
    found = simulate_run(run).result
    for name in ("heights", "speeds", "torque", "tip"):
        np.testing.assert_array_equal(getattr(found, name), getattr(expected, name))


@pytest.mark.parametrize("name", [name for name in REALISTIC if name != "lead"])
def test_each_of_them_changes_every_controllers_result(name: str) -> None:
    """Without noise, too; and alone."""
    changed = {name: REALISTIC[name]} | ({"lead": 0.010} if name == "motor_inertia" else {})
    for controller in ("pd", "ctc", "it2"):
        run = Run(controller, "plant", duration=1.0, **changed)
        assert getattr(run.canonical(), name) == REALISTIC[name]
        with_it, without = execute(run), execute(Run(controller, duration=1.0))
        assert with_it["sum_of_squared_errors"] != without["sum_of_squared_errors"]
        assert with_it["diverged"] == 0.0


# Metrics


NOISY = Run("pd-gravity", "online", -20.0, 7, duration=0.1)
"""Noise of ten times the weight: the largest force pulls down."""


@pytest.mark.parametrize(
    "run",
    [
        Run("pd"),
        Run("ctc", trajectory="waypoints"),
        Run("it2", snr_db=15.0, seed=2, duration=3.0),
        Run("t1", period=0.01),
        NOISY,
    ],
    ids=str,
)
def test_metrics_are_their_definitions(run: Run) -> None:
    """Sums written out; 1e-12 relative is their rounding.

    The functions of ``psp3.simulation.metrics`` say the same of the same result.
    """
    result = simulate_run(run).result
    found = execute(run)
    assert tuple(found) == METRICS
    assert {type(value) for value in found.values()} == {float}
    error, tip_error = result.desired.heights - result.heights, result.desired.tip - result.tip
    steps, every = len(result.t) - 1, round(0.05 / run.period)
    squares = [sum(e**2 for e in row) for row in error]
    forces = [sum(f**2 for f in row) for row in result.torque]

    def integral(values: list[float]) -> float:
        return run.period * (sum(values) - 0.5 * (values[0] + values[-1]))

    expected = {
        "sum_of_squared_errors": sum(squares[k] for k in range(0, steps + 1, every)),
        "integral_of_squared_error": integral(squares),
        "rms_tip_error": math.sqrt(sum(sum(e**2 for e in row) for row in tip_error) / (steps + 1)),
        "largest_tip_error": max(math.hypot(*row) for row in tip_error),
        "effort": integral(forces),
        "largest_torque": max(abs(force) for row in result.torque for force in row),
        "fallbacks": 0.0,
        "left_stroke": 0.0,
        "diverged": 0.0,
        "end_time": run.duration,
    }
    late = squares[len(squares) // 2 :]
    expected["rms_error"] = math.sqrt(sum(squares) / (steps + 1))
    expected["settled_error"] = math.sqrt(sum(late) / len(late))
    expected["largest_error"] = max(abs(e) for row in error for e in row)
    for name, value in expected.items():
        assert found[name] == pytest.approx(value, rel=1e-12), name
    assert metrics.sum_of_squared_errors(result) == pytest.approx(
        found["sum_of_squared_errors"], rel=1e-12
    )
    assert metrics.integral_of_squared_error(result) == pytest.approx(
        found["integral_of_squared_error"], rel=1e-12
    )
    assert metrics.largest_tip_error(result) == pytest.approx(found["largest_tip_error"], rel=1e-12)
    assert result.t.size == round(run.duration / run.period) + 1
    np.testing.assert_array_equal(result.tip, ROBOT.forward_kinematics(result.heights).tip)


def test_coverage_is_the_share_of_steps_inside_the_trained_range() -> None:
    run = Run("it2", trajectory="fast-helix", duration=2.0)
    result, found = simulate_run(run).result, execute(run)
    least, greatest = trained(run, ROBOT, np.random.default_rng(0)).ranges_
    a, v = result.heights, result.speeds
    inputs = np.stack(
        [a[:, 0] - a[:, 1], a[:, 0] - a[:, 2], v[:, 0] - v[:, 1], v[:, 0] - v[:, 2]], axis=1
    )
    inside = ((least <= inputs) & (inputs <= greatest)).all(axis=1)
    assert found["coverage"] == inside.mean()
    assert 0.0 < found["coverage"] < 1.0
    np.testing.assert_array_equal(result.covered, inside)
    assert execute(Run("ctc", trajectory="fast-helix", duration=2.0))["coverage"] == 1.0


@pytest.mark.parametrize(
    ("name", "controller"), [("pd", psp3.PD()), ("ctc", psp3.ComputedTorque(ROBOT))]
)
def test_runs_are_those_of_the_simulation(name: str, controller: Any) -> None:
    """Over all 10.4 s; 1e-9 relative in the error leaves room for the order of sums."""
    expected = psp3.simulate(ROBOT, controller, HELIX, 10.4)
    found = execute(Run(name))
    assert found["sum_of_squared_errors"] == pytest.approx(
        metrics.sum_of_squared_errors(expected), rel=1e-9
    )
    assert found["integral_of_squared_error"] == pytest.approx(
        metrics.integral_of_squared_error(expected), rel=1e-9
    )
    assert found["end_time"] == expected.t[-1]


def test_open_loop_diverges_and_says_so() -> None:
    """It leaves its screws first, and then the poses that the robot can take.

    Off the screws the run goes on.
    """
    found = execute(Run("feed-forward"))
    assert found["diverged"] == found["left_stroke"] == 1.0
    assert 1.0 < found["end_time"] < 10.4
    ends = ("coverage", "fallbacks", "left_stroke", "diverged", "end_time")
    assert all(math.isnan(value) == (name not in ends) for name, value in found.items())
    samples = simulate_run(Run("feed-forward"))
    assert len(samples.result.t) < samples.steps == 5201
    assert np.isfinite(samples.result.torque).all()


def test_leaving_the_stroke_is_noted_and_does_not_end_a_run() -> None:
    """PD sags by a third of the weight over 1000 N/m.

    0.12 m with a payload of 10 kg, and 0.58 m, beyond the screws, with 150 kg.
    """
    light, heavy = (
        execute(Run("pd", "plant", payload=payload, duration=5.0)) for payload in (10.0, 150.0)
    )
    assert (light["left_stroke"], light["diverged"]) == (0.0, 0.0)
    assert (heavy["left_stroke"], heavy["diverged"], heavy["end_time"]) == (1.0, 0.0, 5.0)


def test_a_run_without_a_single_sample_has_no_metrics() -> None:
    """The very first measurement, off by meters, is no pose.

    No force, no sample, and no warning of an empty mean.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for seed in range(5):
            found = execute(Run("ctc", "measurement", -60.0, seed, duration=0.1))
            if found["end_time"] == 0.0 and math.isnan(found["coverage"]):
                return
    raise AssertionError("every first measurement was a pose")


def test_what_cannot_be_learned_or_followed_is_an_error_of_the_run() -> None:
    with pytest.raises(UnsupportedRule, match="Δq12"):
        execute(Run("t1", n_terms=3))
    with pytest.raises(UnusableEstimate):
        execute(Run("t1", snr_db=-10.0, duration=0.1))
    with pytest.raises(StrokeExceeded):
        execute(Run("pd", duration=60.0))
    with pytest.raises(InvalidValue, match="length of the record"):
        execute(Run("t1", samples=6000))
    # The classical controllers learn nothing, so nothing can go wrong with it.
    assert execute(Run("ctc", n_terms=3, snr_db=-10.0, duration=0.1))["diverged"] == 0.0


# The thesis


def test_the_pd_row_of_table_6_3_is_its_sag() -> None:
    """Printed: 4.6339; the bar is 5 %. The sag alone gives 0.0225 m² (T − 0.106 s)/0.05 s."""
    found = execute(Run("pd"))["sum_of_squared_errors"]
    assert found == pytest.approx(4.6339, rel=0.05)
    assert found == pytest.approx(0.0225 * (10.4 - 0.106) / 0.05, rel=0.01)


def test_without_noise_the_kinds_agree() -> None:
    """Of 10.4 s to 1e-12 relative, which is what the issue asks for."""
    type1, *others = (execute(Run(kind)) for kind in ("t1", "it2", "gt2"))
    corollary = execute(Run("gt2", reduction="gaussian"))
    for other in (*others, corollary):
        assert list(other.values()) == pytest.approx(list(type1.values()), rel=1e-12)


@pytest.fixture(scope="module")
def paired() -> dict[str, list[float]]:
    """Return the sums of squared errors of six seeds at 15 dB, rules by averages."""
    return {
        kind: [
            execute(Run(kind, snr_db=15.0, seed=seed, learner="average"))["sum_of_squared_errors"]
            for seed in range(6)
        ]
        for kind in ("t1", "it2", "gt2")
    }


@pytest.mark.parametrize("kind", ["it2", "gt2"])
def test_type_2_is_better_under_noisy_records(paired: dict[str, list[float]], kind: str) -> None:
    """The published picture: a mean error of about half or less.

    Seeds are fixed, so this cannot fail by chance.
    """
    assert np.mean(paired[kind]) < 0.75 * np.mean(paired["t1"])


# Any robot


@pytest.mark.parametrize("name", ["pd-gravity", "ctc"])
def test_runs_of_another_robot_are_those_of_the_simulation(name: str) -> None:
    """With gains of the reference pose, a payload at the tip, noise and friction.

    The controller keeps the robot as drawn. 1e-12 rad, for sums in another order.
    """
    robot, run = psp3.load("five_bar"), Run(name, robot="five_bar", duration=0.5, payload=0.1)
    run = replace(run, coulomb_friction=0.01, viscous_friction=0.02)
    plant = RungeKutta(psp3.with_payload(robot, 0.1), drive=Drive(0.01, 0.02))
    made = {"pd-gravity": GravityCompensatedPD, "ctc": psp3.ComputedTorque}[name]
    controller = made(robot, **default_gains(robot, name))
    expected = psp3.simulate(robot, controller, Sway(robot=robot), 0.5, plant=plant)
    found = simulate_run(run).result
    np.testing.assert_allclose(found.positions, expected.positions, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(found.tip, expected.tip, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("name", ["adaptive-t1", "adaptive-it2"])
def test_rules_of_another_robot_adapt_to_its_payload(name: str) -> None:
    """Settled, a tenth of the error of computed torque that does not know the payload."""
    run = Run(name, robot="delta", duration=4.0, payload=0.5, snr_db=20.0)
    settled = [
        execute(one)["settled_error"]
        for one in (run, Run("ctc", robot="delta", duration=4.0, payload=0.5))
    ]
    assert settled[0] < 0.1 * settled[1]


def test_another_robots_bodies_are_off_by_one_factor_each() -> None:
    """Mass and inertia about the center of mass of a body go together, and its center stays."""
    robot = psp3.load("five_bar")
    changed = mismatched_robot(robot, 0.1, 0.0, np.random.default_rng(3))
    factors = np.exp(0.1 * np.random.default_rng(3).standard_normal(robot.model.njoints))
    for joint in range(1, robot.model.njoints):
        one, other = robot.model.inertias[joint], changed.model.inertias[joint]
        assert other.mass == pytest.approx(one.mass * factors[joint], rel=1e-14)
        np.testing.assert_allclose(other.inertia, one.inertia * factors[joint], rtol=1e-12)
        np.testing.assert_array_equal(other.lever, one.lever)
    assert mismatched_robot(robot, 0.0, 0.0, np.random.default_rng(0)) is robot
    pose = robot.reference
    assert not np.allclose(robot.mass_matrix(pose), changed.mass_matrix(pose), rtol=1e-3)


def test_payload_is_attached_at_its_time() -> None:
    """Until then the run is the one without, and from the sample on that with it begins there."""
    run = Run("ctc", payload=2.0, payload_from=0.2, duration=0.5)
    with_it, without = simulate_run(run).result, simulate_run(replace(run, payload=0.0)).result
    heavy = psp3.load("psp3", mismatched(ROBOT.parameters, 0.0, 2.0, np.random.default_rng(0)))
    np.testing.assert_array_equal(with_it.heights[:101], without.heights[:101])
    force = with_it.torque[100]
    reached = RungeKutta(heavy)
    reached.start(with_it.heights[100], with_it.speeds[100])
    heights, speeds = reached.advance(force, 0.002) or (None, None)
    np.testing.assert_allclose(with_it.heights[101], heights, rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(with_it.speeds[101], speeds, rtol=0.0, atol=1e-12)


class Outside:
    """A controller of somebody else, in Python."""

    def __init__(self, robot: Any) -> None:
        self._inner = psp3.ComputedTorque(robot, 10.0, 1.0)

    def reset(self) -> None:
        """Forget nothing."""

    def torque(self, t: float, positions: Any, speeds: Any, desired: Any) -> Any:
        """Return the forces of computed torque."""
        return self._inner.torque(t, positions, speeds, desired)


def test_loop_in_python_is_the_compiled_one() -> None:
    """Of a controller by where it is, payload at its time and noise included; 1e-12 m."""
    fields: dict[str, Any] = {
        "payload": 2.0,
        "payload_from": 0.1,
        "position_noise": 1e-5,
        "delay": 1,
        "seed": 2,
        "duration": 0.3,
    }
    own = simulate_run(Run(f"{__name__}:Outside", **fields)).result
    ours = simulate_run(Run("ctc", **fields)).result
    np.testing.assert_allclose(own.heights, ours.heights, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(own.torque, ours.torque, rtol=0.0, atol=1e-9)


def test_initial_errors_and_noise_are_what_they_are_said_to_be() -> None:
    """Of their streams; the path is drawn first from that of the initial errors."""
    run = Run("pd", seed=6, initial_error=1e-3, initial_speed_error=1e-2, duration=0.1)
    result, start = simulate_run(run).result, HELIX(0.0)
    draws = np.random.default_rng([6, 3]).standard_normal(6)
    np.testing.assert_allclose(result.heights[0], start.heights + 1e-3 * draws[:3], rtol=1e-15)
    np.testing.assert_allclose(result.speeds[0], start.speeds + 1e-2 * draws[3:], rtol=1e-15)
    noisy = Run("pd", seed=6, position_noise=1e-4, speed_noise=1e-3, duration=0.002)
    error = np.random.default_rng([6, 2]).standard_normal((2, 6))[0] * np.repeat([1e-4, 1e-3], 3)
    np.testing.assert_allclose(
        simulate_run(noisy).result.torque[0],
        -1000.0 * error[:3] + 100.0 * (start.speeds - error[3:]),
        rtol=1e-9,
    )


def test_rules_of_another_robot_are_those_of_its_controller_by_default() -> None:
    """About samples, and no grid, whose corners its sway does not pass by."""
    run = Run("t1", robot="five_bar")
    controller: Any = controller_of(run, robot_named("five_bar"))
    assert [len(system.rules) for system in controller.systems_] == [32, 32]
    grid: Any = controller_of(replace(run, n_terms=2), robot_named("five_bar"))
    assert [len(system.rules) for system in grid.systems_] == [4, 16]
    # Of the 3-PSP what is not given is what is published.
    assert Run("t1").canonical() == Run("t1", n_terms=2).canonical()


def test_learned_computed_torque_tracks_another_robots_sway_nearly_as_the_exact_one() -> None:
    """By default, without noise, within thrice its error."""
    errors = [
        execute(Run(name, robot="five_bar", duration=2.0))["rms_error"]
        for name in ("ctc", "t1", "it2")
    ]
    assert max(errors) <= 3.0 * errors[0]
