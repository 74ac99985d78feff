"""Linkages whose loops can be closed by hand."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pinocchio as pin

from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.helpers import Array


def away(parts: SimpleNamespace, rng: np.random.Generator) -> Array:
    """Return a configuration that leaves the loops open."""
    moved: Array = pin.integrate(parts.model, parts.q0, rng.uniform(-0.3, 0.3, parts.model.nv))
    return moved


def five_bar(base: float = 0.3, near: float = 0.25, far: float = 0.35) -> ClosedLoopRobot:
    """Two legs in the plane, joined at a point."""
    model = pin.Model()
    loops, tips = pin.StdVec_RigidConstraintModel(), []
    for leg, x in enumerate((0.0, base)):
        shoulder = model.addJoint(
            0, pin.JointModelRZ(), pin.SE3(np.eye(3), np.array([x, 0.0, 0.0])), f"shoulder{leg}"
        )
        elbow = model.addJoint(
            shoulder,
            pin.JointModelRZ(),
            pin.SE3(np.eye(3), np.array([near, 0.0, 0.0])),
            f"elbow{leg}",
        )
        for joint in (shoulder, elbow):
            model.appendBodyToJoint(
                joint,
                pin.Inertia(1.0, np.array([0.1, 0.0, 0.0]), 0.01 * np.eye(3)),
                pin.SE3.Identity(),
            )
        tips.append((elbow, pin.SE3(np.eye(3), np.array([far, 0.0, 0.0]))))
    loops.append(
        pin.RigidConstraintModel(
            pin.ContactType.CONTACT_3D, model, *tips[0], *tips[1], pin.ReferenceFrame.LOCAL
        )
    )
    return ClosedLoopRobot(
        model, loops, ("shoulder0", "shoulder1"), np.array([2.3, -1.4, 0.8, 1.4])
    )
