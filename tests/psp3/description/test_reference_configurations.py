"""Poses of a model: what is set is there, is a copy, and leaves nothing behind."""

from __future__ import annotations

import sys

import numpy as np
import pinocchio as pin

from psp3.description.reference_configurations import set_reference_configuration


def test_a_pose_is_set_and_set_again_and_apart_from_others() -> None:
    model = pin.buildSampleModelManipulator()
    first, second = np.arange(6.0), np.arange(6.0) + 10.0
    set_reference_configuration(model, "home", first)
    set_reference_configuration(model, "up", second)
    np.testing.assert_array_equal(model.referenceConfigurations["home"], np.arange(6.0))
    np.testing.assert_array_equal(model.referenceConfigurations["up"], second)
    set_reference_configuration(model, "home", second)
    np.testing.assert_array_equal(model.referenceConfigurations["home"], second)
    second[:] = 0.0
    assert model.referenceConfigurations["up"][0] == 10.0


def test_the_array_is_free_afterwards() -> None:
    """Pinocchio's own assignment keeps it for ever."""
    model, pose = pin.buildSampleModelManipulator(), np.zeros(6)
    before = sys.getrefcount(pose)
    for _ in range(10):
        set_reference_configuration(model, "home", pose)
    assert sys.getrefcount(pose) == before
