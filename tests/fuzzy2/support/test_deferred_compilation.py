"""Compilation that waits for the first call, of one thread."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

import psp3
from fuzzy2.support.compiled import compiled, only_for
from fuzzy2.support.deferred_compilation import deferred_compilation, is_deferred


def test_it_holds_in_its_context_and_its_thread() -> None:
    assert not is_deferred()
    with deferred_compilation():
        assert is_deferred()
        with deferred_compilation():
            pass
        assert is_deferred()
        with ThreadPoolExecutor(1) as pool:
            assert not pool.submit(is_deferred).result()
    assert not is_deferred()


def test_a_deferred_function_is_compiled_by_its_first_call_and_for_nothing_else() -> None:
    @compiled
    def twice(x: Any) -> Any:
        return x + x

    kernel: Any = twice
    with deferred_compilation():
        only_for(twice, np.ones(1))
        assert not kernel.overloads
        for other in ("a", [1.0], np.ones(1, dtype=np.int64), 1j):
            with pytest.raises(TypeError, match="No matching definition"):
                twice(other)
        assert not kernel.overloads
    assert twice(np.ones(1))[0] == 2.0
    with pytest.raises(TypeError, match="No matching definition"):
        twice("a")
    assert len(kernel.overloads) == 1


def test_what_is_made_at_once_is_compiled_at_once() -> None:
    @compiled
    def half(x: float) -> float:
        return 0.5 * x

    kernel: Any = half
    with deferred_compilation():
        only_for(half, 1.0)
    only_for(half, 1.0)
    assert len(kernel.overloads) == 1


def test_a_controller_answers_the_same_compiled_late_or_at_once() -> None:
    """Lists go the longer way, also in the first call; the machine code is one."""
    robot = psp3.load("psp3")
    helix = psp3.trajectories.Helix(robot=robot)
    made = psp3.FuzzyComputedTorque("t1", robot).fit(helix, 1.0)
    with deferred_compilation():
        late = psp3.FuzzyComputedTorque("t1", robot).fit(helix, 1.0)
    heights, speeds, desired = [0.01, 0.0, -0.01], np.zeros(3), helix(0.2)
    np.testing.assert_array_equal(
        late.torque(0.0, heights, speeds, desired), made.torque(0.0, heights, speeds, desired)
    )
