"""The command that shows the robot in the browser."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

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
def view(
    *,
    robot: RobotOptions,
    positions: Positions = None,
    result: Annotated[
        list[Path] | None,
        typer.Option(
            parser=file_path,
            metavar="FILE",
            help="Show the motion that psp3 simulate --out saved; may be given more than once.",
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
            help="Write a page (.html) that any browser opens, and do not serve.",
        ),
    ] = None,
    port: Annotated[
        int, typer.Option(min=1, max=65000, help="Port to serve on; if it is taken, the next one.")
    ] = 7000,
    trajectory: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            rich_help_panel=MOTION,
            help=(
                "helix (of the 3-PSP, with a controller unless given), circle, line, "
                "point-to-point, hold, sway (of any robot), or csv:FILE; without a controller "
                "shown as it is desired."
            ),
        ),
    ] = None,
    motion: MotionOptions,
) -> None:
    """Show the robot in the browser, at rest or in motion.

    Robots of several results and controllers stand side by side. Serves to this machine only, at
    127.0.0.1, until Ctrl-C.
    """
    if positions is not None and result:
        raise usage_error("give --positions or --result, not both")
    simulated = bool(controller or trained)
    if trajectory is None and not simulated:
        what = "a view without --trajectory, --controller or --trained"
        only_allowed(what, vars(motion), ())
    elif positions is not None:
        raise usage_error(
            "--positions is for a robot at rest: it does not apply to --trajectory, --controller "
            "or --trained"
        )
    elif result and not simulated:
        raise usage_error("--trajectory does not apply to --result, which has its own")
    which = robot.load()
    pose = (
        which.reference
        if positions is None
        else of_each("--positions", positions, position_labels(which))
    )
    from psp3.simulation.result import load_result

    # Files of the same name in different directories are told apart by their paths.
    paths = list(dict.fromkeys(result or []))
    stems = [path.stem for path in paths]
    motions: dict[str, Result | Trajectory] = {
        path.stem if stems.count(path.stem) == 1 else str(path): load_result(path) for path in paths
    }
    seconds = None
    if trajectory is not None or simulated:
        desired, seconds, _ = trajectory_from_options(which, trajectory, motion)
        if simulated:
            motions |= _simulated(which, controller or [], trained or [], desired, seconds)
        else:
            motions["desired"] = desired
    from psp3.visualize.scene import Scene
    from psp3.visualize.viewer import Viewer

    def stage(scene: Scene) -> None:
        if motions:
            scene.animate(motions if len(motions) > 1 else next(iter(motions.values())), seconds)
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
            # Who reads this may interrupt at once.
            say(f"{viewer.url} shows the robot; Ctrl-C ends.")
            threading.Event().wait()
        except KeyboardInterrupt:
            say(err=True)


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
