"""Results as columns: the same numbers as in the rows they were made of."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from psp3.errors import InvalidValue, UnknownName
from psp3.study.run import METRICS, Run, contents
from psp3.study.table import Table

RUNS = [
    Run(controller, snr_db=snr, seed=seed, mean_variation=variation)
    for controller in ("it2", "ctc")
    for snr in (20.0, 9.0)
    for variation in (0.2, None)
    for seed in (10, 2)
]
ROWS: list[dict[str, Any]] = [
    {**contents(run), **{name: number + 0.01 * k for k, name in enumerate(METRICS)}}
    for number, run in enumerate(RUNS)
]


def test_rows_are_what_the_table_was_made_of() -> None:
    table = Table.of(ROWS)
    assert list(table) == ROWS
    assert (table[-1], len(table), Table.of(table)) == (ROWS[-1], len(ROWS), table)
    assert list(table[2:9:3]) == ROWS[2:9:3]
    assert table.run(3) == RUNS[3]
    with pytest.raises(IndexError):
        table[len(ROWS)]


def test_columns_are_those_of_the_rows() -> None:
    table = Table.of(ROWS)
    for name in ROWS[0]:
        assert table.column(name).tolist() == [row[name] for row in ROWS]
    with pytest.raises(UnknownName, match="unknown column 'speed'; known are controller"):
        table.column("speed")


def test_order_is_that_of_the_fields_as_numbers_with_none_first() -> None:
    """Not that of texts, in which 10 comes before 2; the seed decides last."""
    found = list(map(Table.of(ROWS[::-1]).in_order().run, range(len(ROWS))))
    expected = sorted(
        RUNS,
        key=lambda run: (
            run.controller,
            run.snr_db,
            run.mean_variation is not None,
            run.mean_variation or 0.0,
            run.seed,
        ),
    )
    assert found == expected
    assert len(Table.of([]).in_order()) == 0


def test_selection_is_that_of_the_rows() -> None:
    table = Table.of(ROWS)
    assert list(table.select(controller="it2", seed=[2, 3])) == [
        row for row in ROWS if row["controller"] == "it2" and row["seed"] == 2
    ]
    assert list(table.select(mean_variation=None)) == [
        row for row in ROWS if row["mean_variation"] is None
    ]
    of_numpy: Any = np.int64(2)
    assert list(table.select(seed=of_numpy)) == list(table.select(seed=2)) != []
    assert list(table.select(seed=10**6)) == []
    with pytest.raises(InvalidValue, match="seed must be an integer, got 'two'"):
        table.select(seed="two")
    with pytest.raises(UnknownName, match="unknown field of a run 'rms_error'"):
        table.select(rms_error=1.0)


def test_groups_are_the_settings_in_the_order_of_the_rows() -> None:
    groups = Table.of(ROWS).groups()
    assert [places.tolist() for _, places in groups] == [[k, k + 1] for k in range(0, len(ROWS), 2)]
    assert all(setting.seed == 0 for setting, _ in groups)
    assert Table.of([]).groups() == []
    assert len(Table.of(ROWS).select(controller="ctc").groups()) == 4


def test_what_diverged_has_no_values_but_that_it_did() -> None:
    rows = [{**ROWS[0], "diverged": float(k == 1)} for k in range(3)]
    table = Table.of(rows)
    effort = table.values("effort")
    assert np.isnan(effort[1])
    assert np.isfinite(effort[[0, 2]]).all()
    assert table.values("diverged").tolist() == [0.0, 1.0, 0.0]
    assert not math.isnan(table[1]["effort"])
