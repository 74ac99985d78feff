"""Compilation in commands: avoided if it takes longer than it saves, and reported otherwise."""

from __future__ import annotations

import functools
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from fuzzy2.support.announcements import Compilation
from psp3.cli.output import say

REDRAWN = 0.5
"""Interval at which the finished share is updated [s]."""

MOST = 0.99
"""Largest share that is shown, because the total time is only estimated."""


def one_off(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command that runs without compilation, because it makes only a few evaluations."""

    @functools.wraps(command)
    def run(*arguments: object, **options: object) -> None:
        from fuzzy2.support.interpreted import few_calls

        with few_calls():
            command(*arguments, **options)

    return run


@contextmanager
def compilation_shown(coming: Compilation) -> Iterator[None]:
    """Report compilation on standard error, on a terminal with the estimated progress."""
    say(coming, err=True)
    if not sys.stderr.isatty():
        yield
        return
    done = threading.Event()
    line = threading.Thread(target=_show_share, args=(coming.seconds, done), daemon=True)
    line.start()
    try:
        yield
    finally:
        done.set()
        line.join()


def _show_share(seconds: float, done: threading.Event) -> None:
    """Rewrite a line with the share of the elapsed time, and clear it at the end."""
    begun, text = time.monotonic(), ""
    while not done.wait(REDRAWN):
        share = min((time.monotonic() - begun) / seconds, MOST)
        text = f"{share:.0%}"
        sys.stderr.write(f"\r{text}")
        sys.stderr.flush()
    sys.stderr.write("\r" + " " * len(text) + "\r")
    sys.stderr.flush()
