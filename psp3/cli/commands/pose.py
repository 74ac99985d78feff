"""The command that solves the kinematics of one pose."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from psp3.cli.compilation import one_off
from psp3.cli.joint_tables import joint_rows, position_labels
from psp3.cli.option_groups import single_options
from psp3.cli.options import (
    RIGHT_ANGLE,
    Json,
    Numbers,
    Positions,
    Triple,
    of_each,
    triple,
    usage_error,
)
from psp3.cli.output import fixed, new_table, plain_number, print_json, show
from psp3.cli.robot_options import RobotOptions

if TYPE_CHECKING:
    from psp3.robots.closed_loop_robot import ClosedLoopRobot
    from psp3.three_psp.robot import PSP3


@single_options
@one_off
def pose(
    *,
    robot: RobotOptions,
    positions: Positions = None,
    frame: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help=(
                "Robots other than the 3-PSP: print the place of this frame; default tip if there "
                "is one; may be given more than once."
            ),
        ),
    ] = None,
    tip: Annotated[
        Triple | None,
        typer.Option(
            parser=triple, metavar="X,Y,Z", help="3-PSP, inverse: position of the tip (m)."
        ),
    ] = None,
    height: Annotated[
        float | None,
        typer.Option(
            metavar="M",
            help="3-PSP, inverse: height of the star's center (m); default 0 with --tilt.",
        ),
    ] = None,
    tilt: Annotated[
        float | None,
        typer.Option(
            metavar="DEGREES",
            help="3-PSP, inverse: tilt of the star's axis (degrees); default 0 with --height.",
        ),
    ] = None,
    azimuth: Annotated[
        float | None,
        typer.Option(
            metavar="DEGREES",
            help="3-PSP, inverse: direction in which the star leans (degrees); default 0.",
        ),
    ] = None,
    json: Json = False,
) -> None:
    """Solve the kinematics of one pose.

    Forward kinematics from --positions. For the 3-PSP also inverse kinematics, from --tip, or from
    --height, --tilt and --azimuth.
    """
    if not robot.is_of_thesis:
        robot.refuse(
            {"tip": tip, "height": height, "tilt": tilt, "azimuth": azimuth},
            ", of which --positions are known",
        )
        _pose_of_any(robot, positions, frame or [], json)
        return
    leaning = [value for value in (height, tilt, azimuth) if value is not None]
    if frame:
        raise usage_error(
            "--frame is for other robots; for the 3-PSP the star and the tip are always shown"
        )
    if (positions is not None) + (tip is not None) + bool(leaning) != 1:
        raise usage_error("give one of --heights, --tip, or --height with --tilt and --azimuth")
    if tilt is not None and not abs(tilt) < RIGHT_ANGLE:
        raise usage_error(f"--tilt must be less than {RIGHT_ANGLE:g} degrees, got {tilt:g}")
    import numpy as np

    psp3 = robot.load_of_thesis()
    if positions is not None:
        a = np.array(of_each("--heights", positions, psp3.actuated))
    elif tip is not None:
        a = psp3.inverse_kinematics_tip(tip)
    else:
        a = psp3.inverse_kinematics(height or 0.0, *np.radians([tilt or 0.0, azimuth or 0.0]))
    _pose_of_thesis(psp3, a, json)


def _pose_of_thesis(robot: PSP3, a: Any, json: bool) -> None:
    import numpy as np

    from psp3.three_psp.workspace import map_at_heights

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
        table.add_row(name, plain_number(float(value)), "", "", unit)
    if not inside:
        table.caption = (
            f"Outside the stroke, {lower[0]:g} m to {upper[0]:g} m: the robot cannot reach this "
            "pose."
        )
    show(table)


def _pose_of_any(
    options: RobotOptions, positions: Numbers | None, frames: list[str], json: bool
) -> None:
    robot = options.load()
    given = (
        robot.reference
        if positions is None
        else of_each("--positions", positions, position_labels(robot))
    )
    q = robot.configuration(given)
    if not frames and robot.model.existFrame("tip"):
        frames = ["tip"]
    placements = {name: robot.frame_placement(given, name) for name in dict.fromkeys(frames)}
    rows = joint_rows(robot, q)
    inside = all(row.is_within for row in rows)
    if json:
        print_json(
            {
                "robot": robot.title,
                "coordinates": robot.coordinates,
                "positions": given,
                "joints": {row.joint: row.values for row in rows},
                "frames": placements,
                "within_limits": inside,
                "units": {"length": "m", "angle": "rad"},
            }
        )
        return
    show(_table_of_joints(robot, rows, inside), *_table_of_frames(placements))


def _table_of_joints(robot: ClosedLoopRobot, rows: list[Any], inside: bool) -> Any:
    table = new_table(f"Pose of {robot.title}", "joint", "position", "unit", "role")
    for row in rows:
        table.add_row(row.joint, "\n".join(fixed(row.values)), row.unit, row.role)
    if not inside:
        beyond = ", ".join(row.joint for row in rows if not row.is_within)
        table.caption = f"Outside the limits of {beyond}: the robot cannot reach this pose."
    return table


def _table_of_frames(placements: dict[str, Any]) -> list[Any]:
    if not placements:
        return []
    table = new_table("Frames in base axes", "", "x", "y", "z", "unit")
    for name, placement in placements.items():
        table.add_row(f"{name}: origin", *fixed(placement[:3, 3]), "m")
        for axis, letter in enumerate("xyz"):
            table.add_row(f"its {letter} axis", *fixed(placement[:3, axis]), "")
        table.add_section()
    return [table]
