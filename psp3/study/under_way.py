"""Work in progress: items handed out and returned, and a way to wake a waiting thread."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor, Future
from queue import Empty, SimpleQueue
from typing import Any, Generic, TypeVar

Work = TypeVar("Work")
Found = TypeVar("Found")


class UnderWay(Generic[Work, Found]):
    """The work that executors are doing now.

    :func:`concurrent.futures.wait` does not suffice: it cannot be woken, and an interrupt within it
    leaves locks held. Signal handlers may put items into a ``SimpleQueue``, so one is used here.
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
        """Let an executor call a function on an item."""
        future = executor.submit(function, *arguments)
        self._work[future] = work
        future.add_done_callback(self._back.put)

    def wake(self) -> None:
        """End the wait of :meth:`finished`."""
        self._back.put(None)

    def finished(self, patience: float | None = None) -> list[Future[Found]]:
        """Wait until at least one future is finished and return all that are; none if woken.

        They stay under way until :meth:`take` removes them.

        Parameters
        ----------
        patience : float, optional
            How long to wait [s]; without limit by default.
        """
        found: list[Future[Found] | None] = []
        try:
            found.append(self._back.get(timeout=patience))
            while True:
                found.append(self._back.get_nowait())
        except Empty:
            return [future for future in found if future is not None and future in self._work]

    def take(self, future: Future[Found]) -> Work:
        """Return the item of a future, which is then no longer under way."""
        return self._work.pop(future)

    def cancel(self) -> None:
        """Cancel the items that have not begun."""
        for future in [future for future in self._work if future.cancel()]:
            del self._work[future]
