"""Panels for figures: those of fuzzy2, with the errors of this package."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes

from fuzzy2.plots import panels
from fuzzy2.plots.panels import Panels as Panels
from fuzzy2.plots.panels import muted as muted
from psp3.checks import checked_kind
from psp3.errors import InvalidValue
from psp3.simulation.result import Result


def checked_result(result: object) -> None:
    """Raise :class:`InvalidValue` if a value is not the result of a simulation."""
    checked_kind("result", result, Result, "a result, as psp3.simulate returns it")


def checked_title(title: object, name: str = "title") -> None:
    """Raise :class:`InvalidValue` if a title is not a text, because matplotlib draws any object."""
    checked_kind(name, title, str, "a text")


def given_panels(axes: Sequence[Axes] | None, count: int) -> Panels | None:
    """Return the panels to draw into, None if none are given; refuse a wrong number."""
    return panels.given_panels(axes, count, InvalidValue)
