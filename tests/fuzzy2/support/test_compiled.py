"""Functions that are chosen by the type of a table, in Python and in compiled code."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np
import pytest
from numba.core.compiler_lock import global_compiler_lock
from numba.core.errors import TypingError

from fuzzy2.support import compile_unit
from fuzzy2.support.compiled import chosen_by_table, compiled, only_for


class Line(NamedTuple):
    """Of one coefficient."""

    slope: np.ndarray


class Parabola(NamedTuple):
    """Of two."""

    slope: np.ndarray
    bend: np.ndarray


class Unknown(NamedTuple):
    """Of which nothing is registered."""

    slope: np.ndarray


@chosen_by_table
def value(curve: Any, x: float) -> float:
    """Return the value of a curve."""
    raise NotImplementedError


@value.register(Line)
def _of_line(curve: Line, x: float) -> float:
    result: float = curve.slope[0] * x
    return result


@value.register(Parabola)
@compiled
def _of_parabola(curve: Parabola, x: float) -> float:
    result: float = curve.slope[0] * x + curve.bend[0] * x * x
    return result


@compiled
def total(curve: Any, count: int) -> float:
    """Return the sum of a curve's values at the first whole numbers."""
    result = 0.0
    for x in range(count):
        result += value(curve, float(x))
    return result


LINE, PARABOLA = Line(np.array([2.0])), Parabola(np.array([2.0]), np.array([3.0]))


def test_each_table_has_its_own_body() -> None:
    assert total(LINE, 4) == 2.0 * 6.0
    assert total(PARABOLA, 4) == 2.0 * 6.0 + 3.0 * 14.0


def test_in_python_it_is_the_same() -> None:
    assert value(LINE, 3.0) == 6.0
    assert value(PARABOLA, 3.0) == 33.0


def test_a_table_of_no_body_is_refused() -> None:
    with pytest.raises(TypingError, match="value"):
        total(Unknown(np.ones(1)), 2)
    with pytest.raises(KeyError):
        value(Unknown(np.ones(1)), 2.0)


def test_a_function_is_opened_for_types_one_after_the_other_and_closed_to_all_others() -> None:
    @compiled
    def twice(x: Any) -> Any:
        return x + x

    one, whole = np.ones(1), np.ones(1, dtype=np.int64)
    assert only_for(twice, one) is twice
    with pytest.raises(TypeError, match="No matching definition"):
        twice(whole)
    for _ in range(2):
        only_for(twice, whole)
        assert twice(whole)[0] == twice(one)[0] == 2
        with pytest.raises(TypeError, match="No matching definition"):
            twice("a")


def test_what_has_been_asked_for_waits_for_no_compiler() -> None:
    @compiled
    def half(x: float) -> float:
        return 0.5 * x

    only_for(half, 1.0)
    with ThreadPoolExecutor(1) as pool, global_compiler_lock:
        assert pool.submit(only_for, half, 1.0).result(timeout=30.0) is half


class Interrupted:
    """A lock, and Ctrl-C as soon as it is locked, before the block that it guards has begun."""

    def __init__(self) -> None:
        self.lock = threading.RLock()

    def __enter__(self) -> None:
        self.lock.acquire()
        signal.raise_signal(signal.SIGINT)

    def __exit__(self, *_: object) -> None:
        self.lock.release()


@pytest.mark.parametrize("ask", [only_for, lambda function, x: function(x)])
def test_ctrl_c_does_not_leave_the_compiler_locked(
    ask: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Other threads would wait for it for ever."""

    @compiled
    def half(x: float) -> float:
        return 0.5 * x

    lock = Interrupted()
    monkeypatch.setattr(compile_unit, "global_compiler_lock", lock)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            ask(half, 1.0)
    finally:
        signal.signal(signal.SIGINT, before)
    with ThreadPoolExecutor(1) as pool:
        assert pool.submit(lock.lock.acquire, blocking=False).result()


def test_who_waited_for_code_finds_it_though_the_function_is_closed_by_then() -> None:
    """A thread that asks while another compiles, and gets its turn after :func:`only_for`."""

    @compiled
    def half(x: float) -> float:
        return 0.5 * x

    with ThreadPoolExecutor(1) as pool:
        with global_compiler_lock:
            waiting = pool.submit(half, 3.0)
            while not waiting.running():
                time.sleep(0.001)
            time.sleep(0.05)
            only_for(half, 1.0)
        assert waiting.result() == 1.5
    with pytest.raises(TypeError):
        half(1j)
