"""Inputs and outputs by name (mappings, keyword arguments or data frames), and their types."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fuzzy2.errors import InvalidValue
from fuzzy2.support.checks import Array, reals
from fuzzy2.systems.rules import unknown_name


def by_name(
    X: Any, names: Sequence[str], named: bool, argument: str = "X", what: str = "input"
) -> Any:
    """Return inputs (..., p) in the order of a system's inputs if they have names.

    Measured outputs are matched with the names of a system's outputs in the same way.

    Parameters
    ----------
    X : mapping, data frame, Series of pandas or array_like
        Values by name, which are broadcast, or a table whose ``columns`` have names, or a row of
        such a table. Anything else is returned unchanged.
    names : sequence of str
        Names of the system's inputs.
    named : bool
        Whether the names were given by the user. Columns of a data frame are not matched with
        default names, but taken in their order.
    argument, what : str
        What ``X`` and its values are called in messages.

    Returns
    -------
    (..., p) ndarray, or X

    Raises
    ------
    InvalidValue
        If an input has no value or several columns, or a value has the name of no input. Other
        columns of a data frame are ignored.
    """
    if isinstance(X, Mapping):
        unknown = [name for name in X if name not in names]
        if unknown:
            raise InvalidValue(
                argument, list(X), f"values of {what}s: {_unknown(what, unknown[0], names)}"
            )
        return _stacked(X, names, list(X), argument, what)
    columns = getattr(X, "columns", None)
    if _is_of_pandas(X, "Series"):
        # A row of a data frame may have its numbers in another order.
        columns = X.index if all(isinstance(label, str) for label in X.index) else None
    if columns is None or isinstance(X, np.ndarray):
        return X
    labels = list(columns)
    in_order = not named and len(labels) == len(names) and not set(names) <= set(labels)
    taken = labels if in_order else [label for label in labels if label in names]
    for label in taken:
        if taken.count(label) > 1:
            raise InvalidValue(argument, labels, f"one column for each {what}: {label} is repeated")
    if in_order:
        return np.stack([reals(str(label), X[label]) for label in labels], axis=-1)
    return _stacked({label: X[label] for label in taken}, names, labels, argument, what)


def like_inputs(outputs: Array, X: Any, names: Sequence[str]) -> Any:
    """Return outputs (n, m) in the type of the inputs if that is a type of pandas.

    Parameters
    ----------
    outputs : (n, m) or (m,) ndarray
        Outputs.
    X : DataFrame, Series or anything else
        Inputs.
    names : sequence of m str
        Names of the outputs.

    Returns
    -------
    DataFrame, Series or ndarray
        A data frame with the index of the inputs, a Series for a single row, or the array for any
        other type of inputs.
    """
    if _is_of_pandas(X, "DataFrame"):
        return sys.modules["pandas"].DataFrame(outputs, index=X.index, columns=list(names))
    if _is_of_pandas(X, "Series"):
        return sys.modules["pandas"].Series(outputs, index=list(names), name=X.name)
    return outputs


def _is_of_pandas(X: Any, kind: str) -> bool:
    """Return whether X is of a class of pandas, without importing pandas."""
    pandas = sys.modules.get("pandas")
    return pandas is not None and isinstance(X, getattr(pandas, kind))


def _stacked(
    values: Mapping[str, Any], names: Sequence[str], given: list[Any], argument: str, what: str
) -> Array:
    missing = [name for name in names if name not in values]
    if missing:
        have = "has" if len(missing) == 1 else "have"
        raise InvalidValue(
            argument, given, f"values of all {what}s, and {', '.join(missing)} {have} none"
        )
    columns = [reals(name, values[name]) for name in names]
    try:
        return np.stack(np.broadcast_arrays(*columns), axis=-1)
    except ValueError as error:
        shapes = {name: column.shape for name, column in zip(names, columns, strict=True)}
        raise InvalidValue(argument, shapes, "values of shapes that go together") from error


def _unknown(what: str, name: Any, names: Sequence[str]) -> str:
    return f"{unknown_name(what, str(name), names)} (known: {', '.join(names)})"
