"""The application that the commands register with."""

from __future__ import annotations

from typing import Annotated

import typer

from psp3.cli.options import USAGE

app = typer.Typer(
    name="psp3",
    add_completion=False,
    invoke_without_command=True,
    pretty_exceptions_enable=False,
    help="Dynamics and control of the 3-PSP parallel robot, and of any robot with loops.",
    epilog=(
        "Lengths are in meters and angles in degrees, lists are separated by commas. 'psp3 "
        "COMMAND --help' explains a command."
    ),
)

export = typer.Typer(
    name="export",
    no_args_is_help=True,
    help="Write a robot, a controller or a fuzzy system for other programs.",
)
"""The commands ``psp3 export ...``, a group."""


def _version(wanted: bool) -> None:
    if wanted:
        from psp3.version import __version__

        typer.echo(f"psp3 {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    context: typer.Context,
    _: Annotated[
        bool,
        typer.Option(
            "--version", callback=_version, is_eager=True, help="Show the version and exit."
        ),
    ] = False,
) -> None:
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())
        raise typer.Exit(USAGE)
