"""Compile scalar kernels with numba.

Cached on disk where that is possible, without the interpreter lock.

Both packages compile with this one decorator. Numba does not notice when a function in *another*
module changed, though kernels call those of other modules: ``fuzzy2.support.code_stamp`` does.
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

    The code releases the interpreter lock and divides as IEEE 754 does.

    Parameters
    ----------
    function : callable
        A function of scalars and contiguous arrays in the subset of Python that numba compiles.

    Returns
    -------
    callable
        The compiled function. Where no folder for its code can be written
        (:mod:`fuzzy2.support.code_folder`) it is compiled anew in every process.
    """
    return _compiled(function, twice=True)


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
    return _compiled(function, twice=True, forceinline=True)


class ChosenByTable(Protocol):
    """What :func:`chosen_by_table` returns."""

    bodies: Mapping[Any, Callable[..., Any]]
    """The bodies by the NamedTuple class that they are for."""

    def __call__(self, table: Any, *arguments: Any) -> Any:
        """Return what the body for the table's type does."""
        ...

    def register(self, kind: Any) -> Callable[[Function], Function]:
        """Return a decorator of the body for a NamedTuple class."""
        ...


def chosen_by_table(declaration: Callable[..., Any]) -> ChosenByTable:
    """Declare a compiled function that has one body for each type of its first argument.

    So a kernel that serves any table, a NamedTuple of arrays, can ask it for what depends on its
    kind; whoever has a kind of table gives the body. Which one it is stands fixed once the kernel
    is compiled for the table, and the compiled kernel can be kept on disk.

    Parameters
    ----------
    declaration : callable
        A function that says what all bodies do.

    Returns
    -------
    ChosenByTable
        The function; ``@declared.register(Table)`` stands above the body for a NamedTuple class. A
        body is compiled where it is called from; what is long in it belongs into a function of its
        own that is :func:`compiled`.
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
    """Compile ``function`` as :func:`compiled` does, without memory of its own, in less time.

    For functions that make no arrays, and call none that do: calls cost less, and the compiler need
    not find out who holds which array. It goes over the code once; long code without loops over
    rows gains nothing from a second time. An index is what it is in C: a negative one does not
    count from the end, but is an error that nobody notices; and entries of an array of whole
    numbers are not read again after an array of others is written to.

    Parameters
    ----------
    function : callable
        As for :func:`compiled`, without closures, comprehensions and operations on whole arrays.

    Returns
    -------
    callable
        The compiled function. A function that makes an array is refused when it is compiled.
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
