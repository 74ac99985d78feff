"""Closures that Pinocchio has no model of: what they are called, and that they can be kept."""

from __future__ import annotations

import pickle

import numpy as np
import pinocchio as pin

from psp3.closure.structure import closure_names
from psp3.multibody.equations import Coupling, Hinge, Spin


def test_closures_are_called_by_their_names_or_numbers() -> None:
    hinge = Hinge("a-b", 1, pin.SE3.Identity(), 2, pin.SE3.Identity())
    coupling = Coupling("", 2, 1, (0.0, 1.0))
    assert closure_names([hinge, coupling]) == ["a-b", "loop 2"]


def test_they_can_be_pickled() -> None:
    for one in (
        Hinge("a-b", 1, pin.SE3.Random(), 2, pin.SE3.Random()),
        Coupling("c", 2, 1, (0.0, 1.0)),
        Spin("s", 1, np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, 0.0, 1.0])),
    ):
        again = pickle.loads(pickle.dumps(one))
        assert str(again) == str(one)
