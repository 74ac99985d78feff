"""Closures for which Pinocchio has no constraint model: hinges, couplings, balls without spin."""

from __future__ import annotations

from typing import NamedTuple

import pinocchio as pin

from psp3.checks import Array


class Hinge(NamedTuple):
    """Two frames that share their origin and their z axis: five equations."""

    name: str
    joint1_id: int
    joint1_placement: pin.SE3
    joint2_id: int
    joint2_placement: pin.SE3


class Coupling(NamedTuple):
    """A coordinate that is a polynomial of another one: a gear, a mimic joint."""

    name: str
    y: int
    """The joint that follows, of one degree of freedom in one coordinate."""
    x: int
    """The joint that leads, of the same kind."""
    coefficients: tuple[float, ...]
    """Coefficients of the polynomial, the constant first; at most five."""


class Spin(NamedTuple):
    """A ball joint that does not rotate about an axis of its body."""

    name: str
    joint: int
    axis: Array
    """The axis, in the axes of the body that the joint carries, (3,)."""
    quaternion: Array
    """The quaternion at which it is held, (x, y, z, w)."""
