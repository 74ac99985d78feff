"""Objects of every public class can be pickled and copied, and used in forked and new processes.

What comes back holds the same numbers, to the bit, and answers the same.
"""

from __future__ import annotations

import copy
import multiprocessing
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from tests.endurance.copies import (
    EXAMPLES,
    NONE_OF_THEIR_OWN,
    answers,
    numbers_in,
    public_classes,
)

WAYS: dict[str, Callable[[Any], Any]] = {
    "pickle": lambda one: pickle.loads(pickle.dumps(one)),
    "deepcopy": copy.deepcopy,
    "copy": copy.copy,
}


@pytest.fixture(scope="module")
def objects(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    folder = tmp_path_factory.mktemp("copies")
    return {name: make(folder) for name, make in EXAMPLES.items()}


@pytest.fixture(scope="module")
def expected(objects: dict[str, Any]) -> dict[str, list[bytes]]:
    return {name: answers(one) for name, one in objects.items()}


def test_no_public_class_is_left_out() -> None:
    assert set(public_classes()) == {*EXAMPLES, *NONE_OF_THEIR_OWN}


@pytest.mark.slow
@pytest.mark.parametrize("name", EXAMPLES)
def test_copies_hold_and_answer_the_same(
    name: str, objects: dict[str, Any], expected: dict[str, list[bytes]]
) -> None:
    one = objects[name]
    assert isinstance(one, public_classes()[name])
    for way, copied in WAYS.items():
        other = copied(one)
        assert type(other) is type(one), way
        assert numbers_in(other) == numbers_in(one), way
        assert answers(other) == expected[name], way
    assert answers(one) == expected[name], "nor did what was asked of copies change it"


def answered(pickled: dict[str, bytes]) -> dict[str, list[bytes]]:
    return {name: answers(pickle.loads(one)) for name, one in pickled.items()}


@pytest.mark.slow
@pytest.mark.parametrize("way", ["fork", "forkserver", "spawn"])
def test_other_processes_answer_the_same(
    way: str, objects: dict[str, Any], expected: dict[str, list[bytes]]
) -> None:
    pickled = {name: pickle.dumps(one) for name, one in objects.items()}
    assert sum(map(bool, expected.values())) > 40
    with multiprocessing.get_context(way).Pool(1) as pool:
        assert pool.apply(answered, (pickled,)) == expected


def batches(robot: Any) -> Any:
    """Return what takes all cores: many rows."""
    rows = robot.reference + np.linspace(-0.01, 0.01, 40_000)[:, np.newaxis]
    return robot.inverse_dynamics(rows, rows, rows)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["PSP3", "ClosedLoopRobot"])
def test_threads_of_a_forked_process(name: str, objects: dict[str, Any]) -> None:
    """A fork has none of the threads that its parent has used for batches."""
    robot = objects[name]
    expected = batches(robot)
    with multiprocessing.get_context("fork").Pool(2) as pool:
        for found in pool.map(batches, [robot] * 4):
            assert found.tobytes() == expected.tobytes()
