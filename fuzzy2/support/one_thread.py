"""Linear algebra on one thread."""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import Any

from threadpoolctl import threadpool_limits


def one_thread() -> AbstractContextManager[Any]:
    """Return a context in which this process's linear algebra takes one thread.

    Matrices here are small: threads wait for each other longer than they compute, twenty times as
    long where other processes want the cores, too. And sums are added in another order with every
    number of threads, so that results would depend on the machine.

    Returns
    -------
    context manager
        To be entered in a ``with`` statement, which costs about a millisecond.
    """
    limits: AbstractContextManager[Any] = threadpool_limits(limits=1, user_api="blas")
    return limits
