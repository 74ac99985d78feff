"""The commands of a scene: the latest of each, in the order in which they were last given."""

from __future__ import annotations

import json

import numpy as np
import pytest

from psp3.errors import InvalidValue
from psp3.visualize.commands import DrawingCommands


def listed(commands: DrawingCommands) -> list[tuple[str, object]]:
    return [(one["path"], one.get("value")) for one in json.loads(commands.as_json())]


def test_a_later_command_takes_the_place_of_an_earlier_one_and_comes_last() -> None:
    commands = DrawingCommands()
    for path, value in (("/a", 1), ("/b", 2), ("/a", np.float64(3.0))):
        commands.add({"type": "set_transform", "path": path, "value": value})
    assert listed(commands) == [("/b", 2), ("/a", 3.0)]


def test_what_is_deleted_takes_all_below_it_along_and_nothing_beside_it() -> None:
    commands = DrawingCommands()
    for path in ("/robot", "/robot/arm", "/robots"):
        commands.add({"type": "set_transform", "path": path})
    commands.add({"type": "delete", "path": "/robot"})
    assert listed(commands) == [("/robots", None)]


def test_subscribers_receive_what_was_and_what_comes_until_the_end() -> None:
    commands = DrawingCommands()
    commands.add({"type": "set_transform", "path": "/a"})
    subscriber = commands.subscribe()
    commands.add({"type": "delete", "path": "/a"})
    commands.end()
    received = [subscriber.get_nowait() for _ in range(3)]
    assert [None if text is None else json.loads(text)["type"] for text in received] == [
        "set_transform",
        "delete",
        None,
    ]
    commands.unsubscribe(subscriber)
    commands.add({"type": "set_transform", "path": "/b"})
    assert subscriber.empty()


def test_who_subscribes_after_the_end_receives_what_was_and_the_end() -> None:
    commands = DrawingCommands()
    commands.add({"type": "set_transform", "path": "/a"})
    commands.end()
    late = commands.subscribe()
    assert json.loads(late.get_nowait() or "")["path"] == "/a"
    assert late.get_nowait() is None


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_what_no_browser_reads_is_refused(value: float) -> None:
    commands = DrawingCommands()
    with pytest.raises(InvalidValue, match="what is drawn must be of finite numbers"):
        commands.add({"type": "set_object", "path": "/mesh", "points": np.array([value])})
    assert listed(commands) == []
