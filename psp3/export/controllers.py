"""Controllers in C99: functions ``reset`` and ``step`` that do the same as the compiled loop.

Every controller that has a table for the compiled loop can be written, see
:func:`psp3.control.controller.steer`, together with the robot's model if it needs one.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import NotExportable
from fuzzy2.export.c_code import Argument, CCode, CWriter, Known, Mixed
from fuzzy2.export.systems import without_shapes
from psp3.checks import Array, checked_count, checked_positive, one_or_each
from psp3.control.controller import Widths, may_be_compiled, widths_of
from psp3.control.feedback import check_feedback
from psp3.control.kernels import (
    COMPUTED_TORQUE,
    FEED_FORWARD,
    GRAVITY_COMPENSATED_PD,
    PD,
    Classical,
)
from psp3.control.linear_quadratic_kernels import Regulation
from psp3.control.task_space_kernels import TaskLaw
from psp3.errors import InvalidValue
from psp3.export import controller_kernels as kernels
from psp3.export import robot_text, single
from psp3.export.trained_range import fires_everywhere
from psp3.fuzzy_control.adaptive_kernels import Adaptive
from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
from psp3.fuzzy_control.kernels import NO_MODEL, FuzzyRun
from psp3.fuzzy_control.slotine_li_kernels import SlotineLi
from psp3.kinematics.tasks import rotating
from psp3.multibody.closing import MOST_ATTEMPTS
from psp3.multibody.tree import AT_BEFORE, GROUPS
from psp3.version import __version__

KINDS: dict[type, tuple[Any, Any, tuple[str, ...]]] = {
    Classical: (kernels.reset_classical, kernels.step, ()),
    Regulation: (kernels.reset_regulation, kernels.step, ()),
    TaskLaw: (kernels.reset_model, kernels.step, ()),
    FuzzyRun: (kernels.reset_model, kernels.learned_step, ("_estimate",)),
    Adaptive: (kernels.reset_adaptive, kernels.learned_step, ()),
    SlotineLi: (kernels.reset_slotine_li, kernels.learned_step, ("_write_basis",)),
}
"""Kinds of tables, each with its reset and step, and the kernels whose loops are unrolled.
Unrolling specializes the code for each rule base.
"""

CODES = "1; or 0 if the torque is not finite, and it must then not be sent to a motor"

_NO_REFERENCE = np.empty(0)


class Exported(NamedTuple):
    """The data of a controller that is exported.

    They are the controller, its robot, its table for the compiled loop, the number of its inputs,
    and the parts between it and the robot.
    """

    controller: Any
    robot: Any
    table: Any
    widths: Widths
    wires: kernels.Wires


def code_of(
    thing: Any,
    *,
    precision: str = "double",
    name: str | None = None,
    robot: Any = None,
    period: float | None = None,
    torque_limit: ArrayLike | None = None,
    encoder_resolution: ArrayLike = 0.0,
    delay: int = 0,
) -> CCode | None:
    """Return the C code of a controller; None if the thing is not a controller.

    Parameters
    ----------
    thing : controller, or path
        A controller whose ``table`` the compiled loop takes; or the file of a saved one.
    precision, name
        See :func:`psp3.export_c`; the name is ``"controller"`` by default.
    robot : Robot, optional
        The controlled robot, for controllers that do not know it.
    period : float, optional
        Control period [s]; needed with encoders.
    torque_limit, encoder_resolution, delay
        The parts between controller and robot, as in :func:`psp3.simulate`. The step then limits
        the forces, takes encoder readings (counts times the resolution) as its positions, and
        returns the forces of ``delay`` steps ago. The plant beside it must then have no delay of
        its own.

    Raises
    ------
    fuzzy2.errors.NotExportable
        If the controller has no table.
    InvalidValue
        If a limit or a period is not positive, or a resolution is negative; or, as in
        :func:`psp3.simulate`, if forces along the coordinates are not motor forces.
    """
    if isinstance(thing, str | Path):
        if not str(thing).endswith(".json"):
            return None
        thing = FuzzyComputedTorque.load(thing, robot)
    if not (hasattr(thing, "torque") and hasattr(thing, "reset")):
        return None
    exported = _exported(thing, robot)
    wires = _wires(exported.widths, period, torque_limit, encoder_resolution, delay)
    exported = exported._replace(wires=wires)
    prefix = "controller" if name is None else name
    constants = without_shapes(getattr(getattr(thing, "base", thing), "systems_", ()))
    if precision == "single":
        exported, constants = _with_fewer_digits(exported), constants | single.CONSTANTS
    table = exported.table
    # Logarithms of firing strengths serve inputs far away from all rules. Most learned controllers
    # never see such inputs, and then need no logarithm.
    never = ("lost",) if isinstance(table, FuzzyRun) and fires_everywhere(table.controller) else ()
    writer = CWriter(prefix, precision, _about(exported), KINDS[type(table)][2], constants, never)
    _add_functions(writer, exported)
    return writer.code()


def _exported(controller: Any, robot: Any) -> Exported:
    title = type(controller).__name__
    if robot is None:
        robot = robot_of(controller)
    if robot is None:
        raise NotExportable(title, "it does not know its robot", "the robot: robot=...")
    check_feedback(robot, controller)
    widths = widths_of(robot)
    controller.reset()
    table = controller.table(NO_MODEL, widths) if may_be_compiled(controller) else None
    if type(table) not in KINDS:
        wanted = "a trained controller that the compiled loop takes, without a path or a model in "
        "Python"
        raise NotExportable(title, "its step is not compiled for this robot", wanted)
    return Exported(controller, robot, table, widths, _wires(widths, None, None, 0.0, 0))


def _wires(
    widths: Widths,
    period: float | None,
    torque_limit: ArrayLike | None,
    encoder_resolution: ArrayLike,
    delay: int,
) -> kernels.Wires:
    """Return the parts between controller and robot; arrays of missing parts are empty."""
    limit, resolution = np.empty(0), np.empty(0)
    if torque_limit is not None:
        limit = one_or_each("torque_limit", torque_limit, widths.motors)
        if not (limit > 0.0).all():
            raise InvalidValue("torque_limit", torque_limit, "positive")
    read = one_or_each("encoder_resolution", encoder_resolution, widths.commanded)
    if not (read >= 0.0).all():
        raise InvalidValue("encoder_resolution", read.tolist(), "not negative")
    if read.any():
        if period is None:
            wanted = "the control period in seconds, over which encoders take differences"
            raise InvalidValue("period", period, wanted)
        resolution = read
    queue = np.zeros((checked_count("delay", delay, 0), widths.motors))
    seconds = 0.0 if period is None else checked_positive("period", period)
    calls = np.zeros(1 if resolution.size or queue.size else 0)
    last = np.zeros(resolution.size)
    return kernels.Wires(resolution, limit, queue, last, calls, seconds, is_guarded=False)


def _with_fewer_digits(exported: Exported) -> Exported:
    """Return a controller whose model closes its loops to the accuracy of single precision."""
    table = exported.table
    for field in ("model", "motors"):
        model: Any = getattr(table, field, None)
        if hasattr(model, "memory"):
            numbers = single.numbers_of(model, exported.robot.title)
            table = table._replace(**{field: model._replace(numbers=numbers)})
    return exported._replace(table=table)


def robot_of(controller: Any) -> Any:
    """Return the robot that a controller knows, or None."""
    inner = getattr(controller, "base", controller)
    known = getattr(inner, "robot", None)
    return known if known is not None else getattr(inner, "model", None)


# Arguments and memory of the functions.


def _add_functions(writer: CWriter, exported: Exported) -> None:
    table = exported.table
    states, of_wires = _states(table), _states_of_wires(exported.wires)
    wires = exported.wires._replace(is_guarded=bool(states or of_wires))
    around = [
        Mixed("law", table, states) if states else Known("law", table),
        Mixed("wires", wires, of_wires) if of_wires else Known("wires", wires),
        Known("reference", _reference(table)),
    ]
    reset, step, _ = KINDS[type(table)]
    if states or of_wires:
        writer.add("reset", RESETS, reset, around)
    writer.add("step", STEPS, step, [*around, *_arguments(exported)], CODES)


def _arguments(exported: Exported) -> list[Argument]:
    """Return the inputs of a step, and its outputs."""
    commanded, p, n, m = exported.widths
    of_all = f"positions, speeds and accelerations of the first {commanded} coordinates"
    arguments = [
        Argument("t", "time [s]"),
        Argument("positions", f"of the coordinates {_units(exported, '')}", p),
        Argument("speeds", f"of the coordinates {_units(exported, '/s')}", n),
        Argument(
            "desired", f"{of_all}: all positions, all speeds, all accelerations", 3 * commanded
        ),
        Argument("torque", f"forces of the motors {_force_units(exported)}", m, "out"),
    ]
    if isinstance(exported.table, Classical | Regulation | TaskLaw):
        return arguments
    flags = f"whether the inputs were in the trained range; whether {_FELL}"
    return [
        *arguments,
        Argument("interval", _interval_words(exported), 2 * m, "out"),
        Argument("flags", flags, 2, "out"),
    ]


RESETS = "Forget everything about earlier runs. Call it once before the first step."
STEPS = "Write the forces of the motors for the next control period."
_FELL = "the estimate of the rules was unusable, and their average replaced it"


def _states(table: Any) -> dict[str, Argument]:
    """Return the arrays that hold a controller's memory."""
    states: dict[str, Argument] = {}
    if isinstance(table, Adaptive | SlotineLi):
        for name, array in table.memory._asdict().items():
            states[f"memory.{name}"] = _state(name, _REMEMBERED[name], array)
        return states
    if hasattr(table.model, "memory"):
        memory = table.model.memory
        states["model.memory"] = _state("pose", "the model's last pose, and room for it", memory)
    if isinstance(table, Regulation):
        # One memory, because forces are distributed to the motors in the pose for which they were
        # computed.
        states["motors.memory"] = states["model.memory"]
        wanted = "desired positions and speeds, and forces along the coordinates"
        states["memory"] = _state("wanted", wanted, table.memory)
    if isinstance(table, Classical):
        servo = "last error, its integral, feedback, zeros"
        states["memory"] = _state("servo", servo, table.memory)
        clock = "time of the last call, whether there was one"
        states["clock"] = _state("clock", clock, table.clock)
    return states


_REMEMBERED = {
    "clock": "time of the last call, whether there was one, and since the rules moved",
    "last": "positions, speeds and forces of the last call",
    "rows": "filtered rows of the least squares",
    "residuals": "filtered forces that the trained rules miss",
    "information": "matrix of the least squares",
    "right": "right side of the least squares",
    "factor": "room",
    "trial": "room",
    "gradient": "gradient of the next move of the rules",
    "delta": "movement of the rules so far",
    "consequents": "present consequents of all rules",
    "orders": "rules in the order of their consequents",
}


def _states_of_wires(wires: kernels.Wires) -> dict[str, Argument]:
    """Return the arrays that hold the memory of the parts between controller and robot."""
    words = {
        "last": ("counted", "positions that the encoders read last"),
        "queue": ("queue", "delayed forces"),
        "calls": ("calls", "whether there was a call"),
    }
    arrays = ((name, getattr(wires, name), *about) for name, about in words.items())
    return {name: _state(said, about, array) for name, array, said, about in arrays if array.size}


def _state(name: str, about: str, array: Array) -> Argument:
    whole = bool(np.issubdtype(array.dtype, np.integer))
    return Argument(name, about, array.size, "state", whole)


def _reference(table: Any) -> Array:
    """Return the initial pose in the memory of a model."""
    if not hasattr(getattr(table, "model", None), "memory"):
        return _NO_REFERENCE
    reference: Array = table.model.memory[: int(table.model.tree[AT_BEFORE])].copy()
    return reference


# Text of the header.


def _iterations(table: Any) -> list[str]:
    """Return the most steps of Newton's method that the model of a controller takes."""
    model: Any = getattr(table, "model", None)
    if not hasattr(model, "memory"):
        return []
    # For a frame: poses of the desired and the present frame, finite differences around the latter,
    # and the forces.
    poses = 2 * table.rows.size + 6 if isinstance(table, TaskLaw) else 1
    return [robot_text.bound_of_time(poses * int(model.tree[GROUPS]), MOST_ATTEMPTS)]


def _about(exported: Exported) -> list[str]:
    controller, robot = exported.controller, exported.robot
    return [
        f"{type(controller).__name__} of {robot.title}, by psp3 {__version__}.",
        f"Coordinates, in this order: {_named(robot.coordinates, robot.coordinates_v, robot)}.\n"
        f"Motors, in this order: {_named(robot.actuated, robot.actuated_v, robot)}.",
        *_law(exported),
        *_iterations(exported.table),
        "Nothing checks that positions, speeds and the desired motion are finite: if they are\n"
        "not, the torque is not, and 0 is returned. No function asks for memory or writes to\n"
        "anything but its arguments; each struct serves one robot and one thread.",
    ]


def _law(exported: Exported) -> list[str]:
    """Return a description of a control law, with its gains."""
    table = exported.table
    if isinstance(table, Regulation):
        return [_regulator_law(table)]
    if isinstance(table, Classical):
        return [_classical_law(table, exported.widths.commanded)]
    if isinstance(table, TaskLaw):
        return [_task_law(exported)]
    return [_learned_law(exported), _range(exported)]


_CLASSICAL = {
    FEED_FORWARD: "forces of the desired motion + kp e + kv e'",
    PD: "kp e + kv e'",
    GRAVITY_COMPENSATED_PD: "kp e + kv e' + weight at the present pose",
    COMPUTED_TORQUE: "forces of the accelerations a_d + kv e' + kp e",
}


def _classical_law(table: Classical, joints: int) -> str:
    lines = [f"torque = {_CLASSICAL[table.kind]}, e = desired - found"]
    if table.ki != 0.0:
        lines[0] += f", + {table.ki:g} times the integral of e, by the trapezoidal rule"
    samples = len(table.kp)
    if samples > 1:
        lines.append(
            f"with gains that change every {table.gain_period:g} s, {samples} times; then the last "
            "ones stay."
        )
        return "\n".join(lines)
    for name, gain in (("kp", table.kp), ("kv", table.kv)):
        matrix = gain.reshape(joints, joints)
        same = np.array_equal(matrix, matrix[0, 0] * np.eye(joints))
        rows = (
            f"{matrix[0, 0]:g}" if same else str([[float(f"{g:.6g}") for g in r] for r in matrix])
        )
        lines.append(f"{name} = {rows}")
    if table.is_allocated:
        lines.append("Feedback is distributed to the motors as the forces of least norm.")
    return "\n".join(lines)


def _regulator_law(table: Regulation) -> str:
    samples, k = len(table.gains), table.gains.shape[1] // (2 * table.pose.size)
    law = "torque = forces of the desired motion + K (e, e'), shared among the motors"
    if samples > 1:
        return f"{law},\nwith gains that change every {table.gain_period:g} s, {samples} times"
    rows = table.gains.reshape(k, -1).tolist()
    return f"{law}, e = desired - found\nK = {[[float(f'{g:.6g}') for g in row] for row in rows]}"


def _task_law(exported: Exported) -> str:
    controller, table = exported.controller, exported.table
    return (
        f"torque that gives {', '.join(controller.space.task)} of the frame "
        f"{controller.space.frame!r} the accelerations\n"
        f"x_d'' + kv e' + kp e, e = x_d - x, kp = {table.kp:g} 1/s^2, kv = {table.kv:g} 1/s, where "
        "the desired\nmotion of the coordinates takes it. Near singular poses it stops short: "
        f"the smallest singular\nvalue of the Jacobian is kept above a quarter of "
        f"{table.threshold:g}."
    )


def _learned_law(exported: Exported) -> str:
    controller = getattr(exported.controller, "base", exported.controller)
    lines = [
        "torque = M (a_d + kv e' + kp e) + C v + G, e = desired - found, with learned M, C and G",
        f"of kind {controller.kind}, kp = {controller.kp:g} 1/s^2, kv = {controller.kv:g} 1/s.",
    ]
    return "\n".join(lines)


def _range(exported: Exported) -> str:
    controller = getattr(exported.controller, "base", exported.controller)
    lines = ["Trained range:"]
    for name, low, high in zip(controller.inputs.names, *controller.ranges_, strict=True):
        lines.append(f"  {name}: {low:.9g} to {high:.9g}")
    if controller.outside == "clamp":
        lines.append("Inputs outside of it are clamped to it, and flags[0] is 0.")
    else:
        lines.append("Outside of it the exact model takes over, and flags[0] is 0.")
    lines.append(f"flags[1] is 1 if {_FELL}.")
    return "\n".join(lines)


def _named(names: Sequence[str], velocities: Array, robot: Any) -> str:
    turns = rotating(robot.model)[velocities]
    units = ("m" if not turn else "rad" for turn in turns)
    return ", ".join(f"{name} [{unit}]" for name, unit in zip(names, units, strict=False))


def _units(exported: Exported, per: str) -> str:
    turns = rotating(exported.robot.model)[exported.robot.coordinates_v]
    units = sorted({f"rad{per}" if turn else f"m{per}" for turn in turns})
    return f"[{', '.join(units)}]"


def _force_units(exported: Exported) -> str:
    turns = rotating(exported.robot.model)[exported.robot.actuated_v]
    return f"[{', '.join(sorted({'N m' if turn else 'N' for turn in turns}))}]"


def _interval_words(exported: Exported) -> str:
    controller = getattr(exported.controller, "base", exported.controller)
    if controller.kind == "gt2" and controller.reduction == "gaussian":
        return "means, then standard deviations of the torque"
    return "left ends, then right ends of the torque's interval"
