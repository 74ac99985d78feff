"""The frames that Pinocchio's constraints join: how far apart, and how they come apart."""

from __future__ import annotations

import itertools

import numpy as np
import pinocchio as pin

from psp3.checks import Array
from psp3.dynamics.mechanism import Mechanism


class JoinedFrames:
    """The two frames of every loop: how far they are apart, and how they come apart."""

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
        """Return how the first frames accelerate against the second ones, (m,).

        In axes of the first, in the motion of the tree without weight that RNEA has just been asked
        for, which keeps the loops closed.
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
                # Both frames move as one, so that neither turns against the other.
                out[rows] = (one - state.c1Mc2.act(other)).vector
        return out
