"""What several test files share: random states, numerical derivatives, small robots with loops."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

Array = NDArray[np.float64]

SCREW_AZIMUTHS = 2.0 * np.pi / 3.0 * np.arange(3)


def random_heights(rng: np.random.Generator, count: int, largest_difference: float = 0.3) -> Array:
    """Return (count, 3) nut heights [m] of random differences.

    The largest difference is uniform between 0 and the given one.

    Up to 0.3 m the star tilts by at most 48 degrees, so every arm length is positive.
    """
    shape = rng.uniform(size=(count, 3))
    shape -= shape.min(axis=1, keepdims=True)
    shape /= shape.max(axis=1, keepdims=True)
    return (
        rng.uniform(-0.4, 0.4, size=(count, 1))
        + rng.uniform(0.0, largest_difference, size=(count, 1)) * shape
    )


def random_states(
    rng: np.random.Generator, count: int, largest_difference: float = 0.3
) -> tuple[Array, Array]:
    """Return random nut heights [m] and speeds of the order of 1 m/s, both (count, 3)."""
    return random_heights(rng, count, largest_difference), rng.normal(size=(count, 3))


def derivative(curve: Callable[[float], Array], step: float) -> Array:
    """Return the derivative at 0 of an array-valued curve by eighth-order central differences.

    The truncation error is step**8 / 630 times the ninth derivative, the rounding error about
    1e-16 / step times the values.
    """
    weights = {1: 4.0 / 5.0, 2: -1.0 / 5.0, 3: 4.0 / 105.0, 4: -1.0 / 280.0}
    return (
        sum(weight * (curve(k * step) - curve(-k * step)) for k, weight in weights.items()) / step
    )


def relative_error(found: Array, expected: Array) -> float:
    """Return the largest error of a stack of arrays (n, ...).

    Each is relative to the largest entry of its expected array.
    """
    axes = tuple(range(1, np.ndim(expected)))
    return float((np.abs(found - expected).max(axis=axes) / np.abs(expected).max(axis=axes)).max())


def cross_matrix(w: Array) -> Array:
    """Return the cross-product matrix of one vector, written out."""
    return np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])


def thesis_chain(leg: int, joints: Array, d: float, h: float) -> Array:
    """Return the tip transform of one leg as printed in eq. 3.7 to 3.12.

    For (a, phi, theta, lambda, b).
    """
    a, phi, theta, lam, b = joints
    alpha = SCREW_AZIMUTHS[leg]
    turn = np.array(
        [
            [np.cos(alpha), -np.sin(alpha), 0, 0],
            [np.sin(alpha), np.cos(alpha), 0, 0],
            [0, 0, 1, 0],
            [0, 0, 0, 1],
        ]
    )
    base = np.eye(4)
    base[:2, 3] = d * np.cos(alpha), d * np.sin(alpha)
    nut = np.eye(4)
    nut[2, 3] = a

    def swivel(angle: float) -> Array:
        s, c = np.sin(angle), np.cos(angle)
        return np.array([[s, c, 0, 0], [0, 0, 1, 0], [c, -s, 0, 0], [0, 0, 0, 1]])

    s, c = np.sin(lam), np.cos(lam)
    last = np.array([[c, -s, 0, 0], [0, 0, 1, 0], [-s, -c, 0, 0], [0, 0, 0, 1]])
    slider = np.array([[1, 0, 0, 0], [0, 0, 1, b], [0, -1, 0, 0], [0, 0, 0, 1]])
    # The tool frames of legs 2 and 3 are turned back about the star's axis, which is y here (3.9,
    # 3.11).
    s, c = np.sin(alpha), np.cos(alpha)
    back = np.array([[c, 0, s, 0], [0, 1, 0, 0], [-s, 0, c, 0], [0, 0, 0, 1]])
    tool = np.eye(4)
    tool[1, 3] = -h
    chain: Array = base @ turn @ nut @ swivel(phi) @ swivel(theta) @ last @ slider @ back @ tool
    return chain


def _robot(
    joints: list[tuple[int, Any, Array]],
    loop: tuple[int, int, Any],
    q0: list[float],
    actuated: tuple[str, ...],
) -> SimpleNamespace:
    """Build a tree of bodies with skewed inertias and close it by a loop that is closed at q0.

    ``joints`` holds (parent, joint model, position in the parent) of joints j1, j2, ...; ``loop``
    the two joints that the closure joins and its kind.
    """
    rng = np.random.default_rng(7)
    model = pin.Model()
    # Oblique, so that a planar linkage in the plane z = 0 feels it.
    model.gravity = pin.Motion(np.array([2.0, -5.0, -8.0]), np.zeros(3))
    for number, (parent, joint, position) in enumerate(joints, start=1):
        index = model.addJoint(parent, joint, pin.SE3(np.eye(3), position), f"j{number}")
        # Random bodies, but not pathological ones: every term of the dynamics is exercised.
        axes, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        inertia = axes @ np.diag([0.02, 0.03, 0.04]) @ axes.T
        model.appendBodyToJoint(
            index,
            pin.Inertia(rng.uniform(0.5, 2.0), rng.uniform(-0.1, 0.1, 3), inertia),
            pin.SE3.Identity(),
        )
    data, reference = model.createData(), np.array(q0)
    pin.forwardKinematics(model, data, reference)
    first, second, kind = loop
    placement = pin.SE3(pin.utils.rotate("x", 0.3), np.array([0.25, 0.05, 0.1]))
    constraint = pin.RigidConstraintModel(
        kind,
        model,
        first,
        placement,
        second,
        data.oMi[second].actInv(data.oMi[first] * placement),
        pin.ReferenceFrame.LOCAL,
    )
    constraints = pin.StdVec_RigidConstraintModel()
    constraints.append(constraint)
    return SimpleNamespace(
        model=model, constraint_models=constraints, actuated=actuated, q0=reference
    )


def four_bar_closed_with_6d() -> SimpleNamespace:
    """Return a planar four-bar linkage: crank, coupler, rocker and a hinge.

    Of the six closure equations three are redundant.
    """
    z = pin.JointModelRZ
    joints = [
        (0, z(), np.zeros(3)),
        (1, z(), np.array([0.2, 0.0, 0.0])),
        (0, z(), np.array([0.45, 0.0, 0.0])),
        (3, z(), np.array([0.4, 0.0, 0.02])),
    ]
    return _robot(joints, (2, 4, pin.ContactType.CONTACT_6D), [1.0, -0.55, 1.3, -0.85], ("j1",))


def four_bar_closed_with_3d() -> SimpleNamespace:
    """Return the linkage without the hinge, closed at a point.

    Of the three closure equations one is redundant.
    """
    z = pin.JointModelRZ
    joints = [
        (0, z(), np.zeros(3)),
        (1, z(), np.array([0.2, 0.0, 0.0])),
        (0, z(), np.array([0.45, 0.0, 0.0])),
    ]
    return _robot(joints, (2, 3, pin.ContactType.CONTACT_3D), [1.0, -0.55, 1.3], ("j1",))


def spatial_loop_closed_with_3d() -> SimpleNamespace:
    """Return a spatial linkage with two degrees of freedom.

    Revolute, slider, universal joint, ball (the closure), revolute.
    """
    axis = np.array([-2.0, 3.0, -2.0]) / np.sqrt(17.0)
    joints = [
        (0, pin.JointModelRZ(), np.zeros(3)),
        (1, pin.JointModelPX(), np.array([0.1, 0.0, 0.05])),
        (2, pin.JointModelRX(), np.array([0.2, 0.0, 0.0])),
        (3, pin.JointModelRY(), np.zeros(3)),
        (0, pin.JointModelRevoluteUnaligned(axis), np.array([0.07, 0.48, 0.34])),
    ]
    return _robot(
        joints, (4, 5, pin.ContactType.CONTACT_3D), [0.55, 0.04, 0.26, -0.29, 0.06], ("j1", "j2")
    )


def spatial_loop_of_every_joint() -> SimpleNamespace:
    """Return a spatial linkage with one degree of freedom.

    Screw, ball, (coupler, 6D), universal, and an angle kept as cosine and sine.
    """
    joints = [
        (0, pin.JointModelHelicalUnaligned(np.array([0.0, 0.6, 0.8]), 0.05), np.zeros(3)),
        (1, pin.JointModelSpherical(), np.array([0.3, 0.0, 0.1])),
        (0, pin.JointModelRUBX(), np.array([0.9, 0.1, 0.0])),
        (
            3,
            pin.JointModelUniversal(np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])),
            np.array([0.0, 0.1, 0.5]),
        ),
    ]
    ball = pin.Quaternion(pin.utils.rpyToMatrix(0.3, -0.2, 0.4)).coeffs()
    q0 = [0.4, *ball, np.cos(0.7), np.sin(0.7), 0.2, -0.3]
    return _robot(joints, (2, 4, pin.ContactType.CONTACT_6D), q0, ("j1",))


def free_body_carried_by_an_arm() -> SimpleNamespace:
    """Return an arm of two joints, welded to a free body.

    The second joint is a chain of two in one joint's clothing.
    """
    chain = pin.JointModelComposite()
    chain.addJoint(pin.JointModelRY())
    joints = [
        (0, pin.JointModelRZ(), np.zeros(3)),
        (1, chain, np.array([0.3, 0.0, 0.1])),
        (0, pin.JointModelFreeFlyer(), np.array([0.2, 0.1, 0.0])),
    ]
    turn = pin.Quaternion(pin.utils.rpyToMatrix(0.5, 0.1, -0.7)).coeffs()
    return _robot(
        joints, (2, 3, pin.ContactType.CONTACT_6D), [0.3, -0.4, 0.1, 0.2, 0.3, *turn], ("j1", "j2")
    )


ROBOTS_WITH_LIE_GROUPS = (spatial_loop_of_every_joint, free_body_carried_by_an_arm)
"""Loops through joints whose velocities are not the rates of their coordinates."""

ROBOTS_WITH_LOOPS = (four_bar_closed_with_6d, four_bar_closed_with_3d, spatial_loop_closed_with_3d)
