"""Answer questions while a robot is constructed, in Python if there are few of them."""

from __future__ import annotations

from typing import Any

import numpy as np

from fuzzy2.support.compiled import only_for
from fuzzy2.support.interpreted import is_ready, twin_of
from psp3.checks import Array, Indices
from psp3.multibody.motion import CONFIGURATION, answer
from psp3.multibody.tree import SIZE


def first_answer(*arguments: Any) -> int:
    """Answer as :func:`psp3.multibody.motion.answer` does, but without compiling it.

    A robot whose loops are closed at home needs about a hundred answers during its construction. In
    Python they take about as long as loading the compiled code from the disk.
    """
    kernel: Any = answer if is_ready(answer) else twin_of(answer)
    answered: int = kernel(*arguments)
    return answered


def compile_answers(tree: Indices, numbers: Array) -> None:
    """Compile the answers for writable arrays, the only type of argument they are called with.

    Parameters
    ----------
    tree, numbers : ndarray
        The arrays of any robot.
    """
    none, memory = np.empty(0), np.empty(int(tree[SIZE]))
    only_for(
        answer,
        *(CONFIGURATION, 0, 0, 0),
        *(tree, numbers.copy(), np.zeros(3), memory, np.empty_like(memory)),
        *(none, none, none, none),
    )
