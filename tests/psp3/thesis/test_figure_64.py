"""Type-2 against type-1 on results that are made up: words follow numbers."""

from __future__ import annotations

import math

import pytest

from psp3.thesis import beyond, figure_64
from psp3.thesis.findings import Reproduction
from psp3.thesis.plan import NOISY, Outcomes
from tests.psp3.thesis.outcomes import PLAN, rows


def test_type_2_that_halves_the_error_is_said_to() -> None:
    outcome = Reproduction()
    figure_64.type_2_against_type_1(Outcomes(rows(it2=0.5)), PLAN, outcome)
    (table,) = outcome.tables
    assert [row[0] for row in table.rows] == ["strongest sample"] * 3 + [
        "table look-up of Wang and Mendel"
    ] * 3
    assert all(row[4].startswith("0.500") for row in table.rows)
    assert all(row[5] == "0.500 to 0.500" for row in table.rows)
    assert all(row[6].startswith("0.500") for row in table.rows)
    for estimand in figure_64.ESTIMANDS:
        assert table.note.count(f" % ({estimand})") == 1
    assert all(row[7:9] == ["0 of 6, 0 %", "0 of 6"] for row in table.rows)
    assert all(row[-1].startswith("type-2 better") for row in table.rows)
    assert "holds" in outcome.answer[0]
    assert outcome.answer[0].count("0.50, 0.50 and 0.50") == 2
    at_20 = outcome.numbers["type_2_against_type_1"]["20"]
    assert at_20["difference"]["high"] < 0.0
    assert at_20["inverse"]["value"] == pytest.approx(2.0, rel=1e-12)
    assert at_20["ratio_of_geometric_means"]["value"] == pytest.approx(0.5, rel=1e-12)


def test_type_2_that_loses_is_said_to() -> None:
    outcome = Reproduction()
    figure_64.type_2_against_type_1(Outcomes(rows(it2=1.5)), PLAN, outcome)
    assert all(row[-1].startswith("type-1 better") for row in outcome.tables[0].rows)
    assert "not shown" in outcome.answer[0]
    beyond.learners(Outcomes(rows(it2=1.5)), PLAN, outcome)
    assert "not always better" in outcome.answer[1]
    assert "Where type-2 does not beat type-1" in outcome.tables[1].note


def test_wins_and_spread_are_those_of_single_runs() -> None:
    """Type-1 wins in two of six seeds, whose ratios are 2 and 3, those of the others are 0.5."""
    made_up = rows(it2=0.5)
    for row in made_up:
        if row["controller"] == "it2" and row["seed"] in (1, 4) and row["snr_db"] == 15.0:
            row["sum_of_squared_errors"] *= 4.0 if row["seed"] == 1 else 6.0
    outcome = Reproduction()
    figure_64.type_2_against_type_1(Outcomes(made_up), PLAN, outcome)
    entry = outcome.numbers["type_2_against_type_1"]["15"]
    assert (entry["type_1_wins"], entry["seeds_compared"]) == (2, 6)
    # The ends lie an eighth of a step from the ordered ratios' own ends: 2.5 % of 5 steps.
    assert entry["spread_of_ratios"] == pytest.approx((0.5, 3.0 - 0.125 * (3.0 - 2.0)))
    row = outcome.tables[0].rows[1]
    assert row[7] == "2 of 6, 33 %"
    assert row[-1].endswith("printed outside of the spread of single runs")
    assert "type-1 wins in 0 %, 33 % and 0 % of the seeds" in outcome.answer[0]


def test_ratios_of_the_figure_are_inverse_to_those_of_the_table() -> None:
    series = figure_64.ratios_of_figure_64(Outcomes(rows(it2=0.25)), PLAN)
    for points in series.values():
        assert points[math.inf][0] == 1.0
        for snr in NOISY:
            assert points[snr][0] == pytest.approx(4.0, rel=1e-12)
