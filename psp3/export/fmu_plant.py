"""A robot as the plant of an FMU: the Runge–Kutta steps of the compiled loop, in C."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import NotExportable
from fuzzy2.export.c_code import Argument, CFunction, CWriter, Known, Mixed
from psp3.checks import Array, one_or_each
from psp3.drives.drive import Drive
from psp3.errors import InvalidValue
from psp3.export.fmu_kernels import BEYOND_LIMITS, begin, move
from psp3.export.fmu_model import Model, in_one_row, name_in_c
from psp3.export.fmu_names import Names, force, position, speed, variables
from psp3.multibody.tree import AT_BEFORE

NO_LIMIT = float(np.finfo(float).max)
"""The largest force of a motor without a limit: the largest double, which all programs can read,
unlike infinity."""

_NO_REFERENCE = np.empty(0)


def plant_model(
    robot: Any,
    name: str,
    period: float,
    steps: int,
    drive: Drive | Sequence[Drive],
    torque_limit: ArrayLike | None,
) -> Model:
    """Return a robot as a plant, with the steps of :mod:`psp3.simulation.runge_kutta`.

    Parameters
    ----------
    robot : Robot
        The robot.
    name : str
        An identifier of C.
    period : float
        Time between two changes of the forces [s].
    steps : int
        Integration steps in a period.
    drive : Drive or sequence of Drive
        Drive of all motors, or of each.
    torque_limit : float or (m,) array_like, optional
        Initial largest forces [N], [N m]; no limit by default.

    Raises
    ------
    fuzzy2.errors.NotExportable
        If a class of the robot's own overrides its dynamics.
    InvalidValue
        If a limit is not positive.
    """
    if robot.compiled_table() is None:
        wanted = "a robot of psp3.load"
        raise NotExportable(type(robot).__name__, "its dynamics are Python of its class", wanted)
    largest = _largest_forces(torque_limit, len(robot.actuated))
    names, code = Names.of(robot), CWriter(name_in_c(name), "double", _about(robot, period, steps))
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
        "largest_forces": variables(
            *("largest_force", "largest force", names.motors, force, "parameter"), largest
        ),
    }
    return Model(
        name,
        code.code(),
        f"{robot.title}, integrated in steps of {period / steps:g} s",
        *in_one_row(groups),
        begins,
        moves,
        False,
        period,
        _messages(robot, names),
    )


def _largest_forces(torque_limit: ArrayLike | None, motors: int) -> Array:
    """Return the largest force of each motor."""
    if torque_limit is None:
        return np.full(motors, NO_LIMIT)
    limits = one_or_each("torque_limit", torque_limit, motors)
    if not (limits > 0.0).all():
        raise InvalidValue("torque_limit", torque_limit, f"one positive number or {motors}")
    return limits


def _about(robot: Any, period: float, steps: int) -> list[str]:
    return [
        f"{robot.title} under forces of its motors that are constant for {period:g} s, in which\n"
        f"the classical Runge-Kutta method takes {steps} step{'s' if steps > 1 else ''}."
    ]


def _add_functions(
    writer: CWriter, robot: Any, plant: Any, period: float
) -> tuple[CFunction, CFunction]:
    """Add the functions that set the robot's state and advance it."""
    table, (low, high) = plant.robot, robot.limits
    m, p, n = len(robot.actuated), len(low), len(robot.coordinates_v)
    mixed, reference = _parts(table)
    motion = Argument("motion", "positions and speeds", p + n, "state")
    limits: list[Known | Argument] = [Known("low", low), Known("high", high), motion]
    largest = Argument("largest_forces", "limits of the motors' forces [N, N m]", m)
    shown = [
        Argument("positions", "positions of the robot [m, rad]", p, "out"),
        Argument("speeds", "its speeds [m/s, rad/s]", n, "out"),
    ]
    begins = writer.add(
        "begin",
        "Set the state of the robot.",
        begin,
        [
            mixed,
            Known("reference", reference),
            *limits,
            Argument("start_positions", "initial positions [m, rad]", p),
            Argument("start_speeds", "initial speeds [m/s, rad/s]", n),
            largest,
            *shown,
        ],
        "1; 0 if there is no such pose; -1 - i if coordinate i is beyond its limits, less if a "
        "largest force is not positive",
    )
    step = [Known("step", period / plant.steps), Known("steps", plant.steps)]
    moves = writer.add(
        "step",
        "Advance by one period.",
        move,
        [
            mixed,
            *step,
            Known("drives", plant.drives),
            *limits,
            Argument("applied", "forces of the motors", m, "state"),
            Argument("forces", "of the motors [N, N m]", m),
            largest,
            *shown,
        ],
        "1; 0 if no pose is reached; -1 - i if coordinate i is beyond its limits",
    )
    return begins, moves


def _parts(table: Any) -> tuple[Mixed, Array]:
    """Return a robot's table, whose memory is part of the struct, and the reference pose."""
    room = "memory" if hasattr(table, "memory") else "scratch"
    array = getattr(table, room)
    states = {room: Argument(room, "last pose, and scratch space", array.size, "state")}
    reference = array[: int(table.tree[AT_BEFORE])].copy() if room == "memory" else _NO_REFERENCE
    return Mixed("robot", table, states), reference


def _messages(robot: Any, names: Names) -> dict[int, str]:
    messages = {
        0: f"{robot.title} has no such pose, or reached one that is impossible: its loops cannot "
        "be closed, or numbers are not finite; check the forces"
    }
    for i, ((name, unit), low, high) in enumerate(zip(names.positions, *robot.limits, strict=True)):
        if high < math.inf or low > -math.inf:
            said = f"{name} is beyond its limits, {low:.6g} to {high:.6g} {unit}"
            messages[BEYOND_LIMITS - i] = said
    for i, (name, _) in enumerate(names.motors):
        said = f"largest_force_{name} is not positive: set the largest force of the motor"
        messages[BEYOND_LIMITS - len(names.positions) - i] = said
    return messages
