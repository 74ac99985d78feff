"""The commands that build a scene in the browser.

They are kept, so a page can be written or served at any time.
"""

from __future__ import annotations

import json
import queue
import threading
from typing import Any

import numpy as np

from psp3.errors import InvalidValue

_NUMPY_TYPES = {0x12: np.uint8, 0x15: np.int32, 0x16: np.uint32, 0x17: np.float32}
"""Types of the arrays in MeshCat's commands, by their MessagePack code."""


class DrawingCommands:
    """The commands that build the present scene, in JSON.

    MeshCat uses this object in place of the connection to its server.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._current: dict[tuple[str, ...], str] = {}
        self._subscribers: list[queue.Queue[str | None]] = []
        self._ended = False

    def send(self, command: Any) -> None:
        """Take one of MeshCat's command objects."""
        self.add(command.lower())

    def add(self, command: dict[str, Any]) -> None:
        """Add a command and send it to every subscriber.

        It replaces an earlier command for the same object.

        Raises
        ------
        InvalidValue
            If a number in it is not finite, because browsers cannot read that.
        """
        path = command.get("path", "")
        try:
            text = json.dumps(
                command, default=_as_plain_data, separators=(",", ":"), allow_nan=False
            )
        except ValueError:
            raise InvalidValue(
                "what is drawn", path, "of finite numbers; correct the mesh or the motion"
            ) from None
        with self._lock:
            if command["type"] == "delete":
                for key in [key for key in self._current if f"{key[1]}/".startswith(f"{path}/")]:
                    del self._current[key]
            else:
                key = (command["type"], path, command.get("property", ""))
                # In the order of the last calls: nodes must have their first values before an
                # animation starts, or three.js assumes values that were not set.
                self._current.pop(key, None)
                self._current[key] = text
            for subscriber in self._subscribers:
                subscriber.put(text)

    def as_json(self) -> str:
        """Return all commands as one JSON array."""
        with self._lock:
            return f"[{','.join(self._current.values())}]"

    def subscribe(self) -> queue.Queue[str | None]:
        """Return a queue of all commands up to now and, as they come, all further ones.

        None ends it.
        """
        subscriber: queue.Queue[str | None] = queue.Queue()
        with self._lock:
            for text in self._current.values():
                subscriber.put(text)
            # A browser may connect just as the viewer closes; its subscription would then never
            # end.
            if self._ended:
                subscriber.put(None)
            self._subscribers.append(subscriber)
        return subscriber

    def unsubscribe(self, subscriber: queue.Queue[str | None]) -> None:
        """Send nothing more to a queue."""
        with self._lock:
            self._subscribers.remove(subscriber)

    def end(self) -> None:
        """End all subscriptions, including future ones."""
        with self._lock:
            self._ended = True
            for subscriber in self._subscribers:
                subscriber.put(None)


def _as_plain_data(value: Any) -> Any:
    """Convert data that JSON does not support to lists and numbers.

    These are packed arrays of MeshCat and numbers of NumPy.
    """
    if hasattr(value, "data") and hasattr(value, "type"):
        return np.frombuffer(value.data, _NUMPY_TYPES[value.type]).tolist()
    return np.asarray(value).tolist()
