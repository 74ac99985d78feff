"""Checks of samples, which are converted to tables."""

from __future__ import annotations

import decimal
import numbers
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy2.errors import InvalidValue, NotNumbers
from fuzzy2.support.checks import Array, reals

LEAST_RANGE = 1e-150
"""Numbers between this one and its inverse have squares that neither overflow nor underflow."""


class Samples(NamedTuple):
    """Samples of nonzero weight as tables, and the names of columns.

    ``inputs`` are (N, p), ``outputs`` (N, m), and ``weights`` (N,). ``numbers`` (N,) are the
    numbers of the samples among all given samples.
    """

    inputs: Array
    outputs: Array
    weights: Array
    numbers: NDArray[np.int64]
    input_names: tuple[str, ...]
    output_names: tuple[str, ...]
    named: bool
    one_column: bool


def samples_of(estimator: str, X: Any, y: Any, sample_weight: Any = None) -> Samples:
    """Return checked samples of inputs and outputs; samples of weight 0 are left out."""
    names = column_names(X)
    inputs = table_of_samples("X", X)
    outputs, one_column = table_of_outputs(y, len(inputs), estimator)
    weights = weights_of(sample_weight, len(inputs))
    for name, table in (("X", inputs), ("y", outputs)):
        check_scale(name, table)
    kept = np.flatnonzero(weights > 0.0)
    if len(kept) < 2:
        raise InvalidValue(
            "X",
            f"{len(kept)} sample",
            "a table of at least 2 samples, which span a range",
        )
    if len(kept) < len(inputs):
        inputs, outputs, weights = inputs[kept], outputs[kept], weights[kept]
    output_names = column_names(y)
    if one_column and isinstance(getattr(y, "name", None), str):
        output_names = [y.name]  # of a Series
    if output_names is None or len(output_names) != outputs.shape[1]:
        output_names = [f"y{j + 1}" for j in range(outputs.shape[1])]
    return Samples(
        inputs,
        outputs,
        weights,
        kept,
        tuple(names) if names is not None else tuple(f"x{i + 1}" for i in range(inputs.shape[1])),
        tuple(output_names),
        names is not None,
        one_column,
    )


def check_scale(name: str, table: Array) -> None:
    """Refuse columns whose squared values or ranges overflow or underflow."""
    size, width = np.abs(table).max(axis=0, initial=0.0), np.ptp(table, axis=0)
    if (size > 1.0 / LEAST_RANGE).any() or ((width > 0.0) & (width < LEAST_RANGE)).any():
        raise InvalidValue(
            name,
            table,
            f"at most {1.0 / LEAST_RANGE:.0e} in size, and equal or at least {LEAST_RANGE:.0e} "
            "apart, so that squares are numbers: give it in another unit",
        )


def ranges_of(what: str, names: Sequence[str], columns: Array) -> list[tuple[float, float]]:
    """Return the range of every column; refuse a column without a range."""
    least, greatest = columns.min(axis=0), columns.max(axis=0)
    for name, low, high in zip(names, least, greatest, strict=True):
        if not low < high:
            remedy = "leave it out" if what == "input" else "learn it without output terms"
            raise InvalidValue(
                f"{what} {name}",
                low,
                f"different in at least two samples, since its terms partition its range; {remedy}",
            )
    return [(float(low), float(high)) for low, high in zip(least, greatest, strict=True)]


def table_of_samples(name: str, values: Any) -> Array:
    """Return samples as a table of finite floats, or raise an error that says what is wrong."""
    table = np.ascontiguousarray(_numbers(name, values))
    if table.ndim != 2:
        raise InvalidValue(
            name,
            table.shape,
            "of shape (n, p), a row for each sample. Reshape your data: a single sample is (1, p)",
        )
    if 0 in table.shape:
        empty = "sample" if table.shape[0] == 0 else "feature"
        raise InvalidValue(
            name,
            f"0 {empty}(s) (shape={table.shape}) while a minimum of 1 is required.",
            "a table that is not empty",
        )
    if not np.isfinite(table).all():
        row, column = (int(index) for index in np.argwhere(~np.isfinite(table))[0])
        raise InvalidValue(
            f"{name}[{row}, {column}]", float(table[row, column]), "finite, not NaN or infinity"
        )
    return table


def _numbers(name: str, values: Any) -> Array:
    """Return values as floats, with errors in the words that scikit-learn's checks expect."""
    if hasattr(values, "toarray") and hasattr(values, "nnz"):
        raise NotNumbers(name, "it is a sparse matrix; pass a dense array, such as its toarray()")
    if isinstance(values, np.ma.MaskedArray):
        raise InvalidValue(name, values, "numbers without a mask, such as values.filled(0.0)")
    try:
        array = np.asarray(values)
    except ValueError as error:  # the rows have different lengths
        raise InvalidValue(name, values, f"numbers ({error})") from error
    if array.dtype.kind == "c":
        raise InvalidValue(name, array.dtype, "real: Complex data not supported")
    if array.dtype.kind == "O":
        for value in array.flat:
            if not isinstance(value, numbers.Real | decimal.Decimal | str | bytes):
                raise NotNumbers(
                    name,
                    f"argument must be a string or a real number, not {type(value).__name__!r}",
                )
    return reals(name, values, "numbers")


def table_of_outputs(y: Any, count: int, estimator: str = "the score") -> tuple[Array, bool]:
    """Return the outputs as a table (N, m), and whether they were one-dimensional."""
    if y is None:
        raise InvalidValue(
            "y",
            None,
            f"the outputs of the samples: {estimator} requires y to be passed, but the target y is "
            "None",
        )
    outputs = _numbers("y", y)
    one_column = outputs.ndim == 1
    table = table_of_samples("y", outputs[:, np.newaxis] if one_column else outputs)
    if len(table) != count:
        raise InvalidValue("y", table.shape, f"of {count} rows, one for each sample of X")
    return table, one_column


def column_names(table: Any) -> list[str] | None:
    """Return the names of a data frame's columns, if all of them are strings."""
    columns = getattr(table, "columns", None)
    if columns is None:
        return None
    names = list(columns)
    return names if names and all(isinstance(name, str) for name in names) else None


def weights_of(given: Any, count: int) -> Array:
    """Return the weights of the samples, 1 by default; refuse invalid weights."""
    if given is None:
        return np.ones(count)
    weights = reals("sample_weight", given)
    if weights.ndim == 0:
        weights = np.full(count, float(weights))
    if weights.shape != (count,) or not np.isfinite(weights).all() or (weights < 0.0).any():
        raise InvalidValue(
            "sample_weight", given, f"{count} finite numbers, one for each sample, none below 0"
        )
    some = weights[weights > 0.0]
    if not some.size:
        raise InvalidValue("sample_weight", "all zero", "above 0 for some sample")
    if some.min() < LEAST_RANGE or some.max() > 1.0 / LEAST_RANGE:
        wanted = f"0, or from {LEAST_RANGE:.0e} to {1.0 / LEAST_RANGE:.0e}"
        raise InvalidValue("sample_weight", given, wanted)
    return weights
