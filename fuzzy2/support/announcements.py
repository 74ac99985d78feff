"""Announcements of compilation: it takes seconds, once, in which nothing else seems to happen.

How long it takes follows roughly from how much code a function has, with all that it calls.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Any, NamedTuple

RATE = 4000.0
"""Bytes of Python's code that are compiled in a second on a machine of 2020."""

TOLD = 2.0
"""Nobody is told of what takes less time [s]."""


class Compilation(NamedTuple):
    """A function that is about to be compiled."""

    name: str
    """Its module and its name."""
    seconds: float
    """How long that takes, roughly [s]."""

    def __str__(self) -> str:
        return f"compiling once, about {self.seconds:.0f} s: {self.name}"


_listeners: list[Callable[[Compilation], AbstractContextManager[None]]] = []


@contextmanager
def announced_by(show: Callable[[Compilation], AbstractContextManager[None]]) -> Iterator[None]:
    """Have long compilations shown in place of logged.

    Parameters
    ----------
    show : callable
        From a compilation to a context in which it takes place.
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
    """Tell that a function is compiled, if that takes long.

    Parameters
    ----------
    function : callable
        The function in Python.
    kinds : iterable
        Numba's types of its arguments.
    work : float
        How many times as long it takes as of a scalar function.
    """
    seconds = work * size_of_code(function, _tables_among(kinds)) / RATE
    coming = Compilation(f"{function.__module__}.{function.__name__}", seconds)
    if seconds < TOLD:
        yield
    elif _listeners:
        with _listeners[-1](coming):
            yield
    else:
        # Only here: the command line asks for this module before it knows what it has to do.
        import logging

        logging.getLogger(__name__).warning("%s", coming)
        yield


def size_of_code(function: Callable[..., Any], tables: frozenset[Any] = frozenset()) -> int:
    """Return the bytes of a function's code in Python, and of all that it calls, each once.

    Parameters
    ----------
    function : callable
        The function in Python.
    tables : frozenset of class
        Kinds of tables: of what is chosen by one the bodies for these count.
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
            # Bodies are compiled where they are called from.
            left += [one for one in called if bodies and not hasattr(one, "py_func")]
    return size


def _tables_among(kinds: Iterable[Any]) -> frozenset[Any]:
    """Return the classes of tables that arguments are, or hold."""
    found: set[Any] = set()
    for kind in kinds:
        table = getattr(kind, "instance_class", None)
        if table is not None:
            found |= {table} | _tables_among(getattr(kind, "types", ()))
    return frozenset(found)
