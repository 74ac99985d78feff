"""A controller as an FMU: its reset and its step in C, one step per period."""

from __future__ import annotations

from typing import Any

from fuzzy2.export.c_code import Argument
from psp3.checks import Array
from psp3.export.controllers import code_of, robot_of
from psp3.export.fmu_model import Model, Variable, in_one_row, name_in_c
from psp3.export.fmu_names import Names, acceleration, force, position, speed, variables


def controller_model(controller: Any, robot: Any, name: str, period: float) -> Model:
    """Return a controller as a model whose inputs are positions, speeds and desired motion.

    Parameters
    ----------
    controller : Controller
        A controller that can be exported, see :mod:`psp3.export.controllers`.
    robot : Robot
        Its robot.
    name : str
        An identifier of C.
    period : float
        The control period [s].

    Raises
    ------
    fuzzy2.errors.NotExportable
        If the controller cannot be written in C.
    """
    steered = robot_of(controller) if robot is None else robot
    code = code_of(controller, name=name_in_c(name), robot=robot)
    assert code is not None
    functions = {
        function.name.removeprefix(f"{code.name}_"): function for function in code.functions
    }
    step = functions["step"]
    groups = {
        argument.name: _group(argument, Names.of(steered), steered.reference)
        for argument in step.visible
        if argument.name != "t"
    }
    return Model(
        name,
        code,
        f"{type(controller).__name__} of {steered.title}, once in {period:g} s",
        *in_one_row(groups),
        functions.get("reset"),
        step,
        True,
        period,
        {0: "the controller's forces are not finite: check its inputs"},
    )


def _group(argument: Argument, names: Names, home: Array) -> list[Variable]:
    """Return the variables of an argument of the step."""
    commanded, motors = names.positions[: names.commanded], names.motors
    if argument.name == "positions":
        return variables("position", "position", names.positions, position, "input", home)
    if argument.name == "speeds":
        return variables("speed", "speed", names.speeds, speed, "input")
    if argument.name == "desired":
        kinds = (("position", position), ("speed", speed), ("acceleration", acceleration))
        starts = (home, None, None)
        return [
            variable
            for (kind, unit), start in zip(kinds, starts, strict=True)
            for variable in variables(
                f"desired_{kind}", f"desired {kind}", commanded, unit, "input", start
            )
        ]
    if argument.name == "torque":
        return variables("force", "force", motors, force, "output")
    if argument.name == "interval":
        ends = ("mean", "deviation") if argument.about.startswith("means") else ("low", "high")
        return [
            variable
            for end in ends
            for variable in variables(
                f"force_{end}", f"{argument.about}: {end}", motors, force, "output"
            )
        ]
    said = f"{argument.name}: {argument.about}"
    count = argument.size or 1
    return [Variable(f"{argument.name}_{i}", said, "", "output") for i in range(1, count + 1)]
