"""Where the parts of a robot's memory are in C: as few numbers as what is asked for takes.

The tree that is translated says where each part begins, so parts that are never needed at the same
time can have the same place: behind the pose stand in one place what closes the loops and what
comes of a closed pose, and behind these what both take.
"""

from __future__ import annotations

import numpy as np

from psp3.checks import Indices
from psp3.multibody.tree import (
    AT_ACROSS,
    AT_BEFORE,
    AT_BEFORE_REFLECTIONS,
    AT_COMPLEMENT,
    AT_COMPLEMENT_RATES,
    AT_FIELDS,
    AT_GROUPS,
    AT_JOINT_SPEEDS,
    AT_MASS,
    AT_RATES,
    AT_REPORT,
    AT_RESIDUAL,
    AT_RIGHT,
    AT_ROOM,
    AT_SECOND_RATES,
    GROUP_COLUMNS,
    GROUP_INTEGERS,
    GROUPS,
    INDEPENDENT,
    IS_SQUARE,
    SIZE,
)

THROUGHOUT = (AT_RESIDUAL, AT_RIGHT, AT_REPORT)
CLOSING = tuple(at for at in range(AT_BEFORE, AT_ACROSS + 1) if at not in THROUGHOUT)
DYNAMICS = tuple(range(AT_JOINT_SPEEDS, AT_ROOM + 1))

ROOM_OF_FORCES = 4
"""Vectors of the room that forces of a motion take; accelerations of many motors take one more."""


POSE, FORCES, COLUMNS, RATES = range(4)
"""What is asked of a closed pose, each with all before: itself; the forces of a motion; L and what
belongs to its columns, as a mass matrix or a Jacobian; how these change, as C.
"""


def laid_out(tree: Indices, asked: int) -> Indices:
    """Return a tree whose memory has no more than it needs.

    Parameters
    ----------
    tree : ndarray of int
        The tree of a core.
    asked : int
        ``POSE``, ``FORCES``, ``COLUMNS`` or ``RATES``.

    Returns
    -------
    ndarray of int
        Its ``AT_SECOND_RATES`` is the size of the memory; behind stands nothing.
    """
    sizes = {at: int(tree[at + 1] - tree[at]) for at in range(AT_BEFORE, AT_SECOND_RATES)}
    groups = tree[int(tree[AT_GROUPS]) :][: GROUP_INTEGERS * int(tree[GROUPS])]
    groups = groups.reshape(-1, GROUP_INTEGERS)
    turning = groups[groups[:, IS_SQUARE] == 0]
    if not len(turning):
        sizes[AT_BEFORE] = sizes[AT_BEFORE_REFLECTIONS] = 0
    sizes[AT_ACROSS] = int(np.max(turning[:, GROUP_COLUMNS] ** 2, initial=0))
    if asked < RATES:
        sizes[AT_RATES] = sizes[AT_COMPLEMENT_RATES] = 0
    if asked < COLUMNS:
        sizes[AT_FIELDS] = sizes[AT_COMPLEMENT] = sizes[AT_MASS] = 0
        sizes[AT_ROOM] = ROOM_OF_FORCES * int(tree[INDEPENDENT])
    new, pose = tree.copy(), int(tree[AT_BEFORE])
    end = _place(new, CLOSING, sizes, pose)
    if asked > POSE:
        end = max(end, _place(new, DYNAMICS, sizes, pose))
    new[AT_SECOND_RATES : SIZE + 1] = _place(new, THROUGHOUT, sizes, end)
    return new


def _place(tree: Indices, parts: tuple[int, ...], sizes: dict[int, int], start: int) -> int:
    """Write where parts begin that follow on one another, and return where they end."""
    for part in parts:
        tree[part], start = start, start + sizes[part]
    return start
