"""The layout of a robot's memory in C, which is as small as its functions allow.

The translated tree says where each part begins, so parts that are never needed at the same time can
share a place. The pose is first. Behind it the data for closing the loops and the results of a
closed pose share one place. The scratch space of both comes last.
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
"""Number of scratch vectors for the forces of a motion; accelerations of many motors take one
more."""


POSE, FORCES, COLUMNS, RATES = range(4)
"""Levels of requests to a closed pose; each includes those before: the pose itself; the forces of a
motion; L and data of its columns, such as a mass matrix or a Jacobian; the rates of these, such as
C.
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
        Its ``AT_SECOND_RATES`` is the size of the memory, because nothing follows.
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
    """Write where consecutive parts begin, and return where they end."""
    for part in parts:
        tree[part], start = start, start + sizes[part]
    return start
