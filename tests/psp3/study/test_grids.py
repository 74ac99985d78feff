"""Grids: that they are sequences, and take no memory."""

from __future__ import annotations

import itertools

import pytest

from psp3.study import Grid, grid
from psp3.study.run import Run


def test_a_grid_is_a_sequence_of_runs() -> None:
    found = grid(controller=("t1", "it2"), snr_db=(20.0, 10.0, 5.0), seed=range(4))
    runs = [
        Run(controller, snr_db=snr, seed=seed)
        for seed, controller, snr in itertools.product(range(4), ("t1", "it2"), (20.0, 10.0, 5.0))
    ]
    assert isinstance(found, Grid)
    assert len(found) == 24
    assert list(found) == runs
    assert [found[k] for k in range(-24, 24)] == runs + runs
    assert found[3:20:5] == tuple(runs[3:20:5])
    assert found == runs
    assert found == tuple(runs)
    assert found != runs[:-1]
    assert found != "runs"
    assert found + grid(controller="pd") == (*runs, Run("pd"))
    for place in (24, -25):
        with pytest.raises(IndexError):
            found[place]


def test_a_grid_of_any_size_is_made_at_once() -> None:
    found = grid(seed=range(100_000), snr_db=range(1000))
    assert len(found) == 100_000_000
    assert found[99_999_999] == Run(seed=99_999, snr_db=999.0)
