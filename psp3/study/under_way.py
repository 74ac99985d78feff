"""Work in progress: items handed out and returned, and a way to wake a waiting thread."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor, Future
from queue import Empty, SimpleQueue
from typing import Any, Generic, TypeVar

Work = TypeVar("Work")
Found = TypeVar("Found")


class UnderWay(Generic[Work, Found]):
    """What executors do at the moment.

    Not :func:`concurrent.futures.wait`: nobody can wake it, and an interrupt within it leaves locks
    behind. A simple queue can be put into by handlers of signals.
    """

    def __init__(self) -> None:
        self._work: dict[Future[Found], Work] = {}
        self._back: SimpleQueue[Future[Found] | None] = SimpleQueue()

    def __len__(self) -> int:
        return len(self._work)

    def __getitem__(self, future: Future[Found]) -> Work:
        return self._work[future]

    def hand_out(
        self, executor: Executor, work: Work, function: Callable[..., Found], *arguments: Any
    ) -> None:
        """Let an executor call a function."""
        future = executor.submit(function, *arguments)
        self._work[future] = work
        future.add_done_callback(self._back.put)

    def wake(self) -> None:
        """End the waiting of :meth:`finished`."""
        self._back.put(None)

    def finished(self, patience: float | None = None) -> list[Future[Found]]:
        """Return what has come back, waiting for the first of it; nothing when it was woken.

        It stays under way until it is taken.

        Parameters
        ----------
        patience : float, optional
            How long to wait [s]; without end unless given.
        """
        found: list[Future[Found] | None] = []
        try:
            found.append(self._back.get(timeout=patience))
            while True:
                found.append(self._back.get_nowait())
        except Empty:
            return [future for future in found if future is not None and future in self._work]

    def take(self, future: Future[Found]) -> Work:
        """Return what was to be done; it is not under way any more."""
        return self._work.pop(future)

    def cancel(self) -> None:
        """Forget what has not begun."""
        for future in [future for future in self._work if future.cancel()]:
            del self._work[future]
