"""The command that runs a controller."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fuzzy2.support.deferred_compilation import deferred_compilation
from psp3.cli.joint_tables import commanded_joints, joint_units, what_follows
from psp3.cli.option_groups import GainOptions, MotionOptions, OutputOptions, single_options
from psp3.cli.options import (
    OUTPUT,
    USAGE,
    ControllerName,
    InitialSpeed,
    Model,
    TorqueLimit,
    TrajectoryText,
    file_path,
    listed,
    one_or_each,
    only_allowed,
    result_output,
)
from psp3.cli.output import (
    draw_figure,
    error_message,
    fixed,
    new_table,
    print_json,
    progress_bar,
    say,
    show,
    show_text,
    write_csv,
)
from psp3.cli.robot_options import RobotOptions
from psp3.cli.shared import (
    controller_from_file,
    controller_named,
    trajectory_from_options,
)

if TYPE_CHECKING:
    from psp3.robots.closed_loop_robot import ClosedLoopRobot
    from psp3.simulation.result import Result
    from psp3.trajectories.trajectory import Trajectory


@single_options
@deferred_compilation()
def simulate(
    *,
    robot: RobotOptions,
    controller: Annotated[
        ControllerName | None,
        typer.Option(
            metavar="NAME",
            help=(
                "Controller: ctc (default), pd, pd-gravity, pid or feed-forward; or t1, it2 or "
                "gt2, trained without noise on the helix (on sway for robots other than the "
                "3-PSP); or adaptive-t1 or adaptive-it2, which continue to learn."
            ),
            show_default=False,
        ),
    ] = None,
    trained: Annotated[
        Path | None,
        typer.Option(
            parser=file_path,
            metavar="FILE",
            help="A controller that psp3 train wrote, in place of --controller.",
            show_default=False,
        ),
    ] = None,
    model: Model = None,
    gains: GainOptions,
    torque_limit: TorqueLimit = None,
    period: Annotated[float, typer.Option(metavar="S", help="Control period (s).")] = 0.002,
    initial_speed: Annotated[
        InitialSpeed,
        typer.Option(
            metavar="NAME", help="Speed at the start: rest, or path for the speed of the motion."
        ),
    ] = InitialSpeed.REST,
    trajectory: TrajectoryText = None,
    motion: MotionOptions,
    out: Annotated[
        Path | None,
        typer.Option(
            parser=result_output,
            metavar="FILE",
            rich_help_panel=OUTPUT,
            help="Save the result as .npz; psp3 view shows it.",
        ),
    ] = None,
    outputs: OutputOptions,
) -> None:
    """Simulate a controller that tracks a motion.

    Without options: computed torque with the thesis's gains on the thesis's helix. Robots other
    than the 3-PSP sway about their reference pose, with their own gains.
    """
    outputs.check()
    which = robot.load()
    if trained is None:
        controller = controller or ControllerName.CTC
        steering, settings = controller_named(which, controller, model, gains)
    else:
        own = vars(gains) | {"model": model, "controller": controller}
        only_allowed("--trained, which has its own", own, ())
        steering, settings = controller_from_file(which, trained)
        controller = ControllerName(steering.kind)
    limit = torque_limit and one_or_each("--torque-limit", torque_limit, which.actuated)
    desired, seconds, name_of_motion = trajectory_from_options(which, trajectory, motion)
    on_path = initial_speed is InitialSpeed.PATH
    from psp3.errors import SimulationStopped
    from psp3.simulation.tracking import simulate as run

    title = f"{controller.value}, {name_of_motion}"
    if not which.has_inverse_of_tip:
        title = f"{which.title}, {title}"

    def write(result: Result) -> dict[str, Path]:
        # If the controller never returned a force, there is nothing to draw.
        figure = outputs.figure if result.t.size else None
        files = {"result": out, "csv": outputs.csv, "figure": figure}
        if out is not None:
            result.save(out)
        if outputs.csv is not None:
            write_csv(outputs.csv, _samples(result, which))
        if figure is not None:
            draw_figure(figure, lambda: _figure(which, result, title))
        return {
            name: path for name, path in files.items() if path is not None and path != Path("-")
        }

    try:
        with progress_bar("simulating", seconds) as progress:
            result = run(
                which,
                steering,
                desired,
                seconds,
                period,
                initial_speeds=_speeds_of_path(which, desired) if on_path else None,
                torque_limit=limit,
                progress=progress,
            )
    except SimulationStopped as error:
        files = write(error.result)
        kept = f"; the part until then is in {listed(map(str, files.values()))}" if files else ""
        say(f"{error_message(error)}{kept}{_why_it_may_have(which)}", err=True)
        raise typer.Exit(USAGE) from error
    files = write(result)
    if outputs.csv == Path("-"):
        return
    metrics = _metrics(result, which)
    if outputs.json:
        of_the_path = motion.of_the_path().items()
        print_json(
            {
                "controller": controller.value,
                **settings,
                **robot.identity(which),
                **({} if which.has_inverse_of_tip else {"coordinates": which.coordinates}),
                "trajectory": name_of_motion,
                "trajectory_options": {
                    name: value for name, value in of_the_path if value is not None
                },
                "duration": float(result.t[-1]),
                "period": period,
                "samples": result.t.size,
                "initial_speed": initial_speed.value,
                "torque_limit": None if torque_limit is None else torque_limit.values,
                "metrics": metrics,
                "files": files,
            }
        )
        return
    title = f"{title}, {result.t[-1]:g} s at {1e3 * period:g} ms"
    if which.has_inverse_of_tip:
        _show_metrics(metrics, title)
    else:
        _show_joint_metrics(metrics, title, which)
    for path in files.values():
        say(path)


def _why_it_may_have(robot: ClosedLoopRobot) -> str:
    """Explain why a robot may have stopped: motions that no motor holds, and how to hold them."""
    follow = what_follows(robot)
    if not follow or robot.options["free"] != "keep":
        return ""
    return f"; {follow} (--free lock holds what can be held)"


def _speeds_of_path(robot: ClosedLoopRobot, desired: Trajectory) -> Any:
    """Return the speeds at the start of a motion; passive coordinates are at rest."""
    import numpy as np

    speeds = np.zeros(robot.coordinates_v.size)
    speeds[: robot.commanded] = desired(0.0).speeds
    return speeds


def _figure(robot: ClosedLoopRobot, result: Result, text: str) -> Any:
    from fuzzy2.plots.names import literal

    title = literal(text)
    if robot.has_inverse_of_tip:
        from psp3.plots.control import figure_of_tracking

        return figure_of_tracking(result, title)
    from psp3.plots.joints import figure_of_joint_tracking

    return figure_of_joint_tracking(robot, result, title)


def _show_joint_metrics(metrics: dict[str, Any], title: str, robot: ClosedLoopRobot) -> None:
    joints, motors = commanded_joints(robot), robot.actuated
    errors = [metrics["rms_errors"], metrics["largest_errors"]]
    headings = ["root mean square of the error", "largest error"]
    if motors == joints:
        table = new_table(title, "motor", *headings, "largest force", "unit")
        units = {"rad": "rad, N m", "m": "m, N"}
        tables, columns = [table], [*errors, metrics["largest_forces"]]
    else:
        table = new_table(title, "joint", *headings, "unit")
        of_motors = new_table("Forces of the motors", "motor", "largest force", "unit")
        for name, force, unit in zip(
            motors, metrics["largest_forces"], joint_units(robot, motors), strict=True
        ):
            of_motors.add_row(name, f"{force:.6g}", {"rad": "N m", "m": "N"}.get(unit, ""))
        units, tables, columns = {}, [table, of_motors], errors
    for name, unit, *values in zip(joints, joint_units(robot, joints), *columns, strict=True):
        table.add_row(name, *(f"{value:.6g}" for value in values), units.get(unit, unit))
    tip = metrics["largest_tip_error"]
    if tip is not None:
        table.caption = f"largest error of the tip: {1e3 * tip:.6g} mm"
    show(*tables)
    if what_follows(robot):
        show_text(what_follows(robot))


def _show_metrics(metrics: dict[str, Any], title: str) -> None:
    table = new_table(title, "", "value", "unit")
    squares = metrics["sum_of_squared_errors"]
    table.add_row(
        "sum of squared errors, one sample per 0.05 s",
        "–" if squares is None else f"{squares:.6g}",
        "m²",
    )
    table.add_row(
        "integral of the squared error", f"{metrics['integral_of_squared_error']:.6g}", "m² s"
    )
    table.add_row("root mean square of the error", f"{1e3 * metrics['rms_error']:.6g}", "mm")
    table.add_row("largest error of the tip", f"{1e3 * metrics['largest_tip_error']:.6g}", "mm")
    table.add_row("error of the tip at the end", f"{1e3 * metrics['final_tip_error']:.6g}", "mm")
    table.add_row("largest screw forces", "  ".join(fixed(metrics["largest_forces"], 2)), "N")
    if "coverage" in metrics:
        table.add_row("steps inside the trained range", f"{100.0 * metrics['coverage']:.4g}", "%")
        table.add_row(
            "steps that fell back on the average of the rules",
            f"{100.0 * metrics['fallbacks']:.4g}",
            "%",
        )
    show(table)


def _joint_metrics(result: Result, robot: ClosedLoopRobot) -> dict[str, Any]:
    import numpy as np

    from psp3.simulation.metrics import largest_tip_error

    errors = result.desired.positions - result.positions[:, : robot.commanded]
    # If some coordinates follow passively, there is no desired motion of the tip.
    all_commanded = robot.commanded == robot.coordinates_v.size
    tip = largest_tip_error(result) if all_commanded else math.nan
    return {
        "rms_errors": np.sqrt((errors**2).mean(axis=0)),
        "largest_errors": np.abs(errors).max(axis=0),
        "largest_forces": np.abs(result.torque).max(axis=0),
        "largest_tip_error": tip if math.isfinite(tip) else None,
    }


def _metrics(result: Result, robot: ClosedLoopRobot) -> dict[str, Any]:
    import numpy as np

    from psp3.errors import InvalidValue
    from psp3.simulation import metrics

    if not robot.has_inverse_of_tip:
        return _joint_metrics(result, robot)
    try:
        squares = metrics.sum_of_squared_errors(result)
    except InvalidValue:
        # The control period does not divide 0.05 s.
        squares = None
    shares = {"coverage": result.covered, "fallbacks": result.fell_back}
    return {
        "sum_of_squared_errors": squares,
        "integral_of_squared_error": metrics.integral_of_squared_error(result),
        "rms_error": metrics.rms_error(result),
        "largest_tip_error": metrics.largest_tip_error(result),
        "final_tip_error": float(np.linalg.norm(result.desired.tip[-1] - result.tip[-1])),
        "largest_forces": np.abs(result.torque).max(axis=0),
        **{name: float(flags.mean()) for name, flags in shares.items() if flags is not None},
    }


def _samples(result: Result, robot: ClosedLoopRobot) -> dict[str, Any]:
    """Return the columns of a simulation's CSV file.

    Their names are those of :meth:`psp3.trajectories.screw_forces.ScrewForces.columns`.
    """
    columns = {"t": result.t, **dict(zip("xyz", result.tip.T, strict=True))}
    columns |= {
        f"desired_{name}": column for name, column in zip("xyz", result.desired.tip.T, strict=True)
    }
    for name, values in (
        ("a", result.heights),
        ("desired_a", result.desired.heights),
        ("speed", result.speeds),
        ("desired_speed", result.desired.speeds),
        ("force", result.torque),
    ):
        columns |= {f"{name}{k}": column for k, column in enumerate(values.T, start=1)}
    flags = {"covered": result.covered, "fell_back": result.fell_back}
    columns |= {name: values.astype(int) for name, values in flags.items() if values is not None}
    return columns
