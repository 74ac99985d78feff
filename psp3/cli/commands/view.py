"""The command that shows the robot in the browser."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fuzzy2.support.deferred_compilation import deferred_compilation
from psp3.cli.browser import open_page
from psp3.cli.joint_tables import position_labels
from psp3.cli.option_groups import GainOptions, MotionOptions, single_options
from psp3.cli.options import (
    MOTION,
    ControllerName,
    Positions,
    file_path,
    of_each,
    only_allowed,
    page_output,
    usage_error,
)
from psp3.cli.output import progress_bar, say
from psp3.cli.robot_options import RobotOptions
from psp3.cli.shared import (
    controller_from_file,
    controller_named,
    trajectory_from_options,
)

if TYPE_CHECKING:
    from psp3.control.controller import Controller
    from psp3.robots.closed_loop_robot import ClosedLoopRobot
    from psp3.simulation.result import Result
    from psp3.trajectories.trajectory import Trajectory


@single_options
@deferred_compilation()
def view(
    *,
    robot: RobotOptions,
    positions: Positions = None,
    result: Annotated[
        list[Path] | None,
        typer.Option(
            parser=file_path,
            metavar="FILE",
            help="Show a motion that psp3 simulate --out saved; may be given more than once.",
        ),
    ] = None,
    controller: Annotated[
        list[ControllerName] | None,
        typer.Option(
            metavar="NAME",
            help=(
                "Simulate this controller, as psp3 simulate does, and show it; may be given more "
                "than once."
            ),
        ),
    ] = None,
    trained: Annotated[
        list[Path] | None,
        typer.Option(
            parser=file_path,
            metavar="FILE",
            help=(
                "Simulate a controller that psp3 train wrote, and show it; may be given more "
                "than once."
            ),
        ),
    ] = None,
    record: Annotated[
        Path | None,
        typer.Option(
            parser=page_output,
            metavar="FILE",
            help="Write a page (.html) that any browser opens, instead of serving.",
        ),
    ] = None,
    browser: Annotated[
        bool,
        typer.Option(
            help="Open the page in your browser if there is a screen, or only serve it.",
        ),
    ] = True,
    port: Annotated[
        int,
        typer.Option(
            min=1,
            max=65000,
            metavar="PORT",
            help="Port to serve on; if it is taken, the next free one.",
        ),
    ] = 7000,
    trajectory: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            rich_help_panel=MOTION,
            help=(
                "Motion: circle (default for the 3-PSP), helix (default with a controller), line, "
                "point-to-point, hold, sway (default for other robots), or csv:FILE. Without a "
                "controller the desired motion is shown."
            ),
        ),
    ] = None,
    motion: MotionOptions,
) -> None:
    """Show the robot in the browser, in motion or, with --positions, at rest.

    Opens the browser itself. The robots of several results and controllers are shown side by side,
    each with its error in millimeters. Serves only this machine, at 127.0.0.1, until Ctrl-C.
    """
    simulated = bool(controller or trained)
    _refuse_contradictions(
        at_rest=positions is not None,
        recorded=bool(result),
        simulated=simulated,
        trajectory=trajectory,
        motion=motion,
    )
    which = robot.load()
    pose = (
        which.reference
        if positions is None
        else of_each("--positions", positions, position_labels(which))
    )
    motions: dict[str, Result | Trajectory] = dict(_recorded(result or []))
    seconds = None
    if simulated:
        desired, seconds, _ = trajectory_from_options(which, trajectory, motion)
        motions |= _simulated(which, controller or [], trained or [], desired, seconds)
    elif positions is None and not motions:
        shown = _desired(which, trajectory, motion)
        if shown is not None:
            motions[""], seconds = shown
    from psp3.visualize.scene import Scene
    from psp3.visualize.viewer import Viewer

    def stage(scene: Scene) -> None:
        if motions:
            scene.animate(motions, seconds)
        else:
            scene.show(pose)

    if record is not None:
        page = Scene(which)
        stage(page)
        page.write_html(record)
        say(record)
        return
    import threading

    with Viewer(which, port) as viewer:
        stage(viewer)
        try:
            # Printed inside the block that handles Ctrl-C, because a reader may interrupt at once.
            say(f"{viewer.url} shows the robot; Ctrl-C ends.")
            if browser:
                open_page(viewer.url)
            threading.Event().wait()
        except KeyboardInterrupt:
            say(err=True)


def _refuse_contradictions(
    *,
    at_rest: bool,
    recorded: bool,
    simulated: bool,
    trajectory: str | None,
    motion: MotionOptions,
) -> None:
    """Raise a usage error if options exclude each other."""
    if at_rest and recorded:
        raise usage_error("give --positions or --result, not both")
    if at_rest and (trajectory is not None or simulated):
        raise usage_error(
            "--positions is for a robot at rest: it does not apply to --trajectory, --controller "
            "or --trained"
        )
    if recorded and trajectory is not None and not simulated:
        raise usage_error("--trajectory does not apply to --result, which has its own")
    if at_rest or (recorded and not simulated):
        only_allowed("--positions" if at_rest else "--result", vars(motion), ())


def _recorded(files: Iterable[Path]) -> dict[str, Result]:
    """Return results from files, by file name.

    Files of the same name in different directories are listed by path.
    """
    from psp3.simulation.result import load_result

    paths = list(dict.fromkeys(files))
    stems = [path.stem for path in paths]
    return {
        path.stem if stems.count(path.stem) == 1 else str(path): load_result(path) for path in paths
    }


def _desired(
    robot: ClosedLoopRobot, text: str | None, options: MotionOptions
) -> tuple[Trajectory, float] | None:
    """Return the motion without a controller and its duration; None if the robot cannot move.

    A periodic motion is shown in whole periods, so it repeats without a jump.
    """
    from psp3.errors import InvalidValue

    chosen = "circle" if text is None and robot.has_inverse_of_tip else text
    try:
        desired, seconds, _ = trajectory_from_options(robot, chosen, options)
    except InvalidValue:
        if text is None and not any(value is not None for value in vars(options).values()):
            return None
        raise
    period = getattr(desired, "period", None)
    if options.duration is None and period is not None and seconds > period:
        seconds = period * int(seconds / period)
    return desired, seconds


def _simulated(
    robot: ClosedLoopRobot,
    names: Iterable[ControllerName],
    files: Iterable[Path],
    motion: Trajectory,
    seconds: float,
) -> dict[str, Result]:
    """Simulate controllers on one motion, each once."""
    from psp3.simulation.tracking import simulate as run

    steering: dict[str, Controller] = {
        name.value: controller_named(robot, name, None, GainOptions())[0]
        for name in dict.fromkeys(names)
    }
    steering |= {str(path): controller_from_file(robot, path)[0] for path in files}
    results = {}
    for name, one in steering.items():
        with progress_bar(f"simulating {name}", seconds) as progress:
            results[name] = run(robot, one, motion, seconds, progress=progress)
    return results
