"""The command that computes the forces for a motion."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from psp3.cli.joint_tables import commanded_joints, joint_units
from psp3.cli.option_groups import MotionOptions, OutputOptions, single_options
from psp3.cli.options import Model, TrajectoryText
from psp3.cli.output import draw_figure, fixed, new_table, print_json, say, show, write_csv
from psp3.cli.robot_options import RobotOptions
from psp3.cli.shared import trajectory_from_options

if TYPE_CHECKING:
    from psp3.robots.closed_loop_robot import ClosedLoopRobot
    from psp3.trajectories.screw_forces import ScrewForces

MOST_SAMPLES = 10**7
"""Greatest number of samples that fits into memory with all values of each."""


@single_options
def torques(
    *,
    robot: RobotOptions,
    trajectory: TrajectoryText = None,
    motion: MotionOptions,
    sampling_period: Annotated[
        float, typer.Option(metavar="S", help="Time between samples (s).")
    ] = 0.01,
    model: Model = None,
    outputs: OutputOptions,
) -> None:
    """Compute the forces of the motors for a motion.

    For the 3-PSP the motion is that of the tip, and nut heights and their rates are computed as
    well: the thesis's inverse dynamics, Figures 27, 28 and 31. Prints the extremes; all samples go
    to --csv, --json or --figure.
    """
    outputs.check()
    which = robot.load()
    import numpy as np

    from psp3.checks import check_periods, checked_positive
    from psp3.errors import InvalidValue
    from psp3.trajectories.screw_forces import screw_forces

    for name, value in (("duration", motion.duration), ("sampling period", sampling_period)):
        if value is not None:
            checked_positive(name, value)
    desired, seconds, name_of_motion = trajectory_from_options(which, trajectory, motion)
    check_periods(seconds, sampling_period, MOST_SAMPLES)
    if sampling_period > seconds:
        raise InvalidValue(
            "sampling period", sampling_period, f"at most the duration, {seconds:g} s"
        )
    # The small excess keeps the last sample in spite of rounding.
    times = sampling_period * np.arange(int(seconds / sampling_period * (1.0 + 1e-12) + 1e-9) + 1)
    forces = screw_forces(
        desired, times, which.dynamics(model.value) if model is not None else None
    )
    files = {}
    if outputs.csv is not None:
        write_csv(outputs.csv, forces.columns())
        files["csv"] = outputs.csv
    if outputs.figure is not None:
        draw_figure(outputs.figure, lambda: _figure(which, forces, name_of_motion))
        files["figure"] = outputs.figure
    if outputs.json:
        print_json(
            {
                **forces.columns(),
                "trajectory": name_of_motion,
                **robot.identity(which),
                "units": "SI",
            }
        )
        return
    if outputs.csv == Path("-"):
        return
    title = f"{name_of_motion}: {times.size} samples over {times[-1]:g} s"
    show(
        _table_of_thesis(title, forces)
        if which.has_inverse_of_tip
        else _table_of_joints(title, which, forces)
    )
    for path in files.values():
        say(path)


def _figure(robot: ClosedLoopRobot, forces: ScrewForces, title: str) -> Any:
    if robot.has_inverse_of_tip:
        from psp3.plots.three_psp import figure_of_torques

        return figure_of_torques(forces)
    from fuzzy2.plots.names import literal
    from psp3.plots.joints import figure_of_joint_forces

    return figure_of_joint_forces(robot, forces, literal(f"{robot.title}, {title}"))


def _table_of_joints(title: str, robot: ClosedLoopRobot, forces: ScrewForces) -> Any:
    table = new_table(title, "joint", "", "least", "greatest", "unit")
    motion, joints, motors = forces.motion, commanded_joints(robot), robot.actuated
    rows = [
        (name, what, values[:, number], unit + of_rate)
        for number, (name, unit) in enumerate(zip(joints, joint_units(robot, joints), strict=True))
        for what, values, of_rate in (
            ("position", motion.positions, ""),
            ("speed", motion.speeds, "/s"),
            ("acceleration", motion.accelerations, "/s²"),
        )
    ]
    rows += [
        (name, "force", column, {"rad": "N m", "m": "N"}.get(unit, ""))
        for name, column, unit in zip(
            motors, forces.forces.T, joint_units(robot, motors), strict=True
        )
    ]
    order = list(dict.fromkeys((*joints, *motors)))
    last = None
    for name, what, column, unit in sorted(rows, key=lambda row: order.index(row[0])):
        if last not in (None, name):
            table.add_section()
        shown = "" if name == last else name
        table.add_row(shown, what, *fixed([column.min(), column.max()], 4), unit)
        last = name
    return table


def _table_of_thesis(title: str, forces: ScrewForces) -> Any:
    table = new_table(title, "", "", "1, x", "2, y", "3, z", "unit")
    for name, values, unit, factor in (
        ("tip", forces.motion.tip, "mm", 1e3),
        ("nut heights", forces.motion.heights, "mm", 1e3),
        ("nut speeds", forces.motion.speeds, "mm/s", 1e3),
        ("nut accelerations", forces.motion.accelerations, "m/s²", 1.0),
        ("screw forces", forces.forces, "N", 1.0),
    ):
        table.add_row(name, "least", *fixed(factor * values.min(axis=0), 2), unit)
        table.add_row("", "greatest", *fixed(factor * values.max(axis=0), 2), "")
    return table
