"""Compilation that waits for the first call.

A fuzzy system or a controller compiles its functions when it is made, so that a control loop never
waits in its first step. In a simulation these functions are parts of a compiled loop, and may never
be called by themselves: a third of the time of the first simulation would be spent on them.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_IS_DEFERRED: ContextVar[bool] = ContextVar("_IS_DEFERRED", default=False)


@contextmanager
def deferred_compilation() -> Iterator[None]:
    """Compile the functions of what is made in this context at their first call.

    This holds for one thread.
    """
    before = _IS_DEFERRED.set(True)
    try:
        yield
    finally:
        _IS_DEFERRED.reset(before)


def is_deferred() -> bool:
    """Tell whether functions should be compiled at their first call."""
    return _IS_DEFERRED.get()
