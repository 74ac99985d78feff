"""Records against differences by hand, Pinocchio's dynamics and a brute-force choice of samples."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import psp3
from psp3.errors import InvalidArray, InvalidValue, UnknownName
from psp3.fuzzy_control.records import (
    INPUT_NAMES,
    OUTPUT_NAMES,
    Record,
    RecordNoise,
    differences,
    pack,
    record,
    unpack,
)
from psp3.trajectories import Helix, Hold, Line
from tests.helpers import random_states

ROBOT = psp3.load("psp3")


@pytest.fixture(scope="module")
def helix() -> Record:
    return record(ROBOT, Helix(robot=ROBOT))


def made_up(inputs: np.ndarray) -> Record:
    """Return a record of given inputs; nothing else of it matters for the choice of samples."""
    count = len(inputs)
    return Record(
        np.arange(count) * 0.002,
        np.zeros((count, 3)),
        np.zeros((count, 3)),
        inputs,
        np.ones((count, 18)),
    )


def test_differences_by_hand() -> None:
    found = differences([0.3, 0.1, -0.2], [1.0, 4.0, -2.0])
    np.testing.assert_allclose(found, [0.2, 0.5, -3.0, 3.0], rtol=1e-15)
    assert INPUT_NAMES == ("Δq12", "Δq13", "Δq̇12", "Δq̇13")
    assert differences(np.zeros((4, 5, 3)), np.zeros((4, 5, 3))).shape == (4, 5, 4)


@pytest.mark.parametrize(
    ("heights", "speeds"),
    [([0.0, 1.0], [0.0, 0.0, 0.0]), ([0.0] * 3, [0.0, np.nan, 0.0]), ("abc", [0.0] * 3)],
)
def test_differences_refuse_what_is_not_three_finite_numbers(
    heights: object, speeds: object
) -> None:
    with pytest.raises(InvalidArray):
        differences(heights, speeds)  # type: ignore[arg-type]


def test_four_differences_decide_the_dynamics() -> None:
    """Heights are 0.4 m, speeds 1 m/s.

    Lifting all by 0.3 m and 2 m/s rounds differences by 1e-16 of these, and 1e-12 covers that.

    Pinocchio's model, which knows nothing of differences, says the same to 1e-9, the bar between
    the two models.
    """
    rng = np.random.default_rng(0)
    heights, speeds = random_states(rng, 200, largest_difference=0.15)
    before = pack(*ROBOT.equation_of_motion(heights, speeds))
    after = pack(*ROBOT.equation_of_motion(heights + 0.3, speeds + 2.0))
    np.testing.assert_allclose(after, before, rtol=0.0, atol=1e-12 * np.abs(before).max())
    pinocchio = ROBOT.dynamics("pinocchio")
    for a, v, expected in zip(heights[:3], speeds[:3], after, strict=False):
        np.testing.assert_allclose(
            pack(*pinocchio.equation_of_motion(a, v)), expected, rtol=1e-9, atol=1e-9
        )


def test_packing_is_in_the_order_of_the_names() -> None:
    M, C, G = ROBOT.equation_of_motion([0.1, 0.0, -0.05], [1.0, -2.0, 0.5])
    elements = {"M": M, "C": C, "G": G}
    expected = [
        elements[name[0]][tuple(int(index) - 1 for index in name[1:])] for name in OUTPUT_NAMES
    ]
    np.testing.assert_array_equal(pack(M, C, G), expected)
    assert len(OUTPUT_NAMES) == 18


@given(arrays(np.float64, (2, 3, 18), elements=st.floats(-1e9, 1e9)))
def test_unpacking_makes_m_symmetric_and_packing_undoes_it(outputs: np.ndarray) -> None:
    M, C, G = unpack(outputs)
    np.testing.assert_array_equal(M, M.swapaxes(-1, -2))
    np.testing.assert_array_equal(pack(M, C, G), outputs)


def test_the_record_is_the_crisp_run(helix: Record) -> None:
    """The run itself.

    And M, C and G of Pinocchio at a few of its samples to 1e-9, the bar between the two models.
    """
    run = psp3.simulate(ROBOT, psp3.ComputedTorque(ROBOT), Helix(robot=ROBOT), 10.4)
    for name in ("t", "heights", "speeds"):
        np.testing.assert_array_equal(getattr(helix, name), getattr(run, name))
    pinocchio = ROBOT.dynamics("pinocchio")
    for k in (0, 700, 5200):
        np.testing.assert_allclose(
            helix.outputs[k],
            pack(*pinocchio.equation_of_motion(run.heights[k], run.speeds[k])),
            rtol=1e-9,
            atol=1e-9,
        )
        a, v = run.heights[k], run.speeds[k]
        np.testing.assert_array_equal(
            helix.inputs[k], [a[0] - a[1], a[0] - a[2], v[0] - v[1], v[0] - v[2]]
        )
    assert helix.inputs.shape == (5201, 4)
    np.testing.assert_allclose(
        helix.rms, [np.sqrt(sum(column**2) / 5201) for column in helix.outputs.T], rtol=1e-12
    )


@pytest.mark.parametrize("reference", ["mean-square", "variance", "unit"])
def test_amplitudes_are_those_of_plain_sums(helix: Record, reference: str) -> None:
    """Of a few columns, in loops: the mean square, less that of the mean, or one."""
    found = RecordNoise(reference).output_amplitudes(helix)
    for column in (0, 1, 7, 15):
        values = helix.outputs[:, column].tolist()
        mean = sum(values) / len(values)
        expected = {
            "mean-square": sum(value * value for value in values) / len(values),
            "variance": sum((value - mean) ** 2 for value in values) / len(values),
            "unit": 1.0,
        }[reference]
        assert found[column] ** 2 == pytest.approx(expected, rel=1e-9)


def test_noise_on_gravity_is_far_greater_than_what_gravity_varies_by(helix: Record) -> None:
    """The numbers of the argument in the report.

    At 20 dB a tenth of the root mean square, 8.7 N, where the entry varies by 0.6 N.
    """
    noise, varies = (
        RecordNoise(name).output_amplitudes(helix) for name in ("mean-square", "variance")
    )
    np.testing.assert_allclose(0.1 * noise[15:], 8.7, atol=0.1)
    np.testing.assert_allclose(varies[15:], 0.6, atol=0.1)


@pytest.mark.parametrize(
    ("entries", "noisy"), [("all", "MCG"), ("gravity", "G"), ("mass-coriolis", "MC")]
)
def test_only_the_chosen_entries_are_noisy_and_always_with_the_same_noise(
    helix: Record, entries: str, noisy: str
) -> None:
    """Against the generator's numbers, times amplitudes worked out here."""
    chosen = helix.sample(50)
    inputs, outputs = RecordNoise(entries=entries).added(
        helix, chosen, 14.0, np.random.default_rng(3)
    )
    np.testing.assert_array_equal(inputs, helix.inputs[chosen])
    draws = np.random.default_rng(3).standard_normal((50, 18))
    amplitude = np.sqrt((helix.outputs**2).mean(axis=0)) * 10.0**-0.7
    for column, name in enumerate(OUTPUT_NAMES):
        error = outputs[:, column] - helix.outputs[chosen, column]
        expected = amplitude[column] * draws[:, column] * (name[0] in noisy)
        np.testing.assert_allclose(error, expected, rtol=1e-9, atol=1e-12)


def test_noise_of_inputs_leaves_the_outputs_alone(helix: Record) -> None:
    chosen = helix.sample(50)
    inputs, outputs = RecordNoise("variance", of_inputs=True).added(
        helix, chosen, 20.0, np.random.default_rng(3)
    )
    np.testing.assert_array_equal(outputs, helix.outputs[chosen])
    draws = np.random.default_rng(3).standard_normal((50, 4))
    np.testing.assert_allclose(
        inputs - helix.inputs[chosen], 0.1 * helix.inputs.std(axis=0) * draws, rtol=1e-9
    )


@pytest.mark.parametrize("wrong", [{"reference": "power"}, {"entries": "M"}, {"entries": None}])
def test_noise_of_unknown_names_is_refused(wrong: dict[str, str]) -> None:
    with pytest.raises(UnknownName, match="known are"):
        RecordNoise(**wrong)


def test_gains_of_the_recording_matter() -> None:
    """Started at rest, the error is that of the servo: a stiffer one leaves less of it."""
    errors = []
    for kp, kv in ((10.0, 1.0), (400.0, 40.0)):
        run = record(ROBOT, Helix(robot=ROBOT), 2.0, kp=kp, kv=kv)
        errors.append(np.abs(Helix(robot=ROBOT)(run.t).heights - run.heights).max())
    assert errors[1] < 0.2 * errors[0]


def farthest_points(inputs: np.ndarray, count: int) -> list[int]:
    """Choose by brute force: all distances of all points to all chosen ones, anew in every step."""
    shares = (inputs - inputs.min(axis=0)) / (inputs.max(axis=0) - inputs.min(axis=0))
    from_middle = [sum((share - 0.5) ** 2 for share in row) for row in shares]
    chosen = [from_middle.index(max(from_middle))]
    while len(chosen) < count:
        holes = [
            min(sum((a - b) ** 2 for a, b in zip(row, shares[k], strict=True)) for k in chosen)
            for row in shares
        ]
        chosen.append(holes.index(max(holes)))
    return chosen


@given(st.integers(0, 10_000), st.integers(2, 12))
def test_samples_are_those_of_the_brute_force_choice(seed: int, count: int) -> None:
    """Random points have no ties, so rounding cannot change the choice."""
    inputs = np.random.default_rng(seed).normal(size=(25, 4)) * [1.0, 1e-3, 1e3, 7.0]
    found = made_up(inputs).sample(count)
    assert found.tolist() == sorted(farthest_points(inputs, count))
    assert len(set(found.tolist())) == count


def largest_hole(inputs: np.ndarray, chosen: np.ndarray) -> float:
    shares = (inputs - inputs.min(axis=0)) / np.ptp(inputs, axis=0)
    distances = np.linalg.norm(shares[:, np.newaxis] - shares[chosen], axis=2)
    return float(distances.min(axis=1).max())


def test_samples_cover_the_record_evenly(helix: Record) -> None:
    """No point of the record is as far from a sample as with samples chosen at random or one in 25.

    Less than half of it.
    """
    hole = largest_hole(helix.inputs, helix.sample(209))
    rng = np.random.default_rng(1)
    assert all(
        hole < 0.5 * largest_hole(helix.inputs, rng.choice(5201, 209, replace=False))
        for _ in range(5)
    )
    assert hole < 0.5 * largest_hole(helix.inputs, np.arange(209) * 25)


def test_more_samples_go_on_from_fewer_and_reach_the_ends_of_the_ranges(helix: Record) -> None:
    """Each input's own extremes lie within the largest hole of a sample.

    That is a few hundredths of the range.
    """
    few, many = helix.sample(50), helix.sample(209)
    assert set(few.tolist()) <= set(many.tolist())
    span = np.ptp(helix.inputs, axis=0)
    chosen = helix.inputs[many]
    hole = largest_hole(helix.inputs, many)
    assert hole < 0.06
    assert ((helix.inputs.max(axis=0) - chosen.max(axis=0)) / span <= hole).all()
    assert ((chosen.min(axis=0) - helix.inputs.min(axis=0)) / span <= hole).all()


def test_samples_can_be_spoiled_without_spoiling_the_next(helix: Record) -> None:
    first = helix.sample(20)
    first[:] = 0
    assert len(set(helix.sample(20).tolist())) == 20


@pytest.mark.parametrize(
    "count", [1, 0, -3, 5202, 10**9, 2.5, 209.0, True, "209", None, np.nan, np.inf, [3]]
)
def test_other_counts_are_refused(helix: Record, count: object) -> None:
    with pytest.raises(InvalidValue, match="whole number from 2 to 5201"):
        helix.sample(count)  # type: ignore[arg-type]


def test_the_whole_record_can_be_taken() -> None:
    inputs = np.random.default_rng(3).normal(size=(30, 4))
    np.testing.assert_array_equal(
        made_up(inputs).sample(np.int64(30)),  # type: ignore[arg-type]
        np.arange(30),
    )


def test_a_record_in_which_an_input_rests_is_refused() -> None:
    """Rising on its axis the star never tilts.

    So all four differences are rounding, 1e-17 m, and not exactly 0.
    """
    rising = record(ROBOT, Helix(radius=0.0, robot=ROBOT), 1.0)
    assert 0.0 < np.abs(rising.inputs).max() < 1e-12
    for still in (rising, record(ROBOT, Hold(robot=ROBOT), 1.0)):
        with pytest.raises(InvalidValue, match="every difference input changes") as caught:
            still.sample(20)
        assert caught.value.value == ", ".join(INPUT_NAMES)
    inputs = np.random.default_rng(0).normal(size=(30, 4)) * [1.0, 1.0, 1.0, 0.0]
    with pytest.raises(InvalidValue, match="Δq̇13") as caught:
        made_up(inputs).sample(20)
    assert caught.value.value == "Δq̇13"


def test_a_line_through_the_axis_still_tilts_the_star() -> None:
    """Its two height differences are equal, and yet each of them changes."""
    line = record(ROBOT, Line([0.0, 0.0, 0.07], [0.02, 0.0, 0.07], 2.0, ROBOT), 2.0)
    assert len(line.sample(20)) == 20
