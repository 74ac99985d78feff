"""The functions of a plant in an FMU, around the kernels of compiled loops.

They are plain Python that is translated to C. Only the kernels that they call are compiled in
Python.
"""

from __future__ import annotations

from typing import Any

from psp3.checks import Array
from psp3.dynamics.compiled_robot import advance, is_state
from psp3.simulation.kernels import limited

BEYOND_LIMITS = -1
"""Code if the first coordinate is beyond its limits. It is one less for each following coordinate,
and then for each motor whose largest force is not positive.
"""


def restart(robot: Any, reference: Array) -> None:
    """Start in the reference pose, if the robot has loops to close."""
    for i in range(reference.size):
        robot.memory[i] = reference[i]


def is_within(motion: Array, low: Array, high: Array) -> int:
    """Return 1 if all positions are within their limits, or -1 - i for the first that is not."""
    for i in range(low.size):
        if not low[i] <= motion[i] <= high[i]:
            return BEYOND_LIMITS - i
    return 1


def write_motion(motion: Array, positions: Array, speeds: Array) -> None:
    """Write positions and speeds of a state."""
    for i in range(positions.size):
        positions[i] = motion[i]
    for i in range(speeds.size):
        speeds[i] = motion[positions.size + i]


def begin(
    robot: Any,
    reference: Array,
    low: Array,
    high: Array,
    motion: Array,
    start_positions: Array,
    start_speeds: Array,
    largest: Array,
    positions: Array,
    speeds: Array,
) -> int:
    """Set the robot's state; return 1, 0 if it has no such pose, or -1 - i at a limit."""
    for i in range(largest.size):
        if not largest[i] > 0.0:
            return BEYOND_LIMITS - low.size - i
    for i in range(start_positions.size):
        motion[i] = start_positions[i]
    for i in range(start_speeds.size):
        motion[start_positions.size + i] = start_speeds[i]
    restart(robot, reference)
    if not is_state(robot, motion):
        return 0
    # As in the compiled loop, the first step searches its pose from the reference pose.
    restart(robot, reference)
    write_motion(motion, positions, speeds)
    return is_within(motion, low, high)


def move(
    robot: Any,
    step: float,
    steps: int,
    drives: Array,
    low: Array,
    high: Array,
    motion: Array,
    applied: Array,
    forces: Array,
    largest: Array,
    positions: Array,
    speeds: Array,
) -> int:
    """Advance by one period; return 1, 0 if no pose is reached, or -1 - i at a limit."""
    for i in range(largest.size):
        applied[i] = limited(forces[i], largest[i])
    if not advance(robot, motion, applied, step, steps, drives):
        return 0
    write_motion(motion, positions, speeds)
    return is_within(motion, low, high)
