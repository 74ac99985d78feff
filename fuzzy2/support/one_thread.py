"""Linear algebra on a single thread."""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import Any

from threadpoolctl import threadpool_limits


def one_thread() -> AbstractContextManager[Any]:
    """Return a context in which linear algebra of this process uses a single thread.

    Matrices here are small, so threads would wait for each other longer than they compute, and
    twenty times as long if other processes need the cores, too. In addition, the order of summation
    depends on the number of threads, so results would depend on the machine.

    Returns
    -------
    context manager
        Context manager for a ``with`` statement; entering it costs about a millisecond.
    """
    limits: AbstractContextManager[Any] = threadpool_limits(limits=1, user_api="blas")
    return limits
