"""Flattened trees with memory whose parts are looked at by their names, and dense oracles."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pinocchio as pin

from psp3.multibody.closing import factored
from psp3.multibody.equations import Coupling, Hinge
from psp3.multibody.flatten import FlatTree, flattened
from psp3.multibody.loops import residual_of
from psp3.multibody.placement import place
from psp3.multibody.tree import (
    AT_CONFIGURATION,
    AT_HERE,
    AT_TARGET,
    COORDINATES,
    ELEMENTS,
    FRAME,
    GROUPS,
    HINGE,
    INDEPENDENT,
    MEMBERS,
    SIZE,
    VELOCITIES,
)
from tests.helpers import Array


class Flat:
    """A flattened tree with its memory, which begins as NaN: nothing is read before it is there."""

    def __init__(self, flat: FlatTree) -> None:
        self.flat = flat
        self.tree, self.numbers = flat.integers, flat.numbers
        self.memory = np.full(int(self.tree[SIZE]), np.nan)

    @property
    def all(self) -> tuple[Any, Array, Array]:
        """What every kernel takes first."""
        return self.tree, self.numbers, self.memory

    def count(self, what: int) -> int:
        """Return how many there are of something."""
        return int(self.tree[what])

    def part(self, at: int, *shape: int) -> Array:
        """Return a part of the memory, to be read and written."""
        first = self.count(at)
        return self.memory[first : first + int(np.prod(shape))].reshape(shape)

    def place(self, q: Array) -> None:
        """Place all elements at a configuration."""
        self.part(AT_CONFIGURATION, self.count(COORDINATES))[:] = q
        members = self.count(MEMBERS)
        place(*self.all, members - self.count(ELEMENTS), members)

    @property
    def seen_from(self) -> pin.SE3:
        """From where placements and twists are seen: where the floating base is, if there is one.

        Its inverse brings what Pinocchio says of the world there.
        """
        return pin.SE3(np.eye(3), self.part(AT_HERE, 3).copy())

    def close(self, q: Array) -> None:
        """Take a closed configuration for the pose: frames and factored Jacobians of all groups."""
        self.place(q)
        for group in range(self.count(GROUPS)):
            assert residual_of(*self.all, group) < 1e-9
            assert factored(*self.all, group) != 0.0

    def aim(self, positions: Array) -> None:
        """Make independent coordinates the target of a motion."""
        self.part(AT_TARGET, self.count(INDEPENDENT))[:] = positions

    def at(self, what: int) -> int:
        """Return where a part of the memory begins."""
        return self.count(what)

    @property
    def nv(self) -> int:
        """How many velocities the joints have."""
        return self.count(VELOCITIES)

    @property
    def n(self) -> int:
        """How many independent coordinates there are."""
        return self.count(INDEPENDENT)


def independent_of(parts: SimpleNamespace) -> Any:
    """Return the velocity indices of the motors."""
    names = [parts.model.getJointId(name) for name in parts.actuated]
    return np.array([parts.model.joints[index].idx_v for index in names], dtype=np.int64)


def flat_of(parts: SimpleNamespace) -> Flat:
    """Return the tree of a robot's parts with its motors."""
    return Flat(flattened(parts.model, parts.constraint_models, independent_of(parts)))


def flat_with(model: pin.Model, closures: list[Any], motors: list[int]) -> Flat:
    """Return a tree with closures of any kind.

    They are pairs of a constraint model of Pinocchio and a kind, or couplings.
    """
    known: list[Any] = []
    for closure in closures:
        if isinstance(closure, Coupling):
            known.append(closure)
            continue
        loop, kind = closure
        ends = loop.joint1_id, loop.joint1_placement, loop.joint2_id, loop.joint2_placement
        contact = pin.ContactType.CONTACT_6D if kind == FRAME else pin.ContactType.CONTACT_3D
        known.append(
            Hinge("", *ends)
            if kind == HINGE
            else pin.RigidConstraintModel(contact, model, *ends, pin.ReferenceFrame.LOCAL)
        )
    return Flat(flattened(model, known, np.array(motors, dtype=np.int64)))


def pinocchios_jacobian(parts: SimpleNamespace, q: Array) -> Array:
    """Return Pinocchio's constraint Jacobian at a closed configuration, (m, nv)."""
    data = parts.model.createData()
    loops = parts.constraint_models
    own = pin.StdVec_RigidConstraintData()
    pin.computeJointJacobians(parts.model, data, q)
    for loop in loops:
        own.append(loop.createData())
    for loop, memory in zip(loops, own, strict=True):
        loop.calc(parts.model, data, memory)
    return np.array(pin.getConstraintsJacobian(parts.model, data, loops, own))


def dense_complement(parts: SimpleNamespace, q: Array) -> Array:
    """Return L by NumPy's pseudo-inverse of Pinocchio's Jacobian, (nv, n)."""
    jacobian, motors = pinocchios_jacobian(parts, q), independent_of(parts)
    others = np.setdiff1d(np.arange(parts.model.nv), motors)
    complement = np.zeros((parts.model.nv, len(motors)))
    complement[motors, np.arange(len(motors))] = 1.0
    inverse = np.linalg.pinv(jacobian[:, others], rcond=1e-10)
    complement[others] = -inverse @ jacobian[:, motors]
    return complement


def symmetric(upper: Array) -> Array:
    """Return a symmetric matrix of which Pinocchio fills the upper triangle."""
    return np.asarray(np.triu(upper) + np.triu(upper, 1).T)
