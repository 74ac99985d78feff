"""The command that maps the workspace."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from psp3.cli.options import (
    RIGHT_ANGLE,
    FigureFile,
    Json,
    Over,
    Parameters,
    ParametersName,
    usage_error,
)
from psp3.cli.output import draw_figure, fixed, new_table, print_json, show
from psp3.cli.shared import load_robot


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
