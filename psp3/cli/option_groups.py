"""Groups of options: one object in Python, single options on the command line."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from dataclasses import MISSING, dataclass, fields, is_dataclass
from pathlib import Path
from typing import Annotated, Any, get_type_hints

import typer

from psp3.cli.options import (
    MOTION,
    OUTPUT,
    SAMPLED,
    SAMPLED_FALL,
    Numbers,
    csv_output,
    figure_output,
    numbers,
    usage_error,
)


@dataclass(frozen=True, kw_only=True)
class MotionOptions:
    """Parameters of a motion; ``--trajectory`` chooses which motion it is."""

    amplitude: Annotated[
        float | None,
        typer.Option(
            metavar="A",
            rich_help_panel=MOTION,
            help="How far sway moves each motor (m, rad); default as far as it easily can.",
        ),
    ] = None

    radius: Annotated[
        float | None,
        typer.Option(
            metavar="M",
            rich_help_panel=MOTION,
            help="Radius of helix and circle (m); default 0.02.",
        ),
    ] = None
    turn_time: Annotated[
        float | None,
        typer.Option(
            metavar="S",
            rich_help_panel=MOTION,
            help="Time for a turn of helix, circle and sway (s); default 2.",
        ),
    ] = None
    rise: Annotated[
        float | None,
        typer.Option(
            metavar="M/S",
            rich_help_panel=MOTION,
            help="Vertical speed of the helix (m/s); default 0.01.",
        ),
    ] = None
    start_height: Annotated[
        float | None,
        typer.Option(
            metavar="M",
            rich_help_panel=MOTION,
            help="Tip height where helix and circle start (m); default 0.07, the home pose.",
        ),
    ] = None
    start: Annotated[
        Numbers | None,
        typer.Option(
            parser=numbers,
            metavar="X,Y,Z",
            rich_help_panel=MOTION,
            help=(
                "Start of line and point-to-point: the tip (m), for robots other than the 3-PSP "
                "the motors (m, rad); default the reference pose."
            ),
        ),
    ] = None
    end: Annotated[
        Numbers | None,
        typer.Option(
            parser=numbers,
            metavar="X,Y,Z",
            rich_help_panel=MOTION,
            help=(
                "End of line and point-to-point, given as --start: the tip (m) or the motors "
                "(m, rad)."
            ),
        ),
    ] = None
    travel_time: Annotated[
        float | None,
        typer.Option(
            metavar="S",
            rich_help_panel=MOTION,
            help="Time that line and point-to-point take (s); default 2.",
        ),
    ] = None
    tip: Annotated[
        Numbers | None,
        typer.Option(
            "--tip",
            "--at",
            parser=numbers,
            metavar="X,Y,Z",
            rich_help_panel=MOTION,
            help=(
                "What to hold: the tip (m), for robots other than the 3-PSP the motors (m, rad); "
                "default home."
            ),
        ),
    ] = None
    duration: Annotated[
        float | None,
        typer.Option(
            metavar="S",
            rich_help_panel=MOTION,
            help=(
                f"Total time (s); default until the motion ends, {SAMPLED} if it never does, "
                f"{SAMPLED_FALL} if some coordinates follow the motors."
            ),
        ),
    ] = None

    def of_the_path(self) -> dict[str, Any]:
        """Return the options of the path: all except the duration, which every motion has."""
        return {name: value for name, value in vars(self).items() if name != "duration"}


@dataclass(frozen=True, kw_only=True)
class GainOptions:
    """Gains of a controller; None takes the controller's default."""

    kp: Annotated[
        float | None,
        typer.Option(
            metavar="GAIN",
            help=(
                "Proportional gain: N/m, 1/s² for ctc; default the thesis's, 1000, 10 for ctc; "
                "for robots other than the 3-PSP that of a bandwidth of 20 rad/s."
            ),
        ),
    ] = None
    kv: Annotated[
        float | None,
        typer.Option(
            metavar="GAIN",
            help=(
                "Derivative gain: N s/m, 1/s for ctc; default the thesis's, 100, 1 for ctc; for "
                "robots other than the 3-PSP critical damping."
            ),
        ),
    ] = None
    ki: Annotated[
        float | None,
        typer.Option(
            metavar="GAIN",
            help="Integral gain of pid: N/(m s); default 2000, for robots other than the 3-PSP "
            "10/s of kp.",
        ),
    ] = None


@dataclass(frozen=True, kw_only=True)
class OutputOptions:
    """Outputs for the samples of a motion."""

    csv: Annotated[
        Path | None,
        typer.Option(
            parser=csv_output,
            metavar="FILE",
            rich_help_panel=OUTPUT,
            help="Write all samples as CSV in SI units; - is standard output.",
        ),
    ] = None
    figure: Annotated[
        Path | None,
        typer.Option(
            parser=figure_output,
            metavar="FILE",
            rich_help_panel=OUTPUT,
            help="Draw to FILE: .pdf, .png or .svg.",
        ),
    ] = None
    json: Annotated[
        bool,
        typer.Option(
            "--json",
            rich_help_panel=OUTPUT,
            help="Print JSON and nothing else.",
            show_default=False,
        ),
    ] = False

    def check(self) -> None:
        """Refuse two outputs that both go to standard output."""
        if self.json and self.csv == Path("-"):
            raise usage_error("--json and --csv - both want standard output; give --csv a file")


def single_options(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command with its groups unfolded, so that typer sees single options.

    A parameter that is annotated with a dataclass is a group. In the signature the fields of the
    dataclass replace it, with their options and defaults; the command is called with one object
    made from them.
    """
    groups: dict[str, type] = {}
    parameters = []
    for parameter in inspect.signature(command, eval_str=True).parameters.values():
        if not is_dataclass(parameter.annotation):
            parameters.append(parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY))
            continue
        group: Any = parameter.annotation
        groups[parameter.name] = group
        options = get_type_hints(group, include_extras=True)
        parameters += [
            inspect.Parameter(
                field.name,
                inspect.Parameter.KEYWORD_ONLY,
                default=inspect.Parameter.empty if field.default is MISSING else field.default,
                annotation=options[field.name],
            )
            for field in fields(group)
        ]

    @functools.wraps(command)
    def run(**given: Any) -> None:
        for name, group in groups.items():
            options = {field.name: given.pop(field.name) for field in fields(group)}
            given[name] = group(**options)
        command(**given)

    # Typer reads the options from these two attributes.
    run.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    signature: Any = run
    signature.__signature__ = inspect.Signature(parameters)
    return run
