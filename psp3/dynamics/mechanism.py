"""What a route through the dynamics needs of a robot: tree, loops, motors and home."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
import pinocchio as pin

from psp3.checks import Array, Indices, one_row
from psp3.errors import UnknownName


class HasTree(Protocol):
    """Anything with a Pinocchio ``model``.

    What else it may have is read if it is there and not None, as of the robots of
    example-robot-data: ``constraint_models`` (none: no loops), ``actuated`` (none: every joint),
    and ``q0``, a configuration that closes the loops, or nearly (none: ``neutral`` of the model).
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
        A robot, or what else has a tree.

    Attributes
    ----------
    model : pinocchio.Model
        The tree.
    loops : list of pinocchio.RigidConstraintModel
        The loop closures.
    names : tuple of str
        The actuated joints.
    actuated, dependent : ndarray of int
        Places of the actuated joints in joint velocities, and of the others.

    Raises
    ------
    UnknownName
        If the tree has no joint of the name of a motor.
    """

    def __init__(self, robot: HasTree) -> None:
        self._robot = robot
        self.model = robot.model
        self.loops: list[Any] = list(getattr(robot, "constraint_models", None) or ())
        known = tuple(str(name) for name in self.model.names)[1:]
        self.names: tuple[str, ...] = tuple(getattr(robot, "actuated", None) or known)
        for name in self.names:
            if name not in known:
                raise UnknownName("actuated joint", name, known)
        joints = [self.model.joints[self.model.getJointId(name)] for name in self.names]
        self.actuated: Indices = np.concatenate(
            [np.arange(joint.idx_v, joint.idx_v + joint.nv) for joint in joints]
        )
        self.dependent: Indices = np.setdiff1d(np.arange(self.model.nv), self.actuated)

    @property
    def rows(self) -> int:
        """How many closure equations there are: three or six a loop."""
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
