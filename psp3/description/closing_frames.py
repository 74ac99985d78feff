"""Loops that a URDF declares through the names of its frames.

A URDF is a tree. Where a mate ``closing_<name>`` would close a loop, onshape-to-robot writes two
frames instead, ``closing_<name>_1`` and ``closing_<name>_2``. Their origins coincide in the
assembled robot. The examples of PlaCo join the two frames in the same way.

The URDF does not state the kind of the mate, with one exception: for a hinge, onshape-to-robot adds
two more frames on its axis, ``closing_<name>_1_z`` and ``closing_<name>_2_z`` (its MuJoCo files
join both pairs at a point). So a pair with these frames is read as a hinge, and every other pair as
a point. Other kinds, such as a weld or a slider, are declared with ``closures=`` or in a loop file.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import pinocchio as pin

from psp3.errors import InvalidRobotFile

CLOSING = re.compile(r"(closing_.+_)([12])")
"""Names of the two frames of a loop."""


def closing_frames(
    path: Path, model: pin.Model, given: Sequence[tuple[str, str, str]] = ()
) -> list[tuple[str, str, str]]:
    """Return the loops that frame names declare: two frames, and ``"3d"`` or ``"hinge"``.

    Parameters
    ----------
    path : path
        The URDF, for error messages.
    model : pinocchio.Model
        Its tree.
    given : sequence of (str, str, str)
        Loops that are declared in another way; their frames are skipped.

    Raises
    ------
    InvalidRobotFile
        If only one of the two frames exists.
    """
    names = dict.fromkeys(frame.name for frame in model.frames)
    joined = {name for first, second, _ in given for name in (first, second)}
    loops = []
    for name in names:
        match = CLOSING.fullmatch(name)
        if match is None or name in joined:
            continue
        other = f"{match[1]}{3 - int(match[2])}"
        if other not in names:
            raise InvalidRobotFile(
                path,
                f"frame {name!r} closes a loop with {other!r}, which is not there: rename "
                "one of them, or say what it joins with closures=[...] or in a loop file",
            )
        if match[2] == "1" and other not in joined:
            hinge = {f"{name}_z", f"{other}_z"} <= names.keys()
            loops.append((name, other, "hinge" if hinge else "3d"))
    return loops
