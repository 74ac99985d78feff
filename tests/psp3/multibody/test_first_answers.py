"""A robot is made, and asked a few questions, without compiling anything: with the same bits."""

from __future__ import annotations

import numpy as np
import pytest

import psp3
from fuzzy2.support.interpreted import twin_of
from psp3.multibody.closing import CLOSED
from psp3.multibody.first_answers import compile_answers, first_answer
from psp3.multibody.motion import (
    ASSEMBLY,
    COMPLEMENT,
    CONFIGURATION,
    ENERGIES,
    EQUATION_OF_MOTION,
    FORWARD_DERIVATIVES,
    FORWARD_DYNAMICS,
    FRAME,
    INVERSE_DERIVATIVES,
    INVERSE_DYNAMICS,
    MOTION,
    answer,
    derivatives,
)
from psp3.multibody.tree import AT_CONFIGURATION
from tests.helpers import Array


def bits(numbers: Array) -> bytes:
    """Return numbers as bytes; which of the many NaN one is the processor may choose."""
    return np.where(np.isnan(numbers), np.nan, numbers).tobytes()


BEFORE_DERIVATIVES = {
    INVERSE_DYNAMICS: INVERSE_DERIVATIVES,
    FORWARD_DYNAMICS: FORWARD_DERIVATIVES,
}


# Redundant loops of hinges, balls that spin, coordinates besides the motors with a floating base,
# and more motors than freedoms.
@pytest.mark.parametrize("name", ["agile_eye", "gough_stewart", "biped", "planar_4rrr"])
def test_python_and_the_compiler_answer_with_the_same_bits(name: str) -> None:
    """Of every question, in poses near and far, some of which are refused; memory included."""
    robot = psp3.load(name)
    core, rng = robot.core, np.random.default_rng(0)
    compile_answers(core.tree, core.numbers)
    tables = core.tables()
    free_fall, nq, nv = np.array([0.1, 0.0, -9.81]), robot.model.nq, robot.model.nv
    n = robot.coordinates_v.size
    widths = {
        CONFIGURATION: nq,
        COMPLEMENT: nq + n * nv,
        INVERSE_DYNAMICS: n,
        FORWARD_DYNAMICS: n,
        EQUATION_OF_MOTION: 2 * n * n + n,
        ENERGIES: 2,
        MOTION: nq + 2 * nv,
        FRAME: 12 + 6 * n,
    }
    frame = np.concatenate([[1.0], np.eye(3).ravel(), rng.normal(size=3)])
    for far in (0.05, 3.0):
        positions = robot.reference + far * rng.uniform(-1.0, 1.0, robot.reference.size)
        speeds, third = rng.normal(size=(2, n))
        for question, width in widths.items():
            given = positions, speeds, frame if question == FRAME else third
            kept = []
            for ask, differentiate in (
                (answer, derivatives),
                (twin_of(answer), twin_of(derivatives)),
            ):
                memory, out, more = np.zeros(core.size), np.zeros(width), np.zeros(3 * n * n)
                row = ask(
                    *(question, 1, 0, 0, tables.tree, tables.numbers.copy(), free_fall),
                    *(tables.memory, memory, *given, out),
                )
                if row == -1 and question in BEFORE_DERIVATIVES:
                    ahead = BEFORE_DERIVATIVES[question]
                    differentiate(ahead, tables.tree, tables.numbers, memory, more)
                kept.append([row, *map(bits, (out, more, memory))])
            assert kept[0] == kept[1], f"question {question}, {far} from the reference"


def test_what_is_asked_first_is_what_the_compiled_answers_are() -> None:
    core = psp3.load("five_bar").core
    memories = []
    for ask in (first_answer, answer, twin_of(answer)):
        memory = np.zeros(core.size)
        tables, none = core.tables(), np.empty(0)
        # Newton's method from a guess that is a little off.
        at = int(tables.tree[AT_CONFIGURATION])
        memory[at : at + core.coordinates] = core.q0 + 1e-3
        numbers = tables.numbers.copy()
        outcome = ask(
            *(ASSEMBLY, 1, 1, 0, tables.tree, numbers, none, none, memory, none, none, none, none)
        )
        assert outcome == CLOSED
        memories.append(bits(memory))
    assert memories[0] == memories[1] == memories[2]
