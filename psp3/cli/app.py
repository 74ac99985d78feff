"""The application that the commands register with."""

from __future__ import annotations

from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from psp3.cli.options import USAGE

ANY_LENGTH = 1000
"""Length limit of a command's summary; large, because the help wraps long summaries."""


def _without_type(options: list[Any]) -> list[Any]:
    """Return options; those that take no value show no type."""
    for one in options:
        if getattr(one, "is_flag", False) and one.metavar is None:
            one.metavar = ""
    return options


class Command(TyperCommand):
    """A command whose help shows no type for options that take no value."""

    def get_params(self, ctx: Any) -> list[Any]:
        """Return options and arguments."""
        return _without_type(super().get_params(ctx))


class Group(TyperGroup):
    """A group of such commands, whose own help has no frames.

    Importing the code that draws frames takes longer than everything else in a group's help.
    """

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        self.rich_markup_mode = None

    def get_params(self, ctx: Any) -> list[Any]:
        """Return options and arguments."""
        return _without_type(super().get_params(ctx))

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the full first sentence of every command."""
        commands = [(name, self.get_command(ctx, name)) for name in self.list_commands(ctx)]
        with formatter.section("Commands"):
            formatter.write_dl(
                [
                    (name, one.get_short_help_str(ANY_LENGTH))
                    for name, one in commands
                    if one is not None
                ]
            )


app = typer.Typer(
    name="psp3",
    cls=Group,
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
    cls=Group,
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
