"""Options that several commands share, and how their texts are read."""

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
"""A star cannot be tilted that far [degrees]."""

FIGURE_FORMATS = (".pdf", ".png", ".svg")
SAMPLED = "10.4"
"""Default duration of a motion without an end of its own [s], that of the thesis's simulations."""

SAMPLED_FALL = "2"
"""And of a robot whose coordinates follow: a floating one falls 20 m in it."""


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


# What the options look like


def _numbers(text: str) -> tuple[float, ...]:
    try:
        return tuple(float(number) for number in text.split(","))
    except ValueError:
        raise typer.BadParameter(f"{text!r} is not a list of numbers separated by commas") from None


def triple(text: str) -> Triple:
    """Read three numbers, separated by commas."""
    numbers = _numbers(text)
    if len(numbers) != len(Triple._fields):
        raise typer.BadParameter(
            f"{text!r} has {len(numbers)} numbers; three are needed, separated by commas"
        )
    return Triple(*numbers)


def numbers(text: str) -> Numbers:
    """Read numbers, separated by commas."""
    return Numbers(_numbers(text))


def of_each(option: str, given: Numbers, names: Sequence[str]) -> tuple[float, ...]:
    """Return numbers, one for each name; refuse another number of them."""
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
    """Read positive numbers."""
    given = _numbers(text)
    if not all(math.isfinite(number) and number > 0.0 for number in given):
        raise typer.BadParameter(f"{text!r} are not positive numbers, separated by commas")
    return Limit(given)


def file_path(text: str) -> Path:
    """Refuse a name without a letter: it would mean the folder where the command runs."""
    # Typer hands over the default, too, which is a path.
    if not str(text).strip():
        raise typer.BadParameter(f"{text!r} names no file")
    return Path(text)


def folder_path(text: str) -> Path:
    """Refuse a folder that is a file."""
    path = file_path(text)
    if path.exists() and not path.is_dir():
        raise typer.BadParameter(f"{text} is no directory: name a directory")
    return path


def output_file(text: str) -> Path:
    """Refuse what cannot be written before anything is computed, not after."""
    path = file_path(text)
    if path.is_dir():
        raise typer.BadParameter(f"{text} is a directory")
    if not path.parent.is_dir():
        raise typer.BadParameter(f"{text}: there is no directory {path.parent}")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise typer.BadParameter(f"{text} cannot be written to")
    return path


def output_named(what: str, *endings: str) -> Callable[[str], Path]:
    """Return how the name of an output is read, which must end as its programs expect."""

    def output(text: str) -> Path:
        # A directory has no ending, and is told as what it is.
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
    """Return a file to write samples to, or the sign of standard output."""
    return Path("-") if text == "-" else table_output(text)


Model = Annotated[
    ModelName | None,
    typer.Option(
        metavar="NAME",
        help=(
            "Where M, C and G come from: closed_form (of the 3-PSP, unless given), core (of any "
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
            "Largest force (N) or torque (N m) of a motor, one number or one each; none unless "
            "given."
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
            "Positions of the coordinates, which are the motors as a rule (m, rad); those of the "
            "reference pose unless given."
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
            "helix (of the 3-PSP, unless given), circle, line, point-to-point, hold, sway (of any "
            "other robot), or csv:FILE for a motion on file."
        ),
    ),
]


# What the commands share


def usage_error(message: str) -> typer.BadParameter:
    """Return the error that says how a command is used."""
    return typer.BadParameter(message)


def option_of(name: str) -> str:
    """Return the option of a parameter of a command."""
    return "--" + name.replace("_", "-")


def listed(names: Iterable[str]) -> str:
    """Return names in words."""
    *others, last = names
    return f"{', '.join(others)} and {last}" if others else last


def only_allowed(chosen: str, given: dict[str, Any], allowed: Iterable[str]) -> dict[str, Any]:
    """Keep the options that were given; refuse those that mean nothing for what was chosen."""
    allowed = tuple(allowed)
    kept = {name: value for name, value in given.items() if value is not None}
    for name in kept:
        if name not in allowed:
            instead = f", which takes {listed(map(option_of, allowed))}" if allowed else ""
            raise usage_error(f"{option_of(name)} does not apply to {chosen}{instead}")
    return kept
