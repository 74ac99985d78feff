"""Compiled functions run by Python itself, for a few calls that end before a compilation would.

The source of a compiled function is Python, and so is that of all functions it calls. Its *twin* is
the same code with twins in place of compiled functions, and with the mathematical functions of
compiled code (:mod:`fuzzy2.support.machine_math`). It does the same operations in the same order on
the same numbers, so every result is equal bit for bit. A call takes about a hundred times as long.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from types import FunctionType, SimpleNamespace
from typing import Any

import numpy as np

from fuzzy2.support import machine_math

_FEW_CALLS: ContextVar[bool] = ContextVar("_FEW_CALLS", default=False)

_TWINS_OF_MODULES: dict[int, tuple[dict[str, Any], dict[str, Any]]] = {}
"""Names of modules and their twins, by the id of the names, which are kept so that the id stays
unique."""

_MAKING = threading.RLock()


@contextmanager
def few_calls() -> Iterator[None]:
    """Declare that only a few calls follow, for which nothing should be compiled.

    Functions that are already compiled are used anyway. The declaration holds for the current
    thread, and for threads that it waits for.
    """
    before = _FEW_CALLS.set(True)
    try:
        yield
    finally:
        _FEW_CALLS.reset(before)


def are_few_calls() -> bool:
    """Return whether only a few calls follow."""
    return _FEW_CALLS.get()


def is_ready(kernel: Any) -> bool:
    """Return whether a compiled function can be called without compilation."""
    # If numba's compilation is disabled, all functions are Python functions.
    return bool(getattr(kernel, "overloads", True))


def twin_of(kernel: Callable[..., Any]) -> Callable[..., Any]:
    """Return the twin of a compiled function, which Python runs.

    Parameters
    ----------
    kernel : callable
        A function that :func:`fuzzy2.support.compiled.compiled` or ``scalar`` returned. It must not
        call functions that are chosen by a table's type.

    Returns
    -------
    callable
        The same function in Python. It accepts the arrays that the compiled function accepts, but
        does not check them.
    """
    with _MAKING:
        twin: Any = _twin(getattr(kernel, "py_func", kernel))

    def called(*arguments: Any) -> Any:
        # Divisions by zero and the like give the machine's results without a warning.
        with np.errstate(all="ignore"):
            return twin(*arguments)

    return called


def twins_of(module: Any) -> Any:
    """Return an object with the twins of all compiled functions of a module."""
    kernels = {name: one for name, one in vars(module).items() if hasattr(one, "py_func")}
    return SimpleNamespace(**{name: twin_of(one) for name, one in kernels.items()})


def _twin(function: Any) -> Any:
    names = function.__globals__
    _, known = _TWINS_OF_MODULES.get(id(names), (names, None))
    if known is None:
        known = dict(names)
        _TWINS_OF_MODULES[id(names)] = names, known
        for name, value in names.items():
            if value is math:
                known[name] = machine_math
            elif hasattr(value, "py_func"):
                known[name] = _twin(value.py_func)
    return FunctionType(
        function.__code__, known, function.__name__, function.__defaults__, function.__closure__
    )
