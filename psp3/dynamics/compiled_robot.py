"""What compiled loops ask of a robot, whichever it is: functions chosen by the type of its table.

A robot's table is a NamedTuple of arrays, :class:`psp3.multibody.core.Tables` of any tree with
loops. What depends on the kind of robot is registered where that is: :mod:`psp3.robots.stepping`,
and for closed forms beside them.
"""

from __future__ import annotations

from typing import Any

from fuzzy2.support.compiled import chosen_by_table
from psp3.checks import Array


@chosen_by_table
def balance(
    robot: Any, state: Array, forces: Array, drives: Array, mass: Array, net: Array
) -> None:
    """Write M + J (n, n) and what is left of the forces for accelerations and dry friction (n,).

    The state are positions and speeds (p + n,), ``forces`` those of the motors, ``drives`` (n, 3)
    see :mod:`psp3.drives.kernels`; their dry friction is written, too, where it depends on the
    pose. What is written is NaN where the state is none of the robot's.
    """


@chosen_by_table
def write_rates(robot: Any, state: Array, rates: Array) -> None:
    """Write how the positions of a state change, (p,), to the first of the rates.

    Of positions that are joint angles and ways these are the speeds. A quaternion among them is
    first brought to unit length, in the state, which rounding and steps of integration leave.
    """


@chosen_by_table
def is_state(robot: Any, state: Array) -> bool:
    """Tell whether a state is finite and one of the robot's."""
    raise NotImplementedError


@chosen_by_table
def advance(
    robot: Any, state: Array, forces: Array, step: float, steps: int, drives: Array
) -> bool:
    """Take Runge–Kutta steps under constant forces (n,), in place.

    ``drives`` (n, 3), or (0, 3) for none. Return whether the state reached is finite and one of the
    robot's.
    """
    raise NotImplementedError


@chosen_by_table
def write_forces(
    robot: Any, positions: Array, speeds: Array, accelerations: Array, out: Array
) -> bool:
    """Write the motors' forces (m,) of a motion; return whether the robot can have them.

    Fewer accelerations, (k,), are those of the first coordinates, and the others follow.
    """
    raise NotImplementedError


@chosen_by_table
def allocate(robot: Any, positions: Array, forces: Array, out: Array) -> bool:
    """Write the shortest forces of the motors (m,) for forces along the first coordinates (k,).

    Return whether there are any.
    """
    raise NotImplementedError
