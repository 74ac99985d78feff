"""The functions of a robot that compiled loops call, chosen by the type of its table.

A robot's table is a NamedTuple of arrays; for any tree with loops it is
:class:`psp3.multibody.core.Tables`. Functions for each kind of robot are registered in the module
of that kind: :mod:`psp3.robots.stepping` for trees, and the modules of closed forms.
"""

from __future__ import annotations

from typing import Any

from fuzzy2.support.compiled import chosen_by_table
from psp3.checks import Array


@chosen_by_table
def balance(
    robot: Any, state: Array, forces: Array, drives: Array, mass: Array, net: Array
) -> None:
    """Write M + J (n, n) and the forces that remain for accelerations and dry friction (n,).

    J is the reflected inertia of the drives. The state is positions and speeds (p + n,), ``forces``
    are those of the motors, and ``drives`` (n, 3) are as in :mod:`psp3.drives.kernels`. Their dry
    friction is also written if it depends on the pose. The results are NaN if the robot cannot be
    in the state.
    """


@chosen_by_table
def write_rates(robot: Any, state: Array, rates: Array) -> None:
    """Write the rates of the positions of a state, (p,), to the first of the rates.

    For joint angles and displacements the rates are the speeds. A quaternion in the state is first
    normalized, because rounding and integration steps change its length.
    """


@chosen_by_table
def is_state(robot: Any, state: Array) -> bool:
    """Tell whether a state is finite and the robot can be in it."""
    raise NotImplementedError


@chosen_by_table
def advance(
    robot: Any, state: Array, forces: Array, step: float, steps: int, drives: Array
) -> bool:
    """Take Runge–Kutta steps under constant forces (n,), in place.

    ``drives`` (n, 3), or (0, 3) for none. Return whether the final state is finite and the robot
    can be in it.
    """
    raise NotImplementedError


@chosen_by_table
def write_forces(
    robot: Any, positions: Array, speeds: Array, accelerations: Array, out: Array
) -> bool:
    """Write the motor forces (m,) of a motion; return whether there are any.

    Fewer accelerations, (k,), are those of the first coordinates, and the others follow.
    """
    raise NotImplementedError


@chosen_by_table
def allocate(robot: Any, positions: Array, forces: Array, out: Array) -> bool:
    """Write the shortest motor forces (m,) for forces along the first coordinates (k,).

    Return whether there are any.
    """
    raise NotImplementedError
