"""Compile scalar kernels with numba.

Cached on disk where that is possible, without the interpreter lock.

Both packages compile with this one decorator. Numba does not notice when a function in *another*
module changed. The control loops of ``psp3`` call kernels of other modules, so whoever changes a
kernel clears the cache: ``make`` does, by deleting every ``*.nbi`` and ``*.nbc``.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any, TypeVar

import numba

Function = TypeVar("Function", bound=Callable[..., Any])

_COMPILING = threading.Lock()


def only_for(function: Function, *arguments: Any) -> Function:
    """Compile a compiled function for arguments of these types, and for no others.

    Others are a TypeError, and never compiled for.

    Parameters
    ----------
    function : callable
        What :func:`compiled` returned.
    *arguments
        Arguments to call it with, once.

    Returns
    -------
    callable
        The same function. A caller can hand it what users give, unchecked, and convert that where
        it raises TypeError.
    """
    # One thread at a time: another's compilation must not be switched off before it is done.
    with _COMPILING:
        function(*arguments)
        # Not there where numba is told not to compile at all.
        getattr(function, "disable_compile", lambda: None)()
    return function


def compiled(function: Function) -> Function:
    """Compile ``function`` on its first call.

    The code releases the interpreter lock and divides as IEEE 754 does.

    Parameters
    ----------
    function : callable
        A function of scalars and contiguous arrays in the subset of Python that numba compiles.

    Returns
    -------
    callable
        The compiled function. Where no directory for the cache can be written it is compiled anew
        in every process.
    """
    return _compiled(function)


def inlined(function: Function) -> Function:
    """Compile ``function`` as :func:`compiled` does, and put it into each function that calls it.

    For what is called in a loop over many states: the compiler takes several of them in one
    instruction only where the loop calls nothing.

    Parameters
    ----------
    function : callable
        As for :func:`compiled`. All compiled functions that it calls must be inlined, too.

    Returns
    -------
    callable
        The compiled function.
    """
    return _compiled(function, forceinline=True)


def merged(function: Function) -> Function:
    """Make the source of ``function`` a part of that of the compiled functions that call it.

    For long functions that are called in one place: LLVM works on the code of a compiled function
    again in each that calls it, so that a chain of calls takes long to compile.

    Parameters
    ----------
    function : callable
        As for :func:`compiled`.

    Returns
    -------
    callable
        The compiled function.
    """
    return _compiled(function, inline="always")


def _compiled(function: Function, **more: Any) -> Function:
    options: dict[str, Any] = {"nogil": True, "error_model": "numpy", **more}
    try:
        compiled_function: Function = numba.njit(cache=True, **options)(function)
    except RuntimeError:  # "no locator available": site-packages and home are both read-only
        compiled_function = numba.njit(**options)(function)
    return compiled_function
