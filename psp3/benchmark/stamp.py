"""A hash of the sources that decide outcomes: outcomes of other sources are computed anew.

The version says it of a release. Between releases, and where a package is changed by its user,
sources say it: of all that a trial may run, and of the robots.
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
"""What no trial runs, of each package: a change of it leaves outcomes as they are."""

SHOWING_BOARDS = ("board.py", "page.py", "pictures.py")
"""The same of this folder."""

DESCRIPTIONS = (".urdf", ".srdf", ".yaml", ".xml")
"""What files of robots end in; what they look like decides nothing."""

DIGITS = 16
"""Hexadecimal digits of the word."""


def sources() -> dict[str, Path]:
    """Return the files that decide outcomes, by what they are called within the packages."""
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
    """Return the version with a word that changes with every file of :func:`sources`."""
    found = hashlib.sha256()
    for name, path in sorted(sources().items()):
        content = path.read_bytes()
        found.update(f"{name} {len(content)} ".encode())
        found.update(content)
    return f"{__version__} (sources {found.hexdigest()[:DIGITS]})"
