"""Every kernel that exported systems reach: its types are numba's, and every loop of it ends."""

from __future__ import annotations

import functools
import re
from typing import Any

import numpy as np
import pytest
from numba.core import compiler, types
from numba.core.registry import cpu_target
from numba.core.ssa import reconstruct_ssa
from numba.core.typed_passes import type_inference_stage

from fuzzy2.export import translator
from fuzzy2.export.frame import Frame
from fuzzy2.export.function import Translation
from fuzzy2.export.systems import c_code_of
from fuzzy2.export.values import BOOL, INT, REAL, Record, Row, Scalar
from tests.fuzzy2.export.kinds import KINDS, SLOW

pytestmark = pytest.mark.filterwarnings("ignore::fuzzy2.ApproximationWarning")

WHILE = {
    "center_of_sets": "i counts up to the number of rules in each of them",
    "end_of_interval": "k moves one way, between 1 and one less than the number of points",
    "end_in_logarithms": "k counts up to one less than the number of points",
    "formula_at": "step counts up to the end of the formula, which the table says",
    "maximum_of_union": "i counts down to 0",
    "supplement_firing": "step counts up to the end of the rule's steps, which the table says",
    "log_fire_trees": "step counts up to the end of the rule's steps, which the table says",
    "sort": "k counts down to 0",
    "as_floats": "k counts down to 0, or up to the number of weights",
    "nodes_of": "k counts down to 0",
    "between": "each turn halves the samples that are left",
    "pieces_of": "each turn takes a piece from the stack, and at most MOST_TURNS put two back",
}
"""Functions with loops that do not count, and why these end all the same."""


@functools.cache
def sources() -> dict[str, str]:
    return {kind: c_code_of(made()).source for kind, made in (KINDS | SLOW).items()}


def functions(source: str) -> dict[str, str]:
    """Return the functions of a file by name, in order."""
    found = re.findall(
        r"^(?:static )?\w[\w ]*?\*?(\w+)\([^;]*?\)\n\{\n(.*?)^\}", source, re.M | re.S
    )
    return dict(found)


@pytest.mark.parametrize("kind", KINDS | SLOW)
def test_no_function_calls_itself_or_one_that_comes_later(kind):
    bodies = functions(sources()[kind])
    assert len(bodies) > 3
    seen: set[str] = set()
    for name, body in bodies.items():
        called = set(re.findall(r"\b(\w+)\(", body)) & bodies.keys()
        assert called <= seen
        seen.add(name)


@pytest.mark.parametrize("kind", KINDS | SLOW)
def test_memory_is_of_sizes_that_are_written_down(kind):
    source = sources()[kind]
    assert not re.search(r"\b(malloc|calloc|realloc|free|alloca)\b", source)
    arrays = re.findall(r"^    (?:double|int) \w+\[(.*?)\];", source, re.M)
    assert arrays
    assert all(size.isdigit() for size in arrays)
    # What is global is constant.
    for line in source.splitlines():
        if re.match(r"(static )?\w[\w ]*\[\d*\]", line):
            assert line.startswith("static const ")


@pytest.mark.parametrize("kind", KINDS | SLOW)
def test_every_loop_ends(kind):
    for name, body in functions(sources()[kind]).items():
        lines = body.splitlines()
        for number, line in enumerate(lines):
            if re.match(r"\s*while \(", line):
                base = re.sub(r"^system_|_\d+$", "", name)
                assert base in WHILE, f"{base} has a loop that does not count, and no reason"
            loop = re.match(r"(\s*)for \((\w+) = (.*); \2 [<>] (.*); (.*)\) \{$", line)
            assert (loop is None) == ("for (" not in line)
            if loop:
                space, counter, _, bound, step = loop.groups()
                assert step in (f"{counter}++", f"{counter}--")
                assert re.fullmatch(r"-?\w+", bound)
                end = next(i for i in range(number, len(lines)) if lines[i] == f"{space}}}")
                inside = "\n".join(lines[number + 1 : end])
                # Neither the counter nor the bound is changed.
                assert not re.search(rf"^\s*({counter}|{bound}) = ", inside, re.M)


def test_reasons_are_of_loops_that_are_there():
    text = "\n".join(sources().values())
    named = {re.sub(r"^system_|_\d+$", "", name) for name in functions(text)}
    assert WHILE.keys() <= named


def numba_type(kind: Any) -> Any:
    if isinstance(kind, Scalar):
        return {REAL: types.float64, INT: types.int64, BOOL: types.boolean}[kind]
    if isinstance(kind, Row):
        item = types.int64 if kind.item == INT else types.float64
        return types.Array(item, len(kind.shape), "C")
    parts = [numba_type(part) for _, part in kind.fields]
    return types.NamedTuple(parts, kind.made) if kind.made else types.Tuple(parts)


def kind_of(numba: Any) -> str:
    numba = types.unliteral(numba)
    if isinstance(numba, types.Array):
        return f"array of {kind_of(numba.dtype)}"
    if isinstance(numba, types.BaseTuple):
        return "record"
    return {types.Boolean: "bool", types.Integer: "int", types.Float: "real"}[
        next(
            base for base in (types.Boolean, types.Integer, types.Float) if isinstance(numba, base)
        )
    ]


def own_kind(kind: Any) -> str:
    if isinstance(kind, Row):
        return f"array of {kind.item.name}"
    return "record" if isinstance(kind, Record) else kind.name


def translated() -> dict[Any, Translation]:
    """Return a translation of each kernel that systems reach."""
    found: dict[Any, Translation] = {}

    class Noted(Translation):
        def translate(self) -> None:
            super().translate()
            found.setdefault(self.body, self)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(translator, "Translation", Noted)
        for made in (KINDS | SLOW).values():
            c_code_of(made())
    return found


@pytest.mark.slow
def test_types_are_those_that_numba_infers():
    kernels = translated()
    assert len(kernels) > 40
    compared = 0
    for body, own in kernels.items():
        if body.__module__ == "fuzzy2.export.system_kernels":
            # Entries that dispatch on the kind of a system; numba never sees them.
            continue
        arguments = tuple(numba_type(value.type) for _, value in own.parameters)
        tree = reconstruct_ssa(compiler.run_frontend(body))
        contexts = cpu_target.typing_context, cpu_target.target_context
        typemap = type_inference_stage(*contexts, tree, arguments, None)[0]
        order = ["bool", "int", "real"]
        for name, kind in own.types.items():
            # Numba gives a variable a type each time it is assigned; C has one for all of them.
            versions = {
                kind_of(numba)
                for other, numba in typemap.items()
                if other.split(".")[0] == name and not isinstance(numba, types.Omitted)
            }
            if versions and name != "_":
                compared += 1
                widest = max(versions, key=lambda one: order.index(one) if one in order else 9)
                assert own_kind(kind) == widest, (body.__name__, name, versions)
    assert compared > 300


@pytest.mark.parametrize("kind", ["interval", "linear", "mamdani"])
def test_what_is_only_looked_at_while_code_is_written_is_left_out(kind):
    source = sources()[kind]
    for name in re.findall(r"^static const \w+ (\w+)\[", source, re.M):
        assert len(re.findall(rf"\b{name}\b", source)) > 1
    assert issubclass(Translation, Frame)
    assert np.size(re.findall("typedef struct", source)) <= 8
