"""A hash of the sources that determine outcomes; if it changes, outcomes are computed again.

The version number identifies only a release. Between releases, or if a user changes the package,
the sources decide: all that a trial may run, and the robots.
"""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path

import fuzzy2
import psp3
from psp3.description.parts import ROBOT_FILES
from psp3.version import __version__

SHOWING = {
    "psp3": ("cli", "thesis", "plots", "visualize", "bounds", "warm_up.py"),
    "fuzzy2": ("plots",),
}
"""Parts of each package that no trial runs; changing them does not affect outcomes."""

SHOWING_BOARDS = ("board.py", "page.py", "pictures.py")
"""The same for this folder."""

DESCRIPTIONS = (".urdf", ".srdf", ".yaml", ".xml")
"""Endings of robot files. Files of shapes are not among them, because appearance does not affect
outcomes."""

DIGITS = 16
"""Number of hexadecimal digits of the hash."""


def sources() -> dict[str, Path]:
    """Return the files that determine outcomes, by their path within the packages."""
    found = {
        f"urdf/{path.name}": path for path in ROBOT_FILES.iterdir() if path.suffix in DESCRIPTIONS
    }
    own = Path(__file__).parent
    for package in (fuzzy2, psp3):
        folder, left_out = Path(package.__path__[0]), SHOWING[package.__name__]
        for path in folder.rglob("*.py"):
            inside = path.relative_to(folder)
            shows_boards = path.parent == own and path.name in SHOWING_BOARDS
            if inside.parts[0] not in left_out and not shows_boards:
                found[f"{package.__name__}/{inside.as_posix()}"] = path
    return found


@cache
def stamp() -> str:
    """Return the version with a hash of all files of :func:`sources`."""
    found = hashlib.sha256()
    for name, path in sorted(sources().items()):
        content = path.read_bytes()
        found.update(f"{name} {len(content)} ".encode())
        found.update(content)
    return f"{__version__} (sources {found.hexdigest()[:DIGITS]})"
