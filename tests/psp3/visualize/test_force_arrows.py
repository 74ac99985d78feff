"""Arrows on the screws: their scale, and that they sit on the screws of the URDF."""

from __future__ import annotations

import coal
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import psp3
from psp3.three_psp.robot import SCREW_IN_NUT
from psp3.visualize.force_arrows import HEAD_LENGTH, LONGEST, ForceArrow, newtons_per_decimeter
from psp3.visualize.shapes import meshcat

ROBOT = psp3.load()


@given(largest=st.floats(1e-6, 1e9))
def test_the_scale_is_round_and_the_longest_arrow_fits(largest: float) -> None:
    """A finer round scale would not fit; rel 1e-9 is rounding."""
    newtons = newtons_per_decimeter(largest)
    mantissa = newtons / 10.0 ** np.floor(np.log10(newtons * (1.0 + 1e-9)))
    assert min(abs(mantissa - step) for step in (1.0, 2.0, 5.0)) < 1e-9 * mantissa
    longest = 0.1 * largest / newtons
    assert longest <= LONGEST * (1.0 + 1e-9)
    assert 2.5 * longest >= LONGEST * (1.0 - 1e-9)


def test_nothing_to_show_has_a_scale_too() -> None:
    assert newtons_per_decimeter(0.0) > 0.0


def test_arrows_are_on_the_axes_of_the_screws() -> None:
    """Screws are the thinner of the two long cylinders of a column; the file has six decimals."""
    screws = [
        shape
        for shape in ROBOT.visual_model.geometryObjects
        if shape.parentJoint == 0
        and isinstance(shape.geometry, coal.Cylinder)
        and shape.geometry.halfLength > 0.4
        and shape.geometry.radius < 0.01
    ]
    assert len(screws) == 3
    for name, screw in zip(ROBOT.actuated, screws, strict=True):
        on_base = ROBOT.model.jointPlacements[ROBOT.model.getJointId(name)].act(SCREW_IN_NUT)
        np.testing.assert_allclose(on_base[:2], screw.placement.translation[:2], atol=1e-6)


class Recorder:
    """Stands for MeshCat's server and keeps the placements."""

    def __init__(self) -> None:
        self.matrices: dict[str, np.ndarray] = {}

    def send(self, command: object) -> None:
        """Take one of MeshCat's commands."""
        content = command.lower()  # type: ignore[attr-defined]
        if content["type"] == "set_transform":
            self.matrices[content["path"]] = np.reshape(content["matrix"], (4, 4)).T


@pytest.mark.parametrize("length", [0.2, HEAD_LENGTH, 0.01, 0.0, -0.01, -0.2])
def test_an_arrow_is_as_long_as_it_should_be_up_or_down(length: float) -> None:
    """From where it starts to its point.

    It starts at the end of the nut that the force pushes from. 2e-4 m replaces a length of zero.
    """
    recorder = Recorder()
    parts = ForceArrow(
        meshcat.Visualizer(window=recorder)["nut"], SCREW_IN_NUT, np.array([0.0, 0.0, 1.0])
    ).place(np.full(2, length), np.array([0.0, 1.0]))
    assert all(part["clip"]["tracks"] == [] for part in parts)
    head, shaft = (
        next(matrix for path, matrix in recorder.matrices.items() if path.endswith(name))
        for name in ("head", "shaft")
    )
    point, start = (head @ [0.0, 0.0, HEAD_LENGTH, 1.0])[2], shaft[2, 3]
    assert point - start == pytest.approx(length, abs=2e-4)
    assert start == pytest.approx(0.044 * np.clip(length / HEAD_LENGTH, -1.0, 1.0), abs=1e-5)
    assert all(np.linalg.det(matrix) > 0.0 for matrix in (head, shaft))
