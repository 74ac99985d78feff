"""The command that writes C."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from psp3.cli.output import say


class PrecisionName(StrEnum):
    """Precision of numbers in C."""

    DOUBLE = "double"
    SINGLE = "single"


def output_folder(text: str) -> Path:
    """Refuse a folder that cannot be made before anything is computed, not after."""
    path = Path(text)
    if path.exists() and not path.is_dir():
        raise typer.BadParameter(f"{text} is no directory")
    if not path.parent.is_dir():
        raise typer.BadParameter(f"{text}: there is no directory {path.parent}")
    return path


def c(
    thing: Annotated[
        str,
        typer.Argument(
            metavar="THING",
            help=(
                "A robot of the package (psp3 info lists them); or a file: of a robot (.urdf, .xml "
                "or .sdf), of a controller that psp3 train wrote (.json), or of a fuzzy system "
                "(.fis, .fll, .fcl, .fml, .json)."
            ),
            show_default=False,
        ),
    ],
    robot: Annotated[
        str | None,
        typer.Argument(
            metavar="[ROBOT]",
            help="The robot of a controller, where it is one from a file.",
            show_default=False,
        ),
    ] = None,
    out: Annotated[
        Path,
        typer.Option(
            parser=output_folder,
            metavar="DIR",
            help="Directory to write into; it is made if it is not there.",
            show_default=False,
        ),
    ] = ...,  # type: ignore[assignment] # what typer takes for: required
    precision: Annotated[
        PrecisionName,
        typer.Option(metavar="NAME", help="Of all numbers: double, or single for a Cortex-M4."),
    ] = PrecisionName.DOUBLE,
    name: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Name of the .c and .h file and prefix of all names in it; THING's unless given.",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Write a robot, a controller or a fuzzy system in C99, with a program and a test.

    Into DIR go NAME.c and NAME.h, which need nothing else; main.c, which answers lines of numbers;
    a test with 200 cases and what Python answers; a Makefile and a README.md.
    """
    from psp3.export.project import export_project, identifier, opened

    owner = None if robot is None else opened(robot)
    code = export_project(
        opened(thing, owner), out, precision=precision.value, name=name or identifier(thing)
    )
    say(
        f"{code.name}.c and {code.name}.h are in {out}, with {len(code.functions)} "
        f"function{'s' if len(code.functions) > 1 else ''}; 'make -C {out} test' compares what "
        "they answer with Python"
    )
