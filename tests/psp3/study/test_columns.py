"""Runs as columns: the same runs one by one."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from psp3.study import columns, grid
from psp3.study.columns import RunColumns, blocks_of
from psp3.study.run import Run

RUNS = [Run("ctc", seed=k // 2, kp=100.0 if k % 2 else None) for k in range(6)]

runs_of_some_fields = st.lists(
    st.builds(
        Run,
        controller=st.sampled_from(["ctc", "it2"]),
        kp=st.sampled_from([None, 0.0, 2.0]),
        seed=st.integers(0, 3),
    )
)


@given(runs_of_some_fields, st.data())
def test_runs_are_those_that_were_given(runs: list[Run], data: Any) -> None:
    found = RunColumns.of(runs)
    assert (len(found), list(found)) == (len(runs), runs)
    assert [found[k] for k in range(-len(runs), len(runs))] == [*runs, *runs]
    assert list(found.column("kp")) == [run.kp for run in runs]
    assert found.differing == tuple(
        name
        for name in ("controller", "seed", "kp")
        if len({getattr(run, name) for run in runs}) > 1
    )
    if runs:
        places = data.draw(st.lists(st.integers(0, len(runs) - 1), min_size=1))
        assert list(found.taken(places)) == [runs[k] for k in places]


@given(st.lists(runs_of_some_fields.filter(bool)))
def test_joined_runs_are_those_of_the_parts(parts: list[list[Run]]) -> None:
    joined = RunColumns.joined([RunColumns.of(part) for part in parts])
    assert list(joined) == [run for part in parts for run in part]


def test_slices_changes_and_what_is_no_place() -> None:
    found = RunColumns.of(RUNS)
    assert RunColumns.of(found) is found
    assert list(found[1:6:2]) == RUNS[1:6:2]
    changed = found.changed({"kp": (5.0,), "seed": range(6)})
    assert [(run.kp, run.seed) for run in changed] == [(5.0, k) for k in range(6)]
    assert list(found) == RUNS
    with pytest.raises(IndexError):
        found[6]


def test_equal_numbers_of_two_types_are_two_values() -> None:
    """As a check tells True from 1."""
    values = [run.levels for run in RunColumns.of([Run(levels=1), Run(levels=True)])]
    assert list(map(type, values)) == [int, bool]


@pytest.mark.parametrize("at_a_time", [1, 4, 100])
def test_blocks_are_all_runs_in_order(at_a_time: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(columns, "AT_A_TIME", at_a_time)
    blocks = list(blocks_of(iter(RUNS)))
    assert [run for block in blocks for run in block] == RUNS
    assert max(map(len, blocks)) <= at_a_time
    assert list(blocks_of([])) == []
    assert [list(block) for block in grid().blocks()] == [[Run()]]
