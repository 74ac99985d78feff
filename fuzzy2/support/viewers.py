"""The function that draws what ``view()`` is called on.

Figures stand above what they show, so nothing that can be shown knows them: the facade, which knows
both, says who draws. Nothing is imported here, because a facade is.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

_viewers: list[Callable[..., Any]] = []


def viewed_by(viewer: Callable[..., Any]) -> None:
    """Say who draws: a function of the thing and of the axes to draw into."""
    _viewers[:] = [viewer]


def viewer() -> Callable[..., Any]:
    """Return who draws."""
    return _viewers[0]
