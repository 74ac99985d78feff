"""A controller in C, called from Python, and the compiled step that it is compared with."""

from __future__ import annotations

import ctypes
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fuzzy2.export.c_code import CCode
from psp3.checks import Array
from psp3.control.controller import steer, widths_of
from psp3.export.face import c_code
from psp3.multibody.tree import AT_BEFORE
from psp3.trajectories.motion import Motion
from tests.c_code import compiled


class ControllerInC:
    """A controller whose steps are those of its C code; the simulation takes it, too.

    Parameters
    ----------
    controller : controller or CCode
        What is written in C, or its code.
    folder : Path
        Where it is written and compiled.
    optimized : str
        How far gcc goes.
    **options
        As of :func:`psp3.export_c`.
    """

    def __init__(
        self, controller: Any, folder: Path, *, optimized: str = "-O2", **options: Any
    ) -> None:
        is_written = isinstance(controller, CCode)
        self.code = controller if is_written else c_code(controller, **options)
        library = ctypes.CDLL(str(compiled(self.code, folder, "gcc", optimized)))
        self.item = ctypes.c_double if self.code.precision.name == "double" else ctypes.c_float
        self._kind = np.float64 if self.item is ctypes.c_double else np.float32
        self._functions = {
            function.name.removeprefix(f"{self.code.name}_"): function
            for function in self.code.functions
        }
        self._called = {
            name: getattr(library, function.name) for name, function in self._functions.items()
        }
        states = {
            argument.name: argument
            for function in self.code.functions
            for argument in function.arguments
            if argument.role == "state"
        }
        kinds = [
            (name, (ctypes.c_int if state.is_whole else self.item) * (state.size or 1))
            for name, state in states.items()
        ]
        self.state = type("State", (ctypes.Structure,), {"_fields_": kinds})()
        self.outputs = [a.size or 1 for a in self._functions["step"].visible if a.role == "out"]
        self.reset()

    def reset(self) -> None:
        """Begin a run; before, the struct holds whatever memory holds."""
        ctypes.memset(ctypes.byref(self.state), 0xA5, ctypes.sizeof(self.state))
        if "reset" in self._called:
            self._called["reset"](ctypes.byref(self.state))

    def step(self, t: float, *rows: Array) -> tuple[bool, Array]:
        """Return what a step returns, and all numbers that it writes, forces first."""
        given = [np.array(row, dtype=self._kind) for row in rows]
        out = [np.full(size, -7.0, dtype=self._kind) for size in self.outputs]
        pointers = [a.ctypes.data_as(ctypes.POINTER(self.item)) for a in (*given, *out)]
        state = [ctypes.byref(self.state)] if self._functions["step"].has_state else []
        done = self._called["step"](*state, self.item(t), *pointers)
        assert done in (0, 1)
        return bool(done), np.concatenate(out)

    def torque(self, t: float, positions: Array, speeds: Array, desired: Motion) -> Array:
        """Return the forces, as the simulation asks for them."""
        _, out = self.step(t, positions, speeds, np.concatenate(desired[:3]))
        return out[: self.outputs[0]]


class CompiledStep:
    """The compiled loop's own step of a controller, and its memory.

    Numbers that are not finite never reach a controller that remembers; and where a model could not
    follow it starts from its reference in the next step. Both are promised of the C code, and are
    written out here once more.
    """

    def __init__(self, controller: Any, robot: Any) -> None:
        controller.reset()
        self.table = controller.table(robot.compiled_table(), widths_of(robot))
        self._body: Any = steer.bodies[type(self.table)]
        self._width = len(robot.actuated) + controller.numbers_said
        model = getattr(self.table, "model", None)
        self._memory = getattr(model, "memory", None)
        self.remembers = hasattr(self.table, "memory") or self._memory is not None
        if self._memory is not None and model is not None:
            self._reference = self._memory[: int(model.tree[AT_BEFORE])].copy()

    def step(self, t: float, *rows: Array) -> tuple[bool, Array]:
        """Return as :meth:`ControllerInC.step`."""
        out = np.full(self._width, np.nan)
        if self.remembers and not np.isfinite([t, *np.concatenate(rows)]).all():
            return False, out
        done = bool(self._body(self.table, 0, t, *rows, out))
        if self._memory is not None and not done:
            self._memory[: len(self._reference)] = self._reference
        return done, out


def states(robot: Any, count: int, spread: float, seed: int = 0) -> list[tuple[Any, ...]]:
    """Return times, positions, speeds and desired motions about the reference pose.

    Some poses are far out of reach, and some numbers are not finite.
    """
    rng = np.random.default_rng(seed)
    k, p, n, _ = widths_of(robot)
    home, found = np.array(robot.reference), []
    for i in range(count):
        positions = home + rng.normal(0.0, spread, p)
        speeds, desired = rng.normal(0.0, 10.0 * spread, n), rng.normal(0.0, 10.0 * spread, 3 * k)
        desired[:k] = home[:k] + 0.1 * desired[:k]
        if i % 29 == 11:
            positions[rng.integers(p)] += rng.choice([-1.0, 1.0]) * 100.0 * spread
        if i % 41 == 17:
            bad = (positions, speeds, desired)[rng.integers(3)]
            bad[rng.integers(len(bad))] = rng.choice([np.nan, np.inf, -np.inf])
        found.append((0.002 * i, positions, speeds, desired))
    return found


class Comparison(NamedTuple):
    """Of two that take the same steps.

    Which steps are ``different``, in what is returned or in any bit but NaN's; in how many there
    were forces; and all numbers that the other one wrote, (steps, width).
    """

    different: list[int]
    done: int
    numbers: Array


def compared(one: Any, other: Any, rows: list[tuple[Any, ...]]) -> Comparison:
    """Return in which steps two controllers differ."""
    found, answers, count = [], [], 0
    for i, row in enumerate(rows):
        (done, numbers), (expected, right) = one.step(*row), other.step(*row)
        known = ~np.isnan(right)
        if (
            done != expected
            or (np.isnan(numbers) == known).any()
            or numbers[known].tobytes() != right[known].tobytes()
        ):
            found.append(i)
        answers.append(right)
        count += expected
    return Comparison(found, count, np.array(answers))
