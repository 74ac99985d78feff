"""Write the files of all robots except the 3-PSP.

``<name>.urdf``, ``.srdf`` and ``.yaml``, or ``<name>.xml``.

Run by ``python urdf/make_robots.py [directory]``.

Every length is written once, in the module of its robot in ``making``. Every mass and inertia is
computed from the drawn solids: a box, a ball, a rod or a tube with the density of its material. The
base is drawn but never moves, so it has no mass. README.md gives the sources of the numbers.
"""

from __future__ import annotations

import sys
from pathlib import Path

from making.agile_eye import agile_eye
from making.biped import biped
from making.delta import delta
from making.five_bar import five_bar
from making.gough_stewart import gough_stewart
from making.gripper import gripper
from making.hexa import hexa
from making.jansen import jansen
from making.planar_rrr import planar_3rrr, planar_4rrr
from making.tricept import tricept

HERE = Path(__file__).resolve().parent

ROBOTS = (
    five_bar,
    planar_3rrr,
    delta,
    gough_stewart,
    tricept,
    planar_4rrr,
    jansen,
    agile_eye,
    hexa,
    gripper,
    biped,
)


def main(directory: str | Path = HERE) -> None:
    """Write all files into a directory."""
    for build in ROBOTS:
        for name, text in build().texts().items():
            (Path(directory) / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
