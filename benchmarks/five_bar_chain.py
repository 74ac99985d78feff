"""Chains of planar five-bar linkages, each mounted on the tip of the one before.

They have any number of loops, to measure scaling.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

import psp3

BASE, NEAR, FAR = 0.3, 0.25, 0.35
"""Distance of the motors, and lengths of the links at the motors and at the tip [m]."""


def five_bar_chain(count: int) -> psp3.ClosedLoopRobot:
    """Return a robot of ``count`` five-bars in the vertical plane.

    It has 4 ``count`` joints, 2 ``count`` motors, and ``count`` loops closed at a point.
    """
    model, loops = pin.Model(), pin.StdVec_RigidConstraintModel()
    upright = pin.SE3(pin.utils.rotate("x", np.pi / 2.0), np.zeros(3))
    angles = dict(
        zip(("left", "right", "elbow_left", "elbow_right"), _closed_angles(), strict=True)
    )

    def linkage(number: int, stand: int, foot: pin.SE3) -> None:
        left = leg(
            number, "left", stand, foot * pin.SE3(np.eye(3), np.array([-0.5 * BASE, 0.0, 0.0]))
        )
        if number + 1 < count:
            # The next five-bar is mounted upright on the left far link's end. Its joints come
            # before those of the right leg, because Pinocchio needs every chain complete before the
            # next begins.
            linkage(
                number + 1,
                left,
                end
                * pin.SE3(
                    pin.utils.rotate("z", -(angles["left"] + angles["elbow_left"])), np.zeros(3)
                ),
            )
        right = leg(
            number, "right", stand, foot * pin.SE3(np.eye(3), np.array([0.5 * BASE, 0.0, 0.0]))
        )
        loops.append(
            pin.RigidConstraintModel(
                pin.ContactType.CONTACT_3D, model, left, end, right, end, pin.ReferenceFrame.LOCAL
            )
        )

    def leg(number: int, side: str, stand: int, place: pin.SE3) -> int:
        motor = model.addJoint(stand, pin.JointModelRZ(), place, f"motor{number}_{side}")
        model.appendBodyToJoint(motor, _rod(NEAR), pin.SE3.Identity())
        elbow: int = model.addJoint(
            motor,
            pin.JointModelRZ(),
            pin.SE3(np.eye(3), np.array([NEAR, 0.0, 0.0])),
            f"elbow{number}_{side}",
        )
        model.appendBodyToJoint(elbow, _rod(FAR), pin.SE3.Identity())
        return elbow

    end = pin.SE3(np.eye(3), np.array([FAR, 0.0, 0.0]))
    linkage(0, 0, upright)
    q0 = [
        angles[f"{'elbow_' if name.startswith('elbow') else ''}{name.split('_')[1]}"]
        for name in list(model.names)[1:]
    ]
    motors = [f"motor{number}_{side}" for number in range(count) for side in ("left", "right")]
    return psp3.ClosedLoopRobot(model, loops, motors, np.array(q0))


def _closed_angles() -> tuple[float, float, float, float]:
    """Return the angles of a symmetric pose: both motors and both elbows [rad]."""
    left = 2.2
    elbow = np.array([-0.5 * BASE + NEAR * np.cos(left), NEAR * np.sin(left)])
    link = np.arctan2(np.sqrt(FAR**2 - elbow[0] ** 2), -elbow[0])
    return left, np.pi - left, float(link - left), float(-(link - left))


def _rod(length: float) -> pin.Inertia:
    return pin.Inertia(
        length,
        np.array([0.5 * length, 0.0, 0.0]),
        length * np.diag([1e-4, length**2 / 12.0, length**2 / 12.0]),
    )
