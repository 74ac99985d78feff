"""Cells of a notebook in a shell like that of a kernel, for a process of :mod:`tests.processes`."""

from __future__ import annotations

import os
import warnings
from multiprocessing.connection import Connection
from pathlib import Path

from IPython.core.interactiveshell import InteractiveShell
from IPython.utils.capture import capture_output


def run_cells(cells: list[str], folder: Path, parent: Connection) -> None:
    """Run cells one after another in a folder, with warnings as errors from the first one on.

    What is displayed is formatted as for a browser. The parent gets the number of the cell that
    failed and its error, or two times None, and what was printed to standard error.
    """
    os.chdir(folder)
    shell = InteractiveShell.instance()
    # There is no loop of events to run; otherwise the figures are drawn as in a notebook.
    shell.enable_gui = lambda gui=None: None
    shell.run_line_magic("matplotlib", "inline")
    # A picture that is cut to its content is drawn twice.
    shell.run_line_magic("config", "InlineBackend.print_figure_kwargs = {'bbox_inches': None}")
    warnings.simplefilter("error")
    complaints = []
    for number, cell in enumerate(cells):
        with capture_output() as shown:
            done = shell.run_cell(cell, store_history=False)
        if shown.stderr:
            complaints.append(shown.stderr)
        if not done.success:
            parent.send((number, repr(done.error_before_exec or done.error_in_exec), complaints))
            return
    parent.send((None, None, complaints))
