"""The command that maps the workspace."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from psp3.cli.option_groups import single_options
from psp3.cli.options import RIGHT_ANGLE, FigureFile, Json, listed, usage_error
from psp3.cli.output import draw_figure, fixed, new_table, print_json, say, show
from psp3.cli.robot_options import RobotOptions

if TYPE_CHECKING:
    from psp3.kinematics.pose_map import KinematicMap
    from psp3.kinematics.workspace import Reach, Workspace
    from psp3.robots.closed_loop_robot import ClosedLoopRobot

TILT, TIP = "tilt", "tip"
"""Quantities over which the 3-PSP's workspace is mapped."""

FARTHEST_TURN = 3.0
"""Rotations are followed up to this angle [rad]."""

FARTHEST = 3.0
"""Translations are followed up to this distance, in characteristic lengths of the robot."""

WELL = 1e-3
"""A task coordinate is independent if the motors move it by at least this share, apart from the
coordinates before it."""

SIDE = 21
"""Poses along a side of the map, for robots other than the 3-PSP."""

ENDS = {
    "limit": "limit of {}",
    "actuation": "singularity of actuation",
    "end_effector": "singularity of the end effector",
    "constraint": "singularity of the loops",
    "farthest": "not ended so far",
}


@single_options
def workspace(
    *,
    robot: RobotOptions,
    over: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help=(
                "3-PSP: tilt (default) maps the orientations of the star, tip maps the tip "
                "positions within reach. Other robots: two coordinates of the task, such as x,z."
            ),
        ),
    ] = None,
    largest_tilt: Annotated[
        float | None,
        typer.Option(
            metavar="DEGREES",
            help="3-PSP, over tilt: largest tilt (degrees), below 90; default 60.",
        ),
    ] = None,
    frame: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Other robots: the frame that moves; default tip."),
    ] = None,
    task: Annotated[
        str | None,
        typer.Option(
            metavar="NAME,NAME",
            help=(
                "Other robots: coordinates of the frame that the motors drive, from x, y, z, rx, "
                "ry and rz; default the first independent ones."
            ),
        ),
    ] = None,
    resolution: Annotated[
        int | None,
        typer.Option(
            min=2,
            max=1000,
            metavar="N",
            help=(
                "2 to 1000. 3-PSP: poses from the center to the border, default 60; twice as many "
                f"around. Other robots: poses along a side, default {SIDE}."
            ),
        ),
    ] = None,
    figure: FigureFile = None,
    json: Json = False,
) -> None:
    """Map the workspace: its limits, and the quality of its poses.

    For the 3-PSP the map holds tilt, parasitic motion, arm lengths and conditioning; for other
    robots limits, singularities and conditioning. Prints the extremes; the whole map goes to
    --figure or --json.
    """
    if robot.is_of_thesis:
        for option, value in (("--frame", frame), ("--task", task)):
            if value is not None:
                raise usage_error(f"{option} is for other robots; for the 3-PSP give --over")
        _check_tilt(over, largest_tilt)
        _map_of_thesis(robot, over or TILT, largest_tilt, resolution or 60, figure, json)
        return
    robot.refuse({"largest_tilt": largest_tilt})
    which = robot.load()
    space = _space(which, frame, task)
    names = _mapped(space, over)
    rays = _rays(space)
    poses = _map(space, rays, names, resolution or SIDE)
    if figure is not None:
        draw_figure(figure, lambda: _figure(space, poses))
    if json:
        _print(which, space, rays, poses)
        return
    _show(which, space, rays, poses)
    if figure is not None:
        say(figure)


# The 3-PSP


def _check_tilt(over: str | None, largest_tilt: float | None) -> None:
    if over not in (None, TILT, TIP):
        raise usage_error(f"--over must be {TILT} or {TIP} for the 3-PSP, got {over!r}")
    if over == TIP and largest_tilt is not None:
        raise usage_error(
            "--largest-tilt does not apply to --over tip, which ends where the tip folds"
        )
    if largest_tilt is not None and not 0.0 < largest_tilt < RIGHT_ANGLE:
        raise usage_error(
            f"--largest-tilt must be positive and less than {RIGHT_ANGLE:g} degrees, got "
            f"{largest_tilt:g}"
        )


def _map_of_thesis(
    options: RobotOptions,
    over: str,
    largest_tilt: float | None,
    resolution: int,
    figure: Path | None,
    json: bool,
) -> None:
    robot = options.load_of_thesis()
    import numpy as np

    from psp3.three_psp import workspace as study

    around = np.radians(np.linspace(-180.0, 180.0, 2 * resolution + 1))
    outward = np.linspace(0.0, 1.0, resolution)[:, np.newaxis]
    if over == TILT:
        poses = study.map_over_tilt(
            robot, np.radians(60.0 if largest_tilt is None else largest_tilt) * outward, around
        )
    else:
        poses = study.map_over_reach(robot, outward, around)
    # Multiples of 5 degrees include the six directions in which all quantities have their extremes.
    directions = np.radians(np.arange(-180.0, 181.0, 5.0))
    fold, border, ends = (
        study.fold_tilt(robot, directions),
        study.reach_boundary(robot, directions),
        study.largest_tilt(directions),
    )
    reach = np.hypot(border[:, 0], border[:, 1])
    if figure is not None:
        from psp3.plots.three_psp import figure_of_workspace

        draw_figure(figure, lambda: figure_of_workspace(robot, poses, over))
    if json:
        content: dict[str, Any] = {
            "over": over,
            "parameters": options.parameter_set,
            "units": {"length": "m", "angle": "degrees"},
        }
        content["border"] = {
            "azimuth": np.degrees(directions),
            "fold_tilt": np.degrees(fold),
            "largest_tilt": np.degrees(ends),
            "tip": border,
        }
        content["reach"] = {"least": reach.min(), "greatest": reach.max()}
        names = (
            "heights",
            "center",
            "parasitic_motion",
            "arms",
            "tip",
            "tip_condition",
            "mass_condition",
            "actuation_determinant",
            "travel",
        )
        content["map"] = {"tilt": np.degrees(poses.tilt), "azimuth": np.degrees(poses.azimuth)}
        print_json(
            content | {"map": content["map"] | {name: getattr(poses, name) for name in names}}
        )
        return
    which = f"tilt up to {np.degrees(poses.tilt.max()):g}°" if over == TILT else "tip within reach"
    table = new_table(f"Workspace: {which}", "", "least", "greatest", "unit")
    for name, values, unit, digits in (
        ("tilt", np.degrees(poses.tilt[~np.isnan(poses.travel)]), "degrees", 2),
        (
            "tip from the vertical axis",
            1e3 * np.hypot(poses.tip[..., 0], poses.tip[..., 1]),
            "mm",
            2,
        ),
        ("parasitic motion", 1e3 * poses.parasitic_motion, "mm", 2),
        ("arm lengths", 1e3 * poses.arms, "mm", 2),
        (
            "condition of the tip Jacobian",
            np.where(poses.tilt < fold.min(), poses.tip_condition, np.inf),
            "",
            3,
        ),
        ("condition of the mass matrix", poses.mass_condition, "", 3),
        ("actuation determinant", poses.actuation_determinant, "m³", 5),
        ("vertical travel left by the stroke", 1e3 * poses.travel, "mm", 1),
    ):
        table.add_row(name, *fixed([np.nanmin(values), np.nanmax(values)], digits), unit)
    table.add_section()
    for name, values, unit in (
        ("border: tilt at which the tip folds", np.degrees(fold), "degrees"),
        ("border: reach of the tip", 1e3 * reach, "mm"),
        ("border: tilt at which an arm vanishes", np.degrees(ends), "degrees"),
    ):
        table.add_row(name, *fixed([values.min(), values.max()], 2), unit)
    show(table)
    if figure is not None:
        say(figure)


# Any other robot


def _space(robot: ClosedLoopRobot, frame: str | None, task: str | None) -> Workspace:
    """Return the workspace of a frame."""
    from psp3.kinematics.tasks import checked_motors
    from psp3.kinematics.workspace import Workspace

    checked_motors(robot)
    if frame is None:
        if not robot.model.existFrame("tip"):
            raise usage_error(f"{robot.title} has no frame tip: give --frame, a body or a site")
        frame = "tip"
    names = _driven(robot, frame) if task is None else tuple(map(str.strip, task.split(",")))
    return Workspace(robot, frame, names)


def _driven(robot: ClosedLoopRobot, frame: str) -> tuple[str, ...]:
    """Return the first independent coordinates of a frame, as many as the motors command."""
    import numpy as np

    from psp3.kinematics.tasks import TASK_COORDINATES, characteristic_length

    jacobian = np.array(robot.frame_jacobian(robot.reference, frame))
    jacobian[3:] *= characteristic_length(robot)
    largest = np.linalg.norm(jacobian, 2)
    chosen: list[int] = []
    for row in range(len(TASK_COORDINATES)):
        values = np.linalg.svd(jacobian[[*chosen, row]], compute_uv=False)
        if len(chosen) < robot.commanded and values[-1] > WELL * largest:
            chosen.append(row)
    names = tuple(TASK_COORDINATES[row] for row in chosen)
    if len(names) < robot.commanded:
        raise usage_error(
            f"the motors of {robot.title} move {frame} in "
            f"{listed(names) if names else 'no coordinate'} only: give a --frame that moves in as "
            f"many coordinates as they command, {robot.commanded}"
        )
    return names


def _mapped(space: Workspace, over: str | None) -> tuple[str, ...]:
    """Return the coordinates of the map: two, or one if there is only one."""
    if over is None:
        # Two lengths or two angles if possible, because only their map has a border and an area.
        for unit in ("m", "rad"):
            alike = [name for name in space.coordinates if space.units[name] == unit]
            if len(alike) > 1:
                return (alike[0], alike[1])
        return space.coordinates[:2]
    names = tuple(map(str.strip, over.split(",")))
    if len(set(names)) != min(2, len(space.coordinates)) or not set(names) <= {*space.coordinates}:
        raise usage_error(
            f"--over must be two of {', '.join(space.coordinates)}, separated by a comma, got "
            f"{over!r}"
        )
    return names


def _rays(space: Workspace) -> dict[str, tuple[Reach, Reach]]:
    """Return how far each coordinate can decrease and increase from the reference pose."""
    farthest = {"m": FARTHEST * space.analysis.length, "rad": FARTHEST_TURN}
    return {
        name: (
            space.distance({name: -1.0}, farthest[space.units[name]]),
            space.distance({name: 1.0}, farthest[space.units[name]]),
        )
        for name in space.coordinates
    }


def _map(
    space: Workspace, rays: dict[str, tuple[Reach, Reach]], names: tuple[str, ...], side: int
) -> KinematicMap:
    """Map around the reference pose, slightly beyond the ends of the rays."""
    import numpy as np

    def values(name: str) -> Any:
        down, up = (ray.distance for ray in rays[name])
        beyond = 0.2 * (down + up) or 0.1 * space.analysis.length
        here = space.reference[name]
        return np.linspace(here - down - beyond, here + up + beyond, side)

    return space.map({name: values(name) for name in names})


def _border(space: Workspace, poses: KinematicMap) -> Any:
    """Return the border of the usable poses; None if it encloses no area."""
    if len(poses.grid) != 2 or len({poses.units[name] for name in poses.grid}) != 1:
        return None
    return space.boundary(poses)


def _figure(space: Workspace, poses: KinematicMap) -> Any:
    from psp3.plots.workspace import figure_of_map

    if len(poses.grid) != 2:
        raise usage_error("--figure needs a map over two coordinates; this robot's task has one")
    return figure_of_map(poses, _border(space, poses))


def _end(ray: Reach) -> str:
    return ENDS[ray.ends].format(ray.joint)


def _print(
    robot: ClosedLoopRobot,
    space: Workspace,
    rays: dict[str, tuple[Reach, Reach]],
    poses: KinematicMap,
) -> None:
    border = _border(space, poses)
    print_json(
        {
            "robot": robot.title,
            "frame": poses.frame,
            "task": poses.task,
            "reference": space.reference,
            "reach": {
                name: [{"distance": ray.distance, "ends": _end(ray)} for ray in both]
                for name, both in rays.items()
            },
            "grid": poses.grid,
            "map": poses.arrays(),
            "border": None if border is None else border.segments,
            "area": None if border is None else border.area,
            "units": poses.units,
        }
    )


def _show(
    robot: ClosedLoopRobot,
    space: Workspace,
    rays: dict[str, tuple[Reach, Reach]],
    poses: KinematicMap,
) -> None:
    import numpy as np

    reach = new_table(
        f"Reach of {poses.frame} of {robot.title} from the reference pose",
        "",
        "from",
        "down to",
        "up to",
        "unit",
        "what ends it",
    )
    for name, (down, up) in rays.items():
        here = space.reference[name]
        reach.add_row(
            name,
            *fixed([here, here - down.distance, here + up.distance], 4),
            space.units[name],
            f"{_end(down)}; {_end(up)}",
        )
    usable = poses.usable
    over = " and ".join(poses.grid)
    table = new_table(f"Map over {over}", "", "least", "greatest", "unit")
    for name, values, unit, factor in (
        ("condition of the Jacobian", poses.measures.condition, "", 1.0),
        ("actuation", poses.measures.actuation, "", 1.0),
        ("end effector", poses.measures.end_effector, "", 1.0),
        ("distance of joints from limits", poses.margin, "mm", 1e3),
    ):
        here = factor * values[usable]
        cells = ["–", "–"] if not here.size else fixed([np.nanmin(here), np.nanmax(here)], 4)
        table.add_row(f"{name}, usable poses", *cells, unit)
    border = _border(space, poses)
    area = "" if border is None else _area(border.area, poses)
    table.caption = f"{np.count_nonzero(usable)} of {usable.size} poses are usable{area}"
    show(reach, table)


def _area(area: float, poses: KinematicMap) -> str:
    unit = poses.units[next(iter(poses.grid))]
    return f"; their area is {area:.4g} {unit}²"
