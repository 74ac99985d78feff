"""Checks of arguments that every module shares.

They return finite numbers of the right shape, or raise an error that names the argument.
"""

from __future__ import annotations

import contextlib
import decimal
import math
import numbers
from collections.abc import Callable, Collection, Iterable, Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fuzzy2.support import checks
from fuzzy2.support.checks import is_path
from psp3.errors import InvalidArray, InvalidValue, UnknownName

MOST = 2**63 - 1
"""The greatest count: that of a 64-bit integer. A greater number is a mistake."""

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


def as_floats(name: str, values: ArrayLike, shape: str) -> Array:
    """Return ``values`` as a contiguous float array; ``shape`` is what the error says was expected.

    Raises
    ------
    InvalidArray
        If they are not real numbers. Complex numbers are refused, because numpy would drop their
        imaginary part. So are masked arrays, because masked entries must not enter a computation.
    """
    if isinstance(values, np.ma.MaskedArray):
        raise InvalidArray(name, f"{shape} without a mask (take values.filled(...))", values)
    try:
        array = np.asarray(values)
        # In an array of objects numpy would read text as numbers and dates as days.
        if array.dtype.kind in "fiub" or (
            array.dtype.kind == "O"
            and all(isinstance(value, numbers.Real | decimal.Decimal) for value in array.flat)
        ):
            floats = np.ascontiguousarray(array, dtype=np.float64)
            # Numba would compile every kernel again for a read-only array, or refuse it.
            return floats if floats.flags.carray else floats.copy()
    except (TypeError, ValueError, OverflowError) as error:
        raise InvalidArray(name, shape, values) from error
    raise InvalidArray(name, shape, values)


def finite_rows(name: str, values: ArrayLike, width: int) -> Array:
    """Return ``values`` as a contiguous array of shape (..., width) of finite numbers.

    Raises
    ------
    InvalidArray
        If the last dimension is not ``width`` or an entry is not a finite number.
    """
    shape = f"(..., {width})"
    array = as_floats(name, values, shape)
    # ascontiguousarray turns a scalar into a row, which must not count as a row of width 1.
    if (
        array.shape[-1:] != (width,)
        or (width == 1 and np.ndim(values) == 0)
        or not np.isfinite(array).all()
    ):
        raise InvalidArray(name, shape, values)
    return array


def finite_array(name: str, values: ArrayLike) -> Array:
    """Return ``values`` as a float array of their own shape.

    Raise :class:`InvalidArray` if one is not a finite number.
    """
    array = as_floats(name, values, "(...,)").reshape(np.shape(values))
    if not np.isfinite(array).all():
        raise InvalidArray(name, "(...,)", array)
    return array


def one_row(name: str, values: ArrayLike, width: int) -> Array:
    """Return ``values`` as an array of shape (width,) of finite numbers.

    Raise :class:`InvalidArray` if they are not.
    """
    array = finite_rows(name, values, width)
    if array.shape != (width,):
        raise InvalidArray(name, f"({width},)", array)
    return array


def together(**arrays: Array) -> list[Array]:
    """Broadcast the leading dimensions of arrays (..., n) against each other.

    Their last dimensions are kept.

    Raises
    ------
    InvalidArray
        If the leading dimensions cannot be broadcast.
    """
    try:
        shape = np.broadcast_shapes(*(array.shape[:-1] for array in arrays.values()))
    except ValueError as error:
        shapes = " and ".join(f"{name} {array.shape}" for name, array in arrays.items())
        raise InvalidArray(
            shapes,
            "(..., n) with leading dimensions that can be broadcast",
            next(iter(arrays.values())),
        ) from error
    # Copies, because broadcasting makes read-only views, and numba would compile every kernel again
    # for those. Row-major copies, because numpy would copy a repeated row column by column.
    return [
        np.array(np.broadcast_to(array, (*shape, array.shape[-1])), order="C")
        for array in arrays.values()
    ]


def applied_to_rows(
    function: Callable[..., Array], shape: tuple[int, ...], **arguments: tuple[ArrayLike, int]
) -> Array:
    """Apply a function of single rows to arguments with leading dimensions.

    Use it for functions that take one configuration at a time, such as Pinocchio's.

    Parameters
    ----------
    function : callable
        Takes one row of each argument and returns an array of the given shape.
    shape : tuple of int
        Shape of what it returns.
    **arguments : tuple of array_like and int
        Arrays (..., n), each with its n; the keyword is the name that an error uses. The leading
        dimensions are broadcast.

    Returns
    -------
    (..., *shape) ndarray

    Raises
    ------
    InvalidArray
        If an argument has another last dimension or is not finite, or the leading dimensions cannot
        be broadcast.
    """
    arrays = together(
        **{name: finite_rows(name, values, width) for name, (values, width) in arguments.items()}
    )
    rows = zip(*(array.reshape(-1, array.shape[-1]) for array in arrays), strict=True)
    return np.array([function(*row) for row in rows]).reshape(arrays[0].shape[:-1] + shape)


def checked_number(name: str, value: object, requirement: str, least: float = -math.inf) -> float:
    """Return a real number as a float.

    Raise :class:`InvalidValue` if it is not a number, or less than the least one.
    """
    number = math.nan
    if isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool):
        with contextlib.suppress(OverflowError):  # a whole number of hundreds of digits
            number = float(value)
    if not number >= least:
        raise InvalidValue(name, value, requirement)
    return number


def checked_finite(name: str, value: object) -> float:
    """Return a number as a float; raise :class:`InvalidValue` if it is not finite."""
    number = checked_number(name, value, "a finite number")
    if math.isinf(number):
        raise InvalidValue(name, value, "a finite number")
    return number


def checked_positive(name: str, value: object) -> float:
    """Return a number as a float; raise :class:`InvalidValue` if it is not finite and positive."""
    number = checked_number(name, value, "finite and positive")
    if not 0.0 < number < math.inf:
        raise InvalidValue(name, value, "finite and positive")
    return number


def checked_not_negative(name: str, value: object) -> float:
    """Return a number as a float.

    Raise :class:`InvalidValue` if it is negative or not finite.
    """
    number = checked_number(name, value, "finite and not negative", 0.0)
    if number == math.inf:
        raise InvalidValue(name, value, "finite and not negative")
    return number


def checked_count(name: str, value: object, least: int = 1, most: int = MOST) -> int:
    """Return a whole number.

    Raise :class:`InvalidValue` if it is not whole, less than the least one or more than the
    greatest.
    """
    if (
        isinstance(value, bool)
        or not isinstance(value, int | np.integer)
        or not least <= value <= most
    ):
        is_too_large = isinstance(value, int | np.integer) and value > MOST
        wanted = "less than 2**63" if is_too_large else f"a whole number of at least {least}"
        if most < MOST:
            wanted = f"a whole number from {least} to {most}"
        raise InvalidValue(name, value, wanted)
    return int(value)


MOST_SEEDS = 1_000_000
"""The largest number of random runs of one kind. More would not fit into memory, and is a typing
mistake.
"""

MOST_STEPS = 10_000
"""The largest number of integration steps in a control period. A compiled period cannot be
interrupted with Ctrl-C, and this many steps take half a second for a robot with many loops.
"""


def check_periods(duration: float, period: float, most: float) -> None:
    """Raise :class:`InvalidValue` if a duration has more control periods than fit into memory."""
    if not duration / period <= most:
        wanted = f"at most {most:.0e} periods of {period} s, which fit into memory"
        raise InvalidValue("duration", duration, wanted)


def checked_steps(value: object) -> int:
    """Return a number of integration steps in a control period.

    Raise :class:`InvalidValue` if it is not a count, or more than :data:`MOST_STEPS`.
    """
    steps = checked_count("steps", value)
    if steps > MOST_STEPS:
        raise InvalidValue(
            "steps", value, f"at most {MOST_STEPS:,} in a period; shorten the period instead"
        )
    return steps


def checked_kind(name: str, value: object, kind: type | tuple[type, ...], requirement: str) -> None:
    """Raise :class:`InvalidValue` if a value is not of a kind."""
    if not isinstance(value, kind):
        raise InvalidValue(name, value, requirement)


def checked_robot(robot: Any) -> None:
    """Raise :class:`InvalidValue` if a value is not a robot."""
    # An attribute ``model`` does not make a robot: a controller has one, too.
    if not hasattr(robot, "reference") and not hasattr(getattr(robot, "model", None), "names"):
        raise InvalidValue("robot", robot, 'a robot, as psp3.load("delta") returns it')


def checked_path(name: str, path: object) -> Path:
    """Return a path; raise :class:`InvalidValue` if it is neither text nor a path."""
    if not is_path(path):
        raise InvalidValue(name, path, "the path of a file, as text or pathlib.Path")
    return Path(cast("str | Path", path))


def is_text(value: object) -> bool:
    """Tell whether a value is text that can be encoded as UTF-8, as C++ libraries need it.

    Names from a command line that are not UTF-8 hold lone surrogates.
    """
    if not isinstance(value, str):
        return False
    with contextlib.suppress(UnicodeEncodeError):
        value.encode()
        return True
    return False


def checked_names(name: str, names: object) -> tuple[str, ...]:
    """Return names as a tuple; raise :class:`InvalidValue` if they are not a list of strings.

    A single string is refused, because it would be read letter by letter.
    """
    listed: tuple[Any, ...] | None = None
    if isinstance(names, Iterable) and not isinstance(names, str | bytes | Mapping):
        with contextlib.suppress(TypeError):  # an array without dimensions
            listed = tuple(names)
    if listed is None or not all(map(is_text, listed)):
        raise InvalidValue(name, names, f"a list of names; for a single one [{name}]")
    return listed


def listed(name: str, values: Any, requirement: str) -> tuple[Any, ...]:
    """Return the items of a list; raise :class:`InvalidValue` if it is a string or not a list."""
    if not isinstance(values, str | bytes | np.ma.MaskedArray):
        with contextlib.suppress(TypeError):
            return tuple(values)
    raise InvalidValue(name, values, requirement)


def known_name(what: str, name: object, known: Collection[str]) -> str:
    """Return a name that is among the known ones; raise :class:`UnknownName` if it is not."""
    if not isinstance(name, str) or name not in known:
        raise UnknownName(what, name, tuple(known))
    return name


def checked_function(name: str, value: object) -> None:
    """Raise :class:`InvalidValue` if a value cannot be called."""
    if not callable(value):
        raise InvalidValue(name, value, "a function")


def overflow_refused(what: str) -> AbstractContextManager[None]:
    """Raise :class:`InvalidValue` where numbers overflow or a result is not a number."""
    return checks.overflow_refused(what, InvalidValue)


def checked_truth(name: str, value: object) -> bool:
    """Return True or False; raise :class:`InvalidValue` if the value is neither."""
    checked_kind(name, value, (bool, np.bool_), "True or False")
    return bool(value)


def checked_random(rng: object) -> None:
    """Raise :class:`InvalidValue` if a value is neither a random generator nor None."""
    wanted = "a generator, numpy.random.default_rng(seed), or None"
    checked_kind("rng", rng, (np.random.Generator, type(None)), wanted)


def one_or_each(name: str, values: ArrayLike, joints: int) -> Array:
    """Return one number, or one for each joint, as (n,)."""
    array = as_floats(name, values, f"() or ({joints},)")
    if np.shape(values) not in ((), (joints,)) or not np.isfinite(array).all():
        raise InvalidValue(name, values, f"one finite number or {joints}")
    return np.array(np.broadcast_to(array, joints))
