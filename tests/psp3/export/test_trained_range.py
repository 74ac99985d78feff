"""Whether rules fire everywhere, against the inside of the range and against rules that do not."""

from __future__ import annotations

import numpy as np
import pytest

import psp3
from psp3.export.face import c_code
from psp3.export.trained_range import HELD, fires_everywhere
from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
from psp3.trajectories import Helix

ROBOT = psp3.load("psp3")


@pytest.fixture(scope="module", params=["t1", "it2", "gt2"])
def trained(request: pytest.FixtureRequest) -> FuzzyComputedTorque:
    controller = FuzzyComputedTorque(request.param, ROBOT, snr_db=20.0)
    return controller.fit(Helix(robot=ROBOT), 1.0, rng=np.random.default_rng(1))


def test_where_it_says_so_no_input_in_the_range_is_lost(trained: FuzzyComputedTorque) -> None:
    """A rule that fires in all corners fires at a thousand places between them."""
    assert fires_everywhere(trained.controller)
    low, high = trained.ranges_
    inside = np.random.default_rng(0).uniform(low, high, (1000, low.size))
    strengths = np.asarray(trained.systems_[0].firing(inside))
    assert strengths.reshape(1000, -1).max(axis=1).min() > HELD
    code = c_code(trained).source
    assert " log(" not in code
    assert "(log(" not in code


def test_rules_that_are_too_narrow_for_the_range_are_told(trained: FuzzyComputedTorque) -> None:
    """Five hundred times the range: the Gaussians vanish there, and logarithms are needed."""
    low, high = trained.ranges_
    wide = np.stack([low - 500.0 * (high - low), high + 500.0 * (high - low)])
    assert not fires_everywhere(trained.controller._replace(ranges=wide))
