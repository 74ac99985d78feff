"""The closed form of the 3-PSP at a few states, for which nothing is compiled."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from typing import Any

from fuzzy2.support.interpreted import are_few_calls, is_ready, twin_of
from psp3.three_psp import closed_form

FEW = 64
"""States of a call for which nothing is compiled where only a few calls are to come."""


def are_few(rows: int) -> bool:
    """Tell whether states are so few that nothing should be compiled for them."""
    return rows <= FEW and are_few_calls()


def kernel_of_closed_form(name: str) -> Callable[..., Any]:
    """Return a kernel of the closed form: in Python where only a few calls are to come.

    Parameters
    ----------
    name : str
        Its name in :mod:`psp3.three_psp.closed_form`.
    """
    kernel: Callable[..., Any] = getattr(closed_form, name)
    return twin_of(kernel) if are_few_calls() and not is_ready(kernel) else kernel


class KernelsOnDemand:
    """Stands for a robot's closed form until it is first called when many calls may follow.

    Parameters
    ----------
    robot : object
        Its ``_kernels`` is this object, and becomes the compiled closed form.
    """

    def __init__(self, robot: Any) -> None:
        # Not the robot itself, which would be its own owner then.
        self._robot = weakref.ref(robot)

    def __getattr__(self, name: str) -> Callable[..., Any]:
        robot = self._robot()
        if robot is not None and not are_few_calls():
            robot._kernels = closed_form
        return kernel_of_closed_form(name)
