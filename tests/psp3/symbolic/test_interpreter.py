"""Kernels on symbols give what they give on numbers: branches, loops that end early, memory."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import casadi
import numpy as np
import pytest

from fuzzy2.support.compiled import compiled
from psp3.symbolic.interpreter import Interpreter
from psp3.symbolic.memory import piece_of, piece_with, symbols_in
from tests.helpers import Array


def branches(x: Any, out: Any) -> None:
    if x[0] < 0.0:
        out[0], out[1] = -x[0], 1.0
    elif x[0] < 1.0:
        out[0] = x[1] if x[1] > x[0] else 2.0 * x[0]
    else:
        out[1] = max(x[0], x[1], 0.5)
    out[1] += 1.0


def early_return(x: Any, out: Any) -> None:
    out[0] = 1.0
    if x[0] < 0.0:
        return
    out[0] = 2.0
    if x[1] < 0.0:
        out[1] = 5.0
        return
    out[0] += math.sqrt(x[0])


def leaves_loop(x: Any, out: Any) -> None:
    """Walk along until a sum is passed, as the search for a switch point does."""
    total, i, settled = 0.0, 0, True
    while i < 6:
        if not total < x[0]:
            settled = settled and (total > 2.0 or x[1] < 0.0)
            break
        total += abs(x[1]) + 0.1 * i
        i += 1
    out[0] = total
    out[1] = 1.0 if settled else 0.0


def leaves_turn(x: Any, out: Any) -> None:
    for i in range(30):
        if x[0] > 0.1 * i:
            continue
        out[0] += 0.1 * i * x[1]
        if out[0] > 2.0:
            break
    out[1] = out[0]


def returns_from_loop(x: Any, out: Any) -> None:
    out[0] = float(first_above(x, x[0]))


def first_above(x: Any, limit: Any) -> Any:
    for i in range(8):
        if 0.5 * i > limit:
            return 0.5 * i + x[1]
    return -1.0


class Pair(NamedTuple):
    """Two numbers."""

    a: Any
    b: Any


@compiled
def ordered(a: Any, b: Any) -> Any:
    return (a, b) if a < b else (b, a)


def calls(x: Any, out: Any) -> None:
    low, high = ordered(x[0], x[1])
    pair = Pair(low, high)
    half = out[:2].reshape(1, 2)
    half[0, 0] = pair.a * 2.0
    half[0, 1] = pair[1]
    if 0.0 < low <= high and not (high > 2.0 or low > 1.5):
        out[:1] = 9.0


KERNELS = (branches, early_return, leaves_loop, leaves_turn, returns_from_loop, calls)
STATES = [np.array([a, b]) for a in (-1.0, 0.0, 0.3, 0.9, 1.0, 1.7, 2.5) for b in (-0.8, 0.4, 1.2)]


def on_symbols(kernel: Callable[..., None]) -> casadi.Function:
    x, out = casadi.SX.sym("x", 2), piece_with([0.0, 0.0])
    Interpreter().call(kernel, symbols_in(x), out)
    return casadi.Function("f", [x], [casadi.vertcat(*out.cells)])


@pytest.mark.parametrize("kernel", KERNELS, ids=lambda kernel: kernel.__name__)
def test_kernels_on_symbols_are_those_on_numbers(kernel: Callable[..., None]) -> None:
    function = on_symbols(kernel)
    for state in STATES:
        expected: Array = np.zeros(2)
        kernel(state, expected)
        assert function(state).full().ravel() == pytest.approx(expected, abs=1e-15)
        known = piece_with([0.0, 0.0])
        Interpreter().call(kernel, piece_of(state), known)
        assert known.cells == pytest.approx(expected, abs=1e-15)


def test_a_loop_of_turns_that_are_left_grows_with_their_number() -> None:
    """And not with two to the power of it."""
    assert on_symbols(leaves_turn).n_instructions() < 1000


def test_derivatives_are_those_of_the_way_that_is_taken() -> None:
    x = casadi.SX.sym("x", 2)
    slope = casadi.Function("slope", [x], [casadi.jacobian(on_symbols(early_return)(x), x)])
    assert slope([4.0, 1.0]).full() == pytest.approx(np.array([[0.25, 0.0], [0.0, 0.0]]))
    assert slope([-4.0, 1.0]).full() == pytest.approx(np.zeros((2, 2)))


def places_a_symbol(x: Any, out: Any) -> None:
    out[int(x[0])] = 1.0


def asks_for_more(x: Any, out: Any) -> None:
    out[0] = sum([x[0] for _ in range(2)])


@pytest.mark.parametrize(
    ("kernel", "reason"), [(places_a_symbol, "symbol"), (asks_for_more, "asks_for_more, line")]
)
def test_what_is_no_kernel_is_refused(kernel: Callable[..., None], reason: str) -> None:
    with pytest.raises(TypeError, match=reason):
        on_symbols(kernel)
