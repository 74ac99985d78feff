"""Measure what exported code needs on a Cortex-M: flash, memory, stack, instructions.

Prints the rows of the table of ``docs/how_to/export.md``, all or some::

    python docs/make_embedded.py
    python docs/make_embedded.py controller delta

Debian's ``gcc-arm-none-eabi``, ``libnewlib-arm-none-eabi`` and ``qemu-system-arm`` are needed. A
minute or two of one core. Everything random has a seed.
"""

from __future__ import annotations

import sys
import tempfile
import warnings
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from fuzzy2.errors import ApproximationWarning
from psp3.export.project import export_project
from tests.embedded.board import BOARDS, measure
from tests.embedded.things import THINGS


def main() -> None:
    """Print a row for each thing and processor."""
    warnings.simplefilter("ignore", ApproximationWarning)
    for name in sys.argv[1:] or THINGS:
        thing = THINGS[name]
        made = thing.make()
        for precision, board in BOARDS.items():
            with tempfile.TemporaryDirectory() as folder:
                code = export_project(made, folder, precision=precision, name=name)
                found = measure(Path(folder), code, board)[thing.function]
            sys.stdout.write(
                f"| {thing.about} | {board.name}, {precision} | {found.flash / 1000.0:.1f} | "
                f"{found.state} | {found.stack} | {found.most_stack} | {found.instructions} | "
                f"{found.most} |\n"
            )


if __name__ == "__main__":
    main()
