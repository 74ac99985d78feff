"""Controllers in C99: ``reset`` and ``step``, as the compiled loop steers with them.

Every controller that has a table for the compiled loop can be written, see
:func:`psp3.control.controller.steer`, with the robot's model in it where it needs one.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fuzzy2.errors import NotExportable
from fuzzy2.export.c_code import Argument, CCode, CWriter, Known, Mixed
from psp3.checks import Array
from psp3.control.controller import Widths, widths_of
from psp3.control.kernels import (
    COMPUTED_TORQUE,
    FEED_FORWARD,
    GRAVITY_COMPENSATED_PD,
    PD,
    Classical,
)
from psp3.export import controller_kernels as kernels
from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
from psp3.fuzzy_control.kernels import NO_MODEL
from psp3.kinematics.tasks import rotating
from psp3.multibody.tree import AT_BEFORE
from psp3.version import __version__

UNROLLED = ("_estimate",)
"""Kernels whose loops are written out, so that each rule base is translated for what it is."""

CODES = "1, or 0 where the torque is not finite, which no motor must be told"

_NO_REFERENCE = np.empty(0)


class Exported(NamedTuple):
    """What is known of a controller that is to be written: its table, its robot and its sizes."""

    controller: Any
    robot: Any
    table: Any
    widths: Widths


def code_of(
    thing: Any,
    *,
    precision: str = "double",
    name: str | None = None,
    robot: Any = None,
) -> CCode | None:
    """Return the C code of a controller, or None of what is no controller.

    Parameters
    ----------
    thing : controller, or path
        A controller whose ``table`` the compiled loop takes; or the file of a saved one.
    precision, name
        See :func:`psp3.export_c`; the name is ``"controller"`` by default.
    robot : Robot, optional
        The robot that is steered, for controllers that do not know it.

    Raises
    ------
    fuzzy2.errors.NotExportable
        If the controller has no table.
    """
    if isinstance(thing, str | Path):
        if not str(thing).endswith(".json"):
            return None
        thing = FuzzyComputedTorque.load(thing, robot)
    if not (hasattr(thing, "torque") and hasattr(thing, "reset")):
        return None
    exported = _exported(thing, robot)
    prefix = "controller" if name is None else name
    writer = CWriter(prefix, precision, _about(exported), UNROLLED)
    _add_functions(writer, exported)
    return writer.code()


def _exported(controller: Any, robot: Any) -> Exported:
    title = type(controller).__name__
    if robot is None:
        robot = robot_of(controller)
    if robot is None:
        raise NotExportable(title, "it does not know its robot", "the robot: robot=...")
    widths = widths_of(robot)
    controller.reset()
    table = controller.table(NO_MODEL, widths) if hasattr(controller, "table") else None
    if table is None:
        wanted = "a trained controller of the compiled loop, without a path or a model in Python"
        raise NotExportable(title, "its step is not compiled for this robot", wanted)
    return Exported(controller, robot, table, widths)


def robot_of(controller: Any) -> Any:
    """Return the robot that a controller knows, or None."""
    inner = getattr(controller, "base", controller)
    known = getattr(inner, "robot", None)
    return known if known is not None else getattr(inner, "model", None)


# What is written.


def _add_functions(writer: CWriter, exported: Exported) -> None:
    table, (commanded, p, n, m) = exported.table, exported.widths
    states, reset = _states(table)
    mixed = Mixed("law", table, states)
    known = Known("law", table)
    controller = mixed if states else known
    if reset is not None:
        reference = Known("reference", _reference(table))
        writer.add("reset", RESETS, reset, [controller, reference])
    rest = [
        Argument("t", "time [s]"),
        Argument("positions", f"of the coordinates, {_units(exported, '')}", p),
        Argument("speeds", f"of the coordinates, {_units(exported, '/s')}", n),
        Argument(
            "desired",
            f"positions, speeds and accelerations of the first {commanded} coordinates, all "
            "positions first",
            3 * commanded,
        ),
        Argument("torque", f"forces of the motors, {_force_units(exported)}", m, "out"),
    ]
    if isinstance(table, Classical):
        writer.add("step", STEPS, kernels.step, [controller, *rest], CODES)
        return
    rest += [
        Argument("interval", _interval_words(exported), 2 * m, "out"),
        Argument(
            "flags", "1 where the inputs were in the trained range; 1 where " + _FELL, 2, "out"
        ),
    ]
    writer.add("step", STEPS, kernels.learned_step, [controller, *rest], CODES)


RESETS = "Forget everything about earlier runs: call it once before the first step."
STEPS = "Write the forces of the motors for the next control period."
_FELL = "what the rules said was of no use, and their average took its place"


def _states(table: Any) -> tuple[dict[str, Argument], Any]:
    """Return the arrays that are remembered, and what resets them; None if there are none."""
    states: dict[str, Argument] = {}
    if hasattr(table.model, "memory"):
        states["model.memory"] = _state(
            "pose", "last pose of the model, and room", table.model.memory
        )
    if isinstance(table, Classical):
        states |= {
            "memory": _state("servo", "last error, its integral, feedback, zeros", table.memory),
            "clock": _state("clock", "time of the last call; whether there was one", table.clock),
        }
        return states, kernels.reset_classical
    return states, kernels.reset_learned if states else None


def _state(name: str, about: str, array: Array) -> Argument:
    whole = bool(np.issubdtype(array.dtype, np.integer))
    return Argument(name, about, array.size, "state", whole)


def _reference(table: Any) -> Array:
    """Return the pose with which the memory of a model begins."""
    if not hasattr(table.model, "memory"):
        return _NO_REFERENCE
    reference: Array = table.model.memory[: int(table.model.tree[AT_BEFORE])].copy()
    return reference


# What the header says.


def _about(exported: Exported) -> list[str]:
    controller, robot = exported.controller, exported.robot
    return [
        f"{type(controller).__name__} of {robot.title}, by psp3 {__version__}.",
        f"Coordinates, in this order: {_named(robot.coordinates, robot.coordinates_v, robot)}.\n"
        f"Motors, in this order: {_named(robot.actuated, robot.actuated_v, robot)}.",
        *_law(exported),
        "Nothing checks that positions, speeds and the desired motion are finite: where they are\n"
        "not, the torque is not, and 0 is returned. No function asks for memory or writes to\n"
        "anything but its arguments; each struct serves one robot and one thread.",
    ]


def _law(exported: Exported) -> list[str]:
    """Return what a controller does, with its gains."""
    table = exported.table
    if isinstance(table, Classical):
        return [_classical_law(table, exported.widths.commanded)]
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
        lines.append("Feedback is turned into the shortest forces of the motors.")
    return "\n".join(lines)


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
        lines.append("Outside of it the nearest inputs within are taken, and flags[0] is 0.")
    else:
        lines.append("Outside of it the exact model takes over, and flags[0] is 0.")
    lines.append(f"flags[1] is 1 where {_FELL}.")
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
