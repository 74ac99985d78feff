"""Checks of what users give to a simulation: objects of their own, and what these return."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from psp3.checks import Array, as_floats
from psp3.errors import InvalidArray, InvalidValue

METHODS = {
    "controller": ("torque", "reset"),
    "trajectory": ("__call__",),
    "plant": ("start", "advance"),
    "progress": ("__call__",),
}
"""The methods that an object needs."""

OPTIONAL = ("plant", "progress")
"""Objects that may be None."""

NUMBERS = "biuf"
"""Kinds of NumPy's real numbers. NumPy would also convert text and complex numbers to floats."""


def check_objects(**given: object) -> None:
    """Refuse objects without the methods that a simulation calls.

    Raises
    ------
    InvalidValue
        If a controller, a trajectory, a plant or a function lacks a method, or is a class.
    """
    for name, value in given.items():
        if value is None and name in OPTIONAL:
            continue
        methods = METHODS[name]
        has_all = all(callable(getattr(value, method, None)) for method in methods)
        if isinstance(value, type) or not has_all:
            wanted = f"method{'s' if len(methods) > 1 else ''} {' and '.join(methods)}"
            raise InvalidValue(name, value, f"a {name}, with {'' if methods[1:] else 'a '}{wanted}")


def finite_row(values: Any, width: int) -> Array | None:
    """Return ``values`` as finite floats of shape (width,), or None."""
    try:
        array = np.asarray(values)
        is_known = array.dtype.kind in NUMBERS
        array = np.asarray(array, np.float64) if is_known else as_floats("forces", values, "(m,)")
        # Infinite entries of opposite sign add up to NaN, so one sum detects every bad number.
        return array if array.shape == (width,) and math.isfinite(sum(array.tolist())) else None
    except (TypeError, ValueError, OverflowError):
        return None


def as_object(value: object) -> Array:
    """Return what a controller returned as an array, for an error."""
    try:
        return np.asarray(value, dtype=object)
    except (TypeError, ValueError):
        # NumPy cannot put arrays of different shapes into one.
        kept = np.empty((), dtype=object)
        kept[()] = value
        return kept


def set_report(reports: Array, sample: int, controller: Any, name: str) -> None:
    """Keep what a controller reports about a sample.

    Raises
    ------
    InvalidValue
        If the report has the wrong shape or type.
    """
    value = getattr(controller, name)
    try:
        reports[sample] = value
    except (TypeError, ValueError) as error:
        wanted = f"of shape {reports.shape[1:]}" if reports.shape[1:] else "True or False"
        raise InvalidValue(f"controller.{name}", value, wanted) from error


def checked_state(state: object, positions: int, speeds: int) -> tuple[Array, Array]:
    """Return the state that a plant reached.

    Raises
    ------
    InvalidValue, InvalidArray
        If it is not a pair of positions (p,) and speeds (n,).
    """
    try:
        pair: Any = state
        reached, rates = pair
    except (TypeError, ValueError):
        wanted = "positions and speeds, or None"
        raise InvalidValue("what the plant's advance returns", state, wanted) from None
    return _floats("positions", reached, positions), _floats("speeds", rates, speeds)


def _floats(name: str, values: Any, width: int) -> Array:
    # Numbers that are not finite pass, because they are beyond the limits, which ends the loop.
    array = as_floats(f"{name} from the plant's advance", values, f"({width},)")
    if np.shape(values) != (width,):
        raise InvalidArray(f"{name} from the plant's advance", f"({width},)", values)
    return array
