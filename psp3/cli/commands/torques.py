"""The command that turns a motion of the tip into screw forces."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from psp3.cli.option_groups import MotionOptions, OutputOptions, single_options
from psp3.cli.options import Model, Parameters, ParametersName, TrajectoryText
from psp3.cli.output import draw_figure, fixed, new_table, print_json, show, write_csv
from psp3.cli.shared import load_robot, trajectory_from_options


@single_options
def torques(
    *,
    trajectory: TrajectoryText = "helix",
    motion: MotionOptions,
    sampling_period: Annotated[
        float, typer.Option(metavar="S", help="Time between two samples (s).")
    ] = 0.01,
    model: Model = None,
    parameters: Parameters = ParametersName.DEFAULT,
    outputs: OutputOptions,
) -> None:
    """Turn a motion of the tip into screw forces.

    The nut heights and their rates come on the way: the thesis's inverse dynamics, Figures 27, 28
    and 31. Prints the extremes; all samples go to --csv, --json or --figure.
    """
    outputs.check()
    robot = load_robot(parameters)
    import numpy as np

    from psp3.checks import checked_positive
    from psp3.trajectories.screw_forces import screw_forces

    for name, value in (("duration", motion.duration), ("sampling period", sampling_period)):
        if value is not None:
            checked_positive(name, value)
    desired, seconds = trajectory_from_options(robot, trajectory, motion)
    # The small excess keeps rounding from losing the last sample.
    times = sampling_period * np.arange(int(seconds / sampling_period * (1.0 + 1e-12) + 1e-9) + 1)
    forces = screw_forces(
        desired, times, robot.dynamics(model.value) if model is not None else None
    )
    files = {}
    if outputs.csv is not None:
        write_csv(outputs.csv, forces.columns())
        files["csv"] = outputs.csv
    if outputs.figure is not None:
        from psp3.plots.three_psp import figure_of_torques

        draw_figure(outputs.figure, lambda: figure_of_torques(forces))
        files["figure"] = outputs.figure
    if outputs.json:
        print_json(
            {
                **forces.columns(),
                "trajectory": trajectory,
                "parameters": parameters.value,
                "units": "SI",
            }
        )
        return
    if outputs.csv == Path("-"):
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
