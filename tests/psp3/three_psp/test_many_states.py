"""Many states at a time: the answers of the closed form's own kernels, to the last bit.

Each operation of a vector instruction rounds as the scalar one does, and without leave to
reassociate or to contract the compiler keeps their order, so that no tolerance is needed.
"""

from __future__ import annotations

import os
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

import psp3
from fuzzy2.support import parallel_rows
from fuzzy2.support.compile_unit import Kernel
from psp3.errors import InvalidArray, InvalidValue, UnreachablePose, UnreachableTip
from psp3.three_psp import closed_form, many_states
from psp3.three_psp.parameters import named_parameters
from tests.helpers import Array, random_heights, random_states

P = psp3.Parameters().as_array()
# Name, number of arguments before the parameters, numbers a row.
IN_COLUMNS = [("equation_of_motion", 2, 21), ("inverse_dynamics", 3, 3), ("forward_dynamics", 3, 3)]
KERNELS = [
    *IN_COLUMNS,
    ("forward_kinematics", 1, 18),
    ("configuration", 1, 15),
    ("tip_jacobian", 1, 9),
    ("energies", 2, 2),
]
BAD = [[0.0, -0.5, 0.5], [np.nan, 0.0, 0.0], [0.0, np.inf, 0.0]]


def arguments(rng: np.random.Generator, rows: int, count: int) -> list[Array]:
    """Return heights, speeds and accelerations or forces, each (rows, 3)."""
    return [*random_states(rng, rows), rng.normal(scale=100.0, size=(rows, 3))][:count]


def flat(arrays: list[Array]) -> list[Array]:
    return [array.reshape(-1) for array in arrays]


@pytest.mark.parametrize(("name", "inputs", "width"), IN_COLUMNS)
@given(
    rows=st.integers(0, 300),
    seed=st.integers(0, 1000),
    parameters=st.sampled_from(["default", "table_3_1", "table_5_1"]),
    bad=st.lists(
        st.tuples(st.integers(0, 299), st.sampled_from(BAD), st.integers(0, 2)), max_size=3
    ),
)
def test_kernels_answer_as_those_of_the_closed_form(
    name: str,
    inputs: int,
    width: int,
    rows: int,
    seed: int,
    parameters: str,
    bad: list[tuple[int, list[float], int]],
) -> None:
    """Up to two blocks and a part of one; any row of any argument may be a bad one.

    The same row is refused, and those before it are written.
    """
    p = named_parameters(parameters).as_array()
    given_arrays = arguments(np.random.default_rng(seed), rows, inputs)
    for row, values, argument in bad:
        if row < rows:
            given_arrays[argument % inputs][row] = values
    found, expected = np.full((rows, width), -7.0), np.full((rows, width), -7.0)
    refused = getattr(many_states, name)(*flat(given_arrays), p, found.reshape(-1))
    assert refused == getattr(closed_form, name)(*flat(given_arrays), p, expected.reshape(-1))
    assert_array_equal(found, expected)


@pytest.mark.parametrize(("name", "inputs", "width"), KERNELS)
@pytest.mark.parametrize("rows", [0, 1, 7, 8, 9, 20_001])
def test_batches_on_several_threads_are_rows_one_by_one(
    name: str, inputs: int, width: int, rows: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {0, 1, 2})
    given_arrays = arguments(np.random.default_rng(rows), rows, inputs)
    found, expected = np.empty((rows, width)), np.empty((rows, width))
    assert many_states.first_refused_row(name, given_arrays, P, found) == -1
    assert getattr(closed_form, name)(*flat(given_arrays), P, expected.reshape(-1)) == -1
    assert_array_equal(found, expected)


@pytest.mark.parametrize("method", ["inverse_dynamics", "forward_dynamics", "equation_of_motion"])
@pytest.mark.parametrize("cores", [1, 3])
def test_errors_name_the_first_refused_row_of_many(
    method: str, cores: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Bad rows in several parts and blocks; each is repaired after it has been named."""
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: set(range(cores)))
    robot, rng = psp3.load("psp3"), np.random.default_rng(0)
    states = arguments(rng, 30_000, 2 if method == "equation_of_motion" else 3)
    rows = [129, 5000, 5001, 14_000, 29_999]
    for row in rows:
        states[0][row] = [0.0, -0.5, 0.5 + 1e-6 * row]
    for row in rows:
        with pytest.raises(UnreachablePose) as caught:
            getattr(robot, method)(*states)
        assert_array_equal(caught.value.heights, states[0][row])
        states[0][row] = 0.1
    states[1][20_000, 1] = np.nan
    with pytest.raises(InvalidArray, match="speeds"):
        getattr(robot, method)(*states)
    states[1][20_000, 1] = 1e200
    with pytest.raises(InvalidValue, match="small enough") as too_large:
        robot.forward_dynamics(states[0], states[1], np.zeros((30_000, 3)))
    assert "1e+200" in str(too_large.value)


def test_batches_of_the_robot_are_its_single_calls() -> None:
    """All that takes rows, at a shape with two leading dimensions."""
    robot, rng = psp3.load("psp3"), np.random.default_rng(1)
    h, v, a = (x.reshape(5, 4, 3) for x in arguments(rng, 20, 3))
    tips = rng.uniform(-0.01, 0.01, (5, 4, 3))

    def rows(*arrays: Array) -> zip[tuple[Array, ...]]:
        return zip(*(x.reshape(-1, 3) for x in arrays), strict=True)

    for name, given_arrays in {
        "inverse_dynamics": (h, v, a),
        "forward_dynamics": (h, v, a),
        "configuration": (h,),
        "tip": (h,),
        "tip_jacobian": (h,),
        "inverse_kinematics_tip": (tips,),
        "kinetic_energy": (h, v),
        "potential_energy": (h,),
    }.items():
        of_one = getattr(robot, name)
        found = of_one(*given_arrays)
        expected = np.array([of_one(*row) for row in rows(*given_arrays)])
        assert_array_equal(found, expected.reshape(found.shape), err_msg=name)
    for name, given_arrays in {"equation_of_motion": (h, v), "rates_of_tip": (h, v, a)}.items():
        of_one = getattr(robot, name)
        found = of_one(*given_arrays)
        expected = zip(*(of_one(*row) for row in rows(*given_arrays)), strict=True)
        for one, other in zip(found, expected, strict=True):
            assert_array_equal(one, np.reshape(other, one.shape), err_msg=name)


def test_a_tip_out_of_reach_is_the_first_one_of_many() -> None:
    robot = psp3.load("psp3")
    tips = np.zeros((1000, 3))
    tips[700, 0], tips[400, 1] = 0.03, 0.04
    with pytest.raises(UnreachableTip) as caught:
        robot.inverse_kinematics_tip(tips)
    assert_array_equal(caught.value.tip, tips[400])


def test_short_batches_go_to_the_kernels_of_the_closed_form(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """One row less than a vector of AVX-512 has places, and long ones to the parts."""
    seen = []
    monkeypatch.setattr(
        parallel_rows, "first_refused_row", lambda part, rows, grain: seen.append(rows) or -1
    )
    heights = random_heights(np.random.default_rng(0), 8)
    for rows in (7, 8):
        many_states.first_refused_row("energies", [heights[:rows]] * 2, P, np.empty((rows, 2)))
    assert seen == [8]


@pytest.mark.slow
def test_the_loop_over_states_is_made_of_vector_instructions() -> None:
    """Divisions tell: the equation has six, each of two states or more at a time.

    The compiler leaves single ones for the rows that fill no vector.
    """
    options = {"nopython": True, "error_model": "numpy"}
    # As ``compiled`` does, but never from the disk, where no code is that can be read.
    kernel = Kernel(many_states._write_columns.py_func, targetoptions=options, twice=True)
    rest = np.zeros(3)
    kernel(rest, rest, 0, 1, P, np.empty(many_states.COLUMNS))
    (code,) = kernel.inspect_llvm().values()
    of_vectors = re.findall(r"fdiv <\d+ x double>", code)
    assert len(of_vectors) >= 6
