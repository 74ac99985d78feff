"""The function that implements ``view()``.

Figures import the objects that they show, so these objects cannot import figures. The facade
imports both and registers the function that draws. This module imports nothing, because the facade
imports it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

_viewers: list[Callable[..., Any]] = []


def viewed_by(viewer: Callable[..., Any]) -> None:
    """Register the function that draws an object into axes."""
    _viewers[:] = [viewer]


def viewer() -> Callable[..., Any]:
    """Return the registered function."""
    return _viewers[0]
