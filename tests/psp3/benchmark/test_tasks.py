"""Tasks: what every entry is asked to do."""

from __future__ import annotations

import numpy as np
import pytest

from psp3.benchmark.tasks import PATHS, ROBOTS, SMALLER, task
from psp3.errors import UnknownName
from psp3.fuzzy_control.numbers import unpack


@pytest.mark.parametrize("name", ROBOTS)
def test_both_paths_are_within_reach_and_the_untrained_one_is_smaller_and_faster(name: str) -> None:
    of_robot = task(name)
    t = np.linspace(0.0, 5.0, 101)
    trained, untrained = (of_robot.paths[path].check(t) for path in PATHS)
    reach = np.ptp(trained.positions, axis=0), np.ptp(untrained.positions, axis=0)
    assert (reach[1] < reach[0]).all()
    assert of_robot.paths[PATHS[1]].period == pytest.approx(  # type: ignore[attr-defined]
        SMALLER * of_robot.paths[PATHS[0]].period  # type: ignore[attr-defined]
    )


def test_extent_of_a_helix_is_known() -> None:
    """Of 5 s: 2.5 turns and a rise of 50 mm, so that the ends lie across from each other.

    The tip's path is sampled every few degrees, which shortens the distance by less than 0.1 %.
    """
    extent = task("psp3").extent(PATHS[0], 5.0, 0.004)
    assert extent == pytest.approx(np.hypot(0.040, 0.050), rel=1e-3)


def test_a_task_is_made_once_and_unknown_ones_are_refused() -> None:
    assert task("delta") is task("delta")
    with pytest.raises(UnknownName, match="gough_stewart"):
        task("hexapod")


@pytest.mark.parametrize("name", ROBOTS)
def test_outputs_of_a_record_are_the_dynamics_at_its_inputs(name: str) -> None:
    """M a + C v + G of the recorded numbers against inverse dynamics, which is another route."""
    of_robot = task(name)
    recorded = of_robot.recorded
    chosen = recorded.sample(7)
    a, v = recorded.positions[chosen], recorded.speeds[chosen]
    np.testing.assert_array_equal(of_robot.inputs_of(a, v), recorded.inputs[chosen])
    M, C, G = unpack(recorded.outputs[chosen])
    acc = np.random.default_rng(0).standard_normal(a.shape)
    forces = (M @ acc[..., None] + C @ v[..., None])[..., 0] + G
    expected = of_robot.robot.inverse_dynamics(a, v, acc)
    np.testing.assert_allclose(forces, expected, rtol=1e-7, atol=1e-7 * np.abs(expected).max())
