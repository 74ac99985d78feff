"""A robot as the plant of an FMU: the Runge–Kutta steps of the compiled loop, in C."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from fuzzy2.errors import NotExportable
from fuzzy2.export.c_code import Argument, CFunction, CWriter, Known, Mixed
from psp3.checks import Array
from psp3.drives.drive import Drive
from psp3.dynamics.compiled_robot import advance, is_state
from psp3.export.fmu_model import Model, in_one_row
from psp3.export.fmu_names import Names, force, position, speed, variables
from psp3.multibody.tree import AT_BEFORE

BEYOND_LIMITS = -1
"""What is returned where the first coordinate is beyond its limits; one less for each that follows.
"""

_NO_REFERENCE = np.empty(0)


# Plain Python that is translated, and never compiled: what it calls is.


def restart(robot, reference):
    """Let the robot begin in the reference pose, if it looks for poses at all."""
    for i in range(reference.size):
        robot.memory[i] = reference[i]


def is_within(motion, low, high):
    """Return 1 where all positions are within their limits, or -1 - i of the first that is not."""
    for i in range(low.size):
        if not low[i] <= motion[i] <= high[i]:
            return BEYOND_LIMITS - i
    return 1


def write_motion(motion, positions, speeds):
    """Write positions and speeds of a state."""
    for i in range(positions.size):
        positions[i] = motion[i]
    for i in range(speeds.size):
        speeds[i] = motion[positions.size + i]


def begin(robot, reference, low, high, motion, start_positions, start_speeds, positions, speeds):
    """Put the robot into a state; return 1, 0 where it has no such pose, or -1 - i at a limit."""
    for i in range(start_positions.size):
        motion[i] = start_positions[i]
    for i in range(start_speeds.size):
        motion[start_positions.size + i] = start_speeds[i]
    restart(robot, reference)
    if not is_state(robot, motion):
        return 0
    # As in the compiled loop the first step looks for its pose from the reference.
    restart(robot, reference)
    write_motion(motion, positions, speeds)
    return is_within(motion, low, high)


def move(robot, step, steps, drives, low, high, motion, forces, positions, speeds):
    """Go on by one period; return 1, 0 where no pose is reached, or -1 - i at a limit."""
    if not advance(robot, motion, forces, step, steps, drives):
        return 0
    write_motion(motion, positions, speeds)
    return is_within(motion, low, high)


def plant_model(
    robot: Any, name: str, period: float, steps: int, drive: Drive | Sequence[Drive]
) -> Model:
    """Return a robot as a plant that takes the steps of :class:`psp3.simulation.runge_kutta.RungeKutta`.

    Parameters
    ----------
    robot : Robot
        The robot.
    name : str
        An identifier of C.
    period : float
        Time between two changes of the forces [s].
    steps : int
        Steps of integration in it.
    drive : Drive or sequence of Drive
        Of all motors, or of each.

    Raises
    ------
    fuzzy2.errors.NotExportable
        If the robot has dynamics of its own class.
    """
    if robot.compiled_table() is None:
        wanted = "a robot of psp3.load"
        raise NotExportable(type(robot).__name__, "its dynamics are Python of its class", wanted)
    names, code = Names.of(robot), CWriter(name, "double", _about(robot, period, steps))
    begins, moves = _add_functions(code, robot, robot.compiled_steps(steps, drive), period)
    groups = {
        "forces": variables("force", "force", names.motors, force, "input"),
        "positions": variables("position", "position", names.positions, position, "output"),
        "speeds": variables("speed", "speed", names.speeds, speed, "output"),
        "start_positions": variables(
            *("start_position", "position at the start", names.positions, position, "parameter"),
            robot.reference,
        ),
        "start_speeds": variables(
            "start_speed", "speed at the start", names.speeds, speed, "parameter"
        ),
    }
    return Model(
        code.code(),
        f"{robot.title}, integrated in steps of {period / steps:g} s",
        *in_one_row(groups),
        begins,
        moves,
        False,
        period,
        _messages(robot, names),
    )


def _about(robot: Any, period: float, steps: int) -> list[str]:
    return [
        f"{robot.title} under forces of its motors that are constant for {period:g} s, in which\n"
        f"the classical Runge-Kutta method takes {steps} step{'s' if steps > 1 else ''}."
    ]


def _add_functions(
    writer: CWriter, robot: Any, plant: Any, period: float
) -> tuple[CFunction, CFunction]:
    """Add what puts the robot into a state, and what moves it on."""
    table, (low, high) = plant.robot, robot.limits
    m, p, n = len(robot.actuated), len(low), len(robot.coordinates_v)
    mixed, reference = _parts(table)
    motion = Argument("motion", "positions and speeds", p + n, "state")
    limits = [Known("low", low), Known("high", high), motion]
    shown = [
        Argument("positions", "where the robot is [m, rad]", p, "out"),
        Argument("speeds", "its speeds [m/s, rad/s]", n, "out"),
    ]
    begins = writer.add(
        "begin",
        "Put the robot into a state.",
        begin,
        [
            *(mixed, Known("reference", reference), *limits),
            Argument("start_positions", "where the robot begins [m, rad]", p),
            Argument("start_speeds", "with which speeds [m/s, rad/s]", n),
            *shown,
        ],
        "1; 0 where there is no such pose; -1 - i where coordinate i is beyond its limits",
    )
    step = [Known("step", period / plant.steps), Known("steps", plant.steps)]
    moves = writer.add(
        "step",
        "Go on by one period.",
        move,
        [
            *(mixed, *step, Known("drives", plant.drives), *limits),
            Argument("forces", "of the motors [N, N m]", m),
            *shown,
        ],
        "1; 0 where no pose is reached; -1 - i where coordinate i is beyond its limits",
    )
    return begins, moves


def _parts(table: Any) -> tuple[Mixed, Array]:
    """Return a robot's table, of which its memory is part of the struct, and the reference pose."""
    room = "memory" if hasattr(table, "memory") else "scratch"
    array = getattr(table, room)
    states = {room: Argument(room, "last pose, and room to work in", array.size, "state")}
    reference = array[: int(table.tree[AT_BEFORE])].copy() if room == "memory" else _NO_REFERENCE
    return Mixed("robot", table, states), reference


def _messages(robot: Any, names: Names) -> dict[int, str]:
    messages = {
        0: f"{robot.title} has no pose there, or reached one that it cannot take: its loops cannot "
        "be closed, or numbers are not finite; look at the forces"
    }
    for i, ((name, unit), low, high) in enumerate(zip(names.positions, *robot.limits, strict=True)):
        if high < math.inf or low > -math.inf:
            said = f"{name} is beyond its limits, {low:.6g} to {high:.6g} {unit}"
            messages[BEYOND_LIMITS - i] = said
    return messages
