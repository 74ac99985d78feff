"""Compiled functions run by Python itself: for a few calls, done before a compiler would begin.

A compiled function is Python, and so is all that it calls. Its *twin* is the same code with twins
in place of compiled functions, and with mathematics as the machine has it
(:mod:`fuzzy2.support.machine_math`): the same operations in the same order on the same numbers, so
that every result is equal to the last bit. A call takes some hundred times as long.
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
"""By the number of a module's names: these, so that no others get the number, and with twins."""

_MAKING = threading.RLock()


@contextmanager
def few_calls() -> Iterator[None]:
    """Say that only a few calls are to come, for which nothing should be compiled.

    What has been compiled already is used all the same. It is said of one thread, and what that
    waits for.
    """
    before = _FEW_CALLS.set(True)
    try:
        yield
    finally:
        _FEW_CALLS.reset(before)


def are_few_calls() -> bool:
    """Tell whether only a few calls are to come."""
    return _FEW_CALLS.get()


def is_ready(kernel: Any) -> bool:
    """Tell whether a compiled function can be called without compiling it first."""
    # Where numba is told not to compile there are Python functions only.
    return bool(getattr(kernel, "overloads", True))


def twin_of(kernel: Callable[..., Any]) -> Callable[..., Any]:
    """Return a compiled function as Python runs it.

    Parameters
    ----------
    kernel : callable
        What :func:`fuzzy2.support.compiled.compiled` or ``scalar`` returned. It must not call what
        is chosen by a table's type.

    Returns
    -------
    callable
        The same function in Python. It takes arrays for which the compiled one exists, and does not
        check them.
    """
    with _MAKING:
        twin: Any = _twin(getattr(kernel, "py_func", kernel))

    def called(*arguments: Any) -> Any:
        # Divisions by zero and the like have answers of the machine's, and nobody is told.
        with np.errstate(all="ignore"):
            return twin(*arguments)

    return called


def twins_of(module: Any) -> Any:
    """Return an object with the compiled functions of a module as Python runs them."""
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
