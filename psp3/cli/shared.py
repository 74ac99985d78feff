"""What several commands do with their options: make a robot, a trajectory and a controller."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from psp3.cli.option_groups import GainOptions, MotionOptions
from psp3.cli.options import (
    INTERRUPTED,
    SAMPLED,
    ControllerName,
    ModelName,
    ParametersName,
    listed,
    only_allowed,
    option_of,
    usage_error,
)

if TYPE_CHECKING:
    from psp3.control.controller import Controller
    from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
    from psp3.three_psp.robot import PSP3
    from psp3.trajectories.trajectory import Trajectory


@contextmanager
def resumable(place: Path) -> Iterator[None]:
    """Turn the interruption of a study into a sentence and the exit status of Ctrl-C."""
    from psp3.errors import StudyInterrupted

    try:
        yield
    except StudyInterrupted as interrupt:
        typer.echo(
            f"{interrupt.done} of {interrupt.total} runs are in {place}; the same command goes on "
            "from there",
            err=True,
        )
        raise typer.Exit(INTERRUPTED) from None


def load_robot(parameters: ParametersName) -> PSP3:
    """Return the 3-PSP with a parameter set."""
    from psp3.loading import load

    return load("psp3", parameters=parameters.value)


def trajectory_from_options(
    robot: PSP3, text: str, motion: MotionOptions
) -> tuple[Trajectory, float]:
    """Return the motion that the options describe, and for how long it is wanted."""
    from psp3.trajectories import paths, recorded

    given, duration = motion.of_the_path(), motion.duration
    kind, _, file = text.partition(":")
    trajectory: Trajectory
    if kind == "csv":
        only_allowed("--trajectory csv", given, ())
        if not file:
            raise usage_error("--trajectory csv needs the name of a file: csv:FILE")
        trajectory = recorded.FromCSV(file, robot=robot)
    elif file or kind not in ("helix", "circle", "line", "point-to-point", "hold"):
        raise usage_error(
            "--trajectory must be helix, circle, line, point-to-point, hold or csv:FILE, got "
            f"{text!r}"
        )
    elif kind == "hold":
        trajectory = paths.Hold(
            only_allowed("--trajectory hold", given, ("tip",)).get("tip"), robot=robot
        )
    elif kind in ("helix", "circle"):
        allowed = ("radius", "turn_time", "start_height") + (("rise",) if kind == "helix" else ())
        options = only_allowed(f"--trajectory {kind}", given, allowed)
        names = {
            "radius": "radius",
            "turn_time": "period",
            "start_height": "height",
            "rise": "rise",
        }
        shape = paths.Helix if kind == "helix" else paths.Circle
        trajectory = shape(robot=robot, **{names[name]: value for name, value in options.items()})
    else:
        options = {"travel_time": 2.0} | only_allowed(
            f"--trajectory {kind}", given, ("start", "end", "travel_time")
        )
        missing = [option_of(name) for name in ("start", "end") if name not in options]
        if missing:
            raise usage_error(f"--trajectory {kind} needs {listed(missing)}")
        segment = paths.Line if kind == "line" else paths.PointToPoint
        trajectory = segment(options["start"], options["end"], options["travel_time"], robot=robot)
    return trajectory, duration if duration is not None else trajectory.duration or float(SAMPLED)


def controller_named(
    robot: PSP3, name: ControllerName, model: ModelName | None, gains: GainOptions
) -> tuple[Controller, dict[str, Any]]:
    """Return a controller and what there is to say about it."""
    from psp3.control import classical as controllers

    allowed = {ControllerName.PID: ("kp", "kv", "ki"), ControllerName.FEED_FORWARD: ()}.get(
        name, ("kp", "kv")
    )
    kept = only_allowed(f"--controller {name.value}", vars(gains), allowed)
    controller: Any
    if name in (ControllerName.T1, ControllerName.IT2, ControllerName.GT2):
        if model is not None:
            raise usage_error(
                f"--model does not apply to --controller {name.value}, which learns its own"
            )
        from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
        from psp3.trajectories.paths import Helix

        controller = FuzzyComputedTorque(name.value, robot, **kept).fit(Helix(robot=robot))
        settings: dict[str, Any] = {"model": "learned"}
    elif name in (ControllerName.PD, ControllerName.PID):
        if model is not None:
            raise usage_error(
                f"--model does not apply to --controller {name.value}, which uses none"
            )
        controller = {ControllerName.PD: controllers.PD, ControllerName.PID: controllers.PID}[name](
            **kept
        )
        settings = {"model": None}
    else:
        chosen = model or ModelName.CLOSED_FORM
        kinds: dict[ControllerName, Callable[..., Any]] = {
            ControllerName.PD_GRAVITY: controllers.GravityCompensatedPD,
            ControllerName.FEED_FORWARD: controllers.FeedForward,
            ControllerName.CTC: controllers.ComputedTorque,
        }
        controller = kinds[name](robot.dynamics(chosen.value), **kept)
        settings = {"model": chosen.value}
    return controller, settings | {"gains": {gain: getattr(controller, gain) for gain in allowed}}


def controller_from_file(robot: PSP3, path: Path) -> tuple[FuzzyComputedTorque, dict[str, Any]]:
    """Return a trained controller and what there is to say about it."""
    from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque

    controller = FuzzyComputedTorque.load(path, robot)
    return controller, {"model": str(path), "gains": {"kp": controller.kp, "kv": controller.kv}}
