"""The command that evaluates the equation of motion at one state."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from psp3.cli.compilation import one_off
from psp3.cli.joint_tables import force_units, position_labels, speed_labels
from psp3.cli.option_groups import single_options
from psp3.cli.options import Json, Numbers, Positions, numbers, of_each
from psp3.cli.output import fixed, new_table, plain_number, print_json, show, show_narrow, show_text
from psp3.cli.robot_options import RobotOptions

if TYPE_CHECKING:
    from psp3.robots.closed_loop_robot import ClosedLoopRobot


@single_options
@one_off
def dynamics(
    *,
    robot: RobotOptions,
    positions: Positions = None,
    speeds: Annotated[
        Numbers | None,
        typer.Option(parser=numbers, metavar="V1,V2,…", help="Speeds v (m/s, rad/s); default 0."),
    ] = None,
    accelerations: Annotated[
        Numbers | None,
        typer.Option(
            parser=numbers,
            metavar="W1,W2,…",
            help="Accelerations w (m/s², rad/s²); default 0.",
        ),
    ] = None,
    json: Json = False,
) -> None:
    """Evaluate the equation of motion at one state.

    Prints M, C, G and the forces of the motors. The forces are M w + C v + G at the given
    positions, speeds v and accelerations w.
    """
    import numpy as np

    which = robot.load()
    labels = speed_labels(which)
    a = (
        which.reference
        if positions is None
        else np.array(of_each("--positions", positions, position_labels(which)))
    )
    v, w = (
        np.zeros(len(labels)) if values is None else np.array(of_each(option, values, labels))
        for option, values in (("--speeds", speeds), ("--accelerations", accelerations))
    )
    M, C, G = which.equation_of_motion(a, v)
    forces = which.inverse_dynamics(a, v, w)
    motors = {} if _are_coordinates(which) else _forces_of_motors(which, a, v, w)
    if json:
        content = {"heights": a} if robot.is_of_thesis else {"robot": which.title, "positions": a}
        content |= {"speeds": v, "accelerations": w, "M": M, "C": C, "G": G, "forces": forces}
        content |= (
            {"parameters": robot.parameter_set}
            if robot.is_of_thesis
            else {"coordinates": which.coordinates} | motors
        )
        print_json(content | {"units": "SI"})
        return
    if robot.is_of_thesis:
        _show_of_thesis(M, C, G, forces)
        return
    _show(which, labels, M, C, G, forces, motors)


def _are_coordinates(robot: ClosedLoopRobot) -> bool:
    return robot.coordinates == robot.actuated


def _forces_of_motors(robot: ClosedLoopRobot, a: Any, v: Any, w: Any) -> dict[str, Any]:
    """Return the forces of motors that are not the coordinates, or why there are none."""
    from psp3.errors import UnreachableForces

    try:
        return {"actuator_forces": robot.actuator_forces(a, v, w)}
    except UnreachableForces as error:
        return {"actuator_forces": None, "why": str(error)}


def _show_of_thesis(M: Any, C: Any, G: Any, forces: Any) -> None:
    table = new_table("Equation of motion", "", "1", "2", "3", "unit")
    for name, rows, unit in (
        ("M", M, "kg"),
        ("C", C, "kg/s"),
        ("G", [G], "N"),
        ("forces", [forces], "N"),
    ):
        for number, row in enumerate(rows):
            table.add_row(name if number == 0 else "", *fixed(row), unit if number == 0 else "")
        table.add_section()
    show(table)


def _show(
    robot: ClosedLoopRobot,
    labels: list[str],
    M: Any,
    C: Any,
    G: Any,
    forces: Any,
    motors: dict[str, Any],
) -> None:
    # Numbered, because the names of many coordinates do not fit on a line.
    numbers = [str(number) for number in range(1, len(labels) + 1)]
    units = "kg, kg m or kg m², depending on whether the coordinates slide or turn"
    for name, matrix, note in (("M", M, units), ("C", C, f"{units}, per second")):
        largest = abs(matrix).max(initial=0.0)
        rows = [
            [number, label, *(plain_number(value, scale=largest) for value in row)]
            for number, label, row in zip(numbers, labels, matrix, strict=True)
        ]
        show_narrow(f"{name} of {robot.title}", ["", "coordinate", *numbers], rows, note)
    vector = new_table("Forces on the coordinates", "", "G", "M w + C v + G", "unit")
    for cells in zip(labels, fixed(G), fixed(forces), force_units(robot), strict=True):
        vector.add_row(*cells)
    show(vector)
    if not motors:
        return
    if motors["actuator_forces"] is None:
        show_text(motors["why"])
        return
    table = new_table("Forces of the motors, of least norm", "", "force")
    for name, value in zip(robot.actuated, fixed(motors["actuator_forces"]), strict=True):
        table.add_row(name, value)
    show(table)
