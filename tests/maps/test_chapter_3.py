"""What the map of chapter 3 says beside its rows."""

from __future__ import annotations

import numpy as np
import pytest

import psp3
from tests.helpers import thesis_chain


def test_the_cayley_form_nears_its_singularity() -> None:
    """Determinant of 1 + R of the tip's frame, by the printed chain of the first arm.

    2 at home, and falling with the tilt.
    """
    robot = psp3.load("psp3")
    order = [
        robot.model.joints[robot.model.getJointId(f"{joint}1")].idx_q
        for joint in ("a", "phi", "theta", "lambda", "b")
    ]
    determinants = []
    for difference in (0.0, 0.15, 0.5):
        shapes = difference * np.array(
            [
                [0.0, 1.0, 0.0],
                [0.0, -1.0, 0.0],
                [1.0, 0.0, 0.0],
                [-1.0, 0.0, 0.0],
                [0.0, 0.0, 1.0],
                [0.0, 0.0, -1.0],
            ]
        )
        chains = [
            thesis_chain(0, robot.configuration(heights)[order], 0.181, 0.070) for heights in shapes
        ]
        determinants.append(min(np.linalg.det(np.eye(3) + chain[:3, :3]) for chain in chains))
    assert determinants[0] == pytest.approx(2.0, abs=1e-12)
    assert determinants[0] > determinants[1] > determinants[2] > 0.0
    assert determinants[2] < 0.1
