"""Commands about the robot in one state: its pose and its equation of motion."""

from __future__ import annotations

from typing import Annotated

import typer

from psp3.cli.options import (
    RIGHT_ANGLE,
    Heights,
    Json,
    Parameters,
    ParametersName,
    Triple,
    triple,
    usage_error,
)
from psp3.cli.output import fixed, new_table, print_json, show
from psp3.cli.shared import load_robot


def pose(
    heights: Annotated[
        Triple | None,
        typer.Option(
            parser=triple, metavar="A1,A2,A3", help="Forward: the pose at these nut heights (m)."
        ),
    ] = None,
    tip: Annotated[
        Triple | None,
        typer.Option(
            parser=triple, metavar="X,Y,Z", help="Inverse: the pose with the tip here (m)."
        ),
    ] = None,
    height: Annotated[
        float | None,
        typer.Option(metavar="M", help="Inverse: height of the star's center (m); 0 with --tilt."),
    ] = None,
    tilt: Annotated[
        float | None,
        typer.Option(
            metavar="DEGREES", help="Inverse: tilt of the star's axis (degrees); 0 with --height."
        ),
    ] = None,
    azimuth: Annotated[
        float | None,
        typer.Option(
            metavar="DEGREES", help="Inverse: where the star leans to (degrees); 0 unless given."
        ),
    ] = None,
    parameters: Parameters = ParametersName.DEFAULT,
    json: Json = False,
) -> None:
    """Solve the kinematics of one pose.

    Forward from --heights; inverse from --tip, or from --height, --tilt and --azimuth.
    """
    leaning = [value for value in (height, tilt, azimuth) if value is not None]
    if (heights is not None) + (tip is not None) + bool(leaning) != 1:
        raise usage_error("give one of --heights, --tip, or --height with --tilt and --azimuth")
    if tilt is not None and not abs(tilt) < RIGHT_ANGLE:
        raise usage_error(f"--tilt must be less than {RIGHT_ANGLE:g} degrees, got {tilt:g}")
    robot = load_robot(parameters)
    import numpy as np

    from psp3.three_psp.workspace import map_at_heights

    if heights is not None:
        a = np.array(heights)
    elif tip is not None:
        a = robot.inverse_kinematics_tip(tip)
    else:
        a = robot.inverse_kinematics(height or 0.0, *np.radians([tilt or 0.0, azimuth or 0.0]))
    here, rotation = map_at_heights(robot, a), robot.forward_kinematics(a).rotation
    angles = np.degrees([here.tilt, here.azimuth])
    lower, upper = robot.stroke
    inside = bool(((a >= lower) & (a <= upper)).all())
    if json:
        content = {
            "heights": a,
            "center": here.center,
            "rotation": rotation,
            "arms": here.arms,
            "tip": here.tip,
        }
        content |= {
            "tilt": angles[0],
            "azimuth": angles[1],
            "parasitic_motion": here.parasitic_motion,
            "tip_condition": here.tip_condition,
        }
        print_json(
            content | {"within_stroke": inside, "units": {"length": "m", "angle": "degrees"}}
        )
        return
    table = new_table("Pose", "", "1, x", "2, y", "3, z", "unit")
    for name, values in (
        ("nut heights", a),
        ("arm lengths", here.arms),
        ("center of the star", here.center),
        ("tip", here.tip),
    ):
        table.add_row(name, *fixed(values), "m")
    table.add_row("axis of the star", *fixed(rotation[:, 2]), "")
    table.add_section()
    for name, value, unit in (
        ("tilt", angles[0], "degrees"),
        ("azimuth", angles[1], "degrees"),
        ("parasitic motion", here.parasitic_motion, "m"),
        ("condition of the tip Jacobian", here.tip_condition, ""),
    ):
        table.add_row(name, f"{value + 0.0:.6g}", "", "", unit)
    if not inside:
        table.caption = (
            f"Outside the stroke, {lower[0]:g} m to {upper[0]:g} m: the machine cannot take this "
            "pose."
        )
    show(table)


def dynamics(
    heights: Heights,
    speeds: Annotated[
        Triple | None,
        typer.Option(
            parser=triple, metavar="V1,V2,V3", help="Nut speeds v (m/s); 0,0,0 unless given."
        ),
    ] = None,
    accelerations: Annotated[
        Triple | None,
        typer.Option(
            parser=triple,
            metavar="W1,W2,W3",
            help="Nut accelerations w (m/s²); 0,0,0 unless given.",
        ),
    ] = None,
    parameters: Parameters = ParametersName.DEFAULT,
    json: Json = False,
) -> None:
    """Evaluate the equation of motion at one state.

    Prints M, C, G and the screw forces. The forces are M w + C v + G at the heights, speeds v and
    accelerations w that are given.
    """
    robot = load_robot(parameters)
    rest = Triple(0.0, 0.0, 0.0)
    v, w = (rest if values is None else values for values in (speeds, accelerations))
    M, C, G = robot.equation_of_motion(heights, v)
    forces = robot.inverse_dynamics(heights, v, w)
    if json:
        print_json(
            {
                "heights": heights,
                "speeds": v,
                "accelerations": w,
                "M": M,
                "C": C,
                "G": G,
                "forces": forces,
                "parameters": parameters.value,
                "units": "SI",
            }
        )
        return
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
