"""Every kernel of both packages is in the subset that C can say, or named here with the reason.

Kernels are found in all modules, and those that Python calls are translated for the types that they
declare, of which nothing else is known; all others are reached from them, with the types that they
are called with.
"""

from __future__ import annotations

import ast
import functools
import importlib
import inspect
import pkgutil
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from numba.core import compiler, types
from numba.core.registry import cpu_target
from numba.core.ssa import reconstruct_ssa
from numba.core.typed_passes import type_inference_stage

import fuzzy2
import psp3
from fuzzy2.errors import NotExportable
from fuzzy2.export import translator
from fuzzy2.export.frame import Known
from fuzzy2.export.function import Translation
from fuzzy2.export.kernel_source import source_of
from fuzzy2.export.numbers import Precision
from fuzzy2.export.translator import Program
from fuzzy2.export.values import BOOL, INT, NOTHING, REAL, Record, Row, Scalar, Type, Value
from fuzzy2.support.compile_unit import Kernel
from psp3.control.kernels import Classical
from psp3.control.linear_quadratic_kernels import Regulation
from psp3.control.task_space_kernels import TaskLaw
from psp3.export.closed_form import OVER_LEGS
from psp3.fuzzy_control.adaptive_kernels import Adaptive
from psp3.fuzzy_control.kernels import FuzzyRun, NoModel
from psp3.fuzzy_control.slotine_li_kernels import SlotineLi
from psp3.multibody.core import Tables
from psp3.robots.stepping import DrivenTables
from psp3.three_psp.stepping import ClosedForm
from tests.fuzzy2.export.in_c import needs_gcc

LEARNING = "learns from samples in tables of three dimensions, before anything is on a drive"
BATCH = "a batch, in tables of three dimensions; what it does with a row is in the subset"

NOT_FOR_C = {
    "fuzzy2.learning.adaptation_kernels.evaluate": BATCH,
    "fuzzy2.learning.adaptation_kernels.learn": LEARNING,
    "fuzzy2.learning.tuning_kernels.add_squares": LEARNING,
    "fuzzy2.reduction.kernels.reduce_rows": BATCH,
    "fuzzy2.reduction.kernels.reduce_rows_in_logarithms": BATCH,
    "fuzzy2.systems.united_kernels.centroids_of_unions": BATCH,
}
"""Kernels that Python calls and C cannot say, and why that is right."""

ONLY_OF_THESE = {
    "fuzzy2.learning.adaptation_kernels._any_basis",
    "fuzzy2.learning.adaptation_kernels._by_end",
    "fuzzy2.learning.adaptation_kernels._far_basis",
    "fuzzy2.learning.adaptation_kernels._far_end",
    "fuzzy2.learning.adaptation_kernels._is_lost",
    "fuzzy2.learning.adaptation_kernels._write",
    "fuzzy2.learning.tuning_kernels._add_consequents",
    "fuzzy2.learning.tuning_kernels._add_end",
    "fuzzy2.learning.tuning_kernels._add_premises",
    "fuzzy2.learning.tuning_kernels._consequents",
    "fuzzy2.learning.tuning_kernels._end_of",
    "fuzzy2.learning.tuning_kernels._fire",
    "fuzzy2.learning.tuning_kernels._log_grades",
}
"""Kernels that only those call."""

WITH_MEMORY = {
    "fuzzy2.reduction.kernels.centroid_of_row",
    "fuzzy2.systems.anya_kernels.relative_densities",
    "fuzzy2.systems.corollary_kernels.evaluate_corollary",
    "fuzzy2.systems.firing_kernels._fire_block",
    "fuzzy2.systems.kernels._evaluate_blocks",
    "fuzzy2.systems.kernels.evaluate",
    "fuzzy2.systems.kernels.evaluate_crisp_planes",
    "fuzzy2.systems.kernels.evaluate_planes",
    "fuzzy2.systems.kernels.firing",
    "fuzzy2.systems.output_kernels.averages",
    "fuzzy2.systems.monotonic_rows.monotonic_points",
    "fuzzy2.systems.sampled_rows.samples",
    "fuzzy2.systems.union_rows.unions",
    "psp3.control.kernels._add_feedback",
    "psp3.control.kernels.classical_step",
    "psp3.control.linear_quadratic_kernels.regulation_step",
    "psp3.control.task_space_kernels._correct",
    "psp3.control.task_space_kernels._moved_smallest",
    "psp3.control.task_space_kernels._signed_smallest",
    "psp3.control.task_space_kernels._write_accelerations",
    "psp3.control.task_space_kernels._write_gradient",
    "psp3.control.task_space_kernels._write_jacobian",
    "psp3.control.task_space_kernels.task_space_step",
    "psp3.drives.kernels.accelerations",
    "psp3.drives.kernels.choose_slip",
    "psp3.dynamics.driven_steps._trial",
    "psp3.dynamics.driven_steps.advance_driven",
    "psp3.dynamics.motor_kernels.shortest",
    "psp3.fuzzy_control.adaptive_kernels.adaptive_step",
    "psp3.fuzzy_control.kernels.control_step",
    "psp3.fuzzy_control.kernels.fuzzy_torque",
    "psp3.fuzzy_control.slotine_li_kernels._write_basis",
    "psp3.fuzzy_control.slotine_li_kernels._write_gradient",
    "psp3.fuzzy_control.slotine_li_kernels.slotine_li_step",
    "psp3.robots.stepping.forces_of_all",
    "psp3.robots.stepping.forces_of_first",
    "psp3.robots.stepping.shared_among_motors",
}
"""Kernels that make memory of a size that their caller's tables or arrays say."""

DIMENSIONS = {
    "learn": {"trained": 3, "information": 3, "consequents": 3, "orders": 3}
    | dict.fromkeys(("x", "y", "lower", "upper", "right", "moved", "errors"), 2),
    "evaluate": {"x": 2, "consequents": 3, "orders": 3, "out": 2},
    "add_squares": {"X": 2, "y": 2},
    "Layout": {"rules": 2, "spreads": 3},
    "reduce_rows": {"z": 3, "order": 3, "w": 3, "out": 2},
    "reduce_rows_in_logarithms": {"z": 3, "order": 3, "logarithms": 3, "out": 2},
    "centroids_of_unions": {"strengths": 3, "out": 2},
    "DrivenTables": {"motors": 2, "columns": 2, "elsewhere": 2},
    "run": {"drives": 2},
    "_add_elsewhere": {"drives": 2, "mass": 2},
    "Wires": {"noise": 2},
    "Track": dict.fromkeys(("desired", "states", "asked", "applied", "wrote"), 2),
    "Classical": {"kp": 2, "kv": 2, "memory": 2, "added": 2},
    "Regulation": {"gains": 2, "memory": 2},
    "Fuzzy": {"ranges": 2, "planes": 2, "inputs": 2},
    "FuzzyRun": {"added": 2},
    "adaptive_kernels.Rules": {"ranges": 2, "trained": 2},
    "adaptive_kernels.Memory": dict.fromkeys(
        ("rows", "information", "factor", "consequents", "orders"), 2
    ),
    "slotine_li_kernels.Rules": {"damping": 2},
}
"""Dimensions of arrays that have more than one, by the kernel or the NamedTuple that names them."""

CONTROLLERS = (Classical, Regulation, FuzzyRun, Adaptive, SlotineLi, TaskLaw)
ROBOTS = (ClosedForm, Tables, DrivenTables)
OF_TREES = (TaskLaw,)
"""Controllers whose robot is always a tree with loops."""


class Choice(NamedTuple):
    """What stands for the tables of any type among a kernel's arguments."""

    controller: Any
    robot: Any


def modules() -> Iterator[Any]:
    for package in (fuzzy2, psp3):
        for found in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            yield importlib.import_module(found.name)


@functools.cache
def kernels() -> dict[Callable[..., Any], Kernel]:
    """Return all kernels by their Python functions."""
    found = (thing for module in modules() for thing in vars(module).values())
    return {kernel.py_func: kernel for kernel in found if isinstance(kernel, Kernel)}


def full_name(body: Callable[..., Any]) -> str:
    return f"{body.__module__}.{body.__qualname__}"


def called_by(body: Callable[..., Any]) -> set[Callable[..., Any]]:
    """Return the kernels that a kernel names, and all bodies of those chosen by a table."""
    source = source_of(body)
    names = {node.id for node in ast.walk(source.tree) if isinstance(node, ast.Name)}
    things = [source.names.get(name) for name in names]
    chosen = [one for thing in things for one in getattr(thing, "bodies", {}).values()]
    found = {getattr(thing, "py_func", thing) for thing in [*things, *chosen] if callable(thing)}
    return found & kernels().keys() - {body}


def called_from_python() -> list[Callable[..., Any]]:
    """Return the kernels that no other calls."""
    called = {other for body in kernels() for other in called_by(body)}
    return [body for body in kernels() if body not in called]


# ------------------------------------------------------------------------------- declared types
def declared(annotation: Any, owner: str, name: str, module: str, choice: Choice) -> Type:
    """Return the type of an argument or a field."""
    if isinstance(annotation, str):
        annotation = eval(annotation, vars(sys.modules[module]))
    if hasattr(annotation, "__forward_arg__"):
        return declared(annotation.__forward_arg__, owner, name, module, choice)
    if annotation is Any:
        # A controller's model is the robot in its loop.
        annotation = choice.controller if name == "controller" else choice.robot
    plain = {int: INT, float: REAL, bool: BOOL}
    if annotation in plain:
        return plain[annotation]
    if hasattr(annotation, "_fields"):
        return record_of(annotation, choice)
    item = {"float64": REAL, "int64": INT, "bool": INT}[
        next(kind for kind in ("float64", "int64", "bool") if kind in str(annotation))
    ]
    dimensions = DIMENSIONS.get(owner, {}).get(name, 1)
    return Row(item, False, (None,) * dimensions)


def record_of(table: Any, choice: Choice) -> Record:
    """Return the type of a NamedTuple."""
    module, hints = table.__module__, table.__annotations__
    owner = f"{module.rpartition('.')[2]}.{table.__name__}"
    owner = owner if owner in DIMENSIONS else table.__name__
    fields = [(name, declared(hints[name], owner, name, module, choice)) for name in table._fields]
    return Record(table.__name__, tuple(fields), table)


def choices(body: Callable[..., Any]) -> list[Choice]:
    """Return what to take for tables of any type."""
    if not any(one.annotation == "Any" for one in inspect.signature(body).parameters.values()):
        return [Choice(None, NoModel)]
    every = [Choice(controller, robot) for controller in CONTROLLERS for robot in ROBOTS]
    return [one for one in every if one.controller not in OF_TREES or one.robot is not ClosedForm]


def arguments_of(body: Callable[..., Any], choice: Choice) -> dict[str, Type]:
    parameters = inspect.signature(body).parameters.items()
    return {
        name: declared(one.annotation, body.__name__, name, body.__module__, choice)
        for name, one in parameters
    }


# ---------------------------------------------------------------------------------- translation
class Translated(NamedTuple):
    """What became of all kernels."""

    program: Program
    reached: frozenset[Callable[..., Any]]
    refused: dict[str, str]
    with_memory: frozenset[str]


@functools.cache
def translated() -> Translated:
    """Translate all kernels that Python calls, and with them those that they call."""
    program = Program("every", Precision("double"), frozenset(OVER_LEGS))
    reached: set[Callable[..., Any]] = set()
    refused: dict[str, str] = {}
    with_memory: set[str] = set()

    class OfAnySize(Translation):
        """A translation in which memory may have a size that only callers know."""

        def translate(self) -> None:
            super().translate()
            reached.add(self.body)

        def memory(self, node: ast.Call, zeros: bool, known: Known) -> Value:
            try:
                return super().memory(node, zeros, known)
            except NotExportable as error:
                if "the size of memory must be known" not in str(error):
                    raise
            with_memory.add(full_name(self.body))
            self.count += 1
            name = f"memory_{self.count}"
            self.buffers.append(f"    double {name}[1];")
            asked = node.args[0].elts if isinstance(node.args[0], ast.Tuple) else node.args[:1]
            sizes = [self.place(size, known) for size in asked]
            kind = Row(REAL, False, tuple(size.known for size in sizes))
            return Value(kind, self.struct(kind, name, *(size.code for size in sizes)))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(translator, "Translation", OfAnySize)
        for body in called_from_python():
            try:
                for choice in choices(body):
                    values = [Value(k, n) for n, k in arguments_of(body, choice).items()]
                    program.call(kernels()[body], values)
            except NotExportable as error:
                refused[full_name(body)] = str(error)
                # What it had begun is not there.
                for key in program.open:
                    program.instances.pop(key, None)
                program.open.clear()
    return Translated(program, frozenset(reached), refused, frozenset(with_memory))


def test_all_kernels_are_found():
    """As many as there are decorators in the source."""
    written = 0
    for package in (fuzzy2, psp3):
        for path in Path(next(iter(package.__path__))).rglob("*.py"):
            text = path.read_text(encoding="utf-8")
            written += len(re.findall(r"^@(?:compiled|scalar|inlined)$", text, re.M))
    assert len(kernels()) == written > 300


def test_every_kernel_is_translated_or_named_with_a_reason():
    done = translated()
    assert done.refused.keys() == NOT_FOR_C.keys(), done.refused
    left = {full_name(body) for body in kernels().keys() - done.reached}
    assert left == NOT_FOR_C.keys() | ONLY_OF_THESE


def test_what_is_refused_is_named_by_file_line_and_kernel():
    for name, message in translated().refused.items():
        kernel = name.rpartition(".")[2]
        assert re.search(rf"\.py, line \d+, in {kernel}: .+ cannot be written in C: ", message)
        assert "docs/concepts/kernels.md" in message


@needs_gcc
def test_what_is_translated_is_c(tmp_path):
    """Without a warning of any kind but that nobody calls what Python calls."""
    program = translated().program
    names = " ".join(instance.name for instance in program.order)
    source = tmp_path / "every.c"
    source.write_text(f"#include <math.h>\n{program.definitions(names)}\n", encoding="utf-8")
    flags = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"]
    command = ["gcc", *flags, "-Wno-unused-function", "-fsyntax-only", str(source)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:4000]


def test_memory_that_callers_size_is_made_where_it_is_said():
    """Exported, these are called with a table that fixes the size."""
    assert translated().with_memory - NOT_FOR_C.keys() == WITH_MEMORY


def numba_type(kind: Type) -> Any:
    if isinstance(kind, Scalar):
        return {REAL: types.float64, INT: types.int64, BOOL: types.boolean}[kind]
    if isinstance(kind, Row):
        item = types.int64 if kind.item == INT else types.float64
        return types.Array(item, len(kind.shape), "C")
    parts = [numba_type(part) for _, part in kind.fields]
    return types.NamedTuple(parts, kind.made)


@pytest.mark.slow
def test_declared_types_are_those_that_numba_can_compile():
    """Also where C cannot: numba finds the types of all that is called, and of all results."""
    contexts = cpu_target.typing_context, cpu_target.target_context
    for context in contexts:
        context.refresh()
    results = {}
    for body in called_from_python():
        for choice in choices(body)[::7]:
            arguments = tuple(numba_type(kind) for kind in arguments_of(body, choice).values())
            tree = reconstruct_ssa(compiler.run_frontend(body))
            results[full_name(body)] = type_inference_stage(*contexts, tree, arguments, None)[1]
    assert len(results) == len(called_from_python())
    program = translated().program
    for (body, *_), instance in program.instances.items():
        if full_name(body) in results:
            found = types.unliteral(results[full_name(body)])
            kind = {"real": types.Float, "int": types.Integer, "bool": types.Boolean}
            expected = types.NoneType if instance.result == NOTHING else kind[instance.result.name]
            assert isinstance(found, expected), (full_name(body), found)
