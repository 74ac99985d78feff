"""The closed form of the 3-PSP at a few states, in Python without compilation."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from typing import Any

from fuzzy2.support.interpreted import are_few_calls, is_ready, twin_of
from psp3.three_psp import closed_form

FEW = 64
"""Nothing is compiled for calls with at most this many states, if only a few calls are expected."""


def are_few(rows: int) -> bool:
    """Tell whether there are too few states to compile anything for them."""
    return rows <= FEW and are_few_calls()


def kernel_of_closed_form(name: str) -> Callable[..., Any]:
    """Return a kernel of the closed form; in Python if only a few calls are expected.

    Parameters
    ----------
    name : str
        Its name in :mod:`psp3.three_psp.closed_form`.
    """
    kernel: Callable[..., Any] = getattr(closed_form, name)
    return twin_of(kernel) if are_few_calls() and not is_ready(kernel) else kernel


class KernelsOnDemand:
    """Represents a robot's closed form until a call after which many others may follow.

    Parameters
    ----------
    robot : object
        Its ``_kernels`` is this object, and is later replaced by the compiled closed form.
    """

    def __init__(self, robot: Any) -> None:
        # A weak reference, because the robot owns this object.
        self._robot = weakref.ref(robot)

    def __getattr__(self, name: str) -> Callable[..., Any]:
        robot = self._robot()
        if robot is not None and not are_few_calls():
            robot._kernels = closed_form
        return kernel_of_closed_form(name)
