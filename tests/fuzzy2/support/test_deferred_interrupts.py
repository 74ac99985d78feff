"""Ctrl-C waits for the end, and then does what it does otherwise."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator

import pytest

from fuzzy2.support.deferred_interrupts import deferred_interrupts


@pytest.fixture(autouse=True)
def default_handler() -> Iterator[None]:
    """Let Ctrl-C do what it does by default, however the tests were started."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def interrupted(done: list[str]) -> None:
    with deferred_interrupts():
        signal.raise_signal(signal.SIGINT)
        done.append("all")
    done.append("more")


def test_an_interrupt_is_raised_at_the_end() -> None:
    done: list[str] = []
    with pytest.raises(KeyboardInterrupt):
        interrupted(done)
    assert done == ["all"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_handler_of_a_program_is_called_at_the_end() -> None:
    done: list[str] = []
    signal.signal(signal.SIGINT, lambda *_: done.append("handled"))
    interrupted(done)
    assert done == ["all", "handled", "more"]


def test_without_one_nothing_is_raised() -> None:
    with deferred_interrupts():
        pass
    with pytest.raises(ZeroDivisionError), deferred_interrupts():
        raise ZeroDivisionError


def test_where_it_is_ignored_it_stays_ignored() -> None:
    done: list[str] = []
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    interrupted(done)
    assert done == ["all", "more"]
    assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN


def test_other_threads_change_nothing() -> None:
    found = []

    def work() -> None:
        with deferred_interrupts():
            found.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert found == [signal.default_int_handler]
