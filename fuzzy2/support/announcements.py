"""Announcements of compilation, which takes seconds the first time and looks like a hang.

The time is estimated from the size of the code of a function and of all functions that it calls.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Any, NamedTuple

RATE = 4000.0
"""Bytes of Python code that a machine of 2020 compiles per second."""

TOLD = 2.0
"""Compilations that take less time [s] are not announced."""


class Compilation(NamedTuple):
    """A function that is about to be compiled."""

    name: str
    """Module and name of the function."""
    seconds: float
    """Estimated compilation time [s]."""

    def __str__(self) -> str:
        return f"compiling once, about {self.seconds:.0f} s: {self.name}"


_listeners: list[Callable[[Compilation], AbstractContextManager[None]]] = []


@contextmanager
def announced_by(show: Callable[[Compilation], AbstractContextManager[None]]) -> Iterator[None]:
    """Have long compilations shown instead of logged.

    Parameters
    ----------
    show : callable
        Returns, for a compilation, the context manager in which it runs.
    """
    _listeners.append(show)
    try:
        yield
    finally:
        _listeners.remove(show)


@contextmanager
def announced(
    function: Callable[..., Any], kinds: Iterable[Any], work: float = 1.0
) -> Iterator[None]:
    """Announce the compilation of a function if it takes long.

    Parameters
    ----------
    function : callable
        The function in Python.
    kinds : iterable
        Numba's types of its arguments.
    work : float
        Compilation time relative to that of a scalar function.
    """
    seconds = work * size_of_code(function, _tables_among(kinds)) / RATE
    coming = Compilation(f"{function.__module__}.{function.__name__}", seconds)
    if seconds < TOLD:
        yield
    elif _listeners:
        with _listeners[-1](coming):
            yield
    else:
        # Imported here, because the command line imports this module before it knows what to do.
        import logging

        logging.getLogger(__name__).warning("%s", coming)
        yield


def size_of_code(function: Callable[..., Any], tables: frozenset[Any] = frozenset()) -> int:
    """Return the bytes of Python code of a function and of all functions that it calls, each once.

    Parameters
    ----------
    function : callable
        The function in Python.
    tables : frozenset of class
        Kinds of tables; of functions that are chosen by table, only the bodies for these are
        counted.
    """
    seen: set[Any] = set()
    left: list[Any] = [function]
    size = 0
    while left:
        body = left.pop()
        if body in seen:
            continue
        seen.add(body)
        code = body.__code__
        size += len(code.co_code)
        for value in map(body.__globals__.get, code.co_names):
            bodies = getattr(value, "bodies", None)
            called = [bodies[one] for one in tables if one in bodies] if bodies else [value]
            left += [one.py_func for one in called if hasattr(one, "py_func")]
            # Bodies are compiled into their callers.
            left += [one for one in called if bodies and not hasattr(one, "py_func")]
    return size


def _tables_among(kinds: Iterable[Any]) -> frozenset[Any]:
    """Return the classes of tables among the arguments or within them."""
    found: set[Any] = set()
    for kind in kinds:
        table = getattr(kind, "instance_class", None)
        if table is not None:
            found |= {table} | _tables_among(getattr(kind, "types", ()))
    return frozenset(found)
