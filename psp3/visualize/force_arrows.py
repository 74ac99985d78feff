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
"""An arrow starts where the nut ends, this far above or below the nut's middle [m]."""

HEAD_LENGTH, HEAD_RADIUS, SHAFT_RADIUS = 0.045, 0.026, 0.0125
"""Of an arrow [m]; the head of a force shorter than a head is smaller."""

LONGEST = 0.25
"""Length that no arrow exceeds [m]."""

_NO_LENGTH = 1e-4
"""In place of a length of zero, which no matrix with an inverse has."""


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
    """An arrow on a sliding motor, which grows with the force, one way or the other.

    Parameters
    ----------
    slider : meshcat.Visualizer
        Node of the joint, with which the arrow moves.
    origin : (3,) ndarray
        Where the force acts, in the axes of the joint [m].
    axis : (3,) ndarray
        Direction of a positive force, in the axes of the joint.
    """

    def __init__(self, slider: meshcat.Visualizer, origin: Array, axis: Array) -> None:
        self._shaft, self._head = slider["force/shaft"], slider["force/head"]
        # Drawn along z; turned where the motor pushes another way.
        turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), axis).toRotationMatrix()
        self._origin = turn.T @ origin
        if not np.array_equal(axis, [0.0, 0.0, 1.0]):
            slider["force"].set_transform(pin.SE3(turn, np.zeros(3)).homogeneous)
        self._shaft.set_object(Column(1.0, SHAFT_RADIUS), Satin(rgb(FORCE_COLOR)))
        self._head.set_object(Column(HEAD_LENGTH, HEAD_RADIUS, 0.0), Satin(rgb(FORCE_COLOR)))

    def place(self, lengths: Array, seconds: Array) -> list[dict[str, Any]]:
        """Put the arrow at the first of its lengths, (n,) [m], negative downward.

        Return its animation through all.
        """
        size = np.maximum(np.minimum(np.abs(lengths) / HEAD_LENGTH, 1.0), _NO_LENGTH)
        reach = np.maximum(np.abs(lengths) - size * HEAD_LENGTH, _NO_LENGTH)
        # Downward is upward turned around x: three.js takes a matrix with negative scales for
        # another rotation.
        down = lengths < 0.0
        turn = np.where(down[:, None], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0])
        # From the upper end of the nut to the lower one while the force changes its sign.
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
