"""Type-1 with wider terms: the same rules, other terms, and at width 1 the very controller of the study."""

from __future__ import annotations

import numpy as np
import pytest

from psp3.errors import InvalidValue
from psp3.fuzzy_computed_torque import FuzzyComputedTorque
from psp3.loading import load
from psp3.records import record
from psp3.runs import Run, execute
from psp3.trajectories import Helix
from psp3.wider_terms import errors_by_seed, widened

ROBOT = load("psp3")
RECORD = record(ROBOT, Helix(robot=ROBOT), period=0.01)


def trained(kind: str = "t1") -> FuzzyComputedTorque:
    return FuzzyComputedTorque(kind, ROBOT, snr_db=20.0).learn(RECORD, rng=np.random.default_rng(3))


def test_width_one_is_the_run_of_the_study() -> None:
    """Bit for bit: the same rules, loop and measure. One seed of three diverges, and both say so."""
    run = Run("t1", snr_db=10.0)
    errors = errors_by_seed(ROBOT, run, 1.0, 3)
    expected = [execute(Run("t1", snr_db=10.0, seed=seed))["sum_of_squared_errors"] for seed in range(3)]
    np.testing.assert_array_equal(errors, expected)
    assert np.isnan(errors).any()
    assert not np.isnan(errors).all()


def test_wide_terms_estimate_the_average_over_the_rules_everywhere() -> None:
    """With terms a thousand ranges wide all rules fire alike; 1e-5 is what is left of their difference."""
    controller = widened(trained(), 1e3)
    outputs = np.asarray(controller.system_(RECORD.inputs[::50]))
    average = controller.system_.consequents.mean(axis=0)
    np.testing.assert_allclose(outputs, np.broadcast_to(average, outputs.shape), rtol=1e-4, atol=1e-4)
    np.testing.assert_array_equal(average, controller.fallback_)


def test_rules_and_range_stay_and_standard_deviations_grow() -> None:
    before, after = trained(), widened(trained(), 2.0)
    np.testing.assert_array_equal(after.system_.consequents, before.system_.consequents)
    np.testing.assert_array_equal(after.ranges_, before.ranges_)
    for old, new in zip(before.system_.inputs, after.system_.inputs, strict=True):
        for one, other in zip(old, new, strict=True):
            assert (other.mean, other.sigma) == (one.mean, 2.0 * one.sigma)


@pytest.mark.parametrize("width", [0.0, -1.0, np.inf, np.nan])
def test_widths_that_are_none(width: float) -> None:
    with pytest.raises(InvalidValue, match="width"):
        widened(trained(), width)


def test_other_kinds_are_refused() -> None:
    with pytest.raises(InvalidValue, match="of kind 't1'"):
        widened(trained("it2"), 2.0)
