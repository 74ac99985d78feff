"""Ctrl-C is noted at once, and raised where it was allowed or at the end."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from queue import SimpleQueue

import pytest

from psp3.study.interrupts import Interrupts, noted_interrupts
from tests.processes import PATIENCE


@pytest.fixture(autouse=True)
def default_handler() -> Iterator[None]:
    """Let signals do what they do by default, however the tests were started."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def interrupt() -> None:
    """Do what Ctrl-C does; the handler has run when this returns."""
    os.kill(os.getpid(), signal.SIGINT)


def test_an_interrupt_is_noted_and_raised_at_the_end() -> None:
    passed = []

    def interrupted() -> None:
        with noted_interrupts() as interrupts:
            interrupt()
            passed.append(interrupts.came)

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert passed == [True]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_without_one_nothing_is_raised() -> None:
    with noted_interrupts() as interrupts:
        interrupts.obey()
        with interrupts.obeyed_at_once():
            pass
    assert not interrupts.came


@pytest.mark.parametrize("before", [True, False])
def test_it_is_obeyed_at_once_where_that_is_allowed(before: bool) -> None:
    passed = []

    def interrupted() -> None:
        with noted_interrupts() as interrupts:
            if before:
                interrupt()
            with interrupts.obeyed_at_once():
                passed.append("in")
                interrupt()
                passed.append("on")

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert passed == ([] if before else ["in"])


def test_it_wakes_who_waits() -> None:
    queue: SimpleQueue[None] = SimpleQueue()

    def interrupted() -> None:
        with noted_interrupts(lambda: queue.put(None)):
            threading.Timer(0.05, interrupt).start()
            # To the end of patience, if nobody wakes it.
            queue.get(timeout=PATIENCE)

    with pytest.raises(KeyboardInterrupt):
        interrupted()


def test_one_within_another_is_the_same_and_wakes_its_own() -> None:
    woken: list[str] = []

    def interrupted() -> None:
        with noted_interrupts(lambda: woken.append("outer")) as outer:
            with noted_interrupts(lambda: woken.append("inner")) as inner:
                assert inner is outer
                interrupt()
            interrupt()

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert woken == ["inner", "outer"]


def test_handlers_of_a_program_stay() -> None:
    came: list[int] = []
    signal.signal(signal.SIGINT, lambda number, frame: came.append(number))
    with noted_interrupts() as interrupts:
        interrupt()
    assert (came, interrupts.came) == ([signal.SIGINT], False)


def test_other_threads_have_none() -> None:
    found: list[Interrupts] = []

    def in_a_thread() -> None:
        with noted_interrupts() as interrupts:
            found.append(interrupts)

    with noted_interrupts() as ours:
        thread = threading.Thread(target=in_a_thread)
        thread.start()
        thread.join()
    assert found[0] is not ours
