"""The command ``psp3``, the package on the command line.

Only typer is imported here; each command imports what it needs when it runs, so that
``psp3 --help`` answers at once. Results go to standard output, progress and errors to standard
error. Lengths are meters, angles radians; tilt and azimuth of the 3-PSP are
degrees.
"""

from __future__ import annotations

import io
import os
import sys

import typer

from fuzzy2.support.announcements import announced_by
from psp3.cli.app import Command, app, export
from psp3.cli.commands.benchmark import benchmark
from psp3.cli.commands.check import check
from psp3.cli.commands.dynamics import dynamics
from psp3.cli.commands.export_c import c
from psp3.cli.commands.export_fmu import fmu
from psp3.cli.commands.info import info
from psp3.cli.commands.pose import pose
from psp3.cli.commands.reproduce import reproduce
from psp3.cli.commands.simulate import simulate
from psp3.cli.commands.study import study
from psp3.cli.commands.torques import torques
from psp3.cli.commands.train import train
from psp3.cli.commands.view import view
from psp3.cli.commands.warm_up import warm_up
from psp3.cli.commands.workspace import workspace
from psp3.cli.compilation import compilation_shown
from psp3.cli.options import INTERRUPTED, USAGE
from psp3.cli.output import error_message, say

# In the order of the help.
for command in (reproduce, simulate, train, study, benchmark, torques, pose, dynamics, workspace):
    app.command(cls=Command)(command)
for command in (view, check, info, warm_up):
    app.command(cls=Command)(command)
export.command(cls=Command)(c)
export.command(cls=Command)(fmu)
app.add_typer(export)


def main() -> None:
    """Run the command line and exit: status 0, 2 for wrong usage or input, 130 for Ctrl-C."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # On a terminal without Greek letters a question mark is better than an error.
            stream.reconfigure(errors="replace")
    try:
        with announced_by(compilation_shown):
            returned = app(prog_name="psp3", standalone_mode=False)
        status = returned if isinstance(returned, int) else 0
        sys.stdout.flush()
    except (KeyboardInterrupt, typer.Abort):
        status = INTERRUPTED
    except BrokenPipeError:
        # The reader of the output, such as ``head``, closed the pipe.
        status = 1
    except Exception as error:
        message = error_message(error)
        if message is None:
            raise
        say(message, err=True)
        status = USAGE
    if status == INTERRUPTED:
        say("psp3: interrupted", err=True)
    _let_go_of_output()
    sys.exit(status)


def _let_go_of_output() -> None:
    """Flush the output, if possible.

    Python flushes again at exit, where a failure would change the exit status.
    """
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    main()
