"""Commands about the robot: forces along a path, poses, dynamics, workspace, versions."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from psp3.cli.options import (
    RIGHT_ANGLE,
    CsvFile,
    Duration,
    End,
    FigureFile,
    Heights,
    HoldTip,
    Json,
    Model,
    OutputFigure,
    OutputJson,
    Over,
    Parameters,
    ParametersName,
    Radius,
    Rise,
    Start,
    StartHeight,
    TrajectoryText,
    TravelTime,
    Triple,
    TurnTime,
    triple,
    usage_error,
)
from psp3.cli.output import (
    check_outputs,
    draw_figure,
    fixed,
    new_table,
    print_json,
    show,
    write_csv,
)
from psp3.cli.shared import load_robot, trajectory_from_options


def torques(
    trajectory: TrajectoryText = "helix",
    radius: Radius = None,
    turn_time: TurnTime = None,
    rise: Rise = None,
    start_height: StartHeight = None,
    start: Start = None,
    end: End = None,
    travel_time: TravelTime = None,
    tip: HoldTip = None,
    duration: Duration = None,
    sampling_period: Annotated[
        float, typer.Option(metavar="S", help="Time between two samples (s).")
    ] = 0.01,
    model: Model = None,
    parameters: Parameters = ParametersName.DEFAULT,
    csv: CsvFile = None,
    figure: OutputFigure = None,
    json: OutputJson = False,
) -> None:
    """Turn a motion of the tip into screw forces.

    The nut heights and their rates come on the way: the thesis's inverse dynamics, Figures 27, 28
    and 31. Prints the extremes; all samples go to --csv, --json or --figure.
    """
    check_outputs(csv, json)
    robot = load_robot(parameters)
    import numpy as np

    from psp3.checks import checked_positive
    from psp3.trajectories.screw_forces import screw_forces

    for name, value in (("duration", duration), ("sampling period", sampling_period)):
        if value is not None:
            checked_positive(name, value)
    given = {
        "radius": radius,
        "turn_time": turn_time,
        "rise": rise,
        "start_height": start_height,
        "start": start,
        "end": end,
        "travel_time": travel_time,
        "tip": tip,
    }
    motion, seconds = trajectory_from_options(robot, trajectory, duration, given)
    # The small excess keeps rounding from losing the last sample.
    times = sampling_period * np.arange(int(seconds / sampling_period * (1.0 + 1e-12) + 1e-9) + 1)
    forces = screw_forces(motion, times, robot.dynamics(model.value) if model is not None else None)
    files = {}
    if csv is not None:
        write_csv(csv, forces.columns())
        files["csv"] = csv
    if figure is not None:
        from psp3.plots.three_psp import figure_of_torques

        draw_figure(figure, lambda: figure_of_torques(forces))
        files["figure"] = figure
    if json:
        print_json(
            {
                **forces.columns(),
                "trajectory": trajectory,
                "parameters": parameters.value,
                "units": "SI",
            }
        )
        return
    if csv == Path("-"):
        return
    table = new_table(
        f"{trajectory}: {times.size} samples over {times[-1]:g} s",
        "",
        "",
        "1, x",
        "2, y",
        "3, z",
        "unit",
    )
    for name, values, unit, factor in (
        ("tip", forces.motion.tip, "mm", 1e3),
        ("nut heights", forces.motion.heights, "mm", 1e3),
        ("nut speeds", forces.motion.speeds, "mm/s", 1e3),
        ("nut accelerations", forces.motion.accelerations, "m/s²", 1.0),
        ("screw forces", forces.forces, "N", 1.0),
    ):
        table.add_row(name, "least", *fixed(factor * values.min(axis=0), 2), unit)
        table.add_row("", "greatest", *fixed(factor * values.max(axis=0), 2), "")
    show(table)
    for path in files.values():
        typer.echo(path)


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


def workspace(
    over: Annotated[
        Over,
        typer.Option(
            metavar="NAME",
            help="tilt maps the orientations of the star, tip the tip positions within reach.",
        ),
    ] = Over.TILT,
    largest_tilt: Annotated[
        float | None,
        typer.Option(
            metavar="DEGREES", help="Over tilt: largest tilt (degrees), below 90; 60 unless given."
        ),
    ] = None,
    resolution: Annotated[
        int,
        typer.Option(
            min=2,
            max=1000,
            metavar="N",
            help="Poses from the middle to the border; twice as many around.",
        ),
    ] = 60,
    parameters: Parameters = ParametersName.DEFAULT,
    figure: FigureFile = None,
    json: Json = False,
) -> None:
    """Map what the poses cost, and where they end.

    The map holds tilt, parasitic motion, arm lengths and conditioning. Prints the extremes; the
    whole map goes to --figure or --json.
    """
    if over is Over.TIP and largest_tilt is not None:
        raise usage_error(
            "--largest-tilt does not apply to --over tip, which ends where the tip folds"
        )
    if largest_tilt is not None and not 0.0 < largest_tilt < RIGHT_ANGLE:
        raise usage_error(
            f"--largest-tilt must be positive and less than {RIGHT_ANGLE:g} degrees, got "
            f"{largest_tilt:g}"
        )
    robot = load_robot(parameters)
    import numpy as np

    from psp3.three_psp import workspace as study

    around = np.radians(np.linspace(-180.0, 180.0, 2 * resolution + 1))
    outward = np.linspace(0.0, 1.0, resolution)[:, np.newaxis]
    if over is Over.TILT:
        poses = study.map_over_tilt(
            robot, np.radians(60.0 if largest_tilt is None else largest_tilt) * outward, around
        )
    else:
        poses = study.map_over_reach(robot, outward, around)
    # Multiples of 5 degrees hold the six directions in which everything is extreme.
    directions = np.radians(np.arange(-180.0, 181.0, 5.0))
    fold, border, ends = (
        study.fold_tilt(robot, directions),
        study.reach_boundary(robot, directions),
        study.largest_tilt(directions),
    )
    reach = np.hypot(border[:, 0], border[:, 1])
    if figure is not None:
        from psp3.plots.three_psp import figure_of_workspace

        draw_figure(figure, lambda: figure_of_workspace(robot, poses, over.value))
    if json:
        content: dict[str, Any] = {
            "over": over.value,
            "parameters": parameters.value,
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
    which = (
        f"tilt up to {np.degrees(poses.tilt.max()):g}°" if over is Over.TILT else "tip within reach"
    )
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
        typer.echo(figure)


def info(json: Json = False) -> None:
    """Show versions, joints, loops, reach, parameter sets and the other robots."""
    import platform
    from dataclasses import asdict
    from importlib.metadata import PackageNotFoundError, version

    import numpy as np

    from psp3.description.loop_file import read_loops
    from psp3.description.parts import ROBOT_FILES, ROBOTS
    from psp3.loading import load
    from psp3.three_psp.parameters import PARAMETER_SETS
    from psp3.version import __version__

    versions = {"psp3": __version__, "python": platform.python_version()}
    for package in ("pin", "numpy", "scipy", "numba", "meshcat", "matplotlib", "typer", "rich"):
        try:
            versions[package] = version(package)
        except PackageNotFoundError:
            versions[package] = "not installed"
    robot = load("psp3")
    loops = read_loops(ROBOT_FILES / "psp3.yaml")
    (lower, *_), (upper, *_) = (bounds.tolist() for bounds in robot.stroke)
    least, greatest = robot.tip_reach(np.radians([0.0, 60.0])).tolist()
    joints = [
        {
            "name": str(name),
            "type": {"JointModelPZ": "slides along z", "JointModelPX": "slides along x"}.get(
                joint.shortname(), joint.shortname()
            ),
            "actuated": name in robot.actuated,
            "lower": float(robot.model.lowerPositionLimit[joint.idx_q]),
            "upper": float(robot.model.upperPositionLimit[joint.idx_q]),
        }
        for name, joint in list(zip(robot.model.names, robot.model.joints, strict=True))[1:]
    ]
    sets = {
        name: asdict(numbers) | {"total_mass": numbers.total_mass}
        for name, numbers in PARAMETER_SETS.items()
    }
    if json:
        content = {
            "versions": versions,
            "files": str(ROBOT_FILES),
            "joints": joints,
            "stroke": {"lower": lower, "upper": upper},
        }
        content["loops"] = [
            {"frames": frames, "kind": kind}
            for frames, kind in zip(loops.frames, loops.kinds, strict=True)
        ]
        print_json(
            content
            | {
                "robots": ROBOTS,
                "tip_reach": {"least": least, "greatest": greatest},
                "parameters": sets,
                "units": "SI",
            }
        )
        return
    about = new_table("Robot", "", "")
    about.show_header, about.columns[1].justify = False, "left"
    about.add_row("versions", ", ".join(f"{name} {number}" for name, number in versions.items()))
    about.add_row("files", str(ROBOT_FILES))
    about.add_row("actuated joints", ", ".join(robot.actuated))
    about.add_row(
        "passive joints", ", ".join(str(joint["name"]) for joint in joints if not joint["actuated"])
    )
    about.add_row(
        "loops",
        ", ".join(
            f"{one} = {other} ({kind})"
            for (one, other), kind in zip(loops.frames, loops.kinds, strict=True)
        ),
    )
    about.add_row("stroke", f"{lower:g} m to {upper:g} m")
    about.add_row(
        "other robots",
        ", ".join(name for name in ROBOTS if name != "psp3") + " (psp3.load in Python)",
    )
    about.add_row(
        "reach of the tip",
        (
            f"{1e3 * least:.1f} mm at azimuth 0°, {1e3 * greatest:.1f} mm at 60°, from the "
            "vertical axis"
        ),
    )
    table = new_table("Parameter sets", "", *sets)
    units = {"gravity": "m/s²", "total_mass": "kg", "screw_radius": "m", "tool_length": "m"}
    for name in next(iter(sets.values())):
        unit = units.get(name, "kg m²" if name.endswith("inertia") else "kg")
        cells = [
            "\n".join(f"{number:.6g}" for number in np.ravel(numbers[name]))
            for numbers in sets.values()
        ]
        table.add_row(f"{name.replace('_', ' ')} ({unit})", *cells)
    show(about, table)
