"""Arrows on sliding motors, such as the screws of the 3-PSP: the force of each, to scale."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin

from psp3.checks import Array
from psp3.visualize.animation import clip
from psp3.visualize.shapes import Column, Satin, meshcat, rgb

FORCE_COLOR = "#5f3dc4"

CLEARANCE = 0.044
"""Distance of an arrow's start, the end of the nut, above or below the nut's middle [m]."""

HEAD_LENGTH, HEAD_RADIUS, SHAFT_RADIUS = 0.045, 0.026, 0.0125
"""Sizes of an arrow [m]; an arrow shorter than its head gets a smaller head."""

LONGEST = 0.25
"""Greatest length of an arrow [m]."""

_NO_LENGTH = 1e-4
"""Replaces a length of zero, for which the matrix would be singular."""


def newtons_per_decimeter(largest: float) -> float:
    """Return a round scale, 1, 2 or 5 times a power of ten, at which the largest force fits [N]."""
    least = max(largest, 1e-9) * 0.1 / LONGEST
    power = 10.0 ** np.floor(np.log10(least))
    return float(
        next(
            step * power for step in (1.0, 2.0, 5.0, 10.0) if step * power >= least * (1.0 - 1e-12)
        )
    )


class ForceArrow:
    """An arrow on a sliding motor that shows the size and the sign of its force.

    Parameters
    ----------
    slider : meshcat.Visualizer
        Node of the joint, which carries the arrow.
    origin : (3,) ndarray
        Point where the force acts, in the axes of the joint [m].
    axis : (3,) ndarray
        Direction of a positive force, in the axes of the joint.
    """

    def __init__(self, slider: meshcat.Visualizer, origin: Array, axis: Array) -> None:
        self._shaft, self._head = slider["force/shaft"], slider["force/head"]
        # Drawn along z, and rotated if the motor pushes in another direction.
        turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), axis).toRotationMatrix()
        self._origin = turn.T @ origin
        if not np.array_equal(axis, [0.0, 0.0, 1.0]):
            slider["force"].set_transform(pin.SE3(turn, np.zeros(3)).homogeneous)
        self._shaft.set_object(Column(1.0, SHAFT_RADIUS), Satin(rgb(FORCE_COLOR)))
        self._head.set_object(Column(HEAD_LENGTH, HEAD_RADIUS, 0.0), Satin(rgb(FORCE_COLOR)))

    def place(self, lengths: Array, seconds: Array) -> list[dict[str, Any]]:
        """Set the arrow to the first of its lengths, (n,) [m], negative downward.

        Return its animation through all lengths.
        """
        size = np.maximum(np.minimum(np.abs(lengths) / HEAD_LENGTH, 1.0), _NO_LENGTH)
        reach = np.maximum(np.abs(lengths) - size * HEAD_LENGTH, _NO_LENGTH)
        # A downward arrow is an upward one rotated about x, because three.js decomposes a matrix
        # with negative scales into a wrong rotation.
        down = lengths < 0.0
        turn = np.where(down[:, None], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0])
        # The arrow moves from the upper end of the nut to the lower one while the force changes
        # sign.
        start = CLEARANCE * np.clip(lengths / HEAD_LENGTH, -1.0, 1.0)
        parts = []
        for node, base, scale in (
            (
                self._shaft,
                start,
                np.stack([np.ones_like(reach), np.ones_like(reach), reach], axis=-1),
            ),
            (
                self._head,
                start + np.where(down, -reach, reach),
                np.repeat(size[:, None], 3, axis=-1),
            ),
        ):
            position = self._origin + base[:, None] * np.array([0.0, 0.0, 1.0])
            placement = np.diag([*scale[0], 1.0])
            if down[0]:
                placement[1:3] *= -1.0
            placement[:3, 3] = position[0]
            node.set_transform(placement)
            parts.append(
                clip(
                    node.path.lower(),
                    seconds,
                    {"position": position, "quaternion": turn, "scale": scale},
                )
            )
        return parts
