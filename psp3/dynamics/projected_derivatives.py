r"""Derivatives of inverse dynamics, from Pinocchio's derivatives of the tree and of joined frames.

With :math:`q` the configuration that closes the loops at the actuated positions :math:`a`, the
equations of the whole robot are

.. math::

    J(q)\, \dot q = 0, \qquad \gamma(q, \dot q, \ddot q) = 0, \qquad
    \operatorname{RNEA}(q, \dot q, \ddot q) + J(q)^T \lambda = S^T \tau,

where :math:`J` is the constraint Jacobian, :math:`\gamma = J \ddot q + \dot J \dot q`,
:math:`\lambda` are the forces in the loops and :math:`S` selects the actuated joints. All three
equations are differentiated along motions that keep the loops closed, :math:`\delta q = L\, \delta
a`, in Pinocchio's tangent coordinates, so that ball joints and free flyers are not special cases:

.. math::

    \delta \dot q_u &= -\Phi_u^{-1} \frac{\partial (J \dot q)}{\partial q} L\, \delta a, \qquad
    \delta \ddot q_u = -\Phi_u^{-1} \Big( \frac{\partial \gamma}{\partial q} L\, \delta a
    + \frac{\partial \gamma}{\partial \dot q}
    \delta \dot q \Big), \\
    \delta \tau &= L^T \Big( \frac{\partial F}{\partial q} L\, \delta a
    + \frac{\partial F}{\partial \dot q} \delta \dot q
    + M_\text{tree}\, \delta \ddot q \Big), \qquad F = \operatorname{RNEA} + J^T \lambda.

The change of the complement :math:`L` does not appear: :math:`L^T J^T = 0`, so it is accounted for
by the loop forces among the external forces of RNEA. The derivatives of RNEA are Pinocchio's (J.
Carpentier and N. Mansard, Analytical derivatives of rigid body dynamics algorithms, Robotics:
Science and Systems, 2018); its ``computeConstraintDynamicsDerivatives``, which is wrong for some
loops closed at a point, is not used.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
import pinocchio as pin

from psp3.checks import Array, Indices
from psp3.dynamics.closed_pose import ClosedPose


class DrivenTree(Protocol):
    """A tree whose loops are closed."""

    model: pin.Model
    """The tree."""
    data: pin.Data
    """Pinocchio's data for the tree."""
    constraint_models: Sequence[Any]
    """The loop closures."""
    dependent_v: Indices
    """Places of the joints without motors in joint velocities."""

    def drift(self, q: Array, v: Array) -> Array:
        """Return the joint accelerations (nv,) at constant speeds of the actuated joints."""
        ...


def projected_derivatives(
    robot: DrivenTree, closure: ClosedPose, speed: Array, acceleration: Array
) -> Array:
    """Return the derivatives of the forces of one motion, (3, n, n).

    They are the derivatives by positions, by speeds and by accelerations.

    Parameters
    ----------
    robot : DrivenTree
        The robot.
    closure : ClosedPose
        Its pose.
    speed, acceleration : (n,) ndarray
        Rates of the actuated joints.
    """
    model, data, dependent = robot.model, robot.data, robot.dependent_v
    q, L, inverse = closure.configuration, closure.complement, closure.dependent_inverse
    v = L @ speed
    joint_accelerations = L @ acceleration + robot.drift(q, v)
    # The un-actuated joints have no motors, so the loops supply their forces.
    loop_forces = -inverse.T @ pin.rnea(model, data, q, v, joint_accelerations)[dependent]

    pin.computeForwardKinematicsDerivatives(model, data, q, v, joint_accelerations)
    loops = [_Loop(robot, loop) for loop in robot.constraint_models]
    velocity_by_q, acceleration_by_q, acceleration_by_v = _constraint_derivatives(loops, model.nv)
    external, turning = _external_forces(loops, loop_forces, model)

    # Changes of the un-actuated joints' velocities and accelerations when only the actuated
    # positions or speeds change.
    velocities, by_positions, by_speeds = np.zeros((3, *L.shape))
    velocities[dependent] = -inverse @ velocity_by_q @ L
    by_positions[dependent] = -inverse @ (acceleration_by_q @ L + acceleration_by_v @ velocities)
    by_speeds[dependent] = -inverse @ acceleration_by_v @ L

    force_by_q, force_by_v, tree = pin.computeRNEADerivatives(
        model, data, q, v, joint_accelerations, external
    )
    return np.stack(
        [
            L.T @ ((force_by_q + turning) @ L + force_by_v @ velocities + tree @ by_positions),
            L.T @ (force_by_v @ L + tree @ by_speeds),
            L.T @ tree @ L,
        ]
    )


class _Frame:
    """One of the two frames that a loop joins.

    It stores the motion in the frame's own axes, with Pinocchio's derivatives.

    Velocity and acceleration are spatial, (6,); their derivatives by q and by the joint velocities
    are (6, nv).
    """

    def __init__(self, robot: DrivenTree, joint: int, placement: Any) -> None:
        self.joint, self.in_joint = joint, placement
        frame = robot.model, robot.data, joint, placement, pin.ReferenceFrame.LOCAL
        self.in_base = robot.data.oMi[joint] * placement
        self.velocity, self.acceleration = (
            pin.getFrameVelocity(*frame).vector,
            pin.getFrameAcceleration(*frame).vector,
        )
        self.velocity_by_q, self.acceleration_by_q, self.acceleration_by_v, self.jacobian = (
            pin.getFrameAccelerationDerivatives(*frame)
        )

    def whole(self) -> tuple[Array, Array, Array]:
        """Return the derivatives of the frame's velocity and acceleration, each (6, nv).

        They are those of the velocity by q, and of the acceleration by q and by v.
        """
        return self.velocity_by_q, self.acceleration_by_q, self.acceleration_by_v

    def point(self) -> tuple[Array, Array, Array]:
        """Return the same for the origin alone, each (3, nv).

        They are those of its velocity and classical acceleration, in axes that do not rotate.
        """
        by_q, by_v = self.acceleration_by_q, self.acceleration_by_v
        velocity, spin, turn = (
            pin.skew(self.velocity[:3]),
            pin.skew(self.velocity[3:]),
            self.jacobian[3:],
        )
        # The classical acceleration is the spatial one plus spin × velocity.
        acceleration = pin.skew(self.acceleration[:3] + spin @ self.velocity[:3])
        return (
            self.velocity_by_q[:3] - velocity @ turn,
            by_q[:3]
            + spin @ self.velocity_by_q[:3]
            - velocity @ self.velocity_by_q[3:]
            - acceleration @ turn,
            by_v[:3] + spin @ self.jacobian[:3] - velocity @ turn,
        )


class _Loop:
    """The two frames of a loop, and the placement of the second in the first.

    It also stores whether only their origins coincide.
    """

    def __init__(self, robot: DrivenTree, loop: Any) -> None:
        self.first = _Frame(robot, loop.joint1_id, loop.joint1_placement)
        self.second = _Frame(robot, loop.joint2_id, loop.joint2_placement)
        self.relative = self.first.in_base.actInv(self.second.in_base)
        self.is_point = loop.type == pin.ContactType.CONTACT_3D


def _constraint_derivatives(loops: list[_Loop], nv: int) -> tuple[Array, Array, Array]:
    """Return the derivatives of J q̇ and γ by q, and of γ by q̇, each (m, nv).

    They are correct along motions that keep the loops closed.
    """
    velocity_by_q, acceleration_by_q, acceleration_by_v = ([np.zeros((0, nv))] for _ in range(3))
    for loop in loops:
        first, second = loop.first, loop.second
        if loop.is_point:
            change, sides = loop.relative.rotation, (first.point(), second.point())
        else:
            # The frames coincide all the time, so they do not rotate relative to each other.
            change, sides = loop.relative.action, (first.whole(), second.whole())
        for rows, one, other in zip(
            (velocity_by_q, acceleration_by_q, acceleration_by_v), *sides, strict=True
        ):
            rows.append(one - change @ other)
    return (
        np.concatenate(velocity_by_q),
        np.concatenate(acceleration_by_q),
        np.concatenate(acceleration_by_v),
    )


def _external_forces(loops: list[_Loop], loop_forces: Array, model: Any) -> tuple[Any, Array]:
    """Return the forces in the loops as external forces of RNEA.

    Also return the part of their derivative by q that RNEA's derivative lacks, (nv, nv).
    """
    external = [pin.Force.Zero() for _ in range(model.njoints)]
    turning = np.zeros((model.nv, model.nv))
    start = 0
    for loop in loops:
        first, second, size = loop.first, loop.second, 3 if loop.is_point else 6
        force = pin.Force(np.concatenate([loop_forces[start : start + size], np.zeros(6 - size)]))
        reaction = loop.relative.actInv(force)
        external[first.joint] = external[first.joint] - first.in_joint.act(force)
        external[second.joint] = external[second.joint] + second.in_joint.act(reaction)
        if loop.is_point:
            # RNEA's derivative keeps both forces fixed in their bodies, but at a point closure the
            # bodies rotate relative to each other.
            turn = loop.relative.rotation.T @ first.jacobian[3:] - second.jacobian[3:]
            turning += second.jacobian[:3].T @ pin.skew(reaction.linear) @ turn
        start += size
    forces = pin.StdVec_Force()
    forces.extend(external)
    return forces, turning
