"""The interface of a robot for motions, controllers, plants and pictures."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Protocol, runtime_checkable

import pinocchio as pin
from numpy.typing import ArrayLike

from psp3.checks import Array, Indices
from psp3.drives.drive import Drive
from psp3.dynamics.dynamics_model import DynamicsModel
from psp3.dynamics.motors import Driven
from psp3.multibody.core import LastPose
from psp3.robots.learning_inputs import LearningInputs


@runtime_checkable
class Robot(DynamicsModel, Protocol):
    """A robot in the coordinates of its n actuated joints.

    If coordinates and motors are not the same, positions are (..., p); speeds, accelerations and
    forces along the coordinates are (..., n); and forces of the motors are (..., m).

    :class:`psp3.ClosedLoopRobot` implements it for any tree with loops, and :class:`psp3.PSP3` in
    closed form. Every robot has all of these members, and code that takes a ``Robot`` does not
    check its class.
    """

    model: pin.Model
    """The tree as a Pinocchio model."""
    visual_model: pin.GeometryModel
    """The shapes of the robot."""
    constraint_models: Sequence[Any]
    """The loop closures."""
    actuated: tuple[str, ...]
    """Names of the actuated joints, in the order of all actuated coordinates."""
    actuated_v: Indices
    """Indices of the actuated joints in a velocity of the tree, (n,)."""
    coordinates: tuple[str, ...]
    """Names of the joints that are coordinates, those that the motors command first."""
    coordinates_q: Indices
    """Indices of the coordinates in a configuration, (p,)."""
    coordinates_v: Indices
    """Indices of the coordinates in a velocity of the tree, (n,)."""
    q0: Array
    """Reference configuration, (nq,)."""
    urdf: Path | None
    """The URDF it was loaded from, if any."""
    srdf: Path | None
    """The SRDF it was loaded with."""
    has_inverse_of_tip: bool
    """Whether :meth:`motion_of_tip` is available."""

    @property
    def reference(self) -> Array:
        """Actuated positions of the reference configuration, (n,) [m or rad]."""
        ...

    @property
    def drives_coordinates(self) -> bool:
        """Whether each coordinate is that of a motor, in the same order."""
        ...

    @property
    def commanded(self) -> int:
        """Number of coordinates that the motors command; these are the first ones."""
        ...

    @property
    def limits(self) -> tuple[Array, Array]:
        """Lowest and highest positions of the actuated joints, each (n,) [m or rad]."""
        ...

    @property
    def title(self) -> str:
        """Name of the robot in titles."""
        ...

    @property
    def limit_message(self) -> str:
        """The message when an actuated joint is beyond its limits."""
        ...

    @property
    def point_of_force(self) -> Array:
        """Where the force of a sliding motor is drawn, in the axes of its joint, (3,) [m]."""
        ...

    @property
    def compiled_steps(self) -> Callable[[int, Any], Any]:
        """Function that creates a compiled plant from a number of steps and drives."""
        ...

    @property
    def learning_inputs(self) -> LearningInputs:
        """The inputs of learned M, C and G."""
        ...

    def compiled_table(self) -> NamedTuple | None:
        """Return the robot's table for compiled loops, or None; each call creates a new memory."""
        ...

    def last_pose(self) -> LastPose | None:
        """Return a memory of the caller's last pose, for the argument ``guess``."""
        ...

    def configuration(
        self, positions: ArrayLike, guess: ArrayLike | LastPose | None = None
    ) -> Array:
        """Return the configurations (..., nq) that close the loops at positions (..., n)."""
        ...

    def configurations_along(self, path: ArrayLike, guess: ArrayLike | None = None) -> Array:
        """Return the configurations (N, nq) along a path (N, n), in one assembly mode."""
        ...

    def velocity(self, positions: ArrayLike, speeds: ArrayLike) -> Array:
        """Return the velocities (..., nv) of all joints."""
        ...

    def drift(self, q: Array, v: Array) -> Array:
        """Return the accelerations (nv,) of all joints at constant speeds of the coordinates."""
        ...

    def tip(self, positions: ArrayLike) -> Array:
        """Return the tip in base axes, (..., 3) [m]; NaN if the robot has none."""
        ...

    def motion_of_tip(
        self, point: Array, velocity: Array, acceleration: Array
    ) -> tuple[Array, Array, Array]:
        """Return actuated positions, speeds and accelerations for a motion of the tip."""
        ...

    def frame_placement(self, positions: ArrayLike, frame: str) -> Array:
        """Return the placement of a frame in base axes, (..., 4, 4)."""
        ...

    def actuation_matrix(self, positions: ArrayLike) -> Array:
        """Return the matrix from motor forces to forces along the coordinates, (..., n, m)."""
        ...

    def drives_of_coordinates(self, drive: Drive | Sequence[Drive]) -> Driven:
        """Return drives of motors, and joints' dry friction, as they act on the coordinates."""
        ...

    def allocated_forces(self, positions: ArrayLike, forces: ArrayLike) -> Array:
        """Return motor forces (..., m) of least norm for forces along the first coordinates."""
        ...

    def mass_matrix(self, positions: ArrayLike, guess: ArrayLike | LastPose | None = None) -> Array:
        """Return the mass matrix, (..., n, n)."""
        ...

    def inverse_dynamics(
        self,
        positions: ArrayLike,
        speeds: ArrayLike,
        accelerations: ArrayLike,
        guess: ArrayLike | LastPose | None = None,
    ) -> Array:
        """Return the forces (..., n) of a motion."""
        ...

    def forward_dynamics(
        self,
        positions: ArrayLike,
        speeds: ArrayLike,
        forces: ArrayLike,
        guess: ArrayLike | LastPose | None = None,
    ) -> Array:
        """Return the accelerations (..., n) under forces (..., n)."""
        ...
