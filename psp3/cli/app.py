"""The application that the commands register with."""

from __future__ import annotations

import inspect
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from psp3.cli.options import USAGE

ANY_LENGTH = 1000
"""Length limit of a command's summary; large, because the help wraps long summaries."""


def _nothing(*_: Any, **__: Any) -> None:
    """Return None."""


def _without_type(options: list[Any]) -> list[Any]:
    """Return options and arguments without Python's types, which users need not know.

    Ranges such as ``[1<=x<=65000]`` are also left out, because they take a third of a line of 80
    characters. The error message for a value outside the range gives it.
    """
    for one in options:
        one._get_number_range_help_str = _nothing
        if one.param_type_name == "argument":
            one.display_type_rich = _nothing
        elif one.is_flag and one.metavar is None:
            one.metavar = ""
    return options


class Command(TyperCommand):
    """A command whose help wraps at the width of the terminal and shows no types of Python."""

    def __init__(self, *args: Any, **settings: Any) -> None:
        super().__init__(*args, **settings)
        # The line breaks of the source code do not fit the terminal.
        paragraphs = inspect.cleandoc(self.help or "").split("\n\n")
        self.help = "\n\n".join(" ".join(one.split("\n")) for one in paragraphs)

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
        "Lengths are in meters and angles in radians; options in degrees are marked DEGREES. "
        "Lists are separated by commas. 'psp3 COMMAND --help' explains a command."
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
