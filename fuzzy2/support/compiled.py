"""Decorators that compile scalar kernels with numba.

The code is cached on disk if possible and runs without the interpreter lock.

Both packages use these decorators. Numba does not notice changes of functions in *other* modules,
although kernels call them; ``fuzzy2.support.code_stamp`` does.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from typing import Any, Protocol, TypeVar, cast

import numba
from numba.extending import overload

from fuzzy2.support.compile_unit import Kernel, PartCompiler
from fuzzy2.support.deferred_compilation import is_deferred

Function = TypeVar("Function", bound=Callable[..., Any])


def only_for(function: Function, *arguments: Any) -> Function:
    """Compile a compiled function for arguments of these types, and for those asked for before.

    All others are a TypeError, and never compiled for. It is compiled at once, or within
    :func:`~fuzzy2.support.deferred_compilation.deferred_compilation` at its first call.

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
    # Where numba is told not to compile at all, this is a function of Python.
    if isinstance(function, Kernel):
        function.keep_to(*arguments)
    if not is_deferred():
        function(*arguments)
    return function


def compiled(function: Function) -> Function:
    """Compile ``function`` on its first call.

    The code releases the interpreter lock and follows IEEE 754 in divisions by zero.

    Parameters
    ----------
    function : callable
        A function of scalars and contiguous arrays in the subset of Python that numba compiles.

    Returns
    -------
    callable
        The compiled function. If there is no writable folder for its code
        (:mod:`fuzzy2.support.code_folder`), it is compiled again in every process.
    """
    return _compiled(function, twice=True)


def inlined(function: Function) -> Function:
    """Compile ``function`` as :func:`compiled` does, and inline it into each of its callers.

    Use it for functions that are called in a loop over many states, because the compiler only
    vectorizes loops without calls.

    Parameters
    ----------
    function : callable
        As for :func:`compiled`. All compiled functions that it calls must be inlined, too.

    Returns
    -------
    callable
        The compiled function.
    """
    return _compiled(function, twice=True, forceinline=True)


class ChosenByTable(Protocol):
    """Result of :func:`chosen_by_table`."""

    bodies: Mapping[Any, Callable[..., Any]]
    """The bodies, by the NamedTuple class of their table."""

    def __call__(self, table: Any, *arguments: Any) -> Any:
        """Call the body for the table's type."""
        ...

    def register(self, kind: Any) -> Callable[[Function], Function]:
        """Return a decorator for the body for a NamedTuple class."""
        ...


def chosen_by_table(declaration: Callable[..., Any]) -> ChosenByTable:
    """Declare a compiled function that has one body for each type of its first argument.

    So a kernel can work on any kind of table, which is a NamedTuple of arrays, and call functions
    that depend on the kind. The module that defines a kind of table registers the bodies for it.
    The choice is fixed when the kernel is compiled for a table, so the compiled kernel can be
    stored on disk.

    Parameters
    ----------
    declaration : callable
        A function whose docstring describes all bodies.

    Returns
    -------
    ChosenByTable
        The function; ``@declared.register(Table)`` decorates the body for a NamedTuple class. A
        body is compiled into its callers, so long code belongs in a separate function that is
        :func:`compiled`.
    """
    bodies: dict[Any, Callable[..., Any]] = {}

    @functools.wraps(declaration)
    def chosen(table: Any, *arguments: Any) -> Any:
        return bodies[type(table)](table, *arguments)

    def body_of(table: Any, *_: Any) -> Callable[..., Any] | None:
        body = bodies.get(getattr(table, "instance_class", None))
        return getattr(body, "py_func", body)

    options: Any = {"error_model": "numpy", "pipeline_class": PartCompiler}
    overload(chosen, strict=False, jit_options=options)(body_of)

    def register(kind: Any) -> Callable[[Function], Function]:
        def registered(body: Function) -> Function:
            bodies[kind] = body
            return body

        return registered

    chosen.register = register  # type: ignore[attr-defined]
    chosen.bodies = bodies  # type: ignore[attr-defined]
    return cast("ChosenByTable", chosen)


def scalar(function: Function) -> Function:
    """Compile ``function`` as :func:`compiled` does, but faster, for functions that make no arrays.

    The function must not make arrays or call functions that do. Then calls cost less, and the
    compiler need not track who owns which array. The code is optimized once, because long code
    without loops over rows gains nothing from a second pass. An index means the same as in C: a
    negative one does not count from the end, but is an undetected error. Entries of an array of
    whole numbers are not read again after an array of another type is written to.

    Parameters
    ----------
    function : callable
        As for :func:`compiled`, but without closures, comprehensions and operations on whole
        arrays.

    Returns
    -------
    callable
        The compiled function. A function that makes an array raises an error when it is compiled.
    """
    return _compiled(function, scalar=True, _nrt=False)


def _compiled(
    function: Function, *, twice: bool = False, scalar: bool = False, **more: Any
) -> Function:
    if getattr(numba.config, "DISABLE_JIT", False):
        return function
    options = {"nopython": True, "nogil": True, "error_model": "numpy", "boundscheck": None}
    options |= more
    kernel: Any = Kernel(function, targetoptions=options, twice=twice, scalar=scalar, kept=True)
    return cast("Function", kernel)
