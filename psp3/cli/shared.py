"""Make trajectories and controllers from the options that several commands share."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from psp3.cli.joint_tables import commanded_joints
from psp3.cli.option_groups import GainOptions, MotionOptions
from psp3.cli.options import (
    INTERRUPTED,
    SAMPLED,
    SAMPLED_FALL,
    ControllerName,
    ModelName,
    Numbers,
    listed,
    of_each,
    only_allowed,
    option_of,
    usage_error,
)
from psp3.cli.output import say

if TYPE_CHECKING:
    from psp3.control.controller import Controller
    from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
    from psp3.robots.closed_loop_robot import ClosedLoopRobot
    from psp3.trajectories.trajectory import Trajectory


@contextmanager
def resumable(place: Path) -> Iterator[None]:
    """Turn the interruption of a study into a message and the exit status of Ctrl-C."""
    from psp3.errors import StudyInterrupted

    try:
        yield
    except StudyInterrupted as interrupt:
        say(
            f"{interrupt.done} of {interrupt.total} runs are in {place}; run the same command to "
            "continue",
            err=True,
        )
        raise typer.Exit(INTERRUPTED) from None


def refuse_workers_of_scheduler(workers: int | None, scheduler: str | None) -> None:
    """Raise a usage error if the number of workers is given together with a scheduler."""
    if workers is not None and scheduler is not None:
        raise usage_error("--workers does not apply to --scheduler, which has its own")


MOTION_OF_THESIS, MOTION_OF_OTHERS = "helix", "sway"
"""Default motion."""

TURNS_LEARNED = 2
"""Number of periods of sway to learn from, for robots other than the 3-PSP."""

ADAPTIVE = "adaptive-"
"""Prefix of the names of controllers whose rules continue to learn."""

LEARNED = (
    *(ControllerName.T1, ControllerName.IT2, ControllerName.GT2),
    *(ControllerName.ADAPTIVE_T1, ControllerName.ADAPTIVE_IT2),
)
"""Controllers that learn rules."""


def trajectory_from_options(
    robot: ClosedLoopRobot, text: str | None, motion: MotionOptions
) -> tuple[Trajectory, float, str]:
    """Return the motion that the options describe, its duration and its name."""
    from psp3.trajectories import recorded
    from psp3.trajectories.sway import Sway

    given, duration = motion.of_the_path(), motion.duration
    has_inverse = robot.has_inverse_of_tip
    if text is None:
        text = MOTION_OF_THESIS if has_inverse else MOTION_OF_OTHERS
    kind, _, file = text.partition(":")
    trajectory: Trajectory
    if kind == "csv":
        only_allowed("--trajectory csv", given, ())
        if not file:
            raise usage_error("--trajectory csv needs the name of a file: csv:FILE")
        trajectory = recorded.FromCSV(file, robot=robot)
    elif file or kind not in ("helix", "circle", "line", "point-to-point", "hold", "sway"):
        raise usage_error(
            "--trajectory must be helix, circle, line, point-to-point, hold, sway or csv:FILE, got "
            f"{text!r}"
        )
    elif kind in ("helix", "circle") and not has_inverse:
        raise usage_error(
            f"--trajectory {kind} is a motion of the 3-PSP's tip; of {robot.title} give sway, "
            "line, point-to-point, hold or csv:FILE"
        )
    elif kind == "sway":
        options = only_allowed("--trajectory sway", given, ("amplitude", "turn_time"))
        names = {"amplitude": "amplitude", "turn_time": "period"}
        trajectory = Sway(robot=robot, **{names[name]: value for name, value in options.items()})
    else:
        trajectory = _path_between_points(robot, kind, given)
    endless = float(SAMPLED if robot.commanded == robot.coordinates_v.size else SAMPLED_FALL)
    wanted = duration if duration is not None else trajectory.duration or endless
    return trajectory, wanted, text


def _path_between_points(robot: ClosedLoopRobot, kind: str, given: dict[str, Any]) -> Trajectory:
    """Return a helix, a circle, a segment or a point to hold."""
    from psp3.trajectories import paths

    has_inverse = robot.has_inverse_of_tip
    labels = ("x", "y", "z") if has_inverse else commanded_joints(robot)

    def point(option: str, numbers: Numbers) -> tuple[float, ...]:
        return of_each(option, numbers, labels)

    if kind == "hold":
        kept = only_allowed("--trajectory hold", given, ("tip",)).get("tip")
        return paths.Hold(
            None if kept is None else point("--tip" if has_inverse else "--at", kept), robot=robot
        )
    if kind in ("helix", "circle"):
        allowed = ("radius", "turn_time", "start_height") + (("rise",) if kind == "helix" else ())
        options = only_allowed(f"--trajectory {kind}", given, allowed)
        names = {
            "radius": "radius",
            "turn_time": "period",
            "start_height": "height",
            "rise": "rise",
        }
        shape = paths.Helix if kind == "helix" else paths.Circle
        return shape(robot=robot, **{names[name]: value for name, value in options.items()})
    options = {"travel_time": 2.0} | only_allowed(
        f"--trajectory {kind}", given, ("start", "end", "travel_time")
    )
    needed = ("start", "end") if has_inverse else ("end",)
    missing = [option_of(name) for name in needed if name not in options]
    if missing:
        raise usage_error(f"--trajectory {kind} needs {listed(missing)}")
    home = robot.reference[: len(labels)]
    start = point("--start", options["start"]) if "start" in options else home
    segment = paths.Line if kind == "line" else paths.PointToPoint
    return segment(start, point("--end", options["end"]), options["travel_time"], robot=robot)


def controller_named(
    robot: ClosedLoopRobot, name: ControllerName, model: ModelName | None, gains: GainOptions
) -> tuple[Controller, dict[str, Any]]:
    """Return a controller and its description."""
    allowed = {ControllerName.PID: ("kp", "kv", "ki"), ControllerName.FEED_FORWARD: ()}.get(
        name, ("kp", "kv")
    )
    kept = only_allowed(f"--controller {name.value}", vars(gains), allowed)
    if not robot.has_inverse_of_tip:
        from psp3.control.default_gains import default_gains

        kept = default_gains(robot, name.value) | kept
    if name in LEARNED:
        controller, settings = _learned(robot, name, model, kept)
    else:
        controller, settings = _classical(robot, name, model, kept)
    return controller, settings | {"gains": {gain: getattr(controller, gain) for gain in allowed}}


def _learned(
    robot: ClosedLoopRobot, name: ControllerName, model: ModelName | None, gains: dict[str, Any]
) -> tuple[Any, dict[str, Any]]:
    if model is not None:
        raise usage_error(
            f"--model does not apply to --controller {name.value}, which learns its own"
        )
    from psp3.fuzzy_control.adaptive import AdaptiveFuzzyComputedTorque
    from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
    from psp3.trajectories.paths import Helix
    from psp3.trajectories.sway import Sway

    kind = name.value.removeprefix(ADAPTIVE)
    controller: Any = FuzzyComputedTorque(kind, robot, **gains)
    if robot.has_inverse_of_tip:
        controller.fit(Helix(robot=robot))
    else:
        path = Sway(robot=robot)
        controller.fit(path, TURNS_LEARNED * path.period)
    if kind != name.value:
        controller = AdaptiveFuzzyComputedTorque(controller)
    return controller, {"model": "learned"}


def _classical(
    robot: ClosedLoopRobot, name: ControllerName, model: ModelName | None, gains: dict[str, Any]
) -> tuple[Any, dict[str, Any]]:
    from psp3.control import classical as controllers

    if name in (ControllerName.PD, ControllerName.PID):
        if model is not None:
            raise usage_error(
                f"--model does not apply to --controller {name.value}, which uses none"
            )
        kinds = {ControllerName.PD: controllers.PD, ControllerName.PID: controllers.PID}
        # Feedback acts along the coordinates, so the robot must map it to the motors.
        motors = {} if robot.drives_coordinates else {"model": robot}
        return kinds[name](**gains, **motors), {"model": None}
    chosen = model or (ModelName.CLOSED_FORM if robot.has_inverse_of_tip else ModelName.CORE)
    of_a_model: dict[ControllerName, Callable[..., Any]] = {
        ControllerName.PD_GRAVITY: controllers.GravityCompensatedPD,
        ControllerName.FEED_FORWARD: controllers.FeedForward,
        ControllerName.CTC: controllers.ComputedTorque,
    }
    made = of_a_model[name](robot.dynamics(chosen.value), **gains)
    return made, {"model": chosen.value}


def gains_of_computed_torque(
    robot: ClosedLoopRobot, kp: float | None, kv: float | None
) -> dict[str, Any]:
    """Return the given gains, or else the robot's defaults."""
    from psp3.control.default_gains import default_gains

    own = {"kp": 10.0, "kv": 1.0}
    if not robot.has_inverse_of_tip:
        own = default_gains(robot, ControllerName.CTC.value)
    given = {"kp": kp, "kv": kv}
    return own | {name: value for name, value in given.items() if value is not None}


def controller_from_file(
    robot: ClosedLoopRobot, path: Path
) -> tuple[FuzzyComputedTorque, dict[str, Any]]:
    """Return a trained controller and its description."""
    from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque

    controller = FuzzyComputedTorque.load(path, robot)
    return controller, {"model": str(path), "gains": {"kp": controller.kp, "kv": controller.kv}}
