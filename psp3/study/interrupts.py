"""Ctrl-C while results are saved: noted at once, and obeyed where no result is lost.

Python raises :class:`KeyboardInterrupt` between any two instructions, also within the locks of
:mod:`concurrent.futures`, which then stay locked, and between a result and its way to the disk.
Here the signal only sets a mark, and whoever works looks at it.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType


class Interrupts:
    """Whether Ctrl-C came; :func:`noted_interrupts` gives it.

    Parameters
    ----------
    wake : callable, optional
        Called when it comes, between any two instructions of the main thread: it wakes who waits.
    """

    def __init__(self, wake: Callable[[], None] | None = None) -> None:
        self.came = False
        self._wake, self._obeyed_at_once = wake, False

    def obey(self) -> None:
        """Raise KeyboardInterrupt if Ctrl-C came."""
        if self.came:
            raise KeyboardInterrupt

    @contextmanager
    def obeyed_at_once(self) -> Iterator[None]:
        """Let Ctrl-C end what is done here, between any two instructions of it."""
        try:
            self._obeyed_at_once = True
            self.obey()
            yield
        finally:
            self._obeyed_at_once = False

    @contextmanager
    def waking(self, wake: Callable[[], None] | None) -> Iterator[None]:
        """Wake somebody else meanwhile."""
        before, self._wake = self._wake, wake
        try:
            yield
        finally:
            self._wake = before

    def take(self, number: int, frame: FrameType | None) -> None:
        """Note Ctrl-C; the handler of the signal."""
        self.came = True
        if self._wake is not None:
            self._wake()
        if self._obeyed_at_once:
            raise KeyboardInterrupt


@contextmanager
def noted_interrupts(wake: Callable[[], None] | None = None) -> Iterator[Interrupts]:
    """Note Ctrl-C instead of raising it.

    One that nobody has obeyed until the end is raised there. Signals come to the main thread alone,
    so in another one nothing changes; nor where a program has a handler of its own, which knows
    what it does. Within another one of these it is the same one, which wakes somebody else.

    Parameters
    ----------
    wake : callable, optional
        See :class:`Interrupts`.
    """
    if threading.current_thread() is not threading.main_thread():
        yield Interrupts()
        return
    handler = signal.getsignal(signal.SIGINT)
    outer = getattr(handler, "__self__", None)
    if isinstance(outer, Interrupts):
        with outer.waking(wake):
            yield outer
    elif handler is signal.default_int_handler:
        interrupts = Interrupts(wake)
        try:
            signal.signal(signal.SIGINT, interrupts.take)
            yield interrupts
        finally:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        interrupts.obey()
    else:
        yield Interrupts()
