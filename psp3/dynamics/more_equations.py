"""Closure equations for which Pinocchio has no model, based on its kinematics.

For couplings, hinges and ball joints whose spin is held, this module computes the residual, the
Jacobian, and the accelerations with which the closures open when all joint speeds are constant. It
shares no code with the compiled core.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from psp3.checks import Array
from psp3.multibody.equations import Coupling, Hinge, Spin


class MoreEquations:
    """Couplings, hinges and held spins of a tree.

    Parameters
    ----------
    model : pinocchio.Model
        The tree.
    equations : sequence of Coupling, Hinge or Spin
    """

    def __init__(self, model: pin.Model, equations: Sequence[Any]) -> None:
        kinds = {Coupling: _Coupled, Hinge: _Hinged, Spin: _Held}
        self._all = [kinds[type(one)](model, one) for one in equations]
        self._width = model.nv
        self.rows = sum(one.rows for one in self._all)

    def at(self, data: pin.Data, q: Array) -> tuple[Array, Array]:
        """Return residuals (m,) and Jacobian (m, nv); joint Jacobians of q must be in the data."""
        if not self._all:
            return np.zeros(0), np.zeros((0, self._width))
        residuals, rows = zip(*(one.at(data, q) for one in self._all), strict=True)
        return np.concatenate(residuals), np.concatenate(rows)

    def accelerations(self, data: pin.Data, q: Array, v: Array) -> Array:
        """Return the opening accelerations, (m,), of a motion v that keeps them closed.

        The data must hold its twists and accelerations, and :meth:`at` must have been called with
        q.
        """
        if not self._all:
            return np.zeros(0)
        return np.concatenate([one.accelerations(data, q, v) for one in self._all])


class _Coupled:
    """A coordinate that is a polynomial of another, y = p(x)."""

    rows = 1

    def __init__(self, model: pin.Model, one: Coupling) -> None:
        self._width, self._y, self._x = model.nv, model.joints[one.y], model.joints[one.x]
        self._polynomial = np.polynomial.Polynomial(one.coefficients)

    def at(self, data: pin.Data, q: Array) -> tuple[Array, Array]:
        x, row = q[self._x.idx_q], np.zeros((1, self._width))
        row[0, self._y.idx_v] += 1.0
        row[0, self._x.idx_v] -= self._polynomial.deriv()(x)
        return np.array([q[self._y.idx_q] - self._polynomial(x)]), row

    def accelerations(self, data: pin.Data, q: Array, v: Array) -> Array:
        bend = self._polynomial.deriv(2)(q[self._x.idx_q])
        return np.array([-bend * v[self._x.idx_v] ** 2])


class _Held:
    """A ball joint that does not rotate about an axis n: its quaternion (u, w) has n · u = 0.

    The quaternion is relative to the held orientation; its rates are ẇ = −½ u · ω and u̇ = ½ (w ω +
    u × ω).
    """

    rows = 1

    def __init__(self, model: pin.Model, one: Spin) -> None:
        self._width, self._joint, self._axis = model.nv, model.joints[one.joint], one.axis
        self._from = pin.Quaternion(np.asarray(one.quaternion)).inverse()

    def _parts(self, q: Array) -> tuple[Array, float]:
        first = self._joint.idx_q
        x, y, z, w = (self._from * pin.Quaternion(q[first : first + 4])).coeffs()
        return np.array([x, y, z]), float(w)

    def at(self, data: pin.Data, q: Array) -> tuple[Array, Array]:
        u, w = self._parts(q)
        row, own = np.zeros((1, self._width)), self._joint.idx_v
        row[0, own : own + 3] = 0.5 * (w * self._axis + np.cross(self._axis, u))
        return np.array([self._axis @ u]), row

    def accelerations(self, data: pin.Data, q: Array, v: Array) -> Array:
        (u, w), own = self._parts(q), self._joint.idx_v
        omega = v[own : own + 3]
        w_rate, u_rate = -0.5 * u @ omega, 0.5 * (w * omega + np.cross(u, omega))
        rate = 0.5 * (w_rate * self._axis + np.cross(self._axis, u_rate))
        return np.array([rate @ omega])


class _Hinged:
    """Two frames that share origin and z axis: those of the second as seen from the first.

    M is the placement of the second frame in the first. The second moves with the relative twist ν
    = M v₂ − v₁.
    """

    rows = 5

    def __init__(self, model: pin.Model, one: Hinge) -> None:
        self._model = model
        self._sides = (
            (one.joint1_id, one.joint1_placement),
            (one.joint2_id, one.joint2_placement),
        )

    def at(self, data: pin.Data, q: Array) -> tuple[Array, Array]:
        (first, place), (second, other) = self._sides
        self._way = (data.oMi[first] * place).actInv(data.oMi[second] * other)
        local = pin.ReferenceFrame.LOCAL
        twists = [
            frame.toActionMatrixInverse()
            @ pin.getJointJacobian(self._model, data, joint, local).reshape(6, -1)
            if joint
            else np.zeros((6, self._model.nv))
            for joint, frame in self._sides
        ]
        relative = self._way.toActionMatrix() @ twists[1] - twists[0]
        point, axis = self._way.translation, self._way.rotation[:, 2]
        moved = relative[:3] - pin.skew(point) @ relative[3:]
        turned = -pin.skew(axis) @ relative[3:]
        return np.concatenate([point, axis[:2]]), np.concatenate([moved, turned[:2]])

    def accelerations(self, data: pin.Data, q: Array, v: Array) -> Array:
        way, point, axis = self._way, self._way.translation, self._way.rotation[:, 2]
        (here, there), (rate, other) = (
            [frame.actInv(values[joint]) for joint, frame in self._sides]
            for values in (data.v, data.a_gf)
        )
        relative = way.act(there) - here
        changes = way.act(other) + relative.cross(way.act(there)) - rate
        turn, turning = relative.angular, changes.angular
        moving = relative.linear + np.cross(turn, point)
        moved = changes.linear + np.cross(turning, point) + np.cross(turn, moving)
        turned = np.cross(turning, axis) + np.cross(turn, np.cross(turn, axis))
        return np.concatenate([moved, turned[:2]])


class JointElements:
    """Springs, damping and dry friction of joints.

    Parameters
    ----------
    model : pinocchio.Model
        The tree, with damping and friction.
    springs : mapping of str to (float, float), optional
        Stiffness and rest, by joint. If it is None (not empty), there is no damping or friction
        either, so that a bare Pinocchio tree moves as in Pinocchio.
    """

    def __init__(self, model: pin.Model, springs: Any) -> None:
        self._has = springs is not None
        self._damping = np.array(model.damping) if self._has else np.zeros(model.nv)
        self._friction = np.array(model.upperDryFrictionLimit) if self._has else np.zeros(model.nv)
        self._springs = [
            (joint.idx_v, joint.idx_q, stiffness, rest)
            for name, (stiffness, rest) in (springs or {}).items()
            for joint in (model.joints[model.getJointId(name)],)
        ]

    @property
    def are_there(self) -> bool:
        """Whether there are any elements."""
        return bool(self._springs or self._damping.any() or self._friction.any())

    def of_positions(self, q: Array) -> Array:
        """Return the forces of springs, (nv,)."""
        forces = np.zeros(len(self._damping))
        for velocity, place, stiffness, rest in self._springs:
            forces[velocity] += stiffness * (q[place] - rest)
        return forces

    def of_speeds(self, v: Array) -> Array:
        """Return the forces of damping and friction divided by the speeds, (nv,)."""
        with np.errstate(divide="ignore", invalid="ignore"):
            friction = np.where(v != 0.0, self._friction / np.abs(v), 0.0)
        return np.asarray(self._damping + friction)

    def resistance(self, q: Array, v: Array) -> Array:
        """Return the sum of all forces, (nv,)."""
        return np.asarray(self.of_positions(q) + self.of_speeds(v) * v)
