"""A compiled function and all functions that it calls, as one unit for the compiler.

Numba optimizes every function together with all functions that it calls, and does so again for each
caller. So the last function in a chain of calls is optimized once for every function in the chain.
Here a function that others call is only translated and simplified; it is called a *part*. A
function that Python calls includes all parts that it needs and is optimized once. Results are the
same, because the compiler may not reorder floating-point operations in either case.

The types of the simplest operations, such as sums of numbers and entries of arrays, are looked up
once and cached, and their code is generated directly (:mod:`fuzzy2.support.plain_lowering`).
Functions that could be written in C skip numba's searches for closures, comprehensions and array
expressions. Together this saves two thirds of the translation time.

The code builds on classes that numba documents for its developers, not for its users. The tests of
this file fail if a version of numba changes them.
"""

from __future__ import annotations

import contextlib
import functools
import types as python_types
from collections.abc import Callable
from typing import Any

from llvmlite.binding import Linkage
from numba._dynfunc import make_function
from numba.core import typed_passes, types, untyped_passes
from numba.core.caching import NullCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import PassManager
from numba.core.registry import CPUDispatcher
from numba.core.sigutils import normalize_signature
from numba.core.typed_passes import NativeLowering
from numba.core.typing.context import Context

from fuzzy2.support.announcements import announced
from fuzzy2.support.code_files import CodeCache
from fuzzy2.support.deferred_interrupts import deferred_interrupts
from fuzzy2.support.plain_lowering import PLAIN, PlainLowering, ScalarLowering, WideLowering


class Kernel(CPUDispatcher):
    """A compiled function: a whole unit if Python calls it, and a part if a compiled function does.

    Parameters
    ----------
    function : callable
        The function.
    locals : dict, optional
        Types of variables; none are given here.
    targetoptions : dict, optional
        Options of ``numba.njit``.
    twice : bool
        Whether the compiler optimizes the code a second time. Only then are parts inlined and
        simple enough for vector instructions, which may be as wide as the machine's.
    scalar : bool
        Whether the function could be written in C: no index is negative, and arrays of numbers of
        different types share no memory.
    kept : bool
        Whether the machine code is stored on disk, if possible.
    """

    def __init__(
        self,
        function: Callable[..., Any],
        locals: dict[str, Any] | None = None,
        targetoptions: dict[str, Any] | None = None,
        *,
        twice: bool = False,
        scalar: bool = False,
        kept: bool = False,
    ) -> None:
        # Older versions of numba need a dictionary even if no types are given.
        kinds, options = dict(locals or {}), dict(targetoptions or {})
        whole: type[Compiler] = _TwiceCompiler if twice else _WholeCompiler
        part: type[Compiler] = PartCompiler
        if scalar:
            whole, part = _ScalarCompiler, _ScalarPartCompiler
        super().__init__(function, kinds, options, pipeline_class=whole)
        self._how, self._is_kept = (kinds, options, part), kept
        self._asked: set[tuple[Any, ...]] = set()
        # Numba's own, which is none.
        del self._cache

    # Both are created on demand, because a process needs neither for most of its hundreds of
    # functions.

    @functools.cached_property
    def _part(self) -> Any:
        """The function as compiled functions call it."""
        kinds, options, compiler = self._how
        return CPUDispatcher(self.py_func, kinds, options, pipeline_class=compiler)

    @functools.cached_property
    def _cache(self) -> Any:
        """The cache where numba finds and stores the machine code."""
        # "no locator available": there is no writable folder
        with contextlib.suppress(RuntimeError):
            return CodeCache(self.py_func) if self._is_kept else NullCache()
        return NullCache()

    def keep_to(self, *arguments: Any) -> None:
        """Refuse from now on what has other types than these arguments and those given before.

        Parameters
        ----------
        *arguments
            Arguments of types that the function can be compiled for when it is called.
        """
        kinds = tuple(map(self.typeof_pyval, arguments))
        if kinds in self._asked:
            return
        with deferred_interrupts(), global_compiler_lock:
            self._asked.add(kinds)
            self._close_if_complete()

    def _close_if_complete(self) -> None:
        """Have numba refuse other types without asking, once no more is to be compiled."""
        if self._asked:
            self.disable_compile(self._asked <= self.overloads.keys())

    def compile(self, sig: Any) -> Any:
        """Return the machine code for arguments of these types.

        Who waited while another thread made it finds it there, though nothing else may be compiled
        any more.

        Raises
        ------
        TypeError
            If the function is kept to other types.
        """
        kinds = tuple(normalize_signature(sig)[0])
        # LLVM frees things twice, and Python ends, where Ctrl-C comes into the middle of it. Just
        # before the block it would leave the lock locked for ever, and other threads would wait.
        with deferred_interrupts(), global_compiler_lock:
            made: Any = self.overloads.get(kinds)
            if made is not None:
                return made.entry_point
            if self._asked and kinds not in self._asked:
                given = ", ".join(map(str, kinds))
                raise TypeError(f"No matching definition for arguments of the types {given}")
            code = super().compile(sig)
            self._close_if_complete()
            return code

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Return how compiled code calls the function with arguments of these types."""
        # The types are not resolved again for each whole number that is written into a call.
        plain = {name: types.unliteral(kind) for name, kind in kws.items()}
        return self._part.get_call_template(tuple(map(types.unliteral, args)), plain)

    def get_overload(self, sig: Any) -> Any:
        """Return the key of the function that compiled code calls."""
        return self._part.get_overload(sig)


_SIGNATURES: dict[Any, Any] = {}


class _Operations(Context):
    """Numba's types of functions, with a cache for those of the simplest operations."""

    def __init__(self, context: Context) -> None:
        # Share all that numba knows, including what it will learn later.
        self.__dict__ = context.__dict__

    def resolve_function_type(self, func: Any, args: Any, kws: Any) -> Any:
        """Return the signature of a call."""
        operation = func.typing_key if type(func) is types.Function else func
        if kws or type(operation) is not python_types.BuiltinFunctionType or not _are_plain(args):
            return super().resolve_function_type(func, args, kws)
        # A literal whole number does not change the type of a sum. For two literals, such as a
        # counter before more is known of it, numba would compare their values.
        kinds = tuple(map(types.unliteral, args)) if operation in PLAIN else args
        key = operation, kinds
        if key not in _SIGNATURES:
            _SIGNATURES[key] = super().resolve_function_type(func, kinds, kws)
        return _SIGNATURES[key]


def _are_plain(kinds: Any) -> bool:
    """Return whether all types are numbers or one-dimensional arrays."""
    return all(
        isinstance(types.unliteral(kind), types.Number | types.Boolean)
        or (isinstance(kind, types.Array) and kind.ndim == 1)
        for kind in kinds
    )


class _PartLibrary(JITCodeLibrary):
    """The code of a part, simplified by itself, but without machine code."""

    def __init__(self, codegen: Any, name: str) -> None:
        super().__init__(codegen, name)
        self._with_parts: Any = None

    def finalize(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True

    def own_code(self) -> Any:
        """Return the code of this part alone."""
        return super()._get_module_for_linking()

    def _get_module_for_linking(self) -> Any:
        """Return the code with all parts, for functions that numba compiles as usual."""
        if self._with_parts is None:
            linked = self.own_code().clone()
            _link(linked, self)
            # Only complete code is cached, because Ctrl-C may interrupt the linking.
            self._with_parts = linked
        return self._with_parts


class _Whole(JITCodeLibrary):
    """The code of a function that Python calls, with all its parts."""

    def finalize(self) -> None:
        self._raise_if_finalized()
        own = {one.name for one in self._final_module.functions if not one.is_declaration}
        _link(self._final_module, self)
        for one in self._final_module.functions:
            if one.linkage == Linkage.linkonce_odr and one.name not in own:
                # Internal linkage lets the compiler remove a part that is inlined everywhere.
                one.linkage = "internal"
        self._optimize_final_module()
        self._final_module.verify()
        self._finalize_final_module()


class _Twice(_Whole):
    """The same, optimized twice."""

    def _optimize_final_module(self) -> None:
        super()._optimize_final_module()
        # Only simple code is vectorized, and parts are not simple before the first optimization.
        passes, builder = self._codegen._module_pass_manager()
        passes.run(self._final_module, builder)


def _link(module: Any, library: Any) -> None:
    """Add to a module the code of all functions that a library calls, directly or indirectly."""
    called, left = set(), list(library._linking_libraries)
    while left:
        one = left.pop()
        if one in called:
            continue
        called.add(one)
        is_part = isinstance(one, _PartLibrary)
        module.link_in(one.own_code() if is_part else one._get_module_for_linking(), preserve=True)
        library._reload_init.update(one._reload_init)
        if is_part:
            left += one._linking_libraries


class _PlainCompiler(Compiler):
    """Numba's compiler, with plain operations generated directly."""

    lowering: type[NativeLowering] = PlainLowering
    needless: frozenset[Any] = frozenset()

    def define_pipelines(self) -> list[PassManager]:
        """Return the passes of the compiler."""
        (theirs,) = super().define_pipelines()
        ours = PassManager(theirs.pipeline_name)
        for one, description in theirs.passes:
            if one not in self.needless:
                ours.add_pass(self.lowering if one is NativeLowering else one, description)
        ours.finalize()
        return [ours]


class _WholeCompiler(_PlainCompiler):
    library: type[JITCodeLibrary] = _Whole
    work = 1.0

    def __init__(self, typingctx: Any, targetctx: Any, library: Any, *more: Any) -> None:
        super().__init__(_Operations(typingctx), targetctx, library, *more)
        # No C wrapper is needed, because C does not call the function.
        self.state.flags.no_cfunc_wrapper = True

    def compile_extra(self, func: Any) -> Any:
        """Return the function with its parts, optimized, as machine code."""
        self.state.library = self.library(self.state.targetctx.codegen(), func.__qualname__)
        self.state.library.enable_object_caching()
        with announced(func, self.state.args, self.work):
            result = super().compile_extra(func)
        # Exceptions that parts may raise.
        for environment in result._find_referenced_environments():
            result.library.codegen.set_env(environment.env_name, environment)
        return result


class _TwiceCompiler(_WholeCompiler):
    lowering = WideLowering
    library = _Twice
    work = 1.7


class PartCompiler(_PlainCompiler):
    """Translates a function that other compiled functions call."""

    def __init__(self, typingctx: Any, targetctx: Any, library: Any, *more: Any) -> None:
        super().__init__(_Operations(typingctx), targetctx, library, *more)
        flags = self.state.flags
        flags.no_compile = flags.no_cpython_wrapper = flags.no_cfunc_wrapper = True

    def compile_extra(self, func: Any) -> Any:
        """Return the function, translated."""
        self.state.library = _PartLibrary(self.state.targetctx.codegen(), func.__qualname__)
        result = super().compile_extra(func)
        # Numba finds the part by this entry; there is no machine code behind it to call.
        nothing = make_function(
            result.fndesc.lookup_module(), func.__name__, "", 0, result.environment, ()
        )
        self.state.targetctx.insert_user_function(nothing, result.fndesc, [result.library])
        return result._replace(entry_point=nothing)


class _Scalar:
    """Mixin for compilers of functions that could be written in C."""

    lowering: type[NativeLowering] = ScalarLowering
    # Passes that search for closures, comprehensions, array expressions and branches on types.
    needless: frozenset[Any] = frozenset(
        {
            untyped_passes.DeadBranchPrune,
            untyped_passes.FindLiterallyCalls,
            untyped_passes.InlineClosureLikes,
            untyped_passes.InlineInlinables,
            untyped_passes.LiteralPropagationSubPipelinePass,
            untyped_passes.LiteralUnroll,
            untyped_passes.MakeFunctionToJitFunction,
            untyped_passes.RewriteSemanticConstants,
            untyped_passes.WithLifting,
            typed_passes.InlineOverloads,
            typed_passes.NopythonRewrites,
        }
    )


class _ScalarCompiler(_Scalar, _WholeCompiler):
    pass


class _ScalarPartCompiler(_Scalar, PartCompiler):
    pass
