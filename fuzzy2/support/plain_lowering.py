"""Direct code generation for plain numbers and entries of flat arrays, without numba's look-ups.

Numba looks up the meaning of each sum, product, comparison and array entry by the types of its
arguments, and then generates general code. That takes most of the time for code that consists of
nothing else. Here the instructions for these few operations are generated directly; they are the
same. All other operations are left to numba.

In functions that could be written in C, indices and arrays have the same meaning as in C: an index
is not negative, and arrays of numbers of different types share no memory. So the compiler need not
read an entry of a table of whole numbers again after each number that is written elsewhere.
"""

from __future__ import annotations

import operator
from typing import Any

from llvmlite import ir
from numba.core import types
from numba.core.compiler_machinery import register_pass
from numba.core.lowering import Lower
from numba.core.typed_passes import NativeLowering

_SUMS = {operator.add: "add", operator.sub: "sub", operator.mul: "mul"}
_COMPARED = {
    operator.lt: "<",
    operator.le: "<=",
    operator.gt: ">",
    operator.ge: ">=",
    operator.eq: "==",
    operator.ne: "!=",
}
PLAIN = frozenset({*_SUMS, *_COMPARED, operator.truediv, operator.getitem, operator.setitem})
"""Operations that are generated directly if their arguments are plain."""

_ENTRIES = (types.float64, types.int64)


def _is_flat(kind: Any) -> bool:
    """Return whether entries of an array can be read and written directly."""
    return (
        isinstance(kind, types.Array)
        and kind.ndim == 1
        and kind.layout == "C"
        and kind.aligned
        and kind.dtype in _ENTRIES
    )


class _PlainLower(Lower):
    """Numba's translation of a function, with plain operations generated directly."""

    counts_from_the_end = True
    """Whether a negative index counts from the end of an array, as in Python."""

    def init(self) -> None:
        """Start; no array is known yet."""
        super().init()
        self._entries: dict[str, tuple[Any, Any]] = {}

    def storevar(self, value: Any, name: str, argidx: int | None = None) -> None:
        """Store a variable; for arrays that are arguments, remember where their entries are."""
        super().storevar(value, name, argidx)
        self._entries.pop(name, None)
        if argidx is not None and _is_flat(self.typeof(name)):
            # The first block dominates all others.
            self._entries[name] = self._where(self.typeof(name), value)

    def _where(self, kind: Any, array: Any) -> tuple[Any, Any]:
        """Return the address of an array's entries, and their number."""
        model = self.context.data_model_manager[kind]
        return model.get(self.builder, array, "data"), model.get(self.builder, array, "nitems")

    def _entry(self, name: str, index: Any) -> Any:
        """Return the address of an entry of an array."""
        known = self._entries.get(name)
        data, count = known or self._where(self.typeof(name), self.loadvar(name))
        if self.counts_from_the_end:
            is_negative = self.builder.icmp_signed("<", index, index.type(0))
            from_the_end = self.builder.add(count, index)
            index = self.builder.select(is_negative, from_the_end, index)
        return self.builder.gep(data, [index])

    def _says_its_type(self, instruction: Any, kind: Any) -> None:
        """Declare the type of an entry, if no other type can share its memory."""
        if self.counts_from_the_end:
            return
        module, start = self.builder.module, ir.Constant(ir.IntType(64), 0)
        root = module.add_metadata([ir.MetaDataString(module, "entries of arrays")])
        own = module.add_metadata([ir.MetaDataString(module, str(kind)), root, start])
        instruction.set_metadata("tbaa", module.add_metadata([own, own, start]))

    def lower_getitem(self, resty: Any, expr: Any, value: Any, index: Any, signature: Any) -> Any:
        """Return an entry of an array."""
        kind = self.typeof(value.name)
        if not _is_flat(kind) or signature.args[1] != types.int64 or resty != kind.dtype:
            return super().lower_getitem(resty, expr, value, index, signature)
        number = self.context.cast(
            self.builder, self.loadvar(index.name), self.typeof(index.name), types.int64
        )
        loaded = self.builder.load(self._entry(value.name, number))
        self._says_its_type(loaded, kind.dtype)
        return loaded

    def lower_setitem(self, target_var: Any, index_var: Any, value_var: Any, signature: Any) -> Any:
        """Write an entry of an array."""
        kind = self.typeof(target_var.name)
        index, value = self.typeof(index_var.name), self.typeof(value_var.name)
        if (
            not _is_flat(kind)
            or signature.args[1] != types.int64
            or types.unliteral(value) not in _ENTRIES
        ):
            return super().lower_setitem(target_var, index_var, value_var, signature)
        number = self.context.cast(self.builder, self.loadvar(index_var.name), index, types.int64)
        written = self.context.cast(self.builder, self.loadvar(value_var.name), value, kind.dtype)
        stored = self.builder.store(written, self._entry(target_var.name, number))
        self._says_its_type(stored, kind.dtype)
        return None

    def lower_binop(self, resty: Any, expr: Any, op: Any) -> Any:
        """Return the result of an operation on two numbers."""
        signature = self.fndesc.calltypes[expr]
        kind = signature.args[0]
        if kind not in _ENTRIES or signature.args[1] != kind:
            return super().lower_binop(resty, expr, op)
        is_sum = op in _SUMS
        is_quotient = op is operator.truediv and kind == types.float64
        # Division by zero is an error unless the function follows IEEE 754.
        if is_quotient and self.context.error_model.raise_on_fp_zero_division:
            is_quotient = False
        if not (is_sum or is_quotient or op in _COMPARED):
            return super().lower_binop(resty, expr, op)
        left, right = (
            self.context.cast(self.builder, self.loadvar(one.name), self.typeof(one.name), kind)
            for one in (expr.lhs, expr.rhs)
        )
        if is_quotient:
            result = self.builder.fdiv(left, right)
        elif is_sum and kind == types.float64:
            result = getattr(self.builder, f"f{_SUMS[op]}")(left, right)
        elif is_sum:
            result = getattr(self.builder, _SUMS[op])(left, right, flags=["nsw"])
        elif kind == types.int64:
            result = self.builder.icmp_signed(_COMPARED[op], left, right)
        elif op is operator.ne:
            result = self.builder.fcmp_unordered("!=", left, right)
        else:
            result = self.builder.fcmp_ordered(_COMPARED[op], left, right)
        return self.context.cast(self.builder, result, signature.return_type, resty)


class _WideLower(_PlainLower):
    """The same for functions whose loops are to be vectorized."""

    def setup_function(self, fndesc: Any) -> None:
        """Set up a function, which may use the widest vectors of the machine."""
        super().setup_function(fndesc)
        # llvmlite does not know attributes with values.
        set.add(self.function.attributes, '"prefer-vector-width"="512"')


class _ScalarLower(_PlainLower):
    counts_from_the_end = False


@register_pass(mutates_CFG=True, analysis_only=False)
class PlainLowering(NativeLowering):
    """Compiler pass that translates a function, with plain operations generated directly."""

    _name = "plain_lowering"
    translator: type[Lower] = _PlainLower

    @property
    def lowering_class(self) -> type[Lower]:
        """Return the class that translates a function."""
        return self.translator


@register_pass(mutates_CFG=True, analysis_only=False)
class WideLowering(PlainLowering):
    """The same pass for functions whose loops are to be vectorized."""

    _name = "wide_lowering"
    translator = _WideLower


@register_pass(mutates_CFG=True, analysis_only=False)
class ScalarLowering(PlainLowering):
    """The same pass for functions whose indices and arrays have the meaning of C."""

    _name = "scalar_lowering"
    translator = _ScalarLower
