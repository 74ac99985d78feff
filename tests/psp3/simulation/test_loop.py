"""The compiled loop against the loop in Python, and both against loops written out here."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

import fuzzy2
import psp3
from psp3.control import kernels as classical_kernels
from psp3.control.controller import Widths, widths_of
from psp3.control.linear_quadratic_regulator import TimeVaryingLinearQuadraticRegulator
from psp3.drives import NO_DRIVE, Drive
from psp3.errors import SimulationDiverged
from psp3.fuzzy_control import kernels
from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
from psp3.fuzzy_control.records import Record, record, unpack
from psp3.simulation import kernels as loop_kernels
from psp3.simulation.loop import compiled_loop, new_track, unbounded
from psp3.simulation.runge_kutta import RungeKutta
from psp3.three_psp.parameters import Parameters
from psp3.three_psp.stepping import ClosedFormSteps, closed_form_table
from psp3.trajectories import Helix, Motion, Trajectory
from psp3.trajectories.fourier_series import FourierSeries

ROBOT = psp3.load("psp3")
HELIX = Helix(robot=ROBOT)
FAST = Helix(period=1.2, robot=ROBOT)  # leaves the trained range of the speeds

KINDS: dict[str, dict[str, Any]] = {
    "t1": {"kind": "t1"},
    "it2": {"kind": "it2"},
    "gt2": {"kind": "gt2"},
    "gt2 last": {"kind": "gt2", "defuzzify": "last"},
    "corollary": {"kind": "gt2", "reduction": "gaussian"},
    "crisp outside": {"kind": "it2", "outside": "crisp"},
}


@pytest.fixture(scope="module")
def recorded() -> Record:
    return record(ROBOT, HELIX)


@pytest.fixture(scope="module")
def trained(recorded: Record) -> dict[str, FuzzyComputedTorque]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fuzzy2.ApproximationWarning)
        return {
            name: FuzzyComputedTorque(robot=ROBOT, snr_db=20.0, learner="average", **options).learn(
                recorded, rng=np.random.default_rng(5)
            )
            for name, options in KINDS.items()
        }


class InPython(RungeKutta):
    """The same plant, which the compiled loop does not know."""


def in_python(
    robot: Any, controller: Any, trajectory: Trajectory, duration: float, **options: Any
) -> psp3.Result:
    """Return what the simulation does without its compiled loop."""
    options.setdefault("plant", InPython(robot))
    return psp3.simulate(robot, controller, trajectory, duration, **options)


def compiled_run(
    controller: Any,
    trajectory: Trajectory,
    steps: int,
    measured: np.ndarray | None = None,
    added: np.ndarray | None = None,
    plant: Parameters | None = None,
    drive: Drive = NO_DRIVE,
    resolution: float = 0.0,
    delay: int = 0,
) -> tuple[int, np.ndarray]:
    """Return the number of samples and the samples; those that were not written are NaN."""
    desired = trajectory(0.002 * np.arange(steps + 1))
    noise = np.empty((0, 18)) if added is None else added
    is_fuzzy, table = isinstance(controller, kernels.Fuzzy), controller
    if is_fuzzy:
        table = kernels.FuzzyRun(controller, closed_form_table(ROBOT.parameters.as_array()), noise)
    else:
        # A run changes the memory of its controller.
        table = controller._replace(added=noise, memory=np.zeros((4, 3)), clock=np.zeros(2))
    track = new_track(0.002 * np.arange(steps + 1), desired, 8 if is_fuzzy else 0)
    done = compiled_loop(
        table,
        ClosedFormSteps((plant or ROBOT.parameters).as_array(), 1, drive),
        unbounded(0.002, np.full(3, resolution), delay, measured),
        track,
        np.concatenate([desired.heights[0], np.zeros(3)]),
    ).samples
    flags = track.wrote[:, 9:] if is_fuzzy else np.tile([1.0, 0.0], (steps + 1, 1))
    samples = np.concatenate([track.states, track.applied, flags], axis=1)
    samples[done:] = np.nan
    return done, samples


def classical(kind: int, kp: float = 10.0, kv: float = 1.0) -> classical_kernels.Classical:
    model = ROBOT.compiled_table()
    if kind == classical_kernels.FEED_FORWARD:
        kp = kv = 0.0
    return classical_kernels.classical(kind, kp, kv, model, Widths.of_motors(3))


def python_loop(
    torque: Callable[[int, np.ndarray, np.ndarray, Motion], np.ndarray],
    trajectory: Trajectory,
    steps: int,
    measured: np.ndarray | None = None,
    plant: Parameters | None = None,
) -> np.ndarray:
    """Return heights, speeds and torque (N, 9) of a loop written with the Python plant.

    The controller sees what is measured.
    """
    desired = trajectory(0.002 * np.arange(steps + 1))
    robot = RungeKutta(psp3.load("psp3", plant) if plant else ROBOT)
    state = (desired.heights[0].copy(), np.zeros(3))
    robot.start(*state)
    rows = []
    for k in range(steps + 1):
        noise = np.zeros(6) if measured is None else measured[k]
        forces = torque(
            k, state[0] + noise[:3], state[1] + noise[3:], Motion(*(array[k] for array in desired))
        )
        rows.append(np.concatenate([*state, forces]))
        advanced = robot.advance(forces, 0.002)
        assert advanced is not None
        state = (advanced[0].copy(), advanced[1].copy())
    return np.array(rows)


# Without noise: the simulation


def test_pd_is_bit_for_bit_that_of_the_simulation() -> None:
    done, samples = compiled_run(classical(classical_kernels.PD, 1000.0, 100.0), HELIX, 1000)
    expected = in_python(ROBOT, psp3.PD(), HELIX, 2.0)
    assert done == 1001
    np.testing.assert_array_equal(samples[:, :3], expected.heights)
    np.testing.assert_array_equal(samples[:, 3:6], expected.speeds)
    np.testing.assert_array_equal(samples[:, 6:9], expected.torque)
    np.testing.assert_array_equal(samples[:, 9:], np.tile([1.0, 0.0], (1001, 1)))


@pytest.mark.parametrize(
    ("kind", "gains", "controller"),
    [
        (
            classical_kernels.GRAVITY_COMPENSATED_PD,
            (1000.0, 100.0),
            psp3.GravityCompensatedPD(ROBOT),
        ),
        (classical_kernels.COMPUTED_TORQUE, (10.0, 1.0), psp3.ComputedTorque(ROBOT)),
        (classical_kernels.COMPUTED_TORQUE, (250.0, 30.0), psp3.ComputedTorque(ROBOT, 250.0, 30.0)),
    ],
)
def test_classical_controllers_are_those_of_the_simulation(
    kind: int, gains: tuple[float, float], controller: Any
) -> None:
    """Products of matrices are summed in another order.

    Ulps of 100 N, which the loops damp; 1e-12 relative.
    """
    done, samples = compiled_run(classical(kind, *gains), HELIX, 1000)
    expected = in_python(ROBOT, controller, HELIX, 2.0)
    assert done == 1001
    np.testing.assert_allclose(samples[:, 6:9], expected.torque, rtol=1e-12)
    np.testing.assert_allclose(samples[:, :3], expected.heights, rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(samples[:, 3:6], expected.speeds, rtol=0.0, atol=1e-12)


def test_feed_forward_is_that_of_the_simulation_until_a_nut_leaves_its_screw() -> None:
    """There the simulation ends, and the compiled run goes on until the pose is none.

    The open loop is unstable, so 1e-9 m.
    """
    with pytest.raises(SimulationDiverged, match="ran off its screw") as caught:
        in_python(ROBOT, psp3.FeedForward(ROBOT), HELIX, 10.0)
    expected = caught.value.result
    done, samples = compiled_run(classical(classical_kernels.FEED_FORWARD, 0.0, 0.0), HELIX, 5000)
    shared = len(expected.t)
    assert shared < done < 5001
    np.testing.assert_allclose(samples[:shared, :3], expected.heights, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(samples[:shared, 6:9], expected.torque, rtol=1e-12)
    assert np.isfinite(samples[:done]).all()
    assert np.isnan(samples[done:]).all()


@pytest.mark.parametrize("trajectory", [HELIX, FAST], ids=["helix", "fast"])
@pytest.mark.parametrize("name", KINDS)
def test_fuzzy_controllers_are_bit_for_bit_those_of_the_simulation(
    trained: dict[str, FuzzyComputedTorque], name: str, trajectory: Trajectory
) -> None:
    done, samples = compiled_run(trained[name].controller, trajectory, 1000)
    expected = in_python(ROBOT, trained[name], trajectory, 2.0)
    assert done == 1001
    assert expected.covered is not None
    assert expected.fell_back is not None
    for columns, array in (
        (slice(3), expected.heights),
        (slice(3, 6), expected.speeds),
        (slice(6, 9), expected.torque),
    ):
        np.testing.assert_array_equal(samples[:, columns], array)
    np.testing.assert_array_equal(samples[:, 9], expected.covered)
    np.testing.assert_array_equal(samples[:, 10], expected.fell_back)
    assert 0 < expected.covered.sum() < 1001


def test_what_a_fuzzy_controller_says_of_itself_is_in_the_result_and_its_file(
    trained: dict[str, FuzzyComputedTorque], tmp_path: Path
) -> None:
    controller = trained["it2"]
    result = in_python(ROBOT, controller, FAST, 0.5)
    loaded = psp3.load_result(result.save(tmp_path / "run.npz"))
    for k in (0, 100, 250):
        controller.torque(
            0.0,
            result.heights[k],
            result.speeds[k],
            Motion(*(array[k] for array in result.desired)),
        )
        assert result.torque_interval is not None
        np.testing.assert_array_equal(result.torque_interval[k], controller.torque_interval)
        assert (result.torque_interval[k, :, 0] < result.torque[k]).all()
        assert (result.torque[k] < result.torque_interval[k, :, 1]).all()
    for name in ("covered", "fell_back", "torque_interval"):
        np.testing.assert_array_equal(getattr(loaded, name), getattr(result, name))
        assert getattr(loaded, name).dtype == getattr(result, name).dtype
    plain = psp3.load_result(in_python(ROBOT, psp3.PD(), HELIX, 0.1).save(tmp_path / "plain.npz"))
    assert (plain.covered, plain.fell_back, plain.torque_interval) == (None, None, None)


def test_a_file_with_flags_of_another_shape_is_refused(
    trained: dict[str, FuzzyComputedTorque], tmp_path: Path
) -> None:
    path = in_python(ROBOT, trained["t1"], HELIX, 0.1).save(tmp_path / "run.npz")
    with np.load(path) as archive:
        arrays = dict(archive)
    for name, array in (
        ("covered", np.ones(51)),
        ("fell_back", np.ones(50, bool)),
        ("torque_interval", np.ones((51, 2, 3))),
    ):
        np.savez(path, **{**arrays, name: array})
        with pytest.raises(psp3.errors.InvalidResultFile, match=name):
            psp3.load_result(path)


# With noise: loops written out


def noise(steps: int, sizes: Any, seed: int = 0) -> np.ndarray:
    return np.asarray(np.random.default_rng(seed).normal(size=(steps + 1, len(sizes))) * sizes)


MEASURED = noise(300, [1e-4] * 3 + [1e-2] * 3)
"""A tenth of a millimeter and a centimeter a second."""

ADDED = noise(300, [0.5] * 6 + [0.05] * 9 + [2.0] * 3, seed=1)
"""Half a kilogram, 0.05 kg/s and 2 N."""


PYTHON: dict[int, Any] = {
    classical_kernels.PD: psp3.PD(),
    classical_kernels.GRAVITY_COMPENSATED_PD: psp3.GravityCompensatedPD(ROBOT),
    classical_kernels.COMPUTED_TORQUE: psp3.ComputedTorque(ROBOT, 1000.0, 100.0),
    classical_kernels.FEED_FORWARD: psp3.FeedForward(ROBOT),
}


@pytest.mark.parametrize("kind", PYTHON)
def test_measurement_noise_is_seen_by_classical_controllers(kind: int) -> None:
    """The open loop sees nothing of it.

    1e-11 relative: rounding by the order of sums, carried through 300 stiff steps.
    """
    expected = python_loop(
        lambda k, a, v, desired: PYTHON[kind].torque(0.0, a, v, desired), HELIX, 300, MEASURED
    )
    done, samples = compiled_run(classical(kind, 1000.0, 100.0), HELIX, 300, MEASURED)
    assert done == 301
    np.testing.assert_allclose(samples[:, 6:9], expected[:, 6:], rtol=1e-11)
    np.testing.assert_allclose(samples[:, :6], expected[:, :6], rtol=0.0, atol=1e-12)
    clean = compiled_run(classical(kind, 1000.0, 100.0), HELIX, 300)[1]
    assert np.array_equal(clean, samples) == (kind == classical_kernels.FEED_FORWARD)


@pytest.mark.parametrize("name", KINDS)
def test_measurement_noise_is_seen_by_fuzzy_controllers(
    trained: dict[str, FuzzyComputedTorque], name: str
) -> None:
    """By servo and estimator, bit for bit as if the Python controller saw it."""
    controller = trained[name]
    expected = python_loop(
        lambda k, a, v, desired: controller.torque(0.0, a, v, desired), HELIX, 300, MEASURED
    )
    samples = compiled_run(controller.controller, HELIX, 300, MEASURED)[1]
    np.testing.assert_array_equal(samples[:, :9], expected)


@pytest.mark.parametrize("kind", PYTHON)
def test_online_noise_is_added_to_the_models_of_classical_controllers(kind: int) -> None:
    """The equations of chapter 4 with Pinocchio's M, C and G plus noise.

    1e-8 relative, for the two models agree to 1e-9.
    """
    pinocchio = ROBOT.dynamics("pinocchio")

    def torque(k: int, a: np.ndarray, v: np.ndarray, desired: Motion) -> np.ndarray:
        open_loop = kind == classical_kernels.FEED_FORWARD
        exact = pinocchio.equation_of_motion(
            *((desired.heights, desired.speeds) if open_loop else (a, v))
        )
        M, C, G = (one + other for one, other in zip(exact, unpack(ADDED[k]), strict=True))
        feedback = 1000.0 * (desired.heights - a) + 100.0 * (desired.speeds - v)
        if kind == classical_kernels.PD:
            return np.asarray(feedback)
        if kind == classical_kernels.GRAVITY_COMPENSATED_PD:
            return np.asarray(feedback + G)
        if kind == classical_kernels.COMPUTED_TORQUE:
            return np.asarray(M @ (desired.accelerations + feedback) + C @ v + G)
        return np.asarray(M @ desired.accelerations + C @ desired.speeds + G)

    expected = python_loop(torque, HELIX, 100)
    samples = compiled_run(classical(kind, 1000.0, 100.0), HELIX, 100, added=ADDED[:101])[1]
    np.testing.assert_allclose(samples[:, 6:9], expected[:, 6:], rtol=1e-8)
    np.testing.assert_allclose(samples[:, :6], expected[:, :6], rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize("size", [1.0, 15.0])
def test_online_noise_is_added_to_the_estimates_of_fuzzy_controllers(
    trained: dict[str, FuzzyComputedTorque], name: str, size: float
) -> None:
    """Estimates plus noise, or their average where that has no mass matrix by its eigenvalues.

    With 7.5 kg of noise that happens.

    1e-9 relative: rounding of the estimates by 1e-16, carried through 300 steps of a loop without
    much damping.
    """
    controller = trained[name]
    fallbacks = []

    def torque(k: int, a: np.ndarray, v: np.ndarray, desired: Motion) -> np.ndarray:
        x = np.array([a[0] - a[1], a[0] - a[2], v[0] - v[1], v[0] - v[2]])
        inside = bool(((controller.ranges_[0] <= x) & (x <= controller.ranges_[1])).all())
        crisp = controller.outside == "crisp" and not inside
        model = ROBOT.equation_of_motion(a, v) if crisp else controller.estimate(a, v)
        M, C, G = (one + other for one, other in zip(model, unpack(size * ADDED[k]), strict=True))
        fallbacks.append(not crisp and bool(np.linalg.eigvalsh(M)[0] <= 0.0))
        if fallbacks[-1]:
            M, C, G = unpack(controller.fallback_)
        servo = desired.accelerations + 10.0 * (desired.heights - a) + (desired.speeds - v)
        if controller.order == "last" and not fallbacks[-1]:
            # Of a fuzzy torque the noise, a crisp one, moves the centroid.
            M, C, G = unpack(size * ADDED[k])
            without = controller.defuzzify(controller.torque_number(a, v, desired))
            return np.asarray(without + M @ servo + C @ v + G)
        return np.asarray(M @ servo + C @ v + G)

    expected = python_loop(torque, HELIX, 300)
    samples = compiled_run(controller.controller, HELIX, 300, added=size * ADDED)[1]
    np.testing.assert_allclose(samples[:, 6:9], expected[:, 6:], rtol=1e-9)
    np.testing.assert_allclose(samples[:, :6], expected[:, :6], rtol=0.0, atol=1e-10)
    np.testing.assert_array_equal(samples[:, 10], fallbacks)
    assert any(fallbacks) == (size > 1.0)


@pytest.mark.parametrize("name", KINDS)
def test_online_noise_moves_the_torques_interval_and_leaves_its_width(
    trained: dict[str, FuzzyComputedTorque], name: str
) -> None:
    """Noise is crisp: it moves both ends by as much as the torque, and no spread.

    1e-10 N is rounding of 1e2 N.
    """
    table, p, t = trained[name].controller, kernels.NO_MODEL, 1.3
    desired = HELIX(t)
    wanted = np.concatenate([desired.heights, desired.speeds, desired.accelerations])
    without, noisy = np.empty((2, kernels.step_width(3)))
    kernels.fuzzy_torque(table, p, desired.heights, desired.speeds, wanted, np.empty(0), without)
    kernels.fuzzy_torque(table, p, desired.heights, desired.speeds, wanted, ADDED[0], noisy)
    M, C, G = unpack(ADDED[0])
    moved = M @ desired.accelerations + C @ desired.speeds + G
    np.testing.assert_allclose(noisy[:3] - without[:3], moved, rtol=0.0, atol=1e-10)
    np.testing.assert_allclose(noisy[3:6] - without[3:6], moved, rtol=0.0, atol=1e-10)
    np.testing.assert_allclose(
        noisy[6:9] - without[6:9], 0.0 if name == "corollary" else moved, rtol=0.0, atol=1e-10
    )
    assert np.abs(moved).min() > 0.1


@pytest.mark.parametrize("name", ["it2", "crisp outside"])
def test_a_plant_that_the_controller_does_not_know(
    trained: dict[str, FuzzyComputedTorque], name: str
) -> None:
    """A star of 5 kg; the controller goes on believing in 1.758 kg."""
    heavy = Parameters(star_mass=5.0)
    controller = trained[name]
    expected = python_loop(
        lambda k, a, v, desired: controller.torque(0.0, a, v, desired), HELIX, 300, plant=heavy
    )
    samples = compiled_run(controller.controller, HELIX, 300, plant=heavy)[1]
    np.testing.assert_array_equal(samples[:, :9], expected)
    assert (
        np.abs(samples[:, :3] - compiled_run(controller.controller, HELIX, 300)[1][:, :3]).max()
        > 0.01
    )


# With drives, encoders and delays: the simulation

REALISTIC: dict[str, dict[str, Any]] = {
    "friction": {"drive": Drive(15.0, 4.0)},
    "motor": {"drive": Drive(motor_inertia=2e-5, lead=0.010)},
    "encoder": {"resolution": 5e-6},
    "delay": {"delay": 1},
    "all": {"drive": Drive(15.0, 4.0, 2e-5, 0.010), "resolution": 5e-6, "delay": 2},
}


def realistic(
    controller: Any, drive: Drive = NO_DRIVE, resolution: float = 0.0, delay: int = 0
) -> psp3.Result:
    plant = InPython(ROBOT, drive=drive)
    return in_python(
        ROBOT, controller, HELIX, 2.0, plant=plant, encoder_resolution=resolution, delay=delay
    )


@pytest.mark.parametrize("what", REALISTIC)
def test_a_realistic_plant_is_bit_for_bit_that_of_the_simulation(
    trained: dict[str, FuzzyComputedTorque], what: str
) -> None:
    """PD and an interval type-2 controller.

    Its Python steps are those of the compiled run to the last bit.
    """
    plain = compiled_run(trained["it2"].controller, HELIX, 1000)[1]
    for table, controller in (
        (classical(classical_kernels.PD, 1000.0, 100.0), psp3.PD()),
        (trained["it2"].controller, trained["it2"]),
    ):
        expected = realistic(controller, **REALISTIC[what])
        done, samples = compiled_run(table, HELIX, 1000, **REALISTIC[what])
        assert done == 1001
        np.testing.assert_array_equal(samples[:, :3], expected.heights)
        np.testing.assert_array_equal(samples[:, 3:6], expected.speeds)
        np.testing.assert_array_equal(samples[:, 6:9], expected.torque)
    assert np.abs(samples[:, :3] - plain[:, :3]).max() > 1e-6
    if "drive" in REALISTIC[what] and what != "motor":
        assert (expected.speeds[1:] == 0.0).any()


@pytest.mark.parametrize("what", REALISTIC)
def test_computed_torque_on_a_realistic_plant_is_that_of_the_simulation(what: str) -> None:
    """Products of matrices are summed in another order.

    Encoders' speeds divide rounding by 2 ms where it tips a count.

    With counts that happens in some sample or other, so there the first 20 ms are compared; the
    rest to 1e-11.
    """
    expected = realistic(psp3.ComputedTorque(ROBOT, 250.0, 30.0), **REALISTIC[what])
    samples = compiled_run(
        classical(classical_kernels.COMPUTED_TORQUE, 250.0, 30.0), HELIX, 1000, **REALISTIC[what]
    )[1]
    last = 10 if "resolution" in REALISTIC[what] else 1001
    np.testing.assert_allclose(samples[:last, :3], expected.heights[:last], rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(samples[:last, 6:9], expected.torque[:last], rtol=1e-9)


def test_measurement_noise_comes_before_the_counting() -> None:
    """The open loop in Python: what PD is shown is the noisy position, rounded."""
    seen: list[np.ndarray] = []

    def torque(k: int, a: np.ndarray, v: np.ndarray, desired: Motion) -> np.ndarray:
        seen.append(1e-4 * np.floor(a / 1e-4 + 0.5))
        speeds = (seen[-1] - seen[-2]) / 0.002 if k else np.zeros(3)
        return psp3.PD().torque(0.0, seen[-1], speeds, desired)

    expected = python_loop(torque, HELIX, 300, MEASURED)
    samples = compiled_run(
        classical(classical_kernels.PD, 1000.0, 100.0), HELIX, 300, MEASURED, resolution=1e-4
    )[1]
    np.testing.assert_array_equal(samples[:, :9], expected)


def test_a_delay_beyond_the_end_holds_the_first_force() -> None:
    samples = compiled_run(classical(classical_kernels.PD, 1000.0, 100.0), HELIX, 50, delay=10**9)[
        1
    ]
    np.testing.assert_array_equal(samples[:, 6:9], np.tile(samples[0, 6:9], (51, 1)))


# How runs end


def test_a_run_ends_where_the_robot_leaves_its_poses() -> None:
    """A gain of 1e8 N/m makes forces of 1e4 N of a tenth of a millimeter.

    The loop is unstable at this period.
    """
    done, samples = compiled_run(classical(classical_kernels.PD, 1e8, 0.0), HELIX, 100, MEASURED)
    assert 1 <= done < 101
    assert np.isfinite(samples[:done]).all()
    assert np.isnan(samples[done:]).all()


def test_a_run_ends_where_the_force_is_not_finite() -> None:
    """A measurement that is no pose of the machine leaves the exact model without an answer.

    The sample does not count.
    """
    measured = np.zeros((101, 6))
    measured[40, 1:3] = 1.0, -1.0
    done, samples = compiled_run(classical(classical_kernels.COMPUTED_TORQUE), HELIX, 100, measured)
    assert done == 40
    assert np.isnan(samples[40, 6:9]).all()
    assert np.isnan(samples[41:]).all()


def test_a_run_of_one_sample_only_asks_for_a_force() -> None:
    done, samples = compiled_run(classical(classical_kernels.COMPUTED_TORQUE), HELIX, 0)
    expected = psp3.ComputedTorque(ROBOT).torque(0.0, HELIX(0.0).heights, np.zeros(3), HELIX(0.0))
    assert done == 1
    np.testing.assert_allclose(samples[0, 6:9], expected, rtol=1e-13)


# Whole simulations: the loop is chosen, and nothing but the time that it takes changes


FIVE_BAR = psp3.load("five_bar")
SWING = FourierSeries(
    FIVE_BAR.reference, np.full((1, 2), 0.05), np.full((1, 2), 0.05), 1.0, FIVE_BAR
)


def of(robot: Any) -> dict[str, Any]:
    """All controllers that any robot can have."""
    n, scale = len(robot.actuated), 1.0 if robot is ROBOT else 0.003
    weights = np.diag(np.repeat([1e4, 1e2], n)), np.eye(n)
    motion = HELIX if robot is ROBOT else SWING
    return {
        "feed-forward": psp3.FeedForward(robot),
        "pd": psp3.PD(1000.0 * scale, 100.0 * scale),
        "pd, matrices": psp3.PD(
            scale * (1000.0 * np.eye(n) + 50.0), scale * (100.0 * np.eye(n) + 5.0)
        ),
        "pd-gravity": psp3.GravityCompensatedPD(robot, 1000.0 * scale, 100.0 * scale),
        "pid": psp3.PID(1000.0 * scale, 100.0 * scale, 300.0 * scale),
        "ctc": psp3.ComputedTorque(robot, 100.0, 20.0),
        "lqr": psp3.LinearQuadraticRegulator(robot, *weights),
        "time-varying lqr": TimeVaryingLinearQuadraticRegulator(robot, motion, 0.3, *weights),
    }


WIRED: dict[str, dict[str, Any]] = {
    "plain": {},
    "all": {"encoder_resolution": 5e-6, "delay": 2, "torque_limit": 90.0},
}


def outcome(*arguments: Any, **options: Any) -> tuple[str, psp3.Result]:
    """Return what is said at the end, and what happened until then."""
    try:
        return "", psp3.simulate(*arguments, **options)
    except SimulationDiverged as ended:
        return str(ended), cast("psp3.Result", ended.result)


@pytest.mark.parametrize("wires", WIRED)
@pytest.mark.parametrize("drive", [NO_DRIVE, Drive(0.005, 0.1)], ids=["free", "driven"])
@pytest.mark.parametrize("name", of(ROBOT))
@pytest.mark.parametrize("robot", [ROBOT, FIVE_BAR], ids=["psp3", "five_bar"])
def test_both_loops_agree(robot: Any, name: str, drive: Drive, wires: str) -> None:
    """Bit for bit, but where matrices multiply.

    Those are summed in another order, 1e-9 after 150 periods; encoders would make a count of that
    now and then, so that matrices are compared without. The five-bar is thrown about by some.
    """
    controller, motion = of(robot)[name], HELIX if robot is ROBOT else SWING
    is_product, options = name in ("pd, matrices", "lqr", "time-varying lqr"), dict(WIRED[wires])
    if is_product:
        options.pop("encoder_resolution", None)
    if "torque_limit" in options:
        options["torque_limit"] = 90.0 if robot is ROBOT else 0.25
    plants = RungeKutta(robot, 2, drive), InPython(robot, 2, drive)
    (said, compiled), (said_too, python) = (
        outcome(robot, controller, motion, 0.3, plant=plant, **options) for plant in plants
    )
    assert controller.table(robot.compiled_table(), widths_of(robot)) is not None
    assert len(compiled.t) == len(python.t) > 20
    if not is_product:
        assert said == said_too
    for field in ("positions", "speeds", "torque"):
        one, other = getattr(compiled, field), getattr(python, field)
        assert np.abs(one).max() > 0.0
        if is_product:
            np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9)
        else:
            np.testing.assert_array_equal(one, other)


def test_a_controller_is_afterwards_as_after_the_loop_in_python(
    trained: dict[str, FuzzyComputedTorque],
) -> None:
    """Of the integral and the last step, which a next call goes on from."""
    desired = HELIX(0.102)
    for controller in (psp3.PID(), trained["it2"], psp3.AdaptiveFuzzyComputedTorque(trained["t1"])):
        next_forces = []
        for plant in (RungeKutta(ROBOT), InPython(ROBOT)):
            psp3.simulate(ROBOT, controller, HELIX, 0.1, plant=plant)
            said = [getattr(controller, name, None) for name in ("covered", "torque_interval")]
            force = controller.torque(0.102, desired.heights - 1e-3, desired.speeds, desired)
            next_forces.append((force, said))
        np.testing.assert_array_equal(next_forces[0][0], next_forces[1][0])
        for one, other in zip(next_forces[0][1], next_forces[1][1], strict=True):
            np.testing.assert_array_equal(one, other)


class Stiffer(psp3.PD):
    """What a user makes of a controller."""

    def torque(self, t: float, positions: Any, speeds: Any, desired: Motion) -> np.ndarray:
        """Return twice the force."""
        return 2.0 * super().torque(t, positions, speeds, desired)


def test_a_class_of_a_users_own_is_asked_itself() -> None:
    twice = psp3.simulate(ROBOT, Stiffer(500.0, 50.0), HELIX, 0.1)
    expected = psp3.simulate(ROBOT, psp3.PD(1000.0, 100.0), HELIX, 0.1)
    np.testing.assert_array_equal(twice.torque, expected.torque)
    assert Stiffer().table(ROBOT.compiled_table(), widths_of(ROBOT)) is None


def test_progress_is_told_at_every_hundredth() -> None:
    for steps in (7, 100, 1000, 30_000):
        told: list[list[float]] = [[], []]
        for plant, times in zip((RungeKutta(ROBOT), InPython(ROBOT)), told, strict=True):
            if steps <= 1000 or type(plant) is RungeKutta:
                psp3.simulate(
                    ROBOT,
                    psp3.GravityCompensatedPD(ROBOT),
                    psp3.trajectories.Hold(robot=ROBOT),
                    0.002 * steps,
                    plant=plant,
                    progress=times.append,
                )
        assert len(told[0]) == min(steps, 100)
        assert told[0][-1] == pytest.approx(0.002 * steps)
        assert told[1] in ([], told[0])


def test_the_compiled_loop_returns_to_python_between_pieces(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """So that Ctrl-C ends it: here by an interrupt after the third of pieces of 100 samples.

    Pieces take some milliseconds of this robot, and no piece changes a bit.
    """
    run, pieces = loop_kernels.run, []

    def counted(*arguments: Any) -> int:
        pieces.append(arguments[-3:-1])
        if len(pieces) == stop:
            raise KeyboardInterrupt
        return int(run(*arguments))

    controller, stop = psp3.ComputedTorque(ROBOT), 0
    whole = psp3.simulate(ROBOT, controller, HELIX, 1.0)
    monkeypatch.setattr(loop_kernels, "run", counted)
    monkeypatch.setattr("psp3.simulation.loop.CHUNK", 300)
    parts = psp3.simulate(ROBOT, controller, HELIX, 1.0)
    assert pieces == [(k, min(k + 100, 501)) for k in range(0, 501, 100)]
    np.testing.assert_array_equal(parts.positions, whole.positions)
    pieces, stop = [], 3
    with pytest.raises(KeyboardInterrupt):
        psp3.simulate(ROBOT, controller, HELIX, 1.0)
