"""Checks of arguments, which all modules share.

They return a valid value, or raise an error that names the argument and its valid range.
"""

from __future__ import annotations

import contextlib
import decimal
import itertools
import math
import numbers
import os
from collections.abc import Collection, Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fuzzy2.errors import InvalidValue, UnknownName

Array = NDArray[np.float64]

MOST = 1_000_000
"""More terms, points or rules than this are surely a mistake, and would not fit into memory."""


def real(name: str, value: object, requirement: str = "a finite number") -> float:
    """Return ``value`` as a float.

    Raise :class:`InvalidValue` if it is not a finite real number.
    """
    number = maybe_infinite(name, value, requirement)
    if math.isinf(number):
        raise InvalidValue(name, value, requirement)
    return number


def maybe_infinite(name: str, value: object, requirement: str = "a number") -> float:
    """Return ``value`` as a float that may be infinite.

    Raise :class:`InvalidValue` if it is not a real number. Infinity is accepted.
    """
    # NumPy would convert complex numbers and dates to floats.
    if isinstance(value, str | bytes | bool | np.ma.MaskedArray | complex) or (
        isinstance(value, np.generic | np.ndarray) and value.dtype.kind not in "fiu"
    ):
        raise InvalidValue(name, value, requirement)
    try:
        number = float(value)  # type: ignore[arg-type] # whatever has no float is refused below
    except (TypeError, ValueError, OverflowError) as error:
        raise InvalidValue(name, value, requirement) from error
    if math.isnan(number):
        raise InvalidValue(name, value, requirement)
    return number


def positive(name: str, value: object) -> float:
    """Return ``value`` as a float.

    Raise :class:`InvalidValue` if it is not a finite number above 0.
    """
    number = real(name, value, "a finite number above 0")
    if number <= 0.0:
        raise InvalidValue(name, value, "a finite number above 0")
    return number


def grade(name: str, value: object) -> float:
    """Return ``value`` as a float; raise :class:`InvalidValue` if it is not in (0, 1]."""
    number = real(name, value, "above 0 and at most 1")
    if not 0.0 < number <= 1.0:
        raise InvalidValue(name, value, "above 0 and at most 1")
    return number


def share(name: str, value: object, requirement: str = "in [0, 1]") -> float:
    """Return ``value`` as a float; raise :class:`InvalidValue` if it is not in [0, 1]."""
    number = real(name, value, requirement)
    if not 0.0 <= number <= 1.0:
        raise InvalidValue(name, value, requirement)
    return number


def true_or_false(name: str, value: object) -> bool:
    """Return ``value`` as a bool; raise :class:`InvalidValue` if it is not a bool."""
    of_kind(name, value, (bool, np.bool_), "True or False")
    return bool(value)


def ascending(name: str, values: tuple[float, ...]) -> None:
    """Raise :class:`InvalidValue` if a value is smaller than the one before it."""
    if any(after < before for before, after in itertools.pairwise(values)):
        raise InvalidValue(name, values, "in ascending order")


def reals(name: str, values: ArrayLike, requirement: str = "real numbers") -> Array:
    """Return ``values`` as an array of floats, which may be NaN.

    Raise :class:`InvalidValue` if they are not real numbers, or if some of them are masked, because
    masked values must not be used.
    """
    if isinstance(values, np.ma.MaskedArray):
        raise InvalidValue(
            name, values, f"{requirement} without a mask, such as values.filled(0.0)"
        )
    try:
        array = np.asarray(values)
        # In object arrays, text would be converted to numbers, dates to days, and None to NaN.
        if array.dtype.kind in "fiub" or (
            array.dtype.kind == "O"
            and all(isinstance(value, numbers.Real | decimal.Decimal) for value in array.flat)
        ):
            # Arrays are contiguous, so that neither sums nor numba's types depend on the memory
            # layout, and writable, because numba would compile every kernel again for read-only
            # arrays.
            floats = np.asarray(array, dtype=np.float64, order="C")
            return floats if floats.flags.writeable else floats.copy()
    except (TypeError, ValueError, OverflowError) as error:
        raise InvalidValue(name, values, requirement) from error
    raise InvalidValue(name, values, requirement)


def finite_rows(name: str, values: Array, fits: bool, shape: str) -> None:
    """Raise :class:`InvalidValue` if samples have another shape, or a row that is not finite.

    Parameters
    ----------
    name : str
        Name of the argument.
    values : (..., p) ndarray
        The samples.
    fits : bool
        Whether they have the shape that is wanted.
    shape : str
        That shape, as the message says it.
    """
    if not fits:
        raise InvalidValue(name, values.shape, f"of shape {shape}")
    bad = np.argwhere(~np.isfinite(values).all(axis=-1))
    if len(bad):
        place = tuple(int(index) for index in bad[0])
        where = f"[{', '.join(map(str, place))}]" if place else ""
        raise InvalidValue(f"{name}{where}", values[place], "finite")


def whole_number(name: str, value: object, least: int, most: int = MOST) -> int:
    """Return a whole number between the least and the greatest one; refuse anything else."""
    if (
        isinstance(value, bool | np.bool_)
        or not isinstance(value, int | np.integer)
        or not least <= value <= most
    ):
        at_most = f" and at most {most:,}" if isinstance(value, int) and value > most else ""
        raise InvalidValue(name, value, f"a whole number of at least {least}{at_most}")
    return int(value)


def known_name(what: str, name: object, known: Collection[str]) -> str:
    """Return a name that is among the known ones; raise :class:`UnknownName` if it is not."""
    if not isinstance(name, str) or name not in known:
        raise UnknownName(what, name, tuple(known))
    return name


def is_path(path: object) -> bool:
    """Return whether a value is the path of a file: text or a path that a file system can name.

    Whole numbers are refused, because Python would take them as descriptors of open files.
    """
    if not isinstance(path, str | os.PathLike):
        return False
    try:
        name = os.fsencode(path)
    except (TypeError, ValueError):  # a lone surrogate, or an object that claims to be a path
        return False
    return bool(name) and b"\0" not in name


def named_path(path: object) -> str | os.PathLike[str]:
    """Return the path of a file; raise :class:`InvalidValue` if it is not a path."""
    if isinstance(path, str | os.PathLike) and is_path(path):
        return path
    raise InvalidValue("path", path, "the path of a file, as text or pathlib.Path")


def listed(name: str, values: Iterable[Any], requirement: str) -> tuple[Any, ...]:
    """Return the items of a list; raise :class:`InvalidValue` for anything else, such as text."""
    if not isinstance(values, str | bytes | np.ma.MaskedArray):
        try:
            return tuple(values)
        except TypeError:
            pass
    raise InvalidValue(name, values, requirement)


def function(name: str, value: object) -> None:
    """Raise :class:`InvalidValue` if a value is not callable."""
    if not callable(value):
        raise InvalidValue(name, value, "a function")


def of_kind(name: str, value: Any, kinds: type | tuple[type, ...], requirement: str) -> None:
    """Raise :class:`InvalidValue` if a value is not of one of the expected types."""
    if not isinstance(value, kinds):
        raise InvalidValue(name, value, requirement)


def generator(name: str, value: object) -> np.random.Generator:
    """Return a source of random numbers; raise :class:`InvalidValue` if it is not a generator."""
    requirement = "a numpy.random.Generator, such as numpy.random.default_rng(0)"
    if not isinstance(value, np.random.Generator):
        raise InvalidValue(name, value, requirement)
    return value


def broadcast(names: str, *arrays: Array) -> tuple[Array, ...]:
    """Return broadcast arrays; raise :class:`InvalidValue` if their shapes do not match."""
    try:
        return tuple(np.broadcast_arrays(*arrays))
    except ValueError as error:
        shapes = tuple(array.shape for array in arrays)
        raise InvalidValue(names, shapes, "arrays whose shapes go together") from error


@contextlib.contextmanager
def overflow_refused(what: str, error: type[InvalidValue] = InvalidValue) -> Iterator[None]:
    """Raise an error if numbers overflow or a result is NaN.

    Parameters
    ----------
    what : str
        Name of what the error refuses.
    error : type
        Class of the error.
    """
    try:
        with np.errstate(over="raise", invalid="raise", divide="raise"):
            yield
    except (FloatingPointError, OverflowError) as reason:
        wanted = "of such a size that results are numbers; check the units"
        raise error(what, str(reason), wanted) from reason


def binary_exponent(values: Array) -> int:
    """Return n such that values divided by :math:`2^n` can be squared and added without overflow.

    It is 0 unless the greatest value is so large or small that its square would overflow or
    underflow. So ordinary results are not changed by the scaling.
    """
    greatest = float(np.max(np.abs(values), initial=0.0))
    exponent = math.frexp(greatest)[1] - 1
    return exponent if math.isfinite(greatest) and abs(exponent) > 400 else 0


def ascending_pair(name: str, values: ArrayLike) -> tuple[float, float]:
    """Return two finite numbers in ascending order; raise :class:`InvalidValue` if they are not."""
    pair = reals(name, values)
    if pair.shape != (2,) or not np.isfinite(pair).all() or pair[0] > pair[1]:
        raise InvalidValue(name, values, "two finite numbers in ascending order")
    return float(pair[0]), float(pair[1])
