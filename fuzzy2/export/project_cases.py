"""Test cases: inputs of the functions in C, and the results of the same functions in Python."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from fuzzy2.errors import InvalidValue
from fuzzy2.export.c_code import CCode
from fuzzy2.export.numbers import Precision
from fuzzy2.export.project_calls import calls_of, size_of
from fuzzy2.support.checks import Array

CASES = 200
"""Number of cases; each calls every function once."""

ROOM, GREATEST = 8.0, float(np.finfo(float).max)
"""Numbers are drawn divided by the first value, and limited to the second, the greatest float."""

CASES_A_RUN = 20
"""The state is reset after this many cases.

A run ends with NaN or infinite inputs, because they may spoil the state.
"""

TOLERANCES = {"double": 1e-12, "single": 1e-3}
"""Relative tolerances of results: in double precision for the different roundings of another C
library, in single precision for its own roundings."""

ROUNDINGS, ROUNDED_RUNS = 300.0, 3
"""In single precision a result may also differ by a multiple of the effect of rounding the inputs,
the largest in several runs. Near a singular pose that exceeds the relative tolerance."""


def drawn(low: Any, high: Any, seed: int = 0) -> Array:
    """Return the inputs of all cases, most of them within a range.

    One case in five is drawn from three times the range. At the end of every second run, one number
    is NaN or infinite.

    Parameters
    ----------
    low, high : array_like (n,)
        The range.
    seed : int
        Seed of the random draw.

    Returns
    -------
    ndarray (CASES, n)
    """
    low, high = np.atleast_1d(np.asarray(low, float)), np.atleast_1d(np.asarray(high, float))
    rng = np.random.default_rng(seed)
    # A range may be as wide as all floats. Its eighth leaves room for three times the range.
    low, high = low / ROOM, high / ROOM
    inputs = rng.uniform(low, high, (CASES, low.size))
    outside = np.arange(3, CASES, 5)
    inputs[outside] += (inputs[outside] - (low + high) / 2.0) * 2.0
    inputs = ROOM * np.clip(inputs, -GREATEST / ROOM, GREATEST / ROOM)
    spoilt = np.arange(CASES_A_RUN - 1, CASES, 2 * CASES_A_RUN)
    places = rng.integers(low.size, size=spoilt.size)
    inputs[spoilt, places] = np.resize([np.nan, np.inf, -np.inf], spoilt.size)
    return inputs


class Cases:
    """The calls of a test in order, with their inputs and the results of Python.

    Parameters
    ----------
    code : CCode
        The code.
    inputs : mapping of str to ndarray (CASES, n)
        Inputs of the cases for each argument that is read, by name. If an array has more columns
        than the argument, its first columns are used.

    Raises
    ------
    InvalidValue
        If an argument has no inputs.
    """

    def __init__(self, code: CCode, inputs: Mapping[str, Array]) -> None:
        self.code, self.calls = code, calls_of(code)
        self.inputs = self._checked(inputs)
        self.done = self._answers(self.inputs)

    def _checked(self, inputs: Mapping[str, Array]) -> dict[str, Array]:
        """Return the inputs rounded to the numbers that C reads."""
        item = np.float64 if self.code.precision.name == "double" else np.float32
        kept = {}
        for argument in (one for call in self.calls for one in call.read):
            given = np.asarray(inputs.get(argument.name, np.empty((0, 0))), dtype=float)
            if given.ndim != 2 or len(given) != CASES or given.shape[1] < size_of(argument):
                wanted = f"cases of shape ({CASES}, {size_of(argument)}) for {argument.name!r}"
                raise InvalidValue("inputs", given, wanted)
            with np.errstate(over="ignore"):
                kept[argument.name] = given.astype(item).astype(float)
        return kept

    def _order(self) -> Iterator[tuple[int, int]]:
        """Yield the number of the function and the number of the case for every call."""
        for case in range(CASES):
            for k, call in enumerate(self.calls):
                if not call.begins or case % CASES_A_RUN == 0:
                    yield k, case

    def _answers(self, inputs: Mapping[str, Array]) -> list[tuple[int, Array, Array]]:
        """Return for every call the function's number, its inputs, and the results of Python."""
        states = {
            argument.name: np.zeros(size_of(argument), dtype=int if argument.is_whole else float)
            for call in self.calls
            for argument in call.function.arguments
            if argument.role == "state"
        }
        return [self._answer(k, case, inputs, states) for k, case in self._order()]

    def _answer(
        self, k: int, case: int, inputs: Mapping[str, Array], states: Mapping[str, Array]
    ) -> tuple[int, Array, Array]:
        call = self.calls[k]
        arguments: list[Any] = []
        for argument in call.function.arguments:
            if argument.role == "state":
                arguments.append(states[argument.name])
            elif argument.role == "out":
                arguments.append(np.zeros(size_of(argument)))
            elif argument.size is None:
                arguments.append(float(inputs[argument.name][case, 0]))
            else:
                arguments.append(inputs[argument.name][case, : argument.size].copy())
        roles = [argument.role for argument in call.function.arguments]
        with np.errstate(all="ignore"):
            returned = call.function.in_python(*arguments)
        by_role = {
            role: [np.atleast_1d(a) for a, r in zip(arguments, roles, strict=True) if r == role]
            for role in ("in", "out")
        }
        first = [np.array([float(returned)])] if call.function.result else []
        empty = np.empty(0)
        return (
            k,
            np.concatenate([empty, *by_role["in"]]),
            np.concatenate([empty, *first, *by_role["out"]]),
        )

    def sizes(self) -> list[Array]:
        """Return for every call the size of each result, to which tolerances are relative.

        It is the largest of the result itself, the usual size of its array, and in single precision
        the size for which the effect of roundings is within the tolerance.
        """
        usual = [self._usual(k) for k in range(len(self.calls))]
        moved = self._moved()
        with np.errstate(invalid="ignore"):
            found = [
                np.fmax(np.fmax(usual[k], np.abs(written)), off)
                for (k, _, written), off in zip(self.done, moved, strict=True)
            ]
        return [np.where(np.isfinite(row), row, 1.0) for row in found]

    def _moved(self) -> list[Array]:
        """Return the effect of input roundings on every result, as the size with that tolerance."""
        moved = [np.zeros(written.size) for _, _, written in self.done]
        if self.code.precision.name == "double":
            return moved
        share = ROUNDINGS / TOLERANCES["single"]
        for seed in range(ROUNDED_RUNS):
            rng = np.random.default_rng(seed)
            rounded = {
                name: given * (1.0 + rng.choice([-1.0, 1.0], given.shape) * 2.0**-24)
                for name, given in self.inputs.items()
            }
            with np.errstate(invalid="ignore", over="ignore"):
                for row, (_, _, one), (_, _, other) in zip(
                    moved, self.done, self._answers(rounded), strict=True
                ):
                    np.fmax(row, share * np.abs(one - other), out=row)
        return moved

    def _usual(self, k: int) -> Array:
        """Return the usual size of each result of a function, which is that of its array."""
        call = self.calls[k]
        rows = np.array([written for number, _, written in self.done if number == k])
        sizes = [1] * bool(call.function.result) + [size_of(a) for a in call.written]
        scales, start = [], 0
        for size in sizes:
            part = np.abs(rows[:, start : start + size]).max(axis=1)
            part = part[np.isfinite(part) & (part > 0.0)]
            scales += [float(np.median(part)) if part.size else 1.0] * size
            start += size
        return np.array(scales)

    def header(self) -> str:
        """Return ``cases.h``."""
        tolerance = TOLERANCES[self.code.precision.name]
        return f"""\
/* The calls of test.c, and the results of the same functions in Python. */
#ifndef CASES_H
#define CASES_H

#define CASES_TOLERANCE {tolerance}

enum {{ CASES = {CASES}, CASES_CALLS = {len(self.done)} }};

/* The number of the function of each call. */
extern const unsigned char cases_functions[CASES_CALLS];

/* For each call the inputs, and the results of Python. */
extern const double cases_numbers[];

/* For each call the sizes of the results, to which errors are relative. */
extern const double cases_sizes[];

#endif
"""

    def source(self) -> str:
        """Return ``cases.c``."""
        order = _wrapped(", ".join(str(k) for k, _, _ in self.done))
        numbers = "\n".join(
            _wrapped(_listed(np.concatenate(both)) + ",") for _, *both in self.done if both[1].size
        )
        sizes = "\n".join(_wrapped(_short(row) + ",") for row in self.sizes() if row.size)
        return f"""\
/* cases.c: see cases.h. */
#include "cases.h"

#include <math.h>

const unsigned char cases_functions[CASES_CALLS] = {{
{order}
}};

const double cases_numbers[] = {{
{numbers}
}};

const double cases_sizes[] = {{
{sizes}
}};
"""


def _listed(row: Array) -> str:
    exact = Precision("double")
    return ", ".join(exact.literal(number) for number in row.tolist())


def _short(row: Array) -> str:
    # Rounded up, the greatest number would be infinite.
    return ", ".join(f"{min(number, 1.79e308):.2e}" for number in row.tolist())


def _wrapped(text: str) -> str:
    return textwrap.fill(text, 100, initial_indent="    ", subsequent_indent="    ")
