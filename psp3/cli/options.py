"""Options that several commands share, and the parsers of their values."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Sequence
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import typer

USAGE, INTERRUPTED = 2, 130
"""Exit statuses: wrong usage or input, and Ctrl-C."""

RIGHT_ANGLE = 90.0
"""The star's tilt must be less than this [degrees]."""

FIGURE_FORMATS = (".pdf", ".png", ".svg")
SAMPLED = "10.4"
"""Default duration of a motion without an end of its own [s], as in the thesis's simulations."""

SAMPLED_FALL = "2"
"""The same for a robot with passive coordinates: a floating one falls 20 m in this time."""


class Triple(NamedTuple):
    """Three numbers of the command line, one for each screw or axis."""

    first: float
    second: float
    third: float


class Numbers(NamedTuple):
    """Numbers of the command line, one for each coordinate of a robot."""

    values: tuple[float, ...]


class Limit(NamedTuple):
    """One number for all motors, or one for each."""

    values: tuple[float, ...]


class ControllerName(StrEnum):
    """Controllers that the command line knows."""

    PD = "pd"
    PD_GRAVITY = "pd-gravity"
    PID = "pid"
    FEED_FORWARD = "feed-forward"
    CTC = "ctc"
    T1 = "t1"
    IT2 = "it2"
    GT2 = "gt2"
    ADAPTIVE_T1 = "adaptive-t1"
    ADAPTIVE_IT2 = "adaptive-it2"


class ModelName(StrEnum):
    """Implementations of the equation of motion."""

    CLOSED_FORM = "closed_form"
    CORE = "core"
    PINOCCHIO = "pinocchio"
    NOC = "noc"


class ParametersName(StrEnum):
    """Parameter sets."""

    DEFAULT = "default"
    TABLE_3_1 = "table_3_1"
    TABLE_5_1 = "table_5_1"


class InitialSpeed(StrEnum):
    """How a simulation starts."""

    REST = "rest"
    PATH = "path"


# Parsers of the options


def _numbers(text: str) -> tuple[float, ...]:
    try:
        return tuple(float(number) for number in text.split(","))
    except ValueError:
        raise typer.BadParameter(f"{text!r} is not a list of numbers separated by commas") from None


def triple(text: str) -> Triple:
    """Parse three numbers, separated by commas."""
    numbers = _numbers(text)
    if len(numbers) != len(Triple._fields):
        raise typer.BadParameter(
            f"{text!r} has {len(numbers)} numbers; three are needed, separated by commas"
        )
    return Triple(*numbers)


def numbers(text: str) -> Numbers:
    """Parse numbers, separated by commas."""
    return Numbers(_numbers(text))


def of_each(option: str, given: Numbers, names: Sequence[str]) -> tuple[float, ...]:
    """Return numbers, one for each name; refuse any other count."""
    if len(given.values) != len(names):
        text = ",".join(f"{number:g}" for number in given.values)
        raise usage_error(
            f"{option} {text} has {_counted(len(given.values), 'number')}; {len(names)} "
            f"{'is' if len(names) == 1 else 'are'} needed, separated by commas: "
            f"{', '.join(names)}"
        )
    return given.values


def one_or_each(option: str, given: Numbers | Limit, names: Sequence[str]) -> tuple[float, ...]:
    """Return numbers, one for each name: as many as are given, or the same for all."""
    if len(given.values) == 1:
        return given.values * len(names)
    return of_each(option, Numbers(given.values), names)


def _counted(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


def limit_of_torque(text: str) -> Limit:
    """Parse positive numbers."""
    given = _numbers(text)
    if not all(math.isfinite(number) and number > 0.0 for number in given):
        raise typer.BadParameter(f"{text!r} is not a list of positive numbers separated by commas")
    return Limit(given)


def file_path(text: str) -> Path:
    """Refuse an empty name, which would mean the current folder."""
    # Typer passes the default, which is a path, too.
    if not str(text).strip():
        raise typer.BadParameter(f"{text!r} is not the name of a file")
    return Path(text)


def folder_path(text: str) -> Path:
    """Refuse a folder that is a file."""
    path = file_path(text)
    if path.exists() and not path.is_dir():
        raise typer.BadParameter(f"{text} is not a directory: name a directory")
    return path


def output_file(text: str) -> Path:
    """Refuse an output that cannot be written, before anything is computed."""
    path = file_path(text)
    if path.is_dir():
        raise typer.BadParameter(f"{text} is a directory")
    if not path.parent.is_dir():
        raise typer.BadParameter(f"{text}: there is no directory {path.parent}")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise typer.BadParameter(f"{text} cannot be written to")
    return path


def output_named(what: str, *endings: str) -> Callable[[str], Path]:
    """Return a parser for the name of an output, which must have one of these endings."""

    def output(text: str) -> Path:
        # A directory is reported as a directory, not for its ending.
        if Path(text).suffix.lower() not in endings and not Path(text).is_dir():
            raise typer.BadParameter(f"{text}: the name of {what} must end in {', '.join(endings)}")
        return output_file(text)

    return output


page_output = output_named("a page", ".html", ".htm")
fmu_output = output_named("an FMU", ".fmu")
figure_output = output_named("a figure", *FIGURE_FORMATS)
result_output = output_named("a result", ".npz")
controller_output = output_named("a controller", ".json")
table_output = output_named("a table", ".csv")


def csv_output(text: str) -> Path:
    """Return a file to write samples to, or ``-`` for standard output."""
    return Path("-") if text == "-" else table_output(text)


Model = Annotated[
    ModelName | None,
    typer.Option(
        metavar="NAME",
        help=(
            "Source of M, C and G: closed_form (default for the 3-PSP), core (default for any "
            "other robot), pinocchio or noc."
        ),
    ),
]
TorqueLimit = Annotated[
    Limit | None,
    typer.Option(
        parser=limit_of_torque,
        metavar="N",
        help=(
            "Largest force (N) or torque (N m) of the motors, one number for all or one for each; "
            "default none."
        ),
    ),
]
Positions = Annotated[
    Numbers | None,
    typer.Option(
        "--positions",
        "--heights",
        parser=numbers,
        metavar="A1,A2,…",
        help=(
            "Positions of the coordinates, usually the motors (m, rad); default the reference pose."
        ),
    ),
]
Json = Annotated[
    bool, typer.Option("--json", help="Print JSON and nothing else.", show_default=False)
]
FigureFile = Annotated[
    Path | None,
    typer.Option(parser=figure_output, metavar="FILE", help="Draw to FILE: .pdf, .png or .svg."),
]

MOTION, RUNS, PLANT, OUTPUT = "Desired motion", "Runs", "Plant, for --reading plant", "Output"
TrajectoryText = Annotated[
    str | None,
    typer.Option(
        metavar="NAME",
        rich_help_panel=MOTION,
        help=(
            "Motion: helix (default for the 3-PSP), circle, line, point-to-point, hold, sway "
            "(default for other robots), or csv:FILE for a motion in a file."
        ),
    ),
]


# Helpers that the commands share


def usage_error(message: str) -> typer.BadParameter:
    """Return the error for wrong usage."""
    return typer.BadParameter(message)


def option_of(name: str) -> str:
    """Return the option of a parameter of a command."""
    return "--" + name.replace("_", "-")


def listed(names: Iterable[str]) -> str:
    """Return names in words."""
    *others, last = names
    return f"{', '.join(others)} and {last}" if others else last


def only_allowed(chosen: str, given: dict[str, Any], allowed: Iterable[str]) -> dict[str, Any]:
    """Return the options that were given; refuse those that do not apply to the choice."""
    allowed = tuple(allowed)
    kept = {name: value for name, value in given.items() if value is not None}
    for name in kept:
        if name not in allowed:
            instead = f", which takes {listed(map(option_of, allowed))}" if allowed else ""
            raise usage_error(f"{option_of(name)} does not apply to {chosen}{instead}")
    return kept
