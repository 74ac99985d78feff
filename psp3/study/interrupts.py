"""Ctrl-C while results are saved: noted at once, and obeyed at a point where no result is lost.

Python raises :class:`KeyboardInterrupt` between any two instructions, also within the locks of
:mod:`concurrent.futures`, which then stay locked, and between a result and its way to the disk.
Here the signal only sets a flag, which the working code checks at safe points.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType


class Interrupts:
    """Whether Ctrl-C came; made by :func:`noted_interrupts`.

    Parameters
    ----------
    wake : callable, optional
        Called when Ctrl-C comes, between any two instructions of the main thread, to wake a waiting
        thread.
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
        """Let Ctrl-C interrupt the block between any two instructions."""
        try:
            self._obeyed_at_once = True
            self.obey()
            yield
        finally:
            self._obeyed_at_once = False

    @contextmanager
    def waking(self, wake: Callable[[], None] | None) -> Iterator[None]:
        """Call another ``wake`` within the block."""
        before, self._wake = self._wake, wake
        try:
            yield
        finally:
            self._wake = before

    def take(self, number: int, frame: FrameType | None) -> None:
        """Note Ctrl-C; this is the signal handler."""
        self.came = True
        if self._wake is not None:
            self._wake()
        if self._obeyed_at_once:
            raise KeyboardInterrupt


@contextmanager
def noted_interrupts(wake: Callable[[], None] | None = None) -> Iterator[Interrupts]:
    """Note Ctrl-C instead of raising it.

    A Ctrl-C that was not obeyed within the block is raised at its end. Signals come to the main
    thread only, so in another thread nothing changes. A program's own signal handler is left in
    place, too. Nested blocks share one object; the inner block only replaces ``wake``.

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
