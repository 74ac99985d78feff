"""Statements do in C what they do in Python: branches, loops, and assignments."""

from __future__ import annotations

import itertools
import re

import numpy as np
import pytest

from fuzzy2.errors import NotExportable
from tests.fuzzy2.export.in_c import kernel_in_c, needs_gcc, same_as_python

COUNTS = list(itertools.product(range(-2, 6), range(-2, 4)))

pytestmark = needs_gcc


def exchanged(x, out):
    a, b, c = x[0], x[1], 3.0
    a, b, c = b, c, a
    out[0], out[1], out[2] = a, b, c
    out[0], out[1] = out[1], out[0]
    i = 0
    i, out[i + 3] = 1, 7.0
    out[i + 3] += a
    part = out[:2]
    out[0], out[2] = out[1], part[0]


def counted(x, out):
    n, m = int(x[0]), int(x[1])
    total = 0.0
    for i in range(n):
        total += i
        n = 2
    out[0], out[1] = total, n
    for i in range(m, n + 3):
        total -= 0.5 * i
    for i in range(n, m, -2):
        total += 10.0 * i
    for i in range(m, n, 3):
        total *= 1.0 + i
    for _ in range(2):
        total += 1.0
    out[2] = total


def left_early(x, out):
    n = int(x[0])
    last = -1
    for i in range(10):
        if i == n:
            break
        if i % 2 == 1:
            continue
        last = i
        out[0] += i
    out[1], out[2] = i, last
    k = 0
    while True:
        k += 1
        if k > n:
            break
    out[3] = k
    while k > 0 and out[4] < 5.0:
        out[4] += k
        k -= 2


def counter_that_changes(x, out):
    for i in range(4):
        i = 2 * i
        out[0] += i
    out[1] = i


def branches(x, out):
    a = 1.0
    if x[0] < 0.0:
        a = 2.0
    elif x[0] == 0.0:
        a = 3.0
    elif x[1] > 0.0:
        a = 4.0
        if x[1] > 2.0:
            a = 5.0
    else:
        b = 6
        a = b
    out[0] = a
    if x[1] < 0.0:
        out[1] = 1.0
        return
    out[1] = 2.0


def turns_real(x, out):
    total = 0
    for i in range(3):
        total = total + x[i % 2]
    sign = 1 if x[0] > 0.0 else -1.5
    out[0], out[1] = total, sign


def parameter_of(n, x):
    if x[0] > 0.0:
        n = 3
    for i in range(2):
        n = n + i
    return n


def changed_parameter(x, out):
    out[0] = parameter_of(5, x)


def in_a_chain(x, out):
    a = b = x[0] + 1.0
    a += 1.0
    out[0], out[1] = a, b
    out[2] = out[3] = a * b


def _both(a, b):
    return a + b, a * b


def several_results(x, out):
    out[0], out[1] = _both(x[0], x[1])
    total, _ = _both(x[1], 2.0)
    out[2] = total


def test_all_values_are_found_before_one_is_written(tmp_path):
    same_as_python(exchanged, [(1.5, -2.0), (0.0, 4.0)], 5, tmp_path)


def test_loops_keep_the_bounds_that_they_began_with(tmp_path):
    same_as_python(counted, COUNTS, 3, tmp_path)


def test_loops_that_are_left_early(tmp_path):
    code = same_as_python(left_early, [(n, 0) for n in range(-1, 11)], 5, tmp_path)
    assert "while (1)" in code.source


def test_a_counter_that_is_changed_counts_on(tmp_path):
    same_as_python(counter_that_changes, [(0, 0)], 2, tmp_path)


def test_branches(tmp_path):
    rows = list(itertools.product((-1.0, 0.0, 1.0, np.nan), (-1.0, 1.0, 3.0, np.nan)))
    code = same_as_python(branches, rows, 2, tmp_path)
    assert "} else if (x.p[0] == 0.0) {" in code.source
    assert not re.search(r"else \{\n\s*if", code.source)


def test_a_variable_that_is_whole_only_at_first_is_real(tmp_path):
    same_as_python(turns_real, [(1.25, -0.5), (-1.0, 2.0)], 2, tmp_path)


def test_a_known_parameter_that_is_changed(tmp_path):
    same_as_python(changed_parameter, [(1.0,), (-1.0,)], 1, tmp_path)


def test_chains_of_assignments(tmp_path):
    same_as_python(in_a_chain, [(0.5,)], 4, tmp_path)


def test_several_results(tmp_path):
    same_as_python(several_results, [(0.5, 3.0)], 3, tmp_path)


def summed(x, out):
    for i in range(3):
        out[0] += (i + 1) * x[i]


def found(x, out):
    for i in range(3):
        if x[i] > 0.0:
            out[0] = i
            break


@pytest.mark.parametrize(("kernel", "written_out"), [(summed, True), (found, False)])
def test_a_loop_is_written_out_unless_it_is_left_early(kernel, written_out, tmp_path):
    rows = [(0.0, 1.0, 2.0), (-1.0, -1.0, -1.0), (1.0, 2.0, 3.0)]
    code = same_as_python(kernel, rows, 1, tmp_path, unrolled=("summed", "found"))
    assert ("for (" not in code.source) == written_out


def itself(x, out):
    out[0] = itself_again(x)


def itself_again(x):
    return itself_again(x)


def over_a_list(x, out):
    for value in x:
        out[0] += value


def with_else(x, out):
    while x[0] > 0.0:
        out[0] = 1.0
    else:
        out[0] = 2.0


def into_its_input(x, out):
    x[0] = 1.0


def with_a_word_of_c(x, out):
    short = x[0]
    out[0] = short


def with_a_step_of_its_own(x, out):
    for i in range(0, 9, int(x[0])):
        out[0] = i


REFUSED = {
    itself: "it calls itself",
    over_a_list: "must count over range",
    with_else: "cannot have an else",
    into_its_input: "read-only",
    with_a_word_of_c: "short is a word of C",
    with_a_step_of_its_own: "the step must be known",
}


@pytest.mark.parametrize("kernel", REFUSED, ids=lambda kernel: kernel.__name__)
def test_what_is_refused(kernel, tmp_path):
    with pytest.raises(NotExportable, match=REFUSED[kernel]):
        kernel_in_c(kernel, 2, 1, tmp_path)


FACTOR = 2.0


def scaled(x, out):
    out[0] = FACTOR * x[0]


def test_names_mean_what_they_mean_when_code_is_written(tmp_path, monkeypatch):
    """The syntax of a kernel is remembered, but not what its names mean."""
    assert "2.0 * " in kernel_in_c(scaled, 1, 1, tmp_path / "before")[1].source
    monkeypatch.setitem(globals(), "FACTOR", 3.0)
    assert "3.0 * " in kernel_in_c(scaled, 1, 1, tmp_path / "after")[1].source
