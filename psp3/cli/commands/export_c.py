"""The command that writes C."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from psp3.cli.export_options import ROBOT_OR_CONTROLLER, ThingOptions
from psp3.cli.option_groups import single_options
from psp3.cli.options import TorqueLimit, folder_path, one_or_each, only_allowed
from psp3.cli.output import say


class PrecisionName(StrEnum):
    """Precision of numbers in C."""

    DOUBLE = "double"
    SINGLE = "single"


def output_folder(text: str) -> Path:
    """Refuse a folder that cannot be made, before anything is computed."""
    path = folder_path(text)
    if not path.parent.is_dir():
        raise typer.BadParameter(f"{text}: there is no directory {path.parent}")
    return path


@dataclass(frozen=True, kw_only=True)
class ThingInC(ThingOptions):
    """What is written in C; it can also be a fuzzy system."""

    thing: Annotated[
        str,
        typer.Argument(
            metavar="THING",
            help=f"{ROBOT_OR_CONTROLLER}, or of a fuzzy system (.fis, .fll, .fcl, .fml, .json).",
            show_default=False,
        ),
    ]


@single_options
def c(
    *,
    thing: ThingInC,
    out: Annotated[
        Path,
        typer.Option(
            parser=output_folder,
            metavar="DIR",
            help="Directory to write to; it is made if it does not exist.",
            show_default=False,
        ),
    ],
    precision: Annotated[
        PrecisionName,
        typer.Option(
            metavar="NAME", help="Type of all numbers: double, or single for a Cortex-M4."
        ),
    ] = PrecisionName.DOUBLE,
    name: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Name of the .c and .h file and prefix of all names in it; default THING's.",
            show_default=False,
        ),
    ] = None,
    torque_limit: TorqueLimit = None,
) -> None:
    """Write a robot, a controller or a fuzzy system in C99, with a program and a test.

    DIR gets NAME.c and NAME.h, which need nothing else; main.c, which reads lines of numbers and
    prints the results; a test with 200 cases and Python's results; a Makefile and a README.md.
    """
    from psp3.export.controllers import robot_of
    from psp3.export.project import export_project, identifier

    written, robot = thing.open()
    options: dict[str, Any] = {} if robot is None else {"robot": robot}
    if not hasattr(written, "torque"):
        chosen = f"{thing.thing}, which is not a controller"
        only_allowed(chosen, {"torque_limit": torque_limit}, ())
    elif torque_limit is not None:
        steered = robot_of(written) if robot is None else robot
        options["torque_limit"] = one_or_each("--torque-limit", torque_limit, steered.actuated)
    prefix = identifier(thing.thing) if name is None else name
    code = export_project(written, out, precision=precision.value, name=prefix, **options)
    say(
        f"{code.name}.c and {code.name}.h are in {out}, with {len(code.functions)} "
        f"function{'s' if len(code.functions) > 1 else ''}; 'make -C {out} test' compares what "
        "they answer with Python"
    )
