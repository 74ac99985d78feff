"""Linkages of which several loops share what moves them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin

from tests.helpers import Array


def rockers(count: int) -> tuple[pin.Model, Any, Array]:
    """Return rockers that one crank drives, in planes of their own, and a closed configuration.

    Joints are the crank, then the couplers, then the rockers.
    """
    model, loops = pin.Model(), pin.StdVec_RigidConstraintModel()
    body = pin.Inertia(1.0, np.array([0.1, 0.0, 0.0]), 0.01 * np.eye(3))

    def hinge(parent: int, x: float, z: float, name: str) -> int:
        joint: int = model.addJoint(
            parent, pin.JointModelRZ(), pin.SE3(np.eye(3), np.array([x, 0.0, z])), name
        )
        model.appendBodyToJoint(joint, body, pin.SE3.Identity())
        return joint

    crank = hinge(0, 0.0, 0.0, "crank")
    couplers = [hinge(crank, 0.2, 0.1 * k, f"coupler{k}") for k in range(count)]
    rockers = [hinge(0, 0.45, 0.1 * k, f"rocker{k}") for k in range(count)]
    for coupler, rocker in zip(couplers, rockers, strict=True):
        ends = [pin.SE3(np.eye(3), np.array([x, 0.0, 0.0])) for x in (0.5, 0.4)]
        loops.append(
            pin.RigidConstraintModel(
                pin.ContactType.CONTACT_3D,
                model,
                coupler,
                ends[0],
                rocker,
                ends[1],
                pin.ReferenceFrame.LOCAL,
            )
        )
    return model, loops, np.array([1.0] + count * [-0.55] + count * [1.3])
