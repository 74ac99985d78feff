"""The frames that Pinocchio's constraints join: their distance, and their relative acceleration."""

from __future__ import annotations

import itertools

import numpy as np
import pinocchio as pin

from psp3.checks import Array
from psp3.dynamics.mechanism import Mechanism


class JoinedFrames:
    """The two frames of every loop: their distance, and their relative acceleration."""

    def __init__(self, mechanism: Mechanism) -> None:
        ends = np.cumsum([0, *(int(loop.residualSize()) for loop in mechanism.loops)])
        self.rows = int(ends[-1])
        self._loops = [
            (
                slice(*rows),
                loop.type == pin.ContactType.CONTACT_3D,
                (loop.joint1_id, loop.joint1_placement),
                (loop.joint2_id, loop.joint2_placement),
            )
            for rows, loop in zip(itertools.pairwise(ends), mechanism.loops, strict=True)
        ]

    def opening(self, states: list[pin.RigidConstraintData]) -> Array:
        """Return the first frames' placements in the second ones, (m,), as small motions."""
        opening = np.empty(self.rows)
        for (rows, is_point, _, _), state in zip(self._loops, states, strict=True):
            relative = state.c1Mc2
            opening[rows] = relative.translation if is_point else pin.log6(relative).vector
        return -opening

    def accelerations(self, data: pin.Data, states: list[pin.RigidConstraintData]) -> Array:
        """Return the accelerations of the first frames relative to the second ones, (m,).

        They are in axes of the first frames. The motion is that of the last call of RNEA, without
        weight, which must keep the loops closed.
        """
        velocities, accelerations, out = data.v, data.a_gf, np.empty(self.rows)
        for (rows, is_point, *sides), state in zip(self._loops, states, strict=True):
            one, other = (placement.actInv(accelerations[joint]) for joint, placement in sides)
            if is_point:
                turning, turning_other = (
                    placement.actInv(velocities[joint]) for joint, placement in sides
                )
                there = pin.classicAcceleration(turning_other, other)
                here = pin.classicAcceleration(turning, one)
                out[rows] = here - state.c1Mc2.rotation @ there
            else:
                # Both frames move together, so they do not rotate relative to each other.
                out[rows] = (one - state.c1Mc2.act(other)).vector
        return out
