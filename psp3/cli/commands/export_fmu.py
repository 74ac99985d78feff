"""The command that writes an FMU."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Annotated

import typer

from psp3.cli.options import fmu_output
from psp3.cli.output import say


def fmu(
    thing: Annotated[
        str,
        typer.Argument(
            metavar="THING",
            help=(
                "A robot of the package (psp3 info lists them); or a file: of a robot (.urdf, .xml "
                "or .sdf), or of a controller that psp3 train wrote (.json)."
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
    *,
    out: Annotated[
        Path,
        typer.Option(
            parser=fmu_output, metavar="FILE", help="File to write, *.fmu.", show_default=False
        ),
    ],
    period: Annotated[
        float,
        typer.Option(metavar="SECONDS", help="Communication step, or the least one (s)."),
    ] = 0.002,
    steps: Annotated[
        int, typer.Option(metavar="COUNT", help="Steps of integration of a robot in a period.")
    ] = 1,
    name: Annotated[
        str | None,
        typer.Option(
            metavar="NAME", help="Identifier of the model; FILE's unless given.", show_default=False
        ),
    ] = None,
) -> None:
    """Write a robot or a controller as an FMU (FMI 2.0, co-simulation).

    A robot is given the forces of its motors, and has positions and speeds as outputs; a controller
    is given those and the desired motion, and has the forces as outputs. FILE holds source code in
    C and, where this is Linux with gcc, a binary.
    """
    from psp3.errors import SourceOnlyFMU
    from psp3.export.fmu import export_fmu
    from psp3.loading import load

    steered = None if robot is None else load(robot)
    model = Path(thing) if thing.endswith(".json") else load(thing)
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always", SourceOnlyFMU)
        written = export_fmu(model, out, robot=steered, period=period, steps=steps, name=name)
    for warning in warned:
        say(f"psp3: {warning.message}", err=True)
    for causality in ("input", "output", "parameter"):
        names = [one.name for one in written.variables if one.causality == causality]
        if names:
            say(f"{causality}s: {', '.join(names)}")
    holds = "source code and a binary" if written.has_binary else "source code alone"
    say(f"{out} holds {holds}; steps are multiples of {period:g} s")
