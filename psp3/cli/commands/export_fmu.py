"""The command that writes an FMU."""

from __future__ import annotations

import warnings
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from psp3.cli.export_options import DriveOptions, ThingOptions
from psp3.cli.option_groups import single_options
from psp3.cli.options import TorqueLimit, fmu_output, one_or_each, only_allowed
from psp3.cli.output import say


class Version(StrEnum):
    """Version of FMI."""

    TWO = "2.0"
    THREE = "3.0"


@single_options
def fmu(
    *,
    thing: ThingOptions,
    out: Annotated[
        Path,
        typer.Option(
            parser=fmu_output, metavar="FILE", help="File to write (*.fmu).", show_default=False
        ),
    ],
    fmi: Annotated[
        Version, typer.Option(metavar="VERSION", help="Version of FMI: 2.0 or 3.0.")
    ] = Version.TWO,
    period: Annotated[
        float,
        typer.Option(
            metavar="SECONDS",
            help="Shortest communication step (s); all steps are multiples of it.",
        ),
    ] = 0.002,
    steps: Annotated[
        int | None,
        typer.Option(metavar="COUNT", help="Integration steps of a robot in a period; default 1."),
    ] = None,
    name: Annotated[
        str | None,
        typer.Option(
            metavar="NAME", help="Identifier of the model; default from FILE.", show_default=False
        ),
    ] = None,
    torque_limit: TorqueLimit = None,
    drive: DriveOptions,
) -> None:
    """Write a robot or a controller as an FMU (FMI 2.0 or 3.0, co-simulation).

    A robot's inputs are the forces of its motors, and its outputs are positions and speeds. A
    controller's inputs are those and the desired motion, and its outputs are the forces. FILE holds
    source code in C and, if written on Linux with gcc, a binary.
    """
    from psp3.errors import SourceOnlyFMU
    from psp3.export.fmu import export_fmu
    from psp3.robots.robot import Robot

    model, steered = thing.open()
    of_a_robot = {"steps": steps, "torque_limit": torque_limit, **vars(drive)}
    options: dict[str, Any] = {}
    if isinstance(model, Robot):
        options = {"drive": drive.drives(model), "steps": 1 if steps is None else steps}
        if torque_limit is not None:
            options["torque_limit"] = one_or_each("--torque-limit", torque_limit, model.actuated)
    else:
        only_allowed(f"{thing.thing}, which is not a robot", of_a_robot, ())
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always", SourceOnlyFMU)
        written = export_fmu(
            model, out, robot=steered, period=period, name=name, version=fmi.value, **options
        )
    for warning in warned:
        say(f"psp3: {warning.message}", err=True)
    for causality in ("input", "output", "parameter"):
        names = [one.name for one in written.variables if one.causality == causality]
        if names:
            say(f"{causality}s: {', '.join(names)}")
    holds = "source code and a binary" if written.has_binary else "only source code"
    say(f"{out} holds {holds}; steps are multiples of {period:g} s")
