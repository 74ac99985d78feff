"""The properties of a robot that its dynamics needs: tree, loops, motors and home."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
import pinocchio as pin

from psp3.checks import Array, Indices, one_row
from psp3.closure.mobility import mobility
from psp3.closure.rank import dependent_solver
from psp3.errors import DisorderedJoints, MobilityMismatch, UnknownName

MOBILITY_TOLERANCE = 1e-5
"""L may violate the loops' velocity equations by this share. It is far above rounding, and far
below the violation with a wrong number of actuators.
"""


MISMATCHED = 300.0
"""Rounded loops may violate their velocity equations by this many times their mismatch. If rounding
causes both, the observed factor of a singular value is at most thirty.
"""


class HasTree(Protocol):
    """Any object with a Pinocchio ``model``.

    Other attributes are read if they exist and are not None, as in the robots of
    example-robot-data: ``constraint_models`` (default: no loops), ``actuated`` (default: every
    joint), and ``q0``, a configuration that closes the loops, or nearly (default: ``neutral`` of
    the model).
    """

    @property
    def model(self) -> pin.Model:
        """The tree."""
        ...


class Mechanism:
    """Tree, loops and motors of a robot.

    Parameters
    ----------
    robot : HasTree
        A robot, or any other object with a tree.

    Attributes
    ----------
    model : pinocchio.Model
        The tree.
    loops : list of pinocchio.RigidConstraintModel
        The loop closures.
    equations : list of Coupling, Hinge or Spin
        The other closures.
    springs : mapping or None
        Springs of joints; None for a bare tree.
    motors : (nv, m) ndarray or None
        Joint velocities that the motors drive; None for a bare tree, whose coordinates are driven.
    mismatch : float
        Residual that rounding leaves in the loops [m, rad].
    names : tuple of str
        The actuated joints, or the robot's ``coordinates`` if these are not the actuated joints.
    actuated, dependent : ndarray of int
        Places of the actuated joints in joint velocities, and of the others; ``locked`` joints are
        in neither.

    Raises
    ------
    UnknownName
        If the tree has no joint of the name of a motor.
    """

    def __init__(self, robot: HasTree) -> None:
        self._robot = robot
        self.model = robot.model
        self.loops: list[Any] = list(getattr(robot, "constraint_models", None) or ())
        locked = getattr(robot, "locked", ())
        self.equations: list[Any] = [
            *(getattr(robot, "equations", None) or ()),
            *(one.spin for one in locked if one.spin is not None),
        ]
        self.springs = getattr(robot, "springs", None)
        self.motors: Any = getattr(robot, "motors", None)
        mismatch = getattr(robot, "closure_mismatch", None)
        self.mismatch = 0.0 if mismatch is None else max(mismatch.length, mismatch.angle)
        known = tuple(str(name) for name in self.model.names)[1:]
        chosen = getattr(robot, "coordinates", None) or getattr(robot, "actuated", None)
        self.names: tuple[str, ...] = tuple(chosen or known)
        for name in self.names:
            if name not in known:
                raise UnknownName("actuated joint", name, known)
        joints = [self.model.joints[self.model.getJointId(name)] for name in self.names]
        self.actuated: Indices = np.concatenate(
            [np.arange(joint.idx_v, joint.idx_v + joint.nv) for joint in joints]
        )
        held = [
            self.model.joints[self.model.getJointId(one.joint)].idx_v
            for one in locked
            if one.spin is None
        ]
        self.dependent: Indices = np.setdiff1d(np.arange(self.model.nv), [*self.actuated, *held])

    @property
    def drives_coordinates(self) -> bool:
        """Whether each coordinate is that of a motor, in the same order."""
        n = self.actuated.size
        return self.motors is None or (
            self.motors.shape[1] == n and bool((self.motors[self.actuated] == np.eye(n)).all())
        )

    @property
    def rows(self) -> int:
        """Number of closure equations: three or six per loop."""
        return sum(int(loop.residualSize()) for loop in self.loops)

    def home(self) -> Array:
        """Return the configuration from which the loops are closed, (nq,).

        Raises
        ------
        InvalidArray
            If ``q0`` is not finite or of another shape.
        """
        home = getattr(self._robot, "q0", None)
        return pin.neutral(self.model) if home is None else one_row("q0", home, self.model.nq)

    def complement(self, q: Array, jacobian: Array) -> tuple[Array, Array]:
        r"""Return L (eq. 3.17), (nv, n), and the inverse of :math:`\Phi^u`, (nv − n, m).

        Parameters
        ----------
        q : (nq,) ndarray
            A configuration.
        jacobian : (m, nv) ndarray
            The constraint Jacobian :math:`\Phi` there.

        Raises
        ------
        SingularConfiguration
            If the actuated joints do not determine the others here.
        MobilityMismatch
            If they determine each other.
        """
        inverse = dependent_solver(jacobian[:, self.dependent])
        complement = np.zeros((self.model.nv, self.actuated.size))
        complement[self.actuated, np.arange(self.actuated.size)] = 1.0
        complement[self.dependent] = -inverse @ jacobian[:, self.actuated]
        # If there are more actuated joints than degrees of freedom, no L keeps the loops closed,
        # and the pseudo-inverse is only the best approximation. An inverse solves all equations.
        if len(jacobian) > self.dependent.size:
            missed = np.abs(jacobian @ complement).max(initial=0.0)
            allowed = MOBILITY_TOLERANCE + MISMATCHED * self.mismatch
            if missed > allowed * np.abs(jacobian).max(initial=1.0):
                raise MobilityMismatch(mobility(self.model, self.loops, self.names, q), self.names)
        return complement, inverse


def check_order(model: pin.Model) -> None:
    """Refuse a tree in which a joint does not follow its parent's other descendants.

    Pinocchio's ``crba`` and ``constraintDynamics`` assume that subtrees are contiguous.

    Raises
    ------
    DisorderedJoints
        If a joint does not.
    """
    branch = [0]
    for joint in range(1, model.njoints):
        parent = int(model.parents[joint])
        while branch and branch[-1] != parent:
            branch.pop()
        if not branch:
            raise DisorderedJoints(str(model.names[joint]), str(model.names[parent]))
        branch.append(joint)
